//! Corners and sections that are multiples of a gap: the contact keeps the state on one side of them.

use super::run;
use chatter::analysis::simulate::Outcome;
use chatter::flow::Occurrence;

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
