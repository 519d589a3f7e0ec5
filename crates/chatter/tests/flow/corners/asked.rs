//! Corners that only impacts and resets ask for: they are decided at that instant, by the values there, and are no part of the motion
//! between.

use super::run;
use chatter::analysis::simulate::Outcome;
use chatter::flow::{FlowError, Occurrence};
use chatter::numerics::{DoubleDouble, Real};

/// A ball on a floor that falls with 2, so that a flight takes as long as the rate that it begins with.
fn ball(tables: &str, restitution: &str, start: (f64, f64)) -> String {
    let (y, v) = start;
    format!(
        "{tables}[flight]\ny = \"v\"\nv = \"-2\"\n[[contact]]\nname = \"floor\"\ngap = \"y\"\nimpulse = {{ v = 1 }}\n\
         restitution = \"{restitution}\"\n[initial]\ny = {y}\nv = {v}\n"
    )
}

fn ratio<R: Real>(p: f64, q: f64) -> R {
    R::splat(p) / R::splat(q)
}

/// The rates of impacts and their times, and when it ends in rest: `law` is the restitution, `rest` that of slow impacts.
fn check<R: Real>(
    (tables, restitution): (&str, &str),
    (law, rest): (&dyn Fn(R) -> R, R),
    within: f64,
) {
    for start in [100.0, 97.0, 190.0] {
        let run = run::<R>(&ball(tables, restitution, (0.0, start / 100.0)), 30.0);
        assert_eq!(run.outcome, Outcome::Horizon, "{restitution} {start}");
        let (mut rate, mut time) = (ratio(start, 100.0), R::ZERO);
        let mut impacts = 0;
        for event in &run.events {
            let told = match event.detail {
                Occurrence::Impact {
                    rate_before,
                    rate_after,
                    ..
                } => {
                    time += rate;
                    let off = (rate_before + rate).abs() / rate;
                    assert!(off.to_f64() < within, "{restitution} {start} {off}");
                    rate *= law(rate);
                    let off = (rate_after - rate).abs() / rate;
                    assert!(off.to_f64() < within, "{restitution} {start} {off}");
                    impacts += 1;
                    time
                }
                Occurrence::Accumulation { .. } => time + rate / (R::ONE - rest),
                other => panic!("{restitution} {start} {other:?}"),
            };
            let off = (event.time - told).abs().to_f64();
            assert!(off < within, "{restitution} {start} {impacts} {off:e}");
        }
        let last = run.events.last().map(|event| event.detail);
        assert!(
            matches!(last, Some(Occurrence::Accumulation { .. })),
            "{restitution} {start}"
        );
        assert!(
            impacts > 3 && run.state.iter().all(|x| *x == R::ZERO),
            "{restitution} {start}"
        );
    }
}

fn restitutions<R: Real>(within: f64) {
    // Johnson's elastoplastic law, which has no value at rest.
    let johnson = |v: R| (ratio::<R>(1.0, 2.0) / v.sqrt().sqrt()).min(ratio(9.0, 10.0));
    check(
        ("", "min(0.9, 0.5*abs(v)^(-0.25))"),
        (&johnson, ratio(9.0, 10.0)),
        within,
    );
    let constant = |v: R| (ratio::<R>(18.0, 100.0) / v).min(ratio(9.0, 10.0));
    check(
        ("", "min(0.9, 0.18/abs(v))"),
        (&constant, ratio(9.0, 10.0)),
        within,
    );
    // A table is asked for abs(v), which is inside at impacts.
    let tenth = |n: f64| ratio::<R>(n, 10.0);
    let table = |v: R| {
        let between = |x: [f64; 2], y: [f64; 2]| {
            let part = (v - tenth(x[0])) / (tenth(x[1]) - tenth(x[0]));
            tenth(y[0]) + part * (tenth(y[1]) - tenth(y[0]))
        };
        if v < tenth(3.0) {
            between([0.0, 3.0], [9.0, 8.0])
        } else if v < tenth(6.0) {
            between([3.0, 6.0], [8.0, 7.0])
        } else {
            between([6.0, 20.0], [7.0, 6.0])
        }
    };
    let e = "[table.e]\nx = [0, 0.3, 0.6, 2]\ny = [0.9, 0.8, 0.7, 0.6]\n";
    // The restitution goes on changing as the rate falls, so the sequence is followed down to where that is rounding.
    for argument in ["e(abs(v))", "e(-v)"] {
        let run = run::<R>(&ball(e, argument, (0.0, 0.97)), 30.0);
        assert_eq!(run.outcome, Outcome::Horizon);
        let (mut rate, mut time) = (ratio(97.0, 100.0), R::ZERO);
        for event in &run.events {
            if let Occurrence::Impact { rate_after, .. } = event.detail {
                time += rate;
                rate *= table(rate);
                assert!(((rate_after - rate).abs() / rate).to_f64() < within);
                assert!((event.time - time).abs().to_f64() < within);
            }
        }
        let Some(end) = run.events.last() else {
            panic!("nothing happens");
        };
        assert!(matches!(end.detail, Occurrence::Accumulation { .. }));
        for _ in 0..2000 {
            time += rate;
            rate *= table(rate);
        }
        let off = (end.time - time).abs().to_f64();
        assert!(off < within, "{argument} {off:e}");
    }
    // Whole parts.
    let floor = |v: R| {
        let tenths = R::splat((v * R::splat(10.0)).to_f64().floor());
        tenth(9.0) - tenths * ratio(2.0, 100.0)
    };
    check(
        ("", "0.9 - 0.02*floor(abs(v)*10)"),
        (&floor, tenth(9.0)),
        within,
    );
}

