//! Where a branch ends since its orbit shrinks to an equilibrium, of which a pair of eigenvalues is imaginary there: a Hopf bifurcation.
//!
//! Through that point the equations of the orbit go on along the same orbits, told half a turn later: with the rate at which the section is
//! crossed of the other sign. So they do where the section is only touched, which is no matter of the orbit: that is told from a plane
//! across the flow from there on.

use super::equilibrium::Equilibrium;
use super::forced_rest::ALIKE;
use crate::analysis::continuation::{Curve, Problem, Station, locate};
use crate::analysis::periodic::branch::special::Seed;
use crate::analysis::periodic::branch::walker::Walker;
use crate::analysis::periodic::branch::{End, Point, SpecialKind};
use crate::analysis::periodic::cycle::itinerary::{Passage, Step};
use crate::analysis::periodic::multipliers::{ROUNDED, without_rounding};
use crate::analysis::periodic::shooting::Shooting;
use crate::analysis::periodic::solved::NOISE;
use crate::flow::GuardKind;
use crate::numerics::{Complex, eigenvalues};
use core::f64::consts::TAU;

/// Where the section is touched an orbit that moves slower than this part of what it did a step before has shrunk to nothing.
const SHRUNK: f64 = 1e-2;
/// Special points are looked for up to the first of these parts of the way to there.
const NEARLY: [f64; 4] = [0.999, 0.99, 0.9, 0.5];
/// The first two values of the parameter for the secant, apart by this part of its size; and so many more are never needed.
const APART: f64 = 1e-4;
const MOST: usize = 50;
/// A step on which an orbit turns too far against the plane that it is told from is taken again with this part of its length.
const SHORTER: f64 = 0.4;
/// Where nothing is left of an orbit is no farther from the last one than this part of the parameter's size.
const HERE: f64 = 1e-3;
/// A pair is imaginary, with the frequency of the last orbit, up to this part of that.
const SAME_FREQUENCY: f64 = 0.1;

/// A Hopf point.
struct Hopf {
    parameter: f64,
    error: f64,
    /// The real part of the pair that is left.
    residual: f64,
    frequency: f64,
    state: Vec<f64>,
    eigenvalues: Vec<Complex>,
}

impl Shooting<f64> {
    /// The rates at which the section is crossed at the ends of steps, where the orbit is told from it and nothing else happens there;
    /// or from a plane across the flow; zero for other steps.
    pub(in crate::analysis::periodic::branch) fn section_rates(&self) -> Vec<f64> {
        let rates = self.steps.iter().zip(&self.latest).map(|(step, landing)| {
            let is_plain = match step.ends_at() {
                Some(GuardKind::Section(section)) => !self.workshop.system.is_event(section),
                _ => matches!(step.passage, Passage::Around(_)),
            };
            if is_plain && !step.is_stretch() {
                landing.surface_rate
            } else {
                0.0
            }
        });
        rates.collect()
    }

    /// Where the pair of eigenvalues with about this frequency is imaginary, of the equilibrium near the node after a step.
    fn hopf(&self, at: &[f64], (index, frequency): (usize, f64)) -> Option<Hopf> {
        let mut equilibria = self.equilibria(at, index)?;
        let (sizes, scale) = (self.state_sizes(), *self.scales().last()?);
        let own = self.free(at).to_vec();
        let mut known = self.node(at, index).to_vec();
        let mut pair_at = |parameter: f64| -> Option<(Complex, Equilibrium, Vec<Complex>)> {
            let mut free = own.clone();
            *free.last_mut()? = parameter;
            let parameters = self.workshop.parameters(&free);
            equilibria.parameters = self.parameters_of(&parameters, &self.steps[index]);
            let found = equilibria.near(&known, &sizes)?;
            known.clone_from(&found.state);
            let all = eigenvalues(&found.slopes);
            let off = |x: &Complex| x.re.hypot(x.im - frequency);
            let pair = *all.iter().min_by(|a, b| off(a).total_cmp(&off(b)))?;
            (off(&pair) <= SAME_FREQUENCY * frequency).then_some((pair, found, all))
        };
        let start = *own.last()?;
        let (mut before, mut now) = (start + APART * scale, start);
        let mut was = pair_at(before)?.0.re;
        for _ in 0..MOST {
            let (pair, found, all) = pair_at(now)?;
            let slope = (pair.re - was) / (now - before);
            let step = pair.re / slope;
            let largest = all.iter().fold(0.0_f64, |most, x| most.max(x.modulus()));
            let error = NOISE * f64::EPSILON * (now.abs() + (largest / slope).abs());
            if !error.is_finite() {
                return None;
            }
            if step.abs() <= error {
                let mut free = own.clone();
                *free.last_mut()? = now;
                let place = core::slice::from_ref(&found.state);
                let (unlike, _) = self.unlike(at, &free, place)?;
                if unlike > ALIKE * largest {
                    return None;
                }
                return Some(Hopf {
                    parameter: now,
                    error: error + (unlike / slope).abs(),
                    residual: pair.re.abs(),
                    frequency: pair.im,
                    state: found.state,
                    eigenvalues: all,
                });
            }
            (before, was, now) = (now, pair.re, now - step);
        }
        None
    }
}

