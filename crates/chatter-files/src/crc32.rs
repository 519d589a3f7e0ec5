//! CRC-32 as in ZIP (ISO 3309), with the length of what was summed.

use crc32fast::Hasher;

/// A running checksum.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Crc32 {
    sum: u32,
    length: u64,
}

impl Crc32 {
    pub(crate) fn sum(self) -> u32 {
        self.sum
    }

    pub(crate) fn length(self) -> u64 {
        self.length
    }

    pub(crate) fn update(&mut self, bytes: &[u8]) {
        let mut hasher = self.hasher();
        hasher.update(bytes);
        self.sum = hasher.finalize();
        self.length += bytes.len() as u64;
    }

    /// The checksum of what `self` has seen followed by what `rest` has seen.
    pub(crate) fn then(self, rest: Crc32) -> Crc32 {
        let mut hasher = self.hasher();
        hasher.combine(&rest.hasher());
        Crc32 {
            sum: hasher.finalize(),
            length: self.length + rest.length,
        }
    }

    fn hasher(self) -> Hasher {
        Hasher::new_with_initial_len(self.sum, self.length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_and_concatenations_agree_with_the_whole() {
        let bytes: Vec<u8> = (0..1000u32).map(|k| ((k * k) >> 3) as u8).collect();
        for cut in [0, 1, 7, 8, 500, 999, 1000] {
            let (a, b) = bytes.split_at(cut);
            let mut piecewise = Crc32::default();
            piecewise.update(a);
            piecewise.update(b);
            let (mut first, mut second) = (Crc32::default(), Crc32::default());
            first.update(a);
            second.update(b);
            assert_eq!(piecewise.sum(), crc32fast::hash(&bytes));
            assert_eq!(first.then(second).sum(), crc32fast::hash(&bytes));
        }
    }
}
