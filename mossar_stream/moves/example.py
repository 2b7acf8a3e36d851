"""One example of a move, from its onset to its offset."""

from typing import Annotated, Any

import msgspec
import numpy as np
from numpy.typing import ArrayLike, NDArray

from mossar_stream.core.kernels import AVERAGED, ONSET, SMOOTHED
from mossar_stream.errors import MovesError
from mossar_stream.frames import plain_array
from mossar_stream.moves.trimming import part_to_follow

MAX_FRAMES = 128  # of the movement that an example keeps
MOST_SHOWN = 300  # frames that an example keeps of the whole: 10 s at 30 Hz, longer ones coarser
SHOWN_RATE = 30.0  # Hz, highest rate of the whole
LONGEST_TAKEN = 100_000  # frames of a recording that are read
LEAST_FRAMES = 8
MAX_DISTANCE = 1000.0  # m from the origin
LEAST_SPEED = 0.015  # m/s, mean over the joints at the peak: slower is no movement
PAUSE = 0.5  # s, of rest that a move may have inside
UNIT = 1e-4  # m, to which positions are rounded
MAX_MOVE_NAME = 64
NUMBERS = (float, int, np.floating, np.integer)  # types of a rate

Coordinate = Annotated[int, msgspec.Meta(ge=-round(MAX_DISTANCE / UNIT), le=round(MAX_DISTANCE / UNIT))]


