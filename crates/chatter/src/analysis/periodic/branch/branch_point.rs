//! Points where branches meet, from stations around them.

use super::walker::Walker;
use super::{End, Point, SpecialKind};
use crate::analysis::continuation::{Corrected, Problem, Station, meeting, other_direction};
use crate::analysis::periodic::multipliers::is_near;
use crate::analysis::periodic::orbit::shorter;
use crate::analysis::periodic::solved::{NOISE, roundoff};

impl Walker {
    /// A point where branches meet. The equations are singular there, so it is found from stations around it: the
    /// polynomial through what vanishes, a multiplier less one or, on a branch that turns, the tangent's part along the
    /// parameter. From there it is solved for with what unfolds it.
    pub(super) fn branch_point(
        &mut self,
        from: &Station,
        step: f64,
        (before, after): (f64, f64),
    ) -> Option<Met> {
        self.settle(from);
        let turns = before * after < 0.0;
        let noise = |station: &Station| roundoff(station.parameter());
        let scale = self.shooting.scales()[from.at.len() - 1];
        let (mut low, mut high) = (0.0, step);
        let mut rough: Option<Fitted> = None;
        let (mut solved, mut elsewhere) = (None, None);
        // Where the fit leads elsewhere it is made on a shorter way.
        for _ in 0..ATTEMPTS {
            if let Some(fitted) = self.fitted(from, (low, high), turns) {
                // As far away as the fit is sure of.
                let span = (high - low) * scale;
                let near = (1e-3 * span).max(fitted.error.min(span));
                let found = meeting(&mut self.shooting, &fitted.station.at).ok();
                let parameter = fitted.station.parameter();
                let scales = self.shooting.scales();
                let on_the_way = |found: &Corrected<f64>| {
                    let ahead = from.reach(&found.at, scales);
                    ahead > 0.0 && ahead < step && from.distance(&found.at, scales) < ROOM * step
                };
                match found {
                    Some(found) if (found.at[found.at.len() - 1] - parameter).abs() <= near => {
                        solved = Some(found);
                    }
                    Some(found) if on_the_way(&found) => elsewhere = Some(found),
                    _ => {}
                }
                rough = Some(fitted);
            }
            if solved.is_some() {
                break;
            }
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                match from.ahead(&mut self.shooting, middle) {
                    Ok((station, _)) if station.orientation * from.orientation < 0.0 => {
                        high = middle;
                    }
                    Ok(_) => low = middle,
                    Err(_) => break,
                }
            }
        }
        // Where few stations can be corrected fits lead away from the one meeting that there is on the way.
        solved = solved.or(elsewhere);
        let Fitted {
            mut station,
            mut error,
            mut residual,
            ..
        } = rough?;
        error = error.max(noise(&station));
        if let Some(found) = solved {
            error = noise(&station).max(NOISE * found.correction * scale);
            residual = found.residual;
            station.at = found.at;
        }
        let leaves = other_direction(&mut self.shooting, &station.at, &station.tangent);
        self.settle(&station);
        let here = Point::new(&mut self.shooting, &station);
        if !(is_near(&here.multipliers, 1.0) || self.shooting.grazes()) {
            return None;
        }
        Some(Met {
            at: station.at,
            point: here,
            told: (error, residual),
            leaves: leaves.unwrap_or_default(),
        })
    }

    /// Tells it. Where it is an orbit gone around twice, this branch is one of doubled orbits: it comes back from there as it went, and ends.
    pub(super) fn note_branch_point(&mut self, met: Met) -> Option<End> {
        let again = shorter(&self.shooting, &met.at).is_ok_and(|half| half.is_some());
        let (error, residual) = met.told;
        self.note(
            SpecialKind::BranchPoint,
            &met.point,
            &met.at,
            error,
            residual,
        );
        let special = self.special.last_mut()?;
        special.leaves = met.leaves;
        again.then_some(End::Again(SpecialKind::BranchPoint))
    }

    /// Where the polynomial through stations on a part of the way ahead of another vanishes.
    fn fitted(&mut self, from: &Station, part: (f64, f64), turns: bool) -> Option<Fitted> {
        let span = part.1 - part.0;
        let mut reader = self.shooting.clone();
        let mut value = |station: &Station| {
            if turns {
                return station.tangent.last().copied();
            }
            reader.evaluate(&station.at).ok()?;
            let (found, _) = reader.multipliers_at(station);
            (found.iter().filter(|m| m.im == 0.0))
                .map(|m| m.re - 1.0)
                .min_by(|a, b| a.abs().total_cmp(&b.abs()))
        };
        let mut ends = part;
        let mut fitted: Option<Fitted> = None;
        // Around the first root of the polynomial the next one is fitted more closely, as far as equations that are nearly singular
        // can be solved there.
        for width in [1.0, 0.2, 0.04] {
            let (low, high) = match &fitted {
                None => ends,
                Some(Fitted { root, .. }) => {
                    let half: f64 = 0.5 * width * span;
                    ((root - half).max(part.0), (root + half).min(part.1))
                }
            };
            ends = (low, high);
            let mut places = Vec::new();
            let mut values = Vec::new();
            let mut stations = Vec::new();
            for k in 0..FITTED {
                let angle = core::f64::consts::PI * (k as f64 + 0.5) / FITTED as f64;
                let at = 0.5 * (low + high) - 0.5 * (high - low) * libm::cos(angle);
                let Ok((station, _)) = from.ahead(&mut self.shooting, at) else {
                    continue;
                };
                let Some(here) = value(&station) else {
                    continue;
                };
                places.push(at);
                values.push(here);
                stations.push(station);
            }
            let Some(root) = root_of(&places, &values, ends) else {
                break;
            };
            let at: Vec<f64> = (0..from.at.len())
                .map(|i| {
                    let component: Vec<f64> = stations.iter().map(|s| s.at[i]).collect();
                    interpolated(&places, &component, root)
                })
                .collect();
            let station = Station {
                at,
                ..stations[0].clone()
            };
            let moved =
                |earlier: &Fitted| (earlier.station.parameter() - station.parameter()).abs();
            fitted = Some(Fitted {
                root,
                error: fitted.as_ref().map_or(span, moved),
                residual: interpolated(&places, &values, root).abs(),
                station,
            });
        }
        fitted
    }
}

