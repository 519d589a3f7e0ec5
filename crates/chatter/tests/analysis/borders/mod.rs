//! Border orbits and their normal forms.

mod border;
mod border_errors;
mod border_search;
mod corners;
mod more_states;
mod unfollowed;

use chatter::analysis::border::{
    PredictedPassage, Prediction, Simulator, Verdict, WindowComparison,
};

/// What an orbit repeats with.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Settled {
    /// After so many passages with so many impacts in all.
    Periodic { passages: usize, impacts: u64 },
    /// Each passage is a complete chatter sequence.
    Complete,
    /// It does not repeat within what was followed.
    Unsettled,
}

/// Periods up to this are recognised.
const LONGEST_PERIOD: usize = 64;
/// Two passages are the same if they agree to this, relative to their size.
const SAME: f64 = 1e-9;

/// The shortest period of passages with their impacts and coordinates.
fn settled(passages: &[(u64, Vec<f64>)]) -> Settled {
    let size = |i: usize| {
        passages
            .iter()
            .fold(0.0_f64, |most, (_, at)| most.max(at[i].abs()))
    };
    let same = |a: &(u64, Vec<f64>), b: &(u64, Vec<f64>)| {
        let near = |i: usize| (a.1[i] - b.1[i]).abs() <= SAME * size(i);
        a.0 == b.0 && (0..a.1.len()).all(near)
    };
    let repeats = |&period: &usize| {
        passages.len() >= 2 * period
            && (passages.iter().zip(&passages[period..])).all(|(a, b)| same(a, b))
    };
    match (1..=LONGEST_PERIOD).find(repeats) {
        Some(passages_a_period) => Settled::Periodic {
            passages: passages_a_period,
            impacts: passages[..passages_a_period].iter().map(|(n, _)| n).sum(),
        },
        None => Settled::Unsettled,
    }
}

/// What predicted orbits settle to.
fn predicted(prediction: &Prediction, parameter: f64) -> Settled {
    let orbit = prediction.orbit(parameter, 4000, 2 * LONGEST_PERIOD);
    let counted = |passage: &PredictedPassage| Some((passage.impacts?, vec![passage.x]));
    match orbit.iter().map(counted).collect::<Option<Vec<_>>>() {
        Some(passages) => settled(&passages),
        None if orbit.iter().all(|passage| passage.impacts.is_none()) => Settled::Complete,
        None => Settled::Unsettled,
    }
}

/// What those of the flow settle to, told by some of the states.
fn simulated(
    (simulator, states): (&Simulator, &[usize]),
    parameter: f64,
    transient: usize,
    keep: usize,
) -> Settled {
    let orbit = simulator.orbit(parameter, transient, keep).unwrap();
    match orbit.verdict {
        Verdict::Stopped => {
            let at = |state: &[f64]| states.iter().map(|&i| state[i]).collect();
            let passages = orbit.passages.iter().map(|p| (p.impacts, at(&p.state)));
            settled(&passages.collect::<Vec<_>>())
        }
        Verdict::Complete => Settled::Complete,
        _ => Settled::Unsettled,
    }
}

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
