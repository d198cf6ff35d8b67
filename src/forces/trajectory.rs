//! The gravity gradient along a trajectory that a table gives: the torque `c x I c`, `c = sqrt(3 gm / r^3) o` in the
//! body, `o` the direction from the planet to the body (Hughes, Spacecraft Attitude Dynamics, 1986, §8.1). In space c is
//! a cubic polynomial of the time between two knots: no kernel needs a root, nor a variable of the trajectory.

use super::orbit::{add_products, to_body};
use crate::kinematics::{dot, plus};
use crate::real::{Outlined, Real};
use crate::series::{Coefficients, VectorSeries};
use crate::special::{exp, ln};

/// Coefficients of c in space, of the powers of the time since the begin of an interval; zeros without a trajectory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trajectory<R>(pub [[R; 3]; 4]);

/// Coefficients beside those of the state.
pub struct TrajectorySeries<R> {
    /// Whether there is a trajectory in some lane.
    acts: bool,
    /// Those of c in space, from the time of the state on.
    in_space: VectorSeries<R>,
    /// Those of c in the body.
    roots: VectorSeries<R>,
}

impl<R: Real> TrajectorySeries<R> {
    /// No coefficients yet.
    #[inline(always)]
    #[allow(clippy::new_without_default)] // A default would be taken for zero.
    pub fn new() -> Self {
        TrajectorySeries { acts: false, in_space: VectorSeries::new(), roots: VectorSeries::new() }
    }
}

/// The torque from the products `c2 c3`, `c3 c1`, `c1 c2`, added to a sum; linear in the moments and in the products.
#[inline(always)]
fn add_gradient<R: Real>([i1, i2, i3]: &[R; 3], products: &[R; 3], torque: &mut [R; 3]) {
    torque[0] = (*i3 - *i2).fma(products[0], torque[0]);
    torque[1] = (*i1 - *i3).fma(products[1], torque[1]);
    torque[2] = (*i2 - *i1).fma(products[2], torque[2]);
}

/// The place in space where c is this, over the length `gm^(1/3)`; zero where c is.
pub struct PlaceOfRoot<R>(pub [R; 3]);

impl<R: Real> Outlined for PlaceOfRoot<R> {
    type Out = [R; 3];
    #[inline(always)]
    fn run(self) -> [R; 3] {
        let (PlaceOfRoot(mut place), zero) = (self, R::splat(0.0));
        let square = dot(&place, &place);
        let distance = exp(ln(R::splat(3.0) / square) * R::splat(1.0 / 3.0));
        let scale = R::select(zero.lt(square), distance / square.sqrt(), zero);
        for part in &mut place {
            *part = *part * scale;
        }
        place
    }
}

impl<R: Real> Trajectory<R> {
    /// Whether there is a trajectory in some lane.
    #[inline(always)]
    pub fn acts(&self) -> bool {
        let mut largest = R::splat(0.0);
        for k in 0..4 {
            for i in 0..3 {
                largest = largest.max(self.0[k][i].abs());
            }
        }
        R::any(R::splat(0.0).lt(largest))
    }

    /// The coefficients from a later time on.
    #[inline(always)]
    fn from(&self, time: R) -> [[R; 3]; 4] {
        let (mut shifted, three) = (self.0, R::splat(3.0));
        for i in 0..3 {
            let [a, b, c, d] = [self.0[0][i], self.0[1][i], self.0[2][i], self.0[3][i]];
            shifted[0][i] = time.fma(time.fma(time.fma(d, c), b), a);
            shifted[1][i] = time.fma(time.fma(three * d, c + c), b);
            shifted[2][i] = time.fma(three * d, c);
        }
        shifted
    }

    /// c in space at a time.
    #[inline(always)]
    pub fn root(&self, time: R) -> [R; 3] {
        let [mut sum, .., last] = self.0;
        for i in 0..3 {
            sum[i] = time.fma(time.fma(time.fma(last[i], self.0[2][i]), self.0[1][i]), sum[i]);
        }
        sum
    }

    /// Adds the torque at a state and a time to `torque`.
    #[inline(always)]
    pub fn add_torque<const D: usize>(&self, moments: &[R; 3], y: &[R; D], time: R, torque: &mut [R; 3]) {
        let root = to_body(&self.root(time), y);
        let mut products = [R::splat(0.0); 3];
        add_products(&root, &root, &mut products);
        add_gradient(moments, &products, torque);
    }

    /// Adds the coefficient of order k of the torque to `torque`. The calls are for ascending orders; `time` is the index
    /// of the time in a state, `unit` the unit of the series.
    #[inline(always)]
    pub fn add_order<const D: usize>(
        &self,
        moments: &[R; 3],
        c: &Coefficients<R, D>,
        (k, time, unit): (usize, usize, R),
        series: &mut TrajectorySeries<R>,
        torque: &mut [R; 3],
    ) {
        if k == 0 {
            series.acts = self.acts();
        }
        if !series.acts {
            return;
        }
        if k == 0 {
            let (rows, mut power) = (self.from(c.order(0)[time]), R::splat(1.0));
            for order in 0..4 {
                let row = rows[order];
                series.in_space.push(order, [row[0] * power, row[1] * power, row[2] * power]);
                power = power * unit;
            }
        }
        let (mut root, mut products) = ([R::splat(0.0); 3], [R::splat(0.0); 3]);
        for j in 0..=k.min(3) {
            // SAFETY: the call for the order 0 has pushed four rows.
            let power = unsafe { series.in_space.order(j) };
            root = plus(&root, &to_body(power, c.order(k - j)));
        }
        series.roots.push(k, root);
        for j in 0..=k {
            // SAFETY: the calls for the orders 0 to k, one each and ascending, have pushed the rows 0 to k.
            let (one, other) = unsafe { (series.roots.order(j), series.roots.order(k - j)) };
            add_products(one, other, &mut products);
        }
        add_gradient(moments, &products, torque);
    }
}
