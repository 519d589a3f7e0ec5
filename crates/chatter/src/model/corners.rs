//! The corners of a model: every surface where an expression of it changes its form.

use super::{Model, Rubbing};
use crate::expressions::{Corners, Expr, Names};

impl Model {
    /// The corners of all expressions, and the surfaces among them that are rates of sliding in contacts.
    pub(crate) fn corners(&self) -> (Corners, Vec<Rubbing>) {
        let mut roots: Vec<Expr> = self.field();
        let mut rates = Vec::new();
        for (index, contact) in self.contacts.iter().enumerate() {
            roots.extend([contact.gap, contact.restitution]);
            roots.extend(&contact.impulse);
            roots.extend(contact.reset.iter().flatten());
            if let Some(friction) = &contact.friction {
                roots.extend([friction.coefficient, friction.rate]);
                roots.extend(&friction.along);
                rates.push((index, friction.rate));
            }
        }
        for section in &self.sections {
            roots.push(section.surface);
            roots.extend(section.reset.iter().flatten());
        }
        let mut corners = Corners::of(&self.graph, &roots, self.parameters.len());
        let rubbing = (rates.into_iter())
            .map(|(contact, rate)| Rubbing {
                contact,
                surface: corners.add(rate),
            })
            .collect();
        (corners, rubbing)
    }

    /// Names of the surfaces of [`corners`](Self::corners): their formulas.
    pub(super) fn surface_names(&self) -> Vec<String> {
        let (corners, _) = self.corners();
        (corners.surfaces.iter())
            .map(|&surface| self.formula(surface))
            .collect()
    }

    /// An expression as text, with the model's names.
    pub fn formula(&self, expr: Expr) -> String {
        let own = |names: Vec<&str>| names.into_iter().map(str::to_owned).collect::<Vec<_>>();
        let (states, parameters) = (own(self.state_names()), own(self.parameter_names()));
        let names = Names {
            states: &states,
            parameters: &parameters,
        };
        self.graph.to_text(expr, names)
    }
}
