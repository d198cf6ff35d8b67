//! The implicit midpoint rule, which conserves every quadratic invariant with steps of any length.
//!
//! Momenta and directions obey `m' = m x omega + torque`, `n' = n x omega`. Energy, `m.m` or `m.n`, and `n.n` are
//! quadratic in momenta and directions, so the rule conserves these invariants. Directions turn by the Cayley transform
//! of `h omega` with the rate in the middle, `omega = I^(-1) (m0 + m1) / 2`. The only unknown is `u = h omega / 2`,
//! which is found by Newton's method.

use super::{Engine, EngineName, Facts, Method, Numbers, Step, Variables};
use crate::forces::{ForcesInterval, attitude_of_stage};
use crate::kinematics::{cross, direction, dot, plus, put, quaternion_product, symmetric};
use crate::real::{Outlined, Real};
use crate::scene::{Applied, Layout, Model, Parameters};

/// The implicit midpoint rule. The method is used in the frame of the body, as published.
pub const MIDPOINT: Method = Method::direct(
    Facts {
        name: "midpoint",
        title: "implicit midpoint rule: conserves energy and momentum with steps of any length",
        order: 2,
        stages: 4,
        symplectic: false,
        reversible: true,
        group_preserving: true,
        conserves: &["momentum", "energy"],
        angle_per_step: 1.0 / 16.0,
        longest_angle: 3.0,
        citation: "J. C. Simo, K. K. Wong, Unconditionally stable algorithms for rigid body dynamics that exactly \
                   preserve energy and momentum, Int. J. Numer. Meth. Eng. 31 (1991) 19-52; attitude by the Cayley \
                   transform: M. A. Austin, P. S. Krishnaprasad, L.-S. Wang, Almost Poisson integration of rigid \
                   body systems, J. Comput. Phys. 107 (1993) 105-117; quadratic invariants: G. J. Cooper, Stability \
                   of Runge-Kutta methods for trajectory problems, IMA J. Numer. Anal. 7 (1987) 1-13",
        doi: "10.1002/nme.1620310103",
    },
    Step::plain(EngineName::Midpoint),
    f64::INFINITY,
);

/// Largest number of Newton steps. Steps of up to one radian need 3 or 4, steps of up to two radians 5.
const NEWTON_STEPS: usize = 8;
/// The correction of u below which Newton's method ends: the remaining error is about the square of the correction.
const SMALL_CORRECTION: f64 = 1e-9;
/// That with the torque of a function, whose derivative by a difference lets the correction fall by its error only: what
/// remained would add up over the steps.
const SMALL_CORRECTION_BY_DIFFERENCES: f64 = 1e-14;
/// The last correction from which on a solution is rejected.
const LARGEST_CORRECTION: f64 = 1e-6;
/// The difference of `u` from which the derivative of a function of the user follows, to half of the digits.
const DIFFERENCE: f64 = 1e-7;
/// Numbers of equal substeps if Newton's method does not solve the equation of a step (from about three radians on).
const PARTS: [usize; 3] = [4, 16, 64];

/// The engine.
#[derive(Clone, Copy)]
pub struct ImplicitMidpoint<R> {
    applied: Applied<R>,
    interval: ForcesInterval<'static, R>,
    /// Moments over the first, and their inverses.
    ratios: [R; 3],
    inverse_ratios: [R; 3],
    /// One over the first moment.
    inverse: R,
    whole: StepConstants<R>,
}

/// Constants of a step or substep, in units of the first moment, so that the equation is dimensionless.
#[derive(Clone, Copy)]
struct StepConstants<R> {
    step: R,
    half: R,
    /// The factor of a torque: half the step squared, over the first moment.
    torque_factor: R,
    /// The weight times `torque_factor`, and the weight times half the step.
    lever: [R; 3],
    kick: [R; 3],
    /// The damping times half the step over the first moment.
    damping: [R; 6],
}

/// The terms of the equation for the rotation of a step that do not depend on the rotation.
#[derive(Clone, Copy)]
struct Equation<R> {
    /// The constant term.
    start: [R; 3],
    /// The torque in space, in body components at the begin.
    space: [R; 3],
    /// The vertical at the begin.
    gamma: [R; 3],
    /// The first space axis at the begin, and the time in the middle, which a function is told.
    first: [R; 3],
    middle: R,
    damping: [[R; 3]; 3],
}

