//! What expressions about points may name.

use crate::expressions::{Expr, Graph, ParseError};

/// What expressions about a map's points may name.
#[derive(Clone, Debug, Default)]
pub struct Scope {
    /// Holds the expressions. States are the coordinates of points.
    pub graph: Graph,
    /// Names and what they stand for; an earlier one hides a later one of the same name.
    pub names: Vec<(String, Expr)>,
}

impl Scope {
    /// Coordinates are states, parameters parameters, in order.
    pub fn new(coordinates: &[String], parameters: &[String]) -> Self {
        let mut scope = Self::default();
        for (index, name) in coordinates.iter().enumerate() {
            scope.names.push((name.clone(), scope.graph.state(index)));
        }
        for (index, name) in parameters.iter().enumerate() {
            let parameter = scope.graph.parameter(index);
            scope.names.push((name.clone(), parameter));
        }
        scope
    }

    /// Reads an expression.
    ///
    /// # Errors
    /// The first thing that is wrong with the text.
    pub fn parse(&mut self, text: &str) -> Result<Expr, ParseError> {
        let names = &self.names;
        let known: Vec<&str> = names.iter().map(|(name, _)| name.as_str()).collect();
        let resolve = |name: &str| {
            let found = names.iter().find(|(known, _)| known == name);
            found.map(|&(_, expr)| expr)
        };
        self.graph.parse(text, &resolve, &known)
    }
}
