//! Damping of any strength: it acts by its exponential, whatever the step.
//!
//! In the modes of the damping, `v = G L` with `G = V^T I^(-1/2)`, `v' = -rates v + G torque`. The splitting solves this
//! for a torque that is frozen with the attitude; the exponential Runge-Kutta method corrects for its change.

use super::splitting::turn;
use super::{Affine, Etd4, Facts, Form, Numbers, Scheme, kinetic_of_rates, momentum_of_rates};
use crate::model::{Drive, Layout, Model, Parameters, cross, direction, dot};
use crate::real::Real;
use crate::special::{exp, rodrigues};
use std::marker::PhantomData;

impl Etd4 {
    /// What it promises.
    pub const FACTS: Facts = Facts {
        name: "etd4",
        title: "exponential Runge-Kutta of stiff order 4 for damping of any strength; without damping it is rk4",
        order: 4,
        stages: 5,
        symplectic: false,
        reversible: false,
        group_preserving: false,
        angle_per_step: 1.0 / 16.0,
        citation: "M. Hochbruck, A. Ostermann, Explicit exponential Runge-Kutta methods for semilinear parabolic \
                   problems, SIAM J. Numer. Anal. 43 (2005) 1069-1090; attitude in Lie coordinates: H. Munthe-Kaas, \
                   Runge-Kutta methods on Lie groups, BIT 38 (1998) 92-111",
        doi: "10.1137/040611434",
    };
}

/// phi_0 = exp, ..., phi_4, with `phi_(k+1)(z) = (phi_k(z) - 1/k!) / z`.
#[inline(always)]
pub fn phi<R: Real>(z: R) -> [R; 5] {
    // Below 2 the series of phi_4 and the recurrence downward: upward the differences would cancel.
    const SERIES: [f64; 22] = {
        let (mut all, mut factorial, mut k) = ([0.0; 22], 24.0, 0);
        while k < 22 {
            all[k] = 1.0 / factorial;
            factorial *= (k + 5) as f64;
            k += 1;
        }
        all
    };
    const INVERSE: [f64; 4] = [1.0, 1.0, 0.5, 1.0 / 6.0];
    let (one, bound) = (R::splat(1.0), R::splat(700.0));
    let small = z.abs().lt(R::splat(2.0));
    let near = R::select(small, z, one);
    let far = R::select(small, one, z);
    let mut below = [R::splat(SERIES[21]); 5];
    for k in (0..21).rev() {
        below[4] = below[4].fma(near, R::splat(SERIES[k]));
    }
    // A z that is no number stays none: the second argument wins.
    let mut above = [exp(bound.min((-bound).max(far))); 5];
    for k in (0..4).rev() {
        below[k] = below[k + 1].fma(near, R::splat(INVERSE[k]));
    }
    for k in 0..4 {
        above[k + 1] = (above[k] - R::splat(INVERSE[k])) / far;
    }
    let mut all = above;
    for k in 0..5 {
        all[k] = R::select(small, below[k], above[k]);
    }
    all
}

/// The modes of the damping of a body.
#[derive(Clone, Copy)]
struct Modes<R> {
    moments: [R; 3],
    rates: [R; 3],
    /// G, row by row.
    to: [[R; 3]; 3],
}

impl<R: Real> Modes<R> {
    #[inline(always)]
    fn new(p: &Parameters<R>, drive: &Drive<R>) -> Self {
        let mut to = drive.modes;
        for k in 0..3 {
            let root = R::splat(1.0) / p.moments[k].sqrt();
            for m in 0..3 {
                to[m][k] = drive.modes[k][m] * root;
            }
        }
        Modes { moments: p.moments, rates: drive.rates, to }
    }
    /// G torque, or G L.
    #[inline(always)]
    fn of(&self, torque: &[R; 3]) -> [R; 3] {
        [dot(&self.to[0], torque), dot(&self.to[1], torque), dot(&self.to[2], torque)]
    }
    /// Rates in the body.
    #[inline(always)]
    fn omega(&self, v: &[R; 3]) -> [R; 3] {
        let mut omega = *v;
        for k in 0..3 {
            omega[k] = self.to[2][k].fma(v[2], self.to[1][k].fma(v[1], self.to[0][k] * v[0]));
        }
        omega
    }
    #[inline(always)]
    fn momentum(&self, omega: &[R; 3]) -> [R; 3] {
        [self.moments[0] * omega[0], self.moments[1] * omega[1], self.moments[2] * omega[2]]
    }
}

