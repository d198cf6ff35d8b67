//! What every bench asks of a measurement, so that it prints no impossible number.
//!
//! Each bench uses some of these functions.
#![allow(dead_code)]

use rigid::parallel::thread_nanoseconds;

/// A time must be so many times longer than the clock can tell.
const TICKS: u64 = 20;

/// The least time that the clock can tell, of a few readings.
fn tick() -> u64 {
    let between = |_| {
        let begin = thread_nanoseconds();
        let mut end = begin;
        while end == begin {
            end = thread_nanoseconds();
        }
        end - begin
    };
    (0..16).map(between).min().unwrap_or(u64::MAX)
}

/// Nanoseconds of processor time that some work takes.
///
/// # Errors
/// If the clock cannot tell so short a time.
pub fn timed(work: impl FnOnce()) -> Result<f64, String> {
    let begin = thread_nanoseconds();
    work();
    let elapsed = thread_nanoseconds() - begin;
    match TICKS * tick() {
        least if elapsed < least => Err(format!("{elapsed} ns: the clock tells {least} ns at the least")),
        _ => Ok(elapsed as f64),
    }
}

/// A share of what the machine can do.
///
/// # Errors
/// If it is more than all.
pub fn share(part: f64, whole: f64) -> Result<f64, String> {
    match part / whole {
        share if share > 0.0 && share <= 1.0 => Ok(share),
        share => Err(format!("{share:.2} of the peak: must lie between 0 and 1")),
    }
}

/// Refuses numbers that the work has not changed, or that are not finite.
///
/// # Errors
/// Naming the first.
pub fn changed(before: &[f64], after: &[f64]) -> Result<(), String> {
    for (index, (old, new)) in before.iter().zip(after).enumerate() {
        if old.to_bits() == new.to_bits() || !new.is_finite() {
            return Err(format!("number {index} of the result is {new}, and was {old} before"));
        }
    }
    Ok(())
}

/// Refuses costs that are not positive: differences of times that noise has swallowed.
///
/// # Errors
/// Naming the first.
pub fn positive(costs: &[f64]) -> Result<(), String> {
    match costs.iter().find(|&&cost| !(cost > 0.0 && cost.is_finite())) {
        Some(cost) => Err(format!("a cost of {cost}: must be positive")),
        None => Ok(()),
    }
}
