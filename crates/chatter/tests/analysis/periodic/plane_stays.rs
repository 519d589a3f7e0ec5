//! Curves of folds and doublings in two parameters beside a jump of the force: with a stay beyond the jump, and without.

use super::plane::{curve_within, of};
use super::{model, with};
use chatter::analysis::periodic::{End, Known, Limits, SpecialKind};

/// Preloaded springs to both sides and a rigid stop.
const VIBRATOR: &str = "[parameters]\nF = 0.9\nP = 0.15\nw = 0.8\n[flight]\nx = 'v'\n\
    v = 'F*cos(w*t) - 0.06*v - 0.3*x - if(x > 0.3, P + 3*(x - 0.3), if(x < -0.3, -P + 3*(x + 0.3), 0))'\n\
    [[contact]]\nname = 'stop'\ngap = '0.9 - x'\nimpulse = { v = -1 }\nrestitution = 0.6\n\
    [section.s]\nsurface = 'sin(w*t)'\ndirection = 'rising'\n[initial]\nx = 0\nv = 0\n";

/// Beside a jump a short stay has a multiplier beyond all bounds, but where what is in front of it vanishes: there the curve of folds with
/// the stay ends, and elsewhere that without. The one does not go on as the other, which is near, and there is no cusp. (Both places by the
/// closed form of the flights, with mpmath.)
#[test]
fn curves_of_folds_with_a_stay_beyond_a_jump_and_without_end_at_touches_of_their_own() {
    let with_stay = (
        [0.741_348_082_963_829_5, 0.743_260_627_976_835_2],
        [0.163_569_744_927_091_53, -0.699_190_260_139_146_2],
        [0.732_953_542_759_554_7, 0.734_467_130_791_423_1],
    );
    let without = (
        [0.738_150_222_783_474_9, 0.740_554_817_660_708_5],
        [0.170_479_512_391_568_5, -0.715_738_332_524_259_9],
        [0.737_407_293_301_287_5, 0.739_643_780_330_201_2],
    );
    for ([w, force], [x, v], at) in [with_stay, without] {
        let model = with(VIBRATOR, &[("F", &format!("{force:?}"))]);
        let period = core::f64::consts::TAU / w;
        let known = Known {
            kind: SpecialKind::Fold,
            monitor: None,
            state: vec![x, v, period],
            period,
        };
        for longest_step in [0.02, 0.01, 0.04] {
            let limits = Limits {
                range: (0.5, 1.3),
                other: Some((0.5, 0.76)),
                impacts: 60,
                points: 300,
                longest_step,
            };
            let curve = curve_within(&model, ["w", "F"], (&known, w), &limits).unwrap();
            let ends = [End::At(SpecialKind::Touch), End::Range];
            assert!(
                ends.iter().all(|end| curve.ends.contains(end)),
                "{:?}",
                curve.ends
            );
            assert!(of(&curve, SpecialKind::Cusp).is_empty(), "{longest_step}");
            let [touch] = &curve.special[..] else {
                panic!("{longest_step}: {:?}", curve.special)
            };
            let told = &touch.point.parameters;
            let off = (told[0] - at[0]).abs().max((told[1] - at[1]).abs());
            assert!(off <= touch.error.max(1e-14), "{off} {}", touch.error);
            assert!(touch.error < 1e-12, "{}", touch.error);
        }
    }
}

/// Where the preload comes to nothing, and the jump with it, the stay of a curve of doublings does, at long steps as at short ones: these may leap over
/// what is left of it. (The place by the closed form of the flights, with mpmath.)
#[test]
fn a_curve_of_doublings_ends_where_its_stay_does_whatever_the_steps() {
    let w = 0.760_920_799_009_485_5;
    let preload = 0.095_756_228_067_150_56;
    let model = with(VIBRATOR, &[("P", &format!("{preload:?}"))]);
    let period = core::f64::consts::TAU / w;
    let known = Known {
        kind: SpecialKind::PeriodDoubling,
        monitor: None,
        state: vec![0.335_711_368_782_973_6, -0.218_699_481_833_229_82, period],
        period,
    };
    for longest_step in [0.04, 0.01] {
        let limits = Limits {
            range: (0.0, 0.12),
            other: None,
            impacts: 60,
            points: 300,
            longest_step,
        };
        let curve = curve_within(&model, ["w", "P"], (&known, w), &limits).unwrap();
        let is_touch = curve.ends.contains(&End::At(SpecialKind::Touch));
        assert!(is_touch, "{longest_step}: {:?}", curve.ends);
        let touches = of(&curve, SpecialKind::Touch);
        let [touch] = &touches[..] else {
            panic!("{longest_step}: {touches:?}")
        };
        let off = (touch[0] - 0.755_393_156_236_185_4)
            .abs()
            .max(touch[1].abs());
        assert!(off < 1e-14, "{touch:?}");
    }
}

