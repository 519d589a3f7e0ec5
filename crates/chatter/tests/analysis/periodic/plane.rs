//! Curves in two parameters, and the points of codimension two on them.

use super::plane_listed::is_on;
use super::{GRAZES, model, nearest, over, value, with};
use chatter::analysis::periodic::{
    Beside, Branch, BranchSpec, End, Known, Limits, PeriodicError, Point, Spec, Special,
    SpecialCurve, SpecialKind, branches, special_curve,
};
use chatter::model::Model;
use std::ops::ControlFlow;

const DUFFING: &str = "[parameters]\nw = 1.3\nf = 0.3\n[flight]\nx = 'v'\nv = '-0.2*v - x - x^3 + f*cos(w*t)'\n\
                       [initial]\nx = 0\nv = 0\n";

pub(super) fn curve(
    model: &Model,
    free: [&str; 2],
    special: &Special,
    over: ((f64, f64), f64),
) -> SpecialCurve {
    curve_of(model, free, (&known(special), value(special)), over).unwrap()
}

/// What a special point is told by.
fn known(special: &Special) -> Known {
    Known {
        kind: special.kind,
        monitor: special.monitor,
        state: special.point.state.clone(),
        period: special.point.period,
    }
}

fn curve_of(
    model: &Model,
    free: [&str; 2],
    told: (&Known, f64),
    (range, longest_step): ((f64, f64), f64),
) -> Result<SpecialCurve, PeriodicError> {
    let limits = Limits {
        range,
        other: None,
        impacts: 60,
        points: 3000,
        longest_step,
    };
    curve_within(model, free, told, &limits)
}

pub(super) fn curve_within(
    model: &Model,
    free: [&str; 2],
    (known, at): (&Known, f64),
    limits: &Limits,
) -> Result<SpecialCurve, PeriodicError> {
    let mut model = model.clone();
    model.set_parameter(free[0], &format!("{at:?}")).unwrap();
    let free = free.map(|name| model.parameter_index(name).unwrap());
    let mut quiet = |_: chatter::analysis::periodic::Told<'_>| ControlFlow::Continue(());
    special_curve(
        &model,
        &Spec::default(),
        (free, known),
        limits,
        Vec::new(),
        &mut quiet,
    )
}

pub(super) fn of(curve: &SpecialCurve, kind: SpecialKind) -> Vec<[f64; 2]> {
    let all = curve.special.iter().filter(|special| special.kind == kind);
    all.map(|special| [special.point.parameters[0], special.point.parameters[1]])
        .collect()
}

/// Without a wall: both folds of the resonance meet in a cusp. Its place is that of SciPy's DOP853 with the fold's equations
/// and differences along the null vector.
#[test]
fn the_folds_of_duffings_oscillator_meet_in_a_cusp() {
    let duffing = with(DUFFING, &[]);
    let found = over(&duffing, "f", (0.2, 0.4), (10, 0.02));
    let folds: Vec<&Special> = (found[0].special.iter())
        .filter(|special| special.kind == SpecialKind::Fold)
        .collect();
    assert_eq!(folds.len(), 2);
    assert!(folds[0].above != folds[1].above);
    let curve = curve(&duffing, ["f", "w"], folds[0], ((1.1, 1.4), 0.05));
    assert_eq!(curve.ends, [End::Range, End::Range]);
    let cusps = of(&curve, SpecialKind::Cusp);
    assert_eq!(cusps.len(), 1, "{:?}", curve.special);
    assert!((cusps[0][0] - 0.164_702_26).abs() < 1e-7, "{cusps:?}");
    assert!((cusps[0][1] - 1.187_299_86).abs() < 1e-7, "{cusps:?}");
    // Each of the folds lies on it, one to each side of the cusp.
    let cusp = curve.special[0].place;
    let [before, beyond] = [&curve.points[..cusp], &curve.points[cusp..]];
    let on = folds.iter().map(|fold| {
        [&*curve.points, before, beyond]
            .map(|part| is_on(&duffing, ["f", "w"], fold, ((1.1, 1.4), fold.kind, part)))
    });
    let on: Vec<[bool; 3]> = on.collect();
    assert!(on.iter().all(|&[all, ..]| all), "{on:?}");
    assert!(
        on.iter().all(|&[_, before, beyond]| before != beyond),
        "{on:?}"
    );
    assert!(on[0][1] != on[1][1], "{on:?}");
}

