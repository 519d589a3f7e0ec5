//! NPZ archives: what is written reads back, damaged files are told apart, and NumPy reads and writes the same.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use chatter_files::Error;
use chatter_files::tables::{
    Column, Dataset, Kind, NpzReader, NpzWriter, Table, TableError, Values,
};
use proptest::prelude::*;

struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("chatter-npz-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Folder(path)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn sample() -> Dataset {
    Dataset::new()
        .table(
            Table::new("columns")
                .column("q", vec![0.1, f64::NAN, f64::NEG_INFINITY])
                .column("period", vec![1i64, -2, i64::MAX])
                .column("outcome", vec!["chaotic", "", "périodique Ω"]),
        )
        .table(Table::new("samples").column("y2", vec![1.0, 2.0, 3.0, 4.0, 5e-324]))
        .text("model", "[flight]\ny1 = \"y2\"\n")
}

fn same(a: &Values, b: &Values) -> bool {
    match (a, b) {
        (Values::Floats(a), Values::Floats(b)) => {
            a.len() == b.len() && a.iter().zip(b).all(|(x, y)| x.to_bits() == y.to_bits())
        }
        _ => a == b,
    }
}

#[test]
fn every_kind_of_column_reads_back() {
    let folder = Folder::new("kinds");
    let path = folder.path("a.npz");
    let data = sample();
    assert_eq!(data.write(&path).unwrap(), std::slice::from_ref(&path));
    let reader = NpzReader::open(&path).unwrap();
    for column in data.tables.iter().flat_map(|t| &t.columns) {
        assert!(
            same(&reader.column(&column.name).unwrap().values, &column.values),
            "{}",
            column.name
        );
    }
    assert_eq!(reader.text("model").unwrap(), data.metadata[0].1);
    assert_eq!(reader.arrays().count(), 5);
    assert_eq!(reader.floats("period").unwrap()[..2], [1.0, -2.0]);
}

#[test]
fn equal_input_gives_equal_bytes() {
    let folder = Folder::new("equal");
    let (a, b) = (folder.path("a.npz"), folder.path("b.npz"));
    sample().write(&a).unwrap();
    sample().write(&b).unwrap();
    assert_eq!(std::fs::read(a).unwrap(), std::fs::read(b).unwrap());
}

#[test]
fn arrays_in_pieces_equal_those_written_at_once() {
    let folder = Folder::new("stream");
    let (a, b) = (folder.path("a.npz"), folder.path("b.npz"));
    let values: Vec<f64> = (0..100_001).map(|k| f64::from(k) * 0.5).collect();
    let mut writer = NpzWriter::create(&a).unwrap();
    writer.array("x", &values).unwrap();
    writer.array("m", &values[..6]).unwrap();
    writer.finish().unwrap();
    let mut writer = NpzWriter::create(&b).unwrap();
    let numbers = values.iter().copied();
    writer.stream("x", 100_001, numbers).unwrap();
    let mut rows = writer.begin("m", 6).unwrap();
    rows.extend(values[..3].iter().copied()).unwrap();
    rows.extend(values[3..6].iter().copied()).unwrap();
    rows.finish().unwrap();
    writer.finish().unwrap();
    assert_eq!(std::fs::read(&a).unwrap(), std::fs::read(&b).unwrap());
    let reader = NpzReader::open(&a).unwrap();
    assert_eq!(reader.info("m").unwrap().shape, [6]);
    assert_eq!(reader.floats("x").unwrap(), values);
}

