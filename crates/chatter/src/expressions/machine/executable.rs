//! Machine code in memory, and the call into it. One of three files with `unsafe`; what it rests on stands here and at
//! `is_sound` in [`compile`](super::compile).
//!
//! Memory is written while it cannot be executed, then made executable and never written again: by `memmap2`, whose
//! interface for that is safe.

use super::Places;
use super::assembler::Width;
use super::compile::{Layout, compile};
use crate::expressions::graph::Function;
use crate::expressions::series::MAX_ORDER;
use crate::expressions::tape::Tape;
use crate::numerics::dispatch::InstructionSet;
use crate::numerics::{Lanes, Registers, Scalar};
use core::any::TypeId;
use core::fmt;
use memmap2::{Mmap, MmapMut};

/// So much code is written out: all orders of the valve, and of the same with its derivative columns those
/// that short flights ask for.
const STRAIGHT: usize = 64 << 10;

/// What the code is called with. Lengths are those of [`Executable::run`]'s slices.
#[repr(C)]
pub(super) struct Frame {
    pub values: *mut f64,
    pub lows: *mut f64,
    pub auxiliaries: *mut f64,
    pub constants: *const f64,
    pub tau: *const f64,
    pub table: *const Table,
    pub order: usize,
}

/// Numbers that the code needs.
#[repr(C)]
pub(super) struct Table {
    pub reciprocals: [f64; MAX_ORDER + 2],
    pub numbers: [f64; MAX_ORDER + 1],
    pub negatives: [f64; MAX_ORDER + 1],
    pub minus_zero: [f64; 8],
    pub one: f64,
    pub half: f64,
    pub two: f64,
    pub minus_two: f64,
}

pub(super) static TABLE: Table = {
    let mut table = Table {
        reciprocals: [0.0; MAX_ORDER + 2],
        numbers: [0.0; MAX_ORDER + 1],
        negatives: [-0.0; MAX_ORDER + 1],
        minus_zero: [-0.0; 8],
        one: 1.0,
        half: 0.5,
        two: 2.0,
        minus_two: -2.0,
    };
    let mut k = 0;
    while k <= MAX_ORDER {
        table.numbers[k] = k as f64;
        table.negatives[k] = -(k as f64);
        table.reciprocals[k + 1] = 1.0 / (k + 1) as f64;
        k += 1;
    }
    table
};

/// What the code calls.
#[derive(Clone, Copy)]
pub(super) enum Callee {
    Function(Function),
    SineCosine,
    Power,
}

/// So many doubles: two to read from, or one to read and one to write, and one to write to.
type Called = unsafe extern "sysv64" fn(*const f64, *mut f64, *mut f64, usize);

macro_rules! callee {
    ($function:expr) => {{
        unsafe extern "sysv64" fn called(from: *const f64, _: *mut f64, to: *mut f64, count: usize) {
            for i in 0..count {
                // SAFETY: the code passes the lanes of one chunk of numbers that it may read and write.
                unsafe { *to.add(i) = $function(*from.add(i)) };
            }
        }
        called
    }};
}

unsafe extern "sysv64" fn sine_cosine(
    from: *const f64,
    sine: *mut f64,
    cosine: *mut f64,
    count: usize,
) {
    for i in 0..count {
        // SAFETY: as for the others.
        unsafe { (*sine.add(i), *cosine.add(i)) = Scalar::sin_cos(*from.add(i)) };
    }
}

unsafe extern "sysv64" fn power(base: *const f64, exponent: *mut f64, to: *mut f64, count: usize) {
    for i in 0..count {
        // SAFETY: as for the others.
        unsafe { *to.add(i) = Scalar::powf(*base.add(i), *exponent.add(i)) };
    }
}

/// Address of what is called.
pub(super) fn function_of(callee: Callee) -> usize {
    let called: Called = match callee {
        Callee::SineCosine => sine_cosine,
        Callee::Power => power,
        Callee::Function(function) => match function {
            Function::Exp => callee!(<f64 as Scalar>::exp),
            Function::Ln => callee!(<f64 as Scalar>::ln),
            Function::Sin => callee!(|x: f64| Scalar::sin_cos(x).0),
            Function::Cos => callee!(|x: f64| Scalar::sin_cos(x).1),
            Function::Tan => callee!(<f64 as Scalar>::tan),
            Function::Asin => callee!(<f64 as Scalar>::asin),
            Function::Acos => callee!(<f64 as Scalar>::acos),
            Function::Atan => callee!(<f64 as Scalar>::atan),
            Function::Sinh => callee!(<f64 as Scalar>::sinh),
            Function::Cosh => callee!(<f64 as Scalar>::cosh),
            Function::Tanh => callee!(<f64 as Scalar>::tanh),
        },
    };
    called as usize
}

