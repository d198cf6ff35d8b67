//! What acts on a satellite: a rotor, an energy sink, quadratic drag, and the gravity gradient on a circular orbit.
//!
//! The angular momentum of the body with its rotor is `L = I omega + h`, with `h` constant in the body (the gyrostat of
//! Zhukovsky 1885 and Volterra 1899; Wittenburg, Dynamics of Multibody Systems, 2nd ed., 2008, §4.2). The gravity
//! gradient is the torque `3 n^2 o x I o`, `o` the direction to the centre (Hughes, Spacecraft Attitude Dynamics, 1986,
//! §8.1).
//!
//! Quadratic drag is the torque `-|omega| c omega`, `c` one coefficient for each body axis: at large Reynolds numbers the
//! moment of a rotating sphere or disk over the square of its rate varies slowly (rotating disk: von Kármán, Z. angew.
//! Math. Mech. 1, 1921, doi 10.1002/zamm.19210010401: the power 9/5).
//!
//! The energy sink is that of a cavity with a very viscous fluid, or of a damper that is tightly coupled: the momentum
//! of the fluid relative to the body is `-P omega'` (Chernousko, USSR Comput. Math. Math. Phys. 5, 1965). With `omega`
//! defined by `L = I omega + h`, the frame of the body then turns with `omega + e`, `e = I^-1 P omega'`, to first order
//! in P, where `omega'` is the rate of change without the sink. In space L is constant, so in the body `L' = L x (omega +
//! e)`, and the energy falls by the power `omega'.P omega'`. This is a double bracket (Bloch, Krishnaprasad, Marsden,
//! Ratiu, Commun. Math. Phys. 175, 1996): |L| stays, whatever the coefficients.

use super::{Applied, Layout, Model};
use crate::kinematics::{add_cross, cross, direction, dot};
use crate::real::Real;

/// The rates of change of a satellite.
pub struct SatelliteRate<R> {
    /// Of the rates.
    pub omega: [R; 3],
    /// The turn of the frame of the body in addition to the rates.
    pub sink: [R; 3],
    /// Of the work and the impulse.
    pub balance: [R; 2],
}

impl<R: Real> Applied<R> {
    /// The direction to the centre, from cosine and sine of the angle on the orbit and the space axes of a state, or of
    /// one order of it; linear in both.
    #[inline(always)]
    pub fn towards_centre<const D: usize>(&self, [cos, sin]: [R; 2], y: &[R; D]) -> [R; 3] {
        let (towards, ahead) = (&self.forcing.satellite.towards, &self.forcing.satellite.ahead);
        let mut part = *towards;
        for k in 0..3 {
            part[k] = cos.fma(towards[k], sin * ahead[k]);
        }
        // The third row of the matrix, the vertical, comes first in the state.
        let (z, x, y) = (direction(y, 0), direction(y, 1), direction(y, 2));
        let mut sum = part;
        for i in 0..3 {
            sum[i] = part[2].fma(z[i], part[0].fma(x[i], part[1] * y[i]));
        }
        sum
    }

    /// The torque of the gravity gradient from the products `o2 o3`, `o3 o1`, `o1 o2`, in which it is linear.
    #[inline(always)]
    pub fn gravity_gradient(&self, products: &[R; 3]) -> [R; 3] {
        let [i1, i2, i3] = self.moments;
        let rate = self.forcing.satellite.orbit_rate;
        let strength = R::splat(3.0) * (rate * rate);
        [
            strength * (i3 - i2) * products[0],
            strength * (i1 - i3) * products[1],
            strength * (i2 - i1) * products[2],
        ]
    }

    /// Which bodies have quadratic drag.
    #[inline(always)]
    pub fn is_dragged(&self) -> R::Mask {
        let [c1, c2, c3] = self.forcing.satellite.drag;
        R::splat(0.0).lt(c1 + c2 + c3)
    }

