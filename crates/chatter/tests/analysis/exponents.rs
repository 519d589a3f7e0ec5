//! Lyapunov exponents where several things happen at one instant, and where the motion is held for ever.

use chatter::analysis::exponents::{Exponents, Spec, exponents};
use chatter::analysis::periodic::PeriodicError;
use chatter::model::Model;
use core::f64::consts::{PI, TAU};
use core::ops::ControlFlow;

fn of(text: &str, interval: f64) -> Exponents {
    of_spec(text, interval, (40, 64))
}

fn of_spec(text: &str, interval: f64, (transient, intervals): (u64, u64)) -> Exponents {
    let model = Model::from_toml(text, "model.toml").unwrap_or_else(|errors| panic!("{errors}"));
    let spec = Spec {
        interval,
        transient,
        intervals,
    };
    exponents(&model, &spec, &mut |_| ControlFlow::Continue(())).expect("exponents")
}

fn agree(found: &Exponents, expected: &[f64], within: f64) {
    assert_eq!(found.values.len(), expected.len());
    for (value, expected) in found.values.iter().zip(expected) {
        let is_near = (value - expected).abs() < within || value == expected;
        assert!(is_near, "{:?} for {expected}", found.values);
    }
}

const LOST: f64 = f64::NEG_INFINITY;

/// A clock adds to b, which jumps across the surface of another event and is multiplied by c at once: displacements of b
/// shrink by c e^-1 in each period, those of the clock stay.
#[test]
fn an_event_that_another_causes_comes_when_that_does() {
    for c in [0.5_f64, 0.2, 0.0] {
        let text = format!(
            "[flight]\na = \"1\"\nb = \"0.5 - b\"\n[[event]]\nname = \"tick\"\nsurface = \"a - 1\"\ndirection = \"rising\"\n\
             reset = {{ a = 0, b = \"b + 1\" }}\n[[event]]\nname = \"fire\"\nsurface = \"b - 0.9\"\ndirection = \"rising\"\n\
             reset = {{ b = \"{c:?}*b\" }}\n[initial]\na = 0\nb = 0.1\n"
        );
        agree(&of(&text, 1.0), &[0.0, c.ln() - 1.0], 1e-12);
    }
}

/// What one event does and another at once is what one that does both does.
#[test]
fn two_events_in_a_row_are_one() {
    let text = |resets: &str| {
        format!(
            "[flight]\ni = \"if(q > 0.5, 1, -0.6 - 0.1*i)\"\nq = \"0\"\ns = \"1 - 0.4*s\"\n[[event]]\nname = \"clock\"\n\
             surface = \"sin(2*pi*t)\"\ndirection = \"rising\"\nreset = {{ q = 1 }}\n[[event]]\nname = \"peak\"\n\
             surface = \"i - 1 + 0.1*s\"\ndirection = \"rising\"\nreset = {{ q = 0{resets}\n[initial]\ni = 0.5\nq = 0\ns = 0\n"
        )
    };
    let chained = text(
        " }\n[[event]]\nname = \"latch\"\nsurface = \"q - 0.5\"\ndirection = \"falling\"\nreset = { s = \"0.5*s\" }",
    );
    let at_once = of(&text(", s = \"0.5*s\" }"), 1.0);
    assert!(at_once.values[0] < -0.5);
    agree(&of(&chained, 1.0), &at_once.values, 1e-12);
}

/// A ball on a shaken table, which it leaves at pi and meets a period later: an impact that an event on the sign of the rate slows down
/// is one of less restitution.
#[test]
fn an_event_that_an_impact_causes_comes_when_that_does() {
    let phase = (0.6 * PI / (1.4 * 1.5)).acos();
    let height = 1.5 * phase.sin() + 0.01;
    let ball = |restitution: f64, event: &str| {
        format!(
            "[flight]\ny = \"v\"\nv = \"-1\"\n[[contact]]\nname = \"floor\"\ngap = \"y - 1.5*sin(t + {phase:?})\"\n\
             impulse = {{ v = 1 }}\nrestitution = {restitution:?}\n{event}[initial]\ny = {height:?}\nv = {PI:?}\n"
        )
    };
    let rate = format!("1.5*cos(t + {phase:?})");
    let event = format!(
        "[[event]]\nname = \"brake\"\nsurface = \"v - {rate}\"\ndirection = \"rising\"\n\
         reset = {{ v = \"{rate} + 0.5*(v - {rate})\" }}\n"
    );
    let (with, without) = (of(&ball(0.8, &event), TAU), of(&ball(0.4, ""), TAU));
    // Both together shrink areas by the square of the restitution.
    let sum: f64 = without.values.iter().sum();
    assert!((sum - 2.0 * 0.4_f64.ln() / TAU).abs() < 1e-10, "{sum}");
    agree(&with, &without.values, 1e-10);
}

