//! Growth of a deviation vector: its logarithm, and the means of the logarithm over the time.

use super::inside::state;
use super::{Observable, Rows, Segment, Start, Update};
use crate::kinematics::{cross, direction, dot};
use crate::method::Engine;
use crate::real::Real;
use crate::scene::{Layout, Model};
use crate::special::ln;

/// A deviation vector at the start, and the norm in which its growth is measured: `|d / scale|^2 + |x|^2` of a change d
/// of the rates, or momenta in a kernel, and a rotation vector x, or with the change `gamma x x` of the vertical
/// instead of x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviation {
    /// Change of the rates, and rotation vector.
    pub start: [f64; 6],
    /// One over the unit of each rate.
    pub inverse_scale: [f64; 3],
    /// Whether the rotation vector counts, not only the change of the vertical.
    pub of_attitude: bool,
}

impl Deviation {
    /// No deviation vector.
    pub const NONE: Deviation = Deviation::new([0.0; 6]);

    /// A deviation vector whose growth is not observed.
    pub const fn new(start: [f64; 6]) -> Deviation {
        Deviation { start, inverse_scale: [1.0; 3], of_attitude: true }
    }

    /// The vector whose length is the norm of a deviation vector.
    #[inline(always)]
    pub fn measured(&self, deviation: &[f64; 6], gamma: &[f64; 3]) -> [f64; 6] {
        let [d1, d2, d3, x1, x2, x3] = *deviation;
        let x = [x1, x2, x3];
        let [a, b, c] = if self.of_attitude { x } else { cross(gamma, &x) };
        let [s1, s2, s3] = self.inverse_scale;
        [d1 * s1, d2 * s2, d3 * s3, a, b, c]
    }
}

/// Logarithm of the size of a deviation vector over its size at the start, and integrals of the logarithm over the
/// time.
///
/// With `Λ = ln |v| / |v(0)|` and its integral `A`, MEGNO is `2 (Λ - A / t)` (Cincotta & Simó 2000, doi
/// 10.1051/aas:2000108), and its mean over the time is `(2 / t) (A - integral of A / t)`. The integrals are trapezoids of
/// the steps of a Runge-Kutta method. A series is known inside its steps: there they are those of the implicit
/// Runge-Kutta method of Gauss with four stages.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Growth;

impl Growth {
    /// The logarithm after the last step.
    pub const LOG: usize = 1;
    /// The largest logarithm.
    pub const LARGEST: usize = 2;
    /// Integral of the logarithm.
    pub const AREA: usize = 3;
    /// Integral of the mean of the logarithm until each time.
    pub const MEAN_AREA: usize = 4;
    /// Time.
    pub const TIME: usize = 5;
    /// The deviation vector is 2^shift times its row.
    pub const SHIFT: usize = 6;
    /// Of the first rate, and two more.
    const INVERSE_SCALE: usize = 7;
    /// 1 if the rotation vector counts, 0 if the change of the vertical counts.
    const OF_ATTITUDE: usize = 10;
    /// The logarithm of the size at the start.
    const START: usize = 11;

    /// The logarithm, its largest until now, its mean over the time, and half of the mean of MEGNO.
    ///
    /// The mean over the time of `2 (L - mean)` is `2 (mean - mean of mean)`.
    pub fn logs(rows: &Rows<f64>) -> [f64; 4] {
        let time = rows[Growth::TIME];
        let (mean, mean_of_mean) = (rows[Growth::AREA] / time, rows[Growth::MEAN_AREA] / time);
        [rows[Growth::LOG], rows[Growth::LARGEST], mean, mean - mean_of_mean]
    }

    /// Logarithm of the size of a deviation vector, which is 2^shift times `[d, x]`. The power of two is added to the
    /// exponent of the square, so the logarithm does not depend on how the size is divided between both.
    #[inline(always)]
    fn log<R: Real>(rows: &Rows<R>, d: [R; 3], x: [R; 3], gamma: [R; 3]) -> R {
        let at = Growth::INVERSE_SCALE;
        let d = [d[0] * rows[at], d[1] * rows[at + 1], d[2] * rows[at + 2]];
        let turned = cross(&gamma, &x);
        let turn = R::select(R::splat(0.5).lt(rows[Growth::OF_ATTITUDE]), dot(&x, &x), dot(&turned, &turned));
        let square = dot(&d, &d) + turn;
        let (mantissa, exponent) = square.frexp();
        let exponent = exponent + (rows[Growth::SHIFT] + rows[Growth::SHIFT]);
        let log = exponent.fma(R::splat(std::f64::consts::LN_2), ln(mantissa)) * R::splat(0.5);
        // A square that overflows has no logarithm.
        square.fma(R::splat(0.0), log) - rows[Growth::START]
    }

    /// Integrals by trapezoids.
    #[inline(always)]
    fn add_trapezoid<R: Real>(rows: &mut Rows<R>, step: R, log: R) {
        let half = step * R::splat(0.5);
        let before = rows[Growth::AREA] / positive(rows[Growth::TIME]);
        let time = rows[Growth::TIME] + step;
        let area = half.fma(rows[Growth::LOG] + log, rows[Growth::AREA]);
        rows[Growth::MEAN_AREA] = half.fma(before + area / positive(time), rows[Growth::MEAN_AREA]);
        (rows[Growth::AREA], rows[Growth::TIME]) = (area, time);
    }

