//! What a sweep carries and starts from: hysteresis, basins of attraction, single values, documents, limits.

use crate::common::{
    Folder, begin, chatter, document, fails, interrupt_within, succeeds, typed, wait_for,
};
use chatter_files::journal::{Journal, Unread};
use chatter_files::tables::NpzReader;
use serde_json::Value;
use std::time::Duration;

fn texts<'a>(columns: &'a Value, name: &str) -> Vec<&'a str> {
    let columns = columns["columns"].as_array().unwrap();
    let text = |column: &'a Value| column[name].as_str().unwrap();
    columns.iter().map(text).collect()
}

/// A mass between two stops, which it reaches or not, depending on where it comes from.
const TWO_STOPS: &str = "diagram impact_oscillator_two_sided --set sigma=1 --period 2*pi/omega --observe v \
                         --transient 200 --keep 20 --sweep omega=0.9:3:43";

#[test]
fn a_carried_state_follows_its_orbit_through_the_whole_range() {
    let folder = Folder::new("hysteresis");
    let (both, figure) = (folder.file("both.npz"), folder.file("both.png"));
    let said = succeeds(&typed(
        TWO_STOPS,
        &["--start", "carry:both", "--out", &both, "--plot", &figure],
    ));
    assert!(
        said.contains("states carried upwards and downwards\n"),
        "{said}"
    );
    assert!(said.contains(" of 43 values: omega = 1.45 to 2."), "{said}");
    let file = NpzReader::open(&both).unwrap();
    let (omega, impacts) = (
        file.floats("omega").unwrap(),
        file.floats("impacts_per_return").unwrap(),
    );
    assert_eq!((omega.len(), omega[0], omega[1]), (86, 0.9, 0.9));
    // Upwards the mass hits both stops far beyond where it begins to, downwards.
    let last = |from: usize| {
        let hits = (from..86).step_by(2).filter(|&row| impacts[row] > 1.0);
        hits.map(|row| omega[row]).fold(0.0, f64::max)
    };
    assert!(
        last(0) > 2.7 && last(1) < 1.5,
        "{} and {}",
        last(0),
        last(1)
    );
    // One way alone is the same orbits.
    for (start, first) in [("carry", 0), ("carry:down", 1)] {
        let one = folder.file("one.npz");
        succeeds(&typed(TWO_STOPS, &["--start", start, "--out", &one]));
        let v = NpzReader::open(&one).unwrap().floats("v").unwrap();
        let expected: Vec<f64> = (file.floats("v").unwrap().chunks(20).skip(first).step_by(2))
            .flatten()
            .copied()
            .collect();
        assert!(v == expected, "{start}");
    }
    // Chunks forget.
    let found = document(&typed(
        TWO_STOPS,
        &["--start", "carry:both", "--chunk", "4", "--json"],
    ));
    let columns = found["hysteresis"].as_array().unwrap();
    let length = |range: &Value| range[1].as_f64().unwrap() - range[0].as_f64().unwrap();
    assert!(columns.iter().map(length).sum::<f64>() < 0.3, "{columns:?}");
}

