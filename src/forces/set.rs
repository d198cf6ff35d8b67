//! What acts on bodies besides weight, as a set. The set decides which variables are integrated, and by which methods.

use super::BodyForces;
use crate::error::{Error, refuse};

/// The forces on a body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ForceSet {
    /// Whether anything acts: work, impulse and time are then integrated.
    pub act: bool,
    /// Whether a further force acts.
    pub further: bool,
    /// Whether a function of the user returns a torque.
    pub function: bool,
    /// Whether it has states of its own, which are then integrated.
    pub states: bool,
    /// Whether a torque depends on the attitude: all space axes are then integrated.
    pub in_space: bool,
    /// Whether the gravity gradient of an orbit acts, and nothing else.
    pub orbit_alone: bool,
}

impl ForceSet {
    /// Nothing acts.
    pub const NONE: ForceSet = ForceSet {
        act: false,
        further: false,
        function: false,
        states: false,
        in_space: false,
        orbit_alone: false,
    };

    /// The forces of both.
    pub fn and(self, other: ForceSet) -> ForceSet {
        ForceSet {
            act: self.act || other.act,
            further: self.further || other.further,
            function: self.function || other.function,
            states: self.states || other.states,
            in_space: self.in_space || other.in_space,
            orbit_alone: (self.orbit_alone || !self.act) && (other.orbit_alone || !other.act),
        }
    }

    /// Refuses deviation vectors under the torque of a function.
    ///
    /// # Errors
    /// If such a torque acts.
    pub fn check_deviations(self) -> Result<(), Error> {
        if !self.function {
            return Ok(());
        }
        let rule = "has no derivative: deviation vectors are not integrated under the torque of a function";
        refuse("torque", "a function", rule)
    }
}

impl From<BodyForces<'_>> for ForceSet {
    fn from(forces: BodyForces) -> ForceSet {
        ForceSet {
            act: !forces.is_none(),
            further: forces.acts_further(),
            function: forces.function.is_some(),
            states: forces.function.is_some_and(|function| function.has_states()),
            in_space: forces.acts_in_space(),
            orbit_alone: forces.orbit_alone(),
        }
    }
}
