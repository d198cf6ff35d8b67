//! The derived quantities of closed forms and the elliptic functions, array by array.

use super::bodies::Bodies;
use super::convert::{
    Aligned1, Aligned2, OneOrEach, bodies, column, copied, evaluated, of_rows, rows, same_length,
};
use super::states::{of_bodies, shaped};
use crate::error::Error;
use crate::exact::derived::{
    FreeQuantities, TopQuantities, free_quantities, saddle, sign_change_time, sign_changes, tilt_time,
    top_quantities,
};
use crate::exact::{CanonicalForm, ClosedForm, Question, lagrange_axis};
use crate::float_environment::FloatEnvironment;
use crate::memory;
use crate::simd::Isa;
use crate::special::{agm, carlson_rc, carlson_rd, carlson_rf, carlson_rj};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods};
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};

/// The names of the codes of closed forms, in their order; that of none is empty.
#[pyfunction]
pub fn closed_form_names() -> Vec<&'static str> {
    std::iter::once("").chain(ClosedForm::ALL.map(ClosedForm::name)).collect()
}

/// The code of the closed form of each body.
#[pyfunction]
pub fn closed_forms<'py>(py: Python<'py>, bodies: Bodies<'py>) -> PyResult<Bound<'py, PyArray1<u8>>> {
    let bodies = bodies.all()?;
    let code =
        |index: usize| Ok(ClosedForm::code(CanonicalForm::of(&bodies[index]).map(|form| form.closed_form)));
    Ok(evaluated(py, "closed forms", bodies.len(), code)?.into_pyarray(py))
}

/// The code of the closed form that applies to a question for each body from any start; a row of moments or weight may
/// be that of all. The question is "states",
/// "regular", "no_flip" or "tilt_from_vertical"; the last two need a body axis, 1 to 3, which is optional for
/// "no_flip".
#[pyfunction]
#[pyo3(signature = (question, moments, weight, axis=None))]
pub fn closed_forms_for<'py>(
    py: Python<'py>,
    question: &str,
    moments: &Bound<'py, PyArray2<f64>>,
    weight: &Bound<'py, PyArray2<f64>>,
    axis: Option<usize>,
) -> PyResult<Bound<'py, PyArray1<u8>>> {
    let index = |axis: usize| {
        let wrong = || Error::value("axis", axis, "must be 1, 2 or 3");
        (1..=3).contains(&axis).then(|| axis - 1).ok_or_else(wrong)
    };
    let axis = axis.map(index).transpose()?;
    let question = match (question, axis) {
        ("states", _) => Question::States,
        ("regular", _) => Question::Regular,
        ("no_flip", axis) => Question::NoFlip(axis),
        ("tilt_from_vertical", Some(axis)) => Question::TiltFromVertical(axis),
        ("tilt_from_vertical", None) => {
            return Err(Error::value("axis", "None", "the tilt of an axis needs the axis").into());
        }
        _ => {
            let known = "states, no_flip, tilt_from_vertical, regular".into();
            return Err(Error::Unknown { argument: "question", value: question.into(), known }.into());
        }
    };
    let codes = of_rows("moments", moments, |moments| {
        of_rows("weight", weight, |weight| codes_of(question, moments, weight))
    })?;
    Ok(of_bodies(py, codes))
}

/// The closed form of each body, or 0.
fn codes_of(question: Question, moments: &[[f64; 3]], weight: &[[f64; 3]]) -> PyResult<Vec<u8>> {
    let n = if moments.len() == 1 { weight.len() } else { moments.len() };
    let (moments, weight) = (OneOrEach::new("moments", n, moments)?, OneOrEach::new("weight", n, weight)?);
    let code =
        |body: usize| ClosedForm::code(ClosedForm::answering(question, moments.of(body), weight.of(body)));
    Ok(memory::collected("closed forms", n, (0..n).map(code))?)
}

/// The symmetry axis 1, 2 or 3 of each Lagrange top, 0 for any other body.
#[pyfunction]
pub fn lagrange_axes<'py>(
    py: Python<'py>,
    moments: Aligned2<'py, f64>,
    weight: Aligned2<'py, f64>,
) -> PyResult<Bound<'py, PyArray1<i64>>> {
    let _standard = FloatEnvironment::standard();
    let (moments, weight) = (rows::<3>("moments", &moments)?, rows::<3>("weight", &weight)?);
    same_length("weight", moments.len(), weight.len())?;
    let axis = |(&moments, &weight)| lagrange_axis(moments, weight).map_or(0, |axis| axis as i64 + 1);
    let axes = memory::collected("axes", moments.len(), moments.iter().zip(weight).map(axis))?;
    Ok(axes.into_pyarray(py))
}

