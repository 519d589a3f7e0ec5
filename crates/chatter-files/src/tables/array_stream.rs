//! The values of one array, read as they are asked for.

use std::io::Read;
use std::path::PathBuf;

use super::archive::{Archive, CHUNK, Entry, in_data, malformed};
use super::npy::Kind;
use crate::error::Error;

/// The numbers of one array, read as they are asked for.
pub struct FloatStream {
    bytes: ArrayBytes,
    chunk: Vec<u8>,
    at: usize,
    remaining: usize,
}

impl FloatStream {
    pub(super) fn new(bytes: ArrayBytes) -> Self {
        Self {
            remaining: bytes.count,
            bytes,
            chunk: Vec::new(),
            at: 0,
        }
    }
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
        let kind = self.bytes.kind;
        let cell = &self.chunk[self.at..self.at + kind.size()];
        self.at += kind.size();
        self.remaining = self.remaining.saturating_sub(1);
        Some(Ok(match kind {
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
    remaining: usize,
    bytes: ArrayBytes,
    pending: Vec<u8>,
    at: usize,
}

impl TextStream {
    pub(super) fn new(bytes: ArrayBytes) -> Self {
        Self {
            remaining: bytes.count,
            bytes,
            pending: Vec::new(),
            at: 0,
        }
    }

    /// How many texts are left.
    pub(super) fn len(&self) -> usize {
        self.remaining
    }

    fn read(&mut self) -> Result<String, Error> {
        let width = self.bytes.kind.size();
        while self.pending.len() - self.at < width {
            self.pending.drain(..self.at);
            self.at = 0;
            if !self.bytes.next(&mut self.pending)? {
                let what = format!("array `{}` is cut short", self.bytes.name);
                return Err(malformed(&self.bytes.path, what));
            }
        }
        let cell = &self.pending[self.at..self.at + width];
        self.at += width;
        let codes = cell.as_chunks().0.iter().map(|b| u32::from_le_bytes(*b));
        let text: Option<String> = codes.map(char::from_u32).collect();
        let text = text.ok_or_else(|| {
            let what = format!("array `{}` holds what is no character", self.bytes.name);
            malformed(&self.bytes.path, what)
        })?;
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

/// The data of one array in chunks; the last one is had only if the checksum agrees. After an error there is nothing more.
pub(super) struct ArrayBytes {
    path: PathBuf,
    name: String,
    kind: Kind,
    /// How many elements there are in all.
    count: usize,
    data: Box<dyn Read + Send>,
    /// Bytes that have not been read yet.
    remaining: u64,
}

impl ArrayBytes {
    pub(super) fn open(archive: &Archive, entry: &Entry) -> Result<Self, Error> {
        let (kind, count) = (entry.info.kind, entry.info.len());
        Ok(ArrayBytes {
            path: archive.path.clone(),
            name: entry.info.name.clone(),
            kind,
            count,
            data: archive.data(entry)?,
            remaining: (count * kind.size()) as u64,
        })
    }

    /// Appends the next chunk; `false` when there is none.
    pub(super) fn next(&mut self, into: &mut Vec<u8>) -> Result<bool, Error> {
        let start = into.len();
        let wanted = self.remaining.min(CHUNK as u64) as usize;
        into.resize(start + wanted, 0);
        if let Err(error) = self.data.read_exact(&mut into[start..]) {
            self.remaining = 0;
            return Err(in_data(&self.path, &self.name, error));
        }
        self.remaining -= wanted as u64;
        Ok(wanted > 0)
    }
}
