//! Files: the same that the command line writes.

use super::Answering;
use chatter_figures::{Figure, Resolution};
use chatter_work::Refusal;
use std::path::{Path, PathBuf};

/// What kind of file is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extension {
    Svg,
    Png,
    Pdf,
    Npz,
    Csv,
}

impl Extension {
    /// By its name.
    pub fn of(name: &str) -> Option<Self> {
        Some(match name {
            "svg" => Self::Svg,
            "png" => Self::Png,
            "pdf" => Self::Pdf,
            "npz" => Self::Npz,
            "csv" => Self::Csv,
            _ => return None,
        })
    }

    fn name(self) -> &'static str {
        match self {
            Self::Svg => "svg",
            Self::Png => "png",
            Self::Pdf => "pdf",
            Self::Npz => "npz",
            Self::Csv => "csv",
        }
    }

    /// Whether it is a picture rather than a table.
    pub fn is_picture(self) -> bool {
        matches!(self, Self::Svg | Self::Png | Self::Pdf)
    }
}

impl Answering<'_> {
    /// A figure as a file.
    pub fn figure(&self, stem: &str, kind: Extension, figure: &Figure) -> Result<(), Refusal> {
        let told = |error: chatter_figures::FigureError| Refusal::Output(error.to_string());
        let bytes = match kind {
            Extension::Png => figure.png(Resolution::default()).map_err(told)?,
            Extension::Pdf => figure.pdf().map_err(told)?,
            _ => figure.svg().map_err(told)?.into_bytes(),
        };
        self.file(&format!("{stem}.{}", kind.name()), &bytes)
    }

    /// Tables as files: `write` is given the path of the first, beside which others may stand.
    pub fn tables<T>(
        &self,
        stem: &str,
        kind: Extension,
        write: impl FnOnce(&Path) -> Result<T, Refusal>,
    ) -> Result<(), Refusal> {
        let failed = |error: std::io::Error| Refusal::Output(error.to_string());
        let folder = tempfile::tempdir().map_err(failed)?;
        write(&folder.path().join(format!("{stem}.{}", kind.name())))?;
        let entries = std::fs::read_dir(folder.path()).map_err(failed)?;
        let mut files: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
        files.sort();
        for path in files {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            self.file(&name, &std::fs::read(&path).map_err(failed)?)?;
        }
        Ok(())
    }
}

/// What files of a model are called: its name as far as it can be one of a file.
pub fn stem(name: &str, what: &str) -> String {
    let bare = Path::new(name)
        .file_stem()
        .unwrap_or_default()
        .to_string_lossy();
    let fits = |character: &char| character.is_alphanumeric() || "_-".contains(*character);
    let kept: String = bare.chars().filter(fits).take(60).collect();
    match kept.is_empty() {
        true => what.to_owned(),
        false => format!("{kept}-{what}"),
    }
}
