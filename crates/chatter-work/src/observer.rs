//! Who listens while an answer is computed.

use core::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

/// Hears how far the work is and what is to be said beside the answer, and may stop it.
pub trait Observer: Sync {
    /// This part of the work is done, of one. The message says more, and is made only where it is shown.
    fn progress(&self, done: f64, message: &dyn Fn() -> String) {
        let _ = (done, message);
    }

    /// Something to know that is no part of the answer.
    fn remark(&self, text: &str) {
        let _ = text;
    }

    /// Set when the work is to stop; what is done by then is kept where it can be.
    fn stop(&self) -> &AtomicBool;

    /// Goes on unless the work is to stop.
    fn going_on(&self) -> ControlFlow<()> {
        match self.stop().load(Ordering::Relaxed) {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    }
}

/// Says nothing and never stops.
#[derive(Debug, Default)]
pub struct Silent {
    stop: AtomicBool,
}

impl Observer for Silent {
    fn stop(&self) -> &AtomicBool {
        &self.stop
    }
}
