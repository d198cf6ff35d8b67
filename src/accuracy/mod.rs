//! States by steps that are as accurate as asked for, with their errors.
//!
//! A run is compared with another one, by shorter steps or by a larger tolerance (`second_run`, `tolerances`); from their
//! distance its error follows (`comparison`). A body whose error is above the accuracy is run again. No number of a body
//! depends on the bodies beside it: the same kinds of forces act on all of a request. The times at which bodies cross surfaces
//! have errors of their own (`crossings`).

mod batch;
mod comparison;
mod crossings;
mod second_run;
mod tolerances;

pub use crossings::{CROSSING_TOLERANCE, crossings};
pub use second_run::ELSEWHERE;
pub use tolerances::{LEAST_UNDER_FUNCTION, SERIES_TOLERANCE, first_tolerance};

use crate::call::Call;
use crate::error::Error;
use crate::estimate::{Estimate, longest_interval};
use crate::kinematics::plain_dot;
use crate::memory;
use crate::method::{Method, SERIES};
use crate::trajectory::{Request, StatesPart};
use batch::{Batch, Job, Solver, picked};
use comparison::{Coarser, Rows, estimate, of_finished, with_phase_errors, write};
use second_run::{
    HALVINGS, HALVINGS_AGAIN, RUNGE_KUTTA, Steps, is_damped_stiffly, is_refined_alike, step_ratio,
};
use std::cell::Cell;
use tolerances::{APART, COARSER_TOLERANCE, coarser_run, finest_tolerance, is_ruled_by_rounding};

/// Angle (rad) between the rates of a body that turns about one direction: far above rounding.
const ONE_DIRECTION: f64 = 1e-9;

/// Largest number of times that the steps of a body are shortened to reach an accuracy.
const ATTEMPTS: i32 = 8;

/// Least factor by which an attempt must lower an error for another to be made. Where rounding or chaos does not keep the error,
/// an attempt lowers it by `MARGIN` at least.
const FALLS: f64 = 2.0;

/// Aim of shorter steps: the accuracy over this. Another attempt costs more than these steps.
const MARGIN: f64 = 4.0;

/// Least and largest factor by which an attempt shortens the steps.
const SHORTENED: [f64; 2] = [1.2, 8.0];

/// Steps shorter by a smaller factor may have larger errors: errors of few steps do not fall evenly.
const MUCH: f64 = 2.0;

/// Factor by which each attempt divides all steps under strong damping.
const DIVISION: f64 = 8.0;

/// How accurate states shall be.
#[derive(Clone, Copy, Debug)]
pub struct Asked {
    /// Largest error: tolerance or steps of a body are made smaller until its estimated error is smaller. None for a
    /// tolerance or a step that the user chose.
    pub accuracy: Option<f64>,
    /// Whether errors are estimated; without it there is one run.
    pub check: bool,
    /// Whether no method was asked for: a series follows where equal steps are not accurate.
    pub free: bool,
    /// Whether a torque or weight may stop the bodies, on which drag acts.
    pub may_stop: bool,
}

/// What is told of the states of some bodies.
pub struct Solved {
    /// Their errors.
    pub estimates: Vec<Estimate>,
    /// Which of them a series made, where steps did not.
    pub by_series: Vec<bool>,
    /// Processor time of all runs.
    pub nanoseconds: u64,
}

impl Solved {
    /// Of a run without estimates.
    pub fn unjudged(nanoseconds: u64) -> Self {
        Solved { estimates: Vec::new(), by_series: Vec::new(), nanoseconds }
    }
}

/// Writes the states of a request by steps, at times, and estimates their errors. The steps of the request are the longest
/// ones, or none, if the method chooses them.
///
/// # Errors
/// As `simulate_into`.
pub fn solve(
    request: &Request,
    method: &'static Method,
    asked: Asked,
    mut states: StatesPart,
    call: Call,
) -> Result<Solved, Error> {
    let nanoseconds = Cell::new(0);
    let job = Job { scene: request.scene, record: request.record, call, nanoseconds: &nanoseconds };
    let batch = Batch::of(request, job);
    let solver = Solver {
        method,
        tolerance: request.tolerance,
        max_steps: request.max_steps,
        may_stop: asked.may_stop,
    };
    let longest = (!request.steps.is_empty()).then_some(request.steps);
    let mut series_made = memory::filled("bodies by a series", batch.len(), false)?;
    let estimates = match (asked.accuracy, longest) {
        (Some(accuracy), _) if solver.tolerance.is_some() => {
            if asked.free && method.facts.name == SERIES.facts.name {
                by_series(&batch, solver, accuracy, asked.check, &mut states)?
            } else {
                by_tolerance(&batch, solver, accuracy, asked.check, &mut states)?
            }
        }
        (Some(accuracy), Some(longest)) => {
            by_equal_steps(&batch, solver, longest, (accuracy, asked), &mut states, &mut series_made)?
        }
        _ => {
            batch.run_into(solver, longest, 1.0, states.again())?;
            let steps = Steps { longest, ..Steps::ADAPTIVE };
            let rows = Rows::all(&states);
            let own =
                if asked.check { estimate(&batch, solver, rows, steps, None)? } else { unknown(&batch)? };
            with_phase_errors(&batch, rows, own)
        }
    };
    Ok(Solved { estimates, by_series: series_made, nanoseconds: nanoseconds.get() })
}

