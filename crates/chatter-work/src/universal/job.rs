//! An orbit diagram of the universal map: all that is needed to compute it again.

use crate::refusal::Refusal;
use chatter::analysis::diagram::{DiagramError, Spec, Sweep};
use chatter::analysis::universal::{Universal, UniversalMap};
use serde::{Deserialize, Serialize};

/// A diagram of z -> Upsilon(K z + mu).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct UniversalJob {
    /// Version of this program.
    pub version: String,
    /// The coefficient of restitution r.
    pub restitution: f64,
    /// The slope K, where it is not swept.
    pub slope: f64,
    /// The offset mu, where it is not swept.
    pub mu: f64,
    /// The diagram.
    pub diagram: Spec,
}

impl UniversalJob {
    /// The map, and the diagram's rows.
    pub fn prepare(&self) -> Result<(UniversalMap<f64>, Sweep), Refusal> {
        let universal = Universal::new(self.restitution).map_err(Refusal::input)?;
        let map = UniversalMap::new(universal, self.slope, self.mu).map_err(Refusal::input)?;
        let unswept = |error: DiagramError| Refusal::input(&error).did_you_mean(error.suggestion());
        let sweep = Sweep::new(&map, &self.diagram).map_err(unswept)?;
        Ok((map, sweep))
    }

    /// What the map is called, with its restitution.
    pub fn title(&self) -> String {
        format!("Universal map, r = {}", self.restitution)
    }
}
