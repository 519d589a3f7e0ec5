//! What is special on a branch is so whatever the steps, from whichever of its orbits it is followed, at whatever section it is told.

use super::steps::KICKED;
use crate::periodic::with;
use chatter::analysis::periodic::{
    Beside, Branch, BranchSpec, End, Limits, Spec, SpecialKind, branches,
};
use chatter::model::Model;
use core::mem::discriminant;
use std::fmt::Write;
use std::ops::ControlFlow;

/// Numbers that are drawn.
struct Drawn(u64);

impl Drawn {
    /// One of these bounds, with four digits.
    fn of(&mut self, low: f64, high: f64) -> String {
        self.0 = (self.0)
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let part = (self.0 >> 11) as f64 / (1_u64 << 53) as f64;
        format!("{:.4}", low + (high - low) * part)
    }
}

/// Told at either of these.
const SECTIONS: &str = "[section.strobe]\nsurface = 'sin(w*t)'\ndirection = 'rising'\n\
                        [section.place]\nsurface = 'x - 0.05'\ndirection = 'rising'\n";

fn stop(drawn: &mut Drawn, side: &str, place: (f64, f64)) -> String {
    let (sign, push) = if side == "up" { ('-', -1) } else { ('+', 1) };
    format!(
        "[[contact]]\nname = '{side}'\ngap = '{} {sign} x'\nimpulse = {{ v = {push} }}\nrestitution = {}\n",
        drawn.of(place.0, place.1),
        drawn.of(0.3, 0.8)
    )
}

/// A model of a kind with drawn numbers, and the parameter with its range.
fn draw(kind: usize, d: &mut Drawn) -> (String, &'static str, (f64, f64)) {
    let forced = |d: &mut Drawn, force: &str| {
        format!(
            "[parameters]\nf = 0.6\nw = {}\n[flight]\nx = 'v'\nv = '-{}*v + f*cos(w*t) {force}'\n{SECTIONS}",
            d.of(0.6, 1.4),
            d.of(0.05, 0.25)
        )
    };
    let start = "[initial]\nx = 0.2\nv = 0.1\n";
    let (mut text, name, range) = match kind {
        // A wall beside a hardening spring.
        0 => {
            let force = format!("- x - {}*x^3", d.of(0.0, 0.5));
            let text = forced(d, &force);
            (text + &stop(d, "up", (0.4, 1.2)), "f", (0.1, 1.1))
        }
        // Two stops.
        1 => {
            let force = format!("- {}*x", d.of(0.1, 1.0));
            let text = forced(d, &force);
            let stops = stop(d, "up", (0.3, 0.7)) + &stop(d, "down", (0.4, 0.8));
            (text + &stops, "f", (0.2, 1.0))
        }
        // Dry friction, and dry friction with a wall.
        2 => {
            let force = format!("- x - {}*sign(v)", d.of(0.1, 0.3));
            let text = forced(d, &force);
            (text, "f", (0.5, 1.5))
        }
        3 => {
            let force = format!("- x - {}*sign(v)", d.of(0.05, 0.2));
            let text = forced(d, &force);
            (text + &stop(d, "up", (0.4, 1.0)), "f", (0.4, 1.5))
        }
        // A spring with preload, and one that begins to push.
        4 => {
            let (p, k) = (d.of(0.05, 0.2), d.of(0.5, 2.0));
            let force = format!("- {p}*sign(x) - {k}*x");
            let text = forced(d, &force);
            (text, "f", (0.4, 1.2))
        }
        5 => {
            let force = format!("- x - {}*max(0, x - 0.3)", d.of(2.0, 9.0));
            let text = forced(d, &force);
            (text, "f", (0.1, 1.2))
        }
        // A belt.
        6 => {
            let text = format!(
                "[parameters]\nV = 0.4\n[flight]\nx = 'v'\nv = '-x - {}*v - {}*sign(v - V)/(1 + {}*abs(v - V))'\n",
                d.of(0.02, 0.1),
                d.of(0.4, 1.0),
                d.of(0.5, 3.0)
            );
            (text, "V", (0.1, 1.0))
        }
        // A relay of three states.
        7 => {
            let text = format!(
                "[parameters]\nb = 1\n[flight]\nx = 'v'\nv = 'z'\nz = '-{}*z - {}*v - {}*x - b*sign(x - {}*v)'\n",
                d.of(0.8, 2.0),
                d.of(1.5, 3.0),
                d.of(0.3, 1.0),
                d.of(0.0, 0.3)
            );
            (text, "b", (0.3, 3.0))
        }
        // Two masses that knock.
        8 => {
            let k = d.of(0.2, 0.6);
            let force = format!("- x - {k}*(x - y)");
            let mut text = forced(d, &force);
            let other = format!(
                "[flight]\ny = 'u'\nu = '{k}*(x - y) - {}*y - 0.1*u'\n",
                d.of(0.5, 1.5)
            );
            text = text.replace("[flight]\n", &other);
            write!(
                text,
                "[[contact]]\nname = 'knock'\ngap = '{} + y - x'\nimpulse = {{ v = -1, u = 1 }}\nrestitution = {}\n",
                d.of(0.2, 0.6),
                d.of(0.4, 0.8)
            )
            .unwrap();
            (text, "f", (0.1, 1.2))
        }
        // A kick in each period, of a strength that is a state.
        _ => {
            let mut text = format!(
                "[parameters]\nk = 0.5\n[flight]\nx = 'v'\nv = '-x - {}*v'\nu = '{}*x - {}*u'\n",
                d.of(0.05, 0.3),
                d.of(0.1, 0.5),
                d.of(0.2, 0.6)
            );
            text += "[[event]]\nname = 'kick'\nsurface = 'x'\ndirection = 'rising'\nreset = { v = 'v + k*(1 - u)' }\n";
            (text + &stop(d, "up", (0.4, 0.9)), "k", (0.1, 1.2))
        }
    };
    text += start;
    // What else there is begins at zero.
    for state in ["y", "z", "u"] {
        if text.contains(&format!("\n{state} = ")) {
            writeln!(text, "{state} = 0").unwrap();
        }
    }
    (text, name, range)
}

