//! Corners at which the event at the end of a step has slopes without bound, as where the root of Nordmark's map begins. Steps towards one from its
//! side come to nothing, and beyond it the root is nothing: the equations of the other piece, which hold at the corner as well, say where it is.

use crate::analysis::continuation::{Problem, Station};
use crate::analysis::periodic::branch::limits::End;
use crate::analysis::periodic::branch::walker::Walker;
use crate::analysis::periodic::branch::{Point, SpecialKind};
use crate::analysis::periodic::shooting::Shooting;
use crate::flow::GuardKind;
use crate::numerics::dot;

/// Slopes without bound grow by more than this part from here, in parts of the sizes of unknowns, to so much nearer to the corner.
const GROWS: f64 = 1e-3;
const STEEP: f64 = 1e-10;
const NEARER: f64 = 1e-2;
/// Where steps come to nothing the corner is no farther away than this part of the size of what vanishes there.
const BESIDE: f64 = 1e-6;
/// Beside the corner a root is no more than this part of the sizes of states, as the root of rounding is.
const OF_ROUNDING: f64 = 1e-3;

impl Walker {
    /// How the branch ends where steps come to nothing beside such a corner.
    pub(in crate::analysis::periodic::branch) fn ends_beside_root(
        &mut self,
        station: &Station,
        here: &Point,
    ) -> Option<End> {
        self.settle(station);
        let least = self.shooting.least(&station.at).ok()?;
        let mut near = Vec::new();
        for (index, least) in least.iter().enumerate() {
            let at_end = least.iter().filter(|least| least.at_end);
            let beside = at_end.filter(|least| least.value.abs() <= BESIDE * least.size);
            let asked = beside.filter(|least| self.shooting.asks(index, least.guard));
            near.extend(asked.map(|least| (index, least.guard)));
        }
        let end = { near.into_iter() }
            .find_map(|(index, guard)| self.ends_at_root(&station.at, (index, guard), here));
        if end.is_none() {
            self.settle(station);
        }
        end
    }

    /// How the branch ends where, next to this place, the event at the end of a step comes to a corner that it asks for, if its slopes have no bound
    /// there. It is told by the equations of the piece that goes on smoothly.
    pub(super) fn ends_at_root(
        &mut self,
        at: &[f64],
        (index, guard): (usize, GuardKind),
        there: &Point,
    ) -> Option<End> {
        let back = guard.opposite()?;
        let mut own = self.shooting.clone();
        let beyond = own.beyond_corners(at, (index, &[guard])).ok()?;
        let mut other = beyond.shooting;
        let steep = [
            own.is_steep(at, (index, guard)),
            other.is_steep(&beyond.at, (beyond.step, back)),
        ];
        let comes_from_it = match steep {
            [_, true] => false,
            [true, false] => true,
            [false, false] => return None,
        };
        let (mut smooth, start, place) = match comes_from_it {
            true => (other, &*beyond.at, (beyond.step, back)),
            false => (own, at, (index, guard)),
        };
        let met = smooth.at_corner(start, place).ok()?;
        let across = smooth.beyond_corners(&met.at, (place.0, &[place.1]));
        if across.ok()?.jump > OF_ROUNDING {
            return None;
        }
        let named = self.shooting.workshop.named(guard);
        self.shooting = smooth;
        let told = (met.error, met.residual);
        self.note(SpecialKind::Touch, there, &met.told, told.0, told.1);
        self.tell_no_multipliers();
        if !comes_from_it {
            let last = there.moved(&mut self.shooting, &met.at);
            self.points.push(last);
        }
        Some(End::Lost(format!(
            "event {index} of the orbit comes at {named}, where its slopes have no bound"
        )))
    }
}

impl Shooting<f64> {
    /// Whether slopes of the event at the end of a step have no bound at a corner next to this place.
    fn is_steep(&mut self, at: &[f64], (index, guard): (usize, GuardKind)) -> bool {
        if self.watch_corner(index, guard).is_err() {
            return false;
        }
        let both = self
            .slopes_inside(at, index, NEARER * STEEP)
            .zip(self.slopes_inside(at, index, STEEP));
        both.is_some_and(|(near, far)| {
            let mut pairs = near.iter().zip(&far);
            pairs.any(|(near, far)| near - far > GROWS * (1.0 + far))
        })
    }

    /// The sizes of the slopes so far inside the corner that is watched, in parts of the sizes of unknowns.
    fn slopes_inside(&mut self, at: &[f64], index: usize, part: f64) -> Option<Vec<f64>> {
        let (_, gradient) = self.monitor(self.corner_function(), at).ok()?;
        let scales = self.scales().to_vec();
        let measured: Vec<f64> = gradient.iter().zip(&scales).map(|(x, s)| x * s).collect();
        let length = dot(&measured, &measured).sqrt();
        let parts = at.iter().zip(&scales).zip(&measured);
        let inside: Vec<f64> = parts
            .map(|((x, scale), along)| x + part * scale * along / length)
            .collect();
        self.evaluate(&inside).ok()?;
        let (slopes, sizes) = (&self.latest[index].image_slopes, self.state_sizes());
        let free = &scales[at.len() - self.workshop.free.len()..];
        let columns: Vec<f64> = sizes.iter().chain(free).copied().collect();
        let mut found = Vec::with_capacity(sizes.len() * columns.len());
        for (i, size) in sizes.iter().enumerate() {
            let row = columns.iter().enumerate();
            found.extend(row.map(|(k, by)| (slopes[(i, k)] * by / size).abs()));
        }
        Some(found)
    }
}
