"""JSON lines: one meta or frame map per line (`mossar_adapters.maps.frame_maps`)."""

from collections.abc import Iterator
from pathlib import Path

from mossar_adapters.files.errors import FileError
from mossar_adapters.files.map_records import MapRecord, read_maps
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.files.text import ends_in_mid_line, numbered_lines
from mossar_adapters.maps.codec import from_json
from mossar_adapters.source import Recording
from mossar_stream import FrameError


def read(path: Path, options: ReadOptions) -> Recording:
    """Read a file of JSON lines; lines of other types, such as events, are passed over."""
    return read_maps(path, lambda: _records(path), options)


def _records(path: Path) -> Iterator[MapRecord]:
    broken: FileError | None = None
    for line, text in numbered_lines(path):
        if broken is not None:
            raise broken
        if not text or text.isspace():
            continue
        try:
            found = from_json(text)
        except FrameError as error:
            broken = FileError(path, f"{error}", line)
            continue
        if found is not None:
            yield MapRecord(line, found)
    if broken is not None:
        if not ends_in_mid_line(path):
            raise broken
        yield MapRecord(0, None)
