//! Finding border orbits: forced systems and their phase, several borders, places that are none, many parameter sets.

use chatter::analysis::border::*;
use chatter::analysis::border_search::*;
use chatter::model::Model;
use std::ops::ControlFlow;

const VALVE: &str = include_str!("../../../../../models/pressure_relief_valve.toml");
const OSCILLATOR: &str = include_str!("../../../../../models/impact_oscillator.toml");
const CAM: &str = include_str!("../../../../../models/cam_follower.toml");
const TABLE: &str = include_str!("../../../../../models/bouncing_ball_on_table.toml");
const LINEAR: &str = include_str!("../../../../../models/linear_impacting_system.toml");

fn read(text: &str) -> Model {
    Model::from_toml(text, "test").unwrap_or_else(|errors| panic!("{errors:?}"))
}

fn with(text: &str, values: &[(&str, &str)]) -> Model {
    let mut model = read(text);
    for (name, value) in values {
        model.set_parameter(name, value).unwrap();
    }
    model
}

fn borders(model: &Model, parameter: &str, low: f64, high: f64) -> Borders<f64> {
    borders_in(model, &BorderSpec::new(parameter), low, high).unwrap()
}

fn close(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance * b.abs(), "{a} {b}");
}

/// K, M, N*: what no choice of coordinates changes.
fn invariants(border: &Border<f64>) -> [f64; 3] {
    let exact = &border.exact;
    [exact.slope, exact.unfolding_rate, exact.amplitude].map(|estimate| estimate.value)
}

/// A range of very many parts is searched stretch by stretch, and what was found stays when the search is broken off.
#[test]
fn a_search_in_stretches_finds_the_same_and_keeps_it_when_broken_off() {
    let model = read(OSCILLATOR);
    let whole = borders(&model, "sigma", -0.9, 0.95);
    assert!(whole.borders.len() > 1 && whole.is_complete);
    let spec = BorderSpec {
        samples: 3000,
        ..BorderSpec::new("sigma")
    };
    let mut parts = Vec::new();
    let fine = search_range::<f64>(&model, &spec, (-0.9, 0.95), &mut |reached| {
        parts.push(reached.done);
        ControlFlow::Continue(())
    });
    let fine = fine.unwrap();
    assert!(parts.is_sorted() && parts[0] < 1e-3 && parts[parts.len() - 1] > 0.9);
    assert!(parts.iter().all(|part| (0.0..=1.0).contains(part)) && parts.len() > 3000);
    assert_eq!(
        (fine.borders.len(), fine.is_complete),
        (whole.borders.len(), true)
    );
    for (a, b) in fine.borders.iter().zip(&whole.borders) {
        close(a.value.value, b.value.value, 1e-14);
    }
    let first = search_range::<f64>(&model, &spec, (-0.9, 0.95), &mut |reached| match reached
        .borders
    {
        0 => ControlFlow::Continue(()),
        _ => ControlFlow::Break(()),
    });
    let first = first.unwrap();
    assert_eq!(
        (first.borders.as_slice(), first.is_complete),
        (&fine.borders[..1], false)
    );
}

/// At sigma = -1 the release point is a double root; from there on the phase must not walk away.
#[test]
fn the_phase_stays_in_the_first_forcing_period() {
    let model = read(OSCILLATOR);
    let period = core::f64::consts::TAU / 0.3;
    let found = borders(&model, "sigma", -1.0, 1.0);
    assert_eq!(found.borders.len(), 3);
    assert!(found.breaks.iter().all(|at| at.value == -1.0) && found.unresolved == 0);
    for border in &found.borders {
        assert!((0.0..period).contains(&border.release.state[2]));
        close(border.period.value, period, 1e-14);
        let [turn] = border.turns[..] else {
            panic!("{:?}", border.turns)
        };
        close(turn.period, period, 1e-15);
        assert_eq!((turn.state, turn.count), (2, 1));
        let exact = &border.exact;
        for estimate in [exact.slope, exact.unfolding_rate, exact.amplitude] {
            assert!(estimate.error < 1e-14 * estimate.value.abs());
        }
    }
}

