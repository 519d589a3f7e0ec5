//! Grazes where the flow turns with the side of a surface: drag and friction change with the sign of the very rate that vanishes. The
//! impact at which that rate turns comes in where it passed zero by itself, and leaves the surface crossed where it goes out.

use super::events::unfollowed;
use super::touch::VANISHED;
use crate::analysis::continuation::Problem;
use crate::analysis::periodic::closure::Closure;
use crate::analysis::periodic::cycle::itinerary::{Passage, Step};
use crate::analysis::periodic::error::PeriodicError;
use crate::analysis::periodic::shooting::Shooting;
use crate::expressions::{Side, Sides, Symbol};
use crate::flow::GuardKind;
use crate::flow::leg::{Jump, Least, LegKind};
use crate::numerics::{Real, moved};

/// This part of a leg before its end is its end.
const NOT_QUITE: f64 = 1e-5;
/// A plastic impact leaves no more than this part of what changes the rate before it: the rest is rounding.
const PLASTIC: f64 = 1e-12;
/// A gap turns where its rate would change it by no more than this part of its size on the leg.
const NO_RATE: f64 = 1e-6;
/// So far on along a curve what begins there has grown in proportion.
const ONWARD: f64 = 1e-6;

impl Shooting<f64> {
    /// The same orbit with an impact of rate zero where a step ends by crossing a surface.
    pub(crate) fn with_impact_at_turn(
        &self,
        at: &[f64],
        (index, contact): (usize, usize),
    ) -> Result<(Self, Vec<f64>, usize), PeriodicError> {
        let mut steps = self.current_steps(at);
        let Some((kind, surface)) = turn(&steps[index]) else {
            return Err(unfollowed("a graze where another event ends the flight"));
        };
        let kind = LegKind {
            ends_at: Some(GuardKind::Gap(contact)),
            jump: Jump::Impact(contact),
            ..kind
        };
        let touch = &steps[self.after(index)].start;
        let (kind, pieces) = self.to_impact(at, kind, (touch, &steps[index]));
        steps[index].passage = Passage::Leg(kind);
        steps[index].pieces = pieces;
        // However weak, it takes the state off a surface that it would slide along, and a way back to that comes in as well, of no time yet.
        let after = self.after(index);
        if self.slides_along(&steps[after], surface)
            && let Some(mode) = self.mode_beyond(kind.mode, surface)
        {
            self.insert_way_back(at, &mut steps, (index, after), (mode, surface))?;
        }
        let (shooting, at) = self.like(steps, at)?;
        Ok((shooting, at, index))
    }

    /// A way back to a surface, of no time yet, after the impact at the end of a step, and before the one after it, which slides along it.
    fn insert_way_back(
        &self,
        at: &[f64],
        steps: &mut Vec<Step>,
        (index, after): (usize, usize),
        (mode, surface): (usize, usize),
    ) -> Result<(), PeriodicError> {
        let back = Step {
            passage: Passage::Leg(LegKind {
                mode,
                ends_at: Some(GuardKind::Switch(surface)),
                jump: Jump::None,
            }),
            duration: 0.0,
            told: Vec::new(),
            closed: steps[index].closed,
            ..steps[after].clone()
        };
        steps.insert(index + 1, back);
        if after == 0 {
            // What comes after is the next turn.
            let parameters = self.workshop.parameters(self.free(at));
            let turns = self.workshop.closure.turns::<f64>(&parameters)?;
            let start = &mut steps[index + 1].start;
            *start = Closure::later(&turns, &self.counts, start);
        }
        Ok(())
    }

    /// The same orbit with a slip, of no time yet, after an impact that takes the state off the one surface that it slides along, and where the time of
    /// that stands among the unknowns.
    pub(super) fn with_slip(
        &self,
        at: &[f64],
        index: usize,
    ) -> Result<(Self, Vec<f64>, usize), PeriodicError> {
        let unknown = || unfollowed("an impact that takes the state off what it slides along");
        let [(surface, side)] = self.left_at_impact(index)[..] else {
            return Err(unknown());
        };
        let after = self.after(index);
        let system = &self.workshop.system;
        let slips = self.slides_along(&self.steps[after], surface);
        let origin = system.origin_of(self.steps[index].mode());
        let (grip, sides, _) = origin.filter(|_| slips).ok_or_else(unknown)?;
        let mode = system.meet(grip, sides.with(surface, side));
        system.program(mode).ok_or_else(unknown)?;
        let mut steps = self.current_steps(at);
        self.insert_way_back(at, &mut steps, (index, after), (mode, surface))?;
        let (shooting, at) = self.like(steps, at)?;
        let place = shooting.duration_place(index + 1).ok_or_else(unknown)?;
        Ok((shooting, at, place))
    }

