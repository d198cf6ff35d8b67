//! Everything that can be wrong with a request. Inside a run nothing fails: each body has a status.

use thiserror::Error;

/// A refused request: the argument, its value and the rule that it breaks.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum Error {
    /// `RIGID_ISA` names a path that does not exist or that the CPU lacks.
    #[error("RIGID_ISA = '{value}' is not available here; available: {available}")]
    Isa {
        /// What the variable says.
        value: String,
        /// What could be said.
        available: String,
    },
    /// A moment of inertia is NaN or infinite.
    #[error("moments = ({0}, {1}, {2}): every moment of inertia must be finite")]
    MomentNotFinite(f64, f64, f64),
    /// A moment of inertia is zero or negative.
    #[error(
        "moments = ({0}, {1}, {2}): every moment of inertia must be positive \
         (a rod, with one moment zero, has no equation of motion about its own axis)"
    )]
    MomentNotPositive(f64, f64, f64),
    /// No distribution of mass has these moments.
    #[error(
        "moments = ({0}, {1}, {2}): no moment may exceed the sum of the other two \
         (triangle inequality; equality is a flat body)"
    )]
    MomentTriangle(f64, f64, f64),
    /// The tensor is not symmetric or not finite.
    #[error(
        "tensor: a tensor of inertia must be finite and symmetric; entry ({row}, {column}) is {value}, its mirror image {mirror}"
    )]
    Tensor {
        /// Row of the offending entry.
        row: usize,
        /// Column of the offending entry.
        column: usize,
        /// The entry.
        value: f64,
        /// The entry it should equal.
        mirror: f64,
    },
    /// A name that is not in the list.
    #[error("{argument} = '{value}': must be one of {known}")]
    Unknown {
        /// Name of the argument.
        argument: &'static str,
        /// What was given.
        value: String,
        /// What could have been given.
        known: String,
    },
    /// A number outside its range.
    #[error("{argument} = {value}: {rule}")]
    Value {
        /// Name of the argument.
        argument: &'static str,
        /// What was given.
        value: String,
        /// What it must be.
        rule: &'static str,
    },
    /// An explicit method would blow up.
    #[error(
        "step = {step:e}: '{name}' is unstable under damping with steps beyond {longest:e} (the fastest damping rate \
         is {rate:e}); take shorter ones, leave the step out, or take a method for strong damping"
    )]
    Unstable {
        /// What was given.
        step: f64,
        /// The largest eigenvalue of `I^-1 D`.
        rate: f64,
        /// Name of the method.
        name: &'static str,
        /// The longest stable step.
        longest: f64,
    },
    /// An array of the wrong shape.
    #[error("{argument}: expected shape {expected}, got {got}")]
    Shape {
        /// Name of the argument.
        argument: &'static str,
        /// The shape it must have.
        expected: String,
        /// The shape it has.
        got: String,
    },
    /// A closed form is wanted of a motion that has none.
    #[error(
        "method = 'exact': body {index} has no closed form (free bodies have one, tops that are symmetric to the bit \
         with the centre of mass on the axis, and tops that swing in a plane about a principal axis)"
    )]
    NoClosedForm {
        /// Which body.
        index: usize,
    },
    /// A verdict in closed form is wanted where there is none.
    #[error(
        "method = 'exact': the criterion has no closed form in pixel {pixel} (there is one for no_flip of a free body, \
         and for no_flip and the tilt from the vertical of the symmetry axis of a top that is symmetric to the bit \
         with the centre of mass on that axis)"
    )]
    NoClosedVerdict {
        /// Which pixel, flat.
        pixel: usize,
    },
}
