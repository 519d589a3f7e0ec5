//! Which orbits, branches and curves are looked for, and how far they are followed.

use crate::refusal::Refusal;
use chatter::analysis::periodic::{Beside, BranchSpec, Known, Limits, Search, Spec};

/// Which orbits of a model are looked for.
#[derive(Clone, Debug)]
pub struct Orbits {
    /// Where their periods begin.
    pub spec: Spec,
    /// All that such a search finds; without it the one that the motion settles to.
    pub search: Option<Search>,
}

/// Longer cycles take too long to be found by chance.
const MOST_PERIODS: u64 = 64;
/// Starts of a search, unless another number is asked for.
const STARTS: u64 = 200;

/// A search for orbits of up to so many periods, from so many starts that this seed draws.
///
/// # Errors
/// The number of periods is zero, or too large.
pub fn search(periods: u64, starts: Option<u64>, seed: Option<u64>) -> Result<Search, Refusal> {
    if periods == 0 || periods > MOST_PERIODS {
        return Err(Refusal::input(format!(
            "--all {periods}: expected a number of periods from 1 to {MOST_PERIODS}"
        )));
    }
    Ok(Search {
        periods: periods as usize,
        starts: starts.unwrap_or(STARTS),
        seed: seed.unwrap_or(0),
    })
}

/// How far branches are followed. What is none is as usual.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reach {
    /// Orbits of at most so many impacts a period, …
    pub impacts: Option<u64>,
    /// … so many on one branch to either side, …
    pub points: Option<u64>,
    /// … at steps of at most this part of the range.
    pub step: Option<f64>,
}

/// Impacts a period of orbits that are followed, unless another number is asked for, …
const IMPACTS: u64 = 80;
/// … orbits of one branch to either side, …
const POINTS: u64 = 20_000;
/// … and the longest step, in parts of the range.
const STEP: f64 = 0.01;

impl Reach {
    /// Over the range between two values, whichever is the greater.
    ///
    /// # Errors
    /// The range has no length, or the step is no part of it.
    pub fn over(self, (one, other): (f64, f64)) -> Result<Limits, Refusal> {
        if !(one < other || other < one) {
            return Err(Refusal::input(format!(
                "from {one} to {other}: expected a range of some length"
            )));
        }
        let step = self.step.unwrap_or(STEP);
        if !(step > 0.0 && step <= 1.0) {
            return Err(Refusal::input(format!(
                "--step {step}: expected a part of the range, above 0 and at most 1"
            )));
        }
        let points = self.points.unwrap_or(POINTS);
        Ok(Limits {
            range: (one.min(other), one.max(other)),
            other: None,
            impacts: self.impacts.unwrap_or(IMPACTS),
            points: usize::try_from(points).unwrap_or(usize::MAX),
            longest_step: step,
        })
    }
}

/// Doublings of doublings, and so on, are followed no deeper.
const MOST_BESIDE: u64 = 16;

/// How often a branch may be left for another at period doublings and at branch points.
///
/// # Errors
/// More often than can be meant.
pub fn beside(doublings: u64, branch_points: u64) -> Result<Beside, Refusal> {
    let depth = doublings.max(branch_points);
    if depth > MOST_BESIDE {
        return Err(Refusal::input(format!(
            "--depth {depth}: expected at most {MOST_BESIDE}"
        )));
    }
    Ok(Beside {
        doublings: doublings as usize,
        branch_points: branch_points as usize,
    })
}

/// Which branches of a model are looked for.
#[derive(Clone, Debug)]
pub struct Branches {
    /// Where periods begin.
    pub spec: Spec,
    /// Over what, how far, and what else than the first branch.
    pub over: BranchSpec,
    /// From every orbit that this search finds; without it from the one that the motion settles to.
    pub search: Option<Search>,
}

/// Which curve of special points is looked for; the model has the values of the parameters at its point.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Where periods begin.
    pub spec: Spec,
    /// Positions of both parameters, of which the second is varied over the range.
    pub free: [usize; 2],
    /// The point.
    pub known: Known,
    /// How far it is followed.
    pub limits: Limits,
}
