//! A body at its start, its way into a lane of a group and back.

use crate::body::Inertia;
use crate::group::{Group, MAX_STATE};
use crate::kernel::{Compiled, Kernel, System, Table, Watch};
use crate::method::{Form, Method};
use crate::model::{Drive, Parameters, cross, dot, quaternion_product, seen_from_body};
use crate::observe::tilt;
use crate::outside::Outside;
use crate::special::sincos;

/// One body with its start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Principal moments.
    pub moments: [f64; 3],
    /// `mgl com`, zero for a free body.
    pub weight: [f64; 3],
    /// Rates in the body at the start.
    pub omega: [f64; 3],
    /// Attitude at the start: unit quaternion, scalar first, body to space.
    pub attitude: [f64; 4],
}

/// The vertical of space.
const VERTICAL: [f64; 3] = [0.0, 0.0, 1.0];

impl Body {
    /// The vertical seen from the body at the start.
    #[inline(always)]
    pub fn vertical(&self) -> [f64; 3] {
        seen_from_body(&self.attitude, &VERTICAL)
    }

    /// Whether the centre of mass lies on this body axis.
    pub fn is_weighed_along(&self, axis: usize) -> bool {
        self.weight[axis] != 0.0 && self.weight[(axis + 1) % 3] == 0.0 && self.weight[(axis + 2) % 3] == 0.0
    }

    /// Whether the two moments across this axis are equal, to the bit.
    pub fn is_symmetric_about(&self, axis: usize) -> bool {
        self.moments[(axis + 1) % 3] == self.moments[(axis + 2) % 3]
    }

    /// 1 - cos of the angle between the upward vertical and the centre of mass on this axis.
    pub fn depth(&self, axis: usize) -> f64 {
        let vertical = self.vertical()[axis];
        1.0 - if self.weight[axis] < 0.0 { -vertical } else { vertical }
    }

    /// A bound of |omega| over the whole motion, from what is conserved.
    ///
    /// Each component is bounded by the energy, `omega_k^2 <= 2 T / I_k`, where a top can gain the fall from
    /// upright. A free body is held tighter by its polhode, a symmetric top by its constant spin.
    pub fn fastest_rate(&self) -> f64 {
        let twice_kinetic: f64 = (0..3).map(|k| self.moments[k] * self.omega[k] * self.omega[k]).sum();
        let mgl = self.weight.iter().map(|c| c * c).sum::<f64>().sqrt();
        if mgl == 0.0 {
            return self.polhode_bounds(twice_kinetic).iter().sum::<f64>().sqrt();
        }
        let vertical = self.vertical();
        let height: f64 = (0..3).map(|k| self.weight[k] * vertical[k]).sum();
        let reach = twice_kinetic + 2.0 * (mgl + height).max(0.0);
        let squares: f64 = match self.lagrange_axis() {
            Some(k) => {
                let spin2 = self.omega[k] * self.omega[k];
                spin2 + (reach - self.moments[k] * spin2) / self.moments[(k + 1) % 3]
            }
            None => (0..3).map(|k| reach / self.moments[k]).sum(),
        };
        // A top also swings: the pendulum frequency is a rate even if nothing turns yet.
        let smallest = self.moments.iter().fold(f64::INFINITY, |a, &b| a.min(b));
        squares.max(mgl / smallest).sqrt()
    }

    /// The same under what acts from outside, between two times around 0.
    pub fn fastest_rate_driven(&self, outside: &Outside, span: [f64; 2]) -> f64 {
        let twice_kinetic: f64 = (0..3).map(|k| self.moments[k] * self.omega[k] * self.omega[k]).sum();
        let mgl = self.weight.iter().map(|c| c * c).sum::<f64>().sqrt();
        let vertical = self.vertical();
        let height: f64 = (0..3).map(|k| self.weight[k] * vertical[k]).sum();
        outside.fastest_rate(self.moments, [twice_kinetic, mgl, (mgl + height).max(0.0)], span)
    }