/// Half a turn about each axis, an exact kick by torques and damping together, and the turns backwards.
pub struct AffineSplitting<T, R, M> {
    model: M,
    modes: Modes<R>,
    /// Half the step over the moment.
    turn: [R; 3],
    /// Step times phi_1, step squared times phi_2.
    gain: [R; 3],
    shift: [R; 3],
    table: PhantomData<T>,
}

impl<T, R: Copy, M: Copy> Clone for AffineSplitting<T, R, M> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<T, R: Copy, M: Copy> Copy for AffineSplitting<T, R, M> {}

impl<R: Real, M: Model<R>, L: Layout, const D: usize> Scheme<R, M, L, D> for AffineSplitting<Affine, R, M> {
    const FORM: Form = Form::Momenta;

    #[inline(always)]
    fn new(p: &Parameters<R>) -> Self {
        <Self as Scheme<R, M, L, D>>::driven(p, &Drive::none(), const { &Numbers::of(&[]) })
    }

    #[inline(always)]
    fn driven(p: &Parameters<R>, drive: &Drive<R>, _numbers: &'static Numbers) -> Self {
        let modes = Modes::new(p, drive);
        let half = p.step * R::splat(0.5);
        let [i1, i2, i3] = p.moments;
        let (mut gain, mut shift) = (modes.rates, modes.rates);
        for m in 0..3 {
            let [_, one, two, ..] = phi(-(p.step * modes.rates[m]));
            gain[m] = p.step * one;
            shift[m] = (p.step * p.step) * two;
        }
        let turn = [half / i1, half / i2, half / i3];
        AffineSplitting { model: M::driven(p, drive), modes, turn, gain, shift, table: PhantomData }
    }

    #[inline(always)]
    fn step(&self, p: &Parameters<R>, y: &mut [R; D]) {
        let half = R::splat(0.5);
        for axis in [0, 1, 2] {
            turn::<R, L, D>(y, axis, self.turn[axis] * y[axis]);
        }
        y[D - 1] = p.step.fma(half, y[D - 1]);
        let mut weight = M::torque(p, y);
        let outside = self.model.undamped(y);
        let mut torque = weight;
        for i in 0..3 {
            torque[i] = weight[i] + outside[i];
        }
        let before = [y[0], y[1], y[2]];
        let (v, force) = (self.modes.of(&before), self.modes.of(&torque));
        // v grows by phi_1 h (force - rates v); its integral is phi_1 h v + phi_2 h^2 force.
        let (mut rise, mut way) = (v, v);
        for m in 0..3 {
            rise[m] = self.gain[m] * self.modes.rates[m].fnma(v[m], force[m]);
            way[m] = self.gain[m].fma(v[m], self.shift[m] * force[m]);
        }
        let change = self.modes.momentum(&self.modes.omega(&rise));
        let way = self.modes.omega(&way);
        let mut twice = before;
        for i in 0..3 {
            y[i] = before[i] + change[i];
            twice[i] = before[i] + y[i];
            weight[i] = weight[i] * way[i];
        }
        // The kinetic energy gained is work; that of the weight is in the potential already.
        let mut twice_v = v;
        for m in 0..3 {
            twice_v[m] = v[m] + (v[m] + rise[m]);
        }
        let gained = half * dot(&rise, &twice_v);
        y[D - 3] = y[D - 3] + (gained - (weight[0] + weight[1] + weight[2]));
        let impulse = if L::VECTORS == 0 { dot(&change, &twice) } else { dot(&change, &direction(y, 0)) };
        y[D - 2] = y[D - 2] + impulse;
        y[D - 1] = p.step.fma(half, y[D - 1]);
        for axis in [2, 1, 0] {
            turn::<R, L, D>(y, axis, self.turn[axis] * y[axis]);
        }
    }

