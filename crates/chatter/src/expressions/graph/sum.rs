//! Sums in canonical form.

use super::number::folded_product;
use super::weighted::Weighted;
use crate::expressions::{Expr, Graph, Node};
use crate::numerics::{DoubleDouble, Real};

impl Graph {
    /// The sum of any number of terms.
    ///
    /// Sums within are flattened, like terms merged (`2*x + 3*x` is `5*x`) at the place of the first; otherwise the
    /// terms keep their order, for it decides what cancels against what in rounding. `a - (b + c)` stays as it is,
    /// unless a term of the inner sum meets a like term outside. What cancels leaves `0*x` behind, if x has no value
    /// everywhere.
    pub fn sum(&mut self, terms: &[Expr]) -> Expr {
        let one = self.number(1.0);
        let mut pending = terms.to_vec();
        loop {
            let mut collected = Weighted::default();
            for &term in &pending {
                if let Node::Sum(inner) = self.node(term).clone() {
                    for &inner_term in inner.iter() {
                        let (coefficient, rest) = self.split_coefficient(inner_term, one);
                        collected.add(rest, coefficient);
                    }
                } else {
                    let (coefficient, rest) = self.split_coefficient(term, one);
                    collected.add(rest, coefficient);
                }
            }
            let mut rebuilt = Vec::with_capacity(collected.entries.len());
            let mut again = false;
            for &(rest, coefficient) in &collected.entries {
                if coefficient.high() == 0.0 && self.can_vanish(rest) {
                    continue;
                }
                if self.meets_like_terms(rest, coefficient, one, &collected) {
                    again = true;
                    self.distribute(coefficient, rest, &mut rebuilt);
                    continue;
                }
                let term = self.scaled(coefficient, rest);
                again |= matches!(self.node(term), Node::Sum(_));
                rebuilt.push(term);
            }
            if again {
                pending = rebuilt;
                continue;
            }
            return match rebuilt[..] {
                [] => self.number(0.0),
                [only] => only,
                _ => self.intern(Node::Sum(rebuilt.into())),
            };
        }
    }

    /// `coefficient * rest` with a numeric coefficient; of a number, the rest is `one`.
    pub(in crate::expressions) fn split_coefficient(
        &mut self,
        term: Expr,
        one: Expr,
    ) -> (DoubleDouble, Expr) {
        match self.node(term) {
            Node::Number(number) => (number.value(), one),
            Node::Product(factors) => match (self.as_number(factors[0]), &factors[1..]) {
                (Some(number), [rest]) => (number, *rest),
                (Some(number), rest) => {
                    let rest = Node::Product(rest.into());
                    (number, self.intern(rest))
                }
                _ => (DoubleDouble::ONE, term),
            },
            _ => (DoubleDouble::ONE, term),
        }
    }

    pub(in crate::expressions) fn scaled(&mut self, coefficient: DoubleDouble, rest: Expr) -> Expr {
        if coefficient == DoubleDouble::ONE {
            return rest;
        }
        let number = self.number_exact(coefficient);
        self.product(&[number, rest])
    }

    pub(in crate::expressions) fn distribute(
        &mut self,
        coefficient: DoubleDouble,
        sum: Expr,
        out: &mut Vec<Expr>,
    ) {
        if let Node::Sum(terms) = self.node(sum).clone() {
            for &term in terms.iter() {
                out.push(self.scaled(coefficient, term));
            }
        }
    }

    /// Whether `coefficient * rest` is a multiplied-out sum in disguise: minus a sum that shares a term with
    /// `collected`, or any multiple of a sum with a term that cancels there.
    fn meets_like_terms(
        &mut self,
        rest: Expr,
        coefficient: DoubleDouble,
        one: Expr,
        collected: &Weighted,
    ) -> bool {
        let Node::Sum(terms) = self.node(rest).clone() else {
            return false;
        };
        terms.iter().any(|&term| {
            let (inner, key) = self.split_coefficient(term, one);
            let Some(outer) = collected.weight(key) else {
                return false;
            };
            coefficient == -DoubleDouble::ONE
                || folded_product(coefficient, inner).is_some_and(|product| product == -outer)
        })
    }

    pub(in crate::expressions) fn has_mostly_negative_terms(&self, sum: Expr) -> bool {
        let Node::Sum(terms) = self.node(sum) else {
            return false;
        };
        let negative = terms.iter().filter(|&&term| self.is_negative(term)).count();
        2 * negative >= terms.len()
    }

    /// Whether a term is written with a minus sign.
    fn is_negative(&self, term: Expr) -> bool {
        match self.node(term) {
            Node::Number(number) => number.value().high() < 0.0,
            Node::Product(factors) => self
                .as_number(factors[0])
                .is_some_and(|number| number.high() < 0.0),
            _ => false,
        }
    }
}
