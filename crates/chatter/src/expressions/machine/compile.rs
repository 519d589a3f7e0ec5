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

mod order_zero;
mod orders_above;
mod sound;

use super::assembler::{Assembler, At, Label, Vector, When, Width};
use super::executable::{Frame, Table};
use super::straight::Kept;
use crate::expressions::tape::{Operand, Tape};
use core::mem::offset_of;
use iced_x86::Register;
use sound::is_sound;

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
}
