//! Two balls on top of each other, whose impacts accumulate while they accumulate on the floor, against their own
//! parabolas, one impact after the other, in double-double.

use chatter::analysis::simulate::{Outcome, Spec, simulate};
use chatter::flow::{Occurrence, Settings, System, Trajectory};
use chatter::model::ModelBuilder;
use chatter::numerics::{DoubleDouble, Real, Scalar};
use proptest::prelude::*;
use std::ops::ControlFlow;

type Dd = DoubleDouble;

/// Two equal balls, dropped in unit gravity from a height, the upper one so much higher.
#[derive(Clone, Copy, Debug)]
struct Stack {
    restitution: f64,
    height: f64,
    above: f64,
}

impl Stack {
    /// When both lie still: every impact one by one, the one that closes fastest first where two happen at one instant.
    fn end(self) -> Dd {
        const REST: f64 = 1e-36;
        let (zero, two) = (Dd::ZERO, Dd::from(2.0));
        let r = Dd::from(self.restitution);
        let mut time = zero;
        let (mut low, mut v_low) = (Dd::from(self.height), zero);
        // The upper ball relative to the lower one.
        let (mut gap, mut rate) = (Dd::from(self.above), zero);
        let mut lies = false;
        loop {
            // Collisions at this instant.
            loop {
                let floor = low <= zero && v_low < zero;
                let pair = gap <= zero && rate < zero;
                if floor && (!pair || v_low <= rate) {
                    rate += (Dd::ONE + r) * v_low;
                    v_low = -r * v_low;
                    lies = false;
                } else if pair {
                    v_low += (Dd::ONE + r) / two * rate;
                    rate = -r * rate;
                    lies = false;
                } else {
                    break;
                }
            }
            let small = |x: Dd| x.abs().to_f64() < REST;
            if low <= zero && small(v_low) {
                if gap <= zero && small(rate) {
                    return time;
                }
                // The end of a sequence on the floor.
                rate += v_low;
                (v_low, lies) = (zero, true);
            }
            let floor = (!lies).then(|| v_low + (v_low * v_low + two * low).sqrt());
            let pair = if lies {
                Some(rate + (rate * rate + two * gap).sqrt())
            } else {
                (rate < zero).then(|| gap / -rate)
            };
            let pair = pair.map_or(1e30.into(), |t| {
                if gap <= zero && rate <= zero {
                    Dd::from(1e30)
                } else {
                    t
                }
            });
            let floor = floor.unwrap_or(Dd::from(1e30));
            let step = if floor <= pair { floor } else { pair };
            time += step;
            gap += rate * step;
            if lies {
                gap -= step * step / two;
                rate -= step;
            } else {
                low += v_low * step - step * step / two;
                v_low -= step;
            }
            if floor <= pair {
                low = zero;
            }
            if pair <= floor {
                gap = zero;
            }
        }
    }

    /// Time of the last accumulation of the library, with the error told.
    fn simulate<R: Real>(self) -> (R, f64) {
        let model = ModelBuilder::new()
            .parameter("r", self.restitution)
            .state("x", "v", self.height)
            .state("v", "-1", 0.0)
            .state("y", "w", self.height + self.above)
            .state("w", "-1", 0.0)
            .contact("floor", "x", [("v", 1.0)], "r")
            .contact("pair", "y - x", [("v", -1.0), ("w", 1.0)], "r")
            .build()
            .expect("a valid model");
        let system = System::new(&model).expect("a valid system");
        let mut work = system.workspace::<R>(&Settings::default());
        let values = model.parameter_values::<f64>(&[]);
        let lift = |value: &f64| R::splat(*value);
        let parameters: Vec<R> = values.iter().map(lift).collect();
        let state: Vec<R> = model.initial_state(&values).iter().map(lift).collect();
        let mut trajectory = Trajectory::start(&system, &mut work, &parameters, R::ZERO, &state)
            .expect("a legal start");
        let mut end = None;
        loop {
            match trajectory
                .advance(&system, &mut work, R::splat(1e3))
                .expect("a finite field")
            {
                Some(Occurrence::Accumulation { error, .. }) => {
                    end = Some((trajectory.time(), error))
                }
                Some(Occurrence::Horizon) => break,
                _ => {}
            }
        }
        assert_eq!(trajectory.closed().contacts().count(), 2, "{self:?}");
        end.expect("an accumulation")
    }
}

