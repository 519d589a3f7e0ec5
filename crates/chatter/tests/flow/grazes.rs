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

/// An impact is told only of a depth that the steps err by, with a rate below a part `least` of the greatest, and never
/// one without a rate.
fn check<R: Real>(touching: &Touching, least: f64) -> Result<(), TestCaseError> {
    let period = 2.0 * core::f64::consts::PI / touching.frequency;
    // A second time it would not be exact any more.
    let (grazes, rates) = touches::<R>(&touching.model(), 1.5 * period);
    let speed = touching.amplitude * touching.frequency;
    let is_none = |rate: &f64| rate.abs() < least * speed && rate.abs() > least * least * speed;
    prop_assert!(rates.iter().all(is_none), "{:?} {:?}", grazes, rates);
    // Rounding may also keep it from getting there.
    prop_assert!(grazes.len() <= 1);
    for graze in grazes {
        prop_assert!((graze / period - 1.0).abs() < 1e-6);
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn touching_is_no_impact(touching in touching()) {
        // What steps err by, some hundred roundoffs, is a depth that is met with a rate of the size of its root.
        check::<f64>(&touching, 1e-6)?;
        check::<DoubleDouble>(&touching, 1e-13)?;
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
