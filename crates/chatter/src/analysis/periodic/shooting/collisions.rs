//! Collisions that share an instant: of the contacts that touch the one that closes fastest goes first, and while that does not change
//! their map is smooth. Where flights of several contacts end at one instant it is if all orders have one derivative.

use super::monodromy::transfer;
use super::{Flown, Shooting};
use crate::analysis::continuation::{Left, Problem};
use crate::analysis::periodic::cycle::corners::in_order;
use crate::analysis::periodic::cycle::itinerary::{Passage, Step};
use crate::analysis::periodic::cycle::trace::open_beside;
use crate::flow::leg::LegKind;
use crate::flow::{Closed, GuardKind, SAME_DERIVATIVE, SAME_RATE, System, UNFELT, orders};
use crate::model::State;
use crate::numerics::Matrix;
use core::ops::Range;

/// Contacts that the state lies on after the collisions up to the end of a step at one instant, and that are open then.
pub(crate) fn lies_on(system: &System, steps: &[Step], last: usize) -> Closed {
    let first = (0..=last).rev().find(|&index| !steps[index].is_at_once());
    let chain = &steps[first.unwrap_or(0)..=last];
    let struck = (chain.iter().filter_map(Step::impact))
        .fold(Closed::NONE, |all, contact| all.with(contact));
    open_beside(system, (chain[0].mode(), struck), steps[last].closed)
}

/// Impacts that are farther apart than this part of the period do not share an instant.
const APART: f64 = 1e-9;

impl Shooting<f64> {
    /// By how much the collision of a step that takes no time, at a point that was evaluated last, comes before any other that would have
    /// another outcome: how much faster it closes; and how fast it does. None of other steps.
    pub(crate) fn precedence(&self, index: usize) -> Option<(f64, f64)> {
        let step = self.steps.get(index).filter(|step| step.is_at_once())?;
        let at = self.watching.as_ref()?;
        // What is to share its instant with the event before does so but for rounding.
        let place = self.duration_place(index);
        let apart = place.map_or(0.0, |place| at[place].abs() / self.scales[place]);
        let Some(contact) = step.impact() else {
            return place.map(|_| (1.0 - apart / APART, 1.0));
        };
        let parameters = self.workshop.parameters(self.free(at));
        let known = self.parameters_of(&parameters, step);
        let system = &self.workshop.system;
        let (_, _, on) = system.origin_of(step.mode())?;
        let rates = |node: usize| -> Vec<f64> {
            let state = self.node(at, node);
            (on.mechanics.contacts.iter())
                .map(|contact| on.mechanics.graph.evaluate(contact.rate, state, &known))
                .collect()
        };
        let (before, after) = (rates(index), rates(self.after(index)));
        let own = -before[contact];
        let touching = self.touching(index)?;
        let others = (touching.contacts())
            .filter(|&other| other != contact)
            .filter(|&other| (after[other] - before[other]).abs() > UNFELT * own.abs());
        let first = others.fold(own, |least, other| least.min(own + before[other].min(0.0)));
        Some((first.min(own * (1.0 - apart / APART)), own))
    }

    /// Contacts that touch at the instant of a step that takes no time: those that were closed before, and those that are struck.
    fn touching(&self, index: usize) -> Option<Closed> {
        let count = self.steps.len();
        let first = (0..count)
            .map(|back| self.step_back(index, back))
            .find(|(_, step)| !step.is_at_once())?
            .0;
        let (grip, ..) = self.workshop.system.origin_of(self.steps[first].mode())?;
        let on = core::iter::successors(Some(self.after(first)), |&step| Some(self.after(step)));
        let on = on
            .take(count - 1)
            .take_while(|&step| self.steps[step].is_at_once());
        let chain = core::iter::once(first).chain(on);
        let all = chain.filter_map(|step| self.steps[step].impact());
        Some(all.fold(grip.closed, |all, contact| all.with(contact)))
    }

