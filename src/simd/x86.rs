//! Explicit AVX-512 and AVX2+FMA registers.
//!
//! The methods execute instructions of their set. The types are private to the crate. Only the calls of `Isa` and the entry
//! points of `kernel` name them, which are entered after `Isa::is_available` has seen the CPU's feature bits.

use super::Arr;
use crate::real::{INTEGER_SHIFT, Outlined, Pack, Quad, Real};
use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Eight doubles in an AVX-512 register.
#[derive(Clone, Copy)]
#[repr(transparent)]
pub(crate) struct V8(__m512d);

/// Four doubles in an AVX register, with FMA.
#[derive(Clone, Copy)]
#[repr(transparent)]
pub(crate) struct V4(__m256d);

macro_rules! operators {
    ($type:ty, Neg $xor:ident $splat:ident, $($trait:ident $method:ident $intrinsic:ident),*) => {
        impl Neg for $type {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                // SAFETY: the CPU has the instructions; see the module.
                unsafe { Self($xor(self.0, $splat(-0.0))) }
            }
        }
        $(
        impl $trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: the CPU has the instructions; see the module.
                unsafe { Self($intrinsic(self.0, other.0)) }
            }
        }
    )*};
}
operators!(V8, Neg _mm512_xor_pd _mm512_set1_pd,
    Add add _mm512_add_pd, Sub sub _mm512_sub_pd, Mul mul _mm512_mul_pd, Div div _mm512_div_pd);
operators!(V4, Neg _mm256_xor_pd _mm256_set1_pd,
    Add add _mm256_add_pd, Sub sub _mm256_sub_pd, Mul mul _mm256_mul_pd, Div div _mm256_div_pd);

/// One `Real` method per line: its arguments beside `self` and the intrinsic on the registers.
macro_rules! intrinsics {
    ($($method:ident($($arg:ident),*) $intrinsic:ident;)*) => {$(
        #[inline(always)]
        fn $method(self $(, $arg: Self)*) -> Self {
            // SAFETY: the CPU has the instructions; see the module.
            unsafe { Self($intrinsic(self.0 $(, $arg.0)*)) }
        }
    )*};
}

/// The lanes of a register, and its moves from and to numbers.
macro_rules! moves {
    ($lanes:literal, $load:ident, $store:ident, $splat:ident, $first:ident) => {
        const LANES: usize = $lanes;
        #[inline(always)]
        fn load(from: &[f64]) -> Self {
            assert!(from.len() >= $lanes);
            // SAFETY: the CPU has the instructions (see the module); the slice is as long as the register.
            unsafe { Self($load(from.as_ptr())) }
        }
        #[inline(always)]
        fn store(self, to: &mut [f64]) {
            assert!(to.len() >= $lanes);
            // SAFETY: the CPU has the instructions (see the module); the slice is as long as the register.
            unsafe { $store(to.as_mut_ptr(), self.0) }
        }
        #[inline(always)]
        fn splat(x: f64) -> Self {
            // SAFETY: the CPU has the instructions; see the module.
            unsafe { Self($splat(x)) }
        }
        #[inline(always)]
        fn first(self) -> f64 {
            // SAFETY: the CPU has the instructions; see the module.
            unsafe { $first(self.0) }
        }
    };
}

