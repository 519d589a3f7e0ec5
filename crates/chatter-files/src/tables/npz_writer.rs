//! NPZ: a ZIP archive of arrays, stored without compression, written front to back in flat memory.

use std::collections::BTreeSet;
use std::io::{Seek, SeekFrom, Write};
use std::marker::PhantomData;
use std::path::Path;

use super::error::TableError;
use super::npy::{self, Element, Kind};
use super::spool::Spool;
use super::table::{Column, Values, check_name};
use crate::atomic_file::AtomicFile;
use crate::crc32::Crc32;
use crate::error::{Error, FileError};

/// Bytes gathered before they are summed and handed to the file.
const CHUNK: usize = 1 << 16;
/// ZIP version that knows 64-bit sizes.
const VERSION: u16 = 45;
/// First of January 1980, the earliest date a ZIP can hold: equal input gives equal bytes.
const DATE: u16 = 0x0021;
/// Sizes and offsets from here on stand in the 64-bit extra field.
const LIMIT_32: u64 = 0xFFFF_FFFF;

struct Entry {
    name: String,
    sum: Crc32,
    offset: u64,
}

/// Writes arrays one after the other; the file appears when [`NpzWriter::finish`] is called.
pub struct NpzWriter {
    file: AtomicFile,
    position: u64,
    entries: Vec<Entry>,
    names: BTreeSet<String>,
    unfinished: Option<String>,
}

impl NpzWriter {
    /// Starts an archive at `path`, whose folder must exist.
    pub fn create(path: impl AsRef<Path>) -> Result<Self, FileError> {
        Ok(NpzWriter {
            file: AtomicFile::create(path)?,
            position: 0,
            entries: Vec::new(),
            names: BTreeSet::new(),
            unfinished: None,
        })
    }

    /// Writes a one-dimensional array.
    pub fn array<T: Element>(&mut self, name: &str, values: &[T]) -> Result<(), Error> {
        let mut array = self.begin(name)?;
        array.extend(values.iter().copied())?;
        array.finish()
    }

    /// Writes a one-dimensional array from an iterator, of any length, in flat memory.
    pub fn stream<T: Element>(
        &mut self,
        name: &str,
        values: impl IntoIterator<Item = T>,
    ) -> Result<(), Error> {
        let mut array = self.begin(name)?;
        array.extend(values)?;
        array.finish()
    }

    /// Writes a one-dimensional array that has waited on disk.
    pub fn spooled<T: Element>(&mut self, name: &str, values: Spool<T>) -> Result<(), Error> {
        let mut array = self.begin(name)?;
        values.read(|value| array.push(value))?;
        array.finish()
    }

