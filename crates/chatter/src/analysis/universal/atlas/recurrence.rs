//! All mu of an interval at which a given point is periodic.

use super::enclosure::{Enclosing, Interval};

/// Intervals of mu that each hold one root, and how many were given up because there were too many.
#[derive(Clone, Debug, Default)]
pub(super) struct Recurrences {
    pub brackets: Vec<Interval>,
    pub undecided: usize,
}

/// Below this length relative to mu an interval is not halved again.
const SHORTEST: f64 = 1e-13;
/// Intervals looked at for one point and one period: more is a question nobody wants the answer to.
const MOST: usize = 1 << 16;

/// A point that is to return to itself under the map with slope K.
pub(super) struct Recurrence<'a> {
    pub enclosing: &'a Enclosing<'a>,
    pub slope: f64,
    pub point: f64,
    pub period: usize,
    /// Orbits that come so far are given up.
    pub beyond: f64,
}

impl Recurrence<'_> {
    /// F^p(point) - point at mu.
    pub(super) fn residual(&self, mu: f64) -> f64 {
        let mut x = self.point;
        for _ in 0..self.period {
            x = self.slope * self.enclosing.universal.value(x) + mu;
        }
        x - self.point
    }

    /// Values of F^p(point) over an interval of mu, and of its derivative by mu.
    fn image(&self, mu: Interval) -> Option<(Interval, Interval, bool)> {
        let slope = Interval::point(self.slope);
        let middle = 0.5 * (mu.low + mu.high);
        let lengths = Interval::new(mu.low - middle, mu.high - middle);
        let start = Interval::point(self.slope * self.enclosing.universal.value(self.point));
        let mut x = mu.plus(start);
        let mut at_middle = middle + start.low;
        let mut by_mu = Interval::point(1.0);
        let mut returned = false;
        for _ in 1..self.period {
            returned |= x.contains(self.point);
            if x.low > self.beyond {
                return None;
            }
            let (value, derivative) = self.enclosing.image(x);
            by_mu = Interval::point(1.0).plus(slope.times(derivative).times(by_mu));
            x = mu.plus(slope.times(value));
            at_middle = self.slope * self.enclosing.universal.value(at_middle) + middle;
            // Mean value theorem: x depends on mu in two ways that partly cancel.
            if by_mu.low.is_finite() && by_mu.high.is_finite() {
                let mean = Interval::point(at_middle).plus(by_mu.times(lengths));
                let met = x.meet(mean);
                if met.low <= met.high {
                    x = met;
                }
            }
        }
        Some((x, by_mu, returned))
    }

    /// All roots in `range`, each in an interval on which the residual is monotone, or that is hardly longer than
    /// rounding errors.
    pub(super) fn all(&self, range: Interval) -> Recurrences {
        let mut found = Recurrences::default();
        let mut left = vec![range];
        let mut looked_at = 0;
        while let Some(mu) = left.pop() {
            looked_at += 1;
            let Some((image, by_mu, returned)) = self.image(mu) else {
                continue;
            };
            if !image.contains(self.point) {
                continue;
            }
            let size = mu.low.abs().max(mu.high.abs());
            let short = mu.high - mu.low <= SHORTEST * size;
            if by_mu.low > 0.0 || by_mu.high < 0.0 || short {
                // On a short interval a point of the orbit comes to a lap's end: no slope to decide by. Where this point has
                // returned before, it is an orbit of smaller period.
                let (a, b) = (self.residual(mu.low), self.residual(mu.high));
                // Half open, so that a root on a seam is found once.
                if ((a <= 0.0 && b > 0.0) || (a >= 0.0 && b < 0.0)) && !(short && returned) {
                    found.brackets.push(mu);
                }
                continue;
            }
            if looked_at >= MOST {
                found.undecided += 1;
                continue;
            }
            let middle = 0.5 * (mu.low + mu.high);
            left.push(Interval::new(middle, mu.high));
            left.push(Interval::new(mu.low, middle));
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::evaluate::Universal;
    use super::*;

    /// Against a search on a fine grid.
    #[test]
    fn no_recurrence_is_missed() {
        let universal = Universal::new(0.8).unwrap();
        let enclosing = Enclosing::new(&universal);
        for (slope, lap, range) in [
            (1.0, 8, (0.006, 0.01)),
            (1.0, 45, (2.0e-6, 3.0e-6)),
            (3.0, 12, (0.001, 0.004)),
            (-2.0, 6, (0.01, 0.03)),
        ] {
            for point in [
                universal.critical_point(lap),
                universal.lap_end() * libm::pow(universal.constants().eta, lap as f64),
            ] {
                for period in 2..=4 {
                    let recurrence = Recurrence {
                        enclosing: &enclosing,
                        slope,
                        point,
                        period,
                        beyond: f64::INFINITY,
                    };
                    let found = recurrence.all(Interval::new(range.0, range.1));
                    const GRID: i32 = 40_000;
                    let step = (range.1 - range.0) / f64::from(GRID);
                    let mut before = recurrence.residual(range.0);
                    for k in 1..=GRID {
                        let mu = range.0 + step * f64::from(k);
                        let now = recurrence.residual(mu);
                        if (now > 0.0) != (before > 0.0) {
                            let near = |b: &&Interval| b.low <= mu && b.high >= mu - step;
                            assert!(
                                found.brackets.iter().any(|b| near(&b)),
                                "{slope} {mu} {period}"
                            );
                        }
                        before = now;
                    }
                }
            }
        }
    }
}