/// The branch through the orbit that the motion settles to, or through another.
fn follow(
    model: &Model,
    (name, range): (&str, (f64, f64)),
    longest_step: f64,
    spec: &Spec,
) -> Option<Branch> {
    let what = BranchSpec {
        parameter: model.parameter_index(name).unwrap(),
        limits: Limits {
            range,
            other: None,
            impacts: 6,
            points: 10_000,
            longest_step,
        },
        beside: Beside::default(),
    };
    let found = branches(model, spec, &what, Vec::new(), &mut |_| {
        ControlFlow::Continue(())
    });
    Some(found.ok()?.swap_remove(0))
}

type Told = (SpecialKind, f64, f64, Option<u64>, Option<bool>);

fn told(branch: &Branch) -> Vec<Told> {
    let of = branch.special.iter();
    let mut all: Vec<Told> = of
        .map(|s| {
            let point = &s.point;
            (
                s.kind,
                point.parameter(),
                s.error,
                point.impacts,
                s.persists,
            )
        })
        .collect();
    all.sort_by(|a, b| a.1.total_cmp(&b.1));
    all
}

/// What is said of a branch twice, in words, where it is not the same.
fn difference(one: &Branch, other: &Branch) -> Option<String> {
    let ends = |branch: &Branch| {
        let mut all: Vec<String> = branch.ends.iter().map(|end| format!("{end:?}")).collect();
        all.sort();
        all
    };
    let kinds = |branch: &Branch, k: usize| discriminant(&branch.ends[k]);
    let same_ends = (0..2).all(|k| kinds(one, k) == kinds(other, k))
        || (0..2).all(|k| kinds(one, k) == kinds(other, 1 - k));
    if !same_ends {
        return Some(format!("{:?} and {:?}", ends(one), ends(other)));
    }
    let (mut first, second) = (told(one), told(other));
    let mut only = Vec::new();
    for special in second {
        let is_it = |known: &Told| {
            let off = (known.1 - special.1).abs();
            (known.0, known.3, known.4) == (special.0, special.3, special.4)
                && off <= (1e-12 * known.1.abs()).max(known.2 + special.2)
        };
        match first.iter().position(is_it) {
            Some(index) => drop(first.remove(index)),
            None => only.push(special),
        }
    }
    (!(first.is_empty() && only.is_empty())).then(|| format!("{first:?} and {only:?}"))
}

