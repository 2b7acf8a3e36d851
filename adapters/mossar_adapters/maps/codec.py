"""Frame and meta maps as bytes: msgpack in `.msk` and ZeroMQ, JSON in lines and ZeroMQ."""

import msgspec
import numpy as np

from mossar_adapters.maps.frame_maps import FrameMap, MetaMap
from mossar_adapters.maps.json_nan import without_nan
from mossar_adapters.maps.states import StateMap
from mossar_stream import FrameError


class _Kind(msgspec.Struct):
    type: str = ""


_json_kind = msgspec.json.Decoder(_Kind)
_json_frame = msgspec.json.Decoder(FrameMap)
_json_meta = msgspec.json.Decoder(MetaMap)
_msgpack_kind = msgspec.msgpack.Decoder(_Kind)
_msgpack_frame = msgspec.msgpack.Decoder(FrameMap)
_msgpack_meta = msgspec.msgpack.Decoder(MetaMap)
_msgpack = msgspec.msgpack.Encoder()
_json = msgspec.json.Encoder()


def from_json(data: bytes | str) -> FrameMap | MetaMap | None:
    """Return the map in a JSON object, None if it is of another type; NaN, as Python writes it, is null.

    Raises:
        FrameError: If it is no JSON object or a field is of the wrong type; one line names it.
    """
    try:
        return _map_of_json(data)
    except (msgspec.DecodeError, RecursionError, UnicodeError) as error:
        mended = without_nan(data.encode("utf-8", "replace") if isinstance(data, str) else data)
        if mended is None:
            raise FrameError(str(error)) from None
    try:
        return _map_of_json(mended)
    except (msgspec.DecodeError, RecursionError, UnicodeError) as error:
        raise FrameError(str(error)) from None


def _map_of_json(data: bytes | str) -> FrameMap | MetaMap | None:
    kind = _json_kind.decode(data).type
    if kind == "frame":
        return _json_frame.decode(data)
    return _json_meta.decode(data) if kind == "meta" else None


def from_msgpack(data: bytes) -> FrameMap | MetaMap | None:
    """Return the map in msgpack bytes, None if it is of another type.

    Raises:
        FrameError: If it is damaged or a field is of the wrong type; one line names it.
    """
    try:
        kind = _msgpack_kind.decode(data).type
        if kind == "frame":
            return _msgpack_frame.decode(data)
        return _msgpack_meta.decode(data) if kind == "meta" else None
    except (msgspec.DecodeError, RecursionError, UnicodeError) as error:
        raise FrameError(str(error)) from None


def to_msgpack(found: FrameMap | MetaMap | StateMap) -> bytes:
    """Return a map as msgpack."""
    return _msgpack.encode(found)


def to_json(found: FrameMap | MetaMap | StateMap) -> bytes:
    """Return a map as JSON: positions as nested lists, null where missing."""
    if isinstance(found, FrameMap):
        found = msgspec.structs.replace(
            found,
            xyz=_listed(found.xyz, 3) if isinstance(found.xyz, bytes) else found.xyz,
            conf=_listed(found.conf, 1) if isinstance(found.conf, bytes) else found.conf,
        )
    return _json.encode(found)


def _listed(data: bytes, width: int) -> list[list[float | None] | None] | list[float | None]:
    """Return little-endian float32 bytes as lists; digits as few as float32 needs."""
    values = np.frombuffer(data, "<f4")
    texts = [None if np.isnan(v) else float(str(v)) for v in values]
    if width == 1:
        return texts
    rows = [texts[i : i + width] for i in range(0, len(texts), width)]
    return [None if None in row else row for row in rows]
