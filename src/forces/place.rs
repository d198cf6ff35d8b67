//! The way along an orbit in eccentric anomaly, which the steps of a body on an orbit alone take for the time.

use super::orbit::{Orbit, anomaly_cos_sin, conic_sign, is_open};
use crate::kinematics::{attitude_of_rows, cross, quaternion_product, to_body_frame};
use crate::real::Real;
use crate::special::{exp, exp_m1, sincos};

/// A part of the way along an orbit, in eccentric anomaly: the slope and the change of the distance behind it, linear in
/// the numbers of [`Orbit::clock_at`] before it.
#[derive(Clone, Copy)]
pub struct Along<R>([R; 4]);

impl<R: Real> Along<R> {
    /// So much of the anomaly.
    #[inline(always)]
    pub fn of(eccentricity: R, anomaly: R) -> Self {
        let open = is_open(eccentricity);
        let (sin, cos) = sincos(anomaly);
        let mut numbers = [cos, -sin, sin, cos];
        if R::any(open) {
            let (up, down) = (exp(anomaly), exp(-anomaly));
            for (number, of_hyperbola) in numbers.iter_mut().zip([-up, -down, up, -down]) {
                *number = R::select(open, of_hyperbola, *number);
            }
        }
        Along(numbers)
    }

    /// `e cos E` and `e sin E` after it; of a hyperbola `-e cosh E` and `e sinh E`, so that the second is the slope of the
    /// distance, too.
    #[inline(always)]
    pub fn after(&self, [first, second]: [R; 2]) -> [R; 2] {
        let [a, b, c, d] = self.0;
        [second.fma(b, first * a), first.fma(c, second * d)]
    }
}

/// How a step along an orbit moves the numbers of [`Orbit::clock_at`]. With `1 - cos` in place of the cosine the rounding of a
/// constant does not add up; of a hyperbola the numbers grow and fall, by themselves.
#[derive(Clone, Copy)]
pub struct StepAlong<R> {
    lost: [R; 2],
    sin: R,
}

impl<R: Real> StepAlong<R> {
    /// So much of the anomaly.
    #[inline(always)]
    pub fn of(eccentricity: R, anomaly: R) -> Self {
        let open = is_open(eccentricity);
        let (half, _) = sincos(anomaly * R::splat(0.5));
        let versine = (half + half) * half;
        let (mut lost, mut sin) = ([versine; 2], sincos(anomaly).0);
        if R::any(open) {
            let zero = R::splat(0.0);
            let falls = exp_m1(-anomaly.abs());
            let grows = -falls / (R::splat(1.0) + falls);
            let ahead = zero.lt(anomaly);
            let (first, second) = (R::select(ahead, grows, falls), R::select(ahead, falls, grows));
            lost = [R::select(open, -first, versine), R::select(open, -second, versine)];
            sin = R::select(open, zero, sin);
        }
        StepAlong { lost, sin }
    }

    /// The numbers after it.
    #[inline(always)]
    pub fn after(&self, [first, second]: [R; 2]) -> [R; 2] {
        [
            first - second.fma(self.sin, first * self.lost[0]),
            second + first.fma(self.sin, -(second * self.lost[1])),
        ]
    }
}

/// A place on an orbit.
#[derive(Clone, Copy, Debug)]
pub struct OrbitPlace {
    orbit: Orbit<f64>,
    anomaly: f64,
    /// The distance over the semi-major axis.
    distance: f64,
    /// The attitude of the frame of the orbit: radial, along, normal.
    frame: [f64; 4],
}

