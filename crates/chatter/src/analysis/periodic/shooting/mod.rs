//! The equations of a periodic orbit: nodes after chosen events, and the times between them.
//!
//! For each leg from node x_k, of duration tau_k, to the surface g_k with the map R_k there (docs/periodic.md)
//!
//! ```text
//! g_k(phi_tau_k(x_k)) = 0,        x_(k+1) - R_k(phi_tau_k(x_k)) = 0,        x_N = x_0 + turns
//! ```
//!
//! Each is regular where an event grazes. A stretch through complete chatter is followed as it is, and its time eliminated.
//!
//! ```text
//! workshop    a model with its compiled legs, and the user's functions
//! equations   residual and Jacobian
//! monodromy   the derivative of one period, and its eigenvalues
//! along       what there is to see on the way of an orbit
//! corner      corners that an event asks for: how far it is from them
//! collisions  whether those of one instant could come in another order
//! exchange    events that change places with the knot of a table
//! at_jumps    corners that share the instant of an impact or a reset
//! rest        what rests at the end of a stretch
//! around      orbits on which nothing happens, told from a plane across the flow
//! ```

mod along;
mod around;
mod at_jumps;
mod collisions;
mod corner;
mod equations;
mod exchange;
mod monodromy;
mod rest;
mod workshop;

pub(crate) use collisions::lies_on;
pub(crate) use corner::BeyondCorner;
pub(in crate::analysis::periodic) use corner::mode_there;
pub(crate) use exchange::{Exchanged, station_after};
pub(in crate::analysis::periodic) use workshop::AT_ENDS;
pub(crate) use workshop::Workshop;

use super::closure::{Closure, Lap, Turn};
use super::cycle::itinerary::{Passage, Step, around, held, keep_idle_sides};
use super::error::PeriodicError;
use crate::analysis::continuation::Left;
use crate::flow::leg::{Astray, Flyer, Follower, Jump, Landing, Least, Leg, LegKind, Stretch};
use crate::flow::{Closed, GuardKind, Settings};
use crate::model::Model;
use crate::numerics::{DoubleDouble, Real};
use std::sync::Arc;

/// A state that is this part of the largest everywhere is zero, as what is left of one in thirty digits.
const NOTHING: f64 = 1e-30;

/// Sizes of states, where nothing is known of one that of the largest.
pub(crate) fn without_zeros(mut sizes: Vec<f64>) -> Vec<f64> {
    let largest = sizes.iter().fold(0.0_f64, |most, x| most.max(*x));
    let usual = if largest > 0.0 { largest } else { 1.0 };
    for size in (sizes.iter_mut()).filter(|size| **size <= NOTHING * largest) {
        *size = usual;
    }
    sizes
}

/// Sizes of states, each no less than how far it moves from states in a time each: a position is zero at all its impacts, yet has a size.
pub(crate) fn take_in_moves<'s>(
    sizes: &mut [f64],
    (model, parameters): (&Model, &[f64]),
    ways: impl IntoIterator<Item = (&'s [f64], f64)>,
) {
    let rates = model.field();
    let parts = model.graph.reachable(&rates);
    for (state, time) in ways {
        let rates = (model.graph).evaluate_parts(&parts, &rates, (state, parameters));
        for (size, rate) in sizes.iter_mut().zip(rates) {
            let moves = (rate * time).abs();
            if moves.is_finite() {
                *size = size.max(moves);
            }
        }
    }
}

/// How the parts of an orbit are computed.
#[derive(Clone, Debug)]
enum Flown<R: Real> {
    Leg(Arc<Leg>, usize),
    Stretch(Arc<Stretch>, Box<Follower<R>>),
}

