//! Independent pieces of work, side by side on all cores.

use crate::refusal::Refusal;
use chatter::analysis::diagram::{Executor, Threads};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// What pieces share. One that panicked takes nothing from the others.
pub fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What `work` makes of each piece, in the order of the pieces, in which they are begun too: whatever takes long is best
/// among the first.
///
/// # Errors
/// That of the first piece to fail, or [`Refusal::Interrupted`] once `stop` is set. No piece is begun after that.
pub fn each<P: Sync, T: Send>(
    pieces: &[P],
    stop: &AtomicBool,
    work: impl Fn(&P) -> Result<T, Refusal> + Sync,
) -> Result<Vec<T>, Refusal> {
    let next = AtomicUsize::new(0);
    let made = Mutex::new(Vec::with_capacity(pieces.len()));
    Threads::available().run(&|| {
        while !stop.load(Ordering::Relaxed) {
            let place = next.fetch_add(1, Ordering::Relaxed);
            let Some(piece) = pieces.get(place) else {
                break;
            };
            let result = work(piece);
            if result.is_err() {
                next.store(pieces.len(), Ordering::Relaxed);
            }
            lock(&made).push((place, result));
        }
    });
    if stop.load(Ordering::Relaxed) {
        return Err(Refusal::Interrupted);
    }
    let mut made = made.into_inner().unwrap_or_else(PoisonError::into_inner);
    // Pieces are begun in order, so the first failure has everything before it.
    made.sort_unstable_by_key(|&(place, _)| place);
    made.into_iter().map(|(_, result)| result).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    static GO_ON: AtomicBool = AtomicBool::new(false);

    #[test]
    fn results_stand_in_the_order_of_the_pieces() {
        let pieces: Vec<u64> = (0..1000).collect();
        let squares = each(&pieces, &GO_ON, |&n| Ok(n * n)).unwrap();
        assert!(
            squares
                .iter()
                .zip(&pieces)
                .all(|(square, n)| *square == n * n)
        );
        assert_eq!(squares.len(), 1000);
        assert!(each(&[] as &[u64], &GO_ON, |&n| Ok(n)).unwrap().is_empty());
    }

    #[test]
    fn the_first_failure_is_the_one_that_is_told() {
        let pieces: Vec<u64> = (0..1000).collect();
        let result = each(&pieces, &GO_ON, |&n| match n {
            0..300 => Ok(n),
            _ => Err(Refusal::input(format!("no {n}"))),
        });
        assert!(matches!(result, Err(Refusal::Input { message, .. }) if message == "no 300"));
    }
}
