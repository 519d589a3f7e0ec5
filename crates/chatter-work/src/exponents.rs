//! All Lyapunov exponents of a motion: request, answer, document.

use crate::json::{Json, Object};
use crate::numbers::Digits;
use crate::observer::Observer;
use crate::options::{Count, Quantity};
use crate::periodic::refused;
use crate::refusal::Refusal;
use chatter::analysis::exponents::{Exponents, Spec, exponents};
use chatter::analysis::periodic::forcing;
use chatter::analysis::simulate::FastestRate;
use chatter::model::Model;
use chatter::numerics::Real as _;
use std::time::Instant;

/// What is asked. What is none is as usual.
#[derive(Clone, Debug, Default)]
pub struct Request {
    /// Time from one orthogonalisation to the next; the period of the forcing, or one unit of time, or a power of ten of that for
    /// faster models.
    pub interval: Option<Quantity>,
    /// Intervals passed over.
    pub transient: Option<Count>,
    /// Intervals that are averaged over.
    pub intervals: Option<Count>,
}

/// Usual numbers.
const TRANSIENT: u64 = 200;
const INTERVALS: u64 = 2000;

impl Request {
    /// The specification.
    ///
    /// # Errors
    /// An interval is none, or there is nothing to average over.
    pub fn spec(&self, model: &mut Model) -> Result<Spec, Refusal> {
        let interval = match &self.interval {
            Some(interval) => interval.value(model, "--interval")?.to_f64(),
            None => forcing(model).unwrap_or_else(|| usual_interval(model)),
        };
        if !(interval > 0.0 && interval.is_finite()) {
            return Err(Refusal::input(format!(
                "--interval {interval}: expected a positive number"
            )));
        }
        let spec = Spec {
            interval,
            transient: self.transient.map_or(TRANSIENT, |count| count.0),
            intervals: self.intervals.map_or(INTERVALS, |count| count.0),
        };
        if spec.intervals == 0 {
            return Err(Refusal::input(
                "--intervals 0: there is nothing to average over",
            ));
        }
        let total = spec.transient as f64 + spec.intervals as f64;
        if !(interval * total).is_finite() {
            return Err(Refusal::input(format!(
                "--interval {interval}: {total} of these are longer than any number"
            )));
        }
        Ok(spec)
    }
}

/// One unit of time; for a model in which much happens in one, the power of ten nearest to ten of the times that its equations
/// answer in.
fn usual_interval(model: &Model) -> f64 {
    let rate = FastestRate::at_start(model).map_or(1.0, |fastest| fastest.rate);
    let power = (1.0 - libm::log10(rate)).round().min(0.0);
    format!("1e{power}").parse().unwrap_or(1.0)
}

/// The exponents; once the observer stops, over the intervals that are done.
///
/// # Errors
/// The motion cannot be followed.
pub fn find(model: &Model, spec: &Spec, observer: &dyn Observer) -> Result<Exponents, Refusal> {
    let began = Instant::now();
    let total = (spec.transient + spec.intervals) as f64;
    let found = exponents(model, spec, &mut |done| {
        observer.progress(done, &|| {
            let rate = done * total / began.elapsed().as_secs_f64();
            format!("{rate:.0} intervals/s")
        });
        observer.going_on()
    });
    found.map_err(|error| refused(&error, model))
}

/// Everything as one document.
pub fn document(model: &Model, source: &str, spec: &Spec, found: &Exponents) -> Object {
    let list = |values: &[f64]| -> Vec<Json> { values.iter().map(|&x| Json::Number(x)).collect() };
    let parameters = model.parameter_values::<f64>(&[]);
    Object::new(Digits::DOUBLE)
        .with("exponents", list(&found.values))
        .with("errors", list(&found.errors))
        .with("dimension", found.dimension)
        .with("time", found.time)
        .with("intervals", found.intervals as i64)
        .with("interval", spec.interval)
        .with("model", Object::new(Digits::DOUBLE).with("source", source))
        .named("parameters", &model.parameter_names(), &parameters)
        .with("version", env!("CARGO_PKG_VERSION"))
}