    /// The rate that the steps of a scheme follow: how fast the body turns, and, if it is explicit, how fast damping
    /// slows it.
    pub fn step_rate(&self, method: Method, outside: Option<&Outside>, span: [f64; 2]) -> f64 {
        let Some(outside) = outside else { return self.fastest_rate() };
        if method.damping_limit() == Some(f64::INFINITY) {
            return self.fastest_rate_driven(outside, span);
        }
        let [.., slowing] = outside.damping_rates(self.moments);
        let turning = self.fastest_rate_driven(outside, span);
        (turning * turning + slowing * slowing).sqrt()
    }

    /// The axis (0, 1, 2) of the smallest moment.
    fn smallest_moment(&self) -> usize {
        (1..3).fold(0, |s, k| if self.moments[k] < self.moments[s] { k } else { s })
    }

    /// The axis about which a top is symmetric with its centre of mass on it: its spin is then constant.
    fn lagrange_axis(&self) -> Option<usize> {
        (0..3).find(|&k| {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            self.is_symmetric_about(k) && self.weight[i] == 0.0 && self.weight[j] == 0.0
        })
    }

    /// Bounds of the squared rates of a free body. With sorted moments, `D1 = L^2 - 2 T I1` and
    /// `D3 = 2 T I3 - L^2`, formed without cancellation, bound every component (Landau & Lifshitz §37).
    fn polhode_bounds(&self, twice_kinetic: f64) -> [f64; 3] {
        let mut order = [0, 1, 2];
        order.sort_by(|&a, &b| self.moments[a].total_cmp(&self.moments[b]));
        let [i1, i2, i3] = order.map(|k| self.moments[k]);
        let [w1, w2, w3] = order.map(|k| self.omega[k]);
        let d1 = i2 * (i2 - i1) * w2 * w2 + i3 * (i3 - i1) * w3 * w3;
        let d3 = i1 * (i3 - i1) * w1 * w1 + i2 * (i3 - i2) * w2 * w2;
        // A denominator of zero gives no bound.
        let least = |bound: f64, numerator: f64, denominator: f64| {
            if denominator > 0.0 { bound.min(numerator / denominator) } else { bound }
        };
        let mut bounds = [twice_kinetic / i1, twice_kinetic / i2, twice_kinetic / i3];
        bounds[0] = least(bounds[0], d3, i1 * (i3 - i1));
        bounds[1] = least(least(bounds[1], d3, i2 * (i3 - i2)), d1, i2 * (i2 - i1));
        bounds[2] = least(bounds[2], d1, i3 * (i3 - i1));
        bounds
    }
}

/// How a body is laid into a kernel: the table, and the cyclic renaming of the body axes that the table wants.
///
/// A cyclic renaming is exact. Kernel axis i is body axis (i + turn) mod 3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seat {
    /// Which table moves it.
    pub table: Table,
    /// The renaming.
    turn: usize,
    /// Of a top that is moved in its spin-free frame: the moment about the symmetry axis.
    spin_moment: Option<f64>,
}

