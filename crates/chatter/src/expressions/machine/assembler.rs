//! Instructions on registers of one width, with labels. Their encodings are those of `iced-x86`.

use iced_x86::{Code, Encoder, IcedError, Instruction, MemoryOperand, Register};

/// How many doubles a register holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Width {
    /// One, in the lowest place.
    One,
    /// Four: AVX2.
    Four,
    /// Eight: AVX-512.
    Eight,
}

impl Width {
    pub(super) fn doubles(self) -> usize {
        match self {
            Self::One => 1,
            Self::Four => 4,
            Self::Eight => 8,
        }
    }

    fn register(self, number: usize) -> Register {
        let first = match self {
            Self::One => Register::XMM0,
            Self::Four => Register::YMM0,
            Self::Eight => Register::ZMM0,
        };
        first + number as u32
    }
}

/// What an instruction does, whatever the width of its registers.
#[derive(Clone, Copy, Debug)]
enum Arithmetic {
    Add,
    Subtract,
    Multiply,
    Divide,
    /// `first += second * third`, fused.
    MultiplyAdd,
    /// `first = first * second - third`, fused.
    MultiplySubtract,
    Xor,
}

impl Arithmetic {
    fn code(self, width: Width) -> Code {
        use Arithmetic::*;
        use Width::*;
        match (self, width) {
            (Add, One) => Code::VEX_Vaddsd_xmm_xmm_xmmm64,
            (Add, Four) => Code::VEX_Vaddpd_ymm_ymm_ymmm256,
            (Add, Eight) => Code::EVEX_Vaddpd_zmm_k1z_zmm_zmmm512b64_er,
            (Subtract, One) => Code::VEX_Vsubsd_xmm_xmm_xmmm64,
            (Subtract, Four) => Code::VEX_Vsubpd_ymm_ymm_ymmm256,
            (Subtract, Eight) => Code::EVEX_Vsubpd_zmm_k1z_zmm_zmmm512b64_er,
            (Multiply, One) => Code::VEX_Vmulsd_xmm_xmm_xmmm64,
            (Multiply, Four) => Code::VEX_Vmulpd_ymm_ymm_ymmm256,
            (Multiply, Eight) => Code::EVEX_Vmulpd_zmm_k1z_zmm_zmmm512b64_er,
            (Divide, One) => Code::VEX_Vdivsd_xmm_xmm_xmmm64,
            (Divide, Four) => Code::VEX_Vdivpd_ymm_ymm_ymmm256,
            (Divide, Eight) => Code::EVEX_Vdivpd_zmm_k1z_zmm_zmmm512b64_er,
            (MultiplyAdd, One) => Code::VEX_Vfmadd231sd_xmm_xmm_xmmm64,
            (MultiplyAdd, Four) => Code::VEX_Vfmadd231pd_ymm_ymm_ymmm256,
            (MultiplyAdd, Eight) => Code::EVEX_Vfmadd231pd_zmm_k1z_zmm_zmmm512b64_er,
            (MultiplySubtract, One) => Code::VEX_Vfmsub213sd_xmm_xmm_xmmm64,
            (MultiplySubtract, Four) => Code::VEX_Vfmsub213pd_ymm_ymm_ymmm256,
            (MultiplySubtract, Eight) => Code::EVEX_Vfmsub213pd_zmm_k1z_zmm_zmmm512b64_er,
            (Xor, One) => Code::VEX_Vxorpd_xmm_xmm_xmmm128,
            (Xor, Four) => Code::VEX_Vxorpd_ymm_ymm_ymmm256,
            (Xor, Eight) => Code::EVEX_Vxorpd_zmm_k1z_zmm_zmmm512b64,
        }
    }
}

/// A vector register, by number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Vector(pub usize);

/// A place in memory: a register that points, and a distance in bytes.
#[derive(Clone, Copy, Debug)]
pub(super) struct At(pub Register, pub usize);

