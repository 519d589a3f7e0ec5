//! Within what branches are followed, and how they end.

use super::{Growth, Saddle, Shrunk, SpecialKind, Unbounded};
use crate::analysis::continuation::{Problem, Settings, Station, locate};
use serde::{Deserialize, Serialize};

/// How an end of a branch came about.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum End {
    /// The parameter left its range.
    Range,
    /// Complete chatter ends at release.
    ChatterBorder,
    /// More impacts a period than allowed: the branch accumulates at a border.
    Impacts(u64),
    /// The flights between so many impacts are as small as rounding of the gap: with one more they could not be told apart. None if there are
    /// infinitely many.
    Rounding(u64),
    /// More points than allowed.
    Points,
    /// The observer broke off.
    Interrupted,
    /// The equations have no solution beyond, for this reason.
    Lost(String),
    /// The orbit comes to a saddle, and its period grows without bound.
    Saddle(Saddle),
    /// The period grows without bound at a value of the parameter.
    Unbounded(Unbounded),
    /// A state grows without bound at a value of the parameter.
    Growth(Growth),
    /// The orbit shrinks to an equilibrium.
    Equilibrium,
    /// The orbit shrinks to an equilibrium on a wall or on a surface, at a value of the parameter.
    Shrunk(Shrunk),
    /// No such points lie beyond a point of this kind.
    At(SpecialKind),
    /// From a point of this kind on the orbit goes more than once around another one, whose branch it has met.
    Again(SpecialKind),
    /// It came back to where it began.
    Closed,
    /// It came back to where it began along itself, by way of its mirror image, say: its other side is another.
    Back,
}

impl core::fmt::Display for End {
    fn fmt(&self, out: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Range => write!(out, "end of the range"),
            Self::ChatterBorder => write!(out, "chatter border"),
            Self::Impacts(most) => write!(out, "more than {most} impacts a period"),
            Self::Rounding(0) => write!(
                out,
                "flights beside complete chatter are as small as rounding of the gap"
            ),
            Self::Rounding(impacts) => write!(
                out,
                "flights between {impacts} impacts a period are as small as rounding of the gap"
            ),
            Self::Points => write!(out, "as many points as allowed"),
            Self::Interrupted => write!(out, "broken off"),
            Self::Lost(why) => out.write_str(why),
            Self::Saddle(saddle) => saddle.fmt(out),
            Self::Unbounded(unbounded) => unbounded.fmt(out),
            Self::Growth(growth) => growth.fmt(out),
            Self::Equilibrium => write!(out, "the orbit shrinks to an equilibrium"),
            Self::Shrunk(shrunk) => shrunk.fmt(out),
            Self::At(kind) => out.write_str(&kind.name().replace('_', " ")),
            Self::Again(kind) => write!(
                out,
                "{}, beyond which it goes more than once around the orbit of another branch",
                kind.name().replace('_', " ")
            ),
            Self::Closed => write!(out, "where it began"),
            Self::Back => write!(out, "where it began, back along itself"),
        }
    }
}

/// Within what a branch is followed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Limits {
    /// Of the last free parameter.
    pub range: (f64, f64),
    /// Of the other one, of curves in two parameters; without it none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub other: Option<(f64, f64)>,
    /// Impacts a period.
    pub impacts: u64,
    /// Points of one branch, to each side.
    pub points: usize,
    /// The longest step, in parts of the range.
    pub longest_step: f64,
}

impl Limits {
    /// How curves within them are followed.
    pub(crate) fn settings(&self) -> Settings {
        Settings {
            first_step: 0.1 * self.longest_step,
            longest_step: self.longest_step,
            ..Settings::default()
        }
    }

    /// The edge of the range that a value lies beyond, if it does.
    pub(crate) fn beyond(&self, value: f64) -> Option<f64> {
        beyond(self.range, value)
    }

    /// The same of the other parameter.
    pub(crate) fn beyond_other(&self, value: f64) -> Option<f64> {
        self.other.and_then(|range| beyond(range, value))
    }

    /// Whether a station of a curve in two parameters is within the ranges of both.
    pub(crate) fn hold(&self, station: &Station) -> bool {
        let other = station.at[station.at.len() - 2];
        self.beyond(station.parameter()).is_none() && self.beyond_other(other).is_none()
    }
}

fn beyond((low, high): (f64, f64), value: f64) -> Option<f64> {
    match value {
        value if value < low => Some(low),
        value if value > high => Some(high),
        _ => None,
    }
}

/// The station, between one and the next, `step` ahead of it, whose parameter has a value, and how far ahead it is.
pub(crate) fn station_at(
    problem: &mut dyn Problem<f64>,
    (from, to): (&Station, &Station),
    step: f64,
    value: f64,
) -> Option<(Station, f64)> {
    let ends = (from.parameter() - value, to.parameter() - value);
    locate(problem, from, step, ends, &mut |_, station| {
        Some(station.parameter() - value)
    })
}
