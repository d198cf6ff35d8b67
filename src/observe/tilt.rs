//! The tilt of a body axis.

use super::dense::{Part, interpolate, turning_point};
use super::{EXIT_TIME, Observable, Rows, Segment, Start, Update, along, three};
use crate::kinematics::{cross, direction, direction_rate, dot};
use crate::method::{Coefficients, Engine};
use crate::real::Real;
use crate::scene::{Layout, Model, Parameters};
use crate::special::{atan2, sincos};
use std::marker::PhantomData;

/// Largest angle between a body axis and a direction that is fixed in space: `Layout::OBSERVED`, or the normal of an orbit.
pub struct Tilt;

/// The direction in a state from which the tilt is measured, of layouts with an orbit from the space axes 3, 1 and 2.
struct Reference<R, L> {
    normal: [R; 3],
    layout: PhantomData<L>,
}

impl<R: Copy, L> Clone for Reference<R, L> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<R: Copy, L> Copy for Reference<R, L> {}

impl<R: Real, L: Layout> Reference<R, L> {
    #[inline(always)]
    fn of_rows(rows: &Rows<R>) -> Self {
        Reference { normal: three(rows, Tilt::NORMAL), layout: PhantomData }
    }
}

impl<R: Real, L: Layout> Part<R> for Reference<R, L> {
    #[inline(always)]
    fn of<const D: usize>(self, state: &[R; D]) -> [R; 3] {
        if L::OWN == 0 {
            return direction(state, L::OBSERVED);
        }
        combined(&self.normal, &[direction(state, 1), direction(state, 2), direction(state, 0)])
    }
}

/// A vector of space in the body, from the axes of space there. The third axis alone keeps its bits.
#[inline(always)]
fn combined<R: Real>(v: &[R; 3], axes: &[[R; 3]; 3]) -> [R; 3] {
    let [first, second, third] = axes;
    let mut sum = *third;
    for i in 0..3 {
        sum[i] = v[2].fma(third[i], v[0].fma(first[i], v[1] * second[i]));
    }
    sum
}

impl Tilt {
    /// Smallest cosine of the tilt.
    pub const COSINE: usize = 1;
    /// Largest squared sine of the tilt.
    pub const SINE2: usize = 2;
    /// The observed body axis: a unit vector along a principal axis, in either direction.
    pub const AXIS: usize = 3;
    /// The limit of the tilt, as a cosine and a squared sine; a smaller cosine or a larger squared sine exceeds the
    /// limit. Below 60 degrees the squared sine is compared, which is accurate for small angles; above 60 degrees the
    /// cosine is compared, which determines the quadrant. The cosine 1/2 separates the two cases.
    pub const LIMIT: usize = 6;
    /// The normal of the orbit in space; axis 3 without an orbit.
    pub const NORMAL: usize = 8;

    /// The limit at an angle; no tilt exceeds an infinite limit.
    fn limit(angle: f64) -> [f64; 2] {
        if angle == f64::INFINITY {
            return [f64::NEG_INFINITY, f64::INFINITY];
        }
        let (sin, cos) = sincos(angle);
        if cos > 0.5 { [0.5, sin * sin] } else { [cos, f64::INFINITY] }
    }
}

impl Observable for Tilt {
    const ROWS: usize = 11;
    const CHANGING: usize = 3;

    fn start(start: &Start) -> Rows<f64> {
        let mut rows = super::UNOBSERVED;
        let (mut normal, mut reference) = ([0.0, 0.0, 1.0], start.direction);
        if let Some(of_orbit) = start.forces.and_then(|(forces, _)| forces.further.orbit.normal()) {
            let [third, first] = start.frame;
            normal = of_orbit;
            reference = combined(&normal, &[first, cross(&third, &first), third]);
        }
        let [cosine, sine2] = tilt(&start.unit, &reference);
        let limit = Tilt::limit(start.limit);
        if cosine < limit[0] || sine2 > limit[1] {
            rows[EXIT_TIME] = 0.0;
        }
        (rows[Tilt::COSINE], rows[Tilt::SINE2]) = (cosine, sine2);
        rows[Tilt::AXIS..Tilt::AXIS + 3].copy_from_slice(&start.unit);
        rows[Tilt::LIMIT..Tilt::LIMIT + 2].copy_from_slice(&limit);
        rows[Tilt::NORMAL..Tilt::NORMAL + 3].copy_from_slice(&normal);
        rows
    }

    /// The largest tilt.
    fn outcome(rows: &Rows<f64>) -> f64 {
        largest_tilt(rows[Tilt::COSINE], rows[Tilt::SINE2])
    }
}

impl<R: Real, M: Model<R>, L: Layout, const D: usize> Update<R, M, L, D> for Tilt {
    /// True if the layout contains a direction in body components.
    const FITS: bool = !L::QUATERNION && !L::TANGENT && L::VECTORS > 0;

