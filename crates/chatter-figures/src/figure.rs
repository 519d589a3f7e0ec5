//! A figure: panels in a grid, its size, and its way into a file.

use std::path::Path;

use super::axis::{Extent, Range};
use super::figure_error::FigureError;
use super::layer::Layer;
use super::legend::{self, Legend};
use super::map::HeatMap;
use super::page::draw;
use super::page::layout::{self, Page, Plan};
use super::panel::Panel;
use super::scene::Scene;
use super::writers::png::Resolution;
use super::writers::{pdf, png, svg};
use crate::error::Error;
use chatter_files::Format;
use chatter_files::atomic_file::write_atomically;

/// Points in a millimetre.
const MILLIMETRE: f64 = 72.0 / 25.4;
/// Width of a journal's column.
const COLUMN_WIDTH: f64 = 86.0;
/// Most that a figure may measure.
const LARGEST: f64 = 5000.0;

/// Whether panels have letters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Letters {
    /// (a), (b), … if there are several panels.
    #[default]
    IfSeveral,
    /// None.
    Never,
}

/// What panels above each other have in common.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Sharing {
    /// Nothing.
    #[default]
    Nothing,
    /// The range of the horizontal axis, whose numbers and label stand below the lowest panel only.
    Horizontal,
}

/// Panels in a grid.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    panels: Vec<Panel>,
    columns: usize,
    width: f64,
    height: Option<f64>,
    heights: Vec<f64>,
    letters: Letters,
    sharing: Sharing,
    title: String,
    caption: String,
}

impl Default for Figure {
    fn default() -> Self {
        Figure {
            panels: Vec::new(),
            columns: 1,
            width: COLUMN_WIDTH,
            height: None,
            heights: Vec::new(),
            letters: Letters::default(),
            sharing: Sharing::default(),
            title: String::new(),
            caption: String::new(),
        }
    }
}

impl From<Panel> for Figure {
    fn from(panel: Panel) -> Self {
        Figure::new().panel(panel)
    }
}

/// So often panels with equal units are laid out again.
const EQUAL_PASSES: usize = 4;

impl Figure {
    /// A figure without panels, 86 mm wide, as high as its panels make it.
    pub fn new() -> Self {
        Figure::default()
    }

    /// With one more panel; panels fill the grid row by row.
    pub fn panel(mut self, panel: Panel) -> Self {
        self.panels.push(panel);
        self
    }

    /// With so many panels side by side, at least one.
    pub fn columns(mut self, columns: usize) -> Self {
        self.columns = columns.max(1);
        self
    }

    /// So many millimetres wide.
    pub fn width(mut self, millimetres: f64) -> Self {
        self.width = millimetres;
        self
    }

    /// So many millimetres high.
    pub fn height(mut self, millimetres: f64) -> Self {
        self.height = Some(millimetres);
        self
    }

    /// With rows of panels in these proportions; rows beyond them count as 1.
    pub fn row_heights(mut self, heights: &[f64]) -> Self {
        self.heights = heights.to_vec();
        self
    }

    /// With letters at panels or not.
    pub fn letters(mut self, letters: Letters) -> Self {
        self.letters = letters;
        self
    }

    /// With this in common between panels above each other.
    pub fn sharing(mut self, sharing: Sharing) -> Self {
        self.sharing = sharing;
        self
    }

    /// With a title in the file's metadata; it is not drawn.
    pub fn title(mut self, title: impl Into<String>) -> Self {
        self.title = title.into();
        self
    }

    /// With a caption in the file's metadata, such as how the figure was made; it is not drawn.
    pub fn caption(mut self, caption: impl Into<String>) -> Self {
        self.caption = caption.into();
        self
    }

