//! The equations of motion under further forces.
//!
//! The angular momentum is `L = I omega + h`, with that of the rotor, which may change with the time: the torque in the body
//! is then with what that takes. The frame of the body turns with `omega + e`,
//! `e` the turn by the dissipation; in space L changes by the torques alone.
//!
//! A deviation vector of rates d and rotation vector x changes a torque by its derivative, `e` by a change `f` that
//! follows from the change of the rates without it, and turns with `d + f + x x (omega + e)`.

use super::forced::acts;
use super::{Applied, Layout, Model, ROWS_LEN, Torques, in_rows};
use crate::forces::{FurtherSeries, FurtherVaried, MOST_STATES, Order, Returned, TrajectorySeries, Varied};
use crate::kinematics::{add_cross, cross, direction, dot, plus};
use crate::real::Real;
use crate::series::{Coefficients, VectorSeries};

/// The rates of change under further forces.
#[derive(Clone, Copy)]
pub struct FurtherRate<R> {
    /// Of the rates.
    pub omega: [R; 3],
    /// Of the rates without the dissipation.
    pub undamped: [R; 3],
    /// The turn of the frame of the body in addition to the rates.
    pub turn: [R; 3],
    /// Of the work and the impulse.
    pub balance: [R; 2],
    /// Of the states of a function.
    pub states: [R; MOST_STATES],
}

/// Rates, and their rates of change without the dissipation, of a state or of one order of it.
#[derive(Clone, Copy)]
pub struct Undamped<R> {
    /// The rates.
    pub omega: [R; 3],
    /// Their rates of change.
    pub rate: [R; 3],
}

impl<R: Real> Applied<R> {
    /// The momentum of the body, without the rotor; linear in the rates.
    #[inline(always)]
    pub fn momentum(&self, omega: &[R; 3]) -> [R; 3] {
        [self.moments[0] * omega[0], self.moments[1] * omega[1], self.moments[2] * omega[2]]
    }

    /// The momentum of the rotor at a time.
    #[inline(always)]
    pub fn rotor(&self, time: R) -> [R; 3] {
        let mut rotor = self.forces.further.rotor.0;
        for i in 0..3 {
            rotor[i] = time.fma(self.forces.rotor_change[i], rotor[i]);
        }
        rotor
    }

    /// The coefficient of order k of `h x v`, from the time at the begin, the coefficients of v of the orders k and k - 1, the
    /// second zeros without one, and the unit of time.
    #[inline(always)]
    pub fn across_rotor(&self, time: R, [v, before]: [&[R; 3]; 2], unit: R) -> [R; 3] {
        let (mut sum, mut change) = (cross(&self.rotor(time), v), self.forces.rotor_change);
        if acts(&change) {
            for i in 0..3 {
                change[i] = change[i] * unit;
            }
            add_cross(&change, before, &mut sum);
        }
        sum
    }

    /// The turn of the frame by the dissipation, from the rate of change of the rates without it; linear.
    #[inline(always)]
    pub fn turn(&self, rate: &[R; 3]) -> [R; 3] {
        self.over_moments(&self.forces.further.dissipation.times(rate))
    }

    /// The equations of motion at a state.
    #[inline(always)]
    pub fn under_further<M: Model<R>, L: Layout, const D: usize>(
        &self,
        model: &M,
        torques: &Torques<R>,
        y: &[R; D],
    ) -> FurtherRate<R> {
        if L::TURNS {
            let (rows, returned) = (in_rows::<L, R, D>(y), self.returned::<L, D>(y));
            self.further_rate::<M, L::Rows, ROWS_LEN>(model, torques, &rows, returned)
        } else {
            self.further_rate::<M, L, D>(model, torques, y, None)
        }
    }

    /// The rates of change of the states of a function.
    #[inline(always)]
    pub fn state_rates<M: Model<R>, L: Layout, const D: usize>(
        &self,
        model: &M,
        y: &[R; D],
    ) -> [R; MOST_STATES] {
        self.under_further::<M, L, D>(model, &self.torques(), y).states
    }

    /// The same at a state with rows, with the torque that a function has returned there. What acts on no lane is left
    /// out: to add its zeros changes no bit.
    #[inline(always)]
    fn further_rate<M: Model<R>, L: Layout, const D: usize>(
        &self,
        model: &M,
        torques: &Torques<R>,
        y: &[R; D],
        returned: Option<Returned<R>>,
    ) -> FurtherRate<R> {
        let (omega, rotor) = ([y[0], y[1], y[2]], self.rotor(y[L::TIME_AT]));
        let mut torque = torques.damped::<L, D>(y);
        // Known without a function, where the question takes a tenth of a step of `rk4`.
        let mut acts = true;
        let mut states = [R::splat(0.0); MOST_STATES];
        if let Some(returned) = returned {
            torque = plus(&torque, &returned.torque);
            states = returned.states;
            acts = torques.further;
        }
        let mut with_rotor = torque;
        if acts {
            self.add_further_torques::<L, D>(torques, y, &mut torque);
            with_rotor = cross(&rotor, &omega);
            with_rotor = plus(&with_rotor, &torque);
        }
        let mut rate = model.euler(&[omega[1] * omega[2], omega[2] * omega[0], omega[0] * omega[1]], y);
        self.add_over_moments(&with_rotor, &mut rate);
        let (undamped, mut turn, mut power) = (rate, [R::splat(0.0); 3], torque);
        if acts {
            turn = self.turn(&rate);
            let by_turn = cross(&plus(&self.momentum(&omega), &rotor), &turn);
            self.add_over_moments(&by_turn, &mut rate);
            power = plus(&torque, &by_turn);
            add_cross(&rotor, &turn, &mut with_rotor);
        }
        let impulse = if L::VECTORS == 0 {
            let half = dot(&with_rotor, &self.momentum(&omega));
            half + half
        } else {
            dot(&with_rotor, &direction(y, 0))
        };
        // The rotor does no work, its motor does.
        FurtherRate { omega: rate, undamped, turn, balance: [dot(&power, &omega), impulse], states }
    }

