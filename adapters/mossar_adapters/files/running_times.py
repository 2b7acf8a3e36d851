"""Running times: the times in a file, if the clock of its sender ran, and frames counted at a rate if it did not.

A clock that stands still or steps coarsely gives many frames the same time, and all but one of them would be dropped. A
file has no arrivals to use instead. The steps of a coarse clock give the rate; without two of them it is the rate that the
file states, else the usual one. So it is where a second or more, or next to nothing, passes from frame to frame: those are
frame numbers, or another clock than that of frames.
"""

import logging
from collections.abc import Iterator, Sequence
from typing import Any, Final, NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files.clock import unit_of_steps
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.files.rates import USUAL_FPS, assumed_rate, nearly_usual, rate_of_times
from mossar_adapters.receiving.pose import differ
from mossar_adapters.source import Recording
from mossar_stream import Frames

_STANDING: Final = 4  # frames with the time of the one before and another pose; fewer are written twice
_OFTEN: Final = 8  # and more than one in so many
_RATES: Final = (5.0, 1000.0)  # Hz of frames; other numbers are rates of the clock
# Seconds from frame to frame; no recording of a body has longer or much shorter ones.
_STEPS: Final = (1 / 2000, 1.0)
_ENOUGH: Final = 16  # steps, for a verdict
_JUDGED: Final = 256  # frames that are judged when a file is opened,
_LOOKED_AT: Final = 16 * _JUDGED  # among as many of other performers

_log = logging.getLogger("mossar.source")


class _Line(msgspec.Struct):
    """One performer's frames so far."""

    count: int = 0
    first: float = 0.0  # s
    last: float = 0.0  # s, of the latest frame
    rate: float | None = None  # Hz, if they are counted


def with_running_times(recording: Recording, options: ReadOptions, *, plain: bool = False) -> Recording:
    """Return a recording whose frames are counted if the times in it stand still or step coarsely.

    Args:
        recording: With the times of its file.
        options: `fps` replaces the times in the file already.
        plain: Whether the times may be in another unit than seconds.
    """
    if options.fps is not None:
        return recording
    times, positions = _beginning(recording)
    unit, name = _unit(times) if plain else (1.0, "s")
    times = times * unit
    notes = () if name == "s" else (f"times taken as {name}",)
    counted = counting_of(times, positions, recording.fps)
    fps = recording.fps if name == "s" else rate_of_times(times)
    if counted is not None:
        fps, notes = counted.rate, (*notes, counted.note)

    def chunks() -> Iterator[Frames]:
        lines: dict[str, _Line] = {}
        for frames in recording.chunks():
            line = lines.setdefault(frames.performer, _Line(rate=counted and counted.rate))
            yield _timed(recording.path, frames, line, unit)

    return msgspec.structs.replace(recording, fps=fps, chunks=chunks, notes=(*recording.notes, *notes))


class Counting(NamedTuple):
    """That frames are counted instead of being timed.

    Args:
        rate: Rate of counting, Hz.
        why: The fault of their times.
    """

    rate: float
    why: str

    @property
    def note(self) -> str:
        """The note about it."""
        return assumed_rate(self.why, self.rate)


def counting_of(
    times: NDArray[np.float64], positions: Sequence[NDArray[Any]] | NDArray[Any], stated: float | None
) -> Counting | None:
    """Return the way to count frames whose times are not those of frames; None if they are.

    Args:
        times: (n,) s.
        positions: (n, J, 3), or n of any shape.
        stated: Rate that the file states, Hz.
    """
    rate = stated if stated is not None and _RATES[0] <= stated <= _RATES[1] else USUAL_FPS
    if not _stands(times, positions):
        why = why_absurd(times)
        return None if why is None else Counting(rate, why)
    ticks = np.flatnonzero(np.diff(times) > 0) + 1
    if len(ticks) > 1:
        measured = float((ticks[-1] - ticks[0]) / (times[ticks[-1]] - times[ticks[0]]))
        if _RATES[0] <= measured <= _RATES[1]:
            rate = nearly_usual(measured)
    return Counting(rate, "its times stand still or step coarsely")


def why_absurd(times: NDArray[np.float64]) -> str | None:
    """Return a description of impossible times, else None."""
    steps = np.diff(times)
    steps = steps[np.isfinite(steps)]
    if len(steps) < _ENOUGH:
        return None
    step = float(np.median(steps))
    if _STEPS[0] <= step < _STEPS[1] or step <= 0:
        return None
    counts = bool((times == np.floor(times)).all()) and step == 1
    return "its times are frame numbers" if counts else f"its times step by {step:.3g} s"


def _beginning(recording: Recording) -> tuple[NDArray[np.float64], NDArray[Any]]:
    """Return times and positions of the first frames of the first performer."""
    name, parts, seen = recording.performers[0], list[Frames](), 0
    for frames in recording.chunks():
        seen += len(frames)
        if frames.performer == name:
            parts.append(frames)
        if sum(map(len, parts)) >= _JUDGED or seen >= _LOOKED_AT:
            break
    if not parts:
        return np.zeros(0), np.zeros((0, 1, 3))
    return np.concatenate([part.times for part in parts]), np.concatenate([part.positions for part in parts])


def _unit(times: NDArray[np.float64]) -> tuple[float, str]:
    """Return the unit of times, in s, and its name; seconds unless steps of seconds would be absurd."""
    steps = np.diff(times)
    steps = steps[steps > 0]
    return (
        unit_of_steps(times)
        if len(steps) and len(times) > _STANDING and 2 * len(steps) > len(times)
        else (1.0, "s")
    )


def _stands(times: NDArray[np.float64], positions: Sequence[NDArray[Any]] | NDArray[Any]) -> bool:
    same = np.flatnonzero(np.diff(times) == 0)
    if len(same) < _STANDING or len(same) * _OFTEN < len(times) - 1:
        return False
    standing = sum(differ(positions[i], positions[i + 1]) for i in same.tolist())
    return standing >= _STANDING and standing * _OFTEN >= len(times) - 1


def _timed(path: str, frames: Frames, line: _Line, unit: float) -> Frames:
    """Return frames with times in s, counted from where the clock stands on."""
    if not len(frames):
        return frames
    times = frames.times if unit == 1.0 else frames.times * unit
    if line.rate is None and _stands(times, frames.positions):
        so_far = (line.count - 1) / (line.last - line.first) if line.last > line.first else None
        counted = counting_of(times, frames.positions, so_far)
        if counted is not None:
            line.rate = counted.rate
            _log.warning("%s: %s: %s", path, frames.performer, counted.note)
    if line.rate is not None:
        begin = float(times[0]) if not line.count else line.last + 1 / line.rate
        times = begin + np.arange(len(times)) / line.rate
    if not line.count:
        line.first = float(times[0])
    line.count, line.last = line.count + len(times), float(times[-1])
    return frames if times is frames.times else msgspec.structs.replace(frames, times=times)
