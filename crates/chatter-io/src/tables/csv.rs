//! Comma-separated values after RFC 4180: a heading line, CRLF, quotes only where needed, `nan`, `inf`, `-inf`.

use std::io::{self, Write};
use std::path::Path;

use super::table::{Table, Values};
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
                Values::Booleans(v) => out.write_all(if v[row] { b"true" } else { b"false" })?,
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
            .column("n", vec![1i64, -2, 3, i64::MIN])
            .column("ok", vec![true, false, true, false]);
        assert_eq!(
            csv_text(&table).unwrap(),
            "x,n,ok\r\n0.1,1,true\r\nnan,-2,false\r\n-inf,3,true\r\n1e300,-9223372036854775808,false\r\n"
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
