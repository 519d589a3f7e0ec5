//! What can be wrong with the text of an expression, in one clear sentence each.

use super::parser::{DEEPEST_NESTING, LONGEST_TEXT};
use super::suggest::function_names;
use core::fmt;
use core::ops::Range;

/// Why a text is not an expression, and where.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct ParseError {
    /// The bytes of the text that are wrong; empty at its end where something is missing there.
    pub span: Range<usize>,
    /// What is wrong.
    pub kind: ParseErrorKind,
    /// What to write in place of the span, where there is a good guess; nothing, where it is to be left out.
    pub suggestion: Option<String>,
}

/// What is wrong with the text of an expression.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum ParseErrorKind {
    /// There is nothing but white space.
    Empty,
    /// The text has more bytes than [`LONGEST_TEXT`].
    TooLong {
        /// Its length in bytes.
        bytes: usize,
    },
    /// Parentheses, signs or powers are nested deeper than [`DEEPEST_NESTING`].
    TooDeep,
    /// A character that no expression has.
    StrayCharacter(char),
    /// Digits and points that are not a number.
    MalformedNumber(String),
    /// A number too large or too small for double precision.
    NumberOutOfRange(String),
    /// A name that stands for nothing.
    UnknownName(String),
    /// A call of a function that does not exist.
    UnknownFunction(String),
    /// A call of a name that is a quantity.
    NotAFunction(String),
    /// A function without the parentheses of its argument.
    BareFunction(String),
    /// A call with another number of arguments than the function takes.
    ArgumentCount {
        /// The function.
        function: String,
        /// How many it takes, in words.
        expected: &'static str,
        /// How many arguments it was given.
        found: usize,
    },
    /// An operator, a parenthesis or the beginning is not followed by an operand.
    MissingOperand {
        /// What it should follow; `None` at the beginning.
        after: Option<String>,
        /// What is there; `None` at the end.
        found: Option<String>,
    },
    /// Two operands side by side, as in `2 x`.
    MissingOperator {
        /// The end of the first operand.
        before: String,
        /// The beginning of the second.
        after: String,
    },
    /// A number with a name after it that stands for nothing, as a unit does.
    NumberWithUnit(String),
    /// A name with points in it, as a function of another language's library has.
    QualifiedName(String),
    /// The first argument of `if` is a number.
    NotACondition,
    /// A comparison outside the first argument of `if`.
    StrayComparison,
    /// `and`, `or` or `not` outside the first argument of `if`.
    StrayWord(String),
    /// A comma outside the argument list of a function.
    StrayComma,
    /// An opening parenthesis, at the span, is never closed.
    UnclosedParenthesis,
    /// A closing parenthesis, at the span, was never opened.
    UnopenedParenthesis,
}

impl fmt::Display for ParseErrorKind {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => write!(out, "the expression is empty"),
            Self::TooLong { bytes } => write!(
                out,
                "the expression is {bytes} bytes long, more than the {LONGEST_TEXT} allowed; name its parts"
            ),
            Self::TooDeep => write!(
                out,
                "the expression is nested more than {DEEPEST_NESTING} deep; name its parts"
            ),
            Self::StrayCharacter('=') => write!(
                out,
                "unexpected `=`: conditions compare by `<` and `>`, and what is zero somewhere is written without `= 0`"
            ),
            Self::StrayCharacter(quote @ ('\'' | '"' | '\\')) => {
                write!(out, "unexpected character `{quote}`")
            }
            Self::StrayCharacter(character) => {
                write!(out, "unexpected character `{}`", character.escape_debug())
            }
            Self::MalformedNumber(text) => write!(out, "`{text}` is not a number"),
            Self::NumberOutOfRange(text) => write!(
                out,
                "the number `{text}` is out of range; sizes between 5e-324 and 1.7e308 can be held"
            ),
            Self::UnknownName(name) => write!(out, "unknown name `{name}`"),
            Self::UnknownFunction(name) => write!(out, "unknown function `{name}`"),
            Self::NotAFunction(name) => {
                write!(
                    out,
                    "`{name}` is not a function; an operator is missing before `(`"
                )
            }
            Self::BareFunction(name) => {
                write!(
                    out,
                    "the function `{name}` needs its argument in parentheses"
                )
            }
            Self::ArgumentCount {
                function,
                expected,
                found,
            } => {
                let are = if *found == 1 { "is" } else { "are" };
                write!(
                    out,
                    "`{function}` takes {expected}, but {found} {are} given"
                )
            }
            Self::NotACondition => write!(
                out,
                "the first argument of `if` is a condition such as `x > 0`, not a number"
            ),
            Self::StrayComparison => write!(
                out,
                "a comparison is true or false and no number: it stands in `if(x > 0, a, b)`"
            ),
            Self::StrayWord(word) => write!(
                out,
                "`{word}` joins conditions: it stands in the first argument of `if`"
            ),
            Self::MissingOperand { after, found } => {
                write!(out, "expected a number, a name or `(`")?;
                if let Some(after) = after {
                    write!(out, " after `{after}`")?;
                }
                match found {
                    Some(found) => write!(out, ", found `{found}`"),
                    None => write!(out, ", but the expression ends"),
                }
            }
            Self::MissingOperator { before, after } => {
                write!(out, "expected an operator between `{before}` and `{after}`")
            }
            Self::NumberWithUnit(name) => {
                write!(
                    out,
                    "unknown name `{name}` after a number, which has no unit"
                )
            }
            Self::QualifiedName(name) => write!(out, "`{name}` has a point in it, as no name here"),
            Self::StrayComma => write!(out, "unexpected `,`; the decimal sign is a point"),
            Self::UnclosedParenthesis => write!(out, "this parenthesis is never closed"),
            Self::UnopenedParenthesis => write!(out, "this parenthesis was never opened"),
        }
    }
}

impl ParseError {
    /// What to do about it, where there is a good guess: the second half of the message.
    pub fn help(&self) -> Option<String> {
        match (&self.kind, &self.suggestion) {
            (
                ParseErrorKind::MissingOperator { .. }
                | ParseErrorKind::NumberWithUnit(_)
                | ParseErrorKind::NotAFunction(_)
                | ParseErrorKind::BareFunction(_)
                | ParseErrorKind::QualifiedName(_)
                | ParseErrorKind::StrayCharacter(_),
                Some(suggestion),
            ) => Some(match suggestion.as_str() {
                "" => "leave it out".to_owned(),
                _ => format!("write `{suggestion}`"),
            }),
            (_, Some(suggestion)) => Some(format!("did you mean `{suggestion}`?")),
            (ParseErrorKind::UnknownFunction(_), None) => {
                let functions: Vec<&str> = function_names().collect();
                Some(format!("there are {}", functions.join(", ")))
            }
            (ParseErrorKind::StrayCharacter('\''), None) => {
                Some("a rate goes by a name: with y = \"v\" that of `y` is `v`".to_owned())
            }
            (ParseErrorKind::StrayCharacter('['), None) => {
                Some("quantities go by their names, such as `x1`, not by numbers".to_owned())
            }
            (ParseErrorKind::StrayCharacter('\\'), None) => {
                Some("plain text is read, not LaTeX: `a/b`, `sin(x)`, `omega`".to_owned())
            }
            (ParseErrorKind::StrayCharacter('#'), None) => {
                Some("comments stand outside the quotes".to_owned())
            }
            (_, None) => None,
        }
    }
}

impl fmt::Display for ParseError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}", self.kind)?;
        match self.help() {
            Some(help) => write!(out, "; {help}"),
            None => Ok(()),
        }
    }
}

impl std::error::Error for ParseError {}
