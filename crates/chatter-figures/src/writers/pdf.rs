//! Scene to PDF: vectors, embedded fonts with their characters, pictures with opacity as soft masks.

use std::collections::{BTreeMap, BTreeSet};

use miniz_oxide::deflate::compress_to_vec_zlib;
use pdf_writer::types::{
    CidFontType, FontFlags, LineCapStyle, LineJoinStyle, SystemInfo, UnicodeCmap,
};
use pdf_writer::{Content, Filter, Finish, Name, Pdf, Ref, Str, TextStr};
use subsetter::GlyphRemapper;

use super::png::LEVEL;
use crate::color::Color;
use crate::labels::fonts::{CAP_HEIGHT, DESCENT, FACES, Face};
use crate::scene::{GlyphRun, Image, Path, Primitive, Scene, Segment, Stroke, Turn};

/// The whole document.
pub(crate) fn document(scene: &Scene) -> Vec<u8> {
    let mut writer = Writer {
        pdf: Pdf::new(),
        next: 1,
        content: Content::new(),
        images: Vec::new(),
        symbols: Vec::new(),
        opacities: BTreeSet::new(),
        glyphs: FACES.map(|_| GlyphRemapper::new()),
    };
    writer.write(scene);
    writer.pdf.finish()
}

struct Writer {
    pdf: Pdf,
    next: i32,
    content: Content,
    images: Vec<Ref>,
    /// Shapes drawn at many places.
    symbols: Vec<Ref>,
    /// Opacities used, of 255.
    opacities: BTreeSet<u8>,
    /// For each face the glyphs that are shown: only these are embedded, under new numbers.
    glyphs: [GlyphRemapper; 2],
}

impl Writer {
    fn reference(&mut self) -> Ref {
        self.next += 1;
        Ref::new(self.next - 1)
    }

    fn write(&mut self, scene: &Scene) {
        let [catalog, pages, page, contents, info] = std::array::from_fn(|_| self.reference());
        let mut shown: [BTreeMap<u16, char>; 2] = Default::default();
        let runs = scene.all().filter_map(|item| match item {
            Primitive::Text(run) => Some(&run.glyphs),
            _ => None,
        });
        for glyph in runs.flatten() {
            let new = self.glyphs[glyph.face as usize].remap(glyph.id);
            shown[glyph.face as usize]
                .entry(new)
                .or_insert(glyph.character);
        }
        let fonts: Vec<(Face, Ref)> = FACES
            .into_iter()
            .filter(|&face| !shown[face as usize].is_empty())
            .map(|face| (face, self.font(face, &shown[face as usize])))
            .collect();

        // Points downwards, as in the scene.
        self.content
            .transform([1.0, 0.0, 0.0, -1.0, 0.0, scene.height as f32]);
        scene.items.iter().for_each(|item| self.draw(item));
        let content = std::mem::replace(&mut self.content, Content::new()).finish();
        let content = compress_to_vec_zlib(&content, LEVEL);
        self.pdf
            .stream(contents, &content)
            .filter(Filter::FlateDecode);

        self.pdf.catalog(catalog).pages(pages);
        self.pdf.pages(pages).kids([page]).count(1);
        let mut p = self.pdf.page(page);
        p.media_box(pdf_writer::Rect::new(
            0.0,
            0.0,
            scene.width as f32,
            scene.height as f32,
        ));
        p.parent(pages);
        p.contents(contents);
        let mut resources = p.resources();
        let mut list = resources.fonts();
        for &(face, font) in &fonts {
            list.pair(font_name(face), font);
        }
        list.finish();
        let mut list = resources.x_objects();
        for (k, &image) in self.images.iter().enumerate() {
            list.pair(Name(format!("I{k}").as_bytes()), image);
        }
        for (k, &symbol) in self.symbols.iter().enumerate() {
            list.pair(Name(format!("S{k}").as_bytes()), symbol);
        }
        list.finish();
        let mut list = resources.ext_g_states();
        for &a in &self.opacities {
            let opacity = f32::from(a) / 255.0;
            let mut state = list
                .insert(Name(format!("A{a}").as_bytes()))
                .start::<pdf_writer::writers::ExtGraphicsState>();
            state.non_stroking_alpha(opacity).stroking_alpha(opacity);
        }
        list.finish();
        resources.finish();
        p.finish();

        let mut information = self.pdf.document_info(info);
        if !scene.title.is_empty() {
            information.title(TextStr(&scene.title));
        }
        if !scene.caption.is_empty() {
            information.subject(TextStr(&scene.caption));
        }
        information.creator(TextStr("chatter"));
    }

    fn draw(&mut self, item: &Primitive) {
        match item {
            Primitive::Path { path, fill, stroke } => self.paint(path, *fill, stroke.as_ref()),
            Primitive::Symbols {
                shape,
                fill,
                stroke,
                places,
            } => self.draw_symbols(shape, *fill, stroke.as_ref(), places),
            Primitive::Image(image) => self.draw_image(image),
            Primitive::Text(run) => self.draw_text(run),
            Primitive::Clip { rect, items } => {
                self.content.save_state();
                outline(&rect.path(), &mut self.content);
                self.content.clip_nonzero().end_path();
                items.iter().for_each(|item| self.draw(item));
                self.content.restore_state();
            }
        }
    }

