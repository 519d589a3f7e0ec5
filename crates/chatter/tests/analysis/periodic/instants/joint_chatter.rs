//! Chatter of several contacts at once: infinitely many impacts in an order that has no end either.

use crate::periodic::{orbit, over, settles, value, with};
use chatter::analysis::diagram::{Exponent, Outcome, Range, Spec, Threads, diagram};
use chatter::analysis::exponents;
use chatter::analysis::periodic::{End, MarginKind, PeriodicError, SpecialKind};
use chatter::analysis::return_map::{ReturnMap, ReturnSpec};
use chatter::model::Model;
use chatter::numerics::Real;
use core::f64::consts::TAU;
use core::ops::ControlFlow;

const UNITS: [(f64, f64); 3] = [(1.0, 1.0), (1e-3, 1e-2), (1e3, 60.0)];

/// Clearance, force, frequency, restitution and damping.
type Row = [f64; 5];

/// All three contacts are closed for a tenth of a period.
const RESTS: Row = [
    0.05118409178102487,
    0.5712231906925163,
    0.7846816273883791,
    0.5824879979261235,
    0.1452488224231075,
];

/// The same, with fewer impacts.
const RESTS_SOON: Row = [
    0.030747237300756552,
    0.7471112974341247,
    1.550697889550283,
    0.20453919340976423,
    0.06075631295167813,
];

/// Three masses in a row before a wall, the first of which is shaken.
fn row([d, force, w, r, c]: Row, (long, short): (f64, f64)) -> Model {
    let stiff = 1.0 / (short * short);
    let text = format!(
        "[parameters]\nF = {:?}\nw = {:?}\nr = {r:?}\nd = {:?}\nc = {:?}\nk = {stiff:?}\n[flight]\nx1 = \"v1\"\n\
         v1 = \"F*cos(w*t) - k*x1 - c*v1\"\nx2 = \"v2\"\nv2 = \"(-1.3*k*x2 - c*v2)/0.7\"\nx3 = \"v3\"\n\
         v3 = \"(-1.7*k*x3 - c*v3)/1.4\"\n[[contact]]\nname = \"a\"\ngap = \"d + x2 - x1\"\n\
         impulse = {{ v1 = -1, v2 = \"1/0.7\" }}\nrestitution = \"r\"\n[[contact]]\nname = \"b\"\ngap = \"d + x3 - x2\"\n\
         impulse = {{ v2 = \"-1/0.7\", v3 = \"1/1.4\" }}\nrestitution = \"r\"\n[[contact]]\nname = \"wall\"\ngap = \"d - x3\"\n\
         impulse = {{ v3 = -1 }}\nrestitution = \"0.5*r\"\n[section.s]\nsurface = \"sin(w*t)\"\ndirection = \"rising\"\n\
         [initial]\nx1 = 0\nv1 = 0\nx2 = 0\nv2 = 0\nx3 = 0\nv3 = 0\n",
        force * long * stiff,
        w / short,
        d * long,
        c / short,
    );
    Model::from_toml(&text, "row").unwrap()
}

#[test]
fn masses_that_all_come_to_rest_have_an_orbit_without_memory() {
    for units in UNITS {
        let found = orbit(&row(RESTS_SOON, units));
        let [d, force, w, ..] = RESTS_SOON;
        assert!((found.period.to_f64() / (TAU / w * units.1) - 1.0).abs() < 1e-14);
        assert_eq!(found.impacts, None);
        let sizes = found.multipliers.iter().map(|m| m.re.hypot(m.im));
        assert_eq!(sizes.fold(0.0, f64::max), 0.0, "{:?}", found.multipliers);
        // The orbit is told from the section on; the wall is left where the force is that of the springs, F cos(w t) = 7.3 d.
        let left = (7.3 * d / force).acos() / w * units.1;
        let mut times = found.margins.iter().map(|margin| margin.time);
        assert!(
            times.any(|time| (time / left - 1.0).abs() < 1e-12),
            "{left}: {:?}",
            found.margins
        );
        // There all three begin to move at once, at a wall that is left with the jerk of their common mass.
        let jerk = force * w * (w * left / units.1).sin() / 3.1 * units.0 / units.1.powi(3);
        let of = |kind| found.margins.iter().find(move |m| m.kind == kind);
        let told = of(MarginKind::ReleaseJerk).unwrap();
        assert!((told.value / jerk - 1.0).abs() < 1e-10, "{told:?} {jerk}");
    }
}

