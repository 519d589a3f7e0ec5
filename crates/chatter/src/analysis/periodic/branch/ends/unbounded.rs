//! Where the period of a branch grows without bound at a finite value of the parameter p*: by which law, and at which value.
//!
//! Beside an orbit that leads to an equilibrium which it leaves or comes to at a rate, the time there is a logarithm; where an equilibrium is about
//! to come about on the orbit by a fold, and the motion creeps through the place, an inverse root (Strogatz, section 8.4):
//!
//! ```text
//! p - p* = C exp(-k T) (1 + ...)              T = -log|p - p*| / k + ...
//! p - p* = C^2 / T^2 + c_3 / T^3 + ...        T = C / sqrt|p - p*| + ...
//! ```
//!
//! Which of them holds is read off the orbits; neither asks for the equilibrium, which a branch need not know, as where a clock, a relay or a
//! threshold leads there.

use crate::analysis::periodic::branch::Point;
use crate::numerics::stored::number;
use crate::numerics::{Matrix, root_between};
use core::fmt;
use serde::{Deserialize, Serialize};

/// How a period grows without bound.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Unbounded {
    /// The parameter.
    pub name: String,
    /// Its value where the period is infinite.
    #[serde(with = "number")]
    pub value: f64,
    /// Estimated error of that.
    #[serde(with = "number")]
    pub error: f64,
    /// The period of the last orbit.
    #[serde(with = "number")]
    pub period: f64,
    /// By which law it grows.
    pub law: Law,
    /// Estimated error of the number in that.
    #[serde(with = "number")]
    pub law_error: f64,
}

/// A period against the distance d of the parameter from its value there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Law {
    /// T = -log(d)/k: beside an equilibrium, k being a rate of it.
    Logarithm(#[serde(with = "number")] f64),
    /// T = C/sqrt(d): a saddle-node on the orbit.
    InverseRoot(#[serde(with = "number")] f64),
}

impl fmt::Display for Unbounded {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, value, .. } = self;
        write!(
            out,
            "the period, {:.6} here, grows without bound as {name} comes to {value} (error {:.0e}): ",
            self.period, self.error
        )?;
        let error = self.law_error;
        match self.law {
            Law::Logarithm(rate) => write!(
                out,
                "T = -log|{name} - {name}*|/{rate:.6} (error {error:.0e})"
            ),
            Law::InverseRoot(factor) => write!(
                out,
                "T = {factor:.6}/sqrt|{name} - {name}*| (error {error:.0e}), as at a saddle-node on the orbit"
            ),
        }
    }
}

/// So many orbits, at least, along which the period grows, …
const FEWEST: usize = 24;
/// … by this factor.
const GROWN: f64 = 1.3;
/// Parts of the growth between two of the orbits that are compared.
const PARTS: f64 = 12.0;
/// Rates of a logarithm that differ by less than this part are one, …
const SAME_RATE: f64 = 0.02;
/// … and its value is known once it is this near, in parts of the parameter's size.
const NEAR: f64 = 1e-11;
/// An inverse root is told from periods that have grown by this factor, …
const LONG: f64 = 16.0;
/// … with an exponent between -2 and this far from it.
const SAME_POWER: f64 = 0.1;
/// Periods of the orbits that an inverse root is told from have this ratio, and there are so many.
const RATIO: f64 = 1.3;
const ORDER: usize = 6;
/// A value is known to so many roundoffs of the parameter.
const ROUNDOFFS: f64 = 64.0;

/// The law by which the period grows at the end of a side of a branch, if it does without bound, and the parameter's value there.
pub(in crate::analysis::periodic::branch) fn unbounded(
    points: &[Point],
    name: &str,
    scale: f64,
) -> Option<Unbounded> {
    let run = Series::growing(points, &|point: &Point| point.period, NEAR * scale);
    let (first, last) = run.ends()?;
    if run.points.len() < FEWEST || last.period < GROWN * first.period {
        return None;
    }
    let ((value, error), law, law_error) = logarithm(&run, scale)
        .or_else(|| inverse_root(&run).filter(|((_, error), ..)| *error < scale))?;
    Some(Unbounded {
        name: name.to_owned(),
        value,
        error: error + run.rounding(value) + run.turned_back(),
        period: last.period,
        law,
        law_error,
    })
}

