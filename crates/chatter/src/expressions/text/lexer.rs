//! Cuts the text of an expression into tokens.

use super::parse_error::{ParseError, ParseErrorKind};
use super::suggest;
use crate::numerics::{DoubleDouble, Real};
use core::ops::Range;

/// Kinds of token.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(in crate::expressions) enum Token {
    Number(DoubleDouble),
    Name,
    Plus,
    Minus,
    Times,
    Divide,
    Power,
    Open,
    Close,
    Comma,
    Less,
    AtMost,
    Greater,
    AtLeast,
    End,
}

/// A token and the bytes of the text it was read from.
#[derive(Clone, PartialEq, Debug)]
pub(in crate::expressions) struct Lexeme {
    pub token: Token,
    pub span: Range<usize>,
}

/// Whether a name may begin with `character`.
fn starts_name(character: char) -> bool {
    character.is_alphabetic() || character == '_'
}

fn continues_name(character: char) -> bool {
    starts_name(character) || character.is_ascii_digit()
}

/// Whether `text` can be the name of a state, a parameter or a definition: letters of any script, digits and
/// underscores, the first not a digit.
pub fn is_name(text: &str) -> bool {
    text.starts_with(starts_name) && text.chars().all(continues_name)
}

/// Cuts `text` into tokens, the last of them `End`.
pub(in crate::expressions) fn tokens(text: &str) -> Result<Vec<Lexeme>, ParseError> {
    let mut lexemes = Vec::new();
    let mut at = 0;
    while let Some(character) = text[at..].chars().next() {
        let rest = &text[at..];
        let (token, length) = match character {
            _ if character.is_whitespace() => {
                at += character.len_utf8();
                continue;
            }
            '+' => (Token::Plus, 1),
            '-' => (Token::Minus, 1),
            '*' if rest.starts_with("**") => (Token::Power, 2),
            '*' => (Token::Times, 1),
            // The quotient without its fraction, as in Python.
            '/' if rest.starts_with("//") => {
                return Err(ParseError {
                    span: at..at + 2,
                    kind: ParseErrorKind::StrayCharacter(character),
                    suggestion: Some("floor(x/y)".to_owned()),
                });
            }
            '/' => (Token::Divide, 1),
            '^' => (Token::Power, 1),
            '(' => (Token::Open, 1),
            ')' => (Token::Close, 1),
            ',' => (Token::Comma, 1),
            '<' if rest.starts_with("<=") => (Token::AtMost, 2),
            '>' if rest.starts_with(">=") => (Token::AtLeast, 2),
            '<' => (Token::Less, 1),
            '>' => (Token::Greater, 1),
            '≤' => (Token::AtMost, character.len_utf8()),
            '≥' => (Token::AtLeast, character.len_utf8()),
            // Element by element, as in other languages.
            '.' if rest[1..].starts_with(['*', '/', '^']) => {
                return Err(ParseError {
                    span: at..at + 2,
                    kind: ParseErrorKind::StrayCharacter(character),
                    suggestion: Some(rest[1..2].to_owned()),
                });
            }
            '0'..='9' | '.' => {
                let length = number_length(rest);
                (Token::Number(number(text, at..at + length)?), length)
            }
            _ if starts_name(character) => {
                let length = name_length(rest);
                let whole = qualified_length(rest, length);
                if whole > length {
                    return Err(ParseError {
                        span: at..at + whole,
                        kind: ParseErrorKind::QualifiedName(rest[..whole].to_owned()),
                        suggestion: suggest::for_qualified(&rest[..whole]),
                    });
                }
                (Token::Name, length)
            }
            // `x[0]`; but `Sin[x]` calls a function.
            '[' if lexemes.last().is_some_and(|last: &Lexeme| {
                last.token == Token::Name
                    && last.span.end == at
                    && suggest::callable(&text[last.span.clone()].to_lowercase()).is_none()
            }) =>
            {
                return Err(ParseError {
                    span: at..at + 1,
                    kind: ParseErrorKind::StrayCharacter(character),
                    suggestion: None,
                });
            }
            _ => {
                return Err(ParseError {
                    span: at..at + character.len_utf8(),
                    kind: ParseErrorKind::StrayCharacter(character),
                    suggestion: suggest::for_character(rest),
                });
            }
        };
        lexemes.push(Lexeme {
            token,
            span: at..at + length,
        });
        at += length;
    }
    lexemes.push(Lexeme {
        token: Token::End,
        span: text.len()..text.len(),
    });
    Ok(lexemes)
}

/// Bytes of the name that `text` starts with.
fn name_length(text: &str) -> usize {
    text.find(|c| !continues_name(c)).unwrap_or(text.len())
}

/// Bytes of the name and of what follows it after points, as in `np.sin`.
fn qualified_length(text: &str, mut length: usize) -> usize {
    while let Some(part) = text[length..].strip_prefix('.')
        && part.starts_with(starts_name)
    {
        length += 1 + name_length(part);
    }
    length
}

/// Bytes of the longest thing at the start of `text` that looks meant as one number, well formed or not.
fn number_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let mut length = 0;
    while let Some(byte) = bytes.get(length) {
        match byte {
            b'0'..=b'9' | b'.' => length += 1,
            // A digit separator, as other languages have it, would otherwise begin a name.
            b'_' if bytes.get(length + 1).is_some_and(u8::is_ascii_digit) => length += 1,
            b'e' | b'E' => {
                let sign = matches!(bytes.get(length + 1), Some(b'+' | b'-'));
                let digit = length + 1 + usize::from(sign);
                if !bytes.get(digit).is_some_and(u8::is_ascii_digit) {
                    break;
                }
                let digits = bytes[digit..].iter().take_while(|b| b.is_ascii_digit());
                return digit + digits.count();
            }
            _ => break,
        }
    }
    length
}

fn number(text: &str, span: Range<usize>) -> Result<DoubleDouble, ParseError> {
    let written = &text[span.clone()];
    let Ok(value) = written.parse::<DoubleDouble>() else {
        let joined = written.replace('_', "");
        let suggestion = joined.parse::<DoubleDouble>().is_ok().then_some(joined);
        return Err(ParseError {
            span,
            kind: ParseErrorKind::MalformedNumber(written.to_string()),
            suggestion,
        });
    };
    if value.is_lost_of(written) || !value.to_f64().is_finite() {
        return Err(ParseError {
            span,
            kind: ParseErrorKind::NumberOutOfRange(written.to_string()),
            suggestion: None,
        });
    }
    Ok(value)
}