#[test]
fn a_restitution_is_asked_at_impacts_only() {
    restitutions::<f64>(1e-13);
    restitutions::<DoubleDouble>(1e-24);
}

/// Collisions of one instant, each with the restitution of its own rate.
#[test]
fn each_collision_of_a_cascade_asks_for_its_own() {
    let text = r#"
        [flight]
        x = "v"
        v = "0"
        u = "w"
        w = "0"
        [[contact]]
        name = "wall"
        gap = "x"
        impulse = { v = 1 }
        restitution = "min(0.7, 0.5*abs(v)^(-0.25))"
        [[contact]]
        name = "pair"
        gap = "u - x"
        impulse = { w = 1, v = -1 }
        restitution = "min(0.8, 0.6/abs(w - v))"
        [initial]
        x = 1
        v = -2
        u = 1
        w = -2
        "#;
    let run = run::<f64>(text, 2.0);
    let (mut v, mut w) = (-2.0_f64, -2.0_f64);
    let mut expected = Vec::new();
    while v < -1e-12 || w - v < -1e-12 {
        if v < w - v {
            expected.push(v);
            v *= -(0.5 * v.abs().powf(-0.25)).min(0.7);
        } else {
            expected.push(w - v);
            let rebound = (0.6 / (w - v).abs()).min(0.8) * (w - v);
            (v, w) = (0.5 * (v + w + rebound), 0.5 * (v + w - rebound));
        }
    }
    let rates: Vec<f64> = (run.events.iter())
        .filter_map(|event| match event.detail {
            Occurrence::Impact { rate_before, .. } => Some(rate_before),
            _ => None,
        })
        .collect();
    assert!(
        rates.len() > 2 && rates.len() == expected.len(),
        "{rates:?} {expected:?}"
    );
    for (found, expected) in rates.iter().zip(&expected) {
        assert!((found - expected).abs() < 1e-14, "{rates:?}");
    }
    assert!((run.state[1] - v).abs() < 1e-14 && (run.state[3] - w).abs() < 1e-14);
}

/// A circle map whose step takes it to whole numbers but for rounding: a whole part is that of the very number that it is taken of.
#[test]
fn a_whole_part_in_a_reset_is_that_of_its_number() {
    for start in [
        0.0,
        0.5,
        0.500_000_000_000_000_3,
        0.999_999_999_999_999_9,
        0.3,
    ] {
        for step in [0.5, 0.1, 0.7, 1.0, 0.0] {
            let text = format!(
                "[flight]\np = \"1\"\nth = \"0\"\n[[event]]\nname = \"map\"\nsurface = \"p - 1\"\ndirection = \"rising\"\n\
                 reset = {{ p = 0, th = \"mod(th + {step}, 1)\" }}\n[initial]\np = 0\nth = {start:?}\n"
            );
            let run = run::<f64>(&text, 40.5);
            assert_eq!(run.events.len(), 40);
            let mut th: f64 = start;
            for event in &run.events {
                th += step;
                th -= th.floor();
                assert_eq!(event.state[1], th, "{start} {step}");
            }
        }
    }
}

/// What lies on its corner at an event is where the motion takes it: past the event's own surface.
#[test]
fn a_reset_lies_beyond_the_surface_of_its_event() {
    fn check<R: Real>(within: f64) {
        // Each passage of zero adds a tenth to the rate.
        let swing = run::<R>(
            "[flight]\nx = \"v\"\nv = \"-x\"\n[[event]]\nname = \"zero\"\nsurface = \"x\"\nreset = { v = \"v + 0.1*sign(x)\" }\n\
             [initial]\nx = 1\nv = 0\n",
            40.0,
        );
        assert_eq!(swing.events.len(), 13);
        for (n, event) in swing.events.iter().enumerate() {
            let rate = event.state[1].abs().to_f64();
            assert!(
                (rate - 1.0 - 0.1 * (n + 1) as f64).abs() < within,
                "{n} {rate}"
            );
        }
        // A clock that is at a whole number counts it, whichever way it runs.
        for (rate, counted) in [(1.0, 1.0), (-1.0, -2.0), (0.1, 1.0)] {
            let clock = run::<R>(
                &format!(
                    "[flight]\np = \"{rate}\"\nq = \"0\"\n[[event]]\nname = \"tick\"\nsurface = \"abs(p) - 1\"\ndirection = \"rising\"\n\
                     reset = {{ p = 0, q = \"q + floor(p)\" }}\n[initial]\np = 0\nq = 0\n"
                ),
                10.5 / f64::abs(rate),
            );
            assert_eq!(clock.events.len(), 10);
            for (n, event) in clock.events.iter().enumerate() {
                assert_eq!(event.state[1].to_f64(), counted * (n + 1) as f64, "{rate}");
            }
        }
    }
    check::<f64>(1e-13);
    check::<DoubleDouble>(1e-13);
}

