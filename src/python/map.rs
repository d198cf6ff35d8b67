//! Stability maps.

use super::convert::{
    self, Aligned1, Aligned2, bodies, interruptible, interruptible_calls, rows, rows_of, same_length,
};
use super::forces::PyForces;
use crate::call::Call;
use crate::error::Error;
use crate::float_environment::FloatEnvironment;
use crate::inertia::MomentStatus;
use crate::map::{
    Bin, Check, Class, Column, Condition, Criterion, Distributions, Field, Logic, Map, Measure, Mixed,
    OF_START, Outcome, Pixel, Sketch, Statistics, Value, Verdict, clopper_pearson_of_each,
};
use crate::memory;
use crate::method::AnyMethod;
use crate::parallel::Interrupt;
use crate::sample::{self, Distribution, Empirical};
use crate::scene::Scene;
use crate::simd::Isa;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::mem;
use std::sync::Mutex;

/// What the columns of a map are called if they do not fit into memory.
const PIXELS: &str = "pixels of the map";
const GIVEN: &str = "given samples";

/// A deviate of unit size for each sample of a pixel, from a block of draws that is neither of its rates nor of its attitude.
#[pyfunction]
pub fn deviates<'py>(
    py: Python<'py>,
    distribution: &str,
    seed: u128,
    block: u64,
    pixels: Aligned1<'py, u64>,
    samples: Aligned1<'py, u64>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let (distribution, key) =
        (Distribution::parse("distribution", distribution)?, [seed as u64, (seed >> 64) as u64]);
    let (pixels, samples) = (pixels.as_array(), samples.as_array());
    same_length("samples", pixels.len(), samples.len())?;
    let drawn = pixels.iter().zip(samples).map(|(&pixel, &sample)| {
        let [first, ..] =
            sample::vector(distribution, sample::uniforms(key, OF_START + block, sample, pixel));
        first
    });
    Ok(memory::collected("deviates", pixels.len(), drawn)?.into_pyarray(py))
}

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
    successes: Aligned1<'py, i64>,
    trials: Aligned1<'py, i64>,
    confidence: f64,
) -> PyResult<[Bound<'py, PyArray1<f64>>; 2]> {
    let (successes, trials) = (successes.as_array(), trials.as_array());
    same_length("trials", successes.len(), trials.len())?;
    let mut counts = memory::reserved("counts of shares", successes.len())?;
    for (&successes, &trials) in successes.iter().zip(trials) {
        counts.push([count("successes", successes)?, count("trials", trials)?]);
    }
    let intervals = interruptible(py, None, |stop| clopper_pearson_of_each(&counts, confidence, stop))??;
    Ok([convert::column(py, &intervals, |ends| ends[0])?, convert::column(py, &intervals, |ends| ends[1])?])
}

/// A time, NaN for never.
fn finite(time: f64) -> f64 {
    if time < f64::INFINITY { time } else { f64::NAN }
}

