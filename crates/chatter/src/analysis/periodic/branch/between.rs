//! Special points between two stations with the same sequence of events.

use super::branch_point::Met;
use super::special::Seed;
use super::walker::Walker;
use super::{End, Point, SpecialKind};
use crate::analysis::continuation::{Problem, Singular, Station, locate, meeting};
use crate::analysis::periodic::aside::shift;
use crate::analysis::periodic::condition::{Bordered, Condition};
use crate::analysis::periodic::multipliers::{
    NEAR_ONE, beyond, farthest, is_near, neutral, off_together, pair, passes, passes_at_place,
    passes_together, straddles,
};
use crate::analysis::periodic::shooting::Shooting;
use crate::analysis::periodic::solved::{Solved, roundoff};
use crate::numerics::{Complex, moved};

/// What changed its sign between two stations, and its values there.
#[derive(Clone, Copy, Debug)]
enum Passed {
    Fold((f64, f64)),
    Doubling((f64, f64)),
    /// Several multipliers pass -1, or 1, at once: this one of them, by its place.
    DoublingOf(usize, (f64, f64)),
    MeetingOf(usize, (f64, f64)),
    /// With how far the parameter goes while the modulus of a pair changes by as much as it may be off by.
    Torus((f64, f64), f64),
    Monitor(usize, (f64, f64)),
}

impl Passed {
    fn kind(self) -> SpecialKind {
        match self {
            Self::Fold(_) => SpecialKind::Fold,
            Self::Doubling(_) | Self::DoublingOf(..) => SpecialKind::PeriodDoubling,
            Self::MeetingOf(..) => SpecialKind::BranchPoint,
            Self::Torus(..) => SpecialKind::NeimarkSacker,
            Self::Monitor(..) => SpecialKind::Monitor,
        }
    }
}

/// The relative error of a place that only stations were compared for.
const UNREFINED: f64 = 1e-11;
/// A direction has no more than this part of the parameter where that stands still.
pub(super) const STANDS: f64 = 1e-12;
/// What vanishes is below this part of what it was to both sides.
const VANISHES: f64 = 1e-4;

/// Where multipliers go farther than this, as they lie on the sphere of all numbers with infinity, ways are halved, so often at most.
const FAR: f64 = 0.2;
const HALVINGS: usize = 5;
/// Where several multipliers pass -1, or 1, ways are halved until each does so alone, or so often: then they are told as one place.
const ALONE: usize = 24;

/// A multiplier may have been past -1 and come back where it is this near to it; it is looked for at so many places, each of them to come
/// nearer by this part.
const CLOSE: f64 = 0.1;
const LOOKS: usize = 8;
const NEARER: f64 = 0.5;
/// Of two that are this near to -1, or 1, to either side, one may go in as the other goes out. One that comes to 1 may be past it by so much of what it
/// was before by rounding.
const AROUND: f64 = 0.5;
const BY_ROUNDING: f64 = 1e-11;

/// To both sides of what is found each place that is looked at is farther from it by this factor, the second as far as it is wide.
const FARTHER: f64 = 2.0;

/// Towards a graze ways are shortened to this part, so often; and only where more than one multiplier is more than this.
const SHORTER: f64 = 0.25;
const TOWARDS: i32 = 6;
const LASTING: f64 = 1e-6;

fn doubling(multipliers: &[Complex]) -> Option<f64> {
    passes(multipliers, -1.0)
}

/// Where the parabola through three points is lowest, and how low.
fn vertex(through: &[(f64, f64)]) -> Option<(f64, f64)> {
    let [(a, fa), (b, fb), (c, fc)] = through else {
        return None;
    };
    let (left, right) = ((fb - fa) / (b - a), (fc - fb) / (c - b));
    let bend = (right - left) / (c - a);
    let lowest = 0.5 * (a + b - left / bend);
    let depth = fa + (lowest - a) * (left + bend * (lowest - b));
    (bend > 0.0).then_some((lowest, depth))
}

/// How many displacements last: where that is several, multipliers may pass together.
fn lasting(point: &Point) -> usize {
    let lasting = point.multipliers.iter().filter(|m| m.modulus() > LASTING);
    lasting.count()
}

/// The middle of each two that follow each other.
fn halfway(places: &[f64]) -> Vec<f64> {
    let ends = places.windows(2);
    ends.map(|ends| 0.5 * (ends[0] + ends[1])).collect()
}

