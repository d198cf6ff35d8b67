//! Rounding errors that a run and its check share, so that their distance does not show them.

use super::{REST, Sized, dot, larger, length, smaller, vertical};

/// Rounding error per radian turned that two runs which agree bit for bit may share.
const EQUAL_RUNS: f64 = 5e-16;

/// Two runs of which the coarser takes no more steps may be one polynomial: their distance does not show their last terms.
/// All ten undetected errors of 2000 random runs were of this kind.
const FEW: f64 = 6.0;

/// Half the distance from 1 to the next number.
const UNIT: f64 = f64::EPSILON / 2.0;

/// Number of damping times after which a rate has fallen below `REST` of its first value.
const FORGOTTEN: f64 = 30.0;

/// Adds the rounding that two runs share which agree bit for bit.
pub fn of_equal_runs(known: &Sized, error: &mut [f64]) {
    add(EQUAL_RUNS * (1.0 + known.bound * known.span), error);
}

/// Adds the rounding of the rates of a top that hangs all but still. Of them, what rounding of the torque adds at random,
/// in each radian that the top may turn, is a larger share.
pub fn of_hanging_top(known: &Sized, error: &mut [f64]) {
    let body = known.run.body;
    if body.weight == [0.0; 3] || !(known.fastest > REST * known.scale) {
        return;
    }
    let share = known.scale / known.fastest * rounded_share_of_torque(body.weight, body.attitude);
    add(EQUAL_RUNS * share * (1.0 + known.bound * known.span).sqrt(), error);
}

/// Size of the products whose differences are the torque of the weight, over its largest.
///
/// Each component of `com x gamma` is one of two products of which both may be rounded.
fn rounded_share_of_torque(weight: [f64; 3], attitude: [f64; 4]) -> f64 {
    let (com, gamma) = (weight.map(f64::abs), vertical(attitude).map(f64::abs));
    let products = [(1, 2), (2, 0), (0, 1)].map(|(i, k)| com[i] * gamma[k] + com[k] * gamma[i]);
    length(&products) / length(&com)
}

/// Adds the tolerance of the coarser run where both runs may be one polynomial. It is relative to the bound of the rates, an
/// error to the fastest rate of the run.
pub fn of_few_steps(known: &Sized, error: &mut [f64]) {
    let Some(coarser) = known.run.coarser_tolerance else { return };
    if known.run.taken > FEW || !(known.bound > 0.0) {
        return;
    }
    let share = if known.fastest > REST * known.bound { known.bound / known.fastest } else { 1.0 };
    add(coarser * share, error);
}

/// Adds the error from the rounding of the damping that two runs may share.
///
/// The damping of a slow direction is a difference of large products if other directions are fast and the directions are
/// not along the axes. Each product is rounded, so the direction has a damping rate that is off by a rounding of their sum,
/// as long as its rates last: relative to them the error grows with the time, and after the time of its damping it follows
/// from the balance of a torque with the damping.
pub fn of_damping(known: &Sized, error: &mut [f64]) {
    let run = known.run;
    if run.forces.damping.is_none() {
        return;
    }
    let matrix = run.forces.damping.matrix();
    let sizes = matrix.map(|row| row.map(f64::abs));
    let quadratic = |matrix: &[[f64; 3]; 3], v: &[f64; 3]| dot(v, &[0, 1, 2].map(|k| dot(&matrix[k], v)));
    for ((error, omega), time) in error.iter_mut().zip(run.states.omega).zip(run.times) {
        let (size, time) = (length(omega), time.abs());
        let along = omega.map(|rate| rate / size);
        let momentum = [0, 1, 2].map(|k| along[k] * run.body.moments[k]);
        let inertia = dot(&momentum, &along);
        let products = quadratic(&sizes, &along.map(f64::abs));
        let power = larger(quadratic(&matrix, &along), UNIT * products);
        let lasts = inertia / power;
        let started = dot(&momentum, &run.body.omega).abs() / inertia;
        let until = smaller(time, lasts);
        let angle = size * time + started * until;
        let of_rates = smaller(time, FORGOTTEN * lasts);
        let shared = UNIT * products / inertia * (of_rates + angle * until);
        // A body at rest has no such error.
        if shared.is_finite() {
            *error += shared;
        }
    }
}

fn add(term: f64, error: &mut [f64]) {
    error.iter_mut().for_each(|error| *error += term);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_products_of_a_torque_are_rounded_where_they_cancel() {
        // Hanging along (1, 1, 0): the products along axis 3 are 1/2 each, and the torque is zero.
        let half = 0.5_f64.sqrt();
        let attitude = [half, half * half, half * half, 0.0];
        let [x, y, z] = vertical(attitude);
        assert!((x + half).abs() < 1e-15 && (y - half).abs() < 1e-15 && z.abs() < 1e-15);
        let share = rounded_share_of_torque([3.0 * half, -3.0 * half, 0.0], attitude);
        assert!((share - 1.0).abs() < 1e-15);
        assert_eq!(rounded_share_of_torque([0.0, 0.0, -3.0], [1.0, 0.0, 0.0, 0.0]), 0.0);
    }
}
