"""Files that are written while a stream runs; a full disk is told once, in one line."""

import contextlib
from collections.abc import Iterator
from pathlib import Path

from mossar_adapters.files.errors import FileError, UnwritableError
from mossar_stream.errors import MossarError


class OutputError(MossarError):
    """What is written cannot be written any more."""


class OutputFile:
    """A file that only grows.

    Args:
        path: Where it lies.
        replace: Whether to replace one that is there.
        position: Go on at this byte of one that is there.

    Raises:
        FileError: If it is there and may not be replaced, or cannot be written.
    """

    def __init__(self, path: Path | str, *, replace: bool, position: int | None = None) -> None:
        self._path = path
        self._broken = False
        try:
            self._file = Path(path).open("r+b" if position is not None else "wb" if replace else "xb")  # noqa: SIM115 - closed by `close`
            if position is not None:
                self._file.seek(position)
                self._file.truncate()
        except FileExistsError:
            raise FileError(path, "there is a file already; --force replaces it") from None
        except (OSError, ValueError) as error:
            reason = error.strerror if isinstance(error, OSError) and error.strerror else error
            raise UnwritableError(path, f"cannot be written: {reason}") from None

    def write(self, data: bytes) -> None:
        """Append bytes; nothing happens after an error.

        Raises:
            OutputError: If the disk is full or gone.
        """
        with self._telling():
            self._file.write(data)

    def flush(self) -> None:
        """Hand everything to the operating system.

        Raises:
            OutputError: If the disk is full or gone.
        """
        with self._telling():
            self._file.flush()

    def tell(self) -> int:
        """Return the bytes in the file."""
        return self._file.tell()

    def close(self) -> None:
        """Write what is left. May be called twice.

        Raises:
            OutputError: If that is impossible, and was not told before.
        """
        with self._telling():
            self._file.close()

    @contextlib.contextmanager
    def _telling(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            if not self._broken:
                self._broken = True
                raise OutputError(f"{self._path}: cannot be written: {error.strerror or error}") from None
