//! The map z -> Upsilon(K z + mu) near a border orbit, equation (25).

use super::argument::Argument;
use super::error::UniversalError;
use super::evaluate::Universal;
use super::scales::lift;
use crate::analysis::map::{Batch, Differentiable, Map, NoReturn, Passage, Tangent};
use crate::numerics::dispatch::{Kernel, dispatch};
use crate::numerics::{Lanes, Real};

/// z -> Upsilon(K z + mu).
///
/// As a [`Map`] its point is `z` and its parameters are `slope` (K) and `mu`; both may be swept.
#[derive(Clone, Debug)]
pub struct UniversalMap<R> {
    universal: Universal<R>,
    slope: R,
    offset: R,
}

/// Lanes that go through the map together: two vectors of AVX-512, four of AVX2.
const LANES: usize = 16;
/// Places of the parameters.
const SLOPE: usize = 0;
const OFFSET: usize = 1;

/// z -> Upsilon(K z + mu) on any number of lanes, each with its own K and mu.
#[inline(always)]
pub(super) fn next<R: Real, T: Argument<Real = R>>(
    universal: &Universal<R>,
    slope: T,
    offset: T,
    z: T,
) -> T {
    universal.upsilon(slope.mul_add(z, offset))
}

impl<R: Real> UniversalMap<R> {
    /// The map with slope K and offset mu.
    ///
    /// # Errors
    /// [`UniversalError::Slope`] where K is zero or not finite, [`UniversalError::Offset`] where mu is not finite.
    pub fn new(universal: Universal<R>, slope: R, offset: R) -> Result<Self, UniversalError> {
        UniversalError::check_slope(slope)?;
        let mu = offset.to_f64();
        if !mu.is_finite() {
            return Err(UniversalError::Offset { value: mu });
        }
        Ok(Self {
            universal,
            slope,
            offset,
        })
    }

    /// Upsilon.
    pub fn universal(&self) -> &Universal<R> {
        &self.universal
    }

    /// K.
    pub fn slope(&self) -> R {
        self.slope
    }

    /// mu.
    pub fn offset(&self) -> R {
        self.offset
    }

    /// The next point on any number of lanes; to be inlined into a loop run by
    /// [`dispatch`](crate::numerics::dispatch::dispatch).
    #[inline(always)]
    pub fn step<T: Argument<Real = R>>(&self, z: T) -> T {
        next(&self.universal, lift(self.slope), lift(self.offset), z)
    }

    /// The next point and the derivative K Upsilon'(K z + mu) of it, on any number of lanes.
    #[inline(always)]
    pub fn step_with_multiplier<T: Argument<Real = R>>(&self, z: T) -> (T, T) {
        let slope = lift::<R, T>(self.slope);
        let at = self
            .universal
            .evaluation(slope.mul_add(z, lift(self.offset)));
        (at.value, slope * at.derivative)
    }
}

/// A lane is the scalar bit for bit, so lanes are filled up with anything.
struct Steps<'a> {
    universal: &'a Universal<f64>,
    slopes: &'a [f64],
    offsets: &'a [f64],
    points: &'a mut [f64],
}

impl Kernel for Steps<'_> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let rest = self.points.len() - self.points.len() % LANES;
        for first in (0..rest).step_by(LANES) {
            let load = |values: &[f64]| Lanes::<LANES>(core::array::from_fn(|i| values[first + i]));
            let next = next(
                self.universal,
                load(self.slopes),
                load(self.offsets),
                load(self.points),
            );
            self.points[first..first + LANES].copy_from_slice(&next.0);
        }
        for orbit in rest..self.points.len() {
            self.points[orbit] = next(
                self.universal,
                self.slopes[orbit],
                self.offsets[orbit],
                self.points[orbit],
            );
        }
    }
}

impl Map for UniversalMap<f64> {
    fn coordinates(&self) -> Vec<String> {
        vec!["z".to_owned()]
    }

    fn parameters(&self) -> Vec<String> {
        vec!["slope".to_owned(), "mu".to_owned()]
    }

    fn parameter_values(&self, swept: &[(usize, f64)]) -> Vec<f64> {
        let mut values = vec![self.slope, self.offset];
        for &(position, value) in swept {
            values[position] = value;
        }
        values
    }

    /// z = 0: the border orbit itself at mu = 0.
    fn initial_point(&self, _parameters: &[f64]) -> Vec<f64> {
        vec![0.0]
    }

