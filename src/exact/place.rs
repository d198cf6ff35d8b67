//! Which closed form a body has, and its way into the variables of that form and back.

use crate::model::quaternion_product;
use crate::start::Body;
use std::f64::consts::FRAC_1_SQRT_2;

/// The closed forms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Free: spherical, at rest or turning about a principal axis; or a top upright or hanging without swing.
    Spin,
    /// Free, two moments equal.
    Symmetric,
    /// Free, three moments.
    Asymmetric,
    /// Symmetric top with its centre of mass on the axis.
    Lagrange,
    /// A top that swings in a plane about a principal axis.
    Pendulum,
}

impl Form {
    /// The words for it.
    pub fn name(self) -> &'static str {
        match self {
            Form::Spin => "axis spin",
            Form::Symmetric => "free symmetric",
            Form::Asymmetric => "free asymmetric",
            Form::Lagrange => "lagrange",
            Form::Pendulum => "pendulum",
        }
    }
}

/// Which code evaluates a form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // The names are those of the motions.
pub enum Kind {
    Symmetric,
    Free,
    Lagrange,
}

/// The closed form of a body, and the change to its variables and back.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// The closed form.
    pub form: Form,
    way: Way,
}

/// How the variables are changed.
#[derive(Clone, Copy, Debug)]
enum Way {
    /// Axis i of body and space is axis (i + turn) mod 3 of before: exact.
    Renamed(usize),
    /// The body turns about this axis, or not at all: all moments may be that of the axis.
    Spin(usize),
    /// The body frame alone was turned so that this axis became the third.
    QuarterTurned(usize),
    /// The body frame alone was turned: this axis, about which it swings, became the first and the weight the third.
    Swing(usize),
}

/// Share of a motion below which something is not part of it.
const NEGLIGIBLE: f64 = 1e-150;

/// The axes of a body frame turned by a quarter so that each axis becomes the third.
const TO_THIRD: [[i8; 3]; 3] = [[-3, 2, 1], [1, -3, 2], [1, 2, 3]];

/// An attitude after the turn of `TO_THIRD` (1) or its inverse (-1). Sums before products: what is vertical to the
/// bit stays so.
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

