//! A branch arc by arc: from graze to graze the number of impacts a period is the same. At a border infinitely many accumulate.

use chatter::analysis::periodic::{Branch, Special};

/// A part of a branch with one number of impacts.
#[derive(Clone, Debug, PartialEq)]
pub struct Arc {
    /// Impacts a period; none where infinitely many.
    pub impacts: Option<u64>,
    /// How many of the branch's points come before it, and how many up to its end.
    pub points: (usize, usize),
    /// Least and greatest value of the parameter on it, special points included.
    pub range: (f64, f64),
    /// Its special points by their places in the branch's list; a graze is one of both arcs that meet there.
    pub special: Vec<usize>,
}

impl Arc {
    fn new(impacts: Option<u64>, before: usize) -> Self {
        Self {
            impacts,
            points: (before, before),
            range: (f64::INFINITY, f64::NEG_INFINITY),
            special: Vec::new(),
        }
    }

    fn reaches(&mut self, value: f64) {
        self.range = (self.range.0.min(value), self.range.1.max(value));
    }

    fn has(&mut self, index: usize, special: &Special) {
        self.special.push(index);
        self.reaches(special.point.parameter());
    }
}

/// The arcs of a branch, in order.
pub fn arcs(branch: &Branch) -> Vec<Arc> {
    let mut found: Vec<Arc> = Vec::new();
    // The graze that the next arc begins at.
    let mut graze: Option<usize> = None;
    let mut specials = branch.special.iter().enumerate().peekable();
    let arc_of = |found: &mut Vec<Arc>, graze: &mut Option<usize>, impacts, before| {
        let goes_on = found.last().is_some_and(|arc: &Arc| arc.impacts == impacts);
        if !goes_on {
            let mut arc = Arc::new(impacts, before);
            if let Some(index) = graze.take() {
                arc.has(index, &branch.special[index]);
            }
            found.push(arc);
        }
        *graze = None;
    };
    for before in 0..=branch.points.len() {
        while let Some((index, special)) = specials.next_if(|(_, s)| s.place <= before) {
            if special.kind.is_graze() {
                if let Some(arc) = found.last_mut() {
                    arc.has(index, special);
                }
                graze = Some(index);
            } else {
                arc_of(&mut found, &mut graze, special.point.impacts, before);
                if let Some(arc) = found.last_mut() {
                    arc.has(index, special);
                }
            }
        }
        if let Some(point) = branch.points.get(before) {
            arc_of(&mut found, &mut graze, point.impacts, before);
            if let Some(arc) = found.last_mut() {
                arc.points.1 = before + 1;
                arc.reaches(point.parameter());
            }
        }
    }
    found
}
