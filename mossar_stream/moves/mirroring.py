"""Mirroring: an example with left and right exchanged."""

import re
from typing import NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_stream.core.kernels import mean_heading
from mossar_stream.errors import MovesError
from mossar_stream.joint_names import counterparts
from mossar_stream.moves.example import Example
from mossar_stream.moves.facing import girdles_of
from mossar_stream.moves.joints import known_joints
from mossar_stream.moves.points import UPWARDS
from mossar_stream.moves.pose import Pose
from mossar_stream.settings import Up
from mossar_stream.skeleton import Skeleton

_SIDE = re.compile("left|right", re.IGNORECASE)


def other_side(name: str) -> str:
    """Return a name with left and right exchanged.

    Example:
        >>> other_side("jab_left"), other_side("RightHand"), other_side("duck")
        ('jab_right', 'LeftHand', 'duck')
    """

    def exchanged(found: re.Match[str]) -> str:
        side = "right" if found[0].lower() == "left" else "left"
        return side.upper() if found[0].isupper() else side.title() if found[0].istitle() else side

    return _SIDE.sub(exchanged, name)


def mirrored_joints(skeleton: Skeleton) -> list[int]:
    """Return the joint on the other side for each joint, or itself.

    Raises:
        MovesError: If the names have no sides, or a joint has no counterpart.
    """
    known = known_joints(skeleton)
    found = counterparts(skeleton.names)
    for slot, joint in known.items():
        found[joint] = known.get(other_side(slot), -1)
    for joint, other in enumerate(found):
        if other < 0:
            raise MovesError(
                f"a mirrored move needs joints of both sides; {skeleton.names[joint]!a} has none"
            )
    if found == list(range(len(found))) or [found[other] for other in found] != list(range(len(found))):
        raise MovesError("a mirrored move needs joints whose names say left and right")
    return found


def mirrored(example: Example, skeleton: Skeleton, up: Up = "y") -> Example:
    """Return the mirror image of an example, across the plane between the body's sides; its name is that of the other side.

    Of a skeleton without hips the plane is that of the vertical and the next axis: of y and z, or of z and x.

    Args:
        example: Of a move.
        skeleton: Of the example.
        up: The axis that points upwards; `auto` is y.

    Raises:
        MovesError: See `mirrored_joints`.
    """
    plane = _plane_of(example.metres(len(skeleton)), skeleton, up)
    return msgspec.structs.replace(
        example,
        name=other_side(example.name),
        positions=plane.image(example.positions),
        whole=plane.image(example.whole),
    )


def mirrored_pose(pose: Pose, skeleton: Skeleton, up: Up = "y") -> Pose:
    """Return the mirror image of a pose; see `mirrored`."""
    shown = pose.metres(len(skeleton))[None].astype(np.float32)
    plane = _plane_of(shown, skeleton, up)
    return msgspec.structs.replace(pose, name=other_side(pose.name), positions=plane.image(pose.positions))


class _Plane(NamedTuple):
    """The plane between the sides of a body: of the vertical and its heading."""

    others: list[int]  # of each joint the one on the other side
    # Two that span the ground: a body that faces along the second has its left along the first.
    axes: list[int]
    cosine: float
    sine: float

    def image(self, numbers: tuple[int, ...]) -> tuple[int, ...]:
        """Return positions, n · J · 3 numbers, mirrored."""
        return _image(numbers, *self)


def _plane_of(positions: NDArray[np.float32], skeleton: Skeleton, up: Up) -> _Plane:
    """Return the plane between the sides of a body that moves."""
    axis, sign = UPWARDS[up]
    turned = [(axis + 2) % 3, axis, (axis + 1) % 3]
    upright = positions[:, :, turned] * np.array([sign, sign, 1.0], np.float32)
    cosine, sine = mean_heading(np.ascontiguousarray(upright), girdles_of(skeleton))
    return _Plane(mirrored_joints(skeleton), [turned[0], turned[2]], cosine, sign * sine)


def _image(
    numbers: tuple[int, ...], others: list[int], axes: list[int], cosine: float, sine: float
) -> tuple[int, ...]:
    positions = np.array(numbers, np.float64).reshape(-1, len(others), 3)[:, others]
    # Turned to the front, mirrored in x, turned back: a reflection whose axis has twice the angle of the heading.
    double_cosine, double_sine = cosine * cosine - sine * sine, 2 * cosine * sine
    x, z = positions[..., axes[0]].copy(), positions[..., axes[1]].copy()
    positions[..., axes[0]] = -double_cosine * x + double_sine * z
    positions[..., axes[1]] = double_sine * x + double_cosine * z
    return tuple(np.rint(positions).astype(np.int64).ravel().tolist())
