//! Tables whose range ends where a wall is, as a force that was measured over the lift of a valve: motions are those of the formula
//! that such a table is.

use super::run;
use chatter::analysis::simulate::{Outcome, Simulation};
use chatter::flow::{FlowError, Occurrence};
use chatter::numerics::{DoubleDouble, Real};

/// What happens, and when.
fn events<R: Real>(text: &str, until: f64) -> (Simulation<R>, Vec<(f64, Occurrence<R>)>) {
    let end = run::<R>(text, until);
    let events = (end.events.iter())
        .map(|event| (event.time.to_f64(), event.detail))
        .collect();
    (end, events)
}

/// A body on a wall at `wall`, which it leaves to the side of `up`: pressed on by 1 + lift/2, and pushed by a force in time. `force` is
/// the first of these as a function of the lift.
fn body((wall, up): (f64, f64), force: &str, push: &str, start: [f64; 2]) -> String {
    let [lift, rate] = start;
    let (y, v) = (wall + up * lift, up * rate);
    format!(
        "[table.force]\nx = [0, 0.5, 6]\ny = [1, 1.25, 4]\n[table.fall]\nx = [-6, -0.5, 0]\ny = [4, 1.25, 1]\n\
         [definitions]\nlift = \"{up}*(y - {wall})\"\n\
         [flight]\ny = \"v\"\nv = \"{up}*({push} - {force})\"\n\
         [[contact]]\nname = \"seat\"\ngap = \"lift\"\nimpulse = {{ v = {up} }}\nrestitution = 0.6\n\
         [initial]\ny = {y}\nv = {v}\n"
    )
}

fn compare<R: Real>(place: (f64, f64), push: &str, start: [f64; 2], within: f64) {
    let (plain, expected) = events::<R>(&body(place, "(1 + lift/2)", push, start), 12.0);
    assert_eq!(plain.outcome, Outcome::Horizon);
    for force in ["force(lift)", "fall(-lift)"] {
        let (end, found) = events::<R>(&body(place, force, push, start), 12.0);
        assert_eq!(end.outcome, Outcome::Horizon, "{place:?} {force} {start:?}");
        // The body passes a knot and so completes its chatter from other impacts.
        let shared = |events: &[(f64, Occurrence<R>)]| -> Vec<f64> {
            (events.iter())
                .filter(|(_, occurrence)| !matches!(occurrence, Occurrence::Impact { .. }))
                .map(|&(time, _)| time)
                .collect()
        };
        let impacts = |events: &[(f64, Occurrence<R>)]| -> Vec<f64> {
            (events.iter())
                .filter(|(_, occurrence)| matches!(occurrence, Occurrence::Impact { .. }))
                .map(|&(time, _)| time)
                .take(6)
                .collect()
        };
        let pairs = [
            (shared(&expected), shared(&found)),
            (impacts(&expected), impacts(&found)),
        ];
        for (expected, found) in pairs {
            assert_eq!(
                expected.len(),
                found.len(),
                "{place:?} {force} {start:?} {expected:?} {found:?}"
            );
            for (a, b) in expected.iter().zip(&found) {
                assert!(
                    (a - b).abs() < within,
                    "{place:?} {force} {start:?} {a} {b}"
                );
            }
        }
        for (&a, &b) in plain.state.iter().zip(&end.state) {
            let apart = (a - b).abs().to_f64();
            assert!(apart < within, "{place:?} {force} {start:?} {apart}");
        }
    }
}

/// Bounces, accumulation, rest, release and the next flight, at the lower and the upper end.
#[test]
fn a_wall_may_stand_where_a_table_ends() {
    let push = "max(0, 2*cos(t))";
    for place in [(0.0, 1.0), (2.0, -1.0), (0.1, 1.0)] {
        for start in [[0.4, 0.0], [0.0, 0.5], [0.0, 0.0]] {
            compare::<f64>(place, push, start, 1e-11);
        }
    }
    compare::<DoubleDouble>((0.0, 1.0), push, [0.4, 0.0], 1e-13);
}

/// Where the argument is a small difference of large terms, it is known no better than these are.
#[test]
fn the_end_of_a_table_is_known_to_rounding_of_its_argument() {
    for wall in [1e3, -1e5] {
        compare::<f64>((wall, 1.0), "0", [0.4, 0.0], 2e-15 * f64::abs(wall));
    }
}

/// A wall far from the end does not keep the body within the table, nor does one that it has left.
#[test]
fn what_leaves_a_table_is_refused_beside_walls() {
    let leaves = |text: &str, expected: (f64, f64)| match events::<f64>(text, 12.0).0.outcome {
        Outcome::Failed(FlowError::OutsideTable { time, argument, .. }) => {
            assert!((time - expected.0).abs() < 1e-13, "{time}");
            assert_eq!(argument, expected.1);
        }
        other => panic!("{other:?}"),
    };
    // x'' = 2 with (1 + x/2) taken away by the push: up to where x = 6 from 0.
    let text = body((0.0, 1.0), "force(lift)", "(3 + lift/2)", [0.0, 0.0]);
    leaves(&text, (6.0_f64.sqrt(), 6.0));
    // The wall is a thousandth beyond the end.
    let beyond = text
        .replace("gap = \"lift\"", "gap = \"lift + 0.001\"")
        .replace("(3 + lift/2)", "(lift/2 - 1)")
        .replace("y = 0\n", "y = 1\n");
    leaves(&beyond, (1.0, 0.0));
}

/// What is not looked up has no value, and need not have any.
#[test]
fn a_table_that_is_not_asked_has_no_end() {
    let text = "[table.force]\nx = [0, 2]\ny = [1, 1]\n[flight]\ny = \"v\"\nv = \"if(y > 0, -force(y), 1)\"\n\
                [initial]\ny = -0.5\nv = 0\n";
    // Up to y = 0 in the time 1, down again from the rate 1 after 2, and so on: with the period 4.
    let (end, _) = events::<f64>(text, 8.0);
    assert_eq!(end.outcome, Outcome::Horizon);
    assert!((end.state[0] + 0.5).abs() < 1e-12, "{:?}", end.state);
}
