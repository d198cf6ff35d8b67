//! States in closed form: many bodies side by side, or many times of one.

use super::{Record, Request, Schedule, StatesPart, kinds_in, neighbours, over_blocks_of, time_range};
use crate::body::Body;
use crate::call::Call;
use crate::error::Error;
use crate::exact::{CanonicalForm, Question, StartRows, StateRows};
use crate::forces::BodyForces;
use crate::kinematics::{length, plain_dot};
use crate::memory;
use crate::parallel::Interrupt;
use crate::real::larger;
use crate::scene::Scene;
use crate::simd::{Isa, LANES, Row};
use crate::status::Status;
use std::ops::Range;

/// Error of a closed form for each radian that a body turns.
pub const ROUNDING: f64 = 1e-15;

/// Rows of times evaluated between two looks at the stop flag.
const ROWS_BETWEEN_STOPS: usize = 256;

/// Bodies in a block, which one thread takes at a time.
const BLOCK: usize = 1024;

/// Runs the request.
pub fn simulate(request: &Request, states: StatesPart, call: Call) -> Result<u64, Error> {
    let blocks = neighbours(request.bodies.len(), BLOCK, |_| ())?;
    over_blocks_of(request, &blocks, states, call, |block, mut states| {
        for drift in states.drifts() {
            drift.fill(0.0);
        }
        let (forms, first) = (&forms_of(request, block.clone())?, block.start);
        let kinds = kinds_in(0..forms.len(), |index| forms[index].evaluator())?;
        for members in kinds.iter().flat_map(|kind| kind.chunks(LANES)) {
            let known = members.iter().map(|&k| Invariants::new(&request.bodies[first + k], request.scene));
            let known = memory::collected("invariants of a group", members.len(), known)?;
            let isa = call.isa;
            ClosedFormBatch { request, forms, first, members, isa, known }.run(&mut states, call.stop)?;
        }
        Ok(())
    })
}

/// The errors of free bodies in closed form over their times, from bounds of their rates: those of rounding. `None` if
/// one may lose its phase.
///
/// # Errors
/// If they do not fit into memory.
pub fn rounding_errors(schedule: &Schedule, rates: &[f64]) -> Result<Option<Vec<f64>>, Error> {
    let mut errors = memory::reserved("errors of the bodies", rates.len())?;
    for (body, &rate) in rates.iter().enumerate() {
        let [first, last] = schedule.times_of(body).map_or([0.0; 2], time_range);
        let angle = rate * (last - first);
        // Nor does a number that is none.
        if !(angle < 0.5 / ROUNDING) {
            return Ok(None);
        }
        errors.push(ROUNDING * (1.0 + angle));
    }
    Ok(Some(errors))
}

/// The closed forms of some bodies.
fn forms_of(request: &Request, block: Range<usize>) -> Result<Vec<CanonicalForm>, Error> {
    let mut forms = memory::reserved("closed forms of the bodies", block.len())?;
    for index in block {
        let form = CanonicalForm::of(&request.bodies[index]);
        forms.push(form.ok_or(Error::NoClosedForm { index, rule: Question::RULE_OF_STATES })?);
    }
    Ok(forms)
}

/// The bodies of one group.
struct ClosedFormBatch<'a> {
    request: &'a Request<'a>,
    /// The closed forms of the bodies of the block.
    forms: &'a [CanonicalForm],
    /// Index of the first body of the block.
    first: usize,
    /// Indices of the bodies of the group in the block.
    members: &'a [usize],
    isa: Isa,
    /// The invariants of each body.
    known: Vec<Invariants>,
}

