//! Chains at rest whose end is struck or driven: what is further away begins to move with a higher power of time, and its series with
//! none of their leading terms.

use chatter::analysis::simulate::{Outcome, Simulation, Spec, simulate};
use chatter::model::Model;
use chatter::numerics::{DoubleDouble, Real};
use std::ops::ControlFlow;

fn run<R: Real>(text: &str, until: f64) -> Simulation<R> {
    let model = Model::from_toml(text, "test").unwrap_or_else(|errors| panic!("{errors:?}"));
    simulate(&model, &Spec::until(until), &mut |_| {
        ControlFlow::Continue(())
    })
    .unwrap_or_else(|error| panic!("{error}"))
}

/// Equal lags that are switched on at t = 1 follow the gamma distribution of their number.
#[test]
fn lags_in_a_row_follow_what_switches_on() {
    fn follow<R: Real>() {
        let text = "[flight]\na = \"1000*(if(t > 1, 1, 0) - a)\"\nb = \"1000*(a - b)\"\nc = \"1000*(b - c)\"\n\
                    d = \"1000*(c - d)\"\n[initial]\na = 0\nb = 0\nc = 0\nd = 0\n";
        for x in [0.5_f64, 2.0, 20.0, 200.0] {
            let end: Simulation<R> = run(text, 1.0 + x / 1000.0);
            let x = (end.time.to_f64() - 1.0) * 1000.0;
            let (mut sum, mut term) = (0.0, 1.0);
            for (k, state) in end.state[..4].iter().enumerate() {
                sum += term;
                term *= x / (k + 1) as f64;
                let off = state.to_f64() - (1.0 - (-x).exp() * sum);
                assert!(off.abs() < 1e-12, "{x} {k}: {off:e}");
            }
        }
    }
    follow::<f64>();
    follow::<DoubleDouble>();
}

/// A ball falls on a rod of three masses and springs at rest.
fn struck(stiffness: f64, floor: &str) -> String {
    format!(
        "[parameters]\nK = {stiffness:?}\n[flight]\nh = \"w\"\nw = \"-1\"\ny0 = \"v0\"\nv0 = \"-K*(y0 - y1)\"\ny1 = \"v1\"\n\
         v1 = \"K*(y0 - y1) - K*(y1 - y2)\"\ny2 = \"v2\"\nv2 = \"K*(y1 - y2) - K*y2\"\n[[contact]]\nname = \"ram\"\n\
         gap = \"h - y0\"\nimpulse = {{ w = 1, v0 = -2 }}\nrestitution = 0.3\n{floor}[initial]\nh = 0.1\nw = 0\ny0 = 0\nv0 = 0\n\
         y1 = 0\nv1 = 0\ny2 = 0\nv2 = 0\n"
    )
}

/// The last mass, by the exponential of the chain's matrix.
#[test]
fn a_blow_runs_along_a_rod_at_rest() {
    fn runs<R: Real>() {
        let end: Simulation<R> = run(&struck(1e4, ""), 0.46);
        assert_eq!(end.outcome, Outcome::Horizon);
        let off = end.state[6].to_f64() - -9.066_555_051_175_03e-5;
        assert!(off.abs() < 1e-16, "{off:e}");
    }
    runs::<f64>();
    runs::<DoubleDouble>();
}

/// What stands on a floor without a load is pressed onto it by the wave, whose force begins with a high derivative.
#[test]
fn a_blow_presses_what_stands_at_the_end() {
    let floor =
        "[[contact]]\nname = \"floor\"\ngap = \"y2\"\nimpulse = { v2 = 1 }\nrestitution = 0.3\n";
    for stiffness in [1e2_f64, 1e4, 1e6] {
        let (time, until) = (0.2_f64.sqrt(), 0.2_f64.sqrt() + 1.0 / stiffness.sqrt());
        let end: Simulation<f64> = run(&struck(stiffness, floor), until);
        assert_eq!(end.outcome, Outcome::Horizon, "{stiffness}");
        assert!(end.time > time && end.closed.contains(1), "{stiffness}");
        assert_eq!(end.state[6..], [0.0, 0.0], "{stiffness}");
    }
}

/// Balls that come to rest on each other while the lowest bounces on a shaken table, in units in which their accelerations in flight
/// differ by rounding: they lie there together in the end.
#[test]
fn stacked_bodies_come_to_rest_in_any_units() {
    let text = r#"
[flight]
x1 = "0.0035194417615494397*((0.020749279561614698*v1))"
v1 = "48.194444391696294*(-9.81)"
x2 = "1314.3275418191195*((-0.009799972303080213*v2))"
v2 = "-102.04110471676452*(-9.81)"
x3 = "95.70394935255895*((13.310626193595786*v3))"
v3 = "0.07512794555684657*(-9.81)"
[[contact]]
name = "fl"
gap = "(284.1359703476805*x1) - 0.1*sin(7*t)"
impulse = { v1 = "(1)/(0.020749279561614698)" }
restitution = "0.7"
[[contact]]
name = "c12"
gap = "(0.0007608453510880031*x2) - (284.1359703476805*x1)"
impulse = { v1 = "(-1)/(0.020749279561614698)", v2 = "(0.5)/(-0.009799972303080213)" }
restitution = "0.6"
[[contact]]
name = "c23"
gap = "(0.010448889588831391*x3) - (0.0007608453510880031*x2)"
impulse = { v2 = "(-0.5)/(-0.009799972303080213)", v3 = "(0.3)/(13.310626193595786)" }
restitution = "0.8"
[initial]
x1 = "(0.3)/(284.1359703476805)"
x2 = "(0.7)/(0.0007608453510880031)"
x3 = "(0.9)/(0.010448889588831391)"
v1 = "(0)/(0.020749279561614698)"
v2 = "(1)/(-0.009799972303080213)"
v3 = "(-0.4)/(13.310626193595786)"
"#;
    let end: Simulation<f64> = run(text, 3.0);
    assert_eq!(end.outcome, Outcome::Horizon);
    let table = 0.1 * 21.0_f64.sin();
    let scales = [
        284.135_970_347_680_5,
        0.000_760_845_351_088_003_1,
        0.010_448_889_588_831_391,
    ];
    for (contact, scale) in scales.into_iter().enumerate() {
        assert!(end.closed.contains(contact));
        let off = end.state[2 * contact] * scale - table;
        assert!(off.abs() < 1e-12, "{contact}: {off:e}");
    }
}
