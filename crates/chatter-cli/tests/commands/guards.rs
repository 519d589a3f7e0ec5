//! Requests that are more than meant, files that claim more than they hold, models that are more than can be done: each says
//! so, ends, or is ended by Ctrl-C, in memory that is in proportion.

use crate::common::{Folder, interrupt, told};
use chatter_files::tables::{Kind, NpzReader, NpzWriter, Values};
use std::path::PathBuf;
use std::process::Stdio;
use std::time::Duration;

/// Wrong input, and what is said about it in no more than so much memory.
fn fails(folder: &Folder, line: &str) -> String {
    told(&folder.run_within(4000, line), 2, line)
}

/// A ball on a floor, under this force.
fn ball(force: &str, definitions: &str) -> String {
    format!(
        "[flight]\ny = \"v\"\nv = \"{force}\"\n{definitions}\n[[contact]]\nname = \"floor\"\ngap = \"y\"\n\
         impulse = {{ v = 1 }}\nrestitution = 0.5\n[initial]\ny = 1\nv = 0\n"
    )
}

#[test]
fn more_rows_than_a_disk_holds_are_told_first_and_stopped_by_ctrl_c() {
    let folder = Folder::new("rows");
    let second = Duration::from_secs(1);
    for (interval, out) in [("1e-12", "a.npz"), ("1e-9", "a.csv")] {
        let line =
            format!("simulate bouncing_ball_on_table --until 90 --sample {interval} --out {out}");
        let said = folder.interrupt(&line, second);
        assert!(said.contains("rows are asked for"), "{said}");
    }
    // What was done stays.
    assert_eq!(folder.names(), ["a.csv", "a.npz"]);
    let time = NpzReader::open(folder.path("a.npz"))
        .unwrap()
        .floats("time")
        .unwrap();
    assert!(time.len() > 1000 && time.is_sorted());
}

#[test]
fn a_stiff_model_says_what_limits_its_steps() {
    let folder = Folder::new("stiff");
    folder.write("damped.toml", &ball("-1e9*v - y - 1", ""));
    folder.write("spring.toml", &ball("-1e18*(y - 2)", ""));
    let second = Duration::from_secs(1);
    let said = folder.interrupt("simulate damped.toml --until 1000", second);
    assert!(
        said.contains("stiff: `v` changes at a rate of 1.0e9"),
        "{said}"
    );
    let said = folder.interrupt("simulate spring.toml --until 1000", second);
    assert!(
        said.contains("`v` and `y` change each other at a rate of 1.0e9"),
        "{said}"
    );
    let damped = "simulate impact_oscillator --set zeta=1e8 --until 10000";
    assert!(
        folder
            .interrupt(damped, second)
            .contains("the model is stiff")
    );
    let said = folder.interrupt(
        "diagram impact_oscillator --set zeta=1e8 --sweep omega=2:3:10 --observe x --out a.npz",
        second,
    );
    assert!(
        said.contains("the model is stiff") && said.contains("the diagram takes some"),
        "{said}"
    );
    let said = folder.interrupt(
        "simulate impact_oscillator --until 1e40 --impacts 100000000000",
        second,
    );
    assert!(
        said.contains("to time 1e40 there are about") && !said.contains("stiff"),
        "{said}"
    );
}

#[test]
fn ctrl_c_ends_every_long_command() {
    let folder = Folder::new("ctrlc");
    let short = Duration::from_millis(300);
    for line in [
        "border impact_oscillator --parameter sigma --near 0.2 --windows 5:500",
        "universal --restitution 0.8 --windows 0:60 --periods 1:6 --chaos --out a.csv",
        "universal --restitution 0.8 --sweep mu=0:0.05:100000 --keep 10000 --out a.npz",
        "reproduce --out r",
    ] {
        let said = folder.interrupt(line, short);
        assert!(said.contains("broken off"), "{said}");
    }
    assert_eq!(folder.names(), ["r"]);
}

