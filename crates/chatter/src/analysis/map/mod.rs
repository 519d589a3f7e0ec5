//! Point -> next point: the seam between systems and the questions asked of their long-term behaviour.
//!
//! A return map of a flow is a map; so are the universal map and a border normal form. An analysis written against
//! [`Map`] (orbit diagram, Lyapunov exponent) is written once for all of them. To join in, a map implements the names
//! of its coordinates and parameters and [`next`](Map::next); one that runs on several lanes implements
//! [`next_batch`](Map::next_batch) too; only a map whose orbits are not in step with each other, such as the return map
//! of a flow, has reason to implement [`follow`](Map::follow).

mod batch;
mod coordinate;
mod passage;
mod scope;
mod tangent;

pub use batch::Batch;
pub(crate) use batch::next_of_follow;
pub use coordinate::{Carry, CoordinateKind, PhaseLost};
pub use passage::{NoReturn, Passage};
pub use scope::Scope;
pub use tangent::{Differentiable, Tangent};
pub(crate) use tangent::{displaced_names, displaced_point};

use core::sync::atomic::AtomicBool;

/// A map of points, depending on parameters. Points and parameters are lists of numbers in a fixed order.
pub trait Map: Sync {
    /// Names of the coordinates of a point.
    fn coordinates(&self) -> Vec<String>;

    /// Names of the parameters.
    fn parameters(&self) -> Vec<String>;

    /// Parameter values in order, with each of `swept` (position, value) in place of what the map says by itself.
    fn parameter_values(&self, swept: &[(usize, f64)]) -> Vec<f64>;

    /// Where an orbit starts unless told otherwise.
    fn initial_point(&self, parameters: &[f64]) -> Vec<f64>;

    /// What an expression about points of this map may name. Unless overridden: coordinates, as states, and parameters.
    fn scope(&self) -> Scope {
        Scope::new(&self.coordinates(), &self.parameters())
    }

    /// Moves `point` to the next one.
    ///
    /// # Errors
    /// There is no next point; `point` is then unspecified.
    fn next(&self, parameters: &[f64], point: &mut [f64]) -> Result<Passage, NoReturn>;

    /// What the coordinates are, at these parameters: numbers as they stand, unless told otherwise.
    fn coordinate_kinds(&self, _parameters: &[f64]) -> Vec<CoordinateKind> {
        vec![CoordinateKind::Plain; self.coordinates().len()]
    }

    /// Whether points can be carried from each of `values`, each a list of all parameters, to the others, as
    /// [`carried`](Self::carried) does.
    ///
    /// # Errors
    /// They would lose the phase of a forcing.
    fn check_carry(&self, _swept: &[usize], _values: &[Vec<f64>]) -> Result<(), PhaseLost> {
        Ok(())
    }

    /// Where an orbit goes on at other parameters: where it ended, in the same phase of any forcing.
    fn carried(&self, carry: &Carry<'_>) -> Vec<f64> {
        carry.end.to_vec()
    }

    /// Points between a point of the map's image and what it comes to after so long a time, one after the other, and what the
    /// terms of its rates make in that time: what sizes coordinates have that are the same at all points of the map, or zero
    /// but for rounding. A map without time has none.
    fn on_the_way(&self, _parameters: &[f64], _from: &[f64], _duration: f64) -> Vec<f64> {
        Vec::new()
    }

    /// The tangent map: its points are those of this map, each followed by a displacement as long as the point, which the
    /// derivative of this map carries along. Orbits may differ in the parameters at the positions `swept`. None where the map has
    /// no derivative.
    ///
    /// A displacement counts as long as what it takes the point to is another orbit: the map may take from it what only
    /// leads along the same motion. It may be scaled at will.
    fn tangent(&self, _swept: &[usize]) -> Option<Box<dyn Map + '_>> {
        None
    }

    /// Moves every point of a batch to its next one. Each must come out to the same bits as by [`next`](Self::next).
    fn next_batch(&self, batch: &mut Batch) {
        batch::one_by_one(self, batch);
    }

    /// Follows several orbits side by side, each until it is retired. They differ in the parameters at the positions
    /// `swept` and in their points.
    ///
    /// `visit` hears of each new point of each orbit and says what becomes of the orbit. What an orbit does depends on
    /// its own starts alone, never on the others or on how many there are. Once `stop` is set it returns as soon as it
    /// can, whether or not an orbit has come to a point.
    fn follow(
        &self,
        swept: &[usize],
        starts: &[Start],
        stop: &AtomicBool,
        visit: &mut dyn FnMut(Arrival<'_>) -> Command,
    ) {
        batch::follow_in_step(self, swept, starts, stop, visit);
    }
}

