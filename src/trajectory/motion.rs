//! Bodies that are moved step by step, under a torque that may change at each step.

use super::kinds_in;
use crate::body::Body;
use crate::error::Error;
use crate::forces::{BodyForces, ForceSet, Forces, TorqueFunction};
use crate::kernel::{Compiled, Entry, ForcesRows, Group, Kernel, MAX_STATE};
use crate::kernel::{KernelAssignment, Needs, System, load, reset_time, unload};
use crate::kinematics::length;
use crate::memory;
use crate::method::{Method, Step};
use crate::observe::Observed;
use crate::parallel::{Interrupt, over_blocks};
use crate::scene::Scene;
use crate::simd::{Isa, LANES, set_lane};
use crate::status::DRIFT_LIMIT;

/// Numbers of a body in motion: of its steps with their rounding errors, its rates and its attitude.
pub const NUMBERS: usize = 2 * MAX_STATE + 7;

/// Bodies in motion, and the code of their steps.
pub struct Motion {
    scene: &'static Scene,
    method: &'static Method,
    /// The forces of the scene.
    forces: Forces,
    /// Whether a torque has been applied: all bodies are then integrated as forced ones.
    is_pushed: bool,
    /// What acts on any of the bodies.
    acting: ForceSet,
    isa: Isa,
    /// The time now.
    time: f64,
    /// The largest damping rate of all bodies.
    damping_rate: f64,
    /// Whether a step has turned a body by more than the method bears.
    is_too_long: bool,
    groups: Vec<MovingGroup>,
    /// The group of each body, and its lane.
    places: Vec<[usize; 2]>,
}

/// Bodies that one kernel moves.
struct MovingGroup {
    /// Their indices among all.
    members: Vec<usize>,
    /// The bodies with their present rates and attitudes.
    bodies: Vec<Body>,
    assignments: Vec<KernelAssignment>,
    compiled: Compiled,
    lanes: Group,
    /// The forces on the lanes, without a function, which would borrow its data from `Motion`.
    forces_rows: Option<Box<ForcesRows<'static>>>,
    /// The torque on each body without that of a step, if no force on it changes: then the other rows do not change.
    constant: Vec<[f64; 3]>,
    /// The longest part of the last step.
    longest: f64,
}

/// The torque of a step in body axes: none, one for all bodies, or one for each.
pub type Torques<'a> = &'a [[f64; 3]];

/// Rates and attitudes of all bodies.
pub type Starts<'a> = (&'a [[f64; 3]], &'a [[f64; 4]]);

/// What the bodies are called if they do not fit into memory.
const BODIES: &str = "bodies in motion";

const LOST: &str = "the attitude is no rotation any more, because the steps are too long for the method, or the numbers \
    for doubles; the motion is lost, begin it again with shorter steps";

/// Knots of a table in one step from which on the step can be stopped. Between two knots a group of bodies moves for
/// some microseconds.
const MANY_KNOTS: usize = 256;

/// Whether the length of a quaternion has not drifted away from 1; NaN has.
fn is_rotation(attitude: [f64; 4]) -> bool {
    (length(&attitude) - 1.0).abs() <= DRIFT_LIMIT
}

impl Motion {
    /// The bodies at their start, at a time.
    ///
    /// # Errors
    /// If the method does not move the scene, or the bodies do not fit into memory.
    pub fn new(
        bodies: &[Body],
        time: f64,
        scene: &'static Scene,
        method: &'static Method,
        forces: Forces,
        isa: Isa,
    ) -> Result<Motion, Error> {
        method.check(scene)?;
        if forces.bodies() > 1 && forces.bodies() != bodies.len() {
            let (expected, got) = (format!("{} rows", bodies.len()), format!("{} rows", forces.bodies()));
            return Err(Error::Shape { argument: "forces", expected, got });
        }
        if forces.states_of_function() > 0 {
            let (value, rule) =
                (forces.states_of_function().to_string(), "a motion carries none; use simulate");
            return Err(Error::Value { argument: "states", value, rule });
        }
        let mut motion = Motion {
            scene,
            method,
            forces,
            is_pushed: false,
            acting: ForceSet::NONE,
            isa,
            time,
            damping_rate: 0.0,
            is_too_long: false,
            groups: Vec::new(),
            places: Vec::new(),
        };
        motion.load(bodies)?;
        Ok(motion)
    }

