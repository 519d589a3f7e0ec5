//! Where a branch goes on past what its equations can say, and where it may not go on.

use super::changes::graze::{THERE, moved};
use super::changes::holds::sequence_holds;
use super::changes::touch::{NO_TIME, Touched};
use super::walker::Walker;
use super::{End, Limits, Point, Seed, Special, SpecialKind};
use crate::analysis::continuation::{Curve, Problem, Settings, Station, locate};
use crate::analysis::periodic::closure::Closure;
use crate::analysis::periodic::cycle::itinerary::Step;
use crate::analysis::periodic::cycle::reread::reread;
use crate::analysis::periodic::cycle::settle::cycle::Cycle;
use crate::analysis::periodic::orbit::{Orbit, close};
use crate::analysis::periodic::shooting::{Shooting, Workshop};
use crate::analysis::periodic::solved::roundoff;
use crate::flow::leg::onto_gaps;
use crate::flow::{Closed, GuardKind};
use crate::numerics::Real;

/// So far beyond a place where the sequence of events changes orbits are looked for, in parts of the longest step; and where what is
/// expected there is so near to closed, they are of the same branch.
const BEYOND: [f64; 5] = [1e-6, 1e-5, 1e-4, 1e-3, 1e-2];
const SAME_BEYOND: f64 = 1e-3;
/// There its period is as it was and its states are but for so much, against their sizes: another orbit may have as many impacts.
const SAME_PERIOD: f64 = 1e-2;
const SAME_PLACE: f64 = 0.1;
/// So often a shorter way is tried before a longer one.
const PATIENCE: usize = 8;
/// Where new equations begin their steps, in parts of the longest one.
pub(super) const CAREFUL: f64 = 1e-3;

/// What is looked for beyond a place.
pub(in crate::analysis::periodic) struct Wanted<W> {
    /// Whether it has infinitely many impacts, if that is known: it is asked before numbers of thirty digits are spent on an orbit.
    pub infinite: Option<bool>,
    pub is_it: W,
}

impl Walker {
    /// How a branch ends where a restitution, as far as it is a matter of parameters, comes to an end of what it may be on the way to a
    /// station, the station where it does, and how far ahead that is.
    pub(super) fn leaves_theory(
        &mut self,
        (from, next): (&Station, &Station),
        step: f64,
    ) -> Option<(End, Station, f64)> {
        if self.shooting.workshop.restitution_follows.is_empty() {
            return None;
        }
        let workshop = self.shooting.workshop.clone();
        let steps = &self.shooting.steps;
        let chatters = steps.iter().any(Step::is_stretch);
        let is_hit =
            |contact: &usize| chatters || steps.iter().any(|step| step.impact() == Some(*contact));
        let follows = workshop.restitution_follows.iter().copied();
        let hit: Vec<usize> = follows.filter(is_hit).collect();
        let free = self.shooting.parameters();
        for contact in hit {
            let contact = &workshop.model.contacts[contact];
            let graph = &workshop.model.graph;
            let inside = |station: &Station| {
                let values = &station.at[station.at.len() - free..];
                let r = graph.evaluate(contact.restitution, &[], &workshop.parameters(values));
                r.min(1.0 - r)
            };
            let ends = (inside(from), inside(next));
            if ends.0 > 0.0 && ends.1 < 0.0 {
                let value =
                    &mut |_: &mut dyn Problem<f64>, station: &Station| Some(inside(station));
                let (station, ahead) = locate(&mut self.shooting, from, step, ends, value)?;
                let value = station.parameter();
                let (low, high) = self.limits.range;
                let is_at =
                    |edge: f64| (value - edge).abs() <= roundoff(edge.abs().max(high - low));
                if self.limits.beyond(value).is_some_and(|edge| !is_at(edge)) {
                    // The range ends before.
                    continue;
                }
                let is_edge = self.limits.beyond(next.parameter()).is_some_and(is_at);
                let end = match is_edge {
                    true => End::Range,
                    false => End::Lost(format!(
                        "contact `{}` would have a restitution outside 0 <= r <= 1",
                        contact.name
                    )),
                };
                return Some((end, station, ahead));
            }
        }
        None
    }