impl Walker {
    /// How the branch ends where, on the way to the next station, the section that an orbit is told from comes to be crossed the other way;
    /// nothing where it goes on, told from elsewhere or by shorter steps.
    pub(in crate::analysis::periodic::branch) fn loses_section(
        &mut self,
        curve: &mut Curve,
        (step, index): (f64, usize),
        ends: (f64, f64),
        here: &mut Point,
    ) -> Option<End> {
        let from = &curve.station.clone();
        let mut reader = self.shooting.clone();
        let found = locate(&mut self.shooting, from, step, ends, &mut |_, station| {
            reader.evaluate(&station.at).ok()?;
            reader.section_rates().get(index).copied()
        });
        let touch = found.unwrap_or_else(|| (from.clone(), 0.0));
        self.settle(&touch.0);
        let hopf = match self.comes_to_stand(from, &touch.0, index) {
            true => self.hopf_beside(&touch.0, index),
            false => None,
        };
        if hopf.is_none() && self.goes_around(curve, step, here) {
            return None;
        }
        if let Some(end) = self.approaches(from, (&touch.0, touch.1), here) {
            return Some(end);
        }
        self.settle(&touch.0);
        let Some(hopf) = hopf else {
            let guard = self.shooting.steps[index].ends_at();
            let named = guard.map(|guard| self.shooting.workshop.named(guard));
            return Some(End::Lost(format!(
                "the orbit comes to where it only touches the section {} that it is told from",
                named.unwrap_or_default()
            )));
        };
        self.note_hopf(&touch.0, hopf);
        Some(End::Equilibrium)
    }

    /// How the branch ends where, on the way to the next station, an event breaks the sequence since nothing is left of the orbit: its equilibrium
    /// lies on the surface of that. Nothing where something is left, as where a surface just beside is crossed no more.
    pub(in crate::analysis::periodic::branch) fn shrinks(
        &mut self,
        from: &Station,
        (touch, ahead): (&Station, f64),
        (index, here): (usize, &Point),
    ) -> Option<End> {
        if !self.comes_to_stand(from, touch, index) || !self.has_shrunk(touch) {
            return None;
        }
        if self.shooting.steps[index].impact().is_some() {
            let shrunk = self.shrinks_to(from)?;
            let end = self.approaches(from, (touch, ahead), here);
            return Some(end.unwrap_or(End::Shrunk(shrunk)));
        }
        let hopf = self.hopf_beside(touch, index);
        if let Some(end) = self.approaches(from, (touch, ahead), here) {
            return Some(end);
        }
        self.settle(touch);
        let Some(hopf) = hopf else {
            let met = self.meets_rest(touch, index);
            return Some(met.unwrap_or_else(|| self.shrinks_or_has_shrunk(from)));
        };
        self.note_hopf(touch, hopf);
        Some(End::Equilibrium)
    }

    /// The end where nothing is left of an orbit that no forcing moves: at a Hopf point, if its equilibrium has one there.
    pub(in crate::analysis::periodic::branch) fn shrunk(&mut self, station: &Station) -> End {
        self.settle(station);
        let is_forced = self.shooting.counts.iter().any(|&count| count != 0);
        let scale = self.shooting.scales().last().copied().unwrap_or(1.0);
        let is_here = |hopf: &Hopf| (hopf.parameter - station.parameter()).abs() <= HERE * scale;
        let hopf = match is_forced {
            true => None,
            false => self.hopf_beside(station, 0).filter(is_here),
        };
        match hopf {
            Some(hopf) => {
                self.note_hopf(station, hopf);
                End::Equilibrium
            }
            None => self.shrinks_or_has_shrunk(station),
        }
    }

    /// The end at an equilibrium that is no Hopf point, with its value if that can be told from a station.
    fn shrinks_or_has_shrunk(&mut self, station: &Station) -> End {
        (self.shrinks_to(station)).map_or(End::Equilibrium, End::Shrunk)
    }

