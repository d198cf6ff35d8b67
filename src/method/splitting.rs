//! Splittings into exact partial flows: one engine, any composition.
//!
//! The flow of `L_k^2 / 2 I_k` is a rotation about body axis k; the flow of the potential is a kick of the
//! momentum; a symmetric body moves exactly. Each keeps the Poisson structure, so their composition does.

use super::{Facts, Form, Planar, Rotor, Scheme};
use crate::model::{self, Layout, Model, Parameters};
use crate::real::Real;
use crate::special::{rodrigues, sincos};
use std::marker::PhantomData;

/// An exactly solvable part of the motion.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Flow {
    /// Rotation about a principal axis (0, 1, 2).
    Turn(usize),
    /// Free motion of a body symmetric about axis 3.
    Rotor,
    /// The potential.
    Kick,
}

/// The table of a splitting: flows in order, each over its fraction of the step.
pub trait Composition: Copy {
    /// Name, order, properties, citation.
    const FACTS: Facts;
    /// Flows and fractions.
    const STAGES: &'static [(Flow, f64)];
}

impl Composition for Planar {
    const FACTS: Facts = Facts {
        name: "splitting",
        title: "symplectic splitting: planar rotations, or the exact rotor of a symmetric body; weight as a kick",
        order: 2,
        stages: 7,
        symplectic: true,
        reversible: true,
        group_preserving: true,
        angle_per_step: 1.0 / 16.0,
        citation: "S. Reich, Momentum conserving symplectic integrators, Physica D 76 (1994) 375-383; \
                   R. I. McLachlan, Explicit Lie-Poisson integration and the Euler equations, \
                   Phys. Rev. Lett. 71 (1993) 3043-3046; A. Dullweber, B. Leimkuhler, R. McLachlan, \
                   Symplectic splitting methods for rigid body molecular dynamics, \
                   J. Chem. Phys. 107 (1997) 5840-5851",
        doi: "10.1063/1.474310",
    };
    // The kick inside the first two rotations has the smallest error of the orders tried on three bodies.
    const STAGES: &'static [(Flow, f64)] = &[
        (Flow::Turn(0), 0.5),
        (Flow::Turn(1), 0.5),
        (Flow::Kick, 0.5),
        (Flow::Turn(2), 1.0),
        (Flow::Kick, 0.5),
        (Flow::Turn(1), 0.5),
        (Flow::Turn(0), 0.5),
    ];
}

impl Composition for Rotor {
    const FACTS: Facts = Facts { stages: 3, ..Planar::FACTS };
    const STAGES: &'static [(Flow, f64)] = &[(Flow::Kick, 0.5), (Flow::Rotor, 1.0), (Flow::Kick, 0.5)];
}

/// Consistent (the fractions of each flow sum to one) and a palindrome, hence symmetric and of order 2.
const fn check<C: Composition>() {
    let n = C::STAGES.len();
    assert!(n == C::FACTS.stages && n <= MAX_STAGES);
    let mut sums = [0.0; 5];
    let mut i = 0;
    while i < n {
        let (flow, fraction) = C::STAGES[i];
        let (mirror_flow, mirror_fraction) = C::STAGES[n - 1 - i];
        assert!(slot(flow) == slot(mirror_flow) && fraction == mirror_fraction);
        sums[slot(flow)] += fraction;
        i += 1;
    }
    let [x, y, z, rotor, kick] = sums;
    let planar = x == 1.0 && y == 1.0 && z == 1.0 && rotor == 0.0;
    let exact = x == 0.0 && y == 0.0 && z == 0.0 && rotor == 1.0;
    assert!((planar || exact) && kick == 1.0);
}
const fn slot(flow: Flow) -> usize {
    match flow {
        Flow::Turn(axis) => axis,
        Flow::Rotor => 3,
        Flow::Kick => 4,
    }
}
const _: () = check::<Planar>();
const _: () = check::<Rotor>();

/// Most flows of any table here.
const MAX_STAGES: usize = 7;

/// The engine.
pub struct Splitting<C, R> {
    /// Step over moment.
    turn: [R; 3],
    /// Step times (1/I3 - 1/I1): the spin of the rotor relative to its turning as a whole.
    spin: R,
    table: PhantomData<C>,
}

impl<C, R: Copy> Clone for Splitting<C, R> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<C, R: Copy> Copy for Splitting<C, R> {}

