//! How states stand to corners, which says what mode follows at one.

use super::guard::GuardKind;
use super::limits::{Corner, Limit};
use crate::expressions::{Expr, Graph, Tape};
use crate::flow::variation::Direction as Along;
use crate::model::ContactMechanics;

/// How a state stands to a corner in a mode.
#[derive(Clone, Debug)]
pub(crate) struct StandingTapes {
    pub corner: Corner,
    /// What is zero on a surface; then for each of the guards its value and its first derivatives in time; then the rate of the
    /// surface and what changes that, if it must be zero, too.
    pub values: Tape,
    pub guards: Vec<GuardKind>,
    /// The motion keeps to the surface but for rounding of numbers.
    pub is_kept: bool,
    /// The derivative of the surface along each column.
    pub slopes: Tape,
    /// By how much the surface rises where the rate of each contact is made larger by one.
    pub lifts: Tape,
    /// Of the squared length of a vector its components.
    pub components: Tape,
    /// And where it is kept at zero what is in place of its direction, and the rates of that; what each component of a direction changes
    /// its components by, row by row; and what it adds to the field.
    pub holding: Tape,
}

/// How many tapes that is.
pub(crate) const STANDING_TAPES: usize = 5;

impl StandingTapes {
    /// How a state stands to this corner in the mode with this field, of which so many components are the model's own.
    pub fn new(
        graph: &mut Graph,
        limit: &Limit,
        (field, coordinates): (&[Expr], usize),
        contacts: &[ContactMechanics],
        directions: &[Along],
    ) -> Self {
        let mut outputs = vec![limit.surface];
        for &(_, guard) in &limit.guards {
            let mut value = guard;
            for _ in 0..STANDING_ORDERS {
                outputs.push(value);
                value = if limit.is_kept {
                    graph.number(0.0)
                } else {
                    graph.lie_derivative(value, field)
                };
            }
        }
        outputs.extend(limit.rate.into_iter().flatten());
        let slopes: Vec<Expr> = (directions.iter())
            .flat_map(|along| along.along(graph, coordinates, &[limit.surface]))
            .collect();
        let lifts: Vec<Expr> = (contacts.iter())
            .map(|contact| graph.lie_derivative(limit.surface, &contact.jump))
            .collect();
        let components = (limit.vector.iter())
            .flat_map(|v| v.components.clone())
            .collect::<Vec<_>>();
        let mut holding = Vec::new();
        if let Some(vector) = &limit.vector {
            holding.extend(&vector.shares);
            for &share in &vector.shares {
                holding.push(graph.lie_derivative(share, field));
            }
            holding.extend(&vector.changes);
            holding.extend(vector.directions.iter().flatten());
        }
        let mut of = |values: &[Expr]| Tape::new(graph, field.len(), &[], values);
        Self {
            corner: limit.corner,
            values: of(&outputs),
            guards: limit.guards.iter().map(|&(kind, _)| kind).collect(),
            is_kept: limit.is_kept,
            slopes: of(&slopes),
            lifts: of(&lifts),
            components: of(&components),
            holding: of(&holding),
        }
    }

    pub fn all(&self) -> [&Tape; STANDING_TAPES] {
        [
            &self.values,
            &self.slopes,
            &self.lifts,
            &self.components,
            &self.holding,
        ]
    }
}

/// Values of a guard and its derivatives that decide which mode follows at a corner.
pub(crate) const STANDING_ORDERS: usize = 4;