    /// What [`Motion::restore`] gives to another motion of the same request: the numbers of each body, and whether a torque
    /// has been applied.
    ///
    /// # Errors
    /// If the numbers do not fit into memory.
    pub fn numbers(&self) -> Result<(Vec<[f64; NUMBERS]>, bool), Error> {
        let mut all = memory::reserved(BODIES, self.len())?;
        for &[group, lane] in &self.places {
            let MovingGroup { lanes: Group { state, compensation, .. }, bodies, .. } = &self.groups[group];
            let mut numbers = [0.0; NUMBERS];
            let own = bodies[lane].omega.into_iter().chain(bodies[lane].attitude);
            let every = state.iter().chain(compensation).map(|row| row.0[lane]).chain(own);
            numbers.iter_mut().zip(every).for_each(|(to, number)| *to = number);
            all.push(numbers);
        }
        Ok((all, self.is_pushed))
    }

    /// Sets the bodies to the numbers of another motion of the same request.
    ///
    /// # Errors
    /// If there are not as many, or the bodies do not fit into memory.
    pub fn restore(&mut self, all: &[[f64; NUMBERS]], pushed: bool) -> Result<(), Error> {
        if all.len() != self.len() {
            let (expected, got) = (self.len().to_string(), all.len().to_string());
            return Err(Error::Shape { argument: "numbers", expected, got });
        }
        if pushed {
            self.push()?;
        }
        all.iter().enumerate().for_each(|(body, numbers)| self.set_numbers(body, numbers));
        Ok(())
    }

    fn set_numbers(&mut self, body: usize, numbers: &[f64; NUMBERS]) {
        let [group, lane] = self.places[body];
        let MovingGroup { lanes: Group { state, compensation, .. }, bodies, .. } = &mut self.groups[group];
        let rows = state.iter_mut().chain(compensation).map(|row| &mut row.0[lane]);
        let body = &mut bodies[lane];
        let every = rows.chain(&mut body.omega).chain(&mut body.attitude);
        every.zip(numbers).for_each(|(to, number)| *to = *number);
    }

    /// Begins the motion again with other rates and attitudes of the bodies. A body whose numbers are the same before goes on
    /// with all its bits.
    ///
    /// # Errors
    /// If there are not as many bodies. They are then as before.
    pub fn begin(&mut self, (omega, attitude): Starts, before: Starts) -> Result<(), Error> {
        for got in [omega.len(), attitude.len(), before.0.len(), before.1.len()] {
            if got != self.len() {
                let (expected, got) = (self.len().to_string(), got.to_string());
                return Err(Error::Shape { argument: "bodies", expected, got });
            }
        }
        for body in 0..self.len() {
            if omega[body] == before.0[body] && attitude[body] == before.1[body] {
                continue;
            }
            let [group, lane] = self.places[body];
            let group = &mut self.groups[group];
            (group.bodies[lane].omega, group.bodies[lane].attitude) = (omega[body], attitude[body]);
            group.load(lane, self.forces.of(body), self.time);
        }
        Ok(())
    }

    /// The present time.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Number of bodies.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Whether there are no bodies.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// The bodies with their present rates and attitudes.
    pub fn bodies(&self) -> impl Iterator<Item = &Body> {
        self.places.iter().map(|&[group, lane]| &self.groups[group].bodies[lane])
    }

