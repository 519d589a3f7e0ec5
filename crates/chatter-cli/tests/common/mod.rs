//! The program as its tests run it. Each test uses some of this.
#![allow(dead_code)]

use std::path::PathBuf;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

/// A folder of its own for each test, removed at the end.
pub struct Folder(PathBuf);

impl Folder {
    pub fn new(test: &str) -> Self {
        let path = std::env::temp_dir().join(format!("chatter-{test}-{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    pub fn file(&self, name: &str) -> String {
        self.0.join(name).to_str().unwrap().to_owned()
    }

    pub fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.file(name)).unwrap()
    }

    pub fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(&self.0).unwrap();
        let name = |entry: std::io::Result<std::fs::DirEntry>| {
            entry.unwrap().file_name().into_string().unwrap()
        };
        let mut names: Vec<String> = entries.map(name).collect();
        names.sort();
        names
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
