//! Quadratic drag: the torque `-|omega| c omega`, `c` one coefficient for each body axis. At large Reynolds numbers the
//! moment of a rotating sphere or disk over the square of its rate varies slowly (rotating disk: von Kármán, Z. angew.
//! Math. Mech. 1, 1921, doi 10.1002/zamm.19210010401: the power 9/5).

use super::{Bounded, Force, Order, Pace, not_negative};
use crate::error::Error;
use crate::kinematics::speed;
use crate::real::Real;
use crate::series::{Coefficients, VectorSeries};

/// The coefficients `c` along the body axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drag<R>(pub [R; 3]);

impl<R: Real> Drag<R> {
    /// Which bodies have drag, or a change of their drag.
    #[inline(always)]
    fn acts(&self) -> R::Mask {
        let [c1, c2, c3] = self.0;
        R::splat(0.0).lt(c1.size() + c2.size() + c3.size())
    }

    /// Adds the drag to a torque, where there is one, from the products of speed and rates; linear.
    #[inline(always)]
    fn add(&self, products: &[R; 3], torque: &mut [R; 3]) {
        let acts = self.acts();
        for i in 0..3 {
            let with = self.0[i].fnma(products[i], torque[i]);
            torque[i] = R::select(acts, with, torque[i]);
        }
    }
}

impl<R: Real> Force<R> for Drag<R> {
    /// Of the speed, the same in all three numbers.
    type Series = VectorSeries<R>;

    #[inline(always)]
    fn series() -> VectorSeries<R> {
        VectorSeries::new()
    }

    #[inline(always)]
    fn add_torque<const D: usize>(&self, _moments: &[R; 3], y: &[R; D], _own: usize, torque: &mut [R; 3]) {
        if R::any(self.acts()) {
            let (omega, speed) = ([y[0], y[1], y[2]], speed(y));
            self.add(&[speed * omega[0], speed * omega[1], speed * omega[2]], torque);
        }
    }

    #[inline(always)]
    fn add_order<const D: usize>(
        &self,
        _moments: &[R; 3],
        c: &Coefficients<R, D>,
        Order { k, .. }: Order<R>,
        speeds: &mut VectorSeries<R>,
        _next: &mut [R; D],
        torque: &mut [R; 3],
    ) {
        if R::any(self.acts()) {
            self.add(&products(speeds, c, k), torque);
        }
    }
}

impl Bounded for Drag<f64> {
    fn check(&self) -> Result<(), Error> {
        not_negative("drag", self.0)
    }

    fn is_none(&self) -> bool {
        self.0 == [0.0; 3]
    }

    /// The relaxation `2 c |omega| / I`.
    fn step_rate(&self, pace: &Pace) -> f64 {
        let drag = (0..3).map(|k| self.0[k] / pace.moments[k]).fold(0.0, f64::max);
        2.0 * drag * pace.fastest
    }
}

/// The coefficients of order k of `|omega| omega`. Those of the speed `|omega|`, rows of `speeds`, follow from those of
/// its square.
#[inline(always)]
fn products<R: Real, const D: usize>(
    speeds: &mut VectorSeries<R>,
    c: &Coefficients<R, D>,
    k: usize,
) -> [R; 3] {
    let (zero, half) = (R::splat(0.0), R::splat(0.5));
    let mut square = zero;
    for j in 0..k + 1 {
        let (a, b) = (c.order(j), c.order(k - j));
        square = a[0].fma(b[0], a[1].fma(b[1], a[2].fma(b[2], square)));
    }
    let speed = if k == 0 {
        square.sqrt()
    } else {
        // SAFETY: the calls for the orders 0 to k - 1, one each and ascending, have pushed the rows 0 to k - 1.
        let [first, ..] = unsafe { *speeds.order(0) };
        let moves = zero.lt(first);
        let inverse = R::select(moves, half / first, zero);
        let mut left = square;
        for j in 1..k {
            // SAFETY: as above.
            let (a, b) = unsafe { (speeds.order(j), speeds.order(k - j)) };
            left = a[0].fnma(b[0], left);
        }
        let speed = left * inverse;
        if R::all(moves) { speed } else { R::select(moves, speed, speed_from_rest(speeds, c, k)) }
    };
    speeds.push(k, [speed; 3]);
    let mut products = [zero; 3];
    for j in 0..k + 1 {
        // SAFETY: the rows 0 to k are pushed.
        let ([speed, ..], row) = unsafe { (*speeds.order(j), c.order(k - j)) };
        for i in 0..3 {
            products[i] = speed.fma(row[i], products[i]);
        }
    }
    products
}

/// The coefficient of order k > 0 of the speed of a body that begins at rest: its square begins with order 2. Without a
/// torque at the begin it is zero, and so is the drag of this step.
#[inline(always)]
fn speed_from_rest<R: Real, const D: usize>(speeds: &VectorSeries<R>, c: &Coefficients<R, D>, k: usize) -> R {
    let (zero, half) = (R::splat(0.0), R::splat(0.5));
    let mut left = zero;
    for j in 1..k + 1 {
        let (a, b) = (c.order(j), c.order(k + 1 - j));
        left = a[0].fma(b[0], a[1].fma(b[1], a[2].fma(b[2], left)));
    }
    if k == 1 {
        return left.sqrt();
    }
    // SAFETY: the rows 0 to k - 1 are pushed.
    let [first, ..] = unsafe { *speeds.order(1) };
    for j in 2..k {
        // SAFETY: as above.
        let (a, b) = unsafe { (speeds.order(j), speeds.order(k + 1 - j)) };
        left = a[0].fnma(b[0], left);
    }
    R::select(zero.lt(first), left * (half / first), zero)
}
