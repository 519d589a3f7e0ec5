//! Modes of a system as C++: what a kernel written around them steps by.

use super::closed::{Closed, Grip};
use super::program::Program;
use crate::expressions::{Graph, NoSource, Sides};
use crate::flow::system::System;

impl System {
    /// The tapes of the modes in which at most one contact is closed, as C++: a namespace for each mode, with structures for its motion
    /// and guards, for impacts, for gap, rate, acceleration and jerk of each contact, and for what brings it to rest. Of a model with
    /// corners these are the modes on the sides that a trajectory is on before it is known on which: there are more.
    ///
    /// # Errors
    /// A constant cannot be written as C++.
    pub fn source(&self) -> Result<String, NoSource> {
        let sides = Sides::default();
        let mut text =
            "// Written by `cargo run -p chatter-dynamics --example tapes_as_cpp`.\n\n".to_owned();
        let contacts = 0..self.contacts();
        let one = |contact| (format!("contact_{contact}"), Closed::NONE.with(contact));
        for (name, closed) in
            core::iter::once(("flight".to_owned(), Closed::NONE)).chain(contacts.map(one))
        {
            let grip = Grip {
                closed,
                idle: Closed::NONE,
            };
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
                text += &format!(
                    "// Outputs after the scalars: states {:?}.\n",
                    impact.changed
                );
                text += &impact.tape.source(graph, &format!("Impact{contact}"))?;
            }
        }
        for (contact, tape) in self.locals.iter().enumerate() {
            text += &tape.source(graph, &format!("Local{contact}"))?;
        }
        for (contact, tape) in self.captures.iter().enumerate() {
            text += &tape.source(graph, &format!("Capture{contact}"))?;
        }
        Ok(text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flow::system::FLIGHT;
    use crate::model::Model;
    use std::path::Path;

    fn shipped() -> impl Iterator<Item = Model> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models");
        let files = std::fs::read_dir(folder).expect("the shipped models");
        files.map(|file| {
            let text = std::fs::read_to_string(file.expect("a file").path()).expect("a text");
            Model::from_toml(&text, "model.toml").expect("a model")
        })
    }

    /// The statements of the first function of a name.
    fn statements<'t>(text: &'t str, name: &str) -> Vec<&'t str> {
        let head = format!("static void {name}(");
        let lines = text.lines().skip_while(|line| !line.contains(&head));
        let body = lines.skip(1).take_while(|&line| line != "    }");
        body.map(str::trim).collect()
    }

    #[test]
    fn each_operation_of_the_shipped_models_is_a_statement() {
        for model in shipped() {
            let system = System::new(&model).expect("a system");
            let (graph, program) = system.compiled(FLIGHT).expect("free flight");
            for tape in program.tapes() {
                let text = tape.source(graph, "Tape").expect("constant numbers");
                let count = tape.ops.len() + tape.field.len();
                assert_eq!(statements(&text, "begin").len(), count, "{text}");
            }
            let motion = (program.tape.source(graph, "Motion")).expect("constant numbers");
            let count = program.tape.ops.len() + program.tape.field.len();
            assert_eq!(statements(&motion, "go_on").len(), count, "{motion}");
            assert!(system.source().is_ok());
        }
    }

    #[test]
    fn statements_say_what_the_interpreter_does() {
        let text = source("v = \"-1 - 0.5*v*sqrt(y)\"").expect("constant numbers");
        let expected = [
            "x[2][k] = root_coefficient(x[2], x[0][k], inverse[0], k);",
            "x[3][k] = convolution(x[2], x[1], k + 1);",
            "if (k < last) x[1][k + 1] = x[3][k] * (c[0] * factor);",
            "if (k < last) x[0][k + 1] = x[1][k] * factor;",
        ];
        assert_eq!(statements(&text, "go_on"), expected);
    }

    #[test]
    fn a_choice_between_parameters_is_refused() {
        assert_eq!(source("v = \"-max(a, b)*y\""), Err(NoSource));
    }

    fn source(rate: &str) -> Result<String, NoSource> {
        let text = format!(
            "[parameters]\na = 1\nb = 2\n[flight]\ny = \"v\"\n{rate}\n[initial]\ny = 1\nv = 0\n"
        );
        let model = Model::from_toml(&text, "fall.toml").expect("a model");
        System::new(&model).expect("a system").source()
    }
}
