//! Columns of numbers from the text of a file: fields between commas, semicolons, tabs or blanks, `#` before comments, and
//! a line of names at the top or not.

use crate::expressions::{MOST_KNOTS, nearest};
use crate::model::names::alternatives;
use crate::numerics::DoubleDouble;
use core::fmt;
use core::ops::Range;

/// What gives the text of a file that a model names, or says why it cannot.
pub type Loader<'a> = dyn FnMut(&str) -> Result<String, String> + 'a;

/// What is wrong with a file of numbers.
#[derive(Clone, PartialEq, Debug)]
pub enum DataFileError {
    /// There is no text.
    Unavailable {
        /// Why.
        reason: String,
    },
    /// No line of numbers.
    Empty,
    /// More lines than a table has knots.
    TooLong {
        /// How many.
        lines: usize,
    },
    /// No column of this name.
    NoColumn {
        /// The name.
        name: String,
        /// The names there are.
        known: Vec<String>,
        /// The one probably meant.
        nearest: Option<String>,
    },
    /// A name for a column, and no line of names.
    NoNames {
        /// The name.
        name: String,
    },
    /// Two columns of this name.
    TwoColumns {
        /// The name.
        name: String,
    },
    /// Fewer columns.
    FewColumns {
        /// The number of the column that is meant, from 1.
        wanted: usize,
        /// How many there are.
        columns: usize,
    },
    /// A line that has not as many fields as the first.
    Ragged {
        /// How many it has.
        fields: usize,
        /// How many the first has.
        columns: usize,
    },
    /// A field that is no number.
    NotANumber {
        /// The field.
        text: String,
    },
    /// A field that is a number too small to be told from zero.
    OutOfRange {
        /// The field.
        text: String,
    },
    /// A quotation mark that is not closed.
    Unclosed,
}

impl core::error::Error for DataFileError {}

impl fmt::Display for DataFileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unavailable { reason } => write!(f, "{reason}"),
            Self::Empty => write!(f, "no numbers"),
            Self::TooLong { lines } => write!(f, "{lines} lines"),
            Self::NoColumn { name, .. } | Self::NoNames { name } => write!(f, "no column `{name}`"),
            Self::TwoColumns { name } => write!(f, "two columns `{name}`"),
            Self::FewColumns { wanted, .. } => write!(f, "no column {wanted}"),
            Self::Ragged { fields, .. } => write!(f, "a line of {}", columns(*fields)),
            Self::NotANumber { text } if text.is_empty() => write!(f, "a number is missing"),
            Self::NotANumber { text } => write!(f, "`{text}` is not a number"),
            Self::OutOfRange { text } => write!(f, "the number `{text}` is out of range"),
            Self::Unclosed => write!(f, "a quotation mark is not closed"),
        }
    }
}

fn columns(count: usize) -> String {
    match count {
        1 => "1 column".to_owned(),
        _ => format!("{count} columns"),
    }
}

impl DataFileError {
    /// The words at the underlined text.
    pub(in crate::model) fn label(&self) -> Option<String> {
        Some(match self {
            Self::Unavailable { .. } | Self::Unclosed => return None,
            Self::Empty => "expected a line for each knot".to_owned(),
            Self::TooLong { .. } => format!("expected {MOST_KNOTS} at most"),
            Self::NoColumn { known, .. } => format!("expected {}", alternatives(known)),
            Self::NoNames { .. } => {
                "expected its number, from 1: its columns have no names".to_owned()
            }
            Self::TwoColumns { .. } => "expected its number, from 1".to_owned(),
            Self::FewColumns { columns: found, .. } => format!("it has {}", columns(*found)),
            Self::Ragged { columns: first, .. } => format!("the first line has {first}"),
            Self::NotANumber { .. } => "expected a number such as 0.5, 12 or 1e-3".to_owned(),
            Self::OutOfRange { .. } => {
                "expected zero, or a size between 5e-324 and 1.7e308".to_owned()
            }
        })
    }

    /// What to do about it.
    pub(in crate::model) fn help(&self) -> Option<String> {
        match self {
            Self::NoColumn { nearest, .. } => {
                Some(format!("did you mean `{}`?", nearest.as_ref()?))
            }
            Self::NotANumber { text } => {
                let point = text.replacen(',', ".", 1);
                let is_number = point != *text && point.parse::<f64>().is_ok();
                is_number.then(|| format!("decimals follow a point: {point}"))
            }
            Self::FewColumns { .. } => {
                let help = "columns = [1, 2] says which two are meant, by number or name";
                Some(help.to_owned())
            }
            _ => None,
        }
    }
}

