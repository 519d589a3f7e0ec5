//! Exact coefficients of the one-dimensional return map near a border orbit, (M5).

use super::super::coordinate::local::Slopes;
use super::super::coordinate::root::Point;
use super::super::error::BorderError;
use super::super::problem::Problem;
use crate::numerics::{Estimate, Real, dot, with_rounding};
use serde::{Deserialize, Serialize};

with_rounding! {
    /// Coefficients of z -> Upsilon(K z + mu), mu = M (p - p*), and what they are made of.
    ///
    /// States after the first impact lie on the contact surface. They are given by all of the model's states but one, the
    /// [`section`](super::super::Border::section) coordinates.
    ///
    /// With more than three states orbits remember where they were released: the map is that of orbits that repeat after one
    /// passage, and [`Memory`](Memory) has what others need.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    pub struct Exact<R> {
        /// K = C A B.
        pub slope: Estimate<R>,
        /// M = C ds_0/dp + D.
        pub unfolding_rate: Estimate<R>,
        /// N* of (M4).
        pub amplitude: Estimate<R>,
        /// A B: the change of the first impact, all states, that Upsilon = 1 makes.
        pub first_impact_by_upsilon: Vec<Estimate<R>>,
        /// ds_0/dp: how the first impact moves with the parameter, release point included, all states.
        pub first_impact_by_parameter: Vec<Estimate<R>>,
        /// A: derivative of the first impact by the state at release, a row for each of the model's states.
        pub flight: Vec<Vec<Estimate<R>>>,
        /// B: the offset at release that Upsilon = 1 makes, in orbits that repeat.
        pub offset: Vec<Estimate<R>>,
        /// C = dX/ds_0 in the section coordinates.
        pub covector: Vec<Estimate<R>>,
        /// D = dX/dp at fixed section coordinates.
        pub covector_parameter: Estimate<R>,
        /// With more than three states what orbits remember from passage to passage.
        pub memory: Option<Memory<R>>,
    }
}

with_rounding! {
    /// How orbits remember the coordinates y of the point where they were released, told from where the orbit at this parameter with
    /// Upsilon = 0 is: x = k z + c y + mu, then z' = Upsilon(x) and y' = R y + b z.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    pub struct Memory<R> {
        /// The states that are coordinates.
        pub states: Vec<usize>,
        /// R: how they return, a row for each.
        pub returns: Vec<Vec<R>>,
        /// b: what Upsilon = 1 adds.
        pub by_upsilon: Vec<R>,
        /// How those of the border orbit move with the parameter.
        pub by_parameter: Vec<R>,
        /// c = dX/dy.
        pub covector: Vec<R>,
        /// k: the slope where nothing is remembered. K = k + c (1 - R)^-1 b.
        pub slope: R,
        /// The slope at which the period doubles: k - c (1 + R)^-1 b.
        pub doubling_slope: R,
        /// The change of the first impact, all states, that Upsilon = 1 makes where nothing is remembered.
        pub first_impact_by_upsilon: Vec<R>,
        /// The change that each coordinate makes.
        pub first_impact_by_memory: Vec<Vec<R>>,
    }
}

/// The states that parametrise the contact surface h = 0 at a point, and how the one left out follows them.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SectionChart<R> {
    /// Indices of the coordinates.
    pub free: Vec<usize>,
    /// Index of the state that follows.
    pub bound: usize,
    /// Derivative of it by the coordinates, then by the parameter.
    pub bound_slopes: Vec<R>,
}

impl<R: Real> SectionChart<R> {
    /// At a contact. Leaves out the state that the gap depends on most; no phase, since it does not come back.
    pub(crate) fn new(problem: &Problem, contact: usize, parameters: &[R], state: &[R]) -> Self {
        let equations = &problem.releases[contact];
        let [gap, _] = equations.gap_and_rate_slopes(state, parameters);
        let bound = (0..state.len())
            .filter(|&i| !equations.is_phase(i))
            .max_by(|&a, &b| {
                let (a, b) = (gap[a].abs(), gap[b].abs());
                // On a tie the first, as max_by would keep the last.
                a.partial_cmp(&b)
                    .filter(|order| order.is_ne())
                    .unwrap_or(core::cmp::Ordering::Greater)
            })
            .unwrap_or(0);
        Self::with_bound(problem, (contact, bound), parameters, state)
    }

