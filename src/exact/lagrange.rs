//! The Lagrange top, symmetric with its centre of mass on the axis: each Cayley-Klein parameter is a constant, a
//! turn at a constant rate and a quotient of theta functions (Klein & Sommerfeld, Theorie des Kreisels, ch. VI).
//!
//! `alpha = q0 + i q3`, `beta = q1 + i q2`; with `w = 1 - cos theta`, `|beta|^2 = w/2`, `|alpha|^2 = 1 - w/2`.
//! Each has one pole of the top as its zero and passes it smoothly: no angle is ever formed.

use super::{Exit, Motion, exponent_near, normalised, power_near, scaled, turn};
use crate::real::Real;
use crate::special::carlson_rf;
use crate::special::theta::{Phase, Shifted, Torus};

/// Whether an upright top falls: its spin is below that of the sleeping top.
pub fn falls([across, along]: [f64; 2], weight: f64, spin: f64) -> bool {
    let (_, inverse_size) = power_near(&[across, along, 0.0]);
    let [across, along, weight] = [across, along, weight.abs()].map(|x| x * inverse_size);
    let (_, inverse_unit) = power_near(&[(weight / across).sqrt(), spin, 0.0]);
    let weight = weight * inverse_unit * inverse_unit;
    0.0 < margin_of(4.0 * across, weight, along, spin * inverse_unit)
}

/// Exponent below which a tilt and rates across the axis have a unit of their own: fourth powers of larger ones are in the
/// range of doubles with all their digits.
const TINY: f64 = -200.0;

/// The larger part.
#[inline(always)]
fn largest<R: Real>(v: [R; 2]) -> R {
    v[0].abs().max(v[1].abs())
}

/// The square of the length.
#[inline(always)]
fn squared<R: Real>(v: [R; 2]) -> R {
    v[0].fma(v[0], v[1] * v[1])
}

/// How far an angle with this 1 - cos and 1 + cos is above another; below the horizontal the latter has the digits.
#[inline(always)]
fn above<R: Real>(angle: [R; 2], other: [R; 2]) -> R {
    let low = R::splat(1.0).lt(angle[0]);
    R::select(low, other[1] - angle[1], angle[0] - other[0])
}

/// a b - (c d)^2 with products that are not rounded before the difference.
#[inline(always)]
fn margin_of<R: Real>(a: R, b: R, c: R, d: R) -> R {
    let (left, momentum) = (a * b, c * d);
    let (left_low, momentum_low) = (a.fms(b, left), c.fms(d, momentum));
    let right = momentum * momentum;
    let right_low = (momentum + momentum).fma(momentum_low, momentum.fms(momentum, right));
    (left - right) + (left_low - right_low)
}

/// a b, complex.
#[inline(always)]
fn product<R: Real>(a: [R; 2], b: [R; 2]) -> [R; 2] {
    [a[0].fms(b[0], a[1] * b[1]), a[0].fma(b[1], a[1] * b[0])]
}

/// a / b, complex.
#[inline(always)]
fn over<R: Real>(a: [R; 2], b: [R; 2]) -> [R; 2] {
    let inverse = R::splat(1.0) / b[0].fma(b[0], b[1] * b[1]);
    [a[0].fma(b[0], a[1] * b[1]) * inverse, a[1].fms(b[0], a[0] * b[1]) * inverse]
}

/// The turning points: `w` and `2 - w` there, and their distances, each with its own relative accuracy.
#[derive(Clone, Copy)]
pub struct TurningPoints<R> {
    /// Roots wa <= wb of the cubic between which w moves, and wc <= 0.
    pub w: [R; 3],
    /// 2 - wa and 2 - wb.
    pub rest: [R; 2],
    /// sqrt(wa).
    pub root: R,
    /// wa and wc over the square of the unit of the start.
    reduced: [R; 2],
    /// wb - wa, and wa - wc over the square of the unit.
    amplitude: R,
    gap: R,
    /// Displacements of wa and wb from the start, and the distance of the start from wc; the outer two over the square of
    /// the unit.
    displacement: [R; 3],
}

