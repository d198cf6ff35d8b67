//! A torque that a function of the user returns, known by its address.

use crate::error::Error;
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

/// Bodies that a `FunctionOfEight` is told.
pub const EIGHT: usize = 8;

/// What numbers for functions are called if they do not fit into memory.
const DATA: &str = "data of a torque";

/// Fewest steps of a run under a function.
///
/// A step of `dop853` looks at the torque at 0, 1/4, 4/13, 1/3, 3/5, 127/195, 6/7 and 1 of its length, `rk4` at 0, 1/2
/// and 1, `midpoint` at 1/2: no pulse is missed that is longer than 0.42, 0.79 or 1.6 % of the run. The second run looks
/// elsewhere.
pub const FEWEST_STEPS: f64 = 64.0;

/// The address of a function.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Code {
    /// A `Function`.
    OfOne(usize),
    /// A `FunctionOfEight`.
    OfEight(usize),
}

/// A function that returns a torque, and the numbers that it is given for each body.
#[derive(Clone, Debug, PartialEq)]
pub struct TorqueFunction {
    code: Code,
    /// Rows of `width` numbers: one for all bodies, or one for each; none without numbers.
    data: Vec<f64>,
    width: usize,
    /// What a torque is multiplied by to be counted in the unit of the moments: one for all bodies, or one for each.
    units: Vec<f64>,
    /// A bound of |omega| under this torque, 0 if none is known.
    fastest: f64,
}

/// The function of one body. It borrows the numbers that the function reads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TorqueCall<'a> {
    code: Code,
    /// The numbers of the body, if there are any.
    data: Option<&'a [f64]>,
    unit: f64,
    fastest: f64,
    /// The time at which the time of the state is zero.
    begin: f64,
}

impl TorqueFunction {
    /// The function at an address, of one body or of eight.
    ///
    /// # Safety
    /// A `Function` or a `FunctionOfEight` is at this address as long as any copy of this value lives. It reads `width`
    /// numbers, or rows of numbers, at most, and may be called by several threads at once.
    ///
    /// # Errors
    /// If the address is zero, or the numbers do not fit.
    pub unsafe fn new(
        address: usize,
        is_of_eight: bool,
        data: Vec<f64>,
        width: usize,
        units: Vec<f64>,
        fastest: f64,
    ) -> Result<TorqueFunction, Error> {
        if address == 0 {
            let (value, rule) = (
                "a function".to_string(),
                "its address is not known here, because no file has it; give the scene again",
            );
            return Err(Error::Value { argument: "torque", value, rule });
        }
        let code = if is_of_eight { Code::OfEight(address) } else { Code::OfOne(address) };
        let made = TorqueFunction { code, data, width, units, fastest };
        let (rows, bodies) = (made.rows(), made.bodies());
        let fits = |count: usize| count == bodies || count <= 1;
        let whole = made.data.len() == rows * width && !made.units.is_empty();
        if !(whole && fits(rows) && fits(made.units.len())) {
            let (expected, got) = (format!("({bodies}, {width})"), format!("{} numbers", made.data.len()));
            return Err(Error::Shape { argument: "data", expected, got });
        }
        Ok(made)
    }

    fn rows(&self) -> usize {
        self.data.len().checked_div(self.width).unwrap_or(0)
    }

    /// The number of bodies whose function it is; 1 if it serves all alike.
    pub fn bodies(&self) -> usize {
        self.rows().max(self.units.len())
    }