/// A number that counts.
fn count(argument: &'static str, value: i64) -> Result<u64, Error> {
    let wrong = |_| Error::value(argument, value, "must not be negative");
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
                let values = values.extract::<Aligned1<'_, i64>>()?;
                fit(values.as_array().len())?;
                for (pixel, &value) in pixels.iter_mut().zip(values.as_array()) {
                    *of(pixel) = count(column.name, value)?;
                }
            }
            Field::Fixed(of) => {
                let values = values.extract::<Aligned1<'_, i64>>()?;
                fit(values.as_array().len())?;
                pixels.iter_mut().zip(values.as_array()).for_each(|(pixel, &value)| *of(pixel) = value);
            }
            Field::Number(of) => {
                let values = values.extract::<Aligned1<'_, f64>>()?;
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

    /// Merges a part in, by the reduction of each column: its rows are of `pixels`, each of which may have several. The
    /// order of the parts has no effect. A part that is refused changes nothing.
    fn merge(&self, part: &Bound<'_, PyDict>) -> PyResult<()> {
        let _standard = FloatEnvironment::standard();
        let places = part.as_any().get_item("pixels")?.extract::<Aligned1<'_, i64>>()?;
        let bins: Vec<Aligned2<'_, i64>> = match part.get_item("measures")? {
            Some(bins) => bins.extract()?,
            None => Vec::new(),
        };
        let mut columns = read_columns(part)?;
        let mut all = self.all.lock().expect("no thread panics while it holds the statistics");
        let (pixels, sketches) = &mut *all;
        same_length("pixels", columns.len(), places.as_array().len())?;
        let index = |what: &str, number: i64, count: usize| {
            let rule = "must be pixels of the map";
            let inside = usize::try_from(number).ok().filter(|&index| index < count);
            inside.ok_or_else(|| Error::value("part", format_args!("{what} {number} of {count}"), rule))
        };
        let mut of_rows = memory::reserved(PIXELS, columns.len())?;
        for &place in places.as_array() {
            of_rows.push(index("pixel", place, pixels.len())?);
        }
        same_length("measures", self.measures, bins.len())?;
        let total = bins.iter().map(|bins| bins.as_array().nrows()).sum();
        let mut of_bins = memory::reserved("bins of the measures", total)?;
        for (measure, bins) in bins.iter().enumerate() {
            for &[row, ref numbers @ ..] in rows_of::<i64, ROW>("measures", bins)? {
                let pixel = of_rows[index("a bin of row", row, of_rows.len())?];
                of_bins.push((pixel * self.measures + measure, Bin::from_numbers(*numbers)?));
            }
        }
        of_bins.sort_unstable_by_key(|&(place, _)| place);
        for bins in of_bins.chunk_by(|(one, _), (next, _)| one == next) {
            sketches[bins[0].0].reserve(bins.iter().map(|(_, bin)| bin.count))?;
        }
        for row in 0..columns.len() {
            let mut merged = pixels[of_rows[row]];
            merged.merge(&columns[row]);
            // What was known, if this row or a later one is refused.
            columns[row] = mem::replace(&mut pixels[of_rows[row]], merged);
            if let Some(name) = merged.full() {
                (0..=row).rev().for_each(|row| pixels[of_rows[row]] = columns[row]);
                let (value, rule) =
                    (format_args!("{name} of pixel {}", of_rows[row]), "must have sums below 2^63");
                return Err(Error::value("part", value, rule).into());
            }
        }
        of_bins.iter().try_for_each(|(place, bin)| sketches[*place].put(bin))?;
        Ok(())
    }

    /// Adds values of a measure with their errors, each of a pixel; a value that is not finite is none, an error that is
    /// NaN is not known.
    fn add(
        &self,
        measure: usize,
        pixels: Aligned1<'_, u64>,
        values: Aligned1<'_, f64>,
        errors: Aligned1<'_, f64>,
    ) -> PyResult<()> {
        let _standard = FloatEnvironment::standard();
        let (pixels, values, errors) = (pixels.as_array(), values.as_array(), errors.as_array());
        same_length("values", pixels.len(), values.len())?;
        same_length("errors", pixels.len(), errors.len())?;
        let mut all = self.all.lock().expect("no thread panics while it holds the statistics");
        let sketches = &mut all.1;
        for ((&pixel, &number), &error) in pixels.iter().zip(values).zip(errors) {
            let at = usize::try_from(pixel).ok().and_then(|pixel| pixel.checked_mul(self.measures));
            let place = at.filter(|_| measure < self.measures).and_then(|at| sketches.get_mut(at + measure));
            let rule = "must be pixels and measures of the map";
            let refused = || Error::value("pixels", format_args!("{pixel} of measure {measure}"), rule);
            let place = place.ok_or_else(refused)?;
            place.add(&Value { number, error: if error.is_finite() { error.abs() } else { f64::NAN } })?;
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

    /// The bins of the sketches of each measure, (n, 10) each: pixel; key, count, least and largest offset; sum of the
    /// offsets and of their squares, in two halves each; the bits of the largest error, -1 if none is known.
    fn bins<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyArray2<i64>>>> {
        let all = self.all.lock().expect("no thread panics while it holds the statistics");
        bins_by_measure(py, &all.1, self.measures)
    }
}

/// What is asked of a map, as `rigid.maps.core_request` describes it: `Map`, column by column.
#[derive(FromPyObject)]
struct MapRequest<'py> {
    scene: String,
    method: String,
    moments: Aligned2<'py, f64>,
    physical: bool,
    weight: Aligned2<'py, f64>,
    starts: Vec<StartsRequest<'py>>,
    shares: Vec<f64>,
    conditions: Vec<(String, i32, Vec<f64>)>,
    logic: String,
    measures: Vec<(String, i32, Vec<f64>)>,
    t_end: f64,
    step: Option<f64>,
    max_steps: u64,
    samples: u64,
    checked: Option<u64>,
    seed: u128,
    forces: Option<PyRef<'py, PyForces>>,
    numbers: Option<Aligned1<'py, u64>>,
    first: Option<Aligned1<'py, u64>>,
}