/// Fixed points x^2 = 1 - f - b^2 of a map fold at x = 0: of all that curve f is largest where it is symmetric, and there it begins, swept over
/// either parameter.
#[test]
fn a_curve_begins_where_its_parameter_is_largest() {
    let text = "[parameters]\nf = 0.75\nb = 0\n[flight]\nclock = \"1\"\nx = \"0\"\n[[event]]\nname = \"step\"\n\
        surface = \"clock - 1\"\ndirection = \"rising\"\n[event.reset]\nclock = \"0\"\n\
        x = \"x + 0.3*(1 - f - b^2 - x^2)\"\n[initial]\nclock = 0\nx = 0.5\n";
    let found = over(&with(text, &[]), "f", (0.5, 1.5), (3, 0.05));
    let fold = nearest(&found, &[SpecialKind::Fold], 1.0);
    assert!((value(&fold) - 1.0).abs() < 1e-15);
    let there = with(text, &[("f", &*format!("{:?}", value(&fold)))]);
    let range = ((0.5, 1.5), 0.05);
    let curve = curve_of(&there, ["b", "f"], (&known(&fold), 0.0), range).unwrap();
    assert_eq!(curve.ends, [End::Range, End::Range]);
    for point in &curve.points {
        let [b, f] = point.parameters[..] else {
            panic!("{point:?}")
        };
        assert!((f - (1.0 - b * b)).abs() < 1e-14, "{b} {f}");
    }
    let sides = [curve.points.first(), curve.points.last()];
    let sides = sides.map(|end| end.map(|point| point.parameters[0]));
    assert!(
        sides[0].zip(sides[1]).is_some_and(|(a, b)| a * b < -0.49),
        "{sides:?}"
    );
}

/// x'' + c x' + x = cos(w t) below the wall s: the orbit without impacts touches it where its amplitude is s, and goes on
/// with one impact.
#[test]
fn an_orbit_without_impacts_touches_where_its_amplitude_says() {
    let text = "[parameters]\ns = 1.2\nc = 0.4\n[flight]\nx = 'v'\nv = '-x - c*v + cos(1.3*t)'\n[[contact]]\ngap = 's - x'\n\
                impulse = { v = -1 }\nrestitution = 0.7\n[initial]\nx = -0.924\nv = 0.906\n";
    let model = with(text, &[]);
    let amplitude = |c: f64| 1.0 / ((1.0 - 1.69_f64).powi(2) + (1.3 * c).powi(2)).sqrt();
    let found = over(&model, "s", (1.05, 1.3), (3, 0.05));
    let graze = nearest(&found, &GRAZES, 1.15);
    assert!((value(&graze) - amplitude(0.4)).abs() < 1e-13);
    assert_eq!(graze.point.impacts, Some(0));
    assert!(found[0].points.iter().any(|point| point.impacts == Some(1)));
    let curve = curve(&model, ["s", "c"], &graze, ((0.2, 0.6), 0.1));
    assert_eq!(curve.ends, [End::Range, End::Range]);
    for point in &curve.points {
        let [s, c] = point.parameters[..] else {
            panic!("{point:?}")
        };
        assert!((s - amplitude(c)).abs() < 1e-12, "{s} {c}");
        // Those of the orbit without the impact.
        let modulus = (-0.5 * c * core::f64::consts::TAU / 1.3).exp();
        assert!((point.multipliers[0].modulus() - modulus).abs() < 1e-10);
    }
}

/// A linear oscillator that touches a wall once a period: a kick at every touch moves the orbit there by the kick times
/// e^(-c T/2) sin(w_d T)/w_d over det(1 - A). Where the sine vanishes the impact costs no change of the parameter: the graze turns
/// from one that persists into a fold with a corner, and the curve of folds ends there.
#[test]
fn a_graze_persists_up_to_where_the_curve_of_folds_ends() {
    let text = "[parameters]\ns = 0.4\nw = 1.85\nc = 0.1\n[flight]\nx = 'v'\nv = '-x - c*v + cos(w*t)'\n[[contact]]\ngap = 's - x'\n\
                impulse = { v = -1 }\nrestitution = 0.7\n[initial]\nx = -0.414\nv = 0\n";
    let model = with(text, &[]);
    let corner = 2.0 * (1.0 - 0.0025_f64).sqrt();
    let found = over(&model, "s", (0.2, 0.6), (3, 0.05));
    let graze = nearest(&found, &GRAZES, 0.4);
    let curve = curve(&model, ["s", "w"], &graze, ((1.6, 2.4), 0.05));
    let ends = of(&curve, SpecialKind::GrazeFold);
    assert_eq!(ends.len(), 1, "{:?}", curve.special);
    assert!((ends[0][1] - corner).abs() < 1e-12, "{ends:?} {corner}");
}

