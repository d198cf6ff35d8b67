//! The closed form of a body, and the change to the variables of that form and back.
//!
//! Only this module decides which bodies have closed forms. `ClosedForm::answering` gives a closed form that holds
//! for any start, from a question, the moments and the weight; `CanonicalForm::of` gives the form of one start, which
//! may be simpler: a permanent rotation, or a top that swings in a plane.

use super::lagrange::falls;
use crate::body::Body;
use crate::kinematics::quaternion_product;
use crate::named::named;
use crate::special::sincos;
use std::f64::consts::{FRAC_1_SQRT_2, PI};

named! {
    /// The closed forms. Their codes begin with 1: 0 stands for none.
    pub enum ClosedForm {
        /// A constant rate about an axis fixed in space: a free body that is spherical, at rest or turns about a principal
        /// axis; a top that is upright or hangs without swinging.
        PermanentRotation = 1 => "axis spin",
        /// A free body with two equal moments.
        Symmetric => "free symmetric",
        /// A free body with three different moments.
        Asymmetric => "free asymmetric",
        /// A symmetric top with its centre of mass on the symmetry axis.
        Lagrange => "lagrange",
        /// A top that swings in a plane about a principal axis.
        Pendulum => "pendulum",
    }
}

/// The quantity that is evaluated in closed form, for any start of the body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Question {
    /// The states of the body: rates, the vertical in body components, the attitude.
    States,
    /// Time of the first sign change of the rate about this body axis (0 to 2); `None` stands for an axis that is not
    /// known yet.
    NoFlip(Option<usize>),
    /// Time at which the tilt of this body axis (0 to 2) from the vertical first exceeds an angle.
    TiltFromVertical(usize),
    /// Whether the motion is regular. It is by theorem, off a separatrix.
    Regular,
}

impl Question {
    /// A description of the bodies that have a closed form for their states.
    pub const RULE_OF_STATES: &str = "closed forms are known of a free body, of a top with two exactly equal \
        moments and its centre of mass on the third axis, and of a top that swings about a principal axis";

    /// A description of the bodies that have a closed form for their class.
    pub const RULE_OF_CLASSES: &str = "closed forms are known of no_flip and regular of a free body, and of \
        tilt_below(axis=±k, reference='vertical'), no_flip(k) and regular of a top with two exactly equal moments \
        and its centre of mass on the third axis k";
}

/// The symmetry axis (0 to 2) of a Lagrange top: the other two moments are exactly equal, and the weight, which is
/// not zero, lies exactly on the axis. `None` for any other body.
pub fn lagrange_axis(moments: [f64; 3], weight: [f64; 3]) -> Option<usize> {
    (0..3).find(|&k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        moments[i] == moments[j] && weight[i] == 0.0 && weight[j] == 0.0 && weight[k] != 0.0
    })
}

impl ClosedForm {
    /// The code of a closed form or of none.
    pub fn code(form: Option<ClosedForm>) -> u8 {
        form.map_or(0, |form| form as u8)
    }

    /// The closed form that applies to the question for a body with these moments and this weight (`mgl com`) from any
    /// start; `None` if there is none.
    pub fn answering(question: Question, moments: [f64; 3], weight: [f64; 3]) -> Option<ClosedForm> {
        if weight == [0.0; 3] {
            let [a, b, c] = moments;
            return match (question, [a == b, b == c, c == a]) {
                (Question::TiltFromVertical(_), _) => None,
                (_, [true, true, true]) => Some(ClosedForm::PermanentRotation),
                (_, [false, false, false]) => Some(ClosedForm::Asymmetric),
                _ => Some(ClosedForm::Symmetric),
            };
        }
        let axis = lagrange_axis(moments, weight)?;
        let answers = match question {
            Question::States | Question::Regular => true,
            Question::NoFlip(asked) => asked == Some(axis),
            Question::TiltFromVertical(asked) => asked == axis,
        };
        answers.then_some(ClosedForm::Lagrange)
    }
}

/// The motion that evaluates a closed form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // The names are those of the motions.
pub enum Evaluator {
    Symmetric,
    Free,
    Lagrange,
}

/// The closed form of a body from its start, and the change to the variables of that form and back.
#[derive(Clone, Copy, Debug)]
pub struct CanonicalForm {
    /// The closed form.
    pub closed_form: ClosedForm,
    transform: Transform,
}

