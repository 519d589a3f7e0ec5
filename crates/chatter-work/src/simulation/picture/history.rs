//! A quantity over time: bands for contact, ticks for impacts, discs for accumulations.

use super::shown::Shown;
use super::side::Side;
use super::{Subject, add_curve, axis_of};
use chatter_figures::{Axis, Color, Legend, Line, Marker, Markers, PALETTE, Panel, Spans};

/// Room below and above the curve, as a part of its extent; ticks of impacts stand in the lower one.
const ROOM_BELOW: f64 = 0.10;
const ROOM_ABOVE: f64 = 0.06;
/// Height of a tick, as a part of the extent.
const TICK: f64 = 0.045;
/// More than these would merge into bars.
const MOST_TICKS: usize = 2000;
const MOST_DISCS: usize = 150;
const DISC: f64 = 3.2;

/// Opacity of bands: where two contacts are closed both are seen.
const BAND: f64 = 0.3;

/// The band and the ticks of a contact: of several each has its colour.
fn colors(contact: usize, contacts: usize) -> (Color, Color) {
    // The first colour is the curve's.
    let own = PALETTE[(contact + 1) % PALETTE.len()];
    match contacts {
        1 => (Color::rgb(196, 207, 222), Color::VERMILION),
        _ => (own.opacity(BAND), own),
    }
}

/// The history of a quantity.
pub fn panel(subject: &Subject, shown: &Shown, side: Side, with_legend: bool) -> Panel {
    let values = &side.values;
    let (low, high) = extent(values);
    let size = if high > low {
        high - low
    } else {
        low.abs().max(1.0)
    };
    let floor = low - ROOM_BELOW * size;
    let mut panel = Panel::new(
        time_axis(subject).range(shown.from, shown.to),
        side.axis.range(floor, high + ROOM_ABOVE * size),
    );
    let contacts = &subject.model.contacts;
    for (contact, intervals) in shown.contact_phases.iter().enumerate() {
        if !intervals.is_empty() {
            panel.add(
                Spans::new(intervals.clone())
                    .color(colors(contact, contacts.len()).0)
                    .label(format!("contact: {}", contacts[contact].name)),
            );
        }
    }
    let count: usize = shown.impacts.iter().map(Vec::len).sum();
    for (contact, impacts) in shown.impacts.iter().enumerate() {
        if impacts.is_empty() || count > MOST_TICKS {
            continue;
        }
        let impacts = impacts.iter();
        let x = impacts
            .clone()
            .flat_map(|&time| [time, time, f64::NAN])
            .collect();
        let y = impacts
            .flat_map(|_| [floor, floor + TICK * size, f64::NAN])
            .collect();
        let label = match contacts.len() {
            1 => "impact".to_owned(),
            _ => format!("impact: {}", contacts[contact].name),
        };
        panel.add(
            Line::new(x, y)
                .color(colors(contact, contacts.len()).1)
                .width(0.5)
                .label(label),
        );
    }
    add_curve(&mut panel, &shown.jumps, &shown.times, values);
    if (1..=MOST_DISCS).contains(&shown.accumulations.len()) {
        let times = shown.accumulations.iter().map(|(time, _)| *time);
        let discs = Markers::new(times.collect(), side.marks)
            .marker(Marker::Disc)
            .size(DISC)
            .color(Color::INK);
        panel.add(discs.label("accumulation"));
    }
    panel.legend(if with_legend {
        Legend::Above
    } else {
        Legend::Hidden
    })
}

/// The axis of time.
pub fn time_axis(subject: &Subject) -> Axis {
    let states = &subject.model.states;
    let label = (subject.model.time).and_then(|time| states[time].label.as_ref());
    match label {
        Some(label) => axis_of("t", Some(label)),
        None => Axis::new("time $t$"),
    }
}

fn extent(values: &[f64]) -> (f64, f64) {
    let finite = values.iter().filter(|value| value.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &value| {
        (low.min(value), high.max(value))
    });
    if low <= high { (low, high) } else { (0.0, 1.0) }
}
