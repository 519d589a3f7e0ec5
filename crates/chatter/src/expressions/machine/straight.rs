//! Orders above zero written out: no loop is left, and what was just computed is still in a register.
//!
//! A trajectory alone waits for its own latest coefficient and for nothing else, so that every load from where it was just
//! stored, and every loop that ends at another count, shows. Lanes wait for loads: two a product, where none is left in a register.
//! Of models so large that the code would not stay in the cache the higher orders are left to the loop of
//! [`compile`](super::compile), which is shorter.

use super::assembler::{At, Label, When, Width};
use super::compile::{Compiler, LAST, TABLE, TAU};
use super::executable::Table;
use super::group::{Group, Place};
use crate::expressions::tape::{Op, Operand, Sign};
use core::mem::offset_of;

/// Groups of registers for sums and factors; …
const SECOND: Group = Group(1);
const MIDDLE: Group = Group(2);
const PAIRS: Group = Group(3);
const FACTORS: [Group; 4] = [Group(4), Group(5), Group(6), Group(7)];
/// … for coefficients that were computed last, in turn; …
const KEPT: [Group; 7] = [
    Group(8),
    Group(9),
    Group(10),
    Group(11),
    Group(12),
    Group(13),
    Group(14),
];
/// … and for the unit of time over the order to come.
const UNIT: Group = Group(15);

/// Groups that are named here.
const GROUPS: usize = 16;

/// Which coefficients stand in which registers.
#[derive(Default)]
pub(super) struct Kept {
    coefficients: [Option<(usize, usize)>; KEPT.len()],
    turn: usize,
    factor: usize,
}

impl Kept {
    fn find(&self, slot: usize, k: usize) -> Option<Group> {
        let place = (self.coefficients)
            .iter()
            .position(|&kept| kept == Some((slot, k)))?;
        Some(KEPT[place])
    }

    /// The register that was filled first of all; it holds nothing any more.
    fn fresh(&mut self) -> (usize, Group) {
        let place = self.turn;
        self.turn = (self.turn + 1) % KEPT.len();
        self.coefficients[place] = None;
        (place, KEPT[place])
    }
}

