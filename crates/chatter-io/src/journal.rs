//! An append-only file of records that survives being killed: what was appended is there again, whole, or not at all.
//!
//! A header says what the records are about; its content is the caller's. Each record has its length and a checksum
//! before it. When a journal is opened again, everything from the first record on that is cut short or damaged is
//! dropped: those records were being written when the process ended, and are to be made again.

use std::fmt;
use std::fs::{self, File};
use std::io::{self, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use crate::atomic_file::write_atomically;
use crate::crc32::Crc32;
use crate::error::{FileAction, FileError};

/// First bytes of a journal.
const MAGIC: &[u8; 16] = b"chatter journal\x01";

/// Length and checksum before the bytes of header or record.
const PREFIX: usize = 12;

/// A journal open for appending. No other process can open it meanwhile.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: File,
    /// Where the next record will stand.
    end: u64,
}

/// Where a record stands in its journal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Place(u64);

impl Journal {
    /// Starts a journal with a header and no records, in place of whatever the file held.
    ///
    /// # Errors
    /// The file cannot be written, or another process has it open.
    pub fn create(path: impl AsRef<Path>, header: &[u8]) -> Result<Self, JournalError> {
        let path = path.as_ref();
        let mut bytes = MAGIC.to_vec();
        bytes.extend(prefix(header));
        bytes.extend(header);
        // Renamed into place, so that there is no journal without a header.
        write_atomically(path, &bytes).map_err(JournalError::File)?;
        let file = open(path)?;
        Ok(Self {
            path: path.to_path_buf(),
            file,
            end: bytes.len() as u64,
        })
    }

    /// Opens a journal and gives its header. `record` hears of each record that is there, in order; the rest of the file
    /// is cut off.
    ///
    /// # Errors
    /// There is no such file, it is no journal, or another process has it open.
    pub fn open(
        path: impl AsRef<Path>,
        mut record: impl FnMut(Place, &[u8]),
    ) -> Result<(Self, Vec<u8>), JournalError> {
        let path = path.as_ref();
        let file = open(path)?;
        let read_error = |error| JournalError::File(FileError::new(path, FileAction::Read, error));
        let mut length = file.metadata().map_err(read_error)?.len();
        let mut reader = BufReader::with_capacity(1 << 16, &file);
        let mut magic = [0; MAGIC.len()];
        let known = length >= MAGIC.len() as u64
            && reader.read_exact(&mut magic).map_err(read_error).is_ok()
            && &magic == MAGIC;
        if !known {
            return Err(JournalError::NotAJournal {
                path: path.to_path_buf(),
            });
        }
        length -= MAGIC.len() as u64;
        let mut end = MAGIC.len() as u64;
        let mut bytes = Vec::new();
        if !next(&mut reader, &mut length, &mut bytes).map_err(read_error)? {
            return Err(JournalError::NotAJournal {
                path: path.to_path_buf(),
            });
        }
        let header = bytes.clone();
        end += (PREFIX + header.len()) as u64;
        while next(&mut reader, &mut length, &mut bytes).map_err(read_error)? {
            record(Place(end), &bytes);
            end += (PREFIX + bytes.len()) as u64;
        }
        drop(reader);
        let journal = Self {
            path: path.to_path_buf(),
            file,
            end,
        };
        journal
            .file
            .set_len(end)
            .map_err(|error| journal.write_error(error))?;
        Ok((journal, header))
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Appends a record.
    ///
    /// # Errors
    /// The file cannot be written, as when the disk is full; the journal is good up to the record before.
    pub fn append(&mut self, bytes: &[u8]) -> Result<Place, JournalError> {
        let mut whole = Vec::with_capacity(PREFIX + bytes.len());
        whole.extend(prefix(bytes));
        whole.extend(bytes);
        let place = Place(self.end);
        self.file
            .seek(SeekFrom::Start(self.end))
            .and_then(|_| self.file.write_all(&whole))
            .map_err(|error| self.write_error(error))?;
        self.end += whole.len() as u64;
        Ok(place)
    }

    /// Reads a record again.
    ///
    /// # Errors
    /// The file cannot be read, or was changed by someone else.
    pub fn read(&mut self, place: Place, bytes: &mut Vec<u8>) -> Result<(), JournalError> {
        let mut left = self.end.saturating_sub(place.0);
        let whole = self
            .file
            .seek(SeekFrom::Start(place.0))
            .and_then(|_| next(&mut self.file, &mut left, bytes))
            .map_err(|error| {
                JournalError::File(FileError::new(&self.path, FileAction::Read, error))
            })?;
        if whole {
            Ok(())
        } else {
            Err(JournalError::Damaged {
                path: self.path.clone(),
                at: place.0,
            })
        }
    }

    /// Deletes the journal: it is not needed any more.
    ///
    /// # Errors
    /// It cannot be deleted.
    pub fn remove(self) -> Result<(), JournalError> {
        let path = self.path.clone();
        drop(self);
        fs::remove_file(&path)
            .map_err(|error| JournalError::File(FileError::new(path, FileAction::Write, error)))
    }

    fn write_error(&self, error: io::Error) -> JournalError {
        JournalError::File(FileError::new(&self.path, FileAction::Write, error))
    }
}

fn open(path: &Path) -> Result<File, JournalError> {
    let file = File::options()
        .read(true)
        .write(true)
        .open(path)
        .map_err(|error| JournalError::File(FileError::new(path, FileAction::Open, error)))?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(fs::TryLockError::WouldBlock) => Err(JournalError::InUse {
            path: path.to_path_buf(),
        }),
        // A file system without locks: the user has to see to it that there is one process.
        Err(fs::TryLockError::Error(_)) => Ok(file),
    }
}

