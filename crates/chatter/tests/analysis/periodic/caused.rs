//! Events that come because a jump, of an impact or of another event, has taken the state across their surfaces.

use super::{Branch, Orbit, SpecialKind, orbit, over, with};
use chatter::analysis::periodic::End;
use chatter::numerics::Real;

/// A clock of period 1 adds J to b, which decays to d between; where that lifts b over 0.9, it is multiplied by c at once.
const LIFTED: &str = r#"
[parameters]
c = 0.5
J = 1
d = 0.5
[flight]
a = "1"
b = "d - b"
[[event]]
name = "tick"
surface = "a - 1"
direction = "rising"
reset = { a = 0, b = "b + J" }
[[event]]
name = "fire"
surface = "b - 0.9"
direction = "rising"
reset = { b = "c*b" }
[initial]
a = 0
b = 0.1
"#;

fn close_to(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-13
}

#[test]
fn an_event_that_another_brings_about_takes_no_time() {
    let decay = (-1.0_f64).exp();
    for c in [0.5, 0.2] {
        let found = orbit(&with(LIFTED, &[("c", &c.to_string())]));
        // b = c (d + (b - d)/e + J) just after, and a displacement of b is multiplied by c/e.
        let after = c * (1.5 - 0.5 * decay) / (1.0 - c * decay);
        assert!(
            close_to(found.start[1].to_f64(), after),
            "{:?}",
            found.start
        );
        assert!(close_to(found.multipliers[0].re, c * decay));
        assert_eq!(found.multipliers.len(), 1);
        assert!(close_to(found.trivial_multiplier.unwrap(), 1.0));
    }
}

#[test]
fn two_neurons_of_which_the_first_fires_the_second_forget_all() {
    let text = r#"
[flight]
a = "1.3 - a"
b = "1.17 - b"
[[event]]
name = "first"
surface = "a - 1"
direction = "rising"
reset = { a = 0, b = "b + 0.2" }
[[event]]
name = "second"
surface = "b - 1"
direction = "rising"
reset = { b = 0 }
[initial]
a = 0.1
b = 0.1
"#;
    let found = orbit(&with(text, &[]));
    assert!(close_to(found.period.to_f64(), (1.3_f64 / 0.3).ln()));
    assert_eq!(found.multipliers[0].re, 0.0);
}

/// A ball on a shaking table, whose impacts take its velocity to the other side of zero.
fn ball(event: &str, set: &[(&str, &str)]) -> Orbit {
    let text = format!(
        r#"
[parameters]
G = 2
r = 0.4
[flight]
x = "v"
v = "-1"
n = "0"
[[contact]]
name = "table"
gap = "x - G*sin(t)"
impulse = {{ v = 1 }}
restitution = "r"
{event}
[section.turn]
surface = "sin(t)"
direction = "rising"
[initial]
x = 2
v = 0
n = 0
"#
    );
    orbit(&with(&text, set))
}

fn reset(what: &str) -> String {
    format!(
        "[[event]]\nname = \"up\"\nsurface = \"v\"\ndirection = \"rising\"\nreset = {{ {what} }}"
    )
}

#[test]
fn rebounds_are_counted_without_a_change_of_the_orbit() {
    let set = [("r", "0.3")];
    let (plain, counted) = (ball("", &set), ball(&reset("n = \"n + 1\""), &set));
    assert_eq!(plain.impacts, counted.impacts);
    for (a, b) in plain.multipliers.iter().zip(&counted.multipliers) {
        assert!((a.re - b.re).hypot(a.im - b.im) < 1e-12, "{a:?} {b:?}");
    }
    assert!(close_to(plain.start[1].to_f64(), counted.start[1].to_f64()));
}

#[test]
fn a_loss_that_impacts_bring_about_multiplies_their_restitution() {
    // The table is at its velocity v_t: v - v_t is restituted, and then v is multiplied. Differences of the map from table to table.
    let found = ball(&reset("v = \"0.8*v\""), &[("r", "0.5")]);
    assert_eq!(found.impacts, Some(1));
    let [t, v] = impact_of_the_period();
    let h = 1e-6;
    let column = |dt: f64, dv: f64| {
        let (up, down) = (next([t + dt, v + dv]), next([t - dt, v - dv]));
        [0, 1].map(|i| (up[i] - down[i]) / (2.0 * h))
    };
    let (by_t, by_v) = (column(h, 0.0), column(0.0, h));
    let (trace, det) = (by_t[0] + by_v[1], by_t[0] * by_v[1] - by_t[1] * by_v[0]);
    let [one, other] = [found.multipliers[0], found.multipliers[1]];
    assert!(
        (one.re + other.re - trace).abs() < 1e-7,
        "{one:?} {other:?} {trace}"
    );
    assert!((one.re * other.re - one.im * other.im - det).abs() < 1e-7);
}

