//! The gravity gradient on a circular orbit: the torque `3 n^2 o x I o`, `o` the direction to the centre (Hughes,
//! Spacecraft Attitude Dynamics, 1986, §8.1).

use super::{Bounded, Force, Order, range};
use crate::error::Error;
use crate::kinematics::{cross, direction, dot, put};
use crate::real::Real;
use crate::series::{Coefficients, VectorSeries};
use crate::special::sincos;

/// The rate of the orbit, 0 without one; the direction to the centre at time 0, and that a quarter of an orbit later,
/// unit vectors in space. The variables are cosine and sine of the angle on the orbit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GravityGradient<R>(pub [R; 7]);

impl<R: Real> GravityGradient<R> {
    #[inline(always)]
    fn rate(&self) -> R {
        self.0[0]
    }

    #[inline(always)]
    fn towards(&self) -> [R; 3] {
        [self.0[1], self.0[2], self.0[3]]
    }

    #[inline(always)]
    fn ahead(&self) -> [R; 3] {
        [self.0[4], self.0[5], self.0[6]]
    }

    /// The direction to the centre, from cosine and sine of the angle on the orbit and the space axes of a state, or of
    /// one order of it; linear in both.
    #[inline(always)]
    fn centre<const D: usize>(&self, [cos, sin]: [R; 2], y: &[R; D]) -> [R; 3] {
        let (towards, ahead) = (self.towards(), self.ahead());
        let mut part = towards;
        for k in 0..3 {
            part[k] = cos.fma(towards[k], sin * ahead[k]);
        }
        // The third row of the matrix, the vertical, comes first in the state.
        let (z, x, y) = (direction(y, 0), direction(y, 1), direction(y, 2));
        let mut sum = part;
        for i in 0..3 {
            sum[i] = part[2].fma(z[i], part[0].fma(x[i], part[1] * y[i]));
        }
        sum
    }

    /// Adds the torque from the products `o2 o3`, `o3 o1`, `o1 o2`, in which it is linear.
    #[inline(always)]
    fn add(&self, [i1, i2, i3]: &[R; 3], products: &[R; 3], torque: &mut [R; 3]) {
        let strength = R::splat(3.0) * (self.rate() * self.rate());
        torque[0] = torque[0] + strength * (*i3 - *i2) * products[0];
        torque[1] = torque[1] + strength * (*i1 - *i3) * products[1];
        torque[2] = torque[2] + strength * (*i2 - *i1) * products[2];
    }

    /// The rates of change of cosine and sine; linear.
    #[inline(always)]
    fn turn(&self, [cos, sin]: [R; 2]) -> [R; 2] {
        [-(self.rate() * sin), self.rate() * cos]
    }
}

impl<R: Real> Force<R> for GravityGradient<R> {
    const IN_SPACE: bool = true;
    const VARIABLES: usize = 2;
    /// Of the direction to the centre.
    type Series = VectorSeries<R>;

    #[inline(always)]
    fn series() -> VectorSeries<R> {
        VectorSeries::new()
    }

    #[inline(always)]
    fn add_torque<const D: usize>(&self, moments: &[R; 3], y: &[R; D], own: usize, torque: &mut [R; 3]) {
        let [o1, o2, o3] = self.centre([y[own], y[own + 1]], y);
        self.add(moments, &[o2 * o3, o3 * o1, o1 * o2], torque);
    }

    #[inline(always)]
    fn add_order<const D: usize>(
        &self,
        moments: &[R; 3],
        c: &Coefficients<R, D>,
        Order { k, own, factor }: Order<R>,
        centres: &mut VectorSeries<R>,
        next: &mut [R; D],
        torque: &mut [R; 3],
    ) {
        let mut centre = [R::splat(0.0); 3];
        for j in 0..=k {
            let part = self.centre([c.order(j)[own], c.order(j)[own + 1]], c.order(k - j));
            centre = [centre[0] + part[0], centre[1] + part[1], centre[2] + part[2]];
        }
        centres.push(k, centre);
        let mut products = [R::splat(0.0); 3];
        for j in 0..=k {
            // SAFETY: the calls for the orders 0 to k, one each and ascending, have pushed the rows 0 to k.
            let (a, b) = unsafe { (centres.order(j), centres.order(k - j)) };
            products =
                [a[1].fma(b[2], products[0]), a[2].fma(b[0], products[1]), a[0].fma(b[1], products[2])];
        }
        self.add(moments, &products, torque);
        let of_k = c.order(k);
        let [cos, sin] = self.turn([of_k[own], of_k[own + 1]]);
        put(next, own, [factor * cos, factor * sin]);
    }

    #[inline(always)]
    fn change<const D: usize>(&self, y: &[R; D], own: usize, change: &mut [R; D]) {
        put(change, own, self.turn([y[own], y[own + 1]]));
    }
}

impl GravityGradient<f64> {
    /// The normal of the orbit in space, if there is one.
    pub fn normal(&self) -> Option<[f64; 3]> {
        (!self.is_none()).then(|| cross(&self.towards(), &self.ahead()))
    }
}

impl Bounded for GravityGradient<f64> {
    fn check(&self) -> Result<(), Error> {
        let (towards, ahead) = (self.towards(), self.ahead());
        let off = [dot(&towards, &towards) - 1.0, dot(&ahead, &ahead) - 1.0, dot(&towards, &ahead)];
        if self.rate() != 0.0 && off.iter().any(|x| x.abs() > 1e-12) {
            let (value, rule) =
                (format!("{towards:?}"), "must be a unit vector across the normal of the orbit");
            return Err(Error::Value { argument: "towards", value, rule });
        }
        Ok(())
    }

    fn is_none(&self) -> bool {
        self.rate() == 0.0
    }

    fn drives(&self) -> bool {
        !self.is_none()
    }

    fn strength(&self, moments: [f64; 3]) -> f64 {
        let [least, largest] = range(moments);
        1.5 * self.rate() * self.rate() * (largest - least) / least.sqrt()
    }

    /// In the frame of the orbit the Jacobi integral is constant, and its potential `n^2 (3 o.Io - N.IN) / 2`, N
    /// along the normal, has the depth `2 n^2 (I_max - I_min)`.
    fn reach(&self, moments: [f64; 3], root: f64) -> [f64; 2] {
        if self.is_none() {
            return [root, 0.0];
        }
        let [least, largest] = range(moments);
        let turning = self.rate().abs() * largest.sqrt();
        let depth = 4.0 * self.rate() * self.rate() * (largest - least);
        [((root + turning) * (root + turning) + depth).sqrt(), turning]
    }

    fn start(&self, time: f64, variables: &mut [f64]) {
        let (sin, cos) = sincos(self.rate() * time);
        variables[..2].copy_from_slice(&[cos, sin]);
    }
}
