//! What follows from the equations of an impacting system: rates, impact map, sticking field (MATH.md 1).

pub(super) mod identically_zero;
mod reset;
mod size;

use self::identically_zero::is_identically_zero;
use self::size::check_size;
use super::Model;
use crate::expressions::{Expr, Folding, Graph, Symbol};
use core::fmt;

/// The expressions derived from a [`Model`], in a graph that continues the model's own: handles of the model stay valid
/// in it.
#[derive(Clone, Debug)]
pub struct Mechanics {
    /// Holds every expression of the model and all derived ones.
    pub graph: Graph,
    /// The vector field f of free flight.
    pub field: Vec<Expr>,
    /// One for each contact of the model, in order.
    pub contacts: Vec<ContactMechanics>,
    parameters: usize,
    /// The field without what holds the state on the surfaces that it slides along: then not the field of flight.
    pub(crate) unheld: Vec<Expr>,
    /// What holds the state on surfaces.
    pub(crate) slides: Vec<Slide>,
    /// Contacts that stick, if they are closed.
    pub(crate) sticks: Vec<Stick>,
    /// Contacts with friction.
    pub(crate) rubs: Vec<Stick>,
}

/// What is derived for one contact with gap h, impulse direction W and restitution r.
#[derive(Clone, Debug)]
pub struct ContactMechanics {
    /// Name of the contact.
    pub name: String,
    /// h.
    pub gap: Expr,
    /// v = L_f h.
    pub rate: Expr,
    /// a = L_f v, in free flight.
    pub acceleration: Expr,
    /// j = L_f a, in free flight.
    pub jerk: Expr,
    /// b = L_W v: how much an impulse of one W changes the rate.
    pub rate_per_impulse: Expr,
    /// W / b: what changes the rate by one.
    pub jump: Vec<Expr>,
    /// r.
    pub restitution: Expr,
    /// The state after an impact in terms of the state before, x - (1 + r) v W / b: equation (M1).
    pub after_impact: Vec<Expr>,
    /// Whether the gap itself may be another after an impact, as where each one wears the stop.
    pub moves_gap: bool,
}

/// Motion in persistent contact: equation (M2) for any number of contacts.
#[derive(Clone, Debug, Default)]
pub struct Sticking {
    /// The vector field f - sum_j (W_j / b_j) lambda_j, along which the rates of all active contacts stay constant.
    pub field: Vec<Expr>,
    /// lambda = B^-1 a with B_ij = L_(W_j / b_j) v_i, one for each active contact in the order asked for: the rate of
    /// change of the gap rate that the contact force takes away. A contact holds while it is negative, and is released
    /// where it rises through zero. For a single contact it is the free acceleration a.
    pub reactions: Vec<Expr>,
    /// For each surface that is slid along the share of both fields: 1 is the one above alone, -1 the one below.
    pub(crate) shares: Vec<Expr>,
    /// The tangential impulse a time of each closed contact that sticks together with those beside it, in the order of
    /// [`Mechanics::sticks`].
    pub(crate) frictions: Vec<(usize, Expr)>,
}

/// Why a model has no impact map or no sticking field.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum MechanicsError {
    /// L_W v is zero everywhere: no impulse can turn the rate of this contact.
    ImpulseLeavesRate {
        /// Name of the contact.
        contact: String,
    },
    /// The contact forces are not determined: the matrix B of these contacts is singular everywhere.
    DependentContacts {
        /// Names of the contacts.
        contacts: Vec<String>,
    },
    /// Expressions are nested too deep to be compiled.
    TooDeep {
        /// How deep, definitions written out.
        depth: usize,
        /// How deep they may be.
        most: usize,
    },
    /// Products have too many factors that change with the state.
    TooManyFactors {
        /// How many operations their derivatives take: for each product the square of the number of such factors.
        operations: usize,
        /// How many they may take.
        most: usize,
    },
    /// Two surfaces change the field together other than one by one: what slides along both is not determined.
    MixedSurfaces {
        /// One, from 0.
        first: usize,
        /// The other.
        second: usize,
    },
    /// There is no contact of this number.
    UnknownContact {
        /// The number asked for, from 0.
        index: usize,
        /// How many contacts the model has.
        count: usize,
    },
}

impl fmt::Display for MechanicsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ImpulseLeavesRate { contact } => write!(
                f,
                "the impulse of contact `{contact}` does not change the rate of its gap, so no impact can happen there"
            ),
            Self::DependentContacts { contacts } => write!(
                f,
                "contacts {} cannot be closed at once: their impulses do not determine the contact forces",
                contacts.join(", ")
            ),
            Self::TooDeep { depth, most } => write!(
                f,
                "the model's expressions are nested {depth} deep, definitions written out: at most {most} is supported"
            ),
            Self::TooManyFactors { operations, most } => write!(
                f,
                "the model's products have so many factors that their derivatives take {operations} operations: at most \
                 {most} are supported, a product of {} factors",
                most.isqrt()
            ),
            Self::MixedSurfaces { first, second } => write!(
                f,
                "the field changes across surfaces {first} and {second} other than by one change after the other, so that \
                 what slides along both is not determined"
            ),
            Self::UnknownContact { index, count } => {
                write!(
                    f,
                    "there is no contact number {index}: the model has {count}, counted from 0"
                )
            }
        }
    }
}

