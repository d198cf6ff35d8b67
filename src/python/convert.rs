//! Arrays and names of Python as the core reads them, and work without the interpreter.

use super::unraisable::{carrying, has_raised};
use crate::body::Body;
use crate::error::Error;
use crate::float_environment::FloatEnvironment;
use crate::forces::ParameterChange;
use crate::memory;
use crate::parallel::{Interrupt, caught, in_another_thread, owned};
use crate::trajectory::{Record, Schedule};
use numpy::ndarray::{Dimension, Ix1, Ix2, IxDyn};
use numpy::npyffi::NPY_ARRAY_WRITEABLE;
use numpy::{
    Element, IntoPyArray, PyArray, PyArray1, PyArray2, PyArrayDyn, PyArrayMethods, PyReadonlyArray,
    PyUntypedArrayMethods,
};
use pyo3::prelude::*;
use pyo3::types::{PyFloat, PyInt, PyList, PyTuple};
use std::cell::RefCell;
use std::ops::{Deref, Range};
use std::sync::Mutex;

/// An array to be read: that of the caller, or a copy of it where its numbers are not aligned. A reference to a number
/// that is not aligned is undefined behaviour.
pub struct Aligned<'py, T: Element, D: Dimension>(PyReadonlyArray<'py, T, D>);

/// A column.
pub type Aligned1<'py, T> = Aligned<'py, T, Ix1>;
/// A matrix.
pub type Aligned2<'py, T> = Aligned<'py, T, Ix2>;

impl<'py, T: Element, D: Dimension> Deref for Aligned<'py, T, D> {
    type Target = PyReadonlyArray<'py, T, D>;

    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl<'a, 'py, T: Element + 'a, D: Dimension + 'a> FromPyObject<'a, 'py> for Aligned<'py, T, D> {
    type Error = PyErr;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        let array: PyReadonlyArray<'py, T, D> = object.extract()?;
        Ok(Aligned(if array.is_aligned() { array } else { copy(&array)?.try_readonly()? }))
    }
}

/// An aligned copy of an array.
fn copy<'py, T: Element, D: Dimension>(
    array: &Bound<'py, PyArray<T, D>>,
) -> PyResult<Bound<'py, PyArray<T, D>>> {
    Ok(array.call_method0("copy")?.cast_into()?)
}

/// The rows of a C-contiguous (n, N) array.
pub fn rows<'a, const N: usize>(
    argument: &'static str,
    array: &'a Aligned2<'_, f64>,
) -> PyResult<&'a [[f64; N]]> {
    rows_of(argument, array)
}

/// The rows of an array of any numbers.
pub fn rows_of<'a, T: Element, const N: usize>(
    argument: &'static str,
    array: &'a Aligned2<'_, T>,
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

/// What is read from the rows of a C-contiguous (n, N) array, before the lock of the interpreter is given up: to register
/// each array as borrowed would take as long as to read the columns of a small call.
pub fn of_rows<const N: usize, T>(
    argument: &'static str,
    array: &Bound<'_, PyArray2<f64>>,
    read: impl FnOnce(&[[f64; N]]) -> PyResult<T>,
) -> PyResult<T> {
    if !array.is_aligned() {
        return of_rows(argument, &copy(array)?, read);
    }
    let shape = array.shape();
    if shape[1] != N || !array.is_c_contiguous() {
        let (expected, got) = (format!("(n, {N}), C-contiguous"), format!("({}, {})", shape[0], shape[1]));
        return Err(Error::Shape { argument, expected, got }.into());
    }
    // SAFETY: the array is contiguous, and no code of Python runs while it is read: `read` has no token of the interpreter.
    read(unsafe { array.as_slice() }?.as_chunks::<N>().0)
}

