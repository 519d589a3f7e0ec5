//! Every way to get a model wrong that we could think of, with the whole message for each: the snapshot is meant to be
//! read, and is to be helpful to somebody who has never seen a model file.

use chatter::model::{Direction, Model, ModelBuilder, ModelErrorKind, Palette};
use proptest::prelude::*;

/// What is wrong, and a text that has it wrong.
const WRONG: &[(&str, &str)] = &[
    ("an empty file", ""),
    (
        "nothing but a comment and a title",
        "# to do\ntitle = \"Ball\"\n",
    ),
    ("no flight table", "[parameters]\ng = 9.81\n"),
    ("a flight table without equations", "[flight]\n[initial]\n"),
    (
        "a misspelt table",
        "[paramters]\ng = 9.81\n\n[flight]\ny = \"v\"\nv = -1\n\n[initial]\ny = 1\nv = 0\n",
    ),
    (
        "a table that means nothing",
        "[flight]\ny = 0\n[initial]\ny = 0\n[solver]\norder = 4\n",
    ),
    (
        "a misspelt key of a contact",
        "[flight]\ny = \"v\"\nv = -1\n[initial]\ny = 1\nv = 0\n\n[[contact]]\ngap = \"y\"\nimpulse = { v = 1 }\nrestitition = 0.5\n",
    ),
    (
        "a contact without gap, impulse and restitution",
        "[flight]\ny = \"v\"\nv = -1\n[initial]\ny = 1\nv = 0\n\n[[contact]]\nname = \"floor\"\n",
    ),
    (
        "a contact in single brackets",
        "[flight]\ny = \"v\"\nv = -1\n[initial]\ny = 1\nv = 0\n\n[contact]\ngap = \"y\"\nimpulse = { v = 1 }\nrestitution = 0.5\n",
    ),
    (
        "an impulse on a name that is no state",
        "[flight]\ny = \"v\"\nvel = -1\n[initial]\ny = 1\nvel = 0\n\n[[contact]]\ngap = \"y\"\nimpulse = { vle = 1 }\nrestitution = 0.5\n",
    ),
    (
        "an impulse on time",
        "[flight]\ny = \"sin(t)\"\n[initial]\ny = 1\n\n[[contact]]\ngap = \"y\"\nimpulse = { t = 1 }\nrestitution = 0.5\n",
    ),
    (
        "an impulse that changes nothing",
        "[flight]\ny = \"v\"\nv = -1\n[initial]\ny = 1\nv = 0\n\n[[contact]]\ngap = \"y\"\nimpulse = { v = 0 }\nrestitution = 0.5\n",
    ),
    (
        "an impulse that is a name instead of a table",
        "[flight]\ny = \"v\"\nv = -1\n[initial]\ny = 1\nv = 0\n\n[[contact]]\ngap = \"y\"\nimpulse = \"v\"\nrestitution = 0.5\n",
    ),
    (
        "a restitution above one",
        "[flight]\ny = \"v\"\nv = -1\n[initial]\ny = 1\nv = 0\n\n[[contact]]\ngap = \"y\"\nimpulse = { v = 1 }\nrestitution = 1.001\n",
    ),
    (
        "a negative restitution",
        "[flight]\ny = \"v\"\nv = -1\n[initial]\ny = 1\nv = 0\n\n[[contact]]\ngap = \"y\"\nimpulse = { v = 1 }\nrestitution = \"-0.8\"\n",
    ),
    (
        "two contacts of one name",
        "[flight]\ny = \"v\"\nv = -1\n[initial]\ny = 1\nv = 0\n\n[[contact]]\nname = \"stop\"\ngap = \"y\"\nimpulse = { v = 1 }\nrestitution = 0\n\n[[contact]]\nname = \"stop\"\ngap = \"2 - y\"\nimpulse = { v = 1 }\nrestitution = 0\n",
    ),
    (
        "one name for a state and a parameter",
        "[parameters]\nv = 2\n\n[flight]\ny = \"v\"\nv = -1\n\n[initial]\ny = 1\nv = 0\n",
    ),
    (
        "a key given twice",
        "[flight]\ny = \"v\"\nv = -1\ny = \"2*v\"\n\n[initial]\ny = 1\nv = 0\n",
    ),
    (
        "a state without initial value",
        "[flight]\ny = \"v\"\nv = -1\n\n[initial]\ny = 1\n",
    ),
    (
        "an initial value for something else",
        "[flight]\ny = \"velocity\"\nvelocity = -1\n\n[initial]\ny = 1\nvelocty = 0\nvelocity = 0\n",
    ),
    (
        "an initial value that depends on a state",
        "[flight]\ny = \"v\"\nv = -1\n\n[initial]\ny = 1\nv = \"sqrt(2*y)\"\n",
    ),
    (
        "an initial value that depends on a changing definition",
        "[definitions]\nenergy = \"v^2/2 + y\"\n[flight]\ny = \"v\"\nv = -1\n[initial]\ny = \"energy\"\nv = 0\n",
    ),
    (
        "a parameter that depends on a state",
        "[parameters]\nlength = \"2*y\"\n\n[flight]\ny = \"length\"\n\n[initial]\ny = 1\n",
    ),
    (
        "a parameter that depends on time",
        "[parameters]\nload = \"cos(t)\"\n\n[flight]\ny = \"load\"\n\n[initial]\ny = 1\n",
    ),
    (
        "parameters in a circle",
        "[parameters]\na = \"b + 1\"\nb = \"2*c\"\nc = \"a\"\n\n[flight]\ny = \"a\"\n\n[initial]\ny = 1\n",
    ),
    (
        "a definition that needs itself",
        "[definitions]\nforce = \"force - y\"\n\n[flight]\ny = \"force\"\n\n[initial]\ny = 1\n",
    ),
    (
        "definitions in a circle",
        "[definitions]\na = \"b\"\nb = \"a*y\"\n\n[flight]\ny = \"a\"\n\n[initial]\ny = 1\n",
    ),
    (
        "an equation for time",
        "[flight]\nt = 1\ny = \"sin(t)\"\n\n[initial]\ny = 1\n",
    ),
    (
        "a parameter called pi",
        "[parameters]\npi = 3\n\n[flight]\ny = \"pi\"\n\n[initial]\ny = 1\n",
    ),
    (
        "a state called after a function",
        "[flight]\nsin = 1\n\n[initial]\nsin = 1\n",
    ),
    (
        "a parameter called t",
        "[parameters]\nt = 3\n\n[flight]\ny = \"t\"\n\n[initial]\ny = 1\n",
    ),
    (
        "a name with a hyphen",
        "[parameters]\nspring-rate = 3\n\n[flight]\ny = 1\n\n[initial]\ny = 1\n",
    ),
    (
        "a misspelt parameter in an equation",
        "[parameters]\nkappa = 1.25\n\n[flight]\ny = \"v\"\nv = \"-kapa*v - y\"\n\n[initial]\ny = 1\nv = 0\n",
    ),
    (
        "a misspelt function",
        "[flight]\ny = \"v\"\nv = \"-sinn(y) - cosec(v)\"\n\n[initial]\ny = 1\nv = 0\n",
    ),
    (
        "an operator too much, and a parenthesis left open",
        "[flight]\ny = \"v +* 2\"\nv = \"-(y + 1\"\n\n[initial]\ny = 1\nv = 0\n",
    ),
    (
        "multiplication left out",
        "[parameters]\nk = 2\n[flight]\ny = \"v\"\nv = \"-2 y - k(y + 1)\"\n\n[initial]\ny = 1\nv = 0\n",
    ),
    (
        "a wrong name in an expression of several lines",
        "[flight]\ny = \"\"\"\n  v\n  + wind\"\"\"\nv = -1\n\n[initial]\ny = 1\nv = 0\n",
    ),
    (
        "a wrong name in a string with escapes",
        "[flight]\ny = \"v\\t+ wind\"\nv = -1\n\n[initial]\ny = 1\nv = 0\n",
    ),
    (
        "an equation without quotes",
        "[flight]\ny = v\nv = -g*y\n\n[initial]\ny = 1\nv = 0\n",
    ),
    (
        "values left out, and numbers that are none",
        "[parameters]\na =\nb = .5\nc = 1,5\nd = 1.2.3\n\n[flight]\ny = \"a*b*c*d\"\n\n[initial]\ny = 1\n",
    ),
    ("no initial values", "[flight]\ny = \"v\"\nv = \"-y\"\n"),
    (
        "a table given twice",
        "[flight]\ny = \"v\"\n\n[initial]\ny = 0\nv = 0\n\n[flight]\nv = 1\n",
    ),
    (
        "a table header that is not closed, and a string that is not closed",
        "[flight]\ny = \"v\nv = \"2*y +\"\n\n[initial\ny = 1\nv = 0\n",
    ),
    (
        "values of the wrong type",
        "title = 3\n\n[flight]\ny = true\nv = [1, 2]\nw = 2020-01-01\n\n[initial]\ny = 1\nv = 0\nw = 0\n",
    ),
    (
        "a parameter that is not finite",
        "[parameters]\na = inf\nb = 1e999\n\n[flight]\ny = \"a*b\"\n\n[initial]\ny = 1\n",
    ),
    (
        "a parameter that divides by zero",
        "[parameters]\nperiod = 0\nomega = \"2*pi/period\"\n\n[flight]\ny = \"cos(omega*t)\"\n\n[initial]\ny = 1\n",
    ),
    (
        "an initial value outside its domain",
        "[parameters]\nheight = -2\n\n[flight]\ny = \"v\"\nv = -1\n\n[initial]\ny = 1\nv = \"sqrt(2*height)\"\n",
    ),
    (
        "a misspelt direction",
        "[flight]\ny = 1\n[initial]\ny = 1\n[section.top]\nsurface = \"y\"\ndirection = \"faling\"\n",
    ),
    (
        "a section without surface, and one that is no table",
        "[flight]\ny = 1\n[initial]\ny = 1\n[section.top]\ndirection = \"rising\"\n[section]\nbottom = \"y\"\n",
    ),
    (
        "a label for nothing",
        "[flight]\nlift = 1\n[initial]\nlift = 1\n[labels]\nlfit = \"valve lift\"\n",
    ),
    (
        "a label with a wrong key",
        "[flight]\nlift = 1\n[initial]\nlift = 1\n[labels]\nlift = { text = \"valve lift\", units = \"mm\" }\n",
    ),
    (
        "everything at once",
        "[parameters]\nr = 0.8\ng = \"9,81\"\n\n[flight]\ny = \"w\"\nv = \"-g - drag(v)\"\n\n[[contact]]\ngap = \"y - \"\nimpulse = { v = true }\nrestitution = 1.5\n\n[initial]\ny = 1\n",
    ),
];

