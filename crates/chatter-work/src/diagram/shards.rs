//! A diagram that several machines compute: each a share of it into a journal of its own, merged in the end.

use super::job::Order;
use super::source::Rows;
use super::store::{Begun, Found, Store};
use crate::journals::journal_of;
use crate::observer::Observer;
use crate::refusal::Refusal;
use chatter::analysis::diagram::{Share, Standing, Sweep};
use chatter::analysis::map::Map;
use std::path::{Path, PathBuf};

/// Fewer pieces than this leave lanes of the processor empty.
const FEW_PIECES: u64 = 64;

/// The journal of a share of the diagram that is to be written to `output`.
pub fn shard_journal(output: &Path, share: Share) -> PathBuf {
    let stem = output.file_stem().unwrap_or_default().to_string_lossy();
    let digits = share.of().to_string().len();
    let name = format!(
        "{stem}.{:0digits$}-of-{}.journal",
        share.number(),
        share.of()
    );
    output.with_file_name(name)
}

/// What there is to say of a share that is too small to be worth a machine.
pub fn small_share(sweep: &Sweep, share: Share) -> Option<String> {
    let pieces = share.count(sweep.pieces());
    (share != Share::WHOLE && pieces < FEW_PIECES).then(|| {
        format!(
            "share {share} has {pieces} pieces that can be computed side by side: fewer than {FEW_PIECES} leave the processor \
             half idle; take fewer shares, or a smaller --chunk"
        )
    })
}

/// Puts the rows of all these journals into that of the diagram which is to be written to `out`.
///
/// # Errors
/// A journal is of another diagram, cannot be read, or is in use.
pub fn merge(
    journals: &[PathBuf],
    (out, plot): (&Path, Option<PathBuf>),
    observer: &dyn Observer,
) -> Result<Order, Refusal> {
    let own = journal_of(out);
    // A pattern of names may take in the journal of a merge that was broken off, which is read anyway.
    let is_own = |path: &Path| match (path.canonicalize(), own.canonicalize()) {
        (Ok(path), Ok(own)) => path == own,
        _ => false,
    };
    let mut parts = Vec::new();
    for path in journals.iter().filter(|path| !is_own(path)) {
        let Some(part) = Begun::open(path)? else {
            return Err(Refusal::input(format!(
                "there is no file `{}`",
                path.display()
            )));
        };
        part.of_this_version()?;
        parts.push(part);
    }
    let Some(first) = parts.first() else {
        return Err(Refusal::input("there is no journal to be merged"));
    };
    for part in &parts {
        let (one, other) = (&first.header, &part.header);
        if one.job != other.job || one.model_text != other.model_text {
            let difference = match one.model_text == other.model_text {
                true => one.job.difference(&other.job),
                false => "another model",
            };
            return Err(Refusal::input(format!(
                "`{}` is a part of another diagram than `{}`: it has {difference}",
                part.path().display(),
                first.path().display()
            )));
        }
    }
    let order = first.header.clone().order(out, plot, observer)?;
    let ready = order.job.prepare(&order.model_text)?;
    let (sweep, coordinates) = (&ready.sweep, ready.map.coordinates().len());
    let (mut store, mut standing) = match Store::find(&own, &order.header(), sweep)? {
        Found::New(store) => (store, Standing::default()),
        Found::Old(begun) if begun.header.job == order.job => begun.read(sweep, coordinates)?,
        Found::Old(begun) => {
            return Err(Refusal::input(format!(
                "`{}` holds an unfinished diagram with {}",
                begun.path().display(),
                begun.header.job.difference(&order.job)
            )));
        }
    };
    for part in parts {
        let (mut rows, there) = part.read(sweep, coordinates)?;
        for piece in 0..sweep.pieces() {
            // Those of a piece follow each other, as far as they are there.
            for index in 0..there.done(piece) {
                let row = rows.row(sweep.row(piece, index))?;
                if standing.note(sweep, &row) {
                    let kept = store.append(&row);
                    kept.map_err(|error| Refusal::Output(error.to_string()))?;
                }
            }
        }
    }
    Ok(order)
}
