//! Collects like terms and equal bases.

use super::Expr;
use super::number::folded_sum;
use crate::numerics::DoubleDouble;
use rustc_hash::FxHashMap;

/// So many operands are found faster by looking at each of them.
const FEW: usize = 16;

/// Operands with a numeric weight each: terms with their coefficients, or bases with their exponents.
#[derive(Default)]
pub(in crate::expressions) struct Weighted {
    pub entries: Vec<(Expr, DoubleDouble)>,
    /// The last place of each operand; empty as long as there are few.
    place: FxHashMap<Expr, usize>,
}

impl Weighted {
    /// Adds the weight to that of the equal operand if there is one, at the place of its first occurrence. Returns the
    /// place.
    pub fn add(&mut self, operand: Expr, weight: DoubleDouble) -> usize {
        if let Some(place) = self.find(operand)
            && let Some(sum) = folded_sum(self.entries[place].1, weight)
        {
            self.entries[place].1 = sum;
            return place;
        }
        let place = self.entries.len();
        self.entries.push((operand, weight));
        if !self.place.is_empty() {
            self.place.insert(operand, place);
        } else if place == FEW {
            let places = self.entries.iter().enumerate();
            self.place = places
                .map(|(place, &(operand, _))| (operand, place))
                .collect();
        }
        place
    }

    fn find(&self, operand: Expr) -> Option<usize> {
        if self.place.is_empty() {
            self.entries
                .iter()
                .rposition(|&(known, _)| known == operand)
        } else {
            self.place.get(&operand).copied()
        }
    }

    /// The weight of an operand, if it has been added.
    pub fn weight(&self, operand: Expr) -> Option<DoubleDouble> {
        self.find(operand).map(|place| self.entries[place].1)
    }
}
