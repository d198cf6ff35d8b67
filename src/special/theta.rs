//! Theta series on the rectangular torus of an elliptic motion.
//!
//! A motion with parameter `m` and complement `mc = 1 - m` is a quotient of theta functions of the phase `u`.
//! For `m <= 1/2` the theta functions are trigonometric series with the nome `q`; for `m > 1/2` Jacobi's imaginary
//! transformation gives hyperbolic series with the complementary nome. Either nome is at most `exp(-pi)`, and the phase
//! is reduced to half a quarter period, so the first omitted term of any series is below `q^14 < 1e-19` of the first
//! term. Sources: Whittaker & Watson, ch. 21; DLMF §20.2, 20.7, 20.11.

use super::carlson::carlson_rf;
use super::elementary::{ln, sincos, sincos_kernel_with_tail, sinhcosh};
use crate::real::Real;
use std::f64::consts::{FRAC_PI_2, LN_2, PI};

/// Highest multiple of the phase in a series.
const TOP: usize = 8;

/// cos and sin, or cosh and sinh, of the multiples 0 to 7 of an argument.
#[derive(Clone, Copy)]
pub struct Multiples<R> {
    even: [R; TOP],
    odd: [R; TOP],
}

impl<R: Real> Multiples<R> {
    /// cos(k x) and sin(k x).
    #[inline(always)]
    fn circular((sin, cos): (R, R)) -> Self {
        let (one, zero) = (R::splat(1.0), R::splat(0.0));
        let cos2 = (sin + sin).fnma(sin, one);
        let sin2 = (sin + sin) * cos;
        let mut x = Multiples { even: [one; TOP], odd: [zero; TOP] };
        (x.even[1], x.odd[1]) = (cos, sin);
        (x.even[2], x.odd[2]) = (cos2, sin2);
        for k in 3..TOP {
            x.even[k] = x.even[k - 2].fms(cos2, x.odd[k - 2] * sin2);
            x.odd[k] = x.odd[k - 2].fma(cos2, x.even[k - 2] * sin2);
        }
        x
    }

    /// `d_k cosh(k x)` and `d_k sinh(k x)` with their powers of the nome in a theta series: `q^(k^2/4)` for even k,
    /// `q^((k^2-1)/4)` for odd k. The products are small even if the factors overflow.
    #[inline(always)]
    fn hyperbolic(nome: R, x: R) -> Self {
        let (one, zero) = (R::splat(1.0), R::splat(0.0));
        let (sinh, cosh) = sinhcosh(x);
        let scaled = (nome * sinh) * (sinh + sinh);
        let cosh2 = scaled + nome;
        let sinh2 = (nome * sinh) * (cosh + cosh);
        let mut x = Multiples { even: [one; TOP], odd: [zero; TOP] };
        (x.even[1], x.odd[1]) = (cosh, sinh);
        (x.even[2], x.odd[2]) = (cosh2, sinh2);
        let mut power = nome;
        for k in 3..TOP {
            let (c, s) = (x.even[k - 2], x.odd[k - 2]);
            x.even[k] = power * c.fma(cosh2, s * sinh2);
            x.odd[k] = power * s.fma(cosh2, c * sinh2);
            power = power * nome;
        }
        x
    }
}

/// 2^exponent; 0 below the range of normal doubles.
#[inline(always)]
pub fn power_of_two<R: Real>(exponent: R) -> R {
    let least = R::splat(-1020.0);
    R::select(exponent.lt(least), R::splat(0.0), exponent.max(least).exp2i())
}

