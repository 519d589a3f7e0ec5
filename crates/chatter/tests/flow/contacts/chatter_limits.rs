//! Where chatter sequences end, against closed forms and recurrences in double-double, and that the error told of each
//! time is true.

use chatter::analysis::simulate::{Spec, simulate};
use chatter::flow::{Column, Occurrence, Settings, System, Trajectory};
use chatter::model::{Model, ModelBuilder};
use chatter::numerics::{DoubleDouble, Real, Scalar};
use proptest::prelude::*;
use std::ops::ControlFlow;

type Dd = DoubleDouble;

fn with_parameters(parameters: &[(&str, f64)]) -> ModelBuilder {
    let parameters = parameters.iter();
    parameters.fold(ModelBuilder::new(), |builder, &(name, value)| {
        builder.parameter(name, value)
    })
}

/// A ball that falls onto a surface, with restitution and further forces as given.
fn ball(
    parameters: &[(&str, f64)],
    gap: &str,
    force: &str,
    restitution: &str,
    start: (f64, f64),
) -> Model {
    with_parameters(parameters)
        .state("y", "v", start.0)
        .state("v", force, start.1)
        .state("x", "5/16", 0.0)
        .contact("floor", gap, [("v", 1.0)], restitution)
        .build()
        .expect("a valid model")
}

/// A drill of mass one that is pushed against a slider: their forces and the restitution.
fn drill(parameters: &[(&str, f64)], [push, slip, restitution]: [&str; 3]) -> Model {
    with_parameters(parameters)
        .state("x", "v", 0.0)
        .state("v", push, 0.0)
        .state("y", "u", 0.1)
        .state("u", slip, 0.0)
        .contact("bit", "y - x", [("v", "-1"), ("u", "1/m")], restitution)
        .build()
        .expect("a valid model")
}

/// Time of the last accumulation before `until`, the error told with it, and the state at `until`. Parameters and initial
/// state are the model's to double precision, whatever the number type, but for the parameter that is shifted.
fn accumulation<R: Real>(
    model: &Model,
    columns: &[Column],
    shift: &[(usize, R)],
    until: f64,
) -> (Option<(R, f64)>, Vec<R>) {
    let system = System::with_columns(model, columns).expect("a valid system");
    let mut work = system.workspace::<R>(&Settings::default());
    let of = |value: &f64| R::splat(*value);
    let values = model.parameter_values::<f64>(&[]);
    let mut parameters: Vec<R> = values.iter().map(of).collect();
    for &(place, value) in shift {
        parameters[place] = value;
    }
    let mut state: Vec<R> = model.initial_state(&values).iter().map(of).collect();
    let coordinates = state.len();
    state.resize(coordinates * (1 + columns.len()), R::ZERO);
    let mut trajectory =
        Trajectory::start(&system, &mut work, &parameters, R::ZERO, &state).expect("a legal start");
    let mut found = None;
    loop {
        match trajectory.advance(&system, &mut work, R::splat(until)) {
            Ok(Some(Occurrence::Accumulation { error, .. })) => {
                found = Some((trajectory.time(), error));
            }
            Ok(Some(Occurrence::Horizon)) => return (found, trajectory.state().to_vec()),
            Ok(_) => {}
            Err(error) => panic!("{error}"),
        }
    }
}

/// That columns of derivatives by every parameter, in doubles, are differences in double-double to this part, where a sequence ends.
fn columns_agree(
    model: &Model,
    parameters: &[(&str, f64)],
    part: f64,
) -> Result<(), TestCaseError> {
    const UNTIL: f64 = 8.0;
    const STEP: f64 = 1e-9;
    let columns: Vec<Column> = (0..parameters.len()).map(Column::Parameter).collect();
    let (found, with) = accumulation::<f64>(model, &columns, &[], UNTIL);
    if found.is_none() {
        return Ok(());
    }
    let count = with.len() / (1 + columns.len());
    for (p, &(name, value)) in parameters.iter().enumerate() {
        let shifted = |sign: f64| {
            let value = Dd::from(value) + Dd::from(sign * STEP);
            accumulation::<Dd>(model, &[], &[(p, value)], UNTIL).1
        };
        let (plus, minus) = (shifted(1.0), shifted(-1.0));
        for i in 0..count {
            let difference = ((plus[i] - minus[i]) / Dd::from(2.0 * STEP)).to_f64();
            let derivative = with[(p + 1) * count + i];
            prop_assert!(
                (derivative - difference).abs() <= part * difference.abs().max(1.0),
                "d state {} / d {}: {:e}, not {:e}",
                i,
                name,
                derivative,
                difference
            );
        }
    }
    Ok(())
}

