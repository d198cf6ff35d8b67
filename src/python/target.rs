//! Arrays of Python into which the states of a call are written.

use crate::error::Error;
use crate::memory;
use crate::trajectory::{Request, States};
use numpy::{IntoPyArray, PyArray1, PyArray3, PyArrayMethods, PyReadwriteArray3, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::ops::Range;

/// A column of output times, (n, times, width), in an array of Python.
pub struct Target<'py> {
    pub name: &'static str,
    width: usize,
    times: usize,
    array: Array<'py>,
    /// The states of a part, before they are rounded to single precision.
    exact: Vec<f64>,
}

enum Array<'py> {
    Double(PyReadwriteArray3<'py, f64>),
    Single(PyReadwriteArray3<'py, f32>),
}

impl<'py> Target<'py> {
    /// The columns of `n` bodies that are in the arrays of `out`, or in new ones of single precision.
    pub fn all(
        py: Python<'py>,
        request: &Request,
        n: usize,
        out: Option<&Bound<'py, PyDict>>,
        single: bool,
    ) -> PyResult<Vec<Self>> {
        let (times, mut targets) = (request.schedule.len(), Vec::new());
        if out.is_none() && !single {
            return Ok(targets);
        }
        for (name, width) in States::recorded(request) {
            let array = match out.map(|out| out.get_item(name)).transpose()?.flatten() {
                Some(given) => Target::given(&given, [n, times, width], name)?,
                // The work may exceed the range of single precision.
                None if single && width > 1 => Array::Single(new(py, [n, times, width])?.try_readwrite()?),
                None => continue,
            };
            targets.push(Target { name, width, times, array, exact: Vec::new() });
        }
        Ok(targets)
    }

    fn given(array: &Bound<'py, PyAny>, shape: [usize; 3], name: &'static str) -> PyResult<Array<'py>> {
        let wrong = |got: String| {
            let expected = format!("{shape:?} of float64 or float32, C-contiguous and writeable");
            Error::Shape { argument: name, expected, got }
        };
        let fits = |got: &[usize], contiguous: bool| match got == shape && contiguous {
            true => Ok(()),
            false => Err(wrong(format!("{got:?}"))),
        };
        if let Ok(array) = array.cast::<PyArray3<f64>>() {
            fits(array.shape(), array.is_c_contiguous())?;
            return Ok(Array::Double(array.try_readwrite()?));
        }
        if let Ok(array) = array.cast::<PyArray3<f32>>() {
            fits(array.shape(), array.is_c_contiguous())?;
            return Ok(Array::Single(array.try_readwrite()?));
        }
        Err(wrong("another array".into()).into())
    }

    /// Memory for the states of some bodies.
    pub fn part(&mut self, bodies: Range<usize>) -> PyResult<&mut [f64]> {
        let row = self.times * self.width;
        match &mut self.array {
            Array::Double(array) => Ok(&mut array.as_slice_mut()?[bodies.start * row..bodies.end * row]),
            Array::Single(_) => {
                self.exact = memory::zeros("states of some bodies", bodies.len() * row)?;
                Ok(&mut self.exact)
            }
        }
    }

    /// Rounds the states of some bodies, if the array has single precision.
    pub fn finish(&mut self, bodies: Range<usize>) -> PyResult<()> {
        if let Array::Single(array) = &mut self.array {
            let row = self.times * self.width;
            let rounded = &mut array.as_slice_mut()?[bodies.start * row..bodies.end * row];
            for (rounded, exact) in rounded.iter_mut().zip(&self.exact) {
                *rounded = *exact as f32;
            }
        }
        Ok(())
    }

    /// The array; (n, times) if each time has one number.
    pub fn shaped(&self) -> PyResult<Bound<'py, PyAny>> {
        let array = match &self.array {
            Array::Double(array) => array.as_any(),
            Array::Single(array) => array.as_any(),
        };
        match self.width {
            1 => array.call_method1("squeeze", (2,)),
            _ => Ok(array.clone()),
        }
    }
}

/// A new array of single precision.
fn new(py: Python<'_>, shape: [usize; 3]) -> PyResult<Bound<'_, PyArray3<f32>>> {
    let [n, times, width] = shape;
    let length = n.saturating_mul(times).saturating_mul(width);
    let numbers = memory::zeros::<f32>(&format!("states of {n} bodies at {times} times"), length)?;
    let array: Bound<'_, PyArray1<f32>> = numbers.into_pyarray(py);
    array.reshape(shape)
}