/// The torus of a motion: its nome and the scale of its phases.
#[derive(Clone, Copy)]
pub struct Torus<R: Real> {
    /// Whether the series are hyperbolic, `m > 1/2`, or circular.
    hyperbolic: R::Mask,
    circular: R::Mask,
    /// The smaller nome, its square root, and that over the unit of a tiny k'.
    nome: R,
    root: R,
    own_root: R,
    /// Powers of the nome by which the multiples are multiplied in a theta series; hyperbolic multiples contain them.
    power: [R; TOP],
    /// sn, cn and dn over their quotients of theta series.
    pub quotient: [R; 3],
    /// Series argument over elliptic argument: 1 / theta3(0)^2.
    pub scale: R,
    /// A quarter period in units of the series argument: pi/2, or -ln(q)/2.
    quarter: R,
    /// Rounding error of `quarter`.
    quarter_low: R,
    inverse_quarter: R,
    /// k and k', the square roots of the parameter and its complement.
    pub moduli: [R; 2],
    /// A power of two, and k' over it: a k' below the range of doubles counts in `quarter`.
    pub unit: R,
    /// k' over the unit.
    pub reduced: R,
}

/// A phase: whole quarter periods, and the rest of the series argument.
#[derive(Clone, Copy)]
pub struct Phase<R> {
    /// Quarter periods.
    pub quarters: R,
    /// Rest of the argument, relative to the nearest quarter period.
    pub rest: R,
}

impl<R: Real> Torus<R> {
    /// The torus of the parameter `m` and its complement `mc 4^exponent`, each with its own relative accuracy.
    #[inline(always)]
    pub fn new(m: R, mc: R, exponent: R) -> Self {
        let (one, half, zero) = (R::splat(1.0), R::splat(0.5), R::splat(0.0));
        let unit = power_of_two(exponent);
        let (k, reduced) = (m.sqrt(), mc.sqrt());
        let kc = reduced * unit;
        let scaled = mc;
        let mc = (mc * unit) * unit;
        let hyperbolic = mc.lt(m);
        let small = R::select(hyperbolic, mc, m);
        let modulus = R::select(hyperbolic, k, kc);
        let root = modulus.sqrt();
        // Nome by Weierstrass's series; 1 - sqrt(k') is formed from the parameter.
        let rise = one + root;
        let e = (small * half) / ((one + modulus) * (rise * rise));
        let e2 = e * e;
        let e4 = e2 * e2;
        let series = e4.fma(R::splat(1707.0), R::splat(150.0));
        let series = e4.fma(e4.fma(series, R::splat(15.0)), R::splat(2.0));
        let nome = e.fma(e4 * series, e);
        let q2 = nome * nome;
        let (q4, q6) = (q2 * q2, q2 * q2 * q2);
        let q9 = q4 * q4 * nome;
        let mut power = [one, one, nome, q2, q4, q6, q9, q6 * q6];
        for p in &mut power {
            *p = R::select(hyperbolic, one, *p);
        }
        // theta2(0) / (2 q^(1/4)), theta3(0), theta4(0).
        let null2 = q2.fma(one + q4, one);
        let null3 = R::splat(2.0).fma(nome + (q4 + q9), one);
        let null4 = R::splat(2.0).fnma(nome - (q4 - q9), one);
        let quotient = [
            null3 / R::select(hyperbolic, null4, null2),
            R::select(hyperbolic, null2, null4) / R::select(hyperbolic, null4, null2),
            R::select(hyperbolic, null2, null4) / null3,
        ];
        // On the separatrix the quarter period is infinite, so no quarter period is subtracted from a phase.
        // Next to it the series of the nome is its first term, and only the logarithm and the root have the range.
        let tiny = exponent.lt(R::splat(-200.0));
        let first = R::select(tiny, (scaled * half) / ((one + modulus) * (rise * rise)), nome);
        let own_root = first.sqrt();
        let finite = zero.lt(first);
        let logarithm = ln(R::select(finite, first, one)) * R::splat(-0.5);
        let logarithm = R::select(tiny, exponent, zero).fnma(R::splat(LN_2), logarithm);
        let endless = R::select(finite, logarithm, R::splat(f64::INFINITY));
        let quarter = R::select(hyperbolic, endless, R::splat(FRAC_PI_2));
        Torus {
            hyperbolic,
            circular: R::select(hyperbolic, one, zero).lt(half),
            nome,
            root: own_root * R::select(tiny, unit, one),
            own_root,
            power,
            quotient,
            scale: one / (null3 * null3),
            quarter,
            inverse_quarter: one / quarter,
            quarter_low: R::select(hyperbolic, zero, R::splat(6.123_233_995_736_766e-17)),
            moduli: [k, kc],
            unit,
            reduced,
        }
    }

