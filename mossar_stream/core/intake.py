"""Intake: pushed frames in the one form that the core takes."""

import warnings
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mossar_stream.core.kernels import Channel
from mossar_stream.errors import FrameError
from mossar_stream.frames import constant_times, plain_array, refuse_other_than_arrays, reshaping

FLOAT32, FLOAT64 = np.dtype(np.float32), np.dtype(np.float64)
LARGEST_PERSON = 100.0  # m; a larger one is given in another unit
ENOUGH_APART = 3  # steps between frames that are takes of their own; from then on times are hardly seconds
UNITS_OF_TIME = {"milliseconds": 1e3, "microseconds": 1e6, "nanoseconds": 1e9}  # in a second
RATES = (5.0, 250.0)  # Hz, of senders and recordings of poses


def checked(
    row: Channel,
    positions: ArrayLike,
    times: ArrayLike | None,
    confidence: ArrayLike | None,
    first_frame: int | None,
) -> tuple[NDArray[Any], NDArray[np.float64]]:
    """Return pushed frames as (n, J, 3) m, in single or double precision, and (n,) s; see `Segmenter.push`."""
    joints = len(row.plan.skeleton)
    chunk = given_positions(positions)
    shape = chunk.shape
    if chunk.ndim == 2:
        chunk = chunk[None]
    if chunk.ndim != 3 or chunk.shape[1:] != (joints, 3):
        needed = f"this skeleton needs (n, {joints}, 3)"
        raise FrameError(f"positions have shape {shape}; {needed}{reshaping(shape)}")
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
    return chunk, moments


def given_positions(values: ArrayLike) -> NDArray[Any]:
    """Return the given positions in single or double precision, contiguous and writeable."""
    if type(values) is np.ndarray and values.dtype in (FLOAT32, FLOAT64) and values.flags.carray:
        return values
    refuse_other_than_arrays(values)
    kind = getattr(values, "dtype", FLOAT64)
    return plain_array(values, FLOAT32 if kind in (np.float16, FLOAT32) else FLOAT64)


def _check_number(row: Channel, first_frame: int, times: NDArray[np.float64]) -> None:
    """Raise FrameError for a frame number that would give two key frames one id."""
    clock = row.clock
    goes_on = (
        bool(clock["open"])
        and len(times) > 0
        and abs(times[0] - clock["time"]) <= row.state["plan"]["max_pause"]
    )
    if first_frame < (int(clock["next_frame"]) if goes_on else 0):
        raise FrameError(f"first_frame is {first_frame}, but the take is at frame {int(clock['next_frame'])}")


def has_said_size(who: str, chunk: NDArray[Any], depth: int) -> bool:
    """Warn if a person is larger than people are, as in another unit; return whether a joint was seen.

    Args:
        who: The person.
        chunk: (n, J, 3) m; the first frame is measured.
        depth: Number of calls from the user's to this one, as `warnings.warn` counts.
    """
    if not len(chunk) or not np.isfinite(chunk[0]).any():
        return False
    seen = chunk[0][np.isfinite(chunk[0]).all(axis=1)]
    size = float(np.ptp(seen, axis=0).max()) if len(seen) else 0.0
    if size > LARGEST_PERSON:
        message = f"{who} is {size:,.0f} m tall; positions are in metres, these look like millimetres or centimetres"
        warnings.warn(message, stacklevel=depth)
    return True


def look_at_steps(row: Channel, times: NDArray[np.float64], apart: int, who: str, depth: int) -> int | None:
    """Warn if each frame since the first is a take of its own: the times are hardly seconds.

    Args:
        row: As it was before these frames.
        times: (n,) s, of the frames.
        apart: Steps between the frames so far, all longer than a take goes on for.
        who: The person.
        depth: See `has_said_size`.

    Returns:
        The steps so far; None once there is nothing to look at any more.
    """
    frames = int(row.state["counters"]["frames"])
    if frames and frames != apart + 1:
        return None
    times = times[np.isfinite(times)]
    steps = np.diff(np.concatenate(([row.clock["time"]], times)) if frames else times)
    if not (steps > row.state["plan"]["max_pause"]).all():
        return None
    apart += len(steps)
    if apart < ENOUGH_APART:
        return apart
    step = float(steps[-1])
    message = f"{who}: each frame is a take of its own, as times step by {step:,.4g} s; times are seconds{in_seconds(step)}"
    warnings.warn(message, stacklevel=depth)
    return None


def in_seconds(step: float) -> str:
    """Return how to turn times into seconds if their step, s, fits poses in another unit; else an empty string."""
    for unit, parts in UNITS_OF_TIME.items():
        if RATES[0] <= parts / step <= RATES[1]:
            return f": times / {parts:.10g} if these are {unit}"
    return ""


def _as_array(values: ArrayLike, kind: "np.dtype[Any]") -> NDArray[Any]:
    """Return an array of a kind; most come in the right form, and seeing to it takes as long as a frame."""
    if type(values) is np.ndarray and values.dtype is kind and values.flags.carray:
        return values
    return plain_array(values, kind)
