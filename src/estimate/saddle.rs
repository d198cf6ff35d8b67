//! The growth of the rounding of a start at a saddle of a top.
//!
//! No method can do better: the start itself is known to rounding only. The start of a second run is rounded otherwise, but
//! a start in equilibrium stays one, and a tiny tilt changes by a share of itself: there the distance of both runs does not show it.

use super::{Sized, cross, dot, larger, length, vertical};
use crate::body::Body;
use crate::exact::derived;
use crate::forces::Damping;
use crate::inertia::moment_range;
use crate::simd::Isa;
use crate::special::{exp, exp_m1};
use nalgebra::{Matrix3, Matrix6, Schur};

/// A start is near an equilibrium if its rates of change are below this share of its rates.
const NEAR: f64 = 1e-4;

/// Exponents below this share of the rates are rounded zeros of neutral directions.
const SLOWEST: f64 = 1e-4;

/// Rounding of a start: three units in the last place.
const START: f64 = 6.7e-16;

/// Most steps of the iteration for eigenvalues: each of the six takes two or three.
const ITERATIONS: usize = 600;

/// Relative distance of a top in closed form from the separatrix of its nutation, and the exponent of its saddle; 1 and 0
/// of any other body.
pub fn separatrix(isa: Isa, body: &Body) -> [f64; 2] {
    if body.weight == [0.0; 3] { [1.0, 0.0] } else { derived::saddle(isa, body) }
}

/// By how much a saddle magnifies a small deviation: at each passage at most by one over the distance.
pub fn magnified(passed: f64, distance: f64) -> f64 {
    exp(passed).min((1.0 + passed) / distance)
}

/// Growth of rounding errors beside the separatrix of a top in closed form.
///
/// Where it makes an error of one of the drift of the energy too, either side of the separatrix is as likely: two runs may
/// take the same wrong one.
pub fn homoclinic(known: &Sized, error: &mut [f64]) {
    if !known.run.forces.is_none() {
        return;
    }
    let [distance, exponent] = separatrix(known.isa, known.run.body);
    if exponent == 0.0 {
        return;
    }
    let grown = |time: f64| magnified(exponent * time.abs(), distance) - 1.0;
    known.add_with_rates(exponent, |time| START * grown(time), error);
    for (error, &time) in error.iter_mut().zip(known.run.times) {
        if known.run.drift * grown(time) >= 1.0 {
            *error = f64::INFINITY;
        }
    }
}

/// Error from the rounding of a start beside an unstable equilibrium.
///
/// Rounding grows with the largest exponent of the linearised motion until the body has left: until its distance from the
/// equilibrium, and the distance of its rounded neighbour, is of order one. A start that is exactly in equilibrium stays,
/// as exact arithmetic has it.
pub fn departure(known: &Sized, error: &mut [f64]) {
    let forces = &known.run.forces;
    let Some(damping) = forces.damping_alone() else { return };
    let Some(Departure { rate, exponent, left }) = Departure::of(known.run.body, damping) else { return };
    let since = |time: f64| if forces.is_none() { time.abs() } else { time.max(0.0) };
    known.add_with_rates(rate, |time| START * grown(exponent * since(time)).min(1.0 / left), error);
}

/// `exp(x) - 1` of x >= 0.
fn grown(x: f64) -> f64 {
    -exp_m1(-x) * exp(x)
}

/// How a body leaves an equilibrium.
struct Departure {
    /// The rate of the body and of its swing.
    rate: f64,
    /// The largest exponent of the linearised motion.
    exponent: f64,
    /// How far the body has left the equilibrium at its start.
    left: f64,
}

impl Departure {
    /// That of a body with this damping; `None` if it is not near an equilibrium, stays, or is stable.
    fn of(body: &Body, damping: Damping) -> Option<Departure> {
        let Body { moments, weight, omega, attitude } = *body;
        if weight == [0.0; 3] {
            return None;
        }
        let gamma = vertical(attitude);
        let rate = (dot(&omega, &omega) + body.mgl() / moment_range(body.moments)[0]).sqrt();
        let tilt = length(&cross(&gamma, &omega)) / rate;
        if !(tilt < NEAR) {
            return None;
        }
        let damping = damping.matrix();
        let turning = cross(&[0, 1, 2].map(|k| moments[k] * omega[k]), &omega);
        let falling = cross(&gamma, &weight);
        let torque = [0, 1, 2].map(|k| turning[k] + falling[k] - super::dot(&damping[k], &omega));
        let away = larger(length(&[0, 1, 2].map(|k| torque[k] / moments[k])) / (rate * rate), tilt);
        if !(away < NEAR) || (away == 0.0 && is_upright_to_the_bit(body)) {
            return None;
        }
        let exponent = rate * largest_exponent(&linearised(body, gamma, damping, rate))?;
        let left = away.max(START);
        (exponent > rate * (10.0 * away.sqrt()).max(SLOWEST)).then_some(Departure { rate, exponent, left })
    }
}

