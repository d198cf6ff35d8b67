//! Elementary functions over `Real`, by polynomials; no libm, no tables.
//!
//! Kernel coefficients of sin, cos and ln: FreeBSD msun (`k_sin.c`, `k_cos.c`, `e_log.c`), Sun Microsystems 1993.

use crate::real::Real;
use std::f64::consts::{FRAC_2_PI, FRAC_PI_4, LOG2_E, SQRT_2};

/// c[0] + c[1] x + c[2] x^2 + …, by Horner's rule.
#[inline(always)]
pub(super) fn polynomial<R: Real, const N: usize>(x: R, c: [f64; N]) -> R {
    let mut sum = R::splat(c[N - 1]);
    for i in (0..N - 1).rev() {
        sum = sum.fma(x, R::splat(c[i]));
    }
    sum
}

/// (sin x - x) / x^3 as a polynomial in x^2, |x| <= pi/4.
const SIN: [f64; 6] = [
    -1.666_666_666_666_663_243_48e-1,
    8.333_333_333_322_489_461_24e-3,
    -1.984_126_982_985_794_931_34e-4,
    2.755_731_370_707_006_767_89e-6,
    -2.505_076_025_340_686_341_95e-8,
    1.589_690_995_211_550_102_21e-10,
];
/// (cos x - 1 + x^2/2) / x^4 as a polynomial in x^2, |x| <= pi/4.
const COS: [f64; 6] = [
    4.166_666_666_666_660_190_37e-2,
    -1.388_888_888_887_410_957_49e-3,
    2.480_158_728_947_672_941_78e-5,
    -2.755_731_435_139_066_330_35e-7,
    2.087_572_321_298_174_827_90e-9,
    -1.135_964_755_778_819_482_65e-11,
];

/// sin and cos of |x| <= pi/4, below 1 ulp.
#[inline(always)]
fn sincos_kernel<R: Real>(x: R) -> (R, R) {
    let z = x * x;
    let sin = (x * z).fma(polynomial(z, SIN), x);
    // 1 - z/2, with compensation of the rounding of the difference.
    let half = z * R::splat(0.5);
    let one = R::splat(1.0);
    let head = one - half;
    let cos = head + (z * z).fma(polynomial(z, COS), (one - head) - half);
    (sin, cos)
}

/// sin and cos of x + tail, |x| <= pi/4, the tail below an ulp of x; the tail is added before the last rounding.
#[inline(always)]
pub(crate) fn sincos_kernel_with_tail<R: Real>(x: R, tail: R) -> (R, R) {
    let z = x * x;
    let half = z * R::splat(0.5);
    let one = R::splat(1.0);
    let head = one - half;
    let sin = x + (x * z).fma(polynomial(z, SIN), tail * head);
    let cos = head + (z * z).fma(polynomial(z, COS), x.fnma(tail, (one - head) - half));
    (sin, cos)
}

/// The number of multiples of pi/2 in x, and the remainder as an unevaluated sum, |r| <= pi/4; pi/2 has three parts
/// (159 bits).
#[inline(always)]
fn reduced<R: Real>(x: R) -> (R, R, R) {
    const P1: f64 = std::f64::consts::FRAC_PI_2;
    const P2: f64 = 6.123_233_995_736_766e-17;
    const P3: f64 = -1.497_384_904_859_183_3e-33;
    let n = (x * R::splat(FRAC_2_PI)).round();
    let high = n * R::splat(P1);
    let low = n.fms(R::splat(P1), high);
    let a = x - high;
    let b = a - low;
    let b_error = (a - b) - low;
    // Close to a multiple of pi/2, b and n P2 cancel and either may be larger, so the difference is Knuth's exact one.
    let c = n * R::splat(P2);
    let c_low = n.fms(R::splat(P2), c);
    let r = b - c;
    let back = r - b;
    let r_error = ((b - (r - back)) - (c + back)) + (b_error - c_low);
    (n, r, n.fnma(R::splat(P3), r_error))
}

/// sin and cos of n pi/2 + r + e, where x is that sum.
#[inline(always)]
fn sincos_in_quadrant<R: Real>(x: R, n: R, r: R, e: R) -> (R, R) {
    let (s, c) = sincos_kernel_with_tail(r, e);
    // Quadrant n mod 4: odd swaps; sin changes sign with floor(n/2), cos with floor((n+1)/2).
    let (half, quarter) = (R::splat(0.5), R::splat(0.25));
    let swap = R::odd(n);
    let sin_sign = n.fms(half, quarter).round();
    let cos_sign = (n + R::splat(1.0)).fms(half, quarter).round();
    let sin = R::select(swap, c, s).neg_if_odd(sin_sign);
    let cos = R::select(swap, s, c).neg_if_odd(cos_sign);
    // Beyond 2^50 the phase of the argument is undetermined.
    let known = x.abs().lt(R::splat(1_125_899_906_842_624.0));
    let nan = R::splat(f64::NAN);
    (R::select(known, sin, nan), R::select(known, cos, nan))
}

