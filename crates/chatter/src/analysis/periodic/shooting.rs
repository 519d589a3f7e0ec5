//! The equations of a periodic orbit: nodes after chosen events, and the times between them.
//!
//! For each leg from node x_k, of duration tau_k, to the surface g_k with the map R_k there (docs/periodic.md)
//!
//! ```text
//! g_k(phi_tau_k(x_k)) = 0,        x_(k+1) - R_k(phi_tau_k(x_k)) = 0,        x_N = x_0 + turns
//! ```
//!
//! Each is regular where an event grazes. A stretch through complete chatter is followed as it is, and its time eliminated.

use super::closure::{Closure, Lap, Turn};
use super::cycle::itinerary::{Passage, Step, held};
use super::cycle::trace::{Instant, Tracer};
use super::error::PeriodicError;
use super::multipliers::neutral;
use crate::analysis::continuation::{Left, Linearised, Problem, Wrap, differenced};
use crate::expressions::{Expr, Graph, Symbol};
use crate::flow::leg::{
    Astray, Flyer, Follower, Landing, Least, Leg, LegKind, Stretch, StretchKind,
};
use crate::flow::{Closed, Corner, GuardKind, Settings, System};
use crate::model::Model;
use crate::numerics::{Complex, Matrix, Real, dot, eigenvalues, pairs};
use core::ops::ControlFlow;
use std::sync::{Arc, Mutex, PoisonError};

/// A model with its compiled legs, shared by all orbits that are looked at.
#[derive(Debug)]
pub(crate) struct Workshop {
    pub model: Model,
    pub system: System,
    pub closure: Closure,
    /// Positions of the free parameters.
    pub free: Vec<usize>,
    /// Sizes of the free parameters.
    pub sizes: Vec<f64>,
    /// Functions of the user's.
    pub monitors: Vec<Monitor>,
    /// The section at which states are told.
    pub section: Option<usize>,
    /// Contacts whose restitution is a matter of parameters alone, the free ones among them.
    pub restitution_follows: Vec<usize>,
    legs: Mutex<Vec<(LegKind, Arc<Leg>)>>,
    stretches: Mutex<Vec<(StretchKind, Arc<Stretch>)>>,
}

/// A function of the state that an orbit is told from, and of parameters, with its derivatives.
#[derive(Clone, Debug)]
pub(crate) struct Monitor {
    value: Expr,
    by_state: Vec<Expr>,
    by_parameter: Vec<Expr>,
}

impl Monitor {
    fn new(model: &mut Model, value: Expr, free: &[usize]) -> Self {
        let mut graph = model.graph.clone();
        let by_state = (0..model.states.len())
            .map(|i| graph.derivative(value, Symbol::State(i)))
            .collect();
        let by_parameter = (free.iter())
            .map(|&p| {
                let rates = model.parameter_rates(&mut graph, p);
                let along = graph.directional_derivatives(&[value], &|symbol| match symbol {
                    Symbol::Parameter(i) => rates.get(i).copied(),
                    Symbol::State(_) => None,
                });
                along[0]
            })
            .collect();
        model.graph = graph;
        Self {
            value,
            by_state,
            by_parameter,
        }
    }
}

impl Monitor {
    /// Its value.
    pub(crate) fn at(&self, graph: &Graph, state: &[f64], parameters: &[f64]) -> f64 {
        graph.evaluate(self.value, state, parameters)
    }
}

impl Workshop {
    pub(crate) fn new(
        model: &Model,
        (free, sizes): (&[usize], &[f64]),
        closure: Closure,
        (section, monitors): (Option<usize>, &[Expr]),
    ) -> Result<Self, PeriodicError> {
        let system = System::new(model).map_err(PeriodicError::System)?;
        let mut model = model.clone();
        let monitors = (monitors.iter())
            .map(|&value| Monitor::new(&mut model, value, free))
            .collect();
        let follows = |index: &usize| {
            let restitution = model.contacts[*index].restitution;
            !model.graph.depends_on_state(restitution) && depends_on(&model, restitution, free)
        };
        Ok(Self {
            restitution_follows: (0..model.contacts.len()).filter(follows).collect(),
            system,
            model,
            monitors,
            closure,
            free: free.to_vec(),
            sizes: sizes.to_vec(),
            section,
            legs: Mutex::default(),
            stretches: Mutex::default(),
        })
    }

