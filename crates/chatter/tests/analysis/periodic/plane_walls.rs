//! Curves in two parameters of orbits that graze more than one wall, or one wall more than once.

use super::plane::{curve_within, of};
use super::{GRAZES, model, nearest, over, value, with};
use chatter::analysis::periodic::{End, Known, Limits, Spec, SpecialKind, Told, special_curve};
use std::ops::ControlFlow;

fn limits(range: (f64, f64), other: (f64, f64), longest_step: f64) -> Limits {
    Limits {
        range,
        other: Some(other),
        impacts: 60,
        points: 3000,
        longest_step,
    }
}

/// A linear oscillator between two walls grazes both at once, to rounding all along the curve, and nothing ends there. Its curve is the amplitude of the forced motion, and its multipliers are those of the free one.
#[test]
fn a_curve_of_grazes_of_both_walls_at_once_goes_on() {
    let zeta = 0.1_f64;
    let settings = [("omega", "0.65"), ("sigma", "1.89"), ("zeta", "0.1")];
    let model = model("impact_oscillator_two_sided", &settings);
    let found = over(&model, "omega", (0.64, 0.72), (6, 0.05));
    let graze = nearest(&found, &GRAZES, 0.7);
    let known = Known {
        kind: graze.kind,
        monitor: None,
        state: graze.point.state.clone(),
        period: graze.point.period,
    };
    for step in [0.02, 0.1] {
        let limits = limits((1.2, 4.0), (0.3, 0.95), step);
        let told = (&known, value(&graze));
        let curve = curve_within(&model, ["omega", "sigma"], told, &limits).unwrap();
        assert_eq!(curve.ends, [End::Range, End::Range], "{step}");
        assert!(of(&curve, SpecialKind::DoubleGraze).is_empty());
        assert!(curve.points.len() > 20);
        for point in &curve.points {
            let [omega, sigma] = point.parameters[..] else {
                panic!("{point:?}")
            };
            let amplitude = 1.0 / (1.0 - omega * omega).hypot(2.0 * zeta * omega);
            assert!((sigma - amplitude).abs() < 1e-12 * sigma, "{omega} {sigma}");
            assert_eq!(point.impacts, Some(0));
            let [one, other] = point.multipliers[..] else {
                panic!("{:?}", point.multipliers)
            };
            let product = one.re * other.re - one.im * other.im;
            let expected = (-2.0 * zeta * point.period).exp();
            assert!((product - expected).abs() < 1e-10, "{product} {expected}");
        }
    }
}

/// An impact alone loses its rate beside the graze of the same wall, under friction that changes with that rate: that is told by what its acceleration
/// makes of the rate in a flight, and the curve ends where both halves graze, at long steps as at short ones.
#[test]
fn a_curve_of_doubled_grazes_under_friction_ends_on_that_of_the_simple_ones_whatever_the_step() {
    let text = "[parameters]\nw = 0.4\nd = 1.3\n[flight]\nx = 'v'\n\
                v = 'cos(w*t) - x - 0.05*v - 0.05*sign(v)*(1 + 0.5*max(v, 0))'\n[[contact]]\nname = 'wall'\n\
                gap = 'd - x'\nimpulse = { v = -1 }\nrestitution = 0.7\n[section.s]\nsurface = 'sin(w*t)'\n\
                direction = 'rising'\n[initial]\nx = 0\nv = 0.3\n";
    let (w, d) = (0.409_806_505_060_391_96, 1.189_746_545_116_341);
    let model = with(text, &[("w", &format!("{w:?}"))]);
    let period = 2.0 * core::f64::consts::TAU / w;
    let known = Known {
        kind: SpecialKind::FlightGraze,
        monitor: None,
        state: vec![
            1.186_897_410_084_392_8,
            0.037_019_783_040_222_13,
            0.5 * period,
        ],
        period,
    };
    for step in [0.02, 0.04] {
        let limits = limits((0.39, 0.42), (0.9, 1.4), step);
        let curve = curve_within(&model, ["d", "w"], (&known, d), &limits).unwrap();
        assert!(
            curve.ends.contains(&End::At(SpecialKind::DoubleGraze)),
            "{step}: {:?}",
            curve.ends
        );
        let [end] = of(&curve, SpecialKind::DoubleGraze)[..] else {
            panic!("{step}: {:?}", curve.special)
        };
        let off = (end[0] - 1.174_079_702_410_015_4).abs();
        let off = off.max((end[1] - 0.399_562_575_952_393_64).abs());
        assert!(off < 1e-12, "{step}: {end:?}");
    }
}

