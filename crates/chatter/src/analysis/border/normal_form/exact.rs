//! Exact coefficients of the one-dimensional return map near a border orbit, (M5).

use super::super::coordinate::root::Point;
use super::super::error::{BorderError, Lack};
use super::super::problem::Here;
use crate::numerics::{Estimate, Real, dot, moved, unit, with_rounding};
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

/// The states that parametrise the contact surface h = 0 at a point: all but the one that the gap depends on most.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SectionChart<R> {
    /// Indices of the coordinates.
    pub free: Vec<usize>,
    /// Index of the state that follows.
    pub bound: usize,
    /// How states and parameter move with each coordinate, and last with the parameter at fixed coordinates.
    pub weights: Vec<Vec<R>>,
}

impl<R: Real> SectionChart<R> {
    pub(crate) fn new(here: &Here<'_, R>, contact: usize, state: &[R]) -> Self {
        let states = state.len();
        let gap = here.functions(contact, 0..1, state).jacobian;
        // No phase, since it does not come back, nor the parameter.
        let mut movable = gap.clone();
        let fixed = (0..=states).filter(|&i| i == states || here.closure.is_phase(i));
        fixed.for_each(|i| movable[(0, i)] = R::ZERO);
        let mut free = movable.free_columns();
        let bound = (0..states).find(|i| !free.contains(i)).unwrap_or(0);
        let along = |&i: &usize| {
            let mut along = unit(states + 1, i);
            along[bound] = -gap[(0, i)] / gap[(0, bound)];
            along
        };
        let weights = free.iter().map(along).collect();
        free.pop();
        Self {
            free,
            bound,
            weights,
        }
    }
}

impl<R: Real> Point<'_, R> {
    /// At the first impact.
    pub(crate) fn chart(&self) -> SectionChart<R> {
        let states = self.here.problem.states();
        let first = &self.sequence.impacts[0].state[..states];
        SectionChart::new(&self.here, self.release.contact, first)
    }
}

/// Roundoffs in the derivatives along one flight: some twenty steps of a few operations each.
const FLIGHT_ROUNDOFFS: f64 = 64.0;

/// The sequence from the first impact is followed once to see by how much its X misses zero, and once more.
const RESTARTS: usize = 3;

