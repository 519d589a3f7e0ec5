//! The server as others meet it: requests that are not the page's, too large, too slow or garbage.

use chatter::analysis::diagram::Threads;
use chatter_explorer::{Context, Explorer, Kind, Limits};
use core::time::Duration;
use proptest::prelude::*;
use serde_json::{Value, json};
use std::io::{Read, Write};
use std::net::{Shutdown, TcpStream};
use std::sync::OnceLock;
use std::time::Instant;

const BALL: &str = "[flight]\ny = \"v\"\nv = -1\n[[contact]]\nname = \"floor\"\ngap = \"y\"\nimpulse = { v = 1 }\nrestitution = \"r\"\n\
     [parameters]\nr = 0.5\n[section.apex]\nsurface = \"v\"\ndirection = \"falling\"\n[initial]\ny = 1\nv = 0\n";

fn context() -> Context {
    Context {
        model: ("ball".to_owned(), BALL.to_owned()),
        files: Default::default(),
        threads: Threads::new(1),
    }
}

/// Where the page is: one server for all tests.
fn address() -> &'static str {
    static ADDRESS: OnceLock<String> = OnceLock::new();
    ADDRESS.get_or_init(|| {
        let limits = Limits {
            request: Duration::from_secs(3),
            ..Limits::default()
        };
        begin(limits)
    })
}

fn begin(limits: Limits) -> String {
    let explorer = Explorer::bind(0, context(), limits).unwrap();
    let address = explorer.address();
    std::thread::spawn(move || explorer.serve());
    address
}

/// Host and path of an address.
fn parts(address: &str) -> (&str, &str) {
    let rest = address.strip_prefix("http://").unwrap();
    rest.split_at(rest.find('/').unwrap())
}

fn sent_to(host: &str, bytes: &[u8]) -> Vec<u8> {
    exchange(host, bytes, false)
}

/// As bytes after which nothing comes.
fn broken_off(bytes: &[u8]) -> Vec<u8> {
    exchange(parts(address()).0, bytes, true)
}

fn exchange(host: &str, bytes: &[u8], breaks_off: bool) -> Vec<u8> {
    let mut stream = TcpStream::connect(host).unwrap();
    stream
        .set_read_timeout(Some(Duration::from_secs(60)))
        .unwrap();
    // It may have been hung up on already.
    drop(stream.write_all(bytes));
    if breaks_off {
        drop(stream.shutdown(Shutdown::Write));
    }
    let mut reply = Vec::new();
    drop(stream.read_to_end(&mut reply));
    reply
}

fn sent(bytes: &[u8]) -> Vec<u8> {
    sent_to(parts(address()).0, bytes)
}

fn status(reply: &[u8]) -> Option<u16> {
    let text = String::from_utf8_lossy(reply);
    text.split(' ').nth(1)?.parse().ok()
}

fn body(reply: &[u8]) -> &[u8] {
    let end = reply
        .windows(4)
        .position(|four| four == b"\r\n\r\n")
        .unwrap();
    &reply[end + 4..]
}

/// A request of the page, but for these headers, which replace its own or come to them.
fn request(method: &str, path: &str, other: &[(&str, Option<&str>)], content: &str) -> Vec<u8> {
    let (host, _) = parts(address());
    let origin = format!("http://{host}");
    let length = content.len().to_string();
    let mut headers = vec![
        ("Host", host),
        ("Origin", &*origin),
        ("Sec-Fetch-Site", "same-origin"),
    ];
    if method == "POST" {
        headers.extend([
            ("Content-Type", "application/json"),
            ("Content-Length", &*length),
        ]);
    }
    for &(name, value) in other {
        headers.retain(|(known, _)| *known != name);
        headers.extend(value.map(|value| (name, value)));
    }
    let lines: String = headers
        .iter()
        .map(|(name, value)| format!("{name}: {value}\r\n"))
        .collect();
    format!("{method} {path} HTTP/1.1\r\n{lines}\r\n{content}").into_bytes()
}

fn page(path: &str) -> String {
    format!("{}{path}", parts(address()).1)
}

/// What the page gets for a question: records of a kind and their content.
fn records(reply: &[u8]) -> Vec<(u32, Vec<u8>)> {
    let mut rest = body(reply);
    let mut records = Vec::new();
    while let Some((head, tail)) = rest.split_first_chunk::<8>() {
        let length = u32::from_le_bytes(head[..4].try_into().unwrap()) as usize;
        let kind = u32::from_le_bytes(head[4..].try_into().unwrap());
        records.push((kind, tail[..length].to_vec()));
        rest = &tail[length..];
    }
    assert!(rest.is_empty());
    records
}

