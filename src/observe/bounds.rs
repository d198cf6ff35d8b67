//! A scalar of the state that stays on one side of a limit.

use super::inside::{self, Inside, crossing, state};
use super::{
    EXIT_TIME, Observable, Rows, Segment, Start, Update, angle_of, chord2, look_inside, motion_inside, three,
};
use crate::forces::{Orbit, anomaly_cos_sin, conic_sign, is_open};
use crate::kinematics::{cross, direction, dot, half_rows};
use crate::method::{Coefficients, Engine, Variables};
use crate::real::{Apart, Real};
use crate::scene::{FurtherFrame, Layout, Model, Parameters, ROWS_LEN, in_rows};
use crate::special::sincos;
use std::f64::consts::PI;
use std::marker::PhantomData;

/// The observed scalar. An angle is observed as a square, which is accurate for small angles: of the chord
/// `4 sin²(angle / 2)` between two directions, of the distance `8 sin²(angle / 2)` between two attitudes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// The rate about the observed axis.
    Rate,
    /// The length of the rates.
    Speed,
    /// The angle of the rates or of the angular momentum from where they were at the start.
    Turn {
        /// Of the angular momentum, not of the rates.
        of_momentum: bool,
        /// From the direction in space at the start, not from the one in the body.
        in_space: bool,
    },
    /// The angle of the rotation since the start.
    Attitude,
    /// The angle of the observed axis from a direction of the orbit.
    Pointing {
        /// The direction.
        from: Direction,
        /// Of the end of the axis that is nearer to the direction at the start.
        either: bool,
    },
    /// An angle in the frame of the orbit, from either side: by a sequence 3-2-1 from rest, where the observed axis lies
    /// along the line from the planet.
    Angle {
        /// The angle.
        of: Angle,
        /// The body axis that lies along the normal at rest: 1, 2, 3 or -1, -2, -3.
        normal: i32,
    },
}

/// An angle of a body in the frame of its orbit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Angle {
    /// About the axis along the orbit.
    Roll,
    /// About the normal of the orbit.
    Pitch,
    /// About the line from the planet.
    Yaw,
}

/// A direction of the frame of an orbit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// From the planet to the body.
    Radial,
    /// Across it in the plane of the orbit, towards the motion.
    Along,
    /// The normal of the orbit.
    Normal,
}

/// A limit of a quantity, and the side of it on which the quantity stays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound {
    /// The quantity.
    pub quantity: Quantity,
    /// A rate, or an angle (rad).
    pub limit: f64,
    /// Whether the quantity stays below the limit; else above.
    pub below: bool,
    /// The time from which it is observed.
    pub after: f64,
}

impl Bound {
    /// The limit of the scalar, 1 if this is the largest allowed one and -1 if it is the least.
    fn of_scalar(self) -> [f64; 2] {
        let half = sincos(0.5 * self.limit).0;
        let limit = match self.quantity {
            // No angle is larger.
            Quantity::Turn { .. } | Quantity::Attitude if self.below && self.limit >= PI => f64::INFINITY,
            Quantity::Rate | Quantity::Speed => self.limit,
            Quantity::Pointing { .. } | Quantity::Angle { .. } if self.limit >= PI => Bound::NO_CHORD2,
            Quantity::Turn { .. } | Quantity::Pointing { .. } | Quantity::Angle { .. } => 4.0 * half * half,
            Quantity::Attitude => 8.0 * half * half,
        };
        [limit, if self.below { 1.0 } else { -1.0 }]
    }

    /// Whether it is the angle of an axis from a direction of an orbit.
    pub fn is_pointing(&self) -> bool {
        matches!(self.quantity, Quantity::Pointing { .. })
    }

    /// The second body axis that is observed; 0 if there is none.
    pub fn second_axis(&self) -> i32 {
        if let Quantity::Angle { normal, .. } = self.quantity { normal } else { 0 }
    }

    /// More than the square of any distance between two directions.
    const NO_CHORD2: f64 = 5.0;

    /// The largest angle of the observed axis from its direction, or in the frame of the orbit, by the smallest margin; NaN
    /// of another quantity.
    pub fn largest_angle(self, margin: f64) -> f64 {
        if !matches!(self.quantity, Quantity::Pointing { .. } | Quantity::Angle { .. }) {
            return f64::NAN;
        }
        // `max` in `angle_of` ignores a NaN.
        if margin.is_nan() { margin } else { angle_of(self.of_scalar()[0] - margin) }
    }
}

