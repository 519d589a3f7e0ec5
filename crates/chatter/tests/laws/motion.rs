//! What holds in every motion: no gap is ever negative, time rises, and the motion ends. Shipped models are followed from
//! any values of their parameters and any state; their equations are derived once, so that a run takes microseconds.

use chatter::flow::{Occurrence, Settings, System, Trajectory, Workspace};
use chatter::model::Model;

/// Share of the largest number of a state by which a gap may seem negative.
pub const ROUNDING: f64 = 1e-9;

/// Where a motion begins, and where it is left.
pub struct Run<'a> {
    pub system: &'a System,
    pub parameters: &'a [f64],
    pub start: &'a [f64],
    pub until: f64,
    pub impacts: u64,
    pub steps: u64,
}

/// Follows a motion; whether it came to its end, also by an error, before its steps were used up. `least` gives the least gap of
/// a state.
pub fn follow(
    run: &Run,
    work: &mut Workspace<f64>,
    least: impl Fn(&[f64]) -> f64,
    context: &impl Fn() -> String,
) -> bool {
    let Run {
        system, parameters, ..
    } = *run;
    let Ok(mut trajectory) = Trajectory::start(system, work, parameters, 0.0, run.start) else {
        return true;
    };
    let (mut steps, mut impacts, mut time, mut largest) = (0, 0, 0.0, 2.0_f64);
    let mut within = vec![0.0; run.start.len()];
    while let Ok(occurrence) = trajectory.advance(system, work, run.until) {
        steps += 1;
        if steps > run.steps {
            return false;
        }
        assert!(time <= trajectory.time(), "time falls {}", context());
        time = trajectory.time();
        let mut look = |state: &[f64]| {
            largest = state.iter().fold(largest, |most, y| most.max(y.abs()));
            let gap = least(state);
            assert!(
                gap.is_nan() || gap >= -ROUNDING * largest,
                "gap {gap} at {state:?} {}",
                context()
            );
        };
        let dense = work.dense();
        if dense.step() > 0.0 {
            for part in 0..=2_u8 {
                for (index, y) in within.iter_mut().enumerate() {
                    *y = dense.state(index, f64::from(part) / 2.0);
                }
                look(&within);
            }
        }
        look(trajectory.state());
        match occurrence {
            Some(Occurrence::Horizon) => break,
            Some(Occurrence::Impact { .. }) => impacts += 1,
            _ => {}
        }
        if impacts >= run.impacts {
            break;
        }
    }
    true
}

/// Models of every kind: smooth and piecewise, forced and not, with one contact and with many, tables, stiction.
const MODELS: &[(&str, &str)] = &[
    (
        "bouncing_ball_on_table",
        include_str!("../../../../models/bouncing_ball_on_table.toml"),
    ),
    (
        "cam_follower",
        include_str!("../../../../models/cam_follower.toml"),
    ),
    (
        "dwell_cam",
        include_str!("../../../../models/dwell_cam.toml"),
    ),
    (
        "gear_backlash",
        include_str!("../../../../models/gear_backlash.toml"),
    ),
    (
        "impact_oscillator_two_sided",
        include_str!("../../../../models/impact_oscillator_two_sided.toml"),
    ),
    (
        "newtons_cradle",
        include_str!("../../../../models/newtons_cradle.toml"),
    ),
    (
        "percussive_drill",
        include_str!("../../../../models/percussive_drill.toml"),
    ),
    (
        "pressure_relief_valve",
        include_str!("../../../../models/pressure_relief_valve.toml"),
    ),
    (
        "relay_feedback",
        include_str!("../../../../models/relay_feedback.toml"),
    ),
    (
        "rotor_in_clearance",
        include_str!("../../../../models/rotor_in_clearance.toml"),
    ),
    (
        "soft_stop",
        include_str!("../../../../models/soft_stop.toml"),
    ),
    (
        "vibro_impact_capsule",
        include_str!("../../../../models/vibro_impact_capsule.toml"),
    ),
];

/// Motions are left after so many steps: some thousand motions a second.
const STEPS: u64 = 12;

/// A model whose equations are derived.
pub struct Prepared {
    name: &'static str,
    model: Model,
    system: System,
    work: Workspace<f64>,
}

/// All models, derived.
pub fn prepared() -> Vec<Prepared> {
    let derived = MODELS.iter().map(|&(name, text)| {
        let model = Model::from_toml(text, name).unwrap();
        let system = System::new(&model).unwrap();
        let work = system.workspace(&Settings::default());
        Prepared {
            name,
            model,
            system,
            work,
        }
    });
    derived.collect()
}

/// Follows the model that the first byte names, with parameters from next to nothing to twice what the model says and a state
/// beside its initial one, from the bytes after it.
pub fn law(prepared: &mut [Prepared], bytes: &[u8]) {
    let Some((&which, bytes)) = bytes.split_first() else {
        return;
    };
    let count = prepared.len();
    let Prepared {
        name,
        model,
        system,
        work,
    } = &mut prepared[usize::from(which) % count];
    let mut bytes = bytes.iter().copied();
    let mut signed = || f64::from(bytes.next().unwrap_or(0) as i8) / 128.0;
    let told = model.parameter_values::<f64>(&[]);
    let free = (0..told.len()).filter(|&index| {
        model
            .graph
            .symbols(model.parameters[index].value)
            .is_empty()
    });
    let overrides: Vec<(usize, f64)> = free
        .map(|index| (index, told[index] * (1.0 + signed())))
        .collect();
    let values = model.parameter_values(&overrides);
    let mut start = model.initial_state(&values);
    for y in &mut start {
        *y += signed() * (1.0 + y.abs());
    }
    let gaps: Vec<_> = model.contacts.iter().map(|contact| contact.gap).collect();
    let least = |state: &[f64]| {
        let gaps = gaps
            .iter()
            .map(|&gap| model.graph.evaluate(gap, state, &values));
        gaps.fold(f64::INFINITY, f64::min)
    };
    let context = || format!("of {name} with {values:?} from {start:?}");
    let run = Run {
        system,
        parameters: &values,
        start: &start,
        until: 1e3,
        impacts: STEPS,
        steps: STEPS,
    };
    follow(&run, work, least, &context);
}
