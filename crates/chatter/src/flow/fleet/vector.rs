//! One step of a vector of trajectories: what each brings is laid side by side, the step is made, what is ordinary in it decided for
//! all lanes at once, and each gets its own back.

use super::shared::{Rows, Shared};
use crate::flow::flight::{Course, Flight, Outcome, largest, plan, reaches, remaining};
use crate::flow::guard::Transition;
use crate::flow::occurrence::Occurrence;
use crate::flow::program::{Closed, IMPACT_SCALARS, Program};
use crate::flow::step::{NO_EVENT, Workspace};
use crate::flow::system::{Settings, System};
use crate::flow::touching::Touching;
use crate::flow::trajectory::{StepResult, Trajectory};
use crate::numerics::dispatch::{Kernel, dispatch};
use crate::numerics::{LaneMask, Lanes, Mask, Scalar};

/// A vector of trajectories. Those of a fleet take turns in it.
#[derive(Debug)]
pub(super) struct Vector<'a, const L: usize> {
    system: &'a System,
    work: Workspace<Lanes<L>>,
    /// Parameters that differ between the trajectories.
    swept: Vec<usize>,
    /// By number of the mode.
    shared: Vec<Option<Shared<L>>>,
    rows: Rows,
    /// The mode whose constants the workspace holds.
    loaded: Option<usize>,
    flight: Flight<Lanes<L>>,
    verdict: Verdict<L>,
}

/// What is known of each lane after a step.
#[derive(Debug)]
struct Verdict<const L: usize> {
    /// Where the step is certain.
    certain: LaneMask<L>,
    /// Where it is an ordinary one, too, with what it came to.
    ordinary: LaneMask<L>,
    course: Course<Lanes<L>>,
    /// Where time is left then, with the order class of the next step and its unit of time.
    goes_on: LaneMask<L>,
    class: Lanes<L>,
    unit: Lanes<L>,
}

/// What became of a trajectory in a lane.
pub(super) enum Ended {
    /// An ordinary step.
    Ordinary {
        /// The guard that ended it.
        at: Option<usize>,
        /// What is to be told of it.
        told: Option<Occurrence<f64>>,
        /// Order class and unit of time of its next step; none where its time is over.
        next: Option<(usize, f64)>,
    },
    /// Something else, of which the mode machine knows more; the state is in place.
    Digest(StepResult<f64>),
    /// A step that could not be certified; nothing is changed.
    Uncertain,
}

/// The step of a vector. Not generic, so that it is compiled here and not again for every visitor of every user.
pub(super) trait VectorStep<const L: usize> {
    fn make_step(&mut self, program: &Program, class: usize, touching: Touching);
}

macro_rules! vector_step {
    ($width:expr) => {
        impl VectorStep<{ $width }> for Vector<'_, { $width }> {
            fn make_step(&mut self, program: &Program, class: usize, touching: Touching) {
                let coordinates = self.system.coordinates();
                let may_bounce = self.system.corners().is_empty();
                dispatch(LaneStep {
                    work: &mut self.work,
                    flight: &self.flight,
                    verdict: &mut self.verdict,
                    coordinates,
                    may_bounce,
                    program,
                    class,
                    touching,
                })
            }
        }
    };
}

vector_step!(16);
#[cfg(test)]
vector_step!(8);
#[cfg(test)]
vector_step!(4);

struct LaneStep<'a, const L: usize> {
    work: &'a mut Workspace<Lanes<L>>,
    flight: &'a Flight<Lanes<L>>,
    verdict: &'a mut Verdict<L>,
    coordinates: usize,
    may_bounce: bool,
    program: &'a Program,
    class: usize,
    touching: Touching,
}

