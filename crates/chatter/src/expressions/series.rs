//! Runs a tape on truncated Taylor series: the one interpreter loop for every number type, and where there is one the
//! tape's machine code, which does the same.
//!
//! Coefficients are those of the scaled time s = t / tau, so that they are of the size of the terms themselves and
//! neither overflow nor vanish. Products are Cauchy products; a function y = F(a) with F' = w integrates y' = a' w,
//! hence k y_k = sum_{j=1..k} j a_j w_{k-j}; a quotient, root or power comes from the same rule solved for y_k.
//!
//! From one order to the next a flow waits for its own latest coefficient, through every operation on its way around. So each
//! is written as a product with what was computed last, added to all that was known before: one fused operation on that way.

use super::graph::Function;
use super::machine::{Backend, Executable, Places};
use super::tape::{Op, Operand, Sign, Swing, Tape};
use crate::numerics::polynomial::magnitude;
use crate::numerics::{Mask, Scalar, two_sum};

/// Highest order that an expansion may have.
pub const MAX_ORDER: usize = 50;

/// How many orders an expansion can choose from.
pub(crate) const ORDER_CLASSES: usize = f64::ORDERS.len();

/// 1 / k for k from 1 on, correctly rounded at each number's own precision.
#[inline(always)]
fn reciprocal<S: Scalar>(k: usize) -> S {
    S::splat(1.0) / S::splat(k as f64)
}

/// Scratch space of one thread: the coefficients of every series of a tape.
#[derive(Clone, Debug)]
pub struct Expansion<S> {
    order: usize,
    /// Whether the latest run computed the last order of all series, not of states alone.
    is_even: bool,
    /// So many runs are interpreted yet; all of them where this is the greatest number.
    patience: u32,
    values: Vec<S>,
    /// Rounding remainders of order zero, where they are known: of states and of linear combinations.
    lows: Vec<S>,
    /// Bounds of the rounding errors of order zero, where a singular point is near.
    pub(super) errors: Vec<S>,
    auxiliaries: Vec<S>,
    reciprocals: Vec<S>,
}

impl<S: Scalar> Expansion<S> {
    /// Coefficients stored for each series: no more than the number type's highest order needs, to stay in cache.
    const STRIDE: usize = S::ORDERS[S::ORDERS.len() - 1] + 1;

    /// Room for every tape of at most `slots` series and `auxiliaries` helpers.
    pub fn new(tapes: &[&Tape]) -> Self {
        let slots = tapes.iter().map(|tape| tape.slots).max().unwrap_or(0);
        let auxiliaries = tapes.iter().map(|tape| tape.auxiliaries).max().unwrap_or(0);
        let mut reciprocals = vec![S::splat(0.0)];
        reciprocals.extend((1..=MAX_ORDER + 1).map(reciprocal::<S>));
        Self {
            order: 0,
            is_even: true,
            patience: 0,
            values: vec![S::splat(0.0); slots * Self::STRIDE],
            lows: vec![S::splat(0.0); slots],
            errors: vec![S::splat(0.0); slots],
            auxiliaries: vec![S::splat(0.0); auxiliaries],
            reciprocals,
        }
        .with_backend(Backend::default())
    }

    /// The same, run by a backend of choice.
    #[must_use]
    pub fn with_backend(mut self, backend: Backend) -> Self {
        self.patience = backend.patience::<S>();
        self
    }

