//! Machine code run by an emulator that knows the few instructions that it consists of: for processors that the tests do not
//! run on, and to see that no place is read or written but those that the code may touch.

use super::assembler::Width;
use super::compile::{Layout, compile};
use super::executable::{Callee, TABLE, Table, function_of};
use super::{Backend, Tape};
use crate::expressions::{Expansion, Function, Graph};
use crate::numerics::{Lanes, Scalar};
use core::mem::{offset_of, size_of};
use iced_x86::{Decoder, DecoderOptions, Instruction, Mnemonic, OpKind, Register};
use std::collections::HashMap;

const RDI: usize = 7;
const RSI: usize = 6;
const RDX: usize = 2;
const RCX: usize = 1;
const RSP: usize = 4;

/// What calls may change.
const CALLER_SAVED: [usize; 9] = [0, 1, 2, 6, 7, 8, 9, 10, 11];

/// One stretch of memory. Between two of them nothing may be touched.
struct Region {
    start: u64,
    words: Vec<u64>,
    is_constant: bool,
}

struct Machine {
    words: [u64; 16],
    vectors: [[f64; 8]; 32],
    regions: Vec<Region>,
    is_zero: bool,
    is_less: bool,
    callees: HashMap<u64, Callee>,
}

fn number(register: Register) -> usize {
    let of = |first: Register, count: usize| {
        let number = (register as usize).wrapping_sub(first as usize);
        (number < count).then_some(number)
    };
    of(Register::RAX, 16)
        .or_else(|| of(Register::XMM0, 32))
        .or_else(|| of(Register::YMM0, 32))
        .or_else(|| of(Register::ZMM0, 32))
        .unwrap_or_else(|| panic!("{register:?}"))
}

impl Machine {
    fn new() -> Self {
        let named = Function::ALL.map(Callee::Function);
        let callees = named.into_iter().chain([Callee::SineCosine, Callee::Power]);
        let mut machine = Self {
            words: [0x5555; 16],
            vectors: [[f64::NAN; 8]; 32],
            regions: Vec::new(),
            is_zero: false,
            is_less: false,
            callees: callees.map(|c| (function_of(c) as u64, c)).collect(),
        };
        let stack = machine.place(vec![0; 1 << 12], false);
        machine.words[RSP] = stack + (8 << 12) - 8;
        machine
    }

    /// Gives memory what it holds; returns where it begins.
    fn place(&mut self, words: Vec<u64>, is_constant: bool) -> u64 {
        let start = 0x100_0000 * (self.regions.len() as u64 + 1);
        self.regions.push(Region {
            start,
            words,
            is_constant,
        });
        start
    }

    fn word(&mut self, address: u64, writes: bool) -> &mut u64 {
        assert!(address.is_multiple_of(8), "{address:x}");
        let region = (self.regions.iter_mut().rev())
            .find(|region| region.start <= address)
            .unwrap_or_else(|| panic!("nothing at {address:x}"));
        assert!(!(writes && region.is_constant), "a constant at {address:x}");
        let place = (address - region.start) as usize / 8;
        &mut region.words[place]
    }

    fn read(&mut self, address: u64) -> f64 {
        f64::from_bits(*self.word(address, false))
    }

    fn write(&mut self, address: u64, value: f64) {
        *self.word(address, true) = value.to_bits();
    }

    fn address(&self, instruction: &Instruction) -> u64 {
        let index = match instruction.memory_index() {
            Register::None => 0,
            index => self.words[number(index)] * u64::from(instruction.memory_index_scale()),
        };
        (self.words[number(instruction.memory_base())])
            .wrapping_add(index)
            .wrapping_add(instruction.memory_displacement64())
    }

    /// The value of a whole-number operand.
    fn whole(&mut self, instruction: &Instruction, operand: u32) -> u64 {
        match instruction.op_kind(operand) {
            OpKind::Register => self.words[number(instruction.op_register(operand))],
            OpKind::Memory => {
                let address = self.address(instruction);
                *self.word(address, false)
            }
            _ => instruction.immediate(operand),
        }
    }

    fn vector(&mut self, instruction: &Instruction, operand: u32, doubles: usize) -> [f64; 8] {
        if instruction.op_kind(operand) == OpKind::Register {
            return self.vectors[number(instruction.op_register(operand))];
        }
        let address = self.address(instruction);
        let mut values = [0.0; 8];
        for (lane, value) in values.iter_mut().take(doubles).enumerate() {
            *value = self.read(address + 8 * lane as u64);
        }
        values
    }

