//! The states that a request returns, and the errors of their invariants.

use super::request::{Record, Request};
use crate::error::Error;
use crate::forces::MOST_STATES;
use crate::kernel::{State, scale_of};
use crate::kinematics::length;
use crate::memory;
use crate::real::larger;
use crate::status::{DRIFT_LIMIT, Status};

/// The values of a column.
#[derive(Clone)]
pub enum Column {
    /// Numbers of each output time of each body, this many in a row; `None` if they are not recorded.
    Series(usize, Option<Vec<f64>>),
    /// A number of each body.
    Numbers(Vec<f64>),
    /// A whole number of each body.
    Counts(Vec<u64>),
    /// A status of each body.
    Statuses(Vec<Status>),
}

impl From<Vec<f64>> for Column {
    fn from(values: Vec<f64>) -> Column {
        Column::Numbers(values)
    }
}

impl From<Vec<u64>> for Column {
    fn from(values: Vec<u64>) -> Column {
        Column::Counts(values)
    }
}

impl From<Vec<Status>> for Column {
    fn from(values: Vec<Status>) -> Column {
        Column::Statuses(values)
    }
}

/// Writes `States`, `StatesPart` and all that follows from their columns: `times` have a name, the numbers in a row and
/// whether a request records them; `bodies` have a name, a type and the value of a body that was not moved.
macro_rules! states {
    (
        times { $($(#[$time_doc:meta])* $time:ident: $width:expr, |$request:pat_param| $recorded:expr;)* }
        bodies { $($(#[$body_doc:meta])* $body:ident: $type:ty, $unknown:expr;)* }
    ) => {
        /// States and the errors of their invariants, body first.
        pub struct States {
            $($(#[$time_doc])* pub $time: Option<Vec<f64>>,)*
            $($(#[$body_doc])* pub $body: Vec<$type>,)*
        }

        /// The states of some neighbouring bodies.
        pub struct StatesPart<'a> {
            $($(#[$time_doc])* pub $time: Option<&'a mut [f64]>,)*
            $($(#[$body_doc])* pub $body: &'a mut [$type],)*
        }

        impl States {
            /// The columns of output times that a request records, with the numbers of each in a row.
            pub fn recorded(request: &Request) -> Vec<(&'static str, usize)> {
                let mut columns = Vec::new();
                $({
                    let $request = request;
                    if $recorded {
                        columns.push((stringify!($time), $width));
                    }
                })*
                columns
            }

            /// Bytes of the states of `n` bodies at so many times but for columns that are given; neither the bodies
            /// nor the times of the request matter. Beyond any number of bytes the product does not matter.
            pub fn bytes(request: &Request, n: usize, times: usize, given: &[&str]) -> u128 {
                let states = (n as u128).saturating_mul(times as u128);
                let mut bytes = 0_u128;
                $({
                    let $request = request;
                    let is_own = $recorded && !given.contains(&stringify!($time));
                    let width = if is_own { ($width * size_of::<f64>()) as u128 } else { 0 };
                    bytes = bytes.saturating_add(states.saturating_mul(width));
                })*
                $(bytes = bytes.saturating_add(n as u128 * size_of::<$type>() as u128);)*
                bytes
            }

            /// All memory that the states of `n` bodies take but for columns that are given; the bodies of the request
            /// do not matter.
            pub fn reserved(request: &Request, n: usize, given: &[&str]) -> Result<States, Error> {
                let times = request.schedule.len();
                let bytes = States::bytes(request, n, times, given);
                let reworded = |error| match error {
                    Error::Memory { limit, .. } => {
                        Error::Memory { what: format!("states of {n} bodies at {times} times"), bytes, limit }
                    }
                    error => error,
                };
                let refused = || Error::Memory { what: String::new(), bytes, limit: None };
                memory::check("", bytes).map_err(reworded)?;
                Ok(States {
                    $($time: {
                        let $request = request;
                        let length = n.checked_mul(times).and_then(|states| states.checked_mul($width));
                        ($recorded && !given.contains(&stringify!($time)))
                            .then(|| memory::zeros("", length.ok_or_else(refused)?))
                            .transpose()
                            .map_err(|_| reworded(refused()))?
                    },)*
                    $($body: memory::filled("", n, $unknown).map_err(|_| reworded(refused()))?,)*
                })
            }

            /// The states of all bodies.
            pub fn whole(&mut self) -> StatesPart<'_> {
                StatesPart {
                    $($time: self.$time.as_deref_mut(),)*
                    $($body: &mut self.$body,)*
                }
            }

            /// The columns by their names.
            pub fn into_columns(self) -> Vec<(&'static str, Column)> {
                vec![
                    $((stringify!($time), Column::Series($width, self.$time)),)*
                    $((stringify!($body), self.$body.into()),)*
                ]
            }
        }

        impl<'a> StatesPart<'a> {
            /// Splits the states of the first bodies off.
            pub fn split_off(&mut self, times: usize, bodies: usize) -> StatesPart<'a> {
                StatesPart {
                    $($time: self.$time.as_mut().map(|values| first(values, $width * times * bodies)),)*
                    $($body: first(&mut self.$body, bodies),)*
                }
            }

            /// Lets a column of output times be written into given memory.
            pub fn give(&mut self, column: &str, values: &'a mut [f64]) {
                match column {
                    $(stringify!($time) => self.$time = Some(values),)*
                    _ => unreachable!("the names are those of `recorded`"),
                }
            }

            /// Copies the states of a body from those of another run at as many times.
            pub fn copy(&mut self, times: usize, body: usize, others: &StatesPart, from: usize) {
                $(if let (Some(values), Some(others)) = (&mut self.$time, &others.$time) {
                    let length = $width * times;
                    values[length * body..][..length].copy_from_slice(&others[length * from..][..length]);
                })*
                $(self.$body[body] = others.$body[from];)*
            }

            /// The same states.
            pub fn again(&mut self) -> StatesPart<'_> {
                StatesPart {
                    $($time: self.$time.as_deref_mut(),)*
                    $($body: &mut *self.$body,)*
                }
            }

            /// Makes all states unknown, as those of bodies that are not moved stay.
            pub(super) fn forget(&mut self) {
                $(if let Some(values) = &mut self.$time {
                    values.fill(f64::NAN);
                })*
            }

            /// Changes each recorded number of state number `at` of all.
            fn change_each(&mut self, at: usize, mut change: impl FnMut(&mut f64)) {
                $(if let Some(values) = &mut self.$time {
                    values[$width * at..][..$width].iter_mut().for_each(&mut change);
                })*
            }
        }
    };
}

/// Splits the first elements off.
pub(super) fn first<'a, T>(rest: &mut &'a mut [T], count: usize) -> &'a mut [T] {
    rest.split_off_mut(..count).expect("the parts are as long as the whole")
}

states! {
    times {
        /// Rates, (n, times, 3), unless deviation vectors are recorded.
        omega: 3, |request| !request.record.is_tangent();
        /// The vertical seen from the body, (n, times, 3), if recorded.
        gamma: 3, |request| match request.record {
            Record::Rates | Record::Tangent(_) | Record::Sensitivity(_) => false,
            Record::Axis => true,
            Record::Attitude => request.scene.has_weight,
        };
        /// Attitude, (n, times, 4), if recorded.
        attitude: 4, |request| request.record == Record::Attitude;
        /// Deviation vectors, (n, times, 6), if recorded: changes of the rates, and rotation vectors in the body.
        tangent: 6, |request| request.record.is_tangent();
        /// Work of torque and damping since the start, (n, times), of forced bodies.
        work: 1, |request| !request.forces.is_none() && !request.record.is_tangent();
        /// States of a function, (n, times, `MOST_STATES`), if there are any; zero beyond those that there are.
        states: MOST_STATES, |request| request.forces.states_of_function() > 0 && !request.record.is_tangent();
    }
    bodies {
        /// Largest energy error at an output time, relative. For a forced body: the error of the energy less the work,
        /// relative to the energy at the start plus the energy at that time.
        energy_drift: f64, f64::NAN;
        /// Largest error of the conserved momentum at an output time, relative.
        momentum_drift: f64, f64::NAN;
        /// Largest deviation of |gamma| and |q| from one.
        unit_drift: f64, f64::NAN;
        /// A bound of |omega| over the motion, of closed forms without forces.
        fastest_rate: f64, f64::NAN;
        /// How each body ended.
        status: Status, Status::Finished;
        /// Steps that each body took.
        steps: u64, 0;
    }
}

impl States {
    /// The rates. Panics if deviation vectors are recorded instead.
    pub fn rates(&self) -> &[f64] {
        self.omega.as_deref().expect("rates are recorded but with deviation vectors")
    }
}

impl StatesPart<'_> {
    /// Whether the vertical is recorded.
    pub(super) fn records_vertical(&self) -> bool {
        self.gamma.is_some()
    }

    /// The drifts of energy, momentum and unit lengths.
    pub(super) fn drifts(&mut self) -> [&mut [f64]; 3] {
        [self.energy_drift, self.momentum_drift, self.unit_drift]
    }

    /// Writes the state of a body, number `at` of all, and updates its drifts, given start and inverse scale of energy
    /// and conserved momentum.
    pub(super) fn record(
        &mut self,
        body: usize,
        at: usize,
        now: &State,
        (invariants, last): ([[f64; 2]; 2], &mut [f64; 4]),
    ) {
        if let Some(omega) = &mut self.omega {
            omega[3 * at..][..3].copy_from_slice(&now.omega);
        }
        let mut units = 0.0_f64;
        if let Some(direction) = &now.direction {
            units = larger(units, (length(direction) - 1.0).abs());
            if let Some(gamma) = &mut self.gamma {
                gamma[3 * at..][..3].copy_from_slice(direction);
            }
        }
        if let (Some(attitude), Some(attitudes)) = (now.attitude_after(last), &mut self.attitude) {
            *last = attitude;
            units = larger(units, (length(&attitude) - 1.0).abs());
            attitudes[4 * at..][..4].copy_from_slice(&attitude);
        }
        if let Some(work) = &mut self.work {
            // A body without forces may have neighbours with them.
            work[at] = now.balance.map_or(0.0, |balance| balance.work);
        }
        let mut finite = true;
        if let Some(states) = &mut self.states {
            let now = now.states.unwrap_or([0.0; MOST_STATES]);
            finite = now.iter().all(|x| x.is_finite());
            states[MOST_STATES * at..][..MOST_STATES].copy_from_slice(&now);
        }
        if let (Some(now), Some(tangent)) = (&now.tangent, &mut self.tangent) {
            tangent[6 * at..][..6].copy_from_slice(now);
        }
        for [energy, momentum] in invariant_errors(now, invariants).into_iter().flatten() {
            self.energy_drift[body] = larger(self.energy_drift[body], energy);
            self.momentum_drift[body] = larger(self.momentum_drift[body], momentum);
        }
        self.unit_drift[body] = larger(self.unit_drift[body], units);
        finite &= now.omega.iter().chain(&now.invariants).all(|x| x.is_finite()) && units.is_finite();
        if !finite {
            self.status[body] = Status::NotFinite;
            // The sign of a NaN is that of the instruction that made it.
            let one_nan = |x: &mut f64| *x = if x.is_nan() { f64::NAN } else { *x };
            self.change_each(at, one_nan);
            for drift in self.drifts() {
                one_nan(&mut drift[body]);
            }
        } else if self.status[body] == Status::Finished {
            let drifts = [self.energy_drift[body], self.momentum_drift[body], self.unit_drift[body]];
            // A NaN is not below the limit.
            if !drifts.iter().all(|&drift| drift <= DRIFT_LIMIT) {
                self.status[body] = Status::Drifted;
            }
        }
    }
}

/// The relative errors of energy and conserved momentum of a state, and of a top those with the vertical that follows
/// from its attitude, given start and inverse scale of both.
#[inline]
pub(super) fn invariant_errors(now: &State, at_start: [[f64; 2]; 2]) -> [Option<[f64; 2]>; 2] {
    let scales = now.balance.map(|balance| balance.scales);
    let mut errors = [None; 2];
    // Loops: the closures of `map` are calls, which took a quarter of the time of dense states.
    for (error, invariants) in errors.iter_mut().zip([Some(now.invariants), now.invariants_of_attitude]) {
        let Some(invariants) = invariants else { continue };
        let mut both = [0.0; 2];
        for i in 0..2 {
            let [start, inverse_scale] = at_start[i];
            let off = (invariants[i] - start).abs();
            both[i] = match scales {
                // Of a body at rest that nothing has moved yet both are zero.
                Some(scales) if off == 0.0 && scales[i].is_finite() => 0.0,
                Some(scales) => off / (scales[i] + scale_of(inverse_scale)),
                None => off * inverse_scale,
            };
        }
        *error = Some(both);
    }
    errors
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::forces::Forces;
    use crate::method::AnyMethod;
    use crate::scene::{FREE, Scene, TOP};
    use crate::trajectory::Schedule;

    fn request<'a>(scene: &'static Scene, record: Record<'a>) -> Request<'a> {
        Request {
            bodies: &[],
            scene,
            forces: Forces::NONE,
            method: AnyMethod::Exact,
            record,
            schedule: Schedule::Times(&[0.0, 1.0]),
            steps: &[],
            tolerance: None,
            refinement: 1.0,
            max_steps: 1,
        }
    }

    #[test]
    fn what_is_recorded_follows_from_the_request() {
        for (scene, record, gamma, attitude) in [
            (&FREE, Record::Rates, false, false),
            (&TOP, Record::Axis, true, false),
            (&FREE, Record::Attitude, false, true),
            (&TOP, Record::Attitude, true, true),
        ] {
            let request = request(scene, record);
            let all = States::reserved(&request, 3, &[]).unwrap();
            assert_eq!((all.gamma.is_some(), all.attitude.is_some()), (gamma, attitude));
            assert!(all.work.is_none());
            let names: Vec<_> = States::recorded(&request).into_iter().map(|(name, _)| name).collect();
            assert!(States::reserved(&request, 3, &names).unwrap().omega.is_none());
            assert_eq!(names.len(), 1 + usize::from(gamma) + usize::from(attitude));
            assert_eq!((all.omega.unwrap().len(), all.energy_drift.len(), all.status.len()), (18, 3, 3));
        }
    }

    #[test]
    fn parts_are_the_states_of_neighbours() {
        let request = request(&FREE, Record::Attitude);
        let mut all = States::reserved(&request, 3, &[]).unwrap();
        let mut rest = all.whole();
        for (value, bodies) in [1, 2].into_iter().enumerate() {
            let mut part = rest.split_off(2, bodies);
            part.energy_drift.fill(value as f64);
            part.attitude.as_mut().unwrap().fill(value as f64);
            assert!(part.gamma.is_none());
        }
        assert_eq!(all.energy_drift, [0.0, 1.0, 1.0]);
        assert_eq!(all.attitude.unwrap(), [[0.0; 8], [1.0; 8], [1.0; 8]].concat());
    }
}