/// Which column is meant.
pub(in crate::model) enum Wanted {
    /// This one, from 1.
    Number(usize),
    /// The one of this name.
    Name(String),
}

/// Numbers of a column, and the bytes of the text that they stand in.
#[derive(Default)]
pub(in crate::model) struct Numbers {
    pub numbers: Vec<DoubleDouble>,
    pub spans: Vec<Range<usize>>,
}

/// What an error is about.
#[derive(Debug, PartialEq)]
pub(in crate::model) enum Where {
    /// The file.
    File,
    /// The column that was asked for so manieth.
    Wanted(usize),
    /// These bytes of it.
    Text(Range<usize>),
}

/// The two columns of a text.
pub(in crate::model) fn read_columns(
    text: &str,
    wanted: &[Wanted; 2],
) -> Result<[Numbers; 2], (DataFileError, Where)> {
    let mut lines = content(text).peekable();
    let Some(first) = lines.peek() else {
        return Err((DataFileError::Empty, Where::File));
    };
    let separator = Separator::of(&text[first.clone()]);
    let fields = separator.fields(text, first.clone())?;
    let columns = fields.len();
    let has_names =
        (fields.iter()).all(|field| text[field.clone()].parse::<DoubleDouble>().is_err());
    let names: Vec<&str> = match has_names {
        true => fields.iter().map(|field| &text[field.clone()]).collect(),
        false => Vec::new(),
    };
    let mut places = [0; 2];
    for (order, (place, wanted)) in places.iter_mut().zip(wanted).enumerate() {
        *place = find(wanted, &names, columns).map_err(|error| (error, Where::Wanted(order)))?;
    }
    if has_names {
        lines.next();
    }
    let mut found = [Numbers::default(), Numbers::default()];
    let mut count = 0;
    for line in lines {
        count += 1;
        // Further ones are counted only.
        if count > MOST_KNOTS {
            continue;
        }
        let fields = separator.fields(text, line.clone())?;
        if fields.len() != columns {
            let fields = fields.len();
            let error = DataFileError::Ragged { fields, columns };
            return Err((error, Where::Text(line)));
        }
        for (column, &place) in found.iter_mut().zip(&places) {
            let span = fields[place].clone();
            let Ok(number) = text[span.clone()].parse::<DoubleDouble>() else {
                let text = text[span.clone()].to_owned();
                let error = DataFileError::NotANumber { text };
                // An empty field shows nothing to underline.
                let shown = if span.is_empty() { line } else { span };
                return Err((error, Where::Text(shown)));
            };
            if number.is_lost_of(&text[span.clone()]) {
                let text = text[span.clone()].to_owned();
                return Err((DataFileError::OutOfRange { text }, Where::Text(span)));
            }
            column.numbers.push(number);
            column.spans.push(span);
        }
    }
    match count {
        0 => Err((DataFileError::Empty, Where::File)),
        lines if lines > MOST_KNOTS => Err((DataFileError::TooLong { lines }, Where::File)),
        _ => Ok(found),
    }
}

fn find(wanted: &Wanted, names: &[&str], columns: usize) -> Result<usize, DataFileError> {
    let name = match wanted {
        Wanted::Number(number) if (1..=columns).contains(number) => return Ok(number - 1),
        &Wanted::Number(wanted) => return Err(DataFileError::FewColumns { wanted, columns }),
        Wanted::Name(name) => name.clone(),
    };
    if names.is_empty() {
        return Err(DataFileError::NoNames { name });
    }
    let mut places = names
        .iter()
        .enumerate()
        .filter(|(_, known)| **known == name);
    match (places.next(), places.next()) {
        (Some((place, _)), None) => Ok(place),
        (Some(_), Some(_)) => Err(DataFileError::TwoColumns { name }),
        (None, _) => Err(DataFileError::NoColumn {
            nearest: nearest(&name, names.iter().copied()),
            known: names.iter().map(|&known| known.to_owned()).collect(),
            name,
        }),
    }
}

/// What some programs put before all else.
const BYTE_ORDER_MARK: char = '\u{feff}';

