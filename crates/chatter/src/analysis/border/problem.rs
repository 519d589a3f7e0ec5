//! A model and one of its parameters, compiled for border orbits; and the same at a value of the parameter.

use super::coordinate::local::LocalTape;
use super::coordinate::sequence::{Follower, Sequence, Until};
use super::error::{BorderError, Lack, Named};
use super::release::equations::{CONDITIONS, ReleaseEquations};
use super::spec::BorderSpec;
use crate::analysis::periodic::closure::{Closure, Turn};
use crate::flow::{Column, System, SystemError, columns, with_identity};
use crate::model::{Mechanics, Model};
use crate::numerics::Real;

/// A model and the parameter that is varied. Derivatives have a column for each state, in order, and one for the parameter.
#[derive(Clone, Debug)]
pub(crate) struct Problem {
    pub model: Model,
    pub mechanics: Mechanics,
    pub parameter: usize,
    pub spec: BorderSpec,
    /// For each contact where it ends.
    pub releases: Vec<ReleaseEquations>,
    /// The phases of a forcing; none where the equations have no period.
    pub closure: Option<Closure>,
    pub plain: Follower,
    variational: Follower,
}

/// The problem at a value of the parameter.
#[derive(Clone, Debug)]
pub(crate) struct Here<'p, R> {
    pub problem: &'p Problem,
    pub value: R,
    /// All parameter values.
    pub parameters: Vec<R>,
    pub closure: &'p Closure,
    /// The phases, which the equations know up to whole periods.
    pub phases: Vec<Turn<R>>,
}

impl Problem {
    pub(crate) fn new(model: &Model, spec: &BorderSpec) -> Result<Self, BorderError> {
        let parameter = &*spec.parameter;
        let Some(index) = model.parameter_index(parameter) else {
            let known = model.parameter_names();
            return Err(BorderError::unknown(Named::Parameter, parameter, known));
        };
        if model.contacts.is_empty() {
            return Err(BorderError::NoContact);
        }
        if model.states.len() < CONDITIONS {
            let count = model.states.len();
            return Err(BorderError::States { count });
        }
        let mut model = model.with_telling_numbers(&[index]);
        // Sections would only cut the flights, but for those that change the state.
        model.sections.retain(|section| section.reset.is_some());
        let mechanics = Mechanics::new(&model).map_err(SystemError::Model)?;
        let contacts = 0..model.contacts.len();
        let follower = |columns: &[Column]| -> Result<Follower, BorderError> {
            let local =
                |contact| LocalTape::new((&model, &mechanics), contact, columns, spec.coordinate);
            Ok(Follower {
                system: System::with_columns(&model, columns)?,
                locals: contacts.clone().map(local).collect(),
            })
        };
        let release = |contact| ReleaseEquations::new(&model, &mechanics, index, contact);
        let closure = Closure::with_section(&model, &[index], None, None).ok();
        Ok(Self {
            releases: contacts.clone().map(release).collect(),
            closure: closure.map(|(closure, _)| closure),
            plain: follower(&[])?,
            variational: follower(&columns(model.states.len(), &[index]))?,
            parameter: index,
            spec: spec.clone(),
            mechanics,
            model,
        })
    }

    /// At a value of the parameter: fails where the equations never return to what they were.
    pub(crate) fn at<R: Real>(&self, value: R) -> Result<Here<'_, R>, BorderError> {
        let parameters = self.model.parameter_values(&[(self.parameter, value)]);
        let lacks = || Lack::Period.at(value);
        let closure = self.closure.as_ref().ok_or_else(lacks)?;
        let phases = closure.turns(&parameters).map_err(|_| lacks())?;
        Ok(Here {
            problem: self,
            value,
            parameters,
            closure,
            phases,
        })
    }

    /// How many states there are.
    pub(crate) fn states(&self) -> usize {
        self.model.states.len()
    }

    /// How many coordinates release points have on their surface.
    pub(crate) fn dimensions(&self) -> usize {
        self.states() - CONDITIONS
    }
}

impl<R: Real> Here<'_, R> {
    /// That something is missing here.
    pub(crate) fn lacks(&self, what: Lack) -> BorderError {
        what.at(self.value)
    }

    /// The impacts from a state, with derivatives by that state and by the parameter: so many, or fewer if chatter ends
    /// earlier, though after impact number `after`.
    pub(crate) fn variation(
        &self,
        (contact, state): (usize, &[R]),
        after: usize,
        impacts: usize,
    ) -> Result<Sequence<R>, BorderError> {
        let start = with_identity(state, self.problem.states() + 1);
        let until = Until {
            impacts,
            after,
            ..Until::NEVER
        };
        let sequence =
            (self.problem.variational).follow(&self.parameters, (contact, &start), until);
        sequence.map_err(|error| self.lacks(Lack::Motion(error)))
    }
}

impl Here<'_, f64> {
    /// The impacts from a state, without derivatives.
    pub(crate) fn follow(
        &self,
        start: (usize, &[f64]),
        until: Until,
    ) -> Result<Sequence<f64>, BorderError> {
        let sequence = self.problem.plain.follow(&self.parameters, start, until);
        sequence.map_err(|error| self.lacks(Lack::Motion(error)))
    }
}
