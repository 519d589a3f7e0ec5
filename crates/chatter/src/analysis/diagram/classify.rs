//! What the samples of an orbit say about it.

/// The kept samples of an orbit, and how it came from one to the next.
pub(super) struct Settled<'a> {
    /// Sample after sample, each with all observed quantities.
    pub samples: &'a [f64],
    /// How many quantities are observed.
    pub observed: usize,
    /// Impacts and time since the sample before, one a sample.
    pub ways: &'a [(u64, f64)],
    /// Largest coordinate of the orbit's last point.
    pub scale: f64,
}

/// A sample that is zero but for rounding errors differs by them, which are this small against the coordinates.
const ROUNDING: f64 = 1e-13;

/// Fewer pairs of neighbours than this say nothing about whether neighbours move apart.
const LEAST_PAIRS: usize = 16;

/// Growth counts if its mean exceeds so many times its standard error: where distances only fluctuate, as they do on
/// quasi-periodic orbits, the mean is as often positive as negative.
const SIGNIFICANT: f64 = 2.0;

/// Whether distances grow, from logarithms of their growth.
pub(super) fn grows(logarithms: &[f64]) -> bool {
    let count = logarithms.len() as f64;
    let mean = logarithms.iter().sum::<f64>() / count;
    let squares = logarithms.iter().map(|x| (x - mean) * (x - mean));
    let error = (squares.sum::<f64>() / (count * (count - 1.0))).sqrt();
    mean > SIGNIFICANT * error
}

impl Settled<'_> {
    /// The smallest number of samples after which all that was sampled, the number of impacts and the time repeat, over
    /// the second half of the samples at least.
    pub fn period(&self, longest: u64, tolerance: f64) -> Option<usize> {
        let count = self.ways.len();
        let mut allowed: Vec<f64> = (0..self.observed)
            .map(|k| self.largest(k) * tolerance + self.scale * ROUNDING)
            .collect();
        let longest_way = self.ways.iter().fold(0.0_f64, |most, way| most.max(way.1));
        allowed.push(longest_way * tolerance);
        let longest = usize::try_from(longest)
            .unwrap_or(usize::MAX)
            .min(count / 2);
        (1..=longest).find(|&period| {
            let first = (count / 2).max(period);
            (first..count)
                .rev()
                .all(|place| self.same(place, place - period, &allowed))
        })
    }

    fn same(&self, a: usize, b: usize, allowed: &[f64]) -> bool {
        let n = self.observed;
        let samples = self.samples[a * n..(a + 1) * n]
            .iter()
            .zip(&self.samples[b * n..(b + 1) * n]);
        let times = (&self.ways[a].1, &self.ways[b].1);
        self.ways[a].0 == self.ways[b].0
            && samples
                .chain([times])
                .zip(allowed)
                // Equal values first: both may be infinite.
                .all(|((x, y), &allowed)| x == y || (x - y).abs() <= allowed)
    }

    fn largest(&self, quantity: usize) -> f64 {
        self.quantity(quantity)
            .fold(0.0_f64, |most, x| most.max(x.abs()))
    }

    fn quantity(&self, quantity: usize) -> impl Iterator<Item = f64> {
        let samples = self.samples.iter().skip(quantity);
        samples.step_by(self.observed).copied()
    }

    /// Whether samples that are neighbours move apart, in the mean of the logarithm: the sign of the largest exponent,
    /// told from the samples alone (after Wolf et al. 1985, Determining Lyapunov exponents from a time series).
    pub fn spreads(&self) -> bool {
        let quantities = (0..self.observed).map(|k| self.neighbours(k));
        // Counts and other quantities of few values tell hardly any samples apart; of the others the one that varies most
        // relative to its size tells neighbours best.
        let clearest = quantities.max_by(|a, b| {
            let pairs = a.growth.len().cmp(&b.growth.len());
            pairs.then(a.variation.total_cmp(&b.variation))
        });
        clearest.is_some_and(|told| told.growth.len() >= LEAST_PAIRS && grows(&told.growth))
    }

    /// Samples that are neighbours by one observed quantity, and where they are a sample later.
    fn neighbours(&self, quantity: usize) -> Neighbours {
        let values: Vec<f64> = self.quantity(quantity).collect();
        let mut order: Vec<usize> = (0..values.len().saturating_sub(1)).collect();
        order.sort_unstable_by(|&a, &b| values[a].total_cmp(&values[b]));
        let mut growth = Vec::new();
        for pair in order.windows(2) {
            let (a, b) = (pair[0], pair[1]);
            let before = (values[a] - values[b]).abs();
            let after = (values[a + 1] - values[b + 1]).abs();
            if before > 0.0 && after > 0.0 && (before + after).is_finite() {
                growth.push(libm::log(after / before));
            }
        }
        let extent = (f64::INFINITY, f64::NEG_INFINITY);
        let extent = values
            .iter()
            .fold(extent, |(low, high), &x| (low.min(x), high.max(x)));
        let size = extent.0.abs().max(extent.1.abs()) + f64::MIN_POSITIVE;
        Neighbours {
            growth,
            variation: (extent.1 - extent.0) / size,
        }
    }
}

