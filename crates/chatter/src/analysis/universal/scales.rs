//! Self-similarity: which lap an argument lies on, and where on that lap, to twice the working precision.
//!
//! Near a lap's end Upsilon is a square root of the distance to it, and for r near one a lap is a tiny fraction of x.
//! So 1 - x / (eta^n x_e) must keep its own digits: eta^-n / x_e is kept as an unevaluated sum of two numbers, and
//! multiplied with x exactly. Large n are written to base [`BASE`], so that the tables stay short however many laps there
//! are between the smallest and the largest double.

use super::argument::Argument;
use super::constants::Constants;
use crate::numerics::{DoubleDouble, Real, Scalar};

const BASE: usize = 64;
/// Up to this many laps need no second table: all doubles, for r up to 0.84.
const TOP: usize = 8192;
/// Below this 1 - eta, rounding errors of the logarithm of x may exceed half a lap.
const SHORT_LAP: f64 = 1e-11;
/// Logarithms of the largest and the smallest positive double.
const LN_LARGEST: f64 = 709.8;
const LN_SMALLEST: f64 = -744.5;

/// The powers that go with a digit of n.
#[derive(Clone, Debug)]
struct Digit<R, const N: usize> {
    /// eta^-n, in the top digit over x_e, and what rounding left of it.
    stretch: Box<[R; N]>,
    stretch_rest: Box<[R; N]>,
    /// lambda^2n.
    value: Box<[R; N]>,
    /// (lambda^2 / eta)^n, in the top digit over -(1 - eta) x_e.
    slope: Box<[R; N]>,
}

/// Maps x to its lap and phase.
#[derive(Clone, Debug)]
pub(super) struct Scales<R> {
    top: Digit<R, TOP>,
    /// The lap number of the first entry of `top`, over [`BASE`] to the number of low digits.
    first: R,
    /// The inverse of the laps that one step of the top digit takes.
    top_weight: R,
    laps_per_top: R,
    /// Lowest digit first.
    low: Vec<Digit<R, BASE>>,
    log2_lap_end: R,
    /// 1 / log2(1 / eta).
    laps_per_octave: R,
    /// Coefficients of the series of log2 in (m - 1) / (m + 1), as many as finding the lap needs.
    logarithm: Vec<R>,
    margin: R,
    /// The guess of the lap is never too small unless laps are as short as rounding errors.
    furthest_on: R,
    eta: R,
    one_minus_eta: R,
    laps_per_lap_end: R,
    value_step: R,
    slope_step: R,
}

/// An argument placed on its lap.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed<T> {
    /// n, with eta^(n + 1) x_e < x <= eta^n x_e.
    pub lap: T,
    /// (1 - x / (eta^n x_e)) / (1 - eta), from 0 at the lap's end to 1 where the next lap begins.
    pub phase: T,
    /// phase - phase of the mark given to [`Scales::place`], to the same relative accuracy; for |k| > 1, see there, of
    /// no use.
    pub from_mark: T,
    top: T,
    digits: T,
    back: T,
}

/// A point of the lap, to twice the working precision, from which distances are wanted too.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mark<R> {
    /// One less its phase.
    pub before_begin: R,
    /// x / (eta^n x_e) there.
    pub ratio: R,
    /// What rounding left of `ratio`.
    pub ratio_rest: R,
}

fn table<R: Real, const N: usize>(entry: impl Fn(usize) -> R) -> Box<[R; N]> {
    let entries: Box<[R]> = (0..N).map(entry).collect();
    match entries.try_into() {
        Ok(table) => table,
        Err(_) => unreachable!("a table of N entries has N entries"),
    }
}

/// exp(k ln_step + ln_factor), k = first … first + count - 1, then zeros: with few exponentials, without error that
/// grows along the table, and without under- or overflow on the way to an entry that is in range.
fn powers<const N: usize>(
    first: f64,
    count: usize,
    ln_step: DoubleDouble,
    ln_factor: DoubleDouble,
) -> Vec<DoubleDouble> {
    const LONGEST_BLOCK: f64 = 64.0;
    const LN_RANGE_OF_BLOCK: f64 = 30.0;
    let block = (LN_RANGE_OF_BLOCK / ln_step.abs().to_f64()).clamp(1.0, LONGEST_BLOCK) as usize;
    let at = |k: f64| ln_step * DoubleDouble::from(k);
    let within: Vec<_> = (0..block).map(|k| at(k as f64).exp()).collect();
    let mut powers: Vec<_> = (0..count.div_ceil(block))
        .flat_map(|index| {
            let start = (at(first + (index * block) as f64) + ln_factor).exp();
            within.iter().map(move |&power| start * power)
        })
        .take(count)
        .collect();
    powers.resize(N, DoubleDouble::ZERO);
    powers
}