/// A copy of all numbers of an array, in the order of C.
pub fn copied_numbers(what: &str, array: &Bound<'_, PyArrayDyn<f64>>) -> PyResult<Vec<f64>> {
    if !array.is_aligned() {
        return copied_numbers(what, &copy(array)?);
    }
    // SAFETY: the array is aligned, and no code of Python runs while it is read.
    let array = unsafe { array.as_array() };
    Ok(memory::collected(what, array.len(), array.iter().copied())?)
}

/// A copy of the rows of an array, and the length of a row.
pub fn copied_rows(what: &str, array: &Aligned2<'_, f64>) -> Result<(Vec<f64>, usize), Error> {
    let array = array.as_array();
    Ok((memory::collected(what, array.len(), array.iter().copied())?, array.ncols()))
}

/// A copy of a column.
pub fn copied(what: &str, array: &Aligned1<'_, f64>) -> Result<Vec<f64>, Error> {
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

/// The output times of bodies: the numbers of an array of this shape, (m,) or (n, m).
pub fn times_of_bodies<'a>(times: &'a [f64], shape: &[usize], bodies: usize) -> PyResult<Schedule<'a>> {
    match shape {
        [_] => Ok(Schedule::Times(times)),
        [rows, count] => {
            same_length("t", bodies, *rows)?;
            Ok(Schedule::TimesOfEach(times, *count))
        }
        shape => {
            let (expected, got) = ("(m,) or (n, m)".into(), format!("{shape:?}"));
            Err(Error::Shape { argument: "t", expected, got }.into())
        }
    }
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

thread_local! {
    /// Who is told the share of a call that is done.
    static LISTENER: RefCell<Option<Py<PyAny>>> = const { RefCell::new(None) };
}

/// Sets the function of this thread that is told the share of a running call which is done, between 0 and 1; returns the
/// one before.
#[pyfunction]
pub fn listen(listener: Option<Py<PyAny>>) -> Option<Py<PyAny>> {
    LISTENER.with(|known| known.replace(listener))
}

/// Tells the listener of this thread the share that is done.
fn tell(py: Python<'_>, share: f64) -> PyResult<()> {
    let listener = LISTENER.with(|known| known.borrow().as_ref().map(|known| known.clone_ref(py)));
    match listener {
        Some(listener) if share > 0.0 => listener.call1(py, (share,)).map(drop),
        _ => Ok(()),
    }
}

/// Runs `work` in the calling thread without the lock of the interpreter; a panic becomes an error. To start a thread
/// would take longer than a short run.
///
/// Twenty times a second the calling thread lets the interpreter handle signals, and tells who listens what is done. The work stops when a signal handler
/// raises (then the function raises too) or when `interrupted()` returns true.
pub fn interruptible<T: Send>(
    py: Python<'_>,
    interrupted: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Interrupt) -> Result<T, Error> + Send,
) -> PyResult<Result<T, Error>> {
    stoppable(py, interrupted, 0, work)
}

/// The same; work that may call functions of Python is done in another thread, see [`in_another_thread`]. It stops when a function
/// raises, and what the function raised is raised.
pub fn interruptible_calls<T: Send>(
    py: Python<'_>,
    interrupted: Option<&Bound<'_, PyAny>>,
    calls: bool,
    work: impl FnOnce(&Interrupt) -> Result<T, Error> + Send,
) -> PyResult<Result<T, Error>> {
    if !calls {
        return interruptible(py, interrupted, work);
    }
    carrying(py, |call| {
        stoppable(py, interrupted, call, |stop| in_another_thread(stop, || owned(call, || work(stop))))
    })
}

