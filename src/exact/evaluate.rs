//! Closed forms of many bodies at once.

use super::{Evaluator, Exit, Free, Lagrange, Motion, Symmetric};
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
    pub const ZERO: StateRows = StateRows { omega: [Row::ZERO; 3], attitude: [Row::ZERO; 4] };
}

impl Exit<Row> {
    /// Zeros.
    pub const ZERO: Exit<Row> = Exit { axis: Row::ZERO, limit: [Row::ZERO; 2], direction: Row::ZERO };

    /// Sets the boundary of the body in a lane.
    #[inline]
    pub fn set(&mut self, lane: usize, Exit { axis, limit, direction }: Exit<f64>) {
        self.axis.0[lane] = axis;
        set_lane(&mut self.limit, lane, &limit);
        self.direction.0[lane] = direction;
    }
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
fn exits<P: Pack, M: Motion<P>>(starts: &StartRows, questions: &Exit<Row>, out: &mut Row) {
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
    by: Evaluator,
    starts: &'a StartRows,
    times: &'a [Row],
    attitude: bool,
    out: &'a mut [StateRows],
}

impl Work for States<'_> {
    type Out = ();
    #[inline(always)]
    fn run<P: Pack>(self) {
        let States { by, starts, times, attitude, out } = self;
        match by {
            Evaluator::Symmetric => states::<P, Symmetric<P>>(starts, times, attitude, out),
            // Two packs in flight hide the latency of its square roots (benches/README.md).
            Evaluator::Free => states::<Arr<P, 2>, Free<Arr<P, 2>>>(starts, times, attitude, out),
            Evaluator::Lagrange => states::<P, Lagrange<P>>(starts, times, attitude, out),
        }
    }
}

/// The exit times of all lanes.
struct Exits<'a> {
    by: Evaluator,
    starts: &'a StartRows,
    questions: &'a Exit<Row>,
    out: &'a mut Row,
}

impl Work for Exits<'_> {
    type Out = ();
    #[inline(always)]
    fn run<P: Pack>(self) {
        let Exits { by, starts, questions, out } = self;
        match by {
            Evaluator::Symmetric => exits::<P, Symmetric<P>>(starts, questions, out),
            Evaluator::Free => exits::<Arr<P, 2>, Free<Arr<P, 2>>>(starts, questions, out),
            Evaluator::Lagrange => exits::<P, Lagrange<P>>(starts, questions, out),
        }
    }
}

/// Each is compiled for each instruction set, and panics if the CPU lacks that one.
impl Evaluator {
    /// The rates of all lanes at each row of times.
    pub fn rates(self, isa: Isa, starts: &StartRows, times: &[Row], out: &mut [StateRows]) {
        isa.call(States { by: self, starts, times, attitude: false, out });
    }

    /// The states of all lanes at each row of times.
    pub fn states(self, isa: Isa, starts: &StartRows, times: &[Row], out: &mut [StateRows]) {
        isa.call(States { by: self, starts, times, attitude: true, out });
    }

    /// The exit times of the lanes.
    pub fn exits(self, isa: Isa, starts: &StartRows, questions: &Exit<Row>, out: &mut Row) {
        isa.call(Exits { by: self, starts, questions, out });
    }
}
