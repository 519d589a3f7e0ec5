//! Ends at which the equations are singular, extrapolated from where they are not.

use super::follower::Follower;
use super::stay_end::KNOWN;
use crate::analysis::continuation::{Problem, Station};
use crate::analysis::periodic::branch::{Broken, interpolated, moved};
use crate::analysis::periodic::condition::Bordered;

/// So many solutions at a time: the polynomial goes through these.
const AT_A_TIME: usize = 6;
/// Solutions on the way to an end, each half as far from there as the one before.
const STATIONS: i32 = 13;
/// A station that differs from what is extrapolated by no more than this part of the solution's size is as good.
const AS_GOOD: f64 = 1e-10;

/// Solutions of a curve where a quantity that vanishes along it has values, each half of the one before, or so: the solution where it is zero, and what
/// that is off by, in parts of the sizes.
pub(super) fn at_zero(
    (values, all): (&[f64], &[Vec<f64>]),
    scales: &[f64],
) -> Option<(Vec<f64>, f64)> {
    let extrapolated = |values: &[f64], all: &[Vec<f64>]| -> Vec<f64> {
        let through = |i: usize| all.iter().map(|at| at[i]).collect::<Vec<f64>>();
        (0..scales.len())
            .map(|i| interpolated(values, &through(i), 0.0))
            .collect()
    };
    // The longest tells what the polynomial leaves out, the shortest what is rounding.
    let pieces = values.windows(AT_A_TIME).zip(all.windows(AT_A_TIME));
    let ends = pieces.map(|(values, all)| {
        let (end, last) = (extrapolated(values, all), AT_A_TIME - 1);
        let fewer = [
            extrapolated(&values[1..], &all[1..]),
            extrapolated(&values[..last], &all[..last]),
        ];
        let off = fewer.iter().map(|other| moved(other, &end, scales));
        let off = off.fold(0.0, f64::max);
        (end, off)
    });
    let ends: Vec<(Vec<f64>, f64)> = ends.collect();
    let least = (0..ends.len()).min_by(|&a, &b| ends[a].1.total_cmp(&ends[b].1))?;
    let (end, off) = ends[least].clone();
    // Chance makes one difference small: those beside it have to agree.
    let beside = [least.checked_sub(1), Some(least + 1)];
    let beside = beside.into_iter().flatten().filter_map(|k| ends.get(k));
    let off = beside.fold(off, |most, (other, _)| most.max(moved(other, &end, scales)));
    Some((end, off))
}

impl Follower {
    /// Where impacts lose their rates all at once, as where an orbit that goes round several times meets one that grazes each time, the
    /// equations lose more than one rank, and stations are the less known the nearer they are. But the curve is a smooth function of a rate: its
    /// end, which of those that may vanish does, and a place before it up to which stations are known; none where the station that was
    /// found is as good.
    pub(super) fn extrapolated(
        &mut self,
        from: &Station,
        (station, ahead): (&Station, f64),
        all: &[Broken],
        bordered: &Bordered,
    ) -> Option<(Broken, Station)> {
        let mut way = vec![from.clone()];
        for halves in 1..STATIONS {
            let by = ahead * (1.0 - 0.5_f64.powi(halves));
            match from.ahead(&mut bordered.of(&mut self.shooting), by) {
                Ok((there, _)) => way.push(there),
                Err(_) => break,
            }
        }
        let places: Vec<Vec<f64>> = way.iter().map(|there| there.at.clone()).collect();
        let ends = all.iter().filter_map(|broken| {
            let values = way.iter().map(|there| self.left_of(broken, there));
            let values: Vec<f64> = values.collect();
            // With noise the flight to a rate that vanishes may be told for that, and has nothing that does so smoothly.
            if values.iter().any(|value| value.is_nan()) {
                return None;
            }
            let (at, off) = at_zero((&values, &places), self.shooting.scales())?;
            Some((broken, at, off))
        });
        let (broken, at, off) = ends.min_by(|a, b| a.2.total_cmp(&b.2))?;
        let apart = moved(&at, &station.at, self.shooting.scales());
        let is_better = off <= KNOWN && apart > off.max(AS_GOOD) && apart < ahead;
        let end = Station {
            at,
            correction: off,
            ..station.clone()
        };
        is_better.then(|| (broken.clone(), end))
    }
}
