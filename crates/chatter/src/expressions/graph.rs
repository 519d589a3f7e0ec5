//! The expression graph: every distinct subexpression is held once.

pub(super) mod condition;
mod derivative;
pub(super) mod disc;
pub(super) mod domain;
pub(super) mod eval;
mod multiple;
pub(super) mod number;
mod operand;
pub(super) mod piecewise;
mod product;
mod sizes;
mod substitute;
mod sum;
mod weighted;

use self::domain::{Domain, Folding};
use self::piecewise::{CurveId, Edge};
use super::Number;
use super::curve::Curve;
use crate::numerics::DoubleDouble;
use rustc_hash::{FxHashMap, FxHashSet};
use std::sync::Arc;

/// Handle of an expression in the [`Graph`] that made it. Equal handles are equal expressions.
///
/// Operands are made before what uses them, so they always have the smaller [`index`](Self::index).
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub struct Expr(u32);

impl Expr {
    /// Place of the node in its graph, from 0.
    pub const fn index(self) -> usize {
        self.0 as usize
    }
}

/// What an expression may depend on, by position. Time is a state of the model, appended by the model floor.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub enum Symbol {
    /// A state, counted from 0.
    State(usize),
    /// A parameter, counted from 0.
    Parameter(usize),
}

/// An elementary function of one argument. The square root is the power 0.5.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Function {
    /// Exponential.
    Exp,
    /// Natural logarithm.
    Ln,
    /// Sine of an angle in radians.
    Sin,
    /// Cosine of an angle in radians.
    Cos,
    /// Tangent of an angle in radians.
    Tan,
    /// Inverse sine, in [-pi/2, pi/2].
    Asin,
    /// Inverse cosine, in [0, pi].
    Acos,
    /// Inverse tangent, in (-pi/2, pi/2).
    Atan,
    /// Hyperbolic sine.
    Sinh,
    /// Hyperbolic cosine.
    Cosh,
    /// Hyperbolic tangent.
    Tanh,
}

impl Function {
    /// All of them.
    pub const ALL: [Self; 11] = [
        Self::Exp,
        Self::Ln,
        Self::Sin,
        Self::Cos,
        Self::Tan,
        Self::Asin,
        Self::Acos,
        Self::Atan,
        Self::Sinh,
        Self::Cosh,
        Self::Tanh,
    ];
}

/// One operation and its operands.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub enum Node {
    /// A constant.
    Number(Number),
    /// The circle constant, kept by name so that every number type has all its digits.
    Pi,
    /// A state or a parameter.
    Symbol(Symbol),
    /// Two terms or more, in the order they were written; none is itself a sum.
    Sum(Arc<[Expr]>),
    /// Two factors or more, numbers first; none is itself a product.
    Product(Arc<[Expr]>),
    /// Base and exponent. An integer exponent takes any base, another needs a base that is not negative.
    Power(Expr, Expr),
    /// A function and its argument.
    Call(Function, Expr),
    /// A choice by the sign of a surface.
    Switch {
        /// The function that vanishes where the choice changes.
        surface: Expr,
        /// The value where it is positive.
        above: Expr,
        /// The value where it is negative.
        below: Expr,
        /// The value where it is zero.
        edge: Edge,
    },
    /// The largest whole number that does not exceed an expression.
    Floor(Expr),
    /// A curve at an argument, or so high a derivative of it.
    Curve(CurveId, Expr, u8),
}

/// A graph of so many nodes is looked through as a whole: in a larger one of many small formulas that would take time
/// with the square of their number.
const SMALL: usize = 4096;

/// A set of expressions that share their common subexpressions.
///
/// The constructors simplify as they build (rules in [`sum`](Self::sum), [`product`](Self::product),
/// [`power`](Self::power) and [`call`](Self::call)). One law holds for all of them: the simplified expression has a value
/// where the expression as written has one, the same, and nowhere else: `x/x` is not 1, and `sqrt(x)^2` is not `x`. Only
/// with [`Folding::Continued`] it may have a value in more places. The same calls in the same order build the same graph.
#[derive(Clone, Default, Debug)]
pub struct Graph {
    nodes: Vec<Node>,
    domains: Vec<Domain>,
    folding: Folding,
    known: FxHashMap<Node, Expr>,
    pub(super) curves: Vec<Arc<Curve>>,
    /// By their terms in order of their handles: the sums that have been surfaces.
    pub(super) surfaces: FxHashMap<Vec<Expr>, Expr>,
}

impl Graph {
    /// The operation behind a handle of this graph.
    pub fn node(&self, expr: Expr) -> &Node {
        &self.nodes[expr.index()]
    }

    /// What simplifications may do from here on to where expressions have a value; returns what they might before.
    pub fn set_folding(&mut self, folding: Folding) -> Folding {
        core::mem::replace(&mut self.folding, folding)
    }

    pub(super) fn folding(&self) -> Folding {
        self.folding
    }

    pub(super) fn domain(&self, expr: Expr) -> Domain {
        self.domains[expr.index()]
    }

    /// Whether an expression may be left out with a factor of zero, or an exponent: nothing is lost of where the rest has
    /// a value.
    pub(super) fn can_vanish(&self, expr: Expr) -> bool {
        self.folding == Folding::Continued || self.domain(expr).total
    }

    /// How many distinct expressions have been built.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Whether nothing has been built.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// The value of an expression that is a plain number.
    pub fn as_number(&self, expr: Expr) -> Option<DoubleDouble> {
        match self.node(expr) {
            Node::Number(number) => Some(number.value()),
            _ => None,
        }
    }

    /// A constant: exactly this double.
    pub fn number(&mut self, value: f64) -> Expr {
        self.number_exact(DoubleDouble::from(value))
    }