fn asked(topic: &str, question: &Value) -> Vec<(u32, Vec<u8>)> {
    let reply = sent(&request("POST", &page(topic), &[], &question.to_string()));
    assert_eq!(status(&reply), Some(200));
    // How far it is comes as time says.
    let told = records(&reply).into_iter();
    told.filter(|(kind, _)| *kind != Kind::Progress as u32)
        .collect()
}

fn model() -> Value {
    json!({ "name": "ball", "text": BALL })
}

#[test]
fn the_page_is_served_with_its_policy() {
    for (path, kind) in [
        ("", "text/html"),
        ("main.js", "text/javascript"),
        ("style.css", "text/css"),
    ] {
        let reply = sent(&request(
            "GET",
            &page(path),
            &[("Sec-Fetch-Site", Some("none")), ("Origin", None)],
            "",
        ));
        assert_eq!(status(&reply), Some(200), "{path}");
        let text = String::from_utf8(reply).unwrap();
        assert!(text.contains(&format!("Content-Type: {kind}")));
        assert!(text.contains("Content-Security-Policy: default-src 'none'; script-src 'self'"));
        assert!(text.contains("X-Content-Type-Options: nosniff"));
    }
}

/// Every module that another one names is there, and nothing comes from elsewhere.
#[test]
fn the_page_is_complete() {
    for asset in chatter_explorer::PAGE {
        for line in asset
            .text
            .lines()
            .filter(|line| line.starts_with("import ") || line.starts_with("} from "))
        {
            let name = beside(asset.path, line.rsplit('"').nth(1).unwrap());
            assert!(
                chatter_explorer::PAGE
                    .iter()
                    .any(|other| other.path == name),
                "{name} of {}",
                asset.path
            );
        }
        let foreign = |text: &str| text.contains("https://") || text.contains("//cdn");
        assert!(!foreign(asset.text), "{}", asset.path);
    }
}

/// The path of what a module names as beside it.
fn beside(module: &str, named: &str) -> String {
    let mut parts: Vec<&str> = module.split('/').collect();
    parts.pop();
    for part in named.split('/') {
        match part {
            "." => {}
            ".." => drop(parts.pop()),
            part => parts.push(part),
        }
    }
    parts.join("/")
}

/// A notebook's widget loads each module after those that it names.
#[test]
fn no_module_needs_itself() {
    fn visit(name: &str, above: &mut Vec<String>) {
        assert!(
            !above.iter().any(|known| known == name),
            "{above:?} needs {name}"
        );
        above.push(name.to_owned());
        let asset = chatter_explorer::PAGE
            .iter()
            .find(|asset| asset.path == name)
            .unwrap();
        for line in asset
            .text
            .lines()
            .filter(|line| line.starts_with("import "))
        {
            visit(&beside(name, line.rsplit('"').nth(1).unwrap()), above);
        }
        above.pop();
    }
    visit("widget.js", &mut Vec::new());
    visit("main.js", &mut Vec::new());
}

#[test]
fn who_is_not_the_page_gets_nothing() {
    let question = json!({ "model": model() }).to_string();
    let post = |path: &str, other: &[(&str, Option<&str>)]| {
        status(&sent(&request("POST", path, other, &question)))
    };
    assert_eq!(post(&page("check"), &[]), Some(200));
    // Programs say nothing of where they come from.
    assert_eq!(
        post(
            &page("check"),
            &[("Origin", None), ("Sec-Fetch-Site", None)]
        ),
        Some(200)
    );
    for host in [
        "evil.example",
        "127.0.0.1",
        "localhost:1",
        "127.0.0.1:80.evil.example",
        "",
    ] {
        assert_eq!(
            post(&page("check"), &[("Host", Some(host)), ("Origin", None)]),
            Some(421),
            "{host}"
        );
    }
    assert_eq!(post(&page("check"), &[("Host", None)]), Some(421));
    for origin in [
        "http://evil.example",
        "null",
        "https://127.0.0.1",
        "http://127.0.0.1:1",
    ] {
        assert_eq!(
            post(&page("check"), &[("Origin", Some(origin))]),
            Some(403),
            "{origin}"
        );
    }
    for site in ["cross-site", "same-site", "none", "", "x"] {
        assert_eq!(
            post(&page("check"), &[("Sec-Fetch-Site", Some(site))]),
            Some(403),
            "{site}"
        );
    }
    for kind in [
        None,
        Some("text/plain"),
        Some("application/x-www-form-urlencoded"),
    ] {
        assert_eq!(
            post(&page("check"), &[("Content-Type", kind)]),
            Some(415),
            "{kind:?}"
        );
    }
    let token = page("").trim_matches('/').to_owned();
    for wrong in [
        "",
        "/",
        "/check",
        &*format!("/{}/check", "0".repeat(32)),
        &*format!("/{}/check", &token[..31]),
        &*format!("/{token}0/check"),
    ] {
        let status = post(wrong, &[]);
        assert!(matches!(status, Some(400 | 404)), "{wrong}: {status:?}");
    }
    let reply = sent(&request(
        "GET",
        &page(""),
        &[("Sec-Fetch-Site", Some("cross-site"))],
        "",
    ));
    assert_eq!(status(&reply), Some(403));
}

