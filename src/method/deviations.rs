//! The Taylor series of the deviation vectors of a motion.
//!
//! The equations of a deviation vector (`tangent`) are linear in it, and the series of the motion is known when they
//! are solved: each order follows from the Cauchy products of the motion with the lower orders of the deviation vector
//! (Jorba & Zou 2005, §2). The motion does not depend on its deviation vectors, so any number of them share one motion.

use super::tangent::{Variation, spin, turn};
use super::taylor::{TurnSeries, add_rates, times_unit};
use super::{Coefficients, Taylor};
use crate::forces::{Further, Order};
use crate::kinematics::{add_cross, put};
use crate::real::Real;
use crate::scene::{Layout, Model, Undamped};
use crate::series::{INVERSE, VectorSeries};

/// Cauchy products of one order with a deviation vector, and those of the rates where a change of the parameters needs
/// them.
#[derive(Clone, Copy)]
struct VariedProducts<R> {
    variation: Variation<R>,
    rates: [R; 3],
}

impl<R: Real> VariedProducts<R> {
    #[inline(always)]
    fn none() -> Self {
        VariedProducts { variation: Variation::none(), rates: [R::splat(0.0); 3] }
    }

    /// Adds the products of the motion of one order with the deviation vector of another.
    #[inline(always)]
    fn add<M: Model<R>, L: Layout, const D: usize>(&mut self, a: &[R; D], b: &[R; D]) {
        self.variation.add::<M, L, D>(b, a);
        if L::CHANGED {
            add_rates(a, b, &mut self.rates);
        }
    }
}

impl<R: Real, M: Model<R>> Taylor<R, M> {
    /// All coefficients of the deviation vector that begins with that of order 0, from those of the motion. The motion
    /// alone comes first, because the sums of both together exceed the registers.
    #[inline(always)]
    pub(super) fn deviation<L: Layout, const D: usize>(&self, unit: R, c: &mut Coefficients<R, D>) {
        let mut torques = VectorSeries::new();
        for half in 0..self.order / 2 {
            let k = 2 * half;
            let (mut sums, mut after) = (VariedProducts::none(), VariedProducts::none());
            for j in 1..k {
                sums.add::<M, L, D>(c.order(j), c.order(k - j));
                after.add::<M, L, D>(c.order(j + 1), c.order(k - j));
            }
            if k > 0 {
                sums.add::<M, L, D>(c.order(0), c.order(k));
                after.add::<M, L, D>(c.order(1), c.order(k));
            }
            sums.add::<M, L, D>(c.order(k), c.order(0));
            self.set_next_deviation::<L, D>(unit, &sums, &mut torques, c, k);
            after.add::<M, L, D>(c.order(0), c.order(k + 1));
            after.add::<M, L, D>(c.order(k + 1), c.order(0));
            self.set_next_deviation::<L, D>(unit, &after, &mut torques, c, k + 1);
        }
    }

    /// Computes the coefficients of order k + 1 of the deviation vector, from the products and the coefficients of
    /// order k.
    #[inline(always)]
    fn set_next_deviation<L: Layout, const D: usize>(
        &self,
        unit: R,
        sums: &VariedProducts<R>,
        torques: &mut VectorSeries<R>,
        c: &mut Coefficients<R, D>,
        k: usize,
    ) {
        let factor = unit * R::splat(INVERSE[k + 1]);
        let torque = self.varied_torque::<L, D>(unit, torques, c, k);
        let mut next = sums.variation.rate::<M, L, D>(&self.model, &self.applied, c.order(k), torque);
        for i in 0..6 {
            next[i] = factor * next[i];
        }
        if L::CHANGED {
            self.add_changed::<D>(factor, &sums.rates, [c.order(k), c.order(k + 1)], k, &mut next);
        }
        c.set(k + 1, L::TANGENT_AT, next);
    }

