//! How a method integrates a body in a kernel: the step, and the axes that the step needs.

use crate::body::Body;
use crate::method::{Method, Step, Variables};
use crate::observe::Deviation;
use crate::scene::Scene;

/// How a kernel integrates a body: the step, and the cyclic permutation of the body axes that the step needs.
///
/// A cyclic permutation is exact. Kernel axis i is body axis (i + shift) mod 3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KernelAssignment {
    /// The step of the method for this body.
    pub step: Step,
    /// The permutation.
    shift: usize,
}

impl KernelAssignment {
    /// The assignment of a body, in its own frame.
    ///
    /// The rotor needs the symmetry axis third. The error of planar rotations is four to eight times smaller with the
    /// smallest moment first than with the smallest moment in the middle. Steps that evaluate the equations of motion
    /// use the axes of the user.
    pub fn of(method: &Method, body: &Body, scene: &Scene) -> KernelAssignment {
        let (step, shift) = match body.symmetry_axis() {
            Some(axis) => (method.symmetric, (axis + 1) % 3),
            None => (method.any, body.smallest_moment()),
        };
        let step = if scene.has_weight { step } else { step.torque_free() };
        let shift = if step.engine.variables() == Variables::Rates { 0 } else { shift };
        KernelAssignment { step, shift }
    }

    /// The assignment of a body that is forced, or not.
    pub fn of_either(is_forced: bool, method: &Method, body: &Body, scene: &Scene) -> KernelAssignment {
        if is_forced {
            KernelAssignment::of_forced(method)
        } else {
            KernelAssignment::of(method, body, scene)
        }
    }

    /// The assignment of a body on an orbit on which nothing else acts, by steps over its anomaly if the method has them.
    pub fn on_orbit(method: &Method) -> Option<KernelAssignment> {
        Some(KernelAssignment { step: method.forced?.step.on_orbit()?, shift: 0 })
    }

    /// The assignment of a forced body, in the axes of the user. Panics if the method does not integrate forced bodies.
    pub fn of_forced(method: &Method) -> KernelAssignment {
        let forced = method.forced.expect("checked when the request was made");
        KernelAssignment { step: forced.step, shift: 0 }
    }

    /// A deviation vector in the variables of the kernel: a change of momenta, if the kernel integrates them.
    pub fn deviation(self, deviation: &Deviation, body: &Body) -> Deviation {
        let [d1, d2, d3, x1, x2, x3] = deviation.start;
        let (mut d, x) = (self.to_kernel_axes([d1, d2, d3]), self.to_kernel_axes([x1, x2, x3]));
        let mut inverse_scale = self.to_kernel_axes(deviation.inverse_scale);
        if self.step.engine.variables() == Variables::Momenta {
            let moments = self.to_kernel_axes(body.moments);
            for k in 0..3 {
                d[k] *= moments[k];
                inverse_scale[k] /= moments[k];
            }
        }
        Deviation { start: [d[0], d[1], d[2], x[0], x[1], x[2]], inverse_scale, ..*deviation }
    }

    /// The deviation vector with these numbers of the kernel: a change of the rates and a rotation vector, in the axes
    /// of the user.
    pub(super) fn deviation_of(self, [mut d, x]: [[f64; 3]; 2], moments: [f64; 3]) -> [f64; 6] {
        if self.step.engine.variables() == Variables::Momenta {
            for k in 0..3 {
                d[k] /= moments[k];
            }
        }
        let ([d1, d2, d3], [x1, x2, x3]) = (self.to_body_axes(d), self.to_body_axes(x));
        [d1, d2, d3, x1, x2, x3]
    }

    #[inline(always)]
    pub(super) fn to_kernel_axes(self, [a, b, c]: [f64; 3]) -> [f64; 3] {
        match self.shift {
            0 => [a, b, c],
            1 => [b, c, a],
            _ => [c, a, b],
        }
    }

    #[inline(always)]
    pub(super) fn to_body_axes(self, [a, b, c]: [f64; 3]) -> [f64; 3] {
        match self.shift {
            0 => [a, b, c],
            1 => [c, a, b],
            _ => [b, c, a],
        }
    }
}
