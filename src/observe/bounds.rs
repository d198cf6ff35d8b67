//! A scalar of the state that stays on one side of a limit.

use super::inside::{self, Bracket, Inside, state};
use super::{
    EXIT_TIME, Observable, Rows, Segment, Start, Update, angle_of, chord2, look_inside, motion_inside, three,
};
use crate::forces::{Orbit, anomaly_cos_sin, conic_sign, is_open};
use crate::kinematics::{cross, direction, dot, half_rows, put};
use crate::method::{Coefficients, Engine, Variables};
use crate::real::{Outlined, Real};
use crate::scene::{FurtherFrame, Layout, Model, Parameters, ROWS_LEN, in_rows};
use crate::special::sincos;
use std::f64::consts::PI;
use std::marker::PhantomData;

/// The observed scalar. An angle is observed as a square, which is accurate for small angles: of the chord
/// `4 sin²(angle / 2)` between two directions, of the distance `8 sin²(angle / 2)` between two attitudes; of the sine of a
/// pitch, which is smooth where the pitch turns back at a right angle.
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

/// A scalar that stays on one side of a limit. The scalar is computed at a few places inside each step and its least
/// margin between them, so a pair of crossings inside a step is seen.
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

impl Quantity {
    /// Whether a direction may leap between two places: of the observed vector, or of a roll or a yaw, which swing fast near
    /// gimbal lock. Rates and attitudes have no direction that could, nor does an axis that points somewhere, as that of a
    /// pitch does.
    fn may_leap(self) -> bool {
        matches!(self, Quantity::Turn { .. } | Quantity::Angle { of: Angle::Roll | Angle::Yaw, .. })
    }

    /// Whether it is seen from the orbit. Then the largest angle is told.
    fn is_of_orbit(self) -> bool {
        matches!(self, Quantity::Pointing { .. } | Quantity::Angle { .. })
    }
}

impl Bound {
    /// Smallest distance from the limit, negative beyond.
    const MARGIN: usize = 1;
    /// The square of the largest distance between the directions at neighbouring places. A vector that almost vanishes
    /// turns faster than the places can tell.
    const LEAP2: usize = 2;
    /// The time from which on the scalar is inside its limit; infinite while it is not.
    pub const SETTLED: usize = 3;
    /// The limit of the scalar; infinite for none.
    const LIMIT: usize = 4;
    /// The time, or the anomaly, from which the scalar is observed.
    const AFTER: usize = 5;
    /// The observed axis, the direction at the start in the body, or the vertical at the start.
    const AXIS: usize = 6;
    /// The direction at the start in space, or space axis 1 at the start in the body; of an orbit the first of the two
    /// semi-axes from which the direction follows.
    const SPACE: usize = 9;
    /// The second semi-axis.
    const SECOND: usize = 12;
    /// The normal of the orbit.
    const NORMAL: usize = 15;
    /// Eccentricity and rate of the orbit.
    const ORBIT: usize = 18;
    /// The anomaly at the start, of a body that is integrated over it.
    const ANOMALY: usize = 20;
    /// The second observed axis.
    const ACROSS: usize = 21;

    /// The largest `LEAP2` of a motion that is known well enough: a leap of 1 rad.
    const MOST_LEAP2: f64 = 0.9193953882637205;

    /// Places inside a step at which the scalar is computed, the end among them. A step is at most about 1 rad.
    const PLACES: usize = 4;

    /// More than the square of any distance between two directions.
    const NO_CHORD2: f64 = 5.0;

    /// The limit of the scalar.
    fn limit_of_scalar(self) -> f64 {
        let half = sincos(0.5 * self.limit).0;
        match self.quantity {
            // No angle is larger.
            Quantity::Turn { .. } | Quantity::Attitude if self.below && self.limit >= PI => f64::INFINITY,
            Quantity::Rate | Quantity::Speed => self.limit,
            Quantity::Angle { of: Angle::Pitch, .. } if self.limit >= 0.5 * PI => Bound::NO_CHORD2,
            Quantity::Angle { of: Angle::Pitch, .. } => sincos(self.limit).0.powi(2),
            Quantity::Pointing { .. } | Quantity::Angle { .. } if self.limit >= PI => Bound::NO_CHORD2,
            Quantity::Turn { .. } | Quantity::Pointing { .. } | Quantity::Angle { .. } => 4.0 * half * half,
            Quantity::Attitude => 8.0 * half * half,
        }
    }

