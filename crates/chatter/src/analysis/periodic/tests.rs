//! Orbits against reference values in quadruple precision.

use super::*;
use crate::numerics::Real;

fn shipped(text: &str, set: &[(&str, f64)]) -> Model {
    let mut model = Model::from_toml(text, "shipped").unwrap();
    for (name, value) in set {
        model.set_parameter(name, &format!("{value:?}")).unwrap();
    }
    model
}

fn valve(q: f64) -> Model {
    shipped(
        include_str!("../../../../../models/pressure_relief_valve.toml"),
        &[("q", q)],
    )
}

fn found(model: &Model) -> Orbit {
    settled(model, &Spec::default(), &mut |_| ControlFlow::Continue(())).unwrap()
}

#[test]
fn the_valve_at_34_impacts() {
    let orbit = found(&valve(0.0203));
    assert_eq!(orbit.impacts, Some(34));
    assert!((orbit.period.to_f64() - 3.524_824_504_277_329).abs() < 1e-12);
    assert!((orbit.multipliers[0].re + 0.611_967_017_203_215_5).abs() < 1e-11);
    assert!((orbit.multipliers[1].re + 4.763_932_297_860_21e-9).abs() < 1e-19);
    let start: Vec<f64> = orbit.start.iter().map(|x| x.to_f64()).collect();
    assert!(
        (start[0] - 0.027_229_278_685_215_647).abs() < 1e-14,
        "{start:?}"
    );
    assert!((start[1] + 0.006_005_945_816_069_922).abs() < 1e-14);
}

#[test]
fn complete_chatter_forgets_two_directions() {
    let orbit = found(&valve(0.0195));
    assert_eq!(orbit.impacts, None);
    assert!((orbit.period.to_f64() - 3.526_655_749_659_584).abs() < 1e-12);
    assert!(orbit.multipliers.iter().all(|m| m.modulus() == 0.0));
}

/// A valve behind a line in chaos, where nothing marks a period: the equations of a return after hundreds of impacts took ten seconds each.
#[test]
fn loops_of_chaos_are_short() {
    let text = "[flight]\ny1 = \"y2\"\ny2 = \"-1.25*y2 - y1 - 10 + y5\"\ny3 = \"20*(1.5 - y4)\"\n\
                y4 = \"20*(y3 - y5)\"\ny5 = \"20*(y4 - y1*sqrt(y5))\"\n\
                [[contact]]\nname = \"seat\"\ngap = \"y1\"\nimpulse = { y2 = 1 }\nrestitution = 0.8\n\
                [initial]\ny1 = 0.3\ny2 = 0\ny3 = 10\ny4 = 0.5\ny5 = 10\n";
    let model = Model::from_toml(text, "valve").unwrap();
    let workshop = workshop(&model, &Spec::default(), (&[], &[])).unwrap();
    let state = model.initial_state(&model.parameter_values::<f64>(&[]));
    let loops = cycle::settle::loops::loops(&workshop, &[], &state, (9, 2)).unwrap();
    assert_eq!(loops.cycles.len(), 2);
    let legs = loops.cycles.iter().map(|cycle| cycle.steps.len());
    assert!(
        legs.clone().all(|legs| legs <= 240),
        "{:?}",
        legs.collect::<Vec<_>>()
    );
}
