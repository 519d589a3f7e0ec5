//! One state over time: bands for contact, ticks for impacts, discs for accumulations.

use super::shown::Shown;
use super::{Subject, add_curve, axis_of};
use chatter_figures::{Axis, Color, Legend, Line, Marker, Markers, Panel, Spans};

/// Room below and above the curve, as a part of its extent; ticks of impacts stand in the lower one.
const ROOM_BELOW: f64 = 0.10;
const ROOM_ABOVE: f64 = 0.06;
/// Height of a tick, as a part of the extent.
const TICK: f64 = 0.045;
/// More than these would merge into bars.
const MOST_TICKS: usize = 2000;
const MOST_DISCS: usize = 150;
const DISC: f64 = 3.2;

/// Bands of the contacts, in order; further ones start again.
const BANDS: [Color; 3] = [
    Color::rgb(196, 207, 222),
    Color::rgb(243, 205, 180),
    Color::rgb(190, 224, 205),
];

/// The history of state `index`.
pub fn panel(subject: &Subject, shown: &Shown, index: usize, with_legend: bool) -> Panel {
    let state = &subject.model.states[index];
    let values = &shown.states[index];
    let (low, high) = extent(values);
    let size = if high > low {
        high - low
    } else {
        low.abs().max(1.0)
    };
    let floor = low - ROOM_BELOW * size;
    let time = subject
        .model
        .time
        .and_then(|time| subject.model.states[time].label.as_ref());
    let x = match time {
        Some(label) => axis_of("t", Some(label)),
        None => Axis::new("time $t$"),
    };
    let y = axis_of(&state.name, state.label.as_ref());
    let mut panel = Panel::new(
        x.range(shown.from, shown.to),
        y.range(floor, high + ROOM_ABOVE * size),
    );
    for (contact, intervals) in shown.contact_phases.iter().enumerate() {
        if !intervals.is_empty() {
            let name = &subject.model.contacts[contact].name;
            panel.add(
                Spans::new(intervals.clone())
                    .color(BANDS[contact % BANDS.len()])
                    .label(format!("contact: {name}")),
            );
        }
    }
    if (1..=MOST_TICKS).contains(&shown.impacts.len()) {
        let impacts = shown.impacts.iter();
        let x = impacts
            .clone()
            .flat_map(|&time| [time, time, f64::NAN])
            .collect();
        let y = impacts
            .flat_map(|_| [floor, floor + TICK * size, f64::NAN])
            .collect();
        panel.add(
            Line::new(x, y)
                .color(Color::VERMILION)
                .width(0.5)
                .label("impact"),
        );
    }
    add_curve(&mut panel, &shown.jumps, &shown.times, values);
    if (1..=MOST_DISCS).contains(&shown.accumulations.len()) {
        let accumulations = shown.accumulations.iter();
        let (x, y) = accumulations
            .map(|(time, state)| (*time, state[index]))
            .unzip();
        let discs = Markers::new(x, y)
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

fn extent(values: &[f64]) -> (f64, f64) {
    let finite = values.iter().filter(|value| value.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &value| {
        (low.min(value), high.max(value))
    });
    if low <= high { (low, high) } else { (0.0, 1.0) }
}