/// A scalar that stays on one side of a limit. The scalar is computed at a few places inside each step and its least
/// margin between them, so a pair of crossings inside a step is seen.
pub struct Bounds;

impl Bounds {
    /// Smallest distance from the limit, negative beyond.
    const MARGIN: usize = 1;
    /// The square of the largest distance between the directions at neighbouring places. A vector that almost vanishes
    /// turns faster than the places can tell.
    const LEAP2: usize = 2;
    /// The time from which on the scalar is inside its limit; infinite while it is not.
    pub const SETTLED: usize = 3;
    /// The limit.
    const LIMIT: usize = 4;
    /// 1 if the scalar stays below the limit, -1 if above.
    const SIDE: usize = 5;
    /// The time from which the scalar is observed.
    const AFTER: usize = 6;
    /// One of the numbers below.
    const KIND: usize = 7;
    /// Whether the angular momentum is observed, not the rates.
    const MOMENTUM: usize = 8;
    /// The observed axis, the direction at the start in the body, or the vertical at the start.
    const AXIS: usize = 9;
    /// The direction at the start in space, or space axis 1 at the start in the body; of an orbit the normal, or the first
    /// of the two semi-axes from which the direction follows.
    const SPACE: usize = 12;
    /// The second semi-axis.
    const SECOND: usize = 15;
    /// Eccentricity and rate of the orbit.
    const ORBIT: usize = 18;
    /// The anomaly at the start, of a body that is integrated over it.
    const ANOMALY: usize = 20;
    /// The second observed axis.
    const ACROSS: usize = 21;
    /// The normal of the orbit, of an angle.
    const ABOUT: usize = 24;

    /// The largest `LEAP2` of a motion that is known well enough: a leap of 1 rad.
    const MOST_LEAP2: f64 = 0.9193953882637205;

    const RATE: f64 = 0.0;
    const SPEED: f64 = 1.0;
    const IN_BODY: f64 = 2.0;
    const IN_SPACE: f64 = 3.0;
    const ATTITUDE: f64 = 4.0;
    const POINTING: f64 = 5.0;
    const NORMAL: f64 = 6.0;
    const PITCH: f64 = 7.0;
    const ROLL: f64 = 8.0;
    const YAW: f64 = 9.0;

    /// Places inside a step at which the scalar is computed, the end among them. A step is at most about 1 rad.
    const PLACES: usize = 4;
}

/// The directions of the space axes in the body: 3, and 1 if the layout has it, and then 2.
#[inline(always)]
fn frame<R: Real, L: Layout, const D: usize>(y: &[R; D]) -> [[R; 3]; 3] {
    let mut axes = [[R::splat(0.0); 3]; 3];
    if const { L::VECTORS > 0 } {
        axes[2] = direction(y, 0);
    }
    if const { L::VECTORS > 1 } {
        axes[0] = direction(y, 1);
        axes[1] = if const { L::VECTORS > 2 } { direction(y, 2) } else { cross(&axes[2], &axes[0]) };
    }
    axes
}

/// A vector of space in the body, from the axes of space there.
#[inline(always)]
fn in_body<R: Real>(v: &[R; 3], [one, two, third]: &[[R; 3]; 3]) -> [R; 3] {
    let mut sum = *one;
    for k in 0..3 {
        sum[k] = one[k].fma(v[0], two[k].fma(v[1], third[k] * v[2]));
    }
    sum
}

/// The orbit whose direction from the planet is the one that is watched: the semi-axes may be others.
#[inline(always)]
fn orbit<R: Real>(rows: &Rows<R>) -> Orbit<R> {
    let ([a1, a2, a3], [b1, b2, b3]) = (three(rows, Bounds::SPACE), three(rows, Bounds::SECOND));
    let (eccentricity, rate) = (rows[Bounds::ORBIT], rows[Bounds::ORBIT + 1]);
    Orbit([rate, eccentricity, R::splat(0.0), a1, a2, a3, b1, b2, b3])
}

/// The direction from the planet that is watched, at the start in the body, from the variables of the orbit and the axes of
/// space.
fn radial_at_start(rows: &Rows<f64>, own: &[f64], [first, second, third]: &[[f64; 3]; 3]) -> [f64; 3] {
    let mut y = [0.0; 14];
    for (at, part) in [(3, third), (6, first), (9, second)] {
        y[at..at + 3].copy_from_slice(part);
    }
    y[12..].copy_from_slice(own);
    orbit(rows).radial(&y, 12)
}

