//! What limits the steps of a stiff model.

use crate::expressions::Symbol;
use crate::model::Model;

/// The fastest answer of the equations of flight to a change of the state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FastestRate {
    /// How fast, per unit of time. A step of the Taylor series is some tens of its reciprocal at most.
    pub rate: f64,
    /// The state that answers.
    pub state: usize,
    /// The state that it answers to, and that answers to it: the same for a damping, another for an oscillation.
    pub with: usize,
    /// The slowest rate that there is beside it, or itself.
    pub slowest: f64,
}

/// Rates so far apart make a model stiff: the slow ones are what is asked for, the fast ones limit the steps.
const STIFF: f64 = 1e3;

impl FastestRate {
    /// Whether the model is stiff.
    pub fn is_stiff(&self) -> bool {
        self.rate > STIFF * self.slowest
    }

    /// At the initial state of a model: the largest |J_ii| or sqrt(|J_ij J_ji|) of the Jacobian J of its equations, none
    /// where all are zero or have no value.
    pub fn at_start(model: &Model) -> Option<Self> {
        let parameters = model.parameter_values::<f64>(&[]);
        let initial = model.initial_state(&parameters);
        let mut graph = model.graph.clone();
        let field = model.field();
        let symbols: Vec<Symbol> = (0..field.len()).map(Symbol::State).collect();
        let jacobian = graph.jacobian(&field, &symbols);
        let rows: Vec<Vec<f64>> = (jacobian.iter())
            .map(|row| graph.evaluate_all(row, &initial, &parameters))
            .collect();
        let mut slowest = f64::INFINITY;
        let mut fastest: Option<Self> = None;
        for (state, row) in rows.iter().enumerate() {
            for with in 0..=state {
                let rate = if state == with {
                    row[state].abs()
                } else {
                    // Each root by itself: the product may overflow.
                    row[with].abs().sqrt() * rows[with][state].abs().sqrt()
                };
                if !rate.is_finite() || rate == 0.0 {
                    continue;
                }
                slowest = rate.min(slowest);
                if rate > fastest.map_or(0.0, |known| known.rate) {
                    fastest = Some(Self {
                        rate,
                        state,
                        with,
                        slowest,
                    });
                }
            }
        }
        fastest.map(|fastest| Self { slowest, ..fastest })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dampings_and_oscillations_have_their_rates() {
        let model = |force: &str| {
            let text = format!(
                "[flight]\ny = 'v'\nv = '{force}'\nw = '-3*w'\n[initial]\ny = 1\nv = 0\nw = 0\n"
            );
            Model::from_toml(&text, "m").unwrap()
        };
        let found = |force| FastestRate::at_start(&model(force)).unwrap();
        let damping = found("-1e9*v - y");
        assert_eq!((damping.rate, damping.state, damping.with), (1e9, 1, 1));
        assert!(damping.is_stiff() && damping.slowest == 1.0);
        let spring = found("-1e16*y");
        assert_eq!((spring.rate, spring.state, spring.with), (1e8, 1, 0));
        let slow = found("-y/100");
        assert_eq!((slow.rate, slow.state, slow.with), (3.0, 2, 2));
        assert!(!slow.is_stiff() && spring.is_stiff());
    }
}
