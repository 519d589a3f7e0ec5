//! Modes of a system as C++: what a kernel written around them steps by.

use super::program::{Closed, Grip, Program};
use super::system::System;
use crate::expressions::{Graph, NoSource, Sides};

impl System {
    /// The tapes of the modes in which at most one contact is closed, as C++: a namespace for each mode, with structures for its motion
    /// and guards, for impacts, for gap, rate, acceleration and jerk of each contact, for what brings it to rest, and for what a motion
    /// in contact keeps at zero. The modes on one side of all surfaces: those of a model with corners are more.
    ///
    /// # Errors
    /// A constant cannot be written as C++.
    pub fn source(&self) -> Result<String, NoSource> {
        let sides = Sides::default();
        let mut text = "// Written by `cargo run -p chatter-dynamics --example tapes_as_cpp`.\n\n".to_owned();
        let contacts = 0..self.contacts();
        let one = |contact| (format!("contact_{contact}"), Closed::NONE.with(contact));
        for (name, closed) in core::iter::once(("flight".to_owned(), Closed::NONE)).chain(contacts.map(one)) {
            let grip = Grip { closed, idle: Closed::NONE };
            let mode = self.meet(grip, sides);
            // None where this contact cannot be held.
            if let Some((graph, program)) = self.compiled(mode) {
                text += &format!("namespace {name} {{\n{}}}\n\n", program.source(graph)?);
            }
        }
        Ok(text)
    }
}

impl Program {
    fn source(&self, graph: &Graph) -> Result<String, NoSource> {
        let mut text = String::new();
        for (index, guard) in self.guards.iter().enumerate() {
            text += &format!("// Output {index} of Motion: {:?}.\n", guard.kind);
        }
        text += &self.tape.source(graph, "Motion")?;
        for (contact, impact) in self.impacts.iter().enumerate() {
            if let Some(impact) = impact {
                text += &format!("// Outputs after the scalars: states {:?}.\n", impact.changed);
                text += &impact.tape.source(graph, &format!("Impact{contact}"))?;
            }
        }
        for (contact, tape) in self.locals.iter().enumerate() {
            text += &tape.source(graph, &format!("Local{contact}"))?;
        }
        for (contact, tape) in self.captures.iter().enumerate() {
            text += &tape.source(graph, &format!("Capture{contact}"))?;
        }
        text += &self.residuals.source(graph, "Residuals")?;
        Ok(text)
    }
}
