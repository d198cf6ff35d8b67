//! Torque and damping, applied to any scene: I omega' = … + torque - D omega.
//!
//! A torque in the body needs only the rates as state; a torque in space is linear in the rows of the rotation matrix,
//! so the state contains all rows. Work and impulse are integrated with the motion: energy minus work and momentum
//! minus impulse are constant, so a drift measures the error of forced motions too. The exponential method computes
//! work and impulse from the gains of energy and momentum, so its drifts do not measure the error.
//!
//! A forced body has a layout with a balance; the models contain no forces.

use super::{Layout, Model, Parameters, quaternion};
use crate::dual::Dual;
use crate::forces::{
    ForcesInterval, MOST_STATES, ParameterChange, Returned, add_space_torque, attitude_of_stage, damp,
    unit_of_stage,
};
use crate::kinematics::{add_cross, direction, dot, plus};
use crate::real::Real;

/// The forces on a body on an interval. Without directions there is no torque in space.
#[derive(Clone, Copy)]
pub struct Applied<R> {
    pub(super) moments: [R; 3],
    inverse: [R; 3],
    /// The forces.
    pub forces: ForcesInterval<'static, R>,
}

/// Torque in the body and in space, each with its rate of change, and damping.
#[derive(Clone, Copy)]
pub struct Torques<R> {
    body: [[R; 3]; 2],
    space: [[R; 3]; 2],
    damping: [R; 6],
    /// Whether a torque of some lane changes, and whether one is fixed in space: to add a zero changes no bit.
    is_timed: bool,
    in_space: bool,
    /// Whether a further force of some lane acts, beside a function; else one does.
    pub further: bool,
    /// Whether the gravity gradient along a trajectory acts on some lane.
    pub on_trajectory: bool,
}

impl<R: Real> Torques<R> {
    /// The torque in the body and the torque in space at a time.
    #[inline(always)]
    fn at(&self, time: R) -> [[R; 3]; 2] {
        let mut at = [self.body[0], self.space[0]];
        if self.is_timed {
            for i in 0..3 {
                at[0][i] = time.fma(self.body[1][i], at[0][i]);
                at[1][i] = time.fma(self.space[1][i], at[1][i]);
            }
        }
        at
    }

    /// The torque without damping, at a state.
    #[inline(always)]
    fn undamped<L: Layout, const D: usize>(&self, y: &[R; D]) -> [R; 3] {
        let [mut sum, space] = self.at(y[L::TIME_AT]);
        if L::HAS_FRAME && self.in_space {
            add_space_torque(&space, y, &mut sum);
        }
        sum
    }

    /// The torque with damping, at a state.
    #[inline(always)]
    pub fn damped<L: Layout, const D: usize>(&self, y: &[R; D]) -> [R; 3] {
        let mut sum = self.undamped::<L, D>(y);
        damp(&self.damping, [y[0], y[1], y[2]], &mut sum);
        sum
    }
}

/// Whether a number of some lane is not zero.
#[inline(always)]
pub(super) fn acts<R: Real>(v: &[R; 3]) -> bool {
    R::any(R::splat(0.0).lt(v[0].abs().max(v[1].abs()).max(v[2].abs())))
}

/// A model and what acts on it, by dual numbers.
pub type Varied<R, M> = (<M as Model<R>>::Varied, Applied<Dual<R>>);

impl<R: Real> Applied<R> {
    /// The constants of a body and its forces.
    #[inline(always)]
    pub fn new(p: &Parameters<R>, forces: &ForcesInterval<'static, R>) -> Self {
        let one = R::splat(1.0);
        let ([i1, i2, i3], mut forces) = (p.moments, *forces);
        if let Some(functions) = &mut forces.functions {
            // Nobody is in a lane with a step of zero.
            *functions = functions.only(p.step.abs());
        }
        Applied { moments: p.moments, inverse: [one / i1, one / i2, one / i3], forces }
    }

    /// A model and what acts on it, with the change of the parameters.
    #[inline(always)]
    pub fn varied<M: Model<R>>(&self, model: &M) -> Varied<R, M> {
        let mut forces = ForcesInterval::none();
        let ForcesInterval {
            body: [body, slope],
            space,
            damping,
            further,
            rotor_change,
            trajectory,
            change,
            ..
        } = &self.forces;
        let none = [R::splat(0.0); 3];
        forces.body = [Dual::of(body, &change.torque), Dual::of(slope, &none)];
        forces.space = [Dual::of(&space[0], &none), Dual::of(&space[1], &none)];
        forces.damping = Dual::of(damping, &change.damping);
        forces.further = further.varied(&change.further);
        forces.rotor_change = Dual::of(rotor_change, &none);
        for k in 0..4 {
            forces.trajectory.0[k] = Dual::of(&trajectory.0[k], &none);
        }
        let applied = Applied {
            moments: Dual::of(&self.moments, &change.moments),
            inverse: Dual::quotients(&self.inverse, none, &change.moments, &self.inverse),
            forces,
        };
        (model.varied(change, &self.inverse), applied)
    }

