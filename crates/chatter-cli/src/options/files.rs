//! Files to be written: their kind is known, and their folder there, before anything is computed.

use chatter_files::Format;
use chatter_files::atomic_file::check_target;
use std::path::{Path, PathBuf};

/// A table: `.csv` or `.npz`.
#[derive(Clone, Debug)]
pub struct TableFile(pub PathBuf);

/// A figure: `.svg`, `.png` or `.pdf`.
#[derive(Clone, Debug)]
pub struct FigureFile(pub PathBuf);

impl std::str::FromStr for TableFile {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Format::of_table(text).map_err(|error| error.to_string())?;
        writable(text).map(Self)
    }
}

impl std::str::FromStr for FigureFile {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Format::of_figure(text).map_err(|error| error.to_string())?;
        writable(text).map(Self)
    }
}

fn writable(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    if !folder.is_dir() {
        return Err(format!("the folder `{}` does not exist", folder.display()));
    }
    match check_target(&path) {
        Ok(()) => Ok(path),
        Err(error) => Err(error.source.to_string()),
    }
}
