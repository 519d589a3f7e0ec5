//! What an event does to the state, and to columns of derivatives.

use super::variation::Direction;
use crate::expressions::{Expr, Graph, Tape};
use crate::model::Section;

/// The tapes of one event.
#[derive(Clone, Debug)]
pub(crate) struct ResetTapes {
    /// The state after it; columns by the derivative of the map alone, without the shift of its time.
    pub after: Tape,
    /// The rate of its surface, then the surface's derivative along each column.
    pub crossing: Tape,
    /// The surface, its rate and its acceleration.
    pub surface: Tape,
}

impl ResetTapes {
    pub(crate) fn new(
        graph: &mut Graph,
        section: &Section,
        field: &[Expr],
        directions: &[Direction],
        coordinates: usize,
    ) -> Option<Self> {
        let map = section.reset.clone()?;
        let dimension = coordinates * (1 + directions.len());
        let mut after = map.clone();
        let mut crossing = vec![graph.lie_derivative(section.surface, field)];
        let acceleration = graph.lie_derivative(crossing[0], field);
        let surface = [section.surface, crossing[0], acceleration];
        for direction in directions {
            after.extend(direction.along(graph, coordinates, &map));
            crossing.extend(direction.along(graph, coordinates, &[section.surface]));
        }
        Some(Self {
            after: Tape::new(graph, dimension, &[], &after),
            crossing: Tape::new(graph, dimension, &[], &crossing),
            surface: Tape::new(graph, dimension, &[], &surface),
        })
    }
}