fn prefix(bytes: &[u8]) -> [u8; PREFIX] {
    let length = (bytes.len() as u64).to_le_bytes();
    let mut sum = Crc32::default();
    sum.update(&length);
    sum.update(bytes);
    let mut prefix = [0; PREFIX];
    prefix[..8].copy_from_slice(&length);
    prefix[8..].copy_from_slice(&sum.sum().to_le_bytes());
    prefix
}

/// Reads one record of at most `left` bytes; `false` if there is none, or it is cut short or damaged.
fn next(reader: &mut impl Read, left: &mut u64, bytes: &mut Vec<u8>) -> io::Result<bool> {
    bytes.clear();
    if *left < PREFIX as u64 {
        return Ok(false);
    }
    let mut found = [0; PREFIX];
    reader.read_exact(&mut found)?;
    *left -= PREFIX as u64;
    let (length, _) = found.split_at(8);
    let length = length
        .iter()
        .rev()
        .fold(0, |n: u64, &byte| n << 8 | u64::from(byte));
    let Some(size) = usize::try_from(length).ok().filter(|_| length <= *left) else {
        return Ok(false);
    };
    bytes.resize(size, 0);
    reader.read_exact(bytes)?;
    *left -= length;
    Ok(prefix(bytes) == found)
}

/// What can go wrong with a journal.
#[derive(Debug)]
pub enum JournalError {
    /// The file cannot be read or written.
    File(FileError),
    /// The file is something else.
    NotAJournal {
        /// The file.
        path: PathBuf,
    },
    /// Another process has it open.
    InUse {
        /// The file.
        path: PathBuf,
    },
    /// A record is not what was appended.
    Damaged {
        /// The file.
        path: PathBuf,
        /// Where the record stands.
        at: u64,
    },
}

impl fmt::Display for JournalError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(error) => error.fmt(f),
            Self::NotAJournal { path } => {
                write!(f, "`{}` is not a journal of chatter", path.display())
            }
            Self::InUse { path } => write!(
                f,
                "`{}` is in use: another process is writing it",
                path.display()
            ),
            Self::Damaged { path, at } => write!(
                f,
                "`{}` was changed while it was in use: the record at byte {at} is damaged",
                path.display()
            ),
        }
    }
}

impl std::error::Error for JournalError {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scratch::Scratch;
    use proptest::prelude::*;

    fn records(path: &Path) -> (Vec<Vec<u8>>, Vec<u8>) {
        let mut records = Vec::new();
        let (_, header) = Journal::open(path, |_, bytes| records.push(bytes.to_vec())).unwrap();
        (records, header)
    }

    #[test]
    fn records_are_there_again_and_more_can_follow() {
        let folder = Scratch::new();
        let path = folder.path("a.journal");
        let mut journal = Journal::create(&path, b"header").unwrap();
        let first = journal.append(b"one").unwrap();
        journal.append(b"").unwrap();
        let mut bytes = Vec::new();
        journal.read(first, &mut bytes).unwrap();
        assert_eq!(bytes, b"one");
        assert!(matches!(
            Journal::open(&path, |_, _| {}),
            Err(JournalError::InUse { .. })
        ));
        drop(journal);
        let (mut journal, header) = Journal::open(&path, |_, _| {}).unwrap();
        assert_eq!(header, b"header");
        let third = journal.append(b"three").unwrap();
        journal.read(first, &mut bytes).unwrap();
        assert_eq!(bytes, b"one");
        journal.read(third, &mut bytes).unwrap();
        assert_eq!(bytes, b"three");
        drop(journal);
        let expected: [&[u8]; 3] = [b"one", b"", b"three"];
        assert_eq!(records(&path).0, expected);
        Journal::open(&path, |_, _| {}).unwrap().0.remove().unwrap();
        assert!(!path.exists());
    }

    #[test]
    fn other_files_are_refused() {
        let folder = Scratch::new();
        let path = folder.path("a.journal");
        for content in [
            &b""[..],
            b"chatter journal",
            b"something else entirely, longer",
        ] {
            fs::write(&path, content).unwrap();
            assert!(matches!(
                Journal::open(&path, |_, _| {}),
                Err(JournalError::NotAJournal { .. })
            ));
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]

        #[test]
        fn a_torn_or_damaged_tail_is_dropped_and_nothing_else(
            contents in proptest::collection::vec(proptest::collection::vec(any::<u8>(), 0..40), 1..8),
            at in any::<proptest::sample::Index>(),
            flip in 1u8..,
            cut in any::<bool>(),
        ) {
            let folder = Scratch::new();
            let path = folder.path("a.journal");
            let mut journal = Journal::create(&path, b"h").unwrap();
            let head = fs::metadata(&path).unwrap().len() as usize;
            let mut ends = Vec::new();
            for content in &contents {
                journal.append(content).unwrap();
                ends.push(fs::metadata(&path).unwrap().len() as usize);
            }
            drop(journal);
            let mut bytes = fs::read(&path).unwrap();
            let place = head + at.index(bytes.len() - head);
            if cut {
                bytes.truncate(place);
            } else {
                bytes[place] ^= flip;
            }
            fs::write(&path, &bytes).unwrap();
            let whole = ends.iter().filter(|&&end| end <= place).count();
            prop_assert_eq!(&records(&path).0, &contents[..whole]);
            // What was dropped does not come back behind what is appended next.
            let (mut journal, _) = Journal::open(&path, |_, _| {}).unwrap();
            journal.append(b"next").unwrap();
            drop(journal);
            let (found, header) = records(&path);
            prop_assert_eq!(found.len(), whole + 1);
            prop_assert_eq!(header, b"h");
        }
    }
}
