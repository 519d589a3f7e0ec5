//! Residual and Jacobian, and the functions that special points hold at zero.

use super::Shooting;
use super::workshop::Monitor;
use crate::analysis::continuation::{Left, Linearised, Problem, Wrap, differenced};
use crate::analysis::periodic::cycle::itinerary::Passage;
use crate::analysis::periodic::multipliers::neutral;
use crate::expressions::Expr;
use crate::numerics::{Matrix, Real};

impl<R: Real> Shooting<R> {
    /// The number of the function that vanishes where a pair of multipliers is on the unit circle.
    pub(crate) fn pair_function(&self) -> usize {
        self.steps.len()
    }

    /// How far the nodes are from where the steps before them lead, against the sizes of the states.
    pub(crate) fn apart(&self, residual: &[R]) -> f64 {
        let sizes = self.state_sizes();
        let mut rows = residual.iter();
        let mut most = 0.0_f64;
        for step in &self.steps {
            if step.has_own_time() {
                rows.next();
            }
            for (size, row) in sizes.iter().zip(rows.by_ref()) {
                let part = row.abs().to_f64() / size;
                most = if part.is_nan() { part } else { most.max(part) };
            }
        }
        most
    }

    /// The number of one of the user's functions.
    pub(crate) fn user_function(&self, index: usize) -> usize {
        self.steps.len() + 1 + index
    }

    /// The same, with its derivatives. Where an event stands for the crossing of the section at its instant the function is that of the state there, to first
    /// order in the time between both: one that vanishes wherever that event is, as on a surface that is crossed, says by itself nothing of the instant.
    fn function(&self, index: usize, at: &[R]) -> Result<(R, Vec<R>), Left> {
        let workshop = &self.workshop;
        let monitor = (workshop.monitors.get(index))
            .ok_or_else(|| Left::because(format_args!("there is no function {index}")))?;
        let parameters = workshop.parameters(self.free(at));
        let node = self.told_node.unwrap_or(0).min(self.steps.len() - 1);
        let of =
            |expr: Expr| (workshop.model.graph).evaluate(expr, self.node(at, node), &parameters);
        let (mut value, mut gradient) = self.with_slopes(monitor, (at, node), &of);
        if self.stands_for_section
            && let Some(surface) = workshop.surface()
        {
            let rate = |function: &Monitor| {
                let rates = function.by_state.iter().zip(&workshop.model.states);
                rates.fold(R::ZERO, |sum, (&by, state)| {
                    sum + of(by) * of(state.derivative)
                })
            };
            let part = rate(monitor) / rate(surface);
            let (off, slopes) = self.with_slopes(surface, (at, node), &of);
            value -= part * off;
            (gradient.iter_mut().zip(slopes)).for_each(|(x, slope)| *x -= part * slope);
        }
        Ok((value, gradient))
    }

    fn with_slopes(
        &self,
        function: &Monitor,
        (at, node): (&[R], usize),
        of: &impl Fn(Expr) -> R,
    ) -> (R, Vec<R>) {
        let mut gradient = vec![R::ZERO; at.len()];
        let by_state = gradient[self.places[node]..].iter_mut();
        by_state
            .zip(&function.by_state)
            .for_each(|(entry, &slope)| *entry = of(slope));
        let free = at.len() - self.workshop.free.len();
        let by_parameter = gradient[free..].iter_mut();
        by_parameter
            .zip(&function.by_parameter)
            .for_each(|(entry, &slope)| *entry = of(slope));
        (of(function.value), gradient)
    }
}

impl<R: Real> Problem<R> for Shooting<R> {
    fn unknowns(&self) -> usize {
        self.scales.len()
    }

    fn parameters(&self) -> usize {
        self.workshop.free.len()
    }

    fn scales(&self) -> &[f64] {
        &self.scales
    }

