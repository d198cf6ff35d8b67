//! What acts on bodies besides weight, as a set. The set decides which variables are integrated, and by which schemes.

use crate::called::TorqueCall;
use crate::error::Error;
use crate::forcing::BodyForcing;
use crate::satellite::Satellite;

/// The forces on a body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Forces {
    /// Whether anything acts: work, impulse and time are then integrated.
    pub act: bool,
    /// Whether a rotor, an energy sink, quadratic drag or a gravity gradient acts.
    pub of_satellite: bool,
    /// Whether a function of the user returns a torque.
    pub of_function: bool,
    /// Whether a torque depends on the attitude: all space axes are then integrated.
    pub in_space: bool,
}

impl Forces {
    /// Nothing acts.
    pub const NONE: Forces = Forces { act: false, of_satellite: false, of_function: false, in_space: false };

    /// The forces of both.
    pub fn and(self, other: Forces) -> Forces {
        Forces {
            act: self.act || other.act,
            of_satellite: self.of_satellite || other.of_satellite,
            of_function: self.of_function || other.of_function,
            in_space: self.in_space || other.in_space,
        }
    }

    /// Refuses displacements under forces for which there are no kernels.
    ///
    /// # Errors
    /// If a rotor, an energy sink, drag, a gravity gradient or the torque of a function acts.
    pub fn check_displaced(self) -> Result<(), Error> {
        match self {
            Forces { of_satellite: true, .. } => Err(Satellite::not_displaced()),
            Forces { of_function: true, .. } => Err(TorqueCall::not_displaced()),
            _ => Ok(()),
        }
    }
}

impl From<BodyForcing<'_>> for Forces {
    fn from(forcing: BodyForcing) -> Forces {
        Forces {
            act: !forcing.is_none(),
            of_satellite: !forcing.satellite().is_none(),
            of_function: forcing.function().is_some(),
            in_space: forcing.acts_in_space(),
        }
    }
}
