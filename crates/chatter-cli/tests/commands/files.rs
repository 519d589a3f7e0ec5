//! What a user's files can count on: outputs stand where they were asked for, two processes do not share one, links and
//! permissions stay, and text from files does nothing to a terminal.

use crate::common::{Folder, wait_for};
use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};
use std::process::{Child, Command, Stdio};

/// Long enough to be broken off.
const LONG: &str = "diagram pressure_relief_valve --section closing --observe y2 --start carry \
                    --sweep q=0.0201:0.0225:100 --transient 400 --keep 100";

#[test]
fn a_resumed_diagram_is_written_where_it_was_begun() {
    let folder = Folder::new("elsewhere");
    for sub in ["sub", "moved"] {
        std::fs::create_dir(folder.path(sub)).unwrap();
    }
    folder.write("o.npz", "another file");
    folder.write("o.png", "another picture");
    let line = format!("{LONG} --out o.npz --plot o.png");
    folder.succeeds("moved", &line);
    let (whole, picture) = (folder.bytes("moved/o.npz"), folder.bytes("moved/o.png"));
    std::fs::remove_file(folder.path("moved/o.npz")).unwrap();
    std::fs::remove_file(folder.path("moved/o.png")).unwrap();

    folder.kill("sub", &line, "sub/o.npz.journal", 20_000);
    let journal = String::from_utf8_lossy(&folder.bytes("sub/o.npz.journal")).into_owned();
    assert!(!journal.contains(folder.path("").to_str().unwrap()));
    folder.succeeds(".", "diagram --resume sub/o.npz");
    assert!(folder.bytes("sub/o.npz") == whole);
    assert!(folder.bytes("sub/o.png") == picture);
    assert_eq!(folder.names_in("sub"), ["o.npz", "o.png"]);

    // A journal goes with its folder, and an absolute path is no different.
    let absolute = folder.path("sub/a.npz");
    let line = format!("{LONG} --out {}", absolute.display());
    folder.kill(".", &line, "sub/a.npz.journal", 20_000);
    let journal = String::from_utf8_lossy(&folder.bytes("sub/a.npz.journal")).into_owned();
    assert!(!journal.contains(folder.path("").to_str().unwrap()));
    std::fs::rename(
        folder.path("sub/a.npz.journal"),
        folder.path("moved/b.npz.journal"),
    )
    .unwrap();
    folder.succeeds(".", "diagram --resume moved/b.npz");
    assert!(folder.bytes("moved/b.npz") == whole);
    assert_eq!(folder.names_in("moved"), ["b.npz"]);
    assert_eq!(folder.bytes("o.npz"), b"another file");
    assert_eq!(folder.bytes("o.png"), b"another picture");
}

#[test]
fn a_figure_in_another_folder_is_asked_for_again() {
    let folder = Folder::new("figure");
    for sub in ["a", "b"] {
        std::fs::create_dir(folder.path(sub)).unwrap();
    }
    let line = format!("{LONG} --out a/o.npz --plot b/p.png");
    folder.kill(".", &line, "a/o.npz.journal", 10_000);
    let said = folder.succeeds(".", "diagram --resume a/o.npz --plot b/q.png");
    assert!(said.contains("wrote b/q.png"), "{said}");
    folder.kill(".", &line, "a/o.npz.journal", 10_000);
    let said = folder.succeeds(".", "diagram --resume a/o.npz");
    assert!(said.contains("--plot FILE draws it"), "{said}");
    // One without a table loses nothing either.
    let line = format!("{LONG} --plot b/p.svg");
    folder.kill(".", &line, "b/p.svg.journal", 10_000);
    folder.succeeds(".", "diagram --resume b/p.svg");
    assert_eq!(folder.names_in("a"), ["o.npz"]);
    assert_eq!(folder.names_in("b"), ["p.svg", "q.png"]);
}

