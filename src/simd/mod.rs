//! Registers and the choice of the instruction set. `kernel.rs` and `ensemble.rs` enter the chosen path.

mod arr;
mod isa;
#[cfg(target_arch = "x86_64")]
mod x86;

pub use arr::Arr;
pub use isa::Isa;
#[cfg(target_arch = "x86_64")]
pub(crate) use x86::{V4, V8};