/// Nor does it take memory for each of a billion parts.
#[test]
fn what_a_search_for_borders_has_found_is_told_when_it_is_broken_off() {
    let folder = Folder::new("search");
    for samples in ["20000", "1000000000"] {
        let line =
            format!("border impact_oscillator --parameter sigma --range -1:1 --samples {samples}");
        let mut command = folder.command(".", &line);
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        let child = command.spawn().unwrap();
        std::thread::sleep(Duration::from_secs(1));
        let output = interrupt(child);
        told(&output, 130, &line);
        let said = String::from_utf8(output.stdout).unwrap();
        assert!(said.contains("interrupted: there may be more"), "{said}");
    }
}

#[test]
fn memory_does_not_grow_with_events() {
    let folder = Folder::new("events");
    // Half a million events of 130 bytes, in whatever form they are told.
    for rest in [
        "",
        "--events",
        "--json",
        "--sample events --out a.csv",
        "--sample events --out a.npz",
    ] {
        let line = format!("simulate bouncing_ball_on_table --impacts 500000 {rest} > /dev/null");
        told(&folder.run_within(60, &line), 0, &line);
    }
    let file = NpzReader::open(folder.path("a.npz")).unwrap();
    let rates = file.floats("rate_before").unwrap();
    assert_eq!(
        rates.iter().filter(|rate| rate.is_finite()).count(),
        500_000
    );
    let rows = std::fs::read_to_string(folder.path("a.csv")).unwrap();
    assert_eq!(rows.lines().count(), 1 + rates.len());
    assert_eq!(folder.names(), ["a.csv", "a.npz"]);
}

#[test]
fn memory_does_not_grow_with_the_table() {
    let folder = Folder::new("memory");
    // Some five million rows of four columns.
    let line = "simulate bouncing_ball_on_table --impacts 250000 --out a.npz --sample dense:20";
    told(&folder.run_within(300, line), 0, line);
    let rows = NpzReader::open(folder.path("a.npz"))
        .unwrap()
        .info("time")
        .unwrap()
        .len();
    assert!(rows > 4_000_000, "{rows}");
    // 160 MB of samples.
    let line = "universal --restitution 0.8 --sweep mu=0.01:0.05:200 --keep 100000 --out b.npz";
    told(&folder.run_within(1000, line), 0, line);
}

#[test]
fn models_that_are_too_large_are_refused_and_long_ones_are_not() {
    let folder = Folder::new("large");
    let chain = |count: usize, next: &dyn Fn(usize) -> String| {
        let lines: Vec<String> = (1..=count)
            .map(|k| format!("d{k} = \"{}\"", next(k - 1)))
            .collect();
        ball(
            &format!("-1 + 1e-9*d{count}"),
            &format!("[definitions]\nd0 = \"y\"\n{}", lines.join("\n")),
        )
    };
    folder.write("sines.toml", &chain(20_000, &|k| format!("sin(d{k})")));
    folder.write("sums.toml", &chain(20_000, &|k| format!("d{k} + 1")));
    let factors: Vec<String> = (1..=5000).map(|k| format!("(y+{k})")).collect();
    folder.write(
        "product.toml",
        &ball(&format!("-1 + 1e-300*{}", factors.join("*")), ""),
    );
    let said = fails(&folder, "simulate sines.toml");
    assert!(said.contains("nested 20"), "{said}");
    let said = fails(&folder, "simulate product.toml");
    assert!(said.contains("so many factors"), "{said}");
    for name in ["sines", "product"] {
        let line = format!("check {name}.toml");
        let output = folder.run_within(2000, &line);
        told(&output, 0, &line);
        assert!(String::from_utf8_lossy(&output.stdout).contains("supported"));
    }
    let line = "simulate sums.toml";
    told(&folder.run_within(1000, line), 0, line);
}

