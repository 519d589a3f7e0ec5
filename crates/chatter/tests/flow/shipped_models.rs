//! The models in `models/`: what they say is what the literature says.

use chatter::analysis::diagram;
use chatter::analysis::return_map::{ReturnMap, ReturnSpec, Sampling};
use chatter::expressions::{Expr, Graph};
use chatter::flow::{Occurrence, Settings, System, Trajectory};
use chatter::model::{Direction, Label, Mechanics, Model, ModelBuilder, Warning, check};
use std::path::{Path, PathBuf};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models")
}

fn shipped(name: &str) -> Model {
    let text = std::fs::read_to_string(folder().join(name).with_extension("toml")).unwrap();
    Model::from_toml(&text, name).unwrap_or_else(|errors| panic!("{errors}"))
}

/// Every model in the folder, by name.
fn all() -> Vec<(String, Model)> {
    let mut names: Vec<String> = std::fs::read_dir(folder())
        .unwrap()
        .map(|entry| {
            entry
                .unwrap()
                .path()
                .file_stem()
                .unwrap()
                .to_string_lossy()
                .into_owned()
        })
        .collect();
    names.sort();
    assert!(names.len() >= 7, "{names:?}");
    names
        .into_iter()
        .map(|name| (name.clone(), shipped(&name)))
        .collect()
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

#[test]
fn every_model_is_complete_and_without_warning() {
    for (name, model) in all() {
        assert!(model.title.is_some() && model.source.is_some(), "{name}");
        assert!(!model.sections.is_empty(), "{name} has no section");
        let check = check(&model);
        assert_eq!(check.warnings, [], "{name}");
        assert_eq!(check.contacts.len(), model.contacts.len());
        assert!(
            model
                .states
                .iter()
                .all(|state| state.label.is_some() || state.name == "t"),
            "{name}"
        );
    }
}

/// What happens up to some time, counted.
#[derive(Default, Debug)]
struct Counts {
    impacts: usize,
    accumulations: usize,
    releases: usize,
    sections: usize,
}

fn simulate(model: &Model, until: f64) -> Counts {
    let parameters = model.parameter_values::<f64>(&[]);
    let initial = model.initial_state(&parameters);
    let system = System::new(model).unwrap();
    let mut work = system.workspace::<f64>(&Settings::default());
    let mut trajectory = Trajectory::start(&system, &mut work, &parameters, 0.0, &initial).unwrap();
    let mut counts = Counts::default();
    loop {
        match trajectory.advance(&system, &mut work, until).unwrap() {
            Some(Occurrence::Impact { .. }) => counts.impacts += 1,
            Some(Occurrence::Accumulation { .. }) => counts.accumulations += 1,
            Some(Occurrence::Release { .. }) => counts.releases += 1,
            Some(Occurrence::Section { .. }) => counts.sections += 1,
            Some(Occurrence::Horizon) => return counts,
            _ => {}
        }
    }
}

#[test]
fn the_parameters_shipped_show_chatter_and_release() {
    for (name, until) in [
        ("bouncing_ball_on_table", 2.0),
        ("impact_oscillator", 60.0),
        ("impact_oscillator_two_sided", 60.0),
        ("linear_impacting_system", 20.0),
        ("cam_follower", 2.0),
    ] {
        let counts = simulate(&shipped(name), until);
        assert!(
            counts.accumulations > 1 && counts.releases > 1,
            "{name}: {counts:?}"
        );
        assert!(counts.sections > 1, "{name}: {counts:?}");
    }
    // At q = 0.0203 the valve has 34 impacts a period and never comes to rest.
    let counts = simulate(&shipped("pressure_relief_valve"), 40.0);
    assert!(
        counts.impacts > 300 && counts.accumulations == 0,
        "{counts:?}"
    );
}

/// What the comment in its file says.
#[test]
fn the_oscillator_bounces_every_other_period_or_in_chaos() {
    let sampling = Sampling::Stroboscopic {
        period: "2*pi/omega".to_owned(),
    };
    let map = ReturnMap::new(&shipped("impact_oscillator"), &ReturnSpec::new(sampling)).unwrap();
    let bounds = |coordinate: &str, from, to| diagram::Bounds {
        coordinate: coordinate.to_owned(),
        from,
        to,
    };
    for (omega, outcome, period) in [
        (3.7, diagram::Outcome::Periodic, 2),
        (2.8, diagram::Outcome::Chaotic, 0),
    ] {
        let range = diagram::Range::linear("omega", omega, omega, 1);
        let spec = diagram::Spec {
            start: diagram::Start::Random {
                count: 4,
                seed: 7,
                bounds: vec![bounds("x", -2.0, 0.0), bounds("v", -2.0, 2.0)],
            },
            exponent: diagram::Exponent::Largest,
            ..diagram::Spec::new(range, "v", 5000, 1000)
        };
        for row in diagram::diagram(&map, &spec, &diagram::Threads::new(1)).unwrap() {
            assert_eq!((row.outcome, row.period), (outcome, period), "{omega}");
            assert_eq!(row.exponent > 0.0, period == 0, "{omega}: {}", row.exponent);
            if period > 0 {
                assert_eq!(row.impacts_per_return, 0.5);
            }
        }
    }
}

#[test]
fn a_stroboscopic_section_is_crossed_once_a_period() {
    let model = shipped("bouncing_ball_on_table");
    let mut unbounded = model.clone();
    unbounded
        .sections
        .retain(|section| section.name == "stroboscopic");
    // Ten periods a second, from phase zero on: the crossing at the start does not count.
    assert_eq!(simulate(&unbounded, 3.05).sections, 30);
}

#[test]
fn the_builder_makes_what_the_file_says() {
    let label = |text: &str| Label {
        text: Some(text.to_owned()),
        unit: None,
    };
    let file = shipped("pressure_relief_valve");
    let built = ModelBuilder::new()
        .title("Pressure relief valve")
        .source("Dankowicz & Fotsch 2017, eq. (1)")
        .parameter("q", 0.0203)
        .parameter("kappa", 1.25)
        .parameter("delta", 10)
        .parameter("beta", 20)
        .parameter("r", 0.8)
        .state("y1", "y2", 0)
        .state("y2", "-kappa*y2 - y1 - delta + y3", 0)
        .state("y3", "beta*(q - y1*sqrt(y3))", 10)
        .contact("seat", "y1", [("y2", 1)], "r")
        .section("closing", "y3 - 9.7", Direction::Falling)
        .label("y1", label("valve lift $y_1$"))
        .label("y2", label("plug velocity $y_2$"))
        .label("y3", label("inlet pressure $y_3$"))
        .label("q", label("flow rate $q$"))
        .build()
        .unwrap_or_else(|errors| panic!("{errors}"));
    // Handles are numbered as expressions are made, so equal models print equally but for the hash map of the graph.
    let nodes = |model: &Model| {
        let mut model = model.clone();
        let graph = std::mem::take(&mut model.graph);
        // The builder has none.
        model.drawing.clear();
        let roots: Vec<Expr> = model.field();
        let nodes: Vec<_> = graph
            .reachable(&roots)
            .into_iter()
            .map(|expr| graph.node(expr).clone())
            .collect();
        (format!("{model:?}"), nodes)
    };
    assert_eq!(nodes(&built), nodes(&file));
}

#[test]
fn time_is_a_state_where_the_equations_use_it() {
    let table = shipped("bouncing_ball_on_table");
    assert_eq!(table.state_names(), ["y", "v", "t"]);
    assert_eq!(table.time, Some(2));
    assert_eq!(
        table
            .graph
            .as_number(table.states[2].derivative)
            .unwrap()
            .high(),
        1.0
    );
    assert_eq!(
        table
            .graph
            .as_number(table.contacts[0].impulse[2])
            .unwrap()
            .high(),
        0.0
    );
    assert_eq!(shipped("pressure_relief_valve").time, None);
}

#[test]
fn warnings_name_what_looks_wrong() {
    let warnings = |model: ModelBuilder| {
        check(&model.build().unwrap_or_else(|errors| panic!("{errors}"))).warnings
    };
    let ball = || ModelBuilder::new().state("y", "v", 1).state("v", -1, 0);
    let floor = || "floor".to_owned();
    let swing = ModelBuilder::new().state("y", "v", 1).state("v", "-y", 0);
    assert_eq!(warnings(swing), [Warning::NoContact]);
    let sideways = ball()
        .contact("floor", "y", [("v", 1)], 0.5)
        .state("z", "v", 0);
    assert_eq!(
        warnings(sideways),
        [Warning::UnusedState {
            name: "z".to_owned()
        }]
    );
    assert_eq!(
        warnings(ball().contact("floor", "y", [("y", 1)], 0.5)),
        [Warning::ImpulseLeavesRate { contact: floor() }]
    );
    assert_eq!(
        warnings(ball().contact("floor", "y", [("v", 1.0), ("y", 0.25)], 0.5)),
        [Warning::ImpulseMovesGap {
            contact: floor(),
            change: "0.25".to_owned()
        }]
    );
    let curved = ModelBuilder::new()
        .state("y", "v + v^3", 1)
        .state("v", -1, 0);
    assert_eq!(
        warnings(curved.contact("floor", "y", [("v", 1)], 0.5)),
        [Warning::RateNotAffine { contact: floor() }]
    );
    assert_eq!(
        warnings(
            ball()
                .parameter("r", 1.5)
                .contact("floor", "y", [("v", 1)], "r")
        ),
        [Warning::Restitution {
            contact: floor(),
            value: 1.5
        }]
    );
    assert_eq!(
        warnings(ball().contact("floor", "y - 2", [("v", 1)], 0)),
        [Warning::NegativeGap {
            contact: floor(),
            gap: -1.0
        }]
    );
    let falling = ModelBuilder::new().state("y", "v", 0).state("v", -1, -3);
    assert_eq!(
        warnings(falling.contact("floor", "y", [("v", 1)], 0)),
        [Warning::StartsWithImpact {
            contact: floor(),
            rate: -3.0
        }]
    );
    let root = ModelBuilder::new()
        .state("y", "v", 1)
        .state("v", "1/(y - 1)", 0);
    let infinite = warnings(root.contact("floor", "y", [("v", 1)], 0));
    assert!(
        matches!(
            &infinite[..],
            [Warning::NotFinite { .. }, Warning::NotFinite { .. }]
        ),
        "{infinite:?}"
    );
    let idle = ball()
        .contact("floor", "y", [("v", 1)], 0)
        .parameter("mass", 2)
        .parameter("weight", "mass")
        .definition("energy", "v^2/2 + y")
        .section("never", "weight - 1", Direction::Either);
    assert_eq!(
        warnings(idle),
        [
            Warning::SectionWithoutState {
                section: "never".to_owned()
            },
            Warning::UnusedDefinition {
                name: "energy".to_owned()
            }
        ]
    );
    let unused = ball()
        .contact("floor", "y", [("v", 1)], 0)
        .parameter("mass", 2);
    assert_eq!(
        warnings(unused),
        [Warning::UnusedParameter {
            name: "mass".to_owned()
        }]
    );
}

#[test]
fn the_ball_comes_to_rest_and_stays() {
    // In contact the surface of the section `apex` vanishes identically, which is no crossing.
    let counts = simulate(&shipped("bouncing_ball"), 10.0);
    assert_eq!(counts.accumulations, 1, "{counts:?}");
    assert_eq!(counts.releases, 0, "{counts:?}");
}
