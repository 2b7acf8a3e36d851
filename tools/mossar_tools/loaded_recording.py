"""Loaded recordings: all frames of a recording, or of a built-in performance, in memory."""

from collections.abc import Callable

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.address import parse_url
from mossar_adapters.demo import Cut, DemoSource
from mossar_adapters.files.selection import selected
from mossar_adapters.source import Meta, Recording
from mossar_stream import Frames, Skeleton
from mossar_tools.console import LOGGER
from mossar_tools.errors import UsageError
from mossar_tools.opening import recording_of
from mossar_tools.options import Options

MAX_BYTES = 2 << 30  # of positions
DEMO_SECONDS = 30  # of motion, unless the URL says otherwise
_CHUNK_CUTS = 8  # more than lie in one chunk of a performance


class LoadedRecording(msgspec.Struct, frozen=True):
    """A recording in memory.

    Args:
        name: File name or URL.
        skeleton: J joints.
        fps: Nominal rate, Hz, if it is known.
        positions: (n, J, 3) float32, metres; NaN where a joint is missing or has no confidence.
        times: (n,) float64, s.
        cuts: True cuts of the built-in performer.
        performer: Its name.
    """

    name: str
    skeleton: Skeleton
    fps: float | None
    positions: NDArray[np.float32]
    times: NDArray[np.float64]
    cuts: tuple[Cut, ...] = ()
    performer: str = "p1"


Tell = Callable[[float | None], None]  # gets the share that is read, None where that is not known


def load_recording(options: Options, tell: Tell = lambda _: None) -> LoadedRecording:
    """Return the recording that `options.file` names.

    Args:
        options: Which file, and what of it.
        tell: Is told how reading goes.

    Raises:
        MossarError: If it cannot be read, or is too large to be held in memory.
    """
    scheme = parse_url(options.file).scheme
    if scheme not in {"demo", "file"}:
        raise UsageError(
            f"{options.file}: mossar segment takes a recording or demo:; mossar run takes streams"
        )
    cuts: dict[str, tuple[Cut, ...]] = {}
    recording = _performance(options, cuts) if scheme == "demo" else recording_of(options.file, options)
    performer = options.performer or recording.performers[0]
    if len(recording.performers) > 1 and options.performer is None:
        LOGGER.info(
            "%s: performer %s is taken; there are %s (--performer)",
            recording.path,
            performer,
            ", ".join(recording.performers),
        )
    count = recording.frame_count or 0
    if count * len(recording.skeleton) * 12 > MAX_BYTES:
        raise UsageError(f"{recording.path}: {count} frames are too many to hold in memory; use mossar run")
    loaded = _joined(recording, performer, tell)
    return msgspec.structs.replace(loaded, cuts=cuts.get(performer, ()))


def _performance(options: Options, cuts: dict[str, tuple[Cut, ...]]) -> Recording:
    """Return the built-in performance as a recording, and put its true cuts into `cuts`."""
    url = options.file
    if "seconds=" not in url and "moves=" not in url:
        url += f"{'&' if '?' in url else '?'}seconds={DEMO_SECONDS}"
    source = DemoSource.from_url(url, speed="max")
    metas: list[Meta] = []
    chunks: list[Frames] = []
    known: dict[str, dict[int, Cut]] = {}
    for item in source.items():
        if isinstance(item, Meta):
            metas.append(item)
        elif isinstance(item, Frames):
            chunks.append(item)
            # Of a long performance the source remembers the last cuts only.
            newest = source.cuts[item.performer][-_CHUNK_CUTS:]
            known.setdefault(item.performer, {}).update((cut.frame, cut) for cut in newest)
    cuts.update((performer, tuple(found.values())) for performer, found in known.items())
    names = tuple(meta.performer for meta in metas)
    whole = Recording(url, metas[0].skeleton, metas[0].fps, lambda: iter(chunks), performers=names)
    return selected(whole, options.reading())


def _joined(recording: Recording, performer: str, tell: Tell) -> LoadedRecording:
    positions = [np.zeros((0, len(recording.skeleton), 3), np.float32)]
    times = [np.zeros(0)]
    read = 0
    for frames in recording.chunks():
        read += len(frames)
        tell(read / recording.frame_count if recording.frame_count else None)
        if frames.performer == performer:
            positions.append(_certain(frames))
            times.append(frames.times)
    return LoadedRecording(
        recording.path,
        recording.skeleton,
        recording.fps,
        np.concatenate(positions),
        np.concatenate(times),
        performer=performer,
    )


def _certain(frames: Frames) -> NDArray[np.float32]:
    """Return positions with NaN where there is no confidence."""
    if frames.confidence is None:
        return frames.positions
    return np.where(frames.confidence[:, :, None] > 0, frames.positions, np.float32(np.nan))
