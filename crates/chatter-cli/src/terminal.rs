//! What a terminal adds: colour, progress, Ctrl-C. A pipe sees none of it.

use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{ErrorKind, IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// A run shorter than this shows no progress.
const QUIET_FOR: Duration = Duration::from_millis(700);

/// Time between two frames of the bar.
const BETWEEN_FRAMES: Duration = Duration::from_millis(100);

/// Steps of the progress bar.
const BAR_LENGTH: u64 = 1000;

/// The text styles of the command line.
#[derive(Clone, Copy, Debug)]
pub struct Style {
    colored: bool,
}

impl Style {
    /// With escape sequences, or without.
    pub const fn new(colored: bool) -> Self {
        Self { colored }
    }

    /// As standard output allows.
    pub fn of_stdout() -> Self {
        Self::new(wants_color(std::io::stdout().is_terminal()))
    }

    /// A title.
    pub fn title(self, text: &str) -> String {
        self.wrap("1", text)
    }

    /// A remark that may be overlooked.
    pub fn faint(self, text: &str) -> String {
        self.wrap("2", text)
    }

    /// The word that introduces an error.
    pub fn error(self, text: &str) -> String {
        self.wrap("1;31", text)
    }

    /// The word that introduces a warning.
    pub fn warning(self, text: &str) -> String {
        self.wrap("1;33", text)
    }

    fn wrap(self, code: &str, text: &str) -> String {
        if self.colored {
            format!("\x1b[{code}m{text}\x1b[0m")
        } else {
            text.to_owned()
        }
    }
}

/// Tells the user of an error.
pub fn complain(message: &str) {
    let title = Style::new(colors_on_stderr()).error("error:");
    eprintln!("{title} {message}");
}

/// Warns the user of what a result may not be good for.
pub fn warn(message: &str) {
    let title = Style::new(colors_on_stderr()).warning("warning:");
    eprintln!("{title} {message}");
}

/// Tells the user what goes on beside the result.
pub fn remark(message: &str) {
    eprintln!("{message}");
}

/// Whether errors may be coloured.
pub fn colors_on_stderr() -> bool {
    wants_color(std::io::stderr().is_terminal())
}

/// NO_COLOR: see no-color.org.
fn wants_color(is_terminal: bool) -> bool {
    let set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    let dumb = std::env::var_os("TERM").is_some_and(|term| term == "dumb");
    is_terminal && !set("NO_COLOR") && !dumb
}

/// Writes a finished text to standard output. A reader that has gone away, such as `head`, is no error.
pub fn print(text: &str) -> Result<(), String> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(format!("cannot write to standard output: {error}"))
        }
        _ => Ok(()),
    }
}

static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// From here on Ctrl-C asks for a clean end; a second one ends the program at once.
pub fn catch_interrupts() {
    let installed = ctrlc::set_handler(|| {
        if INTERRUPTED.swap(true, Ordering::Relaxed) {
            std::process::exit(crate::failure::INTERRUPTED.into());
        }
    });
    // Without a handler Ctrl-C ends the program as usual: nothing is lost but what was computed.
    drop(installed);
}

/// Set once Ctrl-C is pressed.
pub fn interrupt_flag() -> &'static AtomicBool {
    &INTERRUPTED
}

/// Whether Ctrl-C was pressed.
pub fn interrupted() -> bool {
    INTERRUPTED.load(Ordering::Relaxed)
}

/// A bar on the error stream for runs that last, if that is a terminal.
pub struct Progress {
    began: Instant,
    shown: Instant,
    bar: Option<ProgressBar>,
    wanted: bool,
}

impl Progress {
    /// Shows nothing yet.
    pub fn new() -> Self {
        let now = Instant::now();
        Self {
            began: now,
            shown: now,
            bar: None,
            wanted: std::io::stderr().is_terminal(),
        }
    }

    /// Shows that this part of the work is done.
    pub fn show(&mut self, done: f64, message: impl FnOnce() -> String) {
        let waiting = if self.bar.is_none() {
            QUIET_FOR
        } else {
            BETWEEN_FRAMES
        };
        if !self.wanted || self.shown.elapsed() < waiting {
            return;
        }
        self.shown = Instant::now();
        let bar = self.bar.get_or_insert_with(|| {
            let bar = ProgressBar::with_draw_target(Some(BAR_LENGTH), ProgressDrawTarget::stderr());
            if let Ok(style) = ProgressStyle::with_template("{bar:32} {percent:>3} %  {msg}") {
                bar.set_style(style);
            }
            bar
        });
        let done = done.clamp(0.0, 1.0);
        let left = self.began.elapsed().as_secs_f64() * (1.0 - done) / done;
        let left = match left {
            left if left.is_finite() => format!(
                ", {} left",
                HumanDuration(Duration::from_secs_f64(left.min(1e9)))
            ),
            _ => String::new(),
        };
        bar.set_position((done * BAR_LENGTH as f64) as u64);
        bar.set_message(format!("{}{left}", message()));
    }

    /// Takes the bar away.
    pub fn finish(self) {
        if let Some(bar) = self.bar {
            bar.finish_and_clear();
        }
    }
}
