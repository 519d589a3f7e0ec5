//! Branches are the same whatever the steps that they are followed by, and wherever they begin.

use crate::periodic::{GRAZES, nearest, over, value, with};
use chatter::analysis::periodic::{End, Point, SpecialKind};

/// A follower leaves its cam and comes back with chatter: over omega the contact begins to open, chatter grows, ends at a border, and impacts are
/// lost one by one. None of that depends on where one starts and on how long steps are.
#[test]
#[ignore = "takes ten seconds"]
fn a_follower_on_a_cam_is_followed_whatever_the_step() {
    let follower = |omega: &str| {
        let text = r#"
[parameters]
w = 3.1
[flight]
y = "v"
v = "-1 - 2*y - 0.05*v"
[[contact]]
name = "cam"
gap = "y - 0.3*(1 - cos(w*t)) - 0.03*sin(2*w*t)"
impulse = { v = 1 }
restitution = 0.35
[initial]
y = 0.4
v = 0
"#;
        with(text, &[("w", omega)])
    };
    let specials = |omega: &str, step: f64| -> Vec<(SpecialKind, f64)> {
        let found = over(&follower(omega), "w", (2.3, 4.0), (40, step));
        let all = found.iter().flat_map(|branch| &branch.special);
        let mut all: Vec<_> = all.map(|special| (special.kind, value(special))).collect();
        all.sort_by(|a, b| a.1.total_cmp(&b.1));
        all
    };
    let first = specials("3.1", 0.02);
    let of = |kind: SpecialKind| first.iter().filter(|(other, _)| *other == kind).count();
    assert_eq!(
        (of(SpecialKind::Touch), of(SpecialKind::ChatterBorder)),
        (1, 1)
    );
    assert!(of(SpecialKind::PeriodDoubling) > 8, "{first:?}");
    for (omega, step) in [("3.1", 0.05), ("2.35", 0.02), ("3.946", 0.02)] {
        let other = specials(omega, step);
        assert_eq!(first.len(), other.len(), "{first:?} {other:?}");
        for (a, b) in first.iter().zip(&other) {
            assert!(a.0 == b.0 && (a.1 - b.1).abs() < 1e-8, "{a:?} {b:?}");
        }
    }
    // At the touch the cam's own acceleration is that of the free follower, to where that no longer holds it down.
    let touch = first[0].1;
    let force = |w: f64| {
        let least = |k: u32| {
            let p = f64::from(k) * 1e-6 * core::f64::consts::TAU;
            let y = 0.3 * (1.0 - p.cos()) + 0.03 * (2.0 * p).sin();
            let v = w * (0.3 * p.sin() + 0.06 * (2.0 * p).cos());
            let a = w * w * (0.3 * p.cos() - 0.12 * (2.0 * p).sin());
            a + 1.0 + 2.0 * y + 0.05 * v
        };
        (0..1_000_000).map(least).fold(f64::INFINITY, f64::min)
    };
    assert!(force(touch).abs() < 1e-9, "{}", force(touch));
}

/// A gear within its play: a branch of doubled orbits turns where it meets the simple one, and ends where both halves of its orbit graze,
/// since from there on it would go around the simple one twice.
#[test]
fn a_doubled_branch_ends_at_the_graze_of_the_simple_one() {
    let text = r#"
[parameters]
A = 1.2
[flight]
u = "s"
s = "0.3 - 0.15*s + A*cos(1.3*t)"
[[contact]]
name = "drive"
gap = "0.5 - u"
impulse = { s = -1 }
restitution = 0.65
[[contact]]
name = "coast"
gap = "u + 0.5"
impulse = { s = 1 }
restitution = 0.65
[initial]
u = 0
s = 0
"#;
    for step in [0.02, 0.007, 0.05] {
        let found = over(&with(text, &[]), "A", (0.6, 2.0), (40, step));
        assert_eq!(found.len(), 1);
        let ends = &found[0].ends;
        let (parts, grazes) = (SpecialKind::BranchPoint, SpecialKind::FlightGraze);
        assert_eq!(*ends, [End::Again(parts), End::Again(grazes)], "{step}");
        let parts = nearest(&found, &[parts], 1.1148);
        assert!((value(&parts) - 1.114_845_214_256_72).abs() < 1e-12);
        assert!(parts.error < 1e-12);
    }
}

