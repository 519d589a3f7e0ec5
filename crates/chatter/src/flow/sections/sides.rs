//! On which side of each section a trajectory is: the sign that the section's function had last.
//!
//! A section is crossed where that sign changes, be it that the function runs through zero or that an impact makes it
//! jump. Zero is no sign: a trajectory that reaches the surface and turns back has not crossed it, nor has one that rests in
//! it and leaves to the side it came from, nor one that starts on it. So each crossing is told once, at whatever instant
//! it happens: one that cannot be told in time from an impact, graze, accumulation or release is decided by the signs before
//! and after, and told after it.

use crate::flow::touching::Touching;
use crate::numerics::Real;

/// The sides of all sections, each as seen from the guard's function: positive, negative, or not known yet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub(crate) struct Sides([u64; WORDS]);

/// As many sections as there are guards.
const WORDS: usize = Touching::GUARDS / SECTIONS_A_WORD;
const SECTIONS_A_WORD: usize = 32;

impl Sides {
    /// None is known.
    pub const UNKNOWN: Self = Self([0; WORDS]);

    const NEGATIVE: u64 = 1;
    const POSITIVE: u64 = 2;

    /// 1, -1, or 0 where the side is not known.
    #[inline(always)]
    pub fn get<R: Real>(self, section: usize) -> R {
        match self.0[section / SECTIONS_A_WORD] >> (2 * (section % SECTIONS_A_WORD)) & 3 {
            Self::NEGATIVE => R::splat(-1.0),
            Self::POSITIVE => R::ONE,
            _ => R::ZERO,
        }
    }

    /// Takes over a side that a step ended with.
    #[inline(always)]
    pub fn set<R: Real>(&mut self, section: usize, side: R) {
        let bits = if side > R::ZERO {
            Self::POSITIVE
        } else if side < R::ZERO {
            Self::NEGATIVE
        } else {
            0
        };
        let place = 2 * (section % SECTIONS_A_WORD);
        let word = &mut self.0[section / SECTIONS_A_WORD];
        *word = *word & !(3 << place) | bits << place;
    }
}