    /// Goes on a little farther on the same branch, where it has as many impacts and only the order of what happens is another,
    /// such as an impact of complete chatter that comes before the knot of a table and not after it: where it did so often before, farther,
    /// since all impacts of chatter pass a knot one by one. From the station where the sequence of events breaks, if that is known:
    /// then no orbit before it will do. Whether it does.
    pub(super) fn hop(
        &mut self,
        curve: &mut Curve,
        here: &mut Point,
        (before, broke): (usize, Option<&Station>),
    ) -> bool {
        let distances = self.distances()[(before / PATIENCE).min(BEYOND.len() - 1)..].to_vec();
        let from = broke.unwrap_or(&curve.station).clone();
        if self.past_stay(&from, curve, here) {
            return true;
        }
        // What goes on in another number of chatter sequences has as many impacts.
        let accumulations = self.shooting.accumulations();
        let same = |orbit: &Orbit| {
            orbit.impacts == here.impacts && orbit.shooting.accumulations() == accumulations
        };
        let forward = self.heading(&from);
        let passes = |orbit: &Orbit| {
            let gone = orbit.at.last().map_or(0.0, |to| to - from.parameter());
            broke.is_none() || gone * forward > 0.0
        };
        let mut before = self.shooting.clone();
        let slides = self.shooting.slides();
        let ends: Vec<_> = self.shooting.steps.iter().map(Step::ends_at).collect();
        // Where a stick or a slip comes to nothing the way goes into its time, and hardly past the touch.
        let stands = self.shooting.comes_back_at_once(&from.at);
        // So it does where a ball that was thrown lands at rest: it comes from there as the cube of the time between that and its landing.
        // And where an event loses its rate the equations with it turn.
        let is_over =
            stands || self.is_flat(&from) || (broke.is_none() && slides.iter().any(|&on| on > 0));
        let over = is_over.then(|| self.over_the_parameter(&from));
        // A direction in which the parameter goes back, though no fold is told, is one of rounding.
        let is_rounding = !stands && is_over && from.parameter_slope() * forward < 0.0;
        let along = (!is_rounding).then_some(&from);
        let mut ways: Vec<&Station> = along.into_iter().chain(&over).collect();
        if stands {
            ways.reverse();
        }
        let wanted = Wanted {
            infinite: Some(here.impacts.is_none()),
            is_it: |orbit: &Orbit| same(orbit) && passes(orbit),
        };
        let next = (ways.into_iter()).find_map(|way| self.beyond(way, &distances, &wanted));
        let Some(next) = next else {
            return false;
        };
        // Where a stay on a surface shrinks to nothing the orbit beyond only touches it, and where a way off it does, that orbit only just
        // stays on it.
        let slides_on = self.shooting.slides();
        let ends_on: Vec<_> = self.shooting.steps.iter().map(Step::ends_at).collect();
        let between = [curve.station.parameter(), next.parameter()];
        let is_left = |surface: usize| slides[surface] > slides_on[surface];
        let count = |ends: &[Option<GuardKind>], guard: GuardKind| {
            ends.iter().filter(|end| **end == Some(guard)).count()
        };
        let left = |guard| matches!(guard, GuardKind::Switch(surface) if is_left(surface));
        let stayed = |guard| {
            matches!(guard, GuardKind::Leave(..)) && count(&ends, guard) > count(&ends_on, guard)
        };
        let mut touched = None;
        if (0..slides.len()).any(is_left) {
            touched = touch_between(&mut self.shooting, &next.at, between, left);
        }
        if touched.is_none() && ends.iter().flatten().any(|&guard| stayed(guard)) {
            touched = touch_between(&mut self.shooting, &next.at, between, stayed);
        }
        // A crossing and its way back are told by the orbit on either side that has them no more, or not yet. (At the knot of a table nothing
        // happens.)
        let is_crossed = |guard: GuardKind| matches!(guard, GuardKind::Switch(_));
        let goes =
            |guard: GuardKind| is_crossed(guard) && count(&ends, guard) > count(&ends_on, guard);
        let comes =
            |guard: GuardKind| is_crossed(guard) && count(&ends, guard) < count(&ends_on, guard);
        if touched.is_none() && ends.iter().flatten().any(|&guard| goes(guard)) {
            touched = touch_between(&mut self.shooting, &next.at, between, goes);
        }
        if touched.is_none() && ends_on.iter().flatten().any(|&guard| comes(guard)) {
            touched = touch_between(&mut before, &from.at, between, comes);
        }
        let is_new = |touched: &Touched| {
            let (shooting, at, _) = touched.place();
            let own = || shooting.clone().landmarks(at);
            !self.has_told(touched.place(), touched.error)
                && !self.shares_touch((shooting, at, touched.error), own, Seed::landmarks)
        };
        if let Some(touched) = touched.filter(is_new) {
            let there = Point::new(&mut self.shooting, &next);
            self.note_passed_touch(&there, touched);
        }
        // Of one that was told as the sequence broke it is known now, too, that the branch goes on.
        let now = self.points.len();
        let is_told_here =
            |special: &&mut Special| special.kind == SpecialKind::Touch && special.place == now;
        if broke.is_some()
            && let Some(special) = self.special.last_mut().filter(is_told_here)
        {
            special.persists = special.persists.or(Some(true));
        }
        self.begins_anew((next, CAREFUL * self.limits.longest_step), curve, here);
        true
    }

