//! Chatter whose flights are cut in the air, where the gap is the small difference of large terms.

use super::run;
use chatter::analysis::simulate::Outcome;
use chatter::flow::Occurrence;
use chatter::numerics::{DoubleDouble, Real};

/// What cuts flights: nothing, at their tops, or now and then.
const CUTS: [&str; 3] = [
    "",
    "[section.top]\nsurface = \"v\"\n",
    "[section.clock]\nsurface = \"sin(7*t)\"\n",
];

/// When a body comes to rest at y = 1/scale whose flights rise and fall with these accelerations, from rest at zero.
fn comes_to_rest(scale: f64, restitution: f64, [rises, falls]: [f64; 2]) -> f64 {
    let rate = f64::sqrt(2.0 * falls / scale);
    let again = restitution * f64::sqrt(falls / rises);
    rate / falls + rate * (restitution / rises + again / falls) / (1.0 - again)
}

#[test]
fn chatter_ends_where_it_does_without_cuts() {
    fn check<R: Real>(scale: f64, restitution: f64, friction: f64, cut: &str) {
        let text = format!(
            "[flight]\ny = \"v\"\nv = \"1 - {friction}*sign(v)\"\n[[contact]]\ngap = \"1 - {scale}*y\"\n\
            restitution = {restitution}\nimpulse = {{ v = -1 }}\n{cut}[initial]\ny = 0\nv = 0\n"
        );
        let until = 40.0 / scale.sqrt();
        let run = run::<R>(&text, until);
        assert_eq!(run.outcome, Outcome::Horizon, "{text}");
        let right = comes_to_rest(scale, restitution, [1.0 + friction, 1.0 - friction]);
        let ends: Vec<f64> = (run.events.iter())
            .filter(|event| matches!(event.detail, Occurrence::Accumulation { .. }))
            .map(|event| event.time.to_f64())
            .collect();
        let [end] = ends[..] else {
            panic!("{} accumulations: {text}", ends.len());
        };
        assert!(
            (end - right).abs() < 1e-13 * right,
            "{end} for {right}: {text}"
        );
    }
    for scale in [0.7, 0.013, 47.0, 0.3048, 25.4, 3.0, 1.0] {
        for restitution in [0.1, 0.5, 0.8] {
            for friction in [0.0, 0.3] {
                for cut in CUTS {
                    check::<f64>(scale, restitution, friction, cut);
                }
            }
        }
        check::<DoubleDouble>(scale, 0.5, 0.3, CUTS[1]);
    }
}
