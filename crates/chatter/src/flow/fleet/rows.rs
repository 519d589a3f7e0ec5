//! What a step in lanes needs of each trajectory and changes of it, as a row of numbers.
//!
//! A trajectory that makes one ordinary step after another lives in its row, and its own fields wait: they are brought up to date
//! when something else happens to it, which the mode machine sees to. So a step in lanes moves numbers between rows and lanes and
//! touches hardly anything else of a trajectory. Where one step is followed by another of the same kind the row waits, too
//! ([`cohort`](super::cohort)).

use super::cohort::Members;
use super::shared::Shared;
use crate::flow::step::ORDER_CLASSES;
use crate::flow::trajectory::{Caught, Trajectory};
use crate::numerics::{LaneSet, Wide};
use core::ops::Range;

/// So many rows are read side by side, and so many numbers of each at once.
const ABREAST: usize = 4;

/// Where the numbers of a row stand.
#[derive(Clone, Copy, Debug)]
pub(super) struct Places {
    dimension: usize,
    sections: usize,
}

impl Places {
    pub fn state(self) -> Range<usize> {
        0..self.dimension
    }

    pub fn low(self) -> Range<usize> {
        self.dimension..2 * self.dimension
    }

    pub fn sides(self) -> Range<usize> {
        self.low().end..self.low().end + self.sections
    }

    pub fn reach(self) -> Range<usize> {
        self.sides().end..self.sides().end + ORDER_CLASSES
    }

    /// The numbers of a flight, of which a step changes these; …
    pub fn time(self) -> usize {
        self.reach().end
    }

    pub fn time_low(self) -> usize {
        self.time() + 1
    }

    pub fn flight_time(self) -> usize {
        self.time() + 2
    }

    pub fn longest_step(self) -> usize {
        self.time() + 3
    }

    /// The unit of time of the next step.
    pub fn unit(self) -> usize {
        self.time() + 4
    }

    /// All that a step changes comes first.
    pub fn changed(self) -> usize {
        (self.time() + 5).next_multiple_of(ABREAST)
    }

    /// … and not these.
    pub fn horizon(self) -> usize {
        self.changed()
    }

    pub fn horizon_low(self) -> usize {
        self.horizon() + 1
    }

    pub fn restitution(self) -> usize {
        self.horizon() + 2
    }

    pub fn border(self) -> usize {
        self.horizon() + 3
    }

    /// Constants that differ between trajectories come last.
    pub fn constants(self) -> usize {
        self.horizon() + 4
    }
}

/// What a trajectory has done in its row that its own fields do not know of.
#[derive(Clone, Copy, Debug, Default)]
struct Ahead {
    has_moved: bool,
    has_bounced: bool,
    /// The guard that ended the latest step.
    ended_at: Option<u16>,
}

/// The rows of a fleet.
#[derive(Debug)]
pub(super) struct Rows {
    pub places: Places,
    /// Numbers from one row to the next.
    stride: usize,
    values: Vec<f64>,
    ahead: Vec<Ahead>,
}

impl Rows {
    /// Rows for so many trajectories.
    pub fn new((dimension, sections): (usize, usize), trajectories: usize) -> Self {
        let places = Places {
            dimension,
            sections,
        };
        let stride = places.constants().next_multiple_of(ABREAST);
        Self {
            places,
            stride,
            values: vec![0.0; stride * trajectories],
            ahead: vec![Ahead::default(); trajectories],
        }
    }

    /// Numbers in a row.
    pub fn width(&self) -> usize {
        self.stride
    }

    /// Makes room for a mode in which so many constants differ.
    pub fn widen(&mut self, count: usize) {
        let stride = (self.places.constants() + count).next_multiple_of(ABREAST);
        if stride <= self.stride {
            return;
        }
        let mut values = vec![0.0; stride * self.ahead.len()];
        for (new, old) in values
            .chunks_exact_mut(stride)
            .zip(self.values.chunks_exact(self.stride))
        {
            new[..self.stride].copy_from_slice(old);
        }
        (self.stride, self.values) = (stride, values);
    }

