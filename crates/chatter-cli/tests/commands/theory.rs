//! What programs read of the universal map, border orbits and the reproduction of the paper.

use crate::common::{Folder, chatter, document, fails, number};
use serde_json::Value;

fn close(value: &Value, expected: f64, tolerance: f64) {
    let value = number(value);
    assert!((value - expected).abs() <= tolerance, "{value} {expected}");
}

const VALVE: &str = "pressure_relief_valve";

#[test]
fn constants_have_their_members() {
    let map = document(&["universal", "--restitution", "0.8", "--json"]);
    close(&map["restitution"], 0.8, 0.0);
    close(&map["chatter_fixed_point"], 0.060_023_838_139_441_61, 1e-16);
    close(&map["lambda"], 0.874_720_688_417_596_5, 2e-16);
    close(&map["eta"], 0.800_141_908_455_089_3, 2e-16);
    close(&map["exponent"], 1.200_636_400_863_045_7, 4e-16);
    close(&map["lap_end"], 0.063_222_001_601_730_43, 1e-16);
    assert!(map.get("values").is_none() && map.get("windows").is_none());
    let long = document(&[
        "universal",
        "--restitution",
        "0.8",
        "--digits",
        "30",
        "--json",
    ]);
    assert_eq!(long["lambda_digits"], "0.874720688417596469375916860255");
}

#[test]
fn values_obey_self_similarity() {
    let map = document(&[
        "universal",
        "--restitution",
        "0.8",
        "--at",
        "0.05,1e-3,2e-5,-1",
        "--json",
    ]);
    let values = map["values"].as_array().unwrap();
    assert_eq!(values.len(), 4);
    let (lambda, eta) = (number(&map["lambda"]), number(&map["eta"]));
    for value in &values[..3] {
        let x = number(&value["x"]);
        let scaled = format!("{}", x * eta);
        let next = document(&[
            "universal",
            "--restitution",
            "0.8",
            "--at",
            &scaled,
            "--json",
        ]);
        let next = &next["values"][0];
        let expected = lambda * lambda * number(&value["upsilon"]);
        close(&next["upsilon"], expected, 1e-13 * expected.abs());
        let expected = lambda * lambda / eta * number(&value["derivative"]);
        close(&next["derivative"], expected, 1e-11 * expected.abs());
        assert_eq!(
            next["n"].as_i64().unwrap(),
            value["n"].as_i64().unwrap() + 1
        );
        close(&next["u1"], number(&value["u1"]), 1e-12);
    }
    assert_eq!(values[3]["upsilon"], 0.0);
    assert_eq!(values[3]["n"], Value::Null);
}

#[test]
fn windows_are_listed_and_null_where_there_is_none() {
    let folder = Folder::new("windows");
    let table = folder.file("windows.csv");
    let map = document(&[
        "universal",
        "--restitution",
        "0.8",
        "--slope",
        "1",
        "--windows",
        "0:60",
        "--json",
        "--out",
        &table,
    ]);
    let windows = map["windows"].as_array().unwrap();
    assert_eq!(windows.len(), 61);
    for (n, window) in windows.iter().enumerate() {
        assert_eq!(window["n"], n);
        let graze = number(&window["grazing"]);
        let superstable = number(&window["superstable"]);
        assert!(superstable < number(&window["period_doubling"]) && superstable < graze);
        if let Some(fold) = window["fold"].as_f64() {
            assert!(fold < superstable);
        }
    }
    // Folds cease as Upsilon gets flatter.
    assert!(windows[0]["fold"].is_f64() && windows[60]["fold"].is_null());
    let text = std::fs::read_to_string(table).unwrap();
    assert!(text.starts_with("n,fold,period_doubling,superstable,grazing"));
    assert_eq!(text.lines().count(), 62);
}

#[test]
fn an_orbit_settles_to_the_superstable_point() {
    let map = document(&[
        "universal",
        "--restitution",
        "0.8",
        "--windows",
        "40:40",
        "--json",
    ]);
    let mu = number(&map["windows"][0]["superstable"]);
    let sweep = format!("mu={}:{}:3", mu * 0.9999, mu * 1.0001);
    let folder = Folder::new("sweep");
    let plot = folder.file("orbits.svg");
    let map = document(&[
        "universal",
        "--restitution",
        "0.8",
        "--sweep",
        &sweep,
        "--lyapunov",
        "--json",
        "--plot",
        &plot,
    ]);
    let middle = &map["columns"][1];
    close(&middle["mu"], mu, 1e-18);
    assert_eq!(middle["outcome"], "periodic");
    assert_eq!(middle["period"], 1);
    assert!(number(&middle["exponent"]) < -5.0);
    assert!(std::fs::read_to_string(plot).unwrap().ends_with("</svg>\n"));
}

