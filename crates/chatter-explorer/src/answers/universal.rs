//! The universal map near a border: its curve and an orbit on it.

use super::Answering;
use super::file::Extension;
use crate::question::UniversalQuestion;
use crate::record::Kind;
use chatter::analysis::universal::{Universal, UniversalMap};
use chatter_work::Refusal;
use chatter_work::universal::{Cobweb, refused};
use serde_json::json;

fn map(question: &UniversalQuestion) -> Result<UniversalMap<f64>, Refusal> {
    let universal = Universal::new(question.restitution).map_err(refused)?;
    UniversalMap::new(universal, question.slope, question.mu).map_err(refused)
}

/// A document, and as numbers z and the next z of the curve, then z along the orbit.
pub fn answer(answering: &Answering, question: &UniversalQuestion) -> Result<(), Refusal> {
    let map = map(question)?;
    let cobweb = Cobweb::new(&map);
    let constants = map.universal().constants();
    answering.document(&json!({
        "restitution": question.restitution,
        "slope": question.slope,
        "mu": question.mu,
        "eta": constants.eta,
        "exponent": constants.exponent,
        "range": cobweb.range,
    }))?;
    let (z, next) = &cobweb.curve;
    [z, next, &cobweb.orbit]
        .into_iter()
        .try_for_each(|column| answering.numbers(Kind::Numbers, column))
}

/// The cobweb as a file.
pub fn file(
    answering: &Answering,
    question: &UniversalQuestion,
    kind: Extension,
) -> Result<(), Refusal> {
    let map = map(question)?;
    let cobweb = Cobweb::new(&map);
    if kind.is_picture() {
        return answering.figure("cobweb", kind, &cobweb.figure());
    }
    answering.tables("cobweb", kind, |path| {
        let written = cobweb.dataset().write(path);
        written.map_err(|error| Refusal::Output(error.to_string()))
    })
}