/// The same oscillator written by someone else: other names, another phase of the forcing, the phase as an angle.
#[test]
fn the_form_does_not_depend_on_how_the_forcing_is_written() {
    let ours = borders(&read(OSCILLATOR), "sigma", 0.0, 0.9);
    let theirs = |phase: &str, state: &str, initial: &str| {
        let text = format!(
            "[parameters]\nwall = 0.5\nphi = 0.7\nnu = 0.3\ne = 0.8\n\
             [flight]\nposition = \"speed\"\nspeed = \"cos({phase}) - position\"\n{state}\
             [[contact]]\nname = \"wall\"\ngap = \"wall - position\"\nimpulse = {{ speed = -2.5 }}\nrestitution = \"e\"\n\
             [initial]\nposition = 0.0\nspeed = 0.0\n{initial}"
        );
        borders(&read(&text), "wall", 0.0, 0.9)
    };
    for other in [
        theirs("nu*t + phi", "", ""),
        theirs("phi - nu*t", "", ""),
        theirs("angle", "angle = \"nu\"\n", "angle = 0.0\n"),
    ] {
        assert_eq!(other.borders.len(), ours.borders.len());
        for (a, b) in other.borders.iter().zip(&ours.borders) {
            close(a.value.value, b.value.value, 1e-14);
            for (a, b) in invariants(a).into_iter().zip(invariants(b)) {
                close(a, b, 1e-12);
            }
        }
    }
}

#[test]
fn without_a_forcing_period_there_is_no_border() {
    let text = OSCILLATOR.replace(
        "cos(omega*t) - 2*zeta*v - x",
        "cos(omega*t) + 0.1*cos(sqrt(2)*omega*t) - x",
    );
    let spec = BorderSpec::new("sigma");
    for text in [text, OSCILLATOR.replace("cos(omega*t)", "cos(omega*t^2)")] {
        let text = text.replace("surface = \"sin(omega*t)\"", "surface = \"v\"");
        let error = border_near::<f64>(&read(&text), &spec, 0.5).unwrap_err();
        let lacks =
            |what| matches!(&error, BorderError::Lacks { what: found, .. } if *found == what);
        assert!(lacks(Lack::Period), "{error}");
    }
}

/// Two borders within one part of a range, between ends of one verdict.
#[test]
fn a_near_miss_between_samples_is_looked_into() {
    let model = read(VALVE);
    for (low, high, samples) in [(10.0, 1210.0, 2), (10.0, 1210.0, 3), (5.0, 905.0, 2)] {
        let mut spec = BorderSpec::new("beta");
        spec.samples = samples;
        let verdicts = verdicts_in(&model, &spec, low, high).unwrap();
        let [verdicts] = &verdicts[..] else {
            panic!("one release point")
        };
        let same = |(_, verdict): &(f64, Verdict)| *verdict == verdicts[0].1;
        assert!(verdicts.iter().all(same), "{verdicts:?}");
        let found = borders_in::<f64>(&model, &spec, low, high).unwrap();
        let values: Vec<f64> = found.borders.iter().map(|b| b.value.value).collect();
        assert_eq!(values.len(), 2, "{samples}: {values:?}");
        close(values[0], 20.061_501_501_224_9, 1e-13);
        close(values[1], 349.966_597_588_152, 1e-13);
    }
}

/// A parameter that is negative at the border, or zero.
#[test]
fn values_near_zero_and_below_are_found() {
    let shifted = VALVE.replace(
        "\"beta*(q - y1*sqrt(y3))\"",
        "\"beta*(q + 0.02 - y1*sqrt(y3))\"",
    );
    let model = with(&shifted, &[("q", "0")]);
    let spec = BorderSpec::new("q");
    let ours = border_near::<f64>(&read(VALVE), &spec, 0.02).unwrap();
    for near in [5e-5, 0.0, 1e-4] {
        let border = border_near::<f64>(&model, &spec, near).unwrap();
        close(border.value.value, 5.600_568_931_228_4e-5, 1e-10);
        for (a, b) in invariants(&border).into_iter().zip(invariants(&ours)) {
            close(a, b, 1e-12);
        }
    }
    let mirrored = VALVE.replace("\"beta*(q - y1*sqrt(y3))\"", "\"beta*(-q - y1*sqrt(y3))\"");
    let model = with(&mirrored, &[("q", "-0.02")]);
    let border = border_near::<f64>(&model, &spec, -0.03).unwrap();
    close(border.value.value, -ours.value.value, 1e-14);
    close(border.exact.slope.value, ours.exact.slope.value, 1e-13);
    close(
        border.exact.unfolding_rate.value,
        -ours.exact.unfolding_rate.value,
        1e-13,
    );
    let error = border_near::<f64>(&model, &spec, -0.1).unwrap_err();
    match error {
        BorderError::NoBorder { low, high, .. } => assert_eq!((low, high), (-0.2, -0.05)),
        other => panic!("{other}"),
    }
    // Exactly zero, where no accuracy relative to the parameter can be had.
    let digits = format!("{:e}", ours.value.value);
    let exactly = VALVE.replace("\"beta*(q - y1", &format!("\"beta*(q + {digits} - y1"));
    let model = with(&exactly, &[("q", "0")]);
    let border = border_near::<f64>(&model, &spec, 0.0).unwrap();
    assert!(border.value.value.abs() < 1e-16, "{:?}", border.value);
    close(border.exact.slope.value, ours.exact.slope.value, 1e-12);
}

