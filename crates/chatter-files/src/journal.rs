//! An append-only file of records that survives being killed: what was appended is there again, whole, or not at all.
//!
//! A header says what the records are about; its content is the caller's. Each record has its length and a checksum
//! before it. When a journal is opened again, everything from the first record on that is cut short or damaged is
//! dropped: those records were being written when the process ended, and are to be made again.
//!
//! A journal is locked from before it has its name until it is closed or removed: of two processes that begin one, the
//! second is refused. What was appended is handed to the disk every [`SYNC_EVERY`], whether more comes or not.

use std::fmt;
use std::fs::{self, File};
use std::io::{self, BufReader, Read, Seek, SeekFrom, Write};
use std::num::NonZeroU64;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use crate::atomic_file::{sync_folder, temporary_for};
use crate::error::{FileAction, FileError};

/// First bytes of a journal.
const MAGIC: &[u8; 16] = b"chatter journal\x01";

/// Length and checksum before the bytes of header or record.
const PREFIX: usize = 12;

/// A power cut loses no more than was appended in this time.
pub const SYNC_EVERY: Duration = Duration::from_secs(2);

/// Most bytes of a header: a model's text and a specification are far shorter.
pub const LONGEST_HEADER: u64 = 1 << 26;

/// Times that a journal may come and go between looking for it and opening it.
const MOST_ATTEMPTS: usize = 16;

/// A journal open for appending. No other process can open it meanwhile.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: File,
    /// Where the next record will stand.
    end: u64,
    /// None where nothing is to outlast the process.
    sync: Option<Sync>,
}

/// A journal whose header has been read, and whose records have not.
#[derive(Debug)]
pub struct Unread {
    path: PathBuf,
    file: File,
    header: Vec<u8>,
}

/// A journal that was there, or a new one.
#[derive(Debug)]
pub enum Found {
    /// There was none.
    New(Journal),
    /// There was one, about whatever its header says.
    Old(Unread),
}

/// Where a record stands in its journal: the first bytes are the header's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Place(NonZeroU64);

impl Unread {
    /// Opens a journal and reads its header; `None` if there is no such file.
    ///
    /// # Errors
    /// It cannot be read, it is no journal, or another process has it open.
    pub fn open(path: impl AsRef<Path>) -> Result<Option<Self>, JournalError> {
        let path = path.as_ref();
        let Some(file) = open(path)? else {
            return Ok(None);
        };
        let header = header_of(&file)
            .map_err(|error| JournalError::File(FileError::new(path, FileAction::Read, error)))?;
        let path = path.to_path_buf();
        match header {
            Some(header) => Ok(Some(Self { path, file, header })),
            None => Err(JournalError::NotAJournal { path }),
        }
    }

    /// What the records are about.
    pub fn header(&self) -> &[u8] {
        &self.header
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Reads the records: `record` hears of each, in order. From the first one on that is damaged, or longer than
    /// `longest`, the file is cut off.
    ///
    /// # Errors
    /// The file cannot be read or written.
    pub fn read(
        self,
        longest: u64,
        mut record: impl FnMut(Place, &[u8]),
    ) -> Result<Journal, JournalError> {
        let Self { path, file, header } = self;
        let read_error = |error| JournalError::File(FileError::new(&path, FileAction::Read, error));
        let start = (MAGIC.len() + PREFIX + header.len()) as u64;
        let mut left = file
            .metadata()
            .map_err(read_error)?
            .len()
            .saturating_sub(start);
        let mut reader = BufReader::with_capacity(1 << 16, &file);
        reader.seek(SeekFrom::Start(start)).map_err(read_error)?;
        let mut end = start;
        let mut bytes = Vec::new();
        while next(&mut reader, &mut left, longest, &mut bytes).map_err(read_error)? {
            record(place(end), &bytes);
            end += (PREFIX + bytes.len()) as u64;
        }
        drop(reader);
        file.set_len(end)
            .map_err(|error| JournalError::File(FileError::new(&path, FileAction::Write, error)))?;
        Journal::new(path, file, end)
    }
}

impl Journal {
    /// Opens the journal that is there, or starts one with this header and no records.
    ///
    /// # Errors
    /// The file cannot be read or written, it is no journal, or another process has it open.
    pub fn find(path: impl AsRef<Path>, header: &[u8]) -> Result<Found, JournalError> {
        let path = path.as_ref();
        for _ in 0..MOST_ATTEMPTS {
            if let Some(unread) = Unread::open(path)? {
                return Ok(Found::Old(unread));
            }
            if let Some(journal) = Self::create(path, header)? {
                return Ok(Found::New(journal));
            }
        }
        let error = io::Error::from(io::ErrorKind::AlreadyExists);
        Err(JournalError::File(FileError::new(
            path,
            FileAction::Create,
            error,
        )))
    }

