//! Narrow bumps on the contact surface, which no Taylor coefficient far away shows: against the ball's parabola, sampled
//! densely. No impact is missed, and none made up.

use chatter::flow::{Occurrence, Settings, System, Trajectory};
use chatter::model::Model;
use chatter::numerics::{DoubleDouble, Real};
use proptest::prelude::*;

const START: f64 = 2.0;
const RATE: f64 = 0.5;
const UNTIL: f64 = 6.0;

#[derive(Clone, Copy, Debug)]
enum Shape {
    Exponential,
    Gaussian,
    Power,
    Cosine,
    Pulse,
    Ramp,
    Resonance,
}

/// A bump of this shape at `place`, whose width is that of e^(-sharpness (t - place)^2 / 2).
#[derive(Clone, Copy, Debug)]
struct Bump {
    shape: Shape,
    sharpness: f64,
    place: f64,
    height: f64,
    /// Amplitude of the table that it sits on.
    wave: f64,
}

impl Bump {
    fn text(&self) -> String {
        let (w, c) = (self.sharpness, self.place);
        let root = w.sqrt();
        let shape = match self.shape {
            Shape::Exponential => format!("exp({w:e}*(cos(t - {c:e}) - 1))"),
            Shape::Gaussian => format!("exp(-{w:e}*(t - {c:e})^2/2)"),
            Shape::Power => format!("((1 + cos(t - {c:e}))/2)^{}", (2.0 * w).round()),
            Shape::Cosine => format!("cos((t - {c:e})/2)^{}", 2.0 * (2.0 * w).round()),
            Shape::Pulse => format!("1/cosh({root:e}*(t - {c:e}))"),
            Shape::Ramp => format!("(1 + tanh({root:e}*(t - {c:e})))/2"),
            Shape::Resonance => format!("1/(1 + {w:e}*(t - {c:e})^2)"),
        };
        format!("{:e}*sin(t) + {:e}*{shape}", self.wave, self.height)
    }

    fn at(&self, t: f64) -> f64 {
        let (w, off) = (self.sharpness, t - self.place);
        let root = w.sqrt();
        let shape = match self.shape {
            Shape::Exponential => (w * (off.cos() - 1.0)).exp(),
            Shape::Gaussian => (-w * off * off / 2.0).exp(),
            Shape::Power => ((1.0 + off.cos()) / 2.0).powf((2.0 * w).round()),
            Shape::Cosine => (off / 2.0).cos().abs().powf(2.0 * (2.0 * w).round()),
            Shape::Pulse => 1.0 / (root * off).cosh(),
            Shape::Ramp => (1.0 + (root * off).tanh()) / 2.0,
            Shape::Resonance => 1.0 / (1.0 + w * off * off),
        };
        self.wave * t.sin() + self.height * shape
    }

    fn gap(&self, t: f64) -> f64 {
        START + RATE * t - 0.5 * t * t - self.at(t)
    }

    /// The first sample below the surface, and whether a gap without impact comes too near to zero to be sure.
    fn reference(&self) -> (Option<f64>, bool) {
        const STEP: f64 = 2e-5;
        const CLOSE: f64 = 1e-3;
        let mut nearest = f64::INFINITY;
        let mut rising = false;
        let mut before = self.gap(0.0);
        for k in 1..=(UNTIL / STEP) as usize {
            let t = k as f64 * STEP;
            let gap = self.gap(t);
            if gap < 0.0 {
                return (Some(t), nearest < CLOSE);
            }
            if gap > before && !rising {
                nearest = nearest.min(before);
            }
            rising = gap > before;
            before = gap;
        }
        (None, nearest < CLOSE)
    }

    fn first_impact<R: Real>(&self) -> Option<f64> {
        let text = format!(
            "[parameters]\nr = 0.5\n[flight]\ny = \"v\"\nv = \"-1\"\n[[contact]]\nname = \"table\"\ngap = \"y - ({})\"\n\
             impulse = {{ v = 1 }}\nrestitution = \"r\"\n[initial]\ny = {START}\nv = {RATE}\n",
            self.text()
        );
        let model = Model::from_toml(&text, "bump").unwrap_or_else(|errors| panic!("{errors:?}"));
        let system = System::new(&model).unwrap();
        let parameters = model.parameter_values::<R>(&[]);
        let mut work = system.workspace::<R>(&Settings::default());
        let initial = model.initial_state(&parameters);
        let mut trajectory =
            Trajectory::start(&system, &mut work, &parameters, R::ZERO, &initial).unwrap();
        loop {
            let until = R::splat(UNTIL);
            match trajectory.advance(&system, &mut work, until).unwrap() {
                Some(Occurrence::Impact { .. }) => return Some(trajectory.time().to_f64()),
                Some(Occurrence::Horizon) => return None,
                _ => {}
            }
        }
    }
}

fn bumps() -> impl Strategy<Value = Bump> {
    let shapes = prop_oneof![
        Just(Shape::Exponential),
        Just(Shape::Gaussian),
        Just(Shape::Power),
        Just(Shape::Cosine),
        Just(Shape::Pulse),
        Just(Shape::Ramp),
        Just(Shape::Resonance),
    ];
    let wave = prop_oneof![Just(0.0), Just(0.2)];
    (shapes, 1.0..6.0, 0.5..5.0, 0.1..1.5, wave).prop_map(
        |(shape, decades, place, height, wave)| Bump {
            shape,
            // Powers of cosh must not overflow.
            sharpness: match shape {
                Shape::Pulse => 10f64.powf(decades).min(500.0),
                // More than a thousand factors are no product any more: the base must be positive.
                Shape::Cosine => 10f64.powf(decades).min(250.0),
                _ => 10f64.powf(decades),
            },
            place,
            height,
            wave,
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn no_bump_is_flown_through(bump in bumps()) {
        let (expected, doubtful) = bump.reference();
        prop_assume!(!doubtful);
        for found in [bump.first_impact::<f64>(), bump.first_impact::<DoubleDouble>()] {
            match (expected, found) {
                (None, None) => {}
                (Some(expected), Some(found)) => {
                    prop_assert!((expected - 3e-5..=expected + 1e-8).contains(&found), "{found} {expected}");
                }
                _ => prop_assert!(false, "{found:?} {expected:?}"),
            }
        }
    }
}

/// The argument of the hyperbolic tangent goes from -1300 to beyond zero before the ball would fall back on the table.
#[test]
fn a_step_is_seen_from_afar() {
    for (sharpness, place) in [
        (531_010.0, 1.795),
        (1e6, 0.6),
        (3e5, 2.4),
        (1e5, 1.1),
        (7e4, 1.9),
    ] {
        let bump = Bump {
            shape: Shape::Ramp,
            sharpness,
            place,
            height: 1.5,
            wave: 0.2,
        };
        let (expected, _) = bump.reference();
        for found in [
            bump.first_impact::<f64>(),
            bump.first_impact::<DoubleDouble>(),
        ] {
            let off = found.unwrap() - expected.unwrap();
            assert!(off.abs() < 3e-5, "{bump:?}: {off}");
        }
    }
}
