//! Growth of deviation vectors: how fast neighbouring motions part, by steps of a method with a tangent.
//!
//! The deviation vectors of a body are integrated with one motion, if the method can, or in lanes of their own, each
//! with the motion. After some steps they are divided by powers of two, which changes no digit, and all but the first
//! are made orthogonal to those before.

use super::frame::{Frame, MAX_DEVIATIONS};
use super::legs::LegGroup;
use super::states::first;
use super::{Integration, Request, blocks, kinds_in, steps_of_legs};
use crate::call::Call;
use crate::error::Error;
use crate::kernel::{Compiled, DeviationRows, Entry, Group, Job, System, drive, load};
use crate::memory;
use crate::method::Method;
use crate::observe::{Deviation, Growth, Observed};
use crate::parallel::over_blocks;
use crate::simd::LANES;
use crate::status::{DRIFT_LIMIT, Status};

/// Steps between two divisions of a deviation vector, so few that none overflows; of several, so few that they do not
/// align.
pub const STEPS_TOGETHER: [u64; 2] = [64, 16];

/// Bodies in a group of a method whose steps move all deviation vectors: they take so long that one register of bodies
/// hides every latency, and few wait for the body with the most steps.
const FEW: usize = LANES / 4;

/// The deviation vectors of the bodies of a request, and what is asked for.
#[derive(Clone, Copy)]
pub struct Deviations<'a> {
    /// Deviation vectors of each body, one after another.
    pub each: &'a [Deviation],
    /// Number of deviation vectors of a body.
    pub count: usize,
}

/// Growth at the output times, body first: of all bodies, or of some neighbours.
pub struct Growths<Numbers = Vec<f64>, Statuses = Vec<Status>, Counts = Vec<u64>> {
    /// ln of the size over that at the start, of the first deviation vector; its largest until then; its mean over the
    /// time; and the mean over the time of `ln - mean`: (n, times, 4).
    pub logs: Numbers,
    /// ln of what each deviation vector keeps across those before it, over that at the start: (n, times, count).
    pub log_diagonal: Numbers,
    /// ln of GALI of the first 1, 2, … deviation vectors: (n, times, count).
    pub log_gali: Numbers,
    /// SALI of the first two: (n, times).
    pub sali: Numbers,
    /// Largest relative error of the energy after some steps.
    pub energy_drift: Numbers,
    /// How each body ended.
    pub status: Statuses,
    /// Steps of each body.
    pub steps: Counts,
}

/// Growth of the first deviation vector at a time.
const LOGS: usize = 4;

impl Growths {
    fn reserved(bodies: usize, times: usize, count: usize) -> Result<Growths, Error> {
        let unknown = |width: usize| {
            let length = bodies.saturating_mul(times).saturating_mul(width);
            memory::filled("growth of deviation vectors", length, f64::NAN)
        };
        Ok(Growths {
            logs: unknown(LOGS)?,
            log_diagonal: unknown(count)?,
            log_gali: unknown(count)?,
            sali: unknown(1)?,
            energy_drift: memory::filled("drifts", bodies, f64::NAN)?,
            status: memory::filled("statuses", bodies, Status::Finished)?,
            steps: memory::filled("steps", bodies, 0)?,
        })
    }
}

