"""Angles of joints in degrees, and their ranges in each repetition.

Where joint centres are known by name, angles follow the terms of the International Society of Biomechanics, simplified to
angles that follow from positions without orientations:

    knee flexion        0 straight; between the thigh and the shank's continuation of it
    elbow flexion       0 straight; the same of upper arm and forearm
    hip flexion         0 standing; between the thigh and the trunk's continuation, in whichever direction the thigh goes
    shoulder elevation  0 hanging, 90 horizontal; between the upper arm and the trunk downwards
    ankle dorsiflexion  0 when the foot is at right angles to the shank; plantar flexion is negative
    trunk inclination   0 upright; between the trunk and the vertical
"""

from collections.abc import Mapping, Sequence
from typing import Any

import msgspec
import numpy as np
from numpy.typing import ArrayLike, NDArray

from mossar_stream.events import RepetitionEvent
from mossar_stream.moves.joints import known_joints
from mossar_stream.settings import Up
from mossar_stream.skeleton import Skeleton
from mossar_stream.steps.gait import asymmetry

AXES: dict[str, tuple[float, float, float]] = {
    "x": (1.0, 0.0, 0.0),
    "y": (0.0, 1.0, 0.0),
    "z": (0.0, 0.0, 1.0),
    "-x": (-1.0, 0.0, 0.0),
    "-y": (0.0, -1.0, 0.0),
    "-z": (0.0, 0.0, -1.0),
}
START, TOP = 0.1, 0.9  # shares of the range at which the way out begins, and the hold
LEAST = 1.0  # degrees; a smaller range has no way out, hold and way back
_TRUNK = "trunk_inclination"

Angles = dict[str, NDArray[np.float64]]


class RangeOfMotion(msgspec.Struct, frozen=True):
    """The range of an angle in one repetition.

    Args:
        channel: The repeating part, as in `RepetitionEvent`.
        count: Of the repetition in its bout.
        start: Of the repetition, s.
        end: s.
        angle: Its name, such as "left_knee_flexion".
        minimum: Degrees.
        maximum: Degrees.
        range: Degrees.
        up: s from 10 % of the range to 90 %, away from where the repetition begins; None if it goes less than 1 degree.
        hold: s beyond 90 %.
        down: s from 90 % back to 10 %.
        asymmetry: Percent: abs(left - right) / mean of the ranges of both sides; None of the trunk.
    """

    channel: str
    count: int
    start: float
    end: float
    angle: str
    minimum: float
    maximum: float
    range: float
    up: float | None
    hold: float | None
    down: float | None
    asymmetry: float | None


def joint_angles(positions: ArrayLike, skeleton: Skeleton, up: Up = "auto") -> Angles:
    """Return the angles of the joints that are known by name.

    Args:
        positions: (n, J, 3) m.
        skeleton: The joints.
        up: The axis that points upwards; `auto`: the one nearest to the direction from the feet to the head.

    Returns:
        Name to (n,) degrees, NaN where a joint is missing.

    Example:
        >>> leg = Skeleton(("left_hip", "left_knee", "left_ankle"), (-1, 0, 1))
        >>> pose = [[[0, 1, 0], [0, 0.5, 0], [0, 0.5, -0.5]]]
        >>> {name: angle.round(3).tolist() for name, angle in joint_angles(pose, leg).items()}
        {'left_knee_flexion': [90.0]}
    """
    frames = np.asarray(positions, np.float64)
    if frames.ndim != 3 or frames.shape[1:] != (len(skeleton), 3):
        raise ValueError(
            f"positions have shape {frames.shape}; the skeleton calls for (n, {len(skeleton)}, 3)"
        )
    places = {slot: frames[:, joint] for slot, joint in known_joints(skeleton).items()}
    upper = _middle(places, "left_shoulder", "right_shoulder", "chest")
    lower = _middle(places, "left_hip", "right_hip", "hips")
    trunk = None if upper is None or lower is None else upper - lower
    found: Angles = {}
    for side in ("left", "right"):
        at = {
            part: places.get(f"{side}_{part}")
            for part in ("hip", "knee", "ankle", "foot", "shoulder", "elbow", "wrist")
        }
        thigh, shank, foot = (
            _bone(at, *ends) for ends in (("hip", "knee"), ("knee", "ankle"), ("ankle", "foot"))
        )
        upper_arm, forearm = _bone(at, "shoulder", "elbow"), _bone(at, "elbow", "wrist")
        if thigh is not None and trunk is not None:
            found[f"{side}_hip_flexion"] = between(thigh, -trunk)
        if thigh is not None and shank is not None:
            found[f"{side}_knee_flexion"] = between(thigh, shank)
        if shank is not None and foot is not None:
            found[f"{side}_ankle_dorsiflexion"] = 90.0 - between(-shank, foot)
        if upper_arm is not None and trunk is not None:
            found[f"{side}_shoulder_elevation"] = between(upper_arm, -trunk)
        if upper_arm is not None and forearm is not None:
            found[f"{side}_elbow_flexion"] = between(upper_arm, forearm)
    upwards = _upwards(places, lower, trunk, up)
    if trunk is not None and upwards is not None:
        found[_TRUNK] = between(trunk, np.broadcast_to(upwards, trunk.shape))
    return found


