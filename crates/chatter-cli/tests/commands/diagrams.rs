//! Orbit diagrams as a user computes them: tables, resumption after kill and Ctrl-C, pictures, wrong input.

use crate::common::{Folder, begin, chatter, fails, interrupt, succeeds, told, typed, wait_for};
use chatter_files::tables::NpzReader;

/// The diagram of the issue, with fewer values.
fn valve<'a>(sweep: &'a str, options: &'a str, rest: &[&'a str]) -> Vec<&'a str> {
    let valve = "diagram pressure_relief_valve --section closing --observe y2 --start carry --chunk 4 --sweep";
    let mut arguments = typed(valve, &[sweep]);
    arguments.extend(typed(options, rest));
    arguments
}

/// Long enough to be broken off.
fn long(out: &str) -> Vec<&str> {
    let options = "--transient 400 --keep 200 --threads 2 --out";
    valve("q=0.0201:0.0225:800", options, &[out])
}

#[test]
fn a_killed_sweep_goes_on_to_the_same_file() {
    let folder = Folder::new("kill");
    let (whole, killed) = (folder.file("whole.npz"), folder.file("killed.npz"));
    succeeds(&long(&whole));
    let journal = format!("{killed}.journal");
    // Twice, so that what was resumed is itself broken off.
    for (bytes, arguments) in [
        (20_000, long(&killed)),
        (400_000, vec!["diagram", "--resume", &killed]),
    ] {
        let mut child = begin(&arguments);
        wait_for(&journal, bytes);
        // SIGKILL, on Unix.
        child.kill().unwrap();
        child.wait().unwrap();
        assert!(!std::fs::exists(&killed).unwrap());
    }
    // A record that was being written.
    let mut bytes = std::fs::read(&journal).unwrap();
    bytes.truncate(bytes.len() - 7);
    std::fs::write(&journal, bytes).unwrap();
    // Another number of threads makes no difference.
    let said = chatter(&["diagram", "--resume", &killed, "--threads", "1"]);
    assert_eq!(said.status.code(), Some(0));
    assert!(String::from_utf8_lossy(&said.stderr).contains("orbits are done"));
    assert!(folder.bytes("whole.npz") == folder.bytes("killed.npz"));
    assert_eq!(folder.names(), ["killed.npz", "whole.npz"]);
    assert!(succeeds(&["diagram", "--resume", &killed]).contains("nothing to resume"));
}

#[cfg(unix)]
#[test]
fn an_interrupted_sweep_stops_at_once_and_keeps_what_is_done() {
    let folder = Folder::new("interrupt");
    let (whole, stopped) = (folder.file("whole.csv"), folder.file("stopped.csv"));
    let child = begin(&long(&stopped));
    wait_for(&format!("{stopped}.journal"), 40_000);
    let said = told(&interrupt(child), 130, &stopped);
    assert!(
        said.contains("go on with: chatter diagram --resume"),
        "{said}"
    );
    // The same command goes on as well.
    succeeds(&long(&stopped));
    succeeds(&long(&whole));
    for table in ["columns", "samples", "metadata"] {
        let of = |name: &str| folder.bytes(&format!("{name}.{table}.csv"));
        assert!(of("whole") == of("stopped"), "{table}");
    }
}

#[test]
fn a_foreign_journal_is_refused() {
    let folder = Folder::new("foreign");
    let out = folder.file("a.npz");
    let mut child = begin(&long(&out));
    wait_for(&format!("{out}.journal"), 5_000);
    child.kill().unwrap();
    child.wait().unwrap();
    let with = |sweep: &str| fails(&valve(sweep, "--transient 400 --keep 100 --out", &[&out]));
    let said = with("q=0.0201:0.0225:800");
    assert!(
        said.contains("an unfinished diagram with other options"),
        "{said}"
    );
    let said = with("q=0.0201:0.0225:801");
    assert!(said.contains("with another sweep"), "{said}");
    let mut other = long(&out);
    other.extend(["--set", "kappa=1.3"]);
    assert!(fails(&other).contains("with other parameters"));
    other[1] = "bouncing_ball";
    std::fs::write(format!("{out}.journal"), "something else").unwrap();
    assert!(fails(&long(&out)).contains("is not a journal of chatter"));
    assert!(fails(&["diagram", "--resume", &out]).contains("is not a journal"));
}

