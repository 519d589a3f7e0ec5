//! Upsilon on one lap, by power series in the phase.
//!
//! On lap 0, u_1 = Phi(eta Q) with the Poincaré function Phi, and (M7) reads
//!
//! ```text
//! Upsilon = E q(s_1),   q(s) = (3/4) r s (1 - s) - (3 s - 1)^2 / 8,   E = lambda^-2 prod_{i >= 2} (h(u_i) / lambda)^2
//! ```
//!
//! In the phase t = (1 - Q / x_e) / (1 - eta), 0 <= t <= 1 on the lap, s_1^2 = t C(t), and C and E are analytic: Phi and
//! the product are, and the root s_1 is the only singularity at the graze t = 0. The nearest singularity is the image of
//! the pole of g one lap up, at -(1 - t(u_1 = 1/3)) / eta: between -15 for r -> 0 and -0.7 for r -> 1. That is outside
//! the lap by a factor that stays away from one for every r, so C and E are short polynomials, where the series of Phi
//! about u* would need of the order of 1 / (1 - r) terms. They are found by interpolation at Chebyshev points of
//! sequences in double-double, and cut where their coefficients have fallen below rounding error.

use super::argument::Argument;
use super::chebyshev::Grid;
use super::scales::{Mark, lift};
use super::sequence::Sequences;
use crate::numerics::{DoubleDouble, Real};

/// Samples per interpolant: the series fall by at least 4.5 a term, to 1e-34 in 52.
const SAMPLES: usize = 56;
/// What rounding leaves of the coefficients of the samples, relative to the largest.
const SAMPLED: f64 = 1e-31;
/// Below this restitution both zeros of q crowd the pole of g, within sqrt(r): 3 s - 1 needs its own digits.
const CROWDED_BELOW: f64 = 0.25;

/// Even and odd coefficients of two series in z = 1 - 2 t, interleaved for evaluation in z^2.
type Rows<R> = Vec<[R; 4]>;

/// The lap.
#[derive(Clone, Debug)]
pub(super) struct Lap<R> {
    /// E and C.
    series: Rows<R>,
    /// Their derivatives by z.
    slopes: Rows<R>,
    /// Their second derivatives by z.
    curvatures: Rows<R>,
    /// (s_1^2 - 1/9) / (t - t_pole), in both halves of its rows; empty for restitutions that do not need it.
    pole: Vec<[R; 2]>,
    /// The pole of g, u_1 = 1/3.
    pub mark: Mark<R>,
    three_quarters_r: R,
}

/// Upsilon / lambda^2n and what goes with it.
#[derive(Clone, Copy, Debug)]
pub(super) struct OnLap<T> {
    /// s_1.
    pub root: T,
    /// Upsilon / lambda^2n.
    pub value: T,
    /// Its derivative by the phase.
    pub slope: T,
}

fn rows<R: Real, const N: usize>(series: &[&[DoubleDouble]]) -> Vec<[R; N]> {
    let longest = series.iter().map(|s| s.len()).max().unwrap_or(0);
    (0..longest.div_ceil(2))
        .map(|row| {
            core::array::from_fn(|k| {
                let power = 2 * row + k % 2;
                let coefficient = series[k / 2].get(power).copied();
                R::from_double_double(coefficient.unwrap_or(DoubleDouble::ZERO))
            })
        })
        .collect()
}

fn derivative(series: &[DoubleDouble]) -> Vec<DoubleDouble> {
    series
        .iter()
        .enumerate()
        .skip(1)
        .map(|(power, &c)| c * DoubleDouble::from(power as f64))
        .collect()
}