/// The observed vector of a state, its length and its direction: zero, if the vector is.
#[inline(always)]
fn vector<R: Real, const D: usize>(
    variables: Variables,
    p: &Parameters<R>,
    rows: &Rows<R>,
    y: &[R; D],
) -> ([R; 3], R, [R; 3]) {
    let (rates, momentum) = (variables.rates(p, y), variables.momentum(p, y));
    let of_momentum = R::splat(0.5).lt(rows[Bounds::MOMENTUM]);
    let mut v = rates;
    for k in 0..3 {
        v[k] = R::select(of_momentum, momentum[k], rates[k]);
    }
    let size = dot(&v, &v).sqrt();
    let inverse = R::splat(1.0) / size.max(R::splat(f64::MIN_POSITIVE));
    (v, size, [v[0] * inverse, v[1] * inverse, v[2] * inverse])
}

/// Sine and cosine of an angle in the frame of the orbit, or of its opposite, from the direction from the planet and the
/// normal of the orbit in the body.
#[inline(always)]
fn sine_cosine<R: Real>(rows: &Rows<R>, radial: &[R; 3], normal: &[R; 3]) -> [R; 2] {
    let (kind, one) = (rows[Bounds::KIND], R::splat(1.0));
    let (outward, across) = (three(rows, Bounds::AXIS), three(rows, Bounds::ACROSS));
    let ahead = cross(&across, &outward);
    let (up, side, front) = (dot(radial, &outward), dot(radial, &across), dot(radial, &ahead));
    let (turned, along) = (dot(normal, &ahead), dot(&cross(normal, radial), &ahead));
    let is_pitch = kind.lt(R::splat(Bounds::ROLL));
    let is_roll = kind.lt(R::splat(Bounds::YAW));
    let y = R::select(is_pitch, front, R::select(is_roll, side, turned));
    let x = R::select(is_pitch, up.fma(up, side * side).sqrt(), R::select(is_roll, up, along));
    let inverse = one / y.fma(y, x * x).sqrt().max(R::splat(f64::MIN_POSITIVE));
    [y * inverse, x * inverse]
}

/// The square of the chord of this angle.
#[inline(always)]
fn angle2<R: Real>(rows: &Rows<R>, radial: &[R; 3], normal: &[R; 3]) -> R {
    let [sine, cosine] = sine_cosine(rows, radial, normal);
    let less = cosine - R::splat(1.0);
    sine.fma(sine, less * less)
}

/// The direction of a state that may leap between two places: of the observed vector, or of an angle in the frame of the
/// orbit, which swings fast near gimbal lock.
#[inline(always)]
fn leaping<R: Real, L: Layout, const D: usize>(
    variables: Variables,
    p: &Parameters<R>,
    rows: &Rows<R>,
    y: &[R; D],
) -> [R; 3] {
    if const { L::TURNS } {
        return leaping::<R, L::Rows, ROWS_LEN>(variables, p, rows, &in_rows::<L, R, D>(y));
    }
    let (_, _, mut unit) = vector(variables, p, rows, y);
    if const { L::OWN > 0 } {
        let is_angle = R::splat(Bounds::NORMAL).lt(rows[Bounds::KIND]);
        if R::any(is_angle) {
            let normal = in_body(&three(rows, Bounds::ABOUT), &frame::<R, L, D>(y));
            let [sine, cosine] = sine_cosine(rows, &orbit(rows).radial(y, L::OWN_AT), &normal);
            let angle = [sine, cosine, R::splat(0.0)];
            for k in 0..3 {
                unit[k] = R::select(is_angle, angle[k], unit[k]);
            }
        }
    }
    unit
}

