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

from .._checks.exported import exported as _exported
from .euler import EulerRates as EulerRates
from .euler import euler_axes as euler_axes
from .euler import euler_rates_from_omega as euler_rates_from_omega
from .euler import euler_to_matrix as euler_to_matrix
from .euler import euler_to_quaternion as euler_to_quaternion
from .euler import matrix_to_euler as matrix_to_euler
from .euler import omega_from_euler_rates as omega_from_euler_rates
from .euler import quaternion_to_euler as quaternion_to_euler
from .euler import rotation_x as rotation_x
from .euler import rotation_y as rotation_y
from .euler import rotation_z as rotation_z
from .quaternions import canonical_quaternion as canonical_quaternion
from .quaternions import exp_quaternion as exp_quaternion
from .quaternions import log_quaternion as log_quaternion
from .quaternions import log_so3 as log_so3
from .quaternions import matrix_to_quaternion as matrix_to_quaternion
from .quaternions import quaternion_product as quaternion_product
from .quaternions import quaternion_to_matrix as quaternion_to_matrix
from .sampled import AttitudePath as AttitudePath
from .sampled import attitude_from_omega as attitude_from_omega
from .sampled import attitude_from_samples as attitude_from_samples
from .sampled import omega_from_attitudes as omega_from_attitudes
from .so3 import Orthogonality as Orthogonality
from .so3 import axis_angle_matrix as axis_angle_matrix
from .so3 import exp_so3 as exp_so3
from .so3 import hat as hat
from .so3 import nearest_rotation as nearest_rotation
from .so3 import orthogonality_error as orthogonality_error
from .so3 import rotate as rotate
from .so3 import vee as vee

__all__ = _exported(globals())