    fn leg(&self, kind: LegKind) -> Option<Arc<Leg>> {
        let mut known = self.legs.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, leg)) = known.iter().find(|(of, _)| *of == kind) {
            return Some(leg.clone());
        }
        let leg = Arc::new(self.system.leg(kind, &self.free, self.section)?);
        known.push((kind, leg.clone()));
        Some(leg)
    }

    fn stretch(&self, kind: StretchKind) -> Option<Arc<Stretch>> {
        let mut known = (self.stretches.lock()).unwrap_or_else(PoisonError::into_inner);
        if let Some((_, stretch)) = known.iter().find(|(of, _)| *of == kind) {
            return Some(stretch.clone());
        }
        let stretch = Arc::new(self.system.stretch(kind, &self.free)?);
        known.push((kind, stretch.clone()));
        Some(stretch)
    }

    /// What happens where a guard vanishes.
    pub(crate) fn named(&self, guard: GuardKind) -> String {
        let contact = |index: usize| &self.model.contacts[index].name;
        let corner = |corner: Corner| self.system.corner_name(corner);
        match guard {
            GuardKind::Gap(index) => format!("an impact at `{}`", contact(index)),
            GuardKind::Reaction(index) => format!("a release of `{}`", contact(index)),
            GuardKind::Jam(index) => format!("the jamming of `{}`", contact(index)),
            GuardKind::Section(index) => format!("`{}`", self.model.sections[index].name),
            GuardKind::Switch(index) => {
                format!("a crossing of {} = 0", corner(Corner::Surface(index)))
            }
            GuardKind::Leave(index, _) => {
                format!(
                    "the end of sliding along {} = 0",
                    corner(Corner::Surface(index))
                )
            }
            GuardKind::Piece(index, _) => {
                format!("the end of a piece at {}", corner(Corner::Lookup(index)))
            }
        }
    }

    /// All parameters, with the free ones at these values.
    pub(crate) fn parameters<R: Real>(&self, free: &[R]) -> Vec<R> {
        let values: Vec<(usize, R)> = (self.free.iter().copied())
            .zip(free.iter().copied())
            .collect();
        self.model.parameter_values(&values)
    }
}

/// Whether a formula depends on some of these parameters, be it through others.
fn depends_on(model: &Model, formula: Expr, parameters: &[usize]) -> bool {
    let used = model.graph.symbols(formula);
    parameters.iter().any(|&parameter| {
        let mut graph = model.graph.clone();
        let rates = model.parameter_rates(&mut graph, parameter);
        let zero = graph.number(0.0);
        (rates.iter().enumerate())
            .any(|(index, &rate)| rate != zero && used.contains(&Symbol::Parameter(index)))
    })
}

/// Sizes of states, where nothing is known of one that of the largest.
pub(crate) fn without_zeros(mut sizes: Vec<f64>) -> Vec<f64> {
    let largest = sizes.iter().fold(0.0_f64, |most, x| most.max(*x));
    let usual = if largest > 0.0 { largest } else { 1.0 };
    for size in sizes.iter_mut().filter(|size| **size == 0.0) {
        *size = usual;
    }
    sizes
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
    watching: Option<Vec<R>>,
    /// The least values that were looked at last, and where.
    seen: Option<(Vec<R>, Vec<Vec<Least>>)>,
    /// The state that was told last: of several crossings of the section the nearest is told next.
    pub told: Option<Vec<f64>>,
}

/// A stretch that is traced once more ends within this part of its duration.
const BEYOND_END: f64 = 1e-12;
/// Sizes of states that fall below this part of what they were.
const NEXT_TO_NOTHING: f64 = 1e-6;
/// A leg that would take this many times as long as its guess is given up.
const LONGEST: f64 = 4.0;