    /// Whether a guard ends a step that takes no time at the instant of this one's end.
    pub(crate) fn ends_at_once_after(&self, index: usize, guard: GuardKind) -> bool {
        let on = core::iter::successors(Some(self.after(index)), |&step| Some(self.after(step)));
        (on.take(self.steps.len() - 1).map(|step| &self.steps[step]))
            .take_while(|step| step.is_at_once())
            .any(|step| step.ends_at() == Some(guard))
    }

    /// The step of the collision that another one could precede as well, if there is one, with another derivative: after an evaluation.
    pub(crate) fn tie(&self) -> Option<usize> {
        let ties = |&index: &usize| {
            (self.precedence(index)).is_some_and(|(first, own)| first <= SAME_RATE * own)
        };
        (0..self.steps.len()).find(ties)
    }
}

impl Shooting<f64> {
    /// The field at a state where the step after another one begins.
    fn field_after(&self, index: usize, at: &[f64], state: &[f64]) -> Result<Vec<f64>, Left> {
        let parameters = self.workshop.parameters(self.free(at));
        let next = self.after(index);
        if let Flown::Leg(..) = &self.flown[next] {
            let regime = self.regime_after(&self.current_steps(at), index, &parameters)?;
            let system = &self.workshop.system;
            let known = system.with_pieces(&parameters, &regime.pieces);
            let field = system.field_of(regime.mode, &known, state);
            return field.ok_or_else(|| Left::because("a mode holds no motion"));
        }
        let model = &self.workshop.model;
        let rate = |of: &State| model.graph.evaluate(of.derivative, state, &parameters);
        Ok(model.states.iter().map(rate).collect())
    }

    /// The step that ends with an event which comes at the instant of another, where the derivative depends on which of them is met first: at
    /// a point.
    pub(crate) fn depends_on_order(&mut self, at: &[f64]) -> Result<Option<usize>, Left> {
        let count = self.steps.len();
        let mut first = 0;
        while first < count {
            let after = (first + 1..count).find(|&index| !self.steps[index].is_at_once());
            let chain = first..after.unwrap_or(count);
            first = chain.end;
            let is_together =
                |index: usize| matches!(self.steps[index].passage, Passage::Together(_));
            if let Some(index) = chain.clone().find(|&index| is_together(index))
                && self.order_matters(at, chain)?
            {
                return Ok(Some(index));
            }
        }
        Ok(None)
    }