#[test]
fn what_is_not_there_is_told() {
    for (method, path) in [
        ("GET", "x.js"),
        ("GET", "../Cargo.toml"),
        ("POST", "nothing"),
        ("POST", "check.svg"),
        ("POST", "diagram.exe"),
    ] {
        let reply = sent(&request(method, &page(path), &[], "{}"));
        assert_eq!(status(&reply), Some(404), "{path}");
        let error: Value = serde_json::from_slice(body(&reply)).unwrap();
        assert_eq!(error["kind"], "request");
    }
    let reply = sent(&request("PUT", &page("check"), &[], ""));
    assert_eq!(status(&reply), Some(405));
}

#[test]
fn what_is_too_large_is_refused() {
    let large = "x".repeat(chatter_explorer::MOST_BODY + 1);
    assert_eq!(
        status(&sent(&request("POST", &page("check"), &[], &large))),
        Some(413)
    );
    let long = format!(
        "GET /{} HTTP/1.1\r\n\r\n",
        "a".repeat(chatter_explorer::MOST_HEAD)
    );
    assert_eq!(status(&sent(long.as_bytes())), Some(431));
    let many =
        json!({ "model": model(), "runs": vec![vec!["r=0.1:0.9:2"]; 1000], "observe": ["y"] });
    let told = asked("diagram", &many);
    assert!(message(&told).contains("sweeps at most"));
    let wide = json!({ "model": model(), "runs": [["r=0.1:0.9:4000000"]], "observe": ["y"] });
    assert!(message(&asked("diagram", &wide)).contains("too much for a page"));
}

#[test]
fn wrong_questions_about_theory_are_refused() {
    let curve = |kind: &str, state: &[f64], parameters: [&str; 2]| json!({ "model": model(), "parameters": parameters, "from": 0.1, "to": 0.9, "kind": kind, "state": state, "orbit_period": 1.0 });
    for (question, told) in [
        (curve("fold", &[1.0], ["r", "r"]), "named twice"),
        (curve("fold", &[1.0, 0.0], ["r", "q"]), "no parameter `q`"),
        (curve("nothing", &[1.0, 0.0], ["r", "r"]), "named twice"),
    ] {
        let message = message(&asked("curve", &question));
        assert!(message.contains(told), "{message}");
    }
    let universal = |restitution: f64, slope: f64| json!({ "restitution": restitution, "slope": slope, "mu": 0.01 });
    for (restitution, slope) in [(1.0, 1.0), (-0.5, 1.0), (0.8, 0.0)] {
        assert!(!message(&asked("universal", &universal(restitution, slope))).is_empty());
    }
    let border = json!({ "model": model(), "parameter": "r", "from": 0.1, "to": 0.9 });
    assert!(message(&asked("border.svg", &border)).contains("one border"));
    let axes = |axes: &str| json!({ "model": model(), "until": "1", "axes": [axes] });
    for (panel, told) in [
        ("t", "two names"),
        ("t,z", "cannot be drawn"),
        ("y,next:nowhere", "`apex`"),
        ("v,rate_before", "cannot be drawn"),
        ("drawing", "no drawing"),
    ] {
        let message = message(&asked("history.svg", &axes(panel)));
        assert!(message.contains(told), "{panel}: {message}");
    }
}

