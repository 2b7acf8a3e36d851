"""`.msk`, our own recordings: magic and version, then length-prefixed msgpack meta and frame maps.

Layout::

    b"MSK1"                               magic, and 1 for the version
    uint32 little-endian length, map      a record: `mossar_adapters.maps.frame_maps` as msgpack
    ...

Records are only ever appended, so that a file whose writer died reads up to its last whole record.
"""

import struct
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import BinaryIO, Self

from mossar_adapters.files.errors import FileError
from mossar_adapters.files.map_records import MapRecord, read_maps
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.files.output import OutputError, OutputFile
from mossar_adapters.maps.codec import from_msgpack, to_msgpack
from mossar_adapters.maps.frame_maps import FrameMap, MetaMap, map_of_meta, maps_of_frames
from mossar_adapters.source import Meta, Recording
from mossar_stream import FrameError, Frames

MAGIC = b"MSK1"
MAX_RECORD = 1 << 20  # bytes; 1024 joints with confidence take 17 thousand
_LENGTH = struct.Struct("<I")


def read(path: Path, options: ReadOptions) -> Recording:
    """Read a recording; records of types unknown here are passed over."""
    return read_maps(path, lambda: _records(path), options)


def _records(path: Path) -> Iterator[MapRecord]:
    with path.open("rb") as file:
        if file.read(len(MAGIC)) != MAGIC:
            raise FileError(path, "this is no .msk recording of version 1")
        number = 0
        while prefix := file.read(_LENGTH.size):
            number += 1
            length = _LENGTH.unpack(prefix)[0] if len(prefix) == _LENGTH.size else 0
            if length > MAX_RECORD:
                raise FileError(path, f"record {number} is damaged: it has a length of {length} bytes")
            data = file.read(length)
            if len(prefix) < _LENGTH.size or len(data) < length or (length == 0 and _only_zeros(file)):
                yield MapRecord(number, None)
                return
            try:
                found = from_msgpack(data)
            except FrameError as error:
                if not data.endswith(b"\0") or not _only_zeros(file):
                    raise FileError(path, f"record {number} is damaged: {error}") from None
                yield MapRecord(number, None)
                return
            if found is not None:
                yield MapRecord(number, found)


def _only_zeros(file: BinaryIO) -> bool:
    """Return whether only zeros follow: a power cut leaves them in place of unwritten bytes."""
    while block := file.read(1 << 16):
        if block.strip(b"\0"):
            return False
    return True


def end_of_records(file: BinaryIO, size: int) -> int:
    """Return the bytes up to the end of the last record that is whole, of the first `size` bytes of a recording."""
    at = 0
    file.seek(0)
    if size < len(MAGIC) or file.read(len(MAGIC)) != MAGIC:
        return 0
    end = len(MAGIC)
    while end <= size:
        at = end
        file.seek(at)
        prefix = file.read(_LENGTH.size)
        length = _LENGTH.unpack(prefix)[0] if len(prefix) == _LENGTH.size else 0
        if not 0 < length <= MAX_RECORD:
            break
        end = at + _LENGTH.size + length
    return at


class MskWriter:
    """Writes a `.msk` recording.

    Every chunk is handed to the operating system at once, so that it survives a crash of the program.

    Args:
        path: Path of the file.
        force: Whether to replace a file that is there.
        position: Go on at this byte of a recording that is there.

    Raises:
        FileError: If there is a file and `force` is not given, or the path cannot be written.
        OutputError: If the disk is full.

    Example:
        >>> from tempfile import TemporaryDirectory
        >>> from mossar_stream import Skeleton
        >>> meta = Meta("p1", Skeleton(("hip", "hand"), (-1, 0)))
        >>> with TemporaryDirectory() as folder, MskWriter(f"{folder}/take.msk") as writer:
        ...     writer.write(meta)
    """

    def __init__(self, path: Path | str, *, force: bool = False, position: int | None = None) -> None:
        self._file = OutputFile(path, replace=force, position=position, whole=end_of_records)
        self._counts: dict[str, int] = {}  # frames written of each performer
        if self._file.tell() == 0:
            try:
                self._put(MAGIC)
            except OutputError:
                self._file.close()
                raise

    def write(self, item: Meta | Frames) -> None:
        """Append a meta or a chunk of frames.

        Raises:
            OutputError: If the disk is full or gone.
        """
        if isinstance(item, Meta):
            self._put(_record(map_of_meta(item)))
            return
        count = self._counts.get(item.performer, 0)
        self._put(b"".join(_record(found) for found in maps_of_frames(item, count)))
        self._counts[item.performer] = count + len(item)

    def position(self) -> int:
        """Return the bytes in the file."""
        return self._file.tell()

    def sync(self) -> None:
        """Have everything written to the disk.

        Raises:
            OutputError: If the disk is full or gone.
        """
        self._file.sync()

    def close(self) -> None:
        """Release the file; may be called twice."""
        self._file.close()

    def _put(self, data: bytes) -> None:
        self._file.write(data)
        self._file.flush()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def _record(found: MetaMap | FrameMap) -> bytes:
    data = to_msgpack(found)
    return _LENGTH.pack(len(data)) + data
