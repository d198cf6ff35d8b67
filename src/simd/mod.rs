//! Registers and the choice of the instruction set. With `kernel.rs`, which enters the chosen path, the
//! only `unsafe` of the crate.

mod arr;
mod isa;
#[cfg(target_arch = "x86_64")]
mod x86;

pub use arr::Arr;
pub use isa::Isa;
#[cfg(target_arch = "x86_64")]
pub(crate) use x86::{V4, V8};
