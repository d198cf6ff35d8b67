//! Registers and the choice of the instruction set, which the kernels and `map/draw.rs` use.

mod arr;
mod isa;
mod row;
#[cfg(target_arch = "x86_64")]
mod x86;

pub use arr::Arr;
pub use isa::Isa;
pub use row::{LANES, Row};
#[cfg(target_arch = "x86_64")]
pub(crate) use x86::{V4, V8};

/// Writes a statement once for each number of a range, so that the compiler keeps the numbers in registers.
macro_rules! unrolled {
    (pack $b:ident in $range:expr => $body:block) => {
        $crate::simd::unrolled!(@each $b $range, $body, 0 1 2 3 4 5 6 7)
    };
    (variable $d:ident in $range:expr => $body:block) => {
        $crate::simd::unrolled!(@each $d $range, $body, 0 1 2 3 4 5 6 7 8 9 10 11 12 13 14)
    };
    (vector $v:ident in $range:expr => $body:block) => {
        $crate::simd::unrolled!(@each $v $range, $body, 0 1 2)
    };
    (@each $i:ident $range:expr, $body:block, $($number:literal)*) => {$(
        if const { $range.start <= $number && $number < $range.end } {
            let $i: usize = $number;
            $body
        }
    )*};
}
pub(crate) use unrolled;