/// The states by the tolerance of the request, or down to rounding.
fn by_tolerance(
    batch: &Batch,
    solver: Solver,
    accuracy: f64,
    check: bool,
    states: &mut StatesPart,
) -> Result<Vec<Estimate>, Error> {
    batch.run_into(solver, None, 1.0, states.again())?;
    if !check {
        return Ok(with_phase_errors(batch, Rows::all(states), unknown(batch)?));
    }
    let mut all = errors_by_tolerance(batch, solver, Rows::all(states), accuracy, None)?;
    let (finest, pending) = (finest_tolerance(solver.method), above(&all, accuracy)?);
    if !pending.is_empty() && solver.tolerance > Some(finest) {
        let (some, finer) = (batch.select(&pending)?, Solver { tolerance: Some(finest), ..solver });
        let mut others = some.run(finer, None, 1.0)?;
        let others = others.whole();
        let own = errors_by_tolerance(&some, finer, Rows::all(&others), accuracy, None)?;
        take_better(batch, (states, &mut all), &pending, (&others, &own))?;
    }
    Ok(all)
}

/// The states by a series that leaves rounding alone.
///
/// Bodies that drag may stop are integrated in equal steps, for an accuracy in shorter ones.
fn by_series(
    batch: &Batch,
    solver: Solver,
    accuracy: f64,
    check: bool,
    states: &mut StatesPart,
) -> Result<Vec<Estimate>, Error> {
    let solver = Solver { method: SERIES, tolerance: Some(SERIES_TOLERANCE), ..solver };
    batch.run_into(solver, None, 1.0, states.again())?;
    let stops = stopping(batch, solver, states)?;
    let rows = Rows::all(states);
    let mut all = if check {
        let smooth = Solver { may_stop: false, ..solver };
        errors_by_tolerance(batch, smooth, rows, accuracy, Some(&stops))?
    } else {
        with_phase_errors(batch, rows, unknown(batch)?)
    };
    if !stops.is_empty() {
        let some = batch.select(&stops)?;
        let equal = Solver { method: RUNGE_KUTTA, tolerance: None, ..solver };
        let asked = Asked { accuracy: Some(accuracy), check, free: false, may_stop: solver.may_stop };
        let longest = some.longest_steps(RUNGE_KUTTA)?;
        let mut others = some.reserved(equal)?;
        let mut others = others.whole();
        let own = by_equal_steps(&some, equal, &longest, (accuracy, asked), &mut others, &mut [])?;
        for (row, &body) in stops.iter().enumerate() {
            states.copy(batch.number_of_times(), body, &others, row);
        }
        write(&mut all, &stops, &own);
    }
    Ok(all)
}

