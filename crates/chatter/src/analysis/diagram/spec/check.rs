//! What can be wrong with a specification, looked for before anything is computed.

use super::observable::Observable;
use super::range::{Range, Spacing, Swept, initial_name};
use crate::analysis::diagram::error::DiagramError;
use crate::analysis::diagram::sweep::Sweep;
use crate::analysis::diagram::{Bounds, Spec, Start};
use crate::analysis::map::Map;

/// More samples of one orbit than this are a slip of the keyboard: they would fill the memory.
pub(in crate::analysis::diagram) const MOST_KEPT: u64 = 100_000_000;

/// Where the ranges of a sweep are found in a map: positions of parameters and of coordinates.
pub(in crate::analysis::diagram) struct Places {
    pub parameters: Vec<usize>,
    pub initial: Vec<usize>,
}

/// The ranges' places.
pub(in crate::analysis::diagram) fn places(
    map: &dyn Map,
    spec: &Spec,
) -> Result<Places, DiagramError> {
    if !(1..=2).contains(&spec.sweeps.len()) {
        return Err(DiagramError::SweepCount {
            count: spec.sweeps.len(),
        });
    }
    let (parameters, coordinates) = (map.parameters(), map.coordinates());
    let mut places = Places {
        parameters: Vec::new(),
        initial: Vec::new(),
    };
    for range in &spec.sweeps {
        match range.swept {
            Swept::Parameter => {
                let unknown = |name, known| DiagramError::UnknownParameter { name, known };
                check_range(range, &parameters, &mut places.parameters, &unknown)?;
            }
            Swept::Initial => {
                let unknown = |name, known| DiagramError::UnknownInitial { name, known };
                check_range(range, &coordinates, &mut places.initial, &unknown)?;
            }
        }
    }
    Ok(places)
}

fn check_range(
    range: &Range,
    known: &[String],
    swept: &mut Vec<usize>,
    unknown: &dyn Fn(String, Vec<String>) -> DiagramError,
) -> Result<(), DiagramError> {
    let name = range.parameter.clone();
    let Some(index) = known.iter().position(|known| *known == name) else {
        return Err(unknown(name, known.to_vec()));
    };
    if swept.contains(&index) {
        let name = range.name();
        return Err(DiagramError::SweptTwice { name });
    }
    if range.count == 0 {
        let name = range.name();
        return Err(DiagramError::NoValues { name });
    }
    let finite = range.from.is_finite() && range.to.is_finite();
    let ordered = range.from < range.to || (range.count == 1 && range.from == range.to);
    let spaced = range.spacing == Spacing::Linear || range.from > 0.0;
    if finite && ordered && spaced {
        swept.push(index);
        Ok(())
    } else {
        let range = range.clone();
        Err(DiagramError::Ends { range })
    }
}

/// The numbers of a specification.
pub(in crate::analysis::diagram) fn numbers(spec: &Spec) -> Result<(), DiagramError> {
    if spec.keep == 0 {
        return Err(DiagramError::KeepsNothing);
    }
    if spec.keep > MOST_KEPT {
        let (keep, most) = (spec.keep, MOST_KEPT);
        return Err(DiagramError::KeepsTooMuch { keep, most });
    }
    if spec.every == 0 {
        return Err(DiagramError::EveryZeroth);
    }
    if spec.longest_period == 0 {
        return Err(DiagramError::NoPeriods);
    }
    if !(spec.period_tolerance > 0.0 && spec.period_tolerance < 1.0) {
        return Err(DiagramError::PeriodTolerance {
            value: spec.period_tolerance,
        });
    }
    Ok(())
}

/// What is observed, made ready.
pub(in crate::analysis::diagram) fn observed(
    map: &dyn Map,
    spec: &Spec,
) -> Result<Vec<Observable>, DiagramError> {
    if spec.observe.is_empty() {
        return Err(DiagramError::NothingObserved);
    }
    let coordinates = map.coordinates();
    let mut taken: Vec<String> = Sweep::CLASS_NAMES.map(str::to_owned).to_vec();
    taken.push(Sweep::COLUMN_NAME.to_owned());
    let starts: Vec<String> = coordinates.iter().map(|name| initial_name(name)).collect();
    for range in &spec.sweeps {
        let name = range.name();
        let is_start = range.swept == Swept::Parameter && starts.contains(&name);
        if is_start || taken.contains(&name) {
            return Err(DiagramError::SweptNameTaken { name });
        }
    }
    taken.extend(spec.sweeps.iter().map(Range::name));
    taken.extend(starts);
    let scope = map.scope();
    let mut observables = Vec::new();
    for observed in &spec.observe {
        if taken.contains(&observed.name) {
            let name = observed.name.clone();
            return Err(DiagramError::NameTaken { name });
        }
        taken.push(observed.name.clone());
        let observable = Observable::new(&scope, coordinates.len(), &observed.expression);
        observables.push(observable.map_err(|error| DiagramError::Observable {
            text: observed.expression.clone(),
            error,
        })?);
    }
    Ok(observables)
}

/// Positions of the coordinates that are drawn at random.
pub(in crate::analysis::diagram) fn drawn(
    map: &dyn Map,
    bounds: &[Bounds],
    swept: &[usize],
) -> Result<Vec<usize>, DiagramError> {
    let coordinates = map.coordinates();
    let mut drawn = Vec::new();
    for bound in bounds {
        let name = bound.coordinate.clone();
        if !(bound.from.is_finite() && bound.to.is_finite() && bound.from <= bound.to) {
            let (from, to) = (bound.from, bound.to);
            return Err(DiagramError::Bounds { name, from, to });
        }
        match coordinates.iter().position(|known| *known == name) {
            Some(index) if swept.contains(&index) => {
                return Err(DiagramError::SweptAndDrawn { name });
            }
            Some(index) => drawn.push(index),
            None => {
                let known = coordinates.clone();
                return Err(DiagramError::UnknownCoordinate { name, known });
            }
        }
    }
    Ok(drawn)
}

/// Whether states can be carried along the sweep.
pub(in crate::analysis::diagram) fn carry(
    map: &dyn Map,
    spec: &Spec,
    places: &Places,
) -> Result<(), DiagramError> {
    let carries = matches!(
        spec.start,
        Start::CarryUp | Start::CarryDown | Start::CarryBoth
    );
    if !carries {
        return Ok(());
    }
    if spec.chunk == Some(0) {
        return Err(DiagramError::EmptyChunks);
    }
    if let Some(range) = (spec.sweeps.iter()).find(|range| range.swept == Swept::Initial) {
        let name = range.parameter.clone();
        return Err(DiagramError::CarriedInitial { name });
    }
    let [along, others @ ..] = &spec.sweeps[..] else {
        return Ok(());
    };
    // Along the first range, at the first value of the other.
    let ends: Vec<Vec<f64>> = [0, along.count / 2, along.count - 1]
        .map(|index| {
            let along = [along.value(index)].into_iter();
            let values = along.chain(others.iter().map(|range| range.from));
            let swept: Vec<(usize, f64)> = places.parameters.iter().copied().zip(values).collect();
            map.parameter_values(&swept)
        })
        .to_vec();
    map.check_carry(&places.parameters[..1], &ends)
        .map_err(DiagramError::PhaseLost)
}
