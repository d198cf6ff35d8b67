//! States in closed form: many bodies side by side, or many times of one.

use super::states::{StatesPart, norm, worse};
use super::{Record, Request, States, groups, over_groups};
use crate::error::Error;
use crate::exact::{CanonicalForm, Evaluator, StartRows, StateRows};
use crate::memory;
use crate::scene::Scene;
use crate::simd::{Isa, LANES, Row};
use crate::start::Body;
use crate::status::Status;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

/// Rows of times evaluated between two looks at the stop flag.
const ROWS_BETWEEN_STOPS: usize = 256;

/// Runs the request.
pub fn simulate(
    request: &Request,
    times: &[f64],
    forms: &[CanonicalForm],
    threads: usize,
    isa: Isa,
    stop: &AtomicBool,
) -> Result<States, Error> {
    let groups = groups(forms, LANES, |a, b| a.kind() == b.kind())?;
    over_groups(request, &groups, threads, stop, |group, states| {
        let bodies = request.bodies[group.clone()].iter();
        let known = bodies.map(|body| Invariants::new(body, request.scene));
        let known = memory::collected("invariants of a group", group.len(), known)?;
        let forms = &forms[group.clone()];
        ClosedFormBatch { request, times, forms, group, isa, known }.run(states, stop)?;
        Ok(0)
    })
}

/// The bodies of one group.
struct ClosedFormBatch<'a> {
    request: &'a Request<'a>,
    times: &'a [f64],
    forms: &'a [CanonicalForm],
    group: Range<usize>,
    isa: Isa,
    /// The invariants of each body.
    known: Vec<Invariants>,
}

impl ClosedFormBatch<'_> {
    fn run(&self, mut states: StatesPart, stop: &AtomicBool) -> Result<(), Error> {
        let evaluator = Evaluator::new(self.forms[0].kind(), self.isa);
        let canonical = |index: usize| self.forms[index].to_canonical(self.body(index));
        for drift in states.drifts() {
            drift.fill(0.0);
        }
        let [length, times] = [self.forms.len(), self.times.len()];
        let room = ROWS_BETWEEN_STOPS.min(times);
        let mut out = memory::filled("states of a group", room, StateRows::ZERO)?;
        let mut rows = memory::reserved("times of a group", room)?;
        let evaluate = |starts: &StartRows, rows: &[Row], out: &mut [StateRows]| {
            if self.with_attitude() {
                evaluator.states(starts, rows, out);
            } else {
                evaluator.rates(starts, rows, out);
            }
        };
        // One body a lane, or one time a lane: the choice that leaves fewer lanes empty changes no bit.
        if times <= length * times.div_ceil(LANES) {
            let mut starts = StartRows::filled(&canonical(0));
            for lane in 1..length {
                starts.set(lane, &canonical(lane));
            }
            for (first, times) in self.times.chunks(ROWS_BETWEEN_STOPS).enumerate() {
                if stop.load(Ordering::Relaxed) {
                    return Err(Error::Stopped);
                }
                rows.clear();
                rows.extend(times.iter().map(|&t| Row([t; LANES])));
                evaluate(&starts, &rows, &mut out);
                for (k, state) in out[..rows.len()].iter().enumerate() {
                    for lane in 0..length {
                        self.record(&mut states, lane, first * ROWS_BETWEEN_STOPS + k, state, lane);
                    }
                }
            }
        } else {
            for body in 0..length {
                let starts = StartRows::filled(&canonical(body));
                for (first, times) in self.times.chunks(ROWS_BETWEEN_STOPS * LANES).enumerate() {
                    if stop.load(Ordering::Relaxed) {
                        return Err(Error::Stopped);
                    }
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
                        self.record(&mut states, body, time, &out[k / LANES], k % LANES);
                    }
                }
            }
        }
        Ok(())
    }

    /// Writes the state of a body and updates its drifts.
    fn record(&self, states: &mut StatesPart, index: usize, time: usize, rows: &StateRows, lane: usize) {
        let body = self.body(index);
        let mut omega = [0, 1, 2].map(|k| rows.omega[k].0[lane]);
        let mut attitude = [0, 1, 2, 3].map(|k| rows.attitude[k].0[lane]);
        (omega, attitude) = self.forms[index].to_body(body, omega, attitude);
        if self.times[time] == 0.0 {
            // The change of variables and back would round the start.
            (omega, attitude) = (body.omega, body.attitude);
        }
        let at = index * self.times.len() + time;
        if let Some(column) = &mut states.omega {
            column[3 * at..][..3].copy_from_slice(&omega);
        }
        let mut vertical = [0.0; 3];
        if self.with_attitude() {
            vertical = vertical_of(attitude);
            if let Some(column) = &mut states.vertical {
                column[3 * at..][..3].copy_from_slice(&vertical);
            }
            if let Some(column) = &mut states.attitude {
                column[4 * at..][..4].copy_from_slice(&attitude);
            }
            states.unit_drift[index] = worse(states.unit_drift[index], (norm(&attitude) - 1.0).abs());
        }
        let now = invariants(body, self.request.scene, omega, vertical);
        let Invariants { start, inverse_scale } = self.known[index];
        let drift = [0, 1].map(|k| (now[k] - start[k]).abs() * inverse_scale[k]);
        states.energy_drift[index] = worse(states.energy_drift[index], drift[0]);
        states.momentum_drift[index] = worse(states.momentum_drift[index], drift[1]);
        if !omega.iter().chain(&attitude).all(|x| x.is_finite()) {
            states.status[index] = Status::NotFinite;
        }
    }

    fn body(&self, index: usize) -> &Body {
        &self.request.bodies[self.group.start + index]
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
        let start = invariants(body, scene, body.omega, vertical_of(body.attitude));
        let moves = body.omega.iter().chain(&body.weight).any(|&x| x != 0.0);
        // Of a body that cannot move nothing can drift.
        let inverse = |scale: f64| if moves { 1.0 / scale } else { 0.0 };
        Invariants { start, inverse_scale: (scene.invariant_scales)(body).map(inverse) }
    }
}

/// Energy and conserved momentum.
fn invariants(body: &Body, scene: &Scene, omega: [f64; 3], vertical: [f64; 3]) -> [f64; 2] {
    let momentum = [0, 1, 2].map(|k| body.moments[k] * omega[k]);
    let energy = 0.5 * plain_dot(momentum, omega) + plain_dot(body.weight, vertical);
    [energy, plain_dot(momentum, scene.conserved.factor(momentum, vertical))]
}

/// a . b. Without `fma`, which costs a call outside the kernels.
fn plain_dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The vertical seen from the body.
fn vertical_of([w, x, y, z]: [f64; 4]) -> [f64; 3] {
    [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)]
}
