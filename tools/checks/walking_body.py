"""A body that walks, small enough to be written into tests of readers and streams."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mossar_stream import Skeleton

# Joint, parent, place from the parent in a stance (m).
_JOINTS = """
Hips - 0 0.95 0
Spine Hips 0 0.15 0
Chest Spine 0 0.2 0
Neck Chest 0 0.2 0
Head Neck 0 0.12 0
LeftArm Chest 0.2 0.15 0
LeftForeArm LeftArm 0.27 0 0
LeftHand LeftForeArm 0.25 0 0
RightArm Chest -0.2 0.15 0
RightForeArm RightArm -0.27 0 0
RightHand RightForeArm -0.25 0 0
LeftUpLeg Hips 0.1 -0.05 0
LeftLeg LeftUpLeg 0 -0.42 0
LeftFoot LeftLeg 0 -0.42 0
RightUpLeg Hips -0.1 -0.05 0
RightLeg RightUpLeg 0 -0.42 0
RightFoot RightLeg 0 -0.42 0
"""
_ROWS = [line.split() for line in _JOINTS.split("\n") if line]
NAMES = tuple(row[0] for row in _ROWS)
PARENTS = tuple(NAMES.index(row[1]) if row[1] in NAMES else -1 for row in _ROWS)
BODY = Skeleton(NAMES, PARENTS)


def walking(frames: int = 240, fps: float = 60.0, way: float = 6.0) -> NDArray[Any]:
    """Return (n, 17, 3) metres: a body that waves and sways, and is carried so far along x."""
    time = np.arange(frames) / fps
    places = np.zeros((frames, len(NAMES), 3))
    for joint, row in enumerate(_ROWS):
        places[:, joint] = [float(value) for value in row[2:]]
        if PARENTS[joint] >= 0:
            places[:, joint] += places[:, PARENTS[joint]]
    places[..., 0] += (way * time / max(time[-1], 1e-9))[:, None]
    places[..., 1] += 0.02 * np.sin(2 * np.pi * time)[:, None]
    hand = NAMES.index("RightHand")
    places[:, hand, 1] += 0.3 * np.sin(2 * np.pi * time / 1.5) ** 2
    return places


def with_joints_above(
    names: Sequence[str], places: ArrayLike
) -> tuple[Skeleton, Callable[[NDArray[Any]], NDArray[Any]]]:
    """Return the skeleton with joints above the hips, one below the other, and a function that adds them to a body's positions.

    Args:
        names: Of the joints, the topmost first.
        places: (n, K, 3) of them, or an array that can be broadcast to it.
    """
    count = len(names)
    parents = (*range(-1, count - 1), *(parent + count if parent >= 0 else count - 1 for parent in PARENTS))

    def positions(body: NDArray[Any]) -> NDArray[Any]:
        above = np.broadcast_to(np.asarray(places, float), (len(body), count, 3))
        return np.concatenate([above, body], axis=1)

    return Skeleton((*names, *NAMES), parents), positions
