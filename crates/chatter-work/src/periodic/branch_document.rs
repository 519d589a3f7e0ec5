//! Branches of periodic orbits as one JSON document.

use super::Subject;
use super::arcs::arcs;
use super::orbit_document::{about, multipliers};
use crate::json::{Json, Object};
use chatter::analysis::periodic::{Branch, Point, Special, SpecialKind};

/// The document of branches.
pub fn document(subject: &Subject, branches: &[Branch]) -> Object {
    let all = branches.iter().map(|branch| one(subject, branch).into());
    with_branches(subject, all.collect())
}

/// The document of curves of special points.
pub fn curves_document(subject: &Subject, curves: &[(SpecialKind, Branch)]) -> Object {
    let all =
        (curves.iter()).map(|(kind, curve)| one(subject, curve).with("kind", kind.name()).into());
    with_branches(subject, all.collect())
}

fn with_branches(subject: &Subject, branches: Vec<Json>) -> Object {
    let fixed: Vec<usize> = (0..subject.model.parameters.len())
        .filter(|index| !subject.free.contains(index))
        .collect();
    let values = subject.model.parameter_values::<f64>(&[]);
    let names = subject.model.parameter_names();
    let fixed_names: Vec<&str> = fixed.iter().map(|&index| names[index]).collect();
    let fixed_values: Vec<f64> = fixed.iter().map(|&index| values[index]).collect();
    let free: Vec<Json> = subject.names().into_iter().map(Json::from).collect();
    Object::new(subject.digits)
        .with("branches", branches)
        .with("free", free)
        .with("model", about(subject))
        .named("parameters", &fixed_names, &fixed_values)
        .with("version", env!("CARGO_PKG_VERSION"))
}

fn impacts(point: &Point) -> Json {
    point
        .impacts
        .map_or(Json::Null, |count| Json::Integer(count as i64))
}

fn one(subject: &Subject, branch: &Branch) -> Object {
    let points = &branch.points;
    let column =
        |value: &dyn Fn(&Point) -> Json| -> Vec<Json> { points.iter().map(value).collect() };
    let mut columns = Object::new(subject.digits);
    for (place, name) in subject.names().into_iter().enumerate() {
        columns = columns.with(name, column(&|point| Json::Number(point.parameters[place])));
    }
    columns = columns
        .with("period", column(&|point| Json::Number(point.period)))
        .with("impacts", column(&impacts))
        .with("stable", column(&|point| Json::Bool(point.is_stable())))
        .with("neutral", column(&|point| Json::Bool(point.is_neutral())))
        .with(
            "multipliers",
            column(&|point| Json::List(multipliers(&point.multipliers))),
        );
    for (index, state) in subject.model.states.iter().enumerate() {
        columns = columns.with(
            &state.name,
            column(&|point| Json::Number(point.state[index])),
        );
    }
    for (index, text) in subject.watched() {
        columns = columns.with(text, column(&|point| Json::Number(point.monitors[index])));
    }
    columns = columns
        .with("residual", column(&|point| Json::Number(point.residual)))
        .with("error", column(&|point| Json::Number(point.correction)));
    let special: Vec<Json> = (branch.special.iter())
        .map(|special| special_object(subject, special))
        .collect();
    let arcs: Vec<Json> = (arcs(branch).iter())
        .map(|arc| {
            Object::new(subject.digits)
                .with(
                    "impacts",
                    arc.impacts.map_or(Json::Null, |n| Json::Integer(n as i64)),
                )
                .with("low", arc.range.0)
                .with("high", arc.range.1)
                .with("first", arc.points.0 as i64)
                .with("points", (arc.points.1 - arc.points.0) as i64)
                .with(
                    "special",
                    arc.special
                        .iter()
                        .map(|&k| Json::Integer(k as i64))
                        .collect::<Vec<Json>>(),
                )
                .into()
        })
        .collect();
    let ends: Vec<Json> = branch
        .ends
        .iter()
        .map(|end| Json::from(end.to_string()))
        .collect();
    Object::new(subject.digits)
        .with("points", columns)
        .with("special", special)
        .with("arcs", arcs)
        .with("ends", ends)
}

fn special_object(subject: &Subject, special: &Special) -> Json {
    let point = &special.point;
    let states: Vec<&str> = subject.model.state_names();
    let value = point.parameter();
    let monitor = special
        .monitor
        .and_then(|index| subject.monitors.get(index));
    let monitor = monitor.map_or(Json::Null, |text| Json::from(text.as_str()));
    Object::new(subject.digits)
        .with("kind", special.kind.name())
        .with("value", value)
        .named("at", &subject.names(), &point.parameters)
        .with("error", special.error)
        .with("residual", special.residual)
        .with("period", point.period)
        .with("impacts", impacts(point))
        .with("multipliers", multipliers(&point.multipliers))
        .named("state", &states, &point.state)
        .with("point", special.place as i64)
        .with("persists", special.persists.map_or(Json::Null, Json::Bool))
        .with("above", special.above.map_or(Json::Null, Json::Bool))
        .with("monitor", monitor)
        .into()
}