    /// Torque and damping.
    #[inline(always)]
    pub fn torques(&self) -> Torques<R> {
        let ForcesInterval { body, space, damping, .. } = self.forces;
        Torques { body, space, damping, is_timed: true, in_space: true, further: true, on_trajectory: true }
    }

    /// Torque and damping over a unit of time.
    #[inline(always)]
    pub fn torques_in<L: Layout>(&self, unit: R) -> Torques<R> {
        let mut torques = self.torques();
        for j in 0..2 {
            for i in 0..3 {
                // No torque is a zero with a minus, to which nothing may be added.
                torques.body[j][i] = torques.body[j][i].fma(unit, R::splat(0.0));
                torques.space[j][i] = torques.space[j][i] * unit;
            }
        }
        torques.on_trajectory = L::FURTHER && self.forces.trajectory.acts();
        let of_table = torques.on_trajectory || acts(&self.forces.rotor_change);
        torques.further = !L::FUNCTION || of_table || self.forces.further.acts();
        torques.is_timed = acts(&torques.body[1]) || acts(&torques.space[1]);
        torques.in_space = acts(&torques.space[0]) || acts(&torques.space[1]);
        for k in 0..6 {
            torques.damping[k] = torques.damping[k] * unit;
        }
        torques
    }

    /// Applied torque without damping, at a state.
    #[inline(always)]
    pub fn undamped<L: Layout, const D: usize>(&self, y: &[R; D]) -> [R; 3] {
        self.torques().undamped::<L, D>(y)
    }

    /// The torque that the functions of the user return at a state; zero where `wanted` is not above zero.
    #[inline(always)]
    pub fn function_torque(&self, time: R, omega: &[R; 3], attitude: &[R; 4], wanted: R) -> [R; 3] {
        match &self.forces.functions {
            Some(functions) => functions.only(wanted).torques(time, omega, attitude),
            None => [R::splat(0.0); 3],
        }
    }

    /// The same at a state with a quaternion, and the rates of change of the states of the functions; `None` of a layout
    /// without a function.
    #[inline(always)]
    pub(super) fn returned<L: Layout, const D: usize>(
        &self,
        torques: &Torques<R>,
        y: &[R; D],
    ) -> Option<Returned<R>> {
        if !L::FUNCTION {
            return None;
        }
        let mut states = [R::splat(0.0); MOST_STATES];
        let Some(functions) = &self.forces.functions else {
            return Some(Returned { torque: [R::splat(0.0); 3], states });
        };
        let attitude = unit_of_stage(quaternion::<L, R, D>(y));
        let (time, omega) = (y[L::TIME_AT], [y[0], y[1], y[2]]);
        if !functions.are_long() {
            return Some(Returned { torque: functions.torques(time, &omega, &attitude), states });
        }
        if L::STATES {
            #[allow(clippy::manual_memcpy)] // The compiler does not always inline `copy_from_slice`.
            for k in 0..MOST_STATES {
                states[k] = y[L::STATES_AT + k];
            }
        }
        let trajectory = &self.forces.trajectory;
        let of_root = torques.on_trajectory && trajectory.acts();
        let place = if of_root {
            trajectory.root(time)
        } else {
            self.forces.further.orbit.place([y[L::OWN_AT], y[L::OWN_AT + 1]])
        };
        Some(functions.returned(time, &omega, &attitude, &states, (&place, of_root)))
    }

    /// Applied torque with damping, at a state.
    #[inline(always)]
    pub fn torque<L: Layout, const D: usize>(&self, y: &[R; D]) -> [R; 3] {
        self.torque_where::<L, D>(y, R::splat(1.0))
    }

    /// The same, without that of functions where `wanted` is not above zero.
    #[inline(always)]
    pub fn torque_where<L: Layout, const D: usize>(&self, y: &[R; D], wanted: R) -> [R; 3] {
        let mut sum = self.undamped::<L, D>(y);
        if L::FUNCTION {
            let attitude = attitude_of_stage([direction(y, 0), direction(y, 1)]);
            let returned = self.function_torque(y[L::TIME_AT], &[y[0], y[1], y[2]], &attitude, wanted);
            sum = plus(&sum, &returned);
        }
        self.damped(sum, [y[0], y[1], y[2]])
    }

    /// The torque in space of order k, in body components; see `torque_of_order`.
    #[inline(always)]
    pub fn space_torque_of_order<L: Layout, const D: usize>(
        &self,
        start: &[R; D],
        now: &[R; D],
        before: &[R; D],
    ) -> [R; 3] {
        let mut sum = [R::splat(0.0); 3];
        self.add_space_order::<L, D>(start, now, before, &mut sum);
        sum
    }

