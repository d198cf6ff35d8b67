//! The free motion of any body by the discrete Moser-Veselov map, with moments modified to correct the time.
//!
//! The map conserves the energy H, |L| and the path; only the time along the path is wrong. With `1/I_j` replaced by
//! `(1 + s) / I_j + d`, with two series in h^2 H and h^2 L.L/2, the map has any even order (Hairer & Vilmart,
//! J. Phys. A 39 (2006) 13225). The coefficients were found by an exact rational fit to the series of the motion.

use super::{Drift, Numbers, power};
use crate::kinematics;
use crate::real::Real;
use crate::scene::{Layout, Model, Parameters};

/// Power of H, factor, powers of the elementary symmetric functions of 1/I. The powers of H and `C = L.L/2` have the
/// sum k + 1.
type Monomial = (usize, f64, [usize; 3]);

#[rustfmt::skip]
const STRETCH: [&[Monomial]; 4] = [
    &[
        (0, 1.0 / 6.0, [0, 1, 0]),
        (1, -1.0 / 3.0, [1, 0, 0]),
    ],
    &[
        (0, 1.0 / 30.0, [0, 2, 0]),
        (0, -1.0 / 10.0, [1, 0, 1]),
        (1, -1.0 / 30.0, [1, 1, 0]),
        (1, 2.0 / 15.0, [0, 0, 1]),
        (2, 1.0 / 30.0, [2, 0, 0]),
        (2, -1.0 / 60.0, [0, 1, 0]),
    ],
    &[
        (0, 17.0 / 2520.0, [0, 3, 0]),
        (0, -11.0 / 420.0, [1, 1, 1]),
        (0, 5.0 / 126.0, [0, 0, 2]),
        (1, -1.0 / 70.0, [1, 2, 0]),
        (1, 11.0 / 210.0, [2, 0, 1]),
        (1, -1.0 / 84.0, [0, 1, 1]),
        (2, 1.0 / 420.0, [2, 1, 0]),
        (2, 41.0 / 2520.0, [0, 2, 0]),
        (2, -53.0 / 630.0, [1, 0, 1]),
        (3, -1.0 / 630.0, [3, 0, 0]),
        (3, 1.0 / 630.0, [1, 1, 0]),
        (3, 1.0 / 35.0, [0, 0, 1]),
    ],
    &[
        (0, 31.0 / 22680.0, [0, 4, 0]),
        (0, -19.0 / 2520.0, [1, 2, 1]),
        (0, 1.0 / 120.0, [2, 0, 2]),
        (0, 97.0 / 15120.0, [0, 1, 2]),
        (1, -11.0 / 3240.0, [1, 3, 0]),
        (1, 17.0 / 1260.0, [2, 1, 1]),
        (1, 47.0 / 7560.0, [0, 2, 1]),
        (1, -47.0 / 945.0, [1, 0, 2]),
        (2, 13.0 / 3780.0, [2, 2, 0]),
        (2, 1.0 / 2520.0, [0, 3, 0]),
        (2, -17.0 / 1260.0, [3, 0, 1]),
        (2, 1.0 / 252.0, [1, 1, 1]),
        (2, 53.0 / 1260.0, [0, 0, 2]),
        (3, -1.0 / 11340.0, [3, 1, 0]),
        (3, -11.0 / 1890.0, [1, 2, 0]),
        (3, 23.0 / 945.0, [2, 0, 1]),
        (3, -23.0 / 1260.0, [0, 1, 1]),
        (4, 1.0 / 22680.0, [4, 0, 0]),
        (4, -1.0 / 15120.0, [2, 1, 0]),
        (4, 17.0 / 5040.0, [0, 2, 0]),
        (4, -3.0 / 280.0, [1, 0, 1]),
    ],
];
#[rustfmt::skip]
const SHIFT: [&[Monomial]; 4] = [
    &[
        (0, -1.0 / 3.0, [0, 0, 1]),
        (1, 1.0 / 6.0, [0, 1, 0]),
    ],
    &[
        (0, -1.0 / 60.0, [0, 1, 1]),
        (1, -1.0 / 60.0, [0, 2, 0]),
        (1, 2.0 / 15.0, [1, 0, 1]),
        (2, -1.0 / 60.0, [1, 1, 0]),
        (2, -1.0 / 10.0, [0, 0, 1]),
    ],
    &[
        (0, -19.0 / 2520.0, [0, 2, 1]),
        (0, 1.0 / 35.0, [1, 0, 2]),
        (1, 1.0 / 1260.0, [0, 3, 0]),
        (1, -1.0 / 1260.0, [1, 1, 1]),
        (1, -22.0 / 315.0, [0, 0, 2]),
        (2, 13.0 / 2520.0, [1, 2, 0]),
        (2, -8.0 / 315.0, [2, 0, 1]),
        (2, 11.0 / 252.0, [0, 1, 1]),
        (3, 1.0 / 1260.0, [2, 1, 0]),
        (3, -13.0 / 1260.0, [0, 2, 0]),
        (3, 1.0 / 42.0, [1, 0, 1]),
    ],
    &[
        (0, -61.0 / 45360.0, [0, 3, 1]),
        (0, 3.0 / 560.0, [1, 1, 2]),
        (0, -61.0 / 4536.0, [0, 0, 3]),
        (1, -1.0 / 45360.0, [0, 4, 0]),
        (1, 37.0 / 7560.0, [1, 2, 1]),
        (1, -2.0 / 105.0, [2, 0, 2]),
        (1, 19.0 / 1260.0, [0, 1, 2]),
        (2, -1.0 / 1512.0, [1, 3, 0]),
        (2, 19.0 / 7560.0, [2, 1, 1]),
        (2, -19.0 / 1080.0, [0, 2, 1]),
        (2, 89.0 / 1890.0, [1, 0, 2]),
        (3, -1.0 / 1512.0, [2, 2, 0]),
        (3, 97.0 / 22680.0, [0, 3, 0]),
        (3, 8.0 / 2835.0, [3, 0, 1]),
        (3, -23.0 / 1890.0, [1, 1, 1]),
        (3, -1.0 / 35.0, [0, 0, 2]),
        (4, -1.0 / 45360.0, [3, 1, 0]),
        (4, -1.0 / 7560.0, [1, 2, 0]),
        (4, -1.0 / 360.0, [2, 0, 1]),
        (4, 17.0 / 1680.0, [0, 1, 1]),
    ],
];

