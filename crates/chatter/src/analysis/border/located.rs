//! The predicted windows beside those of the system itself.

use super::error::BorderError;
use super::exact::SectionChart;
use super::extrapolate::Estimate;
use super::prediction::Prediction;
use super::return_map::ReturnMap;
use super::simulated::Simulator;
use super::windows::{PredictedPoint, PredictedWindow};
use serde::{Deserialize, Serialize};

/// A window of the system.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LocatedWindow {
    /// Parameter value where the multiplier is 1.
    pub fold: Option<f64>,
    /// Parameter value where it is -1.
    pub period_doubling: Option<f64>,
    /// Parameter value where the last impact grazes.
    pub grazing: Option<Estimate<f64>>,
}

/// Predicted against found, for one number of impacts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct WindowComparison {
    /// From the one-dimensional map.
    pub predicted: PredictedWindow,
    /// In the system; `None` where the orbit was not found.
    pub located: Option<LocatedWindow>,
}

/// How far the found parameter values lie from the predicted ones, as parts of the predicted distance from the border.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Discrepancy {
    /// Of the fold.
    pub fold: Option<f64>,
    /// Of the period doubling.
    pub period_doubling: Option<f64>,
    /// Of the graze.
    pub grazing: Option<f64>,
}

impl WindowComparison {
    /// Relative differences, for a border at the parameter value `border`.
    pub fn discrepancy(&self, border: f64) -> Discrepancy {
        let Some(located) = self.located else {
            return Discrepancy::default();
        };
        let off = |found: Option<f64>, predicted: Option<PredictedPoint>| {
            let (found, predicted) = (found?, predicted?);
            Some((found - predicted.parameter) / (predicted.parameter - border))
        };
        Discrepancy {
            fold: off(located.fold, self.predicted.fold),
            period_doubling: off(located.period_doubling, self.predicted.period_doubling),
            grazing: off(
                located.grazing.map(|graze| graze.value),
                Some(self.predicted.grazing),
            ),
        }
    }
}

impl Simulator {
    /// Compares the windows of laps `first` to `last`, from the latter downwards since the prediction improves with n; what
    /// one lap was off by helps to find the next.
    ///
    /// # Errors
    /// As for [`locate`](Self::locate).
    pub fn compare(
        &self,
        prediction: &Prediction,
        first: u32,
        last: u32,
    ) -> Result<Vec<WindowComparison>, BorderError> {
        let mut shift = 0.0;
        let mut windows = Vec::new();
        for lap in (first..=last).rev() {
            let predicted = prediction.window(lap);
            let mut located = self.locate(prediction, &predicted, shift)?;
            if located.is_none() && shift != 0.0 {
                located = self.locate(prediction, &predicted, 0.0)?;
            }
            let window = WindowComparison { predicted, located };
            if let Some(fold) = window.discrepancy(prediction.border).fold {
                // Discrepancies shrink like lambda^n.
                shift = fold / prediction.universal().constants().lambda;
            }
            windows.push(window);
        }
        windows.reverse();
        Ok(windows)
    }

    /// Locates the window of the orbit with as many impacts as predicted, starting from the prediction; `shift` moves the
    /// start by this part of its distance from the border. `None` where the orbit is not found.
    ///
    /// # Errors
    /// The release point is lost.
    pub fn locate(
        &self,
        prediction: &Prediction,
        predicted: &PredictedWindow,
        shift: f64,
    ) -> Result<Option<LocatedWindow>, BorderError> {
        let start = predicted.superstable;
        let distance = (start.parameter - prediction.border) * (1.0 + shift);
        let parameter = prediction.border + distance;
        let state = prediction.states.at(start.z, distance);
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
        let guess = [state[chart.free[0]], state[chart.free[1]], parameter];
        let Some(middle) = map.solve(guess, None)? else {
            return Ok(None);
        };
        map.window(middle).map(Some)
    }
}