/// The equations of one itinerary.
#[derive(Clone, Debug)]
pub(crate) struct Shooting<R: Real> {
    pub workshop: Arc<Workshop>,
    pub steps: Vec<Step>,
    /// Whole turns of each phase in a period.
    pub counts: Vec<i64>,
    flown: Vec<Flown<R>>,
    flyers: Vec<(LegKind, Flyer<R>)>,
    /// Where each node begins among the unknowns.
    places: Vec<usize>,
    pub(super) scales: Vec<f64>,
    /// Where states that nothing depends on are held.
    pub(super) pins: Vec<R>,
    /// The latest point looked at, and how its legs ended.
    pub latest: Vec<Landing<R>>,
    /// Whether nothing happened to displacements at the events at their ends.
    smooth: Vec<bool>,
    watching: Option<Vec<R>>,
    /// The least values that were looked at last, and where.
    seen: Option<(Vec<R>, Vec<Vec<Least>>)>,
    /// Whether the event at the end of each step may change places with the one before.
    exchanges: Vec<bool>,
    /// The state that was told last: of several crossings of the section the nearest is told next.
    pub told: Option<Vec<f64>>,
    /// The node that the orbit is told from where no crossing of the section is; the first until one was told.
    pub(super) told_node: Option<usize>,
    /// Whether that, without a crossing, stands for one at its instant.
    pub(in crate::analysis::periodic) stands_for_section: bool,
    /// The corner whose function is watched.
    corner: Option<corner::Watched<R>>,
    /// The normal of the plane that each step leads around to, empty for others; none before these are needed.
    pub(super) planes: Vec<Vec<R>>,
}

/// Sizes of states that fall below this part of what they were.
const NEXT_TO_NOTHING: f64 = 1e-6;
/// States are measured anew where they have become so many times as large: more than those that drift are ever displaced.
const OUTGROWN: f64 = 16.0;
/// A state is zero at nodes alone if all that is seen of it there is less than this part of how far others may move it.
const AT_NODES_ALONE: f64 = 1e-9;
/// Impacts that are to share an instant are no farther apart than this part of the period.
const NEARLY_TOGETHER: f64 = 1e-3;
/// Fields on both sides of a surface are one there if they differ by less than this part of them, or of what moves states in a period.
const SAME_FIELD: f64 = 1e-9;
/// Why equations are left where chatter that is followed as a whole does not come to its end.
pub(in crate::analysis::periodic) const INCOMPLETE: &str = "chatter is not complete";
/// A leg that would take this many times as long as its guess is given up.
pub(in crate::analysis::periodic) const LONGEST: f64 = 4.0;

impl<R: Real> Shooting<R> {
    pub(crate) fn new(
        workshop: &Arc<Workshop>,
        mut steps: Vec<Step>,
        counts: Vec<i64>,
    ) -> Result<Self, PeriodicError> {
        let settings = Settings::default();
        keep_idle_sides(&workshop.system, &mut steps);
        let unfollowed = || PeriodicError::Unfollowed {
            what: "a mode that holds no motion".to_owned(),
        };
        if steps.is_empty() {
            return Err(PeriodicError::Unfollowed {
                what: "an orbit of no legs".to_owned(),
            });
        }
        let mut flown = Vec::with_capacity(steps.len());
        let mut flyers: Vec<(LegKind, Flyer<R>)> = Vec::new();
        let mut places = Vec::with_capacity(steps.len());
        let n = workshop.model.states.len();
        let mut unknowns = 0;
        for step in &steps {
            places.push(unknowns);
            unknowns += n;
            match step.passage {
                Passage::Leg(kind)
                | Passage::Timed(kind)
                | Passage::Around(kind)
                | Passage::AtOnce(kind)
                | Passage::Together(kind) => {
                    // Where a vector is zero is no surface that a leg ends across.
                    if let Some(GuardKind::Switch(surface) | GuardKind::Leave(surface, _)) =
                        kind.ends_at
                        && workshop.system.corners().is_disc(surface)
                    {
                        let what = "a rest that friction in the plane brings about".to_owned();
                        return Err(PeriodicError::Unfollowed { what });
                    }
                    let leg = workshop.leg(kind).ok_or_else(unfollowed)?;
                    let place = flyers.iter().position(|(of, _)| *of == kind);
                    let place = place.unwrap_or_else(|| {
                        flyers.push((kind, leg.flyer(&settings)));
                        flyers.len() - 1
                    });
                    unknowns += usize::from(step.has_own_time());
                    flown.push(Flown::Leg(leg, place));
                }
                Passage::Stretch(kind) => {
                    let stretch = workshop.stretch(kind).ok_or_else(unfollowed)?;
                    let follower = stretch.follower(&settings);
                    flown.push(Flown::Stretch(stretch, Box::new(follower)));
                }
            }
        }
        let mut shooting = Self {
            workshop: workshop.clone(),
            steps,
            counts,
            flown,
            flyers,
            places,
            scales: Vec::new(),
            pins: Vec::new(),
            latest: Vec::new(),
            smooth: Vec::new(),
            watching: None,
            seen: None,
            exchanges: Vec::new(),
            told: None,
            told_node: None,
            stands_for_section: false,
            corner: None,
            planes: Vec::new(),
        };
        let exchanges = (0..shooting.steps.len()).map(|index| shooting.may_exchange(index));
        shooting.exchanges = exchanges.collect();
        shooting.rescale();
        Ok(shooting)
    }

