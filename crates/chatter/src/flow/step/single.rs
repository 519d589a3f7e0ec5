//! What one trajectory asks of its workspace beside its steps.

use super::Workspace;
use crate::expressions::Tape;
use crate::flow::modes::program::{Program, ProgramConstants};
use crate::numerics::dispatch::{Kernel, dispatch_narrow};
use crate::numerics::{Mask, Real};

/// What one trajectory asks for beside its steps: one kernel, so that the interpreter is compiled once.
enum Task<'a, R> {
    /// The expansion of a step alone.
    Expansion(&'a Program, usize),
    /// An expansion of the lowest order from another state, which leaves that of the step as it is.
    Point {
        tape: &'a Tape,
        constants: &'a [R],
        state: &'a [R],
        low: &'a [R],
        tau: R,
    },
    /// The outputs of a tape at a state and its remainders.
    Values {
        tape: &'a Tape,
        constants: &'a [R],
        state: &'a [R],
        low: &'a [R],
        values: &'a mut [R],
    },
}

struct Single<'w, 'a, R: Real> {
    work: &'w mut Workspace<R>,
    task: Task<'a, R>,
}

impl<R: Real> Kernel for Single<'_, '_, R> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { work, task } = self;
        match task {
            Task::Expansion(program, class) => work.expand(program, class),
            Task::Point {
                tape,
                constants,
                state,
                low,
                tau,
            } => (work.point).run(tape, constants, state, low, tau, R::ORDERS[0]),
            Task::Values {
                tape,
                constants,
                state,
                low,
                values,
            } => work.point.evaluate(tape, constants, state, low, values),
        }
    }
}

impl<R: Real> Workspace<R> {
    /// Expands, and leaves what follows to the caller.
    pub(crate) fn expand_only(&mut self, program: &Program, class: usize) {
        self.run(Task::Expansion(program, class));
    }

    /// Expands to the lowest order from a state and its remainders, into [`point`](Self::point).
    pub(crate) fn expand_at(
        &mut self,
        tape: &Tape,
        constants: &[R],
        (state, low): (&[R], &[R]),
        tau: R,
    ) {
        self.run(Task::Point {
            tape,
            constants,
            state,
            low,
            tau,
        });
    }

    /// Values of a tape's outputs at a point.
    pub(crate) fn values_at(
        &mut self,
        tape: &Tape,
        constants: &[R],
        (state, low): (&[R], &[R]),
        values: &mut [R],
    ) {
        self.run(Task::Values {
            tape,
            constants,
            state,
            low,
            values,
        });
    }

    fn run(&mut self, task: Task<'_, R>) {
        dispatch_narrow(Single { work: self, task });
    }

    /// Whether arguments that must not vanish are told from zero.
    pub(crate) fn is_clear(&self) -> bool {
        self.clear
    }

    /// Which of the program's singular points the expansion reaches no further for than `scaled_step`, and how far away it is.
    pub(crate) fn singularity(&mut self, program: &Program) -> Option<(usize, R)> {
        let step = self.scaled_step;
        let (which, reach) = (self.expansion).singularity(&program.tape, &self.constants, step)?;
        Some((which, reach * self.tau))
    }

    /// Whether a series of the latest expansion is told from zero at its start, by the bounds of its rounding.
    pub(crate) fn is_told(&mut self, program: &Program, slot: usize) -> bool {
        (self.expansion)
            .is_told(&program.tape, &self.constants, slot)
            .all()
    }

    /// Which of the program's singular points is not positive, or cannot be told from zero, or is nearer by its rate than the shortest step
    /// that was tried: that which is nearest, where series say no more.
    pub(crate) fn vanishing(&self, program: &Program) -> Option<usize> {
        let distance = |slot: usize| {
            let series = self.expansion.series(slot);
            let terms = (self.expansion).size_of_terms(&program.tape, &self.constants, slot);
            let distance = (series[0].abs() / series[1]).abs().to_f64();
            let vanishes = series[0] <= terms * R::splat(Self::NOISE) || distance <= 1.0;
            vanishes.then_some(if distance.is_nan() {
                f64::INFINITY
            } else {
                distance
            })
        };
        (program.tape.singular.iter().enumerate())
            .filter_map(|(which, singular)| Some((which, distance(singular.slot)?)))
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .map(|(which, _)| which)
    }

    /// Sets the constants of a program for a single trajectory.
    #[inline(always)]
    pub(crate) fn load_constants(&mut self, constants: &ProgramConstants<R>) {
        if self.edition != Some(constants.edition) {
            self.edition = Some(constants.edition);
            self.constants.clone_from(&constants.tape);
            self.impact_constants.clone_from(&constants.impacts);
        }
    }
}
