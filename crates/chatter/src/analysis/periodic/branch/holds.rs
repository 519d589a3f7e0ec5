//! Whether the sequence of events still holds along a solution of its equations.

use crate::analysis::continuation::{Left, Problem};
use crate::analysis::periodic::shooting::Shooting;
use crate::flow::GuardKind;
use crate::flow::leg::Least;

/// The guard whose sign says that the sequence no longer holds, and its value.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Broken {
    /// The event at the end of this step is approached from the wrong side.
    Event(usize),
    /// This guard has a negative least value within this step.
    Inner(usize, GuardKind),
    /// This guard vanishes before the end of this step.
    Early(usize, GuardKind),
}

impl Broken {
    /// Positive while the sequence holds.
    pub(super) fn value(&self, shooting: &Shooting<f64>, least: &[Vec<Least>]) -> Option<f64> {
        let smallest = |step: usize, guard: GuardKind, at_end: bool| {
            (least.get(step)?.iter())
                .filter(|l| l.guard == guard && l.at_end == at_end)
                .map(|l| l.value)
                .min_by(f64::total_cmp)
        };
        match *self {
            Self::Event(step) => Some(-shooting.latest.get(step)?.surface_rate),
            Self::Inner(step, guard) => smallest(step, guard, false),
            Self::Early(step, guard) => smallest(step, guard, true),
        }
    }
}

/// A guard that has just opened is known to rounding only: below so much of nothing it says nothing.
const NOTHING: f64 = -1e-13;

pub(super) fn broken(shooting: &Shooting<f64>, least: &[Vec<Least>]) -> Vec<Broken> {
    let mut found = Vec::new();
    for (index, step) in shooting.steps.iter().enumerate() {
        let Some(landing) = shooting.latest.get(index) else {
            continue;
        };
        if let Some(guard) = step.ends_at()
            && !step.is_stretch()
            && !matches!(guard, GuardKind::Section(_))
            && landing.surface_rate > 0.0
        {
            found.push(Broken::Event(index));
        }
        for least in least.get(index).into_iter().flatten() {
            let known = match (least.at_end, least.value < 0.0) {
                (_, false) => continue,
                (false, true) => Broken::Inner(index, least.guard),
                // What vanishes with the event itself is left to the next step.
                (true, true) if least.value < NOTHING => Broken::Early(index, least.guard),
                (true, true) => continue,
            };
            if !found.contains(&known) {
                found.push(known);
            }
        }
    }
    found
}

/// Whether an orbit's equations are solved by what is no motion: through a wall, or with events in another order.
pub(crate) fn is_broken(shooting: &mut Shooting<f64>, at: &[f64]) -> Result<bool, Left> {
    shooting.evaluate(at)?;
    let least = shooting.least(at)?;
    Ok(!broken(shooting, &least).is_empty())
}

/// The same but for the step that grazes.
pub(crate) fn broken_at(shooting: &mut Shooting<f64>, at: &[f64], grazing: Option<usize>) -> bool {
    let Ok(least) = shooting.least(at) else {
        return true;
    };
    let graze = |broken: &Broken| match (grazing, broken) {
        (Some(index), Broken::Event(step)) => *step == index,
        // The touch itself, seen from either side of it.
        (Some(index), Broken::Inner(step, _)) => *step == index || *step == index + 1,
        _ => false,
    };
    broken(shooting, &least).iter().any(|broken| !graze(broken))
}
