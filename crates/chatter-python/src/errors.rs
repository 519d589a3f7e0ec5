//! Refusals as exceptions, those of `chatter._errors`.

use chatter::model::{ModelError, Palette};
use chatter_work::Refusal;
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// An option of the command line, as Python calls it.
fn notation(option: &str) -> String {
    match option {
        "set" => "value of".to_owned(),
        "initial" => "initial value of".to_owned(),
        "until" => "t".to_owned(),
        "all" => "periods".to_owned(),
        "depth" => "doublings or branch_points".to_owned(),
        option => option.replace('-', "_"),
    }
}

/// Something in the notation of the command line is no such thing.
pub fn unreadable(what: &str, message: impl ToString) -> PyErr {
    raised(Refusal::input(format!("--{what}: {}", message.to_string())))
}

/// The exception that a refusal is.
pub fn raised(refusal: Refusal) -> PyErr {
    Python::attach(|py| match exception(py, refusal.told(&notation)) {
        Ok(error) | Err(error) => error,
    })
}

fn exception(py: Python<'_>, refusal: Refusal) -> PyResult<PyErr> {
    let module = py.import("chatter._errors")?;
    let made = |name: &str, message: String, help: Option<String>| {
        let error = module.getattr(name)?.call1((message, help))?;
        Ok(PyErr::from_value(error))
    };
    match refusal {
        Refusal::Model(errors) => {
            let text = errors.render(Palette::Plain);
            model_error(&module, text, errors.errors())
        }
        Refusal::ModelPart(error) => {
            let text = error.render(Palette::Plain);
            model_error(&module, text, std::slice::from_ref(&*error))
        }
        Refusal::Input { message, help } => made("InputError", message, help),
        Refusal::Unfinished { message, help } => made("UnfinishedError", message, help),
        Refusal::Output(message) => made("OutputError", message, None),
        Refusal::Interrupted => Ok(PyKeyboardInterrupt::new_err(())),
    }
}

fn model_error(
    module: &Bound<'_, PyModule>,
    text: String,
    errors: &[ModelError],
) -> PyResult<PyErr> {
    let py = module.py();
    let issue = module.getattr("ModelIssue")?;
    let issues: PyResult<Vec<_>> = errors
        .iter()
        .map(|error| {
            let (line, column) = error.line_and_column();
            let fields = PyDict::new(py);
            fields.set_item("line", line)?;
            fields.set_item("column", column)?;
            fields.set_item("source", error.source_name())?;
            fields.set_item("message", error.kind().to_string())?;
            fields.set_item("text", error.render(Palette::Plain))?;
            issue.call((), Some(&fields))
        })
        .collect();
    let error = module.getattr("ModelError")?.call1((text, issues?))?;
    Ok(PyErr::from_value(error))
}