/// Follows a branch by other steps, at other sections, and from as many other orbits on it. How many special points it has.
fn is_the_same_from_everywhere(
    text: &str,
    what: (&str, (f64, f64)),
    orbits: usize,
) -> Result<usize, String> {
    let model = with(text, &[]);
    let first = follow(&model, what, 0.04, &Spec::default()).ok_or("nothing is found")?;
    let closed = first.ends.contains(&End::Closed);
    let compare = |how: &str, other: Option<Branch>| {
        let other = other.ok_or(format!("{how}: nothing is found"))?;
        match difference(&first, &other) {
            Some(difference) => Err(format!("{how}: {difference}")),
            None => Ok(()),
        }
    };
    compare("finer", follow(&model, what, 0.015, &Spec::default()))?;
    for section in 1..model.sections.len() {
        let spec = Spec {
            section: Some(section),
            ..Spec::default()
        };
        compare("another section", follow(&model, what, 0.04, &spec))?;
    }
    let count = first.points.len();
    for place in (1..=orbits).map(|part| part * (count - 1) / (orbits + 1)) {
        let point = &first.points[place];
        let mut there = model.clone();
        (there.set_parameter(what.0, &format!("{:?}", point.parameter()))).unwrap();
        let spec = Spec {
            through: Some((point.state.clone(), point.period)),
            ..Spec::default()
        };
        let how = format!(
            "through {:?} at {:?}, period {:?}",
            point.state,
            point.parameter(),
            point.period
        );
        compare(&how, follow(&there, what, 0.03, &spec))?;
    }
    assert!(!closed || first.ends[0] == first.ends[1]);
    Ok(first.special.len())
}

/// A branch of an oscillator comes down to where its only impact has no rate: from there on orbits are told at the phase of that graze. One of them,
/// followed up again, touches just where it is told from.
#[test]
fn a_graze_at_the_phase_that_an_orbit_is_told_from_is_passed() {
    const WALL: &str = r#"
[parameters]
f = 0.6
[flight]
x = "v"
v = "-0.1558*v - x - 0.2547*x^3 + f*cos(0.989*t)"
[[contact]]
name = "wall"
gap = "0.9446 - x"
impulse = { v = -1 }
restitution = 0.7
[initial]
x = 0
v = 0
"#;
    let (mut model, what) = (with(WALL, &[]), ("f", (0.1, 1.1)));
    let found = follow(&model, what, 0.05, &Spec::default()).unwrap();
    let point = &found.points[1];
    assert_eq!(point.impacts, Some(0));
    (model.set_parameter("f", &format!("{:?}", point.parameter()))).unwrap();
    let spec = Spec {
        through: Some((point.state.clone(), point.period)),
        ..Spec::default()
    };
    let again = follow(&model, what, 0.03, &spec).unwrap();
    assert_eq!(difference(&found, &again), None);
    assert_eq!(found.ends, [End::Range, End::Range]);
}

/// What is special on a branch and how it ends, followed through one of its orbits.
fn through(
    text: &str,
    (name, value): (&str, f64),
    (state, period): (&[f64], f64),
    (range, step): ((f64, f64), f64),
) -> Branch {
    let model = with(text, &[(name, &format!("{value:?}"))]);
    let spec = Spec {
        through: Some((state.to_vec(), period)),
        ..Spec::default()
    };
    follow(&model, (name, range), step, &spec).unwrap()
}

/// Where the parameter is that of each special point of a kind.
fn places(branch: &Branch, kind: SpecialKind) -> Vec<f64> {
    let of = branch.special.iter().filter(|special| special.kind == kind);
    of.map(|special| special.point.parameter()).collect()
}

/// A mass on a belt slips over it, and a moment later sticks: at a speed of the belt that moment is none. The slip leaves at x = F - c V and
/// comes back at the other end of what the belt can hold, x = -F - c V (integrated with scipy: V = 0.928674714657).
#[test]
fn the_end_of_a_stay_of_no_time_is_told_from_either_side() {
    const BELT: &str = "[parameters]\nV = 0.4\n[flight]\nx = 'v'\n\
        v = '-x - 0.0325*v - 0.6460*sign(v - V)/(1 + 1.2960*abs(v - V))'\n[initial]\nx = 0.2\nv = 0.1\n";
    let (range, from) = ((0.9, 1.0), 0.9309651629047382);
    let state = [-0.677453275080755, from];
    for step in [0.03, 0.05, 0.2] {
        let found = through(
            BELT,
            ("V", from),
            (&state, 6.617144446104501),
            (range, step),
        );
        let touches = places(&found, SpecialKind::Touch);
        assert!(
            matches!(&touches[..], [touch] if (touch - 0.928674714657).abs() < 2e-12),
            "{step}: {touches:?}"
        );
        assert_eq!(found.ends, [End::Range, End::Range]);
    }
}

