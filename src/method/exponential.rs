//! Methods for damping of any strength: every step contains the exponential of the damping.
//!
//! The modes of the damping are `v = G L` with `G = V^T I^(-1/2)`, and `v' = -rates v + G torque`. The splitting solves
//! this equation with a torque that is constant during the step; the exponential Runge-Kutta method corrects for the
//! change of the torque.

use super::acceleration;
use super::splitting::turn;
use super::{Engine, EngineName, Facts, ForcedStep, Method, Numbers, RK4, Step, Variables};
use crate::forces::ForcesInterval;
use crate::kinematics::{cross, direction, dot, plus, put};
use crate::real::Real;
use crate::scene::{Applied, Layout, Model, Parameters};
use crate::special::{exp, rodrigues};

/// Exponential Runge-Kutta method of stiff order 4. Without damping the method is the classical Runge-Kutta method.
pub const ETD4: Method = Method {
    facts: Facts {
        name: "etd4",
        title: "exponential Runge-Kutta of stiff order 4 for damping of any strength; without damping it is rk4",
        order: 4,
        stages: 5,
        symplectic: false,
        reversible: false,
        group_preserving: false,
        conserves: &[],
        angle_per_step: 1.0 / 16.0,
        longest_angle: 0.13,
        citation: "M. Hochbruck, A. Ostermann, Explicit exponential Runge-Kutta methods for semilinear parabolic \
                   problems, SIAM J. Numer. Anal. 43 (2005) 1069-1090; attitude in Lie coordinates: H. Munthe-Kaas, \
                   Runge-Kutta methods on Lie groups, BIT 38 (1998) 92-111",
        doi: "10.1137/040611434",
    },
    forced: Some(ForcedStep { step: Step::plain(EngineName::Exponential), damping_limit: f64::INFINITY }),
    ..RK4
};

/// phi_0 = exp, ..., phi_4, with `phi_(k+1)(z) = (phi_k(z) - 1/k!) / z`.
#[inline(always)]
pub fn phi<R: Real>(z: R) -> [R; 5] {
    // Below 2: the series of phi_4 and the downward recurrence, because the differences of the upward recurrence
    // cancel.
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
    // A NaN remains: `max` and `min` return the second argument.
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
    /// G, one row for each mode.
    to: [[R; 3]; 3],
}

