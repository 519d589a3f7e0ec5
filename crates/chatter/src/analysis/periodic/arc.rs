//! An arc: orbits with one number of impacts, from where the last of their chatter grazes on; and where the stable ones of them end.

use super::branch::{broken_beside, is_broken};
use super::condition::Condition;
use super::cycle::itinerary::Step;
use super::cycle::reread::through_impacts;
use super::error::PeriodicError;
use super::multipliers::passes;
use super::orbit::failed;
use super::shooting::{Shooting, Workshop};
use crate::analysis::continuation::{
    Condition as Row, Curve, NewtonError, Problem, Settings, Station, approach, newton,
};
use crate::numerics::{Estimate, dot};
use std::sync::Arc;

/// An orbit where stable ones end.
#[derive(Clone, Debug)]
pub(in crate::analysis) struct ArcEnd {
    /// After the impact that orbits are told from.
    pub state: Vec<f64>,
    pub parameter: Estimate<f64>,
}

/// Fold, period doubling, and graze of the last impact but the one that orbits are told from, as far as they are found.
pub(in crate::analysis) type ArcEnds = [Option<ArcEnd>; 3];
pub(in crate::analysis) const FOLD: usize = 0;
pub(in crate::analysis) const DOUBLING: usize = 1;
const GRAZE: usize = 2;

/// A way from a state ends near it, in parts of the size of states, if it is to be closed.
const NEARLY_CLOSED: f64 = 0.5;
/// Steps along an arc, in parts of how far ahead its graze seems to be: the longest towards that, and away from it; and how many.
const FIRST_STEP: f64 = 0.1;
const TOWARDS: f64 = 0.3;
const AWAY: f64 = 10.0;
const SHORTEST_STEP: f64 = 1e-7;
const MOST_STEPS: usize = 100;

/// An orbit of an arc, and what tells of its ends: each vanishes at one.
struct Looked {
    station: Station,
    tells: [f64; 3],
}

/// Where stable orbits end, of those with so many impacts at a contact: from the one near a state after one of them, at a value of the
/// parameter that Newton's method may change by so much.
pub(in crate::analysis) fn arc_ends(
    workshop: &Arc<Workshop>,
    (state, value, slack): (&[f64], f64, f64),
    (contact, count): (usize, usize),
) -> Result<ArcEnds, PeriodicError> {
    let left = |left| failed(&NewtonError::Left(left));
    let cycle = through_impacts(workshop, &[value], state, (contact, count))?;
    let hits = |step: &Step| step.impact() == Some(contact);
    let hits: Vec<usize> = (0..cycle.steps.len())
        .filter(|&index| hits(&cycle.steps[index]))
        .collect();
    let [.., last, _] = hits[..] else {
        return Err(another());
    };
    if hits.len() != count || cycle.distance > NEARLY_CLOSED {
        return Err(another());
    }
    let mut shooting = Shooting::<f64>::new(workshop, cycle.steps, cycle.counts)?;
    let guess = shooting.guess(&[value]);
    // Over the parameter an arc turns, and is vertical at its graze: over the rate of its last impact it is neither.
    let (_, row) = shooting.monitor(last, &guess).map_err(left)?;
    let held = [Row {
        value: dot(&row, &guess),
        row,
    }];
    let near = approach(&mut shooting, &guess, &held).map_err(|error| failed(&error))?;
    let at = (newton(&mut shooting, &near, &held).map_err(|error| failed(&error))?).at;
    shooting.adopt(&at);
    let is_near = (at[at.len() - 1] - value).abs() <= slack;
    if !is_near || is_broken(&mut shooting, &at).map_err(left)? {
        return Err(another());
    }
    let station = Station::near(&mut shooting, &at, at.len() - 1);
    let station = station.map_err(|error| failed(&error))?;
    let (rate, row) = shooting.monitor(last, &station.at).map_err(left)?;
    let falls = dot(&row, &station.tangent) / rate;
    let ahead = 1.0 / falls.abs();
    let towards = if falls < 0.0 {
        station
    } else {
        station.reversed()
    };
    let mut arc = ArcWalk {
        shooting,
        last,
        ends: [const { None }; 3],
    };
    for (start, far) in [(towards.clone(), false), (towards.reversed(), true)] {
        arc.walk(start, ahead, far);
    }
    Ok(arc.ends)
}

