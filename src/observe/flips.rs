//! Sign changes of a component of the rates.

use super::dense::{Bracket, Part, hermite_root, interpolate, newton, turning_point};
use super::{
    EXIT_TIME, Observable, Rows, Segment, Start, Update, along, first_time, look_inside, lowest_inside,
    motion_inside, three,
};
use crate::forces::{BodyForces, ForcesInterval};
use crate::kinematics::to_body_frame;
use crate::method::{Coefficients, Engine, Numbers, Rk4Tableau, RungeKutta, Taylor};
use crate::real::{Apart, Real};
use crate::scene::{FunctionTurns, FurtherFrame, Layout, Model, Parameters, Top};
use crate::simd::with_fma;
use crate::start::{Body, VERTICAL};

/// Sign changes of one component of the rates, located inside the step.
pub struct Flips;

impl Flips {
    /// +1 or -1: the sign of the component after the last step.
    pub const SIGN: usize = 1;
    /// Sign changes.
    pub const COUNT: usize = 2;
    /// The observed body axis: a unit vector along a principal axis, in either direction.
    pub const AXIS: usize = 3;

    /// Counts the flips of a step; with the motion inside it, flips are found where they are, and a pair too.
    #[inline(always)]
    fn flips<R: Real, M: Model<R>, L: Layout, S: Engine<R, M, L, D>, const IS_KNOWN: bool, const D: usize>(
        engine: &S,
        p: &Parameters<R>,
        rows: &mut Rows<R>,
        segment: &Segment<R, D>,
    ) {
        let &Segment { begin: time, before, after, .. } = segment;
        let axis = three(rows, Flips::AXIS);
        let sign = rows[Flips::SIGN];
        let zero = R::splat(0.0);
        let end = along(&axis, &[after[0], after[1], after[2]]);
        // An exact zero keeps the sign before the zero.
        let flipped = (end * sign).lt(zero);
        if R::any(flipped) {
            let begin = along(&axis, &[before[0], before[1], before[2]]);
            let begin_rate = along(&axis, &engine.velocity(p, before)) * p.step;
            let end_rate = along(&axis, &engine.velocity(p, after)) * p.step;
            let mut fraction = hermite_root(begin, begin_rate, end, end_rate);
            if const { IS_KNOWN } {
                let dense = segment.dense;
                // The cubic is wrong by at most a hundredth of the step; each Newton step squares this error.
                let mut bracket = Bracket::new(end);
                for _ in 0..3 {
                    let (omega, rate) = interpolate(dense, 0, fraction);
                    fraction = bracket.newton(fraction, along(&axis, &omega), along(&axis, &rate));
                }
            }
            let at = p.step.fma(fraction, time);
            rows[EXIT_TIME] = R::select(flipped, first_time(rows[EXIT_TIME], at), rows[EXIT_TIME]);
            rows[Flips::COUNT] = rows[Flips::COUNT] + R::select(flipped, R::splat(1.0), zero);
            rows[Flips::SIGN] = R::select(flipped, -sign, sign);
        }
        if const { IS_KNOWN } {
            Self::two_flips_in_a_step(engine, p, rows, segment);
        }
    }

    /// Two sign changes inside one long step: the component moves towards zero at the begin, away from zero at the end,
    /// and has the other sign between.
    #[inline(always)]
    fn two_flips_in_a_step<R: Real, M: Model<R>, L: Layout, S: Engine<R, M, L, D>, const D: usize>(
        engine: &S,
        p: &Parameters<R>,
        rows: &mut Rows<R>,
        segment: &Segment<R, D>,
    ) {
        let &Segment { begin: time, before, after, .. } = segment;
        let axis = three(rows, Flips::AXIS);
        let sign = rows[Flips::SIGN];
        let zero = R::splat(0.0);
        let begin_slope = along(&axis, &0usize.of(segment.dense.order(1))) * sign;
        let end_slope = along(&axis, &engine.velocity(p, after)) * p.step * sign;
        let has_minimum = R::select(zero.lt(end_slope), begin_slope, zero).lt(zero);
        if R::any(has_minimum) {
            let dense = segment.dense;
            let extremum = turning_point(dense, 0, &axis, [begin_slope, end_slope]);
            let (omega, _) = interpolate(dense, 0, extremum);
            let begin = along(&axis, &[before[0], before[1], before[2]]) * sign;
            let minimum = along(&axis, &omega) * sign;
            // A step that ends with the other sign contains one flip. `sign` is the new sign then, so `begin` is
            // negative.
            let twice = R::select(zero.lt(begin), R::select(has_minimum, minimum, zero), zero).lt(zero);
            if R::any(twice) {
                let mut fraction = extremum * (begin / (begin - minimum));
                for _ in 0..6 {
                    let (omega, rate) = interpolate(dense, 0, fraction);
                    let (value, slope) = (along(&axis, &omega), along(&axis, &rate));
                    // The first zero lies before the extremum.
                    fraction = newton(fraction, value, slope).min(extremum);
                }
                let at = p.step.fma(fraction, time);
                rows[EXIT_TIME] = R::select(twice, first_time(rows[EXIT_TIME], at), rows[EXIT_TIME]);
                rows[Flips::COUNT] = rows[Flips::COUNT] + R::select(twice, R::splat(2.0), zero);
            }
        }
    }
}

