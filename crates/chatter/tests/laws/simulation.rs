//! Short runs of a model made from any bytes: no gap is ever negative, time rises, and the runs end.

use super::motion::{ROUNDING, Run, follow};
use chatter::analysis::simulate::{Outcome, Sampling, Spec, simulate};
use chatter::flow::{Settings, System};
use chatter::model::Model;
use std::ops::ControlFlow;

/// How long runs last, how many impacts and how many steps they may have: far more than such models need.
const UNTIL: f64 = 5.0;
const IMPACTS: u64 = 300;
const STEPS: u64 = 200_000;

/// Further starts of each model: to derive its equations costs more than to run it.
pub const STARTS: u64 = 7;

/// Takes numbers from bytes; zeros once they are used up.
struct Numbers<'a>(core::slice::Iter<'a, u8>);

impl Numbers<'_> {
    fn byte(&mut self) -> u8 {
        self.0.next().copied().unwrap_or(0)
    }

    /// A multiple of 1/32 from -4 to 4.
    fn signed(&mut self) -> f64 {
        f64::from(self.byte() as i8) / 32.0
    }

    /// From 0 to 2.
    fn positive(&mut self) -> f64 {
        f64::from(self.byte()) / 128.0
    }

    fn restitution(&mut self) -> f64 {
        f64::from(self.byte()) / 266.0
    }
}

/// What bends or jumps: friction along the gap, stops, relays, square waves, tables.
const FORCES: &[&str] = &[
    "sign(v)",
    "abs(y - 1)",
    "max(v, 0)",
    "if(mod(t, 1) < 0.5, 1, 0)",
    "f(mod(t, 1))",
    "step(w)",
    "floor(2*y)",
    "sign(y - 0.5)",
];
const ACTUATOR: &[&str] = &["sign(w)", "step(y - 1)", "clamp(v, -1, 1)", "sign(w - v)"];

/// A mass above a floor, with forces that grow no faster than its state and that of an actuator, so that no rate is beyond
/// a few tens; a forcing, and perhaps a ceiling.
fn model(bytes: &[u8]) -> (String, bool) {
    let mut n = Numbers(bytes.iter());
    let has_ceiling = n.byte() & 1 == 1;
    let force: Vec<String> = ["1", "y", "v", "w", "w*tanh(y)", "sin(3*t)", "tanh(y)"]
        .iter()
        .map(|term| format!("{} * {term}", n.signed()))
        .collect();
    let actuator: Vec<String> = ["1", "w", "y", "v", "sqrt(1 + y^2)"]
        .iter()
        .map(|term| format!("{} * {term}", n.signed()))
        .collect();
    let (r, s) = (n.restitution(), n.restitution());
    let start = n.positive();
    let (v, w) = (n.signed(), n.signed());
    // Terms whose form changes, of force and actuator; those without a coefficient are left out.
    let mut jumps = |terms: &[&str]| -> String {
        let written = terms.iter().filter_map(|term| {
            let coefficient = n.signed();
            (coefficient != 0.0).then(|| format!(" + {coefficient} * {term}"))
        });
        written.collect()
    };
    let force = force.join(" + ") + &jumps(FORCES);
    let actuator = actuator.join(" + ") + &jumps(ACTUATOR);
    let mut text = format!(
        "[table.f]\nx = [0, 0.5, 1]\ny = [1, -1, 1]\noutside = \"hold\"\n[flight]\ny = \"v\"\nv = \"{}\"\nw = \"{}\"\n[[contact]]\nname = \"floor\"\ngap = \"y\"\nimpulse = {{ v = 1 }}\n\
         restitution = {r}\n",
        force, actuator
    );
    if has_ceiling {
        text += &format!(
            "[[contact]]\nname = \"ceiling\"\ngap = \"2 - y\"\nimpulse = {{ v = 1 }}\nrestitution = {s}\n"
        );
    }
    text += &format!(
        "[section.up]\nsurface = \"v\"\ndirection = \"rising\"\n[initial]\ny = {start}\nv = {v}\nw = {w}\n"
    );
    (text, has_ceiling)
}

/// SplitMix64: the bits of number k of a sequence.
pub fn chance(k: u64) -> u64 {
    let mut z = k.wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// Runs the model that the bytes stand for, from where they say and from other places.
pub fn law(bytes: &[u8]) {
    let (text, has_ceiling) = model(bytes);
    let model = Model::from_toml(&text, "any.toml").unwrap();
    from_its_own_start(&model, (&text, has_ceiling));
    from_elsewhere(&model, (&text, has_ceiling), bytes);
}

fn from_elsewhere(model: &Model, (text, has_ceiling): (&str, bool), bytes: &[u8]) {
    let Ok(system) = System::new(model) else {
        return;
    };
    let mut work = system.workspace::<f64>(&Settings::default());
    let parameters = model.parameter_values::<f64>(&[]);
    let first = (bytes.iter()).fold(0_u64, |seed, &byte| chance(seed ^ u64::from(byte)));
    for k in 0..STARTS {
        let bits = chance(first.wrapping_add(k));
        let place = |shift: u32, scale: f64| f64::from((bits >> shift) as i16) / 32_768.0 * scale;
        let start = [1.0 + place(0, 1.0), place(16, 4.0), place(32, 4.0), 0.0];
        let start = &start[..model.initial_state(&parameters).len()];
        let context = || format!("from {start:?}\n{text}");
        let least = |state: &[f64]| {
            let y = state[0];
            if has_ceiling { y.min(2.0 - y) } else { y }
        };
        let run = Run {
            system: &system,
            parameters: &parameters,
            start,
            until: UNTIL,
            impacts: IMPACTS,
            steps: STEPS,
        };
        let ended = follow(&run, &mut work, least, &context);
        assert!(ended, "no end {}", context());
    }
}

fn from_its_own_start(model: &Model, (text, has_ceiling): (&str, bool)) {
    let spec = Spec {
        impacts: IMPACTS,
        sampling: vec![Sampling::Dense { per_step: 3 }],
        ..Spec::until(UNTIL)
    };
    let run = simulate::<f64>(model, &spec, &mut |reached| {
        if reached.steps > STEPS {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    });
    let Ok(run) = run else {
        // It starts beyond a contact, or pressed into both.
        return;
    };
    assert!(run.outcome != Outcome::Interrupted, "no end\n{text}");
    if run.outcome == Outcome::Horizon {
        assert_eq!(run.time, UNTIL, "{text}");
    }
    let samples = &run.samples[0];
    let event_times: Vec<f64> = run.events.iter().map(|event| event.time).collect();
    for times in [&samples.times, &event_times] {
        assert!(times.is_sorted(), "time falls\n{text}");
        let inside = times.iter().all(|time| (0.0..=UNTIL).contains(time));
        assert!(inside, "time leaves the run\n{text}");
    }
    let heights = &samples.states[0];
    let heights = heights
        .iter()
        .chain(run.events.iter().map(|event| &event.state[0]));
    let heights: Vec<f64> = heights.copied().filter(|y| y.is_finite()).collect();
    let largest = heights.iter().fold(2.0_f64, |most, y| most.max(y.abs()));
    for y in heights {
        assert!(y >= -ROUNDING * largest, "gap {y} at the floor\n{text}");
        assert!(
            !has_ceiling || 2.0 - y >= -ROUNDING * largest,
            "gap {} at the ceiling\n{text}",
            2.0 - y
        );
    }
}
