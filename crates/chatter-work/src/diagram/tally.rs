//! How many orbits of a diagram settled to which attractor.

use super::source::{Class, Source};
use crate::refusal::Refusal;
use chatter::analysis::diagram::Outcome;
use std::collections::BTreeMap;

/// The rows of a diagram by attractor.
pub struct Tally {
    /// The attractor of each row.
    pub numbers: Vec<u32>,
    /// The attractors that there are, by number.
    pub shares: Vec<Share>,
}

/// The rows of the attractors of one number.
#[derive(Clone, Debug)]
pub struct Share {
    /// The number; zero for rows that settled to none.
    pub attractor: u32,
    /// How many rows.
    pub rows: u64,
    /// Part of all rows.
    pub part: f64,
    /// What they settled to, where all settled to the same.
    pub outcome: Option<Outcome>,
    /// Their period, where all have the same; zero for none.
    pub period: Option<u64>,
    /// Mean number of impacts from sample to sample, where it is the same for all.
    pub impacts_per_return: Option<f64>,
}

impl Tally {
    /// Counts rows.
    pub fn of<S: Source + ?Sized>(source: &mut S) -> Result<Self, Refusal> {
        let mut numbers = Vec::new();
        let mut shares = BTreeMap::new();
        source.classes(&mut |_, class| {
            numbers.push(class.attractor);
            let share = shares.entry(class.attractor);
            share
                .and_modify(|share: &mut Share| share.join(class))
                .or_insert_with(|| Share::first(class));
        })?;
        let mut shares: Vec<Share> = shares.into_values().collect();
        for share in &mut shares {
            share.part = share.rows as f64 / numbers.len() as f64;
        }
        Ok(Self { numbers, shares })
    }

    /// Whether there is more than one attractor.
    pub fn several(&self) -> bool {
        self.shares.iter().any(|share| share.attractor > 1)
    }
}

impl Share {
    fn first(class: &Class) -> Self {
        Self {
            attractor: class.attractor,
            rows: 1,
            part: 0.0,
            outcome: Some(class.outcome),
            period: Some(class.period),
            impacts_per_return: Some(class.impacts_per_return),
        }
    }

    fn join(&mut self, class: &Class) {
        self.rows += 1;
        self.outcome = self.outcome.filter(|known| *known == class.outcome);
        self.period = self.period.filter(|known| *known == class.period);
        let same = |known: &f64| known.to_bits() == class.impacts_per_return.to_bits();
        self.impacts_per_return = self.impacts_per_return.filter(same);
    }

    /// What it is, in a few words, if that is the same for all its rows.
    pub fn what(&self) -> Option<String> {
        let outcome = self.outcome?.name().replace('_', " ");
        Some(match (self.outcome?, self.period) {
            (Outcome::Periodic, Some(period)) => format!("period {period}"),
            (Outcome::CompleteChatter, Some(period)) if period > 0 => {
                format!("{outcome}, period {period}")
            }
            _ => outcome,
        })
    }

    /// What a legend calls it.
    pub fn label(&self) -> String {
        let name = match (self.attractor, self.what()) {
            (0, Some(what)) => what,
            (0, None) => "none".to_owned(),
            (number, Some(what)) => format!("{number}: {what}"),
            (number, None) => format!("attractor {number}"),
        };
        format!("{name}, {}", percent(self.part))
    }
}

/// A part as it is told.
pub fn percent(part: f64) -> String {
    format!("{:.1} %", 100.0 * part)
}