    /// Does what a called function does, and what it may.
    fn called(&mut self, address: u64) {
        let callee = self.callees[&address];
        let [from, second, third, count] = [RDI, RSI, RDX, RCX].map(|r| self.words[r]);
        assert!((self.words[RSP]).is_multiple_of(16), "the stack");
        for lane in 0..count {
            let at = |start: u64| start + 8 * lane;
            let value = self.read(at(from));
            match callee {
                Callee::SineCosine => {
                    let (sine, cosine) = Scalar::sin_cos(value);
                    self.write(at(second), sine);
                    self.write(at(third), cosine);
                }
                Callee::Power => {
                    let exponent = self.read(at(second));
                    self.write(at(third), Scalar::powf(value, exponent));
                }
                Callee::Function(function) => {
                    let result = crate::expressions::series::apply(function, value);
                    self.write(at(third), result);
                }
            }
        }
        for register in CALLER_SAVED {
            self.words[register] = 0xdead_0000;
        }
        self.vectors = [[f64::NAN; 8]; 32];
    }

    fn run(&mut self, code: &[u8], frame: u64) {
        let before = self.words;
        self.words[RDI] = frame;
        *self.word(before[RSP], true) = u64::MAX;
        let mut decoder = Decoder::with_ip(64, code, 0, DecoderOptions::NONE);
        loop {
            let instruction = decoder.decode();
            assert!(!instruction.is_invalid());
            let mut goes_to = None;
            match instruction.mnemonic() {
                Mnemonic::Ret => break,
                Mnemonic::Jmp => goes_to = Some(true),
                Mnemonic::Je => goes_to = Some(self.is_zero),
                Mnemonic::Jne => goes_to = Some(!self.is_zero),
                Mnemonic::Jl => goes_to = Some(self.is_less),
                Mnemonic::Jge => goes_to = Some(!self.is_less),
                Mnemonic::Jg => goes_to = Some(!self.is_less && !self.is_zero),
                _ => self.step(&instruction),
            }
            if goes_to == Some(true) {
                let target = instruction.near_branch_target();
                decoder.set_ip(target);
                decoder
                    .set_position(target as usize)
                    .expect("a place in the code");
            }
        }
        // What a callee has to leave as it was.
        for register in [3, 4, 5, 12, 13, 14, 15] {
            assert_eq!(self.words[register], before[register], "{register}");
        }
        assert_eq!(*self.word(before[RSP], false), u64::MAX);
    }

    fn step(&mut self, instruction: &Instruction) {
        let mnemonic = instruction.mnemonic();
        match mnemonic {
            Mnemonic::Push => {
                let value = self.whole(instruction, 0);
                self.words[RSP] -= 8;
                *self.word(self.words[RSP], true) = value;
            }
            Mnemonic::Pop => {
                let value = *self.word(self.words[RSP], false);
                self.words[number(instruction.op0_register())] = value;
                self.words[RSP] += 8;
            }
            Mnemonic::Call => {
                let address = self.whole(instruction, 0);
                self.called(address);
            }
            Mnemonic::Lea => {
                self.words[number(instruction.op0_register())] = self.address(instruction);
            }
            Mnemonic::Imul => {
                let product = (self.whole(instruction, 1)).wrapping_mul(instruction.immediate(2));
                self.words[number(instruction.op0_register())] = product;
            }
            Mnemonic::Mov
            | Mnemonic::Add
            | Mnemonic::Sub
            | Mnemonic::Shr
            | Mnemonic::Cmp
            | Mnemonic::Test => {
                let (left, right) = (self.whole(instruction, 0), self.whole(instruction, 1));
                let result = match mnemonic {
                    Mnemonic::Mov => right,
                    Mnemonic::Add => left.wrapping_add(right),
                    Mnemonic::Shr => left >> right,
                    Mnemonic::Test => left & right,
                    _ => left.wrapping_sub(right),
                };
                if mnemonic != Mnemonic::Mov {
                    self.is_zero = result == 0;
                    self.is_less = (left as i64) < (right as i64);
                }
                if !matches!(mnemonic, Mnemonic::Cmp | Mnemonic::Test) {
                    self.words[number(instruction.op0_register())] = result;
                }
            }
            Mnemonic::Vzeroupper => {}
            _ => self.vector_step(instruction),
        }
    }

