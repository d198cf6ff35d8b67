//! States at given times, and the rates that determine steps.

use super::bodies::Bodies;
use super::convert::{
    Aligned1, Aligned2, BodyColumns, OneOrEach, at_once, copied_numbers, evaluated, interruptible_calls,
    parse_record, rows, same_length, times_of_bodies,
};
use super::forces::PyForces;
use super::states::{PyStates, of_bodies, shaped};
use super::target::Target;
use crate::accuracy::{self, Asked, Solved};
use crate::body::Body;
use crate::call::Call;
use crate::error::Error;
use crate::estimate::Estimate;
use crate::float_environment::FloatEnvironment;
use crate::forces::{Forces, ParameterChange};
use crate::map::PlannedRun;
use crate::memory;
use crate::method::{AnyMethod, Method};
use crate::parallel::Interrupt;
use crate::scene::Scene;
use crate::simd::Isa;
use crate::status::Status;
use crate::trajectory::{self, Record, Request, Schedule, States, default_steps as default_steps_of};
use numpy::{PyArray1, PyArray2, PyArrayDyn, PyUntypedArrayMethods};
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};

/// Bytes of the states of so many bodies at so many times.
#[pyfunction]
#[pyo3(signature = (*, scene, record, bodies, times, forces=None))]
pub fn state_bytes(
    scene: &str,
    record: &str,
    bodies: usize,
    times: usize,
    forces: Option<PyRef<'_, PyForces>>,
) -> PyResult<u128> {
    let request = Request {
        bodies: &[],
        scene: Scene::parse(scene)?,
        forces: forces.as_ref().map_or(Forces::NONE, |forces| &forces.0),
        method: AnyMethod::Exact,
        record: parse_record(record, &[], &[])?,
        schedule: Schedule::Times(&[]),
        steps: &[],
        refinement: 1.0,
        tolerance: None,
        max_steps: 0,
    };
    Ok(States::bytes(&request, bodies, times, &[]))
}

/// `rigid.solve.request.Request`.
#[derive(FromPyObject)]
struct Given<'py> {
    bodies: Bodies<'py>,
    times: Bound<'py, PyArrayDyn<f64>>,
    strides: Option<Vec<u64>>,
    method: Bound<'py, PyString>,
    record: Bound<'py, PyString>,
    max_steps: u64,
    threads: usize,
    tolerance: Option<f64>,
}

/// How a request is run.
struct Run<'py> {
    step: Option<Aligned1<'py, f64>>,
    refinement: f64,
    deviations: Option<Aligned2<'py, f64>>,
    changes: Option<Aligned2<'py, f64>>,
    single: bool,
    /// How accurate the states shall be; otherwise there is one run.
    asked: Option<Asked>,
}

/// States of bodies at given times by one run; see `rigid.solve.request.Request.states`.
#[pyfunction]
#[pyo3(signature = (request, step, refinement=1.0, deviations=None, changes=None, out=None, single=false))]
#[allow(clippy::too_many_arguments)] // What differs between the runs of one request.
pub fn simulate<'py>(
    py: Python<'py>,
    request: &Bound<'py, PyAny>,
    step: Option<Aligned1<'py, f64>>,
    refinement: f64,
    deviations: Option<Aligned2<'py, f64>>,
    changes: Option<Aligned2<'py, f64>>,
    out: Option<&Bound<'py, PyDict>>,
    single: bool,
) -> PyResult<PyStates> {
    let run = Run { step, refinement, deviations, changes, single, asked: None };
    states_of(py, request.extract()?, run, out)
}

/// States of bodies at given times by steps, as accurate as asked for, with their errors; see
/// `rigid.solve.request.Request.solve`.
#[pyfunction]
#[pyo3(signature = (request, step, accuracy, check, free, out=None))]
pub fn solve<'py>(
    py: Python<'py>,
    request: &Bound<'py, PyAny>,
    step: Option<Aligned1<'py, f64>>,
    accuracy: Option<f64>,
    check: bool,
    free: bool,
    out: Option<&Bound<'py, PyDict>>,
) -> PyResult<PyStates> {
    let given: Given<'_> = request.extract()?;
    Method::parse(given.method.to_str()?)?;
    if given.strides.is_some() {
        return Err(Error::value("strides", "given", "an accuracy is of states at times").into());
    }
    let asked = Some(Asked { accuracy, check, free, may_stop: given.bodies.may_stop });
    let run = Run { step, refinement: 1.0, deviations: None, changes: None, single: false, asked };
    states_of(py, given, run, out)
}

/// The tolerance of the first run for an accuracy.
#[pyfunction]
pub fn first_tolerance(accuracy: f64, method: &str) -> PyResult<f64> {
    let _standard = FloatEnvironment::standard();
    Ok(accuracy::first_tolerance(accuracy, Method::parse(method)?))
}

