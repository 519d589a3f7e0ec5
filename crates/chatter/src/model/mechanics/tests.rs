use super::*;
use crate::expressions::{Function, Symbol};
use crate::model::{Contact, Parameter, State};

/// A model of as many states and parameters as said, all at rest and zero, to be filled in.
fn blank(states: usize, parameters: usize) -> Model {
    let mut graph = Graph::default();
    let zero = graph.number(0.0);
    let state = |k| State {
        name: format!("x{k}"),
        derivative: zero,
        written: zero,
        initial: zero,
        label: None,
    };
    let parameter = |k| Parameter {
        name: format!("p{k}"),
        value: zero,
        label: None,
    };
    Model {
        title: None,
        source: None,
        graph,
        states: (0..states).map(state).collect(),
        time: None,
        parameters: (0..parameters).map(parameter).collect(),
        simultaneous: crate::model::Simultaneous::Binary,
        contacts: Vec::new(),
        sections: Vec::new(),
        definitions: Vec::new(),
        surfaces: Vec::new(),
        drawing: Vec::new(),
    }
}

fn contact(model: &mut Model, gap: Expr, impulse: &[f64], restitution: Expr) {
    let impulse = impulse.iter().map(|&w| model.graph.number(w)).collect();
    let name = format!("contact{}", model.contacts.len());
    model.contacts.push(Contact {
        name,
        gap,
        impulse,
        restitution,
        reset: None,
        friction: None,
    });
}

/// x'' = -x, v' = -w: two masses, each with a stop, coupled through `impulses`.
fn two_contacts(impulses: [[f64; 4]; 2]) -> Model {
    let mut model = blank(4, 2);
    for (position, velocity) in [(0, 1), (2, 3)] {
        model.states[position].derivative = model.graph.state(velocity);
        let x = model.graph.state(position);
        model.states[velocity].derivative = model.graph.neg(x);
        let r = model.graph.parameter(0);
        contact(&mut model, x, &impulses[position / 2], r);
    }
    model
}

#[test]
fn reactions_of_two_contacts_hold_both_rates() {
    let model = two_contacts([[0.0, 2.0, 0.0, 0.5], [0.0, 0.25, 0.0, 1.0]]);
    let mut mechanics = Mechanics::new(&model).unwrap();
    let sticking = mechanics.sticking(&[0, 1]).unwrap();
    for contact in mechanics.contacts.clone() {
        let left = mechanics
            .graph
            .lie_derivative(contact.rate, &sticking.field);
        assert!(is_identically_zero(&mechanics.graph, left, 4, 2),);
        let drift = mechanics.graph.lie_derivative(contact.gap, &sticking.field);
        assert_eq!(drift, contact.rate);
    }
    // B = [[1, 1/4], [1/4, 1]], a = (-x0, -x2): lambda by Cramer's rule.
    let states = [0.3, 0.0, -0.7, 0.0];
    let (a0, a1) = (-0.3, 0.7);
    let det: f64 = 1.0 - 1.0 / 16.0;
    let value = |expr| mechanics.graph.evaluate::<f64>(expr, &states, &[0.5, 0.0]);
    assert!((value(sticking.reactions[0]) - (a0 - 0.25 * a1) / det).abs() < 1e-15);
    assert!((value(sticking.reactions[1]) - (a1 - 0.25 * a0) / det).abs() < 1e-15);
}

/// y (0.7 + e) - y (0.6 + e) is 0.1 y, however large e = exp(400 x) is against that where x is about one, and y (0.7 + e) - 0.7 y - y e nothing.
#[test]
fn what_vanishes_is_told_from_what_is_small_beside_exponentials() {
    let mut graph = Graph::default();
    let (x, y) = (graph.state(0), graph.state(1));
    let large = graph.number(400.0);
    let large = graph.mul(large, x);
    let large = graph.call(Function::Exp, large);
    let [more, less] = [0.7, 0.6].map(|number| {
        let number = graph.number(number);
        let sum = graph.add(number, large);
        graph.mul(y, sum)
    });
    let small = graph.sub(more, less);
    assert!(!is_identically_zero(&graph, small, 2, 0));
    let (number, beside) = (graph.number(0.7), graph.mul(y, large));
    let number = graph.mul(number, y);
    let parts = graph.add(number, beside);
    let nothing = graph.sub(more, parts);
    assert!(is_identically_zero(&graph, nothing, 2, 0));
}