/// The start of a top, in the variables of its cubic.
#[derive(Clone, Copy)]
struct Start<R> {
    i1: R,
    weight: R,
    /// 1 - cos theta and 1 + cos theta.
    w: R,
    rest: R,
    /// dw/dt.
    slope: R,
    /// Spin momentum a = I3 omega3, and p_phi + a.
    spin: R,
    bottom: R,
    /// omega1^2 + omega2^2, and omega . gamma without its third term.
    transverse2: R,
    lift: R,
    /// 4 I1 mgl - a^2, the distance from the threshold of the sleeping top.
    margin: R,
    /// The unit of tilt and rates across the axis: less than one for an upright top that is about to fall, with numbers
    /// whose squares are below the range of doubles; else one.
    unit: R,
    /// w, dw/dt, p_phi - a and omega1^2 + omega2^2 over the square of the unit.
    reduced: [R; 4],
}

impl<R: Real> Start<R> {
    /// Roots of the cubic of w, for the displacement from the start, so that a turning point at the start is a
    /// root exactly; near a pole the roots follow from the conserved momentum that keeps the top off it.
    #[inline(always)]
    fn turning_points(&self) -> TurningPoints<R> {
        let (zero, one, half, two) = (R::splat(0.0), R::splat(1.0), R::splat(0.5), R::splat(2.0));
        let Start { i1, weight, w, rest, slope, spin, bottom, transverse2, lift, margin, .. } = *self;
        let [own_w, own_slope, top, own_transverse2] = self.reduced;
        let tiny = self.unit.lt(one);
        let unit2 = self.unit * self.unit;
        let k = (i1 + i1) * weight;
        let inverse_k = one / k;
        let cosine = (rest - w) * half;
        let is = i1 * slope;
        // (yb - y)(y - ya)(y - yc) = -y^3 + f2 y^2 + f1 y + f0.
        let f0 = (is * is) * inverse_k;
        let f1 = w.fma(rest, ((i1 * transverse2).fms(cosine, spin * lift)) / weight);
        let f2 = (-(i1 * transverse2)).fma(i1, -(two * (k * w)) + margin) * inverse_k;
        // The isolated outer root, from x^3 - 3 x = 2 rho on [sqrt 3, 2] about the centre.
        let third = R::splat(1.0 / 3.0);
        let centre = f2 * third;
        let p = (centre.fma(centre, f1 * third)).max(zero);
        let value = (f2 - centre).fma(centre, f1).fma(centre, f0);
        let above = zero.lt(value);
        let size = p.sqrt();
        let rho2 = R::select(zero.lt(p), value.abs() / R::select(zero.lt(p), p * size, one), zero)
            .min(R::splat(2.0));
        let mut x = rho2.fma(R::splat(0.133_974_596_215_561_35), R::splat(1.732_050_807_568_877_2));
        for _ in 0..3 {
            let x2 = x * x;
            x = (x2 * (x + x)).fma(one, rho2) / (R::splat(3.0) * (x2 - one));
        }
        let far = size * x;
        let mut alone = centre + R::select(above, far, -far);
        for _ in 0..2 {
            let now = (f2 - alone).fma(alone, f1).fma(alone, f0);
            let rate = (f2 + (f2 - R::splat(3.0) * alone)).fma(alone, f1);
            let steep = zero.lt(rate.abs());
            alone = alone - R::select(steep, now / R::select(steep, rate, one), zero);
        }
        // With a turning point at the start one root is 0: Newton's steps towards it end in a residue.
        let residue = R::select(zero.lt(f0), zero, size * R::splat(1e-20));
        alone = R::select(alone.abs().lt(residue), zero, alone);
        alone = R::select(above, alone.max(zero), alone.min(zero));
        // Deflation from the end that does not cancel.
        let cubed = (alone * alone) * alone;
        let backward = f0.lt(cubed.abs());
        let divisor = one / R::select(backward, alone, one);
        let product_back = f0 * divisor;
        let sum = R::select(backward, -((f1 + product_back) * divisor), f2 - alone);
        let product = R::select(backward, product_back, alone.fnma(sum, -f1));
        let root = sum.fma(sum, R::splat(-4.0) * product).max(zero).sqrt();
        // The other two: the larger in size first, the other from the product.
        let low = (sum - root) * half;
        let high = (sum + root) * half;
        let positive = zero.lt(sum);
        let larger = R::select(positive, high, low);
        let some = zero.lt(larger.abs());
        let other = R::select(some, product / R::select(some, larger, one), zero);
        let (low, high) = (R::select(positive, other, low), R::select(positive, high, other));
        let mut yc = R::select(above, low, alone).min(zero);
        let mut ya = R::select(above, high, low).min(zero);
        let mut yb = R::select(above, alone, high).max(zero);
        let mut gap = R::select(above, root, ya - yc);
        let (mut wa, mut wb, mut wc) = ((w + ya).max(zero), w + yb, (w + yc).min(zero));
        let (mut rest_a, mut rest_b) = (rest - ya, (rest - yb).max(zero));
        // Near the top, wa and wc from their product, -b^2 / (k wb), and their sum; with b = 0 one of them is 0.
        let no_b = R::select(zero.lt(top.abs()), zero, one);
        let close = R::select(wa.lt(R::splat(0.1)), one, zero);
        let within = R::select((wa + wa).lt(w), one, no_b);
        let near = half.lt(R::select(tiny, one, close * within));
        let inverse_b = one / R::select(near, wb, one);
        let energy = (i1 * half).fms(own_transverse2, weight * own_w);
        let pi = -((top * top) * (inverse_k * inverse_b));
        let c1 = ((R::splat(4.0) * i1).fms(energy, (spin + spin) * top)) * inverse_k;
        let s = -((c1 + pi * unit2) * inverse_b);
        let r = s.fma(s, R::splat(-4.0) * pi).sqrt();
        let positive = zero.lt(s);
        let larger = R::select(positive, s + r, s - r) * half;
        let some = zero.lt(larger.abs());
        let other = R::select(some, pi / R::select(some, larger, one), zero);
        let top_a = R::select(positive, larger, other).max(zero);
        let top_c = R::select(positive, other, larger).min(zero);
        // A turning point at the start remains a turning point.
        let off = half.lt(R::select(near, R::select((top_a + top_a).lt(w), one, zero), zero));
        (wa, ya) = (R::select(off, top_a, wa), R::select(off, top_a - w, ya));
        rest_a = R::select(off, R::splat(2.0) - top_a, rest_a);
        (wc, yc) = (R::select(near, top_c, wc), R::select(near, top_c - w, yc));
        gap = R::select(near, R::select(off, r, wa - top_c), gap);
        // All of a tiny tilt is of second order, and the displacement of wa follows from f0, the product of all three.
        let own_slope = i1 * own_slope;
        let to_c = R::select(zero.lt(own_w - top_c), own_w - top_c, one);
        let own_ya = -((own_slope * own_slope) * (inverse_k * inverse_b)) / to_c;
        (wa, ya) = (R::select(tiny, top_a * unit2, wa), R::select(tiny, own_ya, ya));
        (wc, yc) = (R::select(tiny, top_c * unit2, wc), R::select(tiny, top_c - own_w, yc));
        gap = R::select(tiny, r, gap);
        // If wc is small beside wa, the product determines wc.
        let beside = half.lt(R::select(near, zero, R::select((-(wc + wc)).lt(wa), one, zero)));
        let product = -((top * top) * inverse_k) / R::select(beside, wa * wb, one);
        (wc, yc) = (R::select(beside, product, wc), R::select(beside, product - w, yc));
        gap = R::select(beside, wa - product, gap);
        // Near the bottom, 2 - wb from b2.
        let no_b2 = R::select(zero.lt(bottom.abs()), zero, one);
        let close = R::select(rest_b.lt(R::splat(0.1)), one, no_b2);
        let within = R::select((rest_b + rest_b).lt(rest), one, no_b2);
        let near = half.lt(close * within);
        let under = (bottom * bottom) / (k * (rest_a * (two - wc)));
        let off = half.lt(R::select(near, R::select((under + under).lt(rest), one, no_b2), zero));
        rest_b = R::select(near, under, rest_b);
        wb = R::select(near, two - under, wb);
        yb = R::select(off, rest - under, yb);
        let amplitude = yb - ya * unit2;
        let reduced = [R::select(tiny, top_a, wa), R::select(tiny, top_c, wc)];
        let root = reduced[0].sqrt() * self.unit;
        let (w, rest, displacement) = ([wa, wb, wc], [rest_a, rest_b], [ya, yb, yc]);
        TurningPoints { w, rest, root, reduced, amplitude, gap, displacement }
    }
}

