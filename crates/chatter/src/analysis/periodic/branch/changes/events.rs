//! The equations of an orbit with an event more, where a guard touches zero, and with one less.

use crate::analysis::periodic::closure::Closure;
use crate::analysis::periodic::cycle::itinerary::{Passage, Step, around};
use crate::analysis::periodic::cycle::rotate::rotate;
use crate::analysis::periodic::error::PeriodicError;
use crate::analysis::periodic::shooting::{Shooting, lies_on};
use crate::expressions::Side;
use crate::flow::GuardKind;
use crate::flow::leg::{Jump, Least, LegKind, StretchKind};

/// A least value so near to the end of a leg, in parts of its duration, is there.
const AT_ONCE: f64 = 1e-9;

impl Shooting<f64> {
    /// The same orbit with an impact of rate zero, or with a surface that is touched, where a guard has its least value on a
    /// step, and the step that it ends.
    pub(crate) fn with_event(
        &self,
        at: &[f64],
        index: usize,
        least: &Least,
    ) -> Result<(Self, Vec<f64>, usize), PeriodicError> {
        let jump = match least.guard {
            GuardKind::Gap(contact) => Jump::Impact(contact),
            _ => Jump::None,
        };
        let mut steps = self.current_steps(at);
        let whole = steps[index].clone();
        let touches = |mode: usize| {
            let kind = LegKind {
                mode,
                ends_at: Some(least.guard),
                jump,
            };
            let (kind, pieces) = self.to_impact(at, kind, (&least.state, &whole));
            (Passage::Leg(kind), pieces)
        };
        let index = match whole.passage {
            Passage::Leg(_) if let Some(place) = self.corner_at_least(index, least) => {
                let mode = steps[place].mode();
                (steps[place].passage, steps[place].pieces) = touches(mode);
                place
            }
            Passage::Leg(kind) => {
                let (passage, pieces) = touches(kind.mode);
                let first = Step {
                    passage,
                    pieces,
                    duration: least.time,
                    told: Vec::new(),
                    closed: self.closed_before(index),
                    ..whole.clone()
                };
                let second = Step {
                    start: least.state.clone(),
                    duration: whole.duration - least.time,
                    ..whole
                };
                steps.splice(index..=index, [first, second]);
                index
            }
            // Nothing else happens: one leg from the touch to the next one.
            Passage::Timed(kind) | Passage::Around(kind) => {
                let period = steps.iter().map(|step| step.duration).sum();
                let (passage, pieces) = touches(kind.mode);
                steps = vec![Step {
                    passage,
                    pieces,
                    start: least.state.clone(),
                    duration: period,
                    ..whole
                }];
                0
            }
            Passage::Stretch(_) if jump == Jump::None => {
                let parts = self.with_touch_at_rest(at, index, least)?;
                steps.splice(index..=index, parts);
                index + 1
            }
            Passage::Stretch(_) => {
                return Err(unfollowed("a graze within what is followed as a whole"));
            }
            Passage::AtOnce(_) | Passage::Together(_) => {
                return Err(unfollowed("a graze at the instant of an impact"));
            }
        };
        let (shooting, at) = self.like(steps, at)?;
        Ok((shooting, at, index))
    }

    /// The step that ends with a corner of the field at the very instant at which the force of a contact is least, as that of drag which turns where
    /// what shakes the contact does: the force may not change places with it, so that its touch stands for the corner.
    fn corner_at_least(&self, index: usize, least: &Least) -> Option<usize> {
        let GuardKind::Reaction(contact) = least.guard else {
            return None;
        };
        let duration = self.latest.get(index)?.duration;
        let at_once = AT_ONCE * duration;
        let place = match least.time {
            time if time >= duration - at_once => index,
            time if time <= at_once => self.before(index),
            _ => return None,
        };
        let step = &self.steps[place];
        let is_corner = step.flight().is_some_and(|kind| {
            kind.jump == Jump::None && matches!(kind.ends_at, Some(GuardKind::Switch(_)))
        });
        let holds = self.closed_before(place).contains(contact) && step.closed.contains(contact);
        (is_corner && holds).then_some(place)
    }

