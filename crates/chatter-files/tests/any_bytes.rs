//! Archives and journals of any bytes: files that were written, changed here and there, with and without the checksums
//! that go with the changes. `fuzz/` runs the same laws on whatever it comes up with.

#[path = "laws/journal.rs"]
mod journal;
#[path = "laws/npz.rs"]
mod npz;

use chatter_files::journal::{Found, Journal};
use chatter_files::tables::{Dataset, NpzReader, Table};
use std::path::PathBuf;

/// Changed files a test; `CHATTER_ANY_BYTES` sets another number, for long runs.
fn executions() -> u64 {
    let wanted = std::env::var("CHATTER_ANY_BYTES").ok();
    wanted.and_then(|text| text.parse().ok()).unwrap_or(2_000)
}

struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("chatter-any-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// SplitMix64.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn below(&mut self, bound: usize) -> usize {
        (self.next() % bound.max(1) as u64) as usize
    }

    /// A few bytes set, numbers put in, pieces cut out, repeated or cut off.
    fn change(&mut self, bytes: &mut Vec<u8>) {
        const NUMBERS: [u64; 8] = [
            0,
            1,
            0xFFFF,
            0xFFFF_FFFF,
            u64::MAX,
            1 << 31,
            1 << 62,
            200 << 30,
        ];
        const TEXTS: [&[u8]; 6] = [
            b"<U4611686018427387904",
            b"<U0",
            b"(1000000000000000,)",
            b"(4294967296, 4294967296)",
            b"PK\x05\x06",
            b"\x93NUMPY\x02",
        ];
        for _ in 0..=self.below(3) {
            if bytes.is_empty() {
                return;
            }
            let at = self.below(bytes.len());
            match self.below(7) {
                0 => bytes[at] ^= 1 << self.below(8),
                1 => bytes[at] = self.next() as u8,
                2 => {
                    let number = NUMBERS[self.below(NUMBERS.len())].to_le_bytes();
                    let width = [2, 4, 8][self.below(3)];
                    for (byte, new) in bytes[at..].iter_mut().zip(&number[..width]) {
                        *byte = *new;
                    }
                }
                3 => {
                    let text = TEXTS[self.below(TEXTS.len())];
                    for (byte, new) in bytes[at..].iter_mut().zip(text) {
                        *byte = *new;
                    }
                }
                4 => bytes.truncate(at),
                5 => {
                    let to = (at + self.below(100)).min(bytes.len());
                    bytes.drain(at..to);
                }
                _ => {
                    let to = (at + self.below(100)).min(bytes.len());
                    let piece = bytes[at..to].to_vec();
                    bytes.splice(at..at, piece);
                }
            }
        }
    }
}

/// CRC-32 as in ZIP, bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    let step = |sum: u32, _| (sum >> 1) ^ (0xEDB8_8320 & (sum & 1).wrapping_neg());
    !bytes
        .iter()
        .fold(!0, |sum, &byte| (0..8).fold(sum ^ u32::from(byte), step))
}

/// The checksums of stored entries, in the directory, as their bytes are now.
fn repair_archive(bytes: &mut [u8]) {
    let mut at = 0;
    while at + 46 <= bytes.len() {
        if !bytes[at..].starts_with(b"PK\x01\x02") {
            at += 1;
            continue;
        }
        let number = |at: usize, width: usize| {
            (0..width).fold(0, |n, k| n | usize::from(bytes[at + k]) << (8 * k))
        };
        let (size, local) = (number(at + 20, 4), number(at + 42, 4));
        if local + 30 <= bytes.len() {
            let start = local + 30 + number(local + 26, 2) + number(local + 28, 2);
            if let Some(data) = bytes.get(start..start.saturating_add(size)) {
                let sum = crc32(data).to_le_bytes();
                bytes[at + 16..at + 20].copy_from_slice(&sum);
            }
        }
        at += 46;
    }
}

