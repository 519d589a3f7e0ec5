//! Scene to PNG, and pictures to PNG for embedding.

use std::collections::HashMap;

use super::raster;
use crate::color::Color;
use crate::figure_error::FigureError;
use crate::scene::{Image, Scene};

/// Pixels per inch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resolution(pub f64);

impl Resolution {
    /// What journals ask for.
    pub const PRINT: Resolution = Resolution(300.0);
    /// Of pictures inside SVG and PDF.
    pub const EMBEDDED: Resolution = Resolution(600.0);

    pub(crate) fn pixels_per_point(self) -> f64 {
        self.0 / 72.0
    }

    /// Checks that a page of this size in points has a number of pixels that can be drawn.
    pub(crate) fn check(self, width: f64, height: f64) -> Result<(), FigureError> {
        const MOST: f64 = 2e8;
        let (width, height) = (
            (width * self.pixels_per_point()).round(),
            (height * self.pixels_per_point()).round(),
        );
        if width >= 1.0 && height >= 1.0 && width * height <= MOST {
            Ok(())
        } else {
            Err(FigureError::TooLarge { width, height })
        }
    }
}

impl Default for Resolution {
    fn default() -> Self {
        Resolution::PRINT
    }
}

/// Compression level of miniz: its slower ones gain little on drawings.
pub(crate) const LEVEL: u8 = 7;

/// Bytes per pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Channels {
    /// A place in a palette.
    Indexed = 1,
    Rgb = 3,
    Rgba = 4,
}

/// The scene as a PNG file.
pub(crate) fn document(scene: &Scene, resolution: Resolution) -> Result<Vec<u8>, FigureError> {
    let (width, height, rgb) = raster::pixels(scene, resolution)?;
    let mut file = start(width, height, Channels::Rgb);
    let per_metre = (resolution.0 / 0.0254).round() as u32;
    let mut physical = [per_metre.to_be_bytes(), per_metre.to_be_bytes()].concat();
    physical.push(1);
    chunk(&mut file, b"pHYs", &physical);
    for (key, text) in [("Title", &scene.title), ("Description", &scene.caption)] {
        if !text.is_empty() {
            // Keyword, no compression, no language, no translated keyword, text.
            let body = [key.as_bytes(), &[0; 5], text.as_bytes()].concat();
            chunk(&mut file, b"iTXt", &body);
        }
    }
    finish(&mut file, &rgb, width, Channels::Rgb);
    Ok(file)
}

/// A picture as a PNG file with opacity; with a palette, if that has room for its colours.
pub(crate) fn encode_image(image: &Image) -> Vec<u8> {
    if let Some((palette, places)) = indexed(image) {
        let mut file = start(image.width, image.height, Channels::Indexed);
        let colors: Vec<u8> = palette.iter().flat_map(|c| [c.r, c.g, c.b]).collect();
        let opacities: Vec<u8> = palette.iter().map(|c| c.a).collect();
        chunk(&mut file, b"PLTE", &colors);
        chunk(&mut file, b"tRNS", &opacities);
        finish(&mut file, &places, image.width, Channels::Indexed);
        return file;
    }
    let bytes: Vec<u8> = image
        .pixels
        .iter()
        .flat_map(|c| [c.r, c.g, c.b, c.a])
        .collect();
    let mut file = start(image.width, image.height, Channels::Rgba);
    finish(&mut file, &bytes, image.width, Channels::Rgba);
    file
}

/// The colours of a picture, in order of first mention, and the place of each pixel's among them; none if there are more
/// than a byte can count.
fn indexed(image: &Image) -> Option<(Vec<Color>, Vec<u8>)> {
    let mut palette = Vec::new();
    let mut known = HashMap::new();
    let mut places = Vec::with_capacity(image.pixels.len());
    let mut last = None;
    for &color in &image.pixels {
        let place = match last {
            Some((same, place)) if same == color => place,
            _ => *known.entry(color).or_insert_with(|| {
                palette.push(color);
                palette.len() - 1
            }),
        };
        last = Some((color, place));
        places.push(u8::try_from(place).ok()?);
    }
    (!palette.is_empty()).then_some((palette, places))
}

fn start(width: usize, height: usize, channels: Channels) -> Vec<u8> {
    let mut file = b"\x89PNG\r\n\x1a\n".to_vec();
    let mut header = [(width as u32).to_be_bytes(), (height as u32).to_be_bytes()].concat();
    let kind = match channels {
        Channels::Indexed => 3,
        Channels::Rgb => 2,
        Channels::Rgba => 6,
    };
    header.extend([8, kind, 0, 0, 0]);
    chunk(&mut file, b"IHDR", &header);
    file
}

fn finish(file: &mut Vec<u8>, bytes: &[u8], width: usize, channels: Channels) {
    let data = miniz_oxide::deflate::compress_to_vec_zlib(&filtered(bytes, width, channels), LEVEL);
    chunk(file, b"IDAT", &data);
    chunk(file, b"IEND", &[]);
}

fn chunk(file: &mut Vec<u8>, kind: &[u8; 4], body: &[u8]) {
    file.extend((body.len() as u32).to_be_bytes());
    let start = file.len();
    file.extend(kind);
    file.extend(body);
    let sum = crc32fast::hash(&file[start..]);
    file.extend(sum.to_be_bytes());
}

/// Each row as it is, or as the difference to the row above, whichever is smaller: drawings are mostly white rows that
/// repeat.
fn filtered(bytes: &[u8], width: usize, channels: Channels) -> Vec<u8> {
    let length = width * channels as usize;
    let mut out = Vec::with_capacity(bytes.len() + bytes.len() / length.max(1));
    let mut above = vec![0u8; length];
    let weight = |b: u8| u64::from(b.min(b.wrapping_neg()));
    for row in bytes.chunks_exact(length) {
        let difference: Vec<u8> = row
            .iter()
            .zip(&above)
            .map(|(a, b)| a.wrapping_sub(*b))
            .collect();
        let sum = |row: &[u8]| row.iter().map(|&b| weight(b)).sum::<u64>();
        if sum(&difference) < sum(row) {
            out.push(2);
            out.extend(&difference);
        } else {
            out.push(0);
            out.extend(row);
        }
        above.copy_from_slice(row);
    }
    out
}