/// `Distributions`, with the nominal start and the sizes of each pixel.
#[derive(FromPyObject)]
struct StartsRequest<'py> {
    omega: Aligned2<'py, f64>,
    omega_noise: String,
    omega_size: Aligned2<'py, f64>,
    attitude: Aligned2<'py, f64>,
    attitude_noise: String,
    attitude_size: Aligned2<'py, f64>,
    mix: Option<Aligned2<'py, f64>>,
    mixed: [bool; 2],
    given_omega: Option<Aligned2<'py, f64>>,
    given_attitude: Option<Aligned2<'py, f64>>,
    given_shares: Option<Aligned1<'py, f64>>,
}

impl StartsRequest<'_> {
    /// The pixels with these moments and weights, and their distributions.
    fn pixels(
        &self,
        moments: &[[f64; 3]],
        weight: &[[f64; 3]],
        status: &[u8],
    ) -> PyResult<(Vec<Pixel>, Distributions)> {
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
        Ok((memory::collected(PIXELS, pixels, (0..pixels).map(pixel))?, self.distributions()?))
    }

    fn distributions(&self) -> PyResult<Distributions> {
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
        let empirical = match &self.given_omega {
            Some(omega) => {
                let of_rates = rows::<3>("given_omega", omega)?;
                let count = of_rates.len();
                let mut empirical = Empirical {
                    omega: memory::collected(GIVEN, count, of_rates.iter().copied())?,
                    attitude: Vec::new(),
                    cumulative: Vec::new(),
                };
                if let Some(attitude) = &self.given_attitude {
                    let rotations = rows::<4>("given_attitude", attitude)?;
                    same_length("given_attitude", count, rotations.len())?;
                    empirical.attitude = memory::collected(GIVEN, count, rotations.iter().copied())?;
                }
                if let Some(shares) = &self.given_shares {
                    same_length("given_shares", count, shares.as_array().len())?;
                    empirical.cumulative =
                        memory::collected(GIVEN, count, shares.as_array().iter().copied())?;
                }
                Some(empirical)
            }
            None => None,
        };
        Ok(Distributions {
            omega: Distribution::parse("omega_noise", &self.omega_noise)?,
            attitude: Distribution::parse("attitude_noise", &self.attitude_noise)?,
            mix,
            mixed: self.mixed,
            empirical,
        })
    }
}

impl MapRequest<'_> {
    /// The map, and the status of the moments of each pixel.
    fn map(self) -> PyResult<(Map, Vec<u8>)> {
        let moments = rows::<3>("moments", &self.moments)?;
        let pixels = moments.len();
        let status = moments.iter().map(|&m| MomentStatus::of(m, self.physical) as u8);
        let status = memory::collected(PIXELS, pixels, status)?;
        let weight = rows::<3>("weight", &self.weight)?;
        same_length("shares", self.starts.len(), self.shares.len())?;
        let Some((nominal, others)) = self.starts.split_first() else {
            return Err(Error::value("starts", "()", "must not be empty").into());
        };
        let (starting, distributions) = nominal.pixels(moments, weight, &status)?;
        let mut mixture = Vec::new();
        for (starts, &until) in self.starts.iter().zip(&self.shares).filter(|_| !others.is_empty()) {
            let (pixels, distributions) = starts.pixels(moments, weight, &status)?;
            memory::push(PIXELS, &mut mixture, Mixed { until, distributions, pixels })?;
        }
        let forces = self.forces.as_ref().map(|forces| forces.0.copied()).transpose()?;
        let of_each = |name, numbers: &Option<Aligned1<'_, u64>>| -> PyResult<Vec<u64>> {
            let Some(numbers) = numbers.as_ref().map(|numbers| numbers.as_array()) else {
                return Ok(Vec::new());
            };
            same_length(name, pixels, numbers.len())?;
            Ok(memory::collected(PIXELS, pixels, numbers.iter().copied())?)
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
            method: AnyMethod::parse(&self.method)?,
            pixels: starting,
            distributions,
            mixture,
            conditions,
            logic: Logic::parse(&self.logic, self.conditions.len())?,
            measures: self
                .measures
                .iter()
                .map(|(name, axis, numbers)| Measure::parse(name, *axis, numbers))
                .collect::<Result<_, Error>>()?,
            t_end: self.t_end,
            step: self.step,
            max_steps: self.max_steps,
            samples: self.samples,
            check: self.checked.map_or(Check::Doubtful, Check::Before),
            key: [self.seed as u64, (self.seed >> 64) as u64],
            numbers: of_each("numbers", &self.numbers)?,
            first: of_each("first", &self.first)?,
        };
        Ok((map.checked()?, status))
    }
}

