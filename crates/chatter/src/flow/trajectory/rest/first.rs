//! Where contacts of a model first rest along its own motion.

use crate::flow::error::FlowError;
use crate::flow::modes::closed::Grip;
use crate::flow::occurrence::Occurrence;
use crate::flow::system::System;

/// So many steps of that motion show it, or nearly do.
const STEPS: usize = 10_000;

impl System {
    /// The first mode in which something rests along the motion from the model's initial state, at its own parameters; where nothing
    /// ever does, that of the slowest impact, which comes nearest to it.
    ///
    /// # Errors
    /// The motion cannot start there.
    pub(crate) fn first_rest(&self) -> Result<usize, FlowError> {
        let model = self.model();
        let parameters = model.parameter_values::<f64>(&[]);
        let (mut work, mut trajectory) =
            self.trajectory_from(&parameters, &model.initial_state(&parameters))?;
        let (mut nearest, mut slowest) = (trajectory.mode, f64::INFINITY);
        for _ in 0..STEPS {
            let here = self.origin_of(trajectory.mode);
            if here.is_some_and(|(grip, ..)| grip != Grip::NONE) {
                return Ok(trajectory.mode);
            }
            match trajectory.advance_to_horizon(self, &mut work) {
                Ok(Some(Occurrence::Impact { rate_after, .. })) if rate_after < slowest => {
                    (nearest, slowest) = (trajectory.mode, rate_after);
                }
                Ok(_) => {}
                Err(_) => break,
            }
        }
        Ok(nearest)
    }
}
