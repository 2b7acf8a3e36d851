"""JSON lines: one meta or frame map per line (`mossar_adapters.frame_maps`)."""

from collections.abc import Iterator
from pathlib import Path

import msgspec

from mossar_adapters.files.errors import FileError
from mossar_adapters.files.map_records import MapRecord, read_maps
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.files.text import ends_in_mid_line, numbered_lines
from mossar_adapters.frame_maps import FrameMap, MetaMap
from mossar_adapters.source import Recording


class _Kind(msgspec.Struct):
    type: str = ""


_kind = msgspec.json.Decoder(_Kind)
_frame = msgspec.json.Decoder(FrameMap)
_meta = msgspec.json.Decoder(MetaMap)


def read(path: Path, options: ReadOptions) -> Recording:
    """Read a file of JSON lines; lines of other types, such as events, are passed over."""
    return read_maps(path, lambda: _records(path), options)


def decode_line(line: str | bytes) -> FrameMap | MetaMap | None:
    """Return the map in a line, None if it is of another type.

    Raises:
        ValueError: If it is no JSON object or a field is of the wrong type; one line says which.
    """
    try:
        kind = _kind.decode(line).type
        if kind == "frame":
            return _frame.decode(line)
        return _meta.decode(line) if kind == "meta" else None
    except (msgspec.DecodeError, RecursionError, UnicodeError) as error:
        raise ValueError(str(error)) from None


def _records(path: Path) -> Iterator[MapRecord]:
    broken: FileError | None = None
    for line, text in numbered_lines(path):
        if broken is not None:
            raise broken
        if not text or text.isspace():
            continue
        try:
            found = decode_line(text)
        except ValueError as error:
            broken = FileError(path, f"{error}", line)
            continue
        if found is not None:
            yield MapRecord(line, found)
    if broken is not None:
        if not ends_in_mid_line(path):
            raise broken
        yield MapRecord(0, None)