fn digit<R: Real, const N: usize>(
    first: f64,
    count: usize,
    weight: f64,
    c: &Constants<DoubleDouble>,
    ln_stretch: DoubleDouble,
    ln_slope: DoubleDouble,
    sign: f64,
) -> Digit<R, N> {
    let weight = DoubleDouble::from(weight);
    let round = R::from_double_double;
    let stretch = powers::<N>(first, count, -(c.ln_eta * weight), ln_stretch);
    let ln_value = (c.ln_lambda + c.ln_lambda) * weight;
    let value = powers::<N>(first, count, ln_value, DoubleDouble::ZERO);
    let slope = powers::<N>(first, count, ln_value - c.ln_eta * weight, ln_slope);
    Digit {
        stretch: table(|k| round(stretch[k])),
        stretch_rest: table(|k| round(stretch[k] - round(stretch[k]).to_double_double())),
        value: table(|k| round(value[k])),
        slope: table(|k| round(slope[k] * DoubleDouble::from(sign))),
    }
}

impl<R: Real> Scales<R> {
    pub(super) fn new(c: &Constants<DoubleDouble>, lap_end: DoubleDouble) -> Self {
        let number = DoubleDouble::from;
        let ln_lap_end = lap_end.ln();
        let laps = |ln_x: f64| ((ln_x - ln_lap_end.to_f64()) / c.ln_eta.to_f64()).floor();
        let (first_lap, last_lap) = (laps(LN_LARGEST) - 2.0, laps(LN_SMALLEST) + 2.0);
        let mut weight = 1.0;
        let mut low = Vec::new();
        while (last_lap / weight).floor() - (first_lap / weight).floor() >= TOP as f64 {
            low.push(digit(
                0.0,
                BASE,
                weight,
                c,
                DoubleDouble::ZERO,
                DoubleDouble::ZERO,
                1.0,
            ));
            weight *= BASE as f64;
        }
        let first = (first_lap / weight).floor();
        let count = ((last_lap / weight).floor() - first) as usize + 1;
        let ln_slope = -(ln_lap_end + c.one_minus_eta.ln());
        let top = digit(first, count, weight, c, -ln_lap_end, ln_slope, -1.0);

        let ln_two = number(2.0).ln();
        let laps_per_octave = -(ln_two / c.ln_eta);
        // Half the laps from where `back` is -1 at least, x / (eta^n x_e) = 2 - eta, down to the lap's end: together with
        // half of itself, for the error of the logarithm, that stays short of it.
        let nearest = (DoubleDouble::ONE + c.one_minus_eta).ln();
        let margin = -0.5 * (nearest / c.ln_eta).to_f64();
        let allowed = margin / laps_per_octave.to_f64() / 2.0;
        // |m - 1| / (m + 1) is at most 3 - 2 sqrt(2).
        const LARGEST: f64 = 0.171_572_875_253_81;
        let mut logarithm = Vec::new();
        let mut odd = 1.0;
        let mut term = 2.0 * core::f64::consts::LOG2_E * LARGEST;
        const FULL: usize = 11;
        while (logarithm.is_empty() || term / odd > allowed) && logarithm.len() < FULL {
            logarithm.push(R::from_double_double(number(2.0) / (ln_two * number(odd))));
            odd += 2.0;
            term *= LARGEST * LARGEST;
        }
        let round = R::from_double_double;
        let lambda_squared = c.lambda * c.lambda;
        Self {
            top,
            first: R::splat(first),
            top_weight: R::splat(1.0 / weight),
            laps_per_top: R::splat(weight),
            low,
            log2_lap_end: round(ln_lap_end / ln_two),
            laps_per_octave: round(laps_per_octave),
            logarithm,
            margin: R::splat(margin),
            furthest_on: R::splat(if c.one_minus_eta.to_f64() > SHORT_LAP {
                0.0
            } else {
                f64::MAX
            }),
            eta: round(c.eta),
            one_minus_eta: round(c.one_minus_eta),
            laps_per_lap_end: round(DoubleDouble::ONE / c.one_minus_eta),
            value_step: round(DoubleDouble::ONE / lambda_squared - DoubleDouble::ONE),
            slope_step: round(c.eta / lambda_squared - DoubleDouble::ONE),
        }
    }

