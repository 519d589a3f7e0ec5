//! A contact that is touched exactly is a graze: nothing changes, and no impact without a rate is told.

use chatter::flow::{Occurrence, Settings, System, Trajectory};
use chatter::model::{Model, ModelBuilder};
use chatter::numerics::{DoubleDouble, Real};
use proptest::prelude::*;

/// The grazes, and the rates of the impacts.
fn touches<R: Real>(model: &Model, until: f64) -> (Vec<f64>, Vec<f64>) {
    let system = System::new(model).expect("a valid system");
    let mut work = system.workspace::<R>(&Settings::default());
    let parameters = model.parameter_values::<R>(&[]);
    let state = model.initial_state(&parameters);
    let start = model.time.map_or(R::ZERO, |index| state[index]);
    let mut trajectory =
        Trajectory::start(&system, &mut work, &parameters, start, &state).expect("a legal start");
    let (mut grazes, mut rates) = (Vec::new(), Vec::new());
    loop {
        match trajectory.advance(&system, &mut work, R::splat(until)) {
            Ok(Some(Occurrence::Graze { .. })) => grazes.push(trajectory.time().to_f64()),
            Ok(Some(Occurrence::Impact { rate_before, .. })) => rates.push(rate_before.to_f64()),
            Ok(Some(Occurrence::Horizon)) => return (grazes, rates),
            Ok(_) => {}
            Err(error) => panic!("{error}"),
        }
    }
}

/// A motion that touches the floor after each period and nowhere else, seen from a moving floor.
#[derive(Clone, Debug)]
struct Touching {
    amplitude: f64,
    frequency: f64,
    restitution: f64,
    form: usize,
}

impl Touching {
    fn model(&self) -> Model {
        let (a, w) = (self.amplitude, self.frequency);
        let push = format!("{a:?}*{w:?}^2*cos({w:?}*t)");
        let (gap, field) = match self.form {
            0 => ("x".to_owned(), push),
            1 => (
                format!("x - {a:?}*sin(2*{w:?}*t)"),
                format!("{push} - 4*{a:?}*{w:?}^2*sin(2*{w:?}*t)"),
            ),
            2 => (format!("x*(1 + x/{a:?})"), push),
            3 => (format!("x + {a:?}*sin({w:?}*t)^2"), push),
            4 => (format!("{a:?} + x - {a:?}"), format!("{w:?}^2*({a:?} - x)")),
            _ => (format!("sqrt(1 + x/{a:?}) - 1"), push),
        };
        // As a formula, so that it is exact in every number type.
        let rate = if self.form == 1 {
            format!("2*{a:?}*{w:?}")
        } else {
            "0".to_owned()
        };
        ModelBuilder::new()
            .state("x", "v", 0.0)
            .state("v", field, rate)
            .contact(
                "floor",
                gap,
                [("v", 1.0)],
                format!("{:?}", self.restitution),
            )
            .build()
            .expect("a valid model")
    }
}

fn touching() -> impl Strategy<Value = Touching> {
    (-3.0_f64..3.0, -1.0_f64..1.0, 0.0_f64..0.9, 0_usize..6).prop_map(
        |(amplitude, frequency, restitution, form)| Touching {
            amplitude: 10.0_f64.powf(amplitude),
            frequency: 10.0_f64.powf(frequency),
            restitution,
            form,
        },
    )
}

/// No impact is told of a depth that the steps err by, however often it touches.
fn check<R: Real>(touching: &Touching) -> Result<(), TestCaseError> {
    const PERIODS: f64 = 3.0;
    let period = 2.0 * core::f64::consts::PI / touching.frequency;
    let (grazes, rates) = touches::<R>(&touching.model(), (PERIODS + 0.5) * period);
    prop_assert!(rates.is_empty(), "{:?} {:?}", grazes, rates);
    // Rounding may also keep it from getting there.
    prop_assert!(grazes.len() <= PERIODS as usize);
    for graze in grazes {
        let periods = graze / period;
        prop_assert!((periods - periods.round()).abs() < 1e-6);
    }
    Ok(())
}

/// What is deeper than all errors is an impact, and leads to what impacts lead to.
#[test]
fn what_is_deeper_than_its_error_is_an_impact() {
    fn check<R: Real>(depth: f64) {
        let model = ModelBuilder::new()
            .state("x", "v", 2.0)
            .state("v", "-x", 0.0)
            .contact("floor", format!("x + 2 - {depth:e}"), [("v", 1.0)], "0.5")
            .build()
            .expect("a valid model");
        let (grazes, rates) = touches::<R>(&model, 5.0);
        assert!(
            grazes.is_empty() && rates.len() == 1,
            "{depth} {grazes:?} {rates:?}"
        );
        let rate = (4.0 * depth - depth * depth).sqrt();
        assert!((rates[0] / rate + 1.0).abs() < 0.05, "{depth} {rates:?}");
    }
    for depth in [1e-3, 1e-8, 1e-10] {
        check::<f64>(depth);
        check::<DoubleDouble>(depth * depth);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn touching_is_no_impact(touching in touching()) {
        check::<f64>(&touching)?;
        check::<DoubleDouble>(&touching)?;
    }
}

#[test]
fn what_touches_in_numbers_without_rounding_grazes() {
    // (t - 1)^2, (t - 1)^2 (t + 2), 1 + cos(t)
    for (gap, field, start, rate, at) in [
        ("x", "2", 1.0, -2.0, 1.0),
        ("x", "6*t", 2.0, -3.0, 1.0),
        ("1 + x", "-x", 1.0, 0.0, core::f64::consts::PI),
        ("(x - t)^2", "0", 3.0, 0.0, 3.0),
    ] {
        let model = ModelBuilder::new()
            .state("x", "v", start)
            .state("v", field, rate)
            .contact("floor", gap, [("v", 1.0)], "0.5")
            .build()
            .expect("a valid model");
        for (grazes, rates) in [
            touches::<f64>(&model, 6.0),
            touches::<DoubleDouble>(&model, 6.0),
        ] {
            assert!(rates.is_empty(), "{gap} {field}: {rates:?}");
            assert_eq!(grazes.len(), 1, "{gap} {field}: {grazes:?}");
            assert!((grazes[0] - at).abs() < 1e-7, "{gap} {field}: {grazes:?}");
        }
    }
}

/// A particle that passes a disc so near that its rate there is rounding of its speed: a restitution of 0 or 1 is what it is.
#[test]
fn a_weak_impact_obeys_its_restitution() {
    let mut hits = 0;
    for restitution in ["0", "1"] {
        for k in 0..40 {
            let (depth, angle) = (1e-12 * 1.2_f64.powi(k), 0.1 + 0.037 * f64::from(k));
            let (sin, cos) = angle.sin_cos();
            let text = format!(
                "[flight]\nx = \"u\"\nu = \"0\"\ny = \"v\"\nv = \"0\"\n\
                 [[contact]]\nname = \"disc\"\ngap = \"hypot(x, y) - 1\"\nimpulse = {{ u = \"x\", v = \"y\" }}\nrestitution = {restitution}\n\
                 [initial]\nx = {}\nu = {}\ny = {}\nv = {}\n",
                -2.0 * cos - (1.0 - depth) * sin,
                1.1 * cos,
                -2.0 * sin + (1.0 - depth) * cos,
                1.1 * sin
            );
            let model = Model::from_toml(&text, "test").unwrap();
            let (_, rates) = touches::<f64>(&model, 3.0);
            hits += rates.len();
        }
    }
    assert!(hits > 60, "{hits}");
}
