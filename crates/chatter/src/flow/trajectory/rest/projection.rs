//! Keeps the state on the contacts that hold it: rounding errors of the field would move it off them, slowly.

use crate::expressions::{Expansion, Tape};
use crate::flow::error::FlowError;
use crate::flow::modes::closed::Closed;
use crate::flow::step::Workspace;
use crate::flow::system::System;
use crate::flow::touch::Touch;
use crate::flow::trajectory::Trajectory;
use crate::numerics::linear::solve_consistent;
use crate::numerics::{Real, WithTerms, dot};

/// Gaps that are not linear, and what rounding leaves of a first correction, need a second, never a third at this distance.
const CORRECTIONS: usize = 2;

/// What corrections leave of a state, if it is less than so many roundoffs of what it is the sum of, is nothing.
const LEFT_ROUNDOFFS: f64 = 8.0;

impl<R: Real> Trajectory<R> {
    /// Puts the state back onto the closed contacts after a step, if it has left them.
    pub(in crate::flow::trajectory) fn stay_on_contacts(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        slides: bool,
    ) -> Result<(), FlowError> {
        let program = self.program(system)?;
        let Some(constants) = &self.constants[self.mode] else {
            return Ok(());
        };
        let mut residuals = vec![R::ZERO; program.residuals.outputs.len()];
        work.values_at(
            &program.residuals,
            &constants.residuals,
            (&self.state, &self.low),
            &mut residuals,
        );
        if residuals.iter().all(|&value| value == R::ZERO) {
            return Ok(());
        }
        let rests = self.closed != Closed::NONE;
        if rests {
            self.project(system, self.closed)?;
        }
        // Last: impulses that make rates of contacts zero move what friction holds beside them.
        if slides {
            self.stay_on_surfaces(system)?;
        }
        if rests {
            self.watch_idle(system)?;
        }
        Ok(())
    }

    /// Puts the state back onto the surfaces that it slides along, and rates of sliding that stick to zero: by the least
    /// displacement that leaves gaps and rates of closed contacts as they are.
    pub(in crate::flow::trajectory) fn stay_on_surfaces(
        &mut self,
        system: &System,
    ) -> Result<(), FlowError> {
        let first = 2 * self.grip().carrying().contacts().count();
        let mut sizes: Option<Vec<R>> = None;
        for _ in 0..CORRECTIONS {
            let program = self.program(system)?;
            let Some(constants) = &self.constants[self.mode] else {
                return Ok(());
            };
            let mut values = self.evaluated(&program.residuals, &constants.residuals);
            values[..first].fill(R::ZERO);
            if values.iter().all(|&value| value == R::ZERO) {
                break;
            }
            let gradients = &constants.residual_gradients;
            let gradients = self.evaluated(&program.residual_gradients, gradients);
            let Some(by) = taken_back(&values, &gradients, self.coordinates) else {
                break;
            };
            // What contacts hold would be moved by rounding alone.
            let by: Vec<R> = (by.iter())
                .map(|by| {
                    if by.value.abs() > by.level() {
                        by.value
                    } else {
                        R::ZERO
                    }
                })
                .collect();
            let sizes = sizes.get_or_insert_with(|| vec![R::ZERO; self.coordinates]);
            for ((size, x), by) in sizes.iter_mut().zip(&self.state).zip(&by) {
                *size = size.max(x.abs()).max(by.abs());
            }
            self.push(&by, R::ONE);
        }
        if let Some(sizes) = sizes {
            self.drop_rounding(&sizes);
        }
        Ok(())
    }

    /// Puts the state onto surfaces that nothing moves it off: what rounding has left beside them would be a motion, as that of a current
    /// which a diode has stopped and which decays.
    pub(in crate::flow::trajectory) fn rest_on_surfaces(
        &mut self,
        system: &System,
        surfaces: &[usize],
    ) {
        for &surface in surfaces {
            let mut sizes: Vec<R> = self.state[..self.coordinates]
                .iter()
                .map(|x| x.abs())
                .collect();
            for _ in 0..CORRECTIONS {
                let start = (&self.state[..], &self.low[..]);
                let Some((value, mut gradient)) =
                    self.surface_with_gradient(system, surface, start)
                else {
                    break;
                };
                if let Some(time) = system.model().time {
                    gradient[time] = R::ZERO;
                }
                let share = value / dot(&gradient, &gradient);
                if value == R::ZERO || !share.is_finite() {
                    break;
                }
                for (size, &slope) in sizes.iter_mut().zip(&gradient) {
                    *size = size.max((slope * share).abs());
                }
                self.push(&gradient, -share);
            }
            self.drop_rounding(&sizes);
        }
    }