    fn paint(&mut self, path: &Path, fill: Option<Color>, stroke: Option<&Stroke>) {
        if path.0.is_empty() {
            return;
        }
        self.content.save_state();
        self.set_colors(fill, stroke);
        outline(path, &mut self.content);
        finish_path(fill, stroke, &mut self.content);
        self.content.restore_state();
    }

    fn set_colors(&mut self, fill: Option<Color>, stroke: Option<&Stroke>) {
        let opacity = fill.or(stroke.map(|s| s.color)).map_or(255, |c| c.a);
        if opacity < 255 {
            self.opacities.insert(opacity);
            self.content
                .set_parameters(Name(format!("A{opacity}").as_bytes()));
        }
        let channels = |c: Color| [c.r, c.g, c.b].map(|v| f32::from(v) / 255.0);
        if let Some(color) = fill {
            let [r, g, b] = channels(color);
            self.content.set_fill_rgb(r, g, b);
        }
        if let Some(s) = stroke {
            let [r, g, b] = channels(s.color);
            self.content.set_stroke_rgb(r, g, b);
            self.content.set_line_width(s.width as f32);
            if s.dash.is_empty() {
                self.content.set_line_cap(LineCapStyle::RoundCap);
                self.content.set_line_join(LineJoinStyle::RoundJoin);
            } else {
                self.content
                    .set_dash_pattern(s.dash.iter().map(|&l| l as f32), 0.0);
            }
        }
    }

    /// One form per shape, so that each place costs a few bytes.
    fn draw_symbols(
        &mut self,
        shape: &Path,
        fill: Option<Color>,
        stroke: Option<&Stroke>,
        places: &[(f64, f64)],
    ) {
        if places.is_empty() {
            return;
        }
        let reach = shape.0.iter().fold(0.0f64, |reach, s| match *s {
            Segment::Move(x, y) | Segment::Line(x, y) => reach.max(x.abs()).max(y.abs()),
            Segment::Cubic(c) => c.iter().fold(reach, |r, v| r.max(v.abs())),
            Segment::Close => reach,
        });
        let reach = (reach + stroke.map_or(0.0, |s| s.width)) as f32;
        let mut form = Content::new();
        outline(shape, &mut form);
        finish_path(fill, stroke, &mut form);
        let id = self.reference();
        let form = form.finish();
        let mut object = self.pdf.form_xobject(id, &form);
        object.bbox(pdf_writer::Rect::new(-reach, -reach, reach, reach));
        object.resources();
        object.finish();
        let name = format!("S{}", self.symbols.len());
        self.symbols.push(id);
        self.content.save_state();
        self.set_colors(fill, stroke);
        let mut at = (0.0f64, 0.0f64);
        for &(x, y) in places {
            // From place to place by differences of rounded places, so that rounding does not add up.
            let place = (rounded(x), rounded(y));
            self.content.transform([
                1.0,
                0.0,
                0.0,
                1.0,
                rounded(place.0 - at.0) as f32,
                rounded(place.1 - at.1) as f32,
            ]);
            self.content.x_object(Name(name.as_bytes()));
            at = place;
        }
        self.content.restore_state();
    }

    fn draw_image(&mut self, image: &Image) {
        let [id, mask] = std::array::from_fn(|_| self.reference());
        let rgb: Vec<u8> = image.pixels.iter().flat_map(|c| [c.r, c.g, c.b]).collect();
        let alpha: Vec<u8> = image.pixels.iter().map(|c| c.a).collect();
        let opaque = alpha.iter().all(|&a| a == 255);
        let rgb = compress_to_vec_zlib(&rgb, LEVEL);
        let size = (image.width as i32, image.height as i32);
        let mut object = self.pdf.image_xobject(id, &rgb);
        object.width(size.0).height(size.1).bits_per_component(8);
        object.filter(Filter::FlateDecode);
        object.color_space().device_rgb();
        if !opaque {
            object.s_mask(mask);
        }
        object.finish();
        if !opaque {
            let alpha = compress_to_vec_zlib(&alpha, LEVEL);
            let mut object = self.pdf.image_xobject(mask, &alpha);
            object.width(size.0).height(size.1).bits_per_component(8);
            object.filter(Filter::FlateDecode);
            object.color_space().device_gray();
        }
        let name = format!("I{}", self.images.len());
        self.images.push(id);
        let r = &image.rect;
        self.content.save_state();
        // A picture fills the unit square with its foot at the bottom.
        self.content.transform([
            r.width() as f32,
            0.0,
            0.0,
            -r.height() as f32,
            r.left as f32,
            r.bottom as f32,
        ]);
        self.content.x_object(Name(name.as_bytes()));
        self.content.restore_state();
    }

