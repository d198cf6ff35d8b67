//! The tangent of the motion: the rate of change of a small deviation vector.
//!
//! A deviation vector is a change d of the rates and a rotation vector x in the body, `R -> R exp(hat(x))`. Euler's
//! equations are linear in the products of the rates and in the directions, so their derivative is the same model with
//! the changes of both. A direction n that is fixed in space changes by `n x x` in the body.
//!
//! A change of the parameters makes a body deviate too that begins without a deviation vector: its effect is a torque
//! of its own, in the systems that have one. No change adds zero.
//!
//! Runge-Kutta methods and Taylor series commute with differentiation (Hairer, Nørsett, Wanner, Solving ODEs I, §I.14):
//! the change of the rates of a body without weight is the derivative of the step itself. The rotation vector has an
//! equation of its own, so with weight both agree with the derivative of the step to the order of the method.

use crate::kinematics::{add_cross, cross, direction, plus, put};
use crate::real::Real;
use crate::scene::{Applied, FurtherRate, Layout, Model, Undamped};

/// The change of the rates in a state with a deviation vector.
#[inline(always)]
pub(super) fn spin<R: Real, L: Layout, const D: usize>(y: &[R; D]) -> [R; 3] {
    let at = L::TANGENT_AT;
    [y[at], y[at + 1], y[at + 2]]
}

/// The rotation vector in a state with a deviation vector.
#[inline(always)]
pub(super) fn turn<R: Real, L: Layout, const D: usize>(y: &[R; D]) -> [R; 3] {
    let at = L::TANGENT_AT + 3;
    [y[at], y[at + 1], y[at + 2]]
}

/// Changes of the products of Euler's equations, of the vertical and of a torque in space, and the part of the rate of
/// the rotation vector from the rates: at a state, or the sums of one order of a series.
#[derive(Clone, Copy)]
pub(super) struct Variation<R> {
    products: [R; 3],
    gamma: [R; 3],
    turning: [R; 3],
}

impl<R: Real> Variation<R> {
    #[inline(always)]
    pub(super) fn none() -> Self {
        let zero = [R::splat(0.0); 3];
        Variation { products: zero, gamma: zero, turning: zero }
    }

    /// Adds the products of the deviation vector of one state with the rates and the vertical of another.
    #[inline(always)]
    pub(super) fn add<M: Model<R>, L: Layout, const D: usize>(&mut self, deviating: &[R; D], y: &[R; D]) {
        let ([d1, d2, d3], x) = (spin::<R, L, D>(deviating), turn::<R, L, D>(deviating));
        let [w1, w2, w3] = [y[0], y[1], y[2]];
        self.products = [
            d2.fma(w3, d3.fma(w2, self.products[0])),
            d3.fma(w1, d1.fma(w3, self.products[1])),
            d1.fma(w2, d2.fma(w1, self.products[2])),
        ];
        if M::HEAVY {
            add_cross(&direction(y, 0), &x, &mut self.gamma);
        }
        add_cross(&x, &[w1, w2, w3], &mut self.turning);
    }

    /// The change of Euler's equations without torques by a deviation vector.
    #[inline(always)]
    pub(super) fn acceleration<M: Model<R>, const D: usize>(&self, model: &M, deviating: &[R; D]) -> [R; 3] {
        let mut varied = *deviating;
        put(&mut varied, 3, self.gamma);
        model.euler(&self.products, &varied)
    }

    /// The change of the frame of the body by the rates: `d + x x omega`.
    #[inline(always)]
    pub(super) fn turning(&self, d: &[R; 3]) -> [R; 3] {
        [d[0] + self.turning[0], d[1] + self.turning[1], d[2] + self.turning[2]]
    }

