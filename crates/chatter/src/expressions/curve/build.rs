//! From knots to polynomials.
//!
//! On a piece from x_k to x_{k+1} of length h, with secant slope m and the slopes d_k, d_{k+1} at its ends, the cubic in
//! s = x - x_k is y_k + d_k s + (3m - 2d_k - d_{k+1})/h s^2 + (d_k + d_{k+1} - 2m)/h^2 s^3. The kinds of cubic differ in
//! their slopes alone.

use super::{Axis, Curve, CurveError, CurveKind, Outside};
use crate::numerics::{DoubleDouble, Real, Scalar};

/// Most knots of a curve: a hundred bytes each, and far more than a measurement has that is not to be thinned first.
pub const MOST_KNOTS: usize = 1 << 20;

/// The slopes of a spline are solutions of equations, good to so many roundoffs of the steepest secant.
const SLOPE_ROUNDOFFS: f64 = 64.0;

fn number(value: f64) -> DoubleDouble {
    DoubleDouble::from(value)
}

impl Curve {
    /// A curve through the points of `x` and `y`. `outside` is [`Outside::Error`] where it is not given; `slopes` are
    /// those at the first and the last knot of a [`CurveKind::Cubic`], which is natural without them.
    ///
    /// # Errors
    /// The first thing that keeps the points from being the knots of such a curve.
    pub fn new(
        name: &str,
        kind: CurveKind,
        outside: Option<Outside>,
        x: &[DoubleDouble],
        y: &[DoubleDouble],
        slopes: Option<[DoubleDouble; 2]>,
    ) -> Result<Self, CurveError> {
        check(kind, outside, x, y, slopes)?;
        let secants = Secants::new(x, y);
        let slopes = match kind {
            CurveKind::Steps | CurveKind::Linear => Vec::new(),
            CurveKind::Pchip => monotone_slopes(&secants),
            CurveKind::Cubic => secants.without_rounding(spline_slopes(&secants, slopes)),
            CurveKind::PeriodicCubic => secants.without_rounding(periodic_slopes(&secants)),
        };
        let zero = DoubleDouble::ZERO;
        let mut coefficients = Vec::with_capacity(secants.lengths.len());
        for (index, (&h, &m)) in secants.lengths.iter().zip(&secants.slopes).enumerate() {
            let piece = match kind {
                CurveKind::Steps => [y[index], zero, zero, zero],
                CurveKind::Linear => [y[index], m, zero, zero],
                CurveKind::Cubic | CurveKind::Pchip | CurveKind::PeriodicCubic => {
                    let (d, e) = (slopes[index], slopes[index + 1]);
                    let square = (number(3.0) * m - number(2.0) * d - e) / h;
                    [y[index], d, square, (d + e - number(2.0) * m) / h / h]
                }
            };
            if !piece.iter().all(|c| c.is_finite()) {
                return Err(CurveError::Overflow { index });
            }
            coefficients.push(piece);
        }
        Ok(Self {
            name: name.to_owned(),
            kind,
            outside: (kind != CurveKind::PeriodicCubic).then_some(outside.unwrap_or_default()),
            knots: x.to_vec(),
            coefficients,
            last: y[y.len() - 1],
        })
    }
}

fn check(
    kind: CurveKind,
    outside: Option<Outside>,
    x: &[DoubleDouble],
    y: &[DoubleDouble],
    slopes: Option<[DoubleDouble; 2]>,
) -> Result<(), CurveError> {
    if x.len() != y.len() {
        let (x, y) = (x.len(), y.len());
        return Err(CurveError::Lengths { x, y });
    }
    let knots = x.len();
    if knots < kind.least_knots() {
        return Err(CurveError::TooFew { knots, kind });
    }
    if knots > MOST_KNOTS {
        return Err(CurveError::TooMany { knots });
    }
    for (axis, values) in [(Axis::X, x), (Axis::Y, y)] {
        if let Some(index) = values.iter().position(|value| !value.is_finite()) {
            let value = values[index].high();
            return Err(CurveError::NotFinite { axis, index, value });
        }
    }
    if let Some(before) = x.windows(2).position(|pair| pair[1] <= pair[0]) {
        return Err(CurveError::NotIncreasing {
            index: before + 1,
            value: x[before + 1].high(),
            before: x[before].high(),
        });
    }
    if !(x[knots - 1] - x[0]).is_finite() {
        return Err(CurveError::Overflow { index: 0 });
    }
    let (first, last) = (y[0], y[knots - 1]);
    if kind == CurveKind::PeriodicCubic {
        if outside.is_some() {
            return Err(CurveError::OutsideOfPeriodic);
        }
        if first != last {
            return Err(CurveError::PeriodNotClosed {
                first: first.high(),
                last: last.high(),
                index: knots - 1,
            });
        }
    }
    let Some(slopes) = slopes else {
        return Ok(());
    };
    if kind != CurveKind::Cubic {
        return Err(CurveError::SlopesOfKind { kind });
    }
    match slopes.iter().position(|slope| !slope.is_finite()) {
        Some(end) => {
            let value = slopes[end].high();
            Err(CurveError::SlopeNotFinite { end, value })
        }
        None => Ok(()),
    }
}