/// The change of variables.
#[derive(Clone, Copy, Debug)]
enum Transform {
    /// Axis i of body and space is the original axis (i + turn) mod 3. No digit changes.
    RenamedAxes(usize),
    /// The body rotates permanently about this axis, or is at rest: each moment may be replaced by that of the axis.
    PermanentRotation(usize),
    /// Only the body frame is turned, by a quarter, so that this axis becomes the third.
    QuarterTurn(usize),
    /// Only the body frame is turned, so that this axis, about which the body swings, becomes the first axis and the
    /// centre of mass lies on the third.
    Pendulum(usize),
}

/// A weight, or the swing of a top that does not fall from the vertical, of this share of the rest counts as zero. Neither
/// grows, and squares are outside the range of doubles.
const NEGLIGIBLE: f64 = 1e-150;

/// The axes of a body frame turned by a quarter so that each axis becomes the third.
const TO_THIRD: [[i8; 3]; 3] = [[-3, 2, 1], [1, -3, 2], [1, 2, 3]];

/// An attitude after the turn of `TO_THIRD` (`sense` 1) or its inverse (`sense` -1). Sums come before products, so that
/// an axis that is vertical to the bit stays vertical to the bit.
fn quarter_turned([w, x, y, z]: [f64; 4], axis: usize, sense: f64) -> [f64; 4] {
    let turned = match axis {
        0 => [w - sense * y, x - sense * z, y + sense * w, z + sense * x],
        1 => [w + sense * x, x - sense * w, y - sense * z, z + sense * y],
        _ => return [w, x, y, z],
    };
    turned.map(|c| c * FRAC_1_SQRT_2)
}

/// The cyclic renaming of the axes of a body frame that makes each axis the first.
const TO_FIRST: [[f64; 4]; 3] = [[1.0, 0.0, 0.0, 0.0], [0.5, 0.5, 0.5, 0.5], [0.5, -0.5, -0.5, -0.5]];

/// Components along signed axes.
fn along(columns: [i8; 3], v: [f64; 3]) -> [f64; 3] {
    columns.map(|c| f64::from(c.signum()) * v[usize::from(c.unsigned_abs()) - 1])
}

/// The inverse of `along`.
fn back_along(columns: [i8; 3], v: [f64; 3]) -> [f64; 3] {
    let mut out = [0.0; 3];
    for (c, x) in columns.into_iter().zip(v) {
        out[usize::from(c.unsigned_abs()) - 1] = f64::from(c.signum()) * x;
    }
    out
}

fn conjugate([w, x, y, z]: [f64; 4]) -> [f64; 4] {
    [w, -x, -y, -z]
}

/// `v` with component i from component (i + turn) mod 3.
fn rename(v: [f64; 3], turn: usize) -> [f64; 3] {
    [v[turn % 3], v[(turn + 1) % 3], v[(turn + 2) % 3]]
}

/// The quaternion that turns the body frame of a pendulum that swings about `axis`.
fn pendulum_frame(weight: [f64; 3], axis: usize) -> [f64; 4] {
    let [_, next, last] = rename(weight, axis);
    let mgl = (next * next + last * last).sqrt();
    let (sin, cos) = (-next / mgl, last / mgl);
    // Half of the angle, from the half that does not cancel.
    let half = if cos >= 0.0 {
        let c = (0.5 * (1.0 + cos)).sqrt();
        [c, 0.5 * sin / c]
    } else {
        let s = (0.5 * (1.0 - cos)).sqrt();
        [0.5 * sin / s, s]
    };
    quaternion_product(&TO_FIRST[axis], &[half[0], half[1], 0.0, 0.0])
}

/// 1 - cos and 1 + cos of an angle in 0 ..= pi. At pi the latter is zero, although the nearest double is not pi.
pub fn versines(angle: f64) -> [f64; 2] {
    let (sin, cos) = sincos(0.5 * angle);
    if angle < PI { [2.0 * sin * sin, 2.0 * cos * cos] } else { [2.0, 0.0] }
}

/// 1 - cos and 1 + cos of the angle between the upward vertical and the centre of mass, which lies on this axis.
pub fn depths(body: &Body, axis: usize) -> [f64; 2] {
    let [w, x, y, z] = quarter_turned(body.attitude, axis, 1.0);
    let (up, down) = (2.0 * (x * x + y * y), 2.0 * (w * w + z * z));
    if body.weight[axis] < 0.0 { [down, up] } else { [up, down] }
}

