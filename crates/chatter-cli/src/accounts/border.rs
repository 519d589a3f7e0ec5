//! Border orbits as text.

use crate::aligned::{Side, aligned};
use crate::border::{Answer, NAMES, Subject, ends, known, prediction};
use crate::numbers::{Digits, concise, full};
use crate::terminal::Style;
use crate::universal::window_sheet;
use chatter::analysis::border::{Border, BorderError, Estimate, LeadingOrder, WindowComparison};
use chatter::analysis::border_search::Borders;
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
    text += &format!("  {}\n", setting(subject));
    for (border, compared) in answer.borders() {
        text += &one(subject, border, compared, style);
    }
    if let Answer::All {
        found, low, high, ..
    } = answer
    {
        text += &format!("\n{}", summary(subject, found, (*low, *high)));
    }
    text
}

/// The parameters that are not varied.
fn setting(subject: &Subject) -> String {
    let (names, values) = subject.fixed::<f64>();
    let mut parts = vec![format!("{} varied", subject.parameter)];
    let fixed = names.iter().zip(values);
    parts.extend(fixed.map(|(name, value)| format!("{name} = {}", concise(value, 8))));
    parts.join(", ")
}

/// Digits of the ends of a range.
const RANGE_DIGITS: u32 = 10;

/// Breaks that are told one by one.
const BREAKS_TOLD: usize = 6;

fn summary<R>(subject: &Subject, found: &Borders<R>, (low, high): (f64, f64)) -> String {
    let count = match found.borders.len() {
        0 => "no border".to_owned(),
        1 => "one border".to_owned(),
        count => format!("{count} borders"),
    };
    let mut text = format!(
        "{count} between {} and {}, looked for at {} values\n",
        concise(low, RANGE_DIGITS),
        concise(high, RANGE_DIGITS),
        subject.samples + 1
    );
    for place in found.breaks.iter().take(BREAKS_TOLD) {
        text += &format!("no border, though complete chatter ends: {place}\n");
    }
    if found.breaks.len() > BREAKS_TOLD {
        let more = found.breaks.len() - BREAKS_TOLD;
        text += &format!("and at {more} more places (--json lists them)\n");
    }
    if found.without_chatter > 0 {
        text += &format!(
            "no chatter within {} at {} of these values: --excursions allows more\n",
            match subject.excursions {
                1 => "one long flight".to_owned(),
                count => format!("{count} long flights"),
            },
            found.without_chatter
        );
    }
    if let Some(first) = found.unfollowed.first() {
        text += &match found.unfollowed.len() {
            1 => format!("the motion cannot be followed {first}\n"),
            count => format!(
                "the motion cannot be followed at {count} of these values (--json lists them): first {first}\n"
            ),
        };
    }
    if !found.is_complete {
        text += "interrupted: there may be more in what was not searched\n";
    }
    if found.unresolved > 0 {
        text += &format!(
            "{} more changes between complete and incomplete chatter were not looked into: try a smaller range\n",
            found.unresolved
        );
    }
    text
}

fn one<R: Real + Argument<Real = R>>(
    subject: &Subject,
    border: &Border<R>,
    compared: Option<&[WindowComparison]>,
    style: Style,
) -> String {
    let mut text = String::new();
    for (title, rows, sides) in blocks(subject, border, compared.unwrap_or_default()) {
        text += &format!("\n{}\n{}", style.title(&title), aligned(&rows, sides));
    }
    if let Some(compared) = compared {
        text += &not_found(subject.laps(border), compared);
    }
    if let Err(section) = &border.leading_order {
        let error = BorderError::from(section.clone());
        text += &format!(
            "\n{} no leading order: {error}\n",
            style.warning("warning:")
        );
    }
    text
}

/// The n asked for whose windows were not found in the model: those found are in a row.
fn not_found((first, last): (i64, i64), compared: &[WindowComparison]) -> String {
    let (begin, end) = match compared {
        [] => (last + 1, last),
        [begin, ..] => (
            begin.predicted.lap,
            compared[compared.len() - 1].predicted.lap,
        ),
    };
    let runs: Vec<String> = [(first, begin), (end + 1, last + 1)]
        .into_iter()
        .filter(|(from, to)| from < to)
        .map(|(from, to)| match to - from {
            1 => from.to_string(),
            _ => format!("{from} to {}", to - 1),
        })
        .collect();
    if runs.is_empty() {
        return String::new();
    }
    format!("not found in the model for n = {}\n", runs.join(", "))
}

/// Digits of an error estimate.
const ERROR_DIGITS: u32 = 2;