#[test]
fn tables_have_the_names_of_the_issue_and_the_same_numbers() {
    let folder = Folder::new("tables");
    let (npz, csv) = (folder.file("a.npz"), folder.file("a.csv"));
    let options = "--transient 30 --keep 20 --observe n=impacts --exponent --out";
    let with = |out: &str| succeeds(&valve("q=0.0203:0.0206:7", options, &[out]));
    let said = with(&npz);
    assert!(said.contains("q from 0.0203 to 0.0206, 7 values"), "{said}");
    with(&csv);
    let file = NpzReader::open(&npz).unwrap();
    let names: Vec<&str> = file.arrays().map(|array| array.name.as_str()).collect();
    assert_eq!(
        names,
        [
            "q",
            "outcome",
            "period",
            "impacts_per_return",
            "exponent",
            "start",
            "initial_y1",
            "initial_y2",
            "initial_y3",
            "column",
            "y2",
            "n",
            "specification",
            "model",
            "parameters",
            "version"
        ]
    );
    assert_eq!(file.floats("q").unwrap()[6], 0.0206);
    assert_eq!(file.integers("column").unwrap().len(), 140);
    let (y2, n) = (file.floats("y2").unwrap(), file.floats("n").unwrap());
    assert!(
        n.iter()
            .all(|&n| (25.0..40.0).contains(&n) && n.fract() == 0.0)
    );
    assert!(file.text("model").unwrap().contains("Dankowicz"));
    let job: serde_json::Value =
        serde_json::from_str(&file.text("specification").unwrap()).unwrap();
    assert_eq!(job["diagram"]["period_tolerance"], 1e-8);
    assert_eq!(job["returns"]["tolerance"], 0.0);
    let samples = std::fs::read_to_string(folder.file("a.samples.csv")).unwrap();
    let mut lines = samples.lines();
    assert_eq!(lines.next(), Some("column,y2,n"));
    for ((line, y2), n) in lines.by_ref().zip(&y2).zip(&n) {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        assert_eq!((cells[1], cells[2]), (*y2, *n));
    }
    let columns = std::fs::read_to_string(folder.file("a.columns.csv")).unwrap();
    assert!(columns.starts_with(
        "q,outcome,period,impacts_per_return,exponent,start,initial_y1,initial_y2,initial_y3\r\n0.0203,"
    ));
    assert_eq!(columns.lines().count(), 8);
}

#[test]
fn pictures_are_drawn_at_once_and_later() {
    let folder = Folder::new("pictures");
    let (npz, png) = (folder.file("a.npz"), folder.file("a.png"));
    let options = "--transient 50 --keep 40 --observe impacts --shear auto --out";
    succeeds(&valve(
        "q=0.0203:0.0206:40",
        options,
        &[&npz, "--plot", &png],
    ));
    // From the file as from the journal.
    let later = folder.file("later.png");
    succeeds(&["plot", &npz, "--out", &later, "--shear", "auto"]);
    assert!(folder.bytes("a.png") == folder.bytes("later.png"));
    let (svg, pdf) = (folder.file("a.svg"), folder.file("a.pdf"));
    let zoom = ["--zoom", "q=0.0203:0.0204", "--observe", "y2"];
    let mut plot = vec!["plot", &npz, "--out", &svg];
    plot.extend(zoom);
    assert!(succeeds(&plot).contains("--shear auto"));
    let text = String::from_utf8(folder.bytes("a.svg")).unwrap();
    // Few samples are vectors, too.
    assert!(!text.contains("data:image/png;base64") && text.contains("<path"));
    plot[3] = &pdf;
    succeeds(&plot);
    assert!(folder.bytes("a.pdf").starts_with(b"%PDF"));
    let wrong = |more: &[&str]| {
        let mut plot = vec!["plot", &npz, "--out", &png];
        plot.extend(more);
        fails(&plot)
    };
    assert!(wrong(&["--zoom", "q=1:2"]).contains("no value of `q` from 1 to 2"));
    assert!(wrong(&["--zoom", "q=0.0204:0.0203"]).contains("shows nothing"));
    assert!(wrong(&["--zoom", "p=0:1"]).contains("there is `q`, `y2`, `impacts`"));
    assert!(wrong(&["--observe", "y3"]).contains("is not observed"));
    assert!(fails(&["plot", &png, "--out", &pdf]).contains("is not a readable NPZ file"));
}