    /// Leaves out a given state.
    pub(crate) fn with_bound(
        problem: &Problem,
        (contact, bound): (usize, usize),
        parameters: &[R],
        state: &[R],
    ) -> Self {
        let [gap, _] = problem.releases[contact].gap_and_rate_slopes(state, parameters);
        let free: Vec<usize> = (0..state.len()).filter(|&i| i != bound).collect();
        let bound_slopes = (free.iter().copied().chain([state.len()]))
            .map(|i| -gap[i] / gap[bound])
            .collect();
        Self {
            free,
            bound,
            bound_slopes,
        }
    }

    /// Weights of the columns (states, parameter) along a coordinate of the section, or along the parameter at fixed
    /// coordinates.
    pub(crate) fn weights(&self, along: usize) -> Vec<R> {
        let states = self.free.len() + 1;
        let mut weights = vec![R::ZERO; states + 1];
        weights[self.free.get(along).copied().unwrap_or(states)] = R::ONE;
        weights[self.bound] = self.bound_slopes[along];
        weights
    }
}

/// Sum of columns times weights, for the state after an impact.
pub(crate) fn combine<R: Real>(slopes: &[Slopes<R>], weights: &[R]) -> Vec<R> {
    (0..slopes.first().map_or(0, |slope| slope.state.len()))
        .map(|i| {
            (slopes.iter().zip(weights)).fold(R::ZERO, |sum, (slope, &weight)| {
                sum + slope.state[i] * weight
            })
        })
        .collect()
}

/// Roundoffs in the derivatives along one flight: some twenty steps of a few operations each.
const FLIGHT_ROUNDOFFS: f64 = 64.0;

/// The sequence from the first impact is followed once to see by how much its X misses zero, and once more.
const RESTARTS: usize = 3;