    /// Takes from the columns what the closed contacts do not allow to vary, of all at once: rates by their impulses, and gaps by what
    /// the same impulses do to the state where they come earlier or later.
    pub(super) fn hold_columns_on_contacts(&mut self, system: &System) -> Result<(), FlowError> {
        if !self.carries_columns() || self.closed == Closed::NONE {
            return Ok(());
        }
        let touch = self.touch_values(system)?;
        let (touches, constants) = self.touches(system)?;
        let contacts: Vec<usize> = self.closed.contacts().collect();
        let drifts = touches.drifts(constants, (&self.state, &self.low));
        // Where a root begins the field has no slope.
        let are_known = contacts
            .iter()
            .all(|&i| drifts[i].iter().all(|x| x.is_finite()));
        let by_gaps = match are_known {
            true => (touch.block(&contacts), &drifts),
            false => (gram(&touch, &contacts), &touch.gradient),
        };
        let held = [by_gaps, (touch.block(&contacts), &touch.jump)];
        for _ in 0..CORRECTIONS {
            for (which, (rows, directions)) in held.iter().enumerate() {
                let (touches, constants) = self.touches(system)?;
                let slopes = touches.slopes(constants, (&self.state, &self.low));
                let columns = self.state[self.coordinates..].chunks_mut(self.coordinates);
                for (index, column) in columns.enumerate() {
                    let right: Vec<R> = contacts.iter().map(|&i| slopes[i][which][index]).collect();
                    let pushes = solve_consistent(rows, &right).unwrap_or_default();
                    for (&contact, by) in contacts.iter().zip(pushes) {
                        for (entry, &component) in column.iter_mut().zip(&directions[contact]) {
                            *entry = component.mul_add(-by, *entry);
                        }
                    }
                }
                self.low[self.coordinates..].fill(R::ZERO);
            }
        }
        Ok(())
    }

    /// Takes from the columns, displacements of the state, what would vary the surfaces that it slides along, and whatever else is
    /// held beside them.
    pub(super) fn hold_columns_on_surfaces(&mut self, system: &System) -> Result<(), FlowError> {
        let program = self.program(system)?;
        let Some(constants) = &self.constants[self.mode] else {
            return Ok(());
        };
        let gradients = &constants.residual_gradients;
        let gradients = self.evaluated(&program.residual_gradients, gradients);
        let size = self.coordinates;
        for column in self.state[size..].chunks_mut(size) {
            let along = |gradient| dot(gradient, column);
            let values: Vec<R> = gradients.chunks(size).map(along).collect();
            let by = taken_back(&values, &gradients, size).unwrap_or_default();
            for (entry, by) in column.iter_mut().zip(by) {
                *entry += by.value;
            }
        }
        Ok(())
    }

    /// The values of a tape at the state.
    fn evaluated(&self, tape: &Tape, constants: &[R]) -> Vec<R> {
        let mut values = vec![R::ZERO; tape.outputs.len()];
        let expansion = &mut Expansion::new(&[tape]);
        expansion.evaluate(tape, constants, &self.state, &self.low, &mut values);
        values
    }

    /// What is left of coordinates that were moved, if it is rounding of what they have become the sum of, is nothing.
    fn drop_rounding(&mut self, sizes: &[R]) {
        for ((x, low), &size) in self.state.iter_mut().zip(&mut self.low).zip(sizes) {
            if x.abs() <= size * R::splat(LEFT_ROUNDOFFS * R::ROUNDOFF) {
                (*x, *low) = (R::ZERO, R::ZERO);
            }
        }
    }