/// A curve of tori holds its pair on the unit circle, and passes a quarter of a turn where an independent computation does.
#[test]
fn tori_of_two_masses_in_two_parameters() {
    let text = super::branches::TWO_MASSES.replace("restitution = 0.8", "restitution = 'r'");
    let text = text.replace("omega = 1.35", "omega = 1.35\nr = 0.8");
    let model = with(&text, &[]);
    let found = over(&model, "omega", (1.15, 1.4), (60, 0.02));
    let torus = nearest(&found, &[SpecialKind::NeimarkSacker], 1.2124);
    let curve = curve(&model, ["omega", "r"], &torus, ((0.7, 0.9), 0.05));
    for point in &curve.points {
        let neutral = point
            .multipliers
            .iter()
            .any(|m| (m.modulus() - 1.0).abs() < 1e-10);
        assert!(neutral, "{point:?}");
    }
    // Both tori of the branch at r = 0.8 are on it.
    let both = curve
        .points
        .windows(2)
        .filter(|pair| (pair[0].parameters[1] - 0.8) * (pair[1].parameters[1] - 0.8) <= 0.0);
    assert!(both.count() >= 1);
    // Where NumPy's matrix exponential and saltation matrix have the pair at i and -i.
    let quarters = of(&curve, SpecialKind::Resonance14);
    for at in [
        [1.232_094_738_509_506_2, 0.749_321_669_527_529_4],
        [1.202_254_778_022_405_3, 0.868_835_424_554_567],
    ] {
        let near = |found: &&[f64; 2]| (found[0] - at[0]).abs() + (found[1] - at[1]).abs() < 1e-11;
        assert!(quarters.iter().any(|found| near(&found)), "{quarters:?}");
    }
}

/// Branches over a parameter, with the zeros of a function of the user's.
fn watched(
    model: &Model,
    monitor: &str,
    name: &str,
    (range, impacts): ((f64, f64), u64),
) -> Vec<Branch> {
    let spec = Spec {
        monitors: vec![monitor.to_owned()],
        ..Spec::default()
    };
    let what = BranchSpec {
        parameter: model.parameter_index(name).unwrap(),
        limits: Limits {
            range,
            other: None,
            impacts,
            points: 1000,
            longest_step: 0.05,
        },
        beside: Beside::default(),
    };
    let mut quiet = |_: chatter::analysis::periodic::Told<'_>| ControlFlow::Continue(());
    branches(model, &spec, &what, Vec::new(), &mut quiet).unwrap()
}

/// A function of the user's vanishes where it should, and its zeros are a curve.
#[test]
fn functions_of_the_user_are_watched() {
    let text = "[parameters]\nw = 1.3\nc = 0.1\n[flight]\nx = 'v'\nv = '-x - c*v + cos(w*t)'\n[section.top]\n\
                surface = 'v'\ndirection = 'falling'\n[initial]\nx = 0\nv = 0\n";
    let model = with(text, &[]);
    let found = watched(&model, "x - 2", "w", ((1.1, 1.5), 5));
    let zero = nearest(&found, &[SpecialKind::Monitor], 1.2);
    let amplitude = |w: f64| 1.0 / ((1.0 - w * w).powi(2) + (0.1 * w).powi(2)).sqrt();
    assert!((amplitude(value(&zero)) - 2.0).abs() < 1e-11);
    assert_eq!(zero.monitor, Some(0));
}

/// An orbit with events is told at the section, where the function is the user's, with its whole period.
#[test]
fn functions_of_the_user_vanish_at_the_section() {
    let model = model("impact_oscillator", &[("sigma", "0")]);
    let found = watched(&model, "v - 0.025", "omega", ((2.4, 3.0), 40));
    let zero = nearest(&found, &[SpecialKind::Monitor], 2.843_261_324_753);
    let omega = value(&zero);
    assert!((omega - 2.843_261_324_753_44).abs() < 1e-12, "{omega}");
    assert!((zero.point.state[1] - 0.025).abs() < 1e-13);
    assert!((zero.point.period - 4.0 * std::f64::consts::PI / omega).abs() < 1e-12);
}

