//! The predicted windows beside those of the system itself.

use super::super::normal_form::exact::SectionChart;
use super::map::Prediction;
use super::return_map::{FixedPoint, ReturnMap};
use super::simulated::Simulator;
use super::window_curve::{LocatedWindow, WindowEnds};
use super::windows::{PredictedPoint, PredictedWindow};
use crate::numerics::{Estimate, moved};
use core::ops::ControlFlow;
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
pub type Discrepancy = WindowEnds<f64>;

/// Where on the predicted orbits Newton's method starts, from the superstable one, 0, to the graze, 1: where n is small a
/// predicted orbit near the end of its lap may have one impact more.
const STARTS: [f64; 4] = [0.0, 0.25, 0.5, 0.75];

/// A window must lie so many roundoffs from the border.
const RESOLVED: f64 = 1e7;

impl WindowComparison {
    /// Relative differences, for a border at the parameter value `border`.
    pub fn discrepancy(&self, border: f64) -> Discrepancy {
        let located = self.located;
        let off = |found: Option<Estimate<f64>>, predicted: Option<PredictedPoint>| {
            let (found, predicted) = (found?.value, predicted?.parameter);
            Some((predicted - found) / (found - border))
        };
        WindowEnds {
            fold: off(located.fold, self.predicted.fold),
            period_doubling: off(located.period_doubling, self.predicted.period_doubling),
            grazing: off(located.grazing, Some(self.predicted.grazing)),
        }
    }
}

/// A window of the system with the prediction that led to it.
#[derive(Clone)]
struct Found {
    predicted: PredictedWindow,
    located: LocatedWindow,
    /// Period doubling and fold.
    ends: [Option<FixedPoint>; 2],
}

impl Simulator {
    /// Compares the windows of laps `first` to `last`, as far as they are found: those that doubles do not tell from the
    /// border are left out. The prediction improves with n, so what is not found from it alone is looked for from the next
    /// window, whose offset from its prediction helps to find it.
    pub fn compare(&self, prediction: &Prediction, first: u32, last: u32) -> Vec<WindowComparison> {
        let compared =
            self.compare_until(
                prediction,
                (first, last),
                &mut |_| ControlFlow::Continue(()),
            );
        compared.unwrap_or_default()
    }

    /// As [`compare`](Self::compare); the observer hears how much is done, of one, and may break off: then there is nothing.
    pub fn compare_until(
        &self,
        prediction: &Prediction,
        (first, last): (u32, u32),
        observer: &mut dyn FnMut(f64) -> ControlFlow<()>,
    ) -> Option<Vec<WindowComparison>> {
        let map = self.return_map(prediction);
        let Some(nearest) = last_resolved(prediction, &map.free) else {
            return Some(Vec::new());
        };
        let last = last.min(nearest);
        let alone = |predicted: PredictedWindow| {
            map.locate(prediction, predicted, &vec![0.0; map.free.len() + 1])
        };
        // Beyond the last one asked for, if need be, is where to begin.
        let mut begin = None;
        for lap in last..=nearest {
            observer(0.0).is_continue().then_some(())?;
            begin = alone(prediction.window(lap));
            if begin.is_some() {
                break;
            }
        }
        let mut stopped = false;
        let span = f64::from(last.saturating_sub(first).max(1));
        // Farther from the border than a window that is not found nothing but other orbits would be.
        let found = core::iter::successors(begin, |next| {
            let lap = next.predicted.lap;
            stopped = observer(f64::from(last.saturating_sub(lap)) / span).is_break();
            if stopped {
                return None;
            }
            let predicted = prediction.window((lap > first).then(|| lap - 1)?);
            (map.locate_beside(prediction, predicted, next)).or_else(|| alone(predicted))
        });
        let mut windows: Vec<WindowComparison> = found
            .filter(|found| (first..=last).contains(&found.predicted.lap))
            .map(|found| WindowComparison {
                predicted: found.predicted,
                located: found.located,
            })
            .collect();
        windows.reverse();
        (!stopped).then_some(windows)
    }

    fn return_map<'a>(&'a self, prediction: &'a Prediction) -> ReturnMap<'a> {
        let origin = &prediction.states.origin;
        let parameters = self.problem.parameters(prediction.border);
        let contact = self.equations().contact;
        let chart = SectionChart::new(&self.problem, contact, &parameters, origin);
        ReturnMap {
            simulator: self,
            border: prediction.border,
            origin,
            free: chart.free,
            bound: chart.bound,
            impacts: 0,
        }
    }
}

