//! Whole turns by which two runs may differ though they agree at the output times.

use super::Sized;

/// Phase (rad) by which two runs may part between two compared times; a whole turn would not show.
const PART_OF_A_TURN: f64 = 0.5;

/// An error of order p is below `(theta / 3)^p` a radian turned, theta the angle of a step.
///
/// The measured errors of all methods but two, on 40 free bodies, tops and forced bodies each, are smaller; of taylor16 and
/// taylor20 on symmetric tops they are up to twice as large.
const REACH: f64 = 3.0;

/// How many more times between the output times show each whole turn by which two runs part; 0 if the output times do.
pub fn looks(known: &Sized) -> f64 {
    let run = known.run;
    let reached = crate::trajectory::time_range(run.times);
    let angle = run.body.step_rate(run.method, run.forces, reached) * known.span;
    let phase = angle
        * match run.tolerance {
            Some(tolerance) => tolerance,
            None => (angle / run.taken / REACH).powi(run.method.facts.order as i32),
        };
    let is_seen = !(phase * (longest_interval(run.times) / known.span) > PART_OF_A_TURN);
    if is_seen { 0.0 } else { (phase / PART_OF_A_TURN).ceil() }
}

/// The longest interval between ascending times and 0.
pub fn longest_interval(times: &[f64]) -> f64 {
    let (mut last, mut longest) = (times.first().map_or(0.0, |first| first.min(0.0)), 0.0_f64);
    for &time in times {
        if last < 0.0 && time > 0.0 {
            (longest, last) = (longest.max(-last), 0.0);
        }
        (longest, last) = (longest.max(time - last), time);
    }
    longest.max(-last)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_reach_from_the_start() {
        for (times, longest) in [
            (&[] as &[f64], 0.0),
            (&[5.0, 7.0], 5.0),
            (&[1.0, 7.0], 6.0),
            (&[-7.0, -5.0], 5.0),
            (&[-7.0, -1.0], 6.0),
            (&[-3.0, 4.0], 4.0),
            (&[-4.0, 3.0], 4.0),
            (&[-1.0, 0.0, 3.0], 3.0),
        ] {
            assert_eq!(longest_interval(times), longest, "{times:?}");
        }
    }
}