/// Growth of the deviation vectors of the bodies of a request at its times, which are positive.
///
/// # Errors
/// If the method has no tangent or does not move the bodies, if a step is beyond its stability, if the request was
/// stopped, or if the results do not fit into memory.
pub fn growth(
    request: &Request,
    method: &Method,
    deviations: Deviations,
    Call { isa, threads, stop }: Call,
) -> Result<Growths, Error> {
    assert!((1..=MAX_DEVIATIONS).contains(&deviations.count));
    assert_eq!(deviations.each.len(), request.bodies.len() * deviations.count);
    method.check(request.scene)?;
    method.check_tangent(!request.forces.is_none())?;
    request.check_deviations()?;
    if !request.forces.is_none() {
        super::check_forced(request, method)?;
    }
    let times = request.schedule.len();
    let mut growths = Growths::reserved(request.bodies.len(), times, deviations.count)?;
    let mut rest = Part {
        logs: &mut growths.logs,
        log_diagonal: &mut growths.log_diagonal,
        log_gali: &mut growths.log_gali,
        sali: &mut growths.sali,
        energy_drift: &mut growths.energy_drift,
        status: &mut growths.status,
        steps: &mut growths.steps,
    };
    let blocks = blocks(request.bodies.len(), threads, |index| steps_of_legs(request, index))?;
    let parts =
        blocks.iter().map(|block| (block.clone(), rest.split_off(times, deviations.count, block.len())));
    over_blocks(parts, threads, stop, |(block, mut part)| {
        let integrations = Integration::of_block(request, method, block.clone())?;
        let kind = |index: usize| integrations[index - block.start].kind();
        for mut alike in kinds_in(block.clone(), kind)? {
            // Bodies with as many steps together, so that few wait for others.
            alike.sort_unstable_by_key(|&index| steps_of_legs(request, block.start + index));
            let compiled = Compiled::new(integrations[alike[0]].kernel(request, Observed::Growth), isa);
            let (lanes_each, together) = if compiled.shares_motion() {
                (1, FEW)
            } else {
                (deviations.count, LANES / deviations.count)
            };
            let mut lanes = Group::inactive();
            for members in alike.chunks(together) {
                let lanes = (&mut lanes, lanes_each);
                let job = GrowthJob {
                    legs: LegGroup::new(request, &integrations, block.start, members, compiled, lanes, stop)?,
                    deviations,
                    part: &mut part,
                    frames: [Frame::new(deviations.count, isa); LANES],
                    start_logs: [[0.0; MAX_DEVIATIONS]; LANES],
                };
                job.run()?;
            }
        }
        Ok(())
    })?;
    Ok(growths)
}

/// The growth of some neighbouring bodies.
type Part<'a> = Growths<&'a mut [f64], &'a mut [Status], &'a mut [u64]>;

impl<'a> Part<'a> {
    fn split_off(&mut self, times: usize, count: usize, bodies: usize) -> Part<'a> {
        Part {
            logs: first(&mut self.logs, LOGS * times * bodies),
            log_diagonal: first(&mut self.log_diagonal, count * times * bodies),
            log_gali: first(&mut self.log_gali, count * times * bodies),
            sali: first(&mut self.sali, times * bodies),
            energy_drift: first(&mut self.energy_drift, bodies),
            status: first(&mut self.status, bodies),
            steps: first(&mut self.steps, bodies),
        }
    }
}

/// The growth of the bodies of one group.
struct GrowthJob<'a, 'b> {
    legs: LegGroup<'a>,
    deviations: Deviations<'a>,
    part: &'a mut Part<'b>,
    frames: [Frame; LANES],
    start_logs: [[f64; MAX_DEVIATIONS]; LANES],
}

impl Job for GrowthJob<'_, '_> {
    /// The number of the body in the group: its first lane has the task.
    type Task = usize;

    fn load(&mut self, _: usize) -> Result<Option<usize>, Error> {
        let legs = &mut self.legs;
        let Some(b) = legs.waiting.next() else { return Ok(None) };
        let (body, lane, count) = (legs.body(b), legs.lane(b), self.deviations.count);
        let (rate, assignment) = (legs.forced_rate(b), legs.integration(b).assignment);
        let each = &self.deviations.each[legs.index(b) * count..][..count];
        let forces = legs.request.forces_of(legs.index(b));
        let entry = Entry::unobserved(body, forces, (0.0, legs.place(b)), rate, 0.0);
        for j in 0..legs.lanes_each {
            let entry = Entry { deviation: each[j], ..entry };
            load(legs.lanes, lane + j, legs.compiled, assignment, &entry);
        }
        for (rows, deviation) in legs.lanes.further.iter_mut().zip(&each[legs.lanes_each..]) {
            let start = assignment.deviation(deviation, body).start;
            rows.state.iter_mut().zip(start).for_each(|(row, number)| row.0[lane] = number);
        }
        self.renormalise(b);
        let (norm, gamma, deviations) = self.read(b);
        self.start_logs[b] = self.frames[b].log_diagonal(&norm, &gamma, &deviations[..count]);
        Ok(Some(b))
    }

