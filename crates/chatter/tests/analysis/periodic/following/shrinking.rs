//! Orbits that shrink to an equilibrium which lies on what they strike: where the linear motion between impacts grows by as much as these lose.

use crate::periodic::{over, value, with};
use chatter::analysis::periodic::{End, SpecialKind};

/// An oscillator with its wall where it rests, which strikes it once in half a turn.
fn oscillator(force: &str, gap: &str, place: f64) -> String {
    format!(
        "[parameters]\nb = 0.5\nr = 0.7\n[flight]\nx = \"v\"\nv = \"{force}\"\n[[contact]]\nname = \"wall\"\ngap = \"{gap}\"\n\
         impulse = {{ v = 1 }}\nrestitution = \"r\"\n[initial]\nx = {place}\nv = 0.5\n"
    )
}

/// Where r exp(b/2 pi/w) = 1 with the frequency w = sqrt(1 - b^2/4).
fn vanishes(r: f64) -> f64 {
    let slope = -r.ln() / core::f64::consts::PI;
    2.0 * slope / slope.hypot(1.0)
}

fn assert_shrinks(text: &str, (r, b, step): (&str, &str, f64), about: &str) {
    let found = over(
        &with(text, &[("r", r), ("b", b)]),
        "b",
        (0.005, 1.0),
        (4, step),
    );
    let [End::Shrunk(shrunk), End::Range] = &found[0].ends else {
        panic!("{about} from {b} by {step}: {:?}", found[0].ends);
    };
    let off = (shrunk.value - vanishes(r.parse().unwrap())).abs();
    assert!(
        off <= shrunk.error && shrunk.error < 3e-14,
        "{about} from {b} by {step}: {shrunk:?}"
    );
    let told = &found[0].special;
    let folds = told.iter().all(|special| {
        special.kind == SpecialKind::Fold && (value(special) - 0.0133576).abs() < 1e-6
    });
    assert!(folds, "{about}: {told:?}");
}

#[test]
fn an_orbit_shrinks_to_an_equilibrium_on_its_wall() {
    let rayleigh = oscillator("(b - v^2)*v - x", "x", 0.0);
    for (r, b, step) in [
        ("0.5", "0.5", 0.01),
        ("0.5", "0.9", 0.05),
        ("0.7", "0.5", 0.05),
        ("0.9", "0.9", 0.01),
        ("0.95", "0.5", 0.05),
    ] {
        assert_shrinks(&rayleigh, (r, b, step), r);
    }
}

/// Whatever is not linear: of a place, with a corner, of even powers, or against the losses; where the wall moves with the parameter; and where an
/// event with a reset stands for the wall.
#[test]
fn what_is_not_linear_is_no_matter_where_an_orbit_shrinks() {
    let forces = [
        ("(b - x^2)*v - x", "x", 0.0),
        ("(b - abs(v))*v - x", "x", 0.0),
        ("(b - x)*v - x", "x", 0.0),
        ("(b + v^2 - v^4)*v - x", "x", 0.0),
        ("(b - v^2)*v - (x - b)", "x - b", 1.0),
    ];
    let event = "[parameters]\nb = 0.5\nr = 0.7\n[flight]\nx = \"v\"\nv = \"(b - v^2)*v - x\"\n[[event]]\nname = \"kick\"\n\
        surface = \"x\"\ndirection = \"falling\"\nreset = { v = \"-r*v\" }\n[initial]\nx = 0\nv = 0.5\n";
    let walls = forces.map(|(force, gap, place)| oscillator(force, gap, place));
    for text in walls.iter().map(|text| &**text).chain([event]) {
        assert_shrinks(text, ("0.7", "0.6", 0.03), text);
    }
}