impl At {
    pub(super) fn plus(self, bytes: usize) -> Self {
        Self(self.0, self.1.wrapping_add(bytes))
    }

    pub(super) fn minus(self, bytes: usize) -> Self {
        Self(self.0, self.1.wrapping_sub(bytes))
    }

    fn operand(self) -> MemoryOperand {
        // Distances may be negative: they wrap.
        MemoryOperand::with_base_displ(self.0, self.1 as i64)
    }
}

/// Where an operand is.
#[derive(Clone, Copy, Debug)]
pub(super) enum Source {
    Register(Vector),
    Memory(At),
}

impl From<Vector> for Source {
    fn from(vector: Vector) -> Self {
        Self::Register(vector)
    }
}

impl From<At> for Source {
    fn from(at: At) -> Self {
        Self::Memory(at)
    }
}

/// A place in the code, bound or yet to come.
#[derive(Clone, Copy, Debug)]
pub(super) struct Label(usize);

/// When a jump is taken, by the comparison before it; numbers are signed.
#[derive(Clone, Copy, Debug)]
pub(super) enum When {
    Always,
    Equal,
    NotEqual,
    Less,
    AtLeast,
    Greater,
}

/// Code as it grows.
pub(super) struct Assembler {
    pub(super) width: Width,
    encoder: Encoder,
    length: usize,
    labels: Vec<Option<usize>>,
    jumps: Vec<(usize, Code, Label)>,
    failed: bool,
}

impl Assembler {
    pub(super) fn new(width: Width) -> Self {
        Self {
            width,
            encoder: Encoder::new(64),
            length: 0,
            labels: Vec::new(),
            jumps: Vec::new(),
            failed: false,
        }
    }

    /// Bytes so far.
    pub(super) fn length(&self) -> usize {
        self.length
    }

    /// Whether an instruction could not be encoded.
    pub(super) fn failed(&self) -> bool {
        self.failed
    }

    /// The code with its jumps; none if an instruction could not be encoded, or a jump leads nowhere.
    pub(super) fn finish(mut self) -> Option<Vec<u8>> {
        let mut code = self.encoder.take_buffer();
        if self.failed {
            return None;
        }
        for &(place, jump, Label(label)) in &self.jumps {
            let target = self.labels[label]? as u64;
            let instruction = Instruction::with_branch(jump, target).ok()?;
            let length = self.encoder.encode(&instruction, place as u64).ok()?;
            code[place..place + length].copy_from_slice(&self.encoder.take_buffer());
        }
        Some(code)
    }

    fn push(&mut self, instruction: Result<Instruction, IcedError>) {
        let encoded = instruction.and_then(|i| self.encoder.encode(&i, self.length as u64));
        match encoded {
            Ok(length) => self.length += length,
            Err(_) => self.failed = true,
        }
    }

    fn arithmetic(
        &mut self,
        what: Arithmetic,
        into: Vector,
        first: Vector,
        second: impl Into<Source>,
    ) {
        let code = what.code(self.width);
        let (into, first) = (self.width.register(into.0), self.width.register(first.0));
        self.push(match second.into() {
            Source::Register(second) => {
                Instruction::with3(code, into, first, self.width.register(second.0))
            }
            Source::Memory(at) => Instruction::with3(code, into, first, at.operand()),
        });
    }

    /// `into = first + second`.
    pub(super) fn add(&mut self, into: Vector, first: Vector, second: impl Into<Source>) {
        self.arithmetic(Arithmetic::Add, into, first, second);
    }

    /// `into = first - second`.
    pub(super) fn subtract(&mut self, into: Vector, first: Vector, second: impl Into<Source>) {
        self.arithmetic(Arithmetic::Subtract, into, first, second);
    }

    /// `into = first * second`.
    pub(super) fn multiply(&mut self, into: Vector, first: Vector, second: impl Into<Source>) {
        self.arithmetic(Arithmetic::Multiply, into, first, second);
    }

