//! One step of a vector of trajectories: the rows of those who are new are laid beside the others, the step is made, what is ordinary
//! in it decided for all lanes at once, and who does not stay for another gets its own back.

use super::WIDTH;
use super::cohort::{Cohort, Start};
use super::rows::{Places, Rows};
use super::shared::Shared;
use crate::flow::modes::at_contacts::IMPACT_SCALARS;
use crate::flow::modes::closed::Closed;
use crate::flow::modes::guard::Transition;
use crate::flow::modes::program::Program;
use crate::flow::occurrence::Occurrence;
use crate::flow::step::flight::{
    Flight, Outcome, largest, plan, reaches, remaining, rest_of_sequence,
};
use crate::flow::step::{NO_EVENT, Workspace};
use crate::flow::system::{Settings, System};
use crate::flow::touching::Touching;
use crate::flow::trajectory::{StepResult, Trajectory};
#[cfg(target_arch = "x86_64")]
use crate::numerics::Registers;
use crate::numerics::dispatch::Kernel;
use crate::numerics::{LaneSet, Lanes, Mask, Wide, WideMask, index_of};

/// A vector of trajectories. Those of a fleet take turns in it.
#[derive(Debug)]
pub(super) struct Vector<'a, W: Wide> {
    system: &'a System,
    work: Workspace<W>,
    /// Parameters that differ between the trajectories.
    swept: Vec<usize>,
    /// By number of the mode.
    shared: Vec<Option<Shared<W>>>,
    /// All trajectories.
    rows: Rows,
    /// The mode whose constants the workspace holds.
    loaded: Option<usize>,
    verdict: Verdict<W>,
}

/// What is known of each lane after a step.
#[derive(Debug)]
struct Verdict<W: Wide> {
    /// Where the step is certain.
    certain: W::Mask,
    /// Where it is an ordinary one, too.
    ordinary: W::Mask,
    /// Where it ended in the impact that the next step of the same cohort begins with, untold.
    passed: W::Mask,
    /// Where time is left then, with the order class of the next step.
    goes_on: W::Mask,
    class: W,
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

/// What the steps of a cohort have in common.
#[derive(Clone, Copy)]
pub(super) struct Common<'a> {
    pub mode: usize,
    pub program: &'a Program,
    pub class: usize,
    pub touching: Touching,
    /// The impact that they begin with.
    pub start: Option<Start>,
}

/// The step of a vector. Not generic, so that it is compiled here and not again for every visitor of every user.
pub(super) trait VectorStep<W: Wide> {
    /// Makes a step with a cohort, of which some have just boarded, in a mode that was entered. Says which lanes are left.
    fn step(&mut self, cohort: &mut Cohort<W>, newcomers: LaneSet, common: Common<'_>) -> LaneSet;
}

/// Lanes of the widest register; vectors are made of whole ones.
const REGISTER: usize = 8;

macro_rules! vector_step {
    ($wide:ty) => {
        impl VectorStep<$wide> for Vector<'_, $wide> {
            fn step(
                &mut self,
                cohort: &mut Cohort<$wide>,
                newcomers: LaneSet,
                common: Common<'_>,
            ) -> LaneSet {
                self.step_wide(cohort, newcomers, common)
            }
        }
    };
}

#[cfg(target_arch = "x86_64")]
vector_step!(Registers);
vector_step!(Lanes<WIDTH>);
#[cfg(test)]
vector_step!(Lanes<8>);

struct LaneStep<'a, W: Wide> {
    rows: &'a mut Rows,
    cohort: &'a mut Cohort<W>,
    newcomers: LaneSet,
    shared: &'a Shared<W>,
    work: &'a mut Workspace<W>,
    verdict: &'a mut Verdict<W>,
    coordinates: usize,
    may_bounce: bool,
    common: Common<'a>,
}