/// Motion that slides or sticks for ever keeps no displacement off what holds it.
#[test]
fn what_is_held_for_ever_is_forgotten() {
    let slides =
        "[flight]\nx = \"-sign(x) + 0.1*sin(t)\"\nz = \"x - 0.3*z\"\n[initial]\nx = 1\nz = 1\n";
    agree(&of(slides, TAU), &[-0.3, LOST], 1e-12);
    let control =
        "[flight]\nx = \"v\"\nv = \"-3*sign(x + v) + 0.5*sin(t)\"\n[initial]\nx = 1\nv = 0\n";
    agree(&of(control, TAU), &[-1.0, LOST], 1e-12);
    let rests = "[flight]\nx = \"v\"\nv = \"-sign(x) - x + 0.5*sin(t)\"\nz = \"x - 0.2*z\"\n[initial]\nx = 0\nv = 0\nz = 1\n";
    agree(&of(rests, TAU), &[-0.2, LOST, LOST], 1e-12);
    let sticks = "[flight]\nx = \"u\"\nu = \"0.1*sin(t)\"\ny = \"v\"\nv = \"-1\"\nz = \"x - 0.3*z\"\n[[contact]]\nname = \"floor\"\n\
                  gap = \"y\"\nimpulse = { v = 1 }\nrestitution = 0.5\nfriction = { coefficient = 0.3, along = { u = 1 } }\n\
                  [initial]\nx = 0\nu = 0.5\ny = 0.2\nv = 0\nz = 0\n";
    agree(&of(sticks, TAU), &[0.0, -0.3, LOST, LOST, LOST], 1e-12);
}

/// What a surface leaves standing as it is crossed is forgotten, as the current of a chopper that comes to its end between two pulses; what a clock only lets
/// shrink faster is not.
#[test]
fn what_stands_still_behind_a_surface_is_forgotten() {
    let chopper = "[definitions]\ne = \"if(sin(t) > 0.2, 1, 0) - 0.4 - 0.3*i\"\n[flight]\ni = \"if(i > 0, e, max(e, 0))\"\n\
                   z = \"i - 0.3*z\"\n[initial]\ni = 0.1\nz = 0\n";
    agree(&of(chopper, TAU), &[-0.3, LOST], 1e-12);
    let fast = "[flight]\nx = \"cos(t) - if(sin(t) > 0, 60, 20)*x\"\n[initial]\nx = 1\n";
    agree(&of(fast, TAU), &[-40.0], 1e-9);
}

/// A ball with spin whose sliding an impact has stopped to a rounding error: the place, and what friction does not see of speed
/// and spin, are kept.
#[test]
fn sliding_that_has_stopped_to_rounding_leaves_what_it_does_not_hold() {
    let text = "[flight]\nx = \"u\"\nu = \"0\"\ns = \"0\"\ny = \"v\"\nv = \"-1\"\n[[contact]]\nname = \"floor\"\n\
                gap = \"y - 1.3*sin(t)\"\nimpulse = { v = 1 }\nrestitution = 0.6\n\
                friction = { coefficient = 0.3, along = { u = 1, s = 2.5 }, rate = \"u + s\" }\n\
                [initial]\nx = 0\nu = 0.9\ny = 1\nv = 0\ns = 0\n";
    agree(&of(text, TAU), &[0.0, 0.0, LOST, LOST, LOST], 1e-12);
}

/// Two equal masses under one force, each at a stop of its own.
fn in_phase(coupling: &str, law: &str) -> String {
    format!(
        "{law}[parameters]\nF = 2.0\n[flight]\nx = \"v\"\nv = \"-x - 0.1*v + F*cos(2.1*t) - {coupling}\"\ny = \"w\"\n\
         w = \"-y - 0.1*w + F*cos(2.1*t) + {coupling}\"\n[[contact]]\nname = \"right\"\ngap = \"0.3 - x\"\n\
         impulse = {{ v = -1 }}\nrestitution = 0.7\n[[contact]]\nname = \"top\"\ngap = \"0.3 - y\"\nimpulse = {{ w = -1 }}\n\
         restitution = 0.7\n[initial]\nx = 0\nv = 0\ny = 0\nw = 0\n"
    )
}

