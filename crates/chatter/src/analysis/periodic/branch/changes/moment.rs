//! A step that takes no time at a place of the branch: beside it its time, of either sign, is an unknown like others. On one side of that place it is
//! part of the motion, on the other it is not, and there the equations without it hold.

use super::graze::{CAREFUL, THERE, moved};
use crate::analysis::continuation::{Condition, Curve, Problem, Station, newton, tangent};
use crate::analysis::periodic::branch::Point;
use crate::analysis::periodic::branch::limits::End;
use crate::analysis::periodic::branch::walker::{Stop, Walker};
use crate::analysis::periodic::error::PeriodicError;
use crate::analysis::periodic::shooting::Shooting;
use crate::analysis::periodic::solved::Solved;
use crate::flow::GuardKind;

/// A step, whether where it begins and not at its end, and the guard that vanishes there.
pub(super) type Watched = ((usize, bool), GuardKind);

impl Shooting<f64> {
    /// Equations with a step of no time at a guess of their solution, at their first station: on to where it takes time. None if the solution is elsewhere.
    pub(super) fn beginning_with_no_time(
        mut self,
        guess: &[f64],
        step: usize,
    ) -> Option<(Self, Station)> {
        let place = self.duration_place(step)?;
        let none = Condition::fixed(guess.len(), place, 0.0);
        let found = newton(&mut self, guess, core::slice::from_ref(&none)).ok()?;
        if moved(&found.at, guess, self.scales()) > THERE {
            return None;
        }
        let along = tangent(&mut self, &found.at, &none.row).ok()?;
        let next = Station::beginning(found, along);
        self.evaluate(&next.at).ok()?;
        Some((self, next))
    }
}

impl Walker {
    /// On from where a step takes no time any more, by the equations without it, with a guess of their solution: as it comes to nothing what is watched of them
    /// vanishes.
    pub(super) fn moment_vanishes(
        &mut self,
        (curve, reached): (&mut Curve, f64),
        (station, is_told): (&Station, bool),
        here: &mut Point,
        without: impl FnOnce(
            &Shooting<f64>,
            &[f64],
        ) -> Result<(Shooting<f64>, Vec<f64>, Watched), PeriodicError>,
    ) -> Stop {
        let lost = |why: String| Stop::Broken(End::Lost(why), Box::new(station.clone()));
        self.settle(station);
        let forward = self.heading_known(station);
        let there = Point::new(&mut self.shooting, station);
        if let Some(end) = self.between(&curve.station, station, reached, (here, &there)) {
            return Stop::End(end);
        }
        self.settle(station);
        let (mut shorter, guess, watched) = match without(&self.shooting, &station.at) {
            Ok(found) => found,
            Err(error) => return lost(error.to_string()),
        };
        let next = shorter.where_vanishes(&guess, watched).and_then(|met| {
            let next = shorter.inside_watched(met.at.clone(), &met)?;
            Ok((met, next))
        });
        match next {
            Ok((met, next)) => {
                self.shooting = shorter.clone();
                self.settle(&next);
                let there = Point::new(&mut self.shooting, &next);
                let told = is_told.then_some((&there, &met));
                self.goes_on_from((shorter, next), told, (curve, forward), here)
            }
            Err(why) => lost(why),
        }
    }

    /// On with a step that comes in with no time, where what is watched of the equations without it vanishes: they tell the place. None where it does not. Where
    /// nothing leads on the branch ends there, for this reason.
    pub(super) fn moment_comes_in(
        &mut self,
        (curve, reached): (&mut Curve, f64),
        (station, watched, is_told): (&Station, Watched, bool),
        onward: Result<(Shooting<f64>, Station), String>,
        here: &mut Point,
    ) -> Option<Stop> {
        self.settle(station);
        let forward = self.heading_known(station);
        let there = Point::new(&mut self.shooting, station);
        let met = self.shooting.where_vanishes(&station.at, watched).ok()?;
        if let Some(end) = self.between(&curve.station, station, reached, (here, &there)) {
            return Some(Stop::End(end));
        }
        self.settle(station);
        match onward {
            Ok((longer, next)) => {
                let told = is_told.then_some((&there, &met));
                let next = (longer, next);
                Some(self.goes_on_from(next, told, (curve, forward), here))
            }
            Err(why) => {
                self.note_met(&there, &met);
                let last = there.moved(&mut self.shooting, &met.at);
                self.points.push(last);
                Some(Stop::Over(End::Lost(why)))
            }
        }
    }

    /// On with these equations, from where something happens to the orbit if that is told.
    fn goes_on_from(
        &mut self,
        (shooting, next): (Shooting<f64>, Station),
        told: Option<(&Point, &Solved)>,
        (curve, forward): (&mut Curve, Option<f64>),
        here: &mut Point,
    ) -> Stop {
        if let Some((there, met)) = told {
            self.note_met(there, met);
        }
        self.shooting = shooting;
        self.settle(&next);
        match told {
            Some(_) => self.goes_on(Ok(next), (curve, forward), here),
            None => {
                let step = CAREFUL * curve.step;
                self.begins_anew((next, step), curve, here);
                Stop::On
            }
        }
    }
}
