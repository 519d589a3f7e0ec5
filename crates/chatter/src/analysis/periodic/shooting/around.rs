//! Autonomous orbits on which nothing happens, not even a crossing of the section: told from a plane across the flow, which is chosen anew
//! wherever a curve has come to. So it is crossed on any orbit, however that moves or shrinks.

use super::{Flown, Shooting};
use crate::analysis::periodic::closure::Turn;
use crate::analysis::periodic::cycle::itinerary::{Passage, Step};
use crate::flow::GuardKind;
use crate::flow::leg::{Jump, Landing, LegKind};
use crate::numerics::{Real, dot};

/// The landing of a leg on the plane through where the step is guessed to start, phases turned back by so many whole turns.
pub(super) fn onto<R: Real>(
    mut landing: Landing<R>,
    (normal, step): (&[R], &Step),
    turned: impl Iterator<Item = (Turn<R>, i64)>,
) -> Landing<R> {
    let n = normal.len();
    let off = |i: usize| landing.image[i] - R::splat(step.start[i]);
    landing.surface = (0..n).fold(R::ZERO, |sum, i| normal[i].mul_add(off(i), sum));
    landing.surface_rate = dot(normal, &landing.image_rate);
    for (column, slope) in landing.surface_slopes.iter_mut().enumerate() {
        let slopes = (0..n).map(|i| normal[i] * landing.image_slopes[(i, column)]);
        *slope = slopes.fold(R::ZERO, |sum, part| sum + part);
    }
    for (turn, count) in turned {
        let times = normal[turn.state] * R::splat(count as f64);
        landing.surface -= times * turn.period;
        let slopes = landing.surface_slopes[n..].iter_mut().zip(turn.slopes);
        slopes.for_each(|(slope, by)| *slope -= times * by);
    }
    landing
}

impl<R: Real> Shooting<R> {
    /// Chooses planes through the nodes, at the parameters of a point: across the flow there, as sizes of states measure it, and through what
    /// lies opposite. Through the middle of the orbit a plane stays what it is where the orbit shrinks to nothing; across the flow alone
    /// it would turn with every step, and nodes come in on a spiral.
    pub(super) fn set_planes(&mut self, at: &[R]) {
        let planes = (0..self.steps.len()).map(|index| self.plane(at, index).unwrap_or_default());
        self.planes = planes.collect();
    }

    fn plane(&mut self, at: &[R], index: usize) -> Option<Vec<R>> {
        let parameters = self.workshop.parameters(self.free(at));
        let n = self.workshop.model.states.len();
        let step = &self.steps[index];
        let Passage::Around(_) = step.passage else {
            return None;
        };
        let Flown::Leg(leg, flyer) = &self.flown[index] else {
            return None;
        };
        let (leg, flyer) = (leg.clone(), *flyer);
        let all = self.parameters_of(&parameters, step);
        let node: Vec<R> = step.start.iter().map(|&x| R::splat(x)).collect();
        let half = R::splat(0.5 * step.duration);
        let flyer = &mut self.flyers[flyer].1;
        let field = leg.field(flyer, &all, &node);
        let opposite = match self.counts.iter().all(|&count| count == 0) {
            true => leg.fly(flyer, &all, &node, half).ok(),
            false => None,
        };
        let sizes = &self.scales[..n];
        let measured = |of: &dyn Fn(usize) -> R| -> Vec<R> {
            let moves = |state: usize| !self.workshop.closure.is_idle(state);
            let part = |i: usize| match moves(i) {
                true => of(i) / R::splat(sizes[i]),
                false => R::ZERO,
            };
            (0..n).map(part).collect()
        };
        let speeds = measured(&|i| field[i]);
        let mut across = speeds.clone();
        if let Some(opposite) = opposite {
            let through = measured(&|i| node[i] - opposite.image[i]);
            let share = dot(&speeds, &through) / dot(&through, &through);
            let parts = across.iter_mut().zip(&through);
            parts.for_each(|(x, &d)| *x -= share * d);
        }
        let length = |vector: &[R]| dot(vector, vector).sqrt();
        let is_steep = length(&across) > R::splat(STEEP) * length(&speeds);
        let normal = if is_steep { across } else { speeds };
        let size = length(&normal);
        Some(
            (normal.iter().zip(sizes))
                .map(|(&x, &unit)| x / (size * R::splat(unit)))
                .collect(),
        )
    }
}

/// A plane that the flow crosses at a sine less than this does not tell an orbit.
const STEEP: f64 = 0.1;

impl Shooting<f64> {
    /// The same orbit told from a plane across the flow in place of the section, the one crossing of which is all that happens to it.
    pub(crate) fn told_around(&self, at: &[f64]) -> Option<(Self, Vec<f64>)> {
        let mut steps = self.current_steps(at);
        let [only] = &mut steps[..] else {
            return None;
        };
        let Passage::Leg(kind) = only.passage else {
            return None;
        };
        let section = GuardKind::Section(self.workshop.section?);
        if kind.ends_at != Some(section) {
            return None;
        }
        only.passage = Passage::Around(LegKind {
            ends_at: None,
            jump: Jump::None,
            ..kind
        });
        let (mut other, guess) = self.like(steps, at).ok()?;
        // Where the section is touched what it is a function of stands still, and yet has a size.
        other.take_sizes(&self.state_sizes());
        Some((other, guess))
    }
}
