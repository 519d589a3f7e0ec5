//! What the samples of an orbit say about it.

use super::tail::{Tail, between_phases};
use crate::analysis::map::CoordinateKind;

/// The kept samples of an orbit, and how it came from one to the next.
pub(in crate::analysis::diagram) struct Settled<'a> {
    /// Whole points at the latest samples.
    pub points: &'a Tail,
    /// What their coordinates are.
    pub kinds: &'a [CoordinateKind],
    /// What size they have, on the way from sample to sample, too.
    pub sizes: &'a [f64],
    /// Impacts and time since the sample before, one a sample.
    pub ways: &'a [(u64, f64)],
}

/// A coordinate that is zero at all samples but for rounding errors differs by them, which are this small against its size elsewhere.
const ROUNDING: f64 = 1e-13;

impl Settled<'_> {
    /// The smallest number of samples after which the whole point, the number of impacts and the time repeat, over the
    /// second half of the samples at least.
    pub fn period(&self, longest: u64, tolerance: f64) -> Option<usize> {
        let count = self.ways.len();
        let allowed = self.allowed(tolerance);
        let longest_way = self.ways.iter().fold(0.0_f64, |most, way| most.max(way.1));
        let longest = usize::try_from(longest)
            .unwrap_or(usize::MAX)
            .min(count / 2);
        (1..=longest).find(|&period| {
            let first = (count / 2).max(period);
            (first..count).rev().all(|place| {
                self.same_way(place, place - period, longest_way * tolerance)
                    && self.same_point(place, place - period, &allowed)
            })
        })
    }

    /// By how much coordinates that are the same may differ.
    fn allowed(&self, tolerance: f64) -> Vec<f64> {
        let at_samples = self.points.sizes();
        let allowed = |(index, kind): (usize, &CoordinateKind)| match *kind {
            CoordinateKind::Plain => at_samples[index] * tolerance + self.sizes[index] * ROUNDING,
            CoordinateKind::Phase { period } => period * tolerance,
            CoordinateKind::Idle { .. } => f64::INFINITY,
        };
        self.kinds.iter().enumerate().map(allowed).collect()
    }

    fn same_way(&self, a: usize, b: usize, allowed: f64) -> bool {
        let (a, b) = (self.ways[a], self.ways[b]);
        a.0 == b.0 && (a.1 == b.1 || (a.1 - b.1).abs() <= allowed)
    }

    fn same_point(&self, a: usize, b: usize, allowed: &[f64]) -> bool {
        let missing = self.ways.len() - self.points.len();
        // Of long orbits only the latest points are known.
        let (Some(a), Some(b)) = (a.checked_sub(missing), b.checked_sub(missing)) else {
            return true;
        };
        let pairs = self.points.point(a).iter().zip(self.points.point(b));
        pairs
            .zip(self.kinds)
            .zip(allowed)
            .all(|(((&x, &y), kind), &allowed)| match *kind {
                CoordinateKind::Phase { period } => between_phases(x, y, period) <= allowed,
                // Equal values first: both may be infinite.
                CoordinateKind::Plain => x == y || (x - y).abs() <= allowed,
                CoordinateKind::Idle { .. } => true,
            })
    }
}

#[cfg(test)]
mod tests {
    use super::super::aperiodic::{Evidence, evidence, grows};
    use super::super::embedding::Embedding;
    use super::*;

    fn tail(values: &[f64], dimension: usize) -> Tail {
        let mut tail = Tail::new(dimension, 4096);
        values.chunks(dimension).for_each(|point| tail.push(point));
        tail
    }

    fn judged(values: &[f64], kinds: &[CoordinateKind]) -> (Option<usize>, Evidence) {
        let tail = tail(values, kinds.len());
        let ways = vec![(1, 1.0); tail.len()];
        let sizes = tail.sizes();
        let settled = Settled {
            points: &tail,
            kinds,
            sizes: &sizes,
            ways: &ways,
        };
        (
            settled.period(16, 1e-8),
            evidence(&Embedding::new(&tail, 4096, (kinds, &sizes))),
        )
    }