    fn evaluate(&mut self, at: &[R]) -> Result<Linearised<R>, Left> {
        let workshop = self.workshop.clone();
        let n = workshop.model.states.len();
        let free = workshop.free.len();
        let unknowns = self.scales.len();
        let parameters = workshop.parameters(self.free(at));
        let turns = workshop.closure.turns(&parameters).map_err(Left::because)?;
        let landings = self.land(at, &turns, &parameters)?;
        let lap = self.timed(&turns);
        let mut residual = vec![R::ZERO; unknowns - free];
        let mut jacobian = Matrix::zeros(unknowns - free, unknowns);
        let count = self.steps.len();
        let mut row = 0;
        for (index, landing) in landings.iter().enumerate() {
            let place = self.places[index];
            let next = self.places[self.after(index)];
            let is_last = index + 1 == count;
            let timed = matches!(self.steps[index].passage, Passage::Timed(_));
            // Where a time says the end of a stretch it has none to be eliminated.
            let ends_at_event =
                self.steps[index].is_stretch() && self.steps[index].ends_at().is_some();
            let is_leg = self.steps[index].has_own_time();
            if is_leg {
                residual[row] = landing.surface;
                for k in 0..n {
                    jacobian[(row, place + k)] = landing.surface_slopes[k];
                }
                jacobian[(row, place + n)] = landing.surface_rate;
                for k in 0..free {
                    jacobian[(row, unknowns - free + k)] = landing.surface_slopes[n + k];
                }
                row += 1;
            }
            for i in 0..n {
                residual[row] = at[next + i] - landing.image[i];
                jacobian[(row, next + i)] += R::ONE;
                for k in 0..n + free {
                    let column = if k < n {
                        place + k
                    } else {
                        unknowns - free + k - n
                    };
                    let mut slope = landing.image_slopes[(i, k)];
                    if ends_at_event {
                        let late = landing.surface_slopes[k] / landing.surface_rate;
                        slope -= landing.image_rate[i] * late;
                    }
                    jacobian[(row, column)] -= slope;
                }
                if is_leg {
                    jacobian[(row, place + n)] -= landing.image_rate[i];
                }
                if timed {
                    // The duration follows the period.
                    if let Some(lap) = &lap {
                        for (k, &slope) in lap.slopes.iter().enumerate() {
                            jacobian[(row, unknowns - free + k)] -= landing.image_rate[i] * slope;
                        }
                    }
                }
                if is_last {
                    let turning = turns
                        .iter()
                        .zip(&self.counts)
                        .find(|(turn, _)| turn.state == i);
                    if let Some((turn, &times)) = turning {
                        let times = R::splat(times as f64);
                        residual[row] += turn.period * times;
                        for (k, &slope) in turn.slopes.iter().enumerate() {
                            jacobian[(row, unknowns - free + k)] += slope * times;
                        }
                    }
                }
                row += 1;
            }
        }
        let last = row - n;
        // A timed orbit of a system with time has no equation for when it starts: it starts there.
        let all_timed = (self.steps.iter()).all(|step| matches!(step.passage, Passage::Timed(_)));
        let clock = workshop
            .closure
            .time
            .or_else(|| self.clock())
            .filter(|_| all_timed);
        if let Some(i) = clock {
            jacobian.row_mut(last + i).fill(R::ZERO);
            jacobian[(last + i, self.places[0] + i)] = R::ONE;
            residual[last + i] = at[self.places[0] + i] - self.pins[i];
        }
        for free in &workshop.closure.idle {
            let i = last + free.state;
            for &(other, times) in &free.others {
                let times = R::splat(times);
                for column in 0..unknowns {
                    let moved = jacobian[(i, column)];
                    jacobian[(last + other, column)] -= times * moved;
                }
                let moved = residual[i];
                residual[last + other] -= times * moved;
            }
        }
        for free in &workshop.closure.idle {
            let i = last + free.state;
            jacobian.row_mut(i).fill(R::ZERO);
            jacobian[(i, self.places[0] + free.state)] = R::ONE;
            residual[i] = at[self.places[0] + free.state] - self.pins[free.state];
        }
        self.smooth = self.smooth(at, &parameters, &landings);
        self.latest = landings;
        self.watching = Some(at.to_vec());
        Ok(Linearised { residual, jacobian })
    }

    /// Function number `index`: for each step the rate before the event at its end, zero where it grazes; then what vanishes
    /// where a pair of multipliers is on the unit circle; then the user's functions; then that of the corner that is watched.
    fn monitor(&mut self, index: usize, at: &[R]) -> Result<(R, Vec<R>), Left> {
        if index == self.corner_function() {
            return self.corner_value(at);
        }
        if index == self.pair_function() {
            return differenced(self, at, |shooting, at| {
                shooting.evaluate(at)?;
                let found = neutral(&shooting.multipliers());
                let (off, ..) =
                    found.ok_or_else(|| Left::because("there are no two multipliers"))?;
                Ok(R::splat(off))
            });
        }
        if let Some(index) = index.checked_sub(self.user_function(0)) {
            return self.function(index, at);
        }
        if self.watching.as_deref() != Some(at) {
            self.evaluate(at)?;
        }
        let n = self.workshop.model.states.len();
        let free = self.workshop.free.len();
        let place = self.places[index];
        let landing = &self.latest[index];
        let mut gradient = vec![R::ZERO; at.len()];
        gradient[place..place + n].copy_from_slice(&landing.rate_slopes[..n]);
        for k in 0..free {
            gradient[at.len() - free + k] = landing.rate_slopes[n + k];
        }
        if let Some(duration) = self.duration_place(index) {
            gradient[duration] = landing.surface_acceleration;
        }
        Ok((landing.surface_rate, gradient))
    }

    fn wrap(&self) -> Wrap {
        let n = self.workshop.model.states.len();
        let free = self.workshop.free.len();
        let last = self.scales.len() - free - n;
        let closure = &self.workshop.closure;
        let entries = (0..n)
            .filter(|&i| !closure.is_idle(i))
            .map(|i| (last + i, self.places[0] + i, 1.0));
        Wrap {
            entries: entries.collect(),
        }
    }
}
