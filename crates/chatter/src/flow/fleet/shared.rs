//! Constants of tapes in lanes.

use crate::expressions::Tape;
use crate::flow::modes::at_contacts::ImpactTape;
use crate::flow::modes::program::{Program, ProgramConstants};
use crate::flow::system::System;
use crate::numerics::Wide;

/// Constants of the tapes of a mode: which of them differ between the trajectories of a fleet, and the others.
#[derive(Debug)]
pub(super) struct Shared<W> {
    pub varying_tape: Vec<usize>,
    pub varying_impacts: Vec<Vec<usize>>,
    pub tape: Vec<W>,
    pub impacts: Vec<Vec<W>>,
}

impl<W: Wide> Shared<W> {
    /// Takes what does not differ from any of the trajectories.
    pub fn new(
        system: &System,
        mode: usize,
        program: &Program,
        swept: &[usize],
        any: &ProgramConstants<f64>,
    ) -> Self {
        let splat = |values: &[f64]| values.iter().map(|&value| W::splat(value)).collect();
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
