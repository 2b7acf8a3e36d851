"""Stick figures: a skeleton seen obliquely from its own front, as lines on paper."""

import re

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_stream import Skeleton, counterparts, read_joint_names

Floats = NDArray[np.float64]

TURN = np.radians(40)  # between the body's front and the line of sight

_SIDES = (
    (re.compile(r"left", re.IGNORECASE), re.compile(r"right", re.IGNORECASE)),
    (re.compile(r"^l[_.:]?(?=[A-Za-z])"), re.compile(r"^r[_.:]?(?=[A-Za-z])")),
    (re.compile(r"^L(?=[A-Z_])"), re.compile(r"^R(?=[A-Z_])")),
    (re.compile(r"[_.]l$", re.IGNORECASE), re.compile(r"[_.]r$", re.IGNORECASE)),
)
_TOP = re.compile(r"head|neck|nose|thorax|chest", re.IGNORECASE)
_BOTTOM = re.compile(r"foot|toe|ankle|heel", re.IGNORECASE)
_MIDDLE = re.compile(r"spine|pelvis|hip|torso", re.IGNORECASE)  # the lowest joint where there are no feet
_HEAD = re.compile(r"^(head|nose|.*[_:. ]head)$", re.IGNORECASE)


class View(msgspec.Struct, frozen=True):
    """View of the skeletons of a recording.

    Args:
        up: Index of the vertical axis.
        sign: 1 if its larger values are higher, else -1.
        pairs: Left and right joints that belong together.
        height: Of the usual figure, m.
    """

    up: int
    sign: float
    pairs: tuple[tuple[int, int], ...]
    height: float


def view_of(skeleton: Skeleton, poses: Floats) -> View:
    """Return the view of the skeletons of a recording.

    Args:
        skeleton: J joints.
        poses: (n, J, 3) m, NaN where a joint is missing.
    """
    known = poses[np.isfinite(poses).all(axis=2).mean(axis=1) >= 0.5]
    if not len(known):
        return View(1, 1.0, (), 1.7)
    extent = np.nanmedian(np.nanmax(known, axis=1) - np.nanmin(known, axis=1), axis=0)
    up = int(np.argmax(extent))
    top = _joints(skeleton, _TOP)
    bottom = _joints(skeleton, _BOTTOM) or _joints(skeleton, _MIDDLE)
    sign = 1.0
    if top and bottom:
        rise = np.nanmean(known[:, top, up]) - np.nanmean(known[:, bottom, up])
        sign = -1.0 if rise < 0 else 1.0
    return View(up, sign, _pairs(skeleton), max(float(extent[up]), 1e-6))


def project(pose: Floats, view: View) -> Floats:
    """Return a pose on paper: (J, 2) m, centred, up is positive; the body faces the reader and to the right.

    Args:
        pose: (J, 3) m, right-handed axes.
        view: How to look.
    """
    upward = np.zeros(3)
    upward[view.up] = view.sign
    to_left = leftward(pose, upward, view)
    forward = np.cross(to_left, upward)
    across = np.cos(TURN) * to_left + np.sin(TURN) * forward
    flat = np.stack([pose @ across, pose @ upward], axis=1)
    flat[:, 0] -= np.nanmean(flat[:, 0]) if np.isfinite(flat[:, 0]).any() else 0.0
    return flat


def sides(skeleton: Skeleton) -> NDArray[np.intp]:
    """Return the side of each joint: 1 left, -1 right, 0 middle or unknown; (J,)."""
    found = np.zeros(len(skeleton), np.intp)
    for left, right in _pairs(skeleton):
        found[left], found[right] = 1, -1
    return found


def head_of(skeleton: Skeleton) -> int:
    """Return the joint to draw a head at, -1 if none is called so."""
    heads = _joints(skeleton, _HEAD)
    return heads[0] if heads else -1


def leftward(pose: Floats, upward: Floats, view: View) -> Floats:
    """Return the level direction from right to left, (3,); without known sides, that of the widest spread."""
    level = pose - np.outer(pose @ upward, upward)
    spans = np.array([level[left] - level[right] for left, right in view.pairs]).reshape(-1, 3)
    spans = spans[np.isfinite(spans).all(axis=1)]
    # Hips and shoulders show the facing of the body; hands and feet may be anywhere.
    near = spans[np.linalg.norm(spans, axis=1) < 0.3 * view.height]
    direction = (near if len(near) else spans).sum(axis=0)
    length = float(np.linalg.norm(direction))
    if length > 1e-6:
        return np.asarray(direction / length, np.float64)
    present = level[np.isfinite(level).all(axis=1)]
    widest = np.linalg.eigh(np.cov(present.T))[1][:, -1] if len(present) > 2 else np.roll(upward, 1)
    return np.asarray(widest, np.float64)


def _joints(skeleton: Skeleton, words: re.Pattern[str]) -> list[int]:
    return [i for i, name in enumerate(skeleton.names) if words.search(name)]


def _pairs(skeleton: Skeleton) -> tuple[tuple[int, int], ...]:
    for left, right in _SIDES:
        rights = {
            right.sub("*", name, count=1): i for i, name in enumerate(skeleton.names) if right.search(name)
        }
        lefts = {
            left.sub("*", name, count=1): i for i, name in enumerate(skeleton.names) if left.search(name)
        }
        both = tuple((lefts[name], rights[name]) for name in lefts if name in rights)
        if len(both) >= 2:
            return both
    read, others = read_joint_names(skeleton.names), counterparts(skeleton.names)
    found = tuple((j, other) for j, other in enumerate(others) if other >= 0 and read[j].side == "left")
    return found if len(found) >= 2 else ()
