//! Points counted in fine cells and shown as shades, so that ten million are no fog and a single one is still seen.

use super::axis::{Extent, Range, Scale};
use super::color::Color;

/// How counts become shades. Either way more points never give a fainter shade.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Compression {
    /// Shade grows with the logarithm of the count: ratios of density can be judged.
    #[default]
    Logarithmic,
    /// Shade grows with the rank among all counts: as much contrast as there is, everywhere.
    Rank,
}

/// What counts are compared with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Normalisation {
    /// With those of the whole picture.
    #[default]
    Whole,
    /// With those of the same column of the picture. For orbit diagrams, in which columns hold different numbers of
    /// parameter values.
    Column,
}

/// Points of which only the number in each cell of a fine grid is kept: memory does not grow with points.
#[derive(Debug, Clone, PartialEq)]
pub struct Density {
    pub(super) x: Bins,
    pub(super) y: Bins,
    counts: Vec<u32>,
    left_out: u64,
    pub(super) color: Option<Color>,
    pub(super) label: Option<String>,
    compression: Compression,
    normalisation: Normalisation,
}

/// Cells along one axis, equal in the scale's linear coordinate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bins {
    pub(super) scale: Scale,
    pub(super) low: f64,
    pub(super) high: f64,
    pub(super) count: usize,
}

impl Bins {
    fn new((low, high): (f64, f64), count: usize) -> Self {
        let (low, high) = if low < high {
            (low, high)
        } else {
            (low - 0.5, low + 0.5)
        };
        Bins {
            scale: Scale::Linear,
            low,
            high,
            count,
        }
    }

    fn rescaled(self, scale: Scale) -> Self {
        let (low, high) = (
            self.scale.backward(self.low),
            self.scale.backward(self.high),
        );
        Bins {
            scale,
            low: scale.forward(low),
            high: scale.forward(high),
            ..self
        }
    }

    /// The cell of a number; both ends belong to the range.
    fn index(&self, x: f64) -> Option<usize> {
        let u = self.scale.forward(x);
        if !(u >= self.low && u <= self.high) {
            return None;
        }
        let k = (u - self.low) / (self.high - self.low) * self.count as f64;
        Some((k as usize).min(self.count - 1))
    }

    pub(super) fn extent(&self) -> Extent {
        Extent {
            low: self.low,
            high: self.high,
        }
    }
}

/// Cells along x and y unless told otherwise: enough for a column-wide picture at 600 pixels per inch.
const CELLS: (usize, usize) = (2048, 1536);

/// Opacity of a single point beside places that hold very many: clearly seen on white.
const FAINTEST: f64 = 0.22;

/// Count beside which single points are as faint as that; where fewer fall together, they are stronger.
const DENSE: f64 = 50.0;

/// Part of the inked pixels that may be saturated, lest a few periodic windows fade all else.
const SATURATED: f64 = 0.002;

/// Part of the inked pixels that may be as faint as single points, lest bands of chaos be a fog.
const FAINT: f64 = 0.02;

impl Density {
    /// An empty grid over the given ranges; points outside are counted as left out and not drawn.
    ///
    /// A range that is empty or not a range is widened by half to both sides of its first number.
    pub fn new(x: (f64, f64), y: (f64, f64)) -> Self {
        Density {
            x: Bins::new(x, CELLS.0),
            y: Bins::new(y, CELLS.1),
            counts: vec![0; CELLS.0 * CELLS.1],
            left_out: 0,
            color: None,
            label: None,
            compression: Compression::default(),
            normalisation: Normalisation::default(),
        }
    }

    /// Counts points that can be gone through twice: first to find their range, then to count them.
    pub fn of<I: Iterator<Item = (f64, f64)>>(points: impl Fn() -> I) -> Self {
        let (mut x, mut y) = (Extent::NOWHERE, Extent::NOWHERE);
        for (a, b) in points() {
            if a.is_finite() && b.is_finite() {
                x.add(a);
                y.add(b);
            }
        }
        let range = |e: Extent| {
            if e.low <= e.high {
                (e.low, e.high)
            } else {
                (0.0, 1.0)
            }
        };
        let mut density = Density::new(range(x), range(y));
        density.extend(points());
        density
    }

