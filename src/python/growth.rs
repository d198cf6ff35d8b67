//! Growth of deviation vectors.

use super::bodies::Bodies;
use super::convert::{Aligned1, Aligned2, column, copied, evaluated, interruptible, rows, same_length};
use crate::body::Body;
use crate::call::Call;
use crate::error::Error;
use crate::float_environment::FloatEnvironment;
use crate::map::{Class, DEVIATIONS, Rule, deviation_start};
use crate::memory;
use crate::method::{AnyMethod, Method};
use crate::observe::Deviation;
use crate::parallel::Interrupt;
use crate::simd::Isa;
use crate::status::Status;
use crate::trajectory::{self, Deviations, Growths, MAX_DEVIATIONS, Record, Request, Schedule};
use numpy::ndarray::Array3;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArray3, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Growth of deviation vectors, so many a body, at positive times; see `rigid.lyapunov`.
#[pyfunction]
#[pyo3(signature = (bodies, *, method, deviations, of_attitude, times, step, max_steps, threads))]
#[allow(clippy::too_many_arguments)] // The request of `trajectory`, array by array.
pub fn growth<'py>(
    py: Python<'py>,
    bodies: Bodies<'py>,
    method: &str,
    deviations: Aligned2<'py, f64>,
    of_attitude: bool,
    times: Aligned1<'py, f64>,
    step: Aligned1<'py, f64>,
    max_steps: u64,
    threads: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let _standard = FloatEnvironment::standard();
    let (scene, method, isa) = (bodies.scene()?, Method::parse(method)?, Isa::current()?);
    let given = &bodies.all()?;
    let n = given.len();
    let forces = bodies.forces(n)?;
    let times = copied("times", &times)?;
    let starts = rows::<6>("deviations", &deviations)?;
    let count = starts.len().checked_div(n).unwrap_or(1);
    if starts.len() != n * count || !(1..=MAX_DEVIATIONS).contains(&count) {
        let (expected, got) = (format!("(1 to 6 times {n}, 6)"), format!("({}, 6)", starts.len()));
        return Err(Error::Shape { argument: "deviations", expected, got }.into());
    }
    let each = starts.iter().enumerate().map(|(index, &start)| Deviation {
        start,
        inverse_scale: [1.0 / given[index / count].rate_unit(); 3],
        of_attitude,
    });
    let each = memory::collected("deviations", starts.len(), each)?;
    same_length("step", n, step.len())?;
    let steps = &copied("step", &step)?;
    let request = Request {
        bodies: given,
        scene,
        forces,
        method: AnyMethod::Steps(method),
        // The kernels are those of deviation vectors; they are not recorded one by one.
        record: Record::Tangent(&[]),
        schedule: Schedule::Times(&times),
        steps,
        refinement: 1.0,
        tolerance: None,
        max_steps,
    };
    let deviations = Deviations { each: &each, count };
    let run = |stop: &Interrupt| {
        stop.expect(n, 0..n);
        trajectory::growth(&request, method, deviations, Call { isa, threads, stop })
    };
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

/// Generic deviation vectors, (6, 6): rates in the unit of the body, rotation vectors in rad.
#[pyfunction]
pub fn generic_deviations(py: Python<'_>) -> PyResult<Bound<'_, PyArray2<f64>>> {
    DEVIATIONS.as_flattened().to_vec().into_pyarray(py).reshape([6, 6])
}

/// The deviation vectors of the two runs of a verdict on each body, (n, 2, 6): changes of the rates, rotation vectors
/// in rad.
#[pyfunction]
pub fn deviation_starts<'py>(py: Python<'py>, bodies: Bodies<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
    let given = bodies.all()?;
    let n = given.len();
    let forces = bodies.forces(n)?;
    let both = |index: usize| {
        let start = |cross_check| deviation_start(&given[index], forces.of(index), cross_check);
        Ok([false, true].map(start))
    };
    let starts = evaluated(py, "deviations", n, both)?;
    starts.into_flattened().into_flattened().into_pyarray(py).reshape([n, 2, 6])
}

/// The unit of changes of the rates of each body.
#[pyfunction]
pub fn rate_units<'py>(py: Python<'py>, bodies: Bodies<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let _standard = FloatEnvironment::standard();
    column(py, &bodies.all()?, Body::rate_unit)
}

/// The verdict on each motion, from its mean MEGNO at the checkpoints of a run and of a second run, by a rule: the
/// numbers of a criterion of maps.
#[pyfunction]
#[pyo3(signature = (first, second, limits))]
pub fn verdicts(
    first: Aligned2<'_, f64>,
    second: Option<Aligned2<'_, f64>>,
    limits: [f64; 4],
) -> PyResult<Vec<&'static str>> {
    let [sure, low, high, ratio] = limits;
    let rule = Rule { sure, low, high, ratio };
    let first = rows::<4>("first", &first)?;
    let second = second.as_ref().map(|second| rows::<4>("second", second)).transpose()?;
    if let Some(second) = second {
        same_length("second", first.len(), second.len())?;
    }
    let verdict = |(index, &means): (usize, &[f64; 4])| {
        let class = rule.class(means);
        let together = match second.map(|second| rule.class(second[index])) {
            Some(Class::Failed) => Class::Failed,
            Some(again) => class.agreed(again),
            None => class,
        };
        match together {
            Class::Stable => "regular",
            Class::Unstable => "chaotic",
            other => other.name(),
        }
    };
    Ok(memory::collected("verdicts", first.len(), first.iter().enumerate().map(verdict))?)
}
