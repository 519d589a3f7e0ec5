//! The modes of a system, each compiled when it is first met.
//!
//! Which contacts are closed says which equations hold. n contacts have 2^n such sets, of which a motion meets few: so none
//! is compiled in advance. Every mode is derived from the same expressions, whatever modes were met before it, so that its
//! results do not depend on the order of meeting, nor on threads.

use super::program::{Closed, Program};
use crate::expressions::Graph;
use core::fmt;
use std::sync::{Mutex, OnceLock, PoisonError};

/// Modes kept side by side; a further block follows when they are full.
const BLOCK: usize = 32;

/// One set of closed contacts.
#[derive(Debug)]
pub(crate) struct Mode {
    pub closed: Closed,
    /// None where these contacts cannot be held together.
    pub program: Option<Program>,
    /// Holds the expressions of the program's constants.
    pub graph: Graph,
}

/// All modes met so far, by number. They only ever become more, and stay where they are.
#[derive(Default)]
pub(crate) struct Modes {
    first: Block,
    building: Mutex<()>,
}

#[derive(Default)]
struct Block {
    modes: [OnceLock<Mode>; BLOCK],
    next: OnceLock<Box<Block>>,
}

impl Modes {
    /// The mode of a number that [`meet`](Self::meet) gave.
    #[inline]
    pub(crate) fn get(&self, number: usize) -> Option<&Mode> {
        if number < BLOCK {
            return self.first.modes[number].get();
        }
        let mut block = &self.first;
        for _ in 0..number / BLOCK {
            block = block.next.get()?;
        }
        block.modes[number % BLOCK].get()
    }

    /// The number of a set of closed contacts; it is built if it was never met before.
    pub(crate) fn meet(&self, closed: Closed, build: impl FnOnce() -> Mode) -> usize {
        if let Ok(known) = self.find(closed) {
            return known;
        }
        let _alone = (self.building.lock()).unwrap_or_else(PoisonError::into_inner);
        // Another thread may have been faster.
        let number = match self.find(closed) {
            Ok(known) => return known,
            Err(free) => free,
        };
        let mut block = &self.first;
        for _ in 0..number / BLOCK {
            block = block.next.get_or_init(Box::default);
        }
        block.modes[number % BLOCK].get_or_init(build);
        number
    }

    /// The number of a mode, or else the first that is free.
    fn find(&self, closed: Closed) -> Result<usize, usize> {
        let mut number = 0;
        let mut block = Some(&self.first);
        while let Some(here) = block {
            for mode in &here.modes {
                match mode.get() {
                    Some(mode) if mode.closed == closed => return Ok(number),
                    Some(_) => number += 1,
                    None => return Err(number),
                }
            }
            block = here.next.get().map(|next| &**next);
        }
        Err(number)
    }
}

impl fmt::Debug for Modes {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let known = (0..).map_while(|number| self.get(number));
        out.debug_list().entries(known).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mode(bits: u128) -> Mode {
        Mode {
            closed: Closed(bits),
            program: None,
            graph: Graph::default(),
        }
    }

    #[test]
    fn numbers_stay_whatever_comes_later() {
        let modes = Modes::default();
        let numbers: Vec<usize> = (0..100)
            .map(|bits| modes.meet(Closed(bits), || mode(bits)))
            .collect();
        assert_eq!(numbers, (0..100).collect::<Vec<_>>());
        for bits in (0..100_u128).rev() {
            let number = modes.meet(Closed(bits), || panic!("met before"));
            assert_eq!(
                modes.get(number).map(|mode| mode.closed),
                Some(Closed(bits))
            );
        }
        assert!(modes.get(100).is_none());
    }

    #[test]
    fn threads_agree_on_numbers() {
        let modes = Modes::default();
        let meet = |offset: u128| -> Vec<usize> {
            (0..70)
                .map(|k| (k * 11 + offset) % 70)
                .map(|bits| (bits, modes.meet(Closed(bits), || mode(bits))))
                .map(|(bits, number)| {
                    assert_eq!(
                        modes.get(number).map(|mode| mode.closed),
                        Some(Closed(bits))
                    );
                    number
                })
                .collect()
        };
        std::thread::scope(|scope| {
            let threads: Vec<_> = (0..4).map(|k| scope.spawn(move || meet(k * 13))).collect();
            for thread in threads {
                let mut numbers = thread.join().expect("no panic");
                numbers.sort_unstable();
                assert_eq!(numbers, (0..70).collect::<Vec<_>>());
            }
        });
    }
}
