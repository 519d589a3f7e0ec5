//! Branches of periodic orbits and their special points.

use super::Answering;
use super::file::{Extension, stem};
use crate::question::{self, BranchesQuestion};
use chatter::analysis::periodic::{Branch, BranchSpec};
use chatter_work::Refusal;
use chatter_work::numbers::Digits;
use chatter_work::periodic::{
    Branches, Reach, Subject, beside, branch_document, find_branches, first_that_changes,
    free_parameter, picture, specification, write,
};
use chatter_work::source::Loaded;

/// Doublings of doublings.
const MOST_DOUBLINGS: u64 = 4;

struct Found {
    loaded: Loaded,
    parameter: usize,
    branches: Vec<Branch>,
}

impl Found {
    fn subject<'a>(&'a self, question: &'a BranchesQuestion) -> Subject<'a> {
        Subject {
            model: &self.loaded.model,
            source: &question.model.name,
            text: &self.loaded.text,
            free: vec![self.parameter],
            monitors: &[],
            digits: Digits::DOUBLE,
        }
    }
}

fn found(answering: &Answering, question: &BranchesQuestion) -> Result<Found, Refusal> {
    let mut question_model = question.model.clone();
    question_model
        .set
        .retain(|(name, _)| *name != question.parameter);
    let mut loaded = question_model.load(&answering.context.files)?;
    let model = &mut loaded.model;
    let section = question.section.as_deref();
    let spec = specification(model, question.period.as_deref(), (section, &[]))?;
    let parameter = free_parameter(model, &question.parameter)?;
    let range = question::range(question.from, question.to)?;
    let wanted = Branches {
        spec,
        over: BranchSpec {
            parameter,
            limits: Reach::default().over(range)?,
            beside: beside(question.doublings.min(MOST_DOUBLINGS), 0)?,
        },
        search: None,
    };
    let found = find_branches(model, &wanted, None, answering)?;
    if !found.complete {
        return Err(Refusal::Interrupted);
    }
    let branches = found.branches;
    Ok(Found {
        loaded,
        parameter,
        branches,
    })
}

/// The branches as a document.
pub fn answer(answering: &Answering, question: &BranchesQuestion) -> Result<(), Refusal> {
    let found = found(answering, question)?;
    answering.document(&branch_document(&found.subject(question), &found.branches))
}

/// The branches as a file.
pub fn file(
    answering: &Answering,
    question: &BranchesQuestion,
    kind: Extension,
) -> Result<(), Refusal> {
    let found = found(answering, question)?;
    let subject = found.subject(question);
    let stem = stem(&question.model.name, "branches");
    if kind.is_picture() {
        let vertical = first_that_changes(&subject, &found.branches);
        return answering.figure(
            &stem,
            kind,
            &picture(&subject, &found.branches, vertical, None),
        );
    }
    answering.tables(&stem, kind, |path| {
        write(&subject, &question.model.set, &found.branches, path)
    })
}
