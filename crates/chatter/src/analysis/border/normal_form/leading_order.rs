//! The paper's leading-order coefficients, (17) to (24), for any model.
//!
//! They replace X by u = j_R w / nu^2 at the first impact, with nu at rest on the contact, and the flight after release by
//! its leading order h = j t^3 / 6, v = j t^2 / 2 up to a section through which the trajectory passes. Both choices show
//! in the result: see [`Exact`](super::super::Exact) for coefficients that depend on neither.

use super::super::coordinate::local::{LocalCoordinate, LocalTape};
use super::super::coordinate::root::Point;
use super::super::error::{BorderError, Named};
use super::super::release::equations::{FIELD, JERK};
use super::exact::SectionChart;
use super::section::crossing;
use crate::flow::{columns, with_identity};
use crate::model::{Direction, Section};
use crate::numerics::{Matrix, Real, dot, unchanged, unit, with_rounding};
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

/// The state that changes most against its size at release, where the field is this, and a level that it reaches soon after.
fn default_section<R: Real>(point: &Point<'_, R>, field: &[R]) -> (usize, f64) {
    let release = &point.release;
    let distance = |i: usize| {
        let size = release.state[i].abs().to_f64();
        if point.here.closure.is_phase(i) || size <= SECTION_DISTANCE * AT_REST {
            SECTION_DISTANCE
        } else {
            SECTION_DISTANCE * size
        }
    };
    let speed = |i: usize| field[i].abs().to_f64();
    let share = |&i: &usize| speed(i) / distance(i);
    let choice = || (0..field.len()).filter(|i| !release.free.contains(i));
    let fastest = choice().map(speed).fold(0.0, f64::max);
    let index = choice()
        .filter(|&i| speed(i) > AT_REST * fastest)
        .max_by(|a, b| share(a).total_cmp(&share(b)))
        .unwrap_or(0);
    let forward = field[index].to_f64().signum() * distance(index);
    (index, release.state[index].to_f64() + forward)
}

/// The state where the flight from release reaches the section.
fn reached<R: Real>(
    point: &Point<'_, R>,
    (index, level): (usize, f64),
) -> Result<Option<Vec<R>>, BorderError> {
    let mut model = point.here.problem.model.clone();
    let (state, level) = (model.graph.state(index), model.graph.number(level));
    model.sections.push(Section {
        reset: None,
        name: String::new(),
        surface: model.graph.sub(state, level),
        direction: Direction::Either,
    });
    let start = &*point.release.state;
    let started = model.time.map_or(R::ZERO, |index| start[index]);
    let within = point.sequence.impacts[0].time - started;
    crossing(&point.here, &model, &[], (start, within))
}

/// The leading-order coefficients at a border, with the section asked for or a default one.
pub(crate) fn leading_order<R: Real>(
    point: &Point<'_, R>,
    chart: &SectionChart<R>,
) -> Result<Result<LeadingOrder<R>, ReleaseSection>, BorderError> {
    let Point {
        here: at, release, ..
    } = point;
    let (problem, contact) = (at.problem, release.contact);
    let states = problem.states();
    let here = at.functions(contact, JERK..FIELD + states, &release.state);
    let field = &here.residual[FIELD - JERK..];
    let (index, level) = match &problem.spec.section {
        Some(section) => {
            let (name, model) = (&*section.state, &problem.model);
            let unknown = || BorderError::unknown(Named::State, name, model.state_names());
            (model.state_index(name).ok_or_else(unknown)?, section.level)
        }
        None => default_section(point, field),
    };
    let section = ReleaseSection {
        state: problem.model.states[index].name.clone(),
        level,
    };
    let Some(start) = reached(point, (index, level))? else {
        return Ok(Err(section));
    };

    // The flight from the section to the first impact, in terms of gap and rate there.
    let crossing = at.functions(contact, 0..2, &start);
    let [gap, rate] = [0, 1].map(|row| crossing.jacobian.row(row));
    let mut rows = vec![gap[..states].to_vec(), rate[..states].to_vec()];
    rows.extend((release.free.iter().chain([&index])).map(|&held| unit(states, held)));
    let factors = Matrix::from_rows(&rows).factored();
    let flight = at.variation((contact, &start), 0, 1)?;
    let (Some(first), Some(factors)) = (flight.impacts.first(), factors) else {
        return Ok(Err(section));
    };
    let reached = |offset: &[R], by_parameter: R| -> Vec<R> {
        let mut moved = factors.solve(offset);
        moved.push(by_parameter);
        let moved = first.local.along(&moved);
        chart.free.iter().map(|&i| moved[i]).collect()
    };
    let [by_gap, by_rate] = [0, 1].map(|place| reached(&unit(states, place), R::ZERO));
    let a: Vec<[R; 2]> = (by_gap.into_iter().zip(by_rate))
        .map(|(gap, rate)| [gap, rate])
        .collect();
    let mut fixed = vec![R::ZERO; states];
    (fixed[0], fixed[1]) = (-gap[states], -rate[states]);
    let f = reached(&fixed, R::ONE);

    // u and nu at the first impact.
    let columns = columns(states, &[problem.parameter]);
    let model = (&problem.model, &problem.mechanics);
    let at_rest = LocalTape::new(model, contact, &columns, LocalCoordinate::AtRest);
    let start = with_identity(&point.sequence.impacts[0].state[..states], columns.len());
    let low = vec![R::ZERO; start.len()];
    let local = at_rest.at(&mut at_rest.scratch(&at.parameters), &start, &low);
    let (jerk, nu, w) = (release.jerk, local.nu(), local.rate);
    let number = |value: f64| R::splat(value);
    let u_slope = |along: usize| {
        let [dw, da] = local.rates_along(&chart.weights[along]);
        jerk * (dw / (nu * nu) + number(2.0) * w * da / (nu * nu * nu))
    };
    let coordinates = chart.free.len();
    let c: Vec<R> = (0..coordinates).map(u_slope).collect();
    let by_parameter = |row: usize| dot(here.jacobian.row(row), &point.held_slope);
    let jerk_slope = by_parameter(0);
    let d = u_slope(coordinates) + jerk_slope * w / (nu * nu);

    // The flight from release to the section, to leading order.
    let length = R::splat(level) - release.state[index];
    let speed = field[index];
    let time = length / speed;
    let speed_slope = by_parameter(FIELD - JERK + index);
    let time_slope = -(point.held_slope[index] + time * speed_slope) / speed;
    let rate_offset = nu * nu / jerk;
    let b = [time * rate_offset, rate_offset];
    let square = time * time;
    let e = [
        jerk_slope * square * time / number(6.0) + jerk * square * time_slope / number(2.0),
        jerk_slope * square / number(2.0) + jerk * time * time_slope,
    ];
    let after = |v: [R; 2]| -> Vec<R> { a.iter().map(|row| dot(row, &v)).collect() };
    Ok(Ok(LeadingOrder {
        section,
        crossing: [crossing.residual[0], crossing.residual[1]],
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
