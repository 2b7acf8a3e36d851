"""Mirroring: an example as the other side would make it."""

import re

import msgspec
import numpy as np

from mossar_stream.errors import MovesError
from mossar_stream.moves.example import Example
from mossar_stream.moves.facing import girdles_of, mean_heading
from mossar_stream.moves.joints import known_joints
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
    """Return for each joint the one on the other side, or itself.

    Raises:
        MovesError: If the names tell no sides apart, or a joint has no counterpart.
    """
    known = known_joints(skeleton)
    place = {name: joint for joint, name in enumerate(skeleton.names)}
    found = [place.get(other_side(name), -1) for name in skeleton.names]
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


def mirrored(example: Example, skeleton: Skeleton) -> Example:
    """Return the mirror image of an example, across the plane between the body's sides; its name is that of the other side.

    Of a skeleton without hips the plane is that of y and z.

    Raises:
        MovesError: See `mirrored_joints`.
    """
    others = mirrored_joints(skeleton)
    joints = len(skeleton)
    cosine, sine = mean_heading(example.metres(joints), girdles_of(skeleton))
    return msgspec.structs.replace(
        example,
        name=other_side(example.name),
        positions=_image(example.positions, others, cosine, sine),
        whole=_image(example.whole, others, cosine, sine),
    )


def _image(numbers: tuple[int, ...], others: list[int], cosine: float, sine: float) -> tuple[int, ...]:
    """Return positions, n · J · 3 numbers, mirrored across the plane of the vertical and a heading."""
    positions = np.array(numbers, np.float64).reshape(-1, len(others), 3)[:, others]
    # Turned to the front, mirrored in x, turned back: a reflection whose axis has twice the angle of the heading.
    double_cosine, double_sine = cosine * cosine - sine * sine, 2 * cosine * sine
    x, z = positions[..., 0].copy(), positions[..., 2].copy()
    positions[..., 0] = -double_cosine * x + double_sine * z
    positions[..., 2] = double_sine * x + double_cosine * z
    return tuple(np.rint(positions).astype(np.int64).ravel().tolist())
