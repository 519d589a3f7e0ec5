//! Reads NPZ archives, stored, as this crate and `numpy.savez` write them, or compressed, as `numpy.savez_compressed` does.

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use super::error::TableError;
use super::inflate::{Inflated, LARGEST_RATIO};
use super::npy::{self, ArrayInfo, Kind, PREFIX_LENGTH};
use super::table::{Column, Values};
use crate::crc32::Crc32;
use crate::error::{Error, FileAction, FileError};

/// Bytes read at a time.
const CHUNK: usize = 1 << 16;

/// Most characters of a text, which has to be in memory as a whole: longer than any model's.
const LONGEST_TEXT: usize = 1 << 24;

struct Entry {
    info: ArrayInfo,
    packed: Packed,
    /// How long the array's header is.
    header_length: usize,
    checksum: u32,
}

/// Where the bytes of an array begin, how many there are in the file, and how they are kept.
#[derive(Clone, Copy)]
struct Packed {
    at: u64,
    length: u64,
    packing: Packing,
}

/// The format's methods 0 and 8.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Packing {
    Stored,
    Deflated,
}

/// An open archive. Arrays are read when asked for, and their checksums verified.
pub struct NpzReader {
    path: PathBuf,
    entries: Vec<Entry>,
}

impl NpzReader {
    /// Opens an archive and reads its directory and the headers of its arrays.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref().to_path_buf();
        let mut source = Source::open(&path)?;
        let entries = source.entries()?;
        Ok(NpzReader { path, entries })
    }

    /// Name, kind and shape of each array, in the file's order.
    pub fn arrays(&self) -> impl Iterator<Item = &ArrayInfo> {
        self.entries.iter().map(|e| &e.info)
    }

    /// Whether there is an array of this name.
    pub fn contains(&self, name: &str) -> bool {
        self.arrays().any(|a| a.name == name)
    }

    /// Name, kind and shape of one array.
    pub fn info(&self, name: &str) -> Result<&ArrayInfo, Error> {
        Ok(&self.entry(name)?.info)
    }

    /// The values of a column, whatever their kind; truth values as integers.
    pub fn column(&self, name: &str) -> Result<Column, Error> {
        let values = match self.entry(name)?.info.kind {
            Kind::Float => Values::Floats(self.floats(name)?),
            Kind::Integer => Values::Integers(self.integers(name)?),
            Kind::Boolean => {
                let bytes = self.bytes(name, Kind::Boolean)?;
                Values::Integers(bytes.iter().map(|&byte| i64::from(byte != 0)).collect())
            }
            Kind::Text { .. } => Values::Texts(self.texts(name)?),
        };
        Ok(Column {
            name: name.to_string(),
            values,
        })
    }

    /// An array as numbers, row after row; integers and truth values are converted.
    pub fn floats(&self, name: &str) -> Result<Vec<f64>, Error> {
        self.stream_floats(name)?.collect()
    }

    /// An array as numbers, one after the other in flat memory; integers and truth values are converted.
    ///
    /// The checksum is verified when the last number has been read.
    pub fn stream_floats(&self, name: &str) -> Result<FloatStream, Error> {
        let entry = self.entry(name)?;
        if matches!(entry.info.kind, Kind::Text { .. }) {
            return Err(self.wrong_kind(entry, Kind::Float));
        }
        Ok(FloatStream {
            kind: entry.info.kind,
            bytes: ArrayBytes::open(self, entry)?,
            chunk: Vec::new(),
            at: 0,
            remaining: entry.info.len(),
        })
    }

    /// An array of integers, row after row.
    pub fn integers(&self, name: &str) -> Result<Vec<i64>, Error> {
        let bytes = self.bytes(name, Kind::Integer)?;
        Ok(bytes
            .as_chunks()
            .0
            .iter()
            .map(|b| i64::from_le_bytes(*b))
            .collect())
    }

    /// An array of texts; a scalar is an array of one.
    pub fn texts(&self, name: &str) -> Result<Vec<String>, Error> {
        self.stream_texts(name)?.collect()
    }

    /// An array of texts, one after the other in flat memory.
    ///
    /// The checksum is verified when the last one has been read.
    pub fn stream_texts(&self, name: &str) -> Result<TextStream, Error> {
        let entry = self.entry(name)?;
        let Kind::Text { width } = entry.info.kind else {
            return Err(self.wrong_kind(entry, Kind::Text { width: 0 }));
        };
        if width > LONGEST_TEXT {
            let what = format!(
                "the texts of array `{name}` have {width} characters, more than {LONGEST_TEXT}"
            );
            return Err(malformed(&self.path, what));
        }
        Ok(TextStream {
            width: 4 * width,
            remaining: entry.info.len(),
            bytes: ArrayBytes::open(self, entry)?,
            pending: Vec::new(),
            at: 0,
        })
    }

    /// A scalar text entry.
    pub fn text(&self, name: &str) -> Result<String, Error> {
        let mut texts = self.stream_texts(name)?;
        match (texts.remaining, texts.next()) {
            (1, Some(text)) => text,
            (n, _) => Err(malformed(
                &self.path,
                format!("array `{name}` holds {n} texts, where one was expected"),
            )),
        }
    }

    fn entry(&self, name: &str) -> Result<&Entry, Error> {
        self.entries
            .iter()
            .find(|e| e.info.name == name)
            .ok_or_else(|| {
                TableError::NoSuchArray {
                    path: self.path.clone(),
                    name: name.to_string(),
                    known: self.arrays().map(|a| a.name.clone()).collect(),
                }
                .into()
            })
    }

    fn wrong_kind(&self, entry: &Entry, expected: Kind) -> Error {
        TableError::WrongKind {
            path: self.path.clone(),
            name: entry.info.name.clone(),
            found: entry.info.kind,
            expected,
        }
        .into()
    }

    fn bytes(&self, name: &str, expected: Kind) -> Result<Vec<u8>, Error> {
        let entry = self.entry(name)?;
        if entry.info.kind != expected {
            return Err(self.wrong_kind(entry, expected));
        }
        let mut bytes = ArrayBytes::open(self, entry)?;
        let mut all = Vec::new();
        while bytes.next(&mut all)? {}
        Ok(all)
    }
}

