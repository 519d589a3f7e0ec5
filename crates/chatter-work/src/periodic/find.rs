//! Orbits, branches and curves of special points, found while an observer listens.

use super::log::Log;
use super::refused;
use super::refused::why;
use super::several::from_several;
use super::wanted::{Branches, Curve, Orbits};
use crate::observer::Observer;
use crate::refusal::Refusal;
use chatter::analysis::periodic::{
    Branch, BranchSpec, End, Limits, Orbit, PeriodicError, Point, Record, Spec, SpecialCurve,
    SpecialKind, Told, all, branches, forcing, settled, special_curve,
};
use chatter::model::Model;
use core::ops::ControlFlow;
use std::time::Instant;

/// Branches that were found.
#[derive(Debug)]
pub struct Found {
    /// The branches; those that the observer stopped end there (`End::Interrupted`).
    pub branches: Vec<Branch>,
    /// Whether the observer let the work come to its end.
    pub complete: bool,
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
    model: &'a Model,
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
            model,
            parameter: &model.parameters[parameter].name,
            range: limits.range,
            began: Instant::now(),
            orbits: 0,
        }
    }

    fn begins_elsewhere(&self, (own, at): (f64, f64), error: &PeriodicError) {
        let (name, why) = (self.parameter, why(error, self.model));
        self.observer.remark(&format!(
            "no orbit to begin with was found at {name} = {own}: {why}; the branches begin at {name} = {at}"
        ));
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
            Told::Elsewhere { own, at, why } => self.reached.begins_elsewhere((own, at), why),
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
