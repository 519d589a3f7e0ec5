//! The border nearest to a value of the parameter, and all borders of a range, stretch by stretch.

use super::super::coordinate::Verdict;
use super::super::coordinate::root::Root;
use super::super::error::{BorderError, Break};
use super::super::orbit::{Border, complete};
use super::super::problem::Problem;
use super::super::spec::BorderSpec;
use super::closing_in::HALVINGS_WITHOUT;
use super::sample::Sample;
use crate::model::Model;
use crate::numerics::Real;
use core::ops::{ControlFlow, Range};
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

/// Hears of progress, and may break the search off.
pub type SearchObserver<'o> = dyn FnMut(&SearchProgress) -> ControlFlow<()> + 'o;

/// A range of more parts than this is searched in stretches of so many: what is known of a part takes some kilobytes.
const STRETCH: usize = 1024;

/// The verdicts of a stretch are so much of the work there; the rest is closing in on borders.
const VERDICTS: f64 = 0.5;

/// Where the verdict changes from sample to sample, as it may where passages before the sequence are chaotic, no more than
/// so many further sequences are followed, or so many in each part if that is more.
const MOST_SAMPLES: usize = 10_000;
const LEAST_SHARE: usize = 200;

/// Breaks this near to each other, relative to the parameter, are told as one.
const SAME_BREAK: f64 = 1e-6;

/// Around a value the distances from it are searched by stretches, each twice as long as the one before, to as much as the value
/// itself; and the parts of each on either side.
const GRADES: u32 = 8;
const GRADE_SAMPLES: usize = 12;

/// Where the value asked for is zero, the last stretch ends here.
const UNIT: f64 = 1.0;

/// Place number k of `parts` + 1 from `low` to `high`.
fn part(low: f64, high: f64, k: usize, parts: usize) -> f64 {
    low + (high - low) * (k as f64 / parts as f64)
}

/// The search in an interval, and what it has found.
pub(super) struct Search<'a, R> {
    pub problem: Problem,
    pub spec: &'a BorderSpec,
    low: f64,
    high: f64,
    observer: &'a mut SearchObserver<'a>,
    /// Sequences that may still be followed to close in on a change of the verdict.
    pub left: usize,
    /// Where only the border nearest to a value is looked for: that value, and how far the nearest is so far.
    nearest: Option<(f64, f64)>,
    /// The roots that were looked at.
    roots: Vec<Root<f64>>,
    /// Roots that are no borders.
    refused: Vec<Break>,
    pub found: Borders<R>,
}

impl<'a, R: Real> Search<'a, R> {
    fn new(
        model: &Model,
        spec: &'a BorderSpec,
        (low, high): (f64, f64),
        observer: &'a mut SearchObserver<'a>,
    ) -> Result<Self, BorderError> {
        if !(low < high && low.is_finite() && high.is_finite()) {
            return Err(BorderError::Range { low, high });
        }
        Ok(Self {
            problem: Problem::new(model, spec)?,
            spec,
            low,
            high,
            observer,
            left: 0,
            nearest: None,
            roots: Vec::new(),
            refused: Vec::new(),
            found: Borders {
                borders: Vec::new(),
                breaks: Vec::new(),
                unresolved: 0,
                without_chatter: 0,
                is_complete: true,
            },
        })
    }

    fn progress(&mut self, done: f64) -> ControlFlow<()> {
        let borders = self.found.borders.len();
        (self.observer)(&SearchProgress { done, borders })
    }

    /// The verdicts at parameter values in order, along each branch of release points; values at which that fails have none. The
    /// error is the first failure, if nothing is known at any value. None if the observer breaks off.
    fn scan(
        &mut self,
        values: &[f64],
        (begun, share): (f64, f64),
    ) -> Result<Option<Vec<Vec<Sample>>>, BorderError> {
        let branches = self.problem.branches(values)?;
        let total = (branches.len() * values.len()) as f64;
        let mut failure = None;
        let mut samples: Vec<Vec<Sample>> = Vec::new();
        for branch in branches {
            let mut along = Vec::with_capacity(values.len());
            for (&value, point) in values.iter().zip(branch) {
                let done = samples.len() * values.len() + along.len();
                if self
                    .progress(begun + share * (done as f64 / total))
                    .is_break()
                {
                    return Ok(None);
                }
                let sample = point.map(|point| self.problem.sample(value, point));
                along.push(sample.map_or(Sample::unknown(value), |sample| {
                    sample.unwrap_or_else(|error| {
                        failure.get_or_insert(error);
                        Sample::unknown(value)
                    })
                }));
            }
            samples.push(along);
        }
        match failure {
            Some(error) if !samples.iter().flatten().any(|at| at.found.is_some()) => Err(error),
            _ => Ok(Some(samples)),
        }
    }

