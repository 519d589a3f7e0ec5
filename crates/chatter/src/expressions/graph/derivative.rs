//! Derivatives of expressions by forward accumulation over the graph.
//!
//! Each distinct subexpression is differentiated once, so the derivative of a graph of n nodes has of the order of n
//! nodes, however large the formula would be if written out.

use crate::expressions::tape::Sign;
use crate::expressions::{Expr, Function, Graph, Node, Symbol};

impl Graph {
    /// The partial derivative of `expr` with respect to `symbol`.
    pub fn derivative(&mut self, expr: Expr, symbol: Symbol) -> Expr {
        let one = self.number(1.0);
        self.directional_derivatives(&[expr], &|other| (other == symbol).then_some(one))[0]
    }

    /// The derivative of `expr` along the vector field `field`: the sum over states of partial derivative times
    /// component, its rate of change where the states move along the field. A state past the end of `field` rests.
    pub fn lie_derivative(&mut self, expr: Expr, field: &[Expr]) -> Expr {
        self.directional_derivatives(&[expr], &|symbol| match symbol {
            Symbol::State(index) => field.get(index).copied(),
            Symbol::Parameter(_) => None,
        })[0]
    }

    /// The partial derivatives of `expr`, one for each of `symbols`.
    pub fn gradient(&mut self, expr: Expr, symbols: &[Symbol]) -> Vec<Expr> {
        symbols
            .iter()
            .map(|&symbol| self.derivative(expr, symbol))
            .collect()
    }

    /// The matrix of partial derivatives: a row for each of `exprs`, in it a column for each of `symbols`.
    pub fn jacobian(&mut self, exprs: &[Expr], symbols: &[Symbol]) -> Vec<Vec<Expr>> {
        let one = self.number(1.0);
        let mut rows = vec![Vec::with_capacity(symbols.len()); exprs.len()];
        for &symbol in symbols {
            let column =
                self.directional_derivatives(exprs, &|other| (other == symbol).then_some(one));
            for (row, entry) in rows.iter_mut().zip(column) {
                row.push(entry);
            }
        }
        rows
    }

    /// The derivative of each of `exprs` along a direction: `direction` gives the component of a symbol, `None` where
    /// that is zero.
    pub fn directional_derivatives(
        &mut self,
        exprs: &[Expr],
        direction: &dyn Fn(Symbol) -> Option<Expr>,
    ) -> Vec<Expr> {
        let zero = self.number(0.0);
        let order = self.reachable(exprs);
        let mut known = vec![zero; order.last().map_or(0, |last| last.index() + 1)];
        for expr in order {
            known[expr.index()] = match self.node(expr).clone() {
                Node::Number(_) | Node::Pi => zero,
                Node::Symbol(symbol) => direction(symbol).unwrap_or(zero),
                Node::Sum(terms) => {
                    let parts: Vec<Expr> = terms.iter().map(|term| known[term.index()]).collect();
                    self.sum(&parts)
                }
                Node::Product(factors) => self.product_rule(&factors, &known, zero),
                Node::Power(base, exponent) => {
                    let (base_rate, exponent_rate) = (known[base.index()], known[exponent.index()]);
                    self.power_rule(expr, (base, base_rate), (exponent, exponent_rate), zero)
                }
                Node::Switch {
                    surface,
                    above,
                    below,
                    edge,
                } => {
                    let (above, below) = (known[above.index()], known[below.index()]);
                    self.switch(surface, above, below, edge)
                }
                Node::Floor(_) => zero,
                Node::Curve(id, argument, derivative) => {
                    let rate = known[argument.index()];
                    if rate == zero {
                        zero
                    } else {
                        let slope = self.curve_at(id, argument, derivative + 1);
                        self.mul(slope, rate)
                    }
                }
                Node::Call(function, argument) => {
                    let rate = known[argument.index()];
                    if rate == zero {
                        zero
                    } else {
                        let slope = self.slope(function, argument, expr);
                        self.mul(slope, rate)
                    }
                }
            };
        }
        exprs.iter().map(|expr| known[expr.index()]).collect()
    }

    fn product_rule(&mut self, factors: &[Expr], known: &[Expr], zero: Expr) -> Expr {
        let mut parts = Vec::new();
        for (place, factor) in factors.iter().enumerate() {
            let rate = known[factor.index()];
            if rate != zero {
                let mut part = factors.to_vec();
                part[place] = rate;
                parts.push(self.product(&part));
            }
        }
        self.sum(&parts)
    }

