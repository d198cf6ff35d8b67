//! What is zero on the surfaces of one kind, inside the last step of each lane.

use super::{NEAR, NOISE, Pointing, Polynomial, Side, Surface, SurfaceKind, TERMS, Zero};
use crate::body::{Body, VERTICAL};
use crate::forces::{BodyForces, MOST_STATES, Orbit, SMALL_STATE, conic_sign};
use crate::inertia::moment_range;
use crate::kernel::{AdaptiveSteps, Group, System};
use crate::kinematics::{cross, length};
use crate::simd::{LANES, Row, set_lane};

impl SurfaceKind {
    /// The scale of the left side of a surface of this kind, without its value; `rate` bounds the rates of the body.
    pub fn scale(&self, surface: &Surface, body: &Body, forces: BodyForces, rate: f64) -> f64 {
        let Surface { normal: [a, b, c, x, y, z], momentum, square, states, .. } = surface;
        let [_, largest] = moment_range(body.moments);
        let of_momentum = length(momentum) * (largest * rate + length(&forces.further.rotor.0));
        let of_speed = square.abs() * rate * rate;
        let of_pointing = if self.pointing.is_some() { 1.0 } else { 0.0 };
        let mut of_states = 0.0;
        for (factor, start) in states.iter().zip(forces.states()) {
            of_states += factor.abs() * start.abs().max(SMALL_STATE[1]);
        }
        let of_rates = length(&[*a, *b, *c]) * rate + length(&[*x, *y, *z]);
        let scale = of_rates + of_momentum + of_speed + of_states + of_pointing;
        if self.of_rate { scale * rate } else { scale }
    }
}

/// A polynomial in the time: coefficients of its powers.
type Powers = [f64; TERMS];

/// The surfaces of one kind, one for each lane, and the polynomial that is zero on each.
pub struct SurfaceFunction {
    kind: SurfaceKind,
    /// The surface of each lane.
    normal: [Row; 6],
    momentum: [Row; 3],
    square: Row,
    states: [Row; MOST_STATES],
    value: Row,
    /// Momentum of a rotor.
    rotor: [Row; 3],
    /// The orbit of each lane.
    orbit: [Orbit<f64>; LANES],
    /// What the state holds: a quaternion, or the space axes 3 and 1 from index 3 on and mostly space axis 2.
    system: System,
    /// The order of products of two polynomials.
    order: usize,
    /// The sides of the surface at the end of the last step; `None` at the start.
    side: [Option<Side>; LANES],
    /// The scale of what is zero on the surface.
    scale: Row,
    /// Coefficients of the powers of the share of the step.
    powers: [Row; TERMS],
    /// The sum of the sizes of all but the first.
    rest: Row,
    /// The slope at the end.
    end_slope: Row,
    /// The unit of time by which the rate is one, or one.
    unit: Row,
    /// Of an angle, what must be positive on the surface: powers of the share of the step.
    second: [Powers; LANES],
}

/// The powers of a number of the state of a lane.
fn powers_of(adaptive: &AdaptiveSteps, d: usize, lane: usize) -> Powers {
    let mut powers = [0.0; TERMS];
    for (power, rows) in powers.iter_mut().zip(&adaptive.powers) {
        *power = rows[d].0[lane];
    }
    powers
}

impl SurfaceFunction {
    /// The surfaces of bodies, of one kind.
    pub fn new(kind: SurfaceKind, system: System, order: usize) -> SurfaceFunction {
        SurfaceFunction {
            kind,
            normal: [Row::ZERO; 6],
            momentum: [Row::ZERO; 3],
            square: Row::ZERO,
            states: [Row::ZERO; MOST_STATES],
            value: Row::ZERO,
            rotor: [Row::ZERO; 3],
            orbit: [Orbit([0.0; 9]); LANES],
            system,
            order,
            side: [None; LANES],
            scale: Row::ZERO,
            powers: [Row::ZERO; TERMS],
            rest: Row::ZERO,
            end_slope: Row::ZERO,
            unit: Row([1.0; LANES]),
            second: [[0.0; TERMS]; LANES],
        }
    }

