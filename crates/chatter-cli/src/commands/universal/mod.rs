//! `chatter universal`: the universal map of chatter near a border orbit.

mod arguments;
mod atlas;
mod figure;

pub use arguments::Arguments;

use crate::failure::{self, Failure};
use crate::numbers::Digits;
use crate::options::{FigureFile, SweepOption, TableFile};
use crate::terminal::{self, Style};
use crate::universal::{Findings, UniversalJob, account, document, table};
use atlas::Atlas;
use chatter::analysis::diagram::{self, Exponent, Spec, Start, Swept, Threads};
use chatter::analysis::universal::{Argument, Universal, UniversalError, UniversalMap};
use chatter::numerics::{DoubleDouble, Real};
use figure::figure;

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let digits = arguments
        .digits
        .map_or(Digits::DOUBLE, |precision| precision.0);
    let text = if digits.fit_double() {
        find::<f64>(arguments, digits)?
    } else {
        find::<DoubleDouble>(arguments, digits)?
    };
    terminal::print(&text).map_err(Failure::Output)?;
    Ok(failure::SUCCESS)
}

fn find<R: Real + Argument<Real = R>>(
    arguments: &Arguments,
    digits: Digits,
) -> Result<String, Failure> {
    let universal = Universal::<R>::new(arguments.restitution.get()).map_err(refused)?;
    let slope: R = arguments.slope.get();
    let double = Universal::<f64>::new(arguments.restitution.to_f64()).map_err(refused)?;
    let map = UniversalMap::new(
        double.clone(),
        arguments.slope.to_f64(),
        arguments.mu.to_f64(),
    )
    .map_err(refused)?;

    let diagram = match &arguments.sweep {
        Some(option) => {
            let job = UniversalJob {
                version: env!("CARGO_PKG_VERSION").to_owned(),
                restitution: arguments.restitution.to_f64(),
                slope: arguments.slope.to_f64(),
                mu: arguments.mu.to_f64(),
                diagram: specification(arguments, option)?,
            };
            let (map, sweep) = job.prepare()?;
            let rows = diagram::diagram(&map, &job.diagram, &Threads::available())
                .map_err(Failure::input)?;
            Some((job, sweep, rows))
        }
        None => None,
    };
    let values: Vec<(R, _)> = (arguments.at.iter())
        .map(|x| (x.get(), universal.at(x.get())))
        .collect();
    let atlas = Atlas::new(arguments)?;
    let findings = Findings {
        universal: &universal,
        slope,
        values: (!values.is_empty()).then_some(values),
        windows: atlas.windows,
        scaling: atlas.scaling,
        sheets: atlas.sheets,
        periodic: atlas.periodic,
        undecided: atlas.undecided,
        diagram: diagram
            .as_ref()
            .map(|(_, sweep, rows)| (sweep, rows.as_slice())),
        digits,
    };
    let mut written = Vec::new();
    if let Some(TableFile(path)) = &arguments.out {
        written.extend(table::write(
            &findings,
            diagram.as_ref().map(|found| &found.0),
            path,
        )?);
    }
    if let Some(FigureFile(path)) = &arguments.plot {
        let figure = figure(arguments, &findings, &double, &map)?;
        figure
            .write(path)
            .map_err(|error| Failure::Output(error.to_string()))?;
        written.push(path.clone());
    }
    if arguments.json {
        return Ok(document(&findings));
    }
    let mut text = account(&findings, Style::of_stdout());
    for path in &written {
        text += &format!("wrote {}\n", path.display());
    }
    Ok(text)
}

fn specification(arguments: &Arguments, sweep: &SweepOption) -> Result<Spec, Failure> {
    let range = sweep.plain()?;
    Ok(Spec {
        start: match range.swept {
            Swept::Parameter => Start::CarryUp,
            Swept::Initial => Start::Fresh,
        },
        chunk: Some(Spec::quick_chunk(range.count)),
        exponent: if arguments.lyapunov {
            Exponent::Largest
        } else {
            Exponent::Skip
        },
        ..Spec::new(range, "z", arguments.transient, arguments.keep)
    })
}

fn refused(error: UniversalError) -> Failure {
    Failure::input(error)
}
