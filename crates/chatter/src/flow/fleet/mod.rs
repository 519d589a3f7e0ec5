//! Packs the steps of many trajectories into lanes. Nothing else knows of lanes.
//!
//! Each trajectory keeps its own time, step, order and mode. Those whose next step runs the same program at the same
//! order with the same roots divided out are one cohort; as many as there are lanes make a full vector. What a lane computes does
//! not depend on its neighbours, so results do not depend on packing, width or thread count.

mod cohort;
mod rows;
mod shared;
mod vector;

use super::error::FlowError;
use super::modes::program::Program;
use super::occurrence::Occurrence;
use super::step::{ORDER_CLASSES, Workspace};
use super::system::{Settings, System};
use super::touching::Touching;
use super::trajectory::Trajectory;
#[cfg(target_arch = "x86_64")]
use crate::numerics::Registers;
#[cfg(target_arch = "x86_64")]
use crate::numerics::dispatch::InstructionSet;
use crate::numerics::dispatch::has_wide_registers;
use crate::numerics::{Lanes, Wide};
use cohort::{Cohort, Start};
use core::sync::atomic::{AtomicBool, Ordering};
use vector::{Common, Ended, Vector, VectorStep};

/// What becomes of a trajectory after an occurrence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    /// It goes on, from wherever the visitor left it: after an error it must have been replaced.
    Continue,
    /// It is finished.
    Retire,
}

/// Runs trajectories of one system side by side until each retires, or until `stop` is set: then it returns after the step
/// it is at.
///
/// `visit` hears of every occurrence of every trajectory, by index, but of impacts that may pass
/// ([`Trajectory::let_pass`]), and may replace the trajectory. All may differ in the parameters named in `swept` (by index), with
/// what is defined through them, and in nothing else of the model.
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
    #[cfg(target_arch = "x86_64")]
    if InstructionSet::detected() == InstructionSet::Avx512 {
        return Fleet::<Registers, V>::new(system, settings, swept, trajectories, visit).run(stop);
    }
    Fleet::<Lanes<WIDTH>, V>::new(system, settings, swept, trajectories, visit).run(stop);
}

/// Lanes of a vector of trajectories: four registers with AVX2, two with AVX-512. With AVX2 an expansion costs a lane the same
/// in 16 as in 32, and what reads it afterwards finds it in the first cache.
const WIDTH: usize = 16;

/// So many trajectories step faster one by one than in a vector that is nearly empty: it costs as much as five.
const FEW: usize = 4;

/// Trajectories whose next steps run the same program with the same roots divided out.
#[derive(Debug)]
struct Queue<W> {
    mode: usize,
    touching: Touching,
    /// The impact that these steps begin with.
    start: Option<Start>,
    /// By order class, those that can share a vector.
    cohorts: [Cohort<W>; ORDER_CLASSES],
}

struct Fleet<'s, 't, W: Wide, V> {
    system: &'s System,
    trajectories: &'t mut [Trajectory<f64>],
    visit: V,
    vector: Vector<'s, W>,
    single: Workspace<f64>,
    queues: Vec<Queue<W>>,
    /// The queue that was joined last: often the next one, too.
    joined: usize,
    /// The queue and class whose vector made the latest step: as long as it is full, the next one, too.
    stepped: (usize, usize),
}