    /// Whether the latest evaluation was at a point, or no farther from it than such a part of the sizes.
    pub(crate) fn was_evaluated_at(&self, at: &[R], near: f64) -> bool {
        let Some(latest) = (self.watching.as_ref()).filter(|latest| latest.len() == at.len())
        else {
            return false;
        };
        let mut parts = latest.iter().zip(at).zip(&self.scales);
        parts.all(|((&was, &is), scale)| was == is || (was - is).abs().to_f64() <= near * scale)
    }

    /// Sizes from the nodes as they are known.
    fn rescale(&mut self) {
        let n = self.workshop.model.states.len();
        let mut sizes = vec![0.0_f64; n];
        let model = &self.workshop.model;
        let parameters = self.workshop.parameters::<f64>(&[]);
        for step in &self.steps {
            for (size, x) in sizes.iter_mut().zip(&step.start) {
                *size = size.max(x.abs());
            }
        }
        let ways = (self.steps.iter()).map(|step| (&*step.start, step.duration));
        take_in_moves(&mut sizes, (model, &parameters), ways);
        // Nor is one next to nothing that vanishes at all nodes together with its rate, but for rounding: others move it. (What is followed
        // as a whole shrinks to nothing where chatter begins.)
        let is_followed = !self.steps.iter().any(Step::is_stretch);
        for (index, state) in model.states.iter().enumerate().filter(|_| is_followed) {
            let of = [state.derivative];
            let parts = model.graph.reachable(&of);
            let rate = |at: &[f64]| {
                let known = (at, &*parameters);
                model.graph.evaluate_parts(&parts, &of, known)[0]
            };
            let moved = self.steps.iter().fold(0.0_f64, |most, step| {
                let beside: Vec<f64> = (step.start.iter().zip(&sizes))
                    .map(|(x, size)| x + size)
                    .collect();
                let moves = ((rate(&beside) - rate(&step.start)) * step.duration).abs();
                if moves.is_finite() {
                    most.max(moves)
                } else {
                    most
                }
            });
            if sizes[index] > 0.0 && sizes[index] < AT_NODES_ALONE * moved {
                sizes[index] = moved;
            }
        }
        // A phase that goes round no times is a state like others.
        let turns = self.workshop.closure.turns(&parameters).unwrap_or_default();
        for (turn, _) in turns
            .iter()
            .zip(&self.counts)
            .filter(|(_, count)| **count != 0)
        {
            sizes[turn.state] = turn.period;
        }
        let sizes = without_zeros(sizes);
        let period: f64 = self.steps.iter().map(|step| step.duration).sum();
        let mut scales = Vec::new();
        for step in &self.steps {
            scales.extend(&sizes);
            if step.has_own_time() {
                scales.push(period);
            }
        }
        scales.extend(&self.workshop.sizes);
        self.scales = scales;
        self.pins = (self.steps.first())
            .map(|step| step.start.iter().map(|&x| R::splat(x)).collect())
            .unwrap_or_default();
    }

    /// Keeps sizes that states had before, where no more than such a part is left of them.
    pub(crate) fn keep_sizes(&mut self, before: &[f64]) {
        self.keep_sizes_above(before, NEXT_TO_NOTHING);
    }

    /// Takes sizes of states as no less than they are elsewhere on the same curve, where it is displaced from an orbit at zero.
    pub(crate) fn take_sizes(&mut self, least: &[f64]) {
        self.keep_sizes_above(least, 1.0);
    }

