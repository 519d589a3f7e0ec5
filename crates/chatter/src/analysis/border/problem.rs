//! A model and one of its parameters, compiled for the search of border orbits.

use super::coordinate::local::LocalTape;
use super::coordinate::sequence::{Follower, Impact, Sequence, Until, Verdict};
use super::error::BorderError;
use super::release::equations::{ReleaseEquations, ReleasePoint};
use super::spec::BorderSpec;
use crate::analysis::universal::Constants;
use crate::expressions::nearest;
use crate::flow::{Column, System, SystemError, with_identity};
use crate::model::{MechanicsError, Model};
use crate::numerics::{DoubleDouble, Real};

/// Border orbits have three states: only then is the release point one point.
pub(crate) const STATES: usize = 3;

/// Column that carries derivatives by the parameter; those before it are by the states, in order.
pub(crate) const PARAMETER_COLUMN: usize = STATES;

/// Contact ends at a release point if it ends this near to it, relative to the size of the states: event location and
/// Newton's method agree to rounding.
const SAME_RELEASE: f64 = 1e-6;

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

    /// All release points at a parameter value: at least one.
    pub(crate) fn release_points(&self, value: f64) -> Result<Vec<ReleasePoint<f64>>, BorderError> {
        let parameters = self.parameters(value);
        self.release.check_forcing(&parameters, value)?;
        let found = (self.release).all(&self.model, &self.plain.system, &parameters);
        if found.is_empty() {
            return Err(BorderError::NoRelease { value });
        }
        Ok(found)
    }

    /// The release point near one that is known.
    pub(crate) fn release_point<R: Real>(
        &self,
        value: R,
        near: &[DoubleDouble],
    ) -> Result<ReleasePoint<R>, BorderError> {
        let rough = value.to_f64();
        self.release.check_forcing(&self.parameters(rough), rough)?;
        (self.release.polish(&self.parameters(value), near))
            .ok_or(BorderError::NoRelease { value: rough })
    }

    /// The impacts after release up to the end of the first chatter sequence, without derivatives. `several` tells whether
    /// there may be other release points: a sequence that belongs to one of them and ends in flight is a part of the way,
    /// complete chatter there the end of it.
    pub(crate) fn sequence(
        &self,
        value: f64,
        release: &ReleasePoint<f64>,
        several: bool,
    ) -> Result<Sequence<f64>, BorderError> {
        let parameters = self.parameters(value);
        let mut after = 0;
        loop {
            let until = Until::Verdict {
                excursions: self.excursions,
                after,
            };
            let mut sequence = self.plain.follow(&parameters, &release.state, until)?;
            if !several || self.leads_back(&sequence, &parameters, release) {
                return Ok(sequence);
            }
            match sequence.verdict {
                Verdict::Incomplete => after = sequence.impacts.len(),
                Verdict::Complete => {
                    sequence.verdict = Verdict::Elsewhere;
                    return Ok(sequence);
                }
                _ => return Ok(sequence),
            }
        }
    }

    /// Whether contact from the last impact on that presses would last until this release point: to it belongs the chatter
    /// that ends there, in contact or in flight.
    fn leads_back(
        &self,
        sequence: &Sequence<f64>,
        parameters: &[f64],
        release: &ReleasePoint<f64>,
    ) -> bool {
        let presses = |impact: &&Impact<f64>| impact.local.acceleration < 0.0;
        let Some(last) = sequence.impacts.iter().rev().find(presses) else {
            return true;
        };
        let rest = self.release.brought_to_rest(&last.state, parameters);
        match self.plain.contact_until_release(parameters, &rest) {
            Some(state) => self.release.apart(&state, &release.state, parameters) <= SAME_RELEASE,
            None => true,
        }
    }

    /// The impacts from a state, with derivatives by that state and by the parameter: so many, or fewer if chatter ends
    /// earlier, though after impact number `after`.
    pub(crate) fn variation<R: Real>(
        &self,
        parameters: &[R],
        state: &[R],
        after: usize,
        impacts: usize,
    ) -> Result<Sequence<R>, BorderError> {
        let start = with_identity(state, PARAMETER_COLUMN + 1);
        let until = Until::Impacts {
            most: impacts,
            after,
        };
        self.variational.follow(parameters, &start, until)
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

/// The same numbers in double-double.
pub(crate) fn exactly<R: Real>(values: &[R]) -> Vec<DoubleDouble> {
    values.iter().map(|x| x.to_double_double()).collect()
}
