//! What a terminal adds: colour, progress, Ctrl-C. A pipe sees none of it.

use crate::failure::Failure;
use crate::json::Object;
use chatter::model::visible;
use chatter_files::atomic_file::discard_unfinished;
use chatter_work::Observer;
use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;
use std::io::{BufWriter, ErrorKind, IsTerminal, StdoutLock, Write};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// A run shorter than this shows no progress.
const QUIET_FOR: Duration = Duration::from_millis(700);

/// Time between two frames of the bar.
const BETWEEN_FRAMES: Duration = Duration::from_millis(100);

/// Steps of the progress bar.
const BAR_LENGTH: u64 = 1000;

/// Begins one of our own escape sequences until it is printed: a character that no text may hold, so that all others
/// that act on a terminal can be told from ours and made visible.
const BEGIN: char = '\u{FDD0}';

/// What is to be printed, with nothing in it that acts on the terminal but our own styles. Titles, names and file names
/// may hold anything.
pub fn printable(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    let mut rest = text.chars();
    while let Some(c) = rest.next() {
        match c {
            BEGIN => {
                // Ours have nothing but digits and semicolons up to the letter.
                let code: String = (rest.as_str().chars())
                    .take_while(|c| c.is_ascii_digit() || *c == ';')
                    .collect();
                if rest.as_str()[code.len()..].starts_with('m') {
                    shown += "\x1b[";
                } else {
                    shown.push(char::REPLACEMENT_CHARACTER);
                }
            }
            _ => shown.push(visible(c)),
        }
    }
    shown
}

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
            format!("{BEGIN}{code}m{text}{BEGIN}0m")
        } else {
            text.to_owned()
        }
    }
}

/// Tells the user of an error.
pub fn complain(message: &str) {
    let title = Style::new(colors_on_stderr()).error("error:");
    remark(&format!("{title} {message}"));
}

/// Warns the user of what a result may not be good for.
pub fn warn(message: &str) {
    let title = Style::new(colors_on_stderr()).warning("warning:");
    remark(&format!("{title} {message}"));
}

/// Tells the user what goes on beside the result.
pub fn remark(message: &str) {
    tell(&printable(message));
}

/// Writes a line that is printable to the error stream. Where that cannot be written there is nobody to tell.
pub fn tell(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
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
    let text = printable(text);
    wrote(out.write_all(text.as_bytes()).and_then(|()| out.flush()))
}

/// Standard output for a long text that comes in pieces, each of whole lines.
pub struct Printer {
    out: BufWriter<StdoutLock<'static>>,
}

impl Printer {
    /// Of standard output.
    pub fn new() -> Self {
        Self {
            out: BufWriter::with_capacity(1 << 16, std::io::stdout().lock()),
        }
    }

    /// The styles that it allows.
    pub fn style(&self) -> Style {
        Style::of_stdout()
    }

    /// Prints the next piece.
    pub fn print(&mut self, text: &str) -> Result<(), Failure> {
        let written = self.out.write_all(printable(text).as_bytes());
        wrote(written).map_err(Failure::Output)
    }

    /// Has all of it printed.
    pub fn finish(mut self) -> Result<(), Failure> {
        wrote(self.out.flush()).map_err(Failure::Output)
    }
}

fn wrote(written: std::io::Result<()>) -> Result<(), String> {
    match written {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(format!("cannot write to standard output: {error}"))
        }
        _ => Ok(()),
    }
}

/// Writes a JSON document to standard output, piece by piece.
pub fn print_json(document: &impl Serialize) -> Result<(), String> {
    let out = BufWriter::with_capacity(1 << 16, std::io::stdout().lock());
    let mut out = Escaping(out);
    let written = serde_json::to_writer_pretty(&mut out, document)
        .map_err(std::io::Error::from)
        .and_then(|()| out.write_all(b"\n"))
        .and_then(|()| out.flush());
    wrote(written)
}

/// What a command has to say.
pub enum Answer {
    /// To people.
    Text(String),
    /// To programs.
    Document(Object),
}

impl Answer {
    /// Writes it to standard output.
    pub fn print(&self) -> Result<(), Failure> {
        let printed = match self {
            Self::Text(text) => print(text),
            Self::Document(document) => print_json(document),
        };
        printed.map_err(Failure::Output)
    }
}

/// Standard output for a JSON document that is written piece by piece.
pub fn json_stdout() -> impl Write {
    Escaping(std::io::stdout().lock())
}

/// Escapes in JSON what a terminal would act on, which leaves the document the same.
struct Escaping<W>(W);

impl<W: Write> Write for Escaping<W> {
    /// The serializer hands over whole fragments of texts.
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        match std::str::from_utf8(bytes) {
            Ok(text) if text.chars().any(|c| visible(c) != c) => {
                for c in text.chars() {
                    if visible(c) == c {
                        write!(self.0, "{c}")?;
                    } else {
                        // Outside of texts JSON is plain; all such characters have four digits.
                        write!(self.0, "\\u{:04x}", u32::from(c))?;
                    }
                }
            }
            _ => self.0.write_all(bytes)?,
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.0.flush()
    }
}

