//! Trajectories whose next steps run the same program at the same order with the same roots divided out.
//!
//! Some of them are aboard: their numbers stand side by side, lane by lane. Mostly an impact in flight is followed by another at the
//! same order, and then a trajectory stays in its lane, and nobody but the cohort knows what it did there; whoever leaves gets its row
//! back, and is told of its impacts then.

use super::WIDTH;
use super::rows::Rows;
use crate::flow::chatter::REMEMBERED;
use crate::flow::modes::guard::Transition;
use crate::flow::modes::program::Program;
use crate::flow::touching::Touching;
use crate::flow::trajectory::{Passed, Trajectory};
use crate::numerics::{LaneSet, Wide};

/// An impact with which a step begins: the guard that vanishes there, and its contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Start {
    pub guard: usize,
    pub contact: usize,
}

impl Start {
    /// The impact after which steps in free flight begin with such roots.
    pub fn of(program: &Program, touching: Touching) -> Option<Self> {
        let guards = program.guards.iter().enumerate();
        guards
            .filter(|_| program.is_free)
            .filter(|&(guard, _)| Touching::after(Some(guard)) == touching)
            .find_map(|(guard, what)| match what.transition {
                Transition::Impact { contact } => Some(Self { guard, contact }),
                _ => None,
            })
    }
}

/// By lane, who is there: there are no more than so many lanes.
pub(super) type Members = [usize; WIDTH];

/// The most impacts that a double counts one by one.
const COUNTED: u64 = 1 << 53;

/// See the [module's documentation](self).
#[derive(Clone, Debug)]
pub(super) struct Cohort<W> {
    /// Those who are not aboard yet.
    pub waiting: Vec<usize>,
    /// By lane, who is or was aboard.
    pub members: Members,
    aboard: LaneSet,
    /// How many lanes these are: to count them costs more than anything else does that is asked of all cohorts.
    count: usize,
    /// The rows of those aboard, side by side.
    pub block: Vec<W>,
    pub impacts: Impacts<W>,
}

/// The impacts of those aboard of which their trajectories do not know yet.
#[derive(Clone, Debug)]
pub(super) struct Impacts<W> {
    /// How many more may pass untold.
    allowed: W,
    /// How many a sequence has, and the rate of its latest.
    sequence: W,
    rate: W,
    /// Of the latest steps, in turn, their ends, and how long the sequences may still go on after them.
    latest: [(W, W); REMEMBERED],
    /// How many steps the cohort has made, and had when each lane was boarded.
    steps: u64,
    boarded: [u64; WIDTH],
}

impl<W: Wide> Impacts<W> {
    /// Where an impact passes untold.
    #[inline(always)]
    pub fn may_pass(&self) -> W::Mask {
        W::splat(1.0).at_most(self.allowed)
    }

    /// Takes note of a step, which ended in an impact that passes in some lanes.
    #[inline(always)]
    pub fn note(&mut self, passed: W::Mask, rate: W, end: (W, W)) {
        let one = W::splat(1.0);
        let longer = W::select(self.rate.less(rate), self.sequence + one, one);
        self.allowed = W::select(passed, self.allowed - one, self.allowed);
        self.sequence = W::select(passed, longer, self.sequence);
        self.rate = W::select(passed, rate, self.rate);
        self.latest[self.steps as usize % REMEMBERED] = end;
        self.steps += 1;
    }
}

impl<W: Wide> Cohort<W> {
    pub fn new() -> Self {
        let zero = W::splat(0.0);
        Self {
            waiting: Vec::new(),
            members: [0; WIDTH],
            aboard: LaneSet::NONE,
            count: 0,
            block: Vec::new(),
            impacts: Impacts {
                allowed: zero,
                sequence: zero,
                rate: zero,
                latest: [(zero, zero); REMEMBERED],
                steps: 0,
                boarded: [0; WIDTH],
            },
        }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.count + self.waiting.len()
    }

    /// The lanes of those aboard.
    #[inline(always)]
    pub fn aboard(&self) -> LaneSet {
        self.aboard
    }

    /// Lets only these stay aboard. Says which lanes are left.
    pub fn keep(&mut self, lanes: LaneSet) -> LaneSet {
        let left = self.aboard.without(lanes);
        self.aboard = self.aboard & lanes;
        self.count -= left.count();
        left
    }

    /// Lets those who wait aboard, as far as there are lanes. Says which these are.
    pub fn board(
        &mut self,
        start: Option<Start>,
        trajectories: &[Trajectory<f64>],
        width: usize,
    ) -> LaneSet {
        if self.block.len() < width {
            self.block.resize(width, W::splat(0.0));
        }
        let mut newcomers = LaneSet::NONE;
        for lane in LaneSet::first(W::LANES).without(self.aboard) {
            let Some(index) = self.waiting.pop() else {
                break;
            };
            newcomers = newcomers.with(lane);
            self.count += 1;
            self.members[lane] = index;
            if let Some(Start { contact, .. }) = start {
                let (allowed, sequence, rate) = trajectories[index].passing(contact);
                let impacts = &mut self.impacts;
                impacts.allowed.lanes_mut()[lane] = allowed.min(COUNTED) as f64;
                impacts.sequence.lanes_mut()[lane] = sequence as f64;
                impacts.rate.lanes_mut()[lane] = rate.unwrap_or(f64::INFINITY);
                impacts.boarded[lane] = impacts.steps;
            }
        }
        self.aboard = self.aboard | newcomers;
        newcomers
    }

    /// Lets a lane that nobody is in do what another does.
    #[inline(always)]
    pub fn fill_lanes(&mut self) {
        let Some(first) = self.aboard.into_iter().next() else {
            return;
        };
        for lane in LaneSet::first(W::LANES).without(self.aboard) {
            for wide in &mut self.block {
                let lanes = wide.lanes_mut();
                lanes[lane] = lanes[first];
            }
        }
    }

    /// Tells a trajectory, which leaves its lane, of its impacts there: of all steps, or all but the latest.
    #[inline(always)]
    pub fn tell(
        &self,
        lane: usize,
        (index, trajectory): (usize, &mut Trajectory<f64>),
        (start, program): (Start, &Program),
        (rows, but_latest): (&mut Rows, bool),
    ) {
        let lane = lane.min(W::LANES - 1);
        let impacts = &self.impacts;
        let began = impacts.boarded[lane];
        let count = (impacts.steps - began).saturating_sub(u64::from(but_latest));
        if count == 0 {
            return;
        }
        rows.note(index, Some(start.guard));
        let passed = Passed {
            count,
            sequence: impacts.sequence.lanes()[lane] as u64,
            rate: impacts.rate.lanes()[lane],
        };
        let guard = &program.guards[start.guard];
        trajectory.note_passed(guard, start.contact, passed, |number| {
            let (time, rest) = &impacts.latest[(began + number) as usize % REMEMBERED];
            (time.lanes()[lane], rest.lanes()[lane])
        });
    }

    /// Lets all who are aboard wait in their rows.
    pub fn disembark(
        &mut self,
        rows: &mut Rows,
        trajectories: &mut [Trajectory<f64>],
        (start, program): (Option<Start>, &Program),
    ) {
        let left = self.keep(LaneSet::NONE);
        if left == LaneSet::NONE {
            return;
        }
        rows.scatter(&self.members, &self.block, left);
        for lane in left {
            let index = self.members[lane];
            if let Some(start) = start {
                let trajectory = &mut trajectories[index];
                self.tell(lane, (index, trajectory), (start, program), (rows, false));
            }
            self.waiting.push(index);
        }
    }
}