/// Few samples are discs, many an embedded density; the first and last of few values are seen whole.
#[test]
fn many_samples_are_a_density_and_few_are_discs() {
    let folder = Folder::new("discs");
    let drawn = |count: &str, keep: &str| {
        let (npz, svg) = (folder.file("a.npz"), folder.file("a.svg"));
        let sweep = [
            "--sweep",
            count,
            "--observe",
            "x",
            "--transient",
            "0",
            "--keep",
            keep,
        ];
        let mut diagram = vec!["diagram", "impact_oscillator", "--period", "2*pi/omega"];
        diagram.extend(sweep);
        diagram.extend(["--out", &npz, "--plot", &svg]);
        succeeds(&diagram);
        String::from_utf8(folder.bytes("a.svg")).unwrap()
    };
    let image = "data:image/png;base64";
    let few = drawn("omega=2.7:2.8:20", "50");
    assert!(!few.contains(image));
    assert!(drawn("omega=2.8:2.9:20", "400").contains(image));
    assert!(drawn("omega=2.7:2.8:600", "2").contains(image));
    // From the middle of the first of twenty cells to that of the last.
    let places: Vec<f64> = (few.split("<use ").skip(1))
        .map(|disc| disc.split_once("x=\"").unwrap().1)
        .map(|x| x.split('"').next().unwrap().parse().unwrap())
        .collect();
    let least = places.iter().copied().fold(f64::INFINITY, f64::min);
    let most = places.iter().copied().fold(0.0, f64::max);
    let width = (most - least) / 19.0;
    assert!(
        places
            .iter()
            .all(|x| ((x - least) / width + 0.01).fract() < 0.02)
    );
    assert!(least > width && most + width / 2.0 < 504.6);
}

#[test]
fn a_part_computed_again_is_the_diagram_over_that_part() {
    let folder = Folder::new("recompute");
    let [wide, narrow, again, direct] =
        ["wide.npz", "narrow.npz", "again.png", "direct.png"].map(|name| folder.file(name));
    for (range, out) in [("Gamma=1.2:4:40", &wide), ("Gamma=2:2.5:40", &narrow)] {
        let options = "--at impact --observe v --transient 20 --keep 20 --out";
        let mut diagram = vec!["diagram", "bouncing_ball_on_table", "--sweep", range];
        diagram.extend(options.split(' '));
        diagram.push(out);
        succeeds(&diagram);
    }
    let zoom = ["plot", &wide, "--out", &again, "--zoom"];
    let few = succeeds(&[&zoom[..], &["Gamma=2:2.5"]].concat());
    assert!(few.contains("only 7 values of `Gamma` of 40"), "{few}");
    let said = succeeds(&[&zoom[..], &["Gamma=2:2.5", "--recompute"]].concat());
    assert!(!said.contains("only"), "{said}");
    succeeds(&["plot", &narrow, "--out", &direct]);
    assert!(folder.bytes("again.png") == folder.bytes("direct.png"));
    let useless = fails(&[&zoom[..], &["v=0:1", "--recompute"]].concat());
    assert!(useless.contains("computes the same again"), "{useless}");
}

#[test]
fn maps_over_two_parameters_are_tables_and_pictures() {
    let folder = Folder::new("maps");
    let (npz, png) = (folder.file("a.npz"), folder.file("a.png"));
    let options = "--sweep r=0.5:0.81:4 --transient 10 --keep 10 --exponent --out";
    succeeds(&valve(
        "q=0.0202:0.0206:5",
        options,
        &[&npz, "--plot", &png],
    ));
    let file = NpzReader::open(&npz).unwrap();
    assert!(!file.contains("column") && !file.contains("y2"));
    let (q, r) = (file.floats("q").unwrap(), file.floats("r").unwrap());
    assert_eq!((q.len(), q[5], r[4], r[5]), (20, q[0], 0.5, r[9]));
    let outcomes = file.texts("outcome").unwrap();
    assert!(
        outcomes[..15]
            .iter()
            .all(|outcome| outcome == "complete_chatter")
    );
    for show in ["period", "impacts", "exponent"] {
        succeeds(&["plot", &npz, "--show", show, "--out", &png]);
    }
    std::fs::remove_file(&png).unwrap();
    let useless = |more: &[&str]| fails(&[&["plot", &npz, "--out", &png], more].concat());
    assert!(useless(&["--shear", "auto"]).contains("--shear changes nothing"));
    assert!(useless(&["--observe", "y2"]).contains("--observe"));
    assert!(!std::fs::exists(&png).unwrap());
}

