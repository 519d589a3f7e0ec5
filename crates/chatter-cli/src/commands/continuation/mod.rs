//! `chatter continue`: branches of periodic orbits over a parameter.

mod arguments;
mod curves;

pub use arguments::Arguments;

use crate::accounts::periodic::{branches as account, curves as curves_account};
use crate::failure::{self, Failure};
use crate::numbers::Digits;
use crate::options::ShareOption;
use crate::resume::nothing_to_resume;
use crate::terminal::{self, Console, Style};
use chatter::analysis::diagram::Share;
use chatter::analysis::periodic::{Branch, SpecialKind};
use chatter::expressions::nearest;
use chatter_work::journals::journal_of;
use chatter_work::periodic::{
    Beginning, Begun, Job, Shared, Subject, Vertical, beneath, branch_document, curves_document,
    first_that_changes, holds_branches, picture, plane, produce, produce_share, write,
};
use std::path::Path;

/// What of an answer is shown, and how.
#[derive(Default)]
pub struct Shown<'a> {
    plot: Option<&'a Path>,
    over: Option<&'a Path>,
    observe: Option<&'a str>,
    json: bool,
}

impl<'a> Shown<'a> {
    /// An account, and a figure if this names one.
    pub fn plain(plot: Option<&'a Path>) -> Self {
        Self {
            plot,
            ..Self::default()
        }
    }
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let shown = Shown {
        plot: arguments.plot.as_ref().map(|file| file.0.as_path()),
        over: arguments.over.as_deref(),
        observe: arguments.observe.as_deref(),
        json: arguments.json,
    };
    if let Some(target) = &arguments.resume {
        let Some(begun) = Begun::open(&journal_of(target))? else {
            let takes = "the name that was given to --out";
            return nothing_to_resume(target, holds_branches(target)?, takes);
        };
        let job = begun.job.clone();
        return answer(
            &job,
            Some(target),
            Beginning::Begun(Box::new(begun)),
            &shown,
        );
    }
    let job = arguments.job()?;
    let out = arguments.out.as_ref().map(|file| file.0.as_path());
    match (arguments.shard, out) {
        (Some(ShareOption(share)), Some(out)) => produce_shard(&job, share, out),
        (_, Some(out)) => answer(&job, Some(out), Beginning::At(journal_of(out)), &shown),
        (_, None) => answer(&job, None, Beginning::Nowhere, &shown),
    }
}

/// Follows a share of the orbits that a search finds, into a journal of its own.
fn produce_shard(job: &Job, share: Share, out: &Path) -> Result<u8, Failure> {
    terminal::catch_interrupts();
    let console = Console::new();
    let made = produce_share(job, (share, out), &console);
    drop(console);
    let (Shared { done, orbits, all }, journal) = made?;
    let journal = journal.display();
    if done < orbits {
        terminal::remark(&format!(
            "stopped with {done} of {orbits} orbits done in `{journal}`; the same command goes on"
        ));
        return Ok(failure::INTERRUPTED);
    }
    let text = format!("share {share} is done: {orbits} of {all} orbits in `{journal}`\n");
    terminal::print(&text).map_err(Failure::Output)?;
    Ok(failure::SUCCESS)
}

/// Follows what is missing, writes the files and tells of it.
pub fn answer(
    job: &Job,
    out: Option<&Path>,
    beginning: Beginning,
    shown: &Shown<'_>,
) -> Result<u8, Failure> {
    let ready = job.ready()?;
    let model = &ready.model;
    let vertical = match shown.observe {
        None => None,
        Some("period") => Some(Vertical::Period),
        Some(name) => Some(Vertical::State(model.state_index(name).ok_or_else(
            || {
                let known = nearest(name, model.state_names());
                Failure::input(format!("the model has no state `{name}`")).did_you_mean(known)
            },
        )?)),
    };
    let free = ready.free.clone();
    let beneath = match shown.over {
        Some(file) => {
            let names: Vec<&str> = (free.iter())
                .map(|&index| model.parameters[index].name.as_str())
                .collect();
            Some(beneath(model, &names, file, vertical)?)
        }
        None => None,
    };
    terminal::catch_interrupts();
    let console = Console::new();
    let mut produced = produce(job, &ready, beginning, &console)?;
    let monitors = core::mem::take(&mut produced.monitors);
    let branches = core::mem::take(&mut produced.branches);
    let found = match job.plane {
        None => Found::Branches(branches),
        Some(_) => {
            let kinds = core::mem::take(&mut produced.kinds);
            Found::Curves(kinds.into_iter().zip(branches).collect())
        }
    };
    drop(console);
    let subject = Subject {
        model,
        source: &job.model,
        text: &job.model_text,
        monitors: &monitors,
        free,
        digits: Digits::DOUBLE,
    };
    let all = found.branches();
    if let Some(path) = out {
        write(&subject, &job.set, &all, path)?;
    }
    if let Some(path) = shown.plot {
        let vertical = vertical
            .or(beneath.as_ref().and_then(|beneath| beneath.vertical))
            .unwrap_or_else(|| first_that_changes(&subject, &all));
        let figure = match &found {
            Found::Branches(branches) => picture(&subject, branches, vertical, beneath),
            Found::Curves(curves) => plane(&subject, curves, beneath),
        };
        (figure.write(path)).map_err(|error| Failure::Output(error.to_string()))?;
    }
    let answer = if shown.json {
        terminal::Answer::Document(match &found {
            Found::Branches(branches) => branch_document(&subject, branches),
            Found::Curves(curves) => curves_document(&subject, curves),
        })
    } else {
        terminal::Answer::Text(match &found {
            Found::Branches(branches) => account(&subject, branches, Style::of_stdout()),
            Found::Curves(curves) => curves_account(&subject, curves, Style::of_stdout()),
        })
    };
    answer.print()?;
    if produced.complete {
        produced.forget_journal()?;
        return Ok(failure::SUCCESS);
    }
    if let (true, Some(out)) = (produced.is_kept(), out) {
        terminal::remark(&format!(
            "stopped; go on with: chatter continue --resume {}",
            out.display()
        ));
    }
    Ok(failure::INTERRUPTED)
}

/// What was followed.
enum Found {
    Branches(Vec<Branch>),
    Curves(Vec<(SpecialKind, Branch)>),
}

impl Found {
    fn branches(&self) -> Vec<Branch> {
        match self {
            Self::Branches(branches) => branches.clone(),
            Self::Curves(curves) => curves.iter().map(|(_, curve)| curve.clone()).collect(),
        }
    }
}
