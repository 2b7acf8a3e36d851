"""Intake: what people push, brought into the one form that the kernels take.

Kernels calculate in single precision, which 10 km from the origin is a millimetre. So somebody's place is taken off in
double precision, before positions are narrowed: the multiple of `CELL` that is nearest to where the performer is first
seen in a take. On a usual stage that is 0, and nothing need be done.
"""

import math
import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mossar_stream.algorithm.joints import FARTHEST
from mossar_stream.engine.pool import Row
from mossar_stream.errors import FrameError
from mossar_stream.frames import constant_times, plain_array

FLOAT32, FLOAT64 = np.dtype(np.float32), np.dtype(np.float64)
NUMBERS = (float, int, np.floating, np.integer)  # what a time may be
CELL = 16.0  # m; half of it from there, single precision is half a micrometre
LARGEST_PERSON = 100.0  # m; who seems larger is not given in metres


def checked(
    row: Row,
    positions: ArrayLike,
    times: ArrayLike | None,
    confidence: ArrayLike | None,
    first_frame: int | None,
) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
    """Return what was pushed as (n, J, 3) m and (n,) s, in the form that the kernels take; see `Segmenter.push`."""
    joints = len(row.plan.skeleton)
    # Writeable and contiguous: other arrays would be another type to the compiler.
    chunk = given_positions(positions)
    if chunk.ndim == 2:
        chunk = chunk[None]
    if chunk.ndim != 3 or chunk.shape[1:] != (joints, 3):
        raise FrameError(f"positions have shape {np.shape(positions)}; this skeleton needs (n, {joints}, 3)")
    if times is None:
        fps = row.plan.fps
        if fps is None:
            raise ValueError("push needs times, or the segmenter fps")
        begin = int(row.clock["next_frame"]) if first_frame is None else first_frame
        moments = constant_times(len(chunk), fps, begin)
    else:
        moments = np.atleast_1d(_as_array(times, FLOAT64))
    if moments.shape != chunk.shape[:1]:
        raise FrameError(f"{len(chunk)} frames but times of shape {moments.shape}")
    if first_frame is not None:
        _check_number(row, first_frame, moments)
    if confidence is not None:
        sure = np.atleast_2d(np.asarray(confidence, np.float32))
        if sure.shape != chunk.shape[:2]:
            raise FrameError(f"{len(chunk)} frames of {joints} joints but confidence of shape {sure.shape}")
        chunk = np.where(sure[:, :, None] > 0, chunk, chunk.dtype.type(np.nan))
    return narrowed(row, chunk, moments), moments


def given_positions(values: ArrayLike) -> NDArray[Any]:
    """Return positions as they were given, in single or double precision, contiguous and writeable."""
    if type(values) is np.ndarray and values.dtype in (FLOAT32, FLOAT64) and values.flags.carray:
        return values
    kind = getattr(values, "dtype", FLOAT64)
    return plain_array(values, FLOAT32 if kind in (np.float16, FLOAT32) else FLOAT64)