/// The end of a ball's sequence on a floor at rest with unit gravity, from rest at a height; the restitution is a function
/// of time, horizontal place and incoming rate.
fn recurrence(height: f64, restitution: impl Fn(Dd, Dd) -> Dd) -> Dd {
    let two = Dd::from(2.0);
    let mut rate = (two * Dd::from(height)).sqrt();
    let mut time = rate;
    while rate.to_f64() > 1e-40 && time.to_f64() < 1e3 {
        rate = restitution(time, rate) * rate;
        time += two * rate;
    }
    time
}

/// That a time and its error, in doubles, agree with what is true, and are nearly as good as doubles can be.
fn assert_told((time, error): (f64, f64), truth: Dd, context: &str) {
    let off = (Dd::from(time) - truth).abs().to_f64();
    assert!(
        off <= 10.0 * error,
        "{context}: off by {off:e}, told {error:e}"
    );
    let most = 1e-13 * truth.to_f64().abs().max(1.0);
    assert!(
        off <= most && error <= 100.0 * most,
        "{context}: off by {off:e}, told {error:e}"
    );
}

#[test]
fn a_restitution_that_grows_with_time_ends_where_its_recurrence_does() {
    let model = ball(&[("r", 0.7), ("d", 0.02)], "y", "-1", "r + d*t", (0.1, 0.0));
    let truth = recurrence(0.1, |t, _| Dd::from(0.7) + Dd::from(0.02) * t);
    assert!((truth.to_f64() - 2.854_493_895_543_174).abs() < 1e-14);
    let (found, _) = accumulation::<f64>(&model, &[], &[], 4.0);
    assert_told(found.expect("an accumulation"), truth, "doubles");
    let (found, _) = accumulation::<Dd>(&model, &[], &[], 4.0);
    let (time, error) = found.expect("an accumulation");
    let off = (time - truth).abs().to_f64();
    assert!(
        off < 1e-29 && off < 10.0 * error,
        "off by {off:e} to thirty digits, told {error:e}"
    );
}

/// A ball whose restitution depends on time, place and incoming rate.
fn check_recurrence(height: f64, r: f64, drift: f64, wave: f64, loss: f64) {
    let parameters = [("r", r), ("d", drift), ("w", wave), ("c", loss)];
    // Incoming rates are negative.
    let model = ball(
        &parameters,
        "y",
        "-1",
        "(r + d*t + w*sin(x))*exp(c*v)",
        (height, 0.0),
    );
    let [r, d, w, c] = [r, drift, wave, loss].map(Dd::from);
    let truth = recurrence(height, |t, rate| {
        let sine = (Dd::from(0.3125) * t).sin_cos().0;
        (r + d * t + w * sine) * (-c * rate).exp()
    });
    // A restitution that reaches one on the way ends nothing.
    if truth.to_f64() < 20.0 {
        let (found, _) = accumulation::<f64>(&model, &[], &[], truth.to_f64() + 1.0);
        assert_told(found.expect("an accumulation"), truth, "doubles");
    }
}

/// Here the last two entries of the tableau agree to rounding, and are both off.
#[test]
fn entries_that_agree_by_chance_are_not_believed() {
    check_recurrence(
        0.619_723_982_700_620_6,
        0.651_763_723_190_884_8,
        -0.002_110_378_743_751_832_3,
        0.097_622_232_776_814_5,
        0.006_519_855_698_991_18,
    );
}

