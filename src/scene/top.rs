//! The heavy top: I omega' = (I omega) x omega + gamma x (mgl com), gamma' = gamma x omega.

use super::{ConservedMomentum, Model, Parameters, Scene};
use crate::body::Body;
use crate::dual::Dual;
use crate::forces::ParameterChange;
use crate::inertia::moment_range;
use crate::kinematics::{cross, direction, dot, plus};
use crate::real::Real;

/// The scene of a heavy top.
pub const TOP: Scene = Scene {
    kind: "top",
    has_weight: true,
    conserved: ConservedMomentum::Vertical,
    invariant_scales,
    special_case_of: None,
};

/// Kinetic energy plus `mgl`, and |L| plus `sqrt(mgl I_max)`: the invariants themselves may vanish.
fn invariant_scales(body: &Body) -> [f64; 2] {
    let (mgl, [_, largest]) = (body.mgl(), moment_range(body.moments));
    [body.kinetic_energy() + mgl, body.squared_momentum().sqrt() + (mgl * largest).sqrt()]
}

/// A body turning about a fixed point under its weight.
#[derive(Clone, Copy)]
pub struct Top<R> {
    /// (I2 - I3) / I1 and its cyclic neighbours.
    ratios: [R; 3],
    /// Component i of the torque is `plus[i] gamma[i+1] - minus[i] gamma[i+2]`, over its moment.
    plus: [R; 3],
    minus: [R; 3],
}

impl<R: Real> Model<R> for Top<R> {
    type Varied = Top<Dual<R>>;
    #[inline(always)]
    fn new(p: &Parameters<R>) -> Self {
        let [i1, i2, i3] = p.moments;
        let [c1, c2, c3] = p.weight;
        Top {
            ratios: [(i2 - i3) / i1, (i3 - i1) / i2, (i1 - i2) / i3],
            plus: [c3 / i1, c1 / i2, c2 / i3],
            minus: [c2 / i1, c3 / i2, c1 / i3],
        }
    }
    #[inline(always)]
    fn varied(&self, by: &ParameterChange<R>, inverse: &[R; 3]) -> Top<Dual<R>> {
        let (moments, [c1, c2, c3]) = (&by.moments, by.weight);
        let [d1, d2, d3] = *moments;
        Top {
            ratios: Dual::quotients(&self.ratios, [d2 - d3, d3 - d1, d1 - d2], moments, inverse),
            plus: Dual::quotients(&self.plus, [c3, c1, c2], moments, inverse),
            minus: Dual::quotients(&self.minus, [c2, c3, c1], moments, inverse),
        }
    }
    #[inline(always)]
    fn euler<const D: usize>(&self, products: &[R; 3], y: &[R; D]) -> [R; 3] {
        let [g1, g2, g3] = direction(y, 0);
        let Top { ratios: a, plus: p, minus: m } = self;
        // The weight first: it does not wait for the products.
        [
            a[0].fma(products[0], g3.fnma(m[0], g2 * p[0])),
            a[1].fma(products[1], g1.fnma(m[1], g3 * p[1])),
            a[2].fma(products[2], g2.fnma(m[2], g1 * p[2])),
        ]
    }
    #[inline(always)]
    fn ratios(&self) -> [R; 3] {
        self.ratios
    }
    #[inline(always)]
    fn in_units(&self, unit: R) -> Self {
        let Top { ratios: [a, b, c], plus: [d, e, f], minus: [g, h, i] } = *self;
        Top {
            ratios: [a * unit, b * unit, c * unit],
            plus: [d * unit, e * unit, f * unit],
            minus: [g * unit, h * unit, i * unit],
        }
    }
    #[inline(always)]
    fn kick<const D: usize>(p: &Parameters<R>, h: R, momentum: &mut [R; 3], y: &[R; D]) {
        let torque = Self::torque(p, y);
        for i in 0..3 {
            momentum[i] = h.fma(torque[i], momentum[i]);
        }
    }
    #[inline(always)]
    fn gradient_kick<const D: usize>(p: &Parameters<R>, h: R, weight: R, momentum: &mut [R; 3], y: &[R; D]) {
        // A kick by the weight h c - 2 w c x (torque / I).
        let torque = Self::torque(p, y);
        let mut acceleration = torque;
        for i in 0..3 {
            acceleration[i] = torque[i] / p.moments[i];
        }
        let lever = cross(&p.weight, &acceleration);
        let twice = weight + weight;
        let mut impulse = p.weight;
        for i in 0..3 {
            impulse[i] = twice.fnma(lever[i], h * p.weight[i]);
        }
        let kick = cross(&direction(y, 0), &impulse);
        *momentum = plus(momentum, &kick);
    }
    #[inline(always)]
    fn torque<const D: usize>(p: &Parameters<R>, y: &[R; D]) -> [R; 3] {
        cross(&direction(y, 0), &p.weight)
    }
    #[inline(always)]
    fn potential<const D: usize>(p: &Parameters<R>, y: &[R; D]) -> R {
        dot(&p.weight, &direction(y, 0))
    }
    #[inline(always)]
    fn conserved<const D: usize>(momentum: &[R; 3], y: &[R; D]) -> R {
        dot(momentum, &direction(y, 0))
    }
}
