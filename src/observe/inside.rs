//! A number inside a step: its least value, and where it passes zero.

use crate::method::Coefficients;
use crate::real::Real;

/// A number inside a step.
pub(super) trait Inside<R> {
    /// The number at a fraction of the step.
    fn at(&self, fraction: R) -> R;
}

/// A state inside a step, by the powers of the fraction of the step.
#[inline(always)]
pub(super) fn state<R: Real, const D: usize>(dense: &Coefficients<R, D>, fraction: R) -> [R; D] {
    let mut y = *dense.order(dense.highest());
    for k in (0..dense.highest()).rev() {
        let next = dense.order(k);
        for d in 0..D {
            y[d] = y[d].fma(fraction, next[d]);
        }
    }
    y
}

/// A bound from below of a number inside a step, from its values and slopes at both ends: the least control point of the
/// cubic, and what the number may be below the cubic. That is at most `s^4 / 384` of the size of a number that turns by
/// `s` in the step; a sixteenth of the slopes is twenty times as much for steps up to 1 rad.
#[inline(always)]
pub(super) fn lowest<R: Real>([begin, end]: [R; 2], [begin_slope, end_slope]: [R; 2]) -> R {
    let third = R::splat(1.0 / 3.0);
    let (after_begin, before_end) = (third.fma(begin_slope, begin), third.fnma(end_slope, end));
    let lowest = begin.min(after_begin).min(before_end.min(end));
    let spread = begin_slope.abs() + end_slope.abs();
    spread.fnma(R::splat(1.0 / 16.0), lowest)
}

/// Where a number with these slopes at both ends has a minimum between them.
#[inline(always)]
pub(super) fn has_minimum<R: Real>([begin_slope, end_slope]: [R; 2]) -> R::Mask {
    let zero = R::splat(0.0);
    R::both(begin_slope.lt(zero), zero.lt(end_slope))
}

/// The place of the least value between two places, and the value: by the parabola through three places about the best one
/// so far, which are a quarter as far apart each time.
#[inline(always)]
pub(super) fn least<R: Real, const TIMES: usize>(
    inside: &impl Inside<R>,
    [first, last]: [R; 2],
    near: R,
    reach: R,
) -> [R; 2] {
    let (zero, half, one) = (R::splat(0.0), R::splat(0.5), R::splat(1.0));
    let (mut at, mut reach) = (near, reach);
    let (mut place, mut value) = (near, inside.at(near));
    for _ in 0..TIMES {
        let mut around = [zero; 3];
        for side in 0..3 {
            let there = reach.fma(R::splat(side as f64 - 1.0), at);
            around[side] = inside.at(there);
            let is_lower = R::except(R::except(around[side].lt(value), there.lt(first)), last.lt(there));
            value = R::select(is_lower, around[side], value);
            place = R::select(is_lower, there, place);
        }
        let bend = (around[0] - around[1]) + (around[2] - around[1]);
        let shift = ((around[0] - around[2]) * half) / bend;
        // Without a minimum between the three places the middle one stays, and the lowest one is kept.
        let shift = shift.max(-(one + one)).min(one + one);
        at = reach.fma(R::select(zero.lt(bend), shift, zero), at).max(first).min(last);
        reach = reach * R::splat(0.25);
    }
    [place, value]
}

/// A bracket of a zero: two places inside a step, as fractions of it, and a number at each, which is not negative at the
/// first place and negative at the last.
#[derive(Clone, Copy)]
pub(super) struct Bracket<R> {
    /// The place, and the number there.
    pub(super) from: [R; 2],
    pub(super) to: [R; 2],
}

impl<R: Real> Bracket<R> {
    /// No bracket: it ends nowhere.
    #[inline(always)]
    pub(super) fn none() -> Self {
        Bracket { from: [R::splat(0.0); 2], to: [R::splat(f64::INFINITY); 2] }
    }

    /// Whether it ends somewhere.
    #[inline(always)]
    pub(super) fn is_known(&self) -> R::Mask {
        self.to[0].lt(R::splat(f64::INFINITY))
    }

    /// Replaces it by another one in some lanes.
    #[inline(always)]
    pub(super) fn set(&mut self, lanes: R::Mask, other: Bracket<R>) {
        for k in 0..2 {
            self.from[k] = R::select(lanes, other.from[k], self.from[k]);
            self.to[k] = R::select(lanes, other.to[k], self.to[k]);
        }
    }

    /// The bracket the other way round.
    #[inline(always)]
    pub(super) fn reversed(self) -> Self {
        Bracket { from: self.to, to: self.from }
    }

    /// Where the number passes zero: regula falsi with half the value of an end that remains twice (the Illinois rule;
    /// Dowell & Jarratt 1971, doi 10.1007/BF01934364).
    #[inline(always)]
    pub(super) fn crossing(self, inside: &impl Inside<R>) -> R {
        let (zero, half, one) = (R::splat(0.0), R::splat(0.5), R::splat(1.0));
        let Bracket { from: [mut low, mut inner], to: [mut high, mut outer] } = self;
        let mut last_side = zero;
        for _ in 0..16 {
            let fraction = (high - low).fma(inner / (inner - outer), low);
            let value = inside.at(fraction);
            let beyond = value.lt(zero);
            let side = R::select(beyond, one, -one);
            let weight = R::select(zero.lt(side * last_side), half, one);
            last_side = side;
            (low, high) = (R::select(beyond, low, fraction), R::select(beyond, fraction, high));
            (inner, outer) =
                (R::select(beyond, inner * weight, value), R::select(beyond, value, outer * weight));
        }
        (high - low).fma(inner / (inner - outer), low)
    }
}
