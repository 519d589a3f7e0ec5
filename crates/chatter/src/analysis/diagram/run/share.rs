//! A part of a sweep, for one of several machines.

use core::fmt;
use serde::{Deserialize, Serialize};

/// Every so many of the pieces of a sweep: neighbours cost alike, and so do shares that take one in turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Share {
    /// Which of the shares, from 1.
    number: u64,
    /// How many there are.
    of: u64,
}

impl Share {
    /// The only one.
    pub const WHOLE: Self = Self { number: 1, of: 1 };

    /// The share of this number, from 1, of so many; none if there is no such share.
    pub fn new(number: u64, of: u64) -> Option<Self> {
        (1..=of).contains(&number).then_some(Self { number, of })
    }

    /// Which it is, from 1.
    pub fn number(self) -> u64 {
        self.number
    }

    /// Of how many.
    pub fn of(self) -> u64 {
        self.of
    }

    /// The pieces that are in it, of so many.
    pub fn pieces(self, count: u64) -> impl Iterator<Item = u64> {
        let step = usize::try_from(self.of).unwrap_or(usize::MAX);
        (self.number - 1..count).step_by(step)
    }

    /// How many of so many pieces are in it.
    pub fn count(self, count: u64) -> u64 {
        (count + self.of - self.number) / self.of
    }

    /// Its `index`-th piece, if all pieces are so many.
    pub(in crate::analysis::diagram) fn piece(self, index: u64, count: u64) -> Option<u64> {
        let piece = index
            .checked_mul(self.of)
            .and_then(|piece| piece.checked_add(self.number - 1));
        piece.filter(|&piece| piece < count)
    }
}

impl fmt::Display for Share {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{} of {}", self.number, self.of)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_piece_is_in_one_share() {
        for of in [1, 2, 5, 32] {
            for count in [0, 1, 7, 32, 100] {
                let mut found = vec![0; count as usize];
                for number in 1..=of {
                    let share = Share::new(number, of).unwrap();
                    let pieces: Vec<u64> = share.pieces(count).collect();
                    assert_eq!(pieces.len() as u64, share.count(count));
                    for (index, &piece) in (0..).zip(&pieces) {
                        assert_eq!(share.piece(index, count), Some(piece));
                        found[piece as usize] += 1;
                    }
                    assert_eq!(share.piece(pieces.len() as u64, count), None);
                }
                assert!(found.iter().all(|&times| times == 1), "{of} {count}");
            }
        }
        assert!(
            Share::new(0, 3).is_none() && Share::new(4, 3).is_none() && Share::new(1, 0).is_none()
        );
        assert_eq!(Share::new(u64::MAX, u64::MAX).unwrap().piece(2, 9), None);
    }
}