struct ArcWalk {
    shooting: Shooting<f64>,
    /// The step that ends with the impact which grazes.
    last: usize,
    ends: ArcEnds,
}

impl ArcWalk {
    fn look(&mut self, station: Station) -> Option<Looked> {
        let (rate, _) = self.shooting.monitor(self.last, &station.at).ok()?;
        let doubles = passes(&self.shooting.multipliers(), -1.0)?;
        let tells = [station.parameter_slope(), doubles, rate];
        Some(Looked { station, tells })
    }

    /// Towards the graze, or `far` from it until all that ends what is stable is known.
    fn walk(&mut self, start: Station, ahead: f64, far: bool) -> Option<()> {
        let steps = Settings {
            first_step: FIRST_STEP * ahead,
            longest_step: if far { AWAY } else { TOWARDS } * ahead,
            shortest_step: SHORTEST_STEP * ahead,
        };
        let mut curve = Curve::new(start.clone(), steps);
        let mut here = self.look(start)?;
        let began = here.tells[GRAZE];
        for _ in 0..MOST_STEPS {
            let (next, step) = curve.next(&mut self.shooting).ok()?;
            let next = self.look(next)?;
            // A rate that has come to grow has left the arc.
            if !far && next.tells[GRAZE] < began {
                return None;
            }
            for end in [FOLD, DOUBLING, GRAZE] {
                if here.tells[end] * next.tells[end] < 0.0 && self.ends[end].is_none() {
                    self.ends[end] = self.end(end, (&here, &next), step);
                }
            }
            let all_known = self.ends[FOLD].is_some() && self.ends[DOUBLING].is_some();
            if next.tells[GRAZE] >= 0.0 || (far && all_known) {
                return Some(());
            }
            curve.moves(next.station.clone());
            here = next;
        }
        None
    }

    /// The end between two orbits, if that is an orbit of the same events.
    fn end(&mut self, which: usize, (from, to): (&Looked, &Looked), step: f64) -> Option<ArcEnd> {
        let (condition, grazing) = match which {
            FOLD => (Condition::Singular(1.0), None),
            DOUBLING => (Condition::Singular(-1.0), None),
            _ => (Condition::Monitor(self.last), Some(self.last)),
        };
        let shooting = &mut self.shooting;
        let scales = shooting.scales().to_vec();
        let off = |looked: &&&Looked| looked.tells[which].abs();
        let mut starts = [from, to];
        starts.sort_by(|a, b| off(&a).total_cmp(&off(&b)));
        starts.into_iter().find_map(|start| {
            let bordered = condition.near(shooting, &start.station.at, None).ok()?;
            let found = newton(&mut bordered.of(shooting), &start.station.at, &[]).ok()?;
            let reach = from.station.reach(&found.at, &scales);
            shooting.evaluate(&found.at).ok()?;
            let broken = broken_beside(shooting, &found.at, grazing).ok()?;
            let is_it = broken.is_empty() && (-step..=2.0 * step).contains(&reach);
            let state = shooting.node(&found.at, 0).to_vec();
            let known = is_it.then(|| shooting.refined(&bordered, found))?;
            let parameter = Estimate {
                value: *known.told.last()?,
                error: known.error,
            };
            Some(ArcEnd { state, parameter })
        })
    }
}

/// The motion from a state is not one of the orbits asked for.
fn another() -> PeriodicError {
    PeriodicError::NoConvergence {
        how: "the orbit nearby has another sequence of events".to_owned(),
    }
}
