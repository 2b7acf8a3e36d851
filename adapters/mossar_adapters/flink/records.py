"""Records of a topic or a file; one holds a few frames of one performer.

A record is one map, msgpack or JSON: `{v, type: "frames", performer, t: [n seconds], shape: [n, J, 3], xyz, conf?,
first_frame?}` where `xyz` and `conf` are little-endian float32 bytes (base64 in JSON). Before the first record of a
performer, and now and then for receivers that forgot it, comes its meta map. Meta and frame maps are those of ZeroMQ and
JSON lines, so messages of other programs can be put into a topic unchanged.
"""

import math
from collections.abc import Iterator

import msgspec
import numpy as np
from msgspec import UNSET, UnsetType
from numpy.typing import NDArray

from mossar_adapters.files.assembly import sane_frames
from mossar_adapters.maps.frame_maps import (
    FrameMap,
    MetaMap,
    confidence_of_map,
    map_of_meta,
    meta_of_map,
    positions_of_map,
)
from mossar_adapters.receiving.names import distinct_name
from mossar_adapters.source import Meta
from mossar_stream import MAX_JOINTS, FrameError, Frames

FRAMES_A_RECORD = 10  # 167 ms at 60 Hz
MAX_BYTES = 1 << 20  # of a record: the default limit of brokers
NOBODY = ""  # key of records that name no performer
_JSON_BEGINS = b"{ \t\r\n"


class FramesMap(msgspec.Struct):
    """A few frames of one performer; fields as the module describes them."""

    t: list[float]
    shape: tuple[int, int, int]
    xyz: bytes
    performer: str = "p1"
    conf: bytes | UnsetType | None = UNSET
    first_frame: int | None = None
    v: int = 1
    type: str = "frames"


class _Kind(msgspec.Struct):
    type: str = ""
    performer: str = "p1"


_TYPES: dict[str, type[FramesMap | FrameMap | MetaMap]] = {
    "frames": FramesMap,
    "frame": FrameMap,
    "meta": MetaMap,
}
_json_kind = msgspec.json.Decoder(_Kind)
_msgpack_kind = msgspec.msgpack.Decoder(_Kind)
_json = {name: msgspec.json.Decoder(kind) for name, kind in _TYPES.items()}
_msgpack = {name: msgspec.msgpack.Decoder(kind) for name, kind in _TYPES.items()}


def performer_of(record: bytes | str) -> str:
    """Return the performer of a record: the key of the stream. `NOBODY` if it cannot be read."""
    try:
        return distinct_name(_kind(record).performer)
    except (msgspec.DecodeError, RecursionError, UnicodeError):
        return NOBODY


def read_record(record: bytes | str) -> Meta | Frames:
    """Return the content of a record.

    Raises:
        FrameError: If it is too long, damaged, of another type, or impossible; one line has the reason.
    """
    if len(record) > MAX_BYTES:
        raise FrameError(f"a record of {len(record)} bytes; {MAX_BYTES} can be read")
    try:
        kind = _kind(record).type
        if kind not in _TYPES:
            raise FrameError(f"a record of type {kind[:20]!r}; there are {', '.join(_TYPES)}")
        found = (_json if _is_json(record) else _msgpack)[kind].decode(_bytes(record))
    except (msgspec.DecodeError, RecursionError, UnicodeError) as error:
        raise FrameError(str(error)) from None
    match found:
        case MetaMap():
            return meta_of_map(found)
        case FramesMap():
            return _frames(found)
        case FrameMap():
            return _frame(found)


def records_of(item: Meta | Frames, size: int = FRAMES_A_RECORD, *, text: bool = False) -> Iterator[bytes]:
    """Yield the records of a meta or of a chunk of frames, from a source's `items`, ready for a topic.

    Args:
        item: Meta or frames.
        size: Frames in a record.
        text: Whether to write JSON, for files of lines.

    Example:
        >>> from mossar_adapters.demo import DemoSource
        >>> source = DemoSource.from_url("demo:?seconds=1", speed="max")
        >>> len([record for item in source.items() for record in records_of(item)])
        31
    """
    encode = msgspec.json.encode if text else msgspec.msgpack.encode
    if isinstance(item, Meta):
        yield encode(map_of_meta(item))
        return
    for at in range(0, len(item), size):
        part = slice(at, at + size)
        positions = item.positions[part]
        yield encode(
            FramesMap(
                item.times[part].tolist(),
                positions.shape,
                positions.astype("<f4").tobytes(),
                item.performer,
                UNSET if item.confidence is None else item.confidence[part].astype("<f4").tobytes(),
                None if item.first_frame is None else item.first_frame + at,
            )
        )


def _is_json(record: bytes | str) -> bool:
    return isinstance(record, str) or record[:1] in _JSON_BEGINS


def _bytes(record: bytes | str) -> bytes:
    return record.encode() if isinstance(record, str) else record


def _kind(record: bytes | str) -> _Kind:
    return _json_kind.decode(record) if _is_json(record) else _msgpack_kind.decode(_bytes(record))


def _frames(found: FramesMap) -> Frames:
    count, joints, axes = found.shape
    if axes != 3 or not 1 <= joints <= MAX_JOINTS or count != len(found.t):
        raise FrameError(f"{len(found.t)} times with a shape of {list(found.shape)}")
    positions = _floats(found.xyz, (count, joints, 3), "xyz")
    confidence = None
    if found.conf is not None and found.conf is not UNSET:
        confidence = _floats(found.conf, (count, joints), "conf")
    if found.first_frame is not None and not 0 <= found.first_frame < 1 << 62:
        raise FrameError(f"first_frame is {found.first_frame}")
    name = distinct_name(found.performer)
    return sane_frames(positions, _times(found.t), confidence, name, found.first_frame)


def _frame(found: FrameMap) -> Frames:
    if found.t is None:
        raise FrameError("a frame without a time t cannot be segmented again after a failure")
    positions = positions_of_map(found)
    confidence = confidence_of_map(found, len(positions))
    return sane_frames(
        positions[None],
        _times([found.t]),
        None if confidence is None else confidence[None],
        distinct_name(found.performer),
    )


def _floats(data: bytes, shape: tuple[int, ...], name: str) -> NDArray[np.float32]:
    if len(data) != 4 * math.prod(shape):
        raise FrameError(f"{name} has {len(data)} bytes, which is not {list(shape)} of float32")
    return np.frombuffer(data, "<f4").reshape(shape).astype(np.float32)


def _times(times: list[float]) -> NDArray[np.float64]:
    if not all(abs(time) < 1e15 for time in times):
        raise FrameError("t is no time")
    return np.array(times, np.float64)
