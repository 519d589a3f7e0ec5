//! The first and the last of a list, however long it is.

use std::collections::VecDeque;

/// The first and the last items, so many of each, and how many there are in all.
pub struct Ends<T> {
    most: usize,
    first: Vec<T>,
    last: VecDeque<T>,
    count: u64,
}

impl<T> Ends<T> {
    /// An empty list of which so many items are kept at either end.
    pub fn new(most: usize) -> Self {
        Self {
            most,
            first: Vec::new(),
            last: VecDeque::new(),
            count: 0,
        }
    }

    /// How many items were appended.
    pub fn len(&self) -> u64 {
        self.count
    }

    /// Appends an item.
    pub fn push(&mut self, item: T) {
        self.count += 1;
        if self.first.len() < self.most {
            self.first.push(item);
            return;
        }
        if self.last.len() == self.most {
            self.last.pop_front();
        }
        self.last.push_back(item);
    }

    /// Appends what is known of another list that keeps as many items.
    pub fn append(&mut self, other: Self) {
        let left_out = other.left_out();
        other.first.into_iter().for_each(|item| self.push(item));
        self.count += left_out;
        other.last.into_iter().for_each(|item| self.push(item));
    }

    /// How many items between the first and the last are not kept.
    pub fn left_out(&self) -> u64 {
        self.count - (self.first.len() + self.last.len()) as u64
    }

    /// The items kept at the beginning, and those at the end.
    pub fn parts(&self) -> (&[T], impl Iterator<Item = &T>) {
        (&self.first, self.last.iter())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parts(ends: &Ends<u32>) -> (Vec<u32>, u64, Vec<u32>) {
        let (first, last) = ends.parts();
        (first.to_vec(), ends.left_out(), last.copied().collect())
    }

    #[test]
    fn lists_in_pieces_are_the_whole_list() {
        for (total, most) in [(0, 3), (3, 3), (5, 3), (6, 3), (7, 3), (50, 3), (50, 20)] {
            let mut whole = Ends::new(most);
            (0..total).for_each(|k| whole.push(k));
            for piece in [1, 2, 5, 6, 7, 23, 60] {
                let mut joined = Ends::new(most);
                let numbers: Vec<u32> = (0..total).collect();
                for numbers in numbers.chunks(piece) {
                    let mut ends = Ends::new(most);
                    numbers.iter().for_each(|&k| ends.push(k));
                    joined.append(ends);
                }
                assert_eq!(parts(&joined), parts(&whole), "{total} {most} {piece}");
                assert_eq!(joined.len(), u64::from(total));
            }
        }
        let mut ends = Ends::new(2);
        (0..9).for_each(|k| ends.push(k));
        assert_eq!(parts(&ends), (vec![0, 1], 5, vec![7, 8]));
    }
}
