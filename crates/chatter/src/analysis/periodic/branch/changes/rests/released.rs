//! Contacts that were released a moment ago, where a corner of the field follows or ends that moment, as where their sliding turns. A gap opens from no
//! rate and no acceleration: at a corner that comes so soon what there is of it is rounding, of either sign.

use crate::analysis::periodic::branch::changes::graze::{LEAST_HEIGHT, is_told};
use crate::analysis::periodic::cycle::itinerary::Passage;
use crate::analysis::periodic::shooting::Shooting;
use crate::flow::GuardKind;
use crate::flow::leg::{Jump, Least};

/// A gap that is so few roundoffs of what it is the sum of is zero.
const ROUNDOFFS: f64 = 8.0;

impl Shooting<f64> {
    /// Whether a least value is that of a gap where a step begins, as that of a contact which opens at the very instant of the event before, and no more than
    /// rounding of what it is the sum of.
    pub(in crate::analysis::periodic::branch) fn is_rounding_of_gap(
        &self,
        index: usize,
        least: &Least,
    ) -> bool {
        let (GuardKind::Gap(contact), Some(at)) = (least.guard, self.watching()) else {
            return false;
        };
        let terms = || self.gap_rate(at, (index, contact)).1;
        least.time == 0.0 && !is_told(least.value.abs(), terms(), ROUNDOFFS)
    }

    /// Whether a least value on a step is that of a gap which has opened by no more than rounding, before or after a corner.
    pub(in crate::analysis::periodic::branch) fn is_just_released(
        &self,
        index: usize,
        least: &Least,
    ) -> bool {
        let GuardKind::Gap(contact) = least.guard else {
            return false;
        };
        let plain = |index: usize| match self.steps[index].passage {
            Passage::Leg(kind) if kind.jump == Jump::None => kind.ends_at,
            _ => None,
        };
        let is_corner = |ends_at: Option<GuardKind>| {
            matches!(ends_at, Some(GuardKind::Switch(_) | GuardKind::Piece(..)))
        };
        // A flight from release to impact without a corner is told by how high it is.
        let mut has_corner = is_corner(plain(index));
        let (mut since, mut place) = (least.time, index);
        for _ in 0..self.steps.len() {
            place = self.before(place);
            let ends_at = plain(place);
            let Some(landing) = self.latest.get(place) else {
                return false;
            };
            if ends_at == Some(GuardKind::Reaction(contact)) {
                let Some(at) = self.watching().filter(|_| has_corner) else {
                    return false;
                };
                let (_, terms) = self.gap_rate(at, (index, contact));
                // From rest with this jerk.
                let opened = (landing.surface_rate * since.powi(3)).abs() / 6.0;
                return !is_told(opened, terms, LEAST_HEIGHT);
            }
            if !is_corner(ends_at) {
                return false;
            }
            has_corner = true;
            since += landing.duration;
        }
        false
    }
}
