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
        "tables in double brackets",
        "[[parameters]]\ng = 1\n[[flight]]\ny = \"v\"\nv = \"-g\"\n[[initial]]\ny = 1\nv = 0\n",
    ),
    (
        "a flight that is no table",
        "flight = 3\n[initial]\ny = 1\n",
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
        "contacts in single brackets with their names",
        "[flight]\ny = \"v\"\nv = -1\n[initial]\ny = 1\nv = 0\n\n[contact.floor]\ngap = \"y\"\nimpulse = { v = 1 }\nrestitution = 0.5\n",
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
        "a drawing of something unknown",
        "[flight]\ny = \"v\"\nv = -1\n[initial]\ny = 1\nv = 0\n[[drawing.mas]]\nat = [0, \"y\"]\nradius = 1\n",
    ),
    (
        "a drawing with an unknown name",
        "[flight]\ny = \"v\"\nv = -1\n[initial]\ny = 1\nv = 0\n[[drawing.mass]]\nat = [0, \"lift\"]\nradius = 1\n",
    ),
    (
        "a mass nowhere and of no size",
        "[flight]\ny = \"v\"\nv = -1\n[initial]\ny = 1\nv = 0\n[[drawing.mass]]\nangle = 0\n",
    ),
    (
        "a mass that is round and square",
        "[flight]\ny = \"v\"\nv = -1\n[initial]\ny = 1\nv = 0\n[[drawing.mass]]\nat = [0, \"y\"]\nsize = [1, 1]\nradius = 1\n",
    ),
    (
        "a spring in three dimensions",
        "[flight]\ny = \"v\"\nv = -1\n[initial]\ny = 1\nv = 0\n[[drawing.spring]]\nfrom = [0, 0, 0]\nto = [0, \"y\"]\n",
    ),
    (
        "a wall that is no pair",
        "[flight]\ny = \"v\"\nv = -1\n[initial]\ny = 1\nv = 0\n[[drawing.wall]]\nfrom = \"y\"\n",
    ),
    (
        "a wall that is straight and round",
        "[flight]\ny = \"v\"\nv = -1\n[initial]\ny = 1\nv = 0\n[[drawing.wall]]\nfrom = [0, 0]\nat = [0, 0]\nradius = 1\n",
    ),
    (
        "a drawing that is a number",
        "drawing = 1\n[flight]\ny = \"v\"\nv = -1\n[initial]\ny = 1\nv = 0\n",
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
        "numbers too small to be told from zero",
        "[parameters]\na = -1e-400\nb = 0.0e-400\n\n[flight]\ny = \"a*b\"\n\n[initial]\ny = 2e-330\n",
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
        "a table without points",
        "[table.lift]\nkind = \"cubic\"\n[flight]\ny = \"lift(y)\"\n[initial]\ny = 1\n",
    ),
    (
        "a table with misspelt keys and words",
        "[table.lift]\nx = [0, 1]\ny = [0, 1]\nkind = \"periodic cubic\"\nouside = \"hold\"\n[flight]\ny = \"lift(y)\"\n[initial]\ny = 1\n",
    ),
    (
        "a table that cannot be what it should be outside",
        "[table.lift]\nx = [0, 1]\ny = [0, 1]\noutside = \"hol\"\n[flight]\ny = \"lift(y)\"\n[initial]\ny = 1\n",
    ),
    (
        "a table whose x does not increase",
        "[table.lift]\nx = [0, 10, 20, 15, 30]\ny = [0, 1, 2, 3, 4]\n[flight]\ny = \"lift(y)\"\n[initial]\ny = 1\n",
    ),
    (
        "a table with a point twice",
        "[table.lift]\nx = [0, 10, 10, 30]\ny = [0, 1, 2, 3]\n[flight]\ny = \"lift(y)\"\n[initial]\ny = 1\n",
    ),
    (
        "a table with more of x than of y",
        "[table.lift]\nx = [0, 10, 20]\ny = [0, 1]\n[flight]\ny = \"lift(y)\"\n[initial]\ny = 1\n",
    ),
    (
        "a table with values that are not finite",
        "[table.lift]\nx = [0, 1, 2]\ny = [0, nan, \"1/0\"]\n[flight]\ny = \"lift(y)\"\n[initial]\ny = 1\n",
    ),
    (
        "a table with one point",
        "[table.lift]\nx = [0]\ny = [1]\nkind = \"linear\"\n[flight]\ny = \"lift(y)\"\n[initial]\ny = 1\n",
    ),
    (
        "a periodic table that does not close",
        "[table.lift]\nx = [0, 90, 360]\ny = [0, 1, 0.5]\nkind = \"periodic-cubic\"\n[flight]\ny = \"lift(y)\"\n[initial]\ny = 1\n",
    ),
    (
        "a periodic table with an outside",
        "[table.lift]\nx = [0, 90, 360]\ny = [0, 1, 0]\nkind = \"periodic-cubic\"\noutside = \"hold\"\n[flight]\ny = \"lift(y)\"\n[initial]\ny = 1\n",
    ),
    (
        "slopes of a table that takes none",
        "[table.lift]\nx = [0, 90]\ny = [0, 1]\nkind = \"pchip\"\nslopes = [0, 0]\n[flight]\ny = \"lift(y)\"\n[initial]\ny = 1\n",
    ),
    (
        "three slopes",
        "[table.lift]\nx = [0, 90]\ny = [0, 1]\nkind = \"cubic\"\nslopes = [0, 0, 0]\n[flight]\ny = \"lift(y)\"\n[initial]\ny = 1\n",
    ),
    (
        "a table that depends on a parameter, and one on another table",
        "[parameters]\nheight = 2\n[table.lift]\nx = [0, 1, \"2*pii\"]\ny = [0, \"height\", 1]\n\n[table.drag]\nx = [0, 1]\ny = [0, \"lift(1)\"]\n\n[flight]\ny = \"lift(y)\"\n[initial]\ny = 1\n",
    ),
    (
        "a table of words",
        "[table.lift]\nx = \"0 1 2\"\ny = [0, true, 1]\n[flight]\ny = \"lift(y)\"\n[initial]\ny = 1\n",
    ),
    (
        "a table in a file and here",
        "[table.lift]\nfile = \"cam.csv\"\nx = [0, 1]\n[flight]\ny = \"lift(y)\"\n[initial]\ny = 1\n",
    ),
    (
        "a table in a file, read without files",
        "[table.lift]\nfile = \"cam.csv\"\n[flight]\ny = \"lift(y)\"\n[initial]\ny = 1\n",
    ),
    (
        "columns of no file, and such as there cannot be",
        "[table.lift]\nx = [0, 1]\ny = [0, 1]\ncolumns = [\"angle\", \"lift\"]\n[flight]\ny = \"lift(y)\"\n[initial]\ny = 1\n[table.drag]\nfile = \"drag.csv\"\ncolumns = [0, -1]\n[table.wind]\nfile = \"wind.csv\"\ncolumns = \"speed\"\n",
    ),
    (
        "tables with names that mean something else",
        "[parameters]\nlift = 2\n[table.lift]\nx = [0, 1]\ny = [0, 1]\n[flight]\ny = \"lift(y)\"\n[initial]\ny = 1\n[table.sqrt]\nx = [0, 1]\ny = [0, 1]\n[table.cam-lift]\nx = [0, 1]\ny = [0, 1]\n",
    ),
    (
        "a table without its argument, one with two, and a misspelt one",
        "[definitions]\na = \"lift*2\"\nb = \"lift(1, 2)\"\nc = \"lfit(y)\"\n[table.lift]\nx = [0, 1]\ny = [0, 1]\n[flight]\ny = \"lift(y)\"\n[initial]\ny = 1\n",
    ),
    (
        "tables that are none",
        "[table]\nx = [0, 1]\ny = [0, 1]\n[tables.lift]\nx = [0, 1]\n[flight]\ny = \"y\"\n[initial]\ny = 1\n",
    ),
    (
        "everything at once",
        "[parameters]\nr = 0.8\ng = \"9,81\"\n\n[flight]\ny = \"w\"\nv = \"-g - drag(v)\"\n\n[[contact]]\ngap = \"y - \"\nimpulse = { v = true }\nrestitution = 1.5\n\n[initial]\ny = 1\n",
    ),
    (
        "a comparison for a number",
        "[flight]\ny = \"v\"\nv = \"-1 + (y < 0)\"\n[initial]\ny = 1\nv = 0\n",
    ),
    (
        "a number for a condition",
        "[flight]\ny = \"v\"\nv = \"if(y, -1, 1)\"\n[initial]\ny = 1\nv = 0\n",
    ),
    (
        "an `if` without its last piece",
        "[flight]\ny = \"v\"\nv = \"if(y > 0, -1)\"\n[initial]\ny = 1\nv = 0\n",
    ),
    (
        "equality in a condition",
        "[flight]\ny = \"v\"\nv = \"if(y == 0, -1, 1)\"\n[initial]\ny = 1\nv = 0\n",
    ),
    (
        "a surface with its zero",
        "[flight]\ny = \"v\"\nv = -1\n[section.top]\nsurface = \"v = 0\"\n[initial]\ny = 1\nv = 0\n",
    ),
    (
        "a choice as in Pascal",
        "[flight]\ny = \"v\"\nv = \"if y > 0 then -1 else 1\"\n[initial]\ny = 1\nv = 0\n",
    ),
    (
        "a choice as in C",
        "[flight]\ny = \"v\"\nv = \"y > 0 ? -1 : 1\"\n[initial]\ny = 1\nv = 0\n",
    ),
    (
        "a number with its unit",
        "[flight]\ny = \"v\"\nv = \"-9.81 m/s^2\"\n[initial]\ny = 1\nv = 0\n",
    ),
    (
        "an expression without quotes in a reset",
        "[flight]\ny = \"v\"\nv = -1\n[[event]]\nname = \"turn\"\nsurface = \"y\"\nreset = { y = \"y\", v = -0.5*v }\n[initial]\ny = 1\nv = 0\n",
    ),
    (
        "conditions joined as in C",
        "[flight]\ny = \"v\"\nv = \"if(y > 0 && v > 0, -1, 1)\"\n[initial]\ny = 1\nv = 0\n",
    ),
    (
        "a condition joined outside of `if`",
        "[flight]\ny = \"v\"\nv = \"y > 0 and v\"\n[initial]\ny = 1\nv = 0\n",
    ),
    (
        "the sign function under another name",
        "[flight]\ny = \"v\"\nv = \"-sgn(v)\"\n[initial]\ny = 1\nv = 0\n",
    ),
    (
        "the step function under another name",
        "[flight]\ny = \"v\"\nv = \"-heaviside(y)\"\n[initial]\ny = 1\nv = 0\n",
    ),
    (
        "a maximum of one number",
        "[flight]\ny = \"v\"\nv = \"-max(y)\"\n[initial]\ny = 1\nv = 0\n",
    ),
    (
        "a clamp without its upper bound",
        "[flight]\ny = \"v\"\nv = \"clamp(y, 0)\"\n[initial]\ny = 1\nv = 0\n",
    ),
    (
        "a remainder by `%`",
        "[flight]\ny = \"v\"\nv = \"y % 2\"\n[initial]\ny = 1\nv = 0\n",
    ),
    (
        "a state called like a function",
        "[flight]\nstep = \"-1\"\n[initial]\nstep = 1\n",
    ),
    (
        "a reset beside an impulse",
        "[flight]\ny = \"v\"\nv = -1\n[initial]\ny = 1\nv = 0\n\n[[contact]]\ngap = \"y\"\nimpulse = { v = 1 }\nreset = { v = \"-v\" }\n",
    ),
    (
        "a reset of a name that is no state",
        "[flight]\ny = \"v\"\nv = -1\n[initial]\ny = 1\nv = 0\n\n[[contact]]\ngap = \"y\"\nreset = { w = \"-v\" }\n",
    ),
    (
        "a reset that is no table",
        "[flight]\ny = \"v\"\nv = -1\n[initial]\ny = 1\nv = 0\n\n[[contact]]\ngap = \"y\"\nreset = \"-v\"\n",
    ),
    (
        "friction without a direction",
        "[flight]\ny = \"v\"\nv = -1\n[initial]\ny = 1\nv = 0\n\n[[contact]]\ngap = \"y\"\nimpulse = { v = 1 }\nrestitution = 0.5\nfriction = { coefficient = 0.3 }\n",
    ),
    (
        "friction along two states without a rate",
        "[flight]\nx = \"u\"\nu = 0\ny = \"v\"\nv = -1\nw = 0\n[initial]\nx = 0\nu = 1\ny = 1\nv = 0\nw = 0\n\n[[contact]]\ngap = \"y\"\nimpulse = { v = 1 }\nrestitution = 0.5\nfriction = { coefficient = 0.3, along = { u = 1, w = 2 } }\n",
    ),
    (
        "friction with a negative coefficient",
        "[flight]\nx = \"u\"\nu = 0\ny = \"v\"\nv = -1\n[initial]\nx = 0\nu = 1\ny = 1\nv = 0\n\n[[contact]]\ngap = \"y\"\nimpulse = { v = 1 }\nrestitution = 0.5\nfriction = { coefficient = -0.3, along = { u = 1 } }\n",
    ),
    (
        "friction with a misspelt key",
        "[flight]\nx = \"u\"\nu = 0\ny = \"v\"\nv = -1\n[initial]\nx = 0\nu = 1\ny = 1\nv = 0\n\n[[contact]]\ngap = \"y\"\nimpulse = { v = 1 }\nrestitution = 0.5\nfriction = { coeficient = 0.3, along = { u = 1 } }\n",
    ),
    (
        "an event without a reset",
        "[flight]\ny = \"v\"\nv = -1\n[initial]\ny = 1\nv = 0\n\n[[event]]\nname = \"kick\"\nsurface = \"v\"\n",
    ),
    (
        "an event without a surface",
        "[flight]\ny = \"v\"\nv = -1\n[initial]\ny = 1\nv = 0\n\n[[event]]\nname = \"kick\"\nreset = { v = 1 }\n",
    ),
    (
        "an event that changes time",
        "[flight]\ny = \"sin(t)\"\n[initial]\ny = 1\n\n[[event]]\nsurface = \"y\"\nreset = { t = 0 }\n",
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

/// What is wrong with a file of numbers, its text, and what else the model says about it.
const WRONG_DATA: &[(&str, &str, &str)] = &[
    (
        "a file without numbers",
        "# to be measured\nangle,lift\n",
        "",
    ),
    ("a file of one column", "0\n0.5\n", ""),
    (
        "a word among numbers",
        "angle,lift\n0,0\n90,n/a\n180,0\n",
        "",
    ),
    ("a field left out", "angle,lift\n0,0\n90,\n180,0\n", ""),
    ("decimal commas", "angle;lift\n0;0\n90;0,25\n180;0\n", ""),
    ("a line too long", "angle,lift\n0,0\n90,0,25\n180,0\n", ""),
    (
        "a misspelt column",
        "time,angle,lift\n0,0,0\n",
        "columns = [\"angel\", \"lift\"]\n",
    ),
    (
        "names of columns that have none",
        "0,0\n1,1\n",
        "columns = [\"angle\", \"lift\"]\n",
    ),
    (
        "two columns of one name",
        "lift,lift\n0,0\n1,1\n",
        "columns = [1, \"lift\"]\n",
    ),
    (
        "a column that is not there",
        "0,0\n1,1\n",
        "columns = [1, 3]\n",
    ),
    ("a quotation mark left open", "\"angle,lift\n0,0\n", ""),
    (
        "angles that go back",
        "angle,lift\n0,0\n90,1\n# again\n45,0.5\n",
        "",
    ),
    (
        "a lift that is not finite",
        "angle,lift\n0,0\n90,inf\n180,0\n",
        "",
    ),
    (
        "a lift too small to be told from zero",
        "angle,lift\n0,0\n90,1e-400\n180,0\n",
        "",
    ),
    (
        "a turn that does not close",
        "angle,lift\n0,0\n90,1\n360,1e-17\n",
        "kind = \"periodic-cubic\"\n",
    ),
];

#[test]
fn messages_of_data_files() {
    let mut document = String::new();
    for (what, data, keys) in WRONG_DATA {
        let text = format!(
            "[table.lift]\nfile = \"cam.csv\"\n{keys}\n[flight]\ny = \"lift(y)\"\n[initial]\ny = 1\n"
        );
        let mut load = |_: &str| Ok((*data).to_owned());
        let errors = Model::from_toml_with(&text, "model.toml", &mut load).expect_err(what);
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

[table.drag]
kind = "cubic"
x = [-1e1, 0, "10"]
y = [3, "-pi/8", 3.0]
slopes = [-1, 1]
outside = "hold"

[flight]
y = "v"
v = """
-g - drag(v)*0
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
