//! A torque that a function of the user returns, known by its address.

use super::PlaceOfRoot;
use super::body_rows::BodyRows;
use crate::error::{Error, refuse};
use crate::kinematics::{attitude_of_rows, dot, squared_length};
use crate::memory;
use crate::real::Real;
use crate::simd::{LANES, Row};
use std::ptr;

/// `void torque(double t, const double *omega, const double *attitude, const double *data, double *torque)`: from the
/// time, the rates in the body and the unit quaternion, scalar first, body to space, w >= 0, the torque in the body.
pub type Function = unsafe extern "C" fn(f64, *const f64, *const f64, *const f64, *mut f64);

/// The same for eight bodies side by side: the times, then by component the rates, attitudes and torques of all. The data
/// are in rows of `LANES`, of which the first eight numbers are read.
pub type FunctionOfEight = unsafe extern "C" fn(*const f64, *const f64, *const f64, *const f64, *mut f64);

/// A `Function` that is told more: after the torque the states of the body, their rates of change, which it writes, and
/// the place of the body on its orbit in space, over the semi-major axis or, of a table, over `gm^(1/3)`.
pub type LongFunction =
    unsafe extern "C" fn(f64, *const f64, *const f64, *const f64, *mut f64, *const f64, *mut f64, *const f64);

/// The same for eight bodies side by side.
pub type LongFunctionOfEight = unsafe extern "C" fn(
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *mut f64,
    *const f64,
    *mut f64,
    *const f64,
);

/// Bodies that a `FunctionOfEight` is told.
pub const EIGHT: usize = 8;

/// Most states of a body whose rates of change a function returns.
pub const MOST_STATES: usize = 8;

/// Sizes below which no error of a state is relative to the state: this share of the largest state of the body, and this
/// number in the unit of the user. A state that should be zero but for rounding would ask for endless steps.
pub const SMALL_STATE: [f64; 2] = [1e-6, 1e-9];

/// What numbers for functions are called if they do not fit into memory.
const DATA: &str = "data of a torque";

/// Fewest steps of a run under a function.
///
/// A step of `dop853` looks at the torque at 0, 1/4, 4/13, 1/3, 3/5, 127/195, 6/7 and 1 of its length, `rk4` at 0, 1/2
/// and 1, `midpoint` at 1/2: no pulse is missed that is longer than 0.42, 0.79 or 1.6 % of the run. The second run looks
/// elsewhere.
pub const FEWEST_STEPS: f64 = 64.0;

/// The address of a function, and what it is told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Code {
    /// The address.
    pub address: usize,
    /// Whether it is told eight bodies at once.
    pub is_of_eight: bool,
    /// Whether it is told states and the place on the orbit.
    pub is_long: bool,
}

/// A function that returns a torque, and the numbers that it is given for each body.
#[derive(Clone, Debug, PartialEq)]
pub struct TorqueFunction {
    code: Code,
    /// The numbers that it is given; no rows without numbers.
    data: BodyRows<f64>,
    /// What a torque is multiplied by to be counted in the unit of the moments.
    units: BodyRows<f64>,
    /// A bound of |omega| under this torque, 0 if none is known.
    fastest: f64,
    /// The states at the start.
    starts: BodyRows<f64>,
}

/// The function of one body. It borrows the numbers that the function reads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TorqueCall<'a> {
    code: Code,
    /// The numbers of the body, if there are any.
    data: Option<&'a [f64]>,
    unit: f64,
    fastest: f64,
    /// The states at the start, if there are any.
    start: &'a [f64],
    /// The time at which the time of the state is zero.
    begin: f64,
}