#[test]
fn basins_are_one_command() {
    let folder = Folder::new("basins");
    let (npz, csv, png) = (
        folder.file("a.npz"),
        folder.file("a.csv"),
        folder.file("a.png"),
    );
    let line = "diagram impact_oscillator_two_sided --at sigma=1 --at omega=2 --sweep initial:x=-1:1:11 \
                --sweep initial:v=-3:3:13 --period 2*pi/omega --observe v --out";
    let said = succeeds(&typed(line, &[&npz, "--plot", &png]));
    succeeds(&typed(line, &[&csv]));
    assert!(said.contains("initial x from -1 to 1, 11 values"), "{said}");
    let file = NpzReader::open(&npz).unwrap();
    let names: Vec<&str> = file.arrays().map(|array| array.name.as_str()).collect();
    assert_eq!(
        names[..8],
        [
            "initial_x",
            "initial_v",
            "outcome",
            "period",
            "impacts_per_return",
            "start",
            "attractor",
            "initial_t"
        ]
    );
    let text = std::fs::read_to_string(&csv).unwrap();
    assert!(
        text.starts_with(&(names[..8].join(",") + "\r\n-1.0,-3.0,")),
        "{text}"
    );
    // The two orbits differ in whether they hit the stops at all.
    let attractors = file.integers("attractor").unwrap();
    let impacts = file.floats("impacts_per_return").unwrap();
    let hits = |number: i64| -> Vec<f64> {
        let rows = attractors
            .iter()
            .zip(&impacts)
            .filter(|(told, _)| **told == number);
        let mut hits: Vec<f64> = rows.map(|(_, &impacts)| impacts).collect();
        hits.dedup();
        hits
    };
    assert_eq!((hits(1), hits(2)), (vec![2.0], vec![0.0]));
    let count = attractors.iter().filter(|&&number| number == 2).count();
    assert!(said.contains(&format!(
        "attractor 2: period 1, impacts per return 0: {count} of 143 starts"
    )));
    for show in ["attractor", "period", "impacts"] {
        succeeds(&["plot", &npz, "--show", show, "--out", &png]);
    }
    // Over one initial value, samples in the colours of their attractors; from the file as at once.
    let (one, svg, later) = (
        folder.file("b.npz"),
        folder.file("b.svg"),
        folder.file("c.svg"),
    );
    let line = "diagram impact_oscillator_two_sided --set sigma=1 --set omega=2 --sweep initial:v=-3:3:40 \
                --period 2*pi/omega --observe v --out";
    succeeds(&typed(line, &[&one, "--plot", &svg]));
    succeeds(&["plot", &one, "--out", &later]);
    assert!(folder.bytes("b.svg") == folder.bytes("c.svg"));
    succeeds(&["plot", &one, "--zoom", "initial_v=0:1", "--out", &later]);
    // A parameter beside an initial value: the orbit that hits keeps its number.
    let line = "diagram impact_oscillator_two_sided --set sigma=1 --sweep omega=1.8:2.2:5 --sweep initial:v=-3:3:9 \
                --period 2*pi/omega --observe v --json";
    let found = document(&typed(line, &[]));
    let columns = found["columns"].as_array().unwrap();
    let numbers = |hits: f64| -> Vec<i64> {
        let same = columns
            .iter()
            .filter(|column| column["impacts_per_return"] == hits);
        let mut numbers: Vec<i64> = same
            .map(|column| column["attractor"].as_i64().unwrap())
            .collect();
        numbers.sort_unstable();
        numbers.dedup();
        numbers
    };
    assert_eq!((numbers(2.0).len(), numbers(0.0).len()), (1, 1));
    assert_ne!(numbers(2.0), numbers(0.0));
}

#[test]
fn random_starts_behind_a_wall_are_drawn_again_and_recorded() {
    let folder = Folder::new("redrawn");
    let line = "diagram impact_oscillator_two_sided --set sigma=1 --sweep omega=1.9:2.1:3 --start random:20 \
                --box x=-4:4 --box v=-1:1 --period 2*pi/omega --observe v --keep 20 --out";
    let read = |threads: &str| {
        let npz = folder.file("a.npz");
        succeeds(&typed(line, &[&npz, "--threads", threads]));
        NpzReader::open(&npz).unwrap()
    };
    let file = read("2");
    let x = file.floats("initial_x").unwrap();
    assert_eq!(x.len(), 60);
    assert!(x.iter().all(|x| x.abs() <= 1.0) && x.iter().any(|x| x.abs() > 0.7));
    assert!(
        file.texts("outcome")
            .unwrap()
            .iter()
            .all(|outcome| outcome != "no_start")
    );
    assert!(x == read("1").floats("initial_x").unwrap());
}

