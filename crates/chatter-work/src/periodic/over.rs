//! The orbit diagram that branches are drawn over.

use super::picture::Vertical;
use crate::diagram::picture::{axis, densities, map_panel};
use crate::diagram::{Stored, Subject as Of, View};
use crate::refusal::Refusal;
use chatter::analysis::diagram::Range;
use chatter::model::Model;
use chatter_figures::{Legend, Panel};
use std::path::Path;

/// A diagram's panel, and whether its horizontal axis is the first of two free parameters rather than the one of the sweep.
pub struct Beneath {
    /// What branches are drawn into.
    pub panel: Panel,
    /// Whether the axes are the other way round.
    pub turned: bool,
    /// What it shows over one parameter.
    pub vertical: Option<Vertical>,
}

/// Reads the diagram: over the free parameter, of what is to be drawn over it, or of the first state that it shows; or over both
/// free parameters.
///
/// # Errors
/// There is no such file, or its diagram is of other parameters or shows something else.
pub fn beneath(
    model: &Model,
    free: &[&str],
    path: &Path,
    vertical: Option<Vertical>,
) -> Result<Beneath, Refusal> {
    let mut stored = Stored::open(path)?;
    let Of::Flow(job) = stored.subject.clone() else {
        return Err(Refusal::input(format!(
            "`{}` is a diagram of the universal map",
            path.display()
        )));
    };
    let ready = job.prepare(&stored.model_text)?;
    stored.check(&ready.sweep)?;
    let label = |name: &str| axis(&ready.model, name);
    let spec = ready.sweep.spec().clone();
    let swept: Vec<String> = spec.sweeps.iter().map(Range::name).collect();
    let other = || {
        Refusal::input(format!(
            "`{}` is a diagram over {}, and the branches are over {}",
            path.display(),
            swept.join(" and "),
            free.join(" and ")
        ))
    };
    match (&spec.sweeps[..], free) {
        ([range], [name]) if range.name() == *name => {
            let known: Vec<&str> = spec.observe.iter().map(|one| &*one.name).collect();
            let shows = |wanted: &str| {
                Refusal::input(format!(
                    "`{}` shows `{}`, and not {wanted}",
                    path.display(),
                    known.join("`, `")
                ))
                .help("choose a state that the diagram shows with --observe")
            };
            let state = match vertical {
                Some(Vertical::State(index)) => index,
                Some(Vertical::Period) => return Err(shows("the period")),
                None => (known.iter().find_map(|name| model.state_index(name)))
                    .ok_or_else(|| shows("a state"))?,
            };
            let wanted = &model.states[state].name;
            if !known.contains(&wanted.as_str()) {
                return Err(shows(&format!("`{wanted}`")));
            }
            let view = View {
                observe: vec![wanted.clone()],
                ..View::default()
            };
            let drawn = densities(&ready.sweep, range, &label, &mut stored, &view)?;
            let panel = drawn.panels.into_iter().next();
            Ok(Beneath {
                // Alone a diagram of one colour has none.
                panel: panel.ok_or_else(other)?.legend(Legend::Auto),
                turned: false,
                vertical: Some(Vertical::State(state)),
            })
        }
        ([first, second], [one, two]) => {
            let turned = match (first.name(), second.name()) {
                (x, y) if x == *two && y == *one => false,
                (x, y) if x == *one && y == *two => true,
                _ => return Err(other()),
            };
            let panel = map_panel(
                &ready.sweep,
                [first, second],
                &label,
                &mut stored,
                &View::default(),
            )?;
            Ok(Beneath {
                panel,
                turned,
                vertical: None,
            })
        }
        _ => Err(other()),
    }
}
