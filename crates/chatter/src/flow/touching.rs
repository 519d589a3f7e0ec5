//! Which guards vanish at the present state, by mode.

/// How many roots of each guard lie exactly at the start of the next step: none, one after an impact or a section
/// crossing, two where a contact is left from rest by its acceleration or after a graze, three at release.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub(crate) struct Touching([u64; WORDS]);

const WORDS: usize = 4;
const GUARDS_A_WORD: usize = 32;

impl Touching {
    /// Every guard is away from zero.
    pub const NONE: Self = Self([0; WORDS]);

    /// In place of a number, for the reaction of a closed contact: it vanishes as long as nothing else happens.
    pub const BALANCED: u8 = 3;

    /// How many guards can be told apart.
    pub const GUARDS: usize = WORDS * GUARDS_A_WORD;

    /// Roots of a guard at the present state.
    #[inline(always)]
    pub fn get(self, guard: usize) -> u8 {
        (self.0[guard / GUARDS_A_WORD] >> (2 * (guard % GUARDS_A_WORD)) & 3) as u8
    }

    /// Sets the roots of a guard, at most three.
    #[inline(always)]
    pub fn set(&mut self, guard: usize, roots: u8) {
        let (word, place) = (
            &mut self.0[guard / GUARDS_A_WORD],
            2 * (guard % GUARDS_A_WORD),
        );
        *word = *word & !(3 << place) | u64::from(roots & 3) << place;
    }
}
