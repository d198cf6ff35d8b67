//! Registers and the choice of the instruction set, which the kernels and `map/draw.rs` use.

mod arr;
mod isa;
mod row;
#[cfg(target_arch = "x86_64")]
mod x86;

pub use arr::Arr;
pub use isa::{Isa, Work};
pub use row::{LANES, Row};
pub(crate) use row::{load_rows, set_lane, store_rows};
#[cfg(target_arch = "x86_64")]
pub(crate) use x86::{V4, V8};