    /// The function of one of the bodies.
    pub fn of(&self, body: usize) -> TorqueCall<'_> {
        let row = if self.rows() > 1 { body } else { 0 };
        let data = (self.rows() > 0).then(|| &self.data[self.width * row..][..self.width]);
        let unit = self.units[if self.units.len() > 1 { body } else { 0 }];
        TorqueCall { code: self.code, data, unit, fastest: self.fastest, begin: 0.0 }
    }

    /// How many numbers the function is given for each body.
    pub fn width(&self) -> usize {
        self.width
    }

    /// The function of some bodies, in this order; one that serves all stays.
    ///
    /// # Errors
    /// If the numbers do not fit into memory.
    pub fn of_some(&self, bodies: &[usize]) -> Result<TorqueFunction, Error> {
        let row = |&body: &usize| self.data[self.width * body..][..self.width].iter().copied();
        Ok(TorqueFunction {
            data: match self.rows() {
                0 | 1 => memory::collected(DATA, self.data.len(), self.data.iter().copied())?,
                _ => memory::collected(DATA, self.width * bodies.len(), bodies.iter().flat_map(row))?,
            },
            units: match &self.units[..] {
                [one] => memory::collected(DATA, 1, [*one])?,
                all => memory::collected(DATA, bodies.len(), bodies.iter().map(|&body| all[body]))?,
            },
            ..*self
        })
    }

    /// The same function.
    ///
    /// # Errors
    /// If its numbers do not fit into memory once more.
    pub fn copied(&self) -> Result<TorqueFunction, Error> {
        Ok(TorqueFunction {
            data: memory::collected(DATA, self.data.len(), self.data.iter().copied())?,
            units: memory::collected(DATA, self.units.len(), self.units.iter().copied())?,
            ..*self
        })
    }
}

impl<'a> TorqueCall<'a> {
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
}

