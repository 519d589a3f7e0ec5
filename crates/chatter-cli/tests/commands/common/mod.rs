//! The program as its tests run it.

use serde_json::Value;
use std::path::PathBuf;
use std::process::{Child, Command, Output, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

/// A folder of its own for each test, removed at the end.
pub struct Folder(PathBuf);

impl Folder {
    pub fn new(test: &str) -> Self {
        // Tests of one name may run side by side.
        static MADE: AtomicU32 = AtomicU32::new(0);
        let number = MADE.fetch_add(1, Ordering::Relaxed);
        let name = format!("chatter-{test}-{}-{number}", std::process::id());
        let path = std::env::temp_dir().join(name);
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    pub fn file(&self, name: &str) -> String {
        self.path(name).to_str().unwrap().to_owned()
    }

    pub fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).unwrap();
    }

    /// A file with this text, by its path.
    pub fn with(&self, name: &str, text: &str) -> String {
        self.write(name, text);
        self.file(name)
    }

    pub fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap()
    }

    pub fn names(&self) -> Vec<String> {
        self.names_in(".")
    }

    pub fn names_in(&self, folder: &str) -> Vec<String> {
        let entries = std::fs::read_dir(self.path(folder)).unwrap();
        let name = |entry: std::io::Result<std::fs::DirEntry>| {
            entry.unwrap().file_name().into_string().unwrap()
        };
        let mut names: Vec<String> = entries.map(name).collect();
        names.sort();
        names
    }

    /// The program, as typed in a folder of this one.
    pub fn command(&self, folder: &str, line: &str) -> Command {
        let arguments: Vec<&str> = line.split_whitespace().collect();
        let mut command = command(&arguments);
        command.current_dir(self.path(folder));
        command
    }

    pub fn run(&self, folder: &str, line: &str) -> Output {
        self.command(folder, line).output().unwrap()
    }

    /// With no more than so many megabytes of address space.
    #[cfg(unix)]
    pub fn run_within(&self, megabytes: u64, line: &str) -> Output {
        let program = env!("CARGO_BIN_EXE_chatter");
        let limited = format!("ulimit -v {}; exec {program} {line}", megabytes * 1024);
        Command::new("sh")
            .args(["-c", &limited])
            .current_dir(&self.0)
            .output()
            .unwrap()
    }

    /// All that is said.
    pub fn succeeds(&self, folder: &str, line: &str) -> String {
        let output = self.run(folder, line);
        let errors = told(&output, 0, line);
        String::from_utf8(output.stdout).unwrap() + &errors
    }

    pub fn fails(&self, folder: &str, line: &str) -> String {
        told(&self.run(folder, line), 2, line)
    }

    /// Begins a diagram and kills it once so much of it is done.
    pub fn kill(&self, folder: &str, line: &str, journal: &str, bytes: u64) {
        let mut child = self.begin(folder, line);
        wait_for(&self.file(journal), bytes);
        child.kill().unwrap();
        child.wait().unwrap();
    }

    pub fn begin(&self, folder: &str, line: &str) -> Child {
        let mut command = self.command(folder, line);
        command.stdout(Stdio::null()).stderr(Stdio::null());
        command.spawn().unwrap()
    }

    /// Presses Ctrl-C after so long; what was said.
    #[cfg(unix)]
    pub fn interrupt(&self, line: &str, after: Duration) -> String {
        let mut command = self.command(".", line);
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        let child = command.spawn().unwrap();
        std::thread::sleep(after);
        told(&interrupt(child), 130, line)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

pub fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_chatter"));
    command.args(arguments);
    command
}

pub fn chatter(arguments: &[&str]) -> Output {
    command(arguments).output().unwrap()
}

pub fn succeeds(arguments: &[&str]) -> String {
    let output = chatter(arguments);
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{errors}");
    String::from_utf8(output.stdout).unwrap()
}

pub fn document(arguments: &[&str]) -> Value {
    let text = succeeds(arguments);
    assert!(text.ends_with("}\n"));
    serde_json::from_str(&text).unwrap()
}

pub fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("a number, not {value}"))
}

/// What was said on the error stream, by a program that was to end with this code.
pub fn told(output: &Output, code: i32, line: &str) -> String {
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{line}: {said}");
    said
}

pub fn fails(arguments: &[&str]) -> String {
    let output = chatter(arguments);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}");
    assert!(output.stdout.is_empty());
    String::from_utf8(output.stderr).unwrap()
}

/// A command line as it is typed, and what follows: paths, in which there may be spaces.
pub fn typed<'a>(line: &'a str, rest: &[&'a str]) -> Vec<&'a str> {
    line.split(' ').chain(rest.iter().copied()).collect()
}

pub fn begin(arguments: &[&str]) -> Child {
    let mut command = command(arguments);
    command.stdout(Stdio::null()).stderr(Stdio::piped());
    command.spawn().unwrap()
}

/// Waits until so much is in the journal.
pub fn wait_for(journal: &str, bytes: u64) {
    let began = Instant::now();
    while std::fs::metadata(journal).map_or(0, |file| file.len()) < bytes {
        assert!(began.elapsed() < Duration::from_secs(120), "{journal}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Presses Ctrl-C, which ends the program at once.
#[cfg(unix)]
pub fn interrupt(child: Child) -> Output {
    // A second on a machine with nothing else to do.
    interrupt_within(Duration::from_secs(4), child)
}

/// Presses Ctrl-C, which ends the program in so much time.
#[cfg(unix)]
pub fn interrupt_within(limit: Duration, child: Child) -> Output {
    let id = child.id().to_string();
    let sent = Command::new("kill").args(["-INT", &id]).status().unwrap();
    assert!(sent.success(), "it has ended already");
    let began = Instant::now();
    let output = child.wait_with_output().unwrap();
    let spent = began.elapsed();
    assert!(spent < limit, "{spent:?}");
    output
}