/// Beside a touch n (I - M)^-1 M e vanishes where a curve of folds ends with its stay, with the monodromy M of the orbit without it, seen from the touch, n across
/// the surface and e along the jump of the force: so it does at this place, to 2e-14, by SciPy's DOP853. Other events are nearer to the stay there than stays
/// from which its end is extrapolated elsewhere.
#[test]
fn a_curve_of_folds_ends_where_its_stay_does_between_other_events() {
    let (preload, omega) = (0.133_335_299_162_766_12, 0.250_317_000_431_285_24);
    let model = model("preloaded_stop", &[("preload", &format!("{preload:?}"))]);
    let period = core::f64::consts::TAU / omega;
    let known = Known {
        kind: SpecialKind::Fold,
        monitor: None,
        state: vec![0.423_834_734_053_867_9, -0.033_311_634_387_168_984, period],
        period,
    };
    for longest_step in [0.005, 0.02] {
        let limits = Limits {
            range: (0.12, 0.14),
            other: None,
            impacts: 60,
            points: 300,
            longest_step,
        };
        let curve = curve_within(&model, ["omega", "preload"], (&known, omega), &limits).unwrap();
        let is_touch = curve.ends.contains(&End::At(SpecialKind::Touch));
        assert!(is_touch, "{longest_step}: {:?}", curve.ends);
        let [touch] = of(&curve, SpecialKind::Touch)[..] else {
            panic!("{longest_step}: {:?}", curve.special)
        };
        let off = (touch[0] - 0.250_475_156_781_617_5).abs();
        let off = off.max((touch[1] - 0.127_137_977_843_327_3).abs());
        assert!(off < 1e-13, "{longest_step}: {touch:?}");
    }
}

/// Long steps end where short ones do: there a surface is touched while the stay has a while to last. Without that stay another curve of folds passes by,
/// whose touch is nearer than a step; but the stay does not lead there as it becomes shorter.
#[test]
fn a_curve_of_folds_does_not_go_on_as_one_that_its_stay_does_not_lead_to() {
    let model = model("preloaded_stop", &[]);
    let omega = 0.245_658_918_103_007_08;
    let period = core::f64::consts::TAU / omega;
    let known = Known {
        kind: SpecialKind::Fold,
        monitor: None,
        state: vec![0.425_606_2, -0.004_894_57, period],
        period,
    };
    for longest_step in [0.02, 0.01] {
        let limits = Limits {
            range: (0.0, 1.0),
            other: None,
            impacts: 60,
            points: 300,
            longest_step,
        };
        let curve = curve_within(&model, ["omega", "preload"], (&known, omega), &limits).unwrap();
        assert_eq!(
            curve.ends,
            [End::At(SpecialKind::Touch), End::At(SpecialKind::Touch)]
        );
        let touches = of(&curve, SpecialKind::Touch);
        let expected = [
            [0.245_051_604_726_788, 0.189_897_198_076_92],
            [0.247_034_068_127_122, 0.229_475_182_047_33],
        ];
        assert_eq!(touches.len(), expected.len(), "{longest_step}: {touches:?}");
        for (touch, expected) in touches.iter().zip(expected) {
            let off = (0..2).map(|k| (touch[k] - expected[k]).abs());
            assert!(off.fold(0.0, f64::max) < 1e-12, "{longest_step}: {touch:?}");
        }
    }
}

/// However wide the range that a curve of folds is followed over, and whatever its steps, it ends where its stay does, by what is extrapolated from longer
/// ones: another curve of folds without it has a touch beside that, at a stiffness of 16.737.
#[test]
fn a_curve_of_folds_ends_where_its_stay_does_over_any_range() {
    let model = model("preloaded_stop", &[("stiffness", "20")]);
    let omega = 0.411_151_354_033_420_6;
    let period = core::f64::consts::TAU / omega;
    let known = Known {
        kind: SpecialKind::Fold,
        monitor: None,
        state: vec![0.432_485_063_219_243, 0.124_948_735_338_264, period],
        period,
    };
    for (range, longest_step) in [
        ((10.0, 30.0), 0.05),
        ((2.0, 80.0), 0.05),
        ((1.0, 120.0), 0.02),
    ] {
        let limits = Limits {
            range,
            other: Some((0.408, 0.4115)),
            impacts: 60,
            points: 300,
            longest_step,
        };
        let curve = curve_within(&model, ["omega", "stiffness"], (&known, omega), &limits).unwrap();
        assert_eq!(
            curve.ends,
            [End::At(SpecialKind::Touch), End::Range],
            "{range:?}"
        );
        let [touch] = of(&curve, SpecialKind::Touch)[..] else {
            panic!("{range:?}: {:?}", curve.special)
        };
        let off = (touch[0] - 0.409_016_872_507_439).abs();
        let off = off.max(1e-2 * (touch[1] - 16.692_779_377_694_5).abs());
        assert!(off < 1e-13, "{range:?}: {touch:?}");
    }
}
