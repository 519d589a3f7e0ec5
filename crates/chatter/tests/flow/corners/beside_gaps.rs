//! Corners and sections that are multiples of a gap: the contact keeps the state on one side of them.

use super::run;
use chatter::analysis::simulate::{EventKind, Outcome, SimulateError, Spec, simulate};
use chatter::flow::{FlowError, Occurrence};
use chatter::model::Model;
use core::ops::ControlFlow;

/// A spring that pulls to a wall, beside weight that does, too; the wall below or above. The force is written with a corner on the wall, the
/// gap, a section and an event as multiples of how far the wall is.
struct Bounce {
    weight: f64,
    stiffness: f64,
    height: f64,
    restitution: f64,
}

impl Bounce {
    fn text(&self, [force, gap, seen, counted]: [&str; 4], (long, short): (f64, f64)) -> String {
        let above = |formula: &str| {
            formula
                .replace("D", "(w - x)")
                .replace("U", "x")
                .replace("Q", "(1 - x/w)")
        };
        let (sign, wall) = if gap.contains('U') {
            ("-", "+")
        } else {
            ("", "-")
        };
        format!(
            "[parameters]\nw = {:?}\ng = {:?}\nk = {:?}\nm = 0.7\n\
             [flight]\nx = \"v\"\nv = \"{sign}(g + k*({}))\"\nn = \"0\"\n\
             [[contact]]\nname = \"wall\"\ngap = \"{}\"\nimpulse = {{ v = \"0 {wall} 1\" }}\nrestitution = {:?}\n\
             [section.seen]\nsurface = \"{}\"\ndirection = \"either\"\n\
             [[event]]\nname = \"counted\"\nsurface = \"{}\"\ndirection = \"either\"\nreset = {{ n = \"n + 1\" }}\n\
             [initial]\nx = {:?}\nv = 0\nn = 0\n",
            0.3 * long,
            self.weight * long / (short * short),
            self.stiffness / (short * short),
            above(force),
            above(gap),
            self.restitution,
            above(seen),
            above(counted),
            long * if sign == "-" {
                self.height
            } else {
                0.3 - self.height
            },
        )
    }

    /// How far off the wall it is, and after how many impacts: arcs of sines.
    fn at(&self, time: f64) -> (f64, usize) {
        let tone = self.stiffness.sqrt();
        let middle = self.weight / self.stiffness;
        let fall = (middle / (self.height + middle)).acos() / tone;
        if time < fall {
            return ((self.height + middle) * (tone * time).cos() - middle, 0);
        }
        let (mut begun, mut impacts) = (fall, 1);
        let mut speed = self.restitution * (self.height + middle) * tone * (tone * fall).sin();
        loop {
            let flight = 2.0 * (speed / tone / middle).atan() / tone;
            let since = time - begun;
            if since < flight {
                let (sine, cosine) = (tone * since).sin_cos();
                return (speed / tone * sine + middle * cosine - middle, impacts);
            }
            begun += flight;
            impacts += 1;
            speed *= self.restitution;
        }
    }
}

const UNITS: [(f64, f64); 4] = [(1.0, 1.0), (1e-3, 1e-2), (25.4, 60.0), (1e3, 1.0)];

const BELOW: [[&str; 4]; 5] = [
    ["max(U, 0)", "U", "2*U", "-U"],
    ["clamp(U, 0, w)", "2*U", "U", "U/w"],
    ["w*clamp(U/w, 0, 1)", "U", "-U/w", "3*U"],
    ["if(U > 0, U, 0)", "k*U/m", "U", "-U"],
    ["-min(-2*U, 0)/2", "U/w", "-U", "k*U"],
];

const ABOVE: [[&str; 4]; 5] = [
    ["max(D, 0)", "D", "-D", "2*D"],
    ["w - clamp(x, 0, w)", "2*D", "Q", "D"],
    ["w*clamp(Q, 0, 1)", "D", "Q", "-D"],
    ["D*step(Q)", "Q", "D", "-3*D"],
    ["(abs(D) + D)/2", "m*D", "-Q", "D/w"],
];