    /// Puts the surface of a body into a lane; `rate` bounds its rates.
    pub fn enter(&mut self, lane: usize, surface: &Surface, body: &Body, forces: BodyForces, rate: f64) {
        set_lane(&mut self.normal, lane, &surface.normal);
        set_lane(&mut self.momentum, lane, &surface.momentum);
        set_lane(&mut self.rotor, lane, &forces.further.rotor.0);
        self.orbit[lane] = forces.further.orbit;
        set_lane(&mut self.states, lane, &surface.states);
        self.square.0[lane] = surface.square;
        self.value.0[lane] = surface.value;
        self.side[lane] = None;
        self.scale.0[lane] = self.kind.scale(surface, body, forces, rate) + surface.value.abs();
    }

    /// The torque may jump: so may the slope.
    pub fn bend(&mut self, lane: usize) {
        if let Some(side) = &mut self.side[lane] {
            side.rising = None;
        }
    }

    /// The polynomials of the last step. Without fused products, which this code has no instructions for.
    pub fn expand(&mut self, group: &Group, adaptive: &AdaptiveSteps) {
        let of_rate = self.kind.of_rate;
        let mut share = Row::ZERO;
        for lane in 0..LANES {
            share.0[lane] = group.step.0[lane] / adaptive.unit.0[lane];
            self.rest.0[lane] = 0.0;
            self.end_slope.0[lane] = 0.0;
            self.unit.0[lane] = if of_rate { adaptive.unit.0[lane] } else { 1.0 };
        }
        let is_used = |row: &Row| row.0 != [0.0; LANES];
        let (normal, states) = (self.normal.each_ref().map(is_used), self.states.each_ref().map(is_used));
        let of_momentum = self.momentum.iter().any(is_used).then(|| self.along_momentum(group, adaptive));
        let of_speed = is_used(&self.square).then(|| self.along_square(adaptive));
        let of_pointing = self.kind.pointing.map(|pointing| self.along_directions(pointing, group, adaptive));
        let vertical = self.system.turns.then(|| self.vertical(adaptive));
        let mut scale = Row([1.0; LANES]);
        for k in 0..self.terms() {
            let of_state = k + usize::from(of_rate);
            let mut sum = of_momentum.as_ref().map_or([0.0; LANES], |powers| powers[of_state].0);
            for powers in [&of_speed, &of_pointing].into_iter().flatten() {
                for lane in 0..LANES {
                    sum[lane] += powers[of_state].0[lane];
                }
            }
            let known = adaptive.powers.get(of_state);
            for d in (0..6).filter(|&d| normal[d]) {
                let power = match (&vertical, known) {
                    (Some(vertical), _) if d > 2 => &vertical[d - 3][of_state].0,
                    (_, Some(rows)) => &rows[d].0,
                    _ => continue,
                };
                let factor = &self.normal[d].0;
                for lane in 0..LANES {
                    sum[lane] += factor[lane] * power[lane];
                }
            }
            if let (Some(at), Some(rows)) = (self.system.states_at, known) {
                for d in (0..MOST_STATES).filter(|&d| states[d]) {
                    for lane in 0..LANES {
                        sum[lane] += self.states[d].0[lane] * rows[at + d].0[lane];
                    }
                }
            }
            if of_rate {
                sum.iter_mut().for_each(|x| *x *= of_state as f64);
            } else if k == 0 {
                for lane in 0..LANES {
                    sum[lane] -= self.value.0[lane];
                }
            }
            for lane in 0..LANES {
                let term = sum[lane] * scale.0[lane];
                self.powers[k].0[lane] = term;
                if k > 0 {
                    self.rest.0[lane] += term.abs();
                    self.end_slope.0[lane] += k as f64 * term;
                }
                scale.0[lane] *= share.0[lane];
            }
        }
    }

    /// The powers of `momentum . L` in the units of time of the step.
    ///
    /// The product of two series, cut at their order, is the series of the product; of two other polynomials none of
    /// their terms is cut.
    fn along_momentum(&self, group: &Group, adaptive: &AdaptiveSteps) -> [Row; TERMS] {
        let mut sum = [Row::ZERO; TERMS];
        for lane in 0..LANES {
            let along = [0, 1, 2].map(|k| self.momentum[k].0[lane]);
            if along == [0.0; 3] || adaptive.unit.0[lane] == 0.0 {
                continue;
            }
            let direction = match self.system.quaternion_at {
                Some(at) => self.turned_back([0, 1, 2, 3].map(|k| powers_of(adaptive, at + k, lane)), along),
                None => {
                    let axes = self.space_axes(adaptive, lane);
                    [0, 1, 2].map(|k| self.sum(axes.map(|axis| axis[k]), along))
                }
            };
            for k in 0..3 {
                let mut momentum = powers_of(adaptive, k, lane).map(|x| x * group.moments[k].0[lane]);
                momentum[0] += self.rotor[k].0[lane];
                let product = self.product(&direction[k], &momentum);
                (0..=self.order).for_each(|i| sum[i].0[lane] += product[i]);
            }
        }
        sum
    }

