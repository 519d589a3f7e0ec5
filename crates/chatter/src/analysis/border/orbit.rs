//! A border orbit with its normal form, and the questions that find it.

use super::breaks::grazing_start;
use super::closing_in::Found;
use super::coordinate::Limits;
use super::error::{BorderError, Break, BreakCause};
use super::exact::{Exact, SectionChart, exact};
use super::extrapolate::Estimate;
use super::forcing::Turn;
use super::leading_order::{LeadingOrder, ReleaseSection, leading_order};
use super::problem::{Problem, STATES, exactly};
use super::release::ReleasePoint;
use super::root::Root;
use super::samples::{Sample, unwatched};
use super::sequence::Verdict;
use super::spec::BorderSpec;
use crate::analysis::universal::Constants;
use crate::model::Model;
use crate::numerics::{DoubleDouble, Real};
use core::ops::ControlFlow;
use serde::{Deserialize, Serialize};

/// The state after the first impact that follows release.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FirstImpact<R> {
    /// Time since release.
    pub time: R,
    /// The state.
    pub state: Vec<R>,
    /// Gap rate before the impact.
    pub rate_before: R,
}

/// A border orbit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Border<R> {
    /// Name of the parameter.
    pub parameter: String,
    /// Its value p*.
    pub value: Estimate<R>,
    /// Constants of the universal map at the restitution of release: r, u*, lambda, eta.
    pub constants: Constants<R>,
    /// Where the orbit is released and where its chatter ends.
    pub release: ReleasePoint<R>,
    /// s_0.
    pub first_impact: FirstImpact<R>,
    /// From release to the accumulation of the impacts at the release point: the period.
    pub period: Estimate<R>,
    /// What a forced system returns shifted by: the phase, its period, and how many of them the orbit takes.
    pub turns: Vec<Turn<R>>,
    /// Number of the impact after which the chatter sequence begins, the first being 0.
    pub sequence_begins: usize,
    /// Long flights in a period: the one after release, and one before each further excursion until chatter begins.
    pub long_flights: usize,
    /// How many impacts were integrated one by one.
    pub impacts: usize,
    /// Indices of the two states that are coordinates on the contact surface at the first impact.
    pub section: Vec<usize>,
    /// (M5).
    pub exact: Exact<R>,
    /// (17) to (24); or the section that is not crossed between release and first impact.
    pub leading_order: Result<LeadingOrder<R>, ReleaseSection>,
}

/// `parts` + 1 values from `low` to `high`.
pub(super) fn even(low: f64, high: f64, parts: usize) -> Vec<f64> {
    let parts = parts.max(1);
    (0..=parts)
        .map(|i| low + (high - low) * (i as f64 / parts as f64))
        .collect()
}

/// The verdicts that [`borders_in`](super::borders_in) starts from: at `spec.samples` + 1 parameter values from `low` to `high`, a list for
/// each release point.
///
/// # Errors
/// As for [`borders_in`](super::borders_in).
pub fn verdicts_in(
    model: &Model,
    spec: &BorderSpec,
    low: f64,
    high: f64,
) -> Result<Vec<Vec<(f64, Verdict)>>, BorderError> {
    if !(low < high && low.is_finite() && high.is_finite()) {
        return Err(BorderError::Range { low, high });
    }
    let problem = Problem::new(model, spec)?;
    let branches = problem.scan(&even(low, high, spec.samples), &mut unwatched)?;
    let branches = branches.unwrap_or_default();
    let verdicts = |samples: &Vec<Sample>| samples.iter().map(|s| (s.value, s.verdict)).collect();
    Ok(branches.iter().map(verdicts).collect())
}

/// Distances from the value asked for are searched by stretches, each twice as long as the one before, to as much as the
/// value itself.
const STRETCHES: u32 = 8;

/// Parts of each stretch on either side.
const STRETCH_SAMPLES: usize = 12;

/// Where the value asked for is zero, the last stretch ends here.
const UNIT: f64 = 1.0;

/// Values from 0 to 1, the denser the nearer to 0.
fn graded() -> Vec<f64> {
    let mut values = vec![0.0];
    for stretch in 0..=STRETCHES {
        let end = 1.0 / f64::from(1 << (STRETCHES - stretch));
        let begin = if stretch == 0 { 0.0 } else { end * 0.5 };
        values.extend_from_slice(&even(begin, end, STRETCH_SAMPLES)[1..]);
    }
    values
}

/// The border nearest to a parameter value: of those between half of it and twice as much, around zero of those from -1
/// to 1.
///
/// # Errors
/// [`BorderError::NoBorder`] if there is none, else as for [`borders_in`](super::borders_in).
pub fn border_near<R: Real>(
    model: &Model,
    spec: &BorderSpec,
    value: f64,
) -> Result<Border<R>, BorderError> {
    let found = search_near(model, spec, value, &mut unwatched)?;
    Ok(found.expect("nobody breaks off what is unwatched"))
}