impl Seat {
    /// The seat of a body, in its own frame.
    ///
    /// The rotor wants the symmetry axis third; the planar rotations want the smallest moment first: in the
    /// middle of the sequence it costs a factor of four to eight in the error.
    pub fn of(method: Method, body: &Body, is_top: bool) -> Seat {
        use Table::*;
        let (symmetric, any) = match method {
            Method::Rk4 => return Seat::as_is(Rk4),
            // Without damping nothing is stiff: an exponential method is then one of its order.
            Method::Etd4 => return Seat::as_is(Rk4),
            Method::Dop853 => return Seat::as_is(Dop853),
            Method::Taylor8 => return Seat::as_is(Taylor8),
            Method::Taylor12 => return Seat::as_is(Taylor12),
            Method::Taylor16 => return Seat::as_is(Taylor16),
            Method::Taylor20 => return Seat::as_is(Taylor20),
            Method::Taylor26 => return Seat::as_is(Taylor26),
            Method::Midpoint => (Midpoint, Midpoint),
            Method::Splitting => (Rotor, Planar),
            Method::Splitting4 => (Rotor4, Planar4),
            Method::Splitting6 => (Rotor6, Planar6),
            Method::Splitting8 => (Rotor8, Planar8),
            Method::Chin4a => (Chin4a, DmvChin4a),
            Method::Srkn6 => (Srkn6, DmvSrkn6),
            Method::Srkn11 => (Srkn11, DmvSrkn11),
            Method::Srkn14 => (Srkn14, DmvSrkn14),
            Method::Pmlf4 => (Pmlf4, DmvPmlf4),
            Method::Pmlf6 => (Pmlf6, DmvPmlf6),
            Method::Dmv2 => (Rotor, Dmv2),
            Method::Dmv4 => (Rotor, Dmv4),
            Method::Dmv6 => (Rotor, Dmv6),
            Method::Dmv8 => (Rotor, Dmv8),
            Method::Dmv10 => (Rotor, Dmv10),
        };
        let (table, turn) = match Inertia::new(body.moments).ok().and_then(Inertia::symmetry_axis) {
            Some(axis) => (symmetric, (axis + 1) % 3),
            None => (any, body.smallest_moment()),
        };
        let table = if is_top { table } else { table.without_weight() };
        Seat { table, turn, spin_moment: None }
    }

    /// The seat of a body that something acts on from outside: in the axes of the user.
    pub fn of_driven(method: Method, body: &Body) -> Seat {
        match method {
            Method::Splitting => Seat::as_is(Table::Affine),
            Method::Etd4 => Seat::as_is(Table::Etd4),
            _ => Seat { turn: 0, spin_moment: None, ..Seat::of(method, body, true) },
        }
    }

    /// In the axes of the user.
    fn as_is(table: Table) -> Seat {
        Seat { table, turn: 0, spin_moment: None }
    }

    /// The seat of a body whose path alone is wanted: a Lagrange top leaves its spin out, if the method can.
    pub fn of_path(method: Method, body: &Body, is_top: bool) -> Seat {
        let seat = Seat::of(method, body, is_top);
        match body
            .lagrange_axis()
            .filter(|_| is_top && seat.table.moves(System::SpinFreeAxis) && body.weight != [0.0; 3])
        {
            Some(axis) => Seat { turn: (axis + 1) % 3, spin_moment: Some(body.moments[axis]), ..seat },
            None => seat,
        }
    }

    /// Whether the spin is left out.
    pub fn is_spin_free(self) -> bool {
        self.spin_moment.is_some()
    }

    /// Moments and rates in the variables of the kernel.
    fn lay(self, body: &Body) -> ([f64; 3], [f64; 3]) {
        let (moments, omega) = (self.rename(body.moments), self.rename(body.omega));
        match self.spin_moment {
            Some(moment) => ([moments[0]; 3], [omega[0], omega[1], omega[2] * (moment / moments[0])]),
            None => (moments, omega),
        }
    }

    #[inline(always)]
    fn rename(self, [a, b, c]: [f64; 3]) -> [f64; 3] {
        match self.turn {
            0 => [a, b, c],
            1 => [b, c, a],
            _ => [c, a, b],
        }
    }

    #[inline(always)]
    fn restore(self, [a, b, c]: [f64; 3]) -> [f64; 3] {
        match self.turn {
            0 => [a, b, c],
            1 => [c, a, b],
            _ => [b, c, a],
        }
    }
}

/// A state read back from a lane, in the user's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Rates in the body.
    pub omega: [f64; 3],
    /// The first direction carried, if there is one.
    pub direction: Option<[f64; 3]>,
    /// Attitude, if it is carried.
    pub attitude: Option<[f64; 4]>,
    /// Whether the attitude could as well have the other sign: it was made from rows of its matrix.
    pub sign_is_free: bool,
    /// Energy and conserved momentum, with the arithmetic of the kernel.
    pub invariants: [f64; 2],
    /// The same of a top with the vertical that the attitude says, where both are carried: the two may part.
    pub invariants_of_attitude: Option<[f64; 2]>,
    /// Of a body that something acts on from outside.
    pub balance: Option<Balance>,
}