/// Where the orbit on a curve of zeros of a function loses its impact at a graze the curve ends, and says so. (The place is that of SciPy's DOP853 with the
/// orbit that the wall is touched by.)
#[test]
fn a_curve_of_zeros_of_a_function_ends_at_a_graze() {
    let text = "[parameters]\nw = 1.4\nA = 0.0666\n[flight]\nx = 'v'\nv = '-0.2*v + x - x^3 + A*cos(w*t)'\n[[contact]]\n\
                name = 'wall'\ngap = '1.2 - x'\nimpulse = { v = -1 }\nrestitution = 0.6\n[section.s]\n\
                surface = 'sin(w*t)'\ndirection = 'rising'\n[initial]\nx = 0.9\nv = 0.3\n";
    let (w, force) = (1.415_058_416_605_750_3, 0.066_626_473_151_366_33);
    let values = [("w", format!("{w:?}")), ("A", format!("{force:?}"))];
    let model = with(
        text,
        &values.each_ref().map(|(name, value)| (*name, &**value)),
    );
    let period = core::f64::consts::TAU / w;
    let known = Known {
        kind: SpecialKind::Monitor,
        monitor: Some(0),
        state: vec![0.9, 0.293_559_834_736_219, period],
        period,
    };
    let spec = Spec {
        monitors: vec!["x - 0.9".to_owned()],
        ..Spec::default()
    };
    let free = ["w", "A"].map(|name| model.parameter_index(name).unwrap());
    for step in [0.005, 0.02] {
        let limits = limits((0.06, 0.08), (1.3, 1.5), step);
        let mut quiet = |_: Told<'_>| ControlFlow::Continue(());
        let free = (free, &known);
        let curve = special_curve(&model, &spec, free, &limits, Vec::new(), &mut quiet).unwrap();
        let graze = curve
            .special
            .iter()
            .find(|special| GRAZES.contains(&special.kind));
        let graze = graze.unwrap_or_else(|| panic!("{step}: {:?}", curve.ends));
        assert!(
            curve.ends.contains(&End::At(graze.kind)),
            "{:?}",
            curve.ends
        );
        let off = (graze.point.parameters[0] - 1.380_347_366_662_938).abs();
        let off = off.max((graze.point.parameters[1] - 0.064_718_460_989_658).abs());
        assert!(off < 1e-12 && graze.error < 1e-12, "{step}: {graze:?}");
        assert_eq!(graze.point.impacts, Some(0));
    }
}