impl<R: Real> Modes<R> {
    #[inline(always)]
    fn new(p: &Parameters<R>, interval: &ForcesInterval<'static, R>) -> Self {
        let mut to = interval.modes;
        for k in 0..3 {
            let root = R::splat(1.0) / p.moments[k].sqrt();
            for m in 0..3 {
                to[m][k] = interval.modes[k][m] * root;
            }
        }
        Modes { moments: p.moments, rates: interval.rates, to }
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

/// The sum of gyroscopic torque, torque of the scene and applied torque, without damping, from a state of rates.
#[inline(always)]
fn without_damping<R: Real, M: Model<R>, L: Layout, const D: usize>(
    applied: &Applied<R>,
    p: &Parameters<R>,
    y: &[R; D],
) -> [R; 3] {
    let omega = [y[0], y[1], y[2]];
    let mut momentum = omega;
    for i in 0..3 {
        momentum[i] = momentum[i] * p.moments[i];
    }
    let mut whole = cross(&momentum, &omega);
    if L::VECTORS > 0 {
        whole = plus(&whole, &M::torque(p, y));
    }
    plus(&applied.undamped::<L, D>(y), &whole)
}

/// Rotations about the three axes over half the step, an exact kick by torque and damping together, and the rotations
/// in reverse order.
#[derive(Clone, Copy)]
pub struct AffineSplitting<R> {
    applied: Applied<R>,
    modes: Modes<R>,
    /// Half the step over the moment.
    turn: [R; 3],
    /// Step times phi_1, step squared times phi_2.
    gain: [R; 3],
    shift: [R; 3],
}

impl<R: Real, M: Model<R>, L: Layout, const D: usize> Engine<R, M, L, D> for AffineSplitting<R> {
    const VARIABLES: Variables = Variables::Momenta;
    const MOVES: bool = L::BALANCE && !L::TURNS && !L::FURTHER && !L::FUNCTION;

    #[inline(always)]
    fn new(p: &Parameters<R>, interval: &ForcesInterval<'static, R>, _numbers: &'static Numbers) -> Self {
        let modes = Modes::new(p, interval);
        let half = p.step * R::splat(0.5);
        let [i1, i2, i3] = p.moments;
        let (mut gain, mut shift) = (modes.rates, modes.rates);
        for m in 0..3 {
            let [_, one, two, ..] = phi(-(p.step * modes.rates[m]));
            gain[m] = p.step * one;
            shift[m] = (p.step * p.step) * two;
        }
        let turn = [half / i1, half / i2, half / i3];
        AffineSplitting { applied: Applied::new(p, interval), modes, turn, gain, shift }
    }

    #[inline(always)]
    fn step(&self, p: &Parameters<R>, y: &mut [R; D]) {
        let half = R::splat(0.5);
        for axis in [0, 1, 2] {
            turn::<R, L, D>(y, axis, self.turn[axis] * y[axis]);
        }
        y[L::TIME_AT] = p.step.fma(half, y[L::TIME_AT]);
        let mut weight = M::torque(p, y);
        let applied = self.applied.undamped::<L, D>(y);
        let torque = plus(&weight, &applied);
        let before = [y[0], y[1], y[2]];
        let (v, force) = (self.modes.of(&before), self.modes.of(&torque));
        // The increment of v is phi_1 h (force - rates v); the integral of v is phi_1 h v + phi_2 h^2 force.
        let (mut increment, mut rotation) = (v, v);
        for m in 0..3 {
            increment[m] = self.gain[m] * self.modes.rates[m].fnma(v[m], force[m]);
            rotation[m] = self.gain[m].fma(v[m], self.shift[m] * force[m]);
        }
        let change = self.modes.momentum(&self.modes.omega(&increment));
        let rotation = self.modes.omega(&rotation);
        let mut twice = before;
        for i in 0..3 {
            y[i] = before[i] + change[i];
            twice[i] = before[i] + y[i];
            weight[i] = weight[i] * rotation[i];
        }
        // The gain of kinetic energy is work; the work of the weight is subtracted, because the potential energy
        // contains it.
        let twice_v = plus(&v, &plus(&v, &increment));
        let gained = half * dot(&increment, &twice_v);
        y[L::BALANCE_AT] = y[L::BALANCE_AT] + (gained - (weight[0] + weight[1] + weight[2]));
        let impulse = if L::VECTORS == 0 { dot(&change, &twice) } else { dot(&change, &direction(y, 0)) };
        y[L::IMPULSE_AT] = y[L::IMPULSE_AT] + impulse;
        y[L::TIME_AT] = p.step.fma(half, y[L::TIME_AT]);
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
        let without = without_damping::<R, M, L, D>(&self.applied, p, &rates);
        let applied = self.applied.torque::<L, D>(&rates);
        let undamped = self.applied.undamped::<L, D>(&rates);
        let mut sum = without;
        for i in 0..3 {
            sum[i] = without[i] + (applied[i] - undamped[i]);
        }
        sum
    }
}

/// The coefficient of a torque: for the increment of the modes, and for the rotation during the stage.
#[derive(Clone, Copy)]
struct Entry<R> {
    gain: [R; 3],
    rotation: [R; 3],
    /// For a rotation vector, which is not damped.
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

/// The coefficients of each stage and of the result, each with the stage of its torque; Hochbruck & Ostermann 2005,
/// (5.19).
const STAGES: [&[(usize, usize)]; 5] = [
    &[(A21, 0)],
    &[(A31, 0), (A32, 1)],
    &[(A41, 0), (A42, 1), (A42, 2)],
    &[(A51, 0), (A52, 1), (A52, 2), (A54, 3)],
    &[(B1, 0), (B4, 3), (B5, 4)],
];
/// Values of phi_k without damping: phi_k(0) = 1/k!.
const FREE: [f64; 11] = [0.5, 0.0, 0.5, 0.0, 0.5, 0.25, 0.125, 0.0, 1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0];
/// Times of the stages.
const TIMES: [f64; 5] = [0.5, 0.5, 1.0, 0.5, 1.0];

/// The exponential Runge-Kutta method. The damped rates and the rotation vector since the begin of the step form a
/// linear system with a known exponential, so the rotation is accurate even if strong damping stops the body within a
/// small part of the step. The attitude is composed from rotations.
#[derive(Clone, Copy)]
pub struct Exponential<R, M> {
    model: M,
    applied: Applied<R>,
    modes: Modes<R>,
    table: [Entry<R>; 11],
    /// phi_0 - 1 and time times phi_1, for half a step and a step: the change of the rates and the rotation that follow
    /// from the rates at the begin.
    linear: [[[R; 3]; 2]; 2],
}

/// theta' - omega for a rotation vector of a body with the rates `omega` (the inverse of the derivative of exp).
#[inline(always)]
fn dexpinv_correction<R: Real>(theta: &[R; 3], omega: &[R; 3]) -> [R; 3] {
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

/// `n` in the components of a body that turned by a rotation vector with these coefficients of Rodrigues' formula.
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

impl<R: Real, M: Model<R>> Exponential<R, M> {
    /// For a stage, from the torques so far: the increment of v, the rotation vector, and the rotation vector without
    /// the corrections of `dexpinv_correction`.
    #[inline(always)]
    fn stage(
        &self,
        stage: usize,
        v: &[R; 3],
        torques: &[[R; 3]; 5],
        corrections: &[[R; 3]; 5],
    ) -> ([R; 3], [R; 3], [R; 3]) {
        let [decay, time] = &self.linear[if TIMES[stage] == 0.5 { 0 } else { 1 }];
        let (mut increment, mut rotation) = (*v, *v);
        let mut free = [R::splat(0.0); 3];
        for m in 0..3 {
            increment[m] = decay[m] * v[m];
            rotation[m] = time[m] * v[m];
        }
        for &(entry, from) in STAGES[stage] {
            let Entry { gain, rotation: turns, free: share } = &self.table[entry];
            for m in 0..3 {
                increment[m] = gain[m].fma(torques[from][m], increment[m]);
                rotation[m] = turns[m].fma(torques[from][m], rotation[m]);
                free[m] = share.fma(corrections[from][m], free[m]);
            }
        }
        let alone = self.modes.omega(&rotation);
        (increment, plus(&alone, &free), alone)
    }

    /// The state after an increment of v and a rotation.
    #[inline(always)]
    fn moved<L: Layout, const D: usize>(
        &self,
        y: &[R; D],
        increment: &[R; 3],
        theta: &[R; 3],
        time: R,
    ) -> [R; D] {
        let mut at = *y;
        let change = self.modes.omega(increment);
        for i in 0..3 {
            at[i] = y[i] + change[i];
        }
        if L::VECTORS > 0 {
            let coefficients = rodrigues(dot(theta, theta));
            for v in 0..L::VECTORS {
                let in_body = turned(&direction(y, v), theta, coefficients);
                put(&mut at, 3 + 3 * v, in_body);
            }
        }
        at[L::TIME_AT] = y[L::TIME_AT] + time;
        at
    }
}

impl<R: Real, M: Model<R>, L: Layout, const D: usize> Engine<R, M, L, D> for Exponential<R, M> {
    const VARIABLES: Variables = Variables::Rates;
    const MOVES: bool = L::BALANCE && !L::TURNS && !L::FURTHER && !L::FUNCTION;

    #[inline(always)]
    fn new(p: &Parameters<R>, interval: &ForcesInterval<'static, R>, _numbers: &'static Numbers) -> Self {
        let modes = Modes::new(p, interval);
        let (h, half) = (p.step, p.step * R::splat(0.5));
        let zero = R::splat(0.0);
        let mut table = [Entry { gain: [zero; 3], rotation: [zero; 3], free: zero }; 11];
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
            // First for the rates, then for the rotation, for which phi_k becomes time times phi_(k+1).
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
                        table[e].rotation[m] = h * row[e];
                    } else {
                        table[e].gain[m] = h * row[e];
                    }
                }
            }
        }
        Exponential { model: M::new(p), applied: Applied::new(p, interval), modes, table, linear }
    }