/// The quaternion that turns the body frame of a swing about `axis`.
fn swing_frame(weight: [f64; 3], axis: usize) -> [f64; 4] {
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

/// Whether a body axis is upright or hangs.
fn is_vertical(body: &Body, axis: usize) -> bool {
    let [w, x, y, z] = quarter_turned(body.attitude, axis, 1.0);
    (x.abs() <= NEGLIGIBLE && y.abs() <= NEGLIGIBLE) || (w.abs() <= NEGLIGIBLE && z.abs() <= NEGLIGIBLE)
}

impl Place {
    /// The place of a body, if it has a closed form.
    #[inline(always)]
    pub fn of(body: &Body) -> Option<Place> {
        if body.weight == [0.0; 3] { Some(Place::free(body)) } else { Place::top(body) }
    }

    #[inline(always)]
    fn free(body: &Body) -> Place {
        // What is below 1e-150 of the fastest rate has squares outside the range of doubles: it counts as none.
        let fastest = body.omega.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        let turns = body.omega.map(|rate| rate.abs() > NEGLIGIBLE * fastest);
        let count = turns.iter().filter(|&&turns| turns).count();
        let [a, b, c] = body.moments;
        let (first, second, third) = (b == c, c == a, a == b);
        if count <= 1 || (first && second) {
            let axis = turns.iter().position(|&turns| turns).unwrap_or(0);
            return Place { form: Form::Spin, way: Way::Spin(axis) };
        }
        let turn = if third {
            0
        } else if first {
            1
        } else if second {
            2
        } else {
            return Place { form: Form::Asymmetric, way: Way::Renamed(0) };
        };
        Place { form: Form::Symmetric, way: Way::Renamed(turn) }
    }

    fn top(body: &Body) -> Option<Place> {
        let mgl = body.weight.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        let kinetic = (0..3).map(|k| body.moments[k] * body.omega[k] * body.omega[k]).fold(0.0_f64, f64::max);
        if mgl < NEGLIGIBLE * kinetic {
            return Some(Place::free(body));
        }
        let heavy = (0..3).find(|&k| body.is_weighed_along(k));
        let Some(axis) = heavy.filter(|&k| body.is_symmetric_about(k)) else {
            return Place::pendulum(body, heavy);
        };
        let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
        let rate = body.omega[axis].abs().max((mgl / body.moments[next]).sqrt());
        let still = |k: usize| body.omega[k].abs() <= NEGLIGIBLE * rate;
        if still(next) && still(last) && is_vertical(body, axis) {
            return Some(Place { form: Form::Spin, way: Way::Spin(axis) });
        }
        Some(Place { form: Form::Lagrange, way: Way::QuarterTurned(axis) })
    }

    /// A swing about a principal axis that is level, with the centre of mass beside it; or no swing at all.
    fn pendulum(body: &Body, heavy: Option<usize>) -> Option<Place> {
        let rest = body.omega == [0.0; 3];
        if let Some(axis) = heavy.filter(|&k| rest && is_vertical(body, k)) {
            return Some(Place { form: Form::Spin, way: Way::Spin(axis) });
        }
        let vertical = body.vertical();
        let axis = (0..3).find(|&k| {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            body.omega[i] == 0.0 && body.omega[j] == 0.0 && body.weight[k] == 0.0 && vertical[k] == 0.0
        })?;
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        // The weight has no lever: a body at rest stays so.
        if rest && vertical[i] * body.weight[j] == vertical[j] * body.weight[i] {
            return Some(Place { form: Form::Spin, way: Way::Spin(axis) });
        }
        Some(Place { form: Form::Pendulum, way: Way::Swing(axis) })
    }

    /// Who evaluates it.
    #[inline(always)]
    pub fn kind(&self) -> Kind {
        match self.form {
            Form::Spin | Form::Symmetric => Kind::Symmetric,
            Form::Asymmetric => Kind::Free,
            Form::Lagrange | Form::Pendulum => Kind::Lagrange,
        }
    }

    /// The body in the variables of its closed form: axis 3 is the distinct one and carries the weight.
    pub fn canonical(&self, body: &Body) -> Body {
        let [w, x, y, z] = body.attitude;
        match self.way {
            Way::Renamed(0) => *body,
            Way::Renamed(turn) => {
                let [x, y, z] = rename([x, y, z], turn);
                Body {
                    moments: rename(body.moments, turn),
                    weight: [0.0; 3],
                    omega: rename(body.omega, turn),
                    attitude: [w, x, y, z],
                }
            }
            Way::Spin(axis) => Body { moments: [body.moments[axis]; 3], weight: [0.0; 3], ..*body },
            Way::QuarterTurned(axis) => {
                let transverse = body.moments[(axis + 1) % 3];
                Body {
                    moments: [transverse, transverse, body.moments[axis]],
                    weight: [0.0, 0.0, body.weight[axis]],
                    omega: along(TO_THIRD[axis], body.omega),
                    attitude: quarter_turned(body.attitude, axis, 1.0),
                }
            }
            // The same motion as that of a spherical top with the moment of the axis.
            Way::Swing(axis) => {
                let [_, next, last] = rename(body.weight, axis);
                Body {
                    moments: [body.moments[axis]; 3],
                    weight: [0.0, 0.0, (next * next + last * last).sqrt()],
                    omega: [body.omega[axis], 0.0, 0.0],
                    attitude: quaternion_product(&body.attitude, &swing_frame(body.weight, axis)),
                }
            }
        }
    }

    /// The axis of the closed form that lies along this body axis.
    #[inline(always)]
    pub fn axis(&self, body_axis: usize) -> usize {
        match self.way {
            Way::Spin(_) => body_axis,
            Way::Renamed(turn) | Way::Swing(turn) => (body_axis + 3 - turn) % 3,
            Way::QuarterTurned(axis) => {
                let along = |c: &i8| usize::from(c.unsigned_abs()) == body_axis + 1;
                TO_THIRD[axis].iter().position(along).unwrap_or(body_axis)
            }
        }
    }

    /// Rates and attitude of the body from those of its closed form.
    pub fn back(&self, body: &Body, omega: [f64; 3], attitude: [f64; 4]) -> ([f64; 3], [f64; 4]) {
        let [w, x, y, z] = attitude;
        match self.way {
            Way::Renamed(0) | Way::Spin(_) => (omega, attitude),
            Way::Renamed(turn) => {
                let undo = 3 - turn;
                let [x, y, z] = rename([x, y, z], undo);
                (rename(omega, undo), [w, x, y, z])
            }
            Way::QuarterTurned(axis) => {
                (back_along(TO_THIRD[axis], omega), quarter_turned(attitude, axis, -1.0))
            }
            // A swing stays in its plane.
            Way::Swing(axis) => {
                let frame = conjugate(swing_frame(body.weight, axis));
                (rename([omega[0], 0.0, 0.0], (3 - axis) % 3), quaternion_product(&attitude, &frame))
            }
        }
    }
}
