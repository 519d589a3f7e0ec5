//! A root between two places where a function changes sign.

use super::Real;

/// Two places where a function has different signs: secants with the Illinois rule, or halving where they stall, close in.
#[derive(Clone, Copy, Debug)]
pub struct Bracket<R> {
    /// The end that stayed, and its value: halved each time that it stays (Illinois), since it would stay for ever.
    old: (R, R),
    /// The end that moved.
    new: (R, R),
    /// When secants last halved the bracket, and how many have not since.
    width: R,
    stalled: usize,
}

/// It is halved where this many secants have not halved it.
const PATIENCE: usize = 3;
/// A bracket of so many roundoffs is closed.
const CLOSED: f64 = 2.0;

impl<R: Real> Bracket<R> {
    /// Between two places with the values there; `None` where they have one sign, are zero, or are not numbers.
    pub fn new(a: (R, R), b: (R, R)) -> Option<Self> {
        let (negative, positive) = (|x: (R, R)| x.1 < R::ZERO, |x: (R, R)| x.1 > R::ZERO);
        let differ = (negative(a) && positive(b)) || (positive(a) && negative(b));
        differ.then(|| Self {
            old: a,
            new: b,
            width: (b.0 - a.0).abs(),
            stalled: 0,
        })
    }

    /// How far its ends are apart.
    pub fn width(&self) -> R {
        (self.new.0 - self.old.0).abs()
    }

    /// The end that moved last.
    pub fn latest(&self) -> R {
        self.new.0
    }

    /// Where to look next; `None` where nothing lies between its ends but rounding.
    pub fn place(&mut self) -> Option<R> {
        let ((a, fa), (b, fb)) = (self.old, self.new);
        let size = a.abs().max(b.abs());
        if (b - a).abs() <= size * R::splat(CLOSED * R::ROUNDOFF) {
            return None;
        }
        let secant = b - fb * (b - a) / (fb - fa);
        let inside = (secant > a && secant < b) || (secant > b && secant < a);
        let c = if inside && self.stalled < PATIENCE {
            secant
        } else {
            self.stalled = 0;
            a + (b - a) * R::splat(0.5)
        };
        (c != a && c != b).then_some(c)
    }

    /// Takes the value at a place in between: not zero.
    pub fn narrow(&mut self, at: R, value: R) {
        let half = R::splat(0.5);
        if (value < R::ZERO) == (self.new.1 < R::ZERO) {
            self.old.1 *= half;
        } else {
            self.old = self.new;
        }
        self.new = (at, value);
        let now = self.width();
        if now > self.width * half {
            self.stalled += 1;
        } else {
            (self.stalled, self.width) = (0, now);
        }
    }
}

/// The last whole number for which something holds that does so from `first` on and no more from some number on, `end` at the latest.
pub(crate) fn last_where(first: i64, end: i64, holds: impl Fn(i64) -> bool) -> i64 {
    let (mut first, mut end) = (first, end);
    while end - first > 1 {
        let middle = first + (end - first) / 2;
        if holds(middle) {
            first = middle;
        } else {
            end = middle;
        }
    }
    first
}

/// The root between two places, to rounding error.
///
/// `None` where the function does not change sign, or is not a number.
pub fn root_between<R: Real>(function: impl Fn(R) -> R, a: R, b: R) -> Option<R> {
    const LONGEST: usize = 400;
    let (fa, fb) = (function(a), function(b));
    if fa == R::ZERO {
        return Some(a);
    }
    if fb == R::ZERO {
        return Some(b);
    }
    let mut bracket = Bracket::new((a, fa), (b, fb))?;
    for _ in 0..LONGEST {
        let Some(at) = bracket.place() else {
            break;
        };
        let value = function(at);
        if value == R::ZERO {
            return Some(at);
        }
        bracket.narrow(at, value);
    }
    Some(bracket.latest())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::{DoubleDouble, Scalar};

    #[test]
    fn the_last_number_is_found_wherever_it_lies() {
        for last in [-3, -1, 0, 7, 12] {
            assert_eq!(last_where(-3, 13, |number| number <= last), last);
        }
    }

    #[test]
    fn roots_are_found_to_rounding_error() {
        let cube = |x: f64| x * x * x - 2.0;
        assert_eq!(root_between(cube, 0.0, 5.0), Some(libm::cbrt(2.0)));
        assert_eq!(root_between(cube, 2.0, 5.0), None);
        let flat = |x: f64| libm::pow(x - 1.0, 9.0);
        assert!((root_between(flat, 0.0, 7.0).unwrap() - 1.0).abs() < 1e-15);
        let two = DoubleDouble::from(2.0);
        let root = root_between(|x| x * x - two, DoubleDouble::ZERO, two).unwrap();
        assert!((root - two.sqrt()).abs().to_f64() < 1e-31);
    }
}
