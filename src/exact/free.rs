//! The free asymmetric body: rates by Jacobi functions, attitude by one theta function (Jacobi 1849).
//!
//! Roles: the axes are renamed, in body and space alike, so that the moments are monotone and axis 3 is the one
//! that the polhode encircles; a renaming is exact. All differences of energy and momentum are sums of positive
//! terms (Celledoni et al. 2008, doi 10.1137/070704393; van Zon & Schofield 2007, doi 10.1016/j.jcp.2006.11.019).

use super::{Exit, Motion, exponent_near, normalised, power_near, scaled, to_next_zero, turn};
use crate::kinematics::quaternion_product;
use crate::real::Real;
use crate::special::carlson_rf;
use crate::special::theta::{Phase, Shifted, Torus, power_of_two};
use std::f64::consts::FRAC_PI_2;

/// The names of the axes, and the inverse renaming.
#[derive(Clone, Copy)]
struct Roles<R: Real> {
    /// Body axis of each role, as a number.
    axis: [R; 3],
    /// -1 where the renaming mirrors: rates are axial vectors.
    sign: R,
}

/// Whether a and b (whole numbers) are equal.
#[inline(always)]
fn same<R: Real>(a: R, b: f64) -> R::Mask {
    (a - R::splat(b)).abs().lt(R::splat(0.5))
}

impl<R: Real> Roles<R> {
    /// Exchanges two roles where the mask is true.
    #[inline(always)]
    fn exchange<const A: usize, const B: usize>(
        &mut self,
        swap: R::Mask,
        moments: &mut [R; 3],
        omega: &mut [R; 3],
    ) {
        for v in [moments, omega, &mut self.axis] {
            (v[A], v[B]) = (R::select(swap, v[B], v[A]), R::select(swap, v[A], v[B]));
        }
        self.sign = R::select(swap, -self.sign, self.sign);
    }

    /// Components by body axis from components by role.
    #[inline(always)]
    fn undo(&self, v: &[R; 3]) -> [R; 3] {
        let mut out = *v;
        for k in 0..3 {
            let component = R::select(
                same(self.axis[0], k as f64),
                v[0],
                R::select(same(self.axis[1], k as f64), v[1], v[2]),
            );
            out[k] = component * self.sign;
        }
        out
    }
}

/// `i (a - b) w^2` as a sum of two numbers.
#[inline(always)]
fn energy_product<R: Real>(i: R, a: R, b: R, w: R) -> [R; 2] {
    let difference = a - b;
    let back = a - difference;
    let difference_low = (a - (difference + back)) + (back - b);
    let first = i * difference;
    let first_low = i.fma(difference_low, i.fms(difference, first));
    let second = first * w;
    let second_low = first_low.fma(w, first.fms(w, second));
    let third = second * w;
    [third, second_low.fma(w, second.fms(w, third))]
}

/// The constants of the motion of one body.
#[derive(Clone, Copy)]
pub struct Free<R: Real> {
    roles: Roles<R>,
    /// -1 where the frames were turned by pi about role 1, so that the encircled component is positive.
    turned: R,
    /// Power of two by which rates were divided and times multiplied.
    unit: R,
    /// The torus of the motion.
    pub torus: Torus<R>,
    start: Phase<R>,
    /// Rate of the series argument.
    rate: R,
    /// Amplitudes of the direction of L in the body, by role; they contain the constants of sn, cn and dn.
    amplitude: [R; 3],
    /// Rates over components of that direction, by role.
    rates: [R; 3],
    /// From components by role to components by body axis, and from those by polar frame: renaming and signs.
    to_body: [[R; 3]; 3],
    from_polar: [[R; 3]; 3],
    /// Whether role 3 is the polar axis of the attitude, else role 1.
    polar3: R::Mask,
    /// Sense of the theta function's turning.
    sense: R,
    /// Signs of the components along roles 1 and 2 that make the phase wind forwards.
    winding: [R; 2],
    /// Sense of the circulation seen from role 3: the sign of I3 - I1.
    order: R,
    shifted: Shifted<R>,
    /// Half the secular rate about L, and half the turn of a quarter period.
    half_rate: R,
    half_turn: R,
    /// From the frame of L to space, at the start.
    frame: [R; 4],
    /// The start.
    omega: [R; 3],
    attitude: [R; 4],
}