    #[inline(always)]
    fn velocity(&self, p: &Parameters<R>, y: &[R; D]) -> [R; 3] {
        let mut rates = *y;
        for i in 0..3 {
            rates[i] = y[i] / p.moments[i];
        }
        let (forcing, outside) = (self.model.forcing(&rates), self.model.outside(&rates));
        let undamped = self.model.undamped(&rates);
        let mut sum = forcing;
        for i in 0..3 {
            sum[i] = forcing[i] + (outside[i] - undamped[i]);
        }
        sum
    }

    #[inline(always)]
    fn momentum(_p: &Parameters<R>, y: &[R; D]) -> [R; 3] {
        [y[0], y[1], y[2]]
    }

    #[inline(always)]
    fn kinetic(p: &Parameters<R>, y: &[R; D]) -> R {
        let omega = [y[0] / p.moments[0], y[1] / p.moments[1], y[2] / p.moments[2]];
        dot(&[y[0], y[1], y[2]], &omega) * R::splat(0.5)
    }
}

/// Entries of the table: in the modes, and what they turn in the time of the stage.
#[derive(Clone, Copy)]
struct Entry<R> {
    gain: [R; 3],
    way: [R; 3],
    /// The same of what turns without damping.
    free: R,
}

const A21: usize = 0;
const A31: usize = 1;
const A32: usize = 2;
const A41: usize = 3;
const A42: usize = 4;
const A51: usize = 5;
const A52: usize = 6;
const A54: usize = 7;
const B1: usize = 8;
const B4: usize = 9;
const B5: usize = 10;

/// Entries of each stage and of the result, each with its stage; Hochbruck & Ostermann 2005, (5.19).
const STAGES: [&[(usize, usize)]; 5] = [
    &[(A21, 0)],
    &[(A31, 0), (A32, 1)],
    &[(A41, 0), (A42, 1), (A42, 2)],
    &[(A51, 0), (A52, 1), (A52, 2), (A54, 3)],
    &[(B1, 0), (B4, 3), (B5, 4)],
];
/// What they are where nothing damps: phi_k(0) = 1/k!.
const FREE: [f64; 11] = [0.5, 0.0, 0.5, 0.0, 0.5, 0.25, 0.125, 0.0, 1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0];
/// Times of the stages.
const TIMES: [f64; 5] = [0.5, 0.5, 1.0, 0.5, 1.0];

/// The exponential Runge-Kutta method. The rates and a rotation vector from the attitude at the begin of the step are
/// one linear system, damped rates that turn the body, and its exponential is known: a step that leaps over the time in
/// which strong damping stops a body turns it as far as it turned. The attitude is composed from rotations.
pub struct Exponential<T, R, M> {
    model: M,
    modes: Modes<R>,
    table: [Entry<R>; 11],
    /// (phi_0 - 1) and time times phi_1, of half a step and of a step: what the rates at the begin become and turn.
    linear: [[[R; 3]; 2]; 2],
    tag: PhantomData<T>,
}

impl<T, R: Copy, M: Copy> Clone for Exponential<T, R, M> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<T, R: Copy, M: Copy> Copy for Exponential<T, R, M> {}

/// theta' of a rotation vector in a body that turns at `omega`, less `omega`.
#[inline(always)]
fn bend<R: Real>(theta: &[R; 3], omega: &[R; 3]) -> [R; 3] {
    let q = dot(theta, theta);
    // (1 - (a/2) cot(a/2)) / a^2.
    let c = [1.0 / 1_209_600.0, 1.0 / 30_240.0, 1.0 / 720.0, 1.0 / 12.0];
    let mut factor = R::splat(c[0]);
    for &next in &c[1..] {
        factor = factor.fma(q, R::splat(next));
    }
    let once = cross(theta, omega);
    let twice = cross(theta, &once);
    let mut all = once;
    for i in 0..3 {
        all[i] = factor.fma(twice[i], R::splat(0.5) * once[i]);
    }
    all
}

