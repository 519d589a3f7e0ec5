//! Borders stretch by stretch: all of a range, or from a value of the parameter outwards until the nearest is known.

use super::branches::Branch;
use super::closing_in::HALVINGS_WITHOUT;
use super::sample::Sample;
use super::unfollowed::{Unfollowed, end_of_motion};
use crate::analysis::border::{
    Border, BorderError, BorderSpec, Break, Problem, Root, Verdict, complete,
};
use crate::model::Model;
use crate::numerics::{Estimate, Real};
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
    /// Parameter values at which the motion cannot be followed, in order, and why.
    pub unfollowed: Vec<Unfollowed>,
    /// Whether the whole range was searched: the observer did not break off.
    pub is_complete: bool,
}

impl<R: Real> Borders<R> {
    /// The border nearest to a parameter value.
    pub fn nearest(self, value: f64) -> Option<Border<R>> {
        let borders = self.borders.into_iter();
        borders.min_by(|a, b| off(a, value).total_cmp(&off(b, value)))
    }
}

/// How far a border is from a parameter value.
fn off<R: Real>(border: &Border<R>, value: f64) -> f64 {
    (border.value.value.to_f64() - value).abs()
}

/// Whether two searches came to the same root.
fn is_same(a: &Estimate<f64>, b: &Estimate<f64>) -> bool {
    (a.value - b.value).abs() <= SAME_ROOT * a.value.abs() + a.error + b.error
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

/// Roots this near to each other, relative to the parameter, are one found twice.
const SAME_ROOT: f64 = 8.0 * f64::EPSILON;

/// Breaks this near to each other, relative to the parameter, are told as one.
const SAME_BREAK: f64 = 1e-6;

/// Around a value stretches follow each other to either side, each twice as long as the one before, to as much as the value itself;
/// and the parts of each.
const GRADES: u32 = 8;
const GRADE_PARTS: usize = 12;

/// Where the value asked for is zero, the last stretch ends here.
const UNIT: f64 = 1.0;

/// Parameter values in order. Borders are looked for within the interval; values beyond show whether a distance is smallest there.
struct Stretch {
    values: Vec<f64>,
    within: (f64, f64),
}

impl Stretch {
    /// So many parts from one place to another, and one more on either side. Values are those of places up to one, from a lowest on.
    fn new(
        value: impl Fn(f64) -> f64,
        (begin, end): (f64, f64),
        parts: usize,
        lowest: f64,
    ) -> Self {
        let place = |k: usize| begin + (end - begin) * (k as f64 - 1.0) / parts as f64;
        let mut places: Vec<f64> = (0..=parts + 2).map(place).collect();
        places[parts + 1] = end;
        places.retain(|&place| place <= 1.0);
        let mut values: Vec<f64> = places.into_iter().map(&value).collect();
        values.retain(|&value| value >= lowest);
        values.sort_by(f64::total_cmp);
        let [a, b] = [begin, end].map(value);
        Self {
            values,
            within: (a.min(b), a.max(b)),
        }
    }
}

impl Stretch {
    /// Whether a value counts here: one that two stretches share counts once, the last one, too.
    fn owns(&self, value: f64) -> bool {
        let is_last = self.values.last() == Some(&self.within.1);
        self.within.0 <= value && (is_last || value < self.within.1)
    }
}

/// The search in an interval, and what it has found.
pub(super) struct Search<'a, R> {
    pub problem: &'a Problem,
    low: f64,
    high: f64,
    observer: &'a mut SearchObserver<'a>,
    /// From where to where of the whole work the present stretch goes.
    share: [f64; 2],
    /// Sequences that may still be followed to close in on a change of the verdict.
    pub left: usize,
    /// The roots that were looked at.
    roots: Vec<Estimate<f64>>,
    /// Roots that are no borders.
    refused: Vec<Break>,
    pub found: Borders<R>,
}

impl<'a, R: Real> Search<'a, R> {
    fn new(
        problem: &'a Problem,
        (low, high): (f64, f64),
        observer: &'a mut SearchObserver<'a>,
    ) -> Result<Self, BorderError> {
        if !(low < high && low.is_finite() && high.is_finite()) {
            return Err(BorderError::Range { low, high });
        }
        Ok(Self {
            problem,
            low,
            high,
            observer,
            share: [0.0, 1.0],
            left: 0,
            roots: Vec::new(),
            refused: Vec::new(),
            found: Borders {
                borders: Vec::new(),
                breaks: Vec::new(),
                unresolved: 0,
                without_chatter: 0,
                unfollowed: Vec::new(),
                is_complete: true,
            },
        })
    }

