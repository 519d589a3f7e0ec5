//! The derivative of one period, and the multipliers.

use super::{Flown, Shooting};
use crate::analysis::periodic::cycle::itinerary::{Passage, held};
use crate::analysis::periodic::multipliers::{ROUNDED, without_rounding};
use crate::flow::leg::Landing;
use crate::numerics::{Complex, Matrix, Real, balance, dot, eigenvalues, pairs};

/// An impact of so small a part of what rates are has none: rates go to zero as roots of the distance do.
const NO_RATE: f64 = 1e-5;
/// A surface is crossed slowly at a rate that is this part of what its acceleration there makes in a period.
const SLOWLY: f64 = 1e-2;

impl<R: Real> Shooting<R> {
    /// The derivative of the map from the first node to itself, events' times taken with it.
    fn monodromy(&self) -> Matrix<R> {
        let n = self.workshop.model.states.len();
        let mut product = Matrix::identity(n);
        for transfer in self.transfers() {
            product = transfer.times(&product);
        }
        product
    }

    /// The derivatives of the legs. An event's time is taken with it, but where nothing happens to displacements there and a surface is
    /// crossed slowly: there the derivative at a given time, which differs by a displacement in time, is known, and the other is not.
    fn transfers(&self) -> impl Iterator<Item = Matrix<R>> {
        let n = self.workshop.model.states.len();
        let taken = self.takes_time();
        let legs = self.latest.iter().zip(taken);
        legs.map(move |(landing, taken)| match taken {
            true => transfer(landing, n),
            false => at_its_time(landing, n),
        })
    }

    /// Whether the time of the event at the end of each step is taken with it. A displacement in time has to go somewhere: at one event at
    /// least, unless there is a clock, which has none.
    fn takes_time(&self) -> Vec<bool> {
        let period = self.period();
        let how_fast = |landing: &Landing<R>| {
            let gained = (landing.surface_acceleration * period).abs();
            (landing.surface_rate.abs() / gained).to_f64()
        };
        let fast: Vec<f64> = self.latest.iter().map(how_fast).collect();
        let mut taken: Vec<bool> = (self.smooth.iter().zip(&fast))
            .map(|(smooth, fast)| !(*smooth && *fast < SLOWLY))
            .collect();
        let has_clock = self.workshop.closure.time.is_some() || self.clock().is_some();
        if !has_clock && !taken.contains(&true) {
            let fastest = (0..fast.len()).max_by(|&a, &b| fast[a].total_cmp(&fast[b]));
            fastest.into_iter().for_each(|index| taken[index] = true);
        }
        taken
    }

    /// How many of the multipliers are zero by dimension: what the modes hold is forgotten.
    fn lost(&self) -> usize {
        let system = &self.workshop.system;
        let modes = self.steps.iter().map(|step| held(system, step.mode()));
        let closed = (self.steps.iter()).map(|step| 2 * step.closed.contacts().count());
        modes.chain(closed).max().unwrap_or(0)
    }

    /// All multipliers but the trivial one, the largest first.
    pub(crate) fn multipliers(&self) -> Vec<Complex> {
        self.multipliers_known().0
    }