/// E, C and (s_1^2 - 1/9) / (t - t_pole) at the Chebyshev points of the lap's phase, in increasing order of t.
/// The last only where it is needed.
fn samples(sequences: &Sequences, grid: &Grid, crowded: bool) -> [Vec<DoubleDouble>; 3] {
    let number = DoubleDouble::from;
    let (zero, one) = (DoubleDouble::ZERO, DoubleDouble::ONE);
    let c = &sequences.constants;
    let (graze, pole) = (sequences.at(zero), sequences.at_pole());
    // sigma = s_1^2 where the next lap begins, u_1 = g^-1(3/8).
    let begin = {
        let h = sequences.map.back_step(number(super::GRAZE)).h;
        let s = (one + number(2.0) * h) / number(3.0);
        s * s
    };
    let mut by_sigma: [Vec<DoubleDouble>; 3] = [const { Vec::new() }; 3];
    for sigma in grid.points(zero, begin) {
        let start = sequences.at(sigma);
        let from_graze = sequences.limits(start, graze);
        let from_pole = if crowded {
            sequences.limits(start, pole)
        } else {
            from_graze
        };
        // t = (eta x_e - eta Q) / scale, and u = (3/8)(1 - sigma).
        let scale = from_graze.reference * c.one_minus_eta / number(super::GRAZE);
        let weight = from_graze.product / c.lambda;
        by_sigma[0].push(weight * weight);
        by_sigma[1].push(scale / from_graze.quotient);
        by_sigma[2].push(scale / from_pole.quotient);
    }
    let fits = by_sigma.map(|values| grid.interpolate(zero, begin, &values));
    let square_over_phase = &fits[1];

    let mut samples: [Vec<DoubleDouble>; 3] = [const { Vec::new() }; 3];
    let mut sigma = begin;
    // The points run from t = 1 down: each solution of sigma = t C starts from the one before.
    for phase in grid.points(zero, one) {
        const NEWTON_STEPS: usize = 8;
        for _ in 0..NEWTON_STEPS {
            let (value, _, slope) = square_over_phase.pair(sigma, sigma);
            sigma -= (sigma - phase * value) / (one - phase * slope);
        }
        for (samples, fit) in samples.iter_mut().zip(&fits) {
            samples.push(fit.at(sigma));
        }
    }
    for samples in &mut samples {
        samples.reverse();
    }
    samples
}

impl<R: Real> Lap<R> {
    pub(super) fn new(sequences: &Sequences) -> Self {
        let (zero, one) = (DoubleDouble::ZERO, DoubleDouble::ONE);
        let c = &sequences.constants;
        let grid = Grid::new(SAMPLES);
        let crowded = c.restitution.to_f64() < CROWDED_BELOW;
        // z runs against t, and so does the interval of the fit.
        let fits =
            samples(sequences, &grid, crowded).map(|values| grid.interpolate(one, zero, &values));
        let cut = |tolerance: f64| {
            let tolerance = tolerance.max(SAMPLED);
            [0, 1, 2].map(|k: usize| fits[k].monomials(tolerance))
        };
        let series = cut(R::ROUNDOFF * 0.25);
        // Differentiation multiplies what was cut by the square of the degree.
        let slopes = cut(R::ROUNDOFF * 1e-3).map(|series| derivative(&series));
        let curvatures = cut(R::ROUNDOFF * 1e-6).map(|series| derivative(&derivative(&series)));
        let at_pole = sequences.limits(sequences.at_pole(), sequences.at(zero));
        let ratio = at_pole.own / at_pole.reference;
        let rounded = R::from_double_double(ratio);
        Self {
            series: rows(&[&series[0], &series[1]]),
            slopes: rows(&[&slopes[0], &slopes[1]]),
            curvatures: rows(&[&curvatures[0], &curvatures[1]]),
            pole: if crowded {
                rows(&[&series[2]])
            } else {
                Vec::new()
            },
            mark: Mark {
                before_begin: R::from_double_double((ratio - c.eta) / c.one_minus_eta),
                ratio: rounded,
                ratio_rest: R::from_double_double(ratio - rounded.to_double_double()),
            },
            three_quarters_r: R::from_double_double(c.restitution * DoubleDouble::from(0.75)),
        }
    }

    #[inline(always)]
    fn two_series<T: Argument<Real = R>>(rows: &[[R; 4]], z: T, z2: T) -> (T, T) {
        let mut sums = [T::splat(0.0); 4];
        for row in rows.iter().rev() {
            for (sum, &coefficient) in sums.iter_mut().zip(row) {
                *sum = sum.mul_add(z2, lift(coefficient));
            }
        }
        (sums[1].mul_add(z, sums[0]), sums[3].mul_add(z, sums[2]))
    }