impl Compiler<'_> {
    /// Whether there are the registers for it.
    pub(super) fn has_room_to_write_out(&self) -> bool {
        let registers = match self.code.width {
            Width::One | Width::Four => 16,
            Width::Eight => 32,
        };
        GROUPS * self.registers <= registers
    }

    /// Orders from the first on, as far as the code may be written out; the order that is next, and where a run that needs
    /// no more of them goes to.
    pub(super) fn orders_straight(&mut self) -> (usize, Label) {
        let tape = self.tape;
        let done = self.code.label();
        let highest = self.layout.stride - 1;
        let begin = self.code.length();
        for k in 1..=highest {
            if self.code.length() - begin > self.layout.straight || self.code.failed() {
                return (k, done);
            }
            self.code.compare_with(LAST, k as i32);
            self.code.jump(When::Less, done);
            self.unit(k);
            for op in &tape.ops {
                // Whatever lies beyond the last coefficient that is asked for is nobody's, as long as there is room.
                if k < highest || !matches!(op, Op::Rate { .. }) {
                    self.at_order(op, k);
                }
            }
            if k < highest {
                self.integrate_straight(k);
            }
        }
        (highest + 1, done)
    }

    fn unit(&mut self, k: usize) {
        let reciprocal = offset_of!(Table, reciprocals) + (k + 1) * size_of::<f64>();
        self.broadcast(UNIT, At(TABLE, reciprocal));
        self.multiply(UNIT, UNIT, At(TAU, 0));
    }

    fn integrate_straight(&mut self, k: usize) {
        let tape = self.tape;
        for &(state, rate) in &tape.field {
            let (place, out) = self.kept.fresh();
            match rate {
                Operand::Series(of) => {
                    let rate = self.value(of, k);
                    self.multiply(out, UNIT, rate);
                }
                Operand::Constant(_) => self.zero(out),
            }
            self.keep(place, (state, k + 1));
        }
    }

    /// Where a coefficient is read from.
    fn value(&self, slot: usize, k: usize) -> Place {
        match self.kept.find(slot, k) {
            Some(register) => register.into(),
            None => self.first(slot, k).into(),
        }
    }

    /// A coefficient in some register.
    fn in_register(&mut self, slot: usize, k: usize) -> Group {
        if let Some(register) = self.kept.find(slot, k) {
            return register;
        }
        let register = self.next_factor();
        self.load(register, self.first(slot, k));
        register
    }

    fn next_factor(&mut self) -> Group {
        self.kept.factor = (self.kept.factor + 1) % FACTORS.len();
        FACTORS[self.kept.factor]
    }

    /// Stores what a fresh register holds.
    fn keep(&mut self, place: usize, (slot, k): (usize, usize)) {
        self.store(self.first(slot, k), KEPT[place]);
        self.kept.coefficients[place] = Some((slot, k));
    }

    /// A number of the table, in every lane.
    fn number(&mut self, table: usize, index: usize) -> Group {
        let number = self.next_factor();
        self.broadcast(number, At(TABLE, table + index * size_of::<f64>()));
        number
    }

    /// Adds the product of two coefficients to a sum.
    fn add_product(&mut self, sum: Group, left: (usize, usize), right: (usize, usize)) {
        if let Some(right) = self.kept.find(right.0, right.1) {
            let left = self.value(left.0, left.1);
            self.multiply_add(sum, right, left);
        } else {
            let left = self.in_register(left.0, left.1);
            self.multiply_add(sum, left, self.first(right.0, right.1));
        }
    }

    /// sum_{i=0..n-1} a_{first + i} b_{last - i}, in the order of [`convolve`](crate::numerics::Scalar::convolve).
    fn convolution(
        &mut self,
        sum: Group,
        (left, first): (usize, usize),
        (right, last): (usize, usize),
        n: usize,
    ) {
        match n {
            0 => self.zero(sum),
            1 => {
                let factor = self.in_register(left, first);
                let other = self.value(right, last);
                self.multiply(sum, factor, other);
            }
            _ => {
                self.zero(sum);
                self.zero(SECOND);
                for i in 1..n - 1 {
                    let into = if i % 2 == 1 { sum } else { SECOND };
                    self.add_product(into, (left, first + i), (right, last - i));
                }
                self.add(sum, sum, SECOND);
                self.add_product(sum, (left, first + n - 1), (right, last + 1 - n));
                self.add_product(sum, (left, first), (right, last));
            }
        }
    }

    /// Of different coefficients of one series, from `first` on.
    fn different_pairs(&mut self, slot: usize, first: usize, k: usize) {
        let n = k.div_ceil(2) - first;
        self.convolution(PAIRS, (slot, first), (slot, k - first), n);
    }

    /// The square of the coefficient in the middle, or zero.
    fn middle_square(&mut self, into: Group, slot: usize, k: usize) {
        if k.is_multiple_of(2) {
            let middle = self.in_register(slot, k / 2);
            self.multiply(into, middle, middle);
        } else {
            self.zero(into);
        }
    }

    fn sum_of_terms(&mut self, sum: Group, first: usize, end: usize, k: usize) {
        let tape = self.tape;
        self.zero(sum);
        for &(coefficient, slot) in &tape.terms[first..end] {
            let coefficient = self.constant(coefficient);
            if let Some(value) = self.kept.find(slot, k) {
                self.multiply_add(sum, value, coefficient);
            } else {
                let factor = self.next_factor();
                self.load(factor, coefficient);
                self.multiply_add(sum, factor, self.first(slot, k));
            }
        }
    }

    /// A linear combination times the unit of time, what is computed last apart from the rest.
    fn sum_of_terms_times_unit(&mut self, sum: Group, first: usize, end: usize, k: usize) {
        let Some(&(coefficient, slot)) = self.tape.terms[first..end].last() else {
            self.zero(sum);
            return;
        };
        let scaled = MIDDLE;
        self.multiply(scaled, UNIT, self.constant(coefficient));
        if end - first == 1 {
            let newest = self.value(slot, k);
            self.multiply(sum, scaled, newest);
            return;
        }
        self.sum_of_terms(sum, first, end - 1, k);
        self.multiply(sum, sum, UNIT);
        let newest = self.value(slot, k);
        self.multiply_add(sum, scaled, newest);
    }

    fn at_order(&mut self, op: &Op, k: usize) {
        match *op {
            Op::Linear {
                out, first, end, ..
            } => {
                let (place, sum) = self.kept.fresh();
                self.sum_of_terms(sum, first, end, k);
                self.keep(place, (out, k));
            }
            Op::Rate {
                state, first, end, ..
            } => {
                let (place, sum) = self.kept.fresh();
                self.sum_of_terms_times_unit(sum, first, end, k);
                self.keep(place, (state, k + 1));
            }
            Op::Multiply { out, left, right } => {
                let (place, sum) = self.kept.fresh();
                self.convolution(sum, (left, 0), (right, k), k + 1);
                self.keep(place, (out, k));
            }
            Op::Square { out, base } => {
                let (place, value) = self.kept.fresh();
                self.different_pairs(base, 0, k);
                self.middle_square(value, base, k);
                let two = self.number(offset_of!(Table, two), 0);
                self.multiply_add(value, PAIRS, two);
                self.keep(place, (out, k));
            }
            Op::Divide {
                out,
                numerator,
                denominator,
                inverse,
            } => {
                let (place, value) = self.kept.fresh();
                self.convolution(PAIRS, (out, 0), (denominator, k), k);
                self.multiply(PAIRS, PAIRS, self.auxiliary(inverse));
                match numerator {
                    Operand::Series(slot) => {
                        self.load(value, self.auxiliary(inverse));
                        let above = self.in_register(slot, k);
                        self.multiply_subtract(value, above, PAIRS);
                    }
                    Operand::Constant(_) => {
                        self.copy(value, PAIRS);
                        self.negate(value);
                    }
                }
                self.keep(place, (out, k));
            }
            Op::SquareRoot {
                out,
                radicand,
                inverse,
            } => {
                let (place, value) = self.kept.fresh();
                self.middle_square(MIDDLE, out, k);
                self.multiply(MIDDLE, MIDDLE, self.auxiliary(inverse));
                self.different_pairs(out, 1, k);
                let minus_two = self.number(offset_of!(Table, minus_two), 0);
                self.multiply(value, minus_two, self.auxiliary(inverse));
                self.multiply_subtract(value, PAIRS, MIDDLE);
                let radicand = self.in_register(radicand, k);
                self.multiply_add(value, radicand, self.auxiliary(inverse));
                self.keep(place, (out, k));
            }
            Op::Power {
                out,
                base,
                exponent,
                inverse,
            } => {
                let (place, sum) = self.kept.fresh();
                self.zero(sum);
                for j in 1..k {
                    let negative = self.number(offset_of!(Table, negatives), k - j);
                    self.copy(MIDDLE, negative);
                    let whole = self.number(offset_of!(Table, numbers), j);
                    self.multiply_add(MIDDLE, whole, self.constant(exponent));
                    let coefficient = self.value(base, j);
                    self.multiply(MIDDLE, MIDDLE, coefficient);
                    let other = self.value(out, k - j);
                    self.multiply_add(sum, MIDDLE, other);
                }
                self.multiply(sum, sum, self.auxiliary(inverse));
                let reciprocal = self.number(offset_of!(Table, reciprocals), k);
                self.multiply(sum, sum, reciprocal);
                self.load(MIDDLE, self.constant(exponent));
                self.multiply(MIDDLE, MIDDLE, self.first(out, 0));
                self.multiply(MIDDLE, MIDDLE, self.auxiliary(inverse));
                let newest = self.value(base, k);
                self.multiply_add(sum, MIDDLE, newest);
                self.keep(place, (out, k));
            }
            Op::Slope { out, of } => {
                let (place, value) = self.kept.fresh();
                let whole = self.number(offset_of!(Table, numbers), k);
                let coefficient = self.value(of, k);
                self.multiply(value, whole, coefficient);
                self.keep(place, (out, k));
            }
            Op::Integral {
                out,
                slope,
                argument,
                weight,
                sign,
                ..
            } => self.integral(out, (slope, argument, weight), sign, k),
            Op::SineCosine {
                sine,
                cosine,
                slope,
                argument,
            } => {
                self.integral(sine, (slope, argument, cosine), Sign::Plus, k);
                self.integral(cosine, (slope, argument, sine), Sign::Minus, k);
            }
        }
    }

    fn integral(
        &mut self,
        out: usize,
        (slope, argument, weight): (usize, usize, usize),
        sign: Sign,
        k: usize,
    ) {
        let (place, sum) = self.kept.fresh();
        self.convolution(sum, (slope, 1), (weight, k - 1), k - 1);
        let reciprocal = self.number(offset_of!(Table, reciprocals), k);
        self.multiply(sum, sum, reciprocal);
        self.add_product(sum, (weight, 0), (argument, k));
        if sign == Sign::Minus {
            self.negate(sum);
        }
        self.keep(place, (out, k));
    }
}
