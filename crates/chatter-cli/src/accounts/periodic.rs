//! Periodic orbits and branches as text.

use crate::aligned::{Side, aligned};
use crate::failure::Failure;
use crate::numbers::{Digits, concise, full as to_digits};
use crate::terminal::Style;
use chatter::analysis::periodic::{Branch, End, Orbit, Point, Special, SpecialKind};
use chatter::numerics::{Complex, Real};
use chatter_work::periodic::{Subject, arcs, events_of};

/// Digits of numbers in tables.
const DIGITS: u32 = 10;
/// Multipliers that are told one by one.
const MOST_TOLD: usize = 6;

fn full(value: f64) -> String {
    to_digits(value, Digits::DOUBLE)
}

fn title(subject: &Subject, style: Style) -> String {
    let title = subject.model.title.as_deref().unwrap_or(subject.source);
    format!("{}  {}\n", style.title(title), style.faint(subject.source))
}

fn complex(value: &Complex, digits: u32) -> String {
    if value.im == 0.0 {
        return concise(value.re, digits);
    }
    let sign = if value.im < 0.0 { '-' } else { '+' };
    format!(
        "{} {sign} {}i",
        concise(value.re, digits),
        concise(value.im.abs(), digits)
    )
}

fn multipliers(values: &[Complex], digits: u32) -> String {
    let mut told: Vec<String> = values
        .iter()
        .take(MOST_TOLD)
        .map(|m| complex(m, digits))
        .collect();
    if values.len() > MOST_TOLD {
        told.push(format!("and {} smaller", values.len() - MOST_TOLD));
    }
    told.join(", ")
}

/// Orbits, one after the other.
pub fn orbits(subject: &Subject, orbits: &[Orbit], style: Style) -> Result<String, Failure> {
    let mut text = title(subject, style);
    if orbits.is_empty() {
        text += "no periodic orbit was found\n";
    }
    for orbit in orbits {
        text += "\n";
        text += &one(subject, orbit)?;
    }
    Ok(text)
}

fn one(subject: &Subject, orbit: &Orbit) -> Result<String, Failure> {
    let names = subject.model.state_names();
    let digits = subject.digits.0.clamp(DIGITS, 30);
    let number = |value: chatter::numerics::DoubleDouble| {
        if digits > 17 {
            chatter_work::numbers::significant(value, digits)
        } else {
            full(value.to_f64())
        }
    };
    let events = events_of(subject, orbit)?;
    let mut rows: Vec<Vec<String>> = vec![
        vec!["period".to_owned(), number(orbit.period)],
        vec![
            "impacts".to_owned(),
            match orbit.impacts {
                Some(count) => format!("{count} a period"),
                None => "infinitely many: complete chatter".to_owned(),
            },
        ],
        vec![
            "stability".to_owned(),
            if orbit.is_stable() {
                "stable"
            } else if orbit.is_neutral() {
                "neutral: multipliers on the unit circle, as far as they are known"
            } else {
                "unstable"
            }
            .to_owned(),
        ],
        vec![
            "multipliers".to_owned(),
            multipliers(&orbit.multipliers, DIGITS),
        ],
    ];
    if let Some(trivial) = orbit.trivial_multiplier {
        rows.push(vec!["along the flow".to_owned(), full(trivial)]);
    }
    let place = match orbit.section {
        Some(section) => format!("at section {}", subject.model.sections[section].name),
        None => "at its start".to_owned(),
    };
    let state: Vec<String> = names
        .iter()
        .zip(&orbit.start)
        .map(|(name, &x)| format!("{name} = {}", number(x)))
        .collect();
    rows.push(vec![place, state.join(", ")]);
    let mut kinds: Vec<(&str, usize)> = Vec::new();
    for event in &events {
        let name = event.kind.name();
        match kinds.iter_mut().find(|(known, _)| *known == name) {
            Some((_, count)) => *count += 1,
            None => kinds.push((name, 1)),
        }
    }
    let kinds: Vec<String> = kinds
        .iter()
        .map(|(name, count)| format!("{count} {name}"))
        .collect();
    rows.push(vec!["events".to_owned(), kinds.join(", ")]);
    for margin in &orbit.margins {
        rows.push(vec![
            margin.kind.name().replace('_', " "),
            format!(
                "{} at {}, time {}",
                concise(margin.value, DIGITS),
                subject.place(margin.guard),
                concise(margin.time, DIGITS)
            ),
        ]);
    }
    rows.push(vec![
        "residual".to_owned(),
        format!("{:.1e}", orbit.residual),
    ]);
    Ok(aligned(&rows, &[Side::Left, Side::Left]))
}

/// Branches with their special points.
pub fn branches(subject: &Subject, branches: &[Branch], style: Style) -> String {
    let named: Vec<(String, &Branch)> = (branches.iter().enumerate())
        .map(|(index, branch)| (format!("branch {}", index + 1), branch))
        .collect();
    title(subject, style) + &listed(subject, &named)
}

/// Curves of special points in two parameters.
pub fn curves(subject: &Subject, curves: &[(SpecialKind, Branch)], style: Style) -> String {
    let named: Vec<(String, &Branch)> = (curves.iter())
        .map(|(kind, curve)| (format!("curve of {}", kind.name().replace('_', " ")), curve))
        .collect();
    title(subject, style) + &listed(subject, &named)
}