    /// Whether the impact at the end of a step takes the state off a surface that it slides along there, however weak it is: what
    /// follows is not that mode.
    pub(super) fn impact_takes_off(&self, index: usize) -> bool {
        !self.left_at_impact(index).is_empty()
    }

    /// The surfaces that it takes the state off, each with the side that it leads to.
    pub(super) fn left_at_impact(&self, index: usize) -> Vec<(usize, Side)> {
        let step = &self.steps[index];
        let origin = self.workshop.system.origin_of(step.mode());
        let (Some((_, _, on)), Some(contact)) = (origin, step.impact()) else {
            return Vec::new();
        };
        let (Some(landing), Some(parameters)) = (self.latest.get(index), self.latest_parameters())
        else {
            return Vec::new();
        };
        let mut graph = on.mechanics.graph.clone();
        let zero = graph.number(0.0);
        let jump = &on.mechanics.contacts[contact].jump;
        let mut left = Vec::new();
        for slide in &on.mechanics.slides {
            let by = graph.lie_derivative(slide.surface, jump);
            if by != zero {
                let side = match graph.evaluate(by, &landing.image, &parameters) > 0.0 {
                    true => Side::Above,
                    false => Side::Below,
                };
                left.push((slide.index, side));
            }
        }
        left
    }

    /// On how many steps the orbit slides along each surface.
    pub(in crate::analysis::periodic::branch) fn slides(&self) -> Vec<usize> {
        let system = &self.workshop.system;
        let sides = (self.steps.iter()).filter_map(|step| Some(system.origin_of(step.mode())?.1));
        let sides: Vec<_> = sides.collect();
        let slides = |surface| {
            let on = (sides.iter()).filter(|all| all.get(surface) == Side::Sliding);
            on.count()
        };
        (0..system.corners().surfaces.len()).map(slides).collect()
    }

    /// The same orbit without the event at the end of a step, which leaves the state as it is, and the step that goes on
    /// past it.
    pub(crate) fn without_event(
        &self,
        at: &[f64],
        index: usize,
    ) -> Result<(Self, Vec<f64>, usize), PeriodicError> {
        let mut steps = self.current_steps(at);
        // What shares the instant goes with it.
        let chain = steps[index + 1..]
            .iter()
            .take_while(|step| step.is_at_once());
        let others = index + 1..index + 1 + chain.count();
        if steps[others.clone()]
            .iter()
            .any(|step| matches!(step.passage, Passage::AtOnce(_)))
        {
            return Err(unfollowed("the loss of collisions that share an instant"));
        }
        steps.drain(others);
        let mut index = index;
        if self.slips_after(index) {
            index = self.leave_out_slip(at, &mut steps, index)?;
        }
        let count = steps.len();
        let is_section = matches!(steps[index].ends_at(), Some(GuardKind::Section(_)));
        let kind = match steps[index].passage {
            Passage::Leg(kind) => kind,
            Passage::Stretch(kind) if is_section && count > 1 => kind.last,
            _ => return Err(unfollowed("the loss of what is no event by itself")),
        };
        if count == 1 {
            let timed = LegKind {
                ends_at: None,
                jump: Jump::None,
                ..kind
            };
            // A phase that states hold back takes no time that is known.
            let parameters = self.workshop.parameters(self.free(at));
            let turns = self.workshop.closure.turns(&parameters)?;
            steps[0].passage = match Closure::time_of(&turns, &self.counts) {
                Some(_) => Passage::Timed(timed),
                None if is_section => return Err(unfollowed("the loss of its only event")),
                None => Passage::Around(timed),
            };
            let (shooting, at) = self.like(steps, at)?;
            return Ok((shooting, at, 0));
        }
        if index + 1 == count {
            let parameters = self.workshop.parameters(self.free(at));
            rotate(&self.workshop, &parameters, (&mut steps, &self.counts), 1)?;
            index -= 1;
        }
        let next = index + 1;
        let before = around(index, -1, count);
        let passage = match (steps[index].passage, steps[next].passage) {
            // A section that shares its instant with the end of a piece, or with a switch, stands for that.
            (Passage::Leg(_), Passage::Leg(other))
                if is_section
                    && (other.mode != kind.mode || steps[index].pieces != steps[next].pieces) =>
            {
                return Err(unfollowed("the loss of a section where the mode changes"));
            }
            (Passage::Leg(_), Passage::Leg(other)) if self.moves_alike(kind.mode, other.mode) => {
                Passage::Leg(other)
            }
            (Passage::Leg(_), Passage::Leg(other))
                if let Some(surface) = self.surface_at_impact(kind.mode, other.mode) =>
            {
                steps[index].passage = Passage::Leg(LegKind {
                    ends_at: Some(GuardKind::Switch(surface)),
                    jump: Jump::None,
                    ..kind
                });
                // With the impact goes the way back to what it took the state off.
                let after = around(next, 1, count);
                if steps[next].ends_at() == Some(GuardKind::Switch(surface))
                    && self.slides_along(&steps[after], surface)
                {
                    steps.remove(next);
                }
                let (shooting, at) = self.like(steps, at)?;
                return Ok((shooting, at, index));
            }
            // Sections are crossed on the way of what is followed as a whole.
            (Passage::Leg(_), Passage::Stretch(whole)) if is_section => {
                Passage::Stretch(StretchKind {
                    closed: steps[before].closed,
                    on: lies_on(&self.workshop.system, &steps, before),
                    ..whole.up_to(whole.last)
                })
            }
            (Passage::Stretch(whole), Passage::Leg(last))
                if self.moves_alike(kind.mode, last.mode) =>
            {
                Passage::Stretch(whole.up_to(last))
            }
            (Passage::Stretch(first), Passage::Stretch(whole)) => Passage::Stretch(StretchKind {
                accumulations: first.accumulations + whole.accumulations,
                joint: first.joint || whole.joint,
                ..first.up_to(whole.last)
            }),
            _ => {
                return Err(unfollowed("the loss of an event between different modes"));
            }
        };
        let merged = Step {
            passage,
            start: steps[index].start.clone(),
            duration: steps[index].duration + steps[next].duration,
            ..steps[next].clone()
        };
        steps.splice(index..=next, [merged]);
        let (shooting, at) = self.like(steps, at)?;
        Ok((shooting, at, index))
    }