    /// `into = first / second`.
    pub(super) fn divide(&mut self, into: Vector, first: Vector, second: impl Into<Source>) {
        self.arithmetic(Arithmetic::Divide, into, first, second);
    }

    /// `sum += first * second`, rounded once.
    pub(super) fn multiply_add(&mut self, sum: Vector, first: Vector, second: impl Into<Source>) {
        self.arithmetic(Arithmetic::MultiplyAdd, sum, first, second);
    }

    /// `into = into * first - second`, rounded once.
    pub(super) fn multiply_subtract(
        &mut self,
        into: Vector,
        first: Vector,
        second: impl Into<Source>,
    ) {
        self.arithmetic(Arithmetic::MultiplySubtract, into, first, second);
    }

    /// Positive zero.
    pub(super) fn zero(&mut self, into: Vector) {
        self.arithmetic(Arithmetic::Xor, into, into, into);
    }

    /// Changes the sign: `mask` points to eight doubles -0.0.
    pub(super) fn negate(&mut self, vector: Vector, mask: At) {
        self.arithmetic(Arithmetic::Xor, vector, vector, mask);
    }

    /// `into = sqrt(from)`.
    pub(super) fn square_root(&mut self, into: Vector, from: Vector) {
        let (into, from) = (self.width.register(into.0), self.width.register(from.0));
        self.push(match self.width {
            Width::One => Instruction::with3(Code::VEX_Vsqrtsd_xmm_xmm_xmmm64, into, from, from),
            Width::Four => Instruction::with2(Code::VEX_Vsqrtpd_ymm_ymmm256, into, from),
            Width::Eight => {
                Instruction::with2(Code::EVEX_Vsqrtpd_zmm_k1z_zmmm512b64_er, into, from)
            }
        });
    }

    pub(super) fn copy(&mut self, into: Vector, from: Vector) {
        let code = match self.width {
            Width::One => Code::VEX_Vmovapd_xmm_xmmm128,
            Width::Four => Code::VEX_Vmovapd_ymm_ymmm256,
            Width::Eight => Code::EVEX_Vmovapd_zmm_k1z_zmmm512,
        };
        let (into, from) = (self.width.register(into.0), self.width.register(from.0));
        self.push(Instruction::with2(code, into, from));
    }

    pub(super) fn load(&mut self, into: Vector, at: At) {
        let code = match self.width {
            Width::One => Code::VEX_Vmovsd_xmm_m64,
            Width::Four => Code::VEX_Vmovupd_ymm_ymmm256,
            Width::Eight => Code::EVEX_Vmovupd_zmm_k1z_zmmm512,
        };
        let into = self.width.register(into.0);
        self.push(Instruction::with2(code, into, at.operand()));
    }

    /// The double at `at`, in every lane.
    pub(super) fn broadcast(&mut self, into: Vector, at: At) {
        self.broadcast_from(into, at.operand());
    }

    /// The double number `index` after `at`.
    pub(super) fn broadcast_indexed(&mut self, into: Vector, at: At, index: Register) {
        self.broadcast_from(
            into,
            MemoryOperand::with_base_index_scale_displ_size(at.0, index, 8, at.1 as i64, 1),
        );
    }

    fn broadcast_from(&mut self, into: Vector, operand: MemoryOperand) {
        let code = match self.width {
            Width::One => Code::VEX_Vmovsd_xmm_m64,
            Width::Four => Code::VEX_Vbroadcastsd_ymm_m64,
            Width::Eight => Code::EVEX_Vbroadcastsd_zmm_k1z_xmmm64,
        };
        let into = self.width.register(into.0);
        self.push(Instruction::with2(code, into, operand));
    }

    pub(super) fn store(&mut self, at: At, from: Vector) {
        let code = match self.width {
            Width::One => Code::VEX_Vmovsd_m64_xmm,
            Width::Four => Code::VEX_Vmovupd_ymmm256_ymm,
            Width::Eight => Code::EVEX_Vmovupd_zmmm512_k1z_zmm,
        };
        let from = self.width.register(from.0);
        self.push(Instruction::with2(code, at.operand(), from));
    }

