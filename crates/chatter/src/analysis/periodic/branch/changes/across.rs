//! What is on the other side of a surface, or beyond the end of a piece.

use super::events::unfollowed;
use super::touch::Stay;
use crate::analysis::continuation::Problem;
use crate::analysis::periodic::closure::Closure;
use crate::analysis::periodic::cycle::itinerary::{Passage, Step};
use crate::analysis::periodic::error::PeriodicError;
use crate::analysis::periodic::shooting::{Shooting, goes_on, mode_there};
use crate::expressions::{Asked, Side};
use crate::flow::leg::{Jump, LegKind};
use crate::flow::{GuardKind, Settings};
use crate::numerics::Real;

/// A state is on a surface if what is left of its guard is less than this part of what the sizes of states make of it.
const ON_SURFACE: f64 = 1e-6;
/// A guard changes if its rate would make more of it in a period than this part of what the sizes of states make of it.
const CHANGES: f64 = 1e-9;

impl<R: Real> Shooting<R> {
    /// The guard at which a step ends to go on beyond it, where nothing else happens.
    pub(super) fn crossed(&self, index: usize) -> Option<GuardKind> {
        let [step, next] = [index, self.after(index)].map(|k| &self.steps[k]);
        let (Passage::Leg(crosses), Passage::Leg(_)) = (step.passage, next.passage) else {
            return None;
        };
        let guard = crosses.ends_at.filter(|_| crosses.jump == Jump::None)?;
        let is_crossed = match guard {
            GuardKind::Switch(surface) => {
                self.surface_at_impact(step.mode(), next.mode()) == Some(surface)
            }
            GuardKind::Piece(..) => true,
            _ => false,
        };
        is_crossed.then_some(guard)
    }
}

impl Shooting<f64> {
    /// The mode, and the pieces of lookups, beyond a guard of a step, or on its surface, where a state is.
    pub(super) fn other_side(
        &self,
        at: &[f64],
        (step, guard, stay): (&Step, GuardKind, Stay),
        state: &[f64],
    ) -> Result<(usize, Vec<i64>), PeriodicError> {
        let system = &self.workshop.system;
        let mut pieces = step.pieces.clone();
        match guard {
            GuardKind::Switch(surface) => {
                let origin = system.origin_of(step.mode());
                let (grip, sides, _) = origin.ok_or_else(|| unfollowed("a touch of nothing"))?;
                let other = match (sides.get(surface), stay) {
                    (Side::Sliding, _) => {
                        return Err(unfollowed("a touch of a surface slid along"));
                    }
                    (_, Stay::On) => Side::Sliding,
                    (Side::Above, Stay::Beyond) => Side::Below,
                    (Side::Below, Stay::Beyond) => Side::Above,
                };
                // A surface that only the other side asks for, as that of a choice within a choice, is met there for the first time.
                let sides = sides.with(surface, other);
                let asked = |mode: usize| {
                    let origin = system.origin_of(mode);
                    origin.map_or_else(Asked::default, |(.., on)| on.followed)
                };
                let parameters = self.workshop.parameters(self.free(at));
                let known = (asked(step.mode()), (state, &*parameters));
                let mode = mode_there(system, (grip, sides, &mut pieces), &asked, known);
                match system.program(mode) {
                    Some(_) => Ok((mode, pieces)),
                    None => Err(unfollowed("a stay on what is not slid along")),
                }
            }
            GuardKind::Piece(lookup, side) if stay == Stay::Beyond => {
                pieces[lookup] += if side == Side::Above { 1 } else { -1 };
                Ok((step.mode(), pieces))
            }
            _ => Err(unfollowed("a touch of what has no sides")),
        }
    }

    /// Whether the field goes on as it is across a surface that is met with the corner which ends a step: which of both comes first, if both come, is nothing
    /// that happens then.
    pub(super) fn has_kink_at_end(&self, at: &[f64], (index, guard): (usize, GuardKind)) -> bool {
        let step = &self.steps[index];
        let (GuardKind::Switch(surface), Passage::Leg(kind)) = (guard, step.passage) else {
            return false;
        };
        if kind.jump != Jump::None {
            return false;
        }
        let (Ok(state), Some(beyond)) = (
            self.before_event(at, index),
            self.mode_beyond(step.mode(), surface),
        ) else {
            return false;
        };
        let parameters = self.workshop.parameters(self.free(at));
        let all = self.parameters_of(&parameters, step);
        let fields =
            [step.mode(), beyond].map(|mode| self.workshop.system.field_of(mode, &all, &state));
        let [Some(own), Some(other)] = fields else {
            return false;
        };
        goes_on([&own, &other], &self.state_sizes(), self.period())
    }

    /// A guard of a step where a state is, and its rate there, each against what the sizes of states make of the guard, the rate in a period.
    fn guard_where(
        &self,
        at: &[f64],
        (index, guard): (usize, GuardKind),
        state: &[f64],
    ) -> Option<(f64, f64)> {
        let step = &self.steps[index];
        let kind = LegKind {
            mode: step.mode(),
            ends_at: Some(guard),
            jump: Jump::None,
        };
        let leg = self.workshop.leg(kind)?;
        let parameters = self.workshop.parameters(self.free(at));
        let all = self.parameters_of(&parameters, step);
        let landing = leg.at_once(&mut leg.flyer(&Settings::default()), &all, state);
        let parts = landing.surface_slopes.iter().zip(self.scales());
        let states = self.workshop.model.states.len();
        let parts = parts.take(states).map(|(slope, size)| (slope * size).abs());
        let size = parts.fold(0.0, f64::max);
        Some((
            landing.surface / size,
            landing.surface_rate * self.period() / size,
        ))
    }

    /// Whether a guard of a step is not zero just before the event that this begins with, or just after the one that it ends with.
    pub(super) fn jumps_off(
        &self,
        at: &[f64],
        (index, guard): (usize, GuardKind),
        is_start: bool,
    ) -> bool {
        let parameters = self.workshop.parameters(self.free(at));
        let Ok(turns) = self.workshop.closure.turns::<f64>(&parameters) else {
            return false;
        };
        let (state, turns_on) = match is_start {
            true => {
                let before = self.before(index);
                let Ok(state) = self.before_event(at, before) else {
                    return false;
                };
                (state, if index == 0 { -1 } else { 0 })
            }
            false => {
                let next = self.after(index);
                (self.node(at, next).to_vec(), i64::from(next == 0))
            }
        };
        let counts: Vec<i64> = self.counts.iter().map(|count| count * turns_on).collect();
        let state = Closure::later(&turns, &counts, &state);
        let known = self.guard_where(at, (index, guard), &state);
        known.is_some_and(|(value, _)| value.abs() > ON_SURFACE)
    }

    /// Whether the field leads to the side of a guard on which it is positive from where a step begins.
    pub(super) fn leads_away(&self, at: &[f64], (index, guard): (usize, GuardKind)) -> bool {
        let known = self.guard_where(at, (index, guard), self.node(at, index));
        known.is_some_and(|(_, rate)| rate > CHANGES)
    }

    /// Whether it leads to the surface there.
    pub(super) fn leads_onto(&self, at: &[f64], (index, guard): (usize, GuardKind)) -> bool {
        let known = self.guard_where(at, (index, guard), self.node(at, index));
        known.is_some_and(|(_, rate)| rate < -CHANGES)
    }
}