/// Periods, amplitudes and precession of free bodies.
#[pyfunction]
#[pyo3(name = "free_quantities")]
pub fn free_quantities_of<'py>(
    py: Python<'py>,
    moments: &Bound<'py, PyArray2<f64>>,
    omega: &Bound<'py, PyArray2<f64>>,
) -> PyResult<Bound<'py, PyDict>> {
    let isa = Isa::current()?;
    let bodies = of_rows("moments", moments, |moments| {
        of_rows("omega", omega, |omega| bodies(moments, &[[0.0; 3]], omega, &[[1.0, 0.0, 0.0, 0.0]]))
    })?;
    let quantities = |index: usize| Ok(free_quantities(isa, &bodies[index]));
    let all = evaluated(py, "quantities of free bodies", bodies.len(), quantities)?;
    let dict = PyDict::new(py);
    let number = |name: &Bound<'py, PyString>, of: fn(&FreeQuantities) -> f64| {
        let values = memory::collected("quantities of free bodies", all.len(), all.iter().map(of))?;
        dict.set_item(name, of_bodies(py, values))
    };
    let axes = memory::collected("axes", all.len(), all.iter().map(|q| q.axis))?;
    dict.set_item(intern!(py, "axis"), of_bodies(py, axes))?;
    number(intern!(py, "m"), |q| q.parameter[0])?;
    number(intern!(py, "mc"), |q| q.parameter[1])?;
    number(intern!(py, "period"), FreeQuantities::period)?;
    number(intern!(py, "flip_time"), |q| q.flip_time)?;
    number(intern!(py, "precession"), |q| q.precession)?;
    number(intern!(py, "turn"), FreeQuantities::turn)?;
    let amplitude = memory::collected("amplitudes", all.len(), all.iter().map(|q| q.amplitude))?;
    dict.set_item(intern!(py, "amplitude"), shaped(py, amplitude.into_flattened(), [all.len(), 3])?)?;
    Ok(dict)
}

/// Times of the first sign changes of a component of the rates, by default of the largest of each body.
#[pyfunction]
#[pyo3(signature = (bodies, axis, count))]
pub fn flip_times<'py>(
    py: Python<'py>,
    bodies: Bodies<'py>,
    axis: Option<usize>,
    count: usize,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    if !axis.is_none_or(|axis| (1..=3).contains(&axis)) {
        let rule = "must be 1, 2 or 3";
        return Err(Error::value("axis", axis.map_or_else(String::new, |axis| axis.to_string()), rule).into());
    }
    let isa = Isa::current()?;
    let bodies = bodies.all()?;
    let what = "flip times";
    let bytes = (bodies.len() as u128).saturating_mul(count as u128).saturating_mul(8);
    let length = bodies.len().checked_mul(count);
    let length = length.ok_or_else(|| Error::Memory { what: what.into(), bytes, limit: None })?;
    memory::check(what, bytes)?;
    let changes = evaluated(py, what, bodies.len(), |pixel| {
        let body = &bodies[pixel];
        let axis = match axis {
            Some(axis) => axis - 1,
            None => largest(body.omega).ok_or_else(|| {
                Error::value("omega", format_args!("{:?}", body.omega), "has no single largest component")
            })?,
        };
        ClosedForm::answering(Question::NoFlip(Some(axis)), body.moments, body.weight)
            .and_then(|_| sign_changes(isa, body, axis))
            .ok_or(Error::NoClosedClassification { pixel, rule: Question::RULE_OF_CLASSES })
    })?;
    let time = |index| Ok(sign_change_time(changes[index / count], index % count));
    shaped(py, evaluated(py, what, length, time)?, [bodies.len(), count])
}

/// The component of the largest size; `None` if there are two.
fn largest(vector: [f64; 3]) -> Option<usize> {
    let sizes = vector.map(f64::abs);
    let alone = |&k: &usize| (0..3).all(|other| other == k || sizes[other] < sizes[k]);
    (0..3).find(alone)
}