    /// Whether what strikes at the end of a step stays off the contact with the slip that begins there, in a direction in which both grow: parted from
    /// what it slid with, it may be driven back. With rates u and w where the slip of time tau begins and ends, and the acceleration a after it, the
    /// gap is (u + w) tau / 2 at its end, and w^2 / 2a less where it is least, if w < 0. All of it is of one order in how far the curve has gone.
    pub(super) fn parts_by_slip(&self, (at, along): (&[f64], &[f64]), index: usize) -> bool {
        let (Some(contact), slip) = (self.steps[index].impact(), self.after(index)) else {
            return false;
        };
        let held = self.after(slip);
        let beside = moved(at, along, ONWARD);
        let [begins, ends] = [slip, held].map(|index| self.gap_rate(&beside, (index, contact)).0);
        let parameters = self.workshop.parameters(self.free(at));
        let parameters = self.parameters_of(&parameters, &self.steps[held]);
        let place = (self.steps[held].mode(), contact);
        let moves = (self.workshop.system).gap_moves(place, &parameters, self.node(at, held));
        let (Some(lasts), Some([acceleration, _])) = (self.duration_place(slip), moves) else {
            return false;
        };
        ends >= 0.0
            || acceleration > 0.0 && (begins + ends) * beside[lasts] > ends * ends / acceleration
    }

    /// Whether a guard is that of the surface which the impact before a step takes the state across: with no rate it leaves the state on it.
    pub(crate) fn begins_on_turn(&self, index: usize, guard: GuardKind) -> bool {
        let before = &self.steps[self.before(index)];
        let crossed = (before.impact())
            .and_then(|_| self.surface_at_impact(before.mode(), self.steps[index].mode()));
        crossed.is_some_and(|surface| guard == GuardKind::Switch(surface))
    }

    /// The rate with which a guard begins on a step that begins on its surface.
    pub(crate) fn rate_at_start(&self, at: &[f64], place: (usize, GuardKind)) -> Option<f64> {
        let (mut turn, at, index) = self.with_turn_at_start(at, place).ok()?;
        turn.evaluate(&at).ok()?;
        Some(turn.latest[index].surface_rate)
    }

    /// The mode on the other side of a surface.
    pub(super) fn mode_beyond(&self, mode: usize, surface: usize) -> Option<usize> {
        let system = &self.workshop.system;
        let (grip, sides, _) = system.origin_of(mode)?;
        let other = match sides.get(surface) {
            Side::Above => Side::Below,
            Side::Below => Side::Above,
            _ => return None,
        };
        let mode = system.meet(grip, sides.with(surface, other));
        system.program(mode).map(|_| mode)
    }

    /// The impact before the shortest way back to a surface, if that takes next to no time.
    pub(in crate::analysis::periodic::branch) fn impact_that_vanishes(
        &self,
        at: &[f64],
    ) -> Option<usize> {
        let ways = (0..self.steps.len()).filter(|&index| self.is_way_back(index));
        let timed = ways.filter_map(|index| Some((index, *at.get(self.duration_place(index)?)?)));
        let shortest = timed.min_by(|a, b| a.1.total_cmp(&b.1));
        let vanished = shortest.filter(|(_, time)| *time < VANISHED * self.period());
        vanished.map(|(index, _)| self.before(index))
    }

    /// Whether the surface at whose crossing a step ends is one that this contact's rate may turn with.
    pub(in crate::analysis::periodic::branch) fn turns(&self, index: usize) -> bool {
        turn(&self.steps[index]).is_some()
    }

    /// Whether a gap has its least value where its rate turns at the end of a step, with the surface that ends it.
    pub(crate) fn touches_at_turn(
        &self,
        (at, least): (&[f64], &[Vec<Least>]),
        (index, contact): (usize, usize),
    ) -> bool {
        let (Some(all), Some(landing)) = (least.get(index), self.latest.get(index)) else {
            return false;
        };
        let gaps = all.iter().filter(|l| l.guard == GuardKind::Gap(contact));
        let Some(least) = gaps.min_by(|a, b| a.value.total_cmp(&b.value)) else {
            return false;
        };
        let (rate, _) = self.gap_rate(at, (self.after(index), contact));
        let falls = rate * landing.duration;
        self.turns(index)
            && landing.duration - least.time <= NOT_QUITE * landing.duration
            && falls.abs() <= NO_RATE * least.size.max(falls.abs())
    }

    /// The rate of a gap where a step begins, and the size of what the gap is the sum of there.
    pub(in crate::analysis::periodic::branch) fn gap_rate(
        &self,
        at: &[f64],
        (index, contact): (usize, usize),
    ) -> (f64, f64) {
        let model = &self.workshop.model;
        let parameters = self.workshop.parameters(self.free(at));
        let start = self.node(at, index);
        let mut graph = model.graph.clone();
        let gap = model.contacts[contact].gap;
        let (mut rate, mut terms) = (0.0, 0.0);
        for (state, of) in model.states.iter().enumerate() {
            let slope = graph.derivative(gap, Symbol::State(state));
            let slope: f64 = graph.evaluate(slope, start, &parameters);
            rate += slope * graph.evaluate(of.derivative, start, &parameters);
            terms += (slope * start[state]).abs();
        }
        (rate, terms)
    }

