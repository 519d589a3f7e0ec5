//! A stick, a slide, or a way beyond a surface, that an impact or a reset cuts short, and that begins just there. On its other side the event comes first, and takes
//! the state off before it sticks or crosses. So it is with the tick of a clock that makes the field jump, and so lets go at once of what it held, as the
//! next pulse does of a current that has come to its end; and where what slides has just turned as its contact is released: without a force there is no
//! friction, and in flight the turn is no event. The branch goes on without it to where that is the motion, on in the parameter or back, and from there the same
//! way in.

use super::events::unfollowed;
use super::touch::Stay;
use crate::analysis::continuation::{Curve, Left, Problem, Station};
use crate::analysis::periodic::branch::Point;
use crate::analysis::periodic::branch::walker::{Stop, Walker};
use crate::analysis::periodic::cycle::itinerary::{Passage, Step};
use crate::analysis::periodic::error::PeriodicError;
use crate::analysis::periodic::shooting::Shooting;
use crate::expressions::Side;
use crate::flow::GuardKind;
use crate::flow::leg::{Jump, LegKind};
use crate::numerics::Real;

/// What a stick brings about in a period is nothing if it is less than this part of what would be without it.
const STANDS: f64 = 1e-9;

impl<R: Real> Shooting<R> {
    /// The guard of the event before a step that slides along its surface since then, or goes on beyond it, where its own event is a jump and no end of
    /// that, or a corner after which the state is back where it came from, or leaves nothing that asks for it.
    pub(in crate::analysis::periodic) fn cut_short(
        &self,
        index: usize,
    ) -> Option<(GuardKind, Stay)> {
        let before = self.before(index);
        let [first, step] = [before, index].map(|k| &self.steps[k]);
        let (Passage::Leg(meets), Passage::Leg(ends)) = (first.passage, step.passage) else {
            return None;
        };
        if meets.jump != Jump::None || self.steps.len() < 2 {
            return None;
        }
        let guard = meets.ends_at?;
        if self.releases_what_turns(index, guard) {
            return Some((guard, Stay::Beyond));
        }
        if !(jumps(ends) || self.is_let_go(index, guard)) {
            return None;
        }
        if let GuardKind::Switch(surface) = guard
            && self.slides_along(step, surface)
        {
            return (!self.slides_along(first, surface)).then_some((guard, Stay::On));
        }
        (self.crossed(before) == Some(guard)).then_some((guard, Stay::Beyond))
    }

    /// Whether the event at the end of a step is that a contact is released, and a guard that its sliding turns: in flight that is no event.
    fn releases_what_turns(&self, index: usize, guard: GuardKind) -> bool {
        match (self.steps[index].passage, self.steps[index].ends_at()) {
            (Passage::Leg(kind), Some(GuardKind::Reaction(contact))) => {
                kind.jump == Jump::None && self.is_turn(contact, guard)
            }
            _ => false,
        }
    }

    /// Whether a step stays on the surface of a guard to another corner, at which it goes on at once to the side that it has come from.
    fn is_let_go(&self, index: usize, guard: GuardKind) -> bool {
        let (before, after) = (self.before(index), self.after(index));
        let [first, step, next] = [before, index, after].map(|k| &self.steps[k]);
        let (GuardKind::Switch(surface), Passage::Leg(ends), Passage::Leg(_)) =
            (guard, step.passage, next.passage)
        else {
            return false;
        };
        let is_corner = matches!(ends.ends_at, Some(GuardKind::Switch(other)) if other != surface);
        let sides = [first, step, next].map(|step| {
            let origin = self.workshop.system.origin_of(step.mode());
            origin.map(|(_, sides, _)| sides.get(surface))
        });
        let is_back = sides[0] == sides[2] && sides[0] != sides[1];
        let stays = sides[1] == Some(Side::Sliding) || self.stands_on(index, guard);
        let meets = self.meets(first.mode(), ends.ends_at);
        is_corner && is_back && stays && meets && ends.jump == Jump::None
    }
}

/// Whether a leg ends with a jump.
fn jumps(kind: LegKind) -> bool {
    matches!(kind.jump, Jump::Impact(_) | Jump::Reset(_))
}

impl Shooting<f64> {
    /// The same orbit without such a step, which takes no time: what cuts it short comes at the end of the step before. That step.
    fn without_hold(
        &self,
        at: &[f64],
        index: usize,
    ) -> Result<(Self, Vec<f64>, usize), PeriodicError> {
        let mut steps = self.current_steps(at);
        let before = self.before(index);
        let held = steps[index].clone();
        if let (Passage::Leg(meets), Passage::Leg(ends)) = (steps[before].passage, held.passage) {
            let passage = Passage::Leg(LegKind {
                mode: meets.mode,
                ..ends
            });
            steps[before].passage = passage;
            steps[before].duration += held.duration;
            steps[before].told = held.told;
            steps[before].closed = held.closed;
        }
        steps.remove(index);
        let (shorter, at) = self.like(steps, at)?;
        let last = shorter.steps.len() - 1;
        Ok((shorter, at, index.checked_sub(1).unwrap_or(last)))
    }

