//! Every backend computes the same bits, on every kind of number: random tapes with all operations and orders, and the motion
//! of each shipped model.

use chatter::expressions::{Backend, Expansion, Expr, Function, Graph, Tape};
use chatter::flow::{Settings, System, Trajectory};
use chatter::model::Model;
use chatter::numerics::{Lanes, Scalar};

/// Numbers drawn from a seed, by a linear congruence.
struct Draws(u64);

impl Draws {
    fn next(&mut self, below: u64) -> u64 {
        self.0 = (self.0)
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % below
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next(1 << 30) as f64 / (1 << 30) as f64
    }
}

const PARAMETERS: usize = 3;

fn expression(graph: &mut Graph, draws: &mut Draws, dimension: usize, depth: usize) -> Expr {
    if depth == 0 {
        return match draws.next(4) {
            0 => graph.parameter(draws.next(PARAMETERS as u64) as usize),
            1 => graph.number(draws.between(-2.0, 2.0)),
            _ => graph.state(draws.next(dimension as u64) as usize),
        };
    }
    let part = |graph: &mut Graph, draws: &mut Draws| {
        let shallower = draws.next(depth as u64) as usize;
        expression(graph, draws, dimension, shallower)
    };
    let first = part(graph, draws);
    match draws.next(12) {
        0..=2 => {
            let second = part(graph, draws);
            graph.add(first, second)
        }
        3..=5 => {
            let second = part(graph, draws);
            graph.mul(first, second)
        }
        6 => {
            let second = part(graph, draws);
            graph.div(first, second)
        }
        7 => graph.sqrt(first),
        8 => {
            let exponent = [2.0, 3.0, -1.0, 1.5, 0.3, -2.7, 7.0][draws.next(7) as usize];
            let exponent = graph.number(exponent);
            graph.power(first, exponent)
        }
        9 => {
            let exponent = graph.parameter(draws.next(PARAMETERS as u64) as usize);
            graph.power(first, exponent)
        }
        _ => graph.call(Function::ALL[draws.next(11) as usize], first),
    }
}

/// A kind of number as the doubles that it is.
trait Kind: Scalar {
    const COUNT: usize;
    fn of(lane: impl Fn(usize) -> f64) -> Self;
    fn lane(&self, index: usize) -> f64;
}

impl Kind for f64 {
    const COUNT: usize = 1;
    fn of(lane: impl Fn(usize) -> f64) -> Self {
        lane(0)
    }
    fn lane(&self, _: usize) -> f64 {
        *self
    }
}

impl<const L: usize> Kind for Lanes<L>
where
    Self: Scalar,
{
    const COUNT: usize = L;
    fn of(lane: impl Fn(usize) -> f64) -> Self {
        Self(core::array::from_fn(lane))
    }
    fn lane(&self, index: usize) -> f64 {
        self.0[index]
    }
}

/// Which bits of a number that is none are set is nobody's promise.
fn bits(value: f64) -> u64 {
    if value.is_nan() {
        f64::NAN.to_bits()
    } else {
        value.to_bits()
    }
}

/// What a tape is run on, lane by lane.
struct Inputs {
    state: Vec<Vec<f64>>,
    low: Vec<Vec<f64>>,
    constants: Vec<Vec<f64>>,
    tau: Vec<f64>,
}

/// The most lanes that anything has.
const MOST: usize = 32;

impl Inputs {
    fn draw(tape: &Tape, graph: &Graph, draws: &mut Draws) -> Self {
        let mut each = |low: f64, high: f64, count: usize| -> Vec<Vec<f64>> {
            let mut one = || (0..count).map(|_| draws.between(low, high)).collect();
            (0..MOST).map(|_| one()).collect()
        };
        let dimension = tape.dimension();
        let parameters = each(0.2, 2.0, PARAMETERS);
        Self {
            state: each(-0.5, 1.5, dimension),
            low: each(-1e-17, 1e-17, dimension),
            tau: each(0.05, 0.5, 1).concat(),
            constants: (parameters.iter())
                .map(|parameters| tape.constants(graph, parameters))
                .collect(),
        }
    }
}

fn gathered<S: Kind>(lanes: &[Vec<f64>]) -> Vec<S> {
    (0..lanes[0].len())
        .map(|place| S::of(|lane| lanes[lane][place]))
        .collect()
}

