//! The border near a value or those of a range, and their windows.

use super::refused::refused;
use super::{Answer, Subject, compared};
use crate::observer::Observer;
use crate::parallel;
use crate::refusal::Refusal;
use chatter::analysis::border::BorderSpec;
use chatter::analysis::border_search::{search_near, search_range};
use chatter::analysis::universal::Argument;
use chatter::numerics::Real;
use std::time::Instant;

/// Where borders are looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// The one nearest to this value.
    Near(f64),
    /// All from the first to the second value.
    Range(f64, f64),
}

/// What is looked for, and where.
#[derive(Clone, Debug)]
pub struct Question {
    /// How.
    pub spec: BorderSpec,
    /// Where.
    pub place: Place,
}

/// What is found at a place. Once the observer stops, windows are missing, and borders of the rest of a range.
///
/// # Errors
/// There is no border near the value, the place is none, or the search was stopped before anything was found.
pub fn find<R: Real + Argument<Real = R>>(
    subject: &Subject,
    question: &Question,
    observer: &dyn Observer,
) -> Result<Answer<R>, Refusal> {
    let spec = &question.spec;
    match question.place {
        Place::Near(value) => near(subject, spec, value, observer),
        Place::Range(low, high) => range(subject, spec, (low, high), observer),
    }
}

/// The part of the work that is the search, beside that of the windows.
const SEARCH: f64 = 0.9;

fn near<R: Real + Argument<Real = R>>(
    subject: &Subject,
    spec: &BorderSpec,
    value: f64,
    observer: &dyn Observer,
) -> Result<Answer<R>, Refusal> {
    let border = search_near::<R>(subject.model, spec, value, &mut |reached| {
        observer.progress(SEARCH * reached.done, &|| {
            "looking for the border orbit".to_owned()
        });
        observer.going_on()
    });
    let border = border.map_err(refused)?.ok_or(Refusal::Interrupted)?;
    let windows = compared(subject, spec, &border, &mut |done| {
        let done = (1.0 - SEARCH).mul_add(done, SEARCH);
        observer.progress(done, &|| "looking for its windows".to_owned());
        observer.going_on()
    });
    let compared = match windows {
        Err(Refusal::Interrupted) => None,
        windows => Some(windows?),
    };
    Ok(Answer::One {
        border: Box::new(border),
        compared,
    })
}

fn range<R: Real + Argument<Real = R>>(
    subject: &Subject,
    spec: &BorderSpec,
    (low, high): (f64, f64),
    observer: &dyn Observer,
) -> Result<Answer<R>, Refusal> {
    let began = Instant::now();
    let found = search_range::<R>(subject.model, spec, (low, high), &mut |reached| {
        observer.progress(SEARCH * reached.done, &|| {
            let rate = reached.done * spec.samples as f64 / began.elapsed().as_secs_f64();
            let borders = match reached.borders {
                1 => "1 border".to_owned(),
                count => format!("{count} borders"),
            };
            format!("{borders}, {rate:.0} parts/s")
        });
        observer.going_on()
    });
    let found = found.map_err(refused)?;
    observer.progress(SEARCH, &|| "looking for their windows".to_owned());
    let windows = match found.is_complete {
        true => parallel::each(&found.borders, observer.stop(), |border| {
            compared(subject, spec, border, &mut |_| observer.going_on())
        }),
        false => Err(Refusal::Interrupted),
    };
    let compared = match windows {
        Err(Refusal::Interrupted) => None,
        windows => Some(windows?),
    };
    Ok(Answer::All {
        found,
        compared,
        low,
        high,
    })
}