/// The rotation of a step.
#[derive(Clone, Copy)]
struct Turn<R> {
    u: [R; 3],
    /// `1 / (1 + u.u)`.
    inverse: R,
}

impl<R: Real> Turn<R> {
    #[inline(always)]
    fn of(u: &[R; 3]) -> Self {
        let one = R::splat(1.0);
        Turn { u: *u, inverse: one / u[0].fma(u[0], u[1].fma(u[1], u[2].fma(u[2], one))) }
    }
    /// Change of a direction from `n` at the begin to the middle; the change to the end is twice as large.
    #[inline(always)]
    fn gain(&self, n: &[R; 3]) -> [R; 3] {
        let once = cross(n, &self.u);
        let twice = cross(&once, &self.u);
        let mut all = once;
        for i in 0..3 {
            all[i] = self.inverse * (once[i] + twice[i]);
        }
        all
    }
    /// The direction in the middle: the mean of the directions at both ends.
    #[inline(always)]
    fn middle(&self, n: &[R; 3]) -> [R; 3] {
        let gain = self.gain(n);
        plus(n, &gain)
    }
    /// The direction at the end.
    #[inline(always)]
    fn end(&self, n: &[R; 3]) -> [R; 3] {
        let (gain, two) = (self.gain(n), R::splat(2.0));
        [two.fma(gain[0], n[0]), two.fma(gain[1], n[1]), two.fma(gain[2], n[2])]
    }
}

/// The columns `k x e_i`.
#[inline(always)]
fn columns<R: Real>(k: &[R; 3]) -> [[R; 3]; 3] {
    let zero = R::splat(0.0);
    [[zero, k[2], -k[1]], [-k[2], zero, k[0]], [k[1], -k[0], zero]]
}

/// The torque of a function in the middle of a step that turns the body by `u`, as it stands in the equation: a function of
/// its own, which a step calls in four places.
struct TorqueInTheMiddle<'a, R: Real> {
    engine: &'a ImplicitMidpoint<R>,
    constants: &'a StepConstants<R>,
    equation: &'a Equation<R>,
    u: &'a [R; 3],
    wanted: R,
    torque: &'a mut [R; 3],
}

impl<R: Real> Outlined for TorqueInTheMiddle<'_, R> {
    type Out = ();
    #[inline(always)]
    fn run(self) {
        let TorqueInTheMiddle { engine, constants, equation, u, wanted, torque } = self;
        let (turn, half) = (Turn::of(u), constants.half);
        let omega = [u[0] / half, u[1] / half, u[2] / half];
        let attitude = attitude_of_stage([turn.middle(&equation.gamma), turn.middle(&equation.first)]);
        let returned = engine.applied.function_torque(equation.middle, &omega, &attitude, wanted);
        for i in 0..3 {
            torque[i] = returned[i] * constants.torque_factor;
        }
    }
}

impl<R: Real> ImplicitMidpoint<R> {
    #[inline(always)]
    fn of(p: &Parameters<R>, interval: &ForcesInterval<'static, R>) -> Self {
        let one = R::splat(1.0);
        let [i1, i2, i3] = p.moments;
        let inverse = one / i1;
        let (ratios, inverse_ratios) = ([one, i2 / i1, i3 / i1], [one, i1 / i2, i1 / i3]);
        let whole = Self::constants(p, interval, inverse, one);
        ImplicitMidpoint {
            applied: Applied::new(p, interval),
            interval: *interval,
            ratios,
            inverse_ratios,
            inverse,
            whole,
        }
    }

    /// The constants of a step or substep.
    #[inline(always)]
    fn constants(
        p: &Parameters<R>,
        interval: &ForcesInterval<'static, R>,
        inverse: R,
        part: R,
    ) -> StepConstants<R> {
        let step = p.step * part;
        let half = step * R::splat(0.5);
        let (mut lever, mut kick, mut damping) = (p.weight, p.weight, interval.damping);
        for i in 0..3 {
            lever[i] = (p.weight[i] * inverse) * (half * half);
            kick[i] = p.weight[i] * half;
        }
        for i in 0..6 {
            damping[i] = (interval.damping[i] * inverse) * half;
        }
        StepConstants { step, half, torque_factor: inverse * (half * half), lever, kick, damping }
    }

