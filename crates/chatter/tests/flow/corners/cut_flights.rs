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

/// A hammer strikes a bit that sticks in the ground after each blow, and is pulled back: rates fall to nothing in a finite time though
/// the gap of each flight turns upward once the bit sticks, and then the hammer leaves.
#[test]
fn a_hammer_that_is_pulled_back_strikes_until_its_rate_is_gone() {
    fn check<R: Real>(length: f64, time: f64, pull: f64) {
        let (rate, force) = (length / time, length / (time * time));
        let text = format!(
            "[flight]\nx = 'u'\nu = '-{}'\ny = 'v'\nv = '-{}*sign(v)/0.3'\n[[contact]]\ngap = 'y - x'\n\
             restitution = 0.8\nimpulse = {{ u = -1, v = '1/0.3' }}\n[initial]\nx = 0\nu = {rate}\ny = {}\nv = 0\n",
            pull * force,
            3.0 * force,
            0.1 * length
        );
        // One flight after another, in units of one.
        let (mut u, mut y, mut gap, mut t) = (1.0_f64, 0.1_f64, 0.1_f64, 0.0_f64);
        while u > 1e-18 {
            let struck = (u * u - 2.0 * pull * gap).sqrt();
            t += 2.0 * gap / (u + struck);
            let impulse = 1.8 * struck * 0.3 / 1.3;
            let (after, bit) = (struck - impulse, impulse / 0.3);
            let stops = bit / 10.0;
            let (way, forward) = (0.5 * bit * stops, (after - 0.5 * pull * stops) * stops);
            (y, gap) = (y + way, way - forward);
            u = after - pull * stops;
            t += stops;
        }
        let run = run::<R>(&text, 4.0 * time);
        let end = run.events.iter().find_map(|event| match event.detail {
            Occurrence::Accumulation { .. } => Some(event.time.to_f64()),
            _ => None,
        });
        let off = end.map(|end| (end / time - t).abs());
        assert!(
            off.is_some_and(|off| off < 4e-15),
            "{end:?} for {t}: {text}"
        );
        let back = 4.0 - t;
        let right = [y - 0.5 * pull * back * back, -pull * back];
        for (k, unit) in [(0, length), (1, rate)] {
            let off = run.state[k].to_f64() / unit - right[k];
            assert!(
                off.abs() < 4e-15 * (1.0 + right[k].abs()),
                "{k} {off:e}: {text}"
            );
        }
    }
    for (length, time) in [(1.0, 1.0), (1e3, 1e-2), (1e-3, 30.0)] {
        for pull in [0.02, 0.1, 0.5] {
            check::<f64>(length, time, pull);
        }
    }
    check::<DoubleDouble>(1.0, 1.0, 0.1);
}
