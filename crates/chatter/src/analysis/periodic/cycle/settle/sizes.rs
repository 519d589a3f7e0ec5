//! Sizes of states on a motion.

use crate::analysis::periodic::closure::Turn;
use crate::analysis::periodic::cycle::trace::Instant;
use crate::analysis::periodic::shooting::{Workshop, take_in_moves, without_zeros};

/// A motion whose states have all become so small a part of the greatest goes to rest at zero.
pub(crate) const DIED_OUT: f64 = 1e-15;

/// Sizes of states.
pub(crate) fn sizes<'s>(
    states: impl IntoIterator<Item = &'s Vec<f64>>,
    turns: &[Turn<f64>],
) -> Vec<f64> {
    let mut sizes: Vec<f64> = Vec::new();
    for state in states {
        sizes.resize(state.len(), 0.0);
        for (size, x) in sizes.iter_mut().zip(state) {
            *size = size.max(x.abs());
        }
    }
    for turn in turns {
        sizes[turn.state] = turn.period;
    }
    without_zeros(sizes)
}

/// The states of instants.
pub(crate) fn states(instants: &[Instant]) -> impl Iterator<Item = &Vec<f64>> {
    instants.iter().map(|instant| &instant.state)
}

/// Whether a state is a phase.
pub(crate) fn is_phase(turns: &[Turn<f64>], index: usize) -> bool {
    turns.iter().any(|turn| turn.state == index)
}

/// The largest entry of a state among those that count.
pub(super) fn size(state: &[f64], counts: impl Fn(usize) -> bool) -> f64 {
    let all = state.iter().enumerate();
    all.filter(|(index, _)| counts(*index))
        .fold(0.0, |size, (_, x)| size.max(x.abs()))
}

/// The most that each state has been on a motion.
pub(crate) struct Most(pub Vec<f64>);

impl Most {
    pub(super) fn take_in<'s>(&mut self, states: impl IntoIterator<Item = &'s Vec<f64>>) {
        for state in states {
            for (most, x) in self.0.iter_mut().zip(state) {
                *most = most.max(x.abs());
            }
        }
    }

    /// Sizes of states on what may be a cycle: of what has died out there is nothing left that would tell how near two states are.
    fn sizes<'s>(
        &self,
        states: impl IntoIterator<Item = &'s Vec<f64>>,
        turns: &[Turn<f64>],
    ) -> Vec<f64> {
        let mut sizes = sizes(states, turns);
        for (size, most) in sizes.iter_mut().zip(&self.0) {
            *size = size.max(DIED_OUT * most);
        }
        sizes
    }

    /// The same: a state that is zero at all of them has the size of how far it moves in the time from each to the next.
    pub(super) fn sizes_along(
        &self,
        (workshop, parameters): (&Workshop, &[f64]),
        ways: &[(&Vec<f64>, f64)],
        turns: &[Turn<f64>],
    ) -> Vec<f64> {
        let mut sizes = self.sizes(ways.iter().map(|(state, _)| *state), turns);
        let ways = ways.iter().map(|&(state, time)| (&**state, time));
        take_in_moves(&mut sizes, (&workshop.model, parameters), ways);
        for turn in turns {
            sizes[turn.state] = turn.period;
        }
        sizes
    }

    /// The same at instants.
    pub(super) fn sizes_at(
        &self,
        known: (&Workshop, &[f64]),
        instants: &[Instant],
        turns: &[Turn<f64>],
    ) -> Vec<f64> {
        let times = instants.windows(2).map(|pair| pair[1].time - pair[0].time);
        let ways = instants.iter().zip(times.chain([0.0]));
        let ways: Vec<_> = ways.map(|(at, time)| (&at.state, time)).collect();
        self.sizes_along(known, &ways, turns)
    }
}

/// Whether the latest of these states is next to nothing, against the most that states have been, and phases go round no more; as far
/// as what happens depends on them.
pub(super) fn is_next_to_nothing(
    instants: &[Instant],
    (turns, matters): (&[Turn<f64>], &[bool]),
    most: &Most,
) -> bool {
    let [.., before, latest] = instants else {
        return false;
    };
    let stands = |turn: &Turn<f64>| {
        let turned = latest.state[turn.state] - before.state[turn.state];
        turned.abs() <= DIED_OUT * turn.period
    };
    let size_seen = |state: &[f64]| size(state, |index| matters[index] && !is_phase(turns, index));
    // Zero itself is what a reset makes of a state.
    let here = size_seen(&latest.state);
    let mut seen = turns.iter().filter(|turn| matters[turn.state]);
    here > 0.0 && here <= DIED_OUT * size_seen(&most.0) && seen.all(stands)
}