#[test]
fn what_is_a_multiple_of_a_gap_is_touched_at_impacts_and_not_crossed() {
    let bounce = Bounce {
        weight: 2.7,
        stiffness: 9.3,
        height: 0.21,
        restitution: 0.83,
    };
    for written in BELOW.into_iter().chain(ABOVE) {
        for units in UNITS {
            let until = 1.7;
            let text = bounce.text(written, units);
            let run = run::<f64>(&text, until * units.1);
            assert_eq!(run.outcome, Outcome::Horizon, "{text}");
            let (off, impacts) = bounce.at(until);
            let told = |occurrence: &Occurrence<f64>| {
                matches!(occurrence, Occurrence::Impact { contact: 0, .. })
            };
            assert!(run.events.iter().all(|e| told(&e.detail)), "{text}");
            assert_eq!(run.events.len(), impacts, "{text}");
            let place = run.state[0] / units.0;
            let distance = if written[1].contains('U') {
                place
            } else {
                0.3 - place
            };
            assert!((distance - off).abs() < 1e-13, "{distance} {off} {text}");
            assert_eq!(run.state[2], 0.0, "{text}");
        }
    }
}

#[test]
fn a_contact_at_rest_keeps_the_side_that_it_opens_to() {
    let bounce = Bounce {
        weight: 2.7,
        stiffness: 9.3,
        height: 0.21,
        restitution: 0.3,
    };
    for written in BELOW.into_iter().chain(ABOVE) {
        for units in UNITS {
            let text = bounce.text(written, units);
            let run = run::<f64>(&text, 3.0 * units.1);
            assert_eq!(run.outcome, Outcome::Horizon, "{text}");
            let is_switch = |occurrence: &Occurrence<f64>| {
                matches!(
                    occurrence,
                    Occurrence::Switch { .. }
                        | Occurrence::Section { .. }
                        | Occurrence::Reset { .. }
                )
            };
            assert!(!run.events.iter().any(|e| is_switch(&e.detail)), "{text}");
            let wall = if written[1].contains('U') {
                0.0
            } else {
                0.3 * units.0
            };
            assert!((run.state[0] - wall).abs() <= 1e-16 * units.0, "{text}");
        }
    }
}

/// Weight g + s until the body lifts off, by a force that grows as c t: the corner of the weight is on the ground, and the side that
/// counts is the one in the air.
#[test]
fn a_force_that_jumps_on_the_ground_is_the_one_in_the_air_as_the_contact_opens() {
    for (gap, side) in [
        ("x", "step(x)"),
        ("2*x", "if(x > 0, 1, 0)"),
        ("b*x", "step(b*x)"),
    ] {
        let text = format!(
            "[parameters]\nb = 0.7\n[flight]\nx = \"v\"\nv = \"12*t - 10 - 5*{side}\"\n\
             [[contact]]\nname = \"ground\"\ngap = \"{gap}\"\nimpulse = {{ v = 1 }}\nrestitution = 0\n\
             [initial]\nx = 0\nv = 0\n"
        );
        let run = run::<f64>(&text, 2.0);
        assert_eq!(run.outcome, Outcome::Horizon, "{text}");
        // x''' = 12 from t = 15/12 on.
        let since: f64 = 2.0 - 1.25;
        assert!((run.state[0] - 2.0 * since.powi(3)).abs() < 1e-14, "{text}");
        let [event] = &run.events[..] else {
            panic!("{:?} {text}", run.events);
        };
        assert!(matches!(event.detail, Occurrence::Release { contact: 0 }));
        assert!((event.time - 1.25).abs() < 1e-14, "{text}");
    }
}

