//! Poincaré sections and events.

use super::bodies::Bodies;
use super::convert::{Aligned1, Aligned2, column, copied, interruptible_calls, rows, same_length};
use crate::accuracy::crossings;
use crate::call::Call;
use crate::error::Error;
use crate::float_environment::FloatEnvironment;
use crate::forces::{Code, MOST_STATES, TorqueCall};
use crate::memory;
use crate::method::{AnyMethod, Method};
use crate::parallel::Interrupt;
use crate::simd::Isa;
use crate::trajectory::{
    Crossings, Point, Pointing, Record, Request, Schedule, Section, Surface, SurfaceKind, default_steps,
};
use numpy::ndarray::Array2;
use numpy::{Element, IntoPyArray, PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::array::from_fn;
use std::iter::repeat_n;

/// Numbers of a surface.
const OF_SURFACE: usize = 11 + MOST_STATES;

/// A kind of surface: whether it is of a rate, its direction, and whether its points count; two pairs of a body axis and a
/// direction, zeros without any, and whether the directions are those of the orbit; the address of a function in place of the
/// surface, 0 without any, and whether it is told eight bodies at once.
type GivenKind = (bool, i8, bool, [[[f64; 3]; 2]; 2], bool, (usize, bool));

/// The points at which bodies cross their surfaces until a time, with the errors of the times; see `rigid.poincare` and
/// `rigid.simulate`. The surfaces of each body are neighbours, each a row of the numbers of `Surface`.
#[pyfunction]
#[pyo3(signature = (bodies, *, method, kinds, surfaces, ends, count, closed, check, tolerance, max_steps, threads))]
#[allow(clippy::too_many_arguments)] // The request of `trajectory`, array by array.
pub fn section<'py>(
    py: Python<'py>,
    bodies: Bodies<'py>,
    method: &str,
    kinds: Vec<GivenKind>,
    surfaces: Aligned2<'py, f64>,
    ends: Aligned1<'py, f64>,
    count: usize,
    closed: bool,
    check: bool,
    tolerance: f64,
    max_steps: u64,
    threads: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let _standard = FloatEnvironment::standard();
    let (scene, method, isa) = (bodies.scene()?, Method::parse(method)?, Isa::current()?);
    let all = &bodies.all()?;
    let n = all.len();
    let forces = bodies.forces(n)?;
    let (numbers, ends) = (rows::<OF_SURFACE>("surfaces", &surfaces)?, copied("ends", &ends)?);
    same_length("surfaces", n * kinds.len(), numbers.len())?;
    same_length("ends", n, ends.len())?;
    let surface = |row: &[f64; OF_SURFACE]| Surface {
        normal: from_fn(|k| row[k]),
        momentum: from_fn(|k| row[6 + k]),
        square: row[9],
        states: from_fn(|k| row[10 + k]),
        value: row[10 + MOST_STATES],
    };
    let surfaces = &memory::collected("surfaces", numbers.len(), numbers.iter().map(surface))?;
    let kind = |&(of_rate, direction, counts, pairs, in_orbit, (address, is_of_eight)): &GivenKind| {
        let pointing = (pairs[0][0] != [0.0; 3]).then_some(Pointing { pairs, in_orbit });
        let code = Code { address, is_of_eight, is_long: true };
        // SAFETY: what `rigid.crosses` asks of its caller.
        let function = (address > 0).then(|| unsafe { TorqueCall::without_numbers(code) });
        SurfaceKind { of_rate, direction, counts, pointing, function }
    };
    let kinds = &memory::collected("surfaces", kinds.len(), kinds.iter().map(kind))?;
    let schedule = Schedule::TimesOfEach(&ends, 1);
    let steps = &default_steps(method, all, forces, &schedule)?;
    let request = Request {
        bodies: all,
        scene,
        forces,
        method: AnyMethod::Steps(method),
        record: Record::Attitude,
        schedule,
        steps,
        refinement: 1.0,
        tolerance: Some(tolerance),
        max_steps,
    };
    let section = Section { kinds, surfaces, count, closed };
    let run = |stop: &Interrupt| crossings(&request, method, &section, check, Call { isa, threads, stop });
    let calls = forces.of(0).function.is_some() || kinds.iter().any(|kind| kind.function.is_some());
    to_dict(py, &interruptible_calls(py, None, calls, run)??, (kinds.len(), forces.states_of_function()))
}

/// The columns of the points and of the bodies, for so many kinds of surfaces and states.
fn to_dict<'py>(
    py: Python<'py>,
    all: &[Crossings],
    (kinds, states): (usize, usize),
) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    let count = all.iter().map(|own| own.points.len()).sum::<usize>();
    let points = || all.iter().flat_map(|own| &own.points);
    let flat = |width: usize, number: fn(&Point, usize) -> f64| -> Result<Array2<f64>, Error> {
        let numbers = points().flat_map(|point| (0..width).map(move |k| number(point, k)));
        let numbers = memory::collected("points of a section", count * width, numbers)?;
        Ok(Array2::from_shape_vec([count, width], numbers).expect("as many as counted"))
    };
    dict.set_item("omega", flat(3, |point, k| point.omega[k])?.into_pyarray(py))?;
    dict.set_item("gamma", flat(3, |point, k| point.gamma[k])?.into_pyarray(py))?;
    dict.set_item("attitude", flat(4, |point, k| point.attitude[k])?.into_pyarray(py))?;
    dict.set_item("states", flat(states, |point, k| point.states[k])?.into_pyarray(py))?;
    dict.set_item("t", of_points(py, all, |point| point.time)?)?;
    dict.set_item("slope", of_points(py, all, |point| point.slope / point.share)?)?;
    dict.set_item("error", of_points(py, all, |point| point.error)?)?;
    dict.set_item("kind", of_points(py, all, |point| point.kind)?)?;
    dict.set_item("direction", of_points(py, all, |point| point.direction)?)?;
    dict.set_item("grazing", of_points(py, all, |point| point.grazes)?)?;
    let body = all.iter().enumerate().flat_map(|(body, own)| repeat_n(body as isize, own.points.len()));
    dict.set_item("body", memory::collected("points", count, body)?.into_pyarray(py))?;
    let complete = all.iter().map(Crossings::doubtful);
    let complete = complete.flat_map(|doubtful| (0..kinds).map(move |kind| doubtful >> kind & 1 == 0));
    let complete = memory::collected("bodies", all.len() * kinds, complete)?;
    dict.set_item("complete", complete.into_pyarray(py).reshape([all.len(), kinds])?)?;
    dict.set_item("lost_from", column(py, all, |own| own.lost_from)?)?;
    dict.set_item("status", column(py, all, |own| own.status as u8)?)?;
    dict.set_item("stays", column(py, all, |own| own.stays)?)?;
    dict.set_item("stopped", column(py, all, |own| own.stopped)?)?;
    dict.set_item("energy_drift", column(py, all, |own| own.energy_drift)?)?;
    dict.set_item("end", column(py, all, |own| own.end)?)?;
    dict.set_item("steps", column(py, all, |own| own.steps)?)?;
    Ok(dict)
}

/// An array of one number of each point.
fn of_points<'py, N: Element>(
    py: Python<'py>,
    all: &[Crossings],
    of: fn(&Point) -> N,
) -> PyResult<Bound<'py, PyArray1<N>>> {
    let count = all.iter().map(|own| own.points.len()).sum();
    let numbers = all.iter().flat_map(|own| &own.points).map(of);
    Ok(memory::collected("points", count, numbers)?.into_pyarray(py))
}