    /// Steps of a Taylor series are long, so the largest tilt inside the step and the time at which the limit is
    /// reached are computed from the coefficients of the series.
    #[inline(always)]
    fn after_step<S: Engine<R, M, L, D>>(
        engine: &S,
        p: &Parameters<R>,
        rows: &mut Rows<R>,
        segment: &Segment<R, D>,
    ) {
        let &Segment { begin: time, before, after, .. } = segment;
        let axis = three(rows, Tilt::AXIS);
        let limit = [rows[Tilt::LIMIT], rows[Tilt::LIMIT + 1]];
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let reference = Reference::<R, L>::of_rows(rows);
        let at_end = reference.of(after);
        let [mut cosine, mut sine2] = tilt(&axis, &at_end);
        let mut fraction = one;
        if const { S::IS_SERIES } {
            let begin_slope = along(&axis, &reference.of(segment.dense.order(1)));
            let end_slope = along(&axis, &direction_rate(&at_end, &engine.turning(after))) * p.step;
            // The cosine has a minimum inside the step.
            let has_minimum = R::select(zero.lt(end_slope), begin_slope, zero).lt(zero);
            if R::any(has_minimum) {
                let dense = segment.dense;
                let minimum = turning_point(dense, reference, &axis, [begin_slope, end_slope]);
                let (n, _) = interpolate(dense, reference, minimum);
                let [cosine_there, sine2_there] = tilt(&axis, &n);
                fraction = R::select(has_minimum, minimum, fraction);
                cosine = R::select(has_minimum, cosine_there, cosine);
                sine2 = R::select(has_minimum, sine2_there, sine2);
            }
        }
        rows[Tilt::COSINE] = rows[Tilt::COSINE].min(cosine);
        rows[Tilt::SINE2] = rows[Tilt::SINE2].max(sine2);
        let end = margin(&limit, [cosine, sine2]);
        let exceeded = R::select(rows[EXIT_TIME].lt(R::splat(f64::INFINITY)), zero, end).lt(zero);
        if R::any(exceeded) {
            let begin = tilt(&axis, &reference.of(before));
            // The time is the begin of the step if the limit was exceeded there.
            let begin = margin(&limit, begin).max(zero);
            let fraction = if const { S::IS_SERIES } {
                crossing(segment.dense, reference, &axis, &limit, [begin, end], fraction)
            } else {
                // Linear interpolation.
                begin / (begin - end)
            };
            let at = p.step.fma(fraction, time);
            rows[EXIT_TIME] = R::select(exceeded, at, rows[EXIT_TIME]);
        }
    }
}

/// Fraction of a step at which the limit is reached. `inner`, the margin at the begin, is not negative; `outer`, the
/// margin at `last`, is negative. Regula falsi with half the margin of an end that remains twice (the Illinois rule;
/// Dowell & Jarratt 1971, doi 10.1007/BF01934364).
#[inline(always)]
fn crossing<R: Real, const D: usize>(
    dense: &Coefficients<R, D>,
    reference: impl Part<R>,
    axis: &[R; 3],
    limit: &[R; 2],
    [mut inner, mut outer]: [R; 2],
    last: R,
) -> R {
    let (zero, half, one) = (R::splat(0.0), R::splat(0.5), R::splat(1.0));
    let (mut low, mut high) = (zero, last);
    let mut last_side = zero;
    for _ in 0..16 {
        let fraction = (high - low).fma(inner / (inner - outer), low);
        let (n, _) = interpolate(dense, reference, fraction);
        let margin = margin(limit, tilt(axis, &n));
        let beyond = margin.lt(zero);
        let side = R::select(beyond, one, -one);
        let weight = R::select(zero.lt(side * last_side), half, one);
        last_side = side;
        (low, high) = (R::select(beyond, low, fraction), R::select(beyond, fraction, high));
        (inner, outer) =
            (R::select(beyond, inner * weight, margin), R::select(beyond, margin, outer * weight));
    }
    (high - low).fma(inner / (inner - outer), low)
}

/// Cosine and squared sine of the angle between a body axis and a direction in body components.
#[inline(always)]
fn tilt<R: Real>(axis: &[R; 3], n: &[R; 3]) -> [R; 2] {
    let sine = cross(axis, n);
    [along(axis, n), dot(&sine, &sine)]
}

/// Distance of a tilt from its limit; negative beyond the limit.
#[inline(always)]
fn margin<R: Real>(limit: &[R; 2], [cosine, sine2]: [R; 2]) -> R {
    (cosine - limit[0]).min(limit[1] - sine2)
}

/// The largest tilt, from the smallest cosine and the largest squared sine: the sine is accurate for small
/// angles, the cosine determines the quadrant.
pub fn largest_tilt(cosine: f64, sine2: f64) -> f64 {
    if cosine > 0.5 {
        atan2(sine2.sqrt(), (1.0 - sine2).max(0.0).sqrt())
    } else {
        let cosine = cosine.clamp(-1.0, 1.0);
        atan2(((1.0 - cosine) * (1.0 + cosine)).sqrt(), cosine)
    }
}
