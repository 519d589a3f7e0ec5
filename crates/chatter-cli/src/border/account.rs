//! Border orbits as text.

use super::{Answer, Subject};
use crate::aligned::{Side, aligned};
use crate::numbers::{concise, full};
use crate::terminal::Style;
use crate::universal::window_rows;
use chatter::analysis::border::{Border, Estimate, LeadingOrder};
use chatter::analysis::universal::Argument;
use chatter::numerics::Real;

/// The whole answer.
pub fn account<R: Real + Argument<Real = R>>(
    subject: &Subject,
    answer: &Answer<R>,
    style: Style,
) -> String {
    let title = subject.model.title.as_deref().unwrap_or(subject.source);
    let mut text = format!("{}  {}\n", style.title(title), style.faint(subject.source));
    match answer {
        Answer::One(border) => text += &one(subject, border, style),
        Answer::All { found, low, high } => {
            for border in &found.borders {
                text += &one(subject, border, style);
            }
            text.push('\n');
            text += &match found.borders.len() {
                0 => format!("there is no border between {low} and {high}\n"),
                1 => format!("one border between {low} and {high}\n"),
                count => format!("{count} borders between {low} and {high}\n"),
            };
            for place in &found.breaks {
                text += &format!("no border, though complete chatter ends: {place}\n");
            }
        }
    }
    text
}

fn one<R: Real + Argument<Real = R>>(
    subject: &Subject,
    border: &Border<R>,
    style: Style,
) -> String {
    let mut text = String::new();
    for (title, rows, sides) in blocks(subject, border) {
        text += &format!("\n{}\n{}", style.title(&title), aligned(&rows, sides));
    }
    if let Err(error) = &border.leading_order {
        text += &format!(
            "\n{} no leading order: {error}\n",
            style.warning("warning:")
        );
    }
    text
}

/// Digits of an error estimate.
const ERROR_DIGITS: u32 = 2;

type Block = (String, Vec<Vec<String>>, &'static [Side]);

fn blocks<R: Real + Argument<Real = R>>(subject: &Subject, border: &Border<R>) -> Vec<Block> {
    const WORDS: &[Side] = &[];
    let number = |value: R| full(value, subject.digits);
    let estimate = |estimate: &Estimate<R>| {
        [
            number(estimate.value),
            format!("± {}", concise(estimate.error, ERROR_DIGITS)),
        ]
    };
    let row = |name: &str, values: &[String]| {
        let mut row = vec![name.to_owned()];
        row.extend_from_slice(values);
        row
    };
    let parameter = &border.parameter;
    let states = subject.model.state_names();
    let by_state = |values: &[R]| {
        let named = states.iter().zip(values);
        named
            .map(|(name, &value)| row(name, &[number(value)]))
            .collect::<Vec<_>>()
    };
    let constants = &border.constants;
    let exact = &border.exact;

    let orbit = vec![
        row(&format!("{parameter}*"), &estimate(&border.value)),
        row("period", &estimate(&border.period)),
        row("impacts followed", &[border.impacts.to_string()]),
    ];
    let mut first = by_state(&border.first_impact.state);
    first.push(row(
        "time since release",
        &[number(border.first_impact.time)],
    ));
    let numbers = vec![
        row("restitution r", &[number(constants.restitution)]),
        row("fixed point u*", &[number(constants.chatter_fixed_point)]),
        row("lambda", &[number(constants.lambda)]),
        row("eta", &[number(constants.eta)]),
        row("exponent", &[number(constants.exponent)]),
    ];
    let mut form = vec![
        row("slope K", &estimate(&exact.slope)),
        row("unfolding rate M", &estimate(&exact.unfolding_rate)),
        row("amplitude N*", &estimate(&exact.amplitude)),
    ];
    for (covector, &index) in exact.covector.iter().zip(&border.section) {
        form.push(row(&format!("C by {}", states[index]), &estimate(covector)));
    }
    form.push(row(
        &format!("D by {parameter}"),
        &estimate(&exact.covector_parameter),
    ));

    let mut blocks = vec![
        (format!("border orbit in {parameter}"), orbit, WORDS),
        (
            "release, and end of chatter".to_owned(),
            by_state(&border.release.state),
            WORDS,
        ),
        ("after the first impact".to_owned(), first, WORDS),
        ("chatter near release".to_owned(), numbers, WORDS),
        (
            format!("exact: z -> Upsilon(K z + mu), mu = M ({parameter} - {parameter}*)"),
            form,
            WORDS,
        ),
    ];
    if let Ok(form) = &border.leading_order {
        blocks.push(leading_order(subject, form));
    }
    if let Some(windows) = super::prediction(subject, border) {
        let title = format!("predicted with the exact form: values of {parameter}");
        blocks.push((title, window_rows(&windows, subject.digits), &[Side::Right]));
    }
    blocks
}

fn leading_order<R: Real>(subject: &Subject, form: &LeadingOrder<R>) -> Block {
    let number = |value: R| full(value, subject.digits);
    let row = |name: &str, values: &[R]| {
        let mut row = vec![name.to_owned()];
        row.extend(values.iter().map(|&value| number(value)));
        row
    };
    let rows = vec![
        row("slope CAB", &[form.slope]),
        row("unfolding rate CAE + CF + D", &[form.unfolding_rate]),
        row("A", &form.a[0]),
        row("", &form.a[1]),
        row("B", &form.b),
        row("C", &form.c),
        row("D", &[form.d]),
        row("E", &form.e),
        row("F", &form.f),
        row("gap and rate on the section", &form.crossing),
    ];
    let section = &form.section;
    let title = format!(
        "leading order, section {} = {}",
        section.state, section.level
    );
    (title, rows, &[])
}