/// How far the scalar of a state is inside its limit.
#[inline(always)]
fn margin<R: Real, L: Layout, const D: usize>(
    variables: Variables,
    p: &Parameters<R>,
    rows: &Rows<R>,
    y: &[R; D],
) -> R {
    if const { L::TURNS } {
        return margin::<R, L::Rows, ROWS_LEN>(variables, p, rows, &in_rows::<L, R, D>(y));
    }
    let kind = rows[Bounds::KIND];
    let axis = three(rows, Bounds::AXIS);
    let (v, size, unit) = vector(variables, p, rows, y);
    let mut scalar = R::select(kind.lt(R::splat(Bounds::SPEED)), dot(&v, &axis), size);
    scalar = R::select(R::splat(Bounds::SPEED).lt(kind), chord2(&unit, &axis), scalar);
    if const { L::VECTORS > 1 } {
        let [one, two, third] = frame::<R, L, D>(y);
        let space = three(rows, Bounds::SPACE);
        let mut fixed = in_body(&space, &[one, two, third]);
        scalar = R::select(R::splat(Bounds::IN_BODY).lt(kind), chord2(&unit, &fixed), scalar);
        let turned = chord2(&third, &axis) + chord2(&one, &space) + chord2(&two, &cross(&axis, &space));
        scalar = R::select(R::splat(Bounds::IN_SPACE).lt(kind), turned, scalar);
        if const { L::OWN > 0 } {
            let moving = orbit(rows).radial(y, L::OWN_AT);
            for k in 0..3 {
                fixed[k] = R::select(kind.lt(R::splat(Bounds::NORMAL)), moving[k], fixed[k]);
            }
            scalar = R::select(R::splat(Bounds::ATTITUDE).lt(kind), chord2(&axis, &fixed), scalar);
            let normal = in_body(&three(rows, Bounds::ABOUT), &[one, two, third]);
            scalar = R::select(R::splat(Bounds::NORMAL).lt(kind), angle2(rows, &moving, &normal), scalar);
        }
    }
    (rows[Bounds::LIMIT] - scalar) * rows[Bounds::SIDE]
}

/// States inside a step.
trait Within<R, const D: usize> {
    /// The state at a fraction of the step.
    fn at(&self, fraction: R) -> [R; D];
}

/// Rates, space axes and place of a body that is integrated over the anomaly of its orbit, in the layout [`FurtherFrame`];
/// axis 1 of this space leads to the periapsis, axis 3 is the normal of the orbit.
struct OnOrbit<'a, R, const D: usize> {
    dense: &'a Coefficients<R, D>,
    /// The anomaly at the begin of the step, and the step.
    anomaly: R,
    step: R,
    eccentricity: R,
    rate: R,
}

impl<R: Real, const D: usize> OnOrbit<'_, R, D> {
    #[inline(always)]
    fn seen(&self, fraction: R, y: &[R; D]) -> [R; FRAME] {
        let (one, zero, e) = (R::splat(1.0), R::splat(0.0), self.eccentricity);
        let [cos, sin] = anomaly_cos_sin(e, self.step.fma(fraction, self.anomaly));
        // One over the distance, with the sign of an ellipse or a hyperbola.
        let signed = one / e.fnma(cos, one);
        let near = conic_sign(e) * signed;
        let pace = self.rate * near;
        let place = [(cos - e) * signed, ((one - e) * (one + e)).abs().sqrt() * sin * near];
        let [outward, along, normal] = half_rows(&[y[3], y[4], y[5], y[6]]);
        let [first, second] = plane_axes(&outward, &along, place);
        let mut all = [zero; FRAME];
        for k in 0..3 {
            all[k] = pace * y[k];
            all[3 + k] = normal[k] + normal[k];
            all[6 + k] = first[k] + first[k];
            all[9 + k] = second[k] + second[k];
        }
        let open = is_open(e);
        let half = R::splat(0.5);
        all[FurtherFrame::OWN_AT] = R::select(open, half * (cos + sin), cos);
        all[FurtherFrame::OWN_AT + 1] = R::select(open, half * (cos - sin), sin);
        all
    }
}

/// Length of a state with rates, space axes and place.
const FRAME: usize = FurtherFrame::LEN;

/// The directions of the plane of an orbit that are fixed in space, from those that move, which the cosine and the sine of
/// the true anomaly turn.
#[inline(always)]
fn plane_axes<R: Real>(outward: &[R; 3], along: &[R; 3], [cos, sin]: [R; 2]) -> [[R; 3]; 2] {
    let (mut first, mut second) = (*outward, *along);
    for k in 0..3 {
        first[k] = sin.fnma(along[k], cos * outward[k]);
        second[k] = sin.fma(outward[k], cos * along[k]);
    }
    [first, second]
}

impl<R: Real, const D: usize> Within<R, FRAME> for OnOrbit<'_, R, D> {
    #[inline(always)]
    fn at(&self, fraction: R) -> [R; FRAME] {
        self.seen(fraction, &state(self.dense, fraction))
    }
}