    /// All coefficients of the deviation vector under further forces: `further_tangent_rate` by Cauchy products.
    #[inline(always)]
    pub(super) fn further_deviation<L: Layout, const D: usize>(
        &self,
        unit: R,
        series: &mut TurnSeries<R>,
        c: &mut Coefficients<R, D>,
    ) {
        let applied = &self.applied;
        let change = &applied.forces.change;
        let (mut torques, mut turns) = (VectorSeries::new(), VectorSeries::new());
        let (mut varied, mut varied_roots) = (Further::varied(), VectorSeries::new());
        let begin = c.order(0)[L::TIME_AT];
        for k in 0..self.order {
            let of_k = c.order(k);
            let factor = unit * R::splat(INVERSE[k + 1]);
            let mut sums = VariedProducts::none();
            for j in 0..=k {
                sums.add::<M, L, D>(c.order(j), c.order(k - j));
            }
            let (d, omega) = (spin::<R, L, D>(of_k), [of_k[0], of_k[1], of_k[2]]);
            let mut torque = applied.damped(self.varied_torque::<L, D>(unit, &mut torques, c, k), d);
            let changed = applied.changed_torque(&sums.rates, of_k);
            let own = applied.changed_applied_torque();
            for i in 0..3 {
                // The change of the applied torque is constant: its series has one term.
                torque[i] = torque[i] + if k == 0 { changed[i] + own[i] } else { changed[i] };
            }
            let at = Order { k, own: L::OWN_AT, factor: unit };
            let on_trajectory = (&series.on_trajectory, &mut varied_roots);
            applied.add_varied_orders::<L, D>(
                c,
                at,
                (&mut series.torques, &mut varied),
                on_trajectory,
                &mut torque,
            );
            // SAFETY: the series of the motion has pushed all rows of its orders.
            let (frame, undamped, gained) =
                unsafe { (series.turn.order(k), series.undamped.order(k), series.gained.order(k)) };
            let by_products = sums.variation.acceleration::<M, D>(&self.model, of_k);
            let undamped = Undamped { omega, rate: *undamped };
            let mut before = [[R::splat(0.0); 3]; 2];
            if k > 0 {
                // SAFETY: the calls for the orders 0 to k - 1, one each and ascending, have pushed the rows 0 to k - 1.
                before = [spin::<R, L, D>(c.order(k - 1)), unsafe { *turns.order(k - 1) }];
            }
            let by_rotor = applied.across_rotor(begin, [&d, &before[0]], unit);
            let mut rate = applied.varied_rate(by_products, by_rotor, &torque, &undamped);
            let newest = applied.varied_turn(&rate, &undamped.rate, frame);
            turns.push(k, newest);

            let mut by_turn = applied.across_rotor(begin, [&newest, &before[1]], unit);
            add_cross(&change.further.rotor.0, frame, &mut by_turn);
            let mut turning = sums.variation.turning(&d);
            for j in 0..=k {
                // SAFETY: as above; the calls for the orders 0 to k, one each and ascending, have pushed the rows 0 to k
                // of the change.
                let (frame, newest) = unsafe { (series.turn.order(k - j), turns.order(k - j)) };
                let row = c.order(j);
                let omega = [row[0], row[1], row[2]];
                add_cross(&applied.varied_momentum(&omega, &spin::<R, L, D>(row)), frame, &mut by_turn);
                add_cross(&applied.momentum(&omega), newest, &mut by_turn);
                add_cross(&turn::<R, L, D>(row), frame, &mut turning);
            }
            for i in 0..3 {
                by_turn[i] = change.moments[i].fnma(gained[i], by_turn[i]);
            }
            let by_turn = applied.over_moments(&by_turn);
            for i in 0..3 {
                rate[i] = factor * (rate[i] + by_turn[i]);
                turning[i] = factor * (turning[i] + newest[i]);
            }
            c.set(k + 1, L::TANGENT_AT, [rate[0], rate[1], rate[2], turning[0], turning[1], turning[2]]);
        }
    }

    /// The change of order k of the torque in space by the deviation vector: the torque turns with the body.
    #[inline(always)]
    fn varied_torque<L: Layout, const D: usize>(
        &self,
        unit: R,
        torques: &mut VectorSeries<R>,
        c: &Coefficients<R, D>,
        k: usize,
    ) -> [R; 3] {
        let mut sum = [R::splat(0.0); 3];
        if !(L::TANGENT && L::BALANCE) {
            return sum;
        }
        let newest = if k == 0 {
            self.applied.space_torque::<L, D>(c.order(0))
        } else {
            let before = times_unit::<R, L, D>(c.order(k - 1), unit);
            self.applied.space_torque_of_order::<L, D>(c.order(0), c.order(k), &before)
        };
        torques.push(k, newest);
        for j in 0..=k {
            // SAFETY: the calls for the orders 0 to k, one each and ascending, have pushed the rows 0 to k.
            let torque = unsafe { torques.order(j) };
            add_cross(torque, &turn::<R, L, D>(c.order(k - j)), &mut sum);
        }
        sum
    }

    /// Adds the effect of the change of the parameters to the deviation vector of order k + 1, from the motion of the
    /// orders k and k + 1; `factor` is the unit of time over k + 1.
    #[inline(always)]
    fn add_changed<const D: usize>(
        &self,
        factor: R,
        products: &[R; 3],
        [of_k, next]: [&[R; D]; 2],
        k: usize,
        deviation: &mut [R; 6],
    ) {
        let mut torque = self.applied.changed_torque(products, of_k);
        let own = self.applied.changed_applied_torque();
        for i in 0..3 {
            // The change of the applied torque is constant: its series has one term.
            torque[i] = factor * (if k == 0 { torque[i] + own[i] } else { torque[i] });
        }
        let mut spin = [deviation[0], deviation[1], deviation[2]];
        self.applied.add_changed_rate(&torque, &[next[0], next[1], next[2]], &mut spin);
        put(deviation, 0, spin);
    }
}
