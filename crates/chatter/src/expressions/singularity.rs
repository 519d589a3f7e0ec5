//! Where functions stop being analytic: zeros of denominators, of radicands, of arguments of logarithms.
//!
//! A Taylor series converges as far as the nearest singular point of its function in the complex plane, and its terms show
//! that point only by as much as it matters here: the corner of sqrt(x^2) shows in none of them. What always shows is the
//! zero of the argument. A step therefore keeps away from the zeros s_i of every such argument a(s): by Rouche's theorem
//! there is none within s where
//!
//! ```text
//! sum_{k >= 1} |a_k| s^k < |a_0|
//! ```
//!
//! and where that says too little, the power sums of the inverse zeros, sum_i s_i^-k, which are the coefficients of
//! -a'/a, grow like the nearest one's.

use super::graph::{Expr, Function};
use super::machine::Compiled;
use super::series::Expansion;
use super::tape::{Op, Operand, Tape};
use crate::numerics::polynomial::sizes;
use crate::numerics::{Mask, Real, Scalar};
use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};

/// What has no value, or a corner, where its argument vanishes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Singularity {
    /// A denominator.
    Division,
    /// The argument of a square root.
    SquareRoot,
    /// The base of a power with an exponent that is no integer.
    Power,
    /// The argument of a logarithm.
    Logarithm,
    /// The distance of the argument of an inverse sine or cosine from 1 and -1.
    InverseSine,
    /// The cosine of the argument of a tangent.
    Tangent,
}

impl Singularity {
    /// What happens there to an expression, which may be unknown (empty), as the rest of a sentence that begins with the time.
    pub fn sentence(self, expression: &str) -> String {
        let what = match self {
            Self::Division => "a denominator",
            Self::SquareRoot => "the argument of a square root",
            Self::Power => "the base of a power",
            Self::Logarithm => "the argument of a logarithm",
            Self::InverseSine => "the argument of asin or acos",
            Self::Tangent => "the argument of tan",
        };
        let happens = match self {
            Self::Division | Self::Logarithm => {
                "reaches zero: the equations have no finite value there"
            }
            Self::SquareRoot => {
                "reaches zero, where the root is not smooth: the equations cannot be followed past it"
            }
            Self::Power => {
                "reaches zero, where the power is not smooth: the equations cannot be followed past it"
            }
            Self::InverseSine => {
                "reaches 1 or -1, where they are not smooth: the equations cannot be followed past it"
            }
            Self::Tangent => "reaches a pole: the equations have no finite value there",
        };
        let named = match self {
            _ if expression.is_empty() => String::new(),
            // What reaches zero is not the argument itself.
            Self::InverseSine | Self::Tangent => format!(" ({expression} = 0)"),
            _ => format!(" ({expression})"),
        };
        format!("{what}{named} {happens}")
    }
}

/// A series that must not vanish along a step, and why.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Singular {
    pub slot: usize,
    pub kind: Singularity,
    /// The constant that the exponent of a power is: whole and above zero, it is smooth everywhere.
    pub exponent: Option<usize>,
    /// The expression that it is the series of, where it is that of a whole one.
    pub expr: Option<Expr>,
}

/// A step goes this part of the way to the nearest zero: what lies beyond the last term is then at most as large as it.
const SHARE: f64 = 0.5;

/// Where an argument changes by less than this part, its zero is so far that rounding cannot matter: a step towards a
/// singular point that shows in the terms goes a fifth of the way or more.
const FAR: f64 = 1.0 / 8.0;

/// An argument is told from zero if it exceeds so many times the bound of its rounding error. A step halves it at most,
/// so that none goes from one side of zero to the other.
const CLEAR: f64 = 8.0;

/// Below this products of numbers lose digits, and an argument counts as zero.
const NOTHING: f64 = 1e-290;

