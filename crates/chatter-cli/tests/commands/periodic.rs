//! Periodic orbits, branches and exponents, as programs read them and as users mistype them.

use crate::common::{
    Folder, begin, chatter, document, fails, interrupt, number, succeeds, told, typed, wait_for,
};
use serde_json::Value;

const VALVE: &str = "pressure_relief_valve";

/// A capacitor that a relay charges and discharges.
const FAST_RELAY: &str = "[flight]\nx = '(1 - 2*s - x)/1e-4'\ns = 0\n\
    [[event]]\nname = 'up'\nsurface = 'x - 0.5'\ndirection = 'rising'\nreset = { s = 1 }\n\
    [[event]]\nname = 'down'\nsurface = 'x + 0.5'\ndirection = 'falling'\nreset = { s = 0 }\n\
    [initial]\nx = 0\ns = 0\n";

fn close(value: &Value, expected: f64, tolerance: f64) {
    let value = number(value);
    assert!((value - expected).abs() <= tolerance, "{value} {expected}");
}

#[test]
fn an_orbit_has_its_members() {
    let told = document(&["orbit", VALVE, "--set", "q=0.0203", "--json"]);
    let orbit = &told["orbit"];
    close(&orbit["period"], 3.524_824_504_277_329, 1e-14);
    assert_eq!(
        (&orbit["impacts"], &orbit["stable"]),
        (&34.into(), &true.into())
    );
    close(&orbit["section"]["y1"], 0.027_229_278_685_215_647, 1e-15);
    close(
        &orbit["multipliers"][0]["re"],
        -0.611_967_017_203_215_5,
        1e-13,
    );
    close(&orbit["multipliers"][1]["re"], -4.763_932_297_86e-9, 1e-18);
    close(&orbit["trivial_multiplier"], 1.0, 1e-10);
    let events = orbit["events"].as_array().unwrap();
    let impacts = events.iter().filter(|event| event["kind"] == "impact");
    assert_eq!(impacts.count(), 34);
    let slowest = (orbit["margins"].as_array().unwrap().iter())
        .find(|margin| margin["kind"] == "impact_rate")
        .unwrap();
    assert_eq!(slowest["where"], "seat");
    close(&slowest["value"], 4.313_257_121_57e-6, 1e-14);
    let long = document(&[
        "orbit", VALVE, "--set", "q=0.0195", "--digits", "30", "--json",
    ]);
    assert_eq!(long["orbit"]["impacts"], Value::Null);
    let digits = long["orbit"]["period_digits"].as_str().unwrap();
    assert!(digits.starts_with("3.52665574965958417903026"), "{digits}");
}

#[test]
fn all_orbits_are_a_list() {
    let line = "orbit impact_oscillator --set omega=2.7 --all 1 --starts 30 --json";
    let told = document(&line.split(' ').collect::<Vec<_>>());
    let orbits = told["orbits"].as_array().unwrap();
    assert!(!orbits.is_empty());
    for orbit in orbits {
        close(&orbit["period"], core::f64::consts::TAU / 2.7, 1e-12);
        assert_eq!(orbit["trivial_multiplier"], Value::Null);
    }
}

