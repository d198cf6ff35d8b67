//! Errors of requests, and why a run did not end. The bodies of a run raise no error: each has a status.

use std::fmt::Display;
use thiserror::Error;

/// An invalid request: the argument, its value and the rule that it breaks; or a run that did not end.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum Error {
    /// `RIGID_ISA` names a path that does not exist or that the CPU lacks.
    #[error("RIGID_ISA = '{value}' is not available here; available: {available}")]
    Isa {
        /// The value of the variable.
        value: String,
        /// The valid values.
        available: String,
    },
    /// The CPU has none of the instruction sets that kernels are compiled for.
    #[error(
        "this processor has no AVX2 and FMA, which this build of rigid needs; build rigid from its source with \
         MATURIN_PEP517_ARGS='--features plain' for slow kernels with the same results"
    )]
    NoIsa,
    /// A moment of inertia is NaN or infinite.
    #[error("moments = ({}, {}, {}): every moment of inertia must be finite", short(.0), short(.1), short(.2))]
    MomentNotFinite(f64, f64, f64),
    /// A moment of inertia is zero or negative.
    #[error(
        "moments = ({}, {}, {}): every moment of inertia must be positive \
         (a thin rod has zero about its axis and two equal moments, a mass point has no rotation)",
        short(.0), short(.1), short(.2)
    )]
    MomentNotPositive(f64, f64, f64),
    /// No distribution of mass has these moments.
    #[error(
        "moments = ({}, {}, {}): no moment may exceed the sum of the other two (triangle inequality; equality is a \
         flat body); the excess is {:.2} % of the largest, the nearest possible moments are ({}, {}, {}); \
         physical=False takes such moments as they are",
        short(&moments[0]), short(&moments[1]), short(&moments[2]), 100.0 * excess,
        short(&nearest[0]), short(&nearest[1]), short(&nearest[2])
    )]
    MomentTriangle {
        /// The moments.
        moments: [f64; 3],
        /// The possible moments that differ least.
        nearest: [f64; 3],
        /// The largest moment less the sum of the others, as a share of the largest.
        excess: f64,
    },
    /// The tensor is not symmetric or not finite.
    #[error(
        "tensor: a tensor of inertia must be finite and symmetric; entry ({row}, {column}) is {}, its mirror image {}",
        short(value),
        short(mirror)
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
        /// The valid values.
        known: String,
    },
    /// A number outside its range.
    #[error("{argument} = {value}: {rule}")]
    Value {
        /// Name of the argument.
        argument: &'static str,
        /// What was given.
        value: String,
        /// The rule that the value breaks.
        rule: &'static str,
    },
    /// An explicit method would be unstable.
    #[error(
        "step = {step:e}{}: '{name}' is unstable under damping with steps beyond {longest:.3e} (the fastest damping rate \
         is {rate:e}); take shorter ones, leave the step out, or take a method for strong damping",
        whose(*.body)
    )]
    Unstable {
        /// Index of the body, if there are several.
        body: Option<usize>,
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
    /// A closed form was requested for a motion that has none.
    #[error("method = 'exact': body {index} has no closed form; {rule}")]
    NoClosedForm {
        /// Index of the body.
        index: usize,
        /// Which bodies have one.
        rule: &'static str,
    },
    /// A classification in closed form was requested for a body that has none.
    #[error("method = 'exact': the criterion has no closed form in pixel {pixel}; {rule}")]
    NoClosedClassification {
        /// Flat index of the pixel.
        pixel: usize,
        /// Which bodies have one.
        rule: &'static str,
    },
    /// What a request needs does not fit into memory.
    #[error(
        "{what}: {bytes} bytes of memory are needed, {}; divide the request into several smaller ones",
        match limit {
            Some(limit) => format!("more than the {limit} bytes that this machine or its control group has"),
            None => "which the system refuses".into(),
        }
    )]
    Memory {
        /// What the memory is for.
        what: String,
        /// Its size.
        bytes: u128,
        /// The memory of the machine, if that is what is exceeded.
        limit: Option<u64>,
    },
    /// The request was stopped from outside.
    #[error("interrupted")]
    Stopped,
    /// A fault of the library itself.
    #[error("a fault of rigid itself, please report it with the call that led here: {words}")]
    Fault {
        /// What the library noticed.
        words: String,
    },
}

/// Which of several bodies it is, in words.
fn whose(body: Option<usize>) -> String {
    body.map_or(String::new(), |body| format!(" of body {body}"))
}

/// Refuses the value of an argument by a rule.
///
/// # Errors
/// Always.
pub fn refuse<T>(argument: &'static str, value: impl Display, rule: &'static str) -> Result<T, Error> {
    Err(Error::value(argument, value, rule))
}

impl Error {
    /// A number outside its range.
    pub fn value(argument: &'static str, value: impl Display, rule: &'static str) -> Error {
        Error::Value { argument, value: value.to_string(), rule }
    }

    /// The error of a part of the bodies, which begins with this one, in terms of all bodies.
    pub fn of_part(self, first: usize) -> Error {
        match self {
            Error::Unstable { body, step, rate, name, longest } => {
                Error::Unstable { body: body.map(|body| first + body), step, rate, name, longest }
            }
            Error::NoClosedForm { index, rule } => Error::NoClosedForm { index: first + index, rule },
            other => other,
        }
    }
}

/// A number in few digits, whatever its size.
fn short(number: &f64) -> String {
    match number.abs() {
        0.0 | 1e-5..1e16 => number.to_string(),
        _ => format!("{number:e}"),
    }
}
