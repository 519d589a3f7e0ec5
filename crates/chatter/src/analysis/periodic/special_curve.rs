//! Curves of special points in two parameters: the equations of the orbit with the condition of the point.

use super::branch::{End, Limits, Point, SpecialKind, broken_at, station_at};
use super::error::PeriodicError;
use super::itinerary::read;
use super::settle::Cycle;
use super::shooting::{Shooting, Workshop};
use super::trace::{Instant, Tracer};
use crate::analysis::continuation::{
    Condition, Curve, Held, NewtonError, Problem, Singular, Station, StepError, newton,
};
use crate::flow::{Closed, GuardKind};
use core::ops::ControlFlow;
use std::sync::Arc;

/// A special point as it was told: enough to find it again.
#[derive(Clone, Debug)]
pub struct Known {
    /// Which kind.
    pub kind: SpecialKind,
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
    /// How its first and last ends came about.
    pub ends: [End; 2],
}

/// Before a graze orbits are looked at without the impact, and with it: an impact slower than this part of the fastest is the
/// grazing one.
const SLOWEST: f64 = 1e-5;
/// A period may be off by this part where an orbit is read again.
const LATE: f64 = 1e-6;
/// Borders are found anew where a curve has come this far, in steps.
const RENEWED: usize = 8;

fn failed(error: impl core::fmt::Display) -> PeriodicError {
    PeriodicError::NoConvergence {
        how: error.to_string(),
    }
}

/// The cycle of an orbit that goes through a state.
fn reread(workshop: &Workshop, free: &[f64], known: &Known) -> Result<Cycle, PeriodicError> {
    let parameters = workshop.parameters(free);
    let turns = workshop.closure.turns(&parameters)?;
    let state = &known.state;
    let mut tracer = Tracer::new(&workshop.system, &parameters, state, workshop.section)?;
    let start = workshop.model.time.map_or(0.0, |index| state[index]);
    let mut instants = vec![Instant {
        time: start,
        mode: tracer.trajectory.mode,
        pieces: tracer.trajectory.pieces().to_vec(),
        guard: None,
        told: Vec::new(),
        state: state.clone(),
        closed: Closed::NONE,
        mode_after: tracer.trajectory.mode,
    }];
    let mut quiet = |_: f64| ControlFlow::Continue(());
    let until = start + known.period * (1.0 + LATE);
    tracer.follow((until, usize::MAX / 2), &mut instants, &mut quiet)?;
    let Some(last) = instants.last() else {
        return Err(failed("the orbit is lost"));
    };
    let sizes: Vec<f64> = state.iter().map(|x| x.abs().max(1e-300)).collect();
    let difference = (workshop.closure).difference(&turns, (state, &last.state), &sizes);
    Ok(Cycle {
        steps: read(&instants)?,
        counts: difference.turns,
        distance: difference.distance,
    })
}

/// Equations, a solution of them with the condition, and for grazes the step that grazes.
struct Begun {
    shooting: Shooting<f64>,
    at: Vec<f64>,
    grazing: Option<usize>,
}

fn begin(workshop: &Arc<Workshop>, free: &[f64], known: &Known) -> Result<Begun, PeriodicError> {
    let cycle = reread(workshop, free, known)?;
    let mut shooting = Shooting::<f64>::new(workshop, cycle.steps, cycle.counts)?;
    let mut at = shooting.guess(free);
    let mut grazing = None;
    if matches!(
        known.kind,
        SpecialKind::FlightGraze | SpecialKind::ImpactGraze
    ) {
        shooting.evaluate(&at).map_err(failed)?;
        let rates: Vec<f64> = (shooting.steps.iter().zip(&shooting.latest))
            .map(|(step, landing)| {
                step.impact()
                    .map_or(f64::INFINITY, |_| landing.surface_rate.abs())
            })
            .collect();
        let finite = rates.iter().filter(|rate| rate.is_finite());
        let fastest = finite.fold(0.0_f64, |most, rate| most.max(*rate));
        let slowest = (0..rates.len()).min_by(|&a, &b| rates[a].total_cmp(&rates[b]));
        grazing =
            slowest.filter(|&index| rates[index] < SLOWEST * fastest && index + 1 < rates.len());
        if grazing.is_none() {
            // The gap that is nearly zero.
            let least = shooting.least(&at).map_err(failed)?;
            let touching = (least.iter().enumerate())
                .flat_map(|(index, all)| all.iter().map(move |l| (index, l)))
                .filter(|(_, l)| !l.at_end && matches!(l.guard, GuardKind::Gap(_)))
                .min_by(|(_, a), (_, b)| a.value.total_cmp(&b.value));
            let Some((index, least)) = touching else {
                return Err(failed("no flight comes near a contact"));
            };
            let least = least.clone();
            (shooting, at) = shooting.with_event(&at, index, &least)?;
            grazing = Some(index);
        }
    }
    let size = at.len();
    let held = Condition::fixed(size, size - 1, at[size - 1]);
    let found = solve(&mut shooting, (known.kind, grazing), &at, &[held]).map_err(failed)?;
    shooting.evaluate(&found).map_err(failed)?;
    Ok(Begun {
        shooting,
        at: found,
        grazing,
    })
}

