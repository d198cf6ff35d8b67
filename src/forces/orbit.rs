//! The gravity gradient on a Keplerian orbit about a point mass: the torque `3 n^2 (a/r)^3 o x I o`, `o` the direction
//! from the planet to the body, which is small beside the orbit (Hughes, Spacecraft Attitude Dynamics, 1986, §8.1). The
//! orbit is given: the rotation does not act on it.
//!
//! With the eccentric anomaly E the position is `(cos E - e) a + sin E b`, `a` and `b` the semi-axes of the ellipse, and
//! the distance is `1 - e cos E`, both in units of the semi-major axis; `E' = n / (1 - e cos E)` (Murray and Dermott,
//! Solar System Dynamics, 1999, §2.4). On a hyperbola cosh and sinh take the place of cos and sin, the semi-axis `a`
//! leads away from the periapsis, and the distance and the mean anomaly `E - e sin E` change their signs (Battin, An
//! Introduction to the Mathematics and Methods of Astrodynamics, 1999, §4.4).

use super::{AtStart, Bounded, Force, Order, Pace, length};
use crate::dual::Dual;
use crate::error::{Error, refuse};
use crate::inertia::moment_range;
use crate::kinematics::{cross, direction, dot, put, to_body_frame};
use crate::real::{Outlined, Real};
use crate::series::{Coefficients, VectorSeries};
use crate::simd::Isa;
use crate::special::{exp, ln, sincos, sinhcosh};

/// The mean motion n, 0 without an orbit; the eccentricity e; the mean anomaly at time 0; the semi-axes in space, in
/// units of the semi-major axis, the first towards the periapsis of an ellipse, away from that of a hyperbola.
///
/// The variables are cosine and sine of the eccentric anomaly of an ellipse, `exp(E) / 2` and `exp(-E) / 2` of a
/// hyperbola: their difference sinh E would round the small one, with which a body comes in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orbit<R>(pub [R; 9]);

/// Coefficients beside those of the state.
pub struct OrbitSeries<R> {
    /// The semi-axes in the body.
    semi_axes: [VectorSeries<R>; 2],
    /// The direction from the planet along the semi-axes `a` and `b`, the second over its length, and `u = a/r`.
    plane: VectorSeries<R>,
    /// `u^2` and `u^3`.
    powers: VectorSeries<R>,
    /// The direction o from the planet in the body.
    directions: VectorSeries<R>,
    /// `u^3 o`.
    pulls: VectorSeries<R>,
}

impl<R: Real> Orbit<R> {
    /// The mean motion.
    #[inline(always)]
    pub fn rate(&self) -> R {
        self.0[0]
    }

    /// The eccentricity.
    #[inline(always)]
    pub fn eccentricity(&self) -> R {
        self.0[1]
    }

    /// See [`is_open`].
    #[inline(always)]
    pub fn is_open(&self) -> R::Mask {
        is_open(self.eccentricity())
    }

    /// See [`conic_sign`].
    #[inline(always)]
    fn sign(&self) -> R {
        conic_sign(self.eccentricity())
    }

    /// Cosine and sine of the eccentric anomaly, from the variables; linear.
    #[inline(always)]
    pub fn cos_sin(&self, [first, second]: [R; 2]) -> [R; 2] {
        let open = self.is_open();
        [R::select(open, first + second, first), R::select(open, first - second, second)]
    }

    /// The semi-axes in space, over the semi-major axis.
    #[inline(always)]
    pub fn semi_axes(&self) -> [[R; 3]; 2] {
        let [.., a1, a2, a3, b1, b2, b3] = self.0;
        [[a1, a2, a3], [b1, b2, b3]]
    }

    /// A vector `x a + y b` in the body, from the space axes of a state, or of one order of it; linear in both.
    #[inline(always)]
    fn in_body<const D: usize>(&self, [x, y]: [R; 2], state: &[R; D]) -> [R; 3] {
        let [a, b] = self.semi_axes();
        let mut part = a;
        for k in 0..3 {
            part[k] = x.fma(a[k], y * b[k]);
        }
        to_body(&part, state)
    }

