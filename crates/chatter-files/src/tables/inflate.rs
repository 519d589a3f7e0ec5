//! Bytes of a compressed entry of an archive (RFC 1951), as they are asked for.

use miniz_oxide::inflate::stream::{InflateState, inflate};
use miniz_oxide::{DataFormat, MZFlush, MZStatus};
use std::io::{BufRead, Error, ErrorKind, Read, Result};

/// Most bytes that a compressed one can stand for.
pub(super) const LARGEST_RATIO: u64 = 1032;

/// Inflates what it reads, in flat memory.
pub(super) struct Inflated<R> {
    from: R,
    state: Box<InflateState>,
}

impl<R: BufRead> Inflated<R> {
    pub(super) fn new(from: R) -> Self {
        let state = InflateState::new_boxed(DataFormat::Raw);
        Self { from, state }
    }
}

impl<R: BufRead> Read for Inflated<R> {
    fn read(&mut self, into: &mut [u8]) -> Result<usize> {
        if into.is_empty() {
            return Ok(0);
        }
        loop {
            let compressed = self.from.fill_buf()?;
            let at_end = compressed.is_empty();
            let step = inflate(&mut self.state, compressed, into, MZFlush::None);
            self.from.consume(step.bytes_consumed);
            match step.status {
                _ if step.bytes_written > 0 => return Ok(step.bytes_written),
                Ok(MZStatus::StreamEnd) => return Ok(0),
                Ok(_) if !at_end && step.bytes_consumed > 0 => {}
                _ => {
                    let what = "its compressed data are damaged";
                    return Err(Error::new(ErrorKind::InvalidData, what));
                }
            }
        }
    }
}