/// By how many the real multipliers beyond -1, and beyond 1, differ.
fn passing(here: &Point, there: &Point) -> [usize; 2] {
    let [here, there] = [here, there].map(|point| beyond(&point.multipliers));
    [0, 1].map(|side: usize| here[side].abs_diff(there[side]))
}

impl Walker {
    /// Special points between two stations with the same sequence of events, and the end, if the branch ends at one of them.
    pub(super) fn between(
        &mut self,
        from: &Station,
        to: &Station,
        step: f64,
        points: (&Point, &Point),
    ) -> Option<End> {
        self.between_by(0, (from, to), step, points)
    }

    /// The same, looked at in halves where multipliers go so far between the stations that two changes of a sign may undo each other, as where
    /// a pair leaves the circle, becomes real, and one of the two comes back; or where as many multipliers lie beyond -1, or 1, as say that two
    /// have passed it; and in parts where one has passed -1 and come back.
    fn between_by(
        &mut self,
        halvings: usize,
        (from, to): (&Station, &Station),
        step: f64,
        (here, there): (&Point, &Point),
    ) -> Option<End> {
        let is_lasting = |m: &Complex| m.im != 0.0 && m.modulus() > LASTING;
        let has_pair = |point: &Point| point.multipliers.iter().any(is_lasting);
        let goes_far = || {
            halvings < HALVINGS
                && (has_pair(here) || has_pair(there))
                && farthest(&here.multipliers, &there.multipliers) > FAR
        };
        let several = || halvings < ALONE && passing(here, there).iter().any(|&count| count > 1);
        let part = match goes_far() || several() {
            true => Some(0.5),
            false if halvings < HALVINGS => self.comes_back(from, step, (here, there)),
            false => None,
        };
        if let Some(part) = part
            && let Some(end) = self.between_parts(halvings, (from, to), (step, part), (here, there))
        {
            return end;
        }
        self.passed_between(halvings, (from, to), step, (here, there))
    }

    /// The same in two parts, the first of them this part of the way. None where it cannot be parted, or there is no use in it.
    fn between_parts(
        &mut self,
        halvings: usize,
        (from, to): (&Station, &Station),
        (step, part): (f64, f64),
        (here, there): (&Point, &Point),
    ) -> Option<Option<End>> {
        let (middle, _) = from.ahead(&mut self.shooting, part * step).ok()?;
        self.settle(&middle);
        let halfway = Point::new(&mut self.shooting, &middle);
        let left = middle.reach(&to.at, self.shooting.scales());
        if left <= 0.0 || self.is_rounding((from, to), step, [here, &halfway, there]) {
            return None;
        }
        let near = (from, &middle, part * step, (here, &halfway));
        let far = (&middle, to, left, (&halfway, there));
        let mut parts = [near, far].into_iter();
        Some(parts.find_map(|(from, to, step, points)| {
            self.between_by(halvings + 1, (from, to), step, points)
        }))
    }

    /// Where something has passed beside what is found on a way, and come back: beside a fold or a doubling multipliers may go out as far as
    /// infinity and come in on the other side within a short part of the way, which is not far on the sphere. They are looked at between what is
    /// found and, where that is several, ever farther from it to both sides; the part of the way at which that is.
    fn comes_and_goes(
        &mut self,
        (from, step): (&Station, f64),
        (here, there): (&Point, &Point),
        found: &[(Passed, Station, f64)],
    ) -> Option<f64> {
        // Of two the product is smooth, whatever each of them does.
        if lasting(here).max(lasting(there)) < 3 {
            return None;
        }
        let places: Vec<f64> = found.iter().map(|(.., ahead)| *ahead).collect();
        let mut looks = halfway(&[&[0.0], &places[..], &[step]].concat());
        if let [first, .., last] = places[..] {
            let farther = |k: i32| (last - first) * FARTHER.powi(k - 1);
            let before = (0..).map(|k| first - farther(k)).take_while(|at| *at > 0.0);
            looks.extend(before.take(LOOKS));
            let after = (0..).map(|k| last + farther(k)).take_while(|at| *at < step);
            looks.extend(after.take(LOOKS));
        }
        looks.into_iter().find_map(|ahead| {
            let (station, _) = from.ahead(&mut self.shooting, ahead).ok()?;
            self.settle(&station);
            let between = Point::new(&mut self.shooting, &station);
            let error = [here, &between, there].map(|point| point.modulus_error);
            let level = 2.0 * error.into_iter().fold(0.0, f64::max);
            let comes_back = |value: fn(&[Complex]) -> Option<f64>| {
                let of = |point: &Point| value(&point.multipliers);
                let (Some(before), Some(mid), Some(after)) = (of(here), of(&between), of(there))
                else {
                    return false;
                };
                before * after > 0.0 && before * mid < 0.0 && mid.abs() > level
            };
            let comes = comes_back(doubling) || comes_back(passes_together);
            comes.then_some(ahead / step)
        })
    }