    /// The state after a step, and the last correction of its rotation, for the lanes in which `wanted` is above zero.
    #[inline(always)]
    fn moved<M: Model<R>, L: Layout, const D: usize>(
        &self,
        p: &Parameters<R>,
        constants: &StepConstants<R>,
        y: &[R; D],
        wanted: R,
    ) -> ([R; D], R) {
        let (equation, guess) = self.equation::<M, L, D>(constants, y);
        let (u, correction) = self.solution::<M, L>(constants, &equation, guess, wanted);
        (self.state_after::<M, L, D>(p, constants, y, (&u, &equation.gamma), wanted), correction)
    }

    /// The equation for the rotation of a step, and a first guess of its solution.
    #[inline(always)]
    fn equation<M: Model<R>, L: Layout, const D: usize>(
        &self,
        constants: &StepConstants<R>,
        y: &[R; D],
    ) -> (Equation<R>, [R; 3]) {
        let half = constants.half;
        let zeros = [R::splat(0.0); 3];
        let momentum = [y[0], y[1], y[2]];
        // The constant term, and the torque in space in body components at the begin.
        let (mut start, mut torque, mut space) = (momentum, zeros, zeros);
        for i in 0..3 {
            start[i] = (momentum[i] * self.inverse) * half;
        }
        let mut u = start;
        for i in 0..3 {
            u[i] = start[i] * self.inverse_ratios[i];
        }
        if L::BALANCE {
            let middle = y[L::TIME_AT] + half;
            for i in 0..3 {
                torque[i] = middle.fma(self.interval.body[1][i], self.interval.body[0][i]);
                start[i] = constants.torque_factor.fma(torque[i], start[i]);
            }
            if L::VECTORS > 2 {
                for (row, axis) in [(0, 2), (1, 0), (2, 1)] {
                    let n = direction(y, row);
                    let part = middle.fma(self.interval.space[1][axis], self.interval.space[0][axis])
                        * constants.torque_factor;
                    for i in 0..3 {
                        space[i] = part.fma(n[i], space[i]);
                    }
                }
            }
        }
        let gamma = if const { M::HEAVY && L::VECTORS > 0 } { direction(y, 0) } else { zeros };
        let first = if L::FUNCTION { direction(y, 1) } else { zeros };
        let middle = if L::FUNCTION { y[L::TIME_AT] + half } else { half };
        (Equation { start, space, gamma, first, middle, damping: symmetric(&constants.damping) }, u)
    }

    /// The residual of an equation at `u`, and the columns of its derivative, for the lanes in which `wanted` is above zero.
    #[inline(always)]
    fn residual<M: Model<R>, L: Layout>(
        &self,
        constants: &StepConstants<R>,
        equation: &Equation<R>,
        u: &[R; 3],
        wanted: R,
    ) -> ([R; 3], [[R; 3]; 3]) {
        let j = &self.ratios;
        let Equation { start, space, gamma, damping, .. } = equation;
        let turn = Turn::of(u);
        let momentum = [j[0] * u[0], j[1] * u[1], j[2] * u[2]];
        let term = cross(u, &momentum);
        let mut residual = momentum;
        for i in 0..3 {
            residual[i] = (momentum[i] - start[i]) + term[i];
        }
        // The columns of the derivative; `e x momentum` is minus `momentum x e`.
        let (mut a, of_momentum, of_u) = (columns(u), columns(&momentum), columns(u));
        for k in 0..3 {
            for i in 0..3 {
                a[k][i] = j[k].fms(of_u[k][i], of_momentum[k][i]);
            }
            a[k][k] = a[k][k] + j[k];
        }
        if L::BALANCE {
            for k in 0..3 {
                for i in 0..3 {
                    residual[i] = damping[k][i].fma(u[k], residual[i]);
                    a[k][i] = a[k][i] + damping[k][i];
                }
            }
        }
        if const { M::HEAVY && L::VECTORS > 0 } {
            let middle = turn.middle(gamma);
            let torque = cross(&middle, &constants.lever);
            for i in 0..3 {
                residual[i] = residual[i] - torque[i];
            }
            // A change e of u changes the direction in the middle by `middle x e`, itself taken in the middle.
            let of_middle = columns(&middle);
            for k in 0..3 {
                let term = cross(&turn.middle(&of_middle[k]), &constants.lever);
                for i in 0..3 {
                    a[k][i] = a[k][i] - term[i];
                }
            }
            if L::BALANCE {
                let middle = turn.middle(space);
                let of_middle = columns(&middle);
                for k in 0..3 {
                    residual[k] = residual[k] - middle[k];
                    let term = turn.middle(&of_middle[k]);
                    for i in 0..3 {
                        a[k][i] = a[k][i] - term[i];
                    }
                }
            }
        }
        if L::FUNCTION {
            let torque = self.function_torque(constants, equation, u, wanted);
            let inverse = R::splat(1.0 / DIFFERENCE);
            for i in 0..3 {
                residual[i] = residual[i] - torque[i];
            }
            for k in 0..3 {
                let mut beside = *u;
                beside[k] = u[k] + R::splat(DIFFERENCE);
                let other = self.function_torque(constants, equation, &beside, wanted);
                for i in 0..3 {
                    a[k][i] = inverse.fnma(other[i] - torque[i], a[k][i]);
                }
            }
        }
        (residual, a)
    }

