//! `rigid`: the rotation of rigid bodies.
//!
//! Read from left to right; nothing points back.
//!
//! ```text
//! real ← simd        real ← special ← model ← method ← observe ← group ← leaps ← kernel
//! body ← outside        {outside, kernel} ← start ← exact        special ← sample
//! {exact, sample, run} ← trajectory ← ensemble ← python
//! ```

pub mod body;
pub mod clock;
pub mod ensemble;
pub mod error;
pub mod exact;
pub mod group;
pub mod kernel;
pub mod leaps;
pub mod method;
pub mod model;
pub mod observe;
pub mod outside;
#[cfg(feature = "python")]
mod python;
pub mod real;
pub mod run;
pub mod sample;
pub mod simd;
pub mod special;
pub mod start;
pub mod trajectory;
