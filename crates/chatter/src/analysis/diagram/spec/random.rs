//! Numbers drawn at random, the same on every machine.

/// SplitMix64 (Steele, Lea & Flood 2014, Fast splittable pseudorandom number generators): one addition and a mixing
/// function, so any place of the sequence can be reached at once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Generator(u64);

const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

impl Generator {
    /// The generator of one row: rows of one seed do not share numbers.
    pub(crate) fn of_row(seed: u64, row: u64) -> Self {
        Self(mix(
            mix(seed.wrapping_add(GOLDEN)) ^ mix(row.wrapping_mul(GOLDEN).wrapping_add(1))
        ))
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(GOLDEN);
        mix(self.0)
    }

    /// A number in [from, to].
    pub(crate) fn between(&mut self, from: f64, to: f64) -> f64 {
        const UNIT: f64 = 1.0 / (1_u64 << 53) as f64;
        let share = (self.next() >> 11) as f64 * UNIT;
        (from + (to - from) * share).min(to)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sequence_is_the_published_one() {
        let mut generator = Generator(1_234_567);
        let first: Vec<u64> = (0..3).map(|_| generator.next()).collect();
        assert_eq!(
            first,
            [
                6_457_827_717_110_365_317,
                3_203_168_211_198_807_973,
                9_817_491_932_198_370_423
            ]
        );
    }

    #[test]
    fn rows_and_seeds_draw_evenly_and_apart() {
        let mut seen = std::collections::BTreeSet::new();
        let mut mean = 0.0;
        for seed in 0..10 {
            for row in 0..100 {
                let value = Generator::of_row(seed, row).between(-1.0, 3.0);
                assert!((-1.0..=3.0).contains(&value));
                assert!(seen.insert(value.to_bits()));
                mean += value / 1000.0;
            }
        }
        // The standard deviation of the mean is 4 / sqrt(12000).
        assert!((mean - 1.0).abs() < 4.0 * 0.0366, "{mean}");
    }
}
