//! Computes what is missing of a diagram, then writes its files.

use super::expectation::stiffness;
use super::job::{Order, Ready};
use super::picture::{self, Words};
use super::source::InMemory;
use super::store::{Begun, Found, Store, check_size};
use super::{View, table};
use crate::observer::Observer;
use crate::refusal::Refusal;
use chatter::analysis::diagram::{
    Ending, Executor, Record, Row, Share, Standing, Sweep, Threads, run_share as compute,
};
use chatter::analysis::map::Map as _;
use chatter::analysis::return_map::ReturnMap;
use core::ops::ControlFlow;
use std::path::PathBuf;
use std::time::Instant;

/// What is gone on with.
pub enum Beginning {
    /// Whatever stands at this path; nothing as a rule.
    At(PathBuf),
    /// A diagram that was broken off.
    Resumed(Box<Begun>),
}

/// What of a diagram is computed, and how.
pub struct Work {
    /// Which share of it.
    pub share: Share,
    /// What is gone on with.
    pub beginning: Beginning,
    /// On how many threads.
    pub threads: Threads,
}

impl Work {
    /// All of it.
    pub fn whole(beginning: Beginning, threads: Threads) -> Self {
        Self {
            share: Share::WHOLE,
            beginning,
            threads,
        }
    }
}

/// A diagram in its journal.
pub struct Produced {
    /// Its model and map.
    pub ready: Ready,
    /// Its rows.
    pub store: Store,
    /// Whether all of them are there.
    pub complete: bool,
}

/// The files of a diagram, and what to say of its figure.
pub struct Written {
    /// The files.
    pub files: Vec<PathBuf>,
    /// Whether the figure shows a narrow slanted band.
    pub slanted: bool,
}

/// Computes what is missing.
///
/// # Errors
/// The order is wrong, or its journal is another's or cannot be written.
pub fn produce(order: &Order, work: Work, observer: &dyn Observer) -> Result<Produced, Refusal> {
    let Work {
        share,
        beginning,
        threads,
    } = work;
    let ready = order.ready()?;
    check(order, &ready.sweep)?;
    let wanted = Wanted {
        map: &ready.map,
        sweep: &ready.sweep,
        share,
    };
    let (mut store, standing) = open(order, beginning, &ready, share, observer)?;
    if let Some(remark) = stiffness(&ready) {
        observer.remark(&remark);
    }
    let keep = &mut |row: Row| {
        let kept = store.append(&row);
        kept.map_err(|error| Refusal::Output(error.to_string()))
    };
    let ending = fill(&wanted, &standing, (threads, keep), observer)?;
    let complete = ending == Ending::Complete;
    Ok(Produced {
        ready,
        store,
        complete,
    })
}

impl Produced {
    /// Tells attractors apart, and writes table and figure.
    ///
    /// # Errors
    /// A file cannot be written, or the journal not be read.
    pub fn write(&mut self, order: &Order, observer: &dyn Observer) -> Result<Written, Refusal> {
        self.store.compare(&self.ready.map)?;
        write(order, (&self.ready, &mut self.store), observer)
    }
}

/// Computes a diagram that is kept in memory: the rows that are done, in order, and whether all are.
///
/// # Errors
/// The order is wrong, or asks for too much.
pub fn produce_in_memory(
    order: &Order,
    threads: Threads,
    observer: &dyn Observer,
) -> Result<(Ready, Vec<Row>, bool), Refusal> {
    let ready = order.ready()?;
    let mut rows: Vec<Row> = Vec::new();
    let take = &mut |row| {
        rows.push(row);
        Ok(())
    };
    let complete = produce_rows(&ready, (threads, take), observer)?;
    rows.sort_unstable_by_key(|row| row.row);
    Ok((ready, rows, complete))
}

/// What takes each row as it is done.
pub type Take<'a> = &'a mut (dyn FnMut(Row) -> Result<(), Refusal> + Send);

/// Computes a diagram and hands over each row as it is done, in any order; whether all are.
///
/// # Errors
/// The order asks for too much, or `take` refuses a row, which ends the work.
pub fn produce_rows(
    ready: &Ready,
    (threads, take): (Threads, Take),
    observer: &dyn Observer,
) -> Result<bool, Refusal> {
    check_size(&ready.sweep, false)?;
    if let Some(remark) = stiffness(ready) {
        observer.remark(&remark);
    }
    let wanted = Wanted {
        map: &ready.map,
        sweep: &ready.sweep,
        share: Share::WHOLE,
    };
    let ending = fill(&wanted, &Standing::default(), (threads, take), observer)?;
    Ok(ending == Ending::Complete)
}

