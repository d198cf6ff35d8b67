//! The derived quantities of closed forms and the elliptic functions, array by array.

use super::convert::{bodies, rows, same_length};
use crate::error::Error;
use crate::exact::derived::{
    FreeQuantities, TopQuantities, free_quantities, saddle, sign_change_times, tilt_time, top_quantities,
};
use crate::exact::{CanonicalForm, ClosedForm, Question, lagrange_axis};
use crate::scene::Scene;
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

/// The name of the closed form of each body, empty if the body has none.
#[pyfunction]
#[pyo3(signature = (*, scene, moments, weight, omega, attitude))]
pub fn closed_forms(
    scene: &str,
    moments: PyReadonlyArray2<'_, f64>,
    weight: PyReadonlyArray2<'_, f64>,
    omega: PyReadonlyArray2<'_, f64>,
    attitude: PyReadonlyArray2<'_, f64>,
) -> PyResult<Vec<&'static str>> {
    Scene::parse(scene)?;
    let bodies = bodies(
        rows::<3>("moments", &moments)?,
        rows::<3>("weight", &weight)?,
        rows::<3>("omega", &omega)?,
        rows::<4>("attitude", &attitude)?,
    )?;
    Ok(bodies.iter().map(|body| CanonicalForm::of(body).map_or("", |form| form.closed_form.name())).collect())
}

/// The name of the closed form that applies to a question for each body from any start, empty if there is none. The
/// question is "states", "no_flip" or "tilt_from_vertical"; the last two need a body axis, 1 to 3, which is optional
/// for "no_flip".
#[pyfunction]
#[pyo3(signature = (question, *, moments, weight, axis=None))]
pub fn closed_forms_for(
    question: &str,
    moments: PyReadonlyArray2<'_, f64>,
    weight: PyReadonlyArray2<'_, f64>,
    axis: Option<usize>,
) -> PyResult<Vec<&'static str>> {
    let index = |axis: usize| {
        let rule = "must be 1, 2 or 3";
        let wrong = || Error::Value { argument: "axis", value: axis.to_string(), rule };
        (1..=3).contains(&axis).then(|| axis - 1).ok_or_else(wrong)
    };
    let axis = axis.map(index).transpose()?;
    let question = match (question, axis) {
        ("states", _) => Question::States,
        ("no_flip", axis) => Question::NoFlip(axis),
        ("tilt_from_vertical", Some(axis)) => Question::TiltFromVertical(axis),
        ("tilt_from_vertical", None) => {
            let rule = "the tilt of an axis needs the axis";
            return Err(Error::Value { argument: "axis", value: "None".into(), rule }.into());
        }
        _ => {
            let known = "states, no_flip, tilt_from_vertical".into();
            return Err(Error::Unknown { argument: "question", value: question.into(), known }.into());
        }
    };
    let (moments, weight) = (rows::<3>("moments", &moments)?, rows::<3>("weight", &weight)?);
    same_length("weight", moments.len(), weight.len())?;
    let name =
        |(&moments, &weight)| ClosedForm::answering(question, moments, weight).map_or("", ClosedForm::name);
    Ok(moments.iter().zip(weight).map(name).collect())
}

/// The symmetry axis 1, 2 or 3 of each Lagrange top, 0 for any other body.
#[pyfunction]
pub fn lagrange_axes<'py>(
    py: Python<'py>,
    moments: PyReadonlyArray2<'py, f64>,
    weight: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray1<i64>>> {
    let (moments, weight) = (rows::<3>("moments", &moments)?, rows::<3>("weight", &weight)?);
    same_length("weight", moments.len(), weight.len())?;
    let axis = |(&moments, &weight)| lagrange_axis(moments, weight).map_or(0, |axis| axis as i64 + 1);
    Ok(moments.iter().zip(weight).map(axis).collect::<Vec<i64>>().into_pyarray(py))
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
    let column = |of: fn(&FreeQuantities) -> f64| -> Bound<'py, PyArray1<f64>> {
        all.iter().map(of).collect::<Vec<f64>>().into_pyarray(py)
    };
    dict.set_item("axis", all.iter().map(|q| q.axis).collect::<Vec<i8>>().into_pyarray(py))?;
    dict.set_item("m", column(|q| q.parameter[0]))?;
    dict.set_item("mc", column(|q| q.parameter[1]))?;
    dict.set_item("period", column(FreeQuantities::period))?;
    dict.set_item("flip_time", column(|q| q.flip_time))?;
    dict.set_item("precession", column(|q| q.precession))?;
    dict.set_item("turn", column(FreeQuantities::turn))?;
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
    Scene::parse(scene)?;
    if !(1..=3).contains(&axis) {
        let rule = "must be 1, 2 or 3";
        return Err(Error::Value { argument: "axis", value: axis.to_string(), rule }.into());
    }
    let isa = Isa::current()?;
    let bodies = bodies_of(&moments, &weight, &omega, &attitude)?;
    let mut times = Vec::with_capacity(bodies.len() * count);
    for (index, body) in bodies.iter().enumerate() {
        let changes = sign_change_times(isa, body, axis - 1, count);
        times.extend(
            changes.ok_or(Error::NoClosedClassification { pixel: index, rule: Question::RULE_OF_CLASSES })?,
        );
    }
    times.into_pyarray(py).reshape([bodies.len(), count])
}

/// How near each body is to the separatrix of its closed form: complementary parameter, and the rate of the saddle.
#[pyfunction]
#[pyo3(signature = (*, moments, weight, omega, attitude))]
pub fn saddles<'py>(
    py: Python<'py>,
    moments: PyReadonlyArray2<'py, f64>,
    weight: PyReadonlyArray2<'py, f64>,
    omega: PyReadonlyArray2<'py, f64>,
    attitude: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let isa = Isa::current()?;
    let bodies = bodies_of(&moments, &weight, &omega, &attitude)?;
    let all: Vec<f64> = bodies.iter().flat_map(|body| saddle(isa, body)).collect();
    all.into_pyarray(py).reshape([bodies.len(), 2])
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
    let quantities = |(index, body)| {
        top_quantities(isa, body).ok_or(Error::NoClosedForm { index, rule: Question::RULE_OF_STATES })
    };
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
    dict.set_item("precession", column(TopQuantities::precession))?;
    dict.set_item("mc", column(|q| q.mc))?;
    dict.set_item("kind", all.iter().map(|q| q.kind).collect::<Vec<_>>())?;
    let retrograde: Vec<bool> = all.iter().zip(&bodies).map(|(q, body)| q.is_retrograde(body)).collect();
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
    let time = |(index, body)| {
        tilt_time(isa, body, limit).ok_or(Error::NoClosedForm { index, rule: Question::RULE_OF_STATES })
    };
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
