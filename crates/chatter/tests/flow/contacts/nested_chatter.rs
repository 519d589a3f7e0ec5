//! Two balls on top of each other, whose impacts accumulate while they accumulate on the floor, against their own
//! parabolas, one impact after the other, in double-double.

use chatter::flow::{Occurrence, Settings, System, Trajectory};
use chatter::model::ModelBuilder;
use chatter::numerics::{DoubleDouble, Real, Scalar};
use proptest::prelude::*;

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
        if std::env::var("RATIO").is_ok() { println!("f64 {off:e} {told:e} {:.2} {stack:?}", off / told); }
        else { prop_assert!(off <= LARGEST_RATIO * told, "{stack:?}: off by {off:e}, told {told:e}"); }
        let (time, told) = stack.simulate::<Dd>();
        let off = (time - truth).abs().to_f64();
        if std::env::var("RATIO").is_ok() { println!("dd {off:e} {told:e} {:.2} {stack:?}", off / told); }
        else { prop_assert!(off <= LARGEST_RATIO * told, "to thirty digits {stack:?}: off by {off:e}, told {told:e}"); }
    }
}