/// The numbers of one array, read as they are asked for.
pub struct FloatStream {
    kind: Kind,
    bytes: ArrayBytes,
    chunk: Vec<u8>,
    at: usize,
    remaining: usize,
}

impl Iterator for FloatStream {
    type Item = Result<f64, Error>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.at == self.chunk.len() {
            self.chunk.clear();
            self.at = 0;
            match self.bytes.next(&mut self.chunk) {
                Ok(true) => {}
                Ok(false) => return None,
                Err(e) => {
                    self.remaining = 0;
                    return Some(Err(e));
                }
            }
        }
        let size = self.kind.size();
        let cell = &self.chunk[self.at..self.at + size];
        self.at += size;
        self.remaining = self.remaining.saturating_sub(1);
        Some(Ok(match self.kind {
            Kind::Float => f64::from_le_bytes(cell.try_into().expect("eight bytes")),
            Kind::Integer => i64::from_le_bytes(cell.try_into().expect("eight bytes")) as f64,
            Kind::Boolean | Kind::Text { .. } => f64::from(u8::from(cell[0] != 0)),
        }))
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        (0, Some(self.remaining))
    }
}

/// The texts of one array, read as they are asked for.
pub struct TextStream {
    /// Bytes of a text.
    width: usize,
    remaining: usize,
    bytes: ArrayBytes,
    pending: Vec<u8>,
    at: usize,
}

