//! Where a branch goes on past what its equations can say, and where it may not go on.

use super::Point;
use super::walker::Walker;
use crate::analysis::continuation::{Curve, Problem, Settings, Station, locate};
use crate::analysis::periodic::cycle::itinerary::Step;
use crate::analysis::periodic::orbit::close;
use crate::analysis::periodic::special_curve::start::reread;

/// So far beyond a place where the sequence of events changes orbits are looked for, in parts of the longest step; and so near to
/// where they are expected they are of the same branch.
const BEYOND: [f64; 5] = [1e-6, 1e-5, 1e-4, 1e-3, 1e-2];
const SAME_BEYOND: f64 = 1e-3;
/// Where new equations begin their steps, in parts of the longest one.
const CAREFUL: f64 = 1e-3;

impl Walker {
    /// The contact whose restitution, where it is a matter of parameters, comes to an end of what it may be on the way to a
    /// station, and the station where it does.
    pub(super) fn leaves_theory(
        &mut self,
        from: &Station,
        next: &Station,
        step: f64,
    ) -> Option<(String, Station, f64)> {
        let workshop = self.shooting.workshop.clone();
        let steps = self.shooting.steps.iter();
        let mut hit: Vec<usize> = match self.shooting.steps.iter().any(Step::is_stretch) {
            true => (0..workshop.model.contacts.len()).collect(),
            false => steps.filter_map(Step::impact).collect(),
        };
        hit.sort_unstable();
        hit.dedup();
        let free = self.shooting.parameters();
        for contact in hit {
            let contact = &workshop.model.contacts[contact];
            let graph = &workshop.model.graph;
            if graph.depends_on_state(contact.restitution) {
                continue;
            }
            let inside = |station: &Station| {
                let values = &station.at[station.at.len() - free..];
                let r = graph.evaluate(contact.restitution, &[], &workshop.parameters(values));
                r.min(1.0 - r)
            };
            let ends = (inside(from), inside(next));
            if ends.0 > 0.0 && ends.1 < 0.0 {
                let value =
                    &mut |_: &mut dyn Problem<f64>, station: &Station| Some(inside(station));
                let (station, ahead) = locate(&mut self.shooting, from, step, ends, value)?;
                return Some((contact.name.clone(), station, ahead));
            }
        }
        None
    }

    /// Goes on a little farther on the same branch, where it has as many impacts and only the order of what happens is another,
    /// such as an impact of complete chatter that comes before the knot of a table and not after it. Whether it does.
    pub(super) fn hop(&mut self, curve: &mut Curve, here: &mut Point) -> bool {
        let Some(next) = self.beyond(&curve.station, here.impacts) else {
            return false;
        };
        *here = Point::new(&mut self.shooting, &next);
        let careful = Settings {
            first_step: (CAREFUL * self.limits.longest_step).max(1e-9),
            ..self.limits.settings()
        };
        *curve = Curve::new(next, careful);
        true
    }

    /// The orbit a little farther on, read off the motion itself, where it has so many impacts.
    fn beyond(&mut self, from: &Station, impacts: Option<u64>) -> Option<Station> {
        let workshop = self.shooting.workshop.clone();
        let last = from.at.len() - 1;
        // From just after the fastest impact: at a release the motion would have to decide anew.
        let count = self.shooting.steps.len();
        let rate = |index: usize| {
            let before = (index + count - 1) % count;
            let hits = self.shooting.steps[before].impact().is_some();
            let landing = self.shooting.latest.get(before).filter(|_| hits);
            landing.map_or(0.0, |landing| landing.surface_rate.abs())
        };
        let robust = (0..count).max_by(|&a, &b| rate(a).total_cmp(&rate(b)));
        let robust = robust.unwrap_or(0);
        BEYOND.into_iter().find_map(|part| {
            let ahead = part * self.limits.longest_step;
            let guess = from.at.iter().zip(&from.tangent);
            let guess: Vec<f64> = guess.map(|(x, by)| x + by * ahead).collect();
            let free = self.shooting.free(&guess).to_vec();
            let start = self.shooting.node(&guess, robust).to_vec();
            let told = (&start, self.shooting.period());
            let cycle = reread(&workshop, &free, told).ok()?;
            let orbit = close(&workshop, cycle, &free).ok()?;
            let (mut shooting, at) = orbit.shooting.without_section(orbit.at);
            let sizes = self.shooting.state_sizes();
            let turns = (workshop.closure).turns(&workshop.parameters(&free)).ok()?;
            let is_near = |index: usize| {
                let nodes = (&*start, shooting.node(&at, index));
                let difference = (workshop.closure).difference(&turns, nodes, &sizes);
                difference.distance <= SAME_BEYOND
            };
            if orbit.impacts != impacts || !(0..shooting.steps.len()).any(is_near) {
                return None;
            }
            let station = Station::near(&mut shooting, &at, at.len() - 1).ok()?;
            let forward = from.tangent[last] >= 0.0;
            let station = if forward { station } else { station.reversed() };
            self.shooting = shooting;
            self.settle(&station);
            Some(station)
        })
    }
}
