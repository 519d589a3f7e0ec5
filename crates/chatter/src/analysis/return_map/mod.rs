//! The map of a flow from one look at it to the next: Poincaré, impact and stroboscopic maps.
//!
//! ```text
//! ReturnSpec       at which events or times, how long a return may take
//! ReturnMap        a Map: points are states of the model
//!   phases         which coordinates are phases, and how time goes on at other parameters
//!   follow         hundreds of orbits in one fleet, so that SIMD lanes stay full
//!   tangent        its tangent map: orbits that carry a displacement along
//! ```

mod follow;
mod look;
mod phases;
mod spec;
mod tangent;
pub(crate) mod translations;

#[cfg(test)]
mod tests;

pub use spec::{ReturnMapError, ReturnSpec, Sampling};

use crate::analysis::map::{
    Arrival, Carry, Command, CoordinateKind, Map, NoReturn, Passage, PhaseLost, Scope, Start,
    next_of_follow,
};
use crate::analysis::simulate::check_tolerance;
use crate::flow::{Settings, System, Workspace};
use crate::model::Model;
use core::sync::atomic::AtomicBool;
use follow::{Follower, Spare};
use look::Look;
use phases::Phases;
use tangent::TangentReturnMap;

/// A model looked at where a [`ReturnSpec`] says.
#[derive(Clone, Debug)]
pub struct ReturnMap {
    model: Model,
    system: System,
    settings: Settings,
    look: Look,
    phases: Phases,
    longest_return: f64,
    most_impacts: u64,
    spare: Spare,
}

impl ReturnMap {
    /// Compiles a model for its return map.
    ///
    /// # Errors
    /// The specification is wrong by itself or does not fit the model, or the model cannot be compiled.
    pub fn new(model: &Model, spec: &ReturnSpec) -> Result<Self, ReturnMapError> {
        if !(spec.longest_return > 0.0 && spec.longest_return.is_finite()) {
            return Err(ReturnMapError::LongestReturn {
                value: spec.longest_return,
            });
        }
        if spec.most_impacts == 0 {
            return Err(ReturnMapError::NoImpacts);
        }
        check_tolerance(spec.tolerance).map_err(ReturnMapError::Tolerance)?;
        let mut model = model.clone();
        let look = Look::new(&spec.sampling, &mut model)?;
        let system = System::new(&model).map_err(ReturnMapError::System)?;
        let phases = Phases::new(&model);
        Ok(Self {
            model,
            system,
            settings: Settings {
                tolerance: spec.tolerance,
                ..Settings::default()
            },
            look,
            phases,
            longest_return: spec.longest_return,
            most_impacts: spec.most_impacts,
            spare: Spare::default(),
        })
    }

    /// The model, with the sections that are looked at.
    pub fn model(&self) -> &Model {
        &self.model
    }

    fn workspace(&self) -> Workspace<f64> {
        self.system.workspace(&self.settings)
    }

    /// The time from look to look at these parameters, if that is fixed.
    fn period(&self, parameters: &[f64]) -> Option<f64> {
        match &self.look {
            Look::Stroboscopic { period } => Some(follow::strobe_period(period, parameters).high()),
            Look::Event { .. } => None,
        }
    }
}

impl ReturnMapError {
    /// The name that is probably meant, where one is unknown.
    pub fn suggestion(&self) -> Option<String> {
        match self {
            Self::UnknownPlace(error) => error.suggestion(),
            _ => None,
        }
    }
}

impl Map for ReturnMap {
    fn coordinates(&self) -> Vec<String> {
        let states = self.model.states.iter();
        states.map(|state| state.name.clone()).collect()
    }

    fn parameters(&self) -> Vec<String> {
        let parameters = self.model.parameters.iter();
        parameters.map(|parameter| parameter.name.clone()).collect()
    }

    fn parameter_values(&self, swept: &[(usize, f64)]) -> Vec<f64> {
        self.model.parameter_values(swept)
    }

    fn initial_point(&self, parameters: &[f64]) -> Vec<f64> {
        self.model.initial_state(parameters)
    }

    fn coordinate_kinds(&self, parameters: &[f64]) -> Vec<CoordinateKind> {
        self.phases
            .kinds(&self.model, parameters, self.period(parameters))
    }

    fn check_carry(&self, swept: &[usize], values: &[Vec<f64>]) -> Result<(), PhaseLost> {
        let Some(time) = self.model.time else {
            return Ok(());
        };
        let moving = self.model.with_dependents(swept);
        let look = |parameters: &[f64]| self.period(parameters);
        if self.phases.can_carry(&self.model, &moving, values, &look) {
            return Ok(());
        }
        Err(PhaseLost {
            coordinate: self.model.states[time].name.clone(),
            parameters: (swept.iter())
                .map(|&index| self.model.parameters[index].name.clone())
                .collect(),
        })
    }

    fn carried(&self, carry: &Carry<'_>) -> Vec<f64> {
        let periods = self.period(carry.before).zip(self.period(carry.after));
        self.phases.carried(&self.model, carry, periods)
    }

    fn scope(&self) -> Scope {
        let mut scope = Scope {
            graph: self.model.graph.clone(),
            names: Vec::new(),
        };
        for (index, name) in self.coordinates().into_iter().enumerate() {
            let state = scope.graph.state(index);
            scope.names.push((name, state));
        }
        for (index, name) in self.parameters().into_iter().enumerate() {
            let parameter = scope.graph.parameter(index);
            scope.names.push((name, parameter));
        }
        for definition in &self.model.definitions {
            scope
                .names
                .push((definition.name.clone(), definition.value));
        }
        scope
    }

    fn on_the_way(&self, parameters: &[f64], from: &[f64], duration: f64) -> Vec<f64> {
        follow::on_the_way(self, parameters, from, duration)
    }

    fn tangent(&self, swept: &[usize]) -> Option<Box<dyn Map + '_>> {
        Some(Box::new(TangentReturnMap::of(self, swept).ok()?))
    }

    fn next(&self, parameters: &[f64], point: &mut [f64]) -> Result<Passage, NoReturn> {
        next_of_follow(self, parameters, point)
    }

    fn follow(
        &self,
        swept: &[usize],
        starts: &[Start],
        stop: &AtomicBool,
        visit: &mut dyn FnMut(Arrival<'_>) -> Command,
    ) {
        Follower::new(self, swept, visit).run(starts, stop);
    }
}
