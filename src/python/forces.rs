//! Forces from Python.

use super::convert::{Aligned1, Aligned2, OneOrEach, copied, copied_rows, rows, same_length};
use crate::error::Error;
use crate::float_environment::FloatEnvironment;
use crate::forces::{
    BodyForces, Bounded, Code, Forces, Further, Orbit, ParameterChange, Samples, TorqueFunction, Trajectory,
};
use crate::memory;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use std::collections::HashMap;

/// Forces on the bodies of a request: torques in the body and in space at some times, linear between them (no times:
/// constant), table after table, damping, entries 11, 22, 33, 23, 31, 12 of its matrices, and the numbers of the further
/// forces by name. Those of a table over time are its vectors one after another, at the times of `knots` by the same name. One table, matrix or row may serve all bodies; without tables no torque is applied. A function that
/// returns a torque is its address, whether it is told eight bodies at once, whether it is told states and places, its data in
/// rows, what its torques are multiplied by, a bound of the rates, or 0, and its states at the start in rows.
#[pyclass(frozen, name = "Forces", module = "rigid._core")]
pub struct PyForces(pub Forces);

/// What is given of some further forces.
type ByName<T> = HashMap<String, T>;

/// The vectors of a table, which come one after another in the rows of the bodies.
fn vectors(what: &'static str, rows: &Aligned2<'_, f64>) -> Result<Vec<[f64; 3]>, Error> {
    let (numbers, width) = copied_rows(what, rows)?;
    if !width.is_multiple_of(3) {
        return Err(Error::Shape {
            argument: what,
            expected: "(n, 3 m)".into(),
            got: format!("(n, {width})"),
        });
    }
    memory::collected(what, numbers.len() / 3, numbers.chunks_exact(3).map(|v| [v[0], v[1], v[2]]))
}

/// Value, slope and bend at some times, (n, 3, 3), of the spline of a trajectory through samples at its knots, (m, 3).
#[pyfunction]
pub fn spline<'py>(
    py: Python<'py>,
    knots: Aligned1<'py, f64>,
    samples: Aligned2<'py, f64>,
    times: Aligned1<'py, f64>,
) -> PyResult<Bound<'py, PyArray3<f64>>> {
    let _standard = FloatEnvironment::standard();
    let (knots, times) = (copied("t", &knots)?, copied("t", &times)?);
    let values = crate::forces::spline(&knots, rows::<3>("positions", &samples)?)?;
    let spline = Samples { times: knots.as_slice(), values: values.as_slice() };
    let found = times.iter().map(|&time| {
        let Trajectory([value, slope, bend, _]) = spline.polynomial(time, false, 0.0);
        [value, slope, bend.map(|x| 2.0 * x)]
    });
    let found = memory::collected("spline", times.len(), found)?.into_flattened().into_flattened();
    found.into_pyarray(py).reshape([times.len(), 3, 3])
}

/// Address of a function, whether it is of eight bodies and long, data, units, the bound of the rates, states at the start.
type GivenFunction<'py> =
    (usize, bool, bool, Aligned2<'py, f64>, Aligned1<'py, f64>, f64, Aligned2<'py, f64>);

/// The numbers of the further forces, from those of some by name.
fn further(given: &ByName<Aligned2<'_, f64>>) -> Result<Vec<[f64; Further::LEN]>, Error> {
    let bodies = given.values().map(|numbers| numbers.as_array().nrows()).max().unwrap_or(0);
    let none = std::iter::repeat_n([0.0; Further::LEN], bodies);
    let mut all = memory::collected("forces", bodies, none)?;
    for (name, numbers) in given {
        let (numbers, known) = (numbers.as_array(), Further::LIST.iter().find(|(own, ..)| own == name));
        let places = known.map_or(0..0, |(.., places)| places.clone());
        if numbers.ncols() != places.len() || ![1, bodies].contains(&numbers.nrows()) {
            let (expected, got) = (format!("({bodies}, {})", places.len()), format!("{:?}", numbers.shape()));
            return Err(Error::Shape { argument: "forces", expected, got });
        }
        for (body, row) in all.iter_mut().enumerate() {
            let own = numbers.row(if numbers.nrows() > 1 { body } else { 0 });
            row[places.clone()].iter_mut().zip(own).for_each(|(place, &number)| *place = number);
        }
    }
    Ok(all)
}

/// Each further force: its words, how many numbers it has, and where these begin among those of a change of the parameters; and
/// the length of the change.
#[pyfunction]
#[allow(clippy::type_complexity)]
pub fn further_forces() -> (HashMap<&'static str, (&'static str, usize, usize)>, usize) {
    let facts = Further::LIST
        .iter()
        .map(|(name, words, places)| (*name, (*words, places.len(), ParameterChange::OWN + places.start)));
    (facts.collect(), ParameterChange::LEN)
}

/// Cosine and sine of the eccentric anomaly, hyperbolic on a hyperbola, (n, 2), of orbits with these numbers at these times, (n, 9) and (n,).
#[pyfunction]
pub fn orbit_anomalies<'py>(
    py: Python<'py>,
    numbers: Aligned2<'py, f64>,
    times: Aligned1<'py, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let _standard = FloatEnvironment::standard();
    let (numbers, times) = (rows::<9>("orbit", &numbers)?, copied("t", &times)?);
    same_length("t", numbers.len(), times.len())?;
    let anomalies = numbers.iter().zip(&times).map(|(numbers, &time)| {
        let (orbit, mut variables) = (Orbit(*numbers), [0.0; 2]);
        orbit.start(time, &mut variables);
        orbit.cos_sin(variables)
    });
    let anomalies = memory::collected("anomalies", times.len(), anomalies)?.into_flattened();
    anomalies.into_pyarray(py).reshape([times.len(), 2])
}