    /// Advances every body by its leg. Deviation vectors are renormalised after each so many steps of a leg and at its end,
    /// so that they do not depend on the other bodies of the group.
    fn advance(&mut self, _: &[Option<usize>; LANES]) -> Result<(), Error> {
        self.legs.begin_legs();
        let bodies = self.legs.members.len();
        let together = STEPS_TOGETHER[usize::from(self.deviations.count > 1)];
        let mut done = 0;
        // Each round ends a leg, or adds steps to `done`.
        loop {
            let legs = &mut self.legs;
            let ends = legs.legs[..bodies].iter().map(|leg| leg.steps).filter(|&steps| steps > done);
            let Some(end) = ends.min() else { return Ok(()) };
            if legs.stop.is_wanted() {
                return Err(Error::Stopped);
            }
            let next = end.min((done / together + 1) * together);
            legs.set_steps(done);
            let worst = legs.lanes.energy.worst;
            legs.advance(next - done);
            for b in 0..bodies {
                let steps = self.legs.legs[b].steps;
                let is_due = next % together == 0 || next == steps;
                if steps > done {
                    let all = self.legs.steps[b].map_or(f64::INFINITY, |all| all as f64);
                    self.legs.stop.tell((next - done) as f64 / all);
                }
                if steps > done && is_due {
                    self.renormalise(b);
                } else {
                    // So that the drift does not depend on the other bodies either.
                    let lanes = self.legs.lanes_of(b);
                    self.legs.lanes.energy.worst.0[lanes.clone()].copy_from_slice(&worst.0[lanes]);
                }
            }
            done = next;
        }
    }

    fn look(&mut self, _: usize, &mut b: &mut usize) -> Result<bool, Error> {
        if let Some(state) = self.legs.state(b) {
            self.record(b, self.legs.members[b] * self.legs.request.schedule.len() + state);
        }
        Ok(!self.legs.is_over)
    }
}

impl GrowthJob<'_, '_> {
    fn run(mut self) -> Result<(), Error> {
        for (&member, &steps) in self.legs.members.iter().zip(&self.legs.steps) {
            match steps {
                Some(steps) => self.part.steps[member] = steps,
                None => self.part.status[member] = Status::StepLimit,
            }
        }
        if self.legs.begin(false)? {
            let further = self.deviations.count - self.legs.lanes_each;
            self.legs.lanes.further = memory::filled("deviations", further, DeviationRows::ZERO)?;
            drive(&mut self)?;
        }
        Ok(())
    }

    /// The norm of a body in the variables of the kernel.
    fn norm(&self, b: usize) -> Deviation {
        let norm = self.deviations.each[self.legs.index(b) * self.deviations.count];
        self.legs.integration(b).assignment.deviation(&norm, self.legs.body(b))
    }

    /// Norm, vertical and deviation vectors of a body, in the variables of the kernel.
    fn read(&self, b: usize) -> (Deviation, [f64; 3], [[f64; 6]; MAX_DEVIATIONS]) {
        let (legs, count) = (&self.legs, self.deviations.count);
        let system = legs.compiled.kernel().system;
        let (gamma, deviations) = read(legs.lanes, system, legs.lane(b), count);
        (self.norm(b), gamma, deviations)
    }

    /// Makes the deviation vectors of a body orthogonal, and near one in size.
    fn renormalise(&mut self, b: usize) {
        let (norm, legs) = (self.norm(b), &mut self.legs);
        let (lane, is_damped) = (legs.lane(b), legs.integration(b).forces.act);
        let system = legs.compiled.kernel().system;
        renormalise(legs.lanes, system, lane, &norm, is_damped, &mut self.frames[b]);
    }

