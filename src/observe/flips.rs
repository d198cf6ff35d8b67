//! Sign changes of a component of the rates.

use super::inside::{Bracket, Inside, has_minimum, least, lowest};
use super::{EXIT_TIME, Observable, Rows, Segment, Start, Update, look_inside, motion_inside, three};
use crate::body::{Body, VERTICAL};
use crate::forces::{BodyForces, ForcesInterval};
use crate::kinematics::{dot, put, to_body_frame};
use crate::method::{Coefficients, Engine, Numbers, Rk4Tableau, RungeKutta, Taylor};
use crate::real::{Outlined, Real};
use crate::scene::{FurtherFrame, Layout, Model, Parameters, StatesTurns, Top};
use crate::simd::Isa;

/// Sign changes of one component of the rates, located inside the step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flips;

impl Flips {
    /// +1 or -1: the sign of the component after the last step.
    pub const SIGN: usize = 1;
    /// Sign changes.
    pub const COUNT: usize = 2;
    /// The observed body axis: a unit vector along a principal axis, in either direction.
    pub const AXIS: usize = 3;
}

/// A component of the rates inside a step.
struct Component<'a, R, const D: usize> {
    dense: &'a Coefficients<R, D>,
    axis: [R; 3],
    sign: R,
}

impl<R: Real, const D: usize> Inside<R> for Component<'_, R, D> {
    #[inline(always)]
    fn at(&self, fraction: R) -> R {
        let mut sum = R::splat(0.0);
        for row in self.dense.all().iter().rev() {
            sum = sum.fma(fraction, dot(&self.axis, &[row[0], row[1], row[2]]));
        }
        sum * self.sign
    }
}

/// The rates of a body after a short time, in which it turns by 1e-3 rad at the rate `rate`. They follow from a Taylor
/// series, because the first derivatives may vanish too (a top released at rest); of the torque of a function from a
/// Runge-Kutta step.
struct AfterStart<'a> {
    body: &'a Body,
    interval: &'a ForcesInterval<'a, f64>,
    states: &'a [f64],
    rate: f64,
}

impl Outlined for AfterStart<'_> {
    type Out = [f64; 3];
    #[inline(always)]
    fn run(self) -> [f64; 3] {
        const NUMBERS: &Numbers = &Numbers { order: 6, ..Numbers::NONE };
        let AfterStart { body, interval, states, rate } = self;
        // SAFETY: the engines end with this call, during which `interval` is borrowed.
        let interval = unsafe { &interval.outliving() };
        let p = Parameters { moments: body.moments, weight: body.weight, step: 1e-3 / rate };
        if interval.functions.is_some() {
            // Nobody knows the derivatives of the torque of a function: a step of the fourth order is made.
            let engine = <Called as Engine<_, _, StatesTurns, CALLED>>::new(&p, interval, NUMBERS);
            let mut y = [0.0; CALLED];
            y[..3].copy_from_slice(&body.omega);
            y[StatesTurns::QUATERNION_AT..StatesTurns::BALANCE_AT].copy_from_slice(&body.attitude);
            y[StatesTurns::OWN_AT..StatesTurns::STATES_AT].copy_from_slice(&interval.further.start(0.0));
            y[StatesTurns::STATES_AT..].copy_from_slice(states);
            Engine::<_, _, StatesTurns, CALLED>::step(&engine, &p, &mut y);
            return [y[0], y[1], y[2]];
        }
        let series = <Taylor<f64, Top<f64>> as Engine<_, _, FurtherFrame, LEN>>::new(&p, interval, NUMBERS);
        let mut y = start::<LEN>(body);
        y[FurtherFrame::OWN_AT..].copy_from_slice(&interval.further.start(0.0));
        let mut terms = Coefficients::new();
        series.coefficients::<FurtherFrame, LEN>(p.step, &y, &mut terms);
        let mut rates = [0.0; 3];
        for term in terms.all() {
            for k in 0..3 {
                rates[k] += term[k];
            }
        }
        rates
    }
}

const LEN: usize = FurtherFrame::LEN;
const CALLED: usize = StatesTurns::LEN;
type Called = RungeKutta<Rk4Tableau, f64, Top<f64>>;

/// The state of a body at its start in a layout with all space axes: the rates, and the axes 3, 1 and 2.
fn start<const D: usize>(body: &Body) -> [f64; D] {
    let mut y = [0.0; D];
    y[..3].copy_from_slice(&body.omega);
    for (v, axis) in [VERTICAL, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].iter().enumerate() {
        y[3 + 3 * v..][..3].copy_from_slice(&to_body_frame(&body.attitude, axis));
    }
    y
}

fn rates_after_start(start: &Start, interval: &ForcesInterval<f64>, rate: f64) -> [f64; 3] {
    let Start { body, states, .. } = *start;
    Isa::widest().call_with_fma(AfterStart { body, interval, states, rate })
}

