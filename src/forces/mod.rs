//! Forces: what acts on a body besides weight, each in one file.
//!
//! A force has numbers and their check, an equation and its Taylor products, bounds, and what it adds to the rate that
//! steps follow; dual numbers take the derivative. Every kernel of a forced body has the table of a torque and linear
//! damping. The *further* forces are the rows of the list below and the trajectory of a table; kernels with them have
//! them all, and a body that has none of one has zeros for its numbers.
//!
//! Two of the further forces are no torques, and the equations of motion (`scene::further`) name them: the rotor has
//! an angular momentum, and the dissipation turns the frame of the body. The function of a user is called for one
//! body at a time, in kernels of its own.

mod bodies;
mod body_rows;
mod damping;
mod dissipation;
mod drag;
mod function;
mod orbit;
mod place;
mod rotor;
mod set;
mod table;
mod trajectory;

pub use bodies::{BodyForces, Forces, ForcesInterval, ParameterChange};
pub use damping::{Damping, Modes, damp};
pub use dissipation::Dissipation;
pub use drag::Drag;
pub use function::{
    Code, EIGHT, FEWEST_STEPS, Function, FunctionOfEight, LongFunction, LongFunctionOfEight, MOST_STATES,
    Returned, SMALL_STATE, TorqueCall, TorqueCalls, TorqueFunction, TorqueRows, attitude_of_stage,
    unit_of_stage,
};
pub use orbit::{Orbit, anomaly_cos_sin, conic_sign, is_open};
pub use place::{Along, OrbitPlace, StepAlong};
pub use rotor::Rotor;
pub use set::ForceSet;
pub use table::{Samples, Table, add_space_torque, spline};
pub use trajectory::{PlaceOfRoot, Trajectory, TrajectorySeries};

use crate::dual::Dual;
use crate::error::{Error, refuse};
use crate::inertia::moment_range;
use crate::kinematics::length;
use crate::real::{Pack, Real};
use crate::series::Coefficients;
use crate::simd::{Row, load_rows, set_lane};

/// A further force in kernels: its equation, and the Taylor products of it. `y` is a state, which begins with the rates and,
/// if there are any, the space axes 3, 1 and 2 in the body. The variables of the force are at `own`.
pub trait Force<R: Real>: Copy {
    /// Whether the torque depends on the attitude. The force then acts only in kernels with the space axes.
    const IN_SPACE: bool = false;
    /// How many variables are integrated with the motion for this force; only a force in space has any.
    const VARIABLES: usize = 0;
    /// Coefficients of its Taylor product beside those of the state.
    type Series;

    /// No coefficients yet.
    fn series() -> Self::Series;

    /// Adds the torque at a state to `torque`.
    #[inline(always)]
    fn add_torque<const D: usize>(&self, _moments: &[R; 3], _y: &[R; D], _own: usize, _torque: &mut [R; 3]) {}

    /// Adds the coefficient of order k of the torque to `torque`, and writes those of order k + 1 of its variables
    /// into `next`: the coefficients of order k of their rates of change, times `factor`. The calls are for ascending
    /// orders.
    #[inline(always)]
    fn add_order<const D: usize>(
        &self,
        _moments: &[R; 3],
        _c: &Coefficients<R, D>,
        _at: Order<R>,
        _series: &mut Self::Series,
        _next: &mut [R; D],
        _torque: &mut [R; 3],
    ) {
    }

    /// Writes the rates of change of its variables at a state.
    #[inline(always)]
    fn change<const D: usize>(&self, _y: &[R; D], _own: usize, _change: &mut [R; D]) {}

    /// Writes the change of its variables at a time by a change of its numbers, which are those of `by`.
    #[inline(always)]
    fn vary<const D: usize>(&self, _by: &Self, _time: R, _own: usize, _y: &mut [Dual<R>; D]) {}
}

/// An order of a Taylor product.
#[derive(Clone, Copy)]
pub struct Order<R> {
    /// The order.
    pub k: usize,
    /// Index of the variables of the force.
    pub own: usize,
    /// The unit of time over k + 1.
    pub factor: R,
}

/// What is known of a further force outside kernels. A bound that is omitted is that of a force which adds no energy
/// and is not fast.
pub trait Bounded {
    /// Refuses impossible numbers. They are finite.
    ///
    /// # Errors
    /// Naming the number and the rule.
    fn check(&self) -> Result<(), Error>;

