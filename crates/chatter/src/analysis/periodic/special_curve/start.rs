//! A special point as it was told, found again.

use super::Known;
use crate::analysis::continuation::{Condition as Row, Problem, newton};
use crate::analysis::periodic::branch::SpecialKind;
use crate::analysis::periodic::condition::Condition;
use crate::analysis::periodic::cycle::reread::reread;
use crate::analysis::periodic::cycle::settle::cycle::Cycle;
use crate::analysis::periodic::error::PeriodicError;
use crate::analysis::periodic::multipliers::{NEAR_ONE, is_near, neutral};
use crate::analysis::periodic::orbit::shorter;
use crate::analysis::periodic::shooting::{Shooting, Workshop};
use crate::flow::GuardKind;
use crate::flow::leg::Least;
use std::sync::Arc;

/// Before a graze orbits are looked at without the impact, and with it: an impact slower than this part of the fastest is the
/// grazing one.
pub(super) const SLOWEST: f64 = 1e-5;
/// An impact beside a graze that is slower than this is rounding: there is another graze.
const AT_ONCE: f64 = 1e-9;
/// This part of a leg from where it begins is its start.
const AT_START: f64 = 1e-5;

pub(super) fn failed(error: impl core::fmt::Display) -> PeriodicError {
    PeriodicError::NoConvergence {
        how: error.to_string(),
    }
}

/// Equations, a solution of them with the condition, and for grazes the step that grazes.
pub(super) struct Begun {
    pub shooting: Shooting<f64>,
    pub at: Vec<f64>,
    pub condition: Condition,
    pub grazing: Option<usize>,
}

/// Exactly at a graze rounding decides whether a trace hits, touches or comes to rest for an instant. So far beside it, in parts of
/// the first parameter's size, it hits or passes by.
const BESIDE: [f64; 3] = [0.0, 1e-11, -1e-11];

pub(super) fn begin(
    workshop: &Arc<Workshop>,
    free: &[f64],
    known: &Known,
) -> Result<Begun, PeriodicError> {
    begin_at_graze(workshop, free, (known, None))
}

/// Where a contact is grazed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grazed {
    pub contact: usize,
    /// So long after the state that the orbit is told from.
    pub time: f64,
}

/// The same, where it may be known which contact is grazed, and when.
pub(super) fn begin_at_graze(
    workshop: &Arc<Workshop>,
    free: &[f64],
    (known, grazed): (&Known, Option<Grazed>),
) -> Result<Begun, PeriodicError> {
    let mut failed = None;
    for part in BESIDE {
        let mut beside = free.to_vec();
        beside[0] += part * workshop.sizes[0];
        match begin_at(workshop, &beside, (known, grazed)) {
            Ok(begun) => return Ok(begun),
            Err(error) => failed = failed.or(Some(error)),
        }
        if !known.kind.is_graze() {
            break;
        }
    }
    Err(failed.unwrap_or(PeriodicError::Interrupted))
}

fn begin_at(
    workshop: &Arc<Workshop>,
    free: &[f64],
    (known, grazed): (&Known, Option<Grazed>),
) -> Result<Begun, PeriodicError> {
    let no_curve = || PeriodicError::NoCurve { kind: known.kind };
    if !known.kind.has_curve() {
        return Err(no_curve());
    }
    let cycle = reread(workshop, free, (&known.state, known.period))?;
    let mut shooting = Shooting::<f64>::new(workshop, cycle.steps, cycle.counts)?;
    let mut at = shooting.guess(free);
    (shooting, at) = shooting.without_section(at);
    if known.kind == SpecialKind::Monitor {
        // A function of the user's is one of the state at the section.
        shooting.told = Some(known.state.clone());
        if let Some(longer) = shooting.with_section(&at)? {
            (shooting, at) = longer;
        }
    }
    let mut grazing = None;
    let condition = match known.kind {
        SpecialKind::Fold => Condition::Singular(1.0),
        SpecialKind::PeriodDoubling => Condition::Singular(-1.0),
        SpecialKind::NeimarkSacker => Condition::Monitor(shooting.pair_function()),
        SpecialKind::Monitor => {
            let index = known
                .monitor
                .filter(|index| *index < workshop.monitors.len());
            Condition::Monitor(shooting.user_function(index.ok_or_else(no_curve)?))
        }
        SpecialKind::FlightGraze | SpecialKind::ImpactGraze => {
            let mut index = match grazed {
                Some(grazed) => touched_at(&mut shooting, &mut at, grazed)?,
                None => touched(&mut shooting, &mut at)?,
            };
            if let Some(half) = gone_around_twice(&shooting, &at, index) {
                shooting = Shooting::new(workshop, half.steps, half.counts)?;
                at = shooting.guess(free);
                index = touched(&mut shooting, &mut at)?;
            }
            grazing = Some(index);
            Condition::Monitor(index)
        }
        _ => return Err(no_curve()),
    };
    let begun = found_again((shooting, at), (condition, grazing), known.kind)?;
    match grazing {
        Some(_) => without_other_grazes(begun, known.kind),
        None => Ok(begun),
    }
}

