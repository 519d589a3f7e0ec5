//! The frame of an NPZ file that is read: where its arrays are, and what their headers say.

use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rawzip::{
    CompressionMethod, ErrorKind, FileReader, MAX_CENTRAL_DIRECTORY_RECORD_SIZE, RangeReader,
    ZipArchive, ZipArchiveEntryWayfinder, ZipLocator,
};

use super::error::TableError;
use super::inflate::{Inflated, LARGEST_RATIO};
use super::npy::{self, ArrayInfo, PREFIX_LENGTH};
use crate::error::{Error, FileAction, FileError};

/// Bytes read at a time.
pub(super) const CHUNK: usize = 1 << 16;

/// An array of an archive.
pub(super) struct Entry {
    pub(super) info: ArrayInfo,
    place: ZipArchiveEntryWayfinder,
    packing: Packing,
    /// How long the array's header is.
    header_length: usize,
}

/// The format's methods 0 and 8.
#[derive(Clone, Copy)]
enum Packing {
    Stored,
    Deflated,
}

/// An open ZIP archive.
pub(super) struct Archive {
    pub(super) path: PathBuf,
    zip: ZipArchive<Arc<FileReader>>,
    length: u64,
}

impl Archive {
    pub(super) fn open(path: &Path) -> Result<Self, Error> {
        let opened = File::open(path).and_then(|file| Ok((file.metadata()?.len(), file)));
        let (length, file) = opened.map_err(|e| FileError::new(path, FileAction::Open, e))?;
        let mut buffer = vec![0; CHUNK];
        let file = Arc::new(FileReader::from(file));
        let zip = ZipLocator::new()
            .locate_in_reader(file, &mut buffer, length)
            .map_err(|(_, error)| in_frame(path, error))?;
        let path = path.to_path_buf();
        Ok(Self { path, zip, length })
    }

    /// The arrays that the directory lists.
    pub(super) fn entries(&self) -> Result<Vec<Entry>, Error> {
        let mut buffer = vec![0; MAX_CENTRAL_DIRECTORY_RECORD_SIZE];
        let mut listed = self.zip.entries(&mut buffer);
        let mut entries = Vec::new();
        let mut count = 0;
        while let Some(found) = listed.next_entry().map_err(|e| in_frame(&self.path, e))? {
            count += 1;
            let name = String::from_utf8_lossy(found.file_path().as_bytes()).into_owned();
            let Some(name) = name.strip_suffix(".npy") else {
                continue;
            };
            let packing = match found.compression_method() {
                CompressionMethod::STORE => Packing::Stored,
                CompressionMethod::DEFLATE => Packing::Deflated,
                other => {
                    let method = other.as_u16();
                    let what = format!(
                        "array `{name}` is compressed by method {method}, which is not read"
                    );
                    return Err(malformed(&self.path, what));
                }
            };
            entries.push(self.entry(name, found.wayfinder(), packing)?);
        }
        match self.zip.entries_hint() {
            claimed if claimed == count => Ok(entries),
            claimed => {
                let what = format!("its directory lists {count} entries, and claims {claimed}");
                Err(malformed(&self.path, what))
            }
        }
    }

    fn entry(
        &self,
        name: &str,
        place: ZipArchiveEntryWayfinder,
        packing: Packing,
    ) -> Result<Entry, Error> {
        let in_array = |what: String| malformed(&self.path, format!("array `{name}`: {what}"));
        // What is claimed is compared with what there is before memory or time is spent on it.
        let (stored, original) = (place.compressed_size_hint(), place.uncompressed_size_hint());
        let most = match packing {
            Packing::Stored => stored,
            Packing::Deflated => stored.saturating_mul(LARGEST_RATIO),
        };
        if original > most {
            return Err(in_array(format!(
                "{stored} bytes cannot hold the {original} that are claimed"
            )));
        }
        let mut bytes = self.unpacked(name, place, packing)?;
        let mut read = |into: &mut [u8]| {
            let read = bytes.read_exact(into);
            read.map_err(|e| in_data(&self.path, name, e))
        };
        let mut header = vec![0; PREFIX_LENGTH];
        read(&mut header)?;
        let prefix = header.as_slice().try_into().expect("read so many");
        let header_length = npy::header_length(prefix).map_err(in_array)?;
        if header_length < PREFIX_LENGTH || header_length as u64 > original {
            return Err(in_array("its header is cut short".to_owned()));
        }
        header.resize(header_length, 0);
        read(&mut header[PREFIX_LENGTH..])?;
        let (kind, shape) = npy::parse_header(&header).map_err(in_array)?;
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
            place,
            packing,
            header_length,
        })
    }

    /// The bytes of an entry, unpacked; the last one comes with an error if the checksum is another.
    fn unpacked(
        &self,
        name: &str,
        place: ZipArchiveEntryWayfinder,
        packing: Packing,
    ) -> Result<Box<dyn Read + Send>, Error> {
        let found = self.zip.get_entry(place).map_err(|error| {
            if matches!(error.kind(), ErrorKind::InvalidSignature { .. }) {
                let what = format!("array `{name}` is not where the directory says");
                return malformed(&self.path, what);
            }
            in_frame(&self.path, error)
        })?;
        let (from, to) = found.compressed_data_range();
        if to > self.length {
            let what = format!("array `{name}`: it is cut short");
            return Err(malformed(&self.path, what));
        }
        let bytes = RangeReader::new(Arc::clone(self.zip.get_ref()), from..to);
        let bytes = BufReader::with_capacity(CHUNK, bytes);
        Ok(match packing {
            Packing::Stored => Box::new(found.verifying_reader(bytes)),
            Packing::Deflated => Box::new(found.verifying_reader(Inflated::new(bytes))),
        })
    }

    /// The data of an array, behind its header.
    pub(super) fn data(&self, entry: &Entry) -> Result<Box<dyn Read + Send>, Error> {
        let name = &entry.info.name;
        let mut bytes = self.unpacked(name, entry.place, entry.packing)?;
        let header = bytes.read_exact(&mut vec![0; entry.header_length]);
        header.map_err(|error| in_data(&self.path, name, error))?;
        Ok(bytes)
    }
}

pub(super) fn malformed(path: &Path, what: impl Into<String>) -> Error {
    TableError::Malformed {
        path: path.to_path_buf(),
        what: what.into(),
    }
    .into()
}

/// What is wrong with directory or headers.
fn in_frame(path: &Path, error: rawzip::Error) -> Error {
    let what = match error.into_kind() {
        ErrorKind::IO(error) if error.kind() != io::ErrorKind::UnexpectedEof => {
            return FileError::new(path, FileAction::Read, error).into();
        }
        ErrorKind::IO(_) | ErrorKind::Eof => "it is cut short",
        ErrorKind::MissingEndOfCentralDirectory => "it has no ZIP directory",
        _ => "its directory is damaged",
    };
    malformed(path, what)
}

/// What is wrong with the bytes of an array.
pub(super) fn in_data(path: &Path, name: &str, error: io::Error) -> Error {
    let verifies = (error.get_ref()).is_some_and(|inner| inner.is::<rawzip::Error>());
    match error.kind() {
        io::ErrorKind::InvalidData if verifies => {
            let what = format!("array `{name}` is damaged: its checksum differs");
            malformed(path, what)
        }
        io::ErrorKind::InvalidData => malformed(path, format!("array `{name}`: {error}")),
        io::ErrorKind::UnexpectedEof => malformed(path, format!("array `{name}` is cut short")),
        _ => FileError::new(path, FileAction::Read, error).into(),
    }
}