    /// Whether it does not act.
    fn is_none(&self) -> bool;

    /// Whether it may add momentum in space.
    fn drives(&self) -> bool {
        false
    }

    /// A bound of `|I^(-1/2) torque|` of a torque that may add energy.
    fn strength(&self, _moments: [f64; 3]) -> f64 {
        0.0
    }

    /// From a bound of the root of twice the energy: that with the potential energy of this force, and how much the
    /// frame in which this energy is constant turns.
    fn reach(&self, _start: &AtStart, root: f64) -> [f64; 2] {
        [root, 0.0]
    }

    /// What it adds to the rate that the steps of a body follow.
    fn step_rate(&self, _pace: &Pace) -> f64 {
        0.0
    }

    /// Its variables at a time.
    fn start(&self, _time: f64, _variables: &mut [f64]) {}
}

/// A body at its start, with the momentum of its rotor.
pub struct AtStart {
    /// Principal moments.
    pub moments: [f64; 3],
    /// Rates in the body.
    pub omega: [f64; 3],
    /// Attitude: unit quaternion, scalar first, body to space.
    pub attitude: [f64; 4],
    /// Momentum of the rotor.
    pub rotor: [f64; 3],
}

/// Bounds for a body on which forces act.
pub struct Pace {
    /// Principal moments.
    pub moments: [f64; 3],
    /// The least of them.
    pub least: f64,
    /// Of the rates.
    pub fastest: f64,
    /// Of the angular momentum, that of a rotor included.
    pub momentum: f64,
    /// Of the rate at which forces and rotation change the momentum in the body.
    pub torque: f64,
}