/// A graze, without the impacts beside it that have no rate either: where an orbit that hits one wall meets one that is its own mirror image
/// both walls are grazed at once, and so they are all along the curve.
fn without_other_grazes(mut begun: Begun, kind: SpecialKind) -> Result<Begun, PeriodicError> {
    loop {
        let mut lost = begun.shooting.slower_than(AT_ONCE).into_iter();
        let Some(other) = lost.find(|&index| begun.grazing != Some(index)) else {
            return Ok(begun);
        };
        let (mut shooting, at, _) = begun.shooting.without_event(&begun.at, other)?;
        shooting.evaluate(&at).map_err(failed)?;
        let Some(index) = shooting.without_rate() else {
            return Err(failed("all impacts that graze are one"));
        };
        let condition = (Condition::Monitor(index), Some(index));
        begun = found_again((shooting, at), condition, kind)?;
    }
}

/// The solution near a guess, at its last parameter; where that has its most or least value of all the curve, as in symmetric models, at the other.
fn found_again(
    (shooting, at): (Shooting<f64>, Vec<f64>),
    of: (Condition, Option<usize>),
    kind: SpecialKind,
) -> Result<Begun, PeriodicError> {
    let last = at.len() - 1;
    let found = |place: usize| {
        let held = Row::held(&at, place..place + 1);
        solved((shooting.clone(), at.clone()), of, kind, &held)
    };
    found(last).or_else(|why| match shooting.parameters() {
        2 => found(last - 1).map_err(|_| why),
        _ => Err(why),
    })
}

/// The solution near a guess, where one more row is held.
pub(super) fn solved(
    (mut shooting, at): (Shooting<f64>, Vec<f64>),
    (condition, grazing): (Condition, Option<usize>),
    kind: SpecialKind,
    held: &[Row<f64>],
) -> Result<Begun, PeriodicError> {
    let bordered = condition.near(&mut shooting, &at, None).map_err(failed)?;
    let found = newton(&mut bordered.of(&mut shooting), &at, held).map_err(failed)?;
    shooting.evaluate(&found.at).map_err(failed)?;
    is_the_one(&mut shooting, (&at, &found.at), kind)?;
    Ok(Begun {
        shooting,
        at: found.at,
        condition,
        grazing,
    })
}

/// A point is found again this near to where it was told, against the sizes of states and of the parameter.
const AGAIN: f64 = 1e-3;

/// Whether what was found is the point that was told, and one of its kind.
fn is_the_one(
    shooting: &mut Shooting<f64>,
    (told, found): (&[f64], &[f64]),
    kind: SpecialKind,
) -> Result<(), PeriodicError> {
    let (n, scales) = (shooting.state_sizes().len(), shooting.scales());
    let free = found.len() - shooting.parameters();
    let places = (0..n).chain([free]);
    let off = places.fold(0.0_f64, |most, place| {
        most.max((found[place] - told[place]).abs() / scales[place])
    });
    if off > AGAIN {
        return Err(PeriodicError::NotThere { kind, off });
    }
    let (multipliers, error) = shooting.multipliers_known();
    let is_of_kind = match kind {
        SpecialKind::Fold => is_near(&multipliers, 1.0),
        SpecialKind::PeriodDoubling => is_near(&multipliers, -1.0),
        SpecialKind::NeimarkSacker => {
            neutral(&multipliers).is_some_and(|(_, sum, _)| sum.abs() <= 2.0)
        }
        _ => true,
    };
    // Of multipliers that are not known nothing is asked.
    if is_of_kind || error.is_nan() || error > NEAR_ONE {
        return Ok(());
    }
    Err(PeriodicError::NotOfKind { kind, multipliers })
}

/// Where both halves of an orbit graze at once a branch of doubled orbits meets the simple ones, and the curve is theirs: the simple
/// orbit, without the impact that grazes.
fn gone_around_twice(shooting: &Shooting<f64>, at: &[f64], index: usize) -> Option<Cycle> {
    let (mut without, guess, _) = shooting.without_event(at, index).ok()?;
    without.evaluate(&guess).ok()?;
    shorter(&without, &guess).ok()?
}

