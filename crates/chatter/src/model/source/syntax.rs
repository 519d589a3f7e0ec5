//! What is wrong with a text that is not TOML, in words for somebody who writes equations.

use crate::model::error::ModelErrorKind;
use core::ops::Range;

/// What an error of the TOML reader means here, and where.
pub(in crate::model) fn syntax_error(
    text: &str,
    error: &toml::de::Error,
) -> (ModelErrorKind, Range<usize>) {
    let span = error.span().unwrap_or(0..0);
    let there = text.get(span.clone()).unwrap_or_default();
    let message = error.message();
    if message.starts_with("string values must be quoted") {
        let kind = match there {
            "" => ModelErrorKind::MissingValue,
            bare => ModelErrorKind::Unquoted {
                text: bare.to_owned(),
            },
        };
        return (kind, span);
    }
    if message == "duplicate key" {
        let key = there.trim_matches(['"', '\'']).to_owned();
        return (ModelErrorKind::DuplicateKey { key }, span);
    }
    if let Some((number, span)) = number_at(text, span.start) {
        let text = number.to_owned();
        let is_expression = text.contains(['*', '/', '^', '(']);
        let kind = match is_expression {
            true => ModelErrorKind::Unquoted { text },
            false => ModelErrorKind::NotANumber { text },
        };
        return (kind, span);
    }
    let unclosed = ["invalid basic string", "invalid literal string"];
    let message = if unclosed.iter().any(|start| message.starts_with(start)) {
        "a closing quote is missing".to_owned()
    } else {
        message.to_owned()
    };
    (ModelErrorKind::Syntax { message }, span)
}

/// The value that `at` is in, of a line or within a table in one line, if it starts as a number does.
fn number_at(text: &str, at: usize) -> Option<(&str, Range<usize>)> {
    let start = text
        .get(..at)?
        .rfind(['\n', '='])
        .map_or(0, |before| before + 1);
    let line = text[start..].lines().next()?;
    let in_table = text[..start].lines().next_back()?.contains('{');
    let value = match in_table {
        true => line.split(['#', ',', '}']).next()?,
        false => line.split('#').next()?,
    };
    let value_start = start + (value.len() - value.trim_start().len());
    let value = value.trim();
    let span = value_start..value_start + value.len();
    let is_number = value.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
    (is_number && (span.start..=span.end).contains(&at)).then_some((value, span))
}