    /// Leaves out the slip after the impact at the end of a step; which step that is then.
    fn leave_out_slip(
        &self,
        at: &[f64],
        steps: &mut Vec<Step>,
        index: usize,
    ) -> Result<usize, PeriodicError> {
        let (slip, index) = self.take_out_after(at, steps, index)?;
        let next = around(index, 1, steps.len());
        if next != index {
            steps[next].start = slip.start;
        }
        steps[next].duration += slip.duration;
        Ok(index)
    }

    /// Takes out the step after another one, and says which that is then: what comes after both is of the same turn, where it is not the step
    /// before them.
    pub(super) fn take_out_after(
        &self,
        at: &[f64],
        steps: &mut Vec<Step>,
        index: usize,
    ) -> Result<(Step, usize), PeriodicError> {
        let count = steps.len();
        let by = match count {
            2 => index,
            _ => (index + 3).saturating_sub(count),
        };
        if by > 0 {
            let parameters = self.workshop.parameters(self.free(at));
            rotate(&self.workshop, &parameters, (steps, &self.counts), by)?;
        }
        let index = index - by;
        Ok((steps.remove(index + 1), index))
    }

    /// Equations of other steps of the same system, and a guess of their solution.
    pub(in crate::analysis::periodic) fn like(
        &self,
        steps: Vec<Step>,
        at: &[f64],
    ) -> Result<(Self, Vec<f64>), PeriodicError> {
        self.like_with(steps, self.counts.clone(), at)
    }

    /// The same where phases turn so often in a period.
    pub(in crate::analysis::periodic) fn like_with(
        &self,
        steps: Vec<Step>,
        counts: Vec<i64>,
        at: &[f64],
    ) -> Result<(Self, Vec<f64>), PeriodicError> {
        let mut shooting = Self::new(&self.workshop, steps, counts)?;
        shooting.keep_sizes(&self.state_sizes());
        shooting.told.clone_from(&self.told);
        let guess = shooting.guess(self.free(at));
        Ok((shooting, guess))
    }
}

pub(super) fn unfollowed(what: &str) -> PeriodicError {
    PeriodicError::Unfollowed {
        what: what.to_owned(),
    }
}
