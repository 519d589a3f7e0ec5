//! Where rest begins to last, or no longer does: the branch goes through from either side, at every step.

use crate::periodic::{over, value, with};
use chatter::analysis::periodic::{Branch, End, SpecialKind};

fn through(text: &str, name: &str, range: (f64, f64), (start, step): (&str, f64)) -> Branch {
    let mut found = over(&with(text, &[(name, start)]), name, range, (4, step));
    assert_eq!(found.len(), 1, "from {start} by {step}");
    let ends = &found[0].ends;
    assert_eq!(ends, &[End::Range, End::Range], "from {start} by {step}");
    found.remove(0)
}

/// A plastic impact is followed by rest where the force presses on, and else by flight: at omega = 2.0417898374475 that force is none, as a flight
/// that begins where cos(omega t) vanishes and is over after a period tells in closed form. Nothing is singular there.
#[test]
fn what_a_plastic_impact_leaves_is_rest_or_flight() {
    let text = "[parameters]\nomega = 2\n[flight]\nx = \"v\"\nv = \"cos(omega*t) - 0.1*v - x\"\n[[contact]]\nname = \"stop\"\n\
        gap = \"-x\"\nimpulse = { v = -1 }\nrestitution = 0\n[section.strobe]\nsurface = \"sin(omega*t)\"\ndirection = \"rising\"\n\
        [initial]\nx = -0.3\nv = 0\n";
    for start in ["2.03", "2.06"] {
        for step in [0.02, 0.2] {
            let branch = through(text, "omega", (2.02, 2.07), (start, step));
            let impacts = branch.points.iter().map(|point| point.impacts);
            assert!(impacts.clone().all(|impacts| impacts == Some(1)));
            assert!(branch.special.is_empty(), "{:?}", branch.special);
        }
    }
}

/// On a table that goes up and down by G g (period / 2 pi)^2 a ball rests up to G = 1.
#[test]
fn a_ball_rests_on_a_table_up_to_where_it_is_thrown() {
    let text = "[parameters]\ng = 9.81\nG = 1\nomega = \"20*pi\"\nA = \"G*g/omega^2\"\n[flight]\ny = \"v\"\nv = \"-g\"\n\
        [[contact]]\nname = \"table\"\ngap = \"y - A*sin(omega*t)\"\nimpulse = { v = 1 }\nrestitution = 0.5\n\
        [section.strobe]\nsurface = \"sin(omega*t)\"\ndirection = \"rising\"\n[initial]\ny = 0.02\nv = 0\n";
    for (start, step) in [("0.95", 0.2), ("1.02", 0.2), ("1.04", 0.1)] {
        let branch = through(text, "G", (0.9, 1.05), (start, step));
        let [touch] = &branch.special[..] else {
            panic!("from {start}: {:?}", branch.special);
        };
        assert_eq!(
            (touch.kind, touch.persists),
            (SpecialKind::Touch, Some(true))
        );
        assert!((value(touch) - 1.0).abs() <= touch.error, "{touch:?}");
        assert!(touch.error < 1e-13, "{touch:?}");
    }
}

/// A flight that begins with no rate, after a plastic impact, is a flight: where it touches the wall an impact comes in. By SciPy: the orbit that
/// leaves the wall at rest, comes back after 2 pi and touches it between.
#[test]
fn a_flight_from_a_plastic_impact_touches() {
    let text = "[parameters]\nA = 1\n[flight]\nth = \"w\"\nw = \"-0.1*w - (1 + A*cos(2*t))*sin(th)\"\n[[contact]]\nname = \"wall\"\n\
        gap = \"th + 0.3\"\nimpulse = { w = 1 }\nrestitution = 0\n[section.strobe]\nsurface = \"sin(2*t)\"\ndirection = \"rising\"\n\
        [initial]\nth = 0.5\nw = 0.1\n";
    for (start, step) in [("1.295", 0.2), ("1.305", 0.2), ("1.298", 0.05)] {
        let branch = through(text, "A", (1.29, 1.31), (start, step));
        let graze = branch
            .special
            .iter()
            .find(|special| special.kind.is_graze());
        let graze = graze.unwrap();
        assert_eq!(graze.persists, Some(false));
        assert!(
            (value(graze) - 1.299_689_291_675_152_1).abs() < 1e-13,
            "from {start}: {graze:?}"
        );
    }
}