impl<R: Real> Shooting<R> {
    pub(crate) fn new(
        workshop: &Arc<Workshop>,
        steps: Vec<Step>,
        counts: Vec<i64>,
    ) -> Result<Self, PeriodicError> {
        let settings = Settings::default();
        let unfollowed = || PeriodicError::Unfollowed {
            what: "a mode that holds no motion".to_owned(),
        };
        let mut flown = Vec::with_capacity(steps.len());
        let mut flyers: Vec<(LegKind, Flyer<R>)> = Vec::new();
        let mut places = Vec::with_capacity(steps.len());
        let n = workshop.model.states.len();
        let mut unknowns = 0;
        for step in &steps {
            places.push(unknowns);
            unknowns += n;
            match step.passage {
                Passage::Leg(kind) | Passage::Timed(kind) => {
                    let leg = workshop.leg(kind).ok_or_else(unfollowed)?;
                    let place = flyers.iter().position(|(of, _)| *of == kind);
                    let place = place.unwrap_or_else(|| {
                        flyers.push((kind, leg.flyer(&settings)));
                        flyers.len() - 1
                    });
                    unknowns += usize::from(matches!(step.passage, Passage::Leg(_)));
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
            watching: None,
            seen: None,
            told: None,
        };
        shooting.rescale();
        Ok(shooting)
    }

    /// Sizes from the nodes as they are known.
    fn rescale(&mut self) {
        let n = self.workshop.model.states.len();
        let mut sizes = vec![0.0_f64; n];
        let model = &self.workshop.model;
        let parameters = self.workshop.parameters::<f64>(&[]);
        for step in &self.steps {
            for ((size, x), state) in sizes.iter_mut().zip(&step.start).zip(&model.states) {
                // A position is zero at all its impacts, yet has a size: that of how far it moves.
                let rate = model
                    .graph
                    .evaluate(state.derivative, &step.start, &parameters);
                let moves = (rate * step.duration).abs();
                *size = size
                    .max(x.abs())
                    .max(if moves.is_finite() { moves } else { 0.0 });
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
            if matches!(step.passage, Passage::Leg(_)) {
                scales.push(period);
            }
        }
        scales.extend(&self.workshop.sizes);
        self.scales = scales;
        self.pins = (self.steps.first())
            .map(|step| step.start.iter().map(|&x| R::splat(x)).collect())
            .unwrap_or_default();
    }

    /// Keeps sizes that states had before, where next to nothing is left of them.
    pub(crate) fn keep_sizes(&mut self, before: &[f64]) {
        for &place in &self.places {
            for (size, &before) in self.scales[place..].iter_mut().zip(before) {
                if *size < NEXT_TO_NOTHING * before {
                    *size = before;
                }
            }
        }
    }

    /// The size of each state.
    pub(crate) fn state_sizes(&self) -> Vec<f64> {
        self.scales[..self.workshop.model.states.len()].to_vec()
    }

    /// Adds the turns of a period to the phases of all nodes.
    pub(crate) fn turn_on(&self, nodes: &mut [f64], at: &[R]) {
        let parameters = self.workshop.parameters::<f64>(
            &self
                .free(at)
                .iter()
                .map(|p| p.to_f64())
                .collect::<Vec<f64>>(),
        );
        let Ok(turns) = self.workshop.closure.turns(&parameters) else {
            return;
        };
        for (turn, &count) in turns.iter().zip(&self.counts) {
            for &place in &self.places {
                nodes[place + turn.state] += turn.period * count as f64;
            }
        }
    }

    /// The unknowns as first guessed, at these free parameters.
    pub(crate) fn guess(&self, free: &[f64]) -> Vec<R> {
        let mut at = Vec::with_capacity(self.scales.len());
        for step in &self.steps {
            at.extend(step.start.iter().map(|&x| R::splat(x)));
            if matches!(step.passage, Passage::Leg(_)) {
                at.push(R::splat(step.duration));
            }
        }
        at.extend(free.iter().map(|&p| R::splat(p)));
        at
    }

    /// Takes a solution as what later guesses and sizes start from.
    pub(crate) fn adopt(&mut self, at: &[R]) {
        self.steps = self.current_steps(at);
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
        let count = self.steps.len();
        self.steps[(index + count - 1) % count].closed
    }

    /// Impacts a period; none where infinitely many.
    pub(crate) fn impacts(&self) -> Option<u64> {
        let impacts = |step: &Step| match step.passage {
            Passage::Stretch(kind) => (kind.accumulations == 0).then_some(kind.impacts as u64),
            _ => Some(u64::from(step.impact().is_some())),
        };
        self.steps.iter().map(impacts).sum()
    }

    /// The node that a step starts from.
    pub(crate) fn node<'a>(&self, at: &'a [R], index: usize) -> &'a [R] {
        let n = self.workshop.model.states.len();
        &at[self.places[index]..self.places[index] + n]
    }

    /// Place of the duration of a step among the unknowns.
    pub(crate) fn duration_place(&self, index: usize) -> Option<usize> {
        let n = self.workshop.model.states.len();
        matches!(self.steps[index].passage, Passage::Leg(_)).then(|| self.places[index] + n)
    }

    pub(crate) fn free<'a>(&self, at: &'a [R]) -> &'a [R] {
        &at[at.len() - self.workshop.free.len()..]
    }

    /// The model's parameters followed by those of a step's pieces.
    fn parameters_of(&self, parameters: &[R], step: &Step) -> Vec<R> {
        let mut all = parameters.to_vec();
        let system = &self.workshop.system;
        let graph = &system.model().graph;
        for (index, &piece) in step.pieces.iter().enumerate() {
            all.extend(
                system
                    .corners()
                    .slots_of::<R>(graph, index, piece)
                    .unwrap_or_default(),
            );
        }
        all
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
        for index in 0..self.steps.len() {
            let all = self.parameters_of(parameters, &self.steps[index]);
            let place = self.places[index];
            let x = &at[place..place + n];
            let step = &self.steps[index];
            let landing = match &mut self.flown[index] {
                Flown::Leg(leg, flyer) => {
                    let duration = match step.passage {
                        Passage::Leg(_) => at[place + n],
                        _ => timed.as_ref().map_or(R::ZERO, |lap| lap.time),
                    };
                    if duration <= R::ZERO || !duration.is_finite() {
                        return Err(Left::because(format_args!(
                            "the time between events {index} and {} vanishes",
                            index + 1
                        )));
                    }
                    leg.fly(&mut self.flyers[*flyer].1, &all, x, duration)
                        .map_err(Left::because)?
                }
                Flown::Stretch(stretch, follower) => {
                    let longest = R::splat(LONGEST * step.duration);
                    let followed = stretch.follow(follower, &all, x, longest);
                    followed.map_err(|astray| match astray {
                        Astray::Failed(error) => Left::because(error),
                        Astray::Otherwise => Left::because("chatter is not complete"),
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

    /// The period, known after an evaluation.
    pub(crate) fn period(&self) -> R {
        (self.latest.iter()).fold(R::ZERO, |sum, landing| sum + landing.duration)
    }

    /// The derivative of the map from the first node to itself, events' times taken with it.
    pub(crate) fn monodromy(&self) -> Matrix<R> {
        let n = self.workshop.model.states.len();
        let mut product = Matrix::identity(n);
        for landing in &self.latest {
            product = transfer(landing, n).times(&product);
        }
        product
    }

    /// How many of the multipliers are zero by dimension: what the modes hold is forgotten.
    fn lost(&self) -> usize {
        let system = &self.workshop.system;
        let modes = self.steps.iter().map(|step| held(system, step.mode()));
        let closed = (self.steps.iter()).map(|step| 2 * step.closed.contacts().count());
        modes.chain(closed).max().unwrap_or(0)
    }

    /// All multipliers but the trivial one, the largest first.
    pub(crate) fn multipliers(&self) -> Vec<Complex> {
        let n = self.workshop.model.states.len();
        let product = self.monodromy();
        let has_events = (self.steps.iter()).any(|step| !matches!(step.passage, Passage::Timed(_)));
        let turning: Vec<usize> = (self.workshop.closure.time.into_iter())
            .chain(self.clock())
            .collect();
        let kept: Vec<usize> = (0..n)
            .filter(|&i| !self.workshop.closure.is_idle(i))
            .filter(|i| has_events || !turning.contains(i))
            .collect();
        let mut reduced = Matrix::zeros(kept.len(), kept.len());
        for (row, &i) in kept.iter().enumerate() {
            for (column, &k) in kept.iter().enumerate() {
                reduced[(row, column)] = product[(i, k)].to_f64();
            }
        }
        let mut found = eigenvalues(&reduced);
        if has_events {
            // On the surface of an event there is no displacement in time.
            found.pop();
        }
        let left = found.len().saturating_sub(self.lost());
        if left == 2 && found.len() == 2 && has_events && found[0].im == 0.0 {
            // The product of both is a sum of minors, known better than an eigenvalue that is far smaller than the other.
            let minors = self.minors(&kept);
            found[1].re = minors.to_f64() / found[0].re;
        }
        for value in &mut found[left..] {
            *value = Complex::default();
        }
        found
    }

    /// The sum of the monodromy matrix's minors of two of these rows and columns.
    fn minors(&self, kept: &[usize]) -> R {
        let n = self.workshop.model.states.len();
        let mut product = Matrix::identity(n * (n - 1) / 2);
        for landing in &self.latest {
            product = transfer(landing, n).minors().times(&product);
        }
        (pairs(n).enumerate())
            .filter(|(_, (i, k))| kept.contains(i) && kept.contains(k))
            .fold(R::ZERO, |sum, (place, _)| sum + product[(place, place)])
    }

    /// The phase that turns by itself, where no time does.
    fn clock(&self) -> Option<usize> {
        let turns = self
            .workshop
            .closure
            .turns::<f64>(&self.workshop.parameters(&[]))
            .ok()?;
        (turns.iter().zip(&self.counts))
            .find(|(_, count)| **count != 0)
            .map(|(turn, _)| turn.state)
    }

    /// The multiplier along the flow, which is one: how well the derivatives know it. None where time is no state of the
    /// motion.
    pub(crate) fn trivial_multiplier(&mut self, at: &[R]) -> Option<f64> {
        if self.workshop.closure.time.is_some() {
            return None;
        }
        let n = self.workshop.model.states.len();
        let parameters = self.workshop.parameters(self.free(at));
        let mut product = R::ONE;
        for index in 0..self.steps.len() {
            let all = self.parameters_of(&parameters, &self.steps[index]);
            let x = &at[self.places[index]..self.places[index] + n];
            let Flown::Leg(leg, flyer) = &self.flown[index] else {
                continue;
            };
            let field = leg.field(&mut self.flyers[*flyer].1, &all, x);
            let landing = self.latest.get(index)?;
            if landing.surface_rate == R::ZERO {
                return None;
            }
            product *= dot(&landing.surface_slopes[..n], &field) / landing.surface_rate;
        }
        Some(product.to_f64())
    }
}

impl<R: Real> Shooting<R> {
    /// The number of the function that vanishes where a pair of multipliers is on the unit circle.
    pub(crate) fn pair_function(&self) -> usize {
        self.steps.len()
    }

    /// The number of one of the user's functions.
    pub(crate) fn user_function(&self, index: usize) -> usize {
        self.steps.len() + 1 + index
    }

    /// The same, with its derivatives.
    fn function(&self, index: usize, at: &[R]) -> Result<(R, Vec<R>), Left> {
        let monitor = (self.workshop.monitors.get(index))
            .ok_or_else(|| Left::because(format_args!("there is no function {index}")))?;
        let parameters = self.workshop.parameters(self.free(at));
        let of = |expr: Expr| {
            let graph = &self.workshop.model.graph;
            graph.evaluate(expr, self.node(at, 0), &parameters)
        };
        let mut gradient = vec![R::ZERO; at.len()];
        for (entry, &slope) in gradient[self.places[0]..].iter_mut().zip(&monitor.by_state) {
            *entry = of(slope);
        }
        let free = at.len() - self.workshop.free.len();
        for (entry, &slope) in gradient[free..].iter_mut().zip(&monitor.by_parameter) {
            *entry = of(slope);
        }
        Ok((of(monitor.value), gradient))
    }
}

impl Shooting<f64> {
    /// The least values of all guards on the way of the orbit, and its crossings of the section, by step.
    pub(crate) fn least(&mut self, at: &[f64]) -> Result<Vec<Vec<Least>>, Left> {
        if let Some((known, found)) = &self.seen
            && known == at
        {
            return Ok(found.clone());
        }
        let found = self.look(at)?;
        self.seen = Some((at.to_vec(), found.clone()));
        Ok(found)
    }

    fn look(&mut self, at: &[f64]) -> Result<Vec<Vec<Least>>, Left> {
        let n = self.workshop.model.states.len();
        let parameters = self.workshop.parameters(self.free(at));
        let mut found = Vec::with_capacity(self.steps.len());
        for index in 0..self.steps.len() {
            let all = self.parameters_of(&parameters, &self.steps[index]);
            let place = self.places[index];
            let x = &at[place..place + n];
            let Flown::Leg(leg, flyer) = &self.flown[index] else {
                found.push(self.crossings_within(index, at));
                continue;
            };
            let duration = match self.steps[index].passage {
                Passage::Leg(_) => at[place + n],
                _ => self
                    .latest
                    .get(index)
                    .map_or(self.steps[index].duration, |l| l.duration),
            };
            let flyer = &mut self.flyers[*flyer].1;
            found.push(leg.least(flyer, &all, x, duration).map_err(Left::because)?);
        }
        Ok(found)
    }

    /// What happens within a step that is a stretch, which is followed as a whole, and when it begins.
    pub(crate) fn instants_within(&self, index: usize, at: &[f64]) -> (f64, Vec<Instant>) {
        let nothing = (0.0, Vec::new());
        let (Flown::Stretch(stretch, _), Some(landing)) =
            (&self.flown[index], self.latest.get(index))
        else {
            return nothing;
        };
        let parameters = self.workshop.parameters(self.free(at));
        let start = stretch.onto_contact(&parameters, self.node(at, index));
        let system = &self.workshop.system;
        let Ok(mut tracer) = Tracer::new(system, &parameters, &start, self.workshop.section) else {
            return nothing;
        };
        let clock = tracer.trajectory.time();
        let mut instants = Vec::new();
        // Its end is one of them.
        let until = clock + landing.duration * (1.0 + BEYOND_END);
        let mut quiet = |_: f64| ControlFlow::Continue(());
        // What cannot be followed has nothing to tell.
        let _ = tracer.follow((until, usize::MAX / 2), &mut instants, &mut quiet);
        (clock, instants)
    }

    /// The crossings of the section within a stretch.
    fn crossings_within(&self, index: usize, at: &[f64]) -> Vec<Least> {
        let Some(section) = self.workshop.section else {
            return Vec::new();
        };
        let (clock, instants) = self.instants_within(index, at);
        let crossed = instants
            .into_iter()
            .filter(|instant| instant.crosses(section));
        let told = |instant: Instant| Least {
            guard: GuardKind::Section(section),
            time: instant.time - clock,
            value: 0.0,
            state: instant.state,
            at_end: false,
        };
        crossed.map(told).collect()
    }
}

/// The derivative of a leg's image by its start, the event's time taken with it.
fn transfer<R: Real>(landing: &Landing<R>, n: usize) -> Matrix<R> {
    let mut transfer = Matrix::zeros(n, n);
    let timed = landing.surface_rate == R::ZERO;
    for i in 0..n {
        for k in 0..n {
            let mut slope = landing.image_slopes[(i, k)];
            if !timed {
                slope -= landing.image_rate[i] * landing.surface_slopes[k] / landing.surface_rate;
            }
            transfer[(i, k)] = slope;
        }
    }
    transfer
}

impl<R: Real> Problem<R> for Shooting<R> {
    fn unknowns(&self) -> usize {
        self.scales.len()
    }

    fn parameters(&self) -> usize {
        self.workshop.free.len()
    }

    fn scales(&self) -> &[f64] {
        &self.scales
    }

    fn evaluate(&mut self, at: &[R]) -> Result<Linearised<R>, Left> {
        let workshop = self.workshop.clone();
        let n = workshop.model.states.len();
        let free = workshop.free.len();
        let unknowns = self.scales.len();
        let parameters = workshop.parameters(self.free(at));
        let turns = workshop.closure.turns(&parameters).map_err(Left::because)?;
        let landings = self.land(at, &turns, &parameters)?;
        let lap = self.timed(&turns);
        let mut residual = vec![R::ZERO; unknowns - free];
        let mut jacobian = Matrix::zeros(unknowns - free, unknowns);
        let count = self.steps.len();
        let mut row = 0;
        for (index, landing) in landings.iter().enumerate() {
            let place = self.places[index];
            let next = self.places[(index + 1) % count];
            let is_last = index + 1 == count;
            let timed = matches!(self.steps[index].passage, Passage::Timed(_));
            let is_leg = matches!(self.steps[index].passage, Passage::Leg(_));
            if is_leg {
                residual[row] = landing.surface;
                for k in 0..n {
                    jacobian[(row, place + k)] = landing.surface_slopes[k];
                }
                jacobian[(row, place + n)] = landing.surface_rate;
                for k in 0..free {
                    jacobian[(row, unknowns - free + k)] = landing.surface_slopes[n + k];
                }
                row += 1;
            }
            for i in 0..n {
                residual[row] = at[next + i] - landing.image[i];
                jacobian[(row, next + i)] += R::ONE;
                for k in 0..n + free {
                    let column = if k < n {
                        place + k
                    } else {
                        unknowns - free + k - n
                    };
                    let mut slope = landing.image_slopes[(i, k)];
                    if !is_leg && !timed {
                        let late = landing.surface_slopes[k] / landing.surface_rate;
                        slope -= landing.image_rate[i] * late;
                    }
                    jacobian[(row, column)] -= slope;
                }
                if is_leg {
                    jacobian[(row, place + n)] -= landing.image_rate[i];
                }
                if timed {
                    // The duration follows the period.
                    if let Some(lap) = &lap {
                        for (k, &slope) in lap.slopes.iter().enumerate() {
                            jacobian[(row, unknowns - free + k)] -= landing.image_rate[i] * slope;
                        }
                    }
                }
                if is_last {
                    let turning = turns
                        .iter()
                        .zip(&self.counts)
                        .find(|(turn, _)| turn.state == i);
                    if let Some((turn, &times)) = turning {
                        let times = R::splat(times as f64);
                        residual[row] += turn.period * times;
                        for (k, &slope) in turn.slopes.iter().enumerate() {
                            jacobian[(row, unknowns - free + k)] += slope * times;
                        }
                    }
                }
                row += 1;
            }
        }
        let last = row - n;
        // A timed orbit of a system with time has no equation for when it starts: it starts there.
        let all_timed = (self.steps.iter()).all(|step| matches!(step.passage, Passage::Timed(_)));
        let clock = workshop
            .closure
            .time
            .or_else(|| self.clock())
            .filter(|_| all_timed);
        if let Some(i) = clock {
            jacobian.row_mut(last + i).fill(R::ZERO);
            jacobian[(last + i, self.places[0] + i)] = R::ONE;
            residual[last + i] = at[self.places[0] + i] - self.pins[i];
        }
        for free in &workshop.closure.idle {
            let i = last + free.state;
            for &(other, times) in &free.others {
                let times = R::splat(times);
                for column in 0..unknowns {
                    let moved = jacobian[(i, column)];
                    jacobian[(last + other, column)] -= times * moved;
                }
                let moved = residual[i];
                residual[last + other] -= times * moved;
            }
        }
        for free in &workshop.closure.idle {
            let i = last + free.state;
            jacobian.row_mut(i).fill(R::ZERO);
            jacobian[(i, self.places[0] + free.state)] = R::ONE;
            residual[i] = at[self.places[0] + free.state] - self.pins[free.state];
        }
        self.latest = landings;
        self.watching = Some(at.to_vec());
        Ok(Linearised { residual, jacobian })
    }

    /// Function number `index`: for each step the rate before the event at its end, zero where it grazes; then what vanishes
    /// where a pair of multipliers is on the unit circle; then the user's functions.
    fn monitor(&mut self, index: usize, at: &[R]) -> Result<(R, Vec<R>), Left> {
        if index == self.pair_function() {
            return differenced(self, at, |shooting, at| {
                shooting.evaluate(at)?;
                let found = neutral(&shooting.multipliers());
                let (off, ..) =
                    found.ok_or_else(|| Left::because("there are no two multipliers"))?;
                Ok(R::splat(off))
            });
        }
        if let Some(index) = index.checked_sub(self.user_function(0)) {
            return self.function(index, at);
        }
        if self.watching.as_deref() != Some(at) {
            self.evaluate(at)?;
        }
        let n = self.workshop.model.states.len();
        let free = self.workshop.free.len();
        let place = self.places[index];
        let landing = &self.latest[index];
        let mut gradient = vec![R::ZERO; at.len()];
        gradient[place..place + n].copy_from_slice(&landing.rate_slopes[..n]);
        for k in 0..free {
            gradient[at.len() - free + k] = landing.rate_slopes[n + k];
        }
        if let Some(duration) = self.duration_place(index) {
            gradient[duration] = landing.surface_acceleration;
        }
        Ok((landing.surface_rate, gradient))
    }

    fn wrap(&self) -> Wrap {
        let n = self.workshop.model.states.len();
        let free = self.workshop.free.len();
        let last = self.scales.len() - free - n;
        let closure = &self.workshop.closure;
        let entries = (0..n)
            .filter(|&i| !closure.is_idle(i))
            .map(|i| (last + i, self.places[0] + i, 1.0));
        Wrap {
            entries: entries.collect(),
        }
    }
}