/// The exact normal form at a border.
pub(crate) fn exact<R: Real>(
    problem: &Problem,
    point: &Point<R>,
    chart: &SectionChart<R>,
) -> Result<Exact<R>, BorderError> {
    let Point {
        release,
        limits,
        sequence,
        end,
        ..
    } = point;
    let parameters = problem.parameters(point.value);
    let states = problem.states();
    let contact = release.contact;
    let amplitude = limits.amplitude(sequence, *end);
    let scale = amplitude.value * amplitude.value / release.jerk;
    let loops = &point.memory;
    let remembered = |sign: f64| -> Option<Vec<R>> {
        let added = loops.settled(&loops.by_rate, sign)?;
        Some(added.iter().map(|&x| x * R::splat(sign)).collect())
    };
    let by_memory = remembered(1.0).ok_or(BorderError::NotAlone {
        value: point.value.to_f64(),
    })?;
    let jump: Vec<R> = (release.jump.iter().zip(release.along(&by_memory)))
        .map(|(&jump, more)| jump + more)
        .collect();
    let offset_at_release = jump.clone();
    let jump = Problem::weights(&jump, false);
    let restitution = dot(&release.restitution_by, &by_memory);
    let by_rate = limits.x_slope(sequence, *end, &jump, restitution);
    let relative = 2.0 * amplitude.error / amplitude.value.to_f64().abs();
    let mut slope = by_rate.scaled(scale);
    slope.error += relative * slope.value.to_f64().abs();
    let shift = Problem::weights(&release.slope, true);
    let first = &sequence.impacts[0];
    let start = &first.state[..states];
    // One flight knows its derivatives to roundoff against the largest of them.
    let columns = &first.local.slopes;
    let largest = |i: usize, weights: &[R]| {
        (columns.iter().zip(weights))
            .map(|(column, &weight)| (column.state[i] * weight).abs().to_f64())
            .fold(0.0, f64::max)
    };
    // X misses zero at the border that was found, and the parameter is rounded: derivatives are those at that place.
    let place = point.value.abs().to_f64() * point.slope.value.abs().to_f64();
    let relative_error = R::ROUNDOFF + point.x.error.max(R::ROUNDOFF * place);
    let known = |value: R, size: f64| Estimate {
        value,
        error: FLIGHT_ROUNDOFFS * relative_error * size,
    };
    let flight = (0..states)
        .map(|i| {
            let size = largest(i, &vec![R::ONE; states]);
            (0..states)
                .map(|c| known(columns[c].state[i], size))
                .collect()
        })
        .collect();
    let along = |weights: &[R]| -> Vec<Estimate<R>> {
        (combine(columns, weights).into_iter().enumerate())
            .map(|(i, value)| known(value, largest(i, weights)))
            .collect()
    };
    let times_scale = |estimate: Estimate<R>| {
        let mut product = estimate.scaled(scale);
        product.error += relative * product.value.abs().to_f64();
        product
    };
    let exactly_known = |&value: &R| known(value, value.abs().to_f64());
    let offset = (offset_at_release.iter())
        .map(exactly_known)
        .map(times_scale)
        .collect();
    let by_upsilon = along(&jump).into_iter().map(times_scale).collect();
    let by_parameter = along(&shift);
    let memory = (problem.dimensions() > 0).then(|| {
        let rate = Problem::weights(&release.jump, false);
        let restitution = dot(&release.restitution_by, &loops.by_rate);
        let direct = limits.x_slope(sequence, *end, &rate, restitution).value * scale;
        let twice = remembered(-1.0).map(|added| direct + dot(&loops.covector, &added) * scale);
        let count = release.free.len();
        Memory {
            states: release.free.clone(),
            returns: (0..count).map(|i| loops.returns.row(i).to_vec()).collect(),
            by_upsilon: loops.by_rate.iter().map(|&x| x * scale).collect(),
            by_parameter: loops.settled(&loops.by_parameter, 1.0).unwrap_or_default(),
            covector: loops.covector.clone(),
            slope: direct,
            doubling_slope: twice.unwrap_or(R::splat(f64::NAN)),
            first_impact_by_upsilon: combine(columns, &rate).iter().map(|&x| x * scale).collect(),
            first_impact_by_memory: (release.directions.iter())
                .map(|direction| combine(columns, &Problem::weights(direction, false)))
                .collect(),
        }
    });
    // From the first impact on, again with unit columns: X as a function of the state there. That impact itself is not
    // in the new sequence, whose X is therefore measured one power of eta later. Rounding of the state leaves X there
    // somewhat off zero, which the sequence magnifies: the state that can be set most finely makes up for it.
    let mut start = start.to_vec();
    let settles = point.settles.saturating_sub(1);
    let along = chart.free.len();
    let mut covector = Vec::new();
    let mut covector_parameter = point.slope;
    for _ in 0..RESTARTS {
        let most = sequence.impacts.len() - 1;
        let onward = problem.variation(&parameters, (contact, &start), settles, most)?;
        let end = (*end - 1).min(onward.impacts.len() - 1);
        let by = |along: usize, by_parameter: bool| {
            let weights = chart.weights(along);
            let mut restitution = if by_parameter {
                point.held_restitution
            } else {
                R::ZERO
            };
            if release.restitution_by.iter().any(|x| *x != R::ZERO) {
                let places = (&problem.releases[contact], &*parameters, &*release.free);
                let landed = limits.accumulation_place(
                    &onward,
                    end,
                    places,
                    core::slice::from_ref(&weights),
                );
                for (&by, (_, slopes)) in release.restitution_by.iter().zip(&landed) {
                    restitution += by * slopes[0].value;
                }
            }
            limits
                .x_slope(&onward, end, &weights, restitution)
                .scaled(limits.constants.eta)
        };
        covector = (0..along).map(|i| by(i, false)).collect();
        covector_parameter = by(along, true);
        let x = limits.x(&onward, end).value * limits.constants.eta;
        let leverage = |i: usize| {
            let size = start[chart.free[i]].abs().to_f64().max(f64::MIN_POSITIVE);
            covector[i].value.abs().to_f64() / size
        };
        // Of equals the first.
        let more = |&a: &usize, &b: &usize| leverage(a).total_cmp(&leverage(b));
        let finest = (0..along).rev().max_by(more).unwrap_or(0);
        let correction = x / covector[finest].value;
        if !correction.is_finite() {
            break;
        }
        start[chart.free[finest]] -= correction;
    }
    Ok(Exact {
        slope,
        unfolding_rate: point.slope,
        amplitude,
        first_impact_by_upsilon: by_upsilon,
        first_impact_by_parameter: by_parameter,
        flight,
        offset,
        covector,
        covector_parameter,
        memory,
    })
}