/// One Cayley-Klein parameter: `c exp(i (rate t + turn n)) theta(x + i y) / theta(x)`, n the quarter periods.
#[derive(Clone, Copy)]
struct Parameter<R: Real> {
    shifted: Shifted<R>,
    /// -1 where the function turns clockwise.
    sense: R,
    rate: R,
    constant: [R; 2],
}

impl<R: Real> Parameter<R> {
    /// Value and time derivative, without the constant.
    #[inline(always)]
    fn bare<const ALTERNATE: bool>(
        &self,
        torus: &Torus<R>,
        phase_rate: R,
        time: R,
        phase: &Phase<R>,
        x: &crate::special::theta::Multiples<R>,
    ) -> [[R; 2]; 2] {
        let ([a, b], [da, db]) = self.shifted.quotient::<ALTERNATE>(torus, phase, x);
        let (sin, cos) =
            turn(&[(self.rate, time), (self.sense * self.shifted.turn, phase.quarters)], R::splat(0.0));
        let (b, db) = (b * self.sense, db * self.sense);
        let slope = [phase_rate.fms(da, self.rate * b), phase_rate.fma(db, self.rate * a)];
        [product([cos, sin], [a, b]), product([cos, sin], slope)]
    }

    /// Value and time derivative.
    #[inline(always)]
    fn at<const ALTERNATE: bool>(
        &self,
        torus: &Torus<R>,
        phase_rate: R,
        time: R,
        phase: &Phase<R>,
        x: &crate::special::theta::Multiples<R>,
    ) -> [[R; 2]; 2] {
        let [value, slope] = self.bare::<ALTERNATE>(torus, phase_rate, time, phase, x);
        [product(self.constant, value), product(self.constant, slope)]
    }
}

