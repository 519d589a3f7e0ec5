//! How fast a sequence of impacts has slowed down, and so how long it may still take.

use crate::numerics::Real;

/// Impacts remembered for each contact: enough to span those of another that come between.
pub(crate) const REMEMBERED: usize = 8;

/// The estimate takes a sequence for one that slows down by this factor at least over the impacts remembered.
const SLOWEST: f64 = 0.9;

/// Flights no longer than so many roundoffs of the time are none.
const TIME_ROUNDOFFS: f64 = 8.0;

/// Flights of a collapse whose factors say what it comes to, and how many times as far as their latest change lets expect these may go.
const FLIGHTS_COMPARED: usize = 3;
const FACTOR_MARGIN: f64 = 3.0;

/// The latest impacts of one contact.
#[derive(Clone, Debug)]
struct Recent<R> {
    /// Times, and how long the contact's own sequence would last from there to leading order.
    impacts: [(R, R); REMEMBERED],
    count: usize,
}

impl<R: Real> Recent<R> {
    const NONE: Self = Self {
        impacts: [(R::ZERO, R::ZERO); REMEMBERED],
        count: 0,
    };
}

/// The latest impacts of each contact. Those of the first stand with the trajectory: mostly there is no other, and another
/// place in memory costs more than what is done there.
#[derive(Clone, Debug)]
pub(super) struct Pace<R> {
    first: Recent<R>,
    others: Vec<Recent<R>>,
}

impl<R: Real> Pace<R> {
    pub(super) fn new() -> Self {
        Self {
            first: Recent::NONE,
            others: Vec::new(),
        }
    }

    /// Takes note of an impact.
    #[inline(always)]
    pub(super) fn observe(&mut self, contact: usize, time: R, rest: R) {
        let recent = self.recent(contact);
        recent.impacts[recent.count % REMEMBERED] = (time, rest);
        recent.count += 1;
    }

    /// Counts impacts that would not be remembered any more.
    #[inline(always)]
    pub(super) fn pass_over(&mut self, contact: usize, impacts: usize) {
        self.recent(contact).count += impacts;
    }

    #[inline(always)]
    fn recent(&mut self, contact: usize) -> &mut Recent<R> {
        match contact {
            0 => &mut self.first,
            _ => self.other(contact - 1),
        }
    }

    fn other(&mut self, index: usize) -> &mut Recent<R> {
        if self.others.len() <= index {
            self.others.resize(index + 1, Recent::NONE);
        }
        &mut self.others[index]
    }

    /// How long the impacts of a contact may still go on, at most, that nothing but those of others brings about: flights between its
    /// own become shorter by a factor that changes from one to the next. `Err` where it may come to exceed one, so that they need not
    /// end; nothing where fewer than two are remembered, or what was hit since falls back by itself.
    pub(super) fn rest_of_collapse(&self, contact: usize, forever: R) -> Result<R, ()> {
        let recent = match contact {
            0 => Some(&self.first),
            _ => self.others.get(contact - 1),
        };
        let Some(recent) = recent.filter(|recent| recent.count > 1) else {
            return Ok(R::ZERO);
        };
        let at = |back: usize| recent.impacts[(recent.count - 1 - back) % REMEMBERED];
        // What falls back by itself comes to rest, and what bounces on it with it.
        let compared = (recent.count.min(REMEMBERED) - 1).min(FLIGHTS_COMPARED);
        let falls_back = |other: &Recent<R>| {
            let (then, rest) = other.impacts[other.count.wrapping_sub(1) % REMEMBERED];
            other.count > 0 && then >= at(compared).0 && rest < forever
        };
        if falls_back(&self.first) || self.others.iter().any(falls_back) {
            return Ok(R::ZERO);
        }
        let flights: Vec<R> = (0..compared)
            .map(|back| at(back).0 - at(back + 1).0)
            .collect();
        let rounding = at(0).0.abs() * R::splat(TIME_ROUNDOFFS * R::ROUNDOFF);
        if flights[0] <= rounding {
            return Ok(rounding);
        }
        // What was met a few times and moves along by now is no collapse, and of more than two contacts flights take turns.
        let met = |other: &&Recent<R>| {
            let (then, _) = other.impacts[other.count.wrapping_sub(1) % REMEMBERED];
            other.count > 0 && then >= at(compared).0
        };
        let all = core::iter::once(&self.first).chain(&self.others);
        let together = all.filter(met).count();
        let open = || match recent.count < REMEMBERED || together > 2 {
            true => Ok(flights[0]),
            false => Err(()),
        };
        let factor = match flights[..] {
            [latest] => return Ok(latest),
            [latest, before] => latest / before,
            [latest, before, first, ..] => {
                let (factor, earlier) = (latest / before, before / first);
                if factor >= R::ONE {
                    return open();
                }
                // Factors of a linear sequence converge as its flights do.
                let still = (factor - earlier).abs() * factor / (R::ONE - factor);
                still.mul_add(R::splat(FACTOR_MARGIN), factor)
            }
            [] => R::ZERO,
        };
        let ends = factor < R::ONE && flights[0] <= flights[flights.len() - 1];
        if ends {
            Ok(flights[0] * factor / (R::ONE - factor))
        } else {
            open()
        }
    }

    /// How long the impacts of a contact may still go on: what its own sequence would take, or, where others come between
    /// and slow it down less, what the impacts remembered would if they went on like this. Nothing where the latest impact
    /// is followed by none.
    pub(super) fn rest(&self, contact: usize, forever: R) -> R {
        let recent = match contact {
            0 => Some(&self.first),
            _ => self.others.get(contact - 1),
        };
        let Some(recent) = recent.filter(|recent| recent.count > 0) else {
            return R::ZERO;
        };
        let (now, rest) = recent.impacts[(recent.count - 1) % REMEMBERED];
        if rest >= forever {
            return R::ZERO;
        }
        let oldest = recent.count.saturating_sub(REMEMBERED);
        let (then, before) = recent.impacts[oldest % REMEMBERED];
        if before <= rest || before >= forever {
            return rest;
        }
        let share = (rest / before).min(R::splat(SLOWEST));
        rest.max((now - then) * share / (R::ONE - share))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn geometric_and_nested_sequences_end_when_estimated() {
        // A sequence of its own: each flight is 0.7 of the one before.
        let (mut pace, mut time, mut flight) = (Pace::new(), 3.0, 0.1);
        for _ in 0..20 {
            pace.observe(1, time, flight / 0.3);
            time += flight;
            flight *= 0.7;
        }
        let end = 3.0 + 0.1 / 0.3;
        let latest = time - flight / 0.7;
        let rest: f64 = pace.rest(1, 1e30);
        assert!((rest / (end - latest) - 1.0).abs() < 1e-9, "{rest}");
        // Impacts that others keep going: their own flights say a tenth of what is left.
        let mut pace = Pace::new();
        for k in 0..20 {
            let left = f64::powi(0.8, k);
            pace.observe(0, 5.0 - left, 0.1 * left);
        }
        let rest: f64 = pace.rest(0, 1e30);
        assert!((rest / f64::powi(0.8, 19) - 1.0).abs() < 1e-9, "{rest}");
        assert!(pace.rest(2, 1e30) == 0.0);
    }
}
