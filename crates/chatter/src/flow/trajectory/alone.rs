//! A step of one trajectory alone, with what it changes if it is an ordinary one: one kernel, so that all of it is compiled for what
//! the processor offers.

use super::ordinary::Bounce;
use super::{StepResult, Trajectory};
use crate::flow::modes::program::Program;
use crate::flow::step::Workspace;
use crate::flow::system::System;
use crate::numerics::Real;
use crate::numerics::dispatch::Kernel;

pub(super) struct StepAlone<'a, R: Real> {
    pub trajectory: &'a mut Trajectory<R>,
    pub system: &'a System,
    pub work: &'a mut Workspace<R>,
    pub program: &'a Program,
}

/// What became of the trajectory.
pub(super) enum Stepped<R> {
    /// An ordinary step, and what is to be told of it.
    Ordinary(Option<Bounce<R>>),
    /// Something else, of which the mode machine knows more; the state is in place.
    Event(StepResult<R>),
    /// A step that could not be certified; nothing is changed.
    Uncertain,
}

impl<R: Real> Kernel for StepAlone<'_, R> {
    type Output = Stepped<R>;

    #[inline(always)]
    fn run(self) -> Stepped<R> {
        let Self {
            trajectory,
            system,
            work,
            program,
        } = self;
        let class = trajectory.load(work);
        if !work.try_step(program, class, trajectory.touching) {
            return Stepped::Uncertain;
        }
        let mut result = trajectory.result(work);
        let gap = |slot, roots| work.value_at_end(&program.tape, slot, roots);
        result.gap = trajectory.gap_at_end((program, trajectory.touching), &result, gap);
        trajectory.accept(work);
        match trajectory.digest_ordinary(system, program, &result) {
            Some(told) => Stepped::Ordinary(told),
            None => Stepped::Event(result),
        }
    }
}
