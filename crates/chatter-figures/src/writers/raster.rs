//! Scene to pixels.

use tiny_skia::{
    Color as Paintable, FillRule, FilterQuality, LineCap, LineJoin, Mask, Paint, PathBuilder,
    Pixmap, PixmapPaint, PremultipliedColorU8, StrokeDash, Transform,
};

use super::png::Resolution;
use crate::color::Color;
use crate::figure_error::FigureError;
use crate::scene::{GlyphRun, Image, Path, Primitive, Rect, Scene, Segment, Stroke, Turn};

/// Width, height and pixels (red, green, blue) of the scene on white.
pub(crate) fn pixels(
    scene: &Scene,
    resolution: Resolution,
) -> Result<(usize, usize, Vec<u8>), FigureError> {
    let scale = resolution.pixels_per_point();
    let (width, height) = (
        (scene.width * scale).round(),
        (scene.height * scale).round(),
    );
    let too_large = || FigureError::TooLarge { width, height };
    resolution.check(scene.width, scene.height)?;
    let mut canvas = Canvas {
        pixmap: Pixmap::new(width as u32, height as u32).ok_or_else(too_large)?,
        scale,
        clip: None,
    };
    canvas.pixmap.fill(Paintable::WHITE);
    for item in &scene.items {
        canvas.draw(item);
    }
    // White and opaque at the start, so every pixel still is.
    let rgb = canvas
        .pixmap
        .pixels()
        .iter()
        .flat_map(|p| [p.red(), p.green(), p.blue()])
        .collect();
    Ok((width as usize, height as usize, rgb))
}

struct Canvas {
    pixmap: Pixmap,
    /// Pixels per point.
    scale: f64,
    clip: Option<Mask>,
}

impl Canvas {
    fn draw(&mut self, item: &Primitive) {
        match item {
            Primitive::Path { path, fill, stroke } => {
                let scale = self.scale;
                self.paint(path, Placement::scaled(scale), *fill, stroke.as_ref());
            }
            Primitive::Symbols {
                shape,
                fill,
                stroke,
                places,
            } => {
                for &(x, y) in places {
                    let placement = Placement {
                        x: x * self.scale,
                        y: y * self.scale,
                        ..Placement::scaled(self.scale)
                    };
                    self.paint(shape, placement, *fill, stroke.as_ref());
                }
            }
            Primitive::Image(image) => self.image(image),
            Primitive::Text(run) => self.text(run),
            Primitive::Clip { rect, items } => {
                let before = self.clip.take();
                self.clip = self.mask(rect);
                items.iter().for_each(|item| self.draw(item));
                self.clip = before;
            }
        }
    }

    fn mask(&self, rect: &Rect) -> Option<Mask> {
        let mut mask = Mask::new(self.pixmap.width(), self.pixmap.height())?;
        let path = convert(&rect.path(), Placement::scaled(self.scale))?;
        mask.fill_path(&path, FillRule::Winding, true, Transform::identity());
        Some(mask)
    }

    fn paint(
        &mut self,
        path: &Path,
        placement: Placement,
        fill: Option<Color>,
        stroke: Option<&Stroke>,
    ) {
        let Some(path) = convert(path, placement) else {
            return;
        };
        if let Some(color) = fill {
            self.pixmap.fill_path(
                &path,
                &paint_of(color),
                FillRule::Winding,
                Transform::identity(),
                self.clip.as_ref(),
            );
        }
        if let Some(s) = stroke {
            let solid = s.dash.is_empty();
            let dash = s.dash.iter().map(|&l| (l * self.scale) as f32).collect();
            let stroke = tiny_skia::Stroke {
                width: (s.width * self.scale) as f32,
                line_cap: if solid { LineCap::Round } else { LineCap::Butt },
                line_join: if solid {
                    LineJoin::Round
                } else {
                    LineJoin::Miter
                },
                dash: if solid {
                    None
                } else {
                    StrokeDash::new(dash, 0.0)
                },
                ..tiny_skia::Stroke::default()
            };
            self.pixmap.stroke_path(
                &path,
                &paint_of(s.color),
                &stroke,
                Transform::identity(),
                self.clip.as_ref(),
            );
        }
    }

