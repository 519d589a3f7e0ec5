//! Roots of squares and of products: of what is known to be a size, be its factors positive or negative.

use super::run;
use chatter::analysis::simulate::Outcome;
use core::f64::consts::PI;

/// The integral of |sin u cos u|^p over a whole turn.
fn over_a_turn(p: f64) -> f64 {
    let half = PI.sqrt() * libm::tgamma((p + 1.0) / 2.0) / libm::tgamma(p / 2.0 + 1.0);
    2.0 * half * 2.0_f64.powf(-p)
}

/// Of x = a sin(w t) and y = b cos(w t), which are both negative a quarter of the time and change their signs in turn.
#[test]
fn roots_of_products_are_taken_of_two_negative_factors() {
    let forms: [(&str, f64, f64); 9] = [
        ("max(x*y, 0)^1.5", 1.5, 0.5),
        ("max(-x*y, 0)^0.7", 0.7, 0.5),
        ("sqrt(abs(x*y))", 0.5, 1.0),
        ("sqrt(max(x*y, 0))", 0.5, 0.5),
        ("sqrt(abs(x*y))*sign(x*y)", 0.5, 0.0),
        ("if(x*y > 0, (x*y)^1.5, -(-x*y)^1.5)", 1.5, 0.0),
        ("abs(0.2*q*x*y)^1.5", 1.5, 1.0),
        ("(x^2*y^2)^0.75", 1.5, 1.0),
        ("(max(x*y, 0)^3)^0.5", 1.5, 0.5),
    ];
    for (length, time) in [(1.0_f64, 1.0_f64), (1e-3, 17.0), (250.0, 3e-3)] {
        for (form, power, share) in forms {
            let text = format!(
                "[parameters]\nq = -5\n[flight]\nx = \"y/{time}\"\ny = \"-x/{time}\"\nz = \"{form}/{time}\"\n\
                 [initial]\nx = \"{length}*sin(0.4)\"\ny = \"{length}*cos(0.4)\"\nz = 0\n"
            );
            let run = run::<f64>(&text, 2.0 * PI * time);
            assert_eq!(run.outcome, Outcome::Horizon, "{form} {length} {time}");
            let unit = length.powf(2.0 * power);
            let right = share * over_a_turn(power);
            let error = (run.state[2] / unit - right).abs();
            assert!(error < 1e-13, "{form} {length} {time} {error}");
        }
    }
}

/// A product meets zero with one of its factors, and is told of as that.
#[test]
fn a_product_changes_its_sign_with_a_factor() {
    let text = "[flight]\nx = \"y\"\ny = \"-x\"\nz = \"max(x*y, 0)^1.5\"\n[initial]\nx = 0.6\ny = 0.8\nz = 0\n";
    let run = run::<f64>(text, 2.0 * PI);
    let first = 0.8_f64.atan2(0.6);
    assert_eq!(run.events.len(), 4);
    for (k, event) in (0_u8..).zip(&run.events) {
        let right = first + f64::from(k) * PI / 2.0;
        assert!((event.time - right).abs() < 1e-14, "{}", event.time);
    }
}

/// With nothing beside the square a root is a size: for x = sin t the integral of |x|^p over a turn.
#[test]
fn what_rounds_a_corner_off_may_be_nothing() {
    for (form, power) in [
        ("sqrt(x^2 + eps^2)", 1.0),
        ("hypot(x, eps*y)^1.5", 1.5),
        ("(x^2 + 3*eps^2*w)^0.25", 0.5),
        ("x*x/sqrt(x^2 + eps)", 1.0),
        ("x*tip/sqrt(x^2 + eps^2)", 1.0),
    ] {
        let text = format!(
            "[parameters]\neps = 0\nw = 1.7\n[definitions]\ntip = \"x\"\n[flight]\nx = \"y\"\ny = \"-x\"\nz = \"{form}\"\n\
             [initial]\nx = \"sin(0.4)\"\ny = \"cos(0.4)\"\nz = 0\n"
        );
        let run = run::<f64>(&text, 2.0 * PI);
        assert_eq!(run.outcome, Outcome::Horizon, "{form}");
        let right =
            2.0 * PI.sqrt() * libm::tgamma((power + 1.0) / 2.0) / libm::tgamma(power / 2.0 + 1.0);
        let error = (run.state[2] - right).abs();
        assert!(error < 1e-13, "{form} {error}");
    }
}

/// Friction that is rounded off by nothing is dry: a body comes to rest after v0/mu, and stays there.
#[test]
fn friction_rounded_off_by_nothing_is_dry() {
    let text = "[parameters]\neps = 0\nmu = 0.3\n[flight]\nx = \"v\"\nv = \"-mu*v/sqrt(v^2 + eps^2)\"\n[initial]\nx = 0\nv = 1.2\n";
    let run = run::<f64>(text, 7.0);
    assert_eq!(run.outcome, Outcome::Horizon);
    assert!((run.events[0].time - 4.0).abs() < 1e-14);
    assert!((run.state[0] - 2.4).abs() < 1e-14 && run.state[1] == 0.0);
}

/// Next to where a root begins the nearest zero is that of its argument, whatever else it drives: 1 + z^2 has none. The end is that of DOP853.
#[test]
fn what_a_root_drives_does_not_vanish_with_it() {
    let text = "[parameters]\nw = 1.601302755803478\nk = 0.8903841471045233\n[flight]\nx = \"v\"\nv = \"-x - 0.3*z/(1 + z*z)\"\ns = \"u\"\nu = \"-w*w*s\"\nz = \"k*sqrt(max(x*s, 0)) - z\"\n\
                [initial]\nx = 1.4988390153236273\nv = -0.838816158651575\ns = -0.4\nu = 1.601302755803478\nz = 0.1\n";
    let run = run::<f64>(text, 6.0);
    assert_eq!(run.outcome, Outcome::Horizon);
    let right = [
        1.508_919_275_1,
        -0.363_816_751_1,
        0.211_299_838_6,
        -1.691_139_758_5,
        0.780_124_337_9,
    ];
    for (found, right) in run.state.iter().zip(right) {
        assert!((found - right).abs() < 1e-8, "{found} {right}");
    }
}