#[test]
fn messages() {
    let mut document = String::new();
    for (what, text) in WRONG {
        let errors = Model::from_toml(text, "model.toml").expect_err(what);
        document += &format!("=== {what} ===\n{errors}\n\n");
    }
    insta::assert_snapshot!(document);
}

#[test]
fn messages_without_a_file() {
    let mut document = String::new();
    let mut say =
        |what: &str, message: String| document += &format!("=== {what} ===\n{message}\n\n");
    let wrong = ModelBuilder::new()
        .parameter("pi", 3)
        .parameter("g", f64::INFINITY)
        .state("y", "w", 0)
        .state("v", "-g - 2 y", "y")
        .state("y", 1, 0)
        .contact("floor", "y +", [("w", 1)], 1.5)
        .section("", "v", Direction::Rising)
        .build();
    say(
        "a builder with everything wrong",
        wrong.unwrap_err().to_string(),
    );
    say(
        "an empty builder",
        ModelBuilder::new().build().unwrap_err().to_string(),
    );
    let ball = ModelBuilder::new()
        .parameter("g", 9.81)
        .parameter("weight", "2*g")
        .definition("speed", "sqrt(v^2)")
        .state("height", "v", 1)
        .state("v", "-weight*speed", 0)
        .contact("floor", "height", [("v", 1)], 0.5)
        .build()
        .unwrap();
    let mut changed = ball.clone();
    for (name, text) in [
        ("gg", "1"),
        ("g", "9,81"),
        ("g", "v"),
        ("g", "weight/2"),
        ("weight", "1/0"),
        ("g", "weigth"),
        ("g", ""),
    ] {
        let error = changed.set_parameter(name, text).unwrap_err();
        say(&format!("--set {name}={text}"), error.to_string());
    }
    for (name, text) in [
        ("hight", "1"),
        ("height", "v"),
        ("height", "speed"),
        ("v", "log(0)"),
        ("t", "1"),
    ] {
        let error = changed.set_initial(name, text).unwrap_err();
        say(&format!("--initial {name}={text}"), error.to_string());
    }
    assert_eq!(
        changed.parameter_values::<f64>(&[]),
        ball.parameter_values::<f64>(&[])
    );
    insta::assert_snapshot!(document);
}

