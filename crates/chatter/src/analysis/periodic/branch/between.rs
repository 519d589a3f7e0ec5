//! Special points between two stations with the same sequence of events.

use super::walker::{NOISE, Walker};
use super::{Point, SpecialKind};
use crate::analysis::continuation::{Problem, Singular, Station, locate, newton};
use crate::analysis::periodic::aside::shift;
use crate::analysis::periodic::condition::Condition;
use crate::analysis::periodic::multipliers::{pair, passes};
use crate::analysis::periodic::shooting::Shooting;
use crate::numerics::Complex;

/// What changed its sign between two stations, and its values there.
#[derive(Clone, Copy, Debug)]
enum Passed {
    Fold((f64, f64)),
    Doubling((f64, f64)),
    Torus((f64, f64)),
    Monitor(usize, (f64, f64)),
}

impl Passed {
    fn kind(self) -> SpecialKind {
        match self {
            Self::Fold(_) => SpecialKind::Fold,
            Self::Doubling(_) => SpecialKind::PeriodDoubling,
            Self::Torus(_) => SpecialKind::NeimarkSacker,
            Self::Monitor(..) => SpecialKind::Monitor,
        }
    }
}

fn doubling(multipliers: &[Complex]) -> Option<f64> {
    passes(multipliers, -1.0)
}

impl Walker {
    /// Special points between two stations with the same sequence of events.
    pub(super) fn between(
        &mut self,
        from: &Station,
        to: &Station,
        step: f64,
        (here, there): (&Point, &Point),
    ) {
        let size = from.at.len();
        let (before, after) = (from.tangent[size - 1], to.tangent[size - 1]);
        let mut kinds = Vec::new();
        if from.orientation * to.orientation < 0.0 {
            // Where branches meet, one of them may turn.
            self.branch_point(from, step, (before, after));
        } else if before * after < 0.0 {
            kinds.push(Passed::Fold((before, after)));
        }
        let both = |value: fn(&[Complex]) -> Option<f64>| {
            let ends = (value(&here.multipliers)?, value(&there.multipliers)?);
            (ends.0 * ends.1 < 0.0).then_some(ends)
        };
        kinds.extend(both(doubling).map(Passed::Doubling));
        kinds.extend(both(pair).map(Passed::Torus));
        let functions = self.shooting.workshop.monitors.len();
        for index in 0..functions {
            let ends = (here.monitors[index], there.monitors[index]);
            if ends.0 * ends.1 < 0.0 {
                kinds.push(Passed::Monitor(index, ends));
            }
        }
        for passed in kinds {
            self.find(passed, from, step, to.parameter());
        }
    }

    fn find(&mut self, passed: Passed, from: &Station, step: f64, far: f64) {
        // The problem is what is evaluated; its copy tells what there is to tell of the stations found.
        let mut reader = self.shooting.clone();
        let mut of = |ends: (f64, f64), value: &dyn Fn(&Shooting<f64>, &Station) -> Option<f64>| {
            locate(&mut self.shooting, from, step, ends, &mut |_, station| {
                reader.evaluate(&station.at).ok()?;
                value(&reader, station)
            })
        };
        let found = match passed {
            Passed::Fold(ends) => of(ends, &|_, station| station.tangent.last().copied()),
            Passed::Doubling(ends) => of(ends, &|reader, _| doubling(&reader.multipliers())),
            Passed::Torus(ends) => of(ends, &|reader, _| pair(&reader.multipliers())),
            Passed::Monitor(index, ends) => of(ends, &|reader, station| {
                Some(reader.monitored(index, &station.at))
            }),
        };
        let Some((station, _)) = found else {
            return;
        };
        let rough = station.parameter();
        let mut refined = station.clone();
        let mut error = NOISE * f64::EPSILON * rough.abs();
        let mut residual = f64::NAN;
        let mut above = None;
        let condition = match passed {
            Passed::Fold(_) => Some(Condition::Singular(1.0)),
            Passed::Doubling(_) => Some(Condition::Singular(-1.0)),
            Passed::Torus(_) => None,
            Passed::Monitor(index, _) => {
                Some(Condition::Monitor(self.shooting.user_function(index)))
            }
        };
        if let Some(condition) = condition
            && let Ok(bordered) = condition.near(&mut self.shooting, &station.at, None)
        {
            let mut held = bordered.of(&mut self.shooting);
            if let Ok(found) = newton(&mut held, &station.at, &[]) {
                let last = found.at.len() - 1;
                let scale = held.scales()[last];
                let moved = (found.at[last] - rough).abs();
                // Nearer than where the sign changed, or something else was found.
                if moved <= 1e-3 * (from.parameter() - far).abs().max(1e-9 * scale) {
                    refined.at = found.at;
                    error = error.max(NOISE * found.correction * scale);
                    residual = found.residual;
                }
            }
        }
        self.settle(&refined);
        let mut here = Point::new(&self.shooting, &refined);
        if residual.is_nan() {
            residual = match passed {
                Passed::Torus(_) => pair(&here.multipliers).map_or(f64::NAN, f64::abs),
                _ => refined.residual,
            };
        }
        here.correction = refined.correction;
        let at = refined.at.clone();
        match passed {
            Passed::Fold((before, after)) => above = Some(after > before),
            Passed::Doubling(_) => above = self.doubles_above(&at),
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

    /// Whether the doubled orbits beside a period doubling are where the parameter is greater.
    fn doubles_above(&mut self, at: &[f64]) -> Option<bool> {
        let singular = Singular::near(&mut self.shooting, at, -1.0).ok()?;
        let free = self.shooting.parameters();
        let unit = |index: usize| -> Vec<f64> {
            (0..free).map(|k| f64::from(u8::from(k == index))).collect()
        };
        let held: Vec<Vec<f64>> = (0..free - 1).map(unit).collect();
        shift(&self.shooting, at, &singular, (&unit(free - 1), &held)).map(|shift| shift > 0.0)
    }
}