    /// Tells that this part of a stretch is done, and hears whether to go on.
    fn goes_on(&mut self, part: f64) -> bool {
        let [begin, end] = self.share;
        let borders = self.found.borders.len();
        let done = begin + (end - begin) * part;
        self.found.is_complete = (self.observer)(&SearchProgress { done, borders }).is_continue();
        self.found.is_complete
    }

    /// The verdicts at parameter values in order, along each branch of release points; values at which that fails have none, and are
    /// noted as far as they are this stretch's own. The error is the first failure, if nothing is known at any value. Nothing if the
    /// observer breaks off.
    fn scan(
        &mut self,
        values: &[f64],
        is_own: impl Fn(f64) -> bool,
    ) -> Result<Vec<Branch>, BorderError> {
        let mut branches: Vec<Branch> = Vec::new();
        let mut failures = Vec::new();
        for k in 0..values.len() {
            if !self.goes_on(VERDICTS * (k as f64 / values.len() as f64)) {
                return Ok(Vec::new());
            }
            failures.push(self.problem.extend(&mut branches, (values, k)).err());
        }
        let unfollowed = |k: usize| {
            let at = failures[k].as_ref().and_then(end_of_motion);
            let error = at.or_else(|| branches.iter().find_map(|branch| branch[k].failure()));
            let (value, error) = (values[k], error?.clone());
            Some(Unfollowed { value, error })
        };
        let own = (0..values.len()).filter(|&k| is_own(values[k]));
        self.found.unfollowed.extend(own.filter_map(unfollowed));
        let samples = || branches.iter().flatten();
        if samples().any(|at| at.sequence().is_some()) {
            return Ok(branches);
        }
        let failed = samples().find_map(|at| at.sequence.clone()?.err());
        let failed = failed.or_else(|| failures.into_iter().flatten().next());
        failed.map_or(Ok(branches), Err)
    }

    /// Searches a stretch, until the observer breaks off.
    fn stretch(&mut self, stretch: &Stretch) -> Result<(), BorderError> {
        let Stretch { values, within } = stretch;
        let own = |value: f64| stretch.owns(value);
        let samples = self.scan(values, own)?;
        // Release points of contacts that never chatter are none that orbits come to.
        let alone = self.problem.releases.len() == 1;
        let chatters = |branch: &&Branch| alone || !branch.iter().all(Sample::is_without_chatter);
        let is_silent = |place: &usize| {
            let mut branches = samples.iter().filter(chatters);
            own(values[*place]) && branches.any(|branch| branch[*place].is_without_chatter())
        };
        self.found.without_chatter += (0..values.len()).filter(is_silent).count();
        let pairs = samples.iter().flat_map(|branch| self.pairs(branch));
        let is_within =
            |[left, right]: &[Sample; 2]| within.0 <= left.value && right.value <= within.1;
        let changes: Vec<[Sample; 2]> = pairs.filter(is_within).collect();
        for (place, [left, right]) in changes.iter().enumerate() {
            // None may leave the others without sequences.
            self.left = (MOST_SAMPLES / changes.len()).max(LEAST_SHARE);
            self.close_in(left, right, HALVINGS_WITHOUT)?;
            let closed_in = (place + 1) as f64 / changes.len() as f64;
            if !self.goes_on(VERDICTS + (1.0 - VERDICTS) * closed_in) {
                break;
            }
        }
        Ok(())
    }

    /// Makes a border of a root, if it is a new one; whether it lies in a bracket, and its chatter begins as early as is asked for.
    pub(super) fn take(
        &mut self,
        root: &Root<'a, f64>,
        (left, right): (f64, f64),
    ) -> Result<bool, BorderError> {
        let (value, error) = (root.point.here.value, root.error);
        if root.point.sequence.arrivals() > self.problem.spec.excursions {
            return Ok(false);
        }
        let slack = SAME_BREAK * value.abs();
        let is_between = left - slack <= value && value <= right + slack;
        let place = Estimate { value, error };
        let is_known = self.roots.iter().any(|known| is_same(known, &place));
        if is_known || !(self.low..=self.high).contains(&value) {
            return Ok(is_between);
        }
        match complete(root)? {
            Ok(border) => self.found.borders.push(border),
            Err(cause) => self.refused.push(Break { value, cause }),
        }
        self.roots.push(place);
        Ok(is_between)
    }

