//! Orders above zero: sums of products over the orders below.

use super::{COUNT, Compiler, FACTOR, LEFT, ORDER, RIGHT, SCRATCH, TABLE, VALUES};
use crate::expressions::machine::assembler::{At, Vector, When};
use crate::expressions::machine::executable::Table;
use crate::expressions::tape::{Op, Operand, Sign};
use core::mem::offset_of;

/// How many products a sum over orders has, at order k.
#[derive(Clone, Copy)]
enum Terms {
    /// k and so many more.
    Order(isize),
    /// Half of k, rounded up, and so many less.
    Half(usize),
}

impl Compiler<'_> {
    pub(super) fn go_on(&mut self, op: &Op) {
        match *op {
            Op::Linear {
                out, first, end, ..
            } => {
                self.combine(first, end);
                self.finish_now(out);
            }
            Op::Rate {
                state, first, end, ..
            } => {
                let skip = self.unless_last();
                self.combine_times_factor(first, end);
                self.finish_after(state);
                self.code.bind(skip);
            }
            Op::Multiply { out, left, right } => {
                self.convolve((left, 0), (right, 0), Terms::Order(1));
                self.finish_now(out);
            }
            Op::Square { out, base } => {
                self.convolve((base, 0), (base, 0), Terms::Half(0));
                let [two, ..] = Self::FREE;
                self.code.broadcast(two, At(TABLE, offset_of!(Table, two)));
                self.middle(base);
                for part in self.parts() {
                    let (pairs, middle) = (self.sum(part), self.other(part));
                    self.code.multiply_add(middle, pairs, two);
                    self.code.copy(pairs, middle);
                }
                self.finish_now(out);
            }
            Op::Divide {
                out,
                numerator,
                denominator,
                inverse,
            } => {
                self.convolve((out, 0), (denominator, 1), Terms::Order(0));
                for part in self.parts() {
                    let (rest, factor) = (self.sum(part), self.other(part));
                    self.code
                        .load(factor, self.part(self.auxiliary(inverse), part));
                    self.code.multiply(rest, rest, factor);
                    if let Operand::Series(slot) = numerator {
                        let value = self.odd(part);
                        self.code.load(value, self.present(slot, part));
                        self.code.multiply_subtract(value, factor, rest);
                        self.code.copy(rest, value);
                    }
                }
                if matches!(numerator, Operand::Constant(_)) {
                    self.negate_sums();
                }
                self.finish_now(out);
            }
            Op::SquareRoot {
                out,
                radicand,
                inverse,
            } => {
                self.convolve((out, 1), (out, 1), Terms::Half(1));
                let [minus_two, ..] = Self::FREE;
                self.code
                    .broadcast(minus_two, At(TABLE, offset_of!(Table, minus_two)));
                self.middle(out);
                for part in self.parts() {
                    let (pairs, middle, factor) =
                        (self.sum(part), self.other(part), self.odd(part));
                    let [_, minus_twice, ..] = Self::FREE;
                    self.code
                        .load(factor, self.part(self.auxiliary(inverse), part));
                    self.code.multiply(minus_twice, factor, minus_two);
                    self.code.multiply(middle, middle, factor);
                    self.code.multiply_subtract(pairs, minus_twice, middle);
                    let radicand = self.present(radicand, part);
                    self.code.multiply_add(pairs, factor, radicand);
                }
                self.finish_now(out);
            }
            Op::Power {
                out,
                base,
                exponent,
                inverse,
            } => self.go_on_with_power(out, base, exponent, inverse),
            Op::Slope { out, of } => {
                let [k, ..] = Self::FREE;
                let numbers = At(TABLE, offset_of!(Table, numbers));
                self.code.broadcast_indexed(k, numbers, ORDER);
                for part in self.parts() {
                    let (value, of) = (self.sum(part), self.present(of, part));
                    self.code.multiply(value, k, of);
                }
                self.finish_now(out);
            }
            Op::Integral {
                out,
                slope,
                argument,
                weight,
                sign,
                ..
            } => {
                self.integral_in_sums((slope, argument, weight));
                if sign == Sign::Minus {
                    self.negate_sums();
                }
                self.finish_now(out);
            }
            Op::SineCosine {
                sine,
                cosine,
                slope,
                argument,
            } => {
                self.integral_in_sums((slope, argument, cosine));
                self.finish_now(sine);
                self.integral_in_sums((slope, argument, sine));
                self.negate_sums();
                self.finish_now(cosine);
            }
        }
    }

    /// A linear combination of the present order, in the sums.
    fn combine(&mut self, first: usize, end: usize) {
        let tape = self.tape;
        for part in self.parts() {
            self.code.zero(self.sum(part));
        }
        for &(coefficient, slot) in &tape.terms[first..end] {
            for part in self.parts() {
                let factor = self.other(part);
                let at = self.part(self.constant(coefficient), part);
                self.code.load(factor, at);
                let term = self.present(slot, part);
                self.code.multiply_add(self.sum(part), factor, term);
            }
        }
    }

    /// A linear combination of the present order, times the factor, in the sums; what is computed last apart from the rest.
    fn combine_times_factor(&mut self, first: usize, end: usize) {
        let Some(&(coefficient, slot)) = self.tape.terms[first..end].last() else {
            for part in self.parts() {
                self.code.zero(self.sum(part));
            }
            return;
        };
        let is_alone = end - first == 1;
        if !is_alone {
            self.combine(first, end - 1);
        }
        for part in self.parts() {
            let (sum, scaled) = (self.sum(part), self.other(part));
            self.code.load(scaled, self.part(FACTOR, part));
            if !is_alone {
                self.code.multiply(sum, sum, scaled);
            }
            let coefficient = self.part(self.constant(coefficient), part);
            self.code.multiply(scaled, scaled, coefficient);
            let newest = self.present(slot, part);
            if is_alone {
                self.code.multiply(sum, scaled, newest);
            } else {
                self.code.multiply_add(sum, scaled, newest);
            }
        }
    }

    /// What a function is at the present order, but for the sign, in the sums.
    fn integral_in_sums(&mut self, (slope, argument, weight): (usize, usize, usize)) {
        self.convolve((slope, 1), (weight, 1), Terms::Order(-1));
        self.divide_by_order();
        for part in self.parts() {
            let newest = self.other(part);
            self.code.load(newest, self.present(argument, part));
            let weight = self.part(self.first(weight, 0), part);
            self.code.multiply_add(self.sum(part), newest, weight);
        }
    }

    fn divide_by_order(&mut self) {
        let [reciprocal, ..] = Self::FREE;
        let reciprocals = At(TABLE, offset_of!(Table, reciprocals));
        self.code.broadcast_indexed(reciprocal, reciprocals, ORDER);
        for part in self.parts() {
            let sum = self.sum(part);
            self.code.multiply(sum, sum, reciprocal);
        }
    }

    /// The square of the coefficient of half the present order, if that is whole, else zero, in the other registers.
    fn middle(&mut self, slot: usize) {
        let (zero, done) = (self.code.label(), self.code.label());
        self.code.test_odd(ORDER);
        self.code.jump(When::NotEqual, zero);
        self.code.copy_word(LEFT, ORDER);
        self.code.times(LEFT, self.layout.size / 2);
        self.code.add_word(LEFT, VALUES);
        let at = At(LEFT, self.first(slot, 0).1);
        for part in self.parts() {
            let middle = self.other(part);
            self.code.load(middle, self.part(at, part));
            self.code.multiply(middle, middle, middle);
        }
        self.code.jump(When::Always, done);
        self.code.bind(zero);
        for part in self.parts() {
            self.code.zero(self.other(part));
        }
        self.code.bind(done);
    }

    /// sum_i a_i b_{n-1-i} in the sums, in the order of [`convolve`](crate::numerics::Scalar::convolve).
    ///
    /// Of the first series coefficients count from one place on; of the second they end where together they are of the
    /// present order.
    fn convolve(&mut self, left: (usize, usize), right: (usize, usize), terms: Terms) {
        let size = self.layout.size;
        let (all, rest, one, done) = (
            self.code.label(),
            self.code.label(),
            self.code.label(),
            self.code.label(),
        );
        let outermost = self.first(left.0, left.1);
        // Of the last coefficient: at k + c terms from place p on it is number p + k + c - 1.
        let newest = match terms {
            Terms::Order(more) => {
                let end = right.1.wrapping_add_signed(more);
                self.now(right.0).plus(end * size).minus(size)
            }
            Terms::Half(first) => self.now(right.0).minus(first * size),
        };
        // Products between the two outermost ones.
        match terms {
            Terms::Order(more) => {
                self.code.copy_word(COUNT, ORDER);
                self.code
                    .subtract_from(COUNT, 2_usize.wrapping_add_signed(-more));
            }
            Terms::Half(first) => {
                self.code.address(COUNT, At(ORDER, 1));
                self.code.halve(COUNT);
                self.code.subtract_from(COUNT, first + 2);
            }
        }
        if !matches!(terms, Terms::Order(1..)) {
            self.code.compare_with(COUNT, -1);
            self.code.jump(When::Equal, one);
            self.code.jump(When::Greater, all);
            for part in self.parts() {
                self.code.zero(self.sum(part));
            }
            self.code.jump(When::Always, done);
            self.code.bind(one);
            for part in self.parts() {
                let sum = self.sum(part);
                self.code.load(sum, self.part(outermost, part));
                self.code.multiply(sum, sum, self.part(newest, part));
            }
            self.code.jump(When::Always, done);
        }
        self.code.bind(all);
        self.code.address(LEFT, outermost.plus(size));
        self.code.address(RIGHT, newest.minus(size));
        for part in self.parts() {
            self.code.zero(self.sum(part));
            self.code.zero(self.odd(part));
        }
        let pairs = self.code.label();
        self.code.subtract_from(COUNT, 2);
        self.code.jump(When::Less, rest);
        self.code.bind(pairs);
        let (a, b) = (At(LEFT, 0), At(RIGHT, 0));
        self.products(Self::sum, a, b);
        self.products(Self::odd, a.plus(size), b.minus(size));
        self.code.add_to(LEFT, 2 * size);
        self.code.subtract_from(RIGHT, 2 * size);
        self.code.subtract_from(COUNT, 2);
        self.code.jump(When::AtLeast, pairs);
        self.code.bind(rest);
        let outer = self.code.label();
        self.code.compare_with(COUNT, -1);
        self.code.jump(When::NotEqual, outer);
        self.products(Self::sum, a, b);
        self.code.add_to(LEFT, size);
        self.code.subtract_from(RIGHT, size);
        self.code.bind(outer);
        for part in self.parts() {
            let sum = self.sum(part);
            self.code.add(sum, sum, self.odd(part));
        }
        self.products(Self::sum, a, b);
        self.products(Self::sum, newest, outermost);
        self.code.bind(done);
    }

    /// Adds the products of two numbers to sums.
    fn products(&mut self, sums: impl Fn(&Self, usize) -> Vector, left: At, right: At) {
        for part in self.parts() {
            let factor = self.other(part);
            self.code.load(factor, self.part(left, part));
            let sum = sums(self, part);
            self.code.multiply_add(sum, factor, self.part(right, part));
        }
    }

    fn go_on_with_power(&mut self, out: usize, base: usize, exponent: usize, inverse: usize) {
        let size = self.layout.size;
        let (next, newest) = (self.code.label(), self.code.label());
        // From j = 1 on; k - j counts down, until there is but the newest product.
        self.code.address(LEFT, self.first(base, 1));
        self.code.address(RIGHT, self.now(out).minus(size));
        self.code.copy_word(COUNT, ORDER);
        self.code.set(SCRATCH, 0);
        for part in self.parts() {
            self.code.zero(self.sum(part));
        }
        self.code.bind(next);
        self.code.subtract_from(COUNT, 1);
        self.code.jump(When::Equal, newest);
        self.code.add_to(SCRATCH, 1);
        let [j, less, ..] = Self::FREE;
        let numbers = At(TABLE, offset_of!(Table, numbers));
        self.code.broadcast_indexed(j, numbers, SCRATCH);
        let negatives = At(TABLE, offset_of!(Table, negatives));
        self.code.broadcast_indexed(less, negatives, COUNT);
        for part in self.parts() {
            let weight = self.other(part);
            self.code.copy(weight, less);
            self.code
                .multiply_add(weight, j, self.part(self.constant(exponent), part));
            self.code
                .multiply(weight, weight, self.part(At(LEFT, 0), part));
            self.code
                .multiply_add(self.sum(part), weight, self.part(At(RIGHT, 0), part));
        }
        self.code.add_to(LEFT, size);
        self.code.subtract_from(RIGHT, size);
        self.code.jump(When::Always, next);
        self.code.bind(newest);
        for part in self.parts() {
            let sum = self.sum(part);
            self.code
                .multiply(sum, sum, self.part(self.auxiliary(inverse), part));
        }
        self.divide_by_order();
        for part in self.parts() {
            let weight = self.other(part);
            self.code
                .load(weight, self.part(self.constant(exponent), part));
            for factor in [self.first(out, 0), self.auxiliary(inverse)] {
                self.code.multiply(weight, weight, self.part(factor, part));
            }
            let newest = self.present(base, part);
            self.code.multiply_add(self.sum(part), weight, newest);
        }
        self.finish_now(out);
    }
}