/// Two bodies in free fall that a spring and a thrust drive apart up to a stop between them, where both end: they come to rest on it,
/// pressed by the thrust c (T - t) of the side that the stop keeps them on, and part at T. From then on their distance from the stop is
/// c/k (s - sin(w s)/w), w^2 = k (1/M + 1/m).
#[test]
fn what_ends_at_a_stop_presses_the_bodies_at_rest_on_it() {
    let (heavy, light, stiffness, fade, reach) = (1.34259666857, 0.26576735462, 16.0, 2.0, 0.791);
    for (long, short) in [(1.0, 1.0), (1e-3, 1e-2), (25.4, 60.0), (1e3, 1.0)] {
        let unit = long / (short * short);
        let text = format!(
            "[parameters]\nM = {heavy:?}\nm = {light:?}\nk = {:?}\nl = {:?}\nc = {:?}\nT = {:?}\ng = {:?}\n\
             [flight]\ny = \"v\"\nv = \"(max(k*(l - (y - f)), 0) + if(y - f < l, c*(T - t), 0))/M - g\"\n\
             f = \"u\"\nu = \"-(max(k*(l - (y - f)), 0) + if(y - f < l, c*(T - t), 0))/m - g\"\n\
             [[contact]]\nname = \"stop\"\ngap = \"l - (y - f)\"\nimpulse = {{ v = \"-1/M\", u = \"1/m\" }}\nrestitution = 0.4\n\
             [initial]\ny = {:?}\nv = {:?}\nf = 0\nu = {:?}\n",
            stiffness / (short * short),
            reach * long,
            fade * unit / short,
            4.0 * short,
            0.5 * unit,
            (reach - 0.05) * long,
            0.37 * long / short,
            0.37 * long / short,
        );
        let run = run::<f64>(&text, 5.0 * short);
        assert_eq!(run.outcome, Outcome::Horizon, "{text}");
        let tone = (stiffness * (1.0 / heavy + 1.0 / light)).sqrt();
        let apart = reach - fade / stiffness * (1.0 - tone.sin() / tone);
        let distance = (run.state[0] - run.state[2]) / long;
        assert!(
            (distance - apart).abs() < 1e-12,
            "{distance} {apart} {text}"
        );
        let middle = (heavy * run.state[0] + light * run.state[2]) / (heavy + light) / long;
        let fallen = heavy * (reach - 0.05) / (heavy + light) + 0.37 * 5.0 - 0.25 * 25.0;
        assert!((middle - fallen).abs() < 1e-12, "{middle} {fallen} {text}");
        let told: Vec<_> = (run.events.iter())
            .filter(|event| !matches!(event.detail, Occurrence::Impact { .. }))
            .collect();
        let [rests, parts] = told[..] else {
            panic!("{told:?} {text}");
        };
        assert!(
            matches!(rests.detail, Occurrence::Accumulation { .. }),
            "{told:?}"
        );
        assert!(
            matches!(parts.detail, Occurrence::Release { contact: 0 }),
            "{told:?}"
        );
        assert!((parts.time / short - 4.0).abs() < 1e-12, "{told:?} {text}");
    }
}

/// Two bodies at rest on a stop that keeps them from going further apart, one of them driven off the other as long as it rises: as the
/// stop holds them together they fall, and then nothing drives them. The upper one falls alone. Where the lower one is drawn up as
/// strongly both rise, which is another motion: neither is told.
#[test]
fn what_would_press_a_contact_at_rest_is_asked_with_it_closed() {
    for (long, short) in [(1.0, 1.0), (1e-3, 1e-2), (25.4, 60.0), (1e3, 1.0)] {
        let unit = long / (short * short);
        let text = |lift: f64| {
            format!(
                "[parameters]\nM = 2\nm = 0.5\nF = {:?}\nl = {long:?}\ng = {unit:?}\nlift = {:?}\n\
                 [flight]\ny = \"v\"\nv = \"if(v > 0, F, 0)/M - g\"\nf = \"u\"\nu = \"lift - if(v > 0, F, 0)/m\"\n\
                 [[contact]]\nname = \"stop\"\ngap = \"l - (y - f)\"\nimpulse = {{ v = \"-1/M\", u = \"1/m\" }}\nrestitution = 0.4\n\
                 [initial]\ny = {long:?}\nv = 0\nf = 0\nu = 0\n",
                5.0 * unit,
                lift * unit,
            )
        };
        let run = run::<f64>(&text(3.0), 0.5 * short);
        assert_eq!(run.outcome, Outcome::Horizon);
        let expected = [1.0 - 0.125, -0.5, 3.0 * 0.125, 1.5];
        let scales = [long, long / short, long, long / short];
        for ((found, expected), scale) in run.state.iter().zip(expected).zip(scales) {
            assert!((found / scale - expected).abs() < 1e-14, "{:?}", run.state);
        }
        let told: Vec<_> = run.events.iter().map(|event| event.kind).collect();
        assert_eq!(told, [EventKind::Graze], "it starts in touch");
        let model = Model::from_toml(&text(5.0), "model.toml").expect("a valid model");
        let both = simulate::<f64>(&model, &Spec::until(0.5 * short), &mut |_| {
            ControlFlow::Continue(())
        });
        assert!(
            matches!(both, Err(SimulateError::Start(FlowError::NotUnique { .. }))),
            "{both:?}"
        );
    }
}
