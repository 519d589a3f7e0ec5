//! Models whose tables stand in files: which files are read, and that nothing needs them once it has been begun.

use crate::common::{Folder, begin, chatter, fails, succeeds, typed, wait_for};

const MODEL: &str = r#"
title = "Cam"
[parameters]
omega = 3
r = 0.5
[table.lift]
file = "data/cam.csv"
kind = "periodic-cubic"
[flight]
y = "v"
v = "-9.81"
angle = "omega*180/pi"
[[contact]]
name = "cam"
gap = "y - lift(angle)"
impulse = { v = 1 }
restitution = "r"
[initial]
y = 2
v = 0
angle = 0
"#;

const CAM: &str = "# measured\nangle,lift\n0,0\n90,0.5\n180,1\n270,0.5\n360,0\n";

/// A folder with the model, its data in a folder beside it.
fn folder(test: &str) -> Folder {
    let folder = Folder::new(test);
    std::fs::create_dir_all(folder.file("data")).unwrap();
    folder.write("cam.toml", MODEL);
    folder.write("data/cam.csv", CAM);
    folder
}

/// The model with another file.
fn with_file(folder: &Folder, file: &str) -> String {
    folder.with("other.toml", &MODEL.replace("data/cam.csv", file))
}

#[test]
fn files_are_found_from_the_folder_of_the_model() {
    let folder = folder("found");
    let whole = succeeds(&[
        "simulate",
        &folder.file("cam.toml"),
        "--until",
        "1",
        "--json",
    ]);
    let inline = "x = [0, 90, 180, 270, 360]\ny = [0, 0.5, 1, 0.5, 0]";
    folder.write(
        "cam.toml",
        &MODEL.replace("file = \"data/cam.csv\"", inline),
    );
    let same = succeeds(&[
        "simulate",
        &folder.file("cam.toml"),
        "--until",
        "1",
        "--json",
    ]);
    assert_eq!(whole, same);
    std::fs::create_dir_all(folder.file("models")).unwrap();
    folder.write(
        "models/cam.toml",
        &MODEL.replace("data/cam.csv", "../data/cam.csv"),
    );
    succeeds(&["check", &folder.file("models/cam.toml")]);
}

#[test]
fn only_files_are_read_that_are_beside_the_model_and_are_texts() {
    let folder = folder("refused");
    let told = |file: &str, message: &str| {
        let model = with_file(&folder, file);
        let error = fails(&["check", &model]);
        let title = format!("error: cannot read `{file}`: {message}");
        assert!(error.starts_with(&title), "{error}");
        assert!(error.contains("^^^"), "{error}");
    };
    told(
        "/etc/hosts",
        "the path must start from the folder of the model file",
    );
    told("data", "it is a folder");
    told("../nowhere/cam.csv", "there is no file");
    let missing = format!(
        "there is no file `{}`; did you mean `{}`?",
        folder.file("data/cams.csv"),
        folder.file("data/cam.csv")
    );
    told("data/cams.csv", &missing);
    std::os::unix::fs::symlink("/dev/zero", folder.file("endless.csv")).unwrap();
    told("endless.csv", "it is a pipe or a device, not a file");
    let pipe = folder.file("pipe.csv");
    assert!(
        std::process::Command::new("mkfifo")
            .arg(&pipe)
            .status()
            .unwrap()
            .success()
    );
    told("pipe.csv", "it is a pipe or a device, not a file");
    std::fs::write(folder.file("latin.csv"), b"# lift\nangle \xb0,lift\n0,0\n").unwrap();
    told("latin.csv", "it is no text: line 2 is not UTF-8");
    let long = std::fs::File::create(folder.file("long.csv")).unwrap();
    long.set_len((1 << 26) + 1).unwrap();
    told("long.csv", "it has more than 67108864 bytes");
}

#[test]
fn a_text_in_a_file_does_nothing_to_a_terminal() {
    let folder = folder("escapes");
    folder.write("data/cam.csv", "0,0\n\u{1b}[2J,1\n");
    let error = fails(&["check", &folder.file("cam.toml")]);
    assert!(
        error.contains("is not a number") && !error.contains('\u{1b}'),
        "{error}"
    );
}

#[test]
fn a_diagram_is_resumed_and_drawn_without_the_file() {
    let folder = folder("resumed");
    let line = "--sweep omega=2:4:60 --period 2*pi/omega --observe y --start carry --transient 20 --keep 30 --out";
    let model = folder.file("cam.toml");
    let [whole, out] = ["whole.npz", "o.npz"].map(|name| folder.file(name));
    let order = |out| [vec!["diagram", model.as_str()], typed(line, &[out])].concat();
    succeeds(&order(&whole));
    let arguments = order(&out);
    let mut child = begin(&arguments);
    wait_for(&folder.file("o.npz.journal"), 5_000);
    child.kill().unwrap();
    child.wait().unwrap();
    // Another cam under the same name is another diagram.
    folder.write("data/cam.csv", &CAM.replace("180,1", "180,1.5"));
    let output = chatter(&arguments);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{errors}");
    assert!(
        errors.contains("other tables in the model's files"),
        "{errors}"
    );
    std::fs::remove_file(folder.file("data/cam.csv")).unwrap();
    succeeds(&["diagram", "--resume", &folder.file("o.npz")]);
    assert!(folder.bytes("o.npz") == folder.bytes("whole.npz"));
    succeeds(&[
        "plot",
        &folder.file("o.npz"),
        "--out",
        &folder.file("o.svg"),
    ]);
}

#[test]
fn a_simulation_keeps_the_texts_of_the_files() {
    let folder = folder("kept");
    let holds = |text: &str| {
        let bytes = folder.bytes("s.npz");
        bytes
            .windows(text.len())
            .any(|window| window == text.as_bytes())
    };
    let out = folder.file("s.npz");
    succeeds(&[
        "simulate",
        &folder.file("cam.toml"),
        "--until",
        "1",
        "--out",
        &out,
    ]);
    assert!(holds("data_files"));
    succeeds(&["simulate", "bouncing_ball", "--until", "1", "--out", &out]);
    assert!(!holds("data_files"));
}