#[test]
fn attractors_are_told_apart_once_a_sweep_is_done() {
    // A ball in one of two wells, from which its damping does not let it out.
    let text = "[flight]\nx = \"v\"\nv = \"a*x - x^3 - v\"\n[parameters]\na = 1\n[section.turn]\nsurface = \"v\"\n\
                direction = \"either\"\n[initial]\nx = 0.5\nv = 0\n";
    let question = json!({
        "model": { "name": "wells", "text": text }, "runs": [["a=1:1.2:2"]], "observe": ["x"], "period": "1", "transient": 60,
        "keep": "8", "start": "random:8", "bounds": ["x=-1:1"],
    });
    let told = asked("diagram", &question);
    let documents: Vec<Value> = told
        .iter()
        .filter(|(kind, _)| *kind == Kind::Document as u32)
        .map(|(_, content)| serde_json::from_slice(content).unwrap())
        .collect();
    let shares = documents.last().unwrap()["attractors"].as_array().unwrap();
    let rows: u64 = shares.iter().map(|one| one["rows"].as_u64().unwrap()).sum();
    assert_eq!((shares.len(), rows), (2, 16), "{shares:?}");
    let numbers = |wanted: Kind| -> Vec<Vec<f64>> {
        let of_kind = told.iter().filter(|(kind, _)| *kind == wanted as u32);
        let read = |content: &Vec<u8>| {
            let eights = content.chunks_exact(8);
            eights
                .map(|eight| f64::from_le_bytes(eight.try_into().unwrap()))
                .collect()
        };
        of_kind.map(|(_, content)| read(content)).collect()
    };
    // Sweep, pass and value say which row; the well is where its sample lies.
    let ends = numbers(Kind::Row);
    let mut wells = Vec::new();
    for one in numbers(Kind::Numbers)[0].chunks_exact(5) {
        let row = ends.iter().find(|row| row[..3] == one[..3]).unwrap();
        wells.push((one[4], row[8] > 0.0));
    }
    assert_eq!(wells.len(), 16);
    for (number, right) in &wells {
        assert!(
            wells
                .iter()
                .all(|(other, well)| (other == number) == (well == right))
        );
    }
}

/// What a refusal says.
fn message(records: &[(u32, Vec<u8>)]) -> String {
    let refusal = records
        .iter()
        .find(|(kind, _)| *kind == Kind::Refusal as u32);
    let (_, content) = refusal.expect("a refusal");
    let refusal: Value = serde_json::from_slice(content).unwrap();
    assert_eq!(records.last().unwrap().0, Kind::End as u32);
    refusal["message"].as_str().unwrap().to_owned()
}

#[test]
fn who_says_nothing_for_long_is_hung_up_on() {
    let address = begin(Limits {
        request: Duration::from_millis(200),
        ..Limits::default()
    });
    let mut stream = TcpStream::connect(parts(&address).0).unwrap();
    stream.write_all(b"POST / HTTP/1.1\r\n").unwrap();
    let mut reply = Vec::new();
    stream.read_to_end(&mut reply).unwrap();
    assert_eq!(status(&reply), Some(408));
}

#[test]
fn there_is_room_for_so_many_at_one_time() {
    let address = begin(Limits {
        connections: 2,
        ..Limits::default()
    });
    let (host, path) = parts(&address);
    let idle: Vec<TcpStream> = (0..2).map(|_| TcpStream::connect(host).unwrap()).collect();
    let ask = || {
        let text = format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n");
        status(&sent_to(host, text.as_bytes()))
    };
    let waited = |wanted: Option<u16>| {
        let end = Instant::now() + Duration::from_secs(30);
        while ask() != wanted {
            assert!(Instant::now() < end, "waited for {wanted:?}");
        }
    };
    waited(Some(503));
    drop(idle);
    waited(Some(200));
}

#[test]
fn models_name_no_files() {
    let text = format!("{BALL}[table.lift]\nfile = \"/etc/passwd\"\n");
    let told = asked(
        "check",
        &json!({ "model": { "name": "ball", "text": text } }),
    );
    let (kind, content) = &told[0];
    assert_eq!(*kind, Kind::Refusal as u32);
    let text = String::from_utf8(content.clone()).unwrap();
    assert!(!text.contains("root:"));
    assert!(text.contains("was not kept"), "{text}");
}

#[test]
fn errors_of_a_model_have_their_place() {
    let text = BALL.replace("\"v\"\nv", "\"vv\"\nv");
    let told = asked(
        "check",
        &json!({ "model": { "name": "ball", "text": text } }),
    );
    let refusal: Value = serde_json::from_slice(&told[0].1).unwrap();
    let error = &refusal["errors"][0];
    assert_eq!((&error["line"], &error["column"]), (&json!(2), &json!(6)));
    assert_eq!((&error["from"], &error["to"]), (&json!(14), &json!(16)));
    assert!(error["message"].as_str().unwrap().contains("vv"));
}

