//! The curve of a return map of one dimension, and the files of a return map: its points, and its curve where it has one.

use super::file::{Extension, stem};
use super::history::asked;
use super::{Answering, diagram, history};
use crate::question::{DiagramQuestion, HistoryQuestion, ModelQuestion};
use crate::record::Kind;
use chatter::model::Model;
use chatter_work::Refusal;
use chatter_work::simulation::picture::ReturnCurve;
use chatter_work::simulation::{Rows, follow};
use serde_json::{Value, json};

/// The curve that the points of a motion are on, and the model.
fn found(
    answering: &Answering,
    question: &HistoryQuestion,
) -> Result<(Option<ReturnCurve>, Model), Refusal> {
    let asked = asked(answering, question)?;
    let curve = if ReturnCurve::possible(&asked.loaded.model) {
        let subject = asked.subject(question);
        let followed = follow::<f64>(&subject, &Rows::None, answering)?;
        let window = asked.window.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
        ReturnCurve::find(&subject, &followed.record, window, &question.panels()?)?
    } else {
        None
    };
    Ok((curve, asked.loaded.model))
}

/// A document that says how the curve is sampled, and as numbers values and what they are mapped to; without a curve, null.
pub fn answer(answering: &Answering, question: &HistoryQuestion) -> Result<(), Refusal> {
    let (Some(curve), model) = found(answering, question)? else {
        return answering.document(&Value::Null);
    };
    let (values, next) = curve.points(&model, answering)?;
    answering.document(&json!({
        "name": curve.name,
        "held": curve.held,
        "level": curve.level,
        "sweep": curve.sweep,
    }))?;
    answering.numbers(Kind::Numbers, &values)?;
    answering.numbers(Kind::Numbers, &next)
}

/// The return map as files.
pub fn file(
    answering: &Answering,
    question: &HistoryQuestion,
    kind: Extension,
) -> Result<(), Refusal> {
    let name = stem(&question.model.name, "returns");
    history::written(answering, question, (&name, kind))?;
    if kind.is_picture() {
        return Ok(());
    }
    match found(answering, question)? {
        (Some(curve), _) => {
            let of_curve = swept(question, &curve);
            diagram::written(answering, &of_curve, (&format!("{name}-curve"), kind))
        }
        (None, _) => Ok(()),
    }
}

/// The diagram that the curve is.
fn swept(question: &HistoryQuestion, curve: &ReturnCurve) -> DiagramQuestion {
    let mut initial = question.model.initial.clone();
    initial.retain(|(name, _)| *name != curve.name && *name != curve.held);
    initial.push((curve.held.clone(), curve.level.to_string()));
    let model = ModelQuestion {
        initial,
        ..question.model.clone()
    };
    DiagramQuestion {
        model,
        runs: vec![vec![curve.sweep.clone()]],
        section: curve.section.clone(),
        at: curve.kind.map(|kind| kind.name().to_owned()),
        observe: vec![curve.name.clone()],
        transient: Some(0),
        keep: Some("1".to_owned()),
        ..DiagramQuestion::default()
    }
}
