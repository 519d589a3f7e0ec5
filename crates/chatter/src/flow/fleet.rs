//! Packs the steps of many trajectories into lanes. Nothing else knows of lanes.
//!
//! Each trajectory keeps its own time, step, order and mode. Those whose next step runs the same program at the same
//! order with the same roots divided out wait in one queue; a full queue makes a full vector. What a lane computes does
//! not depend on its neighbours, so results do not depend on packing, width or thread count.

use super::error::FlowError;
use super::occurrence::Occurrence;
use super::program::{Closed, IMPACT_SCALARS, ImpactTape, Program, ProgramConstants};
use super::step::{NO_EVENT, ORDER_CLASSES, Workspace};
use super::system::{Settings, System};
use super::touching::Touching;
use super::trajectory::{StepResult, Trajectory};
use crate::expressions::Tape;
use crate::numerics::dispatch::{Kernel, dispatch};
use crate::numerics::{LaneMask, Lanes, Scalar};
use core::sync::atomic::{AtomicBool, Ordering};

/// What becomes of a trajectory after an occurrence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    /// It goes on, from wherever the visitor left it: after an error it must have been replaced.
    Continue,
    /// It is finished.
    Retire,
}

/// Constants of the tapes of a mode: which of them differ between the trajectories of a fleet, and the others.
#[derive(Debug)]
struct Shared<const L: usize> {
    varying_tape: Vec<usize>,
    varying_impacts: Vec<Vec<usize>>,
    tape: Vec<Lanes<L>>,
    impacts: Vec<Vec<Lanes<L>>>,
}

impl<const L: usize> Shared<L> {
    /// Takes what does not differ from any of the trajectories.
    fn new(
        system: &System,
        mode: usize,
        program: &Program,
        swept: &[usize],
        any: &ProgramConstants<f64>,
    ) -> Self {
        let splat = |values: &[f64]| values.iter().map(|&value| Lanes::splat(value)).collect();
        let depending = |tape: &Tape| system.constants_depending_on(mode, tape, swept);
        let of_impact = |impact: &Option<ImpactTape>| {
            (impact.as_ref()).map_or_else(Vec::new, |impact| depending(&impact.tape))
        };
        Self {
            varying_tape: depending(&program.tape),
            varying_impacts: program.impacts.iter().map(of_impact).collect(),
            tape: splat(&any.tape),
            impacts: any.impacts.iter().map(|impact| splat(impact)).collect(),
        }
    }
}

/// Runs trajectories of one system side by side until each retires, or until `stop` is set: then it returns after the step
/// it is at.
///
/// `visit` hears of every occurrence of every trajectory, by index, and may replace the trajectory. All may differ in
/// the parameters named in `swept` (by index) and in nothing else of the model.
pub fn run_fleet<V>(
    system: &System,
    settings: &Settings,
    swept: &[usize],
    trajectories: &mut [Trajectory<f64>],
    stop: &AtomicBool,
    visit: V,
) where
    V: FnMut(usize, &mut Trajectory<f64>, Result<&Occurrence<f64>, FlowError>) -> Next,
{
    Fleet::<WIDTH, V>::new(system, settings, swept, trajectories, visit).run(stop);
}

/// Lanes of a vector of trajectories: four registers with AVX2, two with AVX-512. With AVX2 an expansion costs a lane the same
/// in 16 as in 32, and what reads it afterwards finds it in the first cache.
const WIDTH: usize = 16;

/// So many trajectories step faster one by one than in a vector that is nearly empty: it costs as much as five.
const FEW: usize = 4;

/// Trajectories whose next steps run the same program with the same roots divided out.
#[derive(Debug)]
struct Queue {
    mode: usize,
    touching: Touching,
    /// By order class, those that can share a vector: index of the trajectory and its unit of time.
    waiting: [Vec<(usize, f64)>; ORDER_CLASSES],
}

struct Fleet<'a, const L: usize, V> {
    system: &'a System,
    trajectories: &'a mut [Trajectory<f64>],
    visit: V,
    swept: Vec<usize>,
    /// By number of the mode.
    shared: Vec<Option<Shared<L>>>,
    wide: Workspace<Lanes<L>>,
    single: Workspace<f64>,
    queues: Vec<Queue>,
    /// The queue that was joined last: often the next one, too.
    joined: usize,
    loaded: Option<usize>,
}

struct LaneStep<'a, const L: usize> {
    work: &'a mut Workspace<Lanes<L>>,
    program: &'a Program,
    class: usize,
    touching: Touching,
}

impl<const L: usize> Kernel for LaneStep<'_, L> {
    type Output = LaneMask<L>;
    #[inline(always)]
    fn run(self) -> LaneMask<L> {
        self.work.expand(self.program, self.class);
        let certain = self.work.locate(self.program, self.touching);
        self.work.finish(self.program);
        certain
    }
}