/// `n`, seen from a body that turned by a rotation vector with these coefficients of Rodrigues' formula.
#[inline(always)]
fn turned<R: Real>(n: &[R; 3], theta: &[R; 3], (a, b): (R, R)) -> [R; 3] {
    let once = cross(theta, n);
    let twice = cross(theta, &once);
    let mut all = *n;
    for i in 0..3 {
        all[i] = n[i] + b.fma(twice[i], -(a * once[i]));
    }
    all
}

impl<T, R: Real, M: Model<R>> Exponential<T, R, M> {
    /// What the entries of a stage make of the torques so far: the rise of v, how far the body turned, and the part of
    /// that which the rates alone turned.
    #[inline(always)]
    fn stage(
        &self,
        stage: usize,
        v: &[R; 3],
        torques: &[[R; 3]; 5],
        bends: &[[R; 3]; 5],
    ) -> ([R; 3], [R; 3], [R; 3]) {
        let [decay, time] = &self.linear[if TIMES[stage] == 0.5 { 0 } else { 1 }];
        let (mut rise, mut way) = (*v, *v);
        let mut free = [R::splat(0.0); 3];
        for m in 0..3 {
            rise[m] = decay[m] * v[m];
            way[m] = time[m] * v[m];
        }
        for &(entry, from) in STAGES[stage] {
            let Entry { gain, way: turns, free: share } = &self.table[entry];
            for m in 0..3 {
                rise[m] = gain[m].fma(torques[from][m], rise[m]);
                way[m] = turns[m].fma(torques[from][m], way[m]);
                free[m] = share.fma(bends[from][m], free[m]);
            }
        }
        let alone = self.modes.omega(&way);
        let mut theta = alone;
        for i in 0..3 {
            theta[i] = alone[i] + free[i];
        }
        (rise, theta, alone)
    }

    /// The state after a rise of v and a turn.
    #[inline(always)]
    fn moved<L: Layout, const D: usize>(&self, y: &[R; D], rise: &[R; 3], theta: &[R; 3], time: R) -> [R; D] {
        let mut at = *y;
        let change = self.modes.omega(rise);
        for i in 0..3 {
            at[i] = y[i] + change[i];
        }
        if L::VECTORS > 0 {
            let coefficients = rodrigues(dot(theta, theta));
            for v in 0..L::VECTORS {
                let seen = turned(&direction(y, v), theta, coefficients);
                at[3 + 3 * v..6 + 3 * v].copy_from_slice(&seen);
            }
        }
        at[D - 1] = y[D - 1] + time;
        at
    }
}

impl<R: Real, M: Model<R>, L: Layout, const D: usize> Scheme<R, M, L, D> for Exponential<Etd4, R, M> {
    const FORM: Form = Form::Rates;

    #[inline(always)]
    fn new(p: &Parameters<R>) -> Self {
        <Self as Scheme<R, M, L, D>>::driven(p, &Drive::none(), const { &Numbers::of(&[]) })
    }

