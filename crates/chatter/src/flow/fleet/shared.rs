//! Constants of tapes in lanes, and those of each trajectory that differ, side by side.

use crate::expressions::Tape;
use crate::flow::program::{ImpactTape, Program, ProgramConstants};
use crate::flow::system::System;
use crate::numerics::{Lanes, Scalar};

/// Constants of the tapes of a mode: which of them differ between the trajectories of a fleet, and the others.
#[derive(Debug)]
pub(super) struct Shared<const L: usize> {
    pub varying_tape: Vec<usize>,
    pub varying_impacts: Vec<Vec<usize>>,
    pub tape: Vec<Lanes<L>>,
    pub impacts: Vec<Vec<Lanes<L>>>,
}

impl<const L: usize> Shared<L> {
    /// Takes what does not differ from any of the trajectories.
    pub fn new(
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

    /// How many constants differ.
    pub fn varying(&self) -> usize {
        self.varying_tape.len() + self.varying_impacts.iter().map(Vec::len).sum::<usize>()
    }
}

/// For each trajectory of a fleet the constants of its mode that differ: next to each other, where its own lie scattered.
#[derive(Debug)]
pub(super) struct Rows {
    /// Places of a row; a mode may use fewer.
    stride: usize,
    values: Vec<f64>,
    /// Whether the row holds what the trajectory does.
    is_fresh: Vec<bool>,
}

impl Rows {
    /// Rows for so many trajectories.
    pub fn new(trajectories: usize) -> Self {
        Self {
            stride: 0,
            values: Vec::new(),
            is_fresh: vec![false; trajectories],
        }
    }

    /// Makes room for a mode in which so many constants differ.
    pub fn widen(&mut self, count: usize) {
        if count > self.stride {
            self.stride = count;
            self.values = vec![0.0; count * self.is_fresh.len()];
            self.is_fresh.fill(false);
        }
    }

    /// A trajectory may have entered another mode, or have other constants.
    pub fn forget(&mut self, index: usize) {
        self.is_fresh[index] = false;
    }

    /// The row of a trajectory in a mode.
    #[inline(always)]
    pub fn get<const L: usize>(
        &mut self,
        index: usize,
        shared: &Shared<L>,
        own: &Option<ProgramConstants<f64>>,
    ) -> &[f64] {
        let row = &mut self.values[index * self.stride..][..self.stride];
        if let (false, Some(own)) = (self.is_fresh[index], own) {
            let tape = shared.varying_tape.iter().map(|&place| own.tape[place]);
            let impacts = own.impacts.iter().zip(&shared.varying_impacts);
            let impacts = impacts.flat_map(|(own, places)| places.iter().map(|&place| own[place]));
            for (value, constant) in row.iter_mut().zip(tape.chain(impacts)) {
                *value = constant;
            }
            self.is_fresh[index] = true;
        }
        row
    }
}