    /// Makes one step: the torque is added to that of the scene and does not change during the step. Where a table of
    /// the scene's torque has a knot, the step is divided. Returns the largest angle by which the step has turned a body,
    /// the first time that the method does not bear the angle.
    ///
    /// # Errors
    /// If a number is not finite, if there is neither one torque nor one for each body, if the method does not move
    /// forced bodies or is unstable with the step, or if the table of the scene's torque does not reach its end;
    /// `Stopped` if `stop` is wanted in a step over many knots. The bodies are then as before. If the step is so long
    /// that an attitude is no rotation any more: the bodies are then lost.
    pub fn step(
        &mut self,
        dt: f64,
        torques: Torques,
        threads: usize,
        stop: &Interrupt,
    ) -> Result<Option<f64>, Error> {
        let refused = |argument, value: String, rule| Err(Error::Value { argument, value, rule });
        let n = self.len();
        if !dt.is_finite() {
            return refused("dt", dt.to_string(), "must be finite");
        }
        if torques.len() > 1 && torques.len() != n {
            let (expected, got) = (format!("(3,) or ({n}, 3)"), format!("({}, 3)", torques.len()));
            return Err(Error::Shape { argument: "torque", expected, got });
        }
        if let Some(bad) = torques.iter().flatten().find(|x| !x.is_finite()) {
            return refused("torque", bad.to_string(), "must be finite");
        }
        let [begin, end] = [self.time, self.time + dt];
        if !end.is_finite() {
            return refused("dt", dt.to_string(), "the time would leave the range of doubles");
        }
        if !torques.is_empty() || self.acting.act {
            self.check_forced(begin, dt)?;
        }
        if !torques.is_empty() {
            self.push()?;
        }
        let never = Interrupt::never();
        let (before, stop) = match self.passes_many_knots(dt) {
            true => (Some(self.numbers()?), stop),
            false => (None, &never),
        };
        let forces = &self.forces;
        // Below some 100 microseconds of work a thread is not worth its start.
        let threads = if n < 1000 { 1 } else { threads };
        let made = over_blocks(self.groups.iter_mut(), threads, stop, |group| {
            group.step(forces, [begin, dt], torques, stop)
        });
        if let (Err(_), Some((numbers, pushed))) = (&made, before) {
            self.restore(&numbers, pushed)?;
        }
        made?;
        self.time = end;
        if self.bodies().any(|body| !is_rotation(body.attitude)) {
            return refused("dt", dt.to_string(), LOST);
        }
        let angles = self
            .groups
            .iter()
            .flat_map(|group| group.bodies.iter().map(|body| group.longest * length(&body.omega)));
        let angle = angles.fold(0.0, f64::max);
        let is_first = !self.is_too_long && angle > self.method.facts.longest_angle;
        self.is_too_long |= is_first;
        Ok(is_first.then_some(angle))
    }

    /// Whether a step divides at so many knots of the table that it takes milliseconds.
    pub fn passes_many_knots(&self, dt: f64) -> bool {
        let [first, last] = [self.time.min(self.time + dt), self.time.max(self.time + dt)];
        self.forces.of(0).table.knots_between(first, last) > MANY_KNOTS
    }

    /// Refuses what `trajectory::simulate` refuses of forced bodies.
    fn check_forced(&self, begin: f64, dt: f64) -> Result<(), Error> {
        self.method.forced_limit()?;
        self.method.check_forces(ForceSet { act: true, ..self.acting })?;
        for time in [begin, begin + dt] {
            self.forces.of(0).table.check_reaches(time)?;
        }
        self.method.check_damping(None, dt.abs(), self.damping_rate)
    }

    /// Loads the bodies that are not forced anew into kernels of forced bodies.
    fn push(&mut self) -> Result<(), Error> {
        if self.is_pushed {
            return Ok(());
        }
        let is_forced = |&[group, _]: &[usize; 2]| self.groups[group].is_forced();
        if self.places.iter().all(is_forced) {
            self.is_pushed = true;
            return Ok(());
        }
        let bodies = memory::collected(BODIES, self.len(), self.bodies().copied())?;
        let were_forced = memory::collected(BODIES, self.len(), self.places.iter().map(is_forced))?;
        let (before, _) = self.numbers()?;
        self.is_pushed = true;
        if let Err(error) = self.load(&bodies) {
            self.is_pushed = false;
            return Err(error);
        }
        for (body, numbers) in before.iter().enumerate().filter(|&(body, _)| were_forced[body]) {
            self.set_numbers(body, numbers);
        }
        Ok(())
    }

    /// What acts on a body. An orbit is never alone: a torque may come.
    fn forces_on(&self, body: usize) -> ForceSet {
        let own = ForceSet::from(self.forces.of(body));
        ForceSet { act: own.act || self.is_pushed, orbit_alone: false, ..own }
    }

