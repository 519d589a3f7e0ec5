//! The kinds of file, known by their extension.

use std::fmt;
use std::path::{Path, PathBuf};

/// A kind of file that can be written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Format {
    /// Figure: scalable vector graphics.
    Svg,
    /// Figure: portable network graphics, 300 pixels per inch unless told otherwise.
    Png,
    /// Figure: portable document format, vector with embedded fonts.
    Pdf,
    /// Table: comma-separated values, RFC 4180.
    Csv,
    /// Table: NumPy's archive of arrays.
    Npz,
}

/// What a file is to hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Content {
    /// A drawing.
    Figure,
    /// Columns of numbers and text.
    Table,
}

impl Content {
    /// The formats that can hold it.
    pub fn formats(self) -> &'static [Format] {
        match self {
            Content::Figure => &[Format::Svg, Format::Png, Format::Pdf],
            Content::Table => &[Format::Csv, Format::Npz],
        }
    }

    fn name(self) -> &'static str {
        match self {
            Content::Figure => "figure",
            Content::Table => "table",
        }
    }
}

impl Format {
    /// The extension, without its dot.
    pub fn extension(self) -> &'static str {
        match self {
            Format::Svg => "svg",
            Format::Png => "png",
            Format::Pdf => "pdf",
            Format::Csv => "csv",
            Format::Npz => "npz",
        }
    }

    /// What a file of this format holds.
    pub fn content(self) -> Content {
        match self {
            Format::Svg | Format::Png | Format::Pdf => Content::Figure,
            Format::Csv | Format::Npz => Content::Table,
        }
    }

    /// Whether a file that begins with these bytes may be of this format. Text of separated values has no mark.
    pub fn begins(self, bytes: &[u8]) -> bool {
        let marks: &[&[u8]] = match self {
            Format::Svg => &[b"<svg", b"<?xml"],
            Format::Png => &[b"\x89PNG\r\n\x1a\n"],
            Format::Pdf => &[b"%PDF"],
            Format::Npz => &[b"PK\x03\x04"],
            Format::Csv => &[b""],
        };
        marks.iter().any(|mark| bytes.starts_with(mark))
    }

    /// The format of a figure file from its extension, in capitals or not.
    pub fn of_figure(path: impl AsRef<Path>) -> Result<Format, FormatError> {
        Format::of(path.as_ref(), Content::Figure)
    }

    /// The format of a table file from its extension, in capitals or not.
    pub fn of_table(path: impl AsRef<Path>) -> Result<Format, FormatError> {
        Format::of(path.as_ref(), Content::Table)
    }

    /// The format of a file that is to hold `content`, from its extension, in capitals or not.
    pub fn of(path: &Path, content: Content) -> Result<Format, FormatError> {
        let extension = path
            .extension()
            .map(|e| e.to_string_lossy().to_ascii_lowercase());
        content
            .formats()
            .iter()
            .copied()
            .find(|f| Some(f.extension()) == extension.as_deref())
            .ok_or_else(|| FormatError {
                path: path.to_path_buf(),
                content,
                extension,
            })
    }
}

/// The extension of a path names no format for this content.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FormatError {
    /// The path as given.
    pub path: PathBuf,
    /// What was to be written there.
    pub content: Content,
    /// Its extension in lower case, if it has one.
    pub extension: Option<String>,
}

impl fmt::Display for FormatError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let path = self.path.display();
        let what = self.content.name();
        match &self.extension {
            Some(e) => write!(
                f,
                "cannot write a {what} to `{path}`: unknown extension `.{e}`"
            )?,
            None => write!(f, "cannot write a {what} to `{path}`: it has no extension")?,
        }
        let known: Vec<String> = self
            .content
            .formats()
            .iter()
            .map(|k| format!(".{}", k.extension()))
            .collect();
        write!(f, "; a {what} is written as {}", known.join(", "))
    }
}

impl std::error::Error for FormatError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extensions_are_known_in_any_case() {
        assert_eq!(Format::of_figure("a/b.PNG").unwrap(), Format::Png);
        assert_eq!(Format::of_table("b.npz").unwrap(), Format::Npz);
    }

    #[test]
    fn an_unknown_extension_lists_the_known() {
        let text = |r: Result<Format, FormatError>| r.unwrap_err().to_string();
        assert_eq!(
            text(Format::of_figure("a.jpg")),
            "cannot write a figure to `a.jpg`: unknown extension `.jpg`; a figure is written as .svg, .png, .pdf"
        );
        assert_eq!(
            text(Format::of_table("trajectory")),
            "cannot write a table to `trajectory`: it has no extension; a table is written as .csv, .npz"
        );
        assert!(Format::of_table("a.png").is_err());
    }
}
