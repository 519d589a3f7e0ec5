//! What there is to see on the way of an orbit: least values, crossings of the section, what happens within a stretch.

use super::{Flown, Shooting, lies_on};
use crate::analysis::continuation::Left;
use crate::analysis::periodic::cycle::itinerary::Passage;
use crate::analysis::periodic::cycle::trace::{Instant, Tracer};
use crate::expressions::Expr;
use crate::flow::leg::{Least, LegKind};
use crate::flow::{Closed, GuardKind};
use crate::model::Direction;
use crate::numerics::Real;
use core::ops::ControlFlow;

/// A stretch that is traced once more ends within this part of its duration.
const BEYOND_END: f64 = 1e-12;

impl<R: Real> Shooting<R> {
    /// Whether a state on the surface of a guard stays on it all along a step.
    pub(crate) fn stands_on(&self, index: usize, guard: GuardKind) -> bool {
        matches!(&self.flown[index], Flown::Leg(leg, _) if leg.stays_on(guard))
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

    /// The latest point looked at.
    pub(crate) fn watching(&self) -> Option<&[f64]> {
        self.watching.as_deref()
    }

    /// All parameters at the latest point looked at.
    pub(crate) fn latest_parameters(&self) -> Option<Vec<f64>> {
        let at = self.watching.as_ref()?;
        Some(self.workshop.parameters(self.free(at)))
    }

    /// Where the first leg leads in a time.
    pub(crate) fn flown_on(&mut self, at: &[f64], time: f64) -> Option<Vec<f64>> {
        let parameters = self.workshop.parameters(self.free(at));
        let all = self.parameters_of(&parameters, &self.steps[0]);
        let Flown::Leg(leg, flyer) = &self.flown[0] else {
            return None;
        };
        let x = &at[..self.workshop.model.states.len()];
        let landing = leg.fly(&mut self.flyers[*flyer].1, &all, x, time).ok()?;
        Some(landing.image)
    }

    fn look(&mut self, at: &[f64]) -> Result<Vec<Vec<Least>>, Left> {
        let n = self.workshop.model.states.len();
        let parameters = self.workshop.parameters(self.free(at));
        let mut found = Vec::with_capacity(self.steps.len());
        for index in 0..self.steps.len() {
            let all = self.parameters_of(&parameters, &self.steps[index]);
            let place = self.places[index];
            let x = &at[place..place + n];
            if self.steps[index].is_at_once() {
                found.push(Vec::new());
                continue;
            }
            let Flown::Leg(leg, flyer) = &self.flown[index] else {
                found.push(self.crossings_within(index, at));
                continue;
            };
            let duration = match self.steps[index].passage {
                Passage::Leg(_) | Passage::Around(_) => at[place + n],
                _ => self
                    .latest
                    .get(index)
                    .map_or(self.steps[index].duration, |l| l.duration),
            };
            if duration <= 0.0 {
                found.push(Vec::new());
                continue;
            }
            let (leg, flyer) = (leg.clone(), *flyer);
            let zeros = self.begins_on(index);
            let begins_on = |guard: GuardKind| zeros.contains(&guard);
            let flyer = &mut self.flyers[flyer].1;
            let mut seen =
                (leg.least(flyer, &all, (x, duration), &begins_on)).map_err(Left::because)?;
            // On a way that no event ends its ends are a place like others: a least value may be just there.
            if self.steps[index].ends_at().is_none() {
                seen.iter_mut().for_each(|least| least.at_end = false);
            }
            found.push(seen);
        }
        Ok(found)
    }

    /// The functions of the surfaces on which a step stands still, from where it begins.
    pub(crate) fn surfaces_stood_on(&self, index: usize) -> Vec<Expr> {
        let surfaces = &self.workshop.system.corners().surfaces;
        let on = self.begins_on(index).into_iter();
        on.filter(|&guard| self.stands_on(index, guard))
            .filter_map(|guard| match guard {
                GuardKind::Switch(surface) => surfaces.get(surface).copied(),
                _ => None,
            })
            .collect()
    }

    /// Guards that are zero by the equations where a step begins: gaps of contacts that were struck, held or just released, and surfaces
    /// that it has just crossed, left, or had an event at, or that a step before has crossed to stand still there.
    fn begins_on(&self, index: usize) -> Vec<GuardKind> {
        self.begins_on_since(index, self.steps.len())
    }

    /// The same, as far as so many steps say.
    fn begins_on_since(&self, index: usize, steps: usize) -> Vec<GuardKind> {
        let count = self.steps.len();
        let before = self.before(index);
        let on = lies_on(&self.workshop.system, &self.steps, before);
        let touching = Closed(on.0 | self.closed_before(index).0);
        let mut zeros: Vec<GuardKind> = touching.contacts().map(GuardKind::Gap).collect();
        // What came first at that instant, and then what its jump has brought about, which lies beyond its own surface.
        let others = (0..count - 1).take_while(|&back| self.step_back(before, back).1.is_at_once());
        let others = others.count();
        let (first, _) = self.step_back(before, others);
        let mut on = match &self.flown[first] {
            Flown::Leg(leg, _) if leg.stands_on_any() && steps > 0 => {
                let mut on = self.begins_on_since(first, steps - 1);
                on.retain(|&guard| leg.stays_on(guard));
                on
            }
            _ => Vec::new(),
        };
        for back in (0..=others).rev() {
            let (place, step) = self.step_back(before, back);
            let keeps = |guard: GuardKind| match &self.flown[place] {
                Flown::Leg(leg, _) => leg.keeps(guard),
                Flown::Stretch(..) => false,
            };
            on.retain(|&guard| keeps(guard));
            let begins_on = |guard: GuardKind| match guard {
                GuardKind::Reaction(contact) => Some(GuardKind::Gap(contact)),
                _ if !keeps(guard) => None,
                GuardKind::Leave(surface, _) => Some(GuardKind::Switch(surface)),
                GuardKind::Section(_) => (!step.is_at_once()).then_some(guard),
                _ => guard.opposite(),
            };
            on.extend(step.ends_at().and_then(begins_on));
        }
        zeros.extend(on);
        zeros
    }

    /// How far beyond the surface of its event the state is at a step that takes no time, if a jump has brought that event about: negative
    /// where it is still on the side that it came from. After an evaluation, with the least values there.
    pub(crate) fn carried(&self, index: usize, least: &[Vec<Least>]) -> Option<f64> {
        let Passage::AtOnce(LegKind {
            ends_at: Some(guard @ GuardKind::Section(section)),
            ..
        }) = self.steps[index].passage
        else {
            return None;
        };
        let beyond = -self.latest.get(index)?.surface;
        let told = &self.workshop.model.sections[section];
        if told.direction != Direction::Either {
            return Some(beyond);
        }
        // What comes both on the way up and down says by where it came from which of them this is.
        let (before, step) = self.step_back(index, 1);
        let came_from = match step.is_at_once() {
            true => Some(self.node(self.watching.as_ref()?, before)),
            false => (least.get(before)?.iter())
                .find(|least| least.at_end && least.guard == guard)
                .map(|least| &*least.state),
        };
        let graph = &self.workshop.model.graph;
        let known = self.latest_parameters()?;
        let side = came_from.map_or(beyond, |state| graph.evaluate(told.surface, state, &known));
        Some(beyond * side.signum())
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
            size: 0.0,
            state: instant.state,
            at_end: false,
        };
        crossed.map(told).collect()
    }
}
