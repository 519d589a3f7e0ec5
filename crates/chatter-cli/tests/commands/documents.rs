//! What programs read: the JSON document, tables, figures, exit codes.

use crate::common::{Folder, chatter, command, interrupt, number, told};
use serde_json::Value;
use std::process::Stdio;
use std::time::Duration;

fn document(arguments: &[&str], exit_code: i32) -> Value {
    let output = chatter(arguments);
    told(&output, exit_code, &arguments.join(" "));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn events<'a>(document: &'a Value, kind: &str) -> Vec<&'a Value> {
    let events = document["events"].as_array().unwrap().iter();
    events.filter(|event| event["kind"] == kind).collect()
}

fn keys(value: &Value) -> Vec<&str> {
    value
        .as_object()
        .unwrap()
        .keys()
        .map(String::as_str)
        .collect()
}

const VALVE: &str = "pressure_relief_valve";

/// The schema of the issue, key by key.
#[test]
fn the_document_has_its_members() {
    let valve = document(
        &[
            "simulate", VALVE, "--set", "q=0.0195", "--until", "8", "--json",
        ],
        0,
    );
    assert_eq!(valve["outcome"], "horizon");
    assert_eq!(number(&valve["time"]), 8.0);
    assert_eq!(keys(&valve["state"]), ["y1", "y2", "y3"]);
    assert_eq!(number(&valve["parameters"]["q"]), 0.0195);
    assert_eq!(valve["start"]["state"]["y3"], 10.0);
    assert!(valve.get("error").is_none() && valve.get("time_digits").is_none());
    let counted = |kind: &str| events(&valve, kind).len() as u64;
    for (count, kind) in [
        ("impacts", "impact"),
        ("accumulations", "accumulation"),
        ("releases", "release"),
        ("grazes", "graze"),
        ("sections", "section"),
    ] {
        assert_eq!(
            valve["counts"][count].as_u64().unwrap(),
            counted(kind),
            "{kind}"
        );
    }
    assert_eq!(counted("accumulation"), 2);
    let mut before = 0.0;
    for event in valve["events"].as_array().unwrap() {
        assert!(number(&event["time"]) >= before);
        before = number(&event["time"]);
        assert_eq!(keys(&event["state"]), ["y1", "y2", "y3"]);
        match event["kind"].as_str().unwrap() {
            "impact" => {
                assert_eq!(event["contact"], "seat");
                let (rate_before, rate_after) =
                    (number(&event["rate_before"]), number(&event["rate_after"]));
                assert!(rate_before < 0.0 && (rate_after + 0.8 * rate_before).abs() < 1e-15);
                // The state just after the impact.
                assert_eq!(number(&event["state"]["y2"]), rate_after);
                assert_eq!(event["closes"], false);
            }
            "accumulation" => {
                assert_eq!(event["contact"], "seat");
                assert!(event["impacts"].as_u64().unwrap() > 10);
                assert!(number(&event["error"]) < 1e-13);
                assert_eq!(number(&event["state"]["y1"]), 0.0);
                assert_eq!(number(&event["state"]["y2"]), 0.0);
            }
            "release" => {
                assert_eq!(event["contact"], "seat");
                // The acceleration vanishes: y3 = delta.
                assert!((number(&event["state"]["y3"]) - 10.0).abs() < 1e-13);
            }
            "section" => assert_eq!(event["section"], "closing"),
            other => panic!("unexpected event {other}"),
        }
    }
    // Pressure rises by beta q while the valve is closed.
    let phase = &valve["contact_phases"][0];
    let closed = number(&phase["end"]) - number(&phase["start"]);
    let (closing, release) = (
        events(&valve, "accumulation")[0],
        events(&valve, "release")[0],
    );
    let rise = number(&release["state"]["y3"]) - number(&closing["state"]["y3"]);
    assert!((rise - 20.0 * 0.0195 * closed).abs() < 1e-13);
}

