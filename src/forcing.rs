//! `Forcing`: applied torque over time, linear damping, and what acts on a satellite, of one body or of many;
//! `BodyForcing`: that of one of them.

use crate::called::{TorqueCall, TorqueFunction};
use crate::error::Error;
use crate::memory;
use crate::real::Real;
use crate::satellite::Satellite;
use crate::special::exp;

/// What the table of a torque is called if it does not fit into memory.
const TABLE: &str = "table of the torque";

/// Applied torque and damping of one body on an interval of time in which the torque is linear.
#[derive(Clone, Copy)]
pub struct ForcingInterval<R> {
    /// Torque in the body at the begin of the interval, and its rate of change.
    pub body: [[R; 3]; 2],
    /// Torque in space at the begin of the interval, and its rate of change.
    pub space: [[R; 3]; 2],
    /// Damping: the torque is minus this matrix times the rates; its entries 11, 22, 33, 23, 31, 12.
    pub damping: [R; 6],
    /// Damping rates of the body without torque: eigenvalues of `I^(-1/2) D I^(-1/2)`.
    pub rates: [R; 3],
    /// Eigenvectors of the damping rates, as columns.
    pub modes: [[R; 3]; 3],
    /// Rotor, energy sink, quadratic drag and orbit.
    pub satellite: Satellite<R>,
    /// The function that returns a further torque.
    pub function: Option<TorqueCall>,
    /// The change of the parameters that displaces the body, if displacements are integrated.
    pub change: ParameterChange<R>,
}

/// A small change of the parameters of a body, whose effect is a displacement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterChange<R> {
    /// Of the principal moments.
    pub moments: [R; 3],
    /// Of `mgl com`.
    pub weight: [R; 3],
    /// Of the damping matrix: its entries 11, 22, 33, 23, 31, 12.
    pub damping: [R; 6],
    /// Of the torque in the body, at all times.
    pub torque: [R; 3],
}

impl ParameterChange<f64> {
    /// Number of parameters.
    pub const LEN: usize = 15;

    /// The change with these numbers: of moments, weight, damping and torque.
    pub fn of(numbers: &[f64; ParameterChange::LEN]) -> Self {
        let [i1, i2, i3, w1, w2, w3, d11, d22, d33, d23, d31, d12, t1, t2, t3] = *numbers;
        ParameterChange {
            moments: [i1, i2, i3],
            weight: [w1, w2, w3],
            damping: [d11, d22, d33, d23, d31, d12],
            torque: [t1, t2, t3],
        }
    }
}

impl<R: Real> ParameterChange<R> {
    /// No change.
    #[inline(always)]
    pub fn none() -> Self {
        let zero = R::splat(0.0);
        ParameterChange { moments: [zero; 3], weight: [zero; 3], damping: [zero; 6], torque: [zero; 3] }
    }
}

impl<R: Real> ForcingInterval<R> {
    /// No forcing.
    #[inline(always)]
    pub fn none() -> Self {
        let zero = R::splat(0.0);
        ForcingInterval {
            body: [[zero; 3]; 2],
            space: [[zero; 3]; 2],
            damping: [zero; 6],
            rates: [zero; 3],
            modes: [[zero; 3]; 3],
            satellite: Satellite::none(),
            function: None,
            change: ParameterChange::none(),
        }
    }
}

/// Applied torques, piecewise linear in time, and linear damping, of one body or of many. All tables have the same
/// times, and each table or matrix is that of one body or serves all.
#[derive(Clone, Debug, PartialEq)]
pub struct Forcing {
    /// Times of the values, ascending; two equal times are a jump. Empty for constant torques.
    times: Vec<f64>,
    /// Torque in the body and torque in space at each time, table after table; one pair for a constant torque; empty if
    /// no torque is applied to any body.
    values: Vec<[[f64; 3]; 2]>,
    /// Entries 11, 22, 33, 23, 31, 12 of the damping matrices `D`: the damping torque is `-D omega`.
    dampings: Vec<[f64; 6]>,
    /// What acts on the bodies as satellites.
    satellites: Vec<Satellite<f64>>,
    /// The function that returns a further torque.
    function: Option<TorqueFunction>,
}