impl<R: Real> Motion<R> for Free<R> {
    /// The moments differ, and two rates at least are not zero.
    #[inline(always)]
    fn new(moments: &[R; 3], _weight: &[R; 3], omega: &[R; 3], attitude: &[R; 4]) -> Self {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let largest = exponent_near(omega);
        let unit = largest.exp2i();
        let (_, inverse_size) = power_near(moments);
        let mut i = scaled(moments, inverse_size);
        let mut w = *omega;
        let mut roles = Roles { axis: [zero, one, R::splat(2.0)], sign: one };
        let swap = i[1].lt(i[0]);
        roles.exchange::<0, 1>(swap, &mut i, &mut w);
        let swap = i[2].lt(i[1]);
        roles.exchange::<1, 2>(swap, &mut i, &mut w);
        let swap = i[1].lt(i[0]);
        roles.exchange::<0, 1>(swap, &mut i, &mut w);
        // (L^2 - 2 E I2) (I3 - I1): its sign shows which axis the polhode encircles. All products in two parts: on the
        // separatrix it is zero, and next to it all digits count, in a unit of their own.
        let beside = exponent_near(&[w[0], w[2], zero]);
        let own = (-beside).exp2i();
        let about3 = energy_product(i[2], i[2], i[1], w[2] * own);
        let about1 = energy_product(i[0], i[1], i[0], w[0] * own);
        let distance = (about3[0] - about1[0]) + (about3[1] - about1[1]);
        let swap = distance.lt(zero);
        roles.exchange::<0, 2>(swap, &mut i, &mut w);
        let w = scaled(&w, roles.sign);
        let turned = R::select(w[2].lt(zero), -one, one);
        let w = [w[0], w[1] * turned, w[2] * turned];
        let [n1, n3] = [w[0] * own, w[2] * own];
        // So do the rates about roles 1 and 2, next to a steady rotation about role 3.
        let across = exponent_near(&[w[0], w[1], zero]);
        let own = (-across).exp2i();
        let [x1, x2] = [w[0] * own, w[1] * own];
        let (beside, across) = (beside - largest, across - largest);
        let w = scaled(&w, (-largest).exp2i());

        let [i1, i2, i3] = i;
        let inverse_span = one / (i3 - i1);
        let rho = (i3 - i2) * inverse_span;
        let rho1 = (i2 - i1) * inverse_span;
        let l = [i1 * w[0], i2 * w[1], i3 * w[2]];
        let [e2, e3] = [l[1] * w[1], l[2] * w[2]];
        let [lx1, lx2] = [i1 * x1, i2 * x2];
        let g2 = l[0].fma(l[0], l[1].fma(l[1], l[2] * l[2]));
        let g = g2.sqrt();
        // (2 E I3 - L^2) / (I3 - I1), (L^2 - 2 E I1) / (I3 - I1), (L^2 - 2 E I2) / (I3 - I1); the first and the last
        // in their units.
        let a = (lx2 * x2).fma(rho, lx1 * x1);
        let b = e2.fma(rho1, e3);
        let c = distance.abs() * inverse_span.abs();
        let inverse_rho_b = one / (rho * b);
        let m = (rho1 * a) * inverse_rho_b;
        let mc = c * inverse_rho_b;
        let inverse_g = one / g;
        let inverse_g2 = inverse_g * inverse_g;
        let a1 = (i1 * a) * inverse_g2;
        let b1 = (i3 * b) * inverse_g2;
        let a2 = ((i2 * a) * inverse_g2) / rho;
        let small = power_of_two(across);
        let small2 = small * small;
        let torus = Torus::new(m * small2, mc, beside);
        let lambda = (((i3 - i2) * (i3 - i1)) * b / ((i1 * i2) * i3)).sqrt();
        let rate = lambda * torus.scale;

        let order = R::select(i1.lt(i3), one, -one);
        let s1 = R::select(w[0].lt(zero), -one, one);
        let s2 = s1 * order;
        let [u1, u2, u3] = [a1.sqrt(), a2.sqrt(), b1.sqrt()];
        let inverse_u = one / (u1 * u2);
        let sn = ((s2 * lx2) * inverse_g) * (inverse_u * u1);
        // cn and dn in the unit of k'. One of both units at least is that of the largest rate.
        let l1 = R::select(beside.lt(zero), i1 * n1, lx1);
        let cn = (l1.abs() * inverse_g) * (inverse_u * u2);
        let dn = ((i3 * n3) * inverse_g) / u3;
        let start = torus.phase(sn, cn, dn, [torus.reduced, torus.unit]);

        // The polar axis whose theta function stays away from its zero: sc^2(eta) = b1/a1 or its complement.
        let polar3 = (m * (b1 * b1)).lt((a1 * a1) * small2);
        let over = R::select(polar3, one, m.fma(b1, a1));
        let over = one / over;
        let sn2 = R::select(polar3, b1, a1 * over);
        let cn2 = R::select(polar3, a1 * small2, (m * b1) * over);
        let eta = sn2.sqrt() * carlson_rf(cn2, (m * small2).fma(sn2, cn2), one);
        let shifted = Shifted::new::<true>(&torus, eta, one.lt(zero));
        // The rate about L seen from the polar axis is G / I_a at sn = 0: of the two ways to its mean the one
        // whose terms all have one sign, from the largest moment.
        let origin = Phase { quarters: zero, rest: zero };
        let here = torus.multiples(&origin);
        let excess = rate * shifted.rate::<true>(&torus, &origin, &here).abs();
        let difference = ((i3 - i1).abs() * g) / (i1 * i3);
        let sense = R::select(polar3, order, -order);
        let from_largest = R::select(zero.lt(sense), difference - excess, excess);
        let mean = g / i1.max(i3) + from_largest;
        let half = R::splat(0.5);
        let turn = shifted.turn - R::select(polar3, R::splat(FRAC_PI_2), zero);
        let [fs, fc, fd] = torus.quotient;
        let amplitude = [(s1 * (u1 * small)) * fc, (s2 * (u2 * small)) * fs, u3 * fd];
        let (mut to_body, mut from_polar) = ([[zero; 3]; 3], [[zero; 3]; 3]);
        for role in 0..3 {
            let mut unit_vector = [zero; 3];
            unit_vector[role] = if role == 0 { one } else { turned };
            let column = roles.undo(&unit_vector);
            for k in 0..3 {
                to_body[k][role] = column[k];
            }
        }
        for k in 0..3 {
            let [r1, r2, r3] = to_body[k];
            // Polar, next, last axis: roles 3, 1, 2 or 1, 2, 3.
            from_polar[k] = [R::select(polar3, r3, r1), R::select(polar3, r1, r2), R::select(polar3, r2, r3)];
        }
        let mut body = Free {
            roles,
            turned,
            unit,
            torus,
            start,
            rate,
            amplitude,
            rates: [(g / i1) * unit, (g / i2) * unit, (g / i3) * unit],
            to_body,
            from_polar,
            winding: [s1, s2],
            polar3,
            sense,
            order,
            shifted,
            half_rate: mean * half,
            half_turn: (sense * turn) * half,
            frame: *attitude,
            omega: *omega,
            attitude: *attitude,
        };
        let [c0, x0, y0, z0] = body.evaluate(zero, &start).1;
        body.frame = quaternion_product(attitude, &[c0, -x0, -y0, -z0]);
        body
    }

