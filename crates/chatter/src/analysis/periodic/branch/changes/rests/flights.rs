//! An orbit with a flight beside a rest, and without it.

use crate::analysis::periodic::branch::changes::events::unfollowed;
use crate::analysis::periodic::cycle::itinerary::{Passage, Step};
use crate::analysis::periodic::cycle::rotate::rotate;
use crate::analysis::periodic::error::PeriodicError;
use crate::analysis::periodic::shooting::Shooting;
use crate::flow::leg::{Jump, LegKind};
use crate::flow::{Grip, GuardKind, Settings};

/// Where a contact rests: the step, the contact, and at which of the step's ends there is a flight, or may be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rests {
    pub index: usize,
    pub contact: usize,
    pub beside: Beside,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Beside {
    Start,
    End,
}

impl Shooting<f64> {
    /// The same orbit without such a flight, and the step that rests where it was.
    pub(super) fn without_flight(
        &self,
        at: &[f64],
        (index, beside): (usize, Beside),
    ) -> Result<(Self, Vec<f64>, usize), PeriodicError> {
        match beside {
            Beside::Start => self.without_flight_to_rest(at, index),
            Beside::End => self.without_flight_to_corner(at, index),
        }
    }

    fn without_flight_to_corner(
        &self,
        at: &[f64],
        index: usize,
    ) -> Result<(Self, Vec<f64>, usize), PeriodicError> {
        let mut steps = self.current_steps(at);
        let before = self.before(index);
        let flight = steps[index].clone();
        let rest = &mut steps[before];
        let (Passage::Leg(rests), Passage::Leg(flies)) = (rest.passage, flight.passage) else {
            return Err(unfollowed("a rest that is no leg"));
        };
        rest.passage = Passage::Leg(LegKind {
            mode: rests.mode,
            ..flies
        });
        rest.duration += flight.duration;
        rest.closed = flight.closed;
        rest.told.extend(flight.told);
        steps.remove(index);
        let (shorter, at) = self.like(steps, at)?;
        let last = shorter.steps.len() - 1;
        Ok((shorter, at, index.checked_sub(1).unwrap_or(last)))
    }

    fn without_flight_to_rest(
        &self,
        at: &[f64],
        index: usize,
    ) -> Result<(Self, Vec<f64>, usize), PeriodicError> {
        let mut steps = self.current_steps(at);
        let mut index = index;
        if index + 1 == steps.len() {
            // What rests is to be of the same turn.
            let parameters = self.workshop.parameters(self.free(at));
            rotate(
                &self.workshop,
                &parameters,
                (&mut steps, &self.counts),
                index,
            )?;
            index = 0;
        }
        let flight = steps.remove(index);
        let before = index.checked_sub(1).unwrap_or(steps.len() - 1);
        steps[before].closed = flight.closed;
        let rest = &mut steps[index];
        rest.start = flight.start;
        rest.duration += flight.duration;
        let (shorter, at) = self.like(steps, at)?;
        Ok((shorter, at, index))
    }

    /// The same orbit with a flight of this duration beside a rest, and where its duration stands among the unknowns.
    pub(super) fn with_flight(
        &self,
        at: &[f64],
        (rests, duration): (Rests, f64),
    ) -> Result<(Self, Vec<f64>, usize), PeriodicError> {
        let (longer, at, index) = match rests.beside {
            Beside::Start => self.with_flight_to_rest(at, (rests, duration))?,
            Beside::End => self.with_flight_to_corner(at, (rests, duration))?,
        };
        let place = longer.duration_place(index);
        let place = place.ok_or_else(|| unfollowed("a flight without duration"))?;
        Ok((longer, at, place))
    }

    /// The mode of a step that rests on a contact, but for that.
    fn without_contact(&self, rest: &Step, contact: usize) -> Result<usize, PeriodicError> {
        let Some(LegKind { mode, .. }) = rest.flight() else {
            return Err(unfollowed("a rest that is no leg"));
        };
        let system = &self.workshop.system;
        let (grip, sides, _) =
            (system.origin_of(mode)).ok_or_else(|| unfollowed("a mode that holds no motion"))?;
        let open = Grip {
            closed: grip.closed.without(contact),
            idle: grip.idle.without(contact),
        };
        let mode = system.meet(open, sides);
        if system.program(mode).is_none() {
            return Err(unfollowed("a flight in a mode that holds no motion"));
        }
        Ok(mode)
    }

    /// The contact is released before the corner that the step ends at.
    fn with_flight_to_corner(
        &self,
        at: &[f64],
        (rests, duration): (Rests, f64),
    ) -> Result<(Self, Vec<f64>, usize), PeriodicError> {
        let Rests { index, contact, .. } = rests;
        let mut steps = self.current_steps(at);
        let mode = self.without_contact(&steps[index], contact)?;
        let Passage::Leg(kind) = steps[index].passage else {
            return Err(unfollowed("a rest that is no leg"));
        };
        let released = LegKind {
            ends_at: Some(GuardKind::Reaction(contact)),
            jump: Jump::None,
            ..kind
        };
        let way = steps[index].duration - duration;
        let parameters = self.workshop.parameters(self.free(at));
        let all = self.parameters_of(&parameters, &steps[index]);
        let start = self.workshop.leg(released).and_then(|leg| {
            let mut flyer = leg.flyer(&Settings::default());
            let landing = leg.fly(&mut flyer, &all, self.node(at, index), way).ok()?;
            Some(landing.image)
        });
        let start = start.ok_or_else(|| unfollowed("a rest as short as the flight after it"))?;
        let rest = steps[index].clone();
        let rest_alone = Step {
            passage: Passage::Leg(released),
            duration: way,
            closed: self.closed_before(index).without(contact),
            told: Vec::new(),
            ..rest.clone()
        };
        let flight = Step {
            passage: Passage::Leg(LegKind { mode, ..kind }),
            start,
            duration,
            ..rest
        };
        steps.splice(index..=index, [rest_alone, flight]);
        let (longer, at) = self.like(steps, at)?;
        Ok((longer, at, index + 1))
    }

    /// The contact is struck first where the step begins.
    fn with_flight_to_rest(
        &self,
        at: &[f64],
        (rests, duration): (Rests, f64),
    ) -> Result<(Self, Vec<f64>, usize), PeriodicError> {
        let Rests { index, contact, .. } = rests;
        let mut steps = self.current_steps(at);
        let mode = self.without_contact(&steps[index], contact)?;
        let kind = LegKind {
            mode,
            ends_at: Some(GuardKind::Gap(contact)),
            jump: Jump::Impact(contact),
        };
        let rest = steps[index].clone();
        let (kind, pieces) = self.to_impact(at, kind, (&rest.start, &rest));
        let parameters = self.workshop.parameters(self.free(at));
        let model = &self.workshop.model;
        let later = (rest.start.iter().zip(&model.states)).map(|(x, state)| {
            let rate: f64 = model
                .graph
                .evaluate(state.derivative, &rest.start, &parameters);
            x + duration * rate
        });
        let later = later.collect();
        let flight = Step {
            passage: Passage::Leg(kind),
            pieces,
            duration,
            told: Vec::new(),
            closed: self.closed_before(index),
            ..rest
        };
        let before = self.before(index);
        steps[before].closed = steps[before].closed.without(contact);
        steps[index].start = later;
        steps[index].duration -= duration;
        steps.insert(index, flight);
        let (longer, at) = self.like(steps, at)?;
        Ok((longer, at, index))
    }
}