/// From one impact on the table x = 2 sin t, with the velocity after it and its event, to the next.
fn next([t, v]: [f64; 2]) -> [f64; 2] {
    let gap = |s: f64| 2.0 * t.sin() + v * s - 0.5 * s * s - 2.0 * (t + s).sin();
    let slope = |s: f64| v - s - 2.0 * (t + s).cos();
    // It leaves faster than the table: the last root is where it falls for good.
    let mut s = 2.0 * v + 4.0;
    for _ in 0..60 {
        s -= gap(s) / slope(s);
    }
    let table = 2.0 * (t + s).cos();
    let after = table - 0.5 * (v - s - table);
    [t + s, 0.8 * after]
}

/// The fixed point of the map, up to a period: v is pi.
fn impact_of_the_period() -> [f64; 2] {
    // After the event v = pi, as the flight takes a period; v = 0.8 (v_t + 0.5 (pi + v_t)).
    let table = (core::f64::consts::PI / 0.8 - 0.5 * core::f64::consts::PI) / 1.5;
    [(table / 2.0).acos(), core::f64::consts::PI]
}

fn lifted(direction: &str, set: &[(&str, &str)], range: (f64, f64), step: f64) -> Vec<Branch> {
    let text = LIFTED.replace("\"rising\"", direction);
    over(&with(&text, set), "J", range, (8, step))
}

#[test]
fn a_branch_ends_where_the_jump_leads_just_onto_the_surface() {
    // Before the event b is d + (b - d)/e + J = 0.9 with b = 0.9 c after the one before.
    let touch = 0.4 + 0.05 * (-1.0_f64).exp();
    for direction in ["\"rising\"", "\"either\""] {
        for step in [0.01, 0.04] {
            let all = lifted(direction, &[], (0.1, 1.0), step);
            let [told] = &*all[0].special else {
                panic!("{:?}", all[0].special)
            };
            assert_eq!(told.kind, SpecialKind::Touch);
            assert!((told.point.parameter() - touch).abs() < 1e-12);
            let ends = all[0].ends.iter().map(ToString::to_string);
            assert!(ends.into_iter().any(|end| end.contains("no longer cross")));
        }
    }
}

/// A clock throws a ball, which has chattered to rest, at its floor, as fast as a third state says, which it changes, too: at the instant of the throw it
/// bounces, by drag of another law where it is faster than a half, and that state alone is remembered.
#[test]
fn a_throw_at_the_floor_bounces_at_once() {
    for (unit, length) in [(1e-3, 1.0), (1.0, 1e3), (1e3, 1e-3)] {
        for drag in ["0", "0.2*sign(v/L + 0.5)", "0.05*abs(v/L)*v/L"] {
            let text = format!(
                "[flight]\ny = 'v/{unit:?}'\nv = '-{length:?}*(1 + {})/{unit:?}'\nz = '-0.3*z/{unit:?}'\nc = '1/{unit:?}'\n\
                 [[contact]]\nname = 'floor'\ngap = 'y'\nimpulse = {{ v = 1 }}\nrestitution = 0.5\n\
                 [[event]]\nname = 'throw'\nsurface = 'c - 5'\ndirection = 'rising'\n\
                 reset = {{ c = 0, v = '-{length:?}*(1 + z)', z = '0.5*z + 0.2' }}\n[initial]\ny = {length:?}\nv = 0\nz = 0.1\nc = 0\n",
                drag.replace('L', &format!("{length:?}"))
            );
            let found = orbit(&with(&text, &[]));
            assert_eq!(found.impacts, None);
            assert!(close_to(found.period.to_f64() / unit / 5.0, 1.0));
            let kept = (-1.5_f64).exp();
            let after = 0.2 / (1.0 - 0.5 * kept);
            let start: Vec<f64> = found.start.iter().map(|x| x.to_f64()).collect();
            assert!(close_to(start[2], after), "{start:?}");
            let bounces = 0.5 * (1.0 + kept * after);
            assert!(close_to(start[1] / length, bounces), "{start:?}");
            let multipliers: Vec<f64> = found.multipliers.iter().map(|m| m.re).collect();
            assert_eq!(multipliers.len(), 3);
            assert!(close_to(multipliers[0], 0.5 * kept), "{multipliers:?}");
            assert!(multipliers[1..].iter().all(|&m| m == 0.0));
        }
    }
}

