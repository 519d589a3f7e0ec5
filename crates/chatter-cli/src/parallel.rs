//! Independent pieces of work on all cores, until Ctrl-C.

use crate::failure::Failure;
use crate::terminal;

/// As [`chatter_work::parallel::each`].
///
/// # Errors
/// That of the first piece to fail, or [`Failure::Interrupted`] after Ctrl-C.
pub fn each<P: Sync, T: Send>(
    pieces: &[P],
    work: impl Fn(&P) -> Result<T, Failure> + Sync,
) -> Result<Vec<T>, Failure> {
    chatter_work::parallel::each(pieces, terminal::interrupt_flag(), work)
}
