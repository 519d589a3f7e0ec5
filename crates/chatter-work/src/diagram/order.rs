//! What is asked for, as a diagram to be computed.

use super::job::{Job, Order};
use super::picture::Shear;
use crate::options::{Assignment, AtOption, Count, Quantity, SpanOption, StartOption, SweepOption};
use crate::refusal::Refusal;
use crate::source::{Loaded, Source, set_initial, set_parameters};
use chatter::analysis::diagram::{Bounds, Exponent, Observed, Range, Record, Spec, Start, Swept};
use chatter::analysis::return_map::{ReturnSpec, Sampling};
use chatter::analysis::simulate::EventKind;
use chatter::model::Model;
use std::path::{Path, PathBuf};

/// What is asked for. What is none is as usual.
#[derive(Clone, Debug, Default)]
pub struct Request {
    /// Parameters set: name and expression.
    pub set: Vec<Assignment>,
    /// Initial values set: name and expression.
    pub initial: Vec<Assignment>,
    /// What is swept.
    pub sweeps: Vec<SweepOption>,
    /// The section at whose crossings orbits are sampled.
    pub section: Option<String>,
    /// The events at which orbits are sampled, and single values of parameters.
    pub at: Vec<AtOption>,
    /// The period after which orbits are sampled.
    pub period: Option<String>,
    /// Which of these samples are taken: every so many.
    pub every: Option<Count>,
    /// What is sampled.
    pub observe: Vec<Observed>,
    /// Samples passed over.
    pub transient: Option<u64>,
    /// Samples kept.
    pub keep: Option<Count>,
    /// Where orbits start.
    pub start: Option<StartOption>,
    /// Through how many values a state is carried.
    pub chunk: Option<Count>,
    /// Between which bounds random starts are drawn.
    pub bounds: Vec<SpanOption>,
    /// Of random starts.
    pub seed: Option<u64>,
    /// The longest period that is looked for.
    pub longest_period: Option<Count>,
    /// By how much samples a period apart may differ.
    pub period_tolerance: Option<Quantity>,
    /// Whether the largest Lyapunov exponent is computed.
    pub exponent: bool,
    /// What is kept.
    pub record: Option<Record>,
    /// Longest time of a return.
    pub longest_return: Option<Quantity>,
    /// Most impacts of a return.
    pub most_impacts: Option<Count>,
    /// Relative error of a step.
    pub tolerance: Option<Quantity>,
    /// The table to be written.
    pub out: Option<PathBuf>,
    /// The figure to be drawn.
    pub plot: Option<PathBuf>,
    /// How the vertical axis of the figure is sheared.
    pub shear: Option<Shear>,
}

impl Request {
    /// What is to be computed, of the model that comes from this source.
    ///
    /// # Errors
    /// The model is wrong, or what is asked does not fit it.
    pub fn order(&self, source: Source) -> Result<Order, Refusal> {
        let name = source.name.clone();
        let fixed = Fixed::new(self);
        let Loaded {
            mut model,
            text,
            data_files,
        } = source.load()?;
        set_parameters(&mut model, &fixed.set)?;
        set_initial(&mut model, &fixed.initial)?;
        let pairs = |assignments: &[Assignment]| assignments.iter().map(Assignment::pair).collect();
        let job = Job {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            model: file_name(&name),
            set: pairs(&fixed.set),
            initial: pairs(&fixed.initial),
            returns: returns(self, &mut model)?,
            diagram: specification(self, &fixed, &mut model)?,
            data_files,
        };
        Ok(Order {
            job,
            model_text: text,
            out: self.out.clone(),
            plot: self.plot.clone(),
            shear: self.shear,
        })
    }
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
fn single(request: &Request) -> impl Iterator<Item = &SweepOption> {
    request.at.iter().filter_map(|at| match at {
        AtOption::Value(value) => Some(value),
        AtOption::Event { .. } => None,
    })
}

/// What is not swept.
struct Fixed {
    set: Vec<Assignment>,
    initial: Vec<Assignment>,
}

impl Fixed {
    fn new(request: &Request) -> Self {
        let mut fixed = Self {
            set: request.set.clone(),
            initial: request.initial.clone(),
        };
        if !request.sweeps.is_empty() {
            for (swept, assignment) in single(request).map(SweepOption::assignment) {
                match swept {
                    Swept::Parameter => fixed.set.push(assignment),
                    Swept::Initial => fixed.initial.push(assignment),
                }
            }
        }
        fixed
    }
}

fn returns(request: &Request, model: &mut Model) -> Result<ReturnSpec, Refusal> {
    // The crossing of an event's surface is its reset.
    let is_event = |name: &str| {
        let section = model.section(name);
        section.is_some_and(|section| section.reset.is_some())
    };
    let section = |name: &str| Sampling::Event {
        kind: match is_event(name) {
            true => EventKind::Reset,
            false => EventKind::Section,
        },
        at: Some(name.to_owned()),
    };
    let mut events = request.at.iter().filter_map(|at| match at {
        AtOption::Event { kind, name } => Some((*kind, name)),
        AtOption::Value(_) => None,
    });
    let at = events.next();
    if let Some((kind, _)) = at
        && (request.section.is_some() || request.period.is_some() || events.next().is_some())
    {
        return Err(Refusal::input(format!(
            "orbits cannot be sampled in two ways: give --at {kind} alone, without --section, --period or another event"
        )));
    }
    let sampling = match (&request.section, at, &request.period) {
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
                return Err(Refusal::input(format!(
                    "where are orbits to be sampled? The model has no single section to choose: {known}"
                ))
                .help("name a section with --section NAME, an event with --at impact, or a --period"));
            }
        },
    };
    let mut spec = ReturnSpec::new(sampling);
    if let Some(longest) = &request.longest_return {
        spec.longest_return = longest.value(model, "--longest-return")?.high();
    }
    if let Some(Count(most)) = request.most_impacts {
        spec.most_impacts = most;
    }
    if let Some(tolerance) = &request.tolerance {
        spec.tolerance = tolerance.value(model, "--tolerance")?.high();
    }
    Ok(spec)
}