    /// The same, and what the moduli of those about the unit circle may be off by: a pair's is known by its product, in which entries of
    /// the matrix are multiplied with each other.
    pub(crate) fn multipliers_known(&self) -> (Vec<Complex>, f64) {
        let n = self.workshop.model.states.len();
        let product = self.monodromy();
        let taken = self.takes_time();
        let has_events = (self.steps.iter().zip(&taken))
            .any(|(step, taken)| *taken && !matches!(step.passage, Passage::Timed(_)));
        let turning = self.workshop.closure.time.or_else(|| self.clock());
        let kept: Vec<usize> = (0..n)
            .filter(|&i| !self.workshop.closure.is_idle(i))
            .filter(|i| has_events || turning != Some(*i))
            .collect();
        let mut reduced = Matrix::zeros(kept.len(), kept.len());
        let mut trace = R::ZERO;
        for (row, &i) in kept.iter().enumerate() {
            for (from, times) in self.workshop.closure.displacement(i) {
                for (column, &k) in kept.iter().enumerate() {
                    let part = product[(from, k)] * R::splat(times);
                    reduced[(row, column)] += part.to_f64();
                    if column == row {
                        trace += part;
                    }
                }
            }
        }
        balance(&mut reduced);
        let entries = (0..kept.len()).flat_map(|row| reduced.row(row));
        let largest = entries.fold(0.0, |most: f64, x| most.max(x.abs()));
        let known = kept.len().saturating_sub(usize::from(has_events));
        let mut found = eigenvalues(&reduced);
        if found.len() < kept.len() {
            let beyond = Complex {
                re: f64::INFINITY,
                im: 0.0,
            };
            return (vec![beyond; known], f64::INFINITY);
        }
        // On the surface of an event there is no displacement in time.
        found.truncate(known);
        let left = found.len().saturating_sub(self.lost());
        // What the largest rounds away of the others is nothing.
        let mut unknown = ROUNDED * f64::EPSILON * largest;
        let mut is_product_known = false;
        if left == 2 && found.len() == 2 {
            // Two are known by their sum and product, a sum of minors: an eigenvalue that is far smaller than the other, or than entries of the matrix,
            // as those are between impacts with next to no rate, is lost in their rounding.
            unknown *= 2.0 * R::ROUNDOFF / f64::EPSILON;
            if let Some(pair) = with_sum_and_product(trace, self.minors(&kept)) {
                is_product_known = pair[0].modulus() > unknown;
                found = pair.to_vec();
            }
        }
        for (place, value) in found.iter_mut().enumerate() {
            if place >= left || (!is_product_known && value.modulus() <= unknown) {
                *value = Complex::default();
            }
            *value = without_rounding(*value, unknown);
        }
        let shown = ROUNDED * f64::EPSILON;
        (found, (unknown * largest.max(1.0)).max(shown))
    }

    /// Whether an impact has lost its rate: multipliers have a pole there.
    pub(crate) fn grazes(&self) -> bool {
        self.without_rate().is_some()
    }

    /// The first step that ends with such an impact.
    pub(crate) fn without_rate(&self) -> Option<usize> {
        self.slower_than(NO_RATE).first().copied()
    }

    /// Whether that of a step has.
    pub(crate) fn has_lost_rate(&self, index: usize) -> bool {
        self.slower_than(NO_RATE).contains(&index)
    }

    /// The steps with impacts whose rates are no more than a part of the largest or, since all may have lost theirs, of what its acceleration makes
    /// of each in the flight before.
    pub(crate) fn slower_than(&self, part: f64) -> Vec<usize> {
        let impacts = self.rates(|index| self.steps[index].impact().is_some());
        let largest = impacts
            .iter()
            .fold(0.0_f64, |most, (_, rate, _)| most.max(*rate));
        let lost = |&&(_, rate, gained): &&(usize, f64, f64)| rate <= part * largest.max(gained);
        (impacts.iter().filter(lost).map(|(index, ..)| *index)).collect()
    }

    /// Whether nothing happens to displacements at the end of a step, as of the latest evaluation.
    pub(crate) fn is_smooth(&self, index: usize) -> bool {
        self.smooth.get(index).is_some_and(|smooth| *smooth)
    }

    /// Whether a surface is crossed with next to no rate. Where the field jumps there, what the crossing and the way back do to a
    /// displacement are large and all but cancel: multipliers have few digits, or none.
    pub(crate) fn crosses_slowly(&self) -> bool {
        let crossings =
            self.rates(|index| self.steps[index].impact().is_none() && !self.smooth[index]);
        crossings
            .iter()
            .any(|&(_, rate, gained)| rate <= NO_RATE * gained)
    }

    /// The steps of such legs, the rates with which they end, and what accelerations there make in their time.
    fn rates(&self, which: impl Fn(usize) -> bool) -> Vec<(usize, f64, f64)> {
        let legs = (self.steps.iter().zip(&self.latest)).enumerate();
        legs.filter(|(index, (step, _))| step.has_own_time() && which(*index))
            .map(|(index, (_, landing))| {
                let (rate, gained) = rate_and_gain(landing);
                (index, rate, gained)
            })
            .collect()
    }