type Block = (String, Vec<Vec<String>>, &'static [Side]);

fn row(name: &str, values: impl IntoIterator<Item = String>) -> Vec<String> {
    let mut row = vec![name.to_owned()];
    row.extend(values);
    row
}

fn blocks<R: Real + Argument<Real = R>>(
    subject: &Subject,
    border: &Border<R>,
    compared: &[WindowComparison],
) -> Vec<Block> {
    const WORDS: &[Side] = &[];
    let digits = subject.text_digits;
    let number = |value: R| full(value, digits);
    let estimate = |estimate: &Estimate<R>| {
        let error = format!("± {}", concise(estimate.error, ERROR_DIGITS));
        [full(estimate.value, known(estimate, digits)), error]
    };
    let parameter = &border.parameter;
    let states = subject.model.state_names();
    let named = |values: &[R]| {
        let named = states.iter().zip(values);
        named
            .map(|(name, &value)| format!("{name} = {}", number(value)))
            .collect::<Vec<_>>()
            .join(", ")
    };
    let constants = &border.constants;
    let exact = &border.exact;
    let first = &border.first_impact;

    let mut orbit = vec![
        row(
            &format!("{parameter}*"),
            [estimate(&border.value).join(" ")],
        ),
        row("period", [estimate(&border.period).join(" ")]),
        row("release", [named(&border.release.state)]),
        row("first impact", [named(&first.state)]),
        row("", [format!("{} after release", number(first.time))]),
    ];
    if border.long_flights > 1 {
        let count = format!("{}, then chatter", border.long_flights);
        orbit.push(row("long flights", [count]));
    }
    let numbers = vec![
        row("restitution r", [number(constants.restitution)]),
        row("fixed point u*", [number(constants.chatter_fixed_point)]),
        row("lambda", [number(constants.lambda)]),
        row("eta", [number(constants.eta)]),
    ];
    let mut form = vec![
        row("slope K", estimate(&exact.slope)),
        row("unfolding rate M", estimate(&exact.unfolding_rate)),
        row("amplitude N*", estimate(&exact.amplitude)),
    ];
    for (covector, &index) in exact.covector.iter().zip(&border.section) {
        let name = format!("C = dX/d{}", states[index]);
        form.push(row(&name, estimate(covector)));
    }
    let name = format!("D = dX/d{parameter}");
    form.push(row(&name, estimate(&exact.covector_parameter)));
    if let Some(memory) = &exact.memory {
        form.push(row("K without memory", [number(memory.slope)]));
        form.push(row("K of doublings", [number(memory.doubling_slope)]));
        for (returns, &index) in memory.returns.iter().zip(&memory.states) {
            let name = format!("{} remembered", states[index]);
            form.push(row(&name, returns.iter().map(|&x| number(x))));
        }
    }

    let mut blocks = vec![
        (format!("border orbit in {parameter}"), orbit, WORDS),
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
    if let Some(windows) = prediction(subject, border) {
        let title = format!("values of {parameter} predicted for the orbit with n + 1 impacts");
        const SIDES: &[Side] = &[Side::Right];
        blocks.push((title, window_sheet(&windows).text(digits), SIDES));
    }
    if !compared.is_empty() {
        let title = format!(
            "the model's own, and by how much of the distance from {parameter}* the prediction misses them"
        );
        let (rows, sides) = rows(compared, border.value.value.to_f64(), digits);
        blocks.push((title, rows, sides));
    }
    blocks
}

fn leading_order<R: Real>(subject: &Subject, form: &LeadingOrder<R>) -> Block {
    let number = |value: R| full(value, subject.text_digits);
    let row = |name: &str, values: &[R]| row(name, values.iter().map(|&value| number(value)));
    let mut rows = vec![
        row("CAB", &[form.slope]),
        row("CAE + CF + D", &[form.unfolding_rate]),
    ];
    for (place, part) in form.a.iter().enumerate() {
        rows.push(row(if place == 0 { "A" } else { "" }, part));
    }
    rows.extend([
        row("B", &form.b),
        row("C", &form.c),
        row("D", &[form.d]),
        row("E", &form.e),
        row("F", &form.f),
    ]);
    let section = &form.section;
    let title = format!(
        "leading order, section {} = {}",
        section.state,
        concise(section.level, subject.text_digits.0)
    );
    (title, rows, &[])
}

/// Decimals of a percentage at most.
const PERCENT_DECIMALS: f64 = 3.0;

/// Rows of text with a heading, and the sides of their columns.
fn rows(
    windows: &[WindowComparison],
    border: f64,
    digits: Digits,
) -> (Vec<Vec<String>>, &'static [Side]) {
    const NUMBERS: &[Side] = &[Side::Right; 7];
    let named = NAMES.map(|name| [name.replace('_', " "), "missed by".to_owned()]);
    let heading = core::iter::once("n".to_owned()).chain(named.into_iter().flatten());
    let mut rows = vec![heading.collect()];
    for window in windows {
        let mut row = vec![window.predicted.lap.to_string()];
        for (found, off) in ends(window, border) {
            let missing = || "-".to_owned();
            row.push(found.map_or_else(missing, |found| full(found.value, known(&found, digits))));
            let percent = |off: f64, found: Estimate<f64>| {
                let error = 100.0 * found.error / (found.value - border).abs();
                // Up to the first digit of the error.
                let decimals = (-error.log10()).ceil().clamp(0.0, PERCENT_DECIMALS) as usize;
                format!("{:+.decimals$} %", 100.0 * off)
            };
            row.push(
                off.zip(found)
                    .map_or_else(missing, |(off, found)| percent(off, found)),
            );
        }
        rows.push(row);
    }
    (rows, NUMBERS)
}
