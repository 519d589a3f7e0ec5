//! Figure files: well formed, equal for equal input, small for large data, and alike in all formats.

use chatter_figures::*;
use miniz_oxide::inflate::decompress_to_vec_zlib;

/// One figure with every kind of layer, and text that formats must escape.
fn everything() -> Figure {
    let x: Vec<f64> = (0..500).map(|k| f64::from(k) / 100.0).collect();
    let y: Vec<f64> = x.iter().map(|x| x * x - 3.0 * x).collect();
    let mut density = Density::new((0.0, 5.0), (-3.0, 10.0));
    density.extend(x.iter().zip(&y).map(|(&x, &y)| (x, y + 1.0)));
    let sparse = |v: &[f64]| v.iter().copied().step_by(50).collect::<Vec<f64>>();
    let categories = vec![
        Category::new("a < b & \"c\"", Color::BLUE),
        Category::new("d", Color::ORANGE),
    ];
    Figure::new()
        .columns(2)
        .width(178.0)
        .panel(
            Panel::new(Axis::new("$x$").unit("mm"), Axis::new("$\\dot{y}_1$"))
                .title("title")
                .with(Spans::new(vec![(1.0, 2.0)]).label("contact"))
                .with(density)
                .with(
                    Line::new(x.clone(), y.clone())
                        .label("line")
                        .dash(Dash::Dashed),
                )
                .with(Markers::new(sparse(&x), sparse(&y)))
                .with(Rule::horizontal(0.0).label("<rule>")),
        )
        .panel(
            Panel::new(Axis::new("$a$").logarithmic(), Axis::new("$b$")).with(HeatMap::new(
                vec![1.0, 10.0],
                vec![0.0, 1.0],
                vec![0.0, 1.0, 2.0, f64::NAN],
            )),
        )
        .panel(
            Panel::new(Axis::new("$a$"), Axis::new("$b$")).with(CategoryMap::new(
                vec![0.0, 1.0],
                vec![0.0],
                vec![Some(0), None],
                categories,
            )),
        )
        .title("Everything & <more>")
        .caption("How it was made: é, Ω")
}

/// Checks that tags nest, attributes are quoted, signs are escaped, and names that are referred to exist once.
fn check_xml(text: &str) {
    let mut rest = text
        .strip_prefix("<?xml version=\"1.0\" encoding=\"UTF-8\"?>")
        .expect("declaration");
    let mut open: Vec<&str> = Vec::new();
    let (mut ids, mut references) = (Vec::new(), Vec::new());
    while let Some(start) = rest.find('<') {
        check_text(&rest[..start]);
        let end = rest.find('>').expect("tag is closed");
        let tag = &rest[start + 1..end];
        rest = &rest[end + 1..];
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name));
            continue;
        }
        let (tag, alone) = match tag.strip_suffix('/') {
            Some(tag) => (tag, true),
            None => (tag, false),
        };
        let name = tag.split_whitespace().next().expect("a name");
        let mut attributes = tag[name.len()..].trim_start();
        while !attributes.is_empty() {
            let (key, after) = attributes.split_once("=\"").expect("an attribute");
            assert!(
                key.chars()
                    .all(|c| c.is_ascii_alphanumeric() || c == '-' || c == ':'),
                "{key}"
            );
            let (value, after) = after.split_once('"').expect("a closing quote");
            check_text(value);
            match key {
                "id" => ids.push(value),
                "href" => references.extend(value.strip_prefix('#')),
                "clip-path" => references.push(&value[5..value.len() - 1]),
                // A place that is not a number would be written as one of these.
                "d" | "x" | "y" | "transform" => {
                    assert!(!value.contains("NaN") && !value.contains("inf"), "{value}")
                }
                _ => {}
            }
            attributes = after.trim_start();
        }
        if !alone {
            open.push(name);
        }
    }
    assert!(open.is_empty() && rest.trim().is_empty());
    for r in references {
        assert_eq!(ids.iter().filter(|id| **id == r).count(), 1, "{r}");
    }
}

fn check_text(text: &str) {
    for (k, _) in text.match_indices('&') {
        let entity = &text[k..];
        assert!(
            ["&amp;", "&lt;", "&gt;", "&quot;"]
                .iter()
                .any(|e| entity.starts_with(e)),
            "{entity}"
        );
    }
    assert!(!text.contains('<'));
}