impl TorqueFunction {
    /// The function at an address, of one body or of eight, without states.
    ///
    /// # Safety
    /// A function of the type that `code` tells is at this address as long as any copy of this value lives. It reads `width`
    /// numbers, or rows of numbers, at most, reads and writes as many states as are given to `with_states`, and may be called by
    /// several threads at once.
    ///
    /// # Errors
    /// If the address is zero, or the numbers do not fit.
    pub unsafe fn new(
        code: Code,
        data: Vec<f64>,
        width: usize,
        units: Vec<f64>,
        fastest: f64,
    ) -> Result<TorqueFunction, Error> {
        if code.address == 0 {
            let rule = "its address is not known here, because no file has it; give the scene again";
            return refuse("torque", "a function", rule);
        }
        let (data, units) = (BodyRows::of_width(data, width), BodyRows::of_width(units, 1));
        let made = TorqueFunction { code, data, units, fastest, starts: BodyRows::of_width(Vec::new(), 0) };
        let (rows, bodies) = (made.data.len(), made.bodies());
        let fits = |count: usize| count == bodies || count <= 1;
        let whole = made.data.are_whole() && made.units.len() > 0;
        if !(whole && fits(rows) && fits(made.units.len())) {
            let got = format!("{} numbers", made.data.values.len());
            let expected = format!("({bodies}, {width})");
            return Err(Error::Shape { argument: "data", expected, got });
        }
        Ok(made)
    }

    /// The function with so many states of each body, from these at the start.
    ///
    /// # Errors
    /// If they are more than `MOST_STATES`, do not fit, or belong to a function that is not told them.
    pub fn with_states(self, starts: Vec<f64>, states: usize) -> Result<TorqueFunction, Error> {
        let made = TorqueFunction { starts: BodyRows::of_width(starts, states), ..self };
        let (rows, bodies) = (made.starts.len(), made.bodies());
        let fits = made.starts.are_whole() && (rows == bodies || rows == usize::from(states > 0));
        if !fits || states > MOST_STATES || (states > 0 && !made.code.is_long) {
            let got = format!("{} numbers", made.starts.values.len());
            let expected = format!("({bodies}, {states})");
            return Err(Error::Shape { argument: "states", expected, got });
        }
        Ok(made)
    }

    /// The number of bodies whose function it is; 1 if it serves all alike.
    pub fn bodies(&self) -> usize {
        self.data.len().max(self.units.len()).max(self.starts.len())
    }

    /// How many states each body has.
    pub fn states(&self) -> usize {
        self.starts.width
    }

    /// The function of one of the bodies.
    pub fn of(&self, body: usize) -> TorqueCall<'_> {
        let data = Some(self.data.of(body)).filter(|data| !data.is_empty());
        let (unit, start) = (self.units.of(body)[0], self.starts.of(body));
        TorqueCall { code: self.code, data, unit, fastest: self.fastest, start, begin: 0.0 }
    }

    /// How many numbers the function is given for each body.
    pub fn width(&self) -> usize {
        self.data.width
    }

    /// The function of some bodies, in this order, or of all; one that serves all stays.
    ///
    /// # Errors
    /// If the numbers do not fit into memory.
    pub fn of_some(&self, bodies: Option<&[usize]>) -> Result<TorqueFunction, Error> {
        Ok(TorqueFunction {
            data: self.data.of_some(DATA, bodies)?,
            units: self.units.of_some(DATA, bodies)?,
            starts: self.starts.of_some(DATA, bodies)?,
            ..*self
        })
    }
}

impl<'a> TorqueCall<'a> {
    /// A function that is given no numbers, and returns in the unit of the moments.
    ///
    /// # Safety
    /// As for [`TorqueFunction::new`], with the states of the bodies for which it is called.
    pub unsafe fn without_numbers(code: Code) -> TorqueCall<'a> {
        TorqueCall { code, data: None, unit: 1.0, fastest: 0.0, start: &[], begin: 0.0 }
    }

    /// The function of states whose time is zero at this time.
    pub fn from(self, begin: f64) -> TorqueCall<'a> {
        TorqueCall { begin, ..self }
    }

    /// A bound of |omega|, 0 if none is known.
    pub fn fastest(&self) -> f64 {
        self.fastest
    }

    /// How many numbers the function is given.
    pub fn width(&self) -> usize {
        self.data.map_or(0, <[f64]>::len)
    }

    /// The states at the start; zero beyond those that there are.
    pub fn start(&self) -> [f64; MOST_STATES] {
        let mut states = [0.0; MOST_STATES];
        states[..self.start.len()].copy_from_slice(self.start);
        states
    }

    /// Whether there are states.
    pub fn has_states(&self) -> bool {
        !self.start.is_empty()
    }
}