impl Real for V8 {
    type Mask = __mmask8;
    moves!(8, _mm512_loadu_pd, _mm512_storeu_pd, _mm512_set1_pd, _mm512_cvtsd_f64);
    intrinsics! {
        fma(b, c) _mm512_fmadd_pd;
        fnma(b, c) _mm512_fnmadd_pd;
        fms(b, c) _mm512_fmsub_pd;
        sqrt() _mm512_sqrt_pd;
        abs() _mm512_abs_pd;
        min(other) _mm512_min_pd;
        max(other) _mm512_max_pd;
    }
    #[inline(always)]
    fn round(self) -> Self {
        // SAFETY: the CPU has the instructions; see the module.
        unsafe { V8(_mm512_roundscale_pd::<_MM_FROUND_TO_NEAREST_INT>(self.0)) }
    }
    #[inline(always)]
    fn lt(self, other: Self) -> __mmask8 {
        // SAFETY: the CPU has the instructions; see the module.
        unsafe { _mm512_cmp_pd_mask::<_CMP_LT_OQ>(self.0, other.0) }
    }
    #[inline(always)]
    fn select(mask: __mmask8, a: Self, b: Self) -> Self {
        // SAFETY: the CPU has the instructions; see the module.
        unsafe { V8(_mm512_mask_blend_pd(mask, b.0, a.0)) }
    }
    #[inline(always)]
    fn any(mask: __mmask8) -> bool {
        mask != 0
    }
    #[inline(always)]
    fn exp2i(self) -> Self {
        // SAFETY: the CPU has the instructions; see the module.
        unsafe {
            let shifted = _mm512_add_pd(self.0, _mm512_set1_pd(INTEGER_SHIFT + 1023.0));
            V8(_mm512_castsi512_pd(_mm512_slli_epi64::<52>(_mm512_castpd_si512(shifted))))
        }
    }
    #[inline(always)]
    fn frexp(self) -> (Self, Self) {
        // SAFETY: the CPU has the instructions; see the module.
        unsafe {
            let mantissa = _mm512_getmant_pd::<_MM_MANT_NORM_1_2, _MM_MANT_SIGN_ZERO>(self.0);
            (V8(mantissa), V8(_mm512_getexp_pd(self.0)))
        }
    }
    #[inline(always)]
    fn neg_if_odd(self, n: Self) -> Self {
        // SAFETY: the CPU has the instructions; see the module.
        unsafe {
            let shifted = _mm512_castpd_si512(_mm512_add_pd(n.0, _mm512_set1_pd(INTEGER_SHIFT)));
            V8(_mm512_xor_pd(self.0, _mm512_castsi512_pd(_mm512_slli_epi64::<63>(shifted))))
        }
    }
    #[inline(always)]
    fn odd(n: Self) -> __mmask8 {
        // SAFETY: the CPU has the instructions; see the module.
        unsafe {
            let shifted = _mm512_castpd_si512(_mm512_add_pd(n.0, _mm512_set1_pd(INTEGER_SHIFT)));
            _mm512_test_epi64_mask(shifted, _mm512_set1_epi64(1))
        }
    }
    #[inline(always)]
    fn outlined<W: Outlined>(work: W) -> W::Out {
        #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,avx2,fma")]
        #[inline(never)]
        fn outlined<W: Outlined>(work: W) -> W::Out {
            work.run()
        }
        // SAFETY: the CPU has the instructions; see the module.
        unsafe { outlined(work) }
    }
}

impl Pack for V8 {
    type Eight = V8;
}