/// From each knot to the next: how far, and how steep.
struct Secants {
    lengths: Vec<DoubleDouble>,
    slopes: Vec<DoubleDouble>,
}

impl Secants {
    fn new(x: &[DoubleDouble], y: &[DoubleDouble]) -> Self {
        let steps = |values: &[DoubleDouble]| -> Vec<DoubleDouble> {
            values.windows(2).map(|pair| pair[1] - pair[0]).collect()
        };
        let lengths = steps(x);
        let slopes = (steps(y).into_iter().zip(&lengths))
            .map(|(rise, &length)| rise / length)
            .collect();
        Self { lengths, slopes }
    }

    /// A slope that is rounding of the steepest secant is none: what rests at the top of a cam, or on its dwell, would be moved by it.
    fn without_rounding(&self, mut slopes: Vec<DoubleDouble>) -> Vec<DoubleDouble> {
        let steepest = (self.slopes.iter()).fold(DoubleDouble::ZERO, |most, s| most.max(s.abs()));
        let rounding = number(SLOPE_ROUNDOFFS * DoubleDouble::ROUNDOFF) * steepest;
        for slope in &mut slopes {
            if slope.abs() <= rounding {
                *slope = DoubleDouble::ZERO;
            }
        }
        slopes
    }

    /// Lengths and secant slopes on both sides of inner knot `k`.
    fn around(&self, k: usize) -> [(DoubleDouble, DoubleDouble); 2] {
        [k - 1, k].map(|piece| (self.lengths[piece], self.slopes[piece]))
    }

    /// The second derivative is continuous where, with the lengths a, b before and after, b d_{k-1} + 2 (a + b) d_k +
    /// a d_{k+1} = 3 (b m_{k-1} + a m_k): these four numbers, each divided by a + b, so that tiny lengths do no harm.
    fn smooth([(a, m), (b, n)]: [(DoubleDouble, DoubleDouble); 2]) -> Row {
        let both = a + b;
        let (a, b) = (a / both, b / both);
        Row {
            before: b,
            own: number(2.0),
            after: a,
            right: number(3.0) * (b * m + a * n),
        }
    }
}

/// An equation between the slopes at three neighbouring knots.
struct Row {
    before: DoubleDouble,
    own: DoubleDouble,
    after: DoubleDouble,
    right: DoubleDouble,
}

/// Solves for one unknown a row. Each row's own coefficient exceeds the sum of the others, so that no pivot is needed.
fn tridiagonal(rows: &[Row]) -> Vec<DoubleDouble> {
    let mut eliminated: Vec<(DoubleDouble, DoubleDouble)> = Vec::with_capacity(rows.len());
    for row in rows {
        let (after, right) = eliminated
            .last()
            .copied()
            .unwrap_or((DoubleDouble::ZERO, DoubleDouble::ZERO));
        let own = row.own - row.before * after;
        eliminated.push((row.after / own, (row.right - row.before * right) / own));
    }
    let mut next = DoubleDouble::ZERO;
    let mut solution = vec![next; rows.len()];
    for (value, (after, right)) in solution.iter_mut().zip(eliminated).rev() {
        next = right - after * next;
        *value = next;
    }
    solution
}