    /// Searches between two of these values, the others of which show whether a distance is smallest there. Those of `own` places count
    /// where there is no chatter.
    fn stretch(
        &mut self,
        values: &[f64],
        within: (f64, f64),
        own: Range<usize>,
        (begun, share): (f64, f64),
    ) -> Result<ControlFlow<()>, BorderError> {
        let Some(samples) = self.scan(values, (begun, share * VERDICTS))? else {
            return Ok(ControlFlow::Break(()));
        };
        // Release points of contacts that never chatter are none that orbits come to.
        let alone = self.problem.releases.len() == 1;
        let chatters =
            |branch: &&Vec<Sample>| alone || !branch.iter().all(Sample::is_without_chatter);
        let silent = |place: &usize| {
            let is_silent = |branch: &Vec<Sample>| branch[*place].is_without_chatter();
            samples.iter().filter(chatters).any(is_silent)
        };
        self.found.without_chatter += own.filter(silent).count();
        let mut changes: Vec<[Sample; 2]> = samples
            .iter()
            .flat_map(|branch| self.pairs(branch))
            .collect();
        changes.retain(|[left, right]| within.0 <= left.value && right.value <= within.1);
        let off =
            |[left, right]: &[Sample; 2], from: f64| (left.value - from).max(from - right.value);
        if let Some((wanted, _)) = self.nearest {
            changes.sort_by(|a, b| off(a, wanted).total_cmp(&off(b, wanted)));
        }
        for (place, change) in changes.iter().enumerate() {
            // No further than where a border is nearer than what is left.
            if (self.nearest).is_some_and(|(wanted, least)| least <= off(change, wanted)) {
                break;
            }
            // None may leave the others without sequences.
            self.left = (MOST_SAMPLES / changes.len()).max(LEAST_SHARE);
            self.close_in(&change[0], &change[1], HALVINGS_WITHOUT)?;
            let closed_in = (place + 1) as f64 / changes.len() as f64;
            let done = begun + share * (VERDICTS + (1.0 - VERDICTS) * closed_in);
            if self.progress(done).is_break() {
                return Ok(ControlFlow::Break(()));
            }
        }
        Ok(ControlFlow::Continue(()))
    }

    /// Makes a border of a root, if none is known that makes it needless.
    pub(super) fn take(&mut self, root: Root<f64>) -> Result<(), BorderError> {
        let value = root.point.value;
        let is_needless = match self.nearest {
            Some((wanted, least)) => least <= (value - wanted).abs(),
            None => self.roots.iter().any(|known| known.is_same(&root)),
        };
        if is_needless || !(self.low..=self.high).contains(&value) {
            return Ok(());
        }
        match (
            complete(&self.problem, self.spec, &root)?,
            &mut self.nearest,
        ) {
            (Ok(border), Some((wanted, least))) => {
                *least = (value - *wanted).abs();
                self.found.borders = vec![border];
            }
            (Ok(border), None) => self.found.borders.push(border),
            (Err(cause), Some(_)) => self.found.breaks.push(Break { value, cause }),
            (Err(cause), None) => self.refused.push(Break { value, cause }),
        }
        self.roots.push(root);
        Ok(())
    }

    /// What was found, in order.
    fn finish(self) -> Borders<R> {
        let mut found = self.found;
        let breaks = &mut found.breaks;
        breaks.sort_by(|a, b| a.value.total_cmp(&b.value));
        breaks.dedup_by(|a, b| a.value - b.value <= SAME_BREAK * a.value.abs());
        breaks.extend(self.refused);
        breaks.sort_by(|a, b| a.value.total_cmp(&b.value));
        let value = |border: &Border<R>| border.value.value.to_f64();
        (found.borders).sort_by(|a, b| value(a).total_cmp(&value(b)));
        found
    }
}

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
    search_range(model, spec, (low, high), &mut |_| ControlFlow::Continue(()))
}

