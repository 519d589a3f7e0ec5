//! Surfaces that the motion on one side keeps, as a play operator or a slider without mass does: but for rounding of the numbers that
//! the equations are written with.

use super::run;
use chatter::analysis::simulate::Outcome;
use chatter::numerics::{DoubleDouble, Real};

/// z follows y from where 0.7 x - z reaches 0.02, x being y in another unit of length; before that it falls. After it z' = y = 1 - z...:
/// z'' = 1 - z from z = 0, z' = 0.2 at t = 0.2, y = z'.
fn follows<R: Real>(unit: &str, back: &str) {
    let text = format!(
        "[flight]\nx = \"{back}*y\"\ny = \"1 - z\"\nz = \"if({unit}*x - z - 0.02 >= 0, y, -z)\"\n[initial]\nx = 0\ny = 0\nz = 0\n"
    );
    let run = run::<R>(&text, 20.0);
    assert_eq!(run.outcome, Outcome::Horizon, "{unit}");
    let end = run.state[2].to_f64();
    let (sine, cosine) = 19.8_f64.sin_cos();
    let expected = 1.0 - cosine + 0.2 * sine;
    assert!((end - expected).abs() < 1e-13, "{unit}: {end} {expected}");
}

#[test]
fn a_surface_is_kept_whatever_the_unit_of_what_it_is_a_function_of() {
    for (unit, back) in [
        ("0.7", "1.4285714285714286"),
        ("25.4", "0.03937007874015748"),
        ("0.3048", "3.280839895013123"),
        ("7", "0.14285714285714285"),
        ("47", "0.02127659574468085"),
        ("3", "0.3333333333333333"),
        ("1", "1"),
    ] {
        follows::<f64>(unit, back);
        follows::<DoubleDouble>(unit, back);
    }
}