def between(one: NDArray[np.float64], other: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the angle between vectors (n, 3), degrees; NaN of one without a length."""
    across = np.linalg.norm(np.cross(one, other), axis=-1)
    along = np.sum(one * other, axis=-1)
    known = (np.linalg.norm(one, axis=-1) > 0) & (np.linalg.norm(other, axis=-1) > 0)
    return np.where(known, np.degrees(np.arctan2(across, along)), np.nan)


def ranges_of_motion(
    angles: Mapping[str, NDArray[np.float64]],
    times: NDArray[np.float64],
    repetitions: Sequence[RepetitionEvent],
) -> list[RangeOfMotion]:
    """Return the range of each angle in each repetition, in the order of time.

    Args:
        angles: Of `joint_angles`, n frames.
        times: (n,) s, increasing.
        repetitions: That are counted.
    """
    found = []
    for event in repetitions:
        if event.start is None or event.end is None:
            continue
        inside = (times >= event.start) & (times <= event.end)
        curves = {name: angle[inside] for name, angle in angles.items()}
        spans = {
            name: float(np.nanmax(own) - np.nanmin(own)) for name, own in curves.items() if _is_known(own)
        }
        for name, span in spans.items():
            own = curves[name]
            other = (
                name.replace("left_", "right_")
                if name.startswith("left_")
                else name.replace("right_", "left_")
            )
            parts = _phases(own, times[inside]) if span >= LEAST else (None, None, None)
            uneven = asymmetry(span, spans.get(other)) if other != name else None
            low, high = float(np.nanmin(own)), float(np.nanmax(own))
            found.append(
                RangeOfMotion(
                    event.channel,
                    event.count,
                    event.start,
                    event.end,
                    name,
                    low,
                    high,
                    span,
                    *parts,
                    uneven,
                )
            )
    return found


def _is_known(curve: NDArray[np.float64]) -> bool:
    return int(np.count_nonzero(np.isfinite(curve))) >= 2


def _phases(
    curve: NDArray[np.float64], times: NDArray[np.float64]
) -> tuple[float | None, float | None, float | None]:
    """Return the durations of the way out, the hold and the way back, s; None for a part that the repetition lacks."""
    known = np.isfinite(curve)
    value, moments = curve[known], times[known]
    share = (value - value.min()) / (value.max() - value.min())
    if share[0] + share[-1] > 1.0:  # it begins bent, and goes out by straightening
        share = 1.0 - share
    far = np.flatnonzero(share >= TOP)
    first, last = int(far[0]), int(far[-1])
    near = np.flatnonzero(share <= START)
    before, after = near[near < first], near[near > last]
    reached = _crossed(share, moments, first, TOP, -1)
    left = _crossed(share, moments, last, TOP, 1)
    up = None if not len(before) else reached - _crossed(share, moments, int(before[-1]), START, 1)
    down = None if not len(after) else _crossed(share, moments, int(after[0]), START, -1) - left
    return up, left - reached, down


def _crossed(
    share: NDArray[np.float64], times: NDArray[np.float64], at: int, level: float, towards: int
) -> float:
    """Return the time at which a curve passes a level between a sample and its neighbour, s; at the sample if there is none."""
    other = at + towards
    if not 0 <= other < len(share) or share[other] == share[at]:
        return float(times[at])
    part = min(max((level - share[at]) / (share[other] - share[at]), 0.0), 1.0)
    return float(times[at] + part * (times[other] - times[at]))


def _middle(
    places: Mapping[str, NDArray[np.float64]], left: str, right: str, own: str
) -> NDArray[np.float64] | None:
    if left in places and right in places:
        return (places[left] + places[right]) / 2
    return places.get(own)


def _bone(at: Mapping[str, NDArray[np.float64] | None], begin: str, end: str) -> NDArray[np.float64] | None:
    one, other = at[begin], at[end]
    return None if one is None or other is None else other - one


def _upwards(
    places: Mapping[str, NDArray[np.float64]], hips: Any, trunk: Any, up: Up
) -> NDArray[np.float64] | None:
    """Return the direction upwards: an axis."""
    if up != "auto":
        return np.array(AXES[up])
    feet = _middle(places, "left_ankle", "right_ankle", "left_foot")
    legs = None if feet is None or hips is None else hips - feet
    whole = legs if trunk is None else trunk if legs is None else legs + trunk
    if whole is None or not np.isfinite(whole).any():
        return None
    mean = np.nanmean(whole, axis=0)
    axis = int(np.nanargmax(np.abs(mean)))
    return np.asarray(np.eye(3)[axis] * np.sign(mean[axis]))
