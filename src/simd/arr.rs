//! `Arr<R, K>`: K packs in flight, so that one chain of operations hides the latency of the others.

use crate::real::{Outlined, Pack, Real};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// K registers that pass through a kernel together.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct Arr<R, const K: usize>([R; K]);

macro_rules! each_operator {
    ($($trait:ident $method:ident),*) => {$(
        impl<R: Real, const K: usize> $trait for Arr<R, K> {
            type Output = Self;
            #[inline(always)]
            fn $method(mut self, other: Self) -> Self {
                for i in 0..K {
                    self.0[i] = $trait::$method(self.0[i], other.0[i]);
                }
                self
            }
        }
    )*};
}
each_operator!(Add add, Sub sub, Mul mul, Div div);

impl<R: Real, const K: usize> Neg for Arr<R, K> {
    type Output = Self;
    #[inline(always)]
    fn neg(mut self) -> Self {
        for i in 0..K {
            self.0[i] = -self.0[i];
        }
        self
    }
}

macro_rules! each {
    ($(fn $method:ident(self $(, $arg:ident)*);)*) => {$(
        #[inline(always)]
        fn $method(mut self $(, $arg: Self)*) -> Self {
            for i in 0..K {
                self.0[i] = Real::$method(self.0[i] $(, $arg.0[i])*);
            }
            self
        }
    )*};
}

impl<R: Real, const K: usize> Real for Arr<R, K> {
    type Mask = [R::Mask; K];
    const LANES: usize = R::LANES * K;
    #[inline(always)]
    fn load(from: &[f64]) -> Self {
        let mut packs = [R::splat(0.0); K];
        for i in 0..K {
            packs[i] = R::load(&from[i * R::LANES..]);
        }
        Arr(packs)
    }
    #[inline(always)]
    fn store(self, to: &mut [f64]) {
        for i in 0..K {
            self.0[i].store(&mut to[i * R::LANES..]);
        }
    }
    #[inline(always)]
    fn splat(x: f64) -> Self {
        Arr([R::splat(x); K])
    }
    #[inline(always)]
    fn first(self) -> f64 {
        self.0[0].first()
    }
    each! {
        fn fma(self, b, c);
        fn fnma(self, b, c);
        fn fms(self, b, c);
        fn sqrt(self);
        fn abs(self);
        fn min(self, other);
        fn max(self, other);
        fn round(self);
        fn exp2i(self);
        fn neg_if_odd(self, n);
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Self::Mask {
        let mut mask = [R::lt(self.0[0], other.0[0]); K];
        for i in 1..K {
            mask[i] = R::lt(self.0[i], other.0[i]);
        }
        mask
    }
    #[inline(always)]
    fn select(mask: Self::Mask, mut a: Self, b: Self) -> Self {
        for i in 0..K {
            a.0[i] = R::select(mask[i], a.0[i], b.0[i]);
        }
        a
    }
    #[inline(always)]
    fn any(mask: Self::Mask) -> bool {
        let mut any = false;
        for i in 0..K {
            any |= R::any(mask[i]);
        }
        any
    }
    #[inline(always)]
    fn frexp(self) -> (Self, Self) {
        let (mut mantissa, mut exponent) = (self, self);
        for i in 0..K {
            (mantissa.0[i], exponent.0[i]) = R::frexp(self.0[i]);
        }
        (mantissa, exponent)
    }
    #[inline(always)]
    fn odd(n: Self) -> Self::Mask {
        let mut mask = [R::odd(n.0[0]); K];
        for i in 1..K {
            mask[i] = R::odd(n.0[i]);
        }
        mask
    }
    #[inline(always)]
    fn outlined<W: Outlined>(work: W) -> W::Out {
        R::outlined(work)
    }
}

impl<R: Pack, const K: usize> Pack for Arr<R, K> {
    type Eight = Self;
}

impl Pack for f64 {
    type Eight = Arr<f64, 8>;
}
