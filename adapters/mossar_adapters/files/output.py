"""Files that are written while a stream runs; a full disk is logged once, in one line.

A run that was cut short goes on in its files at the place that its snapshot names. A machine that lost its power may
have lost bytes that were written: then the file is cut behind its last whole record, never filled up, and this is
logged. To keep that rare, outputs are synchronised before the snapshot that refers to them.
"""

import contextlib
import errno
import logging
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import BinaryIO

from mossar_adapters.files.claim import Claim
from mossar_adapters.files.errors import FileError, UnwritableError
from mossar_stream import MossarError

_BLOCK = 1 << 16  # bytes searched at once for the end of a line
_NO_SYNC = {errno.EINVAL, errno.ENOTSUP, errno.EROFS}  # errors of pipes and devices

_log = logging.getLogger("mossar.output")


class OutputError(MossarError):
    """The output cannot be written any more."""


def end_of_lines(file: BinaryIO, size: int) -> int:
    """Return the bytes up to the end of the last line that is whole, of the first `size` bytes of a file."""
    at = size
    while at > 0:
        begin = max(0, at - _BLOCK)
        file.seek(begin)
        found = file.read(at - begin).rfind(b"\n")
        if found >= 0:
            return begin + found + 1
        at = begin
    return 0


class OutputFile:
    """A file that only grows.

    Args:
        path: Path of the file.
        replace: Whether to replace one that is there; one that is empty always is.
        position: Go on at this byte of one that is there.
        whole: Returns where the last whole record ends in so many bytes of a file.

    Raises:
        FileError: If it is there and may not be replaced, another run is writing it, or it cannot be written.
    """

    def __init__(
        self,
        path: Path | str,
        *,
        replace: bool,
        position: int | None = None,
        whole: Callable[[BinaryIO, int], int] = end_of_lines,
    ) -> None:
        self._path = path
        self._broken = False
        self._file: BinaryIO
        self._claim = Claim(path)
        try:
            if position is None:
                self._file = _opened(Path(path), replace=replace)
            else:
                self._file = _opened_again(Path(path), position, whole)
        except FileExistsError:
            self._claim.release()
            raise FileError(path, "there is a file already; --force replaces it") from None
        except (OSError, ValueError) as error:
            self._claim.release()
            reason = error.strerror if isinstance(error, OSError) and error.strerror else error
            raise UnwritableError(path, f"cannot be written: {reason}") from None

    def write(self, data: bytes) -> None:
        """Append bytes; nothing happens after an error.

        Raises:
            OutputError: If the disk is full or gone.
        """
        with self._file_errors():
            self._file.write(data)

    def flush(self) -> None:
        """Hand everything to the operating system.

        Raises:
            OutputError: If the disk is full or gone.
        """
        with self._file_errors():
            self._file.flush()

    def sync(self) -> None:
        """Have the operating system write everything to the disk.

        Raises:
            OutputError: If the disk is full or gone.
        """
        with self._file_errors():
            self._file.flush()
            try:
                os.fsync(self._file.fileno())
            except OSError as error:
                if error.errno not in _NO_SYNC:
                    raise

    def tell(self) -> int:
        """Return the bytes in the file."""
        return self._file.tell()

    def close(self) -> None:
        """Write the rest. May be called twice.

        Raises:
            OutputError: If that is impossible, and was not reported before.
        """
        try:
            with self._file_errors():
                self._file.close()
        finally:
            self._claim.release()

    @contextlib.contextmanager
    def _file_errors(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            if not self._broken:
                self._broken = True
                raise OutputError(f"{self._path}: cannot be written: {error.strerror or error}") from None


def _opened(path: Path, *, replace: bool) -> BinaryIO:
    """Open a file to be written from its beginning."""
    try:
        return path.open("wb" if replace else "xb")
    except FileExistsError:
        if path.is_file() and path.stat().st_size == 0:  # of a run that was killed before it wrote anything
            return path.open("wb")
        raise


def _opened_again(path: Path, position: int, whole: Callable[[BinaryIO, int], int]) -> BinaryIO:
    """Open a file to be written from a position on, or from its last whole record if it is shorter than that."""
    try:
        file = path.open("r+b")
    except FileNotFoundError:
        if position:
            _log.warning("%s: the file that the last run wrote is gone; a new one begins", path)
        return path.open("wb")
    size = file.seek(0, os.SEEK_END)
    if size < position:
        kept = whole(file, size)
        _log.warning(
            "%s: %d bytes of the last run are lost; the file continues after %d whole bytes",
            path,
            position - kept,
            kept,
        )
        position = kept
    file.seek(position)
    file.truncate()
    return file
