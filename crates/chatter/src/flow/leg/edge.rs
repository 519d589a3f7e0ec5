//! The surface and the map at the end of a leg, with derivatives.

use crate::expressions::{Expansion, Expr, Graph, Tape};
use crate::flow::variation::Direction as Along;
use crate::model::Model;
use crate::numerics::{Matrix, Real};

/// The surface and map at the end of a leg, on a state followed by columns.
#[derive(Clone, Debug)]
pub(crate) struct Edge {
    graph: Graph,
    pub(super) tape: Tape,
    coordinates: usize,
    pub(super) columns: usize,
}

/// What is known of a leg at its end, columns of derivatives included.
#[derive(Clone, Debug)]
pub(crate) struct Landing<R> {
    /// How long it took.
    pub duration: R,
    /// The value of the guard, its rate of change in time, and its derivative along each column; zeros where the leg has none.
    pub surface: R,
    pub surface_rate: R,
    pub surface_acceleration: R,
    pub surface_slopes: Vec<R>,
    /// The derivative of the guard's rate along each column.
    pub rate_slopes: Vec<R>,
    /// The state after the event, its rate of change with the duration, and its derivative along each column.
    pub image: Vec<R>,
    pub image_rate: Vec<R>,
    pub image_slopes: Matrix<R>,
}

impl Edge {
    pub(super) fn new(
        model: &Model,
        graph: &mut Graph,
        (field, surface, map): (&[Expr], Option<Expr>, &[Expr]),
        free: &[usize],
    ) -> Self {
        let coordinates = field.len();
        let columns = coordinates + free.len();
        let zero = graph.number(0.0);
        let surface = surface.unwrap_or(zero);
        let rate = graph.lie_derivative(surface, field);
        let acceleration = graph.lie_derivative(rate, field);
        let mut outputs = vec![surface, rate, acceleration];
        outputs.extend(map);
        for &image in map {
            outputs.push(graph.lie_derivative(image, field));
        }
        for index in 0..columns {
            let rates = match index.checked_sub(coordinates) {
                Some(place) => model.parameter_rates(graph, free[place]),
                None => Vec::new(),
            };
            let along = Along::new((index + 1) * coordinates, rates);
            outputs.extend(along.along(graph, coordinates, &[surface, rate]));
            outputs.extend(along.along(graph, coordinates, map));
        }
        let tape = Tape::new(graph, coordinates * (1 + columns), &[], &outputs);
        Self {
            graph: graph.clone(),
            tape,
            coordinates,
            columns,
        }
    }

    pub(super) fn landing<R: Real>(
        &self,
        (expansion, known): (&mut Expansion<R>, &mut Known<R>),
        parameters: &[R],
        duration: R,
        end: &[R],
    ) -> Landing<R> {
        let constants = known.constants(&self.tape, &self.graph, parameters);
        let n = self.coordinates;
        let mut values = vec![R::ZERO; self.tape.outputs.len()];
        let low = vec![R::ZERO; end.len()];
        expansion.evaluate_past_roots(&self.tape, constants, (end, &low), &mut values);
        let mut image_slopes = Matrix::zeros(n, self.columns);
        let mut surface_slopes = Vec::with_capacity(self.columns);
        let mut rate_slopes = Vec::with_capacity(self.columns);
        for (column, slopes) in values[3 + 2 * n..].chunks(2 + n).enumerate() {
            surface_slopes.push(slopes[0]);
            rate_slopes.push(slopes[1]);
            for (i, &slope) in slopes[2..].iter().enumerate() {
                image_slopes[(i, column)] = slope;
            }
        }
        Landing {
            duration,
            surface: values[0],
            surface_rate: values[1],
            surface_acceleration: values[2],
            surface_slopes,
            rate_slopes,
            image: values[3..3 + n].to_vec(),
            image_rate: values[3 + n..3 + 2 * n].to_vec(),
            image_slopes,
        }
    }
}

/// The constants of a tape at the parameters that it was evaluated at last.
#[derive(Clone, Debug)]
pub(super) struct Known<R> {
    parameters: Vec<R>,
    constants: Vec<R>,
}

impl<R: Real> Known<R> {
    pub(super) fn new() -> Self {
        Self {
            parameters: Vec::new(),
            constants: Vec::new(),
        }
    }

    pub(super) fn constants(&mut self, tape: &Tape, graph: &Graph, parameters: &[R]) -> &[R] {
        if self.parameters != parameters || self.constants.is_empty() {
            self.parameters = parameters.to_vec();
            self.constants = tape.constants(graph, parameters);
        }
        &self.constants
    }
}