#[test]
fn thirty_digits_stand_beside_the_numbers() {
    let ball = document(
        &["simulate", "bouncing_ball", "--digits", "30", "--json"],
        0,
    );
    assert_eq!(ball["outcome"], "rest");
    // 3 sqrt(2 / 9.81), to 30 digits.
    let exact = "1.35457092295719271335243337301";
    let end = events(&ball, "accumulation")[0];
    assert_eq!(end["time_digits"], exact);
    assert_eq!(ball["time_digits"], exact);
    assert_eq!(number(&end["time"]), exact.parse::<f64>().unwrap());
    let impact = events(&ball, "impact")[0];
    assert!(
        impact["rate_before_digits"]
            .as_str()
            .unwrap()
            .starts_with("-4.4294469180700")
    );
    assert!(impact["state_digits"]["v"].as_str().unwrap().len() > 30);
}

#[test]
fn a_run_that_cannot_go_on_keeps_what_it_has() {
    let folder = Folder::new("domain");
    let model = folder.with(
        "leaky.toml",
        "[flight]\nx = 'v'\nv = '-1 - sqrt(1.5 - t)'\n[[contact]]\nname = 'floor'\ngap = 'x'\nimpulse = { v = 1 }\n\
         restitution = 0.6\n[initial]\nx = 1\nv = 0\n",
    );
    let table = folder.file("leaky.csv");
    let leaky = document(&["simulate", &model, "--json", "--out", &table], 1);
    assert_eq!(leaky["outcome"], "singular");
    assert_eq!(leaky["error"]["kind"], "singular");
    assert!(
        leaky["error"]["message"]
            .as_str()
            .unwrap()
            .contains("the argument of a square root (1.5 - t) reaches zero")
    );
    assert_eq!(events(&leaky, "impact").len(), 1);
    assert!((number(&leaky["time"]) - 1.5).abs() < 1e-3);
    // Time is no state of the user's.
    assert_eq!(keys(&leaky["state"]), ["v", "x"]);
    assert!(std::fs::read_to_string(table).unwrap().lines().count() > 10);
}

#[test]
fn plastic_impacts_say_that_they_close() {
    let ball = document(&["simulate", "bouncing_ball", "--set", "r=0", "--json"], 0);
    let [impact] = events(&ball, "impact")[..] else {
        panic!("one impact")
    };
    assert_eq!(impact["closes"], true);
    assert_eq!(number(&impact["rate_after"]), 0.0);
    assert_eq!(ball["closed"][0], "floor");
    assert_eq!(ball["counts"]["accumulations"], 0);
}

#[test]
fn tables_have_the_rows_asked_for() {
    let folder = Folder::new("tables");
    let rows = |sample: &str| {
        let file = folder.file("rows.csv");
        let output = chatter(&[
            "simulate", VALVE, "--until", "4", "--out", &file, "--sample", sample,
        ]);
        assert!(output.status.success());
        let text = std::fs::read_to_string(file).unwrap();
        let mut lines = text
            .lines()
            .map(|line| line.split(',').map(str::to_owned).collect::<Vec<String>>());
        let header = lines.next().unwrap();
        (header, lines.collect::<Vec<_>>())
    };
    let (header, even) = rows("kappa/5");
    assert_eq!(header, ["time", "y1", "y2", "y3", "closed_seat"]);
    assert_eq!(even.len(), 17);
    assert_eq!(even[4][0], "1.0");
    let (header, happened) = rows("events");
    assert_eq!(
        header,
        [
            "time",
            "kind",
            "place",
            "y1",
            "y2",
            "y3",
            "rate_before",
            "rate_after",
            "impacts",
            "error"
        ]
    );
    assert!(happened.iter().filter(|row| row[1] == "impact").count() > 30);
    let (_, dense) = rows("dense:2");
    assert!(dense.len() > 4 * happened.len() / 2);
    // Times never fall, gaps never below zero.
    for pair in dense.windows(2) {
        assert!(pair[0][0].parse::<f64>().unwrap() <= pair[1][0].parse::<f64>().unwrap());
    }
    assert!(
        dense
            .iter()
            .all(|row| row[1].parse::<f64>().unwrap() > -1e-15)
    );
}