impl Tape {
    /// Adds what its operations need to be different from zero; what is there already says better why.
    pub(super) fn find_singular(&mut self, exprs: &FxHashMap<usize, Expr>) {
        let producers = self.producers();
        let named = core::mem::take(&mut self.singular);
        let from_ops = self.ops.iter().filter_map(|op| match *op {
            Op::Divide { denominator, .. } => Some((denominator, Singularity::Division, None)),
            Op::SquareRoot { radicand, .. } => Some((radicand, Singularity::SquareRoot, None)),
            Op::Power { base, exponent, .. } => Some((base, Singularity::Power, Some(exponent))),
            _ => None,
        });
        // Roots first: a denominator that is a root vanishes where its radicand does.
        let (divisions, others): (Vec<_>, Vec<_>) =
            from_ops.partition(|&(_, kind, _)| kind == Singularity::Division);
        let named: Vec<_> = (named.iter())
            .map(|singular| (singular.slot, singular.kind, None))
            .collect();
        let mut slots = Vec::new();
        for (slot, kind, exponent) in named.into_iter().chain(others).chain(divisions) {
            slots.clear();
            self.zeros_of(slot, &producers, &mut slots);
            for &slot in &slots {
                let known = (self.singular.iter()).any(|known| {
                    known.slot == slot && known.exponent.is_none_or(|e| exponent == Some(e))
                });
                if !known {
                    self.singular.push(Singular {
                        slot,
                        kind,
                        exponent,
                        expr: exprs.get(&slot).copied(),
                    });
                }
            }
        }
    }
}

/// What may be left out where the base of a root vanishes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Negligible {
    /// What is zero there. What is infinite stays so.
    Zero,
    /// What has a finite integral from there on, as the derivative of a root has.
    Integrable,
}

impl Tape {
    /// This tape where the roots and powers of one of its singular points are nothing, and so is what is divided by them: what is
    /// left where the point's series vanishes. None if something there is not negligible.
    pub(crate) fn without_roots<R: Real>(
        &self,
        which: usize,
        constants: &[R],
        negligible: Negligible,
    ) -> Option<Self> {
        let slot = self.singular.get(which)?.slot;
        let producers = self.producers();
        let vanishes = |of: usize| {
            let mut zeros = Vec::new();
            self.zeros_of(of, &producers, &mut zeros);
            zeros.contains(&slot)
        };
        let degree = |of: usize| self.degree(of, &producers, constants, (slot, &[]));
        let is_negligible = |degree: f64, least: f64| match negligible {
            Negligible::Zero => Some(degree >= least),
            Negligible::Integrable => (degree > -1.0).then_some(true),
        };
        let mut tape = self.clone();
        let mut roots = 0;
        for op in &mut tape.ops {
            let out = match *op {
                Op::SquareRoot { out, radicand, .. } if vanishes(radicand) => out,
                Op::Power { out, base, .. } if vanishes(base) => {
                    if !is_negligible(degree(out), f64::MIN_POSITIVE)? {
                        continue;
                    }
                    out
                }
                Op::Divide {
                    out, denominator, ..
                } if vanishes(denominator) => {
                    if !is_negligible(degree(out), 0.0)? {
                        continue;
                    }
                    out
                }
                _ => continue,
            };
            roots += 1;
            *op = Op::Linear {
                out,
                offset: None,
                first: 0,
                end: 0,
            };
        }
        tape.singular.retain(|singular| singular.slot != slot);
        tape.swings.retain(|swing| !vanishes(swing.slot()));
        tape.compiled = Compiled::default();
        (roots > 0).then_some(tape)
    }

    /// Whether a root or a power is taken of a series, or it is divided by.
    pub(crate) fn takes_root_of(&self, of: Operand) -> bool {
        matches!(of, Operand::Series(slot) if self.singular.iter().any(|s| s.slot == slot))
    }

