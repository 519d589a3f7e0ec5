//! What the command line asks for, as a diagram to be computed.

use super::arguments::{Arguments, RecordOption};
use crate::diagram::{Job, Order};
use crate::failure::Failure;
use crate::options::{Assignment, Count, Loaded, ModelOptions, StartOption};
use chatter::analysis::diagram::{Bounds, Exponent, Observed, Record, Spec, Start};
use chatter::analysis::return_map::{ReturnSpec, Sampling};
use chatter::analysis::simulate::EventKind;
use chatter::model::Model;
use std::path::Path;

/// What the command line asks for.
pub fn order(arguments: &Arguments) -> Result<Order, Failure> {
    let name = arguments.model.clone().unwrap_or_default();
    let options = ModelOptions {
        model: name.clone(),
        set: arguments.set.clone(),
    };
    let Loaded { mut model, text } = options.load()?;
    arguments.initial.apply(&mut model)?;
    let pairs = |assignments: &[Assignment]| assignments.iter().map(Assignment::pair).collect();
    let job = Job {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        model: file_name(&name),
        set: pairs(&arguments.set),
        initial: pairs(&arguments.initial.initial),
        returns: returns(arguments, &mut model)?,
        diagram: specification(arguments, &mut model)?,
    };
    Ok(Order {
        job,
        model_text: text,
        out: arguments.out.as_ref().map(|file| file.0.clone()),
        plot: arguments.plot.as_ref().map(|file| file.0.clone()),
        shear: arguments.shear.map(|shear| shear.0),
    })
}

/// Without the folder: results do not depend on where a model's file was.
fn file_name(name: &str) -> String {
    let last = Path::new(name).file_name();
    last.map_or_else(
        || name.to_owned(),
        |last| last.to_string_lossy().into_owned(),
    )
}

fn returns(arguments: &Arguments, model: &mut Model) -> Result<ReturnSpec, Failure> {
    let section = |name: &str| Sampling::Event {
        kind: EventKind::Section,
        at: Some(name.to_owned()),
    };
    let sampling = match (&arguments.section, &arguments.at, &arguments.period) {
        (Some(name), ..) => section(name),
        (_, Some(at), _) => Sampling::Event {
            kind: at.kind,
            at: at.name.clone(),
        },
        (.., Some(period)) => Sampling::Stroboscopic {
            period: period.clone(),
        },
        (None, None, None) => match &model.sections[..] {
            [only] => section(&only.name),
            sections => {
                let names: Vec<&str> = sections.iter().map(|section| &*section.name).collect();
                let known = match &names[..] {
                    [] => "it has none".to_owned(),
                    names => format!("it has `{}`", names.join("`, `")),
                };
                return Err(Failure::input(format!(
                    "where are orbits to be sampled? The model has no single section to choose: {known}"
                ))
                .help("name a section with --section NAME, an event with --at impact, or a --period"));
            }
        },
    };
    let mut spec = ReturnSpec::new(sampling);
    if let Some(longest) = &arguments.longest_return {
        spec.longest_return = longest.value(model, "--longest-return")?.high();
    }
    if let Some(Count(most)) = arguments.most_impacts {
        spec.most_impacts = most;
    }
    if let Some(tolerance) = &arguments.tolerance {
        spec.tolerance = tolerance.value(model, "--tolerance")?.high();
    }
    Ok(spec)
}

/// Passed over and kept unless told otherwise.
const TRANSIENT: u64 = 300;
const KEEP: u64 = 200;

fn specification(arguments: &Arguments, model: &mut Model) -> Result<Spec, Failure> {
    let mut sweeps = Vec::new();
    for sweep in &arguments.sweep {
        sweeps.push(sweep.range(model)?);
    }
    if let Some(range) = sweeps.iter().find(|range| {
        let mut set = arguments.set.iter().map(Assignment::pair);
        set.any(|(name, _)| name == range.parameter)
    }) {
        let name = &range.parameter;
        return Err(Failure::input(format!(
            "`{name}` cannot be both set and swept: leave out --set {name} or --sweep {name}"
        )));
    }
    if let (Some(_), [first, second, ..]) = (arguments.shear, &sweeps[..]) {
        return Err(Failure::input(format!(
            "--shear is about diagrams over one parameter; this is a map over `{}` and `{}`",
            first.parameter, second.parameter
        )));
    }
    let mut bounds = Vec::new();
    for span in &arguments.bounds {
        let (from, to) = span.ends(model, "--box")?;
        let coordinate = span.name.clone();
        bounds.push(Bounds {
            coordinate,
            from,
            to,
        });
    }
    let random = matches!(arguments.start, Some(StartOption::Random(_)));
    if !random && (!bounds.is_empty() || arguments.seed.is_some()) {
        return Err(
            Failure::input("--box and --seed are about random starts, and there are none")
                .help("add --start random:COUNT"),
        );
    }
    if random && bounds.is_empty() {
        return Err(
            Failure::input("random starts need bounds to be drawn between")
                .help("add --box NAME=FROM:TO, once for each state that is to be drawn"),
        );
    }
    if arguments.chunk.is_some()
        && !matches!(
            arguments.start,
            Some(StartOption::CarryUp | StartOption::CarryDown)
        )
    {
        return Err(
            Failure::input("--chunk is about carried states, and none is carried")
                .help("add --start carry or --start carry-down"),
        );
    }
    let start = match arguments.start {
        None | Some(StartOption::Fresh) => Start::Fresh,
        Some(StartOption::CarryUp) => Start::CarryUp,
        Some(StartOption::CarryDown) => Start::CarryDown,
        Some(StartOption::Random(count)) => Start::Random {
            count,
            seed: arguments.seed.unwrap_or(0),
            bounds,
        },
    };
    let tolerance = match &arguments.period_tolerance {
        Some(tolerance) => tolerance.value(model, "--period-tolerance")?.high(),
        None => Spec::PERIOD_TOLERANCE,
    };
    let record = match arguments.record {
        Some(RecordOption::Samples) => Record::Samples,
        Some(RecordOption::Classes) => Record::Classes,
        None if sweeps.len() > 1 => Record::Classes,
        None => Record::Samples,
    };
    let number = |count: Option<Count>, usual: u64| count.map_or(usual, |count| count.0);
    let observe: Vec<Observed> = arguments.observe.iter().map(|one| one.0.clone()).collect();
    Ok(Spec {
        sweeps,
        observe,
        transient: arguments.transient.unwrap_or(TRANSIENT),
        keep: number(arguments.keep, KEEP),
        every: number(arguments.every, 1),
        start,
        chunk: arguments.chunk.map(|count| count.0),
        longest_period: number(arguments.longest_period, Spec::LONGEST_PERIOD),
        period_tolerance: tolerance,
        record,
        exponent: if arguments.exponent {
            Exponent::Largest
        } else {
            Exponent::Skip
        },
    })
}