/// In phase and against each other they are two oscillators of their own: each shrinks areas as one that is alone.
#[test]
fn what_ends_in_flight_at_one_instant_is_followed_where_it_has_one_derivative() {
    let period = TAU / 2.1;
    let alone = of(
        "[flight]\nx = \"v\"\nv = \"-x - 0.1*v + 2*cos(2.1*t)\"\n[[contact]]\nname = \"right\"\ngap = \"0.3 - x\"\n\
         impulse = { v = -1 }\nrestitution = 0.7\n[initial]\nx = 0\nv = 0\n",
        period,
    );
    let twice: Vec<f64> = alone.values.iter().flat_map(|&x| [x, x]).collect();
    agree(&of(&in_phase("0", ""), period), &twice, 1e-9);
    agree(
        &of(&in_phase("0", "simultaneous = \"moreau\"\n"), period),
        &twice,
        1e-9,
    );
}

fn refusal(text: &str, interval: f64) -> PeriodicError {
    let model = Model::from_toml(text, "model.toml").unwrap_or_else(|errors| panic!("{errors}"));
    let spec = Spec {
        interval,
        transient: 0,
        intervals: 16,
    };
    exponents(&model, &spec, &mut |_| ControlFlow::Continue(())).expect_err("none")
}

#[test]
fn what_depends_on_which_contact_is_met_first_has_no_exponents() {
    let period = TAU / 2.1;
    let damped = refusal(&in_phase("0.3*(v - w)", ""), period);
    assert!(
        matches!(damped, PeriodicError::OrderMatters { .. }),
        "{damped:?}"
    );
    // A plate on two springs falls flat onto two stops that feel each other.
    let plate = |law: &str| {
        format!(
            "{law}[flight]\ny = \"v\"\nv = \"-1\"\na = \"w\"\nw = \"0\"\n[[contact]]\nname = \"left\"\ngap = \"y - a\"\n\
             impulse = {{ v = 1, w = -1 }}\nrestitution = 0.9\n[[contact]]\nname = \"right\"\ngap = \"y + a\"\n\
             impulse = {{ v = 1, w = 1 }}\nrestitution = 0.9\n[initial]\ny = 1\nv = 0\na = 0\nw = 0\n"
        )
    };
    let uncoupled = of_spec(&plate(""), 0.1, (0, 20));
    // Each impact shrinks areas by the square of its restitution.
    let shrunk: f64 = uncoupled.values.iter().sum::<f64>() * 2.0;
    assert!((shrunk - 4.0 * 0.9_f64.ln()).abs() < 1e-10, "{uncoupled:?}");
    let heavy = |law: &str| {
        plate(law)
            .replace("w = -1 }", "w = -3 }")
            .replace("w = 1 }", "w = 3 }")
    };
    let binary = refusal(&heavy(""), 1.0);
    assert!(
        matches!(binary, PeriodicError::OrderMatters { .. }),
        "{binary:?}"
    );
    let joint = refusal(&heavy("simultaneous = \"moreau\"\n"), 1.0);
    assert!(
        matches!(joint, PeriodicError::Unfollowed { .. }),
        "{joint:?}"
    );
}

/// Impacts that share an instant on the way to an orbit leave nothing in its exponents.
#[test]
fn what_depends_on_which_contact_is_met_first_does_not_matter_in_the_transient() {
    let period = TAU / 2.1;
    let alike = in_phase("0.3*(v - w)", "");
    let unlike = alike.replace(
        "restitution = 0.7\n[initial]",
        "restitution = 0.3\n[initial]",
    );
    let beside = unlike.replace("y = 0\nw = 0\n", "y = 0.1\nw = 0\n");
    assert!(unlike != alike && beside != unlike);
    let expected = of_spec(&beside, period, (300, 400));
    assert!(expected.values[0] < 0.0, "no orbit: {expected:?}");
    let found = of_spec(&unlike, period, (300, 400));
    agree(&found, &expected.values, 5e-3);
    // How volumes shrink does not depend on the directions that are followed.
    let volume = |found: &Exponents| found.values.iter().sum::<f64>();
    assert!(
        (volume(&found) - volume(&expected)).abs() < 1e-9,
        "{found:?}"
    );
    let order = refusal(&unlike, period);
    assert!(
        matches!(order, PeriodicError::OrderMatters { .. }),
        "{order:?}"
    );
}
