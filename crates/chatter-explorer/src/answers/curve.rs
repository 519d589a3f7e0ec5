//! The curve of a special point in two parameters.

use super::Answering;
use super::file::{Extension, stem};
use crate::question::{self, CurveQuestion};
use chatter::analysis::periodic::{Branch, End, Known, Record, SpecialKind};
use chatter_work::Refusal;
use chatter_work::numbers::Digits;
use chatter_work::periodic::{
    Curve, Reach, Subject, curves_document, find_curve, free_parameter, plane, specification, write,
};
use chatter_work::source::Loaded;

struct Found {
    loaded: Loaded,
    free: [usize; 2],
    curve: (SpecialKind, Branch),
}

impl Found {
    fn subject<'a>(&'a self, question: &'a CurveQuestion) -> Subject<'a> {
        Subject {
            model: &self.loaded.model,
            source: &question.model.name,
            text: &self.loaded.text,
            free: self.free.to_vec(),
            monitors: &[],
            digits: Digits::DOUBLE,
        }
    }
}

fn found(answering: &Answering, question: &CurveQuestion) -> Result<Found, Refusal> {
    let mut loaded = question.model.load(&answering.context.files)?;
    let model = &mut loaded.model;
    let section = question.section.as_deref();
    let spec = specification(model, question.period.as_deref(), (section, &[]))?;
    let [first, second] = &question.parameters;
    let free = [
        free_parameter(model, first)?,
        free_parameter(model, second)?,
    ];
    if free[0] == free[1] {
        return Err(Refusal::input(format!(
            "`{first}` is named twice: expected two parameters"
        )));
    }
    let range = question::range(question.from, question.to)?;
    let wanted = Curve {
        spec,
        free,
        known: known(question, model.states.len())?,
        limits: Reach::default().over(range)?,
    };
    let mut keep = |_: &Record| Ok(());
    let curve = find_curve(model, &wanted, (Vec::new(), &mut keep), answering)?;
    if curve.1.ends.contains(&End::Interrupted) {
        return Err(Refusal::Interrupted);
    }
    Ok(Found {
        loaded,
        free,
        curve,
    })
}

/// The point that is asked about.
fn known(question: &CurveQuestion, states: usize) -> Result<Known, Refusal> {
    let kind = SpecialKind::named(&question.kind)
        .ok_or_else(|| Refusal::input(format!("no special point is called `{}`", question.kind)))?;
    if question.state.len() != states {
        return Err(Refusal::input(format!(
            "the point has {} states, and the model {states}",
            question.state.len()
        )));
    }
    Ok(Known {
        kind,
        monitor: None,
        state: question.state.clone(),
        period: question.orbit_period,
    })
}

/// The curve as a document.
pub fn answer(answering: &Answering, question: &CurveQuestion) -> Result<(), Refusal> {
    let found = found(answering, question)?;
    let curves = core::slice::from_ref(&found.curve);
    answering.document(&curves_document(&found.subject(question), curves))
}

/// The curve as a file.
pub fn file(
    answering: &Answering,
    question: &CurveQuestion,
    kind: Extension,
) -> Result<(), Refusal> {
    let found = found(answering, question)?;
    let subject = found.subject(question);
    let stem = stem(&question.model.name, "curve");
    if kind.is_picture() {
        let curves = core::slice::from_ref(&found.curve);
        return answering.figure(&stem, kind, &plane(&subject, curves, None));
    }
    let curve = core::slice::from_ref(&found.curve.1);
    answering.tables(&stem, kind, |path| {
        write(&subject, &question.model.set, curve, path)
    })
}