    /// Starts a journal; `None` if there is a file of this name already, whatever it holds.
    fn create(path: &Path, header: &[u8]) -> Result<Option<Self>, JournalError> {
        let fail = |action| move |error| JournalError::File(FileError::new(path, action, error));
        let mut bytes = MAGIC.to_vec();
        bytes.extend(prefix(header));
        bytes.extend(header);
        // It is locked and has its header before it has its name.
        let mut temporary = temporary_for(path).map_err(fail(FileAction::Create))?;
        temporary
            .write_all(&bytes)
            .and_then(|()| temporary.as_file().sync_all())
            .map_err(fail(FileAction::Write))?;
        match temporary.persist_noclobber(path) {
            Ok(file) => {
                sync_folder(path).map_err(fail(FileAction::Create))?;
                Self::new(path.to_path_buf(), file, bytes.len() as u64).map(Some)
            }
            Err(error) if error.error.kind() == io::ErrorKind::AlreadyExists => Ok(None),
            Err(error) => Err(fail(FileAction::Create)(error.error)),
        }
    }

    /// A journal in `folder` without a name, which is gone with the process: for what is too large for memory.
    ///
    /// # Errors
    /// The file cannot be created.
    pub fn nameless(folder: impl AsRef<Path>) -> Result<Self, JournalError> {
        let path = folder.as_ref().to_path_buf();
        match tempfile::tempfile_in(&path) {
            Ok(file) => Ok(Self {
                path,
                file,
                end: MAGIC.len() as u64,
                sync: None,
            }),
            Err(error) => Err(JournalError::File(FileError::new(
                path,
                FileAction::Create,
                error,
            ))),
        }
    }

    fn new(path: PathBuf, file: File, end: u64) -> Result<Self, JournalError> {
        match Sync::new(&file) {
            Ok(sync) => Ok(Self {
                path,
                file,
                end,
                sync: Some(sync),
            }),
            Err(error) => Err(JournalError::File(FileError::new(
                path,
                FileAction::Write,
                error,
            ))),
        }
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
        let place = place(self.end);
        let failure = self.sync.as_ref().map_or(Ok(()), Sync::failure);
        failure
            .and_then(|()| self.file.seek(SeekFrom::Start(self.end)))
            .and_then(|_| self.file.write_all(&whole))
            .map_err(|error| self.write_error(error))?;
        self.end += whole.len() as u64;
        if let Some(sync) = &self.sync {
            sync.dirty.store(true, Ordering::Release);
        }
        Ok(place)
    }

    /// Reads a record again.
    ///
    /// # Errors
    /// The file cannot be read, or was changed by someone else.
    pub fn read(&mut self, place: Place, bytes: &mut Vec<u8>) -> Result<(), JournalError> {
        let at = place.0.get();
        let mut left = self.end.saturating_sub(at);
        let longest = left;
        let whole = self
            .file
            .seek(SeekFrom::Start(at))
            .and_then(|_| next(&mut self.file, &mut left, longest, bytes))
            .map_err(|error| {
                JournalError::File(FileError::new(&self.path, FileAction::Read, error))
            })?;
        if whole {
            Ok(())
        } else {
            Err(JournalError::Damaged {
                path: self.path.clone(),
                at,
            })
        }
    }

    /// Deletes the journal: it is not needed any more. It is locked until it is gone.
    ///
    /// # Errors
    /// It cannot be deleted.
    pub fn remove(self) -> Result<(), JournalError> {
        if let Some(sync) = &self.sync {
            sync.dirty.store(false, Ordering::Release);
        }
        fs::remove_file(&self.path).map_err(|error| self.write_error(error))
    }

