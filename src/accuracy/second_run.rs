//! The second run of bodies, which is compared with their run to estimate its error.
//!
//! It begins at a start that is rounded otherwise, and takes shorter steps.

use super::batch::{Batch, Solver};
use crate::error::Error;
use crate::memory;
use crate::method::{DOP853, FUNCTION, MIDPOINT, Method, TAYLOR16, TAYLOR20, TAYLOR26};
use crate::real::smaller;
use crate::trajectory::States;

/// Number of halvings of the truncation error in the second run.
pub const HALVINGS: f64 = 2.0;

/// Halvings in the second run where the motion multiplies errors, as for bodies integrated again.
///
/// Two runs of which one errs by a quarter of the other then err alike by chance in 5 of 100 cases, by a sixteenth in 1 or 2.
pub const HALVINGS_AGAIN: f64 = 4.0;

/// The second run of a run by tolerance divides the tolerance by this.
///
/// Series of different order may err alike at tolerances that are alike.
pub const TIGHTER: f64 = 1000.0;

/// Least tolerance of a second run.
const FINEST: f64 = 1e-20;

/// Least number of steps of a second run: the errors of fewer do not fall evenly.
const FEWEST: f64 = 16.0;

/// Factor by which the steps of the second run are shorter for a body that drag may stop.
///
/// Steps of a quarter leave one error in a hundred above the stated error, by up to 20 times.
const FINER: f64 = 8.0;

/// The method of a body that drag may stop where a series is the method of others, or of the first run.
pub const RUNGE_KUTTA: &Method = &DOP853;

/// The second run of a series that does not carry its rounding errors on.
const COMPENSATED: &Method = &TAYLOR16;

/// Factor by which the longest step under a function is shorter in the second run by a tolerance: the golden ratio.
///
/// It is no ratio of small whole numbers: both runs look at the torque in different places.
pub const ELSEWHERE: f64 = 1.618_033_988_749_895;

/// The longest steps of a run (s); None for those of its method. A leg takes `refinement` times as many, and the second run
/// halves the truncation error so many times.
#[derive(Clone, Copy)]
pub struct Steps<'a> {
    pub longest: Option<&'a [f64]>,
    pub refinement: f64,
    pub halvings: f64,
}

impl Steps<'_> {
    /// The steps of adaptive methods.
    pub const ADAPTIVE: Steps<'static> = Steps { longest: None, refinement: 1.0, halvings: HALVINGS };
}

/// The states of the same bodies at the same times, with shorter steps than those taken.
///
/// Nearly all of their distance from the states of the run is the error of the run. The start is rounded in one of `ROUNDINGS`
/// ways, or as it is.
pub fn second_run(
    batch: &Batch,
    solver: Solver,
    steps: Steps,
    taken: &[u64],
    rounding: Option<usize>,
) -> Result<States, Error> {
    let rounded = rounding.map(|rounding| batch.rounded_otherwise(rounding)).transpose()?;
    let (again, solver) = (rounded.as_ref().unwrap_or(batch), solver.with_more_steps());
    let method = solver.method;
    if solver.may_stop {
        return past_stops(again, solver, steps, taken);
    }
    if let Some(tolerance) = solver.tolerance {
        let (mut tighter, mut refinement) = (TIGHTER, 1.0);
        let other = if !method.is_series() {
            // The only one under the torque of a function.
            refinement = ELSEWHERE;
            FUNCTION
        } else if method.facts.name == TAYLOR26.facts.name {
            &TAYLOR20
        } else {
            // Of equal order the first steps of both runs would be one polynomial. No smaller tolerance could show how far
            // it is off at a time within the shorter step.
            &TAYLOR26
        };
        if method.is_series() && !batch.is_free() {
            // The tolerance refers to the rates. Their square, the power, has twice their damping: the last terms of its
            // series are so many times as large.
            tighter *= 2.0_f64.powi(other.facts.order as i32);
        }
        let tolerance = Some((tolerance / tighter).max(tolerance.min(FINEST)));
        return again.run(Solver { method: other, tolerance, ..solver }, None, refinement);
    }
    let ratio = step_ratio(batch, method, steps.halvings);
    let own = |longest: &[f64]| memory::collected("steps", longest.len(), longest.iter().copied());
    let (mut solver, mut longest) = (solver, steps.longest.map(own).transpose()?);
    if is_checked_by_compensated(solver) {
        // Rounding that is alike in each step shows against none only.
        longest = Some(longest.map_or_else(|| again.longest_steps(method), Ok)?);
        solver.method = COMPENSATED;
    }
    for (body, step) in longest.iter_mut().flatten().enumerate() {
        *step = smaller(*step, steps.refinement * ratio / FEWEST * batch.span_of(body));
    }
    again.run(solver, longest.as_deref(), steps.refinement * ratio)
}

/// The states of bodies that drag may stop, by a Runge-Kutta method in far shorter steps.
///
/// Where the body stops the speed has a corner. The error of the step that passes the corner falls with its cube, whatever the
/// order, and depends on where in the step the corner is: of two runs with like steps either may err more. A series continues
/// as if there were no corner.
fn past_stops(again: &Batch, solver: Solver, steps: Steps, taken: &[u64]) -> Result<States, Error> {
    if !solver.method.is_series() {
        return again.run(solver, steps.longest, steps.refinement * FINER);
    }
    let default = again.longest_steps(RUNGE_KUTTA)?;
    let own = |body: usize| smaller(again.span_of(body) / taken[body] as f64 / FINER, default[body]);
    let longest = memory::collected("steps", default.len(), (0..default.len()).map(own))?;
    again.run(Solver { method: RUNGE_KUTTA, tolerance: None, ..solver }, Some(&longest), 1.0)
}

/// Factor by which the steps of the second run are shorter, in steps of the same method.
pub fn step_ratio(batch: &Batch, method: &Method, halvings: f64) -> f64 {
    // Of forced bodies the order falls where damping is as fast as the steps.
    let least = if batch.is_free() { 1.2 } else { 1.3 };
    let mut ratio = 2.0_f64.powf(halvings / f64::from(method.facts.order)).max(least);
    if is_damped_stiffly(batch, method) {
        // Under strong damping the order of these methods falls.
        ratio = ratio.max(2.0);
    }
    if method.facts.name == MIDPOINT.facts.name && ratio == 4.0 {
        // It divides a step by 4, 16 or 64 where its equation has no solution: the first run may have done so.
        ratio = 6.0;
    }
    ratio
}

/// Whether a series in equal steps, which does not carry its rounding errors on, is compared with one that does.
pub fn is_checked_by_compensated(solver: Solver) -> bool {
    let is_equal = solver.tolerance.is_none() && !solver.may_stop;
    is_equal && solver.method.is_series() && !solver.method.any.is_compensated()
}

/// Whether the second run is by the same method, and its error falls with the order: not at a stop by drag, nor under strong
/// damping.
pub fn is_refined_alike(batch: &Batch, solver: Solver) -> bool {
    let has_its_order = batch.is_free() || !(solver.may_stop || solver.method.is_stiff());
    has_its_order && (!solver.method.is_series() || solver.method.any.is_compensated())
}

/// Whether a method for strong damping integrates forced bodies.
pub fn is_damped_stiffly(batch: &Batch, method: &Method) -> bool {
    !batch.is_free() && method.is_stiff()
}