    /// The rate of the deviation vector, from this variation, the deviation vector of the same order, and the change of
    /// the torque in space.
    #[inline(always)]
    pub(super) fn rate<M: Model<R>, L: Layout, const D: usize>(
        &self,
        model: &M,
        applied: &Applied<R>,
        deviating: &[R; D],
        torque: [R; 3],
    ) -> [R; 6] {
        let d = spin::<R, L, D>(deviating);
        let mut change = self.acceleration::<M, D>(model, deviating);
        if L::BALANCE {
            let gained = applied.over_moments(&applied.damped(torque, d));
            change = plus(&change, &gained);
        }
        let turning = self.turning(&d);
        [change[0], change[1], change[2], turning[0], turning[1], turning[2]]
    }
}

/// The rate of the deviation vector of a state, from the rate of change of its rates.
#[inline(always)]
pub(super) fn tangent_rate<R: Real, M: Model<R>, L: Layout, const D: usize>(
    model: &M,
    applied: &Applied<R>,
    y: &[R; D],
    acceleration: &[R; 3],
) -> [R; 6] {
    let mut variation = Variation::none();
    variation.add::<M, L, D>(y, y);
    let torque = if L::BALANCE {
        cross(&applied.space_torque::<L, D>(y), &turn::<R, L, D>(y))
    } else {
        [R::splat(0.0); 3]
    };
    let mut rate = variation.rate::<M, L, D>(model, applied, y, torque);
    if L::CHANGED {
        let [w1, w2, w3] = [y[0], y[1], y[2]];
        let changed = applied.changed_torque(&[w2 * w3, w3 * w1, w1 * w2], y);
        let changed = plus(&changed, &applied.changed_applied_torque());
        let mut spin = [rate[0], rate[1], rate[2]];
        applied.add_changed_rate(&changed, acceleration, &mut spin);
        put(&mut rate, 0, spin);
    }
    rate
}

/// The rate of the deviation vector of a state under further forces, whose dissipation turns the frame of the body.
#[inline(always)]
pub(super) fn further_tangent_rate<R: Real, M: Model<R>, L: Layout, const D: usize>(
    model: &M,
    applied: &Applied<R>,
    y: &[R; D],
    rates: &FurtherRate<R>,
) -> [R; 6] {
    let (d, x, omega) = (spin::<R, L, D>(y), turn::<R, L, D>(y), [y[0], y[1], y[2]]);
    let mut variation = Variation::none();
    variation.add::<M, L, D>(y, y);
    let mut torque = applied.damped(cross(&applied.space_torque::<L, D>(y), &x), d);
    let changed = applied.changed_torque(&[omega[1] * omega[2], omega[2] * omega[0], omega[0] * omega[1]], y);
    let own = applied.changed_applied_torque();
    torque = plus(&torque, &plus(&changed, &own));
    applied.add_varied_torques::<L, D>(y, &mut torque);
    let undamped = Undamped { omega, rate: rates.undamped };
    let rotor = applied.rotor(y[L::TIME_AT]);
    let by_products = variation.acceleration::<M, D>(model, y);
    let mut rate = applied.varied_rate(by_products, cross(&rotor, &d), &torque, &undamped);
    let varied_turn = applied.varied_turn(&rate, &rates.undamped, &rates.turn);

    let change = &applied.forces.change;
    let momentum = plus(&applied.varied_momentum(&omega, &d), &change.further.rotor.0);
    let mut by_turn = cross(&momentum, &rates.turn);
    add_cross(&plus(&applied.momentum(&omega), &rotor), &varied_turn, &mut by_turn);
    for i in 0..3 {
        by_turn[i] = change.moments[i].fnma(rates.omega[i] - rates.undamped[i], by_turn[i]);
    }
    let gained = applied.over_moments(&by_turn);
    let mut turning = variation.turning(&d);
    add_cross(&x, &rates.turn, &mut turning);
    for i in 0..3 {
        rate[i] = rate[i] + gained[i];
        turning[i] = turning[i] + varied_turn[i];
    }
    [rate[0], rate[1], rate[2], turning[0], turning[1], turning[2]]
}
