//! The paper's leading-order coefficients, (17) to (24), for any model.
//!
//! They replace X by u = j_R w / nu^2 at the first impact, with nu at rest on the contact, and the flight after release by
//! its leading order h = j t^3 / 6, v = j t^2 / 2 up to a section through which the trajectory passes. Both choices show
//! in the result: see [`Exact`](super::super::Exact) for coefficients that depend on neither.

use super::super::coordinate::limits::Limits;
use super::super::coordinate::local::{LocalCoordinate, LocalTape, Slopes};
use super::super::coordinate::root::Point;
use super::super::error::BorderError;
use super::super::problem::{Problem, columns};
use super::super::spec::BorderSpec;
use super::exact::{SectionChart, combine};
use super::section::crossing;
use crate::expressions::Graph;
use crate::flow::with_identity;
use crate::flow::{System, SystemError};
use crate::model::{Direction, Model, Section};
use crate::numerics::linear::solve;
use crate::numerics::{Real, dot, unchanged, with_rounding};
use serde::{Deserialize, Serialize};

/// The section that the flight after release crosses where the leading order is matched to the true flight.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReleaseSection {
    /// Name of the state that defines it.
    pub state: String,
    /// Its value.
    pub level: f64,
}

unchanged!(ReleaseSection);

/// How far the section lies from release if nothing else is asked for, relative to the state there: the paper's 10.1 for
/// the valve, which is released at 10. Absolute for a phase, and for a state that is released at zero.
const SECTION_DISTANCE: f64 = 0.01;

/// A state whose speed at release is this small against that of another is at rest there, but for rounding; and it is at
/// zero if it is this small against what it moves by.
const AT_REST: f64 = 1e-9;

with_rounding! {
    /// Coefficients of (17) to (24). Offsets on the section are (gap, rate), with more than three states those held that are
    /// coordinates of release points; states after the first impact the
    /// [`section`](super::super::Border::section) coordinates.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    pub struct LeadingOrder<R> {
        /// The section y3 = 10.1 in the paper.
        pub section: ReleaseSection,
        /// Gap and rate where the border orbit crosses it.
        pub crossing: [R; 2],
        /// A: a row for each coordinate after the first impact, a column each for gap and rate on the section.
        pub a: Vec<[R; 2]>,
        /// B: gap and rate on the section that Upsilon = 1 makes.
        pub b: [R; 2],
        /// C: derivative of u by the coordinates after the first impact.
        pub c: Vec<R>,
        /// D: derivative of u by the parameter.
        pub d: R,
        /// E: derivative of gap and rate on the section by the parameter.
        pub e: [R; 2],
        /// F: derivative of the coordinates after the first impact by the parameter, gap and rate on the section fixed.
        pub f: Vec<R>,
        /// C A B.
        pub slope: R,
        /// C A E + C F + D.
        pub unfolding_rate: R,
    }
}

/// The state that changes most against its size at release, and a level that it reaches soon after.
fn default_section<R: Real>(problem: &Problem, point: &Point<R>) -> (usize, f64) {
    let release = &point.release;
    let distance = |i: usize| {
        let size = release.state[i].abs().to_f64();
        if problem.releases[release.contact].is_phase(i) || size <= SECTION_DISTANCE * AT_REST {
            SECTION_DISTANCE
        } else {
            SECTION_DISTANCE * size
        }
    };
    let speed = |i: usize| release.field[i].abs().to_f64();
    let choice = || (0..release.state.len()).filter(|i| !release.free.contains(i));
    let fastest = choice().map(speed).fold(0.0, f64::max);
    let index = choice()
        .filter(|&i| speed(i) > AT_REST * fastest)
        .max_by(|&a, &b| {
            let share = |i: usize| speed(i) / distance(i);
            share(a).total_cmp(&share(b))
        })
        .unwrap_or(0);
    let forward = release.field[index].to_f64().signum();
    (
        index,
        release.state[index].to_f64() + forward * distance(index),
    )
}

/// The state where the flight from release reaches the section.
fn reached<R: Real>(
    problem: &Problem,
    point: &Point<R>,
    (index, level): (usize, f64),
) -> Result<Option<Vec<R>>, BorderError> {
    let mut model = problem.model.clone();
    let graph: &mut Graph = &mut model.graph;
    let state = graph.state(index);
    let level = graph.number(level);
    let surface = graph.sub(state, level);
    model.sections.push(Section {
        reset: None,
        name: String::new(),
        surface,
        direction: Direction::Either,
    });
    let system = System::new(&model)?;
    let parameters = problem.parameters(point.value);
    let start = &point.release.state;
    let started = model.time.map_or(R::ZERO, |index| start[index]);
    let within = point.sequence.impacts[0].time - started;
    Ok(crossing(&system, &parameters, start, within)?)
}

