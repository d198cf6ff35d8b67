//! States by steps of a method.

use super::legs::LegGroup;
use super::{
    Integration, Request, StatesPart, blocks, invariants_at_start, kinds_in, over_blocks_of, steps_of_legs,
};
use crate::call::Call;
use crate::error::Error;
use crate::kernel::{Compiled, Entry, Group, Job, drive, load, unload};
use crate::memory;
use crate::method::Method;
use crate::observe::{Deviation, Observed};
use crate::simd::LANES;
use crate::status::Status;

/// Largest number of steps between two checks of the stop flag: a tenth of a second
/// of the most expensive steps on the slowest path.
const STEPS_BETWEEN_STOPS: u64 = 1 << 9;

/// Runs the request.
pub fn simulate(request: &Request, method: &Method, states: StatesPart, call: Call) -> Result<u64, Error> {
    let count = request.bodies.len();
    let integrations = Integration::of_block(request, method, 0..count)?;
    let steps =
        memory::collected("steps of the bodies", count, (0..count).map(|b| steps_of_legs(request, b)))?;
    let kind = |index: usize| integrations[index].kind();
    let Call { isa, threads, stop } = call;
    let blocks = blocks(count, threads, |index| (kind(index), steps[index]))?;
    // The bits of a body do not depend on the others of its group.
    over_blocks_of(request, &blocks, states, call, |block, mut states| {
        states.forget();
        let mut lanes = Group::inactive();
        for mut members in kinds_in(block.clone(), kind)? {
            // A group makes the steps of the body that needs most.
            members.sort_unstable_by_key(|&member| steps[block.start + member]);
            for group in members.chunks(LANES) {
                let own = &integrations[block.clone()];
                let compiled = Compiled::new(own[group[0]].kernel(request, Observed::Nothing), isa);
                let legs = LegGroup::new(request, own, block.start, group, compiled, (&mut lanes, 1), stop)?;
                FixedJob { legs, states: &mut states, last: [[0.0; 4]; LANES] }.run()?;
            }
        }
        Ok(())
    })
}

/// The states of the bodies of one group.
struct FixedJob<'a, 'b> {
    legs: LegGroup<'a>,
    states: &'a mut StatesPart<'b>,
    /// The attitude of each lane at its last recorded state.
    last: [[f64; 4]; LANES],
}

/// A body in motion.
struct Moving {
    /// Whether it has made a step.
    moved: bool,
}

impl FixedJob<'_, '_> {
    fn run(mut self) -> Result<(), Error> {
        for (&member, &steps) in self.legs.members.iter().zip(&self.legs.steps) {
            let Some(steps) = steps else {
                self.states.status[member] = Status::StepLimit;
                continue;
            };
            self.states.steps[member] = steps;
            for drift in self.states.drifts() {
                drift[member] = 0.0;
            }
        }
        for backward in [false, true] {
            if self.legs.begin(backward)? {
                drive(&mut self)?;
            }
        }
        self.forget_unknown_drifts();
        Ok(())
    }

    /// On an orbit no component of the momentum is constant; the Jacobi integral is on a circle.
    fn forget_unknown_drifts(&mut self) {
        for (lane, &member) in self.legs.members.iter().enumerate() {
            let Some(place) = self.legs.place(lane) else { continue };
            let [energy, momentum, _] = self.states.drifts();
            momentum[member] = f64::NAN;
            if !place.is_on_circle() {
                energy[member] = f64::NAN;
            }
        }
    }

    /// Writes the state of a lane and updates the drifts.
    fn record(&mut self, lane: usize, state: usize, moved: bool) {
        let legs = &self.legs;
        let (request, member) = (legs.request, legs.members[lane]);
        let mut now = unload(legs.lanes, lane, legs.compiled, legs.integration(lane).assignment);
        let place = legs.place(lane);
        if let Some(place) = &place {
            now = now.at(place, legs.body(lane));
            now.direction = now.direction.filter(|_| self.states.records_vertical());
        }
        if !moved {
            // Through the momenta and back, the rates would return rounded.
            now.omega = legs.body(lane).omega;
            now.attitude = now
                .attitude
                .map(|integrated| if place.is_some() { legs.body(lane).attitude } else { integrated });
            now.tangent = now.tangent.map(|_| request.record.deviation_of(legs.index(lane)));
        }
        let at = member * request.schedule.len() + state;
        self.states.record(member, at, &now, (invariants_at_start(legs.lanes, lane), &mut self.last[lane]));
    }
}

impl Job for FixedJob<'_, '_> {
    type Task = Moving;

    fn load(&mut self, lane: usize) -> Result<Option<Moving>, Error> {
        let legs = &mut self.legs;
        if legs.waiting.next().is_none() {
            return Ok(None);
        }
        let (body, index) = (legs.body(lane), legs.index(lane));
        self.last[lane] = body.attitude;
        let deviation = Deviation::new(legs.request.record.deviation_of(index));
        let forces = legs.request.forces_of(index);
        let entry = Entry::unobserved(body, forces, (0.0, legs.place(lane)), legs.forced_rate(lane), 0.0);
        let entry = Entry { deviation, ..entry };
        let assignment = legs.integration(lane).assignment;
        load(legs.lanes, lane, legs.compiled, assignment, &entry);
        Ok(Some(Moving { moved: false }))
    }

    /// Advances every lane by its leg; finished lanes are inactive, with a step of 0.
    fn advance(&mut self, _: &[Option<Moving>; LANES]) -> Result<(), Error> {
        let legs = &mut self.legs;
        legs.begin_legs();
        let mut lanes: [usize; LANES] = std::array::from_fn(|lane| lane);
        let lanes = &mut lanes[..legs.members.len()];
        lanes.sort_unstable_by_key(|&lane| legs.legs[lane].steps);
        legs.set_steps(0);
        legs.compiled.process(legs.lanes, false);
        let (mut done, mut at_rest) = (0, 0);
        for (i, &lane) in lanes.iter().enumerate() {
            let end = legs.legs[lane].steps;
            if end == done {
                continue;
            }
            for &finished in &lanes[at_rest..i] {
                legs.lanes.step.0[finished] = 0.0;
            }
            at_rest = i;
            while done < end {
                if legs.stop.is_wanted() {
                    return Err(Error::Stopped);
                }
                let count = (end - done).min(STEPS_BETWEEN_STOPS);
                legs.advance(count);
                done += count;
                let share = |&lane: &usize| legs.steps[lane].map_or(0.0, |all| count as f64 / all as f64);
                legs.stop.tell(lanes[i..].iter().map(share).sum());
            }
        }
        // All lanes of the leg, those that ended early too.
        legs.set_steps(0);
        legs.compiled.process(legs.lanes, true);
        Ok(())
    }

    fn look(&mut self, lane: usize, task: &mut Moving) -> Result<bool, Error> {
        task.moved |= self.legs.legs[lane].steps > 0;
        if let Some(state) = self.legs.state(lane) {
            self.record(lane, state, task.moved);
        }
        Ok(!self.legs.is_over)
    }
}