    /// Another number of cells, at least one each way. Forgets points added so far, so call it first.
    ///
    /// For a sweep of fewer than about a thousand parameter values, as many columns as values leave no gaps.
    pub fn cells(mut self, columns: usize, rows: usize) -> Self {
        self.x.count = columns.max(1);
        self.y.count = rows.max(1);
        self.forget()
    }

    /// Counts on these scales, which the panel's axes must have. Forgets points added so far, so call it first.
    pub fn scales(mut self, x: Scale, y: Scale) -> Self {
        self.x = self.x.rescaled(x);
        self.y = self.y.rescaled(y);
        self.forget()
    }

    fn forget(mut self) -> Self {
        self.counts = vec![0; self.x.count * self.y.count];
        self.left_out = 0;
        self
    }

    /// In this colour.
    pub fn color(mut self, color: Color) -> Self {
        self.color = Some(color);
        self
    }

    /// With an entry in the legend.
    pub fn label(mut self, label: impl Into<String>) -> Self {
        self.label = Some(label.into());
        self
    }

    /// With shades made in this way.
    pub fn compression(mut self, compression: Compression) -> Self {
        self.compression = compression;
        self
    }

    /// With counts compared in this way.
    pub fn normalisation(mut self, normalisation: Normalisation) -> Self {
        self.normalisation = normalisation;
        self
    }

    /// Counts a point.
    #[inline]
    pub fn add(&mut self, x: f64, y: f64) {
        match (self.x.index(x), self.y.index(y)) {
            (Some(column), Some(row)) => {
                let count = &mut self.counts[row * self.x.count + column];
                *count = count.saturating_add(1);
            }
            _ => self.left_out += 1,
        }
    }

    /// Counts the points of another grid over the same cells, such as one filled by another thread.
    ///
    /// Returns whether the cells are the same; if not, nothing is added.
    pub fn merge(&mut self, other: &Density) -> bool {
        if self.x != other.x || self.y != other.y {
            return false;
        }
        for (a, b) in self.counts.iter_mut().zip(&other.counts) {
            *a = a.saturating_add(*b);
        }
        self.left_out += other.left_out;
        true
    }

    /// How many points were not finite or outside the ranges.
    pub fn left_out(&self) -> u64 {
        self.left_out
    }

    /// How many points were counted.
    pub fn counted(&self) -> u64 {
        self.counts.iter().map(|&n| u64::from(n)).sum()
    }

    /// Opacities, 0 … 1, of the pixels of a picture over the window `x` by `y` (linear coordinates of left and right,
    /// top and bottom edge), row after row from the top.
    pub(super) fn shades(
        &self,
        x: (f64, f64),
        y: (f64, f64),
        width: usize,
        height: usize,
    ) -> Vec<f64> {
        let columns = overlaps(&self.x, x, width);
        let rows = overlaps(&self.y, y, height);
        // Rows of the picture on columns of the grid first, then columns of the picture.
        let mut shades = vec![0.0; width * height];
        let mut line = vec![0.0; self.x.count];
        for (row, overlap) in rows.iter().enumerate() {
            line.fill(0.0);
            for (k, weight) in overlap.weights() {
                let counts = &self.counts[k * self.x.count..(k + 1) * self.x.count];
                for (sum, &n) in line.iter_mut().zip(counts) {
                    *sum += weight * f64::from(n);
                }
            }
            for (pixel, overlap) in shades[row * width..(row + 1) * width]
                .iter_mut()
                .zip(&columns)
            {
                *pixel = overlap.weights().map(|(k, weight)| weight * line[k]).sum();
            }
        }
        // A picture finer than the grid spreads a cell over many pixels: count per cell then, not per pixel.
        let cells_per_pixel = |bins: &Bins, window: (f64, f64), pixels: usize| {
            let cell = (bins.high - bins.low) / bins.count as f64;
            ((window.1 - window.0).abs() / pixels as f64 / cell).min(1.0)
        };
        let area = cells_per_pixel(&self.x, x, width) * cells_per_pixel(&self.y, y, height);
        for shade in &mut shades {
            *shade /= area;
        }
        if self.normalisation == Normalisation::Column {
            normalise_columns(&mut shades, width);
        }
        compress(&mut shades, self.compression);
        shades
    }
}