/// The lines that are neither blank nor comments, without their ends.
fn content(text: &str) -> impl Iterator<Item = Range<usize>> {
    let mut next = 0;
    text.split_inclusive('\n').filter_map(move |line| {
        let start = next;
        next += line.len();
        let skipped = if start == 0 { BYTE_ORDER_MARK } else { ' ' };
        let inner = line.trim_start_matches(skipped);
        let span = trimmed(line, start + line.len() - inner.len()..next, start);
        (!span.is_empty() && !line[span.start - start..].starts_with('#')).then_some(span)
    })
}

/// A stretch of `text`, which begins at byte `offset`, without the blanks at its ends.
fn trimmed(text: &str, span: Range<usize>, offset: usize) -> Range<usize> {
    let whole = &text[span.start - offset..span.end - offset];
    let start = span.start + whole.len() - whole.trim_start().len();
    start..start + whole.trim().len()
}

/// What stands between fields.
#[derive(Clone, Copy)]
enum Separator {
    Character(char),
    Blanks,
}

impl Separator {
    /// That of the file whose first line this is: a semicolon goes before a comma, which may stand in a name.
    fn of(line: &str) -> Self {
        let mut quoted = false;
        let bare: String = line
            .chars()
            .filter(|&c| {
                quoted ^= c == '"';
                !quoted
            })
            .collect();
        [';', ',', '\t']
            .into_iter()
            .find(|&c| bare.contains(c))
            .map_or(Self::Blanks, Self::Character)
    }

    /// The fields of a line, without blanks and quotation marks around them.
    fn fields(
        self,
        text: &str,
        line: Range<usize>,
    ) -> Result<Vec<Range<usize>>, (DataFileError, Where)> {
        let mut fields = Vec::new();
        let mut at = line.start;
        loop {
            let rest = &text[at..line.end];
            let lead = rest.len() - rest.trim_start_matches([' ', '\t']).len();
            // A tab that separates is no blank before a field.
            let lead = match self {
                Self::Character('\t') => rest.len() - rest.trim_start_matches(' ').len(),
                _ => lead,
            };
            let start = at + lead;
            let mut end = if text[start..line.end].starts_with('"') {
                let Some(length) = text[start + 1..line.end].find('"') else {
                    return Err((DataFileError::Unclosed, Where::Text(start..line.end)));
                };
                let inside = start + 1..start + 1 + length;
                fields.push(trimmed(text, inside.clone(), 0));
                inside.end + 1
            } else {
                let end = self
                    .find(&text[start..line.end])
                    .map_or(line.end, |n| start + n);
                fields.push(trimmed(text, start..end, 0));
                end
            };
            // On to the separator, which nothing else may come before.
            let after = trimmed(text, end..line.end, 0);
            match self {
                Self::Blanks if after.is_empty() => return Ok(fields),
                Self::Blanks => at = after.start,
                Self::Character(separator) => {
                    match self.find(&text[end..line.end]) {
                        None => return Ok(fields),
                        Some(length) => end += length,
                    }
                    at = end + separator.len_utf8();
                }
            }
        }
    }

