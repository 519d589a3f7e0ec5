//! Surfaces that the motion on one side keeps, as a play operator or a slider without mass does: but for rounding of the numbers that
//! the equations are written with.

use super::run;
use chatter::analysis::simulate::Outcome;
use chatter::flow::Occurrence;
use chatter::numerics::{DoubleDouble, Real};

/// z follows y from where 0.7 x - z reaches 0.02, x being y in another unit of length; before that it falls. After it z' = y = 1 - z...:
/// z'' = 1 - z from z = 0, z' = 0.2 at t = 0.2, y = z'.
fn follows<R: Real>(unit: &str, back: &str) {
    let text = format!(
        "[flight]\nx = \"{back}*y\"\ny = \"1 - z\"\nz = \"if({unit}*x - z - 0.02 >= 0, y, -z)\"\n[initial]\nx = 0\ny = 0\nz = 0\n"
    );
    let run = run::<R>(&text, 20.0);
    assert_eq!(run.outcome, Outcome::Horizon, "{unit}");
    let end = run.state[2].to_f64();
    let (sine, cosine) = 19.8_f64.sin_cos();
    let expected = 1.0 - cosine + 0.2 * sine;
    assert!((end - expected).abs() < 1e-13, "{unit}: {end} {expected}");
}

#[test]
fn a_surface_is_kept_whatever_the_unit_of_what_it_is_a_function_of() {
    for (unit, back) in [
        ("0.7", "1.4285714285714286"),
        ("25.4", "0.03937007874015748"),
        ("0.3048", "3.280839895013123"),
        ("7", "0.14285714285714285"),
        ("47", "0.02127659574468085"),
        ("3", "0.3333333333333333"),
        ("1", "1"),
    ] {
        follows::<f64>(unit, back);
        follows::<DoubleDouble>(unit, back);
    }
}

/// A ram rests on a pile that friction holds in the soil, and three blocks on each other and on the ground: two forces that cancel hold
/// each of them. What rests goes nowhere, however long.
#[test]
fn what_several_forces_hold_does_not_creep() {
    let pile = "[flight]\ny = \"v\"\nv = \"-9.81\"\np = \"u\"\nu = \"-9.81 - 300*sign(u) - 500*p\"\n\
         [[contact]]\nname = \"ram\"\ngap = \"y - p\"\nimpulse = { v = \"1/2\", u = \"-1\" }\nrestitution = 0.3\n\
         [initial]\ny = 0\nv = -2\np = 0\nu = -2\n";
    let blocks = "[flight]\nx = \"v\"\nv = \"(-0.7*x + 0.3*sign(w - v) - 0.9*sign(v))/1.3\"\ny = \"w\"\n\
         w = \"(-0.11*(y - 0.3) - 0.3*sign(w - v))/0.37\"\n[initial]\nx = 2.1\nv = 0.1\ny = -0.7\nw = 1.2\n";
    for (text, rests) in [(pile, 1.0), (blocks, 50.0)] {
        let (soon, late) = (run::<f64>(text, rests), run::<f64>(text, 1e6));
        assert_eq!(late.outcome, Outcome::Horizon, "{text}");
        assert_eq!(soon.state, late.state, "{text}");
    }
}

/// Sections on a speed that sticks are crossed where it is left to the other side, however they are spelled.
#[test]
fn a_section_that_is_stuck_to_is_crossed_where_it_is_left() {
    let spellings = ["v", "3.3*v", "v*(2 + cos(x))", "-0.1*v"];
    let directions = ["rising", "falling", "either"];
    let mut text = String::from("[flight]\nx = \"v\"\nv = \"1.3*cos(0.5*t) - sign(v)\"\n");
    for (k, spelling) in spellings.iter().enumerate() {
        for direction in directions {
            text += &format!(
                "[section.s{k}{direction}]\nsurface = \"{spelling}\"\ndirection = \"{direction}\"\n"
            );
        }
    }
    text += "[initial]\nx = 0\nv = 0.1\n";
    let run = run::<f64>(&text, 60.0);
    let times = |wanted: &dyn Fn(&Occurrence<f64>) -> bool| -> Vec<f64> {
        let events = run.events.iter().filter(|event| wanted(&event.detail));
        events.map(|event| event.time).collect()
    };
    let crossed = |number: usize| times(&|what| *what == Occurrence::Section { section: number });
    let left = times(&|what| matches!(what, Occurrence::Leave { .. } | Occurrence::Switch { .. }));
    let slid = times(&|what| matches!(what, Occurrence::Slide { .. }));
    assert!(slid.len() >= 3, "{slid:?}");
    let either = crossed(2);
    assert!(
        either.iter().all(|time| left.contains(time)),
        "{either:?}, left at {left:?}"
    );
    for (k, spelling) in spellings.iter().enumerate() {
        let [rising, falling, both] = [0, 1, 2].map(|way| crossed(3 * k + way));
        assert_eq!(both, either, "{spelling}");
        assert_eq!(rising.len() + falling.len(), both.len(), "{spelling}");
        let expected = if k == 3 { crossed(1) } else { crossed(0) };
        assert_eq!(rising, expected, "{spelling}");
    }
}

/// As it is where only one is watched: then nothing else asks what happens at the end of the step.
#[test]
fn one_section_that_is_stuck_to_is_crossed_where_it_is_left() {
    for (surface, direction) in [("v", "falling"), ("v", "rising"), ("3*v", "either")] {
        let text = format!(
            "[flight]\nx = \"v\"\nv = \"1.6*cos(0.4*t) - x - sign(v)\"\n[section.turning]\nsurface = \"{surface}\"\n\
             direction = \"{direction}\"\n[initial]\nx = 0\nv = 0.5\n"
        );
        let run = run::<f64>(&text, 120.0);
        let mut is_told = false;
        for pair in run.events.windows(2) {
            let crossed = matches!(pair[1].detail, Occurrence::Section { .. });
            let left = matches!(
                pair[0].detail,
                Occurrence::Leave { .. } | Occurrence::Switch { .. }
            );
            assert!(!crossed || left, "{pair:?} {text}");
            is_told |= crossed;
        }
        assert!(is_told || direction != "either", "{text}");
    }
}