/// The rates of a body after a short time, in which it turns by 1e-3 rad at the rate `rate`. They follow from a Taylor
/// series, because the first derivatives may vanish too (a top released at rest); of the torque of a function from a
/// Runge-Kutta step.
struct AfterStart<'a> {
    body: &'a Body,
    interval: &'a ForcesInterval<'a, f64>,
    rate: f64,
    rates: &'a mut [f64; 3],
}

impl Apart for AfterStart<'_> {
    #[inline(always)]
    fn run(self) {
        const NUMBERS: &Numbers = &Numbers { order: 6, ..Numbers::NONE };
        let AfterStart { body, interval, rate, rates } = self;
        // SAFETY: the engines end with this call, during which `interval` is borrowed.
        let interval = unsafe { &interval.outliving() };
        let p = Parameters { moments: body.moments, weight: body.weight, step: 1e-3 / rate };
        if interval.functions.is_some() {
            // Nobody knows the derivatives of the torque of a function: a step of the fourth order is made.
            let engine = <Called as Engine<_, _, FunctionTurns, CALLED>>::new(&p, interval, NUMBERS);
            let (mut y, mut unused) = ([0.0; CALLED], [0.0; CALLED]);
            y[..3].copy_from_slice(&body.omega);
            y[FunctionTurns::QUATERNION_AT..FunctionTurns::BALANCE_AT].copy_from_slice(&body.attitude);
            y[FunctionTurns::OWN_AT..].copy_from_slice(&interval.further.start(0.0));
            let dense = &mut Coefficients::new();
            Engine::<_, _, FunctionTurns, CALLED>::step(&engine, &p, &mut y, &mut unused, dense);
            rates.copy_from_slice(&y[..3]);
            return;
        }
        let series = <Taylor<f64, Top<f64>> as Engine<_, _, FurtherFrame, LEN>>::new(&p, interval, NUMBERS);
        let mut y = start::<LEN>(body);
        y[FurtherFrame::OWN_AT..].copy_from_slice(&interval.further.start(0.0));
        let mut terms = Coefficients::new();
        series.coefficients::<FurtherFrame, LEN>(p.step, &y, &mut terms);
        for term in terms.all() {
            for k in 0..3 {
                rates[k] += term[k];
            }
        }
    }
}

const LEN: usize = FurtherFrame::LEN;
const CALLED: usize = FunctionTurns::LEN;
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

fn rates_after_start(body: &Body, interval: &ForcesInterval<f64>, rate: f64) -> [f64; 3] {
    let mut rates = [0.0; 3];
    with_fma(AfterStart { body, interval, rate, rates: &mut rates });
    rates
}

impl Observable for Flips {
    const ROWS: usize = 6;
    const CHANGING: usize = 3;

    /// The sign of the component at the start; for a component that is zero, the sign just after the start.
    fn start(start: &Start) -> Rows<f64> {
        let mut rows = super::UNOBSERVED;
        let k = start.axis.unsigned_abs() as usize - 1;
        let value = match (start.body.omega[k], start.forces) {
            (0.0, Some((interval, rate))) => rates_after_start(start.body, interval, rate)[k],
            (0.0, None) => {
                let rate = start.body.fastest_rate(BodyForces::NONE, [0.0; 2]);
                rates_after_start(start.body, &ForcesInterval::none(), rate)[k]
            }
            (omega, _) => omega,
        };
        rows[Flips::SIGN] = f64::from(start.axis.signum()) * if value < 0.0 { -1.0 } else { 1.0 };
        rows[Flips::AXIS..Flips::AXIS + 3].copy_from_slice(&start.unit);
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
    fn after_step<S: Engine<R, M, L, D>>(
        engine: &S,
        p: &Parameters<R>,
        rows: &mut Rows<R>,
        segment: &Segment<R, D>,
    ) {
        if const { L::CLOCK } {
            // The rates over the pace of the anomaly have the signs of the rates.
            let axis = three(rows, Flips::AXIS);
            let &Segment { before, after, .. } = segment;
            let sign = rows[Flips::SIGN];
            let values = [
                along(&axis, &[before[0], before[1], before[2]]) * sign,
                along(&axis, &[after[0], after[1], after[2]]) * sign,
            ];
            let pace = p.step * sign;
            let slopes = [
                along(&axis, &engine.velocity(p, before)) * pace,
                along(&axis, &engine.velocity(p, after)) * pace,
            ];
            let wanted = lowest_inside(values, slopes).lt(R::splat(0.0));
            look_inside::<Flips, R, M, L, S, D>(engine, p, rows, segment, wanted);
        } else if const { S::IS_SERIES } {
            Self::flips::<R, M, L, S, true, D>(engine, p, rows, segment);
        } else {
            Self::flips::<R, M, L, S, false, D>(engine, p, rows, segment);
        }
    }

    #[inline(always)]
    fn look<S: Engine<R, M, L, D>>(
        engine: &S,
        p: &Parameters<R>,
        rows: &mut Rows<R>,
        segment: &Segment<R, D>,
    ) {
        let dense = motion_inside(engine, p, segment.before);
        Self::flips::<R, M, L, S, true, D>(engine, p, rows, &Segment { dense: &dense, ..*segment });
    }
}
