//! Whether a branch ends where its grazes accumulate.

use crate::analysis::periodic::branch::special::Special;

/// So many grazes, each of one impact more than the one before, say what follows.
const LATEST: usize = 3;
/// Where fewer impacts than these come to nothing they do not accumulate at a border, beyond which chatter is complete: a lone one may
/// be that of a part left to itself.
pub(in crate::analysis::periodic) const ACCUMULATES: u64 = 4;

/// The impacts beyond the latest graze, if those before it come with one impact more each, and the latest two are no farther apart than their parameters
/// are known, or flights are as low as rounding of the gap, or as short as stays that are over: with one impact more nothing would be told from them.
pub(in crate::analysis::periodic::branch) fn accumulates(
    special: &[Special],
    are_low: bool,
) -> Option<u64> {
    let grazes = special
        .iter()
        .rev()
        .filter(|special| special.kind.is_graze());
    let latest: Vec<&Special> = grazes.take(LATEST).collect();
    let [last, before, first] = latest[..] else {
        return None;
    };
    let impacts = [first, before, last].map(|graze| graze.point.impacts);
    let [Some(fewest), Some(more), Some(most)] = impacts else {
        return None;
    };
    let apart = (last.point.parameter() - before.point.parameter()).abs();
    let come_one_by_one = fewest >= ACCUMULATES && more == fewest + 1 && most == more + 1;
    (come_one_by_one && (are_low || apart <= last.error + before.error)).then_some(most + 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::periodic::branch::SpecialKind;
    use crate::analysis::periodic::branch::point::tests::orbits;

    /// Of grazes at such values with so many impacts each.
    fn of(grazes: &[(f64, u64)]) -> Option<u64> {
        let special = grazes.iter().map(|&(value, impacts)| {
            let mut point = orbits(|_| value, [1.0].into_iter()).remove(0);
            point.impacts = Some(impacts);
            Special {
                kind: SpecialKind::FlightGraze,
                point,
                error: 5e-15,
                residual: 0.0,
                persists: None,
                above: None,
                monitor: None,
                leaves: Vec::new(),
                place: 0,
                seed: None,
            }
        });
        accumulates(&special.collect::<Vec<Special>>(), false)
    }

    /// Those of a relay beside the border at 1.4591847658724768, which come nearer to it by 0.4046 each.
    #[test]
    fn grazes_accumulate_where_rounding_does_not_tell_them_apart() {
        let at = |k: i32, impacts: u64| {
            let off = 2.03e-14 * 0.4046_f64.powi(k);
            (1.459_184_765_872_476_8 - off, impacts)
        };
        assert_eq!(of(&[at(0, 35), at(1, 36), at(2, 37)]), Some(38));
        assert_eq!(of(&[at(-2, 33), at(-1, 34), at(0, 35)]), None);
        assert_eq!(of(&[at(0, 35), at(1, 36), at(2, 36)]), None);
        assert_eq!(of(&[at(1, 36), at(2, 37)]), None);
        assert_eq!(of(&[at(0, 1), at(1, 2), at(2, 3)]), None);
    }
}