/// What came from outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Balance {
    /// Work of torque and damping since the start.
    pub work: f64,
    /// What the energy and the conserved momentum have grown to: added to their scales.
    pub scales: [f64; 2],
}

/// Scales of the energy and of the conserved momentum: what a drift is relative to.
///
/// A free body: its energy, and `2 L.L` for `L.L` (so that the number is that of |L|). A top: kinetic energy
/// plus `mgl`, and |L| plus `sqrt(mgl I_max)`: the invariants themselves may vanish.
pub fn invariant_scales(body: &Body, is_top: bool) -> [f64; 2] {
    let momentum = [0, 1, 2].map(|k| body.moments[k] * body.omega[k]);
    let momentum2 = dot(&momentum, &momentum);
    let kinetic: f64 = (0..3).map(|k| 0.5 * body.moments[k] * body.omega[k] * body.omega[k]).sum();
    let mgl = body.weight.iter().map(|c| c * c).sum::<f64>().sqrt();
    if is_top {
        let largest = body.moments.iter().fold(0.0_f64, |a, &b| a.max(b));
        [kinetic + mgl, momentum2.sqrt() + (mgl * largest).sqrt()]
    } else {
        [kinetic, 2.0 * momentum2]
    }
}

/// The state of a body in the variables of a kernel.
fn kernel_state(system: System, seat: Seat, body: &Body, watched_axis: [f64; 3]) -> [f64; MAX_STATE] {
    let mut y = [0.0; MAX_STATE];
    let (moments, omega) = seat.lay(body);
    for k in 0..3 {
        y[k] = match seat.table.form() {
            Form::Rates => omega[k],
            Form::Momenta => moments[k] * omega[k],
        };
    }
    match system {
        System::FreeRates | System::FreeAttitude | System::DrivenRates => {}
        System::DrivenFrame => {
            let seen = |axis: [f64; 3]| seat.rename(seen_from_body(&body.attitude, &axis));
            y[3..6].copy_from_slice(&seat.rename(body.vertical()));
            y[6..9].copy_from_slice(&seen([1.0, 0.0, 0.0]));
            y[9..12].copy_from_slice(&seen([0.0, 1.0, 0.0]));
        }
        System::FreeAxis if watched_axis == [0.0; 3] => {
            y[3..6].copy_from_slice(&seat.rename(body.vertical()));
        }
        System::FreeAxis => y[3..6].copy_from_slice(&watched_axis),
        System::TopAxis
        | System::TopAttitude
        | System::TopTwoAxes
        | System::SpinFreeAxis
        | System::SpinFreeTwoAxes
        | System::SpinFreeAttitude => {
            y[3..6].copy_from_slice(&seat.rename(body.vertical()));
            if system.has_rows() {
                let second = match watched_axis {
                    [0.0, 0.0, 0.0] => seat.rename(seen_from_body(&body.attitude, &[1.0, 0.0, 0.0])),
                    watched => watched,
                };
                y[6..9].copy_from_slice(&second);
            }
        }
    }
    if let Some(at) = system.quaternion_at() {
        let [w, x, y1, z] = body.attitude;
        y[at] = w;
        y[at + 1..at + 4].copy_from_slice(&seat.rename([x, y1, z]));
    }
    y
}

