//! The predicted windows beside those of the system itself: arcs of its periodic orbits, between fold and graze.

use super::super::normal_form::exact::SectionChart;
use super::map::Prediction;
use super::simulated::Simulator;
use super::windows::PredictedWindow;
use crate::analysis::periodic;
use crate::analysis::periodic::arc::{ArcEnd, ArcEnds, DOUBLING, FOLD, arc_ends};
use crate::analysis::periodic::shooting::Workshop;
use crate::numerics::{Estimate, last_where, moved};
use core::ops::ControlFlow;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// What is known of the ends of a window.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct WindowEnds<T> {
    /// Where the multiplier is 1.
    pub fold: Option<T>,
    /// Where it is -1.
    pub period_doubling: Option<T>,
    /// Where the last impact grazes.
    pub grazing: Option<T>,
}

impl<T: Copy> WindowEnds<T> {
    /// Fold, period doubling and graze.
    pub fn ends(&self) -> [Option<T>; 3] {
        [self.fold, self.period_doubling, self.grazing]
    }
}

impl<T> From<[Option<T>; 3]> for WindowEnds<T> {
    fn from([fold, period_doubling, grazing]: [Option<T>; 3]) -> Self {
        Self {
            fold,
            period_doubling,
            grazing,
        }
    }
}

/// A window of the system: parameter values.
pub type LocatedWindow = WindowEnds<Estimate<f64>>;

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

/// Orbits are no farther from where they are looked for, in parts of how far that is from the border.
const NEAR: f64 = 5.0;

/// A window must lie so many roundoffs from the border, and no window beyond this one is looked at.
const RESOLVED: f64 = 1e7;
const LAST_LAP: i64 = 1 << 20;

impl WindowComparison {
    /// Relative differences, for a border at the parameter value `border`.
    pub fn discrepancy(&self, border: f64) -> Discrepancy {
        let (found, predicted) = (self.located.ends(), self.predicted.ends());
        let off = |end: usize| {
            let (found, predicted) = (found[end]?.value, predicted[end]?.parameter);
            Some((predicted - found) / (found - border))
        };
        [0, 1, 2].map(off).into()
    }
}

/// A window of the system with the prediction that led to it.
struct Found {
    compared: WindowComparison,
    ends: ArcEnds,
}

impl Simulator {
    /// Compares the windows of laps `first` to `last`, as far as they are found: those that doubles do not tell from the
    /// border are left out. The prediction improves with n, so what is not found from it alone is looked for from the next
    /// window, whose offset from its prediction helps to find it.
    pub fn compare(&self, prediction: &Prediction, first: i64, last: i64) -> Vec<WindowComparison> {
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
        (first, last): (i64, i64),
        observer: &mut dyn FnMut(f64) -> ControlFlow<()>,
    ) -> Option<Vec<WindowComparison>> {
        let arcs = Arcs::new(self, prediction);
        let resolved = arcs.and_then(|arcs| Some((arcs.last_resolved()?, arcs)));
        let Some((nearest, arcs)) = resolved else {
            return Some(Vec::new());
        };
        let last = last.min(nearest);
        let span = (last - first).max(1) as f64;
        let mut windows = Vec::new();
        // Beyond the last one asked for, if need be, is where to begin; from there on to the first.
        let (mut lap, mut next) = (last, None::<Found>);
        loop {
            let done = next.as_ref().map_or(0, |_| (last - lap - 1).max(0));
            observer(done as f64 / span).is_continue().then_some(())?;
            let predicted = prediction.window(lap);
            let beside = (next.as_ref()).and_then(|next| arcs.locate_beside(predicted, next));
            match beside.or_else(|| arcs.locate(predicted, None)) {
                Some(found) => {
                    if (first..=last).contains(&lap) {
                        windows.push(found.compared);
                    }
                    next = Some(found);
                    lap -= 1;
                }
                None if next.is_none() && lap < nearest => lap += 1,
                // Farther from the border than a window that is not found nothing but other orbits would be.
                None => break,
            }
            if next.is_some() && lap < first {
                break;
            }
        }
        windows.reverse();
        Some(windows)
    }
}

/// Where arcs of periodic orbits are looked for.
struct Arcs<'a> {
    simulator: &'a Simulator,
    prediction: &'a Prediction,
    workshop: Arc<Workshop>,
    /// The states that tell orbits just after their first impact, at the border.
    chart: SectionChart<f64>,
}

