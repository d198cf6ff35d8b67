//! The mean over the time of a component of the rates.

use super::{Observable, Rows, Segment, Start, Update, look_inside, motion_inside, three};
use crate::kinematics::{dot, put};
use crate::method::Engine;
use crate::real::{Real, two_sum};
use crate::scene::{Layout, Model, Parameters};

/// The integral over the time of the rate about the observed axis: of the motion inside each long step, else of the cubic
/// through the values and slopes at the ends of the step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeanRate;

impl MeanRate {
    /// The integral, and the rounding error of the sum.
    pub const ANGLE: usize = 1;
    /// The end of the last step.
    pub const TIME: usize = 3;
    /// The observed body axis: a unit vector along a principal axis, in either direction.
    pub const AXIS: usize = 4;
}

impl Observable for MeanRate {
    const ROWS: usize = 7;
    const CHANGING: usize = 4;

    fn start(self, start: &Start) -> Rows<f64> {
        let mut rows = super::UNOBSERVED;
        put(&mut rows, MeanRate::AXIS, start.unit);
        rows
    }

    /// The integral over the time.
    fn outcome(rows: &Rows<f64>) -> f64 {
        (rows[MeanRate::ANGLE] + rows[MeanRate::ANGLE + 1]) / rows[MeanRate::TIME]
    }
}

impl<R: Real, M: Model<R>, L: Layout, const D: usize> Update<R, M, L, D> for MeanRate {
    /// True for the rates of the body in the layout that contains only variables that the rates need.
    const FITS: bool =
        L::CLOCK || !L::TANGENT && (L::BALANCE || !L::QUATERNION && L::VECTORS == M::HEAVY as usize);

    #[inline(always)]
    fn after_step<S: Engine<R, M, L, D>>(self, rows: &mut Rows<R>, segment: &Segment<R, S, D>) {
        if const { S::IS_LONG } {
            // Of each body; an inactive one has a step of zero.
            let wanted = R::splat(0.0).lt(segment.p.step.abs());
            look_inside::<_, R, M, L, S, D>(self, rows, segment, wanted);
            return;
        }
        let &Segment { engine, p, begin: time, before, after, .. } = segment;
        let axis = three(rows, MeanRate::AXIS);
        let (begin, end) = (S::VARIABLES.rates(p, before), S::VARIABLES.rates(p, after));
        let (begin, end) = (dot(&axis, &begin), dot(&axis, &end));
        // The state may consist of momenta.
        let [mut slope, last] = [engine.velocity(p, before), engine.velocity(p, after)];
        for k in 0..3 {
            slope[k] = (slope[k] - last[k]) * p.step;
        }
        let bend = dot(&axis, &S::VARIABLES.rates(p, &slope));
        let mean = bend.fma(R::splat(1.0 / 12.0), (begin + end) * R::splat(0.5));
        MeanRate::add(p, rows, time, mean);
    }

    #[inline(always)]
    fn look<S: Engine<R, M, L, D>>(self, rows: &mut Rows<R>, segment: &Segment<R, S, D>) {
        let axis = three(rows, MeanRate::AXIS);
        let mut mean = R::splat(0.0);
        for (k, row) in motion_inside(segment).all().iter().enumerate().rev() {
            mean = dot(&axis, &[row[0], row[1], row[2]]).fma(R::splat(1.0 / (k + 1) as f64), mean);
        }
        MeanRate::add(segment.p, rows, segment.begin, mean);
    }
}

impl MeanRate {
    /// Adds the integral over a step, from the mean in it. Over an anomaly it is that of the rates over the pace.
    #[inline(always)]
    fn add<R: Real>(p: &Parameters<R>, rows: &mut Rows<R>, begin: R, mean: R) {
        let (sum, lost) = two_sum(rows[MeanRate::ANGLE], mean * p.step);
        rows[MeanRate::ANGLE] = sum;
        rows[MeanRate::ANGLE + 1] = rows[MeanRate::ANGLE + 1] + lost;
        rows[MeanRate::TIME] = begin + p.step;
    }
}