/// The leading-order coefficients at a border, with the section asked for or a default one.
pub(crate) fn leading_order<R: Real>(
    problem: &Problem,
    point: &Point<R>,
    chart: &SectionChart<R>,
    section: Option<&ReleaseSection>,
) -> Result<Result<LeadingOrder<R>, ReleaseSection>, BorderError> {
    let (index, level) = match section {
        Some(section) => {
            let index = problem.state_index(&section.state)?;
            (index, section.level)
        }
        None => default_section(problem, point),
    };
    let section = ReleaseSection {
        state: problem.model.states[index].name.clone(),
        level,
    };
    let Some(at) = reached(problem, point, (index, level))? else {
        return Ok(Err(section));
    };
    let parameters = problem.parameters(point.value);
    let release = &point.release;

    // The flight from the section to the first impact, in terms of gap and rate there.
    let equations = &problem.releases[release.contact];
    let states = problem.states();
    let [gap, rate] = equations.gap_and_rate_slopes(&at, &parameters);
    let fixed = release.free.iter().chain([&index]).map(|&held| {
        let mut row = vec![R::ZERO; states];
        row[held] = R::ONE;
        row
    });
    let rows: Vec<Vec<R>> = [gap[..states].to_vec(), rate[..states].to_vec()]
        .into_iter()
        .chain(fixed)
        .collect();
    let displacement = |gap: R, rate: R| {
        let mut right = vec![R::ZERO; states];
        (right[0], right[1]) = (gap, rate);
        solve(&rows, &right)
    };
    let flight = problem.variation(&parameters, (release.contact, &at), 0, 1)?;
    let (Some(first), Some(by_gap), Some(by_rate), Some(at_fixed)) = (
        flight.impacts.first(),
        displacement(R::ONE, R::ZERO),
        displacement(R::ZERO, R::ONE),
        displacement(-gap[states], -rate[states]),
    ) else {
        return Ok(Err(section));
    };
    let reached = |weights: Vec<R>, by_parameter: bool| -> Vec<R> {
        let moved = combine(
            &first.local.slopes,
            &Problem::weights(&weights, by_parameter),
        );
        chart.free.iter().map(|&i| moved[i]).collect()
    };
    let by_gap = reached(by_gap, false);
    let by_rate = reached(by_rate, false);
    let a: Vec<[R; 2]> = by_gap
        .into_iter()
        .zip(by_rate)
        .map(|(gap, rate)| [gap, rate])
        .collect();
    let f = reached(at_fixed, true);

    // u and nu at the first impact.
    let columns = columns(&problem.model, problem.parameter);
    let contact = release.contact;
    let at_rest = LocalTape::new(&problem.model, contact, &columns, LocalCoordinate::AtRest)
        .map_err(|error| BorderError::System(SystemError::Model(error)))?;
    let start = with_identity(&point.sequence.impacts[0].state[..states], columns.len());
    let low = vec![R::ZERO; start.len()];
    let local = at_rest.at(
        &mut at_rest.expansion(),
        &at_rest.constants(&parameters),
        &start,
        &low,
    );
    let (jerk, nu, w) = (release.jerk, local.nu(), local.rate);
    let number = |value: f64| R::splat(value);
    let u_slope = |along: usize| {
        let weights = chart.weights(along);
        let total = |part: &dyn Fn(&Slopes<R>) -> R| {
            (local.slopes.iter().zip(&weights))
                .fold(R::ZERO, |sum, (slope, &weight)| sum + part(slope) * weight)
        };
        let (dw, da) = (total(&|s| s.rate), total(&|s| s.acceleration));
        jerk * (dw / (nu * nu) + number(2.0) * w * da / (nu * nu * nu))
    };
    let coordinates = chart.free.len();
    let c: Vec<R> = (0..coordinates).map(u_slope).collect();
    let d = u_slope(coordinates) + release.jerk_slope * w / (nu * nu);

    // The flight from release to the section, to leading order.
    let length = R::splat(level) - release.state[index];
    let speed = release.field[index];
    let time = length / speed;
    let time_slope = -(point.held_slope[index] + time * release.field_slope[index]) / speed;
    let rate_offset = nu * nu / jerk;
    let b = [time * rate_offset, rate_offset];
    let square = time * time;
    let e = [
        release.jerk_slope * square * time / number(6.0) + jerk * square * time_slope / number(2.0),
        release.jerk_slope * square / number(2.0) + jerk * time * time_slope,
    ];
    let after = |v: [R; 2]| -> Vec<R> { a.iter().map(|row| dot(row, &v)).collect() };
    let gap_value = equations.gap_and_rate(&at, &parameters);
    Ok(Ok(LeadingOrder {
        section,
        crossing: gap_value,
        slope: dot(&c, &after(b)),
        unfolding_rate: dot(&c, &after(e)) + dot(&c, &f) + d,
        a,
        b,
        c,
        d,
        e,
        f,
    }))
}

/// The leading-order coefficients at a parameter value near a border, as the paper has them at q = 0.020056: for the
/// release point whose chatter is nearest to one.
///
/// # Errors
/// As for [`borders_in`](super::super::borders_in), and [`BorderError::Section`] if the section is not crossed.
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
    let point = problem.point(value, &release.place(), settles, spec.extrapolation)?;
    let parameters = problem.parameters(value);
    let first = &point.sequence.impacts[0].state[..problem.states()];
    let chart = SectionChart::new(&problem, release.contact, &parameters, first);
    let form = leading_order(&problem, &point, &chart, spec.section.as_ref())??;
    Ok(form)
}
