//! A diagram in a few lines.

use super::job::Job;
use crate::terminal::Style;
use chatter::analysis::diagram::{Outcome, Start, Sweep};
use chatter::analysis::return_map::Sampling;
use chatter::analysis::simulate::EventKind;
use chatter::model::Model;
use std::collections::BTreeMap;

/// What was computed and what it came to.
pub fn account(
    job: &Job,
    model: &Model,
    sweep: &Sweep,
    counts: &BTreeMap<Outcome, u64>,
    style: Style,
) -> String {
    let title = model.title.as_deref().unwrap_or(&job.model);
    let spec = &job.diagram;
    let mut text = format!("{}\n", style.title(title));
    for range in &spec.sweeps {
        text += &format!(
            "  {} from {} to {}, {} values\n",
            range.parameter, range.from, range.to, range.count
        );
    }
    let start = match &spec.start {
        Start::Fresh => "each from the initial state".to_owned(),
        Start::CarryUp => format!("states carried upwards in {} chunks", sweep.pieces()),
        Start::CarryDown => format!("states carried downwards in {} chunks", sweep.pieces()),
        Start::Random { count, seed, .. } => {
            format!("{count} random starts each (seed {seed})")
        }
    };
    text += &format!(
        "  {} samples after {} at {}, {start}\n",
        spec.keep,
        spec.transient,
        look(&job.returns.sampling, spec.every)
    );
    let parts: Vec<String> = counts
        .iter()
        .map(|(outcome, count)| format!("{count} {}", outcome.name().replace('_', " ")))
        .collect();
    text += &format!("  {}\n", parts.join(", "));
    text
}

fn look(sampling: &Sampling, every: u64) -> String {
    let what = match sampling {
        Sampling::Event { kind, at } => {
            let event = match kind {
                EventKind::Section => "crossing of a section".to_owned(),
                _ => kind.to_string(),
            };
            match (kind, at) {
                (_, None) => event,
                (EventKind::Section, Some(at)) => format!("crossing of section `{at}`"),
                (_, Some(at)) => format!("{event} at {at}"),
            }
        }
        Sampling::Stroboscopic { period } => format!("period of {period}"),
    };
    match every {
        1 => format!("each {what}"),
        _ => format!("every {} {what}", ordinal(every)),
    }
}

fn ordinal(number: u64) -> String {
    let ending = match (number % 10, number % 100) {
        (_, 11..=13) => "th",
        (1, _) => "st",
        (2, _) => "nd",
        (3, _) => "rd",
        _ => "th",
    };
    format!("{number}{ending}")
}

#[cfg(test)]
mod tests {
    use super::ordinal;

    #[test]
    fn ordinals_end_as_they_should() {
        let all = [1, 2, 3, 4, 11, 12, 13, 21, 22, 112].map(ordinal);
        let expected = "1st 2nd 3rd 4th 11th 12th 13th 21st 22nd 112th";
        assert_eq!(all.join(" "), expected);
    }
}