#[test]
fn a_border_has_its_members() {
    let border = document(&[
        "border",
        VALVE,
        "--parameter",
        "q",
        "--near",
        "0.02",
        "--json",
    ]);
    assert_eq!(border["parameter"], "q");
    close(&border["value"], 0.020_056_005_689_312_284, 1e-15);
    assert!(number(&border["error"]) < 1e-13);
    close(&border["restitution"], 0.8, 0.0);
    close(
        &border["chatter_fixed_point"],
        0.060_023_838_139_441_61,
        1e-15,
    );
    assert!(number(&border["lambda"]) > number(&border["eta"]));
    close(&border["first_impact"]["y1"], 0.0, 0.0);
    close(&border["first_impact"]["y2"], 0.118_256, 5e-7);
    close(&border["first_impact"]["y3"], 9.45248, 5e-6);
    let exact = &border["exact"];
    close(&exact["slope"], 2.418_590_733_568_688, 1e-8);
    close(&exact["unfolding_rate"], 0.122_000_015_296_745, 1e-9);
    assert!(number(&exact["slope_error"]) < 1e-7);
    assert!(number(&exact["unfolding_rate_error"]) < 1e-8);
    assert!(number(&exact["amplitude"]) > 0.0);
    assert_eq!(exact["covector"].as_array().unwrap().len(), 2);
    assert!(exact["covector_parameter"].is_f64());
    let form = &border["leading_order"];
    close(&form["slope"], 4.58679, 2e-5);
    close(&form["unfolding_rate"], 0.754_296, 2e-5);
    close(&form["A"][1][0], 60.6417, 5e-5);
    for vector in ["B", "C", "E", "F"] {
        assert_eq!(form[vector].as_array().unwrap().len(), 2, "{vector}");
    }
    close(&form["D"], 7.88954, 1e-5);
    assert!(border["parameters"].get("q").is_none() && border["parameters"]["r"] == 0.8);
}

/// The predicted windows and the model's own, which the prediction misses the less the larger n is.
#[test]
fn windows_of_a_border_stand_beside_those_of_the_model() {
    let border = document(&[
        "border",
        "impact_oscillator",
        "--parameter",
        "sigma",
        "--near",
        "0.12",
        "--windows",
        "10:20",
        "--json",
    ]);
    let lists = ["windows", "simulated_windows"].map(|name| border[name].as_array().unwrap());
    assert_eq!([lists[0].len(), lists[1].len()], [11, 11]);
    let value = number(&border["value"]);
    for name in ["fold", "period_doubling", "grazing"] {
        let mut before = f64::INFINITY;
        for (predicted, found) in lists[0].iter().zip(lists[1]) {
            assert_eq!(predicted["n"], found["n"]);
            let [predicted, own] = [predicted, found].map(|window| number(&window[name]));
            let miss = number(&found[format!("{name}_missed_by")]);
            assert!((miss - (predicted - own) / (own - value)).abs() < 1e-9);
            assert!(miss.abs() < 0.9 * before, "{found}");
            assert!(number(&found[format!("{name}_error")]) < 1e-6 * (own - value).abs());
            before = miss.abs();
        }
        assert!(before < 0.04);
    }
}

#[test]
fn a_parameter_that_changes_nothing_is_refused() {
    let folder = Folder::new("unused");
    let file = folder.file("idle.toml");
    let valve = chatter(&["models", VALVE]);
    let text = String::from_utf8(valve.stdout).unwrap();
    std::fs::write(
        &file,
        text.replacen("[parameters]", "[parameters]\nidle = 1.0", 1),
    )
    .unwrap();
    let output = chatter(&["border", &file, "--parameter", "idle", "--near", "1"]);
    assert_eq!(output.status.code(), Some(2));
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(told.contains("no equation uses parameter `idle`"), "{told}");
}

#[test]
fn a_range_lists_borders_or_none() {
    let range = |range: &str| {
        document(&[
            "border",
            VALVE,
            "--parameter",
            "q",
            "--range",
            range,
            "--set",
            "kappa=1",
            "--json",
        ])
    };
    let some = range("0.03:0.06");
    assert_eq!(some["borders"].as_array().unwrap().len(), 1);
    close(&some["borders"][0]["value"], 0.047_964_883_927, 1e-11);
    assert_eq!(range("0.05:0.06")["borders"].as_array().unwrap().len(), 0);
}

