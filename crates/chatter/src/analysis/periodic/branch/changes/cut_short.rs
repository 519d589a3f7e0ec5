//! A stick or a slide that an impact or a reset cuts short, and that begins just there: its time, of either sign, is an unknown like others
//! beside that place. Beyond it the event comes first, and takes the state off before it sticks. The branch goes on without the stick
//! to where that is the motion, on in the parameter or back, and from there the same way in.

use super::graze::{THERE, moved};
use crate::analysis::continuation::{Condition, Curve, Left, Problem, Station, newton, tangent};
use crate::analysis::periodic::branch::Point;
use crate::analysis::periodic::branch::limits::End;
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
    /// The surface that a step slides along since the event before it, where its own event is a jump and no end of that.
    pub(in crate::analysis::periodic) fn cut_short(&self, index: usize) -> Option<usize> {
        let [first, held] = [self.before(index), index].map(|k| &self.steps[k]);
        let (Passage::Leg(meets), Passage::Leg(ends)) = (first.passage, held.passage) else {
            return None;
        };
        let Some(GuardKind::Switch(surface)) = meets.ends_at else {
            return None;
        };
        let jumps = matches!(ends.jump, Jump::Impact(_) | Jump::Reset(_));
        let begins = meets.jump == Jump::None && !self.slides_along(first, surface);
        (jumps && begins && self.slides_along(held, surface)).then_some(surface)
    }
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
        }
        steps.remove(index);
        let (shorter, at) = self.like(steps, at)?;
        let last = shorter.steps.len() - 1;
        Ok((shorter, at, index.checked_sub(1).unwrap_or(last)))
    }

    /// The same orbit with such a step of no time before the event at the end of another one, which comes to this surface. The new step.
    fn with_hold(
        &self,
        at: &[f64],
        (index, surface): (usize, usize),
    ) -> Result<(Self, Vec<f64>, usize), PeriodicError> {
        let unknown = || PeriodicError::Unfollowed {
            what: "a stick that an event cuts short".to_owned(),
        };
        let mut steps = self.current_steps(at);
        let Passage::Leg(kind) = steps[index].passage else {
            return Err(unknown());
        };
        let system = &self.workshop.system;
        let (grip, sides, _) = system.origin_of(kind.mode).ok_or_else(unknown)?;
        let mode = system.meet(grip, sides.with(surface, Side::Sliding));
        let held = Step {
            passage: Passage::Leg(LegKind { mode, ..kind }),
            duration: 0.0,
            ..steps[index].clone()
        };
        steps[index].passage = Passage::Leg(LegKind {
            ends_at: Some(GuardKind::Switch(surface)),
            jump: Jump::None,
            ..kind
        });
        steps[index].told = Vec::new();
        steps.insert(index + 1, held);
        let (mut longer, mut guess) = self.like(steps, at)?;
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
}

impl Walker {
    /// On from where a stick or slide that the event at its end cuts short takes no time any more.
    pub(super) fn hold_vanishes(
        &mut self,
        (curve, reached): (&mut Curve, f64),
        (station, index, surface): (&Station, usize, usize),
        here: &mut Point,
    ) -> Stop {
        let lost = |why: String| Stop::Broken(End::Lost(why), Box::new(station.clone()));
        self.settle(station);
        let forward = self.heading_known(station);
        let there = Point::new(&mut self.shooting, station);
        if let Some(end) = self.between(&curve.station, station, reached, (here, &there)) {
            return Stop::End(end);
        }
        self.settle(station);
        let shorter = self.shooting.without_hold(&station.at, index);
        let (mut shorter, guess, merged) = match shorter {
            Ok(found) => found,
            Err(error) => return lost(error.to_string()),
        };
        let corner = (merged, GuardKind::Switch(surface));
        let next = shorter.at_corner(&guess, corner).and_then(|met| {
            let next = shorter.inside_corner(met.at.clone(), corner, &met)?;
            Ok((met, next))
        });
        match next {
            Ok((met, next)) => {
                self.shooting = shorter;
                self.settle(&next);
                let there = Point::new(&mut self.shooting, &next);
                self.note_met(&there, &met);
                self.goes_on(Ok(next), (curve, forward), here)
            }
            Err(why) => lost(why),
        }
    }

    /// On from where, just at its end, a step comes to a surface that it slides along from there: a stick comes in that the event at its end cuts
    /// short. None where it would go across that surface.
    pub(super) fn hold_comes_in(
        &mut self,
        (curve, reached): (&mut Curve, f64),
        (station, index, surface): (&Station, usize, usize),
        here: &mut Point,
    ) -> Option<Stop> {
        self.settle(station);
        let changes = self.shooting.latest.get(index)?.surface_acceleration;
        let forward = self.heading_known(station);
        let there = Point::new(&mut self.shooting, station);
        let (mut longer, guess, held) =
            (self.shooting.with_hold(&station.at, (index, surface))).ok()?;
        if longer.cut_short(held) != Some(surface) {
            return None;
        }
        let place = longer.duration_place(held)?;
        let none = Condition::fixed(guess.len(), place, 0.0);
        let found = newton(&mut longer, &guess, core::slice::from_ref(&none)).ok()?;
        if moved(&found.at, &guess, longer.scales()) > THERE {
            return None;
        }
        // On to where it takes time.
        let along = tangent(&mut longer, &found.at, &none.row).ok()?;
        let next = Station::beginning(found, along);
        longer.evaluate(&next.at).ok()?;
        // A stick does not come to a wall whose rate it holds at zero: that is a graze.
        let rate = longer.latest.get(held)?.surface_rate;
        if rate.abs() <= STANDS * (changes * longer.period()).abs() {
            return None;
        }
        if !longer.stays_on(&next.at, (held, surface)) {
            return None;
        }
        let met = (self.shooting).at_corner(&station.at, (index, GuardKind::Switch(surface)));
        let met = met.ok()?;
        if let Some(end) = self.between(&curve.station, station, reached, (here, &there)) {
            return Some(Stop::End(end));
        }
        self.settle(station);
        // Told by the equations without the stick.
        self.note_met(&there, &met);
        self.shooting = longer;
        self.settle(&next);
        Some(self.goes_on(Ok(next), (curve, forward), here))
    }
}
