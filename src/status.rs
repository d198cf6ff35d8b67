//! The status of a body at the end of its motion, and the limit of drifts.

/// The status of a body at the end of its motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Status {
    /// The body reached the last requested time.
    Finished = 0,
    /// The integration stopped when the body was classified.
    Stopped = 1,
    /// The body needs more steps than allowed. A body with fixed steps is not integrated; a body with adaptive steps is
    /// integrated up to the limit.
    StepLimit = 2,
    /// A number overflowed or became NaN.
    NotFinite = 3,
    /// The error of the energy, of the conserved momentum or of the length of a direction or quaternion exceeds
    /// `DRIFT_LIMIT`: the step is too long for meaningful states.
    Drifted = 4,
}

/// Relative error of an invariant above which a motion counts as drifted.
pub const DRIFT_LIMIT: f64 = 0.1;

impl Status {
    /// All statuses, in the order of their codes.
    pub const ALL: [Status; 5] =
        [Status::Finished, Status::Stopped, Status::StepLimit, Status::NotFinite, Status::Drifted];

    /// The name of the status.
    pub fn name(self) -> &'static str {
        match self {
            Status::Finished => "finished",
            Status::Stopped => "stopped",
            Status::StepLimit => "step limit",
            Status::NotFinite => "not finite",
            Status::Drifted => "drifted",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_in_order() {
        for (code, status) in Status::ALL.into_iter().enumerate() {
            assert_eq!(status as usize, code, "{}", status.name());
        }
    }
}
