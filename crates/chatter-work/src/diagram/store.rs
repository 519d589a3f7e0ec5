//! The journal of a diagram: its rows, in the order in which they were done.

use super::job::Header;
use super::source::{Rows, samples_of};
use crate::journals::of_this_version;
use crate::refusal::Refusal;
use chatter::analysis::diagram::{Collector, Outcome, Record, Row, Standing, Sweep};
use chatter::analysis::map::Map;
use chatter_files::journal::{self, Journal, JournalError, Place, Unread};
use std::collections::BTreeMap;
use std::path::Path;

/// More orbits than this, 8 bytes each for where they stand in the journal, are a slip of the keyboard.
const MOST_ROWS: u64 = 100_000_000;

/// More numbers than this, 80 gigabytes of them, fill the disk.
const MOST_NUMBERS: u64 = 10_000_000_000;

/// So many numbers are a gigabyte: more are not kept in memory.
const MOST_IN_MEMORY: u64 = 125_000_000;

/// Whether a diagram is small enough to be kept, on disk or in memory.
pub fn check_size(sweep: &Sweep, on_disk: bool) -> Result<(), Refusal> {
    if sweep.rows() > MOST_ROWS {
        return Err(Refusal::input(format!(
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
        return Err(Refusal::input(format!(
            "the diagram has {} orbits with {of_a_row} numbers each: expected {most} numbers {place} at most",
            sweep.rows()
        ))
        .help(help));
    }
    Ok(())
}

/// Most bytes of a row beside its samples and its points.
const ROW_ROOM: u64 = 1 << 20;

/// A journal that was begun before: what it is about is known, its rows are not. No other process can have it meanwhile.
pub struct Begun {
    unread: Unread,
    /// What it is about.
    pub header: Header,
}

/// The journal of a diagram that is to be computed.
pub enum Found {
    /// A new one.
    New(Store),
    /// One that was there.
    Old(Begun),
}

/// An open journal and where its rows stand in it. Memory holds 8 bytes a row.
pub struct Store {
    journal: Journal,
    sweep: Sweep,
    places: Vec<Option<Place>>,
    counts: BTreeMap<Outcome, u64>,
    /// Samples of all rows.
    samples: u64,
    /// Numbers of the rows' attractors, once they are told apart.
    attractors: Vec<u32>,
    bytes: Vec<u8>,
}

impl Begun {
    /// Opens a journal; `None` if there is none.
    pub fn open(path: &Path) -> Result<Option<Self>, Refusal> {
        let unread = Unread::open(path).map_err(Refusal::input)?;
        unread.map(Self::of).transpose()
    }

    fn of(unread: Unread) -> Result<Self, Refusal> {
        match serde_json::from_slice::<Header>(unread.header()) {
            Ok(header) if header.row_format != Row::FORMAT => Err(Refusal::input(format!(
                "`{}` was begun by another chatter, which wrote its rows in form {}; this one writes form {}",
                unread.path().display(),
                header.row_format,
                Row::FORMAT
            ))
            .help("delete it and compute the diagram anew, or go on with the chatter that began it")),
            Ok(header) => Ok(Self { unread, header }),
            Err(error) => Err(Refusal::input(format!(
                "`{}` is not a journal of an orbit diagram of this version of chatter: {error}",
                unread.path().display()
            ))),
        }
    }

    /// The file.
    pub fn path(&self) -> &Path {
        self.unread.path()
    }

    /// Whether this version wrote it: another's rows may differ in their last digits.
    ///
    /// # Errors
    /// Another did.
    pub fn of_this_version(&self) -> Result<(), Refusal> {
        of_this_version(self.path(), &self.header.job.version)
    }

    /// Notes the rows that are there. The points of the map have so many coordinates.
    pub fn read(self, sweep: &Sweep, coordinates: usize) -> Result<(Store, Standing), Refusal> {
        let spec = sweep.spec();
        // A sample may be kept as what is observed and, to compare orbits, as a whole point.
        let numbers = (spec.keep)
            .saturating_add(2)
            .saturating_mul((spec.observe.len() + coordinates) as u64);
        let longest = numbers.saturating_mul(8).saturating_add(ROW_ROOM);
        let mut standing = Standing::default();
        let mut places = vec![None; sweep.rows() as usize];
        let mut counts = BTreeMap::new();
        let mut samples = 0;
        let read = self.unread.read(longest, |place, bytes| {
            // Rows that another program wrote are made again.
            if let Ok(row) = Row::from_bytes(bytes)
                && fits(&row, sweep, coordinates)
                && standing.note(sweep, &row)
            {
                places[row.row as usize] = Some(place);
                *counts.entry(row.outcome).or_default() += 1;
                samples += samples_of(sweep, &row);
            }
        });
        let mut store = Store::new(read.map_err(Refusal::input)?, sweep);
        (store.places, store.counts, store.samples) = (places, counts, samples);
        Ok((store, standing))
    }
}

/// Whether a row has as many numbers as one of this diagram can have.
fn fits(row: &Row, sweep: &Sweep, coordinates: usize) -> bool {
    let spec = sweep.spec();
    let samples = match spec.record {
        Record::Samples => {
            let observed = spec.observe.len();
            row.samples.len().is_multiple_of(observed)
                && (row.samples.len() / observed) as u64 <= spec.keep
        }
        Record::Classes => row.samples.is_empty(),
    };
    let is_point = |point: &[f64]| point.is_empty() || point.len() == coordinates;
    samples
        && is_point(&row.end)
        && is_point(&row.origin)
        && row.orbit.len().is_multiple_of(coordinates.max(1))
}

impl Store {
    /// The journal of a diagram: the one that is there, or a new one.
    pub fn find(path: &Path, header: &Header, sweep: &Sweep) -> Result<Found, Refusal> {
        let bytes =
            serde_json::to_vec(header).map_err(|error| Refusal::input(error.to_string()))?;
        match Journal::find(path, &bytes) {
            Ok(journal::Found::New(journal)) => Ok(Found::New(Self::new(journal, sweep))),
            Ok(journal::Found::Old(unread)) => Begun::of(unread).map(Found::Old),
            Err(error @ JournalError::File(_)) => Err(output(error)),
            Err(error) => Err(Refusal::input(error)),
        }
    }

    /// Rows that are kept as long as the process lasts, on the disk of `folder`.
    pub fn scratch(folder: &Path, sweep: &Sweep) -> Result<Self, Refusal> {
        let journal = Journal::nameless(folder).map_err(output)?;
        Ok(Self::new(journal, sweep))
    }

    fn new(journal: Journal, sweep: &Sweep) -> Self {
        Self {
            journal,
            places: vec![None; sweep.rows() as usize],
            sweep: sweep.clone(),
            counts: BTreeMap::new(),
            samples: 0,
            attractors: Vec::new(),
            bytes: Vec::new(),
        }
    }

    /// Keeps a row.
    pub fn append(&mut self, row: &Row) -> Result<(), JournalError> {
        let place = self.journal.append(&row.to_bytes())?;
        self.places[row.row as usize] = Some(place);
        *self.counts.entry(row.outcome).or_default() += 1;
        self.samples += samples_of(&self.sweep, row);
        Ok(())
    }

    /// How many rows settled to what.
    pub fn counts(&self) -> &BTreeMap<Outcome, u64> {
        &self.counts
    }

    /// Tells the attractors of all rows apart.
    pub fn compare(&mut self, map: &dyn Map) -> Result<(), Refusal> {
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
    pub fn remove(self) -> Result<(), Refusal> {
        self.journal.remove().map_err(output)
    }
}

impl Rows for Store {
    fn sweep(&self) -> &Sweep {
        &self.sweep
    }

    fn row(&mut self, row: u64) -> Result<Row, Refusal> {
        let missing = || Refusal::Output(format!("row {row} of the diagram is missing"));
        let place = self.places[row as usize].ok_or_else(missing)?;
        self.journal.read(place, &mut self.bytes).map_err(output)?;
        Row::from_bytes(&self.bytes).map_err(|error| Refusal::Output(error.to_string()))
    }

    fn sample_count(&self) -> u64 {
        self.samples
    }

    fn attractor(&self, row: u64) -> u32 {
        self.attractors.get(row as usize).copied().unwrap_or(0)
    }
}

fn output(error: JournalError) -> Refusal {
    Refusal::Output(error.to_string())
}
