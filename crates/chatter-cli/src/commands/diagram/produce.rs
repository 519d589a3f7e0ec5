//! Computes what is missing of a diagram, then writes everything.

use crate::diagram::document::{self, Subject};
use crate::diagram::job::Ready;
use crate::diagram::picture::Words;
use crate::diagram::tally::Tally;
use crate::diagram::{
    Begun, Found, InMemory, Order, Store, View, account, check_size, picture, table,
};
use crate::failure::{self, Failure};
use crate::terminal::{self, Progress, Style, Waiting};
use chatter::analysis::diagram::{
    Ending, Executor, Outcome, Record, Row, Standing, Sweep, Threads, run as compute,
};
use chatter::analysis::map::Map;
use chatter::analysis::return_map::ReturnMap;
use core::ops::ControlFlow;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Instant;

/// What is gone on with.
pub enum Beginning {
    /// Whatever stands at this path; nothing as a rule.
    At(PathBuf),
    /// A diagram that was broken off.
    Resumed(Box<Begun>),
}

/// Computes what is missing, then writes everything.
pub fn produce(
    order: &Order,
    beginning: Beginning,
    threads: Threads,
    json: bool,
) -> Result<u8, Failure> {
    let job = &order.job;
    let ready = job.prepare(&order.model_text)?;
    check(order, &ready.sweep)?;
    let (mut store, standing) = open(order, beginning, &ready)?;
    let ending = fill(&ready.map, &ready.sweep, &standing, threads, &mut |row| {
        let kept = store.append(&row);
        kept.map_err(|error| Failure::Output(error.to_string()))
    })?;
    if ending == Ending::Stopped {
        let done: u64 = store.counts().values().sum();
        terminal::remark(&format!(
            "stopped with {done} of {} orbits done; go on with: chatter diagram --resume {}",
            ready.sweep.rows(),
            order.resume_options()
        ));
        return Ok(failure::INTERRUPTED);
    }
    // The journal has everything: what is being written now can be written again.
    terminal::end_on_interrupt();
    let waiting = Waiting::new("writing");
    store.compare(&ready.map)?;
    let (written, slanted) = write(order, &ready, &mut store)?;
    drop(waiting);
    if json {
        let subject = Subject {
            job,
            model: &ready.model,
            counts: &store.counts().clone(),
            complete: true,
        };
        document::write(&subject, &mut store, &mut terminal::json_stdout())?;
        store.remove()?;
        return Ok(failure::SUCCESS);
    }
    let tally = match ready.sweep.compares() {
        true => Some(Tally::of(&mut store)?),
        false => None,
    };
    let style = Style::of_stdout();
    let mut text = account::account(
        job,
        &ready.model,
        &ready.sweep,
        store.counts(),
        tally.as_ref(),
        style,
    );
    store.remove()?;
    for path in &written {
        text += &format!("wrote {}\n", path.display());
    }
    if slanted {
        text += picture::SLANTED;
    }
    terminal::print(&text).map_err(Failure::Output)?;
    Ok(failure::SUCCESS)
}

/// Computes a diagram that goes nowhere but into a document: in memory.
pub fn produce_document(order: &Order, threads: Threads) -> Result<u8, Failure> {
    let job = &order.job;
    let ready = job.prepare(&order.model_text)?;
    check_size(&ready.sweep, false)?;
    let mut rows: Vec<Row> = Vec::new();
    let standing = Standing::default();
    let ending = fill(&ready.map, &ready.sweep, &standing, threads, &mut |row| {
        rows.push(row);
        Ok(())
    })?;
    rows.sort_unstable_by_key(|row| row.row);
    let mut counts = BTreeMap::<Outcome, u64>::new();
    for row in &rows {
        *counts.entry(row.outcome).or_default() += 1;
    }
    let complete = ending == Ending::Complete;
    let subject = Subject {
        job,
        model: &ready.model,
        counts: &counts,
        complete,
    };
    let mut source = InMemory::new(&ready.sweep, &rows);
    if complete {
        source = source.compared(&ready.map);
    }
    document::write(&subject, &mut source, &mut terminal::json_stdout())?;
    Ok(if complete {
        failure::SUCCESS
    } else {
        failure::INTERRUPTED
    })
}

