//! Order zero: values, their rounding remainders, and what begins recurrences.

use super::{
    CHANGED_BY_CALLS, COUNT, Compiler, FACTOR, LEFT, NOW, ORDER, RIGHT, SCRATCH, TABLE, VALUES,
};
use crate::expressions::machine::assembler::{At, Vector};
use crate::expressions::machine::executable::{Callee, Table, function_of};
use crate::expressions::tape::{Op, Operand};
use core::mem::offset_of;
use iced_x86::Register;

impl Compiler<'_> {
    pub(super) fn begin(&mut self, op: &Op) {
        match *op {
            Op::Linear {
                out,
                offset,
                first,
                end,
            } => {
                for part in self.parts() {
                    let (sum, low) = self.compensated_sum((offset, first, end), part);
                    self.code.store(self.part(self.first(out, 0), part), sum);
                    self.code.store(self.part(self.low(out), part), low);
                }
            }
            Op::Rate {
                state,
                offset,
                first,
                end,
            } => {
                let skip = self.unless_last();
                for part in self.parts() {
                    let (sum, _) = self.compensated_sum((offset, first, end), part);
                    self.code.multiply(sum, sum, self.part(FACTOR, part));
                    self.code.store(self.part(self.first(state, 1), part), sum);
                }
                self.code.bind(skip);
            }
            Op::Multiply { out, left, right } => self.begin_product(out, left, right),
            Op::Square { out, base } => self.begin_product(out, base, base),
            Op::Divide {
                out,
                numerator,
                denominator,
                inverse,
            } => {
                let numerator = match numerator {
                    Operand::Series(slot) => self.first(slot, 0),
                    Operand::Constant(index) => self.constant(index),
                };
                self.begin_inverse(offset_of!(Table, one), denominator, inverse);
                for part in self.parts() {
                    let value = self.sum(part);
                    self.code.load(value, self.part(numerator, part));
                    let below = self.part(self.first(denominator, 0), part);
                    self.code.divide(value, value, below);
                }
                self.store_sums(self.first(out, 0));
            }
            Op::SquareRoot {
                out,
                radicand,
                inverse,
            } => {
                for part in self.parts() {
                    let root = self.sum(part);
                    self.code
                        .load(root, self.part(self.first(radicand, 0), part));
                    self.code.square_root(root, root);
                }
                self.store_sums(self.first(out, 0));
                self.begin_inverse(offset_of!(Table, half), out, inverse);
            }
            Op::Power {
                out,
                base,
                exponent,
                inverse,
            } => {
                self.begin_inverse(offset_of!(Table, one), base, inverse);
                self.call(
                    Callee::Power,
                    [
                        self.first(base, 0),
                        self.constant(exponent),
                        self.first(out, 0),
                    ],
                );
            }
            Op::Slope { out, of } => {
                let [zero, ..] = Self::FREE;
                self.code.zero(zero);
                for part in self.parts() {
                    let value = self.sum(part);
                    self.code
                        .multiply(value, zero, self.part(self.first(of, 0), part));
                }
                self.store_sums(self.first(out, 0));
            }
            Op::Integral {
                out,
                argument,
                function,
                ..
            } => {
                let at = self.first(argument, 0);
                self.call(Callee::Function(function), [at, at, self.first(out, 0)]);
            }
            Op::SineCosine {
                sine,
                cosine,
                argument,
                ..
            } => {
                self.call(
                    Callee::SineCosine,
                    [
                        self.first(argument, 0),
                        self.first(sine, 0),
                        self.first(cosine, 0),
                    ],
                );
                self.turn_on(sine, cosine, argument);
            }
        }
    }

    fn begin_product(&mut self, out: usize, left: usize, right: usize) {
        for part in self.parts() {
            let value = self.sum(part);
            self.code.load(value, self.part(self.first(left, 0), part));
            self.code
                .multiply(value, value, self.part(self.first(right, 0), part));
        }
        self.store_sums(self.first(out, 0));
    }

    /// A number of the table divided by a series of order zero.
    fn begin_inverse(&mut self, above: usize, below: usize, inverse: usize) {
        let [number, ..] = Self::FREE;
        self.code.broadcast(number, At(TABLE, above));
        for part in self.parts() {
            let value = self.sum(part);
            let below = self.part(self.first(below, 0), part);
            self.code.divide(value, number, below);
        }
        self.store_sums(self.auxiliary(inverse));
    }

    /// Turns a sine and cosine by what their argument is known to beyond its digits.
    fn turn_on(&mut self, sine: usize, cosine: usize, argument: usize) {
        for part in self.parts() {
            let (s, c, low) = (self.sum(part), self.odd(part), self.other(part));
            let [new_sine, new_cosine, ..] = Self::FREE;
            let at_sine = self.part(self.first(sine, 0), part);
            let at_cosine = self.part(self.first(cosine, 0), part);
            self.code.load(s, at_sine);
            self.code.load(c, at_cosine);
            self.code.load(low, self.part(self.low(argument), part));
            self.code.copy(new_sine, s);
            self.code.multiply_add(new_sine, low, c);
            self.code.negate(low, Self::minus_zero());
            self.code.copy(new_cosine, c);
            self.code.multiply_add(new_cosine, low, s);
            self.code.store(at_sine, new_sine);
            self.code.store(at_cosine, new_cosine);
        }
    }

    /// A linear combination of order zero and its rounding remainder, in registers.
    fn compensated_sum(
        &mut self,
        (offset, first, end): (Option<usize>, usize, usize),
        part: usize,
    ) -> (Vector, Vector) {
        let [sum, error, coefficient, value, product, total, shadow, lost] =
            [0, 1, 2, 3, 4, 5, 6, 7].map(Vector);
        match offset {
            Some(index) => self.code.load(sum, self.part(self.constant(index), part)),
            None => self.code.zero(sum),
        }
        self.code.zero(error);
        for &(index, slot) in &self.tape.terms[first..end] {
            self.code
                .load(coefficient, self.part(self.constant(index), part));
            self.code.load(value, self.part(self.first(slot, 0), part));
            self.code.multiply(product, coefficient, value);
            self.code.multiply_subtract(value, coefficient, product);
            self.code.add(error, error, value);
            self.two_sum((sum, product), (total, lost), shadow);
            self.code.add(error, error, lost);
            self.code.copy(sum, total);
            self.code
                .multiply_add(error, coefficient, self.part(self.low(slot), part));
        }
        self.two_sum((sum, error), (total, lost), shadow);
        (total, lost)
    }

    /// The exact sum of two numbers, which are lost.
    fn two_sum(&mut self, (a, b): (Vector, Vector), (sum, lost): (Vector, Vector), shadow: Vector) {
        self.code.add(sum, a, b);
        self.code.subtract(shadow, sum, a);
        self.code.subtract(b, b, shadow);
        self.code.subtract(shadow, sum, shadow);
        self.code.subtract(a, a, shadow);
        self.code.add(lost, a, b);
    }

    /// Calls for the lanes of the chunk what no instruction computes.
    fn call(&mut self, callee: Callee, [first, second, third]: [At; 3]) {
        self.code.end_of_vectors();
        for register in CHANGED_BY_CALLS {
            self.code.save(register);
        }
        // Arguments by way of registers that hold none of them.
        self.code.address(LEFT, first);
        self.code.address(RIGHT, second);
        self.code.address(COUNT, third);
        self.code.copy_word(Register::RDI, LEFT);
        self.code.copy_word(Register::RSI, RIGHT);
        self.code.copy_word(Register::RDX, COUNT);
        let lanes = self.registers * self.bytes / size_of::<f64>();
        self.code.set(Register::RCX, lanes);
        self.code.set(SCRATCH, function_of(callee));
        self.code.call(SCRATCH);
        for register in CHANGED_BY_CALLS.into_iter().rev() {
            self.code.restore(register);
        }
        self.code.set(ORDER, 0);
        self.code.copy_word(NOW, VALUES);
    }
}