    /// `u = a/r`, from the cosine of the eccentric anomaly.
    #[inline(always)]
    fn inverse(&self, cos: R) -> R {
        self.sign() / self.eccentricity().fnma(cos, R::splat(1.0))
    }

    /// The direction o from the planet in the body, and `u^3 o`, at a state.
    #[inline(always)]
    fn direction<const D: usize>(&self, y: &[R; D], own: usize) -> [[R; 3]; 2] {
        let [cos, sin] = self.cos_sin([y[own], y[own + 1]]);
        let u = self.inverse(cos);
        let o = self.in_body([(cos - self.eccentricity()) * u, sin * u], y);
        let cube = u * u * u;
        [o, [o[0] * cube, o[1] * cube, o[2] * cube]]
    }

    /// The place in space, over the semi-major axis, from the variables.
    #[inline(always)]
    pub fn place(&self, variables: [R; 2]) -> [R; 3] {
        let [cos, sin] = self.cos_sin(variables);
        let [mut place, b] = self.semi_axes();
        for k in 0..3 {
            place[k] = (cos - self.eccentricity()).fma(place[k], sin * b[k]);
        }
        place
    }

    /// The direction from the planet in the body at a state; see `direction`.
    #[inline(always)]
    pub fn radial<const D: usize>(&self, y: &[R; D], own: usize) -> [R; 3] {
        self.direction(y, own)[0]
    }

    /// Adds the torque from the products `o2 o3`, `o3 o1`, `o1 o2`, times `u^3`; linear.
    #[inline(always)]
    fn add(&self, [i1, i2, i3]: &[R; 3], products: &[R; 3], torque: &mut [R; 3]) {
        let strength = R::splat(3.0) * (self.rate() * self.rate());
        torque[0] = torque[0] + strength * (*i3 - *i2) * products[0];
        torque[1] = torque[1] + strength * (*i1 - *i3) * products[1];
        torque[2] = torque[2] + strength * (*i2 - *i1) * products[2];
    }

    /// The derivatives of the variables by the eccentric anomaly; linear.
    #[inline(always)]
    fn turn(&self, [first, second]: [R; 2]) -> [R; 2] {
        let open = self.is_open();
        [R::select(open, first, -second), R::select(open, -second, first)]
    }
}

/// A vector in space, in the body, from the space axes of a state, or of one order of it; linear in both.
#[inline(always)]
pub(super) fn to_body<R: Real, const D: usize>(v: &[R; 3], state: &[R; D]) -> [R; 3] {
    // The third row of the matrix, the vertical, comes first in the state.
    let (third, first, second) = (direction(state, 0), direction(state, 1), direction(state, 2));
    let mut sum = *v;
    for i in 0..3 {
        sum[i] = v[2].fma(third[i], v[0].fma(first[i], v[1] * second[i]));
    }
    sum
}

/// `a2 b3`, `a3 b1` and `a1 b2`, added to sums.
#[inline(always)]
pub(super) fn add_products<R: Real>(a: &[R; 3], b: &[R; 3], sums: &mut [R; 3]) {
    *sums = [a[1].fma(b[2], sums[0]), a[2].fma(b[0], sums[1]), a[0].fma(b[1], sums[2])];
}

impl<R: Real> Force<R> for Orbit<R> {
    const IN_SPACE: bool = true;
    const VARIABLES: usize = 2;
    type Series = OrbitSeries<R>;

    #[inline(always)]
    fn series() -> OrbitSeries<R> {
        OrbitSeries {
            semi_axes: [VectorSeries::new(), VectorSeries::new()],
            plane: VectorSeries::new(),
            powers: VectorSeries::new(),
            directions: VectorSeries::new(),
            pulls: VectorSeries::new(),
        }
    }

