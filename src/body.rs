//! A body at its start: moments, weight, rates and attitude, a bound of its rates, and the scales of its drifts.

use crate::forces::{BodyForces, Further, OrbitPlace};
use crate::inertia::moment_range;
use crate::kinematics::{dot, length, plain_dot, to_body_frame};

/// One body with its start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Principal moments.
    pub moments: [f64; 3],
    /// `mgl com`, zero for a free body.
    pub weight: [f64; 3],
    /// Rates in the body at the start.
    pub omega: [f64; 3],
    /// Attitude at the start: unit quaternion, scalar first, body to space.
    pub attitude: [f64; 4],
}

/// The vertical of space.
pub(crate) const VERTICAL: [f64; 3] = [0.0, 0.0, 1.0];

impl Body {
    /// The vertical in body components at the start.
    #[inline(always)]
    pub fn gamma(&self) -> [f64; 3] {
        to_body_frame(&self.attitude, &VERTICAL)
    }

    /// The unit of changes of the rates, `sqrt(|omega|^2 + mgl / I_min)`; 1 if that is zero.
    pub fn rate_unit(&self) -> f64 {
        let [least, _] = moment_range(self.moments);
        let unit = (plain_dot(&self.omega, &self.omega) + self.mgl() / least).sqrt();
        if unit > 0.0 { unit } else { 1.0 }
    }

    /// Weight times the distance of the centre of mass.
    pub(crate) fn mgl(&self) -> f64 {
        length(&self.weight)
    }

    /// The kinetic energy at the start.
    #[inline]
    pub fn kinetic_energy(&self) -> f64 {
        (0..3).map(|k| 0.5 * self.moments[k] * self.omega[k] * self.omega[k]).sum()
    }

    /// `L.L` at the start.
    #[inline]
    pub fn squared_momentum(&self) -> f64 {
        let ([i1, i2, i3], [a, b, c]) = (self.moments, self.omega);
        let momentum = [i1 * a, i2 * b, i3 * c];
        dot(&momentum, &momentum)
    }

    /// Whether the centre of mass lies on this body axis.
    #[inline]
    pub fn is_weighed_along(&self, axis: usize) -> bool {
        self.weight[axis] != 0.0 && self.weight[(axis + 1) % 3] == 0.0 && self.weight[(axis + 2) % 3] == 0.0
    }

    /// Whether the two moments across this axis are equal, to the bit.
    #[inline]
    pub fn is_symmetric_about(&self, axis: usize) -> bool {
        self.moments[(axis + 1) % 3] == self.moments[(axis + 2) % 3]
    }

    /// The axis (0, 1, 2) about which the body is dynamically symmetric: the other two moments are exactly equal.
    pub fn symmetry_axis(&self) -> Option<usize> {
        (0..3).rev().find(|&axis| self.is_symmetric_about(axis))
    }

    /// A bound of |omega| between two times around 0; without forces, over the whole motion.
    ///
    /// Each component is bounded by the energy, `omega_k^2 <= 2 T / I_k`, where a top can gain the energy of a fall
    /// from the upright position. The polhode gives a closer bound for a free body, the constant spin a closer bound
    /// for a symmetric top, and the power balance a bound for a forced body.
    pub fn fastest_rate(&self, forces: BodyForces, span: [f64; 2]) -> f64 {
        self.rate_bound(forces, span, self.lagrange_axis())
    }

    /// The rate over the pace of the anomaly that determines the steps over the anomaly of an orbit on which nothing else
    /// acts: a bound on a circle. On an eccentric orbit it is that of the circle of [`OrbitPlace::circle`] for a body that
    /// begins with its rates at the largest distance; a body whose rates grow in many orbits may be faster.
    pub fn pace_rate(&self, place: &OrbitPlace, farthest: f64) -> f64 {
        let further = Further { orbit: place.circle(), ..Further::NONE };
        let forces = BodyForces { further: &further, ..BodyForces::NONE };
        Body { omega: place.to_slowest_pace(self.omega, farthest), ..*self }.fastest_rate(forces, [0.0; 2])
    }

    /// The bound without forces of a body whose moments are almost the same: it does not know that the spin is constant.
    ///
    /// The angle of the steps of a map is calibrated with it. With the closer bound the steps of a symmetric top are twice
    /// as long as those of its neighbours, and 5000 times less accurate.
    pub fn neighbours_rate(&self) -> f64 {
        self.rate_bound(BodyForces::NONE, [0.0; 2], None)
    }

