//! What goes wrong at the face: told once, on the error stream, with an exit code that scripts can tell apart.

use crate::terminal;
use chatter::model::{ModelError, ModelErrors, Palette};
use std::process::ExitCode;

/// Everything went as asked.
pub const SUCCESS: u8 = 0;
/// The computation could not be finished; what was computed before is in the output.
pub const UNFINISHED: u8 = 1;
/// What was asked for is wrong: nothing was computed or written.
pub const BAD_INPUT: u8 = 2;
/// Broken off by Ctrl-C, what was computed before is in the output: 128 and the signal's number, as shells have it.
pub const INTERRUPTED: u8 = 130;

/// Why a command ends without result.
#[derive(Debug)]
pub enum Failure {
    /// Errors of a model or of a text set into it, already complete messages.
    Model(ModelErrors),
    /// The same for one error.
    ModelPart(Box<ModelError>),
    /// Another wrong input: the message without its leading `error: `, and what to do about it.
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
    /// Ctrl-C, before there was anything to show.
    Interrupted,
}

impl Failure {
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

    /// Tells the user, and gives the exit code.
    pub fn report(&self) -> ExitCode {
        let colored = terminal::colors_on_stderr();
        let palette = if colored {
            Palette::Ansi
        } else {
            Palette::Plain
        };
        let style = terminal::Style::new(colored);
        let titled = |message: &str| format!("{} {message}", style.error("error:"));
        let text = match self {
            // Made visible where they are rendered.
            Self::Model(errors) => {
                terminal::tell(&errors.render(palette));
                return BAD_INPUT.into();
            }
            Self::ModelPart(error) => {
                terminal::tell(&error.render(palette));
                return BAD_INPUT.into();
            }
            Self::Input { message, help } | Self::Unfinished { message, help } => match help {
                Some(help) => format!("{}\n  help: {help}", titled(message)),
                None => titled(message),
            },
            Self::Output(message) => titled(message),
            Self::Interrupted => titled("broken off"),
        };
        terminal::remark(&text);
        match self {
            Self::Output(_) | Self::Unfinished { .. } => UNFINISHED.into(),
            Self::Interrupted => INTERRUPTED.into(),
            _ => BAD_INPUT.into(),
        }
    }
}

impl From<ModelErrors> for Failure {
    fn from(errors: ModelErrors) -> Self {
        Self::Model(errors)
    }
}

impl From<ModelError> for Failure {
    fn from(error: ModelError) -> Self {
        Self::ModelPart(Box::new(error))
    }
}