/// Checks the dimension of every term, and steady rotations: about each principal axis
/// `(1/I) (1 + s) + d = sin(w h) / (I w h)`.
const _: () = {
    let j = [1.0, 0.625, 0.5];
    let e = symmetric_functions(j);
    let mut axis = 0;
    while axis < 3 {
        // L = 1.
        let (energy, c) = (0.5 * j[axis], 0.5);
        let mut term = 1.0;
        let mut k = 0;
        while k < 4 {
            let [s, d] = [sum(STRETCH[k], e, energy, c, k, 0), sum(SHIFT[k], e, energy, c, k, 1)];
            term *= -j[axis] * j[axis] / ((2 * k + 2) * (2 * k + 3)) as f64;
            let miss = j[axis] * s + d - j[axis] * term;
            assert!(miss < 1e-16 && miss > -1e-16);
            k += 1;
        }
        axis += 1;
    }
};
const fn symmetric_functions([a, b, c]: [f64; 3]) -> [f64; 3] {
    [a + b + c, a * b + b * c + c * a, a * b * c]
}
const fn sum(terms: &[Monomial], e: [f64; 3], energy: f64, c: f64, k: usize, extra: usize) -> f64 {
    let mut sum = 0.0;
    let mut i = 0;
    while i < terms.len() {
        let (a, factor, p) = terms[i];
        // s has no dimension, d that of 1/I; H is L.L/I.
        assert!(a <= k + 1 && p[0] + 2 * p[1] + 3 * p[2] == 2 * (k + 1) - a + extra);
        sum += factor
            * power(e[0], p[0])
            * power(e[1], p[1])
            * power(e[2], p[2])
            * power(energy, a)
            * power(c, k + 1 - a);
        i += 1;
    }
    sum
}