    #[inline(always)]
    fn driven(p: &Parameters<R>, drive: &Drive<R>, _numbers: &'static Numbers) -> Self {
        let modes = Modes::new(p, drive);
        let (h, half) = (p.step, p.step * R::splat(0.5));
        let zero = R::splat(0.0);
        let mut table = [Entry { gain: [zero; 3], way: [zero; 3], free: zero }; 11];
        for e in 0..11 {
            table[e].free = h * R::splat(FREE[e]);
        }
        let mut linear = [[[zero; 3]; 2]; 2];
        for m in 0..3 {
            let whole = phi(-(h * modes.rates[m]));
            let part = phi(-(half * modes.rates[m]));
            linear[0][0][m] = -(half * modes.rates[m]) * part[1];
            linear[0][1][m] = half * part[1];
            linear[1][0][m] = -(h * modes.rates[m]) * whole[1];
            linear[1][1][m] = h * whole[1];
            // Once for what a torque gives, once for what that turns: there phi_k becomes time times phi_(k+1).
            for turning in [false, true] {
                let (mut f, mut g) = (part, whole);
                if turning {
                    for k in 0..4 {
                        f[k] = half * part[k + 1];
                        g[k] = h * whole[k + 1];
                    }
                }
                let c = R::splat;
                let a52 = c(0.5) * f[2] - g[3] + c(0.25) * g[2] - c(0.5) * f[3];
                let a54 = c(0.25) * f[2] - a52;
                let mut row = [zero; 11];
                row[A21] = c(0.5) * f[1];
                row[A31] = c(0.5) * f[1] - f[2];
                row[A32] = f[2];
                row[A41] = g[1] - c(2.0) * g[2];
                row[A42] = g[2];
                row[A51] = c(0.5) * f[1] - c(2.0) * a52 - a54;
                row[A52] = a52;
                row[A54] = a54;
                row[B1] = g[1] - c(3.0) * g[2] + c(4.0) * g[3];
                row[B4] = c(4.0) * g[3] - g[2];
                row[B5] = c(4.0) * g[2] - c(8.0) * g[3];
                for e in 0..11 {
                    if turning {
                        table[e].way[m] = h * row[e];
                    } else {
                        table[e].gain[m] = h * row[e];
                    }
                }
            }
        }
        Exponential { model: M::driven(p, drive), modes, table, linear, tag: PhantomData }
    }

    #[inline(always)]
    fn step(&self, p: &Parameters<R>, y: &mut [R; D]) {
        let zero = [R::splat(0.0); 3];
        let omega = [y[0], y[1], y[2]];
        let v = self.modes.of(&self.modes.momentum(&omega));
        let (mut torques, mut bends) = ([zero; 5], [zero; 5]);
        torques[0] = self.modes.of(&self.model.forcing(y));
        let weight = M::torque(p, y);
        // Work of the weight beside what follows from the whole turn: where a rate may have decayed within the step its
        // weight in the sum is zero.
        let mut worked = R::splat(0.0);
        for stage in 0..4 {
            let (rise, theta, _) = self.stage(stage, &v, &torques, &bends);
            let at = self.moved::<L, D>(y, &rise, &theta, p.step * R::splat(TIMES[stage]));
            torques[stage + 1] = self.modes.of(&self.model.forcing(&at));
            if L::VECTORS > 0 {
                let omega = [at[0], at[1], at[2]];
                bends[stage + 1] = bend(&theta, &omega);
                if stage >= 2 {
                    let share = self.table[if stage == 2 { B4 } else { B5 }].free;
                    let mut heavier = M::torque(p, &at);
                    for i in 0..3 {
                        heavier[i] = heavier[i] - weight[i];
                    }
                    worked = share.fma(dot(&heavier, &omega), worked);
                }
            }
        }
        let (rise, theta, alone) = self.stage(4, &v, &torques, &bends);
        let mut at = self.moved::<L, D>(y, &rise, &theta, p.step);
        let mut twice = v;
        for m in 0..3 {
            twice[m] = v[m] + (v[m] + rise[m]);
        }
        let gained = R::splat(0.5) * dot(&rise, &twice);
        if L::VECTORS > 0 {
            worked = worked + dot(&weight, &alone);
        }
        // The impulse of strong damping is the small difference of large ones: it is what the momentum gained.
        let (mut before, mut after) = (*y, at);
        before[D - 2] = R::splat(0.0);
        after[D - 2] = R::splat(0.0);
        let impulse = M::conserved(&momentum_of_rates(p, &after), &after)
            - M::conserved(&momentum_of_rates(p, &before), &before);
        at[D - 3] = y[D - 3] + (gained - worked);
        at[D - 2] = y[D - 2] + impulse;
        *y = at;
    }

    #[inline(always)]
    fn velocity(&self, _p: &Parameters<R>, y: &[R; D]) -> [R; 3] {
        self.model.acceleration(&[y[0], y[1], y[2]], y)
    }

    #[inline(always)]
    fn momentum(p: &Parameters<R>, y: &[R; D]) -> [R; 3] {
        momentum_of_rates(p, y)
    }

    #[inline(always)]
    fn kinetic(p: &Parameters<R>, y: &[R; D]) -> R {
        kinetic_of_rates(p, y)
    }
}
