//! What is held at zero beside the equations of an orbit: at a special point, and along its curve in two parameters.

use super::shooting::Shooting;
use crate::analysis::continuation::{Held, Left, Singular};

/// What is held at zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Condition {
    /// The equations are singular, with the cycle closed by this sign: 1 at folds, -1 at period doublings.
    Singular(f64),
    /// A function of the orbit vanishes, see `Shooting::monitor`.
    Monitor(usize),
}

/// The same, with all that it needs near a point.
#[derive(Clone, Debug)]
pub(crate) enum Bordered {
    /// The borders of the singular matrix.
    Singular(Singular<f64>),
    Monitor(usize),
    /// A function of the orbit has this value.
    Level(usize, f64),
}

impl Condition {
    /// With borders that are known as [`Bordered::numbers`].
    pub(crate) fn restored(self, numbers: &[f64]) -> Bordered {
        match self {
            Self::Monitor(index) => Bordered::Monitor(index),
            Self::Singular(sign) => Bordered::Singular(Singular::with_borders(sign, numbers)),
        }
    }

    /// Near a point; borders are like those before.
    pub(crate) fn near(
        self,
        shooting: &mut Shooting<f64>,
        at: &[f64],
        before: Option<&Bordered>,
    ) -> Result<Bordered, Left> {
        match (self, before) {
            (Self::Monitor(index), _) => Ok(Bordered::Monitor(index)),
            (Self::Singular(_), Some(Bordered::Singular(before))) => {
                before.renewed(shooting, at).map(Bordered::Singular)
            }
            (Self::Singular(sign), _) => Singular::near(shooting, at, sign).map(Bordered::Singular),
        }
    }
}

impl Bordered {
    /// The borders as numbers.
    pub(crate) fn numbers(&self) -> Vec<f64> {
        match self {
            Self::Singular(singular) => singular.borders(),
            Self::Monitor(_) | Self::Level(..) => Vec::new(),
        }
    }

    /// With the equations.
    pub(crate) fn of<'p>(&self, shooting: &'p mut Shooting<f64>) -> Held<'p, f64, Shooting<f64>> {
        match self {
            Self::Singular(borders) => Held::singular(shooting, borders.clone()),
            Self::Monitor(index) => Held::monitor(shooting, *index),
            Self::Level(index, level) => Held::level(shooting, *index, *level),
        }
    }
}
