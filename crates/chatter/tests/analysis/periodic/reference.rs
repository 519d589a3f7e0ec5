//! Derivatives, branches and curves against values computed beforehand in quadruple precision.

use super::branches::{TWO_MASSES, TWO_SIDED};
use super::orbits::VALVE4;
use super::{GRAZES, model, nearest, orbit, over, value, with};
use chatter::analysis::periodic::{
    Branch, End, Known, Limits, Spec, Special, SpecialCurve, SpecialKind, special_curve,
};
use chatter::flow::{Column, Occurrence, Settings, System, Trajectory};
use chatter::model::Model;
use chatter::numerics::Real;
use std::ops::ControlFlow;

const PARAMETERS: [&str; 5] = ["q", "kappa", "delta", "beta", "r"];

/// What happened, when, and the state after it followed by its columns: by the states, then by all parameters.
type Event = (&'static str, f64, Vec<f64>);

fn events(model: &Model, start: &[f64], until: f64) -> Vec<Event> {
    let n = start.len();
    let columns: Vec<Column> = (0..n)
        .map(|_| Column::State)
        .chain((0..model.parameters.len()).map(Column::Parameter))
        .collect();
    let system = System::with_columns(model, &columns).unwrap();
    let mut state = start.to_vec();
    for index in 0..columns.len() {
        state.extend((0..n).map(|i| f64::from(u8::from(i == index))));
    }
    let parameters = model.parameter_values::<f64>(&[]);
    let mut work = system.workspace::<f64>(&Settings::default());
    let mut trajectory = Trajectory::start(&system, &mut work, &parameters, 0.0, &state).unwrap();
    let mut found = Vec::new();
    loop {
        let kind = match trajectory.advance(&system, &mut work, until).unwrap() {
            Some(Occurrence::Impact { .. }) => "impact",
            Some(Occurrence::Accumulation { .. }) => "accumulation",
            Some(Occurrence::Release { .. }) => "release",
            Some(Occurrence::Section { .. }) => "section",
            Some(Occurrence::Horizon) => return found,
            _ => continue,
        };
        found.push((kind, trajectory.time(), trajectory.state().to_vec()));
    }
}

fn first<'e>(events: &'e [Event], kind: &str) -> &'e Event {
    events.iter().find(|(of, ..)| *of == kind).unwrap()
}

fn assert_close(found: f64, expected: f64, tolerance: f64) {
    let off = (found - expected).abs() / expected.abs().max(1.0);
    assert!(off < tolerance, "{found:?} {expected:?} {off:e}");
}

/// Columns are taken at a time: that of an event's point less the field times that of its time.
#[test]
fn the_closing_map_of_the_valve_and_its_derivatives() {
    let valve = model("pressure_relief_valve", &[("q", "0.0195")]);
    let found = events(&valve, &[0.15, -0.5, 9.7], 10.0);
    // By y1, y2, q, kappa, delta, beta and r: of the time, then of y3 there.
    let check = |kind: &str, (time, y3): (f64, f64), dt: [f64; 7], dy3: [f64; 7]| {
        let (_, at, state) = first(&found, kind);
        assert_close(*at, time, 1e-13);
        assert_close(state[2], y3, 1e-13);
        let field = 20.0 * (0.0195 - state[0] * state[2].sqrt());
        for (k, column) in [0, 1, 3, 4, 5, 6, 7].into_iter().enumerate() {
            let derivative = state[3 * (column + 1) + 2];
            assert_close(derivative, dy3[k] - field * dt[k], 1e-11);
        }
    };
    check(
        "impact",
        (0.273_533_586_331_844_1, 8.514_469_518_706_581),
        [
            1.232_616_047_775_595_3,
            0.341_195_352_224_442_97,
            0.095_334_238_150_705_87,
            0.026_952_782_065_101_18,
            -0.051_311_096_580_513_83,
            -0.001_565_502_879_802_485,
            0.0,
        ],
        [
            -14.498_774_380_233_94,
            -1.766_028_260_953_550_3,
            5.128_352_909_925_985,
            -0.082_158_230_370_968_02,
            0.160_371_209_029_225_82,
            -0.053_352_659_371_146_4,
            0.0,
        ],
    );
    check(
        "accumulation",
        (1.985_338_485_529_781, 7.478_994_502_918_574),
        [
            -1.507_409_146_350_284,
            -0.423_401_227_345_351_7,
            6.832_154_368_389_853,
            -0.362_434_944_578_177_3,
            -0.225_756_806_690_746_43,
            -0.025_248_036_635_919_033,
            6.278_712_191_091_338,
        ],
        [
            -13.168_435_425_531_099,
            1.464_078_852_370_430_7,
            33.601_734_379_448_11,
            0.888_631_926_177_870_8,
            0.105_300_614_113_030_1,
            -0.073_964_445_214_972_62,
            -4.323_986_165_464_741,
        ],
    );
    // At release y3 is delta, at the section 9.7.
    let delta = [0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0];
    check(
        "release",
        (8.449_455_144_712_924, 10.0),
        [
            32.257_809_893_473_05,
            -4.177_449_566_756_712,
            -410.819_300_921_638_3,
            -2.640_978_345_034_256,
            2.068_344_182_763_022_6,
            -0.158_801_445_972_064_3,
            17.365_856_205_103_495,
        ],
        delta,
    );
    check(
        "section",
        (9.533_682_077_648_045, 9.7),
        [
            32.257_809_893_473_05,
            -4.177_449_566_756_712,
            -423.139_913_997_193_3,
            -2.554_154_204_855_772,
            2.860_951_964_703_895_6,
            -0.187_389_688_488_698_33,
            17.365_856_205_103_495,
        ],
        [0.0; 7],
    );
    let (_, _, state) = first(&found, "section");
    assert_close(state[0], 0.026_094_541_746_870_81, 1e-12);
    assert_close(state[1], -0.008_700_746_334_874_377, 1e-12);
}