#[test]
fn archives_say_how_they_came_about() {
    let folder = Folder::new("archives");
    let file = folder.file("valve.npz");
    let output = chatter(&[
        "simulate", VALVE, "--until", "2", "--digits", "30", "--out", &file,
    ]);
    assert!(output.status.success());
    let archive = chatter_files::tables::NpzReader::open(&file).unwrap();
    let times = archive.floats("time").unwrap();
    let remainders = archive.floats("time_low").unwrap();
    assert_eq!(times.len(), remainders.len());
    assert!(
        times
            .iter()
            .zip(&remainders)
            .all(|(high, low)| high + low == *high)
    );
    assert!(remainders.iter().any(|&low| low != 0.0));
    assert!(archive.text("model").unwrap().contains("[flight]"));
    assert!(
        archive
            .text("specification")
            .unwrap()
            .contains("\"until\":2.0")
    );
    assert_eq!(archive.text("outcome").unwrap(), "horizon");
}

#[test]
fn figures_are_drawn_in_every_format() {
    let folder = Folder::new("figures");
    for (name, signature) in [
        ("a.svg", &b"<?xml"[..]),
        ("a.png", &b"\x89PNG"[..]),
        ("a.pdf", &b"%PDF"[..]),
    ] {
        let file = folder.file(name);
        for model in [VALVE, "bouncing_ball", "impact_oscillator_two_sided"] {
            let output = chatter(&["simulate", model, "--until", "5", "--plot", &file]);
            assert!(
                output.status.success(),
                "{}",
                String::from_utf8_lossy(&output.stderr)
            );
            let bytes = std::fs::read(&file).unwrap();
            let start = &bytes[..signature.len()];
            assert!(
                start == signature || start.starts_with(b"<svg"),
                "{name}: {start:?}"
            );
        }
    }
}

#[test]
fn a_pipe_sees_no_escape_sequences() {
    for arguments in [
        &["simulate", VALVE, "--until", "4"][..],
        &["check", VALVE],
        &["simulate", VALVE, "--set", "qq=1"],
        &["simulate", "nothing"],
    ] {
        let output = chatter(arguments);
        assert!(!output.stdout.contains(&0x1b) && !output.stderr.contains(&0x1b));
    }
}

/// Every shipped model runs and is told in all ways.
#[test]
fn shipped_models_run() {
    let list = String::from_utf8(chatter(&["models"]).stdout).unwrap();
    let names: Vec<&str> = list
        .lines()
        .filter_map(|line| line.split_whitespace().next())
        .collect();
    assert!(names.len() >= 7);
    for name in names {
        let checked = document(&["check", name, "--json"], 0);
        assert_eq!(
            checked["warnings"].as_array().unwrap().len(),
            0,
            "{name}: {}",
            checked["warnings"]
        );
        let run = document(&["simulate", name, "--until", "40", "--json"], 0);
        assert_eq!(run["outcome"], "horizon", "{name}");
        if !checked["contacts"].as_array().unwrap().is_empty() {
            assert!(run["counts"]["impacts"].as_u64().unwrap() > 0, "{name}");
        }
    }
}

/// Ctrl-C ends a long run cleanly, with what it has.
#[cfg(unix)]
#[test]
fn an_interrupt_keeps_what_is_done() {
    let run = [
        "simulate",
        VALVE,
        "--until",
        "1e9",
        "--impacts",
        "1000000000",
        "--json",
    ];
    let child = command(&run).stdout(Stdio::piped()).spawn().unwrap();
    std::thread::sleep(Duration::from_millis(200));
    let output = interrupt(child);
    assert_eq!(output.status.code(), Some(130));
    let document: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(document["outcome"], "interrupted");
    assert!(number(&document["time"]) > 0.0);
}
