//! Streaming reductions: what is kept of a motion while it runs. Nothing is stored per step.

use crate::method::{Coefficients, Scheme};
use crate::model::{Layout, Model, Parameters, cross, direction, direction_rate, dot};
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
    /// Looks at the step between two states that began at `time`. A series has left the coefficients of its way.
    #[inline(always)]
    pub fn after_step<R: Real, M: Model<R>, L: Layout, S: Scheme<R, M, L, D>, const D: usize>(
        scheme: &S,
        p: &Parameters<R>,
        watched: &mut Watched<R>,
        time: R,
        [before, after]: [&[R; D]; 2],
        course: &Coefficients<R, D>,
    ) {
        let zero = R::splat(0.0);
        let end = along(&watched.axis, &[after[0], after[1], after[2]]);
        // An exact zero belongs to the side it came from.
        let flipped = (end * watched.side).lt(zero);
        if R::any(flipped) {
            let begin = along(&watched.axis, &[before[0], before[1], before[2]]);
            let begin_rate = along(&watched.axis, &scheme.velocity(p, before)) * p.step;
            let end_rate = along(&watched.axis, &scheme.velocity(p, after)) * p.step;
            let mut share = hermite_root(begin, begin_rate, end, end_rate);
            if const { S::ORDER > 0 } {
                // The cubic is off by a hundredth at most; Newton squares that.
                for _ in 0..3 {
                    let (omega, rate) = on_the_way(course, S::ORDER, 0, share);
                    share = newton(share, along(&watched.axis, &omega), along(&watched.axis, &rate));
                }
            }
            let at = p.step.fma(share, time);
            watched.left = R::select(flipped, first_time(watched.left, at), watched.left);
            watched.flips = watched.flips + R::select(flipped, R::splat(1.0), zero);
            watched.side = R::select(flipped, -watched.side, watched.side);
        }
        if const { S::ORDER > 0 } {
            Self::twice_in_a_step(scheme, p, watched, time, [before, after], course);
        }
    }

    /// In a long step a component may pass zero and come back: towards zero at the begin, away from it at the end, and
    /// beyond it between.
    #[inline(always)]
    fn twice_in_a_step<R: Real, M: Model<R>, L: Layout, S: Scheme<R, M, L, D>, const D: usize>(
        scheme: &S,
        p: &Parameters<R>,
        watched: &mut Watched<R>,
        time: R,
        [before, after]: [&[R; D]; 2],
        course: &Coefficients<R, D>,
    ) {
        let zero = R::splat(0.0);
        let first = course.order(1);
        let begin_slope = along(&watched.axis, &[first[0], first[1], first[2]]) * watched.side;
        let end_slope = along(&watched.axis, &scheme.velocity(p, after)) * p.step * watched.side;
        let dips = R::select(zero.lt(end_slope), begin_slope, zero).lt(zero);
        if R::any(dips) {
            let turn = turning_share(course, S::ORDER, 0, &watched.axis, [begin_slope, end_slope]);
            let (omega, _) = on_the_way(course, S::ORDER, 0, turn);
            let begin = along(&watched.axis, &[before[0], before[1], before[2]]) * watched.side;
            let deepest = along(&watched.axis, &omega) * watched.side;
            // Not of a step that ends on the other side: that is one flip, and `side` is the new one by now.
            let twice = R::select(zero.lt(begin), R::select(dips, deepest, zero), zero).lt(zero);
            if R::any(twice) {
                let mut share = turn * (begin / (begin - deepest));
                for _ in 0..6 {
                    let (omega, rate) = on_the_way(course, S::ORDER, 0, share);
                    let (value, slope) = (along(&watched.axis, &omega), along(&watched.axis, &rate));
                    // The first of the two lies before the turn.
                    share = newton(share, value, slope).min(turn);
                }
                let at = p.step.fma(share, time);
                watched.left = R::select(twice, first_time(watched.left, at), watched.left);
                watched.flips = watched.flips + R::select(twice, R::splat(2.0), zero);
            }
        }
    }
}

/// Three neighbouring numbers of a state from the `first` on, a share of the step after its begin, and their slopes.
#[inline(always)]
fn on_the_way<R: Real, const D: usize>(
    course: &Coefficients<R, D>,
    order: usize,
    first: usize,
    share: R,
) -> ([R; 3], [R; 3]) {
    let top = course.order(order);
    let mut value = [top[first], top[first + 1], top[first + 2]];
    let mut slope = [R::splat(0.0); 3];
    for k in (0..order).rev() {
        for i in 0..3 {
            slope[i] = slope[i].fma(share, value[i]);
            value[i] = value[i].fma(share, course.order(k)[first + i]);
        }
    }
    (value, slope)
}

/// A Newton step for a zero in [0, 1].
#[inline(always)]
fn newton<R: Real>(share: R, value: R, slope: R) -> R {
    // A slope of zero gives a NaN or infinity; min and max then return their second argument.
    (share - value / slope).max(R::splat(0.0)).min(R::splat(1.0))
}

