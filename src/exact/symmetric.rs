//! The free symmetric body and the spin of any body about a principal axis: two turns at constant rates.
//!
//! `R(t) = exp(L t / I1) R(0) exp(e3 Om t)`, `Om = (1 - I3/I1) omega3`: prolate, oblate, spherical and at rest
//! without a branch (Landau & Lifshitz, Mechanics, §33 and §35).

use super::{Exit, Motion, normalised, power_near, scaled, turn};
use crate::kinematics::quaternion_product;
use crate::real::Real;
use crate::special::atan2;
use std::f64::consts::{FRAC_PI_2, PI};

/// The motion of a body that is symmetric about axis 3.
#[derive(Clone, Copy)]
pub struct Symmetric<R> {
    /// Power of two by which rates were divided and times multiplied.
    unit: R,
    /// Rate at which the transverse rates turn in the body, backwards, and half that rate.
    body_rate: R,
    half_body_rate: R,
    /// Half the rate about L.
    half_rate: R,
    /// Direction of L in the body at the start.
    direction: [R; 3],
    omega: [R; 3],
    attitude: [R; 4],
}

impl<R: Real> Symmetric<R> {
    /// Rate at which the transverse rates turn in the body, backwards, and the rate about L.
    #[inline(always)]
    pub fn turning(&self) -> [R; 2] {
        [self.body_rate * self.unit, (self.half_rate + self.half_rate) * self.unit]
    }
}

impl<R: Real> Motion<R> for Symmetric<R> {
    #[inline(always)]
    fn new(moments: &[R; 3], _weight: &[R; 3], omega: &[R; 3], attitude: &[R; 4]) -> Self {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let (unit, inverse_unit) = power_near(omega);
        let (_, inverse_size) = power_near(moments);
        let [i1, _, i3] = scaled(moments, inverse_size);
        let w = scaled(omega, inverse_unit);
        let l = [i1 * w[0], i1 * w[1], i3 * w[2]];
        let length = l[0].fma(l[0], l[1].fma(l[1], l[2] * l[2])).sqrt();
        let inverse = one / R::select(zero.lt(length), length, one);
        let half = R::splat(0.5);
        let body_rate = ((i1 - i3) / i1) * w[2];
        Symmetric {
            unit,
            body_rate,
            half_body_rate: body_rate * half,
            half_rate: (length / i1) * half,
            direction: scaled(&l, inverse),
            omega: *omega,
            attitude: *attitude,
        }
    }

    #[inline(always)]
    fn exit(&self, question: &Exit<R>) -> R {
        let (zero, one, half) = (R::splat(0.0), R::splat(1.0), R::splat(0.5));
        let never = R::splat(f64::INFINITY);
        // The transverse rates are cos and sin of an angle that falls at the body rate.
        let [w1, w2, _] = self.omega;
        let falling = zero.lt(self.body_rate);
        let first = question.axis.lt(half);
        let angle = R::select(falling, atan2(w2, w1), -atan2(w2, w1));
        let above = R::select(first, angle + R::splat(FRAC_PI_2), angle) / R::splat(PI);
        // Half turns to the next zero, in (0, 1].
        let floor = above.round();
        let floor = R::select(above.lt(floor), floor - one, floor);
        let fraction = above - floor;
        let fraction = R::select(zero.lt(fraction), fraction, one);
        let rate = self.body_rate.abs() * self.unit;
        let changes = zero.lt(rate * w1.abs().max(w2.abs()));
        let third = R::splat(1.5).lt(question.axis);
        let time = fraction * R::splat(PI) / R::select(changes, rate, one);
        R::select(third, never, R::select(changes, time, never))
    }

    #[inline(always)]
    fn rates(&self, t: R) -> [R; 3] {
        let (sin, cos) = turn(&[(self.body_rate, t * self.unit)], R::splat(0.0));
        let [w1, w2, w3] = self.omega;
        [w1.fma(cos, w2 * sin), w2.fms(cos, w1 * sin), w3]
    }

    #[inline(always)]
    fn state(&self, t: R) -> ([R; 3], [R; 4]) {
        let zero = R::splat(0.0);
        let time = t * self.unit;
        let (s, c) = turn(&[(self.half_rate, time)], zero);
        let (sb, cb) = turn(&[(self.half_body_rate, time)], zero);
        let [u1, u2, u3] = self.direction;
        let about_l = [c, s * u1, s * u2, s * u3];
        // Product with the turn about axis 3, whose quaternion has two components.
        let local = [
            about_l[0].fms(cb, about_l[3] * sb),
            about_l[1].fma(cb, about_l[2] * sb),
            about_l[2].fms(cb, about_l[1] * sb),
            about_l[3].fma(cb, about_l[0] * sb),
        ];
        (self.rates(t), normalised(&quaternion_product(&self.attitude, &local)))
    }
}
