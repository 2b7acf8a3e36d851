"""Recordings that are a sequence of meta and frame maps: JSON lines and `.msk`."""

from collections.abc import Callable, Iterator
from pathlib import Path

import msgspec
import numpy as np

from mossar_adapters.files.assembly import in_metres, sane_frames
from mossar_adapters.files.errors import FileError
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.files.rates import USUAL_FPS, assumed_rate, rate_of_times
from mossar_adapters.files.rows import CHUNK
from mossar_adapters.files.units import stated_scale
from mossar_adapters.joint_sets import by_count
from mossar_adapters.live import Counters
from mossar_adapters.maps.decoder import MapDecoder
from mossar_adapters.maps.frame_maps import FrameMap, MetaMap
from mossar_adapters.receiving.pose import Pose
from mossar_adapters.source import Meta, Recording
from mossar_stream import FrameError, Frames, Skeleton


class MapRecord(msgspec.Struct, frozen=True):
    """One record of the file.

    Args:
        place: Line or record number, for messages.
        map: Its content; None stands for a last record that was cut off.
    """

    place: int
    map: FrameMap | MetaMap | None


class Survey(msgspec.Struct):
    """The result of a first pass over the file.

    Args:
        metas: The first meta of each performer; one taken for granted for frames without.
        counts: Number of frames of each performer that fit its meta.
        misfits: Frames that came with another skeleton.
        first: Performer of the first frame.
        first_times: Times of the first frames of that one.
        cut: Whether the last record was cut off.
        now: Skeleton of each performer at this place of the file.
    """

    metas: dict[str, Meta]
    counts: dict[str, int]
    now: dict[str, Skeleton] = msgspec.field(default_factory=dict)
    misfits: int = 0
    first: str = ""
    first_times: list[float | None] = msgspec.field(default_factory=list)
    cut: bool = False


class Gathered(msgspec.Struct):
    """Frames of one performer that wait to become a chunk."""

    done: int = 0
    poses: list[Pose] = msgspec.field(default_factory=list)


def read_maps(path: Path, records: Callable[[], Iterator[MapRecord]], options: ReadOptions) -> Recording:
    """Return the recording of a sequence of maps.

    All performers share a skeleton: that of the selected performer, else of the first one that has frames. Frames of
    performers with another skeleton are left out, with a note.
    """
    found = _survey(path, records)
    seen = [name for name in found.metas if found.counts[name]]
    wanted = options.performer if options.performer in found.metas else seen[0]
    chosen = found.metas[wanted]
    performers = tuple(
        name for name, meta in found.metas.items() if meta.skeleton == chosen.skeleton and found.counts[name]
    )
    if not performers:
        raise FileError(path, "there is no frame in the file")
    fps, notes = _rate(chosen, found, options)
    left_out = found.misfits + sum(n for name, n in found.counts.items() if name not in performers)
    if left_out:
        notes.append(f"{left_out} frames with another skeleton are left out")
    if found.cut:
        notes.append("the file is cut off in its last record; everything before it is read")
    clock = None if options.fps is None and found.first_times[0] is not None else fps or USUAL_FPS

    def chunks() -> Iterator[Frames]:
        return _chunks(records, chosen.skeleton, performers, clock)

    count = sum(found.counts[name] for name in performers)
    recording = Recording(str(path), chosen.skeleton, fps, chunks, tuple(notes), count, performers)
    return in_metres(recording, stated_scale(options, 1.0))


def _survey(path: Path, records: Callable[[], Iterator[MapRecord]]) -> Survey:
    found, decoder = Survey({}, {}), _decoder()
    for record in records():
        if record.map is None:
            found.cut = True
            continue
        try:
            item = decoder.receive(record.map, 0.0)
            if isinstance(item, Pose):
                _survey_pose(found, item)
            else:
                found.counts.setdefault(item.performer, 0)
                found.metas.setdefault(item.performer, item)
                found.now[item.performer] = item.skeleton
        except FrameError as error:
            raise FileError(path, f"record {record.place}: {error}") from None
    if not found.metas or not any(found.counts.values()):
        raise FileError(path, "there is no whole frame in the file")
    return found


def _survey_pose(found: Survey, pose: Pose) -> None:
    name, joints = pose.performer, len(pose.positions)
    if name not in found.metas:
        # As in a stream: the skeleton of another performer with as many joints, if one was described.
        others = [meta for meta in found.metas.values() if len(meta.skeleton) == joints]
        unnamed = Meta(name, by_count(joints) or Skeleton(tuple(f"joint{i}" for i in range(joints)), root=-1))
        found.metas[name] = msgspec.structs.replace(others[-1], performer=name) if others else unnamed
        found.now[name] = found.metas[name].skeleton
        found.counts[name] = 0
    if joints != len(found.now[name]) or found.now[name] != found.metas[name].skeleton:
        found.misfits += 1
        return
    if (pose.time is None) != (pose.time is None if not found.first_times else found.first_times[0] is None):
        raise FrameError("some frames have a time t and others do not")
    found.counts[name] += 1
    found.first = found.first or name
    if len(found.first_times) < CHUNK and name == found.first:
        found.first_times.append(pose.time)


def _decoder() -> MapDecoder:
    """Return a decoder that leaves units to the end, as all readers of files do."""
    return MapDecoder(Counters(), ReadOptions())


def _rate(meta: Meta, found: Survey, options: ReadOptions) -> tuple[float | None, list[str]]:
    if options.fps is not None or meta.fps is not None:
        return options.fps or meta.fps, []
    times = [t for t in found.first_times if t is not None]
    if times:
        return rate_of_times(np.array(times)), []
    return USUAL_FPS, [assumed_rate("neither times nor fps are given")]


def _chunks(
    records: Callable[[], Iterator[MapRecord]],
    skeleton: Skeleton,
    performers: tuple[str, ...],
    clock: float | None,
) -> Iterator[Frames]:
    """Yield frames; times from the maps, or counted at `clock` Hz if that is given."""
    waiting = {name: Gathered() for name in performers}
    fits = dict.fromkeys(performers, True)
    decoder = _decoder()
    for record in records():
        item = None if record.map is None else decoder.receive(record.map, 0.0)
        if isinstance(item, Meta):
            fits[item.performer] = item.skeleton == skeleton
        if not isinstance(item, Pose):
            continue
        name = item.performer
        if name not in waiting or not fits[name] or len(item.positions) != len(skeleton):
            continue
        gathered = waiting[name]
        if gathered.poses and (gathered.poses[-1].confidence is None) != (item.confidence is None):
            yield _frames(name, gathered, clock)
        gathered.poses.append(item)
        if len(gathered.poses) == CHUNK:
            yield _frames(name, gathered, clock)
    for name, gathered in waiting.items():
        if gathered.poses:
            yield _frames(name, gathered, clock)


def _frames(name: str, gathered: Gathered, clock: float | None) -> Frames:
    poses, start = gathered.poses, gathered.done
    gathered.poses, gathered.done = [], start + len(poses)
    confidences = [pose.confidence for pose in poses if pose.confidence is not None]
    times = [
        pose.time if clock is None and pose.time is not None else (start + i) / (clock or USUAL_FPS)
        for i, pose in enumerate(poses)
    ]
    positions = np.stack([pose.positions for pose in poses])
    return sane_frames(positions, np.array(times), np.stack(confidences) if confidences else None, name)