#[test]
fn what_the_caller_got_wrong_is_said() {
    let folder = Folder::new("wrong");
    let path = folder.path("a.npz");
    let mut writer = NpzWriter::create(&path).unwrap();
    writer.array("x", &[1.0]).unwrap();
    assert_eq!(
        writer.array("x", &[1.0]).unwrap_err().to_string(),
        "two arrays of one file are named `x`"
    );
    writer.finish().unwrap();
    let reader = NpzReader::open(&path).unwrap();
    assert_eq!(
        reader.floats("y").unwrap_err().to_string(),
        format!("`{}` has no array `y`; it has x", path.display())
    );
    assert!(matches!(
        reader.text("x"),
        Err(Error::Table(TableError::WrongKind {
            found: Kind::Float,
            ..
        }))
    ));

    let mut writer = NpzWriter::create(&path).unwrap();
    let more = writer.stream("x", 2, [1.0, 2.0, 3.0]).unwrap_err();
    assert_eq!(
        more.to_string(),
        "array `x` was given 3 values, where 2 were told of"
    );
    assert!(writer.finish().is_err(), "the array is not whole");

    let mut writer = NpzWriter::create(&path).unwrap();
    let named = ["a:b", "C:", "..", ".", "~", "périodique Ω", "-"];
    for (k, name) in named.into_iter().enumerate() {
        writer.array(name, &[k as f64]).unwrap();
    }
    let colon = writer.array("Ω:q", &[1.0]).unwrap_err();
    assert!(matches!(
        colon,
        Error::Table(TableError::BadName { name }) if name == "Ω:q"
    ));
    writer.finish().unwrap();
    let reader = NpzReader::open(&path).unwrap();
    let read: Vec<&str> = reader.arrays().map(|array| array.name.as_str()).collect();
    assert_eq!(read, named);

    let mut writer = NpzWriter::create(&path).unwrap();
    writer.array("x", &[1.0]).unwrap();
    writer.finish().unwrap();
    let mut writer = NpzWriter::create(&path).unwrap();
    drop(writer.begin::<f64>("x", 1).unwrap());
    assert!(matches!(
        writer.finish(),
        Err(Error::Table(TableError::Unfinished { name })) if name == "x"
    ));
    assert_eq!(
        NpzReader::open(&path).unwrap().floats("x").unwrap(),
        [1.0],
        "the old file stays"
    );
}

#[test]
fn any_changed_or_missing_byte_is_noticed_or_harmless() {
    let folder = Folder::new("damage");
    let path = folder.path("a.npz");
    sample().write(&path).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let read_all = |bytes: &[u8]| -> Result<Vec<Column>, Error> {
        let path = folder.path("b.npz");
        std::fs::write(&path, bytes).unwrap();
        let reader = NpzReader::open(&path)?;
        let names: Vec<String> = reader.arrays().map(|a| a.name.clone()).collect();
        names.iter().map(|n| reader.column(n)).collect()
    };
    let whole = read_all(&bytes).unwrap();
    let agrees = |columns: &[Column]| {
        columns
            .iter()
            .all(|c| whole.iter().any(|w| same(&w.values, &c.values)))
    };
    for at in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[at] ^= 0x55;
        if let Ok(columns) = read_all(&damaged) {
            assert!(agrees(&columns), "byte {at} changed the values unnoticed");
        }
    }
    for length in (0..bytes.len()).step_by(7) {
        assert!(read_all(&bytes[..length]).is_err(), "cut at {length}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn any_columns_read_back(
        bits in proptest::collection::vec(any::<u64>(), 0..40),
        texts in proptest::collection::vec("\\PC{0,12}", 0..10),
        name in "[a-zA-Zµλ_. -]{1,20}",
    ) {
        let folder = Folder::new("any");
        let path = folder.path("a.npz");
        let floats: Vec<f64> = bits.iter().map(|&b| f64::from_bits(b)).collect();
        let data = Dataset::new()
            .table(Table::new("a").column(name.clone(), floats.clone()))
            .table(Table::new("b").column("0 texts", texts.clone()));
        data.write(&path).unwrap();
        let reader = NpzReader::open(&path).unwrap();
        prop_assert!(same(&reader.column(&name).unwrap().values, &Values::Floats(floats)));
        prop_assert_eq!(reader.texts("0 texts").unwrap(), texts);
    }
}

/// The Python to test with, if it has NumPy.
fn python() -> Option<String> {
    let python = std::env::var("CHATTER_PYTHON").unwrap_or_else(|_| "python3".to_string());
    let has_numpy = Command::new(&python)
        .args(["-c", "import numpy"])
        .output()
        .is_ok_and(|o| o.status.success());
    if !has_numpy {
        // Past the test harness, which hides what passing tests print.
        let told = writeln!(
            std::io::stderr(),
            "SKIPPED: `{python}` has no NumPy; set CHATTER_PYTHON to one that has"
        );
        told.unwrap();
    }
    has_numpy.then_some(python)
}

