//! What the one-dimensional map says about the system near a border orbit.

use super::super::error::{BorderError, Lack};
use super::super::normal_form::exact::Memory;
use super::super::orbit::Border;
use crate::analysis::universal::Universal;
use crate::numerics::{Estimate, Real, Rounded, dot, moved};
use serde::{Deserialize, Serialize};

/// z -> Upsilon(K z + M (p - p*)), and the states after the first impact that go with z, (26) and (27).
#[derive(Clone, Debug)]
pub struct Prediction {
    universal: Universal<f64>,
    /// K.
    pub slope: f64,
    /// M.
    pub unfolding_rate: f64,
    /// p*.
    pub border: f64,
    /// States after the first impact: s_0* + by_upsilon z + by_parameter (p - p*).
    pub states: AffineStates,
    /// What orbits that do not repeat after each passage remember, with more than three states.
    pub(in crate::analysis::border) memory: Option<Memory<f64>>,
}

/// States that are affine in z and p - p*.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AffineStates {
    /// At the border orbit.
    pub origin: Vec<f64>,
    /// What z = 1 adds: A B.
    pub by_upsilon: Vec<f64>,
    /// What p - p* = 1 adds: A E + F, or ds_0/dp.
    pub by_parameter: Vec<f64>,
}

/// One predicted passage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PredictedPassage {
    /// Upsilon of the passage before: what it adds to the first impact of this one.
    pub z: f64,
    /// X of the first impact.
    pub x: f64,
    /// Impacts until release in flight; `None` where chatter is complete.
    pub impacts: Option<u64>,
    /// What is remembered of where the orbit was released, beyond what one with Upsilon = 0 would have: nothing with three states.
    pub memory: Vec<f64>,
}

impl AffineStates {
    /// The state for z at a distance p - p* from the border.
    pub fn at(&self, z: f64, distance: f64) -> Vec<f64> {
        let released = moved(&self.origin, &self.by_upsilon, z);
        moved(&released, &self.by_parameter, distance)
    }
}

impl Prediction {
    /// With the exact coefficients (M5).
    ///
    /// # Errors
    /// The restitution is not between 0 and 1.
    pub fn exact<R: Real>(border: &Border<R>) -> Result<Self, BorderError> {
        let exact = &border.exact;
        let rates = [exact.slope, exact.unfolding_rate].map(|rate| rate.value.to_f64());
        let by_upsilon = Estimate::values(&exact.first_impact_by_upsilon.rounded());
        let by_parameter = Estimate::values(&exact.first_impact_by_parameter.rounded());
        Self::at(
            border,
            rates,
            (by_upsilon, by_parameter),
            exact.memory.rounded(),
        )
    }

    /// With the paper's leading-order coefficients. States have the section coordinates' components only; the third
    /// stays at its value on the border orbit.
    ///
    /// # Errors
    /// The restitution is not between 0 and 1, or there are no such coefficients.
    pub fn leading_order<R: Real>(border: &Border<R>) -> Result<Self, BorderError> {
        let form = border.leading_order.as_ref().map_err(Clone::clone)?;
        let mut by_upsilon = vec![0.0; border.first_impact.state.len()];
        let mut by_parameter = by_upsilon.clone();
        for (row, &i) in border.section.iter().enumerate() {
            let along = |v: [R; 2]| dot(&form.a[row], &v);
            by_upsilon[i] = along(form.b).to_f64();
            by_parameter[i] = (along(form.e) + form.f[row]).to_f64();
        }
        let rates = [form.slope, form.unfolding_rate].map(|rate| rate.to_f64());
        Self::at(border, rates, (by_upsilon, by_parameter), None)
    }

    /// With K and M, and how the first impact moves with Upsilon and the parameter.
    fn at<R: Real>(
        border: &Border<R>,
        [slope, unfolding_rate]: [f64; 2],
        (by_upsilon, by_parameter): (Vec<f64>, Vec<f64>),
        memory: Option<Memory<f64>>,
    ) -> Result<Self, BorderError> {
        let restitution = border.constants.restitution.to_f64();
        let universal = Universal::new(restitution)
            .map_err(|_| Lack::Restitution(restitution).at(border.value.value))?;
        Ok(Self {
            universal,
            slope,
            unfolding_rate,
            border: border.value.value.to_f64(),
            states: AffineStates {
                origin: border.first_impact.state.rounded(),
                by_upsilon,
                by_parameter,
            },
            memory,
        })
    }

    /// Upsilon and its constants.
    pub fn universal(&self) -> &Universal<f64> {
        &self.universal
    }

    /// mu = M (p - p*).
    pub fn mu(&self, parameter: f64) -> f64 {
        self.unfolding_rate * (parameter - self.border)
    }

    /// p = p* + mu / M.
    pub fn parameter(&self, mu: f64) -> f64 {
        self.border + mu / self.unfolding_rate
    }

    /// The passage with these numbers, and the z of the next one.
    pub(super) fn passage(&self, x: f64, z: f64, memory: Vec<f64>) -> (PredictedPassage, f64) {
        let at = self.universal.at(x);
        // Lap n has n impacts after the first; above x_e laps are negative, and one impact is left at least.
        let impacts = (x > 0.0).then(|| (at.lap + 1.0).max(1.0) as u64);
        let passage = PredictedPassage {
            z,
            x,
            impacts,
            memory,
        };
        (passage, at.value)
    }

    /// `keep` passages after `transient` others, from the border orbit's own z = 0.
    pub fn orbit(&self, parameter: f64, transient: usize, keep: usize) -> Vec<PredictedPassage> {
        let mu = self.mu(parameter);
        let coordinates = (self.memory.as_ref()).map_or(0, |memory| memory.states.len());
        let first = self.passage(mu, 0.0, vec![0.0; coordinates]);
        let next = |(passage, z): &(PredictedPassage, f64)| {
            let Some(memory) = &self.memory else {
                return Some(self.passage(self.slope.mul_add(*z, mu), *z, Vec::new()));
            };
            let y: Vec<f64> = (memory.returns.iter().zip(&memory.by_upsilon))
                .map(|(row, b)| dot(row, &passage.memory) + b * passage.z)
                .collect();
            let x = memory.slope.mul_add(*z, mu) + dot(&memory.covector, &y);
            Some(self.passage(x, *z, y))
        };
        let orbit = core::iter::successors(Some(first), next);
        let passages = orbit.map(|(passage, _)| passage);
        passages.skip(transient).take(keep).collect()
    }

    /// The state after the first impact of a passage.
    pub fn state(&self, parameter: f64, passage: &PredictedPassage) -> Vec<f64> {
        let Some(memory) = self.memory.as_ref().filter(|_| !passage.memory.is_empty()) else {
            return self.states.at(passage.z, parameter - self.border);
        };
        let remembered = memory.first_impact_by_memory.iter().zip(&passage.memory);
        let parts = remembered.chain([(&memory.first_impact_by_upsilon, &passage.z)]);
        let state = self.states.at(0.0, parameter - self.border);
        parts.fold(state, |state, (by, &part)| moved(&state, by, part))
    }
}