/// The change of an orbit's period with a parameter, by differences of periods of thirty digits.
fn period_slope(model: &Model, parameter: &str, step: f64) -> f64 {
    let index = model.parameter_index(parameter).unwrap();
    let own = model.parameter_values::<f64>(&[])[index];
    let at = |shift: f64| {
        let mut model = model.clone();
        model
            .set_parameter(parameter, &format!("{:?}", own + shift))
            .unwrap();
        let shifted = model.parameter_values::<f64>(&[])[index];
        (orbit(&model).period, shifted)
    };
    let step = step * own;
    let slope = |step: f64| {
        let ((up, high), (down, low)) = (at(step), at(-step));
        (up - down).to_f64() / (high - low)
    };
    (4.0 * slope(0.5 * step) - slope(step)) / 3.0
}

#[test]
fn periods_through_complete_chatter_change_as_they_should() {
    let valve = model("pressure_relief_valve", &[("q", "0.0195")]);
    let found = orbit(&valve);
    assert_close(found.period.to_f64(), 3.526_655_749_659_584, 1e-14);
    assert!(found.multipliers.iter().all(|m| m.modulus() == 0.0));
    assert_close(found.trivial_multiplier.unwrap(), 1.0, 1e-10);
    let slopes = [
        -2.019_804_977_313_734_5,
        -0.743_102_170_818_113_5,
        -0.032_655_721_357_179_57,
        -0.038_563_650_915_822_24,
        3.914_982_132_442_431,
    ];
    for (name, expected) in PARAMETERS.into_iter().zip(slopes) {
        assert_close(period_slope(&valve, name, 2e-5), expected, 1e-10);
    }
    assert_close(
        period_slope(&with(VALVE4, &[]), "q", 2e-5),
        -1.725_862_931_985_504,
        1e-10,
    );
    let found = orbit(&model("pressure_relief_valve", &[]));
    assert_eq!(found.impacts, Some(34));
    assert_close(found.period.to_f64(), 3.524_824_504_277_329_3, 1e-14);
    assert_close(found.multipliers[0].re, -0.611_967_017_203_213_2, 1e-12);
    assert_close(found.multipliers[1].re * 1e9, -4.763_932_297_861_02, 1e-8);
    assert_close(
        period_slope(&model("pressure_relief_valve", &[]), "q", 1e-7),
        -0.902_539_623_049_639_4,
        1e-7,
    );
}

