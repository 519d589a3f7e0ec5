//! A panel: two axes and what is shown between them.

use super::axis::{Axis, Extent, Limits, Range};
use super::color::{Color, PALETTE};
use super::figure_error::{AxisSide, FigureError};
use super::layer::Layer;
use super::legend::Legend;
use super::map::Grid;

/// Two axes and the layers between them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Panel {
    pub(super) x: Axis,
    pub(super) y: Axis,
    pub(super) layers: Vec<Layer>,
    pub(super) title: Option<String>,
    pub(super) legend: Legend,
    pub(super) equal: bool,
}

impl Panel {
    /// A panel between a horizontal and a vertical axis.
    pub fn new(x: Axis, y: Axis) -> Self {
        Panel {
            x,
            y,
            ..Panel::default()
        }
    }

    /// With one more layer, over the others.
    pub fn with(mut self, layer: impl Into<Layer>) -> Self {
        self.layers.push(layer.into());
        self
    }

    /// With one more layer, over the others.
    pub fn add(&mut self, layer: impl Into<Layer>) {
        self.layers.push(layer.into());
    }

    /// With a title above.
    pub fn title(mut self, title: impl Into<String>) -> Self {
        self.title = Some(title.into());
        self
    }

    /// With its legend there.
    pub fn legend(mut self, legend: Legend) -> Self {
        self.legend = legend;
        self
    }

    /// With units of equal length along both axes, which are linear.
    pub fn equal(mut self) -> Self {
        self.equal = true;
        self
    }

    /// Whether a map of categories is shown.
    pub(super) fn has_categories(&self) -> bool {
        self.layers
            .iter()
            .any(|l| matches!(l, Layer::CategoryMap(_)))
    }

    /// Whether cells fill the panel, which then needs no room beside them.
    fn has_cells(&self) -> bool {
        self.layers
            .iter()
            .any(|l| matches!(l, Layer::CategoryMap(_) | Layer::HeatMap(_)))
    }

    /// What the axes show, for layers that reach so far.
    pub(super) fn limits(
        &self,
        x_axis: &Axis,
        extents: (Extent, Extent),
    ) -> Result<(Limits, Limits), FigureError> {
        let limits = |axis: &Axis, side, extent| match axis.range {
            Range::Padded if self.has_cells() => axis.clone().tight().limits(side, extent),
            _ => axis.limits(side, extent),
        };
        Ok((
            limits(x_axis, AxisSide::X, extents.0)?,
            limits(&self.y, AxisSide::Y, extents.1)?,
        ))
    }

    /// Checks what can be wrong with layers.
    pub(super) fn check(&self) -> Result<(), FigureError> {
        for layer in &self.layers {
            let lengths = |layer, x: usize, y: usize| match x == y {
                true => Ok(()),
                false => Err(FigureError::UnequalLengths { layer, x, y }),
            };
            match layer {
                Layer::Line(l) => lengths("line", l.x.len(), l.y.len())?,
                Layer::Markers(m) => lengths("markers", m.x.len(), m.y.len())?,
                Layer::HeatMap(m) => m.grid.check("heat map", m.values.len())?,
                Layer::CategoryMap(m) => m.check()?,
                Layer::Density(d) => {
                    for (axis, bins, scale) in [
                        (AxisSide::X, d.x, self.x.scale),
                        (AxisSide::Y, d.y, self.y.scale),
                    ] {
                        if bins.scale != scale {
                            return Err(FigureError::ScaleMismatch { axis });
                        }
                    }
                }
                Layer::Spans(_) | Layer::Rule(_) => {}
            }
        }
        Ok(())
    }

    /// From where to where the layers reach along both axes, in linear coordinates.
    pub(super) fn extents(&self) -> (Extent, Extent) {
        let (mut x, mut y) = (Extent::NOWHERE, Extent::NOWHERE);
        let mut points = |xs: &[f64], ys: &[f64]| {
            for (&a, &b) in xs.iter().zip(ys) {
                let (a, b) = (self.x.scale.forward(a), self.y.scale.forward(b));
                if a.is_finite() && b.is_finite() {
                    x.add(a);
                    y.add(b);
                }
            }
        };
        for layer in &self.layers {
            match layer {
                Layer::Line(l) => points(&l.x, &l.y),
                Layer::Markers(m) => points(&m.x, &m.y),
                _ => {}
            }
        }
        for layer in &self.layers {
            let grid = match layer {
                Layer::Density(d) => {
                    x.join(d.x.extent());
                    y.join(d.y.extent());
                    continue;
                }
                Layer::HeatMap(m) => &m.grid,
                Layer::CategoryMap(m) => &m.grid,
                _ => continue,
            };
            x.join(Grid::extent(&grid.x, self.x.scale));
            y.join(Grid::extent(&grid.y, self.y.scale));
        }
        (x, y)
    }

    /// The colour of each layer: its own, or the next of the palette; a density alone is dark.
    pub(super) fn colors(&self) -> Vec<Color> {
        let takes_turn =
            |l: &&Layer| matches!(l, Layer::Line(_) | Layer::Markers(_) | Layer::Density(_));
        let density_alone = self.layers.iter().filter(takes_turn).count() == 1;
        let mut next = 0;
        let mut turn = || {
            next += 1;
            PALETTE[(next - 1) % PALETTE.len()]
        };
        self.layers
            .iter()
            .map(|layer| match layer {
                Layer::Line(l) => l.color.unwrap_or_else(&mut turn),
                Layer::Markers(m) => m.color.unwrap_or_else(&mut turn),
                Layer::Density(d) if density_alone => d.color.unwrap_or(Color::NIGHT),
                Layer::Density(d) => d.color.unwrap_or_else(&mut turn),
                Layer::Spans(s) => s.color,
                Layer::Rule(r) => r.color,
                Layer::HeatMap(_) | Layer::CategoryMap(_) => Color::INK,
            })
            .collect()
    }
}