/// Where what is slid along begins to hold at once, after a crossing: the rate beyond vanishes as the surface is met.
#[test]
fn sliding_that_begins_is_known_to_rounding() {
    let text = r#"
[parameters]
F = 1.4
[flight]
x = "v"
v = "-x - 0.4*sign(v - 0.3) + F*cos(0.8*t)"
[[contact]]
name = "stop"
gap = "0.7 - x"
impulse = { v = -1 }
restitution = 0.5
[initial]
x = 0
v = 0
"#;
    let touch = |force: &str, step: f64| {
        let found = over(&with(text, &[("F", force)]), "F", (1.35, 1.5), (40, step));
        value(&nearest(&found, &[SpecialKind::Touch], 1.3639))
    };
    let known = touch("1.4", 0.02);
    for (force, step) in [("1.4", 0.007), ("1.45", 0.05)] {
        assert!((touch(force, step) - known).abs() < 1e-12);
    }
}

/// A mass free in the slot of a forced oscillator. Beside a fold two real multipliers meet and pass the circle as a pair, all within one
/// long step.
#[test]
fn a_pair_that_comes_about_within_a_step_passes_the_circle() {
    let text = r#"
[parameters]
om = 1.084
[flight]
x = "u"
u = "0.3*cos(om*t) - 0.04*u - x"
y = "w"
w = "-0.01*(w - u)"
[[contact]]
name = "left"
gap = "y - x + 1"
impulse = { w = 1, u = -0.1 }
restitution = 0.6
[[contact]]
name = "right"
gap = "1 - y + x"
impulse = { w = -1, u = 0.1 }
restitution = 0.6
[section.s]
surface = "sin(om*t)"
direction = "rising"
[initial]
x = 0.2
u = 0
y = 0
w = 0.5
"#;
    for step in [0.1, 0.8, 0.9] {
        let found = over(&with(text, &[]), "om", (1.05, 1.1), (40, step));
        let tori = (found[0].special.iter())
            .filter(|special| special.kind == SpecialKind::NeimarkSacker)
            .map(value);
        let tori: Vec<f64> = tori.collect();
        assert!(
            matches!(tori[..], [at] if (at - 1.080_576_459_541_752).abs() < 1e-13),
            "{step}: {tori:?}"
        );
    }
}

/// Gears with backlash under a mean load: by shooting with SciPy their branch folds at w = 0.70299451. A range that ends just before is left
/// there, and not passed from one station to the next by way of the fold.
#[test]
fn a_fold_beyond_the_range_is_not_gone_around() {
    let text = "[parameters]\nw = 0.5\n[flight]\nx = 'v'\n\
                v = '0.1 + 0.12*w^2*cos(w*t) - 0.08*v - if(x > 1, x - 1, if(x < -1, x + 1, 0))'\n[initial]\nx = 1.1\nv = 0\n";
    for (end, step) in [(0.702_994, 0.09), (0.702_994_5, 0.06), (0.702_994_5, 0.05)] {
        let found = over(&with(text, &[]), "w", (0.45, end), (40, step));
        assert_eq!(found[0].ends, [End::Range, End::Range], "{end} {step}");
        let mut special = found[0].special.iter();
        assert!(special.all(|special| special.kind == SpecialKind::Touch));
        assert!(found[0].points.iter().all(|point| point.is_stable()));
    }
    // Beyond the fold it is told.
    let found = over(&with(text, &[]), "w", (0.45, 0.702_995), (40, 0.09));
    let fold = nearest(&found, &[SpecialKind::Fold], 0.702_994_51);
    assert!((value(&fold) - 0.702_994_51).abs() < 1e-8);
}

