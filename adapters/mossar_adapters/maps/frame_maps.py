"""Frames and metas as maps: the same fields in `.msk` files, JSON lines and messages.

A frame map is `{v, type: "frame", performer, seq, t, shape: [J, 3], xyz, conf?}` where `xyz` is little-endian
float32 bytes in msgpack and nested lists in JSON (null where missing); a meta map comes before the first
frame of a performer and when its skeleton changes.
"""

from typing import Any

import msgspec
import numpy as np
from msgspec import UNSET, UnsetType
from numpy.typing import NDArray

import mossar_stream
from mossar_adapters.joint_sets import printable_names
from mossar_adapters.receiving.names import distinct_name
from mossar_adapters.source import Meta
from mossar_stream import MAX_JOINTS, FrameError, Frames, Skeleton, narrow

VERSION = 1


class FrameMap(msgspec.Struct):
    """One frame of one performer; fields as the interface names them."""

    performer: str = "p1"
    seq: int | None = None
    t: float | None = None
    shape: tuple[int, ...] | None = None
    xyz: bytes | list[list[float | None] | None] = b""
    conf: bytes | list[float | None] | UnsetType | None = UNSET
    v: int = VERSION
    type: str = "frame"


class MetaMap(msgspec.Struct):
    """The description of a performer; fields as the interface names them.

    Args:
        names: Of the joints.
        performer: Name of the performer.
        parents: For each joint the index of its parent, -1 for the root.
        root: Index of the joint that is the centre of the body; -1 takes the centroid.
        fps: Nominal rate, Hz; left out if unknown.
        unit: Of positions in frames: metres.
        settings: Of the segmenter; left out where frames are sent.
        run: The run of the program that emits the events; left out where frames are sent.
        version: Of the program that sends this.
        v: Version of this layout.
        type: Always `meta`.
    """

    names: tuple[str, ...]
    performer: str = "p1"
    parents: tuple[int, ...] = ()
    root: int = 0
    fps: float | UnsetType | None = UNSET
    unit: str = "m"
    settings: dict[str, Any] | UnsetType = UNSET
    run: str | UnsetType = UNSET
    version: str | UnsetType = UNSET
    v: int = VERSION
    type: str = "meta"


def meta_of_map(found: MetaMap) -> Meta:
    """Return a meta.

    Raises:
        FrameError: If the skeleton or the rate is impossible.
    """
    fps = found.fps or None  # UNSET is false
    if fps is not None and not 0.001 <= fps <= 1e5:
        raise FrameError(f"a rate of {fps} Hz is impossible")
    if found.unit != "m":
        raise FrameError(f"frames are in metres, not in {found.unit[:20]!r}")
    skeleton = printable_names(Skeleton(found.names, found.parents, found.root))
    return Meta(distinct_name(found.performer), skeleton, fps)


def map_of_meta(meta: Meta) -> MetaMap:
    """Return a meta as a map, as it goes with frames."""
    skeleton = meta.skeleton
    return MetaMap(
        skeleton.names,
        meta.performer,
        skeleton.parents,
        skeleton.root,
        UNSET if meta.fps is None else meta.fps,
        version=mossar_stream.__version__,
    )


def map_with_run(meta: Meta) -> MetaMap:
    """Return a meta as a map, as it goes with events: with the settings and the run, where they are known."""
    found = map_of_meta(meta)
    found.settings = UNSET if meta.settings is None else meta.settings
    found.run = UNSET if meta.run is None else meta.run
    return found


def positions_of_map(found: FrameMap) -> NDArray[Any]:
    """Return the positions of one frame.

    Returns:
        (J, 3), metres, NaN where missing.

    Raises:
        FrameError: If they do not have that shape.
    """
    positions: NDArray[Any]
    if isinstance(found.xyz, bytes):
        if len(found.xyz) % 12 or not 12 <= len(found.xyz) <= 12 * MAX_JOINTS:
            raise FrameError(
                f"xyz has {len(found.xyz)} bytes, which is not 12 for each of 1 to {MAX_JOINTS} joints"
            )
        positions = np.frombuffer(found.xyz, "<f4").reshape(-1, 3).astype(np.float32, copy=False)
    else:
        positions = _listed(found.xyz)
    if found.shape is not None and found.shape != positions.shape:
        raise FrameError(f"shape says {list(found.shape)} but xyz has {list(positions.shape)}")
    return positions


def confidence_of_map(found: FrameMap, joints: int) -> NDArray[np.float32] | None:
    """Return the confidence of one frame, (J,) float32, or None.

    Raises:
        FrameError: If there is not one number per joint.
    """
    if found.conf is None or found.conf is UNSET:
        return None
    if isinstance(found.conf, bytes):
        values = np.frombuffer(found.conf, "<f4") if len(found.conf) == 4 * joints else np.empty(0)
    else:
        values = np.array([0.0 if c is None else c for c in found.conf])
    if values.shape != (joints,):
        raise FrameError(f"conf is not one number for each of {joints} joints")
    return np.clip(np.nan_to_num(values), 0, 1).astype(np.float32)


def maps_of_frames(frames: Frames, first_seq: int) -> list[FrameMap]:
    """Return one map per frame, with bytes as in msgpack.

    Args:
        frames: n frames.
        first_seq: `seq` of the first one.
    """
    shape = frames.positions.shape[1:]
    return [
        FrameMap(
            performer=frames.performer,
            seq=first_seq + i,
            t=float(frames.times[i]),
            shape=shape,
            xyz=frames.positions[i].astype("<f4").tobytes(),
            conf=UNSET if frames.confidence is None else frames.confidence[i].astype("<f4").tobytes(),
        )
        for i in range(len(frames))
    ]


def _listed(xyz: list[list[float | None] | None]) -> NDArray[Any]:
    if not 1 <= len(xyz) <= MAX_JOINTS:
        raise FrameError(f"xyz has {len(xyz)} joints; 1 to {MAX_JOINTS} can be used")
    rows: list[Any] = [[None] * 3 if row is None else row for row in xyz]
    if any(len(row) != 3 for row in rows):
        raise FrameError("xyz is not a list of [x, y, z]")
    with np.errstate(over="ignore"):
        return narrow(np.array([[np.nan if c is None else c for c in row] for row in rows], np.float64))