    /// Where a multiplier is past -1, or 1, though as many are at both ends: the part of the way at which it is. One that comes near to -1 may have been
    /// past it and come back; and where there are some on both sides of -1, or 1, one may go in as another goes out. It is looked for at the
    /// vertices of parabolas for as long as these go on to say that it comes much nearer.
    fn comes_back(&mut self, from: &Station, step: f64, points: (&Point, &Point)) -> Option<f64> {
        [-1.0, 1.0]
            .into_iter()
            .find_map(|at| self.comes_back_over(at, (from, step), points))
    }

    fn comes_back_over(
        &mut self,
        at: f64,
        (from, step): (&Station, f64),
        (here, there): (&Point, &Point),
    ) -> Option<f64> {
        let ends = [&here.multipliers, &there.multipliers];
        let [before, after] = ends.map(|all| off_together(all, at));
        let is_within = |part: f64, off: Option<f64>| off.is_some_and(|off| off.abs() <= part);
        // One that comes to 1 and back is at a point where branches meet: rounding says on which side.
        let comes_near = at < 0.0 && ends.iter().any(|all| is_within(CLOSE, passes(all, at)));
        let may_change = ends.iter().any(|all| is_within(AROUND, straddles(all, at)));
        if !(before * after > 0.0 && (comes_near || may_change)) {
            return None;
        }
        let rounding = match at < 0.0 {
            true => 0.0,
            false => BY_ROUNDING * before.abs().max(after.abs()),
        };
        let mut known = vec![(0.0, before.abs()), (1.0, after.abs())];
        let mut part = 0.5;
        for _ in 0..LOOKS {
            let (station, _) = from.ahead(&mut self.shooting, part * step).ok()?;
            self.settle(&station);
            let value =
                off_together(&self.shooting.multipliers_at(&station).0, at) * before.signum();
            if value < -rounding {
                let is_on_it = at < 0.0 || !self.is_beside_meeting(from, part * step, &station);
                return is_on_it.then_some(part);
            }
            let place = known.partition_point(|(other, _)| *other < part);
            known.insert(place, (part, value));
            let values = known.iter().enumerate();
            let (least, _) = values.min_by(|a, b| a.1.1.total_cmp(&b.1.1))?;
            let first = least.saturating_sub(1).min(known.len() - 3);
            let (vertex, lowest) = vertex(&known[first..first + 3])?;
            let is_new = known.iter().all(|(other, _)| *other != vertex);
            let is_inside = vertex > 0.0 && vertex < 1.0;
            if !(is_inside && is_new && lowest < NEARER * known[least].1) {
                return None;
            }
            part = vertex;
        }
        None
    }

    /// Whether a station so far ahead of another was corrected by more than it is away from where branches meet: there it may be on either of them.
    fn is_beside_meeting(&mut self, from: &Station, ahead: f64, station: &Station) -> bool {
        let Ok(met) = meeting(&mut self.shooting, &station.at) else {
            return false;
        };
        let scales = self.shooting.scales();
        let guess = moved(&from.at, &from.tangent, ahead);
        station.distance(&guess, scales) > station.distance(&met.at, scales)
    }

    fn passed_between(
        &mut self,
        halvings: usize,
        (from, to): (&Station, &Station),
        step: f64,
        (here, there): (&Point, &Point),
    ) -> Option<End> {
        let size = from.at.len();
        let (before, after) = (from.tangent[size - 1], to.tangent[size - 1]);
        let (meets, turns) = (
            from.orientation * to.orientation < 0.0,
            before * after < 0.0 && !self.stands_between(from, to),
        );
        // Where nothing is left of an orbit its equations are singular by rounding.
        let is_told = !(self.has_shrunk(from) || self.has_shrunk(to));
        // Where branches meet, one of them may turn.
        if is_told
            && meets
            && let Some(met) = self.branch_point(from, step, (before, after))
        {
            return self.passed_around(met, (from, here), (to, there));
        }
        let fold = (is_told && turns && !meets).then_some(Passed::Fold((before, after)));
        let found = self.passed((from, step), (here, there), (meets || turns, fold));
        if halvings < HALVINGS
            && !found.is_empty()
            && let Some(part) = self.comes_and_goes((from, step), (here, there), &found)
            && let Some(end) = self.between_parts(halvings, (from, to), (step, part), (here, there))
        {
            return end;
        }
        for (passed, station, _) in found {
            self.tell(passed, &station, (here.parameter(), there.parameter()));
        }
        None
    }

