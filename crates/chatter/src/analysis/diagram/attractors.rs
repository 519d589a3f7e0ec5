//! Which rows settled to the same orbit: attractors that coexist, told apart and numbered.

use super::column::same_orbit::{Cycle, Units};
use super::run::row::Row;
use super::sweep::Sweep;
use crate::analysis::map::{CoordinateKind, Map};
use std::collections::BTreeMap;

/// More orbits than this at the same parameters are not attractors: there are as many as starts.
const MOST: usize = 100;

/// Attractors keep their numbers from value to value where there are up to so many pairs of them.
const MOST_PAIRS: usize = 400;

/// The attractors of a diagram.
///
/// At each value of the parameters those that were found have numbers from 1. A number goes on from value to value on the
/// nearest orbit; where there is none to go on from, the attractor of most rows has the first number.
#[derive(Clone, Debug, PartialEq)]
pub struct Attractors {
    numbers: Vec<u32>,
    coexisting: Vec<u64>,
}

impl Attractors {
    /// The number of each row's attractor; zero where it settled to none.
    pub fn numbers(&self) -> &[u32] {
        &self.numbers
    }

    /// At which values of the parameters several attractors were found: their [groups](Sweep::group), in order.
    pub fn coexisting(&self) -> &[u64] {
        &self.coexisting
    }
}

/// Takes in the rows of a diagram, in order.
pub struct Collector<'a> {
    map: &'a dyn Map,
    sweep: &'a Sweep,
    /// Number of the orbit within its group, by row.
    local: Vec<u32>,
    open: BTreeMap<u64, Group>,
    /// Groups that others go on from.
    closed: BTreeMap<u64, Vec<Found>>,
    /// What the orbits of each group are called in the end.
    names: BTreeMap<u64, Vec<u32>>,
    /// The latest group of which there was a row.
    latest: Option<u64>,
}

/// The orbits at the same parameters.
struct Group {
    coordinates: Vec<CoordinateKind>,
    found: Vec<Found>,
}

/// An orbit, its number in the end (zero until it has one), how many rows settled there, and the first of them.
#[derive(Clone)]
struct Found {
    cycle: Cycle,
    number: u32,
    rows: u64,
    first: u64,
}

impl<'a> Collector<'a> {
    /// For the rows of a sweep of a map.
    pub fn new(map: &'a dyn Map, sweep: &'a Sweep) -> Self {
        Self {
            map,
            sweep,
            local: Vec::new(),
            open: BTreeMap::new(),
            closed: BTreeMap::new(),
            names: BTreeMap::new(),
            latest: None,
        }
    }

    /// Takes in the next row.
    pub fn note(&mut self, row: &Row) {
        let group = self.sweep.group(row.row);
        // Where its rows stand together, a group is done once the next begins.
        if let Some(before) = self.latest.filter(|&before| before != group)
            && self.sweep.groups_stand_together()
        {
            self.close(before);
        }
        self.latest = Some(group);
        let local = self.find(group, row);
        self.local.push(local);
    }

    /// The number of a row's orbit within its group, from 1.
    fn find(&mut self, group: u64, row: &Row) -> u32 {
        let (map, sweep) = (self.map, self.sweep);
        let group = self.open.entry(group).or_insert_with(|| Group {
            coordinates: map.coordinate_kinds(&sweep.all_parameters(map, row.row)),
            found: Vec::new(),
        });
        if row.orbit.is_empty() {
            return 0;
        }
        let cycle = Cycle {
            period: row.period,
            points: row.orbit.clone(),
            sizes: row.sizes.clone(),
        };
        let tolerance = sweep.spec().period_tolerance;
        let mut known = group.found.iter_mut().zip(1..);
        if let Some((same, number)) =
            known.find(|(known, _)| known.cycle.is(&cycle, &group.coordinates, tolerance))
        {
            same.rows += 1;
            return number;
        }
        if group.found.len() >= MOST {
            return 0;
        }
        group.found.push(Found {
            cycle,
            number: 0,
            rows: 1,
            first: row.row,
        });
        group.found.len() as u32
    }

    /// Gives the orbits of a group their numbers.
    fn close(&mut self, number: u64) {
        let Some(mut group) = self.open.remove(&number) else {
            return;
        };
        let before = self.sweep.group_before(number);
        let known = before.and_then(|before| self.closed.get(&before).cloned());
        go_on(&mut group, known.as_deref().unwrap_or_default());
        // Those without a predecessor: the most frequent first.
        let mut fresh: Vec<usize> = (0..group.found.len()).collect();
        fresh.retain(|&index| group.found[index].number == 0);
        fresh.sort_by_key(|&index| {
            let found = &group.found[index];
            (core::cmp::Reverse(found.rows), found.first)
        });
        for index in fresh {
            let taken = |number: &u32| group.found.iter().any(|found| found.number == *number);
            let free = (1..).find(|number| !taken(number));
            group.found[index].number = free.unwrap_or(u32::MAX);
        }
        let names = group.found.iter().map(|found| found.number).collect();
        self.names.insert(number, names);
        // Those that were not found here may be found again.
        let lost: Vec<Found> = (known.unwrap_or_default().into_iter())
            .filter(|known| (group.found.iter()).all(|found| found.number != known.number))
            .collect();
        group.found.extend(lost);
        self.closed.insert(number, group.found);
        let needed = self.sweep.groups_needed_after(number);
        self.closed.retain(|group, _| needed.contains(group));
    }

    /// What the rows come to.
    pub fn finish(mut self) -> Attractors {
        let open: Vec<u64> = self.open.keys().copied().collect();
        for group in open {
            self.close(group);
        }
        let number = |(row, &local): (u64, &u32)| match local {
            0 => 0,
            local => {
                let names = self.names.get(&self.sweep.group(row));
                names.map_or(0, |names| names[local as usize - 1])
            }
        };
        let numbers = (0..).zip(&self.local).map(number).collect();
        let several = |(&group, names): (&u64, &Vec<u32>)| (names.len() > 1).then_some(group);
        Attractors {
            numbers,
            coexisting: self.names.iter().filter_map(several).collect(),
        }
    }
}

/// Numbers orbits after the nearest known ones, the nearest pairs first.
fn go_on(group: &mut Group, known: &[Found]) {
    if known.len() * group.found.len() > MOST_PAIRS {
        return;
    }
    let cycles = group.found.iter().chain(known).map(|found| &found.cycle);
    let units = Units::of(cycles, &group.coordinates);
    let mut pairs = Vec::new();
    for (index, found) in group.found.iter().enumerate() {
        for known in known {
            let distance = found.cycle.distance(&known.cycle, &units);
            pairs.push((distance, index, known.number));
        }
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (_, index, number) in pairs {
        let taken = group.found.iter().any(|found| found.number == number);
        if !taken && group.found[index].number == 0 {
            group.found[index].number = number;
        }
    }
}