fn states_of<'py>(
    py: Python<'py>,
    given: Given<'py>,
    run: Run<'py>,
    out: Option<&Bound<'py, PyDict>>,
) -> PyResult<PyStates> {
    let _standard = FloatEnvironment::standard();
    let Given { max_steps, threads, tolerance, .. } = given;
    let Run { step, refinement, deviations, changes, single, asked } = run;
    let (scene, method, isa) =
        (given.bodies.scene()?, AnyMethod::parse(given.method.to_str()?)?, Isa::current()?);
    let n = given.bodies.len()?;
    let forces = given.bodies.forces(n)?;
    let deviations = match &deviations {
        Some(given) => {
            let given = rows::<6>("deviations", given)?;
            memory::collected("deviations", given.len(), given.iter().copied())?
        }
        None => Vec::new(),
    };
    let changes = match &changes {
        Some(given) => {
            let given = rows::<{ ParameterChange::LEN }>("changes", given)?;
            memory::collected("changes", given.len(), given.iter().map(ParameterChange::of))?
        }
        None => Vec::new(),
    };
    let record = parse_record(given.record.to_str()?, &deviations, &changes)?;
    match record {
        Record::Tangent(deviations) => same_length("deviations", n, deviations.len())?,
        Record::Sensitivity(changes) => same_length("changes", n, changes.len())?,
        _ => {}
    }
    if let Some(step) = &step {
        same_length("step", n, step.len())?;
    }
    let times = copied_numbers("times", &given.times)?;
    let schedule = match &given.strides {
        Some(strides) => Schedule::Strides(strides),
        None => times_of_bodies(&times, given.times.shape(), n)?,
    };
    let (bodies, steps) = (&[], &[]);
    let request =
        Request { bodies, scene, forces, method, record, schedule, steps, refinement, tolerance, max_steps };
    let mut targets = Target::all(py, &request, n, out, single)?;
    let elsewhere: Vec<_> = targets.iter().map(|target| target.name).collect();
    let mut states = States::reserved(&request, n, &elsewhere)?;
    let (mut rest, mut nanoseconds) = (states.whole(), 0);
    let judged = if asked.is_some() { n } else { 0 };
    let reserved = || memory::reserved("errors of the bodies", judged);
    let mut estimates = [reserved()?, reserved()?];
    let mut series_made = memory::reserved("bodies by a series", judged)?;
    let mut turns_alone = method == AnyMethod::Exact && forces.is_none();
    for part in BodyColumns::parts(n, threads) {
        let bodies = &given.bodies.of(part.clone())?;
        turns_alone &= bodies.iter().all(|body| body.weight == [0.0; 3]);
        let own = if part.len() < n { forces.of_range(part.clone())? } else { None };
        let (forces, schedule) = (own.as_ref().unwrap_or(forces), schedule.of_range(part.clone()));
        let steps = &match (&step, method) {
            (Some(step), _) => {
                let steps = step.as_array();
                memory::collected("steps", part.len(), part.clone().map(|index| steps[index]))?
            }
            (None, AnyMethod::Steps(method)) if asked.is_none() => {
                default_steps_of(method, bodies, forces, &schedule)?
            }
            _ => Vec::new(),
        };
        let record = match record {
            Record::Tangent(deviations) => Record::Tangent(&deviations[part.clone()]),
            Record::Sensitivity(changes) => Record::Sensitivity(&changes[part.clone()]),
            record => record,
        };
        let request = &Request { bodies, forces, schedule, steps, record, ..request };
        let mut states = rest.split_off(request.schedule.len(), part.len());
        for target in &mut targets {
            states.give(target.name, target.part(part.clone())?);
        }
        let run = |stop: &Interrupt| {
            // A second run takes about as long as the run.
            let runs = 1 + usize::from(asked.is_some_and(|asked| asked.check));
            stop.expect(runs * n, runs * part.start..runs * part.end);
            let call = Call { isa, threads, stop };
            match (asked, method) {
                (Some(asked), AnyMethod::Steps(method)) => {
                    accuracy::solve(request, method, asked, states, call)
                }
                _ => Ok(Solved::unjudged(trajectory::simulate_into(request, states, call)?)),
            }
        };
        let calls = forces.of(0).function.is_some();
        let is_brief = request.is_brief() && !calls;
        let solved = if is_brief { at_once(run) } else { interruptible_calls(py, None, calls, run)? };
        let solved = solved.map_err(|error| error.of_part(part.start))?;
        nanoseconds += solved.nanoseconds;
        for (Estimate { error, lost_from }, by_series) in solved.estimates.into_iter().zip(solved.by_series) {
            estimates[0].push(error);
            estimates[1].push(lost_from);
            series_made.push(by_series);
        }
        for target in &mut targets {
            target.finish(part.clone())?;
        }
        py.check_signals()?;
    }
    let errors =
        if turns_alone { trajectory::rounding_errors(&schedule, &states.fastest_rate)? } else { None };
    let arrived = states.status.iter().all(|&status| status == Status::Finished);
    let (mut columns, mut worst) = (states.into_columns(), None);
    if asked.is_some() {
        let [error, lost_from] = estimates;
        let is_known = arrived && !error.iter().any(|error: &f64| error.is_nan());
        worst = is_known.then(|| error.iter().copied().fold(0.0, f64::max));
        columns.extend([("error", error.into()), ("lost_from", lost_from.into())]);
    }
    if let Some(errors) = errors {
        worst = arrived.then(|| errors.iter().copied().fold(0.0, f64::max));
        let never = memory::filled("times from which bodies are lost", n, f64::INFINITY)?;
        columns.extend([("error", errors.into()), ("lost_from", never.into())]);
    }
    if method != AnyMethod::Exact || worst.is_some() {
        // Errors that are known need no bounds of the rates.
        columns.retain(|(name, _)| *name != "fastest_rate");
    }
    let states = PyStates::new(py, [n, schedule.len()], columns, worst)?;
    states.insert(intern!(py, "nanoseconds"), nanoseconds)?;
    if series_made.iter().any(|&made| made) {
        states.insert(intern!(py, "by_series"), PyArray1::from_vec(py, series_made))?;
    }
    for target in targets {
        states.insert(&PyString::new(py, target.name), target.shaped()?)?;
    }
    Ok(states)
}

