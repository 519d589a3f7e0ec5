//! Where orbits that were carried both ways are not the same.

use super::tally::Tally;
use chatter::analysis::diagram::{Start, Sweep};

/// Where orbits that were carried upwards and downwards are not the same.
pub struct Hysteresis {
    /// At how many values.
    pub values: u64,
    /// From which to which value of the first parameter, runs of neighbours in order.
    pub ranges: Vec<[f64; 2]>,
}

/// What the two ways differ in; none if the diagram was not carried both ways.
pub fn hysteresis(sweep: &Sweep, tally: &Tally) -> Option<Hysteresis> {
    if sweep.spec().start != Start::CarryBoth {
        return None;
    }
    let line = sweep.spec().sweeps[0].count;
    let mut found = Hysteresis {
        values: 0,
        ranges: Vec::new(),
    };
    let mut latest = None;
    for (group, pair) in (0..).zip(tally.numbers.chunks_exact(2)) {
        if pair[0] == pair[1] || pair.contains(&0) {
            continue;
        }
        found.values += 1;
        let value = sweep.values(2 * group)[0];
        match found.ranges.last_mut() {
            Some(range) if latest == Some(group - 1) && group % line != 0 => range[1] = value,
            _ => found.ranges.push([value; 2]),
        }
        latest = Some(group);
    }
    Some(found)
}