/// The errors of states by a tolerance, from a run by a larger one.
///
/// Where rounding is the error, and the coarser run does not show that a body is accurate, several finer runs do; not for bodies
/// that drag stops, whose errors are found otherwise. Where a torque or a stop by drag may have corners, one finer run does.
fn errors_by_tolerance(
    batch: &Batch,
    solver: Solver,
    states: Rows,
    accuracy: f64,
    stops: Option<&[usize]>,
) -> Result<Vec<Estimate>, Error> {
    if !solver.method.is_series() || solver.may_stop {
        let own = estimate(batch, solver, states, Steps::ADAPTIVE, None)?;
        return Ok(with_phase_errors(batch, states, own));
    }
    // Of bodies at the step limit no error is known, and the coarser run has a far higher one.
    let of_some = |some: &[usize], batch: &Batch, states: Rows| {
        let is_stop = |body: &usize| stops.is_some_and(|stops| stops.binary_search(body).is_ok());
        let count = some.iter().filter(|body| is_stop(body)).count();
        let rows = some.iter().enumerate().filter(|(_, body)| is_stop(body)).map(|(row, _)| row);
        let stops = memory::collected("bodies that drag may stop", count, rows)?;
        errors_by_tolerance(batch, solver, states, accuracy, Some(&stops))
    };
    if let Some(all) = of_finished(batch, states, of_some)? {
        return Ok(with_phase_errors(batch, states, all));
    }
    let to_rounding = is_ruled_by_rounding(solver);
    let tolerance = match solver.tolerance {
        Some(tolerance) if !to_rounding => APART * tolerance,
        _ => COARSER_TOLERANCE,
    };
    let mut coarser = coarser_run(batch, solver, tolerance)?;
    let coarser = coarser.whole();
    let coarser = Coarser { states: Rows::all(&coarser), tolerance: (!to_rounding).then_some(tolerance) };
    let again = Steps { halvings: HALVINGS_AGAIN, ..Steps::ADAPTIVE };
    let mut all = estimate(batch, solver, states, again, Some(coarser))?;
    if to_rounding {
        let mut rough = above(&all, accuracy)?;
        rough.retain(|body| stops.is_none_or(|stops| stops.binary_search(body).is_err()));
        if !rough.is_empty() {
            let rows = states.rows_of(&rough)?;
            let rows = Rows { rows: Some(&rows), ..states };
            let own = estimate(&batch.select(&rough)?, solver, rows, Steps::ADAPTIVE, None)?;
            write(&mut all, &rough, &own);
        }
    }
    Ok(with_phase_errors(batch, states, all))
}

/// The bodies that drag may stop: those that turn about one direction at all times.
///
/// The rates of others vanish one after another, and their speed is a series.
fn stopping(batch: &Batch, solver: Solver, states: &StatesPart) -> Result<Vec<usize>, Error> {
    let mut stops = Vec::new();
    if !solver.may_stop {
        return Ok(stops);
    }
    let m = batch.number_of_times();
    let (recorded, _) = states.omega.as_deref().unwrap_or(&[]).as_chunks::<3>();
    for (index, body) in batch.bodies.iter().enumerate() {
        let rates = || std::iter::once(&body.omega).chain(&recorded[index * m..][..m]);
        let square = |v: &[f64; 3]| plain_dot(v, v);
        let fastest = rates().fold(&body.omega, |a, b| if square(b) > square(a) { b } else { a });
        let [a, b, c] = *fastest;
        let is_along = |&[x, y, z]: &[f64; 3]| {
            let across = [y * c - z * b, z * a - x * c, x * b - y * a];
            square(&across).sqrt() <= ONE_DIRECTION * square(fastest)
        };
        if rates().all(is_along) {
            memory::push("bodies that drag may stop", &mut stops, index)?;
        }
    }
    Ok(stops)
}

/// The states by about these steps; of bodies that are not accurate by shorter ones.
///
/// Without a method a series follows that leaves rounding alone, not shorter steps: chaos or a saddle magnifies errors. The speed
/// of a body that drag may stop is no series.
fn by_equal_steps(
    batch: &Batch,
    solver: Solver,
    longest: &[f64],
    (accuracy, asked): (f64, Asked),
    states: &mut StatesPart,
    series_made: &mut [bool],
) -> Result<Vec<Estimate>, Error> {
    // Steps longer than any interval between output times are cut to the interval.
    let cut = |(body, &step): (usize, &f64)| match longest_interval(batch.times_of(body)) {
        interval if step > interval => interval,
        _ => step,
    };
    let mut longest = memory::collected("steps", batch.len(), longest.iter().enumerate().map(cut))?;
    if !asked.check {
        let refined = is_refined_alike(batch, solver);
        let ratio = if refined { step_ratio(batch, solver.method, HALVINGS) } else { 1.0 };
        batch.run_into(solver, Some(&longest), ratio, states.again())?;
        return Ok(with_phase_errors(batch, Rows::all(states), unknown(batch)?));
    }
    let steps = Steps { longest: Some(&longest), refinement: 1.0, halvings: HALVINGS };
    let mut all = checked(batch, solver, steps, states)?;
    let mut pending = above(&all, accuracy)?;
    let stiffly = is_damped_stiffly(batch, solver.method);
    if asked.free && !pending.is_empty() && !(stiffly || solver.may_stop) {
        let some = batch.select(&pending)?;
        let mut others = some.reserved(solver)?;
        let mut others = others.whole();
        let own = by_series(&some, solver, accuracy, true, &mut others)?;
        let better = take_better(batch, (states, &mut all), &pending, (&others, &own))?;
        for (&body, better) in pending.iter().zip(better) {
            series_made[body] = better;
        }
        return Ok(all);
    }
    for attempt in 1..=ATTEMPTS {
        if pending.is_empty() {
            break;
        }
        // What the start forgets at once needs short steps there, not everywhere.
        let refinement = if stiffly { DIVISION.powi(attempt) } else { 1.0 };
        let mut shortened = memory::reserved("steps", pending.len())?;
        for &body in &pending {
            if stiffly {
                shortened.push(DIVISION);
            } else {
                shortened.push(step_reduction(all[body].error, accuracy, solver.method.facts.order));
                longest[body] /= shortened[shortened.len() - 1];
            }
        }
        let before: Vec<Estimate> = picked("errors", &all, &pending)?;
        let some = batch.select(&pending)?;
        let shorter = picked("steps", &longest, &pending)?;
        let steps = Steps { longest: Some(&shorter), refinement, halvings: HALVINGS_AGAIN };
        let mut others = some.reserved(solver)?;
        let mut others = others.whole();
        let own = checked(&some, solver, steps, &mut others)?;
        let better = take_better(batch, (states, &mut all), &pending, (&others, &own))?;
        let helped = |k: usize| {
            own[k].error < before[k].error / FALLS
                || better[k] && (stiffly || before[k].error >= 1.0)
                || shortened[k] < MUCH && attempt == 1
        };
        let mut at = 0..pending.len();
        pending.retain(|_| at.next().is_some_and(|k| helped(k) && own[k].error > accuracy));
    }
    Ok(all)
}

