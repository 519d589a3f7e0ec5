//! NPZ: a ZIP archive of arrays, stored without compression, written front to back in flat memory.

use std::collections::BTreeSet;
use std::io::{self, Write};
use std::marker::PhantomData;
use std::path::{Path, PathBuf};

use crc32fast::Hasher;
use rawzip::path::EntryPath;
use rawzip::{DataDescriptorOutput, ErrorKind, ZipArchiveWriter, ZipEntryWriter};

use super::error::TableError;
use super::npy::{self, Element, Kind};
use super::spool::Spool;
use super::table::{Column, Values, check_name};
use crate::atomic_file::AtomicFile;
use crate::error::{Error, FileAction, FileError};

/// Bytes gathered before they are summed and handed to the file.
const CHUNK: usize = 1 << 16;

/// Writes arrays one after the other; the file appears when [`NpzWriter::finish`] is called.
pub struct NpzWriter {
    path: PathBuf,
    zip: ZipArchiveWriter<AtomicFile>,
    names: BTreeSet<String>,
    unfinished: Option<String>,
}

impl NpzWriter {
    /// Starts an archive at `path`, whose folder must exist.
    pub fn create(path: impl AsRef<Path>) -> Result<Self, FileError> {
        Ok(NpzWriter {
            path: path.as_ref().to_path_buf(),
            zip: ZipArchiveWriter::new(AtomicFile::create(path)?),
            names: BTreeSet::new(),
            unfinished: None,
        })
    }

    /// Writes a one-dimensional array.
    pub fn array<T: Element>(&mut self, name: &str, values: &[T]) -> Result<(), Error> {
        self.stream(name, values.len() as u64, values.iter().copied())
    }

    /// Writes a one-dimensional array of `count` values from an iterator, in flat memory.
    ///
    /// # Errors
    /// There are more or fewer values than `count`.
    pub fn stream<T: Element>(
        &mut self,
        name: &str,
        count: u64,
        values: impl IntoIterator<Item = T>,
    ) -> Result<(), Error> {
        let mut array = self.begin(name, count)?;
        array.extend(values)?;
        array.finish()
    }

    /// Writes a one-dimensional array that has waited on disk.
    pub fn spooled<T: Element>(&mut self, name: &str, values: Spool<T>) -> Result<(), Error> {
        let mut array = self.begin(name, values.len())?;
        values.read(|value| array.push(value))?;
        array.finish()
    }

    /// Begins a one-dimensional array of `count` values that come piece by piece.
    pub fn begin<T: Element>(
        &mut self,
        name: &str,
        count: u64,
    ) -> Result<ArrayWriter<'_, T>, Error> {
        Ok(ArrayWriter {
            entry: self.begin_entry(name, T::KIND, &[count])?,
            expected: count,
            count: 0,
            buffer: Vec::with_capacity(CHUNK + 8),
            element: PhantomData,
        })
    }

    /// Writes a scalar text array (`str(file["name"])` in Python).
    pub fn text(&mut self, name: &str, text: &str) -> Result<(), Error> {
        self.put_texts(name, &[text], &[])
    }

    /// Writes a one-dimensional text array.
    pub fn texts<S: AsRef<str>>(&mut self, name: &str, texts: &[S]) -> Result<(), Error> {
        self.put_texts(name, texts, &[texts.len() as u64])
    }

    /// Writes a one-dimensional array of `count` texts of at most `width` characters from an iterator, in flat memory.
    ///
    /// Longer texts are cut, as in NumPy.
    pub fn stream_texts<S: AsRef<str>>(
        &mut self,
        name: &str,
        width: usize,
        count: u64,
        texts: impl IntoIterator<Item = Result<S, Error>>,
    ) -> Result<(), Error> {
        self.put_cells(name, width, &[count], texts)
    }

    /// Writes a column under its name.
    pub fn column(&mut self, column: &Column) -> Result<(), Error> {
        match &column.values {
            Values::Floats(v) => self.array(&column.name, v),
            Values::Integers(v) => self.array(&column.name, v),
            Values::Texts(v) => self.texts(&column.name, v),
        }
    }

    fn put_texts<S: AsRef<str>>(
        &mut self,
        name: &str,
        texts: &[S],
        shape: &[u64],
    ) -> Result<(), Error> {
        let longest = texts.iter().map(|t| t.as_ref().chars().count()).max();
        let cells = texts.iter().map(|text| Ok(text.as_ref()));
        self.put_cells(name, longest.unwrap_or(0), shape, cells)
    }

    fn put_cells<S: AsRef<str>>(
        &mut self,
        name: &str,
        width: usize,
        shape: &[u64],
        texts: impl IntoIterator<Item = Result<S, Error>>,
    ) -> Result<(), Error> {
        // NumPy reads back a width of zero as one, so one is the least.
        let width = width.max(1);
        let mut entry = self.begin_entry(name, Kind::Text { width }, shape)?;
        let mut count = 0;
        let mut cells = Vec::with_capacity(CHUNK);
        for text in texts {
            let start = cells.len();
            for c in text?.as_ref().chars().take(width) {
                cells.extend_from_slice(&u32::from(c).to_le_bytes());
            }
            cells.resize(start + 4 * width, 0);
            if cells.len() >= CHUNK {
                entry.put(&cells)?;
                cells.clear();
            }
            count += 1;
        }
        entry.put(&cells)?;
        entry.finish(shape.iter().product(), count)
    }

    /// Writes the directory and puts the file in its place.
    pub fn finish(mut self) -> Result<(), Error> {
        self.none_unfinished()?;
        let file = self.zip.finish();
        Ok(file.map_err(|e| failed(&self.path, e))?.commit()?)
    }

    fn none_unfinished(&mut self) -> Result<(), TableError> {
        match self.unfinished.take() {
            Some(name) => Err(TableError::Unfinished { name }),
            None => Ok(()),
        }
    }

    fn begin_entry(
        &mut self,
        name: &str,
        kind: Kind,
        shape: &[u64],
    ) -> Result<EntryWriter<'_>, Error> {
        self.none_unfinished()?;
        check_name(name)?;
        let place = path_of(name)?;
        if !self.names.insert(name.to_string()) {
            return Err(TableError::DuplicateName {
                name: name.to_string(),
            }
            .into());
        }
        self.unfinished = Some(name.to_string());
        let failed = |error| failed(&self.path, error);
        let builder = self.zip.new_file(place);
        let (data, _) = builder.start().map_err(failed)?;
        let mut entry = EntryWriter {
            path: &self.path,
            unfinished: &mut self.unfinished,
            data,
            sum: Hasher::new(),
        };
        entry.put(&npy::header(kind, shape))?;
        Ok(entry)
    }
}

