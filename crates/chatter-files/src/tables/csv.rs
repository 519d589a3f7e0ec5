//! Comma-separated values after RFC 4180: a heading line, CRLF, quotes only where needed, `nan`, `inf`, `-inf`.

use std::io::{self, Write};
use std::path::Path;

use super::error::TableError;
use super::table::{Table, Values, check_name};
use crate::atomic_file::AtomicFile;
use crate::error::Error;

/// Writes one table to `path`. Floats are the shortest text that reads back to the same number.
pub fn write_csv(table: &Table, path: impl AsRef<Path>) -> Result<(), Error> {
    table.check()?;
    let mut file = AtomicFile::create(path)?;
    write_rows(table, &mut file).map_err(|e| file.write_error(e))?;
    Ok(file.commit()?)
}

/// The table as it would stand in a file.
pub fn csv_text(table: &Table) -> Result<String, Error> {
    table.check()?;
    let mut bytes = Vec::new();
    write_rows(table, &mut bytes).expect("writing to memory does not fail");
    Ok(String::from_utf8(bytes).expect("made of text"))
}

/// Writes a table row by row, in flat memory; the file appears when [`CsvWriter::finish`] is called.
pub struct CsvWriter {
    file: AtomicFile,
    columns: usize,
}

/// One value of a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cell<'a> {
    /// A number.
    Float(f64),
    /// An integer.
    Integer(i64),
    /// Text.
    Text(&'a str),
}

impl CsvWriter {
    /// Starts a table with these headings at `path`, whose folder must exist.
    pub fn create(path: impl AsRef<Path>, headings: &[&str]) -> Result<Self, Error> {
        let mut file = AtomicFile::create(path)?;
        for (k, heading) in headings.iter().enumerate() {
            check_name(heading)?;
            separate(k, &mut file)
                .and_then(|()| write_text(heading, &mut file))
                .map_err(|e| file.write_error(e))?;
        }
        file.write_all(b"\r\n").map_err(|e| file.write_error(e))?;
        Ok(CsvWriter {
            file,
            columns: headings.len(),
        })
    }