/// A graze beyond the range, before which the last step ends or not.
#[test]
fn nothing_is_told_beyond_the_range() {
    let text = r#"
[parameters]
g = 0.25
[flight]
x = "v"
v = "-g - 0.05*v*abs(v)"
[[contact]]
name = "plate"
gap = "x - sin(t)"
impulse = { v = 1 }
restitution = 0.6
[initial]
x = 1.5
v = 0.8
"#;
    let range = (0.2, 0.5);
    let found = over(&with(text, &[]), "g", range, (16, 0.05));
    assert!(found.len() > 1);
    for branch in &found {
        for special in &branch.special {
            let at = value(special);
            assert!(range.0 <= at && at <= range.1, "{special:?}");
        }
    }
}

/// Between ever shorter flights doubles do not tell a graze to what they tell its equations to: at 33 impacts of an oscillator that a belt
/// drives two steps differed by 2e-12, with errors of 1e-14.
#[test]
fn grazes_of_short_flights_are_told_to_their_errors() {
    const DRIVEN: &str = r#"
[parameters]
w = 0.7397054
[flight]
x = "v"
v = "-0.1763*v - x - 0.4692*sign(v - 0.1333) + 0.3083*cos(w*t)"
[[contact]]
name = "a"
gap = "0.4087 - x"
impulse = { v = -1 }
restitution = 0.6778
[initial]
x = 0.4
v = 0.1
"#;
    let at = |step: f64| {
        let found = over(
            &with(DRIVEN, &[]),
            "w",
            (0.739_705_35, 0.739_705_8),
            (40, step),
        );
        nearest(&found, &GRAZES, 0.739_705_492_241)
    };
    let [one, other] = [0.02, 0.05].map(at);
    let off = (value(&one) - value(&other)).abs();
    assert!(off <= one.error + other.error, "{off:e} {one:?} {other:?}");
    assert!(one.error < 1e-13);
}

/// A free mass rests in the middle of a frame that swings with the amplitude 0.1/0.04: it is touched where half the way is that.
#[test]
fn a_graze_that_a_closed_form_tells_is_told_to_rounding() {
    const FRAME: &str = r#"
[parameters]
d = 4
[flight]
x = "v"
v = "0.1*cos(t) - 0.04*v - x"
z = "u"
u = "-0.02*u"
[[contact]]
name = "right"
gap = "d/2 - (z - x)"
impulse = { v = 0.1, u = -1 }
restitution = 0.5
[[contact]]
name = "left"
gap = "d/2 + (z - x)"
impulse = { v = -0.1, u = 1 }
restitution = 0.5
[section.strobe]
surface = "sin(t)"
direction = "rising"
[initial]
x = 0
v = 1
z = 0
u = 0.3
"#;
    let found = over(&with(FRAME, &[]), "d", (3.5, 6.0), (10, 0.03));
    let graze = nearest(&found, &GRAZES, 5.0);
    let off = (value(&graze) - 5.0).abs();
    assert!(
        off <= graze.error && graze.error < 1e-12,
        "{off:e} {graze:?}"
    );
}

/// Slips of a mass under dry friction become ever shorter where the force becomes no more than the friction: there the orbit shrinks to rest,
/// and where its equations are singular by rounding no branches meet.
#[test]
fn slips_that_come_to_nothing_shrink_to_rest() {
    const RUBBED: &str = r#"
[parameters]
f = 0.5
[flight]
x = "v"
v = "-0.1973*v - x - 0.3312*sign(v) + f*cos(0.852*t)"
[section.strobe]
surface = "sin(0.852*t)"
direction = "rising"
[initial]
x = 0.4
v = 0.1
"#;
    for step in [0.03, 0.012] {
        let found = over(&with(RUBBED, &[]), "f", (0.3, 0.6), (10, step));
        assert_eq!(found[0].ends, [End::Equilibrium, End::Range], "{step}");
        let first = found[0].points[0].parameter();
        assert!((first - 0.3312).abs() < 1e-6, "{first}");
        let met = (found[0].special.iter()).find(|s| s.kind == SpecialKind::BranchPoint);
        assert!(met.is_none(), "{met:?}");
    }
}

/// A kick whose strength is a state drives a mass against a stop.
pub(super) const KICKED: &str = "[parameters]\nk = 0.5\n[flight]\nx = 'v'\nv = '-x - 0.2039*v'\nu = '0.2397*x - 0.2835*u'\n\
    [[event]]\nname = 'kick'\nsurface = 'x'\ndirection = 'rising'\nreset = { v = 'v + k*(1 - u)' }\n\
    [[contact]]\nname = 'up'\ngap = '0.5043 - x'\nimpulse = { v = -1 }\nrestitution = 0.7877\n\
    [initial]\nx = 0.2\nv = 0.1\nu = 0\n";