/// Puts a body into a lane, ready for its first step. `watched` is the signed body axis to watch, 1, 2, 3 or
/// -1, -2, -3, or 0 for none. The direction that a free body carries is where that axis starts, or the vertical.
pub fn load(
    group: &mut Group,
    lane: usize,
    (kernel, compiled): (Kernel, Compiled),
    seat: Seat,
    body: &Body,
    watched: i32,
    step: f64,
) {
    let axis = watched.unsigned_abs() as usize;
    let mut unit = [0.0; 3];
    if axis > 0 {
        unit[axis - 1] = f64::from(watched.signum());
    }
    let unit = seat.rename(unit);
    let y = kernel_state(kernel.system, seat, body, unit);
    let parameters = Parameters { moments: seat.lay(body).0, weight: seat.rename(body.weight), step };
    for d in 0..kernel.system.len() {
        group.state[d].0[lane] = y[d];
        group.carry[d].0[lane] = 0.0;
    }
    for k in 0..3 {
        group.moments[k].0[lane] = parameters.moments[k];
        group.weight[k].0[lane] = parameters.weight[k];
        group.axis[k].0[lane] = unit[k];
    }
    group.step.0[lane] = step;
    group.count.0[lane] = 0.0;

    let [energy, momentum] = compiled.invariants(&parameters, &y);
    let moves = body.omega.iter().chain(&body.weight).any(|&x| x != 0.0);
    let [energy_scale, momentum_scale] = invariant_scales(body, kernel.system.is_top());
    for (rows, start, scale) in
        [(&mut group.energy, energy, energy_scale), (&mut group.momentum, momentum, momentum_scale)]
    {
        rows.start.0[lane] = start;
        // Of a body that cannot move nothing can drift; a scale that underflowed leaves the drift a NaN.
        rows.inverse_scale.0[lane] = if moves { 1.0 / scale } else { 0.0 };
        rows.worst.0[lane] = 0.0;
    }

    group.unit.0[lane] = 0.0;
    group.side.0[lane] = if axis > 0 { f64::from(watched.signum()) * side(body, axis - 1) } else { 0.0 };
    group.flips.0[lane] = 0.0;
    group.left.0[lane] = f64::INFINITY;
    group.cosine.0[lane] = 1.0;
    group.sine2.0[lane] = 0.0;
    if kernel.watch == Watch::Tilt {
        // The direction that a tilt is measured from is the last one carried, of a frame the vertical.
        let at = if kernel.system.is_driven() { 3 } else { kernel.system.len() - 3 };
        let [cosine, sine2] = tilt(&unit, &[y[at], y[at + 1], y[at + 2]]);
        group.cosine.0[lane] = cosine;
        group.sine2.0[lane] = sine2;
    }
}

/// Lets the time of a driven body, in which its torque is given, begin.
pub fn start_clock(group: &mut Group, kernel: Kernel, lane: usize) {
    let time = kernel.system.len() - 1;
    group.state[time].0[lane] = 0.0;
    group.carry[time].0[lane] = 0.0;
}

/// Lets the drifts of a driven body in a lane be relative to what it can gain too, being as fast as this.
pub fn widen_scales(group: &mut Group, lane: usize, system: System, body: &Body, rate: f64) {
    let least = body.moments.iter().fold(f64::INFINITY, |a, &b| a.min(b));
    let momentum = body.moments.iter().fold(0.0_f64, |a, &b| a.max(b)) * rate;
    let momentum = if system.is_top() { momentum } else { 2.0 * momentum * momentum };
    for (rows, gain) in [(&mut group.energy, 0.5 * least * rate * rate), (&mut group.momentum, momentum)] {
        let inverse = rows.inverse_scale.0[lane];
        let scale = if inverse > 0.0 && inverse.is_finite() { 1.0 / inverse } else { 0.0 };
        rows.inverse_scale.0[lane] = if scale + gain > 0.0 { 1.0 / (scale + gain) } else { 0.0 };
    }
}

/// The side of zero that a component starts on; on zero, the side that it is about to enter.
fn side(body: &Body, k: usize) -> f64 {
    let value = if body.omega[k] == 0.0 {
        rates_soon(body, &Drive::none(), body.fastest_rate())[k]
    } else {
        body.omega[k]
    };
    if value < 0.0 { -1.0 } else { 1.0 }
}

/// The same of a driven body in a lane, as fast as `rate`, watched along a signed axis.
pub fn enter_side(group: &mut Group, lane: usize, body: &Body, watched: i32, drive: &Drive<f64>, rate: f64) {
    let axis = watched.unsigned_abs() as usize;
    if axis > 0 && body.omega[axis - 1] == 0.0 {
        let value = rates_soon(body, drive, rate)[axis - 1];
        group.side.0[lane] = f64::from(watched.signum()) * if value < 0.0 { -1.0 } else { 1.0 };
    }
}