/// An oscillator with dry friction comes to rest just where its stop is, and would stick there: every step until it leaves breaks at one place.
/// Beyond, an impact throws it off the rest, to which it comes back in as little time as the impact has rate. (The orbit whose rest is at
/// the stop, integrated with scipy: f = 1.044116763361.)
#[test]
fn an_impact_where_a_mass_comes_to_rest_is_told_from_either_side() {
    const STICKS: &str = "[parameters]\nf = 0.6\n[flight]\nx = 'v'\n\
        v = '-0.0505*v + f*cos(0.6156*t) - x - 0.0861*sign(v)'\n\
        [[contact]]\nname = 'up'\ngap = '0.4483 - x'\nimpulse = { v = -1 }\nrestitution = 0.3927\n\
        [initial]\nx = 0.2\nv = 0.1\n";
    let (range, period) = ((1.0, 1.06), 10.206603812832336);
    let before = [0.2788022137516788, 0.56185253970956, period];
    let beyond = [0.28538155461090803, 0.5933215830283873, period];
    let starts = [(1.029482652043, before), (1.058189314828, beyond)];
    let found = starts.map(|(f, state)| {
        let found =
            [0.04, 0.1].map(|step| through(STICKS, ("f", f), (&state, period), (range, step)));
        assert_eq!(difference(&found[0], &found[1]), None);
        found
    });
    let [up, down] = found.map(|[found, _]| found);
    assert_eq!(difference(&up, &down), None);
    assert_eq!(up.ends, [End::Range, End::Range]);
    let grazes = places(&up, SpecialKind::FlightGraze);
    assert!(
        matches!(&grazes[..], [graze] if (graze - 1.044116763361).abs() < 2e-12),
        "{grazes:?}"
    );
    let kinds: Vec<SpecialKind> = up.special.iter().map(|special| special.kind).collect();
    let rest = [SpecialKind::Touch, SpecialKind::Fold, SpecialKind::Touch];
    assert_eq!(kinds[1..], rest);
}

/// Two masses that knock, the second of them driven: the frequency, the spring between them, the first one's own and the second one's damping;
/// their distance, and restitution.
fn knocking([w, between, own, damping]: [f64; 4], (distance, restitution): (f64, f64)) -> String {
    format!(
        r#"
[parameters]
f = 0.6
w = {w}
[flight]
y = 'u'
u = '{between}*(x - y) - {own}*y - 0.1*u'
x = 'v'
v = '-{damping}*v + f*cos(w*t) - x - {between}*(x - y)'
[section.strobe]
surface = 'sin(w*t)'
direction = 'rising'
[section.place]
surface = 'x - 0.05'
direction = 'rising'
[[contact]]
name = 'knock'
gap = '{distance} + y - x'
impulse = {{ v = -1, u = 1 }}
restitution = {restitution}
[initial]
x = 0.2
v = 0.1
y = 0
u = 0
"#
    )
}

/// Where it grazes an orbit of four periods goes four times around a simple one, whichever of its events it is told from: there it ends.
#[test]
fn an_orbit_that_goes_around_a_simple_one_at_its_graze_ends_there() {
    let knocks = knocking([0.6774, 0.2211, 1.0481, 0.1137], (0.5377, 0.6923));
    let period = 37.10177329305926;
    let through_four =
        |f: f64, state: &[f64]| through(&knocks, ("f", f), (state, period), ((0.1, 1.2), 0.03));
    let early = [
        0.5219317661887372,
        0.04407761046611913,
        0.459828509537171,
        0.05889252437061282,
        9.275443323264817,
    ];
    let late = [
        0.53863408216867,
        0.028810369407565428,
        0.5319554840234104,
        0.07699699287119961,
        9.275443323264817,
    ];
    let first = through_four(0.5508354193634527, &early);
    let ends = [SpecialKind::FlightGraze, SpecialKind::ImpactGraze].map(End::Again);
    assert_eq!(first.ends, ends);
    assert_eq!(
        difference(&first, &through_four(0.5973987460322597, &late)),
        None
    );
}