#[test]
fn what_several_contacts_forget_has_no_exponent_and_a_period() {
    for units in UNITS {
        let model = row(RESTS, units);
        let period = TAU / RESTS[2] * units.1;
        let spec = exponents::Spec {
            interval: period,
            transient: 4,
            intervals: 6,
        };
        let found = exponents::exponents(&model, &spec, &mut |_| ControlFlow::Continue(()));
        let found = found.unwrap().values;
        assert_eq!(found, [f64::NEG_INFINITY; 6], "{units:?}");
        let map = ReturnMap::new(&model, &ReturnSpec::section("s")).unwrap();
        let swept = Range::linear("r", RESTS[3], RESTS[3], 1);
        let mut spec = Spec::new(swept, "v1", 4, 12);
        spec.exponent = Exponent::Largest;
        let rows = diagram(&map, &spec, &Threads::new(1)).unwrap();
        assert_eq!(rows[0].period, 1, "{units:?}");
        assert_eq!(rows[0].outcome, Outcome::CompleteChatter);
        assert_eq!(rows[0].exponent, f64::NEG_INFINITY);
    }
}

/// Impacts that follow each other so fast that time does not tell them apart: a cascade at one instant ends them.
#[test]
fn collapse_is_no_other_motion_in_each_period() {
    let collapses = [
        0.12709321050696423,
        0.9533949979992502,
        1.2138720084506167,
        0.21450261414180738,
        0.19037064188971334,
    ];
    let model = row(collapses, UNITS[0]);
    let map = ReturnMap::new(&model, &ReturnSpec::section("s")).unwrap();
    let swept = Range::linear("r", collapses[3], collapses[3], 1);
    let rows = diagram(&map, &Spec::new(swept, "v1", 20, 20), &Threads::new(1)).unwrap();
    assert_eq!(
        (rows[0].period, rows[0].outcome),
        (1, Outcome::CompleteChatter)
    );
}

/// Chatter of all three at the end of which two fly on: it is said, with their names.
#[test]
fn chatter_after_which_contacts_open_is_said() {
    let parts = [
        0.20334380802917704,
        0.8594352709774851,
        1.1791977725127283,
        0.2798021061790191,
        0.05359046112781354,
    ];
    match settles(&row(parts, UNITS[0])) {
        Err(PeriodicError::Unfollowed { what }) => {
            assert!(what.contains("`a`, `b`, `wall`"), "{what}");
            assert!(what.contains("at time"), "{what}");
        }
        other => panic!("{other:?}"),
    }
}

/// A hammer pushes a bit into the ground until friction holds the bit: in that instant the hammer is pulled off.
#[test]
fn a_bit_that_sticks_as_its_hammer_leaves_has_an_orbit() {
    for (long, short) in UNITS {
        let rate = 1.0 / short;
        let force = long * rate * rate;
        let text = format!(
            "[parameters]\nP = {:?}\nF = {:?}\nw = {:?}\nk = {:?}\n[flight]\nx = \"u\"\n\
             u = \"P + F*cos(w*t) - k*(x - y) - {:?}*u\"\ny = \"v\"\nv = \"(0.2*k*(x - y) - {:?}*sign(v))/0.5\"\n\
             [[contact]]\nname = \"anvil\"\ngap = \"{:?} - (x - y)\"\nimpulse = {{ u = -1, v = \"1/0.5\" }}\nrestitution = 0.66\n\
             [section.s]\nsurface = \"sin(w*t)\"\ndirection = \"rising\"\n[initial]\nx = 0\nu = {:?}\ny = 0\nv = 0\n",
            0.2 * force,
            0.6 * force,
            0.68 * rate,
            0.8 * rate * rate,
            0.05 * rate,
            0.68 * force,
            0.1 * long,
            0.1 * long * rate,
        );
        let found = orbit(&Model::from_toml(&text, "rig").unwrap());
        assert!((found.period.to_f64() / (TAU / 0.68 * short) - 1.0).abs() < 1e-14);
        assert!(found.residual < 1e-24, "{}", found.residual);
        // A cycle is told by the time of that instant: a difference of times a period later, by DOP853.
        let off = found.multipliers[0].re - 0.035_643_03;
        assert!(off.abs() < 1e-8, "{off:e}");
    }
}

/// A block on a base that shakes by F cos(2 t), with edges half a unit from its middle: struck at one of them, it is thrown off the other one that it
/// rests on, where both gaps are zero by what rounding leaves of a state at zero.
const BLOCK: &str = r#"
[parameters]
F = 1.55
r = 0.15
[flight]
y = "v"
v = "-1"
th = "w"
w = "F*cos(2*t) - 0.05*w"
[[contact]]
name = "left"
gap = "y - 0.5*th"
impulse = { v = 1, w = -1.5 }
restitution = "r"
[[contact]]
name = "right"
gap = "y + 0.5*th"
impulse = { v = 1, w = 1.5 }
restitution = "r"
[section.strobe]
surface = "sin(2*t)"
direction = "rising"
[initial]
y = 0.02
v = 0
th = 0.01
w = 0
"#;