fn listed(subject: &Subject, branches: &[(String, &Branch)]) -> String {
    let mut text = String::new();
    let name = subject
        .names()
        .last()
        .copied()
        .unwrap_or_default()
        .to_owned();
    for (heading, branch) in branches {
        let values = || branch.points.iter().map(Point::parameter);
        let low = values().fold(f64::INFINITY, f64::min);
        let high = values().fold(f64::NEG_INFINITY, f64::max);
        let of = |which: fn(&Point) -> bool| branch.points.iter().filter(|p| which(p)).count();
        let mut stability = format!("{} of them stable", of(Point::is_stable));
        let neutral = of(Point::is_neutral);
        // All orbits on a curve of folds, say, are.
        let is_branch = branch.points.iter().all(|p| p.parameters.len() == 1);
        if neutral > 0 && is_branch {
            stability += &format!(" and {neutral} neutral");
        }
        let ends = match &branch.ends {
            // It has no ends but this one.
            [End::Closed, End::Closed] => End::Closed.to_string(),
            [first, last] => format!("{first}; {last}"),
        };
        text += &format!(
            "\n{}: {} orbits, {stability}, {name} from {} to {}\n  ends: {ends}\n",
            heading,
            branch.points.len(),
            concise(low, DIGITS),
            concise(high, DIGITS)
        );
        if branch.special.is_empty() {
            continue;
        }
        // The parameter of the sweep first.
        let names = subject.names().into_iter().rev();
        let heading = (core::iter::once("kind").chain(names)).chain([
            "error",
            "impacts",
            "period",
            "multipliers",
        ]);
        let mut rows: Vec<Vec<String>> = vec![heading.map(str::to_owned).collect()];
        rows.extend((branch.special.iter()).map(|special| row(subject, special)));
        let mut sides = vec![Side::Left; 1 + subject.free.len()];
        sides.extend([Side::Right, Side::Right, Side::Left, Side::Left]);
        text += &aligned(&rows, &sides);
        text += &by_impacts(branch, &name);
    }
    for (index, function) in subject.monitors.iter().enumerate() {
        let points = || branches.iter().flat_map(|(_, branch)| &branch.points);
        let has_value = |point: &Point| point.monitors.get(index).is_some_and(|x| x.is_finite());
        if points().next().is_some() && !points().any(has_value) {
            text += &format!("\n`{function}` has no value at any of these orbits\n");
        }
    }
    text
}

/// The arcs of a branch that has several.
fn by_impacts(branch: &Branch, name: &str) -> String {
    let arcs = arcs(branch);
    if arcs.len() < 2 {
        return String::new();
    }
    let heading = [
        "arc",
        "impacts",
        &format!("{name} from"),
        "to",
        "orbits",
        "special points",
    ];
    let mut rows: Vec<Vec<String>> = vec![heading.map(str::to_owned).to_vec()];
    for (index, arc) in arcs.iter().enumerate() {
        let mut kinds: Vec<(&str, usize)> = Vec::new();
        for special in arc.special.iter().map(|&place| &branch.special[place]) {
            let kind = if special.kind.is_graze() {
                "graze"
            } else {
                special.kind.name()
            };
            match kinds.iter_mut().find(|(known, _)| *known == kind) {
                Some((_, count)) => *count += 1,
                None => kinds.push((kind, 1)),
            }
        }
        let special: Vec<String> = (kinds.iter())
            .map(|(kind, count)| format!("{count} {}", kind.replace('_', " ")))
            .collect();
        rows.push(vec![
            (index + 1).to_string(),
            arc.impacts
                .map_or("infinite".to_owned(), |count| count.to_string()),
            concise(arc.range.0, DIGITS),
            concise(arc.range.1, DIGITS),
            (arc.points.1 - arc.points.0).to_string(),
            special.join(", "),
        ]);
    }
    let sides = [
        Side::Right,
        Side::Right,
        Side::Left,
        Side::Left,
        Side::Right,
        Side::Left,
    ];
    aligned(&rows, &sides)
}

fn row(subject: &Subject, special: &Special) -> Vec<String> {
    let point = &special.point;
    let mut kind = special.kind.name().replace('_', " ");
    if let Some(function) = special
        .monitor
        .and_then(|index| subject.monitors.get(index))
    {
        kind += &format!(" {function}");
    }
    if special.persists == Some(false) {
        kind += ", turns back";
    }
    match (special.kind, special.above) {
        (SpecialKind::PeriodDoubling, Some(true)) => kind += ", doubled above",
        (SpecialKind::PeriodDoubling, Some(false)) => kind += ", doubled below",
        _ => {}
    }
    let mut row = vec![kind];
    row.extend(point.parameters.iter().rev().map(|&value| full(value)));
    row.extend([
        format!("{:.0e}", special.error),
        point
            .impacts
            .map_or("infinite".to_owned(), |count| count.to_string()),
        concise(point.period, DIGITS),
        multipliers(&point.multipliers, 6),
    ]);
    row
}