/// The values of the measures of samples and their errors, a row a sample, and the steps of their runs.
type ValuesAndSteps<'py> = ([Bound<'py, PyArray2<f64>>; 2], Bound<'py, PyArray1<u64>>);

/// A number of an outcome and its name.
type OutcomeNumber = (&'static str, fn(&Outcome) -> f64);

const OUTCOME_NUMBERS: [OutcomeNumber; 8] = [
    ("left", |one| finite(one.left)),
    ("tilt", |one| one.tilt),
    ("exponent", |one| one.exponent),
    ("mean_megno", |one| one.mean_megno),
    ("energy_drift", |one| one.energy_drift),
    ("momentum_drift", |one| one.momentum_drift),
    ("unit_drift", |one| one.unit_drift),
    ("step", |one| one.step),
];

/// Writes what became of samples as one array a number.
fn write_outcomes<'py>(py: Python<'py>, all: &[Verdict]) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("class", convert::column(py, all, |one| one.class as u8)?)?;
    dict.set_item("status", convert::column(py, all, |one| one.first.status as u8)?)?;
    dict.set_item("exact", convert::column(py, all, |one| one.first.exact)?)?;
    dict.set_item("flips", convert::column(py, all, |one| one.first.flips as i64)?)?;
    dict.set_item("steps", convert::column(py, all, |one| one.first.steps as i64)?)?;
    for (name, of) in OUTCOME_NUMBERS {
        dict.set_item(name, convert::column(py, all, |one| of(&one.first))?)?;
    }
    Ok(dict)
}

/// What became of samples that were not run: arrays of a number each. `class` and `status` are codes in the order of
/// their names.
#[pyfunction]
pub fn unknown_outcomes(py: Python<'_>, count: usize) -> PyResult<Bound<'_, PyDict>> {
    write_outcomes(py, &memory::filled("outcomes of the samples", count, Verdict::NONE)?)
}

/// The names of the classes of bodies, in the order of their codes.
#[pyfunction]
pub fn class_names() -> Vec<&'static str> {
    Class::ALL.into_iter().map(Class::name).collect()
}

/// The class of a body, by those of its first and its second run.
#[pyfunction]
pub fn agreed_classes() -> [[u64; 4]; 4] {
    Class::ALL.map(|first| Class::ALL.map(|second| first.agreed(second) as u64))
}

#[pymethods]
impl MapJob {
    #[new]
    fn new(request: MapRequest<'_>) -> PyResult<Self> {
        let _standard = FloatEnvironment::standard();
        let (map, status) = request.map()?;
        Ok(MapJob { map, status, isa: Isa::current()? })
    }

    /// Status of the moments of each pixel: 0 possible, 1 not finite, 2 not positive, 3 triangle inequality.
    #[getter]
    fn status<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<u8>>> {
        convert::column(py, &self.status, |&status| status)
    }