/// Where an array stands in its archive. What is not ASCII has to be marked as UTF-8, which `rawzip` does with names that it
/// may change: it takes what stands before a colon for the letter of a drive.
fn path_of(name: &str) -> Result<EntryPath<'static>, TableError> {
    let file = format!("{name}.npy");
    if name.is_ascii() {
        return Ok(EntryPath::verbatim(file.into_bytes()));
    }
    if name.contains(':') {
        let name = name.to_string();
        return Err(TableError::BadName { name });
    }
    Ok(EntryPath::conformant(file))
}

fn failed(path: &Path, error: rawzip::Error) -> Error {
    let error = match error.into_kind() {
        ErrorKind::IO(error) => error,
        other => io::Error::other(other.to_string()),
    };
    FileError::new(path, FileAction::Write, error).into()
}

/// One entry of the archive, as it is written.
struct EntryWriter<'a> {
    path: &'a Path,
    unfinished: &'a mut Option<String>,
    data: ZipEntryWriter<'a, AtomicFile>,
    sum: Hasher,
}

impl EntryWriter<'_> {
    fn put(&mut self, bytes: &[u8]) -> Result<(), FileError> {
        self.sum.update(bytes);
        let written = self.data.write_all(bytes);
        written.map_err(|error| FileError::new(self.path, FileAction::Write, error))
    }

    /// Ends the entry, if it has as many values as its header says.
    fn finish(self, expected: u64, count: u64) -> Result<(), Error> {
        if count != expected {
            let name = self.unfinished.clone().unwrap_or_default();
            return Err(TableError::OtherCount {
                name,
                expected,
                count,
            }
            .into());
        }
        let sum = DataDescriptorOutput::new(self.sum.finalize(), self.data.compressed_bytes());
        let ended = self.data.finish(sum);
        ended.map_err(|error| failed(self.path, error))?;
        *self.unfinished = None;
        Ok(())
    }
}

/// Takes the values of one array, as many as were told at its begin.
pub struct ArrayWriter<'a, T: Element> {
    entry: EntryWriter<'a>,
    expected: u64,
    count: u64,
    buffer: Vec<u8>,
    element: PhantomData<T>,
}

impl<T: Element> ArrayWriter<'_, T> {
    /// Appends one value.
    pub fn push(&mut self, value: T) -> Result<(), Error> {
        value.put(&mut self.buffer);
        self.count += 1;
        if self.buffer.len() >= CHUNK {
            self.entry.put(&self.buffer)?;
            self.buffer.clear();
        }
        Ok(())
    }

    /// Appends values.
    pub fn extend(&mut self, values: impl IntoIterator<Item = T>) -> Result<(), Error> {
        values.into_iter().try_for_each(|v| self.push(v))
    }

    /// Ends the array.
    ///
    /// # Errors
    /// There were more or fewer values than told at its begin.
    pub fn finish(mut self) -> Result<(), Error> {
        self.entry.put(&self.buffer)?;
        self.entry.finish(self.expected, self.count)
    }
}