/// The step of a vector. Not generic, so that it is compiled here and not again for every visitor of every user.
trait VectorStep<const L: usize> {
    /// Makes the step; returns where it is certain.
    fn vector_step(&mut self, program: &Program, class: usize, touching: Touching) -> LaneMask<L>;
}

macro_rules! vector_step {
    ($width:expr) => {
        impl VectorStep<{ $width }> for Workspace<Lanes<{ $width }>> {
            fn vector_step(
                &mut self,
                program: &Program,
                class: usize,
                touching: Touching,
            ) -> LaneMask<{ $width }> {
                dispatch(LaneStep {
                    work: self,
                    program,
                    class,
                    touching,
                })
            }
        }
    };
}

vector_step!(WIDTH);

impl<'a, const L: usize, V> Fleet<'a, L, V>
where
    Workspace<Lanes<L>>: VectorStep<L>,
    V: FnMut(usize, &mut Trajectory<f64>, Result<&Occurrence<f64>, FlowError>) -> Next,
{
    fn new(
        system: &'a System,
        settings: &Settings,
        swept: &[usize],
        trajectories: &'a mut [Trajectory<f64>],
        visit: V,
    ) -> Self {
        // Each trajectory is on pieces of its own of what is looked up.
        let corners = system.corners();
        let slots = corners.first_slot..corners.first_slot + corners.slots();
        Self {
            swept: swept.iter().copied().chain(slots).collect(),
            shared: Vec::new(),
            wide: system.workspace(settings),
            single: system.workspace(settings),
            queues: Vec::new(),
            joined: 0,
            loaded: None,
            system,
            trajectories,
            visit,
        }
    }

    fn run(mut self, stop: &AtomicBool) {
        for index in 0..self.trajectories.len() {
            self.enqueue(index);
        }
        while let Some((queue, class)) = self.fullest()
            && !stop.load(Ordering::Relaxed)
        {
            self.step(queue, class);
        }
    }

    /// A queue and class that fill a vector, or else those with the most waiting.
    fn fullest(&self) -> Option<(usize, usize)> {
        let mut best = None;
        let mut length = 0;
        for (place, queue) in self.queues.iter().enumerate() {
            for (class, waiting) in queue.waiting.iter().enumerate() {
                if waiting.len() >= L {
                    return Some((place, class));
                }
                if waiting.len() > length {
                    length = waiting.len();
                    best = Some((place, class));
                }
            }
        }
        best
    }

    /// Puts a trajectory into the queue of its next step, after whatever it can do without one.
    fn enqueue(&mut self, index: usize) {
        loop {
            let trajectory = &mut self.trajectories[index];
            if !trajectory.has_pending() {
                break;
            }
            let outcome = trajectory.advance_to_horizon(self.system, &mut self.single);
            if tell(&mut self.visit, index, trajectory, &outcome) == Next::Retire {
                return;
            }
        }
        let trajectory = &self.trajectories[index];
        let (mode, touching) = (trajectory.mode, trajectory.touching);
        let (class, tau) = trajectory.plan();
        let same = |queue: &Queue| queue.mode == mode && queue.touching == touching;
        if !self.queues.get(self.joined).is_some_and(same) {
            self.joined = self.queues.iter().position(same).unwrap_or_else(|| {
                self.queues.push(Queue {
                    mode,
                    touching,
                    waiting: Default::default(),
                });
                self.queues.len() - 1
            });
        }
        self.queues[self.joined].waiting[class].push((index, tau));
    }

    /// Takes up to a vector of trajectories from a queue and moves each by one step.
    fn step(&mut self, place: usize, class: usize) {
        let queue = &mut self.queues[place];
        let (mode, touching) = (queue.mode, queue.touching);
        let waiting = &mut queue.waiting[class];
        let Some(program) = self.system.program(mode) else {
            // A trajectory enters only modes that have a program.
            waiting.clear();
            return;
        };
        let count = waiting.len().min(L);
        let first = waiting.len() - count;
        let mut members = [(0, 0.0); L];
        members[..count].copy_from_slice(&waiting[first..]);
        waiting.truncate(first);
        if count <= FEW {
            for &(index, _) in &members[..count] {
                let trajectory = &mut self.trajectories[index];
                let outcome = trajectory.advance_to_horizon(self.system, &mut self.single);
                self.hand_on(index, &outcome);
            }
            return;
        }
        for lane in count..L {
            members[lane] = members[0];
        }
        let remaining = self.gather(mode, program, &members);
        let certain = self.wide.vector_step(program, class, touching);
        for (lane, &(index, _)) in members[..count].iter().enumerate() {
            if certain.0[lane] {
                self.store(index, lane, class);
            }
        }
        for (lane, &(index, _)) in members[..count].iter().enumerate() {
            let outcome = self.digest(program, index, lane, certain.0[lane], remaining[lane]);
            self.hand_on(index, &outcome);
        }
    }

    /// Tells the visitor what happened to a trajectory, and lets it wait for its next step.
    #[inline]
    fn hand_on(&mut self, index: usize, outcome: &Told) {
        let trajectory = &mut self.trajectories[index];
        if tell(&mut self.visit, index, trajectory, outcome) == Next::Continue {
            self.enqueue(index);
        }
    }

    /// Loads states and constants into lanes; returns the time left to each.
    #[inline]
    fn gather(&mut self, mode: usize, program: &Program, members: &[(usize, f64); L]) -> [f64; L] {
        if self.shared.len() <= mode {
            self.shared.resize_with(mode + 1, || None);
        }
        if self.shared[mode].is_none()
            && let Some(any) = &self.trajectories[members[0].0].constants[mode]
        {
            let shared = Shared::new(self.system, mode, program, &self.swept, any);
            self.shared[mode] = Some(shared);
        }
        let Some(shared) = &self.shared[mode] else {
            return [0.0; L];
        };
        if self.loaded != Some(mode) {
            self.wide.constants.clone_from(&shared.tape);
            self.wide.impact_constants.clone_from(&shared.impacts);
            self.loaded = Some(mode);
        }
        let mut remaining = [0.0; L];
        for (lane, &(index, tau)) in members.iter().enumerate() {
            let trajectory = &self.trajectories[index];
            for (wide, &value) in self.wide.state.iter_mut().zip(&trajectory.state) {
                wide.0[lane] = value;
            }
            for (wide, &value) in self.wide.low.iter_mut().zip(&trajectory.low) {
                wide.0[lane] = value;
            }
            for (section, wide) in self.wide.sides.iter_mut().enumerate() {
                wide.0[lane] = trajectory.sides.get(section);
            }
            self.wide.tau.0[lane] = tau;
            self.wide.time.0[lane] = trajectory.time();
            remaining[lane] = trajectory.remaining();
            let Some(own) = &trajectory.constants[mode] else {
                continue;
            };
            for &place in &shared.varying_tape {
                self.wide.constants[place].0[lane] = own.tape[place];
            }
            for ((wide, own), places) in self
                .wide
                .impact_constants
                .iter_mut()
                .zip(&own.impacts)
                .zip(&shared.varying_impacts)
            {
                for &place in places {
                    wide[place].0[lane] = own[place];
                }
            }
        }
        self.wide.horizon = Lanes(remaining);
        remaining
    }

    /// Gives the end of a lane's step to its trajectory.
    #[inline(always)]
    fn store(&mut self, index: usize, lane: usize, class: usize) {
        let trajectory = &mut self.trajectories[index];
        for (value, wide) in trajectory.state.iter_mut().zip(&self.wide.state) {
            *value = wide.0[lane];
        }
        for (value, wide) in trajectory.low.iter_mut().zip(&self.wide.low) {
            *value = wide.0[lane];
        }
        for (section, wide) in self.wide.sides.iter().enumerate() {
            trajectory.sides.set(section, wide.0[lane]);
        }
        for (reach, wide) in trajectory
            .reach
            .iter_mut()
            .zip(&self.wide.reach)
            .take(class + 1)
        {
            *reach = wide.0[lane];
        }
    }

    /// Says what a lane's step means for its trajectory; an uncertain one is settled by itself.
    #[inline(always)]
    fn digest(
        &mut self,
        program: &Program,
        index: usize,
        lane: usize,
        certain: bool,
        remaining: f64,
    ) -> Told {
        let trajectory = &mut self.trajectories[index];
        if !certain {
            return trajectory.advance_settled(self.system, &mut self.single, program);
        }
        let event = self.wide.event.0[lane];
        let mut result = StepResult {
            step: self.wide.step.0[lane],
            event: (event >= 0.0).then_some(event as usize),
            touched: None,
            crowd: Closed::NONE,
            jumped: false,
            at_horizon: event == NO_EVENT && StepResult::reaches(self.wide.step.0[lane], remaining),
            impact: [0.0; IMPACT_SCALARS],
            flight_time: self.wide.flight_time.0[lane],
        };
        for (scalar, wide) in result.impact.iter_mut().zip(&self.wide.impact) {
            *scalar = wide.0[lane];
        }
        trajectory.digest(self.system, &mut self.single, program, &result)
    }
}

