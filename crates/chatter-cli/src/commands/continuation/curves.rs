//! Curves of special points in two parameters.

use super::arguments::Seed;
use crate::failure::Failure;
use chatter::expressions::nearest;
use chatter::model::Model;
use chatter_work::periodic::{Asked, Plane, restore};

/// The curves of these points, over the parameter of the sweep and another. What was set into the model of their tables is taken over.
///
/// # Errors
/// The parameters are none of the model, or a file holds no such point of it.
pub fn plane(
    asked: &mut Asked<'_>,
    (seeds, free): (&[Seed], Option<&str>),
    swept: &str,
) -> Result<Option<Plane>, Failure> {
    if seeds.is_empty() {
        return Ok(None);
    }
    let other = other_parameter(free, asked.model, swept)?;
    let points: Result<Vec<_>, _> = (seeds.iter())
        .map(|seed| restore(asked, &seed.path, &seed.chosen))
        .collect();
    Ok(Some(Plane {
        other,
        range: None,
        points: points?.concat(),
    }))
}

/// The parameter that is free beside the one of the sweep.
fn other_parameter(free: Option<&str>, model: &Model, swept: &str) -> Result<String, Failure> {
    let names = free.unwrap_or_default();
    let wrong = || {
        Failure::input(format!(
            "--free {names}: expected two parameters, one of them that of --sweep, such as q,kappa"
        ))
    };
    let (one, two) = names.split_once(',').ok_or_else(wrong)?;
    for name in [one.trim(), two.trim()] {
        if model.parameter_index(name).is_none() {
            let known = nearest(name, model.parameter_names());
            let refusal = Failure::input(format!("--free: the model has no parameter `{name}`"));
            return Err(refusal.did_you_mean(known));
        }
    }
    match (one.trim() == swept, two.trim() == swept) {
        (false, true) => Ok(one.trim().to_owned()),
        (true, false) => Ok(two.trim().to_owned()),
        _ => Err(wrong()),
    }
}
