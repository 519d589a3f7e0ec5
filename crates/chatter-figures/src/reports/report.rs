//! A report as a plain value.

use super::html;
use super::report_error::ReportError;
use crate::Figure;
use crate::error::Error;
use chatter_files::atomic_file::write_atomically;
use std::path::Path;

/// A page: a title, what it is about in a sentence or two, and blocks below each other.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    pub(super) title: String,
    pub(super) summary: String,
    pub(super) blocks: Vec<Block>,
    pub(super) colophon: String,
}

/// Part of a report.
#[derive(Clone, Debug, PartialEq)]
pub enum Block {
    /// The title of a section.
    Heading(String),
    /// Running text.
    Paragraph(String),
    /// A table.
    Grid(Grid),
    /// A figure.
    Picture(Picture),
}

/// How the cells of a column stand below each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Align {
    /// Words.
    #[default]
    Left,
    /// Numbers.
    Right,
}

/// A column of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    pub(super) heading: String,
    pub(super) align: Align,
}

impl Column {
    /// A column of words.
    pub fn words(heading: impl Into<String>) -> Self {
        Self {
            heading: heading.into(),
            align: Align::Left,
        }
    }

    /// A column of numbers.
    pub fn numbers(heading: impl Into<String>) -> Self {
        Self {
            heading: heading.into(),
            align: Align::Right,
        }
    }
}

/// A table with a caption above it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Grid {
    pub(super) label: String,
    pub(super) caption: String,
    pub(super) columns: Vec<Column>,
    pub(super) rows: Vec<Vec<String>>,
}

impl Grid {
    /// A table called `label`, such as `Table 1`, without rows.
    pub fn new(
        label: impl Into<String>,
        caption: impl Into<String>,
        columns: impl IntoIterator<Item = Column>,
    ) -> Self {
        Self {
            label: label.into(),
            caption: caption.into(),
            columns: columns.into_iter().collect(),
            rows: Vec::new(),
        }
    }

    /// With one more row: as many cells as there are columns.
    pub fn row<S: Into<String>>(mut self, cells: impl IntoIterator<Item = S>) -> Self {
        self.add(cells);
        self
    }

    /// Adds a row: as many cells as there are columns.
    pub fn add<S: Into<String>>(&mut self, cells: impl IntoIterator<Item = S>) {
        self.rows.push(cells.into_iter().map(Into::into).collect());
    }
}

/// A figure with a caption below it.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    pub(super) label: String,
    pub(super) caption: String,
    pub(super) figure: Figure,
}

impl Picture {
    /// A figure called `label`, such as `Fig. 2`. The caption has markup; the one in the figure's metadata has none.
    pub fn new(label: impl Into<String>, caption: impl Into<String>, figure: Figure) -> Self {
        Self {
            label: label.into(),
            caption: caption.into(),
            figure,
        }
    }
}

impl From<Grid> for Block {
    fn from(grid: Grid) -> Self {
        Self::Grid(grid)
    }
}

impl From<Picture> for Block {
    fn from(picture: Picture) -> Self {
        Self::Picture(picture)
    }
}

impl Report {
    /// A report without blocks.
    pub fn new(title: impl Into<String>, summary: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            summary: summary.into(),
            ..Self::default()
        }
    }

    /// Adds a section's title.
    pub fn heading(&mut self, text: impl Into<String>) {
        self.blocks.push(Block::Heading(text.into()));
    }

    /// Adds running text.
    pub fn paragraph(&mut self, text: impl Into<String>) {
        self.blocks.push(Block::Paragraph(text.into()));
    }

    /// Adds a table or a figure.
    pub fn add(&mut self, block: impl Into<Block>) {
        self.blocks.push(block.into());
    }

    /// Sets the line at the page's end: what made it.
    pub fn set_colophon(&mut self, text: impl Into<String>) {
        self.colophon = text.into();
    }

    /// The report as one page of HTML.
    ///
    /// # Errors
    /// Markup that cannot be read, a figure that cannot be drawn, or a row with more or fewer cells than columns.
    pub fn html(&self) -> Result<String, ReportError> {
        html::document(self)
    }

    /// Writes the report as one page of HTML.
    ///
    /// # Errors
    /// As for [`html`](Self::html), and where the file cannot be written.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        Ok(write_atomically(path, self.html()?.as_bytes())?)
    }
}
