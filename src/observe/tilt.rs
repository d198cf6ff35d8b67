//! The angle between a body axis and a direction in space.

use super::inside::{Bracket, Inside, has_minimum, least, lowest, state};
use super::{
    Bound, Direction, EXIT_TIME, Observable, Quantity, Rows, Segment, Start, Update, angle_of, chord2,
    chord2_of, combined, look_inside, motion_inside, three,
};
use crate::kinematics::{add_cross, cross, direction, direction_rate, dot, half_rows, plus, put, space_axes};
use crate::method::{Coefficients, Engine};
use crate::real::Real;
use crate::scene::{Layout, Model, Parameters, quaternion};
use std::marker::PhantomData;

/// Largest angle between a body axis and a direction that is fixed in space: `Layout::OBSERVED`, or the normal of an orbit.
/// Of a body that is integrated over the anomaly of its orbit, from any direction of the frame of the orbit. The angle is
/// observed as the square of the chord, which is accurate for small angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tilt {
    /// The largest allowed angle.
    limit: f64,
    /// The direction of the frame of the orbit.
    from: Direction,
    /// Of the end of the axis that is nearer to this direction at the start.
    either: bool,
}

impl Tilt {
    /// The tilt with this largest allowed angle; in the frame of an orbit from its normal.
    pub const fn within(limit: f64) -> Tilt {
        Tilt { limit, from: Direction::Normal, either: false }
    }

    /// The tilt that a bound of the pointing is in the frame of the orbit; `None` for a bound of something else.
    pub fn of(bound: Bound) -> Option<Tilt> {
        let Bound { quantity: Quantity::Pointing { from, either }, limit, .. } = bound else { return None };
        Some(Tilt { limit, from, either })
    }

    /// The square of the largest chord.
    const CHORD2: usize = 1;
    /// The limit of that; infinite for none.
    const LIMIT: usize = 2;
    /// The observed body axis: a unit vector along a principal axis, in either direction.
    const AXIS: usize = 3;
    /// The direction in space, where it follows from a frame: the normal of an orbit, else that at the start. Over an
    /// anomaly the direction in the frame of the orbit.
    const NORMAL: usize = 6;
}

impl Observable for Tilt {
    const ROWS: usize = 9;
    const CHANGING: usize = 2;

    fn start(self, start: &Start) -> Rows<f64> {
        let mut rows = super::UNOBSERVED;
        let (mut normal, mut reference) = ([0.0, 0.0, 1.0], start.direction);
        let [third, first] = start.frame;
        if start.on_orbit.is_none() && reference != third {
            normal = [&first, &cross(&third, &first), &third].map(|axis| dot(axis, &reference));
        }
        let mut axis = start.unit;
        if let Some((_, axes)) = start.on_orbit {
            let column = self.from as usize;
            normal = [0, 1, 2].map(|k| f64::from(u8::from(k == column)));
            reference = axes[column];
            if self.either && dot(&axis, &reference) < 0.0 {
                axis = axis.map(|x| -x);
            }
        } else if let Some(of_orbit) = start.forces.and_then(|(forces, _)| forces.further.orbit.normal()) {
            normal = of_orbit;
            reference = combined(&normal, &[first, cross(&third, &first), third]);
        }
        rows[Tilt::CHORD2] = chord2(&axis, &reference);
        rows[Tilt::LIMIT] = chord2_of(self.limit);
        if rows[Tilt::CHORD2] > rows[Tilt::LIMIT] {
            rows[EXIT_TIME] = 0.0;
        }
        put(&mut rows, Tilt::AXIS, axis);
        put(&mut rows, Tilt::NORMAL, normal);
        rows
    }

    /// The largest tilt.
    fn outcome(rows: &Rows<f64>) -> f64 {
        angle_of(rows[Tilt::CHORD2])
    }
}

impl<R: Real, M: Model<R>, L: Layout, const D: usize> Update<R, M, L, D> for Tilt {
    /// True if the layout contains a direction in body components.
    const FITS: bool = L::CLOCK || !L::TANGENT && (L::TURNS || !L::QUATERNION && L::VECTORS > 0);

    #[inline(always)]
    fn after_step<S: Engine<R, M, L, D>>(self, rows: &mut Rows<R>, segment: &Segment<R, S, D>) {
        let &Segment { engine, p, .. } = segment;
        let axis = three(rows, Tilt::AXIS);
        let at_end = of_state::<R, L, D>(rows, segment.after);
        let end = chord2(&axis, &at_end);
        let largest = rows[Tilt::CHORD2].max(end);
        rows[Tilt::CHORD2] = largest;
        // Negative where the limit is passed for the first time, or where the tilt inside the step may be the largest.
        let has_left = rows[EXIT_TIME].lt(R::splat(f64::INFINITY));
        let mut sought = R::select(has_left, R::splat(0.0), rows[Tilt::LIMIT] - end);
        if const { S::IS_LONG } {
            let at_begin = of_state::<R, L, D>(rows, segment.before);
            let begin = chord2(&axis, &at_begin);
            let twice = p.step + p.step;
            let slopes = [
                dot(&axis, &direction_rate(&at_begin, &engine.turning(p, segment.before))) * twice,
                dot(&axis, &direction_rate(&at_end, &engine.turning(p, segment.after))) * twice,
            ];
            let spare = largest + lowest([-begin, -end], slopes);
            sought = sought.min(R::select(has_minimum(slopes), spare, R::splat(0.0)));
        }
        look_inside::<_, R, M, L, S, D>(self, rows, segment, sought.lt(R::splat(0.0)));
    }

