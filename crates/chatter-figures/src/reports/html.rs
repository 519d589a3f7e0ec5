//! Report to HTML.

use super::report::{Align, Block, Grid, Picture, Report};
use super::report_error::{ReportError, ReportPart};
use crate::Resolution;
use crate::labels::html::{escaped, markup};
use std::fmt::Write;

/// Serif text of moderate width, tables with horizontal rules only, nothing torn apart by a page's end.
const STYLE: &str = include_str!("style.css");

/// Pictures in figures: three times as large as at first there is nothing more to be seen in them.
const PICTURES: Resolution = Resolution(240.0);

/// Sections from which a list of contents is worth its place.
const CONTENTS_FROM: usize = 3;

/// The whole page.
pub(super) fn document(report: &Report) -> Result<String, ReportError> {
    let mut out = String::new();
    // The title of the window knows no markup.
    let plain: String = escaped(&report.title.replace('$', ""));
    let _ = write!(
        out,
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{plain}</title>\n\
         <style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n<h1>{}</h1>\n",
        text(&report.title, None)?
    );
    if !report.summary.is_empty() {
        let _ = writeln!(
            out,
            "<p class=\"summary\">{}</p>",
            text(&report.summary, None)?
        );
    }
    contents(report, &mut out)?;
    let (mut section, mut pictures) = (0, 0);
    for (place, block) in report.blocks.iter().enumerate() {
        let part = Some(place);
        match block {
            Block::Heading(heading) => {
                section += 1;
                let heading = text(heading, part)?;
                let _ = writeln!(out, "<h2 id=\"section-{section}\">{heading}</h2>");
            }
            Block::Paragraph(paragraph) => {
                let _ = writeln!(out, "<p>{}</p>", text(paragraph, part)?);
            }
            Block::Grid(grid) => table(grid, part, &mut out)?,
            Block::Picture(picture) => {
                pictures += 1;
                figure(picture, pictures, part, &mut out)?;
            }
        }
    }
    if !report.colophon.is_empty() {
        let _ = writeln!(out, "<footer>{}</footer>", text(&report.colophon, None)?);
    }
    out.push_str("</main>\n</body>\n</html>\n");
    Ok(out)
}

fn text(source: &str, part: ReportPart) -> Result<String, ReportError> {
    markup(source).map_err(|error| ReportError::Text { part, error })
}

fn contents(report: &Report, out: &mut String) -> Result<(), ReportError> {
    let headings = || {
        report
            .blocks
            .iter()
            .enumerate()
            .filter_map(|(place, block)| match block {
                Block::Heading(heading) => Some((place, heading)),
                _ => None,
            })
    };
    if headings().count() < CONTENTS_FROM {
        return Ok(());
    }
    out.push_str("<nav>\n<ol>\n");
    for (section, (place, heading)) in headings().enumerate() {
        let heading = text(heading, Some(place))?;
        let _ = writeln!(
            out,
            "<li><a href=\"#section-{}\">{heading}</a></li>",
            section + 1
        );
    }
    out.push_str("</ol>\n</nav>\n");
    Ok(())
}

fn table(grid: &Grid, part: ReportPart, out: &mut String) -> Result<(), ReportError> {
    let class = |align| match align {
        Align::Left => "",
        Align::Right => " class=\"n\"",
    };
    let _ = write!(
        out,
        "<div class=\"wide\">\n<table>\n<caption><b>{}.</b> {}</caption>\n<thead>\n<tr>",
        text(&grid.label, part)?,
        text(&grid.caption, part)?
    );
    for column in &grid.columns {
        let heading = text(&column.heading, part)?;
        let _ = write!(
            out,
            "<th scope=\"col\"{}>{heading}</th>",
            class(column.align)
        );
    }
    out.push_str("</tr>\n</thead>\n<tbody>\n");
    for (row, cells) in grid.rows.iter().enumerate() {
        if cells.len() != grid.columns.len() {
            return Err(ReportError::Cells {
                part,
                row,
                cells: cells.len(),
                columns: grid.columns.len(),
            });
        }
        out.push_str("<tr>");
        for (cell, column) in cells.iter().zip(&grid.columns) {
            let _ = write!(out, "<td{}>{}</td>", class(column.align), text(cell, part)?);
        }
        out.push_str("</tr>\n");
    }
    out.push_str("</tbody>\n</table>\n</div>\n");
    Ok(())
}