    fn write_error(&self, error: io::Error) -> JournalError {
        JournalError::File(FileError::new(&self.path, FileAction::Write, error))
    }
}

/// A thread that hands to the disk what was written, as long as it lives and once more at its end.
#[derive(Debug)]
struct Sync {
    dirty: Arc<AtomicBool>,
    failed: Arc<Mutex<Option<io::Error>>>,
    /// Ends the thread by being dropped.
    end: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Sync {
    fn new(file: &File) -> io::Result<Self> {
        let file = file.try_clone()?;
        let dirty = Arc::new(AtomicBool::new(false));
        let failed = Arc::new(Mutex::new(None));
        let (end, ended) = channel();
        let (written, outcome) = (Arc::clone(&dirty), Arc::clone(&failed));
        let thread = std::thread::Builder::new().spawn(move || {
            loop {
                let last = ended.recv_timeout(SYNC_EVERY) != Err(RecvTimeoutError::Timeout);
                if written.swap(false, Ordering::AcqRel)
                    && let Err(error) = file.sync_data()
                {
                    *outcome.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
                }
                if last {
                    return;
                }
            }
        })?;
        Ok(Self {
            dirty,
            failed,
            end: Some(end),
            thread: Some(thread),
        })
    }

    /// What the thread has met with since it was last asked.
    fn failure(&self) -> io::Result<()> {
        let mut failed = self.failed.lock().unwrap_or_else(PoisonError::into_inner);
        failed.take().map_or(Ok(()), Err)
    }
}

impl Drop for Sync {
    fn drop(&mut self) {
        drop(self.end.take());
        if let Some(thread) = self.thread.take() {
            // It does not panic; what it could not write, the system may.
            let _ = thread.join();
        }
    }
}

/// Opens and locks a file that is there.
fn open(path: &Path) -> Result<Option<File>, JournalError> {
    for _ in 0..MOST_ATTEMPTS {
        let file = match File::options().read(true).write(true).open(path) {
            Ok(file) => file,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => {
                return Err(JournalError::File(FileError::new(
                    path,
                    FileAction::Open,
                    error,
                )));
            }
        };
        match file.try_lock() {
            Ok(()) => {}
            Err(fs::TryLockError::WouldBlock) => {
                return Err(JournalError::InUse {
                    path: path.to_path_buf(),
                });
            }
            // A file system without locks: the user has to see to it that there is one process.
            Err(fs::TryLockError::Error(_)) => {}
        }
        // Whoever had it open may just have been done with it and have deleted it.
        if is_at(&file, path) {
            return Ok(Some(file));
        }
    }
    Err(JournalError::InUse {
        path: path.to_path_buf(),
    })
}

/// Whether an open file is the one that has this name now.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    match (file.metadata(), fs::metadata(path)) {
        (Ok(open), Ok(named)) => (open.dev(), open.ino()) == (named.dev(), named.ino()),
        _ => false,
    }
}

/// Elsewhere a file that is open keeps its name.
#[cfg(not(unix))]
fn is_at(_: &File, path: &Path) -> bool {
    path.exists()
}

/// The header of a journal; `None` if the file is something else.
fn header_of(file: &File) -> io::Result<Option<Vec<u8>>> {
    let metadata = file.metadata()?;
    let mut reader = BufReader::with_capacity(1 << 16, file);
    let mut magic = [0; MAGIC.len()];
    if !metadata.is_file() || metadata.len() < MAGIC.len() as u64 {
        return Ok(None);
    }
    reader.read_exact(&mut magic)?;
    let mut left = metadata.len() - MAGIC.len() as u64;
    let mut header = Vec::new();
    let known = &magic == MAGIC && next(&mut reader, &mut left, LONGEST_HEADER, &mut header)?;
    Ok(known.then_some(header))
}

fn place(at: u64) -> Place {
    Place(NonZeroU64::new(at).expect("a record stands behind the header"))
}

fn prefix(bytes: &[u8]) -> [u8; PREFIX] {
    let length = (bytes.len() as u64).to_le_bytes();
    let mut sum = crc32fast::Hasher::new();
    sum.update(&length);
    sum.update(bytes);
    let mut prefix = [0; PREFIX];
    prefix[..8].copy_from_slice(&length);
    prefix[8..].copy_from_slice(&sum.finalize().to_le_bytes());
    prefix
}

