//! The phase portrait: gap against rate of the only contact, else the first two states.

use super::shown::Shown;
use super::side::{Quantity, Side};
use super::{Subject, add_curve};
use crate::refusal::Refusal;
use chatter_figures::{Color, Legend, Marker, Markers, Panel};

const DISC: f64 = 3.2;

/// The portrait; none where there is but one state.
pub fn panel(subject: &Subject, shown: &Shown) -> Result<Option<Panel>, Refusal> {
    let quantities = match subject.model.contacts[..] {
        [_] => Some((Quantity::Gap(0), Quantity::Rate(0))),
        _ => {
            let mut states = subject.states().map(Quantity::State);
            states.next().zip(states.next())
        }
    };
    let Some((x, y)) = quantities else {
        return Ok(None);
    };
    let sides = (Side::new(subject, shown, x)?, Side::new(subject, shown, y)?);
    Ok(Some(of(shown, sides)))
}

/// One quantity against another.
pub fn of(shown: &Shown, (x, y): (Side, Side)) -> Panel {
    let mut panel = Panel::new(x.axis, y.axis);
    add_curve(&mut panel, &shown.jumps, &x.values, &y.values);
    if !x.marks.is_empty() {
        let discs = Markers::new(x.marks, y.marks).marker(Marker::Disc);
        panel.add(discs.size(DISC).color(Color::INK));
    }
    panel.legend(Legend::Hidden)
}