#[test]
fn rows_come_as_numbers_and_end() {
    let question = json!({ "model": model(), "runs": [["r=0.4:0.6:3"]], "observe": ["y"], "transient": 0, "keep": "4" });
    let told = asked("diagram", &question);
    let rows: Vec<&Vec<u8>> = told
        .iter()
        .filter(|(kind, _)| *kind == Kind::Row as u32)
        .map(|(_, row)| row)
        .collect();
    assert_eq!(rows.len(), 3);
    let mut values: Vec<f64> = (rows.iter())
        .map(|row| f64::from_le_bytes(row[16..24].try_into().unwrap()))
        .collect();
    values.sort_by(f64::total_cmp);
    assert_eq!(values, [0.4, 0.5, 0.6]);
    assert_eq!(told.last().unwrap().0, Kind::End as u32);
}

/// A ball that falls from a height rises to r^2 of it: what is on that line comes with the points, as numbers and as files.
#[test]
fn a_return_map_of_one_dimension_comes_with_its_curve() {
    let question =
        |axes: &str| json!({ "model": model(), "until": "9", "axes": [axes], "sample": "events" });
    let told = asked("returns", &question("y,next:apex"));
    let sampled: Value = serde_json::from_slice(&told[0].1).unwrap();
    assert_eq!(
        (&sampled["held"], &sampled["level"]),
        (&json!("v"), &json!(0.0))
    );
    let column = |place: usize| {
        let (kind, bytes): &(u32, Vec<u8>) = &told[place];
        assert_eq!(*kind, Kind::Numbers as u32);
        let numbers = bytes.chunks_exact(8);
        numbers
            .map(|bytes| f64::from_le_bytes(bytes.try_into().unwrap()))
            .collect::<Vec<f64>>()
    };
    let (heights, next) = (column(1), column(2));
    assert_eq!((heights.len(), next.len()), (400, 400));
    for (height, next) in heights
        .iter()
        .zip(next)
        .filter(|(height, _)| **height > 0.0)
    {
        assert!((next - 0.25 * height).abs() < 1e-13, "{height}: {next}");
    }
    // The velocity is what the section holds, and nothing of two states has a curve.
    let told = asked("returns", &question("v,next:apex"));
    assert_eq!(told[0].1, b"null");
    let files = |asked_for: &str| -> Vec<String> {
        let told = asked(asked_for, &question("y,next:apex")).into_iter();
        told.filter(|(kind, _)| *kind == Kind::File as u32)
            .map(|(_, content)| {
                let length = u32::from_le_bytes(content[..4].try_into().unwrap()) as usize;
                String::from_utf8(content[4..4 + length].to_vec()).unwrap()
            })
            .collect()
    };
    assert_eq!(files("returns.svg"), ["ball-returns.svg"]);
    assert_eq!(
        files("returns.npz"),
        ["ball-returns.npz", "ball-returns-curve.npz"]
    );
}

/// Every shape of every shipped model is somewhere at all times.
#[test]
fn drawings_of_shipped_models_have_values() {
    let mut drawn = 0;
    for shipped in chatter_work::shipped::all() {
        let model = json!({ "name": shipped.name, "text": shipped.text });
        let told = asked("history", &json!({ "model": model, "until": "2" }));
        let about: Value = serde_json::from_slice(&told[0].1).unwrap();
        let shapes = about["drawn"].as_array().unwrap().len();
        let count: u64 = about["drawn"]
            .as_array()
            .unwrap()
            .iter()
            .map(|count| count.as_u64().unwrap())
            .sum();
        drawn += usize::from(shapes > 0);
        let columns: Vec<&Vec<u8>> = told
            .iter()
            .filter(|(kind, _)| *kind == Kind::Numbers as u32)
            .map(|(_, column)| column)
            .collect();
        assert!(!columns[0].is_empty(), "{}", shipped.name);
        for column in &columns[columns.len() - count as usize..] {
            assert_eq!(column.len(), columns[0].len());
            let mut values = column
                .chunks_exact(8)
                .map(|bytes| f64::from_le_bytes(bytes.try_into().unwrap()));
            assert!(values.all(f64::is_finite), "{}", shipped.name);
        }
    }
    assert!(drawn >= 18);
}

