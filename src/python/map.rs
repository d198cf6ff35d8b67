//! Stability maps.

use super::convert::{self, bodies, interruptible, rows, rows_of, same_length};
use super::forces::PyForces;
use crate::body::MomentStatus;
use crate::error::Error;
use crate::float_environment::FloatEnvironment;
use crate::forces::Forces;
use crate::map::{
    Bin, Check, Column, Condition, Criterion, Field, Known, Laws, Logic, Map, Measure, MethodChoice, Mixed,
    Outcome, Pixel, Sketch, Statistics, clopper_pearson_of_each,
};
use crate::memory;
use crate::sample::{Given, Law};
use crate::scene::Scene;
use crate::simd::Isa;
use crate::solver::Solver;
use crate::status::Status;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Mutex;

/// What the columns of a map are called if they do not fit into memory.
const PIXELS: &str = "pixels of the map";
const GIVEN: &str = "given samples";

/// A checked request for a map; its samples are run in ranges and one by one.
#[pyclass(frozen, module = "rigid._core")]
pub struct MapJob {
    map: Map,
    status: Vec<u8>,
    isa: Isa,
}

/// The outputs of a map, one number for each pixel: `name`; `dtype`; `reduction` (`sum`, `max` or `min`), by which two
/// parts are merged; `unit`; `words`; and `reproducible`, false for a measurement of the machine.
#[pyfunction]
pub fn map_columns(py: Python<'_>) -> PyResult<Vec<Bound<'_, PyDict>>> {
    let describe = |column: &Column| {
        let entry = PyDict::new(py);
        entry.set_item("name", column.name)?;
        let dtype = match column.field {
            Field::Count(_) | Field::Fixed(_) => "int64",
            Field::Number(_) => "float64",
        };
        entry.set_item("dtype", dtype)?;
        entry.set_item("reduction", column.reduction)?;
        entry.set_item("unit", column.unit)?;
        entry.set_item("words", column.words)?;
        entry.set_item("reproducible", column.reproducible)?;
        Ok(entry)
    };
    Statistics::COLUMNS.iter().map(describe).collect()
}

/// Lower and upper ends of the Clopper-Pearson intervals of shares; NaN without trials.
#[pyfunction]
pub fn clopper_pearson<'py>(
    py: Python<'py>,
    successes: PyReadonlyArray1<'py, i64>,
    trials: PyReadonlyArray1<'py, i64>,
    confidence: f64,
) -> PyResult<[Bound<'py, PyArray1<f64>>; 2]> {
    let (successes, trials) = (successes.as_array(), trials.as_array());
    same_length("trials", successes.len(), trials.len())?;
    let counts: Vec<[u64; 2]> = successes
        .iter()
        .zip(trials)
        .map(|(&successes, &trials)| Ok([count("successes", successes)?, count("trials", trials)?]))
        .collect::<Result<_, Error>>()?;
    let intervals =
        interruptible(py, None, |stop| clopper_pearson_of_each(counts.into_iter(), confidence, stop))??;
    Ok([0, 1].map(|end| intervals.iter().map(|ends| ends[end]).collect::<Vec<f64>>().into_pyarray(py)))
}

/// A time, NaN for never.
fn finite(time: f64) -> f64 {
    if time < f64::INFINITY { time } else { f64::NAN }
}

/// A number that counts.
fn count(argument: &'static str, value: i64) -> Result<u64, Error> {
    let wrong = |_| Error::Value { argument, value: value.to_string(), rule: "must not be negative" };
    u64::try_from(value).map_err(wrong)
}

/// Writes the statistics of pixels as one array a column.
fn write_columns(py: Python<'_>, dict: &Bound<'_, PyDict>, pixels: &[Statistics]) -> PyResult<()> {
    let _standard = FloatEnvironment::standard();
    for column in Statistics::COLUMNS {
        match column.field {
            Field::Count(of) => {
                let values = convert::column(py, pixels, |&(mut pixel)| *of(&mut pixel) as i64)?;
                dict.set_item(column.name, values)?;
            }
            Field::Fixed(of) => {
                let values = convert::column(py, pixels, |&(mut pixel)| *of(&mut pixel))?;
                dict.set_item(column.name, values)?;
            }
            Field::Number(of) => {
                let values = convert::column(py, pixels, |&(mut pixel)| *of(&mut pixel))?;
                dict.set_item(column.name, values)?;
            }
        }
    }
    Ok(())
}