impl TextStream {
    fn read(&mut self) -> Result<String, Error> {
        while self.pending.len() - self.at < self.width {
            self.pending.drain(..self.at);
            self.at = 0;
            if !self.bytes.next(&mut self.pending)? {
                let what = format!("array `{}` is cut short", self.bytes.name);
                return Err(malformed(&self.bytes.path, what));
            }
        }
        let cell = &self.pending[self.at..self.at + self.width];
        self.at += self.width;
        let codes = cell.as_chunks().0.iter().map(|b| u32::from_le_bytes(*b));
        let text: Option<String> = codes.map(char::from_u32).collect();
        let text = text.ok_or_else(|| {
            let what = format!("array `{}` holds what is no character", self.bytes.name);
            malformed(&self.bytes.path, what)
        })?;
        if self.remaining == 0 {
            // Nothing more is there: this verifies the checksum.
            self.bytes.next(&mut Vec::new())?;
        }
        Ok(text.trim_end_matches('\0').to_string())
    }
}

impl Iterator for TextStream {
    type Item = Result<String, Error>;

    fn next(&mut self) -> Option<Self::Item> {
        self.remaining = self.remaining.checked_sub(1)?;
        let text = self.read();
        if text.is_err() {
            self.remaining = 0;
        }
        Some(text)
    }
}

/// The data of one array in chunks, with its checksum verified at the end. After an error there is nothing more.
struct ArrayBytes {
    path: PathBuf,
    name: String,
    file: Box<dyn Read + Send>,
    remaining: u64,
    sum: Crc32,
    checksum: Option<u32>,
}

impl ArrayBytes {
    fn open(reader: &NpzReader, entry: &Entry) -> Result<Self, Error> {
        let mut file = Source::open(&reader.path)?.unpacked(entry.packed)?;
        let mut header = vec![0; entry.header_length];
        file.read_exact(&mut header)
            .map_err(|e| FileError::new(&reader.path, FileAction::Read, e))?;
        let mut sum = Crc32::default();
        sum.update(&header);
        Ok(ArrayBytes {
            path: reader.path.clone(),
            name: entry.info.name.clone(),
            file,
            remaining: (entry.info.len() * entry.info.kind.size()) as u64,
            sum,
            checksum: Some(entry.checksum),
        })
    }

    /// Appends the next chunk; `false` when there is none.
    fn next(&mut self, into: &mut Vec<u8>) -> Result<bool, Error> {
        let start = into.len();
        let wanted = self.remaining.min(CHUNK as u64) as usize;
        into.resize(start + wanted, 0);
        if let Err(e) = self.file.read_exact(&mut into[start..]) {
            (self.remaining, self.checksum) = (0, None);
            return Err(FileError::new(&self.path, FileAction::Read, e).into());
        }
        self.sum.update(&into[start..]);
        self.remaining -= wanted as u64;
        if self.remaining == 0
            && let Some(checksum) = self.checksum.take()
            && checksum != self.sum.sum()
        {
            return Err(malformed(
                &self.path,
                format!("array `{}` is damaged: its checksum differs", self.name),
            ));
        }
        Ok(wanted > 0)
    }
}

fn malformed(path: &Path, what: impl Into<String>) -> Error {
    TableError::Malformed {
        path: path.to_path_buf(),
        what: what.into(),
    }
    .into()
}

/// The archive as a file: signatures and offsets of the ZIP format (APPNOTE 6.3).
struct Source {
    path: PathBuf,
    file: BufReader<File>,
    length: u64,
}

fn u16_at(bytes: &[u8], at: usize) -> u64 {
    u64::from(u16::from_le_bytes([bytes[at], bytes[at + 1]]))
}

fn u32_at(bytes: &[u8], at: usize) -> u64 {
    u64::from(u32::from_le_bytes([
        bytes[at],
        bytes[at + 1],
        bytes[at + 2],
        bytes[at + 3],
    ]))
}

fn u64_at(bytes: &[u8], at: usize) -> u64 {
    u32_at(bytes, at) | (u32_at(bytes, at + 4) << 32)
}