    /// 1 if the limit is the largest allowed scalar, -1 if it is the least.
    fn side(self) -> f64 {
        if self.below { 1.0 } else { -1.0 }
    }

    /// The largest angle of the observed axis from its direction, or in the frame of the orbit, by the smallest margin; NaN
    /// of another quantity.
    pub fn largest_angle(self, margin: f64) -> f64 {
        // `max` in `angle_of` ignores a NaN.
        if !self.quantity.is_of_orbit() || margin.is_nan() {
            return f64::NAN;
        }
        let scalar = self.limit_of_scalar() - margin;
        match self.quantity {
            Quantity::Angle { of: Angle::Pitch, .. } => scalar.clamp(0.0, 1.0).sqrt().asin(),
            _ => angle_of(scalar),
        }
    }

    /// The scalar at the start of an axis or an angle in the frame of an orbit, whose numbers it writes. Without an orbit
    /// there is no direction, and no limit is passed.
    fn start_on_orbit(self, start: &Start, rows: &mut Rows<f64>) -> f64 {
        let [third, first] = start.frame;
        let axes = [first, cross(&third, &first), third];
        let (mut semi_axes, normal, mut seen);
        if let Some((place, [outward, _, about])) = &start.on_orbit {
            let e = place.eccentricity();
            semi_axes = [[conic_sign(e), 0.0, 0.0], [0.0, ((1.0 - e) * (1.0 + e)).abs().sqrt(), 0.0]];
            (normal, seen) = ([0.0, 0.0, 1.0], Some([*outward, *about]));
        } else {
            let orbit = start.forces.map(|(forces, _)| forces.further.orbit);
            let Some((orbit, about)) = orbit.and_then(|orbit| Some((orbit, orbit.normal()?))) else {
                rows[Bound::LIMIT] = f64::INFINITY;
                return 0.0;
            };
            [rows[Bound::ORBIT + 1], rows[Bound::ORBIT]] = [orbit.0[0], orbit.0[1]];
            (semi_axes, normal, seen) = (orbit.semi_axes(), about, None);
        }
        if let Quantity::Pointing { from: Direction::Along, .. } = self.quantity {
            semi_axes = semi_axes.map(|axis| cross(&normal, &axis));
        }
        put(rows, Bound::SPACE, semi_axes[0]);
        put(rows, Bound::SECOND, semi_axes[1]);
        put(rows, Bound::NORMAL, normal);
        let seen =
            seen.get_or_insert_with(|| [radial_at_start(rows, start.own, &axes), in_body(&normal, &axes)]);
        let Quantity::Pointing { from, either } = self.quantity else {
            put(rows, Bound::ACROSS, start.second_unit);
            return square_of_turn(self.quantity, sine_cosine(self.quantity, rows, seen));
        };
        let aimed = seen[usize::from(from == Direction::Normal)];
        if either && dot(&start.unit, &aimed) < 0.0 {
            put(rows, Bound::AXIS, start.unit.map(|x| -x));
        }
        chord2(&three(rows, Bound::AXIS), &aimed)
    }
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

/// The orbit whose direction from the planet is the one that is observed: the semi-axes may be others.
#[inline(always)]
fn orbit<R: Real>(rows: &Rows<R>) -> Orbit<R> {
    let ([a1, a2, a3], [b1, b2, b3]) = (three(rows, Bound::SPACE), three(rows, Bound::SECOND));
    let (eccentricity, rate) = (rows[Bound::ORBIT], rows[Bound::ORBIT + 1]);
    Orbit([rate, eccentricity, R::splat(0.0), a1, a2, a3, b1, b2, b3])
}

/// The direction from the planet that is observed, at the start in the body, from the variables of the orbit and the axes of
/// space.
fn radial_at_start(rows: &Rows<f64>, own: &[f64], [first, second, third]: &[[f64; 3]; 3]) -> [f64; 3] {
    let mut y = [0.0; 14];
    for (at, part) in [(3, third), (6, first), (9, second)] {
        y[at..at + 3].copy_from_slice(part);
    }
    y[12..].copy_from_slice(own);
    orbit(rows).radial(&y, 12)
}

/// Sine and cosine of an angle in the frame of the orbit, or of its opposite, from the direction from the planet and the
/// normal of the orbit in the body.
#[inline(always)]
fn sine_cosine<R: Real>(quantity: Quantity, rows: &Rows<R>, [radial, normal]: &[[R; 3]; 2]) -> [R; 2] {
    let (outward, across) = (three(rows, Bound::AXIS), three(rows, Bound::ACROSS));
    let ahead = cross(&across, &outward);
    let (up, side) = (dot(radial, &outward), dot(radial, &across));
    let [y, x] = match quantity {
        Quantity::Angle { of: Angle::Pitch, .. } => [dot(radial, &ahead), up.fma(up, side * side).sqrt()],
        Quantity::Angle { of: Angle::Roll, .. } => [side, up],
        _ => [dot(normal, &ahead), dot(&cross(normal, radial), &ahead)],
    };
    let inverse = R::splat(1.0) / y.fma(y, x * x).sqrt().max(R::splat(f64::MIN_POSITIVE));
    [y * inverse, x * inverse]
}

/// The square of the chord of an angle with this sine and cosine, or of the sine of a pitch.
#[inline(always)]
fn square_of_turn<R: Real>(quantity: Quantity, [sine, cosine]: [R; 2]) -> R {
    if let Quantity::Angle { of: Angle::Pitch, .. } = quantity {
        return sine * sine;
    }
    let less = cosine - R::splat(1.0);
    sine.fma(sine, less * less)
}

/// The scalar of a state, and the direction that may leap, if there is one.
#[inline(always)]
fn scalar<R: Real, L: Layout, const D: usize>(
    quantity: Quantity,
    variables: Variables,
    p: &Parameters<R>,
    rows: &Rows<R>,
    y: &[R; D],
) -> (R, [R; 3]) {
    if const { L::TURNS } {
        return scalar::<R, L::Rows, ROWS_LEN>(quantity, variables, p, rows, &in_rows::<L, R, D>(y));
    }
    let axis = three(rows, Bound::AXIS);
    match quantity {
        Quantity::Rate => (dot(&variables.rates(p, y), &axis), axis),
        Quantity::Speed => {
            let rates = variables.rates(p, y);
            (dot(&rates, &rates).sqrt(), axis)
        }
        Quantity::Turn { of_momentum, in_space } => {
            let v = if of_momentum { variables.momentum(p, y) } else { variables.rates(p, y) };
            // The direction of a vector that vanishes is zero.
            let inverse = R::splat(1.0) / dot(&v, &v).sqrt().max(R::splat(f64::MIN_POSITIVE));
            let unit = [v[0] * inverse, v[1] * inverse, v[2] * inverse];
            let mut from = axis;
            if in_space {
                from = in_body(&three(rows, Bound::SPACE), &frame::<R, L, D>(y));
            }
            (chord2(&unit, &from), unit)
        }
        Quantity::Attitude => {
            let ([one, two, third], first) = (frame::<R, L, D>(y), three(rows, Bound::SPACE));
            (chord2(&third, &axis) + chord2(&one, &first) + chord2(&two, &cross(&axis, &first)), axis)
        }
        Quantity::Pointing { from: Direction::Normal, .. } => {
            let normal = in_body(&three(rows, Bound::NORMAL), &frame::<R, L, D>(y));
            (chord2(&axis, &normal), axis)
        }
        Quantity::Pointing { .. } if const { L::OWN > 0 } => {
            (chord2(&axis, &orbit(rows).radial(y, L::OWN_AT)), axis)
        }
        Quantity::Angle { .. } if const { L::OWN > 0 } => {
            let normal = in_body(&three(rows, Bound::NORMAL), &frame::<R, L, D>(y));
            let seen = [orbit(rows).radial(y, L::OWN_AT), normal];
            let [sine, cosine] = sine_cosine(quantity, rows, &seen);
            (square_of_turn(quantity, [sine, cosine]), [sine, cosine, R::splat(0.0)])
        }
        // No orbit.
        _ => (R::splat(0.0), axis),
    }
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

/// How far the scalar is inside its limit.
struct Margin<'a, R, L, W, const MOMENTA: bool, const D: usize> {
    bound: Bound,
    p: &'a Parameters<R>,
    rows: &'a Rows<R>,
    within: &'a W,
    layout: PhantomData<L>,
}

impl<R: Real, L: Layout, W: Within<R, D>, const MOMENTA: bool, const D: usize>
    Margin<'_, R, L, W, MOMENTA, D>
{
    /// The margin of a state, and the direction that may leap.
    #[inline(always)]
    fn of(&self, y: &[R; D]) -> (R, [R; 3]) {
        let variables = if MOMENTA { Variables::Momenta } else { Variables::Rates };
        let (scalar, unit) = scalar::<R, L, D>(self.bound.quantity, variables, self.p, self.rows, y);
        ((self.rows[Bound::LIMIT] - scalar) * R::splat(self.bound.side()), unit)
    }
}

impl<R: Real, L: Layout, W: Within<R, D>, const MOMENTA: bool, const D: usize> Inside<R>
    for Margin<'_, R, L, W, MOMENTA, D>
{
    #[inline(always)]
    fn at(&self, fraction: R) -> R {
        self.of(&self.within.at(fraction)).0
    }
}

impl Observable for Bound {
    const ROWS: usize = 24;
    const CHANGING: usize = 4;