impl<W: Wide> Kernel for LaneStep<'_, W> {
    /// Who stays aboard.
    type Output = LaneSet;

    #[inline(always)]
    fn run(self) -> LaneSet {
        let Self {
            rows,
            cohort,
            newcomers,
            work,
            verdict,
            common,
            ..
        } = self;
        let program = common.program;
        let places = rows.places;
        rows.gather(&cohort.members, newcomers, &mut cohort.block);
        let aboard = cohort.aboard();
        if aboard.count() < W::LANES {
            cohort.fill_lanes();
        }
        let block = &mut cohort.block[..];
        load(work, self.shared, (places, block));
        let flight = flight(places, block);
        work.time = flight.time;
        work.horizon = flight.remaining();
        let certain = work.try_step(program, common.class, common.touching);
        verdict.certain = certain;
        if !program.is_free {
            verdict.ordinary = W::Mask::splat(false);
            verdict.passed = W::Mask::splat(false);
            return LaneSet::NONE;
        }
        let nowhere = work.event.less(W::splat(0.0));
        let mut at_impact = W::Mask::splat(false);
        let mut at_start = W::Mask::splat(false);
        for (index, guard) in program.guards.iter().enumerate() {
            if self.may_bounce && matches!(guard.transition, Transition::Impact { .. }) {
                let here = work.ends_step(index);
                at_impact = at_impact | here;
                if common.start.is_some_and(|start| start.guard == index) {
                    at_start = here;
                }
            }
        }
        let (largest, is_finite) = largest(&work.state, self.coordinates);
        let (course, is_ordinary) = flight.follow(&work.outcome(), (nowhere, at_impact), largest);
        let ordinary = certain & is_ordinary & is_finite;
        let passed = ordinary & at_start & cohort.impacts.may_pass();
        let (class, unit) = plan(course.flight_time, &work.reach);
        let (horizon, now) = (
            (flight.horizon, flight.horizon_low),
            (course.time, course.time_low),
        );
        let goes_on = W::splat(0.0).less(remaining(horizon, now));
        let own = W::splat(common.class as f64);
        let stays = passed & goes_on & class.at_most(own) & own.at_most(class);
        let (stays, are_ordinary) = (stays.set() & aboard, ordinary.set());
        if common.start.is_some() {
            let [rate, .., at_rest] = work.impact;
            let rest = rest_of_sequence(course.flight_time, at_rest);
            cohort.impacts.note(passed, rate, (course.time, rest));
            // The mode machine begins from the numbers before.
            let others = aboard.without(newcomers).without(are_ordinary);
            rows.scatter(&cohort.members, block, others);
        }
        store(work, (places, block));
        block[places.unit()] = unit;
        block[places.time()] = course.time;
        block[places.time_low()] = course.time_low;
        block[places.flight_time()] = course.flight_time;
        block[places.longest_step()] = course.longest_step;
        let leave = aboard.without(stays) & are_ordinary;
        rows.scatter(&cohort.members, block, leave);
        verdict.ordinary = ordinary;
        verdict.passed = passed;
        verdict.class = class;
        verdict.goes_on = goes_on;
        stays
    }
}

