//! Where a branch comes to a chatter border, and how far that is from its last orbit.

use crate::analysis::border::BorderSpec;
use crate::analysis::border_search::borders_in;
use crate::analysis::continuation::Station;
use crate::analysis::periodic::branch::walker::Walker;
use crate::analysis::periodic::branch::{Point, SpecialKind};
use crate::analysis::periodic::margins::{border_coordinate, shortest_contact};
use crate::analysis::periodic::orbit::cleaned;
use crate::analysis::periodic::solved::roundoff;

/// A branch comes this near to a border, in parts of the parameter; the border itself is looked for as far away as this.
const BESIDE_BORDER: f64 = 1e-10;
const LOOKED_AT: f64 = 1e-7;
/// Its coordinate is looked at here and so far back, in parts of the longest step, and the distance that this tells is known to a factor.
const BORDER_STEP: f64 = 1e-3;
const BORDER_ROOM: f64 = 2.0;
/// Right beside it the period is that at the border but for this part.
const SAME_PERIOD: f64 = 1e-3;
/// Where it differs by more than this part from that of the orbit before, rounding has led past the release at the border, to a later one.
const ANOTHER_PERIOD: f64 = 0.1;
/// A sequence whose contact is over at this part of the distance that a coordinate tells is another one.
const OF_ANOTHER: f64 = 0.1;
/// So many orbits come close to it one after the other.
const LAST_ORBITS: usize = 4;
/// There is one border in so short a range.
const BORDER_SAMPLES: usize = 6;
impl Walker {
    /// Notes a chatter border that a branch has come to: near it orbits are known the less the nearer they are, and the border orbit
    /// itself is found by its own equations, where these can be set up. Whether there is one: nothing says so where it may be farther
    /// away than a step.
    pub(in crate::analysis::periodic::branch) fn note_border(
        &mut self,
        here: &Point,
        station: &Station,
    ) -> bool {
        let value = station.parameter();
        let workshop = &self.shooting.workshop;
        let mut spec = BorderSpec::new(&workshop.model.parameters[workshop.free[0]].name);
        spec.samples = BORDER_SAMPLES;
        let (low, high) = (
            value - LOOKED_AT * value.abs(),
            value + LOOKED_AT * value.abs(),
        );
        let found = borders_in::<f64>(&workshop.model, &spec, low, high);
        let nearest = found.ok().and_then(|found| found.nearest(value));
        let mut error = BESIDE_BORDER * value.abs();
        let mut extrapolated = None;
        if nearest.is_none()
            && let Some(distance) = self.distance_to_border(station)
        {
            let far = BORDER_ROOM * distance.far;
            if far > self.limits.longest_step * station.parameter_slope().abs() {
                return false;
            }
            error = error.max(far);
            extrapolated = distance.vanishes.filter(|(_, off)| *off < error);
            error = extrapolated.map_or(error, |(_, off)| off);
        }
        self.note(SpecialKind::ChatterBorder, here, &station.at, error, 0.0);
        if let Some(special) = self.special.last_mut() {
            special.leaves.clone_from(&station.tangent);
            if (special.point.period - here.period).abs() > ANOTHER_PERIOD * here.period {
                special.point.period = here.period;
            }
        }
        let told = nearest.map(|border| {
            if let Some(special) = self.special.last_mut() {
                special.error = border.value.error;
                // A border orbit that is told from rest to rest may come to rest more often in a period.
                let (own, period) = (special.point.period, border.period.value);
                if (period - own).abs() <= SAME_PERIOD * own {
                    special.point.period = period;
                }
            }
            border.value.value
        });
        let told = told.or(extrapolated.map(|(value, _)| value));
        if let (Some(border), Some(special)) = (told, self.special.last_mut()) {
            // Told where the branch is told, as far along it as the border is: this says more than where its orbit is released.
            let ahead = (border - value) / station.parameter_slope();
            let along = station.at.iter().zip(&station.tangent);
            let at: Vec<f64> = along.map(|(x, slope)| x + ahead * slope).collect();
            let state = self.shooting.told_state(&at);
            if state.iter().all(|x| x.is_finite()) {
                special.point.state = cleaned(&state, &self.shooting.state_sizes());
                special.point.monitors = self.shooting.monitored(&at);
            }
            if let Some(parameter) = special.point.parameters.last_mut() {
                *parameter = border;
            }
        }
        true
    }

    /// How far the parameter is from a border, by its coordinate, which vanishes linearly, there and a little before; where that cannot be
    /// told, by the time from the end of chatter to release, which vanishes as a power.
    fn distance_to_border(&mut self, station: &Station) -> Option<Distance> {
        // Where nothing tells, no less than how far its last orbits have come.
        let back = self.points.len().checked_sub(LAST_ORBITS);
        let crowded = back.and_then(|place| self.points.get(place));
        let crowded = crowded.map(|point| (point.parameter() - station.parameter()).abs());
        let crowded = crowded.map(|far| Distance {
            far,
            vanishes: None,
        });
        self.measured_distance(station).or(crowded)
    }

