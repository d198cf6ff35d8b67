//! Sign changes of a component of the rates.

use super::dense::{Bracket, Part, hermite_root, interpolate, newton, turning_point};
use super::{EXIT_TIME, Observable, Rows, Segment, Start, Update, along, first_time, three};
use crate::forcing::{BodyForcing, ForcingInterval};
use crate::real::Real;
use crate::scene::{Layout, Model, Parameters};
use crate::scheme::Stepper;
use crate::start::rates_after_start;

/// Sign changes of one component of the rates, located inside the step.
pub struct Flips;

impl Flips {
    /// +1 or -1: the sign of the component after the last step.
    pub const SIGN: usize = 1;
    /// Sign changes.
    pub const COUNT: usize = 2;
    /// The observed body axis: a unit vector along a principal axis, in either direction.
    pub const AXIS: usize = 3;

    /// Two sign changes inside one long step: the component moves towards zero at the begin, away from zero at the end,
    /// and has the other sign between.
    #[inline(always)]
    fn two_flips_in_a_step<R: Real, M: Model<R>, L: Layout, S: Stepper<R, M, L, D>, const D: usize>(
        stepper: &S,
        p: &Parameters<R>,
        rows: &mut Rows<R>,
        segment: &Segment<R, D>,
    ) {
        let &Segment { begin: time, before, after, .. } = segment;
        let axis = three(rows, Flips::AXIS);
        let sign = rows[Flips::SIGN];
        let zero = R::splat(0.0);
        let begin_slope = along(&axis, &0usize.of(segment.dense.order(1))) * sign;
        let end_slope = along(&axis, &stepper.velocity(p, after)) * p.step * sign;
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

impl Observable for Flips {
    const ROWS: usize = 6;
    const CHANGING: usize = 3;

    /// The sign of the component at the start; for a component that is zero, the sign just after the start.
    fn start(start: &Start) -> Rows<f64> {
        let mut rows = super::UNOBSERVED;
        let k = start.axis.unsigned_abs() as usize - 1;
        let value = match (start.body.omega[k], start.forcing) {
            (0.0, Some((interval, rate))) => rates_after_start(start.body, interval, rate)[k],
            (0.0, None) => {
                let rate = start.body.fastest_rate(BodyForcing::NONE, [0.0; 2]);
                rates_after_start(start.body, &ForcingInterval::none(), rate)[k]
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
    const FITS: bool = !L::QUATERNION && !L::TANGENT && (L::BALANCE || L::VECTORS == M::HEAVY as usize);

    #[inline(always)]
    fn after_step<S: Stepper<R, M, L, D>>(
        stepper: &S,
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
            let begin_rate = along(&axis, &stepper.velocity(p, before)) * p.step;
            let end_rate = along(&axis, &stepper.velocity(p, after)) * p.step;
            let mut fraction = hermite_root(begin, begin_rate, end, end_rate);
            if const { S::IS_SERIES } {
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
        if const { S::IS_SERIES } {
            Self::two_flips_in_a_step(stepper, p, rows, segment);
        }
    }
}
