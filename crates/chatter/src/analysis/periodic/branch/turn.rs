//! Grazes where the flow turns with the side of a surface: drag and friction change with the sign of the very rate that vanishes. The
//! impact at which that rate turns comes in where it passed zero by itself, and leaves the surface crossed where it goes out.

use super::events::unfollowed;
use crate::analysis::periodic::cycle::itinerary::{Passage, Step};
use crate::analysis::periodic::error::PeriodicError;
use crate::analysis::periodic::shooting::Shooting;
use crate::expressions::{Side, Sides};
use crate::flow::GuardKind;
use crate::flow::leg::{Jump, LegKind};

impl Shooting<f64> {
    /// The same orbit with an impact of rate zero where a step ends by crossing a surface.
    pub(super) fn with_impact_at_turn(
        &self,
        at: &[f64],
        (index, contact): (usize, usize),
    ) -> Result<(Self, Vec<f64>, usize), PeriodicError> {
        let mut steps = self.current_steps(at);
        let Some((kind, _)) = turn(&steps[index]) else {
            return Err(unfollowed("a graze where another event ends the flight"));
        };
        steps[index].passage = Passage::Leg(LegKind {
            ends_at: Some(GuardKind::Gap(contact)),
            jump: Jump::Impact(contact),
            ..kind
        });
        let (shooting, at) = self.like(steps, at)?;
        Ok((shooting, at, index))
    }

    /// Whether the surface at whose crossing a step ends is one that this contact's rate may turn with.
    pub(super) fn turns(&self, index: usize) -> bool {
        turn(&self.steps[index]).is_some()
    }

    /// The surface that an impact takes the state across, and no other: that of the modes before and after it.
    pub(super) fn surface_at_impact(&self, before: usize, after: usize) -> Option<usize> {
        let system = &self.workshop.system;
        let ((grip, sides, _), (other_grip, other_sides, _)) =
            (system.origin_of(before)?, system.origin_of(after)?);
        if grip != other_grip {
            return None;
        }
        let differ = |surface: &usize| sides.get(*surface) != other_sides.get(*surface);
        let mut surfaces = (0..Sides::MOST).filter(differ);
        let surface = surfaces.next().filter(|_| surfaces.next().is_none())?;
        let slides = |sides: Sides| sides.get(surface) == Side::Sliding;
        (!slides(sides) && !slides(other_sides)).then_some(surface)
    }
}

/// The leg of a step that ends by crossing a surface, and that surface.
fn turn(step: &Step) -> Option<(LegKind, usize)> {
    match step.passage {
        Passage::Leg(kind) if kind.jump == Jump::None => match kind.ends_at {
            Some(GuardKind::Switch(surface)) => Some((kind, surface)),
            _ => None,
        },
        _ => None,
    }
}