/// Whether the weight acts exactly along a principal axis that is exactly vertical.
fn is_upright_to_the_bit(body: &Body) -> bool {
    let [w, x, y, z] = body.attitude.map(f64::abs);
    let vertical = [w == y && x == z, w == x && y == z, (x == 0.0 && y == 0.0) || (w == 0.0 && z == 0.0)];
    (0..3).any(|axis| body.is_weighed_along(axis) && vertical[axis])
}

/// Derivative of the rates of change of rates and vertical, with rates counted in `rate`.
fn linearised(body: &Body, gamma: [f64; 3], damping: [[f64; 3]; 3], rate: f64) -> Matrix6<f64> {
    let Body { moments, weight, omega, .. } = *body;
    let hat = |[x, y, z]: [f64; 3]| Matrix3::new(0.0, -z, y, z, 0.0, -x, -y, x, 0.0);
    let momentum = hat([0, 1, 2].map(|k| moments[k] * omega[k]));
    let (turning, falling, gamma) = (hat(omega), hat(weight), hat(gamma));
    Matrix6::from_fn(|i, k| match (i < 3, k < 3) {
        (true, true) => (momentum[(i, k)] - turning[(i, k)] * moments[k] - damping[i][k]) / moments[i] / rate,
        (true, false) => -falling[(i, k - 3)] / moments[i] / (rate * rate),
        (false, true) => gamma[(i - 3, k)],
        (false, false) => -turning[(i - 3, k - 3)] / rate,
    })
}

/// The largest real part of the eigenvalues; `None` if they are not found.
fn largest_exponent(flow: &Matrix6<f64>) -> Option<f64> {
    let schur = Schur::try_new(*flow, f64::EPSILON, ITERATIONS)?;
    schur.complex_eigenvalues().iter().map(|value| value.re).reduce(f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::special::sincos;

    const TIMES: [f64; 4] = [0.0, 1.0, 2.0, 4.0];

    /// A top with `mgl = 6` that spins upright, tilted by next to nothing.
    fn upright(moments: [f64; 3], spin: f64) -> Body {
        let (sin, cos) = sincos(0.5e-9);
        Body { moments, weight: [0.0, 0.0, 6.0], omega: [0.0, 0.0, spin], attitude: [cos, sin, 0.0, 0.0] }
    }

    fn assert_falls_with(body: &Body, exponent: f64) {
        let found = Departure::of(body, Damping::NONE).unwrap();
        for time in TIMES {
            let (expected, own) = ((exponent * time).exp_m1(), grown(found.exponent * time));
            // The tilt and the eigenvalue are rounded relative to one, which the tilt itself is far below.
            assert!((own - expected).abs() <= 1e-6 * expected, "{own} {expected}");
            assert!(own < 1.0 / found.left);
        }
    }

    #[test]
    fn a_slow_sleeping_top_falls_with_its_exponent() {
        // The characteristic equation has `exponent^2 = mgl / I1 - (I3 spin / 2 I1)^2`.
        for spin in [0.0, 1.0, 3.0] {
            let half = 0.8 * spin / (2.0 * 2.0);
            assert_falls_with(&upright([2.0, 2.0, 0.8], spin), (6.0 / 2.0 - half * half).sqrt());
        }
    }

    #[test]
    fn an_upright_pendulum_falls_about_its_smaller_moment() {
        for moments in [[2.0, 1.2, 1.0], [1.2, 2.0, 1.0]] {
            assert_falls_with(&upright(moments, 0.0), (6.0_f64 / 1.2).sqrt());
        }
    }

    #[test]
    fn the_exponent_is_counted_in_the_unit_of_the_rates() {
        for unit in [1e-9, 1e9] {
            let body = upright([2.0, 1.2, 1.0], 0.0);
            let weight = body.weight.map(|x| x * unit * unit);
            let found = Departure::of(&Body { weight, ..body }, Damping::NONE).unwrap();
            assert!((found.exponent / unit / (6.0_f64 / 1.2).sqrt() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_fast_sleeping_top_stays() {
        assert!(Departure::of(&upright([2.0, 2.0, 0.8], 20.0), Damping::NONE).is_none());
    }

    #[test]
    fn a_top_that_is_upright_to_the_bit_stays() {
        let body = upright([2.0, 2.0, 0.8], 1.0);
        assert!(Departure::of(&Body { attitude: [1.0, 0.0, 0.0, 0.0], ..body }, Damping::NONE).is_none());
        let half = 0.5_f64.sqrt();
        let lying = Body {
            weight: [0.0, 6.0, 0.0],
            omega: [0.0, 1.0, 0.0],
            attitude: [half, half, 0.0, 0.0],
            ..body
        };
        assert!(Departure::of(&lying, Damping::NONE).is_none());
    }

    #[test]
    fn a_free_body_leaves_nothing() {
        let body = Body { weight: [0.0; 3], ..upright([2.0, 2.0, 0.8], 1.0) };
        assert!(Departure::of(&body, Damping::NONE).is_none());
        assert_eq!(separatrix(Isa::current().unwrap(), &body), [1.0, 0.0]);
    }
}
