//! Which names an expression may use, and what it means to use another.

use crate::expressions::{Expr, Graph, ParseErrorKind};
use crate::model::error::{ModelError, ModelErrorKind, Role};
use crate::model::source::draft::{Content, Formula};
use crate::numerics::Scalar;
use core::cell::OnceCell;
use std::collections::HashMap;

/// What an expression is for, where that restricts what it may depend on.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(in crate::model) enum Purpose {
    /// Any quantity may appear.
    Equation,
    /// Only other parameters.
    Parameter,
    /// Only what does not change in time.
    Initial,
}

/// The names an expression may use.
pub(in crate::model) struct Scope<'a> {
    purpose: Purpose,
    known: HashMap<&'a str, Expr>,
    /// Names of the model that are of no use for this purpose.
    barred: HashMap<&'a str, Role>,
    /// The names in order, once they have been asked for: there may be as many formulas as names.
    sorted: OnceCell<Vec<&'a str>>,
}

impl<'a> Scope<'a> {
    pub fn new(purpose: Purpose) -> Self {
        Self {
            purpose,
            known: HashMap::new(),
            barred: HashMap::new(),
            sorted: OnceCell::new(),
        }
    }

    /// Lets `name` stand for `expr`, unless it stands for something already.
    pub fn allow(&mut self, name: &'a str, expr: Expr) {
        self.known.entry(name).or_insert(expr);
        self.sorted.take();
    }

    /// Remembers that `name` exists but must not be used.
    pub fn bar(&mut self, name: &'a str, role: Role) {
        self.barred.entry(name).or_insert(role);
    }

    /// Reads a formula; `None` where something is wrong with it that has been reported.
    pub fn read(&self, graph: &mut Graph, formula: &Formula) -> Result<Option<Expr>, ModelError> {
        let text = match &formula.content {
            Content::Number(value) if value.is_finite() => {
                return Ok(Some(graph.number_exact(*value)));
            }
            Content::Number(value) => {
                let (what, value) = ("the number".to_owned(), value.high());
                let kind = ModelErrorKind::NotFinite { what, value };
                return Err(ModelError::new(kind, &formula.place));
            }
            Content::Broken => return Ok(None),
            Content::Text(text) => text,
        };
        let known = self.sorted.get_or_init(|| {
            let mut known: Vec<&str> = self.known.keys().copied().collect();
            known.sort_unstable();
            known
        });
        let resolve = |name: &str| self.known.get(name).copied();
        graph
            .parse(text, &resolve, known)
            .map(Some)
            .map_err(|error| {
                let place = formula.place.inside(error.span.clone());
                let barred = match &error.kind {
                    ParseErrorKind::UnknownName(name) => self.barred.get_key_value(&**name),
                    _ => None,
                };
                let kind = match (barred, self.purpose) {
                    (Some((&on, &role)), Purpose::Parameter) => {
                        let on = on.to_owned();
                        ModelErrorKind::ParameterNotConstant { on, role }
                    }
                    (Some((&on, &role)), Purpose::Initial) => {
                        let on = on.to_owned();
                        ModelErrorKind::InitialNotConstant { on, role }
                    }
                    _ => {
                        let known = known.iter().map(|&name| name.to_owned()).collect();
                        ModelErrorKind::Expression { error, known }
                    }
                };
                ModelError::new(kind, &place)
            })
    }
}
