//! A branch of periodic orbits over a parameter, through grazes from one sequence of events to the next.
//!
//! Where a flight grazes, the orbit gains an impact: the leg is cut at its least gap, and the equations of the longer
//! sequence hold there with an impact of rate zero, which grows from then on (docs/periodic.md). Where an impact's rate falls to zero it
//! is taken out again. Neither is a decision of the flow, so neither depends on a tolerance.
//!
//! ```text
//! walker       one side of a branch, station by station
//! between      special points between two stations
//! rounding     multipliers next to rounding, and whether what they do there is more than that
//! at_events    stations that are the point of an event
//! branch_point those where branches meet
//! changes/     from one sequence of events to the next
//!   holds        whether the sequence still does
//!   events       the equations with an event more, or one less
//!   graze        where an impact comes in or goes out
//!   touch        the same for a crossing and the way back
//!   turn         the same where the flow turns with the rate of the impact
//!   coincidence  the same where it turns at two places at once
//!   corner       where an event comes to a corner that only it asks for
//!   opening      where a contact at rest begins to open
//!   root         where slopes of an event have no bound
//! onward       past what equations can say, and where they may not go on
//! ends/        where a branch is over
//!   accumulation grazes that rounding does not tell apart
//!   border       how far a chatter border is
//!   returns      it has come back to where it began
//!   equilibrium  equilibria of the flight that a step is
//!   family       without its events orbits lie beside each other
//!   saddle       the orbit comes to a saddle
//!   unbounded    by which law the period grows without bound
//!   growth       at which value a state grows without bound
//!   hopf         the orbit shrinks to an equilibrium
//! limits       within what it is followed, and how it ends
//! kept/        how far a side has come, for another walk to go on from
//! ```

mod at_events;
mod between;
mod branch_point;
mod changes;
mod ends;
mod kept;
mod limits;
mod onward;
mod point;
mod rounding;
mod special;
mod walker;

pub use ends::growth::Growth;
pub use ends::saddle::Saddle;
pub use ends::shrunk::Shrunk;
pub use ends::unbounded::{Law, Unbounded};
pub use kept::Record;
pub use limits::{End, Limits};
pub use point::Point;
pub(super) use special::Near;
pub use special::{Special, SpecialKind};

pub(super) use branch_point::interpolated;
pub(super) use changes::graze::moved;
pub(crate) use changes::holds::{
    Broken, broken, broken_beside, first_break, is_broken, least_beside, sequence_holds, smallest,
};
pub(super) use changes::touch::{STAYS, Stay, VANISHED};
pub(super) use ends::accumulation::ACCUMULATES;
pub(super) use ends::returns::{Began, passages, returned};
pub(super) use kept::{Along, Kept, Ledger, Of, Stand, Standing, Then, damaged};
pub(crate) use limits::station_at;
pub(super) use onward::{Wanted, beside, legal};
pub(super) use special::Seed;
pub(super) use walker::Side;

use super::diary::Diary;
use super::error::PeriodicError;
use super::shooting::Shooting;
use crate::analysis::continuation::{Problem, Station};
use walker::Walker;

/// A branch of periodic orbits.
#[derive(Clone, Debug)]
pub struct Branch {
    /// Its orbits, in order.
    pub points: Vec<Point>,
    /// Its special points, in order.
    pub special: Vec<Special>,
    /// How its first and last ends came about.
    pub ends: [End; 2],
}

impl Branch {
    /// Whether it goes through one of these special points of other branches, but for those at which branches meet: where several impacts lose their rates at once
    /// those of one lead through all, those of another through one of them.
    pub(super) fn shares_special(&self, others: &[Special], near: Near) -> bool {
        let mut own = self.special.iter().filter(|own| !own.kind.meets());
        own.any(|own| {
            let mut all = others.iter();
            all.any(|other| {
                own.is_that_of(other, near)
                    && own.events_among(&self.special) == other.events_among(others)
            })
        })
    }
}

