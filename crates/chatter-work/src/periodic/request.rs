//! What is asked about periodic orbits, checked against the model.

use crate::options::Quantity;
use crate::refusal::Refusal;
use chatter::analysis::periodic::Spec;
use chatter::expressions::nearest;
use chatter::model::{Model, ModelError, Warning, check};

/// The section of a model that is meant.
fn section_of(model: &Model, name: Option<&str>) -> Result<Option<usize>, Refusal> {
    let Some(name) = name else {
        return Ok(None);
    };
    let found = model
        .sections
        .iter()
        .position(|section| section.name == name);
    if found.is_none() {
        let names = model.sections.iter().map(|section| section.name.as_str());
        let known: Vec<&str> = names.collect();
        let refusal = Refusal::input(format!("the model has no section `{name}`"));
        return Err(match nearest(name, known.iter().copied()) {
            None if known.is_empty() => {
                refusal.help("it has none at all: add a [section.NAME] to it")
            }
            near => refusal.did_you_mean(near),
        });
    }
    Ok(found)
}

/// Which orbits of a model are meant.
///
/// # Errors
/// A formula of the model has no value, the period is no expression in parameters, there is no such section, or what is to
/// be watched is no expression.
pub fn specification(
    model: &mut Model,
    period: Option<&str>,
    (section, monitors): (Option<&str>, &[String]),
) -> Result<Spec, Refusal> {
    model.check_defined()?;
    let mut watched: Vec<String> = Vec::new();
    for text in monitors {
        if watched.contains(text) {
            continue;
        }
        watched.push(text.clone());
        let known: Vec<&str> = (model.state_names().into_iter())
            .chain(model.parameter_names())
            .collect();
        let known: Vec<String> = known.into_iter().map(str::to_owned).collect();
        let known: Vec<&str> = known.iter().map(String::as_str).collect();
        (model.parse_expression(text))
            .map_err(|error| ModelError::of_expression("--monitor", text, error, &known))?;
    }
    if let Some(text) = period {
        Quantity(text.to_owned()).value(model, "--period")?;
    }
    Ok(Spec {
        period: period.map(str::to_owned),
        section: section_of(model, section)?,
        monitors: watched,
        ..Spec::default()
    })
}

/// The parameter that a branch is followed in.
///
/// # Errors
/// The model has no such parameter, or no equation uses it.
pub fn free_parameter(model: &Model, name: &str) -> Result<usize, Refusal> {
    let Some(parameter) = model.parameter_index(name) else {
        if model.state_index(name).is_some() {
            return Err(Refusal::input(format!(
                "`{name}` is a state, not a parameter"
            )));
        }
        let known = nearest(name, model.parameter_names());
        return Err(
            Refusal::input(format!("the model has no parameter `{name}`")).did_you_mean(known),
        );
    };
    let is_unused = |warning: &Warning| matches!(warning, Warning::UnusedParameter { name: unused } if unused == name);
    if check(model).warnings.iter().any(is_unused) {
        return Err(Refusal::input(format!(
            "no equation uses parameter `{name}`: nothing changes with it"
        )));
    }
    Ok(parameter)
}