#[test]
fn svg_is_well_formed() {
    let svg = everything().svg().unwrap();
    check_xml(&svg);
    assert!(svg.contains("<title>Everything &amp; &lt;more&gt;</title>"));
    assert!(svg.contains(">a &lt; b &amp; &quot;c&quot;</tspan>"));
}

#[test]
fn the_cross_references_of_pdf_point_at_objects() {
    let pdf = everything().pdf().unwrap();
    assert!(pdf.starts_with(b"%PDF-1."));
    let last = pdf.windows(9).rposition(|w| w == b"startxref").unwrap();
    let tail = String::from_utf8_lossy(&pdf[last..]).into_owned();
    let start: usize = tail.lines().nth(1).unwrap().parse().unwrap();
    let table = String::from_utf8_lossy(&pdf[start..]).into_owned();
    let mut lines = table.lines();
    assert_eq!(lines.next(), Some("xref"));
    let count: usize = lines
        .next()
        .unwrap()
        .split(' ')
        .nth(1)
        .unwrap()
        .parse()
        .unwrap();
    assert!(count > 10);
    for number in 0..count {
        let entry = lines.next().unwrap();
        if entry.contains(" n") {
            let offset: usize = entry[..10].parse().unwrap();
            assert!(
                pdf[offset..].starts_with(format!("{number} 0 obj").as_bytes()),
                "object {number}"
            );
        }
    }
    assert!(table.contains("/Root 1 0 R"));
    let text = String::from_utf8_lossy(&pdf).into_owned();
    assert!(!text.contains("CreationDate"));
    // 178 mm.
    assert!(text.contains("/MediaBox [0 0 504.5669"));
}

/// Width, height, chunks and pixels (rows of `channels` bytes a pixel) of a PNG; its data must inflate whole.
fn decode(png: &[u8], channels: usize) -> (usize, usize, Vec<String>, Vec<u8>) {
    assert!(png.starts_with(b"\x89PNG\r\n\x1a\n"));
    let (mut at, mut names, mut data) = (8, Vec::new(), Vec::new());
    let (mut width, mut height) = (0, 0);
    while at < png.len() {
        let number = |at: usize| u32::from_be_bytes(png[at..at + 4].try_into().unwrap()) as usize;
        let length = number(at);
        let kind = std::str::from_utf8(&png[at + 4..at + 8]).unwrap();
        match kind {
            "IHDR" => (width, height) = (number(at + 8), number(at + 12)),
            "IDAT" => data.extend_from_slice(&png[at + 8..at + 8 + length]),
            _ => {}
        }
        names.push(kind.to_string());
        at += 12 + length;
    }
    let raw = decompress_to_vec_zlib(&data).expect("whole and of the right checksum");
    let mut pixels: Vec<u8> = Vec::new();
    for row in raw.chunks_exact(1 + channels * width) {
        let above = pixels.len().checked_sub(channels * width);
        for (k, &byte) in row[1..].iter().enumerate() {
            pixels.push(match (row[0], above) {
                (0, _) | (2, None) => byte,
                (2, Some(above)) => byte.wrapping_add(pixels[above + k]),
                (filter, _) => panic!("filter {filter}"),
            });
        }
    }
    assert_eq!(pixels.len(), channels * width * height);
    (width, height, names, pixels)
}

#[test]
fn png_has_the_size_of_print() {
    let png = everything().png(Resolution::PRINT).unwrap();
    let (width, _, chunks, pixels) = decode(&png, 3);
    assert_eq!(width, (178.0f64 / 25.4 * 300.0).round() as usize);
    assert_eq!(chunks, ["IHDR", "pHYs", "iTXt", "iTXt", "IDAT", "IEND"]);
    assert_eq!(pixels[..3], [255, 255, 255]);
    assert!(
        pixels
            .chunks_exact(3)
            .any(|p| *p == [Color::INK.r, Color::INK.g, Color::INK.b])
    );
}

#[test]
fn equal_input_gives_equal_bytes() {
    let (a, b) = (everything(), everything());
    assert_eq!(a.svg().unwrap(), b.svg().unwrap());
    assert_eq!(a.pdf().unwrap(), b.pdf().unwrap());
    assert_eq!(
        a.png(Resolution::PRINT).unwrap(),
        b.png(Resolution::PRINT).unwrap()
    );
}