    /// On past where a stay takes no time at all, by the equations without it: with it they have solutions beyond, in which rounding is what is
    /// left of it, and where it is to vanish they are singular. Whether it comes to that.
    pub(super) fn past_stay(
        &mut self,
        from: &Station,
        curve: &mut Curve,
        here: &mut Point,
    ) -> bool {
        let count = self.shooting.steps.len();
        let left = |station: &Station, index: usize| {
            let place = self.shooting.duration_place(index)?;
            station.at.get(place).copied()
        };
        // One that has just come in grows.
        let is_over = |index: &usize| {
            let was = left(&curve.station, *index);
            self.shooting.has_come_back(&from.at, *index) && left(from, *index) <= was
        };
        let over = (0..count).find(is_over);
        // Where several are over at once equations become singular before.
        let index = over.or_else(|| self.shooting.way_onto_that_shrinks(from, NO_TIME));
        let Some(index) = index else {
            return false;
        };
        self.settle(from);
        let forward = self.heading(from);
        let touched = self.shooting.without_stay(&from.at, index).ok();
        let touched = touched.filter(|touched| over.is_some() || touched.together.is_some());
        let Some(mut touched) = touched else {
            return false;
        };
        let Some((shorter, next)) = begins(&mut touched, (&self.distances(), &self.limits)) else {
            return false;
        };
        let there = touched.point(&next);
        let is_new = !self.has_told(touched.place(), touched.error);
        self.shooting = shorter;
        self.settle(&next);
        if is_new {
            self.note_touch(&there, touched);
        }
        let persists = next.parameter_slope() * forward > 0.0;
        if let Some(special) = self.latest_change() {
            special.persists = Some(persists);
        }
        self.begins_anew((next, CAREFUL * self.limits.longest_step), curve, here);
        true
    }

    /// On with new equations, at a station of theirs, with a first step of this length.
    pub(super) fn begins_anew(
        &mut self,
        (next, first_step): (Station, f64),
        curve: &mut Curve,
        here: &mut Point,
    ) {
        *here = Point::new(&mut self.shooting, &next);
        let careful = Settings {
            first_step: first_step.max(1e-9),
            ..self.limits.settings()
        };
        *curve = Curve::new(next, careful);
    }

    /// Whether the latest special point is the touch at the end of a step of these equations, whose parameter is known to so much: an orbit
    /// with a symmetry touches in several places at once.
    pub(super) fn has_told(
        &self,
        (shooting, at, index): (&Shooting<f64>, &[f64], usize),
        error: f64,
    ) -> bool {
        let place = || vec![shooting.node(at, shooting.after(index)).to_vec()];
        let nodes = |seed: &Seed| {
            let nodes = 0..seed.shooting.steps.len();
            nodes
                .map(|index| seed.shooting.node(&seed.at, index).to_vec())
                .collect()
        };
        self.shares_touch((shooting, at, error), place, nodes)
    }

    /// Whether the latest special point is a touch at this value of the parameter, which is known to so much, and one of these states of it is one of
    /// its orbit there.
    fn shares_touch(
        &self,
        (shooting, at, error): (&Shooting<f64>, &[f64], f64),
        states: impl FnOnce() -> Vec<Vec<f64>>,
        known: impl FnOnce(&Seed) -> Vec<Vec<f64>>,
    ) -> bool {
        let value = at.last().copied().unwrap_or(f64::NAN);
        let latest = (self.special.last()).filter(|known| {
            let off = (known.point.parameter() - value).abs();
            known.kind == SpecialKind::Touch && off <= known.error + error
        });
        let Some(seed) = latest.and_then(|known| known.seed.as_ref()) else {
            return false;
        };
        let closure = &shooting.workshop.closure;
        let parameters = shooting.workshop.parameters(shooting.free(at));
        let Ok(turns) = closure.turns(&parameters) else {
            return false;
        };
        let both = (&states()[..], &known(seed)[..]);
        closure.share(&turns, both, &shooting.state_sizes(), THERE)
    }

