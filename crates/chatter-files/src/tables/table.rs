//! Named columns as plain values.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::error::TableError;
use super::{NpzWriter, write_csv};
use crate::error::Error;
use crate::format::Format;

/// The values of one column.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// Double-precision numbers; not-a-number and infinities are kept.
    Floats(Vec<f64>),
    /// Integers.
    Integers(Vec<i64>),
    /// Text.
    Texts(Vec<String>),
}

impl Values {
    /// How many there are.
    pub fn len(&self) -> usize {
        match self {
            Values::Floats(v) => v.len(),
            Values::Integers(v) => v.len(),
            Values::Texts(v) => v.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl From<Vec<f64>> for Values {
    fn from(v: Vec<f64>) -> Self {
        Values::Floats(v)
    }
}

impl From<Vec<i64>> for Values {
    fn from(v: Vec<i64>) -> Self {
        Values::Integers(v)
    }
}

impl From<Vec<String>> for Values {
    fn from(v: Vec<String>) -> Self {
        Values::Texts(v)
    }
}

impl From<Vec<&str>> for Values {
    fn from(v: Vec<&str>) -> Self {
        Values::Texts(v.into_iter().map(str::to_string).collect())
    }
}

/// A named column.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Its name: the heading in CSV, the array's name in NPZ.
    pub name: String,
    /// Its values.
    pub values: Values,
}

/// Columns of equal length, checked when written.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    /// Names the file when a data set of several tables is written as CSV.
    pub name: String,
    /// The columns, in the order they are written.
    pub columns: Vec<Column>,
}

impl Table {
    /// A table without columns.
    pub fn new(name: impl Into<String>) -> Self {
        Table {
            name: name.into(),
            columns: Vec::new(),
        }
    }

    /// Appends a column of `f64`, `i64`, `String` or `&str`.
    pub fn column(mut self, name: impl Into<String>, values: impl Into<Values>) -> Self {
        self.columns.push(Column {
            name: name.into(),
            values: values.into(),
        });
        self
    }

    /// Number of rows: the length of the first column.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |c| c.values.len())
    }

    /// Checks that the columns have one length and each a name of its own.
    pub fn check(&self) -> Result<(), TableError> {
        let mut names = BTreeSet::new();
        for column in &self.columns {
            check_name(&column.name)?;
            if !names.insert(column.name.as_str()) {
                return Err(TableError::DuplicateName {
                    name: column.name.clone(),
                });
            }
            if column.values.len() != self.rows() {
                let first = &self.columns[0];
                return Err(TableError::UnequalLengths {
                    table: self.name.clone(),
                    first: (first.name.clone(), first.values.len()),
                    other: (column.name.clone(), column.values.len()),
                });
            }
        }
        Ok(())
    }
}

/// What one result file holds: tables that may differ in length, and text about them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Dataset {
    /// The tables.
    pub tables: Vec<Table>,
    /// Text entries by name, such as the specification that the result came from.
    pub metadata: Vec<(String, String)>,
}

impl Dataset {
    /// A data set without tables.
    pub fn new() -> Self {
        Dataset::default()
    }

    /// Appends a table.
    pub fn table(mut self, table: Table) -> Self {
        self.tables.push(table);
        self
    }

    /// Appends a text entry.
    pub fn text(mut self, name: impl Into<String>, text: impl Into<String>) -> Self {
        self.metadata.push((name.into(), text.into()));
        self
    }

    /// Checks each table, and that text entries have names.
    pub fn check(&self) -> Result<(), TableError> {
        self.tables.iter().try_for_each(Table::check)?;
        self.metadata
            .iter()
            .try_for_each(|(name, _)| check_name(name))
    }

