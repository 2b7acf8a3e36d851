"""Snapshot: the state that an interrupted run needs to continue without a loss.

Magic, version, SHA-256 of the rest, then a msgpack map: damaged bytes are refused before they are decoded.
Written to a file beside and put in place in one step, so that there is always a whole one. The file beside is made
anew each time: a link in its place, as an attacker may put into a shared folder, is not followed.
"""

import contextlib
import hashlib
import os
from pathlib import Path

import msgspec

from mossar_adapters.regular import check_regular
from mossar_stream import SnapshotError

VERSION = 4
MAX_BYTES = 1 << 30  # a performer with limbs takes half a megabyte, and there may be 1024


class Position(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Position in a source.

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
        pool: Rest of the pool's state: settings that control changed, takes of replaced performers.
        sinks: Bytes written, for sinks that can go on there.
        run: Name of the run, which goes on under it.
        moves: Digest of the moves that were recognised; the examples are in a file of their own.
        people: Memory of the slots of each source; empty for those without slots.
    """

    settings: bytes
    complete: bool
    sources: tuple[Position, ...] = ()
    performers: dict[str, bytes] = {}
    pool: bytes = b""
    sinks: dict[str, int | None] = {}
    run: str = ""
    moves: bytes = b""
    people: tuple[bytes, ...] = ()


_MAGIC = b"MSNAP"
_HEAD = len(_MAGIC) + 1 + hashlib.sha256().digest_size
_decoder = msgspec.msgpack.Decoder(Snapshot)


def write_snapshot(path: Path, snapshot: Snapshot) -> None:
    """Write a snapshot in place of an older one.

    Raises:
        SnapshotError: If it cannot be written, or is too large to be read; the older one stays then.
    """
    content = sealed(msgspec.msgpack.encode(snapshot))
    if len(content) > MAX_BYTES:
        raise SnapshotError(
            f"{path}: the snapshot has {len(content) >> 20} MiB, more than the {MAX_BYTES >> 20} MiB that can be read; "
            "it is not written"
        )
    beside = path.with_name(path.name + ".new")
    try:
        beside.unlink(missing_ok=True)
        with beside.open("xb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        beside.replace(path)
        _sync_folder(path.parent)
    except OSError as error:
        # On a full disk, its part takes room that other files need.
        with contextlib.suppress(OSError):
            beside.unlink(missing_ok=True)
        raise SnapshotError(f"{path}: the snapshot cannot be written: {error.strerror or error}") from None


def _sync_folder(path: Path) -> None:
    """Have the name of a file written to the disk, too, where folders can be opened for that."""
    if os.name == "posix":
        folder = os.open(path, os.O_RDONLY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)


def read_snapshot(path: Path) -> Snapshot | None:
    """Return the snapshot in a file, None if there is no file.

    Raises:
        SnapshotError: If the file cannot be read or holds something else.
    """
    try:
        check_regular(path)
        with path.open("rb") as file:
            if os.fstat(file.fileno()).st_size > MAX_BYTES:
                raise SnapshotError(f"{path}: larger than {MAX_BYTES >> 20} MiB; this is no snapshot")
            data = file.read()
    except FileNotFoundError:
        return None
    except OSError as error:
        raise SnapshotError(f"{path}: the snapshot cannot be read: {error.strerror or error}") from None
    try:
        return _decoder.decode(_opened(data))
    except SnapshotError as error:
        raise SnapshotError(f"{path}: {error}; delete it to start anew") from None
    except (msgspec.DecodeError, RecursionError, UnicodeError) as error:
        raise SnapshotError(f"{path}: the snapshot is damaged ({error}); delete it to start anew") from None


def sealed(body: bytes) -> bytes:
    """Return a body with the head that belongs before it."""
    return _MAGIC + bytes([VERSION]) + hashlib.sha256(body).digest() + body


def _opened(data: bytes) -> bytes:
    """Return the body of a snapshot."""
    if not data.startswith(_MAGIC):
        raise SnapshotError("this is no snapshot")
    version, digest, body = data[len(_MAGIC) : len(_MAGIC) + 1], data[len(_MAGIC) + 1 : _HEAD], data[_HEAD:]
    if version and version[0] != VERSION:
        raise SnapshotError(f"the snapshot is of version {version[0]}, this program reads version {VERSION}")
    if hashlib.sha256(body).digest() != digest:
        raise SnapshotError("the snapshot is damaged or truncated: its checksum does not fit")
    return body
