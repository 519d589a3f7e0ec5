//! A model, immutable.

use crate::arrays::floats;
use crate::errors::raised;
use chatter::model::Model;
use chatter_work::Refusal;
use chatter_work::data_files::DataFiles;
use chatter_work::drawing::drawn;
use chatter_work::options::Assignment;
use chatter_work::source::{Loaded, Source, set_initial, set_parameters};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Arc;

/// Names and expressions, in order.
type Pairs = Vec<(String, String)>;

/// All that a model is made of again.
type State = (String, String, DataFiles, Pairs, Pairs);

/// A shape that is drawn: its kind, its numbers, and x and y of its outline and of its hatches.
type Shape<'py> = (&'static str, Vec<f64>, [Bound<'py, PyAny>; 4]);

/// A model with what was set into it.
#[pyclass(frozen, module = "chatter._chatter")]
pub struct Core {
    /// What it is called.
    #[pyo3(get)]
    pub name: String,
    /// The text of its file.
    #[pyo3(get)]
    pub text: String,
    /// The files that its tables stand in.
    #[pyo3(get)]
    pub data_files: DataFiles,
    /// Parameters set.
    #[pyo3(get)]
    pub set: Pairs,
    /// Initial values set.
    #[pyo3(get)]
    pub initial: Pairs,
    /// The model, with all of that.
    pub model: Arc<Model>,
}

impl Core {
    fn load(source: Source, set: Pairs, initial: Pairs) -> Result<Self, Refusal> {
        let name = source.name.clone();
        let Loaded {
            mut model,
            text,
            data_files,
        } = source.load()?;
        set_parameters(&mut model, &assignments(&set))?;
        set_initial(&mut model, &assignments(&initial))?;
        Ok(Self {
            name,
            text,
            data_files,
            set,
            initial,
            model: Arc::new(model),
        })
    }

    /// Where it comes from.
    pub fn source(&self) -> Source {
        Source::kept(&self.name, &self.text, self.data_files.clone())
    }

    /// Which of these names are states, and the start of time.
    fn is_initial(&self, name: &str) -> bool {
        let parameter = self.model.parameter_index(name).is_some();
        !parameter && (self.model.state_index(name).is_some() || name == "t")
    }
}

/// As options have them.
pub fn assignments(pairs: &[(String, String)]) -> Vec<Assignment> {
    let one = |(name, text): &(String, String)| Assignment::new(name, text);
    pairs.iter().map(one).collect()
}

/// What was set before, with these in place of those of their names.
fn replaced(before: &Pairs, with: Pairs) -> Pairs {
    let mut pairs = before.clone();
    for (name, text) in with {
        pairs.retain(|(known, _)| *known != name);
        pairs.push((name, text));
    }
    pairs
}

#[pymethods]
impl Core {
    /// A shipped model.
    #[staticmethod]
    fn shipped(name: &str) -> PyResult<Self> {
        let loaded = Source::shipped(name).and_then(|source| Self::load(source, vec![], vec![]));
        loaded.map_err(raised)
    }

    /// A model file.
    #[staticmethod]
    fn from_file(path: &str) -> PyResult<Self> {
        let loaded = Source::file(path).and_then(|source| Self::load(source, vec![], vec![]));
        loaded.map_err(raised)
    }

    /// A text.
    #[staticmethod]
    fn from_text(text: &str, name: &str) -> PyResult<Self> {
        Self::load(Source::text(name, text), vec![], vec![]).map_err(raised)
    }

    /// With other values of parameters, or of states at the start.
    fn with_values(&self, values: Pairs) -> PyResult<Self> {
        let (initial, set) = (values.into_iter()).partition(|(name, _)| self.is_initial(name));
        let (set, initial) = (replaced(&self.set, set), replaced(&self.initial, initial));
        Self::load(self.source(), set, initial).map_err(raised)
    }

    /// What it is made of again.
    fn __getstate__(&self) -> State {
        (
            self.name.clone(),
            self.text.clone(),
            self.data_files.clone(),
            self.set.clone(),
            self.initial.clone(),
        )
    }

    /// Made again.
    #[staticmethod]
    fn restore(state: State) -> PyResult<Self> {
        let (name, text, data_files, set, initial) = state;
        Self::load(Source::kept(&name, &text, data_files), set, initial).map_err(raised)
    }

    /// Its title.
    #[getter]
    fn title(&self) -> Option<&str> {
        self.model.title.as_deref()
    }

    /// Names of the states but time.
    #[getter]
    fn states(&self) -> Vec<String> {
        let states = self.model.states.iter().enumerate();
        let proper = states.filter(|&(index, _)| Some(index) != self.model.time);
        proper.map(|(_, state)| state.name.clone()).collect()
    }

    /// Values of the parameters.
    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        let values = self.model.parameter_values::<f64>(&[]);
        for (name, value) in self.model.parameter_names().into_iter().zip(values) {
            dict.set_item(name, value)?;
        }
        Ok(dict)
    }

    /// States at the start; time among them where the equations depend on it.
    #[getter]
    fn start<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        let parameters = self.model.parameter_values::<f64>(&[]);
        let values = self.model.initial_state(&parameters);
        for (state, value) in self.model.states.iter().zip(values) {
            dict.set_item(&state.name, value)?;
        }
        Ok(dict)
    }

    /// Whether the equations depend on time.
    #[getter]
    fn depends_on_time(&self) -> bool {
        self.model.time.is_some()
    }

    /// Names of the contacts.
    #[getter]
    fn contacts(&self) -> Vec<String> {
        let contacts = self.model.contacts.iter();
        contacts.map(|contact| contact.name.clone()).collect()
    }

    /// Names of the sections.
    #[getter]
    fn sections(&self) -> Vec<String> {
        let sections = self.model.sections.iter();
        sections.map(|section| section.name.clone()).collect()
    }

    /// What figures call states and parameters: text and unit, where the model says so.
    #[getter]
    fn labels(&self) -> Vec<(String, Option<String>, Option<String>)> {
        let parameters = self.model.parameters.iter();
        let parameters = parameters.map(|one| (&one.name, &one.label));
        let states = self.model.states.iter().map(|one| (&one.name, &one.label));
        (parameters.chain(states))
            .filter_map(|(name, label)| {
                let label = label.as_ref()?;
                Some((name.clone(), label.text.clone(), label.unit.clone()))
            })
            .collect()
    }

    /// The mechanism at values of the states, in the order of `states`, and a time: for each shape of the drawing what it is,
    /// its numbers, and the lines that it is drawn with, its outline and its hatches, each as x and y.
    fn drawn<'py>(&self, py: Python<'py>, state: Vec<f64>, time: f64) -> Vec<Shape<'py>> {
        let mut values = state.into_iter();
        let states = 0..self.model.states.len();
        let state: Vec<f64> = states
            .map(|index| match Some(index) == self.model.time {
                true => time,
                false => values.next().unwrap_or(f64::NAN),
            })
            .collect();
        let shapes = drawn(&self.model, &state, time).into_iter();
        shapes
            .map(|shape| {
                let ((x, y), (hatch_x, hatch_y)) = (shape.outline, shape.hatches);
                let lines = [x, y, hatch_x, hatch_y].map(|values| floats(py, values));
                (shape.kind.name(), shape.numbers, lines)
            })
            .collect()
    }

    /// What looks wrong with it, one sentence each.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        let found = chatter::model::check(&self.model).warnings;
        found.iter().map(ToString::to_string).collect()
    }
}

/// Names and titles of the shipped models.
#[pyfunction]
pub fn shipped() -> Vec<(&'static str, &'static str)> {
    let all = chatter_work::shipped::all();
    all.map(|model| (model.name, model.text)).collect()
}
