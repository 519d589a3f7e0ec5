//! Why a request has no answer: typed, in plain words, for every face to tell in its own way.

use chatter::model::{ModelError, ModelErrors};
use chatter_files::FileError;

/// Why there is no answer.
///
/// Texts name what was asked by its option of the command line, such as `--until`: a face with another notation puts its own
/// in their place, by [`Refusal::told`].
#[derive(Debug)]
pub enum Refusal {
    /// Errors of a model or of a text set into it, already complete messages.
    Model(ModelErrors),
    /// The same for one error.
    ModelPart(Box<ModelError>),
    /// Another wrong input, and what to do about it.
    Input {
        /// What is wrong.
        message: String,
        /// What to do about it.
        help: Option<String>,
    },
    /// What was asked for is in order, but there is no answer, or none was found.
    Unfinished {
        /// Why.
        message: String,
        /// What to do about it.
        help: Option<String>,
    },
    /// A result could not be written.
    Output(String),
    /// The user broke it off before there was anything to show.
    Interrupted,
}

impl Refusal {
    /// Wrong input.
    pub fn input(message: impl ToString) -> Self {
        Self::Input {
            message: message.to_string(),
            help: None,
        }
    }

    /// With what to do about it.
    #[must_use]
    pub fn help(self, help: impl Into<String>) -> Self {
        match self {
            Self::Input { message, .. } => Self::Input {
                message,
                help: Some(help.into()),
            },
            other => other,
        }
    }

    /// With the name that is probably meant.
    #[must_use]
    pub fn did_you_mean(self, name: Option<String>) -> Self {
        match name {
            Some(name) => self.help(format!("did you mean `{name}`?")),
            None => self,
        }
    }

    /// The same with options in another notation: of each its name without the dashes is asked.
    #[must_use]
    pub fn told(self, notation: &dyn Fn(&str) -> String) -> Self {
        let told = |text: String| in_notation(&text, notation);
        match self {
            Self::Input { message, help } => Self::Input {
                message: told(message),
                help: help.map(told),
            },
            Self::Unfinished { message, help } => Self::Unfinished {
                message: told(message),
                help: help.map(told),
            },
            Self::Output(message) => Self::Output(told(message)),
            Self::ModelPart(error) => {
                let name = told(error.source_name().to_owned());
                Self::ModelPart(Box::new(error.with_source_name(&name)))
            }
            other @ (Self::Model(_) | Self::Interrupted) => other,
        }
    }
}

/// A text with each `--option` in another notation.
pub fn in_notation(text: &str, notation: &dyn Fn(&str) -> String) -> String {
    let mut told = String::new();
    let mut rest = text;
    while let Some(place) = rest.find("--") {
        let (before, option) = rest.split_at(place);
        told += before;
        let name = &option[2..];
        let end = name.find(|c: char| !c.is_ascii_lowercase() && c != '-');
        let (name, after) = name.split_at(end.unwrap_or(name.len()));
        told += &if name.is_empty() {
            "--".to_owned()
        } else {
            notation(name)
        };
        rest = after;
    }
    told + rest
}

impl From<ModelErrors> for Refusal {
    fn from(errors: ModelErrors) -> Self {
        Self::Model(errors)
    }
}

impl From<ModelError> for Refusal {
    fn from(error: ModelError) -> Self {
        Self::ModelPart(Box::new(error))
    }
}

impl From<FileError> for Refusal {
    fn from(error: FileError) -> Self {
        Self::Output(error.to_string())
    }
}

impl From<chatter_files::Error> for Refusal {
    fn from(error: chatter_files::Error) -> Self {
        Self::Output(error.to_string())
    }
}

impl From<chatter_figures::Error> for Refusal {
    fn from(error: chatter_figures::Error) -> Self {
        Self::Output(error.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_told_in_another_notation() {
        let python = |name: &str| name.replace('-', "_");
        let told = |text| in_notation(text, &python);
        assert_eq!(
            told("`--period-tolerance` is -1"),
            "`period_tolerance` is -1"
        );
        assert_eq!(
            told("add --start carry:both, or --box"),
            "add start carry:both, or box"
        );
        assert_eq!(told("a -- b---c"), "a -- b_c");
        assert_eq!(told(""), "");
    }
}