    #[inline(always)]
    fn look<S: Engine<R, M, L, D>>(self, rows: &mut Rows<R>, segment: &Segment<R, S, D>) {
        let (zero, half, one) = (R::splat(0.0), R::splat(0.5), R::splat(1.0));
        let &Segment { engine, p, .. } = segment;
        let axis = three(rows, Tilt::AXIS);
        let ends = [Path::of(engine, p, rows, segment.before), Path::of(engine, p, rows, segment.after)];
        let inside = Quintic::between(&axis, &ends);
        let [begin, end] = [-chord2(&axis, &ends[0].direction), -chord2(&axis, &ends[1].direction)];
        let [first, second] = [dot(&axis, &ends[0].slope), dot(&axis, &ends[1].slope)];
        let slopes = [first + first, second + second];
        let is_inside = has_minimum(slopes);
        let near = R::select(is_inside, slopes[0] / (slopes[0] - slopes[1]), half);
        // The chord of the slopes meets zero within a tenth of the step of the minimum, and the value is flat there.
        let [place, value] = least::<R, 3>(&inside, [zero, one], near, R::splat(0.125));
        let is_deeper = R::both(is_inside, value.lt(end));
        let (last, least) = (R::select(is_deeper, place, one), R::select(is_deeper, value, end));
        rows[Tilt::CHORD2] = rows[Tilt::CHORD2].max(-least);
        let limit = rows[Tilt::LIMIT];
        let margin = R::select(rows[EXIT_TIME].lt(R::splat(f64::INFINITY)), zero, limit + least);
        let exceeded = margin.lt(zero);
        if R::any(exceeded) {
            // The time is the begin of the step if the limit was exceeded there.
            let bracket = Bracket { from: [zero, (limit + begin).max(zero)], to: [last, margin] };
            let dense = &motion_inside(segment);
            let below = Below::<R, L, D> { dense, rows: &*rows, layout: PhantomData };
            let at = p.step.fma(bracket.crossing(&below), segment.begin);
            rows[EXIT_TIME] = R::select(exceeded, at, rows[EXIT_TIME]);
        }
    }
}

/// The direction from which the tilt is measured, in the body.
#[inline(always)]
fn of_state<R: Real, L: Layout, const D: usize>(rows: &Rows<R>, y: &[R; D]) -> [R; 3] {
    let normal = three(rows, Tilt::NORMAL);
    if const { L::CLOCK } {
        let half = combined(&normal, &half_rows(&[y[3], y[4], y[5], y[6]]));
        return plus(&half, &half);
    }
    if const { L::TURNS } {
        let [third, first, second] = space_axes(&quaternion::<L, R, D>(y));
        return combined(&normal, &[first, second, third]);
    }
    direction(y, L::OBSERVED)
}

/// The direction at one end of a step, with its first and second derivatives, times the step and half of its square.
struct Path<R> {
    direction: [R; 3],
    slope: [R; 3],
    bend: [R; 3],
}

impl<R: Real> Path<R> {
    #[inline(always)]
    fn of<M: Model<R>, L: Layout, S: Engine<R, M, L, D>, const D: usize>(
        engine: &S,
        p: &Parameters<R>,
        rows: &Rows<R>,
        y: &[R; D],
    ) -> Path<R> {
        let (turning, half) = (engine.turning(p, y), p.step * (p.step * R::splat(0.5)));
        let direction = of_state::<R, L, D>(rows, y);
        let mut slope = direction_rate(&direction, &turning);
        let mut bend = direction_rate(&slope, &turning);
        add_cross(&direction, &engine.turning_rate(p, y), &mut bend);
        for k in 0..3 {
            (slope[k], bend[k]) = (slope[k] * p.step, bend[k] * half);
        }
        Path { direction, slope, bend }
    }
}

/// The square of the chord inside a step, negated: by the polynomial with values, slopes and bends at both ends. In a step
/// of s rad it errs by `s^6 / 46080`: of 0.75 rad, which the fastest bodies make, 4e-6, of half of it 6e-8.
struct Quintic<R> {
    axis: [R; 3],
    terms: [[R; 3]; 6],
}

impl<R: Real> Quintic<R> {
    #[inline(always)]
    fn between(axis: &[R; 3], [begin, end]: &[Path<R>; 2]) -> Self {
        let mut terms = [[R::splat(0.0); 3]; 6];
        for k in 0..3 {
            let (d0, d1, b0) = (begin.slope[k], end.slope[k], begin.bend[k]);
            let a = ((end.direction[k] - begin.direction[k]) - d0) - b0;
            let b = (d1 - d0) - (b0 + b0);
            let c = end.bend[k] - b0;
            let all = [
                begin.direction[k],
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
        Quintic { axis: *axis, terms }
    }
}

impl<R: Real> Inside<R> for Quintic<R> {
    #[inline(always)]
    fn at(&self, fraction: R) -> R {
        let mut n = self.terms[5];
        for term in self.terms[..5].iter().rev() {
            for k in 0..3 {
                n[k] = n[k].fma(fraction, term[k]);
            }
        }
        -chord2(&self.axis, &n)
    }
}

/// How far the square of the chord is below its limit inside a step, by the motion there.
struct Below<'a, R, L, const D: usize> {
    dense: &'a Coefficients<R, D>,
    rows: &'a Rows<R>,
    layout: PhantomData<L>,
}

impl<R: Real, L: Layout, const D: usize> Inside<R> for Below<'_, R, L, D> {
    #[inline(always)]
    fn at(&self, fraction: R) -> R {
        let direction = of_state::<R, L, D>(self.rows, &state(self.dense, fraction));
        self.rows[Tilt::LIMIT] - chord2(&three(self.rows, Tilt::AXIS), &direction)
    }
}