    /// Writes the data set in the format that the extension of `path` names, and returns the files written.
    ///
    /// NPZ: one file with one array per column and one text array per text entry; all names must differ.
    /// CSV: one table a file, under `path` for a single table, else as `stem.TABLE.csv` beside it; text entries, if
    /// any, go to `stem.metadata.csv` with the columns `name` and `text`, since a comment in the table's own file
    /// would break the one-line readers.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<Vec<PathBuf>, Error> {
        let path = path.as_ref();
        match Format::of_table(path)? {
            Format::Npz => self.write_npz(path),
            _ => self.write_csv_files(path),
        }
    }

    fn write_npz(&self, path: &Path) -> Result<Vec<PathBuf>, Error> {
        self.check()?;
        let mut writer = NpzWriter::create(path)?;
        for column in self.tables.iter().flat_map(|t| &t.columns) {
            writer.column(column)?;
        }
        for (name, text) in &self.metadata {
            writer.text(name, text)?;
        }
        writer.finish()?;
        Ok(vec![path.to_path_buf()])
    }

    fn write_csv_files(&self, path: &Path) -> Result<Vec<PathBuf>, Error> {
        self.check()?;
        let mut written = Vec::new();
        for table in &self.tables {
            let file = match self.tables.len() {
                1 => path.to_path_buf(),
                _ => path.with_extension(format!("{}.csv", table.name)),
            };
            if written.contains(&file) {
                return Err(TableError::DuplicateName {
                    name: table.name.clone(),
                }
                .into());
            }
            check_name(&table.name).or_else(|e| {
                if self.tables.len() == 1 {
                    Ok(())
                } else {
                    Err(e)
                }
            })?;
            write_csv(table, &file)?;
            written.push(file);
        }
        if !self.metadata.is_empty() {
            let (names, texts): (Vec<String>, Vec<String>) = self.metadata.iter().cloned().unzip();
            let file = path.with_extension("metadata.csv");
            write_csv(
                &Table::new("metadata")
                    .column("name", names)
                    .column("text", texts),
                &file,
            )?;
            written.push(file);
        }
        Ok(written)
    }
}

/// A name must be usable as a file's name inside an archive.
pub(super) fn check_name(name: &str) -> Result<(), TableError> {
    if name.is_empty()
        || name
            .chars()
            .any(|c| c == '/' || c == '\\' || c.is_control())
    {
        return Err(TableError::BadName {
            name: name.to_string(),
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scratch::Scratch;

    #[test]
    fn unequal_lengths_are_told_with_names_and_numbers() {
        let table = Table::new("samples")
            .column("t", vec![0.0, 1.0])
            .column("n", vec![1i64]);
        assert_eq!(
            table.check().unwrap_err().to_string(),
            "table `samples`: column `n` has 1 values, but column `t` has 2"
        );
    }

    #[test]
    fn names_are_distinct_and_usable() {
        let twice = Table::new("a")
            .column("x", vec![1.0])
            .column("x", vec![1.0]);
        assert!(matches!(
            twice.check(),
            Err(TableError::DuplicateName { .. })
        ));
        let slash = Table::new("a").column("x/y", vec![1.0]);
        assert!(matches!(slash.check(), Err(TableError::BadName { .. })));
    }

    #[test]
    fn two_tables_become_two_csv_files_and_the_text_a_third() {
        let folder = Scratch::new();
        let data = Dataset::new()
            .table(Table::new("columns").column("q", vec![0.5]))
            .table(Table::new("samples").column("y", vec![1.0, 2.0]))
            .text("model", "a, \"b\"\n");
        let files = data.write(folder.path("fig5.csv")).unwrap();
        let names: Vec<_> = files
            .iter()
            .map(|f| f.file_name().unwrap().to_str().unwrap())
            .collect();
        assert_eq!(
            names,
            ["fig5.columns.csv", "fig5.samples.csv", "fig5.metadata.csv"]
        );
        assert_eq!(
            std::fs::read_to_string(&files[2]).unwrap(),
            "name,text\r\nmodel,\"a, \"\"b\"\"\n\"\r\n"
        );
    }
}
