//! A model and one of its parameters, compiled for the search of border orbits.

use super::coordinate::local::LocalTape;
use super::coordinate::sequence::{Follower, Impact, Sequence, Until, Verdict};
use super::error::{BorderError, Lack, Named};
use super::release::equations::{CONDITIONS, Place, ReleaseEquations, ReleasePoint};
use super::spec::BorderSpec;
use crate::analysis::universal::Constants;
use crate::flow::{Column, System, SystemError, with_identity};
use crate::model::{MechanicsError, Model};
use crate::numerics::Real;

/// Gap, rate and acceleration that vanish where contact ends: with fewer states there is no such point.
const FEWEST_STATES: usize = CONDITIONS;

/// Contact ends at a release point if it ends this near to it, relative to the size of the states: event location and
/// Newton's method agree to rounding.
const SAME_RELEASE: f64 = 1e-6;

/// A model and the parameter that is varied. Derivatives have a column for each state, in order, and one for the parameter.
#[derive(Clone, Debug)]
pub(crate) struct Problem {
    pub model: Model,
    pub parameter: usize,
    /// For each contact where it ends.
    pub releases: Vec<ReleaseEquations>,
    pub plain: Follower,
    pub variational: Follower,
    /// Most long flights before chatter.
    pub excursions: usize,
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
        if model.states.len() < FEWEST_STATES {
            let count = model.states.len();
            return Err(BorderError::States { count });
        }
        let mut model = model.with_whole_exponents(&[index]);
        // Sections would only cut the flights, but for those that change the state.
        model.sections.retain(|section| section.reset.is_some());
        let mechanics = |error: MechanicsError| BorderError::System(SystemError::Model(error));
        let columns = columns(&model, index);
        let contacts = 0..model.contacts.len();
        let follower = |columns: &[Column]| -> Result<Follower, BorderError> {
            let local = |contact| LocalTape::new(&model, contact, columns, spec.coordinate);
            Ok(Follower {
                system: System::with_columns(&model, columns)?,
                locals: (contacts.clone().map(local).collect::<Result<_, _>>())
                    .map_err(mechanics)?,
                time: model.time,
            })
        };
        let equations = |contact| ReleaseEquations::new(&model, index, contact);
        Ok(Self {
            releases: (contacts.clone().map(equations).collect::<Result<_, _>>())
                .map_err(mechanics)?,
            plain: follower(&[])?,
            variational: follower(&columns)?,
            parameter: index,
            excursions: spec.excursions,
            model,
        })
    }

    /// All parameter values with the varied one at `value`.
    pub(crate) fn parameters<R: Real>(&self, value: R) -> Vec<R> {
        self.model.parameter_values(&[(self.parameter, value)])
    }

    /// How many states there are.
    pub(crate) fn states(&self) -> usize {
        self.model.states.len()
    }

    /// How many coordinates release points have on their surface.
    pub(crate) fn dimensions(&self) -> usize {
        self.states() - CONDITIONS
    }

    /// All release points at a parameter value: at least one.
    pub(crate) fn release_points(&self, value: f64) -> Result<Vec<ReleasePoint<f64>>, BorderError> {
        let parameters = self.parameters(value);
        let mut found = Vec::new();
        for release in &self.releases {
            release.check_forcing(&parameters, value)?;
            found.extend(match self.dimensions() {
                0 => release.all(&self.model, &self.plain.system, &parameters),
                _ => self.settled(value, release)?,
            });
        }
        if found.is_empty() {
            return Err(Lack::Release.at(value));
        }
        Ok(found)
    }

    /// The release point near one that is known, with its coordinates.
    pub(crate) fn release_point<R: Real>(
        &self,
        value: R,
        near: &Place,
    ) -> Result<ReleasePoint<R>, BorderError> {
        let rough = value.to_f64();
        let release = &self.releases[near.contact];
        release.check_forcing(&self.parameters(rough), rough)?;
        (release.polish(&self.parameters(value), near)).ok_or_else(|| Lack::Release.at(value))
    }

    /// The impacts after release up to the end of the first chatter sequence, without derivatives. One that belongs to another
    /// release point and ends in flight is a part of the way, complete chatter there the end of it.
    pub(crate) fn sequence(
        &self,
        value: f64,
        release: &ReleasePoint<f64>,
    ) -> Result<Sequence<f64>, BorderError> {
        let parameters = self.parameters(value);
        let start = (release.contact, &*release.state);
        let mut after = 0;
        loop {
            let until = Until {
                excursions: self.excursions,
                after,
                ..Until::NEVER
            };
            let mut sequence = self.plain.follow(&parameters, start, until)?;
            if self.dimensions() > 0 || self.leads_back(&sequence, &parameters, release) {
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

    /// Where the contact is released that chatter ends in, or would if it lasted from the last impact on that presses; `None`
    /// if there is none.
    pub(crate) fn released(
        &self,
        sequence: &Sequence<f64>,
        parameters: &[f64],
        contact: usize,
    ) -> Option<Vec<f64>> {
        if sequence.verdict == Verdict::Complete {
            return sequence.released.clone();
        }
        let presses = |impact: &&Impact<f64>| impact.local.acceleration < 0.0;
        let last = sequence.impacts.iter().rev().find(presses)?;
        let rest = self.releases[contact].brought_to_rest(&last.state, parameters);
        (self.plain).contact_until_release(parameters, (contact, &rest))
    }

    /// Whether contact from the last impact on that presses would last until this release point: to it belongs the chatter
    /// that ends there, in contact or in flight.
    fn leads_back(
        &self,
        sequence: &Sequence<f64>,
        parameters: &[f64],
        release: &ReleasePoint<f64>,
    ) -> bool {
        let equations = &self.releases[release.contact];
        match self.released(sequence, parameters, release.contact) {
            Some(state) => equations.apart(&state, &release.state, parameters).1 <= SAME_RELEASE,
            None => true,
        }
    }

    /// The impacts from a state, with derivatives by that state and by the parameter: so many, or fewer if chatter ends
    /// earlier, though after impact number `after`.
    pub(crate) fn variation<R: Real>(
        &self,
        parameters: &[R],
        (contact, state): (usize, &[R]),
        after: usize,
        impacts: usize,
    ) -> Result<Sequence<R>, BorderError> {
        let start = with_identity(state, self.states() + 1);
        let until = Until {
            impacts,
            after,
            ..Until::NEVER
        };
        self.variational
            .follow(parameters, (contact, &start), until)
    }

    /// What the restitution at release determines.
    pub(crate) fn constants<R: Real>(
        value: R,
        release: &ReleasePoint<R>,
    ) -> Result<Constants<R>, BorderError> {
        let restitution = release.restitution.to_f64();
        Constants::new(release.restitution).map_err(|_| Lack::Restitution(restitution).at(value))
    }
}

/// Derivatives by all states, then by a parameter.
pub(crate) fn columns(model: &Model, parameter: usize) -> Vec<Column> {
    (model.states.iter().map(|_| Column::State))
        .chain([Column::Parameter(parameter)])
        .collect()
}
