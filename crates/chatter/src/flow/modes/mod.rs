//! The modes of a system, each compiled when it is first met.
//!
//! A mode is which contacts are closed and on which side of each surface the state is; that says which equations hold. n of
//! them have 2^n such sets and more, of which a motion meets few: so none is compiled in advance. Every mode is derived from the same expressions, whatever modes were met before it, so that its
//! results do not depend on the order of meeting, nor on threads.

pub(super) mod at_contacts;
pub(super) mod closed;
pub(super) mod equations;
pub(super) mod guard;
mod guarded;
pub(super) mod limits;
pub(super) mod looked_up;
pub(super) mod program;
mod source;
pub(super) mod standing;

use super::touch::Touches;
use crate::expressions::{Graph, Sides, Surfaces};
use crate::model::OnSides;
use closed::Grip;
use core::fmt;
use program::Program;
use std::sync::{Mutex, OnceLock, PoisonError};

/// Modes kept side by side; a further block follows when they are full.
const BLOCK: usize = 32;

/// One set of closed contacts and sides.
#[derive(Debug)]
pub(crate) struct Mode {
    pub grip: Grip,
    pub sides: Sides,
    /// The surfaces whose side matters here.
    pub surfaces: Surfaces,
    /// None where these contacts and surfaces cannot be held together.
    pub program: Option<Program>,
    /// Holds the expressions of the program's constants.
    pub graph: Graph,
    /// Where nothing is closed: what modes with the same sides are derived from.
    pub flight: Option<Box<Flight>>,
}

/// What holds on the same sides whatever is closed.
#[derive(Debug)]
pub(crate) struct Flight {
    pub on_sides: OnSides,
    pub touches: Touches,
}

impl Mode {
    fn is(&self, grip: Grip, sides: Sides) -> bool {
        self.grip == grip && self.sides.agree(sides, self.surfaces)
    }
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

    /// The number of a mode; it is built if it was never met before.
    pub(crate) fn meet(&self, (grip, sides): (Grip, Sides), build: impl FnOnce() -> Mode) -> usize {
        if let Ok(known) = self.find(grip, sides) {
            return known;
        }
        let _alone = (self.building.lock()).unwrap_or_else(PoisonError::into_inner);
        // Another thread may have been faster.
        let number = match self.find(grip, sides) {
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
    fn find(&self, grip: Grip, sides: Sides) -> Result<usize, usize> {
        let mut number = 0;
        let mut block = Some(&self.first);
        while let Some(here) = block {
            for mode in &here.modes {
                match mode.get() {
                    Some(mode) if mode.is(grip, sides) => return Ok(number),
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
    use crate::flow::modes::closed::Closed;

    fn grip(bits: u128) -> Grip {
        Grip {
            closed: Closed(bits),
            idle: Closed::NONE,
        }
    }

    fn mode(bits: u128) -> Mode {
        Mode {
            grip: grip(bits),
            sides: Sides::default(),
            surfaces: Surfaces::default(),
            program: None,
            graph: Graph::default(),
            flight: None,
        }
    }

    #[test]
    fn numbers_stay_whatever_comes_later() {
        let modes = Modes::default();
        let numbers: Vec<usize> = (0..100)
            .map(|bits| modes.meet((grip(bits), Sides::default()), || mode(bits)))
            .collect();
        assert_eq!(numbers, (0..100).collect::<Vec<_>>());
        for bits in (0..100_u128).rev() {
            let number = modes.meet((grip(bits), Sides::default()), || panic!("met before"));
            assert_eq!(modes.get(number).map(|mode| mode.grip), Some(grip(bits)));
        }
        assert!(modes.get(100).is_none());
    }

    #[test]
    fn threads_agree_on_numbers() {
        let modes = Modes::default();
        let meet = |offset: u128| -> Vec<usize> {
            (0..70)
                .map(|k| (k * 11 + offset) % 70)
                .map(|bits| {
                    (
                        bits,
                        modes.meet((grip(bits), Sides::default()), || mode(bits)),
                    )
                })
                .map(|(bits, number)| {
                    assert_eq!(modes.get(number).map(|mode| mode.grip), Some(grip(bits)));
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