/// The constants of the motion of one top.
#[derive(Clone, Copy)]
pub struct Lagrange<R: Real> {
    /// Power of two by which rates were divided and times multiplied.
    unit: R,
    /// -1 where the frame was turned by pi about axis 1, because the centre of mass lies on -axis 3.
    turned: R,
    /// The torus of the nutation; w = wb at the phase 0.
    pub torus: Torus<R>,
    /// Phase at the start.
    start: Phase<R>,
    /// Rate of the series argument.
    rate: R,
    /// Turning points of the nutation.
    pub points: TurningPoints<R>,
    /// 1 - cos theta and 1 + cos theta at the start.
    at_start: [R; 2],
    momenta: [R; 2],
    spin: R,
    /// Sum of the rates of alpha and beta.
    precession: R,
    alpha: Parameter<R>,
    beta: Parameter<R>,
    omega: [R; 3],
    attitude: [R; 4],
}

impl<R: Real> Lagrange<R> {
    /// Period of the nutation.
    #[inline(always)]
    pub fn period(&self) -> R {
        let quarter = self.torus.quarter();
        (quarter + quarter) / (self.rate * self.unit)
    }

    /// The rate at which the top leaves the saddle of its nutation; exact at the separatrix, a bound beside it.
    #[inline(always)]
    pub fn saddle_exponent(&self) -> R {
        self.rate / self.torus.scale * self.unit
    }

    /// Phase at the start, in units of the argument: 0 at the largest tilt, falling from there.
    #[inline(always)]
    fn phase_at_start(&self) -> R {
        let (zero, quarters) = (R::splat(0.0), self.start.quarters);
        R::select(zero.lt(quarters.abs()), quarters * self.torus.quarter(), zero) + self.start.rest
    }

    /// First time of the least and of the largest tilt.
    #[inline(always)]
    pub fn turning_times(&self) -> [R; 2] {
        let (zero, quarter) = (R::splat(0.0), self.torus.quarter());
        let phase = self.phase_at_start();
        let to_largest = R::select(zero.lt(phase), (quarter + quarter) - phase, -phase);
        [quarter - phase, to_largest].map(|distance| distance / (self.rate * self.unit))
    }

    /// p_phi - p_psi and p_psi, in the units of the set-up.
    #[inline(always)]
    pub fn momenta(&self) -> [R; 2] {
        self.momenta
    }

    /// 1 - cos theta and 1 + cos theta at the start.
    #[inline(always)]
    pub fn at_start(&self) -> [R; 2] {
        self.at_start
    }

