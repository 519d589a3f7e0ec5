//! Points counted in fine cells and shown as shades, so that ten million are no fog and a single one is still seen.

mod bins;
mod shades;

use crate::axis::{Range, Scale};
use crate::color::Color;
use bins::{Bins, overlaps};
use shades::Shades;

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

/// Whether points are seen one by one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Grain {
    /// Where only few points fall into a pixel, the mean of its neighbourhood is shown.
    #[default]
    Smooth,
    /// Each point is a dot as large as a cell. For sweeps of so few values that there is room between them.
    Points,
}

/// Points of which only the number in each cell of a fine grid is kept: memory does not grow with points.
#[derive(Debug, Clone, PartialEq)]
pub struct Density {
    pub(crate) x: Bins,
    pub(crate) y: Bins,
    counts: Vec<u32>,
    left_out: u64,
    pub(crate) color: Option<Color>,
    pub(crate) label: Option<String>,
    normalisation: Normalisation,
    grain: Grain,
}

/// Cells along x and y unless told otherwise: enough for a column-wide picture at 600 pixels per inch.
const CELLS: (usize, usize) = (2048, 1536);

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
            normalisation: Normalisation::default(),
            grain: Grain::default(),
        }
    }

    /// Another number of cells, at least one each way. Forgets points added so far, so call it first.
    ///
    /// For a sweep of at most a thousand parameter values or so, as many columns as values leave no gaps.
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

    /// With counts compared in this way.
    pub fn normalisation(mut self, normalisation: Normalisation) -> Self {
        self.normalisation = normalisation;
        self
    }

    /// With points shown so.
    pub fn grain(mut self, grain: Grain) -> Self {
        self.grain = grain;
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
    pub(crate) fn shades(
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
        // A picture finer than the grid spreads a cell over many pixels.
        let pixels_per_cell = |bins: &Bins, window: (f64, f64), pixels: usize| {
            let cell = (bins.high - bins.low) / bins.count as f64;
            (cell * pixels as f64 / (window.1 - window.0).abs()).max(1.0)
        };
        let spread = pixels_per_cell(&self.x, x, width) * pixels_per_cell(&self.y, y, height);
        let shades = Shades {
            width,
            counts: shades,
            spread,
        };
        shades.opacities(self.normalisation, self.grain)
    }
}

impl Extend<(f64, f64)> for Density {
    fn extend<I: IntoIterator<Item = (f64, f64)>>(&mut self, points: I) {
        for (x, y) in points {
            self.add(x, y);
        }
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

    const UNIT: (f64, f64) = (0.0, 1.0);

    #[test]
    fn a_single_point_is_seen_beside_ten_million() {
        let mut density = Density::new(UNIT, UNIT);
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
            assert!(seen >= shades::FAINTEST, "{seen} at {width} by {height}");
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
}
