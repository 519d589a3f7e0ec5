//! The universal function.

use crate::arrays::floats;
use crate::errors::raised;
use chatter::analysis::universal::{Universal, UniversalError};
use chatter_work::Refusal;
use numpy::{PyReadonlyArray1, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Upsilon for one restitution.
#[pyclass(frozen, module = "chatter._chatter")]
pub struct Upsilon(Universal<f64>);

fn refused(error: UniversalError) -> PyErr {
    raised(Refusal::input(error))
}

#[pymethods]
impl Upsilon {
    #[new]
    fn new(restitution: f64) -> PyResult<Self> {
        Universal::new(restitution).map(Self).map_err(refused)
    }

    /// Values at these places.
    fn values<'py>(
        &self,
        py: Python<'py>,
        x: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let x: Vec<f64> = x.as_array().iter().copied().collect();
        let values = py.detach(|| x.iter().map(|&x| self.0.value(x)).collect());
        Ok(floats(py, values))
    }

    /// Values, derivatives, laps and last impacts but one at these places.
    fn evaluations<'py>(
        &self,
        py: Python<'py>,
        x: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let count = x.len();
        let x: Vec<f64> = x.as_array().iter().copied().collect();
        let mut columns = [(); 4].map(|()| Vec::with_capacity(count));
        py.detach(|| {
            for x in x {
                let one = self.0.at(x);
                let all = [one.value, one.derivative, one.lap, one.u1];
                columns
                    .iter_mut()
                    .zip(all)
                    .for_each(|(to, value)| to.push(value));
            }
        });
        let dict = PyDict::new(py);
        for (name, values) in ["value", "derivative", "lap", "u1"]
            .into_iter()
            .zip(columns)
        {
            dict.set_item(name, floats(py, values))?;
        }
        Ok(dict)
    }

    /// The end of the lap with n = 0.
    #[getter]
    fn lap_end(&self) -> f64 {
        self.0.lap_end()
    }

    /// The constants that follow from the restitution.
    #[getter]
    fn constants<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let constants = self.0.constants();
        let dict = PyDict::new(py);
        let named = [
            ("restitution", constants.restitution),
            ("chatter_fixed_point", constants.chatter_fixed_point),
            ("lambda", constants.lambda),
            ("eta", constants.eta),
            ("exponent", constants.exponent),
        ];
        for (name, value) in named {
            dict.set_item(name, value)?;
        }
        Ok(dict)
    }

    /// Windows of the fixed points of z -> Upsilon(K z + mu): n, fold, period doubling, superstable point and graze, NaN
    /// where there is none.
    fn windows<'py>(
        &self,
        py: Python<'py>,
        slope: f64,
        first: i64,
        last: i64,
    ) -> PyResult<Bound<'py, PyDict>> {
        let laps = chatter_work::options::Counts { first, last };
        let found =
            chatter_work::universal::Window::list(&self.0, (slope, None), laps).map_err(refused)?;
        let dict = PyDict::new(py);
        let column = |of: fn(&chatter_work::universal::Window<f64>) -> Option<f64>| {
            let values = found.iter().map(|window| of(window).unwrap_or(f64::NAN));
            floats(py, values.collect())
        };
        dict.set_item(
            "n",
            found.iter().map(|window| window.n).collect::<Vec<i64>>(),
        )?;
        dict.set_item("fold", column(|window| window.fold))?;
        dict.set_item("period_doubling", column(|window| window.period_doubling))?;
        dict.set_item("superstable", column(|window| window.superstable))?;
        dict.set_item("grazing", column(|window| window.grazing))?;
        Ok(dict)
    }
}
