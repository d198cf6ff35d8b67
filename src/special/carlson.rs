//! Carlson's symmetric elliptic integrals over `Real`, by duplication (Carlson 1995, "Numerical computation of
//! real or complex elliptic integrals", Numer. Algorithms 10).
//!
//! A converged lane is frozen, so the numbers of a lane do not depend on other lanes. Roots and divisions are
//! expensive, so the series are long and the duplications few.

use super::elementary::{atan2, ln, polynomial};
use crate::real::Real;

/// Number of duplications that is enough for all arguments in the range of doubles. A duplication halves the logarithm
/// of the ratio of two arguments (below 2100 bits) until the ratio is of order one, and then quarters the distance.
const DUPLICATIONS: usize = 20;

/// n! of a small n, as a double.
const fn factorial(n: u32) -> f64 {
    let (mut product, mut i) = (1.0, 2);
    while i <= n {
        product *= i as f64;
        i += 1;
    }
    product
}

/// (1/2)(3/2)…(n - 1/2).
const fn half_rising(n: u32) -> f64 {
    let (mut product, mut i) = (1.0, 0);
    while i < n {
        product *= i as f64 + 0.5;
        i += 1;
    }
    product
}

/// 1 / (2 k + 1), with the sign of (-1)^k: atan(a) / a as a polynomial in a^2.
const ARCTANGENT: [f64; 22] = {
    let mut row = [0.0; 22];
    let mut k = 0;
    while k < row.len() {
        row[k] = (if k % 2 == 0 { 1.0 } else { -1.0 }) / (2 * k + 1) as f64;
        k += 1;
    }
    row
};

/// Coefficients of E3^n E2^0, E3^n E2^1, … in the series of R_F about equal arguments, without the leading 1 (DLMF
/// 19.19.7).
const fn rf_series<const N: usize>(n: u32) -> [f64; N] {
    let mut row = [0.0; N];
    let mut m = 0;
    while m < N as u32 {
        let (factors, degree) = (m + n, 2 * m + 3 * n);
        let sign = if (factors + degree) % 2 == 0 { 1.0 } else { -1.0 };
        let weight = half_rising(factors) / (factorial(m) * factorial(n));
        row[m as usize] = if degree == 0 { 0.0 } else { sign * weight / (2 * degree + 1) as f64 };
        m += 1;
    }
    row
}

/// Lanes in which an argument is farther from the mean than `spread` times the mean.
#[inline(always)]
fn apart<R: Real, const N: usize>(mean: R, spread: f64, arguments: [R; N]) -> R::Mask {
    let mut farthest = (mean - arguments[0]).abs();
    for i in 1..N {
        farthest = farthest.max((mean - arguments[i]).abs());
    }
    (mean * R::splat(spread)).lt(farthest)
}

/// R_F(x, y, z): half the integral of 1 / sqrt((t + x)(t + y)(t + z)) over t > 0; arguments >= 0, at most one of
/// them 0.
///
/// Within 4 ulp for arguments 0 and 1e-300 to 1e300 (measured: 3.7); infinity where two are 0.
#[inline(always)]
pub fn carlson_rf<R: Real>(x: R, y: R, z: R) -> R {
    // The terms of degree 12, the first omitted, are below 0.01 SPREAD^12 < 1e-17.
    const SPREAD: f64 = 0.055;
    const SERIES: [f64; 6] = rf_series(0);
    const SERIES_1: [f64; 5] = rf_series(1);
    const SERIES_2: [f64; 3] = rf_series(2);
    const SERIES_3: [f64; 2] = rf_series(3);
    let (mut x, mut y, mut z) = (x, y, z);
    let (third, quarter, one) = (R::splat(1.0 / 3.0), R::splat(0.25), R::splat(1.0));
    let mut mean = (x + y + z) * third;
    let mut wide = apart(mean, SPREAD, [x, y, z]);
    for _ in 0..DUPLICATIONS {
        if !R::any(wide) {
            break;
        }
        let (a, b, c) = (x.sqrt(), y.sqrt(), z.sqrt());
        let shift = a.fma(b + c, b * c);
        x = R::select(wide, (x + shift) * quarter, x);
        y = R::select(wide, (y + shift) * quarter, y);
        z = R::select(wide, (z + shift) * quarter, z);
        mean = (x + y + z) * third;
        wide = apart(mean, SPREAD, [x, y, z]);
    }
    let root = one / mean.sqrt();
    let inverse = root * root;
    let (dx, dy) = ((mean - x) * inverse, (mean - y) * inverse);
    let dz = dx + dy;
    let product = dx * dy;
    let (e2, e3) = (dz.fnma(dz, product), -(product * dz));
    let first = e3.fma(polynomial(e2, SERIES_3), polynomial(e2, SERIES_2));
    let series = e3.fma(e3.fma(first, polynomial(e2, SERIES_1)), polynomial(e2, SERIES));
    // The root and its reciprocal have errors of half an ulp each, so one Newton step with an exact residual follows.
    let product = mean * root;
    let rest = product.fnma(root, one) - mean.fms(root, product) * root;
    let value = root.fma(rest.fma(R::splat(0.5), series), root);
    R::select(wide, R::splat(f64::INFINITY), value)
}