/// Where an orbit starts.
#[derive(Clone, Debug, PartialEq)]
pub struct Start {
    /// Values of the swept parameters.
    pub swept: Vec<f64>,
    /// From which point.
    pub origin: Origin,
}

/// From which point an orbit starts.
#[derive(Clone, Debug, PartialEq)]
pub enum Origin {
    /// The map's own initial point at these parameters.
    Initial,
    /// This point; for the return map of a flow any state.
    Point(Vec<f64>),
    /// This point, which is on the image of the map: for the return map of a flow on its section, for example. The map
    /// does not count it as a return.
    Image(Vec<f64>),
}

/// A point that an orbit has come to, or why it has come to none.
#[derive(Debug)]
pub struct Arrival<'a> {
    /// Which orbit, by its place among the starts.
    pub orbit: usize,
    /// The new point; the latest one known where there is no return.
    pub point: &'a [f64],
    /// All parameter values of the orbit.
    pub parameters: &'a [f64],
    /// What happened on the way.
    pub passage: Result<Passage, NoReturn>,
}

/// What becomes of an orbit.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// It goes on. One that has no next point is retired instead.
    Continue,
    /// It is finished.
    Retire,
    /// Another takes its place.
    Restart(Start),
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Logistic;

    impl Map for Logistic {
        fn coordinates(&self) -> Vec<String> {
            vec!["x".to_owned()]
        }
        fn parameters(&self) -> Vec<String> {
            vec!["a".to_owned()]
        }
        fn parameter_values(&self, swept: &[(usize, f64)]) -> Vec<f64> {
            vec![swept.last().map_or(3.7, |&(_, value)| value)]
        }
        fn initial_point(&self, _: &[f64]) -> Vec<f64> {
            vec![0.5]
        }
        fn next(&self, parameters: &[f64], point: &mut [f64]) -> Result<Passage, NoReturn> {
            point[0] = parameters[0] * point[0] * (1.0 - point[0]);
            Ok(Passage::default())
        }
    }

    #[test]
    fn orbits_are_independent_of_their_company() {
        let alone = |a: f64, length: usize| {
            let mut point = [0.5];
            for _ in 0..length {
                Logistic.next(&[a], &mut point).unwrap();
            }
            point[0]
        };
        let values = [3.1, 3.9, 2.0, 3.57, 5.0];
        let starts = values.map(|a| Start {
            swept: vec![a],
            origin: Origin::Initial,
        });
        let mut counts = [0; 5];
        let mut ends = [f64::NAN; 5];
        let mut restarted = false;
        Logistic.follow(&[0], &starts, &AtomicBool::new(false), &mut |arrival| {
            let k = arrival.orbit;
            if arrival.passage.is_err() {
                assert_eq!(values[k], 5.0);
                if restarted {
                    return Command::Continue;
                }
                restarted = true;
                counts[k] = 0;
                return Command::Restart(Start {
                    swept: vec![3.3],
                    origin: Origin::Initial,
                });
            }
            counts[k] += 1;
            ends[k] = arrival.point[0];
            if counts[k] == 10 * (k + 1) {
                Command::Retire
            } else {
                Command::Continue
            }
        });
        for k in 0..4 {
            assert_eq!(ends[k].to_bits(), alone(values[k], 10 * (k + 1)).to_bits());
        }
        assert!(restarted);
        assert_eq!(ends[4].to_bits(), alone(3.3, 50).to_bits());
    }

    #[test]
    fn expressions_name_coordinates_and_parameters() {
        let mut scope = Logistic.scope();
        let expr = scope.parse("a*x^2").unwrap();
        assert_eq!(scope.graph.evaluate(expr, &[3.0], &[2.0]), 18.0);
        assert!(scope.parse("a*y").is_err());
    }
}