impl OrbitPlace {
    /// The place with an eccentric anomaly.
    pub fn of(orbit: Orbit<f64>, anomaly: f64) -> OrbitPlace {
        let (e, nearest) = (orbit.eccentricity(), orbit.periapsis());
        let [cos, sin] = anomaly_cos_sin(e, 0.5 * anomaly);
        // Without cancellation near the periapsis: |1 - e cos E|.
        let distance = (nearest * cos).mul_add(cos, ((1.0 + e) * sin) * sin);
        let [first, _] = orbit.semi_axes();
        let first = first.map(|x| conic_sign(e) * x);
        let normal = orbit.normal().expect("there is an orbit");
        let second = cross(&normal, &first);
        // The half of the true anomaly v: tan(v/2) = sqrt((1 + e) / |1 - e|) tan(E/2).
        let root = distance.sqrt();
        let turn = [nearest.sqrt() * cos / root, 0.0, 0.0, (1.0 + e).sqrt() * sin / root];
        let plane = attitude_of_rows(&[first[0], second[0], normal[0]], &[first[2], second[2], normal[2]]);
        OrbitPlace { orbit, anomaly, distance, frame: quaternion_product(&plane, &turn) }
    }

    /// The eccentricity.
    pub fn eccentricity(&self) -> f64 {
        self.orbit.eccentricity()
    }

    /// The anomaly from here until a time, if the time is 0 here.
    pub fn anomaly_until(&self, time: f64) -> f64 {
        self.orbit.anomaly_in(time, self.anomaly)
    }

    /// The time until the anomaly has grown by so much, if the time is 0 here.
    pub fn time_until(&self, anomaly: f64) -> f64 {
        self.orbit.time_of(anomaly, self.anomaly)
    }

    /// The circle on which the frame turns from here as at the periapsis, over the eccentric anomaly. The gravity gradient on
    /// it is `1 + e` times that at the periapsis.
    pub fn circle(&self) -> Orbit<f64> {
        let e = self.orbit.eccentricity();
        let [w, x, y, z] = self.frame;
        let [first, second] =
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(|axis| to_body_frame(&[w, -x, -y, -z], &axis));
        let [a, b, c] = first;
        let [d, f, g] = second;
        Orbit([((1.0 + e) / self.orbit.periapsis()).sqrt(), 0.0, 0.0, a, b, c, d, f, g])
    }

    /// Rates over the pace of the anomaly if the rates are the same where the distance is the largest.
    pub fn to_slowest_pace(&self, omega: [f64; 3], farthest: f64) -> [f64; 3] {
        omega.map(|rate| rate * farthest / self.orbit.rate())
    }

    /// Cosine and sine of the true anomaly.
    pub fn direction(&self) -> [f64; 2] {
        let e = self.orbit.eccentricity();
        let [cos, sin] = anomaly_cos_sin(e, self.anomaly);
        [conic_sign(e) * (cos - e) / self.distance, self.orbit.semi_minor() * sin / self.distance]
    }

    /// Whether the orbit is circular.
    pub fn is_on_circle(&self) -> bool {
        self.orbit.eccentricity() == 0.0
    }

    /// The mean motion.
    pub fn rate(&self) -> f64 {
        self.orbit.rate()
    }

    /// The eccentric anomaly.
    pub fn anomaly(&self) -> f64 {
        self.anomaly
    }

    /// See [`Orbit::clock_at`].
    pub fn clock(&self) -> [f64; 2] {
        self.orbit.clock_at(self.anomaly)
    }

    /// Rates over the pace of the anomaly, from rates.
    pub fn to_pace(&self, omega: [f64; 3]) -> [f64; 3] {
        omega.map(|rate| rate * self.distance / self.orbit.rate())
    }

    /// Rates, from rates over the pace of the anomaly.
    pub fn of_pace(&self, pace: [f64; 3]) -> [f64; 3] {
        pace.map(|rate| rate * self.orbit.rate() / self.distance)
    }

    /// An attitude seen from the frame of the orbit.
    pub fn to_frame(&self, attitude: &[f64; 4]) -> [f64; 4] {
        let [w, x, y, z] = self.frame;
        quaternion_product(&[w, -x, -y, -z], attitude)
    }

    /// An attitude in space, from one seen from the frame of the orbit.
    pub fn of_frame(&self, attitude: &[f64; 4]) -> [f64; 4] {
        quaternion_product(&self.frame, attitude)
    }
}
