//! `chatter universal`: the universal map of chatter near a border orbit.

mod arguments;

pub use arguments::Arguments;

use crate::accounts::universal::account;
use crate::failure::{self, Failure};
use crate::numbers::Digits;
use crate::options::{FigureFile, TableFile};
use crate::terminal::{self, Console, Style, Waiting};
use crate::universal::{
    Atlas, Cobweb, Findings, Request, compute, document, figure, refused, table,
};
use chatter::analysis::universal::{Argument, Evaluation, Universal, UniversalMap};
use chatter::numerics::{DoubleDouble, Real};
use std::path::PathBuf;

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    if arguments.cobweb.is_some() && arguments.plot.is_none() && arguments.out.is_none() {
        let refusal = Failure::input("--cobweb is drawn or written, and there is no file to do so");
        return Err(refusal.help("name one with --plot or --out"));
    }
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
    let request = arguments.request();
    let map = UniversalMap::new(double.clone(), arguments.slope.to_f64(), request.offset())
        .map_err(refused)?;

    let values = values(arguments, &universal)?;
    let mut diagram = match request.job()? {
        Some(job) => {
            let (map, sweep) = job.prepare()?;
            let (rows, store) = compute(&map, &sweep, &folder(arguments), &Console::new())?;
            Some((job, sweep, rows, Some(store)))
        }
        None => None,
    };
    let atlas = Atlas::new(&request, &Console::new())?;
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
        cobweb: cobweb(&request, &map)?,
        digits,
    };
    let mut written = Vec::new();
    if let Some(TableFile(path)) = &arguments.out {
        let found = (diagram.as_ref().map(|found| &found.0)).zip(samples.as_mut());
        written.extend(table::write(&findings, found, path)?);
    }
    if let Some(FigureFile(path)) = &arguments.plot {
        let figure = figure(&request, &findings, samples.as_mut(), &double, &map)?;
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

/// Upsilon where it is asked for, and can be held.
fn values<R: Real + Argument<Real = R>>(
    arguments: &Arguments,
    universal: &Universal<R>,
) -> Result<Vec<(R, Evaluation<R>)>, Failure> {
    (arguments.at.iter())
        .map(|x| {
            let x: R = x.get();
            let at = universal.at(x);
            match at.value.is_finite() {
                true => Ok((x, at)),
                false => Err(Failure::input(format!(
                    "Upsilon({:e}) is out of range; sizes up to 1.7e308 can be held",
                    x.to_f64()
                ))),
            }
        })
        .collect()
}

/// The cobweb, where one is asked for.
fn cobweb(request: &Request, map: &UniversalMap<f64>) -> Result<Option<Cobweb>, Failure> {
    let Some(mu) = request.cobweb else {
        return Ok(None);
    };
    let map = UniversalMap::new(map.universal().clone(), map.slope(), mu.to_f64());
    Ok(Some(Cobweb::new(&map.map_err(refused)?)))
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
