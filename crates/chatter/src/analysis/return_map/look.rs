//! Where a flow is looked at, found in the model.

use super::spec::{ReturnMapError, Sampling};
use crate::analysis::simulate::EventKind;
use crate::expressions::Formula;
use crate::model::{Model, Section};
use crate::numerics::DoubleDouble;

/// Where the flow is looked at. Places are indices; the only section that the system has left is number 0.
#[derive(Clone, Debug)]
pub(super) enum Look {
    Event {
        kind: EventKind,
        at: Option<usize>,
        /// The surface of a section.
        surface: Option<Formula<f64>>,
    },
    Stroboscopic {
        /// In double-double: rounding it would count as often as there are periods.
        period: Formula<DoubleDouble>,
    },
}

impl Look {
    /// Finds out what is meant. Leaves the model the sections that are looked at: others would only cost time.
    pub(super) fn new(sampling: &Sampling, model: &mut Model) -> Result<Self, ReturnMapError> {
        Ok(match sampling {
            Sampling::Event { kind, at } => {
                let place = |name: &str| {
                    let place = kind.place(model, name);
                    place.map_err(ReturnMapError::UnknownPlace)
                };
                let at = at.as_deref().map(place).transpose()?;
                let changes_nothing = |section: &Section| section.reset.is_none();
                if *kind == EventKind::Section && !model.sections.iter().any(changes_nothing) {
                    // Whatever it is called.
                    place("")?;
                }
                let mut sections = core::mem::take(&mut model.sections);
                let is_event = |section: &Section| section.reset.is_some();
                match (kind, at) {
                    (
                        EventKind::Switch | EventKind::Slide | EventKind::Leave | EventKind::Reset,
                        at,
                    ) => {
                        // Their numbers count all surfaces, and all sections.
                        model.sections = sections;
                        Look::Event {
                            kind: *kind,
                            at,
                            surface: None,
                        }
                    }
                    (EventKind::Section, Some(index)) => {
                        let section = sections.swap_remove(index);
                        let surface = Formula::new(&model.graph, section.surface);
                        sections.retain(is_event);
                        model.sections = vec![section];
                        model.sections.append(&mut sections);
                        Look::Event {
                            kind: *kind,
                            at: Some(0),
                            surface: Some(surface),
                        }
                    }
                    (EventKind::Section, None) => {
                        model.sections = sections;
                        Look::Event {
                            kind: *kind,
                            at: None,
                            surface: None,
                        }
                    }
                    (_, at) => {
                        sections.retain(is_event);
                        model.sections = sections;
                        Look::Event {
                            kind: *kind,
                            at,
                            surface: None,
                        }
                    }
                }
            }
            Sampling::Stroboscopic { period } => {
                model.sections.retain(|section| section.reset.is_some());
                let text = period.clone();
                let expr = model
                    .parse_expression(period)
                    .map_err(|error| ReturnMapError::Period { text, error })?;
                let formula = Formula::<DoubleDouble>::new(&model.graph, expr);
                let parameters = model.parameter_values(&[]);
                let value = formula.evaluate(&[], &parameters, &mut Vec::new()).high();
                if !(value > 0.0 && value.is_finite()) {
                    return Err(ReturnMapError::PeriodValue {
                        text: period.clone(),
                        value,
                    });
                }
                Look::Stroboscopic { period: formula }
            }
        })
    }

    /// Whether this is what is looked at.
    #[inline]
    pub(super) fn sees(&self, what: EventKind, place: usize) -> bool {
        match self {
            Self::Event { kind, at, .. } => *kind == what && at.is_none_or(|at| at == place),
            Self::Stroboscopic { .. } => false,
        }
    }

    /// Whether anything of this kind is looked at.
    pub(super) fn looks_at(&self, what: EventKind) -> bool {
        matches!(self, Self::Event { kind, .. } if *kind == what)
    }

    /// The surface function of a section.
    pub(super) fn section(&self) -> Option<&Formula<f64>> {
        match self {
            Self::Event { surface, .. } => surface.as_ref(),
            Self::Stroboscopic { .. } => None,
        }
    }
}