#[test]
fn values_that_cannot_be_followed_are_listed() {
    let folder = Folder::new("unfollowed");
    // A hammer whose softening spring throws it off at large amplitudes.
    let text = "[parameters]\nA = 1.2\n[flight]\nx = 'v'\nv = '-1 - 0.3*x - 0.05*v + 0.02*x^3 + A*cos(0.7*t)'\n\
                [[contact]]\nname = 'anvil'\ngap = 'x'\nimpulse = { v = 1 }\nrestitution = 0.75\n[initial]\nx = 0.1\nv = 0\n";
    folder.write("m.toml", text);
    let line = "border m.toml --parameter A --range 1.3:2.3 --samples 20 --windows 9:9";
    let told: Value =
        serde_json::from_str(&folder.succeeds("", &format!("{line} --json"))).unwrap();
    let borders = told["borders"].as_array().unwrap();
    let is_there = |at: &Value| (number(&at["value"]) - 1.361_454_882_87).abs() < 2e-11;
    assert!(borders.iter().any(is_there), "{told}");
    let unfollowed = told["unfollowed"].as_array().unwrap();
    let last = unfollowed.last().unwrap();
    close(&last["value"], 2.3, 1e-12);
    assert_eq!(last["outcome"], "left_domain");
    assert_eq!(last["cause"], "left_domain");
    assert!(
        last["message"]
            .as_str()
            .unwrap()
            .contains("leave their domain")
    );
    let count = unfollowed.len();
    let said = format!("the motion cannot be followed at {count} of these values");
    assert!(folder.succeeds("", line).contains(&said));
}

#[test]
fn figures_and_a_report_that_needs_nothing_else() {
    let folder = Folder::new("reproduce");
    let mut pages = Vec::new();
    for run in ["first", "second"] {
        let out = folder.file(run);
        let output = chatter(&["reproduce", "--figures", "2,4", "--out", &out]);
        assert_eq!(output.status.code(), Some(0));
        for name in ["fig2", "fig4"] {
            for extension in ["svg", "pdf", "png"] {
                let file = folder.path(run).join(name).with_extension(extension);
                assert!(std::fs::metadata(file).unwrap().len() > 1000);
            }
        }
        pages.push(std::fs::read_to_string(folder.path(run).join("report.html")).unwrap());
    }
    assert_eq!(pages[0], pages[1]);
    assert!(
        !pages[0].contains("http:")
            && !pages[0].contains("https:")
            && !pages[0].contains("<script")
    );
    assert!(
        pages[0].contains("Fig. 2.")
            && pages[0].contains("Fig. 4.")
            && !pages[0].contains("Fig. 3.")
    );
}

#[test]
fn near_the_border_predicted_and_simulated_orbits_span_the_same() {
    let folder = Folder::new("overlay");
    let (csv, png) = (folder.file("a.csv"), folder.file("a.png"));
    let windows = ["--windows", "40:40", "--out", &csv, "--plot", &png];
    let near = ["border", VALVE, "--parameter", "q", "--near", "0.02"];
    let output = chatter(&[&near[..], &windows].concat());
    assert_eq!(output.status.code(), Some(0));
    assert!(folder.bytes("a.png").starts_with(b"\x89PNG"));
    let text = String::from_utf8(folder.bytes("a.csv")).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("origin,q,y1,y2,y3,straightened"));
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    let span = |origin: &str| {
        let mine = rows.iter().filter(|row| row[0] == origin);
        let places = mine.map(|row| row[5].parse::<f64>().unwrap());
        places.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), y| {
            (low.min(y), high.max(y))
        })
    };
    let (ours, theirs) = (span("simulated"), span("predicted"));
    assert!(ours.0 < -1e-6 && ours.1 > 1e-7, "{ours:?}");
    for (ours, theirs) in [(ours.0, theirs.0), (ours.1, theirs.1)] {
        assert!((ours / theirs - 1.0).abs() < 0.03, "{ours} {theirs}");
    }
}

/// An offset that nothing asks for is no answer to what was meant.
#[test]
fn an_offset_is_given_where_it_is_not_swept() {
    let asked = |rest: &str| {
        let line = format!("universal --restitution 0.8 {rest}");
        let line: Vec<&str> = line.split(' ').collect();
        fails(&line)
    };
    let said = asked("--sweep mu=0:0.05:3 --mu 3");
    assert!(said.contains("--sweep sweeps it"), "{said}");
    let said = asked("--mu 3");
    assert!(said.contains("--sweep"), "{said}");
    document(&[
        "universal",
        "--restitution",
        "0.8",
        "--sweep",
        "slope=1:1.1:2",
        "--mu",
        "0.01",
        "--transient",
        "5",
        "--keep",
        "2",
        "--json",
    ]);
}
