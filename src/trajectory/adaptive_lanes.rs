//! Lanes that choose their steps, each under the forces on its body.

use super::Request;
use crate::call::Call;
use crate::error::Error;
use crate::kernel::{
    AdaptiveSteps, Compiled, Entry, ForcesRows, Group, Kernel, KernelAssignment, load, reset_time,
};
use crate::observe::Deviation;
use crate::parallel::Interrupt;
use crate::simd::LANES;

/// The longest step under a function (rad): the body turns by this angle at most, so that no step leaps over what it does.
const LONGEST: f64 = 2.0;

/// The angle (rad) by which a body turns in its whole run at the least rate that is a scale of errors under a function.
/// A torque that should be zero but for rounding gives smaller rates: a share of those would ask for endless steps.
const STILL: f64 = 1e-6;

/// The lanes of one kernel.
pub(super) struct AdaptiveLanes<'a> {
    request: &'a Request<'a>,
    pub(super) kernel: Compiled,
    pub(super) group: Group,
    pub(super) steps: AdaptiveSteps,
    forces_rows: ForcesRows<'a>,
    /// The next knot of the forces on each lane; infinite if there is none.
    knots: [f64; LANES],
    /// The time of each lane when its steps were last counted.
    counted_at: [f64; LANES],
    /// How many bodies have been in a lane.
    pub(super) entered: usize,
    /// How many bodies are told to be done.
    told: f64,
    stop: &'a Interrupt<'a>,
}

impl<'a> AdaptiveLanes<'a> {
    pub(super) fn new(
        request: &'a Request<'a>,
        kernel: Kernel,
        Call { isa, stop, .. }: Call<'a>,
        tolerance: f64,
    ) -> Result<Self, Error> {
        Ok(AdaptiveLanes {
            request,
            kernel: Compiled::new(kernel, isa),
            group: Group::inactive(),
            steps: AdaptiveSteps::inactive(tolerance, kernel.step.numbers.order)?,
            forces_rows: ForcesRows::with_room(request.forces.function_width())?,
            knots: [f64::INFINITY; LANES],
            counted_at: [f64::NAN; LANES],
            entered: 0,
            told: 0.0,
            stop,
        })
    }

    /// Loads a body into a lane, at its start; returns a bound of its rates in the time range of its motion.
    pub(super) fn enter(
        &mut self,
        lane: usize,
        index: usize,
        assignment: KernelAssignment,
        range: [f64; 2],
        backward: bool,
    ) -> f64 {
        let (body, forces) = (&self.request.bodies[index], self.request.forces_of(index));
        let (mut rate, span) = (body.fastest_rate(forces, range), range[1] - range[0]);
        if forces.function.is_some() {
            let unseen = forces.longest_unseen(range) / self.request.refinement;
            self.steps.longest.0[lane] = (LONGEST / rate).min(unseen);
            rate = rate.max(STILL / span);
        }
        let first = self.request.steps[index];
        // A body that does not turn needs one step.
        let first = if first.is_finite() { first } else { span };
        let direction = if backward { -1.0 } else { 1.0 };
        let deviation = Deviation::new(self.request.record.deviation_of(index));
        let forced_rate = (!forces.is_none()).then_some(rate);
        let entry = Entry::unobserved(body, forces, (0.0, None), forced_rate, direction * first);
        let entry = Entry { deviation, ..entry };
        load(&mut self.group, lane, self.kernel, assignment, &entry);
        self.steps.direction.0[lane] = direction;
        self.steps.trial.0[lane] = direction * first;
        self.steps.again.0[lane] = 0.0;
        self.steps.inverse_rate.0[lane] = if rate > 0.0 { 1.0 / rate } else { 0.0 };
        for row in self.steps.begin.iter_mut().chain(&mut self.steps.now) {
            row.0[lane] = 0.0;
        }
        self.knots[lane] = f64::INFINITY;
        self.counted_at[lane] = f64::NAN;
        self.begin_interval(lane, index, 0.0, backward);
        rate
    }

