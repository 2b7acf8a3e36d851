"""Whole: all frames of a recording, or of a built-in performance, in memory."""

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.address import parse_url
from mossar_adapters.demo import Cut, DemoSource
from mossar_adapters.source import Meta
from mossar_stream.frames import Frames
from mossar_stream.skeleton import Skeleton
from mossar_tools.console import LOGGER
from mossar_tools.errors import UsageError
from mossar_tools.opening import recording_of
from mossar_tools.options import Options

MAX_BYTES = 2 << 30  # of positions
DEMO_SECONDS = 30  # of motion, unless the URL says otherwise
_CHUNK_CUTS = 8  # more than lie in one chunk of a performance


class Whole(msgspec.Struct, frozen=True):
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


def read_whole(options: Options) -> Whole:
    """Return the recording that `options.file` names.

    Raises:
        MossarError: If it cannot be read, or is too large to be held in memory.
    """
    if parse_url(options.file).scheme == "demo":
        return _performance(options.file)
    if parse_url(options.file).scheme != "file":
        raise UsageError(
            f"{options.file}: mossar segment takes a recording or demo:; mossar run takes streams"
        )
    recording = recording_of(options.file, options)
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
    chunks = [frames for frames in recording.chunks() if frames.performer == performer]
    joined = _joined(recording.path, recording.skeleton, recording.fps, chunks)
    return msgspec.structs.replace(joined, performer=performer)


def _performance(url: str) -> Whole:
    if "seconds=" not in url and "moves=" not in url:
        url += f"{'&' if '?' in url else '?'}seconds={DEMO_SECONDS}"
    source = DemoSource.from_url(url, speed="max")
    items, cuts = [], dict[str, dict[int, Cut]]()
    for item in source.items():
        items.append(item)
        if isinstance(item, Frames):  # of a long performance the source remembers the last cuts only
            known = cuts.setdefault(item.performer, {})
            known.update((cut.frame, cut) for cut in source.cuts[item.performer][-_CHUNK_CUTS:])
    first = next(item for item in items if isinstance(item, Meta))
    chunks = [item for item in items if isinstance(item, Frames) and item.performer == first.performer]
    whole = _joined(url, first.skeleton, first.fps, chunks)
    return msgspec.structs.replace(whole, cuts=tuple(cuts.get(first.performer, {}).values()))


def _joined(name: str, skeleton: Skeleton, fps: float | None, chunks: list[Frames]) -> Whole:
    empty = np.zeros((0, len(skeleton), 3), np.float32)
    positions = np.concatenate([empty, *(_certain(chunk) for chunk in chunks)])
    times = np.concatenate([np.zeros(0), *(chunk.times for chunk in chunks)])
    return Whole(name, skeleton, fps, positions, times)


def _certain(frames: Frames) -> NDArray[np.float32]:
    """Return positions with NaN where there is no confidence."""
    if frames.confidence is None:
        return frames.positions
    return np.where(frames.confidence[:, :, None] > 0, frames.positions, np.float32(np.nan))
