//! What `--resume` says of a file that has no journal.

use crate::failure::{self, Failure};
use crate::terminal;
use chatter_work::journals::{journal_of, shards_beside};
use std::path::Path;

/// No journal: what is written there is complete, or there never was any. `takes` says what `--resume` is given.
///
/// # Errors
/// It is not complete.
pub fn nothing_to_resume(target: &Path, is_complete: bool, takes: &str) -> Result<u8, Failure> {
    if is_complete {
        let text = format!(
            "{} is complete: there is nothing to resume\n",
            target.display()
        );
        terminal::print(&text).map_err(Failure::Output)?;
        return Ok(failure::SUCCESS);
    }
    let help = match &shards_beside(target)[..] {
        [] => format!("--resume takes {takes}"),
        [first, ..] => format!(
            "there are shares, such as `{}`: one that was broken off goes on when it is asked for again, and `chatter merge` \
             puts them together",
            first.display()
        ),
    };
    Err(Failure::input(format!(
        "there is nothing to resume: no `{}`",
        journal_of(target).display()
    ))
    .help(help))
}