/// The latest points along which what is measured grows and the parameter goes one way, but for what it is known to, with one sequence of
/// events.
pub(super) struct Series<'p> {
    points: &'p [Point],
    measure: &'p dyn Fn(&Point) -> f64,
}

impl<'p> Series<'p> {
    pub(super) fn growing(
        points: &'p [Point],
        measure: &'p dyn Fn(&Point) -> f64,
        known_to: f64,
    ) -> Self {
        let gone = |pair: &[Point]| pair[1].parameter() - pair[0].parameter();
        let mut latest = points.windows(2).map(gone).rev();
        let way = latest.find(|gone| gone.abs() > known_to);
        let way = way.map_or(0.0, f64::signum);
        let goes_on = |pair: &&[Point]| {
            measure(&pair[1]) > measure(&pair[0])
                && pair[1].impacts == pair[0].impacts
                && gone(pair) * way >= -known_to
        };
        let steps = points.windows(2).rev().take_while(goes_on).count();
        Self {
            points: &points[points.len().saturating_sub(1 + steps)..],
            measure,
        }
    }

    /// The first and the last of them.
    pub(super) fn ends(&self) -> Option<(&'p Point, &'p Point)> {
        Some((self.points.first()?, self.points.last()?))
    }

    fn of(&self, point: &Point) -> f64 {
        (self.measure)(point)
    }

    /// The point whose measure comes next to a value.
    fn with(&self, value: f64) -> Option<&'p Point> {
        let place = (self.points).partition_point(|point| self.of(point) < value);
        self.points.get(place.min(self.points.len() - 1))
    }

    /// The most that the parameter goes back on its way: what it is known to on these orbits.
    fn turned_back(&self) -> f64 {
        let Some((first, last)) = self.ends() else {
            return 0.0;
        };
        let way = (last.parameter() - first.parameter()).signum();
        let back = |pair: &[Point]| (pair[0].parameter() - pair[1].parameter()) * way;
        self.points.windows(2).map(back).fold(0.0, f64::max)
    }

    /// What a value that the parameter comes to is known to at best.
    pub(super) fn rounding(&self, value: f64) -> f64 {
        let last = self.points.last().map_or(0.0, Point::parameter);
        ROUNDOFFS * f64::EPSILON * value.abs().max(last.abs())
    }

    /// The power of one over the measure by which the parameter comes to a value, from the last point and one with so many times less.
    pub(super) fn power(&self, value: f64, ratio: f64) -> Option<f64> {
        let (_, last) = self.ends()?;
        let before = self.with(self.of(last) / ratio)?;
        let distance = |point: &Point| point.parameter() - value;
        let nearer = distance(before) / distance(last);
        let power = libm::log(nearer) / libm::log(self.of(last) / self.of(before));
        (nearer > 1.0).then_some(power)
    }
}

/// The rate and the limit of a parameter that comes to it exponentially, from three periods.
fn exponential([a, b, c]: [&Point; 3]) -> Option<(f64, f64)> {
    let (early, late) = (b.period - a.period, c.period - b.period);
    let (gone, left) = (a.parameter() - b.parameter(), b.parameter() - c.parameter());
    let ratio = gone / left;
    if !(ratio > 1.0 && early > 0.0 && late > 0.0) {
        return None;
    }
    // gone/left = e^(k late) (e^(k early) - 1)/(e^(k late) - 1)
    let off = |rate: f64| {
        let by = |time: f64| libm::expm1(rate * time);
        (1.0 + by(late)) * by(early) / by(late) - ratio
    };
    let high = libm::log(ratio) / early.min(late) * 2.0;
    let rate = root_between(off, high * 1e-6, high)?;
    Some((rate, c.parameter() - left / libm::expm1(rate * late)))
}

/// A value and its error, the law by which it is come to, and the error of the number in that.
type Told = ((f64, f64), Law, f64);