/// An orbit of three periods has one impact, then two, which lose their rate at once: it has met the simple orbit at its graze then, as where its only one
/// does. The impact that is taken out last tells no parts of it from each other.
#[test]
fn an_orbit_all_of_whose_impacts_lose_their_rate_at_once_has_met_a_simple_one() {
    let knocks = knocking([0.6987, 0.5271, 1.2333, 0.0942], (0.4034, 0.7028));
    for step in [0.04, 0.015] {
        let found = follow(
            &with(&knocks, &[]),
            ("f", (0.1, 1.2)),
            step,
            &Spec::default(),
        );
        let found = found.unwrap();
        let ends = [SpecialKind::FlightGraze, SpecialKind::ImpactGraze].map(End::Again);
        assert_eq!(found.ends, ends);
        let grazes = told(&found);
        assert_eq!(grazes.len(), 4, "{grazes:?}");
        let simple = 0.566_510_090_553_527_2;
        assert!([0, 1].iter().all(|&k| (grazes[k].1 - simple).abs() < 1e-12));
    }
}

/// The same where drag turns with the rate that vanishes, so that the way between breaks and not the impact (the graze of the simple orbit in closed form,
/// by mpmath).
#[test]
fn a_doubled_branch_ends_at_the_graze_of_the_simple_one_where_drag_turns() {
    let text = format!(
        "[parameters]\nf = 0.6\nw = 1.3264\n[flight]\nx = 'v'\nv = '-x - 0.1036*v - if(v > 0, 0.1867, -0.0964) + f*cos(w*t)'\n{SECTIONS}\
         [[contact]]\nname = 'up'\ngap = '0.8787 - x'\nimpulse = {{ v = -1 }}\nrestitution = 0.6531\n\
         [[contact]]\nname = 'down'\ngap = '0.6521 + x'\nimpulse = {{ v = 1 }}\nrestitution = 0.5589\n\
         [initial]\nx = 0.1\nv = 0\n"
    );
    let simple = 0.454_684_118_598_862;
    let ends = [SpecialKind::FlightGraze, SpecialKind::BranchPoint].map(End::Again);
    let model = with(&text, &[]);
    for (section, step) in [(1, 0.0044), (1, 0.033), (0, 0.022), (0, 0.1)] {
        let spec = Spec {
            section: Some(section),
            ..Spec::default()
        };
        let found = follow(&model, ("f", (0.3, 1.4)), step, &spec).unwrap();
        assert_eq!(found.ends, ends, "{section} {step}");
        let grazes = places(&found, SpecialKind::FlightGraze);
        assert_eq!(grazes.len(), 2, "{section} {step}: {grazes:?}");
        assert!((grazes[0] - simple).abs() < 1e-14, "{grazes:?}");
    }
}

/// A wall that throws slow impacts back faster than fast ones: an impact that comes in at a graze is a slow one, whatever the impact after it, and one
/// that goes out leaves a flight whichever it was (closed form, by mpmath).
#[test]
fn an_impact_that_comes_in_asks_for_the_restitution_of_its_own_rate() {
    let text = format!(
        "[parameters]\nf = 0.6\nw = 0.6744\n[flight]\nx = 'v'\nv = '-x - 0.1767*v + f*cos(w*t)'\n{SECTIONS}\
         [[contact]]\nname = 'wall'\ngap = '0.8787 - x'\nimpulse = {{ v = -1 }}\n\
         restitution = 'if(v < 0.3565, 0.8061, 0.5702)'\n[initial]\nx = 0.1\nv = 0\n"
    );
    let expected = [
        (SpecialKind::Touch, 0.522_813_619_926_750_3),
        (SpecialKind::Fold, 0.949_655_260_015_167_5),
        (SpecialKind::FlightGraze, 0.952_353_623_051_733_2),
        (SpecialKind::Touch, 1.010_704_976_690_513_4),
    ];
    let model = with(&text, &[]);
    for step in [0.004, 0.03] {
        let found = follow(&model, ("f", (0.1, 1.1)), step, &Spec::default()).unwrap();
        let places = told(&found);
        assert_eq!(places.len(), expected.len(), "{step}: {places:?}");
        for (place, (kind, value)) in places.iter().zip(expected) {
            assert_eq!(place.0, kind);
            assert!((place.1 - value).abs() < 1e-14, "{step}: {place:?}");
        }
    }
    assert_eq!(
        is_the_same_from_everywhere(&text, ("f", (0.1, 1.1)), 4),
        Ok(4)
    );
}

