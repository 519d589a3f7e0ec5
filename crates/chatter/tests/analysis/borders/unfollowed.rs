//! Borders beside values at which nothing can be said.

use chatter::analysis::border::*;
use chatter::analysis::border_search::*;
use chatter::flow::FlowError;
use chatter::model::Model;

fn read(text: &str) -> Model {
    Model::from_toml(text, "test").unwrap_or_else(|errors| panic!("{errors:?}\n{text}"))
}

fn found(text: &str, parameter: &str, (low, high): (f64, f64), samples: usize) -> Borders<f64> {
    let mut spec = BorderSpec::new(parameter);
    spec.samples = samples;
    borders_in(&read(text), &spec, low, high).unwrap()
}

/// A hammer on a spring that softens until it throws it off, in these units.
fn escaping((long, short): (f64, f64)) -> String {
    let (stiff, unit) = (1.0 / short / short, long / short / short);
    format!(
        "[parameters]\nA = 1.2\n[flight]\nx = \"v\"\n\
         v = \"-{unit:?} - {:?}*x - {:?}*v + {:?}*x^3 + {unit:?}*A*cos({:?}*t)\"\n\
         [[contact]]\nname = \"anvil\"\ngap = \"x\"\nimpulse = {{ v = 1 }}\nrestitution = 0.75\n\
         [initial]\nx = {:?}\nv = 0\n",
        0.3 * stiff,
        0.05 / short,
        0.02 * stiff / long / long,
        0.7 / short,
        0.1 * long,
    )
}

/// Where motions leave the domain the others are still searched, and these values told. Border, and the values from which on all escape,
/// are those of integrations by DOP853.
#[test]
fn values_that_cannot_be_followed_are_told_beside_borders() {
    const BORDER: f64 = 1.361_454_882_87;
    for units in [(1.0, 1.0), (1e-3, 1e-2), (1e3, 60.0)] {
        let text = escaping(units);
        let found = found(&text, "A", (1.3, 2.3), 20);
        let is_there = |at: &Border<f64>| (at.value.value - BORDER).abs() < 2e-11;
        assert!(
            found.borders.iter().any(is_there),
            "{units:?}: {:?}",
            found.breaks
        );
        let left = |at: &Unfollowed| matches!(at.error, FlowError::LeftDomain { .. });
        assert!(found.unfollowed.iter().all(left));
        let values: Vec<f64> = found.unfollowed.iter().map(|at| at.value).collect();
        assert!(
            values.is_sorted() && values[0] > 1.7,
            "{units:?}: {values:?}"
        );
        let [.., a, b, c] = values[..] else {
            panic!("{units:?}: {values:?}")
        };
        for (value, expected) in [(a, 2.2), (b, 2.25), (c, 2.3)] {
            assert!((value - expected).abs() < 1e-12, "{units:?}: {values:?}");
        }
        // Where nothing can be followed there is no answer.
        let model = read(&text);
        let mut spec = BorderSpec::new("A");
        spec.samples = 4;
        let error = borders_in::<f64>(&model, &spec, 2.2, 2.3).unwrap_err();
        let is_said = matches!(
            &error,
            BorderError::Lacks {
                what: Lack::Motion(FlowError::LeftDomain { .. }),
                ..
            }
        );
        assert!(is_said, "{error}");
    }
}