/// By the powers of the fraction of the step.
impl<R: Real, const D: usize> Within<R, D> for Coefficients<R, D> {
    #[inline(always)]
    fn at(&self, fraction: R) -> [R; D] {
        state(self, fraction)
    }
}

/// The margin inside a step.
struct Margin<'a, R, L, W, const D: usize> {
    variables: Variables,
    p: &'a Parameters<R>,
    rows: &'a Rows<R>,
    within: &'a W,
    layout: PhantomData<L>,
}

impl<R: Real, L: Layout, W: Within<R, D>, const D: usize> Inside<R> for Margin<'_, R, L, W, D> {
    #[inline(always)]
    fn at(&self, fraction: R) -> R {
        margin::<R, L, D>(self.variables, self.p, self.rows, &self.within.at(fraction))
    }
}

impl Observable for Bounds {
    const ROWS: usize = 27;
    const CHANGING: usize = 4;

    fn start(start: &Start) -> Rows<f64> {
        let mut rows = super::UNOBSERVED;
        let bound = start.bound.expect("a map gives the bound that is observed");
        if let Some((place, _)) = start.on_orbit {
            rows[Bounds::ANOMALY] = place.anomaly();
            [rows[Bounds::ORBIT], rows[Bounds::ORBIT + 1]] = [place.eccentricity(), place.rate()];
        }
        [rows[Bounds::LIMIT], rows[Bounds::SIDE]] = bound.of_scalar();
        rows[Bounds::AFTER] =
            start.on_orbit.map_or(bound.after, |(place, _)| place.anomaly_until(bound.after));
        rows[Bounds::MARGIN] = f64::INFINITY;
        let put = |rows: &mut Rows<f64>, at: usize, v: [f64; 3]| rows[at..at + 3].copy_from_slice(&v);
        // The frame of the kernel at the start: space axis 3, then 1.
        let [third, first] = start.frame;
        let scalar = match bound.quantity {
            Quantity::Rate => {
                rows[Bounds::KIND] = Bounds::RATE;
                put(&mut rows, Bounds::AXIS, start.unit);
                dot(&start.rates, &start.unit)
            }
            Quantity::Speed => {
                rows[Bounds::KIND] = Bounds::SPEED;
                dot(&start.rates, &start.rates).sqrt()
            }
            Quantity::Turn { of_momentum, in_space } => {
                rows[Bounds::KIND] = if in_space { Bounds::IN_SPACE } else { Bounds::IN_BODY };
                rows[Bounds::MOMENTUM] = f64::from(u8::from(of_momentum));
                let v = if of_momentum { start.momentum } else { start.rates };
                let size = dot(&v, &v).sqrt().max(f64::MIN_POSITIVE);
                let unit = v.map(|x| x / size);
                put(&mut rows, Bounds::AXIS, unit);
                if unit == [0.0; 3] {
                    // Without a direction at the start no limit is passed, and the motion is not known well enough.
                    (rows[Bounds::LIMIT], rows[Bounds::LEAP2]) = (f64::INFINITY, f64::INFINITY);
                }
                let second = cross(&third, &first);
                put(&mut rows, Bounds::SPACE, [dot(&first, &unit), dot(&second, &unit), dot(&third, &unit)]);
                0.0
            }
            Quantity::Attitude => {
                rows[Bounds::KIND] = Bounds::ATTITUDE;
                put(&mut rows, Bounds::AXIS, third);
                put(&mut rows, Bounds::SPACE, first);
                0.0
            }
            Quantity::Angle { of, .. } => {
                rows[Bounds::KIND] = match of {
                    Angle::Roll => Bounds::ROLL,
                    Angle::Pitch => Bounds::PITCH,
                    Angle::Yaw => Bounds::YAW,
                };
                put(&mut rows, Bounds::AXIS, start.unit);
                put(&mut rows, Bounds::ACROSS, start.second_unit);
                let known = start.forces.map(|(forces, _)| forces.further.orbit);
                let orbit = known.and_then(|orbit| Some((orbit, orbit.normal()?)));
                if let Some((place, [outward, _, about])) = &start.on_orbit {
                    let e = place.eccentricity();
                    put(&mut rows, Bounds::SPACE, [conic_sign(e), 0.0, 0.0]);
                    put(&mut rows, Bounds::SECOND, [0.0, ((1.0 - e) * (1.0 + e)).abs().sqrt(), 0.0]);
                    put(&mut rows, Bounds::ABOUT, [0.0, 0.0, 1.0]);
                    angle2(&rows, outward, about)
                } else if let Some((known, normal)) = orbit {
                    let [first_axis, second_axis] = known.semi_axes();
                    put(&mut rows, Bounds::SPACE, first_axis);
                    put(&mut rows, Bounds::SECOND, second_axis);
                    put(&mut rows, Bounds::ABOUT, normal);
                    [rows[Bounds::ORBIT + 1], rows[Bounds::ORBIT]] = [known.0[0], known.0[1]];
                    let axes = [first, cross(&third, &first), third];
                    angle2(&rows, &radial_at_start(&rows, start.own, &axes), &in_body(&normal, &axes))
                } else {
                    // Without an orbit there is no direction, and no limit is passed.
                    rows[Bounds::LIMIT] = f64::INFINITY;
                    0.0
                }
            }
            Quantity::Pointing { from, either } => {
                let is_normal = from == Direction::Normal;
                rows[Bounds::KIND] = if is_normal { Bounds::NORMAL } else { Bounds::POINTING };
                put(&mut rows, Bounds::AXIS, start.unit);
                let known = start.forces.map(|(forces, _)| forces.further.orbit);
                match known.and_then(|orbit| Some((orbit, orbit.normal()?))) {
                    Some((known, normal)) => {
                        let [mut first_axis, mut second_axis] = known.semi_axes();
                        if from == Direction::Along {
                            first_axis = cross(&normal, &first_axis);
                            second_axis = cross(&normal, &second_axis);
                        }
                        put(&mut rows, Bounds::SPACE, if is_normal { normal } else { first_axis });
                        put(&mut rows, Bounds::SECOND, second_axis);
                        [rows[Bounds::ORBIT + 1], rows[Bounds::ORBIT]] = [known.0[0], known.0[1]];
                        let axes = [first, cross(&third, &first), third];
                        let aimed = if is_normal {
                            in_body(&normal, &axes)
                        } else {
                            radial_at_start(&rows, start.own, &axes)
                        };
                        let mut axis = start.unit;
                        if either && dot(&axis, &aimed) < 0.0 {
                            axis = axis.map(|x| -x);
                        }
                        put(&mut rows, Bounds::AXIS, axis);
                        chord2(&axis, &aimed)
                    }
                    // Without an orbit there is no direction, and no limit is passed.
                    None => {
                        rows[Bounds::LIMIT] = f64::INFINITY;
                        0.0
                    }
                }
            }
        };
        if bound.after <= 0.0 {
            rows[Bounds::MARGIN] = (rows[Bounds::LIMIT] - scalar) * rows[Bounds::SIDE];
            rows[Bounds::SETTLED] = if rows[Bounds::MARGIN] < 0.0 { f64::INFINITY } else { 0.0 };
            if rows[Bounds::MARGIN] < 0.0 {
                rows[EXIT_TIME] = 0.0;
            }
        }
        rows
    }