    /// The same of one chain of collisions.
    fn order_matters(&mut self, at: &[f64], chain: Range<usize>) -> Result<bool, Left> {
        let steps = self.current_steps(at);
        let mut groups: Vec<Vec<Step>> = Vec::new();
        for step in &steps[chain.clone()] {
            match (groups.last_mut(), step.passage) {
                (Some(group), Passage::AtOnce(_)) => group.push(step.clone()),
                _ => groups.push(vec![step.clone()]),
            }
        }
        let contacts = |group: &[Step]| {
            let all = group.iter().filter_map(Step::impact);
            all.fold(Closed::NONE, |all, contact| all.with(contact))
        };
        let mut seen = Closed::NONE;
        for group in &groups {
            let own = contacts(group);
            if seen.0 & own.0 != 0 {
                return Ok(true);
            }
            seen = Closed(seen.0 | own.0);
        }
        let own_mode = steps[chain.start].mode();
        let own = self.derivative(at, chain.clone())?;
        let largest = (0..own.rows())
            .flat_map(|row| own.row(row))
            .fold(0.0_f64, |most, x| most.max(x.abs()));
        for order in orders(groups.len())
            .into_iter()
            .filter(|order| !order.is_sorted())
        {
            let sorted = order.iter().map(|&group| &groups[group]);
            let chosen = sorted.enumerate().flat_map(|(place, group)| {
                let way = &steps[chain.start];
                group
                    .iter()
                    .enumerate()
                    .map(move |(within, step)| match (place, within) {
                        (0, 0) => Step {
                            passage: ending(way.passage, step.passage),
                            ..way.clone()
                        },
                        (_, 0) => Step {
                            passage: together(step.passage),
                            duration: 0.0,
                            ..step.clone()
                        },
                        _ => step.clone(),
                    })
            });
            let mut all = steps.clone();
            all.splice(chain.clone(), chosen);
            if !self.take_modes(own_mode, &mut all[chain.clone()]) {
                return Ok(true);
            }
            let mut other =
                Self::new(&self.workshop, all, self.counts.clone()).map_err(Left::because)?;
            let found = other.derivative(at, chain.clone())?;
            let off = (0..own.rows()).flat_map(|row| own.row(row).iter().zip(found.row(row)));
            if off
                .into_iter()
                .any(|(a, b)| (a - b).abs() > SAME_DERIVATIVE * largest)
            {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Corners of one instant, met in this mode, lead through other modes in another order. Whether they can, if they are corners.
    fn take_modes(&self, mode: usize, chain: &mut [Step]) -> bool {
        if chain.iter().any(|step| step.impact().is_some()) {
            return true;
        }
        let crossings: Option<Vec<GuardKind>> = chain.iter().map(Step::ends_at).collect();
        let kinds = crossings.and_then(|all| in_order(&self.workshop.system, mode, all));
        let Some(kinds) = kinds else {
            return false;
        };
        for (step, kind) in chain.iter_mut().zip(kinds) {
            step.passage = match step.passage {
                Passage::Stretch(whole) => Passage::Stretch(whole.up_to(kind)),
                Passage::Together(_) => Passage::Together(kind),
                _ => Passage::Leg(kind),
            };
        }
        true
    }

    /// The derivative of a chain of collisions, the way to it included, from where that begins at a point: of the state after it at
    /// a given time, whichever event was the last.
    pub(super) fn derivative(
        &mut self,
        at: &[f64],
        chain: Range<usize>,
    ) -> Result<Matrix<f64>, Left> {
        let n = self.workshop.model.states.len();
        let mut here = self.guess(self.free(at));
        for index in chain.clone() {
            self.evaluate(&here)?;
            let image = self.latest[index].image.clone();
            if index + 1 < chain.end {
                let place = self.places[index + 1];
                here[place..place + n].copy_from_slice(&image);
            }
        }
        let mut product = Matrix::identity(n);
        let mut late = vec![0.0; n];
        for index in chain.clone() {
            let landing = &self.latest[index];
            if !matches!(self.steps[index].passage, Passage::AtOnce(_)) {
                let slopes = product.apply_transposed(&landing.surface_slopes[..n]);
                for (late, slope) in late.iter_mut().zip(slopes) {
                    *late -= slope / landing.surface_rate;
                }
            }
            product = transfer(landing, n).times(&product);
        }
        let image = self.latest[chain.end - 1].image.clone();
        let rates = self.field_after(chain.end - 1, &here, &image)?;
        for (i, rate) in rates.into_iter().enumerate() {
            for (entry, late) in product.row_mut(i).iter_mut().zip(&late) {
                *entry -= rate * late;
            }
        }
        Ok(product)
    }
}

/// The event at the end of a step.
fn event(passage: Passage) -> Option<LegKind> {
    match passage {
        Passage::Leg(kind) | Passage::AtOnce(kind) | Passage::Together(kind) => Some(kind),
        Passage::Stretch(kind) => Some(kind.last),
        Passage::Timed(_) | Passage::Around(_) => None,
    }
}

/// A way that ends with the event of another step.
fn ending(way: Passage, other: Passage) -> Passage {
    match (way, event(other)) {
        (Passage::Stretch(whole), Some(last)) => Passage::Stretch(whole.up_to(last)),
        (_, Some(kind)) => Passage::Leg(kind),
        (way, None) => way,
    }
}

/// An event at the instant of another.
fn together(passage: Passage) -> Passage {
    event(passage).map_or(passage, Passage::Together)
}
