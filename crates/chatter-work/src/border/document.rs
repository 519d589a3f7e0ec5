//! Border orbits as one JSON document.

use super::compared::list;
use super::{Answer, Subject};
use crate::json::{Json, Object};
use crate::universal::window_sheet;
use chatter::analysis::border::{
    Border, BorderError, BreakCause, Estimate, LeadingOrder, Memory, WindowComparison,
};
use chatter::analysis::diagram::Outcome;
use chatter::analysis::universal::Argument;
use chatter::numerics::Real;

/// The whole answer.
pub fn document<R: Real + Argument<Real = R>>(subject: &Subject, answer: &Answer<R>) -> Object {
    let model = Object::new(subject.digits)
        .with("source", subject.source)
        .with(
            "title",
            subject
                .model
                .title
                .as_deref()
                .map_or(Json::Null, Json::from),
        );
    let (names, values) = subject.fixed::<R>();
    let about = |object: Object| {
        object
            .with("model", model)
            .named("parameters", &names, &values)
            .with("version", env!("CARGO_PKG_VERSION"))
    };
    match answer {
        Answer::One { border, compared } => about(one(
            subject,
            border,
            compared.as_deref().unwrap_or_default(),
        )),
        Answer::All {
            found, low, high, ..
        } => {
            let borders = answer.borders().into_iter();
            let borders: Vec<Json> = borders
                .map(|(border, compared)| one(subject, border, compared.unwrap_or_default()).into())
                .collect();
            let breaks = found.breaks.iter().map(|place| {
                Object::new(subject.digits)
                    .number("value", place.value)
                    .with("cause", cause(place.cause))
                    .with("message", place.to_string())
                    .into()
            });
            let unfollowed = found.unfollowed.iter().map(|place| {
                Object::new(subject.digits)
                    .number("value", place.value)
                    .with("outcome", Outcome::from(&place.error).name())
                    .with("cause", place.error.name())
                    .with("message", place.error.to_string())
                    .into()
            });
            about(
                Object::new(subject.digits)
                    .with("borders", borders)
                    .with("breaks", breaks.collect::<Vec<Json>>())
                    .with("range", vec![Json::Number(*low), Json::Number(*high)])
                    .with("samples", subject.samples as i64 + 1)
                    .with("excursions", subject.excursions as i64)
                    .with("without_chatter", found.without_chatter as i64)
                    .with("unfollowed", unfollowed.collect::<Vec<Json>>())
                    .with("unresolved", found.unresolved as i64)
                    .with(
                        "outcome",
                        if found.is_complete {
                            "complete"
                        } else {
                            "interrupted"
                        },
                    ),
            )
        }
    }
}

fn one<R: Real + Argument<Real = R>>(
    subject: &Subject,
    border: &Border<R>,
    compared: &[WindowComparison],
) -> Object {
    let states = subject.model.state_names();
    let section: Vec<Json> = border
        .section
        .iter()
        .map(|&index| states[index].into())
        .collect();
    let constants = &border.constants;
    let forcing: Vec<Json> = (border.turns.iter())
        .map(|turn| {
            Object::new(subject.digits)
                .with("state", states[turn.state])
                .number("period", turn.period)
                .with("count", turn.count)
                .into()
        })
        .collect();
    let object = Object::new(subject.digits)
        .with("parameter", border.parameter.as_str())
        .number("value", border.value.value)
        .with("error", border.value.error)
        .number("restitution", constants.restitution)
        .number("chatter_fixed_point", constants.chatter_fixed_point)
        .number("lambda", constants.lambda)
        .number("eta", constants.eta)
        .number("exponent", constants.exponent)
        .named("release", &states, &border.release.state)
        .named("first_impact", &states, &border.first_impact.state)
        .number("first_impact_time", border.first_impact.time)
        .number("first_impact_rate_before", border.first_impact.rate_before)
        .number("period", border.period.value)
        .with("period_error", border.period.error)
        .with("forcing", forcing)
        .with("long_flights", border.long_flights as i64)
        .with("impacts", border.impacts as i64)
        .with("section", section)
        .with("exact", exact(subject, border));
    let object = match &border.leading_order {
        Ok(form) => object.with("leading_order", leading_order(subject, form)),
        Err(section) => object.with("leading_order", Json::Null).with(
            "leading_order_error",
            BorderError::from(section.clone()).to_string(),
        ),
    };
    let place = border.value.value.to_f64();
    object
        .with("windows", windows(subject, border))
        .with("simulated_windows", list(compared, place, subject.digits))
}

