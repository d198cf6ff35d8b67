//! `Forces`: those of one body or of many; `BodyForces`: those of one of them; `ForcesInterval`: those in a kernel.

use super::body_rows::{BodyRows, copied};
use super::table::{self, Knot, Samples};
use super::{
    AtStart, Bounded, Damping, FEWEST_STEPS, Further, MOST_STATES, Modes, PlaceOfRoot, Rotor, Table,
    TorqueCall, TorqueCalls, TorqueFunction, Trajectory, part,
};
use crate::error::{Error, refuse};
use crate::inertia::moment_range;
use crate::memory;
use crate::real::Real;
use crate::special::exp;

/// What a table is called if it does not fit into memory.
const TABLE: &str = "table of the torque";
const ROTOR: &str = "table of the rotor";
const TRAJECTORY: &str = "table of the orbit";

/// The forces on a body, on an interval of time in which its tables are polynomials.
#[derive(Clone, Copy)]
pub struct ForcesInterval<'a, R> {
    /// Torque in the body at the begin of the interval, and its rate of change.
    pub body: [[R; 3]; 2],
    /// Torque in space at the begin of the interval, and its rate of change.
    pub space: [[R; 3]; 2],
    /// Damping: the torque is minus this matrix times the rates; its entries 11, 22, 33, 23, 31, 12.
    pub damping: [R; 6],
    /// Damping rates of the body without torque: eigenvalues of `I^(-1/2) D I^(-1/2)`.
    pub rates: [R; 3],
    /// Eigenvectors of the damping rates, as columns.
    pub modes: [[R; 3]; 3],
    /// The further forces, with the rotor at the begin of the interval.
    pub further: Further<R>,
    /// The rate of change of the momentum of the rotor; what it takes from the body is in the torque.
    pub rotor_change: [R; 3],
    /// The trajectory whose gravity gradient acts.
    pub trajectory: Trajectory<R>,
    /// The functions that return a further torque.
    pub functions: Option<TorqueCalls<'a, R>>,
    /// The change of the parameters by which the body deviates, if deviation vectors are integrated.
    pub change: ParameterChange<R>,
}

/// A small change of the parameters of a body, whose effect is a deviation vector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterChange<R> {
    /// Of the principal moments.
    pub moments: [R; 3],
    /// Of `mgl com`.
    pub weight: [R; 3],
    /// Of the damping matrix: its entries 11, 22, 33, 23, 31, 12.
    pub damping: [R; 6],
    /// Of the torque in the body, at all times.
    pub torque: [R; 3],
    /// Of the numbers of the further forces.
    pub further: Further<R>,
}

impl ParameterChange<f64> {
    /// Number of parameters without those of the further forces.
    pub const OWN: usize = 15;
    /// Number of parameters.
    pub const LEN: usize = ParameterChange::OWN + Further::LEN;

    /// The change with these numbers: of moments, weight, damping, torque and the further forces.
    pub fn of(numbers: &[f64; ParameterChange::LEN]) -> Self {
        let [i1, i2, i3, w1, w2, w3, d11, d22, d33, d23, d31, d12, t1, t2, t3] = part(numbers, 0);
        ParameterChange {
            moments: [i1, i2, i3],
            weight: [w1, w2, w3],
            damping: [d11, d22, d33, d23, d31, d12],
            torque: [t1, t2, t3],
            further: Further::of(&part(numbers, ParameterChange::OWN)),
        }
    }
}

impl<R: Copy> ParameterChange<R> {
    /// The change whose numbers are all the same.
    #[inline(always)]
    pub const fn filled(number: R) -> Self {
        ParameterChange {
            moments: [number; 3],
            weight: [number; 3],
            damping: [number; 6],
            torque: [number; 3],
            further: Further::filled(number),
        }
    }
}

