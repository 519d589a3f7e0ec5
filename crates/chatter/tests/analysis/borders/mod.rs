//! Border orbits and their normal forms.

mod border;
mod border_errors;
mod border_search;
mod more_states;

use chatter::analysis::border::WindowComparison;

/// Windows come nearer to the prediction from each to the next, and in the end to a five hundredth.
fn approach_the_prediction(windows: &[WindowComparison], border: f64) {
    let mut before = f64::INFINITY;
    for window in windows {
        let now = window.discrepancy(border);
        let largest = [now.fold, now.period_doubling, now.grazing]
            .map(|off| off.unwrap().abs())
            .into_iter()
            .fold(0.0, f64::max);
        assert!(largest < 0.95 * before, "{window:?}");
        before = largest;
    }
    assert!(before < 2e-3);
}
