//! The face towards Python: arrays in, arrays out. No mathematics.

mod exact;

use crate::body::{Inertia, principal_axes as axes_of};
use crate::ensemble::{Criterion, Judge, Map, Outcome, Pixel, Statistics};
use crate::error::Error;
use crate::exact::Place;
use crate::method::Method;
use crate::outside::Outside;
use crate::sample::Law;
use crate::simd::Isa;
use crate::start::Body;
use crate::trajectory::{self, Record, Request, Schedule, Solver, States, Status};
use numpy::{
    IntoPyArray, PyArray1, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods,
};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

impl From<Error> for PyErr {
    fn from(error: Error) -> PyErr {
        match error {
            Error::Isa { .. } => PyRuntimeError::new_err(error.to_string()),
            _ => PyValueError::new_err(error.to_string()),
        }
    }
}

/// Rotation of rigid bodies: the compiled core of `rigid`.
#[pymodule(gil_used = false)]
mod _core {
    #[pymodule_export]
    use super::exact::{elliptic, flip_times, free_quantities_of, tilt_times, top_quantities_of};
    #[pymodule_export]
    use super::{
        MapJob, PyOutside, build_info, check_method, check_moments, closed_forms, fastest_rates, methods,
    };
    #[pymodule_export]
    use super::{principal_axes, simulate};