    /// A station from which the parameter alone goes on: states change ever faster as something shrinks to nothing, and then no more.
    pub(super) fn over_the_parameter(&self, station: &Station) -> Station {
        let mut over = Station {
            tangent: vec![0.0; station.at.len()],
            ..station.clone()
        };
        if let (Some(by), Some(scale)) = (over.tangent.last_mut(), self.shooting.scales().last()) {
            *by = scale.copysign(self.heading(station));
        }
        over
    }

    /// How far beyond a place where the sequence of events changes orbits are looked for.
    pub(super) fn distances(&self) -> [f64; BEYOND.len()] {
        BEYOND.map(|part| part * self.limits.longest_step)
    }

    /// The orbit a little farther on, read off the motion itself, if it is one that is looked for.
    pub(super) fn beyond(
        &mut self,
        from: &Station,
        distances: &[f64],
        wanted: &Wanted<impl Fn(&Orbit) -> bool>,
    ) -> Option<Station> {
        self.settle(from);
        // From just after the fastest impact: at a release the motion would have to decide anew.
        let count = self.shooting.steps.len();
        let rate = |index: usize| {
            let before = self.shooting.before(index);
            let hits = self.shooting.steps[before].impact().is_some();
            let landing = self.shooting.latest.get(before).filter(|_| hits);
            landing.map_or(0.0, |landing| landing.surface_rate.abs())
        };
        // Without impacts a long step begins farther from what changes than a short one, and where the longest one does not lead on
        // another may.
        let duration = |index: usize| {
            (self.shooting.latest.get(index)).map_or(0.0, |landing| landing.duration)
        };
        let nodes = (0..count).filter(|&index| !self.shooting.steps[index].is_at_once());
        let mut nodes: Vec<(usize, f64, f64)> = nodes
            .map(|index| (index, rate(index), duration(index)))
            .collect();
        nodes.sort_by(|a, b| b.1.total_cmp(&a.1).then(b.2.total_cmp(&a.2)));
        if nodes.first().is_some_and(|fastest| fastest.1 > 0.0) {
            nodes.truncate(1);
        }
        nodes.into_iter().find_map(|(node, ..)| {
            let closed = self.shooting.closed_before(node);
            self.beyond_from(from, distances, (node, closed), wanted)
        })
    }

    /// The same from one of its nodes, where these contacts are closed.
    pub(super) fn beyond_from(
        &mut self,
        from: &Station,
        distances: &[f64],
        (node, closed): (usize, Closed),
        wanted: &Wanted<impl Fn(&Orbit) -> bool>,
    ) -> Option<Station> {
        let workshop = self.shooting.workshop.clone();
        let last = from.at.len() - 1;
        distances.iter().find_map(|ahead| {
            let guess = from.at.iter().zip(&from.tangent);
            let guess: Vec<f64> = guess.map(|(x, by)| x + by * ahead).collect();
            let free = self.shooting.free(&guess).to_vec();
            let start = self.shooting.node(&guess, node);
            let mut start = legal(&workshop, &free, (closed, start))?;
            // What stands still on a surface does so exactly: beside it the motion would come to it once more.
            let on = self.shooting.surfaces_stood_on(node);
            let known = workshop.parameters(&free);
            onto_gaps(&workshop.model, (&on, 1), &known, &mut start);
            // The period of a forcing changes with the parameter.
            let turns = workshop.closure.turns(&workshop.parameters(&free)).ok()?;
            let lap = Closure::time_of(&turns, &self.shooting.counts);
            let period = lap.map_or_else(|| self.shooting.period(), |lap| lap.time);
            let told = (&start, period);
            let cycle = reread(&workshop, &free, told).ok()?;
            let cycle = from_rest(&workshop, &free, (&cycle, period)).unwrap_or(cycle);
            // An orbit of more impacts than are followed is closed for nothing; one more may come to be none.
            let impacts: Option<u64> = cycle.steps.iter().map(Step::impacts).sum();
            let is_over = impacts.is_some_and(|impacts| impacts > self.limits.impacts + 1);
            let is_other = (wanted.infinite).is_some_and(|wanted| wanted != impacts.is_none());
            if cycle.distance > SAME_BEYOND || is_over || is_other {
                return None;
            }
            let read: Vec<Vec<f64>> = cycle.steps.iter().map(|step| step.start.clone()).collect();
            let mut orbit = close(&workshop, cycle, &free).ok()?;
            let nodes = 0..orbit.shooting.steps.len();
            let nodes = nodes.map(|index| orbit.shooting.node(&orbit.at, index).to_vec());
            let nodes: Vec<Vec<f64>> = nodes.collect();
            let sizes = self.shooting.state_sizes();
            let is_here = (workshop.closure).share(&turns, (&read, &nodes), &sizes, SAME_PLACE);
            let is_as_long = (orbit.period.to_f64() - period).abs() <= SAME_PERIOD * period;
            if !(is_here && is_as_long) {
                return None;
            }
            // What solves the equations beyond may be no motion any more.
            let holds = sequence_holds(&mut orbit.shooting, &orbit.at);
            if !holds || !(wanted.is_it)(&orbit) {
                return None;
            }
            let (mut shooting, at) = orbit.shooting.without_section(orbit.at);
            shooting.told = self.shooting.told.take().or(shooting.told);
            let station = Station::near(&mut shooting, &at, at.len() - 1).ok()?;
            let forward = from.tangent[last] >= 0.0;
            let station = if forward { station } else { station.reversed() };
            self.shooting = shooting;
            self.settle(&station);
            Some(station)
        })
    }
}

