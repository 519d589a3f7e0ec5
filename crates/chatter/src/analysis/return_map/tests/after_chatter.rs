//! Exponents of orbits with complete chatter, however many samples there are: what it forgets leaves nothing behind that would outlast the
//! rest.

use super::shipped;
use crate::analysis::diagram::{Exponent, Range, Spec, Threads, diagram};
use crate::analysis::return_map::{ReturnMap, ReturnSpec};
use crate::model::Model;
use core::f64::consts::TAU;

fn exponents(
    model: &Model,
    section: &str,
    (swept, observed): (Range, &str),
    keep: u64,
) -> Vec<f64> {
    let map = ReturnMap::new(model, &ReturnSpec::section(section)).unwrap();
    let mut spec = Spec::new(swept, observed, 100, keep);
    spec.exponent = Exponent::Largest;
    let rows = diagram(&map, &spec, &Threads::new(1)).unwrap();
    rows.iter().map(|row| row.exponent).collect()
}

/// A hammer that is forced and comes to rest in each period, in these units, with more equations.
fn hammer(more: &str, initial: &str, (long, short): (f64, f64)) -> Model {
    let text = format!(
        "[parameters]\nA = 1.25\nr = 0.75\nw = {:?}\ng = {:?}\n[flight]\nx = \"v\"\nv = \"g*(A*cos(w*t + 0.3) - 1)\"\n{more}\
         [[contact]]\nname = \"anvil\"\ngap = \"x\"\nimpulse = {{ v = 1 }}\nrestitution = \"r\"\n\
         [section.strobe]\nsurface = \"sin(w*t)\"\ndirection = \"rising\"\n[initial]\nx = {:?}\nv = 0\n{initial}",
        0.7 / short,
        long / short / short,
        0.1 * long,
    );
    Model::from_toml(&text, "hammer").unwrap()
}

const UNITS: [(f64, f64); 3] = [(1.0, 1.0), (1e-3, 1e-2), (1e3, 60.0)];

#[test]
fn what_complete_chatter_forgets_has_no_exponent_at_any_phase() {
    for units in UNITS {
        let swept = Range::linear("A", 1.05, 1.3, 6);
        for exponent in exponents(&hammer("", "", units), "strobe", (swept, "x"), 60) {
            assert_eq!(exponent, f64::NEG_INFINITY, "{units:?}");
        }
    }
    // At the section the follower rests where its cam does not move, so that its own rates are rounding.
    let swept = Range::linear("speed", 490.0, 515.0, 3);
    let model = shipped("cam_follower");
    for exponent in exponents(&model, "bottom", (swept, "v"), 20) {
        assert_eq!(exponent, f64::NEG_INFINITY);
    }
}

/// Something that the hammer drives, and that dies out by itself at a rate of 0.13: by 233 powers of e over these samples.
#[test]
fn what_dies_out_beside_complete_chatter_is_told_however_long_it_does() {
    for (long, short) in UNITS {
        let more = format!("p = \"x - {:?}*p\"\n", 0.13 / short);
        let model = hammer(&more, "p = 0\n", (long, short));
        for keep in [10, 200] {
            let swept = Range::linear("A", 1.25, 1.25, 1);
            let found = exponents(&model, "strobe", (swept, "p"), keep)[0];
            let off = found + 0.13 * TAU / 0.7;
            assert!(off.abs() < 1e-9, "{off:e} at {keep}, {long} {short}");
        }
    }
}