#[test]
fn branches_go_to_table_and_picture_and_special_points_on() {
    let folder = Folder::new("branches");
    let line = "continue impact_oscillator --set r=0.5 --set omega=0.6081 --sweep omega=0.6078:0.609 --impacts 11 --out b.npz \
                --plot b.svg --json";
    let told: Value = serde_json::from_str(&folder.succeeds("", line)).unwrap();
    let branch = &told["branches"][0];
    let special = branch["special"].as_array().unwrap();
    let place = special.iter().position(|s| s["kind"] == "fold").unwrap();
    close(&special[place]["value"], 0.608_257_537_739_327_9, 1e-13);
    let count = branch["points"]["omega"].as_array().unwrap().len();
    for column in [
        "period",
        "impacts",
        "stable",
        "neutral",
        "multipliers",
        "x",
        "v",
    ] {
        assert_eq!(
            branch["points"][column].as_array().unwrap().len(),
            count,
            "{column}"
        );
    }
    assert!(
        String::from_utf8(folder.bytes("b.svg"))
            .unwrap()
            .contains("fold")
    );
    let line = format!(
        "continue impact_oscillator --set r=0.5 --from b.npz:{} --free omega,r --sweep r=0.495:0.505 --json",
        place + 1
    );
    let curve: Value = serde_json::from_str(&folder.succeeds("", &line)).unwrap();
    assert_eq!(curve["branches"][0]["kind"], "fold");
    // All of a kind at once, in the same digits.
    let line = "continue impact_oscillator --set r=0.5 --from b.npz:fold --free omega,r --sweep r=0.495:0.505 --json";
    let curves: Value = serde_json::from_str(&folder.succeeds("", line)).unwrap();
    let folds = special.iter().filter(|s| s["kind"] == "fold").count();
    assert_eq!(curves["branches"].as_array().unwrap().len(), folds);
    assert_eq!(curves["branches"][0], curve["branches"][0]);
    // What was set where the table was written is taken over.
    let line =
        "continue impact_oscillator --from b.npz:fold --free omega,r --sweep r=0.495:0.505 --json";
    let taken: Value = serde_json::from_str(&folder.succeeds("", line)).unwrap();
    assert_eq!(taken["branches"], curves["branches"]);
    folder.write(
        "other.toml",
        "[parameters]\nomega = 2\nr = 0.8\n[flight]\nx = 'v'\nv = 'sin(omega*t) - x'\n[[contact]]\nname = 'wall'\ngap = 'x'\n\
         impulse = { v = 1 }\nrestitution = 'r'\n[initial]\nx = 1\nv = 0\n",
    );
    for (line, expected) in [
        (
            "continue impact_oscillator --set r=0.6 --from b.npz:fold --free omega,sigma --sweep sigma=-1:1",
            "the points in `b.npz` are at r = 0.5, and not at 0.6",
        ),
        (
            "continue other.toml --from b.npz:fold --free omega,r --sweep r=0.4:0.6",
            "`b.npz` is of another model: there ",
        ),
        (
            "continue impact_oscillator --from b.npz:cusp --free omega,r --sweep r=0.4:0.6",
            "is of the kind cusp",
        ),
        (
            "continue impact_oscillator --from b.npz:fould --free omega,r --sweep r=0.4:0.6",
            "did you mean `fold`",
        ),
        (
            "continue impact_oscillator --from b.npz:1 --free omega,r --sweep r=0.4:0.6 --switch period-doubling",
            "cannot be used with",
        ),
        (
            "continue impact_oscillator --from b.npz:99 --free omega,r --sweep r=0.4:0.6",
            "and no 99",
        ),
        (
            "continue impact_oscillator --from b.npz:1 --free omega,sigma --sweep r=0.4:0.6",
            "--free omega,sigma",
        ),
        (
            "continue impact_oscillator --from no.npz:1 --free omega,r --sweep r=0.4:0.6",
            "no.npz",
        ),
    ] {
        let said = folder.fails("", line);
        assert!(said.contains(expected), "{line}: {said}");
    }
}

#[test]
fn branches_are_watched_and_drawn_over_a_diagram() {
    let folder = Folder::new("over");
    let text = "[parameters]\nw = 1.3\nc = 0.4\n[flight]\nx = 'v'\nv = '-x - c*v + cos(w*t)'\n[section.top]\n\
                surface = 'v'\ndirection = 'falling'\n[initial]\nx = 0\nv = 0\n";
    folder.write("m.toml", text);
    folder.succeeds(
        "",
        "diagram m.toml --sweep w=1.1:1.5:6 --observe x --transient 60 --keep 4 --out d.npz",
    );
    let line = "continue m.toml --sweep w=1.1:1.5 --step 0.1 --monitor x-1 --plot b.svg --over d.npz --out b.npz --json";
    let told: Value = serde_json::from_str(&folder.succeeds("", line)).unwrap();
    let special = &told["branches"][0]["special"][0];
    assert_eq!(
        (&special["kind"], &special["monitor"]),
        (&"monitor".into(), &"x-1".into())
    );
    let w = number(&special["value"]);
    close(
        &((1.0 - w * w).powi(2) + (0.4 * w).powi(2)).into(),
        1.0,
        1e-12,
    );
    // The legend tells what lies below, too.
    let drawn = String::from_utf8(folder.bytes("b.svg")).unwrap();
    for name in ["orbit diagram", "stable", "monitor"] {
        assert!(drawn.contains(name), "{name}");
    }
    // Several are told by their names, one that is a state, or is given twice, too.
    let line = "continue m.toml --sweep w=1.1:1.5 --step 0.1 --monitor x-1 --monitor x-1.2 --monitor x --monitor x-1 --out c.npz";
    let told = folder.succeeds("", line);
    for name in ["monitor x-1  ", "monitor x-1.2  "] {
        assert_eq!(told.matches(name).count(), 1, "{told}");
    }
    // Its zeros in two parameters.
    let line = "continue m.toml --from b.npz:1 --free w,c --sweep c=0.3:0.5 --step 0.1 --plot c.svg --json";
    let curve: Value = serde_json::from_str(&folder.succeeds("", line)).unwrap();
    let points = &curve["branches"][0]["points"];
    for (w, c) in points["w"]
        .as_array()
        .unwrap()
        .iter()
        .zip(points["c"].as_array().unwrap())
    {
        let (w, c) = (number(w), number(c));
        close(
            &((1.0 - w * w).powi(2) + (c * w).powi(2)).into(),
            1.0,
            1e-12,
        );
    }
    for (line, expected) in [
        (
            "continue m.toml --sweep c=0.3:0.5 --plot e.svg --over d.npz",
            "diagram over w",
        ),
        (
            "continue m.toml --sweep w=1.1:1.5 --plot e.svg --over d.npz --observe v",
            "shows `x`",
        ),
        (
            "continue m.toml --sweep w=1.1:1.5 --monitor 2-1",
            "is a constant",
        ),
        (
            "continue m.toml --sweep w=1.1:1.5 --monitor xx-1",
            "unknown name `xx`",
        ),
    ] {
        let said = folder.fails("", line);
        assert!(said.contains(expected), "{line}: {said}");
    }
}