    #[inline(always)]
    fn add_torque<const D: usize>(&self, moments: &[R; 3], y: &[R; D], own: usize, torque: &mut [R; 3]) {
        let [o, pull] = self.direction(y, own);
        let mut products = [R::splat(0.0); 3];
        add_products(&pull, &o, &mut products);
        self.add(moments, &products, torque);
    }

    #[inline(always)]
    fn add_order<const D: usize>(
        &self,
        moments: &[R; 3],
        c: &Coefficients<R, D>,
        Order { k, own, factor }: Order<R>,
        OrbitSeries { semi_axes: [first_axis, second_axis], plane, powers, directions, pulls }: &mut OrbitSeries<R>,
        next: &mut [R; D],
        torque: &mut [R; 3],
    ) {
        // SAFETY of all blocks: the calls for the orders 0 to k - 1, one each and ascending, have pushed the rows 0 to
        // k - 1, and this call pushes each row k before it reads the row.
        let zero = R::splat(0.0);
        let row = c.order(k);
        let mut sums = [zero; 2];
        for j in 1..k + 1 {
            // SAFETY: as above.
            let [.., u] = unsafe { *plane.order(k - j) };
            let row = c.order(j);
            sums = [row[own].fma(u, sums[0]), row[own + 1].fma(u, sums[1])];
        }
        let u = if k == 0 {
            self.inverse(self.cos_sin([row[own], row[own + 1]])[0])
        } else {
            let [cos, _] = self.cos_sin(sums);
            // SAFETY: as above.
            let [.., first] = unsafe { *plane.order(0) };
            self.sign() * self.eccentricity() * first * cos
        };
        let begin = c.order(0);
        sums = [begin[own].fma(u, sums[0]), begin[own + 1].fma(u, sums[1])];
        let ([of_first, of_second], rate) = (self.turn(sums), self.rate());
        put(next, own, [factor * (rate * of_first), factor * (rate * of_second)]);
        let [cos, sin] = self.cos_sin(sums);
        plane.push(k, [self.eccentricity().fnma(u, cos), sin, u]);

        let [a, b] = self.semi_axes();
        first_axis.push(k, to_body(&a, row));
        second_axis.push(k, to_body(&b, row));
        let (mut o, mut square, mut cube) = ([zero; 3], zero, zero);
        for j in 0..k + 1 {
            // SAFETY: as above.
            let ([x, y, u], [.., v]) = unsafe { (*plane.order(j), *plane.order(k - j)) };
            // SAFETY: as above.
            let (a, b) = unsafe { (first_axis.order(k - j), second_axis.order(k - j)) };
            for i in 0..3 {
                o[i] = x.fma(a[i], y.fma(b[i], o[i]));
            }
            square = u.fma(v, square);
        }
        for j in 1..k + 1 {
            // SAFETY: as above.
            let ([.., u], [v, ..]) = unsafe { (*plane.order(j), *powers.order(k - j)) };
            cube = u.fma(v, cube);
        }
        // SAFETY: as above.
        let [.., first] = unsafe { *plane.order(0) };
        powers.push(k, [square, first.fma(square, cube), zero]);
        directions.push(k, o);

        let (mut pull, mut products) = ([zero; 3], [zero; 3]);
        for j in 0..k + 1 {
            // SAFETY: as above.
            let ([_, cube, _], o) = unsafe { (*powers.order(j), directions.order(k - j)) };
            for i in 0..3 {
                pull[i] = cube.fma(o[i], pull[i]);
            }
        }
        pulls.push(k, pull);
        for j in 0..k + 1 {
            // SAFETY: as above.
            let (pull, o) = unsafe { (pulls.order(j), directions.order(k - j)) };
            add_products(pull, o, &mut products);
        }
        self.add(moments, &products, torque);
    }

