//! Arrays and names of Python as the core reads them, and work without the interpreter.

use crate::error::Error;
use crate::start::Body;
use crate::trajectory::Record;
use numpy::{PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// The rows of a C-contiguous (n, N) array.
pub fn rows<'a, const N: usize>(
    argument: &'static str,
    array: &'a PyReadonlyArray2<'_, f64>,
) -> PyResult<&'a [[f64; N]]> {
    let shape = array.shape();
    let usable = shape[1] == N && array.is_c_contiguous();
    let slice = array.as_slice().ok().filter(|_| usable).ok_or_else(|| Error::Shape {
        argument,
        expected: format!("(n, {N}), C-contiguous"),
        got: format!("({}, {})", shape[0], shape[1]),
    })?;
    Ok(slice.as_chunks::<N>().0)
}

/// Raises an error for a list that is not as long as the bodies or pixels.
pub fn same_length(argument: &'static str, expected: usize, got: usize) -> PyResult<()> {
    if expected == got {
        return Ok(());
    }
    Err(Error::Shape { argument, expected: format!("({expected}, ...)"), got: format!("({got}, ...)") }
        .into())
}

pub fn parse_record(record: &str) -> Result<Record, Error> {
    match record {
        "rates" => Ok(Record::Rates),
        "axis" => Ok(Record::Axis),
        "attitude" => Ok(Record::Attitude),
        _ => Err(Error::Unknown {
            argument: "record",
            value: record.into(),
            known: "rates, axis, attitude".into(),
        }),
    }
}

/// Runs `work` without the lock of the interpreter, which meanwhile handles signals; `None` if it was stopped.
///
/// Stops when a signal handler raises (then the function raises too) or when `interrupted()` returns true.
pub fn interruptible<T: Send>(
    py: Python<'_>,
    interrupted: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&AtomicBool) -> Option<T> + Send,
) -> PyResult<Option<T>> {
    let stop = &AtomicBool::new(false);
    std::thread::scope(|scope| {
        let (sender, receiver) = channel();
        scope.spawn(move || sender.send(work(stop)));
        let receiver = Mutex::new(receiver);
        let wait = || receiver.lock().expect("only locked here").recv_timeout(Duration::from_millis(50));
        loop {
            match py.detach(wait) {
                Ok(result) => return Ok(result),
                Err(RecvTimeoutError::Disconnected) => return Ok(None),
                Err(RecvTimeoutError::Timeout) => {
                    let asked = py.check_signals().and_then(|()| match interrupted {
                        Some(interrupted) => interrupted.call0()?.is_truthy(),
                        None => Ok(false),
                    });
                    if !matches!(asked, Ok(false)) {
                        stop.store(true, Ordering::Relaxed);
                    }
                    asked?;
                }
            }
        }
    })
}

/// The exception of a stopped request that has no partial result.
pub fn stopped() -> PyErr {
    PyRuntimeError::new_err("interrupted")
}

/// The bodies of columns with a row for each, or one row for all.
pub fn bodies(
    moments: &[[f64; 3]],
    weight: &[[f64; 3]],
    omega: &[[f64; 3]],
    attitude: &[[f64; 4]],
) -> PyResult<Vec<Body>> {
    let n = omega.len();
    for (argument, rows) in
        [("moments", moments.len()), ("weight", weight.len()), ("attitude", attitude.len())]
    {
        if rows != 1 {
            same_length(argument, n, rows)?;
        }
    }
    let row = |i: usize, rows: usize| if rows == 1 { 0 } else { i };
    let body = |i: usize| Body {
        moments: moments[row(i, moments.len())],
        weight: weight[row(i, weight.len())],
        omega: omega[i],
        attitude: attitude[row(i, attitude.len())],
    };
    Ok((0..n).map(body).collect())
}