    fn start(self, start: &Start) -> Rows<f64> {
        let mut rows = super::UNOBSERVED;
        if let Some((place, _)) = start.on_orbit {
            rows[Bound::ANOMALY] = place.anomaly();
            [rows[Bound::ORBIT], rows[Bound::ORBIT + 1]] = [place.eccentricity(), place.rate()];
        }
        rows[Bound::LIMIT] = self.limit_of_scalar();
        rows[Bound::AFTER] = start.on_orbit.map_or(self.after, |(place, _)| place.anomaly_until(self.after));
        rows[Bound::MARGIN] = f64::INFINITY;
        put(&mut rows, Bound::AXIS, start.unit);
        // The frame of the kernel at the start: space axis 3, then 1.
        let [third, first] = start.frame;
        let scalar = match self.quantity {
            Quantity::Rate => dot(&start.rates, &start.unit),
            Quantity::Speed => dot(&start.rates, &start.rates).sqrt(),
            Quantity::Turn { of_momentum, .. } => {
                let v = if of_momentum { start.momentum } else { start.rates };
                let size = dot(&v, &v).sqrt().max(f64::MIN_POSITIVE);
                let unit = v.map(|x| x / size);
                put(&mut rows, Bound::AXIS, unit);
                if unit == [0.0; 3] {
                    // Without a direction at the start no limit is passed, and the motion is not known well enough.
                    (rows[Bound::LIMIT], rows[Bound::LEAP2]) = (f64::INFINITY, f64::INFINITY);
                }
                let second = cross(&third, &first);
                put(&mut rows, Bound::SPACE, [dot(&first, &unit), dot(&second, &unit), dot(&third, &unit)]);
                0.0
            }
            Quantity::Attitude => {
                put(&mut rows, Bound::AXIS, third);
                put(&mut rows, Bound::SPACE, first);
                0.0
            }
            Quantity::Pointing { .. } | Quantity::Angle { .. } => self.start_on_orbit(start, &mut rows),
        };
        if self.after <= 0.0 {
            rows[Bound::MARGIN] = (rows[Bound::LIMIT] - scalar) * self.side();
            rows[Bound::SETTLED] = if rows[Bound::MARGIN] < 0.0 { f64::INFINITY } else { 0.0 };
            if rows[Bound::MARGIN] < 0.0 {
                rows[EXIT_TIME] = 0.0;
            }
        }
        rows
    }