/// The functions of the bodies of a group, which differ in their data only.
#[derive(Clone)]
pub struct TorqueRows<'a> {
    functions: [Option<TorqueCall<'a>>; LANES],
    begin: Row,
    unit: Row,
    /// Whether they are told states and places.
    are_long: bool,
    /// The data of the bodies, for a `FunctionOfEight`.
    data: Vec<Row>,
}

/// The functions of the bodies of a pack.
#[derive(Clone, Copy)]
pub struct TorqueCalls<'a, R> {
    rows: &'a TorqueRows<'a>,
    /// The first lane of the pack.
    at: usize,
    begin: R,
    unit: R,
    /// Above zero in the lanes whose functions are called.
    active: R,
}

/// What the functions of a pack are told, and of each lane whether its function is called.
#[repr(C, align(64))]
struct Told<const T: usize> {
    time: [f64; EIGHT],
    /// Rates and attitude, to long functions also the states and the place on the orbit.
    numbers: [[f64; EIGHT]; T],
    /// Above zero in the lanes whose functions are called.
    active: [f64; EIGHT],
}

/// Where the parts of the numbers of `Told` begin, and their length.
const ATTITUDE: usize = 3;
const STATES: usize = 7;
const PLACE: usize = STATES + MOST_STATES;
const ALL: usize = PLACE + 3;

/// What functions of a pack return: torques, and of long ones the rates of change of the states.
pub struct Returned<R> {
    /// The torque in the body, in the unit of the moments.
    pub torque: [R; 3],
    /// The rates of change of the states.
    pub states: [R; MOST_STATES],
}