    /// The sum of the monodromy matrix's minors of two of these columns, and of the rows of the same displacements.
    fn minors(&self, kept: &[usize]) -> R {
        let n = self.workshop.model.states.len();
        let mut product = Matrix::identity(n * (n - 1) / 2);
        for transfer in self.transfers() {
            product = transfer.minors().times(&product);
        }
        let place = |pair: (usize, usize)| pairs(n).position(|other| other == pair);
        let minor = |(i, k): (usize, usize), column: usize| match place((i.min(k), i.max(k))) {
            Some(row) if i < k => product[(row, column)],
            Some(row) => -product[(row, column)],
            None => R::ZERO,
        };
        let closure = &self.workshop.closure;
        let mut sum = R::ZERO;
        for (column, (i, k)) in pairs(n).enumerate() {
            if !(kept.contains(&i) && kept.contains(&k)) {
                continue;
            }
            for (a, times) in closure.displacement(i) {
                for (b, more) in closure.displacement(k) {
                    sum += minor((a, b), column) * R::splat(times * more);
                }
            }
        }
        sum
    }

    /// The phase that turns by itself, where no time does.
    pub(super) fn clock(&self) -> Option<usize> {
        let turns = self
            .workshop
            .closure
            .turns::<f64>(&self.workshop.parameters(&[]))
            .ok()?;
        (turns.iter().zip(&self.counts))
            .find(|(turn, count)| **count != 0 && turn.lap.is_some())
            .map(|(turn, _)| turn.state)
    }

    /// The multiplier along the flow, which is one: how well the derivatives know it. None where time is no state of the
    /// motion.
    pub(crate) fn trivial_multiplier(&mut self, at: &[R]) -> Option<f64> {
        if self.workshop.closure.time.is_some() {
            return None;
        }
        let n = self.workshop.model.states.len();
        let parameters = self.workshop.parameters(self.free(at));
        let mut product = R::ONE;
        // No motion lies between events of one instant.
        for index in (0..self.steps.len()).filter(|&index| !self.steps[index].is_at_once()) {
            let all = self.parameters_of(&parameters, &self.steps[index]);
            let x = &at[self.places[index]..self.places[index] + n];
            let Flown::Leg(leg, flyer) = &self.flown[index] else {
                continue;
            };
            let field = leg.field(&mut self.flyers[*flyer].1, &all, x);
            let landing = self.latest.get(index)?;
            if landing.surface_rate == R::ZERO {
                return None;
            }
            product *= dot(&landing.surface_slopes[..n], &field) / landing.surface_rate;
        }
        Some(product.to_f64())
    }
}

/// Two numbers, the larger first, with this sum and product. None where these are not finite.
fn with_sum_and_product<R: Real>(sum: R, product: R) -> Option<[Complex; 2]> {
    let half = sum * R::splat(0.5);
    let apart = half * half - product;
    if !apart.to_f64().is_finite() {
        return None;
    }
    if apart < R::ZERO {
        let (re, im) = (half.to_f64(), (-apart).sqrt().to_f64());
        return Some([im, -im].map(|im| Complex { re, im }));
    }
    let root = apart.sqrt();
    let larger = if half < R::ZERO {
        half - root
    } else {
        half + root
    };
    let smaller = match larger == R::ZERO {
        true => R::ZERO,
        false => product / larger,
    };
    let real = |x: R| Complex {
        re: x.to_f64(),
        im: 0.0,
    };
    Some([larger, smaller].map(real))
}

/// The rate with which a leg ends, and what acceleration there makes in its time.
fn rate_and_gain<R: Real>(landing: &Landing<R>) -> (f64, f64) {
    let gained = landing.surface_acceleration.abs() * landing.duration;
    (landing.surface_rate.abs().to_f64(), gained.to_f64())
}

/// The derivative of a leg's image by its start, at a given time.
fn at_its_time<R: Real>(landing: &Landing<R>, n: usize) -> Matrix<R> {
    let mut transfer = Matrix::zeros(n, n);
    for i in 0..n {
        transfer
            .row_mut(i)
            .copy_from_slice(&landing.image_slopes.row(i)[..n]);
    }
    transfer
}

/// The same, the event's time taken with it.
pub(super) fn transfer<R: Real>(landing: &Landing<R>, n: usize) -> Matrix<R> {
    let mut transfer = at_its_time(landing, n);
    if landing.surface_rate == R::ZERO {
        return transfer;
    }
    for i in 0..n {
        for (entry, &slope) in transfer
            .row_mut(i)
            .iter_mut()
            .zip(&landing.surface_slopes[..n])
        {
            *entry -= landing.image_rate[i] * slope / landing.surface_rate;
        }
    }
    transfer
}