impl core::error::Error for MechanicsError {}

impl Mechanics {
    /// Derives everything from the equations.
    ///
    /// # Errors
    /// [`MechanicsError::ImpulseLeavesRate`] where b = L_W v vanishes identically, and
    /// [`MechanicsError::TooDeep`] or [`MechanicsError::TooManyFactors`] for a model that is too large.
    pub fn new(model: &Model) -> Result<Self, MechanicsError> {
        let field = model.field();
        let contacts = model.contacts.iter().flat_map(|contact| {
            let impulse = contact.impulse.iter().copied();
            impulse.chain([contact.gap, contact.restitution])
        });
        let surfaces = model.sections.iter().map(|section| section.surface);
        let roots: Vec<Expr> = (field.iter().copied().chain(contacts).chain(surfaces)).collect();
        check_size(&model.graph, &roots)?;
        let mut mechanics = Self {
            graph: model.graph.clone(),
            unheld: field.clone(),
            slides: Vec::new(),
            sticks: Vec::new(),
            rubs: Vec::new(),
            field,
            contacts: Vec::with_capacity(model.contacts.len()),
            parameters: model.parameters.len(),
        };
        // The equations are evaluated as they were written; what follows from them need not repeat their gaps.
        mechanics.graph.set_folding(Folding::Continued);
        mechanics.derive_all(&model.contacts)?;
        Ok(mechanics)
    }

    fn derive_all(&mut self, contacts: &[super::Contact]) -> Result<(), MechanicsError> {
        for contact in contacts {
            let derived = self.derive(contact)?;
            self.contacts.push(derived);
        }
        Ok(())
    }

    fn derive(&mut self, contact: &super::Contact) -> Result<ContactMechanics, MechanicsError> {
        let rate = self.graph.lie_derivative(contact.gap, &self.field);
        let acceleration = self.graph.lie_derivative(rate, &self.field);
        let jerk = self.graph.lie_derivative(acceleration, &self.field);
        let rate_per_impulse = self.graph.lie_derivative(rate, &contact.impulse);
        if self.vanishes(rate_per_impulse) {
            let contact = contact.name.clone();
            return Err(MechanicsError::ImpulseLeavesRate { contact });
        }
        let graph = &mut self.graph;
        let jump: Vec<Expr> = (contact.impulse.iter())
            .map(|&w| graph.div(w, rate_per_impulse))
            .collect();
        // (1 + r) v as v + r v: where x itself is in v, the first cancels it, and nothing is lost in rounding.
        let after_impact = (jump.iter().enumerate())
            .map(|(index, &jump)| {
                let before = graph.state(index);
                let stop = graph.mul(rate, jump);
                let rebound = graph.mul(contact.restitution, stop);
                let (stop, rebound) = (graph.neg(stop), graph.neg(rebound));
                graph.sum(&[before, stop, rebound])
            })
            .collect();
        let after_impact: Vec<Expr> = contact.reset.clone().unwrap_or(after_impact);
        let gap_after = graph.substitute(contact.gap, &|symbol| match symbol {
            Symbol::State(index) => after_impact.get(index).copied(),
            Symbol::Parameter(_) => None,
        });
        let change = graph.sub(gap_after, contact.gap);
        // A state that is put where the gap is zero has no other.
        let moves_gap = !self.vanishes(change) && !self.vanishes(gap_after);
        Ok(ContactMechanics {
            name: contact.name.clone(),
            gap: contact.gap,
            rate,
            acceleration,
            jerk,
            rate_per_impulse,
            jump,
            restitution: contact.restitution,
            after_impact,
            moves_gap,
        })
    }

