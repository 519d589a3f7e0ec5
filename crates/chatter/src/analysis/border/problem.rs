//! A model and one of its parameters, compiled for the search of border orbits.

use super::error::BorderError;
use super::local::LocalTape;
use super::release::{ReleaseEquations, ReleasePoint};
use super::sequence::{Follower, Sequence, Until};
use super::spec::BorderSpec;
use crate::analysis::universal::Constants;
use crate::expressions::nearest;
use crate::flow::{Column, System, SystemError};
use crate::model::{MechanicsError, Model};
use crate::numerics::{DoubleDouble, Real};

/// Border orbits have three states: only then is the release point one point.
pub(crate) const STATES: usize = 3;

/// Column that carries derivatives by the parameter; those before it are by the states, in order.
pub(crate) const PARAMETER_COLUMN: usize = STATES;

/// A model with one contact and three states, and the parameter that is varied.
#[derive(Clone, Debug)]
pub(crate) struct Problem {
    pub model: Model,
    pub parameter: usize,
    pub release: ReleaseEquations,
    pub plain: Follower,
    pub variational: Follower,
    /// Most long flights before chatter.
    pub excursions: usize,
}

impl Problem {
    pub(crate) fn new(model: &Model, spec: &BorderSpec) -> Result<Self, BorderError> {
        let parameter = &*spec.parameter;
        let Some(index) = model.parameter_index(parameter) else {
            return Err(BorderError::UnknownParameter {
                name: parameter.to_owned(),
                nearest: nearest(parameter, model.parameter_names()),
            });
        };
        if model.contacts.len() != 1 {
            let count = model.contacts.len();
            return Err(BorderError::Contacts { count });
        }
        if model.states.len() != STATES {
            let count = model.states.len();
            return Err(BorderError::States { count });
        }
        let mut model = model.clone();
        // Sections would only cut the flights.
        model.sections.clear();
        let mechanics = |error: MechanicsError| BorderError::System(SystemError::Model(error));
        let columns: Vec<Column> = (0..STATES)
            .map(|_| Column::State)
            .chain([Column::Parameter(index)])
            .collect();
        let follower = |columns: &[Column]| -> Result<Follower, BorderError> {
            Ok(Follower {
                system: System::with_columns(&model, columns)?,
                local: LocalTape::new(&model, columns, spec.coordinate).map_err(mechanics)?,
                time: model.time,
            })
        };
        Ok(Self {
            release: ReleaseEquations::new(&model, index).map_err(mechanics)?,
            plain: follower(&[])?,
            variational: follower(&columns)?,
            parameter: index,
            excursions: spec.excursions,
            model,
        })
    }

    /// Position of a state.
    pub(crate) fn state_index(&self, name: &str) -> Result<usize, BorderError> {
        self.model
            .state_index(name)
            .ok_or_else(|| BorderError::UnknownState {
                name: name.to_owned(),
                nearest: nearest(name, self.model.state_names()),
            })
    }

    /// All parameter values with the varied one at `value`.
    pub(crate) fn parameters<R: Real>(&self, value: R) -> Vec<R> {
        self.model.parameter_values(&[(self.parameter, value)])
    }

    /// The release point, near one that is known or searched for.
    pub(crate) fn release_point<R: Real>(
        &self,
        value: R,
        near: Option<&[DoubleDouble]>,
    ) -> Result<ReleasePoint<R>, BorderError> {
        let parameters = self.parameters(value);
        let known = near.and_then(|near| self.release.polish(&parameters, near));
        let rough = self.parameters(value.to_f64());
        self.release.check_forcing(&rough, value.to_f64())?;
        let found = known.or_else(|| {
            let found = self
                .release
                .search(&self.model, &self.plain.system, &rough)?;
            self.release.polish(&parameters, &exactly(&found.state))
        });
        found.ok_or(BorderError::NoRelease {
            value: value.to_f64(),
        })
    }

    /// The impacts after release, without derivatives.
    pub(crate) fn sequence(
        &self,
        value: f64,
        release: &ReleasePoint<f64>,
    ) -> Result<Sequence<f64>, BorderError> {
        let parameters = self.parameters(value);
        self.plain
            .follow(&parameters, &release.state, Until::Verdict(self.excursions))
    }

    /// The impacts from a state, with derivatives by that state and by the parameter.
    pub(crate) fn variation<R: Real>(
        &self,
        parameters: &[R],
        state: &[R],
        impacts: usize,
    ) -> Result<Sequence<R>, BorderError> {
        let start = with_identity(state);
        self.variational
            .follow(parameters, &start, Until::Impacts(impacts))
    }

    /// What the restitution at release determines.
    pub(crate) fn constants<R: Real>(
        value: R,
        release: &ReleasePoint<R>,
    ) -> Result<Constants<R>, BorderError> {
        Constants::new(release.restitution).map_err(|_| BorderError::Restitution {
            value: release.restitution.to_f64(),
            at: value.to_f64(),
        })
    }
}

/// A state followed by the columns of its own variation: unit vectors, then zero for the parameter.
pub(crate) fn with_identity<R: Real>(state: &[R]) -> Vec<R> {
    let mut start = state.to_vec();
    for column in 0..=state.len() {
        start.extend((0..state.len()).map(|i| if i == column { R::ONE } else { R::ZERO }));
    }
    start
}

/// The same numbers in double-double.
pub(crate) fn exactly<R: Real>(values: &[R]) -> Vec<DoubleDouble> {
    values.iter().map(|x| x.to_double_double()).collect()
}
