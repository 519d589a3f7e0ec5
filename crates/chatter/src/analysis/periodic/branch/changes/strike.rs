//! Where what strikes a body that friction holds loses its rate. However weak, an impact takes the body off where it sticks, and slips lead back:
//! the first in a time in proportion to the rate, the next one as far back as that went. So the body sticks just where friction can hold it no more as the
//! rate vanishes, and both slips come to nothing at once, the second in a time of its own: with it the equations are singular there. Without them
//! they are so, too, by all places in which friction may hold the body; the impact's rate and what friction has left to hold with tell which one it is.

use super::events::unfollowed;
use super::graze::{THERE, graze, moved};
use crate::analysis::continuation::{Coincident, Problem, Singular, Station, coincidence_along};
use crate::analysis::periodic::branch::Point;
use crate::analysis::periodic::branch::limits::End;
use crate::analysis::periodic::branch::walker::Walker;
use crate::analysis::periodic::cycle::itinerary::{Passage, Step};
use crate::analysis::periodic::cycle::rotate::rotate;
use crate::analysis::periodic::error::PeriodicError;
use crate::analysis::periodic::shooting::Shooting;
use crate::analysis::periodic::solved::Solved;
use crate::expressions::Side;
use crate::flow::GuardKind;
use crate::flow::leg::{Jump, LegKind};
use crate::numerics::unit;

/// The first slip is about to come to nothing if it takes less than this part of the period.
const SHORT: f64 = 1e-2;
/// Slips lead back and forth.
const SLIPS: usize = 2;

/// An impact on what sticks along a surface.
#[derive(Clone, Copy, Debug)]
struct Strike {
    /// The step that it ends.
    index: usize,
    contact: usize,
    surface: usize,
    /// The side that the second slip leads to.
    back: Side,
}

impl Shooting<f64> {
    /// The impact that comes to nothing with the slips after it, along a direction.
    fn weak_strike(&self, station: &Station) -> Option<Strike> {
        let surfaces = self.workshop.system.corners().surfaces.len();
        (0..self.steps.len()).find_map(|index| {
            let step = &self.steps[index];
            let contact = step.impact()?;
            let first = self.after(index);
            let place = self.duration_place(first)?;
            let shrinks = station.at[place] < SHORT * self.period() && station.tangent[place] < 0.0;
            if !shrinks || !self.impact_takes_off(index) {
                return None;
            }
            let surface = (0..surfaces).find(|&surface| self.slides_along(step, surface))?;
            let second = self.after(first);
            let slips = |k: usize| {
                let slip = &self.steps[k];
                let ends = slip.ends_at() == Some(GuardKind::Switch(surface));
                ends && slip.impact().is_none() && !self.slides_along(slip, surface)
            };
            let sticks = self.slides_along(&self.steps[self.after(second)], surface);
            let (_, sides, _) = (self.workshop.system).origin_of(self.steps[second].mode())?;
            let back = sides.get(surface);
            (slips(first) && slips(second) && sticks).then_some(Strike {
                index,
                contact,
                surface,
                back,
            })
        })
    }

    /// The same orbit without the slips after such an impact, which only touches: told from there.
    fn without_strike(
        &self,
        at: &[f64],
        strike: Strike,
    ) -> Result<(Self, Vec<f64>), PeriodicError> {
        let mut steps = self.current_steps(at);
        let by = self.after(strike.index);
        if by > 0 {
            let parameters = self.workshop.parameters(self.free(at));
            rotate(&self.workshop, &parameters, (&mut steps, &self.counts), by)?;
        }
        let slips: Vec<Step> = steps.drain(..SLIPS).collect();
        let stick = &mut steps[0];
        stick.start.clone_from(&slips[0].start);
        stick.duration += slips.iter().map(|slip| slip.duration).sum::<f64>();
        let last = steps.len() - 1;
        let Passage::Leg(kind) = steps[last].passage else {
            return Err(unfollowed("an impact that ends no leg"));
        };
        steps[last].passage = Passage::Leg(LegKind {
            jump: Jump::None,
            ..kind
        });
        self.like(steps, at)
    }

    /// Where the impact has no rate and friction just holds what it strikes, and whether it opens on orbits that friction just holds as the parameter
    /// grows.
    fn strikes_no_more(&mut self, start: &[f64], strike: Strike) -> Option<(Solved, bool)> {
        let last = self.steps.len() - 1;
        let leaves = GuardKind::Leave(strike.surface, strike.back);
        self.watch_start(0, leaves).ok()?;
        let conditions = [last, self.corner_function()];
        let singular = Singular::near(self, start, 1.0).ok()?;
        let mut column = singular.borders();
        column.truncate(column.len() / 2);
        let coincident = coincidence_along(self, start, conditions, column).ok()?;
        if moved(&coincident.found.at, start, self.scales()) > THERE {
            return None;
        }
        let Coincident { found, .. } = &coincident;
        // Where the gap has its least value is where its rate vanishes: all but that value held, the parameter goes so for more of it.
        let (unknowns, gap) = (found.at.len(), self.node_places(last).start);
        let opens = found.factors.solve(&unit(unknowns + 1, gap))[unknowns - 1] > 0.0;
        let (solved, _) = self.solved_together(coincident, conditions)?;
        Some((solved, opens))
    }
}

impl Walker {
    /// How the branch ends where such an impact loses its rate: without it what it strikes may be wherever friction holds it.
    pub(in crate::analysis::periodic::branch) fn ends_with_strike(
        &mut self,
        station: &Station,
        here: &Point,
    ) -> Option<End> {
        self.settle(station);
        let strike = self.shooting.weak_strike(station)?;
        let (mut without, guess) = self.shooting.without_strike(&station.at, strike).ok()?;
        let (met, opens) = without.strikes_no_more(&guess, strike)?;
        let own = core::mem::replace(&mut self.shooting, without);
        self.note(graze(opens), here, &met.told, met.error, met.residual);
        self.tell_no_multipliers();
        self.shooting = own;
        if let Some(special) = self.special.last_mut() {
            special.point.impacts = special.point.impacts.map(|n| n.saturating_sub(1));
        }
        self.settle(station);
        let contact = &self.shooting.workshop.model.contacts[strike.contact].name;
        Some(End::Lost(format!(
            "an impact at `{contact}` has no rate any more, and without it orbits lie beside each other: friction holds what it strikes in many places"
        )))
    }
}