/// sin and cos by reduction.
#[inline(always)]
fn sincos_reduced<R: Real>(x: R) -> (R, R) {
    let (n, r, e) = reduced(x);
    sincos_in_quadrant(x, n, r, e)
}

/// sin and cos, within 1 ulp for |x| <= 1e8; NaN from 2^50 on.
///
/// The reduction is skipped if no lane needs it; a lane that does not need the reduction never uses the result.
#[inline(always)]
pub fn sincos<R: Real>(x: R) -> (R, R) {
    let (sin, cos) = sincos_kernel(x);
    let large = R::splat(FRAC_PI_4).lt(x.abs());
    if R::any(large) {
        let (s, c) = sincos_reduced(x);
        (R::select(large, s, sin), R::select(large, c, cos))
    } else {
        (sin, cos)
    }
}

/// sin and cos of the unevaluated sum x + tail, the tail below an ulp of x, for the reduction of a long phase.
#[inline(always)]
pub fn sincos_of_sum<R: Real>(x: R, tail: R) -> (R, R) {
    let (n, r, e) = reduced(x);
    // An ulp of x may be many ulp of r, so the sum is split into two parts again.
    let e = e + tail;
    let sum = r + e;
    let back = sum - r;
    sincos_in_quadrant(x, n, sum, (r - (sum - back)) + (e - back))
}

/// sinh and cosh of |x| below 350, each with a small relative error.
#[inline(always)]
pub fn sinhcosh<R: Real>(x: R) -> (R, R) {
    /// (sinh x - x) / x^3 as a polynomial in x^2, |x| <= 1/2.
    const SINH: [f64; 7] = [
        1.0 / 6.0,
        1.0 / 120.0,
        1.0 / 5040.0,
        1.0 / 362_880.0,
        1.0 / 39_916_800.0,
        1.0 / 6_227_020_800.0,
        1.0 / 1_307_674_368_000.0,
    ];
    let half = R::splat(0.5);
    let size = x.abs();
    let up = exp(size) * half;
    let down = R::splat(0.25) / up;
    let z = x * x;
    let series = (x * z).fma(polynomial(z, SINH), x);
    let large = R::select(x.lt(R::splat(0.0)), down - up, up - down);
    (R::select(size.lt(half), series, large), up + down)
}

/// (sin a)/a and (1 - cos a)/a^2 as functions of z = a^2 >= 0: the two coefficients of Rodrigues' formula.
#[inline(always)]
pub fn rodrigues<R: Real>(z: R) -> (R, R) {
    let limit = R::splat(FRAC_PI_4 * FRAC_PI_4);
    let one = R::splat(1.0);
    let first = polynomial(z, SIN).fma(z, one);
    let second = polynomial(z, COS).fnma(z, R::splat(0.5));
    let large = limit.lt(z);
    if R::any(large) {
        let angle = R::select(large, z, one).sqrt();
        let (s, _) = sincos_reduced(angle);
        let (s2, _) = sincos_reduced(angle * R::splat(0.5));
        let versine = (s2 * s2) * R::splat(2.0);
        let a2 = R::select(large, z, one);
        (R::select(large, s / angle, first), R::select(large, versine / a2, second))
    } else {
        (first, second)
    }
}

/// exp, within 1 ulp; 0 below -745.2, infinity above 709.8.
#[inline(always)]
pub fn exp<R: Real>(x: R) -> R {
    const LN2_HIGH: f64 = 6.931_471_803_691_238_164_90e-1;
    const LN2_LOW: f64 = 1.908_214_929_270_587_700_02e-10;
    const TAYLOR: [f64; 12] = [
        0.5,
        1.0 / 6.0,
        1.0 / 24.0,
        1.0 / 120.0,
        1.0 / 720.0,
        1.0 / 5040.0,
        1.0 / 40320.0,
        1.0 / 362_880.0,
        1.0 / 3_628_800.0,
        1.0 / 39_916_800.0,
        1.0 / 479_001_600.0,
        1.0 / 6_227_020_800.0,
    ];
    let bounded = R::splat(710.0).min(R::splat(-746.0).max(x));
    let n = (bounded * R::splat(LOG2_E)).round();
    let a = n.fnma(R::splat(LN2_HIGH), bounded);
    let r = n.fnma(R::splat(LN2_LOW), a);
    let r_error = n.fnma(R::splat(LN2_LOW), a - r);
    let tail = (r * r).fma(polynomial(r, TAYLOR), r_error);
    let one = R::splat(1.0);
    let head = one + r;
    let y = head + (tail + (r - (head - one)));
    // Two halves, so that neither power of two leaves the normal range.
    let n1 = (n * R::splat(0.5)).round();
    (y * n1.exp2i()) * (n - n1).exp2i()
}