    /// Whether the field changes by no more than a multiple of what the state does where a series vanishes, as a power of it above one
    /// does and a root of it does not, but for that of a sum of squares.
    pub(crate) fn has_slope_at<R: Real>(&self, vanishing: usize, constants: &[R]) -> bool {
        let producers = self.producers();
        let squared = self.squared_in(vanishing, &producers, constants);
        let least_smooth = if squared.is_empty() { 1.0 } else { OF_SQUARED };
        let degree = |of: usize| self.degree(of, &producers, constants, (vanishing, &squared));
        // The least power of it, other than whole ones, that each series holds.
        let mut least = vec![f64::INFINITY; self.slots];
        // What is multiplied by nothing, as flow through a closed valve is, is none.
        let counts = |coefficient: usize| constants[coefficient] != R::ZERO;
        let of_terms = |least: &[f64], first: usize, end: usize| {
            (self.terms[first..end].iter())
                .filter(|&&(coefficient, _)| counts(coefficient))
                .fold(f64::INFINITY, |found, &(_, of)| found.min(least[of]))
        };
        let mut of_field = f64::INFINITY;
        for op in &self.ops {
            let found = match *op {
                Op::Rate { first, end, .. } => {
                    of_field = of_field.min(of_terms(&least, first, end));
                    continue;
                }
                Op::Linear { first, end, .. } => of_terms(&least, first, end),
                Op::Multiply { left, right, .. } => {
                    (least[left] + degree(right)).min(least[right] + degree(left))
                }
                Op::Square { base, .. } => least[base] + degree(base),
                Op::SquareRoot {
                    out,
                    radicand: base,
                    ..
                }
                | Op::Power { out, base, .. } => match degree(base) > 0.0 {
                    true => degree(out),
                    false => least[base],
                },
                Op::Divide {
                    out,
                    numerator,
                    denominator,
                    ..
                } => {
                    let above = match numerator {
                        Operand::Series(numerator) => least[numerator],
                        Operand::Constant(_) => f64::INFINITY,
                    };
                    match degree(denominator) > 0.0 {
                        true => degree(out),
                        false => above.min(least[denominator]),
                    }
                }
                Op::Slope { of, .. } => least[of],
                Op::SineCosine { argument, .. } => least[argument],
                Op::Integral {
                    argument, weight, ..
                } => match degree(weight) {
                    0.0 => least[argument],
                    power => least[argument].min(power + 1.0),
                },
            };
            for out in op.writes().filter(|&out| out != vanishing) {
                least[out] = found;
            }
        }
        (self.field.iter()).fold(of_field, |found, &(_, rate)| match rate {
            Operand::Series(of) => found.min(least[of]),
            Operand::Constant(_) => found,
        }) >= least_smooth
    }

    /// What the squares are of that a series is the sum of; none if it is the sum of anything else.
    fn squared_in<R: Real>(
        &self,
        slot: usize,
        producers: &[Option<Op>],
        constants: &[R],
    ) -> Vec<usize> {
        let Some(Op::Linear {
            offset: None,
            first,
            end,
            ..
        }) = producers[slot]
        else {
            return Vec::new();
        };
        let base = |&(coefficient, of): &(usize, usize)| match producers[of] {
            Some(Op::Square { base, .. }) if constants[coefficient] > R::ZERO => Some(base),
            _ => None,
        };
        let bases: Option<Vec<usize>> = self.terms[first..end].iter().map(base).collect();
        bases.unwrap_or_default()
    }
}

/// What a sum of squares vanishes with does so as its root.
const OF_SQUARED: f64 = 0.5;

impl Tape {
    /// The operation that computes each series, if one does.
    fn producers(&self) -> Vec<Option<Op>> {
        let mut producers = vec![None; self.slots];
        for op in &self.ops {
            for out in op.writes() {
                producers[out] = Some(op.clone());
            }
        }
        producers
    }

    /// The series whose zeros are those of a series.
    fn zeros_of(&self, slot: usize, producers: &[Option<Op>], into: &mut Vec<usize>) {
        match producers[slot] {
            Some(Op::Square { base, .. } | Op::Power { base, .. }) => {
                self.zeros_of(base, producers, into);
            }
            Some(Op::SquareRoot { radicand, .. }) => self.zeros_of(radicand, producers, into),
            Some(Op::Multiply { left, right, .. }) => {
                self.zeros_of(left, producers, into);
                self.zeros_of(right, producers, into);
            }
            Some(Op::Divide { numerator, .. }) => {
                if let Operand::Series(numerator) = numerator {
                    self.zeros_of(numerator, producers, into);
                }
            }
            // A multiple of something that is not smooth where it vanishes, under another root.
            Some(Op::Linear {
                offset: None,
                first,
                end,
                ..
            }) if end - first == 1 && is_root(producers[self.terms[first].1].as_ref()) => {
                self.zeros_of(self.terms[first].1, producers, into);
            }
            Some(Op::Integral {
                function: Function::Exp | Function::Cosh,
                ..
            }) => {}
            _ => into.push(slot),
        }
    }