    /// The same orbit with such a step of no time before the event at the end of another one, which comes to the surface of this guard. The new step.
    fn with_hold(
        &self,
        at: &[f64],
        (index, guard, stay): (usize, GuardKind, Stay),
    ) -> Result<(Self, Vec<f64>, usize), PeriodicError> {
        let unknown = || unfollowed("what an event cuts short");
        let mut steps = self.current_steps(at);
        let Passage::Leg(kind) = steps[index].passage else {
            return Err(unknown());
        };
        let there = self.before_event(at, index)?;
        let (mode, pieces) = self.other_side(at, (&steps[index], guard, stay), &there)?;
        let held = Step {
            passage: Passage::Leg(LegKind { mode, ..kind }),
            pieces,
            duration: 0.0,
            ..steps[index].clone()
        };
        steps[index].passage = Passage::Leg(LegKind {
            ends_at: Some(guard),
            jump: Jump::None,
            ..kind
        });
        steps[index].told = Vec::new();
        if self.releases_what_turns(index, guard) {
            steps[index].closed = self.closed_before(index);
        }
        steps.insert(index + 1, held);
        let (mut longer, mut guess) = self.like(steps, at)?;
        if longer.cut_short(index + 1) != Some((guard, stay)) {
            return Err(unknown());
        }
        // It begins where the step before ends.
        let left = |left: Left| PeriodicError::NoConvergence {
            how: left.to_string(),
        };
        longer.evaluate(&guess).map_err(left)?;
        guess[longer.node_places(index + 1)].copy_from_slice(&longer.latest[index].image);
        Ok((longer, guess, index + 1))
    }

    /// Whether what keeps a step on a surface that it slides along does so where it begins: where the field does not jump there, as that of quadratic
    /// drag, nothing does.
    fn stays_on(&self, at: &[f64], (index, surface): (usize, usize)) -> bool {
        let room = |side: Side| {
            let mut watching = self.clone();
            let watched = watching.watch_start(index, GuardKind::Leave(surface, side));
            let function = watching.corner_function();
            let room = || watching.monitor(function, at).map(|(room, _)| room);
            watched.is_ok().then(room)
        };
        let rooms: Vec<_> = [Side::Above, Side::Below]
            .into_iter()
            .filter_map(room)
            .collect();
        let is_there = |room: &Result<f64, Left>| room.as_ref().is_ok_and(|room| *room >= 0.0);
        !rooms.is_empty() && rooms.iter().all(is_there)
    }

    /// Whether the jump at the end of a step takes the state off the surface that the step before has come to, or the field after the corner there leads
    /// it off, or nothing asks for that any more.
    fn leaves_surface(&self, at: &[f64], (index, guard, stay): (usize, GuardKind, Stay)) -> bool {
        match self.steps[index].passage {
            _ if self.releases_what_turns(index, guard) => true,
            Passage::Leg(kind) if !jumps(kind) => self.leads_away(at, (self.after(index), guard)),
            _ if stay == Stay::On => true,
            _ => {
                (guard.opposite()).is_some_and(|inside| self.jumps_off(at, (index, inside), false))
            }
        }
    }

    /// Whether it shows in derivatives that a step has crossed a surface just before the next one ends there: where a contact is released it has no force,
    /// and so no friction.
    fn shows(&self, crosses: usize, (guard, stay): (GuardKind, Stay)) -> bool {
        let is_nothing =
            self.releases_what_turns(self.after(crosses), guard) || self.is_smooth(crosses);
        !(stay == Stay::Beyond && is_nothing)
    }

    /// Whether a step that comes in after another one stays on the surface where it begins, or goes on beyond it.
    fn stays(&self, at: &[f64], (index, guard, stay): (usize, GuardKind, Stay)) -> bool {
        match (stay, guard, guard.opposite()) {
            (Stay::On, GuardKind::Switch(surface), _) => self.stays_on(at, (index, surface)),
            (Stay::Beyond, _, Some(inside)) => {
                self.stands_on(index, inside) || self.leads_away(at, (index, inside))
            }
            _ => false,
        }
    }
}

impl Walker {
    /// On from where a stick, a slide or a way beyond a surface that the event at its end cuts short takes no time any more; none where that event and the
    /// crossing change places.
    pub(super) fn hold_vanishes(
        &mut self,
        way: (&mut Curve, f64),
        (station, index): (&Station, usize),
        here: &mut Point,
    ) -> Option<Stop> {
        self.settle(station);
        let (guard, stay) = self.shooting.cut_short(index)?;
        let before = self.shooting.before(index);
        if !self
            .shooting
            .leaves_surface(&station.at, (index, guard, stay))
        {
            return None;
        }
        let is_told = self.shooting.shows(before, (guard, stay));
        Some(
            self.moment_vanishes(way, (station, is_told), here, |shooting, at| {
                let (shooting, at, ends) = shooting.without_hold(at, index)?;
                Ok((shooting, at, ((ends, false), guard)))
            }),
        )
    }

    /// On from where a step comes to a surface, or the end of a piece, just at its end: a stick, or a way beyond, comes in that the event there cuts short.
    pub(super) fn hold_comes_in(
        &mut self,
        way: (&mut Curve, f64),
        (station, index, guard): (&Station, usize, GuardKind),
        here: &mut Point,
    ) -> Option<Stop> {
        self.settle(station);
        let changes = self.shooting.latest.get(index)?.surface_acceleration;
        let (stay, longer, held, next) = [Stay::On, Stay::Beyond].into_iter().find_map(|stay| {
            let with = (index, guard, stay);
            let (longer, guess, held) = self.shooting.with_hold(&station.at, with).ok()?;
            let (longer, next) = longer.beginning_with_no_time(&guess, held)?;
            let stays = longer.stays(&next.at, (held, guard, stay));
            stays.then_some((stay, longer, held, next))
        })?;
        // A stick does not come to a wall whose rate it holds at zero: that is a graze.
        let rate = longer.latest.get(held)?.surface_rate;
        if rate.abs() <= STANDS * (changes * longer.period()).abs() {
            return None;
        }
        if !longer.leaves_surface(&next.at, (held, guard, stay)) {
            return None;
        }
        let is_told = longer.shows(index, (guard, stay));
        let watched = ((index, false), guard);
        self.moment_comes_in(way, (station, watched, is_told), Ok((longer, next)), here)
    }
}
