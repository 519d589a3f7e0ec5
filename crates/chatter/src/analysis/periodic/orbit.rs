//! One periodic orbit, closed by Newton's method.

use super::cycle::itinerary::{Passage, Step};
use super::cycle::settle::cycle::Cycle;
use super::cycle::settle::{Patience, settle};
use super::error::PeriodicError;
use super::margins::{Margin, margins};
use super::multipliers::{is_neutral, is_stable};
use super::shooting::{Shooting, Workshop, lies_on};
use crate::analysis::continuation::{Condition, NewtonError, Problem, approach, newton};
use crate::flow::leg::onto_gaps;
use crate::flow::{Closed, GuardKind};
use crate::model::greatest_common_divisor;
use crate::numerics::{Complex, DoubleDouble, Real, Scalar};
use core::ops::ControlFlow;
use std::sync::Arc;

/// A periodic orbit.
#[derive(Clone, Debug)]
pub struct Orbit {
    /// How long it takes.
    pub period: DoubleDouble,
    /// The state that it is told from: just after an event.
    pub start: Vec<DoubleDouble>,
    /// The section that it starts at, if it does.
    pub section: Option<usize>,
    /// All parameters.
    pub parameters: Vec<f64>,
    /// Impacts a period; none where infinitely many.
    pub impacts: Option<u64>,
    /// Whole turns of each phase in a period, by state.
    pub turns: Vec<(usize, i64)>,
    /// All but the trivial one, the largest first.
    pub multipliers: Vec<Complex>,
    /// What moduli of multipliers about the unit circle may be off by.
    pub modulus_error: f64,
    /// Where the flow itself has one, which is 1 as far as derivatives are right.
    pub trivial_multiplier: Option<f64>,
    /// Largest residual of its equations.
    pub residual: f64,
    /// The latest correction against the size of the state.
    pub correction: f64,
    /// How near it is to losing its sequence of events.
    pub margins: Vec<Margin>,
    /// Its equations, for continuing it.
    pub(crate) shooting: Shooting<f64>,
    pub(crate) at: Vec<f64>,
}

impl Orbit {
    /// Whether all multipliers lie inside the unit circle by more than they may be off by.
    pub fn is_stable(&self) -> bool {
        is_stable(&self.multipliers, self.modulus_error)
    }

    /// Whether none lies outside the unit circle, and some on it as far as they are known.
    pub fn is_neutral(&self) -> bool {
        is_neutral(&self.multipliers, self.modulus_error)
    }
}

pub(super) fn failed(error: &NewtonError) -> PeriodicError {
    PeriodicError::NoConvergence {
        how: error.to_string(),
    }
}

