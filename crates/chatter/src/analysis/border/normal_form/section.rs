//! States on a section of the flight after release, predicted by the one-dimensional map.

use super::super::error::{BorderError, Lack, Named};
use super::super::orbit::Border;
use super::super::prediction::map::AffineStates;
use super::super::problem::{Here, Problem};
use super::super::spec::BorderSpec;
use crate::expressions::Expr;
use crate::flow::{Column, Direction, FlowError, Occurrence, System, columns, with_identity};
use crate::model::Model;
use crate::numerics::{DoubleDouble, Estimate, Real, Rounded, moved};

/// The state, columns included, in which the flight from a state crosses a section of a model, within a time and before an
/// impact; `None` if it does not.
pub(super) fn crossing<R: Real>(
    here: &Here<'_, R>,
    model: &Model,
    columns: &[Column],
    (start, within): (&[R], R),
) -> Result<Option<Vec<R>>, BorderError> {
    let system = System::with_columns(model, columns)?;
    let start = with_identity(start, columns.len());
    let ends = |error: FlowError| here.lacks(Lack::Motion(error));
    let started = system.trajectory_from(&here.parameters, &start);
    let (mut work, mut trajectory) = started.map_err(ends)?;
    let end = trajectory.time() + within;
    loop {
        let next = trajectory.advance(&system, &mut work, end);
        match next.map_err(ends)? {
            Some(Occurrence::Section { .. }) => return Ok(Some(trajectory.state().to_vec())),
            Some(Occurrence::Impact { .. } | Occurrence::Horizon) => return Ok(None),
            _ => {}
        }
    }
}

/// The states where orbits near the border cross a section of the model for the first time after release, with the exact
/// coefficients: what (27) becomes on the section of an orbit diagram, such as y3 = 9.7 for the valve. `z` is that of
/// the passage that the crossing begins.
///
/// # Errors
/// There is no such section, or the border orbit does not cross it before its first impact.
pub fn section_states<R: Real>(
    model: &Model,
    spec: &BorderSpec,
    border: &Border<R>,
    section: &str,
) -> Result<AffineStates, BorderError> {
    let not_crossed = || BorderError::NotCrossed {
        section: format!("`{section}`"),
    };
    let Some(chosen) = model.section(section) else {
        let known = model.sections.iter().map(|s| &*s.name);
        return Err(BorderError::unknown(Named::Section, section, known));
    };
    let surface = chosen.surface;
    let problem = Problem::new(model, spec)?;
    let mut model = model.clone();
    model.sections.retain(|s| s.name == section);
    let states = problem.states();
    let columns = columns(states, &[problem.parameter]);
    // The coefficients are wanted to plot by: the border is needed more finely than they are.
    let value: DoubleDouble = border.value.value.to_double_double();
    let here = problem.at(value)?;
    let release = here.release(&border.release.place())?;
    let within = border.first_impact.time.to_double_double();
    let from = (&*release.state, within);
    let state = &*crossing(&here, &model, &columns, from)?.ok_or_else(not_crossed)?;
    let mut graph = model.graph.clone();
    let coordinates: Vec<Expr> = (0..states).map(|i| graph.state(i)).collect();
    let on = (&*model.field(), surface);
    let slopes: Vec<Vec<DoubleDouble>> = (columns.iter().enumerate())
        .map(|(index, &column)| {
            let along = Direction::of(column, &model, &mut graph, (index + 1) * states);
            let slopes = along.at_event(&mut graph, on, &coordinates);
            graph.evaluate_all(&slopes, state, &here.parameters)
        })
        .collect();
    let along = |weights: &[DoubleDouble]| -> Vec<f64> {
        let (nowhere, parts) = (vec![DoubleDouble::ZERO; states], slopes.iter().zip(weights));
        parts
            .fold(nowhere, |sum, (slopes, &weight)| {
                moved(&sum, slopes, weight)
            })
            .rounded()
    };
    Ok(AffineStates {
        origin: state[..states].to_vec().rounded(),
        by_upsilon: along(&Estimate::values(&border.exact.offset.rounded())),
        by_parameter: along(&border.release.slope.rounded()),
    })
}
