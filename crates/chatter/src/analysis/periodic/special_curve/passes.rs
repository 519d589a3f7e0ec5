//! Whether a curve goes through a special point that another one was begun at: then both are one.

use super::start::{begin, failed};
use super::{Known, follow};
use crate::analysis::continuation::Problem;
use crate::analysis::periodic::branch::{End, Limits, Point};
use crate::analysis::periodic::diary::{Diary, Told};
use crate::analysis::periodic::error::PeriodicError;
use crate::analysis::periodic::shooting::Workshop;
use core::ops::ControlFlow;
use std::sync::Arc;

/// Two orbits that were solved for at one value of the second parameter are one if they are this near, against their sizes.
const SAME: f64 = 1e-7;
/// Between two of its points a curve is no farther from the straight way than this part of that, or of those beside it.
const BESIDE: f64 = 0.5;
/// More stations than there are between two points of a curve that was followed with the same steps.
const STATIONS: usize = 200;

/// Whether the curve of these points passes the point, which is one of the same kind at these free parameters. Polynomials through points
/// say where a curve is between them, but not how well: beside a cusp or a graze they say it the worse the longer the steps were. So
/// the curve of the point itself is followed from there to where the other one has a point.
///
/// # Errors
/// The point cannot be found again.
pub(crate) fn passes(
    workshop: &Arc<Workshop>,
    (free, known): (&[f64], &Known),
    limits: &Limits,
    points: &[Point],
) -> Result<bool, PeriodicError> {
    let own = Landmarks::of(workshop, free, known)?;
    let place = |point: &Point| own.measured([&*point.parameters, &[point.period]].concat());
    let here = own.measured([free, &[own.period]].concat());
    let places: Vec<Vec<f64>> = points.iter().map(place).collect();
    let is_beside = |index: usize| is_beside(&here, &places, index);
    // The end of a piece is the beginning of the next one.
    let ends = (0..points.len()).filter(|&index| {
        let before = index > 0 && is_beside(index - 1);
        before || (index + 1 < points.len() && is_beside(index))
    });
    for point in ends.map(|index| &points[index]) {
        // Where the way there is none that can be gone there are others.
        let leads = || leads_to(workshop, (free, known), limits, point).unwrap_or(false);
        if own.are_those_of(point)? || leads() {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Whether the curve from a point comes to another one where it has that one's second parameter.
fn leads_to(
    workshop: &Arc<Workshop>,
    (free, known): (&[f64], &Known),
    limits: &Limits,
    point: &Point,
) -> Result<bool, PeriodicError> {
    let (from, to) = (free[1], point.parameters[1]);
    if from == to {
        return Ok(false);
    }
    let up_to = Limits {
        range: (from.min(to), from.max(to)),
        points: STATIONS,
        ..*limits
    };
    let mut quiet = |_: Told<'_>| ControlFlow::Continue(());
    let mut diary = Diary::new(Vec::new(), &mut quiet);
    let curve = follow(workshop, (free, known), &up_to, &mut diary)?;
    let ends = [curve.points.first(), curve.points.last()].into_iter();
    for (end, how) in ends.flatten().zip(&curve.ends) {
        if *how != End::Range {
            continue;
        }
        let there = Known {
            state: end.state.clone(),
            period: end.period,
            ..known.clone()
        };
        if Landmarks::of(workshop, &end.parameters, &there)?.are_those_of(point)? {
            return Ok(true);
        }
    }
    Ok(false)
}

/// What an orbit is known by, from wherever it is told.
struct Landmarks<'w> {
    workshop: &'w Workshop,
    parameters: Vec<f64>,
    period: f64,
    states: Vec<Vec<f64>>,
    sizes: Vec<f64>,
}

impl<'w> Landmarks<'w> {
    fn of(workshop: &'w Arc<Workshop>, free: &[f64], known: &Known) -> Result<Self, PeriodicError> {
        let mut begun = begin(workshop, free, known)?;
        let shooting = &mut begun.shooting;
        shooting.evaluate(&begun.at).map_err(failed)?;
        Ok(Self {
            workshop,
            states: shooting.landmarks(&begun.at),
            parameters: shooting.free(&begun.at).to_vec(),
            period: shooting.period(),
            sizes: shooting.state_sizes(),
        })
    }

    /// Free parameters and period, each against its size.
    fn measured(&self, numbers: Vec<f64>) -> Vec<f64> {
        let sizes = self.workshop.sizes.iter().chain([&self.period]);
        numbers
            .iter()
            .zip(sizes)
            .map(|(x, size)| x / size)
            .collect()
    }

    /// Whether a point of a curve is this orbit.
    fn are_those_of(&self, point: &Point) -> Result<bool, PeriodicError> {
        let own = self.measured([&*self.parameters, &[self.period]].concat());
        let other = self.measured([&*point.parameters, &[point.period]].concat());
        if own.iter().zip(&other).any(|(x, y)| (x - y).abs() > SAME) {
            return Ok(false);
        }
        let parameters = self.workshop.parameters(&self.parameters);
        let turns = self.workshop.closure.turns(&parameters)?;
        let states = (&[point.state.clone()][..], &*self.states);
        Ok(self
            .workshop
            .closure
            .share(&turns, states, &self.sizes, SAME))
    }
}

/// Whether a place may lie on a curve between one of its points and the next.
fn is_beside(here: &[f64], points: &[Vec<f64>], index: usize) -> bool {
    let length = |of: &[f64]| of.iter().fold(0.0, |sum, x| sum + x * x).sqrt();
    let way = |index: usize| -> Vec<f64> {
        let ends = points[index + 1].iter().zip(&points[index]);
        ends.map(|(to, from)| to - from).collect()
    };
    let last = (index + 2).min(points.len() - 1);
    let longest =
        (index.saturating_sub(1)..last).fold(0.0, |most: f64, k| most.max(length(&way(k))));
    let (own, from) = (way(index), &points[index]);
    let to_here: Vec<f64> = here.iter().zip(from).map(|(x, y)| x - y).collect();
    let square = length(&own) * length(&own);
    let along: f64 = own.iter().zip(&to_here).map(|(x, y)| x * y).sum();
    let part = if square > 0.0 {
        (along / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let off: Vec<f64> = to_here
        .iter()
        .zip(&own)
        .map(|(x, y)| x - part * y)
        .collect();
    length(&off) <= (BESIDE * longest).max(SAME)
}