    /// Writes the growth of a body, number `at` of all.
    fn record(&mut self, b: usize, at: usize) {
        let (norm, gamma, deviations) = self.read(b);
        let (count, member, lane) = (self.deviations.count, self.legs.members[b], self.legs.lane(b));
        let (group, part) = (&*self.legs.lanes, &mut *self.part);
        let rows = group.observed_in(lane);
        part.logs[LOGS * at..][..LOGS].copy_from_slice(&Growth::logs(&rows));
        let deviations = &deviations[..count];
        let diagonal = self.frames[b].log_diagonal(&norm, &gamma, deviations);
        let (gali, sali) = self.frames[b].alignment(&norm, &gamma, deviations);
        for j in 0..count {
            part.log_diagonal[count * at + j] = diagonal[j] - self.start_logs[b][j];
            part.log_gali[count * at + j] = gali[j];
        }
        part.sali[at] = sali;
        let drift = group.energy.worst.0[lane];
        part.energy_drift[member] = drift;
        let finite = [0, 1, 2].iter().all(|&d| group.state[d].0[lane].is_finite()) && drift.is_finite();
        part.status[member] = match (finite, drift <= DRIFT_LIMIT) {
            (false, _) => Status::NotFinite,
            (true, false) => Status::Drifted,
            (true, true) => Status::Finished,
        };
        if !finite {
            let unknown = |values: &mut [f64]| values.fill(f64::NAN);
            unknown(&mut part.logs[LOGS * at..][..LOGS]);
            unknown(&mut part.log_diagonal[count * at..][..count]);
            unknown(&mut part.log_gali[count * at..][..count]);
            unknown(&mut part.sali[at..=at]);
        }
    }
}

/// The vertical and the deviation vectors of a body in lanes from `lane` on, or in one lane if they share a motion.
fn read(group: &Group, system: System, lane: usize, count: usize) -> ([f64; 3], [[f64; 6]; MAX_DEVIATIONS]) {
    let at = system.tangent_at.expect("the system has a deviation vector");
    let gamma = [3, 4, 5].map(|d| group.state[d].0[lane]);
    let mut deviations = [[0.0; 6]; MAX_DEVIATIONS];
    for j in 0..count {
        let (rows, lane) = match group.further.get(j.wrapping_sub(1)) {
            Some(further) => (&further.state[..], lane),
            None => (&group.state[at..at + 6], lane + j),
        };
        deviations[j] = std::array::from_fn(|k| rows[k].0[lane]);
    }
    (gamma, deviations)
}

/// Makes the deviation vectors of a body orthogonal, and near one in size, as many as the frame has. They are in lanes
/// from `lane` on, or in one lane if they share a motion.
pub fn renormalise(
    group: &mut Group,
    system: System,
    lane: usize,
    norm: &Deviation,
    is_damped: bool,
    frame: &mut Frame,
) {
    let count = frame.count();
    let at = system.tangent_at.expect("the system has a deviation vector");
    let (gamma, mut deviations) = read(group, system, lane, count);
    if !norm.of_attitude {
        // A turn about the vertical is not seen by this norm. It is removed before it outgrows what is: from the
        // first only under damping, which shrinks the rest.
        for deviation in &mut deviations[if is_damped { 0 } else { 1 }..count] {
            remove_turn(deviation, &gamma);
        }
    }
    let shifts = frame.renormalise(norm, &gamma, &mut deviations[..count]);
    for j in 0..count {
        let (rows, rests, lane) = match group.further.get_mut(j.wrapping_sub(1)) {
            Some(further) => (&mut further.state[..], &mut further.compensation[..], lane),
            None => {
                group.observed[Growth::SHIFT].0[lane + j] += shifts[j] as f64;
                (&mut group.state[at..at + 6], &mut group.compensation[at..at + 6], lane + j)
            }
        };
        for k in 0..6 {
            let rest = &mut rests[k].0[lane];
            // Of a deviation vector that was changed the lost digits are those of another.
            *rest = if j == 0 { super::frame::times_power_of_two(*rest, -shifts[0]) } else { 0.0 };
            rows[k].0[lane] = deviations[j][k];
        }
    }
}

/// Removes the part of the rotation vector along the vertical.
fn remove_turn(deviation: &mut [f64; 6], gamma: &[f64; 3]) {
    let product = |a: &[f64]| a[0].mul_add(gamma[0], a[1].mul_add(gamma[1], a[2] * gamma[2]));
    let share = product(&deviation[3..]) / product(gamma);
    for k in 0..3 {
        deviation[3 + k] = (-share).mul_add(gamma[k], deviation[3 + k]);
    }
}
