//! What ends complete chatter where no border is.

use super::sample::Sample;
use crate::analysis::border::{Break, BreakCause, GRAZE, SHORTEST, Verdict};

/// What makes the verdict change where no root is.
pub(super) fn break_between(left: &Sample, right: &Sample) -> Break {
    let sequences = || {
        [left, right]
            .into_iter()
            .filter_map(|sample| Some((sample, sample.sequence()?)))
    };
    // Within the sequence rates shrink as they should: a graze stands before it or at its beginning.
    let rates = sequences().flat_map(|(_, sequence)| {
        let largest = sequence.largest_rate();
        let until = sequence.impacts.iter().take(sequence.begins + 1);
        let rates = until.map(|impact| impact.rate_before).enumerate();
        rates.map(move |(impact, rate)| (impact, rate, rate.abs() / largest))
    });
    let slowest = rates.min_by(|a, b| a.2.total_cmp(&b.2));
    let incomplete = sequences().find(|(sample, _)| sample.verdict == Verdict::Incomplete);
    let is_short = incomplete
        .is_some_and(|(_, sequence)| sequence.impacts.len() <= sequence.begins + SHORTEST);
    let cause = match slowest {
        Some((impact, rate, relative)) if relative <= GRAZE => BreakCause::Graze { impact, rate },
        _ if [left.verdict, right.verdict].contains(&Verdict::Elsewhere) => BreakCause::Elsewhere,
        _ if is_short => BreakCause::Short { impacts: SHORTEST },
        _ if [left, right]
            .iter()
            .any(|sample| sample.failure().is_some()) =>
        {
            BreakCause::Unfollowed
        }
        _ if incomplete.is_none() => BreakCause::NoChatter,
        _ => BreakCause::Jump,
    };
    Break {
        value: left.value + (right.value - left.value) * 0.5,
        cause,
    }
}