/// The rates, times a time in which a body as fast as `rate` turns by a thousandth of a radian, after that time: by
/// their Taylor series, since the first derivatives may vanish too (a top released at rest).
fn rates_soon(body: &Body, drive: &Drive<f64>, rate: f64) -> [f64; 3] {
    const TERMS: usize = 6;
    let time = 1e-3 / rate;
    let (i, c) = (body.moments, body.weight.map(|c| c * time * time));
    let (mut w, mut n) = ([[0.0; 3]; TERMS], [[0.0; 3]; TERMS]);
    w[0] = body.omega.map(|rate| rate * time);
    n[0] = body.vertical();
    // Torques in space, seen from the body, turn like its vertical.
    let seen = |torque: &[f64; 3]| seen_from_body(&body.attitude, torque).map(|x| x * time * time);
    let (mut steady, mut rising) = ([[0.0; 3]; TERMS], [[0.0; 3]; TERMS]);
    (steady[0], rising[0]) = (seen(&drive.space[0]), seen(&drive.space[1]).map(|x| x * time));
    let own = [drive.body[0].map(|x| x * time * time), drive.body[1].map(|x| x * time * time * time)];
    let [d11, d22, d33, d23, d31, d12] = drive.damping.map(|d| d * time);
    let damping = [[d11, d12, d31], [d12, d22, d23], [d31, d23, d33]];
    let mut sum = w[0];
    for m in 0..TERMS - 1 {
        let order = (m + 1) as f64;
        for x in 0..3 {
            let (y, z) = ((x + 1) % 3, (x + 2) % 3);
            let mut torque = n[m][y] * c[z] - n[m][z] * c[y] + steady[m][x] - dot(&damping[x], &w[m]);
            torque += if m < 2 { own[m][x] } else { 0.0 };
            torque += if m > 0 { rising[m - 1][x] } else { 0.0 };
            for a in 0..=m {
                torque += (i[y] - i[z]) * w[a][y] * w[m - a][z];
            }
            w[m + 1][x] = torque / i[x] / order;
            for row in [&mut n, &mut steady, &mut rising] {
                let mut turning = 0.0;
                for a in 0..=m {
                    turning += row[a][y] * w[m - a][z] - row[a][z] * w[m - a][y];
                }
                row[m + 1][x] = turning / order;
            }
            sum[x] += w[m + 1][x];
        }
    }
    sum
}

/// Reads a lane back, `time` after its start.
pub fn unload(group: &Group, lane: usize, kernel: (Kernel, Compiled), seat: Seat, time: f64) -> State {
    let mut y = [0.0; MAX_STATE];
    for d in 0..kernel.0.system.len() {
        y[d] = group.state[d].0[lane];
    }
    read(group, lane, kernel, seat, y, time)
}

