//! Whether a curve goes through a special point that another one was begun at: then both are one.

use super::Known;
use super::start::{begin, failed};
use crate::analysis::continuation::Problem;
use crate::analysis::periodic::branch::Point;
use crate::analysis::periodic::error::PeriodicError;
use crate::analysis::periodic::shooting::Workshop;
use crate::numerics::root_between;
use std::sync::Arc;

/// Between its points a curve is known by polynomials through so many of them: to this part of what the lowest order is off by, …
const THROUGH: usize = 4;
const OF_LOWEST: f64 = 0.1;
/// … and no better than to this part of the sizes.
const AT_BEST: f64 = 1e-7;

/// Whether the curve of these points passes the point, which is one of the same kind at these free parameters.
///
/// # Errors
/// The point cannot be found again.
pub(crate) fn passes(
    workshop: &Arc<Workshop>,
    (free, known): (&[f64], &Known),
    points: &[Point],
) -> Result<bool, PeriodicError> {
    let mut begun = begin(workshop, free, known)?;
    let shooting = &mut begun.shooting;
    shooting.evaluate(&begun.at).map_err(failed)?;
    let landmarks = shooting.landmarks(&begun.at);
    let values = shooting.free(&begun.at).to_vec();
    let [value, held] = values[..] else {
        return Ok(false);
    };
    let (period, states) = (shooting.period(), shooting.state_sizes());
    let sizes = [&*workshop.sizes, &[period], &*states].concat();
    let parameters = workshop.parameters(&values);
    let turns = workshop.closure.turns(&parameters)?;
    let numbers = |point: &Point| -> Vec<f64> {
        let all = [&*point.parameters, &[point.period], &*point.state].concat();
        all.iter().zip(&sizes).map(|(x, size)| x / size).collect()
    };
    let held = held / sizes[1];
    Ok((1..points.len()).any(|next| {
        let first = next.saturating_sub(THROUGH / 2);
        let last = (first + THROUGH).min(points.len());
        let around: Vec<Vec<f64>> = points[first..last].iter().map(numbers).collect();
        let ends = [next - 1 - first, next - first];
        let Some((there, off)) = where_held(&around, ends, held) else {
            return false;
        };
        let is_near = |place: usize, other: f64| {
            (there[place] - other / sizes[place]).abs() <= off[place].max(AT_BEST)
        };
        let scaled = there[3..].iter().zip(&states);
        let state: Vec<f64> = scaled.map(|(x, size)| x * size).collect();
        let near = off[3..].iter().fold(AT_BEST, |most, off| most.max(*off));
        is_near(0, value)
            && is_near(2, period)
            && (workshop.closure).share(&turns, (&[state], &landmarks), &states, near)
    }))
}

/// Where, between two neighbours, the second of a curve's numbers has a value: all of them there, and what each may be off by.
fn where_held(
    around: &[Vec<f64>],
    [from, to]: [usize; 2],
    held: f64,
) -> Option<(Vec<f64>, Vec<f64>)> {
    if around.len() < THROUGH.min(3) || (around[from][1] - held) * (around[to][1] - held) > 0.0 {
        return None;
    }
    // How far along the curve each of them is.
    let mut lengths = vec![0.0];
    for pair in around.windows(2) {
        let steps = pair[0].iter().zip(&pair[1]);
        let step = steps
            .fold(0.0, |sum, (a, b)| sum + (b - a) * (b - a))
            .sqrt();
        lengths.push(lengths[lengths.len() - 1] + step);
    }
    // Lagrange's polynomial.
    let at = |along: f64, place: usize, through: core::ops::Range<usize>| -> f64 {
        let weight = |one: usize| {
            let others = through.clone().filter(|&other| other != one);
            others.fold(1.0, |product, other| {
                product * (along - lengths[other]) / (lengths[one] - lengths[other])
            })
        };
        { through.clone() }.fold(0.0, |sum, one| sum + weight(one) * around[one][place])
    };
    let all = 0..around.len();
    let along = root_between(
        |along| at(along, 1, all.clone()) - held,
        lengths[from],
        lengths[to],
    )?;
    let there = (0..around[from].len()).map(|place| {
        let value = at(along, place, all.clone());
        let lowest = at(along, place, from..to + 1);
        (value, OF_LOWEST * (value - lowest).abs())
    });
    Some(there.unzip())
}