    /// Takes what states have grown to along a branch for their sizes, where one has outgrown its own: else ever more steps would go as far, against
    /// what it is. Whether one has.
    pub(crate) fn grows_up(&mut self) -> bool {
        let mut sizes = self.state_sizes();
        let mut has_outgrown = false;
        for (state, size) in sizes.iter_mut().enumerate() {
            if !self.workshop.closure.is_phase(state) {
                let most = |most: f64, step: &Step| most.max(step.start[state].abs());
                let now = self.steps.iter().fold(0.0, most);
                has_outgrown |= now > OUTGROWN * *size;
                *size = size.max(now);
            }
        }
        if has_outgrown {
            self.take_sizes(&sizes);
        }
        has_outgrown
    }

    fn keep_sizes_above(&mut self, before: &[f64], part: f64) {
        for &place in &self.places {
            for (size, &before) in self.scales[place..].iter_mut().zip(before) {
                if *size < part * before {
                    *size = before;
                }
            }
        }
    }

    /// The size of each state.
    pub(crate) fn state_sizes(&self) -> Vec<f64> {
        self.scales[..self.workshop.model.states.len()].to_vec()
    }

    /// Adds the turns of a period to the phases of all nodes, and what the latest one took states along that nothing depends on.
    pub(crate) fn turn_on(&self, nodes: &mut [R], at: &[R]) {
        let parameters = self.workshop.parameters(self.free(at));
        let Ok(turns) = self.workshop.closure.turns(&parameters) else {
            return;
        };
        for (turn, &count) in turns.iter().zip(&self.counts) {
            for &place in &self.places {
                nodes[place + turn.state] += turn.period * R::splat(count as f64);
            }
        }
        let (Some(last), Some(seen)) = (self.latest.last(), &self.watching) else {
            return;
        };
        let (n, closure) = (last.image.len(), &self.workshop.closure);
        let idle = closure.idle.iter();
        for free in idle.filter(|free| !closure.is_phase(free.state)) {
            let drift = last.image[free.state] - self.node(seen, 0)[free.state];
            for &place in &self.places {
                free.carry(&mut nodes[place..place + n], drift);
            }
        }
    }

    /// The unknowns as first guessed, at these free parameters.
    pub(crate) fn guess(&self, free: &[f64]) -> Vec<R> {
        let mut at = Vec::with_capacity(self.scales.len());
        for step in &self.steps {
            at.extend(step.start.iter().map(|&x| R::splat(x)));
            if step.has_own_time() {
                at.push(R::splat(step.duration));
            }
        }
        at.extend(free.iter().map(|&p| R::splat(p)));
        at
    }

    /// Takes a solution as what later guesses and sizes start from.
    pub(crate) fn adopt(&mut self, at: &[R]) {
        self.steps = self.current_steps(at);
        if self.has_planes() {
            self.set_planes(at);
        }
    }

    /// Whether it is told from planes, which are others wherever it has come to: so is the direction of a curve there.
    pub(crate) fn has_planes(&self) -> bool {
        !self.planes.is_empty()
    }

    /// The steps with their nodes and times as they are at a point.
    pub(crate) fn current_steps(&self, at: &[R]) -> Vec<Step> {
        let current = |(index, step): (usize, &Step)| {
            let latest = || Some(self.latest.get(index)?.duration);
            let duration = (self.duration_place(index).map(|place| at[place])).or_else(latest);
            Step {
                start: self.node(at, index).iter().map(|x| x.to_f64()).collect(),
                duration: duration.map_or(step.duration, |duration| duration.to_f64()),
                ..step.clone()
            }
        };
        self.steps.iter().enumerate().map(current).collect()
    }

    /// Contacts that are closed when a step begins.
    pub(crate) fn closed_before(&self, index: usize) -> Closed {
        self.steps[self.before(index)].closed
    }

    /// The step before another one, around the cycle.
    pub(crate) fn before(&self, index: usize) -> usize {
        around(index, -1, self.steps.len())
    }

    /// The step that comes so many before another one.
    fn step_back(&self, from: usize, back: usize) -> (usize, &Step) {
        let place = around(from, -(back as isize), self.steps.len());
        (place, &self.steps[place])
    }

