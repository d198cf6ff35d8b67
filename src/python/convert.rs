//! Arrays and names of Python as the core reads them, and work without the interpreter.

use crate::error::Error;
use crate::float_environment::FloatEnvironment;
use crate::forces::ParameterChange;
use crate::memory;
use crate::parallel::{Interrupt, caught};
use crate::start::Body;
use crate::trajectory::Record;
use numpy::{
    Element, IntoPyArray, PyArray1, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArrayDyn,
    PyUntypedArrayMethods,
};
use pyo3::prelude::*;
use std::ops::Range;
use std::sync::Mutex;

/// The rows of a C-contiguous (n, N) array.
pub fn rows<'a, const N: usize>(
    argument: &'static str,
    array: &'a PyReadonlyArray2<'_, f64>,
) -> PyResult<&'a [[f64; N]]> {
    rows_of(argument, array)
}

/// The rows of an array of any numbers.
pub fn rows_of<'a, T: Element, const N: usize>(
    argument: &'static str,
    array: &'a PyReadonlyArray2<'_, T>,
) -> PyResult<&'a [[T; N]]> {
    let shape = array.shape();
    let usable = shape[1] == N && array.is_c_contiguous();
    let slice = array.as_slice().ok().filter(|_| usable).ok_or_else(|| Error::Shape {
        argument,
        expected: format!("(n, {N}), C-contiguous"),
        got: format!("({}, {})", shape[0], shape[1]),
    })?;
    Ok(slice.as_chunks::<N>().0)
}

/// A copy of the rows of an array, and the length of a row.
pub fn copied_rows(what: &str, array: &PyReadonlyArray2<'_, f64>) -> Result<(Vec<f64>, usize), Error> {
    let array = array.as_array();
    Ok((memory::collected(what, array.len(), array.iter().copied())?, array.ncols()))
}

/// A copy of a column.
pub fn copied(what: &str, array: &PyReadonlyArray1<'_, f64>) -> Result<Vec<f64>, Error> {
    let array = array.as_array();
    memory::collected(what, array.len(), array.iter().copied())
}

/// Raises an error for a list that is not as long as the bodies or pixels.
pub fn same_length(argument: &'static str, expected: usize, got: usize) -> PyResult<()> {
    if expected == got {
        return Ok(());
    }
    Err(Error::Shape { argument, expected: format!("({expected}, ...)"), got: format!("({got}, ...)") }
        .into())
}

pub fn parse_record<'a>(
    record: &str,
    deviations: &'a [[f64; 6]],
    changes: &'a [ParameterChange<f64>],
) -> Result<Record<'a>, Error> {
    match record {
        "rates" => Ok(Record::Rates),
        "axis" => Ok(Record::Axis),
        "attitude" => Ok(Record::Attitude),
        "tangent" => Ok(Record::Tangent(deviations)),
        "sensitivity" => Ok(Record::Sensitivity(changes)),
        _ => Err(Error::Unknown {
            argument: "record",
            value: record.into(),
            known: "rates, axis, attitude, tangent, sensitivity".into(),
        }),
    }
}

/// Values computed between two looks at the clock.
const BETWEEN_CLOCKS: usize = 64;

/// Runs `work` in the calling thread without the lock of the interpreter; a panic becomes an error. To start a thread
/// would take longer than a short run.
///
/// Twenty times a second the calling thread lets the interpreter handle signals. The work stops when a signal handler
/// raises (then the function raises too) or when `interrupted()` returns true.
pub fn interruptible<T: Send>(
    py: Python<'_>,
    interrupted: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Interrupt) -> Result<T, Error> + Send,
) -> PyResult<Result<T, Error>> {
    let interrupted = interrupted.map(|interrupted| interrupted.clone().unbind());
    let raised = Mutex::new(None);
    let ask = || {
        let asked = Python::attach(|py| {
            py.check_signals().and_then(|()| match &interrupted {
                Some(interrupted) => interrupted.bind(py).call0()?.is_truthy(),
                None => Ok(false),
            })
        });
        asked.unwrap_or_else(|error| {
            raised.lock().expect("nothing panics here").get_or_insert(error);
            true
        })
    };
    memory::grow_stack()?;
    let result = py.detach(|| caught(|| work(&Interrupt::when(&ask))));
    raised.into_inner().expect("nothing panics there").map_or(Ok(result), Err)
}

/// The values of 0 .. `length`, computed without the lock of the interpreter, which meanwhile handles signals.
pub fn evaluated<T: Send>(
    py: Python<'_>,
    what: &str,
    length: usize,
    value: impl Fn(usize) -> Result<T, Error> + Sync,
) -> PyResult<Vec<T>> {
    let values = interruptible(py, None, |stop| {
        let mut values = memory::reserved(what, length)?;
        for index in 0..length {
            if index % BETWEEN_CLOCKS == 0 && stop.is_wanted() {
                return Err(Error::Stopped);
            }
            values.push(value(index)?);
        }
        Ok(values)
    })?;
    Ok(values?)
}