/// Whether a top with its centre of mass on this axis, and with rates across it of `across` times the others, stays
/// upright or hangs. From the upright position a top without enough spin falls, however small the tilt.
fn is_vertical(body: &Body, axis: usize, across: f64) -> bool {
    let [w, x, y, z] = quarter_turned(body.attitude, axis, 1.0);
    let mut tilts = [x.abs().max(y.abs()), w.abs().max(z.abs())];
    if body.weight[axis] < 0.0 {
        tilts.reverse();
    }
    let [upright, hanging] = tilts.map(|tilt| tilt.max(across));
    let moments = [body.moments[(axis + 1) % 3], body.moments[axis]];
    hanging <= NEGLIGIBLE
        || upright == 0.0
        || upright <= NEGLIGIBLE && !falls(moments, body.weight[axis], body.omega[axis])
}

impl CanonicalForm {
    /// The canonical form of a body; `None` if the body has no closed form from this start.
    #[inline(always)]
    pub fn of(body: &Body) -> Option<CanonicalForm> {
        if body.weight == [0.0; 3] { Some(CanonicalForm::free(body)) } else { CanonicalForm::top(body) }
    }

    fn permanent_rotation(axis: usize) -> CanonicalForm {
        let transform = Transform::PermanentRotation(axis);
        CanonicalForm { closed_form: ClosedForm::PermanentRotation, transform }
    }

    #[inline(always)]
    fn free(body: &Body) -> CanonicalForm {
        let turns = body.omega.map(|rate| rate != 0.0);
        let count = turns.iter().filter(|&&turns| turns).count();
        let [a, b, c] = body.moments;
        let (first, second, third) = (b == c, c == a, a == b);
        if count <= 1 || (first && second) {
            let axis = turns.iter().position(|&turns| turns).unwrap_or(0);
            return CanonicalForm::permanent_rotation(axis);
        }
        let turn = if third {
            0
        } else if first {
            1
        } else if second {
            2
        } else {
            return CanonicalForm {
                closed_form: ClosedForm::Asymmetric,
                transform: Transform::RenamedAxes(0),
            };
        };
        CanonicalForm { closed_form: ClosedForm::Symmetric, transform: Transform::RenamedAxes(turn) }
    }

    fn top(body: &Body) -> Option<CanonicalForm> {
        let mgl = body.weight.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        let kinetic = (0..3).map(|k| body.moments[k] * body.omega[k] * body.omega[k]).fold(0.0_f64, f64::max);
        let heavy = (0..3).find(|&k| body.is_weighed_along(k));
        let Some(axis) = heavy.filter(|&k| body.is_symmetric_about(k)) else {
            return CanonicalForm::pendulum(body, heavy);
        };
        if mgl < NEGLIGIBLE * kinetic {
            return Some(CanonicalForm::free(body));
        }
        let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
        let rate = body.omega[axis].abs().max((mgl / body.moments[next]).sqrt());
        if is_vertical(body, axis, body.omega[next].abs().max(body.omega[last].abs()) / rate) {
            return Some(CanonicalForm::permanent_rotation(axis));
        }
        Some(CanonicalForm { closed_form: ClosedForm::Lagrange, transform: Transform::QuarterTurn(axis) })
    }

    /// The form of a top that swings about a horizontal principal axis with the centre of mass beside that axis, or
    /// that is in equilibrium.
    fn pendulum(body: &Body, heavy: Option<usize>) -> Option<CanonicalForm> {
        let rest = body.omega == [0.0; 3];
        if let Some(axis) = heavy.filter(|&k| rest && is_vertical(body, k, 0.0)) {
            return Some(CanonicalForm::permanent_rotation(axis));
        }
        let gamma = body.gamma();
        let axis = (0..3).find(|&k| {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            body.omega[i] == 0.0 && body.omega[j] == 0.0 && body.weight[k] == 0.0 && gamma[k] == 0.0
        })?;
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        // The weight has no lever arm: a body at rest stays at rest.
        if rest && gamma[i] * body.weight[j] == gamma[j] * body.weight[i] {
            return Some(CanonicalForm::permanent_rotation(axis));
        }
        Some(CanonicalForm { closed_form: ClosedForm::Pendulum, transform: Transform::Pendulum(axis) })
    }