/// A mass between two walls, as in a harvester. Where it grazes one of them it is told of a graze that no event ends.
#[test]
fn a_graze_between_two_walls_is_found_again() {
    let text = "[parameters]\na = 1\nom = 1\n[flight]\nx = 'v'\nv = 'a*cos(om*t) - 0.1*v - 0.2*x'\n\
                [[contact]]\nname = 'left'\ngap = 'x + 0.5'\nimpulse = { v = 1 }\nrestitution = 0.7\n\
                [[contact]]\nname = 'right'\ngap = '0.5 - x'\nimpulse = { v = -1 }\nrestitution = 0.7\n\
                [section.strobe]\nsurface = 'sin(om*t)'\ndirection = 'rising'\n[initial]\nx = 0\nv = 0.1\n";
    let model = with(text, &[]);
    let found = over(&model, "a", (0.05, 3.0), (40, 0.01));
    let grazes =
        (found.iter().flat_map(|branch| &branch.special)).filter(|special| special.kind.is_graze());
    let mut gone_on = 0;
    for graze in grazes {
        let curve = curve(&model, ["a", "om"], graze, ((0.99, 1.01), 0.1));
        // Symmetric orbits touch both at once, which no curve of one graze goes on from.
        let double = End::At(SpecialKind::DoubleGraze);
        assert!(
            curve
                .ends
                .iter()
                .all(|end| [&End::Range, &double].contains(&end))
        );
        gone_on += usize::from(curve.ends[0] == End::Range);
        let passes = |point: &&Point| {
            (point.parameters[1] - 1.0).abs() < 1e-12
                && (point.parameters[0] - value(graze)).abs() < 1e-12
        };
        assert_eq!(curve.points.iter().filter(passes).count(), 1);
    }
    assert!(gone_on > 1, "{gone_on}");
}

/// An impact that passes a knot of the table which drives it is nothing that happens to the orbit, on curves in two parameters as on branches.
#[test]
fn impacts_pass_the_knots_of_a_table() {
    let text = r#"
[parameters]
d = 0.3
r = 0.6
T = 4.0
[table.push]
x = [0, 0.5, 1, 1.5, 2, 2.5, 3, 3.5, 4]
y = [0, 0.8, 1, 0.5, -0.3, -0.9, -1, -0.4, 0]
kind = "periodic-cubic"
[flight]
x = "v"
v = "-x - 0.1*v + push(4*t/T)"
[[contact]]
name = "wall"
gap = "d - x"
impulse = { v = -1 }
restitution = "r"
[initial]
x = 0
v = 0
"#;
    let driven = with(text, &[]);
    let found = over(&driven, "T", (2.0, 8.0), (40, 0.02));
    assert_eq!(found[0].ends, [End::Range, End::Range]);
    for (near, range) in [(3.175, (0.1, 0.6)), (7.02, (0.1, 0.6))] {
        let fold = nearest(&found, &[SpecialKind::Fold], near);
        let folds = curve(&driven, ["T", "d"], &fold, (range, 0.02));
        assert_eq!(folds.ends[1], End::Range, "{:?}", folds.ends);
        let [at, distance] = folds.points[folds.points.len() - 1].parameters[..] else {
            panic!();
        };
        assert!((distance - 0.6).abs() < 1e-12);
        // The same from the branch at that distance of the wall.
        let there = over(
            &with(text, &[("d", "0.6")]),
            "T",
            (at - 0.5, at + 0.5),
            (40, 0.02),
        );
        let fold = nearest(&there, &[SpecialKind::Fold], at);
        assert!((value(&fold) - at).abs() < 1e-9, "{} {at}", value(&fold));
    }
}

/// Where the graze of the valve with 36 impacts turns into a fold, from `reference/orbits.json`.
#[test]
fn the_graze_of_the_valve_becomes_a_fold() {
    let valve = model("pressure_relief_valve", &[("q", "0.02024")]);
    let found = over(&valve, "q", (0.02024, 0.02026), (40, 0.05));
    let graze = nearest(&found, &GRAZES, 0.020_248_774_288);
    let grazes = curve(&valve, ["q", "r"], &graze, ((0.71, 0.81), 0.05));
    let [[q, r]] = of(&grazes, SpecialKind::GrazeFold)[..] else {
        panic!("{:?}", of(&grazes, SpecialKind::GrazeFold));
    };
    assert!((q - 0.124_932_043_217_728_5).abs() < 1e-12, "{q}");
    assert!((r - 0.725_770_333_687_182_5).abs() < 1e-11, "{r}");
}

