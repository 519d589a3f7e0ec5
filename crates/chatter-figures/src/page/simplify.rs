//! Curves of millions of points, cut down to what can be seen.

use crate::scene::{Path, Rect, Segment};

/// Greatest distance, in points, between a curve and what is drawn of it: an eighth of a pixel at 300 per inch.
pub(crate) const TOLERANCE: f64 = 0.03;

/// A curve through the places given, broken where one is not finite, clipped to the neighbourhood of `visible`.
pub(crate) fn curve(places: impl IntoIterator<Item = (f64, f64)>, visible: Rect) -> Path {
    // Room for the width of the line, so that a clipped end is never seen.
    let clip = visible.grown(20.0);
    let mut out = Reducer::default();
    let mut previous: Option<(f64, f64)> = None;
    for (x, y) in places {
        if !(x.is_finite() && y.is_finite()) {
            out.finish();
            previous = None;
            continue;
        }
        let (x, y) = (x.clamp(-FAR, FAR), y.clamp(-FAR, FAR));
        if let Some(before) = previous {
            match clipped(before, (x, y), &clip) {
                Some((a, b)) => {
                    if out.last_given() != Some(a) {
                        out.finish();
                        out.push(a);
                    }
                    out.push(b);
                }
                None => out.finish(),
            }
        } else if clip.contains(x, y) {
            out.push((x, y));
        }
        previous = Some((x, y));
    }
    out.finish();
    Path(out.path)
}

/// Farther away nothing is told apart, and products of coordinates stay finite.
const FAR: f64 = 1e9;

/// The part of a segment inside the rectangle (Liang and Barsky).
fn clipped(a: (f64, f64), b: (f64, f64), rect: &Rect) -> Option<((f64, f64), (f64, f64))> {
    if rect.contains(a.0, a.1) && rect.contains(b.0, b.1) {
        return Some((a, b));
    }
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let (mut t0, mut t1) = (0.0f64, 1.0f64);
    for (p, q) in [
        (-dx, a.0 - rect.left),
        (dx, rect.right - a.0),
        (-dy, a.1 - rect.top),
        (dy, rect.bottom - a.1),
    ] {
        if p == 0.0 {
            if q < 0.0 {
                return None;
            }
        } else if p < 0.0 {
            t0 = t0.max(q / p);
        } else {
            t1 = t1.min(q / p);
        }
    }
    let point = |t: f64| match t {
        0.0 => a,
        1.0 => b,
        _ => (a.0 + t * dx, a.1 + t * dy),
    };
    (t0 <= t1).then(|| (point(t0), point(t1)))
}

/// Two filters in a row: a run of points within one thin column becomes its first, lowest, highest and last; then a
/// run of points that one segment passes within the tolerance becomes that segment (sector filter).
#[derive(Default)]
struct Reducer {
    column: Option<Column>,
    last: Option<(f64, f64)>,
    sector: Option<Sector>,
    path: Vec<Segment>,
}

struct Column {
    index: f64,
    first: (f64, f64),
    lowest: (f64, f64),
    highest: (f64, f64),
    last: (f64, f64),
    lowest_before_highest: bool,
    count: usize,
}

struct Sector {
    anchor: (f64, f64),
    last: (f64, f64),
    /// Directions from the anchor that pass all points since: an interval of angles as two bounding directions.
    bounds: Option<((f64, f64), (f64, f64))>,
    reach: f64,
}

impl Reducer {
    fn last_given(&self) -> Option<(f64, f64)> {
        self.last
    }

    fn push(&mut self, point: (f64, f64)) {
        self.last = Some(point);
        let index = (point.0 / TOLERANCE).floor();
        if let Some(column) = &mut self.column
            && column.index == index
        {
            column.add(point);
            return;
        }
        self.flush_column();
        self.column = Some(Column {
            index,
            first: point,
            lowest: point,
            highest: point,
            last: point,
            lowest_before_highest: true,
            count: 1,
        });
    }

    fn flush_column(&mut self) {
        let Some(c) = self.column.take() else { return };
        self.emit(c.first);
        if c.count > 2 {
            let (a, b) = if c.lowest_before_highest {
                (c.lowest, c.highest)
            } else {
                (c.highest, c.lowest)
            };
            self.emit(a);
            self.emit(b);
        }
        self.emit(c.last);
    }

    fn emit(&mut self, point: (f64, f64)) {
        let Some(sector) = &mut self.sector else {
            self.path.push(Segment::Move(point.0, point.1));
            self.sector = Some(Sector::new(point));
            return;
        };
        if !sector.take(point) {
            let corner = sector.last;
            self.path.push(Segment::Line(corner.0, corner.1));
            let mut next = Sector::new(corner);
            next.take(point);
            self.sector = Some(next);
        }
    }

    fn finish(&mut self) {
        self.flush_column();
        self.last = None;
        if let Some(sector) = self.sector.take() {
            // A curve of one point is drawn as a dot: a segment of no length with round ends.
            self.path.push(Segment::Line(sector.last.0, sector.last.1));
        }
    }
}

impl Column {
    fn add(&mut self, point: (f64, f64)) {
        if point.1 > self.lowest.1 {
            self.lowest = point;
            self.lowest_before_highest = false;
        }
        if point.1 < self.highest.1 {
            self.highest = point;
            self.lowest_before_highest = true;
        }
        self.last = point;
        self.count += 1;
    }
}

