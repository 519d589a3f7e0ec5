//! The compiled part of the Python package `chatter`: what is asked comes as text in the notation of the command line, what
//! is answered goes as arrays. Everything that a Python user sees is made of it in `python/chatter`.

mod arrays;
mod asked;
mod border;
mod branches;
mod diagram;
mod errors;
mod explorer;
mod exponents;
mod interruptible;
mod model;
mod periodic;
mod run;
mod universal;

use pyo3::prelude::*;

/// The compiled part of `chatter`.
#[pymodule]
fn _chatter(module: &Bound<'_, PyModule>) -> PyResult<()> {
    chatter_work::backend::choose().map_err(errors::raised)?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    let kinds = chatter::analysis::simulate::EventKind::ALL.map(|kind| kind.name());
    module.add("EVENT_KINDS", kinds)?;
    module.add_class::<model::Core>()?;
    module.add_class::<universal::Upsilon>()?;
    module.add_function(wrap_pyfunction!(model::shipped, module)?)?;
    module.add_function(wrap_pyfunction!(run::simulate, module)?)?;
    module.add_function(wrap_pyfunction!(diagram::diagram, module)?)?;
    module.add_function(wrap_pyfunction!(diagram::resume, module)?)?;
    module.add_function(wrap_pyfunction!(diagram::merge, module)?)?;
    module.add_function(wrap_pyfunction!(border::border, module)?)?;
    module.add_function(wrap_pyfunction!(periodic::orbit, module)?)?;
    module.add_function(wrap_pyfunction!(branches::branches, module)?)?;
    module.add_function(wrap_pyfunction!(branches::resume_branches, module)?)?;
    module.add_function(wrap_pyfunction!(branches::merge_branches, module)?)?;
    module.add_function(wrap_pyfunction!(branches::of_branches, module)?)?;
    module.add_function(wrap_pyfunction!(periodic::curve, module)?)?;
    module.add_function(wrap_pyfunction!(exponents::exponents, module)?)?;
    module.add_class::<explorer::Question>()?;
    module.add_function(wrap_pyfunction!(explorer::explorer_page, module)?)?;
    module.add_function(wrap_pyfunction!(explorer::explorer_answer, module)?)?;
    module.add_function(wrap_pyfunction!(main, module)?)?;
    Ok(())
}

/// Does what the `chatter` command does; gives its exit code.
#[pyfunction]
fn main(py: Python<'_>, arguments: Vec<std::ffi::OsString>) -> u8 {
    py.detach(|| chatter_cli::run(arguments))
}
