//! Reads NPZ archives, stored, as this crate and `numpy.savez` write them, or compressed, as `numpy.savez_compressed` does.

use std::path::Path;

use super::archive::{Archive, Entry, malformed};
use super::array_stream::{ArrayBytes, FloatStream, TextStream};
use super::error::TableError;
use super::npy::{ArrayInfo, Kind};
use super::table::{Column, Values};
use crate::error::Error;

/// Most characters of a text, which has to be in memory as a whole: longer than any model's.
const LONGEST_TEXT: usize = 1 << 24;

/// An open archive. Arrays are read when asked for, and their checksums verified.
pub struct NpzReader {
    archive: Archive,
    entries: Vec<Entry>,
}

impl NpzReader {
    /// Opens an archive and reads its directory and the headers of its arrays.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Error> {
        let archive = Archive::open(path.as_ref())?;
        let entries = archive.entries()?;
        Ok(NpzReader { archive, entries })
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
        Ok(FloatStream::new(ArrayBytes::open(&self.archive, entry)?))
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
            return Err(malformed(&self.archive.path, what));
        }
        Ok(TextStream::new(ArrayBytes::open(&self.archive, entry)?))
    }

    /// A scalar text entry.
    pub fn text(&self, name: &str) -> Result<String, Error> {
        let mut texts = self.stream_texts(name)?;
        match (texts.len(), texts.next()) {
            (1, Some(text)) => text,
            (n, _) => Err(malformed(
                &self.archive.path,
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
                    path: self.archive.path.clone(),
                    name: name.to_string(),
                    known: self.arrays().map(|a| a.name.clone()).collect(),
                }
                .into()
            })
    }

    fn wrong_kind(&self, entry: &Entry, expected: Kind) -> Error {
        TableError::WrongKind {
            path: self.archive.path.clone(),
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
        let mut bytes = ArrayBytes::open(&self.archive, entry)?;
        let mut all = Vec::new();
        while bytes.next(&mut all)? {}
        Ok(all)
    }
}
