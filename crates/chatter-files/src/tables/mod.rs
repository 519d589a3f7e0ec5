//! Tables: named columns of numbers, truth values and text, written as CSV and NPZ, read back from NPZ.

mod archive;
mod array_stream;
mod csv;
mod error;
mod inflate;
mod npy;
mod npz_reader;
mod npz_writer;
mod spool;
mod table;

pub use array_stream::{FloatStream, TextStream};
pub use csv::{Cell, CsvWriter, csv_text, write_csv};
pub use error::TableError;
pub use npy::{ArrayInfo, Element, Kind};
pub use npz_reader::NpzReader;
pub use npz_writer::{ArrayWriter, NpzWriter};
pub use spool::Spool;
pub use table::{Column, Dataset, Table, Values};