fn cross(a: (f64, f64), b: (f64, f64)) -> f64 {
    a.0 * b.1 - a.1 * b.0
}

impl Sector {
    fn new(anchor: (f64, f64)) -> Self {
        Sector {
            anchor,
            last: anchor,
            bounds: None,
            reach: 0.0,
        }
    }

    /// Takes a point in if a segment from the anchor to it still passes all points within the tolerance.
    fn take(&mut self, point: (f64, f64)) -> bool {
        let d = (point.0 - self.anchor.0, point.1 - self.anchor.1);
        let length = (d.0 * d.0 + d.1 * d.1).sqrt();
        if let Some((left, right)) = self.bounds {
            // Turning back would shorten the line.
            if length < self.reach - TOLERANCE || cross(left, d) < 0.0 || cross(d, right) < 0.0 {
                return false;
            }
        } else if length < self.reach {
            return false;
        }
        if length > TOLERANCE {
            let along = (length * length - TOLERANCE * TOLERANCE).sqrt();
            // The two tangents from the anchor to the circle of radius TOLERANCE round the point.
            let turn = |side: f64| {
                let (c, s) = (along / length, side * TOLERANCE / length);
                (c * d.0 - s * d.1, s * d.0 + c * d.1)
            };
            let (left, right) = (turn(-1.0), turn(1.0));
            self.bounds = Some(match self.bounds {
                None => (left, right),
                Some((l, r)) => (
                    if cross(l, left) > 0.0 { left } else { l },
                    if cross(right, r) > 0.0 { right } else { r },
                ),
            });
        }
        self.reach = self.reach.max(length);
        self.last = point;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const PAGE: Rect = Rect {
        left: 0.0,
        top: 0.0,
        right: 200.0,
        bottom: 100.0,
    };

    fn pieces(path: &Path) -> Vec<((f64, f64), (f64, f64))> {
        let mut at = (0.0, 0.0);
        let mut pieces = Vec::new();
        for s in &path.0 {
            match *s {
                Segment::Move(x, y) => at = (x, y),
                Segment::Line(x, y) => {
                    pieces.push((at, (x, y)));
                    at = (x, y);
                }
                _ => unreachable!(),
            }
        }
        pieces
    }

    fn distance(p: (f64, f64), (a, b): ((f64, f64), (f64, f64))) -> f64 {
        let d = (b.0 - a.0, b.1 - a.1);
        let l = d.0 * d.0 + d.1 * d.1;
        let t = if l == 0.0 {
            0.0
        } else {
            (((p.0 - a.0) * d.0 + (p.1 - a.1) * d.1) / l).clamp(0.0, 1.0)
        };
        let (x, y) = (p.0 - a.0 - t * d.0, p.1 - a.1 - t * d.1);
        (x * x + y * y).sqrt()
    }

    #[test]
    fn a_million_points_become_few() {
        let n = 1_000_000;
        let wave = (0..n).map(|k| {
            let t = f64::from(k) / f64::from(n);
            (200.0 * t, 50.0 + 40.0 * (300.0 * t * t).sin())
        });
        let path = curve(wave, PAGE);
        assert!(path.0.len() < 20_000, "{}", path.0.len());
        let line = curve((0..n).map(|k| (f64::from(k) * 2e-4, 3.0)), PAGE);
        assert_eq!(line.0.len(), 2);
    }

    #[test]
    fn gaps_and_far_places_break_the_curve() {
        let path = curve(
            [
                (0.0, 1.0),
                (10.0, 1.0),
                (f64::NAN, 0.0),
                (20.0, 1.0),
                (30.0, 1.0),
            ],
            PAGE,
        );
        assert_eq!(
            path.0
                .iter()
                .filter(|s| matches!(s, Segment::Move(..)))
                .count(),
            2
        );
        let path = curve([(10.0, -1e300), (10.0, 1e300), (90.0, f64::INFINITY)], PAGE);
        assert!(pieces(&path).iter().all(
            |(a, b)| PAGE.grown(21.0).contains(a.0, a.1) && PAGE.grown(21.0).contains(b.0, b.1)
        ));
        assert_eq!(pieces(&path).len(), 1);
    }

    proptest! {
        #[test]
        fn every_point_is_near_what_is_drawn(steps in proptest::collection::vec((-1.0..1.0f64, -1.0..1.0f64, 0..5u8), 1..200)) {
            let mut at = (100.0, 50.0);
            let mut points = Vec::new();
            for (dx, dy, size) in steps {
                let size = [0.001, 0.01, 0.1, 1.0, 5.0][size as usize];
                at = ((at.0 + size * dx).clamp(0.0, 200.0), (at.1 + size * dy).clamp(0.0, 100.0));
                points.push(at);
            }
            let drawn = pieces(&curve(points.iter().copied(), PAGE));
            for p in points {
                let nearest = drawn.iter().map(|&s| distance(p, s)).fold(f64::INFINITY, f64::min);
                // Twice: once for the column, once for the sector.
                prop_assert!(nearest <= 2.1 * TOLERANCE, "{nearest}");
            }
        }
    }
}
