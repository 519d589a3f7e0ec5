//! Constants that change with the pieces of lookups: at a knot these are computed anew, and no others.

use crate::expressions::{Expr, Graph, Symbol, Tape};
use crate::numerics::Real;

/// Where such constants stand in some tapes, and their expressions.
#[derive(Clone, Debug, Default)]
pub(crate) struct LookedUp {
    /// Of each: the tape, and its place there.
    places: Vec<(usize, usize)>,
    exprs: Vec<Expr>,
    /// All that they are made of.
    parts: Vec<Expr>,
}

impl LookedUp {
    /// Those that depend on a parameter from this number on.
    pub(crate) fn new<'a>(
        graph: &Graph,
        tapes: impl Iterator<Item = &'a Tape>,
        first_slot: usize,
    ) -> Self {
        let (mut places, mut exprs) = (Vec::new(), Vec::new());
        for (number, tape) in tapes.enumerate() {
            for (place, &expr) in tape.constant_exprs().iter().enumerate() {
                places.push((number, place));
                exprs.push(expr);
            }
        }
        let changes = graph.depend_on(
            &exprs,
            |symbol| matches!(symbol, Symbol::Parameter(p) if p >= first_slot),
        );
        let mut kept = changes.iter();
        places.retain(|_| kept.next() == Some(&true));
        let mut kept = changes.iter();
        exprs.retain(|_| kept.next() == Some(&true));
        let parts = graph.reachable(&exprs);
        Self {
            places,
            exprs,
            parts,
        }
    }

    /// Computes them anew; `constants` holds those of the same tapes in the same order.
    pub(crate) fn renew<'a, R: Real>(
        &self,
        graph: &Graph,
        parameters: &[R],
        constants: impl Iterator<Item = &'a mut Vec<R>>,
    ) {
        let values = graph.evaluate_parts(&self.parts, &self.exprs, (&[], parameters));
        let mut renewed = self.places.iter().zip(values).peekable();
        for (number, own) in constants.enumerate() {
            while let Some((&(_, place), value)) = renewed.next_if(|((tape, _), _)| *tape == number)
            {
                own[place] = value;
            }
        }
    }
}