    /// The same to both sides of where branches meet: what passes before it may come back after it, as it does on a branch that turns there.
    fn passed_around(
        &mut self,
        met: Met,
        (from, here): (&Station, &Point),
        (to, there): (&Station, &Point),
    ) -> Option<End> {
        let parameters = (here.parameter(), met.point.parameter(), there.parameter());
        let reach = |walker: &Self, from: &Station| from.reach(&met.at, walker.shooting.scales());
        let ahead = reach(self, from);
        for (passed, station, _) in self.passed((from, ahead), (here, &met.point), (true, None)) {
            self.tell(passed, &station, (parameters.0, parameters.1));
        }
        let back = to.clone().reversed();
        let ahead = reach(self, &back);
        let mut beyond = self.passed((&back, ahead), (there, &met.point), (true, None));
        beyond.reverse();
        let end = self.note_branch_point(met);
        if end.is_some() {
            return end;
        }
        for (passed, station, _) in beyond {
            self.tell(passed, &station, (parameters.1, parameters.2));
        }
        None
    }

    /// What changed its sign on the way ahead of a station, in the order in which it did, where, and how far ahead; whether branches meet there or one turns, and
    /// that it does, is known.
    fn passed(
        &mut self,
        (from, step): (&Station, f64),
        (here, there): (&Point, &Point),
        (singular, fold): (bool, Option<Passed>),
    ) -> Vec<(Passed, Station, f64)> {
        let mut kinds: Vec<Passed> = fold.into_iter().collect();
        let both = |value: fn(&[Complex]) -> Option<f64>| {
            let ends = (value(&here.multipliers)?, value(&there.multipliers)?);
            (ends.0 * ends.1 < 0.0).then_some(ends)
        };
        kinds.extend(both(doubling).map(Passed::Doubling));
        let [doublings, meetings] = passing(here, there);
        let places = |at: f64, kind: fn(usize, (f64, f64)) -> Passed| {
            let count = here.multipliers.len();
            let vanish = (0..count).filter_map(move |place| {
                let of = |point: &Point| passes_at_place(&point.multipliers, at, place);
                let ends = (of(here)?, of(there)?);
                (ends.0 * ends.1 < 0.0).then(|| kind(place, ends))
            });
            vanish.collect::<Vec<Passed>>()
        };
        if doublings > 1 {
            kinds.retain(|passed| !matches!(passed, Passed::Doubling(_)));
            kinds.extend(places(-1.0, Passed::DoublingOf));
        }
        if meetings > 1 && !singular {
            kinds.extend(places(1.0, Passed::MeetingOf));
        }
        // A pair that stays on the circle, as where energy is conserved, changes sides by rounding: its product, which changes by twice as much as
        // its modulus, is to change by more than that is known to.
        let error = here.modulus_error.max(there.modulus_error);
        let is_pair = |ends: &(f64, f64)| (ends.0 - ends.1).abs() > 2.0 * error;
        // Of two that pass -1, or 1, at once the product passes 1.
        let torus =
            both(passes_together).filter(|ends| is_pair(ends) && doublings.max(meetings) < 2);
        let moduli = [here, there].map(|point| pair(&point.multipliers));
        let off = match moduli {
            [Some(before), Some(after)] => {
                (error * (there.parameter() - here.parameter()) / (after - before)).abs()
            }
            _ => 0.0,
        };
        kinds.extend(torus.map(|ends| Passed::Torus(ends, off)));
        let functions = self.shooting.workshop.monitors.len();
        for index in 0..functions {
            let ends = (here.monitors[index], there.monitors[index]);
            // What is zero all along, as a function that vanishes on the section, changes its sign by rounding.
            let is_told = [(here, ends.0), (there, ends.1)]
                .into_iter()
                .any(|(point, value)| value.abs() > self.monitor_level(index, point));
            if ends.0 * ends.1 < 0.0 && is_told {
                kinds.push(Passed::Monitor(index, ends));
            }
        }
        let located = kinds.into_iter().filter_map(|passed| {
            let (station, ahead) = self.located(passed, from, step)?;
            Some((passed, station, ahead))
        });
        let mut located: Vec<(Passed, Station, f64)> = located.collect();
        located.sort_by(|a, b| a.2.total_cmp(&b.2));
        located
    }

