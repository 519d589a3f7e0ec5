//! Curves of special points in two parameters: the equations of the orbit with the condition of the point, and the points of
//! codimension two on them.
//!
//! ```text
//! start        a special point as it was told, found again
//! degenerate   functions that vanish at points of codimension two
//! border       curves of chatter borders, by the search for border orbits
//! extrapolated ends at which the equations are singular
//! follower     one side of a curve, station by station
//! closed       where it comes back to where it began
//! at_turn      where a rate turns on a surface on which the force changes
//! past_touch   on past where a surface is touched
//! past_break   on past where the sequence of events changes otherwise, by the motion
//! up_to_graze  the motion read up to where it grazes
//! stay_end     the end where a stay comes to nothing and no curve leads on without it
//! passes       whether it goes through another point that was told
//! ```

mod at_turn;
pub(crate) mod border;
mod closed;
mod degenerate;
mod extrapolated;
mod follower;
pub(super) mod passes;
mod past_break;
mod past_touch;
pub(super) mod start;
mod stay_end;
mod up_to_graze;

use super::branch::{Branch, End, Limits, Point, Side, Special, SpecialKind, joined, passages};
use super::diary::Diary;
use super::error::PeriodicError;
use super::shooting::Workshop;
use crate::analysis::continuation::{Problem, Station};
use follower::{Follower, Place};
use serde::{Deserialize, Serialize};
use start::{begin, failed};
use std::sync::Arc;

/// A special point as it was told: enough to find it again.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Known {
    /// Which kind.
    pub kind: SpecialKind,
    /// Which of the user's functions vanishes, of a point of that kind.
    pub monitor: Option<usize>,
    /// The state of its orbit, at the section or just after an event.
    pub state: Vec<f64>,
    /// Its period.
    pub period: f64,
}

/// A curve of special points.
#[derive(Clone, Debug)]
pub struct SpecialCurve {
    /// Which kind.
    pub kind: SpecialKind,
    /// Its points, in order.
    pub points: Vec<Point>,
    /// Those of codimension two, in order.
    pub special: Vec<Special>,
    /// How its first and last ends came about.
    pub ends: [End; 2],
}

/// Follows a special point over the last free parameter, to both sides.
pub(crate) fn follow(
    workshop: &Arc<Workshop>,
    (free, known): (&[f64], &Known),
    limits: &Limits,
    diary: &mut Diary<'_>,
) -> Result<SpecialCurve, PeriodicError> {
    let begun = begin(workshop, free, known)?;
    let mut sides: Vec<Side> = Vec::new();
    let mut first = None;
    for forward in [false, true] {
        if let Some(side) = sides.last().and_then(Side::without_other) {
            sides.push(side);
            continue;
        }
        let mut shooting = begun.shooting.clone();
        let bordered = (begun.condition)
            .near(&mut shooting, &begun.at, None)
            .map_err(failed)?;
        // In a symmetric model the parameter has its most or least value just there.
        let station = Station::beside(&mut bordered.of(&mut shooting), &begun.at);
        let station = station.map_err(failed)?;
        let station = if forward { station } else { station.reversed() };
        shooting.evaluate(&station.at).map_err(failed)?;
        let mut follower = Follower {
            began: (station.clone(), passages(&shooting)),
            shooting,
            kind: known.kind,
            condition: begun.condition,
            grazing: begun.grazing,
            limits: *limits,
            points: Vec::new(),
            special: Vec::new(),
            sided: None,
            passed: None,
        };
        first.get_or_insert_with(|| follower.told(&station));
        sides.push(match follower.resume(diary)? {
            (_, Some(end)) => follower.side(end),
            (Some(place), None) => follower.follow(place, diary),
            (None, None) => follower.follow(Place::new(station, bordered), diary),
        });
    }
    let first = first.ok_or(PeriodicError::Interrupted)?;
    Ok(SpecialCurve::of(known.kind, joined(sides, first)?))
}

impl SpecialCurve {
    fn of(kind: SpecialKind, branch: Branch) -> Self {
        let Branch {
            points,
            special,
            ends,
        } = branch;
        Self {
            kind,
            points,
            special,
            ends,
        }
    }
}
