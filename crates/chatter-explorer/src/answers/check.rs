//! What a model is: its states, parameters, contacts and sections, and what looks wrong.

use super::Answering;
use crate::question::ModelQuestion;
use chatter::model::{Label, Model, check};
use chatter_work::source::Loaded;
use chatter_work::{Refusal, shipped, simulation};
use serde::Deserialize;
use serde_json::{Value, json};

/// What is asked about a model alone.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CheckQuestion {
    model: ModelQuestion,
}

/// The model that the page begins with, and the shipped ones.
pub fn start(answering: &Answering) -> Result<(), Refusal> {
    let shipped: Vec<Value> = shipped::all()
        .map(|shipped| {
            let model = Model::from_toml(shipped.text, shipped.name);
            let title = model.ok().and_then(|model| model.title);
            json!({ "name": shipped.name, "title": title, "text": shipped.text })
        })
        .collect();
    let (name, text) = &answering.context.model;
    answering.document(&json!({
        "name": name,
        "text": text,
        "shipped": shipped,
        "version": env!("CARGO_PKG_VERSION"),
    }))
}

/// The model.
pub fn answer(answering: &Answering, question: &CheckQuestion) -> Result<(), Refusal> {
    let Loaded { model, .. } = question.model.load(&answering.context.files)?;
    model.check_defined()?;
    let parameters = model.parameter_values::<f64>(&[]);
    let initial = model.initial_state(&parameters);
    let checked = check(&model);
    let mut warnings: Vec<String> = checked.warnings.iter().map(ToString::to_string).collect();
    warnings.extend(simulation::why_none_begins(&model));
    let states: Vec<Value> = (model.states.iter().zip(&initial).enumerate())
        .map(|(index, (state, value))| {
            json!({
                "name": state.name,
                "value": value,
                "derivative": model.formula(state.written),
                "label": label(state.label.as_ref()),
                "time": model.time == Some(index),
                "depends": depends(&model, state.initial),
            })
        })
        .collect();
    let unused = |name: &str| {
        let known = |warning: &chatter::model::Warning| matches!(warning, chatter::model::Warning::UnusedParameter { name: unused } if unused == name);
        checked.warnings.iter().any(known)
    };
    let of_parameters: Vec<Value> = (model.parameters.iter().zip(&parameters))
        .map(|(parameter, value)| {
            json!({
                "name": parameter.name,
                "value": value,
                "label": label(parameter.label.as_ref()),
                "depends": depends(&model, parameter.value),
                "unused": unused(&parameter.name),
            })
        })
        .collect();
    let sections: Vec<Value> = (model
        .sections
        .iter()
        .filter(|section| section.reset.is_none()))
    .map(|section| {
        json!({
            "name": section.name,
            "surface": model.formula(section.surface),
            "direction": section.direction.name(),
        })
    })
    .collect();
    let contacts: Vec<&str> = model
        .contacts
        .iter()
        .map(|contact| &*contact.name)
        .collect();
    let phases: Vec<String> = {
        let mut graph = model.graph.clone();
        let phases = model.phases(&mut graph).into_iter();
        phases
            .map(|phase| model.states[phase.state].name.clone())
            .collect()
    };
    let shapes: Vec<Value> = (model.drawing.iter())
        .map(|shape| json!({ "kind": shape.kind.name() }))
        .collect();
    answering.document(&json!({
        "title": model.title,
        "source": model.source,
        "states": states,
        "parameters": of_parameters,
        "contacts": contacts,
        "sections": sections,
        "phases": phases,
        "drawing": { "shapes": shapes },
        "warnings": warnings,
    }))
}

/// Whether an initial value or a parameter is computed from others.
fn depends(model: &Model, value: chatter::expressions::Expr) -> bool {
    !model.graph.symbols(value).is_empty()
}

fn label(label: Option<&Label>) -> Value {
    match label {
        Some(label) => json!({ "text": label.text, "unit": label.unit }),
        None => Value::Null,
    }
}