#[test]
fn chatter_of_chatter() {
    for (restitution, height, above) in [
        (0.6, 0.5, 0.0),
        (0.6, 0.5, 0.25),
        (0.5, 1.0, 0.0),
        (0.3, 0.5, 0.125),
        (0.7, 0.25, 1.0),
    ] {
        let stack = Stack {
            restitution,
            height,
            above,
        };
        let truth = stack.end();
        let (time, _) = stack.simulate::<Dd>();
        let off = (time - truth).abs().to_f64();
        assert!(off < 1e-12, "{stack:?}, to thirty digits: off by {off:e}");
        let (time, told) = stack.simulate::<f64>();
        let off = (Dd::from(time) - truth).abs().to_f64();
        assert!(off < 1e-12, "{stack:?}: off by {off:e}, told {told:e}");
    }
    let stack = Stack {
        restitution: 0.6,
        height: 0.5,
        above: 0.0,
    };
    assert!((stack.end().to_f64() - 2.224_237_063_64).abs() < 1e-11);
}

/// Three balls on a table that never falls away faster than they do, whose impacts accumulate in turn: a contact whose rate
/// after its impact is lost as another one comes to rest is at rest as well.
#[test]
fn what_chatters_in_turn_comes_to_rest() {
    let together =
        |omega: f64, [r, r1]: [f64; 2], masses: [f64; 3], heights: [f64; 3], rates: [f64; 3]| {
            let [a, b, c] = masses.map(|mass| 1.0 / mass);
            let model = ModelBuilder::new()
                .parameter("omega", omega)
                .state("x", "u", heights[0])
                .state("u", "-9.81", rates[0])
                .state("y", "v", heights[1])
                .state("v", "-9.81", rates[1])
                .state("z", "w", heights[2])
                .state("w", "-9.81", rates[2])
                .contact("table", "x - 0.5*sin(omega*t)", [("u", 1.0)], r)
                .contact("low", "y - x - 0.1", [("v", b), ("u", -a)], r1)
                .contact("high", "z - y - 0.1", [("w", c), ("v", -b)], 0.2)
                .build()
                .expect("a valid model");
            let spec = Spec::until(4.0);
            let run = simulate::<f64>(&model, &spec, &mut |_| ControlFlow::Continue(()))
                .expect("a legal start");
            assert_eq!(run.outcome, Outcome::Horizon, "{heights:?}");
            let table = 0.5 * (omega * 4.0).sin();
            for (index, height) in [(0, 0.0), (2, 0.1), (4, 0.2)] {
                let off = run.state[index] - height - table;
                assert!(
                    off.abs() < 1e-14,
                    "{heights:?}: state {index} is off by {off:e}"
                );
            }
        };
    together(
        2.0,
        [0.8, 0.9],
        [1.0, 1.0, 1.0],
        [0.1, 0.5, 0.6],
        [0.0, 0.0, 1.0],
    );
    together(
        3.0,
        [0.8, 0.7],
        [1.0, 2.0, 0.1],
        [0.5, 0.7, 0.8],
        [1.0, -1.0, 0.5],
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// What is told of the last accumulation, with all that were completed within it, covers by how far it is off.
    #[test]
    fn errors_told_cover_the_truth(
        restitution in 0.2_f64..0.95,
        height in 256_u32..1024,
        above in prop_oneof![Just(0), 0_u32..1024],
    ) {
        const LARGEST_RATIO: f64 = 10.0;
        // Such that the sum is exact.
        let [height, above] = [height, above].map(|n| f64::from(n) / 1024.0);
        let stack = Stack { restitution, height, above };
        let truth = stack.end();
        let (time, told) = stack.simulate::<f64>();
        let off = (Dd::from(time) - truth).abs().to_f64();
        prop_assert!(off <= LARGEST_RATIO * told, "{stack:?}: off by {off:e}, told {told:e}");
        let (time, told) = stack.simulate::<Dd>();
        let off = (time - truth).abs().to_f64();
        prop_assert!(off <= LARGEST_RATIO * told, "to thirty digits {stack:?}: off by {off:e}, told {told:e}");
    }
}
