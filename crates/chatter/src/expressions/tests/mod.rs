//! Tests of the expression language as a whole.

mod errors;
mod formulas;
mod laws;
mod parsing;
mod plain;

use super::{Expr, Graph, ParseError};

/// States x, y, z and parameters kappa, beta, q as names.
pub(super) const STATES: [&str; 3] = ["x", "y", "z"];
pub(super) const PARAMETERS: [&str; 3] = ["kappa", "beta", "q"];

/// Reads `text` with those names known.
pub(super) fn read(graph: &mut Graph, text: &str) -> Result<Expr, ParseError> {
    let states = [0, 1, 2].map(|index| graph.state(index));
    let parameters = [0, 1, 2].map(|index| graph.parameter(index));
    let resolve = |name: &str| {
        let state = STATES.iter().position(|known| *known == name);
        let parameter = PARAMETERS.iter().position(|known| *known == name);
        state
            .map(|index| states[index])
            .or(parameter.map(|index| parameters[index]))
    };
    graph.parse(text, &resolve, &["x", "y", "z", "kappa", "beta", "q"])
}

fn names() -> (Vec<String>, Vec<String>) {
    (
        STATES.map(String::from).to_vec(),
        PARAMETERS.map(String::from).to_vec(),
    )
}
