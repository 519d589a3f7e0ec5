//! Translations that leave the equations as they are: states that matter only by their differences, or not at all.

use crate::expressions::{Expr, Formula, Symbol};
use crate::model::Model;
use crate::numerics::Real;

/// The derivatives of the equations, of which translations are the null vectors.
#[derive(Clone, Debug)]
pub(crate) struct Translations {
    /// Of each equation by each state.
    slopes: Vec<Vec<Formula<f64>>>,
}

/// A state that can be moved together with others without any equation noticing.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Translation {
    /// The state.
    pub state: usize,
    /// Others, and how far each moves while this one moves by one.
    pub others: Vec<(usize, f64)>,
}

impl Translation {
    /// Displaces a state along it.
    pub(crate) fn carry<R: Real>(&self, state: &mut [R], by: R) {
        state[self.state] += by;
        for &(other, times) in &self.others {
            state[other] += R::splat(times) * by;
        }
    }
}

/// The equations are looked at in so many places: a derivative that vanishes in all of them vanishes.
const PLACES: usize = 8 * DISTANCES.len();

/// First in these alone: where what they show leaves no state free, all of them do not.
const FEW_PLACES: usize = DISTANCES.len();

/// How far away from a state they are, in parts of its size or of one: what is saturated far away is not nearby, what
/// nanometres are subject to is nothing beside what becomes of it at a metre, and seconds know little of a year. First all states
/// are as far away, then each as far as another one was before.
const DISTANCES: [f64; 8] = [1.0, 0.03, 1e-3, 30.0, 1e4, 1e-6, 1e-9, 1e-12];

/// How far the places are from each other, in such parts. Incommensurate with anything in a model.
const APART: f64 = 0.061_803_398_874_989_49;

/// A slope this small against the others of its equation is rounding error, …
const ROUNDING: f64 = 1e-14;

/// … and so is one this small against what was taken off it.
const CANCELLED: f64 = 1e-10;

/// A slope, and the largest number that it is a sum of.
#[derive(Clone, Copy, Debug)]
struct Slope {
    value: f64,
    size: f64,
}

impl Slope {
    fn is_known(self) -> bool {
        self.value.abs() > CANCELLED * self.size
    }
}

impl Translations {
    /// Of these equations of a model.
    pub fn new(model: &Model, equations: &[Expr]) -> Self {
        let mut graph = model.graph.clone();
        let states = model.states.len();
        let slopes = equations.iter().map(|&equation| {
            // Near the state that is looked at a force may be saturated or cut off, and what it depends on not show.
            let equation = graph.blended(equation);
            (0..states)
                .map(|state| {
                    let slope = graph.derivative(equation, Symbol::State(state));
                    Formula::new(&graph, slope)
                })
                .collect()
        });
        Self {
            slopes: slopes.collect(),
        }
    }

    /// All of them, at these parameters; `state` says how large states are.
    pub fn at(&self, parameters: &[f64], state: &[f64]) -> Vec<Translation> {
        let among = |places| free(self.rows(parameters, state, places), state.len());
        let few = among(FEW_PLACES);
        if few.is_empty() { few } else { among(PLACES) }
    }

    /// Slopes of all equations in so many places, each equation in units of its largest.
    fn rows(&self, parameters: &[f64], state: &[f64], places: usize) -> Vec<Vec<Slope>> {
        let mut scratch = Vec::new();
        let mut rows = Vec::new();
        // Of each equation that has shown nothing yet: which states its slopes have no finite value, or another than zero, by.
        let mut unknown: Vec<Option<Vec<bool>>> =
            vec![Some(vec![false; state.len()]); self.slopes.len()];
        for place in 0..places {
            let moved: Vec<f64> = (state.iter().enumerate())
                .map(|(index, x)| {
                    let turn = place + index * (place / DISTANCES.len());
                    let distance = DISTANCES[turn % DISTANCES.len()];
                    // Roots and powers may have values on one side of the state alone.
                    let step = ((1 + index + place * state.len()) as f64 * APART).fract() - 0.5;
                    x + distance * 2.0 * step * (1.0 + x.abs())
                })
                .collect();
            for (slopes, unknown) in self.slopes.iter().zip(&mut unknown) {
                let row: Vec<f64> = (slopes.iter())
                    .map(|slope| slope.evaluate(&moved, parameters, &mut scratch))
                    .collect();
                let size = row.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
                // Outside the domain there is nothing to learn.
                if !row.iter().all(|x| x.is_finite()) {
                    let depends = unknown.iter_mut().flatten().zip(&row);
                    depends.for_each(|(depends, x)| *depends |= *x != 0.0);
                    continue;
                }
                *unknown = None;
                if size > 0.0 {
                    let slope = |x: &f64| {
                        let value = if x.abs() > ROUNDING * size {
                            x / size
                        } else {
                            0.0
                        };
                        let size = value.abs();
                        Slope { value, size }
                    };
                    rows.push(row.iter().map(slope).collect());
                }
            }
        }
        // What has no value anywhere near depends on all that it is written with.
        let dimension = state.len();
        let unknown = unknown.iter().filter(|_| places == PLACES);
        for state in unknown.flatten().flat_map(|depends| {
            let states = depends.iter().enumerate();
            states
                .filter(|(_, depends)| **depends)
                .map(|(state, _)| state)
        }) {
            let one = |index| f64::from(u8::from(index == state));
            let slope = |index| Slope {
                value: one(index),
                size: one(index),
            };
            rows.push((0..dimension).map(slope).collect());
        }
        rows
    }
}

