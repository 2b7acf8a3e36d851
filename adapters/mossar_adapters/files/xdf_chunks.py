"""The chunks of an XDF file, checked before their counts are used."""

import re
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import IO

import msgspec

from mossar_adapters.files.errors import FileError

MAGIC = b"XDF:"
CUT, FILE_HEADER, STREAM_HEADER, SAMPLES, CLOCK_OFFSET = 0, 1, 2, 3, 4  # tags; the first is our own
_OF_STREAM = {STREAM_HEADER, SAMPLES, CLOCK_OFFSET, 6}
_ITEM_SIZES = {"int8": 1, "int16": 2, "int32": 4, "int64": 8, "float32": 4, "double64": 8}
_MAX_XML = 1 << 20  # bytes
_MAX_STREAM = 512 << 20  # bytes of the one stream that is read as a whole


class Stream(msgspec.Struct, frozen=True):
    """The header of a stream.

    Args:
        number: Its identifier.
        name: Its name.
        type: Its kind, `MoCap` for motion capture.
        sample_size: Bytes of one sample without its time.
    """

    number: int
    name: str
    type: str
    sample_size: int


class Chunk(msgspec.Struct, frozen=True):
    """One chunk.

    Args:
        tag: Its kind.
        stream: Identifier of its stream, -1 if it belongs to none.
        data: All of it, length included; empty where it was skipped.
        content: Where the content begins in `data`, after tag and stream.
    """

    tag: int
    stream: int
    data: bytes
    content: int


def chunks_of(path: Path, only: int | None = None) -> Iterator[Chunk]:
    """Yield the whole chunks; where the file is cut off, one with the tag `CUT` comes last.

    Args:
        path: The file.
        only: Identifier of the only stream whose samples are read; None skips all samples.

    Raises:
        FileError: If it is no XDF file.
    """
    size = path.stat().st_size
    with path.open("rb") as file:
        if file.read(len(MAGIC)) != MAGIC:
            raise FileError(path, "this is no XDF file")
        while True:
            start = file.tell()
            length = _varlen(file)
            begin = file.tell()
            if start == size:
                return
            tag = CUT
            if length is not None and length >= 2 and begin + length <= size:
                (tag,) = struct.unpack("<H", file.read(2))
            if length is None or tag == CUT or (tag in _OF_STREAM and length < 6):
                yield Chunk(CUT, -1, b"", 0)
                return
            stream = struct.unpack("<I", file.read(4))[0] if tag in _OF_STREAM else -1
            wanted = tag in {FILE_HEADER, STREAM_HEADER} or stream == only
            if wanted and length > (_MAX_XML if tag != SAMPLES else _MAX_STREAM):
                raise FileError(path, f"a chunk of {length} bytes is damaged or too large")
            file.seek(start if wanted else begin + length)
            content = begin - start + (6 if tag in _OF_STREAM else 2)
            yield Chunk(tag, stream, file.read(begin - start + length) if wanted else b"", content)


def streams_of(path: Path) -> tuple[list[Stream], bool]:
    """Return the streams of a file, and whether it is cut off."""
    streams, cut = [], False
    for chunk in chunks_of(path):
        cut = chunk.tag == CUT
        if chunk.tag == STREAM_HEADER:
            streams.append(_stream(path, chunk))
    return streams, cut


def _stream(path: Path, chunk: Chunk) -> Stream:
    xml = chunk.data[chunk.content :].decode("utf-8", "replace")
    if "<!" in xml:
        raise FileError(path, "the header of a stream holds declarations, which no recorder writes")
    channels = _field(xml, "channel_count")
    count = int(channels) if channels.isdecimal() and len(channels) < 6 else 0
    item = _ITEM_SIZES.get(_field(xml, "channel_format"), 0)
    return Stream(chunk.stream, _field(xml, "name"), _field(xml, "type"), count * item)


def _field(xml: str, name: str) -> str:
    found = re.search(rf"<{name}>([^<]*)</{name}>", xml)
    return found[1].strip() if found else ""


def checked_stream(path: Path, stream: Stream) -> bytes:
    """Return an XDF file of one stream only, every sample count of which is true.

    Raises:
        FileError: If a count is not.
    """
    parts, total = [MAGIC], 0
    for chunk in chunks_of(path, only=stream.number):
        total += len(chunk.data)
        if total > _MAX_STREAM:
            raise FileError(path, f"the stream has more than {_MAX_STREAM >> 20} MiB")
        if chunk.tag == SAMPLES and chunk.stream == stream.number:
            _check_samples(path, stream, chunk)
        if chunk.tag == FILE_HEADER or chunk.stream == stream.number:
            parts.append(chunk.data)
    return b"".join(parts)


def _check_samples(path: Path, stream: Stream, chunk: Chunk) -> None:
    """Walk over the samples, each a flag, a time if the flag is set, and the values."""
    data, at = chunk.data, chunk.content
    width = data[at] if at < len(data) else 0
    count = int.from_bytes(data[at + 1 : at + 1 + width], "little")
    at += 1 + width
    for _ in range(min(count, len(data))):
        at += 1 + (8 if at < len(data) and data[at] else 0) + stream.sample_size
        if at > len(data):
            raise FileError(path, f"the count of {count} samples does not fit a chunk of {len(data)} bytes")


def _varlen(file: IO[bytes]) -> int | None:
    """Return a length, None at the end of the file or if there is none."""
    width = file.read(1)
    if not width or width[0] not in {1, 4, 8}:
        return None
    data = file.read(width[0])
    return int.from_bytes(data, "little") if len(data) == width[0] else None