    /// The space axes in the body, of a state without a quaternion.
    fn space_axes(&self, adaptive: &AdaptiveSteps, lane: usize) -> [[Powers; 3]; 3] {
        let of = |d: usize| powers_of(adaptive, d, lane);
        let (third, first) = ([3, 4, 5].map(of), [6, 7, 8].map(of));
        let second = match self.system.vectors > 2 {
            true => [9, 10, 11].map(of),
            false => self.cross(&third, &first),
        };
        [first, second, third]
    }

    /// A body axis in space.
    fn in_space(&self, axis: [f64; 3], adaptive: &AdaptiveSteps, lane: usize) -> [Powers; 3] {
        match self.system.quaternion_at {
            // Turned back by the opposite rotation.
            Some(at) => {
                let [w, u @ ..] = [0, 1, 2, 3].map(|k| powers_of(adaptive, at + k, lane));
                let [x, y, z] = u.map(|powers| powers.map(|x| -x));
                self.turned_back([w, x, y, z], axis)
            }
            None => self.space_axes(adaptive, lane).map(|row| self.sum(row, axis)),
        }
    }

    /// The direction from the planet along the semi-axes of the orbit, whose series is a quotient of series.
    fn radial(&self, adaptive: &AdaptiveSteps, lane: usize) -> [Powers; 2] {
        let (orbit, at) = (&self.orbit[lane], self.system.own_at.expect("an orbit has variables"));
        let (e, first, second) =
            (orbit.eccentricity(), powers_of(adaptive, at, lane), powers_of(adaptive, at + 1, lane));
        let (mut radial, mut distance) = ([[0.0; TERMS]; 2], [0.0; TERMS]);
        let sign = conic_sign(e);
        for k in 0..=self.order {
            let one = if k == 0 { 1.0 } else { 0.0 };
            let [cos, sin] = orbit.cos_sin([first[k], second[k]]);
            distance[k] = sign * (one - e * cos);
            for (powers, place) in radial.iter_mut().zip([cos - e * one, sin]) {
                let known = (1..=k).map(|j| distance[j] * powers[k - j]).sum::<f64>();
                powers[k] = (place - known) / distance[0];
            }
        }
        radial
    }

    /// A direction in space.
    fn direction(&self, of: [f64; 3], in_orbit: bool, adaptive: &AdaptiveSteps, lane: usize) -> [Powers; 3] {
        let mut direction = [[0.0; TERMS]; 3];
        if !in_orbit {
            (0..3).for_each(|k| direction[k][0] = of[k]);
            return direction;
        }
        let (orbit, radial) = (&self.orbit[lane], self.radial(adaptive, lane));
        let normal = orbit.normal().expect("there is an orbit");
        for (powers, axis) in radial.iter().zip(orbit.semi_axes()) {
            let along = cross(&normal, &axis);
            for k in 0..3 {
                let factor = of[0] * axis[k] + of[1] * along[k];
                (0..=self.order).for_each(|i| direction[k][i] += factor * powers[i]);
            }
        }
        (0..3).for_each(|k| direction[k][0] += of[2] * normal[k]);
        direction
    }

