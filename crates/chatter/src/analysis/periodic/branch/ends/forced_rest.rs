//! Where a branch of forced orbits ends since they shrink onto a state of rest that the forcing leaves as it is, which lies on the surface of their
//! events: where a multiplier of the linear part there is one, as where branches meet.

use crate::analysis::continuation::{Problem, Station, meeting, other_direction};
use crate::analysis::periodic::branch::changes::graze::{THERE, moved};
use crate::analysis::periodic::branch::walker::Walker;
use crate::analysis::periodic::branch::{End, Point, SpecialKind};
use crate::analysis::periodic::cycle::itinerary::{Passage, Step};
use crate::analysis::periodic::multipliers::is_near;
use crate::analysis::periodic::orbit::shorter;
use crate::analysis::periodic::shooting::Shooting;
use crate::analysis::periodic::solved::{NOISE, roundoff};
use crate::flow::leg::{Jump, LegKind};

/// On both sides of a surface the field is linear alike up to this part of its slopes.
pub(super) const ALIKE: f64 = 1e-6;

impl Shooting<f64> {
    /// What an orbit has shrunk to, of whole periods of its forcing on which nothing happens, by the field of one of its steps.
    pub(super) fn at_rest(&self, at: &[f64], index: usize) -> Option<(Self, Vec<f64>)> {
        let kind = self.steps[index].flight()?;
        let step = Step {
            passage: Passage::Timed(LegKind {
                ends_at: None,
                ..kind
            }),
            duration: self.period(),
            told: Vec::new(),
            ..self.current_steps(at).get(index)?.clone()
        };
        self.like(vec![step], at).ok()
    }

    /// By how much, in units of eigenvalues, the linear parts of the fields of all steps differ at some places of what an orbit has shrunk to, and
    /// the largest of them: these may lie on a surface on which formulas change their form. Nothing where jumps are as much a part of what is
    /// linear.
    pub(super) fn unlike(
        &self,
        at: &[f64],
        free: &[f64],
        places: &[Vec<f64>],
    ) -> Option<(f64, f64)> {
        let (sizes, parameters) = (self.state_sizes(), self.workshop.parameters(free));
        let mut fields = Vec::new();
        for (index, step) in self.steps.iter().enumerate() {
            if step.flight()?.jump != Jump::None {
                return None;
            }
            let mut field = self.equilibria(at, index)?;
            field.parameters = self.parameters_of(&parameters, step);
            fields.push(field);
        }
        let (first, others) = fields.split_first()?;
        let (mut most, mut largest) = (0.0_f64, 0.0_f64);
        for place in places {
            let known = first.at(place);
            for other in others {
                let there = other.at(place);
                for (row, &own) in first.states.iter().enumerate() {
                    let mut apart = (there.residual[row] - known.residual[row]) / sizes[own];
                    for (column, &by) in first.states.iter().enumerate() {
                        let parts = sizes[by] / sizes[own];
                        let slope = known.jacobian[(row, column)];
                        let off = (there.jacobian[(row, column)] - slope) * parts;
                        if !off.is_finite() {
                            return None;
                        }
                        apart = apart.abs().max(off.abs());
                        largest = largest.max((slope * parts).abs());
                    }
                    most = most.max(apart.abs());
                }
            }
        }
        Some((most, largest))
    }
}

impl Walker {
    /// Notes where the branch of shrunk orbits meets that of the state of rest, and tells how it ends there. Nothing where the linear part is not
    /// the same on both sides of the surface of an event, or no multiplier is one.
    pub(super) fn meets_rest(&mut self, shrunk: &Station, index: usize) -> Option<End> {
        if self.shooting.counts.iter().all(|&count| count == 0) {
            return None;
        }
        let (mut rest, guess) = self.shooting.at_rest(&shrunk.at, index)?;
        let found = meeting(&mut rest, &guess).ok()?;
        if moved(&found.at, &guess, rest.scales()) > THERE {
            return None;
        }
        let workshop = self.shooting.workshop.clone();
        let rests = rest.node(&found.at, 0);
        let places = (0..self.shooting.steps.len()).map(|index| {
            let node = self.shooting.node(&shrunk.at, index).iter().zip(rests);
            let parts = node.enumerate().map(|(state, (&then, &rests))| {
                let turns = workshop.closure.is_phase(state);
                if turns { then } else { rests }
            });
            parts.collect()
        });
        let places: Vec<Vec<f64>> = places.collect();
        let free = rest.free(&found.at).to_vec();
        let (unlike, largest) = self.shooting.unlike(&shrunk.at, &free, &places)?;
        let scale = *rest.scales().last()?;
        let station = Station {
            at: found.at,
            residual: found.residual,
            correction: found.correction,
            ..shrunk.clone()
        };
        rest.evaluate(&station.at).ok()?;
        if unlike > ALIKE * largest || !is_near(&rest.multipliers(), 1.0) {
            return None;
        }
        let doubles = shorter(&rest, &station.at).is_ok_and(|half| half.is_some());
        let mut along = vec![0.0; station.at.len()];
        *along.last_mut()? = scale;
        let leaves = other_direction(&mut rest, &station.at, &along);
        let parameter = station.parameter();
        let error = roundoff(parameter)
            .max(NOISE * found.correction * scale)
            .max(unlike / largest * parameter.abs());
        let own = core::mem::replace(&mut self.shooting, rest);
        self.settle(&station);
        let here = Point::new(&mut self.shooting, &station);
        let told = (error, station.residual);
        self.note(SpecialKind::BranchPoint, &here, &station.at, told.0, told.1);
        self.shooting = own;
        let special = self.special.last_mut()?;
        if doubles {
            special.seed = None;
            return Some(End::Again(SpecialKind::BranchPoint));
        }
        special.leaves = leaves.unwrap_or_default();
        Some(End::Equilibrium)
    }
}