    /// The power of a series of which another is at most a multiple where that vanishes, as far as it is made of products, quotients and
    /// powers of it and of what it is the sum of squares of; 0 where it does not vanish with it.
    fn degree<R: Real>(
        &self,
        of: usize,
        producers: &[Option<Op>],
        constants: &[R],
        (vanishing, squared): (usize, &[usize]),
    ) -> f64 {
        let degree = |slot: usize| self.degree(slot, producers, constants, (vanishing, squared));
        match producers[of] {
            _ if of == vanishing => 1.0,
            _ if squared.contains(&of) => OF_SQUARED,
            Some(Op::Square { base, .. }) => 2.0 * degree(base),
            Some(Op::SquareRoot { radicand, .. }) => 0.5 * degree(radicand),
            Some(Op::Power { base, exponent, .. }) => constants[exponent].to_f64() * degree(base),
            Some(Op::Multiply { left, right, .. }) => degree(left) + degree(right),
            Some(Op::Divide {
                numerator,
                denominator,
                ..
            }) => match numerator {
                Operand::Series(numerator) => degree(numerator) - degree(denominator),
                Operand::Constant(_) => -degree(denominator),
            },
            Some(Op::Linear {
                offset: None,
                first,
                end,
                ..
            }) if end - first == 1 => degree(self.terms[first].1),
            _ => 0.0,
        }
    }
}

/// Whether a series is that of a root or a power.
fn is_root(producer: Option<&Op>) -> bool {
    matches!(producer, Some(Op::SquareRoot { .. } | Op::Power { .. }))
}

impl<R: Real> Expansion<R> {
    /// The tape without the roots of one thing that is not positive in the latest run; none if there is no such.
    pub(crate) fn past_a_root(&self, tape: &Tape, constants: &[R]) -> Option<Tape> {
        (tape.singular.iter().enumerate())
            .filter(|(_, singular)| self.get(singular.slot, 0) <= R::ZERO)
            .find_map(|(which, _)| tape.without_roots(which, constants, Negligible::Integrable))
    }

    /// As [`evaluate`](Self::evaluate), where roots of what is not positive are nothing.
    pub(crate) fn evaluate_past_roots(
        &mut self,
        tape: &Tape,
        constants: &[R],
        (state, low): (&[R], &[R]),
        values: &mut [R],
    ) {
        let mut without: Option<Tape> = None;
        loop {
            let tape = without.as_ref().unwrap_or(tape);
            self.evaluate(tape, constants, state, low, values);
            if values.iter().all(|value| value.is_finite()) {
                return;
            }
            match self.past_a_root(tape, constants) {
                Some(left) => without = Some(left),
                None => return,
            }
        }
    }
}

impl<S: Scalar> Expansion<S> {
    /// The longest scaled time up to `wanted` that keeps away from every singular point, and where all arguments can be
    /// told from zero at its start. `scratch` has room for a coefficient an order.
    #[inline(always)]
    pub(crate) fn regular(
        &mut self,
        tape: &Tape,
        constants: &[S],
        wanted: S,
        scratch: &mut [S],
    ) -> (S, S::Mask) {
        let mut longest = wanted;
        let mut clear = S::Mask::splat(true);
        let mut bounded = false;
        for singular in &tape.singular {
            let a = self.computed(tape, singular.slot);
            let start = a[0].abs();
            let change = sizes(&a[1..], wanted).all * wanted;
            let far = change.at_most(start * S::splat(FAR)) & S::splat(NOTHING).less(start);
            if far.all() {
                continue;
            }
            let far = far | smooth(singular, constants);
            if far.all() {
                continue;
            }
            let within = change.at_most(start * S::splat(SHARE));
            let within = within | far;
            let mut counted = within;
            if !within.all() {
                let (reach, computed) = nearest_zero(a, scratch);
                let limit = S::select(within, wanted, reach * S::splat(SHARE));
                longest = S::select(limit.less(longest), limit, longest);
                counted = counted | computed;
            }
            if !bounded {
                self.bound_errors(tape, constants);
                bounded = true;
            }
            clear = clear & (far | (counted & self.told_from_zero(singular.slot)));
        }
        (longest, clear)
    }

