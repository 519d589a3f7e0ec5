//! The question.

use super::coordinate::limits::Extrapolation;
use super::coordinate::local::LocalCoordinate;
use super::normal_form::leading_order::ReleaseSection;
use serde::{Deserialize, Serialize};

/// How borders are looked for and normal forms computed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BorderSpec {
    /// The parameter that is varied.
    pub parameter: String,
    /// The section of the leading-order coefficients; chosen if not given.
    pub section: Option<ReleaseSection>,
    /// How many parts a range is divided into. Two borders within one part are found where the verdict is the same at
    /// both of its ends only if X has a single smallest value between samples there.
    pub samples: usize,
    /// A chatter sequence is looked for after at most so many long flights.
    pub excursions: usize,
    /// How limits along the impact sequence are taken.
    pub extrapolation: Extrapolation,
    /// How u and nu are read off an impact.
    pub coordinate: LocalCoordinate,
}

/// Parts of a range: a verdict costs a tenth of a millisecond.
const SAMPLES: usize = 200;

/// A flight or two may come between release and the impact that chatter begins with. Where orbits are chaotic before they
/// chatter, borders with more are without number, and each is stable in a range of the parameter too narrow to be seen.
const EXCURSIONS: usize = 2;

impl BorderSpec {
    /// The defaults for a parameter.
    pub fn new(parameter: &str) -> Self {
        Self {
            parameter: parameter.to_owned(),
            section: None,
            samples: SAMPLES,
            excursions: EXCURSIONS,
            extrapolation: Extrapolation::default(),
            coordinate: LocalCoordinate::default(),
        }
    }
}