    /// The step after another one, around the cycle.
    pub(crate) fn after(&self, index: usize) -> usize {
        around(index, 1, self.steps.len())
    }

    /// Impacts a period; none where infinitely many.
    pub(crate) fn impacts(&self) -> Option<u64> {
        self.steps.iter().map(Step::impacts).sum()
    }

    /// The node that a step starts from.
    pub(crate) fn node<'a>(&self, at: &'a [R], index: usize) -> &'a [R] {
        let n = self.workshop.model.states.len();
        &at[self.places[index]..self.places[index] + n]
    }

    /// Places of that node among the unknowns.
    pub(crate) fn node_places(&self, index: usize) -> core::ops::Range<usize> {
        let place = self.places[index];
        place..place + self.workshop.model.states.len()
    }

    /// Place of the duration of a step among the unknowns.
    pub(crate) fn duration_place(&self, index: usize) -> Option<usize> {
        let n = self.workshop.model.states.len();
        (self.steps[index].has_own_time()).then(|| self.places[index] + n)
    }

    pub(crate) fn free<'a>(&self, at: &'a [R]) -> &'a [R] {
        &at[at.len() - self.workshop.free.len()..]
    }

    /// The model's parameters followed by those of a step's pieces.
    pub(in crate::analysis::periodic) fn parameters_of(
        &self,
        parameters: &[R],
        step: &Step,
    ) -> Vec<R> {
        self.workshop.system.with_pieces(parameters, &step.pieces)
    }

    /// How long a leg without an event lasts: its part of the time that the phases take for their turns.
    fn timed(&self, turns: &[Turn<R>]) -> Option<Lap<R>> {
        let timed = (self.steps.iter()).filter(|step| matches!(step.passage, Passage::Timed(_)));
        let legs = R::splat(timed.count().max(1) as f64);
        let Lap { time, slopes } = Closure::time_of(turns, &self.counts)?;
        Some(Lap {
            time: time / legs,
            slopes: slopes.into_iter().map(|slope| slope / legs).collect(),
        })
    }

    fn land(
        &mut self,
        at: &[R],
        turns: &[Turn<R>],
        parameters: &[R],
    ) -> Result<Vec<Landing<R>>, Left> {
        let n = self.workshop.model.states.len();
        let mut landings = Vec::with_capacity(self.steps.len());
        let timed = self.timed(turns);
        let goes_around = |step: &Step| matches!(step.passage, Passage::Around(_));
        if self.planes.is_empty() && self.steps.iter().any(goes_around) {
            self.set_planes(at);
        }
        for index in 0..self.steps.len() {
            let all = self.parameters_of(parameters, &self.steps[index]);
            let place = self.places[index];
            let x = &at[place..place + n];
            let step = &self.steps[index];
            let landing = match &mut self.flown[index] {
                Flown::Leg(leg, flyer) if step.is_at_once() => {
                    let flyer = &mut self.flyers[*flyer].1;
                    match step.passage {
                        Passage::Together(_) => {
                            let duration = at[place + n];
                            if duration.to_f64().abs() > NEARLY_TOGETHER * self.scales[place + n] {
                                return Err(Left::because(format_args!(
                                    "events {index} and {} no longer share their instant",
                                    index + 1
                                )));
                            }
                            (leg.fly_a_moment(flyer, &all, x, duration)).map_err(Left::because)?
                        }
                        _ => leg.at_once(flyer, &all, x),
                    }
                }
                Flown::Leg(leg, flyer) => {
                    let duration = match step.passage {
                        Passage::Leg(_) | Passage::Around(_) => at[place + n],
                        _ => timed.as_ref().map_or(R::ZERO, |lap| lap.time),
                    };
                    let flyer = &mut self.flyers[*flyer].1;
                    let apart = duration.to_f64().abs();
                    let passes = self.exchanges[index] && duration <= R::ZERO;
                    if passes && apart <= NEARLY_TOGETHER * self.scales[place + n] {
                        let landing = leg.fly_a_moment(flyer, &all, x, duration);
                        landings.push(landing.map_err(Left::because)?);
                        continue;
                    }
                    if duration <= R::ZERO || !duration.is_finite() {
                        return Err(Left::because(format_args!(
                            "the time between events {index} and {} vanishes",
                            index + 1
                        )));
                    }
                    let landing = leg.fly(flyer, &all, x, duration).map_err(Left::because)?;
                    match (step.passage, self.planes.get(index)) {
                        (Passage::Around(_), Some(normal)) => {
                            let turned = turns.iter().cloned().zip(self.counts.iter().copied());
                            around::onto(landing, (normal, step), turned)
                        }
                        _ => landing,
                    }
                }
                Flown::Stretch(stretch, follower) => {
                    let longest = R::splat(match step.ends_at() {
                        Some(_) => LONGEST * step.duration,
                        None => step.duration,
                    });
                    let after = self.steps[around(index, -1, self.steps.len())].ends_at();
                    let followed = stretch.follow(follower, &all, (x, after), longest);
                    followed.map_err(|astray| match astray {
                        Astray::Failed(error) => {
                            Left::because(error.named(&self.workshop.model))
                        }
                        Astray::Otherwise => Left::because(INCOMPLETE),
                        Astray::Crosses => Left::because(
                            "derivatives are not carried through complete chatter whose flights cross a surface",
                        ),
                    })?
                }
            };
            landings.push(landing);
        }
        Ok(landings)
    }

    /// Whether nothing happens to displacements at the end of each step: the state goes on as it is, and so does its field, as at the
    /// knot of a table or where a spring begins to push.
    fn smooth(&mut self, at: &[R], parameters: &[R], landings: &[Landing<R>]) -> Vec<bool> {
        let system = self.workshop.system.clone();
        let count = self.steps.len();
        let sizes = self.state_sizes();
        let period: f64 = (landings.iter()).fold(0.0, |sum, l| sum + l.duration.to_f64());
        (0..count)
            .map(|index| {
                let next = self.after(index);
                let (step, after) = (&self.steps[index], &self.steps[next]);
                let plain = |step: &Step| held(&system, step.mode()) == 0;
                let is_plain = matches!(step.passage, Passage::Leg(kind) if kind.jump == Jump::None)
                    && matches!(after.passage, Passage::Leg(_))
                    && plain(step)
                    && plain(after);
                let Flown::Leg(leg, flyer) = &self.flown[next] else {
                    return false;
                };
                if !is_plain {
                    return false;
                }
                let all = self.parameters_of(parameters, after);
                let node = &at[self.places[next]..self.places[next] + sizes.len()];
                let field = leg.field(&mut self.flyers[*flyer].1, &all, node);
                goes_on([&landings[index].image_rate, &field], &sizes, period)
            })
            .collect()
    }

    /// The period, known after an evaluation.
    pub(crate) fn period(&self) -> R {
        (self.latest.iter()).fold(R::ZERO, |sum, landing| sum + landing.duration)
    }
}