/// Runs the work of the call of that number until a function that it calls has raised, or a signal handler raises.
fn stoppable<T: Send>(
    py: Python<'_>,
    interrupted: Option<&Bound<'_, PyAny>>,
    call: u64,
    work: impl FnOnce(&Interrupt) -> Result<T, Error> + Send,
) -> PyResult<Result<T, Error>> {
    let interrupted = interrupted.map(|interrupted| interrupted.clone().unbind());
    let raised = Mutex::new(None);
    let ask = |share| {
        let asked = Python::attach(|py| {
            py.check_signals().and_then(|()| tell(py, share)).and_then(|()| match &interrupted {
                Some(interrupted) => interrupted.bind(py).call0()?.is_truthy(),
                None => Ok(call != 0 && has_raised(call)),
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

/// Runs `work` of some microseconds with the lock of the interpreter: to give it up and to take it would add to them.
pub fn at_once<T>(work: impl FnOnce(&Interrupt) -> Result<T, Error>) -> Result<T, Error> {
    memory::grow_stack()?;
    caught(|| work(&Interrupt::never()))
}

/// The values of 0 .. `length`, computed without the lock of the interpreter, which meanwhile handles signals; few values
/// at once.
pub fn evaluated<T: Send>(
    py: Python<'_>,
    what: &str,
    length: usize,
    value: impl Fn(usize) -> Result<T, Error> + Sync,
) -> PyResult<Vec<T>> {
    let all = |stop: &Interrupt| {
        let mut values = memory::reserved(what, length)?;
        for index in 0..length {
            if index % BETWEEN_CLOCKS == 0 && stop.is_wanted() {
                return Err(Error::Stopped);
            }
            values.push(value(index)?);
        }
        Ok(values)
    };
    Ok(if length < BETWEEN_CLOCKS { at_once(all) } else { interruptible(py, None, all)? }?)
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

/// One row for all bodies, or one for each.
#[derive(Clone, Copy)]
pub struct OneOrEach<'a, T>(&'a [T]);

impl<'a, T: Copy> OneOrEach<'a, T> {
    /// Rows of so many bodies.
    pub fn new(argument: &'static str, bodies: usize, rows: &'a [T]) -> PyResult<Self> {
        if rows.len() != 1 {
            same_length(argument, bodies, rows.len())?;
        }
        Ok(OneOrEach(rows))
    }

    /// The row of a body.
    #[inline]
    pub fn of(self, body: usize) -> T {
        self.0[if self.0.len() == 1 { 0 } else { body }]
    }
}

/// Columns of bodies.
pub struct BodyColumns<'a> {
    moments: OneOrEach<'a, [f64; 3]>,
    weight: OneOrEach<'a, [f64; 3]>,
    omega: &'a [[f64; 3]],
    attitude: OneOrEach<'a, [f64; 4]>,
}

/// Bodies of a part for each thread: few enough for the caches of the processor.
const PART: usize = 1 << 14;

impl<'a> BodyColumns<'a> {
    /// Columns of equal length, or of one row.
    pub fn new(
        moments: &'a [[f64; 3]],
        weight: &'a [[f64; 3]],
        omega: &'a [[f64; 3]],
        attitude: &'a [[f64; 4]],
    ) -> PyResult<Self> {
        let n = omega.len();
        Ok(BodyColumns {
            moments: OneOrEach::new("moments", n, moments)?,
            weight: OneOrEach::new("weight", n, weight)?,
            omega,
            attitude: OneOrEach::new("attitude", n, attitude)?,
        })
    }

    /// Number of bodies.
    pub fn len(&self) -> usize {
        self.omega.len()
    }

    /// So many bodies in the parts that are in memory at once, besides the columns; one empty part if there are none.
    pub fn parts(n: usize, threads: usize) -> impl Iterator<Item = Range<usize>> {
        let part = PART.saturating_mul(threads.max(1));
        (0..n.max(1)).step_by(part).map(move |begin| begin..n.min(begin.saturating_add(part)))
    }

    /// Copies of some bodies: without the lock other threads may write to the arrays.
    pub fn bodies(&self, part: Range<usize>) -> Result<Vec<Body>, Error> {
        memory::collected("bodies", part.len(), part.map(|index| self.body(index)))
    }

    /// One body.
    #[inline]
    pub fn body(&self, index: usize) -> Body {
        Body {
            moments: self.moments.of(index),
            weight: self.weight.of(index),
            omega: self.omega[index],
            attitude: self.attitude.of(index),
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

/// Numbers in a list of Python that is read here.
const SHORT: usize = 64;

/// The finite floats of an array, which is returned, or of a short list or tuple; None for anything else, for other
/// axes than (..., width), and for numbers that do not ascend along the last axis if they shall. To be kept are those of
/// a list or tuple only: nobody can write to them.
#[pyfunction]
#[pyo3(signature = (value, width=None, ascending=false, kept=false))]
pub fn plain_numbers<'py>(
    value: &Bound<'py, PyAny>,
    width: Option<usize>,
    ascending: bool,
    kept: bool,
) -> PyResult<Option<Bound<'py, PyAny>>> {
    let py = value.py();
    let fits = |numbers: &[f64], last: usize| {
        let ascend = |row: &[f64]| row.is_sorted();
        width.is_none_or(|width| width == last)
            && numbers.iter().all(|x| x.is_finite())
            && (!ascending || last == 0 || numbers.chunks_exact(last).all(ascend))
    };
    if let (false, Ok(array)) = (kept, value.cast_exact::<PyArrayDyn<f64>>()) {
        let is_usable = array.is_aligned() && array.is_c_contiguous();
        let Some(&last) = array.shape().last().filter(|_| is_usable) else {
            return Ok(None);
        };
        // SAFETY: the array is contiguous and aligned, and no code of Python runs while it is read.
        return Ok(fits(unsafe { array.as_slice() }?, last).then(|| value.clone()));
    }
    let (mut numbers, mut length) = ([0.0; SHORT], 0);
    let mut push = |item: Bound<'py, PyAny>| {
        let number = plain_number(&item)?;
        *numbers.get_mut(length)? = number;
        length += 1;
        Some(())
    };
    let read = if let Ok(list) = value.cast_exact::<PyList>() {
        list.iter().try_for_each(&mut push)
    } else if let Ok(tuple) = value.cast_exact::<PyTuple>() {
        tuple.iter().try_for_each(&mut push)
    } else {
        None
    };
    let numbers = &numbers[..length];
    let is_plain = read.is_some() && length > 0 && fits(numbers, length);
    if !is_plain {
        return Ok(None);
    }
    let array = PyArray1::from_slice(py, numbers);
    if kept {
        // SAFETY: nothing else refers to the new array yet.
        unsafe { (*array.as_array_ptr()).fields.flags &= !NPY_ARRAY_WRITEABLE };
    }
    Ok(Some(array.into_any()))
}

/// A float, or a whole number that is one.
fn plain_number(item: &Bound<'_, PyAny>) -> Option<f64> {
    const EXACT: i64 = 1 << 53;
    if let Ok(float) = item.cast::<PyFloat>() {
        return Some(float.value());
    }
    let whole: i64 = item.cast_exact::<PyInt>().ok()?.extract().ok()?;
    (-EXACT..=EXACT).contains(&whole).then_some(whole as f64)
}

/// Flat index of the first element that is not finite.
#[pyfunction]
pub fn first_not_finite(array: Aligned<'_, f64, IxDyn>) -> PyResult<Option<usize>> {
    Ok(array.as_slice()?.iter().position(|x| !x.is_finite()))
}

/// The first body whose fastest rate, the largest component of `omega` or `swing`, is below `least` but not zero.
#[pyfunction]
pub fn first_slow(omega: &Bound<'_, PyArray2<f64>>, swing: f64, least: f64) -> PyResult<Option<usize>> {
    let _standard = FloatEnvironment::standard();
    let fastest = |omega: &[f64; 3]| omega.iter().fold(swing, |rate, x| rate.max(x.abs()));
    let is_slow = |omega: &[f64; 3]| fastest(omega) > 0.0 && fastest(omega) < least;
    of_rows::<3, _>("omega", omega, |omega| Ok(omega.iter().position(is_slow)))
}