    /// The motion that evaluates the closed form.
    #[inline(always)]
    pub fn evaluator(self) -> Evaluator {
        match self.closed_form {
            ClosedForm::PermanentRotation | ClosedForm::Symmetric => Evaluator::Symmetric,
            ClosedForm::Asymmetric => Evaluator::Free,
            ClosedForm::Lagrange | ClosedForm::Pendulum => Evaluator::Lagrange,
        }
    }

    /// The body in the variables of its closed form: axis 3 is the symmetry axis, and the centre of mass lies on it.
    pub fn to_canonical(self, body: &Body) -> Body {
        let [w, x, y, z] = body.attitude;
        match self.transform {
            Transform::RenamedAxes(0) => *body,
            Transform::RenamedAxes(turn) => {
                let [x, y, z] = rename([x, y, z], turn);
                Body {
                    moments: rename(body.moments, turn),
                    weight: [0.0; 3],
                    omega: rename(body.omega, turn),
                    attitude: [w, x, y, z],
                }
            }
            Transform::PermanentRotation(axis) => {
                Body { moments: [body.moments[axis]; 3], weight: [0.0; 3], ..*body }
            }
            Transform::QuarterTurn(axis) => {
                let transverse = body.moments[(axis + 1) % 3];
                Body {
                    moments: [transverse, transverse, body.moments[axis]],
                    weight: [0.0, 0.0, body.weight[axis]],
                    omega: along(TO_THIRD[axis], body.omega),
                    attitude: quarter_turned(body.attitude, axis, 1.0),
                }
            }
            // A spherical top with the moment of the axis has an equal motion.
            Transform::Pendulum(axis) => {
                let [_, next, last] = rename(body.weight, axis);
                Body {
                    moments: [body.moments[axis]; 3],
                    weight: [0.0, 0.0, (next * next + last * last).sqrt()],
                    omega: [body.omega[axis], 0.0, 0.0],
                    attitude: quaternion_product(&body.attitude, &pendulum_frame(body.weight, axis)),
                }
            }
        }
    }

    /// The axis of the closed form that lies along this body axis.
    #[inline(always)]
    pub fn axis(self, body_axis: usize) -> usize {
        match self.transform {
            Transform::PermanentRotation(_) => body_axis,
            Transform::RenamedAxes(turn) | Transform::Pendulum(turn) => (body_axis + 3 - turn) % 3,
            Transform::QuarterTurn(axis) => {
                let along = |c: &i8| usize::from(c.unsigned_abs()) == body_axis + 1;
                TO_THIRD[axis].iter().position(along).unwrap_or(body_axis)
            }
        }
    }

