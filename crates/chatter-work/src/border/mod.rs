//! Border orbits, told as a JSON document, a table and a figure; with the windows and orbits of the model itself.

mod compared;
mod document;
mod find;
mod overlay;
mod picture;
mod refused;

pub use compared::{NAMES, compared, ends};
pub use document::document;
pub use find::{Place, Question, find};
pub use overlay::{Orbits, Overlay, overlay};
pub use picture::picture;
pub use refused::refused;

use crate::numbers::Digits;
use crate::options::Counts;
use crate::universal::Window;
use chatter::analysis::border::{Border, Estimate, WindowComparison};
use chatter::analysis::border_search::Borders;
use chatter::analysis::universal::{Argument, Universal};
use chatter::model::Model;
use chatter::numerics::Real;

/// What was asked.
pub struct Subject<'a> {
    /// The model, with everything set into it.
    pub model: &'a Model,
    /// The model as the user named it.
    pub source: &'a str,
    /// The parameter that is varied.
    pub parameter: &'a str,
    /// Digits of numbers in a document.
    pub digits: Digits,
    /// Digits of numbers in text.
    pub text_digits: Digits,
    /// Parts of a range that were told apart.
    pub samples: usize,
    /// Long flights that may come before chatter.
    pub excursions: usize,
    /// Which windows are predicted and looked for in the model; a few that a plot shows if not given.
    pub windows: Option<Counts>,
}

/// What was found. Beside each border stand the windows asked for, as far as the model has them.
pub enum Answer<R> {
    /// The border near a value.
    One {
        /// The border.
        border: Box<Border<R>>,
        /// Its windows; none where the work was stopped before they were looked for.
        compared: Option<Vec<WindowComparison>>,
    },
    /// Those of a range.
    All {
        /// Borders, and places that are none.
        found: Borders<R>,
        /// The windows of each border; none where the work was stopped before they were looked for.
        compared: Option<Vec<Vec<WindowComparison>>>,
        /// Lower end of the range.
        low: f64,
        /// Its upper end.
        high: f64,
    },
}

impl<R> Answer<R> {
    /// Whether all that was asked for was found before the work was stopped.
    pub fn is_complete(&self) -> bool {
        match self {
            Self::One { compared, .. } => compared.is_some(),
            Self::All { compared, .. } => compared.is_some(),
        }
    }

    /// Each border with its windows.
    pub fn borders(&self) -> Vec<(&Border<R>, Option<&[WindowComparison]>)> {
        match self {
            Self::One { border, compared } => vec![(border, compared.as_deref())],
            Self::All {
                found, compared, ..
            } => {
                let windows = |place: usize| compared.as_ref().map(|all| all[place].as_slice());
                let borders = found.borders.iter().enumerate();
                borders
                    .map(|(place, border)| (border, windows(place)))
                    .collect()
            }
        }
    }
}

impl Subject<'_> {
    /// The parameters that are not varied, each with its value.
    pub fn fixed<R: Real>(&self) -> (Vec<&str>, Vec<R>) {
        let values = self.model.parameter_values::<R>(&[]);
        (self.model.parameter_names().into_iter())
            .zip(values)
            .filter(|(name, _)| *name != self.parameter)
            .unzip()
    }

    /// The windows asked for, or five of which the first is nearer to the border than that with one impact by the same
    /// factor for every restitution: for the paper's valve 20 to 24.
    pub fn windows<R: Real>(&self, border: &Border<R>) -> Counts {
        const LOG_NEARER: f64 = -4.45;
        const SHOWN: i64 = 5;
        self.windows.unwrap_or_else(|| {
            let first = (LOG_NEARER / border.constants.ln_eta.to_f64()).round() as i64;
            Counts {
                first,
                last: first + SHOWN - 1,
            }
        })
    }

    /// The first and the last lap of these windows.
    pub fn laps<R: Real>(&self, border: &Border<R>) -> (i64, i64) {
        let windows = self.windows(border);
        let lap = |n: i64| i64::from(u32::try_from(n).unwrap_or(u32::MAX));
        (lap(windows.first), lap(windows.last))
    }
}

/// The windows asked for, in the parameter: p = p* + mu / M.
pub fn prediction<R: Real + Argument<Real = R>>(
    subject: &Subject,
    border: &Border<R>,
) -> Option<Vec<Window<R>>> {
    let exact = &border.exact;
    let universal = Universal::new(border.constants.restitution).ok()?;
    let slope = exact.slope.value;
    let doubling = exact.memory.as_ref().map(|memory| memory.doubling_slope);
    let windows = Window::list(&universal, (slope, doubling), subject.windows(border)).ok()?;
    let by_parameter = |mu: R| border.value.value + mu / exact.unfolding_rate.value;
    let windows = windows.into_iter();
    Some(windows.map(|window| window.map(by_parameter)).collect())
}

/// The digits asked for, no more of them than the error leaves.
pub fn known<R: Real>(estimate: &Estimate<R>, digits: Digits) -> Digits {
    let size = estimate.value.abs().to_f64();
    let decades = (size / estimate.error).log10();
    if decades.is_finite() {
        // Up to the first digit of the error.
        Digits(digits.0.min(decades.ceil().max(0.0) as u32 + 1))
    } else {
        digits
    }
}
