//! Impacting systems: states, parameters, contacts, sections, and the files that hold them.
//!
//! A [`Model`] is equations and nothing else. It comes from a file ([`Model::from_toml`]) or from a [`ModelBuilder`];
//! both write the same draft of named texts, which is resolved, parsed and checked in one place. [`Mechanics`] derives
//! from the equations what an impacting system needs: rate, acceleration, jerk, the impact map and the sticking field. [`check()`] shows them as formulas and warns
//! of what looks wrong.

mod assemble;
mod builder;
mod check;
mod direction;
mod drawing;
mod error;
mod exponents;
mod mechanics;
#[expect(
    clippy::module_inception,
    reason = "the floor is named after what it holds"
)]
mod model;
mod names;
mod phase;
mod simultaneous;
mod source;

pub use builder::{ModelBuilder, Value};
pub use check::corners::CornerKind;
pub use check::warning::Warning;
pub use check::{Check, ContactFormulas, NamedFormula, check};
pub use direction::Direction;
pub use drawing::{Shape, ShapeKind};
pub use error::diagnostic::Palette;
pub use error::visible::visible;
pub use error::{ModelError, ModelErrorKind, ModelErrors, Role};
pub use mechanics::{ContactMechanics, Mechanics, MechanicsError, Sticking};
pub(crate) use mechanics::{OnSides, Rubbing, Slide};
pub use model::{Contact, Definition, Friction, Label, Model, Parameter, Section, State};
pub use phase::Phase;
pub(crate) use phase::greatest_common_divisor;
pub use simultaneous::Simultaneous;
pub use source::data_file::{DataFileError, Loader};
pub use source::tabulated::Table;