    fn next(&self, parameters: &[f64], point: &mut [f64]) -> Result<Passage, NoReturn> {
        dispatch(Steps {
            universal: &self.universal,
            slopes: &parameters[SLOPE..=SLOPE],
            offsets: &parameters[OFFSET..=OFFSET],
            points: point,
        });
        passage(point[0])
    }

    fn tangent(&self, _swept: &[usize]) -> Option<Box<dyn Map + '_>> {
        Some(Box::new(Tangent(self)))
    }

    fn next_batch(&self, batch: &mut Batch) {
        let [points] = batch.points.as_mut_slice() else {
            return;
        };
        dispatch(Steps {
            universal: &self.universal,
            slopes: &batch.parameters[SLOPE],
            offsets: &batch.parameters[OFFSET],
            points,
        });
        for (outcome, &point) in batch.passages.iter_mut().zip(&*points) {
            *outcome = passage(point);
        }
    }
}

impl Differentiable for UniversalMap<f64> {
    fn jacobian(&self, parameters: &[f64], point: &[f64]) -> Vec<f64> {
        let x = parameters[SLOPE].mul_add(point[0], parameters[OFFSET]);
        vec![parameters[SLOPE] * self.universal.at(x).derivative]
    }
}

/// The map has no time and counts no impacts: n is the integer that Upsilon hides.
fn passage(point: f64) -> Result<Passage, NoReturn> {
    if point.is_finite() {
        Ok(Passage::default())
    } else {
        Err(NoReturn::LeftDomain)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::map::{Command, Origin, Start};
    use crate::numerics::DoubleDouble;
    use core::sync::atomic::AtomicBool;

    fn map(slope: f64, offset: f64) -> UniversalMap<f64> {
        UniversalMap::new(Universal::new(0.8).unwrap(), slope, offset).unwrap()
    }

    #[test]
    fn a_batch_is_its_members() {
        let map = map(1.0, 0.02);
        let starts: Vec<_> = (0..37)
            .map(|k| Start {
                swept: vec![0.001 * f64::from(k)],
                origin: Origin::Point(vec![0.01]),
            })
            .collect();
        let mut orbits = vec![Vec::new(); starts.len()];
        map.follow(
            &[OFFSET],
            &starts,
            &AtomicBool::new(false),
            &mut |arrival| {
                orbits[arrival.orbit].push(arrival.point[0].to_bits());
                if orbits[arrival.orbit].len() == 50 + 3 * arrival.orbit {
                    Command::Retire
                } else {
                    Command::Continue
                }
            },
        );
        for (k, orbit) in orbits.iter().enumerate() {
            let mut point = [0.01];
            for &bits in orbit {
                map.next(&[1.0, 0.001 * k as f64], &mut point).unwrap();
                assert_eq!(point[0].to_bits(), bits);
            }
        }
    }

    #[test]
    fn points_agree_with_double_double() {
        let map = map(-0.7, 0.03);
        let fine = UniversalMap::new(
            Universal::new(DoubleDouble::from(0.8)).unwrap(),
            DoubleDouble::from(-0.7),
            DoubleDouble::from(0.03),
        )
        .unwrap();
        for k in -20..30 {
            let z = 0.001 * f64::from(k);
            let (next, multiplier) = map.step_with_multiplier(z);
            let (exact, exact_multiplier) = fine.step_with_multiplier(DoubleDouble::from(z));
            // K z + mu is rounded here.
            assert!((next - exact.to_f64()).abs() <= 2e-16 * (0.05 + multiplier.abs()));
            assert!((multiplier / exact_multiplier.to_f64() - 1.0).abs() < 1e-12);
            assert_eq!(map.jacobian(&[-0.7, 0.03], &[z]), [multiplier]);
            assert_eq!(map.step(z).to_bits(), next.to_bits());
        }
    }

    #[test]
    fn a_point_that_is_lost_is_no_point() {
        let map = map(1.0, 0.02);
        let lost = map.next(&[1e200, 1e200], &mut [1e200]);
        assert_eq!(lost, Err(NoReturn::LeftDomain));
        assert_eq!(
            UniversalMap::new(map.universal().clone(), 0.0, 0.1).err(),
            Some(UniversalError::Slope { value: 0.0 })
        );
        assert_eq!(
            UniversalMap::new(map.universal().clone(), 1.0, f64::INFINITY).err(),
            Some(UniversalError::Offset {
                value: f64::INFINITY
            })
        );
    }
}
