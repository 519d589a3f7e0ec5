//! A specification checked against a map: rows, pieces and what is needed to compute them.

use super::error::DiagramError;
use super::observable::Observable;
use super::random::Generator;
use super::spec::{Range, Record, Spacing, Spec, Start};
use crate::analysis::map::Map;

/// The rows of a diagram: for each value of the second parameter each value of the first, for each of these the random
/// starts. Rows that have to be computed one after the other are a piece.
#[derive(Clone, Debug)]
pub struct Sweep {
    spec: Spec,
    /// Positions of the swept parameters.
    pub(super) swept: Vec<usize>,
    pub(super) observables: Vec<Observable>,
    /// Positions of the coordinates that are drawn at random.
    drawn: Vec<usize>,
    starts: u64,
    chunk: u64,
    pieces_per_line: u64,
    rows: u64,
    pieces: u64,
}

impl Sweep {
    /// Names of the columns of the result that hold what each row was classified as.
    pub const CLASS_NAMES: [&'static str; 5] = [
        "outcome",
        "period",
        "impacts_per_return",
        "exponent",
        "start",
    ];
    /// Name of the column that says which row a sample belongs to.
    pub const COLUMN_NAME: &'static str = "column";

    /// Checks a specification against a map and resolves its names.
    ///
    /// # Errors
    /// The first thing that is wrong with the specification.
    pub fn new(map: &dyn Map, spec: &Spec) -> Result<Self, DiagramError> {
        let parameters = map.parameters();
        let coordinates = map.coordinates();
        if !(1..=2).contains(&spec.sweeps.len()) {
            return Err(DiagramError::SweepCount {
                count: spec.sweeps.len(),
            });
        }
        let mut swept = Vec::new();
        for range in &spec.sweeps {
            swept.push(check_range(range, &parameters, &swept)?);
        }
        check_numbers(spec)?;
        let observables = check_observed(map, spec, coordinates.len())?;
        let (starts, drawn) = match &spec.start {
            Start::Random { count, bounds, .. } => {
                if *count == 0 || bounds.is_empty() {
                    return Err(DiagramError::NoStarts);
                }
                let mut drawn = Vec::new();
                for bound in bounds {
                    let name = bound.coordinate.clone();
                    if !(bound.from.is_finite() && bound.to.is_finite() && bound.from <= bound.to) {
                        let (from, to) = (bound.from, bound.to);
                        return Err(DiagramError::Bounds { name, from, to });
                    }
                    match coordinates.iter().position(|known| *known == name) {
                        Some(index) => drawn.push(index),
                        None => {
                            let known = coordinates.clone();
                            return Err(DiagramError::UnknownCoordinate { name, known });
                        }
                    }
                }
                (*count, drawn)
            }
            Start::Fresh | Start::CarryUp | Start::CarryDown => (1, Vec::new()),
        };
        let count = spec.sweeps[0].count;
        let lines = spec.sweeps.get(1).map_or(1, |range| range.count);
        let rows = count
            .checked_mul(lines)
            .and_then(|rows| rows.checked_mul(starts))
            .ok_or(DiagramError::TooManyRows)?;
        let carries = matches!(spec.start, Start::CarryUp | Start::CarryDown);
        let chunk = match (carries, spec.chunk) {
            (false, _) => 1,
            (true, Some(0)) => return Err(DiagramError::EmptyChunks),
            (true, Some(chunk)) => chunk,
            (true, None) => Spec::usual_chunk(count),
        };
        let pieces_per_line = (count * starts).div_ceil(chunk);
        Ok(Self {
            spec: spec.clone(),
            swept,
            observables,
            drawn,
            starts,
            chunk,
            pieces_per_line,
            rows,
            pieces: pieces_per_line * lines,
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

    /// How many pieces can be computed independently.
    pub fn pieces(&self) -> u64 {
        self.pieces
    }

    /// How many rows a piece has.
    pub fn piece_rows(&self, piece: u64) -> u64 {
        let line = self.spec.sweeps[0].count * self.starts;
        let first = piece % self.pieces_per_line * self.chunk;
        self.chunk.min(line - first)
    }

    /// The row that a piece computes as its `index`-th.
    pub fn row(&self, piece: u64, index: u64) -> u64 {
        let line = piece / self.pieces_per_line * self.spec.sweeps[0].count * self.starts;
        let first = piece % self.pieces_per_line * self.chunk;
        match self.spec.start {
            Start::CarryDown => line + first + self.piece_rows(piece) - 1 - index,
            _ => line + first + index,
        }
    }

    /// The piece that computes a row.
    pub fn piece_of(&self, row: u64) -> u64 {
        let line = self.spec.sweeps[0].count * self.starts;
        row / line * self.pieces_per_line + row % line / self.chunk
    }

    /// Values of the swept parameters in a row.
    pub fn values(&self, row: u64) -> Vec<f64> {
        let column = row / self.starts;
        let count = self.spec.sweeps[0].count;
        let indices = [column % count, column / count];
        let ranges = self.spec.sweeps.iter().zip(indices);
        ranges.map(|(range, index)| range.value(index)).collect()
    }

    /// Whether a row hands its last point on to the next of its piece.
    pub(super) fn carries(&self) -> bool {
        matches!(self.spec.start, Start::CarryUp | Start::CarryDown)
    }

    /// Whether a row keeps its samples.
    pub(super) fn records(&self) -> bool {
        self.spec.record == Record::Samples
    }

    /// Whether rows start at random points.
    pub(super) fn draws(&self) -> bool {
        !self.drawn.is_empty()
    }

    /// Random starting points of a row: the attempt-th one.
    pub(super) fn draw(&self, row: u64, attempt: u64, initial: &[f64]) -> Option<Vec<f64>> {
        let Start::Random { seed, bounds, .. } = &self.spec.start else {
            return None;
        };
        let mut generator = Generator::of_row(*seed, row);
        let mut point = initial.to_vec();
        for _ in 0..=attempt {
            for (&coordinate, bound) in self.drawn.iter().zip(bounds) {
                point[coordinate] = generator.between(bound.from, bound.to);
            }
        }
        Some(point)
    }
}

fn check_range(
    range: &Range,
    parameters: &[String],
    swept: &[usize],
) -> Result<usize, DiagramError> {
    let name = range.parameter.clone();
    let Some(index) = parameters.iter().position(|known| *known == name) else {
        let known = parameters.to_vec();
        return Err(DiagramError::UnknownParameter { name, known });
    };
    if swept.contains(&index) {
        return Err(DiagramError::SweptTwice { name });
    }
    if range.count == 0 {
        return Err(DiagramError::NoValues { name });
    }
    let finite = range.from.is_finite() && range.to.is_finite();
    let ordered = range.from < range.to || (range.count == 1 && range.from == range.to);
    let spaced = range.spacing == Spacing::Linear || range.from > 0.0;
    if finite && ordered && spaced {
        Ok(index)
    } else {
        let range = range.clone();
        Err(DiagramError::Ends { range })
    }
}

fn check_numbers(spec: &Spec) -> Result<(), DiagramError> {
    if spec.keep == 0 {
        return Err(DiagramError::KeepsNothing);
    }
    if spec.every == 0 {
        return Err(DiagramError::EveryZeroth);
    }
    if spec.longest_period == 0 {
        return Err(DiagramError::NoPeriods);
    }
    if !(spec.period_tolerance > 0.0 && spec.period_tolerance < 1.0) {
        return Err(DiagramError::PeriodTolerance {
            value: spec.period_tolerance,
        });
    }
    Ok(())
}

fn check_observed(
    map: &dyn Map,
    spec: &Spec,
    dimension: usize,
) -> Result<Vec<Observable>, DiagramError> {
    if spec.observe.is_empty() {
        return Err(DiagramError::NothingObserved);
    }
    let mut taken: Vec<&str> = Sweep::CLASS_NAMES.to_vec();
    taken.push(Sweep::COLUMN_NAME);
    taken.extend(spec.sweeps.iter().map(|range| range.parameter.as_str()));
    let scope = map.scope();
    let mut observables = Vec::new();
    for observed in &spec.observe {
        if taken.contains(&observed.name.as_str()) {
            let name = observed.name.clone();
            return Err(DiagramError::NameTaken { name });
        }
        taken.push(&observed.name);
        let observable =
            Observable::new(&scope, dimension, &observed.expression).map_err(|error| {
                DiagramError::Observable {
                    text: observed.expression.clone(),
                    error,
                }
            })?;
        observables.push(observable);
    }
    Ok(observables)
}
