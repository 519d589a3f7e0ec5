//! Sticks of an orbit that begin at once with a force that friction just holds.

use crate::periodic::{model, orbit, over, value, with};
use chatter::analysis::periodic::{Branch, End, SpecialKind};
use chatter::numerics::Real;
use core::f64::consts::PI;

/// The one branch, with touches at these values and no other special points, from end to end of its range.
fn goes_through(found: &[Branch], touches: &[f64], (low, high): (f64, f64), from: &str) {
    let [branch] = found else {
        panic!("from {from}: {}", found.len());
    };
    assert_eq!(branch.ends, [End::Range, End::Range], "from {from}");
    let [first, last] = [branch.points.first(), branch.points.last()]
        .map(|point| point.map_or(f64::NAN, |point| point.parameter()));
    assert!(
        (first - low).abs() < 1e-12 && (last - high).abs() < 1e-12,
        "from {from}: {first} to {last}"
    );
    assert_eq!(branch.special.len(), touches.len(), "from {from}");
    for (touch, expected) in branch.special.iter().zip(touches) {
        assert_eq!(touch.kind, SpecialKind::Touch, "from {from}");
        let off = (value(touch) - expected).abs();
        assert!(off < 1e-15, "from {from}: {off:e}");
        assert!(touch.error < 1e-14, "from {from}: {:e}", touch.error);
        assert_eq!(touch.persists, Some(true), "from {from}");
    }
}

/// Where the slip lasts 2 pi the mass comes to rest with just the force that it was released by: sin(pi w) = f (1 - w^2)/w^2, to where the orbit
/// is its own mirror image. Displacements come back there as they went, and the equations are singular.
fn holds_just(friction: f64, (mut low, mut high): (f64, f64)) -> f64 {
    let off = |w: f64| (PI * w).sin() - friction * (1.0 - w * w) / (w * w);
    while high - low > f64::EPSILON * high {
        let middle = 0.5 * (low + high);
        match off(middle) < 0.0 {
            true => low = middle,
            false => high = middle,
        }
    }
    0.5 * (low + high)
}

/// Where the stick after the slip that comes in there is over: closed forms of the pieces, by another Newton's method in 25 digits.
const STICK_OVER: f64 = 0.481_478_247_015_290_4;

#[test]
fn sticks_of_both_halves_of_an_orbit_begin_where_friction_just_holds() {
    let just = holds_just(0.3, (0.45, 0.5));
    let touches = [just, STICK_OVER];
    for (start, step) in [
        ("0.47", 0.01),
        ("0.47", 0.002),
        ("0.49", 0.01),
        ("0.52", 0.003),
        ("0.6", 0.02),
    ] {
        let model = model("forced_coulomb_oscillator", &[("omega", start)]);
        let found = over(&model, "omega", (0.45, 0.6), (4, step));
        goes_through(&found, &touches, (0.45, 0.6), start);
    }
    // However near steps come to there.
    for (start, range) in [("0.4803", (0.48, 0.481)), ("0.481", (0.48, 0.481))] {
        let model = model("forced_coulomb_oscillator", &[("omega", start)]);
        let found = over(&model, "omega", range, (4, 0.01));
        goes_through(&found, &touches[..1], range, start);
    }
    for (friction, start, range) in [
        ("0.15", "0.36", (0.36, 0.39)),
        ("0.15", "0.39", (0.36, 0.39)),
    ] {
        let set = [("omega", start), ("friction", friction)];
        let model = model("forced_coulomb_oscillator", &set);
        let found = over(&model, "omega", range, (4, 0.01));
        let expected = holds_just(friction.parse().unwrap(), range);
        goes_through(&found, &[expected], range, start);
    }
}

/// With a damper displacements shrink, and each half by itself says where that is. (The closed form of the slip, its symmetry and the force at its
/// end, in 25 digits.)
#[test]
fn sticks_begin_where_friction_just_holds_beside_a_damper() {
    let text = "[parameters]\nomega = 0.47\nc = 0.02\n[flight]\nx = 'v'\nv = 'cos(omega*t) - x - c*v - 0.3*sign(v)'\n\
        [section.turning]\nsurface = 'v'\ndirection = 'falling'\n[initial]\nx = 1\nv = 0\n";
    for (start, c, expected, range) in [
        ("0.482", "0.02", 0.486_632_130_607_462_2, (0.48, 0.4867)),
        ("0.4867", "0.02", 0.486_632_130_607_462_2, (0.48, 0.4867)),
        ("0.48", "0.001", 0.481_029_308_911_287_2, (0.48, 0.4815)),
    ] {
        let model = with(text, &[("omega", start), ("c", c)]);
        let found = over(&model, "omega", range, (4, 0.02));
        goes_through(&found, &[expected], range, start);
    }
}

/// Where a motion settles slowly it may stick where that which it settles to slips on: what it is closed from is then no motion. (Places where the
/// symmetric orbit turns by the closed form of the pieces, in 25 digits.)
#[test]
fn what_sticks_too_long_is_no_orbit() {
    for (omega, expected) in [
        ("0.4808", 1.298_309_925_215_77),
        ("0.48078", 1.298_272_521_494_11),
    ] {
        let found = orbit(&model("forced_coulomb_oscillator", &[("omega", omega)]));
        let (x, v) = (found.start[0].to_f64(), found.start[1].to_f64());
        assert!((x.abs() - expected).abs() < 1e-13 && v == 0.0, "{x} {v}");
    }
}

/// A mass with dry friction in a shaken box, whose orbit is its own mirror image. (Where the rate against the box comes back to zero with the force that
/// friction just holds: the closed form of the flight between both walls, in 30 digits.)
#[test]
fn an_orbit_that_is_its_own_mirror_image_sticks_on_both_ways() {
    let text = "[parameters]\nA = 1.25\nw = 0.9395\nh = 1.2413\n[flight]\ny = 'u'\nu = '-0.4161*sign(u - A*w*cos(w*t))'\n\
        [[contact]]\nname = 'right'\ngap = 'A*sin(w*t) + h - y'\nimpulse = { u = -1 }\nrestitution = 0.4142\n\
        [[contact]]\nname = 'left'\ngap = 'y - A*sin(w*t) + h'\nimpulse = { u = 1 }\nrestitution = 0.4142\n\
        [section.strobe]\nsurface = 'sin(w*t)'\ndirection = 'rising'\n[initial]\ny = 0\nu = 0.5\n";
    let expected = 1.996_154_245_232_24;
    for (start, step) in [("1.25", 0.02), ("1.25", 0.1), ("2.03", 0.02)] {
        let found = over(&with(text, &[("A", start)]), "A", (1.25, 2.03), (4, step));
        let branch = &found[0];
        assert_eq!(branch.ends, [End::Range, End::Range], "from {start}");
        let touches = { branch.special.iter() }.filter(|told| told.kind == SpecialKind::Touch);
        let [touch] = &touches.collect::<Vec<_>>()[..] else {
            panic!("from {start}: {:?}", branch.special);
        };
        assert!((value(touch) - expected).abs() < 1e-14, "from {start}");
        assert_eq!(touch.persists, Some(true), "from {start}");
    }
}