    fn of(values: &[f64]) -> (Option<usize>, Evidence) {
        judged(values, &[CoordinateKind::Plain])
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
            let found = of(&logistic(a, 5000, 200));
            assert_eq!(found, (None, Evidence::Chaotic), "a = {a}");
        }
    }

    #[test]
    fn an_approach_is_neither_chaos_nor_quasiperiodic() {
        assert_eq!(of(&logistic(2.99, 20, 200)), (None, Evidence::None));
        assert_eq!(of(&logistic(3.01, 20, 100)), (None, Evidence::None));
        for factor in [0.99, 0.999, 0.9999] {
            for turn in [0.618, 0.07, 0.33] {
                let spiral = |k: u32| {
                    let size = libm::pow(factor, f64::from(k));
                    let angle = core::f64::consts::TAU * turn * f64::from(k);
                    [size * libm::cos(angle), size * libm::sin(angle)]
                };
                let points: Vec<f64> = (0..200).flat_map(spiral).collect();
                let found = judged(&points, &[CoordinateKind::Plain, CoordinateKind::Plain]);
                assert_eq!(found, (None, Evidence::None), "{factor} {turn}");
            }
        }
    }

    #[test]
    fn rotations_are_quasiperiodic_and_cascades_are_not() {
        let golden = 0.618_033_988_749_894_9;
        for turn in [golden, 2.0_f64.sqrt(), core::f64::consts::E] {
            let wave = |k: u32| {
                let angle = core::f64::consts::TAU * turn * f64::from(k);
                let bent = libm::cos(angle) + 0.2 * libm::cos(2.0 * angle);
                [bent, 1e3 + libm::sin(angle + 0.3 * bent)]
            };
            let points: Vec<f64> = (0..200).flat_map(wave).collect();
            let found = judged(&points, &[CoordinateKind::Plain, CoordinateKind::Plain]);
            assert_eq!(found, (None, Evidence::Quasiperiodic), "{turn}");
            // The angle itself, whole turns and all.
            let angles: Vec<f64> = (0..200).map(|k| turn * f64::from(k)).collect();
            let found = judged(&angles, &[CoordinateKind::Phase { period: 1.0 }]);
            assert_eq!(found, (None, Evidence::Quasiperiodic), "{turn}");
        }
        // At the accumulation of the period doublings, and in the bands just behind it.
        for a in [3.569_945_671_8, 3.5700, 3.5705, 3.575] {
            for count in [200, 1000, 4000] {
                let found = of(&logistic(a, 5000, count));
                assert_ne!(found.1, Evidence::Quasiperiodic, "a = {a}");
            }
        }
    }

    #[test]
    fn phases_repeat_up_to_whole_periods_and_what_is_idle_does_not_count() {
        let points: Vec<f64> = (0..60)
            .flat_map(|k| [f64::from(k % 2), 0.3 + 0.5 * f64::from(k), f64::from(k)])
            .collect();
        let judge = |period| {
            let kinds = [
                CoordinateKind::Plain,
                CoordinateKind::Phase { period },
                CoordinateKind::Idle { others: Vec::new() },
            ];
            judged(&points, &kinds).0
        };
        assert_eq!(judge(1.0), Some(2));
        assert_eq!(judge(0.5), Some(2));
        assert_eq!(judge(1.5), Some(6));
        assert_eq!(judge(0.7), Some(14));
        assert_eq!(judge(2.0_f64.sqrt()), None);
    }

    #[test]
    fn impacts_and_times_tell_orbits_apart_that_look_the_same() {
        let points = tail(&[0.5; 12], 1);
        let mut ways = [(3, 1.0); 12];
        for place in (0..12).step_by(2) {
            ways[place].0 = 4;
        }
        let settled = |ways| {
            Settled {
                points: &points,
                kinds: &[CoordinateKind::Plain],
                sizes: &[0.5],
                ways,
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
    fn nothing_is_concluded_from_a_single_sample() {
        assert_eq!(of(&[1.0]), (None, Evidence::None));
    }
}