impl<'s, 't, W: Wide, V> Fleet<'s, 't, W, V>
where
    Vector<'s, W>: VectorStep<W>,
    V: FnMut(usize, &mut Trajectory<f64>, Result<&Occurrence<f64>, FlowError>) -> Next,
{
    fn new(
        system: &'s System,
        settings: &Settings,
        swept: &[usize],
        trajectories: &'t mut [Trajectory<f64>],
        visit: V,
    ) -> Self {
        Self {
            vector: Vector::new(system, settings, swept, trajectories.len()),
            single: system.workspace(settings),
            queues: Vec::new(),
            joined: 0,
            stepped: (0, 0),
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
            self.stepped = (queue, class);
        }
        for place in 0..self.queues.len() {
            for class in 0..ORDER_CLASSES {
                self.disembark(place, class);
            }
        }
        for (index, trajectory) in self.trajectories.iter_mut().enumerate() {
            self.vector.catch_up(index, trajectory);
        }
    }

    /// A queue and class that fill a vector, or else those with the most waiting.
    fn fullest(&self) -> Option<(usize, usize)> {
        let (place, class) = self.stepped;
        if (self.queues.get(place)).is_some_and(|queue| queue.cohorts[class].len() >= W::LANES) {
            return Some((place, class));
        }
        let mut best = None;
        let mut length = 0;
        for (place, queue) in self.queues.iter().enumerate() {
            for (class, cohort) in queue.cohorts.iter().enumerate() {
                let count = cohort.len();
                if count >= W::LANES {
                    return Some((place, class));
                }
                if count > length {
                    length = count;
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
            if !(trajectory.has_pending() || trajectory.steps_alone()) {
                break;
            }
            let outcome = trajectory.advance_to_horizon(self.system, &mut self.single);
            if tell(&mut self.visit, index, trajectory, &outcome) == Next::Retire {
                return;
            }
        }
        let trajectory = &self.trajectories[index];
        let (mode, touching) = (trajectory.mode, trajectory.touching);
        let Some(program) = self.system.program(mode) else {
            // A trajectory enters only modes that have a program.
            return;
        };
        let (class, unit) = trajectory.plan();
        self.vector.take_in((index, trajectory, unit), program);
        let place = self.queue(mode, touching, program);
        self.queues[place].cohorts[class].waiting.push(index);
    }

    /// The queue of trajectories in this mode, which has this program, with so many roots to divide out.
    #[inline]
    fn queue(&mut self, mode: usize, touching: Touching, program: &Program) -> usize {
        let same = |queue: &Queue<W>| queue.mode == mode && queue.touching == touching;
        if !self.queues.get(self.joined).is_some_and(same) {
            self.joined = self.queues.iter().position(same).unwrap_or_else(|| {
                self.queues.push(Queue {
                    mode,
                    touching,
                    start: Start::of(program, touching),
                    cohorts: core::array::from_fn(|_| Cohort::new()),
                });
                self.queues.len() - 1
            });
        }
        self.joined
    }

    /// Lets all of a cohort wait in their rows.
    fn disembark(&mut self, place: usize, class: usize) {
        let queue = &mut self.queues[place];
        if let Some(program) = self.system.program(queue.mode) {
            let (cohort, start) = (&mut queue.cohorts[class], queue.start);
            (self.vector).disembark(cohort, self.trajectories, (start, program));
        }
    }

    /// Moves up to a vector of trajectories of a queue by one step each.
    fn step(&mut self, place: usize, class: usize) {
        let Queue {
            mode,
            touching,
            start,
            ref mut cohorts,
        } = self.queues[place];
        let cohort = &mut cohorts[class];
        let Some(program) = self.system.program(mode) else {
            cohort.waiting.clear();
            return;
        };
        if cohort.len() <= FEW || !has_wide_registers() {
            self.disembark(place, class);
            for index in core::mem::take(&mut self.queues[place].cohorts[class].waiting) {
                let trajectory = &mut self.trajectories[index];
                self.vector.catch_up(index, trajectory);
                let outcome = trajectory.advance_to_horizon(self.system, &mut self.single);
                self.hand_on(index, &outcome);
            }
            return;
        }
        let common = Common {
            mode,
            program,
            class,
            touching,
            start,
        };
        let newcomers = self.vector.board(cohort, start, self.trajectories);
        self.vector.enter(mode);
        let left = self.vector.step(cohort, newcomers, common);
        // What ordinary steps lead to is the same for all that end at the same guard.
        let mut known = None;
        for lane in left {
            let cohort = &self.queues[place].cohorts[class];
            let index = cohort.members[lane];
            let trajectory = &mut self.trajectories[index];
            let ended = (self.vector).give_back((cohort, lane), (index, trajectory), common);
            let outcome = match ended {
                Ended::Ordinary {
                    at,
                    told: None,
                    next: Some(class),
                } => {
                    let place = match known {
                        Some((before, place)) if before == at => place,
                        _ => self.queue(mode, Touching::after(at), program),
                    };
                    known = Some((at, place));
                    self.queues[place].cohorts[class].waiting.push(index);
                    continue;
                }
                Ended::Ordinary { told, .. } => {
                    self.vector.catch_up(index, trajectory);
                    Ok(told)
                }
                Ended::Digest(result) => {
                    trajectory.digest(self.system, &mut self.single, program, &result)
                }
                Ended::Uncertain => {
                    trajectory.advance_settled(self.system, &mut self.single, program)
                }
            };
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

    const VALVE: &str = include_str!("../../../../../models/pressure_relief_valve.toml");
    const OSCILLATOR: &str = include_str!("../../../../../models/impact_oscillator_two_sided.toml");
    const CAM: &str = include_str!("../../../../../models/dwell_cam.toml");
    const BELT: &str = include_str!("../../../../../models/mass_on_belt.toml");
    const DRILL: &str = include_str!("../../../../../models/percussive_drill.toml");
    const BALL: &str = include_str!("../../../../../models/bouncing_ball_on_table.toml");

    /// A stop where the table of the force on a body ends.
    const TABLE: &str = "[parameters]\na = 0.5\n[table.force]\nx = [0, 0.5, 9]\ny = [1, 1.25, 4]\n\
        [flight]\ny = \"v\"\nv = \"a*cos(t) - force(y)\"\n[[contact]]\nname = \"seat\"\ngap = \"y\"\n\
        impulse = { v = 1 }\nrestitution = 0.6\n[initial]\ny = 0.4\nv = 0\n";

    /// A restitution whose corner only impacts ask for.
    const JOHNSON: &str = "[parameters]\na = 0.5\n[flight]\ny = \"v\"\nv = \"-1\"\n[[contact]]\nname = \"table\"\n\
        gap = \"y - a*cos(2*t)\"\nimpulse = { v = 1 }\nrestitution = \"min(0.8, 0.5*abs(v + 2*a*sin(2*t))^(-0.25))\"\n\
        [initial]\ny = 2\nv = 0\n";

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

    fn in_lanes<'a, W: Wide>(columns: &'a Columns, occurrences: usize) -> Vec<End>
    where
        Vector<'a, W>: VectorStep<W>,
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
        Fleet::<W, _>::new(
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
            (TABLE, 1.2, 2.0, 100),
            (JOHNSON, 0.3, 0.9, 100),
            // The table's amplitude is defined through gravity.
            (BALL, 9.0, 10.0, 100),
        ];
        for (text, low, high, occurrences) in cases {
            let mut columns = columns(text, low, high, 37);
            columns.settings.backend = Backend::Interpreter;
            let expected = alone(&columns, occurrences);
            assert_eq!(in_lanes::<Lanes<8>>(&columns, occurrences), expected);
            #[cfg(target_arch = "x86_64")]
            if InstructionSet::detected() == InstructionSet::Avx512 {
                assert_eq!(in_lanes::<Registers>(&columns, occurrences), expected);
            }
        }
    }

    /// Impacts, the times of the latest two, and the end after so many other occurrences.
    type Passed = (u64, [u64; 2], End);

    #[test]
    fn impacts_that_pass_untold_are_counted_alone_and_in_lanes() {
        const OTHERS: usize = 12;
        let columns = columns(VALVE, 0.0195, 0.0225, 37);
        let mut work = columns.system.workspace::<f64>(&columns.settings);
        let mut follow = |most: Option<u64>| -> Vec<Passed> {
            let mut passed = Vec::new();
            for trajectory in &columns.trajectories {
                let mut trajectory = trajectory.clone();
                let (mut impacts, mut times, mut others) = (0, [0; 2], 0);
                trajectory.let_pass(most.unwrap_or(0));
                while others < OTHERS {
                    let told = trajectory.advance_to_horizon(&columns.system, &mut work);
                    let Some(told) = told.expect("a finite field") else {
                        continue;
                    };
                    count_untold(&mut trajectory, &mut impacts, &mut times);
                    trajectory.let_pass(most.unwrap_or(0));
                    match told {
                        Occurrence::Impact { .. } => {
                            impacts += 1;
                            times = [times[1], trajectory.time().to_bits()];
                        }
                        _ => others += 1,
                    }
                }
                passed.push((impacts, times, end(&trajectory)));
            }
            passed
        };
        let expected = follow(None);
        assert_eq!(follow(Some(3)), expected);
        assert_eq!(follow(Some(u64::MAX)), expected);

        let mut trajectories = columns.trajectories.clone();
        trajectories.iter_mut().for_each(|one| one.let_pass(7));
        let mut counts = vec![(0, [0; 2], 0); trajectories.len()];
        let mut found = vec![(0, [0; 2], (0, Vec::new())); trajectories.len()];
        let visit =
            |index: usize, trajectory: &mut Trajectory<f64>, told: Result<&_, FlowError>| {
                let (impacts, times, others) = &mut counts[index];
                count_untold(trajectory, impacts, times);
                trajectory.let_pass(7);
                match told.expect("a finite field") {
                    Occurrence::Impact { .. } => {
                        *impacts += 1;
                        *times = [times[1], trajectory.time().to_bits()];
                    }
                    _ => *others += 1,
                }
                if *others < OTHERS {
                    return Next::Continue;
                }
                found[index] = (*impacts, *times, end(trajectory));
                Next::Retire
            };
        let (system, settings) = (&columns.system, &columns.settings);
        Fleet::<Lanes<8>, _>::new(system, settings, &[0], &mut trajectories, visit)
            .run(&AtomicBool::new(false));
        assert_eq!(found, expected);
    }

    fn count_untold(trajectory: &mut Trajectory<f64>, impacts: &mut u64, times: &mut [u64; 2]) {
        if let Some((count, latest, before)) = trajectory.untold() {
            *impacts += count;
            let before = before.map_or(times[1], f64::to_bits);
            *times = [before, latest.to_bits()];
        }
    }
}