    /// Begins a one-dimensional array whose values come piece by piece; its length need not be known.
    pub fn begin<T: Element>(&mut self, name: &str) -> Result<ArrayWriter<'_, T>, Error> {
        let offset = self.begin_entry(name)?;
        let header = npy::header(T::KIND, &[0]);
        self.put(&header)?;
        self.unfinished = Some(name.to_string());
        Ok(ArrayWriter {
            writer: self,
            name: name.to_string(),
            offset,
            count: 0,
            buffer: Vec::with_capacity(CHUNK + 8),
            sum: Crc32::default(),
            element: PhantomData,
        })
    }

    /// Writes a scalar text array (`str(file["name"])` in Python).
    pub fn text(&mut self, name: &str, text: &str) -> Result<(), Error> {
        self.put_texts(name, &[text], &[])
    }

    /// Writes a one-dimensional text array.
    pub fn texts<S: AsRef<str>>(&mut self, name: &str, texts: &[S]) -> Result<(), Error> {
        self.put_texts(name, texts, &[texts.len()])
    }

    /// Writes a one-dimensional array of `count` texts of at most `width` characters from an iterator, in flat memory.
    ///
    /// Longer texts are cut, as in NumPy.
    pub fn stream_texts<S: AsRef<str>>(
        &mut self,
        name: &str,
        width: usize,
        count: usize,
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
        shape: &[usize],
    ) -> Result<(), Error> {
        let longest = texts.iter().map(|t| t.as_ref().chars().count()).max();
        let cells = texts.iter().map(|text| Ok(text.as_ref()));
        self.put_cells(name, longest.unwrap_or(0), shape, cells)
    }

    fn put_cells<S: AsRef<str>>(
        &mut self,
        name: &str,
        width: usize,
        shape: &[usize],
        texts: impl IntoIterator<Item = Result<S, Error>>,
    ) -> Result<(), Error> {
        // NumPy reads back a width of zero as one, so one is the least.
        let width = width.max(1);
        let offset = self.begin_entry(name)?;
        let mut sum = Crc32::default();
        let header = npy::header(Kind::Text { width }, shape);
        sum.update(&header);
        self.put(&header)?;
        let expected = shape.iter().product();
        let mut count = 0;
        let mut cell = Vec::with_capacity(4 * width);
        for text in texts {
            cell.clear();
            for c in text?.as_ref().chars().take(width) {
                cell.extend_from_slice(&u32::from(c).to_le_bytes());
            }
            cell.resize(4 * width, 0);
            sum.update(&cell);
            self.put(&cell)?;
            count += 1;
        }
        if count != expected {
            return Err(TableError::UnequalLengths {
                table: name.to_string(),
                first: ("shape".to_string(), expected),
                other: ("texts".to_string(), count),
            }
            .into());
        }
        self.end_entry(name, offset, sum)
    }

    /// Writes the directory and puts the file in its place.
    pub fn finish(mut self) -> Result<(), Error> {
        if let Some(name) = self.unfinished.take() {
            return Err(TableError::Unfinished { name }.into());
        }
        let start = self.position;
        for entry in std::mem::take(&mut self.entries) {
            let bytes = directory_entry(&entry);
            self.entries.push(entry);
            self.put(&bytes)?;
        }
        let end = end_of_archive(self.entries.len() as u64, start, self.position - start);
        self.put(&end)?;
        Ok(self.file.commit()?)
    }

    fn begin_entry(&mut self, name: &str) -> Result<u64, Error> {
        if let Some(name) = self.unfinished.take() {
            return Err(TableError::Unfinished { name }.into());
        }
        check_name(name)?;
        if !self.names.insert(name.to_string()) {
            return Err(TableError::DuplicateName {
                name: name.to_string(),
            }
            .into());
        }
        let offset = self.position;
        let header = local_header(name, Crc32::default());
        self.put(&header)?;
        Ok(offset)
    }

    fn end_entry(&mut self, name: &str, offset: u64, sum: Crc32) -> Result<(), Error> {
        let header = local_header(name, sum);
        self.overwrite(offset, &header)?;
        self.entries.push(Entry {
            name: name.to_string(),
            sum,
            offset,
        });
        Ok(())
    }

    fn put(&mut self, bytes: &[u8]) -> Result<(), FileError> {
        self.file
            .write_all(bytes)
            .map_err(|e| self.file.write_error(e))?;
        self.position += bytes.len() as u64;
        Ok(())
    }

    fn overwrite(&mut self, offset: u64, bytes: &[u8]) -> Result<(), FileError> {
        let end = self.position;
        let file = &mut self.file;
        file.seek(SeekFrom::Start(offset))
            .and_then(|_| file.write_all(bytes))
            .and_then(|()| file.seek(SeekFrom::Start(end)))
            .map_err(|e| self.file.write_error(e))?;
        Ok(())
    }
}

/// Takes the values of one array; [`ArrayWriter::finish`] writes its length into the header.
pub struct ArrayWriter<'a, T: Element> {
    writer: &'a mut NpzWriter,
    name: String,
    offset: u64,
    count: usize,
    buffer: Vec<u8>,
    sum: Crc32,
    element: PhantomData<T>,
}

impl<T: Element> ArrayWriter<'_, T> {
    /// Appends one value.
    pub fn push(&mut self, value: T) -> Result<(), Error> {
        value.put(&mut self.buffer);
        self.count += 1;
        if self.buffer.len() >= CHUNK {
            self.drain()?;
        }
        Ok(())
    }

    /// Appends values.
    pub fn extend(&mut self, values: impl IntoIterator<Item = T>) -> Result<(), Error> {
        values.into_iter().try_for_each(|v| self.push(v))
    }

    /// Ends the array.
    pub fn finish(mut self) -> Result<(), Error> {
        self.drain()?;
        let header = npy::header(T::KIND, &[self.count]);
        let mut sum = Crc32::default();
        sum.update(&header);
        let data_at = self.offset + local_header(&self.name, sum).len() as u64;
        self.writer.overwrite(data_at, &header)?;
        self.writer.unfinished = None;
        self.writer
            .end_entry(&self.name, self.offset, sum.then(self.sum))
    }

    fn drain(&mut self) -> Result<(), FileError> {
        self.sum.update(&self.buffer);
        self.writer.put(&self.buffer)?;
        self.buffer.clear();
        Ok(())
    }
}

