//! The latest coefficients of some series, in registers that not every width has.
//!
//! From one order to the next a flow waits for its latest coefficient. What was just stored can be loaded again only after a while,
//! longer than a product takes; with AVX-512 half the registers are free to hold it meanwhile. They hold what memory holds.

use super::assembler::{Vector, Width};
use crate::expressions::tape::{Op, Operand, Tape};

/// Registers that nothing else uses.
const FIRST: usize = 16;
const COUNT: usize = 16;

/// Whose latest coefficients are where. States are ahead of all others: once their next coefficient is computed, their present one is
/// in memory alone.
pub(super) struct Latest {
    /// Registers in a number.
    registers: usize,
    /// Series, by place, and whether their present coefficient is there at this point of the code.
    series: Vec<(usize, bool)>,
    /// States that the loop over the orders moves on.
    moving: Vec<usize>,
}

impl Latest {
    /// Places for the series whose present coefficients are asked for, as far as there are registers.
    pub fn of(tape: &Tape, width: Width, registers: usize) -> Self {
        let places = match width {
            Width::Eight => COUNT / registers,
            Width::One | Width::Four => 0,
        };
        let mut series: Vec<(usize, bool)> = Vec::new();
        for slot in asked_for(tape) {
            if series.len() < places && !series.iter().any(|&(known, _)| known == slot) {
                series.push((slot, false));
            }
        }
        let rates = tape.ops.iter().filter_map(|op| match *op {
            Op::Rate { state, .. } => Some(state),
            _ => None,
        });
        Self {
            registers,
            series,
            moving: (rates.chain(tape.field.iter().map(|&(state, _)| state))).collect(),
        }
    }

    fn place(&self, slot: usize) -> Option<usize> {
        self.series.iter().position(|&(known, _)| known == slot)
    }

    /// Where a part of the latest coefficient of a series goes, if there is room for it.
    pub fn register(&self, slot: usize, part: usize) -> Option<Vector> {
        let place = self.place(slot)?;
        Some(Vector(FIRST + place * self.registers + part))
    }

    /// Where its present coefficient is, if it is in a register.
    pub fn present(&self, slot: usize, part: usize) -> Option<Vector> {
        let is_there = self.series[self.place(slot)?].1;
        self.register(slot, part).filter(|_| is_there)
    }

    /// The next order begins: what was the next coefficient of a state is its present one.
    pub fn next_order(&mut self) {
        for (slot, is_there) in &mut self.series {
            *is_there = self.moving.contains(slot);
        }
    }

    /// The present coefficient of a series has been computed.
    pub fn is_computed(&mut self, slot: usize) {
        self.set(slot, true);
    }

    /// The next coefficient of a state has, or it is the last one.
    pub fn has_moved(&mut self, state: usize) {
        self.set(state, false);
    }

    fn set(&mut self, slot: usize, is_there: bool) {
        if let Some(place) = self.place(slot) {
            self.series[place].1 = is_there;
        }
    }
}

/// Series whose present coefficients the operations ask for, in their sequence.
fn asked_for(tape: &Tape) -> Vec<usize> {
    let mut slots = Vec::new();
    for op in &tape.ops {
        match *op {
            Op::Linear { first, end, .. } | Op::Rate { first, end, .. } => {
                slots.extend(tape.terms[first..end].iter().map(|&(_, slot)| slot));
            }
            Op::Multiply { left, right, .. } => slots.extend([left, right]),
            Op::Square { base, .. } | Op::Power { base, .. } => slots.push(base),
            Op::Divide {
                numerator,
                denominator,
                ..
            } => {
                slots.push(denominator);
                slots.extend(series_of(numerator));
            }
            Op::SquareRoot { radicand, .. } => slots.push(radicand),
            Op::Slope { of, .. } => slots.push(of),
            Op::Integral { argument, .. } | Op::SineCosine { argument, .. } => slots.push(argument),
        }
    }
    let rates = tape.field.iter().filter_map(|&(_, rate)| series_of(rate));
    slots.extend(rates);
    slots
}

fn series_of(operand: Operand) -> Option<usize> {
    match operand {
        Operand::Series(slot) => Some(slot),
        Operand::Constant(_) => None,
    }
}
