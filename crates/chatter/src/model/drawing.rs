//! What a mechanism looks like: shapes at places that follow the state.

use super::error::ModelErrorKind;
use super::source::draft::{Formula, Name, Place, ShapeDraft};
use super::source::table::{Item, TableReader};
use crate::expressions::Expr;
use toml::Spanned;
use toml::de::DeValue;

/// One part of a drawing. Its numbers are expressions of the equations, in units of length that are the same across and
/// upwards.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// What it is.
    pub kind: ShapeKind,
    /// Where it is and how large, in the order of [`ShapeKind::quantities`]. Where time is no state of the model, it is
    /// the number behind the states.
    pub numbers: Vec<Expr>,
}

/// Kinds of shapes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShapeKind {
    /// A box around its centre.
    Mass,
    /// A round mass around its centre.
    Disc,
    /// A spring from one end to the other.
    Spring,
    /// A wall, hatched on the right of the way from one end to the other.
    Wall,
    /// A round wall around its centre, hatched outside.
    RoundWall,
    /// A rod from one end to the other.
    Rod,
}

impl ShapeKind {
    /// A word for it, the same in all output.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Mass => "mass",
            Self::Disc => "disc",
            Self::Spring => "spring",
            Self::Wall => "wall",
            Self::RoundWall => "round_wall",
            Self::Rod => "rod",
        }
    }

    /// What its numbers are; angles in radians, turned to the left.
    pub const fn quantities(self) -> &'static [&'static str] {
        match self {
            Self::Mass => &["x", "y", "width", "height", "angle"],
            Self::Disc => &["x", "y", "radius", "angle"],
            Self::RoundWall => &["x", "y", "radius"],
            Self::Spring | Self::Wall | Self::Rod => &["from_x", "from_y", "to_x", "to_y"],
        }
    }
}

/// What may stand in `[drawing]`.
const DRAWING: &[&str] = &["mass", "spring", "wall", "rod"];
const MASS: &[&str] = &["at", "size", "radius", "angle"];
const WALL: &[&str] = &["from", "to", "at", "radius"];
const LINE: &[&str] = &["from", "to"];