#[test]
fn one_value_is_a_sweep_and_a_document_says_all_of_it() {
    let folder = Folder::new("single");
    let found = document(&typed(
        "diagram pressure_relief_valve --at q=0.0203 --observe y2 --exponent --json",
        &[],
    ));
    assert_eq!(
        (&found["outcome"], &found["counts"]["periodic"]),
        (&"complete".into(), &1.into())
    );
    let column = &found["columns"][0];
    assert_eq!(
        (column["q"].as_f64(), column["period"].as_i64()),
        (Some(0.0203), Some(1))
    );
    assert_eq!(column["impacts_per_return"], 34.0);
    assert_eq!(column["initial"]["y3"], 10.0);
    assert_eq!(column["samples"]["y2"].as_array().unwrap().len(), 200);
    assert!(column["exponent"].as_f64().unwrap() < 0.0);
    assert_eq!(found["model"]["source"], "pressure_relief_valve");
    assert_eq!(found["specification"]["diagram"]["keep"], 200);
    // As a table and a figure, and with an event to sample at.
    let (csv, png) = (folder.file("a.csv"), folder.file("a.png"));
    let said = succeeds(&typed(
        "diagram pressure_relief_valve --at q=0.0203 --observe y2 --at impact --keep 5 --out",
        &[&csv, "--plot", &png],
    ));
    assert!(
        said.contains("q = 0.0203\n") && said.contains("each impact"),
        "{said}"
    );
    let samples = std::fs::read_to_string(folder.file("a.samples.csv")).unwrap();
    assert_eq!(samples.lines().count(), 6);
    // The document has the numbers of the table.
    let line =
        "diagram pressure_relief_valve --sweep q=0.0203:0.0206:3 --observe y2 --keep 3 --out";
    let both = document(&typed(line, &[&csv, "--json"]));
    let samples = std::fs::read_to_string(folder.file("a.samples.csv")).unwrap();
    let mut rows = samples.lines().skip(1);
    for column in both["columns"].as_array().unwrap() {
        for y2 in column["samples"]["y2"].as_array().unwrap() {
            let row = rows.next().unwrap();
            assert_eq!(
                row.split(',').nth(1).unwrap().parse::<f64>().ok(),
                y2.as_f64()
            );
        }
    }
    assert!(fails(&["diagram", "pressure_relief_valve", "--observe", "y2"]).contains("--sweep"));
    let twice = typed(
        "diagram pressure_relief_valve --at impact --at q=0.02 --observe y2 --json --section closing",
        &[],
    );
    assert!(fails(&twice).contains("in two ways"));
}

#[test]
fn orbits_are_judged_by_their_whole_state() {
    // Undamped and out of reach of the stops: two incommensurate frequencies.
    let line = "diagram impact_oscillator_two_sided --set zeta=0 --set sigma=9 --observe v --period 2*pi/omega --json";
    for omega in ["sqrt(3)", "sqrt(5)", "1.1*sqrt(2)"] {
        let at = format!("omega={omega}");
        let found = document(&typed(line, &["--at", &at]));
        assert_eq!(texts(&found, "outcome"), ["quasiperiodic"], "{omega}");
    }
    // In proportion: the orbit closes.
    let found = document(&typed(line, &["--at", "omega=2.5"]));
    assert_eq!(
        (texts(&found, "outcome"), &found["columns"][0]["period"]),
        (vec!["periodic"], &5.into())
    );
    // What is observed does not matter, be it the same all the time or never the same.
    for observed in ["0*v", "t"] {
        let line = "diagram impact_oscillator --at omega=2.72 --period 2*pi/omega --transient 500 --keep 400 --json --observe";
        let found = document(&typed(line, &[&format!("c={observed}")]));
        assert_eq!(texts(&found, "outcome"), ["chaotic"], "{observed}");
        let line =
            "diagram impact_oscillator --at omega=2.3 --at impact --transient 500 --json --observe";
        let found = document(&typed(line, &[&format!("c={observed}")]));
        assert_eq!(texts(&found, "outcome"), ["periodic"], "{observed}");
    }
    // Known chaos: the bouncing ball, and the valve.
    let line = "diagram bouncing_ball_on_table --set r=0.9 --sweep Gamma=4:9:6 --at impact --observe v --json";
    let found = document(&typed(line, &[]));
    let outcomes = texts(&found, "outcome");
    assert!(
        outcomes
            .iter()
            .filter(|outcome| **outcome == "chaotic")
            .count()
            >= 5,
        "{outcomes:?}"
    );
    let line = "diagram pressure_relief_valve --sweep q=0.0206:0.0235:8 --observe y2 --transient 1000 --json";
    let found = document(&typed(line, &[]));
    let outcomes = texts(&found, "outcome");
    assert!(
        outcomes
            .iter()
            .filter(|outcome| **outcome == "chaotic")
            .count()
            >= 3,
        "{outcomes:?}"
    );
    assert!(!outcomes.contains(&"quasiperiodic"), "{outcomes:?}");
}

#[test]
fn a_phase_that_would_be_lost_is_told_with_what_to_do() {
    let folder = Folder::new("phase");
    let model = folder.file("beats.toml");
    let text = succeeds(&["models", "impact_oscillator"]);
    std::fs::write(
        &model,
        text.replace("cos(omega*t)", "cos(omega*t) + cos(t)"),
    )
    .unwrap();
    let line = "--sweep omega=2.2:2.4:5 --observe v --start carry --json";
    let with = |look: &[&str]| {
        let mut arguments = vec!["diagram", &model];
        arguments.extend(typed(line, look));
        fails(&arguments)
    };
    for look in [&["--at", "impact"][..], &["--period", "2*pi/omega"]] {
        let said = with(look);
        assert!(
            said.contains("cannot be carried from one value of `omega`"),
            "{said}"
        );
        assert!(
            said.contains("--period EXPR") && said.contains("start afresh"),
            "{said}"
        );
    }
}

