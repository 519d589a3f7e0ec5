//! Scene to SVG: text as text, to be searched, edited and read aloud, each character at its place, so that figures look
//! alike in every font that has the widths of the embedded one. Arial and Helvetica have them.

use std::collections::BTreeMap;
use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::png;
use crate::color::Color;
use crate::labels::fonts::Face;
use crate::scene::{Glyph, GlyphRun, Image, Path, Primitive, Scene, Segment, Stroke, Turn};

/// The whole document.
pub(crate) fn document(scene: &Scene) -> String {
    let prolog = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
    prolog.to_owned() + &element(scene, " xmlns=\"http://www.w3.org/2000/svg\"", "chatter")
}

/// Fonts of equal widths, where they are called so.
const FONTS: &str = "Liberation Sans, Arimo, Arial, Helvetica, sans-serif";

/// The element alone, with this text among its attributes. Inside HTML it needs no name space; whatever it refers to has
/// a name that begins with `name`, which is to be the element's own in the page.
pub(crate) fn element(scene: &Scene, attributes: &str, name: &str) -> String {
    let mut body = String::new();
    let mut definitions = Definitions {
        name: name.to_owned(),
        ..Definitions::default()
    };
    for item in &scene.items {
        draw(item, &mut body, &mut definitions);
    }
    let (w, h) = (number(scene.width), number(scene.height));
    let mm = |points: f64| number(points * 25.4 / 72.0);
    let mut out = String::with_capacity(body.len() + 4096);
    let _ = writeln!(
        out,
        "<svg{attributes} width=\"{}mm\" height=\"{}mm\" viewBox=\"0 0 {w} {h}\" \
         font-family=\"{FONTS}\">",
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

/// Things drawn several times or referred to, under names made from their content.
#[derive(Default)]
struct Definitions {
    /// With what names begin.
    name: String,
    shapes: BTreeMap<String, String>,
    clips: BTreeMap<String, String>,
}

impl Definitions {
    fn write(&self, out: &mut String) {
        if self.shapes.is_empty() && self.clips.is_empty() {
            return;
        }
        out.push_str("<defs>\n");
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

    fn content_name(&self, kind: char, content: &str) -> String {
        let hash = crc32fast::hash(content.as_bytes());
        format!("{}-{kind}{hash:08x}", self.name)
    }
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
            let name = definitions.content_name('s', &data);
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
        Primitive::Text(run) => draw_text(run, out),
        Primitive::Clip { rect, items } => {
            let data = path_data(&rect.path());
            let name = definitions.content_name('c', &data);
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
        STANDARD.encode(png::encode_image(image))
    );
}

fn draw_text(run: &GlyphRun, out: &mut String) {
    let turn = match run.turn {
        Turn::None => "",
        Turn::Left => " rotate(-90)",
    };
    out.push_str("<text xml:space=\"preserve\"");
    paint(&Some(run.color), &None, out);
    let _ = write!(
        out,
        " transform=\"translate({} {}){turn}\">",
        number(run.x),
        number(run.y)
    );
    let together =
        |a: &Glyph, b: &Glyph| a.face == b.face && a.size == b.size && number(a.y) == number(b.y);
    for glyphs in run.glyphs.chunk_by(together) {
        let first = &glyphs[0];
        let places: Vec<String> = glyphs.iter().map(|g| number(g.x)).collect();
        let style = match first.face {
            Face::Regular => "",
            Face::Italic => " font-style=\"italic\"",
        };
        let text: String = glyphs.iter().map(|g| g.character).collect();
        let _ = write!(
            out,
            "<tspan x=\"{}\" y=\"{}\" font-size=\"{}\"{style}>{}</tspan>",
            places.join(" "),
            number(first.y),
            number(first.size),
            escaped(&text)
        );
    }
    out.push_str("</text>\n");
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        assert_eq!(
            [0.0, -0.001, 1.5, -2.0, 100.0, 0.126].map(number),
            ["0", "0", "1.5", "-2", "100", "0.13"]
        );
    }
}