    /// The powers of the first cosine of a pointing in the units of time of the step; of the rate of an angle the integral
    /// of what is zero with this rate.
    fn along_directions(
        &mut self,
        pointing: Pointing,
        group: &Group,
        adaptive: &AdaptiveSteps,
    ) -> [Row; TERMS] {
        let mut sum = [Row::ZERO; TERMS];
        for lane in (0..LANES).filter(|&lane| group.step.0[lane] != 0.0 && adaptive.unit.0[lane] != 0.0) {
            let cosine = |[axis, direction]: [[f64; 3]; 2]| {
                let axis = self.in_space(axis, adaptive, lane);
                let direction = self.direction(direction, pointing.in_orbit, adaptive, lane);
                self.sum([0, 1, 2].map(|k| self.product(&axis[k], &direction[k])), [1.0; 3])
            };
            let mut first = cosine(pointing.pairs[0]);
            if pointing.is_angle() {
                let mut second = cosine(pointing.pairs[1]);
                if self.kind.of_rate {
                    let (rates, squares) = (self.turned_by(&first, &second), [&first, &second]);
                    second = self.sum(squares.map(|x| self.product(x, x)), [1.0; 2]);
                    first = rates;
                }
                let (share, mut scale) = (group.step.0[lane] / adaptive.unit.0[lane], 1.0);
                for power in &mut second {
                    *power *= scale;
                    scale *= share;
                }
                self.second[lane] = second;
            }
            (0..=self.order).for_each(|i| sum[i].0[lane] = first[i]);
        }
        sum
    }

    /// The integral of `y' x - x' y`.
    fn turned_by(&self, y: &Powers, x: &Powers) -> Powers {
        let mut integral = [0.0; TERMS];
        for i in 1..=self.order {
            for k in 0..=self.order - i {
                integral[i + k] += i as f64 * (y[i] * x[k] - x[i] * y[k]);
            }
        }
        (1..=self.order).for_each(|k| integral[k] /= k as f64);
        integral
    }

    /// The sum of series with factors.
    fn sum<const N: usize>(&self, series: [Powers; N], factors: [f64; N]) -> Powers {
        let mut sum = [0.0; TERMS];
        for (powers, factor) in series.iter().zip(factors) {
            (0..=self.order).for_each(|i| sum[i] += factor * powers[i]);
        }
        sum
    }

    /// The powers of `square |omega|²` in the units of time of the step.
    fn along_square(&self, adaptive: &AdaptiveSteps) -> [Row; TERMS] {
        let mut sum = [Row::ZERO; TERMS];
        // All lanes side by side, and no powers beyond those that are known: this takes longer than the step else.
        let (rows, last) = (&adaptive.powers, adaptive.powers.len() - 1);
        for d in 0..3 {
            for i in 0..=self.order.min(2 * last) {
                let mut product = [0.0; LANES];
                for k in i.saturating_sub(last)..=i.min(last) {
                    let (first, second) = (&rows[k][d].0, &rows[i - k][d].0);
                    for lane in 0..LANES {
                        product[lane] += first[lane] * second[lane];
                    }
                }
                for lane in 0..LANES {
                    sum[i].0[lane] += self.square.0[lane] * product[lane];
                }
            }
        }
        sum
    }

    /// The powers of the vertical in the units of time of the step, from those of a quaternion.
    fn vertical(&self, adaptive: &AdaptiveSteps) -> [[Row; TERMS]; 3] {
        let mut vertical = [[Row::ZERO; TERMS]; 3];
        let at = self.system.quaternion_at.expect("the frame turns with it");
        for lane in 0..LANES {
            if (3..6).all(|d| self.normal[d].0[lane] == 0.0) || adaptive.unit.0[lane] == 0.0 {
                continue;
            }
            let q = [0, 1, 2, 3].map(|k| powers_of(adaptive, at + k, lane));
            for (rows, powers) in vertical.iter_mut().zip(self.turned_back(q, VERTICAL)) {
                rows.iter_mut().zip(powers).for_each(|(row, power)| row.0[lane] = power);
            }
        }
        vertical
    }

    /// A vector of space in the body, whose attitude is a quaternion: `(w² - u²) v + 2 (u.v) u - 2 w u x v`.
    fn turned_back(&self, q: [Powers; 4], v: [f64; 3]) -> [Powers; 3] {
        let squares = q.map(|x| self.product(&x, &x));
        let mut lengths = squares[0];
        let mut along = [0.0; TERMS];
        for i in 0..=self.order {
            lengths[i] -= squares[1][i] + squares[2][i] + squares[3][i];
            along[i] = 2.0 * (v[0] * q[1][i] + v[1] * q[2][i] + v[2] * q[3][i]);
        }
        [0, 1, 2].map(|k| {
            let (next, last) = ((k + 1) % 3, (k + 2) % 3);
            let mut cross = [0.0; TERMS];
            for i in 0..=self.order {
                cross[i] = 2.0 * (q[1 + next][i] * v[last] - q[1 + last][i] * v[next]);
            }
            let (first, second) = (self.product(&along, &q[1 + k]), self.product(&q[0], &cross));
            let mut powers = [0.0; TERMS];
            for i in 0..=self.order {
                powers[i] = v[k] * lengths[i] + first[i] - second[i];
            }
            powers
        })
    }

