//! Which guards vanish at the present state or were just left, by mode.

use crate::numerics::Real;
use crate::numerics::polynomial::derivative_bound;

/// How many roots of each guard lie exactly at the start of the next step: none, one after an impact or a section
/// crossing, two where a contact is left from rest by its acceleration or after a graze, three at release, more where jerk and what
/// follows vanish, too.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Touching([u64; WORDS]);

/// All words at once: what is derived calls the library.
impl PartialEq for Touching {
    #[inline(always)]
    fn eq(&self, other: &Self) -> bool {
        let mut differing = 0;
        for (one, two) in self.0.iter().zip(&other.0) {
            differing |= one ^ two;
        }
        differing == 0
    }
}

impl Eq for Touching {}

const WORDS: usize = 8;
const GUARDS_A_WORD: usize = 16;
const BITS: usize = 4;

impl Touching {
    /// Every guard is away from zero.
    pub const NONE: Self = Self([0; WORDS]);

    /// After an ordinary step, which ended at a guard or nowhere: that one vanishes.
    #[inline(always)]
    pub fn after(guard: Option<usize>) -> Self {
        let Some(guard) = guard else {
            return Self::NONE;
        };
        // Each word is made, none is changed: what was stored as a word and is read as many at once stalls the processor.
        let (place, root) = (guard / GUARDS_A_WORD, 1 << (BITS * (guard % GUARDS_A_WORD)));
        Self(core::array::from_fn(
            |word| if word == place { root } else { 0 },
        ))
    }

    /// In place of a number, for what is no gap and no section: it vanishes as long as nothing else happens. More than the
    /// roots that are ever counted, and no more than any expansion has coefficients.
    pub const BALANCED: u8 = 7;

    /// How many guards can be told apart.
    pub const GUARDS: usize = WORDS * GUARDS_A_WORD;

    /// Roots of a guard at the present state.
    #[inline(always)]
    pub fn get(self, guard: usize) -> u8 {
        (self.0[guard / GUARDS_A_WORD] >> (BITS * (guard % GUARDS_A_WORD)) & 7) as u8
    }

    /// Whether any guard has two roots or more: it is being left from rest.
    #[inline(always)]
    pub fn is_leaving(self) -> bool {
        const ALL_BUT_FIRST_BITS: u64 = u64::MAX / 15 * 6;
        self.0.iter().any(|word| word & ALL_BUT_FIRST_BITS != 0)
    }

    /// Sets the roots of a guard, at most seven, which of what is no gap and no section means [`BALANCED`](Self::BALANCED).
    #[inline(always)]
    pub fn set(&mut self, guard: usize, roots: u8) {
        let (word, place) = (
            &mut self.0[guard / GUARDS_A_WORD],
            BITS * (guard % GUARDS_A_WORD),
        );
        *word = *word & !(7 << place) | u64::from(roots & 7) << place;
    }
}

/// Guards that were left from rest, and how long ago.
///
/// Shortly after a release the gap and its rates are sums of terms that cancel: what rounding leaves of them says nothing,
/// and the mode everything. As long as the first derivative that did not vanish there, the jerk, has kept its sign, the
/// gap and all derivatives below it are positive.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Left<R> {
    guards: Touching,
    elapsed: R,
}

impl<R: Real> Left<R> {
    /// No guard.
    pub const NONE: Self = Self {
        guards: Touching::NONE,
        elapsed: R::ZERO,
    };

    /// What holds after an undisturbed step that began with so many roots of each guard.
    #[inline(always)]
    pub fn after(self, touching: Touching, step: R) -> Self {
        if touching.is_leaving() {
            return Self {
                guards: touching,
                elapsed: step,
            };
        }
        Self {
            guards: self.guards,
            elapsed: self.elapsed + step,
        }
    }

    /// Roots that a guard had when it was left.
    pub fn roots(&self, guard: usize) -> u8 {
        self.guards.get(guard)
    }

    /// The same with guards in other places, those of another mode.
    pub fn of(self, guards: Touching) -> Self {
        Self { guards, ..self }
    }

    /// How many of the lowest coefficients of a guard are known not to be negative, from its series in units of `tau`.
    pub fn positive_coefficients(&self, guard: usize, series: &[R], tau: R) -> usize {
        let roots = usize::from(self.roots(guard));
        if roots < 2 || roots >= series.len() {
            return 0;
        }
        let (lowest, change) = derivative_bound(series, roots, self.elapsed / tau);
        if lowest > change { roots } else { 0 }
    }
}
