//! Bodies side by side: one row of numbers for each variable, one lane for each body.

use crate::model::Drive;
use crate::real::Pack;
use std::sync::OnceLock;

/// Bodies in a group: four AVX-512 registers, so that each hides the latency of the others.
pub const LANES: usize = 32;

/// Longest state: rates, three directions, and the balance of work, impulse and time.
pub const MAX_STATE: usize = 15;

/// One number for each body of a group.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub struct Row(pub [f64; LANES]);

impl Row {
    pub(crate) const ZERO: Row = Row([0.0; LANES]);
}

/// The invariants at the start and the largest deviation from them seen at the ends of bursts.
#[derive(Clone, Copy)]
pub struct DriftRows {
    /// Value at the start.
    pub start: Row,
    /// One over the scale that the deviation is measured in.
    pub inverse_scale: Row,
    /// Largest deviation.
    pub worst: Row,
}

/// The bodies in flight and all that is known of them.
#[derive(Clone)]
pub struct Group {
    /// Rates or momenta, directions, quaternion.
    pub state: [Row; MAX_STATE],
    /// What the state has lost to rounding, of schemes that carry it on.
    pub carry: [Row; MAX_STATE],
    /// Principal moments.
    pub moments: [Row; 3],
    /// `mgl com`.
    pub weight: [Row; 3],
    /// Time step; 0 makes a lane wait.
    pub step: Row,
    /// Steps made.
    pub count: Row,
    /// See `Watched`.
    pub axis: [Row; 3],
    /// See `Watched`.
    pub side: Row,
    /// See `Watched`.
    pub flips: Row,
    /// See `Watched`.
    pub left: Row,
    /// See `Watched`.
    pub cosine: Row,
    /// See `Watched`.
    pub sine2: Row,
    /// See `Watched`.
    pub limit: [Row; 2],
    /// Energy.
    pub energy: DriftRows,
    /// `L.L` of a free body, `L.gamma` of a top.
    pub momentum: DriftRows,
    /// Largest deviation of the length of a direction from one.
    pub unit: Row,
}

/// What acts from outside on the bodies of a group: the numbers of `Drive`, in its order.
#[derive(Clone)]
pub struct Drives {
    /// Torque in the body, and its rate of change.
    pub body: [[Row; 3]; 2],
    /// The same of a torque in space.
    pub space: [[Row; 3]; 2],
    /// Damping.
    pub damping: [Row; 6],
    /// Its rates.
    pub rates: [Row; 3],
    /// Its modes.
    pub modes: [[Row; 3]; 3],
}

impl Drives {
    /// Nothing.
    pub const NONE: Drives = Drives {
        body: [[Row::ZERO; 3]; 2],
        space: [[Row::ZERO; 3]; 2],
        damping: [Row::ZERO; 6],
        rates: [Row::ZERO; 3],
        modes: [[Row::ZERO; 3]; 3],
    };

    /// What acts on the body in a lane from now on.
    pub fn set(&mut self, lane: usize, drive: &Drive<f64>) {
        for i in 0..2 {
            for k in 0..3 {
                self.body[i][k].0[lane] = drive.body[i][k];
                self.space[i][k].0[lane] = drive.space[i][k];
            }
        }
        for k in 0..6 {
            self.damping[k].0[lane] = drive.damping[k];
        }
        for k in 0..3 {
            self.rates[k].0[lane] = drive.rates[k];
            for m in 0..3 {
                self.modes[k][m].0[lane] = drive.modes[k][m];
            }
        }
    }

    /// The lanes of a pack.
    #[inline(always)]
    pub fn load<P: Pack>(&self, at: usize) -> Drive<P> {
        let mut drive = Drive::none();
        for i in 0..2 {
            for k in 0..3 {
                drive.body[i][k] = P::load(&self.body[i][k].0[at..]);
                drive.space[i][k] = P::load(&self.space[i][k].0[at..]);
            }
        }
        for k in 0..6 {
            drive.damping[k] = P::load(&self.damping[k].0[at..]);
        }
        for k in 0..3 {
            drive.rates[k] = P::load(&self.rates[k].0[at..]);
            for m in 0..3 {
                drive.modes[k][m] = P::load(&self.modes[k][m].0[at..]);
            }
        }
        drive
    }
}

impl Group {
    /// Lanes that wait.
    pub fn waiting() -> Group {
        static WAITING: OnceLock<Group> = OnceLock::new();
        WAITING.get_or_init(Group::all_waiting).clone()
    }

    fn all_waiting() -> Group {
        let drift = DriftRows { start: Row::ZERO, inverse_scale: Row::ZERO, worst: Row::ZERO };
        let mut group = Group {
            state: [Row::ZERO; MAX_STATE],
            carry: [Row::ZERO; MAX_STATE],
            moments: [Row([1.0; LANES]); 3],
            weight: [Row::ZERO; 3],
            step: Row::ZERO,
            count: Row::ZERO,
            axis: [Row::ZERO; 3],
            side: Row::ZERO,
            flips: Row::ZERO,
            left: Row::ZERO,
            cosine: Row::ZERO,
            sine2: Row::ZERO,
            limit: [Row::ZERO; 2],
            energy: drift,
            momentum: drift,
            unit: Row::ZERO,
        };
        for lane in 0..LANES {
            group.wait(lane);
        }
        group
    }

    /// Makes a lane wait: a unit sphere at rest, its watched axis where it started, and a step of 0.
    pub fn wait(&mut self, lane: usize) {
        for row in self.state.iter_mut().chain(&mut self.carry) {
            row.0[lane] = 0.0;
        }
        for direction in [3, 6] {
            self.state[direction].0[lane] = 1.0;
        }
        for k in 0..3 {
            self.moments[k].0[lane] = 1.0;
            self.weight[k].0[lane] = 0.0;
            self.axis[k].0[lane] = if k == 0 { 1.0 } else { 0.0 };
        }
        self.step.0[lane] = 0.0;
        self.side.0[lane] = 0.0;
        self.flips.0[lane] = 0.0;
        self.left.0[lane] = f64::INFINITY;
        self.cosine.0[lane] = 1.0;
        self.sine2.0[lane] = 0.0;
        self.limit[0].0[lane] = f64::NEG_INFINITY;
        self.limit[1].0[lane] = f64::INFINITY;
        self.unit.0[lane] = 0.0;
        for drift in [&mut self.energy, &mut self.momentum] {
            drift.start.0[lane] = 0.0;
            drift.inverse_scale.0[lane] = 0.0;
            drift.worst.0[lane] = 0.0;
        }
    }
}