    /// The way to where an orbit has shrunk to nothing, or is told no more: whether something ends the branch on it.
    fn approaches(
        &mut self,
        from: &Station,
        (touch, ahead): (&Station, f64),
        here: &Point,
    ) -> Option<End> {
        if let Some(edge) = self.limits.beyond(touch.parameter())
            && let Some(end) = self.ends_at_edge((from, touch), (ahead, edge), here)
        {
            return Some(end);
        }
        // What is left of an orbit that is nearer to nothing does not tell which way the parameter goes.
        let nearly = NEARLY.into_iter().find_map(|part| {
            let (nearly, _) = from.ahead(&mut self.shooting, part * ahead).ok()?;
            (!self.has_shrunk(&nearly)).then_some((nearly, part * ahead))
        });
        if let Some((nearly, ahead)) = nearly {
            self.settle(&nearly);
            let near = Point::new(&mut self.shooting, &nearly);
            let ends = (here, &near);
            if let Some(end) = self.between(from, &nearly, ahead, ends) {
                return Some(end);
            }
            self.points.push(near);
        }
        None
    }

    /// Goes on where the section is only touched, told from a plane across the flow; where one of these is, by a shorter step. Whether that
    /// can be.
    fn goes_around(&mut self, curve: &mut Curve, step: f64, here: &mut Point) -> bool {
        let station = &curve.station;
        self.settle(station);
        let Some((mut other, guess)) = self.shooting.told_around(&station.at) else {
            let goes_around = |step: &Step| matches!(step.passage, Passage::Around(_));
            curve.step = SHORTER * step;
            return self.shooting.steps.iter().any(goes_around)
                && curve.step > self.limits.settings().shortest_step;
        };
        let last = guess.len() - 1;
        let Ok(found) = Station::near(&mut other, &guess, last) else {
            return false;
        };
        let found = match (found.parameter_slope() > 0.0) == (station.parameter_slope() > 0.0) {
            true => found,
            false => found.reversed(),
        };
        self.shooting = other;
        self.settle(&found);
        *here = Point::new(&mut self.shooting, &found);
        curve.moves(found);
        true
    }

    /// Whether all speed is lost on the way to where an orbit is at the end of a step.
    fn comes_to_stand(&self, from: &Station, touch: &Station, index: usize) -> bool {
        let sizes = self.shooting.state_sizes();
        let next = self.shooting.after(index);
        let speed = |station: &Station| {
            let equilibria = self.shooting.equilibria(&station.at, index)?;
            Some(equilibria.speed(self.shooting.node(&station.at, next), &sizes))
        };
        let both = speed(touch).zip(speed(from));
        both.is_some_and(|(now, before)| now <= SHRUNK * before)
    }

    /// The Hopf point where an orbit has shrunk to nothing.
    fn hopf_beside(&mut self, touch: &Station, index: usize) -> Option<Hopf> {
        let next = self.shooting.after(index);
        let frequency = TAU / self.shooting.period();
        self.shooting.hopf(&touch.at, (next, frequency))
    }

    /// Notes a Hopf point.
    fn note_hopf(&mut self, touch: &Station, hopf: Hopf) {
        let workshop = self.shooting.workshop.clone();
        let mut free = self.shooting.free(&touch.at).to_vec();
        if let Some(parameter) = free.last_mut() {
            *parameter = hopf.parameter;
        }
        let parameters = workshop.parameters(&free);
        let period = TAU / hopf.frequency;
        // Beside the trivial one the pair leaves another 1: to first order orbits of any size are orbits.
        let mut others = hopf.eigenvalues.clone();
        others.retain(|x| (x.im.abs() - hopf.frequency).abs() > f64::EPSILON * hopf.frequency);
        let largest = (hopf.eigenvalues.iter()).fold(0.0_f64, |most, x| most.max(x.modulus()));
        let rounded = ROUNDED * f64::EPSILON * largest * period;
        let mut multipliers = vec![Complex { re: 1.0, im: 0.0 }];
        multipliers.extend(others.iter().map(|x| {
            let modulus = libm::exp(x.re * period);
            let (sine, cosine) = libm::sincos(x.im * period);
            let multiplier = Complex {
                re: modulus * cosine,
                im: modulus * sine,
            };
            without_rounding(multiplier, rounded * modulus)
        }));
        multipliers
            .sort_by(|a, b| (b.modulus().total_cmp(&a.modulus())).then(b.im.total_cmp(&a.im)));
        let point = Point {
            parameters: free,
            period,
            impacts: Some(0),
            multipliers,
            modulus_error: hopf.error,
            monitors: (workshop.monitors.iter())
                .map(|monitor| monitor.at(&workshop.model.graph, &hopf.state, &parameters))
                .collect(),
            state: hopf.state,
            residual: hopf.residual,
            correction: 0.0,
        };
        let seed = Seed {
            shooting: self.shooting.clone(),
            at: touch.at.clone(),
        };
        self.points.push(point.clone());
        let told = (hopf.error, hopf.residual);
        self.note_with(SpecialKind::Hopf, point, seed, told);
    }
}
