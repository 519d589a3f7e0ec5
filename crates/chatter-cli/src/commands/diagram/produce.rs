//! Computes what is missing of a diagram, writes its files, and tells what it came to.

use crate::accounts::diagram::account;
use crate::diagram::document::{self, Subject};
use crate::diagram::tally::Tally;
use crate::diagram::{
    self, Beginning, Order, Work, picture, produce_in_memory, rows_of, shard_journal, small_share,
};
use crate::failure::{self, Failure};
use crate::terminal::{self, Console, Style};
use chatter::analysis::diagram::{Outcome, Share, Threads};
use std::collections::BTreeMap;
use std::path::Path;

/// Computes what is missing, then writes everything.
pub fn produce(
    order: &Order,
    beginning: Beginning,
    threads: Threads,
    json: bool,
) -> Result<u8, Failure> {
    terminal::catch_interrupts();
    let console = Console::new();
    let produced = diagram::produce(order, Work::whole(beginning, threads), &console);
    drop(console);
    let mut produced = produced?;
    if !produced.complete {
        let done: u64 = produced.store.counts().values().sum();
        terminal::remark(&format!(
            "stopped with {done} of {} orbits done; go on with: chatter diagram --resume {}",
            produced.ready.sweep.rows(),
            order.resume_options()
        ));
        return Ok(failure::INTERRUPTED);
    }
    // The journal has everything: what is being written now can be written again.
    terminal::end_on_interrupt();
    let console = Console::new();
    let written = produced.write(order, &console)?;
    drop(console);
    let (job, ready, mut store) = (&order.job, &produced.ready, produced.store);
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
    let mut text = account(
        job,
        &ready.model,
        &ready.sweep,
        store.counts(),
        tally.as_ref(),
        style,
    );
    store.remove()?;
    for path in &written.files {
        text += &format!("wrote {}\n", path.display());
    }
    if written.slanted {
        text += picture::SLANTED;
    }
    terminal::print(&text).map_err(Failure::Output)?;
    Ok(failure::SUCCESS)
}

/// Computes a share of a diagram, into a journal of its own.
pub fn produce_shard(
    order: &Order,
    out: &Path,
    share: Share,
    threads: Threads,
) -> Result<u8, Failure> {
    let journal = shard_journal(out, share);
    let work = Work {
        share,
        beginning: Beginning::At(journal.clone()),
        threads,
    };
    terminal::catch_interrupts();
    let console = Console::new();
    let produced = diagram::produce(order, work, &console);
    drop(console);
    let produced = produced?;
    let sweep = &produced.ready.sweep;
    if let Some(remark) = small_share(sweep, share) {
        terminal::warn(&remark);
    }
    let (done, rows): (u64, u64) = (
        produced.store.counts().values().sum(),
        rows_of(sweep, share),
    );
    let journal = journal.display();
    if !produced.complete {
        terminal::remark(&format!(
            "stopped with {done} of {rows} orbits done in `{journal}`; the same command goes on"
        ));
        return Ok(failure::INTERRUPTED);
    }
    let text = format!(
        "share {share} is done: {rows} of {} orbits in `{journal}`\n",
        sweep.rows()
    );
    terminal::print(&text).map_err(Failure::Output)?;
    Ok(failure::SUCCESS)
}

/// Computes a diagram that goes nowhere but into a document: in memory.
pub fn produce_document(order: &Order, threads: Threads) -> Result<u8, Failure> {
    terminal::catch_interrupts();
    let console = Console::new();
    let produced = produce_in_memory(order, threads, &console);
    drop(console);
    let (ready, rows, complete) = produced?;
    let mut counts = BTreeMap::<Outcome, u64>::new();
    for row in &rows {
        *counts.entry(row.outcome).or_default() += 1;
    }
    let subject = Subject {
        job: &order.job,
        model: &ready.model,
        counts: &counts,
        complete,
    };
    let mut source = ready.source(&rows, complete);
    document::write(&subject, &mut source, &mut terminal::json_stdout())?;
    Ok(if complete {
        failure::SUCCESS
    } else {
        failure::INTERRUPTED
    })
}