    #[inline(always)]
    fn exit(&self, question: &Exit<R>) -> R {
        let (half, never) = (R::splat(0.5), R::splat(f64::INFINITY));
        let first = (question.axis - self.roles.axis[0]).abs().lt(half);
        let third = (question.axis - self.roles.axis[2]).abs().lt(half);
        // cn vanishes at odd quarter periods, sn at even ones, dn nowhere.
        let distance = to_next_zero(&self.start, self.torus.quarter(), first);
        let time = distance / (self.rate * self.unit);
        R::select(third, never, time)
    }

    #[inline(always)]
    fn rates(&self, t: R) -> [R; 3] {
        let phase = self.torus.advance(&self.start, self.rate, t * self.unit);
        let (series, under) = self.torus.series(&phase, &self.torus.multiples(&phase));
        self.omega_of(&self.direction(&series), R::splat(1.0) / under, t)
    }

    #[inline(always)]
    fn state(&self, t: R) -> ([R; 3], [R; 4]) {
        let time = t * self.unit;
        let phase = self.torus.advance(&self.start, self.rate, time);
        let ((direction, inverse), local) = self.evaluate(time, &phase);
        let q = normalised(&quaternion_product(&self.frame, &local));
        let moved = R::splat(0.0).lt(t.abs());
        let mut attitude = self.attitude;
        for k in 0..4 {
            attitude[k] = R::select(moved, q[k], self.attitude[k]);
        }
        (self.omega_of(&direction, inverse, t), attitude)
    }
}

impl<R: Real> Free<R> {
    /// Half the period of the rates; every component that changes its sign does so once in it.
    #[inline(always)]
    pub fn half_period(&self) -> R {
        let quarter = self.torus.quarter();
        (quarter + quarter) / (self.rate * self.unit)
    }

    /// Mean rate at which the encircled axis precesses about L.
    #[inline(always)]
    pub fn precession(&self) -> R {
        let per_quarter = self.rate / self.torus.quarter();
        let mean = self.half_turn.fma(per_quarter, self.half_rate);
        (self.order * R::splat(FRAC_PI_2)).fma(per_quarter, mean + mean) * self.unit
    }

