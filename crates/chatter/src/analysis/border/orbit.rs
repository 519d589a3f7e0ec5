//! A border orbit with its normal form, and the questions that find it.

use super::coordinate::Extrapolation;
use super::error::{BorderError, Break, BreakCause};
use super::exact::{Exact, SectionChart, exact};
use super::extrapolate::Estimate;
use super::leading_order::{LeadingOrder, ReleaseSection, leading_order};
use super::local::LocalCoordinate;
use super::problem::{Problem, STATES, exactly};
use super::release::ReleasePoint;
use super::root::Root;
use super::search::Found;
use super::sequence::Verdict;
use crate::analysis::universal::Constants;
use crate::model::Model;
use crate::numerics::Real;

/// How borders are looked for and normal forms computed.
#[derive(Clone, Debug, PartialEq)]
pub struct BorderSpec {
    /// The parameter that is varied.
    pub parameter: String,
    /// The section of the leading-order coefficients; chosen if not given.
    pub section: Option<ReleaseSection>,
    /// How many parts a range is divided into: two borders within one part are missed.
    pub samples: usize,
    /// How limits along the impact sequence are taken.
    pub extrapolation: Extrapolation,
    /// How u and nu are read off an impact.
    pub coordinate: LocalCoordinate,
}

/// Parts of a range: a verdict costs a tenth of a millisecond.
const SAMPLES: usize = 200;

impl BorderSpec {
    /// The defaults for a parameter.
    pub fn new(parameter: &str) -> Self {
        Self {
            parameter: parameter.to_owned(),
            section: None,
            samples: SAMPLES,
            extrapolation: Extrapolation::default(),
            coordinate: LocalCoordinate::default(),
        }
    }
}

/// The state after the first impact that follows release.
#[derive(Clone, Debug, PartialEq)]
pub struct FirstImpact<R> {
    /// Time since release.
    pub time: R,
    /// The state.
    pub state: Vec<R>,
    /// Gap rate before the impact.
    pub rate_before: R,
}

/// A border orbit.
#[derive(Clone, Debug)]
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
    /// (17) to (24); an error if the section that was asked for is not crossed.
    pub leading_order: Result<LeadingOrder<R>, BorderError>,
}

/// All borders of a range.
#[derive(Clone, Debug)]
pub struct Borders<R> {
    /// In the order of the parameter.
    pub borders: Vec<Border<R>>,
    /// Where the verdict changes without a border.
    pub breaks: Vec<Break>,
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
    if !(low < high && low.is_finite() && high.is_finite()) {
        return Err(BorderError::Range { low, high });
    }
    let problem = Problem::new(model, &spec.parameter, spec.coordinate)?;
    let samples = problem.scan(low, high, spec.samples.max(1))?;
    let Found { roots, mut breaks } = problem.changes(&samples, spec.extrapolation)?;
    let mut borders = Vec::new();
    for root in roots {
        if !(low..=high).contains(&root.point.value) {
            continue;
        }
        match complete(&problem, spec, &root) {
            Ok(border) => borders.push(border),
            Err(_) => breaks.push(Break {
                value: root.point.value,
                cause: BreakCause::Jump,
            }),
        }
    }
    breaks.sort_by(|a, b| a.value.total_cmp(&b.value));
    Ok(Borders { borders, breaks })
}

/// The verdicts that [`borders_in`] starts from: at `spec.samples` + 1 parameter values from `low` to `high`.
///
/// # Errors
/// As for [`borders_in`].
pub fn verdicts_in(
    model: &Model,
    spec: &BorderSpec,
    low: f64,
    high: f64,
) -> Result<Vec<(f64, Verdict)>, BorderError> {
    if !(low < high && low.is_finite() && high.is_finite()) {
        return Err(BorderError::Range { low, high });
    }
    let problem = Problem::new(model, &spec.parameter, spec.coordinate)?;
    let samples = problem.scan(low, high, spec.samples.max(1))?;
    Ok(samples.iter().map(|s| (s.value, s.verdict)).collect())
}

/// Searched distances from the value asked for, relative to it, each twice the one before.
const FIRST_DISTANCE: f64 = 1.0 / 256.0;
const LAST_DISTANCE: f64 = 1.0;

/// Parts of each stretch on either side.
const STRETCH_SAMPLES: usize = 12;

/// Where the value asked for is zero, distances are relative to this.
const UNIT: f64 = 1.0;