/// The map from release to release of a valve with four states: contact forgets two of them.
#[test]
fn the_release_map_of_a_valve_of_four_states() {
    let valve = with(VALVE4, &[]);
    let y4 = 0.019_894_297_788_098_34;
    let found = events(&valve, &[0.0, 0.0, 10.0, y4], 4.0);
    let (_, time, state) = first(&found, "release");
    assert_close(*time, 3.037_206_317_799_137, 1e-12);
    assert_close(
        first(&found, "accumulation").1,
        2.208_085_729_994_046,
        1e-12,
    );
    let field = 0.3 * (0.019 - state[3] - 0.004 * (state[2] - 10.0));
    // By y4, q, kappa, beta, gamma, c and r.
    for (column, dy4, dt) in [
        (3, 0.427_687_267_438_056_1, 28.504_219_071_905_01),
        (4, 0.598_540_204_853_233_3, -31.536_349_667_282_6),
        (5, -0.000_179_722_388_366_556_84, -0.394_010_580_052_670_5),
        (7, 2.309_717_660_789_951_7e-5, -0.038_847_405_660_571_32),
        (8, 9.086_117_236_774_3e-5, -0.054_119_516_568_775_34),
        (9, 0.133_142_551_385_117_3, -10.102_365_863_771_724),
        (10, 0.000_338_029_426_614_960_5, 1.368_259_652_442_605),
    ] {
        let derivative = state[4 * (column + 1) + 3];
        assert!(
            (derivative - (dy4 - field * dt)).abs() < 1e-12,
            "{column}: {derivative}"
        );
    }
}

/// Forced: the phase of chatter's end and of the release, which the load alone decides.
#[test]
fn chatter_of_forced_systems_ends_where_it_should() {
    let table = model("bouncing_ball_on_table", &[("Gamma", "1.2")]);
    let found = events(&table, &[0.02, 0.0, 0.0], 0.3);
    assert_close(
        first(&found, "accumulation").1,
        0.191_306_600_328_731_66,
        1e-13,
    );
    assert_close(first(&found, "release").1, 0.215_678_525_066_133_13, 1e-13);
    let oscillator = model("impact_oscillator", &[]);
    let found = orbit(&oscillator);
    assert_eq!(found.impacts, None);
    assert_close(found.period.to_f64(), core::f64::consts::TAU / 0.3, 1e-14);
    assert!(found.multipliers.iter().all(|m| m.modulus() == 0.0));
    // From the release at phase acos(0).
    let start = [0.0, 0.0, core::f64::consts::FRAC_PI_2 / 0.3];
    let begin = start[2];
    let system = System::new(&oscillator).unwrap();
    let mut work = system.workspace::<f64>(&Settings::default());
    let parameters = oscillator.parameter_values::<f64>(&[]);
    let mut trajectory = Trajectory::start(&system, &mut work, &parameters, begin, &start).unwrap();
    let mut times = Vec::new();
    while times.len() < 3 {
        match trajectory.advance(&system, &mut work, 60.0).unwrap() {
            Some(Occurrence::Impact { rate_before, .. }) if times.is_empty() => {
                assert_close(rate_before, -0.447_358_475_880_654_2, 1e-13);
                times.push(trajectory.time() - begin);
            }
            Some(Occurrence::Accumulation { .. } | Occurrence::Release { .. }) => {
                times.push(trajectory.time() - begin);
            }
            Some(Occurrence::Horizon) => panic!("{times:?}"),
            _ => {}
        }
    }
    for (found, expected) in times.iter().zip([
        11.402_394_043_879_825,
        17.102_586_003_473_208,
        20.943_951_023_931_955,
    ]) {
        assert_close(*found, expected, 1e-13);
    }
}

fn follow(
    model: &Model,
    free: [&str; 2],
    special: &Special,
    (range, longest_step): ((f64, f64), f64),
) -> SpecialCurve {
    let mut model = model.clone();
    model
        .set_parameter(
            free.into_iter()
                .find(|name| *name == "q" || *name == "omega")
                .unwrap(),
            &format!("{:?}", value(special)),
        )
        .unwrap();
    let known = Known {
        kind: special.kind,
        monitor: None,
        state: special.point.state.clone(),
        period: special.point.period,
    };
    let limits = Limits {
        range,
        other: None,
        impacts: 60,
        points: 3000,
        longest_step,
    };
    let free = free.map(|name| model.parameter_index(name).unwrap());
    let mut quiet = |_: chatter::analysis::periodic::Told<'_>| ControlFlow::Continue(());
    special_curve(
        &model,
        &Spec::default(),
        (free, &known),
        &limits,
        Vec::new(),
        &mut quiet,
    )
    .unwrap()
}

/// The first point of a curve at the low end of its range, or the last at the high end.
fn end_at(curve: &SpecialCurve, place: f64) -> chatter::analysis::periodic::Point {
    let at_end =
        |point: &&chatter::analysis::periodic::Point| (point.parameters[1] - place).abs() < 1e-14;
    let ends = [&curve.points[0], &curve.points[curve.points.len() - 1]];
    (ends.into_iter().find(at_end)).unwrap().clone()
}

