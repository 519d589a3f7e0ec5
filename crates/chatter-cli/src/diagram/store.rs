//! The journal of a diagram: its rows, in the order in which they were done.

use super::job::Order;
use super::source::Rows;
use crate::failure::Failure;
use chatter::analysis::diagram::{Collector, Outcome, Record, Row, Standing, Sweep};
use chatter::analysis::map::Map;
use chatter_io::journal::{Journal, JournalError, Place};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The journal beside a file that is to be written.
pub fn journal_of(output: &Path) -> PathBuf {
    let mut name = output.file_name().unwrap_or_default().to_os_string();
    name.push(".journal");
    output.with_file_name(name)
}

/// More orbits than this, 16 bytes each for where they stand in the journal, are a slip of the keyboard.
const MOST_ROWS: u64 = 100_000_000;

/// More numbers than this, 80 gigabytes of them, fill the disk.
const MOST_NUMBERS: u64 = 10_000_000_000;

/// So many numbers are a gigabyte: more are not kept in memory.
const MOST_IN_MEMORY: u64 = 125_000_000;

/// Whether a diagram is small enough to be kept, on disk or in memory.
pub fn check_size(sweep: &Sweep, on_disk: bool) -> Result<(), Failure> {
    if sweep.rows() > MOST_ROWS {
        return Err(Failure::input(format!(
            "the diagram has {} orbits: expected {MOST_ROWS} at most",
            sweep.rows()
        ))
        .help("sweep parts of the range into files of their own"));
    }
    let spec = sweep.spec();
    let of_a_row = match spec.record {
        Record::Samples => spec.keep.saturating_mul(spec.observe.len() as u64),
        Record::Classes => 1,
    };
    let numbers = sweep.rows().saturating_mul(of_a_row);
    let (most, place, help) = if on_disk {
        let help = "keep fewer samples with --keep, or none with --record classes";
        (MOST_NUMBERS, "on disk", help)
    } else {
        let help = "write the diagram to a file too, with --out FILE.npz, and it is kept on disk";
        (MOST_IN_MEMORY, "in memory", help)
    };
    if numbers > most {
        return Err(Failure::input(format!(
            "the diagram has {} orbits with {of_a_row} numbers each: expected {most} numbers {place} at most",
            sweep.rows()
        ))
        .help(help));
    }
    Ok(())
}

/// An open journal and where its rows stand in it. Memory holds 16 bytes a row.
pub struct Store {
    journal: Journal,
    sweep: Sweep,
    places: Vec<Option<Place>>,
    counts: BTreeMap<Outcome, u64>,
    /// Numbers of the rows' attractors, once they are told apart.
    attractors: Vec<u32>,
    bytes: Vec<u8>,
}

impl Store {
    /// Starts a journal.
    pub fn create(path: &Path, order: &Order, sweep: &Sweep) -> Result<Self, Failure> {
        let header =
            serde_json::to_vec(order).map_err(|error| Failure::input(error.to_string()))?;
        let journal = Journal::create(path, &header).map_err(output)?;
        Ok(Self::new(journal, sweep))
    }

    fn new(journal: Journal, sweep: &Sweep) -> Self {
        Self {
            journal,
            places: vec![None; sweep.rows() as usize],
            sweep: sweep.clone(),
            counts: BTreeMap::new(),
            attractors: Vec::new(),
            bytes: Vec::new(),
        }
    }

    /// Opens a journal and reads what it is about; its rows only once the sweep is known.
    pub fn order_of(path: &Path) -> Result<Order, Failure> {
        let (_, header) = Journal::open(path, |_, _| {}).map_err(input)?;
        let order: Order = serde_json::from_slice(&header).map_err(|error| {
            Failure::input(format!(
                "`{}` is not a journal of an orbit diagram of this version of chatter: {error}",
                path.display()
            ))
        })?;
        if order.row_format != Row::FORMAT {
            return Err(Failure::input(format!(
                "`{}` was begun by another chatter, which wrote its rows in form {}; this one writes form {}",
                path.display(),
                order.row_format,
                Row::FORMAT
            ))
            .help("delete it and compute the diagram anew, or go on with the chatter that began it"));
        }
        Ok(order)
    }

    /// Opens a journal whose order is known, and notes the rows that are there.
    pub fn open(path: &Path, sweep: &Sweep) -> Result<(Self, Standing), Failure> {
        let mut standing = Standing::default();
        let mut places = vec![None; sweep.rows() as usize];
        let mut counts = BTreeMap::new();
        let (journal, _) = Journal::open(path, |place, bytes| {
            // Rows that another program wrote are made again.
            if let Ok(row) = Row::from_bytes(bytes)
                && standing.note(sweep, &row)
            {
                places[row.row as usize] = Some(place);
                *counts.entry(row.outcome).or_default() += 1;
            }
        })
        .map_err(input)?;
        let mut store = Self::new(journal, sweep);
        (store.places, store.counts) = (places, counts);
        Ok((store, standing))
    }

    /// Keeps a row.
    pub fn append(&mut self, row: &Row) -> Result<(), JournalError> {
        let place = self.journal.append(&row.to_bytes())?;
        self.places[row.row as usize] = Some(place);
        *self.counts.entry(row.outcome).or_default() += 1;
        Ok(())
    }

    /// How many rows settled to what.
    pub fn counts(&self) -> &BTreeMap<Outcome, u64> {
        &self.counts
    }

    /// Tells the attractors of all rows apart.
    pub fn compare(&mut self, map: &dyn Map) -> Result<(), Failure> {
        let sweep = self.sweep.clone();
        if !sweep.compares() {
            return Ok(());
        }
        let mut collector = Collector::new(map, &sweep);
        for row in 0..sweep.rows() {
            collector.note(&self.row(row)?);
        }
        self.attractors = collector.finish().numbers().to_vec();
        Ok(())
    }

    /// Deletes the journal.
    pub fn remove(self) -> Result<(), Failure> {
        self.journal.remove().map_err(output)
    }
}

impl Rows for Store {
    fn sweep(&self) -> &Sweep {
        &self.sweep
    }

    fn row(&mut self, row: u64) -> Result<Row, Failure> {
        let missing = || Failure::Output(format!("row {row} of the diagram is missing"));
        let place = self.places[row as usize].ok_or_else(missing)?;
        self.journal.read(place, &mut self.bytes).map_err(output)?;
        Row::from_bytes(&self.bytes).map_err(|error| Failure::Output(error.to_string()))
    }

    fn attractor(&self, row: u64) -> u32 {
        self.attractors.get(row as usize).copied().unwrap_or(0)
    }
}

fn input(error: JournalError) -> Failure {
    Failure::input(error)
}

fn output(error: JournalError) -> Failure {
    Failure::Output(error.to_string())
}
