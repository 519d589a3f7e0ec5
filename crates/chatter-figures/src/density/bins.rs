//! Cells along an axis, and which of them the pixels of a picture cover.

use crate::axis::{Extent, Scale};

/// Cells along one axis, equal in the scale's linear coordinate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bins {
    pub(crate) scale: Scale,
    pub(crate) low: f64,
    pub(crate) high: f64,
    pub(crate) count: usize,
}

impl Bins {
    pub(super) fn new((low, high): (f64, f64), count: usize) -> Self {
        let (low, high) = if low < high {
            (low, high)
        } else {
            (low - 0.5, low + 0.5)
        };
        Bins {
            scale: Scale::Linear,
            low,
            high,
            count,
        }
    }

    pub(super) fn rescaled(self, scale: Scale) -> Self {
        let (low, high) = (
            self.scale.backward(self.low),
            self.scale.backward(self.high),
        );
        Bins {
            scale,
            low: scale.forward(low),
            high: scale.forward(high),
            ..self
        }
    }

    /// The cell of a number; both ends belong to the range.
    pub(super) fn index(&self, x: f64) -> Option<usize> {
        let u = self.scale.forward(x);
        if !(u >= self.low && u <= self.high) {
            return None;
        }
        let k = (u - self.low) / (self.high - self.low) * self.count as f64;
        Some((k as usize).min(self.count - 1))
    }

    pub(crate) fn extent(&self) -> Extent {
        Extent {
            low: self.low,
            high: self.high,
        }
    }
}

/// Which cells a pixel covers, and how much of the first and last.
pub(super) struct Overlap {
    first: usize,
    count: usize,
    head: f64,
    tail: f64,
}

impl Overlap {
    /// Cell and the part of it that is covered.
    pub(super) fn weights(&self) -> impl Iterator<Item = (usize, f64)> {
        (0..self.count).map(|k| {
            let weight = match (k, self.count) {
                (0, _) => self.head,
                (k, n) if k + 1 == n => self.tail,
                _ => 1.0,
            };
            (self.first + k, weight)
        })
    }
}

/// The cells that each pixel of a window covers.
pub(super) fn overlaps(bins: &Bins, window: (f64, f64), pixels: usize) -> Vec<Overlap> {
    let scale = bins.count as f64 / (bins.high - bins.low);
    let edge = |k: usize| {
        let u = window.0 + (window.1 - window.0) * (k as f64 / pixels as f64);
        ((u - bins.low) * scale).clamp(0.0, bins.count as f64)
    };
    (0..pixels)
        .map(|k| {
            let (a, b) = (edge(k), edge(k + 1));
            let (a, b) = (a.min(b), a.max(b));
            if a == b {
                return Overlap {
                    first: 0,
                    count: 0,
                    head: 0.0,
                    tail: 0.0,
                };
            }
            let first = a.floor() as usize;
            let count = b.ceil() as usize - first;
            Overlap {
                first,
                count,
                head: b.min(first as f64 + 1.0) - a,
                tail: b - (b.ceil() - 1.0),
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn resampling_keeps_the_sum(
            cells in 1usize..30,
            pixels in 1usize..60,
            counts in proptest::collection::vec(0u32..100, 30),
        ) {
            let bins = Bins { scale: Scale::Linear, low: 0.0, high: 1.0, count: cells };
            for window in [(0.0, 1.0), (1.0, 0.0), (-0.5, 2.0)] {
                let total: f64 = overlaps(&bins, window, pixels)
                    .iter()
                    .map(|o| o.weights().map(|(k, w)| w * f64::from(counts[k])).sum::<f64>())
                    .sum();
                let expected: u32 = counts[..cells].iter().sum();
                prop_assert!((total - f64::from(expected)).abs() < 1e-9 * f64::from(expected + 1));
            }
        }
    }
}