impl Forcing {
    /// No applied torque and no damping.
    pub const NONE: &'static Forcing = &Forcing {
        times: Vec::new(),
        values: Vec::new(),
        dampings: Vec::new(),
        satellites: Vec::new(),
        function: None,
    };

    /// Torques in the body and in space, given at some times (without times: constant torques), and damping.
    ///
    /// # Errors
    /// If a number is not finite, if the times descend, if there is not one value for each time, or if damping would
    /// add energy.
    pub fn new(
        times: &[f64],
        body: &[[f64; 3]],
        space: &[[f64; 3]],
        dampings: &[[f64; 6]],
    ) -> Result<Forcing, Error> {
        let refuse = |argument, value: String, rule| Err(Error::Value { argument, value, rule });
        let wanted = times.len().max(1);
        for values in [body, space] {
            if !values.len().is_multiple_of(wanted) || values.len() != body.len() {
                let (expected, got) = (format!("({wanted}, 3)"), format!("({}, 3)", values.len()));
                return Err(Error::Shape { argument: "torque", expected, got });
            }
            if let Some(&bad) = values.iter().flatten().find(|x| !x.is_finite()) {
                return refuse("torque", bad.to_string(), "must be finite");
            }
        }
        if let Some(&bad) = times.iter().find(|x| !x.is_finite()) {
            return refuse("torque times", bad.to_string(), "must be finite");
        }
        if let Some(pair) = times.windows(2).find(|pair| pair[1] < pair[0]) {
            return refuse("torque times", format!("{pair:?}"), "must be ascending");
        }
        if let Some(three) = times.windows(3).find(|three| three[0] == three[2]) {
            return refuse("torque times", format!("{three:?}"), "at most two values may share a time");
        }
        if times.len() == 1 {
            return refuse("torque times", times[0].to_string(), "a table has at least two times");
        }
        let values = body.iter().zip(space).map(|(&body, &space)| [body, space]);
        let made = Forcing {
            times: memory::collected(TABLE, times.len(), times.iter().copied())?,
            values: memory::collected(TABLE, body.len(), values)?,
            dampings: memory::collected("damping", dampings.len(), dampings.iter().copied())?,
            satellites: Vec::new(),
            function: None,
        };
        let rows = [body.len() / wanted, dampings.len()];
        if rows.iter().any(|&rows| rows > 1 && rows != made.bodies()) {
            let (expected, got) = (format!("({}, ...)", made.bodies()), format!("{rows:?} rows"));
            return Err(Error::Shape { argument: "torque and damping", expected, got });
        }
        for &damping in dampings {
            if !damping.iter().all(|x| x.is_finite()) {
                return refuse("damping", format!("{damping:?}"), "must be finite");
            }
            let [least, .., largest] = BodyForcing { damping, ..BodyForcing::NONE }.damping_rates([1.0; 3]);
            // The error of an eigenvalue is a few roundings of the largest one.
            if least < -8.0 * f64::EPSILON * largest.abs().max(least.abs()) {
                let rule = "must be positive semi-definite, so that damping cannot add energy";
                let [d11, d22, d33, d23, d31, d12] = damping;
                let matrix = [[d11, d12, d31], [d12, d22, d23], [d31, d23, d33]];
                return refuse("damping", format!("{matrix:?}"), rule);
            }
        }
        Ok(made)
    }

    /// The same torques and damping with rotors, energy sinks and orbits: those of each body, or of all.
    ///
    /// # Errors
    /// If numbers are impossible (`Satellite::of`), or those of another number of bodies.
    pub fn with_satellites(self, rows: &[[f64; Satellite::LEN]]) -> Result<Forcing, Error> {
        let mut satellites = memory::reserved("satellites", rows.len())?;
        for row in rows {
            satellites.push(Satellite::of(row)?);
        }
        let (rows, others) = (satellites.len(), self.bodies());
        if rows > 1 && others > 1 && rows != others {
            let (expected, got) = (format!("({others}, {})", Satellite::LEN), format!("({rows}, ...)"));
            return Err(Error::Shape { argument: "satellite", expected, got });
        }
        Ok(Forcing { satellites, ..self })
    }

    /// The same forcing with the torque that a function returns.
    ///
    /// # Errors
    /// If it is that of another number of bodies, or something acts that no scheme integrates with it.
    pub fn with_function(self, function: TorqueFunction) -> Result<Forcing, Error> {
        if self.satellites.iter().any(|satellite| !satellite.is_none()) {
            let (value, rule) =
                ("a function".to_string(), "acts with other torques, damping and weight only");
            return Err(Error::Value { argument: "torque", value, rule });
        }
        let (rows, others) = (function.bodies(), self.bodies());
        if rows > 1 && others > 1 && rows != others {
            let (expected, got) = (format!("({others}, ...)"), format!("({rows}, ...)"));
            return Err(Error::Shape { argument: "data", expected, got });
        }
        Ok(Forcing { function: Some(function), ..self })
    }

    /// The same forcing.
    ///
    /// # Errors
    /// If its tables do not fit into memory once more.
    pub fn copied(&self) -> Result<Forcing, Error> {
        Ok(Forcing {
            times: memory::collected(TABLE, self.times.len(), self.times.iter().copied())?,
            values: memory::collected(TABLE, self.values.len(), self.values.iter().copied())?,
            dampings: memory::collected("damping", self.dampings.len(), self.dampings.iter().copied())?,
            satellites: memory::collected(
                "satellites",
                self.satellites.len(),
                self.satellites.iter().copied(),
            )?,
            function: self.function.as_ref().map(TorqueFunction::copied).transpose()?,
        })
    }

    /// The forcing of some bodies, in this order; one forcing that serves all stays.
    ///
    /// # Errors
    /// If there is no such body, or the tables do not fit into memory.
    pub fn of_some(&self, bodies: &[usize]) -> Result<Forcing, Error> {
        if let Some(bad) = bodies.iter().find(|&&body| self.bodies() > 1 && body >= self.bodies()) {
            let rule = "there is no such body";
            return Err(Error::Value { argument: "body", value: bad.to_string(), rule });
        }
        let knots = self.times.len().max(1);
        let tables = self.values.len() / knots;
        let values = |&body: &usize| self.values[knots * body..][..knots].iter().copied();
        Ok(Forcing {
            times: memory::collected(TABLE, self.times.len(), self.times.iter().copied())?,
            values: match tables {
                0 | 1 => memory::collected(TABLE, self.values.len(), self.values.iter().copied())?,
                _ => memory::collected(TABLE, knots * bodies.len(), bodies.iter().flat_map(values))?,
            },
            dampings: match &self.dampings[..] {
                one @ ([] | [_]) => memory::collected("damping", one.len(), one.iter().copied())?,
                all => memory::collected("damping", bodies.len(), bodies.iter().map(|&body| all[body]))?,
            },
            satellites: match &self.satellites[..] {
                one @ ([] | [_]) => memory::collected("satellites", one.len(), one.iter().copied())?,
                all => memory::collected("satellites", bodies.len(), bodies.iter().map(|&body| all[body]))?,
            },
            function: self.function.as_ref().map(|function| function.of_some(bodies)).transpose()?,
        })
    }

    /// The same with damping that is rounded otherwise, by a unit in the last place: the diagonal up, the rest down. So
    /// equal dampings of all axes stay equal, and a matrix that is nearly singular changes its least rate.
    ///
    /// # Errors
    /// As `of_some`.
    pub fn rounded_otherwise(&self) -> Result<Forcing, Error> {
        let all = memory::collected("bodies", self.bodies(), 0..self.bodies())?;
        let mut forcing = self.of_some(&all)?;
        for (k, entry) in forcing.dampings.iter_mut().flat_map(|damping| damping.iter_mut().enumerate()) {
            *entry *= if k < 3 { 1.0 + f64::EPSILON } else { 1.0 - f64::EPSILON };
        }
        Ok(forcing)
    }

    /// The forcing of neighbouring bodies; `None` if one forcing serves all.
    ///
    /// # Errors
    /// As `of_some`.
    pub fn of_range(&self, bodies: std::ops::Range<usize>) -> Result<Option<Forcing>, Error> {
        if self.bodies() == 1 {
            return Ok(None);
        }
        self.of_some(&memory::collected("bodies", bodies.len(), bodies)?).map(Some)
    }

    /// The number of bodies whose forcing it is; 1 if one forcing serves all.
    pub fn bodies(&self) -> usize {
        let tables = self.values.len() / self.times.len().max(1);
        let functions = self.function.as_ref().map_or(1, TorqueFunction::bodies);
        tables.max(self.dampings.len()).max(self.satellites.len()).max(functions)
    }

    /// The forcing of one of the bodies.
    pub fn of(&self, body: usize) -> BodyForcing<'_> {
        let knots = self.times.len().max(1);
        let tables = self.values.len() / knots;
        let first = if tables > 1 { knots * body } else { 0 };
        BodyForcing {
            times: &self.times,
            values: if tables > 0 { &self.values[first..][..knots] } else { &[] },
            damping: match &self.dampings[..] {
                [] => [0.0; 6],
                [damping] => *damping,
                dampings => dampings[body],
            },
            satellite: match &self.satellites[..] {
                [] => Satellite::NONE,
                [satellite] => *satellite,
                satellites => satellites[body],
            },
            function: self.function.as_ref().map(|function| function.of(body)),
        }
    }

    /// Whether there is no forcing of any body.
    pub fn is_none(&self) -> bool {
        (0..self.bodies()).all(|body| self.of(body).is_none())
    }
}