/// Reads `y`, a state of the body in that lane `time` after its start.
pub fn read(
    group: &Group,
    lane: usize,
    (kernel, compiled): (Kernel, Compiled),
    seat: Seat,
    mut y: [f64; MAX_STATE],
    time: f64,
) -> State {
    let at = |rows: &[crate::group::Row; 3]| [rows[0].0[lane], rows[1].0[lane], rows[2].0[lane]];
    let moments = at(&group.moments);
    let parameters = Parameters { moments, weight: at(&group.weight), step: 0.0 };
    let invariants = compiled.invariants(&parameters, &y);
    let quaternion = kernel.system.quaternion_at();
    let in_rows = kernel.system.has_rows();
    let row = |y: &[f64; MAX_STATE], at: usize| [y[at], y[at + 1], y[at + 2]];
    // Of a quaternion the axes of space are renamed with those of the body.
    let carried = match quaternion {
        Some(at) => Some(([y[at], y[at + 1], y[at + 2], y[at + 3]], seat.rename(VERTICAL))),
        None => in_rows.then(|| (attitude_of_rows(&row(&y, 6), &row(&y, 3)), VERTICAL)),
    };
    let invariants_of_attitude = carried.filter(|_| kernel.system.is_top()).map(|(q, vertical)| {
        let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
        let mut of_attitude = y;
        of_attitude[3..6].copy_from_slice(&seen_from_body(&q.map(|x| x / length), &vertical));
        compiled.invariants(&parameters, &of_attitude)
    });
    if seat.table.form() == Form::Momenta {
        for k in 0..3 {
            y[k] /= moments[k];
        }
    }
    if let Some(moment) = seat.spin_moment {
        add_spin(&mut y, quaternion, moments[0] / moment, time);
    }
    let omega = [y[0], y[1], y[2]];
    let balance = kernel.system.is_driven().then(|| {
        let work = y[kernel.system.len() - 3];
        let momentum = [0, 1, 2].map(|k| moments[k] * omega[k]);
        let momentum2 = dot(&momentum, &momentum);
        let scale = if in_rows { momentum2.sqrt() } else { 2.0 * momentum2 };
        Balance { work, scales: [0.5 * dot(&momentum, &omega) + work.abs(), scale] }
    });
    State {
        omega: seat.restore([y[0], y[1], y[2]]),
        direction: kernel.system.has_direction().then(|| seat.restore([y[3], y[4], y[5]])),
        attitude: match quaternion {
            Some(at) => {
                let [x, y1, z] = seat.restore(row(&y, at + 1));
                Some([y[at], x, y1, z])
            }
            None => in_rows.then(|| attitude_of_rows(&seat.restore(row(&y, 6)), &seat.restore(row(&y, 3)))),
        },
        sign_is_free: in_rows,
        invariants,
        invariants_of_attitude,
        balance,
    }
}

/// The quaternion of the rotation matrix whose first and third row these are, up to its sign (Shepperd 1978: the
/// largest component comes from a square root, the others from differences over it).
fn attitude_of_rows(first: &[f64; 3], third: &[f64; 3]) -> [f64; 4] {
    let second = cross(third, first);
    let [r0, r1, r2] = [first, &second, third];
    let squares = [
        1.0 + r0[0] + r1[1] + r2[2],
        1.0 + r0[0] - r1[1] - r2[2],
        1.0 - r0[0] + r1[1] - r2[2],
        1.0 - r0[0] - r1[1] + r2[2],
    ];
    let [wx, wy, wz] = [r2[1] - r1[2], r0[2] - r2[0], r1[0] - r0[1]];
    let [yz, zx, xy] = [r2[1] + r1[2], r0[2] + r2[0], r1[0] + r0[1]];
    let largest = (1..4).fold(0, |best, k| if squares[k] > squares[best] { k } else { best });
    let q = match largest {
        0 => [squares[0], wx, wy, wz],
        1 => [wx, squares[1], xy, zx],
        2 => [wy, xy, squares[2], yz],
        _ => [wz, zx, yz, squares[3]],
    };
    let scale = 0.5 / squares[largest].sqrt();
    q.map(|x| x * scale)
}

/// From the spin-free frame into the body: `ratio` is I1 / I3.
fn add_spin(y: &mut [f64; MAX_STATE], quaternion: Option<usize>, ratio: f64, time: f64) {
    // (1/I3 - 1/I1) L3, with L3 = I1 y3.
    let angle = (ratio - 1.0) * y[2] * time;
    let (s, c) = sincos(angle);
    for at in [0, 3, 6].into_iter().filter(|&at| quaternion != Some(at)) {
        let (a, b) = (y[at], y[at + 1]);
        y[at] = c * a + s * b;
        y[at + 1] = c * b - s * a;
    }
    y[2] *= ratio;
    if let Some(at) = quaternion {
        let (s, c) = sincos(0.5 * angle);
        let q = [y[at], y[at + 1], y[at + 2], y[at + 3]];
        y[at..at + 4].copy_from_slice(&quaternion_product(&q, &[c, 0.0, 0.0, s]));
    }
}