    /// Applies the forces on a body from a time on, to its next knot.
    fn begin_interval(&mut self, lane: usize, index: usize, time: f64, backward: bool) {
        let forces = self.request.forces_of(index);
        if !forces.is_none() || self.request.record.is_sensitivity() {
            self.forces_rows.set(lane, &self.request.interval_of(index, time, backward));
            self.forces_rows.functions.set(lane, forces.function_from(time));
        }
        if forces.is_none() {
            return;
        }
        reset_time(&mut self.group, self.kernel.kernel().system, lane);
        let never = if backward { f64::NEG_INFINITY } else { f64::INFINITY };
        self.knots[lane] = forces.table.next_knot(time, backward).unwrap_or(never);
        self.steps.end.0[lane] = self.knots[lane];
    }

    /// Advances all lanes until one reaches its next time, in so many rounds at most.
    pub(super) fn advance(&mut self, most: usize) {
        self.kernel.advance_adaptive(&mut self.group, &self.forces_rows, &mut self.steps, most);
    }

    /// The steps that a lane has made since the last call. A lane whose steps no longer change its time has a time that is
    /// not a number, as if its state had overflowed: its rates grow without bound towards that time.
    pub(super) fn made(&mut self, lane: usize) -> u64 {
        let steps = std::mem::take(&mut self.group.count.0[lane]) as u64;
        let now = self.steps.now[0].0[lane];
        if steps > 0 && now == self.counted_at[lane] {
            self.steps.now[0].0[lane] = f64::NAN;
        }
        self.counted_at[lane] = now;
        steps
    }

    /// Applies the forces from a knot on, if a lane has reached one. Whether it has.
    pub(super) fn pass_knot(&mut self, lane: usize, index: usize, backward: bool) -> bool {
        // Steps end at a knot but for rounding; one more, too short to have a length, would be made.
        let knot = self.knots[lane];
        let short = (knot - self.steps.now[0].0[lane]) * self.steps.direction.0[lane];
        let reached = knot.is_finite() && short <= 4.0 * f64::EPSILON * knot.abs();
        if reached {
            self.begin_interval(lane, index, knot, backward);
        }
        reached
    }

    /// Stops all lanes when a lane is at a time, or at its next knot, within rounding. Under a function a step ends there.
    pub(super) fn aim(&mut self, lane: usize, time: f64, backward: bool) {
        let (knot, margin) = (self.knots[lane], 4.0 * f64::EPSILON * self.knots[lane].abs());
        self.steps.next.0[lane] = match backward {
            _ if knot.is_infinite() => time,
            false => time.min(knot - margin),
            true => time.max(knot + margin),
        };
        if self.forces_rows.functions.act_on(lane) {
            self.steps.end.0[lane] = if backward { time.max(knot) } else { time.min(knot) };
        }
    }

    /// Tells how many bodies are done, of those that have entered, from the lanes that are active and the indices of their
    /// bodies.
    ///
    /// # Errors
    /// If the work is to stop.
    pub(super) fn tell<T>(
        &mut self,
        tasks: &[Option<T>; LANES],
        index: impl Fn(&T) -> usize,
    ) -> Result<(), Error> {
        let left = tasks.iter().zip(&self.steps.now[0].0).filter_map(|(task, now)| {
            let [first, last] = self.request.range_of(index(task.as_ref()?));
            Some(1.0 - (now.abs() / (last - first)).min(1.0))
        });
        let done = self.entered as f64 - left.sum::<f64>();
        self.stop.tell(done - self.told);
        self.told = self.told.max(done);
        if self.stop.is_wanted() { Err(Error::Stopped) } else { Ok(()) }
    }

    /// Makes a lane inactive.
    pub(super) fn leave(&mut self, lane: usize) {
        self.group.deactivate(lane);
        self.steps.next.0[lane] = f64::INFINITY;
        self.steps.end.0[lane] = f64::INFINITY;
        self.steps.direction.0[lane] = 1.0;
        self.steps.trial.0[lane] = 0.0;
        for row in &mut self.steps.now {
            row.0[lane] = 0.0;
        }
    }
}