/// The exact normal form at a border.
pub(crate) fn exact<R: Real>(
    point: &Point<'_, R>,
    chart: &SectionChart<R>,
) -> Result<Exact<R>, BorderError> {
    let Point {
        here,
        release,
        limits,
        sequence,
        ..
    } = point;
    let states = here.problem.states();
    let contact = release.contact;
    let amplitude = limits.amplitude(sequence);
    let square_by_jerk = amplitude.times(amplitude.scaled(R::ONE / release.jerk));
    let scale = square_by_jerk.value;
    let loops = &point.memory;
    let by_rate = Estimate::values(&loops.by_rate);
    let remembered = |sign: f64| -> Option<Vec<R>> {
        let added = loops.settled(&by_rate, sign)?;
        Some(added.iter().map(|&x| x * R::splat(sign)).collect())
    };
    let by_memory = remembered(1.0).ok_or_else(|| here.lacks(Lack::Alone))?;
    let x_by_rate = |weights: &[R]| limits.x_along(sequence, release, weights, R::ZERO);
    let offset = moved(&release.jump, &release.along(&by_memory), R::ONE);
    let local = &sequence.impacts[0].local;
    // One flight knows its derivatives to roundoff against the largest of them. X misses zero at the border that was found, and the
    // parameter is rounded: derivatives are those at that place.
    let place = here.value.abs().to_f64() * point.slope.value.abs().to_f64();
    let missed = point.x.error.max(point.x.value.abs().to_f64());
    let relative_error = R::ROUNDOFF + missed.max(R::ROUNDOFF * place);
    let known = |value: R, size: f64| Estimate {
        value,
        error: FLIGHT_ROUNDOFFS * relative_error * size,
    };
    let largest = |slopes: &[R], weights: &[R]| {
        let parts = slopes.iter().zip(weights);
        parts.fold(0.0_f64, |most, (&slope, &weight)| {
            most.max((slope * weight).abs().to_f64())
        })
    };
    let along = |weights: &[R]| -> Vec<Estimate<R>> {
        (local.along(weights).into_iter().enumerate())
            .map(|(i, value)| known(value, largest(local.state_slopes(i), weights)))
            .collect()
    };
    let flight = (0..states)
        .map(|i| {
            let row = &local.state_slopes(i)[..states];
            let size = largest(row, &vec![R::ONE; states]);
            row.iter().map(|&slope| known(slope, size)).collect()
        })
        .collect();
    // What is remembered is known no better than its limits are.
    let errors = loops.by_rate.iter().map(|by| R::splat(by.error));
    let errors: Vec<R> = errors.collect();
    let unsure = release.along(&errors);
    let less_sure = |mut estimate: Estimate<R>, by: R| {
        estimate.error += by.abs().to_f64();
        estimate.times(square_by_jerk)
    };
    let first_impact_by_upsilon = (along(&offset).into_iter().zip(local.along(&unsure)))
        .map(|(estimate, by)| less_sure(estimate, by))
        .collect();
    let memory = (here.problem.dimensions() > 0).then(|| {
        let direct = x_by_rate(&release.jump).value * scale;
        let twice = remembered(-1.0).map(|added| direct + dot(&loops.covector, &added) * scale);
        let scaled = |values: &[R]| values.iter().map(|&x| x * scale).collect();
        let count = release.free.len();
        let row = |i: usize| loops.returns.iter().map(|back| back[i]).collect();
        Memory {
            states: release.free.clone(),
            returns: (0..count).map(row).collect(),
            by_upsilon: scaled(&by_rate),
            by_parameter: loops.settled(&loops.by_parameter, 1.0).unwrap_or_default(),
            covector: loops.covector.clone(),
            slope: direct,
            doubling_slope: twice.unwrap_or(R::splat(f64::NAN)),
            first_impact_by_upsilon: scaled(&local.along(&release.jump)),
            first_impact_by_memory: (release.directions.iter())
                .map(|direction| local.along(direction))
                .collect(),
        }
    });
    // From the first impact on, again with unit columns: X as a function of the state there. That impact itself is not
    // in the new sequence, whose X is therefore measured one power of eta later. Rounding of the state leaves X there
    // somewhat off zero, which the sequence magnifies: the state that can be set most finely makes up for it.
    let mut start = sequence.impacts[0].state[..states].to_vec();
    let settles = point.settles.saturating_sub(1);
    let coordinates = chart.free.len();
    let (mut covector, mut covector_parameter) = (Vec::new(), point.slope);
    for _ in 0..RESTARTS {
        let most = sequence.impacts.len() - 1;
        let mut onward = here.variation((contact, &start), settles, most)?;
        onward.impacts.truncate(most);
        let by = |along: usize, held_restitution: R| {
            let weights = &chart.weights[along];
            let slope = limits.x_along(&onward, release, weights, held_restitution);
            slope.scaled(limits.constants.eta)
        };
        covector = (0..coordinates).map(|i| by(i, R::ZERO)).collect();
        covector_parameter = by(coordinates, point.held_restitution);
        let x = limits.x(&onward).value * limits.constants.eta;
        let leverage = |i: usize| {
            let size = start[chart.free[i]].abs().to_f64().max(f64::MIN_POSITIVE);
            covector[i].value.abs().to_f64() / size
        };
        // Of equals the first.
        let more = |&a: &usize, &b: &usize| leverage(a).total_cmp(&leverage(b));
        let finest = (0..coordinates).rev().max_by(more).unwrap_or(0);
        let correction = x / covector[finest].value;
        if !correction.is_finite() {
            break;
        }
        start[chart.free[finest]] -= correction;
    }
    Ok(Exact {
        slope: less_sure(x_by_rate(&offset), dot(&loops.covector, &errors)),
        unfolding_rate: point.slope,
        amplitude,
        first_impact_by_upsilon,
        first_impact_by_parameter: along(&release.slope),
        flight,
        offset: (offset[..states].iter().zip(&unsure))
            .map(|(&value, &by)| less_sure(known(value, value.abs().to_f64()), by))
            .collect(),
        covector,
        covector_parameter,
        memory,
    })
}