/// R_C(x, y) for x >= 0, y > 0, from a difference y - x that is more accurate than x and y.
#[inline(always)]
fn rc_of_difference<R: Real>(x: R, y: R, difference: R) -> R {
    // The first term omitted is below NEAR^22 / 45 < 1e-17. Closer to 1 the logarithm would lose digits.
    const NEAR: f64 = 0.2;
    let size = difference.abs();
    let far = (x * R::splat(NEAR)).lt(size);
    let near = polynomial(difference / x, ARCTANGENT) / x.sqrt();
    if R::any(far) {
        let (leg, base) = (size.sqrt(), x.sqrt());
        let above = R::splat(0.0).lt(difference);
        let logarithm = ln((base + leg) / R::select(above, base, y.sqrt()));
        let value = R::select(above, atan2(leg, base), logarithm) / leg;
        R::select(far, value, near)
    } else {
        near
    }
}

/// R_C(x, y) = R_F(x, y, y) for x >= 0, y > 0; Cauchy's principal value for x > 0, y < 0.
///
/// Within 6 ulp for arguments 0 and 1e-300 to 1e300 (measured: 5.2, above 0 4.3).
#[inline(always)]
pub fn carlson_rc<R: Real>(x: R, y: R) -> R {
    let zero = R::splat(0.0);
    let negative = y.lt(zero);
    if R::any(negative) {
        // DLMF 19.2.20.
        let sum = x - y;
        let value = rc_of_difference(R::select(negative, sum, x), y.abs(), R::select(negative, -x, y - x));
        R::select(negative, x.sqrt() / sum.sqrt() * value, value)
    } else {
        rc_of_difference(x, y, y - x)
    }
}

/// The series of R_J and R_D about equal arguments (DLMF 19.36.2) through degree 7, without the leading 1, from the
/// symmetric functions E2 to E5 of the five relative distances.
#[inline(always)]
fn rj_series<R: Real>(e2: R, e3: R, e4: R, e5: R) -> R {
    const C2: f64 = -3.0 / 14.0;
    const C3: f64 = 1.0 / 6.0;
    const C22: f64 = 9.0 / 88.0;
    const C4: f64 = -3.0 / 22.0;
    const C23: f64 = -9.0 / 52.0;
    const C5: f64 = 3.0 / 26.0;
    const C222: f64 = -1.0 / 16.0;
    const C33: f64 = 3.0 / 40.0;
    const C24: f64 = 3.0 / 20.0;
    const C223: f64 = 45.0 / 272.0;
    const C34_25: f64 = -9.0 / 68.0;
    let of_e3 = e3.fma(R::splat(C33), e4.fma(R::splat(C34_25), polynomial(e2, [C3, C23, C223])));
    let of_e4 = e2.fma(R::splat(C24), R::splat(C4));
    let of_e5 = e2.fma(R::splat(C34_25), R::splat(C5));
    e2.fma(polynomial(e2, [C2, C22, C222]), e3.fma(of_e3, e4.fma(of_e4, e5 * of_e5)))
}

/// Distance from the mean, in units of the mean, at which the first omitted terms of `rj_series` are below 1.4 SPREAD^8
/// < 1e-17.
const RJ_SPREAD: f64 = 0.007;

/// R_D(x, y, z) = R_J(x, y, z, z): arguments >= 0, z > 0, at most one of x and y 0.
///
/// Within 6 ulp for arguments 0 and 1e-100 to 1e100 (measured: 5.4).
#[inline(always)]
pub fn carlson_rd<R: Real>(x: R, y: R, z: R) -> R {
    let (mut x, mut y, mut z) = (x, y, z);
    let (fifth, quarter, three, one) = (R::splat(0.2), R::splat(0.25), R::splat(3.0), R::splat(1.0));
    let (mut sum, mut scale) = (R::splat(0.0), one);
    let mut mean = z.fma(three, x + y) * fifth;
    let mut wide = apart(mean, RJ_SPREAD, [x, y, z]);
    for _ in 0..DUPLICATIONS {
        if !R::any(wide) {
            break;
        }
        let (a, b, c) = (x.sqrt(), y.sqrt(), z.sqrt());
        let shift = a.fma(b + c, b * c);
        sum = R::select(wide, sum + scale / (c * (z + shift)), sum);
        scale = R::select(wide, scale * quarter, scale);
        x = R::select(wide, (x + shift) * quarter, x);
        y = R::select(wide, (y + shift) * quarter, y);
        z = R::select(wide, (z + shift) * quarter, z);
        mean = z.fma(three, x + y) * fifth;
        wide = apart(mean, RJ_SPREAD, [x, y, z]);
    }
    let inverse = one / mean;
    let (dx, dy) = ((mean - x) * inverse, (mean - y) * inverse);
    let dz = (dx + dy) * R::splat(-1.0 / 3.0);
    let (product, square) = (dx * dy, dz * dz);
    let e2 = square.fnma(R::splat(6.0), product);
    let e3 = product.fms(three, R::splat(8.0) * square) * dz;
    let e4 = three * ((product - square) * square);
    let e5 = (product * dz) * square;
    let last = scale * inverse / mean.sqrt();
    sum.fma(three, last.fma(rj_series(e2, e3, e4, e5), last))
}

