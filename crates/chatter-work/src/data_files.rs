//! The files that the tables of a model stand in.

use crate::source::neighbour;
use std::collections::BTreeMap;
use std::io::{ErrorKind, Read};
use std::path::Path;

/// Texts of the files that a model's tables stand in, by what the model calls them.
pub type DataFiles = BTreeMap<String, String>;

/// Longest file that is read: a million knots of sixty characters each.
const MOST_BYTES: u64 = 1 << 26;

/// Reads such files beside the model's, and keeps their texts. `None` for a model that comes with the program.
pub fn beside<'a>(
    model: Option<&'a Path>,
    read: &'a mut DataFiles,
) -> impl FnMut(&str) -> Result<String, String> + 'a {
    move |file| {
        let text = match read.get(file) {
            Some(text) => text.clone(),
            None => text_beside(model, file)?,
        };
        read.insert(file.to_owned(), text.clone());
        Ok(text)
    }
}

/// Gives the texts that were kept.
pub fn kept(files: &DataFiles) -> impl FnMut(&str) -> Result<String, String> + '_ {
    |file| {
        let missing = || "its text was not kept with the model's".to_owned();
        files.get(file).cloned().ok_or_else(missing)
    }
}

fn text_beside(model: Option<&Path>, file: &str) -> Result<String, String> {
    let Some(model) = model else {
        return Err("a shipped model has no files beside it".to_owned());
    };
    let path = Path::new(file);
    if path.has_root() || path.is_absolute() {
        return Err("the path must start from the folder of the model file".to_owned());
    }
    let path = model.with_file_name("").join(path);
    let told = |error: std::io::Error| error.to_string();
    // Asked before it is opened: opening a pipe waits for whoever writes to it.
    let found = match std::fs::metadata(&path) {
        Ok(found) => found,
        Err(error) if error.kind() == ErrorKind::NotFound => {
            let missing = format!("there is no file `{}`", path.display());
            return Err(match neighbour(&path, &|name| !name.ends_with(".toml")) {
                Some(near) => format!("{missing}; did you mean `{near}`?"),
                None => missing,
            });
        }
        Err(error) => return Err(told(error)),
    };
    if found.is_dir() {
        return Err("it is a folder".to_owned());
    }
    if !found.is_file() {
        return Err("it is a pipe or a device, not a file".to_owned());
    }
    let mut bytes = Vec::new();
    let opened = std::fs::File::open(&path).map_err(told)?;
    (opened.take(MOST_BYTES + 1).read_to_end(&mut bytes)).map_err(told)?;
    if bytes.len() as u64 > MOST_BYTES {
        return Err(format!("it has more than {MOST_BYTES} bytes"));
    }
    text_of(bytes).map_err(|line| format!("it is no text: line {line} is not UTF-8"))
}

/// The text that these bytes are, else the first line where they are none.
pub fn text_of(bytes: Vec<u8>) -> Result<String, usize> {
    String::from_utf8(bytes).map_err(|error| {
        let before = error.utf8_error().valid_up_to();
        let text = &error.as_bytes()[..before];
        text.iter().filter(|&&byte| byte == b'\n').count() + 1
    })
}
