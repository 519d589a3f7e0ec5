//! Border orbits over a range of a parameter, with the windows that are predicted beside them.

use super::Answering;
use crate::question::BorderQuestion;
use chatter::analysis::border::{BorderSpec, search_range};
use chatter_work::border::{Answer, Subject, document, refused};
use chatter_work::numbers::Digits;
use chatter_work::periodic::free_parameter;
use chatter_work::{Observer as _, Refusal};

/// The borders as a document.
pub fn answer(answering: &Answering, question: &BorderQuestion) -> Result<(), Refusal> {
    let mut about = question.model.clone();
    about.set.retain(|(name, _)| *name != question.parameter);
    let model = about.load(&answering.context.files)?.model;
    model.check_defined()?;
    free_parameter(&model, &question.parameter)?;
    let spec = BorderSpec::new(&question.parameter);
    let (low, high) = (question.from, question.to);
    if !(low < high && low.is_finite() && high.is_finite()) {
        return Err(Refusal::input("expected a range, the smaller end first"));
    }
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
    let subject = Subject {
        model: &model,
        source: &question.model.name,
        parameter: &question.parameter,
        digits: Digits::DOUBLE,
        text_digits: Digits::DOUBLE,
        samples: spec.samples,
        excursions: spec.excursions,
        windows: None,
    };
    let answer = Answer::All {
        found,
        compared: None,
        low,
        high,
    };
    answering.document(&document(&subject, &answer))
}