/// The functions of the bodies of a group, which differ in their data only.
#[derive(Clone)]
pub struct TorqueRows<'a> {
    functions: [Option<TorqueCall<'a>>; LANES],
    begin: Row,
    unit: Row,
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

/// What the functions of a pack are told.
#[repr(C, align(64))]
struct Told {
    time: [f64; EIGHT],
    omega: [[f64; EIGHT]; 3],
    attitude: [[f64; EIGHT]; 4],
    /// Above zero in the lanes whose functions are called.
    active: [f64; EIGHT],
}

/// Torques of the bodies of a pack.
type Torques = [[f64; EIGHT]; 3];

impl<'a> TorqueRows<'a> {
    /// No functions.
    pub const NONE: TorqueRows<'a> =
        TorqueRows { functions: [None; LANES], begin: Row::ZERO, unit: Row::ZERO, data: Vec::new() };

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
        let Some(TorqueCall { data, unit, begin, .. }) = function else { return };
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

    /// The torques of the active bodies in `lanes` lanes from `at` on. The loops are plain: closures of arrays are calls.
    #[inline(never)]
    fn call(&self, [at, lanes]: [usize; 2], told: &Told, torques: &mut Torques) {
        let mut first = 0;
        while first < lanes && told.is_idle(first) {
            first += 1;
        }
        if first == lanes {
            return;
        }
        if let Some(TorqueCall { code: Code::OfEight(address), .. }) = &self.functions[at + first] {
            self.call_eight(*address, [at, lanes, first], told, torques);
            return;
        }
        for lane in first..lanes {
            let Some(TorqueCall { code: Code::OfOne(address), data, .. }) = &self.functions[at + lane] else {
                continue;
            };
            if told.is_idle(lane) {
                continue;
            }
            let [a, b, c] = &told.omega;
            let [w, x, y, z] = &told.attitude;
            let (omega, attitude) = ([a[lane], b[lane], c[lane]], [w[lane], x[lane], y[lane], z[lane]]);
            let data = data.map_or(ptr::null(), <[f64]>::as_ptr);
            // What the function does not write is no number.
            let mut torque = [f64::NAN; 3];
            let address = ptr::with_exposed_provenance::<()>(*address);
            // SAFETY: `TorqueFunction::new` was promised such a function, and `data` has its numbers or is null.
            unsafe {
                let function = std::mem::transmute::<*const (), Function>(address);
                function(told.time[lane], omega.as_ptr(), attitude.as_ptr(), data, torque.as_mut_ptr());
            }
            for k in 0..3 {
                torques[k][lane] = torque[k];
            }
        }
    }

    /// The torques of bodies, of which that in the lane `first` is active, by a `FunctionOfEight`.
    fn call_eight(&self, address: usize, [at, lanes, first]: [usize; 3], told: &Told, torques: &mut Torques) {
        let mut active = 0;
        for lane in 0..lanes {
            active += usize::from(!told.is_idle(lane));
        }
        if active == EIGHT {
            *torques = [[f64::NAN; EIGHT]; 3];
            self.call_full(address, at, told, torques);
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
        let mut returned = [[f64::NAN; EIGHT]; 3];
        self.call_full(address, at - begin, &eight, &mut returned);
        for lane in 0..lanes {
            if !told.is_idle(lane) {
                for k in 0..3 {
                    torques[k][lane] = returned[k][begin + lane];
                }
            }
        }
    }

    /// The torques of eight bodies that are all there, from the lane `at` on.
    fn call_full(&self, address: usize, at: usize, told: &Told, torques: &mut Torques) {
        // The numbers of the lanes, row after row.
        let data = match &self.data[..] {
            [] => ptr::null(),
            rows => rows.as_ptr().cast::<f64>().wrapping_add(at),
        };
        let address = ptr::with_exposed_provenance::<()>(address);
        // SAFETY: `TorqueFunction::new` was promised such a function, and `data` has its rows or is null.
        unsafe {
            let function = std::mem::transmute::<*const (), FunctionOfEight>(address);
            let (omega, attitude) = (told.omega.as_ptr().cast(), told.attitude.as_ptr().cast());
            function(told.time.as_ptr(), omega, attitude, data, torques.as_mut_ptr().cast());
        }
    }
}

impl Told {
    /// Whether no function is called in a lane.
    fn is_idle(&self, lane: usize) -> bool {
        // A NaN is idle too.
        !(self.active[lane] > 0.0)
    }

    /// The state of one lane in all.
    fn all_as(&self, lane: usize) -> Told {
        let zero = [0.0; EIGHT];
        let mut all = Told { time: zero, omega: [zero; 3], attitude: [zero; 4], active: zero };
        for seat in 0..EIGHT {
            all.seat(seat, self, lane);
        }
        all
    }

    /// Puts the state of a lane of others into a seat.
    fn seat(&mut self, seat: usize, others: &Told, lane: usize) {
        self.time[seat] = others.time[lane];
        for k in 0..3 {
            self.omega[k][seat] = others.omega[k][lane];
        }
        for k in 0..4 {
            self.attitude[k][seat] = others.attitude[k][lane];
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

    /// The torques in the bodies, in the unit of the moments, from the time since the begin, the rates, and the attitude, a
    /// unit quaternion whose scalar is not negative; zero where no function is called.
    #[inline(always)]
    pub fn torques(&self, time: R, omega: &[R; 3], attitude: &[R; 4]) -> [R; 3] {
        const { assert!(R::LANES <= EIGHT) };
        let zero = [0.0; EIGHT];
        let mut told = Told { time: zero, omega: [zero; 3], attitude: [zero; 4], active: zero };
        (self.begin + time).store(&mut told.time);
        for k in 0..3 {
            omega[k].store(&mut told.omega[k]);
        }
        for k in 0..4 {
            attitude[k].store(&mut told.attitude[k]);
        }
        self.active.store(&mut told.active);
        let mut torques = [zero; 3];
        self.rows.call([self.at, R::LANES], &told, &mut torques);
        let mut in_units = *omega;
        for k in 0..3 {
            in_units[k] = R::load(&torques[k]) * self.unit;
        }
        in_units
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
        // SAFETY: the function is of this type.
        unsafe { TorqueFunction::new(told as *const () as usize, false, data, width, units, 0.0) }
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
        let some = made.of_some(&[1]).unwrap();
        assert_eq!((some.bodies(), torque(&some, 0)), (1, [2.0, 3.5, 0.5]));
        assert_eq!(made.copied().unwrap(), made);
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
        let (address, bodies) = (told_eight as *const () as usize, 3);
        let data = (0..2 * bodies).map(f64::from).collect();
        // SAFETY: the function is of this type.
        let made = unsafe { TorqueFunction::new(address, true, data, 2, vec![0.5], 0.0) }.unwrap();
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
        let none = unsafe { TorqueFunction::new(0, false, vec![], 0, vec![1.0], 0.0) };
        assert!(none.unwrap_err().to_string().starts_with("torque = a function: "));
    }
}
