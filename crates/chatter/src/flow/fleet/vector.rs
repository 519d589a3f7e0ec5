//! One step of a vector of trajectories: their rows are laid side by side, the step is made, what is ordinary in it decided for all
//! lanes at once, and each gets its own back.

use super::rows::{Places, Rows};
use super::shared::Shared;
use crate::flow::flight::{Flight, Outcome, largest, plan, reaches, remaining};
use crate::flow::guard::Transition;
use crate::flow::occurrence::Occurrence;
use crate::flow::program::{Closed, IMPACT_SCALARS, Program};
use crate::flow::step::{NO_EVENT, Workspace};
use crate::flow::system::{Settings, System};
use crate::flow::touching::Touching;
use crate::flow::trajectory::{StepResult, Trajectory};
use crate::numerics::dispatch::{Kernel, dispatch};
use crate::numerics::{LaneMask, Lanes, Mask, Scalar, index_of};

/// A vector of trajectories. Those of a fleet take turns in it.
#[derive(Debug)]
pub(super) struct Vector<'a, const L: usize> {
    system: &'a System,
    work: Workspace<Lanes<L>>,
    /// Parameters that differ between the trajectories.
    swept: Vec<usize>,
    /// By number of the mode.
    shared: Vec<Option<Shared<L>>>,
    /// All trajectories, those that are not in the vector, too.
    rows: Rows,
    /// The rows of those that are, side by side: before a step, then after it.
    block: Vec<Lanes<L>>,
    /// The mode whose constants the workspace holds.
    loaded: Option<usize>,
    verdict: Verdict<L>,
}

/// What is known of each lane after a step.
#[derive(Debug)]
struct Verdict<const L: usize> {
    /// Where the step is certain.
    certain: LaneMask<L>,
    /// Where it is an ordinary one, too.
    ordinary: LaneMask<L>,
    /// Where time is left then, with the order class of the next step.
    goes_on: LaneMask<L>,
    class: Lanes<L>,
    /// How long the sequence of impacts may still go on after one.
    rest_of_sequence: Lanes<L>,
}

/// What became of a trajectory in a lane.
pub(super) enum Ended {
    /// An ordinary step, which its row knows of.
    Ordinary {
        /// The guard that ended it.
        at: Option<usize>,
        /// What is to be told of it.
        told: Option<Occurrence<f64>>,
        /// Order class of its next step; none where its time is over.
        next: Option<usize>,
    },
    /// Something else, of which the mode machine knows more; the state is in place.
    Digest(StepResult<f64>),
    /// A step that could not be certified; nothing is changed.
    Uncertain,
}

/// The step of a vector. Not generic, so that it is compiled here and not again for every visitor of every user.
pub(super) trait VectorStep<const L: usize> {
    /// Makes a step with these trajectories, by number, whose mode was entered.
    fn step(
        &mut self,
        members: &[usize; L],
        mode: usize,
        program: &Program,
        class: usize,
        touching: Touching,
    );
}

