//! Collects like terms and equal bases.

use super::graph::Expr;
use super::number::folded_sum;
use crate::numerics::DoubleDouble;
use std::collections::HashMap;

/// Operands with a numeric weight each: terms with their coefficients, or bases with their exponents.
#[derive(Default)]
pub(super) struct Weighted {
    pub entries: Vec<(Expr, DoubleDouble)>,
    place: HashMap<Expr, usize>,
}

impl Weighted {
    /// Adds the weight to that of the equal operand if there is one, at the place of its first occurrence. Returns the
    /// place.
    pub fn add(&mut self, operand: Expr, weight: DoubleDouble) -> usize {
        if let Some(&place) = self.place.get(&operand)
            && let Some(sum) = folded_sum(self.entries[place].1, weight)
        {
            self.entries[place].1 = sum;
            return place;
        }
        let place = self.entries.len();
        self.place.insert(operand, place);
        self.entries.push((operand, weight));
        place
    }

    /// The weight of an operand, if it has been added.
    pub fn weight(&self, operand: Expr) -> Option<DoubleDouble> {
        self.place.get(&operand).map(|&place| self.entries[place].1)
    }
}
