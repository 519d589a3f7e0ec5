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
    /// How the orbit came to each sample from the one before.
    pub ways: &'a [Way],
}

/// How an orbit came from one sample to the next.
#[derive(Clone, Copy, Debug)]
pub(in crate::analysis::diagram) struct Way {
    /// Impacts, and how many infinite sequences of them.
    pub impacts: u64,
    pub accumulations: u64,
    pub time: f64,
}

impl Way {
    /// Whether the events of two ways are the same ones. Of an infinite sequence impacts are followed one by one up to somewhere, which
    /// rounding may decide: their number says nothing. Nor does that of sequences: where contacts chatter together one comes to rest and
    /// is struck off again, as often as its flights are long enough to be told.
    fn has_events_of(self, other: Self) -> bool {
        match (self.accumulations, other.accumulations) {
            (0, 0) => self.impacts == other.impacts,
            (own, others) => own > 0 && others > 0,
        }
    }
}

/// What the samples of an orbit show of a period.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::analysis::diagram) enum Repetition {
    /// The orbit repeats after so many samples, and not after fewer.
    Cycle(usize),
    /// Samples so far apart as to be the same by now differ from those between by what still dies out.
    Approach,
    /// The orbit does not repeat.
    None,
}

impl Repetition {
    /// After how many samples the orbit repeats, if it does.
    pub fn period(self) -> Option<usize> {
        match self {
            Self::Cycle(period) => Some(period),
            Self::Approach | Self::None => None,
        }
    }
}

/// By what part of its distance from the other points of its cycle a point may still move, both ways together: a cycle is told
/// where most of what keeps its points apart is there to stay. Just where periods double it dies out like 1/sqrt(n), and from
/// two halves of some samples a third of it seems to be to come.
const TO_COME: f64 = 0.25;

/// What is to come is reckoned to be so many times what came at most: two steps whose lengths differ by less than a
/// ten-thousandth are not told from equal ones.
const FARTHEST: f64 = 1e4;

/// A coordinate that is zero at all samples but for rounding errors differs by them, which are this small against its size elsewhere.
const ROUNDING: f64 = 1e-13;

