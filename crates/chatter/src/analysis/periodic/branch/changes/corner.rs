//! Border collisions: the event at the end of a step comes to a corner that only it asks for. The equations with the corner's other piece
//! hold there exactly, if both pieces agree, and the curve goes on along them to where they are the motion's: on in the parameter, or
//! back, which is a fold with a corner. Where the pieces differ by a jump the orbit ends.

use super::graze::{THERE, moved};
use crate::analysis::continuation::{Curve, Problem, Station, tangent};
use crate::analysis::periodic::branch::limits::End;
use crate::analysis::periodic::branch::walker::{Stop, Walker};
use crate::analysis::periodic::branch::{Point, SpecialKind};
use crate::analysis::periodic::condition::Bordered;
use crate::analysis::periodic::orbit::shorter;
use crate::analysis::periodic::shooting::{BeyondCorner, Shooting};
use crate::analysis::periodic::solved::Solved;
use crate::flow::GuardKind;
use crate::numerics::dot;

/// Pieces agree at a corner, in values and in slopes, up to this part of the sizes of states.
const AGREE: f64 = 1e-9;
/// Other corners that vanish at the same place, up to this part of what they were a step before, are passed with the first.
const TOGETHER: f64 = 1e-9;
/// The parameter stands still along a curve that moves it by less than this part of how far it goes.
const STANDS: f64 = 1e-12;

impl Shooting<f64> {
    /// Where the event at the end of a step is at a corner.
    pub(super) fn at_corner(
        &mut self,
        start: &[f64],
        (index, guard): (usize, GuardKind),
    ) -> Result<Solved, String> {
        self.where_vanishes(start, ((index, false), guard))
    }

    /// Where a guard vanishes at the end of a step, or where it begins.
    pub(super) fn where_vanishes(
        &mut self,
        start: &[f64],
        (place, guard): ((usize, bool), GuardKind),
    ) -> Result<Solved, String> {
        let known = self.watch(place, guard);
        known.map_err(|error| error.to_string())?;
        self.at_watched(start)
    }

    /// Where what is watched vanishes.
    pub(super) fn at_watched(&mut self, start: &[f64]) -> Result<Solved, String> {
        let function = self.corner_function();
        let found = self.solved(&Bordered::Monitor(function), start);
        let found = found.map_err(|error| error.to_string())?;
        if moved(&found.at, start, self.scales()) > THERE {
            return Err("where an event comes to a corner only another place is found".to_owned());
        }
        Ok(found)
    }
}

impl Walker {
    /// Tells a touch where what was watched vanishes, by the branch's equations.
    pub(super) fn note_met(&mut self, there: &Point, met: &Solved) {
        self.note(
            SpecialKind::Touch,
            there,
            &met.told,
            met.error,
            met.residual,
        );
    }

    /// On from where, on the way to the next station, the event at the end of a step comes to a corner that it asks for.
    pub(super) fn comes_to_corner(
        &mut self,
        (curve, step): (&mut Curve, f64),
        (station, index, guard): (&Station, usize, GuardKind),
        here: &mut Point,
        there: &Point,
    ) -> Stop {
        if let Some(end) = self.ends_at_root(&station.at, (index, guard), there) {
            return Stop::Over(end);
        }
        self.settle(station);
        let lost = |why: String| Stop::Broken(End::Lost(why), Box::new(station.clone()));
        let from = curve.station.clone();
        let met = match self.shooting.at_corner(&station.at, (index, guard)) {
            Ok(met) => met,
            Err(why) => return lost(why),
        };
        let together = self.corners_met_together(&from, &met, (index, guard));
        let beyond = (self.shooting).beyond_corners(&met.at, (index, &together));
        let BeyondCorner {
            shooting: mut other,
            at,
            step: again,
            jump,
            kink,
        } = match beyond {
            Ok(beyond) => beyond,
            Err(error) => return lost(error.to_string()),
        };
        let next = other.leaves_corner(at, (again, guard), &met);
        if jump <= AGREE && kink <= AGREE {
            // Functions go on smoothly, or an angle is kept below a turn: nothing happens to the orbit.
            return match next {
                Ok(next) => {
                    self.shooting = other;
                    self.settle(&next);
                    self.begins_anew((next, step), curve, here);
                    Stop::On
                }
                Err(why) => lost(why),
            };
        }
        self.settle(station);
        self.note_met(there, &met);
        let ends = |walker: &mut Self, why: &str| {
            let last = there.moved(&mut walker.shooting, &met.at);
            walker.points.push(last);
            let named = walker.shooting.workshop.named(guard);
            let how = format!("event {index} of the orbit comes at {named}, beyond which {why}");
            Stop::Over(End::Lost(how))
        };
        if jump > AGREE {
            return ends(self, "it leads elsewhere by a jump");
        }
        let next = match next {
            Ok(next) => next,
            Err(why) => return lost(why),
        };
        if other.stands_still(&next, step) {
            return ends(self, "orbits lie beside each other, all at this one value");
        }
        // Of what is gone around twice beyond, this is where it meets the simple orbits.
        if shorter(&other, &next.at).is_ok_and(|part| part.is_some()) {
            let last = there.moved(&mut self.shooting, &met.at);
            self.points.push(last);
            return Stop::Over(End::Again(SpecialKind::Touch));
        }
        self.shooting = other;
        // A family has come to its end, from neither side.
        let stood = self.is_flat(&from);
        let gone = self.goes_on(Ok(next), (curve, Some(from.parameter_slope())), here);
        if stood && let Some(special) = self.latest_change() {
            special.persists = None;
        }
        match gone {
            Stop::End(end @ End::Lost(_)) => lost(end.to_string()),
            gone => gone,
        }
    }