impl Source {
    fn open(path: &Path) -> Result<Self, Error> {
        let opened = File::open(path).and_then(|f| {
            let length = f.metadata()?.len();
            Ok((f, length))
        });
        let (file, length) = opened.map_err(|e| FileError::new(path, FileAction::Open, e))?;
        Ok(Source {
            path: path.to_path_buf(),
            file: BufReader::with_capacity(CHUNK, file),
            length,
        })
    }

    fn malformed(&self, what: impl Into<String>) -> Error {
        malformed(&self.path, what)
    }

    fn bytes_at(&mut self, at: u64, length: usize) -> Result<Vec<u8>, Error> {
        if at
            .checked_add(length as u64)
            .is_none_or(|end| end > self.length)
        {
            return Err(self.malformed("it is cut short"));
        }
        let mut bytes = vec![0; length];
        self.file
            .seek(SeekFrom::Start(at))
            .and_then(|_| self.file.read_exact(&mut bytes))
            .map_err(|e| FileError::new(&self.path, FileAction::Read, e))?;
        Ok(bytes)
    }

    /// Number of entries, and where the directory begins and how long it is.
    fn directory(&mut self) -> Result<(u64, u64, u64), Error> {
        const END: usize = 22;
        const LONGEST_COMMENT: u64 = 0xFFFF;
        let tail_length = self.length.min(END as u64 + LONGEST_COMMENT) as usize;
        let tail_at = self.length - tail_length as u64;
        let tail = self.bytes_at(tail_at, tail_length)?;
        let end = (0..=tail_length.saturating_sub(END))
            .rev()
            .find(|&k| tail[k..].starts_with(b"PK\x05\x06") && tail.len() - k >= END)
            .ok_or_else(|| self.malformed("it has no ZIP directory"))?;
        let record = &tail[end..];
        let (count, size, start) = (u16_at(record, 10), u32_at(record, 12), u32_at(record, 16));
        if count < 0xFFFF && size < 0xFFFF_FFFF && start < 0xFFFF_FFFF {
            return Ok((count, start, size));
        }
        let locator_at = (tail_at + end as u64)
            .checked_sub(20)
            .ok_or_else(|| self.malformed("it is cut short"))?;
        let locator = self.bytes_at(locator_at, 20)?;
        if !locator.starts_with(b"PK\x06\x07") {
            return Ok((count, start, size));
        }
        let record = self.bytes_at(u64_at(&locator, 8), 56)?;
        if !record.starts_with(b"PK\x06\x06") {
            return Err(self.malformed("its 64-bit directory is not where it should be"));
        }
        Ok((
            u64_at(&record, 32),
            u64_at(&record, 48),
            u64_at(&record, 40),
        ))
    }

    fn entries(&mut self) -> Result<Vec<Entry>, Error> {
        let (count, start, size) = self.directory()?;
        let size =
            usize::try_from(size).map_err(|_| self.malformed("its directory is too large"))?;
        let directory = self.bytes_at(start, size)?;
        let mut rest = directory.as_slice();
        let mut entries = Vec::new();
        for _ in 0..count {
            let cut = || malformed(&self.path, "its directory is cut short");
            if rest.len() < 46 || !rest.starts_with(b"PK\x01\x02") {
                return Err(cut());
            }
            let name_length = u16_at(rest, 28) as usize;
            let extra_length = u16_at(rest, 30) as usize;
            let total = 46 + name_length + extra_length + u16_at(rest, 32) as usize;
            if rest.len() < total {
                return Err(cut());
            }
            let name = String::from_utf8_lossy(&rest[46..46 + name_length]).into_owned();
            let extra = &rest[46 + name_length..46 + name_length + extra_length];
            let mut stored = u32_at(rest, 20);
            let mut original = u32_at(rest, 24);
            let mut offset = u32_at(rest, 42);
            extended([&mut original, &mut stored, &mut offset], extra);
            let (method, checksum) = (u16_at(rest, 10), u32_at(rest, 16) as u32);
            rest = &rest[total..];
            let Some(name) = name.strip_suffix(".npy") else {
                continue;
            };
            let packing = match method {
                0 => Packing::Stored,
                8 => Packing::Deflated,
                _ => {
                    return Err(self.malformed(format!(
                        "array `{name}` is compressed by method {method}, which is not read"
                    )));
                }
            };
            entries.push(self.array(name, (offset, stored, packing), original, checksum)?);
        }
        Ok(entries)
    }