/// Reads one record, of at most `longest` bytes and in `left` ones of the file; `false` if there is none, or it is cut
/// short or damaged.
fn next(
    reader: &mut impl Read,
    left: &mut u64,
    longest: u64,
    bytes: &mut Vec<u8>,
) -> io::Result<bool> {
    bytes.clear();
    if *left < PREFIX as u64 {
        return Ok(false);
    }
    let mut found = [0; PREFIX];
    reader.read_exact(&mut found)?;
    *left -= PREFIX as u64;
    let (length, _) = found.split_first_chunk().expect("longer than a number");
    let length = u64::from_le_bytes(*length);
    if length > *left || length > longest {
        return Ok(false);
    }
    // Memory grows with what is read, not with what a damaged length claims.
    let read = reader.take(length).read_to_end(bytes)?;
    *left -= length;
    Ok(read as u64 == length && prefix(bytes) == found)
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

    fn create(path: &Path, header: &[u8]) -> Journal {
        match Journal::find(path, header).unwrap() {
            Found::New(journal) => journal,
            Found::Old(_) => panic!("there was one"),
        }
    }

    fn reopen(path: &Path) -> Journal {
        let unread = Unread::open(path).unwrap().unwrap();
        unread.read(u64::MAX, |_, _| {}).unwrap()
    }

    fn records(path: &Path) -> (Vec<Vec<u8>>, Vec<u8>) {
        let mut records = Vec::new();
        let unread = Unread::open(path).unwrap().unwrap();
        let header = unread.header().to_vec();
        let read = unread.read(u64::MAX, |_, bytes| records.push(bytes.to_vec()));
        read.unwrap();
        (records, header)
    }

    #[test]
    fn records_are_there_again_and_more_can_follow() {
        let folder = Scratch::new();
        let path = folder.path("a.journal");
        let mut journal = create(&path, b"header");
        let first = journal.append(b"one").unwrap();
        journal.append(b"").unwrap();
        let mut bytes = Vec::new();
        journal.read(first, &mut bytes).unwrap();
        assert_eq!(bytes, b"one");
        for second in [
            Unread::open(&path).map(|_| ()),
            Journal::find(&path, b"other").map(|_| ()),
        ] {
            assert!(matches!(second, Err(JournalError::InUse { .. })));
        }
        drop(journal);
        let Found::Old(unread) = Journal::find(&path, b"other").unwrap() else {
            panic!("it is there");
        };
        assert_eq!(unread.header(), b"header");
        let mut journal = unread.read(u64::MAX, |_, _| {}).unwrap();
        let third = journal.append(b"three").unwrap();
        journal.read(first, &mut bytes).unwrap();
        assert_eq!(bytes, b"one");
        journal.read(third, &mut bytes).unwrap();
        assert_eq!(bytes, b"three");
        drop(journal);
        let expected: [&[u8]; 3] = [b"one", b"", b"three"];
        assert_eq!(records(&path).0, expected);
        reopen(&path).remove().unwrap();
        assert!(Unread::open(&path).unwrap().is_none());
        assert_eq!(fs::read_dir(folder.root()).unwrap().count(), 0);
    }

    #[test]
    fn one_without_a_name_leaves_nothing() {
        let folder = Scratch::new();
        let mut journal = Journal::nameless(folder.root()).unwrap();
        let places: Vec<Place> = (0..100_u8)
            .map(|k| journal.append(&vec![k; usize::from(k)]).unwrap())
            .collect();
        let mut bytes = Vec::new();
        for (k, place) in (0..100_u8).zip(places) {
            journal.read(place, &mut bytes).unwrap();
            assert_eq!(bytes, vec![k; usize::from(k)]);
        }
        drop(journal);
        assert_eq!(fs::read_dir(folder.root()).unwrap().count(), 0);
    }

    #[test]
    fn of_all_that_begin_at_once_one_has_it() {
        let folder = Scratch::new();
        let path = folder.path("a.journal");
        for _ in 0..50 {
            let had = Mutex::new(Vec::new());
            std::thread::scope(|scope| {
                for _ in 0..4 {
                    scope.spawn(|| {
                        let found = Journal::find(&path, b"h");
                        had.lock().unwrap().push(found);
                    });
                }
            });
            let mut had = had.into_inner().unwrap();
            let new = had.iter().filter(|one| matches!(one, Ok(Found::New(_))));
            assert_eq!(new.count(), 1);
            had.retain(|one| !matches!(one, Err(JournalError::InUse { .. })));
            assert_eq!(had.len(), 1);
            drop(had);
            reopen(&path).remove().unwrap();
        }
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
                Unread::open(&path),
                Err(JournalError::NotAJournal { .. })
            ));
            assert_eq!(fs::read(&path).unwrap(), content);
        }
    }

    #[test]
    fn a_length_that_is_nothing_but_a_claim_costs_nothing() {
        let folder = Scratch::new();
        let path = folder.path("a.journal");
        let mut journal = create(&path, b"h");
        journal.append(b"one").unwrap();
        let end = journal.end;
        drop(journal);
        // A record of 200 GB in a file that is as long, and takes no room.
        let length: u64 = 200 << 30;
        let mut bytes = fs::read(&path).unwrap();
        bytes.extend(length.to_le_bytes());
        bytes.extend([0; 4]);
        fs::write(&path, &bytes).unwrap();
        let file = File::options().write(true).open(&path).unwrap();
        file.set_len(end + PREFIX as u64 + length).unwrap();
        let unread = Unread::open(&path).unwrap().unwrap();
        let mut count = 0;
        unread.read(1000, |_, _| count += 1).unwrap();
        assert_eq!(count, 1);
        assert_eq!(fs::metadata(&path).unwrap().len(), end);
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
            let mut journal = create(&path, b"h");
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
            let mut journal = reopen(&path);
            journal.append(b"next").unwrap();
            drop(journal);
            let (found, header) = records(&path);
            prop_assert_eq!(found.len(), whole + 1);
            prop_assert_eq!(header, b"h");
        }
    }
}