    /// The motion in which the contacts numbered `active` stay closed.
    ///
    /// B has a unit diagonal and is solved by elimination in the order given. Where mechanics holds (W proportional to
    /// the inverse mass matrix times the gradient of the gap) all its pivots are positive as long as the contacts are
    /// independent, so the formulas have no singularity of their own.
    ///
    /// # Errors
    /// [`MechanicsError::DependentContacts`] where B is singular identically, [`MechanicsError::UnknownContact`] for a
    /// number out of range.
    pub fn sticking(&mut self, active: &[usize]) -> Result<Sticking, MechanicsError> {
        let count = self.contacts.len();
        if let Some(&index) = active.iter().find(|&&index| index >= count) {
            return Err(MechanicsError::UnknownContact { index, count });
        }
        // What is held, and by what: rates by contact forces, sliding rates by friction, surfaces by the jump of the field.
        let sticks: Vec<Stick> = (self.sticks.iter())
            .filter(|stick| active.contains(&stick.contact))
            .cloned()
            .collect();
        let mut held: Vec<(Expr, Vec<Expr>)> = (active.iter())
            .map(|&i| (self.contacts[i].rate, self.contacts[i].jump.clone()))
            .collect();
        // Of contacts that stick by one rate in one direction, as the feet of a sled, the sum of their forces is determined.
        let leaders: Vec<usize> = (0..sticks.len())
            .map(|k| {
                (0..k)
                    .find(|&i| sticks[i].is_beside(&sticks[k]))
                    .unwrap_or(k)
            })
            .collect();
        let leading = || (0..sticks.len()).filter(|&k| leaders[k] == k);
        held.extend(leading().map(|k| (sticks[k].rate, sticks[k].along.clone())));
        let slides = self.slides.iter();
        held.extend(slides.map(|slide| (slide.held(), slide.jump.clone())));
        let mut rows: Vec<Vec<Expr>> = Vec::with_capacity(held.len());
        for (i, (function, _)) in held.iter().enumerate() {
            let mut row = Vec::with_capacity(held.len() + 1);
            for (j, (_, direction)) in held.iter().enumerate() {
                let is_own = i == j && i < active.len();
                row.push(if is_own {
                    self.graph.number(1.0)
                } else {
                    self.graph.lie_derivative(*function, direction)
                });
            }
            row.push(self.graph.lie_derivative(*function, &self.unheld));
            rows.push(row);
        }
        let Some(solution) = self.solve(rows) else {
            let contacts = active
                .iter()
                .map(|&i| self.contacts[i].name.clone())
                .collect();
            return Err(MechanicsError::DependentContacts { contacts });
        };
        let mut field = self.unheld.clone();
        for ((_, direction), &force) in held.iter().zip(&solution) {
            for (component, &part) in field.iter_mut().zip(direction) {
                let share = self.graph.mul(part, force);
                *component = self.graph.sub(*component, share);
            }
        }
        self.keep_exactly(&held, &mut field);
        let (reactions, rest) = solution.split_at(active.len());
        let (stuck, shares) = rest.split_at(leading().count());
        let place = |leader: usize| leading().position(|k| k == leader).unwrap_or(0);
        let frictions = (sticks.iter().zip(&leaders))
            .map(|(stick, &leader)| (stick.contact, self.graph.neg(stuck[place(leader)])))
            .collect();
        Ok(Sticking {
            field,
            reactions: reactions.to_vec(),
            shares: shares.iter().map(|&share| self.graph.neg(share)).collect(),
            frictions,
        })
    }

    /// B_ij: what a unit jump at contact `j` does to the rate of contact `i`.
    pub(crate) fn rate_per_jump(&mut self, i: usize, j: usize) -> Expr {
        if i == j {
            return self.graph.number(1.0);
        }
        let rate = self.contacts[i].rate;
        self.graph.lie_derivative(rate, &self.contacts[j].jump)
    }

    /// Solves the linear system of which each row holds the coefficients and the right side, by elimination with row
    /// exchanges where a pivot vanishes identically; `None` if it is singular.
    fn solve(&mut self, mut rows: Vec<Vec<Expr>>) -> Option<Vec<Expr>> {
        let size = rows.len();
        for column in 0..size {
            let pivot = (column..size).find(|&row| !self.vanishes(rows[row][column]))?;
            rows.swap(column, pivot);
            let (above, below) = rows.split_at_mut(column + 1);
            let pivot_row = &above[column][column..];
            for row in below {
                let factor = self.graph.div(row[column], pivot_row[0]);
                for (entry, &above) in row[column..].iter_mut().zip(pivot_row).skip(1) {
                    let product = self.graph.mul(factor, above);
                    *entry = self.graph.sub(*entry, product);
                }
            }
        }
        let mut solution = Vec::with_capacity(size);
        for (index, row) in rows.iter().enumerate().rev() {
            let mut rest = row[size];
            for (&coefficient, &known) in row[..size].iter().rev().zip(&solution) {
                let product = self.graph.mul(coefficient, known);
                rest = self.graph.sub(rest, product);
            }
            solution.push(self.graph.div(rest, row[index]));
        }
        solution.reverse();
        Some(solution)
    }

    fn vanishes(&self, expr: Expr) -> bool {
        is_identically_zero(&self.graph, expr, self.field.len(), self.parameters)
    }
}

mod kept;
mod sides;

use sides::Stick;
pub(crate) use sides::{OnSides, Rubbing, Slide};

#[cfg(test)]
mod tests;
