//! The paper's leading-order coefficients, (17) to (24), for any model.
//!
//! They replace X by u = j_R w / nu^2 at the first impact, with nu at rest on the contact, and the flight after release by
//! its leading order h = j t^3 / 6, v = j t^2 / 2 up to a section through which the trajectory passes. Both choices show
//! in the result: see [`Exact`](super::super::Exact) for coefficients that depend on neither.

use super::super::coordinate::limits::Limits;
use super::super::coordinate::local::{LocalCoordinate, LocalTape, Slopes};
use super::super::coordinate::root::Point;
use super::super::error::BorderError;
use super::super::problem::{PARAMETER_COLUMN, Problem, STATES, exactly};
use super::super::spec::BorderSpec;
use super::exact::{SectionChart, combine};
use crate::expressions::Graph;
use crate::flow::with_identity;
use crate::flow::{Column, Occurrence, Settings, System, SystemError, Trajectory};
use crate::model::{Direction, Model, Section};
use crate::numerics::Real;
use crate::numerics::linear::solve;
use serde::{Deserialize, Serialize};

/// The section that the flight after release crosses where the leading order is matched to the true flight.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReleaseSection {
    /// Name of the state that defines it.
    pub state: String,
    /// Its value.
    pub level: f64,
}

/// How far the section lies from release if nothing else is asked for, relative to the state there: the paper's 10.1 for
/// the valve, which is released at 10. Absolute for a phase, and for a state that is released at zero.
const SECTION_DISTANCE: f64 = 0.01;

/// A state whose speed at release is this small against that of another is at rest there, but for rounding; and it is at
/// zero if it is this small against what it moves by.
const AT_REST: f64 = 1e-9;

/// Coefficients of (17) to (24). Offsets on the section are (gap, rate), states after the first impact the
/// [`section`](super::super::Border::section) coordinates.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LeadingOrder<R> {
    /// The section y3 = 10.1 in the paper.
    pub section: ReleaseSection,
    /// Gap and rate where the border orbit crosses it.
    pub crossing: [R; 2],
    /// A: a row for each coordinate after the first impact, a column each for gap and rate on the section.
    pub a: [[R; 2]; 2],
    /// B: gap and rate on the section that Upsilon = 1 makes.
    pub b: [R; 2],
    /// C: derivative of u by the coordinates after the first impact.
    pub c: [R; 2],
    /// D: derivative of u by the parameter.
    pub d: R,
    /// E: derivative of gap and rate on the section by the parameter.
    pub e: [R; 2],
    /// F: derivative of the coordinates after the first impact by the parameter, gap and rate on the section fixed.
    pub f: [R; 2],
    /// C A B.
    pub slope: R,
    /// C A E + C F + D.
    pub unfolding_rate: R,
}

fn dot<R: Real>(a: [R; 2], b: [R; 2]) -> R {
    a[0] * b[0] + a[1] * b[1]
}

