//! What is held: a contact that could not stay closed where it closes, a stick that would slip where it begins, are no motion.

use super::{model, over, value, with};
use chatter::analysis::periodic::SpecialKind;
use chatter::analysis::simulate::{Spec as Until, simulate};
use chatter::model::Model;
use chatter::numerics::Real;
use std::ops::ControlFlow;

/// A plastic ball on a shaken table. It takes off at sin t = 1/G, and lands at t = 3 pi - asin(1/G), where it would take off, for G = G*.
const PLASTIC: &str = r#"
[parameters]
G = 5
[flight]
y = "v"
v = "-1"
[[contact]]
name = "table"
gap = "y - G*sin(t)"
impulse = { v = 1 }
restitution = "0"
[initial]
y = 0
v = 5
"#;
/// Where 3 pi - 2 asin(1/G) = 2 sqrt(G^2 - 1): lifted and landed where the table falls with g.
const BORDER: f64 = 4.603_338_848_751_7;

#[test]
fn a_ball_stays_where_the_table_holds_it() {
    for start in ["5", "4.4"] {
        let found = over(&with(PLASTIC, &[("G", start)]), "G", (4.0, 6.0), (40, 0.02));
        assert_eq!(found.len(), 1);
        let off_border = |g: f64| (g - BORDER).abs() > 1e-9;
        for point in (found[0].points.iter()).filter(|point| off_border(point.parameter())) {
            let impacts = if point.parameter() < BORDER { 2 } else { 1 };
            assert_eq!(point.impacts, Some(impacts), "{}", point.parameter());
        }
    }
    let found = over(&with(PLASTIC, &[]), "G", (4.0, 6.0), (40, 0.02));
    let told = &found[0].special;
    assert_eq!(told.len(), 1, "{told:?}");
    assert_eq!(told[0].kind, SpecialKind::Touch);
    let off = (value(&told[0]) - BORDER).abs();
    assert!(
        off < 1e-11 && off <= told[0].error,
        "{off:e} {:e}",
        told[0].error
    );
}

/// Each orbit of a branch, simulated for its period, comes back.
fn all_come_back(model: &Model, name: &str, range: (f64, f64)) {
    let branches = over(model, name, range, (40, 0.005));
    let mut count = 0;
    for point in branches.iter().flat_map(|branch| &branch.points) {
        let mut begun = model.clone();
        begun
            .set_parameter(name, &point.parameter().to_string())
            .unwrap();
        let clock = model.time.map_or(0.0, |time| point.state[time]);
        for (state, value) in model.states.iter().zip(&point.state) {
            begun.set_initial(&state.name, &value.to_string()).unwrap();
        }
        let run = simulate::<f64>(&begun, &Until::until(clock + point.period), &mut |_| {
            ControlFlow::Continue(())
        })
        .unwrap();
        for (i, (x, y)) in run.state.iter().zip(&point.state).enumerate() {
            let off = (x.to_f64() - y).abs();
            assert!(
                Some(i) == model.time || off < 1e-9,
                "{name} = {}: {off:e}",
                point.parameter()
            );
        }
        count += 1;
    }
    assert!(count > 30, "{count}");
}

/// Onto and off a Hertzian stop, and past where it is touched first.
#[test]
fn orbits_of_a_hertzian_stop_come_back() {
    let text = "[parameters]\nom = 1.7\n[flight]\nx = \"v\"\nv = \"0.5*cos(om*t) - 0.2*v - x - 5*max(x - 0.3, 0)^1.5\"\n\
                [section.strobe]\nsurface = \"sin(om*t)\"\ndirection = \"rising\"\n[initial]\nx = 0.1\nv = 0\n";
    let model = with(text, &[]);
    all_come_back(&model, "om", (1.5, 1.7));
    let found = over(&model, "om", (1.5, 1.7), (40, 0.005));
    let [touch] = &found[0].special[..] else {
        panic!("{:?}", found[0].special)
    };
    // The linear oscillator's amplitude is 0.3 there: (1 - w^2)^2 + (0.2 w)^2 = (0.5/0.3)^2.
    let (b, c) = (2.0 - 0.04, 1.0 - 25.0 / 9.0_f64);
    let expected = (0.5 * (b + (b * b - 4.0 * c).sqrt())).sqrt();
    assert_eq!(touch.kind, SpecialKind::Touch);
    assert!((value(touch) - expected).abs() < 1e-12, "{}", value(touch));
}

#[test]
fn orbits_that_stop_are_orbits_on_both_sides_of_where_stops_begin() {
    for start in ["0.45", "0.55"] {
        let mut oscillator = model("forced_coulomb_oscillator", &[]);
        oscillator.set_parameter("omega", start).unwrap();
        all_come_back(&oscillator, "omega", (0.44, 0.56));
    }
}
