//! Streaming reductions: what is kept of a motion while it runs. Nothing is stored per step.

use crate::method::Scheme;
use crate::model::{Layout, Model, Parameters, cross, direction, dot};
use crate::real::Real;
use crate::special::{atan2, sincos};

/// What is watched, per body: one number each, updated in place.
#[derive(Clone, Copy)]
pub struct Watched<R> {
    /// The watched body axis: a unit vector along a principal axis, either way.
    pub axis: [R; 3],
    /// +1 or -1: the side on which the watched component was last seen.
    pub side: R,
    /// Sign changes of the watched component.
    pub flips: R,
    /// Time at which stability was lost: at the first flip or beyond the limit of the tilt; infinite before.
    pub left: R,
    /// Smallest cosine of the tilt.
    pub cosine: R,
    /// Largest squared sine of the tilt.
    pub sine2: R,
    /// The limit of the tilt, as a cosine and a squared sine; see `TiltLimit`.
    pub limit: [R; 2],
}

/// A largest allowed tilt. Below 60 degrees the squared sine is compared, which is accurate for small angles,
/// above it the cosine, which knows the quadrant; the cosine 1/2 parts the two.
#[derive(Clone, Copy, Debug)]
pub struct TiltLimit {
    /// A tilt with a smaller cosine is beyond the limit.
    pub cosine: f64,
    /// So is one with a larger squared sine.
    pub sine2: f64,
}

impl TiltLimit {
    /// The limit at an angle.
    pub fn new(angle: f64) -> TiltLimit {
        let (sin, cos) = sincos(angle);
        if cos > 0.5 {
            TiltLimit { cosine: 0.5, sine2: sin * sin }
        } else {
            TiltLimit { cosine: cos, sine2: f64::INFINITY }
        }
    }
}

/// Sign changes of one component of the rates, located inside the step.
pub struct Flips;

/// Largest angle between a body axis and a space-fixed direction (the last one carried; of a frame the vertical).
pub struct Tilt;

/// The component along the watched axis. The axis is a unit vector of the frame, so the sum is exact.
#[inline(always)]
fn along<R: Real>(axis: &[R; 3], v: &[R; 3]) -> R {
    axis[0].fma(v[0], axis[1].fma(v[1], axis[2] * v[2]))
}

impl Flips {
    /// Looks at a step from `before` to `after`, which began at `time`.
    #[inline(always)]
    pub fn after_step<R: Real, M: Model<R>, L: Layout, S: Scheme<R, M, L, D>, const D: usize>(
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
            watched.left = R::select(flipped, first_time(watched.left, at), watched.left);
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

impl Tilt {
    /// Looks at a step from `before` to `after`, which began at `time`.
    #[inline(always)]
    pub fn after_step<R: Real, M: Model<R>, L: Layout, S: Scheme<R, M, L, D>, const D: usize>(
        _scheme: &S,
        p: &Parameters<R>,
        watched: &mut Watched<R>,
        time: R,
        before: &[R; D],
        after: &[R; D],
    ) {
        let [cosine, sine2] = tilt(&watched.axis, &direction(after, L::WATCHED));
        watched.cosine = watched.cosine.min(cosine);
        watched.sine2 = watched.sine2.max(sine2);
        let margin = margin(&watched.limit, [cosine, sine2]);
        let beyond = margin.lt(R::splat(0.0));
        if R::any(beyond) {
            // Where the margin vanishes on the way, to first order; at once if it was gone before.
            let begin = tilt(&watched.axis, &direction(before, L::WATCHED));
            let begin = self::margin(&watched.limit, begin).max(R::splat(0.0));
            let at = p.step.fma(begin / (begin - margin), time);
            watched.left = R::select(beyond, first_time(watched.left, at), watched.left);
        }
    }
}

/// Cosine and squared sine of the angle between a body axis and a direction seen from the body.
#[inline(always)]
pub fn tilt<R: Real>(axis: &[R; 3], n: &[R; 3]) -> [R; 2] {
    let sine = cross(axis, n);
    [along(axis, n), dot(&sine, &sine)]
}

/// How far a tilt is from its limit; negative beyond.
#[inline(always)]
fn margin<R: Real>(limit: &[R; 2], [cosine, sine2]: [R; 2]) -> R {
    (cosine - limit[0]).min(limit[1] - sine2)
}

/// `at`, unless something was lost before.
#[inline(always)]
fn first_time<R: Real>(left: R, at: R) -> R {
    R::select(left.lt(R::splat(f64::INFINITY)), left, at)
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
