//! Orbits beside one whose equations are singular: displaced along what the singular matrix takes to zero, once or twice around.

use super::cycle::rotate::a_turn_later;
use super::multipliers::without_nearest;
use super::shooting::Shooting;
use crate::analysis::continuation::{Condition, Held, Problem, Singular, newton};
use crate::numerics::{DoubleDouble, Real, dot};

/// Equations of an orbit aside, a guess of it, and the row that tells how far aside it is.
pub(crate) struct Aside<R: Real> {
    pub shooting: Shooting<R>,
    pub guess: Vec<R>,
    row: Vec<R>,
}

impl<R: Real> Aside<R> {
    /// Displaced so far, against the size of the orbit; twice around where the cycle closes with the other sign.
    pub(crate) fn new(
        shooting: &Shooting<R>,
        at: &[R],
        singular: &Singular<R>,
        far: f64,
    ) -> Option<Self> {
        let size = at.len() - shooting.parameters();
        let direction = singular.direction();
        // Along a curve an orbit may have outgrown the sizes that steps are measured against.
        let sizes = shooting.scales().iter().zip(at);
        let reach = (direction.iter().zip(sizes)).fold(0.0_f64, |most, (x, (scale, here))| {
            most.max(x.abs().to_f64() / scale.max(here.abs().to_f64()))
        });
        let by = far / reach;
        let moved = |sign: f64| -> Vec<R> {
            let by = R::splat(sign * by);
            let displaced = (at[..size].iter().zip(direction)).map(|(&x, &v)| x + by * v);
            displaced.chain(at[size..].iter().copied()).collect()
        };
        let mut steps = shooting.current_steps(&moved(1.0));
        let mut counts = shooting.counts.clone();
        let mut guess = moved(1.0)[..size].to_vec();
        let mut row = direction.to_vec();
        if singular.sign() < 0.0 {
            let free: Vec<f64> = shooting.free(at).iter().map(|p| p.to_f64()).collect();
            let parameters = shooting.workshop.parameters(&free);
            let second = (&*shooting.current_steps(&moved(-1.0)), &*shooting.counts);
            steps.extend(a_turn_later(&shooting.workshop, &parameters, second).ok()?);
            counts.iter_mut().for_each(|count| *count *= 2);
            let mut second = moved(-1.0)[..size].to_vec();
            shooting.turn_on(&mut second, at);
            guess.extend(second);
            row.extend(direction.iter().map(|&v| -v));
        }
        guess.extend(&at[size..]);
        row.resize(guess.len(), R::ZERO);
        let mut beside = Shooting::new(&shooting.workshop, steps, counts).ok()?;
        beside.take_sizes(&shooting.state_sizes());
        Some(Self {
            shooting: beside,
            guess,
            row,
        })
    }

    /// The orbit so far aside, where these rows of the free parameters keep their products.
    pub(crate) fn close(&mut self, held: &[Vec<f64>]) -> Option<Vec<R>> {
        let mut rows = vec![self.row.clone()];
        rows.extend(held.iter().map(|row| of_parameters(row, self.guess.len())));
        let conditions: Vec<Condition<R>> = (rows.into_iter())
            .map(|row| Condition {
                value: dot(&row, &self.guess),
                row,
            })
            .collect();
        let found = newton(&mut self.shooting, &self.guess, &conditions).ok()?;
        self.shooting.adopt(&found.at);
        Some(found.at)
    }
}

/// A row of the free parameters as one of all unknowns.
fn of_parameters<R: Real>(row: &[f64], unknowns: usize) -> Vec<R> {
    let mut all = vec![R::ZERO; unknowns - row.len()];
    all.extend(row.iter().map(|&x| R::splat(x)));
    all
}

/// So far aside are the orbits that tell to which side a branch leaves, half and a quarter of it: what is left of the next two orders
/// is taken out of all three. Nearer ones do where the farther are none, or say too little.
const FAR: [f64; 3] = [2e-2, 6e-3, 2e-3];
/// Where another multiplier is near to the first the square of how far aside they are is this part of how near: else both branches are one.
const ALONE: f64 = 1e-2;
/// In longer numbers they are so near that no further order is left, and yet known.
const NEAR: [f64; 1] = [1e-6];
/// Their parameters are known to so many roundoffs, and in longer numbers, of which there are enough, to so many.
const ROUNDOFFS: f64 = 128.0;
const ROUNDOFFS_LONG: f64 = 65536.0;
/// Extrapolation may be off by so many times what is between the two that it begins from: were what the three distances tell an error of
/// the place alone, which grows by a factor of four from each to the next in parts of their squares, it would be less than that.
const EXTRAPOLATED: f64 = 8.0;
/// Where no further order is left they differ by errors of the place alone, and as they come these may all but agree.
const EXTRAPOLATED_LONG: f64 = 64.0;

