//! What acts on a satellite besides torque and damping: a rotor, an energy sink, quadratic drag, and the gravity gradient
//! on an orbit.

use crate::error::Error;
use crate::real::Real;
use crate::start::Body;

/// Rotor, energy sink, quadratic drag and orbit of one body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Satellite<R> {
    /// Angular momentum of a rotor relative to the body, constant in the body.
    pub rotor: [R; 3],
    /// Coefficients of the energy sink along the body axes; see `scene::satellite`.
    pub sink: [R; 3],
    /// Coefficients `c` of the quadratic drag `-|omega| c omega` along the body axes.
    pub drag: [R; 3],
    /// Rate of the circular orbit, 0 without a gravity gradient.
    pub orbit_rate: R,
    /// The direction to the centre at time 0, in space: a unit vector.
    pub towards: [R; 3],
    /// The direction to the centre a quarter of an orbit later.
    pub ahead: [R; 3],
}

impl<R: Real> Satellite<R> {
    /// Nothing acts.
    #[inline(always)]
    pub fn none() -> Self {
        let zero = R::splat(0.0);
        Satellite {
            rotor: [zero; 3],
            sink: [zero; 3],
            drag: [zero; 3],
            orbit_rate: zero,
            towards: [zero; 3],
            ahead: [zero; 3],
        }
    }
}

impl Satellite<f64> {
    /// Nothing acts.
    pub const NONE: Satellite<f64> = Satellite {
        rotor: [0.0; 3],
        sink: [0.0; 3],
        drag: [0.0; 3],
        orbit_rate: 0.0,
        towards: [0.0; 3],
        ahead: [0.0; 3],
    };

    /// How many numbers it has.
    pub const LEN: usize = 16;

    /// The satellite with these numbers: of the rotor, of the sink, of the drag, of the orbit.
    ///
    /// # Errors
    /// If a number is not finite, a coefficient of the sink or of the drag is negative, or the directions of the orbit
    /// are not unit vectors at right angles.
    pub fn of(numbers: &[f64; Satellite::LEN]) -> Result<Self, Error> {
        let [h1, h2, h3, s1, s2, s3, d1, d2, d3, orbit_rate, t1, t2, t3, a1, a2, a3] = *numbers;
        let refuse = |argument, value: String, rule| Err(Error::Value { argument, value, rule });
        if let Some(bad) = numbers.iter().find(|x| !x.is_finite()) {
            return refuse("satellite", bad.to_string(), "must be finite");
        }
        let (sink, drag, towards, ahead) = ([s1, s2, s3], [d1, d2, d3], [t1, t2, t3], [a1, a2, a3]);
        for (argument, coefficients) in [("dissipation", sink), ("drag", drag)] {
            if coefficients.iter().any(|&c| c < 0.0) {
                return refuse(argument, format!("{coefficients:?}"), "must not be negative");
            }
        }
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let off = [dot(towards, towards) - 1.0, dot(ahead, ahead) - 1.0, dot(towards, ahead)];
        if orbit_rate != 0.0 && off.iter().any(|x| x.abs() > 1e-12) {
            return refuse(
                "towards",
                format!("{towards:?}"),
                "must be a unit vector across the normal of the orbit",
            );
        }
        Ok(Satellite { rotor: [h1, h2, h3], sink, drag, orbit_rate, towards, ahead })
    }

    /// The numbers, in the order of `of`.
    pub fn numbers(&self) -> [f64; Satellite::LEN] {
        let ([h1, h2, h3], [s1, s2, s3], [d1, d2, d3]) = (self.rotor, self.sink, self.drag);
        let ([t1, t2, t3], [a1, a2, a3]) = (self.towards, self.ahead);
        [h1, h2, h3, s1, s2, s3, d1, d2, d3, self.orbit_rate, t1, t2, t3, a1, a2, a3]
    }

