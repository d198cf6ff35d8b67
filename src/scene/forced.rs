//! Torque and damping, applied to any scene: I omega' = … + torque - D omega.
//!
//! For a torque in the body the rates are the whole state; for a torque in space the state needs all rows of the
//! rotation matrix, in which the torque is linear. Work and impulse are integrated with the motion: energy minus work
//! and momentum minus impulse are constant, so a drift measures the error of forced motions too. The exponential scheme
//! computes work and impulse from the gains of energy and momentum, so its drifts do not measure the error.
//!
//! A forced body has a layout with a balance; the models contain no forcing.

use super::{Layout, Parameters};
use crate::forcing::ForcingInterval;
use crate::kinematics::{direction, dot};
use crate::real::Real;

/// The forcing of a body on an interval. Without directions there is no torque in space.
#[derive(Clone, Copy)]
pub struct Applied<R> {
    moments: [R; 3],
    inverse: [R; 3],
    forcing: ForcingInterval<R>,
}

/// sum += a torque in space, in body components.
#[inline(always)]
fn add_seen<R: Real, const D: usize>(torque: &[R; 3], y: &[R; D], sum: &mut [R; 3]) {
    // The third row of the matrix comes first in the state: it is the vertical.
    for (part, row) in [(torque[2], 0), (torque[0], 1), (torque[1], 2)] {
        let row = direction(y, row);
        for i in 0..3 {
            sum[i] = part.fma(row[i], sum[i]);
        }
    }
}

impl<R: Real> Applied<R> {
    /// The constants of a body and its forcing.
    #[inline(always)]
    pub fn new(p: &Parameters<R>, forcing: &ForcingInterval<R>) -> Self {
        let one = R::splat(1.0);
        let [i1, i2, i3] = p.moments;
        Applied { moments: p.moments, inverse: [one / i1, one / i2, one / i3], forcing: *forcing }
    }

    /// The torque that does not depend on the motion: that in the body, and the components in space along the rows.
    #[inline(always)]
    fn torques_at(&self, time: R) -> [[R; 3]; 2] {
        let mut at = [self.forcing.body[0], self.forcing.space[0]];
        for i in 0..3 {
            at[0][i] = time.fma(self.forcing.body[1][i], at[0][i]);
            at[1][i] = time.fma(self.forcing.space[1][i], at[1][i]);
        }
        at
    }

    /// sum -= D omega.
    #[inline(always)]
    fn damp<const D: usize>(&self, y: &[R; D], sum: &mut [R; 3]) {
        let [d11, d22, d33, d23, d31, d12] = self.forcing.damping;
        let [w1, w2, w3] = [y[0], y[1], y[2]];
        *sum = [
            d31.fnma(w3, d12.fnma(w2, d11.fnma(w1, sum[0]))),
            d23.fnma(w3, d22.fnma(w2, d12.fnma(w1, sum[1]))),
            d33.fnma(w3, d23.fnma(w2, d31.fnma(w1, sum[2]))),
        ];
    }

    /// Applied torque without damping, at a state.
    #[inline(always)]
    pub fn undamped<L: Layout, const D: usize>(&self, y: &[R; D]) -> [R; 3] {
        let [mut sum, space] = self.torques_at(y[L::TIME_AT]);
        if L::VECTORS > 0 {
            add_seen(&space, y, &mut sum);
        }
        sum
    }

    /// Applied torque with damping, at a state.
    #[inline(always)]
    pub fn torque<L: Layout, const D: usize>(&self, y: &[R; D]) -> [R; 3] {
        let mut sum = self.undamped::<L, D>(y);
        self.damp(y, &mut sum);
        sum
    }

    /// One order of the series of the torque, after order 0, from the coefficients of the state of this order and of the
    /// one before, the latter times the step; `start` is the state.
    #[inline(always)]
    pub fn torque_of_order<L: Layout, const D: usize>(
        &self,
        start: &[R; D],
        now: &[R; D],
        before: &[R; D],
    ) -> [R; 3] {
        // The series of the time ends after order 1; so does that of a torque in the body.
        let mut sum = self.forcing.body[1];
        for i in 0..3 {
            sum[i] = sum[i] * now[L::TIME_AT];
        }
        if L::VECTORS > 0 {
            // (a + b t) times the row: a row[k] + b row[k - 1] step; the row before is given times the step.
            let space = self.torques_at(start[L::TIME_AT])[1];
            add_seen(&space, now, &mut sum);
            add_seen(&self.forcing.space[1], before, &mut sum);
        }
        self.damp(now, &mut sum);
        sum
    }

    /// Change of the rates by a torque.
    #[inline(always)]
    pub fn over_moments(&self, torque: &[R; 3]) -> [R; 3] {
        [torque[0] * self.inverse[0], torque[1] * self.inverse[1], torque[2] * self.inverse[2]]
    }

    /// Power and rate of impulse of a torque; linear in the torque and in the state.
    #[inline(always)]
    pub fn balance<L: Layout, const D: usize>(&self, torque: &[R; 3], y: &[R; D]) -> [R; 2] {
        let omega = [y[0], y[1], y[2]];
        let impulse = if L::VECTORS == 0 {
            let mut momentum = omega;
            for i in 0..3 {
                momentum[i] = momentum[i] * self.moments[i];
            }
            let half = dot(torque, &momentum);
            half + half
        } else {
            dot(torque, &direction(y, 0))
        };
        [dot(torque, &omega), impulse]
    }
}
