//! What is a corner though it is not written as one: tables of steps that the motion may come to rest on, and roots of squares and of products.

use crate::expressions::{Curve, CurveId, CurveKind, Edge, Expr, Graph, Node, Outside};
use crate::model::Model;
use crate::numerics::{DoubleDouble, Real};

/// A table with more jumps is looked up as it is: each would be a surface, of which there are not so many.
const MOST_JUMPS: usize = 16;

impl Model {
    /// Writes roots of squares, and of products, as sizes.
    pub(in crate::model) fn take_sizes(&mut self) {
        let mut graph = core::mem::take(&mut self.graph);
        let mut written = Vec::new();
        self.for_each_expression(|expr| written.push(expr));
        let sizes = graph.with_sizes(&written.iter().map(|expr| **expr).collect::<Vec<Expr>>());
        for (expr, size) in written.into_iter().zip(sizes) {
            *expr = size;
        }
        self.graph = graph;
    }

    /// Writes tables of steps as sums of steps, where what is looked up acts on how its argument changes, at once or by its acceleration:
    /// friction by a table of speeds. Motion may be held at such a jump, which is a matter of surfaces; pieces that only follow each other
    /// are looked up.
    pub(super) fn part_jumps(&mut self) {
        let field = self.field();
        let mut graph = core::mem::take(&mut self.graph);
        let tables: Vec<(Expr, CurveId, Expr)> = (graph.reachable(&field).into_iter())
            .filter_map(|part| match *graph.node(part) {
                Node::Curve(id, argument, 0) if jumps(graph.curve(id)).is_some() => {
                    Some((part, id, argument))
                }
                _ => None,
            })
            .collect();
        let mut parted = Vec::new();
        for (part, id, argument) in tables {
            if acts_on(&mut graph, part, (argument, &field)) {
                let steps = in_steps(&mut graph, id, argument);
                parted.extend(steps.map(|steps| (part, steps)));
            }
        }
        if !parted.is_empty() {
            self.for_each_expression(|expr| {
                *expr = graph.with_replaced(*expr, &parted);
            });
        }
        self.graph = graph;
    }
}

/// Whether the rate of an argument, or its acceleration, depends on what is looked up by it.
fn acts_on(graph: &mut Graph, part: Expr, (argument, field): (Expr, &[Expr])) -> bool {
    let rate = graph.lie_derivative(argument, field);
    if graph.reachable(&[rate]).contains(&part) {
        return true;
    }
    let acceleration = graph.lie_derivative(rate, field);
    graph.reachable(&[acceleration]).contains(&part)
}

/// Where a curve jumps, and by how much; none where it does not, or too often.
fn jumps(curve: &Curve) -> Option<Vec<(DoubleDouble, DoubleDouble)>> {
    if curve.kind() != CurveKind::Steps {
        return None;
    }
    let holds = curve.outside() == Some(Outside::Hold);
    let count = curve.knots().len();
    let ends = &curve.knots()[1..if holds { count } else { count - 1 }];
    let value = |piece: i64| curve.piece(piece).map(|piece| piece.coefficients[0]);
    let jumps: Option<Vec<_>> = (ends.iter().zip(1..))
        .map(|(&knot, piece)| Some((knot, value(piece)? - value(piece - 1)?)))
        .collect();
    jumps.filter(|jumps| !jumps.is_empty() && jumps.len() <= MOST_JUMPS)
}

/// A table of steps as its first value, and what is added at each jump; where it ends it has no value still.
fn in_steps(graph: &mut Graph, id: CurveId, argument: Expr) -> Option<Expr> {
    let curve = graph.curve(id).clone();
    let first = curve.piece(0)?.coefficients[0];
    let mut terms = vec![graph.number_exact(first)];
    for (knot, jump) in jumps(&curve)? {
        let knot = graph.number_exact(knot);
        let surface = graph.sub(argument, knot);
        let (jump, zero) = (graph.number_exact(jump), graph.number(0.0));
        terms.push(graph.switch(surface, jump, zero, Edge::Above));
    }
    if curve.bounds().is_some() {
        let nothing = [DoubleDouble::ZERO; 2];
        let (name, outside) = (curve.name(), curve.outside());
        let ends = Curve::new(
            name,
            CurveKind::Linear,
            outside,
            &curve.range(),
            &nothing,
            None,
        );
        let ends = graph.add_curve(ends.ok()?);
        terms.push(graph.curve_at(ends, argument, 0));
    }
    Some(graph.sum(&terms))
}
