//! Point -> next point: the seam between systems and the questions asked of their long-term behaviour.
//!
//! A return map of a flow is a map; so are the universal map and a border normal form. An analysis written against
//! [`Map`] (orbit diagram, Lyapunov exponent) is written once for all of them. To join in, a map implements the names
//! of its coordinates and parameters and [`next`](Map::next); one that runs on several lanes implements
//! [`next_batch`](Map::next_batch) too; only a map whose orbits are not in step with each other, such as the return map
//! of a flow, has reason to implement [`follow`](Map::follow).

use crate::expressions::{Expr, Graph, ParseError};
use crate::flow::FlowError;
use core::fmt;

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

    /// Positions of the coordinates in which neighbouring points differ: all of them, unless one only tells the time of a
    /// map that looks at fixed times.
    fn directions(&self) -> Vec<usize> {
        (0..self.coordinates().len()).collect()
    }

    /// The derivative of the next point with respect to the point, row by row, if the map knows it.
    fn jacobian(&self, _parameters: &[f64], _point: &[f64]) -> Option<Vec<f64>> {
        None
    }

    /// Moves every point of a batch to its next one. Each must come out to the same bits as by [`next`](Self::next).
    fn next_batch(&self, batch: &mut Batch) {
        let mut parameters = vec![0.0; batch.parameters.len()];
        let mut point = vec![0.0; batch.points.len()];
        for orbit in 0..batch.passages.len() {
            gather(&batch.parameters, orbit, &mut parameters);
            gather(&batch.points, orbit, &mut point);
            batch.passages[orbit] = self.next(&parameters, &mut point);
            for (lane, &value) in batch.points.iter_mut().zip(&point) {
                lane[orbit] = value;
            }
        }
    }

    /// Follows several orbits side by side, each until it is retired. They differ in the parameters at the positions
    /// `swept` and in their points.
    ///
    /// `visit` hears of each new point of each orbit and says what becomes of the orbit. What an orbit does depends on
    /// its own starts alone, never on the others or on how many there are.
    fn follow(
        &self,
        swept: &[usize],
        starts: &[Start],
        visit: &mut dyn FnMut(Arrival<'_>) -> Command,
    ) {
        follow_in_batches(self, swept, starts, visit);
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
    /// This point, which differs by a small displacement from one on the image of the map that was in the phase given.
    Beside {
        /// The displaced point.
        point: Vec<f64>,
        /// [`Passage::phase`] where the undisplaced one was reached.
        phase: u32,
    },
}

/// What happened on the way from a point to the next one.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Passage {
    /// Impacts on the way; for chatter sequences that were completed by a limit, those integrated one by one.
    pub impacts: u64,
    /// Infinite impact sequences on the way that ended in contact.
    pub accumulations: u64,
    /// Time from point to point; zero for a map without time.
    pub return_time: f64,
    /// Length of the latest flight that was completed on the way; NaN if there was none, or for a map without flights.
    pub flight_time: f64,
    /// In which phase the next point is (for a flow: which contacts are closed). Means nothing outside the map.
    pub phase: u32,
}

impl Passage {
    /// Names of the quantities of a passage in expressions, in the order of [`values`](Self::values).
    pub const NAMES: [&'static str; 4] = ["impacts", "accumulations", "return_time", "flight_time"];

    /// Its quantities.
    pub fn values(&self) -> [f64; 4] {
        [
            self.impacts as f64,
            self.accumulations as f64,
            self.return_time,
            self.flight_time,
        ]
    }

    /// This passage followed by another: sums, and what holds at the end.
    #[must_use]
    pub fn then(&self, next: &Self) -> Self {
        Self {
            impacts: self.impacts + next.impacts,
            accumulations: self.accumulations + next.accumulations,
            return_time: self.return_time + next.return_time,
            flight_time: if next.flight_time.is_nan() {
                self.flight_time
            } else {
                next.flight_time
            },
            phase: next.phase,
        }
    }
}

/// Why there is no next point.
#[derive(Clone, Debug, PartialEq)]
pub enum NoReturn {
    /// Not within the time allowed.
    Time {
        /// The time allowed.
        limit: f64,
    },
    /// Not within the impacts allowed.
    Impacts {
        /// The impacts allowed.
        limit: u64,
    },
    /// The next point is not finite.
    LeftDomain,
    /// The trajectory cannot go on.
    Failed(FlowError),
}

impl fmt::Display for NoReturn {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Time { limit } => write!(out, "no return within a time of {limit}"),
            Self::Impacts { limit } => write!(out, "no return within {limit} impacts"),
            Self::LeftDomain => write!(out, "the next point is not a finite number"),
            Self::Failed(error) => error.fmt(out),
        }
    }
}

impl core::error::Error for NoReturn {}

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