#[test]
fn a_curve_of_a_million_points_makes_small_files() {
    let n = 1_000_000;
    let x: Vec<f64> = (0..n).map(f64::from).collect();
    let y: Vec<f64> = x
        .iter()
        .map(|x| (x * 1e-3).sin() * (x * 1e-5).cos())
        .collect();
    let figure = Figure::from(Panel::new(Axis::new("$t$"), Axis::new("$x$")).with(Line::new(x, y)));
    let (svg, pdf) = (figure.svg().unwrap(), figure.pdf().unwrap());
    assert!(svg.len() < 400_000, "SVG of {} bytes", svg.len());
    assert!(pdf.len() < 250_000, "PDF of {} bytes", pdf.len());
}

#[test]
fn a_point_of_a_density_is_where_its_marker_would_be() {
    let panel = || {
        Panel::new(
            Axis::new("$x$").range(0.0, 10.0),
            Axis::new("$y$").range(0.0, 1.0),
        )
    };
    let red = Color::rgb(255, 0, 0);
    let middle_of_red = |figure: Figure| {
        let (width, _, _, pixels) = decode(&figure.png(Resolution::PRINT).unwrap(), 3);
        let (mut x, mut y, mut n) = (0.0, 0.0, 0.0);
        for (k, p) in pixels.chunks_exact(3).enumerate() {
            if p[0] > 200 && p[1] < 200 && p[2] < 200 {
                (x, y, n) = (x + (k % width) as f64, y + (k / width) as f64, n + 1.0);
            }
        }
        assert!(n > 0.0, "it is seen");
        (x / n, y / n)
    };
    let a = middle_of_red(
        panel()
            .with(Markers::new(vec![7.3], vec![0.21]).color(red))
            .into(),
    );
    let mut density = Density::new((0.0, 10.0), (0.0, 1.0)).color(red);
    density.add(7.3, 0.21);
    let b = middle_of_red(panel().with(density).into());
    assert!(
        (a.0 - b.0).abs() <= 1.0 && (a.1 - b.1).abs() <= 1.0,
        "{a:?} and {b:?}"
    );
}

#[test]
fn odd_data_are_drawn_or_refused_but_never_bring_it_down() {
    let odd = [
        f64::NAN,
        f64::INFINITY,
        -f64::MAX,
        f64::MAX,
        f64::MIN_POSITIVE,
        0.0,
        -0.0,
        5e-324,
    ];
    for logarithmic in [false, true] {
        for &a in &odd {
            for &b in &odd {
                let axis = |label: &str| match logarithmic {
                    true => Axis::new(label).logarithmic(),
                    false => Axis::new(label),
                };
                let panel = Panel::new(axis("$x$"), axis("$y$"))
                    .with(Line::new(vec![a, b, 1.0], vec![b, a, 2.0]).label("line"))
                    .with(Markers::new(vec![a], vec![b]))
                    .with(Spans::new(vec![(a, b)]))
                    .with(Rule::vertical(a));
                let figure = Figure::from(panel);
                check_xml(&figure.svg().unwrap());
                figure.png(Resolution(50.0)).unwrap();
                let given = Axis::new("$x$").range(a, b);
                if let Ok(svg) = Figure::from(Panel::new(given, axis("$y$"))).svg() {
                    check_xml(&svg);
                }
                let mut density = Density::new((a, b), (b, a)).cells(50, 50);
                density.add(a, b);
                let density = Panel::new(Axis::new(""), Axis::new("")).with(density);
                let _ = Figure::from(density).png(Resolution(50.0));
            }
        }
    }
}

#[test]
fn a_figure_goes_into_the_format_of_its_name_or_says_why_not() {
    let folder = std::env::temp_dir().join(format!("chatter-figures-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let figure = Figure::from(Panel::new(Axis::new("$x$"), Axis::new("$y$")));
    for (name, start) in [
        ("a.svg", &b"<?xml"[..]),
        ("a.PDF", b"%PDF"),
        ("a.png", b"\x89PNG"),
    ] {
        let path = folder.join(name);
        figure.write(&path).unwrap();
        assert!(std::fs::read(path).unwrap().starts_with(start));
    }
    let error = figure.write(folder.join("a.csv")).unwrap_err().to_string();
    assert!(
        error.ends_with("unknown extension `.csv`; a figure is written as .svg, .png, .pdf"),
        "{error}"
    );
    let wrong = Figure::from(Panel::new(Axis::new("$\\lamda$"), Axis::new("$y$")));
    let error = wrong.write(folder.join("b.svg")).unwrap_err().to_string();
    assert!(error.contains("did you mean `\\lambda`?"), "{error}");
    assert!(!folder.join("b.svg").exists());
    std::fs::remove_dir_all(folder).unwrap();
}