    /// The bytes of an array, unpacked.
    fn unpacked(mut self, packed: Packed) -> Result<Box<dyn Read + Send>, Error> {
        self.file
            .seek(SeekFrom::Start(packed.at))
            .map_err(|e| FileError::new(&self.path, FileAction::Read, e))?;
        let bytes = self.file.take(packed.length);
        Ok(match packed.packing {
            Packing::Stored => Box::new(bytes),
            Packing::Deflated => Box::new(Inflated::new(bytes)),
        })
    }

    fn array(
        &mut self,
        name: &str,
        (offset, stored, packing): (u64, u64, Packing),
        original: u64,
        checksum: u32,
    ) -> Result<Entry, Error> {
        let local = self.bytes_at(offset, 30)?;
        if !local.starts_with(b"PK\x03\x04") {
            return Err(self.malformed(format!("array `{name}` is not where the directory says")));
        }
        let packed = Packed {
            at: offset + 30 + u16_at(&local, 26) + u16_at(&local, 28),
            length: stored,
            packing,
        };
        let path = self.path.clone();
        let in_array = |what: String| malformed(&path, format!("array `{name}`: {what}"));
        let end = packed.at.checked_add(stored);
        if end.is_none_or(|end| end > self.length) {
            return Err(in_array("it is cut short".to_owned()));
        }
        // What is claimed is compared with what there is before memory or time is spent on it.
        let most = match packing {
            Packing::Stored => stored,
            Packing::Deflated => stored.saturating_mul(LARGEST_RATIO),
        };
        if original > most {
            return Err(in_array(format!(
                "{stored} bytes cannot hold the {original} that are claimed"
            )));
        }
        let mut bytes = Source::open(&self.path)?.unpacked(packed)?;
        let mut read = |into: &mut [u8]| {
            let read = bytes.read_exact(into);
            read.map_err(|e| in_array(e.to_string()))
        };
        let mut header = vec![0; PREFIX_LENGTH];
        read(&mut header)?;
        let prefix = header.as_slice().try_into().expect("read so many");
        let header_length = npy::header_length(prefix).map_err(&in_array)?;
        if header_length < PREFIX_LENGTH || header_length as u64 > original {
            return Err(in_array("its header is cut short".to_owned()));
        }
        header.resize(header_length, 0);
        read(&mut header[PREFIX_LENGTH..])?;
        let (kind, shape) = npy::parse_header(&header).map_err(&in_array)?;
        let info = ArrayInfo {
            name: name.to_string(),
            kind,
            shape,
        };
        let size = ((info.len() * kind.size()) as u64).saturating_add(header_length as u64);
        if size != original {
            return Err(in_array(format!(
                "{size} bytes were expected, {original} are stored"
            )));
        }
        Ok(Entry {
            info,
            packed,
            header_length,
            checksum,
        })
    }
}

/// Replaces those fields that say "see the 64-bit extra field", in the format's order.
fn extended(fields: [&mut u64; 3], mut extra: &[u8]) {
    while extra.len() >= 4 {
        let (id, length) = (u16_at(extra, 0), u16_at(extra, 2) as usize);
        let Some(body) = extra.get(4..4 + length) else {
            return;
        };
        if id == 1 {
            let mut values = body.chunks_exact(8).map(|b| u64_at(b, 0));
            for field in fields {
                if *field == 0xFFFF_FFFF
                    && let Some(value) = values.next()
                {
                    *field = value;
                }
            }
            return;
        }
        extra = &extra[4 + length..];
    }
}