    fn text(&mut self, run: &GlyphRun) {
        for g in &run.glyphs {
            let (dx, dy) = match run.turn {
                Turn::None => (g.x, g.y),
                Turn::Left => (g.y, -g.x),
            };
            let placement = Placement {
                scale: self.scale * g.size / g.face.units(),
                turn: run.turn,
                x: (run.x + dx) * self.scale,
                y: (run.y + dy) * self.scale,
            };
            self.paint(&g.face.outline(g.id), placement, Some(run.color), None);
        }
    }

    fn image(&mut self, image: &Image) {
        let Some(mut picture) = Pixmap::new(image.width as u32, image.height as u32) else {
            return;
        };
        for (pixel, c) in picture.pixels_mut().iter_mut().zip(&image.pixels) {
            *pixel = premultiplied(*c);
        }
        let r = &image.rect;
        let sx = r.width() * self.scale / image.width as f64;
        let sy = r.height() * self.scale / image.height as f64;
        // Pictures made for this resolution lie on whole pixels and are copied.
        let (x, y) = (r.left * self.scale, r.top * self.scale);
        let exact = (sx - 1.0).abs() < 1e-6 && (sy - 1.0).abs() < 1e-6;
        let (x, y) = if exact {
            (x.round(), y.round())
        } else {
            (x, y)
        };
        let paint = PixmapPaint {
            quality: if exact {
                FilterQuality::Nearest
            } else {
                FilterQuality::Bilinear
            },
            ..PixmapPaint::default()
        };
        let transform = if exact {
            Transform::from_translate(x as f32, y as f32)
        } else {
            Transform::from_row(sx as f32, 0.0, 0.0, sy as f32, x as f32, y as f32)
        };
        self.pixmap.draw_pixmap(
            0,
            0,
            picture.as_ref(),
            &paint,
            transform,
            self.clip.as_ref(),
        );
    }
}

fn premultiplied(c: Color) -> PremultipliedColorU8 {
    let by_opacity = |v: u8| ((u32::from(v) * u32::from(c.a) + 127) / 255) as u8;
    PremultipliedColorU8::from_rgba(by_opacity(c.r), by_opacity(c.g), by_opacity(c.b), c.a)
        .unwrap_or(PremultipliedColorU8::TRANSPARENT)
}

fn paint_of(c: Color) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(c.r, c.g, c.b, c.a);
    paint.anti_alias = true;
    paint
}

/// Scale, quarter turn and shift, into pixels.
#[derive(Clone, Copy)]
struct Placement {
    scale: f64,
    turn: Turn,
    x: f64,
    y: f64,
}

impl Placement {
    fn scaled(scale: f64) -> Self {
        Placement {
            scale,
            turn: Turn::None,
            x: 0.0,
            y: 0.0,
        }
    }

    fn apply(&self, x: f64, y: f64) -> (f32, f32) {
        let (x, y) = match self.turn {
            Turn::None => (x, y),
            Turn::Left => (y, -x),
        };
        (
            (x * self.scale + self.x) as f32,
            (y * self.scale + self.y) as f32,
        )
    }
}

fn convert(path: &Path, placement: Placement) -> Option<tiny_skia::Path> {
    let mut builder = PathBuilder::new();
    for segment in &path.0 {
        match *segment {
            Segment::Move(x, y) => {
                let (x, y) = placement.apply(x, y);
                builder.move_to(x, y);
            }
            Segment::Line(x, y) => {
                let (x, y) = placement.apply(x, y);
                builder.line_to(x, y);
            }
            Segment::Cubic([x1, y1, x2, y2, x, y]) => {
                let (x1, y1) = placement.apply(x1, y1);
                let (x2, y2) = placement.apply(x2, y2);
                let (x, y) = placement.apply(x, y);
                builder.cubic_to(x1, y1, x2, y2, x, y);
            }
            Segment::Close => builder.close(),
        }
    }
    builder.finish()
}
