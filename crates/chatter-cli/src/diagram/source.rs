//! Where the results of a diagram come from, in flat memory and as often as needed.

use crate::failure::Failure;
use chatter::analysis::diagram::Outcome;

/// What a row was classified as.
#[derive(Clone, Copy, Debug)]
pub struct Class {
    /// What its orbit settled to.
    pub outcome: Outcome,
    /// Its period; zero for none.
    pub period: u64,
    /// Mean number of impacts from sample to sample.
    pub impacts_per_return: f64,
    /// Largest Lyapunov exponent; NaN where it is not known.
    pub exponent: f64,
}

/// A finished diagram.
pub trait Source {
    /// Goes through all samples, in order: the row and the observed quantities of each.
    fn samples(&mut self, visit: &mut dyn FnMut(u64, &[f64])) -> Result<(), Failure>;

    /// Goes through all rows, in order.
    fn classes(&mut self, visit: &mut dyn FnMut(u64, &Class)) -> Result<(), Failure>;
}