/// The forcing of one body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyForcing<'a> {
    /// Times of the values.
    times: &'a [f64],
    /// Torque in the body and torque in space at each time; empty if no torque is applied.
    values: &'a [[[f64; 3]; 2]],
    /// Entries 11, 22, 33, 23, 31, 12 of the damping matrix.
    damping: [f64; 6],
    /// Rotor, energy sink, quadratic drag and orbit.
    satellite: Satellite<f64>,
    /// The function that returns a further torque.
    function: Option<TorqueCall>,
}

impl BodyForcing<'_> {
    /// No applied torque and no damping.
    pub const NONE: BodyForcing<'static> = BodyForcing {
        times: &[],
        values: &[],
        damping: [0.0; 6],
        satellite: Satellite::NONE,
        function: None,
    };

    /// Whether there is no forcing.
    pub fn is_none(&self) -> bool {
        self.values.is_empty()
            && self.damping == [0.0; 6]
            && self.satellite.is_none()
            && self.function.is_none()
    }

    /// The first values; zero if no torque is applied.
    fn first(&self) -> [[f64; 3]; 2] {
        self.values.first().copied().unwrap_or_default()
    }

    /// Rotor, energy sink, quadratic drag and orbit.
    pub fn satellite(&self) -> &Satellite<f64> {
        &self.satellite
    }

    /// The function that returns a further torque.
    pub fn function(&self) -> Option<TorqueCall> {
        self.function
    }

    /// Whether no torque is applied and nothing damps: rotor, sink and orbit are not asked about.
    pub fn is_torque_free(&self) -> bool {
        self.values.iter().flatten().flatten().all(|&x| x == 0.0) && self.damping == [0.0; 6]
    }

    /// Whether a torque in space, a gravity gradient or a function acts at any time: the rates then depend on the
    /// attitude.
    pub fn acts_in_space(&self) -> bool {
        self.satellite.orbit_rate != 0.0
            || self.function.is_some()
            || self.values.iter().any(|[_, space]| space.iter().any(|&x| x != 0.0))
    }

    /// The times between which the torque is linear in time.
    pub fn knots(&self) -> &[f64] {
        self.times
    }

    /// Raises an error for a time outside the table of the torque, where the torque is unknown.
    pub fn check_reaches(&self, time: f64) -> Result<(), Error> {
        match (self.times.first(), self.times.last()) {
            (Some(&first), Some(&last)) if !(first <= time && time <= last) => Err(Error::Value {
                argument: "t",
                value: time.to_string(),
                rule: "the table of the torque does not reach this time",
            }),
            _ => Ok(()),
        }
    }

    /// The forcing of a body with these moments from a time to the next knot, forward or backward.
    pub fn interval(&self, time: f64, backward: bool, moments: [f64; 3]) -> ForcingInterval<f64> {
        let [[body, body_slope], [space, space_slope]] = self.torques(time, backward);
        let (rates, modes) = self.damping_modes(moments);
        ForcingInterval {
            body: [body, body_slope],
            space: [space, space_slope],
            damping: self.damping,
            rates,
            modes,
            satellite: self.satellite,
            function: self.function.map(|function| function.from(time)),
            change: ParameterChange::none(),
        }
    }

    /// The torques in the body and in space at a time, each with its rate of change.
    fn torques(&self, time: f64, backward: bool) -> [[[f64; 3]; 2]; 2] {
        let [mut value, mut slope] = [self.first(), [[0.0; 3]; 2]];
        if self.times.len() > 1 {
            let piece = self.piece(time, backward);
            let (begin, end) = (self.times[piece], self.times[piece + 1]);
            for f in 0..2 {
                for k in 0..3 {
                    let (from, to) = (self.values[piece][f][k], self.values[piece + 1][f][k]);
                    slope[f][k] = if end > begin { (to - from) / (end - begin) } else { 0.0 };
                    value[f][k] = from + slope[f][k] * (time - begin);
                }
            }
        }
        [[value[0], slope[0]], [value[1], slope[1]]]
    }

    /// The interval of the table that a motion enters at a time.
    fn piece(&self, time: f64, backward: bool) -> usize {
        let after = if backward {
            self.times.partition_point(|&knot| knot < time)
        } else {
            self.times.partition_point(|&knot| knot <= time)
        };
        after.clamp(1, self.times.len() - 1) - 1
    }

    /// The next knot after a time, forward or backward.
    pub fn next_knot(&self, time: f64, backward: bool) -> Option<f64> {
        if backward {
            self.times[..self.times.partition_point(|&knot| knot < time)].last().copied()
        } else {
            self.times.get(self.times.partition_point(|&knot| knot <= time)).copied()
        }
    }

    /// Whether the table of the torque has two values at a time.
    pub fn jumps_at(&self, time: f64) -> bool {
        let first = self.times.partition_point(|&knot| knot < time);
        self.times[first..].get(..2) == Some(&[time; 2][..])
    }

    /// Damping rates of a body with these moments without torque, ascending: the eigenvalues of `I^(-1/2) D I^(-1/2)`.
    pub fn damping_rates(&self, moments: [f64; 3]) -> [f64; 3] {
        let mut rates = self.damping_modes(moments).0;
        rates.sort_by(f64::total_cmp);
        rates
    }

    /// The eigenvalues of `I^(-1/2) D I^(-1/2)`, and its eigenvectors as columns.
    pub fn damping_modes(&self, moments: [f64; 3]) -> ([f64; 3], [[f64; 3]; 3]) {
        let [d11, d22, d33, d23, d31, d12] = self.damping;
        let mut scaled = [[d11, d12, d31], [d12, d22, d23], [d31, d23, d33]];
        for i in 0..3 {
            for k in 0..3 {
                // The root of a square would be rounded.
                scaled[i][k] /= if i == k { moments[i] } else { moments[i].sqrt() * moments[k].sqrt() };
            }
        }
        eigen(scaled)
    }

    /// A bound of the integral of `|I^(-1/2) torque|` between two times, which bounds the increase of the root of twice
    /// the energy. The size of a linear function is convex, so the sum of trapezoids is a bound.
    fn gain(&self, moments: [f64; 3], from: f64, to: f64) -> f64 {
        if self.times.is_empty() {
            return size(moments, self.first()) * (to - from).abs();
        }
        let at = |time: f64, backward: bool| {
            let [body, space] = self.torques(time, backward);
            size(moments, [body[0], space[0]])
        };
        let inner = self.times.iter().copied().filter(|&knot| from < knot && knot < to);
        let mut last = from;
        let area = |next: f64| {
            let begin = std::mem::replace(&mut last, next);
            0.5 * (at(begin, false) + at(next, true)) * (next - begin)
        };
        inner.chain(std::iter::once(to)).map(area).sum()
    }

    /// Entries 11, 22, 33, 23, 31, 12 of the damping matrix.
    pub fn damping(&self) -> [f64; 6] {
        self.damping
    }

    /// Entries 11, 22, 33, 23, 31, 12 of the damping matrix, if nothing else acts at any time.
    pub fn damping_alone(&self) -> Option<[f64; 6]> {
        let acts_otherwise = !self.satellite.is_none() || self.function.is_some();
        let is_alone = !acts_otherwise && self.values.iter().flatten().flatten().all(|&x| x == 0.0);
        is_alone.then_some(self.damping)
    }

    /// The rate k, if the forcing is a damping `D = k I` without torque, equal to within the rounding of the products.
    ///
    /// All components of the momentum then decay as `exp(-k t)`, and the motion is a free motion in a transformed time.
    pub fn slows_evenly(&self, moments: [f64; 3]) -> Option<f64> {
        let [d11, d22, d33, ..] = self.damping_alone()?;
        let diagonal = self.damping[3..].iter().all(|&x| x == 0.0);
        let own = [d11, d22, d33];
        let fits = |&k: &f64| (0..3).all(|i| k * moments[i] == own[i]);
        (0..3).map(|i| own[i] / moments[i]).find(fits).filter(|_| diagonal)
    }

    /// A bound of `|I^(-1/2) torque|` at all times.
    fn strength(&self, moments: [f64; 3]) -> f64 {
        let applied = self.values.iter().map(|&value| size(moments, value)).fold(0.0, f64::max);
        applied + self.satellite.strength(moments)
    }

    /// A bound of |omega| between two times around 0, from the power balance. `twice_kinetic` is taken at the start,
    /// `mgl` is the weight, `fall` the energy that the body can gain by falling.
    ///
    /// With `u = |I^(1/2) omega|`, `u' <= |I^(-1/2) torque| - d u`, and `|omega| <= u / sqrt(I_min)`; `d` is the least
    /// damping rate. Backward in time damping adds energy at the largest rate. On an orbit u is that of the rates seen
    /// from the orbit, whose potential is bounded. Rotor, sink and drag add no energy; backward in time sink and drag add
    /// energy without bound, and the rates are taken as if they added none. Of a function a bound may be known.
    pub fn fastest_rate(
        &self,
        moments: [f64; 3],
        [twice_kinetic, mgl, fall]: [f64; 3],
        [first, last]: [f64; 2],
    ) -> f64 {
        let least = moments.iter().fold(f64::INFINITY, |a, &b| a.min(b));
        let [d, .., fastest] = self.damping_rates(moments);
        let start = twice_kinetic.sqrt();
        let [reach, turning] = self.satellite.energy_bounds(moments, (twice_kinetic + 2.0 * fall).sqrt());
        // Damping slows the rates in space, not those seen from the orbit.
        let drag = |time: f64| if turning > 0.0 { turning * fastest.max(0.0) * time } else { 0.0 };
        let mut forward = reach + turning + self.gain(moments, 0.0, last.max(0.0)) + drag(last.max(0.0));
        let mut swing = (mgl / least).sqrt();
        if d > 0.0 {
            forward = forward.min(start + (mgl / least.sqrt() + self.strength(moments)) / d);
            swing = swing.min(mgl / (least * d));
        }
        let back = first.min(0.0);
        let mut u = forward;
        if back < 0.0 {
            let gained = self.gain(moments, back, 0.0) + drag(-back);
            u = u.max((reach + gained) * exp(-fastest.max(0.0) * back) + turning);
        }
        let called = self.function.map_or(0.0, |function| function.fastest());
        (u / least.sqrt()).max(swing).max(called)
    }
}