/// Follows a branch from one of its orbits to both sides.
pub(crate) fn follow(
    shooting: &Shooting<f64>,
    at: &[f64],
    limits: &Limits,
    diary: &mut Diary<'_>,
) -> Result<Branch, PeriodicError> {
    let mut sides = Vec::new();
    let (mut begin, at) = shooting.clone().without_section(at.to_vec());
    let last = at.len() - 1;
    // Of orbits that all have one value of the parameter, as those that leave a linear oscillator where it doubles, none is told by it.
    let station = Station::near(&mut begin, &at, last)
        .or_else(|why| Station::beside(&mut begin, &at).map_err(|_| why))
        .map_err(|error| PeriodicError::NoConvergence {
            how: error.to_string(),
        })?;
    begin
        .evaluate(&station.at)
        .map_err(|left| PeriodicError::NoConvergence {
            how: left.to_string(),
        })?;
    let first = Point::new(&mut begin, &station);
    // What is followed is what the limits allow, wherever on it it begins.
    if first
        .impacts
        .is_some_and(|impacts| impacts > limits.impacts)
    {
        let nothing = || Side {
            points: Vec::new(),
            special: Vec::new(),
            end: End::Impacts(limits.impacts),
        };
        return joined(vec![nothing(), nothing()], first);
    }
    for forward in [false, true] {
        let start = if forward {
            station.clone()
        } else {
            station.clone().reversed()
        };
        sides.push(match sides.last().and_then(Side::without_other) {
            Some(side) => side,
            None => side((&begin, start), limits, diary)?,
        });
    }
    joined(sides, first)
}

/// Two sides, the one behind first, and the point between them.
pub(super) fn joined(mut sides: Vec<Side>, between: Point) -> Result<Branch, PeriodicError> {
    let (forward, back) = (sides.pop(), sides.pop());
    let (Some(forward), Some(mut back)) = (forward, back) else {
        return Err(PeriodicError::Interrupted);
    };
    // What comes back to where it began has been all the way around, wherever the other side has broken off.
    if forward.end == End::Closed
        && back.end != End::Closed
        && let Some(none) = forward.without_other()
    {
        back = none;
    }
    let behind = back.points.len();
    back.points.reverse();
    back.special.reverse();
    for special in &mut back.special {
        special.place = behind - special.place;
    }
    let mut points = back.points;
    points.push(between);
    points.extend(forward.points);
    let mut special = back.special;
    special.extend(forward.special.into_iter().map(|mut special| {
        special.place += behind + 1;
        special
    }));
    Ok(Branch {
        points,
        special,
        ends: [back.end, forward.end],
    })
}

/// One side, from its first station or from where it is on record.
fn side(
    (shooting, start): (&Shooting<f64>, Station),
    limits: &Limits,
    diary: &mut Diary<'_>,
) -> Result<Side, PeriodicError> {
    let workshop = &shooting.workshop;
    let kept = Kept::read(diary, Some(workshop))?;
    let mut walker = Walker {
        shooting: shooting.clone(),
        limits: *limits,
        points: kept.points,
        special: kept.special,
        began: f64::NAN,
    };
    let stand = match kept.then {
        None => walker.begin(start),
        Some(Then::On(standing)) => {
            let (shooting, stand) = standing.restored(workshop)?;
            walker.shooting = shooting;
            stand
        }
        Some(Then::Points) => return Err(damaged()),
        Some(Then::Ended(end)) => return Ok(walker.side(end)),
    };
    walker.walk(stand, diary)
}

#[cfg(test)]
mod tests {
    use super::point::tests::orbits;
    use super::*;

    /// Of as many points at these values.
    fn side(values: core::ops::Range<u32>, end: End) -> Side {
        Side {
            points: orbits(|period| period, values.map(f64::from)),
            special: Vec::new(),
            end,
        }
    }

    /// A side that comes back to where it began is all of a branch, whichever side it is.
    #[test]
    fn nothing_is_told_twice_of_a_branch_that_closes() {
        let ends = |branch: &Branch| (branch.ends.clone(), branch.points.len());
        let between = || orbits(|period| period, [0.0].into_iter()).remove(0);
        let closed = [End::Closed, End::Closed];
        let around = side(1..9, End::Closed);
        let other = around.without_other().unwrap();
        let first = joined(vec![around, other], between()).unwrap();
        assert_eq!(ends(&first), (closed.clone(), 9));
        let broken = side(1..4, End::Lost("a reason".to_owned()));
        let second = joined(vec![broken, side(1..9, End::Closed)], between()).unwrap();
        assert_eq!(ends(&second), (closed, 9));
    }
}