    /// The smallest margin of the scalar; NaN if it may have been smaller between two places.
    fn outcome(rows: &Rows<f64>) -> f64 {
        if rows[Bound::LEAP2] > Bound::MOST_LEAP2 { f64::NAN } else { rows[Bound::MARGIN] }
    }
}

impl<R: Real, M: Model<R>, L: Layout, const D: usize> Update<R, M, L, D> for Bound {
    /// True for the rates alone, and for rates with a vertical or a frame.
    const FITS: bool =
        L::CLOCK || !L::TANGENT && (L::TURNS || !L::QUATERNION && (L::VECTORS != 1 || M::HEAVY));

    #[inline(always)]
    fn after_step<S: Engine<R, M, L, D>>(self, rows: &mut Rows<R>, segment: &Segment<R, S, D>) {
        // Of each body; an inactive one has a step of zero.
        let wanted = R::splat(0.0).lt(segment.p.step.abs());
        look_inside::<_, R, M, L, S, D>(self, rows, segment, wanted);
    }

    #[inline(always)]
    fn look<S: Engine<R, M, L, D>>(self, rows: &mut Rows<R>, segment: &Segment<R, S, D>) {
        let &Segment { p, begin, before, after, .. } = segment;
        let dense = &motion_inside(segment);
        let bound = self;
        if const { !L::CLOCK } {
            let (ends, layout) = ([before, after], PhantomData::<L>);
            if const { matches!(S::VARIABLES, Variables::Rates) } {
                R::outlined(Look::<_, _, _, false, D> { bound, p, rows, begin, ends, within: dense, layout });
            } else {
                R::outlined(Look::<_, _, _, true, D> { bound, p, rows, begin, ends, within: dense, layout });
            }
            return;
        }
        let [eccentricity, rate] = [rows[Bound::ORBIT], rows[Bound::ORBIT + 1]];
        let anomaly = rows[Bound::ANOMALY] + begin;
        let within = &OnOrbit { dense, anomaly, step: p.step, eccentricity, rate };
        let [first, last] = [within.seen(R::splat(0.0), before), within.seen(R::splat(1.0), after)];
        let (ends, layout) = ([&first, &last], PhantomData);
        Look::<R, FurtherFrame, _, false, FRAME> { bound, p, rows, begin, ends, within, layout }.run();
    }
}

/// The scalar inside a step, in a function that all engines with the same variables share.
struct Look<'a, R, L, W, const MOMENTA: bool, const D: usize> {
    bound: Bound,
    p: &'a Parameters<R>,
    rows: &'a mut Rows<R>,
    begin: R,
    ends: [&'a [R; D]; 2],
    within: &'a W,
    layout: PhantomData<L>,
}

impl<R: Real, L: Layout, W: Within<R, D>, const MOMENTA: bool, const D: usize> Outlined
    for Look<'_, R, L, W, MOMENTA, D>
{
    type Out = ();
    #[inline(always)]
    fn run(self) {
        let Look { bound, p, rows, begin: time, ends: [before, after], within, layout } = self;
        let numbers = *rows;
        let margin = Margin::<R, L, W, MOMENTA, D> { bound, p, rows: &numbers, within, layout };
        let (zero, half, one) = (R::splat(0.0), R::splat(0.5), R::splat(1.0));
        let never = R::splat(f64::INFINITY);
        // The observed part of the step. An inactive lane has a step of zero.
        let begin = one.min(((rows[Bound::AFTER] - time) / p.step).max(zero));
        let span = one - begin;
        let size = span * R::splat(1.0 / Bound::PLACES as f64);
        // Of the first time beyond the limit, and of the last one inside it again.
        let (mut exit, mut entry) = (Bracket::none(), Bracket::none());
        // The margins at the last three places.
        let (mut margins, mut least) = ([never; 3], rows[Bound::MARGIN]);
        let (_, mut unit) = margin.of(before);
        let mut leap2 = rows[Bound::LEAP2];
        for place in 0..=Bound::PLACES {
            let fraction = size.fma(R::splat(place as f64), begin);
            let y = if place == Bound::PLACES { *after } else { within.at(fraction) };
            let (now, unit_now) = margin.of(&y);
            if bound.quantity.may_leap() {
                leap2 = leap2.max(chord2(&unit_now, &unit));
                unit = unit_now;
            }
            margins = [margins[1], margins[2], now];
            let [before_last, last, _] = margins;
            // The minimum of the parabola through three places; its distance before the middle one, in places.
            let bend = (before_last - last) + (now - last);
            let slope = (now - before_last) * half;
            let before_middle = slope / bend;
            let depth = before_middle.fnma(slope * half, last);
            let spread = (before_last - last).abs() + (now - last).abs();
            // A NaN, of the first two places, is no minimum.
            let is_minimum = R::both(zero.lt(bend), before_middle.abs().lt(R::splat(1.25)));
            let mut dip = R::select(is_minimum, depth, never);
            // The parabola is wrong by a small part of what the scalar changes by: near the limit the minimum is sought.
            // Of a direction of an orbit near the least margin so far too, for its largest angle is told.
            let level = if bound.quantity.is_of_orbit() { least.max(zero) } else { zero };
            let is_far = spread.fma(half, level).lt(dip);
            let near = R::except(R::except(dip.lt(never), is_far), exit.is_known());
            if R::any(near) {
                let (first, middle) = (fraction - (size + size), fraction - size);
                let at = before_middle.fnma(size, middle).max(first).min(fraction);
                let at = R::select(near, at, middle);
                let [at, deepest] = inside::least::<R, 6>(&margin, [first, fraction], at, size * half);
                dip = R::select(near, deepest, dip);
                // A pair of crossings: the margin before is not negative, the one at the minimum is.
                let dives = R::both(near, deepest.lt(zero));
                // The last place inside the limit before the minimum, and the first place after the minimum.
                let is_after = R::except(middle.lt(at), last.lt(zero));
                let from_inside =
                    [R::select(is_after, middle, first), R::select(is_after, last, before_last)];
                let to_inside = [R::select(is_after, fraction, middle), R::select(is_after, now, last)];
                exit.set(dives, Bracket { from: from_inside, to: [at, deepest] });
                let returns = R::except(dives, to_inside[1].lt(zero));
                entry.set(returns, Bracket { from: [at, deepest], to: to_inside });
            }
            let bracket = Bracket { from: [fraction - size, last], to: [fraction, now] };
            entry.set(R::except(last.lt(zero), now.lt(zero)), bracket);
            least = least.min(now);
            least = R::select(dip.lt(least), dip, least);
            let bracket = if place == 0 { Bracket { from: [begin, zero], ..bracket } } else { bracket };
            exit.set(R::except(now.lt(zero), exit.is_known()), bracket);
        }
        let is_back = entry.is_known();
        if R::any(is_back) {
            let settled = p.step.fma(entry.reversed().crossing(&margin), time);
            rows[Bound::SETTLED] = R::select(is_back, settled, rows[Bound::SETTLED]);
        }
        rows[Bound::SETTLED] = R::select(margins[2].lt(zero), never, rows[Bound::SETTLED]);
        // Before its time, and after the limit was passed, nothing is observed.
        let is_observed = zero.lt(span);
        rows[Bound::MARGIN] = R::select(is_observed, least, rows[Bound::MARGIN]);
        rows[Bound::LEAP2] = leap2;
        let leaves = R::both(R::except(is_observed, rows[EXIT_TIME].lt(never)), exit.is_known());
        if R::any(leaves) {
            exit.from[1] = exit.from[1].max(zero);
            let at = p.step.fma(exit.crossing(&margin), time);
            rows[EXIT_TIME] = R::select(leaves, at, rows[EXIT_TIME]);
        }
    }
}