    /// Rates and attitude of the body from those in the variables of its closed form.
    pub fn to_body(self, body: &Body, omega: [f64; 3], attitude: [f64; 4]) -> ([f64; 3], [f64; 4]) {
        let [w, x, y, z] = attitude;
        match self.transform {
            Transform::RenamedAxes(0) | Transform::PermanentRotation(_) => (omega, attitude),
            Transform::RenamedAxes(turn) => {
                let undo = 3 - turn;
                let [x, y, z] = rename([x, y, z], undo);
                (rename(omega, undo), [w, x, y, z])
            }
            Transform::QuarterTurn(axis) => {
                (back_along(TO_THIRD[axis], omega), quarter_turned(attitude, axis, -1.0))
            }
            // A pendulum stays in its plane.
            Transform::Pendulum(axis) => {
                let frame = conjugate(pendulum_frame(body.weight, axis));
                (rename([omega[0], 0.0, 0.0], (3 - axis) % 3), quaternion_product(&attitude, &frame))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A body for each transform, with the closed form of the body.
    fn bodies() -> Vec<(Body, ClosedForm)> {
        let attitude = [0.5, 0.5, -0.5, 0.5];
        let omega = [0.375, -0.5, 1.25];
        let free = |moments| Body { moments, weight: [0.0; 3], omega, attitude };
        let mut bodies = vec![
            (free([1.0, 2.0, 2.5]), ClosedForm::Asymmetric),
            (free([1.5; 3]), ClosedForm::PermanentRotation),
            (Body { omega: [0.0, 0.5, 0.0], ..free([1.0, 2.0, 2.5]) }, ClosedForm::PermanentRotation),
        ];
        for axis in 0..3 {
            let (mut moments, mut weight) = ([1.0; 3], [0.0; 3]);
            moments[axis] = 0.5;
            bodies.push((free(moments), ClosedForm::Symmetric));
            weight[axis] = 2.0;
            bodies.push((Body { weight, ..free(moments) }, ClosedForm::Lagrange));
        }
        // Axis 1 is horizontal, the weight lies across it.
        let upright = [1.0, 0.0, 0.0, 0.0];
        let swinging = Body { omega: [0.75, 0.0, 0.0], attitude: upright, ..free([1.0, 2.0, 2.5]) };
        bodies.push((Body { weight: [0.0, 3.0, 4.0], ..swinging }, ClosedForm::Pendulum));
        bodies
    }

    fn differ<const N: usize>(a: [f64; N], b: [f64; N]) -> f64 {
        a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn the_way_to_the_canonical_form_and_back_is_the_identity() {
        for (body, closed_form) in bodies() {
            let form = CanonicalForm::of(&body).unwrap();
            assert_eq!(form.closed_form, closed_form, "{body:?}");
            let there = form.to_canonical(&body);
            let (omega, attitude) = form.to_body(&body, there.omega, there.attitude);
            // A turn and its inverse round four sums of two products each.
            assert!(differ(omega, body.omega) == 0.0, "{body:?}: {omega:?}");
            assert!(differ(attitude, body.attitude) <= 4.0 * f64::EPSILON, "{body:?}: {attitude:?}");
        }
    }

    #[test]
    fn energy_is_the_same_in_canonical_variables() {
        for (body, closed_form) in bodies() {
            let there = CanonicalForm::of(&body).unwrap().to_canonical(&body);
            let energy = |b: &Body, heavy: f64| -> f64 {
                let gamma = b.gamma();
                (0..3)
                    .map(|k| 0.5 * b.moments[k] * b.omega[k] * b.omega[k] + heavy * b.weight[k] * gamma[k])
                    .sum()
            };
            let heavy = f64::from(closed_form == ClosedForm::Lagrange || closed_form == ClosedForm::Pendulum);
            let off = (energy(&there, heavy) - energy(&body, heavy)).abs();
            assert!(off <= 16.0 * f64::EPSILON, "{body:?}: {off:e}");
        }
    }

    #[test]
    fn an_axis_keeps_its_rate_in_canonical_variables() {
        for (body, _) in bodies() {
            let form = CanonicalForm::of(&body).unwrap();
            let there = form.to_canonical(&body);
            for axis in 0..3 {
                assert_eq!(there.omega[form.axis(axis)].abs(), body.omega[axis].abs(), "{body:?}");
            }
        }
    }

    #[test]
    fn the_catalogue_agrees_with_the_form_of_a_start() {
        for (body, closed_form) in bodies() {
            let known = ClosedForm::answering(Question::States, body.moments, body.weight);
            match closed_form {
                // These bodies have a closed form only for some starts.
                ClosedForm::Pendulum => assert_eq!(known, None),
                ClosedForm::PermanentRotation => assert!(known.is_some()),
                _ => assert_eq!(known, Some(closed_form)),
            }
        }
    }

    #[test]
    fn classes_have_a_closed_form_about_the_symmetry_axis_of_a_top_only() {
        let (moments, weight) = ([1.0, 0.5, 1.0], [0.0, -2.0, 0.0]);
        for axis in 0..3 {
            let expected = (axis == 1).then_some(ClosedForm::Lagrange);
            for question in [Question::NoFlip(Some(axis)), Question::TiltFromVertical(axis)] {
                assert_eq!(ClosedForm::answering(question, moments, weight), expected);
            }
            let free = ClosedForm::answering(Question::NoFlip(Some(axis)), moments, [0.0; 3]);
            assert_eq!(free, Some(ClosedForm::Symmetric));
            assert_eq!(ClosedForm::answering(Question::TiltFromVertical(axis), moments, [0.0; 3]), None);
        }
        assert_eq!(ClosedForm::answering(Question::NoFlip(None), moments, weight), None);
        assert_eq!(lagrange_axis(moments, weight), Some(1));
        assert_eq!(lagrange_axis([1.0, 1.0 + f64::EPSILON, 0.5], [0.0, 0.0, 1.0]), None);
    }
}