macro_rules! forces {
    ($($(#[$doc:meta])* $name:ident: $force:ident, $numbers:literal, $word:literal;)*) => {
        /// The further forces on a body, or on the lanes of a pack.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct Further<R> {
            $($(#[$doc])* pub $name: $force<R>,)*
        }

        /// The places of the forces in the list.
        #[allow(non_camel_case_types)]
        #[derive(Clone, Copy)]
        enum Place {
            $($name,)*
        }

        /// How many numbers each force has.
        const NUMBERS: &[usize] = &[$($numbers,)*];
        /// How many variables each force has.
        const VARIABLES: &[usize] = &[$(<$force<f64> as Force<f64>>::VARIABLES,)*];

        /// The coefficients of all forces beside those of the state.
        pub struct FurtherSeries<R: Real> {
            $(pub(crate) $name: <$force<R> as Force<R>>::Series,)*
        }

        impl Further<f64> {
            /// Nothing acts.
            pub const NONE: Further<f64> = Further::filled(0.0);
            /// How many numbers all forces have.
            pub const LEN: usize = before(NUMBERS, NUMBERS.len());
            /// How many variables all forces have.
            pub const VARIABLES: usize = before(VARIABLES, VARIABLES.len());
            /// The forces by name, with their words in messages and the places of their numbers.
            pub const LIST: &[(&str, &str, std::ops::Range<usize>)] =
                &[$((stringify!($name), $word, places(Place::$name as usize)),)*];

            /// The forces with these numbers, or the change of their numbers by these.
            pub fn of(numbers: &[f64; Further::LEN]) -> Self {
                Further { $($name: $force(part(numbers, before(NUMBERS, Place::$name as usize))),)* }
            }

            /// The forces with these numbers.
            ///
            /// # Errors
            /// If a number is not finite, or impossible.
            pub fn checked(numbers: &[f64; Further::LEN]) -> Result<Self, Error> {
                let further = Further::of(numbers);
                $(
                    if let Some(bad) = further.$name.0.iter().find(|x| !x.is_finite()) {
                        return refuse(stringify!($name), bad, "must be finite");
                    }
                    further.$name.check()?;
                )*
                Ok(further)
            }

            /// Whether each of them acts.
            pub fn act(&self) -> [bool; NUMBERS.len()] {
                [$(!self.$name.is_none(),)*]
            }

            /// Whether nothing acts.
            pub fn is_none(&self) -> bool {
                $(self.$name.is_none())&&*
            }

            /// Whether a torque depends on the attitude.
            pub fn acts_in_space(&self) -> bool {
                $((<$force<f64> as Force<f64>>::IN_SPACE && !self.$name.is_none()))||*
            }

            /// Whether a force may add momentum in space.
            pub fn drives(&self) -> bool {
                $(self.$name.drives())||*
            }

            /// See [`Bounded::strength`].
            pub fn strength(&self, moments: [f64; 3]) -> f64 {
                0.0 $(+ self.$name.strength(moments))*
            }

            /// See [`Bounded::reach`].
            pub fn reach(&self, start: &AtStart, root: f64) -> [f64; 2] {
                let [mut reach, mut turning] = [root, 0.0];
                $({
                    let [higher, turn] = self.$name.reach(start, reach);
                    (reach, turning) = (higher, turning + turn);
                })*
                [reach, turning]
            }

            /// See [`Bounded::step_rate`].
            fn step_rates(&self, pace: &Pace) -> f64 {
                0.0 $(+ self.$name.step_rate(pace))*
            }

            /// The variables of all forces at a time.
            pub fn start(&self, time: f64) -> [f64; Further::VARIABLES] {
                let mut variables = [0.0; Further::VARIABLES];
                $(self.$name.start(time, &mut variables[before(VARIABLES, Place::$name as usize)..]);)*
                variables
            }
        }

        impl Further<Row> {
            /// Sets the numbers of a lane.
            pub fn set(&mut self, lane: usize, further: &Further<f64>) {
                $(set_lane(&mut self.$name.0, lane, &further.$name.0);)*
            }

            /// The lanes of a pack.
            #[inline(always)]
            pub fn load<P: Pack>(&self, at: usize) -> Further<P> {
                Further { $($name: $force(load_rows(&self.$name.0, at)),)* }
            }
        }

        impl<R: Copy> Further<R> {
            /// The forces whose numbers are all the same.
            #[inline(always)]
            pub const fn filled(number: R) -> Self {
                Further { $($name: $force([number; $numbers]),)* }
            }
        }

        impl<R: Real> Further<R> {
            /// Whether a force of some lane acts.
            #[inline(always)]
            pub fn acts(&self) -> bool {
                let mut largest = R::splat(0.0);
                $(for k in 0..$numbers {
                    largest = largest.max(self.$name.0[k].abs());
                })*
                R::any(R::splat(0.0).lt(largest))
            }

            /// No coefficients yet.
            #[inline(always)]
            pub fn series() -> FurtherSeries<R> {
                FurtherSeries { $($name: <$force<R> as Force<R>>::series(),)* }
            }

            /// Adds all torques at a state to `torque`, those in space if there are space axes. The variables begin
            /// at `own`.
            #[inline(always)]
            pub fn add_torques<const IN_SPACE: bool, const D: usize>(
                &self,
                moments: &[R; 3],
                y: &[R; D],
                own: usize,
                torque: &mut [R; 3],
            ) {
                $(if IN_SPACE || !<$force<R> as Force<R>>::IN_SPACE {
                    self.$name.add_torque(moments, y, own + const { before(VARIABLES, Place::$name as usize) }, torque);
                })*
            }

            /// See [`Force::add_order`]; the variables of all forces begin at `at.own`.
            #[inline(always)]
            pub fn add_orders<const IN_SPACE: bool, const D: usize>(
                &self,
                moments: &[R; 3],
                c: &Coefficients<R, D>,
                at: Order<R>,
                series: &mut FurtherSeries<R>,
                next: &mut [R; D],
                torque: &mut [R; 3],
            ) {
                $(if IN_SPACE || !<$force<R> as Force<R>>::IN_SPACE {
                    let at = Order { own: at.own + const { before(VARIABLES, Place::$name as usize) }, ..at };
                    self.$name.add_order(moments, c, at, &mut series.$name, next, torque);
                })*
            }

            /// The forces with a change of their numbers.
            #[inline(always)]
            pub fn varied(&self, by: &Self) -> Further<Dual<R>> {
                Further { $($name: $force(Dual::of(&self.$name.0, &by.$name.0)),)* }
            }

            /// See [`Force::vary`]; the variables of all forces begin at `own`.
            #[inline(always)]
            pub fn vary<const D: usize>(&self, by: &Self, time: R, own: usize, y: &mut [Dual<R>; D]) {
                $(self.$name.vary(&by.$name, time, own + const { before(VARIABLES, Place::$name as usize) }, y);)*
            }

            /// Writes the rates of change of the variables of all forces, which begin at `own`.
            #[inline(always)]
            pub fn change<const D: usize>(&self, y: &[R; D], own: usize, change: &mut [R; D]) {
                $(self.$name.change(y, own + const { before(VARIABLES, Place::$name as usize) }, change);)*
            }
        }

        /// The rule of methods that integrate no further force.
        pub const NO_FURTHER: &str = concat!(
            "does not integrate ", $($word, ", ",)* "as Runge-Kutta methods and Taylor series do"
        );
    };
}
forces! {
    /// A rotor at constant speed.
    rotor: Rotor, 3, "a rotor";
    /// The gravity gradient on an orbit.
    orbit: Orbit, 9, "the gravity gradient of an orbit";
    /// Quadratic drag.
    drag: Drag, 3, "drag";
    /// An energy sink.
    dissipation: Dissipation, 3, "dissipation";
}

impl Further<f64> {
    /// Whether the gravity gradient of an orbit acts, and nothing else.
    pub fn is_orbit_alone(&self) -> bool {
        !self.is_none() && Further { orbit: self.orbit, ..Further::NONE } == *self
    }

    /// What the forces add to the rate that the steps of a body follow, whose rates reach `fastest`. The momentum in
    /// space is constant if there is no other torque, `is_torque_free`.
    pub fn step_rate(&self, moments: [f64; 3], omega: [f64; 3], fastest: f64, is_torque_free: bool) -> f64 {
        let [least, largest] = moment_range(moments);
        let rotor = self.rotor.0;
        let momentum = if is_torque_free && !self.drives() {
            length(&[0, 1, 2].map(|k| moments[k] * omega[k] + rotor[k]))
        } else {
            largest * fastest + length(&rotor)
        };
        let torque = momentum * fastest + self.strength(moments) * least.sqrt();
        self.step_rates(&Pace { moments, least, fastest, momentum, torque })
    }
}

/// The sum of the first numbers of a list.
const fn before(list: &[usize], count: usize) -> usize {
    let (mut sum, mut i) = (0, 0);
    while i < count {
        sum += list[i];
        i += 1;
    }
    sum
}

/// The places of the numbers of a force in the list.
const fn places(force: usize) -> std::ops::Range<usize> {
    before(NUMBERS, force)..before(NUMBERS, force + 1)
}

/// Neighbouring numbers from a place on.
fn part<const N: usize>(numbers: &[f64], at: usize) -> [f64; N] {
    let mut part = [0.0; N];
    part.copy_from_slice(&numbers[at..][..N]);
    part
}

/// Refuses negative coefficients.
fn not_negative(argument: &'static str, coefficients: [f64; 3]) -> Result<(), Error> {
    if coefficients.iter().any(|&c| c < 0.0) {
        return refuse(argument, format_args!("{coefficients:?}"), "must not be negative");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_forces_are_checked() {
        let mut numbers = [0.0; Further::LEN];
        let at = |name: &str| Further::LIST.iter().find(|(own, ..)| *own == name).unwrap().2.clone();
        numbers[at("rotor")].copy_from_slice(&[1.0, 2.0, 3.0]);
        numbers[at("dissipation")].copy_from_slice(&[0.0, 0.1, 0.2]);
        numbers[at("drag")].copy_from_slice(&[0.3, 0.0, 0.4]);
        numbers[at("orbit")].copy_from_slice(&[0.5, 0.6, 0.0, 1.0, 0.0, 0.0, 0.0, 0.8, 0.0]);
        let further = Further::checked(&numbers).unwrap();
        assert_eq!((further.rotor.0, further.drag.0), ([1.0, 2.0, 3.0], [0.3, 0.0, 0.4]));
        assert!(!further.is_none() && Further::NONE.is_none() && further.acts_in_space());
        let with = |name, k: usize, value: f64| {
            let mut changed = numbers;
            changed[at(name)][k] = value;
            Further::checked(&changed).unwrap_err().to_string()
        };
        assert!(with("rotor", 0, f64::NAN).starts_with("rotor = NaN"));
        assert!(with("dissipation", 1, -1.0).starts_with("dissipation = [0.0, -1.0, 0.2]"));
        assert!(with("drag", 2, -1.0).starts_with("drag = [0.3, 0.0, -1.0]"));
        assert!(with("orbit", 1, 1.0).starts_with("eccentricity = 1"));
        assert!(with("orbit", 3, 0.5).starts_with("periapsis = [0.5, 0.0, 0.0]"));
        assert!(with("orbit", 7, 0.5).starts_with("periapsis"));
    }
}