/// A ball is caught as it falls through h, and thrown at the floor, faster by k: it bounces with r (k + s) where it fell with s = (v^2 - 2 g h)^(1/2), and a
/// displacement of v is multiplied by r v/s.
#[test]
fn an_event_that_puts_a_body_on_the_floor_may_throw_it_there() {
    let (r, k, h) = (0.5_f64, 2.0, 0.3);
    for (unit, length) in [(1e-3, 1.0), (1.0, 1.0), (1e3, 1e-3)] {
        let text = format!(
            "[flight]\ny = 'v/{unit:?}'\nv = '-{length:?}/{unit:?}'\n[[contact]]\nname = 'floor'\ngap = 'y'\nimpulse = {{ v = 1 }}\n\
             restitution = {r:?}\n[[event]]\nname = 'put'\nsurface = 'y - {h:?}*{length:?}'\ndirection = 'falling'\n\
             reset = {{ y = 0, v = 'v - {k:?}*{length:?}' }}\n[initial]\ny = '0.5*{length:?}'\nv = {length:?}\n"
        );
        let found = orbit(&with(&text, &[]));
        let root = r * (r * r * k * k - (1.0 - r * r) * 2.0 * h).sqrt();
        let v = (r * k + root) / (1.0 - r * r);
        let s = v / r - k;
        assert!(close_to(found.period.to_f64() / unit, v + s));
        assert_eq!(found.impacts, Some(1));
        assert!(close_to(found.start[1].to_f64() / length, v), "{v}");
        assert_eq!(found.multipliers.len(), 1);
        assert!(close_to(found.multipliers[0].re, r * v / s));
    }
}

/// Thrown by a clock, s at a time, a ball comes to rest after 2 s / g: not before it is thrown again where that is the clock's period, 5. Beyond,
/// chatter may come to its end only after some throws more, and no such way is taken for the orbit's.
#[test]
fn a_border_has_the_period_of_its_orbit() {
    for unit in [1e-3, 1.0, 1e3] {
        let text = format!(
            "[parameters]\ns = 1\n[flight]\ny = 'v/{unit:?}'\nv = '-1/{unit:?}'\nc = '1/{unit:?}'\n[[contact]]\nname = 'floor'\n\
             gap = 'y'\nimpulse = {{ v = 1 }}\nrestitution = 0.5\n[[event]]\nname = 'throw'\nsurface = 'c - 5'\n\
             direction = 'rising'\nreset = {{ c = 0, v = '-s' }}\n[initial]\ny = 1\nv = 0\nc = 0\n"
        );
        let branches = over(&with(&text, &[]), "s", (0.5, 4.0), (8, 0.02));
        let branch = &branches[0];
        let mut all = branch.points.iter();
        assert!(
            all.all(|point| (point.period / unit - 5.0).abs() < 1e-9 && point.parameter() < 2.5)
        );
        assert_eq!(branch.ends, [End::Range, End::ChatterBorder]);
        let [border] = &branch.special[..] else {
            panic!("{:?}", branch.special);
        };
        assert_eq!(border.kind, SpecialKind::ChatterBorder);
        assert!(
            (border.point.period / unit - 5.0).abs() < 1e-9,
            "{}",
            border.point.period
        );
        assert!((border.point.parameter() - 2.5).abs() < border.error.min(1e-3));
    }
}

/// A follower that rests on its cam as an event turns the cam's angle back: in doubles rounding lets it bounce there, with rates of 1e-16, and in numbers
/// of thirty digits it does not. Either way it is released at the cam's next rise, once a turn.
#[test]
fn chatter_that_is_rounding_ends_where_what_rests_is_released() {
    let text = "[flight]\ny = 'v'\nv = '-400*y - 20'\nth = 30\n[[contact]]\nname = 'cam'\n\
                gap = 'y - 0.01*if(th < 1.5, sin(pi*th/1.5)^2, 0)'\nimpulse = { v = 1 }\nrestitution = 0.3\n\
                [[event]]\nname = 'turn'\nsurface = 'th - 2*pi'\ndirection = 'rising'\nreset = { th = 'th - 2*pi' }\n\
                [initial]\ny = 0.03\nv = 0\nth = 0.5\n";
    let found = orbit(&with(text, &[]));
    let period = core::f64::consts::TAU / 30.0;
    assert!(close_to(found.period.to_f64(), period));
    assert!(found.residual < 1e-20);
    assert!(found.multipliers.iter().all(|m| m.modulus() == 0.0));
    for margin in &found.margins {
        assert!((0.0..=1.001 * period).contains(&margin.time), "{margin:?}");
    }
}
