//! From a tape to instructions: the operations of [`Expansion::run_order`](super::super::Expansion) in their sequence, each
//! rounded as there.
//!
//! ```text
//! for each chunk of lanes that fits a few registers
//!     every operation at order zero
//!     for k in 1 ..= last            one loop: sums over orders are loops in it
//!         every operation at order k, every state at order k + 1
//! ```
//!
//! What an operation reads and writes stands in memory, so that nothing has to be kept in registers from one to the next,
//! nor over a call. Where there are registers for it the lower orders are written out before the loop
//! ([`straight`](super::straight)).

use super::assembler::{Assembler, At, Label, Vector, When, Width};
use super::executable::{Callee, Frame, Table, function_of};
use super::straight::Kept;
use crate::expressions::tape::{Op, Operand, Sign, Tape};
use core::mem::offset_of;
use iced_x86::Register;

/// Registers in a chunk: with two sums in each product of series as many additions are under way as a processor can begin
/// before the first of them is done.
const REGISTERS: usize = 4;

/// Code that is longer is not kept: the tape is interpreted.
const LONGEST_CODE: usize = 1 << 20;

pub(super) const VALUES: Register = Register::RDI;
const CONSTANTS: Register = Register::RSI;
const AUXILIARIES: Register = Register::RDX;
const LOWS: Register = Register::RCX;
pub(super) const TAU: Register = Register::R8;
pub(super) const TABLE: Register = Register::R9;
/// The order of the coefficients that are computed just now, …
const ORDER: Register = Register::RAX;
/// … and where those of the first series are: `VALUES` so many numbers on.
const NOW: Register = Register::R10;
/// The last order of the states, …
const LAST_OF_STATES: Register = Register::RBP;
/// … and of everything else.
pub(super) const LAST: Register = Register::RBX;
const CHUNKS: Register = Register::R14;
const COUNT: Register = Register::R11;
const LEFT: Register = Register::R12;
const RIGHT: Register = Register::R13;
const SCRATCH: Register = Register::R15;

/// Product of the step's unit of time and one over the order to come.
const FACTOR: At = At(Register::RSP, 0);

const SAVED: [Register; 6] = [
    Register::RBX,
    Register::RBP,
    Register::R12,
    Register::R13,
    Register::R14,
    Register::R15,
];
/// What a call may change of what is used here.
const CHANGED_BY_CALLS: [Register; 6] = [VALUES, CONSTANTS, AUXILIARIES, LOWS, TAU, TABLE];

/// What the numbers are that a tape runs on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Layout {
    /// Doubles in a number.
    pub lanes: usize,
    /// Bytes from one number to the next.
    pub size: usize,
    /// Coefficients from one series to the next.
    pub stride: usize,
    /// So many bytes of code may be spent on writing orders out.
    pub straight: usize,
}

/// The code of a tape; none where it would be too long, or the tape refers to what it does not have.
pub(super) fn compile(tape: &Tape, layout: Layout, width: Width) -> Option<Vec<u8>> {
    if !is_sound(tape) {
        return None;
    }
    let registers = (layout.lanes / width.doubles()).min(REGISTERS);
    if registers == 0 || !layout.lanes.is_multiple_of(registers * width.doubles()) {
        return None;
    }
    let mut compiler = Compiler {
        code: Assembler::new(width),
        tape,
        layout,
        registers,
        bytes: width.doubles() * size_of::<f64>(),
        kept: Kept::default(),
    };
    compiler.whole()?;
    compiler.code.finish()
}