impl<const L: usize> Kernel for LaneStep<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { work, program, .. } = self;
        work.expand(program, self.class);
        let certain = work.locate(program, self.touching);
        work.finish(program);
        let verdict = self.verdict;
        verdict.certain = certain;
        if !program.is_free {
            verdict.ordinary = LaneMask::splat(false);
            return;
        }
        let nowhere = work.event.less(Lanes::splat(0.0));
        let mut at_impact = LaneMask::splat(false);
        for (index, guard) in program.guards.iter().enumerate() {
            if self.may_bounce && matches!(guard.transition, Transition::Impact { .. }) {
                at_impact = at_impact | work.ends_step(index);
            }
        }
        let (largest, is_finite) = largest(&work.state, self.coordinates);
        let (course, is_ordinary) =
            (self.flight).follow(&work.outcome(), (nowhere, at_impact), largest);
        verdict.ordinary = certain & is_ordinary & is_finite;
        (verdict.class, verdict.unit) = plan(course.flight_time, &work.reach);
        let (horizon, now) = (
            (self.flight.horizon, self.flight.horizon_low),
            (course.time, course.time_low),
        );
        verdict.goes_on = Lanes::splat(0.0).less(remaining(horizon, now));
        verdict.course = course;
    }
}

impl<'a, const L: usize> Vector<'a, L> {
    pub fn new(
        system: &'a System,
        settings: &Settings,
        swept: &[usize],
        trajectories: usize,
    ) -> Self {
        // Each trajectory is on pieces of its own of what is looked up.
        let corners = system.corners();
        let slots = corners.first_slot..corners.first_slot + corners.slots();
        let (zero, nowhere) = (Lanes::splat(0.0), LaneMask::splat(false));
        Self {
            system,
            work: system.workspace(settings),
            swept: (system.model().with_dependents(swept).into_iter())
                .chain(slots)
                .collect(),
            shared: Vec::new(),
            rows: Rows::new(trajectories),
            loaded: None,
            flight: Flight {
                time: zero,
                time_low: zero,
                horizon: zero,
                horizon_low: zero,
                flight_time: zero,
                longest_step: zero,
                restitution: zero,
                border: zero,
            },
            verdict: Verdict {
                certain: nowhere,
                ordinary: nowhere,
                course: Course {
                    time: zero,
                    time_low: zero,
                    flight_time: zero,
                    longest_step: zero,
                    rest_of_sequence: zero,
                },
                goes_on: nowhere,
                class: zero,
                unit: zero,
            },
        }
    }

    /// Loads the constants of a mode that the trajectories share; takes them from any of them.
    pub fn enter(&mut self, mode: usize, program: &Program, any: &Trajectory<f64>) {
        if self.loaded == Some(mode) {
            return;
        }
        if self.shared.len() <= mode {
            self.shared.resize_with(mode + 1, || None);
        }
        if self.shared[mode].is_none()
            && let Some(constants) = &any.constants[mode]
        {
            let shared = Shared::new(self.system, mode, program, &self.swept, constants);
            self.rows.widen(shared.varying());
            self.shared[mode] = Some(shared);
        }
        if let Some(shared) = &self.shared[mode] {
            self.work.constants.clone_from(&shared.tape);
            self.work.impact_constants.clone_from(&shared.impacts);
            self.loaded = Some(mode);
        }
    }

    /// A trajectory may have entered another mode, or have other constants, since it was loaded last.
    pub fn forget(&mut self, index: usize) {
        self.rows.forget(index);
    }

    /// Loads a trajectory, the one with this index, whose next step has this unit of time, into a lane.
    #[inline(always)]
    pub fn load(
        &mut self,
        lane: usize,
        mode: usize,
        (index, trajectory, unit): (usize, &Trajectory<f64>, f64),
    ) {
        let Self { work, flight, .. } = self;
        for (wide, &value) in work.state.iter_mut().zip(&trajectory.state) {
            wide.0[lane] = value;
        }
        for (wide, &value) in work.low.iter_mut().zip(&trajectory.low) {
            wide.0[lane] = value;
        }
        for (section, wide) in work.sides.iter_mut().enumerate() {
            wide.0[lane] = trajectory.sides.get(section);
        }
        for (wide, &value) in work.reach.iter_mut().zip(&trajectory.reach) {
            wide.0[lane] = value;
        }
        let own = trajectory.flight();
        flight.time.0[lane] = own.time;
        flight.time_low.0[lane] = own.time_low;
        flight.horizon.0[lane] = own.horizon;
        flight.horizon_low.0[lane] = own.horizon_low;
        flight.flight_time.0[lane] = own.flight_time;
        flight.longest_step.0[lane] = own.longest_step;
        flight.restitution.0[lane] = own.restitution;
        flight.border.0[lane] = own.border;
        work.tau.0[lane] = unit;
        let Some(shared) = &self.shared[mode] else {
            return;
        };
        let row = self.rows.get(index, shared, &trajectory.constants[mode]);
        let (tape, mut impacts) = row.split_at(shared.varying_tape.len());
        for (&place, &value) in shared.varying_tape.iter().zip(tape) {
            work.constants[place].0[lane] = value;
        }
        for (wide, places) in work
            .impact_constants
            .iter_mut()
            .zip(&shared.varying_impacts)
        {
            for (&place, &value) in places.iter().zip(impacts) {
                wide[place].0[lane] = value;
            }
            impacts = &impacts[places.len()..];
        }
    }