    /// Writes the figure in the format that the extension of `path` names; PNG with 300 pixels per inch.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        self.write_at(path, Resolution::default())
    }

    /// Writes the figure in the format that the extension of `path` names; PNG in the given resolution.
    pub fn write_at(&self, path: impl AsRef<Path>, resolution: Resolution) -> Result<(), Error> {
        let path = path.as_ref();
        let bytes = match Format::of_figure(path)? {
            Format::Pdf => self.pdf()?,
            Format::Png => self.png(resolution)?,
            _ => self.svg()?.into_bytes(),
        };
        Ok(write_atomically(path, &bytes)?)
    }

    /// The figure as SVG.
    pub fn svg(&self) -> Result<String, FigureError> {
        Ok(svg::document(&self.scene(Resolution::EMBEDDED)?))
    }

    /// The figure as SVG to stand inside a page of HTML, with pictures in the given resolution. Nothing else in the page
    /// may have a name that begins with `name`.
    pub fn inline_svg(&self, pictures: Resolution, name: &str) -> Result<String, FigureError> {
        Ok(svg::element(&self.scene(pictures)?, "", name))
    }

    /// Whether there is more in it than can be seen at once: densities of points.
    pub(crate) fn has_density(&self) -> bool {
        let layers = self.panels.iter().flat_map(|panel| &panel.layers);
        layers
            .into_iter()
            .any(|layer| matches!(layer, Layer::Density(_)))
    }

    /// The figure as PDF.
    pub fn pdf(&self) -> Result<Vec<u8>, FigureError> {
        Ok(pdf::document(&self.scene(Resolution::EMBEDDED)?))
    }

    /// The figure as PNG.
    pub fn png(&self, resolution: Resolution) -> Result<Vec<u8>, FigureError> {
        png::document(&self.scene(resolution)?, resolution)
    }

    /// The figure as drawing primitives, with pictures inside panels in the given resolution.
    pub fn scene(&self, resolution: Resolution) -> Result<Scene, FigureError> {
        let page = self.page()?;
        resolution.check(page.width, page.height)?;
        let mut plans = self.plans()?;
        let mut frames = layout::arrange(&page, &plans)?;
        // Margins depend on the numbers at the axes, and these on the limits.
        for _ in 0..EQUAL_PASSES {
            let equal = plans.iter_mut().zip(&frames);
            let widened = equal.fold(false, |any, (plan, frame)| plan.widen(frame) | any);
            if !widened {
                break;
            }
            frames = layout::arrange(&page, &plans)?;
        }
        let mut moved = false;
        for (plan, frame) in plans.iter_mut().zip(&frames) {
            if plan.legend == Legend::Auto && !plan.entries.is_empty() {
                plan.legend = draw::occupancy(plan, frame)?.place(&plan.entries);
                moved |= plan.legend == Legend::Above;
            }
        }
        if moved {
            frames = layout::arrange(&page, &plans)?;
        }
        let mut items = Vec::new();
        for (plan, frame) in plans.iter().zip(&frames) {
            draw::panel(plan, frame, resolution.pixels_per_point(), &mut items)?;
        }
        Ok(Scene {
            width: page.width,
            height: page.height,
            items,
            title: self.title.clone(),
            caption: self.caption.clone(),
        })
    }

    fn page(&self) -> Result<Page<'_>, FigureError> {
        if self.panels.is_empty() {
            return Err(FigureError::Empty);
        }
        let rows = self.panels.len().div_ceil(self.columns) as f64;
        let height = self.height.unwrap_or_else(|| {
            let column = self.width / self.columns as f64;
            match (self.sharing, self.panels.len()) {
                (Sharing::Horizontal, 2..) => 8.0 + rows * 0.36 * column,
                (_, 1) => 0.68 * self.width,
                _ => rows * 0.72 * column,
            }
        });
        let usable = |v: f64| v > 0.0 && v <= LARGEST;
        let positive = self.heights.iter().all(|&h| h > 0.0 && h.is_finite());
        if !(usable(self.width) && usable(height) && positive) {
            return Err(FigureError::TooSmall {
                width: self.width,
                height,
            });
        }
        Ok(Page {
            width: self.width * MILLIMETRE,
            height: height * MILLIMETRE,
            columns: self.columns,
            heights: &self.heights,
            millimetres: (self.width, height),
        })
    }

    fn plans(&self) -> Result<Vec<Plan<'_>>, FigureError> {
        self.panels.iter().try_for_each(Panel::check)?;
        let mut extents: Vec<(Extent, Extent)> = self.panels.iter().map(Panel::extents).collect();
        let shared = self.sharing == Sharing::Horizontal;
        if shared {
            for column in 0..self.columns {
                let mut all = Extent::NOWHERE;
                extents
                    .iter()
                    .skip(column)
                    .step_by(self.columns)
                    .for_each(|e| all.join(e.0));
                extents
                    .iter_mut()
                    .skip(column)
                    .step_by(self.columns)
                    .for_each(|e| e.0 = all);
            }
        }
        let lettered = self.letters == Letters::IfSeveral && self.panels.len() > 1;
        let plan = |k: usize| {
            let panel = &self.panels[k];
            let below = k + self.columns < self.panels.len();
            let x_axis = match (&panel.x.range, shared) {
                // A range given for one panel holds for those that share the axis.
                (Range::Given(..), _) | (_, false) => &panel.x,
                _ => {
                    let same_column = self
                        .panels
                        .iter()
                        .skip(k % self.columns)
                        .step_by(self.columns);
                    same_column
                        .map(|p| &p.x)
                        .find(|x| matches!(x.range, Range::Given(..)))
                        .unwrap_or(&panel.x)
                }
            };
            let heat = panel.layers.iter().find_map(|l| match l {
                Layer::HeatMap(m) => Some(m),
                _ => None,
            });
            let bar = heat.map(HeatMap::limits).transpose()?;
            let colors = panel.colors();
            let entries = legend::entries(panel, &colors)?;
            let (x, y) = panel.limits(x_axis, extents[k])?;
            Ok(Plan {
                panel,
                x,
                y,
                bar,
                bar_label: heat.map(|m| m.axis.full_label()).unwrap_or_default(),
                colors,
                entries,
                legend: match panel.legend {
                    Legend::Auto if panel.has_categories() => Legend::Right,
                    chosen => chosen,
                },
                letter: lettered.then(|| letter(k)),
                x_numbers: !(shared && below),
            })
        };
        (0..self.panels.len()).map(plan).collect()
    }
}

/// (a) to (z), then (aa), (ab), …
fn letter(k: usize) -> String {
    let mut name = String::new();
    let mut k = k + 1;
    while k > 0 {
        k -= 1;
        name.insert(0, char::from(b'a' + (k % 26) as u8));
        k /= 26;
    }
    format!("({name})")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_go_on_after_z() {
        assert_eq!(
            [0, 25, 26, 27, 52, 701, 702].map(letter),
            ["(a)", "(z)", "(aa)", "(ab)", "(ba)", "(zz)", "(aaa)"]
        );
    }
}