    #[inline(always)]
    fn add_space_order<L: Layout, const D: usize>(
        &self,
        start: &[R; D],
        now: &[R; D],
        before: &[R; D],
        sum: &mut [R; 3],
    ) {
        if L::HAS_FRAME {
            // The coefficient of (a + b t) row is a row[k] + b step row[k - 1]; `before` contains the step.
            let [_, space] = self.torques().at(start[L::TIME_AT]);
            add_space_torque(&space, now, sum);
            add_space_torque(&self.forces.space[1], before, sum);
        }
    }

    /// The torque in space at a state, in body components.
    #[inline(always)]
    pub fn space_torque<L: Layout, const D: usize>(&self, y: &[R; D]) -> [R; 3] {
        let mut sum = [R::splat(0.0); 3];
        if L::HAS_FRAME {
            add_space_torque(&self.torques().at(y[L::TIME_AT])[1], y, &mut sum);
        }
        sum
    }

    /// A torque less the damping of these rates.
    #[inline(always)]
    pub fn damped(&self, mut torque: [R; 3], omega: [R; 3]) -> [R; 3] {
        damp(&self.forces.damping, omega, &mut torque);
        torque
    }

    /// The coefficient of the torque at an order k > 0: `now` holds the coefficients of the state of order k, `before`
    /// those of order k - 1 times the step, `start` the state.
    #[inline(always)]
    pub fn torque_of_order<L: Layout, const D: usize>(
        &self,
        start: &[R; D],
        now: &[R; D],
        before: &[R; D],
    ) -> [R; 3] {
        // Time is linear in the step, so the series of a torque in the body ends after order 1.
        let mut sum = self.forces.body[1];
        for i in 0..3 {
            sum[i] = sum[i] * now[L::TIME_AT];
        }
        self.add_space_order::<L, D>(start, now, before, &mut sum);
        self.damped(sum, [now[0], now[1], now[2]])
    }

    /// Whether a coefficient of the torque at an order above 1 may differ from minus the damping of the rates of this
    /// order: a torque in space turns with the body. A torque in the body ends at order 1, but leaves a zero with its sign.
    #[inline(always)]
    pub fn has_high_orders(&self) -> bool {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let mut any = false;
        for i in 0..3 {
            for j in 0..2 {
                any |= R::any(zero.lt(self.forces.space[j][i].abs()));
            }
            // A zero has a sign too.
            any |= R::any((one / self.forces.body[1][i]).lt(zero));
        }
        any
    }

    /// The change of the torque by that of the parameters, `(dI w) x w + n x d(mgl com) - dD w`, from the products of the
    /// rates; linear in the products and in the state. The change of the applied torque is not in it.
    #[inline(always)]
    pub fn changed_torque<const D: usize>(&self, products: &[R; 3], y: &[R; D]) -> [R; 3] {
        let ParameterChange { moments, weight, damping, .. } = &self.forces.change;
        let mut sum = [
            (moments[1] - moments[2]) * products[0],
            (moments[2] - moments[0]) * products[1],
            (moments[0] - moments[1]) * products[2],
        ];
        add_cross(&direction(y, 0), weight, &mut sum);
        damp(damping, [y[0], y[1], y[2]], &mut sum);
        sum
    }

    /// The change of the applied torque, at all times.
    #[inline(always)]
    pub fn changed_applied_torque(&self) -> [R; 3] {
        self.forces.change.torque
    }

    /// Adds the rate of a deviation vector by a change of the torque and of the moments, `I^-1 (torque - dI w')`, to
    /// `sum`.
    #[inline(always)]
    pub fn add_changed_rate(&self, torque: &[R; 3], rate: &[R; 3], sum: &mut [R; 3]) {
        for i in 0..3 {
            let left = self.forces.change.moments[i].fnma(rate[i], torque[i]);
            sum[i] = self.inverse[i].fma(left, sum[i]);
        }
    }

    /// Adds the change of the rates by a torque to `sum`.
    #[inline(always)]
    pub fn add_over_moments(&self, torque: &[R; 3], sum: &mut [R; 3]) {
        for i in 0..3 {
            sum[i] = self.inverse[i].fma(torque[i], sum[i]);
        }
    }

    /// Change of the rates by a torque.
    #[inline(always)]
    pub fn over_moments(&self, torque: &[R; 3]) -> [R; 3] {
        [torque[0] * self.inverse[0], torque[1] * self.inverse[1], torque[2] * self.inverse[2]]
    }

    /// Power and rate of impulse of a torque; linear in the torque and in the state.
    #[inline(always)]
    pub fn balance<L: Layout, const D: usize>(&self, torque: &[R; 3], y: &[R; D]) -> [R; 2] {
        let omega = [y[0], y[1], y[2]];
        let impulse = if L::VECTORS == 0 {
            let mut momentum = omega;
            for i in 0..3 {
                momentum[i] = momentum[i] * self.moments[i];
            }
            let half = dot(torque, &momentum);
            half + half
        } else {
            dot(torque, &direction(y, 0))
        };
        [dot(torque, &omega), impulse]
    }
}
