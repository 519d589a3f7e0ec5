//! Scene to SVG: text as outlines, so that it looks the same wherever it is shown; its words are kept for readers of
//! screens.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use super::color::Color;
use super::png;
use super::scene::{GlyphRun, Image, Path, Primitive, Scene, Segment, Stroke, Turn};

/// The whole document.
pub(super) fn document(scene: &Scene) -> String {
    let prolog = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
    prolog.to_owned() + &element(scene, " xmlns=\"http://www.w3.org/2000/svg\"")
}

/// The element alone, with this text among its attributes. Inside HTML it needs no name space.
pub(super) fn element(scene: &Scene, attributes: &str) -> String {
    let mut body = String::new();
    let mut definitions = Definitions::default();
    for item in &scene.items {
        draw(item, &mut body, &mut definitions);
    }
    let (w, h) = (number(scene.width), number(scene.height));
    let mm = |points: f64| number(points * 25.4 / 72.0);
    let mut out = String::with_capacity(body.len() + 4096);
    let _ = writeln!(
        out,
        "<svg{attributes} width=\"{}mm\" height=\"{}mm\" viewBox=\"0 0 {w} {h}\">",
        mm(scene.width),
        mm(scene.height)
    );
    if !scene.title.is_empty() {
        let _ = writeln!(out, "<title>{}</title>", escaped(&scene.title));
    }
    if !scene.caption.is_empty() {
        let _ = writeln!(out, "<desc>{}</desc>", escaped(&scene.caption));
    }
    definitions.write(&mut out);
    let _ = writeln!(out, "<path d=\"M0 0H{w}V{h}H0Z\" fill=\"#fff\"/>");
    out.push_str(&body);
    out.push_str("</svg>\n");
    out
}

/// Things drawn several times or referred to, under names made from their content: equal names mean equal things, even
/// when several figures stand in one page.
#[derive(Default)]
struct Definitions {
    glyphs: BTreeSet<(super::fonts::Face, u16)>,
    shapes: BTreeMap<String, String>,
    clips: BTreeMap<String, String>,
}

impl Definitions {
    fn write(&self, out: &mut String) {
        if self.glyphs.is_empty() && self.shapes.is_empty() && self.clips.is_empty() {
            return;
        }
        out.push_str("<defs>\n");
        for &(face, id) in &self.glyphs {
            let path = path_data(&face.outline(id));
            let _ = writeln!(out, "<path id=\"{}\" d=\"{path}\"/>", glyph_name(face, id));
        }
        for (name, path) in &self.shapes {
            let _ = writeln!(out, "<path id=\"{name}\" d=\"{path}\"/>");
        }
        for (name, path) in &self.clips {
            let _ = writeln!(
                out,
                "<clipPath id=\"{name}\"><path d=\"{path}\"/></clipPath>"
            );
        }
        out.push_str("</defs>\n");
    }
}

fn glyph_name(face: super::fonts::Face, id: u16) -> String {
    let letter = match face {
        super::fonts::Face::Regular => 'r',
        super::fonts::Face::Italic => 'i',
    };
    format!("chatter-{letter}{id}")
}

fn content_name(kind: char, content: &str) -> String {
    format!("chatter-{kind}{:08x}", crc32fast::hash(content.as_bytes()))
}

fn draw(item: &Primitive, out: &mut String, definitions: &mut Definitions) {
    match item {
        Primitive::Path { path, fill, stroke } => {
            if path.0.is_empty() {
                return;
            }
            let _ = write!(out, "<path d=\"{}\"", path_data(path));
            paint(fill, stroke, out);
            out.push_str("/>\n");
        }
        Primitive::Symbols {
            shape,
            fill,
            stroke,
            places,
        } => {
            if places.is_empty() {
                return;
            }
            let data = path_data(shape);
            let name = content_name('s', &data);
            out.push_str("<g");
            paint(fill, stroke, out);
            out.push_str(">\n");
            for &(x, y) in places {
                let _ = writeln!(
                    out,
                    "<use href=\"#{name}\" x=\"{}\" y=\"{}\"/>",
                    number(x),
                    number(y)
                );
            }
            out.push_str("</g>\n");
            definitions.shapes.insert(name, data);
        }
        Primitive::Image(image) => draw_image(image, out),
        Primitive::Text(run) => draw_text(run, out, definitions),
        Primitive::Clip { rect, items } => {
            let data = path_data(&rect.path());
            let name = content_name('c', &data);
            let _ = writeln!(out, "<g clip-path=\"url(#{name})\">");
            items.iter().for_each(|item| draw(item, out, definitions));
            out.push_str("</g>\n");
            definitions.clips.insert(name, data);
        }
    }
}