/// Reads the statistics that `write_columns` wrote.
fn read_columns(dict: &Bound<'_, PyDict>) -> PyResult<Vec<Statistics>> {
    let mut pixels: Vec<Statistics> = Vec::new();
    for column in Statistics::COLUMNS {
        let values = dict.as_any().get_item(column.name)?;
        let mut fit = |length: usize| {
            if pixels.is_empty() {
                pixels = memory::filled(PIXELS, length, Statistics::NONE)?;
            }
            same_length(column.name, pixels.len(), length)
        };
        match column.field {
            Field::Count(of) => {
                let values = values.extract::<PyReadonlyArray1<'_, i64>>()?;
                fit(values.as_array().len())?;
                pixels
                    .iter_mut()
                    .zip(values.as_array())
                    .for_each(|(pixel, &value)| *of(pixel) = value as u64);
            }
            Field::Fixed(of) => {
                let values = values.extract::<PyReadonlyArray1<'_, i64>>()?;
                fit(values.as_array().len())?;
                pixels.iter_mut().zip(values.as_array()).for_each(|(pixel, &value)| *of(pixel) = value);
            }
            Field::Number(of) => {
                let values = values.extract::<PyReadonlyArray1<'_, f64>>()?;
                fit(values.as_array().len())?;
                pixels.iter_mut().zip(values.as_array()).for_each(|(pixel, &value)| *of(pixel) = value);
            }
        }
    }
    Ok(pixels)
}

/// A bin of a sketch as a row: its pixel, and the numbers of the bin.
const ROW: usize = 1 + Bin::LEN;

/// The bins of the sketches of each measure, one row a bin: sorted by pixel and value.
fn bins_by_measure<'py>(
    py: Python<'py>,
    sketches: &[Sketch],
    measures: usize,
) -> PyResult<Vec<Bound<'py, PyArray2<i64>>>> {
    (0..measures)
        .map(|measure| {
            let of_measure = || sketches.iter().skip(measure).step_by(measures).enumerate();
            let bins: usize = of_measure().map(|(_, sketch)| sketch.bins().len()).sum();
            let mut numbers = memory::reserved("bins of a measure", bins * ROW)?;
            for (pixel, sketch) in of_measure() {
                for bin in sketch.bins() {
                    numbers.push(pixel as i64);
                    numbers.extend(bin.numbers());
                }
            }
            numbers.into_pyarray(py).reshape([bins, ROW])
        })
        .collect()
}

/// The statistics of all pixels of a map, merged from the parts that `MapJob.run` returns.
#[pyclass(frozen, module = "rigid._core")]
pub struct MapStatistics {
    measures: usize,
    all: Mutex<(Vec<Statistics>, Vec<Sketch>)>,
}

#[pymethods]
impl MapStatistics {
    /// The statistics of no samples.
    #[new]
    #[pyo3(signature = (pixels, measures=0))]
    fn new(pixels: usize, measures: usize) -> PyResult<Self> {
        let statistics = memory::filled(PIXELS, pixels, Statistics::NONE)?;
        let sketches = memory::filled(PIXELS, pixels.saturating_mul(measures), Sketch::NONE)?;
        Ok(MapStatistics { measures, all: Mutex::new((statistics, sketches)) })
    }