    fn vector_step(&mut self, instruction: &Instruction) {
        let mnemonic = instruction.mnemonic();
        let is = |first: Register, register: Register| {
            (register as usize).wrapping_sub(first as usize) < 32
        };
        let vector = if instruction.op0_kind() == OpKind::Register {
            instruction.op0_register()
        } else {
            instruction.op1_register()
        };
        // Of single numbers only the lowest place counts, whatever a move or xor does above it.
        let doubles = if is(Register::ZMM0, vector) {
            8
        } else if is(Register::YMM0, vector) {
            4
        } else {
            1
        };
        if instruction.op0_kind() == OpKind::Memory {
            let values = self.vector(instruction, 1, doubles);
            let address = self.address(instruction);
            for (lane, &value) in values.iter().take(doubles).enumerate() {
                self.write(address + 8 * lane as u64, value);
            }
            return;
        }
        let old = self.vectors[number(instruction.op0_register())];
        let last = instruction.op_count() - 1;
        let (first, second) = match mnemonic {
            Mnemonic::Vbroadcastsd => (old, [self.vector(instruction, 1, 1)[0]; 8]),
            _ => {
                let first = self.vector(instruction, 1, doubles);
                (first, self.vector(instruction, last, doubles))
            }
        };
        let mut result = [0.0; 8];
        for lane in 0..doubles {
            let (a, b, c) = (old[lane], first[lane], second[lane]);
            result[lane] = match mnemonic {
                Mnemonic::Vmovsd
                | Mnemonic::Vmovupd
                | Mnemonic::Vmovapd
                | Mnemonic::Vbroadcastsd => c,
                Mnemonic::Vaddsd | Mnemonic::Vaddpd => b + c,
                Mnemonic::Vsubsd | Mnemonic::Vsubpd => b - c,
                Mnemonic::Vmulsd | Mnemonic::Vmulpd => b * c,
                Mnemonic::Vdivsd | Mnemonic::Vdivpd => b / c,
                Mnemonic::Vsqrtsd | Mnemonic::Vsqrtpd => c.sqrt(),
                Mnemonic::Vxorpd => f64::from_bits(b.to_bits() ^ c.to_bits()),
                Mnemonic::Vfmadd231sd | Mnemonic::Vfmadd231pd => b.mul_add(c, a),
                Mnemonic::Vfmsub213sd | Mnemonic::Vfmsub213pd => b.mul_add(a, -c),
                _ => panic!("{instruction:?}"),
            };
        }
        self.vectors[number(instruction.op0_register())] = result;
    }
}

/// Fields and outputs in which every operation occurs.
const FIELDS: [[&str; 3]; 4] = [
    ["y", "-x - 0.1*y + cos(1.7*t)", "1"],
    ["x*y - exp(-x)/t", "sqrt(t)*y^2 + 1/x", "0.3*tanh(y) + x"],
    ["x^1.7 + y^p", "sin(x)*cosh(y) - sinh(t)", "atan(y)/x + 0.5"],
    ["ln(t)*tan(y)", "asin(0.3*y) + acos(0.2*x)*x*y", "x^5 - t"],
];

fn tape(texts: [&str; 3], outputs: &[&str]) -> (Graph, Tape) {
    let mut graph = Graph::default();
    let known: HashMap<&str, _> = HashMap::from([
        ("x", graph.state(0)),
        ("y", graph.state(1)),
        ("t", graph.state(2)),
        ("p", graph.parameter(0)),
    ]);
    let mut read = |text: &str| {
        let named = |name: &str| known.get(name).copied();
        graph.parse(text, &named, &[]).expect("an expression")
    };
    let field = texts.map(&mut read);
    let outputs: Vec<_> = outputs.iter().map(|text| read(text)).collect();
    let tape = Tape::new(&mut graph, 3, &field, &outputs);
    (graph, tape)
}

fn bits<const L: usize>(number: &Lanes<L>) -> [u64; L] {
    number.0.map(|value| match value {
        value if value.is_nan() => f64::NAN.to_bits(),
        value => value.to_bits(),
    })
}

fn as_words<const L: usize>(numbers: &[Lanes<L>]) -> Vec<u64> {
    let size = size_of::<Lanes<L>>() / 8;
    let padded = numbers.iter().flat_map(|number| {
        let rest = core::iter::repeat_n(0, size - L);
        number.0.map(f64::to_bits).into_iter().chain(rest)
    });
    padded.collect()
}

fn agrees<const L: usize>(width: Width, texts: [&str; 3], outputs: &[&str], order: usize)
where
    Lanes<L>: Scalar,
{
    agrees_written_out::<L>(width, texts, outputs, (order, usize::MAX));
}