/// Two multipliers that are the same are known to the root of rounding only, but their sum is known. By Newton's method on det = 1 and
/// trace = -2 of the closed form of the flight, in thirty digits.
#[test]
fn a_double_multiplier_is_where_its_sum_says() {
    let model = model("impact_oscillator", &[("omega", "3.0")]);
    let found = over(&model, "zeta", (-0.15, 0.1), (40, 0.01));
    let doubling = nearest(&found, &[SpecialKind::PeriodDoubling], -0.05);
    let curve = curve(&model, ["zeta", "omega"], &doubling, ((2.1, 4.5), 0.01));
    let [zeta, omega] = (of(&curve, SpecialKind::Resonance12).into_iter())
        .min_by(|a, b| (a[1] - 3.104).abs().total_cmp(&(b[1] - 3.104).abs()))
        .expect("a resonance");
    assert!((zeta + 0.110_250_154_322_01).abs() < 1e-13, "{zeta}");
    assert!((omega - 3.104_378_977_884_62).abs() < 1e-13, "{omega}");
}

/// Two impact oscillators that are coupled. Where the pair of multipliers crosses the unit circle is followed wherever rows that were
/// taken at random lie on the way.
#[test]
fn a_curve_of_tori_goes_through() {
    let text = "[parameters]\nr2 = 0.6\nomega = 2.2\n[flight]\nx = 'v'\n\
                v = 'cos(omega*t) - x - 2*(x - y) - 0.08*v - 0.08*(v - w)'\ny = 'w'\n\
                w = '(-1.3*y + 2*(x - y) - 0.08*w + 0.08*(v - w))/1.7'\n\
                [[contact]]\nname = 'one'\ngap = '0.35 - x'\nimpulse = { v = -1 }\nrestitution = 0.75\n\
                [[contact]]\nname = 'two'\ngap = '0.5 - y'\nimpulse = { w = -1 }\nrestitution = 'r2'\n\
                [section.strobe]\nsurface = 'sin(omega*t)'\ndirection = 'rising'\n\
                [initial]\nx = 0\nv = 0.1\ny = 0\nw = 0\n";
    let model = with(text, &[]);
    let found = over(&model, "omega", (2.0, 3.2), (10, 0.05));
    let torus = nearest(&found, &[SpecialKind::NeimarkSacker], 2.71);
    let curve = curve(&model, ["omega", "r2"], &torus, ((0.3, 0.95), 0.03));
    assert_eq!(curve.ends, [End::Range, End::Range]);
}

/// Orbits of two periods of the force with two impacts, where one of these loses its rate. The motion starts beside such an orbit, where
/// that is stable: elsewhere what it settles to is a matter of rounding.
fn grazes_beside_the_doubling() -> (Model, Special) {
    let settings = [("sigma", "0.2"), ("zeta", "0.05"), ("omega", "2.538")];
    let mut model = model("impact_oscillator", &settings);
    for (state, value) in [("x", "-0.883"), ("v", "0.1255")] {
        model.set_initial(state, value).unwrap();
    }
    let found = over(&model, "omega", (2.4, 2.6), (3, 0.05));
    let graze = nearest(&found, &GRAZES, 2.423_367);
    (model, graze)
}