class Example(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """An example of a move.

    Args:
        name: Of the move.
        fps: Frames per second, Hz.
        positions: `n · J · 3` numbers in `UNIT` (tenths of a millimetre), frame by frame, joint by joint: the movement, from
            its onset to its offset.
        whole_fps: Frames per second of `whole`, Hz; 0 if the example has none.
        whole: Everything that was shown, in the same form; empty if that is `positions`.
    """

    name: Annotated[str, msgspec.Meta(min_length=1, max_length=MAX_MOVE_NAME)]
    fps: Annotated[float, msgspec.Meta(gt=0, le=10_000)]
    positions: Annotated[tuple[Coordinate, ...], msgspec.Meta(max_length=MAX_FRAMES * 3 * 1024)]
    whole_fps: Annotated[float, msgspec.Meta(ge=0, le=10_000)] = 0.0
    whole: Annotated[tuple[Coordinate, ...], msgspec.Meta(max_length=MOST_SHOWN * 3 * 1024)] = ()

    def metres(self, joints: int) -> NDArray[np.float32]:
        """Return the positions as (n, J, 3) float32, metres."""
        return (np.array(self.positions, np.float64) * UNIT).astype(np.float32).reshape(-1, joints, 3)

    def seconds(self, joints: int) -> float:
        """Return the duration of the movement, s."""
        return (len(self.positions) // (3 * joints) - 1) / self.fps

    def shown(self, joints: int) -> tuple[NDArray[np.float32], float]:
        """Return everything that was shown as (n, J, 3) float32 metres, and its rate, Hz."""
        if not self.whole:
            return self.metres(joints), self.fps
        return (np.array(self.whole, np.float64) * UNIT).astype(np.float32).reshape(
            -1, joints, 3
        ), self.whole_fps

    def followed(self, joints: int, root: int) -> tuple[NDArray[np.float32], float]:
        """Return the part of `shown` that is followed, without rest and neighbours at its ends; `progress` is along this.

        Args:
            joints: J.
            root: Joint that the others are taken relative to; -1 for the mean of all.

        Returns:
            (n, J, 3) float32 metres, and the rate, Hz.
        """
        positions, rate = self.shown(joints)
        poses = smoothed(_placed(positions.astype(np.float64), root), SMOOTHED, rate)[:, 1:]
        first, last = part_to_follow(poses.reshape(len(poses), -1), rate)
        return positions[first : last + 1], rate


def check_name(name: str) -> str:
    """Return a move's name if it is one.

    Raises:
        MovesError: If it is no text, empty, too long, or not printable.
    """
    if not isinstance(name, str):
        raise MovesError(f"a move's name is text, not {type(name).__name__}")
    if not 1 <= len(name) <= MAX_MOVE_NAME or not name.isprintable() or name != name.strip():
        raise MovesError(
            f"a move's name has 1 to {MAX_MOVE_NAME} printable characters, not {str(name)[:80]!r}"
        )
    return name


def make_example(
    name: str,
    positions: ArrayLike,
    fps: float,
    joints: int,
    root: int,
    movement: tuple[int, int] | None = None,
) -> Example:
    """Return an example of a move: the movement, from its onset to its offset, and everything that was shown.

    Args:
        name: Of the move.
        positions: (n, J, 3), metres, of one performance; rest before and after it does no harm.
        fps: Rate, Hz.
        joints: J.
        root: Joint that the others are taken relative to; -1 for the mean of all.
        movement: First and last frame of the movement, pauses included; None for the part around the peak of speed,
            up to the next pauses.

    Raises:
        MovesError: If the name or the positions cannot be used, or nothing moves.
    """
    check_name(name)
    shown = _checked(numbers_of(positions), fps, joints)
    first, last = _extent(shown, fps, root, movement)
    cut = shown[first : last + 1]
    if len(cut) < LEAST_FRAMES:
        raise MovesError(f"the movement has {len(cut)} frames; an example needs at least {LEAST_FRAMES}")
    rate = fps
    if len(cut) > MAX_FRAMES:
        rate = fps * (MAX_FRAMES - 1) / (len(cut) - 1)
        cut = _resampled(cut, MAX_FRAMES)
    if len(cut) == len(shown) and fps <= SHOWN_RATE:
        return Example(name, float(rate), units_of(cut))
    whole_rate = min(fps, SHOWN_RATE, fps * (MOST_SHOWN - 1) / (len(shown) - 1))
    count = max(2, round((len(shown) - 1) * whole_rate / fps) + 1)
    whole_rate = fps * (count - 1) / (len(shown) - 1)
    return Example(name, float(rate), units_of(cut), float(whole_rate), units_of(_resampled(shown, count)))


def units_of(positions: NDArray[np.float64]) -> tuple[int, ...]:
    """Return positions, m, as whole numbers of `UNIT`."""
    return tuple(np.rint(positions / UNIT).astype(np.int64).ravel().tolist())


def numbers_of(positions: ArrayLike) -> NDArray[np.float64]:
    """Return positions as an array.

    Raises:
        MovesError: If they are no numbers.
    """
    try:
        return plain_array(positions, np.float64)
    except (TypeError, ValueError) as error:
        raise MovesError(f"an example's positions are numbers: {error}") from None


def _checked(shown: NDArray[np.float64], fps: Any, joints: int) -> NDArray[np.float64]:
    if not isinstance(fps, NUMBERS) or not 0 < fps <= 10_000:
        raise MovesError(f"the rate of an example is a positive number of frames per second, not {fps!r}")
    if shown.ndim != 3 or shown.shape[1:] != (joints, 3):
        raise MovesError(f"an example has the form (frames, {joints} joints, 3), not {shown.shape}")
    if not LEAST_FRAMES <= len(shown) <= LONGEST_TAKEN:
        raise MovesError(f"an example has {LEAST_FRAMES} to {LONGEST_TAKEN} frames, not {len(shown)}")
    if not np.isfinite(shown).all():
        bad = int(np.argmin(np.isfinite(shown).all(axis=(1, 2))))
        raise MovesError(f"an example needs all joints in all frames; frame {bad} lacks some")
    if np.abs(shown).max() > MAX_DISTANCE:
        raise MovesError(f"an example's positions are metres, at most {MAX_DISTANCE:g} from the origin")
    return shown


def _extent(
    shown: NDArray[np.float64], fps: float, root: int, movement: tuple[int, int] | None
) -> tuple[int, int]:
    """Return the first and the last frame of the movement: that around the peak of speed, or the one that is known."""
    speed = _speed(shown, fps, root)
    if movement is not None:
        first, last = _checked_frames(movement, len(speed))
        begin, end = _extent_of(speed[first : last + 1], last - first + 1)
        return first + begin, first + end
    return _extent_of(speed, round(PAUSE * fps))


def _extent_of(speed: NDArray[np.float64], pause: int) -> tuple[int, int]:
    """Return the first and the last frame of the movement around the peak of speed.

    Args:
        speed: (n,) m/s.
        pause: Frames of rest that it may have inside.
    """
    peak = int(np.argmax(speed))
    if speed[peak] < LEAST_SPEED:
        raise MovesError(
            f"nothing moves in the example (at most {speed[peak]:.3f} m/s, mean over the joints)"
        )
    moving = np.flatnonzero(speed > ONSET * speed[peak])
    breaks = np.flatnonzero(np.diff(moving) > pause)
    at = int(np.searchsorted(moving, peak))
    begins = [0, *(breaks + 1)]
    ends = [*breaks, len(moving) - 1]
    part = int(np.searchsorted(begins, at, side="right")) - 1
    first, last = int(moving[begins[part]]), int(moving[ends[part]])
    while first > 0 and speed[first - 1] < speed[first]:
        first -= 1
    while last + 1 < len(speed) and speed[last + 1] < speed[last]:
        last += 1
    return first, last


def _checked_frames(movement: tuple[int, int], count: int) -> tuple[int, int]:
    first, last = movement
    if not 0 <= first <= last < count:
        raise MovesError(f"a movement from frame {first} to {last} is not in an example of {count} frames")
    return first, last


def _speed(shown: NDArray[np.float64], fps: float, root: int) -> NDArray[np.float64]:
    """Return (n,) m/s, mean over the joints, centred on each frame."""
    placed = smoothed(_placed(shown, root), SMOOTHED, fps)
    steps = np.linalg.norm(np.diff(placed, axis=0), axis=2).sum(axis=1) / shown.shape[1]
    return smoothed(np.append(steps, steps[-1]) * fps, AVERAGED, fps)


def _placed(shown: NDArray[np.float64], root: int) -> NDArray[np.float64]:
    """Return (n, 1 + J, 3) m: the centre, and the joints relative to it."""
    centre = shown[:, root] if root >= 0 else shown.mean(axis=1)
    return np.concatenate([centre[:, None], shown - centre[:, None]], axis=1)


def smoothed(values: NDArray[np.float64], seconds: float, fps: float) -> NDArray[np.float64]:
    """Return the moving average over `seconds`, centred, along the first axis; shorter at both ends."""
    reach = int(seconds * fps / 2)
    if reach < 1:
        return values
    sums = np.concatenate([np.zeros_like(values[:1]), np.cumsum(values, axis=0)])
    places = np.arange(len(values))
    begin, end = np.maximum(places - reach, 0), np.minimum(places + reach + 1, len(values))
    counts = (end - begin).reshape(-1, *[1] * (values.ndim - 1))
    averaged: NDArray[np.float64] = (sums[end] - sums[begin]) / counts
    return averaged


def _resampled(values: NDArray[np.float64], count: int) -> NDArray[np.float64]:
    places = np.linspace(0, len(values) - 1, count)
    below = np.minimum(places.astype(np.int64), len(values) - 2)
    share = (places - below).reshape(-1, 1, 1)
    resampled: NDArray[np.float64] = values[below] * (1 - share) + values[below + 1] * share
    return resampled