/// The same cycle read from where a contact is at rest after complete chatter, by which it forgets how far it was from closed: beside a corner near the
/// accumulation flights are lower than that, and no guess with it is any. Not from a release, where the motion would have to decide anew.
fn from_rest(workshop: &Workshop, free: &[f64], (cycle, period): (&Cycle, f64)) -> Option<Cycle> {
    let steps = &cycle.steps;
    let rests = steps.windows(2).position(|pair| {
        let [first, next] = pair else { return false };
        let is_over = first.is_stretch() && first.closed != Closed::NONE;
        is_over && !next.is_at_once()
    })?;
    let state = legal(
        workshop,
        free,
        (steps[rests].closed, &steps[rests + 1].start),
    )?;
    let again = reread(workshop, free, (&state, period)).ok()?;
    (again.distance < cycle.distance).then_some(again)
}

/// The orbit beside a solution, at this distance of the parameter in parts of its range, over the parameter alone or along a direction: the one
/// that the motion shows which goes on from there, if it is what is looked for.
pub(in crate::analysis::periodic) fn beside(
    (seed, limits): (&Seed, &Limits),
    (distance, along): (f64, Option<&[f64]>),
    wanted: &Wanted<impl Fn(&Orbit) -> bool>,
) -> Option<(Shooting<f64>, Station)> {
    let mut walker = Walker {
        shooting: seed.shooting.clone(),
        limits: *limits,
        points: Vec::new(),
        special: Vec::new(),
        began: f64::NAN,
    };
    let mut over = Station {
        at: seed.at.clone(),
        tangent: vec![0.0; seed.at.len()],
        residual: 0.0,
        correction: 0.0,
        orientation: 1.0,
    };
    let scale = *walker.shooting.scales().last()?;
    if let Some(along) = along.filter(|along| along.len() == seed.at.len()) {
        let slope = Some(along.last()? / scale).filter(|slope| *slope != 0.0)?;
        over.tangent = along.iter().map(|x| x / slope.abs()).collect();
        if slope * distance < 0.0 {
            over = over.reversed();
        }
    }
    *over.tangent.last_mut()? = scale.copysign(distance);
    let found = walker.beyond(&over, &[distance.abs()], wanted)?;
    Some((walker.shooting, found))
}

/// A station beside a touch, to the side where the sequence of events without what has vanished there holds.
fn begins(
    touched: &mut Touched,
    (distances, limits): (&[f64], &Limits),
) -> Option<(Shooting<f64>, Station)> {
    if let Some(together) = &mut touched.together {
        return together.without_slips(limits);
    }
    let (shooting, at, index) = touched.place();
    let mut steps = shooting.current_steps(at);
    steps.remove(index);
    let (mut shorter, guess) = shooting.like(steps, at).ok()?;
    let there = Station::near(&mut shorter, &guess, guess.len() - 1).ok()?;
    let next = side_that_holds(&mut shorter, &there, distances)?;
    Some((shorter, next))
}

