//! The corners of a model: every surface where an expression of it changes its form.

use crate::expressions::{Corners, Expr, Folding, Graph, LOOKUP_SLOTS, Names, Side, Sides, Symbol};
use crate::model::mechanics::identically_zero::{generic, is_identically_zero};
use crate::model::{Model, Rubbing};

impl Model {
    /// The corners of all expressions, and the surfaces among them that are rates of sliding in contacts.
    pub(crate) fn corners(&self) -> (Corners, Vec<Rubbing>) {
        let mut corners = Corners::of(&self.graph, &self.expressions(), self.parameters.len());
        let rubbing = (self.contacts.iter().enumerate())
            .filter_map(|(contact, of)| Some((contact, of.friction.as_ref()?.rate)))
            .map(|(contact, rate)| Rubbing {
                contact,
                surface: corners.add(rate),
            })
            .collect();
        for square in self.discs() {
            corners.add_disc(square);
        }
        (corners, rubbing)
    }

    /// Of the vectors whose directions the field asks for the squared lengths of those that it changes by them: what dry friction in the
    /// plane brings to rest. Nothing rests where a central force, say, only turns round.
    fn discs(&self) -> Vec<Expr> {
        let field = self.field();
        let squares = self.graph.squares_of_directions(&field);
        if squares.is_empty() {
            return squares;
        }
        let mut graph = self.graph.clone();
        graph.set_folding(Folding::Continued);
        let size = (self.states.len(), self.parameters.len());
        let changes = |graph: &mut Graph, square: Expr| -> Option<bool> {
            let disc = graph.disc_of(square)?;
            let columns = disc.columns(graph, &field)?;
            let vanishes = |graph: &mut Graph, (place, component): (usize, Expr)| {
                let change = graph.lie_derivative(component, &columns[place]);
                is_identically_zero(graph, change, size.0, size.1)
            };
            let mut components = disc.components(graph).into_iter().enumerate();
            Some(!components.any(|component| vanishes(graph, component)))
        };
        (squares.into_iter())
            .filter(|&square| changes(&mut graph, square) == Some(true))
            .collect()
    }

    /// Every expression that a trajectory is made by, as it stands in the model; [`equations`](Self::equations) leaves out what moves nothing.
    pub(in crate::model) fn expressions(&self) -> Vec<Expr> {
        let mut all: Vec<Expr> = self.field();
        for contact in &self.contacts {
            all.extend([contact.gap, contact.restitution]);
            all.extend(&contact.impulse);
            all.extend(contact.reset.iter().flatten());
            if let Some(friction) = &contact.friction {
                all.extend([friction.coefficient, friction.rate]);
                all.extend(&friction.along);
            }
        }
        for section in &self.sections {
            all.push(section.surface);
            all.extend(section.reset.iter().flatten());
        }
        all
    }

    /// Names of the surfaces of [`corners`](Self::corners): their formulas.
    pub(in crate::model) fn surface_names(&self) -> Vec<String> {
        let (corners, _) = self.corners();
        (corners.surfaces.iter())
            .map(|&surface| self.formula(surface))
            .collect()
    }

    /// What must not be negative for the equations of motion to have a value: what roots, and powers that are no whole ones, are taken of in
    /// the field and in gaps, as far as the form does not say that it is not.
    pub fn radicands(&self) -> Vec<Expr> {
        let mut all = self.field();
        all.extend(self.contacts.iter().map(|contact| contact.gap));
        self.graph.radicands(&all)
    }

