//! Registers and the choice of the instruction set, which the kernels and `map/draw.rs` use.

mod arr;
mod isa;
mod row;
#[cfg(target_arch = "x86_64")]
mod x86;

use crate::real::{Apart, Real};
pub use arr::Arr;
pub use isa::Isa;
pub use row::{LANES, Row};
#[cfg(target_arch = "x86_64")]
pub(crate) use x86::{V4, V8};

/// Does scalar work with fused products of the CPU, which are library calls elsewhere; with the same bits.
pub fn with_fma(work: impl Apart) {
    #[cfg(target_arch = "x86_64")]
    if Isa::Avx2.is_available() {
        V4::apart(work);
        return;
    }
    #[cfg(plain)]
    f64::apart(work);
    #[cfg(not(plain))]
    unreachable!("`Isa::current` refuses a CPU without AVX2")
}
