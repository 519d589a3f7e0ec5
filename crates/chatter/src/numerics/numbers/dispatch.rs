//! Runs a kernel compiled for what the processor offers.
//!
//! A kernel is inlined into each of the wrappers below and so compiled once for AVX-512, once for AVX2 and once for the
//! baseline; the arithmetic is the same to the bit (fused multiply-add is exact everywhere, hardware or library). With
//! `unsafe`: calling a wrapper is sound because its features were just detected.

/// A computation to be compiled for several instruction sets. `run` must be `#[inline(always)]`, and so must be what it
/// calls in its inner loops.
pub trait Kernel {
    /// What it computes.
    type Output;
    /// Computes it.
    fn run(self) -> Self::Output;
}

/// What is told apart among processors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum InstructionSet {
    /// Whatever every processor of its kind has.
    Baseline,
    /// Four doubles a register, and fused multiply-add.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// Eight.
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl InstructionSet {
    /// The widest that this processor has.
    #[inline]
    pub(crate) fn detected() -> Self {
        #[cfg(target_arch = "x86_64")]
        {
            if has_avx512() {
                return Self::Avx512;
            }
            if has_avx2() {
                return Self::Avx2;
            }
        }
        Self::Baseline
    }
}

/// Runs the kernel with the widest instruction set that this processor has. Not inlined: each caller would have a baseline of its
/// own.
#[inline(never)]
pub fn dispatch<K: Kernel>(kernel: K) -> K::Output {
    match InstructionSet::detected() {
        // SAFETY: the features that the wrapper enables were detected on this processor.
        #[cfg(target_arch = "x86_64")]
        InstructionSet::Avx512 => unsafe { run_avx512(kernel) },
        // SAFETY: as above.
        #[cfg(target_arch = "x86_64")]
        InstructionSet::Avx2 => unsafe { run_avx2(kernel) },
        _ => kernel.run(),
    }
}

/// Whether vectors of numbers are worth while on this processor: without registers for four and fused multiply-add they are not.
#[inline]
pub(crate) fn has_wide_registers() -> bool {
    !cfg!(target_arch = "x86_64") || InstructionSet::detected() != InstructionSet::Baseline
}

/// As [`dispatch`], for kernels that are asked for where [`has_wide_registers`] only, and whose numbers are arrays: they are the
/// largest, and for narrow registers would be larger than all others together. For AVX-512 there are numbers of its own
/// ([`dispatch_avx512`]).
#[inline(never)]
pub(crate) fn dispatch_wide<K: Kernel>(kernel: K) -> Option<K::Output> {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: the features that the wrapper enables were detected on this processor.
    return has_avx2().then(|| unsafe { run_avx2(kernel) });
    #[cfg(not(target_arch = "x86_64"))]
    Some(kernel.run())
}

/// Runs a kernel whose numbers are registers of AVX-512; nothing where the processor has none.
#[cfg(target_arch = "x86_64")]
#[inline(never)]
pub(crate) fn dispatch_avx512<K: Kernel>(kernel: K) -> Option<K::Output> {
    // SAFETY: the features that the wrapper enables were detected on this processor.
    has_avx512().then(|| unsafe { run_avx512(kernel) })
}

/// Runs a kernel whose numbers are single ones, for which wide registers do nothing: with fused multiply-add or without.
#[inline(never)]
pub fn dispatch_narrow<K: Kernel>(kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    if has_avx2() {
        // SAFETY: the features that the wrapper enables were detected on this processor.
        return unsafe { run_avx2(kernel) };
    }
    kernel.run()
}

/// Whether eight doubles fit a register of this processor.
#[cfg(target_arch = "x86_64")]
#[inline]
fn has_avx512() -> bool {
    std::is_x86_feature_detected!("avx512f")
        && std::is_x86_feature_detected!("avx512vl")
        && std::is_x86_feature_detected!("avx512dq")
        && std::is_x86_feature_detected!("avx512bw")
        && has_avx2()
}

/// Whether four do, and products and sums are rounded at once.
#[cfg(target_arch = "x86_64")]
#[inline]
fn has_avx2() -> bool {
    std::is_x86_feature_detected!("avx2") && std::is_x86_feature_detected!("fma")
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw,avx2,fma")]
fn run_avx512<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn run_avx2<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
}