    /// The torque of the function in the middle of a step that turns the body by `u`, as it stands in the equation.
    #[inline(always)]
    fn function_torque(
        &self,
        constants: &StepConstants<R>,
        equation: &Equation<R>,
        u: &[R; 3],
        wanted: R,
    ) -> [R; 3] {
        let mut torque = *u;
        R::outlined(TorqueInTheMiddle { engine: self, constants, equation, u, wanted, torque: &mut torque });
        torque
    }

    /// The solution of an equation by Newton's method, and the last correction.
    #[inline(always)]
    fn solution<M: Model<R>, L: Layout>(
        &self,
        constants: &StepConstants<R>,
        equation: &Equation<R>,
        mut u: [R; 3],
        wanted: R,
    ) -> ([R; 3], R) {
        let one = R::splat(1.0);
        let mut correction = one;
        let small = R::splat(if L::FUNCTION { SMALL_CORRECTION_BY_DIFFERENCES } else { SMALL_CORRECTION });
        for _ in 0..NEWTON_STEPS {
            // A lane that has converged or failed keeps every bit.
            let active = small.lt(correction);
            let moving = R::select(active, wanted, R::splat(0.0));
            let (residual, a) = self.residual::<M, L>(constants, equation, &u, moving);
            // Cramer's rule: the rows of the inverse are cross products of columns.
            let rows = [cross(&a[1], &a[2]), cross(&a[2], &a[0]), cross(&a[0], &a[1])];
            let inverse = one / dot(&a[0], &rows[0]);
            let mut sum = R::splat(0.0);
            for i in 0..3 {
                let by = inverse * dot(&rows[i], &residual);
                u[i] = R::select(active, u[i] - by, u[i]);
                sum = sum + by.abs();
            }
            correction = R::select(active, sum, correction);
            if !R::any(small.lt(correction)) {
                break;
            }
        }
        (u, correction)
    }