def narrowed(row: Row, positions: NDArray[Any], times: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return positions relative to where the performer was first seen in the take, in single precision.

    Args:
        row: The performer's; takes note of that place.
        positions: (n, J, 3) m, in single or double precision.
        times: (n,) s; where they show that a take begins, the place is looked for anew.
    """
    if not len(positions):
        return plain_array(positions, FLOAT32)
    if not _goes_on(row, times):
        return _narrowed_takes(row, positions, times)
    if not (row.is_live and row.is_placed):
        row.settle(*place_of(positions, row.plan.center))
    return _less(positions, row.origin)


def _goes_on(row: Row, times: NDArray[np.float64]) -> bool:
    """Tell at a glance that no take begins among frames; False where it takes a closer look, as for NaN."""
    first, pause = float(times[0]), row.plan.given.max_pause
    last = float(row.clock["time"]) if row.is_live else first
    if not abs(first - last) <= pause:
        return False
    if abs(float(times[-1]) - first) <= pause:
        return True
    steps = np.diff(times)
    return bool(steps.min() >= 0.0 and steps.max() <= pause)


def _narrowed_takes(row: Row, positions: NDArray[Any], times: NDArray[np.float64]) -> NDArray[np.float32]:
    """Do the same where takes may begin among the frames."""
    begins = [*_begins_of_takes(row, times)]
    pieces = []
    goes_on = row.is_live and row.is_placed
    for begin, end in zip([0, *begins], [*begins, len(times)], strict=True):
        if begin < end and not goes_on:
            row.settle(*place_of(positions[begin:end], row.plan.center))
        pieces.append(_less(positions[begin:end], row.origin))
        goes_on = False
    return np.concatenate(pieces)


def _begins_of_takes(row: Row, times: NDArray[np.float64]) -> Iterator[int]:
    """Yield the frames before which a take ends, as clock.py finds them."""
    last = float(row.clock["time"]) if row.is_live else None
    for i, time in enumerate(times.tolist()):
        if not math.isfinite(time):
            continue
        if last is not None and abs(time - last) > row.plan.given.max_pause:
            yield i
        elif last is not None and time <= last:
            continue
        last = time


def place_of(positions: NDArray[Any], center: int) -> tuple[NDArray[np.float64], bool]:
    """Return what to take off the positions of a take, and whether anybody was seen in them at all.

    Args:
        positions: (n, J, 3) m.
        center: Index of the root, -1 for the centroid.
    """
    for frame in positions:
        seen = (np.abs(frame) <= FARTHEST).all(axis=1)
        if frame[seen].any():  # senders without anybody before them put all joints at the origin
            joint = center if center >= 0 and seen[center] else int(seen.argmax())
            return CELL * np.rint(np.asarray(frame[joint], np.float64) / CELL), True
    return np.zeros(3), False


def _less(positions: NDArray[Any], origin: NDArray[np.float64] | None) -> NDArray[np.float32]:
    if origin is None:
        return _as_array(positions, FLOAT32)
    return less(positions, origin, np.empty(positions.shape, np.float32))


def less(
    positions: NDArray[Any], origin: NDArray[np.float64], result: NDArray[np.float32]
) -> NDArray[np.float32]:
    """Return positions less the origin, taken off in double precision."""
    np.subtract(positions, origin, out=result, casting="same_kind")
    return result


def _check_number(row: Row, first_frame: int, times: NDArray[np.float64]) -> None:
    """Raise FrameError for a frame number that would give two key frames one id."""
    clock = row.clock
    goes_on = (
        bool(clock["open"]) and len(times) > 0 and abs(times[0] - clock["time"]) <= row.plan.given.max_pause
    )
    if first_frame < (int(clock["next_frame"]) if goes_on else 0):
        raise FrameError(f"first_frame is {first_frame}, but the take is at frame {int(clock['next_frame'])}")


def has_said_size(who: str, chunk: NDArray[Any], depth: int) -> bool:
    """Warn if a person is far larger than people are: the unit must be another one; tell whether there was anybody.

    Args:
        who: The person.
        chunk: (n, J, 3) m, of which the first frame is looked at.
        depth: How many calls above this one the user's is, as `warnings.warn` counts.
    """
    if not len(chunk) or not np.isfinite(chunk[0]).any():
        return False
    seen = chunk[0][np.isfinite(chunk[0]).all(axis=1)]
    size = float(np.ptp(seen, axis=0).max()) if len(seen) else 0.0
    if size > LARGEST_PERSON:
        message = f"{who} is {size:,.0f} m tall; positions are in metres, these look like millimetres or centimetres"
        warnings.warn(message, stacklevel=depth)
    return True


def _as_array(values: ArrayLike, kind: "np.dtype[Any]") -> NDArray[Any]:
    """Return an array of a kind; most come in the right form, and seeing to it takes as long as a frame."""
    if type(values) is np.ndarray and values.dtype is kind and values.flags.carray:
        return values
    return plain_array(values, kind)
