//! Columns of derivatives where impacts of several contacts share an instant.
//!
//! A displacement parts what happens at once, and each displacement otherwise. Flights of several contacts that end at one instant end one
//! after the other then, each taking the columns along as an impact of its own does, by the shift of its own time. There is one derivative
//! only if that leads to the same columns whichever of them ends first. Closed contacts that feel an impact collide at the instant of that,
//! displaced or not, and what closes fastest goes first: there is one derivative unless another closes as fast.

use crate::flow::error::FlowError;
use crate::flow::modes::closed::Closed;
use crate::flow::step::Workspace;
use crate::flow::system::System;
use crate::flow::touch::Touch;
use crate::flow::trajectory::Trajectory;
use crate::model::Simultaneous;
use crate::numerics::{Real, WithTerms};

/// A collision that changes another contact's rate by less than this part of its own leaves it as it is.
pub(crate) const UNFELT: f64 = 1e-12;
/// Two that close at rates nearer to each other than this, in parts of them, close at one.
pub(crate) const SAME_RATE: f64 = 1e-9;
/// Derivatives of collisions in two orders that differ by less than this part of their largest entry are one.
pub(crate) const SAME_DERIVATIVE: f64 = 1e-8;
/// The orders of no more flights than this are compared: 24.
const MOST_FLIGHTS: usize = 4;

/// Why the columns are no derivative past an instant at which several contacts touched.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum NoDerivative {
    /// What is displaced otherwise meets its contacts in another order, this one among them, and is taken elsewhere.
    Order(usize),
    /// One impulse vector stops several contacts that feel each other, this one among them.
    Joint(usize),
    /// A vector leaves zero, this surface being its squared length.
    Direction(usize),
}

/// Contacts that touched at an instant, with columns that depend on which of them goes first unless all come to rest in that instant.
#[derive(Clone, Copy, Debug)]
pub(in crate::flow::trajectory) struct Tie<R> {
    contact: usize,
    touching: Closed,
    time: R,
}

impl<R: Real> Trajectory<R> {
    /// What has left the columns without a meaning, if anything has since the start.
    pub(crate) fn no_derivative(&self) -> Option<NoDerivative> {
        let tie = self.tie.filter(|tie| !self.shares_instant(tie));
        (self.no_derivative).or_else(|| tie.map(|tie| NoDerivative::Order(tie.contact)))
    }

    /// The columns are to be others: what has left those before without a meaning does not matter to them.
    pub(crate) fn drop_ties(&mut self) {
        (self.no_derivative, self.tie) = (None, None);
    }

    fn shares_instant(&self, tie: &Tie<R>) -> bool {
        self.time - tie.time <= self.rest_of_burst()
    }

    /// Takes note that columns depend on which of the contacts that touch, this one among them, goes first.
    pub(super) fn note_order(&mut self, contact: usize, touching: Closed) {
        self.no_derivative = self.no_derivative();
        let before = self.tie.filter(|tie| self.shares_instant(tie));
        self.tie = Some(Tie {
            contact,
            touching: Closed(touching.0 | before.map_or(0, |tie| tie.touching.0)),
            time: self.time,
        });
    }

    /// Contacts have come to rest. In whichever order impacts of an instant brought them there, their impulses were the same, which take the
    /// state to where nothing moves at them: but for friction, of which each impact has its own.
    pub(in crate::flow::trajectory) fn settle_order(&mut self, system: &System) {
        let is_void = |tie: &Tie<R>| {
            self.shares_instant(tie) && tie.touching.0 & !self.closed.0 == Closed::NONE.0
        };
        if system.rubbing().is_empty() && self.tie.as_ref().is_some_and(is_void) {
            self.tie = None;
        }
    }

    /// By which law the contacts that touch now collide: where none feels another one collides with each by itself.
    pub(super) fn law_of(&self, touch: &Touch<R>, touching: Closed) -> Simultaneous {
        let felt = |by: usize| {
            let own = touch.rate[by].value;
            touching.contacts().any(|of| {
                of != by && (touch.coupling[of][by] * own).abs() > R::splat(UNFELT) * own.abs()
            })
        };
        match self.carries_columns() && !touching.contacts().any(felt) {
            true => Simultaneous::Binary,
            false => self.law,
        }
    }

    pub(in crate::flow::trajectory) fn carries_columns(&self) -> bool {
        self.state.len() > self.coordinates
    }