/// Passed over and kept unless told otherwise.
const TRANSIENT: u64 = 300;
const KEEP: u64 = 200;

/// What is swept.
fn ranges(request: &Request, fixed: &Fixed, model: &mut Model) -> Result<Vec<Range>, Refusal> {
    let options: Vec<&SweepOption> = match &request.sweeps[..] {
        [] => single(request).collect(),
        sweeps => sweeps.iter().collect(),
    };
    if options.is_empty() {
        return Err(Refusal::input("nothing is swept")
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
            Swept::Initial => (&fixed.initial, "--initial"),
        };
        if given.iter().any(|one| one.pair().0 == *name) {
            return Err(Refusal::input(format!(
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

fn specification(request: &Request, fixed: &Fixed, model: &mut Model) -> Result<Spec, Refusal> {
    let sweeps = ranges(request, fixed, model)?;
    if let (Some(_), [first, second, ..]) = (request.shear, &sweeps[..]) {
        return Err(Refusal::input(format!(
            "--shear is about diagrams over one parameter; this is a map over `{}` and `{}`",
            first.name(),
            second.name()
        )));
    }
    let mut bounds = Vec::new();
    for span in &request.bounds {
        let (from, to) = span.ends(model, "--box")?;
        let coordinate = span.name.clone();
        bounds.push(Bounds {
            coordinate,
            from,
            to,
        });
    }
    let random = matches!(request.start, Some(StartOption::Random(_)));
    if !random && (!bounds.is_empty() || request.seed.is_some()) {
        return Err(
            Refusal::input("--box and --seed are about random starts, and there are none")
                .help("add --start random:COUNT"),
        );
    }
    if random && bounds.is_empty() {
        return Err(
            Refusal::input("random starts need bounds to be drawn between")
                .help("add --box NAME=FROM:TO, once for each state that is to be drawn"),
        );
    }
    if request.chunk.is_some()
        && !matches!(
            request.start,
            Some(StartOption::CarryUp | StartOption::CarryDown | StartOption::CarryBoth)
        )
    {
        return Err(
            Refusal::input("--chunk is about carried states, and none is carried")
                .help("add --start carry, carry:down or carry:both"),
        );
    }
    let start = match request.start {
        None | Some(StartOption::Fresh) => Start::Fresh,
        Some(StartOption::CarryUp) => Start::CarryUp,
        Some(StartOption::CarryDown) => Start::CarryDown,
        Some(StartOption::CarryBoth) => Start::CarryBoth,
        Some(StartOption::Random(count)) => Start::Random {
            count,
            seed: request.seed.unwrap_or(0),
            bounds,
        },
    };
    let tolerance = match &request.period_tolerance {
        Some(tolerance) => tolerance.value(model, "--period-tolerance")?.high(),
        None => Spec::PERIOD_TOLERANCE,
    };
    let record = match request.record {
        Some(record) => record,
        None if sweeps.len() > 1 => Record::Classes,
        None => Record::Samples,
    };
    let number = |count: Option<Count>, usual: u64| count.map_or(usual, |count| count.0);
    let observe: Vec<Observed> = request.observe.clone();
    Ok(Spec {
        sweeps,
        observe,
        transient: request.transient.unwrap_or(TRANSIENT),
        keep: number(request.keep, KEEP),
        every: number(request.every, 1),
        start,
        chunk: request.chunk.map(|count| count.0),
        longest_period: number(request.longest_period, Spec::LONGEST_PERIOD),
        period_tolerance: tolerance,
        record,
        exponent: if request.exponent {
            Exponent::Largest
        } else {
            Exponent::Skip
        },
    })
}