    /// s_1, and 3 s_1 - 1 with digits of its own where they are needed.
    #[inline(always)]
    fn roots<T: Argument<Real = R>>(&self, phase: T, from_pole: T, z: T, z2: T, c: T) -> (T, T) {
        let s = (phase * c).sqrt();
        let three = T::splat(3.0);
        if self.pole.is_empty() {
            return (s, s.mul_add(three, T::splat(-1.0)));
        }
        let mut sums = [T::splat(0.0); 2];
        for row in self.pole.iter().rev() {
            for (sum, &coefficient) in sums.iter_mut().zip(row) {
                *sum = sum.mul_add(z2, lift(coefficient));
            }
        }
        let v = sums[1].mul_add(z, sums[0]);
        let twice_h = T::splat(9.0) * from_pole * v / s.mul_add(three, T::splat(1.0));
        (s, twice_h)
    }

    /// q(s_1).
    #[inline(always)]
    fn shape<T: Argument<Real = R>>(&self, s: T, twice_h: T) -> T {
        let one = T::splat(1.0);
        let graze = lift::<R, T>(self.three_quarters_r) * s * (one - s);
        graze - twice_h * twice_h * T::splat(0.125)
    }

    /// Upsilon / lambda^2n at a phase, given also its distance from the pole.
    #[inline(always)]
    pub(super) fn value<T: Argument<Real = R>>(&self, phase: T, from_pole: T) -> T {
        let z = T::splat(1.0) - (phase + phase);
        let z2 = z * z;
        let (e, c) = Self::two_series(&self.series, z, z2);
        let (s, twice_h) = self.roots(phase, from_pole, z, z2, c);
        e * self.shape(s, twice_h)
    }

    /// Value, derivative by the phase, and s_1. At the graze the derivative is infinite.
    #[inline(always)]
    pub(super) fn evaluate<T: Argument<Real = R>>(&self, phase: T, from_pole: T) -> OnLap<T> {
        let one = T::splat(1.0);
        let z = one - (phase + phase);
        let z2 = z * z;
        let (e, c) = Self::two_series(&self.series, z, z2);
        let (e_z, c_z) = Self::two_series(&self.slopes, z, z2);
        let (s, twice_h) = self.roots(phase, from_pole, z, z2, c);
        let shape = self.shape(s, twice_h);
        // d/dt = -2 d/dz.
        let square_slope = c - (phase + phase) * c_z;
        let root_slope = square_slope / (s + s);
        let shape_slope =
            lift::<R, T>(self.three_quarters_r) * (one - (s + s)) - T::splat(0.75) * twice_h;
        OnLap {
            root: s,
            value: e * shape,
            slope: e * shape_slope * root_slope - (e_z + e_z) * shape,
        }
    }

    /// Second derivative by the phase of Upsilon / lambda^2n: what Newton's method needs, not part of any result.
    pub(super) fn curvature(&self, phase: R, from_pole: R) -> R
    where
        R: Argument<Real = R>,
    {
        let number = R::splat;
        let z = R::ONE - (phase + phase);
        let z2 = z * z;
        let (e, c) = Self::two_series(&self.series, z, z2);
        let (e_z, c_z) = Self::two_series(&self.slopes, z, z2);
        let (e_zz, c_zz) = Self::two_series(&self.curvatures, z, z2);
        let (s, twice_h) = self.roots(phase, from_pole, z, z2, c);
        let (e_t, c_t) = (number(-2.0) * e_z, number(-2.0) * c_z);
        let (e_tt, c_tt) = (number(4.0) * e_zz, number(4.0) * c_zz);
        let square_t = c + phase * c_t;
        let square_tt = c_t + c_t + phase * c_tt;
        let s_t = square_t / (s + s);
        let s_tt = (square_tt * number(0.5) - s_t * s_t) / s;
        let shape_s = self.three_quarters_r * (R::ONE - (s + s)) - number(0.75) * twice_h;
        let shape_ss = -(self.three_quarters_r + self.three_quarters_r + number(2.25));
        e_tt * self.shape(s, twice_h)
            + number(2.0) * e_t * shape_s * s_t
            + e * (shape_ss * s_t * s_t + shape_s * s_tt)
    }

    /// Upsilon / lambda^2n at the graze, and the coefficient of the square root of the phase there.
    pub(super) fn at_graze(&self) -> (R, R)
    where
        R: Argument<Real = R>,
    {
        let (e, c) = Self::two_series(&self.series, R::ONE, R::ONE);
        let rising = self.three_quarters_r + R::splat(0.75);
        (e * R::splat(-0.125), e * rising * c.sqrt())
    }

    /// Distance of a phase from that of the pole.
    pub(super) fn distance_from_pole(&self, phase: R) -> R {
        (phase - R::ONE) + self.mark.before_begin
    }
}