    /// A constant to double-double precision.
    pub fn number_exact(&mut self, value: DoubleDouble) -> Expr {
        self.intern(Node::Number(Number::new(value)))
    }

    /// The circle constant.
    pub fn pi(&mut self) -> Expr {
        self.intern(Node::Pi)
    }

    /// A state or a parameter.
    pub fn symbol(&mut self, symbol: Symbol) -> Expr {
        self.intern(Node::Symbol(symbol))
    }

    /// State number `index`, from 0.
    pub fn state(&mut self, index: usize) -> Expr {
        self.symbol(Symbol::State(index))
    }

    /// Parameter number `index`, from 0.
    pub fn parameter(&mut self, index: usize) -> Expr {
        self.symbol(Symbol::Parameter(index))
    }

    /// `a + b`.
    pub fn add(&mut self, a: Expr, b: Expr) -> Expr {
        self.sum(&[a, b])
    }

    /// `a - b`.
    pub fn sub(&mut self, a: Expr, b: Expr) -> Expr {
        let minus_b = self.neg(b);
        self.sum(&[a, minus_b])
    }

    /// `a * b`.
    pub fn mul(&mut self, a: Expr, b: Expr) -> Expr {
        self.product(&[a, b])
    }

    /// `-a`, the product of -1 and `a`.
    pub fn neg(&mut self, a: Expr) -> Expr {
        let minus_one = self.number(-1.0);
        self.product(&[minus_one, a])
    }

    /// The square root of `a`, its power 0.5.
    pub fn sqrt(&mut self, a: Expr) -> Expr {
        let half = self.number(0.5);
        self.power(a, half)
    }

    /// The one handle of `node`, which must already be in canonical form.
    pub(super) fn intern(&mut self, node: Node) -> Expr {
        if let Some(&known) = self.known.get(&node) {
            return known;
        }
        let index = u32::try_from(self.nodes.len()).expect("a graph of 2^32 nodes exceeds memory");
        let expr = Expr(index);
        self.domains.push(self.domain_of(&node));
        self.nodes.push(node.clone());
        self.known.insert(node, expr);
        expr
    }

    /// All expressions that `roots` are made of, themselves included, operands before what uses them.
    pub fn reachable(&self, roots: &[Expr]) -> Vec<Expr> {
        let size = roots.iter().map(|root| root.index() + 1).max();
        if size.is_some_and(|size| size > SMALL) {
            return self.walked(roots);
        }
        let mut used = vec![false; size.unwrap_or(0)];
        for root in roots {
            used[root.index()] = true;
        }
        // Operands were made before what uses them.
        for index in (0..used.len()).rev() {
            if used[index] {
                self.for_each_operand(Expr(index as u32), |operand| used[operand.index()] = true);
            }
        }
        (0..used.len())
            .filter(|&index| used[index])
            .map(|index| Expr(index as u32))
            .collect()
    }

    /// The same in time that grows with what is reached, not with the graph.
    fn walked(&self, roots: &[Expr]) -> Vec<Expr> {
        let mut pending = roots.to_vec();
        let mut used: FxHashSet<Expr> = roots.iter().copied().collect();
        while let Some(expr) = pending.pop() {
            self.for_each_operand(expr, |operand| {
                if used.insert(operand) {
                    pending.push(operand);
                }
            });
        }
        let mut order: Vec<Expr> = used.into_iter().collect();
        order.sort_unstable();
        order
    }

    /// Calls `visit` with each operand of `expr`, in order.
    pub fn for_each_operand(&self, expr: Expr, mut visit: impl FnMut(Expr)) {
        match self.node(expr) {
            Node::Number(_) | Node::Pi | Node::Symbol(_) => {}
            Node::Sum(operands) | Node::Product(operands) => {
                operands.iter().copied().for_each(visit);
            }
            Node::Power(base, exponent) => {
                visit(*base);
                visit(*exponent);
            }
            Node::Call(_, argument) | Node::Floor(argument) | Node::Curve(_, argument, _) => {
                visit(*argument);
            }
            Node::Switch {
                surface,
                above,
                below,
                ..
            } => {
                visit(*surface);
                visit(*above);
                visit(*below);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_expressions_share_a_handle() {
        let mut graph = Graph::default();
        let (x, y) = (graph.state(0), graph.state(1));
        let (xy, yx) = (graph.mul(x, y), graph.mul(y, x));
        assert_eq!(xy, yx);
        let difference = graph.sub(xy, yx);
        assert_eq!(graph.as_number(difference), Some(DoubleDouble::from(0.0)));
        let size = graph.len();
        assert_eq!(graph.mul(x, y), xy);
        assert_eq!(graph.len(), size);
    }

    #[test]
    fn both_ways_to_look_for_parts_find_the_same() {
        let mut graph = Graph::default();
        let (x, p) = (graph.state(0), graph.parameter(0));
        let mut roots = Vec::new();
        let mut last = x;
        for k in 1..40 {
            let number = graph.number(f64::from(k));
            let sine = graph.call(Function::Sin, last);
            let product = graph.product(&[number, p, sine]);
            last = graph.add(product, x);
            roots.push(product);
        }
        for some in roots.chunks(3) {
            assert_eq!(graph.walked(some), graph.reachable(some));
        }
    }

    #[test]
    fn operands_come_before_what_uses_them() {
        let mut graph = Graph::default();
        let (x, p) = (graph.state(0), graph.parameter(0));
        let root = graph.sqrt(x);
        let product = graph.mul(p, root);
        let sum = graph.sub(x, product);
        for expr in graph.reachable(&[sum]) {
            graph.for_each_operand(expr, |operand| assert!(operand < expr));
        }
        assert!(graph.reachable(&[sum]).contains(&root));
    }
}
