//! A rotor: the momentum of the body with it is `L = I omega + h`, `h` constant in the body (the gyrostat of Zhukovsky 1885
//! and Volterra 1899; Wittenburg, Dynamics of Multibody Systems, 2nd ed., 2008, §4.2), or a table over time. It does no
//! work, but the torque `-h'` on the body by which its motor changes h does.

use super::{Bounded, Force, Pace, length};
use crate::error::Error;
use crate::real::Real;

/// The momentum `h` relative to the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotor<R>(pub [R; 3]);

impl<R: Real> Force<R> for Rotor<R> {
    type Series = ();

    #[inline(always)]
    fn series() {}
}

impl Bounded for Rotor<f64> {
    fn check(&self) -> Result<(), Error> {
        Ok(())
    }

    fn is_none(&self) -> bool {
        self.0 == [0.0; 3]
    }

    /// The nutation.
    fn step_rate(&self, pace: &Pace) -> f64 {
        length(&self.0) / pace.least
    }
}