    /// Version of the library.
    #[pymodule_export]
    #[allow(non_upper_case_globals)]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}

/// How this library was built and what it runs with.
#[pyfunction]
fn build_info(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let info = PyDict::new(py);
    info.set_item("version", env!("CARGO_PKG_VERSION"))?;
    let commit = env!("RIGID_COMMIT");
    info.set_item("commit", (!commit.is_empty()).then_some(commit))?;
    info.set_item("profile", env!("RIGID_PROFILE"))?;
    info.set_item("isa", Isa::current()?.name())?;
    let available: Vec<_> = Isa::available().into_iter().map(Isa::name).collect();
    info.set_item("isa_available", available)?;
    Ok(info)
}

/// What each method promises, one dict a method.
#[pyfunction]
fn methods(py: Python<'_>) -> PyResult<Vec<Bound<'_, PyDict>>> {
    let describe = |method: Method| {
        let facts = method.facts();
        let entry = PyDict::new(py);
        entry.set_item("name", facts.name)?;
        entry.set_item("title", facts.title)?;
        entry.set_item("order", facts.order)?;
        entry.set_item("stages", facts.stages)?;
        entry.set_item("symplectic", facts.symplectic)?;
        entry.set_item("reversible", facts.reversible)?;
        entry.set_item("group_preserving", facts.group_preserving)?;
        entry.set_item("driven", method.damping_limit().is_some())?;
        entry.set_item("stiff", method.damping_limit() == Some(f64::INFINITY))?;
        entry.set_item("tops", method.check(true, false).is_ok())?;
        entry.set_item("maps", method.check(false, true).is_ok())?;
        entry.set_item("angle_per_step", facts.angle_per_step)?;
        entry.set_item("citation", facts.citation)?;
        entry.set_item("doi", facts.doi)?;
        Ok(entry)
    };
    Method::ALL.into_iter().map(describe).collect()
}

/// Raises if the method does not move that scene, or cannot be watched on the way as a map wants it.
#[pyfunction]
fn check_method(method: &str, scene: &str, watched: bool) -> PyResult<()> {
    Method::parse(method)?.check(parse_scene(scene)?, watched)?;
    Ok(())
}

/// Raises if no rigid body has these moments.
#[pyfunction]
fn check_moments(moments: [f64; 3]) -> PyResult<()> {
    Inertia::new(moments)?;
    Ok(())
}

/// Principal moments, ascending, and axes (columns) of a tensor of inertia.
#[pyfunction]
fn principal_axes(tensor: [[f64; 3]; 3]) -> PyResult<([f64; 3], [[f64; 3]; 3])> {
    let (inertia, axes) = axes_of(tensor)?;
    Ok((inertia.moments(), axes))
}

/// The rows of a C-contiguous (n, N) array.
fn rows<'a, const N: usize>(
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

/// Refuses a list that is not as long as the bodies or pixels.
fn same_length(argument: &'static str, expected: usize, got: usize) -> PyResult<()> {
    if expected == got {
        return Ok(());
    }
    Err(Error::Shape { argument, expected: format!("({expected}, ...)"), got: format!("({got}, ...)") }
        .into())
}

fn parse_scene(scene: &str) -> Result<bool, Error> {
    match scene {
        "free" => Ok(false),
        "top" => Ok(true),
        _ => Err(Error::Unknown { argument: "scene", value: scene.into(), known: "free, top".into() }),
    }
}

fn parse_record(record: &str) -> Result<Record, Error> {
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

/// Does `work` without the interpreter, which meanwhile handles its signals; `None` if it was stopped.
///
/// Stops when a signal handler raises (then this raises too) or when `interrupted()` says so.
fn interruptible<T: Send>(
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

/// What a request without a result of its own raises when it was stopped.
fn stopped() -> PyErr {
    PyRuntimeError::new_err("interrupted")
}

/// What acts on all bodies of a request from outside: a torque in the body and in space at some times, between which it
/// changes evenly (no times: constant), and damping, entries 11, 22, 33, 23, 31, 12 of its matrix.
#[pyclass(frozen, name = "Outside", module = "rigid._core")]
struct PyOutside(Outside);

#[pymethods]
impl PyOutside {
    #[new]
    #[pyo3(signature = (*, times, body, space, damping))]
    fn new(
        times: Vec<f64>,
        body: PyReadonlyArray2<'_, f64>,
        space: PyReadonlyArray2<'_, f64>,
        damping: [f64; 6],
    ) -> PyResult<Self> {
        let (body, space) = (rows::<3>("torque", &body)?, rows::<3>("torque", &space)?);
        Ok(PyOutside(Outside::new(&times, body, space, damping)?))
    }

    /// The rate at which it slows all components of the momentum of such a body alike, if it does and nothing else.
    fn slows_evenly(&self, moments: [f64; 3]) -> Option<f64> {
        self.0.slows_evenly(moments)
    }

    /// The rates at which damping alone slows a body with these moments, ascending.
    fn damping_rates(&self, moments: [f64; 3]) -> [f64; 3] {
        self.0.damping_rates(moments)
    }
}

/// States of bodies at wanted times; see `rigid.simulate`.
#[pyfunction]
#[pyo3(signature = (*, scene, method, record, moments, weight, omega, attitude, step, max_steps, threads, times=None, strides=None, tolerance=None, outside=None))]
#[allow(clippy::too_many_arguments)] // The request of `trajectory`, column by column.
fn simulate<'py>(
    py: Python<'py>,
    scene: &str,
    method: &str,
    record: &str,
    moments: PyReadonlyArray2<'py, f64>,
    weight: PyReadonlyArray2<'py, f64>,
    omega: PyReadonlyArray2<'py, f64>,
    attitude: PyReadonlyArray2<'py, f64>,
    step: Option<PyReadonlyArray1<'py, f64>>,
    max_steps: u64,
    threads: usize,
    times: Option<Vec<f64>>,
    strides: Option<Vec<u64>>,
    tolerance: Option<f64>,
    outside: Option<PyRef<'py, PyOutside>>,
) -> PyResult<Bound<'py, PyDict>> {
    let (is_top, solver, record, isa) =
        (parse_scene(scene)?, Solver::parse(method)?, parse_record(record)?, Isa::current()?);
    let omega = rows::<3>("omega", &omega)?;
    let n = omega.len();
    let bodies = bodies(
        rows::<3>("moments", &moments)?,
        rows::<3>("weight", &weight)?,
        omega,
        rows::<4>("attitude", &attitude)?,
    )?;
    let outside = outside.as_ref().map(|outside| &outside.0);
    let span = times.as_deref().map_or([0.0; 2], span_of);
    let steps = match (step, solver) {
        (Some(step), _) => step.as_array().to_vec(),
        (None, Solver::Steps(method)) => {
            let rate = |body: &Body| body.step_rate(method, outside, span);
            bodies.iter().map(|body| method.facts().angle_per_step / rate(body)).collect()
        }
        (None, Solver::Exact) => vec![f64::INFINITY; n],
    };
    same_length("step", n, steps.len())?;
    let schedule = match (&times, &strides) {
        (Some(times), _) => Schedule::Times(times),
        (None, Some(strides)) => Schedule::Strides(strides),
        (None, None) => Schedule::Times(&[]),
    };
    let steps = &steps;
    let request = Request { bodies: &bodies, is_top, solver, record, schedule, steps, tolerance, max_steps };
    let states = interruptible(py, None, |stop| {
        trajectory::simulate_driven(&request, outside, threads, isa, stop).transpose()
    })?
    .ok_or_else(stopped)??;
    states_to_dict(py, states, n, request.schedule.len())
}

/// First and last of some times and 0.
fn span_of(times: &[f64]) -> [f64; 2] {
    [times.first().map_or(0.0, |t| t.min(0.0)), times.last().map_or(0.0, |t| t.max(0.0))]
}

/// The bodies of columns with a row for each, or one row for all.
fn bodies(
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

/// The closed form of each body by its name, empty if it has none.
#[pyfunction]
#[pyo3(signature = (*, scene, moments, weight, omega, attitude))]
fn closed_forms(
    scene: &str,
    moments: PyReadonlyArray2<'_, f64>,
    weight: PyReadonlyArray2<'_, f64>,
    omega: PyReadonlyArray2<'_, f64>,
    attitude: PyReadonlyArray2<'_, f64>,
) -> PyResult<Vec<&'static str>> {
    parse_scene(scene)?;
    let bodies = bodies(
        rows::<3>("moments", &moments)?,
        rows::<3>("weight", &weight)?,
        rows::<3>("omega", &omega)?,
        rows::<4>("attitude", &attitude)?,
    )?;
    Ok(bodies.iter().map(|body| Place::of(body).map_or("", |place| place.form.name())).collect())
}

/// Bounds of |omega| over the whole motion, from what is conserved: those that a step is chosen from. Under what acts
/// from outside, between these two times; given a method, the rate that its steps follow.
#[pyfunction]
#[pyo3(signature = (*, scene, moments, weight, omega, attitude, outside=None, span=None, method=None))]
#[allow(clippy::too_many_arguments)] // The columns of a request.
fn fastest_rates<'py>(
    py: Python<'py>,
    scene: &str,
    moments: PyReadonlyArray2<'py, f64>,
    weight: PyReadonlyArray2<'py, f64>,
    omega: PyReadonlyArray2<'py, f64>,
    attitude: PyReadonlyArray2<'py, f64>,
    outside: Option<PyRef<'py, PyOutside>>,
    span: Option<[f64; 2]>,
    method: Option<&str>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    parse_scene(scene)?;
    let outside = outside.as_ref().map(|outside| &outside.0);
    let (method, span) = (method.map(Method::parse).transpose()?, span.unwrap_or_default());
    let bodies = bodies(
        rows::<3>("moments", &moments)?,
        rows::<3>("weight", &weight)?,
        rows::<3>("omega", &omega)?,
        rows::<4>("attitude", &attitude)?,
    )?;
    let rate = |body: &Body| match (outside, method) {
        (None, _) => body.fastest_rate(),
        (Some(outside), None) => body.fastest_rate_driven(outside, span),
        (_, Some(method)) => body.step_rate(method, outside, span),
    };
    Ok(bodies.iter().map(rate).collect::<Vec<f64>>().into_pyarray(py))
}

fn states_to_dict(py: Python<'_>, states: States, n: usize, times: usize) -> PyResult<Bound<'_, PyDict>> {
    let dict = PyDict::new(py);
    let shaped = |values: Vec<f64>, width: usize| values.into_pyarray(py).reshape([n, times, width]);
    dict.set_item("omega", shaped(states.omega, 3)?)?;
    dict.set_item("vertical", states.vertical.map(|values| shaped(values, 3)).transpose()?)?;
    dict.set_item("attitude", states.attitude.map(|values| shaped(values, 4)).transpose()?)?;
    let work = states.work.map(|values| values.into_pyarray(py).reshape([n, times])).transpose()?;
    dict.set_item("work", work)?;
    dict.set_item("energy_drift", states.energy_drift.into_pyarray(py))?;
    dict.set_item("momentum_drift", states.momentum_drift.into_pyarray(py))?;
    dict.set_item("unit_drift", states.unit_drift.into_pyarray(py))?;
    let status: Vec<u8> = states.status.iter().map(|&s| s as u8).collect();
    dict.set_item("status", status.into_pyarray(py))?;
    dict.set_item("steps", states.steps.into_pyarray(py))?;
    dict.set_item("nanoseconds", states.nanoseconds)?;
    Ok(dict)
}

/// A checked request for a map; its samples are run in ranges and one by one.
#[pyclass(frozen, module = "rigid._core")]
struct MapJob {
    map: Map,
    status: Vec<u8>,
    outside: Option<Vec<Outside>>,
    isa: Isa,
}

/// A column of the statistics: its name and its value in a pixel.
type Column<T> = (&'static str, fn(&Statistics) -> T);

const COUNTS: [Column<u64>; 10] = [
    ("stable", |s| s.stable),
    ("unstable", |s| s.unstable),
    ("undecided", |s| s.undecided),
    ("failed", |s| s.failed),
    ("step_limit", |s| s.step_limit),
    ("not_finite", |s| s.not_finite),
    ("drifted", |s| s.drifted),
    ("exact", |s| s.exact),
    ("checked", |s| s.checked),
    ("steps", |s| s.steps),
];

const NUMBERS: [Column<f64>; 4] = [
    ("energy_drift", |s| s.energy_drift),
    ("momentum_drift", |s| s.momentum_drift),
    ("earliest", |s| s.earliest),
    ("nanoseconds", |s| s.nanoseconds),
];

/// 0 for a possible body, else which rule it breaks.
fn body_status(moments: [f64; 3]) -> u8 {
    match Inertia::new(moments) {
        Ok(_) => 0,
        Err(Error::MomentNotFinite(..)) => 1,
        Err(Error::MomentNotPositive(..)) => 2,
        Err(_) => 3,
    }
}

#[pymethods]
impl MapJob {
    #[new]
    #[pyo3(signature = (*, scene, method, moments, weight, omega, omega_noise, omega_size, attitude, attitude_noise,
        attitude_size, criterion, axis, limit, t_end, step, max_steps, samples, checked, seed, outside=None))]
    #[allow(clippy::too_many_arguments)] // The fields of `Map`, column by column.
    fn new(
        scene: &str,
        method: &str,
        moments: PyReadonlyArray2<'_, f64>,
        weight: PyReadonlyArray2<'_, f64>,
        omega: PyReadonlyArray2<'_, f64>,
        omega_noise: &str,
        omega_size: PyReadonlyArray2<'_, f64>,
        attitude: PyReadonlyArray2<'_, f64>,
        attitude_noise: &str,
        attitude_size: PyReadonlyArray1<'_, f64>,
        criterion: &str,
        axis: i32,
        limit: f64,
        t_end: f64,
        step: Option<f64>,
        max_steps: u64,
        samples: u64,
        checked: u64,
        seed: u128,
        outside: Option<Vec<PyRef<'_, PyOutside>>>,
    ) -> PyResult<Self> {
        let criterion = match criterion {
            "no_flip" => Criterion::NoFlip,
            "tilt_from_start" => Criterion::TiltFromStart(limit),
            "tilt_from_vertical" => Criterion::TiltFromVertical(limit),
            _ => {
                let known = "no_flip, tilt_from_start, tilt_from_vertical".into();
                return Err(Error::Unknown { argument: "criterion", value: criterion.into(), known }.into());
            }
        };
        if !(1..=3).contains(&axis.unsigned_abs()) {
            let rule = "must be 1, 2, 3 or -1, -2, -3";
            return Err(Error::Value { argument: "axis", value: axis.to_string(), rule }.into());
        }
        if samples == 0 {
            let rule = "must be at least 1";
            return Err(Error::Value { argument: "samples", value: samples.to_string(), rule }.into());
        }
        if !(t_end.is_finite() && t_end > 0.0) {
            let rule = "must be positive and finite";
            return Err(Error::Value { argument: "t_end", value: t_end.to_string(), rule }.into());
        }
        let moments = rows::<3>("moments", &moments)?;
        let pixels = moments.len();
        let status: Vec<u8> = moments.iter().map(|&m| body_status(m)).collect();
        let omega_size = rows::<3>("omega_size", &omega_size)?;
        same_length("omega_size", pixels, omega_size.len())?;
        let attitude_size = attitude_size.as_array().to_vec();
        same_length("attitude_size", pixels, attitude_size.len())?;
        let omega = rows::<3>("omega", &omega)?;
        same_length("omega", pixels, omega.len())?;
        let bodies =
            bodies(moments, rows::<3>("weight", &weight)?, omega, rows::<4>("attitude", &attitude)?)?;
        let pixel = |i: usize| Pixel {
            body: bodies[i],
            omega_size: omega_size[i],
            attitude_size: attitude_size[i],
            possible: status[i] == 0,
        };
        let map = Map {
            is_top: parse_scene(scene)?,
            judge: Judge::parse(method)?,
            pixels: (0..pixels).map(pixel).collect(),
            omega_law: Law::parse("omega_noise", omega_noise)?,
            attitude_law: Law::parse("attitude_noise", attitude_noise)?,
            criterion,
            axis,
            t_end,
            step,
            max_steps,
            samples,
            checked,
            key: [seed as u64, (seed >> 64) as u64],
        };
        if map.judge != Judge::Only(Solver::Exact) {
            map.judge.method().check(map.is_top, true)?;
        }
        let outside = outside.map(|all| all.iter().map(|one| one.0.clone()).collect::<Vec<_>>());
        if let Some(outside) = &outside {
            same_length("outside", pixels, outside.len())?;
            map.check_driven(outside)?;
        }
        if map.judge == Judge::Only(Solver::Exact)
            && let Some(pixel) = map.first_without_closed_form()
        {
            return Err(Error::NoClosedVerdict { pixel }.into());
        }
        Ok(MapJob { map, status, outside, isa: Isa::current()? })
    }