impl Settled<'_> {
    /// The smallest number of samples after which the whole point, the number of impacts and the time repeat, over the
    /// second half of the samples at least, if the points between are others and stay so.
    pub fn repetition(&self, longest: u64, tolerance: f64) -> Repetition {
        if !self.has_died_out() {
            return self.repeats(longest, tolerance);
        }
        // Impacts of what is nothing any more come as often as they do between two samples.
        let without_events = |way: &Way| Way {
            impacts: 0,
            accumulations: 0,
            ..*way
        };
        let ways: Vec<Way> = self.ways.iter().map(without_events).collect();
        Settled {
            ways: &ways,
            ..*self
        }
        .repeats(longest, tolerance)
    }

    /// Whether all that is left of the motion at its samples is next to nothing of what it was.
    pub fn has_died_out(&self) -> bool {
        let at_samples = self.points.sizes();
        let mut places = (self.kinds.iter().zip(self.sizes).zip(at_samples)).filter_map(
            |((kind, size), left)| matches!(kind, CoordinateKind::Plain).then_some((*size, left)),
        );
        let moved = self.sizes.iter().any(|size| *size > 0.0);
        moved && places.all(|(size, left)| 2.0 * left <= ROUNDING * size)
    }

    fn repeats(&self, longest: u64, tolerance: f64) -> Repetition {
        let count = self.ways.len();
        let allowed = self.allowed(tolerance);
        let longest_way = self
            .ways
            .iter()
            .fold(0.0_f64, |most, way| most.max(way.time));
        let longest = usize::try_from(longest)
            .unwrap_or(usize::MAX)
            .min(count / 2);
        let repeats = |&period: &usize| {
            let first = (count / 2).max(period);
            (first..count).rev().all(|place| {
                self.same_way(place, place - period, longest_way * tolerance)
                    && self.same_point(place, place - period, &allowed)
            })
        };
        match (1..=longest).find(repeats) {
            None => Repetition::None,
            Some(period) if self.stays(period, &allowed, longest_way * tolerance) => {
                Repetition::Cycle(period)
            }
            Some(_) => Repetition::Approach,
        }
    }

    /// Whether the points of a period keep apart that a shorter one would make the same.
    ///
    /// An orbit that settles as c lambda^n about a point repeats after p samples within the tolerance as soon as
    /// |c (lambda^p - 1)| is below it, which for lambda^p near 1 is long before |c (lambda - 1)| is: what tells it from a cycle is
    /// where it goes. Every p-th point moves by steps whose lengths fall off like |lambda|^p, so that what is to come after a
    /// step of length b that followed one of length a is b^2 / (a - b) (Aitken). Twice this, for both points, is as much as the
    /// distance of two points may still lose, and where both have one limit it is no less than their distance.
    fn stays(&self, period: usize, allowed: &[f64], allowed_time: f64) -> bool {
        if period == 1 || self.points.len() < 2 * period {
            return true;
        }
        let count = self.ways.len();
        let judged = (count - (count / 2).max(period) + period).min(self.points.len());
        let cycle = count - period..count;
        // By how much the points of the latest period, or of one so many samples before, differ from those so many before them.
        let differ = |before: usize, apart: usize| {
            let places = cycle.clone().map(|place| place - before);
            let differences =
                places.map(|place| self.difference(place, place - apart, allowed, allowed_time));
            differences.fold(0.0_f64, f64::max)
        };
        let step = (judged - period) / (2 * period) * period;
        let moved = differ(0, step.max(period));
        let before = if step > 0 { differ(step, step) } else { moved };
        let factor = if before > moved {
            moved / (before - moved)
        } else {
            f64::INFINITY
        };
        let to_come = moved * factor.min(FARTHEST);
        prime_factors(period).all(|factor| {
            let apart = differ(0, period / factor);
            apart >= 1.0 && 2.0 * to_come <= TO_COME * apart
        })
    }

    /// By how much two samples differ, in parts of what is allowed. Both must be known.
    fn difference(&self, a: usize, b: usize, allowed: &[f64], allowed_time: f64) -> f64 {
        let parts = |difference: f64, allowed: f64| match difference {
            0.0 => 0.0,
            difference => difference / allowed,
        };
        let (way, other) = (self.ways[a], self.ways[b]);
        if !way.has_events_of(other) {
            return f64::INFINITY;
        }
        let time = if way.time == other.time {
            0.0
        } else {
            parts((way.time - other.time).abs(), allowed_time)
        };
        let missing = self.ways.len() - self.points.len();
        let pairs = (self.points.point(a - missing).iter()).zip(self.points.point(b - missing));
        let coordinates = pairs.zip(self.kinds).zip(allowed);
        let differences = coordinates.map(|(((&x, &y), kind), &allowed)| match *kind {
            CoordinateKind::Phase { period } => parts(between_phases(x, y, period), allowed),
            CoordinateKind::Plain if x != y => parts((x - y).abs(), allowed),
            CoordinateKind::Plain | CoordinateKind::Idle { .. } => 0.0,
        });
        differences.fold(time, f64::max)
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
        let is_as_long = a.time == b.time || (a.time - b.time).abs() <= allowed;
        is_as_long && a.has_events_of(b)
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

fn prime_factors(number: usize) -> impl Iterator<Item = usize> {
    let divides = move |factor: &usize| number.is_multiple_of(*factor);
    let is_prime = |factor: &usize| (2..*factor).all(|other| !factor.is_multiple_of(other));
    (2..=number).filter(divides).filter(is_prime)
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

    fn way(impacts: u64, time: f64) -> Way {
        Way {
            impacts,
            accumulations: 0,
            time,
        }
    }

    fn judged(values: &[f64], kinds: &[CoordinateKind]) -> (Option<usize>, Evidence) {
        let tail = tail(values, kinds.len());
        let ways = vec![way(1, 1.0); tail.len()];
        let sizes = tail.sizes();
        let settled = Settled {
            points: &tail,
            kinds,
            sizes: &sizes,
            ways: &ways,
        };
        (
            settled.repetition(16, 1e-8).period(),
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

    /// A pseudo-random number from zero to one, for a place in a sequence (Knuth's multiplier for 64 bits).
    fn random(seed: &mut u64) -> f64 {
        *seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (*seed >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Points of x'' + 2 z x' + x = cos(w t), once a period of the load: (x, x').
    fn oscillator((z, w): (f64, f64), transient: usize, count: usize) -> Vec<f64> {
        let own = (1.0 - z * z).sqrt();
        let size = (1.0 - w * w).powi(2) + 4.0 * z * z * w * w;
        let (x, v) = ((1.0 - w * w) / size, 2.0 * z * w * w / size);
        let point = |k: usize| {
            let t = core::f64::consts::TAU * k as f64 / w;
            let (c, s) = (libm::cos(own * t), libm::sin(own * t));
            let (a, b) = (1.0 - x, (z * (1.0 - x) - v) / own);
            let left = libm::exp(-z * t);
            [
                x + left * (a * c + b * s),
                v + left * ((own * b - z * a) * c - (own * a + z * b) * s),
            ]
        };
        (transient..transient + count).flat_map(point).collect()
    }

    const PLANE: [CoordinateKind; 2] = [CoordinateKind::Plain, CoordinateKind::Plain];

    #[test]
    fn a_linear_oscillator_that_settles_has_no_period_but_one_and_no_chaos() {
        let mut seed = 1;
        for (transient, keep) in [(300, 200), (3000, 200), (300, 40), (300, 600)] {
            let mut settled = 0;
            for _ in 0..500 {
                let z = libm::pow(10.0, -1.0 - 3.0 * random(&mut seed));
                let w = 0.2 + 4.8 * random(&mut seed);
                let points = oscillator((z, w), transient, keep);
                let (period, evidence) = judged(&points, &PLANE);
                settled += usize::from(period == Some(1));
                assert!(period.is_none_or(|period| period == 1), "{z} {w}");
                assert!(period.is_some() || evidence == Evidence::None, "{z} {w}");
                // What has died out to the tolerance has settled.
                let left = libm::exp(-z * core::f64::consts::TAU / w * transient as f64);
                assert!(left > 1e-14 || period == Some(1), "{z} {w}");
            }
            assert!(settled > 50, "{settled}");
        }
        // Three samples are a turn but for a millionth of it.
        let points = oscillator((0.0257, 3.0), 300, 200);
        assert_eq!(judged(&points, &PLANE), (None, Evidence::None));
        assert_eq!(
            judged(&oscillator((0.0257, 3.0), 500, 200), &PLANE).0,
            Some(1)
        );
    }

    #[test]
    fn a_cycle_is_told_however_near_its_points_are_if_they_stay_apart() {
        // Rounding errors; what dies out slowly along a cycle or beside it; a cycle of a cycle.
        let mut seed = 2;
        for (split, left, factor) in [
            (3e-8, 0.0, 1.0),
            (1e-6, 1e-8, 0.9),
            (1e-2, 1e-5, 0.9995),
            (1.0, 1e-3, 0.99999),
            (1.0, 4e-9, -0.99),
        ] {
            for period in [2_usize, 3, 4, 6, 12] {
                let points: Vec<f64> = (0..200)
                    .map(|k| {
                        let place = k % period;
                        let apart =
                            split * (1.0 + place as f64) * f64::from(place.is_multiple_of(2));
                        let cycle = if period == 3 {
                            split * place as f64
                        } else {
                            apart
                        };
                        let noise = 1e-15 * random(&mut seed);
                        let shrunk = libm::pow(factor, f64::from(k as u32 / period as u32));
                        1.0 + cycle + left * shrunk + noise
                    })
                    .collect();
                assert_eq!(of(&points).0, Some(period), "{split} {left} {factor}");
            }
        }
    }

    #[test]
    fn a_cycle_settles_by_spirals_too() {
        // Near a third of a turn a cycle's period.
        for period in [2_usize, 5] {
            for (left, outcome) in [(1e-5, None), (1e-12, Some(period))] {
                let points: Vec<f64> = (0..200)
                    .flat_map(|k| {
                        let turns = f64::from(k as u32) / (3.0 * period as f64);
                        let angle = core::f64::consts::TAU * 1.000_01 * turns;
                        let size = left * libm::pow(0.9999, f64::from(k as u32));
                        let x = (k % period) as f64;
                        [
                            x + size * libm::cos(angle),
                            2.0 * x * x + size * libm::sin(angle),
                        ]
                    })
                    .collect();
                assert_eq!(
                    judged(&points, &PLANE),
                    (outcome, Evidence::None),
                    "{period}"
                );
            }
        }
    }

    #[test]
    fn what_settles_in_several_ways_is_no_chaos() {
        // Two spirals in coordinates of which each shows both.
        let mut seed = 3;
        for _ in 0..200 {
            let ways: [(f64, f64); 2] = core::array::from_fn(|_| {
                let factor = 1.0 - libm::pow(10.0, -3.5 + 2.0 * random(&mut seed));
                (factor, core::f64::consts::TAU * random(&mut seed))
            });
            let mixed: [f64; 16] = core::array::from_fn(|_| random(&mut seed) - 0.5);
            let points: Vec<f64> = (0..200_u32)
                .flat_map(|k| {
                    let k = f64::from(k);
                    let spirals = ways.map(|(factor, turn)| {
                        let size = libm::pow(factor, k);
                        [size * libm::cos(turn * k), size * libm::sin(turn * k)]
                    });
                    let [[a, b], [c, d]] = spirals;
                    let of = |row: &[f64]| row[0] * a + row[1] * b + row[2] * c + row[3] * d;
                    [0, 4, 8, 12].map(|row| of(&mixed[row..row + 4]))
                })
                .collect();
            let found = judged(&points, &[PLANE, PLANE].concat());
            assert_eq!(found, (None, Evidence::None), "{ways:?}");
        }
    }

    #[test]
    fn chaos_in_the_plane_is_told_in_whatever_coordinates() {
        // Henon 1976, and coordinates of which one is nearly the other.
        let (mut x, mut y) = (0.1, 0.1);
        let mut points = Vec::new();
        for k in 0..700 {
            (x, y) = (1.0 - 1.4 * x * x + y, 0.3 * x);
            if k >= 500 {
                points.extend([x, y]);
            }
        }
        assert_eq!(judged(&points, &PLANE), (None, Evidence::Chaotic));
        let tilted = points.chunks(2).flat_map(|p| [p[0], p[0] + 0.03 * p[1]]);
        let tilted: Vec<f64> = tilted.collect();
        assert_eq!(judged(&tilted, &PLANE), (None, Evidence::Chaotic));
    }

    #[test]
    fn rounding_errors_of_a_phase_far_from_zero_are_no_motion() {
        // Whole periods but for rounding, while a coordinate settles.
        let mut seed = 4;
        let points: Vec<f64> = (0..200_u32)
            .flat_map(|k| {
                let time = 0.3 * (30_000.0 + f64::from(k));
                let x = libm::pow(0.99, f64::from(k));
                [
                    x,
                    time * (1.0 + f64::EPSILON * (random(&mut seed) - 0.5).signum()),
                ]
            })
            .collect();
        let kinds = [CoordinateKind::Plain, CoordinateKind::Phase { period: 0.3 }];
        assert_eq!(judged(&points, &kinds), (None, Evidence::None));
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
        let mut ways = [way(3, 1.0); 12];
        for place in (0..12).step_by(2) {
            ways[place].impacts = 4;
        }
        let settled = |ways: &[Way]| {
            Settled {
                points: &points,
                kinds: &[CoordinateKind::Plain],
                sizes: &[0.5],
                ways,
            }
            .repetition(4, 1e-8)
            .period()
        };
        assert_eq!(settled(&ways), Some(2));
        // Of an infinite sequence the number of impacts is none.
        ways.iter_mut().for_each(|way| way.accumulations = 1);
        assert_eq!(settled(&ways), Some(1));
        // Nor is that of such sequences, where contacts chatter together; that there are any is.
        (ways.iter_mut().step_by(2)).for_each(|way| way.accumulations = 2);
        assert_eq!(settled(&ways), Some(1));
        (ways.iter_mut().step_by(2)).for_each(|way| way.accumulations = 0);
        assert_eq!(settled(&ways), Some(2));
        let mut times = [way(3, 1.0); 12];
        for place in (0..12).step_by(3) {
            times[place].time = 1.0 + 1e-6;
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
