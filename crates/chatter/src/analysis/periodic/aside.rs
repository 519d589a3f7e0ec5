//! Orbits beside one whose equations are singular: displaced along what the singular matrix takes to zero, once or twice around.

use super::cycle::rotate::a_turn_later;
use super::shooting::Shooting;
use crate::analysis::continuation::{Condition, Problem, Singular, newton};
use crate::numerics::dot;

/// Equations of an orbit aside, a guess of it, and the row that tells how far aside it is.
pub(crate) struct Aside {
    pub shooting: Shooting<f64>,
    pub guess: Vec<f64>,
    row: Vec<f64>,
}

impl Aside {
    /// Displaced so far, against the size of the orbit; twice around where the cycle closes with the other sign.
    pub(crate) fn new(
        shooting: &Shooting<f64>,
        at: &[f64],
        singular: &Singular<f64>,
        far: f64,
    ) -> Option<Self> {
        let size = at.len() - shooting.parameters();
        let direction = singular.direction();
        // Along a curve an orbit may have outgrown the sizes that steps are measured against.
        let sizes = shooting.scales().iter().zip(at);
        let reach = (direction.iter().zip(sizes)).fold(0.0_f64, |most, (x, (scale, here))| {
            most.max(x.abs() / scale.max(here.abs()))
        });
        let by = far / reach;
        let moved = |sign: f64| -> Vec<f64> {
            let displaced = (at[..size].iter().zip(direction)).map(|(x, v)| x + sign * by * v);
            displaced.chain(at[size..].iter().copied()).collect()
        };
        let mut steps = shooting.current_steps(&moved(1.0));
        let mut counts = shooting.counts.clone();
        let mut guess = moved(1.0)[..size].to_vec();
        let mut row = direction.to_vec();
        if singular.sign() < 0.0 {
            let parameters = shooting.workshop.parameters(shooting.free(at));
            let second = (&*shooting.current_steps(&moved(-1.0)), &*shooting.counts);
            steps.extend(a_turn_later(&shooting.workshop, &parameters, second).ok()?);
            counts.iter_mut().for_each(|count| *count *= 2);
            let mut second = moved(-1.0)[..size].to_vec();
            shooting.turn_on(&mut second, at);
            guess.extend(second);
            row.extend(direction.iter().map(|v| -v));
        }
        guess.extend(&at[size..]);
        row.resize(guess.len(), 0.0);
        let mut beside = Shooting::new(&shooting.workshop, steps, counts).ok()?;
        beside.take_sizes(&shooting.state_sizes());
        Some(Self {
            shooting: beside,
            guess,
            row,
        })
    }

    /// The orbit so far aside, where these rows of the free parameters keep their products.
    pub(crate) fn close(&mut self, held: &[Vec<f64>]) -> Option<Vec<f64>> {
        let mut rows = vec![self.row.clone()];
        for parameters in held {
            let mut row = vec![0.0; self.guess.len() - parameters.len()];
            row.extend(parameters);
            rows.push(row);
        }
        let conditions: Vec<Condition<f64>> = (rows.into_iter())
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

/// So far aside are the orbits that tell to which side a branch leaves, half and a quarter of it: what is left of the next two orders
/// is taken out of all three. Nearer ones do where the farther are none.
const FAR: [f64; 2] = [2e-2, 6e-3];
/// Their parameters are known to so many roundoffs.
const ROUNDOFFS: f64 = 64.0;

/// How far the parameters of the orbits beside a singular one lie along a row, at the parameters that hold the other rows, and what
/// that may be off by: in parts of the square of how far aside they are. Positive where the branch that leaves goes along the row.
pub(crate) fn shift(
    shooting: &Shooting<f64>,
    at: &[f64],
    singular: &Singular<f64>,
    (along, held): (&[f64], &[Vec<f64>]),
) -> Option<(f64, f64)> {
    let free = shooting.parameters();
    let here = dot(along, &at[at.len() - free..]);
    let of = |far: f64| {
        let mut aside = Aside::new(shooting, at, singular, far)?;
        let found = aside.close(held)?;
        Some((dot(along, &found[found.len() - free..]) - here) / (far * far))
    };
    let sizes = (at.iter().zip(shooting.scales())).skip(at.len() - free);
    let size: f64 = (along.iter().zip(sizes))
        .map(|(by, (x, scale))| (by * x.abs().max(*scale)).abs())
        .sum();
    FAR.into_iter().find_map(|far| {
        let error = ROUNDOFFS * f64::EPSILON * size / (0.25 * far).powi(2);
        let [far, half, quarter] = [of(far)?, of(0.5 * far)?, of(0.25 * far)?];
        let (once, again) = ((4.0 * half - far) / 3.0, (4.0 * quarter - half) / 3.0);
        Some(((16.0 * again - once) / 15.0, error))
    })
}