/// Bounds of |omega| over the whole motion, from the conserved quantities, to choose a step. With forces the bounds
/// hold between the two times of each row of `span`, or of its only row; with a method they are the rates that determine
/// its steps.
#[pyfunction]
#[pyo3(signature = (bodies, span=None, method=None))]
pub fn fastest_rates<'py>(
    py: Python<'py>,
    bodies: Bodies<'py>,
    span: Option<Aligned2<'py, f64>>,
    method: Option<&str>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let method = method.map(Method::parse).transpose()?;
    let n = bodies.len()?;
    let forces = bodies.forces(n)?;
    let spans = span.as_ref().map(|span| rows::<2>("span", span)).transpose()?.unwrap_or(&[[0.0; 2]]);
    let spans = OneOrEach::new("span", n, spans)?;
    let rate = |index: usize, body: &Body| {
        let span = spans.of(index);
        match method {
            None => body.fastest_rate(forces.of(index), span),
            Some(method) => body.step_rate(method, forces.of(index), span),
        }
    };
    let mut rates = memory::reserved("rates", n)?;
    for part in BodyColumns::parts(n, 1) {
        let bodies = bodies.of(part.clone())?;
        let own = |index: usize| Ok(rate(part.start + index, &bodies[index]));
        rates.extend(evaluated(py, "rates", bodies.len(), own)?);
    }
    Ok(of_bodies(py, rates))
}

/// The longest step of each body between two times, and the time in which equal steps of that length are as many as those of
/// the run; shape (n, 2). For states, the samples of a map, or the growth of their deviation vectors. A step that is asked for
/// takes the place of the longest one; one that is unstable is refused.
#[pyfunction]
#[pyo3(signature = (bodies, method, span, of, step=None))]
pub fn planned_steps<'py>(
    py: Python<'py>,
    bodies: Bodies<'py>,
    method: &str,
    span: Aligned2<'py, f64>,
    of: &str,
    step: Option<f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let _standard = FloatEnvironment::standard();
    let choice = AnyMethod::parse(method)?;
    let of = match of {
        "growth" => PlannedRun::Growth,
        "samples" => PlannedRun::Sample,
        _ => PlannedRun::States,
    };
    let n = bodies.len()?;
    let forces = bodies.forces(n)?;
    let spans = OneOrEach::new("span", n, rows::<2>("span", &span)?)?;
    let mut steps = memory::reserved("steps", n)?;
    for part in BodyColumns::parts(n, 1) {
        let bodies = bodies.of(part.clone())?;
        for (body, index) in bodies.iter().zip(part) {
            let (forces, span) = (forces.of(index), spans.of(index));
            let [longest, time] = choice.planned_step(of, body, forces, span);
            if let (Some(step), AnyMethod::Steps(method), false) = (step, choice, forces.is_none()) {
                trajectory::check_step(method, (n > 1).then_some(index), body, forces, step, span)?;
            }
            steps.push([step.unwrap_or(longest), time]);
        }
    }
    shaped(py, steps.into_flattened(), [n, 2])
}

/// Names of the status codes of a run, in the order of the codes.
#[pyfunction]
pub fn status_names() -> Vec<&'static str> {
    Status::ALL.into_iter().map(Status::name).collect()
}
