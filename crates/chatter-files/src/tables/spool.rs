//! A column that waits on disk until its archive is written: in flat memory, and gone with the process.

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::marker::PhantomData;
use std::path::{Path, PathBuf};

use super::npy::Element;
use crate::error::{Error, FileAction, FileError};

/// Values of one column, appended one after the other.
#[derive(Debug)]
pub struct Spool<T> {
    folder: PathBuf,
    file: BufWriter<File>,
    count: u64,
    bytes: Vec<u8>,
    element: PhantomData<T>,
}

impl<T: Element> Spool<T> {
    /// An empty one on the disk of `folder`.
    ///
    /// # Errors
    /// The file cannot be created.
    pub fn create(folder: impl AsRef<Path>) -> Result<Self, FileError> {
        let folder = folder.as_ref().to_path_buf();
        match tempfile::tempfile_in(&folder) {
            Ok(file) => Ok(Self {
                folder,
                file: BufWriter::with_capacity(1 << 16, file),
                count: 0,
                bytes: Vec::new(),
                element: PhantomData,
            }),
            Err(error) => Err(FileError::new(folder, FileAction::Create, error)),
        }
    }

    /// Appends a value.
    ///
    /// # Errors
    /// The file cannot be written, as when the disk is full.
    pub fn push(&mut self, value: T) -> Result<(), FileError> {
        self.bytes.clear();
        value.put(&mut self.bytes);
        let written = self.file.write_all(&self.bytes);
        written.map_err(|error| self.error(FileAction::Write, error))?;
        self.count += 1;
        Ok(())
    }

    /// How many values there are.
    pub fn len(&self) -> u64 {
        self.count
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Goes through the values in order.
    ///
    /// # Errors
    /// The file cannot be read, or `visit` fails.
    pub fn read(self, mut visit: impl FnMut(T) -> Result<(), Error>) -> Result<(), Error> {
        let Self {
            folder,
            file,
            count,
            ..
        } = self;
        let fail = |action| {
            let folder = folder.clone();
            move |error| FileError::new(folder, action, error)
        };
        let mut file = file
            .into_inner()
            .map_err(|error| fail(FileAction::Write)(error.into_error()))?;
        file.seek(SeekFrom::Start(0))
            .map_err(fail(FileAction::Read))?;
        let mut reader = BufReader::with_capacity(1 << 16, file);
        let mut bytes = vec![0; T::KIND.size()];
        for _ in 0..count {
            reader
                .read_exact(&mut bytes)
                .map_err(fail(FileAction::Read))?;
            visit(T::take(&bytes))?;
        }
        Ok(())
    }

    fn error(&self, action: FileAction, error: io::Error) -> FileError {
        FileError::new(&self.folder, action, error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scratch::Scratch;

    #[test]
    fn values_come_back_in_order_and_nothing_is_left() {
        let folder = Scratch::new();
        let mut floats = Spool::create(folder.root()).unwrap();
        let mut integers = Spool::create(folder.root()).unwrap();
        for k in 0..100_000_i64 {
            floats.push(k as f64 * 0.1).unwrap();
            integers.push(-k).unwrap();
        }
        let mut next = 0;
        floats
            .read(|value| {
                assert_eq!(value, next as f64 * 0.1);
                next += 1;
                Ok(())
            })
            .unwrap();
        assert_eq!((next, integers.len()), (100_000, 100_000));
        let mut sum = 0;
        integers
            .read(|value| {
                sum += value;
                Ok(())
            })
            .unwrap();
        assert_eq!(sum, -100_000 * 99_999 / 2);
        assert_eq!(std::fs::read_dir(folder.root()).unwrap().count(), 0);
    }
}
