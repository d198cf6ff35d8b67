//! Poincaré sections and events.

use super::bodies::Bodies;
use super::convert::{Aligned1, Aligned2, column, copied, interruptible_calls, rows, same_length};
use crate::call::Call;
use crate::error::Error;
use crate::float_environment::FloatEnvironment;
use crate::forces::{Code, MOST_STATES, TorqueCall};
use crate::memory;
use crate::method::{AnyMethod, Method, default_step};
use crate::parallel::Interrupt;
use crate::simd::Isa;
use crate::trajectory::{
    self, Crossings, Point, Pointing, Record, Request, Schedule, Section, Surface, SurfaceKind,
};
use numpy::ndarray::Array2;
use numpy::{Element, IntoPyArray, PyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::array::from_fn;

/// Numbers of a surface.
const OF_SURFACE: usize = 11 + MOST_STATES;

/// The points at which bodies cross their surfaces until a time; see `rigid.poincare` and `rigid.simulate`. A kind of
/// surface is whether it is of a rate, its direction, and whether its points count, with its row of `pointing`: two pairs of
/// a body axis and a direction, zeros without any, and 1 if the directions are those of the orbit; and with the address of a
/// function in place of the surface and whether it is told eight bodies at once, 0 without any. The surfaces of each body are
/// neighbours, each a row of the numbers of `Surface`.
#[pyfunction]
#[pyo3(signature = (bodies, *, method, kinds, pointing, functions, surfaces, ends, count, closed, tolerance, max_steps, threads))]
#[allow(clippy::too_many_arguments)] // The request of `trajectory`, array by array.
pub fn section<'py>(
    py: Python<'py>,
    bodies: Bodies<'py>,
    method: &str,
    kinds: Vec<(bool, i8, bool)>,
    pointing: Aligned2<'py, f64>,
    functions: Vec<(usize, bool)>,
    surfaces: Aligned2<'py, f64>,
    ends: Aligned1<'py, f64>,
    count: usize,
    closed: bool,
    tolerance: f64,
    max_steps: u64,
    threads: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let _standard = FloatEnvironment::standard();
    let (scene, method, isa) = (bodies.scene()?, Method::parse(method)?, Isa::current()?);
    let given = &bodies.all()?;
    let n = given.len();
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
    let kind = |((&(of_rate, direction, counts), row), (address, is_of_eight))| {
        let row: &[f64; 13] = row;
        let [first, second, third, fourth] =
            [0, 1, 2, 3].map(|k| [row[3 * k], row[3 * k + 1], row[3 * k + 2]]);
        let pairs = [[first, second], [third, fourth]];
        let pointing = (first != [0.0; 3]).then_some(Pointing { pairs, in_orbit: row[12] != 0.0 });
        let code = Code { address, is_of_eight, is_long: true };
        // SAFETY: what `rigid.crosses` asks of its caller.
        let function = (address > 0).then(|| unsafe { TorqueCall::without_numbers(code) });
        SurfaceKind { of_rate, direction, counts, pointing, function }
    };
    let pointings = rows::<13>("pointing", &pointing)?;
    same_length("pointing", kinds.len(), pointings.len())?;
    same_length("functions", kinds.len(), functions.len())?;
    let kinds = kinds.iter().zip(pointings).zip(functions).map(kind);
    let kinds = &memory::collected("surfaces", pointings.len(), kinds)?;
    let bodies = given;
    let own = bodies.iter().zip(&ends).enumerate();
    let own =
        own.map(|(i, (body, &end))| default_step(method, body.step_rate(method, forces.of(i), [0.0, end])));
    let steps = &memory::collected("steps", n, own)?;
    let request = Request {
        bodies,
        scene,
        forces,
        method: AnyMethod::Steps(method),
        record: Record::Attitude,
        schedule: Schedule::TimesOfEach(&ends, 1),
        steps,
        refinement: 1.0,
        tolerance: Some(tolerance),
        max_steps,
    };
    let section = Section { kinds, surfaces, count, ends: &ends, closed };
    let run = |stop: &Interrupt| {
        stop.expect(n, 0..n);
        trajectory::section(&request, method, &section, Call { isa, threads, stop })
    };
    let calls = forces.of(0).function.is_some() || kinds.iter().any(|kind| kind.function.is_some());
    to_dict(py, &interruptible_calls(py, None, calls, run)??)
}

fn to_dict<'py>(py: Python<'py>, all: &[Crossings]) -> PyResult<Bound<'py, PyDict>> {
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
    dict.set_item("states", flat(MOST_STATES, |point, k| point.states[k])?.into_pyarray(py))?;
    dict.set_item("t", of_points(py, all, |point| point.time)?)?;
    dict.set_item("slope", of_points(py, all, |point| point.slope)?)?;
    dict.set_item("kind", of_points(py, all, |point| point.kind)?)?;
    dict.set_item("direction", of_points(py, all, |point| point.direction)?)?;
    dict.set_item("grazing", of_points(py, all, |point| point.grazes)?)?;
    dict.set_item("points", column(py, all, |own| own.points.len() as u64)?)?;
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