#[test]
fn contacts_that_do_not_touch_each_other_stick_each_by_itself() {
    let model = two_contacts([[0.0, 2.0, 0.0, 0.0], [0.0, 0.0, 0.0, 3.0]]);
    let mut mechanics = Mechanics::new(&model).unwrap();
    let both = mechanics.sticking(&[0, 1]).unwrap();
    let reversed = mechanics.sticking(&[1, 0]).unwrap();
    for k in 0..2 {
        assert_eq!(both.reactions[k], mechanics.contacts[k].acceleration);
        assert_eq!(both.reactions[k], reversed.reactions[1 - k]);
    }
    assert_eq!(both.field, reversed.field);
    let none = mechanics.sticking(&[]).unwrap();
    assert_eq!(none.field, mechanics.field);
}

#[test]
fn opposite_stops_cannot_be_closed_at_once() {
    let mut model = blank(2, 1);
    model.states[0].derivative = model.graph.state(1);
    let (x, sigma) = (model.graph.state(0), model.graph.parameter(0));
    let r = model.graph.number(0.5);
    let (upper, lower) = (model.graph.sub(sigma, x), model.graph.add(sigma, x));
    contact(&mut model, upper, &[0.0, -1.0], r);
    contact(&mut model, lower, &[0.0, 1.0], r);
    let mut mechanics = Mechanics::new(&model).unwrap();
    let error = mechanics.sticking(&[0, 1]).unwrap_err();
    let contacts = vec!["contact0".to_owned(), "contact1".to_owned()];
    assert_eq!(error, MechanicsError::DependentContacts { contacts });
    let error = mechanics.sticking(&[2]).unwrap_err();
    assert_eq!(error, MechanicsError::UnknownContact { index: 2, count: 2 });
}

#[test]
fn an_impulse_across_the_gap_is_refused() {
    // sin^2 + cos^2 - 1 is zero, which simplification need not see.
    let mut model = two_contacts([[0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]]);
    let x = model.graph.state(0);
    let two = model.graph.number(2.0);
    let (sin, cos) = (
        model.graph.call(Function::Sin, x),
        model.graph.call(Function::Cos, x),
    );
    let (sin, cos) = (model.graph.power(sin, two), model.graph.power(cos, two));
    let minus_one = model.graph.number(-1.0);
    model.contacts[1].impulse[3] = model.graph.sum(&[sin, cos, minus_one]);
    let error = Mechanics::new(&model).unwrap_err();
    let contact = "contact1".to_owned();
    assert_eq!(error, MechanicsError::ImpulseLeavesRate { contact });
}

#[test]
fn a_jump_changes_the_rate_by_one_and_an_impact_turns_it() {
    let model = two_contacts([[0.0, 2.0, 0.0, 0.5], [0.0, 0.25, 0.0, 1.0]]);
    let mut mechanics = Mechanics::new(&model).unwrap();
    let before = [0.0, -0.8, 0.0, 0.3];
    for contact in mechanics.contacts.clone() {
        let unit = mechanics.graph.lie_derivative(contact.rate, &contact.jump);
        assert_eq!(mechanics.graph.as_number(unit).unwrap().high(), 1.0);
        let value =
            |expr, states: &[f64]| mechanics.graph.evaluate::<f64>(expr, states, &[0.75, 0.0]);
        let after: Vec<f64> = contact
            .after_impact
            .iter()
            .map(|&x| value(x, &before))
            .collect();
        let turned = -0.75 * value(contact.rate, &before);
        assert!((value(contact.rate, &after) - turned).abs() < 1e-15);
        assert_eq!(value(contact.gap, &after), value(contact.gap, &before));
    }
}

#[test]
fn overridden_parameters_carry_those_defined_through_them() {
    let mut model = blank(1, 3);
    let two = model.graph.number(2.0);
    let middle = model.graph.parameter(1);
    model.parameters[0].value = model.graph.mul(two, middle);
    model.parameters[1].value = two;
    model.parameters[2].value = model.graph.symbol(Symbol::Parameter(0));
    model.states[0].initial = model.graph.parameter(2);
    assert_eq!(model.parameter_values::<f64>(&[]), [4.0, 2.0, 4.0]);
    let values = model.parameter_values(&[(1, 5.0)]);
    assert_eq!(values, [10.0, 5.0, 10.0]);
    assert_eq!(model.initial_state(&values), [10.0]);
    assert_eq!(model.parameter_values(&[(0, 7.0)]), [7.0, 2.0, 7.0]);
}
