//! Corners that are in use on one side of another corner only.

use super::run;
use chatter::analysis::simulate::Outcome;
use chatter::flow::EventKind;
use chatter::numerics::{DoubleDouble, Real};

/// The rate x' of a state, y' = 1, from where; until when, and where x is then.
type Case = (&'static str, [f64; 2], f64, f64);

fn check<R: Real>((rate, [x, y], until, right): Case) {
    let text = format!("[flight]\nx = \"{rate}\"\ny = \"1\"\n[initial]\nx = {x}\ny = {y}\n");
    let run = run::<R>(&text, until);
    assert_eq!(run.outcome, Outcome::Horizon, "{text}");
    let end = run.state[0].to_f64();
    assert!((end - right).abs() < 1e-14, "{end} for {right}: {text}");
}

/// What is slid along is held by the fields of both sides: a corner of either ends it.
#[test]
fn sliding_ends_by_a_corner_of_one_side() {
    let cases: [Case; 6] = [
        ("if(x < 0, if(y >= 0, -1, 1), -1)", [-0.5, -1.0], 3.0, -2.0),
        ("if(x > 0, if(y >= 0, 1, -1), 1)", [0.5, -1.0], 3.0, 2.0),
        ("if(-x > 0 and y < 0, 1, -1)", [-0.5, -1.0], 3.0, -2.0),
        // The field below is 1 - 2 y until it is -1.
        (
            "if(x < 0, 1 - 2*max(y, 0), -1)",
            [-0.5, -1.0],
            3.0,
            -2.25 + 0.0,
        ),
        (
            "if(x < 0, if(y >= 0, if(y >= 1, -1, 1), 1), -1)",
            [-0.5, -1.0],
            3.0,
            -1.0,
        ),
        (
            "if(x > 0, if(y >= 0, 1, -1), if(y >= 1, -1, 1))",
            [0.5, -1.0],
            3.0,
            2.0,
        ),
    ];
    for case in cases {
        check::<f64>(case);
        check::<DoubleDouble>(case);
    }
}

/// What no side asked for on the way is asked where it is met.
#[test]
fn a_corner_that_was_not_in_use_is_where_the_state_is() {
    let cases: [Case; 3] = [
        ("if(x >= 0, -1, if(y >= 0, -1, 1))", [0.5, -0.2], 3.0, -2.5),
        ("if(x <= 0, 1, if(y >= 0, 1, -1))", [-0.5, -0.2], 3.0, 2.5),
        (
            "2*cos(y) - if(x - 0.1 <= 0, 0.1, if(x + 0.1 >= 0, 0.1, 3))",
            [-0.5, 0.0],
            3.0,
            -0.5 + 2.0 * 0.141_120_008_059_867_2 - 0.3,
        ),
    ];
    for case in cases {
        check::<f64>(case);
        check::<DoubleDouble>(case);
    }
}

/// A corner that only one side asks for decides there whether the surface is slid along: where the state is, and not where it was when
/// it was asked last. Here y runs backwards, from t = 2 on x stays.
#[test]
fn sliding_asks_corners_where_the_state_is() {
    let rates = [
        "if(X > 0 and y < 0, -0.5, 0.5)",
        "if(y < 0 and X > 0, -0.5, 0.5)",
        "0.5 - step(X)*step(-y)",
        "if(X > 0, if(y < 0, -0.5, 0.5), 0.5)",
        "0.5 - if(X > 0, max(-y, 0), 0)",
    ];
    let end = |rate: &str, sign: f64| {
        let text = format!(
            "[flight]\nx = \"{sign:?}*({})\"\ny = \"-1\"\n[initial]\nx = {}\ny = 0.5\n",
            rate.replace('X', &format!("({sign:?}*x)")),
            -sign,
        );
        let run = run::<f64>(&text, 3.0);
        assert_eq!(run.outcome, Outcome::Horizon, "{text}");
        run.state[0]
    };
    for rate in rates {
        assert!(end(rate, 1.0).abs() < 1e-14, "{rate}");
        assert!(end(rate, -1.0).abs() < 1e-14, "{rate}");
    }
}

/// Where sliding ends by a corner of one side that is crossed by force of motion, nothing holds the state on that corner.
#[test]
fn a_corner_that_ends_sliding_is_crossed() {
    let text = "[flight]\nx = \"v\"\n\
                v = \"-1.71*x - 0.838*(x - y) + 0.2*cos(3.67*t + 1.9) + if(v - 0.726*w > 0 and x < 0, -0.341, 0.695)\"\n\
                y = \"w\"\nw = \"-2.17*y + 0.735*cos(3.67*t + 1.03)\"\n\
                [initial]\nx = -0.043\nv = 0.441\ny = 0.136\nw = 0.646\n";
    let run = run::<f64>(text, 0.3);
    assert_eq!(run.outcome, Outcome::Horizon);
    let told: Vec<_> = run
        .events
        .iter()
        .filter_map(|event| event.detail.kind())
        .collect();
    assert!(
        told.contains(&EventKind::Slide) && told.contains(&EventKind::Leave),
        "{told:?}"
    );
}