/// What samples that are neighbours by one quantity do.
struct Neighbours {
    /// Logarithms of the growth of their distances, one for each pair that can be told apart, before and after.
    growth: Vec<f64>,
    /// How much the quantity varies, relative to its size.
    variation: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(values: &[f64]) -> (Option<usize>, bool) {
        let ways = vec![(1, 1.0); values.len()];
        let settled = Settled {
            samples: values,
            observed: 1,
            ways: &ways,
            scale: 1.0,
        };
        (settled.period(16, 1e-8), settled.spreads())
    }

    fn logistic(a: f64, transient: usize, count: usize) -> Vec<f64> {
        let mut x = 0.4;
        let mut next = || {
            x = a * x * (1.0 - x);
            x
        };
        (0..transient).for_each(|_| {
            next();
        });
        (0..count).map(|_| next()).collect()
    }

    #[test]
    fn the_logistic_map_has_the_periods_of_its_books() {
        // May 1976: 2-cycle from 3, 4-cycle from 1 + sqrt(6), 3-cycle from 1 + sqrt(8).
        for (a, period) in [
            (2.8, 1),
            (3.2, 2),
            (3.5, 4),
            (3.55, 8),
            (3.832, 3),
            (3.63, 6),
        ] {
            assert_eq!(of(&logistic(a, 5000, 200)).0, Some(period), "a = {a}");
        }
        for a in [3.6, 3.7, 3.9, 4.0] {
            assert_eq!(of(&logistic(a, 5000, 200)), (None, true), "a = {a}");
        }
    }

    #[test]
    fn an_approach_is_not_chaos() {
        assert_eq!(of(&logistic(2.99, 20, 200)), (None, false));
        assert_eq!(of(&logistic(3.01, 20, 100)), (None, false));
    }

    #[test]
    fn impacts_and_times_tell_orbits_apart_that_look_the_same() {
        let samples = [0.5; 12];
        let mut ways = [(3, 1.0); 12];
        for place in (0..12).step_by(2) {
            ways[place].0 = 4;
        }
        let settled = |ways| {
            Settled {
                samples: &samples,
                observed: 1,
                ways,
                scale: 1.0,
            }
            .period(4, 1e-8)
        };
        assert_eq!(settled(&ways), Some(2));
        let mut times = [(3, 1.0); 12];
        for place in (0..12).step_by(3) {
            times[place].1 = 1.0 + 1e-6;
        }
        assert_eq!(settled(&times), Some(3));
    }

    #[test]
    fn fluctuation_is_no_growth() {
        // On a circle by the golden angle: neighbours stay neighbours.
        let turn = 2.0 * core::f64::consts::PI * 0.618_033_988_749_894_9;
        let circle = |k: u32| libm::cos(turn * f64::from(k));
        let logarithms: Vec<f64> = (0..200)
            .map(|k| libm::log((2.0 + circle(k + 1)) / (2.0 + circle(k))))
            .collect();
        assert!(!grows(&logarithms));
        assert!(grows(&[1.0, 2.0, 1.5]) && !grows(&[-1.0, -2.0, -1.5]));
        assert!(!grows(&[f64::NEG_INFINITY, 1.0]) && !grows(&[]));
    }

    #[test]
    fn counts_beside_a_state_do_not_hide_chaos() {
        let states = logistic(3.9, 100, 200);
        let samples: Vec<f64> = states
            .iter()
            .flat_map(|&x| [x, f64::from(x > 0.5)])
            .collect();
        let ways = vec![(1, 1.0); states.len()];
        let settled = Settled {
            samples: &samples,
            observed: 2,
            ways: &ways,
            scale: 1.0,
        };
        assert!(settled.spreads());
    }

    #[test]
    fn nothing_is_concluded_from_a_single_sample() {
        assert_eq!(of(&[1.0]), (None, false));
    }
}