/// What came of a step.
type Told = Result<Option<Occurrence<f64>>, FlowError>;

/// Tells the visitor of an occurrence or error, if there is one. By reference: moving what was just written stalls the
/// processor.
#[inline(always)]
fn tell<V>(visit: &mut V, index: usize, trajectory: &mut Trajectory<f64>, outcome: &Told) -> Next
where
    V: FnMut(usize, &mut Trajectory<f64>, Result<&Occurrence<f64>, FlowError>) -> Next,
{
    match outcome {
        Ok(None) => Next::Continue,
        Ok(Some(occurrence)) => visit(index, trajectory, Ok(occurrence)),
        Err(error) => visit(index, trajectory, Err(error.clone())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expressions::Backend;
    use crate::model::Model;

    const VALVE: &str = include_str!("../../../../models/pressure_relief_valve.toml");
    const OSCILLATOR: &str = include_str!("../../../../models/impact_oscillator_two_sided.toml");
    const CAM: &str = include_str!("../../../../models/dwell_cam.toml");
    const BELT: &str = include_str!("../../../../models/mass_on_belt.toml");
    const DRILL: &str = include_str!("../../../../models/percussive_drill.toml");

    /// Time and state of every trajectory after so many occurrences, to the bit.
    type End = (u64, Vec<u64>);

    fn end(trajectory: &Trajectory<f64>) -> End {
        let bits = trajectory.state().iter().map(|x| x.to_bits()).collect();
        (trajectory.time().to_bits(), bits)
    }

    struct Columns {
        system: System,
        settings: Settings,
        trajectories: Vec<Trajectory<f64>>,
    }

    /// Columns over values of the first parameter: complete and incomplete chatter, periodic and chaotic.
    fn columns(text: &str, low: f64, high: f64, count: usize) -> Columns {
        let model = Model::from_toml(text, "model").expect("a valid model");
        let system = System::new(&model).expect("a valid system");
        let settings = Settings::default();
        let mut work = system.workspace::<f64>(&settings);
        let trajectories = (0..count)
            .map(|i| {
                let value = low + (high - low) * i as f64 / count as f64;
                let parameters = model.parameter_values::<f64>(&[(0, value)]);
                let state = model.initial_state(&parameters);
                Trajectory::start(&system, &mut work, &parameters, 0.0, &state)
                    .expect("a legal start")
            })
            .collect();
        Columns {
            system,
            settings,
            trajectories,
        }
    }

    vector_step!(4);
    vector_step!(8);

    fn in_lanes<const L: usize>(columns: &Columns, occurrences: usize) -> Vec<End>
    where
        Workspace<Lanes<L>>: VectorStep<L>,
    {
        let mut trajectories = columns.trajectories.clone();
        let mut told = vec![0; trajectories.len()];
        let mut ends = vec![(0, Vec::new()); trajectories.len()];
        let visit =
            |index: usize, trajectory: &mut Trajectory<f64>, what: Result<&_, FlowError>| {
                what.expect("a finite field");
                told[index] += 1;
                if told[index] < occurrences {
                    return Next::Continue;
                }
                ends[index] = end(trajectory);
                Next::Retire
            };
        Fleet::<L, _>::new(
            &columns.system,
            &columns.settings,
            &[0],
            &mut trajectories,
            visit,
        )
        .run(&AtomicBool::new(false));
        ends
    }

    fn alone(columns: &Columns, occurrences: usize) -> Vec<End> {
        let mut work = columns.system.workspace::<f64>(&columns.settings);
        let follow = |trajectory: &Trajectory<f64>| {
            let mut trajectory = trajectory.clone();
            let mut told = 0;
            while told < occurrences {
                let what = trajectory.advance_to_horizon(&columns.system, &mut work);
                told += usize::from(what.expect("a finite field").is_some());
            }
            end(&trajectory)
        };
        columns.trajectories.iter().map(follow).collect()
    }

    #[test]
    fn a_lane_is_a_trajectory_to_the_bit_whatever_the_width() {
        let cases = [
            (VALVE, 0.0195, 0.0225, 400),
            (OSCILLATOR, 0.5, 2.5, 400),
            (CAM, 1.5, 2.5, 100),
            (BELT, 0.1, 0.5, 40),
            (DRILL, 0.1, 0.2, 40),
        ];
        for (text, low, high, occurrences) in cases {
            let mut columns = columns(text, low, high, 37);
            columns.settings.backend = Backend::Interpreter;
            let expected = alone(&columns, occurrences);
            assert_eq!(in_lanes::<4>(&columns, occurrences), expected);
            columns.settings.backend = Backend::CompiledAtOnce;
            assert_eq!(alone(&columns, occurrences), expected);
            assert_eq!(in_lanes::<WIDTH>(&columns, occurrences), expected);
            assert_eq!(in_lanes::<8>(&columns, occurrences), expected);
            assert_eq!(in_lanes::<4>(&columns, occurrences), expected);
        }
    }
}
