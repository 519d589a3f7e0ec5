//! What is asked about periodic orbits, checked against the model.

use crate::options::Quantity;
use crate::refusal::Refusal;
use chatter::expressions::nearest;
use chatter::model::{Model, Warning, check};

/// The section of a model that is meant.
///
/// # Errors
/// It has no such section.
pub fn section(model: &Model, name: Option<&str>) -> Result<Option<usize>, Refusal> {
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

/// Checks that a period is an expression in parameters.
///
/// # Errors
/// It is none.
pub fn check_period(model: &mut Model, period: Option<&str>) -> Result<(), Refusal> {
    if let Some(text) = period {
        Quantity(text.to_owned()).value(model, "--period")?;
    }
    Ok(())
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
