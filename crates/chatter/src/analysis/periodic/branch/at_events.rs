//! Stations that are the point of an event as far as that is known: there multipliers, which have a pole or a root at it, are made of rounding.

use super::walker::Walker;
use super::{Near, Point, Special, SpecialKind};

impl Walker {
    /// Leaves them out, but for the last station, which tells where the side ends.
    pub(super) fn leave_out_events(&mut self) {
        let sizes = self.greatest_states();
        let count = self.points.len();
        let mut is_out = vec![false; count];
        let singular = |special: &&Special| {
            let kind = special.kind;
            kind.is_graze() || matches!(kind, SpecialKind::Touch | SpecialKind::ChatterBorder)
        };
        for special in self.special.iter().filter(singular) {
            let is_it = |place: &usize| self.is_of(special, &self.points[*place], &sizes);
            let place = special.place.min(count);
            let beside = (0..place).rev().take_while(is_it);
            for place in beside.chain((place..count).take_while(is_it)) {
                is_out[place] = place + 1 < count;
            }
        }
        let mut left = 0;
        let mut before: Vec<usize> = Vec::with_capacity(count + 1);
        for &out in &is_out {
            before.push(left);
            left += usize::from(out);
        }
        before.push(left);
        for special in &mut self.special {
            special.place -= before[special.place.min(count)];
        }
        let mut places = is_out.iter();
        self.points.retain(|_| places.next() != Some(&true));
    }

    /// Whether an orbit is that of a special point: its parameter is no farther away than that may be off by, and its states, which may be far
    /// from each other at one value of the parameter, are as near as those of one point.
    fn is_of(&self, special: &Special, point: &Point, sizes: &[f64]) -> bool {
        let off = (point.parameter() - special.point.parameter()).abs();
        let workshop = &self.shooting.workshop;
        let parameters = workshop.parameters(&special.point.parameters);
        let Ok(turns) = workshop.closure.turns(&parameters) else {
            return false;
        };
        let states = (&*special.point.state, &*point.state);
        off <= special.error
            && workshop.closure.difference(&turns, states, sizes).distance
                <= Near::known(special, special).state
    }

    /// The greatest values of states along the side.
    fn greatest_states(&self) -> Vec<f64> {
        let states = self.shooting.workshop.model.states.len();
        let greatest = |state: usize| {
            let all = self.points.iter().map(|point| point.state[state].abs());
            all.fold(f64::MIN_POSITIVE, f64::max)
        };
        (0..states).map(greatest).collect()
    }
}
