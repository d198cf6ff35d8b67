//! The derived quantities of closed forms and the elliptic functions, array by array.

use super::{bodies, parse_scene, rows, same_length};
use crate::error::Error;
use crate::exact::derived::{TopQuantities, free_quantities, sign_changes, tilt_time, top_quantities};
use crate::simd::Isa;
use crate::special::{agm, carlson_rc, carlson_rd, carlson_rf, carlson_rj};
use crate::start::Body;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Bodies from the columns of a request.
fn bodies_of(
    moments: &PyReadonlyArray2<'_, f64>,
    weight: &PyReadonlyArray2<'_, f64>,
    omega: &PyReadonlyArray2<'_, f64>,
    attitude: &PyReadonlyArray2<'_, f64>,
) -> PyResult<Vec<Body>> {
    bodies(
        rows::<3>("moments", moments)?,
        rows::<3>("weight", weight)?,
        rows::<3>("omega", omega)?,
        rows::<4>("attitude", attitude)?,
    )
}

/// Periods, amplitudes and precession of free bodies.
#[pyfunction]
#[pyo3(name = "free_quantities", signature = (*, moments, omega))]
pub fn free_quantities_of<'py>(
    py: Python<'py>,
    moments: PyReadonlyArray2<'py, f64>,
    omega: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let isa = Isa::current()?;
    let bodies = bodies(
        rows::<3>("moments", &moments)?,
        &[[0.0; 3]],
        rows::<3>("omega", &omega)?,
        &[[1.0, 0.0, 0.0, 0.0]],
    )?;
    let all: Vec<_> = bodies.iter().map(|body| free_quantities(isa, body)).collect();
    let dict = PyDict::new(py);
    let column = |of: fn(&crate::exact::derived::FreeQuantities) -> f64| -> Bound<'py, PyArray1<f64>> {
        all.iter().map(of).collect::<Vec<f64>>().into_pyarray(py)
    };
    dict.set_item("axis", all.iter().map(|q| q.axis).collect::<Vec<i8>>().into_pyarray(py))?;
    dict.set_item("m", column(|q| q.parameter[0]))?;
    dict.set_item("mc", column(|q| q.parameter[1]))?;
    dict.set_item("period", column(|q| 2.0 * q.flip_time))?;
    dict.set_item("flip_time", column(|q| q.flip_time))?;
    dict.set_item("precession", column(|q| q.precession))?;
    let turn = column(|q| if q.precession == 0.0 { 0.0 } else { 2.0 * q.flip_time * q.precession });
    dict.set_item("turn", turn)?;
    let amplitude: Vec<f64> = all.iter().flat_map(|q| q.amplitude).collect();
    dict.set_item("amplitude", amplitude.into_pyarray(py).reshape([all.len(), 3])?)?;
    Ok(dict)
}

/// Times of the first sign changes of a component of the rates.
#[pyfunction]
#[pyo3(signature = (*, scene, moments, weight, omega, attitude, axis, count))]
#[allow(clippy::too_many_arguments)] // The columns of a request.
pub fn flip_times<'py>(
    py: Python<'py>,
    scene: &str,
    moments: PyReadonlyArray2<'py, f64>,
    weight: PyReadonlyArray2<'py, f64>,
    omega: PyReadonlyArray2<'py, f64>,
    attitude: PyReadonlyArray2<'py, f64>,
    axis: usize,
    count: usize,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    parse_scene(scene)?;
    if !(1..=3).contains(&axis) {
        let rule = "must be 1, 2 or 3";
        return Err(Error::Value { argument: "axis", value: axis.to_string(), rule }.into());
    }
    let isa = Isa::current()?;
    let bodies = bodies_of(&moments, &weight, &omega, &attitude)?;
    let mut times = Vec::with_capacity(bodies.len() * count);
    for (index, body) in bodies.iter().enumerate() {
        let [first, interval] =
            sign_changes(isa, body, axis - 1).ok_or(Error::NoClosedVerdict { pixel: index })?;
        let never = first == f64::INFINITY;
        times.extend((0..count).map(|k| if never || k == 0 { first } else { first + k as f64 * interval }));
    }
    times.into_pyarray(py).reshape([bodies.len(), count])
}

