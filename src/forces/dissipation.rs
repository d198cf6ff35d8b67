//! An energy sink: that of a cavity with a very viscous fluid, or of a damper that is tightly coupled.
//!
//! The momentum of the fluid relative to the body is `-P omega'` (Chernousko, USSR Comput. Math. Math. Phys. 5,
//! 1965). With `omega` defined by `L = I omega + h`, the frame of the body then turns with `omega + e`, `e = I^-1 P
//! omega'`, to first order in P, where `omega'` is the rate of change without the sink. In space L is constant, so in
//! the body `L' = L x (omega + e)`, and the energy falls by the power `omega'.P omega'`. This is a double bracket
//! (Bloch, Krishnaprasad, Marsden, Ratiu, Commun. Math. Phys. 175, 1996): |L| stays, whatever the coefficients.

use super::{Bounded, Force, Pace, not_negative};
use crate::error::Error;
use crate::real::Real;

/// The diagonal of P.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dissipation<R>(pub [R; 3]);

impl<R: Real> Dissipation<R> {
    /// `P omega'`, which over the moments is the turn of the frame; linear.
    #[inline(always)]
    pub fn times(&self, rate: &[R; 3]) -> [R; 3] {
        [self.0[0] * rate[0], self.0[1] * rate[1], self.0[2] * rate[2]]
    }
}

impl<R: Real> Force<R> for Dissipation<R> {
    type Series = ();

    #[inline(always)]
    fn series() {}
}

impl Bounded for Dissipation<f64> {
    fn check(&self) -> Result<(), Error> {
        not_negative("dissipation", self.0)
    }

    fn is_none(&self) -> bool {
        self.0 == [0.0; 3]
    }

    /// The turn `e`, and the relaxation that it causes.
    fn step_rate(&self, pace: &Pace) -> f64 {
        let sink = (0..3).map(|k| self.0[k] / (pace.moments[k] * pace.moments[k])).fold(0.0, f64::max);
        (sink * pace.torque).max(sink * pace.momentum * pace.momentum / pace.least)
    }
}
