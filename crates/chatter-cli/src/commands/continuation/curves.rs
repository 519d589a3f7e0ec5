//! Curves of special points in two parameters.

use super::arguments::Seed;
use crate::failure::Failure;
use crate::terminal::Console;
use chatter::analysis::periodic::{Branch, Known, Spec, SpecialKind};
use chatter::expressions::nearest;
use chatter::model::Model;
use chatter_work::periodic::{Curve, Ready, find_curve, restore};

/// Curves, each of its kind of points.
pub type Curves = Vec<(SpecialKind, Branch)>;

/// Curves that were followed.
pub struct Followed {
    /// The curves.
    pub curves: Curves,
    /// The functions that are watched on them.
    pub monitors: Vec<String>,
}

/// The curves of special points, in both parameters.
pub fn follow(
    ready: &Ready,
    (seeds, other): (&[Seed], usize),
    console: &Console,
) -> Result<Followed, Failure> {
    let over = ready.wanted.over;
    let mut spec = ready.wanted.spec.clone();
    let mut curves = Vec::new();
    for seed in seeds {
        let mut model = ready.model.clone();
        let known = known_point((&mut model, &mut spec), seed)?;
        let wanted = Curve {
            spec: spec.clone(),
            free: [other, over.parameter],
            known,
            limits: over.limits,
        };
        curves.push(find_curve(&model, &wanted, console)?);
    }
    Ok(Followed {
        curves,
        monitors: spec.monitors,
    })
}

/// The parameter that is free beside the one of the sweep.
pub fn other_parameter(free: Option<&str>, model: &Model, swept: usize) -> Result<usize, Failure> {
    let names = free.unwrap_or_default();
    let wrong = || {
        Failure::input(format!(
            "--free {names}: expected two parameters, one of them that of --sweep, such as q,kappa"
        ))
    };
    let (one, two) = names.split_once(',').ok_or_else(wrong)?;
    let index = |name: &str| {
        model.parameter_index(name.trim()).ok_or_else(|| {
            let known = nearest(name.trim(), model.parameter_names());
            Failure::input(format!(
                "--free: the model has no parameter `{}`",
                name.trim()
            ))
            .did_you_mean(known)
        })
    };
    let (one, two) = (index(one)?, index(two)?);
    match (one == swept, two == swept) {
        (false, true) => Ok(one),
        (true, false) => Ok(two),
        _ => Err(wrong()),
    }
}

/// A special point that is followed in two parameters; the model is set to its values.
fn known_point((model, spec): (&mut Model, &mut Spec), seed: &Seed) -> Result<Known, Failure> {
    let restored = restore(model, &seed.path, seed.index)?;
    for (name, value) in &restored.parameters {
        model.set_parameter(name, &format!("{value:?}"))?;
    }
    let mut known = restored.known;
    if let Some(text) = restored.function {
        let place = spec.monitors.iter().position(|known| *known == text);
        known.monitor = Some(place.unwrap_or_else(|| {
            spec.monitors.push(text);
            spec.monitors.len() - 1
        }));
    }
    Ok(known)
}
