//! Arrays and names of Python as the core reads them, and work without the interpreter.

use crate::error::Error;
use crate::memory;
use crate::parallel::caught;
use crate::start::Body;
use crate::trajectory::Record;
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

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

/// How often signals are handled: Ctrl-C is heard at once.
const BETWEEN_SIGNALS: Duration = Duration::from_millis(50);

/// Elements between two looks at the clock.
const BETWEEN_CLOCKS: usize = 64;

/// Runs `work` without the lock of the interpreter, which meanwhile handles signals; a panic becomes an error.
///
/// Stops when a signal handler raises (then the function raises too) or when `interrupted()` returns true.
pub fn interruptible<T: Send>(
    py: Python<'_>,
    interrupted: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&AtomicBool) -> Result<T, Error> + Send,
) -> PyResult<Result<T, Error>> {
    let stop = &AtomicBool::new(false);
    let work = Mutex::new(Some(work));
    let run = &|| caught(|| work.lock().expect("only locked here").take().expect("run once")(stop));
    std::thread::scope(|scope| {
        let (sender, receiver) = channel();
        let send = move || sender.send(run());
        if std::thread::Builder::new().spawn_scoped(scope, send).is_err() {
            // Without another thread no signal is handled until the end.
            return Ok(py.detach(run));
        }
        let receiver = Mutex::new(receiver);
        let wait = || receiver.lock().expect("only locked here").recv_timeout(BETWEEN_SIGNALS);
        loop {
            match py.detach(wait) {
                Ok(result) => return Ok(result),
                Err(RecvTimeoutError::Disconnected) => return Ok(Err(Error::Stopped)),
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

/// The values of 0 .. `length`, computed without the lock of the interpreter, which meanwhile handles signals.
///
/// By the calling thread, unlike `interruptible`: to start a thread would take longer than a single value.
pub fn evaluated<T: Send>(
    py: Python<'_>,
    what: &str,
    length: usize,
    value: impl Fn(usize) -> Result<T, Error> + Sync,
) -> PyResult<Vec<T>> {
    let mut values = memory::reserved(what, length)?;
    while values.len() < length {
        let some = || {
            let begun = Instant::now();
            while values.len() < length && begun.elapsed() < BETWEEN_SIGNALS {
                for index in values.len()..length.min(values.len() + BETWEEN_CLOCKS) {
                    values.push(value(index)?);
                }
            }
            Ok(())
        };
        py.detach(|| caught(some))?;
        py.check_signals()?;
    }
    Ok(values)
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
    Ok(memory::collected("bodies", n, (0..n).map(body))?)
}
