//! Bodies side by side: one row of numbers for each variable, one lane for each body.

use crate::error::Error;
use crate::forces::{ForcesInterval, Further, ParameterChange, TorqueRows};
use crate::observe::{MAX_ROWS, Rows, UNOBSERVED};
use crate::real::Pack;
use crate::simd::{LANES, Row, load_rows, set_lane};
use std::sync::OnceLock;

/// Longest state: rates, three directions, the balance of work, impulse and time, a deviation vector, and the variables
/// of further forces.
pub const MAX_STATE: usize = 15 + 6 + Further::VARIABLES;

/// The invariants at the start, and the largest deviation from them at the ends of blocks of steps.
#[derive(Clone, Copy)]
pub struct DriftRows {
    /// Value at the start.
    pub start: Row,
    /// One over the scale of the deviation.
    pub inverse_scale: Row,
    /// Largest deviation.
    pub worst: Row,
}

/// A deviation vector of each body, beside the one in its state: the numbers, and their rounding errors.
#[derive(Clone, Copy)]
pub struct DeviationRows {
    /// Change of the rates, and rotation vector.
    pub state: [Row; 6],
    /// Rounding error, for methods with compensation.
    pub compensation: [Row; 6],
}

impl DeviationRows {
    /// No deviation vector.
    pub const ZERO: DeviationRows = DeviationRows { state: [Row::ZERO; 6], compensation: [Row::ZERO; 6] };
}

/// The bodies that are integrated together, with their states and invariants.
#[derive(Clone)]
pub struct Group {
    /// Lanes up to the last that was loaded: the packs after them are not computed.
    pub(super) used: usize,
    /// Rates or momenta, directions, quaternion, balance, deviation vector.
    pub state: [Row; MAX_STATE],
    /// Rounding error of the state, for methods with compensation.
    pub compensation: [Row; MAX_STATE],
    /// Principal moments.
    pub moments: [Row; 3],
    /// `mgl com`.
    pub weight: [Row; 3],
    /// Time step; 0 for an inactive lane.
    pub step: Row,
    /// Steps made.
    pub count: Row,
    /// The rows of the observable of the kernel.
    pub observed: [Row; MAX_ROWS],
    /// Energy.
    pub energy: DriftRows,
    /// `L.L` of a free body, `L.gamma` of a top.
    pub momentum: DriftRows,
    /// Largest deviation of the length of a direction or quaternion from one.
    pub unit: Row,
    /// Further deviation vectors of all bodies, for a kernel that moves them with one motion. A change of the
    /// parameters is that of the deviation vector in the state.
    pub further: Vec<DeviationRows>,
}

/// The forces on the bodies of a group on an interval.
#[derive(Clone)]
pub struct ForcesRows<'a> {
    /// The numbers, a row of each.
    pub numbers: ForcesInterval<'static, Row>,
    /// The functions that return a torque.
    pub functions: TorqueRows<'a>,
}

impl<'a> ForcesRows<'a> {
    /// No forces.
    pub const NONE: ForcesRows<'a> =
        ForcesRows { numbers: ForcesInterval::filled(Row::ZERO), functions: TorqueRows::NONE };