    /// Adds the quadratic drag to a torque, where there is one, from the products of speed and rates; linear.
    #[inline(always)]
    pub fn add_drag(&self, products: &[R; 3], torque: &mut [R; 3]) {
        let is_dragged = self.is_dragged();
        for i in 0..3 {
            let with = self.forcing.satellite.drag[i].fnma(products[i], torque[i]);
            torque[i] = R::select(is_dragged, with, torque[i]);
        }
    }

    /// `h x v`, with the momentum h of the rotor.
    #[inline(always)]
    pub fn rotor_across(&self, v: &[R; 3]) -> [R; 3] {
        cross(&self.forcing.satellite.rotor, v)
    }

    /// The momentum of the body, without the rotor; linear in the rates.
    #[inline(always)]
    pub fn momentum(&self, omega: &[R; 3]) -> [R; 3] {
        [self.moments[0] * omega[0], self.moments[1] * omega[1], self.moments[2] * omega[2]]
    }

    /// The momentum of the body with its rotor.
    #[inline(always)]
    pub fn whole_momentum(&self, omega: &[R; 3]) -> [R; 3] {
        let (own, rotor) = (self.momentum(omega), &self.forcing.satellite.rotor);
        [own[0] + rotor[0], own[1] + rotor[1], own[2] + rotor[2]]
    }

    /// The turn of the frame by the sink, from the rate of change of the rates without it; linear.
    #[inline(always)]
    pub fn sink(&self, rate: &[R; 3]) -> [R; 3] {
        let sink = &self.forcing.satellite.sink;
        self.over_moments(&[sink[0] * rate[0], sink[1] * rate[1], sink[2] * rate[2]])
    }

    /// The rate of change of cosine and sine of the angle on the orbit; linear.
    #[inline(always)]
    pub fn orbit_change(&self, [cos, sin]: [R; 2]) -> [R; 2] {
        let rate = self.forcing.satellite.orbit_rate;
        [-(rate * sin), rate * cos]
    }

    /// The equations of motion of a satellite, at a state.
    #[inline(always)]
    pub fn satellite<M: Model<R>, L: Layout, const D: usize>(
        &self,
        model: &M,
        y: &[R; D],
    ) -> SatelliteRate<R> {
        let omega = [y[0], y[1], y[2]];
        let mut torque = self.torque::<L, D>(y);
        if L::ORBITS {
            let [o1, o2, o3] = self.towards_centre([y[L::ORBIT_AT], y[L::ORBIT_AT + 1]], y);
            let gradient = self.gravity_gradient(&[o2 * o3, o3 * o1, o1 * o2]);
            for i in 0..3 {
                torque[i] = torque[i] + gradient[i];
            }
        }
        if R::any(self.is_dragged()) {
            let speed = dot(&omega, &omega).sqrt();
            self.add_drag(&[speed * omega[0], speed * omega[1], speed * omega[2]], &mut torque);
        }
        let mut rate = model.euler(&[omega[1] * omega[2], omega[2] * omega[0], omega[0] * omega[1]], y);
        let mut with_rotor = self.rotor_across(&omega);
        for i in 0..3 {
            with_rotor[i] = with_rotor[i] + torque[i];
        }
        let change = self.over_moments(&with_rotor);
        for i in 0..3 {
            rate[i] = rate[i] + change[i];
        }
        let sink = self.sink(&rate);
        let by_sink = cross(&self.whole_momentum(&omega), &sink);
        let change = self.over_moments(&by_sink);
        let mut power = torque;
        for i in 0..3 {
            rate[i] = rate[i] + change[i];
            power[i] = torque[i] + by_sink[i];
        }
        add_cross(&self.forcing.satellite.rotor, &sink, &mut with_rotor);
        let impulse = if L::VECTORS == 0 {
            let half = dot(&with_rotor, &self.momentum(&omega));
            half + half
        } else {
            dot(&with_rotor, &direction(y, 0))
        };
        // The rotor does no work.
        SatelliteRate { omega: rate, sink, balance: [dot(&power, &omega), impulse] }
    }
}