/// At rest the edges carry (1 +- F cos(2 t)/1.5)/2: one is left where F cos(2 t) = 1.5, the other half a period on, with the jerk
/// 4/7 of the rate of F cos(2 t).
#[test]
fn a_block_thrown_off_an_edge_that_it_rests_on_has_an_orbit() {
    for (force, r) in [("1.55", "0.15"), ("1.6", "0.03")] {
        let found = orbit(&with(BLOCK, &[("F", force), ("r", r)]));
        assert!((found.period.to_f64() / (TAU / 2.0) - 1.0).abs() < 1e-14);
        assert_eq!(found.impacts, None);
        assert!(found.multipliers.iter().all(|m| m.re == 0.0 && m.im == 0.0));
        let force: f64 = force.parse().unwrap();
        let jerk = 4.0 / 7.0 * 2.0 * (force * force - 2.25).sqrt();
        let left = 0.5 * (-1.5 / force).acos();
        let releases = (found.margins.iter()).filter(|m| m.kind == MarginKind::ReleaseJerk);
        let releases: Vec<_> = releases.map(|m| (m.value, m.time)).collect();
        let of = |time: f64| {
            releases.iter().any(|(value, at)| {
                (value / jerk - 1.0).abs() < 1e-9 && (at / time - 1.0).abs() < 1e-9
            })
        };
        assert!(
            of(left) && of(left + TAU / 4.0),
            "{releases:?} {jerk} {left}"
        );
    }
}

/// It begins to rock where F = 1.5, and the branch goes on there with an orbit of chatter.
#[test]
fn a_block_begins_to_rock_where_an_edge_carries_nothing() {
    let model = with(BLOCK, &[("F", "1.499"), ("r", "0.03")]);
    let found = over(&model, "F", (1.498, 1.502), (4, 0.5));
    let [touch] = &*found[0].special else {
        panic!("{:?}", found[0].special);
    };
    assert_eq!(
        (touch.kind, touch.persists),
        (SpecialKind::Touch, Some(true))
    );
    assert!((value(touch) - 1.5).abs() < 1e-12);
    assert_eq!(found[0].ends, [End::Range, End::Range]);
    assert_eq!(found[0].points.last().unwrap().impacts, None);
}

/// As it rocks, impacts at its two edges come in another order at each force, and it rests on both.
#[test]
fn a_block_rocks_to_rest_in_whatever_order() {
    for (start, longest) in [("1.698", 0.5), ("1.704", 0.2)] {
        let model = with(BLOCK, &[("F", start), ("r", "0.3")]);
        let found = over(&model, "F", (1.6965, 1.7055), (40, longest));
        let [branch] = &*found else {
            panic!("{found:?}");
        };
        assert_eq!(branch.ends, [End::Range, End::Range], "from {start}");
        assert!(branch.special.is_empty(), "{:?}", branch.special);
        for point in &branch.points {
            assert_eq!(point.impacts, None);
            assert!(point.multipliers.iter().all(|m| m.re == 0.0 && m.im == 0.0));
        }
    }
}

/// A cam, a tappet and a valve on its seat: all rest at the foot of the cam, which forgets how they came there. The preload of the valve is known
/// up to p = 2.
const TAPPET: &str = r#"
[parameters]
omega = 6.0
p = 1.0
lift = 0.01
mt = 0.1
mv = 0.2
kv = 1000.0
Fv = 8.0
kt = 200.0
Ft = 1.5
c = 2.0
cl = 0.0005
r1 = 0.4
r2 = 0.3
[definitions]
cam = "lift*((1 - cos(a))/2)^2"
[flight]
yt = "vt"
vt = "(-kt*yt - Ft - c*vt)/mt"
yv = "vv"
vv = "(-kv*yv - Fv*push(p) - c*vv)/mv"
a = "omega"
[[contact]]
name = "cam"
gap = "yt - cam"
impulse = { vt = 1 }
restitution = "r1"
[[contact]]
name = "stem"
gap = "yv - yt + cl"
impulse = { vt = "-1/mt", vv = "1/mv" }
restitution = "r2"
[[contact]]
name = "seat"
gap = "yv"
impulse = { vv = 1 }
restitution = "r2"
[section.bottom]
surface = "sin(a)"
direction = "rising"
[initial]
yt = 0
vt = 0
yv = 0
vv = 0
a = 0
[table.push]
x = [0, 1, 2]
y = [1, 1, 1.3]
kind = "linear"
"#;

