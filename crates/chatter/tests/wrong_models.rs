//! Every way to get a model wrong that we could think of, with the whole message for each: the snapshot is meant to be
//! read, and is to be helpful to somebody who has never seen a model file.

use chatter::model::Model;

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
        "a restitution of one",
        "[flight]\ny = \"v\"\nv = -1\n[initial]\ny = 1\nv = 0\n\n[[contact]]\ngap = \"y\"\nimpulse = { v = 1 }\nrestitution = 1\n",
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
