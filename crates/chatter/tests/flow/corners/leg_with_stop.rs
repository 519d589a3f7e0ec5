//! A hopper on a spring leg that only pushes, and whose stop is where the spring is slack: the stop's contact keeps the state on the
//! corner of the spring as long as body and foot fly together.

use super::run;
use chatter::analysis::simulate::Outcome;
use chatter::flow::Occurrence;

/// Lengths in units of `long`, times in units of `short`.
fn hopper(
    leg: &str,
    (body, foot, stiffness): (f64, f64, f64),
    (long, short): (f64, f64),
) -> String {
    let rate = format!("{:?}", long / short);
    let force = format!("(({leg})*{long:?}/{:?})", short * short);
    let leg = force.replace("C", &format!("{stiffness:?}*(0.7 - (y - f)/{long:?})"));
    let weight = format!("{:?}", 9.81 * long / (short * short));
    format!(
        "[flight]\ny = \"v\"\nv = \"{leg}/{body:?} - {weight}\"\nf = \"u\"\nu = \"-{leg}/{foot:?} - {weight}\"\n\
         [[contact]]\nname = \"foot\"\ngap = \"f\"\nimpulse = {{ u = \"1/{foot:?}\" }}\nrestitution = 0\n\
         [[contact]]\nname = \"stop\"\ngap = \"0.7*{long:?} - (y - f)\"\nimpulse = {{ v = \"-1/{body:?}\", u = \"1/{foot:?}\" }}\n\
         restitution = 0\n\
         [initial]\ny = \"0.9*{long:?}\"\nv = \"0*{rate}\"\nf = \"0.2*{long:?}\"\nu = 0\n"
    )
}

/// The leg that pushes with C = k z, z being by how much it is pressed, lets the body go with the speed w that it came with, after
/// (2/o)(pi - atan(o w/g)), o^2 = k/M. The stop takes it to w M/(M + m), with which both fly.
#[test]
fn a_leg_with_a_stop_at_the_corner_of_its_spring_hops_on() {
    for parts in [
        (3.8, 0.22, 913.0),
        (2.1, 0.32, 763.0),
        (2.8, 0.14, 1354.0),
        (1.3, 0.71, 1990.0),
    ] {
        for leg in ["max(C, 0)", "if(C > 0, C, 0)", "(C + abs(C))/2"] {
            for units in [
                (1.0, 1.0),
                (1e-3, 1.0),
                (25.4, 0.01),
                (0.3048, 60.0),
                (1e3, 1e3),
            ] {
                let (body, foot, stiffness) = parts;
                let (gravity, tone) = (9.81, f64::sqrt(stiffness / body));
                let mut speed = f64::sqrt(2.0 * gravity * 0.2);
                let mut time = speed / gravity;
                let hops = 5;
                for _ in 0..hops {
                    time += 2.0 / tone * (std::f64::consts::PI - (tone * speed / gravity).atan());
                    speed *= body / (body + foot);
                    time += 2.0 * speed / gravity;
                }
                // Half way up and down.
                let time = time - speed / gravity;
                let height = speed * speed / (2.0 * gravity);
                let text = hopper(leg, parts, units);
                let run = run::<f64>(&text, time * units.1);
                assert_eq!(run.outcome, Outcome::Horizon, "{text}");
                for (place, expected) in [(0, 0.7 + height), (2, height)] {
                    let off = run.state[place] / units.0 - expected;
                    assert!(off.abs() < 1e-12, "{off:e} {text}");
                }
                let met = |contact: usize| {
                    let told = run.events.iter().filter(
                        |event| matches!(event.detail, Occurrence::Impact { contact: c, .. } if c == contact),
                    );
                    told.count()
                };
                assert_eq!((met(0), met(1)), (hops, hops), "{text}");
                let opened = (run.events.iter())
                    .filter(|event| matches!(event.detail, Occurrence::Release { contact: 1 }));
                assert_eq!(opened.count(), 0, "{text}");
            }
        }
    }
}
