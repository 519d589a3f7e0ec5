//! A specification checked against a map: rows, pieces and what is needed to compute them.

use super::error::DiagramError;
use super::spec::check::{self, Places};
use super::spec::observable::Observable;
use super::spec::random::Generator;
use super::spec::range::Swept;
use super::spec::{Record, Spec, Start};
use crate::analysis::map::Map;

/// The rows of a diagram: for each value of the second range each value of the first, for each of these its starts: the
/// random ones, or upwards and downwards. Rows that have to be computed one after the other are a piece.
#[derive(Clone, Debug)]
pub struct Sweep {
    spec: Spec,
    /// Positions of the swept parameters.
    pub(super) swept: Vec<usize>,
    /// Positions of the coordinates whose initial values are swept.
    initial: Vec<usize>,
    coordinates: Vec<String>,
    pub(super) observables: Vec<Observable>,
    /// Positions of the coordinates that are drawn at random.
    drawn: Vec<usize>,
    starts: u64,
    rows: u64,
    pieces: Pieces,
}

/// How rows are cut into pieces.
#[derive(Clone, Copy, Debug)]
struct Pieces {
    /// How many there are.
    count: u64,
    /// Values of a line that are carried through.
    columns: u64,
    /// How many times each line is carried through.
    passes: u64,
    chunk: u64,
}

impl Pieces {
    fn chunks(&self) -> u64 {
        self.columns.div_ceil(self.chunk)
    }

    /// The line and the pass of a piece, and the first column.
    fn place(&self, piece: u64) -> (u64, u64, u64) {
        let line = self.chunks() * self.passes;
        let within = piece % line;
        let first = within % self.chunks() * self.chunk;
        (piece / line, within / self.chunks(), first)
    }
}

impl Sweep {
    /// Names of the columns of the result that hold what each row was classified as.
    pub const CLASS_NAMES: [&'static str; 6] = [
        "outcome",
        "period",
        "impacts_per_return",
        "exponent",
        "start",
        "attractor",
    ];
    /// Name of the column that says which row a sample belongs to.
    pub const COLUMN_NAME: &'static str = "column";

    /// Checks a specification against a map and resolves its names.
    ///
    /// # Errors
    /// The first thing that is wrong with the specification.
    pub fn new(map: &dyn Map, spec: &Spec) -> Result<Self, DiagramError> {
        let places = check::places(map, spec)?;
        check::numbers(spec)?;
        let observables = check::observed(map, spec)?;
        check::carry(map, spec, &places)?;
        let Places {
            parameters,
            initial,
        } = places;
        let (starts, drawn) = match &spec.start {
            Start::Random { count, bounds, .. } => {
                if *count == 0 || bounds.is_empty() {
                    return Err(DiagramError::NoStarts);
                }
                (*count, check::drawn(map, bounds, &initial)?)
            }
            Start::Fresh | Start::CarryUp | Start::CarryDown => (1, Vec::new()),
            Start::CarryBoth => (2, Vec::new()),
        };
        let count = spec.sweeps[0].count;
        let lines = spec.sweeps.get(1).map_or(1, |range| range.count);
        let rows = count
            .checked_mul(lines)
            .and_then(|rows| rows.checked_mul(starts))
            .ok_or(DiagramError::TooManyRows)?;
        let mut pieces = match spec.start {
            Start::Fresh | Start::Random { .. } => Pieces {
                count: 0,
                columns: count * starts,
                passes: 1,
                chunk: 1,
            },
            Start::CarryUp | Start::CarryDown | Start::CarryBoth => Pieces {
                count: 0,
                columns: count,
                passes: starts,
                chunk: spec.chunk.unwrap_or(count),
            },
        };
        pieces.count = pieces.chunks() * pieces.passes * lines;
        Ok(Self {
            spec: spec.clone(),
            swept: parameters,
            initial,
            coordinates: map.coordinates(),
            observables,
            drawn,
            starts,
            rows,
            pieces,
        })
    }

    /// What was asked for.
    pub fn spec(&self) -> &Spec {
        &self.spec
    }

    /// How many rows the result has.
    pub fn rows(&self) -> u64 {
        self.rows
    }

    /// How many rows each value (pair of values) of the sweep has.
    pub fn starts(&self) -> u64 {
        self.starts
    }

    /// Names of the coordinates of points.
    pub fn coordinates(&self) -> &[String] {
        &self.coordinates
    }

    /// About how many numbers each sample of a row takes up while it is computed.
    pub(super) fn row_width(&self) -> u64 {
        // Impacts, time and accumulations beside what is observed.
        self.observables.len() as u64 + 3
    }

    /// How many pieces can be computed independently.
    pub fn pieces(&self) -> u64 {
        self.pieces.count
    }

    /// How many rows a piece has.
    pub fn piece_rows(&self, piece: u64) -> u64 {
        let (_, _, first) = self.pieces.place(piece);
        self.pieces.chunk.min(self.pieces.columns - first)
    }