/// Slopes of the spline with these slopes at its ends, natural without.
fn spline_slopes(secants: &Secants, ends: Option<[DoubleDouble; 2]>) -> Vec<DoubleDouble> {
    let (zero, one) = (DoubleDouble::ZERO, DoubleDouble::ONE);
    let pieces = secants.lengths.len();
    // At a natural end 2 d_0 + d_1 = 3 m_0.
    let end =
        |slope: Option<DoubleDouble>, secant: DoubleDouble, neighbour: DoubleDouble| match slope {
            Some(slope) => (one, zero, slope),
            None => (number(2.0), neighbour, number(3.0) * secant),
        };
    let mut rows = Vec::with_capacity(pieces + 1);
    let (own, after, right) = end(ends.map(|ends| ends[0]), secants.slopes[0], one);
    rows.push(Row {
        before: zero,
        own,
        after,
        right,
    });
    rows.extend((1..pieces).map(|k| Secants::smooth(secants.around(k))));
    let (own, before, right) = end(ends.map(|ends| ends[1]), secants.slopes[pieces - 1], one);
    rows.push(Row {
        before,
        own,
        after: zero,
        right,
    });
    tridiagonal(&rows)
}

/// Slopes of the periodic spline: those at the inner knots are linear in the slope at the ends, which the equation there
/// then gives.
fn periodic_slopes(secants: &Secants) -> Vec<DoubleDouble> {
    let zero = DoubleDouble::ZERO;
    let pieces = secants.lengths.len();
    let inner = || (1..pieces).map(|k| Secants::smooth(secants.around(k)));
    // With slope 0 at the ends, and what slope 1 there adds.
    let rested = tridiagonal(&inner().collect::<Vec<_>>());
    let unit: Vec<Row> = (inner().enumerate())
        .map(|(place, row)| {
            let mut right = zero;
            if place == 0 {
                right -= row.before;
            }
            if place + 2 == pieces {
                right -= row.after;
            }
            Row { right, ..row }
        })
        .collect();
    let added = tridiagonal(&unit);
    let last = pieces - 1;
    let around = [last, 0].map(|piece| (secants.lengths[piece], secants.slopes[piece]));
    let row = Secants::smooth(around);
    let combined = |slopes: &[DoubleDouble]| row.before * slopes[last - 1] + row.after * slopes[0];
    let end = (row.right - combined(&rested)) / (row.own + combined(&added));
    let mut slopes = vec![end];
    slopes.extend(rested.iter().zip(&added).map(|(&r, &a)| r + end * a));
    slopes.push(end);
    slopes
}

/// Slopes that keep each piece monotone (F. N. Fritsch and R. E. Carlson, SIAM J. Numer. Anal. 17 (1980) 238; the weighted
/// harmonic mean is of F. N. Fritsch and J. Butland, SIAM J. Sci. Stat. Comput. 5 (1984) 300).
fn monotone_slopes(secants: &Secants) -> Vec<DoubleDouble> {
    let pieces = secants.lengths.len();
    if pieces == 1 {
        return vec![secants.slopes[0]; 2];
    }
    let inner = (1..pieces).map(|k| {
        let [(a, m), (b, n)] = secants.around(k);
        if sign(m) * sign(n) <= 0 {
            return DoubleDouble::ZERO;
        }
        let (v, w) = (number(2.0) * b + a, b + number(2.0) * a);
        (v + w) / (v / m + w / n)
    });
    let at = |piece: usize| (secants.lengths[piece], secants.slopes[piece]);
    let mut slopes = vec![monotone_end(at(0), at(1))];
    slopes.extend(inner);
    slopes.push(monotone_end(at(pieces - 1), at(pieces - 2)));
    slopes
}

/// The slope of the parabola through three points at its end, cut back where that would overshoot.
fn monotone_end(
    (a, m): (DoubleDouble, DoubleDouble),
    (b, n): (DoubleDouble, DoubleDouble),
) -> DoubleDouble {
    let slope = ((number(2.0) * a + b) * m - a * n) / (a + b);
    let steepest = number(3.0) * m;
    if sign(slope) != sign(m) {
        DoubleDouble::ZERO
    } else if sign(m) != sign(n) && slope.abs() > steepest.abs() {
        steepest
    } else {
        slope
    }
}

fn sign(value: DoubleDouble) -> i32 {
    i32::from(value > DoubleDouble::ZERO) - i32::from(value < DoubleDouble::ZERO)
}