    /// Copies a trajectory, whose next step has this unit of time, into its row.
    pub fn fill<W: Wide>(
        &mut self,
        (index, trajectory, unit): (usize, &Trajectory<f64>, f64),
        shared: &Shared<W>,
    ) {
        let places = self.places;
        let row = &mut self.values[index * self.stride..][..self.stride];
        row[places.state()].copy_from_slice(&trajectory.state);
        row[places.low()].copy_from_slice(&trajectory.low);
        for (section, side) in row[places.sides()].iter_mut().enumerate() {
            *side = trajectory.sides.get(section);
        }
        row[places.reach()].copy_from_slice(&trajectory.reach);
        let flight = trajectory.flight();
        row[places.time()] = flight.time;
        row[places.time_low()] = flight.time_low;
        row[places.flight_time()] = flight.flight_time;
        row[places.longest_step()] = flight.longest_step;
        row[places.unit()] = unit;
        row[places.horizon()] = flight.horizon;
        row[places.horizon_low()] = flight.horizon_low;
        row[places.restitution()] = flight.restitution;
        row[places.border()] = flight.border;
        if let Some(own) = &trajectory.constants[trajectory.mode] {
            let tape = shared.varying_tape.iter().map(|&place| own.tape[place]);
            let impacts = own.impacts.iter().zip(&shared.varying_impacts);
            let impacts = impacts.flat_map(|(own, places)| places.iter().map(|&place| own[place]));
            for (value, constant) in (row[places.constants()..].iter_mut()).zip(tape.chain(impacts))
            {
                *value = constant;
            }
        }
        self.ahead[index] = Ahead::default();
    }

    /// Brings a trajectory up to date.
    #[inline]
    pub fn catch_up(&mut self, index: usize, trajectory: &mut Trajectory<f64>) {
        let ahead = core::mem::take(&mut self.ahead[index]);
        if !ahead.has_moved {
            return;
        }
        let places = self.places;
        let row = &self.values[index * self.stride..][..self.stride];
        trajectory.state.copy_from_slice(&row[places.state()]);
        trajectory.low.copy_from_slice(&row[places.low()]);
        for (section, &side) in row[places.sides()].iter().enumerate() {
            trajectory.sides.set(section, side);
        }
        trajectory.reach.copy_from_slice(&row[places.reach()]);
        trajectory.catch_up(&Caught {
            time: (row[places.time()], row[places.time_low()]),
            flight_time: row[places.flight_time()],
            longest_step: row[places.longest_step()],
            has_bounced: ahead.has_bounced,
            ended_at: ahead.ended_at.map(usize::from),
        });
    }

    /// Lays the rows of the newcomers among trajectories beside those of the others, each number of theirs a vector.
    ///
    /// Where neighbours are all new a few rows at a time: what is stored is then as wide as what is loaded from there.
    #[inline(always)]
    pub fn gather<W: Wide>(&self, members: &Members, newcomers: LaneSet, block: &mut [W]) {
        let row = |lane: usize| {
            let start = members[lane] * self.stride;
            &self.values[start..start + self.stride]
        };
        for first in (0..W::LANES).step_by(ABREAST) {
            let new = newcomers.among(first, ABREAST);
            if new.count() < ABREAST {
                for lane in new {
                    for (wide, &value) in block.iter_mut().zip(row(lane)) {
                        wide.lanes_mut()[lane] = value;
                    }
                }
                continue;
            }
            let rows: [&[f64]; ABREAST] =
                [row(first), row(first + 1), row(first + 2), row(first + 3)];
            let rows = rows.map(|row| row.as_chunks::<ABREAST>().0);
            let rows = (rows[0].iter().zip(rows[1])).zip(rows[2].iter().zip(rows[3]));
            let blocks = block.as_chunks_mut::<ABREAST>().0;
            for (wide, ((a, b), (c, d))) in blocks.iter_mut().zip(rows) {
                for (k, wide) in wide.iter_mut().enumerate() {
                    let place = &mut wide.lanes_mut()[first..first + ABREAST];
                    place.copy_from_slice(&[a[k], b[k], c[k], d[k]]);
                }
            }
        }
    }

    /// Takes over from rows that are side by side, in these lanes, what steps change.
    #[inline(always)]
    pub fn scatter<W: Wide>(&mut self, members: &Members, block: &[W], lanes: LaneSet) {
        let changed = self.places.changed();
        let blocks = block[..changed].as_chunks::<ABREAST>().0;
        for lane in lanes {
            let lane = lane.min(W::LANES - 1);
            let row = &mut self.values[members[lane] * self.stride..][..changed];
            for (values, wide) in row.as_chunks_mut::<ABREAST>().0.iter_mut().zip(blocks) {
                *values = [
                    wide[0].lanes()[lane],
                    wide[1].lanes()[lane],
                    wide[2].lanes()[lane],
                    wide[3].lanes()[lane],
                ];
            }
        }
    }

    /// Takes note of an ordinary step, which ended at this guard, or nowhere.
    #[inline(always)]
    pub fn note(&mut self, index: usize, ended_at: Option<usize>) {
        let ahead = &mut self.ahead[index];
        ahead.has_moved = true;
        ahead.has_bounced |= ended_at.is_some();
        ahead.ended_at = ended_at.map(|guard| guard as u16);
    }
}