impl Shooting<f64> {
    /// The same equations in numbers of thirty digits, what is held held as it is at a point.
    pub(crate) fn in_longer_numbers(
        &self,
        at: &[f64],
    ) -> Result<Shooting<DoubleDouble>, PeriodicError> {
        let (steps, counts) = (self.current_steps(at), self.counts.clone());
        let mut fine = Shooting::<DoubleDouble>::new(&self.workshop, steps, counts)?;
        fine.told_node = self.told_node;
        fine.stands_for_section = self.stands_for_section;
        if let Some((place, guard)) = self.corner.as_ref().map(corner::Watched::place) {
            fine.watch(place, guard)?;
        }
        // Where the solution is zero but for rounding, its own size is none.
        for (size, before) in fine.scales.iter_mut().zip(&self.scales) {
            *size = size.max(*before);
        }
        Ok(fine)
    }
}

/// Whether a field goes on as it is, with what it is before and after, where states have these sizes in a period.
pub(in crate::analysis::periodic) fn goes_on<R: Real>(
    [before, after]: [&[R]; 2],
    sizes: &[f64],
    period: f64,
) -> bool {
    let mut rates = before.iter().zip(after).zip(sizes);
    rates.all(|((&before, &after), size)| {
        let jump = (after - before).abs().to_f64();
        jump <= SAME_FIELD * (size / period).max(before.abs().to_f64())
    })
}