    /// Which bodies are possible: 0, or 1 not finite, 2 not positive, 3 triangle inequality.
    #[getter]
    fn status<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u8>> {
        self.status.clone().into_pyarray(py)
    }

    /// Statistics of the samples start .. stop (pixel-major) for the pixels that they touch; None if
    /// `interrupted()`, asked twenty times a second, said to stop.
    #[pyo3(signature = (start, stop, threads, interrupted=None))]
    fn run<'py>(
        &self,
        py: Python<'py>,
        start: u64,
        stop: u64,
        threads: usize,
        interrupted: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Option<Bound<'py, PyDict>>> {
        if start > stop || stop > self.map.len() {
            let value = format!("({start}, {stop})");
            let rule = "must be a range of the samples of the map";
            return Err(Error::Value { argument: "start, stop", value, rule }.into());
        }
        let result = interruptible(py, interrupted, |interrupt| {
            self.map.run_driven(self.outside.as_deref(), start, stop, threads.max(1), self.isa, interrupt)
        })?;
        let Some((first, statistics)) = result else { return Ok(None) };
        let dict = PyDict::new(py);
        dict.set_item("first", first)?;
        for (name, of) in COUNTS {
            let column: Vec<i64> = statistics.iter().map(|s| of(s) as i64).collect();
            dict.set_item(name, column.into_pyarray(py))?;
        }
        for (name, of) in NUMBERS {
            let column: Vec<f64> = statistics.iter().map(of).collect();
            dict.set_item(name, column.into_pyarray(py))?;
        }
        Ok(Some(dict))
    }

    /// One sample alone, with the bits that it has in the map.
    fn sample<'py>(&self, py: Python<'py>, pixel: u64, sample: u64) -> PyResult<Bound<'py, PyDict>> {
        for (argument, value, length) in
            [("pixel", pixel, self.map.pixels.len() as u64), ("sample", sample, self.map.samples)]
        {
            if value >= length {
                let value = format!("{value} of {length}");
                return Err(Error::Value { argument, value, rule: "must be an index" }.into());
            }
        }
        let (body, class, outcome) = interruptible(py, None, |interrupt| {
            self.map.sample_driven(self.outside.as_deref(), pixel, sample, self.isa, interrupt)
        })?
        .ok_or_else(stopped)?;
        let Outcome { status, flips, left, tilt, energy_drift, momentum_drift, step, steps, exact, .. } =
            outcome;
        let dict = PyDict::new(py);
        dict.set_item("omega", body.omega.to_vec().into_pyarray(py))?;
        dict.set_item("attitude", body.attitude.to_vec().into_pyarray(py))?;
        dict.set_item("class", class.name())?;
        dict.set_item("status", Status::name(status))?;
        dict.set_item("flips", flips)?;
        dict.set_item("left", if left < f64::INFINITY { left } else { f64::NAN })?;
        dict.set_item("tilt", tilt)?;
        dict.set_item("energy_drift", energy_drift)?;
        dict.set_item("momentum_drift", momentum_drift)?;
        dict.set_item("step", step)?;
        dict.set_item("steps", steps)?;
        dict.set_item("method", if exact { Solver::EXACT } else { self.map.judge.method().facts().name })?;
        Ok(dict)
    }
}
