//! The equations of motion under further forces.
//!
//! The angular momentum is `L = I omega + h`, with that of the rotor. The frame of the body turns with `omega + e`,
//! `e` the turn by the dissipation; in space L changes by the torques alone.

use super::{Applied, Layout, Model};
use crate::forces::{FurtherSeries, Order};
use crate::kinematics::{add_cross, cross, direction, dot};
use crate::real::Real;
use crate::series::Coefficients;

/// The rates of change under further forces.
pub struct FurtherRate<R> {
    /// Of the rates.
    pub omega: [R; 3],
    /// The turn of the frame of the body in addition to the rates.
    pub turn: [R; 3],
    /// Of the work and the impulse.
    pub balance: [R; 2],
}

impl<R: Real> Applied<R> {
    /// The momentum of the body, without the rotor; linear in the rates.
    #[inline(always)]
    pub fn momentum(&self, omega: &[R; 3]) -> [R; 3] {
        [self.moments[0] * omega[0], self.moments[1] * omega[1], self.moments[2] * omega[2]]
    }

    /// The turn of the frame by the dissipation, from the rate of change of the rates without it; linear.
    #[inline(always)]
    pub fn turn(&self, rate: &[R; 3]) -> [R; 3] {
        self.over_moments(&self.forces.further.dissipation.times(rate))
    }

    /// The equations of motion at a state.
    #[inline(always)]
    pub fn under_further<M: Model<R>, L: Layout, const D: usize>(
        &self,
        model: &M,
        y: &[R; D],
    ) -> FurtherRate<R> {
        let (omega, rotor) = ([y[0], y[1], y[2]], &self.forces.further.rotor);
        let mut torque = self.torque::<L, D>(y);
        self.add_further_torques::<L, D>(y, &mut torque);
        let mut rate = model.euler(&[omega[1] * omega[2], omega[2] * omega[0], omega[0] * omega[1]], y);
        let mut with_rotor = rotor.across(&omega);
        for i in 0..3 {
            with_rotor[i] = with_rotor[i] + torque[i];
        }
        let change = self.over_moments(&with_rotor);
        for i in 0..3 {
            rate[i] = rate[i] + change[i];
        }
        let turn = self.turn(&rate);
        let mut momentum = self.momentum(&omega);
        for i in 0..3 {
            momentum[i] = momentum[i] + rotor.0[i];
        }
        let by_turn = cross(&momentum, &turn);
        let change = self.over_moments(&by_turn);
        let mut power = torque;
        for i in 0..3 {
            rate[i] = rate[i] + change[i];
            power[i] = torque[i] + by_turn[i];
        }
        add_cross(&rotor.0, &turn, &mut with_rotor);
        let impulse = if L::VECTORS == 0 {
            let half = dot(&with_rotor, &self.momentum(&omega));
            half + half
        } else {
            dot(&with_rotor, &direction(y, 0))
        };
        // The rotor does no work.
        FurtherRate { omega: rate, turn, balance: [dot(&power, &omega), impulse] }
    }

    #[inline(always)]
    fn add_further_torques<L: Layout, const D: usize>(&self, y: &[R; D], torque: &mut [R; 3]) {
        let further = &self.forces.further;
        if L::VECTORS > 0 {
            further.add_torques::<true, D>(&self.moments, y, L::OWN_AT, torque);
        } else {
            further.add_torques::<false, D>(&self.moments, y, L::OWN_AT, torque);
        }
    }

    /// Adds the coefficient of order k of all further torques to `torque`; see [`Force::add_order`].
    ///
    /// [`Force::add_order`]: crate::forces::Force::add_order
    #[inline(always)]
    pub fn add_further_orders<L: Layout, const D: usize>(
        &self,
        c: &Coefficients<R, D>,
        at: Order<R>,
        series: &mut FurtherSeries<R>,
        next: &mut [R; D],
        torque: &mut [R; 3],
    ) {
        let further = &self.forces.further;
        if L::VECTORS > 0 {
            further.add_orders::<true, D>(&self.moments, c, at, series, next, torque);
        } else {
            further.add_orders::<false, D>(&self.moments, c, at, series, next, torque);
        }
    }
}
