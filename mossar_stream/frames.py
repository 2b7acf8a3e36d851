"""Frames: the input of a segmenter."""

import math
from pathlib import PurePath
from typing import Any

import msgspec
import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from mossar_stream.errors import FrameError

MAX_PERFORMER_NAME = 64
NEAR = 16.0  # m from the origin, where single precision is a micrometre
_LONGEST = 1024  # characters that are read: senders may use names of any length


class Frames(msgspec.Struct, frozen=True):
    """A chunk of consecutive frames of one performer.

    Args:
        positions: (n, J, 3), metres; NaN where a joint is missing. Single precision serves up to `NEAR`, see `narrow`.
        times: (n,) float64, seconds on the source's clock.
        confidence: (n, J) float32 in 0..1, or None. 0 marks a joint as missing.
        performer: Name of the performer.
        first_frame: Number of the first frame, or None to count on from the frames before.
    """

    positions: NDArray[Any]
    times: NDArray[np.float64]
    confidence: NDArray[np.float32] | None = None
    performer: str = "p1"
    first_frame: int | None = None

    def __len__(self) -> int:
        return len(self.positions)


def plain_array(values: ArrayLike, kind: DTypeLike) -> NDArray[Any]:
    """Return numbers in the one form that the kernels take: an array of a kind, contiguous, aligned and writeable.

    Masked numbers become NaN, which is missing.

    Raises:
        FrameError: If they are dates.
    """
    if isinstance(values, np.ndarray) and values.dtype.kind in "mM":
        raise FrameError(
            f"times are seconds, not {values.dtype}; (times - times[0]) / np.timedelta64(1, 's')"
        )
    if isinstance(values, np.ma.MaskedArray):
        values = np.ma.filled(np.ma.asarray(values, kind), np.nan)
    return np.require(np.asarray(values), kind, ["C", "A", "W"])


def refuse_other_than_arrays(values: object) -> None:
    """Refuse paths and tables, which are often given in place of arrays.

    Raises:
        TypeError: If it is a path or a table; the message has the remedy.
    """
    if isinstance(values, list | tuple) and len(values) == 1:
        (values,) = values
    if isinstance(values, str | PurePath):
        raise TypeError(
            f"positions are an array, not the path {str(values)[:80]!r}; mossar_stream.read(path) reads a recording"
        )
    if hasattr(values, "to_numpy") and hasattr(values, "columns"):
        raise TypeError(
            "positions are an array (n, J, 3), not a DataFrame; with x, y, z of each joint in the columns: "
            "table.to_numpy().reshape(len(table), -1, 3)"
        )


def refuse_text_as_rate(fps: object) -> None:
    """Refuse a rate that is a text, as options of programs are, or an array, as times are.

    Raises:
        TypeError: If it is one; the message has the remedy.
    """
    if isinstance(fps, str):
        raise TypeError(f"fps is a number in Hz, not the text {fps[:40]!r}: float(fps)")
    if isinstance(fps, list | tuple) or getattr(fps, "ndim", 0) > 0:
        raise TypeError("fps is a number in Hz, not an array; the times of frames go by name: times=...")


def reshaping(shape: tuple[int, ...]) -> str:
    """Return the remedy for positions of a shape other than (n, J, 3), after a semicolon; empty if it is unknown.

    Example:
        >>> reshaping((90, 63))
        '; with x, y, z of each joint in a row: positions.reshape(len(positions), -1, 3)'
    """
    match shape:
        case (_, columns) if columns > 3 and columns % 3 == 0:
            return "; with x, y, z of each joint in a row: positions.reshape(len(positions), -1, 3)"
        case (_, 3):
            return "; of one joint: positions[:, None]; of one frame: positions[None]"
        case (_, _, 2):
            return "; flat poses need a depth: np.pad(positions, ((0, 0), (0, 0), (0, 1)))"
        case (_, _, 4):
            return "; a fourth column is confidence: positions[..., :3]"
        case (3 | 4, _, _):
            return "; with the axes x, y, z first, as ezc3d has them: positions[:3].transpose(2, 1, 0)"
    return ""


def narrow(positions: NDArray[Any]) -> NDArray[Any]:
    """Return positions, m, in single precision, or in double where single would be too coarse.

    Example:
        >>> narrow(np.array([1.0, 2.0])).dtype, narrow(np.array([1.0, 1e4])).dtype
        (dtype('float32'), dtype('float64'))
    """
    if positions.dtype == np.float64 and (np.abs(positions) > NEAR).any():
        return np.asarray(positions, np.float64)
    return positions.astype(np.float32, copy=False)


def performer_name(name: str) -> str:
    """Return `name` as a performer name: printable, without `/`, dot and space, at most 64 characters.

    Example:
        >>> performer_name("192.168.0.7:5000")
        '192_168_0_7:5000'
    """
    clean = "".join("_" if c in "/. " else c for c in name[:_LONGEST] if c.isprintable())
    return clean[:MAX_PERFORMER_NAME] or "p1"


def constant_times(count: int, fps: float, first_frame: int = 0) -> NDArray[np.float64]:
    """Return the times of `count` frames at a constant rate.

    Args:
        count: Number of frames.
        fps: Rate, Hz.
        first_frame: Number of the first one.

    Returns:
        (count,) float64, seconds.

    Raises:
        ValueError: If `fps` is not a positive number.
    """
    refuse_text_as_rate(fps)
    if not (math.isfinite(fps) and fps > 0):
        raise ValueError(f"fps must be a positive number, not {fps!r}")
    return np.arange(first_frame, first_frame + count, dtype=np.float64) / fps