    /// The contacts among these whose flights end now.
    pub(super) fn ending(&self, touch: &Touch<R>, touching: Closed) -> Vec<usize> {
        let closes = |&contact: &usize| touch.rate[contact].value < -touch.rate[contact].level();
        let open = Closed(touching.0 & !self.closed.0);
        open.contacts().filter(closes).collect()
    }

    /// The columns, at fixed time, after flights of several contacts have ended at this instant; none if they depend on which of them
    /// ends first.
    pub(super) fn columns_after(
        &self,
        system: &System,
        work: &mut Workspace<R>,
        (flights, touching): (&[usize], Closed),
    ) -> Result<Option<Vec<R>>, FlowError> {
        if flights.len() > MOST_FLIGHTS {
            return Ok(None);
        }
        let mut found: Option<Trajectory<R>> = None;
        for order in orders(flights.len()) {
            let order: Vec<usize> = order.iter().map(|&place| flights[place]).collect();
            let Some(ended) = self.end_in_turn(system, work, (&order, touching))? else {
                return Ok(None);
            };
            match &found {
                Some(first) if !self.agree(first, &ended) => return Ok(None),
                Some(_) => {}
                None => found = Some(ended),
            }
        }
        Ok(found.map(|mut first| first.state.split_off(self.coordinates)))
    }

    /// The flights of these contacts ended one after the other, as where a displacement parts them; none if one of them does not end so,
    /// or the others make it end again.
    fn end_in_turn(
        &self,
        system: &System,
        work: &mut Workspace<R>,
        (order, touching): (&[usize], Closed),
    ) -> Result<Option<Self>, FlowError> {
        let mut moved = self.clone();
        moved.tie = None;
        for &contact in order {
            let touch = moved.touch_values(system)?;
            if moved.ending(&touch, Closed::NONE.with(contact)).is_empty() {
                return Ok(None);
            }
            let meets = moved.closed.with(contact);
            moved.collide(system, work, contact, meets)?;
            while moved.collisions.is_some() {
                moved.collide_on(system, work)?;
            }
        }
        let touch = moved.touch_values(system)?;
        let before = self.touch_values(system)?;
        let rates = touching
            .contacts()
            .map(|contact| before.rate[contact].value.abs());
        let rounding = WithTerms::exact(rates.fold(R::ZERO, R::max)).level();
        let closes =
            |contact: usize| touch.rate[contact].value < -rounding.max(touch.rate[contact].level());
        let is_over = !touching.contacts().any(closes)
            && moved.no_derivative.is_none()
            && moved.tie.is_none();
        Ok(is_over.then_some(moved))
    }

    /// Whether two ways through an instant have led to the same columns, each coordinate against its own size there and before.
    fn agree(&self, one: &Self, other: &Self) -> bool {
        let n = self.coordinates;
        let columns = |of: &Self| of.state[n..].to_vec();
        let (before, one, other) = (columns(self), columns(one), columns(other));
        (0..n).all(|i| {
            let row = |of: &[R]| -> Vec<R> { of.iter().skip(i).step_by(n).copied().collect() };
            let (before, one, other) = (row(&before), row(&one), row(&other));
            let all = before.iter().chain(&one).chain(&other);
            let size = all.fold(R::ZERO, |size, x| size.max(x.abs()));
            let bound = size * R::splat(SAME_DERIVATIVE);
            (one.iter().zip(&other)).all(|(&a, &b)| (a - b).abs() <= bound)
        })
    }

    /// Takes note where a collision of a contact that was struck by no flight of its own could come after another one as well: from the
    /// rates before and after it.
    pub(super) fn note_tie(
        &mut self,
        contact: usize,
        touching: Closed,
        rates: (&Touch<R>, &Touch<R>),
    ) {
        let (before, after) = rates;
        let own = -before.rate[contact].value;
        let ties = |other: usize| {
            let (was, is) = (before.rate[other].value, after.rate[other].value);
            let is_felt = (is - was).abs() > R::splat(UNFELT) * own.abs();
            other != contact && is_felt && own + was.min(R::ZERO) <= R::splat(SAME_RATE) * own
        };
        if touching.contacts().any(ties) {
            self.note_order(contact, touching);
        }
    }
}

/// All orders of so many.
pub(crate) fn orders(count: usize) -> Vec<Vec<usize>> {
    let mut all: Vec<Vec<usize>> = vec![Vec::new()];
    for next in 0..count {
        let insert = |order: &Vec<usize>| -> Vec<Vec<usize>> {
            let at = |place: usize| {
                let mut longer = order.clone();
                longer.insert(place, next);
                longer
            };
            (0..=order.len()).map(at).collect()
        };
        all = all.iter().flat_map(insert).collect();
    }
    all
}