/// Whether every place that an operation names exists: what is read and written is decided here, not by the code.
fn is_sound(tape: &Tape) -> bool {
    let slot = |slot: usize| slot < tape.slots;
    let constant = |index: usize| index < tape.constants.len();
    let auxiliary = |index: usize| index < tape.auxiliaries;
    let operand = |operand: Operand| match operand {
        Operand::Constant(index) => constant(index),
        Operand::Series(index) => slot(index),
    };
    let sum = |offset: Option<usize>, first: usize, end: usize| {
        offset.is_none_or(constant)
            && (tape.terms.get(first..end))
                .is_some_and(|terms| terms.iter().all(|&(c, s)| constant(c) && slot(s)))
    };
    let op = |op: &Op| match *op {
        Op::Linear {
            out,
            offset,
            first,
            end,
        } => slot(out) && sum(offset, first, end),
        Op::Rate {
            state,
            offset,
            first,
            end,
        } => slot(state) && sum(offset, first, end),
        Op::Multiply { out, left, right } => slot(out) && slot(left) && slot(right),
        Op::Square { out, base } => slot(out) && slot(base),
        Op::Divide {
            out,
            numerator,
            denominator,
            inverse,
        } => slot(out) && operand(numerator) && slot(denominator) && auxiliary(inverse),
        Op::SquareRoot {
            out,
            radicand,
            inverse,
        } => slot(out) && slot(radicand) && auxiliary(inverse),
        Op::Power {
            out,
            base,
            exponent,
            inverse,
        } => slot(out) && slot(base) && constant(exponent) && auxiliary(inverse),
        Op::Slope { out, of } => slot(out) && slot(of),
        Op::Integral {
            out,
            slope,
            argument,
            weight,
            ..
        } => slot(out) && slot(slope) && slot(argument) && slot(weight),
        Op::SineCosine {
            sine,
            cosine,
            slope,
            argument,
        } => slot(sine) && slot(cosine) && slot(slope) && slot(argument),
    };
    let field = |&(state, rate): &(usize, Operand)| slot(state) && operand(rate);
    tape.dimension <= tape.slots && tape.ops.iter().all(op) && tape.field.iter().all(field)
}

/// How many products a sum over orders has, at order k.
#[derive(Clone, Copy)]
enum Terms {
    /// k and so many more.
    Order(isize),
    /// Half of k, rounded up, and so many less.
    Half(usize),
}

pub(super) struct Compiler<'t> {
    pub(super) code: Assembler,
    pub(super) tape: &'t Tape,
    pub(super) layout: Layout,
    /// Registers in a chunk.
    pub(super) registers: usize,
    /// Bytes in a register.
    bytes: usize,
    pub(super) kept: Kept,
}