    /// Which of the tape's singular points the expansion reaches no further for than a few times `scaled_step`, if it is one,
    /// and the scaled time of that.
    pub(crate) fn singularity(
        &mut self,
        tape: &Tape,
        constants: &[S],
        scaled_step: S,
    ) -> Option<(usize, S)> {
        /// Steps towards a singular point that shows in the terms are about a quarter of the way.
        const NEAR: f64 = 64.0;
        self.bound_errors(tape, constants);
        let mut scratch = vec![S::splat(0.0); self.order() + 1];
        for (which, singular) in tape.singular.iter().enumerate() {
            if smooth(singular, constants).any() {
                continue;
            }
            let a = self.computed(tape, singular.slot);
            let (reach, counted) = nearest_zero(a, &mut scratch);
            if (counted & reach.at_most(scaled_step * S::splat(NEAR))).any() {
                return Some((which, reach));
            }
            if (!self.told_from_zero(singular.slot) & a[0].is_finite()).any() {
                return Some((which, S::splat(0.0)));
            }
        }
        None
    }

    /// Whether a series is told from zero at its start.
    pub(crate) fn is_told(&mut self, tape: &Tape, constants: &[S], slot: usize) -> S::Mask {
        self.bound_errors(tape, constants);
        self.told_from_zero(slot)
    }

    #[inline(always)]
    fn told_from_zero(&self, slot: usize) -> S::Mask {
        let level = self.errors[slot].mul_add(S::splat(CLEAR), S::splat(NOTHING));
        level.less(self.get(slot, 0).abs())
    }

    /// Bounds to first order how far each series of order zero is from its exact value at this state.
    ///
    /// States and linear combinations of them come with their rounding remainders, known to twice the precision; only
    /// what takes them as plain numbers sees them rounded.
    #[inline(always)]
    fn bound_errors(&mut self, tape: &Tape, constants: &[S]) {
        let unit = S::splat(S::ROUNDOFF);
        let fine = S::splat(S::ROUNDOFF * S::ROUNDOFF);
        for slot in 0..tape.dimension {
            self.errors[slot] = self.get(slot, 0).abs() * fine;
        }
        for op in &tape.ops {
            match *op {
                Op::Linear {
                    out,
                    offset,
                    first,
                    end,
                } => {
                    let mut size = offset.map_or(S::splat(0.0), |index| constants[index].abs());
                    let mut error = S::splat(0.0);
                    for &(coefficient, slot) in &tape.terms[first..end] {
                        let coefficient = constants[coefficient].abs();
                        size = coefficient.mul_add(self.get(slot, 0).abs(), size);
                        error = coefficient.mul_add(self.errors[slot], error);
                    }
                    self.errors[out] = size.mul_add(fine, error);
                }
                Op::Rate { .. } => {}
                Op::Multiply { out, left, right } => {
                    let by_left = self.rounded_error(left) * self.get(right, 0).abs();
                    self.errors[out] =
                        (self.rounded_error(right)).mul_add(self.get(left, 0).abs(), by_left);
                }
                Op::Square { out, base } => {
                    let twice = self.get(base, 0).abs() * S::splat(2.0);
                    self.errors[out] = self.rounded_error(base) * twice;
                }
                Op::Divide {
                    out,
                    numerator,
                    denominator,
                    inverse,
                } => {
                    let above = match numerator {
                        Operand::Series(slot) => self.rounded_error(slot),
                        Operand::Constant(_) => S::splat(0.0),
                    };
                    let value = self.get(out, 0).abs();
                    let both = self.rounded_error(denominator).mul_add(value, above);
                    self.errors[out] = both * self.inverse(inverse).abs();
                }
                Op::SquareRoot {
                    out,
                    radicand,
                    inverse,
                } => {
                    self.errors[out] = self.rounded_error(radicand) * self.inverse(inverse).abs();
                }
                Op::Power {
                    out,
                    base,
                    exponent,
                    inverse,
                } => {
                    let slope = constants[exponent] * self.get(out, 0) * self.inverse(inverse);
                    self.errors[out] = self.rounded_error(base) * slope.abs();
                }
                // Of order zero it is nothing.
                Op::Slope { out, .. } => self.errors[out] = S::splat(0.0),
                Op::Integral {
                    out,
                    argument,
                    weight,
                    ..
                } => {
                    let value = self.get(out, 0).abs() * unit;
                    let slope = self.get(weight, 0).abs();
                    self.errors[out] = self.rounded_error(argument).mul_add(slope, value);
                }
                Op::SineCosine {
                    sine,
                    cosine,
                    argument,
                    ..
                } => {
                    let of_argument = self.errors[argument];
                    let (s, c) = (self.get(sine, 0).abs(), self.get(cosine, 0).abs());
                    self.errors[sine] = of_argument.mul_add(c, s * unit);
                    self.errors[cosine] = of_argument.mul_add(s, c * unit);
                }
            }
        }
    }

