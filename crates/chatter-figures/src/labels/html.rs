//! Labels inside a page of HTML: mathematics as MathML.

use super::label::{LabelError, Node, parse};
use pulldown_latex::{Parser, RenderConfig, Storage, push_mathml};

/// Text with markup as HTML.
pub(crate) fn markup(source: &str) -> Result<String, LabelError> {
    // What figures cannot set is wrong in text, too.
    parse(source)?;
    let mut out = String::with_capacity(source.len() + 16);
    for (place, (at, part)) in parts(source).into_iter().enumerate() {
        match place % 2 {
            0 => write(&parse(part)?, &mut out),
            _ => mathematics(source, at, part, &mut out)?,
        }
    }
    Ok(out)
}

/// Text without markup as HTML.
pub(crate) fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    text.chars().for_each(|c| character(c, &mut out));
    out
}

/// Text and mathematics in turn, with the place of each in the source.
fn parts(source: &str) -> Vec<(usize, &str)> {
    let mut parts = Vec::new();
    let (mut from, mut after_backslash) = (0, false);
    for (place, c) in source.char_indices() {
        if c == '$' && !after_backslash {
            parts.push((from, &source[from..place]));
            from = place + 1;
        }
        after_backslash = c == '\\' && !after_backslash;
    }
    parts.push((from, &source[from..]));
    parts
}

fn mathematics(source: &str, at: usize, tex: &str, out: &mut String) -> Result<(), LabelError> {
    let wrong = |what: String| LabelError {
        source: source.to_owned(),
        at: source[..at].chars().count(),
        what,
    };
    // Elsewhere it is drawn as a Y.
    let tex = tex.replace("\\Upsilon", "{ϒ}");
    let storage = Storage::new();
    let events: Result<Vec<_>, _> = Parser::new(&tex, &storage).collect();
    let events = events.map_err(|error| wrong(error.to_string()))?;
    let events = events.into_iter().map(Ok::<_, core::fmt::Error>);
    push_mathml(out, events, RenderConfig::default()).map_err(|error| wrong(error.to_string()))
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

/// Text outside mathematics, where there are no indices.
fn write(nodes: &[Node], out: &mut String) {
    for node in nodes {
        match node {
            Node::Char(c, _) => character(*c, out),
            Node::Space(ems, _) if *ems < 0.5 => out.push('\u{202f}'),
            Node::Space(..) => out.push('\u{2003}'),
            Node::Accent { body, .. } => write(body, out),
            Node::Scripts { sub, sup } => {
                write(sub, out);
                write(sup, out);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::label::{ACCENTS, FUNCTIONS, GREEK, OPERATORS, RELATIONS, SYMBOLS};
    use super::*;

    #[test]
    fn mathematics_becomes_mathml() {
        let html = |source| markup(source).unwrap();
        assert_eq!(html("a < b & c, 5\\$"), "a &lt; b &amp; c, 5$");
        let index = html("$y_{10}$ is 1");
        assert!(index.starts_with("<math") && index.contains("<msub>"));
        assert!(index.ends_with("</math> is 1"));
        assert!(html("$q^*$").contains("<msup>"));
        assert!(html("$z \\to \\Upsilon(K z + \\mu)$").contains("→"));
        assert!(markup("$q").is_err());
    }

    #[test]
    fn whatever_figures_can_set_is_known() {
        let symbols = [&GREEK[..], &SYMBOLS, &RELATIONS, &OPERATORS].concat();
        let mut commands: Vec<String> = symbols
            .iter()
            .map(|(name, _)| format!("\\{name}"))
            .collect();
        commands.extend(ACCENTS.iter().map(|(name, _)| format!("\\{name}{{y}}")));
        commands.extend(FUNCTIONS.iter().map(|name| format!("\\{name}")));
        let others = [
            "\\mathrm{max}",
            "\\text{in use}",
            "a\\,b\\;c\\ d\\quad e",
            "\\$\\%\\_\\{\\}",
            "y_1^{\\dagger *}",
            "y'",
        ];
        commands.extend(others.map(str::to_owned));
        for command in commands {
            let html = markup(&format!("${command}$"));
            assert!(html.is_ok_and(|html| !html.contains("merror")), "{command}");
        }
    }
}
