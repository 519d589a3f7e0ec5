//! Derivatives of one period by differences of motions in thirty digits, to compare multipliers with.

use chatter::analysis::periodic::Orbit;
use chatter::flow::{Occurrence, Settings, System, Trajectory};
use chatter::model::Model;
use chatter::numerics::{DoubleDouble, Real};

/// Where a state leads in a time, in thirty digits.
fn flown(
    (model, system): (&Model, &System),
    from: &[DoubleDouble],
    clock: usize,
    time: DoubleDouble,
) -> Vec<DoubleDouble> {
    let mut work = system.workspace::<DoubleDouble>(&Settings::default());
    let parameters = model.parameter_values(&[]);
    let mut trajectory =
        Trajectory::start(system, &mut work, &parameters, from[clock], from).unwrap();
    trajectory.set_horizon(from[clock] + time);
    while trajectory.advance_to_horizon(system, &mut work).unwrap() != Some(Occurrence::Horizon) {}
    trajectory.state().to_vec()
}

/// The derivative of one period by differences, from soon after the start, where no contact touches.
pub(super) fn differences(model: &Model, orbit: &Orbit) -> Vec<Vec<f64>> {
    const BY: f64 = 1e-11;
    let system = System::new(model).unwrap();
    let clock = model.time.unwrap();
    let soon = orbit.period * DoubleDouble::from(1e-3);
    let start = flown((model, &system), &orbit.start, clock, soon);
    let moved = |index: usize, by: f64| {
        let mut state = start.clone();
        state[index] += by.into();
        flown((model, &system), &state, clock, orbit.period)
    };
    let columns: Vec<usize> = (0..start.len()).filter(|&index| index != clock).collect();
    (columns.iter())
        .map(|&index| {
            let (up, down) = (moved(index, BY), moved(index, -BY));
            let slope = |&i: &usize| (up[i] - down[i]).to_f64() / (2.0 * BY);
            columns.iter().map(slope).collect()
        })
        .collect()
}

/// Sums of multipliers and of their squares are traces.
pub(super) fn agree(orbit: &Orbit, derivative: &[Vec<f64>]) {
    let n = derivative.len();
    let trace: f64 = (0..n).map(|i| derivative[i][i]).sum();
    let squares = (0..n).flat_map(|i| (0..n).map(move |k| (i, k)));
    let of_square: f64 = squares
        .map(|(i, k)| derivative[i][k] * derivative[k][i])
        .sum();
    let sum: f64 = orbit.multipliers.iter().map(|m| m.re).sum();
    let sum_of_squares: f64 = (orbit.multipliers.iter())
        .map(|m| m.re * m.re - m.im * m.im)
        .sum();
    assert!((sum - trace).abs() < 1e-9, "{sum} {trace}");
    assert!(
        (sum_of_squares - of_square).abs() < 1e-9,
        "{sum_of_squares} {of_square}"
    );
}
