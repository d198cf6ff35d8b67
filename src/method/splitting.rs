//! Splittings into exact partial flows: one engine, any composition.
//!
//! The flow of `L_k^2 / 2 I_k` is a rotation about body axis k; the flow of the potential is a kick of the momentum;
//! between kicks the body drifts freely. Each flow preserves the Poisson structure, so a composition of flows does too.
//!
//! A deviation vector is a change d of the momenta and a rotation vector x in the body, `R -> R exp(hat(x))`. It is
//! moved by the derivative of each flow, so it is the derivative of the step to rounding, and symplectic at any step.

use super::{Engine, Numbers, Variables};
use crate::forces::ForcesInterval;
use crate::kinematics::{self, plus};
use crate::real::Real;
use crate::scene::{Layout, Model, Parameters};
use crate::special::{rodrigues, sincos};

/// An exactly solvable part of the motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flow {
    /// Rotation about a principal axis (0, 1, 2).
    Turn(usize),
    /// Free motion.
    Drift,
    /// The potential, with or without its force gradient.
    Kick,
}

/// Free motion over fractions of a step, exact or of the order in the numbers of a method.
pub trait Drift<R: Real>: Copy {
    /// Whether the motion moves a deviation vector too.
    const HAS_TANGENT: bool = false;
    /// Prepares the constants of the step.
    fn new(p: &Parameters<R>, numbers: &Numbers) -> Self;
    /// Moves the state over a fraction of the step.
    fn flow<M: Model<R>, L: Layout, const D: usize>(&self, fraction: R, y: &mut [R; D]);
}

/// A round of flows, which a step repeats with its numbers.
pub trait Round: Copy {
    /// The flow of `Flow::Drift`.
    type Drift<R: Real>: Drift<R>;
    /// The flows of a round, in order.
    const FLOWS: &'static [Flow];
    /// The numbers for which the code is specialised, if any: a step of one round is then faster by a tenth.
    const SPECIALISED: Option<&'static Numbers> = None;
    /// Whether the composition may have a processor.
    const PROCESSED: bool = false;
}

/// This order of the flows has the smallest error of all orders tried on three bodies.
const PLANAR: &[Flow] = &[Flow::Turn(0), Flow::Turn(1), Flow::Kick, Flow::Turn(2), Flow::Kick, Flow::Turn(1)];
const KICK_DRIFT: &[Flow] = &[Flow::Kick, Flow::Drift];

/// Planar rotations about the principal axes, and kicks, of order 2.
#[derive(Clone, Copy)]
pub struct Planar;
impl Round for Planar {
    type Drift<R: Real> = ExactRotor<R>;
    const FLOWS: &'static [Flow] = PLANAR;
    const SPECIALISED: Option<&'static Numbers> = Some(super::SPLITTING.any.numbers);
}

/// Planar rotations about the principal axes, and kicks.
#[derive(Clone, Copy)]
pub struct ComposedPlanar;
impl Round for ComposedPlanar {
    type Drift<R: Real> = ExactRotor<R>;
    const FLOWS: &'static [Flow] = PLANAR;
}

/// The exact rotor of a body that is symmetric about its axis 3, and kicks.
#[derive(Clone, Copy)]
pub struct KickRotor;
impl Round for KickRotor {
    type Drift<R: Real> = ExactRotor<R>;
    const FLOWS: &'static [Flow] = KICK_DRIFT;
    const PROCESSED: bool = true;
}

/// Discrete Moser-Veselov drifts of any body, and kicks.
#[derive(Clone, Copy)]
pub struct KickMoserVeselov;
impl Round for KickMoserVeselov {
    type Drift<R: Real> = super::MoserVeselov<R>;
    const FLOWS: &'static [Flow] = KICK_DRIFT;
    const PROCESSED: bool = true;
}