/// `v`, seen from a body that turned about `axis` by the angle with that sine and cosine.
#[inline(always)]
fn turn_vector<R: Real>(v: &mut [R], axis: usize, (sin, cos): (R, R)) {
    let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
    let (a, b) = (v[j], v[k]);
    v[j] = cos.fma(a, sin * b);
    v[k] = cos.fms(b, sin * a);
}

/// The body turns about a principal axis by `angle`.
#[inline(always)]
fn turn<R: Real, L: Layout, const D: usize>(y: &mut [R; D], axis: usize, angle: R) {
    let rotation = sincos(angle);
    turn_vector(&mut y[..3], axis, rotation);
    for v in 0..L::VECTORS {
        let at = 3 + 3 * v;
        turn_vector(&mut y[at..at + 3], axis, rotation);
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

/// Exact free motion of the symmetric body: everything turns about L by |L| h / I1, then the body spins
/// about its axis 3 by (1/I3 - 1/I1) L3 h; L itself is fixed in space.
#[inline(always)]
fn rotor<R: Real, L: Layout, const D: usize>(y: &mut [R; D], h_over_i1: R, spin: R) {
    let w = [h_over_i1 * y[0], h_over_i1 * y[1], h_over_i1 * y[2]];
    let z = model::dot(&w, &w);
    if L::VECTORS > 0 {
        let (a, b) = rodrigues(z);
        for v in 0..L::VECTORS {
            let n = model::direction(y, v);
            let p = model::cross(&n, &w);
            let r = model::cross(&p, &w);
            for i in 0..3 {
                y[3 + 3 * v + i] = b.fma(r[i], a.fma(p[i], n[i]));
            }
        }
    }
    if L::QUATERNION {
        let at = L::QUATERNION_AT;
        let q = [y[at], y[at + 1], y[at + 2], y[at + 3]];
        y[at..at + 4].copy_from_slice(&model::quaternion_product(&q, &model::rotation_by(&w)));
    }
    let angle = spin * y[2];
    turn::<R, L, D>(y, 2, angle);
}

impl<C: Composition, R: Real, M: Model<R>, L: Layout, const D: usize> Scheme<R, M, L, D> for Splitting<C, R> {
    const FORM: Form = Form::Momenta;

    #[inline(always)]
    fn new(p: &Parameters<R>) -> Self {
        let [i1, i2, i3] = p.moments;
        let one = R::splat(1.0);
        Splitting {
            turn: [p.step / i1, p.step / i2, p.step / i3],
            spin: p.step * (one / i3 - one / i1),
            table: PhantomData,
        }
    }

    #[inline(always)]
    fn step(&self, p: &Parameters<R>, y: &mut [R; D]) {
        macro_rules! stages {
            ($($i:literal)*) => {$(
                if const { $i < C::STAGES.len() } {
                    let (flow, fraction) = const { C::STAGES[if $i < C::STAGES.len() { $i } else { 0 }] };
                    let fraction = R::splat(fraction);
                    match flow {
                        Flow::Turn(axis) => {
                            let angle = (fraction * self.turn[axis]) * y[axis];
                            turn::<R, L, D>(y, axis, angle);
                        }
                        Flow::Rotor => rotor::<R, L, D>(y, fraction * self.turn[0], fraction * self.spin),
                        Flow::Kick => {
                            let mut momentum = [y[0], y[1], y[2]];
                            M::kick(p, fraction * p.step, &mut momentum, y);
                            y[..3].copy_from_slice(&momentum);
                        }
                    }
                }
            )*};
        }
        stages!(0 1 2 3 4 5 6);
    }

    #[inline(always)]
    fn velocity(&self, p: &Parameters<R>, y: &[R; D]) -> [R; 3] {
        // L' = L x omega + torque.
        let omega = [y[0] / p.moments[0], y[1] / p.moments[1], y[2] / p.moments[2]];
        let gyroscopic = model::cross(&[y[0], y[1], y[2]], &omega);
        let torque = M::torque(p, y);
        [gyroscopic[0] + torque[0], gyroscopic[1] + torque[1], gyroscopic[2] + torque[2]]
    }

    #[inline(always)]
    fn momentum(_p: &Parameters<R>, y: &[R; D]) -> [R; 3] {
        [y[0], y[1], y[2]]
    }

    #[inline(always)]
    fn kinetic(p: &Parameters<R>, y: &[R; D]) -> R {
        let omega = [y[0] / p.moments[0], y[1] / p.moments[1], y[2] / p.moments[2]];
        model::dot(&[y[0], y[1], y[2]], &omega) * R::splat(0.5)
    }
}