    /// The change of the rates without the dissipation by a deviation vector with the change d of the rates, and by a
    /// change of the parameters: from the changes by the products and the weight, by the rotor, `h x d`, and of the torques;
    /// linear.
    #[inline(always)]
    pub fn varied_rate(
        &self,
        by_products: [R; 3],
        mut gained: [R; 3],
        torque: &[R; 3],
        y: &Undamped<R>,
    ) -> [R; 3] {
        let change = &self.forces.change;
        add_cross(&change.further.rotor.0, &y.omega, &mut gained);
        for i in 0..3 {
            gained[i] = change.moments[i].fnma(y.rate[i], gained[i] + torque[i]);
        }
        let gained = self.over_moments(&gained);
        plus(&by_products, &gained)
    }

    /// The change of the turn of the frame, from the change of the rates without the dissipation; linear.
    #[inline(always)]
    pub fn varied_turn(&self, varied_rate: &[R; 3], rate: &[R; 3], turn: &[R; 3]) -> [R; 3] {
        let change = &self.forces.change;
        let mut sum = self.forces.further.dissipation.times(varied_rate);
        let by_numbers = change.further.dissipation.times(rate);
        for i in 0..3 {
            sum[i] = change.moments[i].fnma(turn[i], sum[i] + by_numbers[i]);
        }
        self.over_moments(&sum)
    }

    /// The change of the momentum by those of the moments and of the rates; linear in both.
    #[inline(always)]
    pub fn varied_momentum(&self, omega: &[R; 3], d: &[R; 3]) -> [R; 3] {
        let (mut sum, moments) = (self.momentum(d), &self.forces.change.moments);
        for i in 0..3 {
            sum[i] = moments[i].fma(omega[i], sum[i]);
        }
        sum
    }

    /// The change of the further torques by the deviation vector in a state, and by a change of the parameters.
    #[inline(always)]
    pub fn add_varied_torques<L: Layout, const D: usize>(&self, y: &[R; D], torque: &mut [R; 3]) {
        let (further, by) = (&self.forces.further, &self.forces.change.further);
        further.add_varied_torques::<D>(by, &self.varied::<L>(), y, L::OWN_AT, torque);
        if self.forces.trajectory.acts() {
            self.forces.trajectory.add_varied_torque::<D>(&self.varied::<L>(), y, torque);
        }
    }

    /// Adds the coefficient of order k of the change of all further torques; see [`Force::add_varied_order`].
    ///
    /// [`Force::add_varied_order`]: crate::forces::Force::add_varied_order
    #[inline(always)]
    pub fn add_varied_orders<L: Layout, const D: usize>(
        &self,
        c: &Coefficients<R, D>,
        at: Order<R>,
        series: (&mut FurtherSeries<R>, &mut FurtherVaried<R>),
        on_trajectory: (&TrajectorySeries<R>, &mut VectorSeries<R>),
        torque: &mut [R; 3],
    ) {
        let (further, by) = (&self.forces.further, &self.forces.change.further);
        let varied = self.varied::<L>();
        further.add_varied_orders(by, &varied, c, at, series, torque);
        self.forces.trajectory.add_varied_order(&varied, c, at.k, on_trajectory, torque);
    }

    #[inline(always)]
    fn varied<L: Layout>(&self) -> Varied<R> {
        Varied {
            moments: self.moments,
            change: self.forces.change.moments,
            time: L::TIME_AT,
            tangent: L::TANGENT_AT,
        }
    }

    #[inline(always)]
    fn add_further_torques<L: Layout, const D: usize>(
        &self,
        torques: &Torques<R>,
        y: &[R; D],
        torque: &mut [R; 3],
    ) {
        let further = &self.forces.further;
        if L::HAS_FRAME {
            further.add_torques::<true, D>(&self.moments, y, L::OWN_AT, torque);
            if torques.on_trajectory {
                self.forces.trajectory.add_torque(&self.moments, y, y[L::TIME_AT], torque);
            }
        } else {
            further.add_torques::<false, D>(&self.moments, y, L::OWN_AT, torque);
        }
    }

    /// Adds the coefficient of order k of all further torques to `torque`; see [`Force::add_order`].
    ///
    /// [`Force::add_order`]: crate::forces::Force::add_order
    #[inline(always)]
    pub fn add_further_orders<L: Layout, const D: usize>(
        &self,
        c: &Coefficients<R, D>,
        at: Order<R>,
        (series, on_trajectory): (&mut FurtherSeries<R>, &mut TrajectorySeries<R>),
        next: &mut [R; D],
        torque: &mut [R; 3],
    ) {
        let further = &self.forces.further;
        if L::HAS_FRAME {
            further.add_orders::<true, D>(&self.moments, c, at, series, next, torque);
            let of_time = (at.k, L::TIME_AT);
            self.forces.trajectory.add_order(&self.moments, c, of_time, on_trajectory, torque);
        } else {
            further.add_orders::<false, D>(&self.moments, c, at, series, next, torque);
        }
    }
}
