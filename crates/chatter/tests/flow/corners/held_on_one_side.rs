//! What one side alone drives to a surface: the field of the other vanishes there.

use super::run;
use chatter::analysis::simulate::Outcome;
use chatter::flow::Occurrence;
use chatter::numerics::{DoubleDouble, Real};

/// L i' = -U - R i while i > 0, and -R i below: i = 0 after (L/R) log(1 + R/U), and stays.
#[test]
fn a_current_that_a_diode_stops_stays_at_zero() {
    fn check<R: Real>(resistance: f64, tolerance: f64) {
        let text = format!(
            "[flight]\ni = \"(if(i > 0, -12, 0) - {resistance}*i)/0.004\"\n[initial]\ni = 1\n"
        );
        let run = run::<R>(&text, 0.02);
        assert_eq!(run.outcome, Outcome::Horizon, "{resistance}");
        assert!(run.state[0].to_f64().abs() < 1e-15, "{resistance}");
        let stops = 0.004 / resistance * (resistance / 12.0).ln_1p();
        let [stopped] = &run.events[..] else {
            panic!("{resistance}: {} events", run.events.len());
        };
        assert!((stopped.time.to_f64() - stops).abs() < tolerance);
    }
    for k in 1..=60 {
        check::<f64>(0.25 * f64::from(k), 1e-17);
    }
    check::<DoubleDouble>(3.5, 1e-18);
}

/// What a diode has stopped stays so where something else meets a corner, whatever rounding has left of it: y' = 0, from 0.01 on 1, less i.
#[test]
fn a_current_stays_at_zero_as_other_corners_are_met() {
    for k in 1..=40 {
        for unit in [1.0, 0.0920833, 7.3, -3.1] {
            let resistance = 0.25 * f64::from(k);
            let text = format!(
                "[flight]\ni = \"(if({unit:?}*i > 0, -12, 0) - {resistance}*({unit:?}*i))/(0.004*{unit:?})\"\n\
                 y = \"if(t > 0.01, 1, 0) - {unit:?}*i\"\n[initial]\ni = \"1/({unit:?})\"\ny = 0\n"
            );
            let run = run::<f64>(&text, 0.02);
            assert_eq!(run.outcome, Outcome::Horizon, "{resistance} {unit}");
            assert_eq!(run.state[0], 0.0, "{resistance} {unit}");
            let stops = 0.004 / resistance * (resistance / 12.0).ln_1p();
            let charge = 0.004 / resistance - 12.0 * stops / resistance;
            assert!(
                (run.state[1] - (0.01 - charge)).abs() < 1e-15,
                "{resistance} {unit}: {}",
                run.state[1] - (0.01 - charge)
            );
        }
    }
}

/// An event on a surface that is a corner, too: the state goes on to the other side, whatever rounding says where it is.
#[test]
fn an_event_on_its_own_corner_tells_one_switch() {
    for size in [1.0, 7.0, 19.0, 0.3, 1e3, 1e-3] {
        let text = format!(
            "[flight]\nx = \"v\"\nv = \"-{size}*sign(x)\"\n[[event]]\nname = \"up\"\nsurface = \"x\"\n\
             direction = \"either\"\nreset = {{ v = \"0.9*v\" }}\n[initial]\nx = {}\nv = 0\n",
            0.02 * size
        );
        let run = run::<f64>(&text, 2.0);
        let count = |told: fn(&Occurrence<f64>) -> bool| {
            (run.events.iter())
                .filter(|event| told(&event.detail))
                .count()
        };
        let resets = count(|what| matches!(what, Occurrence::Reset { .. }));
        assert!(resets > 4, "{size}: {resets}");
        let switches = count(|what| matches!(what, Occurrence::Switch { .. }));
        assert_eq!(switches, resets, "{size}");
    }
}

/// A carriage leaves its stop just as the motion starts, with a mass on it that its friction takes along: both are one mass of 1.5
/// then, which does not hold the carriage back.
#[test]
fn what_is_taken_along_leaves_a_stop_at_the_start() {
    let starts = (0.05_f64).acos() / 0.4;
    for (unit, off) in [
        (1.0, 0.0),
        (1.0, 4e-16),
        (1e-3, 0.0),
        (1e3, -4e-16),
        (0.7, 4e-16),
    ] {
        let from = format!("t = {:?}\nx = {:?}\nv = 0\n", starts + off, 0.05 * unit);
        let two = format!(
            "[flight]\nx = \"v\"\nv = \"{unit}*cos(0.4*t) - 0.1*{unit}*sign(v - u) - 0.05*v - x\"\nu = \"0.2*{unit}*sign(v - u)\"\n\
             [[contact]]\nname = \"stop\"\ngap = \"0.05*{unit} - x\"\nimpulse = {{ v = -1 }}\nrestitution = 0\n[initial]\n{from}u = 0\n"
        );
        let one = format!(
            "[flight]\nx = \"v\"\nv = \"({unit}*cos(0.4*t) - 0.05*v - x)/1.5\"\n[initial]\n{from}"
        );
        let [two, one] = [two, one].map(|text| run::<f64>(&text, 4.5));
        assert_eq!(two.outcome, Outcome::Horizon, "{unit} {off:e}");
        let [x, v, u] = [0, 1, 2].map(|i| two.state[i]);
        for (ours, right) in [(x, one.state[0]), (v, one.state[1]), (u, one.state[1])] {
            assert!(
                (ours - right).abs() < 1e-13 * unit,
                "{unit}: {ours} {right}"
            );
        }
    }
}
