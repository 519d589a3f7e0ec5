//! A diagram that several machines compute: each a share of it into a journal of its own, merged in the end.

use super::job::Order;
use super::source::Rows;
use super::store::{Begun, Found, Store};
use crate::journals::{journal_of, parts};
use crate::observer::Observer;
use crate::refusal::Refusal;
use chatter::analysis::diagram::{Share, Standing, Sweep};
use chatter::analysis::map::Map;
use std::path::{Path, PathBuf};

/// Fewer pieces than this leave lanes of the processor empty.
const FEW_PIECES: u64 = 64;

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
    let parts = parts(journals, &own, Begun::open)?;
    for part in &parts {
        part.of_this_version()?;
    }
    let first = &parts[0];
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
