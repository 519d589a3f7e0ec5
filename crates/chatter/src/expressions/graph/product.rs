//! Products, quotients and powers in canonical form.

use super::domain::Demands;
use super::number::{Number, folded_power, folded_product, folded_quotient};
use super::weighted::Weighted;
use crate::expressions::{Expr, Graph, Node, Symbol};
use crate::numerics::{DoubleDouble, Real};

impl Graph {
    /// The product of any number of factors.
    ///
    /// Products within are flattened, numbers folded into one that comes first, equal bases with numeric exponents
    /// merged (`x * x^2` is `x^3`, but `x * x^-1` stays), the other factors put in a fixed order: pi, parameters, states,
    /// the rest by age. Zero times what has a value everywhere is zero. A number is not multiplied into a sum, except -1
    /// into one that then has fewer minus signs.
    pub fn product(&mut self, factors: &[Expr]) -> Expr {
        let mut pending = factors.to_vec();
        loop {
            let mut numbers: Vec<DoubleDouble> = Vec::new();
            let mut collected = Factors::default();
            for &factor in &pending {
                if let Node::Product(inner) = self.node(factor) {
                    // The numbers of a product have been multiplied as far as they can be.
                    let none_yet = numbers.is_empty();
                    for &inner_factor in inner.iter() {
                        match self.as_number(inner_factor) {
                            Some(number) if none_yet => numbers.push(number),
                            _ => self.collect_factor(inner_factor, &mut numbers, &mut collected),
                        }
                    }
                } else {
                    self.collect_factor(factor, &mut numbers, &mut collected);
                }
            }
            numbers.sort_by(|a, b| a.high().total_cmp(&b.high()));
            let mut rebuilt = Vec::with_capacity(collected.weights.entries.len());
            let mut again = false;
            for (&(base, exponent), &asked) in
                collected.weights.entries.iter().zip(&collected.demands)
            {
                for exponent in self.exponents(base, exponent, asked).into_iter().flatten() {
                    let exponent_expr = self.number_exact(exponent);
                    if self.meets_like_bases(base, exponent, &collected.weights) {
                        again = true;
                        if let Node::Product(inner) = self.node(base).clone() {
                            for &factor in inner.iter() {
                                rebuilt.push(self.power(factor, exponent_expr));
                            }
                        }
                        continue;
                    }
                    let factor = self.power(base, exponent_expr);
                    again |= matches!(self.node(factor), Node::Number(_) | Node::Product(_))
                        || self.split_exponent(factor).0 != base;
                    rebuilt.push(factor);
                }
            }
            let vanishes = numbers.iter().any(|number| number.high() == 0.0);
            if vanishes && rebuilt.iter().all(|&factor| self.can_vanish(factor)) {
                return self.number(0.0);
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
                _ => self.intern(Node::Product(all.into())),
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
    /// squares. `(x^a)^n` is `x^(a*n)` for an integer `n` only, since `sqrt(x^2)` is not `x`, and where that has a value
    /// at the same points; a numeric factor leaves an integer power: `(2*x)^3` is `8*x^3`. `0^0` is 1, as in IEEE 754;
    /// of what has no value everywhere, 1 is left as `1 + 0*x`.
    pub fn power(&mut self, base: Expr, exponent: Expr) -> Expr {
        let plain = Node::Power(base, exponent);
        if self.as_number(base) == Some(DoubleDouble::ONE) {
            return self.one_where_defined(exponent);
        }
        let Some(weight) = self.as_number(exponent) else {
            return self.intern(plain);
        };
        if weight == DoubleDouble::ZERO {
            return self.one_where_defined(base);
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
        if let Some(inner) = self.size_of(base)
            && libm::fmod(weight.high(), 2.0) == 0.0
        {
            return self.power(inner, exponent);
        }
        match self.node(base) {
            &Node::Power(inner, inner_exponent) => {
                let merged = self
                    .as_number(inner_exponent)
                    .and_then(|inner_weight| folded_product(inner_weight, weight));
                let (Some(merged), Some(inner_weight)) = (merged, self.as_number(inner_exponent))
                else {
                    return self.intern(plain);
                };
                let outer = Demands {
                    not_zero: weight.high() < 0.0,
                    not_negative: false,
                };
                let asked = Demands::of(inner_weight).and(outer);
                let parts = self.exponents(inner, merged, asked);
                let factors: Vec<Expr> = (parts.into_iter().flatten())
                    .map(|exponent| {
                        let exponent = self.number_exact(exponent);
                        self.power(inner, exponent)
                    })
                    .collect();
                match factors[..] {
                    [only] => only,
                    _ => self.product(&factors),
                }
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

    /// What an expression is the size of.
    pub(super) fn size_of(&mut self, expr: Expr) -> Option<Expr> {
        let &Node::Switch {
            surface,
            above,
            below,
            ..
        } = self.node(expr)
        else {
            return None;
        };
        (surface == above && below == self.neg(surface)).then_some(surface)
    }

    fn one_where_defined(&mut self, expr: Expr) -> Expr {
        let one = self.number(1.0);
        if self.can_vanish(expr) {
            return one;
        }
        let zero = self.number(0.0);
        let nothing = self.product(&[zero, expr]);
        self.sum(&[one, nothing])
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
    pub(super) fn split_exponent(&self, factor: Expr) -> (Expr, DoubleDouble) {
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
        collected: &mut Factors,
    ) {
        match self.as_number(factor) {
            Some(number) => fold_in(numbers, number),
            None => {
                let (base, exponent) = self.split_exponent(factor);
                collected.add(base, exponent);
            }
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

/// Bases with their exponents, and what all powers of each ask of it.
#[derive(Default)]
struct Factors {
    weights: Weighted,
    demands: Vec<Demands>,
}

impl Factors {
    fn add(&mut self, base: Expr, exponent: DoubleDouble) {
        let place = self.weights.add(base, exponent);
        self.demands
            .resize(self.weights.entries.len(), Demands::default());
        self.demands[place] = self.demands[place].and(Demands::of(exponent));
    }
}

/// Multiplies a number into others as far as products stay in range. No two of those that are left can be multiplied: in
/// whatever order and however often numbers are collected, they stay as they are.
fn fold_in(numbers: &mut Vec<DoubleDouble>, mut number: DoubleDouble) {
    let nothing = number.high() == 0.0 || numbers.iter().any(|other| other.high() == 0.0);
    if nothing {
        *numbers = vec![DoubleDouble::ZERO];
        return;
    }
    let mut place = 0;
    while place < numbers.len() {
        match folded_product(numbers[place], number) {
            Some(product) => {
                numbers.remove(place);
                number = product;
                place = 0;
            }
            None => place += 1,
        }
    }
    numbers.push(number);
}
