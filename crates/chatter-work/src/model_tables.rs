//! The tables of a model, as they are told.

use crate::numbers::{Digits, full};
use chatter::expressions::{Curve, Outside};
use chatter::model::Model;
use chatter::numerics::DoubleDouble;
use serde::Serialize;

/// A table in a document.
#[derive(Serialize)]
pub struct TableObject<'a> {
    name: &'a str,
    kind: &'static str,
    points: usize,
    from: f64,
    to: f64,
    /// None of a periodic one.
    outside: Option<&'static str>,
}

fn curves(model: &Model) -> impl Iterator<Item = &Curve> {
    let graph = &model.graph;
    let ids = graph
        .curve_names()
        .filter_map(|name| graph.curve_named(name));
    ids.map(|id| &**graph.curve(id))
}

/// All of them, for a document.
pub fn objects(model: &Model) -> Vec<TableObject<'_>> {
    let object = |curve| {
        let [from, to] = Curve::range(curve).map(DoubleDouble::high);
        TableObject {
            name: curve.name(),
            kind: curve.kind().name(),
            points: curve.knots().len(),
            from,
            to,
            outside: curve.outside().map(Outside::name),
        }
    };
    curves(model).map(object).collect()
}

/// The name of each, and a line about it.
pub fn lines(model: &Model) -> Vec<(String, String)> {
    let line = |curve: &Curve| {
        let [from, to] = curve.range().map(|end| full(end.high(), Digits::DOUBLE));
        let points = curve.knots().len();
        let beyond = match curve.outside() {
            Some(Outside::Error) => ", no value outside",
            Some(Outside::Hold) => ", held outside",
            None => "",
        };
        let text = format!("{}, {points} points, {from} to {to}{beyond}", curve.kind());
        (curve.name().to_owned(), text)
    };
    curves(model).map(line).collect()
}