/// Natural logarithm of a positive normal number, within 1 ulp.
#[inline(always)]
pub fn ln<R: Real>(x: R) -> R {
    const LN2_HIGH: f64 = 6.931_471_803_691_238_164_90e-1;
    const LN2_LOW: f64 = 1.908_214_929_270_587_700_02e-10;
    const LG: [f64; 7] = [
        6.666_666_666_666_735_130e-1,
        3.999_999_999_940_941_908e-1,
        2.857_142_874_366_239_149e-1,
        2.222_219_843_214_978_396e-1,
        1.818_357_216_161_805_012e-1,
        1.531_383_769_920_937_332e-1,
        1.479_819_860_511_658_591e-1,
    ];
    let (m, e) = x.frexp();
    let one = R::splat(1.0);
    let high = R::splat(SQRT_2).lt(m);
    let k = R::select(high, e + one, e);
    let f = R::select(high, m * R::splat(0.5), m) - one;
    let s = f / (R::splat(2.0) + f);
    let z = s * s;
    let half = (f * f) * R::splat(0.5);
    let r = z * polynomial(z, LG);
    let correction = s.fma(half + r, k * R::splat(LN2_LOW));
    k * R::splat(LN2_HIGH) - ((half - correction) - f)
}

/// ln(1 + x) of -1 < x <= 0, within 3 ulp: the rounding of `1 + x` is made good (W. Kahan; N. J. Higham, *Accuracy and
/// Stability of Numerical Algorithms*, 2nd ed., SIAM 2002, section 1.14.1).
#[inline(always)]
pub fn ln_1p<R: Real>(x: R) -> R {
    let one = R::splat(1.0);
    let sum = one + x;
    R::select(sum.lt(one), ln(sum) * (x / (sum - one)), x)
}

/// exp(x) - 1 of x <= 0, within 4 ulp, in the same way.
#[inline(always)]
pub fn exp_m1<R: Real>(x: R) -> R {
    let one = R::splat(1.0);
    let bounded = R::splat(-40.0).max(x);
    let power = exp(bounded);
    R::select(power.lt(one), (power - one) * (bounded / ln(power)), bounded)
}

/// The angle of the point (x, y) from the x axis, in [-pi, pi], within 2 ulp; 0 at the origin.
///
/// The argument is reduced to |t| <= tan(pi/8) at the diagonals; kernel coefficients of msun `s_atan.c`.
#[inline(always)]
pub fn atan2<R: Real>(y: R, x: R) -> R {
    const AT: [f64; 11] = [
        3.333_333_333_333_293_180_27e-1,
        -1.999_999_999_987_648_324_76e-1,
        1.428_571_427_250_346_637_11e-1,
        -1.111_111_040_546_235_578_80e-1,
        9.090_887_133_436_506_561_96e-2,
        -7.691_876_205_044_829_994_95e-2,
        6.661_073_137_387_531_206_69e-2,
        -5.833_570_133_790_573_486_45e-2,
        4.976_877_994_615_932_360_17e-2,
        -3.653_157_274_421_691_552_70e-2,
        1.628_582_011_536_578_236_23e-2,
    ];
    const TAN_PI_8: f64 = 0.414_213_562_373_095_048_80;
    // The low parts of pi/4, pi/2 and pi, which complete the rounded numbers to 106 bits.
    const PI_4_LOW: f64 = 3.061_616_997_868_383_017_93e-17;
    let (zero, one) = (R::splat(0.0), R::splat(1.0));
    let (a, b) = (y.abs(), x.abs());
    let steep = b.lt(a);
    let (small, large) = (a.min(b), b.max(a));
    let large = R::select(zero.lt(large), large, one);
    // Near the diagonal, atan(s/l) = pi/4 - atan((l - s)/(l + s)).
    let diagonal = (R::splat(TAN_PI_8) * large).lt(small);
    let t = R::select(diagonal, small - large, small) / R::select(diagonal, small + large, large);
    let z = t * t;
    let correction = (t * z) * polynomial(z, AT);
    // The multiple of pi/4 to which the reduced angle is added, or from which the angle is subtracted.
    let base = R::select(diagonal, one, zero);
    let (base, sign) = (R::select(steep, R::splat(2.0) - base, base), R::select(steep, -one, one));
    let behind = x.lt(zero);
    let (base, sign) = (R::select(behind, R::splat(4.0) - base, base), R::select(behind, -sign, sign));
    let tail = base.fma(R::splat(PI_4_LOW), -(sign * correction));
    let angle = base.fma(R::splat(FRAC_PI_4), sign.fma(t, tail));
    R::select(y.lt(zero), -angle, angle)
}
