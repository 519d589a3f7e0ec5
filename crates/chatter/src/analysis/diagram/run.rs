//! Workers that take the pieces of a sweep.

use super::column::{Column, Need};
use super::executor::Executor;
use super::observable::Scratch;
use super::row::{Row, Started};
use super::sweep::Sweep;
use crate::analysis::map::{Arrival, Command, Map, NoReturn, Origin, Start};
use crate::flow::FlowError;
use core::ops::ControlFlow;
use core::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

/// A worker follows up to so many orbits at once: enough to fill the lanes of every kind of step, few enough that their
/// states stay in the processor's cache.
const IN_FLIGHT: u64 = 256;

/// All orbits that are followed at once hold no more numbers than this, 256 MiB, unless a few do so alone.
const MOST_HELD: u64 = 1 << 25;

/// Numbers that an orbit holds in the end: its samples, and for each of them impacts, time and chatter.
fn held_by(sweep: &Sweep) -> u64 {
    let a_sample = sweep.spec().observe.len() as u64 + 3;
    sweep.spec().keep.saturating_mul(a_sample).max(1)
}

/// So many random points are drawn for a start before it is given up: none in that many is admissible.
const DRAWS: u64 = 1000;

/// Which rows are there already, from a run that was broken off.
#[derive(Clone, Debug, Default)]
pub struct Standing {
    /// For each piece that has been begun: how many of its rows are done, and the last point of the latest.
    begun: BTreeMap<u64, (u64, Vec<f64>)>,
    rows: u64,
}

impl Standing {
    /// Notes a row that is there. Those of a piece come in the order in which they were computed; a row that does not
    /// belong to the sweep, or is out of order, is not noted, and will be computed again.
    pub fn note(&mut self, sweep: &Sweep, row: &Row) -> bool {
        if row.row >= sweep.rows() {
            return false;
        }
        let piece = sweep.piece_of(row.row);
        let begun = self.begun.entry(piece).or_default();
        if begun.0 >= sweep.piece_rows(piece) || row.row != sweep.row(piece, begun.0) {
            return false;
        }
        begun.0 += 1;
        self.rows += 1;
        begun.1 = if begun.0 < sweep.piece_rows(piece) {
            row.end.clone()
        } else {
            Vec::new()
        };
        true
    }

    /// How many rows are there.
    pub fn rows(&self) -> u64 {
        self.rows
    }
}

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// Every row is there.
    Complete,
    /// It was broken off.
    Stopped,
}

/// Computes the rows of a diagram that are not there yet, and hands each to `sink` as soon as it is done, in any order.
/// Rows of one piece come in the order of the piece.
///
/// It ends early once `stop` is set or `sink` breaks off: within milliseconds, unless a single return takes longer. Rows
/// that are not done by then are lost.
pub fn run(
    map: &dyn Map,
    sweep: &Sweep,
    standing: &Standing,
    executor: &dyn Executor,
    stop: &AtomicBool,
    sink: &mut (dyn FnMut(Row) -> ControlFlow<()> + Send),
) -> Ending {
    let supply = Supply {
        sweep,
        standing,
        next: AtomicU64::new(0),
    };
    let workers = executor.workers().max(1) as u64;
    let open = sweep.pieces() - standing.finished(sweep);
    let shared = Shared {
        map,
        sweep,
        supply: &supply,
        in_flight: (open.div_ceil(workers))
            .min(MOST_HELD / held_by(sweep) / workers)
            .clamp(1, IN_FLIGHT),
        stop,
        broken_off: AtomicBool::new(false),
        sink: Mutex::new(sink),
    };
    executor.run(&|| Worker::new(&shared).work());
    if shared.is_stopped() {
        Ending::Stopped
    } else {
        Ending::Complete
    }
}

impl Standing {
    fn finished(&self, sweep: &Sweep) -> u64 {
        let finished = self
            .begun
            .iter()
            .filter(|(piece, begun)| begun.0 >= sweep.piece_rows(**piece));
        finished.count() as u64
    }
}

/// Hands out the pieces that are not done, each once.
struct Supply<'a> {
    sweep: &'a Sweep,
    standing: &'a Standing,
    next: AtomicU64,
}

impl Supply<'_> {
    fn take(&self) -> Option<Piece> {
        loop {
            let piece = self.next.fetch_add(1, Ordering::Relaxed);
            if piece >= self.sweep.pieces() {
                return None;
            }
            let rows = self.sweep.piece_rows(piece);
            let begun = self.standing.begun.get(&piece);
            let (done, carried) = begun.cloned().unwrap_or_default();
            if done < rows {
                return Some(Piece {
                    piece,
                    rows,
                    done,
                    carried,
                });
            }
        }
    }
}

struct Piece {
    piece: u64,
    rows: u64,
    done: u64,
    /// The last point of the row before; empty where it cannot be gone on from.
    carried: Vec<f64>,
}

struct Shared<'a, 's> {
    map: &'a dyn Map,
    sweep: &'a Sweep,
    supply: &'a Supply<'a>,
    in_flight: u64,
    stop: &'a AtomicBool,
    broken_off: AtomicBool,
    sink: Mutex<&'s mut (dyn FnMut(Row) -> ControlFlow<()> + Send)>,
}

