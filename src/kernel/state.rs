//! The state of a body in a lane, in the axes of the user.

use super::group::{Group, MAX_STATE};
use super::{Compiled, KernelAssignment};
use crate::body::{Body, VERTICAL};
use crate::forces::{MOST_STATES, OrbitPlace};
use crate::kinematics::{attitude_of_rows, dot, length, to_body_frame, vertical};
use crate::method::Variables;
use crate::scene::Parameters;
use crate::simd::Row;

/// A state in the user's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Rates in the body.
    pub omega: [f64; 3],
    /// The first direction of the state, if there is one.
    pub direction: Option<[f64; 3]>,
    /// Attitude, if it is integrated.
    pub attitude: Option<[f64; 4]>,
    /// Whether the sign of the quaternion is arbitrary, because the quaternion is computed from rows of the matrix.
    sign_is_free: bool,
    /// Energy and conserved momentum, with the arithmetic of the kernel.
    pub invariants: [f64; 2],
    /// Energy and conserved momentum of a top with the vertical that follows from its attitude; this vertical may
    /// differ from the integrated one.
    pub invariants_of_attitude: Option<[f64; 2]>,
    /// The deviation vector, if one is integrated: a change of the rates and a rotation vector in the body.
    pub tangent: Option<[f64; 6]>,
    /// Work and scales of a forced body.
    pub balance: Option<Balance>,
    /// The states of a function, if there are any.
    pub states: Option<[f64; MOST_STATES]>,
}

/// Work of the forces, and scales of the invariants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Balance {
    /// Work of torque and damping since the start.
    pub work: f64,
    /// Scales of the present energy and conserved momentum, to be added to the scales at the start.
    pub scales: [f64; 2],
}

impl State {
    /// The attitude, if it is integrated. A sign that is arbitrary is that nearer to the last attitude.
    #[inline]
    pub fn attitude_after(&self, last: &[f64; 4]) -> Option<[f64; 4]> {
        let attitude = self.attitude?;
        let turned = self.sign_is_free && (0..4).map(|k| attitude[k] * last[k]).sum::<f64>() < 0.0;
        Some(if turned { attitude.map(|x| -x) } else { attitude })
    }

    /// The state in space of a body whose rates are those over the pace of the anomaly, and whose attitude is that seen
    /// from the frame of its orbit. The work of the gravity gradient is what the kinetic energy has gained.
    pub fn at(self, place: &OrbitPlace, start: &Body) -> State {
        let (omega, attitude) = (place.of_pace(self.omega), self.attitude.map(|q| place.of_frame(&q)));
        let work = Body { omega, ..*start }.kinetic_energy() - start.kinetic_energy();
        let direction = attitude.map(|q| to_body_frame(&q, &VERTICAL));
        let [jacobi, _] = self.invariants;
        let balance = Some(Balance { work, scales: [0.0; 2] });
        State { omega, attitude, direction, invariants: [jacobi, 0.0], balance, ..self }
    }
}

/// The state of the body in a lane.
pub fn unload(group: &Group, lane: usize, compiled: Compiled, assignment: KernelAssignment) -> State {
    let mut y = [0.0; MAX_STATE];
    for d in 0..compiled.kernel().system.len {
        y[d] = group.state[d].0[lane];
    }
    read(group, lane, compiled, assignment, y)
}

/// The state in the user's axes of the body in a lane, from the state `y` of the kernel.
pub fn read(
    group: &Group,
    lane: usize,
    compiled: Compiled,
    assignment: KernelAssignment,
    mut y: [f64; MAX_STATE],
) -> State {
    let kernel = compiled.kernel();
    let at = |rows: &[Row; 3]| [rows[0].0[lane], rows[1].0[lane], rows[2].0[lane]];
    let parameters = Parameters { moments: at(&group.moments), weight: at(&group.weight), step: 0.0 };
    let moments = &parameters.moments;
    let invariants = compiled.invariants(&parameters, &y);
    let quaternion = kernel.system.quaternion_at;
    let in_rows = kernel.system.has_rows();
    let row = |y: &[f64; MAX_STATE], at: usize| [y[at], y[at + 1], y[at + 2]];
    let tangent = kernel.system.tangent_at;
    let tangent = tangent.map(|at| assignment.deviation_of([row(&y, at), row(&y, at + 3)], *moments));
    // With a quaternion, the space axes are permuted like the body axes.
    let attitude_and_vertical = match quaternion {
        Some(at) => Some(([y[at], y[at + 1], y[at + 2], y[at + 3]], assignment.to_kernel_axes(VERTICAL))),
        None => in_rows.then(|| (attitude_of_rows(&row(&y, 6), &row(&y, 3)), VERTICAL)),
    };
    let has_vertical = kernel.system.scene.has_weight && kernel.system.vectors > 0;
    let invariants_of_attitude = attitude_and_vertical.filter(|_| has_vertical).map(|(q, vertical)| {
        let (mut of_attitude, size) = (y, length(&q));
        of_attitude[3..6].copy_from_slice(&to_body_frame(&q.map(|x| x / size), &vertical));
        compiled.invariants(&parameters, &of_attitude)
    });
    let states = kernel.system.states_at.map(|at| {
        let mut states = [0.0; MOST_STATES];
        states.copy_from_slice(&y[at..at + MOST_STATES]);
        states
    });
    if assignment.step.engine.variables() == Variables::Momenta {
        for k in 0..3 {
            y[k] /= moments[k];
        }
    }
    let omega = [y[0], y[1], y[2]];
    let balance = kernel.system.balance_at.map(|at| {
        let work = y[at];
        let momentum = [0, 1, 2].map(|k| moments[k] * omega[k]);
        let momentum2 = dot(&momentum, &momentum);
        let scale = kernel.system.scene.conserved.scale(momentum2.sqrt());
        Balance { work, scales: [0.5 * dot(&momentum, &omega) + work.abs(), scale] }
    });
    State {
        omega: assignment.to_body_axes([y[0], y[1], y[2]]),
        direction: match quaternion {
            Some(at) if kernel.system.turns => Some(vertical(&[y[at], y[at + 1], y[at + 2], y[at + 3]])),
            _ => (kernel.system.vectors > 0).then(|| assignment.to_body_axes([y[3], y[4], y[5]])),
        },
        attitude: match quaternion {
            Some(at) => {
                let [x, y1, z] = assignment.to_body_axes(row(&y, at + 1));
                Some([y[at], x, y1, z])
            }
            None => in_rows.then(|| {
                attitude_of_rows(&assignment.to_body_axes(row(&y, 6)), &assignment.to_body_axes(row(&y, 3)))
            }),
        },
        sign_is_free: in_rows,
        invariants,
        invariants_of_attitude,
        tangent,
        balance,
        states,
    }
}