/// The map of an order from 2 to 10. Moments are in units of the first moment, so that only the step has a dimension.
#[derive(Clone, Copy)]
pub struct MoserVeselov<R> {
    /// Step over the first moment; the product with L is an angle.
    angle: R,
    /// Inverse moments.
    j: [R; 3],
    /// Differences of the next two inverse moments, one of which is zero for a symmetric body.
    uneven: [R; 3],
    /// Coefficients of H^a C^(k+1-a).
    s: [[R; 5]; 4],
    d: [[R; 5]; 4],
}

/// Largest angle of a step. The equation of the map has a solution up to about a right angle. Close to this limit
/// Newton's method fails, and beyond it Newton's method finds another motion.
const LARGEST_ANGLE: f64 = 1.25;
/// Largest last correction of Newton's method; the remaining error is about the square of the correction.
const LARGEST_CORRECTION: f64 = 1e-5;
/// Numbers of fixed-point iterations and Newton steps: enough for rounding accuracy at angles up to 0.5.
const SWEEPS: usize = 2;
const NEWTON_STEPS: usize = 2;

#[inline(always)]
fn coefficients<R: Real>(terms: &[Monomial], powers: &[[R; 5]; 3]) -> [R; 5] {
    let mut all = [R::splat(0.0); 5];
    for &(a, factor, [p, q, r]) in terms {
        all[a] = ((powers[0][p] * powers[1][q]) * powers[2][r]).fma(R::splat(factor), all[a]);
    }
    all
}

/// The sum over k of the homogeneous polynomials, by Horner's rule in C of polynomials in H.
#[inline(always)]
fn series<R: Real>(table: &[[R; 5]; 4], energy: R, c: R) -> R {
    let mut sum = R::splat(0.0);
    for b in (0..5).rev() {
        let mut inner = R::splat(0.0);
        for k in (b.max(1)..5).rev() {
            inner = inner.fma(energy, table[k - 1][k - b]);
        }
        if b == 0 {
            inner = inner * energy;
        }
        sum = sum.fma(c, inner);
    }
    sum
}

impl<R: Real> Drift<R> for MoserVeselov<R> {
    #[inline(always)]
    fn new(p: &Parameters<R>, numbers: &Numbers) -> Self {
        let [i1, i2, i3] = p.moments;
        let one = R::splat(1.0);
        let j = [one, i1 / i2, i1 / i3];
        let e = [j[0] + j[1] + j[2], (j[0] * j[1] + j[1] * j[2]) + j[2] * j[0], (j[0] * j[1]) * j[2]];
        let mut powers = [[one; 5]; 3];
        for i in 0..3 {
            for n in 1..5 {
                powers[i][n] = powers[i][n - 1] * e[i];
            }
        }
        let zero = R::splat(0.0);
        let (mut s, mut d) = ([[zero; 5]; 4], [[zero; 5]; 4]);
        // The last coefficients of a lower order are 0.
        for k in 0..numbers.drift_order / 2 - 1 {
            s[k] = coefficients(STRETCH[k], &powers);
            d[k] = coefficients(SHIFT[k], &powers);
        }
        let uneven = [j[1] * ((i3 - i2) / i3), j[2] * ((i1 - i3) / i1), (i2 - i1) / i2];
        MoserVeselov { angle: p.step / i1, j, uneven, s, d }
    }