#[pymethods]
impl PyForces {
    #[new]
    #[pyo3(signature = (*, times, body, space, damping, further = None, knots = None, function = None))]
    fn new(
        times: Aligned1<'_, f64>,
        body: Aligned2<'_, f64>,
        space: Aligned2<'_, f64>,
        damping: Aligned2<'_, f64>,
        further: Option<ByName<Aligned2<'_, f64>>>,
        knots: Option<ByName<Aligned1<'_, f64>>>,
        function: Option<GivenFunction<'_>>,
    ) -> PyResult<Self> {
        let _standard = FloatEnvironment::standard();
        let (body, space) = (rows::<3>("torque", &body)?, rows::<3>("torque", &space)?);
        let times = copied("torque times", &times)?;
        let mut forces = Forces::new(&times, body, space, rows::<6>("damping", &damping)?)?;
        let mut given = further.unwrap_or_default();
        for (name, knots) in knots.unwrap_or_default() {
            let (times, rows) = (copied("t", &knots)?, given.remove(&name));
            match (name.as_str(), rows) {
                ("rotor", Some(rows)) => forces = forces.with_rotors(&times, &vectors("rotor", &rows)?)?,
                ("orbit", Some(rows)) => forces = forces.on_trajectory(&times, &vectors("orbit", &rows)?)?,
                _ => {
                    return Err(Error::value("forces", name.clone(), "has no table over time").into());
                }
            }
        }
        forces = forces.with_further(&self::further(&given)?)?;
        let Some((address, is_of_eight, is_long, data, units, fastest, starts)) = function else {
            return Ok(PyForces(forces));
        };
        let (data, width) = copied_rows("data of a torque", &data)?;
        let units = copied("units", &units)?;
        let code = Code { address, is_of_eight, is_long };
        // SAFETY: what `rigid.Torque.call` asks of its caller.
        let function = unsafe { TorqueFunction::new(code, data, width, units, fastest)? };
        let (starts, states) = copied_rows("states", &starts)?;
        let function = function.with_states(starts, states)?;
        Ok(PyForces(forces.with_function(function)?))
    }

    /// The forces on some bodies, in this order.
    fn select(&self, bodies: Aligned1<'_, isize>) -> PyResult<Self> {
        let bodies = bodies.as_array();
        // No body has a negative index.
        let indices = bodies.iter().map(|&body| usize::try_from(body).unwrap_or(usize::MAX));
        let indices = memory::collected("bodies", bodies.len(), indices)?;
        Ok(PyForces(self.0.of_some(&indices)?))
    }

    /// The forces of a second run, in which the trajectory of a table is another by its doubt.
    fn doubted(&self) -> PyResult<Self> {
        Ok(PyForces(self.0.doubted()?))
    }

    /// The rate k of each body with these moments, if nothing acts but a damping `D = k I`, else NaN.
    fn slows_evenly<'py>(
        &self,
        py: Python<'py>,
        moments: Aligned2<'_, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.of_each(py, &moments, |forces, moments| forces.slows_evenly(moments).unwrap_or(f64::NAN))
    }

    /// Whether a function gives a torque.
    #[getter]
    fn calls(&self) -> bool {
        self.0.of(0).function.is_some()
    }

    /// How many states of its own a function has for each body.
    #[getter]
    fn states(&self) -> usize {
        self.0.states_of_function()
    }

    /// What acts on each body, as bits: a torque is applied, damping, a function, and each further force that is not zero.
    fn kinds<'py>(&self, py: Python<'py>, bodies: usize) -> PyResult<Bound<'py, PyArray1<u64>>> {
        if self.0.bodies() > 1 {
            same_length("bodies", self.0.bodies(), bodies)?;
        }
        let kinds = (0..bodies).map(|body| self.0.of(body).kinds());
        Ok(memory::collected("bodies", bodies, kinds)?.into_pyarray(py))
    }

    /// The largest damping rate of each body with these moments without torque.
    fn damping_rates<'py>(
        &self,
        py: Python<'py>,
        moments: Aligned2<'_, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.of_each(py, &moments, |forces, moments| forces.damping.rates(moments)[2])
    }
}

impl PyForces {
    /// A number of each body; one row of moments may be those of all.
    fn of_each<'py>(
        &self,
        py: Python<'py>,
        moments: &Aligned2<'_, f64>,
        of: impl Fn(BodyForces<'_>, [f64; 3]) -> f64,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let _standard = FloatEnvironment::standard();
        let moments = rows::<3>("moments", moments)?;
        let bodies = if moments.len() == 1 { self.0.bodies() } else { moments.len() };
        if self.0.bodies() > 1 {
            same_length("moments", self.0.bodies(), bodies)?;
        }
        let moments = OneOrEach::new("moments", bodies, moments)?;
        let number = |body: usize| of(self.0.of(body), moments.of(body));
        Ok(memory::collected("numbers of the bodies", bodies, (0..bodies).map(number))?.into_pyarray(py))
    }
}