/// Puts rows that stand side by side where a step expects them.
#[inline(always)]
fn load<W: Wide>(work: &mut Workspace<W>, shared: &Shared<W>, (places, block): (Places, &[W])) {
    copy(&mut work.state, &block[places.state()]);
    copy(&mut work.low, &block[places.low()]);
    copy(&mut work.sides, &block[places.sides()]);
    copy(&mut work.reach, &block[places.reach()]);
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
fn store<W: Wide>(work: &Workspace<W>, (places, block): (Places, &mut [W])) {
    copy(&mut block[places.state()], &work.state);
    copy(&mut block[places.low()], &work.low);
    copy(&mut block[places.sides()], &work.sides);
    copy(&mut block[places.reach()], &work.reach);
}

/// Copies a few numbers, some lanes at a time: for so few a call of the library, which is what copying arrays whole becomes, costs more.
#[inline(always)]
fn copy<W: Wide>(to: &mut [W], from: &[W]) {
    const { assert!(W::LANES.is_multiple_of(REGISTER)) };
    for (to, from) in to.iter_mut().zip(from) {
        let from = from.lanes().as_chunks::<REGISTER>().0;
        let to = to.lanes_mut().as_chunks_mut::<REGISTER>().0;
        for (to, from) in to.iter_mut().zip(from) {
            *to = *from;
        }
    }
}

#[inline(always)]
fn flight<W: Wide>(places: Places, block: &[W]) -> Flight<W> {
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

impl<'a, W: Wide> Vector<'a, W> {
    pub fn new(
        system: &'a System,
        settings: &Settings,
        swept: &[usize],
        trajectories: usize,
    ) -> Self {
        // Each trajectory is on pieces of its own of what is looked up.
        let corners = system.corners();
        let slots = corners.first_slot..corners.first_slot + corners.slots();
        let (zero, nowhere) = (W::splat(0.0), W::Mask::splat(false));
        let rows = Rows::new((system.dimension(), system.sections()), trajectories);
        Self {
            system,
            work: system.workspace(settings),
            swept: (system.model().with_dependents(swept).into_iter())
                .chain(slots)
                .collect(),
            shared: Vec::new(),
            rows,
            loaded: None,
            verdict: Verdict {
                certain: nowhere,
                ordinary: nowhere,
                passed: nowhere,
                goes_on: nowhere,
                class: zero,
            },
        }
    }

    fn step_wide(
        &mut self,
        cohort: &mut Cohort<W>,
        newcomers: LaneSet,
        common: Common<'_>,
    ) -> LaneSet {
        let Some(shared) = self.shared.get(common.mode).and_then(Option::as_ref) else {
            self.verdict.certain = W::Mask::splat(false);
            return cohort.keep(LaneSet::NONE);
        };
        let stay = W::run(LaneStep {
            rows: &mut self.rows,
            cohort: &mut *cohort,
            newcomers,
            shared,
            work: &mut self.work,
            verdict: &mut self.verdict,
            coordinates: self.system.coordinates(),
            may_bounce: self.system.corners().is_empty(),
            common,
        });
        if stay.is_none() {
            self.verdict.certain = W::Mask::splat(false);
        }
        cohort.keep(stay.unwrap_or(LaneSet::NONE))
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

    /// Lets those of a cohort who wait aboard. Says which lanes are new.
    pub fn board(
        &self,
        cohort: &mut Cohort<W>,
        start: Option<Start>,
        trajectories: &[Trajectory<f64>],
    ) -> LaneSet {
        cohort.board(start, trajectories, self.rows.width())
    }

    /// Lets all who are aboard wait in their rows.
    pub fn disembark(
        &mut self,
        cohort: &mut Cohort<W>,
        trajectories: &mut [Trajectory<f64>],
        (start, program): (Option<Start>, &Program),
    ) {
        cohort.disembark(&mut self.rows, trajectories, (start, program));
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

    /// Tells a trajectory that leaves its lane of the end of its step there: of an ordinary one, which is in its row, what cannot wait,
    /// of another all that is known.
    #[inline(always)]
    pub fn give_back(
        &mut self,
        (cohort, lane): (&Cohort<W>, usize),
        (index, trajectory): (usize, &mut Trajectory<f64>),
        common: Common<'_>,
    ) -> Ended {
        let Self {
            work,
            verdict,
            rows,
            ..
        } = self;
        let Common {
            program, touching, ..
        } = common;
        let has_passed = verdict.passed.lane(lane);
        if let Some(start) = common.start {
            let told = (start, program);
            cohort.tell(lane, (index, trajectory), told, (rows, !has_passed));
        }
        if !verdict.ordinary.lane(lane) {
            rows.catch_up(index, trajectory);
            return self.give_to_mode_machine(lane, trajectory, common);
        }
        let lane = lane.min(W::LANES - 1);
        let event = work.event.lanes()[lane];
        let at = (event > NO_EVENT).then(|| index_of(event));
        rows.note(index, at);
        let told = match at {
            None => {
                trajectory.note_glide(touching, work.step.lanes()[lane]);
                None
            }
            Some(_) if has_passed => None,
            Some(at) => {
                let guard = &program.guards[at];
                guard.closing().and_then(|contact| {
                    let rate = work.impact[0].lanes()[lane];
                    let time = cohort.block[rows.places.time()].lanes()[lane];
                    let [.., at_rest] = work.impact.map(|value| value.lanes()[lane]);
                    let rest = rest_of_sequence(work.flight_time.lanes()[lane], at_rest);
                    let is_told = trajectory.note_bounce(guard, (contact, rate), (time, rest));
                    let rates = (rate, work.impact[1].lanes()[lane]);
                    is_told.then(|| Occurrence::ordinary_impact((contact, rates)))
                })
            }
        };
        let class = index_of(verdict.class.lanes()[lane]);
        Ended::Ordinary {
            at,
            told,
            next: verdict.goes_on.lane(lane).then_some(class),
        }
    }

    /// Gives the end of a step that is no ordinary one to a trajectory that knows where it began.
    #[inline(never)]
    fn give_to_mode_machine(
        &self,
        lane: usize,
        trajectory: &mut Trajectory<f64>,
        Common {
            program, touching, ..
        }: Common<'_>,
    ) -> Ended {
        let work = &self.work;
        if !self.verdict.certain.lane(lane) {
            return Ended::Uncertain;
        }
        for (value, wide) in trajectory.state.iter_mut().zip(&work.state) {
            *value = wide.lanes()[lane];
        }
        for (value, wide) in trajectory.low.iter_mut().zip(&work.low) {
            *value = wide.lanes()[lane];
        }
        for (section, wide) in work.sides.iter().enumerate() {
            trajectory.sides.set(section, wide.lanes()[lane]);
        }
        for (reach, wide) in trajectory.reach.iter_mut().zip(&work.reach) {
            *reach = wide.lanes()[lane];
        }
        let event = work.event.lanes()[lane];
        let event = (event > NO_EVENT).then_some(event as usize);
        let mut outcome = Outcome {
            step: work.step.lanes()[lane],
            step_low: work.step_low.lanes()[lane],
            impact: [0.0; IMPACT_SCALARS],
            flight_time: work.flight_time.lanes()[lane],
        };
        for (value, wide) in outcome.impact.iter_mut().zip(&work.impact) {
            *value = wide.lanes()[lane];
        }
        let remaining = trajectory.remaining();
        let mut result = StepResult {
            outcome,
            event,
            touched: None,
            crowd: Closed::NONE,
            jumped: false,
            at_horizon: event.is_none() && reaches(outcome.step, remaining),
            gap: None,
        };
        let gap = |slot: usize, roots: u8| {
            let (value, terms) = work.value_at_end(&program.tape, slot, roots);
            (value.lanes()[lane], terms.lanes()[lane])
        };
        result.gap = trajectory.gap_at_end((program, touching), &result, gap);
        Ended::Digest(result)
    }
}