/// A linear oscillator touches a wall once a period, and an impact costs nothing where half its own period is one of the force's: there
/// orbits of two periods with one impact have met those that touch each time, and their curve of grazes ends. It is singular there, and
/// is known to rounding all the same, as told.
#[test]
fn a_curve_of_grazes_of_doubled_orbits_ends_where_both_halves_graze() {
    let zeta = 0.05_f64;
    let (model, graze) = grazes_beside_the_doubling();
    assert_eq!(graze.point.impacts, Some(1));
    let omega = 2.0 * (1.0 - zeta * zeta).sqrt();
    let sigma = 1.0 / (1.0 - omega * omega).hypot(2.0 * zeta * omega);
    for step in [0.02, 0.007] {
        let curve = curve(&model, ["omega", "sigma"], &graze, ((0.1, 0.6), step));
        assert_eq!(curve.ends[1], End::At(SpecialKind::DoubleGraze));
        let end = curve.special.last().unwrap();
        let off = (end.point.parameters[1] - sigma).abs();
        assert!(off <= end.error && end.error < 1e-12, "{off} {end:?}");
        assert!((end.point.parameters[0] - omega).abs() < 1e-12);
        // With an impact that grazes besides the one that is left out multipliers have a pole.
        assert!(end.point.multipliers.is_empty());
        let folds = of(&curve, SpecialKind::GrazeFold);
        assert!(
            folds.iter().all(|at| (at[1] - sigma).abs() > 1e-3),
            "{folds:?}"
        );
    }
}

/// Of a pair with play the curve of grazes of doubled orbits ends on that of the simple ones, and so does the curve of their doublings: at one
/// place. Near there rounding tells a flight that goes through the wall for the impact that loses its rate: that to it (steps of 0.002 and 0.02),
/// or that from it.
#[test]
fn curves_of_grazes_and_doublings_end_where_both_halves_graze() {
    let model = with(
        "[parameters]\nd = 1.567\nr = 0.5237\nc = 0.2612\n[flight]\nx = 'v'\nv = '-c*v'\n[[contact]]\nname = 'right'\n\
         gap = 'd/2 + sin(t) - x'\nimpulse = { v = -1 }\nrestitution = 'r'\n[[contact]]\nname = 'left'\n\
         gap = 'x - sin(t) + d/2'\nimpulse = { v = 1 }\nrestitution = 'r'\n[section.strobe]\nsurface = 'sin(t)'\n\
         direction = 'rising'\n[initial]\nx = 0\nv = 1.3\n",
        &[],
    );
    let found = over(&model, "r", (0.45, 0.65), (12, 0.05));
    let graze = nearest(&found, &GRAZES, 0.6325);
    let doubling = nearest(&found, &[SpecialKind::PeriodDoubling], 0.4924);
    let limits = ((0.25, 0.4), 0.02);
    let doublings = curve(&model, ["r", "c"], &doubling, limits);
    let end = doublings.special.iter();
    let mut end = end.filter(|special| special.kind == SpecialKind::GrazeDoubling);
    let expected = end.next_back().unwrap().point.parameters.clone();
    for step in [0.002, 0.01, 0.02, 0.03] {
        let curve = curve(&model, ["r", "c"], &graze, ((0.0, 0.5), step));
        let double = curve.special.iter();
        let mut double = double.filter(|special| special.kind == SpecialKind::DoubleGraze);
        let (Some(double), None) = (double.next(), double.next()) else {
            panic!("{step}: {:?}", curve.special)
        };
        let found = &double.point.parameters;
        let off = (0..2).map(|k| (found[k] - expected[k]).abs());
        let off = off.fold(0.0, f64::max);
        assert!(
            off < 1e-12 && double.error < 1e-12,
            "{step}: {off} {double:?}"
        );
    }
}

/// A branch of doubled orbits ends where both halves of its orbit graze, and what is followed from there are the simple orbits that graze.
#[test]
fn grazes_of_both_halves_are_those_of_the_simple_orbit() {
    let (model, simple) = grazes_beside_the_doubling();
    let mut doubled = simple.clone();
    doubled.point.period *= 2.0;
    let [one, two] = [&simple, &doubled].map(|graze| {
        let curve = curve(&model, ["omega", "sigma"], graze, ((0.15, 0.25), 0.05));
        assert_eq!(curve.ends, [End::Range, End::Range]);
        curve.points
    });
    for at in [0, 1] {
        let ends =
            |points: &[Point]| [&points[0], points.last().unwrap()].map(|p| p.parameters[at]);
        let off = ends(&one)
            .into_iter()
            .zip(ends(&two))
            .map(|(a, b)| (a - b).abs());
        assert!(off.fold(0.0, f64::max) < 1e-11);
    }
}

