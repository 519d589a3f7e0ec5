//! How states stand to corners, which says what mode follows at one.

use super::guard::GuardKind;
use super::limits::Corner;
use crate::expressions::Tape;

/// How a state stands to a corner in a mode.
#[derive(Clone, Debug)]
pub(crate) struct StandingTapes {
    pub corner: Corner,
    /// What is zero on a surface; then for each of the guards its value and its first derivatives in time; then the rate of the
    /// surface and what changes that, if it must be zero, too.
    pub values: Tape,
    pub guards: Vec<GuardKind>,
    /// The motion keeps to the surface but for rounding of numbers.
    pub is_kept: bool,
    /// The derivative of the surface along each column.
    pub slopes: Tape,
    /// By how much the surface rises where the rate of each contact is made larger by one.
    pub lifts: Tape,
    /// Of the squared length of a vector its components.
    pub components: Tape,
    /// And where it is kept at zero what is in place of its direction, and the rates of that; what each component of a direction changes
    /// its components by, row by row; and what it adds to the field.
    pub holding: Tape,
}

/// How many tapes that is.
pub(crate) const STANDING_TAPES: usize = 5;

impl StandingTapes {
    pub fn all(&self) -> [&Tape; STANDING_TAPES] {
        [
            &self.values,
            &self.slopes,
            &self.lifts,
            &self.components,
            &self.holding,
        ]
    }
}

/// Values of a guard and its derivatives that decide which mode follows at a corner.
pub(crate) const STANDING_ORDERS: usize = 4;
