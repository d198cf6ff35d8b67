//! Which closed form a body has, and its way into the variables of that form and back.

use crate::model::quaternion_product;
use crate::start::Body;
use std::f64::consts::FRAC_1_SQRT_2;

/// The closed forms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Free: spherical, at rest or turning about a principal axis, or a top upright or hanging without swing.
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

/// A body in the variables of its closed form, and the way back.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// The closed form.
    pub form: Form,
    /// Who evaluates it.
    pub kind: Kind,
    /// The body as that code wants it: axis 3 is the distinct one.
    pub body: Body,
    way: Way,
}

/// How the variables were changed.
#[derive(Clone, Copy, Debug)]
enum Way {
    /// Axis i of body and space is axis (i + turn) mod 3 of before: exact.
    Renamed(usize),
    /// The body frame alone was turned so that this axis became the third.
    QuarterTurned(usize),
    /// The body frame alone was turned: this axis became the first, then the quaternion.
    Turned { by: [f64; 4], first: usize },
}

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

impl Place {
    /// The place of a body, if it has a closed form.
    pub fn of(body: &Body) -> Option<Place> {
        let Body { moments, weight, omega, .. } = *body;
        if weight == [0.0; 3] { Some(Place::free(body)) } else { Place::top(body, moments, weight, omega) }
    }

    fn free(body: &Body) -> Place {
        let turning = (0..3).filter(|&k| body.omega[k] != 0.0);
        let equal = |i: usize, j: usize| body.moments[i] == body.moments[j];
        let spherical = equal(0, 1) && equal(1, 2);
        if spherical || turning.clone().count() <= 1 {
            let axis = turning.last().unwrap_or(0);
            let moments = [body.moments[axis]; 3];
            let body = Body { moments, ..*body };
            return Place { form: Form::Spin, kind: Kind::Symmetric, body, way: Way::Renamed(0) };
        }
        match (0..3).find(|&k| equal((k + 1) % 3, (k + 2) % 3)) {
            Some(axis) => {
                let turn = (axis + 1) % 3;
                let [w, x, y, z] = body.attitude;
                let [x, y, z] = rename([x, y, z], turn);
                let body = Body {
                    moments: rename(body.moments, turn),
                    weight: [0.0; 3],
                    omega: rename(body.omega, turn),
                    attitude: [w, x, y, z],
                };
                Place { form: Form::Symmetric, kind: Kind::Symmetric, body, way: Way::Renamed(turn) }
            }
            None => {
                Place { form: Form::Asymmetric, kind: Kind::Free, body: *body, way: Way::Renamed(0) }
            }
        }
    }

    fn top(body: &Body, moments: [f64; 3], weight: [f64; 3], omega: [f64; 3]) -> Option<Place> {
        let symmetry = (0..3).find(|&k| {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            moments[i] == moments[j] && weight[i] == 0.0 && weight[j] == 0.0
        });
        if let Some(axis) = symmetry {
            let attitude = quarter_turned(body.attitude, axis, 1.0);
            let omega = along(TO_THIRD[axis], omega);
            let [w, x, y, z] = attitude;
            let vertical = (x == 0.0 && y == 0.0) || (w == 0.0 && z == 0.0);
            if vertical && omega[0] == 0.0 && omega[1] == 0.0 {
                let body = Body { moments: [moments[axis]; 3], weight: [0.0; 3], ..*body };
                return Some(Place { form: Form::Spin, kind: Kind::Symmetric, body, way: Way::Renamed(0) });
            }
            let transverse = moments[(axis + 1) % 3];
            let body = Body {
                moments: [transverse, transverse, moments[axis]],
                weight: [0.0, 0.0, weight[axis]],
                omega,
                attitude,
            };
            let way = Way::QuarterTurned(axis);
            return Some(Place { form: Form::Lagrange, kind: Kind::Lagrange, body, way });
        }
        Place::pendulum(body, moments, weight, omega)
    }

    /// A swing about principal axis k with the centre of mass beside it and the axis level: the same motion as
    /// that of a spherical top with the moment of that axis, its weight on axis 3.
    fn pendulum(body: &Body, moments: [f64; 3], weight: [f64; 3], omega: [f64; 3]) -> Option<Place> {
        let vertical = body.vertical();
        let axis = (0..3).find(|&k| {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            omega[i] == 0.0 && omega[j] == 0.0 && weight[k] == 0.0 && vertical[k] == 0.0
        })?;
        // Axis k becomes axis 1 and the direction of the weight axis 3.
        let renamed = rename(weight, axis);
        let mgl = (renamed[1] * renamed[1] + renamed[2] * renamed[2]).sqrt();
        let (sin, cos) = (-renamed[1] / mgl, renamed[2] / mgl);
        let half = if cos >= 0.0 {
            let c = (0.5 * (1.0 + cos)).sqrt();
            [c, 0.5 * sin / c]
        } else {
            let s = (0.5 * (1.0 - cos)).sqrt();
            [0.5 * sin / s, s]
        };
        let by = quaternion_product(&TO_FIRST[axis], &[half[0], half[1], 0.0, 0.0]);
        let body = Body {
            moments: [moments[axis]; 3],
            weight: [0.0, 0.0, mgl],
            omega: [omega[axis], 0.0, 0.0],
            attitude: quaternion_product(&body.attitude, &by),
        };
        let way = Way::Turned { by, first: axis };
        Some(Place { form: Form::Pendulum, kind: Kind::Lagrange, body, way })
    }

    /// The axis of the closed form that lies along this body axis.
    pub fn axis(&self, body_axis: usize) -> usize {
        match self.way {
            Way::Renamed(turn) | Way::Turned { first: turn, .. } => (body_axis + 3 - turn) % 3,
            Way::QuarterTurned(axis) => {
                let along = |c: &i8| usize::from(c.unsigned_abs()) == body_axis + 1;
                TO_THIRD[axis].iter().position(along).unwrap_or(body_axis)
            }
        }
    }

    /// Rates and attitude of the body from those of its closed form.
    pub fn back(&self, omega: [f64; 3], attitude: [f64; 4]) -> ([f64; 3], [f64; 4]) {
        match self.way {
            Way::Renamed(turn) => {
                let undo = (3 - turn) % 3;
                let [w, x, y, z] = attitude;
                let [x, y, z] = rename([x, y, z], undo);
                (rename(omega, undo), [w, x, y, z])
            }
            Way::QuarterTurned(axis) => {
                (back_along(TO_THIRD[axis], omega), quarter_turned(attitude, axis, -1.0))
            }
            Way::Turned { by, first } => {
                // A swing stays in its plane.
                let along_first = [omega[0], 0.0, 0.0];
                (rename(along_first, (3 - first) % 3), quaternion_product(&attitude, &conjugate(by)))
            }
        }
    }
}
