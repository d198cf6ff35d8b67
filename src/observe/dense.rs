//! The polynomial of a step, and its zeros.

use crate::method::Coefficients;
use crate::real::Real;

/// Three numbers that are linear in a state.
pub(super) trait Part<R>: Copy {
    /// The numbers of a state, or of one order of it.
    fn of<const D: usize>(self, state: &[R; D]) -> [R; 3];
}

/// Three neighbouring numbers, from this index on.
impl<R: Real> Part<R> for usize {
    #[inline(always)]
    fn of<const D: usize>(self, state: &[R; D]) -> [R; 3] {
        [state[self], state[self + 1], state[self + 2]]
    }
}

/// A part of a state inside a step, and its slopes.
#[inline(always)]
pub(super) fn interpolate<R: Real, const D: usize>(
    dense: &Coefficients<R, D>,
    part: impl Part<R>,
    fraction: R,
) -> ([R; 3], [R; 3]) {
    let order = dense.highest();
    let mut value = part.of(dense.order(order));
    let mut slope = [R::splat(0.0); 3];
    for k in (0..order).rev() {
        let next = part.of(dense.order(k));
        for i in 0..3 {
            slope[i] = slope[i].fma(fraction, value[i]);
            value[i] = value[i].fma(fraction, next[i]);
        }
    }
    (value, slope)
}

/// A Newton step for a zero in [0, 1].
#[inline(always)]
pub(super) fn newton<R: Real>(fraction: R, value: R, slope: R) -> R {
    // A slope of zero gives a NaN or infinity; min and max then return their second argument.
    (fraction - value / slope).max(R::splat(0.0)).min(R::splat(1.0))
}

/// Bounds of a zero in [0, 1] of a function that ends with this value, and begins with one of the other sign.
pub(super) struct Bracket<R> {
    low: R,
    high: R,
    end: R,
}

impl<R: Real> Bracket<R> {
    #[inline(always)]
    pub(super) fn new(end: R) -> Self {
        Bracket { low: R::splat(0.0), high: R::splat(1.0), end }
    }

    /// A Newton step, or half the bracket where the step leaves the bracket: a function that begins near zero, and moves
    /// away first, has a zero beside the begin too.
    #[inline(always)]
    pub(super) fn newton(&mut self, fraction: R, value: R, slope: R) -> R {
        let is_past = R::splat(0.0).lt(value * self.end);
        self.high = R::select(is_past, fraction, self.high);
        self.low = R::select(is_past, self.low, fraction);
        let (next, middle) = (fraction - value / slope, (self.low + self.high) * R::splat(0.5));
        let inside = R::select(next.lt(self.low), middle, R::select(self.high.lt(next), middle, next));
        // Of a value and a slope of zero the quotient is NaN; max and min then return their second argument.
        inside.max(self.low).min(self.high)
    }
}

/// Zero in [0, 1] of the cubic with these values and slopes at both ends, where the values have opposite signs: one
/// step of regula falsi, then bracketed Newton steps. A cubic that begins at zero and moves away first has its zero later.
#[inline(always)]
pub(super) fn hermite_root<R: Real>(begin: R, begin_rate: R, end: R, end_rate: R) -> R {
    let mut bracket = Bracket::new(end);
    let difference = end - begin;
    let c2 = (difference * R::splat(3.0) - begin_rate) - (begin_rate + end_rate);
    let c3 = (begin_rate + end_rate) - (difference + difference);
    let zero = R::splat(0.0);
    let mut s = begin / (begin - end);
    let later = R::select((begin_rate * end).lt(zero), R::splat(0.5), s);
    s = R::select(zero.lt(begin * begin), s, later);
    for _ in 0..4 {
        let value = c3.fma(s, c2).fma(s, begin_rate).fma(s, begin);
        let slope = (c3 * R::splat(3.0)).fma(s, c2 + c2).fma(s, begin_rate);
        s = bracket.newton(s, value, slope);
    }
    s
}

/// Weights of the change, of the slope at the begin and of that at the end, in the cubic with these values and slopes.
#[inline(always)]
pub(super) fn hermite_weights<R: Real>(fraction: R) -> [R; 3] {
    let rest = R::splat(1.0) - fraction;
    let (square, across) = (fraction * fraction, fraction * rest);
    [square * (rest + (rest + R::splat(1.0))), across * rest, -(across * fraction)]
}

/// Fraction of a step at which a component of a part of a state has an extremum, if the slopes at both ends have opposite
/// signs.
#[inline(always)]
pub(super) fn turning_point<R: Real, const D: usize>(
    dense: &Coefficients<R, D>,
    part: impl Part<R>,
    axis: &[R; 3],
    [begin_slope, end_slope]: [R; 2],
) -> R {
    let mut fraction = begin_slope / (begin_slope - end_slope);
    for _ in 0..5 {
        let (mut slope, mut curvature) = (R::splat(0.0), R::splat(0.0));
        for k in (1..=dense.highest()).rev() {
            curvature = curvature.fma(fraction, slope);
            let along = super::along(axis, &part.of(dense.order(k)));
            slope = slope.fma(fraction, along * R::splat(k as f64));
        }
        fraction = newton(fraction, slope, curvature);
    }
    fraction
}
