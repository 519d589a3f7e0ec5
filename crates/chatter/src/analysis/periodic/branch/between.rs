//! Special points between two stations with the same sequence of events.

use super::walker::{NOISE, Walker};
use super::{Point, SpecialKind};
use crate::analysis::continuation::{Held, Problem, Singular, Station, locate, newton};
use crate::numerics::Complex;

/// The sign of the product of 1 + m over real multipliers, and the modulus of the largest pair less one.
fn tests(multipliers: &[Complex]) -> (f64, f64) {
    let real = multipliers.iter().filter(|m| m.im == 0.0);
    let sign = real.map(|m| (1.0 + m.re).signum()).product();
    let pair = (multipliers.iter())
        .filter(|m| m.im > 0.0)
        .map(|m| m.modulus() - 1.0)
        .max_by(f64::total_cmp)
        .unwrap_or(f64::NAN);
    (sign, pair)
}

/// 1 + m of the multiplier nearest to -1.
fn doubling_value(multipliers: &[Complex]) -> Option<f64> {
    (multipliers.iter())
        .filter(|m| m.im == 0.0)
        .map(|m| 1.0 + m.re)
        .min_by(|a, b| a.abs().total_cmp(&b.abs()))
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
            kinds.push(SpecialKind::BranchPoint);
        } else if before * after < 0.0 {
            kinds.push(SpecialKind::Fold);
        }
        let (tests_here, tests_there) = (tests(&here.multipliers), tests(&there.multipliers));
        if tests_here.0 * tests_there.0 < 0.0 {
            kinds.push(SpecialKind::PeriodDoubling);
        }
        if tests_here.1 * tests_there.1 < 0.0 {
            kinds.push(SpecialKind::NeimarkSacker);
        }
        for kind in kinds {
            self.find(kind, from, step, (before, after), (here, there));
        }
    }

    fn find(
        &mut self,
        kind: SpecialKind,
        from: &Station,
        step: f64,
        (before, after): (f64, f64),
        (here, there): (&Point, &Point),
    ) {
        // The problem is what is evaluated; its copy tells multipliers of the stations found.
        let mut reader = self.shooting.clone();
        let mut multipliers = |station: &Station| {
            reader.evaluate(&station.at).ok()?;
            Some(reader.multipliers())
        };
        let found = match kind {
            SpecialKind::Fold => locate(
                &mut self.shooting,
                from,
                step,
                (before, after),
                &mut |_, station| station.tangent.last().copied(),
            ),
            SpecialKind::BranchPoint => {
                self.branch_point(from, step, (before, after));
                return;
            }
            SpecialKind::PeriodDoubling => {
                let value = |m: &[Complex]| {
                    let size = doubling_value(m)?.abs();
                    Some(tests(m).0 * size)
                };
                let (Some(a), Some(b)) = (value(&here.multipliers), value(&there.multipliers))
                else {
                    return;
                };
                locate(&mut self.shooting, from, step, (a, b), &mut |_, station| {
                    value(&multipliers(station)?)
                })
            }
            SpecialKind::NeimarkSacker => locate(
                &mut self.shooting,
                from,
                step,
                (tests(&here.multipliers).1, tests(&there.multipliers).1),
                &mut |_, station| {
                    let value = tests(&multipliers(station)?).1;
                    value.is_finite().then_some(value)
                },
            ),
            _ => None,
        };
        let Some((station, _)) = found else {
            return;
        };
        let rough = station.parameter();
        let mut refined = station.clone();
        let mut error = NOISE * f64::EPSILON * rough.abs();
        let mut residual = f64::NAN;
        let sign = match kind {
            SpecialKind::Fold => Some(1.0),
            SpecialKind::PeriodDoubling => Some(-1.0),
            _ => None,
        };
        if let Some(sign) = sign
            && let Ok(singular) = Singular::near(&mut self.shooting, &station.at, sign)
        {
            let mut held = Held::singular(&mut self.shooting, singular);
            if let Ok(found) = newton(&mut held, &station.at, &[]) {
                let last = found.at.len() - 1;
                let scale = held.scales()[last];
                let moved = (found.at[last] - rough).abs();
                // Nearer than where the sign changed, or something else was found.
                if moved
                    <= 1e-3
                        * (from.parameter() - there.parameter())
                            .abs()
                            .max(1e-9 * scale)
                {
                    refined.at = found.at;
                    error = error.max(NOISE * found.correction * scale);
                    residual = found.residual;
                }
            }
        }
        self.settle(&refined);
        let mut here = Point::new(&self.shooting, &refined);
        if residual.is_nan() {
            residual = match kind {
                SpecialKind::NeimarkSacker => tests(&here.multipliers).1.abs(),
                _ => refined.residual,
            };
        }
        here.correction = refined.correction;
        let at = refined.at.clone();
        self.note(kind, &here, &at, error, residual);
    }
}
