//! Expressions as straight-line operations on truncated series.
//!
//! A tape holds a vector field and any number of further outputs. Whatever depends on parameters alone is a constant of
//! the tape, computed once for each parameter set; the rest is a list of operations, each of which yields the
//! coefficient of order k of one series from coefficients of order k and below of others. [`series`](super::series)
//! runs it.

use super::graph::{Expr, Function, Graph};
use super::machine::{Compiled, Executable};
use super::singularity::Singular;
use crate::numerics::Real;

/// Where a value comes from while a tape runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operand {
    /// A constant of the tape: its index.
    Constant(usize),
    /// A series: its slot. Slots below the dimension are the states.
    Series(usize),
}

impl Operand {
    fn slot(self) -> Option<usize> {
        match self {
            Self::Constant(_) => None,
            Self::Series(slot) => Some(slot),
        }
    }
}

/// One operation; every field named `out` or after an operand is a slot, `inverse` an auxiliary value.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Op {
    /// `offset + sum coefficient * series`: a range of the tape's term list.
    Linear {
        out: usize,
        offset: Option<usize>,
        first: usize,
        end: usize,
    },
    /// A linear combination that is the derivative of a state and nothing else: it is integrated at once.
    Rate {
        state: usize,
        offset: Option<usize>,
        first: usize,
        end: usize,
    },
    Multiply {
        out: usize,
        left: usize,
        right: usize,
    },
    Square {
        out: usize,
        base: usize,
    },
    Divide {
        out: usize,
        numerator: Operand,
        denominator: usize,
        inverse: usize,
    },
    SquareRoot {
        out: usize,
        radicand: usize,
        inverse: usize,
    },
    /// A power with constant exponent that no product or root expresses.
    Power {
        out: usize,
        base: usize,
        exponent: usize,
        inverse: usize,
    },
    /// k times the coefficient of order k: the derivative's series, shifted by one.
    Slope {
        out: usize,
        of: usize,
    },
    /// A function whose derivative is `sign * weight`: its series integrates `slope * weight`.
    Integral {
        out: usize,
        slope: usize,
        argument: usize,
        weight: usize,
        sign: Sign,
        function: Function,
    },
    SineCosine {
        sine: usize,
        cosine: usize,
        slope: usize,
        argument: usize,
    },
}

/// A series of which a function may grow out of next to nothing: no coefficient of the function shows it beforehand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Swing {
    /// Argument of an exponential, which is zero to rounding where the argument is far below zero.
    Exponential { argument: usize },
    /// Argument of a hyperbolic sine and cosine.
    Hyperbolic { argument: usize },
    /// Argument of a hyperbolic tangent, which is constant to rounding where the argument is large.
    Saturating { argument: usize },
    /// Base of a power; the exponent is a constant of the tape.
    Power { base: usize, exponent: usize },
}