/// A table that an impact leaves is told at that impact.
#[test]
fn a_table_that_only_impacts_ask_ends_at_them() {
    let e = "[table.e]\nx = [0, 1.5]\ny = [0.9, 0.6]\n";
    let run = run::<f64>(&ball(e, "e(abs(v))", (0.0, 1.6)), 30.0);
    match run.outcome {
        Outcome::Failed(FlowError::OutsideTable { time, argument, .. }) => {
            assert!((time - 1.6).abs() < 1e-13 && (argument - 1.6).abs() < 1e-13);
        }
        other => panic!("{other:?}"),
    }
}

/// What only resets change is where plain evaluation says: no motion has brought it to the whole number that it stands at.
#[test]
fn counters_are_where_plain_evaluation_says() {
    type Rate = fn(f64) -> f64;
    let ticks = |k: usize| k as f64 * core::f64::consts::FRAC_PI_3 - 0.1;
    let counted: [(&str, Rate); 5] = [
        ("floor(n)", |n| n),
        ("mod(n, 3)", |n| n % 3.0),
        ("floor(n/2)", |n| (n / 2.0).floor()),
        ("if(n >= 2, 1, 0)", |n| f64::from(u8::from(n >= 2.0))),
        ("if(n > 2, 1, 0)", |n| f64::from(u8::from(n > 2.0))),
    ];
    for (rate, at) in counted {
        let event = |name: &str, direction: &str| {
            format!(
                "[[event]]\nname = \"{name}\"\nsurface = \"sin(3*x)\"\ndirection = \"{direction}\"\nreset = {{ n = \"n + 1\" }}\n"
            )
        };
        let text = format!(
            "[flight]\nx = 1\nn = 0\nw = \"{rate}\"\n{}{}[initial]\nx = 0.1\nn = 0\nw = 0\n",
            event("a", "rising"),
            event("b", "falling"),
        );
        let run = run::<f64>(&text, 12.0);
        let last = (1..).take_while(|&k| ticks(k) < 12.0).count();
        let of = |k: usize| at(k as f64) * (ticks(k + 1).min(12.0) - ticks(k).max(0.0));
        let sum: f64 = (0..=last).map(of).sum();
        assert!(
            (run.state[2] - sum).abs() < 1e-12,
            "{rate}: {:?} {sum}",
            run.state
        );
    }
    // At impacts, too: from 1.41 to 3.96 one, from there two.
    let ball = run::<f64>(
        "[flight]\ny = \"v\"\nv = \"-1\"\nn = 0\nw = \"floor(n)\"\n[[contact]]\nname = \"floor\"\ngap = \"y\"\n\
         reset = { v = \"-0.9*v\", n = \"n + 1\" }\n[initial]\ny = 1\nv = 0\nn = 0\nw = 0\n",
        6.0,
    );
    let fall = f64::sqrt(2.0);
    let expected = 1.8 * fall + 2.0 * (6.0 - 2.8 * fall);
    assert!((ball.state[3] - expected).abs() < 1e-13, "{:?}", ball.state);
}

/// Nor is the whole number that a counter stands at a place that motion could leave, where chatter ends and where surfaces meet.
#[test]
fn counters_stand_at_thresholds_where_motion_meets_corners() {
    let wall = "[flight]\nx = \"v\"\nv = \"1 - 0.1*v*abs(v)\"\nu = \"RATE\"\nn = 0\n[[contact]]\ngap = \"-x\"\n\
                impulse = { v = -1 }\nrestitution = 0.1\n[[event]]\nname = \"tick\"\nsurface = \"t - 50\"\ndirection = \"rising\"\n\
                reset = { n = \"n + 1\" }\n[initial]\nx = -1\nv = 0\nu = 0\nn = 2\n";
    for (rate, right) in [
        ("if(n >= 2, 1, 0)", 12.0),
        ("if(n > 2, 1, 0)", 0.0),
        ("floor(n)", 24.0),
    ] {
        let run = run::<f64>(&wall.replace("RATE", rate), 12.0);
        assert_eq!(run.outcome, Outcome::Horizon, "{rate}");
        assert!(
            (run.state[2] - right).abs() < 1e-13,
            "{rate}: {:?}",
            run.state
        );
    }
}