    /// The state after a step that turns the body by `u`.
    #[inline(always)]
    fn state_after<M: Model<R>, L: Layout, const D: usize>(
        &self,
        p: &Parameters<R>,
        constants: &StepConstants<R>,
        y: &[R; D],
        (u, gamma): (&[R; 3], &[R; 3]),
        wanted: R,
    ) -> [R; D] {
        let (one, two, half) = (R::splat(1.0), R::splat(2.0), constants.half);
        let heavy = const { M::HEAVY && L::VECTORS > 0 };
        let momentum = [y[0], y[1], y[2]];
        let turn = Turn::of(u);
        let mut z = *y;
        let mut middle = *y;
        for v in 0..L::VECTORS {
            let n = direction(y, v);
            put(&mut z, 3 + 3 * v, turn.end(&n));
            if L::BALANCE {
                put(&mut middle, 3 + 3 * v, turn.middle(&n));
            }
        }
        if L::QUATERNION {
            let at = L::QUATERNION_AT;
            let q = [y[at], y[at + 1], y[at + 2], y[at + 3]];
            let w = turn.inverse.sqrt();
            let by = [w, w * u[0], w * u[1], w * u[2]];
            put(&mut z, at, quaternion_product(&q, &by));
        }
        if L::BALANCE {
            // The momentum at the end follows from the mean momentum: a sum of large damping torques would cancel.
            let moves = R::splat(0.0).lt(half.abs());
            let inverse_half = one / half;
            for i in 0..3 {
                let rate = R::select(moves, inverse_half * u[i], momentum[i] / p.moments[i]);
                middle[i] = rate;
                z[i] = R::select(moves, two.fms(p.moments[i] * rate, momentum[i]), momentum[i]);
            }
            middle[L::TIME_AT] = y[L::TIME_AT] + half;
            let torque = self.applied.torque_where::<L, D>(&middle, wanted);
            let [power, impulse] = self.applied.balance::<L, D>(&torque, &middle);
            z[L::BALANCE_AT] = constants.step.fma(power, y[L::BALANCE_AT]);
            z[L::IMPULSE_AT] = constants.step.fma(impulse, y[L::IMPULSE_AT]);
            z[L::TIME_AT] = y[L::TIME_AT] + constants.step;
        } else {
            // The momentum is turned between two half kicks, so its length is conserved even if `u` is not exact.
            let mut kick = [R::splat(0.0); 3];
            if heavy {
                kick = cross(&turn.middle(gamma), &constants.kick);
            }
            let before = if heavy { plus(&momentum, &kick) } else { momentum };
            let after = turn.end(&before);
            for i in 0..3 {
                z[i] = if heavy { after[i] + kick[i] } else { after[i] };
            }
        }
        z
    }
}

impl<R: Real, M: Model<R>, L: Layout, const D: usize> Engine<R, M, L, D> for ImplicitMidpoint<R> {
    const VARIABLES: Variables = Variables::Momenta;
    const MOVES: bool = !L::FURTHER && !L::TURNS && !(M::HEAVY && L::QUATERNION);

    #[inline(always)]
    fn new(p: &Parameters<R>, interval: &ForcesInterval<'static, R>, _numbers: &'static Numbers) -> Self {
        Self::of(p, interval)
    }

    #[inline(always)]
    fn step(&self, p: &Parameters<R>, y: &mut [R; D]) {
        let (zero, one, half) = (R::splat(0.0), R::splat(1.0), R::splat(0.5));
        let largest = R::splat(LARGEST_CORRECTION);
        let (mut next, correction) = self.moved::<M, L, D>(p, &self.whole, y, one);
        // 1 in lanes with a solution; a lane with a NaN is not tried again.
        let mut done = R::select(correction.lt(largest), one, zero);
        let zero_or_nan = (y[0] * zero + y[1] * zero) + y[2] * zero;
        done = R::select(zero_or_nan.abs().lt(half), done, one);
        if R::any(done.lt(half)) {
            for parts in PARTS {
                let part = Self::constants(p, &self.interval, self.inverse, R::splat(1.0 / parts as f64));
                let mut z = *y;
                let mut all = one;
                for _ in 0..parts {
                    let (after, correction) = self.moved::<M, L, D>(p, &part, &z, one - done);
                    z = after;
                    all = R::select(correction.lt(largest), all, zero);
                }
                let active = done.lt(half);
                for d in 0..D {
                    next[d] = R::select(active, z[d], next[d]);
                }
                done = R::select(active, all, done);
                if !R::any(done.lt(half)) {
                    break;
                }
            }
            // A rejected solution becomes NaN.
            let failed = done.lt(half);
            for d in 0..D {
                next[d] = R::select(failed, R::splat(f64::NAN), next[d]);
            }
        }
        *y = next;
    }

    #[inline(always)]
    fn velocity(&self, p: &Parameters<R>, y: &[R; D]) -> [R; 3] {
        let mut rates = *y;
        for i in 0..3 {
            rates[i] = y[i] / p.moments[i];
        }
        let gyroscopic = cross(&[y[0], y[1], y[2]], &[rates[0], rates[1], rates[2]]);
        let weight = M::torque(p, y);
        let applied = if L::BALANCE { self.applied.torque::<L, D>(&rates) } else { [R::splat(0.0); 3] };
        plus(&plus(&gyroscopic, &weight), &applied)
    }
}