    #[inline(always)]
    fn change<const D: usize>(&self, y: &[R; D], own: usize, change: &mut [R; D]) {
        let u = self.inverse(self.cos_sin([y[own], y[own + 1]])[0]);
        let ([of_first, of_second], rate) = (self.turn([y[own] * u, y[own + 1] * u]), self.rate());
        put(change, own, [rate * of_first, rate * of_second]);
    }

    /// With `M = n t + M0 = E - e sin E` the eccentric anomaly changes by `u (dn t + dM0 + sin E de)`; on a hyperbola
    /// sin E de has another sign.
    #[inline(always)]
    fn vary<const D: usize>(&self, by: &Self, time: R, own: usize, y: &mut [Dual<R>; D]) {
        let variables = [y[own].value, y[own + 1].value];
        let [cos, sin] = self.cos_sin(variables);
        let mean = by.rate().fma(time, by.0[2] + by.eccentricity() * (self.sign() * sin));
        let (anomaly, turned) = (mean * self.inverse(cos), self.turn(variables));
        (y[own].slope, y[own + 1].slope) = (turned[0] * anomaly, turned[1] * anomaly);
    }
}

/// Whether an orbit with this eccentricity is a hyperbola.
#[inline(always)]
pub fn is_open<R: Real>(eccentricity: R) -> R::Mask {
    R::splat(1.0).lt(eccentricity)
}

/// The sign of `1 - e`: 1 of an ellipse, -1 of a hyperbola.
#[inline(always)]
pub fn conic_sign<R: Real>(eccentricity: R) -> R {
    let one = R::splat(1.0);
    R::select(is_open(eccentricity), -one, one)
}

/// Cosine and sine of an eccentric anomaly, hyperbolic on a hyperbola.
#[inline(always)]
pub fn anomaly_cos_sin<R: Real>(eccentricity: R, anomaly: R) -> [R; 2] {
    let open = is_open(eccentricity);
    let (mut sin, mut cos) = sincos(anomaly);
    if R::any(open) {
        let (sinh, cosh) = sinhcosh(anomaly);
        (sin, cos) = (R::select(open, sinh, sin), R::select(open, cosh, cos));
    }
    [cos, sin]
}

impl Orbit<f64> {
    /// Rounds the rate otherwise, by more than the rates of a body: one that turns with its orbit does so no longer. And
    /// the mean anomaly, by a rounding of the eccentric one, with which all runs begin. A body at the periapsis stays. Far
    /// out on a hyperbola a rounding of the place is as many times as long as the mean anomaly, and two runs may share those
    /// of their steps by chance: 1000 add up at random to 32.
    pub fn round_otherwise(&mut self, sign: f64) {
        let unit = sign * f64::EPSILON;
        self.0[0] *= 1.0 + 3.0 * unit;
        let mean = self.0[2];
        self.0[2] += unit * mean.clamp(-1.0, 1.0);
        if self.is_open() {
            self.0[2] += 32.0 * unit * mean;
        }
    }

    /// Makes a change of an orbit that of the same orbit whose time begins then: its mean anomaly grows with the time.
    pub fn begin_at(&mut self, time: f64) {
        self.0[2] = self.0[0].mul_add(time, self.0[2]);
    }

    /// The normal of the orbit in space, if there is one.
    pub fn normal(&self) -> Option<[f64; 3]> {
        let [a, b] = self.semi_axes();
        let normal = cross(&a, &b);
        let length = self.sign() * dot(&normal, &normal).sqrt();
        (!self.is_none()).then(|| normal.map(|x| x / length))
    }

    /// The semi-minor axis over the semi-major one: `sqrt |1 - e^2|`.
    pub fn semi_minor(&self) -> f64 {
        let e = self.eccentricity();
        ((1.0 - e) * (1.0 + e)).abs().sqrt()
    }

    /// The distance at the periapsis.
    pub fn periapsis(&self) -> f64 {
        (1.0 - self.eccentricity()).abs()
    }

