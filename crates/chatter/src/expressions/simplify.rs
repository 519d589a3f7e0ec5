//! Constructors that bring sums, products, powers and calls into canonical form.

use super::graph::{Expr, Function, Graph, Node, Symbol};
use super::number::{Number, folded_power, folded_product, folded_quotient, folded_sum};
use crate::numerics::{DoubleDouble, Real};
use std::collections::HashMap;

/// Operands with a numeric weight each: terms with their coefficients, or bases with their exponents.
#[derive(Default)]
struct Weighted {
    entries: Vec<(Expr, DoubleDouble)>,
    place: HashMap<Expr, usize>,
}

impl Weighted {
    /// Adds the weight to that of the equal operand if there is one, at the place of its first occurrence.
    fn add(&mut self, operand: Expr, weight: DoubleDouble) {
        if let Some(&place) = self.place.get(&operand)
            && let Some(sum) = folded_sum(self.entries[place].1, weight)
        {
            self.entries[place].1 = sum;
            return;
        }
        self.place.insert(operand, self.entries.len());
        self.entries.push((operand, weight));
    }

    fn weight(&self, operand: Expr) -> Option<DoubleDouble> {
        self.place.get(&operand).map(|&place| self.entries[place].1)
    }
}

impl Graph {
    /// The sum of any number of terms.
    ///
    /// Sums within are flattened, like terms merged (`2*x + 3*x` is `5*x`) at the place of the first; otherwise the
    /// terms keep their order, for it decides what cancels against what in rounding. `a - (b + c)` stays as it is,
    /// unless a term of the inner sum meets a like term outside.
    pub fn sum(&mut self, terms: &[Expr]) -> Expr {
        let one = self.number(1.0);
        let mut pending = terms.to_vec();
        loop {
            let mut collected = Weighted::default();
            for &term in &pending {
                if let Node::Sum(inner) = self.node(term).clone() {
                    for inner_term in inner {
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
                if coefficient.high() == 0.0 {
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
                _ => self.intern(Node::Sum(rebuilt)),
            };
        }
    }

    /// The product of any number of factors.
    ///
    /// Products within are flattened, numbers folded into one that comes first, equal bases with numeric exponents
    /// merged (`x * x^2` is `x^3`, `x * x^-1` is 1), the other factors put in a fixed order: pi, parameters, states,
    /// the rest by age. Zero times anything is zero. A number is not multiplied into a sum, except -1 into one that
    /// then has fewer minus signs.
    pub fn product(&mut self, factors: &[Expr]) -> Expr {
        let mut pending = factors.to_vec();
        loop {
            let mut numbers: Vec<DoubleDouble> = Vec::new();
            let mut collected = Weighted::default();
            for &factor in &pending {
                if let Node::Product(inner) = self.node(factor) {
                    for &inner_factor in inner {
                        self.collect_factor(inner_factor, &mut numbers, &mut collected);
                    }
                } else {
                    self.collect_factor(factor, &mut numbers, &mut collected);
                }
            }
            if numbers.iter().any(|number| number.high() == 0.0) {
                return self.number(0.0);
            }
            let mut rebuilt = Vec::with_capacity(collected.entries.len());
            let mut again = false;
            for &(base, exponent) in &collected.entries {
                let exponent_expr = self.number_exact(exponent);
                if self.meets_like_bases(base, exponent, &collected) {
                    again = true;
                    if let Node::Product(inner) = self.node(base).clone() {
                        for factor in inner {
                            rebuilt.push(self.power(factor, exponent_expr));
                        }
                    }
                    continue;
                }
                let factor = self.power(base, exponent_expr);
                again |= matches!(self.node(factor), Node::Number(_) | Node::Product(_));
                rebuilt.push(factor);
            }
            numbers.retain(|&number| number != DoubleDouble::ONE);
            if again {
                pending = numbers.iter().map(|&n| self.number_exact(n)).collect();
                pending.extend(rebuilt);
                continue;
            }
            if let (&[number], &[only]) = (&numbers[..], &rebuilt[..])
                && number == -DoubleDouble::ONE
                && self.has_mostly_negative_terms(only)
            {
                let mut negated = Vec::new();
                self.distribute(number, only, &mut negated);
                return self.sum(&negated);
            }
            rebuilt.sort_by_key(|&factor| self.factor_order(factor));
            let mut all: Vec<Expr> = numbers.iter().map(|&n| self.number_exact(n)).collect();
            all.append(&mut rebuilt);
            return match all[..] {
                [] => self.number(1.0),
                [only] => only,
                _ => self.intern(Node::Product(all)),
            };
        }
    }

    /// `a / b`: the product of `a` and `b^-1`, where numbers are divided at once (`6*x/3` is `2*x`).
    pub fn div(&mut self, a: Expr, b: Expr) -> Expr {
        let one = self.number(1.0);
        let (above, a_rest) = self.split_coefficient(a, one);
        let (below, b_rest) = self.split_coefficient(b, one);
        let minus_one = self.number(-1.0);
        if let Some(quotient) = folded_quotient(above, below) {
            let quotient = self.number_exact(quotient);
            let inverse = self.power(b_rest, minus_one);
            return self.product(&[quotient, a_rest, inverse]);
        }
        let inverse = self.power(b, minus_one);
        self.product(&[a, inverse])
    }

    /// `base ^ exponent`.
    ///
    /// Folded for the exponents 0 and 1, the base 1, integer powers of numbers and half-integer powers of perfect
    /// squares. `(x^a)^n` is `x^(a*n)` for an integer `n` only, since `sqrt(x^2)` is not `x`; a numeric factor leaves
    /// an integer power: `(2*x)^3` is `8*x^3`. `0^0` is 1, as in IEEE 754.
    pub fn power(&mut self, base: Expr, exponent: Expr) -> Expr {
        let plain = Node::Power(base, exponent);
        if self.as_number(base) == Some(DoubleDouble::ONE) {
            return base;
        }
        let Some(weight) = self.as_number(exponent) else {
            return self.intern(plain);
        };
        if weight == DoubleDouble::ZERO {
            return self.number(1.0);
        }
        if weight == DoubleDouble::ONE {
            return base;
        }
        if let Some(number) = self.as_number(base) {
            return match folded_power(number, weight) {
                Some(value) => self.number_exact(value),
                None => self.intern(plain),
            };
        }
        if Number::new(weight).as_integer().is_none() {
            return self.intern(plain);
        }
        match self.node(base) {
            &Node::Power(inner, inner_exponent) => {
                let merged = self
                    .as_number(inner_exponent)
                    .and_then(|inner_weight| folded_product(inner_weight, weight));
                let Some(merged) = merged else {
                    return self.intern(plain);
                };
                let merged = self.number_exact(merged);
                self.power(inner, merged)
            }
            Node::Product(_) => {
                let one = self.number(1.0);
                let (coefficient, rest) = self.split_coefficient(base, one);
                match folded_power(coefficient, weight) {
                    Some(outside) if rest != base => {
                        let outside = self.number_exact(outside);
                        let inside = self.power(rest, exponent);
                        self.product(&[outside, inside])
                    }
                    _ => self.intern(plain),
                }
            }
            _ => self.intern(plain),
        }
    }

    /// A function of an expression.
    ///
    /// Folded where the value is exact: at 0, at 1, and at pi. The minus sign of the argument moves out of an odd
    /// function and disappears in an even one.
    pub fn call(&mut self, function: Function, argument: Expr) -> Expr {
        if let Some(value) = self.exact_value(function, argument) {
            return self.number(value);
        }
        let one = self.number(1.0);
        let (coefficient, rest) = self.split_coefficient(argument, one);
        let negative = coefficient.high() < 0.0;
        match function.parity() {
            Some(parity) if negative => {
                let positive = self.scaled(-coefficient, rest);
                let value = self.call(function, positive);
                match parity {
                    Parity::Odd => self.neg(value),
                    Parity::Even => value,
                }
            }
            _ => self.intern(Node::Call(function, argument)),
        }
    }

    fn exact_value(&self, function: Function, argument: Expr) -> Option<f64> {
        use Function::{Acos, Asin, Atan, Cos, Cosh, Exp, Ln, Sin, Sinh, Tan, Tanh};
        if *self.node(argument) == Node::Pi {
            return match function {
                Sin | Tan => Some(0.0),
                Cos => Some(-1.0),
                _ => None,
            };
        }
        let value = self.as_number(argument)?;
        if value == DoubleDouble::ZERO {
            return match function {
                Sin | Tan | Asin | Atan | Sinh | Tanh => Some(0.0),
                Exp | Cos | Cosh => Some(1.0),
                Ln | Acos => None,
            };
        }
        (value == DoubleDouble::ONE && matches!(function, Ln | Acos)).then_some(0.0)
    }

    /// `coefficient * rest` with a numeric coefficient; of a number, the rest is `one`.
    fn split_coefficient(&mut self, term: Expr, one: Expr) -> (DoubleDouble, Expr) {
        match self.node(term) {
            Node::Number(number) => (number.value(), one),
            Node::Product(factors) => match (self.as_number(factors[0]), &factors[1..]) {
                (Some(number), [rest]) => (number, *rest),
                (Some(number), rest) => {
                    let rest = Node::Product(rest.to_vec());
                    (number, self.intern(rest))
                }
                _ => (DoubleDouble::ONE, term),
            },
            _ => (DoubleDouble::ONE, term),
        }
    }

    fn scaled(&mut self, coefficient: DoubleDouble, rest: Expr) -> Expr {
        if coefficient == DoubleDouble::ONE {
            return rest;
        }
        let number = self.number_exact(coefficient);
        self.product(&[number, rest])
    }

    fn distribute(&mut self, coefficient: DoubleDouble, sum: Expr, out: &mut Vec<Expr>) {
        if let Node::Sum(terms) = self.node(sum).clone() {
            for term in terms {
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
        terms.into_iter().any(|term| {
            let (inner, key) = self.split_coefficient(term, one);
            let Some(outer) = collected.weight(key) else {
                return false;
            };
            coefficient == -DoubleDouble::ONE
                || folded_product(coefficient, inner).is_some_and(|product| product == -outer)
        })
    }

    /// Whether `base ^ exponent` is an integer power of a product that shares a base with `collected`.
    fn meets_like_bases(&self, base: Expr, exponent: DoubleDouble, collected: &Weighted) -> bool {
        let Node::Product(factors) = self.node(base) else {
            return false;
        };
        Number::new(exponent).as_integer().is_some()
            && factors.iter().any(|&factor| {
                let key = self.split_exponent(factor).0;
                collected.weight(key).is_some()
            })
    }

    /// `base ^ exponent` with a numeric exponent.
    fn split_exponent(&self, factor: Expr) -> (Expr, DoubleDouble) {
        if let &Node::Power(base, exponent) = self.node(factor)
            && let Some(weight) = self.as_number(exponent)
        {
            return (base, weight);
        }
        (factor, DoubleDouble::ONE)
    }

    fn collect_factor(
        &self,
        factor: Expr,
        numbers: &mut Vec<DoubleDouble>,
        collected: &mut Weighted,
    ) {
        let Some(number) = self.as_number(factor) else {
            let (base, exponent) = self.split_exponent(factor);
            collected.add(base, exponent);
            return;
        };
        match numbers.last_mut() {
            Some(last) => match folded_product(*last, number) {
                Some(product) => *last = product,
                None => numbers.push(number),
            },
            None => numbers.push(number),
        }
    }

    fn has_mostly_negative_terms(&self, sum: Expr) -> bool {
        let Node::Sum(terms) = self.node(sum) else {
            return false;
        };
        let negative = terms.iter().filter(|&&term| self.is_negative(term)).count();
        2 * negative >= terms.len()
    }

    /// Whether a term is written with a minus sign.
    pub(super) fn is_negative(&self, term: Expr) -> bool {
        match self.node(term) {
            Node::Number(number) => number.value().high() < 0.0,
            Node::Product(factors) => self
                .as_number(factors[0])
                .is_some_and(|number| number.high() < 0.0),
            _ => false,
        }
    }

    /// Place of a factor in a product: numbers aside, from what never changes to what is dearest to compute.
    fn factor_order(&self, factor: Expr) -> (u8, usize, Expr) {
        let base = self.split_exponent(factor).0;
        match self.node(base) {
            Node::Number(_) => (0, 0, factor),
            Node::Pi => (1, 0, factor),
            Node::Symbol(Symbol::Parameter(index)) => (2, *index, factor),
            Node::Symbol(Symbol::State(index)) => (3, *index, factor),
            _ => (4, base.index(), factor),
        }
    }
}

enum Parity {
    Even,
    Odd,
}

impl Function {
    fn parity(self) -> Option<Parity> {
        match self {
            Self::Sin | Self::Tan | Self::Asin | Self::Atan | Self::Sinh | Self::Tanh => {
                Some(Parity::Odd)
            }
            Self::Cos | Self::Cosh => Some(Parity::Even),
            Self::Exp | Self::Ln | Self::Acos => None,
        }
    }
}