    #[inline(always)]
    fn step(&self, p: &Parameters<R>, y: &mut [R; D]) {
        let zero = [R::splat(0.0); 3];
        let omega = [y[0], y[1], y[2]];
        let v = self.modes.of(&self.modes.momentum(&omega));
        let (mut torques, mut corrections) = ([zero; 5], [zero; 5]);
        torques[0] = self.modes.of(&without_damping::<R, M, L, D>(&self.applied, p, y));
        let weight = M::torque(p, y);
        // The work of the change of the weight torque since the begin. Stages at which a rate may already have decayed
        // have the coefficient zero in this sum.
        let mut worked = R::splat(0.0);
        for stage in 0..4 {
            let (increment, theta, _) = self.stage(stage, &v, &torques, &corrections);
            let at = self.moved::<L, D>(y, &increment, &theta, p.step * R::splat(TIMES[stage]));
            torques[stage + 1] = self.modes.of(&without_damping::<R, M, L, D>(&self.applied, p, &at));
            if L::VECTORS > 0 {
                let omega = [at[0], at[1], at[2]];
                corrections[stage + 1] = dexpinv_correction(&theta, &omega);
                if stage >= 2 {
                    let share = self.table[if stage == 2 { B4 } else { B5 }].free;
                    let mut change_of_torque = M::torque(p, &at);
                    for i in 0..3 {
                        change_of_torque[i] = change_of_torque[i] - weight[i];
                    }
                    worked = share.fma(dot(&change_of_torque, &omega), worked);
                }
            }
        }
        let (increment, theta, alone) = self.stage(4, &v, &torques, &corrections);
        let mut at = self.moved::<L, D>(y, &increment, &theta, p.step);
        let twice = plus(&v, &plus(&v, &increment));
        let gained = R::splat(0.5) * dot(&increment, &twice);
        if L::VECTORS > 0 {
            worked = worked + dot(&weight, &alone);
        }
        // The impulse of strong damping is a small difference of large ones, so it is set to the gain of momentum.
        let [after, before] = [Variables::Rates.momentum(p, &at), Variables::Rates.momentum(p, y)];
        let impulse = M::conserved(&after, &at) - M::conserved(&before, y);
        at[L::BALANCE_AT] = y[L::BALANCE_AT] + (gained - worked);
        at[L::IMPULSE_AT] = y[L::IMPULSE_AT] + impulse;
        *y = at;
    }

    #[inline(always)]
    fn velocity(&self, _p: &Parameters<R>, y: &[R; D]) -> [R; 3] {
        acceleration::<R, M, L, D>(&self.model, &self.applied, y)
    }
}
