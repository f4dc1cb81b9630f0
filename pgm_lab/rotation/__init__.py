"""Rotation matrices: from object space into image space, and every way to write them.

`matrix` gives M = M_kappa M_phi M_omega. It turns a vector of object space into the
image space of a camera that looks along its negative z axis: (U, V, W) = M (X - X0).
The rows of M are the camera's axes in object space. Angles are in radians; a positive
one turns the camera counter-clockwise as seen from the tip of the axis. Rodrigues
vectors and quaternions have the same sense.
"""

from pgm_lab.rotation.axis import (
    angle_between,
    from_quaternion,
    from_rodrigues,
    to_quaternion,
    to_rodrigues,
)
from pgm_lab.rotation.check import best_fit, defect, nearest
from pgm_lab.rotation.euler import (
    angles,
    derivatives,
    from_tilt_azimuth_swing,
    is_gimbal,
    matrix,
    small_angle,
    to_tilt_azimuth_swing,
)

__all__ = [
    "angle_between",
    "angles",
    "best_fit",
    "defect",
    "derivatives",
    "from_quaternion",
    "from_rodrigues",
    "from_tilt_azimuth_swing",
    "is_gimbal",
    "matrix",
    "nearest",
    "small_angle",
    "to_quaternion",
    "to_rodrigues",
    "to_tilt_azimuth_swing",
]