/// The checksums of records whose lengths are still right.
fn repair_journal(bytes: &mut [u8]) {
    let mut at = 16;
    while at + 12 <= bytes.len() {
        let length = u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
        let Some(end) = usize::try_from(length)
            .ok()
            .and_then(|n| n.checked_add(at + 12))
        else {
            return;
        };
        let Some(record) = bytes.get(at + 12..end) else {
            return;
        };
        let sum = crc32(&[&bytes[at..at + 8], record].concat());
        bytes[at + 8..at + 12].copy_from_slice(&sum.to_le_bytes());
        at = end;
    }
}

/// An archive of one array, compressed as `numpy.savez_compressed` does.
fn compressed() -> Vec<u8> {
    let mut header = b"\x93NUMPY\x01\x00\x76\x00".to_vec();
    header.extend(b"{'descr': '<f8', 'fortran_order': False, 'shape': (40,), }");
    header.resize(127, b' ');
    header.push(b'\n');
    let numbers = (0..40).flat_map(|k| (f64::from(k) / 7.0).to_le_bytes());
    let array: Vec<u8> = header.into_iter().chain(numbers).collect();
    let packed = miniz_oxide::deflate::compress_to_vec(&array, 6);
    let about = |bytes: &mut Vec<u8>| {
        bytes.extend([20, 0, 0, 0, 8, 0, 0, 0, 0x21, 0]);
        bytes.extend(crc32(&array).to_le_bytes());
        bytes.extend((packed.len() as u32).to_le_bytes());
        bytes.extend((array.len() as u32).to_le_bytes());
        bytes.extend([5, 0, 0, 0]);
    };
    let mut file = b"PK\x03\x04".to_vec();
    about(&mut file);
    file.extend(b"x.npy");
    file.extend(&packed);
    let directory = file.len();
    file.extend(b"PK\x01\x02\x14\x00");
    about(&mut file);
    file.extend([0; 14]);
    file.extend(b"x.npy");
    let length = file.len() - directory;
    file.extend(b"PK\x05\x06\0\0\0\0\x01\0\x01\0");
    file.extend((length as u32).to_le_bytes());
    file.extend((directory as u32).to_le_bytes());
    file.extend([0, 0]);
    file
}

#[test]
fn archives_of_any_bytes_are_read_or_refused() {
    let folder = Folder::new("npz");
    let whole = folder.0.join("whole.npz");
    let table = Table::new("columns")
        .column("q", vec![0.1, f64::NAN, 3.0])
        .column("n", vec![1_i64, -2, i64::MAX])
        .column("outcome", vec!["chaotic", "", "périodique Ω"]);
    let data = Dataset::new().table(table).text("model", "y = \"v\"\n");
    data.write(&whole).unwrap();
    let stored = std::fs::read(&whole).unwrap();
    let path = folder.0.join("a.npz");
    std::fs::write(&path, compressed()).unwrap();
    let numbers = NpzReader::open(&path).unwrap().floats("x").unwrap();
    assert_eq!((numbers.len(), numbers[39]), (40, 39.0 / 7.0));
    let seeds = [stored, compressed()];
    seeds.iter().for_each(|good| npz::law(&path, good));
    let mut random = Random(1);
    for k in 0..executions() {
        let mut bytes = seeds[(k % 2) as usize].clone();
        random.change(&mut bytes);
        if random.below(2) == 0 {
            repair_archive(&mut bytes);
        }
        npz::law(&path, &bytes);
    }
}

#[test]
fn journals_of_any_bytes_are_refused_or_gone_on_with() {
    let folder = Folder::new("journal");
    let whole = folder.0.join("whole.journal");
    let Found::New(mut journal) = Journal::find(&whole, b"{\"about\":\"this\"}").unwrap() else {
        panic!("there was one");
    };
    for k in 0..6_u8 {
        journal
            .append(&vec![k; 1 << k])
            .expect("there is room for it");
    }
    drop(journal);
    let good = std::fs::read(&whole).unwrap();
    let path = folder.0.join("a.journal");
    journal::law(&path, &good);
    let mut random = Random(2);
    for _ in 0..executions() {
        let mut bytes = good.clone();
        random.change(&mut bytes);
        if random.below(2) == 0 {
            repair_journal(&mut bytes);
        }
        journal::law(&path, &bytes);
    }
}