/// What a plastic impact leaves flies on for a while and lands again, or rests at once: the flight comes to nothing where the force of that rest
/// vanishes as it begins. For an oscillator in closed form: A cos(omega t) = -1/2 at the release, where the flight to the impact begins, and again
/// where that ends. For two masses by an integration with 24 digits: the orbit on which the coupling is without a force at the impact and the release.
#[test]
fn a_flight_from_rest_comes_to_nothing() {
    let oscillator = "[parameters]\nA = 1\n[flight]\nx = \"v\"\nv = \"A*cos(0.8*t) - 0.1*v - x\"\n[[contact]]\nname = \"wall\"\n\
        gap = \"x + 0.5\"\nimpulse = { v = 1 }\nrestitution = 0\n[section.strobe]\nsurface = \"sin(0.8*t)\"\ndirection = \"rising\"\n\
        [initial]\nx = 0.5\nv = 0.1\n";
    let masses = "[parameters]\nA = 1\n[flight]\nx = \"v\"\nv = \"2*(y - x) - 0.1*v - x\"\ny = \"u\"\n\
        u = \"A*cos(0.6*t) - 0.1*u - 2*(y - x)\"\n[[contact]]\nname = \"stop\"\ngap = \"x + 0.1\"\nimpulse = { v = 1 }\n\
        restitution = 0\n[section.strobe]\nsurface = \"sin(0.6*t)\"\ndirection = \"rising\"\n[initial]\nx = 0.5\nv = 0.1\ny = 0\nu = 0\n";
    let (of_one, of_two) = (0.581_724_245_189_851_4, 0.054_693_446_014_842_54);
    for (text, range, start, step, exact) in [
        (oscillator, (0.55, 0.7), "0.57", 0.02, of_one),
        (oscillator, (0.55, 0.7), "0.57", 0.2, of_one),
        (oscillator, (0.55, 0.7), "0.6", 0.02, of_one),
        (oscillator, (0.55, 0.7), "0.65", 0.2, of_one),
        (masses, (0.045, 0.07), "0.05", 0.1, of_two),
        (masses, (0.045, 0.07), "0.06", 0.03, of_two),
    ] {
        let branch = through(text, "A", range, (start, step));
        let [touch] = &branch.special[..] else {
            panic!("from {start} by {step}: {:?}", branch.special);
        };
        assert_eq!(
            (touch.kind, touch.persists),
            (SpecialKind::Touch, Some(true))
        );
        let off = (value(touch) - exact).abs();
        assert!(off <= touch.error && touch.error < 1e-14, "{touch:?}");
    }
}

/// A relay whose orbit, its own mirror image, begins to slide along the switching line at two places at once.
#[test]
fn a_relay_begins_to_slide_at_two_places_at_once() {
    let text = "[parameters]\nA = 1.2\n[flight]\nx = \"v\"\nv = \"-x - 0.3*v - sign(x + 0.2*v) + A*cos(2*t)\"\n\
        [section.strobe]\nsurface = \"sin(2*t)\"\ndirection = \"rising\"\n[initial]\nx = 0.4\nv = 0\n";
    let told = |branch: &Branch| {
        let mut all: Vec<_> = branch
            .special
            .iter()
            .map(|s| (s.kind.name(), value(s), s.error, s.persists))
            .collect();
        all.sort_by(|a, b| a.1.total_cmp(&b.1));
        all
    };
    let branches = [("1.23", 0.2), ("1.226", 0.2), ("0.9", 0.1)]
        .map(|(start, step)| told(&through(text, "A", (0.78, 1.24), (start, step))));
    for other in &branches[1..] {
        assert_eq!(other.len(), branches[0].len(), "{branches:?}");
        for (a, b) in branches[0].iter().zip(other) {
            assert_eq!((a.0, a.3), (b.0, b.3), "{branches:?}");
            assert!((a.1 - b.1).abs() <= a.2 + b.2, "{branches:?}");
        }
    }
    assert_eq!(branches[0].len(), 4, "{branches:?}");
}

