//! The distance of two runs.

use super::{Recorded, Sized, larger, largest, length, smaller, unit};
use crate::forces::{MOST_STATES, SMALL_STATE};
use crate::inertia::moment_range;

/// Relative distances of the states of two runs of a body at their times: the largest of `|d omega|` over the largest
/// `|omega|` of the two, of the chord of the angle between the verticals and of the angle between the attitudes. Rates that are all
/// rest beside a scale are compared with the scale.
pub fn distances(run: &Recorded, other: &Recorded, scale: f64, apart: &mut [f64]) {
    let size = unit(fastest_of_both(run, other, |_| true), scale);
    for (time, apart) in apart.iter_mut().enumerate() {
        *apart = larger(of_rates(run, other, time) / size, of_directions(run, other, time));
    }
}

/// Writes the errors that are stated for the distance of two runs, with their work.
pub fn stated(known: &Sized, other: &Recorded, safety: f64, error: &mut [f64]) {
    let run = &known.run.states;
    let size = known.unit(fastest_of_both(run, other, |_| true));
    let mut is_lost = false;
    for (time, error) in error.iter_mut().enumerate() {
        let of_rates = safety * (of_rates(run, other, time) / size);
        *error = larger(of_rates, safety * of_directions(run, other, time));
        if of_rates < 1.0 {
            // Relative to the rates of the runs: relative to the true ones it may be as much larger.
            *error = larger(*error, of_rates / (1.0 - of_rates));
        }
        is_lost |= !(*error < 1.0);
    }
    if is_lost {
        add_those_before_the_loss(known, other, safety, error);
    }
    if let (Some(work), Some(others)) = (run.work, other.work) {
        // The fastest rate is reached about the axis of the least moment.
        let energy = 0.5 * moment_range(known.run.body.moments)[0] * (known.bound * known.bound);
        let energy = if energy > 0.0 { energy } else { 1.0 };
        for (error, (work, other)) in error.iter_mut().zip(work.iter().zip(others)) {
            *error = larger(*error, safety * ((work - other).abs() / energy));
        }
    }
    if let (Some(states), Some(others)) = (run.states, other.states) {
        let sizes = sizes_of_states(states, others);
        for (error, (states, others)) in error.iter_mut().zip(states.iter().zip(others)) {
            for (size, (state, other)) in sizes.iter().zip(states.iter().zip(others)) {
                *error = larger(*error, safety * ((state - other).abs() / size));
            }
        }
    }
}

/// The sizes to which errors of the states of a function are relative: the largest that two runs reach at their times, but
/// not small ones.
fn sizes_of_states(states: &[[f64; MOST_STATES]], others: &[[f64; MOST_STATES]]) -> [f64; MOST_STATES] {
    let mut sizes = [0.0_f64; MOST_STATES];
    for row in states.iter().chain(others) {
        sizes.iter_mut().zip(row).for_each(|(size, state)| *size = larger(*size, state.abs()));
    }
    let [share, least] = SMALL_STATE;
    let least = larger(least, share * largest(sizes.iter().copied()));
    sizes.map(|size| larger(size, least))
}

/// Before a body is lost errors are relative to the rates until then: later rates belong to a wrong motion and may be
/// larger than the true ones ever are.
fn add_those_before_the_loss(known: &Sized, other: &Recorded, safety: f64, error: &mut [f64]) {
    let (run, times) = (&known.run.states, known.run.times);
    // Each round but the last loses one time more, so there are at most as many rounds as times.
    loop {
        let lost = error.iter().zip(times).filter(|(error, _)| !(**error < 1.0));
        let since = lost.map(|(_, time)| time.abs()).fold(f64::INFINITY, f64::min);
        let before = |time: usize| times[time].abs() < since;
        let size = known.unit(fastest_of_both(run, other, before));
        let mut is_lost_earlier = false;
        for (time, error) in error.iter_mut().enumerate().filter(|&(time, _)| before(time)) {
            let nearer = safety * (of_rates(run, other, time) / size);
            *error = larger(*error, nearer);
            is_lost_earlier |= nearer >= 1.0;
        }
        if !is_lost_earlier {
            return;
        }
    }
}