/// In which order the contacts come to rest is another at each speed.
#[test]
fn contacts_in_series_that_rest_at_all_speeds_have_no_border() {
    for (start, longest) in [("9", 0.5), ("9.3", 0.2)] {
        let model = with(TAPPET, &[("omega", start)]);
        let found = over(&model, "omega", (9.0, 9.4), (40, longest));
        let [branch] = &*found else {
            panic!("{found:?}");
        };
        assert_eq!(branch.ends, [End::Range, End::Range], "from {start}");
        assert!(branch.special.is_empty(), "{:?}", branch.special);
        for point in &branch.points {
            assert!(point.multipliers.iter().all(|m| m.re == 0.0 && m.im == 0.0));
        }
        let at = |point: &chatter::analysis::periodic::Point| *point.parameters.last().unwrap();
        let edges = [branch.points.first(), branch.points.last()].map(|point| at(point.unwrap()));
        assert!(
            (edges[0] - 9.0).abs() < 1e-6 && (edges[1] - 9.4).abs() < 1e-6,
            "{edges:?}"
        );
    }
}

/// Chatter that nothing is released after ends by what strikes there. Where a table ends the equations are left for another reason than
/// chatter which is not complete.
#[test]
fn the_end_of_a_table_is_no_border_of_chatter() {
    let found = over(&with(TAPPET, &[("p", "1.9")]), "p", (1.8, 2.5), (40, 0.2));
    let [branch] = &*found else {
        panic!("{found:?}");
    };
    assert!(branch.special.is_empty(), "{:?}", branch.special);
    assert!(
        matches!(&branch.ends, [End::Range, End::Lost(what)] if !what.contains("chatter")),
        "{:?}",
        branch.ends
    );
    let last = branch.points.last().unwrap().parameters.last().unwrap();
    assert!((last - 2.0).abs() < 1e-6, "{last}");
}

/// A branch of orbits that rest at the foot of the cam, with nothing to tell on the way.
fn assert_forgets((model, parameter): (&Model, &str), (low, high): (f64, f64), longest: f64) {
    let found = over(model, parameter, (low, high), (40, longest));
    let [branch] = &*found else {
        panic!("{found:?}");
    };
    assert_eq!(branch.ends, [End::Range, End::Range], "{parameter}");
    assert!(branch.special.is_empty(), "{:?}", branch.special);
    for point in &branch.points {
        assert_eq!(point.impacts, None);
        assert!(point.multipliers.iter().all(|m| m.re == 0.0 && m.im == 0.0));
        // Of the section, where the cam is at its foot.
        let [yt, vt, yv, vv, _] = point.state[..] else {
            panic!("{:?}", point.state);
        };
        let off = [yt / 5e-4, vt / 0.05, yv / 5e-4, vv / 0.05].map(f64::abs);
        assert!(off.iter().all(|off| *off < 1e-9), "{:?}", point.state);
    }
}

/// At mv = 0.1909 a collision of the tappet with the cam loses its rate, in each of infinitely many instants at which several collide.
#[test]
fn the_order_of_impacts_before_all_rest_is_no_matter_of_the_orbit() {
    for longest in [0.5, 0.2] {
        let model = with(TAPPET, &[("omega", "20"), ("mv", "0.2")]);
        assert_forgets((&model, "mv"), (0.187, 0.201), longest);
    }
}

/// At r2 = 0.1832 the last collision of the instant at which the cam meets the valve comes no more, since flights begin instead; from either side.
#[test]
fn how_many_collisions_share_the_first_instant_is_no_matter_of_the_orbit() {
    for (start, longest) in [("0.18", 0.5), ("0.189", 0.2)] {
        let model = with(TAPPET, &[("omega", "30"), ("r2", start)]);
        assert_forgets((&model, "r2"), (0.17, 0.19), longest);
    }
}

/// A ball in a shaken groove, whose both walls hold it at rest in each period. Where the first impact of one wall passes the fourth of the other one nothing happens to
/// the orbit: so it did at A = 0.5515092935453.
#[test]
fn the_order_of_impacts_before_a_rest_that_holds_all_is_not_told() {
    let text = "[parameters]\nA = 0.5515\n[flight]\ny = \"v\"\nv = \"-1 + 2.25*A*sin(1.5*t)\"\nx = \"u\"\nu = \"0.225*sin(1.5*t + 1) - 0.05*u\"\n\
        [[contact]]\nname = \"right\"\ngap = \"y - x\"\nimpulse = { v = 1, u = -1 }\nrestitution = 0.5\n\
        [[contact]]\nname = \"left\"\ngap = \"y + x\"\nimpulse = { v = 1, u = 1 }\nrestitution = 0.5\n\
        [initial]\ny = 0.5\nv = 0\nx = 0.1\nu = 0\n";
    let found = over(&with(text, &[]), "A", (0.5514, 0.5516), (4, 0.5));
    assert_eq!(found[0].ends, [End::Range, End::Range]);
    assert!(found[0].special.is_empty(), "{:?}", found[0].special);
}