    /// The torus with the root of the nome over its unit: functions near K keep their digits below the range of doubles.
    #[inline(always)]
    pub fn in_its_unit(&self) -> Self {
        Torus { root: self.own_root, ..*self }
    }

    /// A quarter period in units of the series argument; infinite on the separatrix.
    #[inline(always)]
    pub fn quarter(&self) -> R {
        self.quarter
    }

    /// The phase with these sn, cn >= 0 and dn, measured from the nearer end, 0 or K, so that a small distance from
    /// either end keeps its relative accuracy. cn, dn and k' are over a power of two, `unit`.
    #[inline(always)]
    pub fn phase(&self, sn: R, cn: R, dn: R, [kc, unit]: [R; 2]) -> Phase<R> {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let size = sn.abs();
        // sn^2(K/2) = 1/(1 + k').
        let far = ((cn * cn) * unit).lt((kc * size) * size);
        let inverse = one / R::select(far, dn, one);
        let c = R::select(far, (kc * size) * inverse, cn * unit);
        let d = R::select(far, kc * inverse, dn * unit);
        let s = R::select(far, cn * inverse, size);
        let argument = (s * carlson_rf(c * c, d * d, one)) * self.scale;
        let rest = R::select(far, -argument, argument);
        let quarters = R::select(far, one, zero);
        let back = sn.lt(zero);
        Phase { quarters: R::select(back, -quarters, quarters), rest: R::select(back, -rest, rest) }
    }

    /// The phase after the time `t` at this rate of the series argument; the product is not rounded before the whole
    /// quarter periods are subtracted.
    #[inline(always)]
    pub fn advance(&self, start: &Phase<R>, rate: R, t: R) -> Phase<R> {
        let product = rate * t;
        let product_low = rate.fms(t, product);
        let high = product + start.rest;
        let back = high - product;
        let low = ((product - (high - back)) + (start.rest - back)) + product_low;
        let turns = (high * self.inverse_quarter).round();
        let whole = turns * self.quarter;
        let whole = R::select(turns.abs().lt(R::splat(0.5)), R::splat(0.0), whole);
        let whole_low =
            R::select(turns.abs().lt(R::splat(0.5)), R::splat(0.0), turns.fms(self.quarter, whole));
        let rest = (high - whole) + (low - turns.fma(self.quarter_low, whole_low));
        // From 2^50 quarter periods on, a phase in doubles is undetermined.
        let known = turns.abs().lt(R::splat(1_125_899_906_842_624.0));
        Phase { quarters: start.quarters + turns, rest: R::select(known, rest, R::splat(f64::NAN)) }
    }

    /// The multiples that all series at this phase contain.
    #[inline(always)]
    pub fn multiples(&self, phase: &Phase<R>) -> Multiples<R> {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let mut x = Multiples { even: [one; TOP], odd: [zero; TOP] };
        if R::any(self.circular) {
            let (s, c) = sincos_kernel_with_tail(R::select(self.hyperbolic, zero, phase.rest), zero);
            let swap = R::odd(phase.quarters);
            let (half, quarter) = (R::splat(0.5), R::splat(0.25));
            let sin_sign = phase.quarters.fms(half, quarter).round();
            let cos_sign = (phase.quarters + one).fms(half, quarter).round();
            let sin = R::select(swap, c, s).neg_if_odd(sin_sign);
            let cos = R::select(swap, s, c).neg_if_odd(cos_sign);
            x = Multiples::circular((sin, cos));
        }
        if R::any(self.hyperbolic) {
            // On the separatrix terms below sech(170) = 1e-74 are negligible.
            let end = R::splat(170.0);
            let edge = R::select(phase.rest.lt(zero), -end, end);
            let bounded = R::select(end.lt(phase.rest.abs()), edge, phase.rest);
            let h = Multiples::hyperbolic(self.nome, R::select(self.hyperbolic, bounded, zero));
            for k in 0..TOP {
                x.even[k] = R::select(self.hyperbolic, h.even[k], x.even[k]);
                x.odd[k] = R::select(self.hyperbolic, h.odd[k], x.odd[k]);
            }
        }
        x
    }