fn arcs() -> Vec<Branch> {
    let valve = model("pressure_relief_valve", &[("q", "0.020185")]);
    over(&valve, "q", (0.02015, 0.02026), (60, 0.02))
}

#[test]
#[ignore = "takes half a minute"]
fn arcs_of_the_valve_and_their_curves_in_two_parameters() {
    let found = arcs();
    for (kinds, at, impacts, period) in [
        (
            &[SpecialKind::PeriodDoubling][..],
            0.020_162_252_788_521_224,
            38,
            3.525_246_552_475_871,
        ),
        (
            &[SpecialKind::Fold][..],
            0.020_158_379_913_459_48,
            38,
            3.525_257_104_459_044,
        ),
        (
            &GRAZES[..],
            0.020_209_433_153_759_982,
            37,
            3.525_277_435_342_566,
        ),
        (
            &[SpecialKind::Fold][..],
            0.020_182_579_910_832_31,
            37,
            3.525_186_137_369_561,
        ),
        (
            &[SpecialKind::PeriodDoubling][..],
            0.020_187_230_871_066_755,
            37,
            3.525_173_635_175_647_6,
        ),
    ] {
        let special = nearest(&found, kinds, at);
        assert!((value(&special) - at).abs() < 2e-13, "{special:?}");
        assert_eq!(special.point.impacts, Some(impacts));
        assert!((special.point.period - period).abs() < 1e-11, "{special:?}");
    }
    let valve = model("pressure_relief_valve", &[]);
    for (kinds, at, over_kappa, period) in [
        (
            &GRAZES[..],
            0.020_248_774_288_446_61,
            0.019_128_020_263_104_087,
            3.520_067_859_106_439,
        ),
        (
            &[SpecialKind::PeriodDoubling][..],
            0.020_187_230_871_066_755,
            0.019_066_779_587_176_33,
            3.520_027_702_304_216,
        ),
        (
            &[SpecialKind::Fold][..],
            0.020_182_579_910_832_31,
            0.019_062_107_319_059_847,
            3.520_040_241_823_89,
        ),
    ] {
        let special = nearest(&found, kinds, at);
        let curve = follow(&valve, ["q", "kappa"], &special, ((1.24, 1.26), 0.05));
        assert_eq!(curve.ends, [End::Range, End::Range], "{:?}", special.kind);
        let point = end_at(&curve, 1.26);
        assert!(
            (point.parameters[0] - over_kappa).abs() < 1e-12,
            "{point:?}"
        );
        assert!((point.period - period).abs() < 1e-10, "{point:?}");
    }
    for (kinds, at, kappa) in [
        (
            &GRAZES[..],
            0.020_248_774_288_446_61,
            1.249_542_943_434_720_4,
        ),
        (
            &[SpecialKind::PeriodDoubling][..],
            0.020_187_230_871_066_755,
            1.248_993_556_156_871,
        ),
        (
            &[SpecialKind::Fold][..],
            0.020_182_579_910_832_31,
            1.248_952_067_115_691,
        ),
    ] {
        let special = nearest(&found, kinds, at);
        let curve = follow(&valve, ["kappa", "q"], &special, ((0.0201, 0.0203), 0.2));
        let point = end_at(&curve, 0.0203);
        assert!((point.parameters[0] - kappa).abs() < 1e-11, "{point:?}");
    }
    let graze = nearest(&found, &GRAZES, 0.020_248_774_288_446_61);
    let curve = follow(&valve, ["q", "r"], &graze, ((0.72, 0.8), 0.02));
    let folds: Vec<&Special> = (curve.special.iter())
        .filter(|special| special.kind == SpecialKind::GrazeFold)
        .collect();
    assert_eq!(folds.len(), 1);
    let [q, r] = folds[0].point.parameters[..] else {
        panic!("two parameters");
    };
    assert!((q - 0.124_932_043_217_728_5).abs() < 1e-11, "{q}");
    assert!((r - 0.725_770_333_687_571_8).abs() < 1e-11, "{r}");
}