impl<'a> TorqueRows<'a> {
    /// No functions.
    pub const NONE: TorqueRows<'a> = TorqueRows {
        functions: [None; LANES],
        begin: Row::ZERO,
        unit: Row::ZERO,
        are_long: false,
        data: Vec::new(),
    };

    /// No functions, with room for so many numbers of each body.
    ///
    /// # Errors
    /// If the numbers do not fit into memory.
    pub fn with_room(width: usize) -> Result<TorqueRows<'a>, Error> {
        Ok(TorqueRows { data: memory::filled(DATA, width, Row::ZERO)?, ..TorqueRows::NONE })
    }

    /// Sets the function of the body in a lane.
    pub fn set(&mut self, lane: usize, function: Option<TorqueCall<'a>>) {
        let is_first = self.functions.iter().all(Option::is_none);
        self.functions[lane] = function;
        let Some(TorqueCall { code, data, unit, begin, .. }) = function else { return };
        self.are_long = code.is_long;
        (self.begin.0[lane], self.unit.0[lane]) = (begin, unit);
        for (row, &number) in self.data.iter_mut().zip(data.unwrap_or(&[])) {
            row.0[lane] = number;
            // A lane without a body has the data of another.
            if is_first {
                row.0.fill(number);
            }
        }
    }

    /// Whether a function acts on the body in a lane.
    pub fn act_on(&self, lane: usize) -> bool {
        self.functions[lane].is_some()
    }

    /// The functions of the pack that begins at a lane; `None` without any.
    #[inline(always)]
    pub fn of<R: Real>(&self, at: usize) -> Option<TorqueCalls<'_, R>> {
        let mut any = false;
        for lane in at..at + R::LANES {
            any |= self.functions[lane].is_some();
        }
        any.then_some(TorqueCalls {
            rows: self,
            at,
            begin: R::load(&self.begin.0[at..]),
            unit: R::load(&self.unit.0[at..]),
            active: R::splat(1.0),
        })
    }

    /// What the functions of the active bodies in `lanes` lanes from `at` on return. The loops are plain: closures of
    /// arrays are calls.
    #[inline(never)]
    fn call<const T: usize, const N: usize>(
        &self,
        [at, lanes]: [usize; 2],
        told: &Told<T>,
        returned: &mut [[f64; EIGHT]; N],
    ) {
        let mut first = 0;
        while first < lanes && (told.is_idle(first) || self.functions[at + first].is_none()) {
            first += 1;
        }
        if first == lanes {
            return;
        }
        let Some(TorqueCall { code, start, .. }) = &self.functions[at + first] else { return };
        let (code, states) = (*code, start.len());
        if code.is_of_eight {
            self.call_eight((code, states), [at, lanes, first], told, returned);
            return;
        }
        for lane in first..lanes {
            let Some(TorqueCall { data, .. }) = &self.functions[at + lane] else {
                continue;
            };
            if told.is_idle(lane) {
                continue;
            }
            let mut numbers = [0.0; T];
            for k in 0..T {
                numbers[k] = told.numbers[k][lane];
            }
            let data = data.map_or(ptr::null(), <[f64]>::as_ptr);
            let mut own = [0.0; N];
            // What the function does not write is no number.
            own[..3 + states].fill(f64::NAN);
            let (time, numbers, torque) = (told.time[lane], numbers.as_ptr(), own.as_mut_ptr());
            let address = ptr::with_exposed_provenance::<()>(code.address);
            // SAFETY: `TorqueFunction::new` was promised such a function, and `data` has its numbers or is null. Only long
            // functions have states, and `T` and `N` are `ALL` and the torque with all states then.
            unsafe {
                let attitude = numbers.wrapping_add(ATTITUDE);
                if code.is_long {
                    let function = std::mem::transmute::<*const (), LongFunction>(address);
                    let (states, place) = (numbers.wrapping_add(STATES), numbers.wrapping_add(PLACE));
                    let rates = torque.wrapping_add(3);
                    function(time, numbers, attitude, data, torque, states, rates, place);
                } else {
                    let function = std::mem::transmute::<*const (), Function>(address);
                    function(time, numbers, attitude, data, torque);
                }
            }
            for k in 0..N {
                returned[k][lane] = own[k];
            }
        }
    }

    /// The same of bodies, of which that in the lane `first` is active, by a function of eight.
    fn call_eight<const T: usize, const N: usize>(
        &self,
        (code, states): (Code, usize),
        [at, lanes, first]: [usize; 3],
        told: &Told<T>,
        returned: &mut [[f64; EIGHT]; N],
    ) {
        let mut active = 0;
        for lane in 0..lanes {
            active += usize::from(!told.is_idle(lane));
        }
        if active == EIGHT {
            returned[..3 + states].fill([f64::NAN; EIGHT]);
            self.call_full(code, at, told, returned);
            return;
        }
        // Their seats among eight; in a seat without an active body is the state of one.
        let begin = at % EIGHT;
        let mut eight = told.all_as(first);
        for lane in 0..lanes {
            if !told.is_idle(lane) {
                eight.seat(begin + lane, told, lane);
            }
        }
        let mut all = [[0.0; EIGHT]; N];
        all[..3 + states].fill([f64::NAN; EIGHT]);
        self.call_full(code, at - begin, &eight, &mut all);
        for lane in 0..lanes {
            if !told.is_idle(lane) {
                for k in 0..N {
                    returned[k][lane] = all[k][begin + lane];
                }
            }
        }
    }

    /// The same of eight bodies that are all there, from the lane `at` on.
    fn call_full<const T: usize, const N: usize>(
        &self,
        code: Code,
        at: usize,
        told: &Told<T>,
        returned: &mut [[f64; EIGHT]; N],
    ) {
        // The numbers of the lanes, row after row.
        let data = match &self.data[..] {
            [] => ptr::null(),
            rows => rows.as_ptr().cast::<f64>().wrapping_add(at),
        };
        let address = ptr::with_exposed_provenance::<()>(code.address);
        let (time, numbers) = (told.time.as_ptr(), told.numbers.as_ptr());
        let torque = returned.as_mut_ptr();
        // SAFETY: `TorqueFunction::new` was promised such a function, and `data` has its rows or is null. `T` and `N` are as
        // in `call`.
        unsafe {
            let attitude = numbers.wrapping_add(ATTITUDE).cast();
            if code.is_long {
                let function = std::mem::transmute::<*const (), LongFunctionOfEight>(address);
                let (states, place) =
                    (numbers.wrapping_add(STATES).cast(), numbers.wrapping_add(PLACE).cast());
                let rates = torque.wrapping_add(3).cast();
                function(time, numbers.cast(), attitude, data, torque.cast(), states, rates, place);
            } else {
                let function = std::mem::transmute::<*const (), FunctionOfEight>(address);
                function(time, numbers.cast(), attitude, data, torque.cast());
            }
        }
    }
}

