//! The status of a body at the end of its motion, and the limit of drifts.

use crate::named::named;

named! {
    /// The status of a body at the end of its motion.
    pub enum Status {
        /// The body reached the last requested time.
        Finished => "finished",
        /// The integration stopped when the body was classified.
        Stopped => "stopped",
        /// The body needs more steps than allowed. A body with fixed steps is not integrated; a body with adaptive steps is
        /// integrated up to the limit.
        StepLimit => "step limit",
        /// A number overflowed or became NaN.
        NotFinite => "not finite",
        /// The error of the energy, of the conserved momentum or of the length of a direction or quaternion exceeds
        /// `DRIFT_LIMIT`: the step is too long for meaningful states.
        Drifted => "drifted",
    }
}

/// Relative error of an invariant above which a motion counts as drifted.
pub const DRIFT_LIMIT: f64 = 0.1;
