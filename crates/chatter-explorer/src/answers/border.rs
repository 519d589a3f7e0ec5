//! Border orbits over a range of a parameter, with the windows that are predicted beside them; one of them as a file.

use super::Answering;
use super::file::{Extension, stem};
use crate::question::{self, BorderQuestion};
use chatter::analysis::border::BorderSpec;
use chatter::analysis::border_search::search_range;
use chatter::model::Model;
use chatter_work::border::{
    Answer, Place, Question, Subject, document, find, overlay, picture, refused,
};
use chatter_work::numbers::Digits;
use chatter_work::periodic::free_parameter;
use chatter_work::{Observer as _, Refusal};

/// The model, but for the value of the parameter that is varied.
fn model(answering: &Answering, question: &BorderQuestion) -> Result<Model, Refusal> {
    let mut about = question.model.clone();
    about.set.retain(|(name, _)| *name != question.parameter);
    let model = about.load(&answering.context.files)?.model;
    model.check_defined()?;
    free_parameter(&model, &question.parameter)?;
    Ok(model)
}

fn subject<'a>(model: &'a Model, question: &'a BorderQuestion, spec: &BorderSpec) -> Subject<'a> {
    Subject {
        model,
        source: &question.model.name,
        parameter: &question.parameter,
        digits: Digits::DOUBLE,
        text_digits: Digits::DOUBLE,
        samples: spec.samples,
        excursions: spec.excursions,
        windows: None,
    }
}

/// The borders as a document.
pub fn answer(answering: &Answering, question: &BorderQuestion) -> Result<(), Refusal> {
    let model = model(answering, question)?;
    let spec = BorderSpec::new(&question.parameter);
    let (low, high) = question::range(question.from, question.to)?;
    let found = search_range::<f64>(&model, &spec, (low, high), &mut |reached| {
        let (done, borders) = (reached.done, reached.borders);
        answering.progress(done, &|| {
            format!("{:.0} %, borders: {borders}", 100.0 * done)
        });
        answering.going_on()
    });
    let found = found.map_err(refused)?;
    if !found.is_complete {
        return Err(Refusal::Interrupted);
    }
    let answer = Answer::All {
        found,
        compared: None,
        low,
        high,
    };
    answering.document(&document(&subject(&model, question, &spec), &answer))
}

/// The orbits over the windows beside a border, simulated and predicted, as a file.
pub fn file(
    answering: &Answering,
    question: &BorderQuestion,
    kind: Extension,
) -> Result<(), Refusal> {
    let near = question
        .near
        .ok_or_else(|| Refusal::input("a file shows one border: say near which value it is"))?;
    let model = model(answering, question)?;
    let spec = BorderSpec::new(&question.parameter);
    let subject = subject(&model, question, &spec);
    let asked = Question {
        spec,
        place: Place::Near(near),
    };
    let found = find::<f64>(&subject, &asked, answering)?;
    let (Answer::One { border, compared }, false) = (&found, answering.going_on().is_break())
    else {
        return Err(Refusal::Interrupted);
    };
    let compared = compared.as_deref().unwrap_or_default();
    let overlay = overlay(&subject, (&asked.spec, border, compared), answering)?;
    let stem = stem(&question.model.name, "border");
    if kind.is_picture() {
        return answering.figure(&stem, kind, &picture(&subject, &overlay));
    }
    answering.tables(&stem, kind, |path| {
        let written = overlay.dataset(&subject).write(path);
        written.map_err(|error| Refusal::Output(error.to_string()))
    })
}
