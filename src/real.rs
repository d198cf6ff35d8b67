//! `Real`: the arithmetic of a trajectory.
//!
//! Kernels are written once over this trait. Every operation is correctly rounded or exact and depends on
//! its own lane only, so a kernel gives the same 64 bits in each lane of every implementation.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// Adding this to an integer-valued double below 2^51 leaves the integer in the low mantissa bits.
pub(crate) const INTEGER_SHIFT: f64 = 6_755_399_441_055_744.0;

/// Work that several kernels share: a function of its own, which a kernel calls.
pub trait Outlined {
    /// What it returns.
    type Out;
    /// Does the work. It is `#[inline(always)]`, and takes on the instruction set of its caller.
    fn run(self) -> Self::Out;
}

/// A scalar, or several side by side in registers.
pub trait Real:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// One boolean per lane.
    type Mask: Copy;
    /// Number of bodies side by side.
    const LANES: usize = 1;
    /// Reads the first `LANES` values.
    #[inline(always)]
    fn load(from: &[f64]) -> Self {
        Self::splat(from[0])
    }
    /// Writes the first `LANES` values.
    #[inline(always)]
    fn store(self, to: &mut [f64]) {
        to[0] = self.first();
    }
    /// All lanes set to one number.
    fn splat(x: f64) -> Self;
    /// `self * b + c`, rounded once.
    fn fma(self, b: Self, c: Self) -> Self;
    /// `c - self * b`, rounded once.
    fn fnma(self, b: Self, c: Self) -> Self;
    /// `self * b - c`, rounded once.
    fn fms(self, b: Self, c: Self) -> Self;
    /// Square root, correctly rounded.
    fn sqrt(self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// Zero of a number that is zero and does not change, else above zero.
    #[inline(always)]
    fn size(self) -> Self {
        self.abs()
    }
    /// The smaller number; `other` if the numbers are equal or one is NaN.
    fn min(self, other: Self) -> Self;
    /// The larger number; `other` if the numbers are equal or one is NaN.
    fn max(self, other: Self) -> Self;
    /// Nearest integer, ties to even.
    fn round(self) -> Self;
    /// The number of the first lane.
    fn first(self) -> f64;
    /// Lane-wise `self < other`.
    fn lt(self, other: Self) -> Self::Mask;
    /// Lane-wise `if mask { a } else { b }`.
    fn select(mask: Self::Mask, a: Self, b: Self) -> Self;
    /// Whether some lane is true. Use it only to skip work whose result no lane needs.
    fn any(mask: Self::Mask) -> bool;
    /// Whether all lanes are true; a comparison with a NaN is false.
    #[inline(always)]
    fn all(mask: Self::Mask) -> bool {
        let (zero, one) = (Self::splat(0.0), Self::splat(1.0));
        !Self::any(zero.lt(Self::select(mask, zero, one)))
    }
    /// Where both masks are true.
    #[inline(always)]
    fn both(one: Self::Mask, other: Self::Mask) -> Self::Mask {
        let zero = Self::splat(0.0);
        zero.lt(Self::select(one, Self::select(other, Self::splat(1.0), zero), zero))
    }
    /// Where the first mask is true and the other is not.
    #[inline(always)]
    fn except(one: Self::Mask, other: Self::Mask) -> Self::Mask {
        let zero = Self::splat(0.0);
        zero.lt(Self::select(one, Self::select(other, zero, Self::splat(1.0)), zero))
    }
    /// 2^self for an integer-valued self in -1022 ..= 1023.
    fn exp2i(self) -> Self;
    /// Mantissa in [1, 2) and exponent of a positive normal number.
    fn frexp(self) -> (Self, Self);
    /// `self`, negated where the integer-valued `n` (below 2^51) is odd.
    fn neg_if_odd(self, n: Self) -> Self;
    /// Whether the integer-valued `n` (below 2^51) is odd.
    fn odd(n: Self) -> Self::Mask;
    /// Runs work in a function of its own, with the instructions of the registers.
    fn outlined<W: Outlined>(work: W) -> W::Out;
}

/// `a + b` and its rounding error (Knuth, TAOCP 2, §4.2.2).
#[inline(always)]
pub fn two_sum<R: Real>(a: R, b: R) -> (R, R) {
    let sum = a + b;
    let of_b = sum - a;
    (sum, (a - (sum - of_b)) + (b - of_b))
}

/// The larger number; no number if one is none.
#[inline]
pub fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}