    /// `(b^e)' = e b^(e-1) b' + b^e ln(b) e'`; a part whose rate is zero is left out, so that a constant exponent asks
    /// for no logarithm.
    fn power_rule(
        &mut self,
        power: Expr,
        (base, base_rate): (Expr, Expr),
        (exponent, exponent_rate): (Expr, Expr),
        zero: Expr,
    ) -> Expr {
        let mut parts = Vec::new();
        if base_rate != zero {
            let one = self.number(1.0);
            let lower = self.sub(exponent, one);
            let lower = self.power(base, lower);
            parts.push(self.product(&[exponent, lower, base_rate]));
        }
        if exponent_rate != zero {
            let logarithm = self.call(Function::Ln, base);
            parts.push(self.product(&[power, logarithm, exponent_rate]));
        }
        self.sum(&parts)
    }

    /// The derivative of a function at `argument`, where it takes the value `value`.
    fn slope(&mut self, function: Function, argument: Expr, value: Expr) -> Expr {
        match self.signed_slope(function, argument, value) {
            (Sign::Plus, slope) => slope,
            (Sign::Minus, slope) => self.neg(slope),
        }
    }

    /// The same as a sign and an expression without it.
    pub(in crate::expressions) fn signed_slope(
        &mut self,
        function: Function,
        argument: Expr,
        value: Expr,
    ) -> (Sign, Expr) {
        let one = self.number(1.0);
        let two = self.number(2.0);
        let slope = match function {
            Function::Exp => value,
            Function::Ln => self.div(one, argument),
            Function::Sin => self.call(Function::Cos, argument),
            Function::Cos => self.call(Function::Sin, argument),
            Function::Tan => {
                let square = self.power(value, two);
                self.add(one, square)
            }
            Function::Asin | Function::Acos => {
                let square = self.complement_of_square(argument);
                let root = self.sqrt(square);
                self.div(one, root)
            }
            Function::Atan => {
                let square = self.power(argument, two);
                let below = self.add(one, square);
                self.div(one, below)
            }
            Function::Sinh => self.call(Function::Cosh, argument),
            Function::Cosh => self.call(Function::Sinh, argument),
            Function::Tanh => {
                let square = self.power(value, two);
                self.sub(one, square)
            }
        };
        let sign = match function {
            Function::Cos | Function::Acos => Sign::Minus,
            _ => Sign::Plus,
        };
        (sign, slope)
    }

    /// 1 - x^2 as a product: exact near the ends of the domain of inverse sine and cosine, where it decides everything.
    pub(in crate::expressions) fn complement_of_square(&mut self, x: Expr) -> Expr {
        let one = self.number(1.0);
        let below = self.sub(one, x);
        let above = self.add(one, x);
        self.mul(below, above)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The valve of MATH.md, section 1: gap y1 along its field gives rate, acceleration, jerk.
    #[test]
    fn lie_derivatives_of_the_valve_gap() {
        let mut graph = Graph::default();
        let [y1, y2, y3] = [0, 1, 2].map(|index| graph.state(index));
        let [q, kappa, delta, beta] = [0, 1, 2, 3].map(|index| graph.parameter(index));
        let damping = graph.mul(kappa, y2);
        let damping = graph.neg(damping);
        let spring = graph.neg(y1);
        let preload = graph.neg(delta);
        let force = graph.sum(&[damping, spring, preload, y3]);
        let root = graph.sqrt(y3);
        let outflow = graph.mul(y1, root);
        let net = graph.sub(q, outflow);
        let filling = graph.mul(beta, net);
        let field = [y2, force, filling];

        let rate = graph.lie_derivative(y1, &field);
        let acceleration = graph.lie_derivative(rate, &field);
        let jerk = graph.lie_derivative(acceleration, &field);
        assert_eq!((rate, acceleration), (y2, force));
        let damped = graph.mul(kappa, force);
        let damped = graph.neg(damped);
        let minus_rate = graph.neg(y2);
        assert_eq!(jerk, graph.sum(&[damped, minus_rate, filling]));

        let states = [0, 1, 2].map(Symbol::State);
        let gradient = graph.gradient(rate, &states);
        let [zero, one] = [0.0, 1.0].map(|value| graph.number(value));
        assert_eq!(gradient, [zero, one, zero]);
        let sticking = graph.sub(force, acceleration);
        assert_eq!(sticking, zero);
    }

    #[test]
    fn a_deep_shared_graph_is_differentiated_once_a_node() {
        let mut graph = Graph::default();
        let x = graph.state(0);
        let mut expr = x;
        // Written out, this has 2^60 occurrences of x.
        for _ in 0..60 {
            let sine = graph.call(Function::Sin, expr);
            expr = graph.mul(sine, expr);
        }
        let before = graph.len();
        let derivative = graph.derivative(expr, Symbol::State(0));
        assert!(graph.len() < 20 * before, "{} from {before}", graph.len());
        assert!(graph.evaluate(derivative, &[0.3_f64], &[]).is_finite());
    }
}
