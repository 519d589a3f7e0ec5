//! Binary collisions in numbers: rates, and impulses that change them by constant amounts.

use crate::flow::touch::Touch;
use crate::numerics::{Real, WithTerms};

/// Contacts that touch, their rates, and what collisions have done to them so far.
#[derive(Clone, Debug)]
pub(super) struct Cascade<R> {
    rates: Vec<R>,
    restitutions: Vec<R>,
    /// Row i, column j: what an impulse at j that changes its own rate by one does to the rate of i.
    block: Vec<Vec<R>>,
    /// What cannot be told from zero by the terms of a rate.
    levels: Vec<R>,
    /// The greatest rates so far.
    greatest: Vec<R>,
    /// The change of its own rate that each contact made so far.
    pub impulses: Vec<R>,
    /// How many collisions there were.
    pub count: u64,
}

impl<R: Real> Cascade<R> {
    pub(super) fn new(touch: &Touch<R>, contacts: &[usize], greatest: &[R]) -> Self {
        let of = |value: &dyn Fn(usize) -> R| contacts.iter().map(|&i| value(i)).collect();
        Self {
            rates: of(&|i| touch.rate[i].value),
            restitutions: of(&|i| touch.restitution[i].value),
            block: touch.block(contacts),
            levels: of(&|i| touch.rate[i].level()),
            greatest: of(&|i| greatest[i].max(touch.rate[i].value.abs())),
            impulses: vec![R::ZERO; contacts.len()],
            count: 0,
        }
    }

    /// One contact collides.
    pub(super) fn collide(&mut self, contact: usize) {
        let push = -((R::ONE + self.restitutions[contact]) * self.rates[contact]);
        self.impulses[contact] += push;
        for (rate, row) in self.rates.iter_mut().zip(&self.block) {
            *rate = row[contact].mul_add(push, *rate);
        }
        for (greatest, rate) in self.greatest.iter_mut().zip(&self.rates) {
            *greatest = greatest.max(rate.abs());
        }
        self.count += 1;
    }

    /// The contact that closes fastest, the first of equals; none if no rate can be told from what does not close.
    pub(super) fn fastest_closing(&self) -> Option<usize> {
        let mut fastest: Option<usize> = None;
        for (contact, &rate) in self.rates.iter().enumerate() {
            let level = self.levels[contact].max(WithTerms::exact(self.greatest[contact]).level());
            if rate < -level && fastest.is_none_or(|other| rate < self.rates[other]) {
                fastest = Some(contact);
            }
        }
        fastest
    }

    pub(super) fn greatest(&self) -> &[R] {
        &self.greatest
    }

    /// Goes on until no contact closes any more. Returns whether there is such an end within so many collisions.
    pub(super) fn carry_on(&mut self, most: u64) -> bool {
        while let Some(fastest) = self.fastest_closing() {
            if self.count >= most {
                return false;
            }
            self.collide(fastest);
        }
        true
    }
}