/// Turning points, period and advances of symmetric tops.
#[pyfunction]
#[pyo3(name = "top_quantities", signature = (*, moments, weight, omega, attitude))]
pub fn top_quantities_of<'py>(
    py: Python<'py>,
    moments: PyReadonlyArray2<'py, f64>,
    weight: PyReadonlyArray2<'py, f64>,
    omega: PyReadonlyArray2<'py, f64>,
    attitude: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let isa = Isa::current()?;
    let bodies = bodies_of(&moments, &weight, &omega, &attitude)?;
    let quantities = |(index, body)| top_quantities(isa, body).ok_or(Error::NoClosedForm { index });
    let all: Vec<TopQuantities> = bodies.iter().enumerate().map(quantities).collect::<Result<_, _>>()?;
    let dict = PyDict::new(py);
    let column = |of: fn(&TopQuantities) -> f64| -> Bound<'py, PyArray1<f64>> {
        all.iter().map(of).collect::<Vec<f64>>().into_pyarray(py)
    };
    dict.set_item("tilt_min", column(|q| q.tilt[0]))?;
    dict.set_item("tilt_max", column(|q| q.tilt[1]))?;
    dict.set_item("period", column(|q| q.period))?;
    dict.set_item("precession_advance", column(|q| q.advance[0]))?;
    dict.set_item("spin_advance", column(|q| q.advance[1]))?;
    dict.set_item("precession", column(|q| q.advance[0] / q.period))?;
    dict.set_item("mc", column(|q| q.mc))?;
    dict.set_item("kind", all.iter().map(|q| q.kind).collect::<Vec<_>>())?;
    let retrograde = |(q, body): (&TopQuantities, &Body)| {
        let along: f64 = (0..3).map(|k| body.omega[k] * body.weight[k]).sum();
        q.advance[0] * along < 0.0
    };
    let retrograde: Vec<bool> = all.iter().zip(&bodies).map(retrograde).collect();
    dict.set_item("retrograde", retrograde.into_pyarray(py))?;
    Ok(dict)
}

/// First times at which symmetric tops reach a tilt.
#[pyfunction]
#[pyo3(signature = (*, moments, weight, omega, attitude, limit))]
pub fn tilt_times<'py>(
    py: Python<'py>,
    moments: PyReadonlyArray2<'py, f64>,
    weight: PyReadonlyArray2<'py, f64>,
    omega: PyReadonlyArray2<'py, f64>,
    attitude: PyReadonlyArray2<'py, f64>,
    limit: f64,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let isa = Isa::current()?;
    let bodies = bodies_of(&moments, &weight, &omega, &attitude)?;
    let time = |(index, body)| tilt_time(isa, body, limit).ok_or(Error::NoClosedForm { index });
    let times: Vec<f64> = bodies.iter().enumerate().map(time).collect::<Result<_, _>>()?;
    Ok(times.into_pyarray(py))
}

/// An elliptic function of arrays of equal length; `jacobi` gives three arrays, the others one.
#[pyfunction]
pub fn elliptic<'py>(
    py: Python<'py>,
    name: &str,
    arguments: Vec<PyReadonlyArray1<'py, f64>>,
) -> PyResult<Vec<Bound<'py, PyArray1<f64>>>> {
    let columns: Vec<_> = arguments.iter().map(|column| column.as_array()).collect();
    let n = columns.first().map_or(0, |column| column.len());
    for column in &columns {
        same_length("arguments", n, column.len())?;
    }
    let wanted = match name {
        "complete_k" => 1,
        "rc" | "agm" | "jacobi" => 2,
        "rf" | "rd" => 3,
        "rj" => 4,
        _ => {
            let known = "rf, rc, rd, rj, agm, jacobi, complete_k".into();
            return Err(Error::Unknown { argument: "name", value: name.into(), known }.into());
        }
    };
    same_length("arguments", wanted, columns.len())?;
    let x = |k: usize, i: usize| columns[k][i];
    let one = |of: &dyn Fn(usize) -> f64| vec![(0..n).map(of).collect::<Vec<f64>>().into_pyarray(py)];
    Ok(match name {
        "rf" => one(&|i| carlson_rf(x(0, i), x(1, i), x(2, i))),
        "rc" => one(&|i| carlson_rc(x(0, i), x(1, i))),
        "rd" => one(&|i| carlson_rd(x(0, i), x(1, i), x(2, i))),
        "rj" => one(&|i| carlson_rj(x(0, i), x(1, i), x(2, i), x(3, i))),
        "agm" => one(&|i| agm(x(0, i), x(1, i))),
        "complete_k" => one(&|i| crate::special::complete_k(x(0, i))),
        _ => {
            let all: Vec<(f64, f64, f64)> =
                (0..n).map(|i| crate::special::jacobi(x(0, i), x(1, i))).collect();
            let part =
                |of: fn(&(f64, f64, f64)) -> f64| all.iter().map(of).collect::<Vec<f64>>().into_pyarray(py);
            vec![part(|s| s.0), part(|s| s.1), part(|s| s.2)]
        }
    })
}