/// x' = y, y' = a - b x - y^2 + R x y + S y^3 with R = 0 = S keeps areas where b = 1: at a = 0 its multipliers are i and -i, and a curve of tori that
/// begins there begins on a point of codimension two.
#[test]
fn a_curve_that_begins_on_a_point_of_codimension_two_tells_it() {
    let (r, s) = (0.3_f64, -0.2_f64);
    let text = format!(
        "[parameters]\na = 0\nb = 0.9\n[flight]\nx = '0'\ny = '0'\nc = '1'\n[[event]]\nname = 'tick'\nsurface = 'c - 1'\n\
         direction = 'rising'\nreset = {{ x = 'y', y = 'a - b*x - y^2 + {r}*x*y + {s}*y^3', c = '0' }}\n[initial]\nx = 0\ny = 0\nc = 0\n"
    );
    let model = with(&text, &[]);
    let found = over(&model, "b", (0.5, 1.5), (4, 0.05));
    let torus = nearest(&found, &[SpecialKind::NeimarkSacker], 1.0);
    // The trace vanishes at x = y = 0, and at the other root of (R - 2) x + 3 S x^2.
    let x = (2.0 - r) / (3.0 * s);
    let b = 1.0 + r * x;
    let other = [b, x + b * x + x * x - r * x * x - s * x * x * x];
    for step in [0.02, 0.005] {
        let curve = curve(&model, ["b", "a"], &torus, ((-6.0, 12.0), step));
        let both = [
            End::At(SpecialKind::Resonance12),
            End::At(SpecialKind::Resonance12),
        ];
        assert_eq!(curve.ends, both);
        let found = of(&curve, SpecialKind::Resonance14);
        assert_eq!(found.len(), 2, "{found:?}");
        for (found, expected) in found.iter().zip([other, [1.0, 0.0]]) {
            let off = (0..2).map(|k| (found[k] - expected[k]).abs());
            assert!(off.fold(0.0, f64::max) < 1e-12, "{found:?}");
        }
        let all = curve.special.iter();
        assert!(all.clone().all(|special| special.error > 0.0));
        // Each once, and in order.
        let values: Vec<f64> = all.map(|special| special.point.parameters[1]).collect();
        assert!(
            values.windows(2).all(|pair| pair[0] < pair[1]),
            "{values:?}"
        );
    }
}

/// A doubling of a quite different orbit, or a fold told as a doubling, is none here: that is said, and no curve told.
#[test]
fn a_point_that_is_no_such_point_has_no_curve() {
    let duffing = with(DUFFING, &[]);
    let found = over(&duffing, "f", (0.2, 0.4), (10, 0.02));
    let fold = nearest(&found, &[SpecialKind::Fold], 0.3);
    let range = ((1.1, 1.4), 0.05);
    let known = |kind: SpecialKind| Known {
        kind,
        monitor: None,
        state: fold.point.state.clone(),
        period: fold.point.period,
    };
    let (as_told, elsewhere) = (value(&fold), 1.2 * value(&fold));
    for (kind, at) in [
        (SpecialKind::PeriodDoubling, as_told),
        (SpecialKind::NeimarkSacker, as_told),
        (SpecialKind::Fold, elsewhere),
    ] {
        let followed = curve_of(&duffing, ["f", "w"], (&known(kind), at), range);
        let why = followed.map(|curve| curve.points.len());
        assert!(
            matches!(
                why,
                Err(PeriodicError::NotThere { .. }
                    | PeriodicError::NotOfKind { .. }
                    | PeriodicError::NoConvergence { .. })
            ),
            "{kind:?}: {why:?}"
        );
    }
}

/// A curve keeps to the range of the other parameter as it does to that of its own, and ends at the edge itself.
#[test]
fn a_curve_keeps_to_the_ranges_of_both_parameters() {
    let duffing = with(DUFFING, &[]);
    let found = over(&duffing, "f", (0.2, 0.4), (10, 0.02));
    let fold = nearest(&found, &[SpecialKind::Fold], 0.3);
    let known = Known {
        kind: fold.kind,
        monitor: None,
        state: fold.point.state.clone(),
        period: fold.point.period,
    };
    let (at, half) = (value(&fold), 0.01);
    let mut limits = Limits {
        range: (1.0, 1.6),
        other: Some((at - half, at + half)),
        impacts: 60,
        points: 3000,
        longest_step: 0.01,
    };
    let curve = curve_within(&duffing, ["f", "w"], (&known, at), &limits).unwrap();
    assert_eq!(curve.ends, [End::Range, End::Range]);
    let first = |point: &Point| point.parameters[0] - at;
    let inside = |point: &Point| first(point).abs() <= half * (1.0 + 1e-9);
    assert!(curve.points.len() > 3 && curve.points.iter().all(inside));
    let ends = [&curve.points[0], &curve.points[curve.points.len() - 1]];
    assert!(
        ends.iter()
            .all(|end| (first(end).abs() - half).abs() < 1e-12)
    );
    limits.other = Some((at + half, at + 2.0 * half));
    let refused = curve_within(&duffing, ["f", "w"], (&known, at), &limits);
    assert!(matches!(refused, Err(PeriodicError::OutOfRange { .. })));
}