    /// The acceleration of a contact's gap where a step begins, in flight.
    pub(in crate::analysis::periodic::branch) fn gap_acceleration(
        &self,
        at: &[f64],
        (index, contact): (usize, usize),
    ) -> f64 {
        let model = &self.workshop.model;
        let mut graph = model.graph.clone();
        let field = model.field();
        let rate = graph.lie_derivative(model.contacts[contact].gap, &field);
        let acceleration = graph.lie_derivative(rate, &field);
        let parameters = self.workshop.parameters(self.free(at));
        graph.evaluate(acceleration, self.node(at, index), &parameters)
    }

    /// Whether the impact at the end of a step is plastic: whatever rate comes, none is left. An impact that comes to nothing has none left, either;
    /// but a little later its rate is another, dv = a dt, and it leaves -r of that.
    pub(in crate::analysis::periodic::branch) fn is_plastic(
        &self,
        (index, contact): (usize, usize),
    ) -> bool {
        let (Some(landing), Some(parameters)) = (self.latest.get(index), self.latest_parameters())
        else {
            return false;
        };
        if self.steps[index].impact() != Some(contact) {
            return false;
        }
        let model = &self.workshop.model;
        let mut graph = model.graph.clone();
        let rate = graph.lie_derivative(model.contacts[contact].gap, &model.field());
        let (mut left, mut terms) = (0.0, landing.surface_acceleration.abs());
        for (state, by) in landing.image_rate.iter().enumerate() {
            let slope = graph.derivative(rate, Symbol::State(state));
            let part = by * graph.evaluate(slope, &landing.image, &parameters);
            left += part;
            terms += part.abs();
        }
        left.abs() <= PLASTIC * terms
    }
}

impl<R: Real> Shooting<R> {
    /// Whether a step slides along a surface.
    pub(super) fn slides_along(&self, step: &Step, surface: usize) -> bool {
        let origin = self.workshop.system.origin_of(step.mode());
        origin.is_some_and(|(_, sides, _)| sides.get(surface) == Side::Sliding)
    }

    /// Whether a step leads back to a surface that the impact before it takes the state off, to slide along it: it takes as little time as that
    /// impact has rate.
    pub(in crate::analysis::periodic) fn is_way_back(&self, index: usize) -> bool {
        let before = self.before(index);
        let [first, back] = [before, index].map(|k| &self.steps[k]);
        let (Some(_), Some((_, surface))) = (first.impact(), turn(back)) else {
            return false;
        };
        let is_leg = matches!(first.passage, Passage::Leg(_));
        is_leg
            && self.slides_along(&self.steps[self.after(index)], surface)
            && (self.surface_at_impact(first.mode(), back.mode()) == Some(surface)
                || self.slips_along(first, back, surface))
    }

    /// Whether the impact at the end of a step takes what slides along a surface off it, and the step after that leads back to go on as before.
    pub(super) fn slips_after(&self, index: usize) -> bool {
        let (first, back) = (&self.steps[index], &self.steps[self.after(index)]);
        self.is_way_back(self.after(index))
            && turn(back).is_some_and(|(_, surface)| self.slips_along(first, back, surface))
    }

    fn slips_along(&self, first: &Step, back: &Step, surface: usize) -> bool {
        self.slides_along(first, surface) && !self.slides_along(back, surface)
    }

    /// The surface that an impact takes the state across, and no other: that of the modes before and after it.
    pub(super) fn surface_at_impact(&self, before: usize, after: usize) -> Option<usize> {
        let system = &self.workshop.system;
        let ((grip, sides, on), (other_grip, other_sides, other_on)) =
            (system.origin_of(before)?, system.origin_of(after)?);
        if grip != other_grip {
            return None;
        }
        // What impacts alone ask for is on whichever side the next one is.
        let followed = on.followed.surfaces.or(other_on.followed.surfaces);
        let differ = |surface: &usize| {
            sides.get(*surface) != other_sides.get(*surface)
                && !system.rubs_nowhere(before, *surface)
        };
        let mut surfaces = followed.members().filter(differ);
        let surface = surfaces.next().filter(|_| surfaces.next().is_none())?;
        let slides = |sides: Sides| sides.get(surface) == Side::Sliding;
        (!slides(sides) && !slides(other_sides)).then_some(surface)
    }
}

/// The leg of a step that ends by crossing a surface, and that surface.
fn turn(step: &Step) -> Option<(LegKind, usize)> {
    match step.passage {
        Passage::Leg(kind) if kind.jump == Jump::None => match kind.ends_at {
            Some(GuardKind::Switch(surface)) => Some((kind, surface)),
            _ => None,
        },
        _ => None,
    }
}