/// The equations with the condition of a kind of point.
fn hold<'p>(
    shooting: &'p mut Shooting<f64>,
    (kind, grazing): (SpecialKind, Option<usize>),
    at: &[f64],
) -> Result<Held<'p, f64, Shooting<f64>>, NewtonError> {
    let sign = match (kind, grazing) {
        (_, Some(index)) => return Ok(Held::monitor(shooting, index)),
        (SpecialKind::PeriodDoubling, _) => -1.0,
        _ => 1.0,
    };
    let singular = Singular::near(shooting, at, sign).map_err(NewtonError::Left)?;
    Ok(Held::singular(shooting, singular))
}

fn solve(
    shooting: &mut Shooting<f64>,
    kind: (SpecialKind, Option<usize>),
    at: &[f64],
    conditions: &[Condition<f64>],
) -> Result<Vec<f64>, NewtonError> {
    let mut held = hold(shooting, kind, at)?;
    Ok(newton(&mut held, at, conditions)?.at)
}

/// Follows a special point over the last free parameter, to both sides.
pub(crate) fn follow(
    workshop: &Arc<Workshop>,
    (free, known): (&[f64], &Known),
    limits: &Limits,
    observer: &mut dyn FnMut(&Point) -> ControlFlow<()>,
) -> Result<SpecialCurve, PeriodicError> {
    if !matches!(
        known.kind,
        SpecialKind::Fold
            | SpecialKind::PeriodDoubling
            | SpecialKind::FlightGraze
            | SpecialKind::ImpactGraze
    ) {
        return Err(PeriodicError::Unfollowed {
            what: format!("a {} in two parameters", known.kind.name()),
        });
    }
    let begun = begin(workshop, free, known)?;
    let kind = (known.kind, begun.grazing);
    let last = begun.at.len() - 1;
    let mut sides = Vec::new();
    let mut first = None;
    for forward in [false, true] {
        let mut shooting = begun.shooting.clone();
        let station = {
            let mut held = hold(&mut shooting, kind, &begun.at).map_err(failed)?;
            Station::near(&mut held, &begun.at, last).map_err(failed)?
        };
        let station = if forward { station } else { station.reversed() };
        shooting.evaluate(&station.at).map_err(failed)?;
        first.get_or_insert_with(|| Point::new(&shooting, &station));
        sides.push(side(shooting, kind, station, limits, observer));
    }
    let (forward, back) = (sides.pop(), sides.pop());
    let (Some((forward, end)), Some((mut back, begin))) = (forward, back) else {
        return Err(PeriodicError::Interrupted);
    };
    back.reverse();
    back.extend(first);
    back.extend(forward);
    Ok(SpecialCurve {
        kind: known.kind,
        points: back,
        ends: [begin, end],
    })
}

fn side(
    mut shooting: Shooting<f64>,
    kind: (SpecialKind, Option<usize>),
    station: Station,
    limits: &Limits,
    observer: &mut dyn FnMut(&Point) -> ControlFlow<()>,
) -> (Vec<Point>, End) {
    let mut curve = Curve::new(station, limits.settings());
    let mut points = Vec::new();
    while points.len() < limits.points {
        let at = curve.station.at.clone();
        let mut held = match hold(&mut shooting, kind, &at) {
            Ok(held) => held,
            Err(error) => return (points, End::Lost(error.to_string())),
        };
        for _ in 0..RENEWED {
            let (mut next, step) = match curve.next(&mut held) {
                Ok(found) => found,
                Err(StepError::TooShort(error)) => return (points, End::Lost(error.to_string())),
            };
            let edge = limits.beyond(next.parameter());
            if let Some(edge) = edge
                && let Some((station, _)) =
                    station_at(&mut held, (&curve.station, &next), step, edge)
            {
                next = station;
            }
            let (told, breaks) = {
                let reader = held.problem_mut();
                if let Err(left) = reader.evaluate(&next.at) {
                    return (points, End::Lost(left.to_string()));
                }
                let breaks = broken_at(reader, &next.at, kind.1);
                (Point::new(reader, &next), breaks)
            };
            if breaks {
                return (
                    points,
                    End::Lost("the sequence of events changes".to_owned()),
                );
            }
            // Told of the orbit without the impact that grazes.
            let told = match kind.1 {
                Some(_) => Point {
                    impacts: told.impacts.map(|count| count.saturating_sub(1)),
                    ..told
                },
                None => told,
            };
            let on = observer(&told);
            points.push(told);
            if edge.is_some() {
                return (points, End::Range);
            }
            if on.is_break() {
                return (points, End::Interrupted);
            }
            curve.moves(next);
            held.problem_mut().adopt(&curve.station.at);
        }
    }
    (points, End::Points)
}