impl<const T: usize> Told<T> {
    /// Whether no function is called in a lane.
    fn is_idle(&self, lane: usize) -> bool {
        // A NaN is idle too.
        !(self.active[lane] > 0.0)
    }

    /// The state of one lane in all.
    fn all_as(&self, lane: usize) -> Told<T> {
        let zero = [0.0; EIGHT];
        let mut all = Told { time: zero, numbers: [zero; T], active: zero };
        for seat in 0..EIGHT {
            all.seat(seat, self, lane);
        }
        all
    }

    /// Puts the state of a lane of others into a seat.
    fn seat(&mut self, seat: usize, others: &Told<T>, lane: usize) {
        self.time[seat] = others.time[lane];
        for k in 0..T {
            self.numbers[k][seat] = others.numbers[k][lane];
        }
    }
}

impl<R: Real> TorqueCalls<'_, R> {
    /// The same in the lanes in which a number is above zero.
    #[inline(always)]
    pub fn only(self, wanted: R) -> Self {
        let zero = R::splat(0.0);
        TorqueCalls { active: R::select(zero.lt(wanted), self.active, zero), ..self }
    }

    /// The same for code of a kernel, whose types cannot name a lifetime.
    ///
    /// # Safety
    /// It is not called after the `TorqueRows` has gone.
    #[inline(always)]
    pub unsafe fn outliving(self) -> TorqueCalls<'static, R> {
        let TorqueCalls { rows, at, begin, unit, active } = self;
        // SAFETY: the caller's promise; only the lifetime differs.
        let rows = unsafe { std::mem::transmute::<&TorqueRows<'_>, &'static TorqueRows<'static>>(rows) };
        TorqueCalls { rows, at, begin, unit, active }
    }

    /// Whether the functions are told states and places.
    #[inline(always)]
    pub fn are_long(&self) -> bool {
        self.rows.are_long
    }

    /// The torques in the bodies, in the unit of the moments, from the time since the begin, the rates, and the attitude, a
    /// unit quaternion whose scalar is not negative; zero where no function is called. Functions that are told more get
    /// zeros.
    #[inline(always)]
    pub fn torques(&self, time: R, omega: &[R; 3], attitude: &[R; 4]) -> [R; 3] {
        if self.are_long() {
            let zero = R::splat(0.0);
            return self.returned(time, omega, attitude, &[zero; MOST_STATES], (&[zero; 3], false)).torque;
        }
        let mut returned = [[0.0; EIGHT]; 3];
        let told = self.told::<STATES>(time, omega, attitude);
        self.rows.call([self.at, R::LANES], &told, &mut returned);
        self.in_units(&returned)
    }

    /// The same, and the rates of change of the states, of functions that are told states and places too; or of places
    /// along a trajectory the root of the gradient.
    #[inline(always)]
    pub fn returned(
        &self,
        time: R,
        omega: &[R; 3],
        attitude: &[R; 4],
        states: &[R; MOST_STATES],
        (place, of_root): (&[R; 3], bool),
    ) -> Returned<R> {
        let mut told = self.told::<ALL>(time, omega, attitude);
        for k in 0..MOST_STATES {
            states[k].store(&mut told.numbers[STATES + k]);
        }
        for k in 0..3 {
            place[k].store(&mut told.numbers[PLACE + k]);
        }
        if of_root {
            // Here nothing is left in registers that the call would spill in every step.
            let place = R::outlined(PlaceOfRoot(*place));
            for k in 0..3 {
                place[k].store(&mut told.numbers[PLACE + k]);
            }
        }
        let mut returned = [[0.0; EIGHT]; 3 + MOST_STATES];
        self.rows.call([self.at, R::LANES], &told, &mut returned);
        let (torque, mut rates) = (self.in_units(&returned), *states);
        for k in 0..MOST_STATES {
            rates[k] = R::load(&returned[3 + k]);
        }
        Returned { torque, states: rates }
    }

    /// What functions are told, but states and places.
    #[inline(always)]
    fn told<const T: usize>(&self, time: R, omega: &[R; 3], attitude: &[R; 4]) -> Told<T> {
        const { assert!(R::LANES <= EIGHT) };
        let zero = [0.0; EIGHT];
        let mut told = Told { time: zero, numbers: [zero; T], active: zero };
        (self.begin + time).store(&mut told.time);
        for k in 0..3 {
            omega[k].store(&mut told.numbers[k]);
        }
        for k in 0..4 {
            attitude[k].store(&mut told.numbers[ATTITUDE + k]);
        }
        self.active.store(&mut told.active);
        told
    }

    /// The torques in the unit of the moments.
    #[inline(always)]
    fn in_units<const N: usize>(&self, returned: &[[f64; EIGHT]; N]) -> [R; 3] {
        let mut torques = [self.unit; 3];
        for k in 0..3 {
            torques[k] = R::load(&returned[k]) * self.unit;
        }
        torques
    }
}