fn check(order: &Order, sweep: &Sweep) -> Result<(), Failure> {
    check_size(sweep, true)?;
    if order.out.is_some() {
        table::check_names(sweep)?;
    }
    let spec = sweep.spec();
    if order.plot.is_some() && spec.sweeps.len() == 1 && spec.record == Record::Classes {
        return Err(Failure::input("a diagram without samples cannot be drawn")
            .help("leave out --record classes, or --plot"));
    }
    if let (Some(_), [first, second]) = (&order.plot, &spec.sweeps[..]) {
        picture::check_cells(first.count, second.count)?;
    }
    Ok(())
}

/// Writes table and figure; gives the files, and whether the figure shows a narrow slanted band.
fn write(order: &Order, ready: &Ready, store: &mut Store) -> Result<(Vec<PathBuf>, bool), Failure> {
    let job = &order.job;
    let mut written = Vec::new();
    let mut slanted = false;
    if let Some(path) = &order.out {
        let texts = table::provenance(order, &ready.model)?;
        written.extend(table::write(store, &texts, path)?);
    }
    if let Some(path) = &order.plot {
        let view = View {
            shear: order.shear,
            ..View::default()
        };
        let words = Words {
            title: job.title(&ready.model),
            origin: &job.model,
            version: &job.version,
            axis: &|name| picture::axis(&ready.model, name),
        };
        let picture = picture::draw(&words, &ready.sweep, store, &view)?;
        let outcome = picture.figure.write(path);
        outcome.map_err(|error| Failure::Output(error.to_string()))?;
        written.push(path.clone());
        slanted = picture.slanted;
    }
    Ok((written, slanted))
}

/// The journal: the one that is there if it is about the same diagram, else a new one.
fn open(order: &Order, beginning: Beginning, ready: &Ready) -> Result<(Store, Standing), Failure> {
    let sweep = &ready.sweep;
    let begun = match beginning {
        Beginning::Resumed(begun) => *begun,
        Beginning::At(path) => match Store::find(&path, &order.header(), sweep)? {
            Found::New(store) => return Ok((store, Standing::default())),
            Found::Old(begun) => same(order, begun)?,
        },
    };
    let path = begun.path().to_path_buf();
    let (store, standing) = begun.read(sweep, ready.map.coordinates().len())?;
    terminal::remark(&format!(
        "going on from `{}`: {} of {} orbits are done",
        path.display(),
        standing.rows(),
        sweep.rows()
    ));
    Ok((store, standing))
}

/// A journal that was there, if it is about the same diagram.
fn same(order: &Order, begun: Begun) -> Result<Begun, Failure> {
    let found = &begun.header;
    let same_model = found.model_text == order.model_text && found.job.model == order.job.model;
    if found.job == order.job && same_model {
        return Ok(begun);
    }
    let difference = if same_model {
        found.job.difference(&order.job)
    } else {
        "another model"
    };
    Err(Failure::input(format!(
        "`{}` holds an unfinished diagram with {difference}",
        begun.path().display()
    ))
    .help("finish it with --resume, delete it, or write this diagram to another file"))
}

/// Computes what is missing; `keep` takes each row as it is done.
fn fill(
    map: &ReturnMap,
    sweep: &Sweep,
    standing: &Standing,
    threads: Threads,
    keep: &mut (dyn FnMut(Row) -> Result<(), Failure> + Send),
) -> Result<Ending, Failure> {
    terminal::catch_interrupts();
    let mut progress = Progress::new();
    let began = Instant::now();
    let spec = sweep.spec();
    let returns = (spec.transient as f64 + spec.keep as f64) * spec.every as f64;
    let mut broken = None;
    let executor: &dyn Executor = &threads;
    let mut done = standing.rows();
    let ending = compute(
        map,
        sweep,
        standing,
        executor,
        terminal::interrupt_flag(),
        &mut |row| {
            if let Err(failure) = keep(row) {
                broken = Some(failure);
                return ControlFlow::Break(());
            }
            done += 1;
            progress.show(done as f64 / sweep.rows() as f64, || {
                let rate =
                    (done - standing.rows()) as f64 * returns / began.elapsed().as_secs_f64();
                format!("{done} of {} orbits, {rate:.0} returns/s", sweep.rows())
            });
            ControlFlow::Continue(())
        },
    );
    progress.finish();
    match broken {
        Some(failure) => Err(failure),
        None => Ok(ending),
    }
}