    /// The smallest margin of the scalar; NaN if it may have been smaller between two places.
    fn outcome(rows: &Rows<f64>) -> f64 {
        if rows[Bounds::LEAP2] > Bounds::MOST_LEAP2 { f64::NAN } else { rows[Bounds::MARGIN] }
    }
}

impl<R: Real, M: Model<R>, L: Layout, const D: usize> Update<R, M, L, D> for Bounds {
    /// True for the rates alone, and for rates with a vertical or a frame.
    const FITS: bool =
        L::CLOCK || !L::TANGENT && (L::TURNS || !L::QUATERNION && (L::VECTORS != 1 || M::HEAVY));

    #[inline(always)]
    fn after_step<S: Engine<R, M, L, D>>(
        engine: &S,
        p: &Parameters<R>,
        rows: &mut Rows<R>,
        segment: &Segment<R, D>,
    ) {
        // Of each body; an inactive one has a step of zero.
        let wanted = R::splat(0.0).lt(p.step.abs());
        look_inside::<Bounds, R, M, L, S, D>(engine, p, rows, segment, wanted);
    }

    #[inline(always)]
    fn look<S: Engine<R, M, L, D>>(
        engine: &S,
        p: &Parameters<R>,
        rows: &mut Rows<R>,
        segment: &Segment<R, D>,
    ) {
        let &Segment { begin, before, after, .. } = segment;
        let dense = &motion_inside(engine, p, segment);
        if const { !L::CLOCK } {
            let (ends, layout) = ([before, after], PhantomData::<L>);
            if const { matches!(S::VARIABLES, Variables::Rates) } {
                R::apart(Look::<_, _, _, false, D> { p, rows, begin, ends, within: dense, layout });
            } else {
                R::apart(Look::<_, _, _, true, D> { p, rows, begin, ends, within: dense, layout });
            }
            return;
        }
        let [eccentricity, rate] = [rows[Bounds::ORBIT], rows[Bounds::ORBIT + 1]];
        let anomaly = rows[Bounds::ANOMALY] + begin;
        let within = &OnOrbit { dense, anomaly, step: p.step, eccentricity, rate };
        let [first, last] = [within.seen(R::splat(0.0), before), within.seen(R::splat(1.0), after)];
        let (ends, layout) = ([&first, &last], PhantomData);
        Look::<R, FurtherFrame, _, false, FRAME> { p, rows, begin, ends, within, layout }.run();
    }
}