    /// Merges a part in, by the reduction of each column. The order of the parts has no effect.
    fn merge(&self, part: &Bound<'_, PyDict>) -> PyResult<()> {
        let _standard = FloatEnvironment::standard();
        let first: usize = part.as_any().get_item("first")?.extract()?;
        let bins: Vec<PyReadonlyArray2<'_, i64>> = match part.get_item("measures")? {
            Some(bins) => bins.extract()?,
            None => Vec::new(),
        };
        let columns = read_columns(part)?;
        let mut all = self.all.lock().expect("no thread panics while it holds the statistics");
        let (pixels, sketches) = &mut *all;
        let window = pixels.get_mut(first..first.saturating_add(columns.len())).ok_or_else(|| {
            let value = format!("{first} to {}", first.saturating_add(columns.len()));
            Error::Value { argument: "part", value, rule: "must be pixels of the map" }
        })?;
        same_length("measures", self.measures, bins.len())?;
        for (measure, bins) in bins.iter().enumerate() {
            for &[pixel, ref numbers @ ..] in rows_of::<i64, ROW>("measures", bins)? {
                let at = usize::try_from(pixel).ok().filter(|&pixel| pixel < columns.len());
                let at = at.ok_or_else(|| Error::Value {
                    argument: "part",
                    value: format!("a bin of pixel {pixel}"),
                    rule: "must be pixels of the map",
                })?;
                sketches[(first + at) * self.measures + measure].put(&Bin::from_numbers(*numbers))?;
            }
        }
        window.iter_mut().zip(&columns).for_each(|(pixel, other)| pixel.merge(other));
        Ok(())
    }

    /// Adds values of a measure, each of a pixel; what is not finite is none.
    fn add(
        &self,
        measure: usize,
        pixels: PyReadonlyArray1<'_, u64>,
        values: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<()> {
        let _standard = FloatEnvironment::standard();
        let (pixels, values) = (pixels.as_array(), values.as_array());
        same_length("values", pixels.len(), values.len())?;
        let mut all = self.all.lock().expect("no thread panics while it holds the statistics");
        let sketches = &mut all.1;
        for (&pixel, &value) in pixels.iter().zip(values) {
            let at = usize::try_from(pixel).ok().and_then(|pixel| pixel.checked_mul(self.measures));
            let place = at.filter(|_| measure < self.measures).and_then(|at| sketches.get_mut(at + measure));
            let place = place.ok_or_else(|| Error::Value {
                argument: "pixels",
                value: format!("{pixel} of measure {measure}"),
                rule: "must be pixels and measures of the map",
            })?;
            place.add(value)?;
        }
        Ok(())
    }

    /// One array of a number a pixel for each of `map_columns()`, flat.
    fn arrays<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        let all = self.all.lock().expect("no thread panics while it holds the statistics");
        write_columns(py, &dict, &all.0)?;
        Ok(dict)
    }

    /// The bins of the sketches of each measure, (n, 9) each: pixel; key, count, least and largest offset; sum of the
    /// offsets and of their squares, in two halves each.
    fn bins<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyArray2<i64>>>> {
        let all = self.all.lock().expect("no thread panics while it holds the statistics");
        bins_by_measure(py, &all.1, self.measures)
    }
}