/// A mass rattles between two springs with play. Where the curve of its doublings comes to where the orbit touches the other spring it goes on with the
/// orbits that press it. (The touch by SciPy's DOP853, the orbit told from it: x = -b, with a multiplier of -1.)
#[test]
fn a_curve_of_doublings_passes_where_a_spring_is_touched() {
    // The other spring is not pressed.
    let free = (
        [0.238_647_257_034_490_25, 0.688_155_637_206_443_5],
        [-0.744_194_219_977_444_2, 0.112_737_237_303_040_67],
    );
    for step in [0.05, 0.2] {
        comes_through_the_touch(free, step);
    }
}

/// And comes back from them as well.
#[test]
fn a_curve_of_doublings_passes_where_a_spring_is_left() {
    let presses = (
        [0.246_801_465_256_053_43, 0.672_019_385_652_484_5],
        [-0.894_461_672_876_993_7, 0.118_368_766_887_246_26],
    );
    for step in [0.05, 0.2] {
        comes_through_the_touch(presses, step);
    }
}

fn comes_through_the_touch(([first, om], [x, v]): ([f64; 2], [f64; 2]), longest_step: f64) {
    const RATTLE: &str = "[parameters]\nom = 1.488\nF1 = 0.142\n[flight]\nx = 'v'\n\
        v = '0.208 + F1*cos(om*t) - 0.04746*v - max(x - 0.91, 0) - 0.01188*max(x - 0.91, 0)^3 \
        + max(-x - 0.91, 0) + 0.01188*max(-x - 0.91, 0)^3'\n\
        [section.strobe]\nsurface = 'sin(om*t)'\ndirection = 'rising'\n[initial]\nx = 0.8\nv = 0\n";
    let rattle = with(RATTLE, &[("om", &format!("{om:?}"))]);
    let period = core::f64::consts::TAU / om;
    let known = Known {
        kind: SpecialKind::PeriodDoubling,
        monitor: None,
        state: vec![x, v, period],
        period,
    };
    let limits = Limits {
        range: (0.666, 0.69),
        other: Some((0.2, 0.25)),
        impacts: 60,
        points: 300,
        longest_step,
    };
    let curve = curve_within(&rattle, ["F1", "om"], (&known, first), &limits).unwrap();
    assert_eq!(curve.ends, [End::Range, End::Range], "{longest_step}");
    let touches = of(&curve, SpecialKind::Touch);
    let is_there = |at: &[f64; 2]| (at[0] - 0.237_443_24).hypot(at[1] - 0.666_823_98) < 1e-8;
    assert!(
        matches!(&touches[..], [at] if is_there(at)),
        "{longest_step}: {touches:?}"
    );
}

/// Of which kinds there are curves is said where there is none.
#[test]
fn of_a_kind_without_curves_that_is_said() {
    let duffing = with(DUFFING, &[]);
    for kind in [
        SpecialKind::Hopf,
        SpecialKind::BranchPoint,
        SpecialKind::Touch,
    ] {
        let known = Known {
            kind,
            monitor: None,
            state: vec![0.0, 0.0, 0.0],
            period: core::f64::consts::TAU / 1.3,
        };
        let found = curve_of(&duffing, ["f", "w"], (&known, 0.3), ((1.1, 1.4), 0.05));
        let error = found.unwrap_err();
        let is_of_kind = matches!(error, PeriodicError::NoCurve { kind: told } if told == kind);
        assert!(is_of_kind, "{error}");
        let (followed, told) = { error.to_string() }
            .split_once(", and not of ")
            .map(|(one, other)| (one.to_owned(), other.to_owned()))
            .unwrap();
        assert_eq!(told, format!("`{}`", kind.name()));
        assert!(followed.contains("`fold`, `period_doubling`, `neimark_sacker`"));
        assert!(!followed.contains(kind.name()), "{followed}");
    }
}