/// The `number`-th figure. What is a density can be enlarged: a box is ticked by a click on the figure, and the style
/// sheet does the rest.
fn figure(
    picture: &Picture,
    number: usize,
    part: ReportPart,
    out: &mut String,
) -> Result<(), ReportError> {
    let name = format!("figure-{number}");
    let svg = picture
        .figure
        .inline_svg(PICTURES, &name)
        .map_err(|error| ReportError::Figure { part, error })?;
    let label = text(&picture.label, part)?;
    let (before, after) = match picture.figure.has_density() {
        true => (
            format!(
                "<input type=\"checkbox\" id=\"{name}-zoom\" aria-label=\"Enlarge {}\"/>\
                 <label for=\"{name}-zoom\" title=\"Click to enlarge, and again to see all\">",
                escaped(&picture.label)
            ),
            "</label>",
        ),
        false => (String::new(), ""),
    };
    let _ = write!(
        out,
        "<figure>\n{before}{svg}{after}<figcaption><b>{label}.</b> {}</figcaption>\n</figure>\n",
        text(&picture.caption, part)?
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::Column;
    use super::*;
    use crate::{Axis, Density, Figure, Line, Panel};

    fn report() -> Report {
        let mut density = Density::new((0.0, 1.0), (0.0, 1.0));
        (0..1000)
            .for_each(|k| density.add(f64::from(k) / 1000.0, f64::from(k * k % 1000) / 1000.0));
        let figure = Figure::new()
            .panel(Panel::new(Axis::new("$\\mu$"), Axis::new("$z$")).with(density))
            .panel(
                Panel::new(Axis::new("$x$"), Axis::new("$\\Upsilon(x)$"))
                    .with(Line::new(vec![0.0, 1.0], vec![1.0, 0.0])),
            );
        let mut report = Report::new("Chatter & release at $q^*$", "What was found.");
        for name in ["First", "Second", "Third"] {
            report.heading(name);
            report.paragraph("The slope is $K = C A B$, and 1 < 2.");
        }
        report.add(
            Grid::new(
                "Table 1",
                "Numbers",
                [Column::words("what"), Column::numbers("ours")],
            )
            .row(["$q^*$", "0.020056"]),
        );
        report.add(Picture::new("Fig. 3", "Orbits of $z$.", figure));
        report.set_colophon("Made by a test.");
        report
    }

    /// Everything that could make a browser fetch something.
    #[test]
    fn the_page_refers_to_nothing_outside() {
        let page = report().html().unwrap();
        for forbidden in [
            "http:", "https:", "//", "<script", "<link", "@import", "src=",
        ] {
            // Base-64 has slashes of its own.
            let mut rest = page.as_str();
            let mut kept = String::new();
            while let Some((before, after)) = rest.split_once("base64,") {
                kept += before;
                rest = after.split_once('"').unwrap().1;
            }
            kept += rest;
            assert!(!kept.contains(forbidden), "{forbidden}");
        }
        for (place, _) in page.match_indices("href=\"") {
            let target = &page[place + 6..page.len().min(place + 100)];
            assert!(
                target.starts_with('#') || target.starts_with("data:image/png;base64,"),
                "{target}"
            );
        }
        assert!(!page.contains("<?xml"));
    }

    #[test]
    fn equal_reports_give_equal_bytes() {
        assert_eq!(report().html(), report().html());
    }

    #[test]
    fn tags_are_closed_in_order() {
        let page = report().html().unwrap();
        let mut open: Vec<&str> = Vec::new();
        for tag in page.split('<').skip(1) {
            let (inside, _) = tag.split_once('>').unwrap();
            let name = inside.split([' ', '\n']).next().unwrap();
            if let Some(closed) = name.strip_prefix('/') {
                assert_eq!(open.pop(), Some(closed));
            } else if !inside.ends_with('/') && !["!DOCTYPE", "meta"].contains(&name) {
                open.push(name);
            }
        }
        assert!(open.is_empty());
        assert!(page.contains("<td class=\"n\">0.020056</td>"));
        assert!(page.contains("Chatter &amp; release at <math"));
    }

    #[test]
    fn names_are_given_once_and_what_is_referred_to_is_there() {
        let mut report = report();
        for block in self::report().blocks {
            report.blocks.push(block);
        }
        let page = report.html().unwrap();
        let values = |attribute: &str| -> Vec<String> {
            let parts = page.split(attribute).skip(1);
            parts
                .map(|rest| rest.split(['"', ')']).next().unwrap().to_owned())
                .collect()
        };
        let mut names = values(" id=\"");
        let count = names.len();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), count);
        assert!(count >= 10);
        for attribute in [" for=\"", "url(#", "href=\"#"] {
            let used = values(attribute);
            assert!(
                !used.is_empty() && used.iter().all(|name| names.contains(name)),
                "{attribute}"
            );
        }
    }

    #[test]
    fn what_is_wrong_is_named_with_its_place() {
        let mut report = Report::new("Title", "");
        report.paragraph("$open");
        let error = report.html().unwrap_err();
        assert!(error.to_string().starts_with("report, block 0: label: "));
        let mut report = Report::new("Title", "");
        report.add(Grid::new("Table 1", "", [Column::words("a"), Column::words("b")]).row(["1"]));
        assert_eq!(
            report.html().unwrap_err().to_string(),
            "report, block 0: row 0 of the table has 1 cells for 2 columns"
        );
    }
}