impl Extend<(f64, f64)> for Density {
    fn extend<I: IntoIterator<Item = (f64, f64)>>(&mut self, points: I) {
        for (x, y) in points {
            self.add(x, y);
        }
    }
}

/// Which cells a pixel covers, and how much of the first and last.
struct Overlap {
    first: usize,
    count: usize,
    head: f64,
    tail: f64,
}

impl Overlap {
    /// Cell and the part of it that is covered.
    fn weights(&self) -> impl Iterator<Item = (usize, f64)> {
        (0..self.count).map(|k| {
            let weight = match (k, self.count) {
                (0, _) => self.head,
                (k, n) if k + 1 == n => self.tail,
                _ => 1.0,
            };
            (self.first + k, weight)
        })
    }
}

fn overlaps(bins: &Bins, window: (f64, f64), pixels: usize) -> Vec<Overlap> {
    let scale = bins.count as f64 / (bins.high - bins.low);
    let edge = |k: usize| {
        let u = window.0 + (window.1 - window.0) * (k as f64 / pixels as f64);
        ((u - bins.low) * scale).clamp(0.0, bins.count as f64)
    };
    (0..pixels)
        .map(|k| {
            let (a, b) = (edge(k), edge(k + 1));
            let (a, b) = (a.min(b), a.max(b));
            if a == b {
                return Overlap {
                    first: 0,
                    count: 0,
                    head: 0.0,
                    tail: 0.0,
                };
            }
            let first = a.floor() as usize;
            let count = b.ceil() as usize - first;
            Overlap {
                first,
                count,
                head: b.min(first as f64 + 1.0) - a,
                tail: b - (b.ceil() - 1.0),
            }
        })
        .collect()
}

/// Scales each column so that all that hold points hold equally many.
fn normalise_columns(counts: &mut [f64], width: usize) {
    let mut sums = vec![0.0; width];
    for row in counts.chunks_exact(width) {
        for (sum, n) in sums.iter_mut().zip(row) {
            *sum += n;
        }
    }
    let filled = sums.iter().filter(|&&s| s > 0.0).count();
    let mean = sums.iter().sum::<f64>() / filled.max(1) as f64;
    for row in counts.chunks_exact_mut(width) {
        for (n, &sum) in row.iter_mut().zip(&sums) {
            if sum > 0.0 {
                *n *= mean / sum;
            }
        }
    }
}

/// Counts to opacities.
fn compress(counts: &mut [f64], compression: Compression) {
    let mut sorted: Vec<f64> = counts.iter().copied().filter(|&n| n > 0.0).collect();
    if sorted.is_empty() {
        return;
    }
    sorted.sort_unstable_by(f64::total_cmp);
    let quantile = |part: f64| sorted[((sorted.len() - 1) as f64 * part) as usize];
    let (weak, strong) = (quantile(FAINT).max(1.0), quantile(1.0 - SATURATED));
    let strength = |n: f64| match compression {
        Compression::Logarithmic if strong > weak => {
            let t = (libm::log(n / weak) / libm::log(strong / weak)).clamp(0.0, 1.0);
            // Steeper at the dark end: caustics stand out from the band between them.
            t * t.sqrt()
        }
        Compression::Logarithmic => f64::from(u8::from(n >= weak)),
        Compression::Rank => sorted.partition_point(|&m| m <= n) as f64 / sorted.len() as f64,
    };
    let density = libm::log(strong.max(1.0)) / libm::log(DENSE);
    let faintest = libm::pow(FAINTEST, density.min(1.0));
    for n in counts.iter_mut().filter(|n| **n > 0.0) {
        // A point on the corner of four pixels leaves a quarter in each; less is the rim of a neighbour.
        let whole = (4.0 * *n).min(1.0);
        *n = whole * (faintest + (1.0 - faintest) * strength(*n));
    }
}

