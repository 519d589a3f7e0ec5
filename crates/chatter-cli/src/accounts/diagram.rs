//! A diagram in a few lines.

use crate::diagram::tally::{Tally, percent};
use crate::diagram::{Hysteresis, Job, hysteresis};
use crate::numbers::concise;
use crate::terminal::Style;
use chatter::analysis::diagram::{Outcome, Range, Start, Sweep, Swept};
use chatter::analysis::return_map::Sampling;
use chatter::analysis::simulate::EventKind;
use chatter::model::Model;
use std::collections::{BTreeMap, BTreeSet};

/// What was computed and what it came to.
pub fn account(
    job: &Job,
    model: &Model,
    sweep: &Sweep,
    counts: &BTreeMap<Outcome, u64>,
    tally: Option<&Tally>,
    style: Style,
) -> String {
    let title = model.title.as_deref().unwrap_or(&job.model);
    let spec = &job.diagram;
    let mut text = format!("{}\n", style.title(title));
    for range in &spec.sweeps {
        let name = told(range);
        text += &match range.count {
            1 => format!("  {name} = {}\n", range.from),
            count => format!(
                "  {name} from {} to {}, {count} values\n",
                range.from, range.to
            ),
        };
    }
    let start = match &spec.start {
        Start::Fresh => "each from the initial state".to_owned(),
        Start::CarryUp => carried("upwards", sweep),
        Start::CarryDown => carried("downwards", sweep),
        Start::CarryBoth => carried("upwards and downwards", sweep),
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
    if let Some(tally) = tally {
        text += &attractors(sweep, tally);
    }
    text
}

/// What is swept, in words.
fn told(range: &Range) -> String {
    match range.swept {
        Swept::Parameter => range.parameter.clone(),
        Swept::Initial => format!("initial {}", range.parameter),
    }
}

fn carried(way: &str, sweep: &Sweep) -> String {
    match sweep.spec().chunk {
        Some(chunk) => format!("states carried {way} through {chunk} values at a time"),
        None => format!("states carried {way}"),
    }
}

/// Which attractors coexist, and where.
fn attractors(sweep: &Sweep, tally: &Tally) -> String {
    if let Some(found) = hysteresis(sweep, tally) {
        return told_hysteresis(&found, sweep);
    }
    let mut text = String::new();
    if sweep.groups() == 1 {
        for share in tally.shares.iter().filter(|share| share.attractor > 0) {
            let what = share.what().unwrap_or_default();
            let impacts = match share.impacts_per_return {
                Some(impacts) if impacts.is_finite() => format!(", impacts per return {impacts}"),
                _ => String::new(),
            };
            text += &format!(
                "  attractor {}: {what}{impacts}: {} of {} starts, {}\n",
                share.attractor,
                share.rows,
                tally.numbers.len(),
                percent(share.part)
            );
        }
        return text;
    }
    let most = tally.shares.last().map_or(0, |share| share.attractor);
    match most {
        0 | 1 => "  no attractors coexist\n".to_owned(),
        most => format!(
            "  attractors coexist: up to {most} at the same parameters, at {} of {} values\n",
            coexisting(sweep, tally),
            sweep.groups()
        ),
    }
}

/// At how many values of the parameters there are several attractors.
fn coexisting(sweep: &Sweep, tally: &Tally) -> usize {
    let mut found: BTreeMap<u64, BTreeSet<u32>> = BTreeMap::new();
    for (row, &number) in (0..).zip(&tally.numbers) {
        if number > 0 {
            found.entry(sweep.group(row)).or_default().insert(number);
        }
    }
    found.values().filter(|numbers| numbers.len() > 1).count()
}

/// More ranges than this are not listed.
const LISTED: usize = 6;

fn told_hysteresis(found: &Hysteresis, sweep: &Sweep) -> String {
    let range = &sweep.spec().sweeps[0];
    if found.values == 0 {
        return "  no hysteresis: both ways come to the same orbits\n".to_owned();
    }
    let told = |[from, to]: &[f64; 2]| match from == to {
        true => concise(*from, 6),
        false => format!("{} to {}", concise(*from, 6), concise(*to, 6)),
    };
    let where_ = match sweep.spec().sweeps.len() {
        1 => {
            let mut listed: Vec<String> = found.ranges.iter().take(LISTED).map(told).collect();
            if found.ranges.len() > LISTED {
                listed.push("…".to_owned());
            }
            format!(": {} = {}", range.parameter, listed.join(", "))
        }
        _ => String::new(),
    };
    format!(
        "  hysteresis at {} of {} values{where_}\n",
        found.values,
        sweep.groups()
    )
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