/// How near each body is to the separatrix of its closed form: complementary parameter, and the rate of the saddle.
#[pyfunction]
pub fn saddles<'py>(py: Python<'py>, bodies: Bodies<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let isa = Isa::current()?;
    let bodies = bodies.all()?;
    let all = evaluated(py, "saddles", bodies.len(), |index| Ok(saddle(isa, &bodies[index])))?;
    all.into_flattened().into_pyarray(py).reshape([bodies.len(), 2])
}

/// Turning points, period and advances of symmetric tops.
#[pyfunction]
#[pyo3(name = "top_quantities")]
pub fn top_quantities_of<'py>(py: Python<'py>, bodies: Bodies<'py>) -> PyResult<Bound<'py, PyDict>> {
    let isa = Isa::current()?;
    let bodies = bodies.all()?;
    let quantities = |index: usize| {
        let none = Error::NoClosedForm { index, rule: Question::RULE_OF_STATES };
        top_quantities(isa, &bodies[index]).ok_or(none)
    };
    let all = evaluated(py, "quantities of tops", bodies.len(), quantities)?;
    let dict = PyDict::new(py);
    let number = |of: fn(&TopQuantities) -> f64| column(py, &all, of);
    dict.set_item("tilt_min", number(|q| q.tilt[0])?)?;
    dict.set_item("tilt_max", number(|q| q.tilt[1])?)?;
    dict.set_item("period", number(|q| q.period)?)?;
    dict.set_item("precession_advance", number(|q| q.advance[0])?)?;
    dict.set_item("spin_advance", number(|q| q.advance[1])?)?;
    dict.set_item("precession", number(TopQuantities::precession)?)?;
    dict.set_item("mc", number(|q| q.mc)?)?;
    dict.set_item("kind", memory::collected("kinds", all.len(), all.iter().map(|q| q.kind))?)?;
    let retrograde = |index: usize| Ok(all[index].is_retrograde(&bodies[index]));
    dict.set_item("retrograde", evaluated(py, "tops", all.len(), retrograde)?.into_pyarray(py))?;
    Ok(dict)
}

/// First times at which symmetric tops reach a tilt.
#[pyfunction]
pub fn tilt_times<'py>(
    py: Python<'py>,
    bodies: Bodies<'py>,
    limit: f64,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let isa = Isa::current()?;
    let bodies = bodies.all()?;
    let time = |index: usize| {
        let none = Error::NoClosedForm { index, rule: Question::RULE_OF_STATES };
        tilt_time(isa, &bodies[index], limit).ok_or(none)
    };
    Ok(evaluated(py, "tilt times", bodies.len(), time)?.into_pyarray(py))
}

/// An elliptic function of arrays of equal length; `jacobi` gives three arrays, the others one.
#[pyfunction]
pub fn elliptic<'py>(
    py: Python<'py>,
    name: &str,
    arguments: Vec<Aligned1<'py, f64>>,
) -> PyResult<Vec<Bound<'py, PyArray1<f64>>>> {
    let n = arguments.first().map_or(0, |argument| argument.as_array().len());
    for argument in &arguments {
        same_length("arguments", n, argument.as_array().len())?;
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
    same_length("arguments", wanted, arguments.len())?;
    // Copies: without the lock other threads may write to the arrays.
    let mut columns = Vec::with_capacity(wanted);
    for argument in &arguments {
        columns.push(copied("arguments", argument)?);
    }
    let x = |k: usize, i: usize| columns[k][i];
    let one = |of: &(dyn Fn(usize) -> f64 + Sync)| {
        PyResult::Ok(vec![evaluated(py, "values", n, |i| Ok(of(i)))?.into_pyarray(py)])
    };
    match name {
        "rf" => one(&|i| carlson_rf(x(0, i), x(1, i), x(2, i))),
        "rc" => one(&|i| carlson_rc(x(0, i), x(1, i))),
        "rd" => one(&|i| carlson_rd(x(0, i), x(1, i), x(2, i))),
        "rj" => one(&|i| carlson_rj(x(0, i), x(1, i), x(2, i), x(3, i))),
        "agm" => one(&|i| agm(x(0, i), x(1, i))),
        "complete_k" => one(&|i| crate::special::complete_k(x(0, i))),
        _ => {
            let all = evaluated(py, "values", n, |i| Ok(crate::special::jacobi(x(0, i), x(1, i))))?;
            Ok(vec![column(py, &all, |s| s.0)?, column(py, &all, |s| s.1)?, column(py, &all, |s| s.2)?])
        }
    }
}