    /// Whether the parameter goes nowhere between two stations, and to neither side at any of them, but for rounding: so it is in a family of
    /// orbits at one value of it.
    fn stands_between(&self, from: &Station, to: &Station) -> bool {
        let scale = self.shooting.scales().last().copied().unwrap_or(1.0);
        let value = from.parameter();
        let slopes = [from, to].map(|station| station.parameter_slope().abs());
        slopes.iter().all(|slope| *slope <= STANDS * scale)
            && (to.parameter() - value).abs() <= roundoff(value.abs()).max(STANDS * scale)
    }

    /// Below this a function of the user's is not told from zero.
    fn monitor_level(&self, index: usize, point: &Point) -> f64 {
        let workshop = &self.shooting.workshop;
        let parameters = workshop.parameters(&point.parameters);
        let sizes = self.shooting.state_sizes();
        let known = (&*point.state, &*sizes);
        workshop.monitors[index].level(&workshop.model.graph, known, &parameters)
    }

    /// The same where a graze is at one of the ends, at the first if `opens`: multipliers change there as one over the rate of an
    /// impact, so that pairs come about and go between two stations. They are looked at on ever shorter ways towards it.
    pub(super) fn between_beside_graze(
        &mut self,
        (from, to): (&Station, &Station),
        step: f64,
        (here, there): (&Point, &Point),
        opens: bool,
    ) -> Option<End> {
        let (mut station, mut point, mut gone) = (from.clone(), here.clone(), 0.0);
        if lasting(here).max(lasting(there)) > 1 {
            let nearer = |k: i32| SHORTER.powi(k);
            let parts: Vec<f64> = match opens {
                true => (1..=TOWARDS).rev().map(nearer).collect(),
                false => (1..=TOWARDS).map(|k| 1.0 - nearer(k)).collect(),
            };
            for part in parts {
                let ahead = part * step - gone;
                let Ok((next, _)) = station.ahead(&mut self.shooting, ahead) else {
                    break;
                };
                self.settle(&next);
                let further = Point::new(&mut self.shooting, &next);
                if let Some(end) = self.between(&station, &next, ahead, (&point, &further)) {
                    return Some(end);
                }
                (station, point, gone) = (next, further, part * step);
            }
        }
        let left = match gone > 0.0 {
            true => station.reach(&to.at, self.shooting.scales()),
            false => step,
        };
        self.between(&station, to, left, (&point, there))
    }

    /// Where what has passed vanishes, and how far ahead.
    fn located(&mut self, passed: Passed, from: &Station, step: f64) -> Option<(Station, f64)> {
        // The problem is what is evaluated; its copy tells what there is to tell of the stations found.
        let mut reader = self.shooting.clone();
        let mut of =
            |ends: (f64, f64), value: &dyn Fn(&mut Shooting<f64>, &Station) -> Option<f64>| {
                let mut least = f64::INFINITY;
                let found = locate(&mut self.shooting, from, step, ends, &mut |_, station| {
                    reader.evaluate(&station.at).ok()?;
                    let value = value(&mut reader, station)?;
                    least = least.min(value.abs());
                    Some(value)
                });
                // What jumps, as a multiplier does from one infinity to the other, has no zero.
                found.filter(|_| least <= VANISHES * ends.0.abs().max(ends.1.abs()))
            };
        match passed {
            Passed::Fold(ends) => of(ends, &|_, station| station.tangent.last().copied()),
            Passed::Doubling(ends) => of(ends, &|reader, station| {
                doubling(&reader.multipliers_at(station).0)
            }),
            Passed::DoublingOf(place, ends) => of(ends, &|reader, station| {
                passes_at_place(&reader.multipliers_at(station).0, -1.0, place)
            }),
            Passed::MeetingOf(place, ends) => of(ends, &|reader, station| {
                passes_at_place(&reader.multipliers_at(station).0, 1.0, place)
            }),
            Passed::Torus(ends, _) => of(ends, &|reader, station| {
                passes_together(&reader.multipliers_at(station).0)
            }),
            Passed::Monitor(index, ends) => of(ends, &|reader, station| {
                reader.monitored(&station.at).get(index).copied()
            }),
        }
    }