/// Writes the states of a run whose steps are shorter than these, and estimates their errors from a run by these. Where the
/// second run differs in more than shorter steps, the states are those of the run by these steps.
fn checked(
    batch: &Batch,
    solver: Solver,
    steps: Steps,
    states: &mut StatesPart,
) -> Result<Vec<Estimate>, Error> {
    let Steps { longest, refinement, halvings } = steps;
    let own = if is_refined_alike(batch, solver) {
        let mut coarser = batch.rounded_otherwise(0)?.run(solver, longest, refinement)?;
        let ratio = step_ratio(batch, solver.method, halvings);
        batch.run_into(solver, longest, refinement * ratio, states.again())?;
        let coarser = coarser.whole();
        let coarser = Coarser { states: Rows::all(&coarser), tolerance: None };
        estimate(batch, solver, Rows::all(states), steps, Some(coarser))?
    } else {
        batch.run_into(solver, longest, refinement, states.again())?;
        estimate(batch, solver, Rows::all(states), steps, None)?
    };
    Ok(with_phase_errors(batch, Rows::all(states), own))
}

/// The factor by which steps must shrink for an error to fall well below the accuracy.
fn step_reduction(error: f64, accuracy: f64, order: u32) -> f64 {
    let excess = MARGIN * error / accuracy;
    // Square roots are rounded alike on every processor.
    let root = if order.is_power_of_two() {
        (0..order.ilog2()).fold(excess, |root, _| root.sqrt())
    } else {
        excess.powf(1.0 / f64::from(order))
    };
    root.clamp(SHORTENED[0], SHORTENED[1])
}

/// Copies the states of some bodies, with their errors, where those are smaller; which of the bodies.
fn take_better(
    batch: &Batch,
    (states, all): (&mut StatesPart, &mut [Estimate]),
    some: &[usize],
    (others, own): (&StatesPart, &[Estimate]),
) -> Result<Vec<bool>, Error> {
    let mut better = memory::filled("bodies", some.len(), false)?;
    for (row, (&body, better)) in some.iter().zip(&mut better).enumerate() {
        *better = own[row].error < all[body].error;
        if *better {
            states.copy(batch.number_of_times(), body, others, row);
            all[body] = own[row];
        }
    }
    Ok(better)
}

/// The bodies whose error is above the accuracy.
fn above(all: &[Estimate], accuracy: f64) -> Result<Vec<usize>, Error> {
    let some = || all.iter().enumerate().filter(|(_, own)| own.error > accuracy);
    memory::collected("bodies", some().count(), some().map(|(body, _)| body))
}

fn unknown(batch: &Batch) -> Result<Vec<Estimate>, Error> {
    memory::filled("errors of the bodies", batch.len(), Estimate::UNKNOWN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_shrink_by_the_root_of_the_excess() {
        // The excess is 4 error / accuracy.
        assert_eq!(step_reduction(4.0, 1.0, 4), 2.0);
        assert!((step_reduction(16.0, 1.0, 6) - 2.0).abs() < 1e-15);
        assert_eq!([0.0, f64::INFINITY].map(|error| step_reduction(error, 1.0, 2)), SHORTENED);
    }
}
