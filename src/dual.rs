//! `Dual`: a number and its derivative in one direction, so that equations that are written once give both (Griewank,
//! Walther, Evaluating Derivatives, 2nd ed., 2008, §3.1).

use crate::real::{Outlined, Real};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number and its derivative. The numbers alone have the bits that they have without derivatives; comparisons are those
/// of the numbers.
#[derive(Clone, Copy)]
pub struct Dual<R> {
    /// The number.
    pub value: R,
    /// The derivative.
    pub slope: R,
}

impl<R: Real> Dual<R> {
    /// A number that does not change.
    #[inline(always)]
    pub fn constant(value: R) -> Self {
        Dual { value, slope: R::splat(0.0) }
    }

    /// Numbers and their derivatives.
    #[inline(always)]
    pub fn of<const N: usize>(values: &[R; N], slopes: &[R; N]) -> [Self; N] {
        let mut numbers = [Dual { value: values[0], slope: slopes[0] }; N];
        for k in 1..N {
            numbers[k] = Dual { value: values[k], slope: slopes[k] };
        }
        numbers
    }

    /// Quotients whose values are known, from the derivatives of their dividends and divisors, and one over the divisors.
    #[inline(always)]
    pub fn quotients(values: &[R; 3], dividends: [R; 3], divisors: &[R; 3], inverse: &[R; 3]) -> [Self; 3] {
        let mut slopes = dividends;
        for k in 0..3 {
            slopes[k] = values[k].fnma(divisors[k], dividends[k]) * inverse[k];
        }
        Dual::of(values, &slopes)
    }

    /// The numbers.
    #[inline(always)]
    pub fn values<const N: usize>(numbers: &[Self; N]) -> [R; N] {
        let mut values = [numbers[0].value; N];
        for k in 1..N {
            values[k] = numbers[k].value;
        }
        values
    }

    /// The derivatives.
    #[inline(always)]
    pub fn slopes<const N: usize>(numbers: &[Self; N]) -> [R; N] {
        let mut slopes = [numbers[0].slope; N];
        for k in 1..N {
            slopes[k] = numbers[k].slope;
        }
        slopes
    }
}

impl<R: Real> Add for Dual<R> {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        Dual { value: self.value + b.value, slope: self.slope + b.slope }
    }
}

impl<R: Real> Sub for Dual<R> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        Dual { value: self.value - b.value, slope: self.slope - b.slope }
    }
}

impl<R: Real> Mul for Dual<R> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, b: Self) -> Self {
        Dual { value: self.value * b.value, slope: self.value.fma(b.slope, self.slope * b.value) }
    }
}

impl<R: Real> Div for Dual<R> {
    type Output = Self;
    #[inline(always)]
    fn div(self, b: Self) -> Self {
        let value = self.value / b.value;
        Dual { value, slope: value.fnma(b.slope, self.slope) / b.value }
    }
}

impl<R: Real> Neg for Dual<R> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Dual { value: -self.value, slope: -self.slope }
    }
}

