//! Quadratic drag: the torque `-|omega| c omega`, `c` one coefficient for each body axis. At large Reynolds numbers the
//! moment of a rotating sphere or disk over the square of its rate varies slowly (rotating disk: von Kármán, Z. angew.
//! Math. Mech. 1, 1921, doi 10.1002/zamm.19210010401: the power 9/5).

use super::{Bounded, Force, Order, Pace, Varied, deviation, not_negative};
use crate::error::Error;
use crate::kinematics::{dot, speed};
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
        R::splat(0.0).lt(c1.abs() + c2.abs() + c3.abs())
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
    /// Of the change of the speed, the same in all three numbers.
    type Varied = VectorSeries<R>;

    #[inline(always)]
    fn series() -> VectorSeries<R> {
        VectorSeries::new()
    }

    #[inline(always)]
    fn varied() -> VectorSeries<R> {
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

    /// The speed changes by `omega.d / |omega|`; where a body stops, it has no derivative, and none is added.
    #[inline(always)]
    fn add_varied_torque<const D: usize>(
        &self,
        by: &Self,
        body: &Varied<R>,
        y: &[R; D],
        _own: usize,
        torque: &mut [R; 3],
    ) {
        if R::any(self.acts()) || R::any(by.acts()) {
            let (omega, zero) = ([y[0], y[1], y[2]], R::splat(0.0));
            let [d, _] = deviation(y, body.tangent);
            let speed = speed(y);
            let change = R::select(zero.lt(speed), dot(&omega, &d) / speed, zero);
            let (mut products, mut by_numbers) = ([zero; 3], [zero; 3]);
            for i in 0..3 {
                products[i] = speed.fma(d[i], change * omega[i]);
                by_numbers[i] = speed * omega[i];
            }
            self.add(&products, torque);
            by.add(&by_numbers, torque);
        }
    }

    #[inline(always)]
    fn add_varied_order<const D: usize>(
        &self,
        by: &Self,
        body: &Varied<R>,
        c: &Coefficients<R, D>,
        Order { k, .. }: Order<R>,
        (speeds, varied): (&mut VectorSeries<R>, &mut VectorSeries<R>),
        torque: &mut [R; 3],
    ) {
        if R::any(self.acts()) {
            self.add(&varied_products(speeds, varied, c, body.tangent, k), torque);
        }
        if R::any(by.acts()) {
            // The series of the motion has the speeds only where there is drag.
            let products =
                if R::any(self.acts()) { speed_times_rates(speeds, c, k) } else { products(speeds, c, k) };
            by.add(&products, torque);
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
    for j in 0..=k {
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
    speed_times_rates(speeds, c, k)
}

/// The coefficients of order k of the speed times the rates.
#[inline(always)]
fn speed_times_rates<R: Real, const D: usize>(
    speeds: &VectorSeries<R>,
    c: &Coefficients<R, D>,
    k: usize,
) -> [R; 3] {
    let mut products = [R::splat(0.0); 3];
    for j in 0..=k {
        // SAFETY: the rows 0 to k are pushed.
        let ([speed, ..], row) = unsafe { (*speeds.order(j), c.order(k - j)) };
        for i in 0..3 {
            products[i] = speed.fma(row[i], products[i]);
        }
    }
    products
}

/// The coefficients of order k of the change of `|omega| omega` by a deviation vector. Those of the change of the speed,
/// rows of `varied`, follow from those of `omega.d`; where a body begins at rest, they are zero.
#[inline(always)]
fn varied_products<R: Real, const D: usize>(
    speeds: &VectorSeries<R>,
    varied: &mut VectorSeries<R>,
    c: &Coefficients<R, D>,
    tangent: usize,
    k: usize,
) -> [R; 3] {
    let zero = R::splat(0.0);
    let mut change = zero;
    for j in 0..=k {
        let (row, [d, _]) = (c.order(j), deviation(c.order(k - j), tangent));
        change = row[0].fma(d[0], row[1].fma(d[1], row[2].fma(d[2], change)));
    }
    for j in 1..=k {
        // SAFETY: the series of the motion has pushed all rows of its orders; the calls for the orders 0 to k - 1, one
        // each and ascending, have pushed the rows 0 to k - 1 of the change.
        let (speed, before) = unsafe { (speeds.order(j), varied.order(k - j)) };
        change = speed[0].fnma(before[0], change);
    }
    // SAFETY: as above.
    let [first, ..] = unsafe { *speeds.order(0) };
    change = R::select(zero.lt(first), change / first, zero);
    varied.push(k, [change; 3]);
    let mut products = [zero; 3];
    for j in 0..=k {
        // SAFETY: as above; the row k is pushed too.
        let (speed, change) = unsafe { (speeds.order(j), varied.order(j)) };
        let (row, [d, _]) = (c.order(k - j), deviation(c.order(k - j), tangent));
        for i in 0..3 {
            products[i] = speed[0].fma(d[i], change[0].fma(row[i], products[i]));
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
    for j in 1..=k {
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
