//! The bindings for Python: arrays in, arrays out. No mathematics.

mod bodies;
mod convert;
mod estimate;
mod exact;
mod forces;
mod growth;
mod map;
mod motion;
mod section;
mod simulate;
mod states;
mod target;
mod unraisable;

use crate::body::unit_quaternion;
use crate::error::Error;
use crate::float_environment::FloatEnvironment;
use crate::inertia::{self, MomentStatus, excess, nearest_possible as nearest_of, principal_axes as axes_of};
use crate::map::SECOND_OF_GROWTH;
use crate::memory;
use crate::method::{self, AnyMethod, Method};
use crate::scene::Scene;
use crate::simd::Isa;
use convert::{Aligned2, column, rows};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods};
use pyo3::exceptions::{PyImportError, PyMemoryError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use std::sync::OnceLock;

impl From<Error> for PyErr {
    fn from(error: Error) -> PyErr {
        match error {
            Error::Memory { .. } => PyMemoryError::new_err(error.to_string()),
            Error::NoIsa => PyImportError::new_err(error.to_string()),
            Error::Isa { .. } | Error::Stopped | Error::Fault { .. } => {
                PyRuntimeError::new_err(error.to_string())
            }
            _ => PyValueError::new_err(error.to_string()),
        }
    }
}

/// Rotation of rigid bodies: the compiled core of `rigid`.
#[pymodule]
mod _core {
    #[pymodule_export]
    use super::convert::{first_not_finite, first_slow, listen, plain_numbers};
    #[pymodule_export]
    use super::estimate::{distances, errors_of_closed_forms};
    #[pymodule_export]
    use super::exact::{closed_form_names, closed_forms, closed_forms_for, lagrange_axes};
    #[pymodule_export]
    use super::exact::{elliptic, flip_times, free_quantities_of, saddles, tilt_times, top_quantities_of};
    #[pymodule_export]
    use super::forces::{PyForces, further_forces, orbit_anomalies, spline};
    #[pymodule_export]
    use super::growth::{deviation_starts, generic_deviations, growth, rate_units, verdicts};
    #[pymodule_export]
    use super::map::{
        MapJob, MapStatistics, agreed_classes, class_names, clopper_pearson, deviates, map_columns,
        unknown_outcomes,
    };
    #[pymodule_export]
    use super::motion::PyMotion;
    #[pymodule_export]
    use super::section::section;
    #[pymodule_export]
    use super::simulate::{
        fastest_rates, first_tolerance, planned_steps, simulate, solve, state_bytes, status_names,
    };
    #[pymodule_export]
    use super::states::PyStates;
    #[pymodule_export]
    use super::{
        available_threads, build_info, check_method, check_moments, chosen_methods, in_standard_floats,
        is_set, methods, moment_status, moment_status_names, nearest_possible, principal_axes,
        unit_quaternions,
    };
    /// Largest relative error of energy, momentum or unit lengths of a motion that has not drifted.
    #[pymodule_export]
    const DRIFT_LIMIT: f64 = crate::status::DRIFT_LIMIT;

    #[pymodule_export]
    const FEWEST_STEPS: f64 = crate::forces::FEWEST_STEPS;

    /// Bodies that a function of many is told, and numbers of a row of their data.
    #[pymodule_export]
    const BODIES_OF_A_FUNCTION: usize = crate::forces::EIGHT;
    #[pymodule_export]
    const BODIES_OF_A_ROW: usize = crate::simd::LANES;

    /// Most states of a body whose rates of change a function returns.
    #[pymodule_export]
    const MOST_STATES: usize = crate::forces::MOST_STATES;

    /// Error of a closed form for each radian that a body turns.
    #[pymodule_export]
    const ROUNDING: f64 = crate::trajectory::ROUNDING;

    /// The tolerance with which a series leaves rounding alone, and the least under a function.
    #[pymodule_export]
    const SERIES_TOLERANCE: f64 = crate::accuracy::SERIES_TOLERANCE;
    #[pymodule_export]
    const LEAST_UNDER_FUNCTION: f64 = crate::accuracy::LEAST_UNDER_FUNCTION;

    /// The tolerance at which rounding alone is left in the times of crossings.
    #[pymodule_export]
    const CROSSING_TOLERANCE: f64 = crate::accuracy::CROSSING_TOLERANCE;

    /// Factor by which the longest step under a function is shorter in a second run by a tolerance.
    #[pymodule_export]
    const ELSEWHERE: f64 = crate::accuracy::ELSEWHERE;

    /// The horizon over the times at which the mean MEGNO is read to tell whether a motion is regular.
    #[pymodule_export]
    const CHECKPOINT_PARTS: [u64; 4] = crate::map::PARTS;

    /// One over the unit of sums in fixed point.
    #[pymodule_export]
    const FIXED_POINT: f64 = crate::map::FIXED_POINT;

    /// Version of the library.
    #[pymodule_export]
    #[allow(non_upper_case_globals)]
    const __version__: &str = env!("CARGO_PKG_VERSION");

    /// Refuses a processor for which nothing is compiled before anything runs.
    #[pymodule_init]
    fn init(_module: &pyo3::Bound<'_, pyo3::types::PyModule>) -> pyo3::PyResult<()> {
        crate::simd::Isa::parse(None, &crate::simd::Isa::available())?;
        Ok(())
    }
}

/// Number of threads that can run at once: the processors that the affinity and the control group of this process allow.
/// Read once: to read the limits of control groups takes as long as a short run.
#[pyfunction]
fn available_threads() -> usize {
    static AVAILABLE: OnceLock<usize> = OnceLock::new();
    *AVAILABLE.get_or_init(|| std::thread::available_parallelism().map_or(1, usize::from))
}

/// Whether a variable of the environment is set: Python takes longer to tell.
#[pyfunction]
fn is_set(variable: &str) -> bool {
    std::env::var_os(variable).is_some()
}

/// The build of this library and its instruction set.
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

/// Properties of the methods, one dict a method.
#[pyfunction]
fn methods(py: Python<'_>) -> PyResult<Vec<Bound<'_, PyDict>>> {
    let describe = |(family, method): (&str, &Method)| {
        let facts = method.facts;
        let entry = PyDict::new(py);
        entry.set_item("name", facts.name)?;
        entry.set_item("title", facts.title)?;
        entry.set_item("family", family)?;
        entry.set_item("order", facts.order)?;
        entry.set_item("stages", facts.stages)?;
        entry.set_item("symplectic", facts.symplectic)?;
        entry.set_item("reversible", facts.reversible)?;
        entry.set_item("group_preserving", facts.group_preserving)?;
        entry.set_item("conserves", PyTuple::new(py, facts.conserves)?)?;
        entry.set_item("tangent", method.has_tangent())?;
        entry.set_item("forces", PyTuple::new(py, method.forces())?)?;
        entry.set_item("stiff", method.is_stiff())?;
        entry.set_item("tops", method.moves_tops())?;
        entry.set_item("maps", !method.is_processed())?;
        entry.set_item("series", method.is_series())?;
        entry.set_item("compensated", method.any.is_compensated())?;
        entry.set_item("damping_limit", method.damping_limit())?;
        entry.set_item("angle_per_step", facts.angle_per_step)?;
        entry.set_item("longest_angle", facts.longest_angle)?;
        entry.set_item("citation", facts.citation)?;
        entry.set_item("doi", facts.doi)?;
        Ok(entry)
    };
    let methods =
        method::FAMILIES.iter().flat_map(|(family, own)| own.iter().map(move |&one| (*family, one)));
    methods.map(describe).collect()
}

/// The names of the methods that are chosen by default: without a closed form, for the samples of a map, to cross-check
/// them and the growth of deviation vectors, under the torque of a function, for many times, to rounding, where only rounding
/// is left to err, and under strong damping.
#[pyfunction]
fn chosen_methods(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let names = PyDict::new(py);
    names.set_item("default", method::DEFAULT.facts.name)?;
    names.set_item("map", AnyMethod::Auto.by_steps().facts.name)?;
    names.set_item("second", method::SECOND.facts.name)?;
    names.set_item("function", method::FUNCTION.facts.name)?;
    names.set_item("many_times", method::MANY_TIMES.facts.name)?;
    names.set_item("to_rounding", method::TO_ROUNDING.facts.name)?;
    names.set_item("series", method::SERIES.facts.name)?;
    names.set_item("second_growth", SECOND_OF_GROWTH.facts.name)?;
    names.set_item("stiff", method::STIFF.facts.name)?;
    Ok(names)
}

/// Calls a function while its thread rounds to nearest and keeps subnormal numbers.
#[pyfunction]
fn in_standard_floats<'py>(
    function: &Bound<'py, PyAny>,
    args: &Bound<'py, PyTuple>,
    kwargs: &Bound<'py, PyDict>,
) -> PyResult<Bound<'py, PyAny>> {
    let _standard = FloatEnvironment::standard();
    function.call(args, Some(kwargs))
}

