//! Tables in models: from a file, from arrays, from Rust code, and the same to the bit.

use chatter::expressions::{CurveKind, Outside};
use chatter::model::{Model, ModelBuilder, Table};
use chatter::numerics::{DoubleDouble, Real};

const REST: &str = "[flight]\ny = \"lift(y)\"\n[initial]\ny = 0\n";

fn value<R: Real>(model: &Model, at: R) -> R {
    let parameters: Vec<R> = model.parameter_values(&[]);
    model
        .graph
        .evaluate(model.states[0].derivative, &[at], &parameters)
}

fn from_file(keys: &str, data: &str) -> Model {
    let text = format!("[table.lift]\nfile = \"data/cam.csv\"\n{keys}{REST}");
    let mut asked = Vec::new();
    let mut load = |file: &str| {
        asked.push(file.to_owned());
        Ok(data.to_owned())
    };
    let model = Model::from_toml_with(&text, "model.toml", &mut load);
    assert_eq!(asked, ["data/cam.csv"]);
    model.unwrap_or_else(|errors| panic!("{errors}"))
}

#[test]
fn a_table_is_the_same_wherever_its_numbers_stand() {
    let inline = format!(
        "[table.lift]\nx = [0, 0.1, 0.7]\ny = [1, \"-2\", 3e-1]\nkind = \"cubic\"\noutside = \"hold\"\n{REST}"
    );
    let inline = Model::from_toml(&inline, "model.toml").unwrap();
    let keys = "kind = \"cubic\"\noutside = \"hold\"\n";
    let named = format!("{keys}columns = [\"angle\", 1]\n");
    let table =
        Table::new(CurveKind::Cubic, [0.0, 0.1, 0.7], [1.0, -2.0, 0.3]).outside(Outside::Hold);
    let built = ModelBuilder::new()
        .table("lift", table)
        .state("y", "lift(y)", 0)
        .build()
        .unwrap();
    for other in [
        from_file(keys, "0 1\n0.1 -2\n0.7 0.3\n"),
        from_file(&named, "lift;angle\n1;0\n-2;0.1\n0.3;0.7\n"),
        built,
    ] {
        for at in [-1.0, 0.05, 0.1, 0.3, 2.0] {
            let wide = DoubleDouble::from(at);
            assert_eq!(value(&inline, at), value(&other, at));
            assert_eq!(value(&inline, wide), value(&other, wide));
        }
    }
    // A tenth is a tenth to all digits, not the double nearest to it.
    let tenth = DoubleDouble::ONE / DoubleDouble::from(10.0);
    assert_eq!(value(&inline, tenth), DoubleDouble::from(-2.0));
}

#[test]
fn tables_may_be_called_from_every_formula_and_each_other() {
    let text = "[table.lift]\nx = [0, 1]\ny = [0, 2]\n[table.drag]\nx = [0, 4]\ny = [0, 1]\n\
                [parameters]\nc = \"drag(2)\"\n[definitions]\nboth = \"drag(lift(y)) + c\"\n\
                [flight]\ny = \"both\"\n[initial]\ny = \"lift(0.25)\"\n";
    let model = Model::from_toml(text, "model.toml").unwrap_or_else(|errors| panic!("{errors}"));
    let parameters = model.parameter_values::<f64>(&[]);
    assert_eq!(parameters, [0.5]);
    assert_eq!(model.initial_state(&parameters), [0.5]);
    assert_eq!(value(&model, 1.0), 1.0);
}

#[test]
fn a_table_without_a_value_is_told_where_it_is_asked() {
    let text = "[table.lift]\nx = [0, 1]\ny = [0, 2]\n[parameters]\nc = \"lift(1.5)\"\n\
                [flight]\ny = \"c\"\n[initial]\ny = 0\n";
    let errors = Model::from_toml(text, "model.toml").unwrap_err();
    assert_eq!(errors.errors()[0].line_and_column(), (5, 5), "{errors}");
}