#[test]
fn what_is_no_diagram_is_not_called_complete() {
    let folder = Folder::new("complete");
    folder.write("notes.txt", "notes");
    folder.write("a.png", "no picture");
    folder.write("a.npz", "no archive");
    folder.write("a.csv", "x\r\n1\r\n");
    for name in ["notes.txt", "a.png", "a.npz", "a.csv"] {
        folder.fails(".", &format!("diagram --resume {name}"));
    }
    let line = "diagram bouncing_ball_on_table --at impact --observe v --sweep Gamma=1.2:2:3 --keep 5 --transient 5";
    for name in ["b.npz", "b.csv", "b.svg"] {
        let option = if name.ends_with("svg") { "plot" } else { "out" };
        folder.succeeds(".", &format!("{line} --{option} {name}"));
        let said = folder.succeeds(".", &format!("diagram --resume {name}"));
        assert!(said.contains("nothing to resume"), "{said}");
    }
}

#[test]
fn of_two_processes_on_one_output_one_computes() {
    let folder = Folder::new("two");
    let line = "diagram bouncing_ball_on_table --at impact --observe v --sweep Gamma=1.2:2:40 --transient 2000 --out o.npz";
    folder.succeeds(".", line);
    let whole = folder.bytes("o.npz");
    for _ in 0..5 {
        std::fs::remove_file(folder.path("o.npz")).unwrap();
        let children: Vec<Child> = (0..4)
            .map(|_| {
                let mut command = folder.command(".", line);
                command.stdout(Stdio::piped()).stderr(Stdio::piped());
                command.spawn().unwrap()
            })
            .collect();
        let mut computed = 0;
        for child in children {
            let output = child.wait_with_output().unwrap();
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            match output.status.code() {
                Some(0) => computed += 1,
                Some(2) => assert!(said.contains("is in use: another process"), "{said}"),
                other => panic!("{other:?}: {said}"),
            }
        }
        assert!(computed >= 1);
        assert!(folder.bytes("o.npz") == whole);
        assert_eq!(folder.names_in("."), ["o.npz"]);
    }
    // Nor does one that goes on share it with another.
    let mut first = folder.begin(".", &format!("{LONG} --out long.npz"));
    wait_for(&folder.file("long.npz.journal"), 10_000);
    for line in [
        format!("{LONG} --out long.npz"),
        "diagram --resume long.npz".to_owned(),
    ] {
        let said = folder.fails(".", &line);
        assert!(said.contains("is in use"), "{said}");
    }
    first.kill().unwrap();
    first.wait().unwrap();
    folder.succeeds(".", "diagram --resume long.npz");
}

#[test]
fn links_permissions_and_pipes_stay() {
    let folder = Folder::new("targets");
    std::fs::create_dir(folder.path("far")).unwrap();
    let line = "simulate bouncing_ball --until 1 --out";
    folder.write("secret.csv", "old");
    let mode = |name: &str| std::fs::metadata(folder.path(name)).unwrap().mode() & 0o777;
    let only_mine = std::fs::Permissions::from_mode(0o600);
    std::fs::set_permissions(folder.path("secret.csv"), only_mine).unwrap();
    folder.succeeds(".", &format!("{line} secret.csv"));
    assert_eq!(mode("secret.csv"), 0o600);
    folder.write("far/real.csv", "old");
    symlink("far/real.csv", folder.path("link.csv")).unwrap();
    folder.succeeds(".", &format!("{line} link.csv"));
    assert!(folder.path("link.csv").is_symlink());
    assert!(folder.bytes("far/real.csv") == folder.bytes("secret.csv"));
    let pipe = folder.path("pipe.csv");
    assert!(
        Command::new("mkfifo")
            .arg(&pipe)
            .status()
            .unwrap()
            .success()
    );
    let said = folder.fails(".", &format!("{line} pipe.csv"));
    assert!(said.contains("it is a pipe"), "{said}");
    assert!(!std::fs::metadata(&pipe).unwrap().is_file());
    assert_eq!(folder.names_in("far"), ["real.csv"]);
}

#[test]
fn what_a_killed_process_was_writing_is_removed_by_the_one_that_goes_on() {
    let folder = Folder::new("litter");
    let line = format!("{LONG} --out o.npz --plot o.png");
    folder.kill(".", &line, "o.npz.journal", 10_000);
    for left in [".o.npz.aB3dE6.tmp", ".o.png.aB3dE6.tmp"] {
        folder.write(left, "half of it");
    }
    folder.succeeds(".", "diagram --resume o.npz");
    assert_eq!(folder.names_in("."), ["o.npz", "o.png"]);
}

