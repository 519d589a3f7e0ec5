//! States on a section of the flight after release, predicted by the one-dimensional map.

use super::super::error::BorderError;
use super::super::orbit::Border;
use super::super::prediction::AffineStates;
use super::super::problem::{Problem, columns};
use super::super::spec::BorderSpec;
use crate::expressions::{Expr, Symbol, nearest};
use crate::flow::with_identity;
use crate::flow::{FlowError, Occurrence, Settings, System, Trajectory};
use crate::model::Model;
use crate::numerics::{DoubleDouble, Real, dot};

/// The state, columns included, in which the flight from a state crosses the section of a system, within a time and before an
/// impact; `None` if it does not.
pub(super) fn crossing<R: Real>(
    system: &System,
    parameters: &[R],
    start: &[R],
    within: R,
) -> Result<Option<Vec<R>>, FlowError> {
    let mut work = system.workspace::<R>(&Settings::default());
    let time = system.model().time.map_or(R::ZERO, |index| start[index]);
    let mut trajectory = Trajectory::start(system, &mut work, parameters, time, start)?;
    loop {
        match trajectory.advance(system, &mut work, time + within)? {
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
    let not_crossed = || BorderError::SectionNotCrossed {
        name: section.to_owned(),
    };
    let Some(chosen) = model.section(section) else {
        let names = model.sections.iter().map(|s| &*s.name);
        return Err(BorderError::UnknownSection {
            name: section.to_owned(),
            nearest: nearest(section, names),
        });
    };
    let surface = chosen.surface;
    let problem = Problem::new(model, spec)?;
    let mut model = model.clone();
    model.sections.retain(|s| s.name == section);
    let columns = columns(&model, problem.parameter);
    let states = problem.states();
    let system = System::with_columns(&model, &columns)?;
    // The coefficients are wanted to plot by: the border is needed more finely than they are.
    let value: DoubleDouble = border.value.value.to_double_double();
    let parameters = problem.parameters(value);
    let release = problem.release_point(value, &border.release.place())?;
    let start = with_identity(&release.state, columns.len());
    let within = border.first_impact.time.to_double_double();
    let state = &*crossing(&system, &parameters, &start, within)?.ok_or_else(not_crossed)?;
    let here = &state[..states];
    let mut graph = model.graph.clone();
    let rates = model.parameter_rates(&mut graph, problem.parameter);
    let symbols: Vec<Symbol> = (0..states).map(Symbol::State).collect();
    let mut slopes = graph.gradient(surface, &symbols);
    slopes.push(
        graph.directional_derivatives(&[surface], &|symbol| match symbol {
            Symbol::Parameter(i) => rates.get(i).copied(),
            Symbol::State(_) => None,
        })[0],
    );
    let evaluate = |exprs: &[Expr]| -> Vec<DoubleDouble> {
        exprs
            .iter()
            .map(|&expr| graph.evaluate(expr, here, &parameters))
            .collect()
    };
    let (slopes, field) = (evaluate(&slopes), evaluate(&model.field()));
    let speed = dot(&slopes[..states], &field);
    let along = |weights: &[DoubleDouble], by_parameter: DoubleDouble| -> Vec<f64> {
        let moved: Vec<DoubleDouble> = (0..states)
            .map(|i| {
                (weights.iter().chain([&by_parameter]).enumerate())
                    .map(|(column, &weight)| system.column(state, column)[i] * weight)
                    .fold(DoubleDouble::ZERO, |sum, part| sum + part)
            })
            .collect();
        let drift = dot(&slopes[..states], &moved) + slopes[states] * by_parameter;
        (moved.iter().zip(&field))
            .map(|(&moved, &field)| (moved - field * drift / speed).to_f64())
            .collect()
    };
    let exactly = |values: &mut dyn Iterator<Item = R>| -> Vec<DoubleDouble> {
        values.map(|x| x.to_double_double()).collect()
    };
    let offset = exactly(&mut border.exact.offset.iter().map(|x| x.value));
    let slope = exactly(&mut border.release.slope.iter().copied());
    Ok(AffineStates {
        origin: here.iter().map(|x| x.to_f64()).collect(),
        by_upsilon: along(&offset, DoubleDouble::ZERO),
        by_parameter: along(&slope, DoubleDouble::ONE),
    })
}