/// Like [`border_near`], with a watcher that hears what part of the search is done and may break it off; nothing is found
/// then.
///
/// # Errors
/// As for [`border_near`].
pub fn search_near<R: Real>(
    model: &Model,
    spec: &BorderSpec,
    value: f64,
    watch: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<Option<Border<R>>, BorderError> {
    if !value.is_finite() {
        return Err(BorderError::Range {
            low: value,
            high: value,
        });
    }
    let problem = Problem::new(model, spec)?;
    let (low, high) = match value {
        0.0 => (-UNIT, UNIT),
        _ if value > 0.0 => (value * 0.5, value * 2.0),
        _ => (value * 2.0, value * 0.5),
    };
    let towards = |end: f64| graded().into_iter().map(move |g| value + (end - value) * g);
    let mut values: Vec<f64> = towards(low).collect();
    values.reverse();
    values.extend(towards(high).skip(1));
    let Some(samples) = problem.scan(&values, watch)? else {
        return Ok(None);
    };
    let changes = problem.changes(&samples, spec.extrapolation);
    let nearest = changes.nearest(value, |root, breaks| {
        if !(low..=high).contains(&root.point.value) {
            return Ok(None);
        }
        Ok(match complete(&problem, spec, root)? {
            Ok(border) => Some(border),
            Err(cause) => {
                breaks.push(Break {
                    value: root.point.value,
                    cause,
                });
                None
            }
        })
    })?;
    let breaks = match nearest {
        Ok(border) => return Ok(Some(border)),
        Err(Found { breaks, .. }) => breaks,
    };
    Err(BorderError::NoBorder { low, high, breaks })
}

/// The leading-order coefficients at a parameter value near a border, as the paper has them at q = 0.020056: for the
/// release point whose chatter is nearest to one.
///
/// # Errors
/// As for [`borders_in`](super::borders_in), and [`BorderError::Section`] if the section is not crossed.
pub fn leading_order_at<R: Real>(
    model: &Model,
    spec: &BorderSpec,
    value: R,
) -> Result<LeadingOrder<R>, BorderError> {
    let problem = Problem::new(model, spec)?;
    let at = value.to_f64();
    let releases = problem.release_points(at)?;
    let mut nearest = (f64::INFINITY, 0, &releases[0]);
    for release in &releases {
        let sequence = problem.sequence(at, release, releases.len() > 1)?;
        let limits = Limits::new(
            Problem::constants(at, release)?,
            release,
            spec.extrapolation,
        );
        let distance = limits.rough_distance(&sequence);
        if distance < nearest.0 {
            nearest = (distance, limits.settles(&sequence), release);
        }
    }
    let (_, settles, release) = nearest;
    let near = exactly(&release.state);
    let point = problem.point(value, &near, settles, spec.extrapolation)?;
    let parameters = problem.parameters(value);
    let first = &point.sequence.impacts[0].state[..STATES];
    let chart = SectionChart::new(&problem, &parameters, first);
    let form = leading_order(&problem, &point, &chart, spec.section.as_ref())??;
    Ok(form)
}

/// The normal form at a root found in `f64`, or why that is no border; in double-double: its limits keep half the digits of the number that they
/// are computed with, and cost little.
pub(super) fn complete<R: Real>(
    problem: &Problem,
    spec: &BorderSpec,
    rough: &Root<f64>,
) -> Result<Result<Border<R>, BreakCause>, BorderError> {
    let start = rough.point.value;
    let slack = (POLISH_SLACK * rough.point.parameter_scale()).max(4.0 * rough.error);
    let near = exactly(&rough.point.release.state);
    let settles = rough.point.settles;
    let guess = DoubleDouble::from(start);
    let within = (start - slack, start + slack);
    let root = problem.root(guess, &near, settles, spec.extrapolation, within);
    let Ok(Root { point, error }) = root else {
        return Ok(Err(BreakCause::Jump));
    };
    if let Some(rate) = grazing_start(&point) {
        return Ok(Err(BreakCause::Graze { impact: 0, rate }));
    }
    let Some(turns) = point.turns(problem) else {
        return Ok(Err(BreakCause::Elsewhere));
    };
    let first = &point.sequence.impacts[0];
    let started =
        (problem.model.time).map_or(DoubleDouble::ZERO, |index| point.release.state[index]);
    let parameters = problem.parameters(point.value);
    let chart = SectionChart::new(problem, &parameters, &first.state[..STATES]);
    let mut period = point.limits.accumulation(&point.sequence, point.end);
    period.value -= started;
    let border = Border {
        parameter: spec.parameter.clone(),
        value: Estimate {
            value: point.value,
            error,
        },
        constants: point.limits.constants,
        first_impact: FirstImpact {
            time: first.time - started,
            state: first.state[..STATES].to_vec(),
            rate_before: first.rate_before,
        },
        period,
        turns,
        sequence_begins: point.sequence.begins,
        long_flights: point.sequence.arrivals(),
        impacts: point.sequence.impacts.len(),
        exact: exact(problem, &point, &chart)?,
        leading_order: leading_order(problem, &point, &chart, spec.section.as_ref())?,
        section: chart.free.clone(),
        release: point.release,
    };
    Ok(Ok(border.rounded()))
}

/// Polishing a root moves it by the errors of the `f64` search at most.
const POLISH_SLACK: f64 = 1e-6;
