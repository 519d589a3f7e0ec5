//! Maps over two parameters: a colour for each cell, from a number or from a category.

use super::axis::{Axis, Extent, Limits, Scale};
use super::color::{Color, Colormap};
use super::figure_error::{AxisSide, FigureError};

/// Numbers over a grid of two parameters, shown as colours with a colour bar.
#[derive(Debug, Clone, PartialEq)]
pub struct HeatMap {
    pub(super) grid: Grid,
    pub(super) values: Vec<f64>,
    pub(super) colormap: Colormap,
    /// What the numbers are, and which of them the colours span.
    pub(super) axis: Axis,
}

/// One of a few named kinds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Category {
    /// Its name in the legend.
    pub name: String,
    /// Its colour.
    pub color: Color,
}

impl Category {
    /// A category.
    pub fn new(name: impl Into<String>, color: Color) -> Self {
        Category {
            name: name.into(),
            color,
        }
    }
}

/// Categories over a grid of two parameters, shown as colours with a legend.
#[derive(Debug, Clone, PartialEq)]
pub struct CategoryMap {
    pub(super) grid: Grid,
    pub(super) cells: Vec<Option<usize>>,
    pub(super) categories: Vec<Category>,
}

/// The places of cells: their middles along both axes, increasing.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Grid {
    pub(super) x: Vec<f64>,
    pub(super) y: Vec<f64>,
}

/// A side of a two-sided scale is at least so large, as a part of both.
const LEAST_SIDE: f64 = 0.01;

impl HeatMap {
    /// Cells with their middles at `x` and `y` (both increasing), their numbers row after row: the cell at `x[i]`,
    /// `y[j]` is `values[j * x.len() + i]`. Numbers that are not finite leave their cell empty.
    pub fn new(x: Vec<f64>, y: Vec<f64>, values: Vec<f64>) -> Self {
        HeatMap {
            grid: Grid { x, y },
            values,
            colormap: Colormap::Sequential,
            axis: Axis::default().tight(),
        }
    }

    /// With these colours.
    pub fn colormap(mut self, colormap: Colormap) -> Self {
        self.colormap = colormap;
        self
    }

    /// With this axis at the colour bar.
    pub fn axis(mut self, axis: Axis) -> Self {
        self.axis = axis;
        self
    }

    /// What the colour bar shows.
    pub(super) fn limits(&self) -> Result<Limits, FigureError> {
        let mut extent = Extent::NOWHERE;
        for &v in &self.values {
            extent.add(self.axis.scale.forward(v));
        }
        let mut limits = self.axis.limits(AxisSide::Color, extent)?;
        limits.centre = self.colormap.centre(limits.low, limits.high);
        if let Some(centre) = limits.centre {
            // What is next to nothing beside the other side is not blown up.
            let least = LEAST_SIDE * (limits.high - limits.low);
            limits.low = limits.low.min(centre - least);
            limits.high = limits.high.max(centre + least);
        }
        Ok(limits)
    }
}

impl CategoryMap {
    /// Cells with their middles at `x` and `y` (both increasing), row after row as for [`HeatMap::new`]; each names its
    /// category by number, or none.
    pub fn new(
        x: Vec<f64>,
        y: Vec<f64>,
        cells: Vec<Option<usize>>,
        categories: Vec<Category>,
    ) -> Self {
        CategoryMap {
            grid: Grid { x, y },
            cells,
            categories,
        }
    }

    pub(super) fn check(&self) -> Result<(), FigureError> {
        self.grid.check("category map", self.cells.len())?;
        match self
            .cells
            .iter()
            .flatten()
            .find(|&&c| c >= self.categories.len())
        {
            Some(&category) => Err(FigureError::NoSuchCategory {
                category,
                known: self.categories.len(),
            }),
            None => Ok(()),
        }
    }
}

impl Grid {
    pub(super) fn check(&self, layer: &'static str, cells: usize) -> Result<(), FigureError> {
        let expected = self.x.len() * self.y.len();
        if expected != cells {
            return Err(FigureError::UnequalLengths {
                layer,
                x: expected,
                y: cells,
            });
        }
        for (axis, middles) in [(AxisSide::X, &self.x), (AxisSide::Y, &self.y)] {
            if let Some(k) = middles
                .windows(2)
                .position(|w| w[0].partial_cmp(&w[1]) != Some(std::cmp::Ordering::Less))
            {
                return Err(FigureError::Unordered { axis, index: k + 1 });
            }
        }
        Ok(())
    }

    /// From edge to edge of the cells, in linear coordinates.
    pub(super) fn extent(middles: &[f64], scale: Scale) -> Extent {
        let edges = edges(middles, scale);
        let mut extent = Extent::NOWHERE;
        edges.iter().for_each(|&e| extent.add(e));
        extent
    }

    /// The cell along one axis at each of `places` (linear coordinates).
    pub(super) fn indices(
        middles: &[f64],
        scale: Scale,
        places: impl Iterator<Item = f64>,
    ) -> Vec<Option<usize>> {
        let edges = edges(middles, scale);
        places
            .map(|u| {
                let above = edges.partition_point(|&e| e <= u);
                let last = edges.last().is_some_and(|&e| e == u);
                (1..edges.len())
                    .contains(&above)
                    .then(|| above - 1)
                    .or(last.then(|| middles.len() - 1))
            })
            .collect()
    }
}

/// Edges of cells half-way between their middles, in linear coordinates.
fn edges(middles: &[f64], scale: Scale) -> Vec<f64> {
    let u: Vec<f64> = middles.iter().map(|&x| scale.forward(x)).collect();
    match u.as_slice() {
        [] => Vec::new(),
        [only] => vec![only - 0.5, only + 0.5],
        [first, second, ..] => {
            let n = u.len();
            let mut edges = vec![first - 0.5 * (second - first)];
            edges.extend(u.windows(2).map(|w| 0.5 * (w[0] + w[1])));
            edges.push(u[n - 1] + 0.5 * (u[n - 1] - u[n - 2]));
            edges
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_reach_half_way_to_their_neighbours() {
        let at = |u: f64| Grid::indices(&[0.0, 1.0, 3.0], Scale::Linear, [u].into_iter())[0];
        assert_eq!(
            [-0.6, -0.5, 0.4, 0.5, 1.9, 2.0, 4.0, 4.1].map(at),
            [
                None,
                Some(0),
                Some(0),
                Some(1),
                Some(1),
                Some(2),
                Some(2),
                None
            ]
        );
    }

    #[test]
    fn wrong_grids_are_refused() {
        let unordered = Grid {
            x: vec![0.0, 2.0, 1.0],
            y: vec![0.0],
        };
        assert_eq!(
            unordered.check("heat map", 3).unwrap_err().to_string(),
            "map: cell 2 along the horizontal axis is not above the one before it"
        );
        assert!(unordered.check("heat map", 4).is_err());
        let map = CategoryMap::new(
            vec![0.0],
            vec![0.0],
            vec![Some(1)],
            vec![Category::new("a", Color::BLUE)],
        );
        assert!(matches!(
            map.check(),
            Err(FigureError::NoSuchCategory {
                category: 1,
                known: 1
            })
        ));
    }
}