/// A pendulum between two walls whose orbit is its own mirror image, and loses that: there the curve of its grazes meets that of the others, a multiplier is
/// 1, and the point is known to rounding at all steps and from both sides. (The place is that of SciPy's DOP853, where an eigenvalue of half a period is -1.)
#[test]
fn a_curve_of_symmetric_grazes_passes_where_symmetry_is_lost() {
    let text = "[parameters]\nF = 0.5\nsigma = 2.7\n[flight]\nx = 'v'\nv = '-0.2*v - sin(x) + F*cos(0.65*t)'\n[[contact]]\n\
                name = 'right'\ngap = 'sigma - x'\nimpulse = { v = -1 }\nrestitution = 0.7\n[[contact]]\nname = 'left'\n\
                gap = 'sigma + x'\nimpulse = { v = 1 }\nrestitution = 0.7\n[section.s]\nsurface = 'sin(0.65*t)'\n\
                direction = 'rising'\n[initial]\nx = 0\nv = 0\n";
    let period = core::f64::consts::TAU / 0.65;
    let starts = [
        [
            0.503_100_223_396_410_6,
            2.692_804_113_034_004,
            -1.995_630_227_071_345_3,
            1.195_525_095_492_179_4,
        ],
        [
            0.522_792_628_048_773_5,
            2.714_882_447_187_507_3,
            -2.070_984_611_883_627,
            1.145_954_666_680_09,
        ],
    ];
    for [force, wall, x, v] in starts {
        let model = with(text, &[("sigma", &format!("{wall:?}"))]);
        let known = Known {
            kind: SpecialKind::ImpactGraze,
            monitor: None,
            state: vec![x, v, period],
            period,
        };
        for step in [0.02, 0.05, 0.2] {
            let limits = limits((2.69, 2.72), (0.5, 0.53), step);
            let free = ["F", "sigma"];
            let curve = curve_within(&model, free, (&known, force), &limits).unwrap();
            assert_eq!(curve.ends, [End::Range, End::Range], "{force} {step}");
            let [special] = &curve.special[..] else {
                panic!("{force} {step}: {:?}", curve.special)
            };
            assert_eq!(special.kind, SpecialKind::GrazeFold);
            let off = (special.point.parameters[0] - 0.516_836_743_376_455).abs();
            let off = off.max((special.point.parameters[1] - 2.708_288_200_761_826).abs());
            assert!(
                off < 1e-12 && special.error < 1e-13,
                "{force} {step}: {off} {special:?}"
            );
        }
    }
}

/// Orbits of three periods of the force with two impacts and a graze. Their curve ends on that of orbits of one period that graze: where what a kick at the touch
/// does to the place a period later vanishes. All three impacts lose their rates at once there, so that the equations lose two ranks. The place is that of SciPy's DOP853 with the variational equation.
#[test]
fn a_curve_of_tripled_grazes_ends_on_that_of_the_simple_ones_whatever_the_step() {
    let text = "[parameters]\nF = 0.42138945881455914\nw = 1.1\n[flight]\nx = 'v'\nv = '0.3*(1 - x^2)*v - x + F*cos(w*t)'\n\
                [[contact]]\ngap = '1.2 - x'\nimpulse = { v = -1 }\nrestitution = 0.8\n[section.strobe]\nsurface = 'sin(w*t)'\n\
                direction = 'rising'\n[initial]\nx = 0\nv = 0\n";
    let driven = with(text, &[]);
    let known = Known {
        kind: SpecialKind::ImpactGraze,
        monitor: None,
        state: vec![
            0.186_563_528_354_722_23,
            -1.473_522_291_095_791_7,
            5.711_986_642_890_532,
        ],
        period: 17.135_959_928_671_6,
    };
    let [force, frequency] = [0.229_357_848_723_310, 0.994_648_214_644_928];
    for step in [0.2, 0.1] {
        let limits = limits((0.99, 1.101), (0.2, 0.5), step);
        let told = (&known, 0.421_389_458_814_559_14);
        let curve = curve_within(&driven, ["F", "w"], told, &limits).unwrap();
        assert_eq!(curve.ends, [End::At(SpecialKind::DoubleGraze), End::Range]);
        // No graze becomes a fold near there, as rounding said.
        let [end] = &curve.special[..] else {
            panic!("{step}: {:?}", curve.special);
        };
        let [f, w] = end.point.parameters[..] else {
            panic!("{end:?}");
        };
        let off = (f - force).abs().max((w - frequency).abs());
        assert!(
            off <= end.error && end.error < 1e-8,
            "{step}: {off:e} {:e}",
            end.error
        );
    }
}
