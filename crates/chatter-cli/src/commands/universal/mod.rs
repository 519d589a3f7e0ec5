//! `chatter universal`: the universal map of chatter near a border orbit.

mod arguments;
mod atlas;
mod figure;

pub use arguments::Arguments;

use crate::accounts::universal::account;
use crate::diagram::{Store, check_size};
use crate::failure::{self, Failure};
use crate::numbers::Digits;
use crate::options::{FigureFile, SweepOption, TableFile};
use crate::terminal::{self, Progress, Style, Waiting};
use crate::universal::{Findings, UniversalJob, document, table};
use atlas::Atlas;
use chatter::analysis::diagram::{
    self, Exponent, Row, Spec, Standing, Start, Sweep, Swept, Threads,
};
use chatter::analysis::map::Map;
use chatter::analysis::universal::{Argument, Universal, UniversalError, UniversalMap};
use chatter::numerics::{DoubleDouble, Real};
use core::ops::ControlFlow;
use figure::figure;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let digits = arguments
        .digits
        .map_or(Digits::DOUBLE, |precision| precision.0);
    terminal::end_on_interrupt();
    let answer = if digits.fit_double() {
        find::<f64>(arguments, digits)?
    } else {
        find::<DoubleDouble>(arguments, digits)?
    };
    answer.print()?;
    Ok(failure::SUCCESS)
}

fn find<R: Real + Argument<Real = R>>(
    arguments: &Arguments,
    digits: Digits,
) -> Result<terminal::Answer, Failure> {
    let universal = Universal::<R>::new(arguments.restitution.get()).map_err(refused)?;
    let slope: R = arguments.slope.get();
    let double = Universal::<f64>::new(arguments.restitution.to_f64()).map_err(refused)?;
    let map = UniversalMap::new(
        double.clone(),
        arguments.slope.to_f64(),
        arguments.mu.to_f64(),
    )
    .map_err(refused)?;

    let mut diagram = match &arguments.sweep {
        Some(option) => {
            let job = UniversalJob {
                version: env!("CARGO_PKG_VERSION").to_owned(),
                restitution: arguments.restitution.to_f64(),
                slope: arguments.slope.to_f64(),
                mu: arguments.mu.to_f64(),
                diagram: specification(arguments, option)?,
            };
            let (map, sweep) = job.prepare()?;
            let (rows, store) = compute(&map, &sweep, &folder(arguments))?;
            Some((job, sweep, rows, store))
        }
        None => None,
    };
    let waiting = Waiting::new("finding windows");
    let values: Vec<(R, _)> = (arguments.at.iter())
        .map(|x| (x.get(), universal.at(x.get())))
        .collect();
    let atlas = Atlas::new(arguments)?;
    drop(waiting);
    let waiting = Waiting::new("writing");
    let mut samples = diagram.as_mut().and_then(|found| found.3.take());
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
            .map(|(_, sweep, rows, _)| (sweep, rows.as_slice())),
        digits,
    };
    let mut written = Vec::new();
    if let Some(TableFile(path)) = &arguments.out {
        let found = (diagram.as_ref().map(|found| &found.0)).zip(samples.as_mut());
        written.extend(table::write(&findings, found, path)?);
    }
    if let Some(FigureFile(path)) = &arguments.plot {
        let figure = figure(arguments, &findings, samples.as_mut(), &double, &map)?;
        figure
            .write(path)
            .map_err(|error| Failure::Output(error.to_string()))?;
        written.push(path.clone());
    }
    drop(waiting);
    if arguments.json {
        return Ok(terminal::Answer::Document(document(&findings)));
    }
    let mut text = account(&findings, Style::of_stdout());
    for path in &written {
        text += &format!("wrote {}\n", path.display());
    }
    Ok(terminal::Answer::Text(text))
}

/// The rows of the diagram without their samples, and on disk with them.
fn compute(
    map: &dyn Map,
    sweep: &Sweep,
    folder: &Path,
) -> Result<(Vec<Row>, Option<Store>), Failure> {
    check_size(sweep, true)?;
    let mut store = Store::scratch(folder, sweep)?;
    let mut rows = Vec::new();
    let mut progress = Progress::new();
    let mut broken = None;
    let spec = sweep.spec();
    let iterates = spec.transient.saturating_add(spec.keep) as f64;
    let began = Instant::now();
    let (standing, threads) = (Standing::default(), Threads::available());
    let stop = terminal::interrupt_flag();
    diagram::run(map, sweep, &standing, &threads, stop, &mut |mut row| {
        if let Err(error) = store.append(&row) {
            broken = Some(Failure::Output(error.to_string()));
            return ControlFlow::Break(());
        }
        row.samples = Vec::new();
        rows.push(row);
        let done = rows.len() as f64;
        progress.show(done / sweep.rows() as f64, || {
            let rate = done * iterates / began.elapsed().as_secs_f64();
            format!("{done} of {} orbits, {rate:.2e} iterates/s", sweep.rows())
        });
        ControlFlow::Continue(())
    });
    progress.finish();
    if let Some(failure) = broken {
        return Err(failure);
    }
    rows.sort_unstable_by_key(|row| row.row);
    Ok((rows, Some(store)))
}

/// Where samples are kept meanwhile: beside what is to be written, where there is room for as much.
fn folder(arguments: &Arguments) -> PathBuf {
    let out = arguments.out.as_ref().map(|file| &file.0);
    let file = out.or(arguments.plot.as_ref().map(|file| &file.0));
    match file.and_then(|file| file.parent()) {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_path_buf(),
        Some(_) => PathBuf::from("."),
        None => std::env::temp_dir(),
    }
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