/// The border nearest to a parameter value.
///
/// # Errors
/// [`BorderError::NoBorder`] if there is none between half and twice the value, else as for [`borders_in`].
pub fn border_near<R: Real>(
    model: &Model,
    spec: &BorderSpec,
    value: f64,
) -> Result<Border<R>, BorderError> {
    if !value.is_finite() {
        return Err(BorderError::Range {
            low: value,
            high: value,
        });
    }
    let problem = Problem::new(model, &spec.parameter, spec.coordinate)?;
    let unit = if value == 0.0 { UNIT } else { value.abs() };
    let mut distance = FIRST_DISTANCE;
    let mut inner = 0.0;
    let mut breaks = Vec::new();
    let mut failure = None;
    let mut searched = false;
    let (low, high) = loop {
        // Downwards a distance of one would reach zero: half is as far as a factor of two goes.
        let (below, above) = (distance * 0.5, distance);
        let stretches = [
            (value - unit * below, value - unit * inner * 0.5),
            (value + unit * inner, value + unit * above),
        ];
        let mut roots = Vec::new();
        for (from, to) in stretches {
            match problem.scan(from, to, STRETCH_SAMPLES) {
                Ok(samples) => {
                    searched = true;
                    let found = problem.changes(&samples, spec.extrapolation)?;
                    roots.extend(found.roots);
                    breaks.extend(found.breaks);
                }
                Err(error) => failure = Some(error),
            }
        }
        let off = |root: &Root<f64>| (root.point.value - value).abs();
        if let Some(nearest) = roots.iter().min_by(|a, b| off(a).total_cmp(&off(b))) {
            return complete(&problem, spec, nearest);
        }
        if distance >= LAST_DISTANCE {
            break (value - unit * below, value + unit * above);
        }
        inner = distance;
        distance *= 2.0;
    };
    match failure {
        Some(error) if !searched => Err(error),
        _ => Err(BorderError::NoBorder { low, high, breaks }),
    }
}

/// The leading-order coefficients at a parameter value near a border, as the paper has them at q = 0.020056.
///
/// # Errors
/// As for [`borders_in`], and [`BorderError::Section`] if the section is not crossed.
pub fn leading_order_at<R: Real>(
    model: &Model,
    spec: &BorderSpec,
    value: R,
) -> Result<LeadingOrder<R>, BorderError> {
    let problem = Problem::new(model, &spec.parameter, spec.coordinate)?;
    let rough = problem.release_point(value.to_f64(), None)?;
    let begins = problem.sequence(value.to_f64(), &rough)?.begins;
    let near = exactly(&rough.state);
    let point = problem.point(value, &near, begins, spec.extrapolation)?;
    let parameters = problem.parameters(value);
    let first = &point.sequence.impacts[0].state[..STATES];
    let chart = SectionChart::new(&problem, &parameters, first);
    leading_order(&problem, &point, &chart, spec.section.as_ref())
}

/// The normal form at a root found in `f64`, polished in the number type asked for.
fn complete<R: Real>(
    problem: &Problem,
    spec: &BorderSpec,
    rough: &Root<f64>,
) -> Result<Border<R>, BorderError> {
    let start = rough.point.value;
    let slack = POLISH_SLACK * start.abs().max(rough.error);
    let near = exactly(&rough.point.release.state);
    let begins = rough.point.sequence.begins;
    let guess = R::splat(start);
    let within = (start - slack, start + slack);
    let Root { point, error } = problem.root(guess, &near, begins, spec.extrapolation, within)?;
    let first = &point.sequence.impacts[0];
    let started = problem
        .model
        .time
        .map_or(R::ZERO, |index| point.release.state[index]);
    let parameters = problem.parameters(point.value);
    let chart = SectionChart::new(problem, &parameters, &first.state[..STATES]);
    let mut period = point.limits.accumulation(&point.sequence, point.end);
    period.value -= started;
    Ok(Border {
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
        sequence_begins: point.sequence.begins,
        long_flights: (point.sequence.impacts.iter())
            .filter(|impact| impact.arrives)
            .count(),
        impacts: point.sequence.impacts.len(),
        exact: exact(problem, &point, &chart)?,
        leading_order: leading_order(problem, &point, &chart, spec.section.as_ref()),
        section: chart.free.clone(),
        release: point.release,
    })
}

/// Polishing a root moves it by rounding errors of the `f64` search at most.
const POLISH_SLACK: f64 = 1e-6;