    /// Appends a row, which must have a cell for each heading.
    pub fn row(&mut self, cells: &[Cell<'_>]) -> Result<(), Error> {
        if cells.len() != self.columns {
            return Err(TableError::UnequalLengths {
                table: self.file.target().display().to_string(),
                first: ("heading".to_string(), self.columns),
                other: ("row".to_string(), cells.len()),
            }
            .into());
        }
        let mut digits = ryu::Buffer::new();
        let mut write = || -> io::Result<()> {
            for (k, cell) in cells.iter().enumerate() {
                separate(k, &mut self.file)?;
                match cell {
                    Cell::Float(x) => self.file.write_all(float(*x, &mut digits).as_bytes())?,
                    Cell::Integer(n) => write!(self.file, "{n}")?,
                    Cell::Text(text) => write_text(text, &mut self.file)?,
                }
            }
            self.file.write_all(b"\r\n")
        };
        let written = write();
        Ok(written.map_err(|e| self.file.write_error(e))?)
    }

    /// Puts the file in its place.
    pub fn finish(self) -> Result<(), Error> {
        Ok(self.file.commit()?)
    }
}

fn write_rows(table: &Table, out: &mut impl Write) -> io::Result<()> {
    for (k, column) in table.columns.iter().enumerate() {
        separate(k, out)?;
        write_text(&column.name, out)?;
    }
    out.write_all(b"\r\n")?;
    let mut digits = ryu::Buffer::new();
    for row in 0..table.rows() {
        for (k, column) in table.columns.iter().enumerate() {
            separate(k, out)?;
            match &column.values {
                Values::Floats(v) => out.write_all(float(v[row], &mut digits).as_bytes())?,
                Values::Integers(v) => write!(out, "{}", v[row])?,
                Values::Texts(v) => write_text(&v[row], out)?,
            }
        }
        out.write_all(b"\r\n")?;
    }
    Ok(())
}

fn separate(k: usize, out: &mut impl Write) -> io::Result<()> {
    if k > 0 { out.write_all(b",") } else { Ok(()) }
}

fn float(x: f64, digits: &mut ryu::Buffer) -> &str {
    if x.is_nan() {
        "nan"
    } else if x == f64::INFINITY {
        "inf"
    } else if x == f64::NEG_INFINITY {
        "-inf"
    } else {
        digits.format_finite(x)
    }
}

fn write_text(text: &str, out: &mut impl Write) -> io::Result<()> {
    let needs_quotes =
        text.contains([',', '"', '\r', '\n']) || text.starts_with(' ') || text.ends_with(' ');
    // An empty text is quoted so that it differs from a missing value, and a row of one such cell from a blank line.
    if needs_quotes || text.is_empty() {
        write!(out, "\"{}\"", text.replace('"', "\"\""))
    } else {
        out.write_all(text.as_bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A plain RFC 4180 reader, to read back what was written.
    fn parse(text: &str) -> Vec<Vec<String>> {
        let (mut rows, mut row, mut cell) = (Vec::new(), Vec::new(), String::new());
        let mut quoted = false;
        let mut chars = text.chars().peekable();
        while let Some(c) = chars.next() {
            match (quoted, c) {
                (true, '"') if chars.peek() == Some(&'"') => {
                    chars.next();
                    cell.push('"');
                }
                (_, '"') => quoted = !quoted,
                (false, ',') => row.push(std::mem::take(&mut cell)),
                (false, '\r') => {
                    assert_eq!(chars.next(), Some('\n'));
                    row.push(std::mem::take(&mut cell));
                    rows.push(std::mem::take(&mut row));
                }
                (_, c) => cell.push(c),
            }
        }
        assert!(
            !quoted && cell.is_empty() && row.is_empty(),
            "the last line is ended"
        );
        rows
    }

    #[test]
    fn numbers_are_short_and_special_values_readable() {
        let table = Table::new("t")
            .column("x", vec![0.1, f64::NAN, f64::NEG_INFINITY, 1e300])
            .column("n", vec![1i64, -2, 3, i64::MIN]);
        assert_eq!(
            csv_text(&table).unwrap(),
            "x,n\r\n0.1,1\r\nnan,-2\r\n-inf,3\r\n1e300,-9223372036854775808\r\n"
        );
    }

    #[test]
    fn rows_come_to_the_same_file_as_a_table() {
        let folder = crate::scratch::Scratch::new();
        let path = folder.path("a.csv");
        let mut writer = CsvWriter::create(&path, &["x", "n", "a, b"]).unwrap();
        let values = [
            (0.1, 3_i64, "é"),
            (f64::NAN, -4, "two, words"),
            (1e300, 0, ""),
        ];
        for (x, n, text) in values {
            let cells = [Cell::Float(x), Cell::Integer(n), Cell::Text(text)];
            writer.row(&cells).unwrap();
        }
        assert!(writer.row(&[Cell::Integer(1)]).is_err());
        assert!(!path.exists());
        writer.finish().unwrap();
        let table = Table::new("t")
            .column("x", values.map(|v| v.0).to_vec())
            .column("n", values.map(|v| v.1).to_vec())
            .column("a, b", values.map(|v| v.2).to_vec());
        assert_eq!(
            std::fs::read_to_string(&path).unwrap(),
            csv_text(&table).unwrap()
        );
    }

    #[test]
    fn a_table_without_rows_keeps_its_heading() {
        let table = Table::new("t").column("a,b", Vec::<f64>::new());
        assert_eq!(csv_text(&table).unwrap(), "\"a,b\"\r\n");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn any_text_and_any_number_read_back(
            texts in proptest::collection::vec("[ -~\r\n\"é]{0,8}", 1..6),
            bits in proptest::collection::vec(any::<u64>(), 6),
        ) {
            let numbers: Vec<f64> = bits.iter().take(texts.len()).map(|&b| f64::from_bits(b)).collect();
            let table = Table::new("t").column("text", texts.clone()).column("x", numbers.clone());
            let rows = parse(&csv_text(&table).unwrap());
            prop_assert_eq!(rows.len(), texts.len() + 1);
            for (row, (text, x)) in rows[1..].iter().zip(texts.iter().zip(&numbers)) {
                prop_assert_eq!(&row[0], text);
                let back: f64 = row[1].parse().unwrap();
                prop_assert!(back.to_bits() == x.to_bits() || (back.is_nan() && x.is_nan()));
            }
        }
    }
}