macro_rules! vector_step {
    ($width:expr) => {
        impl VectorStep<{ $width }> for Vector<'_, { $width }> {
            fn step(
                &mut self,
                members: &[usize; $width],
                mode: usize,
                program: &Program,
                class: usize,
                touching: Touching,
            ) {
                let Some(shared) = self.shared.get(mode).and_then(Option::as_ref) else {
                    self.verdict.certain = LaneMask::splat(false);
                    return;
                };
                dispatch(LaneStep {
                    rows: &mut self.rows,
                    members,
                    shared,
                    block: &mut self.block,
                    work: &mut self.work,
                    verdict: &mut self.verdict,
                    coordinates: self.system.coordinates(),
                    may_bounce: self.system.corners().is_empty(),
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
    rows: &'a mut Rows,
    members: &'a [usize; L],
    shared: &'a Shared<L>,
    block: &'a mut [Lanes<L>],
    work: &'a mut Workspace<Lanes<L>>,
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
        let Self {
            work,
            program,
            block,
            verdict,
            ..
        } = self;
        let places = self.rows.places;
        self.rows.gather(self.members, block);
        load(work, self.shared, (places, block));
        let flight = flight(places, block);
        work.time = flight.time;
        work.horizon = flight.remaining();
        let certain = work.try_step(program, self.class, self.touching);
        store(work, (places, block));
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
        let (course, is_ordinary) = flight.follow(&work.outcome(), (nowhere, at_impact), largest);
        verdict.ordinary = certain & is_ordinary & is_finite;
        (verdict.class, block[places.unit()]) = plan(course.flight_time, &work.reach);
        let (horizon, now) = (
            (flight.horizon, flight.horizon_low),
            (course.time, course.time_low),
        );
        verdict.goes_on = Lanes::splat(0.0).less(remaining(horizon, now));
        verdict.rest_of_sequence = course.rest_of_sequence;
        block[places.time()] = course.time;
        block[places.time_low()] = course.time_low;
        block[places.flight_time()] = course.flight_time;
        block[places.longest_step()] = course.longest_step;
        (self.rows).scatter(self.members, block, verdict.ordinary);
    }
}

/// Puts rows that stand side by side where a step expects them.
#[inline(always)]
fn load<const L: usize>(
    work: &mut Workspace<Lanes<L>>,
    shared: &Shared<L>,
    (places, block): (Places, &[Lanes<L>]),
) {
    work.state.copy_from_slice(&block[places.state()]);
    work.low.copy_from_slice(&block[places.low()]);
    work.sides.copy_from_slice(&block[places.sides()]);
    work.reach.copy_from_slice(&block[places.reach()]);
    work.tau = block[places.unit()];
    let (tape, mut impacts) = block[places.constants()..].split_at(shared.varying_tape.len());
    for (&place, &value) in shared.varying_tape.iter().zip(tape) {
        work.constants[place] = value;
    }
    let constants = work.impact_constants.iter_mut();
    for (wide, places) in constants.zip(&shared.varying_impacts) {
        for (&place, &value) in places.iter().zip(impacts) {
            wide[place] = value;
        }
        impacts = &impacts[places.len()..];
    }
}

/// Puts back what any step changes.
#[inline(always)]
fn store<const L: usize>(work: &Workspace<Lanes<L>>, (places, block): (Places, &mut [Lanes<L>])) {
    block[places.state()].copy_from_slice(&work.state);
    block[places.low()].copy_from_slice(&work.low);
    block[places.sides()].copy_from_slice(&work.sides);
    block[places.reach()].copy_from_slice(&work.reach);
}

#[inline(always)]
fn flight<const L: usize>(places: Places, block: &[Lanes<L>]) -> Flight<Lanes<L>> {
    Flight {
        time: block[places.time()],
        time_low: block[places.time_low()],
        horizon: block[places.horizon()],
        horizon_low: block[places.horizon_low()],
        flight_time: block[places.flight_time()],
        longest_step: block[places.longest_step()],
        restitution: block[places.restitution()],
        border: block[places.border()],
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
        let rows = Rows::new((system.dimension(), system.sections()), trajectories);
        Self {
            system,
            work: system.workspace(settings),
            swept: (system.model().with_dependents(swept).into_iter())
                .chain(slots)
                .collect(),
            shared: Vec::new(),
            block: vec![zero; rows.width()],
            rows,
            loaded: None,
            verdict: Verdict {
                certain: nowhere,
                ordinary: nowhere,
                goes_on: nowhere,
                class: zero,
                rest_of_sequence: zero,
            },
        }
    }

    /// Lets a trajectory, by its number, wait in its row for its next step, which has this unit of time.
    pub fn take_in(
        &mut self,
        (index, trajectory, unit): (usize, &Trajectory<f64>, f64),
        program: &Program,
    ) {
        let mode = trajectory.mode;
        if self.shared.len() <= mode {
            self.shared.resize_with(mode + 1, || None);
        }
        if self.shared[mode].is_none()
            && let Some(constants) = &trajectory.constants[mode]
        {
            let shared = Shared::new(self.system, mode, program, &self.swept, constants);
            self.rows.widen(shared.varying());
            self.block.resize(self.rows.width(), Lanes::splat(0.0));
            self.shared[mode] = Some(shared);
        }
        if let Some(shared) = &self.shared[mode] {
            self.rows.fill((index, trajectory, unit), shared);
        }
    }

    /// Brings a trajectory up to date with its row.
    pub fn catch_up(&mut self, index: usize, trajectory: &mut Trajectory<f64>) {
        self.rows.catch_up(index, trajectory);
    }

    /// Loads the constants of a mode that the trajectories share.
    pub fn enter(&mut self, mode: usize) {
        if self.loaded == Some(mode) {
            return;
        }
        if let Some(shared) = self.shared.get(mode).and_then(Option::as_ref) {
            self.work.constants.clone_from(&shared.tape);
            self.work.impact_constants.clone_from(&shared.impacts);
            self.loaded = Some(mode);
        }
    }

    /// Tells a trajectory of the end of its lane's step: of an ordinary one, which is in its row, what cannot wait, of another all
    /// that is known.
    #[inline(always)]
    pub fn give_back(
        &mut self,
        lane: usize,
        (index, trajectory): (usize, &mut Trajectory<f64>),
        (program, touching): (&Program, Touching),
    ) -> Ended {
        let Self {
            work,
            verdict,
            rows,
            block,
            ..
        } = self;
        if !verdict.ordinary.lane(lane) {
            rows.catch_up(index, trajectory);
            return self.give_to_mode_machine(lane, trajectory);
        }
        let lane = lane.min(L - 1);
        let event = work.event.0[lane];
        let at = (event > NO_EVENT).then(|| index_of(event));
        rows.note(index, at);
        let told = match at {
            None => {
                trajectory.note_glide(touching, work.step.0[lane]);
                None
            }
            Some(at) => {
                let guard = &program.guards[at];
                guard.closing().and_then(|contact| {
                    let rate = work.impact[0].0[lane];
                    let time = block[rows.places.time()].0[lane];
                    let rest = verdict.rest_of_sequence.0[lane];
                    let is_told = trajectory.note_bounce(guard, (contact, rate), (time, rest));
                    let rates = (rate, work.impact[1].0[lane]);
                    is_told.then(|| Occurrence::ordinary_impact((contact, rates)))
                })
            }
        };
        let class = index_of(verdict.class.0[lane]);
        Ended::Ordinary {
            at,
            told,
            next: verdict.goes_on.lane(lane).then_some(class),
        }
    }

    /// Gives the end of a step that is no ordinary one to a trajectory that knows where it began.
    #[inline(never)]
    fn give_to_mode_machine(&self, lane: usize, trajectory: &mut Trajectory<f64>) -> Ended {
        let work = &self.work;
        if !self.verdict.certain.lane(lane) {
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
        let remaining = trajectory.remaining();
        Ended::Digest(StepResult {
            outcome,
            event,
            touched: None,
            crowd: Closed::NONE,
            jumped: false,
            at_horizon: event.is_none() && reaches(outcome.step, remaining),
        })
    }
}
