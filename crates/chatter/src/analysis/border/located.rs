//! The predicted windows beside those of the system itself.

use super::exact::SectionChart;
use super::extrapolate::Estimate;
use super::prediction::Prediction;
use super::return_map::ReturnMap;
use super::simulated::Simulator;
use super::window_curve::LocatedWindow;
use super::windows::{PredictedPoint, PredictedWindow};
use serde::{Deserialize, Serialize};

/// Predicted against found, for one number of impacts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct WindowComparison {
    /// From the one-dimensional map.
    pub predicted: PredictedWindow,
    /// In the system.
    pub located: LocatedWindow,
}

/// By how much the predicted parameter values miss those of the system, as parts of the latter's distance from the border.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Discrepancy {
    /// Of the fold.
    pub fold: Option<f64>,
    /// Of the period doubling.
    pub period_doubling: Option<f64>,
    /// Of the graze.
    pub grazing: Option<f64>,
}

/// If nothing is found at the last lap asked for, the search begins so many laps nearer to the border, at most.
const MORE_LAPS: u32 = 12;

/// Where on the predicted orbits Newton's method starts, from the superstable one, 0, to the graze, 1: where n is small a
/// predicted orbit near the end of its lap may have one impact more.
const STARTS: [f64; 4] = [0.0, 0.25, 0.5, 0.75];

/// A window must lie so many roundoffs from the border.
const RESOLVED: f64 = 1e7;

/// From a predicted orbit to the one found: of its state, at the same parameter value, and of its parameter value.
#[derive(Clone, Debug)]
struct Offset {
    state: [f64; 2],
    parameter: f64,
}

impl Offset {
    const NONE: Self = Self {
        state: [0.0; 2],
        parameter: 0.0,
    };

    fn times(&self, factor: f64) -> Self {
        Self {
            state: self.state.map(|off| off * factor),
            parameter: self.parameter * factor,
        }
    }
}

impl WindowComparison {
    /// Relative differences, for a border at the parameter value `border`.
    pub fn discrepancy(&self, border: f64) -> Discrepancy {
        let located = self.located;
        let off = |found: Option<Estimate<f64>>, predicted: Option<PredictedPoint>| {
            let (found, predicted) = (found?.value, predicted?.parameter);
            Some((predicted - found) / (found - border))
        };
        Discrepancy {
            fold: off(located.fold, self.predicted.fold),
            period_doubling: off(located.period_doubling, self.predicted.period_doubling),
            grazing: off(located.grazing, Some(self.predicted.grazing)),
        }
    }

    /// From the predicted parameter value to that of the system.
    fn offset(&self) -> Option<f64> {
        let located = self.located;
        let off = |found: Option<Estimate<f64>>, predicted: Option<PredictedPoint>| {
            Some(found?.value - predicted?.parameter)
        };
        off(located.fold, self.predicted.fold)
            .or_else(|| off(located.period_doubling, self.predicted.period_doubling))
            .or_else(|| off(located.grazing, Some(self.predicted.grazing)))
    }
}

impl Simulator {
    /// Compares the windows of laps `first` to `last`, as far as they are found. The prediction improves with n, so they are
    /// located from the latter downwards, or from a lap beyond it if nothing is found there, until one is not found; what
    /// the prediction was off by at one lap helps to find the next. Those that doubles do not tell from the border are left
    /// out.
    pub fn compare(&self, prediction: &Prediction, first: u32, last: u32) -> Vec<WindowComparison> {
        let alone = |lap: u32| self.locate(prediction, &prediction.window(lap), &Offset::NONE);
        let Some(nearest) = last_resolved(prediction, first, last) else {
            return Vec::new();
        };
        let mut start = nearest;
        let mut found = alone(start);
        while found.is_none() && start < nearest.saturating_add(MORE_LAPS) {
            start += 1;
            found = alone(start);
        }
        // What the prediction leaves out is quadratic in x, which goes like lambda^n.
        let lambda = prediction.universal().constants().lambda;
        let growth = 1.0 / (lambda * lambda);
        let mut windows = Vec::new();
        for lap in (first..=start).rev() {
            let predicted = prediction.window(lap);
            if lap < start
                && let Some((_, offset)) = &found
            {
                found = (self.locate(prediction, &predicted, &offset.times(growth)))
                    .or_else(|| alone(lap));
            }
            let Some((located, offset)) = &mut found else {
                break;
            };
            let located = *located;
            let window = WindowComparison { predicted, located };
            if let Some(parameter) = window.offset() {
                offset.parameter = parameter;
            }
            if lap <= last {
                windows.push(window);
            }
        }
        windows.reverse();
        windows
    }

    /// Locates the window of the orbit with as many impacts as predicted, starting at an offset from the prediction. `None`
    /// where the orbit is not found.
    fn locate(
        &self,
        prediction: &Prediction,
        predicted: &PredictedWindow,
        offset: &Offset,
    ) -> Option<(LocatedWindow, Offset)> {
        let (begin, end) = (predicted.superstable.x, predicted.grazing.x);
        STARTS.into_iter().find_map(|share| {
            let x = begin + (end - begin) * share;
            let z = prediction.universal().value(x);
            let parameter = prediction.parameter(x - prediction.slope * z) + offset.parameter;
            let state = prediction.states.at(z, parameter - prediction.border);
            let parameters = self.problem.parameters(parameter);
            let chart = SectionChart::new(&self.problem, &parameters, &prediction.states.origin);
            let map = ReturnMap {
                simulator: self,
                border: prediction.border,
                origin: prediction.states.origin.clone(),
                free: [chart.free[0], chart.free[1]],
                bound: chart.bound,
                impacts: predicted.lap as usize + 1,
            };
            let expected = map.free.map(|i| state[i]);
            let guess = [
                expected[0] + offset.state[0],
                expected[1] + offset.state[1],
                parameter,
            ];
            let middle = map.solve(guess, None)?;
            let window = map.window(middle);
            let state = [0, 1].map(|i| middle.at[i] - expected[i]);
            let parameter = offset.parameter;
            (window != LocatedWindow::default()).then_some((window, Offset { state, parameter }))
        })
    }
}

/// The last of these laps whose window doubles tell from the border, in the parameter and in the states: windows come
/// nearer to it from lap to lap.
fn last_resolved(prediction: &Prediction, first: u32, last: u32) -> Option<u32> {
    let least = RESOLVED * f64::EPSILON;
    let border = prediction.border;
    let origin = &prediction.states.origin;
    let is_resolved = |lap: u32| {
        let graze = prediction.window(lap).grazing;
        let distance = graze.parameter - border;
        let state = prediction.states.at(graze.z, distance);
        distance.abs() > least * border.abs()
            && (state.iter().zip(origin)).any(|(x, start)| (x - start).abs() > least * start.abs())
    };
    if is_resolved(last) {
        return Some(last);
    }
    let (mut resolved, mut lost) = (is_resolved(first).then_some(first)?, last);
    while lost - resolved > 1 {
        let middle = resolved + (lost - resolved) / 2;
        if is_resolved(middle) {
            resolved = middle;
        } else {
            lost = middle;
        }
    }
    Some(resolved)
}