    /// Advance of phi and psi in a period of the nutation.
    #[inline(always)]
    pub fn advances(&self) -> [R; 2] {
        let period = self.period() * self.unit;
        let winding = |parameter: &Parameter<R>| parameter.sense * parameter.shifted.winding(&self.torus);
        let (alpha, beta) = (winding(&self.alpha), winding(&self.beta));
        let phi = self.precession.fma(period, alpha + beta);
        [phi, self.alpha.rate.fma(period, alpha) - self.beta.rate.fma(period, beta)]
    }
}

impl<R: Real> Motion<R> for Lagrange<R> {
    const RATES_ALONE: bool = false;

    /// Symmetric about axis 3 with the weight on it, not upright at rest.
    #[inline(always)]
    fn new(moments: &[R; 3], weight: &[R; 3], omega: &[R; 3], attitude: &[R; 4]) -> Self {
        let (zero, one, half) = (R::splat(0.0), R::splat(1.0), R::splat(0.5));
        let (_, inverse_size) = power_near(moments);
        let [i1, _, i3] = scaled(moments, inverse_size);
        let swing = (weight[2].abs() * inverse_size / i1).sqrt();
        let (unit, inverse_unit) = power_near(&[omega[0].abs().max(swing), omega[1], omega[2]]);
        let turned = R::select(weight[2].lt(zero), -one, one);
        let mu = ((weight[2].abs() * inverse_size) * inverse_unit) * inverse_unit;
        let w = scaled(omega, inverse_unit);
        let [w1, w2, w3] = [w[0], w[1] * turned, w[2] * turned];
        let down = turned.lt(zero);
        let [q0, q1, q2, q3] = *attitude;
        let (q0, q1, q2, q3) = (
            R::select(down, -q1, q0),
            R::select(down, q0, q1),
            R::select(down, q3, q2),
            R::select(down, -q2, q3),
        );
        let two = R::splat(2.0);
        let spin = i3 * w3;
        let margin = margin_of(i1 * R::splat(4.0), mu, i3, w3);
        // A top that falls from a tiny tilt has a unit for its tilt and its rates across the axis.
        let across = exponent_near(&[q1.abs().max(w1.abs()), q2.abs().max(w2.abs()), zero]);
        let across = R::select(across.lt(R::splat(TINY)), R::select(zero.lt(margin), across, zero), zero);
        let (own, inverse_own) = (across.exp2i(), (-across).exp2i());
        let [t1, t2, v1, v2] = scaled(&[q1, q2, w1, w2], inverse_own);
        let g1 = two * t1.fms(q3, q0 * t2);
        let g2 = two * t2.fma(q3, q0 * t1);
        let own_tilt = two * t1.fma(t1, t2 * t2);
        let rest = two * q3.fma(q3, q0 * q0);
        let own_lift = v1.fma(g1, v2 * g2);
        let own_top = i1.fms(own_lift, spin * own_tilt);
        let reduced = [own_tilt, g2.fms(v1, g1 * v2), own_top, v1.fma(v1, v2 * v2)];
        let [tilt, slope, top, transverse2] = scaled(&scaled(&reduced, own), own);
        let lift = (own_lift * own) * own;
        let start = Start {
            i1,
            weight: mu,
            w: tilt,
            rest,
            slope,
            spin,
            bottom: i1.fma(lift, spin * rest),
            transverse2,
            lift,
            margin,
            unit: own,
            reduced,
        };
        let points = start.turning_points();
        let [_, wb, wc] = points.w;
        let [own_wa, own_wc] = points.reduced;
        let [rest_a, rest_b] = points.rest;
        let [ya, yb, yc] = points.displacement;
        let extent = wb - wc;
        let inverse_extent = one / extent;
        let (m, mc) = (points.amplitude * inverse_extent, points.gap * inverse_extent);
        let torus = Torus::new(m, mc, across);
        let rate = ((mu * extent) / (i1 + i1)).sqrt() * torus.scale;
        let moving = zero.lt(points.amplitude);
        let span = one / R::select(moving, points.amplitude, one);
        let sn = R::select(moving, (yb * span).sqrt(), zero);
        let cn = R::select(moving, (-ya * span).sqrt(), one);
        let dn = ((-yc).max(zero) * inverse_extent).sqrt();
        let phase = torus.phase(R::select(zero.lt(reduced[1]), -sn, sn), cn, dn, [torus.reduced, torus.unit]);

        // The zeros of 2 - w and of w, as imaginary parts below K'/2; the odd functions have them there.
        let k = torus.moduli[0];
        let odd = (k * rest_b).lt(points.amplitude);
        let sn2 = R::select(odd, rest_b / rest_a, extent / (two - wc));
        let cn2 = R::select(odd, points.amplitude / rest_a, rest_b / (two - wc));
        let eta = sn2.sqrt() * carlson_rf(cn2, m.fma(sn2, cn2), one);
        let sense = R::select(start.bottom.lt(zero), -one, one);
        let mut alpha = Parameter {
            shifted: Shifted::new::<true>(&torus, eta, odd),
            sense: R::select(odd, -sense, sense),
            rate: zero,
            constant: [one, zero],
        };
        let (ea, ec) = (own_wa * extent, -(own_wc * points.amplitude));
        let odd = (k * ea).lt(ec);
        let parted = zero.lt(points.gap);
        let under = one / R::select(parted, points.gap, one);
        let both = R::select(odd, under / wb, under);
        let sn2 = R::select(parted, R::select(odd, ea, -own_wc) * both, zero);
        let cn2 = R::select(parted, R::select(odd, ec, own_wa) * both, one);
        let eta = sn2.sqrt() * carlson_rf(cn2, m.fma(sn2, cn2), one);
        let sense = R::select(own_top.lt(zero), -one, one);
        let mut beta = Parameter {
            shifted: Shifted::new::<false>(&torus, eta, odd),
            sense: R::select(odd, -sense, sense),
            rate: zero,
            constant: [one, zero],
        };
        // The rates of the arguments are known where w is far from the zero: at wa for alpha, at wb for beta.
        let spin_excess = ((i1 - i3) * w3) / i1;
        let at_wa = Phase { quarters: one, rest: zero };
        let at_wb = Phase { quarters: zero, rest: zero };
        let local = alpha.shifted.rate::<true>(&torus, &at_wa, &torus.multiples(&at_wa));
        let (from_bottom, alpha_own) = (start.bottom / (i1 * rest_a), alpha.sense * (rate * local));
        alpha.rate = half * (spin_excess + from_bottom) - alpha_own;
        let x_at_wb = torus.multiples(&at_wb);
        let local = beta.shifted.rate::<false>(&torus, &at_wb, &x_at_wb);
        let (from_top, beta_own) = (top / (i1 * wb), beta.sense * (rate * local));
        beta.rate = half * (from_top - spin_excess) - beta_own;
        // Their sum without the spin, whose rounding exceeds the precession of a needle.
        let precession = half * (from_bottom + from_top) - (alpha_own + beta_own);

        // The constants from the start; exactly at a pole, from the derivative.
        let x = torus.multiples(&phase);
        let (a, b) = ([q0, q3], [t1, t2]);
        let pole = R::splat(1e-100);
        let [value, slope] = alpha.bare::<true>(&torus, rate, zero, &phase, &x);
        let moved = product([q1, q2], [w1, -w2]);
        let at_bottom = largest(a).lt(pole.min(largest(moved)));
        let from =
            [R::select(at_bottom, -(moved[0] * half), a[0]), R::select(at_bottom, -(moved[1] * half), a[1])];
        let by = [R::select(at_bottom, slope[0], value[0]), R::select(at_bottom, slope[1], value[1])];
        alpha.constant = over(from, by);
        let [value, slope] = beta.bare::<false>(&torus.in_its_unit(), rate, zero, &phase, &x);
        let moved = product(a, [v1, v2]);
        let tiny = own.lt(one);
        let at_top = largest(b).lt(R::select(tiny, largest(moved), pole.min(largest(moved))));
        let from = [R::select(at_top, moved[0] * half, b[0]), R::select(at_top, moved[1] * half, b[1])];
        let by = [R::select(at_top, slope[0], value[0]), R::select(at_top, slope[1], value[1])];
        beta.constant = over(from, by);
        // From a tiny tilt only its direction; its size from the largest tilt.
        let there = beta.bare::<false>(&torus, rate, zero, &at_wb, &x_at_wb)[0];
        let size = ((wb * half) / (squared(there) * squared(beta.constant))).sqrt();
        for part in &mut beta.constant {
            *part = *part * R::select(tiny, size, one);
        }
        Lagrange {
            unit,
            turned,
            torus,
            start: phase,
            rate,
            points,
            at_start: [tilt, rest],
            momenta: [top, spin],
            spin: w3,
            precession,
            alpha,
            beta,
            omega: *omega,
            attitude: *attitude,
        }
    }