    /// Largest size of each component of the rates.
    #[inline(always)]
    pub fn amplitude(&self) -> [R; 3] {
        let [u1, u2, u3] = self.amplitude;
        let [fs, fc, fd] = self.torus.quotient;
        let [r1, r2, r3] = self.rates;
        let v = self.roles.undo(&[u1 * r1 / fc, u2 * r2 / fs, u3 * r3 / fd]);
        [v[0].abs(), v[1].abs(), v[2].abs()]
    }

    /// The body axis that the polhode encircles, 0 to 2, and the sign of the rate along it.
    #[inline(always)]
    pub fn encircled(&self) -> (R, R) {
        (self.roles.axis[2], self.turned * self.roles.sign)
    }

    /// The direction of L in the body, by role, times the series under it.
    #[inline(always)]
    fn direction(&self, [sn, cn, dn]: &[R; 3]) -> [R; 3] {
        let [u1, u2, u3] = self.amplitude;
        [u1 * *cn, u2 * *sn, u3 * *dn]
    }

    /// The rates in the body from that direction and the inverse of the series.
    #[inline(always)]
    fn omega_of(&self, v: &[R; 3], inverse: R, t: R) -> [R; 3] {
        let [r1, r2, r3] = self.rates;
        let [w1, w2, w3] = [(v[0] * r1) * inverse, (v[1] * r2) * inverse, (v[2] * r3) * inverse];
        let moved = R::splat(0.0).lt(t.abs());
        let mut omega = self.omega;
        for k in 0..3 {
            // One of the three is not zero times a component: the sum is exact.
            let [m1, m2, m3] = self.to_body[k];
            omega[k] = R::select(moved, m1.fma(w1, m2.fma(w2, m3 * w3)), self.omega[k]);
        }
        omega
    }

    /// The direction of L with the inverse of the series under it, and the attitude relative to the frame of L: the
    /// shortest turn that takes L to the polar axis, then a turn about L by an angle that is continuous in time.
    #[inline(always)]
    fn evaluate(&self, time: R, phase: &Phase<R>) -> (([R; 3], R), [R; 4]) {
        let x = self.torus.multiples(phase);
        let (series, under) = self.torus.series(phase, &x);
        let v = self.direction(&series);
        let [a, b] = self.shifted.value::<true>(&self.torus, phase, &x);
        // Seen from role 3, (v1, v2) winds around: its quarter turns are counted by the phase. From role 1,
        // (v3, v2) does not.
        let (x1, x2) = (v[0] * self.winding[0], v[1] * self.winding[1]);
        let odd = R::odd(phase.quarters);
        let half_turns = phase.quarters.fms(R::splat(0.5), R::splat(0.25)).round();
        let c = R::select(odd, x2, x1).neg_if_odd(half_turns);
        let d = R::select(odd, -x1, x2).neg_if_odd(half_turns);
        let c = R::select(self.polar3, c, v[2]);
        let d = R::select(self.polar3, d, v[1] * self.order);
        // Half of the bounded angle, as a complex number of any length; its real part is positive.
        let (re, im) = (a.fma(c, b * d), b.fms(c, a * d) * self.sense);
        let length = re.fma(re, im * im).sqrt();
        let half = length + re;
        let (sin, cos) = turn(&[(self.half_rate, time), (self.half_turn, phase.quarters)], R::splat(0.0));
        let (cos, sin) = (cos.fms(half, sin * im), cos.fma(im, sin * half));

        let along = R::select(self.polar3, v[2], v[0]);
        let next = R::select(self.polar3, v[0], v[1]);
        let last = R::select(self.polar3, v[1], v[2]);
        let sum = under + along;
        // |(half, im)|^2 = 2 length half and |(sum, last, -next)|^2 = 2 under sum. (Two roots, because the product
        // of the four leaves the range of doubles near a separatrix.)
        let two = R::splat(2.0);
        let scale = R::splat(1.0) / ((two * (length * half)).sqrt() * (two * (under * sum)).sqrt());
        let (cos, sin) = (cos * scale, sin * scale);
        let polar = [sin * sum, cos.fma(last, sin * next), sin.fms(last, cos * next)];
        let mut local = [cos * sum; 4];
        for k in 0..3 {
            let [m1, m2, m3] = self.from_polar[k];
            local[k + 1] = m1.fma(polar[0], m2.fma(polar[1], m3 * polar[2]));
        }
        ((v, R::splat(1.0) / under), local)
    }
}
