//! Complete chatter on a slider that each impact makes slip, and that friction holds again before it is struck next.

use crate::periodic::differences::{agree, differences};
use crate::periodic::{orbit, over, with};
use chatter::analysis::periodic::End;

/// A drill that is pushed against a slider held by dry friction, told by the gap between them. Something may feel how that slips, and act on the drill.
fn drill(push: &str, felt: f64) -> chatter::model::Model {
    let text = format!(
        "[parameters]\nw = 1.3344\nP = 0.45\nF = 0.4872\nz = 0.065\nm = 1.3547\nr = 0.4708\n[flight]\ng = 'q - y'\n\
         y = 'P + F*cos(w*t) - 2*z*y + {felt}*e'\nq = '-sign(q)/m'\ne = 'u'\nu = '-e - 0.3*u + 0.2*q'\n\
         [[contact]]\nname = 'bit'\ngap = 'g'\nimpulse = {{ y = -1, q = '1/m' }}\nrestitution = 'r'\n\
         [section.s]\nsurface = 'sin(w*t)'\ndirection = 'falling'\n[initial]\ng = 0.1\ny = 0\nq = 0\ne = 0\nu = 0\n"
    );
    with(&text, &[("P", push)])
}

#[test]
fn its_multipliers_are_those_of_differences() {
    for push in ["0.43", "0.45", "0.48"] {
        let model = drill(push, 0.05);
        let found = orbit(&model);
        assert_eq!(found.impacts, None, "{push}");
        agree(&found, &differences(&model, &found));
    }
}

/// From a push of 0.44373 on slips end before the next impact, late in the sequence first: chatter is complete to both sides, and nothing happens to the orbit.
/// The load turns, and so releases the drill, up to P = F.
#[test]
fn slips_that_end_in_flight_are_no_event_of_its_branch() {
    for start in ["0.442", "0.447"] {
        let found = over(&drill(start, 0.0), "P", (0.442, 0.447), (12, 0.05));
        let [branch] = &found[..] else {
            panic!("{start}: {} branches", found.len());
        };
        assert_eq!(branch.ends, [End::Range, End::Range], "{start}");
        assert!(branch.special.is_empty(), "{start}: {:?}", branch.special);
    }
}