    /// The distance where the cosine of the anomaly is known.
    fn distance_at(&self, cos: f64) -> f64 {
        self.sign() * self.eccentricity().mul_add(-cos, 1.0)
    }

    /// The rate at which the direction turns at a distance, `n sqrt |1 - e^2| (a/r)^2`.
    fn turning(&self, distance: f64) -> f64 {
        self.rate() * self.semi_minor() / (distance * distance)
    }

    /// The pace of the anomaly by which a step of the time becomes one of the anomaly, where the distance is at most this: the
    /// mean motion, with which an ellipse has as many steps of either kind; on a hyperbola the slowest, so that no step takes
    /// longer.
    pub fn pace(&self, farthest: f64) -> f64 {
        if self.is_open() { self.rate() / farthest } else { self.rate() }
    }

    /// The distance at the apoapsis, or the largest one of a hyperbola in a range of times.
    pub fn farthest(&self, range: [f64; 2]) -> f64 {
        if !self.is_open() {
            return 1.0 + self.eccentricity();
        }
        let [first, last] = range.map(|time| anomaly_cos_sin(self.eccentricity(), self.anomaly_at(time))[0]);
        self.distance_at(first.max(last))
    }

    /// The eccentric anomaly over the mean anomaly.
    fn eccentric_anomaly(&self, mean: f64) -> f64 {
        if self.eccentricity() > 0.0 {
            Isa::widest().call_with_fma(Kepler { eccentricity: self.eccentricity(), mean })
        } else {
            mean
        }
    }
}

/// The growth of the mean anomaly where the eccentric one grows: `d - e (sin(E + d) - sin E)` without cancellation, of an
/// ellipse.
#[inline(always)]
fn mean_growth(e: f64, anomaly: f64, growth: f64) -> f64 {
    let half = 0.5 * growth;
    let ([cos, _], [_, sin]) = (anomaly_cos_sin(e, anomaly + half), anomaly_cos_sin(e, half));
    let grown = (2.0 * e * cos).mul_add(-sin, growth);
    conic_sign(e) * grown
}

/// The growth of an eccentric anomaly from that of the mean one, by two of Newton's steps: it is known to rounding of the
/// anomaly.
struct Growth {
    eccentricity: f64,
    anomaly: f64,
    mean: f64,
    growth: f64,
}

impl Outlined for Growth {
    type Out = f64;
    #[inline(always)]
    fn run(self) -> f64 {
        let Growth { eccentricity: e, anomaly, mean, mut growth } = self;
        for _ in 0..2 {
            let slope = e.mul_add(-anomaly_cos_sin(e, anomaly + growth)[0], 1.0).abs();
            growth -= (mean_growth(e, anomaly, growth) - mean) / slope;
        }
        growth
    }
}

/// Kepler's equation, by Newton's steps inside brackets: `E - e sin E - M` ascends, and so does `e sinh E - E - M`.
struct Kepler {
    eccentricity: f64,
    mean: f64,
}

impl Kepler {
    /// Numbers below and above the anomaly, and one to begin with.
    #[inline(always)]
    fn brackets(&self) -> [f64; 3] {
        let (e, mean) = (self.eccentricity, self.mean);
        if e < 1.0 {
            return [mean - e, mean + e, mean];
        }
        // `(e - 1) sinh E` is nearer to zero than M, `e sinh E` is not; wider by rounding.
        let [near, far] = [mean / e, mean / (e - 1.0)].map(area_sinh);
        let (low, high) = if mean < 0.0 { (far, near) } else { (near, far) };
        let wider = 1e-12 * (1.0 + far.abs());
        [low - wider, high + wider, near]
    }
}

/// The number whose sinh is known.
#[inline(always)]
fn area_sinh(x: f64) -> f64 {
    ln(x.abs() + x.mul_add(x, 1.0).sqrt()).copysign(x)
}

