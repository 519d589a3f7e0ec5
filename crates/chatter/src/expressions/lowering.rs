//! From expressions to a tape: each subexpression once, constants apart, functions by the differential equations that they
//! satisfy.

use super::graph::domain::Folding;
use super::graph::eval::LARGEST_MULTIPLIED_EXPONENT;
use super::graph::{Expr, Function, Graph, Node, Symbol};
use super::machine::Compiled;
use super::singularity::{Singular, Singularity};
use super::tape::{Op, Operand, Sign, Swing, Tape};
use rustc_hash::FxHashMap;
use std::sync::Arc;

/// Up to this power an expansion of the lowest order sees what a base of any size grows into, by the size of its terms.
const VISIBLE_POWER: f64 = 16.0;

impl Tape {
    /// Lowers the field (one expression a state, or none where only outputs at a point are wanted) and the outputs.
    ///
    /// `graph` may grow: powers with variable exponents become exponentials.
    pub fn new(graph: &mut Graph, dimension: usize, field: &[Expr], outputs: &[Expr]) -> Self {
        // Constants are products and sums of what is checked as it was written; what the state changes is kept so.
        let folding = graph.set_folding(Folding::Continued);
        let mut lowering = Lowering {
            stateful: Vec::new(),
            series: FxHashMap::default(),
            constants: FxHashMap::default(),
            slopes: FxHashMap::default(),
            sine_cosines: FxHashMap::default(),
            graph,
            tape: Self {
                dimension,
                slots: dimension,
                auxiliaries: 0,
                ops: Vec::new(),
                terms: Vec::new(),
                field: Vec::new(),
                outputs: Vec::new(),
                swings: Vec::new(),
                singular: Vec::new(),
                constants: Vec::new(),
                compiled: Compiled::default(),
            },
        };
        let field: Vec<Operand> = field.iter().map(|&e| lowering.operand(e)).collect();
        lowering.tape.field = field.into_iter().enumerate().collect();
        lowering.tape.outputs = outputs.iter().map(|&e| lowering.operand(e)).collect();
        let mut exprs = FxHashMap::default();
        for (&expr, &slot) in &lowering.series {
            // Of equal ones the first, so that it does not depend on the order of the map.
            let first = exprs.entry(slot).or_insert(expr);
            if expr.index() < first.index() {
                *first = expr;
            }
        }
        // In an order of their own, since the graph may grow by what is asked of it here.
        let mut pairs: Vec<_> = lowering.sine_cosines.drain().collect();
        pairs.sort_unstable();
        for (argument, (sine, cosine)) in pairs {
            exprs.insert(sine, lowering.graph.call(Function::Sin, argument));
            exprs.insert(cosine, lowering.graph.call(Function::Cos, argument));
        }
        lowering.graph.set_folding(folding);
        let mut tape = lowering.tape;
        for swing in tape.ops.iter().filter_map(Op::swing) {
            if !tape.swings.contains(&swing) {
                tape.swings.push(swing);
            }
        }
        tape.find_singular(&exprs);
        tape.integrate_at_once();
        tape.put_latest_last();
        tape
    }
}

#[derive(Default)]
struct LinearForm {
    offsets: Vec<Expr>,
    terms: Vec<(usize, usize)>,
}

/// Sums within sums are written out up to so many terms: sums that share parts have exponentially many.
const MOST_INLINED: usize = 64;

struct Lowering<'g> {
    graph: &'g mut Graph,
    tape: Tape,
    /// Per node: whether it depends on a state, once known.
    stateful: Vec<Option<bool>>,
    series: FxHashMap<Expr, usize>,
    constants: FxHashMap<Expr, usize>,
    slopes: FxHashMap<usize, usize>,
    sine_cosines: FxHashMap<Expr, (usize, usize)>,
}

