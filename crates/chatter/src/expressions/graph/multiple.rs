//! Roots of multiples: what vanishes with something else is written as that, or as nothing where that stays zero.

use crate::expressions::{Expr, Folding, Graph, Node};
use crate::numerics::Scalar;

impl Graph {
    /// Expressions in which powers of constant multiples of one of these bases are powers of the base times those of the multiple:
    /// `sqrt(2*g*h)` is `sqrt(2*g)*sqrt(h)` for the base `h`, as long as that is positive. Whole powers stay.
    pub(crate) fn with_powers_of(&mut self, exprs: &[Expr], bases: &[Expr]) -> Vec<Expr> {
        self.with_powers(exprs, bases, |graph, factor, (of, base), exponent| {
            if base == of {
                return None;
            }
            let (factor, power) = (graph.power(factor, exponent), graph.power(base, exponent));
            Some(graph.mul(factor, power))
        })
    }

    /// Expressions where these bases are zero and stay so: their powers, and those of their constant multiples, are nothing, as
    /// `sqrt(abs(u)/vs)` where u is held at zero. Evaluated, a root of what rounding leaves of u may have no value, and it has no
    /// derivative. Whole powers stay, and so do those with a negative number.
    pub(crate) fn without_powers_of(&mut self, exprs: &[Expr], bases: &[Expr]) -> Vec<Expr> {
        self.with_powers(exprs, bases, |graph, _, _, exponent| {
            let sinks = (graph.as_number(exponent)).is_none_or(|exponent| exponent.high() > 0.0);
            (sinks && !graph.depends_on_state(exponent)).then(|| graph.number(0.0))
        })
    }

    /// Expressions with what `new` makes of powers, but whole ones, of multiples of one of these bases: by the factor, what the power
    /// is of and the base, and the exponent.
    pub(super) fn with_powers(
        &mut self,
        exprs: &[Expr],
        bases: &[Expr],
        new: impl Fn(&mut Self, Expr, (Expr, Expr), Expr) -> Option<Expr>,
    ) -> Vec<Expr> {
        if bases.is_empty() {
            return exprs.to_vec();
        }
        let forms: Vec<(Expr, Vec<Term>)> = (bases.iter())
            .map(|&base| (base, self.terms_of(base)))
            .collect();
        let parts = self.reachable(exprs);
        let mut known = vec![self.number(0.0); parts.last().map_or(0, |last| last.index() + 1)];
        let mut changed = vec![false; known.len()];
        for old in parts {
            let mut has_changed = false;
            self.for_each_operand(old, |operand| has_changed |= changed[operand.index()]);
            let rebuilt = match has_changed {
                true => self.with_parts(old, &known),
                false => old,
            };
            let power = match *self.node(rebuilt) {
                Node::Power(base, exponent) => self.power_by((base, exponent), &forms, &new),
                _ => None,
            };
            known[old.index()] = power.unwrap_or(rebuilt);
            changed[old.index()] = known[old.index()] != old;
        }
        exprs.iter().map(|expr| known[expr.index()]).collect()
    }

    /// What becomes of the power of a multiple of one of these; none of anything else, or a whole one.
    fn power_by(
        &mut self,
        (of, exponent): (Expr, Expr),
        forms: &[(Expr, Vec<Term>)],
        new: &impl Fn(&mut Self, Expr, (Expr, Expr), Expr) -> Option<Expr>,
    ) -> Option<Expr> {
        if self.as_number(exponent).is_some_and(Scalar::is_whole) {
            return None;
        }
        let terms = self.terms_of(of);
        for (base, own) in forms {
            if let Some(factor) = self.factor_between(&terms, own)
                && let Some(power) = new(self, factor, (of, *base), exponent)
            {
                return Some(power);
            }
        }
        None
    }

    /// By which constant an expression is a multiple of another; none where it is not.
    pub(crate) fn factor_of(&mut self, expr: Expr, base: Expr) -> Option<Expr> {
        let (terms, of) = (self.terms_of(expr), self.terms_of(base));
        self.factor_between(&terms, &of)
    }

    /// By which constant terms are multiples of others.
    pub(super) fn factor_between(&mut self, terms: &[Term], of: &[Term]) -> Option<Expr> {
        let first = terms.first()?;
        if terms.len() != of.len() || first.moving.is_none() && terms.len() == 1 {
            return None;
        }
        let same = of.iter().position(|other| other.moving == first.moving)?;
        let first_of = &of[same];
        // Where a constant is zero both are.
        let folding = self.folding();
        self.set_folding(Folding::Continued);
        let mut is_multiple = true;
        for term in terms {
            let other = of.iter().find(|other| other.moving == term.moving);
            is_multiple &= other.is_some_and(|other| {
                let here = self.mul(term.constant, first_of.constant);
                here == self.mul(other.constant, first.constant)
            });
        }
        let factor = is_multiple.then(|| self.div(first.constant, first_of.constant));
        self.set_folding(folding);
        factor
    }

    /// The terms of a sum, constants multiplied into sums within.
    pub(super) fn terms_of(&mut self, expr: Expr) -> Vec<Term> {
        match self.node(expr).clone() {
            Node::Sum(terms) => terms.iter().flat_map(|&term| self.terms_of(term)).collect(),
            Node::Product(factors) => {
                let moves = self.depend_on_state(&factors);
                let (moving, constant): (Vec<_>, Vec<_>) =
                    (factors.iter().zip(moves)).partition(|&(_, moves)| moves);
                let [moving, constant] = [moving, constant]
                    .map(|part| part.into_iter().map(|(&f, _)| f).collect::<Vec<Expr>>());
                let constant = self.product(&constant);
                let mut inner = match moving[..] {
                    [sum] => self.terms_of(sum),
                    [] => vec![self.term(None)],
                    _ => {
                        let product = self.product(&moving);
                        vec![self.term(Some(product))]
                    }
                };
                for term in &mut inner {
                    term.constant = self.mul(constant, term.constant);
                }
                inner
            }
            _ if self.depends_on_state(expr) => vec![self.term(Some(expr))],
            _ => vec![Term {
                constant: expr,
                moving: None,
            }],
        }
    }

    fn term(&mut self, moving: Option<Expr>) -> Term {
        let constant = self.number(1.0);
        Term { constant, moving }
    }
}

/// A constant times what depends on the state, or alone.
pub(super) struct Term {
    pub(super) constant: Expr,
    moving: Option<Expr>,
}