fn logarithm(run: &Series<'_>, scale: f64) -> Option<Told> {
    let (first, last) = run.ends()?;
    let part = (last.period - first.period) / PARTS;
    let at = |parts: f64| run.with(last.period - parts * part);
    let (early, late) = (
        exponential([at(3.0)?, at(2.0)?, at(1.0)?])?,
        exponential([at(2.0)?, at(1.0)?, last])?,
    );
    let is_one = (late.0 / early.0 - 1.0).abs() < SAME_RATE;
    let is_near = (last.parameter() - late.1).abs() < NEAR * scale;
    let known = (late.1, (late.1 - early.1).abs());
    let law = Law::Logarithm(late.0);
    // As near to the value as this, parameters are differences of little more than their rounding.
    let before = at(1.0)?;
    let rounding = 2.0 * f64::EPSILON * late.1.abs() / (before.parameter() - last.parameter());
    let law_error = (late.0 - early.0).abs() + (rounding / (last.period - before.period)).abs();
    (is_one && is_near).then_some((known, law, law_error))
}

/// The limit of a parameter that comes to it as a polynomial in one over the measure, of these powers, and the coefficient of the first: from one
/// point more than there are powers, each with so many times less than the one before.
pub(super) fn limit(run: &Series<'_>, powers: &[i32], ratio: f64) -> Option<(f64, f64)> {
    let (_, last) = run.ends()?;
    let order = powers.len() + 1;
    let mut rows = Vec::with_capacity(order);
    let mut values = Vec::with_capacity(order);
    for k in 0..order {
        let point = run.with(run.of(last) / ratio.powi(k as i32))?;
        let inverse = run.of(last) / run.of(point);
        let parts = powers.iter().map(|&power| inverse.powi(power));
        rows.push(core::iter::once(1.0).chain(parts).collect::<Vec<f64>>());
        values.push(point.parameter());
    }
    let found = Matrix::from_rows(&rows).factored()?.solve(&values);
    let (&[value, part, ..], Some(&power)) = (&*found, powers.first()) else {
        return None;
    };
    (value.is_finite()).then(|| (value, part * run.of(last).powi(power)))
}

fn inverse_root(run: &Series<'_>) -> Option<Told> {
    let (first, last) = run.ends()?;
    if last.period < LONG * first.period {
        return None;
    }
    // Without a linear term.
    let powers = |order: usize| (2..=order as i32).collect::<Vec<i32>>();
    let value = limit(run, &powers(ORDER), RATIO)?;
    let other = limit(run, &powers(ORDER - 1), RATIO)?;
    let [(value, square), (other, others)] = [value, other];
    let holds = (run.power(value, RATIO)? - 2.0).abs() < SAME_POWER;
    let [factor, others] = [square, others].map(|square| square.abs().sqrt());
    let known = (value, (value - other).abs());
    holds.then_some((known, Law::InverseRoot(factor), (factor - others).abs()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::periodic::branch::point::tests::orbits;

    #[test]
    fn laws_are_told_apart_with_their_values() {
        let steps = |least: f64, most: f64, step: f64| {
            let count = ((most - least) / step) as usize;
            (0..count).map(move |k| least + step * k as f64)
        };
        let exponential = orbits(
            |t| 0.3 + 2.0 * libm::exp(-0.7 * t) + 5.0 * libm::exp(-1.4 * t),
            steps(2.0, 42.0, 0.11),
        );
        let found = unbounded(&exponential, "p", 1.0).unwrap();
        let Law::Logarithm(rate) = found.law else {
            panic!("{found:?}");
        };
        let off = (rate - 0.7).abs();
        assert!(off <= found.law_error && off < 1e-3, "{found:?}");
        assert!(
            (found.value - 0.3).abs() <= found.error && found.error < 1e-11,
            "{found:?}"
        );
        let root = orbits(
            |t| 0.3 - 2.0 / (t - 0.4).powi(2) + 3.0 / (t - 0.4).powi(4),
            steps(2.0, 60.0, 0.1),
        );
        let found = unbounded(&root, "p", 1.0).unwrap();
        let Law::InverseRoot(factor) = found.law else {
            panic!("{found:?}");
        };
        let off = (factor - 2.0_f64.sqrt()).abs();
        assert!(off <= found.law_error && off < 1e-3, "{found:?}");
        assert!(
            (found.value - 0.3).abs() <= found.error && found.error < 1e-4,
            "{found:?}"
        );
        // A period that comes to an end, or grows with the parameter.
        assert_eq!(
            unbounded(&orbits(|t| 5.0 * t, steps(2.0, 60.0, 0.1)), "p", 1.0),
            None
        );
        let fold = orbits(|t| 0.3 - (60.0 - t).powi(2), steps(2.0, 59.9, 0.1));
        assert_eq!(unbounded(&fold, "p", 1.0), None);
    }
}
