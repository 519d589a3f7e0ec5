//! The largest Lyapunov exponent of an orbit.

use super::aperiodic::grows;
use crate::analysis::map::{CoordinateKind, Map, Origin, Passage, Phase};

/// Distance of the second orbit, in [`units`], relative to the point with its time, whose rounding makes as much of an error: a
/// million times rounding error, and small against the windows of stability and the distance to the next graze, over which the
/// map is far from linear.
const DISPLACEMENT: f64 = 1e-10;

/// Two orbits that are this close, relative to the point, differ by rounding errors alone: they have become one, and the
/// exponent is minus infinity. So it is where orbits come to rest on the way, by complete chatter, and forget how.
const ONE_ORBIT: f64 = 8.0 * f64::EPSILON;

/// This part of the steps, at the beginning, only turns the displacement into the direction that grows most.
const TURNING: f64 = 0.1;

/// Logarithms of growth, step by step.
#[derive(Clone, Debug, Default)]
pub(in crate::analysis::diagram) struct Growth(Vec<f64>);

impl Growth {
    fn counted(&self) -> &[f64] {
        let turning = (self.0.len() as f64 * TURNING) as usize;
        &self.0[turning..]
    }

    /// The exponent, of an orbit that repeats after so many samples over whole periods: what a part of one grows by is no mean.
    pub(in crate::analysis::diagram) fn mean(&self, period: Option<usize>) -> f64 {
        let counted = self.counted();
        let left_over = match period {
            Some(period) if period <= counted.len() => counted.len() % period,
            _ => 0,
        };
        let counted = &counted[left_over..];
        counted.iter().sum::<f64>() / counted.len() as f64
    }

    /// Whether it is positive beyond chance.
    pub(in crate::analysis::diagram) fn is_chaotic(&self) -> bool {
        grows(self.counted())
    }
}

/// Units in which displacements of coordinates of these kinds and sizes can be compared, whatever the model's are. What is always
/// zero may vary as much as anything else.
pub(in crate::analysis::diagram) fn units(kinds: &[CoordinateKind], sizes: &[f64]) -> Vec<f64> {
    let unit = |(kind, &size): (&CoordinateKind, &f64)| match *kind {
        CoordinateKind::Phase { period } => period,
        CoordinateKind::Plain | CoordinateKind::Idle { .. } => size,
    };
    let mut units: Vec<f64> = kinds.iter().zip(sizes).map(unit).collect();
    let is_unit = |unit: &f64| *unit > 0.0 && unit.is_finite();
    let largest = units.iter().copied().filter(is_unit).fold(0.0, f64::max);
    let instead = if largest > 0.0 { largest } else { 1.0 };
    for unit in &mut units {
        if !is_unit(unit) {
            *unit = instead;
        }
    }
    units
}

/// A displacement that a map's Jacobian carries along.
#[derive(Clone, Debug)]
pub(in crate::analysis::diagram) struct Tangent {
    direction: Vec<f64>,
    growth: Growth,
    /// Of the present step, if a sample has several returns.
    pending: f64,
}

impl Tangent {
    pub(in crate::analysis::diagram) fn new(dimension: usize) -> Self {
        Self {
            direction: even(&(0..dimension).collect::<Vec<_>>(), dimension),
            growth: Growth::default(),
            pending: 0.0,
        }
    }

    /// Takes the displacement over the map's next step from `point`. Says whether the map knows its Jacobian there.
    pub(in crate::analysis::diagram) fn step(
        &mut self,
        map: &dyn Map,
        parameters: &[f64],
        point: &[f64],
    ) -> bool {
        let Some(jacobian) = map.jacobian(parameters, point) else {
            return false;
        };
        let n = self.direction.len();
        let image: Vec<f64> = (0..n)
            .map(|i| {
                let row = &jacobian[i * n..(i + 1) * n];
                row.iter().zip(&self.direction).map(|(a, b)| a * b).sum()
            })
            .collect();
        self.pending += turn(&mut self.direction, &image);
        true
    }

    /// A sample is complete.
    pub(in crate::analysis::diagram) fn sampled(&mut self) {
        self.growth.0.push(self.pending);
        self.pending = 0.0;
    }

    pub(in crate::analysis::diagram) fn growth(&self) -> &Growth {
        &self.growth
    }
}