impl<'a> Arcs<'a> {
    /// None where the system has no periodic orbits that can be followed.
    fn new(simulator: &'a Simulator, prediction: &'a Prediction) -> Option<Self> {
        let problem = &simulator.problem;
        let here = problem.at(prediction.border).ok()?;
        let (contact, state) = (simulator.release.contact, &prediction.states.origin);
        let free = (&[problem.parameter][..], &[size(prediction)][..]);
        Some(Self {
            simulator,
            prediction,
            workshop: periodic::workshop(&problem.model, &periodic::Spec::default(), free).ok()?,
            chart: SectionChart::new(&here, contact, state),
        })
    }

    /// The last lap whose window doubles tell from the border, in the parameter and in the states: windows come nearer to it from
    /// lap to lap.
    fn last_resolved(&self) -> Option<i64> {
        let least = RESOLVED * f64::EPSILON;
        let Prediction { border, states, .. } = self.prediction;
        let is_resolved = |lap: i64| {
            let graze = self.prediction.window(lap).grazing;
            let distance = graze.parameter - border;
            let state = states.at(graze.z, distance);
            let moved =
                |i: usize| (state[i] - states.origin[i]).abs() > least * states.origin[i].abs();
            distance.abs() > least * border.abs() && self.chart.free.iter().copied().any(moved)
        };
        is_resolved(0).then(|| last_where(0, LAST_LAP, is_resolved))
    }

    /// State and parameter of a predicted point.
    fn expected(&self, z: f64, parameter: f64) -> Vec<f64> {
        let distance = parameter - self.prediction.border;
        [self.prediction.states.at(z, distance), vec![parameter]].concat()
    }

    /// Locates the window of the orbit with as many impacts as predicted, starting at this offset from predicted orbits.
    /// `None` where the orbit is not found.
    fn locate(&self, predicted: PredictedWindow, offset: Option<&[f64]>) -> Option<Found> {
        let (begin, end) = (predicted.superstable.x, predicted.grazing.x);
        STARTS.into_iter().find_map(|share| {
            let x = begin + (end - begin) * share;
            let z = self.prediction.universal().value(x);
            let parameter = self.prediction.parameter(x - self.prediction.slope * z);
            let start = self.expected(z, parameter);
            let start = offset.map_or(start.clone(), |offset| moved(&start, offset, 1.0));
            self.window(predicted, &start)
        })
    }

    /// Locates the window of a lap, starting at what the next lap's ends are off by.
    fn locate_beside(&self, predicted: PredictedWindow, next: &Found) -> Option<Found> {
        // What the prediction leaves out is quadratic in x, which goes like eta^n.
        let eta = self.prediction.universal().constants().eta;
        let (known, here) = (next.compared.predicted.ends(), predicted.ends());
        let starts = [DOUBLING, FOLD].into_iter().filter_map(|end| {
            let ArcEnd { state, parameter } = next.ends[end].as_ref()?;
            let [known, here] =
                [known[end]?, here[end]?].map(|point| self.expected(point.z, point.parameter));
            let there = self.simulator.problem.at(parameter.value).ok()?;
            let (mut off, _) = there.apart(&known[..state.len()], state);
            off.push(parameter.value - known[state.len()]);
            let offset: Vec<f64> = off.iter().map(|off| off / (eta * eta)).collect();
            Some((moved(&here, &offset, 1.0), offset))
        });
        let starts: Vec<(Vec<f64>, Vec<f64>)> = starts.collect();
        let mut all = starts.iter();
        let found = all.find_map(|(start, _)| self.window(predicted, start));
        found.or_else(|| self.locate(predicted, Some(&starts.first()?.1)))
    }

    /// The window of the orbit with n + 1 impacts in a loop near a state at a value of the parameter, if it has an end.
    fn window(&self, predicted: PredictedWindow, start: &[f64]) -> Option<Found> {
        let (&value, state) = start.split_last()?;
        let contact = self.simulator.release.contact;
        let here = self.simulator.problem.at(value).ok()?;
        let state = here.onto_surface(contact, state, self.chart.bound)?;
        let impacts = (contact, predicted.lap as usize + 1);
        let slack = NEAR * (value - self.prediction.border).abs();
        let ends = arc_ends(&self.workshop, (&state, value, slack), impacts).ok()?;
        let located: LocatedWindow = ends
            .each_ref()
            .map(|end| Some(end.as_ref()?.parameter))
            .into();
        (ends.iter().any(Option::is_some)).then_some(Found {
            compared: WindowComparison { predicted, located },
            ends,
        })
    }
}

/// The size of the parameter that arcs are measured by, against its value: mostly by states, which go on where the parameter turns.
const SIZE: f64 = 10.0;

/// What a change of the parameter is small against.
fn size(prediction: &Prediction) -> f64 {
    match prediction.border {
        0.0 => SIZE,
        border => SIZE * border.abs(),
    }
}