/// Over other parameter sets of the valve: a border is a border whichever parameter is varied, its form obeys
/// K = C A B, and X changes its sign there.
#[test]
fn many_valves() {
    let sets: [&[(&str, &str)]; 5] = [
        &[("kappa", "1.5"), ("r", "0.7")],
        &[("r", "0.5")],
        &[("beta", "10"), ("r", "0.6")],
        &[("delta", "6"), ("r", "0.7")],
        &[("delta", "15"), ("beta", "30")],
    ];
    let mut count = 0;
    for set in sets {
        let model = with(VALVE, set);
        let found = borders(&model, "q", 0.005, 1.5);
        assert_eq!(found.unresolved, 0);
        for border in &found.borders {
            count += 1;
            let q = border.value.value;
            let exact = &border.exact;
            let product: f64 = (border.section.iter().zip(&exact.covector))
                .map(|(&i, c)| c.value * exact.first_impact_by_upsilon[i].value)
                .sum();
            close(product, exact.slope.value, 1e-12);
            let step = 1e-6 * q;
            let verdict = |q: f64| {
                let mut spec = BorderSpec::new("q");
                spec.samples = 1;
                verdicts_in(&model, &spec, q, q + 1e-9).unwrap()[0][0].1
            };
            let (below, above) = (verdict(q - step), verdict(q + step));
            let expected = if exact.unfolding_rate.value > 0.0 {
                (Verdict::Complete, Verdict::Incomplete)
            } else {
                (Verdict::Incomplete, Verdict::Complete)
            };
            assert_eq!((below, above), expected, "{set:?} {q}");
            let mut model = model.clone();
            model.set_parameter("q", &format!("{q:e}")).unwrap();
            let kappa = model.parameter_values::<f64>(&[])[1];
            let other = border_near::<f64>(&model, &BorderSpec::new("kappa"), kappa).unwrap();
            close(other.value.value, kappa, 1e-11);
            close(other.exact.slope.value, exact.slope.value, 1e-9);
        }
    }
    assert!(count >= 3, "{count}");
}

/// Borders of the other shipped models, with the same form whichever of two parameters is varied.
#[test]
fn borders_of_other_models() {
    for (text, parameter, near, other) in [
        (LINEAR, "beta", 22.0, "zeta"),
        (CAM, "speed", 622.0, "r"),
        (CAM, "r", 0.538, "stiffness"),
        (TABLE, "Gamma", 1.597, "r"),
        (OSCILLATOR, "omega", 0.3446, "r"),
    ] {
        let mut model = read(text);
        let border = border_near::<f64>(&model, &BorderSpec::new(parameter), near).unwrap();
        close(border.value.value, near, 1e-2);
        model
            .set_parameter(parameter, &format!("{:e}", border.value.value))
            .unwrap();
        let index = model.parameter_index(other).unwrap();
        let value = model.parameter_values::<f64>(&[])[index];
        let again = border_near::<f64>(&model, &BorderSpec::new(other), value).unwrap();
        close(again.value.value, value, 1e-9);
        close(again.exact.slope.value, border.exact.slope.value, 1e-8);
        close(
            again.exact.amplitude.value,
            border.exact.amplitude.value,
            1e-8,
        );
    }
}

#[test]
fn changes_of_the_verdict_that_are_no_border_are_told_with_their_cause() {
    let table = borders(&read(TABLE), "Gamma", 4.9, 5.2);
    let grazes = (table.breaks.iter()).filter(|at| match at.cause {
        BreakCause::Graze { impact, rate } => impact > 0 && (-1e-4..=0.0).contains(&rate),
        _ => false,
    });
    assert!(grazes.count() >= 1, "{:?}", table.breaks);
    let cam = borders(&read(CAM), "r", 0.59, 0.61);
    let short = |at: &Break| matches!(at.cause, BreakCause::Short { impacts: 4 });
    assert!(cam.breaks.iter().any(short), "{:?}", cam.breaks);
}

