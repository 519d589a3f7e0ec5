//! A model as its author wrote it: named texts and where they stand. Files and the builder both make one, and
//! [`assemble`](crate::model::assemble) turns it into a [`Model`](crate::model::Model).

use crate::expressions::{CurveKind, Outside};
use crate::model::direction::Direction;
use crate::model::drawing::ShapeKind;
use crate::model::model::Label;
use crate::model::simultaneous::Simultaneous;
use crate::numerics::{DoubleDouble, Real as _};
use core::ops::Range;
use std::sync::Arc;

/// A text that errors point into.
#[derive(Debug, PartialEq, Eq)]
pub(in crate::model) struct SourceText {
    /// Name of the file, or what the text is for.
    pub name: String,
    /// Empty where there is no text to show.
    pub text: String,
}

/// A stretch of a text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::model) struct Place {
    pub source: Arc<SourceText>,
    pub span: Range<usize>,
    /// Where the content of the string starts, if it stands in the source letter by letter (no escapes).
    pub verbatim: Option<usize>,
}

impl Place {
    /// Whether another is a part of it.
    pub fn holds(&self, other: &Self) -> bool {
        let (outer, inner) = (&self.span, &other.span);
        self.source == other.source && outer.start <= inner.start && inner.end <= outer.end
    }

    /// A place without text, known by name only.
    pub fn named(name: &str) -> Self {
        Self::whole(name, "")
    }

    /// All of a text of its own.
    pub fn whole(name: &str, text: &str) -> Self {
        let (name, text) = (name.to_owned(), text.to_owned());
        let span = 0..text.len();
        let verbatim = Some(0);
        Self {
            source: Arc::new(SourceText { name, text }),
            span,
            verbatim,
        }
    }

    /// The part `within` of the string that stands here, or all of it where it cannot be told.
    pub fn inside(&self, within: Range<usize>) -> Self {
        let Some(start) = self.verbatim else {
            return self.clone();
        };
        let span = start + within.start..start + within.end;
        Self {
            span,
            ..self.clone()
        }
    }
}

/// A name and where it stands.
#[derive(Clone, Debug)]
pub(in crate::model) struct Name {
    pub text: String,
    pub place: Place,
}

/// Something that should be an expression.
#[derive(Clone, Debug)]
pub(in crate::model) struct Formula {
    pub content: Content,
    pub place: Place,
}

impl Formula {
    /// Zero, where nothing is written.
    pub fn zero(place: &Place) -> Self {
        Self {
            content: Content::Number(DoubleDouble::ZERO),
            place: place.clone(),
        }
    }
}

#[derive(Clone, Debug)]
pub(in crate::model) enum Content {
    Number(DoubleDouble),
    Text(String),
    /// Not an expression, which has been reported.
    Broken,
}

/// `name = formula`.
#[derive(Clone, Debug)]
pub(in crate::model) struct Entry {
    pub name: Name,
    pub formula: Formula,
}

#[derive(Clone, Debug)]
pub(in crate::model) struct ContactDraft {
    pub name: Option<Name>,
    pub place: Place,
    pub gap: Option<Formula>,
    pub impulse: Option<ImpulseDraft>,
    pub restitution: Option<Formula>,
    /// In place of impulse and restitution.
    pub reset: Option<ImpulseDraft>,
    pub friction: Option<FrictionDraft>,
}

#[derive(Clone, Debug)]
pub(in crate::model) struct FrictionDraft {
    pub place: Place,
    pub coefficient: Option<Formula>,
    pub along: Option<ImpulseDraft>,
    pub rate: Option<Formula>,
}

#[derive(Clone, Debug)]
pub(in crate::model) struct ImpulseDraft {
    pub place: Place,
    /// `None` where the table could not be read, which has been reported.
    pub components: Option<Vec<Entry>>,
}

#[derive(Clone, Debug)]
pub(in crate::model) struct SectionDraft {
    pub name: Name,
    pub surface: Option<Formula>,
    pub direction: Direction,
    /// Of an event: how it changes the state.
    pub reset: Option<ImpulseDraft>,
    /// Whether it is an event.
    pub is_event: bool,
}

#[derive(Clone, Debug)]
pub(in crate::model) struct LabelDraft {
    pub name: Name,
    pub label: Label,
}

/// Numbers, and where each of them stands.
#[derive(Clone, Debug)]
pub(in crate::model) struct Column {
    /// Stands for all of them.
    pub place: Place,
    pub numbers: Vec<DoubleDouble>,
    /// The text that they stand in, and where.
    pub source: Arc<SourceText>,
    pub spans: Vec<Range<usize>>,
}

impl Column {
    /// Where number `index` stands.
    pub fn place_of(&self, index: usize) -> Place {
        match self.spans.get(index) {
            Some(span) => Place {
                source: Arc::clone(&self.source),
                span: span.clone(),
                verbatim: None,
            },
            None => self.place.clone(),
        }
    }
}

#[derive(Clone, Debug)]
pub(in crate::model) struct KnotsDraft {
    pub kind: CurveKind,
    pub outside: Option<(Outside, Place)>,
    pub x: Column,
    pub y: Column,
    pub slopes: Option<Column>,
}

#[derive(Clone, Debug)]
pub(in crate::model) struct TableDraft {
    pub name: Name,
    /// `None` where they could not be read, which has been reported.
    pub knots: Option<KnotsDraft>,
}

/// A part of a drawing.
#[derive(Clone, Debug)]
pub(in crate::model) struct ShapeDraft {
    pub kind: ShapeKind,
    pub numbers: Vec<Formula>,
}

/// Everything an author wrote, unresolved.
#[derive(Clone, Debug)]
pub(in crate::model) struct Draft {
    /// Stands for the model as a whole in errors.
    pub place: Place,
    pub title: Option<String>,
    pub source: Option<String>,
    pub simultaneous: Simultaneous,
    pub parameters: Vec<Entry>,
    /// `None` where there is no such table; entries `None` where it is no table, which has been reported.
    pub flight: Option<(Place, Option<Vec<Entry>>)>,
    pub contacts: Vec<ContactDraft>,
    pub sections: Vec<SectionDraft>,
    pub initial: Vec<Entry>,
    pub definitions: Vec<Entry>,
    pub tables: Vec<TableDraft>,
    pub labels: Vec<LabelDraft>,
    pub drawing: Vec<ShapeDraft>,
}

impl Draft {
    pub fn new(place: Place) -> Self {
        Self {
            place,
            title: None,
            source: None,
            simultaneous: Simultaneous::default(),
            parameters: Vec::new(),
            flight: None,
            contacts: Vec::new(),
            sections: Vec::new(),
            initial: Vec::new(),
            definitions: Vec::new(),
            tables: Vec::new(),
            labels: Vec::new(),
            drawing: Vec::new(),
        }
    }
}