    /// Solves for it from there, between these values of the parameter, and tells it.
    fn tell(&mut self, passed: Passed, station: &Station, (low, high): (f64, f64)) {
        let rough = station.parameter();
        let mut refined = station.clone();
        let mut error = UNREFINED * rough.abs();
        let mut residual = f64::NAN;
        let mut above = None;
        let near = 1e-3 * (low - high).abs();
        let scale = self.shooting.scales()[station.at.len() - 1];
        let mut take = |found: Solved| {
            let moved = (found.at[found.at.len() - 1] - rough).abs();
            // Nearer than where the sign changed, or something else was found.
            let is_it = moved <= near.max(1e-12 * scale);
            if is_it {
                refined.at = found.told;
                error = found.error;
                residual = found.residual;
            }
            is_it
        };
        // A function of the user's is one of the state at the section.
        let mut at_section = None;
        let condition = match passed {
            Passed::Fold(_) => Some(Condition::Singular(1.0)),
            Passed::Doubling(_) | Passed::DoublingOf(..) => Some(Condition::Singular(-1.0)),
            Passed::Torus(..) | Passed::MeetingOf(..) => None,
            Passed::Monitor(index, _) => {
                let other = self.shooting.with_section(&station.at).ok().flatten();
                if let Some((mut longer, guess)) = other {
                    let function = Bordered::Monitor(longer.user_function(index));
                    if let Ok(found) = longer.solved(&function, &guess) {
                        let at = found.told.clone();
                        if take(found) {
                            at_section = Some(Seed {
                                shooting: longer,
                                at,
                            });
                        }
                    }
                    None
                } else {
                    Some(Condition::Monitor(self.shooting.user_function(index)))
                }
            }
        };
        if let Some(condition) = condition
            && let Ok(bordered) = condition.near(&mut self.shooting, &station.at, None)
            && let Ok(found) = self.shooting.solved(&bordered, &station.at)
        {
            take(found);
        }
        if let Passed::Torus(_, off) = passed {
            error = off.max(roundoff(rough));
        }
        if let Some(Seed { mut shooting, at }) = at_section {
            refined.at = at;
            if shooting.evaluate(&refined.at).is_err() {
                return;
            }
            let here = Point::new(&mut shooting, &refined);
            let at = refined.at;
            let seed = Seed { shooting, at };
            self.note_with(passed.kind(), here, seed, (error, residual));
            if let (Some(special), Passed::Monitor(index, _)) = (self.special.last_mut(), passed) {
                special.monitor = Some(index);
            }
            return;
        }
        self.settle(&refined);
        let mut here = Point::new(&mut self.shooting, &refined);
        let neutral = neutral(&here.multipliers);
        if residual.is_nan() {
            residual = match (passed, &neutral) {
                (Passed::Torus(..), Some((off, ..))) => off.abs(),
                (Passed::Torus(..), None) => f64::NAN,
                _ => refined.residual,
            };
        }
        let is_it = match passed {
            Passed::Fold(_) | Passed::MeetingOf(..) => is_near(&here.multipliers, 1.0),
            Passed::Doubling(_) | Passed::DoublingOf(..) => is_near(&here.multipliers, -1.0),
            // One of two real multipliers may as well be the inverse of the other.
            Passed::Torus(..) => {
                neutral.is_some_and(|(off, sum, _)| off.abs() < NEAR_ONE && sum.abs() < 2.0)
            }
            Passed::Monitor(..) => true,
        };
        if !is_it {
            return;
        }
        here.correction = refined.correction;
        let at = refined.at.clone();
        match passed {
            Passed::Fold((before, after)) => above = Some(after > before),
            Passed::Doubling(_) | Passed::DoublingOf(..) => above = self.doubles_above(&at),
            _ => {}
        }
        self.note(passed.kind(), &here, &at, error, residual);
        if let Some(special) = self.special.last_mut() {
            special.above = above;
            if let Passed::Monitor(index, _) = passed {
                special.monitor = Some(index);
            }
        }
    }

    /// Whether the doubled orbits beside a period doubling are where the parameter is greater; of a linear map all are at one value.
    fn doubles_above(&mut self, at: &[f64]) -> Option<bool> {
        let singular = Singular::near(&mut self.shooting, at, -1.0).ok()?;
        let free = self.shooting.parameters();
        let unit = |index: usize| -> Vec<f64> {
            (0..free).map(|k| f64::from(u8::from(k == index))).collect()
        };
        let held: Vec<Vec<f64>> = (0..free - 1).map(unit).collect();
        let by = shift(&self.shooting, at, &singular, (&unit(free - 1), &held))?;
        Some(by > 0.0)
    }
}