/// Writes the keyword arguments of a map as a type.
macro_rules! keywords {
    ($(#[$doc:meta])* struct $name:ident { $($(#[$option:meta])* $field:ident: $type:ty,)* }) => {
        $(#[$doc])*
        #[derive(FromPyObject)]
        #[pyo3(from_item_all)]
        struct $name<'py> {
            $($(#[$option])* $field: $type,)*
        }

        impl $name<'_> {
            const KEYWORDS: &'static [&'static str] = &[$(stringify!($field)),*];
        }
    };
}

keywords! {
    /// The keyword arguments of `MapJob`: those of `Map`, column by column.
    struct MapRequest {
        scene: String,
        method: String,
        moments: PyReadonlyArray2<'py, f64>,
        weight: PyReadonlyArray2<'py, f64>,
        conditions: Vec<(String, i32, Vec<f64>)>,
        logic: String,
        measures: Vec<(String, i32)>,
        t_end: f64,
        step: Option<f64>,
        max_steps: u64,
        samples: u64,
        checked: Option<u64>,
        seed: u128,
        #[pyo3(default)]
        forces: Option<Vec<PyRef<'py, PyForces>>>,
        #[pyo3(default)]
        numbers: Option<PyReadonlyArray1<'py, u64>>,
        #[pyo3(default)]
        first: u64,
        #[pyo3(default)]
        mixture: Option<Vec<StartsRequest<'py>>>,
        #[pyo3(default)]
        mixture_shares: Option<Vec<f64>>,
    }
}

keywords! {
    /// The keyword arguments of the starts: those of `Laws`, with the nominal start and the sizes of each pixel.
    struct StartsRequest {
        omega: PyReadonlyArray2<'py, f64>,
        omega_noise: String,
        omega_size: PyReadonlyArray2<'py, f64>,
        attitude: PyReadonlyArray2<'py, f64>,
        attitude_noise: String,
        attitude_size: PyReadonlyArray2<'py, f64>,
        #[pyo3(default)]
        mix: Option<PyReadonlyArray2<'py, f64>>,
        #[pyo3(default)]
        mixed: [bool; 2],
        #[pyo3(default)]
        given_omega: Option<PyReadonlyArray2<'py, f64>>,
        #[pyo3(default)]
        given_attitude: Option<PyReadonlyArray2<'py, f64>>,
        #[pyo3(default)]
        given_shares: Option<PyReadonlyArray1<'py, f64>>,
    }
}

impl StartsRequest<'_> {
    /// The pixels with these moments and weights, and their laws.
    fn pixels(
        &self,
        moments: &[[f64; 3]],
        weight: &[[f64; 3]],
        status: &[u8],
    ) -> PyResult<(Vec<Pixel>, Laws)> {
        let pixels = moments.len();
        let omega_size = rows::<3>("omega_size", &self.omega_size)?;
        same_length("omega_size", pixels, omega_size.len())?;
        let attitude_size = rows::<3>("attitude_size", &self.attitude_size)?;
        same_length("attitude_size", pixels, attitude_size.len())?;
        let omega = rows::<3>("omega", &self.omega)?;
        same_length("omega", pixels, omega.len())?;
        let bodies = bodies(moments, weight, omega, rows::<4>("attitude", &self.attitude)?)?;
        let pixel = |i: usize| Pixel {
            body: bodies[i],
            omega_size: omega_size[i],
            attitude_size: attitude_size[i],
            possible: status[i] == MomentStatus::Possible as u8,
        };
        Ok((memory::collected(PIXELS, pixels, (0..pixels).map(pixel))?, self.laws()?))
    }

    fn laws(&self) -> PyResult<Laws> {
        let mix = match &self.mix {
            Some(mix) => {
                let factor = rows::<6>("mix", mix)?;
                same_length("mix", 6, factor.len())?;
                let mut rows = [[0.0; 6]; 6];
                rows.copy_from_slice(factor);
                Some(rows)
            }
            None => None,
        };
        let given = match &self.given_omega {
            Some(omega) => {
                let of_rates = rows::<3>("given_omega", omega)?;
                let count = of_rates.len();
                let mut given = Given {
                    omega: memory::collected(GIVEN, count, of_rates.iter().copied())?,
                    attitude: Vec::new(),
                    cumulative: Vec::new(),
                };
                if let Some(attitude) = &self.given_attitude {
                    let rotations = rows::<4>("given_attitude", attitude)?;
                    same_length("given_attitude", count, rotations.len())?;
                    given.attitude = memory::collected(GIVEN, count, rotations.iter().copied())?;
                }
                if let Some(shares) = &self.given_shares {
                    same_length("given_shares", count, shares.as_array().len())?;
                    given.cumulative = memory::collected(GIVEN, count, shares.as_array().iter().copied())?;
                }
                Some(given)
            }
            None => None,
        };
        Ok(Laws {
            omega: Law::parse("omega_noise", &self.omega_noise)?,
            attitude: Law::parse("attitude_noise", &self.attitude_noise)?,
            mix,
            mixed: self.mixed,
            given,
        })
    }
}

