//! What the command line asks for, as a diagram to be computed.

use super::arguments::{Arguments, RecordOption};
use crate::diagram::{Job, Order};
use crate::failure::Failure;
use crate::options::{
    Assignment, AtOption, Count, Initial, Loaded, ModelOptions, StartOption, SweepOption,
};
use chatter::analysis::diagram::{Bounds, Exponent, Observed, Range, Record, Spec, Start, Swept};
use chatter::analysis::return_map::{ReturnSpec, Sampling};
use chatter::analysis::simulate::EventKind;
use chatter::model::Model;
use std::path::Path;

/// What the command line asks for.
pub fn order(arguments: &Arguments) -> Result<Order, Failure> {
    let name = arguments.model.clone().unwrap_or_default();
    let fixed = Fixed::new(arguments);
    let options = ModelOptions {
        model: name.clone(),
        set: fixed.set.clone(),
    };
    let Loaded {
        mut model,
        text,
        data_files,
    } = options.load()?;
    fixed.initial.apply(&mut model)?;
    let pairs = |assignments: &[Assignment]| assignments.iter().map(Assignment::pair).collect();
    let job = Job {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        model: file_name(&name),
        set: pairs(&fixed.set),
        initial: pairs(&fixed.initial.initial),
        returns: returns(arguments, &mut model)?,
        diagram: specification(arguments, &fixed, &mut model)?,
        data_files,
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

/// Single values: beside a sweep they are set, without one each is a sweep.
fn single(arguments: &Arguments) -> impl Iterator<Item = &SweepOption> {
    arguments.at.iter().filter_map(|at| match at {
        AtOption::Value(value) => Some(value),
        AtOption::Event { .. } => None,
    })
}

/// What is not swept.
struct Fixed {
    set: Vec<Assignment>,
    initial: Initial,
}

impl Fixed {
    fn new(arguments: &Arguments) -> Self {
        let mut fixed = Self {
            set: arguments.set.clone(),
            initial: arguments.initial.clone(),
        };
        if !arguments.sweep.is_empty() {
            for (swept, assignment) in single(arguments).map(SweepOption::assignment) {
                match swept {
                    Swept::Parameter => fixed.set.push(assignment),
                    Swept::Initial => fixed.initial.initial.push(assignment),
                }
            }
        }
        fixed
    }
}

fn returns(arguments: &Arguments, model: &mut Model) -> Result<ReturnSpec, Failure> {
    let section = |name: &str| Sampling::Event {
        kind: EventKind::Section,
        at: Some(name.to_owned()),
    };
    let mut events = arguments.at.iter().filter_map(|at| match at {
        AtOption::Event { kind, name } => Some((*kind, name)),
        AtOption::Value(_) => None,
    });
    let at = events.next();
    if let Some((kind, _)) = at
        && (arguments.section.is_some() || arguments.period.is_some() || events.next().is_some())
    {
        return Err(Failure::input(format!(
            "orbits cannot be sampled in two ways: give --at {kind} alone, without --section, --period or another event"
        )));
    }
    let sampling = match (&arguments.section, at, &arguments.period) {
        (Some(name), ..) => section(name),
        (_, Some((kind, name)), _) => Sampling::Event {
            kind,
            at: name.clone(),
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

/// What is swept.
fn ranges(arguments: &Arguments, fixed: &Fixed, model: &mut Model) -> Result<Vec<Range>, Failure> {
    let options: Vec<&SweepOption> = match &arguments.sweep[..] {
        [] => single(arguments).collect(),
        sweeps => sweeps.iter().collect(),
    };
    if options.is_empty() {
        return Err(Failure::input("nothing is swept")
            .help("add --sweep NAME=FROM:TO:COUNT, or --at NAME=VALUE for one value"));
    }
    let mut sweeps = Vec::new();
    for option in options {
        sweeps.push(option.range(model)?);
    }
    for range in &sweeps {
        let name = &range.parameter;
        let (given, option) = match range.swept {
            Swept::Parameter => (&fixed.set, "--set"),
            Swept::Initial => (&fixed.initial.initial, "--initial"),
        };
        if given.iter().any(|one| one.pair().0 == *name) {
            return Err(Failure::input(format!(
                "`{name}` cannot be both set and swept: leave out {option} {name} or --sweep {}",
                match range.swept {
                    Swept::Parameter => name.clone(),
                    Swept::Initial => format!("initial:{name}"),
                }
            )));
        }
    }
    Ok(sweeps)
}

fn specification(arguments: &Arguments, fixed: &Fixed, model: &mut Model) -> Result<Spec, Failure> {
    let sweeps = ranges(arguments, fixed, model)?;
    if let (Some(_), [first, second, ..]) = (arguments.shear, &sweeps[..]) {
        return Err(Failure::input(format!(
            "--shear is about diagrams over one parameter; this is a map over `{}` and `{}`",
            first.name(),
            second.name()
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
            Some(StartOption::CarryUp | StartOption::CarryDown | StartOption::CarryBoth)
        )
    {
        return Err(
            Failure::input("--chunk is about carried states, and none is carried")
                .help("add --start carry, carry:down or carry:both"),
        );
    }
    let start = match arguments.start {
        None | Some(StartOption::Fresh) => Start::Fresh,
        Some(StartOption::CarryUp) => Start::CarryUp,
        Some(StartOption::CarryDown) => Start::CarryDown,
        Some(StartOption::CarryBoth) => Start::CarryBoth,
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