fn run(python: &str, script: &str, folder: &Path) -> String {
    let output = Command::new(python)
        .args(["-c", script])
        .current_dir(folder)
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn numpy_reads_what_is_written() {
    let Some(python) = python() else { return };
    let folder = Folder::new("numpy-reads");
    sample().write(folder.path("a.npz")).unwrap();
    sample().write(folder.path("a.csv")).unwrap();
    let script = r#"
import numpy, zipfile
assert zipfile.ZipFile("a.npz").testzip() is None
f = numpy.load("a.npz")
print(f["q"].dtype, f["q"].tolist(), f["period"].tolist(), f["outcome"].tolist(), f["y2"].tolist())
print(repr(str(f["model"])))
c = numpy.genfromtxt("a.columns.csv", delimiter=",", names=True, dtype=None, encoding="utf-8")
print(c["q"].tolist(), c["period"].tolist())
print(numpy.loadtxt("a.samples.csv", skiprows=1).tolist())
"#;
    assert_eq!(
        run(&python, script, &folder.0),
        "float64 [0.1, nan, -inf] [1, -2, 9223372036854775807] ['chaotic', '', 'périodique Ω'] \
         [1.0, 2.0, 3.0, 4.0, 5e-324]\n'[flight]\\ny1 = \"y2\"\\n'\n[0.1, nan, -inf] [1, -2, 9223372036854775807]\n\
         [1.0, 2.0, 3.0, 4.0, 5e-324]\n"
    );
}

#[test]
fn what_numpy_writes_is_read() {
    let Some(python) = python() else { return };
    let folder = Folder::new("numpy-writes");
    run(
        &python,
        r#"
import numpy
numpy.savez("a.npz", x=numpy.linspace(0, 1, 5), n=numpy.arange(6).reshape(2, 3), ok=numpy.array([True]), t=numpy.array("ü text"))
numpy.savez_compressed("c.npz", x=numpy.arange(100000) % 77 / 7, n=numpy.arange(6), t=numpy.array("ü text"), e=numpy.zeros(0))
numpy.savez("f.npz", x=numpy.zeros(3, dtype="f4"))
"#,
        &folder.0,
    );
    let reader = NpzReader::open(folder.path("a.npz")).unwrap();
    assert_eq!(reader.floats("x").unwrap(), [0.0, 0.25, 0.5, 0.75, 1.0]);
    assert_eq!(reader.integers("n").unwrap(), [0, 1, 2, 3, 4, 5]);
    assert_eq!(reader.info("n").unwrap().shape, [2, 3]);
    assert_eq!(
        reader.column("ok").unwrap().values,
        Values::Integers(vec![1])
    );
    assert_eq!(reader.text("t").unwrap(), "ü text");
    let error = |file: &str| {
        NpzReader::open(folder.path(file))
            .err()
            .unwrap()
            .to_string()
    };
    let packed = NpzReader::open(folder.path("c.npz")).unwrap();
    let expected: Vec<f64> = (0..100_000).map(|k| f64::from(k % 77) / 7.0).collect();
    assert_eq!(packed.floats("x").unwrap(), expected);
    assert_eq!(packed.integers("n").unwrap(), [0, 1, 2, 3, 4, 5]);
    assert_eq!(packed.text("t").unwrap(), "ü text");
    assert!(packed.floats("e").unwrap().is_empty());
    // One bit wrong in what is compressed is told, wherever it is.
    let whole = std::fs::read(folder.path("c.npz")).unwrap();
    for place in (60..whole.len() / 2).step_by(97) {
        let mut damaged = whole.clone();
        damaged[place] ^= 4;
        std::fs::write(folder.path("d.npz"), damaged).unwrap();
        let read = NpzReader::open(folder.path("d.npz")).and_then(|file| file.floats("x"));
        assert!(read.is_err(), "byte {place}");
    }
    assert!(error("f.npz").contains("'<f4'"));
}
