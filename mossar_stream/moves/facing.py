"""Facing: which way a body is turned about the vertical (y), by its hips and shoulders.

The girdles and the trunk span a frame of the body: left is from the right hips and shoulders to the left ones, up is from
the hips to the shoulders, forward is what both span. The facing is the twist of that frame about the vertical. A body
that bows, ducks or does a cartwheel keeps it, which the line of the hips alone does not: it turns over in a cartwheel.
A twist is undefined only for a body upside down; the vector shrinks towards it, so that sums over time remain sound.
"""

import numpy as np
from numpy.typing import NDArray

from mossar_stream.jit.decorators import entry_point, inline_kernel, kernel
from mossar_stream.moves.joints import known_joints
from mossar_stream.skeleton import Skeleton

GIRDLES = ("left_hip", "right_hip", "left_shoulder", "right_shoulder")
SETTLING = 0.3  # s, time constant of a facing that is smoothed
LEAST_WIDTH = np.float32(1e-3)  # m, of a girdle or a trunk: less has no direction


def girdles_of(skeleton: Skeleton) -> NDArray[np.int64]:
    """Return where the joints of `GIRDLES` are in a skeleton, (4,); -1 where it has none of that name.

    Example:
        >>> girdles_of(Skeleton(("hips", "LeftHip", "RightHip", "neck")))
        array([ 1,  2, -1, -1])
    """
    known = known_joints(skeleton)
    return np.array([known.get(slot, -1) for slot in GIRDLES], np.int64)


@kernel
def facing_of(joints, girdles):
    """Return the way that a pose faces in the ground plane, not scaled to one.

    Args:
        joints: (J, 3) float32 metres, y up; NaN where a joint is missing.
        girdles: (4,) from `girdles_of`.

    Returns:
        x and z; (0, 1) for an upright body that faces +z, with its left side towards +x. The length is 1 for an upright
        body, less for a body that leans, and 0 if neither both hips nor both shoulders are there.
    """
    hip_x, hip_y, hip_z = _across(joints, girdles[0], girdles[1])
    shoulder_x, shoulder_y, shoulder_z = _across(joints, girdles[2], girdles[3])
    left_x, left_y, left_z = _unit(hip_x + shoulder_x, hip_y + shoulder_y, hip_z + shoulder_z)
    up_x, up_y, up_z = _trunk(joints, girdles)
    half = np.float32(0.5)
    forward_x = left_y * up_z - left_z * up_y
    forward_z = left_x * up_y - left_y * up_x
    return half * (forward_x - left_z), half * (forward_z + left_x)


@inline_kernel
def _across(joints, left, right):
    """Return the way from the right joint of a girdle to the left one, m; zero if one is missing."""
    if left < 0 or right < 0:
        return np.float32(0.0), np.float32(0.0), np.float32(0.0)
    x = joints[left, 0] - joints[right, 0]
    y = joints[left, 1] - joints[right, 1]
    z = joints[left, 2] - joints[right, 2]
    if np.isnan(x + y + z):
        return np.float32(0.0), np.float32(0.0), np.float32(0.0)
    return x, y, z


@inline_kernel
def _trunk(joints, girdles):
    """Return the unit direction from the hips to the shoulders; up if a girdle is missing."""
    x = y = z = np.float32(0.0)
    for i in range(4):
        sign = np.float32(-1.0) if i < 2 else np.float32(1.0)
        joint = girdles[i]
        if joint < 0:
            return np.float32(0.0), np.float32(1.0), np.float32(0.0)
        x += sign * joints[joint, 0]
        y += sign * joints[joint, 1]
        z += sign * joints[joint, 2]
    x, y, z = _unit(x, y, z)
    if np.isnan(x + y + z) or x * x + y * y + z * z == 0.0:
        return np.float32(0.0), np.float32(1.0), np.float32(0.0)
    return x, y, z


@inline_kernel
def _unit(x, y, z):
    length = np.sqrt(x * x + y * y + z * z)
    if length < LEAST_WIDTH:
        return np.float32(0.0), np.float32(0.0), np.float32(0.0)
    return x / length, y / length, z / length


@inline_kernel
def smooth_facing(held, x, z, seconds):
    """Let a facing follow that of one more pose, with the time constant `SETTLING`.

    Args:
        held: (2,) float64, x and z of the smoothed facing; zeros before the first pose.
        x: Of `facing_of`; zero together with `z` where it is unknown: the facing stays.
        z: The same.
        seconds: Since the pose before.
    """
    if x * x + z * z == 0.0:
        return
    if held[0] * held[0] + held[1] * held[1] == 0.0:
        held[0], held[1] = x, z
        return
    share = 1.0 - np.exp(-seconds / SETTLING)
    held[0] += share * (x - held[0])
    held[1] += share * (z - held[1])


@inline_kernel
def heading(x, z):
    """Return the cosine and the sine of the turn from facing +z to facing (x, z); no turn if that is zero."""
    length = np.sqrt(x * x + z * z)
    if length < np.float32(1e-6):
        return x * 0 + 1, x * 0
    return z / length, x / length


@inline_kernel
def turned_back(x, z, cosine, sine):
    """Return where a point (x, z) would be if the body faced +z.

    Args:
        x: Of a point or a direction.
        z: The same.
        cosine: Of the body's `heading`.
        sine: The same.
    """
    return cosine * x - sine * z, sine * x + cosine * z


@entry_point
def mean_heading(positions, girdles):
    """Return the cosine and the sine of a movement's mean heading; no turn where there are no hips.

    Args:
        positions: (n, J, 3) float32 metres.
        girdles: (4,) from `girdles_of`.
    """
    x = z = np.float32(0.0)
    if girdles[0] >= 0 and girdles[1] >= 0:
        for i in range(positions.shape[0]):
            facing_x, facing_z = facing_of(positions[i], girdles)
            x += facing_x
            z += facing_z
    cosine, sine = heading(x, z)
    return cosine, sine
