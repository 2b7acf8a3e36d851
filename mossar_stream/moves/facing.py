"""Facing: the joints that show the facing of a body; the kernels are in `facing.pxi`."""

import numpy as np
from numpy.typing import NDArray

from mossar_stream.moves.joints import known_joints
from mossar_stream.skeleton import Skeleton

GIRDLES = ("left_hip", "right_hip", "left_shoulder", "right_shoulder")


def girdles_of(skeleton: Skeleton) -> NDArray[np.int64]:
    """Return the indices of the joints of `GIRDLES` in a skeleton, (4,); -1 where it has none of that name.

    Example:
        >>> girdles_of(Skeleton(("hips", "LeftHip", "RightHip", "neck")))
        array([ 1,  2, -1, -1])
    """
    known = known_joints(skeleton)
    return np.array([known.get(slot, -1) for slot in GIRDLES], np.int64)