/// A change of variables by rounds of a kick and a drift. A kernel of low order between a processor and its inverse is
/// a method of higher order (Butcher 1969; Blanes, Casas, Ros 1999).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Processor {
    /// Before the first step.
    pub enter: Composition,
    /// After the last step: the inverse.
    pub leave: Composition,
}

/// Rounds of a kick and a drift.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Composition {
    /// Fractions of the step, kick and drift in turn.
    pub fractions: &'static [f64],
    /// Weight of the force gradient in each kick, as in `Numbers`.
    pub gradients: &'static [f64],
}

/// The engine.
#[derive(Clone, Copy)]
pub struct Splitting<C: Round, R: Real> {
    /// Step over moment.
    turn: [R; 3],
    drift: C::Drift<R>,
    numbers: &'static Numbers,
}

/// `v` in the components of a body that turned about `axis` by the angle with this sine and cosine.
#[inline(always)]
fn turn_vector<R: Real>(v: &mut [R], axis: usize, (sin, cos): (R, R)) {
    let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
    let (a, b) = (v[j], v[k]);
    v[j] = cos.fma(a, sin * b);
    v[k] = cos.fms(b, sin * a);
}

/// Turns the body about a principal axis by `angle`.
#[inline(always)]
pub(super) fn turn<R: Real, L: Layout, const D: usize>(y: &mut [R; D], axis: usize, angle: R) {
    let rotation = sincos(angle);
    turn_vector(&mut y[..3], axis, rotation);
    for v in 0..L::VECTORS {
        let at = 3 + 3 * v;
        turn_vector(&mut y[at..at + 3], axis, rotation);
    }
    if L::TANGENT {
        for at in [L::TANGENT_AT, L::TANGENT_AT + 3] {
            turn_vector(&mut y[at..at + 3], axis, rotation);
        }
    }
    if L::QUATERNION {
        let (s, c) = sincos(angle * R::splat(0.5));
        let at = L::QUATERNION_AT;
        let q = [y[at], y[at + 1], y[at + 2], y[at + 3]];
        let (i, j, k) = (axis + 1, (axis + 1) % 3 + 1, (axis + 2) % 3 + 1);
        y[at] = c.fms(q[0], s * q[i]);
        y[at + i] = c.fma(q[i], s * q[0]);
        y[at + j] = c.fma(q[j], s * q[k]);
        y[at + k] = c.fms(q[k], s * q[j]);
    }
}

/// Turns the body about a principal axis by `factor` times its momentum about this axis.
#[inline(always)]
fn turn_by_momentum<R: Real, L: Layout, const D: usize>(y: &mut [R; D], axis: usize, factor: R) {
    turn::<R, L, D>(y, axis, factor * y[axis]);
    if L::TANGENT {
        // The momentum about the axis stays, and so does its change.
        let (j, k, at) = ((axis + 1) % 3, (axis + 2) % 3, L::TANGENT_AT);
        let further = factor * y[at + axis];
        y[at + j] = further.fma(y[k], y[at + j]);
        y[at + k] = further.fnma(y[j], y[at + k]);
        y[at + 3 + axis] = y[at + 3 + axis] + further;
    }
}

/// The free motion of a body symmetric about axis 3, exact for any step.
#[derive(Clone, Copy)]
pub struct ExactRotor<R> {
    h_over_i1: R,
    /// Step times (1/I3 - 1/I1), the factor of L3 in the spin about axis 3.
    spin: R,
}

impl<R: Real> Drift<R> for ExactRotor<R> {
    const HAS_TANGENT: bool = true;

    #[inline(always)]
    fn new(p: &Parameters<R>, _numbers: &Numbers) -> Self {
        let [i1, _, i3] = p.moments;
        let one = R::splat(1.0);
        ExactRotor { h_over_i1: p.step / i1, spin: p.step * (one / i3 - one / i1) }
    }

