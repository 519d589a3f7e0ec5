//! Models from Rust code, by the same rules as files.

use super::error::ModelErrors;
use super::model::Label;
use super::source::draft::{
    ContactDraft, Content, Draft, Entry, Formula, FrictionDraft, ImpulseDraft, LabelDraft, Name,
    Place, SectionDraft, TableDraft,
};
use super::{Direction, Model, Simultaneous, Table};
use crate::numerics::DoubleDouble;

/// Something that stands for an expression in a [`ModelBuilder`].
#[derive(Clone, PartialEq, Debug)]
pub enum Value {
    /// A number, meant as its shortest decimal digits say: `0.1` is a tenth, to all digits of whatever number type
    /// computes with it.
    Number(f64),
    /// An expression, as in a model file.
    Text(String),
}

impl From<f64> for Value {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl From<i32> for Value {
    fn from(number: i32) -> Self {
        Self::Number(f64::from(number))
    }
}

impl From<&str> for Value {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Value {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

/// Builds a [`Model`] step by step. Nothing is checked before [`build`](Self::build), so names may be used before they
/// are given.
///
/// ```
/// use chatter::model::{Direction, ModelBuilder};
///
/// let ball = ModelBuilder::new()
///     .title("Bouncing ball")
///     .parameter("g", 9.81)
///     .parameter("r", 0.5)
///     .state("y", "v", 1.0)
///     .state("v", "-g", 0.0)
///     .contact("floor", "y", [("v", 1.0)], "r")
///     .section("apex", "v", Direction::Falling)
///     .build()?;
/// assert_eq!(ball.state_names(), ["y", "v"]);
/// # Ok::<(), chatter::model::ModelErrors>(())
/// ```
#[derive(Clone, Debug)]
pub struct ModelBuilder {
    draft: Draft,
    flight: Vec<Entry>,
}

impl Default for ModelBuilder {
    fn default() -> Self {
        Self {
            draft: Draft::new(Place::named("model")),
            flight: Vec::new(),
        }
    }
}

impl ModelBuilder {
    /// A model with nothing in it.
    pub fn new() -> Self {
        Self::default()
    }

    /// What the model is called, in words.
    pub fn title(mut self, title: &str) -> Self {
        self.draft.title = Some(title.to_owned());
        self
    }

    /// Where it was published.
    pub fn source(mut self, source: &str) -> Self {
        self.draft.source = Some(source.to_owned());
        self
    }

    /// What happens where several contacts touch at one instant.
    pub fn simultaneous(mut self, law: Simultaneous) -> Self {
        self.draft.simultaneous = law;
        self
    }

    /// A parameter: a number, or an expression in other parameters.
    pub fn parameter(mut self, name: &str, value: impl Into<Value>) -> Self {
        self.draft
            .parameters
            .push(entry("parameters", name, value.into()));
        self
    }

    /// A named expression.
    pub fn definition(mut self, name: &str, value: impl Into<Value>) -> Self {
        self.draft
            .definitions
            .push(entry("definitions", name, value.into()));
        self
    }

    /// A function of one argument from points, called in expressions by its name.
    pub fn table(mut self, name: &str, table: Table) -> Self {
        self.draft.tables.push(TableDraft {
            name: named("table", name),
            knots: Some(table.draft(name)),
        });
        self
    }

    /// A state, its derivative in free flight, and its initial value.
    pub fn state(
        mut self,
        name: &str,
        derivative: impl Into<Value>,
        initial: impl Into<Value>,
    ) -> Self {
        self.flight.push(entry("flight", name, derivative.into()));
        self.draft
            .initial
            .push(entry("initial", name, initial.into()));
        self
    }

    /// The initial value of time `t`, zero unless given.
    pub fn initial_time(mut self, initial: impl Into<Value>) -> Self {
        self.draft
            .initial
            .push(entry("initial", super::names::TIME, initial.into()));
        self
    }

