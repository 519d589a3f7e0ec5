//! The universal map as text.

use crate::aligned::{Side, aligned};
use crate::numbers::{Digits, full};
use crate::terminal::Style;
use crate::universal::atlas::limits;
use crate::universal::{Findings, window_sheet};
use chatter::analysis::diagram::Outcome;
use chatter::analysis::universal::Universal;
use chatter::numerics::{DoubleDouble, Real};

/// The whole account.
pub fn account<R: Real>(findings: &Findings<R>, style: Style) -> String {
    let digits = findings.digits;
    let block = |title: &str, rows: &[Vec<String>], sides: &[Side]| {
        format!("{}\n{}", style.title(title), aligned(rows, sides))
    };
    let constants = constant_rows(findings.universal, digits);
    let mut text = block("universal map", &constants, &[]);
    if let Some(values) = findings.value_sheet() {
        text.push('\n');
        text += &block(values.title, &values.text(digits), &[]);
    }
    if let Some(windows) = &findings.windows {
        let title = format!("windows in mu, K = {}", full(findings.slope, digits));
        text.push('\n');
        text += &block(&title, &window_sheet(windows).text(digits), &[Side::Right]);
    }
    if let Some(scaling) = &findings.scaling {
        let row = |&(name, value, meaning): &(&str, DoubleDouble, &str)| {
            vec![
                name.replace('_', " "),
                full(value, digits),
                meaning.to_owned(),
            ]
        };
        let rows: Vec<Vec<String>> = limits(scaling).iter().map(row).collect();
        text.push('\n');
        text += &block("scaling", &rows, &[]);
    }
    for sheet in &findings.sheets {
        text.push('\n');
        text += &block(
            sheet.title,
            &sheet.text(digits),
            &[Side::Right, Side::Right],
        );
    }
    if findings.undecided > 0 {
        text += &format!(
            "\n{} intervals of mu were given up: there may be more windows of periodic orbits\n",
            findings.undecided
        );
    }
    if let Some((sweep, rows)) = &findings.diagram {
        let range = &sweep.spec().sweeps[0];
        let title = format!(
            "orbits for {} values of {} from {} to {}",
            range.count,
            range.name(),
            range.from,
            range.to
        );
        let mut lines = Vec::new();
        for outcome in Outcome::ALL {
            let count = rows.iter().filter(|row| row.outcome == outcome).count();
            if count > 0 {
                lines.push(vec![outcome.name().replace('_', " "), count.to_string()]);
            }
        }
        text.push('\n');
        text += &block(&title, &lines, &[Side::Left, Side::Right]);
    }
    text
}

/// The constants of a restitution: name, value and meaning of each, a row each.
fn constant_rows<R: Real>(universal: &Universal<R>, digits: Digits) -> Vec<Vec<String>> {
    let constants = universal.constants();
    let (begin, end) = universal.window();
    let row = |name: &str, value: R, meaning: &str| {
        vec![name.to_owned(), full(value, digits), meaning.to_owned()]
    };
    vec![
        row("restitution r", constants.restitution, ""),
        row(
            "fixed point u*",
            constants.chatter_fixed_point,
            "the border between complete and incomplete chatter",
        ),
        row(
            "lambda",
            constants.lambda,
            "factor of the distance from release, impact to impact",
        ),
        row(
            "eta",
            constants.eta,
            "factor of u - u*, from an impact to the one before",
        ),
        row(
            "exponent",
            constants.exponent,
            "log lambda^2 / log eta: Upsilon(x) is of the order of x to this power",
        ),
        row("window of Q", begin, "eta x_e, where lap 1 ends"),
        row("", end, "x_e = Q(3/8), where lap 0 ends"),
    ]
}
