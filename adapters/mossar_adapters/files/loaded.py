"""Loaded: all frames of one performer of a recording, in memory."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.demo import Cut
from mossar_adapters.files.assembly import confident
from mossar_adapters.files.body import body_recording
from mossar_adapters.files.errors import FileError
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.files.registry import open_recording
from mossar_adapters.held_joints import HeldJoints
from mossar_adapters.source import Recording
from mossar_stream import Result, Settings, Skeleton, Up, segment_recording

MAX_BYTES = 2 << 30  # of positions
OnProgress = Callable[[float | None], None]  # gets the share that is read, None where that is not known


class LoadedRecording(msgspec.Struct, frozen=True):
    """A recording in memory.

    Args:
        name: File name or URL.
        skeleton: J joints.
        fps: Nominal rate, Hz, if it is known.
        positions: (n, J, 3), metres; NaN where a joint is missing or has no confidence.
        times: (n,) float64, s.
        cuts: True cuts of the built-in performer.
        performer: Its name.
        up: The axis that points upwards, by the file.
        outside: For a part of a recording, the numbers of frames before it and after it.
        origin: When the recording begins, s; None if that is the first frame here.
        reference: Joints that are no part of the body and were left out.
    """

    name: str
    skeleton: Skeleton
    fps: float | None
    positions: NDArray[Any]
    times: NDArray[np.float64]
    cuts: tuple[Cut, ...] = ()
    performer: str = "p1"
    up: Up = "auto"
    outside: tuple[int, int] = (0, 0)
    origin: float | None = None
    reference: tuple[str, ...] = ()

    @property
    def begin(self) -> float:
        """Begin of the whole recording, of which this may be a part, s; 0 without frames."""
        if self.origin is not None:
            return self.origin
        return float(self.times[0]) if len(self.times) else 0.0

    def part(self, begin: float | None, until: float | None) -> "LoadedRecording":
        """Return the frames from one time until another, as a recording of its own; times stay those of the clock.

        Args:
            begin: s on the recording's clock; None: from where it begins.
            until: The same; None: until its end.

        Raises:
            FileError: If there are no frames.
        """
        low = -np.inf if begin is None else begin
        high = np.inf if until is None else until
        inside = np.flatnonzero((self.times >= low) & (self.times <= high))
        if not len(inside):
            length = (
                f"it lasts from {self.times[0]:g} s to {self.times[-1]:g} s"
                if len(self.times)
                else "it is empty"
            )
            asked = ("" if begin is None else f" from {begin:g} s") + (
                "" if until is None else f" until {until:g} s"
            )
            what = "there are no frames" if low <= high else "a part begins before it ends, not"
            raise FileError(self.name, f"{what}{asked}; {length}")
        first, end = int(inside[0]), int(inside[-1]) + 1
        if end - first == len(self.times):
            return self
        return msgspec.structs.replace(
            self,
            positions=self.positions[first:end],
            times=self.times[first:end],
            cuts=tuple(
                msgspec.structs.replace(cut, frame=cut.frame - first)
                for cut in self.cuts
                if low <= cut.time <= high
            ),
            outside=(self.outside[0] + first, self.outside[1] + len(self.times) - end),
            origin=self.begin,
        )

    def between(self, begin: float, end: float) -> tuple[NDArray[Any], float]:
        """Return the positions from one time until another, s, both included, and their rate, Hz; 0 if it is unknown."""
        inside = (self.times >= begin) & (self.times <= end)
        times = self.times[inside]
        span = float(times[-1] - times[0]) if len(times) else 0.0
        return self.positions[inside], (len(times) - 1) / span if span > 0 else self.fps or 0.0

    def held(self) -> "LoadedRecording":
        """Return it with each missing joint where it was, relative to the body centre; see `HeldJoints`."""
        filled = HeldJoints(self.skeleton).fill(self.positions)
        return msgspec.structs.replace(self, positions=filled)

    def __repr__(self) -> str:
        rate = f" at {self.fps:g} Hz" if self.fps else ""
        return f"{self.name}: {len(self.times)} frames{rate}, {len(self.skeleton)} joints, performer {self.performer}"

    def segment(self, *unnamed: object, curves: bool = True, **settings: Any) -> Result:
        """Segment it offline, with the range of the whole recording.

        Args:
            unnamed: Nothing; settings have names.
            curves: Whether to keep the velocity curve, for `Result.plot`.
            settings: Fields of `Settings`, as `level="cluster"`.

        Raises:
            SettingsError: If a setting is unknown or its value illegal.
            TypeError: If a setting has no name, such as a whole `Settings`; the message has the form of settings.
        """
        if unnamed:
            raise TypeError(
                'settings are given by name, as in take.segment(level="cluster", repetitions=True); a whole Settings goes to '
                "segment_recording(take.positions, take.fps, take.skeleton, settings, times=take.times)"
            )
        chosen = Settings.build("default", {"range": "file", "up": self.up, **settings})
        return segment_recording(
            self.positions, self.fps, self.skeleton, chosen, times=self.times, curves=curves
        )


def read(path: str | Path, **options: Any) -> LoadedRecording:
    """Read a recording of any format in one call.

    Args:
        path: Path of the file.
        options: Fields of `ReadOptions`: `unit`, `fps`, `skeleton`, `root`, `joints`, `performer`, `allow_2d`.

    Raises:
        FileError: If it cannot be read, or is too large to be held in memory.

    Example:
        >>> from mossar_adapters.files import read
        >>> take = read("walk.bvh")  # doctest: +SKIP
        >>> take.segment(level="cluster").plot()  # doctest: +SKIP
    """
    return load(open_recording(str(path), ReadOptions(**options)))


def load(recording: Recording, on_progress: OnProgress = lambda _: None) -> LoadedRecording:
    """Return the first performer of a recording, without the joints that are no part of the body.

    Args:
        recording: As opened.
        on_progress: Gets the share that is read.

    Raises:
        FileError: If it is too large to be held in memory, or cannot be read to its end.
    """
    recording, reference = body_recording(recording), recording.reference
    count = recording.frame_count or 0
    _check_size(recording, count)
    performer = recording.performers[0]
    positions: list[NDArray[Any]] = [np.zeros((0, len(recording.skeleton), 3), np.float32)]
    times = [np.zeros(0)]
    read_so_far = 0
    for frames in recording.chunks():
        read_so_far += len(frames)
        on_progress(read_so_far / count if count else None)
        _check_size(recording, read_so_far)
        if frames.performer == performer:
            positions.append(confident(frames))
            times.append(frames.times)
    return LoadedRecording(
        recording.path,
        recording.skeleton,
        recording.fps,
        np.concatenate(positions),
        np.concatenate(times),
        performer=performer,
        up=recording.up,
        reference=reference,
    )


def _check_size(recording: Recording, count: int) -> None:
    if count * len(recording.skeleton) * 12 > MAX_BYTES:
        raise FileError(recording.path, f"{count} frames are too many to hold in memory; use mossar run")