impl<R: Copy> ForcesInterval<'_, R> {
    /// The interval whose numbers are all the same, without functions.
    #[inline(always)]
    pub const fn filled(number: R) -> Self {
        ForcesInterval {
            body: [[number; 3]; 2],
            space: [[number; 3]; 2],
            damping: [number; 6],
            rates: [number; 3],
            modes: [[number; 3]; 3],
            further: Further::filled(number),
            rotor_change: [number; 3],
            trajectory: Trajectory([[number; 3]; 4]),
            functions: None,
            change: ParameterChange::filled(number),
        }
    }
}

impl<R: Real> ForcesInterval<'_, R> {
    /// No forces.
    #[inline(always)]
    pub fn none() -> Self {
        ForcesInterval::filled(R::splat(0.0))
    }

    /// The same for code of a kernel, whose types cannot name a lifetime.
    ///
    /// # Safety
    /// As [`TorqueCalls::outliving`].
    #[inline(always)]
    pub unsafe fn outliving(&self) -> ForcesInterval<'static, R> {
        let ForcesInterval { body, space, damping, rates, modes, further, rotor_change, .. } = *self;
        let ForcesInterval { trajectory, change, .. } = *self;
        ForcesInterval {
            body,
            space,
            damping,
            rates,
            modes,
            further,
            rotor_change,
            trajectory,
            // SAFETY: the caller's promise.
            functions: self.functions.map(|functions| unsafe { functions.outliving() }),
            change,
        }
    }
}

/// The tables of one kind of some bodies, which have the same times.
#[derive(Clone, Debug, PartialEq)]
struct Tables<T> {
    /// As in [`Samples`].
    times: Vec<f64>,
    /// The values of the tables, a table in a row.
    values: BodyRows<T>,
}

impl<T: Copy> Tables<T> {
    const NONE: Tables<T> = Tables { times: Vec::new(), values: BodyRows::NONE };

    /// Tables at these times, table after table; a value a table without times.
    fn new(what: &str, times: &[f64], values: Vec<T>) -> Result<Self, Error> {
        let values = BodyRows::of_width(values, times.len().max(1));
        Ok(Tables { times: copied(what, times)?, values })
    }

    fn of(&self, body: usize) -> Samples<'_, T> {
        Samples { times: &self.times, values: self.values.of(body) }
    }

    fn of_some(&self, what: &str, bodies: Option<&[usize]>) -> Result<Self, Error> {
        Ok(Tables { times: copied(what, &self.times)?, values: self.values.of_some(what, bodies)? })
    }
}

/// The forces on one body or on many. All tables of one kind have the same times, and each table, matrix or row of
/// numbers is that of one body or serves all.
#[derive(Clone, Debug, PartialEq)]
pub struct Forces {
    /// Torques, as in [`Table`].
    torques: Tables<[[f64; 3]; 2]>,
    /// Momenta of rotors, as in [`Table`].
    rotors: Tables<[f64; 3]>,
    /// The trajectory of all bodies, as in [`Table`].
    trajectory: Tables<Knot>,
    /// See [`Table::doubt`].
    doubt: f64,
    /// The damping matrices, as in [`Damping`].
    dampings: BodyRows<[f64; 6]>,
    further: BodyRows<Further<f64>>,
    /// The function that returns a torque.
    function: Option<TorqueFunction>,
}