impl Compiler<'_> {
    fn whole(&mut self) -> Option<()> {
        let chunk = self.registers * self.bytes;
        for register in SAVED {
            self.code.save(register);
        }
        // With the address to return to the stack stays a multiple of sixteen bytes.
        let room = chunk.next_multiple_of(16) + 8;
        self.code.subtract_from(Register::RSP, room);
        // The frame comes in the register of the values: that one last.
        for (register, field) in [
            (LAST_OF_STATES, offset_of!(Frame, order)),
            (CONSTANTS, offset_of!(Frame, constants)),
            (AUXILIARIES, offset_of!(Frame, auxiliaries)),
            (LOWS, offset_of!(Frame, lows)),
            (TAU, offset_of!(Frame, tau)),
            (TABLE, offset_of!(Frame, table)),
            (VALUES, offset_of!(Frame, values)),
        ] {
            self.code.load_word(register, At(VALUES, field));
        }
        self.code.copy_word(LAST, LAST_OF_STATES);
        if self.tape.outputs_are_states() {
            self.code.subtract_from(LAST, 1);
        }
        let chunks = self.layout.lanes * size_of::<f64>() / chunk;
        let next_chunk = self.code.label();
        self.code.set(CHUNKS, chunks);
        self.code.bind(next_chunk);
        self.orders()?;
        for pointer in [VALUES, CONSTANTS, AUXILIARIES, LOWS, TAU] {
            self.code.add_to(pointer, chunk);
        }
        self.code.subtract_from(CHUNKS, 1);
        self.code.jump(When::NotEqual, next_chunk);
        self.code.end_of_vectors();
        self.code.add_to(Register::RSP, room);
        for register in SAVED.into_iter().rev() {
            self.code.restore(register);
        }
        self.code.give_back();
        Some(())
    }

    fn orders(&mut self) -> Option<()> {
        let tape = self.tape;
        self.code.set(ORDER, 0);
        self.code.copy_word(NOW, VALUES);
        self.factor();
        for op in &tape.ops {
            self.begin(op);
            self.keep_short()?;
        }
        self.integrate(true);
        let (next, done) = if self.has_room_to_write_out() {
            let (first, done) = self.orders_straight();
            if first == self.layout.stride {
                self.code.bind(done);
                return Some(());
            }
            self.code.set(ORDER, first - 1);
            self.code.address(NOW, self.first(0, first - 1));
            (self.code.label(), done)
        } else {
            (self.code.label(), self.code.label())
        };
        self.code.compare(ORDER, LAST);
        self.code.jump(When::AtLeast, done);
        self.code.bind(next);
        self.code.add_to(ORDER, 1);
        self.code.add_to(NOW, self.layout.size);
        self.code.compare(ORDER, LAST);
        self.code.jump(When::Greater, done);
        self.factor();
        for op in &tape.ops {
            self.go_on(op);
            self.keep_short()?;
        }
        self.integrate(false);
        self.code.jump(When::Always, next);
        self.code.bind(done);
        Some(())
    }

    fn keep_short(&self) -> Option<()> {
        (self.code.length() <= LONGEST_CODE && !self.code.failed()).then_some(())
    }

    // Where things stand.

    /// The lowest coefficient of a series, or another.
    pub(super) fn first(&self, slot: usize, k: usize) -> At {
        At(VALUES, (slot * self.layout.stride + k) * self.layout.size)
    }

    /// The present coefficient of a series.
    fn now(&self, slot: usize) -> At {
        At(NOW, slot * self.layout.stride * self.layout.size)
    }

    /// The coefficient after that.
    fn after(&self, slot: usize) -> At {
        self.now(slot).plus(self.layout.size)
    }

    pub(super) fn constant(&self, index: usize) -> At {
        At(CONSTANTS, index * self.layout.size)
    }

    pub(super) fn auxiliary(&self, index: usize) -> At {
        At(AUXILIARIES, index * self.layout.size)
    }

    fn low(&self, slot: usize) -> At {
        At(LOWS, slot * self.layout.size)
    }

    pub(super) fn minus_zero() -> At {
        At(TABLE, offset_of!(Table, minus_zero))
    }

    /// A register of the chunk's sums, of the second ones, of others.
    fn sum(&self, part: usize) -> Vector {
        Vector(part)
    }

    fn odd(&self, part: usize) -> Vector {
        Vector(self.registers + part)
    }

    fn other(&self, part: usize) -> Vector {
        Vector(2 * self.registers + part)
    }

    /// Registers that no chunk uses.
    const FREE: [Vector; 4] = [Vector(12), Vector(13), Vector(14), Vector(15)];

    pub(super) fn parts(&self) -> core::ops::Range<usize> {
        0..self.registers
    }

    /// The part of a number that belongs to a register of the chunk.
    pub(super) fn part(&self, at: At, part: usize) -> At {
        at.plus(part * self.bytes)
    }

    // What several operations do.

    fn factor(&mut self) {
        let [unit, ..] = Self::FREE;
        // Reciprocals begin with that of one: that of the order to come stands at the present one.
        let reciprocals = At(TABLE, offset_of!(Table, reciprocals) + size_of::<f64>());
        self.code.broadcast_indexed(unit, reciprocals, ORDER);
        for part in self.parts() {
            let product = self.sum(part);
            self.code
                .multiply(product, unit, self.part(At(TAU, 0), part));
            self.code.store(self.part(FACTOR, part), product);
        }
    }

    fn store_sums(&mut self, at: At) {
        for part in self.parts() {
            self.code.store(self.part(at, part), self.sum(part));
        }
    }

    /// Stores the sums as the present coefficient of a series, or as that after it.
    fn finish_now(&mut self, slot: usize) {
        self.store_sums(self.now(slot));
    }

    fn finish_after(&mut self, state: usize) {
        self.store_sums(self.after(state));
    }

    /// A part of the present coefficient of a series.
    fn present(&self, slot: usize, part: usize) -> At {
        self.part(self.now(slot), part)
    }

    fn negate_sums(&mut self) {
        for part in self.parts() {
            self.code.negate(self.sum(part), Self::minus_zero());
        }
    }

    /// Runs what follows only while states have a coefficient to come.
    fn unless_last(&mut self) -> Label {
        let skip = self.code.label();
        self.code.compare(ORDER, LAST_OF_STATES);
        self.code.jump(When::AtLeast, skip);
        skip
    }

    /// The next coefficient of every state that no operation integrates.
    fn integrate(&mut self, at_zero: bool) {
        let tape = self.tape;
        if tape.field.is_empty() {
            return;
        }
        let skip = self.unless_last();
        for &(state, rate) in &tape.field {
            for part in self.parts() {
                let sum = self.sum(part);
                let rate = match rate {
                    Operand::Series(of) => self.present(of, part),
                    Operand::Constant(index) if at_zero => self.part(self.constant(index), part),
                    Operand::Constant(_) => {
                        self.code.zero(sum);
                        continue;
                    }
                };
                self.code.load(sum, rate);
                self.code.multiply(sum, sum, self.part(FACTOR, part));
            }
            self.finish_after(state);
        }
        self.code.bind(skip);
    }

    // Order zero.

    fn begin(&mut self, op: &Op) {
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

    // Orders above zero.

    fn go_on(&mut self, op: &Op) {
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

    /// sum_i a_i b_{n-1-i} in the sums, in the order of [`convolve`](crate::expressions::series::convolve).
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
