"""Take: a whole performance of the built-in performer, with its true cuts."""

from collections.abc import Sequence
from typing import Final

import msgspec
import numpy as np

from mossar_adapters.demo.body import SKELETON
from mossar_adapters.demo.plan import FIRST_ROUND
from mossar_adapters.demo.stream import Cut, stream
from mossar_adapters.demo.style import Style
from mossar_stream import Frames, SettingsError, Skeleton, performer_name

MAX_FRAMES: Final = 1_000_000  # of a whole performance: 252 MB


class Performance(msgspec.Struct, frozen=True):
    """A whole performance.

    Args:
        skeleton: Joints in the order of the frames, named like the bones of Unity's humanoid.
        fps: Nominal rate, Hz.
        frames: All frames, metres, +y up; times from 0.
        cuts: The true cuts, in order of time.
    """

    skeleton: Skeleton
    fps: float
    frames: Frames
    cuts: tuple[Cut, ...]


def performance(
    seed: int = 1,
    *,
    fps: float = 60.0,
    seconds: float | None = None,
    moves: Sequence[str] | None = None,
    noise: float = 0.0,
    noise_kind: str = "white",
    jitter: float = 0.0,
    drop: float = 0.0,
    performer: str = "p1",
    tempo: float = 1.0,
    place: tuple[float, float] = (0.0, 0.0),
) -> Performance:
    """Return a whole performance; the same arguments give the same bytes (see the package).

    Args:
        seed: 0 or more.
        fps: See `Style`, also for noise, noise_kind, jitter, drop and tempo.
        seconds: Where to stop, if not at the end of the moves. Without moves: the duration.
        moves: `rest walk punch kick jump wave squat turn stand`; `punch`, `kick`, `wave` and `turn` also with
            `_left` or `_right`; `rest` and `stand` also with seconds (`stand:20`). None: a round of 17 moves
            with every kind but `stand`, 40-46 s.
        noise: m.
        noise_kind: `white` or `kinect`.
        jitter: s.
        drop: Share of frames.
        performer: Name.
        tempo: 1 is ordinary.
        place: Place at which the performer starts, x and z in metres.

    Raises:
        SettingsError: If a value is out of its range, there is no such move, or there would be more than
            `MAX_FRAMES` frames.

    Example:
        >>> take = performance(seed=3, moves=("rest", "punch_left", "kick_right"))
        >>> [(cut.before, cut.after) for cut in take.cuts]
        [('rest', 'punch_left'), ('punch_left', 'kick_right')]
    """
    style = Style(fps, tempo, noise, noise_kind, jitter, drop)
    most = FIRST_ROUND if moves is None and seconds is None else None
    pieces = stream(
        seed, style, moves=moves, most_moves=most, seconds=seconds, performer=performer, place=place
    )
    chunks, cuts, count = [], list[Cut](), 0
    for chunk, passed in pieces:
        chunks.append(chunk)
        cuts += passed
        count += len(chunk)
        if count > MAX_FRAMES:
            raise SettingsError(
                f"a whole performance has at most {MAX_FRAMES} frames; shorten it or stream it"
            )
    positions = np.concatenate([np.zeros((0, len(SKELETON), 3), np.float32), *(c.positions for c in chunks)])
    times = np.concatenate([np.zeros(0), *(chunk.times for chunk in chunks)])
    frames = Frames(positions, times, performer=performer_name(performer), first_frame=0)
    return Performance(SKELETON, fps, frames, tuple(cuts))
