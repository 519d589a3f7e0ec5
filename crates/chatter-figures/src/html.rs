//! Labels and figures inside a page of HTML.

use super::fonts::Face;
use super::label::{LabelError, Node, Spacing, parse};

/// Text with markup as HTML: letters in `<i>`, indices and exponents in `<sub>` and `<sup>`.
pub(crate) fn markup(source: &str) -> Result<String, LabelError> {
    let mut out = String::with_capacity(source.len() + 16);
    write(&parse(source)?, Level::Line, &mut out);
    Ok(out.replace("</i><i>", ""))
}

/// Text without markup as HTML.
pub(crate) fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    text.chars().for_each(|c| character(c, &mut out));
    out
}

#[derive(Clone, Copy, PartialEq)]
enum Level {
    Line,
    Script,
}

fn character(c: char, out: &mut String) {
    match c {
        '&' => out.push_str("&amp;"),
        '<' => out.push_str("&lt;"),
        '>' => out.push_str("&gt;"),
        '"' => out.push_str("&quot;"),
        c => out.push(c),
    }
}

/// Combining form of a mark that figures draw above a symbol.
fn combining(mark: char) -> char {
    match mark {
        '˙' => '\u{307}',
        '¨' => '\u{308}',
        'ˆ' => '\u{302}',
        '˜' => '\u{303}',
        _ => '\u{304}',
    }
}

fn write(nodes: &[Node], level: Level, out: &mut String) {
    for node in nodes {
        match node {
            Node::Char(c, Face::Regular) => character(*c, out),
            Node::Char(c, Face::Italic) => {
                out.push_str("<i>");
                character(*c, out);
                out.push_str("</i>");
            }
            Node::Space(_, Spacing::Operator) if level == Level::Script => {}
            Node::Space(ems, _) if *ems < 0.0 => {}
            // No line ends beside an operator.
            Node::Space(_, Spacing::Operator) => out.push('\u{202f}'),
            Node::Space(ems, Spacing::Wanted) if *ems < 0.5 => out.push('\u{202f}'),
            Node::Space(..) => out.push('\u{2003}'),
            Node::Scripts { sub, sup } => {
                for (tag, body) in [("sub", sub), ("sup", sup)] {
                    if !body.is_empty() {
                        out.push_str(&format!("<{tag}>"));
                        write(body, Level::Script, out);
                        out.push_str(&format!("</{tag}>"));
                    }
                }
            }
            Node::Accent { mark, body } => {
                let mut inner = String::new();
                write(body, level, &mut inner);
                // The mark belongs to the last letter, inside its tag.
                let at = inner.strip_suffix("</i>").map_or(inner.len(), str::len);
                inner.insert(at, combining(*mark));
                out.push_str(&inner);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mathematics_becomes_tags() {
        let html = |source| markup(source).unwrap();
        assert_eq!(html("a < b & c"), "a &lt; b &amp; c");
        assert_eq!(html("$q^*$"), "<i>q</i><sup>*</sup>");
        assert_eq!(html("$y_{10}$ is"), "<i>y</i><sub>10</sub> is");
        assert_eq!(html("$CAB$"), "<i>CAB</i>");
        assert_eq!(html("$\\dot{y}$"), "<i>y\u{307}</i>");
        assert_eq!(
            html("$z \\to \\Upsilon(K z + \\mu)$"),
            "<i>z</i>\u{202f}→\u{202f}ϒ(<i>Kz</i>\u{202f}+\u{202f}<i>μ</i>)"
        );
        assert!(markup("$q").is_err());
    }
}