    /// The error of a series of order zero without its rounding remainder.
    #[inline(always)]
    fn rounded_error(&self, slot: usize) -> S {
        (self.get(slot, 0).abs()).mul_add(S::splat(S::ROUNDOFF), self.errors[slot])
    }
}

/// Where a power is one of repeated multiplication.
#[inline(always)]
fn smooth<S: Scalar>(singular: &Singular, constants: &[S]) -> S::Mask {
    match singular.exponent {
        Some(exponent) => {
            let exponent = constants[exponent];
            S::splat(0.0).less(exponent) & exponent.is_whole()
        }
        None => S::Mask::splat(false),
    }
}

/// The distance of the zero of a(s) that is nearest to s = 0, and whether it could be computed.
///
/// With a'/a = -sum_k q_k s^k, q_k = sum_i s_i^-(k+1): the largest of the later roots |q_k|^(1/(k+1)) is one over that
/// distance, up to a factor near one for several zeros as near.
#[inline(always)]
fn nearest_zero<S: Scalar>(a: &[S], scratch: &mut [S]) -> (S, S::Mask) {
    let order = a.len() - 1;
    let inverse = S::splat(1.0) / a[0];
    let mut closeness = S::splat(f64::MIN);
    let mut finite = S::Mask::splat(true);
    for k in 0..order {
        // (k + 1) a_(k+1) = -sum_{j=0..k} q_j a_(k-j)
        let rest = S::convolve(&scratch[..k], &a[1..=k]);
        let sum = (a[k + 1].mul_add(S::splat((k + 1) as f64), rest)) * inverse;
        scratch[k] = -sum;
        finite = finite & sum.is_finite();
        if k >= order / 2 {
            let root = sum.abs().coarse_log2() * S::splat(1.0 / (k + 1) as f64);
            closeness = S::select(root.less(closeness), closeness, root);
        }
    }
    ((-closeness).coarse_exp2(), finite)
}

impl Op {
    /// The series that it computes, the derivative of a state aside.
    fn writes(&self) -> impl Iterator<Item = usize> {
        let (first, second) = match *self {
            Self::Rate { .. } => (None, None),
            Self::SineCosine { sine, cosine, .. } => (Some(sine), Some(cosine)),
            Self::Linear { out, .. }
            | Self::Multiply { out, .. }
            | Self::Square { out, .. }
            | Self::Divide { out, .. }
            | Self::SquareRoot { out, .. }
            | Self::Power { out, .. }
            | Self::Slope { out, .. }
            | Self::Integral { out, .. } => (Some(out), None),
        };
        first.into_iter().chain(second)
    }
}