/// Like [`borders_in`], with an observer that hears of progress and may break off; what was found before is kept.
///
/// # Errors
/// As for [`borders_in`].
pub fn search_range<R: Real>(
    model: &Model,
    spec: &BorderSpec,
    range: (f64, f64),
    observer: &mut SearchObserver<'_>,
) -> Result<Borders<R>, BorderError> {
    let mut search = Search::new(model, spec, range, observer)?;
    let (mut failure, mut is_known) = (None, false);
    let parts = spec.samples.max(1);
    let value = |place| part(range.0, range.1, place, parts);
    for first in (0..parts).step_by(STRETCH) {
        let last = first.saturating_add(STRETCH).min(parts);
        let [begun, share] = [first, last - first].map(|count| count as f64 / parts as f64);
        // A value more on either side.
        let before = first.saturating_sub(1);
        let values: Vec<f64> = (before..=(last + 1).min(parts)).map(value).collect();
        // The value that two stretches share counts once.
        let own = first - before..last - before + usize::from(last == parts);
        match search.stretch(&values, (value(first), value(last)), own, (begun, share)) {
            Ok(ControlFlow::Continue(())) => is_known = true,
            Ok(ControlFlow::Break(())) => {
                search.found.is_complete = false;
                break;
            }
            Err(error) => {
                failure.get_or_insert(error);
            }
        }
    }
    match failure {
        Some(error) if !is_known => Err(error),
        _ => Ok(search.finish()),
    }
}

/// The border nearest to a parameter value: of those between half of it and twice as much, around zero of those from -1
/// to 1.
///
/// # Errors
/// [`BorderError::NoBorder`] if there is none, else as for [`borders_in`].
pub fn border_near<R: Real>(
    model: &Model,
    spec: &BorderSpec,
    value: f64,
) -> Result<Border<R>, BorderError> {
    let found = search_near(model, spec, value, &mut |_| ControlFlow::Continue(()))?;
    Ok(found.expect("nobody breaks off what is unwatched"))
}

/// Like [`border_near`], with an observer that hears what part of the search is done and may break it off; nothing is found
/// then.
///
/// # Errors
/// As for [`border_near`].
pub fn search_near<R: Real>(
    model: &Model,
    spec: &BorderSpec,
    value: f64,
    observer: &mut SearchObserver<'_>,
) -> Result<Option<Border<R>>, BorderError> {
    let (low, high) = match value {
        0.0 => (-UNIT, UNIT),
        _ if value > 0.0 => (value * 0.5, value * 2.0),
        _ => (value * 2.0, value * 0.5),
    };
    let mut search = Search::new(model, spec, (low, high), observer)?;
    let ends = (0..=GRADES).map(|grade| 1.0 / f64::from(1 << (GRADES - grade)));
    let begins = core::iter::once(0.0).chain(ends.clone());
    let places = begins.zip(ends).flat_map(|(begin, end)| {
        (1..=GRADE_SAMPLES).map(move |k| part(begin, end, k, GRADE_SAMPLES))
    });
    let mut values: Vec<f64> = places.clone().map(|x| value + (low - value) * x).collect();
    values.reverse();
    values.push(value);
    values.extend(places.map(|x| value + (high - value) * x));
    search.nearest = Some((value, f64::INFINITY));
    let stretch = search.stretch(&values, (low, high), 0..values.len(), (0.0, 1.0))?;
    if stretch.is_break() {
        return Ok(None);
    }
    let mut found = search.finish();
    let breaks = found.breaks;
    (found.borders.pop().map(Some)).ok_or(BorderError::NoBorder { low, high, breaks })
}

/// The verdicts that [`borders_in`] starts from: at `spec.samples` + 1 parameter values from `low` to `high`, a list for
/// each release point.
///
/// # Errors
/// As for [`borders_in`].
pub fn verdicts_in(
    model: &Model,
    spec: &BorderSpec,
    low: f64,
    high: f64,
) -> Result<Vec<Vec<(f64, Verdict)>>, BorderError> {
    let mut observer = |_: &SearchProgress| ControlFlow::Continue(());
    let mut search: Search<'_, f64> = Search::new(model, spec, (low, high), &mut observer)?;
    let parts = spec.samples.max(1);
    let values: Vec<f64> = (0..=parts).map(|k| part(low, high, k, parts)).collect();
    let branches = search.scan(&values, (0.0, 1.0))?.unwrap_or_default();
    let verdicts = |samples: &Vec<Sample>| samples.iter().map(|s| (s.value, s.verdict)).collect();
    Ok(branches.iter().map(verdicts).collect())
}
