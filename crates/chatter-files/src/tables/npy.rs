//! NumPy's array header (NPY format, versions 1 to 3) and the element types that are written and read.

use std::fmt;

/// What an array holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// `<f8`: double-precision numbers.
    Float,
    /// `<i8`: integers.
    Integer,
    /// `|b1`: truth values, which others write.
    Boolean,
    /// `<U…`: text of at most so many characters, four bytes each.
    Text {
        /// Longest text in characters.
        width: usize,
    },
}

impl Kind {
    /// Bytes of one element.
    pub fn size(self) -> usize {
        match self {
            Kind::Float | Kind::Integer => 8,
            Kind::Boolean => 1,
            Kind::Text { width } => 4 * width,
        }
    }

    fn descr(self) -> String {
        match self {
            Kind::Float => "<f8".to_string(),
            Kind::Integer => "<i8".to_string(),
            Kind::Boolean => "|b1".to_string(),
            Kind::Text { width } => format!("<U{width}"),
        }
    }

    fn from_descr(descr: &str) -> Option<Kind> {
        match descr {
            "<f8" => Some(Kind::Float),
            "<i8" => Some(Kind::Integer),
            "|b1" => Some(Kind::Boolean),
            _ => {
                let width = descr.strip_prefix("<U")?.parse().ok()?;
                // Wider than memory can be is no width.
                let _: usize = 4_usize.checked_mul(width)?;
                Some(Kind::Text { width })
            }
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Kind::Float => "floating-point numbers",
            Kind::Integer => "integers",
            Kind::Boolean => "truth values",
            Kind::Text { .. } => "text",
        })
    }
}

/// Name, kind and shape of one array of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ArrayInfo {
    /// Its name in the archive, without `.npy`.
    pub name: String,
    /// What it holds.
    pub kind: Kind,
    /// Its shape in row-major order; empty for a scalar.
    pub shape: Vec<usize>,
}

impl ArrayInfo {
    /// Number of elements.
    pub fn len(&self) -> usize {
        self.shape.iter().product()
    }

