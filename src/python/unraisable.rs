//! What functions of the user raise. Functions of ctypes and numba cannot raise it in the core, which called them: they
//! hand it to `sys.unraisablehook`, from where the call takes it.

use crate::parallel::owner;
use pyo3::prelude::*;
use pyo3::sync::MutexExt;
use pyo3::types::{PyCFunction, PyDict, PyString, PyTuple};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

/// What was raised first in each call of the core that runs.
static RAISED: Mutex<Vec<(u64, PyErr)>> = Mutex::new(Vec::new());

/// The hook of the calls that run, the hook before it, and the number of the calls.
struct Hook {
    own: Py<PyAny>,
    before: Py<PyAny>,
    calls: usize,
}

static HOOK: Mutex<Option<Hook>> = Mutex::new(None);

/// Number of the last call.
static CALLS: AtomicU64 = AtomicU64::new(0);

const NAME: &str = "unraisablehook";

/// Does work that calls functions, given the number of the call; raises what a function raised first.
pub fn carrying<T>(py: Python<'_>, work: impl FnOnce(u64) -> PyResult<T>) -> PyResult<T> {
    let call = CALLS.fetch_add(1, Ordering::Relaxed) + 1;
    begin(py)?;
    let result = work(call);
    let raised = {
        let mut raised = RAISED.lock().expect("nothing panics here");
        raised.iter().position(|(other, _)| *other == call).map(|place| raised.swap_remove(place).1)
    };
    end(py)?;
    raised.map_or(result, Err)
}

/// Whether a function has raised in the call of that number.
pub fn has_raised(call: u64) -> bool {
    RAISED.lock().expect("nothing panics here").iter().any(|(other, _)| *other == call)
}

fn begin(py: Python<'_>) -> PyResult<()> {
    let mut hook = HOOK.lock_py_attached(py).expect("nothing panics here");
    if let Some(hook) = &mut *hook {
        hook.calls += 1;
        return Ok(());
    }
    let sys = py.import("sys")?;
    let before = sys.getattr(NAME)?.unbind();
    let other = before.clone_ref(py);
    let own = PyCFunction::new_closure(py, None, None, move |given, _: Option<&Bound<'_, PyDict>>| {
        note(given, &other)
    })?;
    sys.setattr(NAME, &own)?;
    *hook = Some(Hook { own: own.into_any().unbind(), before, calls: 1 });
    Ok(())
}

fn end(py: Python<'_>) -> PyResult<()> {
    let mut hook = HOOK.lock_py_attached(py).expect("nothing panics here");
    let Some(Hook { own, before, calls }) = &mut *hook else { return Ok(()) };
    *calls -= 1;
    if *calls == 0 {
        let sys = py.import("sys")?;
        // A hook that was set meanwhile stays.
        if sys.getattr(NAME)?.is(&*own) {
            sys.setattr(NAME, &*before)?;
        }
        *hook = None;
    }
    Ok(())
}

/// Keeps what a function of a call raised, and hands all else to the hook before.
fn note(given: &Bound<'_, PyTuple>, before: &Py<PyAny>) -> PyResult<()> {
    let (py, unraisable, call) = (given.py(), given.get_item(0)?, owner());
    // numba gives the name of its function instead of the function.
    let is_of_numba = unraisable.getattr("object")?.is_instance_of::<PyString>();
    let words = unraisable.getattr("err_msg")?;
    let is_of_ctypes = !words.is_none() && words.str()?.to_string_lossy().contains("ctypes callback");
    let value = unraisable.getattr("exc_value")?;
    if call == 0 || value.is_none() || !(is_of_ctypes || is_of_numba) {
        return before.call1(py, given).map(|_| ());
    }
    if !has_raised(call) {
        let error = PyErr::from_value(value);
        RAISED.lock().expect("nothing panics here").push((call, error));
    }
    Ok(())
}