/// Hanging up ends work that would go on for long.
#[test]
fn hanging_up_stops_the_work() {
    let address = begin(Limits::default());
    let (host, path) = parts(&address);
    // Without end: the ball is kept in the air.
    let text = "[flight]\ny = \"v\"\nv = \"-y + cos(1.4*t)\"\n[section.turn]\nsurface = \"v\"\ndirection = \"falling\"\n\
         [parameters]\nq = 1\n[initial]\ny = 1\nv = 0\n";
    let question = json!({ "model": { "name": "m", "text": text }, "runs": [["q=1:2:1000"]], "observe": ["y"], "transient": 10_000_000, "keep": "1" });
    let content = question.to_string();
    let request = format!(
        "POST {path}diagram HTTP/1.1\r\nHost: {host}\r\nContent-Type: application/json\r\nContent-Length: {}\r\n\r\n{content}",
        content.len()
    );
    let mut stream = TcpStream::connect(host).unwrap();
    stream.write_all(request.as_bytes()).unwrap();
    let working = || {
        let reply = sent_to(
            host,
            format!("GET {path}work HTTP/1.1\r\nHost: {host}\r\n\r\n").as_bytes(),
        );
        let told: Value = serde_json::from_slice(body(&reply)).unwrap();
        told["questions"].as_u64().unwrap()
    };
    let waited = |wanted: u64| {
        let end = Instant::now() + Duration::from_secs(60);
        while Instant::now() < end && working() != wanted {
            std::thread::sleep(Duration::from_millis(10));
        }
        assert_eq!(working(), wanted);
    };
    waited(1);
    // It does not end by itself.
    std::thread::sleep(Duration::from_millis(300));
    assert_eq!(working(), 1);
    drop(stream);
    waited(0);
}

fn any_json() -> impl Strategy<Value = Value> {
    let leaf = prop_oneof![
        Just(Value::Null),
        any::<bool>().prop_map(Value::from),
        any::<i64>().prop_map(Value::from),
        any::<f64>().prop_map(Value::from),
        "[ -~]{0,12}".prop_map(Value::from),
        prop::sample::select(vec![
            "r=0.1:0.9:3",
            "r",
            "y",
            "0:1",
            "initial:y=0:1:2",
            "carry",
            "1e999",
            "-1",
            "r=1:0:2:log"
        ])
        .prop_map(Value::from),
    ];
    leaf.prop_recursive(3, 24, 4, |inner| {
        let names = prop::sample::select(vec![
            "model", "runs", "observe", "keep", "until", "window", "name", "text", "set",
        ]);
        prop_oneof![
            prop::collection::vec(inner.clone(), 0..4).prop_map(Value::from),
            prop::collection::vec((names, inner), 0..4).prop_map(|members| Value::Object(
                members
                    .into_iter()
                    .map(|(name, value)| (name.to_owned(), value))
                    .collect()
            )),
        ]
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn any_question_is_answered_or_refused(
        topic in prop::sample::select(vec!["start", "check", "diagram", "history", "branches", "returns", "border", "diagram.svg", "history.npz", "returns.csv"]),
        question in any_json(),
        change in prop::sample::select(vec!["runs", "observe", "keep", "until", "window", "parameter", "start", "set", "period"]),
        value in any_json(),
    ) {
        for question in [question, json!({ "model": model(), change: value, "transient": 1 })] {
            let reply = sent(&request("POST", &page(topic), &[], &question.to_string()));
            prop_assert_eq!(status(&reply), Some(200));
            let told = records(&reply);
            prop_assert_eq!(told.last().map(|(kind, _)| *kind), Some(Kind::End as u32));
            let text = String::from_utf8_lossy(&told[0].1).into_owned();
            prop_assert!(!text.contains("fault of chatter"), "{}", text);
        }
    }

    #[test]
    fn any_bytes_are_answered_or_hung_up_on(
        bytes in prop::collection::vec(any::<u8>(), 0..300),
        cut in any::<prop::sample::Index>(),
        flipped in any::<prop::sample::Index>(),
        byte in any::<u8>(),
    ) {
        let reply = broken_off(&bytes);
        prop_assert!(reply.is_empty() || matches!(status(&reply), Some(400..=431)));
        // One that is right but for a byte, and one that is broken off.
        let right = request("POST", &page("check"), &[], &json!({ "model": model() }).to_string());
        let mut wrong = right.clone();
        let place = flipped.index(wrong.len());
        wrong[place] = byte;
        let reply = broken_off(&wrong);
        prop_assert!(reply.is_empty() || status(&reply).is_some());
        let reply = broken_off(&right[..cut.index(right.len())]);
        prop_assert!(reply.is_empty() || status(&reply).is_some());
    }
}