#[test]
fn grazes_and_doublings_of_the_forced_oscillator() {
    let oscillator = |omega: &str| model("impact_oscillator", &[("omega", omega), ("r", "0.5")]);
    let found = over(&oscillator("0.6081"), "omega", (0.607, 0.609), (11, 0.01));
    let graze = nearest(&found, &GRAZES, 0.608_193_037_535_510_8);
    assert!((graze.point.multipliers[0].re + 0.415_999_487_679_974_5).abs() < 1e-9);
    let other = nearest(&found, &GRAZES, 0.607_701_126_906_327_9);
    assert!((other.point.multipliers[0].re + 0.359_949_360_949_074_6).abs() < 1e-9);
    let fold = nearest(&found, &[SpecialKind::Fold], 0.607_727_487_515_739_8);
    assert!((value(&fold) - 0.607_727_487_515_739_8).abs() < 1e-13);
    assert_eq!(fold.point.impacts, Some(11));
    let own = nearest(&found, &[SpecialKind::Fold], 0.608_257_537_739_327_9);
    for (special, at) in [
        (&graze, 0.613_631_044_670_084_3),
        (&own, 0.613_691_568_666_569_5),
    ] {
        let curve = follow(
            &oscillator("0.6081"),
            ["omega", "zeta"],
            special,
            ((0.0, 0.005), 0.05),
        );
        let point = end_at(&curve, 0.005);
        assert!((point.parameters[0] - at).abs() < 1e-12, "{point:?}");
    }
    // The doubled orbit comes from the orbit of one impact a period.
    let oscillator = model("impact_oscillator", &[("omega", "2.7")]);
    let found = over(&oscillator, "omega", (2.6, 2.9), (11, 0.01));
    let leaves = nearest(&found, &[SpecialKind::BranchPoint], 2.653);
    assert!((value(&leaves) - 2.653_347_727_855_323).abs() < 1e-13);
    assert!(
        found[0]
            .ends
            .contains(&End::Again(SpecialKind::BranchPoint))
    );
}

#[test]
fn states_at_pitchfork_graze_and_torus() {
    let section = "[section.half]\nsurface = 'sin(omega*t)'\ndirection = 'falling'\n";
    let two = with(&(TWO_SIDED.to_owned() + section), &[]);
    let found = over(&two, "omega", (1.9, 3.0), (60, 0.01));
    let pitchfork = nearest(&found[..1], &[SpecialKind::BranchPoint], 2.5);
    assert!((value(&pitchfork) - 2.542_111_080_123_326_5).abs() < 1e-13);
    let [x, v, ..] = pitchfork.point.state[..] else {
        panic!("two states");
    };
    assert!((x + 0.142_154_845_449_447_6).abs() < 1e-11, "{x}");
    assert!((v + 0.546_292_980_182_642_4).abs() < 1e-11, "{v}");
    let grazes = found[1].special.iter().filter(|s| GRAZES.contains(&s.kind));
    let grazes: Vec<&Special> = grazes.collect();
    // Both mirror images.
    assert_eq!(grazes.len(), 2);
    let told = |graze: &&&Special| {
        let state = &graze.point.state;
        (state[0] - 0.118_317_370_152_857_4).abs() + (state[1] + 0.419_786_997_158_947_2).abs()
            < 1e-10
    };
    assert_eq!(grazes.iter().filter(told).count(), 1, "{grazes:?}");
    let masses = with(TWO_MASSES, &[]);
    let found = over(&masses, "omega", (1.15, 1.4), (60, 0.01));
    for (at, angle) in [
        (1.212_416_918_341_172_3, 1.577_026_315_952_048_7),
        (1.263_087_195_029_196_6, 1.559_281_862_975_612_8),
    ] {
        let special = nearest(&found, &[SpecialKind::NeimarkSacker], at);
        let pair = special.point.multipliers[0];
        assert!((pair.im.abs().atan2(pair.re) - angle).abs() < 1e-9);
    }
    let first = nearest(&found, &[SpecialKind::NeimarkSacker], 1.2124);
    let other = first.point.multipliers[2];
    assert!((other.re - 0.052_013_832_694_777_3).abs() < 1e-9);
    assert!((other.im.abs() - 0.648_140_444_053_367_7).abs() < 1e-9);
}

/// A limit cycle that loses its last impact goes on without.
#[test]
fn the_limit_cycle_of_the_valve_lifts_off() {
    let valve = model("pressure_relief_valve", &[("q", "7.56")]);
    let found = over(&valve, "q", (7.55, 7.57), (60, 0.1));
    let graze = nearest(&found, &GRAZES, 7.557);
    assert!((value(&graze) - 7.557_210_971_876_686).abs() < 1e-12);
    assert!((graze.point.period - 2.656_012_147_475_165).abs() < 1e-11);
    assert!((graze.point.multipliers[0].re - 0.853_395_334_460_181_7).abs() < 1e-9);
    assert_eq!(graze.persists, Some(true));
}