#[test]
fn more_than_there_is_room_for_is_refused() {
    let line = "diagram pressure_relief_valve --sweep q=0.0201:0.0203:9 --observe y2 --json";
    let with = |more: &[&str]| fails(&typed(line, more));
    for keep in ["1000000000000000000", "18446744073709551615", "100000001"] {
        assert!(
            with(&["--keep", keep]).contains("expected 100000000 at most"),
            "{keep}"
        );
    }
    assert!(with(&["--keep", "100000000"]).contains("--out FILE.npz"));
    for threads in ["18446744073709551615", "100000", "0"] {
        assert!(
            with(&["--threads", threads]).contains("from 1 to 1024"),
            "{threads}"
        );
    }
    // One value of the sweep has no period, the others do.
    let line =
        "diagram impact_oscillator --sweep omega=0:3:4 --observe v --keep 20 --json --period";
    let found = document(&typed(line, &["2*pi/omega"]));
    let outcomes = texts(&found, "outcome");
    assert!(
        outcomes[0] == "no_return" && outcomes[1..].iter().all(|outcome| *outcome != "no_return")
    );
    let found = document(&typed(line, &["exp(1000*(omega-2))"]));
    assert_eq!(texts(&found, "outcome")[3], "no_return");
}

#[cfg(unix)]
#[test]
fn a_run_that_never_returns_is_broken_off_within_a_second() {
    let folder = Folder::new("never");
    let out = folder.file("a.npz");
    let line = "diagram impact_oscillator --sweep omega=2.2:2.4:400 --observe v --at graze --longest-return 1e9 \
                --most-impacts 1000000000000 --out";
    let child = begin(&typed(line, &[&out]));
    wait_for(&format!("{out}.journal"), 1);
    std::thread::sleep(Duration::from_millis(500));
    // Less than a tenth of that on a machine with nothing else to do.
    let output = interrupt_within(Duration::from_secs(1), child);
    assert_eq!(output.status.code(), Some(130));
}

#[test]
fn a_journal_in_another_form_is_refused() {
    let folder = Folder::new("form");
    let out = folder.file("a.npz");
    let journal = format!("{out}.journal");
    let line = "diagram pressure_relief_valve --sweep q=0.0201:0.0225:2000 --observe y2 --out";
    let mut child = begin(&typed(line, &[&out]));
    wait_for(&journal, 3_000);
    child.kill().unwrap();
    child.wait().unwrap();
    let unread = Unread::open(&journal).unwrap().unwrap();
    let header = unread.header().to_vec();
    drop(unread);
    std::fs::remove_file(&journal).unwrap();
    let mut header: Value = serde_json::from_slice(&header).unwrap();
    header.as_object_mut().unwrap().remove("row_format");
    Journal::find(&journal, header.to_string().as_bytes()).unwrap();
    let said = String::from_utf8(chatter(&["diagram", "--resume", &out]).stderr).unwrap();
    assert!(said.contains("begun by another chatter"), "{said}");
    assert!(fails(&typed(line, &[&out])).contains("begun by another chatter"));
}

/// An event is crossed where it resets the state: its name says where orbits are sampled, as that of a section does.
#[test]
fn orbits_are_sampled_at_events_by_their_names() {
    let folder = Folder::new("events");
    let model = folder.file("fires.toml");
    std::fs::write(
        &model,
        "[flight]\na = \"1.5 - a\"\n[[event]]\nname = \"fire\"\nsurface = \"a - 1\"\ndirection = \"rising\"\n\
         reset = { a = 0 }\n[initial]\na = 0.1\n",
    )
    .unwrap();
    for section in [&["--section", "fire"][..], &["--at", "reset:fire"], &[]] {
        let sampled = [
            &["diagram", &model, "--at", "initial:a=0.1", "--observe", "a"],
            section,
            &["--json"],
        ];
        let found = document(&sampled.concat());
        assert_eq!(texts(&found, "outcome"), ["periodic"], "{section:?}");
    }
    let stop = |stop: &str| fails(&["simulate", &model, "--until", "9", "--stop", stop]);
    assert!(stop("section:fire").contains("that is an event, which is told as a `reset`"));
    succeeds(&["simulate", &model, "--until", "9", "--stop", "reset:fire=3"]);
}