    /// Statistics of the samples start .. stop (pixel-major) for the `pixels` that they touch; None if
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
            let rule = "must be a range of the samples of the map";
            return Err(Error::value("start, stop", format_args!("({start}, {stop})"), rule).into());
        }
        let calls = self.map.calls_functions();
        let result = interruptible_calls(py, interrupted, calls, |wish| {
            self.map.run(start, stop, self.call(threads, wish))
        })?;
        let (first, statistics, sketches) = match result {
            Err(Error::Stopped) => return Ok(None),
            result => result?,
        };
        let dict = PyDict::new(py);
        let pixels = first..first + statistics.len() as u64;
        dict.set_item(
            "pixels",
            memory::collected(PIXELS, statistics.len(), pixels.map(|pixel| pixel as i64))?.into_pyarray(py),
        )?;
        write_columns(py, &dict, &statistics)?;
        dict.set_item("measures", bins_by_measure(py, &sketches, self.map.measures.len())?)?;
        Ok(Some(dict))
    }

    /// The starts of samples, numbered pixel by pixel: rates (n, 3) and attitudes (n, 4), one after the other.
    fn starts<'py>(
        &self,
        py: Python<'py>,
        samples: Aligned1<'py, u64>,
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

    /// The values of the measures of samples, numbered pixel by pixel in ascending order, sample by sample, and their errors;
    /// and the steps of their runs. What follows from a classification is NaN: nothing is classified.
    fn measured<'py>(
        &self,
        py: Python<'py>,
        samples: Aligned1<'py, u64>,
        threads: usize,
    ) -> PyResult<ValuesAndSteps<'py>> {
        let flat = self.ascending(&samples)?;
        let (values, steps) = interruptible_calls(py, None, self.map.calls_functions(), |stop| {
            self.map.values_at(&flat, &[], self.call(threads, stop))
        })??;
        let shape = [flat.len(), self.map.measures.len()];
        let numbers = convert::column(py, &values, |value| value.number)?.reshape(shape)?;
        let errors = convert::column(py, &values, |value| value.error)?.reshape(shape)?;
        Ok(([numbers, errors], steps.into_pyarray(py)))
    }

    /// What became of samples, numbered pixel by pixel in ascending order: the arrays of `unknown_outcomes`, with the bits
    /// of the map; `measures`, the values of the measures, sample by sample; and `part_class` and `part_left` of each
    /// condition.
    fn outcomes<'py>(
        &self,
        py: Python<'py>,
        samples: Aligned1<'py, u64>,
        threads: usize,
    ) -> PyResult<Bound<'py, PyDict>> {
        let flat = self.ascending(&samples)?;
        let calls = self.map.calls_functions();
        let ((all, parts), (values, _)) = interruptible_calls(py, None, calls, |stop| {
            stop.expect(flat.len(), 0..flat.len());
            let known = self.map.samples_at(&flat, self.call(threads, stop))?;
            let values = self.map.values_at(&flat, &known.0, self.call(threads, stop))?;
            Ok::<_, Error>((known, values))
        })??;
        let dict = write_outcomes(py, &all)?;
        let shape = [flat.len(), self.map.measures.len()];
        dict.set_item("measures", convert::column(py, &values, |value| value.number)?.reshape(shape)?)?;
        let shape = [flat.len(), self.map.conditions.len()];
        let class = convert::column(py, &parts, |&(class, _)| class as u8)?;
        dict.set_item("part_class", class.reshape(shape)?)?;
        dict.set_item("part_left", convert::column(py, &parts, |&(_, left)| finite(left))?.reshape(shape)?)?;
        Ok(dict)
    }
}

impl MapJob {
    fn call<'a>(&self, threads: usize, stop: &'a Interrupt<'a>) -> Call<'a> {
        Call { isa: self.isa, threads: threads.max(1), stop }
    }

    /// The numbers of samples, if the map has such samples and they ascend.
    fn ascending(&self, samples: &Aligned1<'_, u64>) -> PyResult<Vec<u64>> {
        let flat = self.numbers(samples)?;
        if !flat.is_sorted_by(|one, next| one < next) {
            return Err(Error::value("samples", "of the map", "must be in ascending order, each once").into());
        }
        Ok(flat)
    }

    /// The numbers of samples, if the map has such samples.
    fn numbers(&self, samples: &Aligned1<'_, u64>) -> PyResult<Vec<u64>> {
        let samples = samples.as_array();
        if let Some(sample) = samples.iter().find(|&&sample| sample >= self.map.len()) {
            let rule = "must be an index";
            return Err(Error::value("samples", format_args!("{sample} of {}", self.map.len()), rule).into());
        }
        Ok(memory::collected("numbers of samples", samples.len(), samples.iter().copied())?)
    }
}