impl Swing {
    pub(super) fn slot(self) -> usize {
        match self {
            Self::Exponential { argument }
            | Self::Hyperbolic { argument }
            | Self::Saturating { argument } => argument,
            Self::Power { base, .. } => base,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sign {
    Plus,
    Minus,
}

impl Op {
    /// The series that it reads.
    fn reads(&self, terms: &[(usize, usize)]) -> Vec<usize> {
        match *self {
            Self::Linear { first, end, .. } | Self::Rate { first, end, .. } => {
                terms[first..end].iter().map(|&(_, slot)| slot).collect()
            }
            Self::Multiply { left, right, .. } => vec![left, right],
            Self::Square { base, .. } | Self::Power { base, .. } => vec![base],
            Self::Divide {
                numerator,
                denominator,
                ..
            } => numerator.slot().into_iter().chain([denominator]).collect(),
            Self::SquareRoot { radicand, .. } => vec![radicand],
            Self::Slope { of, .. } => vec![of],
            Self::Integral {
                slope,
                argument,
                weight,
                ..
            } => vec![slope, argument, weight],
            Self::SineCosine {
                slope, argument, ..
            } => vec![slope, argument],
        }
    }

    pub(super) fn swing(&self) -> Option<Swing> {
        match *self {
            Self::Integral {
                function: Function::Exp,
                argument,
                ..
            } => Some(Swing::Exponential { argument }),
            Self::Integral {
                function: Function::Sinh | Function::Cosh,
                argument,
                ..
            } => Some(Swing::Hyperbolic { argument }),
            Self::Integral {
                function: Function::Tanh,
                argument,
                ..
            } => Some(Swing::Saturating { argument }),
            Self::Power { base, exponent, .. } => Some(Swing::Power { base, exponent }),
            _ => None,
        }
    }
}

/// A vector field and outputs, ready to run on any [`Scalar`](crate::numerics::Scalar).
#[derive(Clone, Debug)]
pub struct Tape {
    pub(crate) dimension: usize,
    pub(crate) slots: usize,
    pub(crate) auxiliaries: usize,
    pub(crate) ops: Vec<Op>,
    pub(crate) terms: Vec<(usize, usize)>,
    /// States, each with its derivative, that no operation integrates at once.
    pub(crate) field: Vec<(usize, Operand)>,
    pub(crate) outputs: Vec<Operand>,
    /// What limits a step besides the size of its last terms.
    pub(crate) swings: Vec<Swing>,
    /// What must not vanish along a step.
    pub(crate) singular: Vec<Singular>,
    pub(super) constants: Vec<Expr>,
    pub(super) compiled: Compiled,
}

impl Tape {
    /// Makes an output a series, if it is a constant: a function whose jumps from one tape to another count.
    pub(crate) fn as_series(&mut self, output: usize) {
        if let Operand::Constant(offset) = self.outputs[output] {
            self.ops.push(Op::Linear {
                out: self.slots,
                offset: Some(offset),
                first: 0,
                end: 0,
            });
            self.outputs[output] = Operand::Series(self.slots);
            self.slots += 1;
        }
    }

    /// Integrates linear combinations that are the derivative of a state at once; the swings are known. What else reads one of them
    /// reads it as before: the state is the same to the bit whether anything does.
    pub(super) fn integrate_at_once(&mut self) {
        let mut readers = vec![0; self.slots];
        let operands = self.outputs.iter().chain(self.field.iter().map(|(_, d)| d));
        let read = (operands.filter_map(|operand| operand.slot()))
            // Nothing else may read what swings: a power of a multiple can be the multiple of a power.
            .chain(self.swings.iter().map(|swing| swing.slot()))
            .chain(self.singular.iter().map(|singular| singular.slot))
            .chain(self.ops.iter().flat_map(|op| op.reads(&self.terms)));
        for slot in read {
            readers[slot] += 1;
        }
        for op in core::mem::take(&mut self.ops) {
            let Op::Linear {
                out,
                offset,
                first,
                end,
            } = op
            else {
                self.ops.push(op);
                continue;
            };
            let is_its_rate = |&(_, derivative): &(usize, Operand)| derivative.slot() == Some(out);
            let states: Vec<usize> = (self.field.iter().filter(|one| is_its_rate(one)))
                .map(|&(state, _)| state)
                .collect();
            self.field.retain(|one| !is_its_rate(one));
            if readers[out] > states.len() {
                self.ops.push(op);
            }
            for state in states {
                // With terms of its own: those of each operation are put in order.
                let own = self.terms.len();
                self.terms.extend_from_within(first..end);
                self.ops.push(Op::Rate {
                    state,
                    offset,
                    first: own,
                    end: self.terms.len(),
                });
            }
        }
    }

    /// Puts last, in sums and in products, what is known last: nothing else need wait for it then.
    pub(super) fn put_latest_last(&mut self) {
        let depths = self.depths();
        for op in &mut self.ops {
            match op {
                Op::Linear { first, end, .. } | Op::Rate { first, end, .. } => {
                    let terms = &mut self.terms[*first..*end];
                    let depth = |&(_, slot): &(usize, usize)| depths[slot];
                    let deepest = terms.iter().map(depth).max();
                    if let Some(place) = terms.iter().rposition(|term| Some(depth(term)) == deepest)
                    {
                        terms[place..].rotate_left(1);
                    }
                }
                Op::Multiply { left, right, .. } if depths[*left] > depths[*right] => {
                    core::mem::swap(left, right);
                }
                _ => {}
            }
        }
    }

    /// After how many operations in turn a coefficient of each series is known, at an order so high that beginnings no longer
    /// count.
    fn depths(&self) -> Vec<usize> {
        const ORDERS: usize = 16;
        let mut depths = vec![0; self.slots];
        for _ in 0..ORDERS {
            let mut next = depths.clone();
            for op in &self.ops {
                let reads = op.reads(&self.terms);
                let depth = 1 + reads
                    .into_iter()
                    .map(|slot| depths[slot])
                    .max()
                    .unwrap_or(0);
                match *op {
                    Op::Rate { state, .. } => next[state] = depth,
                    Op::SineCosine { sine, cosine, .. } => {
                        (depths[sine], depths[cosine]) = (depth, depth);
                    }
                    Op::Linear { out, .. }
                    | Op::Multiply { out, .. }
                    | Op::Square { out, .. }
                    | Op::Divide { out, .. }
                    | Op::SquareRoot { out, .. }
                    | Op::Power { out, .. }
                    | Op::Slope { out, .. }
                    | Op::Integral { out, .. } => depths[out] = depth,
                }
            }
            for &(state, derivative) in &self.field {
                next[state] = 1 + derivative.slot().map_or(0, |slot| depths[slot]);
            }
            depths[..self.dimension].copy_from_slice(&next[..self.dimension]);
        }
        depths
    }

    /// Its machine code for a kind of number, of whose series so many coefficients are stored; none where there is none.
    #[inline]
    pub(super) fn executable<S: 'static>(&self, stride: usize) -> Option<&Executable> {
        self.compiled.get::<S>(self, stride)
    }

    /// Number of states.
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// How many constants a parameter set gives.
    pub fn constant_count(&self) -> usize {
        self.constants.len()
    }

    /// Number of operations for each order.
    pub fn operation_count(&self) -> usize {
        self.ops.len()
    }

    /// Number of outputs.
    pub fn output_count(&self) -> usize {
        self.outputs.len()
    }

    /// Whether it has been compiled for this kind of number.
    pub fn is_compiled<S: 'static>(&self) -> bool {
        self.compiled.has::<S>()
    }

    /// The tape's constants at one parameter set.
    pub fn constants<R: Real>(&self, graph: &Graph, parameters: &[R]) -> Vec<R> {
        graph.evaluate_all(&self.constants, &[], parameters)
    }

    /// The expressions of the constants.
    pub(crate) fn constant_exprs(&self) -> &[Expr] {
        &self.constants
    }

    /// Indices of the constants whose expressions satisfy a condition.
    pub(crate) fn constants_where(&self, condition: impl Fn(Expr) -> bool) -> Vec<usize> {
        let matching = |(index, &expr): (usize, &Expr)| condition(expr).then_some(index);
        self.constants
            .iter()
            .enumerate()
            .filter_map(matching)
            .collect()
    }

    /// Whether every output is a state or a constant, so that no operation is needed at the last order.
    #[inline(always)]
    pub(crate) fn outputs_are_states(&self) -> bool {
        self.outputs.iter().all(|output| match output {
            Operand::Constant(_) => true,
            Operand::Series(slot) => *slot < self.dimension,
        })
    }
}
