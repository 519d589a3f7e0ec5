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