    /// Makes gaps and rates of these contacts zero: gaps by the least displacement, rates along the impulses.
    pub(in crate::flow::trajectory) fn project(
        &mut self,
        system: &System,
        contacts: Closed,
    ) -> Result<(), FlowError> {
        let mut sizes = self.correct_gaps(system, contacts)?;
        let contacts: Vec<usize> = contacts.contacts().collect();
        for _ in 0..CORRECTIONS {
            let touch = self.touch_values(system)?;
            let rates: Vec<R> = contacts.iter().map(|&i| touch.rate[i].value).collect();
            let pushes = self.solved(&touch.block(&contacts), &rates, &contacts)?;
            let directions = contacts.iter().map(|&i| &touch.jump[i]);
            self.take_back(directions.zip(pushes), &mut sizes);
        }
        self.drop_rounding(&sizes);
        Ok(())
    }

    /// Makes the gaps of these contacts zero, which are zero but for rounding.
    pub(in crate::flow::trajectory) fn close_gaps(
        &mut self,
        system: &System,
        contacts: Closed,
    ) -> Result<(), FlowError> {
        self.correct_gaps(system, contacts).map(|_| ())
    }

    /// As [`close_gaps`](Self::close_gaps); returns the sizes of what each coordinate has become the sum of.
    fn correct_gaps(&mut self, system: &System, contacts: Closed) -> Result<Vec<R>, FlowError> {
        let mut sizes: Vec<R> = (self.state[..self.coordinates].iter())
            .map(|x| x.abs())
            .collect();
        let contacts: Vec<usize> = contacts.contacts().collect();
        for _ in 0..CORRECTIONS {
            let touch = self.touch_values(system)?;
            let gaps: Vec<R> = contacts.iter().map(|&i| touch.gap[i].value).collect();
            let pushes = self.solved(&gram(&touch, &contacts), &gaps, &contacts)?;
            let directions = contacts.iter().map(|&i| &touch.gradient[i]);
            self.take_back(directions.zip(pushes), &mut sizes);
        }
        Ok(sizes)
    }

    /// Subtracts so many times each direction from the coordinates, and adds the sizes of that.
    fn take_back<'a>(&mut self, parts: impl Iterator<Item = (&'a Vec<R>, R)>, sizes: &mut [R]) {
        for (direction, by) in parts {
            self.push(direction, -by);
            for (size, &component) in sizes.iter_mut().zip(direction) {
                *size = component.abs().mul_add(by.abs(), *size);
            }
        }
    }

    fn solved(
        &self,
        rows: &[Vec<R>],
        right: &[R],
        contacts: &[usize],
    ) -> Result<Vec<R>, FlowError> {
        if right.iter().all(|&value| value == R::ZERO) {
            return Ok(vec![R::ZERO; right.len()]);
        }
        solve_consistent(rows, right).ok_or_else(|| self.dependent(contacts))
    }
}

/// The least displacement that takes back so much of functions with these gradients, one after the other.
fn taken_back<R: Real>(values: &[R], gradients: &[R], size: usize) -> Option<Vec<WithTerms<R>>> {
    let squared = |gradient| (gradient, dot(gradient, gradient));
    // What moves nothing cannot be put back by moving.
    let (right, held): (Vec<R>, Vec<(&[R], R)>) = (values.iter().copied())
        .zip(gradients.chunks(size).map(squared))
        .filter(|(_, (_, square))| *square > R::ZERO)
        .unzip();
    let row = |of: &[R]| {
        held.iter()
            .map(|&(g, square)| dot(of, g) / square)
            .collect()
    };
    let rows: Vec<Vec<R>> = held.iter().map(|(gradient, _)| row(gradient)).collect();
    let parts = solve_consistent(&rows, &right)?;
    let mut by = vec![WithTerms::exact(R::ZERO); size];
    for (&(gradient, square), part) in held.iter().zip(parts) {
        let part = part / square;
        for (by, &component) in by.iter_mut().zip(gradient) {
            *by -= WithTerms::exact(component * part);
        }
    }
    Some(by)
}

/// Products of the gradients of the gaps with each other.
fn gram<R: Real>(touch: &Touch<R>, contacts: &[usize]) -> Vec<Vec<R>> {
    let of = |i: usize, j: usize| dot(&touch.gradient[i], &touch.gradient[j]);
    let row = |&i: &usize| contacts.iter().map(|&j| of(i, j)).collect();
    contacts.iter().map(row).collect()
}
