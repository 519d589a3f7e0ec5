//! Whether two models are one, as far as motion goes: names of sections, comments, labels and drawings aside.

use chatter::expressions::{Expr, Names};
use chatter::model::Model;
use std::collections::HashMap;

/// What of one model is another in the other, in words: first of those, then of these.
pub(super) fn difference(there: &Model, here: &Model) -> Option<String> {
    let states = [there, here].map(|model| format!("`{}`", model.state_names().join("`, `")));
    if states[0] != states[1] {
        return Some(format!(
            "its states are {}, and here {}",
            states[0], states[1]
        ));
    }
    let (told, known) = (equations(there), equations(here));
    let other: HashMap<&str, &str> = (known.iter())
        .map(|(name, text)| (&**name, &**text))
        .collect();
    for (name, text) in &told {
        match other.get(&**name) {
            Some(own) if own == text => {}
            Some(own) => return Some(format!("there {name} is `{text}`, and here `{own}`")),
            None => return Some(format!("it has {name}, and here there is none")),
        }
    }
    let of_both = |(name, _): &&(String, String)| told.iter().any(|(known, _)| known == name);
    let more = known.iter().find(|equation| !of_both(equation));
    more.map(|(name, _)| format!("here is {name}, which it has not"))
}

/// All that moves the state, by what it is called.
fn equations(model: &Model) -> Vec<(String, String)> {
    let owned =
        |names: Vec<&str>| -> Vec<String> { names.into_iter().map(str::to_owned).collect() };
    let (states, parameters) = (owned(model.state_names()), owned(model.parameter_names()));
    let names = Names {
        states: &states,
        parameters: &parameters,
    };
    let text = |expr: Expr| model.graph.to_text(expr, names);
    let each = |exprs: &[Expr]| {
        let texts = exprs.iter().zip(&states);
        let texts = texts.map(|(&expr, state)| format!("{state}: {}", text(expr)));
        texts.collect::<Vec<_>>().join(", ")
    };
    let mut all: Vec<(String, String)> = (model.states.iter())
        .map(|state| {
            (
                format!("the rate of `{}`", state.name),
                text(state.derivative),
            )
        })
        .collect();
    for (number, contact) in model.contacts.iter().enumerate() {
        let of = |what: &str| format!("the {what} of contact {}", number + 1);
        all.push((of("gap"), text(contact.gap)));
        match &contact.reset {
            Some(reset) => all.push((of("reset"), each(reset))),
            None => {
                all.push((of("impulse"), each(&contact.impulse)));
                all.push((of("restitution"), text(contact.restitution)));
            }
        }
        if let Some(friction) = &contact.friction {
            all.push((of("friction"), text(friction.coefficient)));
            all.push((of("sliding"), text(friction.rate)));
            all.push((of("friction's impulse"), each(&friction.along)));
        }
    }
    let events = model.sections.iter().filter_map(|section| {
        let reset = section.reset.as_ref()?;
        Some((section, reset))
    });
    for (number, (section, reset)) in events.enumerate() {
        let of = |what: &str| format!("the {what} of event {}", number + 1);
        all.push((of("surface"), text(section.surface)));
        all.push((of("direction"), format!("{:?}", section.direction)));
        all.push((of("reset"), each(reset)));
    }
    if model.contacts.len() > 1 {
        let law = format!("{:?}", model.simultaneous);
        all.push(("what happens at one instant".to_owned(), law));
    }
    for name in model.graph.curve_names() {
        if let Some(id) = model.graph.curve_named(name) {
            let curve = model.graph.curve(id);
            let points = format!("{} through {:?}", curve.kind(), curve.knots());
            all.push((format!("the table `{name}`"), points));
        }
    }
    all
}