/// A pair leaves the circle, becomes real, and one of the two comes back within it by a period doubling: within one step.
#[test]
fn a_pair_that_becomes_real_beside_the_circle_is_told() {
    let knocks = knocking([0.7593, 0.4942, 1.3624, 0.1536], (0.3488, 0.6307));
    let state = [
        0.43647108399658396,
        0.09659249433091233,
        0.6734148558012975,
        0.07858522643512501,
        8.274970771999982,
    ];
    for step in [0.03, 0.02] {
        let found = through(
            &knocks,
            ("f", 0.6),
            (&state, 8.27497077199998),
            ((0.1, 1.2), step),
        );
        let mut tori = found
            .special
            .iter()
            .filter(|special| special.kind == SpecialKind::NeimarkSacker);
        let torus = tori.next().unwrap();
        assert!(tori.next().is_none());
        let off = torus
            .point
            .multipliers
            .iter()
            .map(|m| (m.modulus() - 1.0).abs());
        assert_eq!(off.filter(|off| *off < 1e-10).count(), 2);
        let doublings = places(&found, SpecialKind::PeriodDoubling);
        assert_eq!(doublings.len(), 1);
        assert!(doublings[0] < torus.point.parameter());
    }
}

/// An orbit of more impacts than are followed is on no branch that is: nothing is told of it that would not be told from others.
#[test]
fn limits_hold_where_a_branch_begins() {
    const BALL: &str = "[parameters]\nf = 0.6\n[flight]\nx = 'v'\nv = '-0.1392*v + f*cos(0.8116*t) - 0.2144*x'\n\
        [[contact]]\nname = 'up'\ngap = '0.5008 - x'\nimpulse = { v = -1 }\nrestitution = 0.4818\n\
        [[contact]]\nname = 'down'\ngap = '0.5608 + x'\nimpulse = { v = 1 }\nrestitution = 0.7646\n\
        [initial]\nx = 0.2\nv = 0.1\n";
    let model = with(BALL, &[]);
    let found = follow(&model, ("f", (0.2, 1.0)), 0.04, &Spec::default()).unwrap();
    assert_eq!(found.points.len(), 1);
    assert_eq!(found.points[0].impacts, Some(7));
    assert!(found.special.is_empty());
    assert_eq!(found.ends, [End::Impacts(6), End::Impacts(6)]);
}

/// A kick whose strength is a state: at a value of the parameter nothing holds the orbits back. As they grow all lengths are forgotten: the oscillator
/// swings for half a period from where it is kicked and thrown back to where it is kicked again, k* = (v - 1/r)/u with v and u when it comes back,
/// from the speed 1 (in 30 digits by mpmath).
#[test]
fn a_branch_whose_orbits_grow_without_bound_says_where() {
    for step in [0.1, 0.2] {
        let found = follow(
            &with(KICKED, &[]),
            ("k", (0.4, 2.0)),
            step,
            &Spec::default(),
        )
        .unwrap();
        let grown = found.ends.iter().find_map(|end| match end {
            End::Growth(growth) => Some(growth),
            _ => None,
        });
        let grown = grown.unwrap();
        assert!(
            (grown.value - 1.213_148_617_858_093_5).abs() <= grown.error,
            "{grown:?}"
        );
        assert!(grown.error < 1e-12 && grown.power == 1, "{grown:?}");
    }
}

const KINDS: usize = 10;

fn all_are_the_same(seed: u64, rounds: usize, orbits: usize) {
    let mut drawn = Drawn(seed);
    let (mut points, mut wrong) = (0, Vec::new());
    for round in 0..rounds * KINDS {
        let (text, name, range) = draw(round % KINDS, &mut drawn);
        match is_the_same_from_everywhere(&text, (name, range), orbits) {
            Ok(found) => points += found,
            Err(why) => wrong.push(format!("{text}{name} over {range:?}\n{why}\n")),
        }
    }
    assert!(wrong.is_empty(), "{}: {}", wrong.len(), wrong.join("\n"));
    assert!(points > rounds * KINDS / 2, "{points}");
}

#[test]
fn special_points_depend_on_no_step_no_section_and_no_start() {
    all_are_the_same(1, 1, 2);
}

/// `CHATTER_SEED=7 cargo test --release -p chatter-dynamics --test analysis any_start -- --ignored`
#[test]
#[ignore = "takes minutes"]
fn those_of_many_models_depend_on_no_step_no_section_and_no_start() {
    let seed = std::env::var("CHATTER_SEED").map_or(2, |seed| seed.parse().unwrap());
    all_are_the_same(seed, 10, 6);
}