/// The attitude, its scalar not negative, of rows of a stage, which are no unit vectors: that of the nearest third row and
/// of the part of the first row across it. It depends smoothly on them, so that no method loses its order.
#[inline(always)]
pub fn attitude_of_stage<R: Real>([mut third, mut first]: [[R; 3]; 2]) -> [R; 4] {
    let one = R::splat(1.0);
    let (squared, along) = (dot(&third, &third), dot(&first, &third));
    // The squared length of the part of the first row across the third, times that of the third.
    let area = squared.fms(dot(&first, &first), along * along);
    // Two roots and two quotients that do not wait for each other.
    let (over_third, over_first) = (one / squared.sqrt(), squared / (squared * area).sqrt());
    let share = along * over_third * over_third;
    for k in 0..3 {
        first[k] = share.fnma(third[k], first[k]) * over_first;
        third[k] = third[k] * over_third;
    }
    let mut attitude = attitude_of_rows(&first, &third);
    let is_negative = attitude[0].lt(R::splat(0.0));
    for part in &mut attitude {
        *part = R::select(is_negative, -*part, *part);
    }
    attitude
}

/// The attitude, its scalar not negative, of a quaternion of a stage, which is no unit quaternion.
#[inline(always)]
pub fn unit_of_stage<R: Real>(mut q: [R; 4]) -> [R; 4] {
    let scale = R::splat(1.0) / squared_length(&q).sqrt();
    let signed = R::select(q[0].lt(R::splat(0.0)), -scale, scale);
    for part in &mut q {
        *part = *part * signed;
    }
    q
}

#[cfg(test)]
mod tests {
    use super::*;

    const OF_ONE: Code = Code { address: 0, is_of_eight: false, is_long: false };

    /// The time, a number of the data, and the scalar of the quaternion.
    unsafe extern "C" fn told(
        t: f64,
        omega: *const f64,
        attitude: *const f64,
        data: *const f64,
        torque: *mut f64,
    ) {
        // SAFETY: the caller gives arrays of these lengths.
        unsafe {
            let number = if data.is_null() { *omega } else { *data };
            [t, number, *attitude].iter().enumerate().for_each(|(k, &x)| *torque.add(k) = x);
        }
    }

