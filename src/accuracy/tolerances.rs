//! Tolerances of adaptive steps for an accuracy, and the coarser runs that show their errors.
//!
//! A run begins with a tolerance below its accuracy. A body that is not accurate is run once more, by a tolerance that leaves
//! nothing but rounding: chaos or a saddle magnifies its error.

use super::batch::{Batch, Solver};
use crate::error::Error;
use crate::method::{Method, TO_ROUNDING};
use crate::trajectory::States;

/// The tolerance with which a series leaves rounding alone.
///
/// On 200 random orbits, of eccentricities to 0.95, `taylor20` errs no more than with a tolerance of 1e-20: the ratio of the
/// errors is 1.04 in the median, below 5.1 in 95 of 100, as it is with 1e-18.
pub const SERIES_TOLERANCE: f64 = 1e-16;

/// Least tolerance under a function: the error of a step is estimated to rounding, not below.
pub const LEAST_UNDER_FUNCTION: f64 = 1e-14;

/// The tolerance of the coarser run of a series that leaves rounding alone.
///
/// On the same orbits it errs 1700 times as much in the median, by truncation, and never less than 10 times as much. A series
/// that errs by rounding too would hide its error in one of ten runs.
pub const COARSER_TOLERANCE: f64 = 1e-11;

/// Largest tolerance of a series whose error is rounding: on the same orbits the median of the ratio to the error with 1e-20
/// is 1.18, with 1e-14 it is 2.8.
const RULED: f64 = 1e-15;

/// Factor between the tolerances of a run and of its coarser run.
///
/// Where the motion magnifies errors, the errors of both runs have signs and sizes at random, the coarser one `APART` times as
/// large. The runs are then nearer to each other than a third of the finer error in about `1 / (4.7 APART)` of all cases. On 2000
/// eccentric orbits 0.5 % erred by more than twice the stated error with a factor of 30.
pub const APART: f64 = 900.0;

/// First tolerance over the accuracy. The tolerance of the coarser run is a fifth of the accuracy: the stated error is half of
/// the accuracy unless the motion magnifies errors.
const SHARE: f64 = 2e-4;

/// The same under a function: some steps err, and three times the distance is stated.
const SHARE_UNDER_FUNCTION: f64 = 0.01;

/// Largest first tolerance: the coarser run has nearly 1e-3, where orders just show.
const LARGEST: f64 = 1e-6;

/// The tolerance of the first run for an accuracy.
pub fn first_tolerance(accuracy: f64, method: &Method) -> f64 {
    if method.is_series() {
        return (SHARE * accuracy).clamp(SERIES_TOLERANCE, LARGEST);
    }
    // A body whose error is 1 is lost.
    (SHARE_UNDER_FUNCTION * accuracy.min(1.0)).max(LEAST_UNDER_FUNCTION)
}

/// The tolerance below which there is nothing but rounding.
pub fn finest_tolerance(method: &Method) -> f64 {
    if method.is_series() { SERIES_TOLERANCE } else { LEAST_UNDER_FUNCTION }
}

/// Whether the tolerance of a series leaves less truncation than rounding.
pub fn is_ruled_by_rounding(solver: Solver) -> bool {
    solver.tolerance.is_some_and(|tolerance| tolerance <= RULED)
        && solver.method.is_series()
        && !solver.may_stop
}

/// The states from the start rounded otherwise, by a series with a larger tolerance.
///
/// Two series of high order may err alike: their errors do not fall evenly with the tolerance.
pub fn coarser_run(batch: &Batch, solver: Solver, tolerance: f64) -> Result<States, Error> {
    let coarser = Solver { method: TO_ROUNDING, tolerance: Some(tolerance), ..solver.with_more_steps() };
    batch.rounded_otherwise(0)?.run(coarser, None, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::method::{DOP853, TAYLOR12};

    #[test]
    fn a_first_tolerance_lies_between_what_rounding_and_what_orders_allow() {
        assert_eq!(first_tolerance(1e-8, &TAYLOR12), 2e-12);
        assert_eq!(
            [1.0, 1e-15].map(|accuracy| first_tolerance(accuracy, &TAYLOR12)),
            [LARGEST, SERIES_TOLERANCE]
        );
        let under_function = [200.0, 1.0, 1e-15].map(|accuracy| first_tolerance(accuracy, &DOP853));
        assert_eq!(under_function, [0.01, 0.01, LEAST_UNDER_FUNCTION]);
    }
}