/// A kick drives a mass against a stop ever faster: the orbit grows to 500 times its size, and a step against what it was at first would go ever
/// less far.
#[test]
fn steps_grow_with_the_orbit() {
    for k in ["0.5", "1.15"] {
        let found = over(&with(KICKED, &[("k", k)]), "k", (0.1, 1.2), (6, 0.04));
        let branch = &found[0];
        assert_eq!(branch.ends, [End::Range, End::Range]);
        assert!(branch.points.len() < 1500, "{k}: {}", branch.points.len());
        let fastest = |sum: f64, point: &Point| sum.max(point.state[1].abs());
        assert!(branch.points.iter().fold(0.0, fastest) > 140.0);
        let fold = nearest(&found, &[SpecialKind::Fold], 0.2625);
        assert!((value(&fold) - 0.262_510_514_166_561_96).abs() < 1e-12);
    }
}

/// From an orbit that is twenty thousand times as large, beside which one of the size of the model is a point.
#[test]
fn a_fold_is_told_from_orbits_however_large() {
    const MODEL: &str = "[parameters]\nk = 0.5\n[flight]\nx = 'v'\nv = '-x - 0.0860*v'\nu = '0.4614*x - 0.4652*u'\n\
        [[event]]\nname = 'kick'\nsurface = 'x'\ndirection = 'rising'\nreset = { v = 'v + k*(1 - u)' }\n\
        [[contact]]\nname = 'up'\ngap = '0.5784 - x'\nimpulse = { v = -1 }\nrestitution = 0.7802\n";
    let small = "[initial]\nx = 0.2\nv = 0.1\nu = 0\n";
    let large = "[initial]\nx = 0.5784\nv = -8399.518525518162\nu = -4737.6505648009725\n";
    for (initial, k) in [(small, "0.15"), (large, "0.7235466103289692")] {
        let model = with(&format!("{MODEL}{initial}"), &[("k", k)]);
        let found = over(&model, "k", (0.1, 0.72355), (6, 0.1));
        let fold = nearest(&found, &[SpecialKind::Fold], 0.1238);
        assert!((value(&fold) - 0.123_828_428_571_031_57).abs() < 1e-14);
    }
}

/// A multiplier passes -1 by 8e-4 and comes back, within one step: both doublings are told. (Where they are, by steps a third as long.)
#[test]
fn a_multiplier_that_passes_and_comes_back_within_a_step_is_told() {
    const SPRING: &str = "[parameters]\nf = 0.6\n[flight]\nx = 'v'\n\
        v = '-0.1935*v + f*cos(0.6948*t) - x - 8.5184*max(0, x - 0.3)'\n[initial]\nx = 0.2\nv = 0.1\n";
    for step in [0.04, 0.05, 0.015] {
        let found = over(&with(SPRING, &[]), "f", (0.1, 1.2), (6, step));
        let all = found.iter().flat_map(|branch| &branch.special);
        let doublings = all.filter(|special| special.kind == SpecialKind::PeriodDoubling);
        let mut doublings: Vec<f64> = doublings.map(value).collect();
        doublings.sort_by(f64::total_cmp);
        let expected = [0.162_660_623_317_299_08, 0.163_260_379_640_662_2];
        assert_eq!(doublings.len(), 2, "{step}: {doublings:?}");
        assert!(
            (0..2).all(|k| (doublings[k] - expected[k]).abs() < 1e-12),
            "{step}: {doublings:?}"
        );
    }
}