    fn function(data: Vec<f64>, width: usize, units: Vec<f64>) -> Result<TorqueFunction, Error> {
        let code = Code { address: told as *const () as usize, ..OF_ONE };
        // SAFETY: the function is of this type.
        unsafe { TorqueFunction::new(code, data, width, units, 0.0) }
    }

    /// The torques of a pack from the time 1 on, of bodies that turn by 9, after a begin at 3.
    fn torques<R: Real>(rows: &TorqueRows, at: usize, wanted: &[f64]) -> [Vec<f64>; 3] {
        let [zero, one] = [0.0, 1.0].map(R::splat);
        let calls = rows.of::<R>(at).unwrap().only(R::load(wanted));
        let turned = [R::splat(-2.0), zero, zero, zero];
        let of_rows = attitude_of_stage([[zero, zero, R::splat(3.0)], [one, zero, one]]);
        let found = calls.torques(one, &[R::splat(9.0); 3], &unit_of_stage(turned));
        let same = calls.torques(one, &[R::splat(9.0); 3], &of_rows);
        (0..3).for_each(|k| assert!(R::all((same[k] - found[k]).abs().lt(R::splat(f64::MIN_POSITIVE)))));
        found.map(|component| {
            let mut numbers = vec![0.0; R::LANES];
            component.store(&mut numbers);
            numbers
        })
    }

    fn torque(made: &TorqueFunction, body: usize) -> [f64; 3] {
        let mut rows = TorqueRows::with_room(made.width()).unwrap();
        rows.set(7, Some(made.of(body).from(3.0)));
        torques::<f64>(&rows, 7, &[1.0]).map(|numbers| numbers[0])
    }

    #[test]
    fn a_function_is_told_time_state_and_the_data_of_its_body() {
        let made = function(vec![5.0, 6.0, 7.0, 8.0], 2, vec![0.5]).unwrap();
        assert_eq!(made.bodies(), 2);
        assert_eq!(torque(&made, 0), [2.0, 2.5, 0.5]);
        assert_eq!(torque(&made, 1), [2.0, 3.5, 0.5]);
        let some = made.of_some(Some(&[1])).unwrap();
        assert_eq!((some.bodies(), torque(&some, 0)), (1, [2.0, 3.5, 0.5]));
        assert_eq!(made.of_some(None).unwrap(), made);
        assert_eq!(torque(&function(vec![], 0, vec![1.0]).unwrap(), 4), [4.0, 9.0, 1.0]);
    }

    /// The same of eight bodies; the third torque is the sum of all data.
    unsafe extern "C" fn told_eight(
        t: *const f64,
        omega: *const f64,
        attitude: *const f64,
        data: *const f64,
        torque: *mut f64,
    ) {
        // SAFETY: the caller gives arrays of these lengths.
        unsafe {
            let sum: f64 = (0..EIGHT).map(|seat| *data.add(LANES + seat)).sum();
            for seat in 0..EIGHT {
                assert_eq!([*omega.add(2 * EIGHT + seat), *attitude.add(seat)], [9.0, 1.0]);
                let torques = [*t.add(seat), *data.add(seat), sum];
                torques.iter().enumerate().for_each(|(k, &x)| *torque.add(EIGHT * k + seat) = x);
            }
        }
    }