impl Outlined for Kepler {
    type Out = f64;
    #[inline(always)]
    fn run(self) -> f64 {
        let (e, mean) = (self.eccentricity, self.mean);
        let [mut low, mut high, mut anomaly] = self.brackets();
        let sign = conic_sign(e);
        // 64 halvings leave nothing; Newton's steps end long before.
        for _ in 0..64 {
            let [cos, sin] = anomaly_cos_sin(e, anomaly);
            let miss = e.mul_add(-sin, anomaly - sign * mean) * sign;
            if miss > 0.0 {
                high = anomaly;
            } else {
                low = anomaly;
            }
            let mut next = anomaly - miss / (e.mul_add(-cos, 1.0) * sign);
            // Before the brackets, which a step that changes nothing does not leave.
            if next == anomaly {
                break;
            }
            if !(low < next && next < high) {
                next = 0.5 * (low + high);
            }
            if next == anomaly {
                break;
            }
            anomaly = next;
        }
        anomaly
    }
}

impl Bounded for Orbit<f64> {
    fn check(&self) -> Result<(), Error> {
        if self.is_none() {
            return Ok(());
        }
        let e = self.eccentricity();
        let [closed, open] = Orbit::OF_PARABOLA;
        if !(0.0..=closed).contains(&e) && !(open..=Orbit::MOST_ECCENTRIC).contains(&e) {
            let rule = "must be from 0 to 0.95, or from 1.05 to 1e6: near a parabola the anomaly does not tell the place";
            return refuse("eccentricity", e, rule);
        }
        let ([a, b], minor) = (self.semi_axes(), self.semi_minor());
        let off = [dot(&a, &a) - 1.0, dot(&b, &b) / (minor * minor) - 1.0, dot(&a, &b) / minor];
        if off.iter().any(|x| x.abs() > 1e-12) {
            let rule = "must be a unit vector across the normal of the orbit";
            return refuse("periapsis", format_args!("{a:?}"), rule);
        }
        Ok(())
    }

    fn is_none(&self) -> bool {
        self.rate() == 0.0
    }

    fn drives(&self) -> bool {
        !self.is_none()
    }

    fn strength(&self, moments: [f64; 3]) -> f64 {
        let [least, largest] = moment_range(moments);
        let left = self.periapsis();
        1.5 * self.rate() * self.rate() * (largest - least) / (left * left * left * least.sqrt())
    }

    /// In the frame of a circular orbit the Jacobi integral is constant: the kinetic energy of the rates in this frame
    /// and the potential `n^2 (3 o.Io - N.IN) / 2 - n N.h`, N along the normal, h the momentum of a rotor. On an eccentric
    /// orbit nothing is constant. The bound is that of a circle on which the direction turns as at the periapsis, with
    /// the whole depth of the potential, and with the changes of the rate of the frame as further rates.
    fn reach(&self, start: &AtStart, root: f64) -> [f64; 2] {
        let Some(normal) = self.normal() else { return [root, 0.0] };
        let (moments, wheel) = (&start.moments, length(&start.rotor));
        let [least, largest] = moment_range(start.moments);
        // On a hyperbola the direction turns as slowly as the body is far.
        let farthest = if self.is_open() { f64::INFINITY } else { 1.0 + self.eccentricity() };
        let [fastest, slowest] = [self.periapsis(), farthest].map(|distance| self.turning(distance));
        let mut variables = [0.0; 2];
        self.start(0.0, &mut variables);
        let [cos, sin] = self.cos_sin(variables);
        let (distance, [a, b]) = (self.distance_at(cos), self.semi_axes());
        let place = [0, 1, 2].map(|k| ((cos - self.eccentricity()) * a[k] + sin * b[k]) / distance);
        let [n, o] = [normal, place].map(|axis| to_body_frame(&start.attitude, &axis));
        let now = self.turning(distance);
        let twice = |v: &[f64; 3]| (0..3).map(|k| moments[k] * v[k] * v[k]).sum::<f64>();
        let relative = twice(&[0, 1, 2].map(|k| start.omega[k] - now * n[k]));
        let others = (root * root - twice(&start.omega)).max(0.0);
        let depth = if self.eccentricity() == 0.0 {
            let of_rotor = 2.0 * fastest * (wheel - dot(&n, &start.rotor));
            fastest * fastest * (3.0 * (twice(&o) - least) + (largest - twice(&n))) + of_rotor
        } else {
            4.0 * fastest * fastest * (largest - least) + 4.0 * fastest * wheel
        };
        let changes = (fastest - slowest) * largest.sqrt();
        let begin = (relative + others).sqrt() + changes;
        [(begin * begin + depth.max(0.0)).sqrt(), fastest * largest.sqrt()]
    }

