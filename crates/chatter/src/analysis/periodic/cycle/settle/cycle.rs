//! A cycle as far as a trajectory shows it.

use super::sizes::{sizes, states};
use crate::analysis::periodic::closure::Turn;
use crate::analysis::periodic::cycle::itinerary::{Step, around, read};
use crate::analysis::periodic::cycle::rotate::{past_instant, rotate, turned};
use crate::analysis::periodic::cycle::trace::Instant;
use crate::analysis::periodic::error::PeriodicError;
use crate::analysis::periodic::shooting::Workshop;
use crate::flow::GuardKind;

/// A cycle as far as a trajectory shows it.
#[derive(Clone, Debug)]
pub(crate) struct Cycle {
    pub steps: Vec<Step>,
    pub counts: Vec<i64>,
    /// How far from closed it is, against the size of the state.
    pub distance: f64,
    /// The size of each state that tells so: on the motion that led there, which need not be its size on the cycle.
    pub sizes: Vec<f64>,
}

/// A cycle has drifted far if it has gone so many times as far as it goes itself.
const DRIFTED: f64 = 8.0;

impl Cycle {
    /// How long it takes.
    pub(crate) fn duration(&self) -> f64 {
        self.steps.iter().map(|step| step.duration).sum()
    }

    /// Takes the cycle back to where states that nothing depends on are zero, where it has drifted so far from there that what they do on it
    /// is little beside: their sizes are of its motion, not of its way there.
    pub(crate) fn come_back(&mut self, workshop: &Workshop) {
        let Some(first) = self.steps.first().map(|step| step.start.clone()) else {
            return;
        };
        // Counters tell by what they are which side holds.
        let model = &workshop.model;
        let moves = |state: usize| {
            !model
                .graph
                .symbols(model.states[state].derivative)
                .is_empty()
        };
        let is_place = |state: usize| moves(state) && !workshop.closure.is_phase(state);
        let idle = workshop.closure.idle.iter();
        for free in idle.filter(|free| is_place(free.state)) {
            let gone = first[free.state];
            let on = |step: &Step| (step.start[free.state] - gone).abs();
            let span = self.steps.iter().map(on).fold(0.0, f64::max);
            if gone.abs() > DRIFTED * span && span > 0.0 {
                for step in &mut self.steps {
                    free.carry(&mut step.start, -gone);
                }
            }
        }
    }

    /// Begins the cycle at the section, if it is crossed.
    pub(crate) fn begin_at_section(
        &mut self,
        workshop: &Workshop,
        parameters: &[f64],
    ) -> Result<(), PeriodicError> {
        let Some(section) = workshop.section else {
            return Ok(());
        };
        let ends_there = |step: &Step| step.ends_at() == Some(GuardKind::Section(section));
        let Some(index) = self.steps.iter().position(ends_there) else {
            return Ok(());
        };
        let moved = around(index, 1, self.steps.len());
        let cycle = (&mut *self.steps, &*self.counts);
        rotate(workshop, parameters, cycle, moved)
    }
}

/// Tells steps from the first turn of each phase, where phases have most digits and change least with their rate; a phase that goes
/// round no times from the turn nearest to zero. Pieces of lookups are numbered on from turn to turn where they are asked at a phase: then
/// phases stay what they are.
pub(crate) fn from_first_turn(
    known: (&Workshop, &[f64]),
    steps: &mut [Step],
    turns: &[Turn<f64>],
    counts: &[i64],
) {
    let Some(first) = steps.first().map(|step| &step.start) else {
        return;
    };
    let whole = turns.iter().zip(counts).map(|(turn, &count)| {
        let gone = first[turn.state] / turn.period;
        if count == 0 {
            gone.round()
        } else {
            gone.floor()
        }
    });
    let by: Vec<i64> = whole.map(|whole| -(whole as i64)).collect();
    if by.iter().any(|&by| by != 0) {
        let told = turned(known, turns, (steps, counts), &by);
        let in_same_pieces = |(step, told): (&Step, &Step)| step.pieces == told.pieces;
        if steps.iter().zip(&told).all(in_same_pieces) {
            steps.clone_from_slice(&told);
        }
    }
}

/// The cycle between two instants, where states have these sizes.
pub(super) fn cycle(
    (workshop, parameters): (&Workshop, &[f64]),
    turns: &[Turn<f64>],
    instants: &[Instant],
    sizes: &[f64],
) -> Result<Cycle, PeriodicError> {
    let mut steps = read((&workshop.system, parameters), instants)?;
    let (first, last) = (&instants[0].state, &instants[instants.len() - 1].state);
    let difference = workshop.closure.difference(turns, (first, last), sizes);
    past_instant(workshop, parameters, (&mut steps, &difference.turns))?;
    from_first_turn((workshop, parameters), &mut steps, turns, &difference.turns);
    Ok(Cycle {
        steps,
        counts: difference.turns,
        distance: difference.distance,
        sizes: sizes.to_vec(),
    })
}

/// The cycle between two instants, where only it says what sizes states have.
pub(super) fn alone(
    (workshop, parameters): (&Workshop, &[f64]),
    turns: &[Turn<f64>],
    instants: &[Instant],
) -> Result<Cycle, PeriodicError> {
    let sizes = sizes(states(instants), turns);
    cycle((workshop, parameters), turns, instants, &sizes)
}