/// The samples of an orbit as points, for a second orbit to be compared with.
#[derive(Clone, Debug, Default)]
pub(in crate::analysis::diagram) struct Trail {
    points: Vec<f64>,
    phases: Vec<Phase>,
    dimension: usize,
    /// Whether the orbit has a derivative no longer.
    is_ambiguous: bool,
}

impl Trail {
    pub(in crate::analysis::diagram) fn push(&mut self, point: &[f64], passage: &Passage) {
        self.dimension = point.len();
        self.points.extend_from_slice(point);
        self.phases.push(passage.phase);
        self.is_ambiguous |= passage.ambiguities > 0;
    }

    pub(in crate::analysis::diagram) fn clear(&mut self) {
        *self = Self::default();
    }

    fn point(&self, index: usize) -> &[f64] {
        &self.points[index * self.dimension..(index + 1) * self.dimension]
    }
}

/// A second orbit that is brought near the first again after each sample.
#[derive(Clone, Debug)]
pub(in crate::analysis::diagram) struct Companion {
    /// The coordinates in which it differs.
    directions: Vec<usize>,
    direction: Vec<f64>,
    units: Vec<f64>,
    /// Sample of the first orbit beside which the second one started.
    from: usize,
    size: f64,
    growth: Growth,
}

impl Companion {
    pub(in crate::analysis::diagram) fn new(directions: Vec<usize>, units: Vec<f64>) -> Self {
        Self {
            direction: even(&directions, units.len()),
            directions,
            units,
            from: 0,
            size: 0.0,
            growth: Growth::default(),
        }
    }

    /// Where the second orbit starts next; none if the first one has no further sample, or orbits beside it leave it at once.
    pub(in crate::analysis::diagram) fn origin(&mut self, trail: &Trail) -> Option<Origin> {
        if trail.is_ambiguous || self.from + 1 >= trail.phases.len() {
            return None;
        }
        let point = trail.point(self.from);
        let length = self.length(point);
        let size = if length > 0.0 {
            DISPLACEMENT * length
        } else {
            DISPLACEMENT
        };
        // The sign is kept where the other side was not admissible.
        self.size = size.copysign(self.size);
        let displaced = point.iter().zip(&self.direction).zip(&self.units);
        Some(Origin::Beside {
            point: displaced
                .map(|((x, d), unit)| x + self.size * d * unit)
                .collect(),
            phase: trail.phases[self.from],
        })
    }

    fn length(&self, point: &[f64]) -> f64 {
        let of_units = point.iter().zip(&self.units).map(|(x, unit)| x / unit);
        norm(&of_units.collect::<Vec<f64>>())
    }

    /// The second orbit has come to a sample.
    pub(in crate::analysis::diagram) fn arrive(&mut self, trail: &Trail, point: &[f64]) {
        self.from += 1;
        let reached = trail.point(self.from);
        let mut distance = vec![0.0; point.len()];
        for &k in &self.directions {
            distance[k] = (point[k] - reached[k]) / self.units[k];
        }
        let growth = if norm(&distance) <= ONE_ORBIT * self.length(reached) {
            f64::NEG_INFINITY
        } else {
            let image: Vec<f64> = distance.iter().map(|d| d / self.size).collect();
            turn(&mut self.direction, &image)
        };
        self.growth.0.push(growth);
    }

    /// The second orbit cannot start, or has no next point: tries the other side, once.
    pub(in crate::analysis::diagram) fn other_side(&mut self) -> bool {
        let first_try = self.size > 0.0;
        self.size = -1.0;
        first_try
    }

    pub(in crate::analysis::diagram) fn growth(&self) -> &Growth {
        &self.growth
    }
}

/// Makes `image` the direction; the logarithm of its length. A direction that vanishes is kept as it was.
fn turn(direction: &mut [f64], image: &[f64]) -> f64 {
    let length = norm(image);
    if length > 0.0 && length.is_finite() {
        for (d, x) in direction.iter_mut().zip(image) {
            *d = x / length;
        }
    }
    libm::log(length)
}

fn norm(vector: &[f64]) -> f64 {
    vector.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn even(directions: &[usize], dimension: usize) -> Vec<f64> {
    let mut direction = vec![0.0; dimension];
    for &k in directions {
        direction[k] = 1.0 / (directions.len() as f64).sqrt();
    }
    direction
}