/// Where branches meet, the orbit there, what its parameter may be off by and what is left of what vanishes, and the direction of the other branch.
pub(super) struct Met {
    pub at: Vec<f64>,
    pub point: Point,
    told: (f64, f64),
    leaves: Vec<f64>,
}

/// Where a polynomial through stations vanishes: how far ahead, and the station there.
struct Fitted {
    root: f64,
    station: Station,
    residual: f64,
    /// Of the parameter.
    error: f64,
}

/// Fits on ever shorter ways, by so many halvings each.
const ATTEMPTS: usize = 3;
const HALVINGS: usize = 3;
/// A point on the way is no farther from its start, in parts of the way.
const ROOM: f64 = 1.2;
/// Stations that a polynomial is fitted to.
const FITTED: usize = 8;

/// The polynomial through points, in Lagrange's form.
pub(in crate::analysis::periodic) fn interpolated(places: &[f64], values: &[f64], at: f64) -> f64 {
    let mut sum = 0.0;
    for (i, (&x, &y)) in places.iter().zip(values).enumerate() {
        let weight: f64 = (places.iter().enumerate())
            .filter(|(k, _)| *k != i)
            .map(|(_, other)| (at - other) / (x - other))
            .product();
        sum += weight * y;
    }
    sum
}

/// Where it vanishes between the ends, by bisection.
fn root_of(places: &[f64], values: &[f64], (mut low, mut high): (f64, f64)) -> Option<f64> {
    if places.len() < FITTED / 2 {
        return None;
    }
    let at = |x: f64| interpolated(places, values, x);
    let sign = at(low) > 0.0;
    if sign == (at(high) > 0.0) {
        return None;
    }
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if (at(middle) > 0.0) == sign {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some(0.5 * (low + high))
}
