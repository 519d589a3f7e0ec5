//! Orbits, branches and curves of special points, found while an observer listens.

use super::log::Log;
use super::refused;
use super::several::from_several;
use crate::observer::Observer;
use crate::refusal::Refusal;
use chatter::analysis::periodic::{
    Beside, Branch, BranchSpec, End, Known, Limits, Orbit, PeriodicError, Point, Record, Search,
    Spec, SpecialCurve, SpecialKind, Told, all, branches, forcing, settled, special_curve,
};
use chatter::model::Model;
use core::ops::ControlFlow;
use std::time::Instant;

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

/// Branches that were found.
#[derive(Debug)]
pub struct Found {
    /// The branches; those that the observer stopped end there (`End::Interrupted`).
    pub branches: Vec<Branch>,
    /// Whether the observer let the work come to its end.
    pub complete: bool,
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

/// The orbits.
///
/// # Errors
/// There are none, or the observer stopped the work.
pub fn find_orbits(
    model: &Model,
    wanted: &Orbits,
    observer: &dyn Observer,
) -> Result<Vec<Orbit>, Refusal> {
    let began = Instant::now();
    let found = match &wanted.search {
        None => {
            let patience = wanted.spec.patience;
            let longest = forcing(model).map_or(patience.time, |period| {
                patience.time.min(period * patience.periods as f64)
            });
            settled(model, &wanted.spec, &mut |time| {
                observer.progress(time / longest, &|| {
                    format!("following the motion until it settles, time {time:.6}")
                });
                observer.going_on()
            })
            .map(|orbit| vec![orbit])
        }
        Some(search) => all(model, &wanted.spec, search, &mut |reached| {
            let done = reached.starts as f64 / search.starts as f64;
            observer.progress(done, &|| {
                let rate = reached.starts as f64 / began.elapsed().as_secs_f64();
                format!("{} orbits, {rate:.0} starts/s", reached.orbits)
            });
            observer.going_on()
        }),
    };
    found.map_err(|error| refused(&error, model))
}

/// Tells how far along its range a curve is.
struct Reached<'a> {
    observer: &'a dyn Observer,
    parameter: &'a str,
    range: (f64, f64),
    began: Instant,
    orbits: u64,
}

impl<'a> Reached<'a> {
    fn new(
        model: &'a Model,
        parameter: usize,
        limits: &Limits,
        observer: &'a dyn Observer,
    ) -> Self {
        Self {
            observer,
            parameter: &model.parameters[parameter].name,
            range: limits.range,
            began: Instant::now(),
            orbits: 0,
        }
    }

    fn tell(&mut self, point: &Point) {
        self.orbits += 1;
        let (at, orbits, (low, high)) = (point.parameter(), self.orbits, self.range);
        let done = ((at - low) / (high - low)).clamp(0.0, 1.0);
        self.observer.progress(done, &|| {
            let impacts = match point.impacts {
                Some(impacts) => format!("{impacts} impacts"),
                None => "complete chatter".to_owned(),
            };
            let rate = orbits as f64 / self.began.elapsed().as_secs_f64();
            format!(
                "{} = {at:.8}, {impacts}, {orbits} orbits, {rate:.0} orbits/s",
                self.parameter
            )
        });
    }
}

/// Keeps a record, or says why it cannot.
type Keep<'a> = dyn FnMut(&Record) -> Result<(), Refusal> + 'a;

/// The branches. With a log they go on from what it held, and how far they come is kept in it.
///
/// # Errors
/// There are none, or the log cannot be written.
pub fn find_branches(
    model: &Model,
    wanted: &Branches,
    log: Option<&mut Log>,
    observer: &dyn Observer,
) -> Result<Found, Refusal> {
    if let Some(search) = &wanted.search {
        return from_several(model, (wanted, search), log, observer);
    }
    let mut log = log;
    let mut before = log.as_mut().map(|log| log.before()).unwrap_or_default();
    let before = before.parts.remove(&0).unwrap_or_default();
    let mut keep = |record: &Record| log.as_mut().map_or(Ok(()), |log| log.part(0, record));
    let found = follow(
        model,
        (&wanted.spec, &wanted.over),
        before,
        &mut keep,
        observer,
    )?;
    let branches = found.map_err(|error| refused(&error, model))?;
    let complete = !(branches.iter()).any(|branch| branch.ends.contains(&End::Interrupted));
    Ok(Found { branches, complete })
}

/// The branches from one orbit, each record kept as it comes; or why there are none.
///
/// # Errors
/// A record cannot be kept.
pub(super) fn follow(
    model: &Model,
    (spec, over): (&Spec, &BranchSpec),
    before: Vec<Record>,
    keep: &mut Keep<'_>,
    observer: &dyn Observer,
) -> Result<Result<Vec<Branch>, PeriodicError>, Refusal> {
    let mut kept = Kept {
        reached: Reached::new(model, over.parameter, &over.limits, observer),
        keep,
        broken: None,
    };
    let found = branches(model, spec, over, before, &mut |told| kept.hear(told));
    kept.broken.map_or(Ok(found), Err)
}

/// Tells of orbits, and keeps records until one cannot be kept.
struct Kept<'a> {
    reached: Reached<'a>,
    keep: &'a mut Keep<'a>,
    broken: Option<Refusal>,
}

impl Kept<'_> {
    fn hear(&mut self, told: Told<'_>) -> ControlFlow<()> {
        match told {
            Told::Settling => {}
            Told::Orbit(point) => self.reached.tell(point),
            Told::Record(record) => {
                if let Err(refusal) = (self.keep)(record) {
                    self.broken = Some(refusal);
                    return ControlFlow::Break(());
                }
            }
        }
        self.reached.observer.going_on()
    }
}

/// The curve and of what; one that the observer stopped ends there (`End::Interrupted`). With records `before` it goes on from
/// there, and how far it comes is kept.
///
/// # Errors
/// The point cannot be found again, or is of a kind that has no curve, or a record cannot be kept.
pub fn find_curve(
    model: &Model,
    wanted: &Curve,
    (before, keep): (Vec<Record>, &mut Keep<'_>),
    observer: &dyn Observer,
) -> Result<(SpecialKind, Branch), Refusal> {
    let Curve {
        spec,
        free,
        known,
        limits,
    } = wanted;
    let mut kept = Kept {
        reached: Reached::new(model, free[1], limits, observer),
        keep,
        broken: None,
    };
    let of = (*free, known);
    let found = special_curve(model, spec, of, limits, before, &mut |told| kept.hear(told));
    if let Some(refusal) = kept.broken {
        return Err(refusal);
    }
    let SpecialCurve {
        kind,
        points,
        special,
        ends,
    } = found.map_err(|error| refused(&error, model))?;
    let branch = Branch {
        points,
        special,
        ends,
    };
    Ok((kind, branch))
}
