//! Streaming reductions: what is kept of a motion while it runs. Nothing is stored per step.

use crate::method::Scheme;
use crate::model::{Layout, Model, Parameters, cross, direction, dot};
use crate::real::Real;
use crate::special::atan2;

/// What is watched, per body: one number each, updated in place.
#[derive(Clone, Copy)]
pub struct Watched<R> {
    /// The watched body axis: a unit vector along a principal axis, either way.
    pub axis: [R; 3],
    /// +1 or -1: the side on which the watched component was last seen.
    pub side: R,
    /// Sign changes of the watched component.
    pub flips: R,
    /// Time of the first, NaN before.
    pub first_flip: R,
    /// Smallest cosine of the tilt.
    pub cosine: R,
    /// Largest squared sine of the tilt.
    pub sine2: R,
}

/// An observable: looks at each step from `before` to `after`, which began at `time`.
pub trait Observe {
    /// Whether there is anything to look at.
    const WATCHES: bool = true;
    /// Updates `watched`.
    fn after_step<R: Real, M: Model<R>, L: Layout, S: Scheme<R, M, L, D>, const D: usize>(
        scheme: &S,
        p: &Parameters<R>,
        watched: &mut Watched<R>,
        time: R,
        before: &[R; D],
        after: &[R; D],
    );
}

/// Nothing.
pub struct Nothing;

/// Sign changes of one component of the rates, located inside the step.
pub struct Flips;

/// Largest angle between a body axis and a space-fixed direction (the last one carried).
pub struct Tilt;

impl Observe for Nothing {
    const WATCHES: bool = false;
    #[inline(always)]
    fn after_step<R: Real, M: Model<R>, L: Layout, S: Scheme<R, M, L, D>, const D: usize>(
        _scheme: &S,
        _p: &Parameters<R>,
        _watched: &mut Watched<R>,
        _time: R,
        _before: &[R; D],
        _after: &[R; D],
    ) {
    }
}

/// The component along the watched axis. The axis is a unit vector of the frame, so the sum is exact.
#[inline(always)]
fn along<R: Real>(axis: &[R; 3], v: &[R; 3]) -> R {
    axis[0].fma(v[0], axis[1].fma(v[1], axis[2] * v[2]))
}

impl Observe for Flips {
    #[inline(always)]
    fn after_step<R: Real, M: Model<R>, L: Layout, S: Scheme<R, M, L, D>, const D: usize>(
        scheme: &S,
        p: &Parameters<R>,
        watched: &mut Watched<R>,
        time: R,
        before: &[R; D],
        after: &[R; D],
    ) {
        let zero = R::splat(0.0);
        let end = along(&watched.axis, &[after[0], after[1], after[2]]);
        // An exact zero belongs to the side it came from.
        let flipped = (end * watched.side).lt(zero);
        if R::any(flipped) {
            let begin = along(&watched.axis, &[before[0], before[1], before[2]]);
            let begin_rate = along(&watched.axis, &scheme.velocity(p, before)) * p.step;
            let end_rate = along(&watched.axis, &scheme.velocity(p, after)) * p.step;
            let at = p.step.fma(hermite_root(begin, begin_rate, end, end_rate), time);
            let first = watched.flips.lt(R::splat(0.5));
            let time_of_first = R::select(first, at, watched.first_flip);
            watched.first_flip = R::select(flipped, time_of_first, watched.first_flip);
            watched.flips = watched.flips + R::select(flipped, R::splat(1.0), zero);
            watched.side = R::select(flipped, -watched.side, watched.side);
        }
    }
}

/// Where in [0, 1] the cubic with these values and slopes at both ends vanishes, its ends being of
/// opposite sign: regula falsi for a start, then Newton steps kept inside.
#[inline(always)]
fn hermite_root<R: Real>(begin: R, begin_rate: R, end: R, end_rate: R) -> R {
    let (zero, one) = (R::splat(0.0), R::splat(1.0));
    let rise = end - begin;
    let c2 = (rise * R::splat(3.0) - begin_rate) - (begin_rate + end_rate);
    let c3 = (begin_rate + end_rate) - (rise + rise);
    let mut s = begin / (begin - end);
    for _ in 0..4 {
        let value = c3.fma(s, c2).fma(s, begin_rate).fma(s, begin);
        let slope = (c3 * R::splat(3.0)).fma(s, c2 + c2).fma(s, begin_rate);
        let next = s - value / slope;
        // A slope of zero gives a NaN or infinity; min and max then return their second argument.
        s = next.max(zero).min(one);
    }
    s
}

impl Observe for Tilt {
    #[inline(always)]
    fn after_step<R: Real, M: Model<R>, L: Layout, S: Scheme<R, M, L, D>, const D: usize>(
        _scheme: &S,
        _p: &Parameters<R>,
        watched: &mut Watched<R>,
        _time: R,
        _before: &[R; D],
        after: &[R; D],
    ) {
        let n = direction(after, L::VECTORS - 1);
        watch_tilt(watched, &n);
    }
}

/// Updates the largest tilt with the direction `n` seen from the body.
#[inline(always)]
pub fn watch_tilt<R: Real>(watched: &mut Watched<R>, n: &[R; 3]) {
    let cosine = along(&watched.axis, n);
    let sine = cross(&watched.axis, n);
    watched.cosine = watched.cosine.min(cosine);
    watched.sine2 = watched.sine2.max(dot(&sine, &sine));
}

/// The largest tilt, from the smallest cosine and the largest squared sine: the sine is accurate for small
/// angles, the cosine knows the quadrant.
pub fn largest_tilt(cosine: f64, sine2: f64) -> f64 {
    if cosine > 0.5 {
        atan2(sine2.sqrt(), (1.0 - sine2).max(0.0).sqrt())
    } else {
        let cosine = cosine.clamp(-1.0, 1.0);
        atan2(((1.0 - cosine) * (1.0 + cosine)).sqrt(), cosine)
    }
}