    fn find(self, text: &str) -> Option<usize> {
        match self {
            Self::Character(separator) => text.find(separator),
            Self::Blanks => text.find(char::is_whitespace),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn numbers(text: &str, wanted: [Wanted; 2]) -> [Vec<f64>; 2] {
        let columns =
            read_columns(text, &wanted).unwrap_or_else(|error| panic!("{text:?}: {error:?}"));
        columns.map(|column| column.numbers.iter().map(|number| number.high()).collect())
    }

    fn first_two() -> [Wanted; 2] {
        [Wanted::Number(1), Wanted::Number(2)]
    }

    fn named(x: &str, y: &str) -> [Wanted; 2] {
        [x, y].map(|name| Wanted::Name(name.to_owned()))
    }

    #[test]
    fn separators_headings_comments_and_line_ends_may_be_any() {
        for text in [
            "0,1\n.5,2\n",
            "0;1\n.5;2",
            "0\t1\r\n.5\t2\r\n",
            "0 1\n.5    2\n",
            "  0 1  \n\n\n .5 \t 2",
            "\u{feff}angle,lift\n0,1\n.5,2\n",
            "# measured\n\n\"angle (deg, true)\";lift\n0 ; 1\n # again\n5e-1;\"2\"\n",
            "\u{feff}# measured\n0, 1\n+0.5, 2.0",
            "angle lift\n0 1\n0.5 2\n",
        ] {
            assert_eq!(numbers(text, first_two()), [vec![0.0, 0.5], vec![1.0, 2.0]]);
        }
        let three = "time,lift (mm),angle\nmorning,1,0\nnoon,2,90\n";
        assert_eq!(
            numbers(three, named("angle", "lift (mm)")),
            [vec![0.0, 90.0], vec![1.0, 2.0]]
        );
        assert_eq!(
            numbers("a\t\tb\n1\t\t2\n", [Wanted::Number(3), Wanted::Number(1)]),
            [vec![2.0], vec![1.0]]
        );
    }

    #[test]
    fn every_number_knows_its_place() {
        let text = "# é\nangle;lift\n 0.25 ; 1e3\n";
        let [x, y] = read_columns(text, &first_two()).unwrap_or_default();
        assert_eq!(
            (&text[x.spans[0].clone()], &text[y.spans[0].clone()]),
            ("0.25", "1e3")
        );
    }

    #[test]
    fn what_is_wrong_is_told_with_its_place() {
        let table: [(&str, [Wanted; 2], &str, &str); 12] = [
            ("", first_two(), "no numbers", "FILE"),
            ("# only words\nx,y\n", first_two(), "no numbers", "FILE"),
            ("1,2\n3,4,5\n", first_two(), "a line of 3 columns", "3,4,5"),
            ("1,2\n3,a\n", first_two(), "`a` is not a number", "a"),
            ("1,2\n3,\n", first_two(), "a number is missing", "3,"),
            ("1;2\n1,5;3\n", first_two(), "`1,5` is not a number", "1,5"),
            ("1\n2\n", first_two(), "no column 2", "WANTED 1"),
            (
                "1,2\n",
                [Wanted::Number(0), Wanted::Number(1)],
                "no column 0",
                "WANTED 0",
            ),
            ("a,b\n1,2\n", named("a", "c"), "no column `c`", "WANTED 1"),
            ("1,2\n", named("a", "b"), "no column `a`", "WANTED 0"),
            ("a,a\n1,2\n", named("a", "b"), "two columns `a`", "WANTED 0"),
            (
                "\"a,b\n1,2\n",
                first_two(),
                "a quotation mark is not closed",
                "\"a,b",
            ),
        ];
        for (text, wanted, message, place) in table {
            let Err((error, at)) = read_columns(text, &wanted) else {
                panic!("{text:?} was read");
            };
            let at = match at {
                Where::File => "FILE".to_owned(),
                Where::Wanted(order) => format!("WANTED {order}"),
                Where::Text(span) => text[span].to_owned(),
            };
            assert_eq!((&*error.to_string(), &*at), (message, place), "{text:?}");
        }
        let long = "1 2\n".repeat(MOST_KNOTS + 1);
        let error = read_columns(&long, &first_two()).err();
        let lines = MOST_KNOTS + 1;
        assert_eq!(error, Some((DataFileError::TooLong { lines }, Where::File)));
    }

    proptest! {
        #[test]
        fn any_text_is_read_or_refused_at_a_place(
            parts in prop::collection::vec(
                prop_oneof![
                    any::<char>().prop_map(String::from),
                    prop::sample::select(vec![
                        "0", "1.5", "-2e3", ",", ";", "\t", " ", "\n", "\r\n", "#", "\"", "a", "é", "\u{feff}", "nan", "\u{a0}",
                    ]).prop_map(str::to_owned),
                ],
                0..40,
            ),
            by_name in any::<bool>(),
        ) {
            let text = parts.concat();
            let wanted = if by_name { named("a", "é") } else { first_two() };
            match read_columns(&text, &wanted) {
                Ok([x, y]) => {
                    prop_assert_eq!(x.numbers.len(), y.numbers.len());
                    for (number, span) in x.numbers.iter().zip(&x.spans) {
                        let read: DoubleDouble = text[span.clone()].parse().unwrap();
                        prop_assert!(read == *number || number.high().is_nan());
                    }
                }
                Err((_, Where::Text(span))) => prop_assert!(text.get(span).is_some_and(|text| !text.is_empty())),
                Err(_) => {}
            }
        }
    }
}