/// Where no restitution is left at rest, rates fall faster than with any ratio.
#[test]
fn a_restitution_that_vanishes_at_rest_is_followed_to_the_end() {
    let ratio = |rate: Dd| rate / (Dd::ONE + rate);
    let laws: [(&str, &dyn Fn(Dd) -> Dd); 4] = [
        ("abs(v)/(1 + abs(v))", &ratio),
        ("0.9*sqrt(abs(v))", &|rate| Dd::from(0.9) * rate.sqrt()),
        ("0.9*v^2", &|rate| Dd::from(0.9) * rate * rate),
        ("0.8/(1 - 0.1*log(abs(v)))", &|rate| {
            Dd::from(0.8) / (Dd::ONE - Dd::from(0.1) * rate.ln())
        }),
    ];
    for (law, restitution) in laws {
        let model = ball(&[], "y", "-1", law, (0.4, 0.0));
        let truth = recurrence(0.4, |_, rate| restitution(rate));
        let (found, _) = accumulation::<f64>(&model, &[], &[], 10.0);
        assert_told(found.expect("an accumulation"), truth, law);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Restitution that falls to next to nothing with the rate.
    #[test]
    fn little_is_left_at_rest(height in 0.02_f64..0.4, tenths in 0.0_f64..12.0, slope in 0.05_f64..0.9) {
        let rest = 10.0_f64.powf(-tenths) * 0.2;
        let model = ball(&[("r", rest), ("s", slope)], "y", "-1", "r - s*v", (height, 0.0));
        let truth = recurrence(height, |_, rate| Dd::from(rest) + Dd::from(slope) * rate);
        let (found, _) = accumulation::<f64>(&model, &[], &[], truth.to_f64() + 1.0);
        assert_told(found.expect("an accumulation"), truth, "doubles");
    }

    /// Constant restitution on a floor that moves steadily.
    #[test]
    fn closed_forms(height in 0.01_f64..3.0, r in 0.02_f64..0.93, speed in -0.5_f64..0.5, g in 0.2_f64..9.0) {
        let parameters = [("r", r), ("c", speed), ("g", g)];
        let model = ball(&parameters, "y - c*t", "-g", "r", (height, 0.0));
        let [h, r, c, g] = [height, r, speed, g].map(Dd::from);
        // In the floor's frame the ball starts at -c.
        let first = (c * c + Dd::from(2.0) * g * h).sqrt();
        let truth = (first - c) / g + Dd::from(2.0) * r * first / (g * (Dd::ONE - r));
        let until = truth.to_f64() + 1.0;
        let (found, _) = accumulation::<f64>(&model, &[], &[], until);
        assert_told(found.expect("an accumulation"), truth, "doubles");
        let (found, _) = accumulation::<Dd>(&model, &[], &[], until);
        let (time, error) = found.expect("an accumulation");
        let off = (time - truth).abs().to_f64();
        prop_assert!(off <= 1e-27 && off <= 10.0 * error, "{:e} {:e}", off, error);
    }

    /// Restitution that depends on time, place and incoming rate.
    #[test]
    fn recurrences(
        height in 0.02_f64..1.0,
        r in 0.3_f64..0.8,
        drift in -0.03_f64..0.03,
        wave in 0.0_f64..0.1,
        loss in 0.0_f64..0.4,
    ) {
        check_recurrence(height, r, drift, wave, loss);
    }

    /// Forces of any kind, and restitution that drifts: doubles against double-double.
    #[test]
    fn errors_told_are_true(
        (height, rate) in (0.02_f64..0.5, -0.5_f64..0.5),
        (damping, stiffness) in (0.0_f64..0.5, 0.0_f64..2.0),
        (force, frequency) in (0.0_f64..0.3, 0.3_f64..4.0),
        (r, drift, pace) in (0.2_f64..0.8, 0.0_f64..0.15, 0.2_f64..3.0),
    ) {
        let parameters = [
            ("d", damping), ("k", stiffness), ("a", force), ("w", frequency),
            ("r", r), ("s", drift), ("p", pace),
        ];
        let acceleration = "-1 - d*v - k*y + a*cos(w*t)";
        let model = ball(&parameters, "y", acceleration, "r + s*sin(p*t)", (height, rate));
        const UNTIL: f64 = 9.0;
        let (fine, _) = accumulation::<Dd>(&model, &[], &[], UNTIL);
        let (found, _) = accumulation::<f64>(&model, &[], &[], UNTIL);
        prop_assert_eq!(fine.is_some(), found.is_some());
        if let (Some((truth, _)), Some(found)) = (fine, found) {
            assert_told(found, truth, "doubles");
        }
    }

    /// Columns of derivatives by every parameter, the restitution's among them, through complete chatter.
    #[test]
    fn columns_through_complete_chatter(
        (height, damping, stiffness) in (0.05_f64..0.5, 0.0_f64..0.5, 0.0_f64..2.0),
        (force, frequency, tilt) in (0.05_f64..0.3, 0.3_f64..3.0, -0.1_f64..0.1),
        (r, drift, pace) in (0.3_f64..0.75, 0.0_f64..0.1, 0.2_f64..2.0),
    ) {
        let parameters = [
            ("d", damping), ("k", stiffness), ("a", force), ("w", frequency), ("c", tilt),
            ("r", r), ("s", drift), ("p", pace),
        ];
        let acceleration = "-1 - d*v - k*y + a*cos(w*t) + c*x";
        let restitution = "r + s*sin(p*t) + c*y";
        let model = ball(&parameters, "y - c*x", acceleration, restitution, (height, 0.1));
        columns_agree(&model, &parameters, 1e-10)?;
    }

    /// The same where each impact makes a slider slip, that friction holds again before it is struck next: rounding of a column grows with each slip.
    #[test]
    fn columns_through_chatter_whose_flights_come_to_a_stick(
        (mass, friction, drag) in (0.5_f64..3.0, 0.8_f64..1.5, 0.0_f64..0.3),
        (push, force, frequency) in (0.2_f64..0.4, 0.0_f64..0.1, 0.3_f64..3.0),
        (r, damping, drift) in (0.3_f64..0.6, 0.0_f64..0.3, 0.0_f64..0.05),
    ) {
        let parameters = [
            ("m", mass), ("f", friction), ("k", drag), ("p", push), ("a", force),
            ("w", frequency), ("r", r), ("c", damping), ("s", drift),
        ];
        let model = drill(&parameters, ["p + a*cos(w*t) - c*v", "-(f*sign(u) + k*u)/m", "r + s*sin(t)"]);
        columns_agree(&model, &parameters, 1e-9)?;
    }

    /// Two bodies that stay together: resistance accelerates neither towards the other, and what rounding leaves of the
    /// rebound says nothing of the time, which is known to all digits.
    #[test]
    fn a_plastic_impact_without_acceleration_is_known_to_all_digits(
        mass in 0.05_f64..20.0,
        (gap, speed, other) in (0.1_f64..1.0, 0.8_f64..2.0, -0.4_f64..0.3),
    ) {
        let model = ModelBuilder::new()
            .parameter("m", mass)
            .state("x", "v", 0.0)
            .state("v", "-0.25*v", speed)
            .state("y", "w", gap)
            .state("w", "-0.25*w", other)
            .contact("pair", "y - x", [("v", "-1"), ("w", "1/m")], 0.0)
            .build()
            .expect("a valid model");
        let system = System::new(&model).expect("a valid system");
        let mut work = system.workspace::<f64>(&Settings::default());
        let parameters = model.parameter_values::<f64>(&[]);
        let state = model.initial_state(&parameters);
        let mut trajectory = Trajectory::start(&system, &mut work, &parameters, 0.0, &state)
            .expect("a legal start");
        let truth = -4.0 * (-0.25 * gap / (speed - other)).ln_1p();
        let mut met = None;
        loop {
            match trajectory.advance(&system, &mut work, 10.0).expect("a finite field") {
                Some(Occurrence::Impact { .. }) => met = met.or(Some(trajectory.time())),
                Some(Occurrence::Accumulation { error, .. }) => {
                    let off = (trajectory.time() - truth).abs();
                    prop_assert!(error <= 1e-14 * truth.max(1.0), "told {:e}", error);
                    prop_assert!(off <= 10.0 * error + 4.0 * f64::EPSILON * truth, "off by {:e}, told {:e}", off, error);
                }
                Some(Occurrence::Horizon) => break,
                _ => {}
            }
        }
        let off = (met.expect("an impact") - truth).abs();
        prop_assert!(off <= 1e-14 * truth.max(1.0), "off by {:e}", off);
        let apart = trajectory.state()[2] - trajectory.state()[0];
        prop_assert!(apart.abs() <= 1e-13, "apart by {:e}", apart);
    }
}

/// A point mass that is dropped onto a rough incline: each impact stops it along the incline, and so does the rest of them; there
/// it sticks, whatever the extrapolated rate is by rounding. The load is less than the friction force at rest, 2.943.
#[test]
fn what_impacts_have_stopped_sticks_where_chatter_ends() {
    for load in ["-1", "1", "-0.001", "0.1*cos(3*t)", "-2.9"] {
        for speed in [0.5, -0.3, 0.0] {
            let text = format!(
                "[flight]\nx = \"u\"\nu = \"{load} - 0.5*u\"\ny = \"v\"\nv = \"-9.81\"\n[[contact]]\ngap = \"y\"\n\
                 impulse = {{ v = 1 }}\nrestitution = 0.7\nfriction = {{ coefficient = 0.3, along = {{ u = 1 }}, rate = \"u\" }}\n\
                 [initial]\nx = 0\nu = {speed}\ny = 0.02\nv = 0\n"
            );
            let model = Model::from_toml(&text, "incline").unwrap();
            let run = simulate::<f64>(
                &model,
                &Spec::until(3.0),
                &mut |_| ControlFlow::Continue(()),
            );
            let run = run.unwrap_or_else(|error| panic!("{load} from {speed}: {error:?}"));
            assert!(run.state[1].abs() < 1e-15, "{load}: {:?}", run.state);
            assert!(run.state[2].abs() < 1e-18, "{load}: {:?}", run.state);
        }
    }
}

/// A plate whose greatest acceleration just carries a ball: beside that instant the force between both is none to rounding, and only its jerk
/// leads flights back. They end where they are shorter than time can tell, not where rates have no digits left.
#[test]
fn chatter_without_a_force_ends_by_the_jerk() {
    for (length, rate) in [(1.0, 1.0), (1e3, 1e-3), (1e-3, 40.0), (1.0, 1e3)] {
        for restitution in [0.05, 0.1, 0.3, 0.45] {
            let text = format!(
                "[parameters]\nL = {length:?}\nw = {rate:?}\n[flight]\ny = 'v'\nv = 'L*w^2*(sin(p) - 1)'\np = 'w'\n\
                 [[contact]]\nname = 'plate'\ngap = 'y'\nimpulse = {{ v = 1 }}\nrestitution = {restitution}\n\
                 [initial]\ny = 0\nv = '1e-30*L*w'\np = 'pi/2 + 1e-9'\n"
            );
            let model = Model::from_toml(&text, "plate").expect("a valid model");
            // Beyond this the force is told from none.
            let end = 2e-8 / rate;
            let run = simulate::<f64>(
                &model,
                &Spec::until(end),
                &mut |_| ControlFlow::Continue(()),
            )
            .expect("a legal start");
            let context = format!("{length} {rate} {restitution}");
            assert_eq!(run.counts.accumulations, 1, "{context}");
            assert_eq!(run.state[..2], [0.0, 0.0], "{context}");
            // As many as it takes from the first flight to a roundoff of it, each sqrt(2 r) as long as the one before.
            let most = (0.5 * f64::EPSILON).ln() / (2.0_f64 * restitution).sqrt().ln();
            let impacts = run.counts.impacts;
            assert!(impacts as f64 <= most + 4.0, "{context}: {impacts} {most}");
        }
    }
}

/// Flights of a drill under a constant push are all alike, if each slip of what it strikes ends in them: rates fall by one ratio, which is not the restitution.
#[test]
fn chatter_whose_flights_come_to_a_stick_ends_where_its_sum_does() {
    for (m, f, p, r) in [
        (1.0, 1.0, 0.3, 0.5),
        (2.5, 1.4, 0.25, 0.4),
        (0.6, 0.9, 0.35, 0.7),
    ] {
        let parameters = [("m", m), ("f", f), ("p", p), ("r", r)];
        let model = drill(&parameters, ["p", "-f*sign(u)/m", "r"]);
        let [mass, friction, push, restitution] = [m, f, p, r].map(Dd::from);
        let two = Dd::from(2.0);
        // Of an impact with the rate one: what it makes of slider and gap, the end of the slip, and the rest of the flight.
        let slip = (Dd::from(1.0) + restitution) / (mass + Dd::from(1.0));
        let until = slip * mass / friction;
        let rate = restitution - (push + friction / mass) * until;
        let gap = (restitution + rate) * until / two;
        let last = (rate * rate + two * push * gap).sqrt();
        let flight = until + (rate + last) / push;
        assert!(gap.to_f64() > 0.0 && last.to_f64() < 1.0);
        // From rest at a distance of a tenth.
        let fall = (two * Dd::from(0.1) / push).sqrt();
        let truth = fall + push * fall * flight / (Dd::from(1.0) - last);
        let (found, _) = accumulation::<f64>(&model, &[], &[], 20.0);
        assert_told(found.expect("an accumulation"), truth, "doubles");
        let (found, state) = accumulation::<Dd>(&model, &[], &[], 20.0);
        let (time, error) = found.expect("an accumulation");
        let off = (time - truth).abs().to_f64();
        assert!(
            off < 1e-29 && off < 10.0 * error,
            "{m}: off by {off:e}, told {error:e}"
        );
        assert_eq!((state[1].to_f64(), state[3].to_f64()), (0.0, 0.0));
        let spec = Spec::until(20.0);
        let run = simulate::<f64>(&model, &spec, &mut |_| ControlFlow::Continue(())).unwrap();
        assert!(run.counts.impacts < 30, "{}", run.counts.impacts);
    }
}