/// The guide of a cam's follower rubs it. At the top friction turns, and the force on the cam jumps by 2 f down, to 2 k e + P - f - e omega^2, which
/// vanishes at the square root of 77: beyond, the follower lifts off just there.
#[test]
fn a_contact_opens_just_where_friction_turns() {
    let text = "[parameters]\nom = 8.5\n[flight]\nx = \"v\"\nv = \"-20*x - 20 - 1.5*sign(v)\"\n[[contact]]\nname = \"cam\"\n\
        gap = \"x - 0.5*(1 - cos(om*t))\"\nimpulse = { v = 1 }\nrestitution = 0.4\n[section.s]\nsurface = \"sin(om*t)\"\ndirection = \"rising\"\n\
        [initial]\nx = 2\nv = 0\n";
    let slow = [("8.5", 0.02), ("8.5", 0.1), ("8.9", 0.02), ("8.9", 0.1)].map(|how| (9.0, how));
    // By long steps flights come to nothing but for rounding.
    let all = slow.into_iter().chain([(9.1, ("9.05", 0.3))]);
    for (high, (start, step)) in all {
        let branch = through(text, "om", (8.4, high), (start, step));
        let [touch] = &branch.special[..] else {
            panic!("from {start}: {:?}", branch.special);
        };
        assert_eq!(touch.kind, SpecialKind::Touch);
        assert!(
            (value(touch) - 77.0_f64.sqrt()).abs() <= touch.error,
            "{touch:?}"
        );
        assert!(touch.error < 1e-13, "{touch:?}");
    }
}

/// Faster still it is released on the way up, and friction turns in flight. That begins where the force just before the top, 2 k e + P + f - e omega^2,
/// vanishes: at the square root of 83, be it least there or, with a damper in the guide, on its way to less. For a cam with a second harmonic by
/// mpmath: the force where the cam's slope vanishes.
#[test]
fn a_contact_is_released_before_friction_turns() {
    let text = |cam: &str, drag: &str| {
        format!(
            "[parameters]\nom = 9\n[flight]\nx = \"v\"\nv = \"-20*x - 20 - 1.5*sign(v){drag}\"\n[[contact]]\nname = \"cam\"\n\
            gap = \"x - 0.5*(1 - cos(om*t)){cam}\"\nimpulse = {{ v = 1 }}\nrestitution = 0.4\n[section.s]\nsurface = \"sin(om*t)\"\n\
            direction = \"rising\"\n[initial]\nx = 2\nv = 0\n"
        )
    };
    let least = (text("", ""), 83.0_f64.sqrt());
    let falling = (text("", " - 0.5*v"), 83.0_f64.sqrt());
    let skew = (text(" - 0.02*sin(2*om*t)", ""), 9.014_954_180_793_579);
    for (text, exact) in [least, falling, skew] {
        for (start, step) in [("9", 0.02), ("9", 0.3), ("9.2", 0.02), ("9.2", 0.3)] {
            let branch = through(&text, "om", (8.95, 9.25), (start, step));
            let [touch] = &branch.special[..] else {
                panic!("from {start}: {:?}", branch.special);
            };
            assert_eq!(
                (touch.kind, touch.persists),
                (SpecialKind::Touch, Some(true))
            );
            assert!((value(touch) - exact).abs() <= touch.error, "{touch:?}");
            assert!(touch.error < 1e-13, "{touch:?}");
        }
    }
}

/// A ball that is thrown where the table goes down faster than it falls flies a way that is its own mirror image, and lands at rest where its phase is
/// 3 pi less that of the release: at G = sqrt(1 + x^2) with tan x = x. Before and after its first impact is slow, as the cube root of the distance squared.
#[test]
fn a_ball_lands_at_rest() {
    let text = "[parameters]\ng = 9.81\nG = 4.6\nomega = \"20*pi\"\nA = \"G*g/omega^2\"\n[flight]\ny = \"v\"\nv = \"-g\"\n\
        [[contact]]\nname = \"table\"\ngap = \"y - A*sin(omega*t)\"\nimpulse = { v = 1 }\nrestitution = 0.5\n\
        [section.strobe]\nsurface = \"sin(omega*t)\"\ndirection = \"rising\"\n[initial]\ny = 0.02\nv = 0\n";
    let x = 4.493_409_457_909_064_f64;
    let soft = (1.0 + x * x).sqrt();
    for (start, step) in [("4.598", 0.05), ("4.6", 0.2), ("4.61", 0.05), ("4.62", 0.2)] {
        let branch = through(text, "G", (4.59, 4.63), (start, step));
        assert!(
            branch.special.is_empty(),
            "from {start}: {:?}",
            branch.special
        );
        let near = |side: f64| {
            let all = branch
                .points
                .iter()
                .map(|point| side * (point.parameter() - soft));
            all.filter(|off| *off > 0.0).fold(f64::INFINITY, f64::min)
        };
        assert!(near(1.0) < 0.02 && near(-1.0) < 0.02, "from {start}");
    }
}
