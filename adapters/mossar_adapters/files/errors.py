"""Errors of recordings."""

from pathlib import Path

from mossar_adapters.address import readable
from mossar_stream import MossarError


class FileError(MossarError):
    """A recording cannot be read; the message names file, line if there is one, and problem.

    Args:
        path: The recording.
        problem: The problem and the remedy, in one line.
        line: Number of the line, from 1, in formats made of lines.
    """

    def __init__(self, path: Path | str, problem: str, line: int | None = None) -> None:
        name = readable(str(path))
        where = f"{name}, line {line}" if line else name
        super().__init__(f"{where}: {problem}".translate(_ONE_LINE))


class UnwritableError(FileError):
    """A file cannot be opened for writing: the folder is missing or read-only, or the disk is."""


def shown(text: str, limit: int = 40) -> str:
    """Return a piece of a file as it may stand in a message: quoted, escaped and short."""
    return repr(text if len(text) <= limit else text[: limit - 1] + "…")


_ONE_LINE = dict.fromkeys(range(32), " ")