    /// All corners of one event that it comes to at this place.
    fn corners_met_together(
        &mut self,
        from: &Station,
        met: &Solved,
        (index, guard): (usize, GuardKind),
    ) -> Vec<GuardKind> {
        let mut ends = |at: &[f64]| {
            let _ = self.shooting.evaluate(at);
            let least = self.shooting.least(at).unwrap_or_default();
            let of_step = least.into_iter().nth(index).unwrap_or_default();
            let at_end = of_step.into_iter().filter(|least| least.at_end);
            at_end
                .map(|least| (least.guard, least.value))
                .collect::<Vec<_>>()
        };
        let (before, now) = (ends(&from.at), ends(&met.at));
        let mut found = vec![guard];
        for (other, value) in now {
            let known = before.iter().find(|(of, _)| *of == other);
            let vanishes = known.is_some_and(|(_, was)| value.abs() <= TOGETHER * was.abs());
            if vanishes && !found.contains(&other) && self.shooting.asks(index, other) {
                found.push(other);
            }
        }
        found
    }
}

impl Shooting<f64> {
    /// The first station of equations with the other piece of a corner, on the side where they are the motion's.
    fn leaves_corner(
        &mut self,
        at: Vec<f64>,
        (index, guard): (usize, GuardKind),
        met: &Solved,
    ) -> Result<Station, String> {
        let back = guard.opposite().ok_or("a corner without sides")?;
        self.inside_corner(at, (index, back), met)
    }

    /// The first station from where an event is at a corner, on the side where it comes before that.
    pub(super) fn inside_corner(
        &mut self,
        at: Vec<f64>,
        (index, guard): (usize, GuardKind),
        met: &Solved,
    ) -> Result<Station, String> {
        let known = self.watch_corner(index, guard);
        known.map_err(|error| error.to_string())?;
        self.inside_watched(at, met)
    }

    /// The first station from where what is watched vanishes, on the side where its guard is positive.
    pub(super) fn inside_watched(&mut self, at: Vec<f64>, met: &Solved) -> Result<Station, String> {
        let function = self.corner_function();
        let gradient = self.monitor(function, &at);
        let (_, gradient) = gradient.map_err(|left| left.to_string())?;
        let mut tangent = tangent(self, &at, &gradient).map_err(|error| error.to_string())?;
        if dot(&gradient, &tangent) < 0.0 {
            tangent.iter_mut().for_each(|x| *x = -*x);
        }
        Ok(Station {
            at,
            tangent,
            residual: met.residual,
            correction: met.correction,
            orientation: 0.0,
        })
    }

    /// Whether the parameter stands still along the curve from a station on.
    fn stands_still(&mut self, from: &Station, step: f64) -> bool {
        let Ok((ahead, _)) = from.ahead(self, step) else {
            return false;
        };
        let size = self.scales().last().copied().unwrap_or(1.0);
        (ahead.parameter() - from.parameter()).abs() <= STANDS * size
    }
}