/// The fastest rate of two runs at some of the times.
fn fastest_of_both(run: &Recorded, other: &Recorded, at: impl Fn(usize) -> bool) -> f64 {
    let rates = run.omega.iter().zip(other.omega).enumerate().filter(|&(time, _)| at(time));
    largest(rates.map(|(_, (one, other))| larger(length(one), length(other))))
}

fn of_rates(run: &Recorded, other: &Recorded, time: usize) -> f64 {
    apart(&run.omega[time], &other.omega[time])
}

/// The larger of the angles between verticals and between attitudes; the angle between quaternions is half of it, and
/// either sign is the same attitude.
fn of_directions(run: &Recorded, other: &Recorded, time: usize) -> f64 {
    let of_gamma = match (run.gamma, other.gamma) {
        (Some(one), Some(other)) => apart(&one[time], &other[time]),
        _ => 0.0,
    };
    let of_attitude = match (run.attitude, other.attitude) {
        (Some(one), Some(other)) => {
            let (one, other) = (&one[time], &other[time]);
            2.0 * smaller(apart(one, other), apart(one, &other.map(|x| -x)))
        }
        _ => 0.0,
    };
    larger(of_gamma, of_attitude)
}

fn apart<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    let mut difference = *a;
    difference.iter_mut().zip(b).for_each(|(a, b)| *a -= b);
    length(&difference)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_distance_is_the_largest_of_relative_rates_and_angles() {
        let (omega, gamma) = ([[0.0, 0.0, 2.0], [0.0, 0.0, 4.0]], [[0.0, 0.0, 1.0]; 2]);
        let (attitude, turned) = ([[1.0, 0.0, 0.0, 0.0]; 2], [[-1.0, 0.0, 0.0, 0.0]; 2]);
        let run = Recorded {
            omega: &omega,
            gamma: Some(&gamma),
            attitude: Some(&attitude),
            work: None,
            states: None,
        };
        let mut apart = [1.0; 2];
        distances(&run, &Recorded { attitude: Some(&turned), ..run }, 1.0, &mut apart);
        assert_eq!(apart, [0.0; 2], "a quaternion and its negative are one attitude");
        let other = [[0.0, 0.0, 2.0], [0.0, 0.0, 3.0]];
        distances(&run, &Recorded { omega: &other, ..run }, 1.0, &mut apart);
        assert_eq!(apart, [0.0, 0.25]);
        let tilted = [[0.6, 0.0, 0.8]; 2];
        distances(&run, &Recorded { gamma: Some(&tilted), ..run }, 1.0, &mut apart);
        // The chord of the angle: sqrt(0.6^2 + 0.2^2).
        assert!(apart.iter().all(|apart| (apart - 0.4_f64.sqrt()).abs() < 1e-15));
    }

    #[test]
    fn rates_of_a_body_at_rest_are_compared_with_what_it_could_reach() {
        let (still, slow) = ([[0.0; 3]], [[1e-20, 0.0, 0.0]]);
        let run = Recorded { omega: &still, gamma: None, attitude: None, work: None, states: None };
        let mut apart = [0.0];
        for (scale, expected) in [(10.0, 1e-21), (0.0, 1.0), (1e-10, 1.0)] {
            distances(&run, &Recorded { omega: &slow, ..run }, scale, &mut apart);
            assert_eq!(apart, [expected]);
        }
    }

    #[test]
    fn errors_of_states_are_relative_to_the_largest_that_two_runs_reach() {
        let row = |first: f64, second: f64| {
            let mut row = [0.0; MOST_STATES];
            (row[0], row[1]) = (first, second);
            row
        };
        let sizes = sizes_of_states(&[row(1.0, 1e-12), row(-3.0, 0.0)], &[row(2.0, 0.0), row(4.0, 1e-9)]);
        // A millionth of the largest at least, and 1e-9.
        assert_eq!((sizes[0], sizes[1], sizes[7]), (4.0, 4e-6, 4e-6));
        assert_eq!(sizes_of_states(&[row(0.0, 0.0)], &[row(1e-20, 0.0)]), [1e-9; MOST_STATES]);
    }
}
