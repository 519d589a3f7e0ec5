//! All borders of a range of the parameter, stretch by stretch.

use super::super::coordinate::root::Root;
use super::super::error::{BorderError, Break};
use super::super::orbit::{Border, complete};
use super::super::problem::Problem;
use super::super::spec::BorderSpec;
use super::closing_in::Found;
use super::samples::Sample;
use crate::model::Model;
use crate::numerics::Real;
use core::ops::ControlFlow;
use serde::{Deserialize, Serialize};

/// All borders of a range.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Borders<R> {
    /// In the order of the parameter.
    pub borders: Vec<Border<R>>,
    /// Where complete chatter ends without a border.
    pub breaks: Vec<Break>,
    /// Changes between complete and incomplete chatter that were not looked into, since there are very many.
    pub unresolved: usize,
    /// Parameter values at which no chatter follows a release point within the long flights allowed.
    pub without_chatter: usize,
    /// Whether the whole range was searched: the observer did not break off.
    pub is_complete: bool,
}

/// How far a search is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SearchProgress {
    /// The part of it that is done.
    pub done: f64,
    /// Borders found so far.
    pub borders: usize,
}

/// A range of more parts than this is searched in stretches of so many: what is known of a part takes some kilobytes.
const STRETCH: usize = 1024;

/// The verdicts of a stretch are so much of the work there; the rest is closing in on borders.
const VERDICTS: f64 = 0.5;

/// All borders with the parameter from `low` to `high`: none is an answer, not an error.
///
/// # Errors
/// The question does not fit the model, or nothing can be said at any parameter value.
pub fn borders_in<R: Real>(
    model: &Model,
    spec: &BorderSpec,
    low: f64,
    high: f64,
) -> Result<Borders<R>, BorderError> {
    let mut goes_on = |_: &SearchProgress| ControlFlow::Continue(());
    search_range(model, spec, (low, high), &mut goes_on)
}

/// Like [`borders_in`], with an observer that hears of progress and may break off; what was found before is kept.
///
/// # Errors
/// As for [`borders_in`].
pub fn search_range<R: Real>(
    model: &Model,
    spec: &BorderSpec,
    (low, high): (f64, f64),
    observer: &mut dyn FnMut(&SearchProgress) -> ControlFlow<()>,
) -> Result<Borders<R>, BorderError> {
    if !(low < high && low.is_finite() && high.is_finite()) {
        return Err(BorderError::Range { low, high });
    }
    let mut search: RangeSearch<'_, R> = RangeSearch {
        problem: Problem::new(model, spec)?,
        spec,
        low,
        high,
        found: Found::default(),
        roots: Vec::new(),
        borders: Vec::new(),
        refused: Vec::new(),
        without_chatter: 0,
        observer,
    };
    let (mut failure, mut is_known, mut is_complete) = (None, false, true);
    let parts = search.parts();
    for first in (0..parts).step_by(STRETCH) {
        let last = first.saturating_add(STRETCH).min(parts);
        match search.stretch(first, last) {
            Ok(ControlFlow::Continue(())) => is_known = true,
            Ok(ControlFlow::Break(())) => {
                is_complete = false;
                break;
            }
            Err(error) => {
                failure.get_or_insert(error);
            }
        }
    }
    if let Some(error) = failure.filter(|_| !is_known) {
        return Err(error);
    }
    search.found.sort();
    let mut breaks = search.found.breaks;
    breaks.append(&mut search.refused);
    breaks.sort_by(|a, b| a.value.total_cmp(&b.value));
    (search.borders).sort_by(|a, b| a.value.value.to_f64().total_cmp(&b.value.value.to_f64()));
    Ok(Borders {
        borders: search.borders,
        breaks,
        unresolved: search.found.unresolved,
        without_chatter: search.without_chatter,
        is_complete,
    })
}

struct RangeSearch<'a, R> {
    problem: Problem,
    spec: &'a BorderSpec,
    low: f64,
    high: f64,
    found: Found,
    /// The roots that were looked at.
    roots: Vec<Root<f64>>,
    borders: Vec<Border<R>>,
    /// Roots that are no borders.
    refused: Vec<Break>,
    without_chatter: usize,
    observer: &'a mut dyn FnMut(&SearchProgress) -> ControlFlow<()>,
}

impl<R: Real> RangeSearch<'_, R> {
    fn parts(&self) -> usize {
        self.spec.samples.max(1)
    }

    fn value(&self, place: usize) -> f64 {
        self.low + (self.high - self.low) * (place as f64 / self.parts() as f64)
    }

    /// Searches from one value to another.
    fn stretch(&mut self, first: usize, last: usize) -> Result<ControlFlow<()>, BorderError> {
        let parts = self.parts();
        let share = (last - first) as f64 / parts as f64;
        let begun = first as f64 / parts as f64;
        // A value more on either side shows whether a distance is smallest at an end.
        let before = first.saturating_sub(1);
        let values: Vec<f64> = (before..=(last + 1).min(parts))
            .map(|place| self.value(place))
            .collect();
        let count = self.borders.len();
        let (problem, observer) = (&self.problem, &mut *self.observer);
        let samples = problem.scan(&values, &mut |part| {
            observer(&SearchProgress {
                done: begun + share * VERDICTS * part,
                borders: count,
            })
        })?;
        let Some(samples) = samples else {
            return Ok(ControlFlow::Break(()));
        };
        // The value that two stretches share counts once.
        let own = first..last + usize::from(last == parts);
        // Release points of contacts that never chatter are none that orbits come to.
        let alone = self.problem.releases.len() == 1;
        let chatters =
            |branch: &&Vec<Sample>| alone || !branch.iter().all(Sample::is_without_chatter);
        let silent = |place: &usize| {
            let is_silent = |branch: &Vec<Sample>| branch[*place - before].is_without_chatter();
            samples.iter().filter(chatters).any(is_silent)
        };
        self.without_chatter += own.filter(silent).count();
        let within = (self.value(first), self.value(last));
        let problem = self.problem.clone();
        let changes = (problem.changes(&samples, self.spec.extrapolation)).within(within);
        for (place, pair) in changes.pairs().iter().enumerate() {
            changes.look_into(pair, &mut self.found);
            self.complete_roots()?;
            let part = (place + 1) as f64 / changes.pairs().len() as f64;
            let progress = SearchProgress {
                done: begun + share * (VERDICTS + (1.0 - VERDICTS) * part),
                borders: self.borders.len(),
            };
            if (self.observer)(&progress).is_break() {
                return Ok(ControlFlow::Break(()));
            }
        }
        Ok(ControlFlow::Continue(()))
    }

    /// Makes borders of the roots that were found last, each once.
    fn complete_roots(&mut self) -> Result<(), BorderError> {
        for root in core::mem::take(&mut self.found.roots) {
            let value = root.point.value;
            let is_known = self.roots.iter().any(|known| known.is_same(&root));
            if is_known || !(self.low..=self.high).contains(&value) {
                continue;
            }
            match complete(&self.problem, self.spec, &root)? {
                Ok(border) => self.borders.push(border),
                Err(cause) => self.refused.push(Break { value, cause }),
            }
            self.roots.push(root);
        }
        Ok(())
    }
}