impl Observable for Flips {
    const ROWS: usize = 6;
    const CHANGING: usize = 3;

    /// The sign of the component at the start; for a component that is zero, the sign just after the start.
    fn start(self, start: &Start) -> Rows<f64> {
        let mut rows = super::UNOBSERVED;
        let k = start.axis.unsigned_abs() as usize - 1;
        let value = match (start.body.omega[k], start.forces) {
            (0.0, Some((interval, rate))) => rates_after_start(start, interval, rate)[k],
            (0.0, None) => {
                let rate = start.body.fastest_rate(BodyForces::NONE, [0.0; 2]);
                rates_after_start(start, &ForcesInterval::none(), rate)[k]
            }
            (omega, _) => omega,
        };
        rows[Flips::SIGN] = f64::from(start.axis.signum()) * if value < 0.0 { -1.0 } else { 1.0 };
        put(&mut rows, Flips::AXIS, start.unit);
        rows
    }

    /// The number of sign changes.
    fn outcome(rows: &Rows<f64>) -> f64 {
        rows[Flips::COUNT]
    }
}

impl<R: Real, M: Model<R>, L: Layout, const D: usize> Update<R, M, L, D> for Flips {
    /// True for the rates of the body in the layout that contains only variables that the rates need.
    const FITS: bool =
        L::CLOCK || !L::TANGENT && (L::BALANCE || !L::QUATERNION && L::VECTORS == M::HEAVY as usize);

    #[inline(always)]
    fn after_step<S: Engine<R, M, L, D>>(self, rows: &mut Rows<R>, segment: &Segment<R, S, D>) {
        let &Segment { engine, p, .. } = segment;
        let axis = three(rows, Flips::AXIS);
        let ends = Flips::at_ends(rows, segment);
        let mut sought = ends[1];
        if const { S::IS_LONG } {
            let signed = p.step * rows[Flips::SIGN];
            let slopes = [
                dot(&axis, &engine.velocity(p, segment.before)) * signed,
                dot(&axis, &engine.velocity(p, segment.after)) * signed,
            ];
            sought = sought.min(R::select(has_minimum(slopes), lowest(ends, slopes), R::splat(0.0)));
        }
        look_inside::<_, R, M, L, S, D>(self, rows, segment, sought.lt(R::splat(0.0)));
    }

    /// One flip where the component ends with the other sign, two where it has the other sign between; the first is
    /// found. An exact zero keeps the sign before it.
    #[inline(always)]
    fn look<S: Engine<R, M, L, D>>(self, rows: &mut Rows<R>, segment: &Segment<R, S, D>) {
        let (zero, half, one) = (R::splat(0.0), R::splat(0.5), R::splat(1.0));
        let (axis, sign) = (three(rows, Flips::AXIS), rows[Flips::SIGN]);
        let [begin, end] = Flips::at_ends(rows, segment);
        let dense = &motion_inside(segment);
        let inside = Component { dense, axis, sign };
        let flipped = end.lt(zero);
        let [lowest_at, lowest] = least::<R, 6>(&inside, [zero, one], half, half * half);
        let (last, last_value) = (R::select(flipped, one, lowest_at), R::select(flipped, end, lowest));
        // A body that begins with a rate of zero moves away from zero first: the flip is after its largest rate.
        let mut first = [zero, begin];
        if !R::all(zero.lt(begin)) {
            let [highest_at, highest] = least::<R, 6>(
                &Component { sign: -sign, ..inside },
                [zero, last],
                last * half,
                last * R::splat(0.25),
            );
            let is_away = R::except(highest.lt(zero), zero.lt(begin));
            first = [R::select(is_away, highest_at, zero), R::select(is_away, -highest, begin.max(zero))];
        }
        let count = R::select(flipped, one, R::select(last_value.lt(zero), one + one, zero));
        let fraction = Bracket { from: first, to: [last, last_value] }.crossing(&inside);
        let at = segment.p.step.fma(fraction, segment.begin);
        let leaves = R::except(half.lt(count), rows[EXIT_TIME].lt(R::splat(f64::INFINITY)));
        rows[EXIT_TIME] = R::select(leaves, at, rows[EXIT_TIME]);
        rows[Flips::COUNT] = rows[Flips::COUNT] + count;
        rows[Flips::SIGN] = R::select(flipped, -sign, sign);
    }
}

impl Flips {
    /// The component at both ends of a step, with the sign before the step.
    #[inline(always)]
    fn at_ends<R: Real, S, const D: usize>(rows: &Rows<R>, segment: &Segment<R, S, D>) -> [R; 2] {
        let axis = three(rows, Flips::AXIS);
        let (before, after, sign) = (segment.before, segment.after, rows[Flips::SIGN]);
        let begin = dot(&axis, &[before[0], before[1], before[2]]);
        [begin * sign, dot(&axis, &[after[0], after[1], after[2]]) * sign]
    }
}