    /// The body turns about L by |L| h / I1, then the body spins about its axis 3 by (1/I3 - 1/I1) L3 h; L is constant
    /// in space. A sphere has no second rotation.
    #[inline(always)]
    fn flow<M: Model<R>, L: Layout, const D: usize>(&self, fraction: R, y: &mut [R; D]) {
        let h_over_i1 = fraction * self.h_over_i1;
        let w = [h_over_i1 * y[0], h_over_i1 * y[1], h_over_i1 * y[2]];
        let z = kinematics::dot(&w, &w);
        if L::VECTORS > 0 {
            let (a, b) = rodrigues(z);
            for v in 0..L::VECTORS {
                let n = kinematics::direction(y, v);
                let p = kinematics::cross(&n, &w);
                let r = kinematics::cross(&p, &w);
                for i in 0..3 {
                    y[3 + 3 * v + i] = b.fma(r[i], a.fma(p[i], n[i]));
                }
            }
            if L::TANGENT {
                let at = L::TANGENT_AT;
                let change = [h_over_i1 * y[at], h_over_i1 * y[at + 1], h_over_i1 * y[at + 2]];
                let x = [y[at + 3], y[at + 4], y[at + 5]];
                kinematics::put(y, at + 3, turned_by(&w, (z, a, b), &change, x));
            }
        }
        if L::QUATERNION {
            let at = L::QUATERNION_AT;
            let q = [y[at], y[at + 1], y[at + 2], y[at + 3]];
            kinematics::put(y, at, kinematics::quaternion_product(&q, &kinematics::rotation_by(&w)));
        }
        turn_by_momentum::<R, L, D>(y, 2, fraction * self.spin);
    }
}

/// A rotation vector x after the body has turned by w, and further by the change of w: the rotation of x, and the right
/// Jacobian of the exponential map (Chirikjian, Stochastic Models, Information Theory, and Lie Groups 2, §10.6)
/// `a + (1 - a) w w.T / z - b hat(w)` on the change, with `z = w.w` and Rodrigues' coefficients a and b.
#[inline(always)]
fn turned_by<R: Real>(w: &[R; 3], (z, a, b): (R, R, R), change: &[R; 3], x: [R; 3]) -> [R; 3] {
    let mut first = *change;
    kinematics::add_cross(&x, w, &mut first);
    let second = kinematics::cross(&first, w);
    // The digits that 1 - a loses are below those of the change, and so is all of it if z underflows.
    let share = (R::splat(1.0) - a) / z.max(R::splat(f64::MIN_POSITIVE));
    let along = share * kinematics::dot(w, change);
    let mut turned = x;
    for i in 0..3 {
        turned[i] = along.fma(w[i], b.fma(second[i], a.fma(first[i], x[i])));
    }
    turned
}

/// The code of flow `i` of a round; `NONE` beyond the round.
const fn flow_code_at<C: Round>(i: usize) -> usize {
    if i < C::FLOWS.len() { flow_code(C::FLOWS[i]) } else { NONE }
}
pub(super) const fn flow_code(flow: Flow) -> usize {
    match flow {
        Flow::Turn(axis) => axis,
        Flow::Drift => DRIFT,
        Flow::Kick => KICK,
    }
}
pub(super) const DRIFT: usize = 3;
pub(super) const KICK: usize = 4;
const NONE: usize = 5;

/// The flow of the potential over a fraction of the step. Steps with a force gradient have no tangent.
#[inline(always)]
fn kick<R: Real, M: Model<R>, L: Layout, const D: usize>(
    p: &Parameters<R>,
    y: &mut [R; D],
    fraction: f64,
    gradient: f64,
) {
    let mut momentum = [y[0], y[1], y[2]];
    let h = R::splat(fraction) * p.step;
    if L::TANGENT {
        // A kick is linear in the vertical n, which the deviation vector changes by n x x.
        let at = L::TANGENT_AT;
        let (mut change, x) = ([y[at], y[at + 1], y[at + 2]], [y[at + 3], y[at + 4], y[at + 5]]);
        let mut varied = *y;
        kinematics::put(&mut varied, 3, kinematics::cross(&kinematics::direction(y, 0), &x));
        M::kick(p, h, &mut change, &varied);
        kinematics::put(y, at, change);
    }
    if L::TANGENT || gradient == 0.0 {
        M::kick(p, h, &mut momentum, y);
    } else {
        let cubed = (p.step * p.step) * p.step;
        M::gradient_kick(p, h, R::splat(gradient) * cubed, &mut momentum, y);
    }
    kinematics::put(y, 0, momentum);
}