static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Whether Ctrl-C ends the program at once.
static ENDS_AT_ONCE: AtomicBool = AtomicBool::new(false);

/// From here on Ctrl-C asks for a clean end, which keeps what is done; a second one ends the program at once.
pub fn catch_interrupts() {
    ENDS_AT_ONCE.store(false, Ordering::Relaxed);
    let installed = ctrlc::set_handler(|| {
        let again = INTERRUPTED.swap(true, Ordering::Relaxed);
        if again || ENDS_AT_ONCE.load(Ordering::Relaxed) {
            discard_unfinished();
            if std::io::stderr().is_terminal() {
                // In place of the bar, if there is one.
                let _ = write!(std::io::stderr(), "\r\x1b[K");
            }
            let _ = crate::failure::report(&Failure::Interrupted);
            std::process::exit(crate::failure::INTERRUPTED.into());
        }
    });
    // It can be installed once, and without it Ctrl-C ends the program as usual: nothing is lost but what was computed.
    drop(installed);
}

/// From here on Ctrl-C ends the program at once: all that is done is in files already, or is nothing by itself.
pub fn end_on_interrupt() {
    catch_interrupts();
    ENDS_AT_ONCE.store(true, Ordering::Relaxed);
}

/// Set once Ctrl-C is pressed.
pub fn interrupt_flag() -> &'static AtomicBool {
    &INTERRUPTED
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

    /// Whether it is time to show something, or something else.
    fn is_due(&self) -> bool {
        let waiting = if self.bar.is_none() {
            QUIET_FOR
        } else {
            BETWEEN_FRAMES
        };
        self.wanted && self.shown.elapsed() >= waiting
    }

    /// Shows that this part of the work is done.
    pub fn show(&mut self, done: f64, message: impl FnOnce() -> String) {
        if !self.is_due() {
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

/// Hears for the user: shows progress until it is dropped, tells remarks, stops at Ctrl-C.
pub struct Console {
    shown: Mutex<Shown>,
}

/// What a console shows: that something goes on, until it is known how far it is.
#[derive(Default)]
struct Shown {
    waiting: Option<Waiting>,
    progress: Option<Progress>,
}

impl Console {
    /// Shows nothing yet.
    pub fn new() -> Self {
        Self {
            shown: Mutex::new(Shown {
                waiting: Some(Waiting::new("beginning")),
                progress: Some(Progress::new()),
            }),
        }
    }
}

impl Observer for Console {
    fn progress(&self, done: f64, message: &dyn Fn() -> String) {
        if let Ok(mut shown) = self.shown.lock() {
            let Shown { waiting, progress } = &mut *shown;
            if let Some(progress) = progress
                && progress.is_due()
            {
                drop(waiting.take());
                progress.show(done, message);
            }
        }
    }

    fn remark(&self, text: &str) {
        remark(text);
    }

    fn stop(&self) -> &AtomicBool {
        interrupt_flag()
    }
}

impl Drop for Console {
    /// What is printed next finds the line empty.
    fn drop(&mut self) {
        if let Ok(shown) = self.shown.get_mut() {
            drop(shown.waiting.take());
            if let Some(progress) = shown.progress.take() {
                progress.finish();
            }
        }
    }
}

/// Shows that something is going on that cannot tell how far it is, until it is dropped.
pub struct Waiting {
    /// Ends the thread by being dropped.
    end: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Waiting {
    /// For `what`, such as "looking for borders".
    pub fn new(what: &'static str) -> Self {
        if !std::io::stderr().is_terminal() {
            return Self {
                end: None,
                thread: None,
            };
        }
        let (end, ended) = channel();
        let thread = std::thread::spawn(move || {
            let still = || ended.recv_timeout(QUIET_FOR) == Err(RecvTimeoutError::Timeout);
            if !still() {
                return;
            }
            let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
            if let Ok(style) = ProgressStyle::with_template("{spinner} {msg}, {elapsed}") {
                bar.set_style(style);
            }
            bar.set_message(what);
            bar.enable_steady_tick(BETWEEN_FRAMES);
            while still() {}
            bar.finish_and_clear();
        });
        Self {
            end: Some(end),
            thread: Some(thread),
        }
    }
}

impl Drop for Waiting {
    /// What is printed next finds the line empty.
    fn drop(&mut self) {
        drop(self.end.take());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_but_our_own_styles_acts_on_the_terminal() {
        let title = "a\u{1b}[31m\u{7}\u{9b}31m\u{fdd0}b\u{fdd0}1\u{202e}é\r\n\tΩ";
        let shown = "a␛[31m␇\u{fffd}31m\u{fffd}b\u{fffd}1\u{fffd}é␍\n\tΩ";
        assert_eq!(printable(&Style::new(false).title(title)), shown);
        let styled = printable(&Style::new(true).title(title));
        assert_eq!(styled, format!("\u{1b}[1m{shown}\u{1b}[0m"));
    }
}