/// Null vectors of these rows.
fn free(mut rows: Vec<Vec<Slope>>, states: usize) -> Vec<Translation> {
    // Gauss-Jordan; the states without a pivot are free to move.
    let mut pivots: Vec<(usize, usize)> = Vec::new();
    for column in 0..states {
        let open = pivots.len();
        let largest = (open..rows.len()).max_by(|&a, &b| {
            let size = |row: usize| {
                let slope = rows[row][column];
                (slope.is_known(), slope.value.abs())
            };
            let ((a_known, a), (b_known, b)) = (size(a), size(b));
            a_known.cmp(&b_known).then(a.total_cmp(&b))
        });
        let Some(row) = largest.filter(|&row| rows[row][column].is_known()) else {
            continue;
        };
        rows.swap(open, row);
        let pivot = rows[open][column].value;
        for slope in &mut rows[open] {
            slope.value /= pivot;
            slope.size /= pivot.abs();
        }
        let cleared = rows[open].clone();
        for (index, other) in rows.iter_mut().enumerate() {
            let times = other[column].value;
            if index == open || times == 0.0 {
                continue;
            }
            for (slope, by) in other.iter_mut().zip(&cleared) {
                slope.value -= times * by.value;
                slope.size = slope.size.max(times.abs() * by.size);
            }
        }
        pivots.push((open, column));
    }
    let bound = |state: &usize| pivots.iter().any(|(_, column)| column == state);
    let translation = |state: usize| {
        let others = (pivots.iter())
            .filter(|&&(row, _)| rows[row][state].is_known())
            .map(|&(row, column)| (column, -rows[row][state].value));
        Translation {
            state,
            others: others.collect(),
        }
    };
    (0..states)
        .filter(|state| !bound(state))
        .map(translation)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(states: &str, gap: &str) -> Vec<Translation> {
        let names: Vec<&str> = states
            .lines()
            .filter_map(|line| line.split(' ').next())
            .collect();
        let initial: Vec<String> = names.iter().map(|name| format!("{name} = 1\n")).collect();
        let text = format!(
            "[parameters]\nn = 3\nomega = 2\n[flight]\n{states}\n[[contact]]\nname = \"c\"\ngap = \"{gap}\"\n\
             impulse = {{ u = -1, v = 1 }}\nrestitution = \"0.5\"\n[initial]\n{}",
            initial.concat()
        );
        let model = Model::from_toml(&text, "test").unwrap();
        let parameters = model.parameter_values::<f64>(&[]);
        let state = model.initial_state(&parameters);
        Translations::new(&model, &model.equations()).at(&parameters, &state)
    }

    #[test]
    fn what_matters_only_by_differences_is_found() {
        let gears = "a = \"u\"\nu = \"-(a - n*b) - u\"\nb = \"v\"\nv = \"a - n*b + sin(omega*t)\"";
        // Both wheels may turn on together: one three times as far as the other.
        let found = of(gears, "a - n*b + 1");
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].state, found[0].others.len()), (2, 1));
        assert_eq!(found[0].others[0].0, 0);
        assert!((found[0].others[0].1 - 3.0).abs() < 1e-12);
        // Nothing is free where one of them is held, …
        let held = "a = \"u\"\nu = \"-a - (a - n*b) - u\"\nb = \"v\"\nv = \"a - n*b\"";
        assert_eq!(of(held, "a - n*b + 1"), []);
        // … and what nothing depends on is free alone.
        let way = "a = \"u\"\nu = \"-a - u\"\nb = \"v\"\nv = \"-v\"";
        let alone = Translation {
            state: 2,
            others: Vec::new(),
        };
        assert_eq!(of(way, "a + 1"), [alone]);
    }

    #[test]
    fn what_is_small_is_not_free() {
        // A cubic spring of nanometres: where x is a metre, the load is nothing beside it.
        let states =
            "a = \"u\"\nu = \"-1e12*a - 5e29*a^3 + 1e3*sin(b/1e-6) - u\"\nb = \"1\"\nv = \"-v\"";
        let text = format!("[flight]\n{states}\n[initial]\na = 0\nu = 0\nb = 0\nv = 1e-6\n");
        let model = Model::from_toml(&text, "test").unwrap();
        let state = model.initial_state(&[]);
        let found = Translations::new(&model, &model.equations()).at(&[], &state);
        assert_eq!(found, []);
    }

    /// A power may have no value where the state is, and none on one side of it.
    #[test]
    fn what_has_no_value_nearby_is_not_free() {
        for force in [
            "max(-a - 0.1, 0)^1.5",
            "max(a - 0.1, 0)^1.5",
            "if(a < -0.1, (-0.1 - a)^1.5, 0)",
            "sqrt(-1e6 - a)",
        ] {
            let states = format!("a = \"u\"\nu = \"-a + {force} - u\"\nb = \"v\"\nv = \"-b\"");
            assert_eq!(of(&states, "b + 1"), [], "{force}");
        }
    }

    #[test]
    fn what_is_saturated_or_cut_off_nearby_is_not_free() {
        // A free play that the start is inside of, an integral that is saturated there, and one that only a sign knows.
        for force in [
            "-max(a - 20, 0) + min(a + 20, 0)",
            "-clamp(100*a, -1, 1)",
            "-sign(a - 50)",
            "-tanh(1e3*(a - 1))",
            "if(mod(a, 1) < 0.5, 1, -1)",
        ] {
            let states = format!("a = \"u\"\nu = \"{force} - u\"\nb = \"v\"\nv = \"-b\"");
            assert_eq!(of(&states, "b + 1"), [], "{force}");
        }
    }
}
