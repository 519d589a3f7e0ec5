//! The tangent map of a return map.

use super::ReturnMap;
use super::follow::Follower;
use crate::analysis::map::{
    Arrival, Command, Map, NoReturn, Passage, Start, displaced_names, displaced_point,
    next_of_follow,
};
use crate::flow::{Column, System, SystemError};
use core::sync::atomic::AtomicBool;

/// A return map whose flow carries one displacement along by the variational equation (MATH.md 6).
#[derive(Debug)]
pub(super) struct TangentReturnMap(ReturnMap);

impl TangentReturnMap {
    /// That of a map whose orbits differ in these parameters.
    pub(super) fn of(map: &ReturnMap, swept: &[usize]) -> Result<Self, SystemError> {
        let model = map.model.with_telling_numbers(swept);
        let system = System::with_columns(&model, &[Column::State])?;
        Ok(Self(ReturnMap {
            model,
            system,
            ..map.clone()
        }))
    }
}

impl Map for TangentReturnMap {
    fn coordinates(&self) -> Vec<String> {
        displaced_names(self.0.coordinates())
    }

    fn parameters(&self) -> Vec<String> {
        self.0.parameters()
    }

    fn parameter_values(&self, swept: &[(usize, f64)]) -> Vec<f64> {
        self.0.parameter_values(swept)
    }

    fn initial_point(&self, parameters: &[f64]) -> Vec<f64> {
        displaced_point(self.0.initial_point(parameters))
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
        Follower::new(&self.0, swept, visit).run(starts, stop);
    }
}