    /// No forces, with room for so many numbers that a function is given for each body.
    ///
    /// # Errors
    /// If the numbers do not fit into memory.
    pub fn with_room(width: usize) -> Result<ForcesRows<'a>, Error> {
        Ok(ForcesRows { functions: TorqueRows::with_room(width)?, ..ForcesRows::NONE })
    }

    /// Sets the forces without functions on the body in a lane.
    pub fn set(&mut self, lane: usize, interval: &ForcesInterval<f64>) {
        let numbers = &mut self.numbers;
        for i in 0..2 {
            set_lane(&mut numbers.body[i], lane, &interval.body[i]);
            set_lane(&mut numbers.space[i], lane, &interval.space[i]);
        }
        set_lane(&mut numbers.damping, lane, &interval.damping);
        set_lane(&mut numbers.rates, lane, &interval.rates);
        for k in 0..3 {
            set_lane(&mut numbers.modes[k], lane, &interval.modes[k]);
        }
        numbers.further.set(lane, &interval.further);
        set_lane(&mut numbers.rotor_change, lane, &interval.rotor_change);
        for k in 0..4 {
            set_lane(&mut numbers.trajectory.0[k], lane, &interval.trajectory.0[k]);
        }
        let (rows, change) = (&mut numbers.change, &interval.change);
        set_lane(&mut rows.moments, lane, &change.moments);
        set_lane(&mut rows.weight, lane, &change.weight);
        set_lane(&mut rows.damping, lane, &change.damping);
        set_lane(&mut rows.torque, lane, &change.torque);
        rows.further.set(lane, &change.further);
    }

    /// The lanes of a pack.
    ///
    /// # Safety
    /// The functions of the interval are not called after the end of the borrow.
    #[inline(always)]
    pub unsafe fn load<P: Pack>(&self, at: usize) -> ForcesInterval<'static, P> {
        let (mut interval, numbers) = (ForcesInterval::none(), &self.numbers);
        for i in 0..2 {
            interval.body[i] = load_rows(&numbers.body[i], at);
            interval.space[i] = load_rows(&numbers.space[i], at);
        }
        interval.damping = load_rows(&numbers.damping, at);
        interval.rates = load_rows(&numbers.rates, at);
        for k in 0..3 {
            interval.modes[k] = load_rows(&numbers.modes[k], at);
        }
        interval.further = numbers.further.load(at);
        interval.rotor_change = load_rows(&numbers.rotor_change, at);
        for k in 0..4 {
            interval.trajectory.0[k] = load_rows(&numbers.trajectory.0[k], at);
        }
        interval.change = ParameterChange {
            moments: load_rows(&numbers.change.moments, at),
            weight: load_rows(&numbers.change.weight, at),
            damping: load_rows(&numbers.change.damping, at),
            torque: load_rows(&numbers.change.torque, at),
            further: numbers.change.further.load(at),
        };
        // SAFETY: the caller's promise.
        interval.functions = self.functions.of(at).map(|functions| unsafe { functions.outliving() });
        interval
    }
}

impl Group {
    /// Inactive lanes.
    pub fn inactive() -> Group {
        static INACTIVE: OnceLock<Group> = OnceLock::new();
        INACTIVE.get_or_init(Group::all_inactive).clone()
    }

    fn all_inactive() -> Group {
        let drift = DriftRows { start: Row::ZERO, inverse_scale: Row::ZERO, worst: Row::ZERO };
        let mut group = Group {
            used: 0,
            state: [Row::ZERO; MAX_STATE],
            compensation: [Row::ZERO; MAX_STATE],
            moments: [Row([1.0; LANES]); 3],
            weight: [Row::ZERO; 3],
            step: Row::ZERO,
            count: Row::ZERO,
            observed: [Row::ZERO; MAX_ROWS],
            energy: drift,
            momentum: drift,
            unit: Row::ZERO,
            further: Vec::new(),
        };
        for lane in 0..LANES {
            group.deactivate(lane);
        }
        group
    }

    /// Makes all lanes inactive.
    pub fn clear(&mut self) {
        if self.used > 0 {
            *self = Group::inactive();
        }
    }

    /// Whether only the first lane has been loaded.
    pub(super) fn is_of_one(&self) -> bool {
        self.used == 1
    }

    /// The numbers of the observable of a lane.
    pub fn observed_in(&self, lane: usize) -> Rows<f64> {
        self.observed.each_ref().map(|row| row.0[lane])
    }

    /// Sets the numbers of the observable of a lane.
    pub(super) fn set_observed(&mut self, lane: usize, rows: &Rows<f64>) {
        set_lane(&mut self.observed, lane, rows);
    }

    /// Makes a lane inactive: a unit sphere at rest that is not observed, and a step of 0.
    pub fn deactivate(&mut self, lane: usize) {
        for row in self.state.iter_mut().chain(&mut self.compensation) {
            row.0[lane] = 0.0;
        }
        for direction in [3, 6] {
            self.state[direction].0[lane] = 1.0;
        }
        for k in 0..3 {
            self.moments[k].0[lane] = 1.0;
            self.weight[k].0[lane] = 0.0;
        }
        self.step.0[lane] = 0.0;
        self.set_observed(lane, &UNOBSERVED);
        self.unit.0[lane] = 0.0;
        for drift in [&mut self.energy, &mut self.momentum] {
            drift.start.0[lane] = 0.0;
            drift.inverse_scale.0[lane] = 0.0;
            drift.worst.0[lane] = 0.0;
        }
    }
}
