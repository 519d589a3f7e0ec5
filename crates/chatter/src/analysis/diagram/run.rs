//! Workers that take the pieces of a sweep.

pub(super) mod executor;
pub(super) mod row;
pub(super) mod share;
pub(super) mod standing;

use self::executor::Executor;
use self::row::{Row, Started};
use self::share::Share;
use self::standing::{Begun, Carried, Standing};
use super::column::exponent::{Displaced, weigh};
use super::column::{Column, Need};
use super::spec::Exponent;
use super::spec::observable::Scratch;
use super::sweep::Sweep;
use crate::analysis::map::{Arrival, Carry, Command, Map, NoReturn, Origin, Start};
use crate::flow::FlowError;
use core::ops::ControlFlow;
use core::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

/// A worker follows up to so many orbits at once: enough to fill the lanes of every kind of step, few enough that their
/// states stay in the processor's cache.
const IN_FLIGHT: u64 = 256;

/// Rows in flight hold up to so many numbers together (half a gigabyte), or one row a worker where that is more.
const MEMORY: u64 = 1 << 26;

/// So many rows at least wait for their exponents together, if memory allows: orbits in as many lanes, of which few become idle.
const WAITING: u64 = 32;

/// So many random points are drawn for a start before it is given up: none in that many is admissible.
const DRAWS: u64 = 1000;

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
/// It ends early once `stop` is set, after the step that each worker is at, or `sink` breaks off, after the return. Rows that
/// are not done by then are lost.
pub fn run(
    map: &dyn Map,
    sweep: &Sweep,
    standing: &Standing,
    executor: &dyn Executor,
    stop: &AtomicBool,
    sink: &mut (dyn FnMut(Row) -> ControlFlow<()> + Send),
) -> Ending {
    run_share(map, sweep, Share::WHOLE, standing, executor, stop, sink)
}

/// Like [`run`], for the pieces of a share alone: the same rows to the bit.
pub fn run_share(
    map: &dyn Map,
    sweep: &Sweep,
    share: Share,
    standing: &Standing,
    executor: &dyn Executor,
    stop: &AtomicBool,
    sink: &mut (dyn FnMut(Row) -> ControlFlow<()> + Send),
) -> Ending {
    let supply = Supply {
        sweep,
        share,
        standing,
        next: AtomicU64::new(0),
    };
    let workers = executor.workers().max(1) as u64;
    let open = share.count(sweep.pieces()) - standing.finished(sweep, share);
    let row_numbers = sweep.spec().keep.saturating_mul(sweep.row_width());
    let weighs = sweep.spec().exponent == Exponent::Largest;
    let in_memory = MEMORY / workers / row_numbers.max(1) / if weighs { 2 } else { 1 };
    let in_memory = in_memory.clamp(1, IN_FLIGHT);
    let in_flight = open.div_ceil(workers).clamp(1, in_memory);
    let tangent = weighs.then(|| map.tangent(&sweep.swept)).flatten();
    let shared = Shared {
        map,
        tangent: tangent.as_deref(),
        sweep,
        supply: &supply,
        in_flight,
        together: match weighs {
            true => in_flight.max(WAITING).min(in_memory),
            false => 1,
        },
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

/// Hands out the pieces that are not done, each once.
struct Supply<'a> {
    sweep: &'a Sweep,
    share: Share,
    standing: &'a Standing,
    next: AtomicU64,
}

impl Supply<'_> {
    fn take(&self) -> Option<Piece> {
        loop {
            let index = self.next.fetch_add(1, Ordering::Relaxed);
            let piece = self.share.piece(index, self.sweep.pieces())?;
            let rows = self.sweep.piece_rows(piece);
            let Begun { done, latest } = self.standing.begun(piece);
            if done < rows {
                return Some(Piece {
                    piece,
                    rows,
                    done,
                    carried: latest,
                });
            }
        }
    }
}

struct Piece {
    piece: u64,
    rows: u64,
    done: u64,
    /// The row before.
    carried: Option<Carried>,
}

