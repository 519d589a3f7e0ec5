//! Dry friction on ground that yields: it vanishes with the force that presses, while the rate of sliding may be zero still.

use super::run;
use chatter::analysis::simulate::{Outcome, Simulation};
use chatter::flow::Occurrence;
use chatter::numerics::{DoubleDouble, Real};

const GRAVITY: f64 = 9.81;

/// A ball of radius 0.1 and inertia 0.004 that is pressed with `force` and slides at rate u - 0.1 om.
fn ball<R: Real>(force: &str, height: f64, spin: f64) -> Simulation<R> {
    let text = format!(
        r#"
        [definitions]
        N = "{force}"
        F = "-0.3*N*sign(u - 0.1*om)"
        [flight]
        y = "w"
        w = "-{GRAVITY} + N"
        x = "u"
        u = "F"
        om = "-0.1*F/0.004"
        [initial]
        y = {height}
        w = 0
        x = 0
        u = 0.3
        om = {spin}
        "#
    );
    run::<R>(&text, 4.0)
}

/// What slides no longer when the ball leaves the ground does not when it is back.
#[test]
fn a_ball_that_rolls_goes_on_rolling_from_bounce_to_bounce() {
    fn check<R: Real>(force: &str, height: f64, spin: f64) {
        let run = ball::<R>(force, height, spin);
        assert_eq!(run.outcome, Outcome::Horizon, "{force} {height}");
        let slides = |what: &Occurrence<R>| matches!(what, Occurrence::Slide { .. });
        let times: Vec<R> = (run.events.iter())
            .filter(|event| slides(&event.detail))
            .map(|event| event.time)
            .collect();
        assert!(times.len() > 2, "{force} {height}: {}", times.len());
        // Friction changes the sum of 0.004 om and 0.1 u by nothing.
        let rolls = (0.004 * spin + 0.1 * 0.3) / (0.004 + 0.1 * 0.1);
        let [_, _, _, rate, turning] = run.state[..] else {
            panic!("{} states", run.state.len());
        };
        assert!((turning.to_f64() - rolls).abs() < 1e-14, "{turning:?}");
        assert!((rate.to_f64() - 0.1 * rolls).abs() < 1e-15, "{rate:?}");
    }
    let forces = [
        "1000*max(-y, 0)",
        "max(-1000*y - 0.7*w, 0)*step(-y)",
        "if(y < 0, max(-1000*y - 0.7*w, 0), 0)",
        "1000*max(-y, 0)*(1 + 0.1*abs(w))",
        "2e4*max(-y, 0)^1.5",
    ];
    for force in forces {
        for height in [0.05, 0.124, 0.31, 0.494, 0.753] {
            check::<f64>(force, height, -2.0);
            check::<f64>(force, height, 5.0);
        }
        check::<DoubleDouble>(force, 0.31, -2.0);
    }
}
