//! Piecewise models against exact solutions, and random ones against an independent reference: in each mode a linear system,
//! followed by its own series in short steps, corners found by sampling and bisection, sliding by Filippov's formula.

use chatter::expressions::Side;
use chatter::flow::{Column, FlowError, Occurrence, Settings, System, Trajectory};
use chatter::model::{Direction, Model, ModelBuilder};
use chatter::numerics::{DoubleDouble, Real, Scalar};
use core::cell::Cell;
use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use std::f64::consts::PI;

fn read(text: &str) -> Model {
    Model::from_toml(text, "test").unwrap_or_else(|errors| panic!("{errors:?}"))
}

struct Told<R> {
    time: R,
    state: Vec<R>,
    what: Occurrence<R>,
}

/// Everything that happens, and the state at the end.
fn follow<R: Real>(model: &Model, until: f64) -> Result<(Vec<Told<R>>, Vec<R>), FlowError> {
    let system = System::new(model).expect("a valid system");
    let mut work = system.workspace::<R>(&Settings::default());
    let parameters = model.parameter_values::<R>(&[]);
    let state = model.initial_state(&parameters);
    let mut trajectory = Trajectory::start(&system, &mut work, &parameters, R::ZERO, &state)?;
    let mut told = Vec::new();
    loop {
        match trajectory.advance(&system, &mut work, R::splat(until))? {
            None => {}
            Some(Occurrence::Horizon) => return Ok((told, trajectory.state().to_vec())),
            Some(what) => told.push(Told {
                time: trajectory.time(),
                state: trajectory.state().to_vec(),
                what,
            }),
        }
    }
}

/// The amplitude falls by 4 mu N / k a cycle, exactly, and the mass stops where friction holds it.
#[test]
fn dry_friction_takes_four_times_its_force_a_cycle() {
    for (amplitude, friction) in [(1.05, 0.1), (7.3, 0.31), (0.55, 0.07), (2.0, 0.6)] {
        let model = ModelBuilder::new()
            .parameter("f", friction)
            .state("x", "v", amplitude)
            .state("v", "-x - f*sign(v)", 0.0)
            .build()
            .expect("a valid model");
        let (told, end) = follow::<f64>(&model, 400.0).expect("a motion");
        let mut expected = amplitude;
        let mut turns = 0;
        while expected > friction {
            expected -= 2.0 * friction;
            turns += 1;
            let turn = &told[turns - 1];
            let sign = if turns % 2 == 1 { -1.0 } else { 1.0 };
            assert!(
                (turn.time - PI * turns as f64).abs() < 1e-12 * turn.time,
                "{amplitude}"
            );
            assert!((turn.state[0] - sign * expected).abs() < 1e-13 * amplitude);
            let sticks = expected.abs() < friction;
            assert_eq!(
                sticks,
                matches!(turn.what, Occurrence::Slide { .. }),
                "{amplitude}"
            );
        }
        assert_eq!(told.len(), turns, "{amplitude} {friction}");
        assert_eq!(end[1], 0.0);
        assert!((end[0].abs() - expected.abs()).abs() < 1e-13 * amplitude);
    }
}

/// Stick and slip on a belt: slip is an arc of a circle around the point where friction balances the spring.
#[test]
fn a_mass_on_a_belt_sticks_and_slips() {
    let (slip, belt) = (0.4, 0.3_f64);
    let model = read(&format!(
        "[flight]\nx = \"v\"\nv = \"-x - {slip}*sign(v - {belt})\"\n[initial]\nx = -0.3\nv = 0.0\n"
    ));
    let (told, _) = follow::<f64>(&model, 30.0).expect("a motion");
    let radius = slip + 0.3;
    let arc = (belt / radius).asin();
    assert!(matches!(told[0].what, Occurrence::Slide { .. }));
    assert!((told[0].time - arc).abs() < 1e-14);
    let at = slip - radius * arc.cos();
    let leaves = arc + (slip - at) / belt;
    assert!(matches!(
        told[1].what,
        Occurrence::Leave {
            side: Side::Below,
            ..
        }
    ));
    assert!((told[1].time - leaves).abs() < 1e-13);
    assert!((told[1].state[0] - slip).abs() < 1e-14);
}

/// Two half periods of different length, exactly; and the energy is kept over ten thousand corners, whatever the stiffness: what a
/// step rounds is not rounded in the same direction in each period.
#[test]
fn a_bilinear_oscillator_keeps_energy_and_period() {
    for stiffness in [
        2.0_f64, 2.5, 3.0, 4.0, 5.0, 6.0, 7.0, 7.3, 8.0, 8.1, 8.5, 9.0,
    ] {
        let model = read(&format!(
            "[flight]\nx = \"v\"\nv = \"-x - {:?}*max(x, 0)\"\n[initial]\nx = -1.0\nv = 0.0\n",
            stiffness - 1.0
        ));
        let corners = 10_000;
        let short = PI / stiffness.sqrt();
        let until = (PI + short) * corners as f64 / 2.0 + 0.1;
        let (told, _) = follow::<f64>(&model, until).expect("a motion");
        assert_eq!(told.len(), corners, "{stiffness}");
        for (k, corner) in told.iter().enumerate() {
            let half = k.div_ceil(2);
            let expected = PI / 2.0 + half as f64 * short + (k - half) as f64 * PI;
            let (time, speed) = (corner.time, corner.state[1].abs());
            assert!(
                (time - expected).abs() < 1e-11,
                "{stiffness}, {k}: {time} {expected}"
            );
            assert!((speed - 1.0).abs() < 1e-14, "{stiffness}, {k}: {speed}");
        }
        let (told, _) = follow::<DoubleDouble>(&model, 30.0).expect("a motion");
        let last = told.last().expect("a corner");
        let energy = last.state[1] * last.state[1] - DoubleDouble::ONE;
        assert!(energy.to_f64().abs() < 1e-29, "{stiffness}");
    }
}