struct Shared<'a, 's> {
    map: &'a dyn Map,
    /// Carries displacements along, if exponents are asked for.
    tangent: Option<&'a dyn Map>,
    sweep: &'a Sweep,
    supply: &'a Supply<'a>,
    in_flight: u64,
    /// So many rows of a worker wait to be handed over together.
    together: u64,
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
    /// Rows that have all of their samples, and whence their exponents.
    waiting: Vec<(Row, Option<Displaced>)>,
}

impl<'a, 's> Worker<'a, 's> {
    fn new(shared: &'a Shared<'a, 's>) -> Self {
        Self {
            shared,
            slots: Vec::new(),
            scratch: Scratch::default(),
            waiting: Vec::new(),
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
        let stop = self.shared.stop;
        map.follow(swept, &starts, stop, &mut |arrival| self.visit(&arrival));
        self.hand_over();
    }

    /// Hands over the rows that wait, with their exponents.
    fn hand_over(&mut self) {
        let shared = self.shared;
        if let Some(tangent) = shared.tangent {
            weigh(tangent, shared.sweep, &mut self.waiting, shared.stop);
        }
        for (row, _) in self.waiting.drain(..) {
            // What was stopped on the way has no exponent yet.
            if shared.tangent.is_some() && shared.is_stopped() {
                continue;
            }
            shared.hand_over(row);
        }
    }

    /// The next row of a piece, and where its orbit starts.
    fn begin(&self, mut piece: Piece) -> (Slot, Start) {
        let sweep = self.shared.sweep;
        let row = sweep.row(piece.piece, piece.done);
        let carried = piece.carried.take();
        let carried = carried.filter(|carried| sweep.carries() && !carried.end.is_empty());
        let (started, point) = match carried {
            Some(carried) => {
                let point = self.shared.map.carried(&Carry {
                    origin: &carried.origin,
                    end: &carried.end,
                    before: &sweep.all_parameters(self.shared.map, carried.row),
                    after: &sweep.all_parameters(self.shared.map, row),
                });
                (Started::Carried, point)
            }
            None => self.first_point(row, 0),
        };
        let origin = match started {
            Started::Carried => Origin::Image(point.clone()),
            Started::Fresh | Started::Random => Origin::Point(point.clone()),
        };
        let slot = Slot {
            piece,
            column: Column::new(sweep, row, started, point),
            attempt: 0,
        };
        let swept = sweep.parameters(row);
        (slot, Start { swept, origin })
    }

    /// Where a row starts that is not carried.
    fn first_point(&self, row: u64, attempt: u64) -> (Started, Vec<f64>) {
        let Shared { map, sweep, .. } = self.shared;
        let initial = map.initial_point(&sweep.all_parameters(*map, row));
        let started = if sweep.draws() {
            Started::Random
        } else {
            Started::Fresh
        };
        (started, sweep.first_point(row, attempt, &initial))
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
            Need::Done(row, displaced) => self.done(arrival.orbit, *row, displaced),
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
        let (started, point) = self.first_point(row, attempt);
        let slot = &mut self.slots[orbit];
        slot.attempt = attempt;
        slot.column.restart(started, point.clone());
        Some(Start {
            swept: sweep.parameters(row),
            origin: Origin::Point(point),
        })
    }

    /// Takes in a row and begins the next, of this piece or of another.
    fn done(&mut self, orbit: usize, mut row: Row, displaced: Option<Displaced>) -> Command {
        let slot = &mut self.slots[orbit];
        let mut piece = Piece {
            done: slot.piece.done + 1,
            carried: None,
            ..slot.piece
        };
        let last = piece.done >= piece.rows;
        if last {
            row.end.clear();
        } else {
            piece.carried = Some(Carried::of(&row));
        }
        self.waiting.push((row, displaced));
        if self.waiting.len() as u64 >= self.shared.together {
            self.hand_over();
        }
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
