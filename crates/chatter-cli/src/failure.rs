//! What goes wrong at the command line: told once, on the error stream, with an exit code that scripts can tell apart.

use crate::terminal;
use chatter::model::Palette;

/// Everything went as asked.
pub const SUCCESS: u8 = 0;
/// The computation could not be finished; what was computed before is in the output.
pub const UNFINISHED: u8 = 1;
/// What was asked for is wrong: nothing was computed or written.
pub const BAD_INPUT: u8 = 2;
/// Broken off by Ctrl-C, what was computed before is in the output: 128 and the signal's number, as shells have it.
pub const INTERRUPTED: u8 = 130;

/// Why a command ends without result.
pub type Failure = chatter_work::Refusal;

/// Tells the user, and gives the exit code.
pub fn report(failure: &Failure) -> u8 {
    let colored = terminal::colors_on_stderr();
    let palette = if colored {
        Palette::Ansi
    } else {
        Palette::Plain
    };
    let style = terminal::Style::new(colored);
    let titled = |message: &str| format!("{} {message}", style.error("error:"));
    let text = match failure {
        // Made visible where they are rendered.
        Failure::Model(errors) => {
            terminal::tell(&errors.render(palette));
            return BAD_INPUT;
        }
        Failure::ModelPart(error) => {
            terminal::tell(&error.render(palette));
            return BAD_INPUT;
        }
        Failure::Input { message, help } | Failure::Unfinished { message, help } => match help {
            Some(help) => format!("{}\n  help: {help}", titled(message)),
            None => titled(message),
        },
        Failure::Output(message) => titled(message),
        Failure::Interrupted => titled("broken off"),
    };
    terminal::remark(&text);
    match failure {
        Failure::Output(_) | Failure::Unfinished { .. } => UNFINISHED,
        Failure::Interrupted => INTERRUPTED,
        _ => BAD_INPUT,
    }
}
