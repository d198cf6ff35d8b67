//! The free body: I omega' = (I omega) x omega (Euler 1758).

use super::{ConservedMomentum, Model, Parameters, Scene, TOP};
use crate::dual::Dual;
use crate::forces::ParameterChange;
use crate::kinematics::dot;
use crate::real::Real;

/// The scene of a free body: a top without weight.
pub const FREE: Scene = Scene {
    kind: "free",
    has_weight: false,
    conserved: ConservedMomentum::Square,
    // The scale `2 L.L` makes the relative drift of `L.L` that of |L|.
    invariant_scales: |body| [body.kinetic_energy(), 2.0 * body.squared_momentum()],
    special_case_of: Some(&TOP),
};

/// A body under no torque.
#[derive(Clone, Copy)]
pub struct Free<R> {
    /// (I2 - I3) / I1 and its cyclic neighbours.
    ratios: [R; 3],
}

impl<R: Real> Model<R> for Free<R> {
    const HEAVY: bool = false;
    type Varied = Free<Dual<R>>;

    #[inline(always)]
    fn new(p: &Parameters<R>) -> Self {
        let [i1, i2, i3] = p.moments;
        Free { ratios: [(i2 - i3) / i1, (i3 - i1) / i2, (i1 - i2) / i3] }
    }
    #[inline(always)]
    fn varied(&self, by: &ParameterChange<R>, inverse: &[R; 3]) -> Free<Dual<R>> {
        let [d1, d2, d3] = by.moments;
        Free { ratios: Dual::quotients(&self.ratios, [d2 - d3, d3 - d1, d1 - d2], &by.moments, inverse) }
    }
    #[inline(always)]
    fn euler<const D: usize>(&self, products: &[R; 3], _y: &[R; D]) -> [R; 3] {
        let [a1, a2, a3] = self.ratios;
        [a1 * products[0], a2 * products[1], a3 * products[2]]
    }
    #[inline(always)]
    fn ratios(&self) -> [R; 3] {
        self.ratios
    }
    #[inline(always)]
    fn in_units(&self, unit: R) -> Self {
        let [a, b, c] = self.ratios;
        Free { ratios: [a * unit, b * unit, c * unit] }
    }
    #[inline(always)]
    fn kick<const D: usize>(_p: &Parameters<R>, _h: R, _momentum: &mut [R; 3], _y: &[R; D]) {}
    #[inline(always)]
    fn gradient_kick<const D: usize>(
        _p: &Parameters<R>,
        _h: R,
        _weight: R,
        _momentum: &mut [R; 3],
        _y: &[R; D],
    ) {
    }
    #[inline(always)]
    fn torque<const D: usize>(_p: &Parameters<R>, _y: &[R; D]) -> [R; 3] {
        [R::splat(0.0); 3]
    }
    #[inline(always)]
    fn potential<const D: usize>(_p: &Parameters<R>, _y: &[R; D]) -> R {
        R::splat(0.0)
    }
    #[inline(always)]
    fn conserved<const D: usize>(momentum: &[R; 3], _y: &[R; D]) -> R {
        dot(momentum, momentum)
    }
}