impl ClosedFormBatch<'_> {
    fn run(&self, states: &mut StatesPart, stop: &Interrupt) -> Result<(), Error> {
        let evaluator = self.form(0).evaluator();
        let canonical = |index: usize| self.form(index).to_canonical(self.body(index));
        for (index, &member) in self.members.iter().enumerate() {
            states.fastest_rate[member] = self.body(index).fastest_rate(BodyForces::NONE, [0.0; 2]);
        }
        let [length, times] = [self.members.len(), self.request.schedule.len()];
        let room = ROWS_BETWEEN_STOPS.min(times);
        let mut out = memory::filled("states of a group", room, StateRows::ZERO)?;
        let mut rows = memory::reserved("times of a group", room)?;
        let evaluate = |starts: &StartRows, rows: &[Row], out: &mut [StateRows]| {
            if self.with_attitude() {
                evaluator.states(self.isa, starts, rows, out);
            } else {
                evaluator.rates(self.isa, starts, rows, out);
            }
        };
        // One body a lane, or one time a lane: the choice that leaves fewer lanes empty changes no bit.
        if times <= length * times.div_ceil(LANES) {
            let mut starts = StartRows::filled(&canonical(0));
            starts.keep(length);
            for lane in 1..length {
                starts.set(lane, &canonical(lane));
            }
            for first in (0..times).step_by(ROWS_BETWEEN_STOPS) {
                if stop.is_wanted() {
                    return Err(Error::Stopped);
                }
                stop.tell(length as f64 * room as f64 / times as f64);
                rows.clear();
                rows.extend((first..times.min(first + ROWS_BETWEEN_STOPS)).map(|time| self.row(time)));
                evaluate(&starts, &rows, &mut out);
                for (k, state) in out[..rows.len()].iter().enumerate() {
                    for lane in 0..length {
                        self.record(states, (lane, first + k, rows[k].0[lane]), state, lane);
                    }
                }
            }
        } else {
            for body in 0..length {
                let mut starts = StartRows::filled(&canonical(body));
                starts.keep(times.min(LANES));
                for (first, times) in self.times(body).chunks(ROWS_BETWEEN_STOPS * LANES).enumerate() {
                    if stop.is_wanted() {
                        return Err(Error::Stopped);
                    }
                    stop.tell(times.len() as f64 / self.times(body).len() as f64);
                    let row = |part: &[f64]| {
                        let mut row = Row([part[0]; LANES]);
                        row.0[..part.len()].copy_from_slice(part);
                        row
                    };
                    rows.clear();
                    rows.extend(times.chunks(LANES).map(row));
                    evaluate(&starts, &rows, &mut out);
                    for k in 0..times.len() {
                        let time = first * ROWS_BETWEEN_STOPS * LANES + k;
                        self.record(states, (body, time, times[k]), &out[k / LANES], k % LANES);
                    }
                }
            }
        }
        Ok(())
    }

    /// Output time number `time` of each body, one body a lane.
    fn row(&self, time: usize) -> Row {
        let mut row = Row([self.times(0)[time]; LANES]);
        if let Schedule::TimesOfEach(..) = self.request.schedule {
            for lane in 0..self.members.len() {
                row.0[lane] = self.times(lane)[time];
            }
        }
        row
    }

    /// Writes the state of a body at output time number `time`, which is `t`, and updates its drifts.
    fn record(
        &self,
        states: &mut StatesPart,
        (index, time, t): (usize, usize, f64),
        rows: &StateRows,
        lane: usize,
    ) {
        let body = self.body(index);
        let place = self.members[index];
        let mut omega = [0, 1, 2].map(|k| rows.omega[k].0[lane]);
        let mut attitude = [0, 1, 2, 3].map(|k| rows.attitude[k].0[lane]);
        (omega, attitude) = self.form(index).to_body(body, omega, attitude);
        if t == 0.0 {
            // The change of variables and back would round the start.
            (omega, attitude) = (body.omega, body.attitude);
        }
        let at = place * self.request.schedule.len() + time;
        if let Some(column) = &mut states.omega {
            column[3 * at..][..3].copy_from_slice(&omega);
        }
        let mut gamma = [0.0; 3];
        if self.with_attitude() {
            gamma = gamma_of(attitude);
            if let Some(column) = &mut states.gamma {
                column[3 * at..][..3].copy_from_slice(&gamma);
            }
            if let Some(column) = &mut states.attitude {
                column[4 * at..][..4].copy_from_slice(&attitude);
            }
            states.unit_drift[place] = larger(states.unit_drift[place], (length(&attitude) - 1.0).abs());
        }
        let now = invariants(body, self.request.scene, omega, gamma);
        let Invariants { start, inverse_scale } = self.known[index];
        let drift = [0, 1].map(|k| (now[k] - start[k]).abs() * inverse_scale[k]);
        states.energy_drift[place] = larger(states.energy_drift[place], drift[0]);
        states.momentum_drift[place] = larger(states.momentum_drift[place], drift[1]);
        if !omega.iter().chain(&attitude).all(|x| x.is_finite()) {
            states.status[place] = Status::NotFinite;
        }
    }

    fn body(&self, index: usize) -> &Body {
        &self.request.bodies[self.first + self.members[index]]
    }

    fn form(&self, index: usize) -> CanonicalForm {
        self.forms[self.members[index]]
    }

    fn times(&self, index: usize) -> &[f64] {
        let times = self.request.schedule.times_of(self.first + self.members[index]);
        times.expect("a closed form takes no steps")
    }

    /// Whether the attitude is evaluated: it is recorded, or the energy depends on the vertical.
    fn with_attitude(&self) -> bool {
        self.request.scene.has_weight || self.request.record != Record::Rates
    }
}

/// Energy and conserved momentum at the start, and one over the scales of their drifts.
#[derive(Clone, Copy)]
struct Invariants {
    start: [f64; 2],
    inverse_scale: [f64; 2],
}

impl Invariants {
    fn new(body: &Body, scene: &Scene) -> Self {
        let start = invariants(body, scene, body.omega, gamma_of(body.attitude));
        let moves = body.omega.iter().chain(&body.weight).any(|&x| x != 0.0);
        // Of a body that cannot move nothing can drift.
        let inverse = |scale: f64| if moves { 1.0 / scale } else { 0.0 };
        Invariants { start, inverse_scale: (scene.invariant_scales)(body).map(inverse) }
    }
}

/// Energy and conserved momentum.
fn invariants(body: &Body, scene: &Scene, omega: [f64; 3], gamma: [f64; 3]) -> [f64; 2] {
    let momentum = [0, 1, 2].map(|k| body.moments[k] * omega[k]);
    let energy = 0.5 * plain_dot(&momentum, &omega) + plain_dot(&body.weight, &gamma);
    [energy, plain_dot(&momentum, &scene.conserved.factor(momentum, gamma))]
}

/// The vertical seen from the body.
fn gamma_of([w, x, y, z]: [f64; 4]) -> [f64; 3] {
    [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_those_of_rounding_unless_a_body_loses_its_phase() {
        let times = Schedule::Times(&[-1.0, 3.0]);
        assert_eq!(rounding_errors(&times, &[0.0, 2.0]), Ok(Some(vec![1e-15, 1e-15 * (1.0 + 2.0 * 4.0)])));
        let each = Schedule::TimesOfEach(&[1.0, 2.0], 1);
        assert_eq!(rounding_errors(&each, &[1.0, 1.0]), Ok(Some(vec![2e-15, 1e-15 * 3.0])));
        for rate in [1e15, f64::INFINITY, f64::NAN] {
            assert_eq!(rounding_errors(&times, &[1.0, rate]), Ok(None));
        }
    }
}
