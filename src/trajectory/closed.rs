//! States in closed form: many bodies side by side, or many times of one.

use super::states::{norm, worse};
use super::{Record, Request, States};
use crate::exact::{CanonicalForm, Evaluator, StartRows, StateRows};
use crate::parallel::over_blocks;
use crate::scene::Scene;
use crate::simd::{Isa, LANES, Row};
use crate::start::Body;
use crate::status::Status;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

/// Rows of times evaluated between two looks at the stop flag.
const ROWS_BETWEEN_STOPS: usize = 256;

/// Runs the request; `None` if it was stopped.
pub fn simulate(
    request: &Request,
    times: &[f64],
    forms: &[CanonicalForm],
    threads: usize,
    isa: Isa,
    stop: &AtomicBool,
) -> Option<States> {
    let groups = groups(forms);
    let parts = over_blocks(groups.len(), threads, stop, |g| {
        let group = groups[g].clone();
        let known = request.bodies[group.clone()].iter().map(|b| Invariants::new(b, request.scene)).collect();
        let batch = ClosedFormBatch { request, times, forms: &forms[group.clone()], group, isa, known };
        States::timed(|| batch.run(stop))
    });
    let mut all = States::with_capacity(request);
    for part in parts {
        all.append(part??);
    }
    Some(all)
}

/// Runs of neighbours with the same kind of closed form.
fn groups(forms: &[CanonicalForm]) -> Vec<Range<usize>> {
    let mut groups = Vec::with_capacity(forms.len().div_ceil(LANES));
    let mut first = 0;
    for run in forms.chunk_by(|a, b| a.kind() == b.kind()) {
        let end = first + run.len();
        groups.extend((first..end).step_by(LANES).map(|begin| begin..end.min(begin + LANES)));
        first = end;
    }
    groups
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
    fn run(&self, stop: &AtomicBool) -> Option<States> {
        let evaluator = Evaluator::new(self.forms[0].kind(), self.isa);
        let canonical = |index: usize| self.forms[index].to_canonical(self.body(index));
        let mut states = States::unknown(self.request, self.forms.len());
        for drift in [&mut states.energy_drift, &mut states.momentum_drift, &mut states.unit_drift] {
            drift.fill(0.0);
        }
        let mut out = vec![StateRows::ZERO; ROWS_BETWEEN_STOPS.min(self.times.len())];
        let evaluate = |starts: &StartRows, rows: &[Row], out: &mut [StateRows]| {
            if self.with_attitude() {
                evaluator.states(starts, rows, out);
            } else {
                evaluator.rates(starts, rows, out);
            }
        };
        // One body a lane, or one time a lane: the choice that leaves fewer lanes empty changes no bit.
        if self.times.len() <= self.forms.len() * self.times.len().div_ceil(LANES) {
            let mut starts = StartRows::filled(&canonical(0));
            for lane in 1..self.forms.len() {
                starts.set(lane, &canonical(lane));
            }
            let rows: Vec<Row> = self.times.iter().map(|&t| Row([t; LANES])).collect();
            for (first, rows) in rows.chunks(ROWS_BETWEEN_STOPS).enumerate() {
                if stop.load(Ordering::Relaxed) {
                    return None;
                }
                evaluate(&starts, rows, &mut out);
                for (k, state) in out[..rows.len()].iter().enumerate() {
                    for lane in 0..self.forms.len() {
                        self.record(&mut states, lane, first * ROWS_BETWEEN_STOPS + k, state, lane);
                    }
                }
            }
        } else {
            for body in 0..self.forms.len() {
                let starts = StartRows::filled(&canonical(body));
                for (first, times) in self.times.chunks(ROWS_BETWEEN_STOPS * LANES).enumerate() {
                    if stop.load(Ordering::Relaxed) {
                        return None;
                    }
                    let row = |part: &[f64]| {
                        let mut row = Row([part[0]; LANES]);
                        row.0[..part.len()].copy_from_slice(part);
                        row
                    };
                    let rows: Vec<Row> = times.chunks(LANES).map(row).collect();
                    evaluate(&starts, &rows, &mut out);
                    for k in 0..times.len() {
                        let time = first * ROWS_BETWEEN_STOPS * LANES + k;
                        self.record(&mut states, body, time, &out[k / LANES], k % LANES);
                    }
                }
            }
        }
        Some(states)
    }

    /// Writes the state of a body and updates its drifts.
    fn record(&self, states: &mut States, index: usize, time: usize, rows: &StateRows, lane: usize) {
        let body = self.body(index);
        let mut omega = [0, 1, 2].map(|k| rows.omega[k].0[lane]);
        let mut attitude = [0, 1, 2, 3].map(|k| rows.attitude[k].0[lane]);
        (omega, attitude) = self.forms[index].to_body(body, omega, attitude);
        if self.times[time] == 0.0 {
            // The change of variables and back would round the start.
            (omega, attitude) = (body.omega, body.attitude);
        }
        let at = index * self.times.len() + time;
        states.omega[3 * at..][..3].copy_from_slice(&omega);
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
