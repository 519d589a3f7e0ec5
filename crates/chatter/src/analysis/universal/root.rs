//! A root between two points where a function changes sign.

use crate::numerics::Real;

/// Secants with the Illinois rule, or halving where they stall, until the bracket has closed to rounding error.
///
/// `None` where the function does not change sign, or is not a number.
pub(super) fn between<R: Real>(function: impl Fn(R) -> R, a: R, b: R) -> Option<R> {
    const LONGEST: usize = 400;
    // Halve where this many secants have not halved the bracket.
    const PATIENCE: usize = 3;
    let (mut a, mut b) = (a, b);
    let (mut fa, mut fb) = (function(a), function(b));
    if fa == R::ZERO {
        return Some(a);
    }
    if fb == R::ZERO {
        return Some(b);
    }
    if !((fa < R::ZERO && fb > R::ZERO) || (fa > R::ZERO && fb < R::ZERO)) {
        return None;
    }
    let half = R::splat(0.5);
    let mut width = (b - a).abs();
    let mut stalled = 0;
    for _ in 0..LONGEST {
        let size = a.abs().max(b.abs());
        if (b - a).abs() <= size * R::splat(2.0 * R::ROUNDOFF) {
            break;
        }
        let secant = b - fb * (b - a) / (fb - fa);
        let inside = (secant > a && secant < b) || (secant > b && secant < a);
        let c = if inside && stalled < PATIENCE {
            secant
        } else {
            stalled = 0;
            a + (b - a) * half
        };
        if c == a || c == b {
            break;
        }
        let fc = function(c);
        if fc == R::ZERO {
            return Some(c);
        }
        if (fc < R::ZERO) == (fb < R::ZERO) {
            fa *= half;
        } else {
            (a, fa) = (b, fb);
        }
        (b, fb) = (c, fc);
        let now = (b - a).abs();
        if now > width * half {
            stalled += 1;
        } else {
            (stalled, width) = (0, now);
        }
    }
    Some(b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::{DoubleDouble, Scalar};

    #[test]
    fn roots_are_found_to_rounding_error() {
        let cube = |x: f64| x * x * x - 2.0;
        assert_eq!(between(cube, 0.0, 5.0), Some(libm::cbrt(2.0)));
        assert_eq!(between(cube, 2.0, 5.0), None);
        let flat = |x: f64| libm::pow(x - 1.0, 9.0);
        assert!((between(flat, 0.0, 7.0).unwrap() - 1.0).abs() < 1e-15);
        let two = DoubleDouble::from(2.0);
        let root = between(|x| x * x - two, DoubleDouble::ZERO, two).unwrap();
        assert!((root - two.sqrt()).abs().to_f64() < 1e-31);
    }
}