/// Where in [0, 1] the cubic with these values and slopes at both ends vanishes, its ends being of
/// opposite sign: regula falsi for a start, then Newton steps kept inside.
#[inline(always)]
fn hermite_root<R: Real>(begin: R, begin_rate: R, end: R, end_rate: R) -> R {
    let rise = end - begin;
    let c2 = (rise * R::splat(3.0) - begin_rate) - (begin_rate + end_rate);
    let c3 = (begin_rate + end_rate) - (rise + rise);
    let mut s = begin / (begin - end);
    for _ in 0..4 {
        let value = c3.fma(s, c2).fma(s, begin_rate).fma(s, begin);
        let slope = (c3 * R::splat(3.0)).fma(s, c2 + c2).fma(s, begin_rate);
        s = newton(s, value, slope);
    }
    s
}

impl Tilt {
    /// Looks at the step between two states that began at `time`. Steps of a series are long, and it has left the
    /// coefficients of its way: a largest tilt inside the step is looked at too, and the limit met where it is.
    #[inline(always)]
    pub fn after_step<R: Real, M: Model<R>, L: Layout, S: Scheme<R, M, L, D>, const D: usize>(
        p: &Parameters<R>,
        watched: &mut Watched<R>,
        time: R,
        [before, after]: [&[R; D]; 2],
        course: &Coefficients<R, D>,
    ) {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let at_end = direction(after, L::WATCHED);
        let [mut cosine, mut sine2] = tilt(&watched.axis, &at_end);
        let mut share = one;
        if const { S::ORDER > 0 } {
            let first_rate = course.order(1);
            let begin_slope = along(&watched.axis, &direction(first_rate, L::WATCHED));
            let omega = [after[0], after[1], after[2]];
            let end_slope = along(&watched.axis, &direction_rate(&at_end, &omega)) * p.step;
            // The cosine falls, then rises.
            let turns = R::select(zero.lt(end_slope), begin_slope, zero).lt(zero);
            if R::any(turns) {
                let first = 3 + 3 * L::WATCHED;
                let turn = turning_share(course, S::ORDER, first, &watched.axis, [begin_slope, end_slope]);
                let (n, _) = on_the_way(course, S::ORDER, 3 + 3 * L::WATCHED, turn);
                let [cosine_there, sine2_there] = tilt(&watched.axis, &n);
                share = R::select(turns, turn, share);
                cosine = R::select(turns, cosine_there, cosine);
                sine2 = R::select(turns, sine2_there, sine2);
            }
        }
        watched.cosine = watched.cosine.min(cosine);
        watched.sine2 = watched.sine2.max(sine2);
        let end = margin(&watched.limit, [cosine, sine2]);
        let lost = R::select(watched.left.lt(R::splat(f64::INFINITY)), zero, end).lt(zero);
        if R::any(lost) {
            let begin = tilt(&watched.axis, &direction(before, L::WATCHED));
            // At once if it was gone before.
            let begin = margin(&watched.limit, begin).max(zero);
            let share = if const { S::ORDER > 0 } {
                meeting_share::<R, L, D>(course, S::ORDER, watched, [begin, end], share)
            } else {
                // To first order.
                begin / (begin - end)
            };
            let at = p.step.fma(share, time);
            watched.left = R::select(lost, at, watched.left);
        }
    }
}

/// Where in a step the part along an axis of three numbers, from the `first` on, turns, its slopes at both ends being
/// of opposite sign.
#[inline(always)]
fn turning_share<R: Real, const D: usize>(
    course: &Coefficients<R, D>,
    order: usize,
    first: usize,
    axis: &[R; 3],
    [begin_slope, end_slope]: [R; 2],
) -> R {
    let mut share = begin_slope / (begin_slope - end_slope);
    for _ in 0..5 {
        let (mut slope, mut bend) = (R::splat(0.0), R::splat(0.0));
        for k in (1..=order).rev() {
            bend = bend.fma(share, slope);
            let row = course.order(k);
            let along = along(axis, &[row[first], row[first + 1], row[first + 2]]);
            slope = slope.fma(share, along * R::splat(k as f64));
        }
        share = newton(share, slope, bend);
    }
    share
}

/// Where in a step the limit is met, between margins that are not negative and negative: regula falsi, halving the
/// margin of an end that stays again (the Illinois rule; Dowell & Jarratt 1971, doi 10.1007/BF01934364).
#[inline(always)]
fn meeting_share<R: Real, L: Layout, const D: usize>(
    course: &Coefficients<R, D>,
    order: usize,
    watched: &Watched<R>,
    [mut inner, mut outer]: [R; 2],
    last: R,
) -> R {
    let (zero, half, one) = (R::splat(0.0), R::splat(0.5), R::splat(1.0));
    let (mut low, mut high) = (zero, last);
    let mut moved = zero;
    for _ in 0..16 {
        let share = (high - low).fma(inner / (inner - outer), low);
        let (n, _) = on_the_way(course, order, 3 + 3 * L::WATCHED, share);
        let margin = margin(&watched.limit, tilt(&watched.axis, &n));
        let gone = margin.lt(zero);
        let moves = R::select(gone, one, -one);
        let stays = R::select(zero.lt(moves * moved), half, one);
        moved = moves;
        (low, high) = (R::select(gone, low, share), R::select(gone, share, high));
        (inner, outer) = (R::select(gone, inner * stays, margin), R::select(gone, margin, outer * stays));
    }
    (high - low).fma(inner / (inner - outer), low)
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
