"""The checked input of `Slots`: a wrong value changes nothing."""

import math
from typing import Any, Final, Literal, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mossar_adapters.receiving.batch import FARTHEST
from mossar_stream import FrameError, SettingsError, Skeleton

People = int | Literal["nearest", "first"]

MOST: Final = 64  # slots
_NUMBERS: Final = (int, float, np.integer, np.floating)
_FLOATS: Final = (np.dtype(np.float32), np.dtype(np.float64))


def checked_people(people: object) -> People:
    """Return for whom slots are kept: an int, or a word. OSC clients such as Pure Data send all numbers as floats.

    Raises:
        SettingsError: If it is neither a possible number nor a word.
    """
    if isinstance(people, str) and people in {"nearest", "first"}:
        return cast("People", people)
    if isinstance(people, _NUMBERS) and not isinstance(people, bool) and float(people).is_integer():
        count = int(people)
        if 1 <= count <= MOST:
            return count
    raise SettingsError(f"people must be 1 to {MOST}, nearest or first, not {repr(people)[:40]}")


def checked_seconds(name: str, seconds: object) -> float:
    """Return a duration, s.

    Raises:
        SettingsError: If it is no number, or negative.
    """
    if isinstance(seconds, _NUMBERS) and not isinstance(seconds, bool) and seconds >= 0:
        return float(seconds)
    raise SettingsError(f"{name} must be a number of seconds from 0, not {repr(seconds)[:40]}")


def checked_moment(ident: object, time: object) -> float:
    """Return the time of a pose, s.

    Raises:
        FrameError: If it is no finite number, or the id is no text.
    """
    if not isinstance(ident, str):
        raise FrameError(f"an id is text, as str(7), not {repr(ident)[:40]}")
    if isinstance(time, _NUMBERS) and math.isfinite(time):
        return float(time)
    raise FrameError(f"a time is a finite number of seconds, not {repr(time)[:40]}")


def checked_skeleton(ident: object, skeleton: object) -> None:
    """Check the announcement of an id.

    Raises:
        FrameError: If the id is no text, or the skeleton none.
    """
    if not isinstance(ident, str) or not isinstance(skeleton, Skeleton):
        raise FrameError(f"an id, as text, is announced with a Skeleton, not {repr((ident, skeleton))[:60]}")


def checked_pose(pose: ArrayLike) -> NDArray[Any]:
    """Return a pose as floats, (J, 3) metres; masked numbers are missing.

    Raises:
        FrameError: If it is none.
    """
    found = pose if type(pose) is np.ndarray and pose.dtype in _FLOATS else _as_floats(pose)
    if found.ndim != 2 or found.shape[1] != 3 or not len(found):
        raise FrameError(f"a pose has shape (J, 3), not {found.shape}")
    return found


def nearby(pose: NDArray[Any]) -> NDArray[Any]:
    """Return a pose, (J, 3) metres, whose coordinates beyond `FARTHEST` are missing."""
    near = np.abs(pose) <= FARTHEST
    return pose if near.all() else np.where(near, pose, pose.dtype.type(np.nan))


def _as_floats(pose: ArrayLike) -> NDArray[Any]:
    try:
        if isinstance(pose, np.ma.MaskedArray):
            return np.ma.filled(pose.astype(np.float64), np.nan)
        return np.asarray(pose, np.float64)
    except (TypeError, ValueError):
        raise FrameError(f"a pose has (J, 3) numbers, not {repr(pose)[:40]}") from None
