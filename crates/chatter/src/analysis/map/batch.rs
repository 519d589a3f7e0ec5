//! Orbits in step with each other.

use super::{Arrival, Command, Map, NoReturn, Origin, Passage, Start};
use core::sync::atomic::{AtomicBool, Ordering};

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

/// [`Map::next_batch`] by [`Map::next`].
pub(super) fn one_by_one<M: Map + ?Sized>(map: &M, batch: &mut Batch) {
    let mut parameters = vec![0.0; batch.parameters.len()];
    let mut point = vec![0.0; batch.points.len()];
    for orbit in 0..batch.passages.len() {
        gather(&batch.parameters, orbit, &mut parameters);
        gather(&batch.points, orbit, &mut point);
        batch.passages[orbit] = map.next(&parameters, &mut point);
        for (lane, &value) in batch.points.iter_mut().zip(&point) {
            lane[orbit] = value;
        }
    }
}

fn gather(arrays: &[Vec<f64>], orbit: usize, into: &mut [f64]) {
    for (value, array) in into.iter_mut().zip(arrays) {
        *value = array[orbit];
    }
}

/// [`Map::next`] by [`Map::follow`].
pub(crate) fn next_of_follow<M: Map + ?Sized>(
    map: &M,
    parameters: &[f64],
    point: &mut [f64],
) -> Result<Passage, NoReturn> {
    let every: Vec<usize> = (0..parameters.len()).collect();
    let start = Start {
        swept: parameters.to_vec(),
        origin: Origin::Image(point.to_vec()),
    };
    let mut passage = Err(NoReturn::LeftDomain);
    let stop = AtomicBool::new(false);
    map.follow(&every, &[start], &stop, &mut |arrival: Arrival<'_>| {
        point.copy_from_slice(arrival.point);
        passage = arrival.passage;
        Command::Retire
    });
    passage
}

/// [`Map::follow`] for maps whose orbits are in step: all move by one point, then each is visited.
pub(super) fn follow_in_step<M: Map + ?Sized>(
    map: &M,
    swept: &[usize],
    starts: &[Start],
    stop: &AtomicBool,
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
            Origin::Point(point) | Origin::Image(point) => point.clone(),
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
    while !orbits.is_empty() && !stop.load(Ordering::Relaxed) {
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
