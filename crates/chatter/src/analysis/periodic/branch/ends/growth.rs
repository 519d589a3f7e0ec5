//! Where a state of a branch's orbits grows without bound at a finite value of the parameter p*, and which value that is.
//!
//! An orbit that outgrows all lengths of a model is one of the model without them, whose forces are proportional to its states: such orbits come in all
//! sizes S, and only at one value of the parameter. What was left out vanishes as powers of 1/S:
//!
//! ```text
//! p - p* = c_1 / S + c_2 / S^2 + ...
//! ```

use super::unbounded::{Series, limit};
use crate::analysis::periodic::branch::Point;
use crate::numerics::stored::number;
use core::fmt;
use serde::{Deserialize, Serialize};

/// How a state grows without bound.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Growth {
    /// The parameter.
    pub name: String,
    /// Its value where the state is infinite.
    #[serde(with = "number")]
    pub value: f64,
    /// Estimated error of that.
    #[serde(with = "number")]
    pub error: f64,
    /// The state.
    pub state: String,
    /// What it is on the last orbit.
    #[serde(with = "number")]
    pub size: f64,
    /// The power of the distance from that value by which it grows is minus one over this.
    pub power: u8,
}

/// A value as digits, or as zero where it is no more than its error.
struct Known(f64, f64);

impl fmt::Display for Known {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(value, error) = *self;
        write!(out, "{}", if value.abs() <= error { 0.0 } else { value })
    }
}

impl fmt::Display for Growth {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, value, .. } = self;
        write!(
            out,
            "`{}`, {:.1e} here, grows without bound as {name} comes to {} (error {:.0e}), as 1/|{name} - {name}*|",
            self.state,
            self.size,
            Known(*value, self.error),
            self.error
        )?;
        match self.power {
            1 => Ok(()),
            power => write!(out, "^(1/{power})"),
        }
    }
}

/// A state has grown by this factor, …
const GROWN: f64 = 1e4;
/// … the parameter's value there is known to this part of its size, …
const KNOWN: f64 = 1e-11;
/// … and is come to by a power no farther than this from one of the first.
const SAME_POWER: f64 = 0.05;
const POWERS: u8 = 4;
/// Sizes of the orbits that it is told from have this ratio, and there are so many.
const RATIO: f64 = 2.0;
const ORDER: usize = 6;

/// How a state, by its place, has grown at the end of a side of a branch, if it does without bound.
pub(in crate::analysis::periodic::branch) fn growth(
    points: &[Point],
    (state, place): (&str, usize),
    (name, scale): (&str, f64),
) -> Option<Growth> {
    let size = |point: &Point| point.state[place].abs();
    let run = Series::growing(points, &size, 0.0);
    let (first, last) = run.ends()?;
    if size(last) < GROWN * size(first) {
        return None;
    }
    let powers = |order: usize| (1..order as i32).collect::<Vec<i32>>();
    let [value, other] = [ORDER, ORDER - 1].map(|order| limit(&run, &powers(order), RATIO));
    let ((value, _), (other, _)) = (value?, other?);
    // What is left of states is rounding of those, whatever the parameter's value is.
    let error = (value - other).abs() + run.rounding(scale.abs().max(value.abs()));
    let power = run.power(value, RATIO)?;
    let known = (1..=POWERS).find(|&known| (power - f64::from(known)).abs() < SAME_POWER)?;
    (error < KNOWN * scale).then(|| Growth {
        name: name.to_owned(),
        value,
        error,
        state: state.to_owned(),
        size: size(last),
        power: known,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::periodic::branch::point::tests::orbits;

    fn sizes(parameter: impl Fn(f64) -> f64, most: f64) -> Vec<Point> {
        let sizes = (0..).map(|k| 1.05_f64.powi(k)).take_while(|s| *s < most);
        let of_size = |size: f64| Point {
            state: vec![-size],
            ..orbits(|_| parameter(size), core::iter::once(1.0)).remove(0)
        };
        sizes.map(of_size).collect()
    }

    #[test]
    fn what_grows_without_bound_is_told_with_where() {
        let told = |points: &[Point]| growth(points, ("v", 0), ("k", 1.0));
        let lengths = sizes(|s| 1.2 - 3.0 / (s + 0.7) + 2.0 / (s * s), 1e7);
        let found = told(&lengths).unwrap();
        assert_eq!(found.power, 1);
        assert!((found.value - 1.2).abs() <= found.error && found.error < 1e-12);
        // No more is known of a value that is zero than states have digits.
        let found = told(&sizes(|s| -3.0 / s, 1e7)).unwrap();
        assert!(found.value.abs() <= found.error && found.error >= f64::EPSILON);
        let square = sizes(|s| 0.3 + 3.0 / (s * (s + 0.7)), 1e7);
        let found = told(&square).unwrap();
        assert_eq!(found.power, 2);
        assert!((found.value - 0.3).abs() <= found.error && found.error < 1e-12);
        // Not by far enough; in proportion to the parameter; through a resonance with damping, whose peak is at 2e6; by a root.
        assert_eq!(told(&sizes(|s| 1.2 - 3.0 / s, 9e3)), None);
        assert_eq!(told(&sizes(|s| 0.1 * s, 1e7)), None);
        let resonance = |s: f64| 1.0 - (1.0 / (s * s) - 0.25e-12).sqrt();
        assert_eq!(told(&sizes(resonance, 1.9e6)), None);
        assert_eq!(told(&sizes(|s| 1.2 - 3.0 / s.sqrt(), 1e7)), None);
    }
}
