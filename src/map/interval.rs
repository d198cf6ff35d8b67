//! Confidence intervals of shares.

use crate::error::{Error, refuse};
use crate::memory;
use crate::parallel::Interrupt;
use crate::special::inverse_incomplete_beta;

/// Most trials of an interval: above, a share next to 1 rounds to 1.
const MOST_TRIALS: u64 = 1 << 50;

/// The interval of C. J. Clopper and E. S. Pearson, Biometrika 26 (1934) 404; NaN without trials.
///
/// Each end is the share that gives a result at least as extreme as the one seen with a chance of half of
/// 1 - confidence. Whatever the true share, the interval holds it with at least the chance `confidence`.
///
/// # Errors
/// Naming the argument.
pub fn clopper_pearson(successes: u64, trials: u64, confidence: f64) -> Result<[f64; 2], Error> {
    if !(confidence > 0.0 && confidence < 1.0) {
        return refuse("confidence", confidence, "must lie between 0 and 1");
    }
    if trials > MOST_TRIALS {
        return refuse("trials", trials, "must be at most 2^50");
    }
    if successes > trials {
        return refuse("successes", format_args!("{successes} of {trials}"), "must be at most the trials");
    }
    if trials == 0 {
        return Ok([f64::NAN; 2]);
    }
    let level = 0.5 * (1.0 - confidence);
    let lower = |successes: u64| match successes {
        // Exactly 0, and 1 for the upper end: rounding would exclude a certain prediction.
        0 => 0.0,
        _ => inverse_incomplete_beta(successes as f64, (trials - successes + 1) as f64, level),
    };
    Ok([lower(successes), 1.0 - lower(trials - successes)])
}

/// The intervals of successes and trials; those of equal counts, as most pixels have, are computed once.
///
/// # Errors
/// As [`clopper_pearson`]; if they do not fit into memory; `Stopped` if `stop` is wanted.
pub fn clopper_pearson_of_each(
    counts: &[[u64; 2]],
    confidence: f64,
    stop: &Interrupt,
) -> Result<Vec<[f64; 2]>, Error> {
    const INTERVALS: &str = "intervals of shares";
    let mut order = memory::collected(INTERVALS, counts.len(), 0..counts.len())?;
    order.sort_unstable_by_key(|&index| counts[index]);
    let mut intervals = memory::filled(INTERVALS, counts.len(), [f64::NAN; 2])?;
    for equal in order.chunk_by(|&one, &next| counts[one] == counts[next]) {
        if stop.is_wanted() {
            return Err(Error::Stopped);
        }
        let [successes, trials] = counts[equal[0]];
        let ends = clopper_pearson(successes, trials, confidence)?;
        equal.iter().for_each(|&index| intervals[index] = ends);
    }
    Ok(intervals)
}
