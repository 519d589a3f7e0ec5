//! Branches that were followed from several orbits at one value of the parameter: each of them once.
//!
//! Whether two branches are one is asked where both have the same value of the parameter. Each is marked where it passes the value at
//! which the orbits were found: a function of the parameter alone vanishes there, so that the orbit is located as any special point
//! is. A branch that does not pass that value is known by its special points, but for those at which branches meet.

use super::branch::{Branch, Special, SpecialKind};
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
/// Special points this near, in parts of the range, …
const NEAR: f64 = 1e-9;
/// … are one if nodes of theirs are this near, against their size: where orbits fold they change much with the parameter.
const SAME_SPECIAL: f64 = 1e-5;

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
    near: f64,
    sizes: Vec<f64>,
    /// Orbits at the value.
    orbits: Vec<Nodes>,
    special: Vec<(SpecialKind, f64, Nodes)>,
}

impl Distinct {
    /// Of branches over this range, from orbits at the model's value of the parameter.
    ///
    /// # Errors
    /// What is asked does not fit the model.
    pub fn new(model: &Model, spec: &Spec, what: &BranchSpec) -> Result<Self, PeriodicError> {
        let value = model.parameter_values::<f64>(&[])[what.parameter];
        let (low, high) = what.limits.range;
        let name = &model.parameters[what.parameter].name;
        let mut spec = spec.clone();
        spec.monitors.push(format!("{name} - ({value:?})"));
        Ok(Self {
            workshop: workshop(model, &spec, (&[what.parameter], &[high - low]))?,
            spec,
            value,
            near: NEAR * (high - low),
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
                .filter_map(nodes)
                .collect();
            let special: Vec<(SpecialKind, f64, Nodes)> = (branch.special.iter())
                .filter(|special| !is_mark(special) && !meets(special.kind))
                .filter_map(|special| {
                    let nodes = nodes(special)?;
                    Some((special.kind, special.point.parameter(), nodes))
                })
                .collect();
            let is_known = match (index, marks.first()) {
                (0, _) => false,
                (_, Some(orbit)) => self.has(orbit)?,
                (_, None) => self.has_any(&special)?,
            };
            if is_known {
                continue;
            }
            self.orbits.extend(marks);
            self.special.extend(special);
            branch.special.retain(|special| !is_mark(special));
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

    fn has_any(&self, special: &[(SpecialKind, f64, Nodes)]) -> Result<bool, PeriodicError> {
        for (kind, value, nodes) in special {
            for (known_kind, known_value, known) in &self.special {
                let fits = kind == known_kind && (value - known_value).abs() <= self.near;
                if fits && self.share(nodes, known, SAME_SPECIAL)? {
                    return Ok(true);
                }
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

/// Whether more than one branch goes through special points of this kind.
fn meets(kind: SpecialKind) -> bool {
    matches!(
        kind,
        SpecialKind::BranchPoint | SpecialKind::PeriodDoubling | SpecialKind::Monitor
    )
}

fn nodes(special: &Special) -> Option<Nodes> {
    let seed = special.seed.as_ref()?;
    let mut shooting = seed.shooting.clone();
    Some(shooting.landmarks(&seed.at))
}