/// Raises if the method does not integrate that scene, or if no map observes its motions.
#[pyfunction]
fn check_method(method: &str, scene: &str, watched: bool) -> PyResult<()> {
    let method = Method::parse(method)?;
    method.check(Scene::parse(scene)?)?;
    if watched { Ok(method.check_observed()?) } else { Ok(()) }
}

/// Raises if no rigid body has these moments.
#[pyfunction]
fn check_moments(moments: [f64; 3]) -> PyResult<()> {
    Ok(inertia::check_moments(moments)?)
}

/// Whether a rigid body has these moments: 0, or the code of the first rule that they break.
#[pyfunction]
fn moment_status<'py>(
    py: Python<'py>,
    moments: Aligned2<'py, f64>,
    physical: bool,
) -> PyResult<Bound<'py, PyArray1<u8>>> {
    let _standard = FloatEnvironment::standard();
    column(py, rows::<3>("moments", &moments)?, |&moments| MomentStatus::of(moments, physical) as u8)
}

/// The nearest possible moments, and the excess of the largest moment as a share of it.
#[pyfunction]
#[allow(clippy::type_complexity)]
fn nearest_possible<'py>(
    py: Python<'py>,
    moments: Aligned2<'py, f64>,
) -> PyResult<(Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<f64>>)> {
    let _standard = FloatEnvironment::standard();
    let moments = rows::<3>("moments", &moments)?;
    let nearest = memory::collected("moments", moments.len(), moments.iter().map(|&m| nearest_of(m)))?;
    let nearest = nearest.into_flattened().into_pyarray(py).reshape([moments.len(), 3])?;
    Ok((nearest, column(py, moments, |&moments| excess(moments))?))
}

