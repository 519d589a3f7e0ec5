//! The values that a sweep goes through.

use serde::{Deserialize, Serialize};

/// Values of one parameter or initial value: equally spaced, both ends included.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Range {
    /// The name of the parameter, or of the coordinate whose initial value it is.
    pub parameter: String,
    /// Which of the two.
    #[serde(default)]
    pub swept: Swept,
    /// The first value.
    pub from: f64,
    /// The last value.
    pub to: f64,
    /// How many values.
    pub count: u64,
    /// How they are spaced.
    pub spacing: Spacing,
}

/// What is swept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Swept {
    /// A parameter of the map.
    #[default]
    Parameter,
    /// Where a coordinate starts.
    Initial,
}

/// How values are spaced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Spacing {
    /// Equal differences.
    Linear,
    /// Equal ratios.
    Logarithmic,
}

impl Range {
    /// Parameter values with equal differences.
    pub fn linear(parameter: &str, from: f64, to: f64, count: u64) -> Self {
        Self {
            parameter: parameter.to_owned(),
            swept: Swept::Parameter,
            from,
            to,
            count,
            spacing: Spacing::Linear,
        }
    }

    /// Initial values with equal differences.
    pub fn initial(coordinate: &str, from: f64, to: f64, count: u64) -> Self {
        Self {
            swept: Swept::Initial,
            ..Self::linear(coordinate, from, to, count)
        }
    }

    /// One value of a parameter.
    pub fn single(parameter: &str, value: f64) -> Self {
        Self::linear(parameter, value, value, 1)
    }

    /// What its values are called in the result.
    pub fn name(&self) -> String {
        match self.swept {
            Swept::Parameter => self.parameter.clone(),
            Swept::Initial => initial_name(&self.parameter),
        }
    }

    /// Value number `index`, from 0.
    pub fn value(&self, index: u64) -> f64 {
        if index == 0 {
            return self.from;
        }
        if index + 1 >= self.count {
            return self.to;
        }
        let share = index as f64 / (self.count - 1) as f64;
        match self.spacing {
            Spacing::Linear => self.from + (self.to - self.from) * share,
            Spacing::Logarithmic => {
                let exponent = libm::log(self.to / self.from) * share;
                self.from * libm::exp(exponent)
            }
        }
    }
}

/// What the values at which a coordinate starts are called in the result.
pub fn initial_name(coordinate: &str) -> String {
    format!("initial_{coordinate}")
}