/// Orbits side by side, one array for each coordinate and parameter.
#[derive(Clone, Debug, Default)]
pub struct Batch {
    /// `parameters[k][orbit]`.
    pub parameters: Vec<Vec<f64>>,
    /// `points[k][orbit]`: replaced by the next point.
    pub points: Vec<Vec<f64>>,
    /// What happened on the way, one for each orbit: to be set.
    pub passages: Vec<Result<Passage, NoReturn>>,
}

/// What expressions about a map's points may name.
#[derive(Clone, Debug, Default)]
pub struct Scope {
    /// Holds the expressions. States are the coordinates of points.
    pub graph: Graph,
    /// Names and what they stand for; an earlier one hides a later one of the same name.
    pub names: Vec<(String, Expr)>,
}

impl Scope {
    /// Coordinates are states, parameters parameters, in order.
    pub fn new(coordinates: &[String], parameters: &[String]) -> Self {
        let mut scope = Self::default();
        for (index, name) in coordinates.iter().enumerate() {
            scope.names.push((name.clone(), scope.graph.state(index)));
        }
        for (index, name) in parameters.iter().enumerate() {
            let parameter = scope.graph.parameter(index);
            scope.names.push((name.clone(), parameter));
        }
        scope
    }

    /// Reads an expression.
    ///
    /// # Errors
    /// The first thing that is wrong with the text.
    pub fn parse(&mut self, text: &str) -> Result<Expr, ParseError> {
        let names = &self.names;
        let known: Vec<&str> = names.iter().map(|(name, _)| name.as_str()).collect();
        let resolve = |name: &str| {
            let found = names.iter().find(|(known, _)| known == name);
            found.map(|&(_, expr)| expr)
        };
        self.graph.parse(text, &resolve, &known)
    }
}

fn gather(arrays: &[Vec<f64>], orbit: usize, into: &mut [f64]) {
    for (value, array) in into.iter_mut().zip(arrays) {
        *value = array[orbit];
    }
}

/// [`Map::follow`] for maps whose orbits are in step: all move by one point, then each is visited.
fn follow_in_batches<M: Map + ?Sized>(
    map: &M,
    swept: &[usize],
    starts: &[Start],
    visit: &mut dyn FnMut(Arrival<'_>) -> Command,
) {
    let width = map.coordinates().len();
    let mut batch = Batch {
        parameters: vec![Vec::new(); map.parameters().len()],
        points: vec![Vec::new(); width],
        passages: Vec::new(),
    };
    let begin = |start: &Start| {
        let overrides: Vec<(usize, f64)> = swept
            .iter()
            .copied()
            .zip(start.swept.iter().copied())
            .collect();
        let parameters = map.parameter_values(&overrides);
        let point = match &start.origin {
            Origin::Initial => map.initial_point(&parameters),
            Origin::Point(point) | Origin::Image(point) | Origin::Beside { point, .. } => {
                point.clone()
            }
        };
        (parameters, point)
    };
    for start in starts {
        let (parameters, point) = begin(start);
        for (array, value) in batch.parameters.iter_mut().zip(parameters) {
            array.push(value);
        }
        for (array, value) in batch.points.iter_mut().zip(point) {
            array.push(value);
        }
        batch.passages.push(Ok(Passage::default()));
    }
    // Which orbit each place of the batch holds.
    let mut orbits: Vec<usize> = (0..starts.len()).collect();
    let mut point = vec![0.0; width];
    let mut parameters = vec![0.0; batch.parameters.len()];
    while !orbits.is_empty() {
        map.next_batch(&mut batch);
        // Backwards, so that the place filled from the end by `swap_remove` has been visited already.
        for place in (0..orbits.len()).rev() {
            gather(&batch.points, place, &mut point);
            gather(&batch.parameters, place, &mut parameters);
            let passage = core::mem::replace(&mut batch.passages[place], Ok(Passage::default()));
            let passage = match passage {
                Ok(_) if !point.iter().all(|x| x.is_finite()) => Err(NoReturn::LeftDomain),
                other => other,
            };
            let failed = passage.is_err();
            let arrival = Arrival {
                orbit: orbits[place],
                point: &point,
                parameters: &parameters,
                passage,
            };
            match visit(arrival) {
                Command::Continue if !failed => {}
                Command::Continue | Command::Retire => {
                    orbits.swap_remove(place);
                    drop(batch.passages.swap_remove(place));
                    let arrays = batch.parameters.iter_mut().chain(&mut batch.points);
                    arrays.for_each(|array| {
                        array.swap_remove(place);
                    });
                }
                Command::Restart(start) => {
                    let (parameters, point) = begin(&start);
                    let values = parameters.into_iter().chain(point);
                    let arrays = batch.parameters.iter_mut().chain(&mut batch.points);
                    arrays
                        .zip(values)
                        .for_each(|(array, value)| array[place] = value);
                }
            }
        }
    }
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
        Logistic.follow(&[0], &starts, &mut |arrival| {
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