/// Descriptions of the codes of `moment_status`, in the order of the codes.
#[pyfunction]
fn moment_status_names() -> Vec<&'static str> {
    MomentStatus::ALL.into_iter().map(MomentStatus::name).collect()
}

/// The unit quaternion of each quaternion, `None` if one is zero: the one normalisation of attitudes.
#[pyfunction]
fn unit_quaternions<'py>(
    py: Python<'py>,
    quaternions: Aligned2<'py, f64>,
) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
    let _standard = FloatEnvironment::standard();
    let quaternions = rows::<4>("attitude", &quaternions)?;
    let mut units: Vec<[f64; 4]> = memory::reserved("unit quaternions", quaternions.len())?;
    for &quaternion in quaternions {
        let Some(unit) = unit_quaternion(quaternion) else { return Ok(None) };
        units.push(unit);
    }
    Ok(Some(units.into_flattened().into_pyarray(py).reshape([quaternions.len(), 4])?))
}

/// Principal moments, ascending, possible or not, and axes (columns) of a tensor of inertia.
#[pyfunction]
fn principal_axes(tensor: [[f64; 3]; 3]) -> PyResult<([f64; 3], [[f64; 3]; 3])> {
    let _standard = FloatEnvironment::standard();
    Ok(axes_of(tensor)?)
}