/// A swing is driven by a pulse that ends just as the swing is at its crest (closed form, by mpmath), and the crest grazes a wall: rounding says whether the
/// graze comes before the end of the pulse or after it. Impacts of every second period shrink to it, too, and have met the simple orbit there.
#[test]
fn a_graze_where_a_pulse_ends_is_passed_and_met() {
    let touch = 0.990_487_121_867_032_9;
    let text = |start: f64| {
        format!(
            "[parameters]\nF = {start}\n[flight]\nx = 'v'\nv = '-x - 0.1*v + F*if(mod(t, 7) < 1.5061355081561787, 1, 0)'\n[[contact]]\n\
             name = 'wall'\ngap = '2 - x'\nimpulse = {{ v = -1 }}\nrestitution = 0.7\n[section.s]\nsurface = 'sin(2*pi*(t - 4)/7)'\n\
             direction = 'rising'\n[initial]\nx = 0\nv = 0\n"
        )
    };
    let met = [End::Again(SpecialKind::FlightGraze), End::Range];
    for (start, ends) in [(0.8, [End::Range, End::Range]), (1.5, met)] {
        for step in [0.1, 0.01] {
            let branch = over(&with(&text(start), &[]), "F", (0.6, 1.6), (6, step)).swap_remove(0);
            assert_eq!(branch.ends, ends, "{start} {step}");
            let mut grazes = branch.special.iter().filter(|s| s.kind.is_graze());
            let graze = grazes.next().unwrap();
            assert!(
                (value(graze) - touch).abs() < 1e-14,
                "{start} {step} {}",
                value(graze)
            );
            assert_eq!((graze.kind, grazes.count()), (SpecialKind::FlightGraze, 0));
        }
    }
}

/// A gear that its load holds against a stop just leaves it where the force that swings reaches the load. From chatter down flights shrink to nothing there, at
/// all steps: what rounding leaves of the last impact is no graze.
#[test]
fn flights_that_shrink_to_nothing_graze_nowhere() {
    let text = "[parameters]\nf = 0.23\n[flight]\nx = 'v'\nv = '-0.1422*v + 0.1919 - f*cos(1.3198*t)'\n[[contact]]\nname = 'up'\n\
                gap = '0.4761 - x'\nimpulse = { v = -1 }\nrestitution = 0.6619\n[section.s]\nsurface = 'sin(1.3198*t)'\n\
                direction = 'rising'\n[initial]\nx = 0.1\nv = 0\n";
    for step in [0.033, 0.03, 0.02, 0.011, 0.004] {
        let branch = over(&with(text, &[]), "f", (0.1, 0.25), (6, step)).swap_remove(0);
        let told: Vec<_> = branch.special.iter().map(|s| (s.kind, value(s))).collect();
        let [(SpecialKind::Touch, at)] = told[..] else {
            panic!("{step}: {told:?} {:?}", branch.ends);
        };
        assert!((at - 0.1919).abs() < 1e-12, "{step}: {at}");
        assert_eq!(branch.ends, [End::Range, End::Range], "{step}");
    }
}

/// A print hammer strikes its backstop just as its pulse begins, a little beyond a fold of its orbits: there the branch has a corner and goes on, though a
/// long step begins before the fold. The period is that of two equations in closed flights with 30 digits.
#[test]
fn a_branch_goes_on_where_an_impact_passes_a_pulse_though_the_step_begins_before_a_fold() {
    let text = "[parameters]\nT = 2.6\n[flight]\nx = \"v\"\nv = \"if(mod(t, T) < 0.6, 3, 0) - 0.4 - x - 0.2*v\"\n[[contact]]\n\
        name = \"paper\"\ngap = \"0.5 - x\"\nimpulse = { v = -1 }\nrestitution = 0.55\n[[contact]]\nname = \"backstop\"\n\
        gap = \"x\"\nimpulse = { v = 1 }\nrestitution = 0.3\n[section.s]\nsurface = \"sin(2*pi*t/T)\"\n\
        direction = \"rising\"\n[initial]\nx = 0.1\nv = 0\n";
    let found = over(&with(text, &[]), "T", (2.5, 8.0), (5, 0.1));
    let told = found[0].special.iter();
    let told: Vec<_> = told
        .filter(|s| s.kind == SpecialKind::Touch && s.point.impacts == Some(5))
        .collect();
    let [touch] = told[..] else {
        panic!("{told:?}");
    };
    assert!((value(touch) - 2.976_386_474_399_244).abs() < 1e-11);
    assert_eq!(touch.persists, Some(true));
}