/// How far the parameters of the orbits beside a singular one lie along a row, at the parameters that hold the other rows: in parts of
/// the square of how far aside they are, positive where the branch that leaves goes along the row. None where that is no more than what it
/// may be off by. What doubles do not tell longer numbers are asked for.
pub(crate) fn shift(
    shooting: &Shooting<f64>,
    at: &[f64],
    singular: &Singular<f64>,
    (along, held): (&[f64], &[Vec<f64>]),
) -> Option<f64> {
    let others = beside((shooting, at), singular.sign());
    let farthest = others.map_or(FAR[0], |off| (ALONE * off).sqrt());
    let distances = FAR.map(|far| far.min(farthest));
    let roughly = shift_of(
        (shooting, at),
        singular,
        (along, held),
        (&distances, ROUNDOFFS, EXTRAPOLATED),
    );
    roughly.or_else(|| fine_shift((shooting, at), singular.sign(), (along, held)))
}

/// How far from that sign the multiplier nearest to it is, beside the one that is it.
fn beside((shooting, at): (&Shooting<f64>, &[f64]), sign: f64) -> Option<f64> {
    let mut shooting = shooting.clone();
    shooting.evaluate(at).ok()?;
    let others = without_nearest(&shooting.multipliers(), sign);
    let off = others.iter().map(|m| (m.re - sign).hypot(m.im));
    off.min_by(f64::total_cmp)
}

/// The same of the solution nearby in numbers of thirty digits: the singular orbit, too, has to be known as well as those beside it.
fn fine_shift(
    (shooting, at): (&Shooting<f64>, &[f64]),
    sign: f64,
    (along, held): (&[f64], &[Vec<f64>]),
) -> Option<f64> {
    let mut fine = shooting.in_longer_numbers(at).ok()?;
    let start: Vec<DoubleDouble> = at.iter().map(|&x| x.into()).collect();
    let rows = held.iter().map(|row| {
        let row: Vec<DoubleDouble> = of_parameters(row, at.len());
        Condition {
            value: dot(&row, &start),
            row,
        }
    });
    let rows: Vec<_> = rows.collect();
    let singular = Singular::near(&mut fine, &start, sign).ok()?;
    let mut there = Held::singular(&mut fine, singular);
    let found = newton(&mut there, &start, &rows).ok()?;
    let singular = Singular::near(&mut fine, &found.at, sign).ok()?;
    let near = (&NEAR[..], ROUNDOFFS_LONG, EXTRAPOLATED_LONG);
    shift_of((&fine, &found.at), &singular, (along, held), near)
}

/// The shift from the first of these distances that there are orbits at whose shift is more than it may be off by.
fn shift_of<R: Real>(
    (shooting, at): (&Shooting<R>, &[R]),
    singular: &Singular<R>,
    (along, held): (&[f64], &[Vec<f64>]),
    (distances, roundoffs, extrapolated): (&[f64], f64, f64),
) -> Option<f64> {
    let along: Vec<R> = along.iter().map(|&x| R::splat(x)).collect();
    let free = shooting.parameters();
    let here = dot(&along, &at[at.len() - free..]);
    let of = |far: f64| {
        let mut aside = Aside::new(shooting, at, singular, far)?;
        let found = aside.close(held)?;
        let there = dot(&along, &found[found.len() - free..]);
        Some((there - here).to_f64() / (far * far))
    };
    let sizes = (at.iter().zip(shooting.scales())).skip(at.len() - free);
    let size: f64 = (along.iter().zip(sizes))
        .map(|(by, (x, scale))| (by.to_f64() * x.to_f64().abs().max(*scale)).abs())
        .sum();
    distances.iter().find_map(|&far| {
        let rounding = roundoffs * R::ROUNDOFF * size / (0.25 * far).powi(2);
        let [far, half, quarter] = [of(far)?, of(0.5 * far)?, of(0.25 * far)?];
        let (once, again) = ((4.0 * half - far) / 3.0, (4.0 * quarter - half) / 3.0);
        let by = (16.0 * again - once) / 15.0;
        let error = rounding + extrapolated * (again - once).abs();
        (by.abs() > error).then_some(by)
    })
}