    /// Makes a step with the trajectories of the first lanes; the others repeat the first.
    pub fn step(&mut self, count: usize, program: &Program, class: usize, touching: Touching)
    where
        Self: VectorStep<L>,
    {
        let Self { work, flight, .. } = self;
        if count < L {
            let Flight {
                time,
                time_low,
                horizon,
                horizon_low,
                ..
            } = flight;
            let rows = (work.state.iter_mut())
                .chain(&mut work.low)
                .chain(&mut work.sides)
                .chain(&mut work.reach)
                .chain(&mut work.constants)
                .chain(work.impact_constants.iter_mut().flatten())
                .chain([&mut work.tau, time, time_low, horizon, horizon_low]);
            for wide in rows {
                let first = wide.0[0];
                wide.0[count..].fill(first);
            }
        }
        work.time = flight.time;
        work.horizon = flight.remaining();
        self.make_step(program, class, touching);
    }

    /// Gives the end of a lane's step to its trajectory, as far as it is known.
    #[inline(always)]
    pub fn store(&self, lane: usize, program: &Program, trajectory: &mut Trajectory<f64>) -> Ended {
        let (work, verdict) = (&self.work, &self.verdict);
        if !verdict.certain.lane(lane) {
            return Ended::Uncertain;
        }
        for (value, wide) in trajectory.state.iter_mut().zip(&work.state) {
            *value = wide.0[lane];
        }
        for (value, wide) in trajectory.low.iter_mut().zip(&work.low) {
            *value = wide.0[lane];
        }
        for (section, wide) in work.sides.iter().enumerate() {
            trajectory.sides.set(section, wide.0[lane]);
        }
        for (reach, wide) in trajectory.reach.iter_mut().zip(&work.reach) {
            *reach = wide.0[lane];
        }
        let event = work.event.0[lane];
        let event = (event > NO_EVENT).then_some(event as usize);
        let mut outcome = Outcome {
            step: work.step.0[lane],
            impact: [0.0; IMPACT_SCALARS],
            flight_time: work.flight_time.0[lane],
        };
        for (value, wide) in outcome.impact.iter_mut().zip(&work.impact) {
            *value = wide.0[lane];
        }
        if !verdict.ordinary.lane(lane) {
            let remaining = trajectory.remaining();
            return Ended::Digest(StepResult {
                outcome,
                event,
                touched: None,
                crowd: Closed::NONE,
                jumped: false,
                at_horizon: event.is_none() && reaches(outcome.step, remaining),
            });
        }
        let course = Course {
            time: verdict.course.time.0[lane],
            time_low: verdict.course.time_low.0[lane],
            flight_time: verdict.course.flight_time.0[lane],
            longest_step: verdict.course.longest_step.0[lane],
            rest_of_sequence: verdict.course.rest_of_sequence.0[lane],
        };
        let told = match event {
            Some(index) => trajectory.keep_bounce(&course, (index, program), &outcome.impact),
            None => {
                trajectory.keep_glide(&course, outcome.step);
                None
            }
        };
        let next = verdict
            .goes_on
            .lane(lane)
            .then(|| (verdict.class.0[lane] as usize, verdict.unit.0[lane]));
        Ended::Ordinary {
            at: event,
            told,
            next,
        }
    }
}
