//! Closed forms of many bodies at once.

use super::{EvaluatorKind, Exit, Free, Lagrange, Motion, Symmetric};
use crate::body::Body;
use crate::real::Pack;
use crate::simd::{Arr, Isa, LANES, Row, Work, load_rows, set_lane, store_rows};

/// Bodies at their start, one in each lane, in the variables of their closed form.
#[derive(Clone, Copy)]
pub struct StartRows {
    /// The lanes that are evaluated, from the first on.
    lanes: usize,
    moments: [Row; 3],
    weight: [Row; 3],
    omega: [Row; 3],
    attitude: [Row; 4],
}

impl StartRows {
    /// One body in all lanes.
    #[inline]
    pub fn filled(body: &Body) -> StartRows {
        StartRows {
            lanes: LANES,
            moments: body.moments.map(|x| Row([x; LANES])),
            weight: body.weight.map(|x| Row([x; LANES])),
            omega: body.omega.map(|x| Row([x; LANES])),
            attitude: body.attitude.map(|x| Row([x; LANES])),
        }
    }

    /// Only the first lanes, and those that share a register with them, are evaluated.
    pub fn keep(&mut self, lanes: usize) {
        self.lanes = lanes;
    }

    /// Puts a body into a lane.
    #[inline]
    pub fn set(&mut self, lane: usize, body: &Body) {
        set_lane(&mut self.moments, lane, &body.moments);
        set_lane(&mut self.weight, lane, &body.weight);
        set_lane(&mut self.omega, lane, &body.omega);
        set_lane(&mut self.attitude, lane, &body.attitude);
    }
}

/// The states of all lanes at one time each.
#[derive(Clone, Copy)]
pub struct StateRows {
    /// Rates.
    pub omega: [Row; 3],
    /// Unit quaternions; unchanged if only rates were requested.
    pub attitude: [Row; 4],
}

impl StateRows {
    /// Zeros.
    pub const ZERO: StateRows = StateRows { omega: [Row([0.0; LANES]); 3], attitude: [Row([0.0; LANES]); 4] };
}

/// The boundary of the stable motion of each lane; see `Exit`.
#[derive(Clone, Copy)]
pub struct ExitRows {
    /// Observed component.
    pub axis: Row,
    /// Limit.
    pub limit: [Row; 2],
    /// Direction.
    pub direction: Row,
}

/// The motion of the lanes from `at` on.
#[inline(always)]
fn motion<P: Pack, M: Motion<P>>(starts: &StartRows, at: usize) -> M {
    M::new(
        &load_rows(&starts.moments, at),
        &load_rows(&starts.weight, at),
        &load_rows(&starts.omega, at),
        &load_rows(&starts.attitude, at),
    )
}

/// Sets up the motion of each lane, then evaluates it at each row of times: the rates, and on request the attitude.
#[inline(always)]
fn states<P: Pack, M: Motion<P>>(starts: &StartRows, times: &[Row], attitude: bool, out: &mut [StateRows]) {
    let out = &mut out[..times.len()];
    for at in (0..starts.lanes).step_by(P::LANES) {
        let motion: M = motion(starts, at);
        for k in 0..times.len() {
            let t = P::load(&times[k].0[at..]);
            if M::RATES_ALONE && !attitude {
                store_rows(&motion.rates(t), &mut out[k].omega, at);
                continue;
            }
            let (omega, q) = motion.state(t);
            store_rows(&omega, &mut out[k].omega, at);
            if attitude {
                store_rows(&q, &mut out[k].attitude, at);
            }
        }
    }
}

/// The exit time of each lane. The compiler removes most of the set-up, which is not needed here.
#[inline(always)]
fn exits<P: Pack, M: Motion<P>>(starts: &StartRows, questions: &ExitRows, out: &mut Row) {
    for at in (0..LANES).step_by(P::LANES) {
        let motion: M = motion(starts, at);
        let question = Exit {
            axis: P::load(&questions.axis.0[at..]),
            limit: load_rows(&questions.limit, at),
            direction: P::load(&questions.direction.0[at..]),
        };
        motion.exit(&question).store(&mut out.0[at..]);
    }
}

/// The states of all lanes, for packs of any width.
struct States<'a> {
    kind: EvaluatorKind,
    starts: &'a StartRows,
    times: &'a [Row],
    attitude: bool,
    out: &'a mut [StateRows],
}

impl Work for States<'_> {
    type Out = ();
    #[inline(always)]
    fn run<P: Pack>(self) {
        let States { kind, starts, times, attitude, out } = self;
        match kind {
            EvaluatorKind::Symmetric => states::<P, Symmetric<P>>(starts, times, attitude, out),
            // Two packs in flight hide the latency of its square roots (benches/README.md).
            EvaluatorKind::Free => states::<Arr<P, 2>, Free<Arr<P, 2>>>(starts, times, attitude, out),
            EvaluatorKind::Lagrange => states::<P, Lagrange<P>>(starts, times, attitude, out),
        }
    }
}

/// The exit times of all lanes.
struct Exits<'a> {
    kind: EvaluatorKind,
    starts: &'a StartRows,
    questions: &'a ExitRows,
    out: &'a mut Row,
}

impl Work for Exits<'_> {
    type Out = ();
    #[inline(always)]
    fn run<P: Pack>(self) {
        let Exits { kind, starts, questions, out } = self;
        match kind {
            EvaluatorKind::Symmetric => exits::<P, Symmetric<P>>(starts, questions, out),
            EvaluatorKind::Free => exits::<Arr<P, 2>, Free<Arr<P, 2>>>(starts, questions, out),
            EvaluatorKind::Lagrange => exits::<P, Lagrange<P>>(starts, questions, out),
        }
    }
}

/// The closed form of a kind, compiled for each instruction set.
#[derive(Clone, Copy)]
pub struct Evaluator {
    kind: EvaluatorKind,
    isa: Isa,
}

impl Evaluator {
    /// The evaluator for that instruction set. Its calls panic if the CPU lacks it.
    pub fn new(kind: EvaluatorKind, isa: Isa) -> Evaluator {
        Evaluator { kind, isa }
    }

    /// The rates of all lanes at each row of times.
    pub fn rates(self, starts: &StartRows, times: &[Row], out: &mut [StateRows]) {
        self.isa.call(States { kind: self.kind, starts, times, attitude: false, out });
    }

    /// The states of all lanes at each row of times.
    pub fn states(self, starts: &StartRows, times: &[Row], out: &mut [StateRows]) {
        self.isa.call(States { kind: self.kind, starts, times, attitude: true, out });
    }

    /// The exit times of the lanes.
    pub fn exits(self, starts: &StartRows, questions: &ExitRows, out: &mut Row) {
        self.isa.call(Exits { kind: self.kind, starts, questions, out });
    }
}