    #[inline(always)]
    fn flow<M: Model<R>, L: Layout, const D: usize>(&self, fraction: R, y: &mut [R; D]) {
        let (one, half) = (R::splat(1.0), R::splat(0.5));
        let angle = fraction * self.angle;
        let x = [angle * y[0], angle * y[1], angle * y[2]];
        let squares = [x[0] * x[0], x[1] * x[1], x[2] * x[2]];
        let energy = kinematics::dot(&squares, &self.j) * half;
        let c = ((squares[0] + squares[1]) + squares[2]) * half;
        let stretch = series(&self.s, energy, c) + one;
        let shift = series(&self.d, energy, c);
        // The modified inverse moments, and the ratios (I3 - I2) / I1 of their inverses.
        let mut k = self.j;
        for i in 0..3 {
            k[i] = self.j[i].fma(stretch, shift);
        }
        let scale = stretch / ((k[0] * k[1]) * k[2]);
        let (mut b, mut ratio) = (x, x);
        for i in 0..3 {
            b[i] = (k[i] * x[i]) * half;
            ratio[i] = (k[i] * k[i]) * (self.uneven[i] * scale);
        }
        let (e, correction) = rotation(&b, &ratio);

        // The body turns by (1, e) / |(1, e)|. A rejected solution becomes NaN.
        let rate = [self.j[0] * x[0], self.j[1] * x[1], self.j[2] * x[2]];
        let nan = R::splat(f64::NAN);
        let inverse = one / e[0].fma(e[0], e[1].fma(e[1], e[2].fma(e[2], one)));
        let slow = kinematics::dot(&rate, &rate).lt(R::splat(LARGEST_ANGLE * LARGEST_ANGLE));
        let inverse = R::select(slow, inverse, nan);
        let inverse = R::select(correction.lt(R::splat(LARGEST_CORRECTION)), inverse, nan);
        let twice = inverse + inverse;
        for v in 0..L::VECTORS + 1 {
            let n = [y[3 * v], y[3 * v + 1], y[3 * v + 2]];
            let p = kinematics::cross(&n, &e);
            let r = kinematics::cross(&p, &e);
            for i in 0..3 {
                y[3 * v + i] = twice.fma(p[i] + r[i], n[i]);
            }
        }
        if L::QUATERNION {
            let at = L::QUATERNION_AT;
            let q = [y[at], y[at + 1], y[at + 2], y[at + 3]];
            let w = inverse.sqrt();
            let by = [w, w * e[0], w * e[1], w * e[2]];
            kinematics::put(y, at, kinematics::quaternion_product(&q, &by));
        }
    }
}

/// The solution e of `e_i + ratio_i e_j e_k = b_i (1 + e.e)` that vanishes with b, and its last correction.
#[inline(always)]
fn rotation<R: Real>(b: &[R; 3], ratio: &[R; 3]) -> ([R; 3], R) {
    let one = R::splat(1.0);
    let mut e = [
        ratio[0].fnma(b[1] * b[2], b[0]),
        ratio[1].fnma(b[2] * b[0], b[1]),
        ratio[2].fnma(b[0] * b[1], b[2]),
    ];
    for _ in 0..SWEEPS {
        let n = e[0].fma(e[0], e[1].fma(e[1], e[2].fma(e[2], one)));
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            e[i] = ratio[i].fnma(e[j] * e[k], b[i] * n);
        }
    }
    let mut correction = one;
    for _ in 0..NEWTON_STEPS {
        let n = e[0].fma(e[0], e[1].fma(e[1], e[2].fma(e[2], one)));
        // Row i of the matrix begins with its diagonal element, the others follow cyclically.
        let mut a = [e; 3];
        let mut miss = e;
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let twice = b[i] + b[i];
            a[i] =
                [twice.fnma(e[i], one), twice.fnma(e[j], ratio[i] * e[k]), twice.fnma(e[k], ratio[i] * e[j])];
            miss[i] = b[i].fnma(n, ratio[i].fma(e[j] * e[k], e[i]));
        }
        // Cramer's rule: the columns of the inverse are cross products of rows.
        let rows = [a[0], [a[1][2], a[1][0], a[1][1]], [a[2][1], a[2][2], a[2][0]]];
        let columns = [
            kinematics::cross(&rows[1], &rows[2]),
            kinematics::cross(&rows[2], &rows[0]),
            kinematics::cross(&rows[0], &rows[1]),
        ];
        let inverse = one / kinematics::dot(&rows[0], &columns[0]);
        correction = R::splat(0.0);
        for i in 0..3 {
            let sum = columns[0][i].fma(miss[0], columns[1][i].fma(miss[1], columns[2][i] * miss[2]));
            let step = inverse * sum;
            e[i] = e[i] - step;
            // A NaN remains.
            correction = correction + step.abs();
        }
    }
    (e, correction)
}
