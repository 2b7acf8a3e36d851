"""A file that is written when frames come: a source that delivers nothing leaves no file, and replaces none."""

import os
from collections.abc import Callable
from pathlib import Path

from mossar_adapters.abilities import HasPosition, Syncs, offered
from mossar_adapters.address import Address
from mossar_adapters.files.claim import Claim
from mossar_adapters.files.errors import FileError, UnwritableError
from mossar_adapters.sink import FrameSink
from mossar_adapters.source import Meta
from mossar_stream import Frames


class DeferredSink:
    """Opens a file of frames with the first frames; implements `FrameSink`.

    Args:
        address: Path of the file.
        opened: Opens the sink that writes it.
        force: Whether to replace a file that is there.

    Raises:
        FileError: If there is a file and `force` is not given, or the path cannot be written.
    """

    def __init__(self, address: Address, opened: Callable[[], FrameSink], *, force: bool) -> None:
        self.name = address.url
        self._opened = opened
        self._sink: FrameSink | None = None
        self._metas: dict[str, Meta] = {}  # by performer, until there are frames
        _check(Path(address.path), force=force)

    def announce(self, meta: Meta) -> None:
        """Write a meta, or keep it for the first frames."""
        if self._sink is None:
            self._metas[meta.performer] = meta
        else:
            self._sink.announce(meta)

    def send_frames(self, frames: Frames) -> None:
        """Write frames.

        Raises:
            FileError: If the file cannot be opened now.
        """
        if self._sink is None:
            self._sink = self._opened()
            for meta in self._metas.values():
                self._sink.announce(meta)
        self._sink.send_frames(frames)

    def position(self) -> int | None:
        """Return the bytes in the file, 0 before there is one, None if the sink has no position."""
        if self._sink is None:
            return 0
        own = offered(self._sink, HasPosition)
        return None if own is None else own.position()

    def sync(self) -> None:
        """Have everything written to the disk, before a snapshot counts on it."""
        if (written := offered(self._sink, Syncs)) is not None:
            written.sync()

    def close(self) -> None:
        """Write the rest. May be called twice."""
        if self._sink is not None:
            self._sink.close()


def _check(path: Path, *, force: bool) -> None:
    """Raise early the errors that opening the file would raise late.

    Raises:
        FileError: If it cannot be written.
    """
    try:
        there = path.exists()
        if there and not force and not (path.is_file() and path.stat().st_size == 0):
            raise FileError(path, "there is a file already; --force replaces it")
        if path.is_dir():
            raise UnwritableError(path, "cannot be written: it is a folder")
        if not path.parent.is_dir():
            raise UnwritableError(path, "cannot be written: there is no such folder")
        if not os.access(path if there else path.parent, os.W_OK):
            raise UnwritableError(path, "cannot be written: permission denied")
    except OSError as error:
        raise UnwritableError(path, f"cannot be written: {error.strerror or error}") from None
    Claim(path).release()
