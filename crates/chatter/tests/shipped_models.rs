//! The models in `models/`: what they say is what the literature says.

use chatter::expressions::{Expr, Graph};
use chatter::model::{Mechanics, Model};
use std::path::Path;

fn shipped(name: &str) -> Model {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models");
    let text = std::fs::read_to_string(folder.join(name).with_extension("toml")).unwrap();
    Model::from_toml(&text, name).unwrap_or_else(|errors| panic!("{errors}"))
}

/// Reads a formula in the names of the model, in the graph of its mechanics.
fn by_hand(model: &Model, graph: &mut Graph, text: &str) -> Expr {
    let states = model.state_names();
    let parameters = model.parameter_names();
    let mut known = std::collections::HashMap::new();
    for (index, name) in states.iter().enumerate() {
        known.insert(*name, graph.state(index));
    }
    for (index, name) in parameters.iter().enumerate() {
        known.insert(*name, graph.parameter(index));
    }
    graph
        .parse(text, &|name| known.get(name).copied(), &[])
        .unwrap()
}

/// That `found` and the formula are one function: equal at generic points, to rounding.
fn assert_same(model: &Model, mechanics: &mut Mechanics, found: Expr, formula: &str) {
    let expected = by_hand(model, &mut mechanics.graph, formula);
    let generic = |k: usize| 0.5 + (0.618_033_988_75 * k as f64).fract();
    for point in 0..5 {
        let states: Vec<f64> = (0..model.states.len())
            .map(|k| generic(31 * point + k))
            .collect();
        let parameters: Vec<f64> = (0..model.parameters.len())
            .map(|k| generic(17 * point + k + 7))
            .collect();
        let value = |expr| mechanics.graph.evaluate::<f64>(expr, &states, &parameters);
        let (found, expected) = (value(found), value(expected));
        let difference = (found - expected).abs();
        assert!(
            difference <= 1e-13 * expected.abs().max(1.0),
            "{formula}: {found} is not {expected}"
        );
    }
}

#[test]
fn the_valve_has_the_mechanics_of_the_paper() {
    let model = shipped("pressure_relief_valve");
    let mut mechanics = Mechanics::new(&model).unwrap();
    let seat = mechanics.contacts[0].clone();
    assert_eq!(seat.rate, mechanics.graph.state(1));
    assert_same(
        &model,
        &mut mechanics,
        seat.acceleration,
        "-kappa*y2 - y1 - delta + y3",
    );
    let jerk = "-kappa*(-kappa*y2 - y1 - delta + y3) - y2 + beta*(q - y1*sqrt(y3))";
    assert_same(&model, &mut mechanics, seat.jerk, jerk);
    assert_eq!(
        mechanics
            .graph
            .as_number(seat.rate_per_impulse)
            .unwrap()
            .high(),
        1.0
    );
    let sticking = mechanics.sticking(&[0]).unwrap();
    assert_eq!(sticking.reactions, [seat.acceleration]);
    for (component, formula) in sticking
        .field
        .iter()
        .zip(["y2", "0", "beta*(q - y1*sqrt(y3))"])
    {
        assert_same(&model, &mut mechanics, *component, formula);
    }
    for (component, formula) in seat.after_impact.iter().zip(["y1", "-r*y2", "y3"]) {
        assert_same(&model, &mut mechanics, *component, formula);
    }
    assert_eq!(
        model.parameter_values::<f64>(&[]),
        [0.0203, 1.25, 10.0, 20.0, 0.8]
    );
    assert_eq!(model.initial_state::<f64>(&[]), [0.0, 0.0, 10.0]);
}