impl Shared<'_, '_> {
    fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed) || self.broken_off.load(Ordering::Relaxed)
    }

    fn hand_over(&self, row: Row) {
        let mut sink = self.sink.lock().unwrap_or_else(PoisonError::into_inner);
        if !self.broken_off.load(Ordering::Relaxed) && sink(row).is_break() {
            self.broken_off.store(true, Ordering::Relaxed);
        }
    }
}

/// One orbit's place: the piece it works on and the row it is at.
struct Slot {
    piece: Piece,
    column: Column,
    attempt: u64,
}

struct Worker<'a, 's> {
    shared: &'a Shared<'a, 's>,
    slots: Vec<Slot>,
    scratch: Scratch,
}

impl<'a, 's> Worker<'a, 's> {
    fn new(shared: &'a Shared<'a, 's>) -> Self {
        Self {
            shared,
            slots: Vec::new(),
            scratch: Scratch::default(),
        }
    }

    fn work(mut self) {
        let mut starts = Vec::new();
        while (starts.len() as u64) < self.shared.in_flight {
            let Some(piece) = self.shared.supply.take() else {
                break;
            };
            let (slot, start) = self.begin(piece);
            self.slots.push(slot);
            starts.push(start);
        }
        let map = self.shared.map;
        let swept = &self.shared.sweep.swept;
        map.follow(swept, &starts, &mut |arrival| self.visit(&arrival));
    }

    /// The next row of a piece, and where its orbit starts.
    fn begin(&self, mut piece: Piece) -> (Slot, Start) {
        let sweep = self.shared.sweep;
        let row = sweep.row(piece.piece, piece.done);
        let swept = sweep.values(row);
        let carried = core::mem::take(&mut piece.carried);
        let (started, origin) = if carried.is_empty() {
            self.first_origin(row, 0, &swept)
        } else {
            (Started::Carried, Origin::Image(carried))
        };
        let slot = Slot {
            piece,
            column: Column::new(sweep, row, started),
            attempt: 0,
        };
        (slot, Start { swept, origin })
    }

    fn first_origin(&self, row: u64, attempt: u64, swept: &[f64]) -> (Started, Origin) {
        let map = self.shared.map;
        let overrides: Vec<(usize, f64)> = self
            .shared
            .sweep
            .swept
            .iter()
            .copied()
            .zip(swept.iter().copied())
            .collect();
        if !self.shared.sweep.draws() {
            return (Started::Fresh, Origin::Initial);
        }
        let initial = map.initial_point(&map.parameter_values(&overrides));
        match self.shared.sweep.draw(row, attempt, &initial) {
            Some(point) => (Started::Random, Origin::Point(point)),
            None => (Started::Fresh, Origin::Initial),
        }
    }

    fn visit(&mut self, arrival: &Arrival<'_>) -> Command {
        if self.shared.is_stopped() {
            return Command::Retire;
        }
        let sweep = self.shared.sweep;
        if let Err(reason) = &arrival.passage
            && let Some(start) = self.start_otherwise(arrival.orbit, reason)
        {
            return Command::Restart(start);
        }
        let slot = &mut self.slots[arrival.orbit];
        let need = slot
            .column
            .arrive(self.shared.map, sweep, arrival, &mut self.scratch);
        match need {
            Need::Next => Command::Continue,
            Need::Companion(origin) => Command::Restart(Start {
                swept: sweep.values(slot.column.row),
                origin,
            }),
            Need::Done(row) => self.done(arrival.orbit, row),
        }
    }

    /// Another start for an orbit that could not start at all.
    fn start_otherwise(&mut self, orbit: usize, reason: &NoReturn) -> Option<Start> {
        let sweep = self.shared.sweep;
        let slot = &self.slots[orbit];
        let (row, start) = (slot.column.row, slot.column.start);
        let inadmissible = matches!(reason, NoReturn::Failed(FlowError::Penetrates { .. }));
        if !inadmissible || slot.column.has_begun(sweep) {
            return None;
        }
        let attempt = slot.attempt + 1;
        if start == Started::Fresh || attempt >= DRAWS {
            return None;
        }
        let swept = sweep.values(row);
        let (started, origin) = self.first_origin(row, attempt, &swept);
        let slot = &mut self.slots[orbit];
        slot.attempt = attempt;
        slot.column.start = started;
        Some(Start { swept, origin })
    }

    /// Hands over a row and begins the next, of this piece or of another.
    fn done(&mut self, orbit: usize, mut row: Row) -> Command {
        let slot = &mut self.slots[orbit];
        let mut piece = Piece {
            done: slot.piece.done + 1,
            carried: Vec::new(),
            ..slot.piece
        };
        let last = piece.done >= piece.rows;
        if last {
            row.end.clear();
        } else {
            piece.carried.clone_from(&row.end);
        }
        self.shared.hand_over(row);
        if last {
            match self.shared.supply.take() {
                Some(next) => piece = next,
                None => return Command::Retire,
            }
        }
        let (slot, start) = self.begin(piece);
        self.slots[orbit] = slot;
        Command::Restart(start)
    }
}