fn draw_image(image: &Image, out: &mut String) {
    let r = &image.rect;
    let _ = writeln!(
        out,
        "<image x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" preserveAspectRatio=\"none\" \
         href=\"data:image/png;base64,{}\"/>",
        number(r.left),
        number(r.top),
        number(r.width()),
        number(r.height()),
        base64(&png::encode_image(image))
    );
}

fn draw_text(run: &GlyphRun, out: &mut String, definitions: &mut Definitions) {
    let _ = write!(
        out,
        "<g role=\"img\" aria-label=\"{}\"",
        escaped(&run.source)
    );
    paint(&Some(run.color), &None, out);
    let turn = match run.turn {
        Turn::None => "",
        Turn::Left => " rotate(-90)",
    };
    let _ = writeln!(
        out,
        " transform=\"translate({} {}){turn}\">",
        number(run.x),
        number(run.y)
    );
    for g in &run.glyphs {
        if g.face.ink(g.id).is_none() {
            continue;
        }
        let scale = g.size / g.face.units();
        let _ = writeln!(
            out,
            "<use href=\"#{}\" transform=\"translate({} {}) scale({scale:.6})\"/>",
            glyph_name(g.face, g.id),
            number(g.x),
            number(g.y)
        );
        definitions.glyphs.insert((g.face, g.id));
    }
    out.push_str("</g>\n");
}

fn paint(fill: &Option<Color>, stroke: &Option<Stroke>, out: &mut String) {
    match fill {
        Some(color) => {
            let _ = write!(out, " fill=\"{}\"", hex(*color));
            if color.a < 255 {
                let _ = write!(out, " fill-opacity=\"{:.3}\"", f64::from(color.a) / 255.0);
            }
        }
        None => out.push_str(" fill=\"none\""),
    }
    if let Some(s) = stroke {
        let _ = write!(
            out,
            " stroke=\"{}\" stroke-width=\"{}\"",
            hex(s.color),
            number(s.width)
        );
        if s.color.a < 255 {
            let _ = write!(
                out,
                " stroke-opacity=\"{:.3}\"",
                f64::from(s.color.a) / 255.0
            );
        }
        if s.dash.is_empty() {
            out.push_str(" stroke-linejoin=\"round\" stroke-linecap=\"round\"");
        } else {
            let lengths: Vec<String> = s.dash.iter().map(|&l| number(l)).collect();
            let _ = write!(out, " stroke-dasharray=\"{}\"", lengths.join(" "));
        }
    }
}

fn hex(c: Color) -> String {
    format!("#{:02x}{:02x}{:02x}", c.r, c.g, c.b)
}

/// A length to a hundredth of a point, without needless figures.
fn number(x: f64) -> String {
    let text = format!("{x:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" {
        "0".to_string()
    } else {
        text.to_string()
    }
}

fn path_data(path: &Path) -> String {
    let mut out = String::with_capacity(12 * path.0.len());
    let mut push = |command: char, numbers: &[f64]| {
        out.push(command);
        for (k, &x) in numbers.iter().enumerate() {
            let text = number(x);
            if k > 0 && !text.starts_with('-') {
                out.push(' ');
            }
            out.push_str(&text);
        }
    };
    for segment in &path.0 {
        match *segment {
            Segment::Move(x, y) => push('M', &[x, y]),
            Segment::Line(x, y) => push('L', &[x, y]),
            Segment::Cubic(c) => push('C', &c),
            Segment::Close => push('Z', &[]),
        }
    }
    out
}

/// Text with XML's own characters replaced, and those that XML cannot hold left out.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\t' | '\n' | '\r' => out.push(c),
            '\u{fffe}' | '\u{ffff}' => {}
            c if c < ' ' => {}
            c => out.push(c),
        }
    }
    out
}

/// Base 64 (RFC 4648).
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for group in bytes.chunks(3) {
        let byte = |k: usize| u32::from(group.get(k).copied().unwrap_or(0));
        let bits = (byte(0) << 16) | (byte(1) << 8) | byte(2);
        for k in 0..4 {
            if k <= group.len() {
                out.push(char::from(DIGITS[((bits >> (18 - 6 * k)) & 63) as usize]));
            } else {
                out.push('=');
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base_64_of_the_standard() {
        for (plain, coded) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foobar", "Zm9vYmFy"),
        ] {
            assert_eq!(base64(plain.as_bytes()), coded);
        }
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!(
            [0.0, -0.001, 1.5, -2.0, 100.0, 0.126].map(number),
            ["0", "0", "1.5", "-2", "100", "0.13"]
        );
    }
}
