//! The answer as a stream of records.
//!
//! Each is the length of its content in bytes and its kind, both as 32-bit numbers, little-endian, and the content. A stream
//! that does not end with [`Kind::End`] has broken off.

use core::ops::ControlFlow;

/// What a record holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Kind {
    /// Nothing: all has been said.
    End = 0,
    /// A JSON document.
    Document = 1,
    /// A row of a diagram: see [`answers::diagram`](crate::answer).
    Row = 2,
    /// Numbers, 64 bits each.
    Numbers = 3,
    /// A file, as it is written to a disk.
    File = 4,
    /// How far the work is, in words.
    Progress = 5,
    /// Something to know beside the answer, as text.
    Remark = 6,
    /// Why there is no answer, as JSON.
    Refusal = 7,
}

impl Kind {
    /// The record with this content, but for the content itself.
    pub fn head(self, length: usize) -> [u8; 8] {
        let mut head = [0; 8];
        let length = u32::try_from(length).unwrap_or(u32::MAX);
        head[..4].copy_from_slice(&length.to_le_bytes());
        head[4..].copy_from_slice(&(self as u32).to_le_bytes());
        head
    }
}

/// Where records go.
pub trait Sink: Send {
    /// Takes a record. After a break nobody listens any more.
    fn put(&mut self, kind: Kind, content: &[u8]) -> ControlFlow<()>;
}