/// The scalar inside a step, in a function that all engines with the same variables share.
struct Look<'a, R, L, W, const MOMENTA: bool, const D: usize> {
    p: &'a Parameters<R>,
    rows: &'a mut Rows<R>,
    begin: R,
    ends: [&'a [R; D]; 2],
    within: &'a W,
    layout: PhantomData<L>,
}

impl<R: Real, L: Layout, W: Within<R, D>, const MOMENTA: bool, const D: usize> Apart
    for Look<'_, R, L, W, MOMENTA, D>
{
    type Out = ();
    #[inline(always)]
    fn run(self) {
        let Look { p, rows, begin: time, ends: [before, after], within, layout } = self;
        let variables = if MOMENTA { Variables::Momenta } else { Variables::Rates };
        let numbers = *rows;
        let scalar = Margin { variables, p, rows: &numbers, within, layout };
        let (zero, half, one) = (R::splat(0.0), R::splat(0.5), R::splat(1.0));
        let never = R::splat(f64::INFINITY);
        // The observed part of the step. An inactive lane has a step of zero.
        let watched = one.min(((rows[Bounds::AFTER] - time) / p.step).max(zero));
        let span = one - watched;
        let size = span * R::splat(1.0 / Bounds::PLACES as f64);
        // The last three places, the margins there, and the first part of the step that has an end beyond the limit.
        let (mut margins, mut least) = ([never; 3], rows[Bounds::MARGIN]);
        let (mut low, mut high, mut ends) = (zero, zero, [zero; 2]);
        let mut exit = never;
        // The last part of the step at whose end the scalar comes back inside the limit.
        let (mut back, mut entry, mut margins_of_entry) = ([zero; 2], never, [zero, one]);
        let mut unit = leaping::<R, L, D>(variables, p, rows, before);
        let mut leap2 = rows[Bounds::LEAP2];
        for place in 0..=Bounds::PLACES {
            let fraction = size.fma(R::splat(place as f64), watched);
            let y = if place == Bounds::PLACES { *after } else { within.at(fraction) };
            margins = [margins[1], margins[2], margin::<R, L, D>(variables, p, rows, &y)];
            let now_along = leaping::<R, L, D>(variables, p, rows, &y);
            leap2 = leap2.max(chord2(&now_along, &unit));
            unit = now_along;
            let [before_last, last, now] = margins;
            // The minimum of the parabola through three places; its distance before the middle one, in places.
            let bend = (before_last - last) + (now - last);
            let slope = (now - before_last) * half;
            let before_middle = slope / bend;
            let depth = before_middle.fnma(slope * half, last);
            let spread = (before_last - last).abs() + (now - last).abs();
            // A NaN, of the first two places, is no minimum.
            let is_between = R::select(before_middle.abs().lt(R::splat(1.25)), one, zero);
            let is_minimum = R::select(zero.lt(bend), is_between, zero);
            let mut dip = R::select(half.lt(is_minimum), depth, never);
            let mut at = before_middle.fnma(size, fraction - size);
            // The parabola is wrong by a small part of what the scalar changes by: near the limit the minimum is sought.
            // Of a direction of an orbit near the least margin so far too, for its largest angle is told.
            let is_told = R::splat(Bounds::ATTITUDE).lt(rows[Bounds::KIND]);
            let level = R::select(is_told, least.max(zero), zero);
            let near = R::select(spread.fma(half, level).lt(dip), zero, R::select(dip.lt(never), one, zero));
            let near = R::select(exit.lt(never), zero, near);
            if R::any(half.lt(near)) {
                let [first, end] = [fraction - (size + size), fraction];
                let middle = fraction - size;
                at = R::select(half.lt(near), at.max(first).min(end), middle);
                let [place_of_deepest, deepest] =
                    inside::least::<R, 6>(&scalar, [first, end], at, size * half);
                dip = R::select(half.lt(near), deepest, dip);
                at = R::select(half.lt(near), place_of_deepest, at);
                // A pair of crossings: the margin before is not negative, the one at the minimum is.
                let dives = R::select(half.lt(near), R::select(deepest.lt(zero), one, zero), zero);
                let new = R::select(half.lt(dives), one, zero);
                // The last place inside the limit before the minimum.
                let from_middle = R::select(middle.lt(at), R::select(last.lt(zero), zero, one), zero);
                low = R::select(half.lt(new), R::select(half.lt(from_middle), middle, first), low);
                high = R::select(half.lt(new), at, high);
                ends[0] =
                    R::select(half.lt(new), R::select(half.lt(from_middle), last, before_last), ends[0]);
                ends[1] = R::select(half.lt(new), deepest, ends[1]);
                exit = R::select(half.lt(new), at, exit);
                let [next, inside] = [
                    R::select(half.lt(from_middle), fraction, middle),
                    R::select(half.lt(from_middle), now, last),
                ];
                let returns = R::select(half.lt(new), R::select(inside.lt(zero), zero, one), zero);
                back = [R::select(half.lt(returns), at, back[0]), R::select(half.lt(returns), next, back[1])];
                margins_of_entry = [
                    R::select(half.lt(returns), deepest, margins_of_entry[0]),
                    R::select(half.lt(returns), inside, margins_of_entry[1]),
                ];
                entry = R::select(half.lt(returns), next, entry);
            }
            let returns = R::select(last.lt(zero), R::select(now.lt(zero), zero, one), zero);
            back = [
                R::select(half.lt(returns), fraction - size, back[0]),
                R::select(half.lt(returns), fraction, back[1]),
            ];
            margins_of_entry = [
                R::select(half.lt(returns), last, margins_of_entry[0]),
                R::select(half.lt(returns), now, margins_of_entry[1]),
            ];
            entry = R::select(half.lt(returns), fraction, entry);
            least = least.min(now);
            least = R::select(dip.lt(least), dip, least);
            let crosses = R::select(exit.lt(never), zero, R::select(now.lt(zero), one, zero));
            low = R::select(half.lt(crosses), if place == 0 { watched } else { fraction - size }, low);
            high = R::select(half.lt(crosses), fraction, high);
            ends[0] = R::select(half.lt(crosses), if place == 0 { zero } else { last }, ends[0]);
            ends[1] = R::select(half.lt(crosses), now, ends[1]);
            exit = R::select(half.lt(crosses), fraction, exit);
        }
        let (is_back, at_end) = (entry.lt(never), margins[2]);
        if R::any(is_back) {
            // The part of the step the other way round.
            let fraction = crossing(&scalar, [back[1], back[0]], [margins_of_entry[1], margins_of_entry[0]]);
            rows[Bounds::SETTLED] = R::select(is_back, p.step.fma(fraction, time), rows[Bounds::SETTLED]);
        }
        rows[Bounds::SETTLED] = R::select(at_end.lt(zero), never, rows[Bounds::SETTLED]);
        // Before its time, and after the limit was passed, nothing is observed.
        let is_open = R::select(rows[EXIT_TIME].lt(never), zero, R::select(zero.lt(span), one, zero));
        rows[Bounds::MARGIN] = R::select(zero.lt(span), least, rows[Bounds::MARGIN]);
        // Rates and attitudes have no direction that could leap, nor does an axis that points somewhere.
        let kind = rows[Bounds::KIND];
        let leaps = R::select(R::splat(Bounds::NORMAL).lt(kind), one, zero);
        let leaps = R::select(kind.lt(R::splat(Bounds::ATTITUDE)), kind, leaps + leaps);
        rows[Bounds::LEAP2] = R::select(R::splat(Bounds::SPEED).lt(leaps), leap2, zero);
        let leaves = R::select(half.lt(is_open), exit, never).lt(never);
        if R::any(leaves) {
            let fraction = crossing(&scalar, [low, high], [ends[0].max(zero), ends[1]]);
            let at = p.step.fma(fraction, time);
            rows[EXIT_TIME] = R::select(leaves, at, rows[EXIT_TIME]);
        }
    }
}
