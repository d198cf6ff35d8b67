//! The equations of motion under further forces.
//!
//! The angular momentum is `L = I omega + h`, with that of the rotor, which may change with the time: the torque in the body
//! is then with what that takes. The frame of the body turns with `omega + e`,
//! `e` the turn by the dissipation; in space L changes by the torques alone.
//!
//! A deviation vector of rates d and rotation vector x changes a direction n that is fixed in space by `n x x` in the body.
//! Dual numbers take the changes through the equations; x turns with `d + f + x x (omega + e)`, f the change of `e`.

use super::forced::acts;
use super::{Applied, FurtherFrame, Layout, Model, ROWS_LEN, Torques, in_rows};
use crate::dual::Dual;
use crate::forces::{FurtherSeries, MOST_STATES, Order, Returned, TrajectorySeries};
use crate::kinematics::{add_cross, cross, direction, dot, plus};
use crate::real::Real;
use crate::series::Coefficients;

/// The layout of a motion whose numbers change by a deviation vector under further forces.
pub type Moved = FurtherFrame;
/// Length of its state.
pub const MOVED: usize = Moved::LEN;

/// The rates of change under further forces.
#[derive(Clone, Copy)]
pub struct FurtherRate<R> {
    /// Of the rates.
    pub omega: [R; 3],
    /// The turn of the frame of the body in addition to the rates.
    pub turn: [R; 3],
    /// Of the work and the impulse.
    pub balance: [R; 2],
    /// Of the states of a function.
    pub states: [R; MOST_STATES],
}

impl<R: Real> FurtherRate<Dual<R>> {
    /// The rates without their changes.
    #[inline(always)]
    pub fn values(&self) -> FurtherRate<R> {
        FurtherRate {
            omega: Dual::values(&self.omega),
            turn: Dual::values(&self.turn),
            balance: Dual::values(&self.balance),
            states: Dual::values(&self.states),
        }
    }
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

    /// The momentum of the rotor at the begin of a step, and its change over the unit of time, if it changes in some lane.
    #[inline(always)]
    pub fn rotor_from(&self, time: R, unit: R) -> ([R; 3], Option<[R; 3]>) {
        let mut change = self.forces.rotor_change;
        if !acts(&change) {
            return (self.forces.further.rotor.0, None);
        }
        for i in 0..3 {
            change[i] = change[i] * unit;
        }
        (self.rotor(time), Some(change))
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
            let (rows, returned) = (in_rows::<L, R, D>(y), self.returned::<L, D>(torques, y));
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
        let (mut turn, mut power) = ([R::splat(0.0); 3], torque);
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
        FurtherRate { omega: rate, turn, balance: [dot(&power, &omega), impulse], states }
    }

    /// A state with its change by the deviation vector.
    #[inline(always)]
    pub fn moved<L: Layout, const D: usize>(&self, y: &[R; D]) -> [Dual<R>; MOVED] {
        let mut axes = [[R::splat(0.0); 3]; 3];
        add_turned_axes::<R, L, D>(y, y, &mut axes);
        let mut own = [Dual::constant(y[0]); MOVED];
        for d in 0..L::OWN {
            own[Moved::OWN_AT + d] = Dual::constant(y[L::OWN_AT + d]);
        }
        let (further, by) = (&self.forces.further, &self.forces.change.further);
        further.vary(by, y[L::TIME_AT], Moved::OWN_AT, &mut own);
        moved_by::<R, L, D>(y, &axes, own)
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
            // The factor is the unit over k + 1.
            let of_time = (at.k, L::TIME_AT, at.factor);
            self.forces.trajectory.add_order(&self.moments, c, of_time, on_trajectory, torque);
        } else {
            further.add_orders::<false, D>(&self.moments, c, at, series, next, torque);
        }
    }
}

/// Adds the changes of the space axes of one state by the rotation vector of another.
#[inline(always)]
pub fn add_turned_axes<R: Real, L: Layout, const D: usize>(y: &[R; D], by: &[R; D], axes: &mut [[R; 3]; 3]) {
    let at = L::TANGENT_AT + 3;
    for v in 0..3 {
        add_cross(&direction(y, v), &[by[at], by[at + 1], by[at + 2]], &mut axes[v]);
    }
}

/// A state with the change of the rates by its deviation vector, with these changes of the space axes, and with these
/// variables of the forces.
#[inline(always)]
pub fn moved_by<R: Real, L: Layout, const D: usize>(
    y: &[R; D],
    axes: &[[R; 3]; 3],
    own: [Dual<R>; MOVED],
) -> [Dual<R>; MOVED] {
    let mut moved = own;
    for d in 0..L::TANGENT_AT {
        moved[d] = Dual::constant(y[d]);
    }
    for i in 0..3 {
        moved[i].slope = y[L::TANGENT_AT + i];
        for v in 0..3 {
            moved[3 + 3 * v + i].slope = axes[v][i];
        }
    }
    moved
}
