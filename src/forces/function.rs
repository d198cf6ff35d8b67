//! A torque that a function of the user returns, known by its address.

use crate::error::Error;
use crate::kinematics::{attitude_of_rows, dot};
use crate::memory;
use crate::real::Real;

/// `void torque(double t, const double *omega, const double *attitude, const double *data, double *torque)`: from the
/// time, the rates in the body and the unit quaternion, scalar first, body to space, w >= 0, the torque in the body.
pub type Function = unsafe extern "C" fn(f64, *const f64, *const f64, *const f64, *mut f64);

/// Fewest steps of a run under a function.
///
/// A step of `dop853` looks at the torque at 0, 1/4, 4/13, 1/3, 3/5, 127/195, 6/7 and 1 of its length, `rk4` at 0, 1/2
/// and 1, `midpoint` at 1/2: no pulse is missed that is longer than 0.42, 0.79 or 1.6 % of the run. The second run looks
/// elsewhere.
pub const FEWEST_STEPS: f64 = 64.0;

/// A function that returns a torque, and the numbers that it is given for each body.
#[derive(Clone, Debug, PartialEq)]
pub struct TorqueFunction {
    address: usize,
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
    address: usize,
    /// The numbers of the body, if there are any.
    data: Option<&'a [f64]>,
    unit: f64,
    fastest: f64,
    /// The time at which the time of the state is zero.
    begin: f64,
}

impl TorqueFunction {
    /// The function at an address.
    ///
    /// # Safety
    /// A function of the type `Function` is at this address as long as any copy of this value lives. It reads `width`
    /// numbers at most, and may be called by several threads at once.
    ///
    /// # Errors
    /// If the address is zero, or the numbers do not fit.
    pub unsafe fn new(
        address: usize,
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
        let made = TorqueFunction { address, data, width, units, fastest };
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
        TorqueCall { address: self.address, data, unit, fastest: self.fastest, begin: 0.0 }
    }

    /// The function of some bodies, in this order; one that serves all stays.
    ///
    /// # Errors
    /// If the numbers do not fit into memory.
    pub fn of_some(&self, bodies: &[usize]) -> Result<TorqueFunction, Error> {
        const DATA: &str = "data of a torque";
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
        const DATA: &str = "data of a torque";
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

    /// The same for code of a kernel, whose types cannot name a lifetime.
    ///
    /// # Safety
    /// It is not called after the `TorqueFunction` has gone.
    #[inline(always)]
    pub unsafe fn outliving(self) -> TorqueCall<'static> {
        // SAFETY: the caller's promise; only the lifetime differs.
        unsafe { std::mem::transmute::<TorqueCall<'a>, TorqueCall<'static>>(self) }
    }

    /// A bound of |omega|, 0 if none is known.
    pub fn fastest(&self) -> f64 {
        self.fastest
    }

    /// The torque in the body, in the unit of the moments, from the time since the begin, the rates, and the third and the
    /// first row of the rotation matrix.
    ///
    /// It is part of a kernel, which makes one call: outside of a kernel each fused product would be a call too.
    #[inline(always)]
    pub fn torque(&self, time: f64, omega: [f64; 3], third: [f64; 3], first: [f64; 3]) -> [f64; 3] {
        let attitude = smooth_attitude(third, first);
        // What the function does not write is no number.
        let mut torque = [f64::NAN; 3];
        let address = std::ptr::with_exposed_provenance::<()>(self.address);
        let data = self.data.map_or(std::ptr::null(), <[f64]>::as_ptr);
        // SAFETY: `TorqueFunction::new` was promised such a function, and `data` has its numbers or is null.
        unsafe {
            let function = std::mem::transmute::<*const (), Function>(address);
            function(self.begin + time, omega.as_ptr(), attitude.as_ptr(), data, torque.as_mut_ptr());
        }
        [torque[0] * self.unit, torque[1] * self.unit, torque[2] * self.unit]
    }
}

/// The attitude, its scalar not negative, of rows of a stage, which are no unit vectors: that of the nearest third row and
/// of the part of the first row across it. It depends smoothly on them, so that no method loses its order.
#[inline(always)]
fn smooth_attitude(mut third: [f64; 3], mut first: [f64; 3]) -> [f64; 4] {
    let (squared, along) = (dot(&third, &third), dot(&first, &third));
    // The squared length of the part of the first row across the third, times that of the third.
    let area = squared.fms(dot(&first, &first), along * along);
    // Two roots and two quotients that do not wait for each other.
    let (over_third, over_first) = (1.0 / squared.sqrt(), squared / (squared * area).sqrt());
    let share = along * over_third * over_third;
    for k in 0..3 {
        first[k] = share.fnma(third[k], first[k]) * over_first;
        third[k] *= over_third;
    }
    let mut attitude = attitude_of_rows(&first, &third);
    if attitude[0] < 0.0 {
        for part in &mut attitude {
            *part = -*part;
        }
    }
    attitude
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
        unsafe { TorqueFunction::new(told as *const () as usize, data, width, units, 0.0) }
    }

    #[test]
    fn a_function_is_told_time_state_and_the_data_of_its_body() {
        let [e1, e3] = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
        let made = function(vec![5.0, 6.0, 7.0, 8.0], 2, vec![0.5]).unwrap();
        assert_eq!(made.bodies(), 2);
        let torque = |made: &TorqueFunction, body| made.of(body).from(3.0).torque(1.0, [9.0; 3], e3, e1);
        assert_eq!(torque(&made, 0), [2.0, 2.5, 0.5]);
        assert_eq!(torque(&made, 1), [2.0, 3.5, 0.5]);
        let some = made.of_some(&[1]).unwrap();
        assert_eq!((some.bodies(), torque(&some, 0)), (1, [2.0, 3.5, 0.5]));
        assert_eq!(made.copied().unwrap(), made);
        assert_eq!(torque(&function(vec![], 0, vec![1.0]).unwrap(), 4), [4.0, 9.0, 1.0]);
    }

    #[test]
    fn numbers_that_fit_no_body_are_refused() {
        assert!(function(vec![1.0; 3], 2, vec![1.0]).is_err());
        assert!(function(vec![1.0; 6], 2, vec![1.0; 2]).is_err());
        // SAFETY: nothing is called.
        let none = unsafe { TorqueFunction::new(0, vec![], 0, vec![1.0], 0.0) };
        assert!(none.unwrap_err().to_string().starts_with("torque = a function: "));
    }
}