/// A density's range, for callers that want the panel's axes to agree with it.
impl Density {
    /// The ranges over which points are counted, as given ranges of axes.
    pub fn ranges(&self) -> (Range, Range) {
        let range = |b: &Bins| Range::Given(b.scale.backward(b.low), b.scale.backward(b.high));
        (range(&self.x), range(&self.y))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const UNIT: (f64, f64) = (0.0, 1.0);

    #[test]
    fn a_single_point_is_seen_beside_ten_million() {
        for compression in [Compression::Logarithmic, Compression::Rank] {
            let mut density = Density::new(UNIT, UNIT).compression(compression);
            for k in 0..10_000_000u32 {
                density.add(0.5, 0.5 + f64::from(k % 1000) * 1e-4);
            }
            density.add(0.1, 0.1);
            for (width, height) in [(700, 500), (2048, 1536), (5000, 3000), (333, 97)] {
                let shades = density.shades(UNIT, (1.0, 0.0), width, height);
                let (column, row) = (
                    (0.1 * width as f64) as usize,
                    (0.9 * height as f64) as usize,
                );
                let mut seen: f64 = 0.0;
                for y in row.saturating_sub(2)..row + 3 {
                    for x in column.saturating_sub(2)..column + 3 {
                        seen = seen.max(shades[y * width + x]);
                    }
                }
                assert!(seen >= FAINTEST, "{seen} at {width} by {height}");
            }
        }
    }

    #[test]
    fn points_are_neither_lost_nor_made() {
        let mut density = Density::new((1.0, 10.0), UNIT)
            .cells(3, 7)
            .scales(Scale::Logarithmic, Scale::Linear);
        density.extend([
            (1.0, 0.0),
            (10.0, 1.0),
            (5.0, 0.5),
            (0.0, 0.5),
            (f64::NAN, 0.5),
            (5.0, 1.1),
        ]);
        assert_eq!((density.counted(), density.left_out()), (3, 3));
        let mut other = density.clone();
        assert!(other.merge(&density));
        assert_eq!(other.counted(), 6);
        assert!(!other.merge(&Density::new(UNIT, UNIT)));
    }

    #[test]
    fn columns_of_unequal_numbers_look_alike_when_normalised() {
        let mut density = Density::new(UNIT, UNIT)
            .cells(2, 10)
            .normalisation(Normalisation::Column);
        for k in 0..1000 {
            let y = f64::from(k) / 1000.0;
            density.add(0.2, y);
            (0..2).for_each(|_| density.add(0.7, y));
        }
        let shades = density.shades(UNIT, (1.0, 0.0), 2, 10);
        assert!(
            shades
                .chunks_exact(2)
                .all(|row| (row[0] - row[1]).abs() < 1e-12)
        );
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn more_points_never_give_a_fainter_shade(counts in proptest::collection::vec(0.0..1e6f64, 1..200)) {
            for compression in [Compression::Logarithmic, Compression::Rank] {
                let mut shades = counts.clone();
                compress(&mut shades, compression);
                let mut order: Vec<usize> = (0..counts.len()).collect();
                order.sort_by(|&a, &b| counts[a].total_cmp(&counts[b]));
                for w in order.windows(2) {
                    prop_assert!(shades[w[0]] <= shades[w[1]] + 1e-12);
                }
                prop_assert!(shades.iter().all(|s| (0.0..=1.0).contains(s)));
            }
        }

        #[test]
        fn resampling_keeps_the_sum(
            cells in 1usize..30,
            pixels in 1usize..60,
            counts in proptest::collection::vec(0u32..100, 30),
        ) {
            let bins = Bins { scale: Scale::Linear, low: 0.0, high: 1.0, count: cells };
            for window in [(0.0, 1.0), (1.0, 0.0), (-0.5, 2.0)] {
                let total: f64 = overlaps(&bins, window, pixels)
                    .iter()
                    .map(|o| o.weights().map(|(k, w)| w * f64::from(counts[k])).sum::<f64>())
                    .sum();
                let expected: u32 = counts[..cells].iter().sum();
                prop_assert!((total - f64::from(expected)).abs() < 1e-9 * f64::from(expected + 1));
            }
        }
    }
}