    /// The vector product of two vectors of series, up to their order.
    fn cross(&self, a: &[Powers; 3], b: &[Powers; 3]) -> [Powers; 3] {
        [0, 1, 2].map(|k| {
            let (next, last) = ((k + 1) % 3, (k + 2) % 3);
            let mut powers = self.product(&a[next], &b[last]);
            let other = self.product(&a[last], &b[next]);
            (0..=self.order).for_each(|i| powers[i] -= other[i]);
            powers
        })
    }

    /// The product of two series, up to their order.
    fn product(&self, a: &Powers, b: &Powers) -> Powers {
        let mut product = [0.0; TERMS];
        for i in 0..=self.order {
            for k in 0..=i {
                product[i] += a[k] * b[i - k];
            }
        }
        product
    }

    /// Number of coefficients.
    fn terms(&self) -> usize {
        self.order + usize::from(!self.kind.of_rate)
    }

    /// What is zero on the surface after so many units of time of the last step of a lane, from the state and its rate of
    /// change, for which `here` has room.
    pub fn value(
        &mut self,
        lane: usize,
        units: f64,
        group: &Group,
        (last, here): (&AdaptiveSteps, &mut AdaptiveSteps),
    ) -> f64 {
        here.unit.0[lane] = last.unit.0[lane];
        for d in 0..self.system.len {
            let polynomial = Polynomial { powers: &powers_of(last, d, lane), noise: 0.0, near: 0.0 };
            (here.powers[0][d].0[lane], here.powers[1][d].0[lane]) = polynomial.value(units);
        }
        self.expand(group, here);
        // No other lane has a unit: nothing long is computed there.
        here.unit.0[lane] = 0.0;
        self.powers[0].0[lane] / self.unit.0[lane]
    }

    /// Finds the wanted zeros of the last step of a lane with their slopes, by the step, and `Point::share`; returns whether
    /// the motion is on the surface all along. `error` is that of the state, relative to its scale.
    pub fn zeros(&mut self, lane: usize, error: f64, found: &mut impl FnMut(Zero, [f64; 2])) -> bool {
        let unit = self.unit.0[lane];
        let scale = self.scale.0[lane] * unit;
        let near = NEAR.max(error) * scale;
        let (begin, rest) = (self.powers[0].0[lane], self.rest.0[lane]);
        let at_once = self.side[lane].is_some_and(|side| side.positive == (begin >= 0.0));
        let rising = Some(self.end_slope.0[lane] >= 0.0);
        if at_once && begin.abs() > rest + near {
            self.side[lane] = Some(Side { positive: begin >= 0.0, rising });
            return false;
        }
        let is_angle = self.kind.pointing.is_some_and(|pointing| pointing.is_angle());
        let second = if is_angle { self.second[lane] } else { [0.0; TERMS] };
        if begin.abs() + rest <= near {
            // On the surface all along: nothing is crossed.
            return !is_angle || second[0] > 0.0;
        }
        let mut powers = [0.0; TERMS];
        for k in 0..self.terms() {
            powers[k] = self.powers[k].0[lane];
        }
        let powers = &powers[..self.terms()];
        let side = self.side[lane].unwrap_or_else(|| Side::after_begin(powers, NOISE * scale));
        let polynomial = Polynomial { powers, noise: NOISE * scale, near };
        let wanted = self.kind.direction;
        let positive = polynomial.zeros(side, &mut |mut zero| {
            let mut share = 1.0;
            if is_angle {
                // Where both cosines are nearly zero the angle leaps.
                share = second.iter().rev().fold(0.0, |sum, power| sum * zero.at + power);
                zero.grazes |= share.abs() <= NEAR;
                if share < 0.0 && !zero.grazes {
                    return;
                }
            }
            if wanted == 0 || zero.direction == 0 || zero.direction == wanted {
                found(zero, [polynomial.value(zero.at).1 / unit, share]);
            }
        });
        self.side[lane] = Some(Side { positive, rising });
        false
    }
}