    /// The machine code of a tape, once it is worth it.
    #[inline(always)]
    fn code<'t>(&mut self, tape: &'t Tape) -> Option<&'t Executable> {
        if self.patience > 0 {
            if self.patience < Backend::NEVER {
                self.patience -= 1;
            }
            return None;
        }
        tape.executable::<S>(Self::STRIDE)
    }

    /// Computes all orders by machine code; whether there is any.
    #[inline(always)]
    fn run_code(&mut self, tape: &Tape, constants: &[S], tau: &S) -> bool {
        let Some(code) = self.code(tape) else {
            return false;
        };
        let places = Places {
            values: &mut self.values,
            lows: &mut self.lows,
            auxiliaries: &mut self.auxiliaries,
            constants,
            tau,
        };
        code.run(places, self.order);
        true
    }

    /// The order of the latest run.
    #[inline(always)]
    pub fn order(&self) -> usize {
        self.order
    }

    /// Coefficients of a series in powers of the scaled time, lowest first.
    #[inline(always)]
    pub fn series(&self, slot: usize) -> &[S] {
        &self.values[slot * Self::STRIDE..slot * Self::STRIDE + self.order + 1]
    }

    /// As [`series`](Self::series), as far as the latest run has computed it: where no output asks for more, what is not a
    /// state ends one order earlier.
    #[inline(always)]
    pub(super) fn computed(&self, tape: &Tape, slot: usize) -> &[S] {
        let series = self.series(slot);
        if self.is_even || slot < tape.dimension {
            series
        } else {
            &series[..series.len() - 1]
        }
    }

    /// The series of one of the tape's outputs; none where parameters alone fix it.
    pub fn output(&self, tape: &Tape, index: usize) -> Option<&[S]> {
        match tape.outputs[index] {
            Operand::Series(slot) => Some(self.series(slot)),
            Operand::Constant(_) => None,
        }
    }

    #[inline(always)]
    pub(super) fn get(&self, slot: usize, k: usize) -> S {
        self.values[slot * Self::STRIDE + k]
    }

    /// What an operation divides by, as a factor.
    #[inline(always)]
    pub(super) fn inverse(&self, auxiliary: usize) -> S {
        self.auxiliaries[auxiliary]
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, slot: usize, k: usize, value: S) {
        self.values[slot * Self::STRIDE + k] = value;
    }

    #[inline(always)]
    fn part(&self, slot: usize, from: usize, to: usize) -> &[S] {
        &self.values[slot * Self::STRIDE + from..slot * Self::STRIDE + to]
    }

    /// The sizes, added up, of the terms that a series is the sum of at its start: what its value there is rounded against.
    pub fn size_of_terms(&self, tape: &Tape, constants: &[S], slot: usize) -> S {
        let sum = tape.ops.iter().find_map(|op| match *op {
            Op::Linear {
                out,
                offset,
                first,
                end,
            } if out == slot => Some((offset, &tape.terms[first..end])),
            _ => None,
        });
        let Some((offset, terms)) = sum else {
            return self.get(slot, 0).abs();
        };
        let mut size = offset.map_or(S::splat(0.0), |index| constants[index].abs());
        for &(coefficient, slot) in terms {
            size += (constants[coefficient] * self.get(slot, 0)).abs();
        }
        size
    }

    /// How large the last terms of a series are against its leading ones, for each of the lowest orders, `count` of them: each
    /// entry of `worst` is raised to that ratio.
    ///
    /// The term before the last counts a little, for series in which every other one vanishes. What begins with a higher power, as the
    /// far end of a chain at rest that is struck, has no leading terms, and is compared with all that it has.
    #[inline(always)]
    pub fn tail_ratios(&self, slot: usize, count: usize, worst: &mut [S; ORDER_CLASSES]) {
        const BEFORE_LAST: f64 = 1.0 / 16.0;
        const TINY: f64 = 1e-290;
        // With what lies beyond the order of the run, which is not asked for: so that all places are known to exist.
        let c = &self.values[slot * Self::STRIDE..][..Self::STRIDE];
        let mut leading = (c[0].abs() + c[1].abs()) + (c[2].abs() + c[3].abs());
        let begins_late = leading.at_most(S::splat(TINY));
        if begins_late.any() {
            let all = (c[4..=self.order].iter()).fold(leading, |sum, c| sum + c.abs());
            leading = S::select(begins_late, all, leading);
        }
        let inverse = S::splat(1.0) / leading.max(S::splat(TINY));
        for (class, (worst, &order)) in worst.iter_mut().zip(&S::ORDERS).enumerate() {
            if class == count {
                break;
            }
            let tail = c[order]
                .abs()
                .max(c[order - 1].abs() * S::splat(BEFORE_LAST));
            *worst = worst.max(tail * inverse);
        }
    }

    /// The longest scaled time up to `longest`, at least one, in which no argument of an exponential swings further than
    /// this order resolves.
    ///
    /// The terms of e^a grow until their number exceeds the swing of a. Where e^a is next to nothing, so may all terms
    /// be that an expansion has, the last of them included, and the sum at the end of the step nonetheless everything:
    /// a narrow bump seen from afar. With a swing below half the order the last terms halve from one to the next at
    /// least, and what is left out is no more than the last.
    #[inline(always)]
    pub(crate) fn resolved(&self, tape: &Tape, constants: &[S], longest: f64) -> S {
        let mut resolved = S::splat(longest);
        for swing in &tape.swings {
            let (slot, allowed) = self.allowed_swing(*swing, constants);
            let changes = &self.computed(tape, slot)[1..];
            let one = magnitude(changes, S::splat(1.0));
            let all = magnitude(changes, S::splat(longest)) * S::splat(longest);
            // The logarithm of the sum of the terms' sizes is a convex function of that of the time: below its chord.
            let share = (allowed.coarse_log2() - one.coarse_log2())
                / (all.coarse_log2() - one.coarse_log2());
            let chord = (share * S::splat(libm::log2(longest))).coarse_exp2();
            let within = S::select(one.at_most(allowed), chord, allowed / one);
            let within = S::select(all.at_most(allowed), S::splat(longest), within);
            resolved = resolved.min(within);
        }
        resolved
    }

    /// The series that swings and by how much it may.
    #[inline(always)]
    fn allowed_swing(&self, swing: Swing, constants: &[S]) -> (usize, S) {
        // A power or exponential below this, base-two logarithm, is nothing.
        const NOTHING: f64 = -330.0;
        // Coarse logarithms may make a step an eighth too long.
        const NOT_ALL_THE_WAY: f64 = 0.8;
        let half_order = S::splat(0.5 * self.order as f64);
        match swing {
            Swing::Exponential { argument } => {
                let nothing = S::splat(NOTHING * core::f64::consts::LN_2) - self.get(argument, 0);
                let far = nothing * S::splat(NOT_ALL_THE_WAY);
                (argument, half_order.max(far))
            }
            Swing::Hyperbolic { argument } => (argument, half_order),
            Swing::Saturating { argument } => {
                // 1 - tanh^2 a = 4 e^(-2|a|) is visible up to here.
                let visible = S::splat(-0.5 * libm::log(S::ROUNDOFF) - 1.0);
                let value = self.get(argument, 0).abs();
                let far = ((value - visible) * S::splat(NOT_ALL_THE_WAY)).max(S::splat(1.0));
                let near = half_order * S::splat(0.5);
                (argument, S::select(value.at_most(visible), near, far))
            }
            Swing::Power { base, exponent } => {
                let exponent = constants[exponent];
                let value = self.get(base, 0).abs();
                let nothing = (S::splat(NOTHING) / exponent).coarse_exp2() - value;
                let relative = half_order * value / exponent.abs();
                let positive = S::splat(0.0).less(exponent);
                let allowed = S::select(positive, relative.max(nothing), relative);
                (base, allowed)
            }
        }
    }

    /// Values of the tape's outputs at a state: order zero, no time step.
    ///
    /// `state` and `low` as in [`run`](Self::run); `values` receives one number an output.
    #[inline(always)]
    pub fn evaluate(
        &mut self,
        tape: &Tape,
        constants: &[S],
        state: &[S],
        low: &[S],
        values: &mut [S],
    ) {
        self.settle(tape, constants, state, low);
        for (index, value) in (0..tape.outputs.len()).zip(values) {
            *value = self.value(tape, constants, index);
        }
    }

    /// As [`evaluate`](Self::evaluate); [`value`](Self::value) then says what came out.
    #[inline(always)]
    pub(crate) fn settle(&mut self, tape: &Tape, constants: &[S], state: &[S], low: &[S]) {
        self.make_room(tape);
        self.order = 0;
        self.is_even = true;
        self.start(tape, state, low);
        if !self.run_code(tape, constants, &S::splat(0.0)) {
            self.run_order(tape, constants, S::splat(0.0), 0);
        }
    }

    /// An output of the latest run at order zero.
    #[inline(always)]
    pub(crate) fn value(&self, tape: &Tape, constants: &[S], index: usize) -> S {
        match tape.outputs[index] {
            Operand::Constant(index) => constants[index],
            Operand::Series(slot) => self.get(slot, 0),
        }
    }

    /// Expands the flow of the tape's field from a state to `order`, in units of `tau`.
    ///
    /// The state is `state + low`, the second a rounding remainder that cancelling sums of states take into account.
    #[inline(always)]
    pub fn run(
        &mut self,
        tape: &Tape,
        constants: &[S],
        state: &[S],
        low: &[S],
        tau: S,
        order: usize,
    ) {
        self.make_room(tape);
        self.order = order;
        self.start(tape, state, low);
        self.is_even = !tape.outputs_are_states();
        if self.run_code(tape, constants, &tau) {
            return;
        }
        for k in 0..order {
            let factor = tau * self.reciprocals[k + 1];
            self.run_order(tape, constants, factor, k);
            self.integrate(tape, constants, factor, k);
        }
        if self.is_even {
            self.run_order(tape, constants, tau, order);
        }
    }

    /// The next coefficient of every state that no operation integrates, from order k of its derivative.
    #[inline(always)]
    fn integrate(&mut self, tape: &Tape, constants: &[S], factor: S, k: usize) {
        for &(slot, derivative) in &tape.field {
            let value = match derivative {
                Operand::Series(of) => self.get(of, k) * factor,
                Operand::Constant(index) if k == 0 => constants[index] * factor,
                Operand::Constant(_) => S::splat(0.0),
            };
            self.set(slot, k + 1, value);
        }
    }

    /// The rounding remainder of an output of the latest [`evaluate`](Self::evaluate), where it is known.
    #[inline(always)]
    pub(crate) fn output_remainder(&self, tape: &Tape, index: usize) -> S {
        match tape.outputs[index] {
            Operand::Series(slot) => self.lows[slot],
            Operand::Constant(_) => S::splat(0.0),
        }
    }

    /// Modes are compiled when they are met, and may need more room than those before.
    #[inline(always)]
    fn make_room(&mut self, tape: &Tape) {
        if self.lows.len() < tape.slots || self.auxiliaries.len() < tape.auxiliaries {
            self.grow(tape);
        }
    }

    #[cold]
    fn grow(&mut self, tape: &Tape) {
        let slots = tape.slots.max(self.lows.len());
        self.values.resize(slots * Self::STRIDE, S::splat(0.0));
        self.lows.resize(slots, S::splat(0.0));
        self.errors.resize(slots, S::splat(0.0));
        let auxiliaries = tape.auxiliaries.max(self.auxiliaries.len());
        self.auxiliaries.resize(auxiliaries, S::splat(0.0));
    }

    /// Puts the state into its slots.
    #[inline(always)]
    fn start(&mut self, tape: &Tape, state: &[S], low: &[S]) {
        for low in &mut self.lows[..tape.slots] {
            *low = S::splat(0.0);
        }
        for (slot, (&value, &low)) in state.iter().zip(low).enumerate() {
            self.set(slot, 0, value);
            self.lows[slot] = low;
        }
    }

    #[inline(always)]
    fn run_order(&mut self, tape: &Tape, constants: &[S], factor: S, k: usize) {
        for op in &tape.ops {
            match *op {
                Op::Linear {
                    out,
                    offset,
                    first,
                    end,
                } => {
                    let terms = &tape.terms[first..end];
                    let value = if k == 0 {
                        let (value, low) = self.compensated_sum(constants, offset, terms);
                        self.lows[out] = low;
                        value
                    } else {
                        self.sum(constants, terms, k)
                    };
                    self.set(out, k, value);
                }
                Op::Rate {
                    state,
                    offset,
                    first,
                    end,
                } if k < self.order => {
                    let terms = &tape.terms[first..end];
                    let value = if k == 0 {
                        self.compensated_sum(constants, offset, terms).0 * factor
                    } else {
                        self.sum_times(constants, terms, factor, k)
                    };
                    self.set(state, k + 1, value);
                }
                // There is no coefficient after the last.
                Op::Rate { .. } => {}
                Op::Multiply { out, left, right } => {
                    let value = S::convolve(self.part(left, 0, k + 1), self.part(right, 0, k + 1));
                    self.set(out, k, value);
                }
                Op::Square { out, base } => {
                    let value = self.self_convolution(base, 0, k);
                    self.set(out, k, value);
                }
                Op::Divide {
                    out,
                    numerator,
                    denominator,
                    inverse,
                } => {
                    if k == 0 {
                        self.auxiliaries[inverse] = S::splat(1.0) / self.get(denominator, 0);
                        let value = match numerator {
                            Operand::Series(slot) => self.get(slot, 0),
                            Operand::Constant(index) => constants[index],
                        } / self.get(denominator, 0);
                        self.set(out, 0, value);
                    } else {
                        let inverse = self.auxiliaries[inverse];
                        let rest =
                            S::convolve(self.part(out, 0, k), self.part(denominator, 1, k + 1));
                        let rest = -(rest * inverse);
                        let value = match numerator {
                            Operand::Series(slot) => self.get(slot, k).mul_add(inverse, rest),
                            Operand::Constant(_) => rest,
                        };
                        self.set(out, k, value);
                    }
                }
                Op::SquareRoot {
                    out,
                    radicand,
                    inverse,
                } => {
                    if k == 0 {
                        let root = self.get(radicand, 0).sqrt();
                        self.auxiliaries[inverse] = S::splat(0.5) / root;
                        self.set(out, 0, root);
                    } else {
                        let inverse = self.auxiliaries[inverse];
                        let (pairs, middle) = self.self_pairs(out, 1, k);
                        let minus_twice = inverse * S::splat(-2.0);
                        let rest = pairs.mul_add(minus_twice, -(middle * inverse));
                        let value = self.get(radicand, k).mul_add(inverse, rest);
                        self.set(out, k, value);
                    }
                }
                Op::Power {
                    out,
                    base,
                    exponent,
                    inverse,
                } => {
                    if k == 0 {
                        self.auxiliaries[inverse] = S::splat(1.0) / self.get(base, 0);
                        let value = self.get(base, 0).powf(constants[exponent]);
                        self.set(out, 0, value);
                    } else {
                        // k a_0 p_k = sum_{j=1..k} (e j - (k - j)) a_j p_{k-j}
                        let inverse = self.auxiliaries[inverse];
                        let mut sum = S::splat(0.0);
                        for j in 1..k {
                            let weight = constants[exponent]
                                .mul_add(S::splat(j as f64), S::splat(-((k - j) as f64)));
                            sum = (weight * self.get(base, j)).mul_add(self.get(out, k - j), sum);
                        }
                        let rest = sum * inverse * self.reciprocals[k];
                        let newest = constants[exponent] * self.get(out, 0) * inverse;
                        self.set(out, k, self.get(base, k).mul_add(newest, rest));
                    }
                }
                Op::Slope { out, of } => {
                    let value = self.get(of, k) * S::splat(k as f64);
                    self.set(out, k, value);
                }
                Op::Integral {
                    out,
                    slope,
                    argument,
                    weight,
                    sign,
                    function,
                } => {
                    let value = if k == 0 {
                        apply(function, self.get(argument, 0))
                    } else {
                        let sum = self.integral((slope, argument, weight), k);
                        match sign {
                            Sign::Plus => sum,
                            Sign::Minus => -sum,
                        }
                    };
                    self.set(out, k, value);
                }
                Op::SineCosine {
                    sine,
                    cosine,
                    slope,
                    argument,
                } => {
                    let (of_sine, of_cosine) = if k == 0 {
                        // The remainder of the argument turns the pair a little further.
                        let (sine, cosine) = self.get(argument, 0).sin_cos();
                        let low = self.lows[argument];
                        (low.mul_add(cosine, sine), (-low).mul_add(sine, cosine))
                    } else {
                        (
                            self.integral((slope, argument, cosine), k),
                            -self.integral((slope, argument, sine), k),
                        )
                    };
                    self.set(sine, k, of_sine);
                    self.set(cosine, k, of_cosine);
                }
            }
        }
    }

    /// A linear combination of an order above zero.
    #[inline(always)]
    fn sum(&self, constants: &[S], terms: &[(usize, usize)], k: usize) -> S {
        let mut sum = S::splat(0.0);
        for &(coefficient, slot) in terms {
            sum = sum.plus_product(constants[coefficient], self.get(slot, k));
        }
        sum.summed()
    }

    /// That combination times a factor. The last term is the one that is computed last: nothing but its own product waits for it.
    #[inline(always)]
    fn sum_times(&self, constants: &[S], terms: &[(usize, usize)], factor: S, k: usize) -> S {
        let Some((&(coefficient, slot), others)) = terms.split_last() else {
            return S::splat(0.0);
        };
        let (coefficient, newest) = (constants[coefficient] * factor, self.get(slot, k));
        if others.is_empty() {
            return newest * coefficient;
        }
        let rest = self.sum(constants, others, k) * factor;
        newest.mul_add(coefficient, rest)
    }

    /// 1/k sum_{j=1..k} j a_j w_{k-j}, the newest coefficient of a, which the slope need not be asked for, apart from the others.
    #[inline(always)]
    fn integral(&self, (slope, argument, weight): (usize, usize, usize), k: usize) -> S {
        let rest =
            S::convolve(self.part(slope, 1, k), self.part(weight, 1, k)) * self.reciprocals[k];
        self.get(argument, k).mul_add(self.get(weight, 0), rest)
    }

    /// sum_{j=first..k-first} a_j a_{k-j}.
    #[inline(always)]
    fn self_convolution(&self, slot: usize, first: usize, k: usize) -> S {
        let (pairs, middle) = self.self_pairs(slot, first, k);
        pairs.mul_add(S::splat(2.0), middle)
    }

    /// That sum as its products of different coefficients, each once, and the square in the middle.
    #[inline(always)]
    fn self_pairs(&self, slot: usize, first: usize, k: usize) -> (S, S) {
        let half = k.div_ceil(2);
        let pairs = if half > first {
            S::convolve(
                self.part(slot, first, half),
                self.part(slot, k + 1 - half, k + 1 - first),
            )
        } else {
            S::splat(0.0)
        };
        // A choice between places, not values: lanes stay together in their registers.
        let zero = S::splat(0.0);
        let middle = if k.is_multiple_of(2) && k / 2 >= first {
            &self.values[slot * Self::STRIDE + k / 2]
        } else {
            &zero
        };
        (pairs, *middle * *middle)
    }

    /// A linear combination of order zero in about twice the working precision, remainders of its terms included, and
    /// its own remainder.
    ///
    /// A difference such as `y3 - delta` near release is what decides between complete and incomplete chatter, and a
    /// phase `omega*t` of many turns is what a forced system depends on.
    #[inline(always)]
    fn compensated_sum(
        &self,
        constants: &[S],
        offset: Option<usize>,
        terms: &[(usize, usize)],
    ) -> (S, S) {
        let mut sum = match offset {
            Some(index) => constants[index],
            None => S::splat(0.0),
        };
        let mut error = S::splat(0.0);
        for &(coefficient, slot) in terms {
            let coefficient = constants[coefficient];
            let value = self.get(slot, 0);
            let product = coefficient * value;
            error += coefficient.mul_add(value, -product);
            let (total, lost) = two_sum(sum, product);
            error += lost;
            sum = total;
            error = coefficient.mul_add(self.lows[slot], error);
        }
        two_sum(sum, error)
    }
}

#[inline(always)]
pub(super) fn apply<S: Scalar>(function: Function, argument: S) -> S {
    match function {
        Function::Exp => argument.exp(),
        Function::Ln => argument.ln(),
        Function::Sin => argument.sin_cos().0,
        Function::Cos => argument.sin_cos().1,
        Function::Tan => argument.tan(),
        Function::Asin => argument.asin(),
        Function::Acos => argument.acos(),
        Function::Atan => argument.atan(),
        Function::Sinh => argument.sinh(),
        Function::Cosh => argument.cosh(),
        Function::Tanh => argument.tanh(),
    }
}