    /// sn, cn and dn over their constants: three numerators, and a common positive denominator.
    #[inline(always)]
    pub fn series(&self, phase: &Phase<R>, x: &Multiples<R>) -> ([R; 3], R) {
        let (one, zero, two) = (R::splat(1.0), R::splat(0.0), R::splat(2.0));
        let p = &self.power;
        let th1 = p[7].fnma(x.odd[7], p[5].fma(x.odd[5], p[3].fnma(x.odd[3], x.odd[1])));
        let th2 = p[7].fma(x.even[7], p[5].fma(x.even[5], p[3].fma(x.even[3], x.even[1])));
        let (e2, e4, e6) = (p[2] * x.even[2], p[4] * x.even[4], p[6] * x.even[6]);
        let th3 = two.fma(e2 + (e4 + e6), one);
        let th4 = two.fnma(e2 - (e4 - e6), one);
        if !R::any(self.hyperbolic) {
            return ([th1, th2, th3], th4);
        }
        // A hyperbolic series after an odd number of quarter periods: functions of K + u in terms of u.
        let odd = R::odd(phase.quarters);
        let half_turns = phase.quarters.fms(R::splat(0.5), R::splat(0.25)).round();
        let half_turns = R::select(self.hyperbolic, half_turns, zero);
        let small = R::splat(4.0) * self.root;
        let sn = R::select(odd, th4, th1).neg_if_odd(half_turns);
        let cn = R::select(odd, -(small * th1), th4).neg_if_odd(half_turns);
        let dn = R::select(odd, small * th2, th3);
        let denominator = R::select(odd, th3, th2);
        let h = self.hyperbolic;
        (
            [R::select(h, sn, th1), R::select(h, cn, th2), R::select(h, dn, th3)],
            R::select(h, denominator, th4),
        )
    }

    /// The common denominator of sn, cn and dn, and its derivative.
    #[inline(always)]
    fn denominator(&self, phase: &Phase<R>, x: &Multiples<R>) -> (R, R) {
        let (one, two) = (R::splat(1.0), R::splat(2.0));
        let p = &self.power;
        // Circular: theta4. Hyperbolic: theta2 / q^(1/4), or theta3 after an odd number of quarter periods.
        let sign = R::select(self.hyperbolic, two, -two);
        let even =
            (p[2] * sign).fma(x.even[2], (p[4] * two).fma(x.even[4], (p[6] * sign).fma(x.even[6], one)));
        let slope = (p[2] * two).fma(
            x.odd[2],
            (p[4] * (sign + sign)).fma(x.odd[4], (p[6] * R::splat(6.0)).fma(x.odd[6], R::splat(0.0))),
        );
        let even_slope = slope * two;
        let odd = two * (x.even[1] + (x.even[3] + (x.even[5] + x.even[7])));
        let odd_slope = two
            * R::splat(7.0).fma(x.odd[7], R::splat(5.0).fma(x.odd[5], R::splat(3.0).fma(x.odd[3], x.odd[1])));
        let zero = R::splat(0.0);
        let between = zero.lt(R::select(self.hyperbolic, R::select(R::odd(phase.quarters), zero, one), zero));
        (R::select(between, odd, even), R::select(between, odd_slope, even_slope))
    }
}