    /// Whether it has no elements.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// A number type that arrays are made of.
pub trait Element: Copy + sealed::Sealed {
    /// What an array of it holds.
    const KIND: Kind;
    /// Appends its bytes, little end first.
    fn put(self, bytes: &mut Vec<u8>);
    /// The value of that many bytes.
    fn take(bytes: &[u8]) -> Self;
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for f64 {}
    impl Sealed for i64 {}
}

impl Element for f64 {
    const KIND: Kind = Kind::Float;
    fn put(self, bytes: &mut Vec<u8>) {
        bytes.extend_from_slice(&self.to_le_bytes());
    }
    fn take(bytes: &[u8]) -> Self {
        f64::from_le_bytes(bytes.try_into().expect("eight bytes"))
    }
}

impl Element for i64 {
    const KIND: Kind = Kind::Integer;
    fn put(self, bytes: &mut Vec<u8>) {
        bytes.extend_from_slice(&self.to_le_bytes());
    }
    fn take(bytes: &[u8]) -> Self {
        i64::from_le_bytes(bytes.try_into().expect("eight bytes"))
    }
}

/// Length of every header written: room for any shape, and a multiple of 64, as the format asks for.
pub(super) const HEADER_LENGTH: usize = 192;

const MAGIC: &[u8; 6] = b"\x93NUMPY";

/// The header of format version 1.0, padded to [`HEADER_LENGTH`].
pub(super) fn header(kind: Kind, shape: &[u64]) -> [u8; HEADER_LENGTH] {
    let lengths: Vec<String> = shape.iter().map(u64::to_string).collect();
    let shape = match lengths.as_slice() {
        [single] => format!("({single},)"),
        many => format!("({})", many.join(", ")),
    };
    let text = format!(
        "{{'descr': '{}', 'fortran_order': False, 'shape': {shape}, }}",
        kind.descr()
    );
    let mut header = [b' '; HEADER_LENGTH];
    header[..6].copy_from_slice(MAGIC);
    header[6..8].copy_from_slice(&[1, 0]);
    header[8..10].copy_from_slice(&((HEADER_LENGTH - 10) as u16).to_le_bytes());
    header[10..10 + text.len()].copy_from_slice(text.as_bytes());
    header[HEADER_LENGTH - 1] = b'\n';
    header
}

/// Bytes from the start of an array file that tell how long its header is.
pub(super) const PREFIX_LENGTH: usize = 12;

/// Most bytes of a header that is read: NumPy's own limit is 10,000.
const LONGEST_HEADER: usize = 1 << 20;

/// Total length of the header, from its first [`PREFIX_LENGTH`] bytes.
pub(super) fn header_length(prefix: &[u8; PREFIX_LENGTH]) -> Result<usize, String> {
    match claimed_length(prefix)? {
        length if length > LONGEST_HEADER => Err(format!(
            "its header has {length} bytes, more than {LONGEST_HEADER}"
        )),
        length => Ok(length),
    }
}

fn claimed_length(prefix: &[u8; PREFIX_LENGTH]) -> Result<usize, String> {
    if &prefix[..6] != MAGIC {
        return Err("it does not start as an array file does".to_string());
    }
    match prefix[6] {
        1 => Ok(10 + usize::from(u16::from_le_bytes([prefix[8], prefix[9]]))),
        2 | 3 => {
            let length = u32::from_le_bytes([prefix[8], prefix[9], prefix[10], prefix[11]]);
            Ok((length as usize).saturating_add(12))
        }
        other => Err(format!("its format version {other} is unknown")),
    }
}

/// Kind and shape from a whole header.
pub(super) fn parse_header(header: &[u8]) -> Result<(Kind, Vec<usize>), String> {
    let start = if header[6] == 1 { 10 } else { 12 };
    let text =
        std::str::from_utf8(&header[start..]).map_err(|_| "its header is not text".to_string())?;
    let value = |key: &str| -> Result<&str, String> {
        let at = text
            .find(&format!("'{key}'"))
            .ok_or_else(|| format!("its header lacks '{key}'"))?;
        let rest = &text[at + key.len() + 2..];
        Ok(rest.trim_start().trim_start_matches(':').trim_start())
    };
    let descr = value("descr")?;
    let descr = descr
        .strip_prefix('\'')
        .and_then(|d| d.split('\'').next())
        .ok_or_else(|| "it holds records, which are not read".to_string())?;
    let kind = Kind::from_descr(descr).ok_or_else(|| {
        format!("its type '{descr}' is not read; '<f8', '<i8', '|b1' and '<U…' are")
    })?;
    let shape = value("shape")?;
    let shape = shape
        .strip_prefix('(')
        .and_then(|s| s.split(')').next())
        .ok_or_else(|| "its shape is not a tuple".to_string())?;
    let shape: Vec<usize> = shape
        .split(',')
        .map(str::trim)
        .filter(|s| !s.is_empty())
        .map(|s| s.parse().map_err(|_| format!("its shape holds `{s}`")))
        .collect::<Result<_, _>>()?;
    let size = shape
        .iter()
        .try_fold(kind.size().max(1), |n, &k| n.checked_mul(k.max(1)))
        .ok_or_else(|| "its shape is larger than memory can be".to_string())?;
    if kind.size() == 0 && size > 1 {
        return Err("its texts have no width, and nothing says that there are so many".to_string());
    }
    if value("fortran_order")?.starts_with("True") && shape.len() > 1 {
        return Err("it is stored in column-major order, which is not read".to_string());
    }
    Ok((kind, shape))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_read_back() {
        for (kind, shape) in [
            (Kind::Float, vec![]),
            (Kind::Integer, vec![0]),
            (Kind::Boolean, vec![3, 4, 5]),
            (Kind::Text { width: 17 }, vec![usize::MAX >> 8]),
        ] {
            let lengths: Vec<u64> = shape.iter().map(|&length| length as u64).collect();
            let header = header(kind, &lengths);
            let length = header_length(header[..PREFIX_LENGTH].try_into().unwrap()).unwrap();
            assert_eq!(length, HEADER_LENGTH);
            assert_eq!(parse_header(&header).unwrap(), (kind, shape));
        }
    }

    #[test]
    fn what_is_not_read_is_said() {
        let mut header = header(Kind::Float, &[2]).to_vec();
        let at = header.windows(3).position(|w| w == b"<f8").unwrap();
        header[at..at + 3].copy_from_slice(b">f4");
        assert!(parse_header(&header).unwrap_err().contains(">f4"));
    }
}
