//! The states of a call as a mapping of Python, whose arrays are made when they are first read.

use crate::memory;
use crate::trajectory::Column;
use numpy::ndarray::{Dim, Dimension, IntoDimension};
use numpy::{Element, IntoPyArray, PyArray, PyArray1, PyArrayMethods};
use pyo3::exceptions::PyKeyError;
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyIterator, PyString};
use std::sync::Mutex;

/// Numbers of which a copy takes less time than an array that owns those of the core.
const FEW: usize = 64;

/// Columns by their names: few of those of a small call are read, and arrays take as long as its states.
#[pyclass(frozen, mapping, name = "States", module = "rigid._core")]
pub struct PyStates {
    /// Bodies and output times.
    shape: [usize; 2],
    /// What has been made, and what Python has added.
    made: Py<PyDict>,
    /// Columns that nobody has read yet.
    waiting: Mutex<Vec<(&'static str, Column)>>,
    /// The largest error, if it is known and all bodies have arrived.
    #[pyo3(get)]
    worst: Option<f64>,
}

impl PyStates {
    /// The columns of so many bodies at so many times; those of many are made at once.
    pub fn new(
        py: Python<'_>,
        shape: [usize; 2],
        columns: Vec<(&'static str, Column)>,
        worst: Option<f64>,
    ) -> PyResult<Self> {
        let (made, mut waiting) = (PyDict::new(py), columns);
        if shape[0].saturating_mul(shape[1].max(1)) > FEW {
            for (name, column) in std::mem::take(&mut waiting) {
                made.set_item(name, array_of(py, column, shape)?)?;
            }
        }
        Ok(PyStates { shape, made: made.unbind(), waiting: Mutex::new(waiting), worst })
    }

    /// Adds a value, or writes over one.
    pub fn insert<'py>(&self, name: &Bound<'py, PyString>, value: impl IntoPyObject<'py>) -> PyResult<()> {
        self.made.bind(name.py()).set_item(name, value)?;
        let own = name.to_str()?;
        self.waiting().retain(|(known, _)| *known != own);
        Ok(())
    }

    /// A value, if there is one.
    fn found<'py>(&self, name: &Bound<'py, PyString>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let py = name.py();
        let made = self.made.bind(py);
        if let Some(value) = made.get_item(name)? {
            return Ok(Some(value));
        }
        let own = name.to_str()?;
        // A copy: to make an array may run other code of Python, which may read the same column.
        let column = self.waiting().iter().find(|(known, _)| *known == own).map(|(_, column)| column.clone());
        let Some(column) = column else { return Ok(None) };
        let array = array_of(py, column, self.shape)?;
        self.insert(name, &array)?;
        Ok(Some(array))
    }

    /// Everything.
    fn all<'py>(&self, py: Python<'py>) -> PyResult<&Bound<'py, PyDict>> {
        let names: Vec<_> = self.waiting().iter().map(|(name, _)| *name).collect();
        for name in names {
            self.found(&PyString::new(py, name))?;
        }
        Ok(self.made.bind(py))
    }

    fn waiting(&self) -> std::sync::MutexGuard<'_, Vec<(&'static str, Column)>> {
        self.waiting.lock().expect("nothing panics with the list")
    }
}

#[pymethods]
impl PyStates {
    fn __getitem__<'py>(&self, name: &Bound<'py, PyString>) -> PyResult<Bound<'py, PyAny>> {
        self.found(name)?.ok_or_else(|| PyKeyError::new_err(name.clone().unbind()))
    }

    fn __setitem__(&self, name: &Bound<'_, PyString>, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.insert(name, value)
    }

    fn __delitem__(&self, name: &Bound<'_, PyString>) -> PyResult<()> {
        self.all(name.py())?.del_item(name)
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyIterator>> {
        self.all(py)?.try_iter()
    }

    fn __len__(&self, py: Python<'_>) -> PyResult<usize> {
        Ok(self.all(py)?.len())
    }

    fn __contains__(&self, name: &Bound<'_, PyAny>) -> PyResult<bool> {
        self.all(name.py())?.contains(name)
    }

    /// The errors of the bodies, if they are known.
    #[getter]
    fn error<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.__getitem__(intern!(py, "error"))
    }

    /// The times from which on the bodies are lost, if the errors are known.
    #[getter]
    fn lost_from<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.__getitem__(intern!(py, "lost_from"))
    }

    /// The value of a name, by default None.
    #[pyo3(signature = (name, default=None, /))]
    fn get<'py>(
        &self,
        name: &Bound<'py, PyString>,
        default: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Option<Bound<'py, PyAny>>> {
        Ok(self.found(name)?.or(default))
    }

    /// The other methods of a dict.
    fn __getattr__<'py>(&self, name: &Bound<'py, PyString>) -> PyResult<Bound<'py, PyAny>> {
        self.all(name.py())?.getattr(name)
    }

    /// A dict, if it is copied or pickled.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (Bound<'py, PyDict>,))> {
        Ok((py.get_type::<PyDict>().into_any(), (self.all(py)?.clone(),)))
    }
}

/// A column of so many bodies at so many times as an array; None for what is not recorded.
fn array_of<'py>(py: Python<'py>, column: Column, [n, times]: [usize; 2]) -> PyResult<Bound<'py, PyAny>> {
    Ok(match column {
        Column::Series(_, None) => py.None().into_bound(py),
        Column::Series(1, Some(values)) => shaped(py, values, [n, times])?.into_any(),
        Column::Series(width, Some(values)) => shaped(py, values, [n, times, width])?.into_any(),
        Column::Numbers(values) => of_bodies(py, values).into_any(),
        Column::Counts(values) => of_bodies(py, values).into_any(),
        Column::Statuses(values) => {
            let codes = values.iter().map(|&status| status as u8);
            of_bodies(py, memory::collected("statuses", values.len(), codes)?).into_any()
        }
    })
}

/// An array with a number of each body: of few bodies a copy, which is faster.
pub fn of_bodies<T: Element + Copy>(py: Python<'_>, values: Vec<T>) -> Bound<'_, PyArray1<T>> {
    if values.len() <= FEW { PyArray1::from_slice(py, &values) } else { values.into_pyarray(py) }
}

/// An array of this shape: of few numbers a copy.
pub fn shaped<const N: usize>(
    py: Python<'_>,
    values: Vec<f64>,
    shape: [usize; N],
) -> PyResult<Bound<'_, PyArray<f64, Dim<[usize; N]>>>>
where
    Dim<[usize; N]>: Dimension,
    [usize; N]: IntoDimension<Dim = Dim<[usize; N]>>,
{
    // NumPy may refuse a shape without numbers.
    if values.len() > FEW || values.is_empty() {
        return values.into_pyarray(py).reshape(shape);
    }
    let array = PyArray::zeros(py, shape, false);
    // SAFETY: nothing else refers to a new array.
    unsafe { array.as_slice_mut() }?.copy_from_slice(&values);
    Ok(array)
}