#[test]
fn diagrams_of_the_universal_map_are_diagrams_like_others() {
    let folder = Folder::new("universal");
    let (npz, csv, png) = (
        folder.file("a.npz"),
        folder.file("a.csv"),
        folder.file("a.png"),
    );
    let line = "universal --restitution 0.8 --sweep mu=0.004:0.006:40 --keep 60 --out";
    for out in [&npz, &csv] {
        succeeds(&typed(line, &[out]));
    }
    let file = NpzReader::open(&npz).unwrap();
    assert_eq!(file.floats("mu").unwrap().len(), 40);
    assert_eq!(file.texts("outcome").unwrap().len(), 40);
    assert_eq!(file.integers("column").unwrap().len(), 2400);
    assert!(file.text("model").unwrap().contains("Upsilon"));
    let columns = std::fs::read_to_string(folder.file("a.columns.csv")).unwrap();
    assert!(columns.starts_with("mu,outcome,period,impacts_per_return,start,initial_z\r\n0.004,"));
    succeeds(&["plot", &npz, "--zoom", "mu=0.0045:0.005", "--out", &png]);
    let wrong = |more: &[&str]| fails(&[&["plot", &npz, "--out", &png], more].concat());
    assert!(wrong(&["--zoom", "mu=0:y"]).contains("`y` is no number"));
    assert!(wrong(&["--zoom", "z=8:9"]).contains("no sample of `z` from 8 to 9"));
    assert!(wrong(&["--show", "impacts"]).contains("--show changes nothing"));
}

#[test]
fn wrong_input_is_told_before_anything_is_computed() {
    let folder = Folder::new("wrong");
    let out = folder.file("a.npz");
    let with = |change: &[&str]| {
        let mut arguments = vec!["diagram", "pressure_relief_valve", "--out", &out];
        arguments.extend(change);
        fails(&arguments)
    };
    let sweep = ["--sweep", "q=0.0201:0.0203:9"];
    let and = |more: &[&str]| with(&[&sweep[..], more].concat());
    let observed = |more: &[&str]| and(&[&["--observe", "y2"], more].concat());
    assert!(observed(&["--section", "closingg"]).contains("did you mean `closing`?"));
    assert!(observed(&["--at", "impact:seet"]).contains("did you mean `seat`?"));
    assert!(observed(&["--at", "impct"]).contains("did you mean `impact`?"));
    assert!(observed(&["--period", "2*pi/omega"]).contains("unknown name `omega`"));
    assert!(observed(&["--period", "-q"]).contains("expected a positive number"));
    assert!(and(&["--observe", "y2 + yy3"]).contains("did you mean `y3`?"));
    assert!(and(&["--observe", "q"]).contains("would be called `q`"));
    assert!(and(&["--observe", "y1/y2"]).contains("--observe NAME=EXPR"));
    assert!(and(&["--observe", "model=y1"]).contains("`model`"));
    assert!(observed(&["--keep", "0"]).contains("expected a whole number from 1"));
    assert!(observed(&["--start", "cary"]).contains("did you mean `carry`?"));
    assert!(observed(&["--start", "random:3"]).contains("--box"));
    assert!(observed(&["--start", "random:3", "--box", "z=0:1"]).contains("no state `z`"));
    assert!(observed(&["--box", "y1=0:1"]).contains("there are none"));
    assert!(observed(&["--shear", "auto"]).contains("--plot"));
    let range = |range: &str| with(&["--observe", "y2", "--sweep", range]);
    assert!(range("p=0:1:3").contains("no parameter `p`"));
    assert!(range("y1=0:1:3").contains("is a state"));
    assert!(range("q=0.03:0.02:3").contains("is reversed"));
    assert!(range("q=0.02:0.02:3").contains("is empty"));
    assert!(range("q=0.02:0.03:0").contains("has no values"));
    assert!(range("q=0.02:0.03").contains("expected NAME=FROM:TO:COUNT"));
    assert!(range("q=-1:0.03:3:log").contains("by ratios"));
    assert!(range("q=0.02:zz:3").contains("unknown name `zz`"));
    let line = "diagram pressure_relief_valve --observe y2 --sweep q=0.0201:0.0203:9";
    assert!(fails(&typed(line, &[])).contains("goes nowhere"));
    let missing = folder.file("no/a.npz");
    let said = fails(&typed(line, &["--out", &missing]));
    assert!(said.contains("does not exist"), "{said}");
    let said = fails(&typed(line, &["--out", "a.xyz"]));
    assert!(said.contains("xyz"), "{said}");
    assert!(observed(&["--chunk", "4"]).contains("none is carried"));
    assert!(observed(&["--set", "q=0.02"]).contains("both set and swept"));
    assert!(range("r=0.5:1.1:3").contains("restitution 1.1"));
    assert!(range("q=0.02:0.03:999999999999").contains("expected 100000000 at most"));
    assert!(fails(&["diagram", "--resume", &out]).contains("nothing to resume"));
    let cam = "diagram cam_follower --observe y --sweep speed=500:600:9 --out";
    let said = fails(&typed(cam, &[&out]));
    assert!(said.contains("it has `bottom`, `top`"), "{said}");
    assert!(folder.names().is_empty(), "{:?}", folder.names());
}
