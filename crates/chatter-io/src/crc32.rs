//! CRC-32 as in ZIP and PNG (ISO 3309, reflected polynomial 0xEDB88320), with the sum of a concatenation.

const POLYNOMIAL: u32 = 0xEDB8_8320;

/// `TABLES[k][b]`: the register after byte `b` followed by `k` zero bytes, for eight bytes at a time.
static TABLES: [[u32; 256]; 8] = tables();

const fn tables() -> [[u32; 256]; 8] {
    let mut tables = [[0u32; 256]; 8];
    let mut byte = 0;
    while byte < 256 {
        let mut register = byte as u32;
        let mut bit = 0;
        while bit < 8 {
            register = if register & 1 == 1 {
                (register >> 1) ^ POLYNOMIAL
            } else {
                register >> 1
            };
            bit += 1;
        }
        tables[0][byte] = register;
        byte += 1;
    }
    let mut k = 1;
    while k < 8 {
        let mut byte = 0;
        while byte < 256 {
            let previous = tables[k - 1][byte];
            tables[k][byte] = (previous >> 8) ^ tables[0][(previous & 0xFF) as usize];
            byte += 1;
        }
        k += 1;
    }
    tables
}

/// A running checksum.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Crc32 {
    sum: u32,
    length: u64,
}

impl Crc32 {
    pub(crate) fn of(bytes: &[u8]) -> u32 {
        let mut crc = Crc32::default();
        crc.update(bytes);
        crc.sum()
    }

    pub(crate) fn sum(self) -> u32 {
        self.sum
    }

    pub(crate) fn length(self) -> u64 {
        self.length
    }

    pub(crate) fn update(&mut self, bytes: &[u8]) {
        let mut register = !self.sum;
        let mut chunks = bytes.chunks_exact(8);
        for c in &mut chunks {
            let low = register ^ u32::from_le_bytes([c[0], c[1], c[2], c[3]]);
            register = TABLES[7][(low & 0xFF) as usize]
                ^ TABLES[6][((low >> 8) & 0xFF) as usize]
                ^ TABLES[5][((low >> 16) & 0xFF) as usize]
                ^ TABLES[4][(low >> 24) as usize]
                ^ TABLES[3][c[4] as usize]
                ^ TABLES[2][c[5] as usize]
                ^ TABLES[1][c[6] as usize]
                ^ TABLES[0][c[7] as usize];
        }
        for &b in chunks.remainder() {
            register = (register >> 8) ^ TABLES[0][((register ^ u32::from(b)) & 0xFF) as usize];
        }
        self.sum = !register;
        self.length += bytes.len() as u64;
    }

    /// The checksum of what `self` has seen followed by what `rest` has seen.
    pub(crate) fn then(self, rest: Crc32) -> Crc32 {
        // Appending n bytes multiplies by x^(8n) modulo the polynomial, over GF(2).
        Crc32 {
            sum: multiply(self.sum, power_of_x(rest.length * 8)) ^ rest.sum,
            length: self.length + rest.length,
        }
    }
}

/// Product of two polynomials over GF(2) modulo the CRC polynomial; bit 31 is the coefficient of x^0.
fn multiply(a: u32, mut b: u32) -> u32 {
    let mut product = 0;
    for degree in 0..32 {
        if a & (1 << (31 - degree)) != 0 {
            product ^= b;
        }
        b = if b & 1 == 1 {
            (b >> 1) ^ POLYNOMIAL
        } else {
            b >> 1
        };
    }
    product
}

/// x^n modulo the CRC polynomial, by repeated squaring.
fn power_of_x(mut n: u64) -> u32 {
    let mut result = 1 << 31;
    let mut square = 1 << 30;
    while n > 0 {
        if n & 1 == 1 {
            result = multiply(result, square);
        }
        square = multiply(square, square);
        n >>= 1;
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_standard_check_value() {
        assert_eq!(Crc32::of(b"123456789"), 0xCBF4_3926);
        assert_eq!(Crc32::of(b""), 0);
    }

    #[test]
    fn pieces_and_concatenations_agree_with_the_whole() {
        let bytes: Vec<u8> = (0..1000u32).map(|k| ((k * k) >> 3) as u8).collect();
        for cut in [0, 1, 7, 8, 500, 999, 1000] {
            let (a, b) = bytes.split_at(cut);
            let mut piecewise = Crc32::default();
            piecewise.update(a);
            piecewise.update(b);
            let (mut first, mut second) = (Crc32::default(), Crc32::default());
            first.update(a);
            second.update(b);
            assert_eq!(piecewise.sum(), Crc32::of(&bytes));
            assert_eq!(first.then(second).sum(), Crc32::of(&bytes));
        }
    }
}
