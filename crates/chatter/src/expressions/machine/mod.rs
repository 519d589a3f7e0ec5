//! Tapes as machine code: what the interpreter does, in the same sequence, without looking up what to do.
//!
//! ```text
//! Backend       which of the two runs a tape, from when on
//! assembler     instructions for registers of one, four or eight doubles
//! compile       a tape's operations as such: at order zero, above it, and whether all is there that they name
//! straight      orders above zero written out, where there are registers for it
//! group         the registers of a number
//! executable    memory that is executed
//! ```

#[cfg(target_arch = "x86_64")]
mod assembler;
#[cfg(target_arch = "x86_64")]
mod compile;
#[cfg(all(test, target_arch = "x86_64"))]
mod emulated;
#[cfg(target_arch = "x86_64")]
mod executable;
#[cfg(not(target_arch = "x86_64"))]
#[path = "none.rs"]
mod executable;
#[cfg(target_arch = "x86_64")]
mod group;
#[cfg(target_arch = "x86_64")]
mod straight;

use super::tape::Tape;
use crate::numerics::dispatch::InstructionSet;
use core::sync::atomic::{AtomicU8, Ordering};
pub(super) use executable::Executable;
use std::sync::OnceLock;

/// What runs tapes. The results are the same to the bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Backend {
    /// Machine code for what is run often, where the processor has AVX2; else the interpreter.
    Compiled,
    /// The interpreter alone.
    Interpreter,
    /// As `Compiled`, from the first run on: for tests.
    CompiledAtOnce,
}

/// What is taken where nothing else is said, for the whole process.
static DEFAULT: AtomicU8 = AtomicU8::new(0);

impl Default for Backend {
    fn default() -> Self {
        let all = [Self::Compiled, Self::Interpreter, Self::CompiledAtOnce];
        all[usize::from(DEFAULT.load(Ordering::Relaxed))]
    }
}

/// So many numbers are run through the interpreter before a tape is compiled: that takes longer than the compiler.
const PATIENCE: usize = 2000;

impl Backend {
    /// Makes this what is taken from now on where nothing else is said.
    pub fn make_default(self) {
        DEFAULT.store(self as u8, Ordering::Relaxed);
    }

    /// Whether this processor runs what is compiled.
    pub fn is_available() -> bool {
        cfg!(target_arch = "x86_64") && InstructionSet::detected() != InstructionSet::Baseline
    }

    /// In place of a number of runs.
    pub(super) const NEVER: u32 = u32::MAX;

    /// How many runs are interpreted.
    pub(super) fn patience<S>(self) -> u32 {
        match self {
            Self::Compiled => (PATIENCE * size_of::<f64>() / size_of::<S>()) as u32,
            Self::CompiledAtOnce => 0,
            Self::Interpreter => Self::NEVER,
        }
    }
}

/// What a run reads and writes.
#[cfg_attr(not(target_arch = "x86_64"), expect(dead_code))]
pub(crate) struct Places<'a, S> {
    pub values: &'a mut [S],
    pub lows: &'a mut [S],
    pub auxiliaries: &'a mut [S],
    pub constants: &'a [S],
    pub tau: &'a S,
}

/// The code of one tape, for each kind of number that it was run on often.
#[derive(Debug, Default)]
pub(crate) struct Compiled {
    kinds: [OnceLock<Option<Executable>>; KINDS],
}

const KINDS: usize = 5;

/// Whoever changes the clone of a tape finds no code for what it was.
impl Clone for Compiled {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl Compiled {
    /// The code of the tape that this belongs to; none where it is interpreted.
    #[inline]
    pub(super) fn get<S: 'static>(&self, tape: &Tape, stride: usize) -> Option<&Executable> {
        self.kind::<S>()?
            .get_or_init(|| Executable::new::<S>(tape, stride))
            .as_ref()
    }

    pub(super) fn has<S: 'static>(&self) -> bool {
        let known = self.kind::<S>().and_then(OnceLock::get);
        known.is_some_and(Option::is_some)
    }

    #[inline]
    fn kind<S: 'static>(&self) -> Option<&OnceLock<Option<Executable>>> {
        // One, four, eight, …: two lanes are no kind.
        let kind = executable::lanes_of::<S>()?.ilog2() as usize;
        self.kinds.get(kind.saturating_sub(1))
    }
}