/// R_J(x, y, z, p): 3/2 of the integral of 1 / ((t + p) sqrt((t + x)(t + y)(t + z))) over t > 0; x, y, z >= 0,
/// at most one of them 0, p > 0.
///
/// Within 8 ulp for arguments 0 and 1e-100 to 1e100 (measured: 7.1). Slow if p is far above the other arguments,
/// because a duplication then only quarters the distance.
#[inline(always)]
pub fn carlson_rj<R: Real>(x: R, y: R, z: R, p: R) -> R {
    // Enough for any quotient p / max(x, y, z) in the range of doubles.
    const QUARTERINGS: usize = 1024;
    let (mut x, mut y, mut z, mut p) = (x, y, z, p);
    let (fifth, quarter, two, one) = (R::splat(0.2), R::splat(0.25), R::splat(2.0), R::splat(1.0));
    let (mut sum, mut scale) = (R::splat(0.0), one);
    let mut mean = p.fma(two, x + y + z) * fifth;
    let mut wide = apart(mean, RJ_SPREAD, [x, y, z, p]);
    for _ in 0..DUPLICATIONS + QUARTERINGS {
        if !R::any(wide) {
            break;
        }
        let (a, b, c, d) = (x.sqrt(), y.sqrt(), z.sqrt(), p.sqrt());
        let shift = a.fma(b + c, b * c);
        // R_C(1, 1 + e): e and 1 + e from products without cancellation.
        let inverse = one / ((d + a) * (d + b) * (d + c));
        let e = ((d - a) * (d - b) * (d - c)) * inverse;
        let below = (two * d) * ((p + shift) * inverse);
        let term = (scale * inverse) * rc_of_difference(one, below, e);
        sum = R::select(wide, sum + term, sum);
        scale = R::select(wide, scale * quarter, scale);
        x = R::select(wide, (x + shift) * quarter, x);
        y = R::select(wide, (y + shift) * quarter, y);
        z = R::select(wide, (z + shift) * quarter, z);
        p = R::select(wide, (p + shift) * quarter, p);
        mean = p.fma(two, x + y + z) * fifth;
        wide = apart(mean, RJ_SPREAD, [x, y, z, p]);
    }
    let inverse = one / mean;
    let (dx, dy, dz) = ((mean - x) * inverse, (mean - y) * inverse, (mean - z) * inverse);
    let dp = (dx + dy + dz) * R::splat(-0.5);
    let (product, square) = (dx * dy * dz, dp * dp);
    let e2 = square.fnma(R::splat(3.0), dx.fma(dy + dz, dy * dz));
    let e3 = dp.fma(two.fma(e2, R::splat(4.0) * square), product);
    let e4 = dp * two.fma(product, dp * square.fma(R::splat(3.0), e2));
    let e5 = product * square;
    let last = scale * inverse / mean.sqrt();
    sum.fma(R::splat(6.0), last.fma(rj_series(e2, e3, e4, e5), last))
}

/// Gauss's arithmetic-geometric mean of two numbers >= 0.
///
/// Within 4 ulp if the product and the square of the larger number are normal (measured: 3.3); 0 if a number is 0.
#[inline(always)]
pub fn agm<R: Real>(a: R, b: R) -> R {
    // The relative error of the last mean is SPREAD^2 / 16.
    const SPREAD: f64 = 1e-8;
    let (mut a, mut b) = (a, b);
    let half = R::splat(0.5);
    let mut wide = apart(a, SPREAD, [b]);
    for _ in 0..DUPLICATIONS {
        if !R::any(wide) {
            break;
        }
        let mean = (a + b) * half;
        b = R::select(wide, (a * b).sqrt(), b);
        a = R::select(wide, mean, a);
        wide = apart(a, SPREAD, [b]);
    }
    R::select(wide, R::splat(0.0), (a + b) * half)
}
