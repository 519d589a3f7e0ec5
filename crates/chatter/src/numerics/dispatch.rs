//! Runs a kernel compiled for what the processor offers.
//!
//! A kernel is inlined into each of the wrappers below and so compiled once for AVX-512, once for AVX2 and once for the
//! baseline; the arithmetic is the same to the bit (fused multiply-add is exact everywhere, hardware or library). The
//! one place with `unsafe`: calling a wrapper is sound because its features were just detected.

/// A computation to be compiled for several instruction sets. `run` must be `#[inline(always)]`, and so must be what it
/// calls in its inner loops.
pub trait Kernel {
    /// What it computes.
    type Output;
    /// Computes it.
    fn run(self) -> Self::Output;
}

/// Runs the kernel with the widest instruction set that this processor has.
#[inline]
pub fn dispatch<K: Kernel>(kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    {
        if has_avx512() {
            // SAFETY: the features that the wrapper enables were detected on this processor.
            return unsafe { run_avx512(kernel) };
        }
        if std::is_x86_feature_detected!("avx2") && std::is_x86_feature_detected!("fma") {
            // SAFETY: as above.
            return unsafe { run_avx2(kernel) };
        }
    }
    kernel.run()
}

/// Runs a kernel whose numbers are single ones, for which wide registers do nothing: with fused multiply-add or without.
#[inline]
pub fn dispatch_narrow<K: Kernel>(kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    if std::is_x86_feature_detected!("avx2") && std::is_x86_feature_detected!("fma") {
        // SAFETY: the features that the wrapper enables were detected on this processor.
        return unsafe { run_avx2(kernel) };
    }
    kernel.run()
}

/// Whether eight doubles fit a register of this processor.
#[inline]
fn has_avx512() -> bool {
    #[cfg(target_arch = "x86_64")]
    {
        std::is_x86_feature_detected!("avx512f")
            && std::is_x86_feature_detected!("avx512vl")
            && std::is_x86_feature_detected!("avx512dq")
            && std::is_x86_feature_detected!("avx512bw")
            && std::is_x86_feature_detected!("fma")
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        false
    }
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
