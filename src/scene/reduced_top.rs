//! The reduced top: a Lagrange top in the frame that rotates with L / I1, where the top is a sphere without spin.
//!
//! The torque has no component along the symmetry axis, so L3 is constant, and the body turns about axis 3 of this
//! frame at the constant rate (1/I3 - 1/I1) L3. `moments` are (I1, I1, I1), the weight lies on axis 3.

use super::{Model, Parameters};
use crate::kinematics::{direction, dot};
use crate::real::Real;

/// A Lagrange top in the frame that rotates with L / I1.
#[derive(Clone, Copy)]
pub struct ReducedTop<R> {
    /// Weight over moment.
    rate: R,
}

impl<R: Real> Model<R> for ReducedTop<R> {
    const REDUCED: bool = true;

    #[inline(always)]
    fn new(p: &Parameters<R>) -> Self {
        ReducedTop { rate: p.weight[2] / p.moments[0] }
    }
    #[inline(always)]
    fn euler<const D: usize>(&self, _products: &[R; 3], y: &[R; D]) -> [R; 3] {
        let [g1, g2, _] = direction(y, 0);
        [self.rate * g2, -(self.rate * g1), R::splat(0.0)]
    }
    #[inline(always)]
    fn doubled(&self) -> Self {
        ReducedTop { rate: self.rate + self.rate }
    }
    #[inline(always)]
    fn kick<const D: usize>(p: &Parameters<R>, h: R, momentum: &mut [R; 3], y: &[R; D]) {
        let [g1, g2, _] = direction(y, 0);
        let impulse = h * p.weight[2];
        momentum[0] = impulse.fma(g2, momentum[0]);
        momentum[1] = impulse.fnma(g1, momentum[1]);
    }
    #[inline(always)]
    fn gradient_kick<const D: usize>(p: &Parameters<R>, h: R, weight: R, momentum: &mut [R; 3], y: &[R; D]) {
        // The force gradient of a sphere is parallel to the kick, so it changes only the size of the kick.
        let [g1, g2, g3] = direction(y, 0);
        let lever = (p.weight[2] * p.weight[2]) / p.moments[0];
        let impulse = (weight + weight).fma(lever * g3, h * p.weight[2]);
        momentum[0] = impulse.fma(g2, momentum[0]);
        momentum[1] = impulse.fnma(g1, momentum[1]);
    }
    #[inline(always)]
    fn torque<const D: usize>(p: &Parameters<R>, y: &[R; D]) -> [R; 3] {
        let [g1, g2, _] = direction(y, 0);
        [p.weight[2] * g2, -(p.weight[2] * g1), R::splat(0.0)]
    }
    #[inline(always)]
    fn potential<const D: usize>(p: &Parameters<R>, y: &[R; D]) -> R {
        p.weight[2] * direction(y, 0)[2]
    }
    #[inline(always)]
    fn conserved<const D: usize>(momentum: &[R; 3], y: &[R; D]) -> R {
        dot(momentum, &direction(y, 0))
    }
}