    /// Integrals by the method of Gauss.
    #[inline(always)]
    fn add_gauss<R: Real>(rows: &mut Rows<R>, step: R, logs: &[R; 4]) {
        let (mut area, mut mean_area) = (R::splat(0.0), R::splat(0.0));
        for i in 0..4 {
            let mut until = R::splat(0.0);
            for j in 0..4 {
                until = R::splat(GAUSS[i][j]).fma(logs[j], until);
            }
            let until = step.fma(until, rows[Growth::AREA]);
            let time = step.fma(R::splat(NODES[i]), rows[Growth::TIME]);
            let weight = R::splat(WEIGHTS[i]);
            area = weight.fma(logs[i], area);
            mean_area = weight.fma(until / positive(time), mean_area);
        }
        rows[Growth::AREA] = step.fma(area, rows[Growth::AREA]);
        rows[Growth::MEAN_AREA] = step.fma(mean_area, rows[Growth::MEAN_AREA]);
        rows[Growth::TIME] = rows[Growth::TIME] + step;
    }
}

/// A divisor that is not zero: at the start the dividend is zero too.
#[inline(always)]
fn positive<R: Real>(time: R) -> R {
    time.max(R::splat(f64::MIN_POSITIVE))
}

/// Nodes of Gauss' quadrature of order 8 on [0, 1].
const NODES: [f64; 4] =
    [0.069_431_844_202_973_71, 0.330_009_478_207_571_87, 0.669_990_521_792_428_1, 0.930_568_155_797_026_3];

/// Weights of Gauss' quadrature of order 8.
const WEIGHTS: [f64; 4] =
    [0.173_927_422_568_726_92, 0.326_072_577_431_273_05, 0.326_072_577_431_273_05, 0.173_927_422_568_726_92];

/// The matrix of Gauss' implicit Runge-Kutta method of order 8 (Butcher 1964).
const GAUSS: [[f64; 4]; 4] = [
    [
        0.086_963_711_284_363_46,
        -0.026_604_180_084_998_794,
        0.012_627_462_689_404_725,
        -0.003_555_149_685_795_683_3,
    ],
    [
        0.188_118_117_499_868_06,
        0.163_036_288_715_636_52,
        -0.027_880_428_602_470_895,
        0.006_735_500_594_538_156,
    ],
    [
        0.167_191_921_974_188_78,
        0.353_953_006_033_743_97,
        0.163_036_288_715_636_52,
        -0.014_190_694_931_141_144,
    ],
    [0.177_482_572_254_522_6, 0.313_445_114_741_868_37, 0.352_676_757_516_271_87, 0.086_963_711_284_363_46],
];

/// Nodes and weights integrate powers below 8, and each row of the matrix powers below 4.
const _: () = {
    let (mut power, mut k) = ([1.0; 4], 1);
    while k <= 8 {
        let (mut sum, mut i) = (0.0, 0);
        while i < 4 {
            sum += WEIGHTS[i] * power[i];
            if k <= 4 {
                let (mut row, mut j) = (0.0, 0);
                while j < 4 {
                    row += GAUSS[i][j] * power[j];
                    j += 1;
                }
                let miss = row - power[i] * NODES[i] / k as f64;
                assert!(miss < 1e-15 && -miss < 1e-15);
            }
            i += 1;
        }
        let miss = sum - 1.0 / k as f64;
        assert!(miss < 1e-15 && -miss < 1e-15);
        let mut i = 0;
        while i < 4 {
            power[i] *= NODES[i];
            i += 1;
        }
        k += 1;
    }
};

impl Observable for Growth {
    const ROWS: usize = 12;
    const CHANGING: usize = 6;

    fn start(self, start: &Start) -> Rows<f64> {
        let mut rows = super::UNOBSERVED;
        let Deviation { start: [d1, d2, d3, x1, x2, x3], inverse_scale, of_attitude } = *start.deviation;
        rows[Growth::INVERSE_SCALE..Growth::OF_ATTITUDE].copy_from_slice(&inverse_scale);
        rows[Growth::OF_ATTITUDE] = if of_attitude { 1.0 } else { 0.0 };
        rows[Growth::START] = Growth::log(&rows, [d1, d2, d3], [x1, x2, x3], start.direction);
        rows
    }

    /// The logarithm at the end.
    fn outcome(rows: &Rows<f64>) -> f64 {
        rows[Growth::LOG]
    }
}

impl<R: Real, M: Model<R>, L: Layout, const D: usize> Update<R, M, L, D> for Growth {
    const FITS: bool = L::TANGENT && L::BALANCE == L::CHANGED;

    #[inline(always)]
    fn after_step<S: Engine<R, M, L, D>>(self, rows: &mut Rows<R>, segment: &Segment<R, S, D>) {
        let (at, &Segment { p, after: y, .. }) = (L::TANGENT_AT, segment);
        let log = Growth::log(
            rows,
            [y[at], y[at + 1], y[at + 2]],
            [y[at + 3], y[at + 4], y[at + 5]],
            direction(y, 0),
        );
        // A lane that waits for others keeps the logarithm of its last step: since then its deviation vector may have lost
        // what the norm does not see, and its logarithm is rounded otherwise.
        let (moves, last) = (R::splat(0.0).lt(p.step.abs()), rows[Growth::LOG]);
        let log = R::select(moves, log, last);
        if const { S::IS_SERIES } {
            let dense = segment.dense;
            let mut logs = [log; 4];
            for i in 0..4 {
                let node = R::splat(NODES[i]);
                let y = state(dense, node);
                let (d, x) = ([y[at], y[at + 1], y[at + 2]], [y[at + 3], y[at + 4], y[at + 5]]);
                logs[i] = R::select(moves, Growth::log(rows, d, x, direction(&y, 0)), last);
                rows[Growth::LARGEST] = rows[Growth::LARGEST].max(logs[i]);
            }
            Growth::add_gauss(rows, p.step, &logs);
        } else {
            Growth::add_trapezoid(rows, p.step, log);
        }
        rows[Growth::LOG] = log;
        rows[Growth::LARGEST] = rows[Growth::LARGEST].max(log);
    }
}
