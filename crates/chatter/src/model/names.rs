//! Rules for names, and lists of them in sentences.

use super::error::Role;
use crate::expressions::{is_name, is_reserved};
use core::fmt::Display;

/// Name of time in expressions.
pub(super) const TIME: &str = "t";

/// What the language itself means by a name, if it does.
pub(super) fn reserved_meaning(name: &str) -> Option<&'static str> {
    match name {
        TIME => Some("time"),
        "pi" => Some("the circle constant"),
        _ if is_reserved(name) => Some("a function"),
        _ => None,
    }
}

/// Whether `text` can name something in this role. Contacts and sections are no part of expressions, so their names
/// may have hyphens and begin with a digit.
pub(super) fn is_name_of(role: Role, text: &str) -> bool {
    match role {
        Role::Contact | Role::Section => {
            let fits = |c: char| c.is_alphanumeric() || c == '_' || c == '-';
            !text.is_empty() && text.chars().all(fits)
        }
        Role::State | Role::Parameter | Role::Definition | Role::Table | Role::Time => {
            is_name(text)
        }
    }
}

/// Longest list in a message.
const LISTED: usize = 12;

/// "`a`, `b` or `c`".
pub(super) fn alternatives<S: Display>(names: &[S]) -> String {
    match names {
        [most @ .., end] if !most.is_empty() && names.len() <= LISTED => {
            format!("{} or `{end}`", listed(most))
        }
        _ => listed(names),
    }
}

/// "`a`, `b`, `c`", the rest counted where there are many.
pub(super) fn listed<S: Display>(names: &[S]) -> String {
    let shown = names.iter().take(LISTED);
    let mut list: Vec<String> = shown.map(|name| format!("`{name}`")).collect();
    if let Some(more @ 1..) = names.len().checked_sub(LISTED) {
        list.push(format!("and {more} more"));
    }
    list.join(", ")
}