/// The smaller number; no number if one is none.
pub fn smaller(a: f64, b: f64) -> f64 {
    if a.is_nan() || a < b { a } else { b }
}

/// A `Real` with a body in each lane.
pub trait Pack: Real {
    /// Eight bodies in such registers.
    type Eight: Pack;
}

/// A `Pack` of four lanes that can hold four numbers of one body.
pub trait Quad: Pack {
    /// All lanes set to the number of one lane.
    fn lane(self, lane: usize) -> Self;
    /// The first three lanes, and the last lane of `other`.
    fn with_last(self, other: Self) -> Self;
    /// The outer lanes, and the first lanes of two others between them.
    fn with_middle(self, second: Self, third: Self) -> Self;
    /// All lanes set to the largest number.
    fn largest(self) -> Self;
}

/// Zero in the lanes in which all numbers are finite, NaN in the others.
#[inline(always)]
pub(crate) fn zero_or_nan<R: Real>(numbers: &[R]) -> R {
    let zero = R::splat(0.0);
    let mut sum = zero;
    for number in numbers {
        sum = number.fma(zero, sum);
    }
    sum
}

/// Whether all numbers are finite, in all lanes.
#[inline(always)]
pub(crate) fn is_finite<R: Real>(numbers: &[R]) -> bool {
    R::all(zero_or_nan(numbers).lt(R::splat(1.0)))
}

impl Real for f64 {
    type Mask = bool;
    #[inline(always)]
    fn splat(x: f64) -> Self {
        x
    }
    #[inline(always)]
    fn fma(self, b: f64, c: f64) -> f64 {
        self.mul_add(b, c)
    }
    #[inline(always)]
    fn fnma(self, b: f64, c: f64) -> f64 {
        (-self).mul_add(b, c)
    }
    #[inline(always)]
    fn fms(self, b: f64, c: f64) -> f64 {
        self.mul_add(b, -c)
    }
    #[inline(always)]
    fn sqrt(self) -> f64 {
        f64::sqrt(self)
    }
    #[inline(always)]
    fn abs(self) -> f64 {
        f64::abs(self)
    }
    #[inline(always)]
    fn min(self, other: f64) -> f64 {
        if self < other { self } else { other }
    }
    #[inline(always)]
    fn max(self, other: f64) -> f64 {
        if self > other { self } else { other }
    }
    #[inline(always)]
    fn round(self) -> f64 {
        f64::round_ties_even(self)
    }
    #[inline(always)]
    fn lt(self, other: f64) -> bool {
        self < other
    }
    #[inline(always)]
    fn select(mask: bool, a: f64, b: f64) -> f64 {
        if mask { a } else { b }
    }
    #[inline(always)]
    fn any(mask: bool) -> bool {
        mask
    }
    #[inline(always)]
    fn first(self) -> f64 {
        self
    }
    #[inline(always)]
    fn exp2i(self) -> f64 {
        f64::from_bits((self + (INTEGER_SHIFT + 1023.0)).to_bits() << 52)
    }
    #[inline(always)]
    fn frexp(self) -> (f64, f64) {
        let bits = self.to_bits();
        let exponent = ((bits >> 52) & 0x7ff) as i64 - 1023;
        let mantissa = f64::from_bits((bits & 0x000f_ffff_ffff_ffff) | 0x3ff0_0000_0000_0000);
        (mantissa, exponent as f64)
    }
    #[inline(always)]
    fn neg_if_odd(self, n: f64) -> f64 {
        f64::from_bits(self.to_bits() ^ ((n + INTEGER_SHIFT).to_bits() << 63))
    }
    #[inline(always)]
    fn odd(n: f64) -> bool {
        (n + INTEGER_SHIFT).to_bits() & 1 == 1
    }
    // Only plain kernels are made of such numbers, and a function of its own keeps them small. Elsewhere a body alone is
    // computed in such numbers, and the function would lack the fused products of its caller.
    #[cfg_attr(plain, inline(never))]
    #[cfg_attr(not(plain), inline(always))]
    fn outlined<W: Outlined>(work: W) -> W::Out {
        work.run()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_nan_is_worse_than_any_number() {
        assert_eq!(
            [larger(1.0, 2.0), larger(2.0, 1.0), smaller(1.0, 2.0), smaller(2.0, 1.0)],
            [2.0, 2.0, 1.0, 1.0]
        );
        for of in [larger, smaller] {
            assert!(of(f64::NAN, 1.0).is_nan() && of(1.0, f64::NAN).is_nan());
        }
    }
}
