//! Branches that were followed from several orbits at one value of the parameter: each of them once.
//!
//! Whether two branches are one is asked where both have the same value of the parameter. Each is marked where it passes the value at
//! which the orbits were found: a function of the parameter alone vanishes there, so that the orbit is located as any special point
//! is. A branch that does not pass that value is known by its special points, but for those at which branches meet.

use super::branch::{Branch, Near, Seed, Special};
use super::cycle::reread::reread;
use super::error::PeriodicError;
use super::orbit::{Orbit, close};
use super::shooting::Workshop;
use super::{BranchSpec, Spec, workshop};
use crate::model::Model;
use crate::numerics::Real;
use crate::numerics::stored::{list, number};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Two orbits at one value are one if a node of one comes this near to a node of the other, against their size: no two share a state.
const SAME: f64 = 1e-7;

/// An orbit that a branch is followed from: a state on it, and its period.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Start {
    /// All states in order.
    #[serde(with = "list")]
    pub state: Vec<f64>,
    /// How long it takes.
    #[serde(with = "number")]
    pub period: f64,
}

impl From<&Orbit> for Start {
    fn from(orbit: &Orbit) -> Self {
        Self {
            state: orbit.start.iter().map(|x| x.to_f64()).collect(),
            period: orbit.period.to_f64(),
        }
    }
}

/// The states that an orbit is known by.
type Nodes = Vec<Vec<f64>>;

/// Takes the branches from one orbit after the other, and passes on those that are new.
pub struct Distinct {
    spec: Spec,
    workshop: Arc<Workshop>,
    value: f64,
    near: Near,
    sizes: Vec<f64>,
    /// Orbits at the value.
    orbits: Vec<Nodes>,
    special: Vec<Vec<Special>>,
}

impl Distinct {
    /// Of branches over this range, from orbits at the model's value of the parameter.
    ///
    /// # Errors
    /// What is asked does not fit the model.
    pub fn new(model: &Model, spec: &Spec, what: &BranchSpec) -> Result<Self, PeriodicError> {
        let value = model.parameter_values::<f64>(&[])[what.parameter];
        let range = what.limits.range;
        let (low, high) = range;
        let name = &model.parameters[what.parameter].name;
        let mut spec = spec.clone();
        spec.monitors.push(format!("{name} - ({value:?})"));
        Ok(Self {
            workshop: workshop(model, &spec, (&[what.parameter], &[high - low]))?,
            spec,
            value,
            near: Near::over(range),
            sizes: Vec::new(),
            orbits: Vec::new(),
            special: Vec::new(),
        })
    }

    /// How the branches from an orbit are to be followed: marked.
    pub fn spec(&self, start: &Start) -> Spec {
        Spec {
            through: Some((start.state.clone(), start.period)),
            ..self.spec.clone()
        }
    }

    /// Whether an orbit lies on a branch that was passed on.
    ///
    /// # Errors
    /// It is no orbit.
    pub fn knows(&mut self, start: &Start) -> Result<bool, PeriodicError> {
        let nodes = self.nodes_of(start)?;
        self.has(&nodes)
    }

    /// Takes the branches from an orbit that is not [known](Self::knows), the first of them through it, and passes on those that are new,
    /// without their marks.
    ///
    /// # Errors
    /// It is no orbit.
    pub fn add(
        &mut self,
        start: &Start,
        branches: Vec<Branch>,
    ) -> Result<Vec<Branch>, PeriodicError> {
        let own = self.nodes_of(start)?;
        self.orbits.push(own);
        let mark = self.spec.monitors.len() - 1;
        let is_mark = |special: &Special| special.monitor == Some(mark);
        let mut new = Vec::new();
        for (index, mut branch) in branches.into_iter().enumerate() {
            let marks: Vec<Nodes> = (branch.special.iter())
                .filter(|special| is_mark(special))
                .filter_map(|special| special.seed.as_ref().map(Seed::landmarks))
                .collect();
            let is_known = match (index, marks.first()) {
                (0, _) => false,
                (_, Some(orbit)) => self.has(orbit)?,
                (_, None) => {
                    let mut all = self.special.iter();
                    all.any(|known| branch.shares_special(known, self.near))
                }
            };
            if is_known {
                continue;
            }
            self.orbits.extend(marks);
            branch.special.retain(|special| !is_mark(special));
            let told = branch.special.iter();
            let alone = told.filter(|special| !special.kind.meets());
            self.special.push(alone.cloned().collect());
            let points = branch.points.iter_mut();
            let special = branch.special.iter_mut();
            for point in points.chain(special.map(|special| &mut special.point)) {
                point.monitors.truncate(mark);
            }
            new.push(branch);
        }
        Ok(new)
    }

    fn nodes_of(&mut self, start: &Start) -> Result<Nodes, PeriodicError> {
        let through = (&start.state, start.period);
        let cycle = reread(&self.workshop, &[self.value], through)?;
        let orbit = close(&self.workshop, cycle, &[self.value])?;
        if self.sizes.is_empty() {
            self.sizes = orbit.shooting.state_sizes();
        }
        let mut shooting = orbit.shooting;
        Ok(shooting.landmarks(&orbit.at))
    }

    fn has(&self, nodes: &Nodes) -> Result<bool, PeriodicError> {
        for known in &self.orbits {
            if self.share(nodes, known, SAME)? {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Whether two orbits share a state.
    fn share(&self, one: &Nodes, other: &Nodes, near: f64) -> Result<bool, PeriodicError> {
        let closure = &self.workshop.closure;
        let turns = closure.turns(&self.workshop.parameters(&[self.value]))?;
        Ok(closure.share(&turns, (one, other), &self.sizes, near))
    }
}