    /// Searches those of stretches that are wanted beside what is found so far, until the observer breaks off. The error is the
    /// latest failure, if all fail.
    fn search(
        mut self,
        stretches: impl ExactSizeIterator<Item = Stretch>,
        is_wanted: impl Fn(&Stretch, &[Border<R>]) -> bool,
    ) -> Result<Borders<R>, BorderError> {
        let (mut failure, mut is_known) = (None, false);
        let count = stretches.len() as f64;
        for (place, stretch) in stretches.enumerate() {
            if !(self.found.is_complete && is_wanted(&stretch, &self.found.borders)) {
                break;
            }
            self.share = [place, place + 1].map(|place| place as f64 / count);
            match self.stretch(&stretch) {
                Ok(()) => is_known = true,
                Err(error) => failure = Some(error),
            }
        }
        if let Some(error) = failure.filter(|_| !is_known) {
            return Err(error);
        }
        let mut found = self.found;
        let breaks = &mut found.breaks;
        breaks.sort_by(|a, b| a.value.total_cmp(&b.value));
        breaks.dedup_by(|a, b| a.value - b.value <= SAME_BREAK * a.value.abs());
        breaks.extend(self.refused);
        breaks.sort_by(|a, b| a.value.total_cmp(&b.value));
        (found.unfollowed).sort_by(|a, b| a.value.total_cmp(&b.value));
        let value = |border: &Border<R>| border.value.value.to_f64();
        (found.borders).sort_by(|a, b| value(a).total_cmp(&value(b)));
        Ok(found)
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
    (low, high): (f64, f64),
    observer: &mut SearchObserver<'_>,
) -> Result<Borders<R>, BorderError> {
    let parts = spec.samples.max(1);
    let stretch = |first: usize| {
        let last = first.saturating_add(STRETCH).min(parts);
        let [begin, end] = [first, last].map(|k| k as f64 / parts as f64);
        let value = |place: f64| low + (high - low) * place;
        Stretch::new(value, (begin, end), last - first, low)
    };
    let stretches = (0..parts).step_by(STRETCH).map(stretch);
    let problem = Problem::new(model, spec)?;
    Search::new(&problem, (low, high), observer)?.search(stretches, |_, _| true)
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
    let stretch = |place: u32| {
        let edge = if place.is_multiple_of(2) { high } else { low };
        let end = 1.0 / f64::from(1 << (GRADES - place / 2));
        let begin = if place < 2 { 0.0 } else { 0.5 * end };
        let value = |place: f64| value + (edge - value) * place;
        Stretch::new(value, (begin, end), GRADE_PARTS, low)
    };
    let is_wanted = |Stretch { within, .. }: &Stretch, found: &[Border<R>]| {
        let begins = (within.0 - value).max(value - within.1);
        found.iter().all(|border| off(border, value) > begins)
    };
    let problem = Problem::new(model, spec)?;
    let search = Search::new(&problem, (low, high), observer)?;
    let found = search.search((0..2 * (GRADES + 1)).map(stretch), is_wanted)?;
    if !found.is_complete {
        return Ok(None);
    }
    let breaks = found.breaks.clone();
    (found.nearest(value).map(Some)).ok_or(BorderError::NoBorder { low, high, breaks })
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
    let problem = Problem::new(model, spec)?;
    let mut search: Search<'_, f64> = Search::new(&problem, (low, high), &mut observer)?;
    let parts = spec.samples.max(1);
    let value = |k: usize| low + (high - low) * (k as f64 / parts as f64);
    let values: Vec<f64> = (0..=parts).map(value).collect();
    let branches = search.scan(&values, |_| true)?;
    let verdicts = |samples: &Branch| samples.iter().map(|s| (s.value, s.verdict)).collect();
    Ok(branches.iter().map(verdicts).collect())
}