impl Lowering<'_> {
    fn depends_on_state(&mut self, expr: Expr) -> bool {
        if self.stateful.len() <= expr.index() {
            self.stateful.resize(self.graph.len(), None);
        }
        if let Some(known) = self.stateful[expr.index()] {
            return known;
        }
        let answer = match self.graph.node(expr).clone() {
            Node::Number(_) | Node::Pi | Node::Symbol(Symbol::Parameter(_)) => false,
            Node::Symbol(Symbol::State(_)) => true,
            Node::Sum(parts) | Node::Product(parts) => {
                parts.iter().any(|&part| self.depends_on_state(part))
            }
            Node::Power(base, exponent) => {
                self.depends_on_state(base) || self.depends_on_state(exponent)
            }
            Node::Call(_, argument) | Node::Floor(argument) | Node::Curve(_, argument, _) => {
                self.depends_on_state(argument)
            }
            Node::Switch {
                surface,
                above,
                below,
                ..
            } => [surface, above, below]
                .into_iter()
                .any(|part| self.depends_on_state(part)),
        };
        self.stateful[expr.index()] = Some(answer);
        answer
    }

    fn operand(&mut self, expr: Expr) -> Operand {
        if self.depends_on_state(expr) {
            Operand::Series(self.slot(expr))
        } else {
            Operand::Constant(self.constant(expr))
        }
    }

    fn constant(&mut self, expr: Expr) -> usize {
        if let Some(&index) = self.constants.get(&expr) {
            return index;
        }
        let index = self.tape.constants.len();
        self.tape.constants.push(expr);
        self.constants.insert(expr, index);
        index
    }

    fn new_slot(&mut self) -> usize {
        self.tape.slots += 1;
        self.tape.slots - 1
    }

    fn new_auxiliary(&mut self) -> usize {
        self.tape.auxiliaries += 1;
        self.tape.auxiliaries - 1
    }

    fn slope(&mut self, of: usize) -> usize {
        if let Some(&slot) = self.slopes.get(&of) {
            return slot;
        }
        let out = self.new_slot();
        self.tape.ops.push(Op::Slope { out, of });
        self.slopes.insert(of, out);
        out
    }

    fn slot(&mut self, expr: Expr) -> usize {
        if let Some(&slot) = self.series.get(&expr) {
            return slot;
        }
        let slot = match self.graph.node(expr).clone() {
            Node::Symbol(Symbol::State(index)) => index,
            Node::Sum(parts) => self.linear(&parts),
            Node::Product(factors) => self.product(expr, &factors),
            Node::Power(base, exponent) => self.power(base, exponent),
            Node::Call(function, argument) => self.call(function, argument),
            // Parameters and numbers never reach here: they are constants. Nor do corners, which the mode has settled: one
            // that does is a constant without a value.
            Node::Number(_)
            | Node::Pi
            | Node::Symbol(Symbol::Parameter(_))
            | Node::Switch { .. }
            | Node::Floor(_)
            | Node::Curve(..) => {
                let offset = Some(self.constant(expr));
                let (out, end) = (self.new_slot(), self.tape.terms.len());
                self.tape.ops.push(Op::Linear {
                    out,
                    offset,
                    first: end,
                    end,
                });
                out
            }
        };
        self.series.insert(expr, slot);
        slot
    }

    /// Splits a term into what parameters fix and what the state changes.
    fn split(&mut self, term: Expr) -> (Expr, Option<Expr>) {
        if !self.depends_on_state(term) {
            return (term, None);
        }
        let factors = match self.graph.node(term).clone() {
            Node::Product(factors) => factors,
            _ => Arc::from([term]),
        };
        let (varying, fixed): (Vec<Expr>, Vec<Expr>) =
            (factors.iter().copied()).partition(|&factor| self.depends_on_state(factor));
        let coefficient = self.graph.product(&fixed);
        (coefficient, Some(self.product_as_written(&varying)))
    }

    /// Terms of a sum, each a coefficient and a series, and the offsets; constant factors are multiplied into the sums
    /// that they stand before, which saves an operation an order.
    fn collect(&mut self, parts: &[Expr], factor: Option<Expr>, into: &mut LinearForm) {
        for &part in parts {
            let (coefficient, varying) = self.split(part);
            let coefficient = match factor {
                Some(factor) => self.graph.mul(factor, coefficient),
                None => coefficient,
            };
            let Some(varying) = varying else {
                into.offsets.push(coefficient);
                continue;
            };
            match self.graph.node(varying).clone() {
                Node::Sum(inner)
                    if !self.series.contains_key(&varying) && into.terms.len() < MOST_INLINED =>
                {
                    self.collect(&inner, Some(coefficient), into);
                }
                _ => {
                    let slot = self.slot(varying);
                    into.terms.push((self.constant(coefficient), slot));
                }
            }
        }
    }

    fn linear(&mut self, parts: &[Expr]) -> usize {
        let mut form = LinearForm::default();
        self.collect(parts, None, &mut form);
        let offset = if form.offsets.is_empty() {
            None
        } else {
            let sum = self.graph.sum(&form.offsets);
            Some(self.constant(sum))
        };
        let out = self.new_slot();
        let first = self.tape.terms.len();
        self.tape.terms.extend(form.terms);
        let end = self.tape.terms.len();
        self.tape.ops.push(Op::Linear {
            out,
            offset,
            first,
            end,
        });
        out
    }

    fn product(&mut self, expr: Expr, factors: &[Expr]) -> usize {
        if factors.iter().any(|&factor| !self.depends_on_state(factor)) {
            return self.linear(&[expr]);
        }
        let mut above = Vec::new();
        let mut below = Vec::new();
        for &factor in factors {
            match self.negative_power(factor) {
                Some(reciprocal) => below.push(reciprocal),
                None => above.push(factor),
            }
        }
        if below.is_empty() {
            let mut slot = self.slot(above[0]);
            for &factor in &above[1..] {
                slot = self.multiply(slot, factor);
            }
            return slot;
        }
        let numerator = self.product_as_written(&above);
        let denominator = self.product_as_written(&below);
        let numerator = self.operand(numerator);
        self.divide(numerator, denominator)
    }

    /// Of some of the factors of a product, as they stand in it.
    fn product_as_written(&mut self, factors: &[Expr]) -> Expr {
        let folding = self.graph.set_folding(Folding::Exact);
        let product = self.graph.product(factors);
        self.graph.set_folding(folding);
        product
    }

    fn multiply(&mut self, left: usize, factor: Expr) -> usize {
        let right = self.slot(factor);
        let out = self.new_slot();
        self.tape.ops.push(if left == right {
            Op::Square { out, base: left }
        } else {
            Op::Multiply { out, left, right }
        });
        out
    }

    /// For a power with negative numeric exponent: its reciprocal.
    fn negative_power(&mut self, expr: Expr) -> Option<Expr> {
        let &Node::Power(base, exponent) = self.graph.node(expr) else {
            return None;
        };
        let value = self.graph.as_number(exponent)?;
        if value.high() >= 0.0 {
            return None;
        }
        let positive = self.graph.number_exact(-value);
        Some(self.graph.power(base, positive))
    }

    fn divide(&mut self, numerator: Operand, denominator: Expr) -> usize {
        let denominator = self.slot(denominator);
        let inverse = self.new_auxiliary();
        let out = self.new_slot();
        self.tape.ops.push(Op::Divide {
            out,
            numerator,
            denominator,
            inverse,
        });
        out
    }

    fn power(&mut self, base: Expr, exponent: Expr) -> usize {
        let whole = self.graph.power(base, exponent);
        if let Some(reciprocal) = self.negative_power(whole) {
            let one = self.graph.number(1.0);
            let one = self.operand(one);
            return self.divide(one, reciprocal);
        }
        if self.depends_on_state(exponent) {
            let logarithm = self.graph.call(Function::Ln, base);
            let scaled = self.graph.product(&[exponent, logarithm]);
            let exponential = self.graph.call(Function::Exp, scaled);
            return self.slot(exponential);
        }
        let number = self.graph.as_number(exponent);
        let twice = number.map(|n| 2.0 * n.high()).filter(|t| {
            *t == t.trunc()
                && number.is_some_and(|n| n.low() == 0.0)
                && *t > 0.0
                && *t <= 2.0 * f64::from(LARGEST_MULTIPLIED_EXPONENT)
        });
        let Some(twice) = twice else {
            let base = self.slot(base);
            let exponent = self.constant(exponent);
            let inverse = self.new_auxiliary();
            let out = self.new_slot();
            self.tape.ops.push(Op::Power {
                out,
                base,
                exponent,
                inverse,
            });
            return out;
        };
        let whole_part = (twice / 2.0).trunc();
        if whole_part > VISIBLE_POWER {
            let base = self.slot(base);
            let exponent = self.constant(exponent);
            self.tape.swings.push(Swing::Power { base, exponent });
        }
        let half = twice % 2.0 == 1.0;
        if half && whole_part == 0.0 {
            let radicand = self.slot(base);
            let inverse = self.new_auxiliary();
            let out = self.new_slot();
            self.tape.ops.push(Op::SquareRoot {
                out,
                radicand,
                inverse,
            });
            return out;
        }
        if half {
            let root = self.graph.sqrt(base);
            let integer = self.integer_power(base, whole_part as u32);
            return self.multiply(integer, root);
        }
        self.integer_power(base, whole_part as u32)
    }

    /// Squares and products only, so that a base may be zero or negative.
    fn integer_power(&mut self, base: Expr, exponent: u32) -> usize {
        if exponent == 1 {
            return self.slot(base);
        }
        let half = self.graph.number(f64::from(exponent / 2));
        let half = self.graph.power(base, half);
        let half = self.slot(half);
        let out = self.new_slot();
        self.tape.ops.push(Op::Square { out, base: half });
        if exponent % 2 == 1 {
            return self.multiply(out, base);
        }
        out
    }

    fn call(&mut self, function: Function, argument: Expr) -> usize {
        if matches!(function, Function::Sin | Function::Cos) {
            let (sine, cosine) = self.sine_cosine(argument);
            return if function == Function::Sin {
                sine
            } else {
                cosine
            };
        }
        if function == Function::Tan {
            return self.tangent(argument);
        }
        let expr = self.graph.call(function, argument);
        let slot = self.slot(argument);
        if function == Function::Ln {
            self.must_not_vanish(slot, Singularity::Logarithm);
        }
        let slope = self.slope(slot);
        let out = self.new_slot();
        // Registered before its weight is lowered: some weights are functions of the result itself.
        self.series.insert(expr, out);
        let position = self.tape.ops.len();
        let (sign, weight) = self.weight(function, expr, argument);
        let integral = Op::Integral {
            out,
            slope,
            argument: slot,
            weight,
            sign,
            function,
        };
        // A weight of the same order is needed only from the next order on, while its own operations may need this one.
        self.tape.ops.insert(position, integral);
        out
    }

    /// The derivative of a function, as sign and series.
    fn weight(&mut self, function: Function, value: Expr, argument: Expr) -> (Sign, usize) {
        if matches!(function, Function::Asin | Function::Acos) {
            let inside = self.graph.complement_of_square(argument);
            let inside = self.slot(inside);
            self.must_not_vanish(inside, Singularity::InverseSine);
        }
        let (sign, slope) = self.graph.signed_slope(function, argument, value);
        (sign, self.slot(slope))
    }

    fn must_not_vanish(&mut self, slot: usize, kind: Singularity) {
        self.tape.singular.push(Singular {
            slot,
            kind,
            exponent: None,
            expr: None,
        });
    }

    /// As a quotient, so that its pole is the zero of a series.
    fn tangent(&mut self, argument: Expr) -> usize {
        let (sine, cosine) = self.sine_cosine(argument);
        self.must_not_vanish(cosine, Singularity::Tangent);
        let inverse = self.new_auxiliary();
        let out = self.new_slot();
        self.tape.ops.push(Op::Divide {
            out,
            numerator: Operand::Series(sine),
            denominator: cosine,
            inverse,
        });
        out
    }

    fn sine_cosine(&mut self, argument: Expr) -> (usize, usize) {
        if let Some(&pair) = self.sine_cosines.get(&argument) {
            return pair;
        }
        let slot = self.slot(argument);
        let slope = self.slope(slot);
        let sine = self.new_slot();
        let cosine = self.new_slot();
        self.tape.ops.push(Op::SineCosine {
            sine,
            cosine,
            slope,
            argument: slot,
        });
        self.sine_cosines.insert(argument, (sine, cosine));
        (sine, cosine)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Expansion;
    use super::*;

    /// Handles are given out by age, and factors are put in the order of their handles: what a tape adds to the graph must
    /// not depend on the order of a map. Of each pair of sine and cosine it adds the one that nobody has asked for.
    #[test]
    fn the_graph_grows_in_the_same_order_each_time() {
        let mut graph = Graph::default();
        let rates: Vec<Expr> = (0..40).map(|k| graph.parameter(k)).collect();
        let x = graph.state(0);
        let arguments: Vec<Expr> = rates.iter().map(|&rate| graph.mul(rate, x)).collect();
        let sines: Vec<Expr> = (arguments.iter())
            .map(|&argument| graph.call(Function::Sin, argument))
            .collect();
        let field = graph.sum(&sines);
        let _ = Tape::new(&mut graph, 1, &[field], &[]);
        let cosines: Vec<Expr> = (arguments.iter())
            .map(|&argument| graph.call(Function::Cos, argument))
            .collect();
        assert!(cosines.is_sorted());
    }

    /// With half the exponent the number leaves the power, 0.4^500 y^500, and no operation is left that reads 0.4 y.
    #[test]
    fn what_swings_stays_a_series_though_it_is_a_derivative() {
        const LONGEST: f64 = 4.0;
        let resolved = |as_output: bool| {
            let mut graph = Graph::default();
            let (x, y) = (graph.state(0), graph.state(1));
            let (factor, exponent) = (graph.number(0.4), graph.number(1000.0));
            let rate = graph.mul(factor, y);
            let power = graph.power(rate, exponent);
            let field = [rate, graph.neg(x)];
            let outputs = if as_output {
                vec![power, rate]
            } else {
                vec![power]
            };
            let tape = Tape::new(&mut graph, 2, &field, &outputs);
            let constants = tape.constants::<f64>(&graph, &[]);
            let mut expansion = Expansion::<f64>::new(&[&tape]);
            expansion.run(&tape, &constants, &[0.3, 2.4], &[0.0, 0.0], 0.5, 20);
            expansion.resolved(&tape, &constants, LONGEST)
        };
        assert!(resolved(true) < LONGEST);
        assert_eq!(resolved(false), resolved(true));
    }
}
