//! The rates of impacts in logarithmic scale: complete chatter is a straight line.

use super::super::rates;
use super::history::time_axis;
use super::shown::Shown;
use super::wanted::Along;
use super::{Record, Subject};
use crate::refusal::Refusal;
use chatter::analysis::simulate::EventKind;
use chatter::flow::Place;
use chatter::numerics::Real;
use chatter_figures::{Axis, Legend, Marker, Markers, PALETTE, Panel};

const DISC: f64 = 2.2;

/// The rates before the impacts that are shown, over their numbers or times.
pub fn panel<R: Real>(
    subject: &Subject,
    record: &Record<R>,
    shown: &Shown,
    over: Along,
) -> Result<Panel, Refusal> {
    let contacts = &subject.model.contacts;
    let mut points = vec![(Vec::new(), Vec::new()); contacts.len()];
    let mut number = 0;
    for noted in record.events() {
        let event = noted?.event;
        let time = event.time.to_f64();
        let (EventKind::Impact, Some(Place::Contact(contact)), true) = (
            event.kind,
            event.detail.place(),
            (shown.from..=shown.to).contains(&time),
        ) else {
            continue;
        };
        number += 1;
        let (x, y) = &mut points[contact];
        x.push(match over {
            Along::Number => f64::from(number),
            Along::Time => time,
        });
        y.push(-rates(&event)[0]);
    }
    let across = match over {
        Along::Number => Axis::new("number of the impact").whole(),
        Along::Time => time_axis(subject),
    };
    let mut panel = Panel::new(across, Axis::new("rate before impact").logarithmic());
    for (contact, (x, y)) in points.into_iter().enumerate() {
        if x.is_empty() {
            continue;
        }
        let color = PALETTE[contact % PALETTE.len()];
        let marks = Markers::new(x, y).marker(Marker::Disc);
        panel.add(marks.size(DISC).color(color).label(&contacts[contact].name));
    }
    Ok(panel.legend(match contacts.len() {
        1 => Legend::Hidden,
        _ => Legend::Above,
    }))
}
