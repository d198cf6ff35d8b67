//! The tilt of a body axis.

use super::dense::{Part, interpolate, turning_point};
use super::{
    Bound, EXIT_TIME, Observable, Quantity, Rows, Segment, Start, Update, along, look_inside, lowest_inside,
    three,
};
use crate::kinematics::{add_cross, cross, direction, direction_rate, dot, half_rows, space_axes};
use crate::method::{Coefficients, Engine};
use crate::real::Real;
use crate::scene::{Layout, Model, Parameters, quaternion};
use crate::special::{atan2, sincos};
use std::f64::consts::PI;
use std::marker::PhantomData;

/// Largest angle between a body axis and a direction that is fixed in space: `Layout::OBSERVED`, or the normal of an orbit.
/// Of a body that is integrated over the anomaly of its orbit, from any direction of the frame of the orbit.
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
        if L::TURNS {
            let [third, first, second] = space_axes(&quaternion::<L, R, D>(state));
            return combined(&self.normal, &[first, second, third]);
        }
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
    /// The direction in space, where it follows from a frame: the normal of an orbit, else that at the start. Over an
    /// anomaly the direction in the frame of the orbit.
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
        let [third, first] = start.frame;
        if start.on_orbit.is_none() && reference != third {
            normal = [&first, &cross(&third, &first), &third].map(|axis| dot(axis, &reference));
        }
        let (mut axis, mut limit) = (start.unit, start.limit);
        if let Some((_, axes)) = start.on_orbit {
            reference = axes[2];
            if let Some(Bound { quantity: Quantity::Pointing { from, either }, limit: largest, .. }) =
                start.bound
            {
                let column = *from as usize;
                normal = [0, 1, 2].map(|k| f64::from(u8::from(k == column)));
                reference = axes[column];
                if *either && dot(&axis, &reference) < 0.0 {
                    axis = axis.map(|x| -x);
                }
                // No angle is larger.
                limit = if *largest >= PI { f64::INFINITY } else { *largest };
            }
        } else if let Some(of_orbit) = start.forces.and_then(|(forces, _)| forces.further.orbit.normal()) {
            normal = of_orbit;
            reference = combined(&normal, &[first, cross(&third, &first), third]);
        }
        let [cosine, sine2] = tilt(&axis, &reference);
        let limit = Tilt::limit(limit);
        if cosine < limit[0] || sine2 > limit[1] {
            rows[EXIT_TIME] = 0.0;
        }
        (rows[Tilt::COSINE], rows[Tilt::SINE2]) = (cosine, sine2);
        rows[Tilt::AXIS..Tilt::AXIS + 3].copy_from_slice(&axis);
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
    const FITS: bool = L::CLOCK || !L::TANGENT && (L::TURNS || !L::QUATERNION && L::VECTORS > 0);

    /// Steps of a Taylor series are long, so the largest tilt inside the step and the time at which the limit is
    /// reached are computed from the coefficients of the series.
    #[inline(always)]
    fn after_step<S: Engine<R, M, L, D>>(
        engine: &S,
        p: &Parameters<R>,
        rows: &mut Rows<R>,
        segment: &Segment<R, D>,
    ) {
        let &Segment { begin: time, before, after, dense } = segment;
        let axis = three(rows, Tilt::AXIS);
        if const { L::CLOCK } {
            let [begin, end] = [Path::of(engine, rows, before), Path::of(engine, rows, after)];
            let values = [along(&axis, &begin.direction), along(&axis, &end.direction)];
            let slopes = [along(&axis, &begin.rate()) * p.step, along(&axis, &end.rate()) * p.step];
            // A cosine knows no smaller angle than 1e-7 rad from the one that is least so far.
            let lowest = lowest_inside(values, slopes) - R::splat(1e-14);
            look_inside::<Tilt, R, M, L, S, D>(engine, p, rows, segment, lowest.lt(rows[Tilt::COSINE]));
            return;
        }
        let reference = Reference::<R, L>::of_rows(rows);
        let ends = [reference.of(before), reference.of(after)];
        if const { S::IS_SERIES } {
            let slopes = [
                along(&axis, &reference.of(dense.order(1))),
                along(&axis, &direction_rate(&ends[1], &engine.turning(after))) * p.step,
            ];
            Tilt::see::<R, true, D>(p, rows, time, ends, slopes, (dense, reference));
        } else {
            Tilt::see::<R, false, D>(p, rows, time, ends, [R::splat(0.0); 2], (dense, reference));
        }
    }

    #[inline(always)]
    fn look<S: Engine<R, M, L, D>>(
        engine: &S,
        p: &Parameters<R>,
        rows: &mut Rows<R>,
        segment: &Segment<R, D>,
    ) {
        let &Segment { begin: time, before, after, .. } = segment;
        let axis = three(rows, Tilt::AXIS);
        let [begin, end] = [Path::of(engine, rows, before), Path::of(engine, rows, after)];
        let slopes = [along(&axis, &begin.rate()) * p.step, along(&axis, &end.rate()) * p.step];
        let bends = [begin.bend(engine, p, before), end.bend(engine, p, after)];
        let ends = [begin.direction, end.direction];
        let [first, last] = [begin.rate(), end.rate()];
        // The polynomial with values, slopes and bends at both ends. In a step of 1 rad it errs by 2e-5.
        let mut dense = Coefficients::new();
        let mut terms = [[R::splat(0.0); D]; 6];
        for k in 0..3 {
            let (d0, d1) = (first[k] * p.step, last[k] * p.step);
            let half = R::splat(0.5) * (p.step * p.step);
            let (b0, b1) = (bends[0][k] * half, bends[1][k] * half);
            let a = ((ends[1][k] - ends[0][k]) - d0) - b0;
            let b = (d1 - d0) - (b0 + b0);
            let c = b1 - b0;
            let all = [
                ends[0][k],
                d0,
                b0,
                R::splat(10.0).fma(a, R::splat(4.0).fnma(b, c)),
                R::splat(15.0).fnma(a, R::splat(2.0).fnma(c, R::splat(7.0) * b)),
                R::splat(6.0).fma(a, R::splat(3.0).fnma(b, c)),
            ];
            for j in 0..6 {
                terms[j][k] = all[j];
            }
        }
        for term in terms {
            dense.push(term);
        }
        Tilt::see::<R, true, D>(p, rows, time, ends, slopes, (&dense, 0_usize));
    }
}