impl Ready {
    /// All rows of the diagram, their attractors told apart.
    pub fn source<'a>(&'a self, rows: &'a [Row], complete: bool) -> InMemory<'a> {
        let source = InMemory::new(&self.sweep, rows);
        match complete {
            true => source.compared(&self.map),
            false => source,
        }
    }
}

fn check(order: &Order, sweep: &Sweep) -> Result<(), Refusal> {
    check_size(sweep, true)?;
    if order.out.is_some() {
        table::check_names(sweep)?;
    }
    let spec = sweep.spec();
    if order.plot.is_some() && spec.sweeps.len() == 1 && spec.record == Record::Classes {
        return Err(Refusal::input("a diagram without samples cannot be drawn")
            .help("leave out --record classes, or --plot"));
    }
    if let (Some(_), [first, second]) = (&order.plot, &spec.sweeps[..]) {
        picture::check_cells(first.count, second.count)?;
    }
    Ok(())
}

/// Writes table and figure.
fn write(
    order: &Order,
    (ready, store): (&Ready, &mut Store),
    observer: &dyn Observer,
) -> Result<Written, Refusal> {
    let job = &order.job;
    let mut files = Vec::new();
    let mut slanted = false;
    if let Some(path) = &order.out {
        let texts = table::provenance(order, &ready.model)?;
        files.extend(table::write(store, &texts, path)?);
    }
    if let Some(path) = &order.plot {
        let view = View {
            shear: order.shear,
            ..View::default()
        };
        let words = Words {
            title: job.title(&ready.model),
            origin: &job.model,
            parameters: &picture::parameters(&ready.model, ready.sweep.spec()),
            version: &job.version,
            axis: &|name| picture::axis(&ready.model, name),
        };
        let picture = picture::draw(&words, (&ready.sweep, store), &view, observer)?;
        picture.figure.write(path)?;
        files.push(path.clone());
        slanted = picture.slanted;
    }
    Ok(Written { files, slanted })
}

/// The journal: the one that is there if it is about the same diagram, else a new one.
fn open(
    order: &Order,
    beginning: Beginning,
    ready: &Ready,
    share: Share,
    observer: &dyn Observer,
) -> Result<(Store, Standing), Refusal> {
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
    observer.remark(&format!(
        "going on from `{}`: {} of {} orbits are done",
        path.display(),
        standing.rows_of(sweep, share),
        rows_of(sweep, share)
    ));
    Ok((store, standing))
}

/// A journal that was there, if it is about the same diagram.
fn same(order: &Order, begun: Begun) -> Result<Begun, Refusal> {
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
    Err(Refusal::input(format!(
        "`{}` holds an unfinished diagram with {difference}",
        begun.path().display()
    ))
    .help("finish it with --resume, delete it, or write this diagram to another file"))
}

/// How many rows there are in a share of a sweep.
pub fn rows_of(sweep: &Sweep, share: Share) -> u64 {
    let pieces = share.pieces(sweep.pieces());
    pieces.map(|piece| sweep.piece_rows(piece)).sum()
}

/// Which rows of what are computed.
struct Wanted<'a> {
    map: &'a ReturnMap,
    sweep: &'a Sweep,
    share: Share,
}

/// Computes what is missing; `keep` takes each row as it is done.
fn fill(
    wanted: &Wanted,
    standing: &Standing,
    (threads, keep): (Threads, Take),
    observer: &dyn Observer,
) -> Result<Ending, Refusal> {
    let began = Instant::now();
    let &Wanted { map, sweep, share } = wanted;
    let rows = rows_of(sweep, share);
    let spec = sweep.spec();
    let returns = (spec.transient as f64 + spec.keep as f64) * spec.every as f64;
    let mut broken = None;
    let executor: &dyn Executor = &threads;
    let begun = standing.rows_of(sweep, share);
    let mut done = begun;
    let stop = observer.stop();
    let ending = compute(map, sweep, share, standing, executor, stop, &mut |row| {
        if let Err(refusal) = keep(row) {
            broken = Some(refusal);
            return ControlFlow::Break(());
        }
        done += 1;
        observer.progress(done as f64 / rows as f64, &|| {
            let rate = (done - begun) as f64 * returns / began.elapsed().as_secs_f64();
            format!("{done} of {rows} orbits, {rate:.0} returns/s")
        });
        ControlFlow::Continue(())
    });
    match broken {
        Some(refusal) => Err(refusal),
        None => Ok(ending),
    }
}