    fn rate_bound(&self, forces: BodyForces, span: [f64; 2], lagrange_axis: Option<usize>) -> f64 {
        let twice_kinetic: f64 = (0..3).map(|k| self.moments[k] * self.omega[k] * self.omega[k]).sum();
        let mgl = self.mgl();
        if forces.is_none() && mgl == 0.0 {
            return self.polhode_bounds(twice_kinetic).iter().sum::<f64>().sqrt();
        }
        let gamma = self.gamma();
        let height: f64 = (0..3).map(|k| self.weight[k] * gamma[k]).sum();
        let fall = (mgl + height).max(0.0);
        if !forces.is_none() {
            let start = (self.moments, self.omega, self.attitude);
            return forces.fastest_rate(start, [twice_kinetic, mgl, fall], span);
        }
        let reach = twice_kinetic + 2.0 * fall;
        let squares: f64 = match lagrange_axis {
            Some(k) => {
                let spin2 = self.omega[k] * self.omega[k];
                spin2 + (reach - self.moments[k] * spin2) / self.moments[(k + 1) % 3]
            }
            None => (0..3).map(|k| reach / self.moments[k]).sum(),
        };
        // A top also swings, so its rate is at least the pendulum frequency, even for a top at rest.
        let [least, _] = moment_range(self.moments);
        squares.max(mgl / least).sqrt()
    }

    /// Moments in ascending order, and the rates about their axes; equal moments stay in their order.
    #[inline]
    pub(crate) fn ascending(&self) -> ([f64; 3], [f64; 3]) {
        let (mut moments, mut rates) = (self.moments, self.omega);
        for (a, b) in [(0, 1), (1, 2), (0, 1)] {
            if moments[a] > moments[b] {
                moments.swap(a, b);
                rates.swap(a, b);
            }
        }
        (moments, rates)
    }

    /// The axis (0, 1, 2) of the smallest moment.
    pub(crate) fn smallest_moment(&self) -> usize {
        (1..3).fold(0, |s, k| if self.moments[k] < self.moments[s] { k } else { s })
    }

    /// The symmetry axis of a Lagrange top, about which the spin is constant.
    pub(crate) fn lagrange_axis(&self) -> Option<usize> {
        (0..3).find(|&k| {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            self.is_symmetric_about(k) && self.weight[i] == 0.0 && self.weight[j] == 0.0
        })
    }

    /// Bounds of the squared rates of a free body. With sorted moments, `D1 = L^2 - 2 T I1` and
    /// `D3 = 2 T I3 - L^2`, formed without cancellation, bound every component (Landau & Lifshitz §37).
    fn polhode_bounds(&self, twice_kinetic: f64) -> [f64; 3] {
        let ([i1, i2, i3], [w1, w2, w3]) = self.ascending();
        let d1 = i2 * (i2 - i1) * w2 * w2 + i3 * (i3 - i1) * w3 * w3;
        let d3 = i1 * (i3 - i1) * w1 * w1 + i2 * (i3 - i2) * w2 * w2;
        // A denominator of zero gives no bound.
        let least = |bound: f64, numerator: f64, denominator: f64| {
            if denominator > 0.0 { bound.min(numerator / denominator) } else { bound }
        };
        let mut bounds = [twice_kinetic / i1, twice_kinetic / i2, twice_kinetic / i3];
        bounds[0] = least(bounds[0], d3, i1 * (i3 - i1));
        bounds[1] = least(least(bounds[1], d3, i2 * (i3 - i2)), d1, i2 * (i2 - i1));
        bounds[2] = least(bounds[2], d1, i3 * (i3 - i1));
        bounds
    }
}

/// The unit quaternion of a quaternion of any length; `None` for zero.
///
/// This is the one normalisation of attitudes: `q / sqrt((w² + y²) + (x² + z²))`.
pub fn unit_quaternion(q: [f64; 4]) -> Option<[f64; 4]> {
    let square = |[w, x, y, z]: [f64; 4]| (w * w + y * y) + (x * x + z * z);
    let (mut q, mut squares) = (q, square(q));
    // A power of two changes no digit and keeps the squares in the range of doubles.
    let range = 1e-200..1e200;
    if !range.contains(&squares) {
        let power: u64 = if squares < 1.0 { 1023 + 600 } else { 1023 - 600 };
        q = q.map(|x| x * f64::from_bits(power << 52));
        squares = square(q);
    }
    (squares > 0.0).then(|| q.map(|x| x / squares.sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quaternions_of_any_length_have_the_same_unit_quaternion() {
        let q = [0.1, -0.2, 0.3, 0.4];
        let unit = unit_quaternion(q).unwrap();
        assert!((unit.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 4.0 * f64::EPSILON);
        for power in [-1000, -400, 3, 400, 1000] {
            let scale = 2.0_f64.powi(power);
            assert_eq!(unit_quaternion(q.map(|x| x * scale)).unwrap(), unit, "2^{power}");
        }
        assert_eq!(unit_quaternion([0.0, 5e-324, 0.0, 0.0]), Some([0.0, 1.0, 0.0, 0.0]));
        assert_eq!(unit_quaternion([0.0; 4]), None);
    }
}
