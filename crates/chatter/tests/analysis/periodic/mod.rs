//! Periodic orbits, branches and exponents.

mod branches;
mod caused;
mod corners;
mod counters;
mod differences;
mod drift;
mod following;
mod held;
mod hopf;
mod instants;
mod new_kinds;
mod orbits;
mod phases;
mod plane;
mod plane_borders;
mod plane_closed;
mod plane_corners;
mod plane_listed;
mod plane_stays;
mod plane_turns;
mod plane_walls;
mod reference;
mod units;

use chatter::analysis::periodic::{
    Beside, Branch, BranchSpec, Limits, Orbit, PeriodicError, Record, Search, Spec, Special,
    SpecialKind, Told, all, branches, settled,
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

fn settles(model: &Model) -> Result<Orbit, PeriodicError> {
    settled(model, &Spec::default(), &mut |_| ControlFlow::Continue(()))
}

fn orbit(model: &Model) -> Orbit {
    settles(model).unwrap()
}

/// All orbits of up to so many periods from so many starts.
fn orbits_from(model: &Model, (periods, starts, seed): (usize, u64, u64)) -> Vec<Orbit> {
    let what = Search {
        periods,
        starts,
        seed,
    };
    all(model, &Spec::default(), &what, &mut |_| {
        ControlFlow::Continue(())
    })
    .unwrap()
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
            other: None,
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

/// Records as a journal holds them.
fn read(records: &[String]) -> Vec<Record> {
    { records.iter() }
        .map(|text| serde_json::from_str(text).unwrap())
        .collect()
}

/// Keeps the records that are told, and breaks off after so many orbits.
fn broken_off_after(
    most: usize,
    records: &mut Vec<String>,
) -> impl FnMut(Told<'_>) -> ControlFlow<()> {
    let mut orbits = 0;
    move |told| {
        match told {
            Told::Orbit(_) => orbits += 1,
            Told::Record(record) => records.push(serde_json::to_string(record).unwrap()),
            Told::Settling | Told::Elsewhere { .. } => {}
        }
        match orbits >= most {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    }
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

/// A mass that is held on a stop by a force that swings: for a < 1 it never opens.
const HELD: &str = r#"
[parameters]
a = 0.5
r = 0.4
c = 0.1
[flight]
x = "v"
v = "-1 - a*cos(t) - c*v - x"
[[contact]]
name = "stop"
gap = "x"
impulse = { v = 1 }
restitution = "r"
[section.strobe]
surface = "sin(t)"
direction = "rising"
[initial]
x = 0
v = 0
"#;

/// A pendulum that hangs beside a wall which swings: it touches the pendulum at rest at A = d.
const PENDULUM: &str = r#"
[parameters]
A = 0.03
d = 0.05
[definitions]
wall = "d + A*sin(5*t)"
[flight]
th = "om"
om = "-9.81/0.7*sin(th) - 0.1*om"
[[contact]]
name = "wall"
gap = "wall - 0.7*(sin(th)*cos(0.25) + (1 - cos(th))*sin(0.25))"
impulse = { om = "-cos(th - 0.25)" }
restitution = 0.55
[section.strobe]
surface = "sin(5*t)"
direction = "rising"
[initial]
th = -0.5
om = 0
"#;