    fn draw_text(&mut self, run: &GlyphRun) {
        if run.glyphs.is_empty() {
            return;
        }
        self.content.save_state();
        self.set_colors(Some(run.color), None);
        self.content.begin_text();
        let mut font = None;
        for g in &run.glyphs {
            if font != Some((g.face, g.size)) {
                self.content.set_font(font_name(g.face), g.size as f32);
                font = Some((g.face, g.size));
            }
            // Glyphs stand upright although the page is upside down.
            let matrix = match run.turn {
                Turn::None => [1.0, 0.0, 0.0, -1.0, run.x + g.x, run.y + g.y],
                Turn::Left => [0.0, -1.0, -1.0, 0.0, run.x + g.y, run.y - g.x],
            };
            self.content
                .set_text_matrix(matrix.map(|v| rounded(v) as f32));
            let id = self.glyphs[g.face as usize].remap(g.id);
            self.content.show(Str(&id.to_be_bytes()));
        }
        self.content.end_text();
        self.content.restore_state();
    }

    /// Embeds what is shown of a font, glyphs by number, with the characters that they show.
    fn font(&mut self, face: Face, shown: &BTreeMap<u16, char>) -> Ref {
        let [font, cid, descriptor, file, unicode] = std::array::from_fn(|_| self.reference());
        let system = SystemInfo {
            registry: Str(b"Adobe"),
            ordering: Str(b"Identity"),
            supplement: 0,
        };
        let name = Name(face.name().as_bytes());
        self.pdf
            .type0_font(font)
            .base_font(name)
            .encoding_predefined(Name(b"Identity-H"))
            .descendant_font(cid)
            .to_unicode(unicode);
        let glyphs = &self.glyphs[face as usize];
        let mut object = self.pdf.cid_font(cid);
        object
            .subtype(CidFontType::Type2)
            .base_font(name)
            .system_info(system)
            .font_descriptor(descriptor)
            .cid_to_gid_map_predefined(Name(b"Identity"));
        object.widths().consecutive(
            0,
            glyphs
                .remapped_gids()
                .map(|g| (1000.0 * face.advance(g)) as f32),
        );
        object.finish();
        let parsed = face.parsed();
        let per_mille = |v: i16| (1000.0 * f64::from(v) / face.units()) as f32;
        let bounds = parsed.global_bounding_box();
        let (flags, angle) = match face {
            Face::Regular => (FontFlags::SYMBOLIC, 0.0),
            Face::Italic => (FontFlags::SYMBOLIC | FontFlags::ITALIC, -12.0),
        };
        self.pdf
            .font_descriptor(descriptor)
            .name(name)
            .flags(flags)
            .bbox(pdf_writer::Rect::new(
                per_mille(bounds.x_min),
                per_mille(bounds.y_min),
                per_mille(bounds.x_max),
                per_mille(bounds.y_max),
            ))
            .italic_angle(angle)
            .ascent(per_mille(parsed.ascender()))
            .descent((-1000.0 * DESCENT) as f32)
            .cap_height((1000.0 * CAP_HEIGHT) as f32)
            .stem_v(80.0)
            .font_file2(file);
        let subset = subsetter::subset(face.data(), 0, &self.glyphs[face as usize])
            .expect("the embedded font is whole");
        let data = compress_to_vec_zlib(&subset, LEVEL);
        self.pdf
            .stream(file, &data)
            .filter(Filter::FlateDecode)
            .pair(Name(b"Length1"), subset.len() as i32);
        let mut map = UnicodeCmap::new(Name(b"Chatter"), system);
        for (&id, &character) in shown {
            map.pair(id, character);
        }
        let map = compress_to_vec_zlib(&map.finish(), LEVEL);
        self.pdf.stream(unicode, &map).filter(Filter::FlateDecode);
        font
    }
}

fn font_name(face: Face) -> Name<'static> {
    Name(match face {
        Face::Regular => b"F0",
        Face::Italic => b"F1",
    })
}

fn finish_path(fill: Option<Color>, stroke: Option<&Stroke>, content: &mut Content) {
    match (fill, stroke) {
        (Some(_), Some(_)) => content.fill_nonzero_and_stroke(),
        (Some(_), None) => content.fill_nonzero(),
        (None, Some(_)) => content.stroke(),
        (None, None) => content.end_path(),
    };
}

/// To a thousandth of a point: finer is not seen, and costs bytes.
fn rounded(x: f64) -> f64 {
    (x * 1000.0).round() / 1000.0
}

fn outline(path: &Path, content: &mut Content) {
    let r = |v: f64| rounded(v) as f32;
    for segment in &path.0 {
        match *segment {
            Segment::Move(x, y) => content.move_to(r(x), r(y)),
            Segment::Line(x, y) => content.line_to(r(x), r(y)),
            Segment::Cubic([a, b, c, d, x, y]) => {
                content.cubic_to(r(a), r(b), r(c), r(d), r(x), r(y))
            }
            Segment::Close => content.close_path(),
        };
    }
}