#[test]
fn parameters_and_initial_values_can_be_set() {
    let mut ball = ModelBuilder::new()
        .parameter("g", 9.81)
        .parameter("twice", "2*g")
        .state("y", "v", "twice")
        .state("v", "-g*cos(t)", 0)
        .build()
        .unwrap();
    ball.set_parameter("g", "3/2").unwrap();
    ball.set_initial("v", "-sqrt(g + twice^2/4 - g + 1.75)")
        .unwrap();
    ball.set_initial("t", "pi").unwrap();
    let parameters = ball.parameter_values::<f64>(&[]);
    assert_eq!(parameters, [1.5, 3.0]);
    assert_eq!(
        ball.initial_state(&parameters),
        [3.0, -2.0, std::f64::consts::PI]
    );
    let energy = ball.parse_expression("v^2/2 + g*y").unwrap();
    assert_eq!(
        ball.graph
            .evaluate::<f64>(energy, &[2.0, 4.0, 0.0], &parameters),
        11.0
    );
    assert!(ball.parse_expression("v + w").is_err());
}

#[test]
fn errors_know_their_line_and_column() {
    let text = "[flight]\ny = \"\"\"\n  v + π\n  + wind\"\"\"\nv = -1\n\n[initial]\ny = 1\nv = 0\n";
    let errors = Model::from_toml(text, "folder/ball.toml").unwrap_err();
    let error = &errors.errors()[0];
    assert_eq!(error.source_name(), "folder/ball.toml");
    assert_eq!(error.line_and_column(), (3, 7));
    assert_eq!(&text[error.span()], "π");
    assert!(matches!(error.kind(), ModelErrorKind::Expression { .. }));
    assert!(error.render(Palette::Ansi).contains("\u{1b}["));
    assert!(!error.render(Palette::Plain).contains("\u{1b}["));
}