/// A direction of the frame of an orbit, in the body.
struct Path<R> {
    direction: [R; 3],
    /// The rates of the body against the frame.
    turning: [R; 3],
}

impl<R: Real> Path<R> {
    /// That of the rows, at a state.
    #[inline(always)]
    fn of<M: Model<R>, L: Layout, S: Engine<R, M, L, D>, const D: usize>(
        engine: &S,
        rows: &Rows<R>,
        y: &[R; D],
    ) -> Path<R> {
        let half = combined(&three(rows, Tilt::NORMAL), &half_rows(&[y[3], y[4], y[5], y[6]]));
        let direction = [half[0] + half[0], half[1] + half[1], half[2] + half[2]];
        Path { direction, turning: engine.turning(y) }
    }

    /// Its rate of change.
    #[inline(always)]
    fn rate(&self) -> [R; 3] {
        direction_rate(&self.direction, &self.turning)
    }

    /// The rate of change of that. The frame turns about the normal: its rate in the body is the difference w of the
    /// rates and of those against it, `w' = -e sin E / r w + w x turning`.
    #[inline(always)]
    fn bend<M: Model<R>, L: Layout, S: Engine<R, M, L, D>, const D: usize>(
        &self,
        engine: &S,
        p: &Parameters<R>,
        y: &[R; D],
    ) -> [R; 3] {
        let Path { direction, turning } = self;
        let frame = [y[0] - turning[0], y[1] - turning[1], y[2] - turning[2]];
        let slower = y[8] / (R::splat(1.0) - y[7]);
        let (turned, mut change) = (cross(&frame, turning), engine.velocity(p, y));
        for k in 0..3 {
            change[k] = (slower.fma(frame[k], change[k])) - turned[k];
        }
        let mut bend = direction_rate(&self.rate(), turning);
        add_cross(direction, &change, &mut bend);
        bend
    }
}

impl Tilt {
    /// Updates the rows by a step with these directions at its ends; with the slopes of the cosine there and the motion
    /// inside it, by the largest tilt inside.
    #[inline(always)]
    fn see<R: Real, const IS_KNOWN: bool, const D: usize>(
        p: &Parameters<R>,
        rows: &mut Rows<R>,
        time: R,
        [at_begin, at_end]: [[R; 3]; 2],
        [begin_slope, end_slope]: [R; 2],
        (dense, reference): (&Coefficients<R, D>, impl Part<R>),
    ) {
        let axis = three(rows, Tilt::AXIS);
        let limit = [rows[Tilt::LIMIT], rows[Tilt::LIMIT + 1]];
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let [mut cosine, mut sine2] = tilt(&axis, &at_end);
        let mut fraction = one;
        if const { IS_KNOWN } {
            // The cosine has a minimum inside the step.
            let has_minimum = R::select(zero.lt(end_slope), begin_slope, zero).lt(zero);
            if R::any(has_minimum) {
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
            let begin = tilt(&axis, &at_begin);
            // The time is the begin of the step if the limit was exceeded there.
            let begin = margin(&limit, begin).max(zero);
            let fraction = if const { IS_KNOWN } {
                crossing(dense, reference, &axis, &limit, [begin, end], fraction)
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
