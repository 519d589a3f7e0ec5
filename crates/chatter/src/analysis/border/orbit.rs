//! A border orbit with its normal form.

use super::coordinate::root::Root;
use super::error::{BorderError, BreakCause, Lack};
use super::normal_form::exact::{Exact, exact};
use super::normal_form::leading_order::{LeadingOrder, ReleaseSection, leading_order};
use super::release::equations::ReleasePoint;
use super::release::forcing::Turn;
use crate::analysis::universal::Constants;
use crate::numerics::{DoubleDouble, Estimate, Real, Rounded, with_rounding};
use serde::{Deserialize, Serialize};

with_rounding! {
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
}

with_rounding! {
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
        /// Indices of the states that are coordinates on the contact surface at the first impact.
        pub section: Vec<usize>,
        /// (M5).
        pub exact: Exact<R>,
        /// (17) to (24); or the section that is not crossed between release and first impact.
        pub leading_order: Result<LeadingOrder<R>, ReleaseSection>,
    }
}

/// The normal form at a root found in `f64`, or why that is no border; in double-double: its limits keep half the digits of the number that they
/// are computed with, and cost little.
pub(crate) fn complete<R: Real>(
    rough: &Root<'_, f64>,
) -> Result<Result<Border<R>, BreakCause>, BorderError> {
    let problem = rough.point.here.problem;
    let start = rough.point.here.value;
    let slack = (POLISH_SLACK * rough.point.parameter_scale()).max(4.0 * rough.error);
    let near = rough.point.release.place();
    let settles = rough.point.settles;
    let guess = DoubleDouble::from(start);
    let within = (start - slack, start + slack);
    let root = problem.root(guess, &near, settles, within);
    let Some(Root { point, error }) = root else {
        return Ok(Err(BreakCause::Jump));
    };
    if let Some(rate) = point.sequence.grazing_start() {
        return Ok(Err(BreakCause::Graze { impact: 0, rate }));
    }
    if !point.closes() {
        return Ok(Err(BreakCause::Elsewhere));
    }
    let states = problem.states();
    let way: Vec<&[DoubleDouble]> = (point.sequence.impacts.iter())
        .map(|impact| &impact.state[..states])
        .collect();
    let released = (&point.release, &point.here.parameters[..]);
    if let Some(corner) = problem.corner_at(released, &way) {
        return Err(point.here.lacks(Lack::Smooth(corner)));
    }
    let first = &point.sequence.impacts[0];
    let started =
        (problem.model.time).map_or(DoubleDouble::ZERO, |index| point.release.state[index]);
    let chart = point.chart();
    let mut period = point.limits.accumulation(&point.sequence);
    period.value -= started;
    let border = Border {
        parameter: problem.spec.parameter.clone(),
        value: Estimate {
            value: point.here.value,
            error,
        },
        constants: point.limits.constants,
        first_impact: FirstImpact {
            time: first.time - started,
            state: first.state[..problem.states()].to_vec(),
            rate_before: first.rate_before,
        },
        period,
        turns: point.turns.clone(),
        sequence_begins: point.sequence.begins,
        long_flights: point.sequence.arrivals(),
        impacts: point.followed,
        exact: exact(&point, &chart)?,
        leading_order: leading_order(&point, &chart)?,
        section: chart.free.clone(),
        release: point.release,
    };
    Ok(Ok(border.rounded()))
}

/// Polishing a root moves it by the errors of the `f64` search at most.
const POLISH_SLACK: f64 = 1e-6;