/// The station at the first of these distances, to either side of another, at which the sequence of events holds on one side alone.
pub(super) fn side_that_holds(
    shooting: &mut Shooting<f64>,
    there: &Station,
    distances: &[f64],
) -> Option<Station> {
    distances.iter().find_map(|&ahead| {
        let both = [there.clone(), there.clone().reversed()].map(|there| {
            let (next, _) = there.ahead(shooting, ahead).ok()?;
            sequence_holds(shooting, &next.at).then_some(next)
        });
        match both {
            [Some(next), None] | [None, Some(next)] => Some(next),
            _ => None,
        }
    })
}

/// Where, between two values of the parameter, the smallest of such guards touches zero on an orbit that does not meet it.
pub(super) fn touch_between(
    shooting: &mut Shooting<f64>,
    at: &[f64],
    between: [f64; 2],
    is_wanted: impl Fn(GuardKind) -> bool,
) -> Option<Touched> {
    shooting.evaluate(at).ok()?;
    let least = shooting.least(at).unwrap_or_default();
    let least = least.into_iter().enumerate();
    let on_the_way =
        least.flat_map(|(index, all)| all.into_iter().map(move |least| (index, least)));
    let at_rest = shooting.least_forces(at).unwrap_or_default();
    let all = on_the_way.chain(at_rest);
    let wanted = all.filter(|(_, least)| is_wanted(least.guard));
    let (at_ends, inner): (Vec<_>, Vec<_>) = wanted.partition(|(_, least)| least.at_end);
    let least_at_ends =
        (at_ends.into_iter()).min_by(|a, b| a.1.value.abs().total_cmp(&b.1.value.abs()));
    let inner = inner.into_iter();
    let smallest = inner.min_by(|a, b| a.1.value.abs().total_cmp(&b.1.value.abs()));
    let touches =
        smallest.and_then(|(index, least)| shooting.touched_or_turned(at, (index, &least)).ok());
    // Or, where the surface is crossed, the flow beyond turns back to it as soon as it begins.
    let crossings = shooting.steps.iter().enumerate();
    let crossings = crossings.filter_map(|(index, step)| Some((index, step.ends_at()?)));
    let turns = crossings
        .filter(|(_, guard)| is_wanted(*guard))
        .filter_map(|(index, guard)| {
            let begins = (shooting.after(index), guard.opposite()?);
            let turn = shooting.with_turn_at_start(at, begins).ok()?;
            Touched::solve_turn(turn).ok()
        });
    // Where rounding decides orbits are known to less than as far as they go from there.
    let (low, high) = (between[0].min(between[1]), between[0].max(between[1]));
    let is_between = |touched: &Touched| {
        let value = touched.at.last().copied().unwrap_or(f64::NAN);
        let off = (high - low).max(touched.error);
        (low - off..=high + off).contains(&value)
    };
    // Or a corner of the field ends the way to the touch at that very instant, as that of drag which turns with the rate that vanishes.
    let at_corners = least_at_ends.into_iter().filter_map(|(index, least)| {
        let longer = shooting.with_event(at, index, &least).ok()?;
        let (start, scales) = (longer.1.clone(), longer.0.scales().to_vec());
        let touched = Touched::solve(longer).ok()?;
        (moved(&touched.at, &start, &scales) <= THERE).then_some(touched)
    });
    let inside = touches.into_iter().chain(turns).chain(at_corners);
    { inside }.find(is_between)
}

/// A state that was only guessed: out of the contacts that it penetrates, and at rest on those that are closed.
pub(in crate::analysis::periodic) fn legal(
    workshop: &Workshop,
    free: &[f64],
    (closed, state): (Closed, &[f64]),
) -> Option<Vec<f64>> {
    let (model, system) = (&workshop.model, &workshop.system);
    let parameters = workshop.parameters(free);
    let mut state = state.to_vec();
    for contact in &model.contacts {
        let gap = model.graph.evaluate(contact.gap, &state, &parameters);
        if gap < 0.0 {
            onto_gaps(model, (&[contact.gap], 1), &parameters, &mut state);
        }
    }
    if closed == Closed::NONE {
        return Some(state);
    }
    let clock = model.time.map_or(0.0, |index| state[index]);
    let (mut work, mut held) = system.trajectory_from(&parameters, &state).ok()?;
    (held.restart_beside(system, &mut work, closed, clock, &state)).ok()?;
    Some(held.state().to_vec())
}
