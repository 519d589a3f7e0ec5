//! Embeds the shipped models: every file of `models/` (a link to that of the repository, so that source packages hold them), so that adding one touches nothing else.

use std::fmt::Write;
use std::path::Path;
use std::{env, fs};

fn main() {
    let here = env::var("CARGO_MANIFEST_DIR").expect("CARGO_MANIFEST_DIR");
    let folder = Path::new(&here).join("models");
    println!("cargo::rerun-if-changed={}", folder.display());
    let entries = fs::read_dir(&folder).expect("the folder of shipped models");
    let mut files: Vec<_> = entries
        .map(|entry| {
            entry
                .expect("an entry of the folder of shipped models")
                .path()
        })
        .filter(|path| {
            path.extension()
                .is_some_and(|extension| extension == "toml")
        })
        .collect();
    files.sort();
    let mut code = String::from("&[\n");
    for file in files {
        let name = file
            .file_stem()
            .expect("a name")
            .to_string_lossy()
            .into_owned();
        let path = file.canonicalize().expect("a path");
        writeln!(code, "    ({name:?}, include_str!({path:?})),").expect("text");
    }
    code.push(']');
    let out = env::var("OUT_DIR").expect("OUT_DIR");
    fs::write(Path::new(&out).join("shipped.rs"), code).expect("the generated list");
}
