//! Any text is read as a model or refused with messages whose places lie in it; what is read can be checked, its
//! mechanics derived, its constants evaluated and set again. What follows a NUL is the file that its tables name.

#![no_main]

use chatter::model::{Mechanics, Model, Palette, check};
use libfuzzer_sys::fuzz_target;

/// Mechanics of more states than this take longer to derive than a fuzzer can wait.
const MOST_STATES: usize = 8;

fuzz_target!(|input: &str| {
    let (text, data) = input.split_once('\0').unwrap_or((input, ""));
    let mut load = |_: &str| Ok(data.to_owned());
    let mut model = match Model::from_toml_with(text, "model.toml", &mut load) {
        Ok(model) => model,
        Err(errors) => {
            assert!(!errors.errors().is_empty());
            assert!(!errors.render(Palette::Ansi).is_empty());
            for error in errors.errors() {
                let place = match error.source_name() {
                    "model.toml" => text.get(error.span()).is_some(),
                    _ => data.get(error.span()).is_some() || text.get(error.span()).is_some(),
                };
                assert!(place, "{error:?}");
                let (line, column) = error.line_and_column();
                assert!(line >= 1 && column >= 1);
            }
            return;
        }
    };
    let parameters = model.parameter_values::<f64>(&[]);
    assert!(parameters.iter().all(|value| value.is_finite()));
    let initial = model.initial_state(&parameters);
    assert!(initial.iter().all(|value| value.is_finite()));
    assert_eq!(model.time.is_some(), model.state_index("t").is_some());
    for contact in &model.contacts {
        assert_eq!(contact.impulse.len(), model.states.len());
    }
    if model.states.len() <= MOST_STATES {
        for warning in check(&model).warnings {
            assert!(!warning.to_string().is_empty());
        }
        if let Ok(mut mechanics) = Mechanics::new(&model) {
            let all: Vec<usize> = (0..model.contacts.len().min(3)).collect();
            let _ = mechanics.sticking(&all);
        }
    }
    let names: Vec<String> = model.parameter_names().into_iter().map(str::to_owned).collect();
    for name in &names {
        // May fail, where another constant depends on it in a way that does not allow this value.
        let _ = model.set_parameter(name, "2");
        assert!(model.set_parameter(name, name).is_err());
    }
});
