//! What computations run on: one double, several side by side, pairs of doubles, numbers that know the size of their terms; and
//! kernels compiled for each of them.

pub mod dispatch;
pub(super) mod double_double;
pub(super) mod lanes;
#[cfg(target_arch = "x86_64")]
pub(super) mod registers;
pub(super) mod rounded;
pub(super) mod scalar;
pub(crate) mod stored;
pub(super) mod with_terms;
