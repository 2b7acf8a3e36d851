"""The protocols of sources of frames."""

import warnings
from collections.abc import Iterator
from typing import Any, Protocol

import msgspec

from mossar_stream import Frames, Skeleton, Up


class Meta(msgspec.Struct, frozen=True):
    """Announces a performer: comes before its first frames, and again when its skeleton changes.

    Args:
        performer: Name of the performer.
        skeleton: Joints in the order of the frames that follow.
        fps: Nominal rate in Hz if the source knows it.
        unit: The guessed unit of the original, for the user to read.
        recording: Path or URL of the recording; empty for live sources.
        settings: Of the segmentation, as plain values; the pipeline adds them for sinks of events.
        run: The run of the program; the pipeline adds it for sinks of events.
        reference: Joints that are no part of the body: they come with frames, and are left out where the body counts.
        assumed: Whether the sender has not described the skeleton, so that it follows from the number of joints.
    """

    performer: str
    skeleton: Skeleton
    fps: float | None = None
    unit: str = "m"
    recording: str = ""
    settings: dict[str, Any] | None = None
    run: str | None = None
    assumed: bool = False
    reference: tuple[str, ...] = ()


class Departure(msgspec.Struct, frozen=True):
    """A performer has left: follows the last of its frames and ends its take.

    Args:
        performer: Name of the performer.
        reason: The reason of the `ended` event.
    """

    performer: str
    reason: str


class Occupant(msgspec.Struct, frozen=True):
    """The person whose frames follow under a performer's name, where the sender's ids are not the names.

    Args:
        performer: Name of the performer.
        id: The sender's.
        another: Whether it is another person than before, of whom nothing is known.
    """

    performer: str
    id: str
    another: bool = False


Item = Meta | Frames | Departure | Occupant | None  # of a source


class Source(Protocol):
    """Frames from a file, a socket or a sensor.

    A live source yields None when nothing came for about a tenth of a second, so that its reader notices a stall or a
    request to stop. `abilities.py` has the optional methods of a source.
    """

    name: str  # the URL or path, for messages
    live: bool  # whether frames arrive at their own pace

    def items(self) -> Iterator[Item]:
        """Yield metas, chunks of frames, arrivals and departures, until the source ends or is closed."""

    def close(self) -> None:
        """Release the socket, file or device; `items` ends soon after. May be called twice."""


class Recording(msgspec.Struct, frozen=True):
    """A recording on disk, opened by a reader of `mossar_adapters.files`.

    Args:
        path: Path of the file.
        skeleton: Joints in the order of the frames.
        fps: Nominal rate in Hz, None if the file only has times.
        chunks: Called for a fresh pass over the frames, from the first one.
        notes: Notes for the user, one line each (the unit that was guessed, rows skipped).
        frame_count: Number of frames if known without reading them all.
        performers: Names of the performers if there are several; they share the skeleton.
        up: The axis that points upwards, by the file.
        metres: One unit of the file, m.
        reference: Joints that are no part of the body, as in `Meta`.
    """

    path: str
    skeleton: Skeleton
    fps: float | None
    chunks: "Chunks"
    notes: tuple[str, ...] = ()
    frame_count: int | None = None
    performers: tuple[str, ...] = ("p1",)
    up: Up = "auto"
    metres: float = 1.0
    reference: tuple[str, ...] = ()


class Chunks(Protocol):
    """One pass over the frames of a recording."""

    def __call__(self) -> Iterator[Frames]:
        """Yield the frames in chunks of a few hundred."""


_FORMER = {"Left": "Departure", "Came": "Occupant"}  # names before 0.2


def __getattr__(name: str) -> Any:
    if name not in _FORMER:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    now = _FORMER[name]
    warnings.warn(f"{name} is called {now} now; the next release has no {name}", DeprecationWarning, 2)
    return globals()[now]