impl Forces {
    /// No forces.
    pub const NONE: &'static Forces = &Forces {
        torques: Tables::NONE,
        rotors: Tables::NONE,
        trajectory: Tables::NONE,
        doubt: 0.0,
        dampings: BodyRows::NONE,
        further: BodyRows::NONE,
        function: None,
    };

    /// Torques in the body and in space, given at some times (without times: constant torques), and damping.
    ///
    /// # Errors
    /// If a number is not finite, if the times descend, if there is not one value for each time, or if damping would
    /// add energy.
    pub fn new(
        times: &[f64],
        body: &[[f64; 3]],
        space: &[[f64; 3]],
        dampings: &[[f64; 6]],
    ) -> Result<Forces, Error> {
        table::check(times, body, space)?;
        let values = body.iter().zip(space).map(|(&body, &space)| [body, space]);
        let values = memory::collected(TABLE, body.len(), values)?;
        let matrices = BodyRows::of_width(copied("damping", dampings)?, 1);
        let torques = Tables::new(TABLE, times, values)?;
        let made = Forces { torques, dampings: matrices, ..Forces::NONE.copied()? };
        let rows = [body.len() / times.len().max(1), dampings.len()];
        if rows.iter().any(|&rows| rows > 1 && rows != made.bodies()) {
            let (expected, got) = (format!("({}, ...)", made.bodies()), format!("{rows:?} rows"));
            return Err(Error::Shape { argument: "torque and damping", expected, got });
        }
        dampings.iter().try_for_each(|&entries| Damping(entries).check())?;
        Ok(made)
    }

    /// The same with further forces: the numbers of each body, or of all.
    ///
    /// # Errors
    /// If numbers are impossible, or those of another number of bodies.
    pub fn with_further(self, rows: &[[f64; Further::LEN]]) -> Result<Forces, Error> {
        let mut further = memory::reserved("forces", rows.len())?;
        for row in rows {
            further.push(Further::checked(row)?);
        }
        self.check_rows("forces", further.len())?;
        Ok(Forces { further: BodyRows::of_width(further, 1), ..self })
    }

    /// The same with rotors whose momenta are tables: table after table.
    ///
    /// # Errors
    /// If the tables are impossible, or those of another number of bodies.
    pub fn with_rotors(self, times: &[f64], momenta: &[[f64; 3]]) -> Result<Forces, Error> {
        table::check_smooth("rotor", times, momenta, 2)?;
        let rotors = Tables::new(ROTOR, times, copied(ROTOR, momenta)?)?;
        self.check_rows("rotor", rotors.values.len())?;
        Ok(Forces { rotors, ..self })
    }

    /// The same on a trajectory with these samples of `sqrt(3 gm / r^3) o`, which serves all bodies.
    ///
    /// # Errors
    /// If the samples are impossible.
    pub fn on_trajectory(self, times: &[f64], samples: &[[f64; 3]]) -> Result<Forces, Error> {
        let trajectory = Tables::new(TRAJECTORY, times, table::spline(times, samples)?)?;
        Ok(Forces { trajectory, ..self })
    }

    /// The same with the torque that a function returns.
    ///
    /// # Errors
    /// If it is that of another number of bodies.
    pub fn with_function(self, function: TorqueFunction) -> Result<Forces, Error> {
        self.check_rows("data", function.bodies())?;
        Ok(Forces { function: Some(function), ..self })
    }

    /// Refuses rows of another number of bodies.
    fn check_rows(&self, argument: &'static str, rows: usize) -> Result<(), Error> {
        let bodies = self.bodies();
        if rows > 1 && bodies > 1 && rows != bodies {
            let (expected, got) = (format!("({bodies}, ...)"), format!("({rows}, ...)"));
            return Err(Error::Shape { argument, expected, got });
        }
        Ok(())
    }

    /// The same forces.
    ///
    /// # Errors
    /// If they do not fit into memory once more.
    pub fn copied(&self) -> Result<Forces, Error> {
        self.rows_of(None)
    }

    /// The forces on some bodies, in this order; what serves all stays.
    ///
    /// # Errors
    /// If there is no such body, or they do not fit into memory.
    pub fn of_some(&self, bodies: &[usize]) -> Result<Forces, Error> {
        if let Some(bad) = bodies.iter().find(|&&body| self.bodies() > 1 && body >= self.bodies()) {
            return refuse("body", bad, "there is no such body");
        }
        self.rows_of(Some(bodies))
    }

    fn rows_of(&self, bodies: Option<&[usize]>) -> Result<Forces, Error> {
        Ok(Forces {
            torques: self.torques.of_some(TABLE, bodies)?,
            rotors: self.rotors.of_some(ROTOR, bodies)?,
            trajectory: self.trajectory.of_some(TRAJECTORY, bodies)?,
            doubt: self.doubt,
            dampings: self.dampings.of_some("damping", bodies)?,
            further: self.further.of_some("forces", bodies)?,
            function: self.function.as_ref().map(|function| function.of_some(bodies)).transpose()?,
        })
    }

    /// The same with damping and orbits that are rounded otherwise, by a unit in the last place: of the damping the
    /// diagonal up, the rest down, or with a sign of -1 the other way round. So equal dampings of all axes stay equal, and a matrix that is nearly singular changes
    /// its least rate. A step rounds how far an orbit has gone alike in every step, as another rate would. A trajectory is
    /// another by its doubt.
    ///
    /// # Errors
    /// As `of_some`.
    pub fn rounded_otherwise(&self, sign: f64) -> Result<Forces, Error> {
        let mut forces = self.copied()?;
        for (k, entry) in forces.dampings.values.iter_mut().flat_map(|damping| damping.iter_mut().enumerate())
        {
            *entry *= 1.0 + if k < 3 { sign * f64::EPSILON } else { -sign * f64::EPSILON };
        }
        forces.further.values.iter_mut().for_each(|further| further.orbit.round_otherwise(sign));
        forces.doubt += sign;
        Ok(forces)
    }

    /// The same with a trajectory that is another by its doubt: for a second run whose rounding does not matter.
    ///
    /// # Errors
    /// As `of_some`.
    pub fn doubted(&self) -> Result<Forces, Error> {
        Ok(Forces { doubt: self.doubt + 1.0, ..self.copied()? })
    }

    /// The forces on neighbouring bodies; `None` if all have the same.
    ///
    /// # Errors
    /// As `of_some`.
    pub fn of_range(&self, bodies: std::ops::Range<usize>) -> Result<Option<Forces>, Error> {
        if self.bodies() == 1 {
            return Ok(None);
        }
        self.of_some(&memory::collected("bodies", bodies.len(), bodies)?).map(Some)
    }

    /// The number of bodies on which they act; 1 if all have the same.
    pub fn bodies(&self) -> usize {
        let tables = self.torques.values.len().max(self.rotors.values.len());
        let functions = self.function.as_ref().map_or(1, TorqueFunction::bodies);
        tables.max(self.dampings.len()).max(self.further.len()).max(functions)
    }

    /// How many numbers a function is given for each body.
    pub fn function_width(&self) -> usize {
        self.function.as_ref().map_or(0, TorqueFunction::width)
    }

    /// The forces on one of the bodies.
    pub fn of(&self, body: usize) -> BodyForces<'_> {
        BodyForces {
            table: Table {
                torque: self.torques.of(body),
                rotor: self.rotors.of(body),
                trajectory: self.trajectory.of(body),
                doubt: self.doubt,
            },
            damping: self.dampings.of(body).first().map_or(Damping::NONE, |&one| Damping(one)),
            further: self.further.of(body).first().unwrap_or(&Further::NONE),
            function: self.function.as_ref().map(|function| function.of(body)),
        }
    }

    /// How many states a function has for each body.
    pub fn states_of_function(&self) -> usize {
        self.function.as_ref().map_or(0, TorqueFunction::states)
    }

    /// The function that returns a torque.
    pub fn function(&self) -> Option<&TorqueFunction> {
        self.function.as_ref()
    }

    /// Whether nothing acts on any body.
    pub fn is_none(&self) -> bool {
        (0..self.bodies()).all(|body| self.of(body).is_none())
    }
}