/// Functions of the language, each as it is defined, along a motion that passes all their corners.
#[test]
fn functions_follow_their_definitions() {
    type Function = (&'static str, fn(f64) -> f64);
    let functions: [Function; 12] = [
        ("abs(x)", f64::abs),
        ("max(x, 0.3, -x)", |x| x.max(0.3).max(-x)),
        ("min(x, 0.3, 2*x)", |x| x.min(0.3).min(2.0 * x)),
        ("clamp(x, -0.4, 0.7)", |x| x.clamp(-0.4, 0.7)),
        ("sign(x - 0.1)", |x| (x - 0.1).signum()),
        ("step(x)", |x| f64::from(u8::from(x >= 0.0))),
        ("floor(3*x)", |x| (3.0 * x).floor()),
        ("mod(5*x, 2)", |x| (5.0 * x).rem_euclid(2.0)),
        ("atan2(sin(7*x), cos(7*x))", |x| {
            (7.0 * x).sin().atan2((7.0 * x).cos())
        }),
        ("hypot(x, 0.5)", |x| x.hypot(0.5)),
        ("if(x > -0.2 and x <= 0.5 or x > 0.8, x, -1)", |x| {
            if x > -0.2 && x <= 0.5 || x > 0.8 {
                x
            } else {
                -1.0
            }
        }),
        ("if(not (0 < x < 0.4), 2, if(x < 0.1, 5, 7))", |x| {
            if !(0.0 < x && x < 0.4) {
                2.0
            } else if x < 0.1 {
                5.0
            } else {
                7.0
            }
        }),
    ];
    for (text, function) in functions {
        // x runs from -1 to 1; y collects the function, which a fine midpoint rule does too.
        let model = ModelBuilder::new()
            .state("x", 1.0, -1.0)
            .state("y", text, 0.0)
            .build()
            .expect(text);
        let (_, end) = follow::<f64>(&model, 2.0).expect(text);
        let points = 2_000_000;
        let width = 2.0 / f64::from(points);
        let sum: f64 = (0..points)
            .map(|k| function(-1.0 + (f64::from(k) + 0.5) * width) * width)
            .sum();
        assert!((end[1] - sum).abs() < 1e-5, "{text}: {} and {sum}", end[1]);
    }
}

/// Normal, offset, jump of the field from the middle to the side above, slope above.
type Surface = (Vec<f64>, f64, Vec<f64>, Vec<f64>);

/// A linear system with a jump across each of its surfaces, or a corner.
#[derive(Clone, Debug)]
struct Piecewise {
    matrix: Vec<Vec<f64>>,
    constant: Vec<f64>,
    surfaces: Vec<Surface>,
    start: Vec<f64>,
}

fn piecewise() -> impl Strategy<Value = Piecewise> {
    (2..=4_usize, 1..=3_usize).prop_flat_map(|(n, m)| {
        let vector = move |size: f64| prop::collection::vec(-size..size, n);
        (
            prop::collection::vec(vector(1.5), n),
            vector(0.8),
            prop::collection::vec(
                (vector(1.0), -0.5..0.5, vector(1.0), vector(1.0), 0..3_u8),
                m,
            ),
            vector(1.5),
        )
            .prop_map(|(matrix, constant, surfaces, start)| Piecewise {
                matrix,
                constant,
                surfaces: (surfaces.into_iter())
                    .map(|(normal, offset, jump, slope, kind)| {
                        let none = vec![0.0; normal.len()];
                        match kind {
                            0 => (normal, offset, none, slope),
                            1 => (normal, offset, jump, none),
                            // Against the normal: sliding is likely.
                            _ => {
                                let against = normal.iter().map(|n| -n).collect();
                                (normal, offset, against, none)
                            }
                        }
                    })
                    .collect(),
                start,
            })
    })
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Place {
    Above,
    Below,
    On,
}

impl Piecewise {
    fn model(&self) -> Model {
        let surface = |k: usize| {
            let (normal, offset, ..) = &self.surfaces[k];
            let terms: Vec<String> = (normal.iter().enumerate())
                .map(|(i, c)| format!("({c:?})*x{i}"))
                .collect();
            format!("{} - ({offset:?})", terms.join(" + "))
        };
        let mut builder = ModelBuilder::new();
        for (i, row) in self.matrix.iter().enumerate() {
            let mut text = format!("{:?}", self.constant[i]);
            for (j, a) in row.iter().enumerate() {
                text += &format!(" + ({a:?})*x{j}");
            }
            for (k, (_, _, jump, slope)) in self.surfaces.iter().enumerate() {
                if jump[i] != 0.0 {
                    text += &format!(" + ({:?})*sign({})", jump[i], surface(k));
                }
                if slope[i] != 0.0 {
                    text += &format!(" + ({:?})*max({}, 0)", slope[i], surface(k));
                }
            }
            builder = builder.state(&format!("x{i}"), text, self.start[i]);
        }
        builder.build().expect("a valid model")
    }

    fn value(&self, k: usize, x: &[f64]) -> f64 {
        let (normal, offset, ..) = &self.surfaces[k];
        dot(normal, x) - offset
    }

    /// The field in a mode; none where what slides is not determined.
    fn field(&self, places: &[Place], x: &[f64]) -> Option<Vec<f64>> {
        let mut f: Vec<f64> = (self.matrix.iter().zip(&self.constant))
            .map(|(row, c)| dot(row, x) + c)
            .collect();
        let mut slid = Vec::new();
        for (k, (_, _, jump, slope)) in self.surfaces.iter().enumerate() {
            match places[k] {
                Place::Above => {
                    let value = self.value(k, x);
                    for i in 0..f.len() {
                        f[i] += jump[i] + slope[i] * value;
                    }
                }
                Place::Below => {
                    for i in 0..f.len() {
                        f[i] -= jump[i];
                    }
                }
                Place::On => slid.push(k),
            }
        }
        let shares = self.shares(&slid, &f)?;
        for (&k, share) in slid.iter().zip(&shares) {
            for (f, jump) in f.iter_mut().zip(&self.surfaces[k].2) {
                *f += share * jump;
            }
        }
        Some(f)
    }

    /// Filippov's shares of surfaces that are slid along, one or two.
    fn shares(&self, slid: &[usize], free: &[f64]) -> Option<Vec<f64>> {
        let entry = |i: usize, j: usize| dot(&self.surfaces[i].0, &self.surfaces[j].2);
        let right = |i: usize| -dot(&self.surfaces[i].0, free);
        match *slid {
            [] => Some(Vec::new()),
            [a] => Some(vec![right(a) / entry(a, a)]),
            [a, b] => {
                let det = entry(a, a) * entry(b, b) - entry(a, b) * entry(b, a);
                let first = (right(a) * entry(b, b) - entry(a, b) * right(b)) / det;
                let second = (entry(a, a) * right(b) - right(a) * entry(b, a)) / det;
                (det.abs() > 1e-3).then(|| vec![first, second])
            }
            _ => None,
        }
    }

    fn share_of(&self, places: &[Place], k: usize, x: &[f64]) -> Option<f64> {
        let slid: Vec<usize> = (0..places.len())
            .filter(|&k| places[k] == Place::On)
            .collect();
        let free: Vec<Place> = places.to_vec();
        let mut f: Vec<f64> = (self.matrix.iter().zip(&self.constant))
            .map(|(row, c)| dot(row, x) + c)
            .collect();
        for (j, (_, _, jump, slope)) in self.surfaces.iter().enumerate() {
            let sign = match free[j] {
                Place::Above => 1.0,
                Place::Below => -1.0,
                Place::On => continue,
            };
            let value = self.value(j, x).max(0.0);
            for (f, (jump, slope)) in f.iter_mut().zip(jump.iter().zip(slope)) {
                *f += sign * jump;
                if sign > 0.0 {
                    *f += slope * value;
                }
            }
        }
        let place = slid.iter().position(|&s| s == k)?;
        Some(self.shares(&slid, &f)?[place])
    }

    /// A step of a linear system by its Taylor series: the field is affine, so that its derivatives follow from differences.
    fn step(&self, places: &[Place], x: &[f64], h: f64) -> Option<Vec<f64>> {
        let zero = vec![0.0; x.len()];
        let constant = self.field(places, &zero)?;
        let mut term = self.field(places, x)?;
        let mut next = x.to_vec();
        let mut factor = h;
        for k in 2..26 {
            for i in 0..x.len() {
                next[i] += factor * term[i];
            }
            let image = self.field(places, &term)?;
            term = image.iter().zip(&constant).map(|(a, b)| a - b).collect();
            factor *= h / f64::from(k);
        }
        Some(next)
    }

    /// What ends a mode: positive as long as it lasts.
    fn margins(&self, places: &[Place], x: &[f64]) -> Vec<f64> {
        (0..places.len())
            .map(|k| match places[k] {
                Place::Above => self.value(k, x),
                Place::Below => -self.value(k, x),
                Place::On => self
                    .share_of(places, k, x)
                    .map_or(f64::NAN, |share| 1.0 - share.abs()),
            })
            .collect()
    }

    /// Times and modes, until the time asked for or until something is too close for sampling to be sure of.
    fn reference(&self, until: f64) -> Vec<(f64, Vec<Place>)> {
        const STEP: f64 = 1.0 / 512.0;
        const CLOSE: f64 = 1e-4;
        let mut x = self.start.clone();
        let mut places: Vec<Place> = (0..self.surfaces.len())
            .map(|k| {
                if self.value(k, &x) > 0.0 {
                    Place::Above
                } else {
                    Place::Below
                }
            })
            .collect();
        let mut found = Vec::new();
        let mut t = 0.0;
        if (0..places.len()).any(|k| self.value(k, &x).abs() < CLOSE) {
            return found;
        }
        // Margins that begin at zero are left alone until they are clear of it.
        let mut fresh: Option<usize> = None;
        while t < until && x.iter().all(|x| x.abs() < 50.0) {
            let Some(next) = self.step(&places, &x, STEP) else {
                return found;
            };
            let (before, after) = (self.margins(&places, &x), self.margins(&places, &next));
            let hit = (0..places.len())
                .filter(|&k| after[k] < 0.0)
                .collect::<Vec<_>>();
            let unsure = (0..places.len()).any(|k| {
                let turns = fresh != Some(k) && before[k].min(after[k]).abs() < CLOSE;
                !after[k].is_finite() || turns && !hit.contains(&k)
            });
            if unsure || hit.len() > 1 || hit.first().is_some_and(|&k| fresh == Some(k)) {
                return found;
            }
            let Some(&k) = hit.first() else {
                if fresh.is_some_and(|k| after[k] > CLOSE) {
                    fresh = None;
                }
                (t, x) = (t + STEP, next);
                continue;
            };
            let (mut low, mut high) = (0.0, STEP);
            for _ in 0..80 {
                let middle = 0.5 * (low + high);
                let Some(point) = self.step(&places, &x, middle) else {
                    return found;
                };
                if self.margins(&places, &point)[k] > 0.0 {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            let Some(point) = self.step(&places, &x, high) else {
                return found;
            };
            (t, x) = (t + high, point);
            if (0..places.len()).any(|j| j != k && self.margins(&places, &x)[j].abs() < CLOSE) {
                return found;
            }
            let rate = |place: Place| {
                let mut other = places.clone();
                other[k] = place;
                self.field(&other, &x).map(|f| dot(&self.surfaces[k].0, &f))
            };
            let now = places[k];
            places[k] = match now {
                Place::On => {
                    let share = self.share_of(&places, k, &x).unwrap_or(0.0);
                    if share > 0.0 {
                        Place::Above
                    } else {
                        Place::Below
                    }
                }
                side => {
                    let other = if side == Place::Above {
                        Place::Below
                    } else {
                        Place::Above
                    };
                    let Some(rate) = rate(other) else {
                        return found;
                    };
                    if rate.abs() < CLOSE {
                        return found;
                    }
                    if (rate > 0.0) == (other == Place::Above) {
                        other
                    } else {
                        Place::On
                    }
                }
            };
            // Others that slide may be thrown off by the change.
            if self
                .margins(&places, &x)
                .iter()
                .enumerate()
                .any(|(j, m)| j != k && *m < CLOSE)
            {
                return found;
            }
            // Sliding that would not be attracting by itself is no flow's.
            let repels = |k: usize| dot(&self.surfaces[k].0, &self.surfaces[k].2) > -CLOSE;
            if (0..places.len()).any(|k| places[k] == Place::On && repels(k)) {
                return found;
            }
            fresh = Some(k);
            found.push((t, places.clone()));
        }
        found
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[test]
fn random_piecewise_models_pass_the_same_modes_at_the_same_times() {
    let compared = Cell::new(0);
    let slides = Cell::new(0);
    let mut runner = TestRunner::new(ProptestConfig::with_cases(96));
    let result = runner.run(&piecewise(), |case| {
        let expected = case.reference(8.0);
        let Some(&(last, _)) = expected.last() else {
            return Ok(());
        };
        let model = case.model();
        let found = match follow::<f64>(&model, last + 1e-9) {
            Ok((found, _)) => found,
            Err(error) => return Err(TestCaseError::fail(format!("{error}; {expected:?}"))),
        };
        // The reference ends where the latest change may throw off what slides: then more happens, but at that instant.
        prop_assert!(found.len() >= expected.len(), "{:?}", expected);
        let (_, more) = found.split_at(expected.len());
        prop_assert!(
            more.iter()
                .all(|more| more.time - last < 1e-11 * (1.0 + last)),
            "{:?} {:?}",
            more.iter().map(|more| more.time).collect::<Vec<_>>(),
            expected
        );
        for (found, (time, _)) in found.iter().zip(&expected) {
            prop_assert!(
                (found.time - time).abs() < 1e-11 * (1.0 + time),
                "{} {}",
                found.time,
                time
            );
            compared.set(compared.get() + 1);
            slides.set(slides.get() + usize::from(matches!(found.what, Occurrence::Slide { .. })));
        }
        Ok(())
    });
    result.unwrap_or_else(|error| panic!("{error}"));
    assert!(compared.get() > 100, "{}", compared.get());
    assert!(slides.get() > 10, "{}", slides.get());
}

/// Columns of derivatives against differences of double-double trajectories.
#[test]
fn derivatives_pass_every_corner() {
    let texts = [
        // A crossing with a jump, a corner, a table's knots.
        "[parameters]\na = 0.7\n[flight]\nx = \"v\"\nv = \"-x - a*max(x, 0.1) + if(v > 0.2, 0.3*a, -0.1)\"\n\
         [initial]\nx = 1.0\nv = 0.1\n",
        // Sliding, entered and left.
        "[parameters]\na = 0.4\n[flight]\nx = \"v\"\nv = \"-x - a*sign(v - 0.3)\"\nz = \"x*v\"\n\
         [initial]\nx = -0.5\nv = 0.0\nz = 0.0\n",
        // An event.
        "[parameters]\na = 0.4\n[flight]\nx = \"v\"\nv = \"-x\"\n[[event]]\nsurface = \"x - 0.2*t*a\"\ndirection = \"either\"\n\
         reset = { v = \"v + a*x\", x = \"x + 0.1*v\" }\n[initial]\nx = 1.0\nv = 0.1\n",
        // An impact that changes sides.
        "[parameters]\na = 0.4\n[flight]\nx = \"v\"\nv = \"-1 - a*sign(v)\"\n[[contact]]\ngap = \"x\"\nimpulse = { v = 1 }\n\
         restitution = \"0.5 + 0.3*a\"\n[initial]\nx = 1.0\nv = 0.1\n",
        // Friction in a contact: slip, stick, slip.
        "[parameters]\nmu = 0.3\n[flight]\nx = \"u\"\nu = \"0.5*cos(t)\"\ny = \"v\"\nv = \"-1\"\n[[contact]]\ngap = \"y\"\n\
         impulse = { v = 1 }\nrestitution = 0.5\nfriction = { coefficient = \"mu\", along = { u = 1 } }\n\
         [initial]\nx = 0.0\nu = 1.0\ny = 0.0\nv = 0.0\n",
    ];
    for text in texts {
        let model = read(text);
        for until in [0.7, 2.3, 4.1, 5.6, 7.4] {
            check_columns(&model, until);
        }
    }
}

fn check_columns(model: &Model, until: f64) {
    const STEP: f64 = 1e-10;
    let n = model.states.len();
    let spatial = n - usize::from(model.time.is_some());
    let columns: Vec<Column> = (0..spatial)
        .map(|_| Column::State)
        .chain((0..model.parameters.len()).map(Column::Parameter))
        .collect();
    let system = System::with_columns(model, &columns).expect("a system");
    let parameters = model.parameter_values::<f64>(&[]);
    let state = model.initial_state::<f64>(&parameters);
    let mut start = state.clone();
    for index in 0..columns.len() {
        start.extend((0..n).map(|i| f64::from(u8::from(i == index && index < spatial))));
    }
    let end = {
        let mut work = system.workspace::<f64>(&Settings::default());
        let mut run =
            Trajectory::start(&system, &mut work, &parameters, 0.0, &start).expect("a start");
        while run.advance(&system, &mut work, until).expect("a motion") != Some(Occurrence::Horizon)
        {
        }
        run.state().to_vec()
    };
    let plain = System::new(model).expect("a system");
    for (index, column) in columns.iter().enumerate() {
        let shifted = |by: f64| {
            let (mut p, mut x): (Vec<DoubleDouble>, Vec<DoubleDouble>) = (
                model.parameter_values(&[]),
                state.iter().map(|&x| DoubleDouble::from(x)).collect(),
            );
            match column {
                Column::State => x[index] += DoubleDouble::from(by),
                Column::Parameter(k) => p[*k] += DoubleDouble::from(by),
            }
            let mut work = plain.workspace::<DoubleDouble>(&Settings::default());
            let mut run =
                Trajectory::start(&plain, &mut work, &p, DoubleDouble::ZERO, &x).expect("a start");
            let until = DoubleDouble::from(until);
            while run.advance(&plain, &mut work, until).expect("a motion")
                != Some(Occurrence::Horizon)
            {}
            run.state().to_vec()
        };
        // A displaced start may have left the contact that it rested on: no difference is a derivative then.
        let rests =
            state.iter().zip(&model.states).any(|(&x, _)| x == 0.0) && !model.contacts.is_empty();
        if rests && *column == Column::State && model.contacts[0].friction.is_some() && index >= 2 {
            continue;
        }
        let (after, before) = (shifted(STEP), shifted(-STEP));
        for i in 0..n {
            let difference = ((after[i] - before[i]) / DoubleDouble::from(2.0 * STEP)).to_f64();
            let own = end[n * (index + 1) + i];
            assert!(
                (own - difference).abs() < 1e-7 * (1.0 + difference.abs()),
                "{}, until {until}, {column:?} {index}, component {i}: {own} and {difference}",
                model.formula(model.states[1].derivative)
            );
        }
    }
}

/// A kick at each half turn.
#[test]
fn events_reset_the_state_once_each() {
    let model = ModelBuilder::new()
        .state("x", "v", 1.0)
        .state("v", "-x", 0.0)
        .event("kick", "v", Direction::Falling, [("v", "v - 0.25")])
        .build()
        .expect("a valid model");
    let (told, _) = follow::<f64>(&model, 20.0).expect("a motion");
    // v falls through zero at the right end: then it is lessened by a quarter, which widens the circle.
    let mut radius = 1.0_f64;
    let mut time = 0.0;
    let mut expected = Vec::new();
    let mut angle = 0.0_f64;
    for _ in 0..8 {
        time += 2.0 * PI - angle;
        angle = (0.25 / radius).atan();
        expected.push(time);
        radius = radius.hypot(0.25);
    }
    assert!(!told.is_empty());
    for (told, expected) in told.iter().zip(&expected) {
        assert!(matches!(told.what, Occurrence::Reset { .. }));
        assert!(
            (told.time - expected).abs() < 1e-12,
            "{} {expected}",
            told.time
        );
    }
}

/// What cannot be decided is said, with its time.
#[test]
fn repelling_surfaces_are_not_left_by_chance() {
    let model = read("[flight]\nx = \"sign(x)\"\n[initial]\nx = 0.0\n");
    assert!(
        matches!(follow::<f64>(&model, 1.0), Err(FlowError::NotUnique { time, .. }) if time == 0.0)
    );
    let model = read("[flight]\nx = \"sign(x - t + 1) - 0.5\"\n[initial]\nx = 0.5\n");
    assert!(follow::<f64>(&model, 3.0).is_ok());
}

/// Where a run ends stuck, its result says by what: a surface, or the friction of a contact.
#[test]
fn what_holds_the_state_at_the_end_is_told() {
    use chatter::analysis::simulate::{Spec, simulate};
    use chatter::flow::{Closed, Held};
    use core::ops::ControlFlow;
    let held = |text: &str, until: f64| {
        let run = simulate::<f64>(&read(text), &Spec::until(until), &mut |_| {
            ControlFlow::Continue(())
        });
        let run = run.expect("a motion");
        (run.closed, run.start_held, run.held)
    };
    let belt =
        "[flight]\nx = \"v\"\nv = \"-x - 0.4*sign(v - 0.3)\"\n[initial]\nx = -0.3\nv = 0.3\n";
    let slid = Held {
        surfaces: vec![0],
        contacts: vec![],
    };
    assert_eq!(held(belt, 1.0), (Closed::NONE, slid.clone(), slid.clone()));
    assert_eq!(held(belt, 3.0), (Closed::NONE, slid, Held::default()));
    let skid = "[flight]\ny = \"v\"\nv = -1\ns = \"u\"\nu = \"0\"\n[[contact]]\ngap = \"y\"\nimpulse = { v = 1 }\n\
                restitution = 0\nfriction = { coefficient = 0.5, along = { u = 1 } }\n\
                [initial]\ny = 0\nv = 0\ns = 0\nu = 1\n";
    let stuck = Held {
        surfaces: vec![],
        contacts: vec![0],
    };
    let closed = Closed::NONE.with(0);
    assert_eq!(held(skid, 1.9), (closed, Held::default(), Held::default()));
    assert_eq!(held(skid, 2.1), (closed, Held::default(), stuck));
}

/// A table whose argument is a `mod`: where that jumps, so does the piece. The same motion with the argument as a state that an
/// event takes back.
#[test]
fn tables_of_a_repeated_argument_go_round() {
    for (kind, y) in [
        ("linear", "[0.0, 0.4, 1.0, 0.3, 0.0]"),
        ("cubic", "[0.0, 0.4, 1.0, 0.3, 0.0]"),
        ("pchip", "[0.2, 0.4, 1.0, 0.3, 0.2]"),
        ("steps", "[0.0, 0.4, -1.0, 0.3, 0.0]"),
        ("periodic-cubic", "[0.1, 0.4, 1.0, 0.3, 0.1]"),
        // A jump where it goes round.
        ("linear", "[0.5, 0.4, 1.0, 0.3, -0.7]"),
    ] {
        for (from, speed) in [
            (0.0, 1.5),
            (-8.0, 0.7),
            (4.0, 1.1),
            (3.3, -0.9),
            (0.0, -1.3),
        ] {
            let table = format!("[table.f]\nx = [0, 1, 2, 3, 4]\ny = {y}\nkind = \"{kind}\"\n");
            let rest = "x = 0.3\nv = 0.1\n";
            let folded = format!(
                "{table}[flight]\nx = \"v\"\nv = \"-x + f(mod(s, 4))\"\ns = {speed}\n[initial]\ns = {from}\n{rest}"
            );
            let start = f64::rem_euclid(from, 4.0);
            let start = if start == 0.0 && speed < 0.0 {
                4.0
            } else {
                start
            };
            let outside = if kind == "periodic-cubic" {
                ""
            } else {
                "outside = \"hold\"\n"
            };
            let (surface, to) = if speed > 0.0 { ("s - 4", 0) } else { ("s", 4) };
            let reset = format!(
                "{table}{outside}[flight]\nx = \"v\"\nv = \"-x + f(s)\"\ns = {speed}\n\
                 [[event]]\nsurface = \"{surface}\"\nreset = {{ s = {to} }}\n[initial]\ns = {start}\n{rest}"
            );
            let (_, folded) = follow::<f64>(&read(&folded), 17.0)
                .unwrap_or_else(|e| panic!("{kind} {from} {speed}: {e}"));
            let (_, reset) = follow::<f64>(&read(&reset), 17.0).expect("a motion");
            for k in 0..2 {
                assert!(
                    (folded[k] - reset[k]).abs() < 1e-12,
                    "{kind} {from} {speed}: {folded:?} {reset:?}"
                );
            }
        }
    }
}

/// A corner in a function that itself jumps: a square wave by `mod` is the sign of a sine.
#[test]
fn corners_of_what_jumps_are_where_it_jumps_to() {
    let wave = |force: &str| {
        let text = format!(
            "[flight]\nx = \"v\"\nv = \"-2*x - 0.1*v + {force}\"\n[initial]\nx = 0.3\nv = 0\n"
        );
        let (told, end) = follow::<f64>(&read(&text), 9.7).expect("a motion");
        (told.len(), end)
    };
    let (_, by_sine) = wave("sign(sin(2*pi*t))");
    for force in [
        "if(mod(t, 1) < 0.5, 1, -1)",
        "sign(0.5 - mod(t, 1))",
        "1 - 2*step(mod(t, 1) - 0.5)",
        "1 - 2*floor(2*mod(t, 1))",
        "if(mod(floor(2*t), 2) < 0.5, 1, -1)",
    ] {
        let (_, end) = wave(force);
        for k in 0..2 {
            assert!(
                (end[k] - by_sine[k]).abs() < 1e-12,
                "{force}: {end:?} {by_sine:?}"
            );
        }
    }
}

/// Where a gap jumps up the contact opens; where it jumps down the state is inside an obstacle, and the run ends.
#[test]
fn gaps_that_jump_open_or_end_the_run() {
    let ball = |y: &str, start: f64| {
        let text = format!(
            "[table.floor]\nx = [0, 1, 2]\ny = {y}\nkind = \"steps\"\n[flight]\ny = \"v\"\nv = -5\n\
             s = 1\n[[contact]]\ngap = \"y - floor(s)\"\nimpulse = {{ v = 1 }}\nrestitution = 0.5\n\
             [initial]\ny = {start}\nv = 0\ns = 0\n"
        );
        follow::<f64>(&read(&text.replace("floor", "ground")), 1.5)
    };
    let (told, end) = ball("[0.0, -2.0, -2.0]", 0.0).expect("a motion");
    assert!(matches!(told[0].what, Occurrence::Release { contact: 0 }));
    assert!((told[0].time - 1.0).abs() < 1e-15);
    assert!((end[0] + 5.0 * 0.25 / 2.0).abs() < 1e-15, "{end:?}");
    for start in [0.0, 0.1] {
        let jumps = ball("[0.0, 0.3, 0.3]", start);
        assert!(
            matches!(jumps, Err(FlowError::JumpsInside { contact: 0, time, .. }) if (time - 1.0).abs() < 1e-15)
        );
    }
    let text = "[flight]\ny = \"v\"\nv = -1\n[[contact]]\ngap = \"y\"\nimpulse = { v = 1 }\nrestitution = 0.5\n\
                [[event]]\nsurface = \"t - 0.5\"\nreset = { y = -0.25 }\n[initial]\ny = 1\nv = 0\n";
    let by_event = follow::<f64>(&read(text), 1.0);
    assert!(
        matches!(by_event, Err(FlowError::JumpsInside { gap, time, .. }) if gap == -0.25 && time == 0.5)
    );
}

/// A ball against Coulomb friction along its fall: rates fall by r sqrt((g - f) / (g + f)) from impact to impact, so that it comes to
/// rest at a time that is known.
#[test]
fn chatter_against_dry_friction_ends_where_it_ends() {
    fn check<R: Real>(share: f64) {
        for (g, f, r, height) in [
            (1.0, 0.3, 0.7, 1.0),
            (9.81, 0.5, 0.9, 0.4),
            (2.0, 1.5, 0.4, 3.0),
            (1.0, -0.1, 0.6, 1.0),
            (1.0, 0.02, 0.99, 0.2),
        ] {
            let text = format!(
                "[flight]\ny = \"v\"\nv = \"-{g} - {f}*sign(v)\"\n[[contact]]\ngap = \"y\"\nimpulse = {{ v = 1 }}\n\
                 restitution = {r}\n[initial]\ny = {height}\nv = 0\n"
            );
            let (told, end) = follow::<R>(&read(&text), 1000.0).expect("a motion");
            let parsed =
                |x: f64| R::from_double_double(format!("{x:?}").parse().expect("a number"));
            let (g, f, r, height) = (parsed(g), parsed(f), parsed(r), parsed(height));
            let (rise, fall) = (g + f, g - f);
            let ratio = r * (fall / rise).sqrt();
            let first = (R::splat(2.0) * fall * height).sqrt();
            let flight = r * first / rise + ratio * first / fall;
            let expected = first / fall + flight / (R::ONE - ratio);
            let (at, error, impacts) = (told.iter())
                .find_map(|told| match told.what {
                    Occurrence::Accumulation { error, impacts, .. } => {
                        Some((told.time, error, impacts))
                    }
                    _ => None,
                })
                .expect("it comes to rest");
            let off = ((at - expected) / expected).abs().to_f64();
            assert!(off < share, "{r:?} {f:?}: {at:?} {expected:?} {off:e}");
            assert!(
                (at - expected).abs().to_f64() <= 2.0 * error,
                "{off:e} {error:e}"
            );
            // It is not followed until nothing is left.
            let few = 40.0 / -libm::log2(ratio.to_f64()).max(-40.0) + 30.0;
            assert!((impacts as f64) < few, "{impacts} {few}");
            assert!(end.iter().all(|x| *x == R::ZERO), "{end:?}");
        }
    }
    check::<f64>(2e-13);
    check::<DoubleDouble>(1e-28);
}

/// The same where neither force is constant: extrapolated as soon as it can be, and followed for long.
#[test]
fn chatter_that_crosses_surfaces_ends_alike_however_long_it_is_followed() {
    for force in [
        "-1 - 0.3*sign(v) - 0.2*y*y",
        "-1 - (0.3 + 0.1*cos(t) + 0.2*y)*sign(v)",
        "-1 - 0.4*v*abs(v)",
        "-1 + if(v > 0, -0.2*cos(t), 0.3*sin(t) - 0.1*y)",
        "-1 - 0.3*sign(v) + 0.2*sin(3*t)",
        "-1 - 0.8*sign(v) + 0.1*sin(t)",
    ] {
        let text = format!(
            "[flight]\ny = \"v\"\nv = \"{force}\"\n[[contact]]\ngap = \"y\"\nimpulse = {{ v = 1 }}\nrestitution = 0.6\n\
             [initial]\ny = 0.8\nv = 0\n"
        );
        let model = read(&text);
        let end = |longest_tail: f64| {
            let system = System::new(&model).expect("a valid system");
            let settings = Settings {
                longest_tail,
                ..Settings::default()
            };
            let mut work = system.workspace::<DoubleDouble>(&settings);
            let parameters = model.parameter_values(&[]);
            let state = model.initial_state(&parameters);
            let start = DoubleDouble::ZERO;
            let mut trajectory =
                Trajectory::start(&system, &mut work, &parameters, start, &state).expect("a start");
            loop {
                let until = DoubleDouble::splat(20.0);
                match trajectory
                    .advance(&system, &mut work, until)
                    .expect("a motion")
                {
                    Some(Occurrence::Accumulation { impacts, .. }) => {
                        return (trajectory.time(), impacts);
                    }
                    Some(Occurrence::Horizon) => panic!("{force}: no end"),
                    _ => {}
                }
            }
        };
        let ((soon, few), (late, many)) = (end(f64::INFINITY), end(1e-14));
        assert!(few + 10 < many, "{force}: {few} {many}");
        assert!(
            (soon - late).abs().to_f64() < 1e-27,
            "{force}: {:e}",
            (soon - late).to_f64()
        );
    }
}

/// Friction along the gap holds a ball on the floor as well as the floor does: it rises when the lift exceeds weight and friction.
#[test]
fn friction_along_the_gap_delays_release() {
    for (friction, lift) in [(0.3_f64, 1.4_f64), (0.05, 3.0), (0.9, 2.0)] {
        for force in [
            format!("-1 + {lift}*sin(t) - {friction}*sign(v)"),
            format!("-1 + {lift}*sin(t) + {friction}*sign(-v)"),
            format!("-1 + {lift}*sin(t) - if(v > 0, {friction}, -{friction})"),
        ] {
            let text = format!(
                "[flight]\ny = \"v\"\nv = \"{force}\"\n[[contact]]\ngap = \"y\"\nimpulse = {{ v = 1 }}\n\
                 restitution = 0.4\n[initial]\ny = 0\nv = 0\n"
            );
            let (told, _) = follow::<f64>(&read(&text), 1.7).expect("a motion");
            let released = (told.iter())
                .find(|told| matches!(told.what, Occurrence::Release { .. }))
                .expect("it rises");
            let expected: f64 = ((1.0 + friction) / lift).asin();
            assert!(
                (released.time - expected).abs() < 1e-14,
                "{force} {}",
                released.time
            );
        }
    }
}

/// A square root with the sign of its argument has no derivative where it is zero, and the motion goes through.
#[test]
fn signed_roots_are_zero_on_time() {
    for (field, at) in [
        ("-1 - sqrt(abs(h))*sign(h)", 0.0),
        ("-sqrt(abs(h))*sign(h) - 0.25*h - 1", 0.0),
    ] {
        let text = format!("[flight]\nh = \"{field}\"\n[initial]\nh = 0.7\n");
        let (told, end) = follow::<f64>(&read(&text), 10.0).expect("it goes on");
        let crossed = |told: &&Told<f64>| matches!(told.what, Occurrence::Switch { .. });
        let time = told.iter().find(crossed).expect("it crosses zero").time;
        assert!(end[0] < 0.0, "{field} {end:?}");
        // The time until then, by the substitution h = w^2: 2 w dw / (c + w + b w^2).
        let b = if field.contains("0.25") { 0.25 } else { 0.0 };
        let steps = 20_000;
        let top = f64::sqrt(0.7);
        let part = |w: f64| 2.0 * w / (1.0 + w + b * w * w);
        let width = top / f64::from(steps);
        let sum: f64 = (0..steps)
            .map(|k| {
                let a = f64::from(k) * width;
                (part(a) + 4.0 * part(a + width / 2.0) + part(a + width)) * width / 6.0
            })
            .sum();
        assert!((time - sum - at).abs() < 1e-10, "{field} {time} {sum}");
    }
}

/// A ball that comes to rest where the floor is a knot, too: the contact keeps it on both.
#[test]
fn contacts_may_rest_on_knots() {
    for force in ["-1 + 0.3*floor(2*y)", "-1 + 0.3*floor(2*y) - 0.2*sign(v)"] {
        let text = format!(
            "[flight]\ny = \"v\"\nv = \"{force}\"\n[[contact]]\ngap = \"y\"\nimpulse = {{ v = 1 }}\n\
             restitution = 0.5\n[initial]\ny = 1\nv = 0\n"
        );
        let (_, end) = follow::<f64>(&read(&text), 6.0).expect("a motion");
        assert!(end.iter().all(|x| *x == 0.0), "{force} {end:?}");
    }
}