    #[test]
    fn a_function_of_eight_is_told_the_state_of_another_where_no_body_is_active() {
        let code = Code { address: told_eight as *const () as usize, is_of_eight: true, ..OF_ONE };
        let bodies = 3;
        let data = (0..2 * bodies).map(f64::from).collect();
        // SAFETY: the function is of this type.
        let made = unsafe { TorqueFunction::new(code, data, 2, vec![0.5], 0.0) }.unwrap();
        let mut rows = TorqueRows::with_room(made.width()).unwrap();
        for body in 0..bodies as usize {
            rows.set(16 + body, Some(made.of(body).from(3.0)));
        }
        // The second numbers are 1, 3, 5, and 1 of those who are not there.
        let sum = 0.5 * (1.0 + 3.0 + 5.0 + 5.0 * 1.0);
        let found = torques::<crate::simd::Arr<f64, 8>>(&rows, 16, &[1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(found[0][..3], [2.0, 0.0, 2.0]);
        assert_eq!([found[1][0], found[1][2], found[2][0]], [0.0, 2.0, sum]);
        for body in 0..bodies as usize {
            let alone = torques::<f64>(&rows, 16 + body, &[1.0]);
            assert_eq!(alone, [vec![2.0], vec![body as f64], vec![sum]]);
        }
        assert!(rows.of::<f64>(15).is_none() && rows.act_on(17));
    }

    #[test]
    fn numbers_that_fit_no_body_are_refused() {
        assert!(function(vec![1.0; 3], 2, vec![1.0]).is_err());
        assert!(function(vec![1.0; 6], 2, vec![1.0; 2]).is_err());
        // SAFETY: nothing is called.
        let none = unsafe { TorqueFunction::new(Code { address: 0, ..OF_ONE }, vec![], 0, vec![1.0], 0.0) };
        assert!(none.unwrap_err().to_string().starts_with("torque = a function: "));
    }

    /// The first state, the second number of the place, and the sum of the states; the rates are the states, twice.
    #[allow(clippy::too_many_arguments)] // Those of the type.
    unsafe extern "C" fn told_long(
        _t: f64,
        _omega: *const f64,
        _attitude: *const f64,
        _data: *const f64,
        torque: *mut f64,
        states: *const f64,
        rates: *mut f64,
        place: *const f64,
    ) {
        // SAFETY: the caller gives arrays of these lengths.
        unsafe {
            let numbers = [*states, *place.add(1), *states + *states.add(1)];
            numbers.iter().enumerate().for_each(|(k, &x)| *torque.add(k) = x);
            *rates = 2.0 * *states;
        }
    }

    #[test]
    fn a_long_function_is_told_states_and_places_and_a_rate_that_it_does_not_write_is_no_number() {
        let code = Code { address: told_long as *const () as usize, is_long: true, ..OF_ONE };
        // SAFETY: the function is of this type.
        let made = unsafe { TorqueFunction::new(code, vec![], 0, vec![0.5], 0.0) }.unwrap();
        assert!(made.of_some(None).unwrap().with_states(vec![1.0; 9], 9).is_err());
        assert!(made.of_some(None).unwrap().with_states(vec![1.0; 3], 2).is_err());
        let made = made.with_states(vec![3.0, 4.0, 5.0, 6.0], 2).unwrap();
        assert_eq!(
            (made.bodies(), made.states(), made.of(1).start()[..3].to_vec()),
            (2, 2, vec![5.0, 6.0, 0.0])
        );
        let (some, both) = (made.of_some(Some(&[1])).unwrap(), made.of_some(None).unwrap());
        assert_eq!((some.of(0), both.of(0).has_states()), (made.of(1), true));
        let mut rows = TorqueRows::with_room(0).unwrap();
        rows.set(2, Some(made.of(1)));
        let calls = rows.of::<f64>(2).unwrap();
        let found = calls.returned(
            0.0,
            &[0.0; 3],
            &[1.0, 0.0, 0.0, 0.0],
            &made.of(1).start(),
            (&[7.0, 8.0, 9.0], false),
        );
        assert_eq!((found.torque, found.states[0]), ([2.5, 4.0, 5.5], 10.0));
        assert!(calls.are_long() && found.states[1].is_nan() && found.states[2..] == [0.0; 6]);
        // SAFETY: nothing is called.
        let short = unsafe { TorqueFunction::new(Code { address: 1, ..OF_ONE }, vec![], 0, vec![1.0], 0.0) };
        assert!(short.unwrap().with_states(vec![1.0], 1).unwrap_err().to_string().starts_with("states"));
    }
}