/// Header before an entry's data; its sizes stand in the 64-bit extra field, since they are not known at first.
fn local_header(name: &str, sum: Crc32) -> Vec<u8> {
    let file_name = format!("{name}.npy");
    let mut h = Vec::with_capacity(64 + file_name.len());
    h.extend_from_slice(b"PK\x03\x04");
    h.extend_from_slice(&VERSION.to_le_bytes());
    h.extend_from_slice(&name_flags(name).to_le_bytes());
    h.extend_from_slice(&[0; 4]); // stored; midnight
    h.extend_from_slice(&DATE.to_le_bytes());
    h.extend_from_slice(&sum.sum().to_le_bytes());
    h.extend_from_slice(&[0xFF; 8]);
    h.extend_from_slice(&(file_name.len() as u16).to_le_bytes());
    h.extend_from_slice(&20u16.to_le_bytes());
    h.extend_from_slice(file_name.as_bytes());
    h.extend_from_slice(&[1, 0, 16, 0]);
    h.extend_from_slice(&sum.length().to_le_bytes());
    h.extend_from_slice(&sum.length().to_le_bytes());
    debug_assert_eq!(h.len(), 50 + file_name.len());
    h
}

/// The flag that a name is UTF-8.
fn name_flags(name: &str) -> u16 {
    if name.is_ascii() { 0 } else { 0x0800 }
}

fn directory_entry(entry: &Entry) -> Vec<u8> {
    let file_name = format!("{}.npy", entry.name);
    let size = entry.sum.length();
    let mut extra = Vec::new();
    if size >= LIMIT_32 {
        extra.extend_from_slice(&size.to_le_bytes());
        extra.extend_from_slice(&size.to_le_bytes());
    }
    if entry.offset >= LIMIT_32 {
        extra.extend_from_slice(&entry.offset.to_le_bytes());
    }
    if !extra.is_empty() {
        let length = extra.len() as u16;
        extra.splice(0..0, [1u16.to_le_bytes(), length.to_le_bytes()].concat());
    }
    let short = |n: u64| (n.min(LIMIT_32) as u32).to_le_bytes();
    let mut d = Vec::with_capacity(80 + file_name.len());
    d.extend_from_slice(b"PK\x01\x02");
    d.extend_from_slice(&VERSION.to_le_bytes());
    d.extend_from_slice(&VERSION.to_le_bytes());
    d.extend_from_slice(&name_flags(&entry.name).to_le_bytes());
    d.extend_from_slice(&[0; 4]);
    d.extend_from_slice(&DATE.to_le_bytes());
    d.extend_from_slice(&entry.sum.sum().to_le_bytes());
    d.extend_from_slice(&short(size));
    d.extend_from_slice(&short(size));
    d.extend_from_slice(&(file_name.len() as u16).to_le_bytes());
    d.extend_from_slice(&(extra.len() as u16).to_le_bytes());
    d.extend_from_slice(&[0; 10]); // no comment, first disk, no attributes
    d.extend_from_slice(&short(entry.offset));
    d.extend_from_slice(file_name.as_bytes());
    d.extend_from_slice(&extra);
    d
}

fn end_of_archive(count: u64, start: u64, size: u64) -> Vec<u8> {
    let mut e = Vec::new();
    if count >= 0xFFFF || start >= LIMIT_32 || size >= LIMIT_32 {
        e.extend_from_slice(b"PK\x06\x06");
        e.extend_from_slice(&44u64.to_le_bytes());
        e.extend_from_slice(&VERSION.to_le_bytes());
        e.extend_from_slice(&VERSION.to_le_bytes());
        e.extend_from_slice(&[0; 8]);
        for n in [count, count, size, start] {
            e.extend_from_slice(&n.to_le_bytes());
        }
        e.extend_from_slice(b"PK\x06\x07");
        e.extend_from_slice(&[0; 4]);
        e.extend_from_slice(&(start + size).to_le_bytes());
        e.extend_from_slice(&1u32.to_le_bytes());
    }
    e.extend_from_slice(b"PK\x05\x06");
    e.extend_from_slice(&[0; 4]);
    let count = (count.min(0xFFFF) as u16).to_le_bytes();
    e.extend_from_slice(&count);
    e.extend_from_slice(&count);
    e.extend_from_slice(&(size.min(LIMIT_32) as u32).to_le_bytes());
    e.extend_from_slice(&(start.min(LIMIT_32) as u32).to_le_bytes());
    e.extend_from_slice(&[0; 2]);
    e
}
