//! Border orbits: the paper's table, the exact normal form, other systems, and questions without an answer.

use super::{Settled, approach_the_prediction, predicted, simulated};
use chatter::analysis::border::*;
use chatter::analysis::border_search::*;
use chatter::model::Model;
use chatter::numerics::{DoubleDouble, Real, Scalar};

const VALVE: &str = include_str!("../../../../../models/pressure_relief_valve.toml");
const LINEAR: &str = include_str!("../../../../../models/linear_impacting_system.toml");
const CAM: &str = include_str!("../../../../../models/cam_follower.toml");
const OSCILLATOR: &str = include_str!("../../../../../models/impact_oscillator.toml");
const BALL: &str = include_str!("../../../../../models/bouncing_ball.toml");

/// The states that tell orbits: time is none.
const VALVE_STATES: &[usize] = &[0, 1, 2];
const OSCILLATOR_STATES: &[usize] = &[0, 1];

fn read(text: &str) -> Model {
    Model::from_toml(text, "test").unwrap_or_else(|errors| panic!("{errors:?}"))
}

fn valve_border<R: Real>() -> Border<R> {
    border_near(&read(VALVE), &BorderSpec::new("q"), 0.02).unwrap()
}

/// The paper's numbers with the unit of their last digit, and ours.
fn printed(form: &LeadingOrder<f64>) -> [(&'static str, f64, f64, f64); 17] {
    [
        ("y1", 0.001080, 1e-6, form.crossing[0]),
        ("y2", 0.011966, 1e-6, form.crossing[1]),
        ("B1", 0.186318, 1e-6, form.b[0]),
        ("B2", 0.747358, 1e-6, form.b[1]),
        ("C1", 1.33805, 1e-5, form.c[0]),
        ("C2", 0.577996, 1e-6, form.c[1]),
        ("D", 7.88954, 1e-5, form.d),
        ("E1", -0.103297, 1e-6, form.e[0]),
        ("E2", -0.621515, 1e-6, form.e[1]),
        ("A11", -11.2769, 1e-4, form.a[0][0]),
        ("A12", -0.667163, 1e-6, form.a[0][1]),
        ("A21", 60.6417, 1e-4, form.a[1][0]),
        ("A22", 3.55289, 1e-5, form.a[1][1]),
        ("F1", 3.96147, 1e-5, form.f[0]),
        ("F2", -16.6998, 1e-4, form.f[1]),
        ("CAB", 4.58679, 1e-5, form.slope),
        ("CAE + CF + D", 0.754296, 1e-6, form.unfolding_rate),
    ]
}

/// Which of our numbers do not round to the paper's, and by how many units of the last digit they miss it.
fn deviations(form: &LeadingOrder<f64>) -> Vec<(&'static str, i32)> {
    printed(form)
        .into_iter()
        .map(|(name, paper, unit, ours)| (name, ((ours - paper) / unit).round() as i32))
        .filter(|&(_, units)| units != 0)
        .collect()
}

#[test]
fn eq28_and_eq29_at_the_border() {
    let border = valve_border::<f64>();
    assert!((border.value.value - 0.020056).abs() < 0.5e-6);
    assert!((border.first_impact.state[1] - 0.118256).abs() < 0.5e-6);
    assert!((border.first_impact.state[2] - 9.45248).abs() < 0.5e-5);
    // E is met at the paper's own q* (next test). A and F come out of its integrator with some six digits: A12, A22 and
    // F limit CAB and CAE + CF + D, the latter a sum of terms a hundred times its size.
    let expected = [
        ("E1", 1),
        ("E2", 1),
        ("A12", -2),
        ("A22", 1),
        ("CAB", 1),
        ("CAE + CF + D", -16),
    ];
    assert_eq!(deviations(&border.leading_order.unwrap()), expected);
}

/// The digits of D, E1 and E2 together put the q* that the paper computed with, printed as 0.020056, between
/// 0.02005600115 and 0.02005600234.
#[test]
fn eq28_and_eq29_at_the_printed_parameter() {
    let model = read(VALVE);
    let at = |q: f64| {
        let form = leading_order_at(&model, &BorderSpec::new("q"), q).unwrap();
        deviations(&form)
    };
    let flight = [("A12", -2), ("A22", 1), ("CAB", 1), ("CAE + CF + D", -15)];
    assert_eq!(at(0.0200560017), flight);
    let with_d = [
        ("D", 1),
        ("A12", -1),
        ("A22", 1),
        ("CAB", 1),
        ("CAE + CF + D", -15),
    ];
    assert_eq!(at(0.020056), with_d);
}

/// q* of valves with beta = 20, delta = 10 and these kappa and r, and its derivatives by kappa, delta, beta and r: from an
/// integration in quadruple precision of its own, impact by impact, with sensitivities that were checked against differences.
type Reference = (
    &'static str,
    &'static str,
    &'static str,
    [(&'static str, f64); 4],
);

const REFERENCE: [Reference; 4] = [
    (
        "1.25",
        "0.8",
        "0.0200560056893122842825170310696",
        [
            ("kappa", -0.11206425667511687),
            ("delta", 0.006995811420158389),
            ("beta", 0.003987410566761546),
            ("r", -1.48250117565152),
        ],
    ),
    (
        "1.26",
        "0.8",
        "0.0189353825782125338490055767608",
        [
            ("kappa", -0.11205966205668626),
            ("delta", 0.00689344599670945),
            ("beta", 0.004053138609977571),
            ("r", -1.4871819042030632),
        ],
    ),
    (
        "1.3",
        "0.8",
        "0.0144539780365359802254187056915",
        [
            ("kappa", -0.11199949696752758),
            ("delta", 0.006482807540862663),
            ("beta", 0.004314710835382266),
            ("r", -1.50574715563023),
        ],
    ),
    (
        "1.25",
        "0.75",
        "0.0916237457842126622572297530195",
        [
            ("kappa", -0.09070081829411436),
            ("delta", 0.014810744710524171),
            ("beta", 0.0010671828428922719),
            ("r", -1.389528114989936),
        ],
    ),
];

/// Along the border M_q dq + M_p dp = 0: unfolding rates by two parameters give the derivative of q*.
#[test]
fn borders_are_those_of_an_integration_of_its_own() {
    for (kappa, r, value, slopes) in REFERENCE {
        let mut model = read(VALVE);
        model.set_parameter("kappa", kappa).unwrap();
        model.set_parameter("r", r).unwrap();
        let q: DoubleDouble = value.parse().unwrap();
        let near = q.to_f64() * 1.001;
        let border = border_near::<DoubleDouble>(&model, &BorderSpec::new("q"), near).unwrap();
        let off = (border.value.value - q).abs().to_f64();
        assert!(off < 1e-24, "q*: {off:e}");
        assert!(border.value.error < 1e-24);
        let by_q = border.exact.unfolding_rate.value.to_f64();
        model.set_parameter("q", value).unwrap();
        for (name, slope) in slopes {
            let at = match name {
                "kappa" => kappa.parse().unwrap(),
                "r" => r.parse().unwrap(),
                "delta" => 10.0,
                _ => 20.0,
            };
            let other = border_near::<f64>(&model, &BorderSpec::new(name), at).unwrap();
            let found = -other.exact.unfolding_rate.value / by_q;
            assert!(
                (found / slope - 1.0).abs() < 1e-13,
                "dq*/d{name}: {found} {slope}"
            );
        }
    }
}

/// K, M and N* are properties of the orbit: neither what u is read off from, nor how many impacts are integrated, nor how
/// many ratios are eliminated shows in them.
#[test]
fn exact_form_depends_on_no_choice() {
    fn forms(impacts: [usize; 3], orders: [usize; 2], tolerance: f64) {
        let model = read(VALVE);
        let mut forms = Vec::new();
        for coordinate in [LocalCoordinate::AtImpact, LocalCoordinate::AtRest] {
            for impacts in impacts {
                for orders in orders {
                    let mut spec = BorderSpec::new("q");
                    spec.coordinate = coordinate;
                    spec.extrapolation = Extrapolation {
                        impacts: Some(impacts),
                        orders: Some(orders),
                    };
                    let border = border_near::<DoubleDouble>(&model, &spec, 0.02).unwrap();
                    forms.push((border.exact, border.value));
                }
            }
        }
        let (first, value) = forms[0].clone();
        for (form, other) in &forms[1..] {
            let off = |a: DoubleDouble, b: DoubleDouble| ((a - b) / b).to_f64().abs();
            assert!(off(form.slope.value, first.slope.value) < tolerance);
            assert!(off(form.unfolding_rate.value, first.unfolding_rate.value) < tolerance);
            assert!(off(form.amplitude.value, first.amplitude.value) < tolerance);
            assert!(off(other.value, value.value) < tolerance);
        }
    }
    forms([43, 46, 50], [9, 12], 1e-9);
    forms([76, 84, 90], [18, 22], 1e-18);
}

#[test]
fn coefficients_make_up_slope_and_rate() {
    let border = valve_border::<DoubleDouble>();
    let exact = &border.exact;
    let product = |by: &[Estimate<DoubleDouble>]| {
        border
            .section
            .iter()
            .zip(&exact.covector)
            .fold(DoubleDouble::from(0.0), |sum, (&i, c)| {
                sum + c.value * by[i].value
            })
    };
    let close = |a: DoubleDouble, b: DoubleDouble| {
        assert!(((a - b) / b).to_f64().abs() < 1e-18, "{a} {b}");
    };
    close(product(&exact.first_impact_by_upsilon), exact.slope.value);
    let moved = product(&exact.first_impact_by_parameter) + exact.covector_parameter.value;
    close(moved, exact.unfolding_rate.value);
    // A B.
    for (row, &moved) in exact
        .flight
        .iter()
        .zip(&exact.first_impact_by_upsilon)
        .skip(1)
    {
        let sum = row
            .iter()
            .zip(&exact.offset)
            .fold(DoubleDouble::from(0.0), |sum, (a, b)| {
                sum + a.value * b.value
            });
        close(sum, moved.value);
    }
}

#[test]
fn other_valves_have_their_borders() {
    for (name, text, near, value) in [
        ("kappa", "1.0", 0.048, 0.047_964_883_927),
        ("r", "0.75", 0.0916, 0.091_623_745_784),
    ] {
        let mut model = read(VALVE);
        model.set_parameter(name, text).unwrap();
        let spec = BorderSpec::new("q");
        let border = border_near::<f64>(&model, &spec, near).unwrap();
        assert!((border.value.value - value).abs() < 1e-12);
        assert!(border.value.error < 1e-13);
        let all = borders_in::<f64>(&model, &spec, 0.01, 0.2).unwrap();
        assert_eq!(all.borders.len(), 1);
        assert!((all.borders[0].value.value - value).abs() < 1e-12);
        assert!(all.breaks.is_empty());
    }
}

/// The same orbit whichever parameter is varied: p* of one is the given value of the other.
#[test]
fn every_parameter_leads_to_the_same_orbit() {
    let mut model = read(VALVE);
    model.set_parameter("q", "0.02005600568931228428").unwrap();
    let here = valve_border::<f64>();
    for (parameter, value) in [("kappa", 1.25), ("r", 0.8), ("delta", 10.0), ("beta", 20.0)] {
        let border = border_near::<f64>(&model, &BorderSpec::new(parameter), value).unwrap();
        let off = (border.value.value - value).abs() / value;
        assert!(off < 1e-12, "{parameter}: {off}");
        let slope = border.exact.slope.value / here.exact.slope.value - 1.0;
        assert!(slope.abs() < 1e-9, "{parameter}: {slope}");
    }
}

#[test]
fn the_forced_oscillator_has_borders() {
    let model = read(OSCILLATOR);
    let found = borders_in::<f64>(&model, &BorderSpec::new("sigma"), -0.9, 0.95).unwrap();
    let values: Vec<f64> = found.borders.iter().map(|b| b.value.value).collect();
    let expected = [
        0.123_448_597_848_029,
        0.777_348_206_276_957,
        0.792_035_464_209_81,
    ];
    assert_eq!(values.len(), expected.len(), "{values:?}");
    for (border, expected) in found.borders.iter().zip(expected) {
        assert!((border.value.value - expected).abs() < 1e-12);
        let sigma = border.value.value;
        let [x, v, t] = border.release.state[..] else {
            panic!("three states")
        };
        assert!((x - sigma).abs() < 1e-14 && v.abs() < 1e-14);
        assert!(((0.3 * t).cos() - sigma).abs() < 1e-13);
    }
}

#[test]
fn questions_without_an_answer_get_a_typed_one() {
    let valve = read(VALVE);
    let near = |model: &Model, parameter: &str, value: f64| {
        border_near::<f64>(model, &BorderSpec::new(parameter), value).unwrap_err()
    };
    match near(&valve, "kapa", 1.0) {
        BorderError::Unknown {
            kind: Named::Parameter,
            name,
            nearest,
        } => {
            assert_eq!((&*name, nearest.as_deref()), ("kapa", Some("kappa")));
        }
        other => panic!("{other}"),
    }
    assert!(matches!(
        near(&read(BALL), "r", 0.5),
        BorderError::States { count: 2 }
    ));
    let mut plastic = valve.clone();
    plastic.set_parameter("r", "0").unwrap();
    assert!(matches!(
        near(&plastic, "q", 0.02),
        BorderError::Lacks {
            what: Lack::Restitution(0.0),
            ..
        }
    ));
    assert!(matches!(
        near(&valve, "q", 0.2),
        BorderError::NoBorder { .. }
    ));
    let spec = BorderSpec::new("q");
    let none = borders_in::<f64>(&valve, &spec, 0.021, 0.03).unwrap();
    assert!(none.borders.is_empty() && none.breaks.is_empty());
    for (low, high) in [
        (0.03, 0.02),
        (0.02, 0.02),
        (f64::NAN, 1.0),
        (0.0, f64::INFINITY),
    ] {
        assert!(matches!(
            borders_in::<f64>(&valve, &spec, low, high),
            Err(BorderError::Range { .. })
        ));
    }
    let mut far = spec.clone();
    far.section = Some(ReleaseSection {
        state: "y3".to_owned(),
        level: 11.0,
    });
    let border = border_near::<f64>(&valve, &far, 0.02).unwrap();
    assert!(matches!(border.leading_order, Err(ReleaseSection { .. })));
}

fn mean(impacts: &[u64]) -> f64 {
    impacts.iter().sum::<u64>() as f64 / impacts.len() as f64
}

fn counts(border: &Border<f64>, prediction: &Prediction, at: f64) -> Vec<u64> {
    let passages = prediction.orbit(at, 600, 2000);
    assert_eq!(border.value.value, prediction.border);
    passages
        .iter()
        .filter_map(|passage| passage.impacts)
        .collect()
}

/// The valve's passages have the predicted numbers of impacts with the exact coefficients, where the orbit is periodic and
/// where it is chaotic. With the leading-order ones they have not: as the paper has them, q = 0.021 would be below the
/// border.
#[test]
fn exact_prediction_has_the_impacts_of_the_simulation() {
    let model = read(VALVE);
    let spec = BorderSpec::new("q");
    let border = valve_border::<f64>();
    let exact = Prediction::exact(&border).unwrap();
    let leading = Prediction::leading_order(&border).unwrap();
    let simulator = Simulator::new(&model, &spec, &border).unwrap();
    for (q, impacts) in [(0.02006, 53), (0.0201, 42), (0.0203, 34)] {
        let period = Settled::Periodic {
            passages: 1,
            impacts,
        };
        assert_eq!(
            simulated((&simulator, VALVE_STATES), q, 300, 200),
            period,
            "{q}"
        );
        assert_eq!(predicted(&exact, q), period, "{q}");
        assert_ne!(predicted(&leading, q), period, "{q}");
        let predicted = exact.state(q, &exact.orbit(q, 1000, 1)[0]);
        let there = &simulator.orbit(q, 300, 200).unwrap().passages[0].state;
        let moved = |state: &[f64]| state[1] - border.first_impact.state[1];
        let off = (moved(&predicted) - moved(there)).abs();
        // (26), (27): to first order in the distance from the border.
        assert!(
            off < 0.01 * moved(there).abs(),
            "{q}: {predicted:?} {there:?}"
        );
    }
    // One chaotic band: 36 more impacts after the first in each passage, as the paper counts.
    let band = counts(&border, &exact, 0.02019);
    assert!(!band.is_empty() && band.iter().all(|&impacts| impacts == 37));
    for (q, tolerance) in [(0.02019, 0.0), (0.0205, 0.15), (0.021, 0.3)] {
        let valve = (&simulator, VALVE_STATES);
        assert_eq!(simulated(valve, q, 300, 2000), Settled::Unsettled);
        let passages = simulator.orbit(q, 300, 2000).unwrap().passages;
        let there: Vec<u64> = passages.iter().map(|passage| passage.impacts).collect();
        let here = counts(&border, &exact, q);
        let off = (mean(&here) - mean(&there)).abs();
        assert!(off <= tolerance, "{q}: {off}");
        let leading = counts(&border, &leading, q);
        let off = (mean(&leading) - mean(&there)).abs();
        assert!(leading.is_empty() || off > 2.0, "{q}: {off:?}");
    }
    assert_eq!(
        simulated((&simulator, VALVE_STATES), 0.02, 10, 10),
        Settled::Complete
    );
    assert_eq!(predicted(&exact, 0.02), Settled::Complete);
}

/// The cascade of the forced oscillator over the stop's place: numbers of impacts and periods as predicted.
#[test]
fn the_forced_oscillator_follows_its_cascade() {
    let model = read(OSCILLATOR);
    let spec = BorderSpec::new("sigma");
    let border = border_near::<f64>(&model, &spec, 0.1234).unwrap();
    let prediction = Prediction::exact(&border).unwrap();
    let simulator = Simulator::new(&model, &spec, &border).unwrap();
    for (mu, passages, impacts) in [
        (1e-6, 1, 50),
        (1e-5, 1, 40),
        (3e-5, 1, 35),
        (1e-4, 1, 30),
        (3e-4, 2, 50),
    ] {
        let sigma = prediction.parameter(mu);
        let period = Settled::Periodic { passages, impacts };
        assert_eq!(predicted(&prediction, sigma), period, "{mu}");
        let found = simulated((&simulator, OSCILLATOR_STATES), sigma, 300, 200);
        assert_eq!(found, period, "{mu}");
    }
    let below = prediction.parameter(-1e-4);
    assert_eq!(
        simulated((&simulator, OSCILLATOR_STATES), below, 10, 10),
        Settled::Complete
    );
}

/// The windows of the valve's n-impact orbits lie where they are predicted, the better the more impacts; and what Newton's
/// method calls a period doubling is one in simulation.
#[test]
fn windows_of_the_valve_approach_the_prediction() {
    let model = read(VALVE);
    let spec = BorderSpec::new("q");
    let border = valve_border::<f64>();
    let prediction = Prediction::exact(&border).unwrap();
    let simulator = Simulator::new(&model, &spec, &border).unwrap();
    let windows = simulator.compare(&prediction, 11, 45);
    assert_eq!(windows.len(), 35);
    let mut before = Discrepancy {
        fold: Some(0.12),
        period_doubling: Some(0.12),
        grazing: Some(0.12),
    };
    for window in &windows {
        let now = window.discrepancy(border.value.value);
        for (now, before) in [
            (now.fold, before.fold),
            (now.period_doubling, before.period_doubling),
            (now.grazing, before.grazing),
        ] {
            assert!(
                now.unwrap().abs() < 0.95 * before.unwrap().abs(),
                "{window:?}"
            );
        }
        before = now;
    }
    assert!(before.fold.unwrap().abs() < 4e-4);
    let window = windows.iter().find(|w| w.predicted.lap == 31).unwrap();
    let doubling = window.located.period_doubling.unwrap().value;
    for (q, passages, impacts) in [(doubling - 2e-8, 1, 32), (doubling + 2e-8, 2, 64)] {
        let found = simulated((&simulator, VALVE_STATES), q, 6000, 200);
        assert_eq!(found, Settled::Periodic { passages, impacts });
    }
}

/// A forced system returns shifted by forcing periods, whichever parameter is varied, and negative K turns windows round.
#[test]
fn windows_of_the_forced_oscillator_approach_the_prediction() {
    let model = read(OSCILLATOR);
    for (parameter, near) in [("sigma", 0.1234), ("omega", 5.014)] {
        let spec = BorderSpec::new(parameter);
        let border = border_near::<f64>(&model, &spec, near).unwrap();
        let prediction = Prediction::exact(&border).unwrap();
        assert!(prediction.slope < 0.0);
        let simulator = Simulator::new(&model, &spec, &border).unwrap();
        let windows = simulator.compare(&prediction, 7, 41);
        assert_eq!(windows.len(), 35, "{parameter}");
        let mut before = f64::INFINITY;
        for window in windows {
            let now = window.discrepancy(border.value.value);
            let (fold, graze) = (now.fold.unwrap().abs(), now.grazing.unwrap().abs());
            assert!(fold.max(graze) < 0.95 * before, "{window:?}");
            before = fold.max(graze);
        }
        assert!(before < 1e-3);
    }
}

/// Two long flights before chatter, and slopes so large that predicted windows cross the border over n: 8.7 for the
/// oscillator, 16.4 for the cam.
#[test]
fn windows_after_two_long_flights_approach_the_prediction() {
    for (text, parameter, near, first, last) in [
        (OSCILLATOR, "sigma", 0.777, 36, 60),
        (CAM, "speed", 902.0, 5, 9),
    ] {
        let model = read(text);
        let spec = BorderSpec::new(parameter);
        let border = border_near::<f64>(&model, &spec, near).unwrap();
        assert_eq!(border.long_flights, 2);
        let prediction = Prediction::exact(&border).unwrap();
        let simulator = Simulator::new(&model, &spec, &border).unwrap();
        let windows = simulator.compare(&prediction, first, last);
        assert_eq!(windows.len(), (last - first + 1) as usize);
        approach_the_prediction(&windows, border.value.value);
    }
}

/// Which windows are asked for does not matter, and errors say how well they are known. K of the linear system is so large
/// that its prediction is far off for n below 30.
#[test]
#[ignore = "takes ten seconds"]
fn windows_do_not_depend_on_where_they_are_looked_for_from() {
    for (text, parameter, near, first, last, beyond) in [
        (VALVE, "q", 0.02, 9, 25, 34),
        (OSCILLATOR, "sigma", 0.1234, 4, 12, 26),
        (LINEAR, "r", 0.848, 6, 16, 30),
        (CAM, "speed", 622.0, 4, 9, 12),
    ] {
        let model = read(text);
        let spec = BorderSpec::new(parameter);
        let border = border_near::<f64>(&model, &spec, near).unwrap();
        let prediction = Prediction::exact(&border).unwrap();
        let simulator = Simulator::new(&model, &spec, &border).unwrap();
        let some = simulator.compare(&prediction, first, last);
        let more = simulator.compare(&prediction, first, beyond);
        assert_eq!(some.len(), (last - first + 1) as usize, "{parameter}");
        for (a, b) in some.iter().zip(&more) {
            assert_eq!(a.predicted, b.predicted);
            let pairs = [
                (a.located.fold, b.located.fold),
                (a.located.period_doubling, b.located.period_doubling),
                (a.located.grazing, b.located.grazing),
            ];
            for (a, b) in pairs {
                assert_eq!(a.is_some(), b.is_some(), "{parameter} {some:?}");
                if let (Some(a), Some(b)) = (a, b) {
                    let off = (a.value - b.value).abs();
                    assert!(off <= 2.0 * (a.error + b.error), "{parameter} {a:?} {b:?}");
                }
            }
        }
    }
}

/// On the paper's section y3 = 9.7 the predicted states are those of the flow, to first order.
#[test]
fn predicted_states_lie_on_sections_where_the_flow_crosses_them() {
    use chatter::flow::{Occurrence, Settings, System, Trajectory};
    let model = read(VALVE);
    let spec = BorderSpec::new("q");
    let border = valve_border::<f64>();
    let prediction = Prediction::exact(&border).unwrap();
    let states = section_states(&model, &spec, &border, "closing").unwrap();
    assert!((states.origin[2] - 9.7).abs() < 1e-14);
    assert!(states.by_upsilon[2].abs() < 1e-12 && states.by_parameter[2].abs() < 1e-12);
    let system = System::new(&model).unwrap();
    for (q, tolerance) in [(0.02006, 2e-4), (0.0203, 2e-2)] {
        let parameters = model.parameter_values(&[(0, q)]);
        let mut work = system.workspace::<f64>(&Settings::default());
        let start = [0.0, 0.0, 10.0];
        let mut trajectory =
            Trajectory::start(&system, &mut work, &parameters, 0.0, &start).unwrap();
        let mut crossings = 0;
        while crossings < 2000 {
            let next = trajectory.advance(&system, &mut work, 1e9).unwrap();
            crossings += i32::from(matches!(next, Some(Occurrence::Section { .. })));
        }
        let predicted = states.at(prediction.orbit(q, 2000, 1)[0].z, q - prediction.border);
        let there = trajectory.state().iter().zip(&states.origin);
        for (predicted, (state, origin)) in predicted.iter().zip(there).take(2) {
            let moved = state - origin;
            let off = (predicted - state).abs();
            assert!(off < tolerance * moved.abs(), "{q}: {off} of {moved}");
        }
    }
    assert!(matches!(
        section_states(&model, &spec, &border, "closed"),
        Err(BorderError::Unknown {
            kind: Named::Section,
            ..
        })
    ));
}
