//! Which guards vanish at the present state, by mode.

/// How many roots of each guard lie exactly at the start of the next step: none, one after an impact or a section
/// crossing, two where a contact is left from rest by its acceleration or after a graze, three at release.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub(crate) struct Touching(u64);

impl Touching {
    /// Every guard is away from zero.
    pub const NONE: Self = Self(0);

    /// In place of a number, for the reaction of a closed contact: it vanishes as long as nothing else happens.
    pub const BALANCED: u8 = 3;

    /// How many guards can be told apart.
    pub const GUARDS: usize = 32;

    /// Roots of a guard at the present state.
    #[inline(always)]
    pub fn get(self, guard: usize) -> u8 {
        (self.0 >> (2 * guard) & 3) as u8
    }

    /// Sets the roots of a guard, at most three.
    #[inline(always)]
    pub fn set(&mut self, guard: usize, roots: u8) {
        self.0 = self.0 & !(3 << (2 * guard)) | u64::from(roots & 3) << (2 * guard);
    }
}
