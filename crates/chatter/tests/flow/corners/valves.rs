//! A leaflet on its seat between equal pressures, where flow past it is a root of their difference, cut off at the seat or
//! shut there: nothing moves until the pump starts.

use super::run;
use chatter::analysis::simulate::Outcome;
use chatter::flow::Occurrence;

/// The pump starts at pi/5.7 with the rate of a sine. The leaflet opens with the fourth power of time.
fn valve(flow: &str, (long, short): (f64, f64)) -> String {
    format!(
        "[parameters]\nCd = {:?}\nm = {:?}\nks = {:?}\ndd = {:?}\nA = {:?}\nw = {:?}\nC = 0.15\npa = 0.7\n\
         [flight]\np = \"(A*max(-sin(w*t), 0) - ({flow}))/C\"\nx = \"v\"\nv = \"(p - pa - ks*x - dd*v)/m\"\n\
         [[contact]]\nname = \"seat\"\ngap = \"x\"\nimpulse = {{ v = \"1/m\" }}\nrestitution = 0.3\n\
         [initial]\np = 0.7\nx = 0\nv = 0\n",
        8.9 / long / short,
        0.29 * short * short / long,
        3.1 / long,
        0.075 * short / long,
        1.1 / short,
        5.7 / short,
    )
}

/// At time 0.9, by an eighth-order method with steps of 1e-3 from the leading terms 3e-4 after the start.
#[test]
fn a_leaflet_between_equal_pressures_waits_for_the_pump() {
    let (pressure, lift, rate) = (1.46543228, 0.070_235_083_82, 0.69703894);
    for flow in [
        "if(x > 0, Cd*x*sign(p - pa)*sqrt(abs(p - pa)), 0)",
        "Cd*max(x, 0)*sign(p - pa)*sqrt(abs(p - pa))",
        "Cd*x*sign(p - pa)*sqrt(abs(p - pa))",
        "Cd*clamp(x, 0, 1e9)*sign(p - pa)*sqrt(abs(p - pa))",
    ] {
        for units in [(1.0, 1.0), (1e-3, 1e-2), (25.4, 60.0), (1e3, 1.0)] {
            let text = valve(flow, units);
            let run = run::<f64>(&text, 0.9 * units.1);
            assert_eq!(run.outcome, Outcome::Horizon, "{text}");
            let found = [
                run.state[0] - 0.7 - pressure,
                run.state[1] / units.0 - lift,
                run.state[2] / units.0 * units.1 - rate,
            ];
            assert!(found.iter().all(|off| off.abs() < 1e-7), "{found:?} {text}");
            let opened = (run.events.iter())
                .filter(|event| matches!(event.detail, Occurrence::Release { .. }));
            assert!(opened.count() <= 1, "{text}");
        }
    }
}

/// A body pulled off a stop, beside something at rest whose own root or power begins where it is, and which pushes the body by how far it
/// is from there.
#[test]
fn a_contact_opens_beside_a_root_that_begins() {
    for rest in [
        "-sign(p)*sqrt(abs(p))",
        "-sign(p)*abs(p)^1.5",
        "-h*(p - 0)*abs(p)^0.25",
    ] {
        for push in ["p - g", "p^2 - g"] {
            for (long, short) in [(1.0, 1.0), (1e-3, 1e-2), (25.4, 60.0), (1e3, 1.0)] {
                let text = format!(
                    "[parameters]\ng = {:?}\nh = 2\n[flight]\np = \"{rest}\"\nx = \"v\"\nv = \"{push}\"\n\
                     [[contact]]\nname = \"stop\"\ngap = \"a - x\"\nimpulse = {{ v = -1 }}\nrestitution = 0.3\n\
                     [initial]\np = 0\nx = {long:?}\nv = 0\n",
                    long / short / short,
                );
                let text = text.replace("h = 2", &format!("h = 2\na = {long:?}"));
                let run = run::<f64>(&text, short);
                assert_eq!(run.outcome, Outcome::Horizon, "{text}");
                let found = [run.state[1] / long - 0.5, run.state[2] / long * short + 1.0];
                assert!(
                    found.iter().all(|off| off.abs() < 1e-12),
                    "{found:?} {text}"
                );
                assert_eq!(run.state[0], 0.0);
            }
        }
    }
}

/// A leaflet that springs off its stop when there is no difference of pressure any more: a damped swing, in which none arises.
#[test]
fn a_leaflet_leaves_its_stop_between_equal_pressures() {
    for flow in ["Cd*x", "Cd*max(x, 0)", "Cd*clamp(x, 0, xm)", "Cd"] {
        for (long, short) in [(1.0, 1.0), (1e-3, 1e-2), (25.4, 60.0)] {
            let (stiffness, damping) = (10.0 / short / short, 0.6 / short);
            let text = format!(
                "[parameters]\nCd = 8.9\nks = {stiffness:?}\ndd = {damping:?}\nxm = {long:?}\npa = 0.7\n\
                 [flight]\np = \"-{flow}*sign(p - pa)*sqrt(abs(p - pa))\"\nx = \"v\"\n\
                 v = \"{long:?}*(p - pa) - ks*x - dd*v\"\n\
                 [[contact]]\nname = \"seat\"\ngap = \"x\"\nimpulse = {{ v = 1 }}\nrestitution = 0.3\n\
                 [[contact]]\nname = \"stop\"\ngap = \"xm - x\"\nimpulse = {{ v = -1 }}\nrestitution = 0.3\n\
                 [initial]\np = 0.7\nx = {long:?}\nv = 0\n"
            );
            let time: f64 = 0.4;
            let run = run::<f64>(&text, time * short);
            assert_eq!(run.outcome, Outcome::Horizon, "{text}");
            let (slow, fast) = (0.3_f64, (10.0_f64 - 0.09).sqrt());
            let (sine, cosine) = (fast * time).sin_cos();
            let x = (-slow * time).exp() * (cosine + slow / fast * sine);
            let v = -(-slow * time).exp() * 10.0 / fast * sine;
            let found = [
                run.state[1] / long - x,
                run.state[2] / long * short - v,
                run.state[0] - 0.7,
            ];
            assert!(
                found.iter().all(|off| off.abs() < 1e-12),
                "{found:?} {text}"
            );
        }
    }
}
