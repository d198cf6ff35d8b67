//! Growth of displacements.

use super::convert::{BodyColumns, copied, interruptible, rows, same_length};
use super::forcing::PyForcing;
use super::simulate::forcing_of;
use crate::error::Error;
use crate::memory;
use crate::observe::Displacement;
use crate::parallel::Interrupt;
use crate::scene::Scene;
use crate::scheme::Scheme;
use crate::simd::Isa;
use crate::solver::Solver;
use crate::status::Status;
use crate::trajectory::{self, Displacements, Growths, MAX_DISPLACEMENTS, Record, Request, Schedule};
use numpy::ndarray::Array3;
use numpy::{IntoPyArray, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Growth of displacements, so many a body, at positive times; see `rigid.lyapunov`. `scale` is the unit of the rates of
/// each body.
#[pyfunction]
#[pyo3(signature = (*, scene, method, moments, weight, omega, attitude, displacements, scale, of_attitude, times, step, max_steps, threads, forcing=None))]
#[allow(clippy::too_many_arguments)] // The request of `trajectory`, column by column.
pub fn growth<'py>(
    py: Python<'py>,
    scene: &str,
    method: &str,
    moments: PyReadonlyArray2<'py, f64>,
    weight: PyReadonlyArray2<'py, f64>,
    omega: PyReadonlyArray2<'py, f64>,
    attitude: PyReadonlyArray2<'py, f64>,
    displacements: PyReadonlyArray2<'py, f64>,
    scale: PyReadonlyArray1<'py, f64>,
    of_attitude: bool,
    times: PyReadonlyArray1<'py, f64>,
    step: PyReadonlyArray1<'py, f64>,
    max_steps: u64,
    threads: usize,
    forcing: Option<PyRef<'py, PyForcing>>,
) -> PyResult<Bound<'py, PyDict>> {
    let (scene, scheme, isa) = (Scene::parse(scene)?, Scheme::parse(method)?, Isa::current()?);
    let columns = BodyColumns::of_arrays(&moments, &weight, &omega, &attitude)?;
    let n = columns.len();
    let forcing = forcing_of(forcing.as_ref(), n)?;
    let (times, scale) = (copied("times", &times)?, copied("scale", &scale)?);
    same_length("scale", n, scale.len())?;
    let starts = rows::<6>("displacements", &displacements)?;
    let count = starts.len().checked_div(n).unwrap_or(1);
    if starts.len() != n * count || !(1..=MAX_DISPLACEMENTS).contains(&count) {
        let (expected, got) = (format!("(1 to 6 times {n}, 6)"), format!("({}, 6)", starts.len()));
        return Err(Error::Shape { argument: "displacements", expected, got }.into());
    }
    let each = starts.iter().enumerate().map(|(index, &start)| Displacement {
        start,
        inverse_scale: [1.0 / scale[index / count]; 3],
        of_attitude,
    });
    let each = memory::collected("displacements", starts.len(), each)?;
    let bodies = &columns.bodies(0..n)?;
    let schedule = Schedule::Times(&times);
    same_length("step", n, step.len())?;
    let steps = &copied("step", &step)?;
    let request = Request {
        bodies,
        scene,
        forcing,
        solver: Solver::Steps(scheme),
        // The kernels are those of displacements; they are not recorded one by one.
        record: Record::Tangent(&[]),
        schedule,
        steps,
        refinement: 1.0,
        tolerance: None,
        max_steps,
    };
    let displacements = Displacements { each: &each, count };
    let run = |stop: &Interrupt| trajectory::growth(&request, scheme, displacements, threads, isa, stop);
    to_dict(py, interruptible(py, None, run)??, n, times.len(), count)
}

fn to_dict(
    py: Python<'_>,
    growths: Growths,
    n: usize,
    times: usize,
    count: usize,
) -> PyResult<Bound<'_, PyDict>> {
    let dict = PyDict::new(py);
    for (name, width, values) in [
        ("logs", 4, growths.logs),
        ("log_diagonal", count, growths.log_diagonal),
        ("log_gali", count, growths.log_gali),
        ("sali", 1, growths.sali),
    ] {
        let rows = Array3::from_shape_vec([n, times, width], values).expect("as long as reserved");
        dict.set_item(name, rows.into_pyarray(py))?;
    }
    dict.set_item("energy_drift", growths.energy_drift.into_pyarray(py))?;
    dict.set_item("steps", growths.steps.into_pyarray(py))?;
    let status = |&status: &Status| status as u8;
    dict.set_item("status", super::convert::column(py, &growths.status, status)?)?;
    Ok(dict)
}