impl ReturnMap<'_> {
    /// The coordinates and the parameter of a predicted point.
    fn expected(&self, prediction: &Prediction, z: f64, parameter: f64) -> Vec<f64> {
        let state = prediction.states.at(z, parameter - prediction.border);
        (self.free.iter().map(|&i| state[i]))
            .chain([parameter])
            .collect()
    }

    /// Locates the window of the orbit with as many impacts as predicted, starting at this offset from predicted orbits.
    /// `None` where the orbit is not found.
    fn locate(
        &self,
        prediction: &Prediction,
        predicted: PredictedWindow,
        offset: &[f64],
    ) -> Option<Found> {
        let (begin, end) = (predicted.superstable.x, predicted.grazing.x);
        STARTS.into_iter().find_map(|share| {
            let x = begin + (end - begin) * share;
            let z = prediction.universal().value(x);
            let parameter = prediction.parameter(x - prediction.slope * z);
            let start = self.expected(prediction, z, parameter);
            self.window_from(predicted, &moved(&start, offset, 1.0), None)
        })
    }

    /// Locates the window of a lap, starting at what the next lap's ends are off by.
    fn locate_beside(
        &self,
        prediction: &Prediction,
        predicted: PredictedWindow,
        next: &Found,
    ) -> Option<Found> {
        // What the prediction leaves out is quadratic in x, which goes like eta^n; rates go like the square of the time to
        // release, which goes like lambda^n.
        let constants = prediction.universal().constants();
        let growth = 1.0 / (constants.eta * constants.eta);
        let faster = 1.0 / (constants.lambda * constants.lambda);
        let pairs = [
            (next.predicted.period_doubling, predicted.period_doubling),
            (next.predicted.fold, predicted.fold),
        ];
        let starts = next
            .ends
            .iter()
            .zip(pairs)
            .filter_map(|(found, (known, here))| {
                let (found, known, here) = (found.as_ref()?, known?, here?);
                let [known, here] =
                    [known, here].map(|point| self.expected(prediction, point.z, point.parameter));
                let off = moved(&found.at, &known, -1.0);
                let offset: Vec<f64> = off.iter().map(|off| off * growth).collect();
                Some((moved(&here, &offset, 1.0), offset, found.rate * faster))
            });
        let mut starts = starts.collect::<Vec<_>>().into_iter().peekable();
        let first = starts.peek().map(|(_, offset, _)| offset.clone());
        starts
            .find_map(|(start, _, rate)| self.window_from(predicted, &start, Some(rate)))
            .or_else(|| self.locate(prediction, predicted, &first?))
    }

    /// The window of the orbit with n + 1 impacts in a loop near a guess, if it has an end.
    fn window_from(
        &self,
        predicted: PredictedWindow,
        guess: &[f64],
        rate: Option<f64>,
    ) -> Option<Found> {
        let map = Self {
            impacts: predicted.lap as usize + 1,
            ..self.clone()
        };
        let (located, ends) = map.window(map.solve(guess, rate)?);
        let found = Found {
            predicted,
            located,
            ends,
        };
        (located.ends().iter().any(Option::is_some)).then_some(found)
    }
}

/// No window beyond this one is looked at.
const LAST_LAP: u32 = 1 << 20;

/// The last lap whose window doubles tell from the border, in the parameter and in these states: windows come nearer to it
/// from lap to lap.
fn last_resolved(prediction: &Prediction, free: &[usize]) -> Option<u32> {
    let least = RESOLVED * f64::EPSILON;
    let border = prediction.border;
    let origin = &prediction.states.origin;
    let is_resolved = |lap: u32| {
        let graze = prediction.window(lap).grazing;
        let distance = graze.parameter - border;
        let state = prediction.states.at(graze.z, distance);
        let moved = |i: usize| (state[i] - origin[i]).abs() > least * origin[i].abs();
        distance.abs() > least * border.abs() && free.iter().copied().any(moved)
    };
    let (mut resolved, mut lost) = (is_resolved(0).then_some(0)?, LAST_LAP);
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
