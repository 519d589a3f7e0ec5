//! Periodic orbits, branches and exponents.

mod branches;
mod new_kinds;
mod orbits;
mod order_of_events;
mod plane;
mod reference;
mod resumed;

use chatter::analysis::periodic::{
    Beside, Branch, BranchSpec, Limits, Orbit, Spec, Special, SpecialKind, branches, settled,
};
use chatter::model::Model;
use std::ops::ControlFlow;

fn model(name: &str, set: &[(&str, &str)]) -> Model {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../models/");
    let text = std::fs::read_to_string(format!("{folder}{name}.toml")).unwrap();
    with(&text, set)
}

fn with(text: &str, set: &[(&str, &str)]) -> Model {
    let mut model = Model::from_toml(text, "model").unwrap();
    for (name, value) in set {
        model.set_parameter(name, value).unwrap();
    }
    model
}

fn orbit(model: &Model) -> Orbit {
    settled(model, &Spec::default(), &mut |_| ControlFlow::Continue(())).unwrap()
}

fn branch_spec(
    model: &Model,
    (name, range): (&str, (f64, f64)),
    (impacts, longest_step): (u64, f64),
    beside: Beside,
) -> BranchSpec {
    BranchSpec {
        parameter: model.parameter_index(name).unwrap(),
        limits: Limits {
            range,
            impacts,
            points: 5000,
            longest_step,
        },
        beside,
    }
}

fn over(
    model: &Model,
    name: &str,
    range: (f64, f64),
    (impacts, longest_step): (u64, f64),
) -> Vec<Branch> {
    let beside = Beside {
        doublings: 0,
        branch_points: 1,
    };
    let spec = branch_spec(model, (name, range), (impacts, longest_step), beside);
    branches(model, &Spec::default(), &spec, Vec::new(), &mut |_| {
        ControlFlow::Continue(())
    })
    .unwrap()
}

fn value(special: &Special) -> f64 {
    *special.point.parameters.last().unwrap()
}

/// The special point of a kind nearest to a value.
fn nearest(branches: &[Branch], kinds: &[SpecialKind], at: f64) -> Special {
    (branches.iter().flat_map(|branch| &branch.special))
        .filter(|special| kinds.contains(&special.kind))
        .min_by(|a, b| (value(a) - at).abs().total_cmp(&(value(b) - at).abs()))
        .unwrap_or_else(|| panic!("no {kinds:?}"))
        .clone()
}

const GRAZES: [SpecialKind; 2] = [SpecialKind::FlightGraze, SpecialKind::ImpactGraze];