impl<'i> TableReader<'i> {
    /// The shapes of a drawing.
    pub(super) fn drawing(&mut self, value: &Spanned<DeValue<'i>>) -> Vec<ShapeDraft> {
        const EXPECTED: &str = "tables such as [[drawing.mass]]";
        let items = self.table("drawing", EXPECTED, value).unwrap_or_default();
        let mut shapes = Vec::new();
        for Item { key, value } in &items {
            let meant = self.meant(key, "[drawing]", DRAWING, &items);
            let alone = core::slice::from_ref(*value);
            let tables: Box<dyn Iterator<Item = &Spanned<DeValue<'i>>>> = match value.get_ref() {
                DeValue::Array(array) => Box::new(array.iter()),
                _ => Box::new(alone.iter()),
            };
            for value in tables {
                shapes.extend(match meant {
                    "mass" => self.mass(value),
                    "spring" => self.line(ShapeKind::Spring, value),
                    "wall" => self.wall(value),
                    "rod" => self.line(ShapeKind::Rod, value),
                    _ => None,
                });
            }
        }
        shapes
    }

    fn mass(&mut self, value: &Spanned<DeValue<'i>>) -> Option<ShapeDraft> {
        const TABLE: &str = "[[drawing.mass]]";
        let items = self.table("mass", "a table [[drawing.mass]]", value)?;
        let place = self.place(value.span());
        let (mut at, mut size, mut radius, mut angle) = (None, None, None, None);
        for Item { key, value } in &items {
            match self.meant(key, TABLE, MASS, &items) {
                "at" => at = Some(self.pair("at", value)),
                "size" => size = Some((self.pair("size", value), key)),
                "radius" => radius = Some(self.formula("radius".to_owned(), value)),
                "angle" => angle = Some(self.formula("angle".to_owned(), value)),
                _ => {}
            }
        }
        self.check_missing(TABLE, &[("at", at.is_some())], &place);
        let (kind, size) = match (size, radius) {
            (Some((_, Name { place, .. })), Some(_)) => {
                let kind = ModelErrorKind::BothKeys {
                    table: TABLE.to_owned(),
                    key: "size",
                    other: "radius",
                };
                self.report(kind, place);
                return None;
            }
            (Some((size, _)), None) => (ShapeKind::Mass, size?.to_vec()),
            (None, Some(radius)) => (ShapeKind::Disc, vec![radius]),
            (None, None) => {
                self.check_missing(TABLE, &[("size", false)], &place);
                return None;
            }
        };
        let angle = angle.unwrap_or_else(|| Formula::zero(&place));
        let numbers = at??.into_iter().chain(size).chain([angle]);
        Some(ShapeDraft {
            kind,
            numbers: numbers.collect(),
        })
    }

    fn wall(&mut self, value: &Spanned<DeValue<'i>>) -> Option<ShapeDraft> {
        const TABLE: &str = "[[drawing.wall]]";
        let is_round = |item: &Item<'_, 'i>| item.key.text == "at" || item.key.text == "radius";
        let round = (value.get_ref().as_table())
            .map(|table| self.items(table))
            .is_some_and(|items| items.iter().any(is_round));
        if !round {
            return self.line(ShapeKind::Wall, value);
        }
        let items = self.table("wall", "a table [[drawing.wall]]", value)?;
        let (mut at, mut radius) = (None, None);
        for Item { key, value } in &items {
            match self.meant(key, TABLE, WALL, &items) {
                "at" => at = Some(self.pair("at", value)),
                "radius" => radius = Some(self.formula("radius".to_owned(), value)),
                "from" | "to" => {
                    let kind = ModelErrorKind::BothKeys {
                        table: TABLE.to_owned(),
                        key: if key.text == "from" { "from" } else { "to" },
                        other: "radius",
                    };
                    self.report(kind, &key.place);
                }
                _ => {}
            }
        }
        let place = self.place(value.span());
        let given = [("at", at.is_some()), ("radius", radius.is_some())];
        self.check_missing(TABLE, &given, &place);
        Some(ShapeDraft {
            kind: ShapeKind::RoundWall,
            numbers: at??.into_iter().chain(radius).collect(),
        })
    }

    fn line(&mut self, kind: ShapeKind, value: &Spanned<DeValue<'i>>) -> Option<ShapeDraft> {
        let table = format!("[[drawing.{}]]", kind.name());
        let items = self.table(kind.name(), "a table such as [[drawing.spring]]", value)?;
        let place = self.place(value.span());
        let (mut from, mut to) = (None, None);
        for Item { key, value } in &items {
            let known = match kind {
                ShapeKind::Wall => WALL,
                _ => LINE,
            };
            match self.meant(key, &table, known, &items) {
                "from" => from = Some(self.pair("from", value)),
                "to" => to = Some(self.pair("to", value)),
                _ => {}
            }
        }
        let given = [("from", from.is_some()), ("to", to.is_some())];
        self.check_missing(&table, &given, &place);
        Some(ShapeDraft {
            kind,
            numbers: from??.into_iter().chain(to??).collect(),
        })
    }

    /// Reports those of the keys that are not given.
    fn check_missing(&mut self, table: &str, given: &[(&'static str, bool)], place: &Place) {
        let missing = given.iter().filter(|(_, given)| !given);
        let keys: Vec<&'static str> = missing.map(|(key, _)| *key).collect();
        if !keys.is_empty() {
            let table = table.to_owned();
            self.report(ModelErrorKind::MissingKeys { table, keys }, place);
        }
    }

    /// Two expressions, across and upwards; `None` where there are not two, which is reported.
    fn pair(&mut self, key: &str, value: &Spanned<DeValue<'i>>) -> Option<[Formula; 2]> {
        let Some(array) = value.get_ref().as_array() else {
            self.wrong_type(key.to_owned(), "two expressions such as [0, \"y\"]", value);
            return None;
        };
        let entries: Vec<&Spanned<DeValue<'i>>> = array.iter().collect();
        let &[across, up] = &entries[..] else {
            let kind = ModelErrorKind::WrongLength {
                what: key.to_owned(),
                found: entries.len(),
                expected: "two expressions, across and upwards",
            };
            let place = self.place(value.span());
            self.report(kind, &place);
            return None;
        };
        Some([across, up].map(|value| self.formula(format!("`{key}`"), value)))
    }
}

#[cfg(test)]
mod tests {
    use super::ShapeKind;
    use crate::model::Model;

    const BALL: &str = "[flight]\ny = \"v\"\nv = -1\n[initial]\ny = 1\nv = 0\n";

    #[test]
    fn shapes_are_read_and_change_nothing_else() {
        let drawing = "[[drawing.mass]]\nat = [\"t\", \"y\"]\nradius = 0.5\n[[drawing.wall]]\nfrom = [-1, 0]\nto = [1, 0]\n\
             [[drawing.wall]]\nat = [0, 0]\nradius = 3\n[[drawing.mass]]\nat = [0, 0]\nsize = [1, 2]\nangle = \"v\"\n";
        let [plain, drawn] =
            [BALL, &format!("{BALL}{drawing}")].map(|text| Model::from_toml(text, "ball").unwrap());
        let kinds: Vec<ShapeKind> = drawn.drawing.iter().map(|shape| shape.kind).collect();
        let expected = [
            ShapeKind::Mass,
            ShapeKind::Disc,
            ShapeKind::Wall,
            ShapeKind::RoundWall,
        ];
        assert!(expected.iter().all(|kind| kinds.contains(kind)));
        assert_eq!(kinds.len(), 4);
        for shape in &drawn.drawing {
            assert_eq!(shape.numbers.len(), shape.kind.quantities().len());
        }
        assert_eq!(plain.state_names(), drawn.state_names());
        assert_eq!(drawn.time, None);
        // Time is the number behind the states.
        let disc = drawn
            .drawing
            .iter()
            .find(|shape| shape.kind == ShapeKind::Disc)
            .unwrap();
        let at: Vec<f64> = (disc.numbers.iter())
            .map(|&number| drawn.graph.evaluate(number, &[2.0, 3.0, 7.0], &[]))
            .collect();
        assert_eq!(at, [7.0, 2.0, 0.5, 0.0]);
    }
}
