//! `rigid`: the rotation of rigid bodies.
//!
//! An arrow points from a module to the modules that it uses:
//!
//! ```text
//! real ← {dual, simd}        real ← special ← kinematics        {dual, kinematics} ← series
//! {series, inertia} ← forces ← body        {kinematics, forces} ← scene ← method ← observe ← kernel
//! {special, body} ← exact        special ← sample        memory ← {forces, kernel, parallel}
//! float_environment ← {parallel, python}        {simd, parallel} ← call ← trajectory
//! {kernel, exact, sample, parallel} ← trajectory ← {estimate ← accuracy, map} ← python
//! ```

pub mod accuracy;
pub mod body;
pub mod call;
pub mod dual;
pub mod error;
pub mod estimate;
pub mod exact;
pub mod float_environment;
pub mod forces;
pub mod inertia;
pub mod kernel;
pub mod kinematics;
pub mod map;
pub mod memory;
pub mod method;
mod named;
pub mod observe;
pub mod parallel;
#[cfg(feature = "python")]
mod python;
pub mod real;
pub mod sample;
pub mod scene;
pub mod series;
pub mod simd;
pub mod special;
pub mod status;
pub mod trajectory;

// The tests of tests/rust use the crate by its name, as its users do. They are part of its own test
// binary: a binary of their own would compile all kernels a second time.
#[cfg(test)]
extern crate self as rigid;
#[cfg(test)]
#[path = "../tests/rust/mod.rs"]
mod tests;