/// A theta function of `x + iy` for real `x`, `A + iB`: its argument is an angle of rotation of a closed form.
///
/// `theta4` and `theta3` have even multiples, `theta2` and `theta1` odd multiples; `theta4` and `theta1` alternate in
/// sign.
#[derive(Clone, Copy)]
pub struct Shifted<R: Real> {
    real: [R; TOP],
    imaginary: [R; TOP],
    /// Whether the circular series has odd multiples.
    odd: R::Mask,
    /// Angle by which a hyperbolic series turns in a quarter period.
    pub turn: R,
}

impl<R: Real> Shifted<R> {
    /// The function at the imaginary elliptic argument `eta <= K'/2`: `odd` selects theta1 instead of theta4
    /// (ALTERNATE), or theta2 instead of theta3. A constant factor of modulus one is omitted.
    #[inline(always)]
    pub fn new<const ALTERNATE: bool>(torus: &Torus<R>, eta: R, odd: R::Mask) -> Self {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let y = eta * torus.scale;
        let turn = y - R::select(odd, R::splat(FRAC_PI_2), zero);
        let turn = R::select(torus.hyperbolic, turn, zero);
        let mut real = [one; TOP];
        let mut imaginary = [zero; TOP];
        if R::any(torus.hyperbolic) {
            // theta(x + iy) is a theta function of Y - iX; an odd one is a theta function of Y - pi/2 - iX, by exact
            // quarter turns.
            let x = Multiples::circular(sincos(R::select(torus.hyperbolic, y, zero)));
            for k in 1..TOP {
                let negative = (k / 2) % 2 == 1;
                let (cos, sin) = (x.even[k] + x.even[k], x.odd[k] + x.odd[k]);
                let (a, b) = if k % 2 == 1 { (sin, -cos) } else { (cos, sin) };
                real[k] = R::select(odd, if negative { -a } else { a }, cos);
                imaginary[k] = R::select(odd, if negative { -b } else { b }, sin);
            }
        }
        if R::any(torus.circular) {
            let x = Multiples::hyperbolic(torus.nome, R::select(torus.circular, y, zero));
            for k in 1..TOP {
                let negative = ALTERNATE && (k / 2) % 2 == 1;
                let (cosh, sinh) = (x.even[k] + x.even[k], x.odd[k] + x.odd[k]);
                let (a, b) = if ALTERNATE && k % 2 == 1 { (sinh, -cosh) } else { (cosh, -sinh) };
                real[k] = R::select(torus.circular, if negative { -a } else { a }, real[k]);
                imaginary[k] = R::select(torus.circular, if negative { -b } else { b }, imaginary[k]);
            }
        }
        Shifted { real, imaginary, odd, turn }
    }

    /// Angle by which the function turns in half a period.
    #[inline(always)]
    pub fn winding(&self, torus: &Torus<R>) -> R {
        // The odd circular series contains exp(-ix).
        let circular = R::select(self.odd, R::splat(-PI), R::splat(0.0));
        R::select(torus.hyperbolic, self.turn + self.turn, circular)
    }

    /// Whether the series has odd multiples at this phase.
    #[inline(always)]
    fn odd_at<const ALTERNATE: bool>(&self, torus: &Torus<R>, phase: &Phase<R>) -> R::Mask {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let (even, odd) = if ALTERNATE { (one, zero) } else { (zero, one) };
        let hyperbolic = R::select(R::odd(phase.quarters), odd, even);
        zero.lt(R::select(torus.hyperbolic, hyperbolic, R::select(self.odd, one, zero)))
    }

    /// Whether the series has odd multiples in some lane; used only to skip work that no lane needs.
    #[inline(always)]
    fn any_odd(&self, torus: &Torus<R>) -> bool {
        R::any(torus.hyperbolic) || R::any(self.odd)
    }