    /// The error of a request for displacements under rotor, energy sink, drag or gravity gradient.
    pub fn not_displaced() -> Error {
        Error::Value {
            argument: "scene",
            value: "a satellite".to_string(),
            rule: "displacements under a rotor, dissipation, drag or a gravity gradient are not integrated",
        }
    }

    /// Whether nothing acts.
    pub fn is_none(&self) -> bool {
        [self.rotor, self.sink, self.drag] == [[0.0; 3]; 3] && self.orbit_rate == 0.0
    }

    /// Bounds of the root of twice the energy in the frame of the orbit from that at rest, and of how much the rotation
    /// of this frame adds: the Jacobi integral is constant, and its potential `n^2 (3 o.Io - N.IN) / 2` has the depth
    /// `2 n^2 (I_max - I_min)`, where o points to the centre and N along the normal.
    pub(crate) fn energy_bounds(&self, moments: [f64; 3], root: f64) -> [f64; 2] {
        let [least, largest] = range(moments);
        let turning = self.orbit_rate.abs() * largest.sqrt();
        let depth = 4.0 * self.orbit_rate * self.orbit_rate * (largest - least);
        match self.orbit_rate {
            0.0 => [root, 0.0],
            _ => [((root + turning) * (root + turning) + depth).sqrt(), turning],
        }
    }

    /// A bound of `|I^(-1/2) torque|` for the torque of the gravity gradient, `3 n^2 o x I o`.
    pub(crate) fn strength(&self, moments: [f64; 3]) -> f64 {
        let [least, largest] = range(moments);
        1.5 * self.orbit_rate * self.orbit_rate * (largest - least) / least.sqrt()
    }

    /// What rotor, sink and drag add to the rate that the steps of a body follow, whose rates reach `fastest`: the nutation
    /// `|h| / I` by the rotor, the relaxation `2 c |omega| / I` by the drag, and the turn `e` by the sink with the
    /// relaxation that it causes. The momentum in space is constant if there is no torque, `is_torque_free`.
    pub(crate) fn step_rate(&self, body: &Body, fastest: f64, is_torque_free: bool) -> f64 {
        let [least, largest] = range(body.moments);
        let size = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let rotor = size(self.rotor);
        let momentum = if is_torque_free && self.orbit_rate == 0.0 {
            size([0, 1, 2].map(|k| body.moments[k] * body.omega[k] + self.rotor[k]))
        } else {
            largest * fastest + rotor
        };
        let torque = momentum * fastest + self.strength(body.moments) * least.sqrt();
        let sink = (0..3).map(|k| self.sink[k] / (body.moments[k] * body.moments[k])).fold(0.0, f64::max);
        let drag = (0..3).map(|k| self.drag[k] / body.moments[k]).fold(0.0, f64::max);
        rotor / least + 2.0 * drag * fastest + (sink * torque).max(sink * momentum * momentum / least)
    }
}

/// The least and the largest moment.
fn range(moments: [f64; 3]) -> [f64; 2] {
    let least = moments.iter().fold(f64::INFINITY, |a, &b| a.min(b));
    [least, moments.iter().fold(0.0, |a, &b| a.max(b))]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_a_satellite_are_checked() {
        let numbers = [1.0, 2.0, 3.0, 0.0, 0.1, 0.2, 0.3, 0.0, 0.4, 0.5, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        let satellite = Satellite::of(&numbers).unwrap();
        assert_eq!(satellite.numbers(), numbers);
        assert!(!satellite.is_none() && Satellite::NONE.is_none());
        let with = |at: usize, value: f64| {
            let mut changed = numbers;
            changed[at] = value;
            Satellite::of(&changed).unwrap_err().to_string()
        };
        assert!(with(0, f64::NAN).starts_with("satellite = NaN"));
        assert!(with(4, -1.0).starts_with("dissipation = [0.0, -1.0, 0.2]"));
        assert!(with(8, -1.0).starts_with("drag = [0.3, 0.0, -1.0]"));
        assert!(with(10, 0.5).starts_with("towards = [0.5, 0.0, 0.0]"));
        assert!(with(13, 0.5).starts_with("towards"));
    }
}