fn exact<R: Real>(subject: &Subject, border: &Border<R>) -> Object {
    let exact = &border.exact;
    let flight: Vec<Vec<R>> = exact
        .flight
        .iter()
        .map(|row| Estimate::values(row))
        .collect();
    let flight_errors = exact.flight.iter().map(|row| Json::List(errors(row)));
    let with = |object: Object, name: &str, estimates: &[Estimate<R>]| {
        object
            .numbers(name, &Estimate::values(estimates))
            .with(&format!("{name}_error"), errors(estimates))
    };
    let object = Object::new(subject.digits)
        .number("slope", exact.slope.value)
        .number("unfolding_rate", exact.unfolding_rate.value)
        .with("slope_error", exact.slope.error)
        .with("unfolding_rate_error", exact.unfolding_rate.error)
        .number("amplitude", exact.amplitude.value)
        .with("amplitude_error", exact.amplitude.error);
    let object = with(object, "covector", &exact.covector)
        .number("covector_parameter", exact.covector_parameter.value)
        .with("covector_parameter_error", exact.covector_parameter.error)
        .rows("flight", &flight)
        .with("flight_error", flight_errors.collect::<Vec<Json>>());
    let object = with(object, "offset", &exact.offset);
    let object = with(
        object,
        "first_impact_by_upsilon",
        &exact.first_impact_by_upsilon,
    );
    let object = with(
        object,
        "first_impact_by_parameter",
        &exact.first_impact_by_parameter,
    );
    match &exact.memory {
        Some(form) => object.with("memory", memory(subject, form)),
        None => object,
    }
}

/// With more than three states: what orbits remember from passage to passage.
fn memory<R: Real>(subject: &Subject, form: &Memory<R>) -> Object {
    let states = subject.model.state_names();
    let names: Vec<Json> = form.states.iter().map(|&i| states[i].into()).collect();
    Object::new(subject.digits)
        .with("states", names)
        .rows("returns", &form.returns)
        .numbers("by_upsilon", &form.by_upsilon)
        .numbers("by_parameter", &form.by_parameter)
        .numbers("covector", &form.covector)
        .number("slope", form.slope)
        .number("doubling_slope", form.doubling_slope)
}

fn errors<R: Real>(estimates: &[Estimate<R>]) -> Vec<Json> {
    let error = |estimate: &Estimate<R>| Json::Number(estimate.error);
    estimates.iter().map(error).collect()
}

fn leading_order<R: Real>(subject: &Subject, form: &LeadingOrder<R>) -> Object {
    let section = Object::new(subject.digits)
        .with("state", form.section.state.as_str())
        .with("level", form.section.level);
    Object::new(subject.digits)
        .rows("A", &form.a)
        .numbers("B", &form.b)
        .numbers("C", &form.c)
        .number("D", form.d)
        .numbers("E", &form.e)
        .numbers("F", &form.f)
        .number("slope", form.slope)
        .number("unfolding_rate", form.unfolding_rate)
        .with("section", section)
        .numbers("crossing", &form.crossing)
}

/// Predicted windows, in the parameter.
fn windows<R: Real + Argument<Real = R>>(subject: &Subject, border: &Border<R>) -> Json {
    match super::prediction(subject, border) {
        Some(windows) => window_sheet(&windows).json(subject.digits),
        None => Json::Null,
    }
}

fn cause(cause: BreakCause) -> &'static str {
    match cause {
        BreakCause::Graze { .. } => "graze",
        BreakCause::Elsewhere => "elsewhere",
        BreakCause::Short { .. } => "short",
        BreakCause::NoChatter => "no_chatter",
        BreakCause::Unfollowed => "unfollowed",
        BreakCause::Jump => "jump",
    }
}