#[test]
fn exponents_sum_to_what_volumes_shrink_by() {
    let line = "exponents impact_oscillator --set omega=2.8 --set zeta=0.05 --set r=1 --intervals 300 --json";
    let told = document(&line.split(' ').collect::<Vec<_>>());
    let sum: f64 = told["exponents"]
        .as_array()
        .unwrap()
        .iter()
        .map(number)
        .sum();
    assert!((sum + 0.1).abs() < 1e-8, "{sum}");
    assert!(succeeds(&["exponents", VALVE, "--intervals", "20"]).contains("dimension"));
    // What takes a tenth of a millisecond, in seconds: its own time is zero's, to its rate of 1e4.
    let folder = Folder::new("fast");
    let file = folder.file("relay.toml");
    std::fs::write(&file, FAST_RELAY).unwrap();
    let told = document(&["exponents", &file, "--json"]);
    assert_eq!(told["interval"], 1e-3);
    assert!(number(&told["exponents"][0]).abs() < 30.0);
}

#[test]
fn wrong_questions_are_told_what_is_wrong() {
    for (line, expected) in [
        (
            "orbit pressure_relief_valve --period 2",
            "do not depend on time",
        ),
        ("orbit impact_oscillator --period 3", "repeat after 20.94"),
        ("orbit impact_oscillator --period x", "depends on the state"),
        (
            "orbit pressure_relief_valve --section closng",
            "did you mean `closing`?",
        ),
        (
            "orbit impact_oscillator --set r=2",
            "restitution 2, outside",
        ),
        ("orbit bouncing_ball --section top", "no section `top`"),
        ("orbit impact_oscillator --all 1000", "from 1 to 64"),
        (
            "continue pressure_relief_valve --sweep kapa=1:2",
            "did you mean `kappa`?",
        ),
        (
            "continue pressure_relief_valve --sweep y1=1:2",
            "is a state",
        ),
        (
            "continue pressure_relief_valve --sweep q=0.02",
            "expected NAME=LOW:HIGH",
        ),
        (
            "continue pressure_relief_valve --sweep q=0.02:0.02",
            "expected a range of some length",
        ),
        (
            "continue pressure_relief_valve --sweep q=0.02:0.021 --step 2",
            "at most 1",
        ),
        (
            "continue pressure_relief_valve --sweep q=0.02:0.021 --from b.npz:1",
            "--free",
        ),
        ("exponents pressure_relief_valve --interval 0", "positive"),
        ("exponents pressure_relief_valve --intervals 0", "intervals"),
    ] {
        let said = fails(&line.split(' ').collect::<Vec<_>>());
        assert!(said.contains(expected), "{line}: {said}");
    }
    // An answer of its own kind: there is no orbit.
    let output = chatter(&["orbit", "bouncing_ball"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("comes to rest"));
}

#[test]
fn branches_go_on_to_the_same_file() {
    let folder = Folder::new("resumed_branches");
    let (whole, stopped) = (folder.file("whole.npz"), folder.file("stopped.npz"));
    let line = "continue pressure_relief_valve --set q=0.0203 --sweep q=0.0202:0.0204 --impacts 37 --step 0.004 --out";
    let (long, short) = (typed(line, &[&whole]), typed(line, &[&stopped]));
    succeeds(&long);
    let journal = format!("{stopped}.journal");
    let mut child = begin(&short);
    wait_for(&journal, 40_000);
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(!std::fs::exists(&stopped).unwrap());
    let known = std::fs::metadata(&journal).unwrap().len();
    let child = begin(&["continue", "--resume", &stopped]);
    wait_for(&journal, known + 40_000);
    let said = told(&interrupt(child), 130, &stopped);
    assert!(
        said.contains("go on with: chatter continue --resume"),
        "{said}"
    );
    // Other branches do not go there.
    let mut other = short.clone();
    other.extend(["--set", "kappa=1.26"]);
    assert!(fails(&other).contains("unfinished branches with other parameters"));
    assert!(
        fails(&["diagram", "--resume", &stopped]).contains("not a journal of an orbit diagram")
    );
    succeeds(&["continue", "--resume", &stopped]);
    assert!(folder.bytes("whole.npz") == folder.bytes("stopped.npz"));
    assert_eq!(folder.names(), ["stopped.npz", "whole.npz"]);
    assert!(succeeds(&["continue", "--resume", &stopped]).contains("nothing to resume"));
    let missing = fails(&["continue", "--resume", &folder.file("other.npz")]);
    assert!(missing.contains("there is nothing to resume"), "{missing}");
}

#[test]
fn curves_in_two_parameters_go_on_to_the_same_file() {
    let folder = Folder::new("resumed_curves");
    let branch = folder.file("branch.npz");
    let sweep = "continue impact_oscillator --set sigma=0 --sweep omega=2.6:2.8 --out";
    succeeds(&typed(sweep, &[&branch]));
    let (whole, stopped) = (folder.file("whole.npz"), folder.file("stopped.npz"));
    let point = format!("{branch}:2");
    let line = "continue impact_oscillator --set sigma=0 --free omega,r --sweep r=0.4:0.9 --step 0.001 --from";
    succeeds(&typed(line, &[&point, "--out", &whole]));
    let journal = format!("{stopped}.journal");
    let mut child = begin(&typed(line, &[&point, "--out", &stopped]));
    wait_for(&journal, 60_000);
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(!std::fs::exists(&stopped).unwrap());
    succeeds(&["continue", "--resume", &stopped]);
    assert!(folder.bytes("whole.npz") == folder.bytes("stopped.npz"));
    assert_eq!(folder.names(), ["branch.npz", "stopped.npz", "whole.npz"]);
}

/// Without damping multipliers are exp(+-2 pi i/w): orbits are neither stable nor unstable, and every reader of a branch is told so.
#[test]
fn neutral_orbits_of_a_branch_are_told_as_such() {
    let folder = Folder::new("neutral");
    let text = "[parameters]\nw = 1.637\nc = 0\n[flight]\nx = 'v'\nv = '-x - c*v + cos(w*t)'\n[initial]\nx = 0\nv = 0\n";
    std::fs::write(folder.file("free.toml"), text).unwrap();
    for (damping, [stable, neutral], label) in [
        ("0", [false, true], "neutral"),
        ("0.1", [true, false], "stable"),
        ("-0.1", [false, false], "unstable"),
    ] {
        let line = format!(
            "continue free.toml --set c={damping} --sweep w=1.6:1.7 --all 1 --starts 3 --step 0.1 --out b.csv --plot b.svg --json"
        );
        let told: Value = serde_json::from_str(&folder.succeeds("", &line)).unwrap();
        let points = &told["branches"][0]["points"];
        for (name, expected) in [("stable", stable), ("neutral", neutral)] {
            let column = points[name].as_array().unwrap();
            assert!(column.len() > 5);
            assert!(
                column.iter().all(|told| *told == expected),
                "{name} {damping}"
            );
        }
        let table = String::from_utf8(folder.bytes("b.points.csv")).unwrap();
        let rows: Vec<Vec<&str>> = table
            .lines()
            .map(|line| line.split(',').collect())
            .collect();
        let column = |name: &str| rows[0].iter().position(|head| *head == name).unwrap();
        for row in &rows[1..] {
            assert_eq!(row[column("stable")], i64::from(stable).to_string());
            assert_eq!(row[column("neutral")], i64::from(neutral).to_string());
        }
        let drawn = String::from_utf8(folder.bytes("b.svg")).unwrap();
        assert!(drawn.contains(&format!(">{label}<")), "{label}");
    }
}

/// Where no orbit is found at the model's own value branches begin elsewhere, and it is said why and where.
#[test]
fn branches_that_begin_elsewhere_say_so() {
    let folder = Folder::new("elsewhere");
    let model = folder.file("grows.toml");
    let text = "[parameters]\nc = -0.5\n[flight]\nx = 'v'\nv = '-x - c*v + cos(1.3*t)'\n[initial]\nx = 1\nv = 0\n";
    std::fs::write(&model, text).unwrap();
    let said = told(
        &chatter(&["continue", &model, "--sweep", "c=-1:3"]),
        0,
        "continue",
    );
    assert!(
        said.contains("no orbit to begin with was found at c = -0.5: "),
        "{said}"
    );
    assert!(said.contains("; the branches begin at c = 1"), "{said}");
    let said = told(
        &chatter(&["continue", &model, "--set", "c=0.5", "--sweep", "c=0.1:3"]),
        0,
        "continue",
    );
    assert!(!said.contains("begin"), "{said}");
}