/// With so many bytes of code written out.
fn agrees_written_out<const L: usize>(
    width: Width,
    texts: [&str; 3],
    outputs: &[&str],
    (order, straight): (usize, usize),
) where
    Lanes<L>: Scalar,
{
    let (graph, tape) = tape(texts, outputs);
    let lane = |i: usize, k: usize| 0.4 + 0.07 * i as f64 + 0.013 * k as f64;
    let number = |k: usize| Lanes::<L>(core::array::from_fn(|i| lane(i, k)));
    let constants: Vec<Lanes<L>> = {
        let of = |i: usize| tape.constants(&graph, &[lane(i, 50)]);
        let lanes: Vec<Vec<f64>> = (0..L).map(of).collect();
        let place = |k: usize| Lanes(core::array::from_fn(|i| lanes[i][k]));
        (0..tape.constant_count()).map(place).collect()
    };
    let state: Vec<Lanes<L>> = (0..3).map(number).collect();
    let low: Vec<Lanes<L>> = (0..3).map(|k| number(k) * Lanes::splat(1e-17)).collect();
    let tau = number(9) * Lanes::splat(0.2);
    let mut expected = Expansion::new(&[&tape]).with_backend(Backend::Interpreter);
    expected.run(&tape, &constants, &state, &low, tau, order);

    let stride = <Lanes<L> as Scalar>::ORDERS[5] + 1;
    let layout = Layout {
        lanes: L,
        size: size_of::<Lanes<L>>(),
        stride,
        straight,
    };
    let code = compile(&tape, layout, width).expect("code");
    let zero = Lanes::<L>::splat(0.0);
    let mut values = vec![zero; tape.slots * stride];
    let mut lows = vec![zero; tape.slots];
    for slot in 0..3 {
        values[slot * stride] = state[slot];
        lows[slot] = low[slot];
    }
    let mut machine = Machine::new();
    let values = machine.place(as_words(&values), false);
    let frame = [
        values,
        machine.place(as_words(&lows), false),
        machine.place(as_words(&vec![zero; tape.auxiliaries]), false),
        machine.place(as_words(&constants), true),
        machine.place(as_words(&[tau]), true),
        machine.place(table(), true),
        order as u64,
    ];
    let frame = machine.place(frame.to_vec(), true);
    machine.run(&code, frame);
    let slots = (0..3).chain(tape.outputs.iter().filter_map(|output| match *output {
        super::super::tape::Operand::Series(slot) => Some(slot),
        super::super::tape::Operand::Constant(_) => None,
    }));
    for slot in slots {
        for (k, number) in expected.series(slot).iter().enumerate() {
            let at = values + ((slot * stride + k) * layout.size) as u64;
            let found: [f64; L] = core::array::from_fn(|lane| machine.read(at + 8 * lane as u64));
            assert_eq!(bits(&Lanes(found)), bits(number), "{width:?} {slot} {k}");
        }
    }
}

/// The numbers that the code needs, as they lie in memory.
fn table() -> Vec<u64> {
    let mut words = vec![0; size_of::<Table>() / 8];
    let mut put = |offset: usize, values: &[f64]| {
        for (i, value) in values.iter().enumerate() {
            words[offset / 8 + i] = value.to_bits();
        }
    };
    put(offset_of!(Table, reciprocals), &TABLE.reciprocals);
    put(offset_of!(Table, numbers), &TABLE.numbers);
    put(offset_of!(Table, negatives), &TABLE.negatives);
    put(offset_of!(Table, minus_zero), &TABLE.minus_zero);
    put(offset_of!(Table, one), &[TABLE.one]);
    put(offset_of!(Table, half), &[TABLE.half]);
    put(offset_of!(Table, two), &[TABLE.two]);
    put(offset_of!(Table, minus_two), &[TABLE.minus_two]);
    words
}

#[test]
fn code_for_every_processor_keeps_bits_and_to_its_places() {
    for texts in FIELDS {
        for outputs in [&["x", "y"][..], &["x*y - 0.3", "exp(y)", "t"]] {
            for order in [1, 2, 8, 26] {
                agrees::<16>(Width::Eight, texts, outputs, order);
                agrees::<8>(Width::Four, texts, outputs, order);
            }
            agrees::<8>(Width::Eight, texts, outputs, 13);
            agrees::<32>(Width::Eight, texts, outputs, 13);
            agrees::<32>(Width::Four, texts, outputs, 5);
            agrees::<4>(Width::Four, texts, outputs, 26);
            agrees::<1>(Width::One, texts, outputs, 26);
            agrees::<1>(Width::One, texts, outputs, 4);
            for straight in [0, 2000, 5000] {
                agrees_written_out::<16>(Width::Eight, texts, outputs, (26, 4 * straight));
                agrees_written_out::<16>(Width::Eight, texts, outputs, (3, 4 * straight));
                agrees_written_out::<1>(Width::One, texts, outputs, (26, straight));
                agrees_written_out::<1>(Width::One, texts, outputs, (3, straight));
            }
        }
    }
}