/// The orbit that the trajectory from a state settles to at these free parameters.
pub(crate) fn settled(
    workshop: &Arc<Workshop>,
    free: &[f64],
    state: &[f64],
    patience: Patience,
    observer: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<Orbit, PeriodicError> {
    settled_if(workshop, free, (state, patience), &|_| true, observer)
}

/// The same, if the cycle is one that is wanted: others are not closed, which for many events is long work.
pub(crate) fn settled_if(
    workshop: &Arc<Workshop>,
    free: &[f64],
    (state, patience): (&[f64], Patience),
    is_wanted: &dyn Fn(&Cycle) -> bool,
    observer: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<Orbit, PeriodicError> {
    let cycle = settle(workshop, free, state, patience, observer)?;
    if !is_wanted(&cycle) {
        return Err(PeriodicError::Unfollowed {
            what: "a cycle that is not asked for".to_owned(),
        });
    }
    let nearest = cycle.distance;
    close(workshop, cycle, free).map_err(|error| match error {
        PeriodicError::NoConvergence { how } if nearest > NEAR => {
            PeriodicError::NotRepeated { nearest, how }
        }
        error => error,
    })
}

/// A cycle is closed but for so much where Newton's method needs no care.
const NEAR: f64 = 1e-7;

/// Closes a cycle at these free parameters, in doubles and then in longer numbers.
pub(crate) fn close(
    workshop: &Arc<Workshop>,
    cycle: Cycle,
    free: &[f64],
) -> Result<Orbit, PeriodicError> {
    let mut cycle = cycle;
    let parameters = workshop.parameters(free);
    cycle.begin_at_section(workshop, &parameters)?;
    cycle.come_back(workshop);
    let mut shooting = Shooting::<f64>::new(workshop, cycle.steps, cycle.counts)?;
    shooting.keep_sizes(&cycle.sizes);
    let guess = shooting.guess(free);
    let rows = Condition::held(&guess, guess.len() - free.len()..guess.len());
    let near = if cycle.distance > NEAR {
        approach(&mut shooting, &guess, &rows).map_err(|error| failed(&error))?
    } else {
        guess
    };
    let failed = match newton(&mut shooting, &near, &rows) {
        Err(error) => failed(&error),
        Ok(found) if is_at_rest(&shooting, &found.at) => PeriodicError::AtRest,
        Ok(found) => {
            shooting.adopt(&found.at);
            if let Some(index) = shooting.passed(&found.at) {
                let (shooting, at) = shooting.exchanged_and_solved(&found.at, index)?;
                // Of two that share an instant either may be first by a rounding: whether that matters is told with the orbit.
                return match shooting.passed(&at) {
                    Some(again) if !shooting.shares_instant(&at, again) => {
                        Err(PeriodicError::NoConvergence {
                            how: format!("events {index} and {} change places", index + 1),
                        })
                    }
                    _ => finish(shooting, at),
                };
            }
            if let Some(cycle) = shorter(&shooting, &found.at)? {
                return close(workshop, cycle, free);
            }
            // What solves equations that are singular does so for many, and in longer numbers for another.
            match finish(shooting.clone(), found.at) {
                Err(error @ PeriodicError::NoConvergence { .. }) => error,
                told => return told,
            }
        }
    };
    if cycle.distance <= NEAR && is_singular(&mut shooting, &near) {
        let moduli = shooting.multipliers().into_iter().map(|m| m.modulus());
        let least = moduli.fold(1.0, f64::min);
        return Err(PeriodicError::OneOfMany { least });
    }
    Err(failed)
}

/// Beside a closed cycle with a multiplier as near to one there are others.
const SINGULAR: f64 = 1e-4;

/// Whether a multiplier beside the trivial one is one, as far as numbers can tell.
fn is_singular(shooting: &mut Shooting<f64>, at: &[f64]) -> bool {
    let is_one = |m: &Complex| (m.re - 1.0).hypot(m.im) <= SINGULAR;
    shooting.evaluate(at).is_ok() && shooting.multipliers().iter().any(is_one)
}

/// States that change by less than this part of what they do on the cycle that an orbit was closed from are at rest.
const AT_REST: f64 = 1e-9;

/// Whether an autonomous system is at rest at all nodes.
fn is_at_rest(shooting: &Shooting<f64>, at: &[f64]) -> bool {
    let model = &shooting.workshop.model;
    if shooting.workshop.closure.time.is_some() || shooting.counts.iter().any(|&count| count != 0) {
        return false;
    }
    let parameters = shooting.workshop.parameters::<f64>(shooting.free(at));
    let (sizes, period) = (shooting.state_sizes(), shooting.period());
    (0..shooting.steps.len()).all(|index| {
        let node = shooting.node(at, index);
        (model.states.iter().zip(&sizes)).all(|(state, size)| {
            let rate = model.graph.evaluate(state.derivative, node, &parameters);
            (rate * period).abs() <= AT_REST * size
        })
    })
}

/// The same orbit as it is told: from the section, where it crosses it though the cycle that it was closed from did not.
pub(crate) fn as_told(orbit: Orbit) -> Orbit {
    let mut shooting = orbit.shooting.clone();
    let anew = told_anew(&mut shooting, &orbit.at);
    let anew = anew.and_then(|(shooting, at)| finish(shooting, at).ok());
    anew.unwrap_or(orbit)
}

/// An orbit told from the section, where it crosses it though the cycle that it was closed from did not; one on which nothing
/// happens from where its forcing begins.
fn told_anew(shooting: &mut Shooting<f64>, at: &[f64]) -> Option<(Shooting<f64>, Vec<f64>)> {
    if shooting.begins_at_section() {
        return None;
    }
    let (mut other, guess) = match shooting.with_section(at).ok()? {
        Some(longer) => longer,
        None => shooting.told_from_phase_zero(at)?,
    };
    let held = Condition::held(&guess, guess.len() - shooting.parameters()..guess.len());
    let found = newton(&mut other, &guess, &held).ok()?;
    other.adopt(&found.at);
    Some((other, found.at))
}

/// Two nodes of one orbit that are this near, against their size, are one: the orbit was gone around more than once.
const SAME_NODE: f64 = 1e-7;

/// The part of a cycle that comes back to its first node, where it does so before its end.
pub(crate) fn shorter(
    shooting: &Shooting<f64>,
    at: &[f64],
) -> Result<Option<Cycle>, PeriodicError> {
    let workshop = &shooting.workshop;
    let parameters = workshop.parameters(shooting.free(at));
    let turns = workshop.closure.turns(&parameters)?;
    let sizes = shooting.state_sizes();
    let steps = &shooting.steps;
    let count = steps.len();
    if let [only] = &steps[..]
        && matches!(only.passage, Passage::Timed(_))
    {
        return Ok(part_of_timed(shooting, at));
    }
    // Of crossings of the section one alone is an event.
    for crossing in shooting.other_crossings(at) {
        let nodes = (shooting.node(at, 0), &*crossing.state);
        let difference = workshop.closure.difference(&turns, nodes, &sizes);
        if difference.distance < SAME_NODE && turns.is_empty() {
            let mut steps = shooting.current_steps(at);
            steps[0].duration = crossing.time;
            return Ok(Some(Cycle {
                steps,
                counts: difference.turns,
                distance: difference.distance,
                sizes,
            }));
        }
    }
    let arrives = |index: usize| steps[shooting.before(index)].passage;
    // An impact without rate, as at a graze, is none: there the parts are told by the others. Parts that are like one another have a first one.
    let rate = |index: usize| {
        let before = shooting.before(index);
        let hits = steps[before].impact().is_some();
        let landing = shooting.latest.get(before).filter(|_| hits);
        landing.map_or(0.0, |landing| landing.surface_rate.abs())
    };
    let fastest = (0..count).map(rate).fold(0.0, f64::max);
    let fast = (0..count).find(|&index| rate(index) > 0.5 * fastest);
    let firsts = [0].into_iter().chain(fast.filter(|&index| index > 0));
    for (first, index) in
        firsts.flat_map(|first| (first + 1..count).map(move |index| (first, index)))
    {
        if arrives(index) != arrives(first) || steps[index].passage != steps[first].passage {
            continue;
        }
        let nodes = (shooting.node(at, first), shooting.node(at, index));
        let difference = workshop.closure.difference(&turns, nodes, &sizes);
        let goes_on = turns.is_empty() || difference.turns.iter().any(|turns| *turns != 0);
        if difference.distance < SAME_NODE && goes_on {
            return Ok(Some(Cycle {
                steps: shooting.current_steps(at)[first..index].to_vec(),
                counts: difference.turns,
                distance: difference.distance,
                sizes,
            }));
        }
    }
    Ok(None)
}

/// The same of an orbit on which nothing happens: no node tells that it was gone around more than once, but its shorter parts do.
fn part_of_timed(shooting: &Shooting<f64>, at: &[f64]) -> Option<Cycle> {
    let counts = shooting.counts.iter();
    let most = counts.fold(0, |common, count| {
        greatest_common_divisor(common, count.abs())
    });
    (2..=most).rev().find_map(|parts| {
        if most % parts != 0 {
            return None;
        }
        let counts: Vec<i64> = shooting.counts.iter().map(|count| count / parts).collect();
        let mut steps = shooting.current_steps(at);
        steps[0].duration /= parts as f64;
        let mut part = Shooting::new(&shooting.workshop, steps.clone(), counts.clone()).ok()?;
        let off = part.evaluate(at).ok()?.residual;
        let sizes = shooting.state_sizes();
        let distance =
            (off.iter().zip(&sizes)).fold(0.0_f64, |most, (x, size)| most.max(x.abs() / size));
        (distance < SAME_NODE).then_some(Cycle {
            steps,
            counts,
            distance,
            sizes,
        })
    })
}

/// An orbit whose equations are solved in doubles, told in longer numbers.
pub(crate) fn finish(mut shooting: Shooting<f64>, at: Vec<f64>) -> Result<Orbit, PeriodicError> {
    let workshop = shooting.workshop.clone();
    let free = workshop.free.len();
    let mut fine = shooting.in_longer_numbers(&at)?;
    let start: Vec<DoubleDouble> = at.iter().map(|&x| x.into()).collect();
    let rows = Condition::held(&start, start.len() - free..start.len());
    let found = newton(&mut fine, &start, &rows).map_err(|error| failed(&error))?;
    let checked = (fine.evaluate(&found.at)).map_err(|left| failed(&NewtonError::Left(left)))?;
    let residual = (checked.residual.iter()).fold(0.0_f64, |most, x| most.max(x.to_f64().abs()));
    // What is followed as a whole may lead elsewhere once more.
    let apart = fine.apart(&checked.residual);
    if apart.is_nan() || apart > SAME_NODE {
        return Err(PeriodicError::NoConvergence {
            how: format!("the orbit does not close: it is off by {apart:.1e} of its size"),
        });
    }
    let (multipliers, modulus_error) = fine.multipliers_known();
    if multipliers.iter().any(|m| !m.modulus().is_finite()) {
        return Err(PeriodicError::Boundless);
    }
    shooting
        .evaluate(&at)
        .map_err(|left| failed(&NewtonError::Left(left)))?;
    let order =
        (shooting.depends_on_order(&at)).map_err(|left| failed(&NewtonError::Left(left)))?;
    if let Some(index) = shooting.tie().or(order) {
        let step = &shooting.steps[index];
        return Err(match (step.impact(), step.ends_at()) {
            (Some(contact), _) => PeriodicError::OrderMatters {
                contact: workshop.model.contacts[contact].name.clone(),
            },
            (None, guard) => PeriodicError::OrderOfCorners {
                corner: guard.map_or_else(String::new, |guard| workshop.named(guard)),
            },
        });
    }
    let guard = shooting.order_at_jumps(&at);
    if let Some(guard) = guard.map_err(|left| failed(&NewtonError::Left(left)))? {
        return Err(PeriodicError::OrderOfCorners {
            corner: workshop.named(guard),
        });
    }
    let margins = margins(&mut shooting, &at)?;
    let parameters = workshop.parameters(&at[at.len() - free..]);
    let turns = workshop.closure.turns::<f64>(&parameters)?;
    let ends_with = |section: &usize| {
        let last = shooting.steps.last().and_then(Step::ends_at);
        last == Some(GuardKind::Section(*section))
    };
    let period = fine.period();
    let lies_on =
        |_: &usize| workshop.is_on_section(shooting.node(&at, 0), &parameters, period.to_f64());
    let section = workshop.section;
    let section = section.filter(|section| ends_with(section) || lies_on(section));
    Ok(Orbit {
        period,
        start: cleaned(&told_start(&fine, &found.at), &shooting.state_sizes()),
        section,
        parameters,
        impacts: shooting.impacts(),
        turns: (turns.iter().zip(&shooting.counts))
            .map(|(turn, &count)| (turn.state, count))
            .collect(),
        multipliers,
        modulus_error,
        trivial_multiplier: fine.trivial_multiplier(&found.at),
        residual,
        correction: found.correction,
        margins,
        shooting,
        at,
    })
}

/// The state that an orbit is told from, on the contacts that hold it or that impacts have just struck.
pub(super) fn told_start<R: Real>(shooting: &Shooting<R>, at: &[R]) -> Vec<R> {
    let workshop = &shooting.workshop;
    let on = lies_on(&workshop.system, &shooting.steps, shooting.steps.len() - 1);
    let touching = Closed(shooting.closed_before(0).0 | on.0);
    let gaps: Vec<_> = (touching.contacts())
        .map(|contact| workshop.model.contacts[contact].gap)
        .collect();
    let mut start = shooting.node(at, 0).to_vec();
    let parameters = workshop.parameters(shooting.free(at));
    onto_gaps(&workshop.model, (&gaps, 1), &parameters, &mut start);
    start
}

/// What is nothing but rounding of a state's size is nothing: a state on a contact at zero is told as zero. In doubles it is what
/// longer numbers would round, since the rate at a graze is small without being nothing.
pub(crate) fn cleaned<R: Real>(state: &[R], sizes: &[f64]) -> Vec<R> {
    let rounding = 64.0 * <DoubleDouble as Scalar>::ROUNDOFF;
    (state.iter().zip(sizes))
        .map(|(&x, size)| {
            if x.to_f64().abs() <= rounding * size {
                R::ZERO
            } else {
                x
            }
        })
        .collect()
}
