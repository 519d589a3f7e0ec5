//! Records of equal length in flat memory: the latest in memory, all before them in a nameless file, gone with the process.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use crate::error::{FileAction, FileError};

/// So many bytes are kept in memory: a short log needs no file at all.
const IN_MEMORY: usize = 1 << 20;

/// Bytes read at once.
const CHUNK: usize = 1 << 16;

/// Records in the order in which they were appended; they can be read again and again, and replaced.
#[derive(Debug)]
pub struct RecordLog {
    folder: PathBuf,
    /// Bytes of a record.
    length: usize,
    file: Option<File>,
    /// How many records the file holds; the rest follow in memory.
    in_file: u64,
    memory: Vec<u8>,
}

impl RecordLog {
    /// An empty one of records of so many bytes; should they become many, on the disk of `folder`.
    pub fn new(folder: impl AsRef<Path>, length: usize) -> Self {
        Self {
            folder: folder.as_ref().to_path_buf(),
            length: length.max(1),
            file: None,
            in_file: 0,
            memory: Vec::new(),
        }
    }

    /// How many records there are.
    pub fn len(&self) -> u64 {
        self.in_file + (self.memory.len() / self.length) as u64
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Appends a record of the length that was said.
    ///
    /// # Errors
    /// The file cannot be created or written, as when the disk is full.
    pub fn push(&mut self, record: &[u8]) -> Result<(), FileError> {
        debug_assert_eq!(record.len(), self.length);
        self.memory.extend_from_slice(record);
        if self.memory.len() < IN_MEMORY {
            return Ok(());
        }
        let mut file = match self.file.take() {
            Some(file) => file,
            None => tempfile::tempfile_in(&self.folder)
                .map_err(|error| self.failed(FileAction::Create, error))?,
        };
        file.seek(SeekFrom::End(0))
            .and_then(|_| file.write_all(&self.memory))
            .map_err(|error| self.failed(FileAction::Write, error))?;
        self.in_file = self.len();
        self.memory.clear();
        self.file = Some(file);
        Ok(())
    }

    /// Puts a record in the place of another, by number.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn replace(&mut self, number: u64, record: &[u8]) -> Result<(), FileError> {
        debug_assert!(number < self.len() && record.len() == self.length);
        if let Some(place) = number.checked_sub(self.in_file) {
            let first = place as usize * self.length;
            self.memory[first..first + self.length].copy_from_slice(record);
            return Ok(());
        }
        let Some(mut file) = self.file.as_ref() else {
            return Ok(());
        };
        file.seek(SeekFrom::Start(number * self.length as u64))
            .and_then(|_| file.write_all(record))
            .map_err(|error| self.failed(FileAction::Write, error))
    }

    /// Goes through all records from the first.
    pub fn read(&self) -> Records<'_> {
        Records {
            log: self,
            next: 0,
            chunk: Vec::new(),
            first: 0,
        }
    }

    fn failed(&self, action: FileAction, error: io::Error) -> FileError {
        FileError::new(&self.folder, action, error)
    }
}

/// The records of a log, one after the other.
#[derive(Debug)]
pub struct Records<'a> {
    log: &'a RecordLog,
    next: u64,
    /// What was read from the file last, and the number of its first record.
    chunk: Vec<u8>,
    first: u64,
}

impl Records<'_> {
    /// The next record; none after the last.
    ///
    /// # Errors
    /// The file cannot be read.
    #[expect(clippy::should_implement_trait, reason = "it lends")]
    pub fn next(&mut self) -> Result<Option<&[u8]>, FileError> {
        let (log, length) = (self.log, self.log.length);
        if self.next >= log.len() {
            return Ok(None);
        }
        let number = self.next;
        self.next += 1;
        if let Some(place) = number.checked_sub(log.in_file) {
            let first = place as usize * length;
            return Ok(Some(&log.memory[first..first + length]));
        }
        if number >= self.first + (self.chunk.len() / length) as u64 {
            self.fill(number)?;
        }
        let first = (number - self.first) as usize * length;
        Ok(Some(&self.chunk[first..first + length]))
    }

    fn fill(&mut self, number: u64) -> Result<(), FileError> {
        let (log, length) = (self.log, self.log.length);
        let Some(mut file) = log.file.as_ref() else {
            return Ok(());
        };
        let count = ((CHUNK / length).max(1) as u64).min(log.in_file - number);
        self.chunk.resize(count as usize * length, 0);
        self.first = number;
        file.seek(SeekFrom::Start(number * length as u64))
            .and_then(|_| file.read_exact(&mut self.chunk))
            .map_err(|error| log.failed(FileAction::Read, error))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scratch::Scratch;

    fn record(number: u64) -> [u8; 24] {
        let mut record = [number as u8; 24];
        record[..8].copy_from_slice(&number.to_le_bytes());
        record
    }

    fn numbers(log: &RecordLog) -> Vec<u64> {
        let mut numbers = Vec::new();
        let mut records = log.read();
        while let Some(bytes) = records.next().unwrap() {
            let number = u64::from_le_bytes(bytes[..8].try_into().unwrap());
            assert_eq!(bytes, record(number));
            numbers.push(number);
        }
        numbers
    }

    #[test]
    fn records_come_back_in_order_as_often_as_asked() {
        let folder = Scratch::new();
        for count in [0_u64, 1, 1000, 43_690, 43_691, 200_000] {
            let mut log = RecordLog::new(folder.root(), 24);
            for number in 0..count {
                log.push(&record(number)).unwrap();
            }
            assert_eq!((log.len(), log.is_empty()), (count, count == 0));
            assert!(log.memory.len() < IN_MEMORY && log.memory.capacity() <= 2 * IN_MEMORY);
            let expected: Vec<u64> = (0..count).collect();
            assert_eq!(numbers(&log), expected);
            // Two readers side by side, and more records after them.
            let (mut one, mut other) = (log.read(), log.read());
            for _ in 0..count.min(5000) {
                assert_eq!(one.next().unwrap(), other.next().unwrap());
            }
            log.push(&record(count)).unwrap();
            assert_eq!(numbers(&log).last(), Some(&count));
        }
        assert_eq!(std::fs::read_dir(folder.root()).unwrap().count(), 0);
    }

    #[test]
    fn records_are_replaced_wherever_they_are() {
        let folder = Scratch::new();
        let mut log = RecordLog::new(folder.root(), 24);
        for number in 0..100_000 {
            log.push(&record(number)).unwrap();
        }
        let mut expected: Vec<u64> = (0..100_000).collect();
        for number in [0, 1, 43_689, 43_690, 43_691, 87_381, 99_999] {
            log.replace(number, &record(number + 7_000_000)).unwrap();
            expected[number as usize] += 7_000_000;
        }
        log.push(&record(100_000)).unwrap();
        expected.push(100_000);
        assert_eq!(numbers(&log), expected);
    }

    #[test]
    fn a_folder_that_is_not_there_is_told_when_it_is_needed() {
        let mut log = RecordLog::new("/nowhere/at/all", 1 << 18);
        let record = vec![0; 1 << 18];
        let few: Result<(), FileError> = (0..3).try_for_each(|_| log.push(&record));
        assert!(few.is_ok());
        let told = log.push(&record).unwrap_err().to_string();
        assert!(told.contains("/nowhere/at/all"), "{told}");
    }
}