    /// Places a positive finite `x`.
    #[inline(always)]
    pub(super) fn place<T: Argument<Real = R>>(&self, x: T, mark: &Mark<R>) -> Placed<T> {
        let (exponent, mantissa) = x.split_binary();
        let one = T::splat(1.0);
        let z = (mantissa - one) / (mantissa + one);
        let z2 = z * z;
        let mut series = T::splat(0.0);
        for &coefficient in self.logarithm.iter().rev() {
            series = series.mul_add(z2, lift(coefficient));
        }
        let octaves = lift::<R, T>(self.log2_lap_end) - (exponent + series * z);
        // The margin covers the error, so that this is n or n + 1.
        let guess = octaves
            .mul_add(lift(self.laps_per_octave), lift(self.margin))
            .floor();

        let top = (guess * lift(self.top_weight)).floor();
        let digits = guess - top * lift(self.laps_per_top);
        let top = top - lift(self.first);
        let stretch = T::look_up(&self.top.stretch, top);
        let mut ratio = x * stretch;
        let mut rest = x.mul_add(stretch, -ratio) + x * T::look_up(&self.top.stretch_rest, top);
        self.for_low_digits(digits, |table, digit| {
            let stretch = T::look_up(&table.stretch, digit);
            let product = ratio * stretch;
            rest = ratio.mul_add(stretch, -product)
                + ratio.mul_add(T::look_up(&table.stretch_rest, digit), rest * stretch);
            ratio = product;
        });

        let raw = ((one - ratio) - rest) * lift(self.laps_per_lap_end);
        // On by k laps: exact for k = -1; other k happen only where 1 - eta is near rounding error, and then the
        // neglected k^3 (1 - eta)^2 is nothing.
        let back = raw.floor().min(lift(self.furthest_on));
        let half = (back + one) * T::splat(0.5);
        let phase = (raw - back) + back * lift(self.one_minus_eta) * (raw - half);
        let phase = phase.max(T::splat(0.0)).min(one);
        // Seen from the lap before (k = -1), the phase is 1 + eta times the raw one.
        let from_mark = T::select(
            back.less(T::splat(0.0)),
            lift::<R, T>(self.eta).mul_add(raw, lift(mark.before_begin)),
            ((lift::<R, T>(mark.ratio) - ratio) + (lift::<R, T>(mark.ratio_rest) - rest))
                * lift(self.laps_per_lap_end),
        );
        Placed {
            lap: guess + back,
            phase,
            from_mark,
            top,
            digits,
            back,
        }
    }

    #[inline(always)]
    fn for_low_digits<T: Argument<Real = R>>(
        &self,
        digits: T,
        mut visit: impl FnMut(&Digit<R, BASE>, T),
    ) {
        let mut left = digits;
        let base = BASE as f64;
        for table in &self.low {
            let carried = (left * T::splat(1.0 / base)).floor();
            visit(table, left - carried * T::splat(base));
            left = carried;
        }
    }

    /// lambda^2n.
    #[inline(always)]
    pub(super) fn value<T: Argument<Real = R>>(&self, placed: &Placed<T>) -> T {
        let mut product = T::look_up(&self.top.value, placed.top);
        self.for_low_digits(placed.digits, |table, digit| {
            product *= T::look_up(&table.value, digit);
        });
        product * (T::splat(1.0) - placed.back * lift(self.value_step))
    }

    /// -(lambda^2 / eta)^n / ((1 - eta) x_e): the derivative by the phase times this is the derivative by x.
    #[inline(always)]
    pub(super) fn slope<T: Argument<Real = R>>(&self, placed: &Placed<T>) -> T {
        let mut product = T::look_up(&self.top.slope, placed.top);
        self.for_low_digits(placed.digits, |table, digit| {
            product *= T::look_up(&table.slope, digit);
        });
        product * (T::splat(1.0) - placed.back * lift(self.slope_step))
    }
}

/// A constant in every lane.
#[inline(always)]
pub(super) fn lift<R: Real, T: Scalar>(value: R) -> T {
    T::from_double_double(value.to_double_double())
}