    /// The text of one of those, empty if there are fewer.
    pub fn radicand(&self, index: usize) -> String {
        let of = self.radicands().get(index).copied();
        of.map_or_else(String::new, |of| self.formula(of))
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

/// A surface where expressions change their form, and what that does.
#[derive(Clone, Debug, PartialEq)]
pub struct CornerKind {
    /// The formula that vanishes there.
    pub surface: String,
    /// Whether the vector field jumps.
    pub jumps: bool,
    /// Whether the fields on both sides can point towards it, so that the motion slides along.
    pub can_slide: bool,
    /// The contact whose rate of sliding it is.
    pub contact: Option<usize>,
}

/// Points of a surface that are looked at, and steps of Newton's method onto it.
const PROBES: usize = 64;
const NEWTON_STEPS: usize = 40;

/// A point is on a surface whose function is less than this part of the terms that it is the sum of.
const ON_SURFACE: f64 = 1e-9;

/// A field jumps by more than this part of its size.
const JUMP: f64 = 1e-9;

impl Model {
    /// What the field does at each corner, found at points of it at the model's parameter values: the field above and below,
    /// all else being equal.
    pub fn corner_kinds(&self) -> Vec<CornerKind> {
        let (corners, rubbing) = self.corners();
        if corners.surfaces.len() > Sides::MOST {
            // There are no trajectories, and no sides to ask for.
            return Vec::new();
        }
        let parameters = self.parameter_values::<f64>(&[]);
        let start = self.initial_state(&parameters);
        (0..corners.surfaces.len())
            .map(|index| {
                let contact = rubbing
                    .iter()
                    .find(|r| r.surface == index)
                    .map(|r| r.contact);
                let mut kind = CornerKind {
                    surface: self.surfaces[index].clone(),
                    jumps: contact.is_some(),
                    can_slide: contact.is_some(),
                    contact,
                };
                if corners.is_disc(index) {
                    (kind.jumps, kind.can_slide) = (true, true);
                } else if contact.is_none() {
                    self.probe(&corners, index, (&start, &parameters), &mut kind);
                }
                kind
            })
            .collect()
    }

    fn probe(
        &self,
        corners: &Corners,
        index: usize,
        (start, parameters): (&[f64], &[f64]),
        kind: &mut CornerKind,
    ) {
        let n = self.states.len();
        let mut graph = self.graph.clone();
        let surface = corners.surfaces[index];
        let slopes: Vec<Expr> = (0..n)
            .map(|i| graph.derivative(surface, Symbol::State(i)))
            .collect();
        for probe in 0..PROBES {
            let spread = |i: usize| 2.0 * generic(probe * n + i) - 2.0;
            let mut x: Vec<f64> = (0..n)
                .map(|i| start[i] + spread(i) * (1.0 + start[i].abs()))
                .collect();
            for _ in 0..NEWTON_STEPS {
                let value = graph.evaluate(surface, &x, parameters);
                let slope = graph.evaluate_all(&slopes, &x, parameters);
                let square: f64 = slope.iter().map(|s| s * s).sum();
                if value == 0.0 || square <= 0.0 || !square.is_finite() {
                    break;
                }
                for (x, s) in x.iter_mut().zip(&slope) {
                    *x -= value * s / square;
                }
            }
            let slope = graph.evaluate_all(&slopes, &x, parameters);
            // On a side of another corner the function may vanish nowhere.
            let terms: f64 = (x.iter().zip(&slope))
                .map(|(x, s)| (1.0 + x.abs()) * s.abs())
                .sum();
            if graph.evaluate(surface, &x, parameters).abs() > ON_SURFACE * terms {
                continue;
            }
            let (sides, pieces) = corners.at(&graph, &x, parameters);
            let mut values = parameters.to_vec();
            for (lookup, &piece) in pieces.iter().enumerate() {
                let slots = corners.slots_of::<f64>(&graph, lookup, piece);
                values.extend(slots.unwrap_or_else(|| vec![f64::NAN; LOOKUP_SLOTS]));
            }
            let mut field = |side: Side| {
                let smooth = corners.smooth(&mut graph, sides.with(index, side), &self.field());
                graph.evaluate_all(&smooth.exprs, &x, &values)
            };
            let (above, below) = (field(Side::Above), field(Side::Below));
            let along = |field: &[f64]| field.iter().zip(&slope).map(|(f, s)| f * s).sum::<f64>();
            let size = above
                .iter()
                .chain(&below)
                .fold(0.0_f64, |most, f| most.max(f.abs()));
            if !size.is_finite() || !slope.iter().all(|s| s.is_finite()) {
                continue;
            }
            let jumps = (above.iter().zip(&below)).any(|(a, b)| (a - b).abs() > JUMP * size);
            kind.jumps |= jumps;
            let (up, down) = (along(&above), along(&below));
            kind.can_slide |= jumps && up < down - JUMP * (up.abs() + down.abs());
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::model::Model;

    /// The saturated force jumps nowhere: where the upper bound is asked below the lower one, its function is no zero.
    #[test]
    fn a_surface_is_asked_where_it_is_one() {
        for force in [
            "min(max(4*v, -1), 1)",
            "max(min(4*v, 1), -1)",
            "clamp(4*v, -1, 1)",
        ] {
            let text =
                format!("[flight]\nx = \"v\"\nv = \"-x - {force}\"\n[initial]\nx = 1\nv = 0\n");
            let model = Model::from_toml(&text, "model.toml").unwrap();
            let kinds = model.corner_kinds();
            assert_eq!(kinds.len(), 2, "{kinds:?}");
            assert!(
                kinds.iter().all(|kind| !kind.jumps && !kind.can_slide),
                "{kinds:?}"
            );
        }
    }
}
