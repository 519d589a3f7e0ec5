//! The journal of branches that are being found: how far they have come.

use super::job::Job;
use crate::journals::of_this_version;
use crate::observer::Observer;
use crate::refusal::Refusal;
use chatter::analysis::periodic::Record;
use chatter_files::journal::{Found, Journal, JournalError, Unread};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// What a journal of branches begins with.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Header {
    /// What is computed: the name tells this journal from those of other computations.
    branches: Job,
    /// In which form records are kept: [`Record::FORMAT`].
    record_format: u32,
}

/// A journal that was begun before. No other process can have it meanwhile.
pub struct Begun {
    unread: Unread,
    /// What it is about.
    pub job: Job,
}

/// An open journal, and what it held.
pub struct Log {
    journal: Journal,
    before: Vec<Record>,
    records: usize,
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
        let mut before = Vec::new();
        let mut damaged = None;
        let read = self.unread.read(LONGEST, |_, bytes| {
            match serde_json::from_slice::<Record>(bytes) {
                Ok(record) => before.push(record),
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
        let orbits: usize = before.iter().map(Record::orbits).sum();
        observer.remark(&format!(
            "going on from `{}`: {orbits} orbits are known",
            path.display()
        ));
        Ok(Log {
            journal,
            records: before.len(),
            before,
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
                before: Vec::new(),
                records: 0,
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
    pub(super) fn before(&mut self) -> Vec<Record> {
        core::mem::take(&mut self.before)
    }

    /// Keeps a record.
    pub(super) fn append(&mut self, record: &Record) -> Result<(), Refusal> {
        let bytes =
            serde_json::to_vec(record).map_err(|error| Refusal::Output(error.to_string()))?;
        self.journal
            .append(&bytes)
            .map_err(|error| output(&error))?;
        self.records += 1;
        Ok(())
    }

    /// Whether there is nothing in it.
    pub fn is_empty(&self) -> bool {
        self.records == 0
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
