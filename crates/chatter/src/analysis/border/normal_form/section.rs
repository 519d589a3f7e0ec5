//! States on a section of the flight after release, predicted by the one-dimensional map.

use super::super::error::{BorderError, Named};
use super::super::orbit::Border;
use super::super::prediction::AffineStates;
use super::super::problem::{Problem, columns};
use super::super::spec::BorderSpec;
use crate::expressions::Expr;
use crate::flow::with_identity;
use crate::flow::{Column, Direction, Occurrence, Settings, System, Trajectory};
use crate::model::Model;
use crate::numerics::{DoubleDouble, Real};

/// The state, columns included, in which the flight from a state crosses a section of a model, within a time and before an
/// impact; `None` if it does not.
pub(super) fn crossing<R: Real>(
    model: &Model,
    columns: &[Column],
    parameters: &[R],
    (start, within): (&[R], R),
) -> Result<Option<Vec<R>>, BorderError> {
    let system = System::with_columns(model, columns)?;
    let mut work = system.workspace::<R>(&Settings::default());
    let time = model.time.map_or(R::ZERO, |index| start[index]);
    let start = with_identity(start, columns.len());
    let mut trajectory = Trajectory::start(&system, &mut work, parameters, time, &start)?;
    loop {
        match trajectory.advance(&system, &mut work, time + within)? {
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
    let columns = columns(&model, problem.parameter);
    let states = problem.states();
    // The coefficients are wanted to plot by: the border is needed more finely than they are.
    let value: DoubleDouble = border.value.value.to_double_double();
    let parameters = problem.parameters(value);
    let release = problem.release_point(value, &border.release.place())?;
    let within = border.first_impact.time.to_double_double();
    let from = (&*release.state, within);
    let state = &*crossing(&model, &columns, &parameters, from)?.ok_or_else(not_crossed)?;
    let mut graph = model.graph.clone();
    let coordinates: Vec<Expr> = (0..states).map(|i| graph.state(i)).collect();
    let on = (&*model.field(), surface);
    let slopes: Vec<Vec<DoubleDouble>> = (columns.iter().enumerate())
        .map(|(index, &column)| {
            let along = Direction::of(column, &model, &mut graph, (index + 1) * states);
            let slopes = along.at_event(&mut graph, on, &coordinates);
            graph.evaluate_all(&slopes, state, &parameters)
        })
        .collect();
    let along = |weights: &mut dyn Iterator<Item = R>| -> Vec<f64> {
        let weights: Vec<DoubleDouble> = weights.map(|x| x.to_double_double()).collect();
        let moved = (0..states).map(|i| {
            let parts = slopes.iter().zip(&weights);
            parts.fold(DoubleDouble::ZERO, |sum, (slopes, &weight)| {
                sum + slopes[i] * weight
            })
        });
        moved.map(|x| x.to_f64()).collect()
    };
    Ok(AffineStates {
        origin: state[..states].iter().map(|x| x.to_f64()).collect(),
        by_upsilon: along(&mut border.exact.offset.iter().map(|x| x.value)),
        by_parameter: along(&mut border.release.slope.iter().copied()),
    })
}
