//! What a tape may be asked.

use crate::expressions::tape::{Op, Operand, Tape};

/// Whether every place that an operation names exists: what is read and written is decided here, not by the code.
pub(super) fn is_sound(tape: &Tape) -> bool {
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