impl<C: Round, R: Real, M: Model<R>, L: Layout, const D: usize> Engine<R, M, L, D> for Splitting<C, R> {
    const VARIABLES: Variables = Variables::Momenta;
    // Layouts with two directions have no processor, because the directions are observed.
    const MOVES: bool = !L::BALANCE && !L::CHANGED && !L::TURNS;
    const PROCESSED: bool = C::PROCESSED && M::HEAVY && L::VECTORS < 2 && !L::TANGENT;
    const HAS_TANGENT: bool = <C::Drift<R> as Drift<R>>::HAS_TANGENT;
    const FLOWS: Option<&'static [Flow]> = Some(C::FLOWS);

    #[inline(always)]
    fn new(p: &Parameters<R>, _forces: &ForcesInterval<'static, R>, numbers: &'static Numbers) -> Self {
        let [i1, i2, i3] = p.moments;
        Splitting { turn: [p.step / i1, p.step / i2, p.step / i3], drift: C::Drift::new(p, numbers), numbers }
    }

    #[inline(always)]
    fn step(&self, p: &Parameters<R>, y: &mut [R; D]) {
        let width = const {
            assert!(C::FLOWS.len() <= 6);
            C::FLOWS.len()
        };
        let own = match const { C::SPECIALISED } {
            Some(own) => own,
            None => self.numbers,
        };
        let Numbers { fractions, gradients, .. } = own;
        // Only the flows of one round are unrolled, so the length of the code does not depend on the number of rounds.
        macro_rules! flows {
            ($round:expr; $($i:literal)*) => {$(
                if const { flow_code_at::<C>($i) != NONE } {
                    let fraction = fractions[$round * width + $i];
                    if const { flow_code_at::<C>($i) < DRIFT } {
                        let axis = const { flow_code_at::<C>($i) % DRIFT };
                        turn_by_momentum::<R, L, D>(y, axis, R::splat(fraction) * self.turn[axis]);
                    } else if const { flow_code_at::<C>($i) == DRIFT } {
                        self.drift.flow::<M, L, D>(R::splat(fraction), y);
                    } else {
                        let gradient = if gradients.is_empty() { 0.0 } else { gradients[$round] };
                        kick::<R, M, L, D>(p, y, fraction, gradient);
                    }
                }
            )*};
        }
        let rounds = fractions.len() / width;
        for round in 0..rounds {
            flows!(round; 0 1 2 3 4 5);
        }
        // A palindrome ends with its first flow.
        if fractions.len() > rounds * width {
            flows!(rounds; 0);
        }
    }

    #[inline(always)]
    fn process(&self, p: &Parameters<R>, y: &mut [R; D], leaving: bool) {
        if let Some(Processor { enter, leave }) = self.numbers.processor {
            let composition = if leaving { leave } else { enter };
            for round in 0..composition.gradients.len() {
                kick::<R, M, L, D>(p, y, composition.fractions[2 * round], composition.gradients[round]);
                self.drift.flow::<M, L, D>(R::splat(composition.fractions[2 * round + 1]), y);
            }
        }
    }

    #[inline(always)]
    fn velocity(&self, p: &Parameters<R>, y: &[R; D]) -> [R; 3] {
        // L' = L x omega + torque.
        let omega = [y[0] / p.moments[0], y[1] / p.moments[1], y[2] / p.moments[2]];
        let gyroscopic = kinematics::cross(&[y[0], y[1], y[2]], &omega);
        let torque = M::torque(p, y);
        plus(&gyroscopic, &torque)
    }
}