impl MapRequest<'_> {
    const OPTIONAL: [&'static str; 10] = [
        "forces",
        "numbers",
        "first",
        "mix",
        "mixed",
        "given_omega",
        "given_attitude",
        "given_shares",
        "mixture",
        "mixture_shares",
    ];

    /// The map with these starts, and the status of the moments of each pixel.
    fn map(self, starts: &StartsRequest<'_>) -> PyResult<(Map, Vec<u8>)> {
        let moments = rows::<3>("moments", &self.moments)?;
        let pixels = moments.len();
        let status = moments.iter().map(|&m| MomentStatus::of(m) as u8);
        let status = memory::collected(PIXELS, pixels, status)?;
        let weight = rows::<3>("weight", &self.weight)?;
        let (starting, laws) = starts.pixels(moments, weight, &status)?;
        let shares = self.mixture_shares.unwrap_or_default();
        let mut mixture = Vec::new();
        if let Some(all) = &self.mixture {
            same_length("mixture_shares", all.len(), shares.len())?;
            for (starts, &until) in all.iter().zip(&shares) {
                let (pixels, laws) = starts.pixels(moments, weight, &status)?;
                memory::push(PIXELS, &mut mixture, Mixed { until, laws, pixels })?;
            }
        }
        let forces: Vec<Forces> = match self.forces {
            Some(all) => {
                same_length("forces", pixels, all.len())?;
                let mut copies = memory::reserved(PIXELS, pixels)?;
                for one in &all {
                    copies.push(one.0.copied()?);
                }
                copies
            }
            None => Vec::new(),
        };
        let numbers = match &self.numbers {
            Some(numbers) => {
                same_length("numbers", pixels, numbers.as_array().len())?;
                memory::collected(PIXELS, pixels, numbers.as_array().iter().copied())?
            }
            None => Vec::new(),
        };
        let conditions: Vec<Condition> = self
            .conditions
            .iter()
            .map(|(name, axis, limits)| {
                Ok(Condition { criterion: Criterion::parse(name, limits)?, axis: *axis })
            })
            .collect::<Result<_, Error>>()?;
        let map = Map {
            scene: Scene::parse(&self.scene)?,
            forces,
            method: MethodChoice::parse(&self.method)?,
            pixels: starting,
            laws,
            mixture,
            conditions,
            logic: Logic::parse(&self.logic, self.conditions.len())?,
            measures: self
                .measures
                .iter()
                .map(|(name, axis)| Measure::parse(name, *axis))
                .collect::<Result<_, Error>>()?,
            t_end: self.t_end,
            step: self.step,
            max_steps: self.max_steps,
            samples: self.samples,
            check: self.checked.map_or(Check::Doubtful, Check::First),
            key: [self.seed as u64, (self.seed >> 64) as u64],
            numbers,
            first: self.first,
        };
        Ok((map.checked()?, status))
    }
}

/// The values of the measures of samples, a row a sample, and the steps of their runs.
type ValuesAndSteps<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<u64>>);