/// Bits of everything that runs of all orders leave, and values at a point, by lane.
fn results<S: Kind>(tape: &Tape, inputs: &Inputs, backend: Backend) -> Vec<Vec<u64>> {
    let state: Vec<S> = gathered(&inputs.state);
    let low: Vec<S> = gathered(&inputs.low);
    let constants: Vec<S> = gathered(&inputs.constants);
    let tau = S::of(|lane| inputs.tau[lane]);
    let mut expansion = Expansion::new(&[tape]).with_backend(backend);
    let mut results = vec![Vec::new(); S::COUNT];
    let mut take = |number: &S| {
        for (lane, results) in results.iter_mut().enumerate() {
            results.push(bits(number.lane(lane)));
        }
    };
    let mut values = vec![S::splat(0.0); tape.output_count()];
    for order in S::ORDERS.into_iter().chain([1, 2, 3]) {
        expansion.run(tape, &constants, &state, &low, tau, order);
        for slot in 0..tape.dimension() {
            expansion.series(slot).iter().for_each(&mut take);
        }
        for output in 0..tape.output_count() {
            let series = expansion.output(tape, output);
            series.into_iter().flatten().for_each(&mut take);
        }
        expansion.evaluate(tape, &constants, &state, &low, &mut values);
        values.iter().for_each(&mut take);
    }
    results
}

/// The suite that a backend has to pass: on this kind of number, what single doubles are in the interpreter.
fn passes<S: Kind>(backend: Backend, tape: &Tape, inputs: &Inputs, expected: &[Vec<u64>]) {
    let found = results::<S>(tape, inputs, backend);
    for (lane, found) in found.iter().enumerate() {
        assert!(
            *found == expected[lane],
            "lane {lane} of {} by {backend:?}: {tape:?}",
            S::COUNT
        );
    }
    if backend == Backend::CompiledAtOnce && cfg!(target_arch = "x86_64") {
        assert_eq!(tape.is_compiled::<S>(), Backend::is_available());
    }
}

#[test]
fn backends_agree_on_random_tapes() {
    let cases = std::env::var("CHATTER_RANDOM_TAPES").ok();
    let cases = cases.and_then(|text| text.parse().ok()).unwrap_or(60);
    for seed in 0..cases {
        let mut draws = Draws(seed);
        let mut graph = Graph::default();
        let dimension = 1 + draws.next(4) as usize;
        let mut several = |graph: &mut Graph, count: usize| -> Vec<Expr> {
            (0..count)
                .map(|_| {
                    let depth = draws.next(6) as usize;
                    expression(graph, &mut draws, dimension, depth)
                })
                .collect()
        };
        let field = several(&mut graph, dimension);
        // Where all outputs are states the last order of all else is not computed.
        let outputs = if seed % 4 == 0 {
            vec![graph.state(0)]
        } else {
            several(&mut graph, 3)
        };
        let tape = Tape::new(&mut graph, dimension, &field, &outputs);
        let inputs = Inputs::draw(&tape, &graph, &mut draws);
        let expected: Vec<Vec<u64>> = (0..MOST)
            .flat_map(|lane| {
                let alone = Inputs {
                    state: vec![inputs.state[lane].clone()],
                    low: vec![inputs.low[lane].clone()],
                    constants: vec![inputs.constants[lane].clone()],
                    tau: vec![inputs.tau[lane]],
                };
                results::<f64>(&tape, &alone, Backend::Interpreter)
            })
            .collect();
        for backend in [Backend::CompiledAtOnce, Backend::Interpreter] {
            passes::<f64>(backend, &tape, &inputs, &expected);
            passes::<Lanes<4>>(backend, &tape, &inputs, &expected);
            passes::<Lanes<8>>(backend, &tape, &inputs, &expected);
            passes::<Lanes<16>>(backend, &tape, &inputs, &expected);
            passes::<Lanes<32>>(backend, &tape, &inputs, &expected);
        }
    }
}

/// What happens on a trajectory from its start, and where it is afterwards, as bits.
fn motion(model: &Model, backend: Backend) -> String {
    let system = System::new(model).expect("a shipped model");
    let settings = Settings {
        backend,
        ..Settings::default()
    };
    let mut work = system.workspace::<f64>(&settings);
    let parameters = model.parameter_values::<f64>(&[]);
    let state = model.initial_state(&parameters);
    let start = model.time.map_or(0.0, |index| state[index]);
    let mut told = String::new();
    let mut trajectory =
        Trajectory::start(&system, &mut work, &parameters, start, &state).expect("a shipped start");
    for _ in 0..200 {
        // Numbers are written with all digits.
        match trajectory.advance(&system, &mut work, start + 50.0) {
            Ok(None) => {}
            Ok(Some(what)) => told += &format!("{what:?}\n"),
            Err(error) => {
                told += &format!("{error:?}\n");
                break;
            }
        }
        let time = trajectory.time();
        told += &format!("{time:?} {:?}\n", trajectory.state());
    }
    told
}

#[test]
fn backends_agree_on_shipped_models() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models");
    let mut count = 0;
    for entry in std::fs::read_dir(folder).expect("the models") {
        let path = entry.expect("a model").path();
        let text = std::fs::read_to_string(&path).expect("a model");
        let model = Model::from_toml(&text, "model").expect("a shipped model");
        let expected = motion(&model, Backend::Interpreter);
        assert!(
            motion(&model, Backend::CompiledAtOnce) == expected,
            "{path:?}"
        );
        count += 1;
    }
    assert!(count >= 20, "{count}");
}