/// A bound of `|I^(-1/2) torque|` for the sum of a torque in the body and a torque in space.
fn size(moments: [f64; 3], [body, space]: [[f64; 3]; 2]) -> f64 {
    let least = moments.iter().fold(f64::INFINITY, |a, &b| a.min(b));
    let own: f64 = (0..3).map(|k| body[k] * body[k] / moments[k]).sum();
    let turned: f64 = space.iter().map(|x| x * x).sum::<f64>() / least;
    own.sqrt() + turned.sqrt()
}

/// Eigenvalues and eigenvectors (columns) of a symmetric matrix, by plane rotations (Jacobi 1846). Only arithmetic
/// and roots are used, so that the bits are equal on all machines.
fn eigen(mut a: [[f64; 3]; 3]) -> ([f64; 3], [[f64; 3]; 3]) {
    let mut vectors = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    // Convergence is quadratic: the off-diagonal part of any matrix vanishes after five or six sweeps.
    for _ in 0..12 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if a[p][q] == 0.0 {
                continue;
            }
            let tau = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
            // The smaller root of t^2 + 2 tau t = 1; it is zero if the square of tau overflows.
            let t = tau.signum() / (tau.abs() + (1.0 + tau * tau).sqrt());
            let cos = 1.0 / (1.0 + t * t).sqrt();
            let sin = t * cos;
            let (app, aqq, apq) = (a[p][p], a[q][q], a[p][q]);
            let r = 3 - p - q;
            let (apr, aqr) = (a[p][r], a[q][r]);
            a[p][p] = app - t * apq;
            a[q][q] = aqq + t * apq;
            (a[p][q], a[q][p]) = (0.0, 0.0);
            a[p][r] = cos * apr - sin * aqr;
            a[q][r] = sin * apr + cos * aqr;
            (a[r][p], a[r][q]) = (a[p][r], a[q][r]);
            for row in &mut vectors {
                let (vp, vq) = (row[p], row[q]);
                row[p] = cos * vp - sin * vq;
                row[q] = sin * vp + cos * vq;
            }
        }
    }
    ([a[0][0], a[1][1], a[2][2]], vectors)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn damping(entries: [f64; 6]) -> Result<Forcing, Error> {
        Forcing::new(&[], &[[0.0; 3]], &[[0.0; 3]], &[entries])
    }

    #[test]
    fn the_absence_of_forcing_is_a_value() {
        let none = Forcing::NONE.of(7);
        assert!(Forcing::NONE.is_none() && none.is_none() && !none.acts_in_space());
        assert!(!damping([0.0; 6]).unwrap().is_none());
        assert_eq!(none.next_knot(0.0, false), None);
        assert!(none.check_reaches(1e300).is_ok());
    }

    #[test]
    fn each_body_has_a_torque_and_a_damping_of_its_own_or_that_of_all() {
        let (torques, none) = ([[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0]], [[0.0; 3]; 3]);
        let [strong, weak] = [[2.0; 6], [0.0; 6]].map(|d: [f64; 6]| [d[0], d[1], d[2], 0.0, 0.0, 0.0]);
        let forcing = Forcing::new(&[], &torques, &none, &[strong]).unwrap();
        assert_eq!(forcing.bodies(), 3);
        for (body, torque) in torques.into_iter().enumerate() {
            let interval = forcing.of(body).interval(0.0, false, [1.0; 3]);
            assert_eq!((interval.body[0], interval.damping), (torque, strong));
        }
        let some = forcing.of_some(&[2, 0]).unwrap();
        assert_eq!((some.bodies(), some.of(0), some.of(1)), (2, forcing.of(2), forcing.of(0)));
        assert!(forcing.of_some(&[3]).is_err());
        let damped = Forcing::new(&[], &[], &[], &[strong, weak]).unwrap();
        assert!(!damped.is_none() && !damped.of(0).is_none() && damped.of(1).is_none());
        let tables = Forcing::new(&[0.0, 1.0], &[[0.0; 3]; 4], &[[0.0; 3]; 4], &[strong, weak]).unwrap();
        assert_eq!((tables.bodies(), tables.of(1).knots()), (2, &[0.0, 1.0][..]));
        assert!(Forcing::new(&[], &torques, &none, &[strong, weak]).is_err());
    }

    #[test]
    fn a_torque_is_linear_between_its_knots_and_jumps_at_equal_times() {
        let torque = [[1.0, 0.0, 0.0], [3.0, 0.0, 0.0], [7.0, 0.0, 0.0], [7.0, 0.0, 0.0]];
        let forcing = Forcing::new(&[0.0, 2.0, 2.0, 4.0], &torque, &[[0.0; 3]; 4], &[[0.0; 6]]).unwrap();
        let forcing = forcing.of(0);
        let at = |time, backward| forcing.interval(time, backward, [1.0; 3]).body.map(|x| x[0]);
        assert_eq!(at(0.0, false), [1.0, 1.0]);
        assert_eq!(at(1.0, false), [2.0, 1.0]);
        assert_eq!(at(2.0, false), [7.0, 0.0]);
        assert_eq!(at(2.0, true), [3.0, 1.0]);
        assert_eq!(forcing.next_knot(0.0, false), Some(2.0));
        assert_eq!(forcing.next_knot(4.0, true), Some(2.0));
        assert_eq!([0.0, 1.0, 2.0, 4.0].map(|time| forcing.jumps_at(time)), [false, false, true, false]);
    }

    #[test]
    fn damping_that_adds_energy_is_refused() {
        assert!(damping([1.0, 1.0, 1.0, 0.0, 0.0, 1.0]).is_ok());
        // The product of the off-diagonal entries exceeds that of the diagonal ones by a few roundings only.
        assert!(damping([1.0, 1.0, 1.0, 0.0, 0.0, 1.0 + f64::EPSILON]).is_ok());
        assert!(damping([1.0, 1.0, 1.0, 0.0, 0.0, 1.0 + 1e-14]).is_err());
        assert!(damping([-1e-300, 0.0, 0.0, 0.0, 0.0, 0.0]).is_err());
    }

    #[test]
    fn modes_of_damping_are_eigenvectors() {
        let entries = [2.0, 3.0, 5.0, 0.4, -0.3, 0.7];
        let moments = [1.0, 2.0, 4.0];
        let (rates, modes) = damping(entries).unwrap().of(0).damping_modes(moments);
        let [d11, d22, d33, d23, d31, d12] = entries;
        let matrix = [[d11, d12, d31], [d12, d22, d23], [d31, d23, d33]];
        for k in 0..3 {
            for i in 0..3 {
                let row: f64 =
                    (0..3).map(|j| matrix[i][j] / f64::sqrt(moments[i] * moments[j]) * modes[j][k]).sum();
                assert!((row - rates[k] * modes[i][k]).abs() < 1e-14, "mode {k}, row {i}");
            }
        }
        let even = damping([2.0, 4.0, 8.0, 0.0, 0.0, 0.0]).unwrap();
        let even = even.of(0);
        assert_eq!(even.slows_evenly(moments), Some(2.0));
        assert_eq!(even.slows_evenly([1.0, 2.0, 3.0]), None);
    }
}