/// A number of an outcome and its name.
type OutcomeNumber = (&'static str, fn(&Outcome) -> f64);

const OUTCOME_NUMBERS: [OutcomeNumber; 8] = [
    ("left", |one| if one.left < f64::INFINITY { one.left } else { f64::NAN }),
    ("tilt", |one| one.tilt),
    ("exponent", |one| one.exponent),
    ("mean_megno", |one| one.mean_megno),
    ("energy_drift", |one| one.energy_drift),
    ("momentum_drift", |one| one.momentum_drift),
    ("unit_drift", |one| one.unit_drift),
    ("step", |one| one.step),
];

#[pymethods]
impl MapJob {
    #[new]
    #[pyo3(signature = (**request))]
    fn new(request: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let _standard = FloatEnvironment::standard();
        let given = |name: &str| request.is_some_and(|request| request.contains(name).unwrap_or(false));
        let known = || MapRequest::KEYWORDS.iter().chain(StartsRequest::KEYWORDS);
        let missing = |name: &&&str| !MapRequest::OPTIONAL.contains(*name) && !given(name);
        if let Some(name) = known().find(missing) {
            return Err(PyTypeError::new_err(format!("MapJob() misses the keyword argument '{name}'")));
        }
        let request = request.expect("no keyword is missing");
        for name in request.keys() {
            let word = name.extract::<&str>()?;
            if !known().any(|known| *known == word) {
                return Err(PyTypeError::new_err(format!("MapJob() has no keyword argument '{name}'")));
            }
        }
        let starts = request.extract::<StartsRequest<'_>>()?;
        let (map, status) = request.extract::<MapRequest<'_>>()?.map(&starts)?;
        Ok(MapJob { map, status, isa: Isa::current()? })
    }

    /// Status of the moments of each pixel: 0 possible, 1 not finite, 2 not positive, 3 triangle inequality.
    #[getter]
    fn status<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<u8>>> {
        convert::column(py, &self.status, |&status| status)
    }

    /// Statistics of the samples start .. stop (pixel-major) for the pixels that they touch; None if
    /// `interrupted()`, called twenty times a second, returned true.
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
            self.map.run(start, stop, threads.max(1), self.isa, interrupt)
        })?;
        let (first, statistics, sketches) = match result {
            Err(Error::Stopped) => return Ok(None),
            result => result?,
        };
        let dict = PyDict::new(py);
        dict.set_item("first", first)?;
        write_columns(py, &dict, &statistics)?;
        dict.set_item("measures", bins_by_measure(py, &sketches, self.map.measures.len())?)?;
        Ok(Some(dict))
    }

    /// One sample, with the bits that it has in the map.
    fn sample<'py>(&self, py: Python<'py>, pixel: u64, sample: u64) -> PyResult<Bound<'py, PyDict>> {
        for (argument, value, length) in
            [("pixel", pixel, self.map.pixels.len() as u64), ("sample", sample, self.map.samples)]
        {
            if value >= length {
                let value = format!("{value} of {length}");
                return Err(Error::Value { argument, value, rule: "must be an index" }.into());
            }
        }
        let Known { body, class, outcome, parts, measures } =
            interruptible(py, None, |interrupt| self.map.sample(pixel, sample, self.isa, interrupt))??;
        let Outcome { status, flips, left, tilt, exponent, mean_megno, step, steps, exact, .. } = outcome;
        let dict = PyDict::new(py);
        dict.set_item("omega", body.omega.to_vec().into_pyarray(py))?;
        dict.set_item("attitude", body.attitude.to_vec().into_pyarray(py))?;
        dict.set_item("class", class.name())?;
        dict.set_item("status", Status::name(status))?;
        dict.set_item("flips", flips)?;
        dict.set_item("left", finite(left))?;
        dict.set_item("tilt", tilt)?;
        let parts = parts.iter().map(|&(class, left)| (class.name(), finite(left)));
        dict.set_item("parts", parts.collect::<Vec<_>>())?;
        dict.set_item("measures", measures)?;
        dict.set_item("exponent", exponent)?;
        dict.set_item("mean_megno", mean_megno)?;
        dict.set_item("energy_drift", outcome.energy_drift)?;
        dict.set_item("momentum_drift", outcome.momentum_drift)?;
        dict.set_item("unit_drift", outcome.unit_drift)?;
        dict.set_item("step", step)?;
        dict.set_item("steps", steps)?;
        dict.set_item("method", if exact { Solver::EXACT } else { self.map.first_scheme().facts.name })?;
        Ok(dict)
    }

    /// The starts of samples, numbered pixel by pixel: rates (n, 3) and attitudes (n, 4), one after the other.
    fn starts<'py>(
        &self,
        py: Python<'py>,
        samples: PyReadonlyArray1<'py, u64>,
    ) -> PyResult<[Bound<'py, PyArray1<f64>>; 2]> {
        let flat = self.numbers(&samples)?;
        let count = self.map.samples;
        let places = flat.iter().map(|sample| (sample / count, sample % count));
        let places = memory::collected("samples", flat.len(), places)?;
        let bodies = interruptible(py, None, |_| self.map.draw_at(self.isa, &places))??;
        let omega = bodies.iter().flat_map(|body| body.omega);
        let attitude = bodies.iter().flat_map(|body| body.attitude);
        Ok([
            memory::collected("rates", 3 * bodies.len(), omega)?.into_pyarray(py),
            memory::collected("attitudes", 4 * bodies.len(), attitude)?.into_pyarray(py),
        ])
    }

    /// The values of the measures of samples, numbered pixel by pixel in ascending order, sample by sample, and the steps of
    /// their runs. What follows from a classification is NaN: nothing is classified.
    fn measured<'py>(
        &self,
        py: Python<'py>,
        samples: PyReadonlyArray1<'py, u64>,
        threads: usize,
    ) -> PyResult<ValuesAndSteps<'py>> {
        let flat = self.ascending(&samples)?;
        let (values, steps) = interruptible(py, None, |interrupt| {
            self.map.values_at(&flat, &[], threads.max(1), self.isa, interrupt)
        })??;
        let values = values.into_pyarray(py).reshape([flat.len(), self.map.measures.len()])?;
        Ok((values, steps.into_pyarray(py)))
    }

    /// What became of samples, numbered pixel by pixel in ascending order: arrays of a number each. `class` and `status`
    /// are codes in the order of the classes and of the statuses; `exact` is 1 for a closed form; `measures` are the values of
    /// the measures, sample by sample.
    fn outcomes<'py>(
        &self,
        py: Python<'py>,
        samples: PyReadonlyArray1<'py, u64>,
        threads: usize,
    ) -> PyResult<Bound<'py, PyDict>> {
        let flat = self.ascending(&samples)?;
        let (all, (values, _)) = interruptible(py, None, |interrupt| {
            let all = self.map.samples_at(&flat, threads.max(1), self.isa, interrupt)?;
            let values = self.map.values_at(&flat, &all, threads.max(1), self.isa, interrupt)?;
            Ok::<_, Error>((all, values))
        })??;
        let dict = PyDict::new(py);
        dict.set_item("measures", values.into_pyarray(py).reshape([flat.len(), self.map.measures.len()])?)?;
        dict.set_item("class", convert::column(py, &all, |(_, class, _)| *class as u8)?)?;
        dict.set_item("status", convert::column(py, &all, |(.., one)| one.status as u8)?)?;
        dict.set_item("exact", convert::column(py, &all, |(.., one)| one.exact)?)?;
        dict.set_item("flips", convert::column(py, &all, |(.., one)| one.flips as i64)?)?;
        dict.set_item("steps", convert::column(py, &all, |(.., one)| one.steps as i64)?)?;
        for (name, of) in OUTCOME_NUMBERS {
            dict.set_item(name, convert::column(py, &all, |(.., one)| of(one))?)?;
        }
        Ok(dict)
    }
}

impl MapJob {
    /// The numbers of samples, if the map has such samples and they ascend.
    fn ascending(&self, samples: &PyReadonlyArray1<'_, u64>) -> PyResult<Vec<u64>> {
        let flat = self.numbers(samples)?;
        if !flat.is_sorted_by(|one, next| one < next) {
            let rule = "must be in ascending order, each once";
            return Err(Error::Value { argument: "samples", value: "of the map".into(), rule }.into());
        }
        Ok(flat)
    }

    /// The numbers of samples, if the map has such samples.
    fn numbers(&self, samples: &PyReadonlyArray1<'_, u64>) -> PyResult<Vec<u64>> {
        let samples = samples.as_array();
        if let Some(sample) = samples.iter().find(|&&sample| sample >= self.map.len()) {
            let value = format!("{sample} of {}", self.map.len());
            return Err(Error::Value { argument: "samples", value, rule: "must be an index" }.into());
        }
        Ok(memory::collected("numbers of samples", samples.len(), samples.iter().copied())?)
    }
}