    /// Loads bodies into groups of one kind.
    fn load(&mut self, bodies: &[Body]) -> Result<(), Error> {
        let acting = (0..bodies.len()).fold(ForceSet::NONE, |all, body| all.and(self.forces_on(body)));
        if acting.act {
            self.check_forced(self.time, 0.0)?;
        }
        let assignment = |body: usize, forces: ForceSet| {
            KernelAssignment::of_either(forces.act, self.method, &bodies[body], self.scene)
        };
        let kind = |body: usize| -> (Step, ForceSet) {
            let forces = self.forces_on(body);
            (assignment(body, forces).step, forces)
        };
        let kinds = kinds_in(0..bodies.len(), kind)?;
        let mut groups = Vec::new();
        let mut places = memory::filled(BODIES, bodies.len(), [0; 2])?;
        let mut damping_rate = 0.0_f64;
        for members in kinds.iter().flat_map(|members| members.chunks(LANES)) {
            let (step, forces) = kind(members[0]);
            let needs = Needs { forces, directions: 0, attitude: true, tangent: false, is_changed: false };
            let system = System::carrying(self.scene, step, needs);
            let kernel = Kernel { system, step, observed: Observed::Nothing };
            let count = members.len();
            let assignments = members.iter().map(|&member| assignment(member, forces));
            let mut rows = Box::new(ForcesRows::NONE);
            let mut group = MovingGroup {
                members: memory::collected(BODIES, count, members.iter().copied())?,
                bodies: memory::collected(BODIES, count, members.iter().map(|&member| bodies[member]))?,
                assignments: memory::collected(BODIES, count, assignments)?,
                compiled: Compiled::new(kernel, self.isa),
                lanes: Group::inactive(),
                forces_rows: None,
                constant: memory::reserved(BODIES, count)?,
                longest: 0.0,
            };
            for (lane, &member) in members.iter().enumerate() {
                places[member] = [groups.len(), lane];
                let acting = self.forces.of(member);
                group.load(lane, acting, self.time);
                if !forces.act {
                    continue;
                }
                let moments = group.bodies[lane].moments;
                acting.damping.check_rates(moments)?;
                let [.., rate] = acting.damping.rates(moments);
                damping_rate = damping_rate.max(rate);
                // A function is told the time.
                if !acting.table.has_knots() && !forces.function {
                    let interval = acting.interval(0.0, false, acting.damping.modes(moments));
                    rows.set(lane, &interval);
                    group.constant.push(interval.body[0]);
                }
            }
            group.forces_rows = Some(rows);
            memory::push(BODIES, &mut groups, group)?;
        }
        (self.groups, self.places) = (groups, places);
        (self.acting, self.damping_rate) = (acting, damping_rate);
        Ok(())
    }
}

impl MovingGroup {
    fn is_forced(&self) -> bool {
        self.compiled.kernel().system.is_forced()
    }

    /// Loads the body of a lane, as it is at a time. The drifts of bodies in motion are not looked at.
    fn load(&mut self, lane: usize, forces: BodyForces, time: f64) {
        let entry = Entry::unobserved(&self.bodies[lane], forces, (time, None), None, 0.0);
        load(&mut self.lanes, lane, self.compiled, self.assignments[lane], &entry);
    }

    /// Makes one step from a time, or several with the knots of a table between them.
    fn step(
        &mut self,
        forces: &Forces,
        times: [f64; 2],
        torques: Torques,
        stop: &Interrupt,
    ) -> Result<(), Error> {
        if times[1] == 0.0 {
            return Ok(());
        }
        if let Some(function) = forces.function() {
            let mut rows = Box::new(ForcesRows::with_room(function.width())?);
            return self.advance((forces, Some(function)), times, torques, stop, &mut rows);
        }
        let mut rows = self.forces_rows.take().expect("put back after each step");
        let made = self.advance((forces, None), times, torques, stop, &mut rows);
        self.forces_rows = Some(rows);
        made
    }