/// The step that an impact without rate ends; where there is none yet, it comes in.
fn touched(shooting: &mut Shooting<f64>, at: &mut Vec<f64>) -> Result<usize, PeriodicError> {
    shooting.evaluate(at).map_err(failed)?;
    let rates: Vec<f64> = (shooting.steps.iter().zip(&shooting.latest))
        .map(|(step, landing)| {
            let rate = step.impact().map(|_| landing.surface_rate.abs());
            rate.unwrap_or(f64::INFINITY)
        })
        .collect();
    let finite = rates.iter().filter(|rate| rate.is_finite());
    let fastest = finite.fold(0.0_f64, |most, rate| most.max(*rate));
    let slowest = (0..rates.len()).min_by(|&a, &b| rates[a].total_cmp(&rates[b]));
    if let Some(index) = slowest.filter(|&index| rates[index] < SLOWEST * fastest) {
        return Ok(index);
    }
    let least = shooting.least(at).map_err(failed)?;
    // The gap that is nearly zero.
    let all = near_touches(shooting, (at, &least)).into_iter();
    let touch = all.min_by(|a, b| a.least.value.total_cmp(&b.least.value));
    let touch = touch.ok_or_else(|| failed("no flight comes near a contact"))?;
    comes_in((shooting, at), &least, &touch)
}

/// A place where a gap may be nearly zero: the step, and the contact.
struct Nearly<'l> {
    step: usize,
    contact: usize,
    least: &'l Least,
}

fn near_touches<'l>(
    shooting: &Shooting<f64>,
    (at, least): (&[f64], &'l [Vec<Least>]),
) -> Vec<Nearly<'l>> {
    let all = (least.iter().enumerate()).flat_map(|(step, all)| all.iter().map(move |l| (step, l)));
    let gaps = all.filter_map(|(step, least)| match least.guard {
        GuardKind::Gap(contact) => Some(Nearly {
            step,
            contact,
            least,
        }),
        _ => None,
    });
    // Where the flow turns with the rate of a gap the flight ends there.
    gaps.filter(|of| {
        !of.least.at_end || shooting.touches_at_turn((at, least), (of.step, of.contact))
    })
    .collect()
}

/// The orbit with an impact of no rate where a gap is nearly zero, and the step that it ends.
fn comes_in(
    (shooting, at): (&mut Shooting<f64>, &mut Vec<f64>),
    least: &[Vec<Least>],
    touch: &Nearly<'_>,
) -> Result<usize, PeriodicError> {
    // Where the flow turns with the rate of the gap the flight before the touch ends there, and the one after it begins.
    let (own, before) = (touch.step, shooting.before(touch.step));
    let is_start = touch.least.time <= AT_START * shooting.latest[own].duration;
    let mut turns = [Some(own), is_start.then_some(before)]
        .into_iter()
        .flatten();
    let known = (&**at, least);
    let turn = turns.find(|&turn| shooting.touches_at_turn(known, (turn, touch.contact)));
    let (longer, guess, index) = match turn {
        Some(turn) => shooting.with_impact_at_turn(at, (turn, touch.contact))?,
        None => shooting.with_event(at, touch.step, touch.least)?,
    };
    (*shooting, *at) = (longer, guess);
    Ok(index)
}

/// The step that an impact ends, or a touch, which is nearest to where a graze is known to be: beside the graze that may have a rate.
fn touched_at(
    shooting: &mut Shooting<f64>,
    at: &mut Vec<f64>,
    grazed: Grazed,
) -> Result<usize, PeriodicError> {
    shooting.evaluate(at).map_err(failed)?;
    let least = shooting.least(at).map_err(failed)?;
    let mut begins = vec![0.0];
    for landing in &shooting.latest {
        begins.push(begins[begins.len() - 1] + landing.duration);
    }
    let period = begins[begins.len() - 1];
    let off = |time: f64| {
        let off = time - grazed.time;
        (off - period * (off / period).round()).abs()
    };
    let impacts = (shooting.steps.iter().enumerate())
        .filter(|(_, step)| step.impact() == Some(grazed.contact))
        .map(|(index, _)| (off(begins[index + 1]), index));
    let impact = impacts.min_by(|a, b| a.0.total_cmp(&b.0));
    let touches = near_touches(shooting, (at, &least)).into_iter();
    let touches = touches
        .filter(|of| of.contact == grazed.contact)
        .map(|of| (off(begins[of.step] + of.least.time), of));
    let touch = touches.min_by(|a, b| a.0.total_cmp(&b.0));
    match (impact, touch) {
        (Some((late, index)), touch) if touch.as_ref().is_none_or(|(off, _)| late <= *off) => {
            Ok(index)
        }
        (_, Some((_, touch))) => comes_in((shooting, at), &least, &touch),
        _ => Err(failed("no flight comes near a contact")),
    }
}