/// How many doubles side by side a number is, where it is nothing else.
///
/// Types are compared, not asked: nobody else's type can claim to be one of these.
pub(super) fn lanes_of<S: 'static>() -> Option<usize> {
    let is = |id: TypeId| TypeId::of::<S>() == id;
    if is(TypeId::of::<f64>()) {
        Some(1)
    } else if is(TypeId::of::<Lanes<4>>()) {
        Some(4)
    } else if is(TypeId::of::<Lanes<8>>()) {
        Some(8)
    } else if is(TypeId::of::<Lanes<16>>()) || is(TypeId::of::<Registers>()) {
        Some(16)
    } else if is(TypeId::of::<Lanes<32>>()) {
        Some(32)
    } else {
        None
    }
}

/// A tape's code for numbers that are so many doubles.
pub(crate) struct Executable {
    memory: Mmap,
    lanes: usize,
    stride: usize,
    /// Least lengths of what it is called with.
    slots: usize,
    auxiliaries: usize,
    constants: usize,
}

impl Executable {
    /// None where the processor has no instructions for these numbers, the tape is too long, or the system gives no memory
    /// to execute.
    pub(super) fn new<S: 'static>(tape: &Tape, stride: usize) -> Option<Self> {
        let lanes = lanes_of::<S>()?;
        let width = match InstructionSet::detected() {
            _ if lanes == 1 => Width::One,
            InstructionSet::Avx512 if lanes.is_multiple_of(8) => Width::Eight,
            _ => Width::Four,
        };
        if InstructionSet::detected() == InstructionSet::Baseline {
            return None;
        }
        let layout = Layout {
            lanes,
            size: size_of::<S>(),
            stride,
            straight: STRAIGHT,
        };
        let code = compile(tape, layout, width)?;
        let mut memory = MmapMut::map_anon(code.len()).ok()?;
        memory.copy_from_slice(&code);
        Some(Self {
            memory: memory.make_exec().ok()?,
            lanes,
            stride,
            slots: tape.slots,
            auxiliaries: tape.auxiliaries,
            constants: tape.constants.len(),
        })
    }

    /// Computes all coefficients up to an order from those of order zero of the states.
    ///
    /// # Panics
    /// If something is shorter than the tape needs, or the order higher than there is room for.
    #[inline]
    pub(crate) fn run<S: 'static>(&self, places: Places<'_, S>, order: usize) {
        assert!(
            lanes_of::<S>() == Some(self.lanes)
                && order < self.stride
                && order <= MAX_ORDER
                && places.values.len() >= self.slots * self.stride
                && places.lows.len() >= self.slots
                && places.auxiliaries.len() >= self.auxiliaries
                && places.constants.len() >= self.constants,
            "places that do not fit the code"
        );
        let frame = Frame {
            values: places.values.as_mut_ptr().cast(),
            lows: places.lows.as_mut_ptr().cast(),
            auxiliaries: places.auxiliaries.as_mut_ptr().cast(),
            constants: places.constants.as_ptr().cast(),
            tau: (&raw const *places.tau).cast(),
            table: &raw const TABLE,
            order,
        };
        // SAFETY: the memory holds, from its start on, code that `compile` made for numbers of this type, which are plain
        // doubles (`lanes_of`) at the distances of its layout, with instructions that this processor was found to have. It
        // begins and ends as the calling convention asks. It reads and writes coefficients below `stride` of series below
        // `slots`, auxiliaries and constants below their counts, which `is_sound` has found all its operations to keep to and
        // which exist by the assertion above, the whole number `tau`, the table, and the stack below its own frame; nothing
        // else. The slices are borrowed for as long as it runs, and memory that is executed is never written.
        unsafe {
            let code: unsafe extern "sysv64" fn(*const Frame) =
                core::mem::transmute(self.memory.as_ptr());
            code(&raw const frame);
        }
    }
}

impl fmt::Debug for Executable {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "Executable({} bytes)", self.memory.len())
    }
}
