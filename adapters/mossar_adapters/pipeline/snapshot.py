"""Snapshot: what a run that was cut short needs in order to go on as if it had not been.

Written to a file beside and put in place in one step, so that there is always a whole one.
"""

import os
from pathlib import Path

import msgspec

from mossar_stream.errors import SnapshotError

VERSION = 1
MAX_BYTES = 1 << 30


class Position(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """How far a source was read.

    Args:
        name: The source, as the user wrote it.
        frames: Frames used of each performer, under the names that the source gives them.
        names: The names that the pipeline gave these performers.
    """

    name: str
    frames: dict[str, int]
    names: dict[str, str]


class Snapshot(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The state of a pipeline.

    Args:
        settings: Settings of the run, as JSON.
        complete: Whether all sources ended by themselves: then there is nothing to go on with.
        sources: How far each source was read.
        performers: Snapshot of each performer's segmenter.
        sinks: Bytes written, for sinks that can go on there.
    """

    settings: bytes
    complete: bool
    sources: tuple[Position, ...] = ()
    performers: dict[str, bytes] = {}
    sinks: dict[str, int | None] = {}
    v: int = VERSION


_MAGIC = b"MSNAP"
_decoder = msgspec.msgpack.Decoder(Snapshot)


def write_snapshot(path: Path, snapshot: Snapshot) -> None:
    """Write a snapshot in place of an older one.

    Raises:
        SnapshotError: If it cannot be written.
    """
    beside = path.with_name(path.name + ".new")
    try:
        with beside.open("wb") as file:
            file.write(_MAGIC + msgspec.msgpack.encode(snapshot))
            file.flush()
            os.fsync(file.fileno())
        beside.replace(path)
    except OSError as error:
        raise SnapshotError(f"{path}: the snapshot cannot be written: {error.strerror or error}") from None


def read_snapshot(path: Path) -> Snapshot | None:
    """Return the snapshot in a file, None if there is no file.

    Raises:
        SnapshotError: If the file cannot be read or holds something else.
    """
    try:
        with path.open("rb") as file:
            data = file.read(MAX_BYTES)
    except FileNotFoundError:
        return None
    except OSError as error:
        raise SnapshotError(f"{path}: the snapshot cannot be read: {error.strerror or error}") from None
    if not data.startswith(_MAGIC):
        raise SnapshotError(f"{path}: this is no snapshot; name another file, or delete it to start anew")
    try:
        found = _decoder.decode(data[len(_MAGIC) :])
    except (msgspec.DecodeError, RecursionError, UnicodeError) as error:
        raise SnapshotError(f"{path}: the snapshot is damaged ({error}); delete it to start anew") from None
    if found.v != VERSION:
        raise SnapshotError(f"{path}: the snapshot is of version {found.v}; delete it to start anew")
    return found
