"""Layout: how the bytes of shown poses, and of a performer who may hold them, are laid out."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mossar_stream.following.layout import BONE, BONE_BYTES, BONE_POINT, BONE_POINT_BYTES
from mossar_stream.jit.decorators import inline_kernel
from mossar_stream.jit.views import part

POSES_HEAD = np.dtype(
    [
        ("points", "i8"),
        ("bones", "i8"),
        ("groups", "i8"),  # limbs that have bones; bones of none are one, too
        ("poses", "i8"),
        ("axis", "i8"),  # that points upwards
        ("sign", "f8"),
        ("girdles", "i8", (4,)),  # points of hips and shoulders, left before right; -1 for as shown
    ]
)
SHOWN = np.dtype([("name", "i8"), ("hold", "f8")])  # number of its name; s
HOLDING_STATE = np.dtype(
    [
        ("due", "f8"),  # s, when the next sample is due; see readers.py
        ("frames", "i8"),  # sampled since the last gap
        ("time", "f8"),  # s, of the last sample
        ("facing", "f8", (2,)),  # x and z, smoothed
        ("near", "i8"),  # pose that the performer is near to, -1 for none
        ("since", "f8"),  # s, from when on
        ("active", "i8"),  # pose that is held, -1 for none
        (
            "latest",
            "i8",
        ),  # the one that is held or was last, of which start, seen, matched, number and rev are
        ("is_held", "i8"),  # whether that was reported
        ("start", "f8"),  # s
        ("seen", "f8"),  # s, when it was last held
        ("matched", "i8"),  # samples since its start
        ("number", "i8"),  # of the latest pose of the take
        ("rev", "i8"),
        ("happened", "i8"),  # at the last frame
    ]
)
POSES_HEAD_BYTES, SHOWN_BYTES, HOLDING_STATE_BYTES = (
    POSES_HEAD.itemsize,
    SHOWN.itemsize,
    HOLDING_STATE.itemsize,
)


class Bank(NamedTuple):
    """Shown poses, described for a stream."""

    head: NDArray[np.void]  # (1,) POSES_HEAD
    points: NDArray[np.void]  # (K,) BONE_POINT
    bones: NDArray[np.void]  # (B,) BONE; `limb` is the number of a group
    shown: NDArray[np.void]  # (P,) SHOWN
    rows: NDArray[np.float64]  # (P, B, 3) directions


class Memory(NamedTuple):
    """What is known of a performer."""

    state: NDArray[np.void]  # (1,) HOLDING_STATE
    fast: NDArray[np.float64]  # (B, 3) directions, averaged over `SMOOTHED`
    slow: NDArray[np.float64]  # (B, 3) the same over `SETTLED`
    strays: NDArray[np.float64]  # (B,) squares of the chord to the pose that is held, summed over samples
    chords: NDArray[np.float64]  # (B,) the same of the pose that is looked at, now
    groups: NDArray[np.float64]  # (2, G) mean of those over each limb, and how many bones it has
    pose: NDArray[np.float32]  # (K, 3) m, points of the last sample relative to the centre, y upwards


def bank_bytes(points: int, bones: int, poses: int) -> int:
    """Return the bytes of a bank."""
    return (
        POSES_HEAD_BYTES
        + points * BONE_POINT_BYTES
        + bones * BONE_BYTES
        + poses * SHOWN_BYTES
        + 8 * poses * bones * 3
    )


def memory_bytes(points: int, bones: int, groups: int) -> int:
    """Return the bytes that a performer takes."""
    return HOLDING_STATE_BYTES + 8 * (2 * 3 * bones + 2 * bones + 2 * groups) + 4 * 3 * points


@inline_kernel(returns_views=True)
def open_bank(store):
    """Return the bank that a store holds."""
    head = part(store, 0, POSES_HEAD, (1,))
    points, bones, poses = head[0].points, head[0].bones, head[0].poses
    at_bones = POSES_HEAD_BYTES + points * BONE_POINT_BYTES
    at_shown = at_bones + bones * BONE_BYTES
    return Bank(
        head,
        part(store, POSES_HEAD_BYTES, BONE_POINT, (points,)),
        part(store, at_bones, BONE, (bones,)),
        part(store, at_shown, SHOWN, (poses,)),
        part(store, at_shown + poses * SHOWN_BYTES, np.float64, (poses, bones, 3)),
    )


@inline_kernel(returns_views=True)
def open_memory(memory, head):
    """Return what is known of a performer."""
    points, bones, groups = head.points, head.bones, head.groups
    at_slow = HOLDING_STATE_BYTES + 8 * 3 * bones
    at_strays = at_slow + 8 * 3 * bones
    at_groups = at_strays + 8 * 2 * bones
    return Memory(
        part(memory, 0, HOLDING_STATE, (1,)),
        part(memory, HOLDING_STATE_BYTES, np.float64, (bones, 3)),
        part(memory, at_slow, np.float64, (bones, 3)),
        part(memory, at_strays, np.float64, (bones,)),
        part(memory, at_strays + 8 * bones, np.float64, (bones,)),
        part(memory, at_groups, np.float64, (2, groups)),
        part(memory, at_groups + 8 * 2 * groups, np.float32, (points, 3)),
    )