/// Whole numbers of which each bit is one of these.
fn bits(set: &[bool]) -> u64 {
    set.iter().rev().fold(0, |bits, &one| bits << 1 | u64::from(one))
}

/// The forces on one body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyForces<'a> {
    /// The table of a torque.
    pub table: Table<'a>,
    /// Linear damping.
    pub damping: Damping,
    /// The further forces.
    pub further: &'a Further<f64>,
    /// The function that returns a torque.
    pub function: Option<TorqueCall<'a>>,
}

impl<'a> BodyForces<'a> {
    /// No forces.
    pub const NONE: BodyForces<'static> =
        BodyForces { table: Table::NONE, damping: Damping::NONE, further: &Further::NONE, function: None };

    /// Whether nothing acts. A table of zeros acts.
    pub fn is_none(&self) -> bool {
        self.damping.is_none() && self.further.is_none() && self.function.is_none() && self.table.is_none()
    }

    /// Whether a further force acts, by its numbers or by a table.
    pub fn acts_further(&self) -> bool {
        !self.further.is_none() || self.table.acts_further()
    }

    /// The same with a trajectory that is another by its doubt: for a second run.
    pub fn doubted(self) -> Self {
        BodyForces { table: Table { doubt: 1.0, ..self.table }, ..self }
    }