/// Answers are values: the same each time, and the same after a journey as text.
#[test]
fn questions_and_answers_are_stored() {
    let model = read(OSCILLATOR);
    let mut spec = BorderSpec::new("sigma");
    spec.section = Some(ReleaseSection {
        state: "t".to_owned(),
        level: 4.9,
    });
    let text = serde_json::to_string(&spec).unwrap();
    assert_eq!(serde_json::from_str::<BorderSpec>(&text).unwrap(), spec);
    let border = border_near::<f64>(&model, &spec, 0.12).unwrap();
    assert_eq!(border_near::<f64>(&model, &spec, 0.12).unwrap(), border);
    let text = serde_json::to_string(&border).unwrap();
    assert_eq!(serde_json::from_str::<Border<f64>>(&text).unwrap(), border);
    let prediction = Prediction::exact(&border).unwrap();
    let simulator = Simulator::new(&model, &spec, &border).unwrap();
    let windows = simulator.compare(&prediction, 30, 31);
    assert_eq!(windows.len(), 2);
    let text = serde_json::to_string(&windows).unwrap();
    let read: Vec<WindowComparison> = serde_json::from_str(&text).unwrap();
    assert_eq!(read, windows);
}

/// Far from a border impacts may go on for ever without a long flight.
#[test]
fn orbits_without_long_flights_are_given_up() {
    let model = read(
        "[parameters]\npreload = 0.2\n\
         [flight]\nx = \"v\"\nv = \"-(x + preload) - 0.5*x^3 - 0.04*v + sin(phi)\"\nphi = \"0.5\"\n\
         [[contact]]\nname = \"stop\"\ngap = \"x\"\nimpulse = { v = 1 }\nrestitution = \"0.75\"\n\
         [initial]\nx = 0\nv = 0\nphi = 0\n",
    );
    let spec = BorderSpec::new("preload");
    let border = border_near::<f64>(&model, &spec, 0.29).unwrap();
    close(border.value.value, 0.291_394_858_6, 1e-9);
    let simulator = Simulator::new(&model, &spec, &border).unwrap();
    let far = simulator.orbit(-0.41, 150, 100).unwrap();
    assert_eq!(far.verdict, Verdict::NoChatter);
    // The first flight is local there by the acceleration at the first impact, but it is a long one.
    let prediction = Prediction::exact(&border).unwrap();
    assert_eq!(simulator.compare(&prediction, 8, 22).len(), 15);
}

/// Where the impact nearest to u* is not near, what it says of X is vague: the border was taken for a jump, and beside it another one
/// was told. The value is that of bisection in quadruple precision.
#[test]
fn a_border_that_few_impacts_come_near_is_found() {
    let text = "[parameters]\nA = 1.4\n[flight]\nx = 'v'\n\
        v = '-1 - 0.249*x - 0.062*v + A*cos(0.988*t) + 0.521*sin(2*0.988*t)'\n[[contact]]\nname = 'anvil'\ngap = 'x'\n\
        impulse = { v = 1 }\nrestitution = 0.607\n[initial]\nx = 0.1\nv = 0\n";
    let model = Model::from_toml(text, "drill").unwrap_or_else(|errors| panic!("{errors:?}"));
    let spec = BorderSpec::new("A");
    let found = borders_in::<f64>(&model, &spec, 1.4, 1.5).unwrap();
    let near = border_near::<f64>(&model, &spec, 1.4406).unwrap();
    assert_eq!(found.borders.len(), 1);
    for border in [&found.borders[0], &near] {
        let off = border.value.value - 1.440_637_606_940_648;
        assert!(off.abs() < 1e-14, "{off:e}");
    }
}

/// With little restitution four impacts shrink a sequence as far as limits need, and as few are no sequence: one more is followed. Values are those of bisection
/// with 36 digits.
#[test]
fn borders_of_little_restitution_are_found() {
    let text = "[parameters]\nG = 2.5\nr = 0.07\n[flight]\ny = \"v\"\nv = \"-1\"\n[[contact]]\nname = \"table\"\ngap = \"y - G*sin(t)\"\n\
        impulse = { v = 1 }\nrestitution = \"r\"\n[section.s]\nsurface = \"sin(t)\"\ndirection = \"rising\"\n[initial]\ny = 6\nv = 0\n";
    let known = [
        ("0.0744", 2.619_110_387_888_6),
        ("0.07", 2.639_930_194_589_9),
        ("0.06", 2.689_873_714_855_2),
    ];
    for (restitution, expected) in known {
        let model = with(text, &[("r", restitution)]);
        let found = borders(&model, "G", expected - 0.01, expected + 0.005);
        let values = found.borders.iter().map(|border| border.value.value);
        let off = |value: f64| (value - expected).abs();
        let nearest = values.min_by(|a, b| off(*a).total_cmp(&off(*b)));
        assert!(
            nearest.is_some_and(|value| off(value) < 1e-12),
            "{restitution} {nearest:?}"
        );
    }
}
