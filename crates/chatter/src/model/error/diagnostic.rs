//! How errors look: the line, the characters underlined, what was expected, what may have been meant.

use super::visible::visible;
use crate::model::{ModelError, ModelErrors};
use annotate_snippets::{AnnotationKind, Group, Level, Origin, Renderer, Snippet};
use core::fmt;

/// Colours of rendered errors.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum Palette {
    /// None: for files and pipes.
    #[default]
    Plain,
    /// ANSI escape sequences: for terminals.
    Ansi,
}

/// Longest line of a message before it is cut around the underlined part.
const WIDTH: usize = 120;

impl ModelError {
    /// The whole message, without a final line break.
    pub fn render(&self, palette: Palette) -> String {
        let renderer = match palette {
            Palette::Plain => Renderer::plain(),
            Palette::Ansi => Renderer::styled(),
        };
        let mut group = Group::with_title(Level::ERROR.primary_title(self.kind.to_string()));
        let source = &self.place.source;
        if source.text.is_empty() {
            group = group.element(Origin::path(shown(&source.name)));
        } else {
            let mut primary = AnnotationKind::Primary.span(self.place.span.clone());
            if let Some(label) = self.kind.label() {
                primary = primary.label(label);
            }
            let mut snippet = Snippet::source(&*source.text)
                .path(shown(&source.name))
                .annotation(primary);
            let mut elsewhere = None;
            if let Some((place, label)) = self.related.as_deref() {
                let annotation = AnnotationKind::Context
                    .span(place.span.clone())
                    .label(&**label);
                if place.source == *source {
                    snippet = snippet.annotation(annotation);
                } else if !place.source.text.is_empty() {
                    let other =
                        Snippet::source(&*place.source.text).path(shown(&place.source.name));
                    elsewhere = Some(other.annotation(annotation));
                }
            }
            group = group.element(snippet).elements(elsewhere);
        }
        let help = self.kind.help();
        group = group.elements(help.map(|help| Level::HELP.message(shown(&help))));
        renderer.term_width(WIDTH).render(&[group])
    }
}

/// Names and help, which the renderer takes as they are; titles and sources it makes visible itself.
fn shown(text: &str) -> String {
    text.chars().map(visible).collect()
}

impl fmt::Display for ModelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.render(Palette::Plain))
    }
}

impl ModelErrors {
    /// All messages, an empty line between them.
    pub fn render(&self, palette: Palette) -> String {
        let messages: Vec<String> = self
            .errors()
            .iter()
            .map(|error| error.render(palette))
            .collect();
        messages.join("\n\n")
    }
}

impl fmt::Display for ModelErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.render(Palette::Plain))
    }
}
