//! The journal of branches that are being found: how far they have come.

use super::job::Job;
use crate::journals::of_this_version;
use crate::observer::Observer;
use crate::refusal::Refusal;
use chatter::analysis::periodic::{Record, Start};
use chatter_files::journal::{Found, Journal, JournalError, Unread};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// What a journal of branches begins with.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Header {
    /// What is computed: the name tells this journal from those of other computations.
    branches: Job,
    /// In which form records are kept: [`Record::FORMAT`].
    record_format: u32,
}

/// What is appended. A piece is what is followed from one orbit.
#[derive(Serialize, Deserialize)]
enum Entry<'a> {
    /// The orbits that branches are followed from, where there are several.
    Starts(Cow<'a, [Start]>),
    /// How far a piece has come since its entry before.
    Part(usize, Cow<'a, Record>),
    /// Nothing is left to be done for a piece.
    Done(usize),
}

/// What is known of branches that were begun.
#[derive(Default)]
pub(super) struct Known {
    /// The orbits that they are followed from.
    pub starts: Option<Vec<Start>>,
    /// How far each piece has come.
    pub parts: BTreeMap<usize, Vec<Record>>,
    /// Pieces that are done; those without parts were found to be on others.
    pub done: BTreeSet<usize>,
}

impl Known {
    fn take(&mut self, entry: Entry<'_>) {
        match entry {
            Entry::Starts(starts) => self.starts = Some(starts.into_owned()),
            Entry::Part(piece, record) => {
                let parts = self.parts.entry(piece).or_default();
                parts.push(record.into_owned());
            }
            Entry::Done(piece) => _ = self.done.insert(piece),
        }
    }
}

/// A journal that was begun before. No other process can have it meanwhile.
pub struct Begun {
    unread: Unread,
    /// What it is about.
    pub job: Job,
}

impl Begun {
    /// The file.
    pub(super) fn path(&self) -> &Path {
        self.unread.path()
    }
}

/// An open journal, and what it held.
pub struct Log {
    journal: Journal,
    before: Known,
    entries: usize,
}

/// Longest record: more is no part of a branch.
const LONGEST: u64 = 1 << 30;

impl Begun {
    /// Opens a journal; `None` if there is none.
    ///
    /// # Errors
    /// It cannot be read, is of something else, or another process has it open.
    pub fn open(path: &Path) -> Result<Option<Self>, Refusal> {
        let unread = Unread::open(path).map_err(Refusal::input)?;
        unread.map(Self::of).transpose()
    }

    fn of(unread: Unread) -> Result<Self, Refusal> {
        let path = unread.path().display();
        match serde_json::from_slice::<Header>(unread.header()) {
            Ok(header) if header.record_format != Record::FORMAT => Err(Refusal::input(format!(
                "`{path}` was begun by another chatter, which wrote its records in form {}; this one writes form {}",
                header.record_format,
                Record::FORMAT
            ))
            .help("delete it and compute the branches anew, or go on with the chatter that began it")),
            Ok(header) => {
                of_this_version(unread.path(), &header.branches.version)?;
                Ok(Self {
                    unread,
                    job: header.branches,
                })
            }
            Err(error) => Err(Refusal::input(format!(
                "`{path}` is not a journal of branches of this version of chatter: {error}"
            ))),
        }
    }

    /// Reads what is there.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn read(self, observer: &dyn Observer) -> Result<Log, Refusal> {
        let path = self.unread.path().to_path_buf();
        let mut before = Known::default();
        let mut entries = 0;
        let mut damaged = None;
        let read = self.unread.read(LONGEST, |_, bytes| {
            match serde_json::from_slice::<Entry<'_>>(bytes) {
                Ok(entry) => {
                    before.take(entry);
                    entries += 1;
                }
                Err(error) => damaged = Some(error),
            }
        });
        let journal = read.map_err(Refusal::input)?;
        if let Some(error) = damaged {
            return Err(Refusal::input(format!(
                "`{}` holds a record that is none of a branch: {error}",
                path.display()
            ))
            .help("delete it and compute the branches anew"));
        }
        let records = before.parts.values().flatten();
        let orbits: usize = records.map(Record::orbits).sum();
        observer.remark(&format!(
            "going on from `{}`: {orbits} orbits are known",
            path.display()
        ));
        Ok(Log {
            journal,
            before,
            entries,
        })
    }
}

impl Log {
    /// The journal of a job: the one that is there, if it is of the same, or a new one.
    ///
    /// # Errors
    /// The one that is there is of something else, or it cannot be read or written.
    pub fn find(path: &Path, job: &Job, observer: &dyn Observer) -> Result<Self, Refusal> {
        let header = Header {
            branches: job.clone(),
            record_format: Record::FORMAT,
        };
        let bytes =
            serde_json::to_vec(&header).map_err(|error| Refusal::input(error.to_string()))?;
        match Journal::find(path, &bytes) {
            Ok(Found::New(journal)) => Ok(Self {
                journal,
                before: Known::default(),
                entries: 0,
            }),
            Ok(Found::Old(unread)) => {
                let begun = Begun::of(unread)?;
                if begun.job == *job {
                    return begun.read(observer);
                }
                Err(Refusal::input(format!(
                    "`{}` holds unfinished branches with {}",
                    path.display(),
                    begun.job.difference(job)
                ))
                .help(
                    "finish them with --resume, delete it, or write these branches to another file",
                ))
            }
            Err(error @ JournalError::File(_)) => Err(output(&error)),
            Err(error) => Err(Refusal::input(error)),
        }
    }

    /// What was known when it was opened.
    pub(super) fn before(&mut self) -> Known {
        core::mem::take(&mut self.before)
    }

    /// What was known when it was opened, unless it was taken.
    pub(super) fn known(&self) -> &Known {
        &self.before
    }

    /// Keeps the orbits that branches are followed from.
    pub(super) fn starts(&mut self, starts: &[Start]) -> Result<(), Refusal> {
        self.append(&Entry::Starts(Cow::Borrowed(starts)))
    }

    /// Keeps a record of a piece.
    pub(super) fn part(&mut self, piece: usize, record: &Record) -> Result<(), Refusal> {
        self.append(&Entry::Part(piece, Cow::Borrowed(record)))
    }

    /// Keeps that a piece is done.
    pub(super) fn done(&mut self, piece: usize) -> Result<(), Refusal> {
        self.append(&Entry::Done(piece))
    }

    fn append(&mut self, entry: &Entry<'_>) -> Result<(), Refusal> {
        let bytes =
            serde_json::to_vec(entry).map_err(|error| Refusal::Output(error.to_string()))?;
        self.journal
            .append(&bytes)
            .map_err(|error| output(&error))?;
        self.entries += 1;
        Ok(())
    }

    /// Whether there is nothing in it.
    pub fn is_empty(&self) -> bool {
        self.entries == 0
    }

    /// Deletes the journal.
    ///
    /// # Errors
    /// It cannot be deleted.
    pub fn remove(self) -> Result<(), Refusal> {
        self.journal.remove().map_err(|error| output(&error))
    }
}

fn output(error: &JournalError) -> Refusal {
    Refusal::Output(error.to_string())
}