    /// The row that a piece computes as its `index`-th.
    pub fn row(&self, piece: u64, index: u64) -> u64 {
        let Pieces {
            columns, passes, ..
        } = self.pieces;
        let (line, pass, first) = self.pieces.place(piece);
        let downwards = match self.spec.start {
            Start::CarryDown => true,
            Start::CarryBoth => pass == 1,
            Start::Fresh | Start::CarryUp | Start::Random { .. } => false,
        };
        let column = if downwards {
            first + self.piece_rows(piece) - 1 - index
        } else {
            first + index
        };
        (line * columns + column) * passes + pass
    }

    /// The piece that computes a row.
    pub fn piece_of(&self, row: u64) -> u64 {
        let Pieces {
            columns,
            passes,
            chunk,
            ..
        } = self.pieces;
        let (pass, column) = (row % passes, row / passes);
        let line = column / columns;
        (line * passes + pass) * self.pieces.chunks() + column % columns / chunk
    }

    /// The value of each range in a row.
    pub fn values(&self, row: u64) -> Vec<f64> {
        let ranges = self.spec.sweeps.iter().zip(self.indices(row));
        ranges.map(|(range, index)| range.value(index)).collect()
    }

    fn indices(&self, row: u64) -> [u64; 2] {
        let column = row / self.starts;
        let count = self.spec.sweeps[0].count;
        [column % count, column / count]
    }

    /// Values of what is swept of one kind in a row.
    fn values_of(&self, row: u64, swept: Swept) -> impl Iterator<Item = f64> {
        let ranges = self.spec.sweeps.iter().zip(self.values(row));
        ranges.filter_map(move |(range, value)| (range.swept == swept).then_some(value))
    }

    /// Values of the swept parameters in a row.
    pub(super) fn parameters(&self, row: u64) -> Vec<f64> {
        self.values_of(row, Swept::Parameter).collect()
    }

    /// All parameters of a row.
    pub(super) fn all_parameters(&self, map: &dyn Map, row: u64) -> Vec<f64> {
        let values = self.values_of(row, Swept::Parameter);
        let swept: Vec<(usize, f64)> = self.swept.iter().copied().zip(values).collect();
        map.parameter_values(&swept)
    }

    /// Rows at the same values of the parameters have the same number, from zero.
    pub fn group(&self, row: u64) -> u64 {
        let ranges = self.spec.sweeps.iter().zip(self.indices(row));
        ranges
            .filter(|(range, _)| range.swept == Swept::Parameter)
            .fold((0, 1), |(group, stride), (range, index)| {
                (group + stride * index, stride * range.count)
            })
            .0
    }

    /// How many different values the parameters take.
    pub fn groups(&self) -> u64 {
        self.group_counts().1
    }

    /// Counts of the parameter values: of the first range, and of all.
    fn group_counts(&self) -> (u64, u64) {
        let mut parameters =
            (self.spec.sweeps.iter()).filter(|range| range.swept == Swept::Parameter);
        let first = parameters.next().map_or(1, |range| range.count);
        (
            first,
            first * parameters.next().map_or(1, |range| range.count),
        )
    }

    /// The group of the neighbouring parameter values: the next lower ones of the first parameter, else of the second.
    pub(super) fn group_before(&self, group: u64) -> Option<u64> {
        let (line, _) = self.group_counts();
        match group % line {
            0 => group.checked_sub(line),
            _ => Some(group - 1),
        }
    }

    /// Groups from which groups after this one go on.
    pub(super) fn groups_needed_after(&self, group: u64) -> [u64; 2] {
        let (line, _) = self.group_counts();
        [group, group - group % line]
    }

    /// Whether all rows of a group stand one after the other.
    pub(super) fn groups_stand_together(&self) -> bool {
        let kinds: Vec<Swept> = self.spec.sweeps.iter().map(|range| range.swept).collect();
        kinds != [Swept::Parameter, Swept::Initial]
    }

    /// Whether orbits from different starts are compared at the same parameters.
    pub fn compares(&self) -> bool {
        self.rows > self.groups()
    }

    /// Whether a row hands its last point on to the next of its piece.
    pub(super) fn carries(&self) -> bool {
        matches!(
            self.spec.start,
            Start::CarryUp | Start::CarryDown | Start::CarryBoth
        )
    }

    /// Whether a row keeps its samples.
    pub(super) fn records(&self) -> bool {
        self.spec.record == Record::Samples
    }

    /// Where the orbit of a row starts, unless it is carried: with the swept initial values and, at the attempt-th
    /// attempt, the coordinates that are drawn at random.
    pub(super) fn first_point(&self, row: u64, attempt: u64, initial: &[f64]) -> Vec<f64> {
        let mut point = initial.to_vec();
        for (&index, value) in self.initial.iter().zip(self.values_of(row, Swept::Initial)) {
            point[index] = value;
        }
        if let Start::Random { seed, bounds, .. } = &self.spec.start {
            let mut generator = Generator::of_row(*seed, row);
            for _ in 0..=attempt {
                for (&index, bounds) in self.drawn.iter().zip(bounds) {
                    point[index] = generator.between(bounds.from, bounds.to);
                }
            }
        }
        point
    }

    /// Whether rows start at random points.
    pub(super) fn draws(&self) -> bool {
        !self.drawn.is_empty()
    }
}