/// The state that changes most against its size at release, and a level that it reaches soon after.
fn default_section<R: Real>(problem: &Problem, point: &Point<R>) -> (usize, f64) {
    let release = &point.release;
    let distance = |i: usize| {
        let size = release.state[i].abs().to_f64();
        if problem.release.forcing.is_phase(i) || size <= SECTION_DISTANCE * AT_REST {
            SECTION_DISTANCE
        } else {
            SECTION_DISTANCE * size
        }
    };
    let speed = |i: usize| release.field[i].abs().to_f64();
    let fastest = (0..STATES).map(speed).fold(0.0, f64::max);
    let index = (0..STATES)
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
fn crossing<R: Real>(
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
    let mut work = system.workspace::<R>(&Settings::default());
    let parameters = problem.parameters(point.value);
    let start = &point.release.state;
    let time = model.time.map_or(R::ZERO, |index| start[index]);
    let first = point.sequence.impacts[0].time;
    let mut trajectory = Trajectory::start(&system, &mut work, &parameters, time, start)?;
    loop {
        match trajectory.advance(&system, &mut work, first)? {
            Some(Occurrence::Section { .. }) => return Ok(Some(trajectory.state().to_vec())),
            Some(Occurrence::Impact { .. } | Occurrence::Horizon) => return Ok(None),
            _ => {}
        }
    }
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
    let Some(at) = crossing(problem, point, (index, level))? else {
        return Ok(Err(section));
    };
    let parameters = problem.parameters(point.value);
    let release = &point.release;

    // The flight from the section to the first impact, in terms of gap and rate there.
    let [gap, rate] = problem.release.gap_and_rate_slopes(&at, &parameters);
    let mut fixed = vec![R::ZERO; STATES];
    fixed[index] = R::ONE;
    let rows = vec![gap[..STATES].to_vec(), rate[..STATES].to_vec(), fixed];
    let displacement = |gap: R, rate: R| solve(&rows, &[gap, rate, R::ZERO]);
    let flight = problem.variation(&parameters, &at, 0, 1)?;
    let (Some(first), Some(by_gap), Some(by_rate), Some(at_fixed)) = (
        flight.impacts.first(),
        displacement(R::ONE, R::ZERO),
        displacement(R::ZERO, R::ONE),
        displacement(-gap[PARAMETER_COLUMN], -rate[PARAMETER_COLUMN]),
    ) else {
        return Ok(Err(section));
    };
    let reached = |mut weights: Vec<R>, by_parameter: R| -> [R; 2] {
        weights.push(by_parameter);
        let moved = combine(&first.local.slopes, &weights);
        [moved[chart.free[0]], moved[chart.free[1]]]
    };
    let by_gap = reached(by_gap, R::ZERO);
    let by_rate = reached(by_rate, R::ZERO);
    let a = [[by_gap[0], by_rate[0]], [by_gap[1], by_rate[1]]];
    let f = reached(at_fixed, R::ONE);

    // u and nu at the first impact.
    let columns: Vec<Column> = (0..STATES)
        .map(|_| Column::State)
        .chain([Column::Parameter(problem.parameter)])
        .collect();
    let at_rest = LocalTape::new(&problem.model, &columns, LocalCoordinate::AtRest)
        .map_err(|error| BorderError::System(SystemError::Model(error)))?;
    let start = with_identity(
        &point.sequence.impacts[0].state[..STATES],
        PARAMETER_COLUMN + 1,
    );
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
    let c = [u_slope(0), u_slope(1)];
    let d = u_slope(2) + release.jerk_slope * w / (nu * nu);

    // The flight from release to the section, to leading order.
    let length = R::splat(level) - release.state[index];
    let speed = release.field[index];
    let time = length / speed;
    let time_slope = -(release.slope[index] + time * release.field_slope[index]) / speed;
    let rate_offset = nu * nu / jerk;
    let b = [time * rate_offset, rate_offset];
    let square = time * time;
    let e = [
        release.jerk_slope * square * time / number(6.0) + jerk * square * time_slope / number(2.0),
        release.jerk_slope * square / number(2.0) + jerk * time * time_slope,
    ];
    let after = |v: [R; 2]| [dot(a[0], v), dot(a[1], v)];
    let gap_value = problem.release.gap_and_rate(&at, &parameters);
    Ok(Ok(LeadingOrder {
        section,
        crossing: gap_value,
        slope: dot(c, after(b)),
        unfolding_rate: dot(c, after(e)) + dot(c, f) + d,
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
    let near = exactly(&release.state);
    let point = problem.point(value, &near, settles, spec.extrapolation)?;
    let parameters = problem.parameters(value);
    let first = &point.sequence.impacts[0].state[..STATES];
    let chart = SectionChart::new(&problem, &parameters, first);
    let form = leading_order(&problem, &point, &chart, spec.section.as_ref())??;
    Ok(form)
}
