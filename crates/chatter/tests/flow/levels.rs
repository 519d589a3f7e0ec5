//! What counts as zero is told by the terms that a quantity is the sum of, not by other states nor by units.

use chatter::analysis::simulate::{EventKind, Simulation, Spec, simulate};
use chatter::model::Model;
use chatter::numerics::{DoubleDouble, Real, Scalar};
use std::ops::ControlFlow;

fn run<R: Real>(text: &str, until: f64) -> Simulation<R> {
    let model = Model::from_toml(text, "model").expect("a valid model");
    simulate::<R>(&model, &Spec::until(until), &mut |_| {
        ControlFlow::Continue(())
    })
    .expect("a legal start")
}

fn ball(height: &str, gravity: &str, further: &str, initial: &str) -> String {
    format!(
        "[flight]\ny = \"v\"\nv = \"-({gravity})\"\n{further}\n\
         [[contact]]\nname = \"floor\"\ngap = \"y\"\nimpulse = {{ v = 1 }}\nrestitution = 0.6\n\
         [initial]\ny = \"{height}\"\nv = 0\n{initial}\n"
    )
}

#[test]
fn unrelated_states_change_nothing() {
    let alone = run::<f64>(&ball("0.3", "1 + 0.5*sin(t)", "", ""), 50.0);
    for size in ["1e6", "1e9", "1e-9"] {
        let (further, initial) = ("z = \"0\"", format!("z = {size}"));
        let beside = run::<f64>(&ball("0.3", "1 + 0.5*sin(t)", further, &initial), 50.0);
        assert_eq!(alone.counts, beside.counts, "{size}");
        for (a, b) in alone.events.iter().zip(&beside.events) {
            assert_eq!(a.kind, b.kind);
            assert!((a.time - b.time).abs() < 1e-13, "{} {}", a.time, b.time);
        }
    }
}

#[test]
fn a_ball_just_above_the_ground_falls() {
    for height in [1e-13_f64, 1e-20, 1e-100] {
        let falls = run::<f64>(&ball(&format!("{height:e}"), "2", "", ""), 1.0);
        let first = &falls.events[0];
        assert_eq!(first.kind, EventKind::Impact, "{height}");
        assert!((first.time / height.sqrt() - 1.0).abs() < 1e-14);
    }
}

/// The least force holds a contact, and lets it go where it vanishes.
#[test]
fn weak_forces_hold() {
    for weak in [1e-9_f64, 1e-15, 1e-30] {
        let gravity = format!("{weak:e}*(1 - t/1000)");
        let held = run::<f64>(&ball("0", &gravity, "", ""), 1500.0);
        assert_eq!(held.counts.impacts, 0, "{weak}");
        assert_eq!(held.counts.releases, 1, "{weak}");
        assert!((held.events[0].time - 1000.0).abs() < 1e-10);
        // From rest: y = weak (t - 1000)^3 / 6000.
        let y = weak * 500.0_f64.powi(3) / 6000.0;
        assert!((held.state[0] / y - 1.0).abs() < 1e-11, "{:?}", held.state);
    }
}

#[test]
fn thirty_digits_stay_thirty_in_contact() {
    let text = "[flight]\ny = \"v\"\nv = \"-1\"\n\
        [[contact]]\ngap = \"y - sin(0.1*t)\"\nimpulse = { v = 1 }\nrestitution = 0.3\n\
        [initial]\ny = 0\nv = 0.1\n";
    let held = run::<DoubleDouble>(text, 1000.0);
    let turn = DoubleDouble::from(1000.0) / DoubleDouble::from(10.0);
    let table = turn.sin_cos().0;
    let off = (held.state[0] - table).to_f64().abs();
    assert!(held.closed.contains(0) && off < 1e-29, "{off:e}");
}