    fn measured_distance(&mut self, station: &Station) -> Option<Distance> {
        let back = station.clone().reversed();
        let way = BORDER_STEP * self.limits.longest_step;
        let mut looked = Vec::new();
        for part in [0.0, 0.25, 0.5, 1.0] {
            let (there, _) = back.ahead(&mut self.shooting, part * way).ok()?;
            self.settle(&there);
            let coordinate = border_coordinate(&self.shooting, &there.at);
            let contact = shortest_contact(&self.shooting, &there.at);
            looked.push((there.parameter(), coordinate, contact));
        }
        self.settle(station);
        let [here, _, halfway, before] = looked[..] else {
            return None;
        };
        let gone = [halfway.0, before.0].map(|value| (value - here.0).abs());
        let lasted = [here.2, halfway.2, before.2];
        let by_contact = match lasted {
            [Some(here), Some(next), Some(last)] => Some(Distance {
                far: distance_by_power(gone, [here, next, last]).unwrap_or(gone[1]),
                vanishes: None,
            }),
            _ => None,
        };
        let coordinates: Option<Vec<(f64, f64)>> = (looked.iter())
            .map(|&(value, coordinate, _)| Some((coordinate?, value)))
            .collect();
        if let Some(known) = coordinates {
            let slope = (known[3].0 - known[0].0) / (before.0 - here.0);
            let far = (known[0].0 / slope).abs();
            // Without the nearest, where it is known least, the value tells what it may be off by.
            let [value, other] = [&known[..], &known[1..]].map(where_it_vanishes);
            let error = BORDER_ROOM * (value - other).abs() + roundoff(value);
            // Where contact of another sequence is over sooner the coordinate is none of that.
            let is_of_another = |contact: &Distance| contact.far < OF_ANOTHER * far;
            if !by_contact.as_ref().is_some_and(is_of_another) {
                return far.is_finite().then_some(Distance {
                    far,
                    vanishes: error.is_finite().then_some((value, error)),
                });
            }
        }
        by_contact
    }
}

/// How far a border is.
struct Distance {
    far: f64,
    /// The parameter there, and its error, if more is known of it.
    vanishes: Option<(f64, f64)>,
}

/// The argument at which a function vanishes, by the polynomial in its values through these (value, argument), as Neville has it.
fn where_it_vanishes(known: &[(f64, f64)]) -> f64 {
    let mut all: Vec<f64> = known.iter().map(|(_, argument)| *argument).collect();
    for order in 1..known.len() {
        for first in 0..known.len() - order {
            let (near, far) = (known[first].0, known[first + order].0);
            all[first] = (far * all[first] - near * all[first + 1]) / (far - near);
        }
    }
    all[0]
}

/// How far from here a function vanishes as a power of the distance, from its values here and at two distances from here, the function
/// growing with both: d with log(f_1/f_0)/log(1 + x_1/d) = log(f_2/f_0)/log(1 + x_2/d). None where no distance up to the farther of them
/// does.
fn distance_by_power([near, far]: [f64; 2], [here, next, last]: [f64; 3]) -> Option<f64> {
    if !(0.0 < here && here < next && next < last) {
        return None;
    }
    let (rise, whole) = (libm::log(next / here), libm::log(last / here));
    let off =
        |distance: f64| rise * libm::log1p(far / distance) - whole * libm::log1p(near / distance);
    // As the distance vanishes both logarithms are one, and `off` has the sign of -1.
    let (mut low, mut high) = (f64::MIN_POSITIVE.sqrt(), far);
    if off(low) * off(high) > 0.0 {
        return None;
    }
    for _ in 0..200 {
        let middle = (low * high).sqrt();
        if off(middle) * off(low) > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some(high)
}

#[cfg(test)]
mod tests {
    use super::{distance_by_power, where_it_vanishes};

    #[test]
    fn a_function_vanishes_where_its_inverse_is() {
        let inverse = |x: f64| 0.3 + 2.0 * x - 5.0 * x * x + 7.0 * x * x * x;
        let known = [1e-9, 0.1, 0.2, 0.4].map(|x| (x, inverse(x)));
        assert!((where_it_vanishes(&known) - 0.3).abs() < 1e-15);
        assert!((where_it_vanishes(&known[1..]) - 0.3 - 7.0 * 0.1 * 0.2 * 0.4).abs() < 1e-14);
    }

    #[test]
    fn a_power_tells_where_it_vanishes() {
        for (distance, power) in [(1e-7, 0.7), (3e-3, 1.0), (2e-9, 1.9)] {
            let of = |x: f64| libm::pow(x + distance, power);
            let ways = [5e-3, 1e-2];
            let found = distance_by_power(ways, [of(0.0), of(ways[0]), of(ways[1])]).unwrap();
            assert!((found / distance - 1.0).abs() < 1e-6, "{distance}: {found}");
        }
        assert_eq!(distance_by_power([1.0, 2.0], [0.0, 1.0, 2.0]), None);
        assert_eq!(distance_by_power([1.0, 2.0], [2.0, 1.0, 2.0]), None);
    }
}