    /// A contact: its gap, the components of its impulse direction by state, and its restitution.
    pub fn contact<S: AsRef<str>, V: Into<Value>>(
        mut self,
        name: &str,
        gap: impl Into<Value>,
        impulse: impl IntoIterator<Item = (S, V)>,
        restitution: impl Into<Value>,
    ) -> Self {
        let table = format!("contact.{name}");
        let of = |key: &str| format!("{table}.{key}");
        let component =
            |(state, value): (S, V)| entry(&of("impulse"), state.as_ref(), value.into());
        self.draft.contacts.push(ContactDraft {
            name: Some(named("contact", name)),
            place: Place::named(&table),
            gap: Some(formula(&of("gap"), gap.into())),
            impulse: Some(ImpulseDraft {
                place: Place::named(&of("impulse")),
                components: Some(impulse.into_iter().map(component).collect()),
            }),
            restitution: Some(formula(&of("restitution"), restitution.into())),
            reset: None,
            friction: None,
        });
        self
    }

    /// A named surface: where an expression crosses zero.
    pub fn section(mut self, name: &str, surface: impl Into<Value>, direction: Direction) -> Self {
        self.draft.sections.push(SectionDraft {
            name: named("section", name),
            surface: Some(formula(&format!("section.{name}.surface"), surface.into())),
            direction,
            reset: None,
            is_event: false,
        });
        self
    }

    /// An event: where an expression crosses zero the named states take new values.
    pub fn event<S: AsRef<str>, V: Into<Value>>(
        mut self,
        name: &str,
        surface: impl Into<Value>,
        direction: Direction,
        reset: impl IntoIterator<Item = (S, V)>,
    ) -> Self {
        let table = format!("event.{name}");
        let component =
            |(state, value): (S, V)| entry(&format!("{table}.reset"), state.as_ref(), value.into());
        self.draft.sections.push(SectionDraft {
            name: named("event", name),
            surface: Some(formula(&format!("{table}.surface"), surface.into())),
            direction,
            reset: Some(ImpulseDraft {
                place: Place::named(&format!("{table}.reset")),
                components: Some(reset.into_iter().map(component).collect()),
            }),
            is_event: true,
        });
        self
    }

    /// Dry friction in the contact that was added last: its coefficient, the tangential direction by state, and the rate of
    /// sliding.
    pub fn friction<S: AsRef<str>, V: Into<Value>>(
        mut self,
        coefficient: impl Into<Value>,
        along: impl IntoIterator<Item = (S, V)>,
        rate: impl Into<Value>,
    ) -> Self {
        let component =
            |(state, value): (S, V)| entry("friction.along", state.as_ref(), value.into());
        let friction = FrictionDraft {
            place: Place::named("friction"),
            coefficient: Some(formula("friction.coefficient", coefficient.into())),
            along: Some(ImpulseDraft {
                place: Place::named("friction.along"),
                components: Some(along.into_iter().map(component).collect()),
            }),
            rate: Some(formula("friction.rate", rate.into())),
        };
        if let Some(contact) = self.draft.contacts.last_mut() {
            contact.friction = Some(friction);
        }
        self
    }

    /// How plots call a state or a parameter.
    pub fn label(mut self, name: &str, label: Label) -> Self {
        let name = named("labels", name);
        self.draft.labels.push(LabelDraft { name, label });
        self
    }

    /// The model.
    ///
    /// # Errors
    /// All that is wrong with it. Errors call an expression by where it would stand in a file, such as `flight.y`.
    pub fn build(mut self) -> Result<Model, ModelErrors> {
        let place = Place::named("flight");
        self.draft.flight = (!self.flight.is_empty()).then_some((place, Some(self.flight)));
        self.draft.assemble(Vec::new()).map_err(ModelErrors::new)
    }
}

fn named(table: &str, name: &str) -> Name {
    Name {
        text: name.to_owned(),
        place: Place::whole(table, name),
    }
}

fn entry(table: &str, name: &str, value: Value) -> Entry {
    Entry {
        name: named(table, name),
        formula: formula(&format!("{table}.{name}"), value),
    }
}

fn formula(name: &str, value: Value) -> Formula {
    match value {
        Value::Number(number) => {
            let digits = number.to_string();
            let exact = digits.parse().unwrap_or(DoubleDouble::from(number));
            Formula {
                content: Content::Number(exact),
                place: Place::whole(name, &digits),
            }
        }
        Value::Text(text) => Formula {
            place: Place::whole(name, &text),
            content: Content::Text(text),
        },
    }
}