/// An array of one number of each value.
pub fn column<'py, T, N: numpy::Element>(
    py: Python<'py>,
    values: &[T],
    of: impl Fn(&T) -> N,
) -> PyResult<Bound<'py, PyArray1<N>>> {
    let column = memory::collected("an array of the result", values.len(), values.iter().map(of))?;
    Ok(column.into_pyarray(py))
}

/// Columns of bodies: a row for each body, or one row for all.
pub struct BodyColumns<'a> {
    moments: &'a [[f64; 3]],
    weight: &'a [[f64; 3]],
    omega: &'a [[f64; 3]],
    attitude: &'a [[f64; 4]],
}

/// Bodies of a part for each thread: few enough for the caches of the processor.
const PART: usize = 1 << 14;

impl<'a> BodyColumns<'a> {
    /// The columns of the arrays of a request.
    pub fn of_arrays(
        moments: &'a PyReadonlyArray2<'_, f64>,
        weight: &'a PyReadonlyArray2<'_, f64>,
        omega: &'a PyReadonlyArray2<'_, f64>,
        attitude: &'a PyReadonlyArray2<'_, f64>,
    ) -> PyResult<Self> {
        BodyColumns::new(
            rows::<3>("moments", moments)?,
            rows::<3>("weight", weight)?,
            rows::<3>("omega", omega)?,
            rows::<4>("attitude", attitude)?,
        )
    }

    /// Columns of equal length, or of one row.
    pub fn new(
        moments: &'a [[f64; 3]],
        weight: &'a [[f64; 3]],
        omega: &'a [[f64; 3]],
        attitude: &'a [[f64; 4]],
    ) -> PyResult<Self> {
        let columns = BodyColumns { moments, weight, omega, attitude };
        let n = columns.len();
        for (argument, rows) in [
            ("moments", columns.moments.len()),
            ("weight", columns.weight.len()),
            ("attitude", columns.attitude.len()),
        ] {
            if rows != 1 {
                same_length(argument, n, rows)?;
            }
        }
        Ok(columns)
    }

    /// Number of bodies.
    pub fn len(&self) -> usize {
        self.omega.len()
    }

    /// All bodies in the parts that are in memory at once, besides the columns; one empty part if there are none.
    pub fn parts(&self, threads: usize) -> impl Iterator<Item = Range<usize>> + use<> {
        let (n, part) = (self.len(), PART.saturating_mul(threads.max(1)));
        (0..n.max(1)).step_by(part).map(move |begin| begin..n.min(begin.saturating_add(part)))
    }

    /// Copies of some bodies: without the lock other threads may write to the arrays.
    pub fn bodies(&self, part: Range<usize>) -> Result<Vec<Body>, Error> {
        memory::collected("bodies", part.len(), part.map(|index| self.body(index)))
    }

    /// One body.
    #[inline]
    pub fn body(&self, index: usize) -> Body {
        let row = |rows: usize| if rows == 1 { 0 } else { index };
        Body {
            moments: self.moments[row(self.moments.len())],
            weight: self.weight[row(self.weight.len())],
            omega: self.omega[index],
            attitude: self.attitude[row(self.attitude.len())],
        }
    }
}

/// All bodies of columns.
pub fn bodies(
    moments: &[[f64; 3]],
    weight: &[[f64; 3]],
    omega: &[[f64; 3]],
    attitude: &[[f64; 4]],
) -> PyResult<Vec<Body>> {
    let columns = BodyColumns::new(moments, weight, omega, attitude)?;
    Ok(columns.bodies(0..columns.len())?)
}

/// All bodies of the arrays of a request.
pub fn bodies_of(
    moments: &PyReadonlyArray2<'_, f64>,
    weight: &PyReadonlyArray2<'_, f64>,
    omega: &PyReadonlyArray2<'_, f64>,
    attitude: &PyReadonlyArray2<'_, f64>,
) -> PyResult<Vec<Body>> {
    let columns = BodyColumns::of_arrays(moments, weight, omega, attitude)?;
    Ok(columns.bodies(0..columns.len())?)
}

/// Flat index of the first element that is not finite.
#[pyfunction]
pub fn first_not_finite(array: PyReadonlyArrayDyn<'_, f64>) -> PyResult<Option<usize>> {
    Ok(array.as_slice()?.iter().position(|x| !x.is_finite()))
}

/// The first body whose fastest rate, the largest component of `omega` or `swing`, is below `least` but not zero.
#[pyfunction]
pub fn first_slow(omega: PyReadonlyArray2<'_, f64>, swing: f64, least: f64) -> PyResult<Option<usize>> {
    let _standard = FloatEnvironment::standard();
    let fastest = |omega: &[f64; 3]| omega.iter().fold(swing, |rate, x| rate.max(x.abs()));
    let is_slow = |omega: &[f64; 3]| fastest(omega) > 0.0 && fastest(omega) < least;
    Ok(rows::<3>("omega", &omega)?.iter().position(is_slow))
}
