"""Rotations: elementary and about any axis, Euler angles, quaternions, and their rates.

All rotations are active and take the body to space, ``v_space = R v_body``, ``R' = R hat(omega)``,
with ``omega`` in the body. Quaternions are scalar first, ``(w, x, y, z)``. Euler angles are z-x-z,
``R = Rz(phi) Rx(theta) Rz(psi)``. For the passive matrix of textbooks, the transpose, pass
``passive=True``. All functions broadcast over leading axes.

=============================  ===========================================================
elementary, about an axis      rotation_x, rotation_y, rotation_z; axis_angle_matrix, rotate
vectors                        hat, vee; exp_so3, log_so3; exp_quaternion, log_quaternion
quaternions                    quaternion_product, quaternion_to_matrix,
                               matrix_to_quaternion, canonical_quaternion
Euler angles                   euler_to_matrix, matrix_to_euler, euler_to_quaternion,
                               quaternion_to_euler
their rates                    euler_axes, omega_from_euler_rates, euler_rates_from_omega
along a motion                 omega_from_attitudes, attitude_from_omega,
                               attitude_from_samples
repair of matrices             orthogonality_error, nearest_rotation
=============================  ===========================================================

The package uses NumPy and ``_checks`` only; a spline of samples needs SciPy. All physics modules
use the package.
"""

from __future__ import annotations

from .euler import (
    EulerRates,
    euler_axes,
    euler_rates_from_omega,
    euler_to_matrix,
    euler_to_quaternion,
    matrix_to_euler,
    omega_from_euler_rates,
    quaternion_to_euler,
    rotation_x,
    rotation_y,
    rotation_z,
)
from .quaternions import (
    canonical_quaternion,
    exp_quaternion,
    log_quaternion,
    log_so3,
    matrix_to_quaternion,
    quaternion_product,
    quaternion_to_matrix,
)
from .sampled import (
    AttitudePath,
    attitude_from_omega,
    attitude_from_samples,
    omega_from_attitudes,
)
from .so3 import (
    Orthogonality,
    axis_angle_matrix,
    exp_so3,
    hat,
    nearest_rotation,
    orthogonality_error,
    rotate,
    vee,
)

__all__ = [
    "AttitudePath",
    "EulerRates",
    "Orthogonality",
    "attitude_from_omega",
    "attitude_from_samples",
    "axis_angle_matrix",
    "canonical_quaternion",
    "euler_axes",
    "euler_rates_from_omega",
    "euler_to_matrix",
    "euler_to_quaternion",
    "exp_quaternion",
    "exp_so3",
    "hat",
    "log_quaternion",
    "log_so3",
    "matrix_to_euler",
    "matrix_to_quaternion",
    "nearest_rotation",
    "omega_from_attitudes",
    "omega_from_euler_rates",
    "orthogonality_error",
    "quaternion_product",
    "quaternion_to_euler",
    "quaternion_to_matrix",
    "rotate",
    "rotation_x",
    "rotation_y",
    "rotation_z",
    "vee",
]