#[test]
fn check_tells_what_simulate_would_refuse() {
    let folder = Folder::new("check");
    let contact = |name: &str, gap: &str| {
        format!(
            "[[contact]]\nname = \"{name}\"\ngap = \"{gap}\"\nimpulse = {{ v = 1 }}\nrestitution = 0.5\n"
        )
    };
    let cases = [
        (
            ball("-1", &contact("again", "y")),
            "`again` and `floor` have the same gap",
        ),
        (
            ball("-1", &contact("again", "3*y")),
            "`again` and `floor` have the same gap",
        ),
        (
            ball("-1", "[section.s]\nsurface = \"3\"\ndirection = \"rising\""),
            "nothing crosses it",
        ),
        (
            ball("-1", "[parameters]\ng = 0").replace("v = 1 }", "v = \"1/g\" }"),
            "impulse",
        ),
    ];
    for (text, expected) in cases {
        folder.write("m.toml", &text);
        let output = folder.run(".", "check m.toml");
        let said = String::from_utf8_lossy(&output.stdout).into_owned()
            + &String::from_utf8_lossy(&output.stderr);
        assert!(said.contains(expected), "{expected}: {said}");
        assert!(!said.contains("nothing looks wrong"));
    }
}

/// Writes an archive again, with some of its texts and numbers changed.
fn changed(
    from: PathBuf,
    to: PathBuf,
    text: impl Fn(&str, String) -> String,
    number: impl Fn(&str, usize, f64) -> f64,
) {
    let reader = NpzReader::open(from).unwrap();
    let mut writer = NpzWriter::create(to).unwrap();
    for array in reader.arrays() {
        let name = &array.name;
        match (array.kind, array.shape.is_empty()) {
            (Kind::Text { .. }, true) => {
                let new = text(name, reader.text(name).unwrap());
                writer.text(name, &new).unwrap();
            }
            _ => {
                let mut column = reader.column(name).unwrap();
                if let Values::Floats(values) = &mut column.values {
                    for (place, value) in values.iter_mut().enumerate() {
                        *value = number(name, place, *value);
                    }
                }
                writer.column(&column).unwrap();
            }
        }
    }
    writer.finish().unwrap();
}

#[test]
fn an_archive_that_claims_more_than_it_holds_is_refused() {
    let folder = Folder::new("claims");
    let line = "diagram bouncing_ball_on_table --at impact --observe v --sweep Gamma=1.2:2:5 --keep 20 --transient 5 --out";
    told(&folder.run(".", &format!("{line} one.npz")), 0, line);
    let map = line.replace("--keep", "--sweep r=0.1:0.5:3 --keep");
    told(&folder.run(".", &format!("{map} two.npz")), 0, &map);
    let counts = ["1000000000000000000", "100000000", "6", "0"];
    for (name, old) in [("one", "\"count\":5"), ("two", "\"count\":3")] {
        for count in counts {
            changed(
                folder.path(&format!("{name}.npz")),
                folder.path("claims.npz"),
                |_, text| text.replace(old, &format!("\"count\":{count}")),
                |_, _, value| value,
            );
            fails(&folder, "plot claims.npz --out a.png");
            fails(&folder, "plot claims.npz --out a.png --zoom Gamma=5:6");
        }
    }
    // Values that overflow are drawn, or refused.
    let huge = [
        f64::MAX,
        f64::MIN,
        f64::INFINITY,
        f64::NAN,
        1e300,
        -5e307,
        5e-324,
    ];
    for count in 1..huge.len() {
        changed(
            folder.path("one.npz"),
            folder.path("huge.npz"),
            |_, text| text,
            |name, place, value| {
                if name == "v" {
                    huge[place % count]
                } else {
                    value
                }
            },
        );
        for options in [
            "a.svg",
            "b.png",
            "c.svg --shear auto",
            "d.svg --shear 1e308",
        ] {
            let line = format!("plot huge.npz --out {options}");
            let output = folder.run_within(2000, &line);
            let code = output.status.code();
            assert!(code == Some(0) || code == Some(2), "{line}: {code:?}");
        }
    }
}

#[test]
fn maps_that_cannot_be_drawn_are_refused_before_they_are_computed() {
    let folder = Folder::new("cells");
    let said = fails(
        &folder,
        "diagram bouncing_ball_on_table --at impact --observe v --sweep Gamma=1.2:2:10000 --sweep r=0.1:0.5:10000 --plot a.png",
    );
    assert!(said.contains("10000 by 10000 cells"), "{said}");
    assert!(folder.names().is_empty());
}
