//! Jacobi's elliptic functions and their quarter period, from the complementary parameter mc = 1 - m.
//!
//! The functions depend on mc, because near the separatrix mc is known and 1 - m is not.

use super::carlson::agm;
use super::elementary::{ln, sincos, sinhcosh};
use crate::real::Real;
use std::f64::consts::{FRAC_PI_2, LN_2};

/// The nome of the parameter `small` <= 1/2, with relative accuracy even for a tiny parameter; `large` = 1 - `small`.
///
/// DLMF 19.5.6 and 19.5.7, with 1 - sqrt(k') written without cancellation; the first omitted term is 1707 e^17 < 3e-19
/// e.
#[inline(always)]
fn nome<R: Real>(small: R, large: R) -> R {
    let (one, half) = (R::splat(1.0), R::splat(0.5));
    let modulus = large.sqrt();
    let sum = one + modulus.sqrt();
    let e = (small * half) / ((one + modulus) * (sum * sum));
    let e2 = e * e;
    let e4 = e2 * e2;
    let series = e4.fma(e4.fma(R::splat(150.0), R::splat(15.0)), R::splat(2.0));
    e.fma(e4 * series, e)
}

/// theta1(z) / (2 q^(1/4) sin z), theta2(z) / (2 q^(1/4) cos z), theta3(z) and theta4(z), from q and
/// d = 2 q cos 2z.
///
/// The powers of q that multiply cos 4z and cos 6z are contained in d, so that no imaginary z overflows. The error is
/// 1e-17 for q <= exp(-pi) and z real, or imaginary up to a quarter of the period.
#[inline(always)]
fn thetas<R: Real>(q: R, d: R) -> [R; 4] {
    let (one, two, three) = (R::splat(1.0), R::splat(2.0), R::splat(3.0));
    let (q2, d2) = (q * q, d * d);
    let q4 = q2 * q2;
    let (q6, q8) = (q2 * q4, q4 * q4);
    let even = q4.fma(d2, q2.fnma(q4, -q2)) + (q2 * q8) * (q2 - d2);
    let odd = (q * d) * q8.fma(two.fnma(q2, d2), one - q4);
    let even3 = q2.fma(d2, -(two * q4));
    let odd3 = d * q6.fma(three.fnma(q2, d2), one);
    [one + (even - odd), one + (even + odd), one + (even3 + odd3), one + (even3 - odd3)]
}

/// Below this mc the nome is computed from mc times a power of two.
const TINY: f64 = f64::from_bits(123_u64 << 52); // 2^-900
const RAISED: f64 = f64::from_bits((1023 + 200) << 52);

/// (sn, cn, dn) at `u`, for mc in 0 ..= 1.
///
/// Each is within 5 ulp of its value at an argument within 4 roundings (2^-53) of `u`, also close to a zero. Values below
/// sech(708) = 7e-308 are 0. NaN from 2^50 (quarter periods, if m > 1/2) on.
#[inline(always)]
pub fn jacobi<R: Real>(u: R, mc: R) -> (R, R, R) {
    let (zero, half, one, four) = (R::splat(0.0), R::splat(0.5), R::splat(1.0), R::splat(4.0));
    // Jacobi's imaginary transformation where the complementary nome is the smaller.
    let hyperbolic = mc.lt(half);
    let m = one - mc;
    let q = nome(R::select(hyperbolic, mc, m), R::select(hyperbolic, m, mc));
    let [_, null2, null3, null4] = thetas(q, q + q);
    // u / theta3^2 with the rounding of an exact theta3: only the distance of theta3 from 1 is rounded.
    let shrink = ((null3 - one) * (null3 + one)) / (null3 * null3);
    let z = shrink.fnma(u, u);
    // Whole quarter periods are removed here if the series are hyperbolic, in the sine if the series are circular; on
    // the separatrix there are none.
    let counted = R::select(hyperbolic, R::select(zero.lt(mc), one, zero), zero);
    let endless = R::select(hyperbolic, one - counted, zero);
    // The nome of a tiny mc is mc / 16, perhaps below the range of normal doubles.
    let tiny = mc.lt(R::splat(TINY));
    let normal = R::select(tiny, (mc * R::splat(RAISED)).max(R::splat(f64::MIN_POSITIVE)), q);
    let logarithm = ln(normal) - R::select(tiny, R::splat(204.0 * LN_2), zero);
    let quarter = logarithm * R::splat(-0.5);
    let turns = counted * (z / quarter).round();
    let known = turns.abs().lt(R::splat(1_125_899_906_842_624.0));
    let rest = R::select(known, turns.fnma(quarter, z), R::splat(f64::NAN));
    let (mut s, mut c) = sincos(R::select(hyperbolic, zero, z));
    let mut square = s * s;
    if R::any(hyperbolic) {
        let limit = R::select(half.lt(endless), R::splat(708.0), R::splat(350.0));
        let (sinh, cosh) = sinhcosh((-limit).max(limit.min(R::select(hyperbolic, rest, zero))));
        s = R::select(hyperbolic, sinh, s);
        c = R::select(hyperbolic, cosh, c);
        square = R::select(hyperbolic, R::select(half.lt(endless), zero, -(sinh * sinh)), square);
    }
    let [t1, t2, t3, t4] = thetas(q, q * four.fnma(square, R::splat(2.0)));
    let (t1, t2) = (s * t1, c * t2);
    // DLMF 22.2.4 to 22.2.6, and the same functions shifted by K, where k' over theta2^2 is replaced by 4 sqrt(q).
    let after_odd = R::odd(turns);
    let root = R::select(tiny, mc.sqrt(), four * q.sqrt());
    let (upper, lower) = (R::select(hyperbolic, null2, null4), R::select(hyperbolic, null4, null2));
    let denominator = R::select(after_odd, t3, R::select(hyperbolic, t2, t4));
    let sn = R::select(after_odd, t4, t1);
    let cn = R::select(after_odd, -(root * t1), R::select(hyperbolic, t4, t2));
    let dn = R::select(after_odd, root * t2, t3);
    let half_turns = turns.fms(half, R::splat(0.25)).round();
    let gone = half.lt(R::select(R::splat(708.0).lt(z.abs()), endless, zero));
    (
        ((null3 * sn) / (lower * denominator)).neg_if_odd(half_turns),
        R::select(gone, zero, ((upper * cn) / (lower * denominator)).neg_if_odd(half_turns)),
        R::select(gone, zero, (upper * dn) / (null3 * denominator)),
    )
}

/// Complete integral of the first kind, the quarter period of sn; infinite for mc = 0.
///
/// Within 5 ulp (measured: 4.5).
#[inline(always)]
pub fn complete_k<R: Real>(mc: R) -> R {
    R::splat(FRAC_PI_2) / agm(R::splat(1.0), mc.sqrt())
}