    /// Leaves the wide registers as code that knows nothing of them expects.
    pub(super) fn end_of_vectors(&mut self) {
        if self.width != Width::One {
            self.push(Ok(Instruction::with(Code::VEX_Vzeroupper)));
        }
    }

    pub(super) fn label(&mut self) -> Label {
        self.labels.push(None);
        Label(self.labels.len() - 1)
    }

    pub(super) fn bind(&mut self, label: Label) {
        self.labels[label.0] = Some(self.length);
    }

    pub(super) fn jump(&mut self, when: When, to: Label) {
        let code = match when {
            When::Always => Code::Jmp_rel32_64,
            When::Equal => Code::Je_rel32_64,
            When::NotEqual => Code::Jne_rel32_64,
            When::Less => Code::Jl_rel32_64,
            When::AtLeast => Code::Jge_rel32_64,
            When::Greater => Code::Jg_rel32_64,
        };
        self.jumps.push((self.length, code, to));
        // Always as long as it will be.
        self.push(Instruction::with_branch(code, self.length as u64));
    }

    pub(super) fn load_word(&mut self, into: Register, at: At) {
        self.push(Instruction::with2(Code::Mov_r64_rm64, into, at.operand()));
    }

    pub(super) fn set(&mut self, register: Register, value: usize) {
        self.push(Instruction::with2(
            Code::Mov_r64_imm64,
            register,
            value as u64,
        ));
    }

    pub(super) fn copy_word(&mut self, into: Register, from: Register) {
        self.push(Instruction::with2(Code::Mov_r64_rm64, into, from));
    }

    /// The address of `at`.
    pub(super) fn address(&mut self, into: Register, at: At) {
        self.push(Instruction::with2(Code::Lea_r64_m, into, at.operand()));
    }

    pub(super) fn add_to(&mut self, register: Register, bytes: usize) {
        self.push(Instruction::with2(
            Code::Add_rm64_imm32,
            register,
            bytes as i32,
        ));
    }

    pub(super) fn subtract_from(&mut self, register: Register, bytes: usize) {
        self.push(Instruction::with2(
            Code::Sub_rm64_imm32,
            register,
            bytes as i32,
        ));
    }

    /// Half, rounded down.
    pub(super) fn halve(&mut self, register: Register) {
        self.push(Instruction::with2(Code::Shr_rm64_imm8, register, 1_u32));
    }

    pub(super) fn times(&mut self, into: Register, factor: usize) {
        self.push(Instruction::with3(
            Code::Imul_r64_rm64_imm32,
            into,
            into,
            factor as i32,
        ));
    }

    pub(super) fn add_word(&mut self, into: Register, from: Register) {
        self.push(Instruction::with2(Code::Add_r64_rm64, into, from));
    }

    pub(super) fn compare(&mut self, register: Register, with: Register) {
        self.push(Instruction::with2(Code::Cmp_r64_rm64, register, with));
    }

    pub(super) fn compare_with(&mut self, register: Register, with: i32) {
        self.push(Instruction::with2(Code::Cmp_rm64_imm32, register, with));
    }

    /// Compares the lowest bit with zero.
    pub(super) fn test_odd(&mut self, register: Register) {
        self.push(Instruction::with2(Code::Test_rm64_imm32, register, 1_i32));
    }

    pub(super) fn save(&mut self, register: Register) {
        self.push(Instruction::with1(Code::Push_r64, register));
    }

    pub(super) fn restore(&mut self, register: Register) {
        self.push(Instruction::with1(Code::Pop_r64, register));
    }

    pub(super) fn call(&mut self, function: Register) {
        self.push(Instruction::with1(Code::Call_rm64, function));
    }

    pub(super) fn give_back(&mut self) {
        self.push(Ok(Instruction::with(Code::Retnq)));
    }
}