    /// What acts, as bits: a table, which may be of zeros, damping, a function, and each further force.
    pub fn kinds(&self) -> u64 {
        let Table { torque, rotor, trajectory, .. } = &self.table;
        let tables = [torque.values.is_empty(), rotor.values.is_empty(), trajectory.values.is_empty()];
        let others = [!tables[0], !self.damping.is_none(), self.function.is_some(), !tables[1], !tables[2]];
        bits(&others) | bits(&self.further.act()) << others.len()
    }

    /// Whether a torque depends on the attitude at any time: the rates then depend on it too.
    pub fn acts_in_space(&self) -> bool {
        self.further.acts_in_space() || self.function.is_some() || self.table.acts_in_space()
    }

    /// The forces without functions on a body whose damping has these modes, from a time to the next knot, forward or
    /// backward.
    pub fn interval(&self, time: f64, backward: bool, (rates, modes): Modes) -> ForcesInterval<'static, f64> {
        let [[body, body_slope], [space, space_slope]] = self.table.torques(time, backward);
        let (mut further, mut rotor_change) = (*self.further, [0.0; 3]);
        if let Some([momentum, change]) = self.table.momentum(time, backward) {
            (further.rotor, rotor_change) = (Rotor(momentum), change);
        }
        ForcesInterval {
            body: [body, body_slope],
            space: [space, space_slope],
            damping: self.damping.0,
            rates,
            modes,
            further,
            rotor_change,
            trajectory: self.table.trajectory.polynomial(time, backward, self.table.doubt),
            functions: None,
            change: ParameterChange::filled(0.0),
        }
    }

    /// What the function is told of the place at a time; zero without an orbit.
    pub fn place(&self, time: f64) -> [f64; 3] {
        let trajectory = self.table.trajectory.polynomial(time, false, self.table.doubt);
        if trajectory.acts() {
            return f64::outlined(PlaceOfRoot(trajectory.root(0.0)));
        }
        let mut variables = [0.0; 2];
        self.further.orbit.start(time, &mut variables);
        self.further.orbit.place(variables)
    }

    /// The states of the function at the start.
    pub fn states(&self) -> [f64; MOST_STATES] {
        self.function.map_or([0.0; MOST_STATES], |function| function.start())
    }

    /// The function, told the time of states whose time is zero at this time.
    pub fn function_from(&self, time: f64) -> Option<TorqueCall<'a>> {
        self.function.map(|function| function.from(time))
    }

    /// Whether the gravity gradient of an orbit acts, and nothing else: not even a torque that is zero, under which a body
    /// is integrated like its neighbours.
    pub fn orbit_alone(&self) -> bool {
        let has_others = !self.damping.is_none() || self.function.is_some() || !self.table.is_none();
        !has_others && self.further.is_orbit_alone()
    }

    /// The damping, if nothing else acts at any time.
    pub fn damping_alone(&self) -> Option<Damping> {
        let is_alone = self.further.is_none() && self.function.is_none() && self.table.is_zero();
        is_alone.then_some(self.damping)
    }

    /// The rate k, if nothing acts but a damping `D = k I`. All components of the momentum then decay as `exp(-k t)`,
    /// and the motion is a free motion in a transformed time.
    pub fn slows_evenly(&self, moments: [f64; 3]) -> Option<f64> {
        self.damping_alone()?.slows_evenly(moments)
    }

    /// What the further forces add to the rate that the steps of a body follow, whose rates reach `fastest`.
    pub fn further_step_rate(&self, moments: [f64; 3], omega: [f64; 3], fastest: f64) -> f64 {
        if !self.acts_further() {
            return 0.0;
        }
        let is_torque_free = self.table.is_zero() && self.damping.is_none();
        self.further_bound().step_rate(moments, omega, fastest, is_torque_free)
    }

    /// The further forces, with the largest momentum of the rotor.
    fn further_bound(&self) -> Further<f64> {
        let rotor = self.table.largest_momentum().map_or(self.further.rotor, Rotor);
        Further { rotor, ..*self.further }
    }

    /// The longest step of a run between two times that looks at the torque of a function often enough; infinite without
    /// a function.
    pub fn longest_unseen(&self, [first, last]: [f64; 2]) -> f64 {
        if self.function.is_some() { (last - first) / FEWEST_STEPS } else { f64::INFINITY }
    }

    /// A bound of |omega| between two times around 0, from the power balance. `twice_kinetic` is taken at the start,
    /// `mgl` is the weight, `fall` the energy that the body can gain by falling.
    ///
    /// With `u = |I^(1/2) omega|`, `u' <= |I^(-1/2) torque| - d u`, and `|omega| <= u / sqrt(I_min)`; `d` is the
    /// least damping rate. Backward in time damping adds energy at the largest rate. A further force that adds energy
    /// has a potential, whose bound raises u, if need be seen from a frame that turns; `reach` and `turning` are of
    /// it. The others add none; backward in time they add energy without bound, and the rates are taken as if they
    /// added none. Of a function a bound may be known.
    pub fn fastest_rate(
        &self,
        (moments, omega, attitude): ([f64; 3], [f64; 3], [f64; 4]),
        [twice_kinetic, mgl, fall]: [f64; 3],
        [first, last]: [f64; 2],
    ) -> f64 {
        let [least, _] = moment_range(moments);
        let [d, .., fastest] = self.damping.rates(moments);
        let strength = self.table.strength(moments) + self.further.strength(moments);
        let start = twice_kinetic.sqrt();
        let at_start = AtStart { moments, omega, attitude, rotor: self.further_bound().rotor.0 };
        let [reach, turning] = self.further.reach(&at_start, (twice_kinetic + 2.0 * fall).sqrt());
        let reach = self.table.reach(moments, reach, [first, last]);
        // Damping slows the rates in space, not those seen from a turning frame.
        let drag = |time: f64| if turning > 0.0 { turning * fastest.max(0.0) * time } else { 0.0 };
        let mut forward =
            reach + turning + self.table.gain(moments, 0.0, last.max(0.0)) + drag(last.max(0.0));
        let mut swing = (mgl / least).sqrt();
        if d > 0.0 {
            forward = forward.min(start + (mgl / least.sqrt() + strength) / d);
            swing = swing.min(mgl / (least * d));
        }
        let back = first.min(0.0);
        let mut u = forward;
        if back < 0.0 {
            let gained = self.table.gain(moments, back, 0.0) + drag(-back);
            u = u.max((reach + gained) * exp(-fastest.max(0.0) * back) + turning);
        }
        let called = self.function.map_or(0.0, |function| function.fastest());
        (u / least.sqrt()).max(swing).max(called)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn damping(entries: [f64; 6]) -> Result<Forces, Error> {
        Forces::new(&[], &[[0.0; 3]], &[[0.0; 3]], &[entries])
    }

    #[test]
    fn the_absence_of_forces_is_a_value() {
        let none = Forces::NONE.of(7);
        assert!(Forces::NONE.is_none() && none.is_none() && !none.acts_in_space());
        assert!(!damping([0.0; 6]).unwrap().is_none());
        assert_eq!(none.table.next_knot(0.0, false), None);
        assert!(none.table.check_reaches(1e300).is_ok());
    }

    #[test]
    fn each_body_has_a_torque_and_a_damping_of_its_own_or_that_of_all() {
        let (torques, none) = ([[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0]], [[0.0; 3]; 3]);
        let [strong, weak] = [[2.0; 6], [0.0; 6]].map(|d: [f64; 6]| [d[0], d[1], d[2], 0.0, 0.0, 0.0]);
        let forces = Forces::new(&[], &torques, &none, &[strong]).unwrap();
        assert_eq!(forces.bodies(), 3);
        for (body, torque) in torques.into_iter().enumerate() {
            let interval = forces.of(body).interval(0.0, false, Damping(strong).modes([1.0; 3]));
            assert_eq!((interval.body[0], interval.damping), (torque, strong));
        }
        let some = forces.of_some(&[2, 0]).unwrap();
        assert_eq!((some.bodies(), some.of(0), some.of(1)), (2, forces.of(2), forces.of(0)));
        assert!(forces.of_some(&[3]).is_err());
        let damped = Forces::new(&[], &[], &[], &[strong, weak]).unwrap();
        assert!(!damped.is_none() && !damped.of(0).is_none() && damped.of(1).is_none());
        let tables = Forces::new(&[0.0, 1.0], &[[0.0; 3]; 4], &[[0.0; 3]; 4], &[strong, weak]).unwrap();
        assert_eq!((tables.bodies(), tables.of(1).table.torque.times), (2, &[0.0, 1.0][..]));
        assert!(Forces::new(&[], &torques, &none, &[strong, weak]).is_err());
    }

    #[test]
    fn a_torque_is_linear_between_its_knots_and_jumps_at_equal_times() {
        let torque = [[1.0, 0.0, 0.0], [3.0, 0.0, 0.0], [7.0, 0.0, 0.0], [7.0, 0.0, 0.0]];
        let forces = Forces::new(&[0.0, 2.0, 2.0, 4.0], &torque, &[[0.0; 3]; 4], &[[0.0; 6]]).unwrap();
        let forces = forces.of(0);
        let at = |time, backward| {
            forces.interval(time, backward, Damping::NONE.modes([1.0; 3])).body.map(|x| x[0])
        };
        assert_eq!(at(0.0, false), [1.0, 1.0]);
        assert_eq!(at(1.0, false), [2.0, 1.0]);
        assert_eq!(at(2.0, false), [7.0, 0.0]);
        assert_eq!(at(2.0, true), [3.0, 1.0]);
        assert_eq!(forces.table.next_knot(0.0, false), Some(2.0));
        assert_eq!(forces.table.next_knot(4.0, true), Some(2.0));
        assert_eq!([0.0, 1.0, 2.0, 4.0].map(|time| forces.table.jumps_at(time)), [false, false, true, false]);
    }

    #[test]
    fn damping_that_adds_energy_is_refused() {
        assert!(damping([1.0, 1.0, 1.0, 0.0, 0.0, 1.0]).is_ok());
        // The product of the off-diagonal entries exceeds that of the diagonal ones by a few roundings only.
        assert!(damping([1.0, 1.0, 1.0, 0.0, 0.0, 1.0 + f64::EPSILON]).is_ok());
        assert!(damping([1.0, 1.0, 1.0, 0.0, 0.0, 1.0 + 1e-14]).is_err());
        assert!(damping([-1e-300, 0.0, 0.0, 0.0, 0.0, 0.0]).is_err());
    }

    #[test]
    fn modes_of_damping_are_eigenvectors() {
        let entries = [2.0, 3.0, 5.0, 0.4, -0.3, 0.7];
        let moments = [1.0, 2.0, 4.0];
        let (rates, modes) = damping(entries).unwrap().of(0).damping.modes(moments);
        let matrix = Damping(entries).matrix();
        for k in 0..3 {
            for i in 0..3 {
                let row: f64 =
                    (0..3).map(|j| matrix[i][j] / f64::sqrt(moments[i] * moments[j]) * modes[j][k]).sum();
                assert!((row - rates[k] * modes[i][k]).abs() < 1e-14, "mode {k}, row {i}");
            }
        }
        let even = damping([2.0, 4.0, 8.0, 0.0, 0.0, 0.0]).unwrap();
        let even = even.of(0);
        assert_eq!(even.slows_evenly(moments), Some(2.0));
        assert_eq!(even.slows_evenly([1.0, 2.0, 3.0]), None);
    }
}
