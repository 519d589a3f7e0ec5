//! The pressure relief valve of the paper: double against double-double, and the verdict on either side of the border.

use chatter::flow::{Occurrence, Settings, System, Trajectory};
use chatter::model::Model;
use chatter::numerics::{DoubleDouble, Real, Scalar};

const VALVE: &str = include_str!("../../../../models/pressure_relief_valve.toml");

/// Times and states of all occurrences up to and including the first accumulation or section, whichever is asked for.
struct Run<R> {
    told: Vec<(R, Vec<R>, Occurrence<R>)>,
}

/// Parameters are the doubles of the f64 run in any precision: the same system.
fn run<R: Real>(
    q: f64,
    tolerance: f64,
    until: f64,
    stop: impl Fn(&Occurrence<R>) -> bool,
) -> Run<R> {
    let model = Model::from_toml(VALVE, "valve").expect("a valid model");
    let system = System::new(&model).expect("a valid system");
    let mut work = system.workspace::<R>(&Settings {
        tolerance,
        ..Settings::default()
    });
    let rounded = model.parameter_values::<f64>(&[(0, q)]);
    let parameters: Vec<R> = rounded.iter().map(|&p| R::splat(p)).collect();
    let state = model.initial_state(&parameters);
    let mut trajectory =
        Trajectory::start(&system, &mut work, &parameters, R::ZERO, &state).expect("a legal start");
    let mut told = Vec::new();
    loop {
        let Some(what) = trajectory
            .advance(&system, &mut work, R::splat(until))
            .expect("a finite field")
        else {
            continue;
        };
        told.push((trajectory.time(), trajectory.state().to_vec(), what));
        if stop(&what) || what == Occurrence::Horizon {
            return Run { told };
        }
    }
}

fn accumulates<R>(what: &Occurrence<R>) -> bool {
    matches!(what, Occurrence::Accumulation { .. })
}

#[test]
fn every_impact_and_the_accumulation_agree_with_double_double() {
    let double = run::<f64>(0.0195, 0.0, 40.0, accumulates);
    let exact = run::<DoubleDouble>(0.0195, 0.0, 40.0, accumulates);
    let impacts = double.told.len() - 1;
    assert!(impacts > 30);
    for (place, (have, want)) in double.told[..impacts].iter().zip(&exact.told).enumerate() {
        let late = (DoubleDouble::from(have.0) - want.0).abs().high();
        assert!(late < 1e-12 * have.0, "impact {place} off by {late:e}");
        for (x, y) in have.1.iter().zip(&want.1) {
            let off = (DoubleDouble::from(*x) - *y).abs().high();
            assert!(
                off < 1e-12 * y.high().abs().max(1.0),
                "state at impact {place} off by {off:e}"
            );
        }
    }
    let (have, want) = (&double.told[impacts], exact.told.last().expect("an end"));
    let late = (DoubleDouble::from(have.0) - want.0).abs().high() / have.0;
    let pressure = (DoubleDouble::from(have.1[2]) - want.1[2]).abs().high() / have.1[2];
    println!("accumulation: time off by {late:e}, pressure by {pressure:e}");
    assert!(late < 1e-13 && pressure < 1e-13, "{late:e} {pressure:e}");
    assert_eq!((have.1[0], have.1[1]), (0.0, 0.0));
}

#[test]
fn thirty_digits_agree_with_themselves_at_another_order() {
    let fine = run::<DoubleDouble>(0.0195, 0.0, 40.0, accumulates);
    // A looser tolerance, so other orders and other step ends throughout.
    let other = run::<DoubleDouble>(0.0195, 1e-31, 40.0, accumulates);
    let (a, b) = (
        fine.told.last().expect("an end"),
        other.told.last().expect("an end"),
    );
    let late = ((a.0 - b.0) / a.0).abs().high();
    let pressure = ((a.1[2] - b.1[2]) / a.1[2]).abs().high();
    println!("{late:e} {pressure:e}");
    assert!(late < 1e-28 && pressure < 1e-28, "{late:e} {pressure:e}");
}

#[test]
fn the_verdict_is_right_on_either_side_of_the_border() {
    let ends = |what: &Occurrence<f64>| {
        matches!(
            what,
            Occurrence::Accumulation { .. } | Occurrence::Section { .. }
        )
    };
    for (q, complete) in [
        (0.019, true),
        (0.020056, true),
        (0.0200561, false),
        (0.0203, false),
    ] {
        let told = run::<f64>(q, 0.0, 40.0, ends).told;
        // The first crossing of the section belongs to the opening flight; what follows the impacts counts.
        let after = run::<f64>(q, 0.0, 5.5, |what| {
            accumulates(what) || matches!(what, Occurrence::Horizon)
        });
        assert!(!told.is_empty());
        assert_eq!(
            after.told.iter().any(|(_, _, what)| accumulates(what)),
            complete,
            "q = {q}"
        );
    }
}

#[test]
fn chaos_keeps_its_time_for_a_hundred_impacts() {
    let hundred = |count: usize| {
        let seen = std::cell::Cell::new(0);
        move |is_impact: bool| {
            seen.set(seen.get() + usize::from(is_impact));
            seen.get() == count
        }
    };
    let (f, d) = (hundred(100), hundred(100));
    let double = run::<f64>(0.0205, 0.0, 1e3, |what| {
        f(matches!(what, Occurrence::Impact { .. }))
    });
    let exact = run::<DoubleDouble>(0.0205, 0.0, 1e3, |what| {
        d(matches!(what, Occurrence::Impact { .. }))
    });
    let (a, b) = (
        double.told.last().expect("an end"),
        exact.told.last().expect("an end"),
    );
    let late = (DoubleDouble::from(a.0) - b.0).abs().high();
    println!("after 100 impacts at {}: off by {late:e}", a.0);
    assert!(late < 2e-13, "{late:e}");
}