    #[inline(always)]
    fn exit(&self, question: &Exit<R>) -> R {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let never = R::splat(f64::INFINITY);
        let ([wa, wb, _], [rest_a, rest_b]) = (self.points.w, self.points.rest);
        // Where w = wa sn^2 + wb cn^2 is at the limit; it rises there before the phase 0 and falls after it.
        let up = (-above(question.limit, [wb, rest_b])).max(zero);
        let down = above(question.limit, [wa, rest_a]).max(zero);
        let span = up + down;
        let rising = zero.lt(question.direction);
        let crossed = zero.lt(R::select(rising, up, down));
        let inverse = one / R::select(crossed, span, one);
        let [m, mc] =
            [self.torus.moduli[0] * self.torus.moduli[0], self.torus.moduli[1] * self.torus.moduli[1]];
        let (sn2, cn2) = (R::select(crossed, up * inverse, zero), R::select(crossed, down * inverse, one));
        let whole = [self.torus.moduli[1], one];
        let there = self.torus.phase(sn2.sqrt(), cn2.sqrt(), m.fma(cn2, mc).sqrt(), whole);
        let quarter = self.torus.quarter();
        let sign = R::select(rising, -one, one);
        let quarters = sign.fms(there.quarters, self.start.quarters);
        let rests = sign.fms(there.rest, self.start.rest);
        let distance = R::select(zero.lt(quarters.abs()), quarters * quarter, zero) + rests;
        // A start that moves towards the limit is not past the limit, whatever the rounding.
        let phase = self.phase_at_start();
        let approaches = R::select(rising, -phase, phase);
        let wrapped = R::select(zero.lt(approaches), zero, (quarter + quarter) + distance);
        let distance = R::select(distance.lt(zero), wrapped, distance);
        let time = distance / (self.rate * self.unit);
        // Beyond the limit from the start.
        let ahead = above(question.limit, self.at_start);
        let beyond = R::select(rising, -ahead, ahead);
        R::select(zero.lt(beyond), zero, R::select(crossed, time, never))
    }