impl<R: Real> Real for Dual<R> {
    type Mask = R::Mask;
    const LANES: usize = R::LANES;
    #[inline(always)]
    fn load(from: &[f64]) -> Self {
        Dual::constant(R::load(from))
    }
    #[inline(always)]
    fn store(self, to: &mut [f64]) {
        self.value.store(to);
    }
    #[inline(always)]
    fn splat(x: f64) -> Self {
        Dual::constant(R::splat(x))
    }
    #[inline(always)]
    fn fma(self, b: Self, c: Self) -> Self {
        let slope = self.value.fma(b.slope, self.slope.fma(b.value, c.slope));
        Dual { value: self.value.fma(b.value, c.value), slope }
    }
    #[inline(always)]
    fn fnma(self, b: Self, c: Self) -> Self {
        let slope = self.value.fnma(b.slope, self.slope.fnma(b.value, c.slope));
        Dual { value: self.value.fnma(b.value, c.value), slope }
    }
    #[inline(always)]
    fn fms(self, b: Self, c: Self) -> Self {
        let slope = self.value.fma(b.slope, self.slope.fms(b.value, c.slope));
        Dual { value: self.value.fms(b.value, c.value), slope }
    }
    /// The root of zero, which has no derivative, has none here.
    #[inline(always)]
    fn sqrt(self) -> Self {
        let (root, zero) = (self.value.sqrt(), R::splat(0.0));
        Dual { value: root, slope: R::select(zero.lt(root), self.slope / (root + root), zero) }
    }
    #[inline(always)]
    fn abs(self) -> Self {
        let slope = R::select(self.value.lt(R::splat(0.0)), -self.slope, self.slope);
        Dual { value: self.value.abs(), slope }
    }
    #[inline(always)]
    fn size(self) -> Self {
        Dual::constant(self.value.size() + self.slope.size())
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Dual::select(self.lt(other), self, other)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Dual::select(other.lt(self), self, other)
    }
    #[inline(always)]
    fn round(self) -> Self {
        Dual::constant(self.value.round())
    }
    #[inline(always)]
    fn first(self) -> f64 {
        self.value.first()
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Self::Mask {
        self.value.lt(other.value)
    }
    #[inline(always)]
    fn select(mask: Self::Mask, a: Self, b: Self) -> Self {
        Dual { value: R::select(mask, a.value, b.value), slope: R::select(mask, a.slope, b.slope) }
    }
    #[inline(always)]
    fn any(mask: Self::Mask) -> bool {
        R::any(mask)
    }
    #[inline(always)]
    fn exp2i(self) -> Self {
        Dual::constant(self.value.exp2i())
    }
    #[inline(always)]
    fn frexp(self) -> (Self, Self) {
        let (value, exponent) = self.value.frexp();
        (Dual { value, slope: self.slope * (-exponent).exp2i() }, Dual::constant(exponent))
    }
    #[inline(always)]
    fn neg_if_odd(self, n: Self) -> Self {
        Dual { value: self.value.neg_if_odd(n.value), slope: self.slope.neg_if_odd(n.value) }
    }
    #[inline(always)]
    fn odd(n: Self) -> Self::Mask {
        R::odd(n.value)
    }
    #[inline(always)]
    fn outlined<W: Outlined>(work: W) -> W::Out {
        R::outlined(work)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::special::{exp, ln, sincos};

    /// The derivative of a function at a number.
    fn slope(f: impl Fn(Dual<f64>) -> Dual<f64>, at: f64) -> f64 {
        f(Dual { value: at, slope: 1.0 }).slope
    }

    #[test]
    fn derivatives_of_functions_are_those_of_calculus() {
        for at in [0.3, 1.7, 11.0] {
            let (sin, cos) = sincos(at);
            let (x, one) = (at, 1.0);
            for (found, known) in [
                (slope(|x| x * x - x / (x + Dual::splat(1.0)), x), 2.0 * x - one / ((x + 1.0) * (x + 1.0))),
                (slope(Real::sqrt, x), 0.5 / x.sqrt()),
                (slope(|x| (-x).abs(), x), 1.0),
                (slope(|x| x.fma(x, x), x), 2.0 * x + 1.0),
                (slope(|x| x.fnma(x, x), x), 1.0 - 2.0 * x),
                (slope(|x| x.fms(x, x), x), 2.0 * x - 1.0),
                (slope(|x| x.min(Dual::splat(1.0)), x), if x < 1.0 { 1.0 } else { 0.0 }),
                (slope(|x| x.max(Dual::splat(1.0)), x), if x > 1.0 { 1.0 } else { 0.0 }),
                // Polynomials that are close in value to a function are so in slope, to a few roundings.
                (slope(|x| sincos(x).0, x), cos),
                (slope(|x| sincos(x).1, x), -sin),
                (slope(exp, x), exp(x)),
                (slope(ln, x), 1.0 / x),
            ] {
                assert!((found - known).abs() < 1e-14 * (1.0 + known.abs()), "{at}: {found} {known}");
            }
        }
        assert_eq!(slope(Real::sqrt, 0.0), 0.0);
    }
}