/// A model file that uses all there is.
const COMPLETE: &str = r#"
title = "Ball"
source = 'nowhere'

[parameters]
g = 9.81
A = "g/omega^2" # amplitude
omega = 6e1

[definitions]
table = "A*sin(omega*t)"

[flight]
y = "v"
v = """
-g
"""

[[contact]]
name = "table"
gap = "y - table"
impulse = { v = 1, y = "0" }
restitution = "1/2"

[section.phase]
surface = "sin(omega*t)"
direction = "rising"

[initial]
y = 1
v = 0.0
t = 0x10

[labels]
y = { text = "height", unit = "m" }
v = "velocity"
"#;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn the_reader_survives_any_change_to_a_model(
        changes in prop::collection::vec((0..COMPLETE.len(), 0..3_usize, any::<char>()), 1..6),
        fragments in prop::collection::vec(
            (0..COMPLETE.len(), prop::sample::select(vec![
                "\n", "\"", "'", "\"\"\"", "[", "]]", "{", "=", "\\", "\u{feff}", "\r\n", "\t", "t", "[[contact]]\n",
                "[flight]\n", "nan", "1e999", "0", "-", "^", "(", "é",
            ])),
            0..4,
        ),
    ) {
        let mut characters: Vec<char> = COMPLETE.chars().collect();
        for (at, action, character) in changes {
            let at = at.min(characters.len() - 1);
            match action {
                0 => characters[at] = character,
                1 => characters.insert(at, character),
                _ => {
                    characters.remove(at);
                }
            }
        }
        for (at, fragment) in fragments {
            let at = at.min(characters.len());
            characters.splice(at..at, fragment.chars());
        }
        let text: String = characters.into_iter().collect();
        match Model::from_toml(&text, "model.toml") {
            Ok(model) => drop(chatter::model::check(&model)),
            Err(errors) => {
                prop_assert!(!errors.errors().is_empty());
                prop_assert!(errors.to_string().contains("error: "));
                for error in errors.errors() {
                    prop_assert!(text.get(error.span()).is_some(), "{:?}", error.span());
                }
            }
        }
    }
}

#[test]
fn the_model_that_is_changed_is_right_itself() {
    let model =
        Model::from_toml(COMPLETE, "model.toml").unwrap_or_else(|errors| panic!("{errors}"));
    let initial = model.initial_state(&model.parameter_values::<f64>(&[]));
    assert_eq!(initial, [1.0, 0.0, 16.0]);
}