    #[inline(always)]
    fn state(&self, t: R) -> ([R; 3], [R; 4]) {
        let half = R::splat(0.5);
        let time = t * self.unit;
        let phase = self.torus.advance(&self.start, self.rate, time);
        let x = self.torus.multiples(&phase);
        let [a, da] = self.alpha.at::<true>(&self.torus, self.rate, time, &phase, &x);
        let [b, db] = self.beta.at::<false>(&self.torus, self.rate, time, &phase, &x);
        // beta' = (alpha W - i omega3 beta)/2, alpha' = (i omega3 alpha - beta conj W)/2 with W = omega1 + i omega2:
        // from the one that is not small.
        let spin = self.spin * half;
        let upper = [spin.fnma(b[1], db[0]), spin.fma(b[0], db[1])];
        let lower = [spin.fnma(a[1], -da[0]), spin.fms(a[0], da[1])];
        let high = b[0].fma(b[0], b[1] * b[1]).lt(a[0].fma(a[0], a[1] * a[1]));
        let from = [R::select(high, upper[0], lower[0]), R::select(high, upper[1], lower[1])];
        let by = [R::select(high, a[0], b[0]), R::select(high, a[1], b[1])];
        let transverse = over(from, by);
        let transverse = [transverse[0] + transverse[0], transverse[1] + transverse[1]];
        let w2 = R::select(high, transverse[1], -transverse[1]) * self.turned;
        let [q0, q1, q2, q3] = normalised(&[a[0], b[0], b[1], a[1]]);
        let down = self.turned.lt(R::splat(0.0));
        let q = [
            R::select(down, q1, q0),
            R::select(down, -q0, q1),
            R::select(down, -q3, q2),
            R::select(down, q2, q3),
        ];
        let moved = R::splat(0.0).lt(t.abs());
        let mut attitude = self.attitude;
        for i in 0..4 {
            attitude[i] = R::select(moved, q[i], self.attitude[i]);
        }
        let omega = [
            R::select(moved, transverse[0] * self.unit, self.omega[0]),
            R::select(moved, w2 * self.unit, self.omega[1]),
            self.omega[2],
        ];
        (omega, attitude)
    }
}