    fn advance<'f>(
        &mut self,
        (forces, function): (&Forces, Option<&'f TorqueFunction>),
        [begin, dt]: [f64; 2],
        torques: Torques,
        stop: &Interrupt,
        rows: &mut ForcesRows<'f>,
    ) -> Result<(), Error> {
        let (end, backward) = (begin + dt, dt < 0.0);
        // All tables have the same times.
        let table = forces.of(self.members[0]).table;
        let mut from = begin;
        self.longest = 0.0;
        // A round for each knot of the table.
        loop {
            if stop.is_wanted() {
                return Err(Error::Stopped);
            }
            let is_before = |&knot: &f64| if backward { knot > end } else { knot < end };
            let knot = table.next_knot(from, backward).filter(is_before);
            let to = knot.unwrap_or(end);
            // The difference of two times would round a whole step.
            let step = if from == begin && to == end { dt } else { to - from };
            self.longest = self.longest.max(step.abs());
            if self.is_forced() {
                self.apply((forces, function), (from, backward), torques, rows);
            }
            for lane in 0..self.bodies.len() {
                self.lanes.step.0[lane] = step;
            }
            self.compiled.process(&mut self.lanes, false);
            self.compiled.advance(&mut self.lanes, rows, 1);
            self.compiled.process(&mut self.lanes, true);
            if knot.is_none() {
                break;
            }
            from = to;
        }
        self.read();
        Ok(())
    }

    /// Sets the forces on each lane from a time on.
    fn apply<'f>(
        &mut self,
        (forces, function): (&Forces, Option<&'f TorqueFunction>),
        (time, backward): (f64, bool),
        torques: Torques,
        rows: &mut ForcesRows<'f>,
    ) {
        let system = self.compiled.kernel().system;
        for (lane, (&member, body)) in self.members.iter().zip(&self.bodies).enumerate() {
            let mut torque = match self.constant.get(lane) {
                Some(torque) => *torque,
                None => {
                    let forces = forces.of(member);
                    let interval = forces.interval(time, backward, forces.damping.modes(body.moments));
                    rows.set(lane, &interval);
                    rows.functions.set(lane, function.map(|function| function.of(member).from(time)));
                    interval.body[0]
                }
            };
            if let Some(added) = torques.get(member).or(torques.first()) {
                for k in 0..3 {
                    torque[k] += added[k];
                }
            }
            set_lane(&mut rows.numbers.body[0], lane, &torque);
            reset_time(&mut self.lanes, system, lane);
        }
    }

    /// Reads the present rates and attitudes.
    fn read(&mut self) {
        for (lane, body) in self.bodies.iter_mut().enumerate() {
            let now = unload(&self.lanes, lane, self.compiled, self.assignments[lane]);
            body.omega = now.omega;
            body.attitude = now.attitude_after(&body.attitude).expect("the attitude is always integrated");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::method::RK4;
    use crate::scene::FREE;

    const BODY: Body = Body {
        moments: [1.0, 2.0, 2.5],
        weight: [0.0; 3],
        omega: [0.1, 1.0, 0.2],
        attitude: [1.0, 0.0, 0.0, 0.0],
    };

    fn motion(bodies: &[Body]) -> Motion {
        Motion::new(bodies, 0.0, &FREE, &RK4, Forces::NONE.copied().unwrap(), Isa::NARROWEST).unwrap()
    }

    #[test]
    fn bodies_in_one_motion_move_as_they_move_alone() {
        let bodies: Vec<Body> =
            (0..70).map(|i| Body { omega: [0.1, 1.0, 0.01 * f64::from(i)], ..BODY }).collect();
        let torques: Vec<[f64; 3]> = (0..70).map(|i| [0.0, 0.02 * f64::from(i), 0.1]).collect();
        let mut together = motion(&bodies);
        together.step(0.125, &[], 1, &Interrupt::never()).unwrap();
        together.step(0.125, &torques, 2, &Interrupt::never()).unwrap();
        for (index, moved) in together.bodies().enumerate() {
            let mut alone = motion(&bodies[index..][..1]);
            alone.step(0.125, &[], 1, &Interrupt::never()).unwrap();
            alone.step(0.125, &torques[index..][..1], 1, &Interrupt::never()).unwrap();
            assert_eq!(alone.bodies().next().unwrap(), moved, "body {index}");
        }
    }

    #[test]
    fn a_refused_step_changes_nothing() {
        let mut moving = motion(&[BODY; 2]);
        for (dt, torques) in
            [(f64::NAN, &[][..]), (0.1, &[[f64::INFINITY, 0.0, 0.0]][..]), (0.1, &[[0.0; 3]; 3][..])]
        {
            assert!(moving.step(dt, torques, 1, &Interrupt::never()).is_err());
            assert_eq!((moving.time(), moving.bodies().copied().collect::<Vec<_>>()), (0.0, vec![BODY; 2]));
        }
    }
}