impl Real for V4 {
    type Mask = __m256d;
    moves!(4, _mm256_loadu_pd, _mm256_storeu_pd, _mm256_set1_pd, _mm256_cvtsd_f64);
    intrinsics! {
        fma(b, c) _mm256_fmadd_pd;
        fnma(b, c) _mm256_fnmadd_pd;
        fms(b, c) _mm256_fmsub_pd;
        sqrt() _mm256_sqrt_pd;
        min(other) _mm256_min_pd;
        max(other) _mm256_max_pd;
    }
    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: the CPU has the instructions; see the module.
        unsafe { V4(_mm256_andnot_pd(_mm256_set1_pd(-0.0), self.0)) }
    }
    #[inline(always)]
    fn round(self) -> Self {
        // SAFETY: the CPU has the instructions; see the module.
        unsafe { V4(_mm256_round_pd::<{ _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC }>(self.0)) }
    }
    #[inline(always)]
    fn lt(self, other: Self) -> __m256d {
        // SAFETY: the CPU has the instructions; see the module.
        unsafe { _mm256_cmp_pd::<_CMP_LT_OQ>(self.0, other.0) }
    }
    #[inline(always)]
    fn select(mask: __m256d, a: Self, b: Self) -> Self {
        // SAFETY: the CPU has the instructions; see the module.
        unsafe { V4(_mm256_blendv_pd(b.0, a.0, mask)) }
    }
    #[inline(always)]
    fn any(mask: __m256d) -> bool {
        // SAFETY: the CPU has the instructions; see the module.
        unsafe { _mm256_movemask_pd(mask) != 0 }
    }
    #[inline(always)]
    fn exp2i(self) -> Self {
        // SAFETY: the CPU has the instructions; see the module.
        unsafe {
            let shifted = _mm256_add_pd(self.0, _mm256_set1_pd(INTEGER_SHIFT + 1023.0));
            V4(_mm256_castsi256_pd(_mm256_slli_epi64::<52>(_mm256_castpd_si256(shifted))))
        }
    }
    #[inline(always)]
    fn frexp(self) -> (Self, Self) {
        // 2^52 as bits: an exponent field or-ed into it reads as 2^52 + field.
        const TWO52: f64 = 4_503_599_627_370_496.0;
        // SAFETY: the CPU has the instructions; see the module.
        unsafe {
            let bits = _mm256_castpd_si256(self.0);
            let mantissa = _mm256_or_si256(
                _mm256_and_si256(bits, _mm256_set1_epi64x(0x000f_ffff_ffff_ffff)),
                _mm256_set1_epi64x(0x3ff0_0000_0000_0000),
            );
            let field = _mm256_and_si256(_mm256_srli_epi64::<52>(bits), _mm256_set1_epi64x(0x7ff));
            let shifted = _mm256_or_si256(field, _mm256_castpd_si256(_mm256_set1_pd(TWO52)));
            let exponent = _mm256_sub_pd(_mm256_castsi256_pd(shifted), _mm256_set1_pd(TWO52 + 1023.0));
            (V4(_mm256_castsi256_pd(mantissa)), V4(exponent))
        }
    }
    #[inline(always)]
    fn neg_if_odd(self, n: Self) -> Self {
        // SAFETY: the CPU has the instructions; see the module.
        unsafe {
            let shifted = _mm256_castpd_si256(_mm256_add_pd(n.0, _mm256_set1_pd(INTEGER_SHIFT)));
            V4(_mm256_xor_pd(self.0, _mm256_castsi256_pd(_mm256_slli_epi64::<63>(shifted))))
        }
    }
    #[inline(always)]
    fn odd(n: Self) -> __m256d {
        // SAFETY: the CPU has the instructions; see the module.
        unsafe {
            let shifted = _mm256_castpd_si256(_mm256_add_pd(n.0, _mm256_set1_pd(INTEGER_SHIFT)));
            // blendv and movemask read the sign bit only.
            _mm256_castsi256_pd(_mm256_slli_epi64::<63>(shifted))
        }
    }
    #[inline(always)]
    fn outlined<W: Outlined>(work: W) -> W::Out {
        #[target_feature(enable = "avx2,fma")]
        #[inline(never)]
        fn outlined<W: Outlined>(work: W) -> W::Out {
            work.run()
        }
        // SAFETY: the CPU has the instructions; see the module.
        unsafe { outlined(work) }
    }
}

impl Pack for V4 {
    type Eight = Arr<V4, 2>;
}

impl Quad for V4 {
    #[inline(always)]
    fn lane(self, lane: usize) -> Self {
        // SAFETY: the CPU has the instructions; see the module.
        unsafe {
            V4(match lane {
                0 => _mm256_permute4x64_pd::<0b00_00_00_00>(self.0),
                1 => _mm256_permute4x64_pd::<0b01_01_01_01>(self.0),
                2 => _mm256_permute4x64_pd::<0b10_10_10_10>(self.0),
                _ => _mm256_permute4x64_pd::<0b11_11_11_11>(self.0),
            })
        }
    }
    #[inline(always)]
    fn with_last(self, other: Self) -> Self {
        // SAFETY: the CPU has the instructions; see the module.
        unsafe { V4(_mm256_blend_pd::<0b1000>(self.0, other.0)) }
    }
    #[inline(always)]
    fn with_middle(self, second: Self, third: Self) -> Self {
        // SAFETY: the CPU has the instructions; see the module.
        unsafe { V4(_mm256_blend_pd::<0b0100>(_mm256_blend_pd::<0b0010>(self.0, second.0), third.0)) }
    }
    #[inline(always)]
    fn largest(self) -> Self {
        // SAFETY: the CPU has the instructions; see the module.
        unsafe {
            let of_pairs = _mm256_max_pd(self.0, _mm256_permute_pd::<0b0101>(self.0));
            V4(_mm256_max_pd(of_pairs, _mm256_permute4x64_pd::<0b01_00_11_10>(of_pairs)))
        }
    }
}