#[test]
fn a_journal_with_wrong_rows_is_gone_on_with_from_the_right_ones() {
    let folder = Folder::new("rows");
    folder.succeeds(".", &format!("{LONG} --out whole.npz"));
    folder.kill(".", &format!("{LONG} --out o.npz"), "o.npz.journal", 20_000);
    let good = folder.bytes("o.npz.journal");
    // The last point of the first row, with one coordinate less, and the checksum that goes with it.
    let length = |at: usize| u64::from_le_bytes(good[at..at + 8].try_into().unwrap()) as usize;
    let row = 16 + 12 + length(16);
    let body = row + 12;
    // Origin, orbit and its sizes stand before it.
    let behind = |list: usize| list + 8 + 8 * length(list);
    let end = behind(behind(behind(body + 34)));
    assert_eq!(length(end), 3);
    let end = end - body;
    let mut changed = good[body..body + length(row)].to_vec();
    changed.splice(end..end + 8, 2_u64.to_le_bytes());
    changed.drain(end + 8..end + 16);
    let mut record = (changed.len() as u64).to_le_bytes().to_vec();
    let sum = crc32(&[&record[..], &changed[..]].concat());
    record.extend(sum.to_le_bytes());
    record.extend(&changed);
    let mut bytes = good[..row].to_vec();
    bytes.extend(record);
    bytes.extend(&good[body + length(row)..]);
    std::fs::write(folder.path("o.npz.journal"), bytes).unwrap();
    folder.succeeds(".", "diagram --resume o.npz");
    assert!(folder.bytes("o.npz") == folder.bytes("whole.npz"));
}

/// CRC-32 as in ZIP, bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    let step = |sum: u32, _| (sum >> 1) ^ (0xEDB8_8320 & (sum & 1).wrapping_neg());
    !bytes
        .iter()
        .fold(!0, |sum, &byte| (0..8).fold(sum ^ u32::from(byte), step))
}

#[test]
fn text_from_files_does_nothing_to_a_terminal() {
    let folder = Folder::new("escapes");
    let model = "title = \"T\\u001b]0;gone\\u0007\\u009b31m\"\nsource = \"\\u001b[2J\"\n[flight]\ny = \"v\"\nv = \"-1\"\n\
                 [[contact]]\ngap = \"y\"\nimpulse = { v = 1 }\nrestitution = \"0.5\"\n[initial]\ny = 1\nv = 0\n";
    let name = "a\u{1b}[31m.toml";
    folder.write(name, model);
    folder.write("broken\u{1b}[31m.toml", "[flight\n\u{1b}[2J");
    let lines = [
        format!("simulate {name}"),
        format!("simulate {name} --json"),
        format!("check {name}"),
        format!("check {name} --json"),
        "simulate broken\u{1b}[31m.toml".to_owned(),
        "simulate missing\u{1b}[31m.toml".to_owned(),
        format!("simulate {name} --set \u{1b}[31mq=1"),
        format!("simulate {name} --\u{1b}[31m"),
        format!("simulate {name} --out \u{1b}[31m/x.csv"),
        format!("diagram --resume {name}"),
        "plot \u{1b}[31m.npz --out a.png".to_owned(),
    ];
    for line in lines {
        let output = folder.run(".", &line);
        for said in [&output.stdout, &output.stderr] {
            let said = String::from_utf8_lossy(said);
            let raw = said.chars().find(|c| c.is_control() && *c != '\n');
            assert_eq!(raw, None, "{line:?}: {said:?}");
        }
    }
    // A document still says what the title is.
    let json: serde_json::Value =
        serde_json::from_slice(&folder.run(".", &format!("check {name} --json")).stdout).unwrap();
    assert_eq!(json["title"], "T\u{1b}]0;gone\u{7}\u{9b}31m");
}

#[test]
fn a_full_device_is_an_exit_code_and_no_panic() {
    let folder = Folder::new("full");
    let full = || {
        std::fs::File::options()
            .write(true)
            .open("/dev/full")
            .unwrap()
    };
    let mut nothing = folder.command(".", "simulate no_such_model");
    nothing.stderr(full()).stdout(full());
    assert_eq!(nothing.status().unwrap().code(), Some(2));
    let mut ball = folder.command(".", "simulate bouncing_ball --until 1");
    ball.stderr(full()).stdout(full());
    assert_eq!(ball.status().unwrap().code(), Some(1));
}