    /// Real and imaginary part.
    #[inline(always)]
    pub fn value<const ALTERNATE: bool>(
        &self,
        torus: &Torus<R>,
        phase: &Phase<R>,
        x: &Multiples<R>,
    ) -> [R; 2] {
        let (a, b) = (&self.real, &self.imaginary);
        let even_real = a[6].fma(x.even[6], a[4].fma(x.even[4], a[2].fma(x.even[2], a[0])));
        let even_imaginary = b[6].fma(x.odd[6], b[4].fma(x.odd[4], b[2] * x.odd[2]));
        if !self.any_odd(torus) {
            return [even_real, even_imaginary];
        }
        let odd = self.odd_at::<ALTERNATE>(torus, phase);
        let odd_real = a[7].fma(x.even[7], a[5].fma(x.even[5], a[3].fma(x.even[3], a[1] * x.even[1])));
        let odd_imaginary = b[7].fma(x.odd[7], b[5].fma(x.odd[5], b[3].fma(x.odd[3], b[1] * x.odd[1])));
        [R::select(odd, odd_real, even_real), R::select(odd, odd_imaginary, even_imaginary)]
    }

    /// Derivatives of real and imaginary part.
    #[inline(always)]
    fn slope<const ALTERNATE: bool>(&self, torus: &Torus<R>, phase: &Phase<R>, x: &Multiples<R>) -> [R; 2] {
        let (a, b) = (&self.real, &self.imaginary);
        let odd = self.odd_at::<ALTERNATE>(torus, phase);
        let (n2, n3, n4) = (R::splat(2.0), R::splat(3.0), R::splat(4.0));
        let (n5, n6, n7) = (R::splat(5.0), R::splat(6.0), R::splat(7.0));
        let even_real = (n6 * a[6]).fma(x.odd[6], (n4 * a[4]).fma(x.odd[4], (n2 * a[2]) * x.odd[2]));
        let odd_real =
            (n7 * a[7]).fma(x.odd[7], (n5 * a[5]).fma(x.odd[5], (n3 * a[3]).fma(x.odd[3], a[1] * x.odd[1])));
        let even_imaginary = (n6 * b[6]).fma(x.even[6], (n4 * b[4]).fma(x.even[4], (n2 * b[2]) * x.even[2]));
        let odd_imaginary = (n7 * b[7])
            .fma(x.even[7], (n5 * b[5]).fma(x.even[5], (n3 * b[3]).fma(x.even[3], b[1] * x.even[1])));
        let real = R::select(odd, odd_real, even_real);
        // (cos)' = -sin, (cosh)' = sinh.
        [R::select(torus.hyperbolic, real, -real), R::select(odd, odd_imaginary, even_imaginary)]
    }

    /// Rate of the argument of the function, per unit of the series argument.
    #[inline(always)]
    pub fn rate<const ALTERNATE: bool>(&self, torus: &Torus<R>, phase: &Phase<R>, x: &Multiples<R>) -> R {
        let [a, b] = self.value::<ALTERNATE>(torus, phase, x);
        let [da, db] = self.slope::<ALTERNATE>(torus, phase, x);
        db.fms(a, da * b) / a.fma(a, b * b)
    }

    /// The function over the denominator of sn, cn and dn, and the derivative of this quotient.
    #[inline(always)]
    pub fn quotient<const ALTERNATE: bool>(
        &self,
        torus: &Torus<R>,
        phase: &Phase<R>,
        x: &Multiples<R>,
    ) -> ([R; 2], [R; 2]) {
        let value = self.value::<ALTERNATE>(torus, phase, x);
        let slope = self.slope::<ALTERNATE>(torus, phase, x);
        let (denominator, denominator_slope) = torus.denominator(phase, x);
        let one = R::splat(1.0);
        let mut inverse = one / denominator;
        let decay = denominator_slope * inverse;
        if !ALTERNATE {
            // After an odd number of quarter periods the quotient contains the square root of the nome.
            let factor = R::select(R::odd(phase.quarters), torus.root, one);
            inverse = inverse * R::select(torus.hyperbolic, factor, one);
        }
        let quotient = [value[0] * inverse, value[1] * inverse];
        let rate = [quotient[0].fnma(decay, slope[0] * inverse), quotient[1].fnma(decay, slope[1] * inverse)];
        (quotient, rate)
    }
}