    /// Near a periapsis a series in time converges up to `arcosh(1/e) - sqrt(1 - e^2)` over n, which is 1.3 over the rate
    /// there: less than that of a rotation, which is pi/2 over its rate. A circle adds nothing. On a hyperbola the way to the
    /// distance zero is `sqrt(e^2 - 1) - arccos(1/e)` over n, from 1.3 down to 1 over the rate.
    fn step_rate(&self, _pace: &Pace) -> f64 {
        let fastest = self.turning(self.periapsis());
        if self.is_open() { 0.6 * fastest } else { 0.2 * (fastest - self.rate()) }
    }

    fn start(&self, time: f64, variables: &mut [f64]) {
        // Of a body on no orbit: Kepler's equation takes as long as many steps.
        if self.is_none() && self.0[2] == 0.0 {
            variables[..2].copy_from_slice(&[1.0, 0.0]);
            return;
        }
        let mean = self.rate().mul_add(time, self.0[2]);
        variables[..2].copy_from_slice(&self.variables_at(self.eccentric_anomaly(mean)));
    }
}

impl Orbit<f64> {
    /// The eccentric anomaly at a time.
    pub fn anomaly_at(&self, time: f64) -> f64 {
        self.eccentric_anomaly(self.rate().mul_add(time, self.0[2]))
    }

    /// The variables at an eccentric anomaly.
    fn variables_at(&self, anomaly: f64) -> [f64; 2] {
        if self.is_open() {
            let up = 0.5 * exp(anomaly);
            return [up, 0.25 / up];
        }
        let (sin, cos) = sincos(anomaly);
        [cos, sin]
    }

    /// The variables at an eccentric anomaly, times e: with which steps over the anomaly tell the place.
    pub fn clock_at(&self, anomaly: f64) -> [f64; 2] {
        self.variables_at(anomaly).map(|variable| self.eccentricity() * variable)
    }

    /// The growth of an eccentric anomaly in a time. On a slow orbit it is small beside the anomaly, and the difference of
    /// two anomalies would round it.
    pub fn anomaly_in(&self, time: f64, anomaly: f64) -> f64 {
        let (e, mean) = (self.eccentricity(), self.rate() * time);
        if e == 0.0 {
            return mean;
        }
        let begin = e.mul_add(-anomaly_cos_sin(e, anomaly)[1], anomaly) * self.sign();
        let growth = self.eccentric_anomaly(begin + mean) - anomaly;
        Isa::widest().call_with_fma(Growth { eccentricity: e, anomaly, mean, growth })
    }

    /// The time in which an eccentric anomaly grows by so much.
    pub fn time_of(&self, growth: f64, anomaly: f64) -> f64 {
        mean_growth(self.eccentricity(), anomaly, growth) / self.rate()
    }
}

impl Orbit<f64> {
    /// The largest eccentricity of an ellipse, and the least of a hyperbola.
    pub const OF_PARABOLA: [f64; 2] = [0.95, 1.05];
    /// The largest eccentricity.
    pub const MOST_ECCENTRIC: f64 = 1e6;
}
